//! How far a point is from the image of a trim.
//!
//! # What is proven
//! On a part of the image let `D_i = X_i - w_i (p - o)`, `w_i > 0` be its control points relative to the point `p`. The distance from
//! `p` of each of its points is at least the height of the point along any unit vector `n`, which is a convex combination of the
//! `n.D_i / w_i`: their least is a lower bound. It loses only what the part bends, with `n` towards its middle. Both ends of
//! a part are points of the image: the lesser of their distances is an upper bound, as is that of any point, first of the one that Newton's
//! method takes for the nearest. Parts are halved until the two meet.

use super::closed::V3;
use super::image::{Image, Stretch};
use super::matching::{STARTS, foot};
use crate::numeric::bernstein::{Bidegree, greater, largest, lesser, split_error, split_off};
use crate::numeric::{Ball, Dd, TINY};
use nalgebra::Vector3;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// A lower bound of this part of the upper one is good enough.
const GOOD: f64 = 1.0 - 1.0 / 1024.0;
/// Parts are not halved more often than this, as double-double would not tell more.
const DEPTH: u32 = 100;
/// In the unit of the model; added to the errors of lengths. A shorter vector may have squares that underflow, and no computed length at
/// all: then this is more than its length. Of a longer one the squares' sum is above 1e-280, and what underflows in it far below a rounding.
const LEAST_LENGTH: f64 = 1e-140;
/// Nor are there more of them than this; what is left open keeps its lower bound.
const PARTS: usize = 1024;

/// Part of a curve relative to a point: coefficients of `D` and `w`, each off by `error` at most.
struct Part {
    c: [Vec<Dd>; 4],
    error: [f64; 4],
    depth: u32,
}

impl Part {
    fn new(stretch: &Stretch<Dd>, p: &V3) -> Self {
        let shift: V3 = std::array::from_fn(|c| Ball::exact(stretch.origin[c]) - p[c]);
        let mut error = [0.0; 4];
        let c = std::array::from_fn(|c| {
            let values = stretch.points.iter().map(|x| {
                if c == 3 {
                    return x[3];
                }
                let known = |mid| Ball { mid, rad: 0.0 };
                let d = known(x[c]) + shift[c] * known(x[3]);
                error[c] = greater(error[c], d.rad);
                d.mid
            });
            values.collect()
        });
        Self { c, error, depth: 0 }
    }

    fn degree(&self) -> usize {
        self.c[0].len() - 1
    }

    /// How far it is, about.
    fn about(&self) -> f64 {
        let i = self.c[0].len() / 2;
        Vector3::from_fn(|c, _| self.c[c][i].hi / self.c[3][i].hi).norm()
    }

    /// Bounds of the distance of its nearest point.
    fn bounds(&self) -> [f64; 2] {
        let count = self.c[0].len();
        let at = |i: usize| Vector3::from_fn(|c, _| self.c[c][i].hi);
        // By how much a vector, rounded, may be off.
        let error: f64 = self.error[..3].iter().sum::<f64>();
        let weight = |i: usize| {
            let w = self.c[3][i].hi;
            let off = self.error[3] + f64::EPSILON * w;
            [w - off, w + off]
        };
        let middle = (at(0) / weight(0)[1] + at(count - 1) / weight(count - 1)[1]) * 0.5;
        let n = middle / middle.norm();
        let (mut least, mut most) = (f64::INFINITY, f64::INFINITY);
        for i in 0..count {
            let (d, [low, high]) = (at(i), weight(i));
            if !(low > 0.0) {
                return [0.0, f64::INFINITY];
            }
            // A dozen roundings of numbers no larger than |d|, whose squares may underflow.
            let off = error + 16.0 * f64::EPSILON * d.norm() + LEAST_LENGTH;
            let height = (n.dot(&d) - off) / high;
            least = if height > 0.0 {
                lesser(least, height)
            } else {
                0.0
            };
            if i == 0 || i + 1 == count {
                most = lesser(most, (d.norm() + off) / low * UP);
            }
        }
        // `n` is of length one up to a few roundings; where it is none at all the heights are no numbers.
        let least = if least.is_finite() { least / UP } else { 0.0 };
        [least, most]
    }

    fn halves(mut self) -> [Self; 2] {
        let degree = Bidegree {
            u: self.degree(),
            v: 0,
        };
        let mut high = Self {
            c: Default::default(),
            error: self.error,
            depth: self.depth + 1,
        };
        self.depth += 1;
        for k in 0..4 {
            let e = self.error[k] + split_error::<Dd>(degree, true, largest(&self.c[k]), TINY);
            high.c[k] = split_off(&mut self.c[k], degree, true);
            (self.error[k], high.error[k]) = (e * UP, e * UP);
        }
        [self, high]
    }
}

/// How far a point of a stretch is at most that is about the nearest.
fn apart_at_foot(stretch: &Stretch<Dd>, p: &V3) -> f64 {
    let middle = p.each_ref().map(|x| x.mid);
    let (at, _) = foot(stretch, &middle, [Dd::ZERO, Dd::ONE], STARTS);
    let x = stretch.point(at);
    let off = Vector3::from_fn(|c, _| (x[c] - p[c]).magnitude() + LEAST_LENGTH);
    off.norm() * UP
}

/// Bounds of the distance of a point from an image.
///
/// No closer than is needed to tell whether it is farther than `far`, or no farther than `near` or twice what the image is off by; those
/// aside, the lower bound is a part [`GOOD`] of the upper one, as far as double-double and [`PARTS`] parts can tell.
pub(crate) fn distance(p: &V3, image: &Image<Dd>, near: f64, far: f64) -> [f64; 2] {
    let slack = |s: &Stretch<Dd>| (s.slack + image.extra) * UP;
    let mut stretches: Vec<(f64, &Stretch<Dd>, Part)> = (image.stretches.iter())
        .map(|s| {
            let part = Part::new(s, p);
            (part.about(), s, part)
        })
        .collect();
    // What is nearer is looked at first: the rest is put aside without being halved as a rule.
    stretches.sort_by(|(a, ..), (b, ..)| b.total_cmp(a));
    let (mut least, mut most) = (f64::INFINITY, f64::INFINITY);
    if let Some((_, s, _)) = stretches.last() {
        most = apart_at_foot(s, p) + slack(s);
        if most <= near.max(2.0 * slack(s)) {
            return [0.0, most];
        }
    }
    let parts = stretches.into_iter();
    let mut stack: Vec<(Part, f64)> = parts.map(|(_, s, part)| (part, slack(s))).collect();
    let mut parts = 0;
    while let Some((part, slack)) = stack.pop() {
        let [low, high] = part.bounds();
        let (low, high) = ((low - slack).max(0.0), (high + slack) * UP);
        most = lesser(most, high);
        // What is within the noise of the curves is as near as can be told.
        if most <= near.max(2.0 * slack) {
            return [0.0, most];
        }
        parts += 1;
        if low > far || low >= GOOD * most || part.depth >= DEPTH || parts > PARTS {
            least = lesser(least, low);
            continue;
        }
        let [a, b] = part.halves();
        if a.about() <= b.about() {
            stack.push((b, slack));
            stack.push((a, slack));
        } else {
            stack.push((a, slack));
            stack.push((b, slack));
        }
    }
    [lesser(least, most), most]
}
