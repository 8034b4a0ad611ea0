//! Boxes around surfaces and their patches: of revolutions and sums from the pieces of their curves, no patch is made for them.
//!
//! # Method
//! A piece of a profile is within the hull of its control points, as weights are positive: each of its points is a mean of these, and turned by an angle
//! the mean of these turned. So what a span of angles sweeps is within the hull of the arcs that the control points run along. A coordinate of such an arc is
//! `m + e cos a + f sin a`: over less than half a turn its derivative vanishes once at most, where it is `m` plus or minus the root of `e^2 + f^2`; else it is
//! extreme at the ends. A sum of two curves is within the sum of their boxes.

use super::super::circle::Spans;
use super::super::net::{Net, hull};
use super::super::spline::{BezierCurve, Homogeneous, curve_pieces};
use super::super::{Box3, around};
use super::{Patches, Source, Turns, plane_patch, unit_axis};
use crate::numeric::bernstein::Bidegree;
use crate::numeric::{Ball, TINY, sin_cos};
use crate::nurbs::{Curve3, KnotVector, Surface};
use nalgebra::Vector3;

/// Makes up for the roundings of a bound computed in a few operations.
const UP: f64 = 1.0 + 32.0 * f64::EPSILON;

/// A box around a whole surface, by the convex hull of its control points; `None` where none is known.
pub(crate) fn surface_box(surface: &Surface) -> Option<Box3> {
    match surface {
        Surface::Nurbs(s) => {
            let points = s
                .control_net()
                .iter()
                .map(|p| std::array::from_fn(|c| Ball::<f64>::exact(p[c])))
                .collect();
            Net::new(Bidegree { u: 0, v: 0 }, points, [0.0; 3]).bounding_box()
        }
        Surface::Plane(s) => plane_patch::<f64>(s).net.bounding_box(),
        Surface::Revolution(_) | Surface::Sum(_) => {
            union(&patch_boxes(&Patches::on_demand(surface)))
        }
    }
}

/// A box around the part of a surface over a box of native parameters, moved into the domain: of whole spans and pieces, as a rule. No patch is made for it.
pub(crate) fn box_over(surface: &Surface, range: &[[f64; 2]; 2]) -> Option<Box3> {
    let domain = surface.domain();
    let [u, v] = [0, 1].map(|k| range[k].map(|x| x.clamp(domain[k].start, domain[k].end)));
    match surface {
        Surface::Nurbs(s) => {
            let rows = |knots: &KnotVector, range: [f64; 2]| {
                let [first, last] = range.map(|x| knots.find_span(x));
                // What is on a knot is the end of the span before as well: its points are among these, too.
                first - knots.degree()..=last
            };
            let [_, count] = s.counts();
            let mut points = Vec::new();
            for i in rows(s.knots_u(), u) {
                for p in &s.control_net()[i * count..][rows(s.knots_v(), v)] {
                    points.push(std::array::from_fn(|c| Ball::<f64>::exact(p[c])));
                }
            }
            hull(&points, &[0.0; 3])
        }
        Surface::Plane(s) => {
            let patch = plane_patch::<f64>(s);
            let local = |k: usize, range: [f64; 2]| {
                let ends = range.map(|x| patch.maps[k].to_local(Ball::<f64>::exact(x)));
                [ends[0].lower(), ends[1].upper()]
            };
            patch.net.box_over([local(0, u), local(1, v)])
        }
        Surface::Revolution(s) => {
            let (u, v) = if s.transposed { (v, u) } else { (u, v) };
            let part = Turns {
                turns: Spans::new(s.angle, s.angle_domain, u[0], u[1]),
                profile: pieces_over(&s.profile, v)
                    .into_iter()
                    .map(Into::into)
                    .collect(),
                made: Box::default(),
                origin: s.origin,
                axis: unit_axis(s),
                transposed: s.transposed,
            };
            union(&swept_boxes(&part))
        }
        Surface::Sum(s) => {
            let pieces = [pieces_over(&s.first, u), pieces_over(&s.second, v)];
            union(&sum_boxes(&s.base, &pieces))
        }
    }
}

