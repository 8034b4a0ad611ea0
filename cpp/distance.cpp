#include "distance.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "distance_bounds.hpp"
#include "distance_foot.hpp"
#include "distance_region.hpp"

namespace feeler_oracle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// ---- what work costs, in boxes of a bicubic patch

double coefficients(Degrees d) { return double(d.p + 1) * (d.q + 1); }

// Bounding and halving a box.
double box_work(Degrees d) {
    constexpr double kBicubic = 49 * (6 + 6 + 4);
    return (coefficients(d) * (d.p + d.q + 4) + 50) / kBicubic;
}

// Making a net of the objective: products of all pairs of coefficients.
double net_work(const Objective& o, const Piece& s) {
    const double n = (s.p + 1.0) * (s.q + 1.0);
    constexpr double kBicubic = 49 * (6 + 6 + 4);
    return (o.linear ? 4 * n : 2 * n * n) / kBicubic;
}

// A decision of a region in intervals.
constexpr double kRegionWork = 2;

// A box in the queue of the first phase; `net` is made when it first comes up. Without a piece: a
// face that is not opened.
struct Box64 {
    const Piece* piece;
    int face;
    DyadicBox at;
    Net64 net;
    double lo;
    bool inside;  // the region is known to hold the whole box
};

struct BoxMp {
    const Piece* piece;
    DyadicBox at;
    NetMp net;
    Real lo;
    bool inside;
};

class Search {
 public:
    Search(const Pieces& model, Objective o, DistanceBudget budget)
        : model_(model), o_(o), budget_(budget) {}

    DistanceAnswer run() {
        first_phase();
        if (best64_ == kInfinity && finals64_.empty()) {
            answer_.lo = answer_.hi = Real(kInfinity);
            answer_.status = DistanceStatus::IntervalOnly;
            return answer_;
        }
        second_phase();
        return answer_;
    }

    // The largest slack of the pieces that were looked at.
    double slack() const { return slack_; }

 private:
    PieceInRegion region(const Piece& s) const { return {s, model_.face(s.face)}; }

    // ---- phase 1: doubles

    // `border`: the point is known to be on the border of the domain.
    void lower_best64(double value, const Piece& s, bool border = false) {
        if (value < best64_) {
            best64_ = value;
            answer_.face = s.face;
            best_kind_ = border ? PieceKind::Joint : s.kind;
        }
    }

    // Whether a point of a box, x and y of which are at its ends (-1, 1) or between (0), is on the
    // border of the domain.
    bool on_border(const Piece& s, const DyadicBox& b, int x, int y) const {
        if (s.kind != PieceKind::Patch) return false;
        const auto& domain = model_.face(s.face).region->domain();
        const auto at = [&](int k, int end, int level, std::uint64_t index) {
            if (end == 0) return false;
            // One more than the last index: 2^level, where that is small enough.
            if (end < 0 ? index != 0 : level > kDeepest || index + 1 != std::uint64_t(1) << level)
                return false;
            const size_t side = 2 * k + (end > 0 ? 1 : 0);
            return s.uv[side] == domain[side];
        };
        return at(0, x, b.lu, b.iu) || at(1, y, b.lv, b.iv);
    }
    static int end_of(const Real& z) {
        return z.sign() <= 0 ? -1 : mpfr_cmp_ui(z.get(), 1) >= 0 ? 1 : 0;
    }

    void corners64(const Box64& b, Degrees d) {
        const Piece& s = *b.piece;
        if (!s.attained || !(b.inside || !s.regional)) return;
        for (int i : {0, d.p})
            for (int j : {0, d.q}) {
                const double value = value_above(b.net, d.index(i, j));
                if (value < best64_)
                    lower_best64(value, s, on_border(s, b.at, i == 0 ? -1 : 1, j == 0 ? -1 : 1));
            }
    }

    using Item64 = std::unique_ptr<Box64>;
    struct Later64 {
        bool operator()(const Item64& a, const Item64& b) const { return a->lo > b->lo; }
    };

    void push64(Item64 b) {
        if (b->lo > best64_) return;
        queue64_.push_back(std::move(b));
        std::push_heap(queue64_.begin(), queue64_.end(), Later64());
    }

    Item64 pop64() {
        std::pop_heap(queue64_.begin(), queue64_.end(), Later64());
        Item64 b = std::move(queue64_.back());
        queue64_.pop_back();
        return b;
    }

    void push_piece(const Piece& s) {
        push64(std::make_unique<Box64>(
            Box64{&s, s.face, {}, {}, box_bounds(o_, s.box).lo, !s.regional}));
    }

