//! Native curves and surfaces about the origin and the z axis.

use super::interval;
use feeler::nurbs::{Arc, Curve2, Curve3, Line, Revolution, Surface};
use nalgebra::{Point2, Point3, Vector2, Vector3};

pub(crate) fn line3(a: [f64; 3], b: [f64; 3]) -> Curve3 {
    Curve3::Line(Line::new(Point3::from(a), Point3::from(b), interval(0.0, 1.0)).unwrap())
}

/// By angles from x about z.
pub(crate) fn arc3(center: [f64; 3], z: [f64; 3], radius: f64, turn: [f64; 2]) -> Curve3 {
    let z = Vector3::from(z);
    Curve3::Arc(
        Arc::new(Arc {
            center: Point3::from(center),
            x: Vector3::x(),
            y: z.cross(&Vector3::x()),
            z,
            radius,
            angle: interval(turn[0], turn[1]),
            domain: interval(turn[0], turn[1]),
        })
        .unwrap(),
    )
}

/// An arc in the plane y = 0, by angles from x towards z.
pub(crate) fn arc_xz(center: [f64; 3], radius: f64, turn: [f64; 2]) -> Curve3 {
    arc3(center, [0.0, -1.0, 0.0], radius, turn)
}

/// Turned about the z axis.
pub(crate) fn revolved(profile: Curve3, turn: [f64; 2], transposed: bool) -> Surface {
    Surface::Revolution(
        Revolution::new(Revolution {
            origin: Point3::origin(),
            axis: Vector3::new(0.0, 0.0, 3.0),
            angle: interval(turn[0], turn[1]),
            angle_domain: interval(turn[0], turn[1]),
            profile,
            transposed,
        })
        .unwrap(),
    )
}

pub(crate) fn circle2(center: [f64; 2], radius: f64, turn: [f64; 2]) -> Curve2 {
    Curve2::Arc(
        Arc::new(Arc {
            center: Point2::from(center),
            x: Vector2::x(),
            y: Vector2::y(),
            z: Vector2::zeros(),
            radius,
            angle: interval(turn[0], turn[1]),
            domain: interval(turn[0], turn[1]),
        })
        .unwrap(),
    )
}
