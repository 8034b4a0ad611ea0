//! A proven bound of the Frechet distance of two images of an edge.
//!
//! Both images are run through in pairs of parts, in order, `A` over `[a0, a1]` with `B` over `[b0, b1]`: a matching that
//! never turns back, so that the largest distance within a pair bounds the Frechet distance.
//!
//! What bounds the distance within a pair is in `matched`.
//!
//! The pair with the largest bound is cut where that may help: one part at its middle, the other at the nearest point.
//! For smooth curves and the second bound the loss falls with the cube of the parts' length. The end points of parts are
//! values of T, so that they lose no more than T does.

use super::image::{Image, Stretch};
use super::matched::{Factors, NEAR_SLACK, bound};
use crate::numeric::Real;
use nalgebra::Vector3;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// A bound no more than so many times what is found at matched points is good enough.
const GOOD: f64 = 1.125;
/// Cuts: as many as this much work allows, the product of two curves' coefficients for a unit; but no fewer and no more than
/// these.
const WORK: usize = 4096;
const LEAST_CUTS: usize = 8;
const MOST_CUTS: usize = 64;
/// Steps in the search of a nearest point.
const STEPS: usize = 8;
/// Of these, in the number that is wanted: the first begins within roundings of f64.
const LAST_STEPS: usize = 2;

/// The homogeneous point of a Bezier curve, about: `sum binomial(n, i) t^i (1 - t)^(n - i) p_i` with running powers, in as many steps as there are control
/// points.
fn homogeneous<T: Real>(points: &[[T; 4]], at: T) -> [T; 4] {
    let [first, others @ ..] = points else {
        return [T::ZERO; 4];
    };
    let (n, rest) = (others.len(), T::ONE - at);
    let (mut sum, mut power, mut binomial) = (*first, T::ONE, 1.0);
    for (i, p) in others.iter().enumerate() {
        power = power * at;
        binomial = binomial * (n - i) as f64 / (i + 1) as f64;
        let factor = power * T::from_f64(binomial);
        for (sum, x) in sum.iter_mut().zip(p) {
            *sum = *sum * rest + factor * *x;
        }
    }
    sum
}

/// A point of the stretch, about.
fn point<T: Real>(stretch: &Stretch<T>, at: T) -> [T; 3] {
    let p = homogeneous(&stretch.points, at);
    std::array::from_fn(|c| p[c] / p[3] + T::from_f64(stretch.origin[c]))
}

/// A stretch in f64: its control points, and the steps from each to the next, of which its derivative is made.
struct Rough {
    points: Vec<[f64; 4]>,
    steps: Vec<[f64; 4]>,
    origin: [f64; 3],
}

impl Rough {
    fn new<T: Real>(stretch: &Stretch<T>) -> Self {
        let points: Vec<[f64; 4]> = (stretch.points.iter())
            .map(|p| p.map(T::approximate))
            .collect();
        let step = |pair: &[[f64; 4]]| std::array::from_fn(|c| pair[1][c] - pair[0][c]);
        Self {
            steps: points.windows(2).map(step).collect(),
            points,
            origin: stretch.origin,
        }
    }

    fn point(&self, at: f64) -> [f64; 3] {
        let p = homogeneous(&self.points, at);
        std::array::from_fn(|c| p[c] / p[3] + self.origin[c])
    }

    fn tangent(&self, at: f64) -> Vector3<f64> {
        if self.steps.is_empty() {
            return Vector3::zeros();
        }
        let (p, d) = (homogeneous(&self.points, at), homogeneous(&self.steps, at));
        let degree = self.steps.len() as f64;
        Vector3::from_fn(|c, _| degree * (d[c] - d[3] * (p[c] / p[3])) / p[3])
    }
}

fn apart<T: Real>(a: &[T; 3], b: &[T; 3]) -> f64 {
    Vector3::from_fn(|c, _| (a[c] - b[c]).approximate()).norm()
}

/// Starts in the search of the nearest point of a whole stretch.
pub(super) const STARTS: usize = 9;

/// The parameter in `[lo, hi]` of the nearest point, about, and how far it is; nothing rests on it. Found in f64, then to more digits.
pub(super) fn foot<T: Real>(
    stretch: &Stretch<T>,
    p: &[T; 3],
    [lo, hi]: [T; 2],
    starts: usize,
) -> (T, f64) {
    let rough = Rough::new(stretch);
    let place = p.map(T::approximate);
    let range = [lo, hi].map(T::approximate);
    let mut start = (range[0], f64::INFINITY);
    for k in 0..starts {
        let s = (k as f64 + 0.5) / starts as f64;
        let at = range[0] + (range[1] - range[0]) * s;
        let off = apart(&rough.point(at), &place);
        if off < start.1 {
            start = (at, off);
        }
    }
    let (at, _) = descend(&rough, |at| rough.point(at), &place, range, start.0, STEPS);
    let at = clamped(T::from_f64(at), [lo, hi]);
    descend(&rough, |at| point(stretch, at), p, [lo, hi], at, LAST_STEPS)
}