    // Prepares a face: its ends of trims lower the upper bound, its trims are pushed.
    void open_face(int index) {
        const FacePieces& face = model_.face(index);
        slack_ = std::max(slack_, face.slack);
        opened_.push_back(&face);
        for (const Piece& s : face.pieces)
            if (s.kind == PieceKind::Point && s.attained && !s.regional)
                lower_best64(box_bounds(o_, s.box).hi, s);
        for (const Piece& s : face.pieces)
            if (s.kind == PieceKind::Trim) push_piece(s);
    }

    // Trim curves first: their points need no decision of the region, so that they give a tight
    // upper bound before any box is put to it (a box along the domain's border, which a loop
    // follows but for rounding, would otherwise be cut to pieces in vain). Faces whose boxes lie
    // beyond the upper bound are never opened.
    void first_phase() {
        for (size_t i = 0; i < model_.count(); ++i)
            if (!model_.nothing(i))
                push64(std::make_unique<Box64>(
                    Box64{nullptr, int(i), {}, {}, box_bounds(o_, model_.box(i)).lo, false}));
        drain64();
        for (const FacePieces* face : opened_)
            for (const Piece& s : face->pieces)
                if (s.kind != PieceKind::Trim) push_piece(s);
        drain64();
    }

    void drain64() {
        while (!queue64_.empty()) {
            Item64 b = pop64();
            if (b->lo > best64_) break;
            if (b->piece)
                treat64(std::move(b));
            else
                open_face(b->face);
        }
        queue64_.clear();
    }

    void treat64(Item64 b) {
        const Piece& s = *b->piece;
        const Degrees d = objective_degrees(o_, s);
        if (b->net.a.empty()) {
            b->net = objective_net64(o_, s);
            b->lo = std::max(b->lo, lower_bound(b->net));
            ++answer_.nodes64;
            work64_ += net_work(o_, s);
            corners64(*b, d);
            push64(std::move(b));
            return;
        }
        const double ma = magnitude(b->net.a), mb = magnitude(b->net.b);
        const Interval64 t(b->lo, best64_);
        const bool bounded = std::isfinite(b->lo) && best64_ < kInfinity;
        if (bounded &&
            (monotone(b->net, d, true, t, ma, mb) || monotone(b->net, d, false, t, ma, mb)))
            return;
        if (!b->inside) {
            const PieceInRegion in = region(s);
            BoxSide where = region_side(in, b->at, {0, 1}, {0, 1});
            if (where == BoxSide::Mixed) {
                // A loop may follow the border of the domain but for rounding: box_side cannot
                // tell then. Joints are few; of patches only a point that would help is asked.
                const Real half(0.5), none(0.0);
                const Interval unit(none, Real(1.0));
                const double value = value_above(b->net, d, 0.5, 0.5);
                bool held = false;
                if (s.kind == PieceKind::Joint)
                    where = exact_side(in, b->at, unit, Interval(none), half, none, held);
                else if (s.kind == PieceKind::Patch && value < best64_)
                    held = holds(in, b->at, half, half);
                if (held) lower_best64(value, s);
            }
            if (where == BoxSide::Outside) return;
            if (where == BoxSide::Inside) {
                b->inside = true;
                corners64(*b, d);
            }
        }
        // No more to gain in doubles: the gap is of the size of the radii.
        constexpr double kNoise = 16;
        const double largest = std::max(std::fabs(b->lo), std::fabs(best64_));
        const bool noise = bounded && best64_ - b->lo <= kNoise * b->net.noise(largest);
        if (noise || deepest(b->at, d, s.far) || (d.p == 0 && d.q == 0) ||
            work64_ >= budget_.nodes64 || (bounded && curvature(b->net, d, t, ma, mb).convex(d))) {
            if (s.attained && b->inside) sharpen64(*b, d);
            finals64_.push_back(std::move(b));
            return;
        }
        std::vector<double> h(b->net.a);
        if (bounded)
            for (size_t i = 0; i < h.size(); ++i) h[i] -= best64_ * b->net.b[i];
        bool along_u = split_along_u(h, d, b->at);
        // What is next to 1 cannot be cut as finely: half of the levels are left to the second
        // phase, whose balanced feet may do without them.
        constexpr int kBits = 32;
        if (s.far && !may_halve(b->at, along_u, true, kBits)) {
            finals64_.push_back(std::move(b));
            return;
        }
        along_u = allowed_along_u(along_u, d, b->at, s.far);
        Item64 halves[2];
        for (int k = 0; k < 2; ++k)
            halves[k] = std::make_unique<Box64>(
                Box64{&s, s.face, b->at.half(along_u, k == 1), {}, 0, b->inside});
        split64(b->net, d, along_u, halves[0]->net, halves[1]->net);
        work64_ += 2 * box_work(d);
        for (Item64& half : halves) {
            half->lo = std::max(b->lo, lower_bound(half->net));
            ++answer_.nodes64;
            corners64(*half, d);
            push64(std::move(half));
        }
    }

