//! Nodes on which `G = N - tau C` is strictly convex: the last digits.

use super::node::{Node, on_borders};
use super::objective::Sample;
use super::outcome::{Growth, Settled, Source, Spread};
use super::search::{QUARTER, Search};
use super::shape::Shape;
use super::task::{Arithmetic, Task};
use super::upper::upper_end;
use crate::numeric::bernstein::{Bidegree, greater};
use crate::numeric::{Ball, Dd, Real, Td};
use crate::prepare::closed::Extent;
use crate::prepare::{Homogeneous, jet};
use crate::trim::BoxSide;
use std::collections::BinaryHeap;

/// What convexity proves about a node. Lengths `y` are in coordinates that run over the node from 0 to 1.
///
/// Let `p` be a point of the node, `tau = f(p)` (a double-double; any number would do), `g = grad G(p)`, and
/// `G` strongly convex on the node with constant `lambda > 0` (its Hessian is at least `lambda`; from the second differences of its
/// coefficients). A component of `g` is *pinned* if `p` lies on that border of the node and `g` points so that
/// `g_k (y - p)_k >= 0` for all `y` in the node; `g'` is the rest.
///
/// 1. *Bound.* `G(y) >= G(p) + g.(y-p) + lambda/2 |y-p|^2 >= G(p) - |g'|^2 / (2 lambda)`, hence
///    `f = tau + G/C >= tau + (that) / C`.
/// 2. *Critical points.* Where `grad f(y) = 0`: `grad G(y) = (f(y) - tau) grad C(y)`. Strong convexity gives
///    `(y-p).(grad G(y) - g) >= lambda |y-p|^2`, hence
///    `|y-p| <= (|g'| + |f(y) - tau| |grad C|) / lambda =: rho`.
///    `|f(y) - tau| = |G(y)| / C <= (|G(p)| + |g| rho + Lambda/2 rho^2) / min C`, so a
///    ball of radius `rho` gives a smaller one until it no longer shrinks.
/// 3. *None.* If a component is pinned, `|grad G(y) - g| <= Lambda |y-p|`; so there is no critical point if
///    `|g| - |f - tau| |grad C| > Lambda rho`.
/// 4. *Cut.* If no component is pinned but on borders of the patch (or the ends of the piece), `p` may be a local minimum of the face all the same:
///    where the face ends, or where the next patch rises too. If one is pinned on another side, `p` is none: `f` is smooth there and
///    goes on falling beyond, where the next node is.
pub(crate) struct Leaf {
    pub(crate) p: [Dd; 2],
    pub(crate) lo: Dd,
    /// Radius of the ball that holds all critical points.
    pub(crate) rho: f64,
    /// Whether there are provably none.
    pub(crate) empty: bool,
    /// Whether `p` is pinned on a side of the node that is no border of its patch.
    pub(crate) cut: bool,
    /// Whether no critical point on the box was found to be in the region: what is on borders of the patch is searched apart (with a node, it is in line).
    pub(crate) none_in_region: bool,
    /// `f(p)`.
    pub(crate) value: Ball<Dd>,
    /// The homogeneous point at `p`, where it was found in double-double.
    pub(crate) point: Option<Homogeneous<Dd, 4>>,
    /// Where `f` can be low; without the speed.
    pub(crate) growth: Growth,
    /// `sqrt(2 C / lambda)`: how far `f` may be followed before it grows by one, in node coordinates.
    pub(crate) reach: f64,
}

impl Leaf {
    /// Whether its bound hangs on roundings of the value more than on the slope that is left at `p`, thus is about as good as this arithmetic has it.
    fn is_at_rest(&self) -> bool {
        let Growth {
            slope,
            lambda,
            value,
            ..
        } = self.growth;
        slope * slope <= 2.0 * lambda * value
    }
}

