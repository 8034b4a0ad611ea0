//! Which boxes of the patches of a sphere a nearer point can be in.
//!
//! # What is proven
//! On a surface that is a sphere up to the thickness of its [shell](crate::prepare::Shell), all points nearer to a ball's centre than one
//! that is known are in a [half-space](crate::prepare::Shell::near_half_space): squared distances are linear there but for what the shell allows. A linear
//! function on a patch is a quotient with the patch's own weights, of half the degree that a squared distance has and a third of its
//! coefficients: where it is above the half-space's offset for all coefficients of a box (they are averages of the patch's, and
//! weights are positive), no point of the box is nearer.
//!
//! Where the linear function is least on a patch, the four quarters about that place have it at a corner: where the place is not near, all of them are above the
//! offset; else all eight halves of the strips beside a small box about it, which cover the rest of the patch, and the small box is searched. Where that fails, boxes are
//! halved until they are above it or small; one box about those that are left is searched.
//!
//! The half-space is first made for the distance that the sphere itself has, and a little more. The least place of all patches is then where the search for a
//! nearest point starts; if what is found there is no farther, that half-space holds all that is nearer.
//!
//! Nothing is said of how small the rest is: a box that the half-space does not tell is searched like any other.

use super::objective::Objective;
use super::outcome::Source;
use super::search::Search;
use super::task::{Arithmetic, Kind, Task};
use crate::numeric::bernstein::greater;
use crate::numeric::{Dd, Real, TINY};
use crate::prepare::{NearHalfSpace, Net, Shell};
use arrayvec::ArrayVec;
use nalgebra::Point3;
use std::collections::BinaryHeap;

/// How far the small box about the least place of a patch goes, in local parameters, from the nearest multiple of that: no end is nearer to the place
/// than half of it, but those of the patch.
const ABOUT: f64 = 1.0 / 16.0;
/// Of how many patches the nearest may be on one; where more come near, the next to a pole or where distances hardly differ, none has an edge.
const MOST_NEAR: usize = 8;
/// By which part the distance of a sphere is enlarged, and by how many times its thickness, for the surface that is on it.
const LARGER: f64 = 1.0 / (1u64 << 40) as f64;
const THICKER: f64 = 4.0;
/// Rounds of finding the least place, along u and along v: they are told apart all but perfectly by what a sphere's parameters are.
const ROUNDS: usize = 6;
/// Steps this short end them.
const SETTLED: f64 = 1.0 / (1u64 << 12) as f64;
/// Boxes this wide or narrower, in local parameters, are not halved.
const SMALL: f64 = 1.0 / 8.0;
/// Patches of which a box wider than this is left are searched like any other.
const WIDE: f64 = 0.5;
/// Halvings down to a small box: three along either side.
const HALVINGS: usize = 6;
/// Boxes that wait: one at each step on the way down, and the last two.
const DEPTH: usize = HALVINGS + 2;
/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 32.0 * f64::EPSILON;

/// Coefficients over a box: rows along u, in each the ones along v; of second degree, as exact round patches have it, or raised to it.
type Coefficients = [f64; 9];

/// Coefficients of `n.(X - o w) - t w` over a box.
#[derive(Clone, Copy)]
struct Linear {
    c: Coefficients,
    u: [f64; 2],
    v: [f64; 2],
}

