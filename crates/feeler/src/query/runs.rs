//! Which part of a line is in the crack by one image of an edge, however long that is: by how the distance from the line changes along the image.
//!
//! # What is proven
//! Let `c(s)` be the image, continuous, within `slack` of the stretches' curve `e(s)`; `a(s)` and `b(s)` their distances from the line, so `|a - b| <= slack`; and `p(s)` the
//! projection of `c(s)` to the line. The width `d` is in `[least, most]`. What is in the crack by `c(s)` is the interval of points no farther than the root of `d^2 - a^2`
//! from `p(s)`, if `a <= d`. It changes continuously with `s`: by a part of the image all of which is within `d` it is one interval.
//!
//! The image is halved into parts until each is *off* (farther than `most`), *sure* (all within `least`), or *monotone* (`b` falls or rises along all of it). A *run* is the
//! parts from one that is off to the next. It is *plain* if first `b` falls, then parts are sure, then `b` rises: each may be missing, but not the sure ones. Of a plain run
//! what is in the crack is part of one passage, whatever `d` is. For what is by its sure parts is one interval. Let `s_1 < s_2` be beyond these, with `a(s_2) <= d` and `a > d`
//! at `s_1`, the first such place. Then `b(s_1) >= d - slack`, `b(s_2) <= d + slack`. Where stretches meet `e` leaps, by no more than twice the slack, and `b` may fall by that; with `n` stretches there are
//! `n - 1` such places, so `b` rises from `s_1` to `s_2` by no more than `2 n slack` in all. On a part where `b' >= r` and the projection of `e` moves with a speed of no more than `v` it moves by no more than
//! `v / r` times that rise, and where stretches meet by `2 (n - 1) slack` in all; at `s_1` and `s_2` it is within the slack of that of `c`.
//! Where all this, `2 n slack (v / r + 1)`, is no more than an eighth of `least` ([`NEXT`]), `p(s_2)` is next to what is in the crack before it. The same where `b` falls, from the other end.
//!
//! A sure part whose points are within `a <= least` has in the crack all that is within the root of `least^2 - a^2` of its projection. Runs of one group are one passage if what is so sure of each is no farther
//! than `least` from what is sure of the next. The ends of sure parts tell: with places of a run up to `x` or beyond and down to `y` or before, and runs in order of `y`, one is no farther from those
//! before than `y` is beyond the largest `x`. A run that is not plain, or of which nothing is sure, takes no part in that if all of it projects to between the least `y` and the largest `x`, or next to it by no
//! more than `least`: what is in the crack by it has the projection of one of its points, which is no farther than that from something sure.
//!
//! The distance is the length of the three coordinates `l` of the cross product of the direction with `c - o` over that of the direction; so `b b' |d|^2` is the sum of the products `l l'`.

use super::forms::{Forms, Stabber, range, slope_range};
use super::passages::{DEPTH, Place, above, below, widened};
use crate::numeric::{Ball, Dd};
use crate::prepare::Image;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// What is next to something is no farther from it than this part of `least`.
const NEXT: f64 = 1.0 / 8.0;
/// A part that is shorter than this part of the width is left as it is: it is where the distance is least, between the bounds of the width.
const SHORTEST: f64 = 1.0 / 1024.0;

/// Parts of an image that follow each other, none of which is off.
pub(super) struct Run {
    pub(super) image: usize,
    /// Holds the projections of all.
    pub(super) t: [Dd; 2],
    /// Some of what is surely in the crack is no later than the first, some no earlier than the second.
    pub(super) sure: Option<[Dd; 2]>,
    /// Whether it is plain, where something is sure.
    pub(super) plain: bool,
    past: Way,
}

/// How far a part of an image is from the line.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Way {
    Falls,
    Sure,
    Rises,
}

impl Run {
    /// The next part: its projection, those of its ends, and how far from these all is in the crack, if it is sure.
    fn take(&mut self, way: Option<Way>, t: [Dd; 2], ends: Option<[[Dd; 2]; 2]>, about: Dd) {
        self.plain &= way.is_some_and(|way| way >= self.past);
        self.past = way.unwrap_or(self.past);
        self.t = [lesser(self.t[0], t[0]), greater(self.t[1], t[1])];
        for [low, high] in ends.iter().flatten().filter(|_| way == Some(Way::Sure)) {
            let (first, last) = (*high - about, *low + about);
            let [least, most] = self.sure.unwrap_or([first, last]);
            self.sure = Some([lesser(least, first), greater(most, last)]);
        }
    }
}

