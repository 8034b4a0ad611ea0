#include "root_candidates.hpp"

// Not Eigen's LGPL parts.
#define EIGEN_MPL2_ONLY
#if __has_include(<Eigen/Eigenvalues>)
#include <Eigen/Eigenvalues>
#else
#include <eigen3/Eigen/Eigenvalues>
#endif

#include <algorithm>
#include <cmath>

namespace feeler_oracle {
namespace {

double de_casteljau(std::vector<double> b, double t) {
    for (std::size_t n = b.size(); n > 1; --n)
        for (std::size_t i = 0; i + 1 < n; ++i) b[i] += t * (b[i + 1] - b[i]);
    return b[0];
}

// Coefficients in T_k(2t - 1), by the discrete cosine transform.
Eigen::VectorXd chebyshev(const std::vector<double>& bernstein) {
    const int n = int(bernstein.size());
    const double step = std::acos(-1.0) / n;
    Eigen::VectorXd c = Eigen::VectorXd::Zero(n);
    for (int i = 0; i < n; ++i) {
        const double angle = step * (i + 0.5);
        const double value = de_casteljau(bernstein, 0.5 + 0.5 * std::cos(angle));
        for (int k = 0; k < n; ++k) c[k] += (k == 0 ? 1.0 : 2.0) / n * value * std::cos(k * angle);
    }
    return c;
}

}  // namespace

std::vector<double> root_candidates(const std::vector<double>& bernstein) {
    for (double x : bernstein)
        if (!std::isfinite(x)) return {};
    if (bernstein.size() < 2) return {};
    const Eigen::VectorXd c = chebyshev(bernstein);
    const double noise = c.lpNorm<Eigen::Infinity>() * 0x1p-52;
    Eigen::Index m = c.size() - 1;
    while (m > 0 && !(std::fabs(c[m]) > noise)) --m;
    if (m == 0) return {};
    Eigen::MatrixXd colleague = Eigen::MatrixXd::Zero(m, m);
    for (Eigen::Index k = 0; k < m; ++k) {
        // x T_0 = T_1, x T_k = (T_(k-1) + T_(k+1)) / 2.
        if (k > 0) colleague(k, k - 1) = 0.5;
        const double up = k == 0 ? 1.0 : 0.5;
        if (k + 1 < m)
            colleague(k, k + 1) = up;
        else
            colleague.row(k) -= up / c[m] * c.head(m).transpose();
    }
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(colleague, false);
    if (solver.info() != Eigen::Success) return {};
    // Those of multiple roots stray, off the real line too.
    constexpr double kStray = 0.0625;
    std::vector<double> roots;
    for (Eigen::Index k = 0; k < m; ++k) {
        const auto x = 0.5 * (solver.eigenvalues()[k] + 1.0);
        if (std::fabs(x.imag()) <= kStray && x.real() >= -kStray && x.real() <= 1 + kStray)
            roots.push_back(std::min(1.0, std::max(0.0, x.real())));
    }
    std::sort(roots.begin(), roots.end());
    roots.erase(std::unique(roots.begin(), roots.end()), roots.end());
    return roots;
}

}  // namespace feeler_oracle