/// Those over a whole patch, and how much they are off; `None` for patches of higher degrees: they are searched like any other.
fn linear(net: &Net<f64>, half: &NearHalfSpace) -> Option<(Coefficients, f64)> {
    let (du, dv) = (net.degree.u, net.degree.v);
    if !(1..=2).contains(&du) || !(1..=2).contains(&dv) {
        return None;
    }
    let n = &half.normal;
    let from = Point3::from(net.origin) - half.origin;
    let shift = n.dot(&from) - half.offset;
    let mut values = [0.0; 9];
    for (value, p) in values.iter_mut().zip(&net.points) {
        *value = n[0] * p[0].mid + n[1] * p[1].mid + n[2] * p[2].mid + shift * p[3].mid;
    }
    let c = match (du, dv) {
        (2, 2) => values,
        (1, 1) => {
            let [a, b, c, d, ..] = values;
            rows_raised(raised([a, b]), raised([c, d]))
        }
        (1, _) => {
            let [a, b, c, d, e, f, ..] = values;
            rows_raised([a, b, c], [d, e, f])
        }
        _ => {
            let [a, b, c, d, e, f, ..] = values;
            let [x, y, z] = [raised([a, b]), raised([c, d]), raised([e, f])];
            [x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]]
        }
    };
    // Differences, products and sums of `shift` are off by four roundings of its parts, values by as many of theirs, means by one more.
    // (Sums of magnitudes: squares of the least would be lost.)
    let parts = n.lp_norm(1) * from.lp_norm(1) + half.offset.abs();
    let mut error = 8.0 * f64::EPSILON * parts * net.largest[3] + parts * net.spread[3];
    for k in 0..3 {
        error += n[k].abs() * (8.0 * f64::EPSILON * net.largest[k] + net.spread[k]);
    }
    Some((c, (error + TINY) * UP))
}

/// What halving down to the smallest boxes adds to the error: two roundings of a mean at each step. No mean is larger than the largest
/// of all.
fn halving_error(c: &Coefficients) -> f64 {
    let most = c.iter().fold(0.0, |m, x| greater(m, x.abs()));
    HALVINGS as f64 * (4.0 * f64::EPSILON * most + TINY) * UP
}

fn is_above(c: &Coefficients, least: f64) -> bool {
    // All of them are looked at: no branch to be guessed.
    c.iter().fold(true, |above, x| above & (*x > least))
}

/// A patch that comes near.
pub(super) struct NearPatch {
    index: usize,
    c: Coefficients,
    error: f64,
    /// Where it seems nearest.
    least: [f64; 2],
}

/// What all patches of a sphere are told by.
pub(super) struct Approach {
    /// All points whose squared distance is below this are on the patches below.
    squared: f64,
    near: ArrayVec<NearPatch, MOST_NEAR>,
}

impl Approach {
    /// Whether it tells of all points nearer than this squared distance.
    pub(super) fn serves(&self, squared: Dd) -> bool {
        squared <= Dd::from(self.squared)
    }

    /// The patch and place to start from.
    pub(super) fn start(&self) -> Option<(usize, [f64; 2])> {
        let value = |n: &NearPatch| value(&n.c, n.least);
        let least = self
            .near
            .iter()
            .min_by(|a, b| value(a).total_cmp(&value(b)))?;
        Some((least.index, least.least))
    }
}

/// A polynomial's value at a place along v for each of the three coefficients along u...
#[inline]
fn at_v(c: &Coefficients, v: f64) -> [f64; 3] {
    let s = 1.0 - v;
    let (a, b, d) = (s * s, 2.0 * s * v, v * v);
    [
        a * c[0] + b * c[1] + d * c[2],
        a * c[3] + b * c[4] + d * c[5],
        a * c[6] + b * c[7] + d * c[8],
    ]
}

/// ...and the other way around.
#[inline]
fn at_u(c: &Coefficients, u: f64) -> [f64; 3] {
    let s = 1.0 - u;
    let (a, b, d) = (s * s, 2.0 * s * u, u * u);
    [
        a * c[0] + b * c[3] + d * c[6],
        a * c[1] + b * c[4] + d * c[7],
        a * c[2] + b * c[5] + d * c[8],
    ]
}

fn value(c: &Coefficients, [u, v]: [f64; 2]) -> f64 {
    let [a, b, d] = at_v(c, v);
    let s = 1.0 - u;
    s * s * a + 2.0 * s * u * b + u * u * d
}

/// Where a polynomial of second degree is least in `[0, 1]`.
fn least_of([a, b, c]: [f64; 3]) -> f64 {
    let bend = a - 2.0 * b + c;
    if bend > 0.0 {
        ((a - b) / bend).clamp(0.0, 1.0)
    } else if c < a {
        1.0
    } else {
        0.0
    }
}