fn lesser(a: Dd, b: Dd) -> Dd {
    if b < a { b } else { a }
}

fn greater(a: Dd, b: Dd) -> Dd {
    if b > a { b } else { a }
}

/// The runs of an image near a line; `None` where the budget does not suffice. `scale` is parameters for a unit of length.
pub(super) fn runs(
    stab: &Stabber,
    (index, image): (usize, &Image<Dd>),
    [least, most]: [f64; 2],
    scale: f64,
    budget: &mut usize,
) -> Option<Vec<Run>> {
    let slack = |s: f64| (s + image.extra) * UP;
    let stretches = image.stretches.iter();
    let widest = stretches.fold(0.0, |m: f64, s| m.max(slack(s.slack)));
    let leaps = 2.0 * image.stretches.len() as f64 * widest * UP;
    let shortest = widest.max(SHORTEST * least.max(SHORTEST * most));
    let mut out = Vec::new();
    let mut run: Option<Run> = None;
    for s in &image.stretches {
        let mut stack = vec![(stab.forms(&s.net()), 0)];
        while let Some((node, depth)) = stack.pop() {
            let place = Place::new(stab, &node)?;
            if place.away[0] > (most + widest) * UP {
                out.extend(run.take());
                continue;
            }
            let way = if (place.away[1] + widest) * UP <= least {
                Some(Way::Sure)
            } else {
                monotone(stab, &node, &place, leaps, least)
            };
            if way.is_none() && depth < DEPTH && place.length > shortest {
                *budget = budget.checked_sub(1)?;
                let [low, high] = node.halves(true);
                stack.push((high, depth + 1));
                stack.push((low, depth + 1));
                continue;
            }
            let by = widest * scale;
            let moved = |t: [Dd; 2]| [below(t[0], by), above(t[1], by)];
            let t = moved(place.t);
            let ends = end_parameters(stab, &node).map(|ends| ends.map(moved));
            let run = run.get_or_insert(Run {
                image: index,
                t,
                sure: None,
                plain: true,
                past: Way::Falls,
            });
            let away = (place.away[1] + widest) * UP;
            let about = ((least - away).max(0.0) * (least + away)).sqrt()
                / (stab.direction.norm() * UP * UP);
            run.take(way, t, ends, Dd::from(about));
        }
    }
    out.extend(run);
    Some(out)
}

/// Whether the distance from the line falls or rises along a part, fast enough for what the image may be off: `leaps` in all, of the distance and along the line; see the module.
fn monotone(
    stab: &Stabber,
    node: &Forms<Dd>,
    place: &Place,
    leaps: f64,
    least: f64,
) -> Option<Way> {
    let w = range(&node.c[3], node.error[3]);
    let slope = |k: usize| slope_range(&node.c[k], node.degree, true, node.error[k]);
    let dw = slope(3);
    // Of `L / w`, given its range.
    let quotient = |k: usize, value: [f64; 2]| {
        let top = sum(slope(k), times(value, [-dw[1], -dw[0]]));
        widened(times(top, [1.0 / w[1], 1.0 / w[0]]))
    };
    let (a, b, c) = (stab.axis, (stab.axis + 1) % 3, (stab.axis + 2) % 3);
    let d = stab.direction;
    let [p, q] = [0, 1].map(|k| quotient(k, place.across[k]));
    let third = sum(by(q, d[b] / d[a]), by(p, -d[c] / d[a]));
    let products = [p, q, third].into_iter().zip(place.across);
    let change = products.fold([0.0; 2], |s, (slope, value)| sum(s, times(slope, value)));
    let (way, least_change) = if change[0] > 0.0 {
        (Way::Rises, change[0])
    } else if change[1] < 0.0 {
        (Way::Falls, -change[1])
    } else {
        return None;
    };
    // Speeds along the line and of the distance.
    let square = d.norm_squared();
    let heights = range(&node.c[2], node.error[2]);
    let height = widened(times(heights, [1.0 / w[1], 1.0 / w[0]]));
    let along = sum(
        by(quotient(2, height), 1.0 / d[a]),
        sum(by(p, d[b] / (d[a] * square)), by(q, d[c] / (d[a] * square))),
    );
    let speed = along[0].abs().max(along[1].abs()) * square.sqrt() * UP;
    let rate = least_change / (place.away[1] * square) / UP;
    let off = leaps * (speed / rate + 1.0) * UP;
    // What is not a number tells nothing.
    (off <= NEXT * least).then_some(way)
}