/// The pieces of a curve over a range; where that is a point, of what is next to it. Of a poly-curve whole pieces: parameters of its segments are rounded where these are cut.
fn pieces_over(curve: &Curve3, [from, to]: [f64; 2]) -> Vec<BezierCurve<f64, 4>> {
    let domain = curve.domain();
    let wide = [from.next_down(), to.next_up()];
    let mut out = Vec::new();
    if let Curve3::Poly(_) = curve {
        curve_pieces(curve, domain.start, domain.end, &mut out);
        out.retain(|p| {
            // Its ends may be no f64, and between two that are neighbours.
            let (a, b) = (p.map.start, p.map.end);
            a.min(b) <= wide[1] && a.max(b) >= wide[0]
        });
    } else {
        let (from, to) = if from < to {
            (from, to)
        } else {
            (wide[0].max(domain.start), wide[1].min(domain.end))
        };
        curve_pieces(curve, from, to, &mut out);
    }
    out
}

/// A box around some; `None` where one is not known, or there are none.
fn union(boxes: &[Option<Box3>]) -> Option<Box3> {
    let mut out: Option<Box3> = None;
    for b in boxes {
        let b = (*b)?;
        out = Some(out.map_or(b, |all| around(&[all, b])));
    }
    out
}

/// A box around each patch; `None` where a weight is not proven to be positive. Of revolutions and sums no patch is made, of others all.
pub(super) fn patch_boxes(patches: &Patches<f64>) -> Vec<Option<Box3>> {
    match &patches.source {
        Source::Revolution(s) => swept_boxes(s),
        Source::Sum { base, pieces } => sum_boxes(base, pieces),
        Source::Plane(_) | Source::Nurbs { .. } => {
            patches.make_all().map(|p| p.net.bounding_box()).collect()
        }
    }
}

fn sum_boxes(base: &Vector3<f64>, pieces: &[Vec<BezierCurve<f64, 4>>; 2]) -> Vec<Option<Box3>> {
    let [first, second] = [0, 1].map(|k| {
        let boxes = pieces[k].iter().map(|p| hull(&p.points, &[0.0; 3]));
        boxes.collect::<Vec<_>>()
    });
    let sum = |a: &Option<Box3>, b: &Option<Box3>| {
        let (a, b) = (a.as_ref()?, b.as_ref()?);
        let out: Box3 = std::array::from_fn(|c| {
            // Two roundings of each sum.
            let size = [base[c], a[c][0], a[c][1], b[c][0], b[c][1]];
            let off = 4.0 * f64::EPSILON * size.iter().map(|x| x.abs()).sum::<f64>();
            [
                base[c] + a[c][0] + b[c][0] - off,
                base[c] + a[c][1] + b[c][1] + off,
            ]
        });
        finite(out)
    };
    let second = &second;
    let all = first
        .iter()
        .flat_map(|a| second.iter().map(move |b| sum(a, b)));
    all.collect()
}

fn finite(b: Box3) -> Option<Box3> {
    b.iter().flatten().all(|x| x.is_finite()).then_some(b)
}

/// A coordinate of what a control point runs along: `middle + ahead cos a + aside sin a`.
#[derive(Clone, Copy)]
struct Arc {
    middle: f64,
    ahead: f64,
    aside: f64,
    /// How much it is off at most, where it is evaluated in f64.
    off: f64,
}

/// A span of angles: cosine and sine at its ends, and whether it is shorter than half a turn.
struct Sector {
    ends: [[f64; 2]; 2],
    short: bool,
}

fn swept_boxes(s: &Turns<f64>) -> Vec<Option<Box3>> {
    let arcs = |points: &Vec<Homogeneous<f64, 4>>| -> Option<Vec<[Arc; 3]>> {
        points.iter().map(|p| arcs_of(s, p)).collect()
    };
    let pieces: Vec<_> = s.profile.iter().map(|p| arcs(&p.points)).collect();
    let sectors = sectors(&s.turns);
    let of = |piece: &Option<Vec<[Arc; 3]>>, sector: &Sector| {
        let mut out = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        for arcs in piece.as_ref()? {
            for (range, arc) in out.iter_mut().zip(arcs) {
                let [low, high] = arc.range(sector);
                // What is no number is nowhere.
                if !(low <= high) {
                    return None;
                }
                *range = [range[0].min(low), range[1].max(high)];
            }
        }
        finite(out)
    };
    let (pieces, sectors) = (&pieces, &sectors);
    if s.transposed {
        let all = pieces
            .iter()
            .flat_map(|p| sectors.iter().map(move |t| (p, t)));
        all.map(|(p, t)| of(p, t)).collect()
    } else {
        let all = sectors
            .iter()
            .flat_map(|t| pieces.iter().map(move |p| (p, t)));
        all.map(|(p, t)| of(p, t)).collect()
    }
}

