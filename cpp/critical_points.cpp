#include "critical_points.hpp"

#include <CGAL/Algebraic_kernel_d_2.h>

#include <cmath>
#include <numeric>
#include <stdexcept>

#include "exact.hpp"

namespace feeler_oracle {
namespace {

using Kernel = CGAL::Algebraic_kernel_d_2<Z>;
using Polynomial1 = Kernel::Polynomial_1;
using Polynomial2 = Kernel::Polynomial_2;

// How finely zeros are enclosed.
constexpr int kRootBits = 150;

// Sum of c[i][j] u^i v^j, exactly.
struct Power2 {
    std::vector<std::vector<Q>> c;

    Power2 derivative(bool by_u) const {
        Power2 r;
        for (std::size_t i = by_u ? 1 : 0; i < c.size(); ++i) {
            std::vector<Q> row;
            for (std::size_t j = by_u ? 0 : 1; j < c[i].size(); ++j)
                row.push_back(Q(int(by_u ? i : j)) * c[i][j]);
            if (row.empty()) row.emplace_back(0);
            r.c.push_back(row);
        }
        if (r.c.empty()) r.c = {{Q(0)}};
        return r;
    }
    template <class T, class Convert>
    T value(const T& u, const T& v, Convert convert) const {
        T sum = convert(Q(0));
        for (std::size_t i = c.size(); i-- > 0;) {
            T row = convert(Q(0));
            for (std::size_t j = c[i].size(); j-- > 0;) row = row * v + convert(c[i][j]);
            sum = sum * u + row;
        }
        return sum;
    }
    Q at(const Q& u, const Q& v) const {
        return value<Q>(u, v, [](const Q& x) { return x; });
    }
    Interval over(const Interval& u, const Interval& v) const {
        return value<Interval>(u, v, [](const Q& x) { return Interval(x.mpq()); });
    }
    bool is_zero() const {
        for (const auto& row : c)
            for (const Q& x : row)
                if (sign(x) != 0) return false;
        return true;
    }
};

// Coefficients in the power basis of those in the Bernstein basis.
std::vector<Q> to_power(std::vector<Q> b) {
    std::vector<Q> c;
    Q binomial(1);
    const int n = int(b.size()) - 1;
    for (int k = 0; k <= n; ++k) {
        c.push_back(binomial * b[0]);
        for (std::size_t i = 0; i + 1 < b.size(); ++i) b[i] = b[i + 1] - b[i];
        b.pop_back();
        binomial = binomial * Q(n - k) / Q(k + 1);
    }
    return c;
}

Power2 coordinate(int p, int q, const std::vector<double>& net, int k, double minus) {
    // Along v, then along u.
    std::vector<std::vector<Q>> rows;
    for (int i = 0; i <= p; ++i) {
        std::vector<Q> row;
        for (int j = 0; j <= q; ++j)
            row.push_back(Q(net[std::size_t(3 * (i * (q + 1) + j) + k)]) - Q(minus));
        rows.push_back(to_power(row));
    }
    Power2 r;
    r.c.assign(std::size_t(p) + 1, std::vector<Q>(std::size_t(q) + 1, Q(0)));
    for (std::size_t j = 0; j <= std::size_t(q); ++j) {
        std::vector<Q> column;
        for (const auto& row : rows) column.push_back(row[j]);
        column = to_power(column);
        for (std::size_t i = 0; i < column.size(); ++i) r.c[i][j] = column[i];
    }
    return r;
}

// An integer multiple, positive, of rational numbers.
std::vector<Z> integers(const std::vector<Q>& values) {
    Z denominator(1);
    for (const Q& x : values) {
        const Z d = x.denominator();
        denominator = CGAL::integral_division(denominator * d, CGAL::gcd(denominator, d));
    }
    std::vector<Z> r;
    for (const Q& x : values)
        r.push_back(x.numerator() * CGAL::integral_division(denominator, x.denominator()));
    return r;
}

// In CGAL's form: the inner variable is u.
Polynomial2 to_cgal(const Power2& f) {
    std::vector<Q> flat;
    for (const auto& row : f.c) flat.insert(flat.end(), row.begin(), row.end());
    const std::vector<Z> z = integers(flat);
    const std::size_t rows = f.c.size(), columns = f.c[0].size();
    std::vector<Polynomial1> by_v;
    for (std::size_t j = 0; j < columns; ++j) {
        std::vector<Z> in_u;
        for (std::size_t i = 0; i < rows; ++i) in_u.push_back(z[i * columns + j]);
        by_v.emplace_back(in_u.begin(), in_u.end());
    }
    return CGAL::canonicalize(Polynomial2(by_v.begin(), by_v.end()));
}

enum class Where { Inside, Outside, Unknown };

Where in_unit(const std::pair<Q, Q>& x) {
    if (x.second < Q(0) || x.first > Q(1)) return Where::Outside;
    return x.first > Q(0) && x.second < Q(1) ? Where::Inside : Where::Unknown;
}

Interval between(const std::pair<Q, Q>& x) {
    return {Interval(x.first.mpq()).lo, Interval(x.second.mpq()).hi};
}

Q middle(const std::pair<Q, Q>& x) { return (x.first + x.second) / Q(2); }

class Search {
 public:
    Search(int p, int q, const std::vector<double>& net, const std::array<double, 3>& c) : c_(c) {
        f_.c.assign(2 * std::size_t(p) + 1, std::vector<Q>(2 * std::size_t(q) + 1, Q(0)));
        for (int k = 0; k < 3; ++k) {
            x_[k] = coordinate(p, q, net, k, c[k]);
            const auto& x = x_[k].c;
            for (std::size_t i = 0; i < x.size(); ++i)
                for (std::size_t j = 0; j < x[i].size(); ++j)
                    for (std::size_t m = 0; m < x.size(); ++m)
                        for (std::size_t n = 0; n < x[m].size(); ++n)
                            f_.c[i + m][j + n] += x[i][j] * x[m][n];
        }
        fu_ = f_.derivative(true);
        fv_ = f_.derivative(false);
        fuu_ = fu_.derivative(true);
        fuv_ = fu_.derivative(false);
        fvv_ = fv_.derivative(false);
    }

