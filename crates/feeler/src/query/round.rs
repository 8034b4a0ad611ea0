//! Which boxes of the patches of a sphere a nearer point can be in.
//!
//! # What is proven
//! On a surface that is a sphere up to the thickness of its [shell](crate::prepare::Shell), all points nearer to a ball's centre than one
//! that is known are in a [half-space](crate::prepare::Shell::near_half_space): squared distances are linear there but for what the shell allows. A linear
//! function on a patch is a quotient with the patch's own weights, of half the degree that a squared distance has and a third of its
//! coefficients: where it is above the half-space's offset for all coefficients of a box (they are averages of the patch's, and
//! weights are positive), no point of the box is nearer. Boxes are halved until that is so or until they are small; one box about those that are left is searched.
//!
//! Nothing is said of how small the rest is: a box that the half-space does not tell is searched like any other.

use super::objective::Objective;
use super::outcome::Source;
use super::search::Search;
use super::task::{Arithmetic, Kind, Task};
use crate::numeric::bernstein::greater;
use crate::numeric::{Dd, Real, TINY};
use crate::prepare::{NearHalfSpace, Net};
use arrayvec::ArrayVec;
use nalgebra::Point3;
use std::collections::BinaryHeap;

/// Boxes this wide or narrower, in local parameters, are not halved.
const SMALL: f64 = 1.0 / 8.0;
/// Patches of which a box wider than this is left are searched like any other.
const WIDE: f64 = 0.5;
/// Boxes that wait: halving down to small ones leaves one at each step, four along either side.
const DEPTH: usize = 10;
/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 32.0 * f64::EPSILON;

/// Coefficients of `n.(X - o w) - t w` over a box, and a bound on the error of each: of second degree, as exact round patches have it, or raised
/// to it.
#[derive(Clone, Copy)]
struct Linear {
    c: [[f64; 3]; 3],
    error: f64,
    /// What halving adds to that: two roundings of a mean. No mean is larger than the largest of all.
    step: f64,
    u: [f64; 2],
    v: [f64; 2],
}

impl Linear {
    /// `None` for patches of higher degrees: they are searched like any other.
    fn new(net: &Net<f64>, half: &NearHalfSpace) -> Option<Self> {
        let (du, dv) = (net.degree.u, net.degree.v);
        if !(1..=2).contains(&du) || !(1..=2).contains(&dv) {
            return None;
        }
        let n = &half.normal;
        let from = Point3::from(net.origin) - half.origin;
        let shift = n.dot(&from) - half.offset;
        let value = |i: usize, j: usize| {
            let p = &net.points[i * (dv + 1) + j];
            n[0] * p[0].mid + n[1] * p[1].mid + n[2] * p[2].mid + shift * p[3].mid
        };
        let row = |i: usize| match dv {
            1 => raised([value(i, 0), value(i, 1)]),
            _ => [value(i, 0), value(i, 1), value(i, 2)],
        };
        let c = match du {
            1 => {
                let ends = [row(0), row(1)];
                let middle = [0, 1, 2].map(|j| 0.5 * (ends[0][j] + ends[1][j]));
                [ends[0], middle, ends[1]]
            }
            _ => [row(0), row(1), row(2)],
        };
        // Differences, products and sums of `shift` are off by four roundings of its parts, values by as many of theirs, means by one more.
        // (Sums of magnitudes: squares of the least would be lost.)
        let parts = n.lp_norm(1) * from.lp_norm(1) + half.offset.abs();
        let mut error = 8.0 * f64::EPSILON * parts * net.largest[3] + parts * net.spread[3];
        for k in 0..3 {
            error += n[k].abs() * (8.0 * f64::EPSILON * net.largest[k] + net.spread[k]);
        }
        let most = c.as_flattened().iter();
        let most = most.fold(0.0, |m, x| greater(m, x.abs()));
        Some(Self {
            c,
            error: (error + TINY) * UP,
            step: (4.0 * f64::EPSILON * most + TINY) * UP,
            u: [0.0, 1.0],
            v: [0.0, 1.0],
        })
    }

    fn is_above(&self) -> bool {
        self.c.as_flattened().iter().all(|c| *c > self.error)
    }