    // Lowers the upper bound to (nearly) the box's least value.
    void sharpen64(const Box64& b, Degrees d) {
        if (d.p == 0 && d.q == 0) return;
        std::vector<double> h(b.net.a);
        const double t = best64_ < kInfinity ? best64_ : b.lo;
        for (size_t i = 0; i < h.size(); ++i) h[i] -= t * b.net.b[i];
        const Newton64 at = newton64(h, d, 0.5, 0.5);
        const double value = value_above(b.net, d, at.x, at.y);
        if (value < best64_)
            lower_best64(value, *b.piece,
                         on_border(*b.piece, b.at, end_of(Real(at.x)), end_of(Real(at.y))));
    }

    // ---- phase 2: MPFR

    void lower_best(const Real& value, const Piece& s, bool border = false) {
        if (value < best_) {
            best_ = value;
            answer_.face = s.face;
            best_kind_ = border ? PieceKind::Joint : s.kind;
        }
    }

    void corners(const BoxMp& b, Degrees d) {
        const Piece& s = *b.piece;
        if (!s.attained || !(b.inside || !s.regional)) return;
        for (int i : {0, d.p})
            for (int j : {0, d.q}) {
                const size_t k = d.index(i, j);
                const Real value = divide_positive(b.net.a[k], b.net.b[k]).hi;
                if (value < best_)
                    lower_best(value, s, on_border(s, b.at, i == 0 ? -1 : 1, j == 0 ? -1 : 1));
            }
    }

    enum class Verdict { Gone, Settled, Level, Final, Open };

    // Applies items 3 and 4 of the header to a box. Gone: holds no minimiser. Settled: its lower
    // bound is within the tolerance of best_. Level: likewise, but it may hold many minimisers.
    // Final: nothing more can be learnt by splitting.
    Verdict close(BoxMp& b, Degrees d) {
        const Piece& s = *b.piece;
        const auto f = foot(b.net, d, b.lo, best_, s.far);
        if (!f) return Verdict::Open;
        work_ += box_work(d);
        b.lo = f->lo;
        if (best_ < b.lo) return Verdict::Gone;
        // Is x on the face?
        if (!s.regional || b.inside) {
            if (s.attained && f->t < best_)
                lower_best(f->t, s, on_border(s, b.at, end_of(f->x), end_of(f->y)));
        } else if (f->convex) {
            bool held = false;
            work_ += kRegionWork;
            const BoxSide where =
                exact_side(region(s), b.at, f->around[0], f->around[1], f->x, f->y, held);
            if (where == BoxSide::Outside) return Verdict::Gone;
            if (held && f->t < best_)
                lower_best(f->t, s, on_border(s, b.at, end_of(f->x), end_of(f->y)));
            // The region's boundary passes within the radius: not worth resolving further.
            constexpr double kUnresolved = 0x1p-160;
            if (where == BoxSide::Mixed && !held && f->radius < Real(kUnresolved))
                return Verdict::Final;
        }
        if (!settled(b.lo)) return Verdict::Open;
        return f->convex ? Verdict::Settled : Verdict::Level;
    }

    // The tolerance on the objective at a value: 2 d w for squares of d, w the width asked of d.
    Real tolerance(const Real& value) const {
        Real width(model_.size());
        mpfr_div_2ui(width.get(), width.get(), kWidthBits, MPFR_RNDN);
        if (o_.linear) return width;
        Real d;
        if (value.sign() > 0) mpfr_sqrt(d.get(), value.get(), MPFR_RNDD);
        return mul_down(d < width ? width : d, width);
    }
    bool near_enough(const Real& lo, const Real& hi) const {
        return !(add_up(lo, tolerance(hi)) < hi);
    }
    bool settled(const Real& lo) const { return near_enough(lo, best_); }

    using ItemMp = std::unique_ptr<BoxMp>;