const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
const DOWN: f64 = 1.0 - 64.0 * f64::EPSILON;
/// Steps of Newton's method with a double-double gradient. With the f64 Hessian at the point each
/// gains some 50 bits and three do; with the node's mean Hessian convergence is linear.
const POLISH_STEPS: usize = 16;
/// A ball of critical points this small (in units of the node) has shrunk all it will.
const SMALL_BALL: f64 = 1.0 / (1u64 << 20) as f64;
/// A step below this, in local parameters, changes nothing that a double-double holds.
const LEAST_STEP: f64 = 1.0 / (1u128 << 96) as f64;
/// A value that is off by more than this share of the width wanted is found in triple-double.
const LOST: f64 = 1.0 / 32.0;
/// No more than a third.
const THIRD: f64 = 0.333;
/// How often the ball of critical points is shrunk.
const SHRINK_STEPS: usize = 24;

/// A box, and what of a node on it counts here.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell<'a, T> {
    pub(super) u: [f64; 2],
    pub(super) v: [f64; 2],
    /// Proven: `f >= lo` on the box.
    pub(super) lo: Dd,
    pub(super) degree: Bidegree,
    /// Whether `C` is 1, exactly.
    pub(super) constant: bool,
    /// The node, unless what is known of its shape comes from one about another centre.
    pub(super) node: Option<&'a Node<T>>,
    /// A place on it from where the way down is short, if one is known.
    pub(super) near: Option<[f64; 2]>,
}

impl<'a, T> From<&'a Node<T>> for Cell<'a, T> {
    fn from(node: &'a Node<T>) -> Self {
        Self {
            u: node.u,
            v: node.v,
            lo: node.lo,
            degree: node.f.degree,
            constant: node.f.c.is_empty(),
            node: Some(node),
            near: None,
        }
    }
}

