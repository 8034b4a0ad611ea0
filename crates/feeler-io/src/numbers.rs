//! How many numbers geometry holds: what a copy of it costs.

use feeler::brep::Brep;
use feeler::nurbs::{Curve, NurbsCurve, Surface};

/// How many numbers a spline holds.
pub(crate) fn numbers_of_spline<const H: usize>(n: &NurbsCurve<H>) -> usize {
    H * n.control_points().len() + n.knots().knots().len()
}

pub(crate) fn numbers_of_curve<const D: usize, const H: usize>(c: &Curve<D, H>) -> usize {
    match c {
        Curve::Nurbs(n) => numbers_of_spline(n),
        Curve::Polyline(p) => (D + 1) * p.points().len(),
        // Segments are never poly-curves themselves.
        Curve::Poly(p) => p.segments().iter().map(numbers_of_curve).sum(),
        Curve::Line(_) | Curve::Arc(_) => 20,
    }
}

/// How many numbers a surface holds.
pub(crate) fn numbers_of_surface(s: &Surface) -> usize {
    match s {
        Surface::Nurbs(n) => {
            4 * n.control_net().len() + n.knots_u().knots().len() + n.knots_v().knots().len()
        }
        Surface::Revolution(r) => 20 + numbers_of_curve(&r.profile),
        Surface::Sum(s) => 3 + numbers_of_curve(&s.first) + numbers_of_curve(&s.second),
        Surface::Plane(_) => 20,
    }
}

/// How many numbers a BREP holds, roughly: what a copy of it costs.
pub(crate) fn numbers(brep: &Brep) -> usize {
    let p = brep.parts();
    let surfaces = p.surfaces.iter().map(numbers_of_surface);
    let curves: usize = p.curves2.iter().map(numbers_of_curve).sum();
    let curves3: usize = p.curves3.iter().map(numbers_of_curve).sum();
    let items = p.vertices.len() + p.edges.len() + p.trims.len() + p.loops.len() + p.faces.len();
    surfaces.sum::<usize>() + curves + curves3 + 20 * items
}