    // Whether each box can be cut into parts that hold no minimiser or are convex.
    bool isolated(std::vector<ItemMp> boxes) const {
        if (!mpfr_number_p(best_.get())) return false;
        constexpr double kWork = 200;
        for (double work = 0; !boxes.empty();) {
            const auto b = std::move(boxes.back());
            boxes.pop_back();
            const Degrees d = objective_degrees(o_, *b->piece);
            if (best_ < b->lo || (d.p == 0 && d.q == 0)) continue;
            const Interval range(b->lo, best_);
            if (monotone(b->net, d, true, range) || monotone(b->net, d, false, range)) continue;
            if (curvature(b->net, d, range).convex(d)) continue;
            work += std::max(1.0, box_work(d));
            if (work > kWork || deepest(b->at, d, b->piece->far)) return false;
            for (auto& half : halves(*b, d)) boxes.push_back(std::move(half));
        }
        return true;
    }

    std::array<ItemMp, 2> halves(const BoxMp& b, Degrees d) const {
        long exponent = 0;
        const Real& t = mpfr_number_p(best_.get()) ? best_ : b.lo;
        const bool along_u = allowed_along_u(
            split_along_u(scaled_difference(b.net, t, exponent), d, b.at), d, b.at, b.piece->far);
        std::array<ItemMp, 2> r;
        for (int k = 0; k < 2; ++k)
            r[k] = std::make_unique<BoxMp>(
                BoxMp{b.piece, b.at.half(along_u, k == 1), {}, b.lo, b.inside});
        split(b.net, d, along_u, r[0]->net, r[1]->net);
        for (auto& half : r) {
            const Real lo = lower_bound(half->net);
            if (half->lo < lo) half->lo = lo;
        }
        return r;
    }

    void push(ItemMp b) {
        if (best_ < b->lo) return;
        const auto later = [](const ItemMp& x, const ItemMp& y) { return y->lo < x->lo; };
        queue_.push_back(std::move(b));
        std::push_heap(queue_.begin(), queue_.end(), later);
    }

    ItemMp pop() {
        const auto later = [](const ItemMp& x, const ItemMp& y) { return y->lo < x->lo; };
        std::pop_heap(queue_.begin(), queue_.end(), later);
        ItemMp b = std::move(queue_.back());
        queue_.pop_back();
        return b;
    }

    void take(const Box64& f) {
        ItemMp b = std::make_unique<BoxMp>(
            BoxMp{f.piece, f.at, objective_net(o_, *f.piece, f.at), Real(f.lo), f.inside});
        const Real lo = lower_bound(b->net);
        if (b->lo < lo) b->lo = lo;
        ++answer_.nodes;
        work_ += std::max(1.0, net_work(o_, *f.piece));
        corners(*b, objective_degrees(o_, *f.piece));
        push(std::move(b));
    }

    // Boxes of the first phase join when they become the least: their nets are made then.
    void take_finals() {
        while (next_final_ < finals64_.size() &&
               (queue_.empty() || Real(finals64_[next_final_]->lo) <= queue_.front()->lo)) {
            const Box64& f = *finals64_[next_final_++];
            if (!(best_ < Real(f.lo))) take(f);
            if (work_ >= budget_.nodes) return;
        }
    }

    // Whether all boxes of the first phase that may hold a minimiser are in the queue now.
    bool take_all_finals() {
        constexpr size_t kMost = 64;
        for (size_t taken = 0; next_final_ < finals64_.size(); ++next_final_) {
            const Box64& f = *finals64_[next_final_];
            if (best_ < Real(f.lo)) break;
            if (++taken > kMost) return false;
            take(f);
        }
        return true;
    }

    void keep(const Real& lo) {
        if (lo < floor_) floor_ = lo;
    }

    // Everything left in the queues is above this.
    void stop_at_budget() {
        for (const ItemMp& b : queue_) keep(b->lo);
        for (; next_final_ < finals64_.size(); ++next_final_)
            keep(Real(finals64_[next_final_]->lo));
        open_ = true;
    }

