//! A BREP in the making: its parts, and what faces need once their trims are known.

use super::motion::Place;
use super::wires::Use;
use crate::sheets::{ROUNDING, Reach, reach};
use feeler::brep::{BrepParts, Face, Iso, LoopKind, TrimCurve, TrimKind, TrimLoop};
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Curve2, Line, Polyline};
use nalgebra::{Point2, SVector};
use std::collections::{BTreeMap, HashMap};

/// A point on a loop is taken at so many parameters of each trim to see which way it runs.
const SAMPLES: u16 = 16;

/// A BREP in the making.
#[derive(Default)]
pub(crate) struct Builder {
    pub(crate) parts: BrepParts,
    pub(crate) vertices: HashMap<(usize, Place), usize>,
    pub(crate) edges: HashMap<(usize, Place), usize>,
    /// Splines that are used as they stand, shared.
    pub(crate) curves2: HashMap<usize, usize>,
    pub(crate) curves3: HashMap<(usize, Place), usize>,
    pub(crate) surfaces: HashMap<(usize, Place), usize>,
    /// What was odd, and how often.
    pub(crate) odd: BTreeMap<&'static str, usize>,
    pub(crate) is_moved: bool,
}

/// One use of an edge by a wire.
pub(crate) struct EdgeUse {
    pub(crate) shape: usize,
    pub(crate) place: Place,
    pub(crate) reversed: bool,
    pub(crate) curve: usize,
    pub(crate) span: Interval,
    pub(crate) vertices: [usize; 2],
    pub(crate) degenerated: bool,
}

/// A loop that goes on around a periodic surface by more than a period and this part of it (a third of a degree) winds; what is less is the error of a fitted curve, by
/// which a loop that closes at the seam would cover a strip there twice.
const WINDS: f64 = 1.0 / (1 << 10) as f64;

const SHIFTED: &str = "loops were moved by a period to where their face's outer loop lies";

impl Builder {
    pub(super) fn ends(&self, u: &EdgeUse) -> Use {
        let at = |t: f64| {
            let curve = self.parts.curves2.get(u.curve);
            curve.map_or(Point2::origin(), |c| c.point(t))
        };
        let mut ends = [at(u.span.start), at(u.span.end)];
        if u.reversed {
            ends.reverse();
        }
        Use {
            vertices: u.vertices,
            ends,
        }
    }

    /// Moves loops by whole periods so that they start within one period from where the longest does, but those that are where it is.
    pub(crate) fn lift(&mut self, loops: &mut [Vec<EdgeUse>], periods: [Option<f64>; 2]) {
        for (c, period) in periods.into_iter().enumerate() {
            let Some(period) = period.filter(|_| loops.len() > 1) else {
                continue;
            };
            let ranges: Vec<[f64; 2]> = loops
                .iter()
                .map(|uses| self.range(uses, c).map_or([0.0; 2], |r| r.range))
                .collect();
            let longest = ranges
                .iter()
                .max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
            let Some(&[base, top]) = longest else {
                continue;
            };
            let slack = ROUNDING * period;
            for (uses, [lo, hi]) in loops.iter_mut().zip(&ranges) {
                // A hole in a later turn of a face that winds.
                if base - slack <= *lo && *hi <= top + slack {
                    continue;
                }
                let turns = ((base - lo) / period - ROUNDING).ceil();
                if turns == 0.0 || !turns.is_finite() {
                    continue;
                }
                *self.odd.entry(SHIFTED).or_default() += 1;
                for u in uses {
                    let Some(curve) = self.parts.curves2.get_mut(u.curve) else {
                        continue;
                    };
                    if self.curves2.is_empty() {
                        // Nothing is shared, and what is left behind would be kept.
                        shift(curve, c, turns * period);
                        continue;
                    }
                    let mut moved = curve.clone();
                    if shift(&mut moved, c, turns * period).is_some() {
                        u.curve = self.parts.curves2.len();
                        self.parts.curves2.push(moved);
                    }
                }
            }
        }
    }