/// About where a polynomial is least, going along u and v in turn from its least coefficient. Only a guide.
fn least_place(c: &Coefficients) -> [f64; 2] {
    let mut least = 0;
    for k in 1..9 {
        if c[k] < c[least] {
            least = k;
        }
    }
    let [mut u, mut v] = [least / 3, least % 3].map(|k| 0.5 * k as f64);
    for _ in 0..ROUNDS {
        let before = [u, v];
        u = least_of(at_v(c, v));
        v = least_of(at_u(c, u));
        if (u - before[0]).abs() + (v - before[1]).abs() < SETTLED {
            break;
        }
    }
    [u, v]
}

/// The coefficients of the part below (or above) `t` along u (or v).
fn part(c: &Coefficients, along_u: bool, t: f64, above: bool) -> Coefficients {
    let (stride, other) = if along_u { (3, 1) } else { (1, 3) };
    let s = 1.0 - t;
    let mut out = *c;
    for k in 0..3 {
        let [i, j, l] = [0, 1, 2].map(|m| k * other + m * stride);
        let (p, q) = (s * c[i] + t * c[j], s * c[j] + t * c[l]);
        let m = s * p + t * q;
        if above {
            (out[i], out[j]) = (m, q);
        } else {
            (out[j], out[l]) = (p, m);
        }
    }
    out
}

/// A box that holds all of a patch that is not above `error`, found about its least place; `None` where that does not tell, and no box where nothing is left.
///
/// A part is made of the whole by two cuts at most, each of which rounds `1 - t`, products and sums of what is no larger than the largest coefficient,
/// twice over: by less than a halving's share each.
fn box_about(c: &Coefficients, least: [f64; 2], error: f64) -> Option<Option<[[f64; 2]; 2]>> {
    let split = |strip: &Coefficients, along_u: bool| {
        let at = least[usize::from(!along_u)];
        [false, true]
            .iter()
            .all(|above| is_above(&part(strip, along_u, at, *above), error))
    };
    if value(c, least) > error {
        let quarters = [false, true]
            .iter()
            .all(|above| split(&part(c, true, least[0], *above), false));
        return quarters.then_some(None);
    }
    // Such as halving of the patch could reach: each half of it is then exactly between f64 numbers, as far down as boxes are halved.
    let ends = least.map(|x| {
        let middle = (x / ABOUT).round();
        [middle - 1.0, middle + 1.0].map(|x| (x * ABOUT).clamp(0.0, 1.0))
    });
    for (along_u, [low, high]) in [(true, ends[0]), (false, ends[1])] {
        let below = low == 0.0 || split(&part(c, along_u, low, false), !along_u);
        if !(below && (high == 1.0 || split(&part(c, along_u, high, true), !along_u))) {
            return None;
        }
    }
    Some(Some(ends))
}

impl Linear {
    /// Along which of u and v (u: true) it is to be halved: where it changes more, as far as it is not small there; `None` where it is
    /// small.
    fn split(&self) -> Option<bool> {
        let [u, v] = [self.u, self.v].map(|r| r[1] - r[0] > SMALL);
        match (u, v) {
            (true, true) => Some(self.changes_along_u()),
            (true, false) => Some(true),
            (false, true) => Some(false),
            (false, false) => None,
        }
    }

    /// By all coefficients: about the least point of a linear function on a sphere its corners are alike.
    fn changes_along_u(&self) -> bool {
        let c = &self.c;
        let (mut along_u, mut along_v) = (0.0, 0.0);
        for k in 0..3 {
            along_u += (c[3 + k] - c[k]).abs() + (c[6 + k] - c[3 + k]).abs();
            along_v += (c[3 * k + 1] - c[3 * k]).abs() + (c[3 * k + 2] - c[3 * k + 1]).abs();
        }
        along_u >= along_v
    }

    /// The upper half takes its place, the lower is given.
    fn halve(&mut self, along_u: bool) -> Self {
        let mut low = *self;
        let (range, low_range) = if along_u {
            (&mut self.u, &mut low.u)
        } else {
            (&mut self.v, &mut low.v)
        };
        let middle = 0.5 * (range[0] + range[1]);
        (range[0], low_range[1]) = (middle, middle);
        low.c = part(&self.c, along_u, 0.5, false);
        self.c = part(&self.c, along_u, 0.5, true);
        low
    }
}

