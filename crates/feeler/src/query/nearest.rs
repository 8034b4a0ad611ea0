//! Where a curve, as a trim in space, comes nearest to a point: of use for which contacts there are and how they are named. No separation rests on it.

use super::local::{on_trim, point};
use super::search::least_squared;
use crate::prepare::trim_boxes::{BENT, SAMPLES};
use crate::prepare::{Box3, PreparedBrep};
use nalgebra::{Point, Point3};

/// How near what a trim is in space comes to a point, and where on the trim, from 0 to 1, roughly; `None` where it does not come within so much.
pub(super) fn nearest_on(
    brep: &PreparedBrep,
    trim: usize,
    to: &Point3<f64>,
    within: f64,
) -> Option<(f64, f64)> {
    /// Room for roundings: a box may be a point.
    const DOWN: f64 = 1.0 - 1.0 / (1u64 << 40) as f64;
    let curve = |s: f64| point(brep, on_trim(brep, trim, s));
    let boxes = brep.trim_boxes(trim, curve);
    let mut limit = within;
    // What is told as nearer than this is within the limit.
    let unknown = |limit: f64| (limit.next_up(), 0.0);
    let count = boxes.count();
    let reaches = |b: &Box3, limit: f64| least_squared(b, to).sqrt() * DOWN <= limit;
    if count > 1 {
        // What is no nearer than a place in the nearest box need not be looked at.
        let after = |best: Option<(usize, f64)>| {
            let nearer = |b: &Box3| best.is_none_or(|(_, than)| least_squared(b, to) < than);
            let from = best.map_or(0, |(k, _)| k + 1);
            let (k, own) = boxes.next(from, |b| reaches(b, within) && nearer(b))?;
            Some((k, least_squared(own, to)))
        };
        let (first, _) = std::iter::successors(after(None), |b| after(Some(*b))).last()?;
        let mut nearest = unknown(within);
        narrow_part(curve, (first, count), to, &mut nearest);
        limit = limit.min(nearest.0);
    }
    let mut nearest = unknown(limit);
    let mut next = 0;
    while let Some((k, _)) = boxes.next(next, |b| reaches(b, limit)) {
        narrow_part(curve, (k, count), to, &mut nearest);
        next = k + 1;
    }
    (nearest.0 <= limit && nearest.0 < f64::INFINITY).then_some(nearest)
}

/// Where that is nearest.
pub(super) fn nearest_place(brep: &PreparedBrep, trim: usize, to: &Point3<f64>) -> f64 {
    nearest_on(brep, trim, to, f64::INFINITY).map_or(0.0, |(_, s)| s)
}

/// Where what a trim is in space comes nearest to a point, from a place on it on.
pub(super) fn nearest_from(brep: &PreparedBrep, trim: usize, to: &Point3<f64>, from: f64) -> f64 {
    let curve = |s: f64| point(brep, on_trim(brep, trim, s));
    let part = 1.0 / SAMPLES as f64;
    let beside = if from < 0.5 { from + part } else { from - part };
    let speed = (curve(beside) - curve(from)).norm() / part;
    descend(|s| (curve(s) - to).norm_squared(), from, speed).1
}

/// How near a curve over [0, 1] comes to a point, and where, roughly: what is nearest among samples and their neighbours, each
/// narrowed down. (On a closed curve both ends may be near a point, and one of them is the wrong one.)
pub(super) fn nearest<const D: usize>(
    curve: impl Fn(f64) -> Point<f64, D>,
    to: &Point<f64, D>,
) -> (f64, f64) {
    let mut all = (f64::INFINITY, 0.0);
    narrow(curve, to, &mut all);
    all
}

/// The same of a curve over a trim, from its start to its end.
pub(super) fn nearest_along<const D: usize>(
    brep: &PreparedBrep,
    trim: usize,
    curve: impl Fn(f64) -> Point<f64, D>,
    to: &Point<f64, D>,
) -> (f64, f64) {
    let count = brep.trim_parts(trim);
    let mut best = (f64::INFINITY, 0.0);
    for k in 0..count {
        narrow_part(&curve, (k, count), to, &mut best);
    }
    best
}