/// The best of so many of Newton's steps towards the nearest point, and how far it is. (Tangents are those of f64: each step leaves a rounding of it.)
fn descend<T: Real>(
    rough: &Rough,
    point: impl Fn(T) -> [T; 3],
    p: &[T; 3],
    range: [T; 2],
    mut at: T,
    steps: usize,
) -> (T, f64) {
    let mut best = (range[0], f64::INFINITY);
    for step in 0..=steps {
        let x = point(at);
        let off = apart(&x, p);
        if off < best.1 {
            best = (at, off);
        }
        if step == steps {
            break;
        }
        let tangent = rough.tangent(at.approximate());
        let to = Vector3::from_fn(|c, _| (x[c] - p[c]).approximate());
        let back = to.dot(&tangent) / tangent.norm_squared();
        if !back.is_finite() {
            break;
        }
        let next = clamped(at - T::from_f64(back), range);
        if next == at {
            break;
        }
        at = next;
    }
    best
}

fn clamped<T: Real>(x: T, [lo, hi]: [T; 2]) -> T {
    if x < lo {
        lo
    } else if x > hi {
        hi
    } else {
        x
    }
}

/// A part of `A` and the part of `B` that it is matched with.
pub(super) struct Pair<T> {
    stretches: [usize; 2],
    from: [T; 2],
    to: [T; 2],
    bound: f64,
    slack: f64,
    /// Which is cut at its middle.
    turn: usize,
}

/// Bytes that [`frechet`] takes at most for two images with so many control points in a stretch, beside a pair for each stretch.
pub(super) fn frechet_bytes<T: Real>(a: usize, b: usize) -> usize {
    // Of both parts the points, the sums of their products and the differences; a foot's curve in f64 takes less.
    let pair = Factors::<T>::bytes(a, b) + 3 * (a + b) * size_of::<[T; 4]>();
    MOST_CUTS * size_of::<Pair<T>>() + pair + (a + b) * size_of::<[f64; 4]>()
}

struct Matching<'a, T> {
    images: [&'a Image<T>; 2],
    pairs: Vec<Pair<T>>,
    /// The farthest of the matched points from its nearest point: an estimate from below.
    farthest: f64,
    factors: Option<Factors<T>>,
}

impl<T: Real> Matching<'_, T> {
    fn stretch(&self, which: usize, index: usize) -> &Stretch<T> {
        &self.images[which].stretches[index]
    }

    fn add(&mut self, stretches: [usize; 2], from: [T; 2], to: [T; 2], turn: usize) -> Option<()> {
        let images = self.images;
        let both = [0, 1].map(|k| &images[k].stretches[stretches[k]]);
        let (bound, slack) = bound(both, from, to, &mut self.factors)?;
        self.pairs.push(Pair {
            stretches,
            from,
            to,
            bound,
            slack,
            turn,
        });
        Some(())
    }

    /// Matches the images stretch by stretch: that whose end is nearer to the other's stretch ends first, and is matched
    /// with it up to the nearest point.
    fn start(&mut self) -> Option<()> {
        let last = [0, 1].map(|k| self.images[k].stretches.len() - 1);
        let mut at = [0; 2];
        let mut from = [T::ZERO; 2];
        while at != last {
            let ends = [0, 1].map(|k| point(self.stretch(k, at[k]), T::ONE));
            // The nearest point of the other to the end of each.
            let feet = [0, 1].map(|k| {
                let other = self.stretch(1 - k, at[1 - k]);
                foot(other, &ends[k], [from[1 - k], T::ONE], STARTS)
            });
            let together = apart(&ends[0], &ends[1]);
            let least = feet[0].1.min(feet[1].1);
            let mut to = [T::ONE; 2];
            let next = if at[0] < last[0] && at[1] < last[1] && together <= GOOD * least {
                [true, true]
            } else if at[1] == last[1] || (at[0] < last[0] && feet[0].1 <= feet[1].1) {
                to[1] = feet[0].0;
                [true, false]
            } else {
                to[0] = feet[1].0;
                [false, true]
            };
            self.add(at, from, to, 0)?;
            for k in 0..2 {
                if next[k] {
                    at[k] += 1;
                    from[k] = T::ZERO;
                } else {
                    from[k] = to[k];
                }
            }
        }
        self.add(at, from, [T::ONE; 2], 0)
    }

    /// Cuts a pair in two.
    fn halve(&mut self, p: &Pair<T>) -> Option<()> {
        let k = p.turn;
        let middle = (p.from[k] + p.to[k]).half();
        let place = point(self.stretch(k, p.stretches[k]), middle);
        let other = self.stretch(1 - k, p.stretches[1 - k]);
        let (near, off) = foot(other, &place, [p.from[1 - k], p.to[1 - k]], 3);
        self.farthest = self.farthest.max(off);
        let mut at = [near; 2];
        at[k] = middle;
        self.add(p.stretches, p.from, at, 1 - k)?;
        self.add(p.stretches, at, p.to, 1 - k)
    }
}

