//! Surfaces whose NURBS form has another parameter than they: curves in uv on them are taken along.
//!
//! A `.brep` has surfaces made of ellipses and hyperbolas, which the kernel holds as rational quadratics, exactly the same points at other parameters
//! ([`Form::part`](crate::occt::curves::Form::part)); a .3dm has no surface of revolution over more than a turn.
//!
//! What is straight along u or v stays so, up to the rounding of its ends. Other curves are fitted by cubics, each through four points of its piece, which is
//! halved until [`CHECKED`] points between are within [`FIT`] of the domain's length. How far their images are from the edges' curves in space
//! the health report proves, as of all trims.

use crate::occt::TextProblem;
use crate::occt::curves::{Budget, Refusal, refused};
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Curve2, Line, NurbsCurve, ParameterMap};
use libm::sinh;
use nalgebra::{Point2, Vector3};

/// How near fitted curves come, relative to the surface's domain: far below what files' own curves in uv are off.
const FIT: f64 = 1.0 / (1_u64 << 32) as f64;
/// Points of a piece that are looked at.
const CHECKED: u8 = 8;
/// How often a piece is halved, and how many there may be. The map bends where the quadratics of an ellipse meet; pieces are short there.
const HALVINGS: u32 = 16;
const MOST_PIECES: usize = 512;
/// What a piece that is tried counts for among the numbers that may be made of a file: points on it take sines, far more time than that many numbers.
const EFFORT: usize = 32;

/// From one parameter to that of the NURBS form.
pub(crate) enum Warp {
    /// Angles of an arc, or of the circle that an ellipse is an image of.
    Arcs(ParameterMap),
    /// A hyperbola's: one quadratic over this range. As with an arc, with the hyperbolic sine: at `t` it is `sinh((t - a) / 2)` of
    /// `sinh((t - a) / 2) + sinh((b - t) / 2)`.
    Hyperbola(Interval),
}

impl Warp {
    fn at(&self, t: f64) -> f64 {
        match self {
            Self::Arcs(map) => map.to_nurbs(t),
            Self::Hyperbola(on) => {
                if !(on.start < t && t < on.end) {
                    return t;
                }
                let (a, b) = (sinh(0.5 * (t - on.start)), sinh(0.5 * (on.end - t)));
                on.lerp(a / (a + b)).clamp(on.start, on.end)
            }
        }
    }

    /// The part over `span` of a curve in uv, with coordinate `c` taken along. `lengths`: those of the surface's domain.
    pub(crate) fn taken(
        &self,
        curve: &Curve2,
        span: Interval,
        c: usize,
        lengths: [f64; 2],
        numbers: &mut Budget,
    ) -> Result<Curve2, Refusal> {
        let at = |t: f64| {
            let mut p = curve.point(t);
            p[c] = self.at(p[c]);
            p
        };
        if let Curve::Line(l) = curve
            && (l.from.x == l.to.x || l.from.y == l.to.y)
        {
            let line = Line::new(at(span.start), at(span.end), span);
            return Ok(Curve::Line(line.map_err(refused("a curve in uv"))?));
        }
        let mut ends: Vec<f64> = curve.breaks();
        ends.retain(|t| span.start < *t && *t < span.end);
        ends.extend([span.start, span.end]);
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        let mut open: Vec<([f64; 2], u32)> =
            ends.windows(2).rev().map(|w| ([w[0], w[1]], 0)).collect();
        let mut points = vec![at(span.start)];
        let mut knots = vec![span.start; 4];
        while let Some(([a, b], depth)) = open.pop() {
            numbers.take(EFFORT)?;
            let on = |s: f64| at(a + (b - a) * s);
            let cubic = through([on(0.0), on(1.0 / 3.0), on(2.0 / 3.0), on(1.0)]);
            let is_near = (0..CHECKED).all(|k| {
                let s = (f64::from(k) + 0.5) / f64::from(CHECKED);
                let off = on(s) - evaluated(&cubic, s);
                (0..2).all(|k| off[k].abs() <= FIT * lengths[k])
            });
            let m = 0.5 * (a + b);
            if is_near {
                points.extend_from_slice(&cubic[1..]);
                knots.extend([b; 3]);
            } else if depth < HALVINGS && open.len() < MOST_PIECES && a < m && m < b {
                open.extend([([m, b], depth + 1), ([a, m], depth + 1)]);
            } else {
                break;
            }
            if points.len() > 3 * MOST_PIECES {
                break;
            }
        }
        let is_done = knots.last() == Some(&span.end) && span.start < span.end;
        if !is_done {
            return Err(TextProblem::Unsupported {
                what: "a curve in uv that is too uneven to be fitted to its surface's NURBS form"
                    .into(),
                remedy: "convert the shape to NURBS (BRepBuilderAPI_NurbsConvert)",
            });
        }
        knots.push(span.end);
        numbers.take(3 * points.len())?;
        let points = points.iter().map(|p| Vector3::new(p.x, p.y, 1.0));
        let fitted = NurbsCurve::new(3, points.collect(), knots);
        Ok(Curve::Nurbs(fitted.map_err(refused("a curve in uv"))?))
    }
}