/// What is nearer on a part of a curve, one of so many, than what is known so far.
fn narrow_part<const D: usize>(
    curve: impl Fn(f64) -> Point<f64, D>,
    (k, count): (usize, usize),
    to: &Point<f64, D>,
    best: &mut (f64, f64),
) {
    let at = |s: f64| (k as f64 + s) / count as f64;
    let before = best.0;
    narrow(|s| curve(at(s)), to, best);
    if best.0 < before {
        best.1 = at(best.1);
    }
}

/// What is nearer than what is known so far.
fn narrow<const D: usize>(
    curve: impl Fn(f64) -> Point<f64, D>,
    to: &Point<f64, D>,
    all: &mut (f64, f64),
) {
    // What is nearer than that is not told from a point on the curve.
    let told = 4.0 * f64::EPSILON * to.coords.norm();
    // A foot is often at an end.
    for s in [0.0, 1.0] {
        let away = (curve(s) - to).norm();
        if away < all.0 {
            *all = (away, s);
        }
        if away <= told {
            return;
        }
    }
    let at = |k: usize| k as f64 / SAMPLES as f64;
    let points: [_; SAMPLES + 1] = std::array::from_fn(|k| curve(at(k)));
    let away = points.map(|p| (p - to).norm());
    let chord = |k: usize, other: usize| (points[k] - points[other]).norm();
    let last = |k: usize| (k + 1).min(SAMPLES);
    let is_least = |k: usize| {
        let around = &away[k.saturating_sub(1)..=last(k)];
        !around.iter().any(|v| *v < away[k])
    };
    // It may pass between two samples where there is a kink, from which the way falls to the other side.
    let may_pass = |k: usize, other: usize| away[k] + away[other] <= BENT * chord(k, other);
    let first = (1..=SAMPLES).fold(0, |a, b| if away[b] < away[a] { b } else { a });
    let others = (0..=SAMPLES).filter(|k| *k != first);
    for k in [first].into_iter().chain(others) {
        let is_far = |other: usize| away[k] - BENT * chord(k, other) > all.0;
        let (before, after) = (k.saturating_sub(1), last(k));
        if away[k] > all.0 && is_far(before) && is_far(after) {
            continue;
        }
        if !(is_least(k) || may_pass(k, before) || may_pass(k, after)) {
            continue;
        }
        let speed = SAMPLES as f64 * chord(k, before).max(chord(k, after));
        let best = descend(|s| (curve(s) - to).norm_squared(), at(k), speed);
        if best.0 < all.0 {
            *all = best;
        }
        if best.0 <= told {
            return;
        }
    }
}

