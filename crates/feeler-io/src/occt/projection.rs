//! Curves in uv of edges on planes, which the format may leave out: the curve in space, projected along
//! the normal. A plane's parameters are affine in space, so that this is exact up to rounding.

use super::curves::{Refusal, refused};
use super::error::TextProblem;
use super::surfaces::Axes;
use feeler::nurbs::{Arc, Curve, Curve2, Curve3, Line, NurbsCurve};
use nalgebra::{Point2, Point3, Vector2, Vector3};

/// An arc whose axis is off the plane's normal by more than this (a sine) becomes an ellipse. An arc taken
/// for parallel is off by the square of that, 2^-52 of its radius: rounding.
const PARALLEL: f64 = 1.0 / (1 << 26) as f64;

/// The parameters of a plane as affine functions of space.
struct Affine {
    origin: Point3<f64>,
    rows: [Vector3<f64>; 2],
}

impl Affine {
    fn new(axes: &Axes) -> Result<Self, Refusal> {
        let (x, y) = (axes.x, axes.y);
        let (xx, xy, yy) = (x.dot(&x), x.dot(&y), y.dot(&y));
        let determinant = xx * yy - xy * xy;
        if !(determinant > 0.0) {
            return Err(TextProblem::Shape {
                what: "the axes of a plane span no plane".into(),
            });
        }
        Ok(Self {
            origin: axes.origin,
            rows: [
                (x * yy - y * xy) / determinant,
                (y * xx - x * xy) / determinant,
            ],
        })
    }

    fn vector(&self, v: &Vector3<f64>) -> Vector2<f64> {
        Vector2::new(self.rows[0].dot(v), self.rows[1].dot(v))
    }

    fn point(&self, p: &Point3<f64>) -> Point2<f64> {
        Point2::from(self.vector(&(p - self.origin)))
    }
}

/// The projection of a curve that the kernel holds, over the same domain.
pub(crate) fn projected(curve: &Curve3, axes: &Axes) -> Result<Curve2, Refusal> {
    let to = Affine::new(axes)?;
    let nurbs = |n: &NurbsCurve<4>| -> Result<Curve2, Refusal> {
        let points = n.control_points().iter().map(|p| {
            let uv = to.vector(&(p.xyz() - to.origin.coords * p.w));
            Vector3::new(uv.x, uv.y, p.w)
        });
        let knots = n.knots().knots().to_vec();
        let curve = NurbsCurve::new(n.degree(), points.collect(), knots);
        Ok(Curve::Nurbs(curve.map_err(refused("a projected curve"))?))
    };
    match curve {
        Curve::Line(l) => {
            let line = Line::new(to.point(&l.from), to.point(&l.to), l.domain);
            Ok(Curve::Line(line.map_err(refused("a projected line"))?))
        }
        Curve::Arc(a) => {
            let normal = axes.x.cross(&axes.y).normalize();
            let axis = a.z.normalize();
            let unit = |v: &Vector3<f64>| (v.norm() - 1.0).abs() <= PARALLEL;
            let square = axes.x.dot(&axes.y).abs() <= PARALLEL;
            if normal.cross(&axis).norm() > PARALLEL || !unit(&axes.x) || !unit(&axes.y) || !square
            {
                let turned = curve.to_nurbs().map_err(refused("a projected circle"))?;
                return nurbs(&turned.nurbs);
            }
            let arc = Arc {
                center: to.point(&a.center),
                x: to.vector(&a.x),
                y: to.vector(&a.z.cross(&a.x)),
                z: Vector2::zeros(),
                radius: a.radius,
                angle: a.angle,
                domain: a.domain,
            };
            Ok(Curve::Arc(
                Arc::new(arc).map_err(refused("a projected circle"))?,
            ))
        }
        Curve::Nurbs(n) => nurbs(n),
        // Never made here.
        Curve::Polyline(_) | Curve::Poly(_) => Err(TextProblem::Unsupported {
            what: "the projection of a curve in pieces".into(),
            remedy: "store the edge's curve on its plane (ShapeFix_Edge)",
        }),
    }
}