    void treat(ItemMp b) {
        const Piece& s = *b->piece;
        const Degrees d = objective_degrees(o_, s);
        if (d.p == 0 && d.q == 0) {
            // Attained points lowered best_ to their own upper end already.
            if (!s.regional || b->inside || holds(region(s), b->at, Real(0.0), Real(0.0))) {
                if (s.attained) lower_best(divide_positive(b->net.a[0], b->net.b[0]).hi, s);
                keep(b->lo);
            }
            return;
        }
        const Interval range(b->lo, best_);
        const bool bounded = mpfr_number_p(best_.get());
        if (bounded && (monotone(b->net, d, true, range) || monotone(b->net, d, false, range)))
            return;
        if (!b->inside) {
            const PieceInRegion in = region(s);
            BoxSide where = region_side(in, b->at, {0, 1}, {0, 1});
            if (where == BoxSide::Mixed) {
                const Interval unit(Real(0.0), Real(1.0)), none(0.0);
                bool held = false;
                work_ += kRegionWork;
                where = exact_side(in, b->at, unit, d.q > 0 ? unit : none, Real(0.5),
                                   Real(d.q > 0 ? 0.5 : 0.0), held);
            }
            if (where == BoxSide::Outside) return;
            if (where == BoxSide::Inside) {
                b->inside = true;
                corners(*b, d);
            }
        }
        const Verdict verdict = bounded ? close(*b, d) : Verdict::Open;
        if (verdict == Verdict::Gone) return;
        if (verdict != Verdict::Open || deepest(b->at, d, s.far)) {
            keep(b->lo);
            open_ |= verdict == Verdict::Open;
            if (verdict == Verdict::Level && !open_) {
                std::vector<ItemMp> one;
                one.push_back(std::move(b));
                open_ = !isolated(std::move(one));
            }
            return;
        }
        work_ += 2 * box_work(d);
        for (auto& half : halves(*b, d)) {
            ++answer_.nodes;
            corners(*half, d);
            push(std::move(half));
        }
    }

    void second_phase() {
        best_ = Real(best64_);
        std::sort(finals64_.begin(), finals64_.end(),
                  [](const auto& a, const auto& b) { return a->lo < b->lo; });
        for (;;) {
            take_finals();
            if (queue_.empty() && next_final_ == finals64_.size()) break;
            if (work_ >= budget_.nodes) {
                stop_at_budget();
                break;
            }
            ItemMp b = pop();
            if (best_ < b->lo) continue;
            if (settled(b->lo)) {
                // All other boxes lie above this bound; whether the minimiser is isolated is asked
                // of those that may hold one.
                keep(b->lo);
                queue_.push_back(std::move(b));
                open_ = !take_all_finals() || !isolated(std::move(queue_));
                break;
            }
            treat(std::move(b));
        }
        answer_.hi = best_;
        answer_.lo = floor_ < best_ ? floor_ : best_;
        answer_.status = DistanceStatus::Regular;
        if (!near_enough(answer_.lo, best_))
            answer_.status = DistanceStatus::Budget;
        else if (open_)
            answer_.status = DistanceStatus::IntervalOnly;
        else if (best_kind_ != PieceKind::Patch)
            answer_.status = DistanceStatus::EdgeOrCorner;
    }

    // An operation on Intervals against one on doubles, in time.
    static constexpr double kMpWork = 40;

    const Pieces& model_;
    const Objective o_;
    const DistanceBudget budget_;
    DistanceAnswer answer_;
    std::vector<const FacePieces*> opened_;
    double slack_ = 0;
    std::vector<Item64> queue64_, finals64_;
    double best64_ = kInfinity;
    double work64_ = 0, work_ = 0;
    PieceKind best_kind_ = PieceKind::Point;
    std::vector<ItemMp> queue_;
    size_t next_final_ = 0;
    Real best_, floor_ = Real(kInfinity);  // floor_: the least bound of the boxes that are closed
    bool open_ = false;  // whether a box was left without a proof of a single minimiser
};

// [lo - slack, hi + slack]
void widen(DistanceAnswer& r, double slack) {
    if (!(slack > 0)) return;
    r.lo = sub_down(r.lo, Real(slack));
    r.hi = add_up(r.hi, Real(slack));
}

}  // namespace

DistanceAnswer distance(const Pieces& model, const std::array<double, 3>& c,
                        const DistanceBudget& budget) {
    Search search(model, {false, c, 0}, budget);
    DistanceAnswer r = search.run();
    if (r.lo.sign() < 0) r.lo = Real(0.0);
    mpfr_sqrt(r.lo.get(), r.lo.get(), MPFR_RNDD);
    mpfr_sqrt(r.hi.get(), r.hi.get(), MPFR_RNDU);
    widen(r, search.slack());
    if (r.lo.sign() < 0) r.lo = Real(0.0);
    return r;
}

DistanceAnswer support(const Pieces& model, const std::array<double, 3>& n, double h,
                       const DistanceBudget& budget) {
    Search search(model, {true, n, h}, budget);
    DistanceAnswer r = search.run();
    // |n| times the slack.
    Interval64 square(0.0);
    for (double x : n) square = square + Interval64(x) * Interval64(x);
    widen(r, next_up(search.slack() * next_up(std::sqrt(square.hi))));
    return r;
}

}  // namespace feeler_oracle