/// A bound of the Frechet distance of two images, each in its direction; `None` where there is none.
pub(super) fn frechet<T: Real>(a: &Image<T>, b: &Image<T>) -> Option<f64> {
    let mut matching = Matching {
        images: [a, b],
        pairs: Vec::with_capacity(a.stretches.len() + b.stretches.len() + MOST_CUTS),
        farthest: 0.0,
        factors: None,
    };
    matching.start()?;
    // What a pair costs goes with the product of the degrees.
    let order = |image: &Image<T>| image.stretches.iter().map(|s| s.points.len()).max();
    let cost = order(a)? * order(b)?;
    let mut left = (WORK / cost).clamp(LEAST_CUTS, MOST_CUTS);
    loop {
        let pairs = &matching.pairs;
        let by_bound = |x: &usize, y: &usize| pairs[*x].bound.total_cmp(&pairs[*y].bound);
        let worst = (0..pairs.len()).max_by(by_bound)?;
        let p = &pairs[worst];
        // Nor is it cut below so many times its slack.
        let good = (GOOD * matching.farthest).max(NEAR_SLACK * p.slack);
        if left == 0 || p.bound <= good + a.extra + b.extra {
            return Some((p.bound + a.extra + b.extra) * UP);
        }
        left -= 1;
        let p = matching.pairs.swap_remove(worst);
        matching.halve(&p)?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An image of one stretch with these control points `(X, w)`.
    fn image(points: &[[f64; 4]]) -> Image<f64> {
        let mut stretch = Stretch {
            points: points.to_vec(),
            origin: [0.0; 3],
            slack: 0.0,
            bounds: Default::default(),
        };
        stretch.bounds = stretch.net().bounding_box().unwrap();
        Image {
            stretches: vec![stretch],
            extra: 0.0,
        }
    }

    /// A quarter of a circle, its parameter run through faster at one end for `c != 1`.
    fn quarter(radius: f64, height: f64, c: f64) -> Image<f64> {
        let h = c * std::f64::consts::FRAC_1_SQRT_2;
        let q = c * c;
        image(&[
            [radius, 0.0, height, 1.0],
            [h * radius, h * radius, h * height, h],
            [0.0, q * radius, q * height, q],
        ])
    }

    /// A hundred roundings of lengths about 1.
    const ROUNDING: f64 = 128.0 * f64::EPSILON;

    #[test]
    fn copies_are_apart_by_rounding_only() {
        let a = quarter(1.0, 0.0, 1.0);
        assert!(frechet(&a, &a).unwrap() <= ROUNDING);
        let back = a.clone().reversed();
        assert!(frechet(&back, &back).unwrap() <= ROUNDING);
    }

    #[test]
    fn parallel_quarters_are_as_far_apart_as_known() {
        // Beside each other, and concentric: each point has one exactly so far away, the nearest.
        let a = quarter(1.0, 0.0, 1.0);
        for (b, is) in [
            (quarter(1.0, 0.25, 1.0), 0.25),
            (quarter(1.125, 0.0, 1.0), 0.125),
        ] {
            let found = frechet(&a, &b).unwrap();
            assert!(is <= found && found <= GOOD * is + ROUNDING, "{found:e}");
        }
    }

    #[test]
    fn against_each_other_the_ends_count() {
        // The ends of a quarter are the square root of 2 apart.
        let a = quarter(1.0, 0.0, 1.0);
        let found = frechet(&a, &a.clone().reversed()).unwrap();
        assert!(found >= std::f64::consts::SQRT_2, "{found:e}");
    }

    #[test]
    fn another_parametrisation_costs_little() {
        // The same points at other parameters, up to 0.2 away at equal ones.
        let a = quarter(1.0, 0.0, 1.0);
        let shifted = frechet(&a, &quarter(1.0, 1.0 / 64.0, 1.5)).unwrap();
        assert!((1.0 / 64.0..=2.0 / 64.0).contains(&shifted), "{shifted:e}");
        assert!(frechet(&a, &quarter(1.0, 0.0, 1.5)).unwrap() <= 1.0 / 4096.0);
    }
}
