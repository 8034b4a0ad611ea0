//! Trims without an edge: poles, and edges that are lost.

use crate::sheets::{ROUNDING, SAMPLES, grow};
use feeler::brep::Brep;
use feeler::nurbs::{Curve2, KnotVector, NurbsSurface, Revolution, Surface};
use nalgebra::{Point3, Vector4};

/// One line for each trim without an edge that is no pole: its image is no point. (Of what is wide and comes back between all samples nothing is
/// said; the report on a BREP's health looks as closely as at other trims.)
pub(crate) fn lost_edges(brep: &Brep) -> Vec<String> {
    let parts = brep.parts();
    let largest = { parts.vertices.iter() }.fold(0.0, |a: f64, v| a.max(v.point.coords.amax()));
    let mut found = Vec::new();
    for (t, trim) in parts.trims.iter().enumerate() {
        let face = parts.loops.get(trim.trim_loop).map(|l| l.face);
        let (None, Some(curve), Some(face)) = (trim.edge, parts.curves2.get(trim.curve), face)
        else {
            continue;
        };
        let surface = brep.surface(face);
        if width(surface, curve).is_some_and(|w| w <= ROUNDING * largest) {
            continue;
        }
        let at = |k: u16| {
            let uv = curve.point(trim.span.lerp(f64::from(k) / f64::from(SAMPLES)));
            surface.point(uv.x, uv.y)
        };
        let start = at(0);
        let reach = (1..=SAMPLES).map(|k| (at(k) - start).norm());
        // What is no number reaches anywhere.
        let reach = reach.fold(0.0, |most: f64, x| {
            if x.is_nan() {
                f64::INFINITY
            } else {
                x.max(most)
            }
        });
        if !(reach <= ROUNDING * largest) {
            found.push(format!(
                "face {face}, trim {t}: has no edge, and is no pole: it reaches {reach:.3e}. Its edge is lost, and what the \
                 face meets there is not known; join the faces again (Rhino: ExtractSrf, Join) and save"
            ));
        }
    }
    found
}

/// A length, up to rounding, than which no two points of a curve's image on a surface are farther apart, where it is seen without looking at points: of
/// a parameter line that is a circle of a surface of revolution, or a border of a NURBS surface.
fn width(surface: &Surface, curve: &Curve2) -> Option<f64> {
    // The coordinate that stays as it is, and its value.
    let fixed = |c: usize| {
        let mut hull = [f64::INFINITY, f64::NEG_INFINITY];
        grow(&mut hull, curve, c);
        (hull[0] == hull[1]).then_some(hull[0])
    };
    match surface {
        Surface::Revolution(r) => Some(2.0 * radius(r, fixed(usize::from(!r.transposed))?)),
        Surface::Nurbs(n) => [0, 1]
            .into_iter()
            .find_map(|c| border(n, c, fixed(c)?))
            .and_then(hull_width),
        Surface::Plane(_) | Surface::Sum(_) => None,
    }
}

/// The radius of the circle at a parameter of the profile.
fn radius(revolution: &Revolution, t: f64) -> f64 {
    let off = revolution.profile.point(t) - revolution.origin;
    // Scaled first: squares of a short axis are lost.
    let axis = revolution.axis / revolution.axis.amax();
    off.cross(&axis).norm() / axis.norm()
}

/// The control points of the border at which coordinate `c` is `x`, if the knots are clamped there.
fn border(surface: &NurbsSurface, c: usize, x: f64) -> Option<Vec<Vector4<f64>>> {
    let [count_u, count_v] = surface.counts();
    let knots = [surface.knots_u(), surface.knots_v()][c];
    let at = end_of(knots, x)?;
    let net = surface.control_net();
    let place = |k: usize| [at * count_v + k, k * count_v + at][c];
    let along = [count_v, count_u][c];
    (0..along).map(|k| net.get(place(k)).copied()).collect()
}

/// The control point that a spline goes through at `x`, its first or its last.
fn end_of(knots: &KnotVector, x: f64) -> Option<usize> {
    let (k, p) = (knots.knots(), knots.degree());
    let all = |same: Option<&[f64]>| same.is_some_and(|s| s.iter().all(|k| *k == x));
    if all(k.get(..=p)) {
        Some(0)
    } else if all(k.len().checked_sub(p + 1).and_then(|from| k.get(from..))) {
        knots.control_points().checked_sub(1)
    } else {
        None
    }
}