fn sectors(turns: &Spans) -> Vec<Sector> {
    /// Less than half a turn, in radians.
    const SHORT: f64 = 3.0;
    let angles: Vec<_> = (0..=turns.len()).map(|k| turns.border(k)).collect();
    let at = angles.iter().map(|a| {
        let (sin, cos) = sin_cos(*a);
        [cos.mid.hi, sin.mid.hi]
    });
    let at: Vec<_> = at.collect();
    let of = |k: usize| Sector {
        ends: [at[k], at[k + 1]],
        short: (angles[k + 1] - angles[k]).upper() < SHORT,
    };
    (0..turns.len()).map(of).collect()
}

/// The arcs of a control point, whose weight must be positive.
fn arcs_of(s: &Turns<f64>, p: &Homogeneous<f64, 4>) -> Option<[Arc; 3]> {
    if !p[3].is_above(0.0) {
        return None;
    }
    let n = &s.axis;
    let origin = |c: usize| Ball::exact(s.origin[c]);
    let q: [Ball<f64>; 3] = std::array::from_fn(|c| p[c] / p[3] - origin(c));
    let height = q[0] * n[0] + q[1] * n[1] + q[2] * n[2];
    Some(std::array::from_fn(|c| {
        let (j, k) = ((c + 1) % 3, (c + 2) % 3);
        let along = height * n[c];
        let (middle, ahead, aside) = (origin(c) + along, q[c] - along, n[j] * q[k] - n[k] * q[j]);
        // Cosine and sine are rounded, the products, and their sum: three halves of a unit of the last two in all, and one of the whole; the root is off by four.
        let size = ahead.mid.abs() + aside.mid.abs();
        let known = middle.rad + ahead.rad + aside.rad;
        let off = known + f64::EPSILON * (8.0 * size + 4.0 * middle.mid.abs()) + TINY;
        Arc {
            middle: middle.mid,
            ahead: ahead.mid,
            aside: aside.mid,
            off: off * UP,
        }
    }))
}

impl Arc {
    fn range(&self, sector: &Sector) -> [f64; 2] {
        let &Self {
            ahead, aside, off, ..
        } = self;
        let value = |[cos, sin]: [f64; 2]| ahead * cos + aside * sin;
        let slope = |[cos, sin]: [f64; 2]| aside * cos - ahead * sin;
        let (values, slopes) = (sector.ends.map(value), sector.ends.map(slope));
        // Negated: what is no number may be anything.
        let falls = |slope: f64| !(slope > off);
        let rises = |slope: f64| !(slope < -off);
        let most = || {
            let (a, b) = (ahead.abs().max(aside.abs()), ahead.abs().min(aside.abs()));
            if a > 0.0 {
                a * (1.0 + (b / a) * (b / a)).sqrt()
            } else {
                0.0
            }
        };
        let (mut low, mut high) = (values[0].min(values[1]), values[0].max(values[1]));
        if !sector.short || rises(slopes[0]) && falls(slopes[1]) {
            high = most();
        }
        if !sector.short || falls(slopes[0]) && rises(slopes[1]) {
            low = -most();
        }
        [self.middle + low - off, self.middle + high + off]
    }
}

#[cfg(test)]
mod tests {
    use super::super::surface_patches;
    use super::*;
    use crate::numeric::Interval;
    use crate::nurbs::{Line, NurbsCurve, Plane, PolyCurve, Revolution, Sum};
    use nalgebra::{Point3, Vector4};

    struct Random(u64);

    impl Random {
        fn between(&mut self, low: f64, high: f64) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
        }

        fn vector(&mut self, size: f64) -> Vector3<f64> {
            Vector3::from_fn(|_, _| self.between(-size, size))
        }