impl Search<'_> {
    /// Tries to settle a box by convexity: what is proven of it if it needs no more work.
    pub(super) fn leaf<T: Real + Arithmetic>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        source: Source,
        inside: bool,
        cell: &Cell<T>,
        shape: (&Shape, Dd),
    ) -> Option<Leaf> {
        let mut leaf = self.certify(source, cell, shape)?;
        if self.hopeless(leaf.lo) {
            return Some(leaf);
        }
        let narrowest = (cell.u[1] - cell.u[0]).max(cell.v[1] - cell.v[0]);
        if !self.serves(&leaf) && (narrowest > SMALL_BALL || !leaf.is_at_rest()) {
            // Convex, but only just: halves have better bounds.
            self.try_point(source, leaf.p, false);
            return None;
        }
        let mut minimum_inside = true;
        if let Source::Patch { face, index } = source
            && !inside
        {
            let around = |k: usize, range: [f64; 2]| {
                if range[0] == range[1] {
                    return range;
                }
                // `p` is rounded to its leading part.
                let r = leaf.rho * (range[1] - range[0]) * UP + f64::EPSILON;
                [
                    (leaf.p[k].hi - r).max(range[0]),
                    (leaf.p[k].hi + r).min(range[1]),
                ]
            };
            let mut side = self.classify(face, index, around(0, cell.u), around(1, cell.v));
            if side == BoxSide::Mixed && leaf.rho <= SMALL_BALL {
                // A trim passes next to it: the ball itself may be clear of that.
                let radius = [cell.u, cell.v].map(|r| leaf.rho * (r[1] - r[0]) * UP);
                side = self.side_around((face, index), leaf.p, radius);
            }
            if leaf.empty || side == BoxSide::Outside {
                if let Some(node) = cell.node {
                    self.push_borders(heap, source, inside, node);
                }
                leaf.none_in_region = true;
                return Some(leaf);
            }
            minimum_inside = side == BoxSide::Inside;
            if !minimum_inside && leaf.rho > SMALL_BALL {
                // The ball is no answer yet: halves have smaller ones.
                self.try_point(source, leaf.p, false);
                return None;
            }
        }
        if let Source::Piece { face, index } = source {
            let rho = leaf.rho * (cell.u[1] - cell.u[0]) * UP + f64::EPSILON * f64::EPSILON;
            let around = [
                (leaf.p[0] - Dd::from(rho)).hi.max(cell.u[0]),
                (leaf.p[0] + Dd::from(rho)).hi.min(cell.u[1]),
            ];
            if self.piece_place(face, index, around).off {
                // Not on the surface (past its border): only where the curve comes back matters.
                return self.piece_place(face, index, cell.u).off.then_some(leaf);
            }
            if leaf.rho > SMALL_BALL && self.piece_leaves(face, index) {
                self.try_point(source, leaf.p, false);
                return None;
            }
        }
        self.keep_leaf(source, &leaf, minimum_inside);
        if self.hopeless(leaf.lo) {
            return Some(leaf);
        }
        self.lower(leaf.lo);
        let size = self.speed(source, cell);
        self.out.settled.push(Settled {
            face: source.face(),
            source: Some(source),
            lo: leaf.lo,
            at: [leaf.p[0].hi, leaf.p[1].hi],
            spread: Some(Spread::Around(Growth {
                speed: size,
                ..leaf.growth
            })),
            extent: Extent::Root(leaf.reach * size),
            local_minimum: !leaf.empty,
            on_border: leaf.empty && !leaf.cut,
            flat: false,
        });
        Some(leaf)
    }

    /// Whether a leaf's bounds are near enough to each other, or its lower bound to what is known.
    fn serves(&self, leaf: &Leaf) -> bool {
        // The lower end is near the value, and, with what the value may be off, the whole is narrow enough.
        let own = leaf.value.mid;
        let end = upper_end(leaf.value);
        let all = self.goal.all_below.is_some();
        let least = |x: Dd| {
            if all || x < self.out.hi {
                x
            } else {
                self.out.hi
            }
        };
        let narrow = leaf.lo >= self.near(least(own), QUARTER)
            && leaf.lo >= self.near(least(end), self.most_served());
        narrow || leaf.lo >= self.enough()
    }

    /// Which share of the width a leaf's bounds may take up. Ends that are rounded to f64 take up to an ulp more each, and in full the width is two ulps or more: of bounds that
    /// are `k` ulps apart the rounded ones are `k + 1` at most, for whole `k`. A third of a width of `k + 1` to `k + 2` ulps is no more than `k`.
    fn most_served(&self) -> f64 {
        if self.goal.width.is_full() {
            THIRD
        } else {
            3.0 * QUARTER
        }
    }

    /// Where a descent on a box starts: at the best point so far, if it is on it; else near where it is known to end, or in the middle.
    fn start<T>(&self, source: Source, cell: &Cell<T>) -> [f64; 2] {
        let ranges = [cell.u, cell.v];
        let best = self.best_on(source, ranges).or(cell.near);
        best.unwrap_or_else(|| ranges.map(|r| 0.5 * (r[0] + r[1])))
    }

    /// The best point so far, if it is on a node.
    pub(super) fn best_on(&self, source: Source, ranges: [[f64; 2]; 2]) -> Option<[f64; 2]> {
        let (own, p) = self.out.foot.as_ref()?.found?;
        let holds = (0..2).all(|k| ranges[k][0] <= p[k] && p[k] <= ranges[k][1]);
        (own == source && holds).then_some(p)
    }

    /// Whether a place is next to the best point so far.
    fn is_best(&self, source: Source, p: [f64; 2]) -> bool {
        let near = |q: [f64; 2]| (0..2).all(|k| (p[k] - q[k]).abs() <= SMALL_BALL);
        let found = self.out.foot.as_ref().and_then(|f| f.found);
        found.is_some_and(|(s, q)| s == source && near(q))
    }

    /// The borders of the patch that the node touches, as nodes of their own.
    fn push_borders<T: Real + Arithmetic>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        source: Source,
        inside: bool,
        node: &Node<T>,
    ) {
        for (k, high) in on_borders([node.u, node.v]) {
            self.enqueue_border(heap, source, inside, node, (k == 0, high));
        }
    }

    /// How fast the surface moves over the node, in units of length per unit of node coordinates.
    fn speed<T: Real>(&self, source: Source, cell: &Cell<T>) -> f64 {
        let (Source::Patch { face, .. } | Source::Piece { face, .. }) = source;
        let geometry = self.brep.double(face);
        let speeds = match source {
            Source::Patch { index, .. } => geometry.patch_speeds(index),
            Source::Piece { index, .. } => geometry.piece_speeds(index),
        };
        let [along_u, along_v] = speeds;
        (along_u * (cell.u[1] - cell.u[0]) + along_v * (cell.v[1] - cell.v[0])) * UP
    }

    /// Bounds on a node that is convex for `G = N - tau C`, by what is known about its shape with some tau. As cheaply as
    /// serves: in f64, then with a value in double-double, then with Newton's method in double-double.
    pub(super) fn certify<T: Real>(
        &self,
        source: Source,
        cell: &Cell<T>,
        shape: (&Shape, Dd),
    ) -> Option<Leaf> {
        let coarse = self.net(source)?;
        let ranges = [cell.u, cell.v];
        let mut start = self.start(source, cell);
        // Where a warm start has come down there is no way left.
        if self.out.rough_at(source, start).is_none() || cell.node.is_some() {
            start = self.descend(source, start, ranges);
        }
        let mut p = start.map(Dd::from);
        if T::UNIT >= f64::UNIT && jet::fits(coarse.degree) {
            // At the best point so far, f64 is not worth trying for the last digits.
            if !(self.goal.width.is_full() && self.is_best(source, start)) {
                let leaf = match self.out.rough_at(source, start) {
                    Some(rough) => self.prove(cell, shape, p, &rough.sample)?,
                    None => {
                        let sample = self.objective.rough_sample(coarse, start);
                        self.prove(cell, shape, p, &sample)?
                    }
                };
                if self.hopeless(leaf.lo) || self.serves(&leaf) {
                    return Some(leaf);
                }
            }
            let net = self.net_dd(source)?;
            if let Some(sample) = self.objective.fine_sample(coarse, net, start) {
                let leaf = self.prove(cell, shape, p, &sample)?;
                if self.hopeless(leaf.lo) || self.serves(&leaf) {
                    return Some(leaf);
                }
            }
        }
        let net = self.net_dd(source)?;
        let widths = ranges.map(|r| r[1] - r[0]);
        for _ in 0..POLISH_STEPS {
            let s = self.objective.sample(net, ball(p[0]), ball(p[1]));
            let slope: [f64; 2] = std::array::from_fn(|k| {
                let g =
                    (s.n_slope[k].mid * s.c.mid - s.n.mid * s.c_slope[k].mid) / (s.c.mid * s.c.mid);
                g.hi
            });
            // Where f64 sees only noise, the node's own coefficients know the Hessian better.
            let h = match cell.node {
                Some(node) if T::UNIT < f64::UNIT => node.mean_hessian(T::from_dd(s.value().mid).0),
                _ => self.objective.guide(coarse, p[0].hi, p[1].hi).curvature,
            };
            let blocked: [bool; 2] = std::array::from_fn(|k| {
                widths[k] == 0.0
                    || (p[k].hi <= ranges[k][0] && slope[k] > 0.0)
                    || (p[k].hi >= ranges[k][1] && slope[k] < 0.0)
            });
            let step = super::upper::newton_step(slope, h, blocked);
            let mut moved = false;
            let long = |k: usize| step[k].abs() > 0.5 * widths[k];
            if T::UNIT < f64::UNIT && widths[0] > 0.0 && widths[1] > 0.0 && (long(0) || long(1)) {
                // The minimum is off the node: what is least on it is on a side.
                let room: [[f64; 2]; 2] =
                    std::array::from_fn(|k| ranges[k].map(|end| (Dd::from(end) - p[k]).hi));
                for (k, place) in least_on_sides(slope, h, room).into_iter().enumerate() {
                    let next = match place {
                        Place::End(high) => Dd::from(ranges[k][usize::from(high)]),
                        Place::Between(step) => clamp(p[k] + Dd::from(step), ranges[k]),
                    };
                    moved |= (next - p[k]).magnitude() > LEAST_STEP;
                    p[k] = next;
                }
                if !moved {
                    break;
                }
                continue;
            }
            for k in 0..2 {
                if blocked[k] || step[k].abs() > 0.5 * widths[k] {
                    continue;
                }
                let next = clamp(p[k] + Dd::from(step[k]), ranges[k]);
                moved |= next != p[k] && step[k].abs() > LEAST_STEP;
                p[k] = next;
            }
            if !moved {
                break;
            }
        }
        let s = self.objective.sample(net, ball(p[0]), ball(p[1]));
        let leaf = self.prove(cell, shape, p, &s)?;
        if !(self.hopeless(leaf.lo) || self.serves(&leaf))
            && self.is_lost(leaf.value)
            && let Some(net) = self.net_in::<Td>(source)
        {
            let [u, v] = p.map(|x| Ball::from_dd(x, 0.0));
            let s = self.objective.sample(net, u, v);
            return self.prove(cell, shape, p, &s);
        }
        Some(leaf)
    }

    /// Whether the rounding of a value in double-double takes up so much of the width that is wanted in full that more digits may serve.
    pub(super) fn is_lost(&self, value: Ball<Dd>) -> bool {
        if !self.goal.width.is_full() {
            return false;
        }
        let rad = Dd::from(value.rad * UP);
        !(value.mid - rad >= self.near(value.mid + rad, LOST))
    }

    /// What convexity proves at a point of a node.
    fn prove<T: Real>(
        &self,
        cell: &Cell<T>,
        (shape, shape_tau): (&Shape, Dd),
        p: [Dd; 2],
        s: &Sample,
    ) -> Option<Leaf> {
        let ranges = [cell.u, cell.v];
        let widths = ranges.map(|r| r[1] - r[0]);
        let value = s.value();
        let tau = value.mid;
        if !tau.hi.is_finite() {
            return None;
        }
        // The shape is known for another tau: what that changes is counted, or it is found anew.
        let mut tau_error = (tau - shape_tau).magnitude() * UP;
        let mut own = *shape;
        let fine = T::UNIT < f64::UNIT;
        if fine || !(convexity(&own, cell, tau_error) > 0.5 * own.convexity) {
            let (node_tau, error) = T::from_dd(tau);
            own = cell.node?.shape(node_tau);
            tau_error = error;
        }
        let shape = &own;
        let lambda = convexity(shape, cell, tau_error);
        if !(lambda > 0.0 && shape.c_range[0] > 0.0) {
            return None;
        }
        let exact_tau = ball(tau);
        // Where `C` is 1 its derivatives are 0, and `tau` is the middle of what `N` is known to be.
        let minus = |x: Ball<Dd>, c: Ball<Dd>| {
            if cell.constant { x } else { x - exact_tau * c }
        };
        let off = if s.c.is_one() {
            s.n.rad
        } else {
            (s.n - exact_tau * s.c).magnitude()
        };
        let (mut free, mut all_high) = ([0.0; 2], [0.0; 2]);
        let mut all_low = 0.0;
        let (mut pinned, mut cut) = (false, false);
        for k in 0..2 {
            if widths[k] == 0.0 {
                continue;
            }
            let g = minus(s.n_slope[k], s.c_slope[k]);
            // The lesser part of the middle, with the radius: a rounding of the greater part at most, unless the radius is larger.
            let off = (g.mid.lo.abs() + g.rad) * UP;
            let [low, high] = [g.mid.hi - off, g.mid.hi + off];
            let size = greater(low.abs(), high.abs()) * widths[k] * UP;
            all_high[k] = size;
            let is_pinned = (p[k] == Dd::from(ranges[k][0]) && low > 0.0)
                || (p[k] == Dd::from(ranges[k][1]) && high < 0.0);
            if is_pinned {
                pinned = true;
                cut |= p[k] != Dd::ZERO && p[k] != Dd::ONE;
                let least = low.abs().min(high.abs()) * widths[k] * DOWN;
                all_low += least * least;
            } else {
                free[k] = size;
            }
        }
        let free = length(free) * UP;
        // Not the square first, which may underflow.
        let drop = (free * (free / (2.0 * lambda)) + off) * UP;
        // G(p) is zero up to rounding: taken as a loss.
        let lo = tau - Dd::from(drop / shape.c_range[0] * UP);
        let lo = Dd::new(lo.hi, lo.lo) - Dd::from(8.0 * Dd::UNIT * tau.magnitude());
        let curvature = shape.curvature * UP + tau_curvature(shape, cell, tau_error);
        let all_high = length(all_high) * UP;
        let growth =
            |rho: f64| (off + all_high * rho + 0.5 * curvature * rho * rho) / shape.c_range[0] * UP;
        // The whole node to start with.
        let mut rho = std::f64::consts::SQRT_2 * UP;
        let steps = if shape.c_slope == 0.0 {
            1
        } else {
            SHRINK_STEPS
        };
        for _ in 0..steps {
            let next = (free + growth(rho) * shape.c_slope) / lambda * UP;
            if next >= rho {
                break;
            }
            rho = next;
        }
        let empty = pinned
            && all_low.sqrt() * (1.0 - 16.0 * f64::EPSILON)
                > (curvature * rho + growth(rho) * shape.c_slope) * UP;
        let best = if self.objective.is_squared() && lo < Dd::ZERO {
            Dd::ZERO
        } else {
            lo
        };
        Some(Leaf {
            p,
            lo: if cell.lo > best { cell.lo } else { best },
            rho,
            empty,
            cut,
            none_in_region: false,
            value,
            point: s.point,
            growth: Growth {
                slope: free,
                value: off,
                lambda,
                c_max: shape.c_range[1],
                tau,
                speed: 0.0,
            },
            reach: (2.0 * shape.c_range[1] / lambda).sqrt(),
        })
    }
}