    CriticalPoints run() {
        out_.all = true;
        inside();
        for (bool along_u : {false, true})
            for (int end : {0, 1}) side(along_u, end);
        for (int u : {0, 1})
            for (int v : {0, 1}) corner(u, v);
        return std::move(out_);
    }

 private:
    void inside() {
        if (fu_.is_zero() || fv_.is_zero()) {
            out_.all = false;
            return;
        }
        const Polynomial2 a = to_cgal(fu_), b = to_cgal(fv_);
        if (CGAL::total_degree(a) == 0 || CGAL::total_degree(b) == 0) return;
        if (CGAL::total_degree(CGAL::gcd(a, b)) > 0) {
            out_.all = false;
            return;
        }
        const Kernel kernel;
        std::vector<std::pair<Kernel::Algebraic_real_2, int>> zeros;
        kernel.solve_2_object()(a, b, std::back_inserter(zeros));
        for (const auto& zero : zeros) {
            const auto u = kernel.approximate_absolute_x_2_object()(zero.first, kRootBits);
            const Where where_u = in_unit(u);
            if (where_u == Where::Outside) continue;
            const auto v = kernel.approximate_absolute_y_2_object()(zero.first, kRootBits);
            const Where where_v = in_unit(v);
            if (where_v == Where::Outside) continue;
            // On the border it is among those of the sides, if it is exactly there.
            if (where_u == Where::Unknown || where_v == Where::Unknown) {
                out_.all = false;
                continue;
            }
            const Interval bu = between(u), bv = between(v);
            const Interval uu = fuu_.over(bu, bv), vv = fvv_.over(bu, bv), uv = fuv_.over(bu, bv);
            const Interval det = uu * vv - square(uv);
            Extremum kind = Extremum::Unknown;
            if (det.lo.sign() > 0)
                kind = uu.lo.sign() > 0   ? Extremum::Minimum
                       : uu.hi.sign() < 0 ? Extremum::None
                                          : kind;
            else if (det.hi.sign() < 0)
                kind = Extremum::None;
            add(u, v, kind, true);
        }
    }

