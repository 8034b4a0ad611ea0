//! Faces that a half-space or a ball touches and does not enter, proven in exact numbers: of what touches no enclosure tells that.
//!
//! # What is proven
//! A face is part of its surface, and on a plane part of the hull of its boundary. For a half-space `n.x < h`, `n.x - h` is not negative on
//!
//! - a NURBS surface, if it is at all control points: `n.P - h w >= 0` of homogeneous ones, whose weights are positive;
//! - a plane, if `n` is at right angles to both axes and it is at the origin; else at all control points of the boundary's pieces, taken to space
//!   (the plane's map is affine, so their hull goes to that of the images), and of an arc of a circle at the point of the circle where it is least;
//! - a revolution, if `n` is along its axis and it is on the profile: turning about the axis changes no `n.x`. Of the profile the same control points count;
//! - a sum of a straight curve and another, if it is at both ends of the one with all control points of the other.
//!
//! The inside of a ball of radius r about c is in each half-space `n.x < n.c + r` for a unit vector n, and along the axes these are exact. Of a plane with the normal `N`, no
//! point is nearer than r if `(N.(c - o))^2 >= r^2 N.N` for one of its points, o.
//!
//! What is not told here may be apart all the same.

use super::PreparedBrep;
use super::exact::{D3, cross, dot, dyadic, sub, vector};
use crate::numeric::Dyadic;
use crate::nurbs::{Curve, Curve3, Plane, Surface};
use nalgebra::{Point3, Vector3, Vector4};

/// `n.x >= h`.
struct Above {
    normal: D3,
    height: Dyadic,
}

impl Above {
    fn new(normal: &Vector3<f64>, height: Dyadic) -> Option<Self> {
        Some(Self {
            normal: vector(normal.as_slice())?,
            height,
        })
    }

    /// Of a point.
    fn holds(&self, point: &D3) -> bool {
        dot(&self.normal, point) >= self.height
    }

    /// Of an affine point.
    fn holds_at(&self, point: &Point3<f64>) -> bool {
        vector(point.coords.as_slice()).is_some_and(|p| self.holds(&p))
    }

    /// Of a homogeneous point.
    fn holds_of(&self, p: &Vector4<f64>) -> bool {
        let own = vector(&[p.x, p.y, p.z]).zip(dyadic(p.w));
        own.is_some_and(|(x, w)| dot(&self.normal, &x) >= &self.height * &w)
    }

    /// Of a curve, by its control points.
    fn holds_on(&self, curve: &Curve3) -> bool {
        let segments = match curve {
            Curve::Poly(curves) => curves.segments(),
            one => std::slice::from_ref(one),
        };
        segments.iter().all(|segment| match segment {
            Curve::Line(l) => self.holds_at(&l.from) && self.holds_at(&l.to),
            Curve::Polyline(l) => l.points().iter().all(|p| self.holds_at(p)),
            Curve::Nurbs(c) => c.control_points().iter().all(|p| self.holds_of(p)),
            Curve::Arc(_) | Curve::Poly(_) => false,
        })
    }

    /// The same of what is moved by so much.
    fn moved(&self, by: &Vector3<f64>) -> Option<Self> {
        let by = dot(&self.normal, &vector(by.as_slice())?);
        Some(Self {
            normal: self.normal.clone(),
            height: &self.height - &by,
        })
    }

    fn is_along(&self, axis: &Vector3<f64>) -> bool {
        let axis = vector(axis.as_slice());
        axis.is_some_and(|a| cross(&self.normal, &a).iter().all(|x| x.signum() == 0))
    }

    /// Of a face.
    fn holds_of_face(&self, brep: &PreparedBrep, face: usize) -> bool {
        match brep.brep().surface(face) {
            Surface::Plane(p) => {
                let is_level = |axis: &Vector3<f64>| {
                    let axis = vector(axis.as_slice());
                    axis.is_some_and(|a| dot(&self.normal, &a).signum() == 0)
                };
                if is_level(&p.x) && is_level(&p.y) {
                    return self.holds_at(&p.origin);
                }
                let polygon = brep.polygon(face);
                polygon.is_some_and(|p| p.is_above(&self.normal, &self.height))
            }
            Surface::Nurbs(s) => {
                let polygon = || brep.polygon(face);
                s.control_net().iter().all(|p| self.holds_of(p))
                    || polygon().is_some_and(|p| p.is_above(&self.normal, &self.height))
            }
            Surface::Revolution(r) => self.is_along(&r.axis) && self.holds_on(&r.profile),
            Surface::Sum(s) => {
                let (line, other) = match (&s.first, &s.second) {
                    (Curve::Line(l), other) | (other, Curve::Line(l)) => (l, other),
                    _ => return false,
                };
                [line.from, line.to].iter().all(|end| {
                    let rest = self.moved(&s.base).and_then(|a| a.moved(&end.coords));
                    rest.is_some_and(|a| a.holds_on(other))
                })
            }
        }
    }
}

/// Whether no point of a face is proven to be below the plane `n.x = h`.
pub(crate) fn is_above(
    brep: &PreparedBrep,
    face: usize,
    normal: &Vector3<f64>,
    height: f64,
) -> bool {
    let above = dyadic(height).and_then(|h| Above::new(normal, h));
    above.is_some_and(|a| a.holds_of_face(brep, face))
}

/// Whether no point of a face is proven to be nearer to a point than a radius.
pub(crate) fn is_as_far(
    brep: &PreparedBrep,
    face: usize,
    center: &Point3<f64>,
    radius: f64,
) -> bool {
    let Some(radius) = dyadic(radius) else {
        return false;
    };
    let mut sides = (0..3).flat_map(|k| [(k, 1.0), (k, -1.0)]);
    let is_beside = sides.any(|(k, sign)| {
        let mut normal = Vector3::zeros();
        normal[k] = sign;
        let height = dyadic(sign * center[k]).map(|x| &x + &radius);
        let above = height.and_then(|h| Above::new(&normal, h));
        above.is_some_and(|a| a.holds_of_face(brep, face))
    });
    is_beside
        || match brep.brep().surface(face) {
            Surface::Plane(p) => is_plane_as_far(p, center, &radius).unwrap_or(false),
            _ => false,
        }
}

/// `None` where a number is none, or the axes are parallel.
fn is_plane_as_far(plane: &Plane, center: &Point3<f64>, radius: &Dyadic) -> Option<bool> {
    let axes = [vector(plane.x.as_slice())?, vector(plane.y.as_slice())?];
    let normal = cross(&axes[0], &axes[1]);
    // Axes that are parallel, which f64 may not see, span a line.
    let square = dot(&normal, &normal);
    if square.signum() == 0 {
        return None;
    }
    let origin = vector(plane.origin.coords.as_slice())?;
    let height = dot(&normal, &sub(&vector(center.coords.as_slice())?, &origin));
    let reach = &(radius * radius) * &square;
    Some(&height * &height >= reach)
}