/// Where a curve over [0, 1] comes nearest to a point from a sample on, and how near, given the squared distance and how fast the curve is.
///
/// A pattern search (Hooke and Jeeves): each round looks at both sides of the best place, and between them where the parabola through the three is least.
/// The steps at least halve, as they must where there is a kink; where the parabola is right they shrink as fast as it becomes better.
fn descend(squared: impl Fn(f64) -> f64, from: f64, speed: f64) -> (f64, f64) {
    const ROUNDS: usize = 64;
    const SHRINK: f64 = 1.0 / 64.0;
    const LEAST: f64 = 1.0 / (1u64 << 50) as f64;
    // Nearer to a minimum than so much of the distance, on the curve, the squared distances differ by roundings.
    const NOISE: f64 = 1.0 / (1u64 << 27) as f64;
    let mut best = (squared(from), from);
    let mut step = 0.5 / SAMPLES as f64;
    let mut most = step;
    for _ in 0..ROUNDS {
        if !(step > LEAST + NOISE * best.0.sqrt() / speed) {
            break;
        }
        let is_end = best.1 == 0.0 || best.1 == 1.0;
        if !is_end {
            // As far to one side as to the other, for the parabola.
            step = step.min(best.1).min(1.0 - best.1);
        }
        let sides = [best.1 - step, best.1 + step].map(|s| {
            let s = s.clamp(0.0, 1.0);
            (squared(s), s)
        });
        let bend = sides[0].0 - 2.0 * best.0 + sides[1].0;
        let off = 0.5 * step * (sides[0].0 - sides[1].0) / bend;
        let is_bent = !is_end && bend > 0.0 && off.abs() < step;
        let side = if sides[1].0 < sides[0].0 {
            sides[1]
        } else {
            sides[0]
        };
        let middle = if is_bent && off != 0.0 {
            (squared(best.1 + off), best.1 + off)
        } else {
            best
        };
        if middle.0 < best.0 && middle.0 <= side.0 {
            best = middle;
            step = (SHRINK * step).max(0.25 * off.abs());
        } else if side.0 < best.0 {
            best = side;
            // From where a parabola has led astray it goes back as far as before.
            if step >= most {
                most *= 0.5;
            }
            step = (2.0 * step).min(most);
        } else if is_end || is_bent && off.abs() <= SHRINK * step {
            step *= SHRINK;
        } else {
            step *= 0.5;
            most = step;
        }
    }
    (best.0.sqrt(), best.1)
}

#[cfg(test)]
mod tests {
    use super::super::tests::bowl;
    use super::*;
    use crate::brep::{BrepBuilder, TrimSpec};
    use crate::numeric::Interval;
    use crate::nurbs::{Curve, Line, Plane, Polyline, Surface};
    use nalgebra::{Point2, Vector3};

    /// The nearer sample is on the flat side of a fold, the point on the steep one.
    #[test]
    fn the_nearest_point_beyond_a_kink() {
        let fold = |s: f64| {
            let x = s - 25.5 / 32.0;
            Point2::new(s, if x < 0.0 { -0.5 * x } else { 8.0 * x })
        };
        // 44 halvings of 1/64 leave 2^-50, which the slope of 8 makes 2^-47 in space; with room for roundings.
        const NEAR: f64 = 1.0 / (1u64 << 44) as f64;
        let to = fold(25.7 / 32.0);
        let (off, s) = nearest(fold, &to);
        assert!(off < NEAR && (s - 25.7 / 32.0).abs() < NEAR, "{off} {s}");
    }