    // The side where v (`along_u`) or u is `end`.
    void side(bool along_u, int end) {
        // F there as a polynomial of the other.
        std::vector<Q> f;
        if (along_u) {
            for (const auto& row : f_.c)
                f.push_back(end == 0 ? row[0] : std::accumulate(row.begin(), row.end(), Q(0)));
        } else {
            f = f_.c[0];
            for (std::size_t i = 1; end == 1 && i < f_.c.size(); ++i)
                for (std::size_t j = 0; j < f.size(); ++j) f[j] += f_.c[i][j];
        }
        std::vector<Q> slope;
        for (std::size_t k = 1; k < f.size(); ++k) slope.push_back(Q(int(k)) * f[k]);
        while (!slope.empty() && sign(slope.back()) == 0) slope.pop_back();
        if (slope.empty()) {
            out_.all = false;
            return;
        }
        if (slope.size() == 1) return;
        const std::vector<Z> z = integers(slope);
        const CGAL::Algebraic_kernel_d_1<Z> kernel;
        std::vector<CGAL::Algebraic_kernel_d_1<Z>::Algebraic_real_1> zeros;
        const auto slope_z = CGAL::make_square_free(Polynomial1(z.begin(), z.end()));
        kernel.solve_1_object()(slope_z, true, std::back_inserter(zeros));
        const std::pair<Q, Q> fixed{Q(end), Q(end)};
        for (const auto& zero : zeros) {
            const auto t = kernel.approximate_absolute_1_object()(zero, kRootBits);
            if (in_unit(t) != Where::Inside) continue;  // a corner
            const auto &u = along_u ? t : fixed, &v = along_u ? fixed : t;
            const Interval bu = between(u), bv = between(v);
            const Interval bend = (along_u ? fuu_ : fvv_).over(bu, bv);
            Interval inwards = (along_u ? fv_ : fu_).over(bu, bv);
            if (end == 1) inwards = -inwards;
            Extremum kind = Extremum::Unknown;
            if (bend.lo.sign() > 0 && inwards.lo.sign() > 0) kind = Extremum::Minimum;
            if (bend.hi.sign() < 0 || inwards.hi.sign() < 0) kind = Extremum::None;
            add(u, v, kind, false);
        }
    }

    void corner(int u, int v) {
        const int a = (u == 0 ? 1 : -1) * sign(fu_.at(Q(u), Q(v)));
        const int b = (v == 0 ? 1 : -1) * sign(fv_.at(Q(u), Q(v)));
        const Extremum kind = a > 0 && b > 0   ? Extremum::Minimum
                              : a < 0 || b < 0 ? Extremum::None
                                               : Extremum::Unknown;
        add({Q(u), Q(u)}, {Q(v), Q(v)}, kind, false);
    }

    void add(const std::pair<Q, Q>& u, const std::pair<Q, Q>& v, Extremum kind, bool inner) {
        const Interval bu = between(u), bv = between(v);
        const Q mu = middle(u), mv = middle(v);
        Interval f = Interval(f_.at(mu, mv).mpq()) + fu_.over(bu, bv) * (bu - Interval(mu.mpq())) +
                     fv_.over(bu, bv) * (bv - Interval(mv.mpq()));
        if (f.lo.sign() < 0) f.lo = Real(0.0);
        mpfr_sqrt(f.lo.get(), f.lo.get(), MPFR_RNDD);
        mpfr_sqrt(f.hi.get(), f.hi.get(), MPFR_RNDU);
        CriticalPoint point{f, {}, kind, inner};
        for (int k = 0; k < 3; ++k) point.at[k] = (x_[k].over(bu, bv) + Interval(c_[k])).outer();
        out_.points.push_back(point);
    }

    std::array<double, 3> c_;
    std::array<Power2, 3> x_;  // S - c
    Power2 f_, fu_, fv_, fuu_, fuv_, fvv_;
    CriticalPoints out_;
};

}  // namespace

CriticalPoints critical_points(int p, int q, const std::vector<double>& net,
                               const std::array<double, 3>& c) {
    if (p < 1 || q < 1 || p > 3 || q > 3 || net.size() != std::size_t(3 * (p + 1) * (q + 1)))
        throw std::invalid_argument("no patch of degrees 1 to 3");
    for (double x : net)
        if (!std::isfinite(x)) throw std::invalid_argument("a number that is not finite");
    for (double x : c)
        if (!std::isfinite(x)) throw std::invalid_argument("a number that is not finite");
    return Search(p, q, net, c).run();
}

}  // namespace feeler_oracle
