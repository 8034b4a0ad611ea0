//! The signed area of a loop in uv, enclosed.
//!
//! # Method
//! Half the sum of `p x q` over the chords `p q` of the loop's parts is the area of a polygon; to it comes what lies
//! between each part and its chord. For a part that is monotone in v, of height `h = q_v - p_v`, that is the integral of
//! `u - u_chord(v)` over v, where `(u - u_chord(v)) h` is the level `(c - p) x (q - p)` of the curve's point: so it is
//! the mean of the level over the part's height, and lies between the least and the largest level of the part's control points. The
//! same holds with u and v exchanged. For any other part it is `1/2 ∫ (c - p) x dc`, no more than half the
//! polygon's length times the largest distance of a control point from `p`: the curve is no longer than its polygon (which every
//! line meets at least as often: Cauchy and Crofton). Parts are halved where that is widest.

use super::decide::Part;
use super::piece::Piece;
use super::region::{PieceOrigin, TrimRegion};
use super::split::Trend;
use crate::numeric::{Ball, Enclosure};

/// Parts are halved until the enclosure is as narrow as this share of the area...
const GOOD: f64 = 1.0 / (1u64 << 16) as f64;
/// ...or so many parts are there, besides those of the region.
const MOST_HALVINGS: usize = 2048;

/// A part, the polygon's term of its chord, and the enclosure of what is between.
struct Slice<'a> {
    piece: &'a Piece,
    t: [f64; 2],
    monotone: bool,
    polygon: Ball<f64>,
    bulge: [f64; 2],
}

impl Slice<'_> {
    fn width(&self) -> f64 {
        self.bulge[1] - self.bulge[0]
    }
}

type Point = [Ball<f64>; 2];

fn cross(a: &Point, b: &Point) -> Ball<f64> {
    a[0] * b[1] - a[1] * b[0]
}

fn minus(a: &Point, b: &Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

/// `None` where a weight is not proven to be positive. `o` is a point to keep digits about.
fn slice(piece: &Piece, t: [f64; 2], monotone: bool, o: [f64; 2]) -> Option<Slice<'_>> {
    let points: Option<Vec<Point>> = piece
        .control()
        .sub_points(t)
        .iter()
        .map(|p| {
            let q = [0, 1].map(|c| p[c] / p[2] - Ball::exact(o[c]));
            let known = p[2].is_above(0.0) && q.iter().all(|x| x.rad.is_finite());
            known.then_some(q)
        })
        .collect();
    let points = points?;
    let (first, last) = (points.first()?, points.last()?);
    let chord = minus(last, first);
    let mut bulge = [0.0, 0.0];
    if points.len() == 2 {
        // Nothing is between a segment and itself.
    } else if monotone {
        for p in &points {
            let level = cross(&minus(p, first), &chord);
            bulge = [
                f64::min(bulge[0], level.lower()),
                f64::max(bulge[1], level.upper()),
            ];
        }
    } else {
        let length = |v: Point| (v[0].square() + v[1].square()).sqrt().upper();
        let polygon: f64 = points.windows(2).map(|w| length(minus(&w[1], &w[0]))).sum();
        let far = points
            .iter()
            .map(|p| length(minus(p, first)))
            .fold(0.0, f64::max);
        // The sum's own roundings: one a step.
        let up = 1.0 + points.len() as f64 * f64::EPSILON;
        let most = (0.5 * polygon * up * far).next_up();
        bulge = [-most, most];
    }
    let polygon = cross(first, last).half();
    Some(Slice {
        piece,
        t,
        monotone,
        polygon,
        bulge,
    })
}

impl TrimRegion {
    /// The signed area of a loop in uv, joins included: positive where it runs counter-clockwise. Proven; as narrow as
    /// 2^-16 of it for ordinary loops, [`Enclosure::UNKNOWN`] where there is no such loop. (A loop that crosses itself has areas of
    /// both signs in the sum.)
    pub fn loop_area(&self, trim_loop: usize) -> Enclosure {
        self.slices(trim_loop).map_or(Enclosure::UNKNOWN, enclosed)
    }

    fn slices(&self, trim_loop: usize) -> Option<(Vec<Slice<'_>>, [f64; 2])> {
        let own = |part: &&Part| match self.origin(part.piece) {
            PieceOrigin::Trim { trim_loop: l, .. } | PieceOrigin::Join { trim_loop: l, .. } => {
                l == trim_loop
            }
            PieceOrigin::Domain => false,
        };
        let parts: Vec<&Part> = self.loops().parts.iter().filter(own).collect();
        let o = parts.first()?.ends(self.loops())[0].at.map(|r| r[0]);
        if !o.iter().all(|x| x.is_finite()) {
            return None;
        }
        let strict = |t: Trend| matches!(t, Trend::Up | Trend::Down);
        let slices: Option<Vec<Slice>> = parts
            .iter()
            .map(|p| {
                let piece = p.piece(self.loops());
                // A part that is flat in both is a point.
                let monotone = p.trends.into_iter().any(strict) || p.trends == [Trend::Flat; 2];
                slice(piece, p.t(self.loops()), monotone, o)
            })
            .collect();
        Some((slices?, o))
    }
}