/// The length of a vector of these two sizes, up to a few roundings, however small they are.
fn length([a, b]: [f64; 2]) -> f64 {
    /// Squares that underflow lose less than the least normal number: of a sum above this, no more than half a unit of double-double.
    const PLAIN: f64 = f64::MIN_POSITIVE / (f64::EPSILON * f64::EPSILON);
    let square = a * a + b * b;
    if square > PLAIN {
        return square.sqrt();
    }
    let most = greater(a, b);
    if most > 0.0 {
        let [a, b] = [a / most, b / most];
        most * (a * a + b * b).sqrt()
    } else {
        square
    }
}

/// The change of the Hessian of `G` when tau changes by `tau_error`: second differences of `C` are at
/// most four coefficients, times `degree^2`, in each of the four entries.
fn tau_curvature<T: Real>(shape: &Shape, cell: &Cell<T>, tau_error: f64) -> f64 {
    if cell.constant {
        return 0.0;
    }
    let d = (cell.degree.u + cell.degree.v) as f64;
    4.0 * tau_error * shape.c_range[1] * d * d * UP
}

/// The least eigenvalue of the Hessian of `G` for a tau that is another one by `tau_error` at most is at least this.
pub(super) fn convexity<T: Real>(shape: &Shape, cell: &Cell<T>, tau_error: f64) -> f64 {
    shape.convexity - tau_curvature(shape, cell, tau_error)
}