    /// Random curves, smooth and with kinks on samples: none of many points of them is nearer, and there are few that are looked at.
    #[test]
    fn the_nearest_point_of_random_curves() {
        const CURVES: usize = 400;
        /// How far from a curve points are, in parts of where the random ones are: on it, so near that the squares are small, and beside it.
        const OFFS: [f64; 4] = [0.0, 1e-9, 1e-3, 1.0];
        /// The last step is 2^-50 of the curve, which is no faster than 8: coordinates differ by 1 at most, so 3 sqrt(3) for a cubic, 4 sqrt(3) between corners a
        /// quarter apart. As much again is for the roundings of coordinates below 2.
        const NEAR: f64 = 2.0 * 8.0 / (1u64 << 50) as f64;
        /// In the mean: fewer than 33 samples and one way down by 44 halvings take.
        const LOOKS: usize = 120;
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            (state >> 40) as f64 / (1u64 << 24) as f64 - 0.5
        };
        let asked = std::cell::Cell::new(0);
        for k in 0..CURVES {
            let c: [Point3<f64>; 4] =
                std::array::from_fn(|_| Point3::new(random(), random(), random()));
            let curve = |s: f64| {
                asked.set(asked.get() + 1);
                if k % 2 == 0 {
                    let (r, b) = (1.0 - s, [1.0, 3.0, 3.0, 1.0]);
                    let all = (0..4)
                        .map(|i| c[i].coords * (b[i] * r.powi(3 - i as i32) * s.powi(i as i32)));
                    Point3::from(all.sum::<Vector3<f64>>())
                } else {
                    // Corners at 1/4 and 3/4.
                    let corners = [0.0, 0.25, 0.75, 1.0];
                    let i = usize::from(s >= 0.25) + usize::from(s >= 0.75);
                    c[i] + (c[i + 1] - c[i]) * ((s - corners[i]) / (corners[i + 1] - corners[i]))
                }
            };
            let s = random() + 0.5;
            let off = Vector3::new(random(), random(), random()) * OFFS[k % OFFS.len()];
            let to = curve(s) + off;
            let (away, at) = nearest(curve, &to);
            assert_eq!(away, (curve(at) - to).norm(), "{k}");
            let samples = (0..=4096).map(|i| (curve(f64::from(i) / 4096.0) - to).norm());
            let least = samples.fold(off.norm(), f64::min);
            assert!(away <= least + NEAR, "{k}: {away} {least}");
        }
        // But for those of this test: the point itself, the place found, and the samples.
        let each = asked.get() / CURVES - 4099;
        assert!(each < LOOKS, "{each}");
    }

    /// A comb of long teeth next to each other, as one trim.
    fn comb(surface: Surface) -> PreparedBrep {
        const TEETH: usize = 40;
        let width = 1.0 / TEETH as f64;
        let tops = (0..2 * TEETH).map(|k| {
            let y = if k % 2 == 0 { 0.5 } else { -0.4 };
            Point2::new(0.5 - 0.5 * (k as f64 + 0.25) * width, y)
        });
        let ends = [Point2::new(0.5, -0.5), Point2::new(-0.5, -0.5)];
        let corners: Vec<_> = [ends[0]].into_iter().chain(tops).chain([ends[1]]).collect();
        let params = (0..corners.len()).map(|k| k as f64).collect();
        let unit = Interval::new(0.0, 1.0).unwrap();
        let mut b = BrepBuilder::new();
        let ids = ends.map(|p| b.vertex([p.x, p.y, 0.0]));
        let curves = [
            Curve::Polyline(Polyline::new(corners, params).unwrap()),
            Curve::Line(Line::new(ends[1], ends[0], unit).unwrap()),
        ];
        let trims = [0, 1].into_iter().zip(curves).map(|(k, curve)| {
            let vertices = [ids[k], ids[1 - k]];
            let edge = Some(b.straight_edge(vertices).unwrap());
            TrimSpec {
                vertices,
                curve,
                edge,
            }
        });
        let trims = trims.collect();
        b.face_with_trims(surface, vec![trims]).unwrap();
        PreparedBrep::new(b.build().unwrap())
    }

    /// A plane, whose boxes are of control points, and a bowl, whose boxes are of samples.
    fn combs() -> [PreparedBrep; 2] {
        let d = Interval::new(-1.0, 1.0).unwrap();
        let plane = Plane {
            origin: Point3::new(1.0, 2.0, 3.0),
            x: Vector3::x(),
            y: Vector3::y(),
            domain: [d, d],
            extents: [d, d],
        };
        let bowl = bowl(0.25);
        [
            comb(Surface::Plane(plane)),
            comb(bowl.brep().surface(0).clone()),
        ]
    }

    /// What is left out by boxes is no nearer: all samples of all parts tell the same.
    #[test]
    fn boxes_leave_out_what_is_farther() {
        for brep in combs() {
            let trim = 0;
            assert!(brep.trim_parts(trim) > 16);
            let image = |s: f64| point(&brep, on_trim(&brep, trim, s));
            for k in 0..64 {
                let s = f64::from(k) / 64.0 + 0.004;
                let off = 0.5f64.powi(k % 32);
                let to = image(s) + Vector3::new(0.3, -0.5, 0.8) * off;
                let (all, at) = nearest_along(&brep, trim, image, &to);
                let found = nearest_on(&brep, trim, &to, f64::INFINITY);
                assert_eq!(found, Some((all, at)), "{s} {off}");
                assert_eq!(nearest_on(&brep, trim, &to, 1.5 * all), found);
                assert_eq!(nearest_on(&brep, trim, &to, 0.5 * all), None);
            }
        }
    }
}