/// Holds the projections of both ends of a part.
fn end_parameters(stab: &Stabber, node: &Forms<Dd>) -> Option<[[Dd; 2]; 2]> {
    let (a, b, c) = (stab.axis, (stab.axis + 1) % 3, (stab.axis + 2) % 3);
    let d = [0, 1, 2].map(|k| Ball::<Dd>::exact(stab.direction[k]));
    let square = d[a] * d[a] + d[b] * d[b] + d[c] * d[c];
    let last = node.c[3].len() - 1;
    let at = |i: usize| -> Option<[Dd; 2]> {
        let value = |k: usize| Ball {
            mid: node.c[k][i],
            rad: node.error[k],
        };
        let planes = (d[b] * value(0) + d[c] * value(1)) / square;
        let t = (value(2) + planes) / value(3) / d[a];
        t.rad
            .is_finite()
            .then(|| [below(t.mid, t.rad), above(t.mid, t.rad)])
    };
    Some([at(0)?, at(last)?])
}

/// Whether all that is in the crack by the runs is one passage; `gap` is no more than `least`, as parameters.
pub(super) fn is_one(runs: &[Run], gap: Dd) -> bool {
    let mut sure: Vec<[Dd; 2]> = runs
        .iter()
        .filter_map(|r| r.sure.filter(|_| r.plain))
        .collect();
    sure.sort_by(|a, b| a[0].partial_cmp(&b[0]).unwrap_or(std::cmp::Ordering::Equal));
    let Some([first, mut end]) = sure.first().copied() else {
        return false;
    };
    let linked = sure.iter().all(|[low, high]| {
        let near = *low <= end + gap && first <= *high + gap;
        end = greater(end, *high);
        near
    });
    let takes_part = |r: &Run| r.plain && r.sure.is_some();
    let within = |r: &Run| first <= r.t[0] + gap && r.t[1] <= end + gap;
    linked && runs.iter().all(|r| takes_part(r) || within(r))
}

fn sum(x: [f64; 2], y: [f64; 2]) -> [f64; 2] {
    widened([x[0] + y[0], x[1] + y[1]])
}

fn by(x: [f64; 2], f: f64) -> [f64; 2] {
    times(x, [f, f])
}

