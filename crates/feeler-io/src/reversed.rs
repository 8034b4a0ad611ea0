//! Curves reversed.

use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve, GeometryError, Line, NurbsCurve, PolyCurve, Polyline};

/// The numbers of an interval with the other sign.
pub(crate) fn negated(i: Interval) -> Interval {
    Interval {
        start: -i.end,
        end: -i.start,
    }
}

fn backward(params: &[f64]) -> Vec<f64> {
    params.iter().rev().map(|t| -t).collect()
}

/// The same points in the other direction, at the negated parameter. Exact.
pub(crate) fn reversed_curve<const D: usize, const H: usize>(
    curve: &Curve<D, H>,
) -> Result<Curve<D, H>, GeometryError> {
    Ok(match curve {
        Curve::Line(l) => Curve::Line(Line {
            from: l.to,
            to: l.from,
            domain: negated(l.domain),
        }),
        Curve::Arc(a) => Curve::Arc(Arc {
            y: -a.y,
            z: -a.z,
            angle: negated(a.angle),
            domain: negated(a.domain),
            ..a.clone()
        }),
        Curve::Polyline(p) => {
            let points = p.points().iter().rev().copied().collect();
            Curve::Polyline(Polyline::new(points, backward(p.params()))?)
        }
        Curve::Nurbs(n) => {
            let points = n.control_points().iter().rev().copied().collect();
            let knots = backward(n.knots().knots());
            Curve::Nurbs(NurbsCurve::new(n.degree(), points, knots)?)
        }
        Curve::Poly(p) => {
            let mut segments = Vec::with_capacity(p.segments().len());
            for segment in p.segments().iter().rev() {
                // Segments are never poly-curves themselves: one level deep.
                segments.push(reversed_curve(segment)?);
            }
            Curve::Poly(PolyCurve::new(segments, backward(p.params()))?)
        }
    })
}