fn enclosed((mut slices, o): (Vec<Slice<'_>>, [f64; 2])) -> Enclosure {
    let mut left = MOST_HALVINGS;
    loop {
        let mut sum = Ball::ZERO;
        let mut widest = (0, 0.0);
        let mut all = 0.0;
        for (i, s) in slices.iter().enumerate() {
            let mid = 0.5 * s.bulge[0] + 0.5 * s.bulge[1];
            // Half the width, and the roundings of the middle.
            let rad = (0.5 * s.width()).next_up() + f64::EPSILON * mid.abs();
            sum = sum + s.polygon + Ball { mid, rad };
            all += s.width();
            if s.width() > widest.1 {
                widest = (i, s.width());
            }
        }
        let (lo, hi) = (sum.lower(), sum.upper());
        if lo.is_nan() || hi.is_nan() {
            return Enclosure::UNKNOWN;
        }
        let good = all <= GOOD * lo.abs().min(hi.abs()) && lo * hi > 0.0;
        if good || left == 0 || widest.1 == 0.0 {
            return Enclosure { lo, hi };
        }
        // A batch: all that are nearly as wide, so that few sums are made.
        let limit = 0.25 * widest.1;
        let mut next = Vec::with_capacity(slices.len() + 16);
        for s in slices {
            if s.width() < limit || left == 0 {
                next.push(s);
                continue;
            }
            left -= 1;
            let middle = 0.5 * (s.t[0] + s.t[1]);
            let cut = |t| slice(s.piece, t, s.monotone, o);
            match (cut([s.t[0], middle]), cut([middle, s.t[1]])) {
                (Some(a), Some(b)) => next.extend([a, b]),
                _ => next.push(s),
            }
        }
        slices = next;
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::shapes::{Use, bezier, face, line};
    use super::*;

    fn region(curve: &[[f64; 3]], corners: &[[f64; 2]]) -> TrimRegion {
        let mut sides: Vec<Use> = vec![bezier(curve).into()];
        sides.extend(corners.windows(2).map(|w| line(w[0], w[1]).into()));
        TrimRegion::new(&face([-2.0, 2.0, -2.0, 2.0], Some(vec![sides])), 0)
    }

    /// A side with a flat bulge of height h, so slight that it need not be halved: between it and its chord are 0.6 h and less than h^2, of the h that
    /// its control points allow. The area is `∫ u dv` along it, as the other sides are at u = 0 or level:
    /// u = 3 a t^2 + (1 - 3 a) t^3 with a = 1 - h, dv = 3 h + 2 (3 - 6 h) t + 3 (3 h - 2) t^2.
    #[test]
    fn an_area_that_no_part_is_halved_for() {
        let h = 1.0 / f64::from(1 << 20);
        let curve = [[0.0, 0.0], [0.0, h], [1.0 - h, 1.0], [1.0, 1.0]].map(|[u, v]| [u, v, 1.0]);
        let found = region(&curve, &[[1.0, 1.0], [0.0, 1.0], [0.0, 0.0]]).loop_area(0);
        let a = 1.0 - h;
        let (first, second, third) = (3.0 * h, 2.0 * (3.0 - 6.0 * h), 3.0 * (3.0 * h - 2.0));
        let is = 3.0 * a * (first / 3.0 + second / 4.0 + third / 5.0)
            + (1.0 - 3.0 * a) * (first / 4.0 + second / 5.0 + third / 6.0);
        assert!((is - (0.5 - 0.6 * h)).abs() < 2.0 * h * h);
        assert!(
            found.contains(is) && found.width() < 1.01 * h,
            "{found:?} {is}"
        );
    }

    /// Whatever a part does, no more than half its polygon's length times its reach, which goes with the square of its size.
    #[test]
    fn a_part_that_is_not_monotone() {
        let size = 1.0 / 1024.0;
        let curve = [[0.0, 0.0, 1.0], [size, 0.0, 1.0], [size, size, 1.0]];
        let region = region(&curve, &[[size, size], [0.0, 1.0], [0.0, 0.0]]);
        let slice = slice(&region.loops().pieces[0], [0.0, 1.0], false, [0.0; 2]).unwrap();
        let most = 0.5 * (2.0 * size) * (2f64.sqrt() * size);
        assert!(
            (most..=1.001 * most).contains(&slice.bulge[1]),
            "{:?}",
            slice.bulge
        );
        assert_eq!(slice.bulge[0], -slice.bulge[1]);
    }
}