fn rows_raised(a: [f64; 3], b: [f64; 3]) -> Coefficients {
    let m = |k: usize| 0.5 * (a[k] + b[k]);
    [a[0], a[1], a[2], m(0), m(1), m(2), b[0], b[1], b[2]]
}

fn raised([a, b]: [f64; 2]) -> [f64; 3] {
    [a, 0.5 * (a + b), b]
}

impl Search<'_> {
    /// Whether the half-space of what is nearer than a point is wanted.
    fn wants_half_space(&self, covered: bool) -> bool {
        // What is put aside here has no bound but the best value so far: a front would keep that.
        self.goal.all_below.is_none() && (covered || !self.recording)
    }

    /// What comes as near as a sphere does that has this least squared distance, of those patches that boxes do not exclude; `None` where that is not wanted or cannot
    /// be told.
    pub(super) fn approach(
        &self,
        shell: &Shell,
        face: usize,
        least: Dd,
        covered: bool,
    ) -> Option<Approach> {
        let Objective::SquaredDistance(q) = self.objective else {
            return None;
        };
        if !self.wants_half_space(covered) {
            return None;
        }
        let b = self.brep.face_box(face)?;
        let distance = least.hi.max(0.0).sqrt();
        let distance = distance * (1.0 + LARGER) + THICKER * shell.thickness();
        let squared = distance * distance;
        let half = shell.near_half_space(q, squared, b)?;
        let geometry = self.brep.double(face);
        let mut near = ArrayVec::new();
        for index in 0..geometry.patches.len() {
            let own = geometry.patch_boxes()[index].as_ref();
            if own.is_some_and(|b| self.box_bound(b).hi > squared) {
                continue;
            }
            let (c, error) = linear(&geometry.patches[index].net, &half)?;
            if is_above(&c, error) {
                continue;
            }
            let near_patch = NearPatch {
                index,
                least: least_place(&c),
                error: (error + halving_error(&c)) * UP,
                c,
            };
            near.try_push(near_patch).ok()?;
        }
        Some(Approach { squared, near })
    }

    /// Puts those boxes in line that may hold nearer points.
    pub(super) fn push_near<T: Real + Arithmetic>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        face: usize,
        approach: &Approach,
        lo: Dd,
        covered: bool,
    ) {
        for patch in &approach.near {
            if self.hopeless(lo) {
                return;
            }
            let told = box_about(&patch.c, patch.least, patch.error);
            let Some([u, v]) = told.unwrap_or_else(|| halved(&patch.c, patch.error)) else {
                continue;
            };
            let index = patch.index;
            let source = Source::Patch { face, index };
            // Next to a pole, or where distances hardly differ, no box is small: the whole patch has better places to start from.
            let wide = [u, v].iter().any(|r| r[1] - r[0] > WIDE);
            let Some(mut node) = (!wide).then(|| self.root::<T>(source)).flatten() else {
                self.push(heap, lo, covered, Kind::Root(source));
                continue;
            };
            node.cut(u, v, self.objective.is_squared());
            if lo > node.lo {
                node.lo = lo;
            }
            self.enqueue(heap, source, false, node, covered);
        }
    }
}