    fn range<'u>(&self, uses: impl IntoIterator<Item = &'u EdgeUse>, c: usize) -> Option<Reach> {
        let curves = uses.into_iter();
        let known = curves.filter_map(|u| Some((self.parts.curves2.get(u.curve)?, u.span)));
        reach(known, c)
    }

    /// How far loops reach in u and v on a surface with these periods.
    pub(crate) fn reach(
        &self,
        loops: &[Vec<EdgeUse>],
        periods: [Option<f64>; 2],
    ) -> [Option<Reach>; 2] {
        [0, 1].map(|c| {
            let mut all = self.range(loops.iter().flatten(), c)?;
            if let Some(period) = periods[c]
                && all.range[1] - all.range[0] > period
            {
                let long = |r: Reach| r.range[1] - r.range[0] > (1.0 + WINDS) * period;
                all.winds = loops
                    .iter()
                    .any(|uses| self.range(uses, c).is_some_and(long));
            }
            Some(all)
        })
    }

    pub(crate) fn face(
        &mut self,
        surface: usize,
        has_wires: bool,
        loops: Vec<Vec<EdgeUse>>,
        reversed: bool,
    ) {
        let face = self.parts.faces.len();
        let domain = self.parts.surfaces.get(surface).map(|s| s.domain());
        let mut indices = Vec::new();
        for uses in loops {
            let trim_loop = self.parts.loops.len();
            indices.push(trim_loop);
            let kind = self.loop_kind(&uses);
            let mut trims = Vec::with_capacity(uses.len());
            for u in uses {
                let trim = self.parts.trims.len();
                trims.push(trim);
                let edge = match u.degenerated {
                    true => None,
                    false => self.edges.get(&(u.shape, u.place)).copied(),
                };
                if let Some(edge) = edge.and_then(|e| self.parts.edges.get_mut(e)) {
                    edge.trims.push(trim);
                }
                let curve = self.parts.curves2.get(u.curve);
                self.parts.trims.push(TrimCurve {
                    curve: u.curve,
                    span: u.span,
                    reversed: u.reversed,
                    edge,
                    edge_reversed: u.reversed,
                    vertices: u.vertices,
                    kind: TrimKind::Singular,
                    iso: curve.zip(domain).map_or(Iso::None, |(c, d)| Iso::of(c, d)),
                    trim_loop,
                });
            }
            self.parts.loops.push(TrimLoop { kind, trims, face });
        }
        self.parts.faces.push(Face {
            surface,
            loops: has_wires.then_some(indices),
            reversed,
        });
    }

    /// By the sign of the area of a polygon through points of the loop, of which the first and the last are kept.
    fn loop_kind(&self, uses: &[EdgeUse]) -> LoopKind {
        let mut points: Option<[Point2<f64>; 2]> = None;
        let mut area = 0.0;
        for u in uses {
            let Some(curve) = self.parts.curves2.get(u.curve) else {
                continue;
            };
            // A straight one is its ends: where there are gaps, the next does not start where it ends.
            let (count, steps) = if matches!(curve, Curve::Line(_)) {
                (2, 1)
            } else {
                (SAMPLES, SAMPLES)
            };
            for k in 0..count {
                let s = f64::from(k) / f64::from(steps);
                let p = nearly(curve, u.span.lerp(if u.reversed { 1.0 - s } else { s }));
                let [o, last] = points.unwrap_or([p; 2]);
                let (a, b) = (last - o, p - o);
                area += a.x * b.y - a.y * b.x;
                points = Some([o, p]);
            }
        }
        if area > 0.0 {
            LoopKind::Outer
        } else if area < 0.0 {
            LoopKind::Inner
        } else {
            LoopKind::Unknown
        }
    }
}

/// A point of a curve; of an arc without the care for its last digits, which takes most of the time: the sign of an area does not
/// need them.
fn nearly(curve: &Curve2, t: f64) -> Point2<f64> {
    let Curve::Arc(a) = curve else {
        return curve.point(t);
    };
    let turned = (t - a.domain.start) / a.domain.length();
    let (sin, cos) = libm::sincos(a.angle.lerp(turned));
    let x = a.x.normalize();
    let y = if a.x.perp(&a.y) < 0.0 { -1.0 } else { 1.0 };
    a.center + (x * cos + nalgebra::Vector2::new(-x.y, x.x) * (y * sin)) * a.radius
}