fn times(x: [f64; 2], y: [f64; 2]) -> [f64; 2] {
    let all = [x[0] * y[0], x[0] * y[1], x[1] * y[0], x[1] * y[1]];
    let low = all.iter().fold(f64::INFINITY, |m, x| m.min(*x));
    let high = all.iter().fold(f64::NEG_INFINITY, |m, x| m.max(*x));
    widened([low, high])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::Stretch;
    use crate::query::{LineKind, LineProbe};
    use nalgebra::{Point3, Vector3};

    /// About how wide cracks are: so narrow against the parabolas that these are flat where they matter.
    const WIDTH: f64 = 1e-4;

    /// The parabola `(x, lift + bend (x - at)^2, 0)` for `x` from -1 to 1, as an image.
    #[derive(Clone, Copy)]
    struct Parabola {
        at: f64,
        lift: f64,
        bend: f64,
    }

    impl Parabola {
        fn image(&self) -> Image<Dd> {
            let height = |x: f64| self.lift + self.bend * (x - self.at).powi(2);
            let middle = self.lift + self.bend * (self.at * self.at - 1.0);
            let points = [[-1.0, height(-1.0)], [0.0, middle], [1.0, height(1.0)]];
            let stretch = Stretch {
                points: points.map(|[x, y]| [x, y, 0.0, 1.0].map(Dd::from)).to_vec(),
                origin: [0.0; 3],
                slack: 0.0,
                bounds: [[-10.0, 10.0]; 3],
            };
            Image {
                stretches: vec![stretch],
                extra: 0.0,
            }
        }

        /// How far `(t, 0, 0)` is, as flat as it is: the angle of its tangents is below a thousandth.
        fn away(&self, t: f64) -> f64 {
            let x = t.clamp(-1.0, 1.0);
            (self.lift + self.bend * (x - self.at).powi(2)).hypot(t - x)
        }
    }

    /// How many passages there are by these, for a width: samples are closer by far than the width.
    fn passages(all: &[Parabola], d: f64, around: f64, step: f64) -> usize {
        let count = (2.0 * around / step) as usize;
        let held = (0..=count).map(|i| step * i as f64 - around);
        let held = held.filter(|t| all.iter().any(|p| p.away(*t).abs() <= d));
        let (mut passages, mut last) = (0, f64::NEG_INFINITY);
        for t in held {
            passages += usize::from(t - last > d);
            last = t;
        }
        passages
    }

    /// Where a group of runs is said to be one passage it is, for all widths between the bounds; and that is said of all tangents but
    /// those whose number of passages hangs on the width, or is two.
    #[test]
    fn one_is_one() {
        let line = LineProbe::new(Point3::origin(), Vector3::x(), LineKind::Line);
        let stab = Stabber::new(&line.unwrap());
        let (mut told, mut two) = (0, 0);
        for n in 0..600u32 {
            let unit = |k: u32| f64::from((n * 7 + k * 13 + n * n * k) % 101) / 101.0;
            let most = WIDTH * (0.5 + unit(1));
            let least = most * (0.8 + 0.2 * unit(2));
            let one = |k: u32| Parabola {
                at: 0.05 * unit(k) - 0.025,
                lift: most * (2.6 * unit(k + 1) - 1.6),
                bend: 0.2 + 0.3 * unit(k + 2),
            };
            let mut all = vec![one(3)];
            if n % 2 == 1 {
                all.push(one(6));
            }
            let mut found = Vec::new();
            for (i, p) in all.iter().enumerate() {
                let found_here = runs(&stab, (i, &p.image()), [least, most], UP, &mut 10_000);
                found.extend(found_here.unwrap());
            }
            let said = is_one(&found, Dd::from(least));
            let counts = [0.0, 0.3, 0.7, 1.0].map(|x| {
                let d = least + x * (most - least);
                passages(&all, d, 0.05, 0.1 * least)
            });
            if said {
                assert_eq!(counts, [1; 4], "{n}");
            }
            if let [p] = all[..] {
                // All of what is within the width is next to the vertex.
                let plain = p.lift <= 0.99 * least && p.lift >= -0.99 * least;
                assert!(said || !plain, "{n}");
            }
            told += usize::from(said);
            two += usize::from(counts.iter().any(|c| *c > 1));
        }
        assert!(told > 150 && two > 40, "{told} {two}");
    }

    /// Stretches straight away from the line, each a little farther along it than the one before, though none by more than twice the slack: the image, no farther than that
    /// from them, may leave the crack on the first and come back on the last, four widths from there.
    #[test]
    fn stretches_that_do_not_meet_are_passed_one_by_one() {
        let line = LineProbe::new(Point3::origin(), Vector3::x(), LineKind::Line);
        let stab = Stabber::new(&line.unwrap());
        let slack = 0.05;
        let stretch = |x: f64, y: [f64; 2]| Stretch {
            points: y.map(|y| [x, y, 0.0, 1.0].map(Dd::from)).to_vec(),
            origin: [0.0; 3],
            slack,
            bounds: [[-10.0, 10.0]; 3],
        };
        let height = |i: usize| 0.95 + 0.0025 * i as f64;
        let away = (0..40).map(|i| stretch(1.9 * slack * i as f64, [i, i + 1].map(height)));
        let image = Image {
            stretches: std::iter::once(stretch(0.0, [0.0, 0.94]))
                .chain(away)
                .collect(),
            extra: 0.0,
        };
        let found = runs(&stab, (0, &image), [1.0; 2], UP, &mut 10_000).unwrap();
        assert!(!is_one(&found, Dd::from(1.0)));
    }
}