/// The Bezier points of the cubic through four points, at thirds.
fn through([p, q, r, s]: [Point2<f64>; 4]) -> [Point2<f64>; 4] {
    let inner = |near: Point2<f64>, a: Point2<f64>, b: Point2<f64>, far: Point2<f64>| {
        Point2::from(
            (near.coords * -5.0 + a.coords * 18.0 - b.coords * 9.0 + far.coords * 2.0) / 6.0,
        )
    };
    [p, inner(p, q, r, s), inner(s, r, q, p), s]
}

fn evaluated(b: &[Point2<f64>; 4], s: f64) -> Point2<f64> {
    let r = 1.0 - s;
    let weights = [r * r * r, 3.0 * r * r * s, 3.0 * r * s * s, s * s * s];
    let sum = b.iter().zip(weights).map(|(p, w)| p.coords * w);
    Point2::from(sum.sum::<nalgebra::Vector2<f64>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::occt::curves::{Form, Frame};
    use nalgebra::{Point3, Vector3};

    /// A point of the file's conic is that of the kernel's form at the parameter that is taken along.
    #[test]
    fn parameters_go_together() {
        let frame = || Frame {
            center: Point3::new(1.0, -2.0, 0.5),
            x: Vector3::new(0.6, 0.8, 0.0),
            y: Vector3::new(-0.8, 0.6, 0.0),
            z: Vector3::z(),
        };
        let (a, b) = (3.0, 0.75);
        let ellipse: Form<3, 4> = Form::Ellipse(frame(), [a, b]);
        let hyperbola: Form<3, 4> = Form::Hyperbola(frame(), [a, b]);
        let on_ellipse = |t: f64| (a * t.cos(), b * t.sin());
        let on_hyperbola = |t: f64| (a * t.cosh(), b * t.sinh());
        type Case<'a> = (&'a Form<3, 4>, &'a dyn Fn(f64) -> (f64, f64), [f64; 2]);
        let cases: [Case; 4] = [
            (&ellipse, &on_ellipse, [0.0, std::f64::consts::TAU]),
            (&ellipse, &on_ellipse, [-1.0, 2.5]),
            (&hyperbola, &on_hyperbola, [-1.5, 2.0]),
            (&hyperbola, &on_hyperbola, [0.25, 0.5]),
        ];
        for (form, known, [from, to]) in cases {
            let range = Interval::new(from, to).unwrap();
            let (curve, _) = form.part([from, to], &mut Budget::new(1000)).unwrap();
            let warp = form.warp(range).unwrap().unwrap();
            let mut last = f64::NEG_INFINITY;
            for k in 0..=200 {
                let t = range.lerp(f64::from(k) / 200.0);
                let at = warp.at(t);
                assert!(last < at);
                last = at;
                let (x, y) = known(t);
                let f = frame();
                let p = f.center + f.x * x + f.y * y;
                let off = (curve.point(at) - p).norm();
                assert!(off <= 1e-14 * (1.0 + p.coords.norm()), "{t}: {off:e}");
            }
        }
    }

    /// A sloped line and a rational curve on an ellipse's extrusion: the same points, to what is said.
    #[test]
    fn curves_are_taken_along() {
        let frame = Frame {
            center: Point3::origin(),
            x: Vector3::x(),
            y: Vector3::y(),
            z: Vector3::z(),
        };
        let ellipse: Form<3, 4> = Form::Ellipse(frame, [2.0, 1.0]);
        let domain = Interval::new(0.0, 6.0).unwrap();
        let warp = ellipse.warp(domain).unwrap().unwrap();
        let span = Interval::new(-1.0, 1.0).unwrap();
        let line = Line::new(Point2::new(0.25, 1.0), Point2::new(5.5, -2.0), span).unwrap();
        let bent = [[0.5, 0.0, 1.0], [6.0, 6.0, 2.0], [4.0, 1.0, 1.0]].map(Vector3::from);
        let knots = vec![-1.0, -1.0, -1.0, 1.0, 1.0, 1.0];
        let bent = NurbsCurve::new(2, bent.to_vec(), knots).unwrap();
        for curve in [Curve::Line(line), Curve::Nurbs(bent)] {
            let numbers = &mut Budget::new(100_000);
            let taken = warp.taken(&curve, span, 0, [6.0; 2], numbers).unwrap();
            assert_eq!(taken.domain(), span);
            for k in 0..=1000 {
                let t = span.lerp(f64::from(k) / 1000.0);
                let (p, q) = (curve.point(t), taken.point(t));
                let off = (warp.at(p.x) - q.x).abs().max((p.y - q.y).abs());
                // Between the points that are looked at it is hardly more.
                assert!(off <= 2.0 * 6.0 * FIT, "{t}: {off:e}");
            }
        }
        // Straight along an axis: two points, exactly.
        let level = Line::new(Point2::new(0.0, 1.5), Point2::new(6.0, 1.5), span).unwrap();
        let level = Curve::Line(level);
        let taken = warp
            .taken(&level, span, 0, [6.0; 2], &mut Budget::new(0))
            .unwrap();
        assert!(matches!(taken, Curve::Line(_)));
        assert_eq!(taken.point(1.0), Point2::new(6.0, 1.5));
    }
}