/// Moves a curve in coordinate `c`, in place: it may be long. Rounded. `None`, and as it was: where it would lie is none.
pub(crate) fn shift(curve: &mut Curve2, c: usize, by: f64) -> Option<()> {
    let mut step = SVector::<f64, 2>::zeros();
    step[c] = by;
    match curve {
        Curve::Line(l) => *l = Line::new(l.from + step, l.to + step, l.domain).ok()?,
        Curve::Arc(a) => a.center += step,
        Curve::Nurbs(n) => {
            let moved = |p: &SVector<f64, 3>| {
                let mut p = *p;
                p[c] += by * p[2];
                p
            };
            n.move_points(moved).ok()?;
        }
        Curve::Polyline(l) => {
            let points = l.points().iter().map(|p| p + step).collect();
            *l = Polyline::new(points, l.params().to_vec()).ok()?;
        }
        // Never made here.
        Curve::Poly(_) => return None,
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Straight uses of edges, one curve each.
    fn loops(b: &mut Builder, lines: &[[[f64; 2]; 2]], reversed: bool) -> Vec<EdgeUse> {
        let span = Interval::new(0.0, 1.0).unwrap();
        let mut uses: Vec<EdgeUse> = { lines.iter() }
            .map(|&[from, to]| {
                let line = Line::new(Point2::from(from), Point2::from(to), span).unwrap();
                b.parts.curves2.push(Curve::Line(line));
                EdgeUse {
                    shape: 0,
                    place: Place::HERE,
                    reversed,
                    curve: b.parts.curves2.len() - 1,
                    span,
                    vertices: [0, 0],
                    degenerated: false,
                }
            })
            .collect();
        if reversed {
            uses.reverse();
        }
        uses
    }

    /// Straight trims with gaps between them: the sides of a square that lie opposite, without the other two.
    #[test]
    fn far_ends_count_for_the_sense_of_a_loop() {
        let sides = [[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.5], [0.0, 0.5]]];
        let mut b = Builder::default();
        let with = loops(&mut b, &sides, false);
        assert_eq!(b.loop_kind(&with), LoopKind::Outer);
        let against = loops(&mut b, &sides, true);
        assert_eq!(b.loop_kind(&against), LoopKind::Inner);
    }

    /// Two turns and a half, one, and one and a fitted curve's error.
    #[test]
    fn a_loop_winds_by_more_than_an_error() {
        let periods = [Some(TAU), None];
        for (to, winds) in [(2.5 * TAU, true), (TAU, false), (TAU * (1.0 + 1e-4), false)] {
            let mut b = Builder::default();
            let band = [[[0.0, 0.0], [to, 1.0]], [[to, 1.5], [0.0, 0.5]]];
            let own = loops(&mut b, &band, false);
            let [u, v] = b.reach(&[own], periods);
            let (u, v) = (u.unwrap(), v.unwrap());
            assert_eq!((u.range, u.winds), ([0.0, to], winds));
            assert_eq!((v.range, v.winds), ([0.0, 1.5], false));
        }
        // A hole in the second turn stays there, one beyond comes to the first.
        let mut b = Builder::default();
        let band = loops(
            &mut b,
            &[[[0.0, 0.0], [15.0, 1.0]], [[15.0, 1.5], [0.0, 0.5]]],
            false,
        );
        let hole = |from: f64| {
            [
                [[from, 0.7], [from + 1.0, 0.75]],
                [[from + 1.0, 0.8], [from, 0.75]],
            ]
        };
        let (second, beyond) = (
            loops(&mut b, &hole(8.0), true),
            loops(&mut b, &hole(20.0), true),
        );
        let mut all = [band, second, beyond];
        b.lift(&mut all, periods);
        let start = |k: usize| b.range(&all[k], 0).unwrap().range[0];
        assert_eq!((start(0), start(1)), (0.0, 8.0));
        assert!((start(2) - (20.0 - 3.0 * TAU)).abs() < 1e-14);
        // Several loops that reach so far together do not.
        let mut b = Builder::default();
        let one = loops(&mut b, &[[[0.0, 0.0], [TAU, 0.0]]], false);
        let two = loops(&mut b, &[[[3.0, 1.0], [9.0, 1.0]]], false);
        let [u, _] = b.reach(&[one, two], periods);
        assert!(!u.unwrap().winds);
    }
}
