//! Parameter lines of a NURBS surface that lie in a line in space, exactly.

use super::exact::{D3, Ratio, cross, dyadic, scale, sub, vector};
use crate::numeric::Dyadic;
use crate::nurbs::{KnotVector, NurbsSurface};
use nalgebra::{Point3, Vector3};
use std::cmp::Ordering;

/// The parameters `t` of the line `o + t d` at both ends of the row of a surface at `u = at` (across 0) or `v = at` (across 1); `None`
/// unless all of the row lies in the line, between these two. `span` is the span of the knots across that `at` is in or at an end of.
///
/// # What is proven
/// The row is a rational spline. Its control points are `sum_i N_i(at) P_i`, the columns' control points `P_i` weighted by the basis functions of the
/// span: found here times one positive number, without quotients, so exactly. If each is a point of the line, so is each point of the row, and `t` of
/// a point is a mean of `t` of the control points, with positive weights: between the least of these and the largest. Where these are those of the
/// first and the last control point, which are the row's ends, the row runs over all of the interval and no farther.
///
/// Cost: exact arithmetic on each control point of the span, with some hundred bits for each degree times its successor where knots are ordinary, and no
/// more than [`MOST_BITS`]; it ends with the first point that is not in the line.
pub(crate) fn row_in_line(
    surface: &NurbsSurface,
    across: usize,
    at: f64,
    span: [f64; 2],
    (o, d): (&Point3<f64>, &Vector3<f64>),
) -> Option<[Ratio; 2]> {
    let knots = [surface.knots_u(), surface.knots_v()];
    if !(knots[1 - across].is_clamped() && span[0] <= at && at <= span[1]) {
        return None;
    }
    let (index, ..) = knots[across].spans().find(|(_, a, b)| [*a, *b] == span)?;
    let basis = scaled_basis(knots[across], index, at)?;
    if basis.iter().any(|n| n.bits() > MOST_BITS) {
        return None;
    }
    let first = index - knots[across].degree();
    let (o, d) = (vector(o.coords.as_slice())?, vector(d.as_slice())?);
    let axis = (0..3).find(|c| d[*c].signum() != 0)?;
    let [_, width] = surface.counts();
    let mut ts = Vec::new();
    for along in 0..knots[1 - across].control_points() {
        let (mut x, mut w): (D3, Dyadic) = ([Dyadic::ZERO; 3], Dyadic::ZERO);
        for (i, n) in basis.iter().enumerate() {
            let index = match across {
                0 => (first + i) * width + along,
                _ => along * width + first + i,
            };
            let p = &surface.control_net()[index];
            let own = vector(&[p.x, p.y, p.z])?;
            x = std::array::from_fn(|c| &x[c] + &(n * &own[c]));
            w = &w + &(n * &dyadic(p.w)?);
        }
        let off = sub(&x, &scale(&o, &w));
        if cross(&off, &d).iter().any(|c| c.signum() != 0) {
            return None;
        }
        ts.push(Ratio::new(off[axis].clone(), &d[axis] * &w));
    }
    let (first, last) = (ts.first()?, ts.last()?);
    let (low, high) = match first.cmp(last) {
        Ordering::Greater => (last, first),
        _ => (first, last),
    };
    let within = |t: &Ratio| t.cmp(low).is_ge() && t.cmp(high).is_le();
    ts.iter().all(within).then(|| [first.clone(), last.clone()])
}

/// Basis functions of more bits than this are given up: knots of ordinary sizes give less for degree 25.
const MOST_BITS: usize = 1 << 16;

/// The basis functions that are not zero on a span, at a parameter in it or at an end of it, all times one positive number.
///
/// Algorithm A2.2 of *The NURBS Book*, where each level is multiplied by all of the widths that it divides by.
fn scaled_basis(knots: &KnotVector, index: usize, at: f64) -> Option<Vec<Dyadic>> {
    let knot = |i: usize| dyadic(knots.knots()[i]);
    let at = dyadic(at)?;
    let mut values = vec![dyadic(1.0)?];
    for level in 1..=knots.degree() {
        let mut shares = Vec::new();
        for r in 0..level {
            let (low, high) = (knot(index + 1 + r - level)?, knot(index + 1 + r)?);
            shares.push([&at - &low, &high - &at, &high - &low]);
        }
        let mut next = vec![Dyadic::ZERO; level + 1];
        for (r, value) in values.iter().enumerate() {
            let others = shares.iter().enumerate().filter(|(l, _)| *l != r);
            let part = others.fold(value.clone(), |x, (_, [.., width])| &x * width);
            let [past, left, _] = &shares[r];
            next[r] = &next[r] + &(left * &part);
            next[r + 1] = &next[r + 1] + &(past * &part);
        }
        values = next;
    }
    Some(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector4;

    /// A strip whose second half comes to the y axis if it is followed past its start, where the first half is elsewhere.
    #[test]
    fn a_row_is_in_its_span() {
        let rows = [[3.0, 3.0], [1.0, 1.0], [2.0, 3.0]];
        let points = rows
            .iter()
            .flat_map(|[x, z]| [0.0, 1.0].map(|y| Vector4::new(*x, y, *z, 1.0)));
        let knots = [vec![0.0, 0.0, 1.0, 2.0, 2.0], vec![0.0, 0.0, 1.0, 1.0]];
        let surface = NurbsSurface::new([1, 1], [3, 2], points.collect(), knots).unwrap();
        let in_line = |x: f64, z: f64, at: f64, span: [f64; 2]| {
            let (o, d) = (Point3::new(x, 0.0, z), Vector3::y());
            row_in_line(&surface, 0, at, span, (&o, &d)).is_some()
        };
        // At u = 1 both halves have the row (1, y, 1); the second's polynomials at u = 0 give (0, y, -1), where the first is (3, y, 3).
        assert!(in_line(1.0, 1.0, 1.0, [0.0, 1.0]));
        assert!(in_line(1.0, 1.0, 1.0, [1.0, 2.0]));
        assert!(in_line(3.0, 3.0, 0.0, [0.0, 1.0]));
        assert!(!in_line(0.0, -1.0, 0.0, [1.0, 2.0]));
        assert!(!in_line(1.0, 1.0 + f64::EPSILON, 1.0, [1.0, 2.0]));
    }
}
