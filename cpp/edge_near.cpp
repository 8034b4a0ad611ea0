#include "edge_near.hpp"

#include "edge_images.hpp"

namespace feeler_oracle {
namespace {

Interval64 average(const Interval64& a, const Interval64& b) { return Interval64(0.5) * (a + b); }
Interval64 square(const Interval64& a) {
    const double least = a.lo > 0 ? a.lo : (a.hi < 0 ? -a.hi : 0.0);
    const double most = std::max(-a.lo, a.hi);
    return {std::max(0.0, next_down(least * least)), next_up(most * most)};
}

double approximate(const Interval64& x) { return 0.5 * (x.lo + x.hi); }
double approximate(const Interval& x) { return x.lo.near(); }

template <class T>
using Vector = std::array<T, 3>;

template <class T>
T dot(const Vector<T>& a, const Vector<T>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class T>
Vector<T> cross(const Vector<T>& a, const Vector<T>& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// |x|, from above.
double norm_up(const Vector<Interval64>& x) {
    const Interval64 s = square(x[0]) + square(x[1]) + square(x[2]);
    return next_up(std::sqrt(s.hi));
}
Interval64 outer(const Interval64& x) { return x; }
Interval64 outer(const Interval& x) { return x.outer(); }

template <class T>
struct Node {
    std::vector<Vector<T>> d;
    std::vector<T> w;
    int depth;
};

// Deep enough for a radius of 2^-200 of the size.
constexpr int kDeepest = 260;
constexpr int kDeepest64 = 56;
constexpr int kNodes = 6000;
constexpr int kNodes64 = 2000;
// Parts smaller than this part of the radius are not halved any more.
constexpr double kFine = 1.0 / 256;

template <class T>
class Search {
 public:
    Search(const NearTarget& target, const Piece& piece, const T& inner, const T& outer_radius)
        : target_(target), inner_(inner), outer_(outer_radius) {
        for (int k = 0; k < 3; ++k) along_[k] = T(target.direction[k]);
        root_.depth = 0;
        const auto& net = net_of(piece);
        for (std::size_t i = 0; i < net[3].size(); ++i) {
            Vector<T> x;
            for (int k = 0; k < 3; ++k) x[k] = net[k][i] - origin(k) * net[3][i];
            root_.d.push_back(x);
            root_.w.push_back(net[3][i]);
        }
        const Vector<T> length{along_[0], along_[1], along_[2]};
        length2_ = dot(length, length);
    }

    Near run(std::vector<NearPart>* parts, int most_nodes, int deepest) {
        Near result = Near::No;
        std::vector<Node<T>> stack{root_};
        int nodes = 0;
        while (!stack.empty()) {
            Node<T> node = std::move(stack.back());
            stack.pop_back();
            if (farther(node)) continue;
            const std::size_t n = node.w.size();
            const bool at_end = within(node, 0) || within(node, n - 1);
            if (at_end && !parts) return Near::Yes;
            bool settled = ++nodes > most_nodes || node.depth == deepest || n == 1 || fine(node);
            if (at_end && !settled) {
                settled = true;
                for (std::size_t i = 1; i + 1 < n; ++i) settled &= within(node, i);
            }
            if (settled) {
                const Near near = at_end ? Near::Yes : Near::Unknown;
                if (parts) parts->push_back({parameters(node), near});
                if (result != Near::Yes) result = near;
                continue;
            }
            Node<T> left = node;
            for (std::size_t m = 0; m < n; ++m) {
                left.d[m] = node.d[0];
                left.w[m] = node.w[0];
                for (std::size_t i = 0; i + 1 < n - m; ++i) {
                    for (int k = 0; k < 3; ++k)
                        node.d[i][k] = average(node.d[i][k], node.d[i + 1][k]);
                    node.w[i] = average(node.w[i], node.w[i + 1]);
                }
            }
            left.depth = ++node.depth;
            stack.push_back(std::move(node));
            stack.push_back(std::move(left));
        }
        return result;
    }

 private:
    static const auto& net_of(const Piece& piece) {
        if constexpr (std::is_same_v<T, Interval64>)
            return piece.net64;
        else
            return piece.net;
    }
    T origin(int k) const {
        if constexpr (std::is_same_v<T, Interval64>)
            return target_.origin[k].outer();
        else
            return target_.origin[k];
    }

    // The sum of x(D_i) / W_i over a few i, in doubles and of length about 1; 0 if there is none.
    template <class F>
    Vector<double> direction(const Node<T>& node, F x) const {
        const std::size_t n = node.w.size();
        Vector<double> v{};
        for (const std::size_t i : {std::size_t(0), n / 2, n - 1}) {
            const double w = approximate(node.w[i]);
            const Vector<T> of = x(node.d[i]);
            for (int k = 0; k < 3; ++k) v[k] += approximate(of[k]) / w;
        }
        const double largest = std::max({std::fabs(v[0]), std::fabs(v[1]), std::fabs(v[2])});
        if (!(largest > 0) || !std::isfinite(largest)) return {};
        double norm = 0;
        for (double& y : v) {
            y /= largest;
            norm += y * y;
        }
        for (double& y : v) y /= std::sqrt(norm);
        return v;
    }

    bool farther(const Node<T>& node) const {
        bool across = target_.kind == NearTarget::Line;
        if (target_.kind == NearTarget::Ray) {
            for (const auto& d : node.d) across |= !(dot(d, along_).hi < zero_.lo);
        }
        // n = d x w is perpendicular to d, whatever w; it points towards the part for w about D x
        // d, which is formed in T: D may be nearly parallel to d.
        const Vector<double> v =
            across ? direction(node, [&](const Vector<T>& d) { return cross(d, along_); })
                   : direction(node, [](const Vector<T>& d) { return d; });
        if (v == Vector<double>{}) return false;
        Vector<T> n{T(v[0]), T(v[1]), T(v[2])};
        if (across) n = cross(along_, n);
        const T reach = outer_ * T(norm_up({outer(n[0]), outer(n[1]), outer(n[2])}));
        for (std::size_t i = 0; i < node.w.size(); ++i)
            if (!(zero_.hi < (dot(n, node.d[i]) - reach * node.w[i]).lo)) return false;
        return true;
    }

    // Whether control point i is within the inner radius.
    bool within(const Node<T>& node, std::size_t i) const {
        const T r2 = square(inner_) * square(node.w[i]);
        if (target_.kind == NearTarget::Point) {
            const T d2 = square(node.d[i][0]) + square(node.d[i][1]) + square(node.d[i][2]);
            return d2.hi <= r2.lo;
        }
        const Vector<T> c = cross(node.d[i], along_);
        const T d2 = square(c[0]) + square(c[1]) + square(c[2]);
        return d2.hi <= (r2 * length2_).lo;
    }

    bool fine(const Node<T>& node) const {
        const double r = outer(outer_).hi * kFine;
        double most = 0;
        const double w0 = approximate(node.w[0]);
        for (std::size_t i = 1; i < node.w.size(); ++i)
            for (int k = 0; k < 3; ++k)
                most = std::max(most, std::fabs(approximate(node.d[i][k]) / approximate(node.w[i]) -
                                                approximate(node.d[0][k]) / w0));
        return most < r;
    }

    Interval parameters(const Node<T>& node) const {
        if constexpr (std::is_same_v<T, Interval64>) {
            return {};
        } else {
            if (target_.kind == NearTarget::Point) return {};
            Interval t;
            for (std::size_t i = 0; i < node.w.size(); ++i) {
                const Interval x = divide_positive(dot(node.d[i], along_), node.w[i] * length2_);
                t = i == 0 ? x : hull(t, x);
            }
            return t;
        }
    }

    const NearTarget& target_;
    T inner_, outer_, length2_;
    T zero_ = T(0.0);
    Vector<T> along_;
    Node<T> root_;
};

}  // namespace

bool clear_in_doubles(const NearTarget& target, const Piece& piece, double radius) {
    const Interval64 r(next_up(radius + slack_of(piece)));
    Search<Interval64> search(target, piece, Interval64(0.0), r);
    return search.run(nullptr, kNodes64, kDeepest64) == Near::No;
}

Near near_piece(const NearTarget& target, const Piece& piece, const Interval& radius,
                std::vector<NearPart>* parts) {
    if (clear_in_doubles(target, piece, radius.hi.up())) return Near::No;
    const Interval slack(slack_of(piece));
    Interval inner = Interval(radius.lo) - slack;
    // A negative inner radius holds nothing; a point of the net may then be claimed by no test.
    const bool none = inner.lo.sign() < 0;
    if (none) inner = Interval(0.0);
    const Interval outer = Interval(radius.hi) + slack;
    Search<Interval> search(target, piece, inner, outer);
    const std::size_t before = parts ? parts->size() : 0;
    Near near = search.run(parts, kNodes, kDeepest);
    if (none) {
        if (near == Near::Yes) near = Near::Unknown;
        if (parts)
            for (std::size_t i = before; i < parts->size(); ++i)
                if ((*parts)[i].near == Near::Yes) (*parts)[i].near = Near::Unknown;
    }
    return near;
}

double box_distance(const std::array<double, 3>& point, const std::array<double, 6>& box) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double x =
            std::max({0.0, next_down(box[2 * k] - point[k]), next_down(point[k] - box[2 * k + 1])});
        sum = next_down(sum + next_down(x * x));
    }
    return sum > 0 ? next_down(std::sqrt(sum)) : 0.0;
}

namespace {

template <class T>
bool misses(const NearTarget& target, const std::array<T, 3>& origin,
            const std::array<double, 6>& box, double radius) {
    const T zero(0.0);
    Vector<T> d, b;
    for (int k = 0; k < 3; ++k) {
        d[k] = T(target.direction[k]);
        const double lo = radius > 0 ? next_down(box[2 * k] - radius) : box[2 * k];
        const double hi = radius > 0 ? next_up(box[2 * k + 1] + radius) : box[2 * k + 1];
        b[k] = T(T(lo).lo, T(hi).hi) - origin[k];
    }
    // A line through the box has a point x = s d in it: then x x d = 0, and for a ray each x_k has
    // the sign of d_k.
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const T c = b[i] * d[j] - b[j] * d[i];
        if (zero.hi < c.lo || c.hi < zero.lo) return true;
    }
    if (target.kind == NearTarget::Ray)
        for (int k = 0; k < 3; ++k) {
            if (target.direction[k] >= 0 && b[k].hi < zero.lo) return true;
            if (target.direction[k] <= 0 && zero.hi < b[k].lo) return true;
        }
    return false;
}

}  // namespace

bool line_misses(const NearTarget& target, const std::array<double, 6>& box, double radius) {
    const std::array<Interval64, 3> origin{target.origin[0].outer(), target.origin[1].outer(),
                                           target.origin[2].outer()};
    return misses<Interval64>(target, origin, box, radius);
}

bool line_misses_exactly(const NearTarget& target, const std::array<double, 6>& box) {
    return line_misses(target, box, 0) || misses<Interval>(target, target.origin, box, 0);
}

}  // namespace feeler_oracle