fn ball(x: Dd) -> Ball<Dd> {
    Ball { mid: x, rad: 0.0 }
}

/// A coordinate of a place on a side of a box: at the low or the high (`true`) end, or a step away.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    End(bool),
    Between(f64),
}

/// Where on the sides of a box a quadratic function of this slope and Hessian is least, which is convex and has its minimum elsewhere; `room` is how far it is
/// to the ends. Only a guide.
fn least_on_sides(slope: [f64; 2], h: [f64; 3], room: [[f64; 2]; 2]) -> [Place; 2] {
    let value = |s: [f64; 2]| {
        slope[0] * s[0]
            + slope[1] * s[1]
            + 0.5 * (h[0] * s[0] * s[0] + h[2] * s[1] * s[1])
            + h[1] * s[0] * s[1]
    };
    let mut best = (f64::INFINITY, [Place::Between(0.0); 2]);
    for (k, high) in [(0, false), (0, true), (1, false), (1, true)] {
        let end = room[k][usize::from(high)];
        let other = 1 - k;
        let least = -(slope[other] + h[1] * end) / h[2 * other];
        let [low, top] = room[other];
        // Negated: what is no number is at the low end.
        let (step, place) = if !(least > low) {
            (low, Place::End(false))
        } else if least >= top {
            (top, Place::End(true))
        } else {
            (least, Place::Between(least))
        };
        let (steps, places) = if k == 0 {
            ([end, step], [Place::End(high), place])
        } else {
            ([step, end], [place, Place::End(high)])
        };
        let own = value(steps);
        if own < best.0 {
            best = (own, places);
        }
    }
    best.1
}

fn clamp(x: Dd, range: [f64; 2]) -> Dd {
    if x < Dd::from(range[0]) {
        Dd::from(range[0])
    } else if x > Dd::from(range[1]) {
        Dd::from(range[1])
    } else {
        x
    }
}

#[cfg(test)]
mod tests;
