//! Curves on surfaces (`ON_CurveOnSurface`) as curves in space.
//!
//! Stored are a curve in uv, perhaps a curve in space beside it, which is some approximation and not used, and the surface. The image is a
//! curve of a kind that there is, with the same parameter, of
//! - lines, polygons and splines on a plane, and arcs on one whose parameters are lengths along axes that are square and of length 1;
//! - lines and polygons on a NURBS surface, and along u and v on surfaces of revolution and sums ([`parameter_lines`](super::parameter_lines)).
//!
//! Up to rounding it is the very image. Of all others there is none here.

use super::archive::Chunk;
use super::class::Class;
use super::curves::{curve, unusable};
use super::parameter_lines::{self, Room, joined};
use super::surfaces::surface;
use crate::error::ReadError;
use feeler::numeric::Interval;
use feeler::nurbs::{
    Arc, Curve, Curve2, Curve3, Line, NurbsCurve, Plane, PolyCurve, Polyline, Surface,
};
use nalgebra::{Point2, Point3, Vector2, Vector3, Vector4};

/// What lengths of axes and the cosine between them may be off by for an arc's image to be taken for an arc: some roundings.
const ROUNDED: f64 = 8.0 * f64::EPSILON;

/// The image of the curve whose data is at hand; one without a form here is refused by its class.
pub(super) fn read(mut data: Chunk<'_>, role: &'static str) -> Result<Curve3, ReadError> {
    let mut room = Room::new(data.left());
    let in_uv: Curve2 = curve(&mut data, "a curve in uv")?;
    if data.i32("whether there is a curve in space")? != 0 {
        let _approximation: Curve3 = curve(&mut data, "a curve in space")?;
    }
    let surface = surface(&mut data)?;
    let image = match &surface {
        Surface::Plane(plane) => on_plane(&in_uv, plane),
        _ => straight(&in_uv, &surface, &mut room),
    };
    let image = image.ok_or_else(|| unusable(Class::CurveOnSurface, &data, role))?;
    data.finish()?;
    Ok(image)
}

/// A plane's point `origin + a x + b y` where `a` and `b` are `at + u per`, of u and of v.
struct Lift<'p> {
    plane: &'p Plane,
    at: [f64; 2],
    per: [f64; 2],
}

impl<'p> Lift<'p> {
    fn new(plane: &'p Plane) -> Self {
        let (mut at, mut per) = ([0.0; 2], [1.0; 2]);
        for c in 0..2 {
            let (domain, extent) = (plane.domain[c], plane.extents[c]);
            if domain != extent {
                per[c] = extent.length() / domain.length();
                at[c] = extent.start - domain.start * per[c];
            }
        }
        Self { plane, at, per }
    }

    /// A homogeneous point.
    fn homogeneous(&self, p: &Vector3<f64>) -> Vector4<f64> {
        let [a, b] = [0, 1].map(|c| self.at[c] * p.z + self.per[c] * p[c]);
        let Plane { origin, x, y, .. } = self.plane;
        (origin.coords * p.z + x * a + y * b).push(p.z)
    }

    fn point(&self, p: &Point2<f64>) -> Point3<f64> {
        self.homogeneous(&p.coords.push(1.0)).xyz().into()
    }

    fn has_unit_axes(&self) -> bool {
        let (x, y) = (self.plane.x, self.plane.y);
        let off = [x.norm() - 1.0, y.norm() - 1.0, x.dot(&y)];
        self.per == [1.0; 2] && off.iter().all(|d| d.abs() <= ROUNDED)
    }

    fn arc(&self, arc: &Arc<2>) -> Option<Curve3> {
        if !self.has_unit_axes() {
            return None;
        }
        let turned = |v: &Vector2<f64>| self.plane.x * v.x + self.plane.y * v.y;
        let (x, y) = (turned(&arc.x), turned(&arc.y));
        let lifted = Arc {
            center: self.point(&arc.center),
            x,
            y,
            z: x.cross(&y),
            radius: arc.radius,
            angle: arc.angle,
            domain: arc.domain,
        };
        Arc::new(lifted).ok().map(Curve::Arc)
    }
}

/// Recursion ends with the segments of a poly-curve, which are none themselves.
fn on_plane(in_uv: &Curve2, plane: &Plane) -> Option<Curve3> {
    let lift = Lift::new(plane);
    match in_uv {
        Curve::Line(l) => {
            let line = Line::new(lift.point(&l.from), lift.point(&l.to), l.domain);
            line.ok().map(Curve::Line)
        }
        Curve::Arc(arc) => lift.arc(arc),
        Curve::Polyline(p) => {
            let points = p.points().iter().map(|q| lift.point(q)).collect();
            let lifted = Polyline::new(points, p.params().to_vec());
            lifted.ok().map(Curve::Polyline)
        }
        Curve::Nurbs(n) => {
            let points = n.control_points().iter().map(|p| lift.homogeneous(p));
            let knots = n.knots().knots().to_vec();
            let lifted = NurbsCurve::new(n.degree(), points.collect(), knots);
            lifted.ok().map(Curve::Nurbs)
        }
        Curve::Poly(p) => {
            let segments = p.segments().iter().map(|s| on_plane(s, plane));
            let lifted = PolyCurve::new(segments.collect::<Option<_>>()?, p.params().to_vec());
            lifted.ok().map(Curve::Poly)
        }
    }
}

/// The image of a line, or of lines in a row. Recursion ends as above.
fn straight(in_uv: &Curve2, surface: &Surface, room: &mut Room) -> Option<Curve3> {
    match in_uv {
        Curve::Line(line) => parameter_lines::image(line, surface, room),
        Curve::Polyline(p) => {
            let pieces = p.points().windows(2).zip(p.params().windows(2));
            let pieces = pieces.map(|(p, t)| {
                let line = Line::new(p[0], p[1], Interval::new(t[0], t[1])?).ok()?;
                Some((t[0], t[1], parameter_lines::image(&line, surface, room)?))
            });
            joined(pieces.collect::<Option<_>>()?)
        }
        Curve::Poly(p) => {
            let pieces = p.segments().iter().zip(p.params().windows(2));
            let pieces = pieces.map(|(s, t)| Some((t[0], t[1], straight(s, surface, room)?)));
            joined(pieces.collect::<Option<_>>()?)
        }
        Curve::Arc(_) | Curve::Nurbs(_) => None,
    }
}