        /// Of two spans, rational.
        fn curve(&mut self) -> Curve3 {
            let points = (0..4).map(|_| {
                let (p, w) = (self.vector(3.0), self.between(0.2, 2.0));
                Vector4::new(p.x * w, p.y * w, p.z * w, w)
            });
            let knots = vec![0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0];
            Curve3::Nurbs(NurbsCurve::new(2, points.collect(), knots).unwrap())
        }

        /// A sum, or a revolution of a hundredth of a turn to whole ones, and more.
        fn swept(&mut self, round: usize) -> Surface {
            if round % 4 == 3 {
                Surface::Sum(Sum {
                    first: self.curve(),
                    second: self.curve(),
                    base: self.vector(5.0),
                })
            } else {
                let turn = [0.05, 1.0, 4.0, std::f64::consts::TAU, 9.0][round % 5];
                let start = self.between(-7.0, 7.0);
                let revolution = Revolution {
                    origin: Point3::from(self.vector(5.0)),
                    axis: match round % 3 {
                        0 => Vector3::z(),
                        _ => self.vector(1.0),
                    },
                    angle: Interval::new(start, start + turn).unwrap(),
                    angle_domain: Interval::new(0.0, 3.0).unwrap(),
                    profile: self.curve(),
                    transposed: round.is_multiple_of(2),
                };
                Surface::Revolution(Revolution::new(revolution).unwrap())
            }
        }
    }

    /// The boxes hold all points of their patches, and are no larger than the hulls of the patches' control points but by roundings and by what those
    /// of a curve with weights gain.
    #[test]
    fn boxes_hold_their_patches() {
        let mut random = Random(0x7c1e_93a5_d2f0_4b69);
        for round in 0..60 {
            let surface = random.swept(round);
            let boxes = patch_boxes(&Patches::on_demand(&surface));
            let whole = surface_box(&surface).unwrap();
            let patches = surface_patches::<f64>(&surface);
            assert_eq!(boxes.len(), patches.len());
            let (mut held, mut seen) = ([[f64::INFINITY, f64::NEG_INFINITY]; 3], 0);
            for (b, patch) in boxes.iter().zip(&patches) {
                let b = b.unwrap();
                let hull = patch.net.bounding_box().unwrap();
                for c in 0..3 {
                    let room = 1e-12;
                    assert!(
                        hull[c][0] - room <= b[c][0] && b[c][1] <= hull[c][1] + room,
                        "{round}"
                    );
                    held[c] = [held[c][0].min(b[c][0]), held[c][1].max(b[c][1])];
                }
                let maps = &patch.maps;
                for i in 0..=8 {
                    for j in 0..=8 {
                        let at =
                            |k: usize, s: f64| maps[k].start + (maps[k].end - maps[k].start) * s;
                        let p = surface.point(at(0, f64::from(i) / 8.0), at(1, f64::from(j) / 8.0));
                        // Points are evaluated to some roundings.
                        let room = 1e-13;
                        let inside =
                            (0..3).all(|c| b[c][0] - room <= p[c] && p[c] <= b[c][1] + room);
                        assert!(inside, "{round} {p} {b:?}");
                        seen += 1;
                    }
                }
            }
            assert!(seen >= 81 && held == whole);
        }
    }

    /// A segment of a poly-curve whose own parameters are so large that all next to its end is rounded to it.
    #[test]
    fn boxes_over_poly_curves() {
        let line = |a: [f64; 3], b: [f64; 3], start: f64| {
            let domain = Interval::new(start, start + 1.0).unwrap();
            Curve3::Line(Line::new(a.into(), b.into(), domain).unwrap())
        };
        let (a, b, c) = ([1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [2.0, 0.0, 1.0]);
        let segments = vec![line(a, b, 1e15), line(b, c, 0.0)];
        let poly = PolyCurve::new(segments, vec![0.0, 1.0, 2.0]).unwrap();
        let first = Interval::new(0.0, 1.0).unwrap();
        let along = Line::new(Point3::origin(), Point3::new(0.0, 3.0, 0.0), first).unwrap();
        let sum = Surface::Sum(Sum {
            first: Curve3::Line(along),
            second: Curve3::Poly(poly.clone()),
            base: Vector3::zeros(),
        });
        let turned = Revolution {
            origin: Point3::origin(),
            axis: Vector3::z(),
            angle: first,
            angle_domain: first,
            profile: Curve3::Poly(poly),
            transposed: false,
        };
        let turned = Surface::Revolution(Revolution::new(turned).unwrap());
        for surface in [sum, turned] {
            // The second coordinate at 0.95 of the first segment, and where both meet.
            for range in [[0.95, 1.5], [0.95; 2], [1.0, 1.0], [1.0, 1.5]] {
                let b = box_over(&surface, &[[0.2, 0.7], range]).unwrap();
                assert!(
                    b[2][0] <= range[0].min(1.0) && b[2][1] >= 1.0,
                    "{range:?} {b:?}"
                );
            }
        }
    }

    /// A box over some parameters holds the surface there, is within that of the whole surface, and about that of a point where it is one.
    #[test]
    fn boxes_over_parts() {
        let mut random = Random(0x1f83_d9ab_fb41_bd6b);
        for round in 0..200 {
            let surface = match round % 6 {
                4 => Surface::Nurbs(random.swept(round).to_nurbs().unwrap().nurbs),
                5 => Surface::Plane(Plane {
                    origin: Point3::from(random.vector(5.0)),
                    x: Vector3::new(0.6, 0.8, 0.0),
                    y: Vector3::new(0.0, 0.0, -1.0),
                    domain: [Interval::new(-1.0, 2.0).unwrap(); 2],
                    extents: [Interval::new(3.0, 5.0).unwrap(); 2],
                }),
                _ => random.swept(round),
            };
            let whole = surface_box(&surface).unwrap();
            let domain = surface.domain();
            let range = [0, 1].map(|k| {
                let d = domain[k];
                let length = d.end - d.start;
                // Beyond the domain, too, and points.
                let ends = [0, 1].map(|_| d.start + length * random.between(-0.2, 1.2));
                let at = ends[0];
                match round % 7 {
                    0 => [at; 2],
                    1 => [d.start; 2],
                    2 => [d.end; 2],
                    _ => [at.min(ends[1]), at.max(ends[1])],
                }
            });
            let b = box_over(&surface, &range).unwrap();
            for c in 0..3 {
                // Two ways to the same box differ by roundings.
                let room = 1e-12;
                assert!(whole[c][0] - room <= b[c][0] && b[c][1] <= whole[c][1] + room);
            }
            for _ in 0..50 {
                let [u, v] = [0, 1].map(|k| {
                    let x = range[k][0] + (range[k][1] - range[k][0]) * random.between(0.0, 1.0);
                    x.clamp(domain[k].start, domain[k].end)
                });
                let p = surface.point(u, v);
                let room = 1e-13;
                let inside = (0..3).all(|c| b[c][0] - room <= p[c] && p[c] <= b[c][1] + room);
                assert!(inside, "{round} {p} {b:?}");
            }
        }
    }

    /// A circle about an axis through the origin reaches exactly so far, in the coordinates across, whatever part of it is swept.
    #[test]
    fn arcs_reach_their_tops() {
        let arc = Arc {
            middle: 1.0,
            ahead: 3.0,
            aside: 4.0,
            off: 1e-14,
        };
        let top = 4f64.atan2(3.0);
        let sector = |a: f64, b: f64| Sector {
            ends: [a, b].map(|x| [x.cos(), x.sin()]),
            short: b - a < 3.0,
        };
        let near =
            |[a, b]: [f64; 2], [c, d]: [f64; 2]| (a - c).abs() < 1e-13 && (b - d).abs() < 1e-13;
        assert!(near(
            arc.range(&sector(top - 0.1, top + 0.2)),
            [1.0 + 5.0 * 0.2f64.cos(), 6.0]
        ));
        assert!(near(
            arc.range(&sector(top + 3.0, top + 3.2)),
            [-4.0, 1.0 + 5.0 * 3f64.cos()]
        ));
        assert!(near(
            arc.range(&sector(top + 0.1, top + 0.2)),
            [0.2, 0.1].map(|x: f64| 1.0 + 5.0 * x.cos())
        ));
        assert!(near(arc.range(&sector(0.0, 6.0)), [-4.0, 6.0]));
    }
}