/// Twice the radius of a ball about one of some control points that holds them all, and so what they span: weights are positive. `None` where
/// one is too far off to be told.
fn hull_width(points: Vec<Vector4<f64>>) -> Option<f64> {
    let mut places = points.iter().map(|q| Point3::from(q.xyz() / q.w));
    let first = places.next()?;
    let mut width = 0.0f64;
    for p in places {
        let own = (p - first).norm();
        if !own.is_finite() {
            return None;
        }
        width = width.max(2.0 * own);
    }
    Some(width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler::numeric::Interval;
    use feeler::nurbs::{Curve, Line, NurbsCurve};
    use nalgebra::{Point2, Vector3};
    use std::f64::consts::TAU;

    /// A line in uv along which coordinate `c` is `x`, over the unit square.
    fn along(c: usize, x: f64) -> Curve2 {
        let ends = [0.0, 1.0].map(|t| {
            let mut p = Point2::new(t, t);
            p[c] = x;
            p
        });
        let domain = Interval::new(0.0, 1.0).unwrap();
        Curve2::Line(Line::new(ends[0], ends[1], domain).unwrap())
    }

    /// The cone z = 1 - distance from the z axis, as a surface of revolution, u and v as told.
    fn cone(transposed: bool) -> Surface {
        let unit = Interval::new(0.0, 1.0).unwrap();
        let ends = [Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 0.0, 1.0)];
        let profile = Curve::Line(Line::new(ends[0], ends[1], unit).unwrap());
        let turn = Revolution {
            origin: Point3::new(0.0, 0.0, 5.0),
            axis: Vector3::new(0.0, 0.0, -2.0),
            angle: Interval::new(0.0, TAU).unwrap(),
            angle_domain: unit,
            profile,
            transposed,
        };
        Surface::Revolution(Revolution::new(turn).unwrap())
    }

    #[test]
    fn circles_of_a_cone() {
        for transposed in [false, true] {
            let (cone, profile) = (cone(transposed), usize::from(!transposed));
            assert_eq!(width(&cone, &along(profile, 1.0)), Some(0.0));
            assert_eq!(width(&cone, &along(profile, 0.0)), Some(2.0));
            assert_eq!(width(&cone, &along(profile, 0.75)), Some(0.5));
            assert_eq!(width(&cone, &along(1 - profile, 0.0)), None);
        }
    }

    /// The squares of such an axis are none that f64 has.
    #[test]
    fn a_short_axis_is_an_axis() {
        let Surface::Revolution(cone) = cone(false) else {
            panic!("a surface of revolution");
        };
        for length in [1e-200, 1e200] {
            let axis = Vector3::new(0.0, 0.0, -length);
            let cone = Revolution {
                axis,
                ..cone.clone()
            };
            assert_eq!([0.0, 0.75, 1.0].map(|t| radius(&cone, t)), [1.0, 0.25, 0.0]);
        }
    }

    /// Control points that f64 cannot place are in no ball: not beside each other, and not where their distance is infinite.
    #[test]
    fn places_that_are_no_numbers_are_no_poles() {
        let same = Vector4::new(1e300, 0.0, 0.0, 1e-300);
        assert_eq!(hull_width(vec![same; 3]), None);
        let apart = [1e308, -1e308].map(|x| Vector4::new(x, 0.0, 0.0, 1.0));
        assert_eq!(hull_width(apart.to_vec()), None);
        let near = [1.0, 3.0].map(|x| Vector4::new(2.0 * x, 0.0, 0.0, 2.0));
        assert_eq!(hull_width(near.to_vec()), Some(4.0));
    }

    /// Three sides of a bilinear patch are as long as they are, one is a point.
    #[test]
    fn borders_of_a_triangle() {
        let knots = || vec![0.0, 0.0, 1.0, 1.0];
        let net = [
            [0.0, 0.0, 0.0, 1.0],
            [0.0, 0.0, 0.0, 2.0],
            [4.0, 0.0, 0.0, 1.0],
            [8.0, 6.0, 0.0, 2.0],
        ];
        let net = net.map(Vector4::from).to_vec();
        let surface =
            Surface::Nurbs(NurbsSurface::new([1, 1], [2, 2], net, [knots(), knots()]).unwrap());
        assert_eq!(width(&surface, &along(0, 0.0)), Some(0.0));
        assert_eq!(width(&surface, &along(0, 1.0)), Some(6.0));
        assert_eq!(width(&surface, &along(1, 0.0)), Some(8.0));
        assert_eq!(width(&surface, &along(1, 1.0)), Some(10.0));
        assert_eq!(width(&surface, &along(1, 0.5)), None);
        let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let bent = [[0.0, 0.0], [0.5, 0.5], [1.0, 0.0]].map(|[u, v]| Vector3::new(u, v, 1.0));
        let bent = Curve2::Nurbs(NurbsCurve::new(2, bent.to_vec(), knots).unwrap());
        assert_eq!(width(&surface, &bent), None);
    }
}