    /// Along which of u and v (u: true) it is to be halved: where it changes more, as far as it is not small there; `None` where it is
    /// small.
    fn split(&self) -> Option<bool> {
        // By all coefficients: about the least point of a linear function on a sphere its corners are alike.
        let c = &self.c;
        let (mut along_u, mut along_v) = (0.0, 0.0);
        for i in 0..3 {
            along_u += (c[1][i] - c[0][i]).abs() + (c[2][i] - c[1][i]).abs();
            along_v += (c[i][1] - c[i][0]).abs() + (c[i][2] - c[i][1]).abs();
        }
        let [u, v] = [self.u, self.v].map(|r| r[1] - r[0] > SMALL);
        match (u, v) {
            (true, true) => Some(along_u >= along_v),
            (true, false) => Some(true),
            (false, true) => Some(false),
            (false, false) => None,
        }
    }

    /// Two means, one of the other's, for each of three coefficients.
    fn halves(mut self, along_u: bool) -> [Self; 2] {
        self.error = (self.error + self.step) * UP;
        let mut high = self;
        if along_u {
            for j in 0..3 {
                let [low, up] = parted([self.c[0][j], self.c[1][j], self.c[2][j]]);
                for i in 0..3 {
                    (self.c[i][j], high.c[i][j]) = (low[i], up[i]);
                }
            }
            let middle = 0.5 * (self.u[0] + self.u[1]);
            (self.u[1], high.u[0]) = (middle, middle);
        } else {
            for i in 0..3 {
                [self.c[i], high.c[i]] = parted(self.c[i]);
            }
            let middle = 0.5 * (self.v[0] + self.v[1]);
            (self.v[1], high.v[0]) = (middle, middle);
        }
        [self, high]
    }
}

fn raised([a, b]: [f64; 2]) -> [f64; 3] {
    [a, 0.5 * (a + b), b]
}

fn parted([a, b, c]: [f64; 3]) -> [[f64; 3]; 2] {
    let (p, q) = (0.5 * (a + b), 0.5 * (b + c));
    let m = 0.5 * (p + q);
    [[a, p, m], [m, q, c]]
}

impl Search<'_> {
    /// The half-space that holds what is nearer than the best point so far on a face, where that is wanted and can be told.
    pub(super) fn near_half_space(&self, face: usize, covered: bool) -> Option<NearHalfSpace> {
        let Objective::SquaredDistance(q) = self.objective else {
            return None;
        };
        // What is put aside here has no bound but the best value so far: a front would keep that.
        if self.goal.all_below.is_some() || (self.recording && !covered) {
            return None;
        }
        let shell = self.brep.shell(face)?;
        let b = self.brep.face_box(face)?;
        let squared = self.out.hi.ceil_f64();
        squared.is_finite().then_some(())?;
        shell.near_half_space(q, squared, b)
    }

    /// Puts those boxes of a patch in line that a half-space does not exclude.
    pub(super) fn push_boxes_in<T: Real + Arithmetic>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        (face, index): (usize, usize),
        half: &NearHalfSpace,
        lo: Dd,
        covered: bool,
    ) {
        if self.hopeless(lo) {
            return;
        }
        // What is left is next to one place as a rule: one box holds it.
        let mut left: Option<[[f64; 2]; 2]> = None;
        let source = Source::Patch { face, index };
        let Some(whole) = Linear::new(&self.brep.double(face).patches[index].net, half) else {
            return self.push(heap, lo, covered, Kind::Root(source));
        };
        let mut stack = ArrayVec::<Linear, DEPTH>::new();
        stack.push(whole);
        while let Some(part) = stack.pop() {
            if part.is_above() {
                continue;
            }
            if let Some(along_u) = part.split() {
                stack.extend(part.halves(along_u));
                continue;
            }
            let hull = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
            left = Some(match left {
                Some([u, v]) => [hull(u, part.u), hull(v, part.v)],
                None => [part.u, part.v],
            });
        }
        let Some([u, v]) = left else {
            return;
        };
        // Next to a pole, or where distances hardly differ, no box is small: the whole patch has better places to start from.
        let wide = [u, v].iter().any(|r| r[1] - r[0] > WIDE);
        let Some(mut node) = (!wide).then(|| self.root::<T>(source)).flatten() else {
            return self.push(heap, lo, covered, Kind::Root(source));
        };
        node.cut(u, v, self.objective.is_squared());
        if lo > node.lo {
            node.lo = lo;
        }
        self.enqueue(heap, source, false, node, covered);
    }
}