/// A box that holds all of a patch that is not above `error`, by halving.
fn halved(c: &Coefficients, error: f64) -> Option<[[f64; 2]; 2]> {
    // What is left is next to one place as a rule: one box holds it.
    let mut left: Option<[[f64; 2]; 2]> = None;
    let mut stack = ArrayVec::<Linear, DEPTH>::new();
    let (u, v) = ([0.0, 1.0], [0.0, 1.0]);
    stack.push(Linear { c: *c, u, v });
    while let Some(part) = stack.last_mut() {
        if is_above(&part.c, error) {
            stack.pop();
            continue;
        }
        if let Some(along_u) = part.split() {
            let low = part.halve(along_u);
            stack.push(low);
            continue;
        }
        let hull = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        left = Some(match left {
            Some([u, v]) => [hull(u, part.u), hull(v, part.v)],
            None => [part.u, part.v],
        });
        stack.pop();
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Random(u64);

    impl Random {
        fn between(&mut self, a: f64, b: f64) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            a + (b - a) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
        }
    }

    /// Wherever a polynomial is not above the error, the box that is found holds it: bowls whose lowest place is on the patch or next to it, bent and
    /// twisted, and others.
    #[test]
    fn boxes_hold_all_that_is_near() {
        const STEPS: usize = 40;
        let mut random = Random(23);
        let (mut empty, mut about, mut other) = (0, 0, 0);
        for k in 0..4000 {
            let [u, v] = [0, 1].map(|_| random.between(-0.1, 1.1));
            let [a, b] = [0, 1].map(|_| random.between(0.3, 2.0));
            let depth = random.between(-2.0, 1.0) * 10f64.powf(random.between(-9.0, -1.0));
            // The coefficients of (t - x)^2 on [0, 1].
            let bowl = |x: f64| [x * x, x * x - x, (1.0 - x) * (1.0 - x)];
            let (along_u, along_v) = (bowl(u), bowl(v));
            let twist = if k % 3 == 0 { 0.1 } else { 1e-3 };
            let mut c: Coefficients = std::array::from_fn(|m| {
                let own = a * along_u[m / 3] + b * along_v[m % 3];
                own + twist * own * random.between(-1.0, 1.0) - depth
            });
            if k % 7 == 0 {
                c = c.map(|_| random.between(-1.0, 3.0));
            }
            let error = halving_error(&c);
            let told = box_about(&c, least_place(&c), error);
            match told {
                None => other += 1,
                Some(None) => empty += 1,
                Some(Some(_)) => about += 1,
            }
            let left = told.unwrap_or_else(|| halved(&c, error));
            // It is halved again and again: ends that are no numbers of few digits would be rounded, and the boxes not those of the coefficients.
            for mut range in left.iter().flatten().copied() {
                while range[1] - range[0] <= WIDE && range[1] - range[0] > 4.0 * f64::EPSILON {
                    let middle = 0.5 * (range[0] + range[1]);
                    assert_eq!(
                        Dd::sum(range[0], range[1]),
                        Dd::from(2.0 * middle),
                        "{left:?}"
                    );
                    range[usize::from(k % 2 == 0)] = middle;
                }
            }
            for i in 0..=STEPS {
                for j in 0..=STEPS {
                    let at = [i, j].map(|m| m as f64 / STEPS as f64);
                    let inside = left.is_some_and(|[u, v]| {
                        u[0] <= at[0] && at[0] <= u[1] && v[0] <= at[1] && at[1] <= v[1]
                    });
                    assert!(
                        inside || value(&c, at) > 0.0,
                        "{c:?}: {at:?} is not in {left:?}"
                    );
                }
            }
        }
        assert!(
            empty > 500 && about > 500 && other > 500,
            "{empty} {about} {other}"
        );
    }

    /// Halving and cutting agree with the polynomial.
    #[test]
    fn parts_are_the_polynomial_s() {
        let mut random = Random(29);
        for _ in 0..200 {
            let c: Coefficients = std::array::from_fn(|_| random.between(-1.0, 1.0));
            let [t, x, y] = [0, 1, 2].map(|_| random.between(0.0, 1.0));
            for along_u in [true, false] {
                let mut high = Linear {
                    c,
                    u: [0.0, 1.0],
                    v: [0.0, 1.0],
                };
                let low = high.halve(along_u);
                for (got, cut, above) in [
                    (part(&c, along_u, t, false), t, false),
                    (part(&c, along_u, t, true), t, true),
                    (low.c, 0.5, false),
                    (high.c, 0.5, true),
                ] {
                    let place = |x: f64| {
                        if above {
                            cut + (1.0 - cut) * x
                        } else {
                            cut * x
                        }
                    };
                    let at = if along_u {
                        [place(x), y]
                    } else {
                        [x, place(y)]
                    };
                    let off = (value(&got, [x, y]) - value(&c, at)).abs();
                    assert!(off < 32.0 * f64::EPSILON, "{off:e}");
                }
            }
        }
    }
}
