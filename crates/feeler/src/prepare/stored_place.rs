//! Places of a surface whose points are numbers of the file, or lie between two of them: on planes, straight rows and at control points.
//!
//! There are parameters in f64 there whose point is a given one exactly, as dyadic numbers tell: a guess is made in f64 and tried.

use super::exact::{D3, dot, dyadic, scale, sub, vector};
use crate::numeric::{Dyadic, Interval};
use crate::nurbs::{Curve3, KnotVector, NurbsSurface, Plane, Revolution, Surface};

/// Parameters within the domain where a surface is exactly at a point, if some are found. They need not be: on a plane none is if the point's parameters
/// are no f64, elsewhere only a profile, straight rows and control points are looked at.
pub(crate) fn stored_place(surface: &Surface, point: &[f64; 3]) -> Option<[f64; 2]> {
    let point = vector(point)?;
    match surface {
        Surface::Plane(s) => on_plane(s, &point),
        Surface::Nurbs(s) => on_parallelogram(s, &point)
            .or_else(|| on_straight_row(s, &point))
            .or_else(|| at_control_point(s, &point)),
        Surface::Revolution(s) => on_profile(s, &point),
        Surface::Sum(_) => None,
    }
}

/// The part of the way from one number to another at which a parameter stands in its domain, as a quotient.
fn part(at: f64, of: Interval) -> Option<[Dyadic; 2]> {
    let start = dyadic(of.start)?;
    Some([&dyadic(at)? - &start, &dyadic(of.end)? - &start])
}

/// A parameter and its neighbours: a guess may be a rounding or two off.
fn next_to(guess: f64, domain: Interval) -> impl Iterator<Item = f64> {
    let near = [
        guess,
        guess.next_down(),
        guess.next_up(),
        guess.next_down().next_down(),
        guess.next_up().next_up(),
    ];
    near.into_iter().filter(move |x| domain.contains(*x))
}

fn on_plane(s: &Plane, point: &D3) -> Option<[f64; 2]> {
    let axes = [vector(s.x.as_slice())?, vector(s.y.as_slice())?];
    let off = sub(point, &vector(s.origin.coords.as_slice())?);
    spanned(&off, &axes, s.domain, s.extents)
}

/// A bilinear surface of weights 1 whose control points are the corners of a parallelogram.
fn on_parallelogram(s: &NurbsSurface, point: &D3) -> Option<[f64; 2]> {
    let [p00, p01, p10, p11] = s.control_net() else {
        return None;
    };
    let degrees = [s.knots_u().degree(), s.knots_v().degree()];
    if degrees != [1, 1] || [p00, p01, p10, p11].iter().any(|p| p.w != 1.0) {
        return None;
    }
    let [p00, p01, p10, p11] = [
        vector(p00.as_slice())?,
        vector(p01.as_slice())?,
        vector(p10.as_slice())?,
        vector(p11.as_slice())?,
    ];
    let axes = [sub(&p10, &p00), sub(&p01, &p00)];
    if sub(&p11, &p01) != axes[0] {
        return None;
    }
    let unit = Interval {
        start: 0.0,
        end: 1.0,
    };
    spanned(&sub(point, &p00), &axes, s.domain(), [unit; 2])
}

/// Parameters at which `a x + b y` is a vector, with `a` and `b` from extents as parameters run over their domains.
fn spanned(
    off: &D3,
    [x, y]: &[D3; 2],
    domain: [Interval; 2],
    extents: [Interval; 2],
) -> Option<[f64; 2]> {
    let [xx, xy, yy] = [dot(x, x), dot(x, y), dot(y, y)].map(|d| d.approximate());
    let [wx, wy] = [dot(off, x), dot(off, y)].map(|d| d.approximate());
    let determinant = xx * yy - xy * xy;
    let along = [wx * yy - wy * xy, wy * xx - wx * xy].map(|a| a / determinant);
    let guess = [0, 1].map(|k| {
        let (from, to) = (extents[k], domain[k]);
        if from == to {
            along[k]
        } else {
            to.start + (along[k] - from.start) / from.length() * to.length()
        }
    });
    // `a = start + p / q (end - start)` of the extents, for the part `p / q` of the domain.
    let coordinate = |k: usize, at: f64| -> Option<[Dyadic; 2]> {
        let [p, q] = part(at, domain[k])?;
        let (start, end) = (dyadic(extents[k].start)?, dyadic(extents[k].end)?);
        Some([&(&start * &q) + &(&p * &(&end - &start)), q])
    };
    for u in next_to(guess[0], domain[0]) {
        let [a, below_a] = coordinate(0, u)?;
        for v in next_to(guess[1], domain[1]) {
            let [b, below_b] = coordinate(1, v)?;
            let (of_x, of_y) = (&a * &below_b, &b * &below_a);
            let below = &below_a * &below_b;
            let is_there = |c: usize| &off[c] * &below == &(&of_x * &x[c]) + &(&of_y * &y[c]);
            if (0..3).all(is_there) {
                return Some([u, v]);
            }
        }
    }
    None
}

/// The parameter in a domain at which `s run` is a vector, for the part `s` of the domain.
fn on_segment(off: &D3, run: &D3, domain: Interval) -> Option<f64> {
    let s = dot(off, run).approximate() / dot(run, run).approximate();
    let guess = domain.start + s * domain.length();
    next_to(guess, domain).find(|t| match part(*t, domain) {
        Some([p, q]) => scale(off, &q) == scale(run, &p),
        None => false,
    })
}

/// On the profile where that stands as it is stored: on a segment, or at angle 0 of an arc.
fn on_profile(s: &Revolution, point: &D3) -> Option<[f64; 2]> {
    if s.angle.start != 0.0 {
        return None;
    }
    let t = match &s.profile {
        Curve3::Line(line) => {
            let from = vector(line.from.coords.as_slice())?;
            let run = sub(&vector(line.to.coords.as_slice())?, &from);
            on_segment(&sub(point, &from), &run, line.domain)?
        }
        Curve3::Arc(arc) => {
            // Its direction counts as a unit vector, and is one here.
            let x = vector(arc.x.as_slice())?;
            let off = sub(point, &vector(arc.center.coords.as_slice())?);
            let is_there = dot(&x, &x) == dyadic(1.0)? && off == scale(&x, &dyadic(arc.radius)?);
            if !is_there || !arc.angle.contains(0.0) {
                return None;
            }
            let (from, to) = (arc.angle, arc.domain);
            let guess = to.start - from.start / from.length() * to.length();
            let turned = |t: f64| {
                let [p, q] = part(t, to)?;
                let (start, end) = (dyadic(from.start)?, dyadic(from.end)?);
                Some(&(&start * &q) + &(&p * &(&end - &start)))
            };
            next_to(guess, to).find(|t| turned(*t).is_some_and(|angle| angle.signum() == 0))?
        }
        _ => return None,
    };
    let start = s.angle_domain.start;
    Some(if s.transposed { [t, start] } else { [start, t] })
}

/// At a control point that the surface goes through: where it is of a multiplicity that is its degree, along both parameters.
fn at_control_point(s: &NurbsSurface, point: &D3) -> Option<[f64; 2]> {
    let (net, count) = (s.control_net(), s.counts()[1]);
    let (along_u, along_v) = (through(s.knots_u()), through(s.knots_v()));
    along_u.iter().find_map(|(i, u)| {
        along_v.iter().find_map(|(j, v)| {
            let p = net[i * count + j];
            let own = vector(p.as_slice())?;
            let is_there = scale(point, &dyadic(p.w)?) == own;
            is_there.then_some([*u, *v])
        })
    })
}

/// The control points that a curve with such knots goes through, and where.
///
/// With `p` equal knots, the last of them the `k`-th, the curve is there at its control point `k - p`. (Of `p + 1` equal ones, which there are at an end only, the
/// last counts at the start, the last but one at the end.)
fn through(knots: &KnotVector) -> Vec<(usize, f64)> {
    let (all, degree) = (knots.knots(), knots.degree());
    let mut found = Vec::new();
    let mut next = 0;
    for run in all.chunk_by(|a, b| a == b) {
        next += run.len();
        let beyond = next == all.len() && run.len() > degree;
        let k = next - 1 - usize::from(beyond);
        if run.len() >= degree && k >= degree && knots.domain().contains(run[0]) {
            found.push((k - degree, run[0]));
        }
    }
    found
}

/// On a curve of one parameter that is straight with a constant speed: of degree one, between two control points of one weight that the surface goes through.
fn on_straight_row(s: &NurbsSurface, point: &D3) -> Option<[f64; 2]> {
    let (domain, net) = (s.domain(), s.control_net());
    let (counts, knots) = (s.counts(), [s.knots_u(), s.knots_v()]);
    [0, 1].into_iter().find_map(|k| {
        // It runs along the other parameter.
        let along = 1 - k;
        let ends = through(knots[along]);
        let [(0, from_at), (1, to_at)] = ends.as_slice() else {
            return None;
        };
        let whole = *from_at == domain[along].start && *to_at == domain[along].end;
        if knots[along].degree() != 1 || counts[along] != 2 || !whole {
            return None;
        }
        through(knots[k]).into_iter().find_map(|(at, fixed)| {
            let [a, b] = [0, 1].map(|i| match k {
                0 => net[at * counts[1] + i],
                _ => net[i * counts[1] + at],
            });
            if a.w != b.w {
                return None;
            }
            // All times the weight.
            let (from, to) = (vector(a.as_slice())?, vector(b.as_slice())?);
            let off = sub(&scale(point, &dyadic(a.w)?), &from);
            let t = on_segment(&off, &sub(&to, &from), domain[along])?;
            Some(if k == 0 { [fixed, t] } else { [t, fixed] })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nurbs::{Arc, Line};
    use nalgebra::{Point3, Vector3, Vector4};

    /// Of evaluating in f64 at coordinates below 8: some ten units in their last place.
    const ROUNDINGS: f64 = 8.0 * 8.0 * f64::EPSILON;

    fn interval(start: f64, end: f64) -> Interval {
        Interval { start, end }
    }

    /// The place is found, and the surface is there, up to the rounding of its evaluation; next to it nothing is found.
    fn is_found(surface: &Surface, point: [f64; 3]) {
        let [u, v] = stored_place(surface, &point).unwrap();
        let off = (surface.point(u, v) - Point3::from(point)).norm();
        assert!(off < ROUNDINGS, "{point:?} at {u}, {v}: off by {off}");
        for c in 0..3 {
            for beside in [point[c].next_up(), point[c].next_down(), point[c] + 0.125] {
                let mut moved = point;
                moved[c] = beside;
                if let Some([u, v]) = stored_place(surface, &moved) {
                    // A step along the surface.
                    let off = (surface.point(u, v) - Point3::from(moved)).norm();
                    assert!(off < ROUNDINGS, "{moved:?} at {u}, {v}: off by {off}");
                }
            }
        }
    }

    fn none_is_found(surface: &Surface, point: [f64; 3]) {
        let found = stored_place(surface, &point);
        assert!(found.is_none(), "{point:?} at {found:?}");
    }

    /// `(1, 2, 3) + a (2, 1, 0) + b (0, 1, 4)`; u is `a` moved and scaled by 4, v is `b`.
    #[test]
    fn on_planes() {
        let plane = Plane {
            origin: Point3::new(1.0, 2.0, 3.0),
            x: Vector3::new(2.0, 1.0, 0.0),
            y: Vector3::new(0.0, 1.0, 4.0),
            domain: [interval(10.0, 18.0), interval(-1.0, 1.0)],
            extents: [interval(0.0, 2.0), interval(-1.0, 1.0)],
        };
        let surface = Surface::Plane(Plane::new(plane).unwrap());
        for (a, b) in [(0.0, -1.0), (0.25, 0.5), (1.75, 0.125), (2.0, 1.0)] {
            is_found(&surface, [1.0 + 2.0 * a, 2.0 + a + b, 3.0 + 4.0 * b]);
        }
        none_is_found(&surface, [1.0, 2.0, 3.0f64.next_up()]);
        // Beyond the domain.
        none_is_found(&surface, [1.0 - 2.0 * 0.5, 1.5, 3.0]);
        assert_eq!(stored_place(&surface, &[1.5, 2.75, 5.0]), Some([11.0, 0.5]));
    }

    fn nurbs(degrees: [usize; 2], knots: [&[f64]; 2], points: &[[f64; 4]]) -> Surface {
        let counts = [0, 1].map(|k| knots[k].len() - degrees[k] - 1);
        let net = points.iter().map(|p| Vector4::from(*p)).collect();
        let knots = knots.map(<[f64]>::to_vec);
        Surface::Nurbs(NurbsSurface::new(degrees, counts, net, knots).unwrap())
    }

    #[test]
    fn on_a_parallelogram() {
        let knots: [&[f64]; 2] = [&[0.0, 0.0, 4.0, 4.0], &[-1.0, -1.0, 1.0, 1.0]];
        let corner = |x: f64, y: f64, z: f64| [x, y, z, 1.0];
        let corners = [
            corner(0.0, 0.0, 1.0),
            corner(0.0, 2.0, 2.0),
            corner(4.0, 1.0, 1.0),
            corner(4.0, 3.0, 2.0),
        ];
        let surface = nurbs([1, 1], knots, &corners);
        is_found(&surface, [2.0, 1.5, 1.5]);
        assert_eq!(
            stored_place(&surface, &[1.0, 0.75, 1.25]),
            Some([1.0, -0.5])
        );
        none_is_found(&surface, [2.0, 1.5, 1.5f64.next_up()]);
        // Bent, it goes on along its rows only.
        let mut bent = corners;
        bent[3][2] = 3.0;
        let surface = nurbs([1, 1], knots, &bent);
        is_found(&surface, [0.0, 0.5, 1.25]);
        is_found(&surface, [4.0, 2.0, 2.0]);
        none_is_found(&surface, [2.0, 1.5, 1.5]);
    }

    /// Three parabolas joined, each row from z = 0 to z = 8, of weights 1 and 2; unclamped, as a periodic file has it, or clamped.
    #[test]
    fn on_straight_rows_and_control_points() {
        let clamped: &[f64] = &[0.0, 0.0, 0.0, 1.0, 1.0, 3.0, 3.0, 3.0];
        let unclamped: &[f64] = &[-2.0, 0.0, 0.0, 1.0, 1.0, 3.0, 3.0, 4.0];
        let rows = [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [-1.0, 1.0], [-1.0, 0.0]];
        let weights = [1.0, 2.0, 2.0, 0.5, 1.0];
        let points: Vec<[f64; 4]> = (0..10)
            .map(|i| {
                let ([x, y], w) = (rows[i / 2], weights[i / 2]);
                let z = if i % 2 == 0 { 0.0 } else { 8.0 };
                [w * x, w * y, w * z, w]
            })
            .collect();
        for along_u in [clamped, unclamped] {
            let surface = nurbs([2, 1], [along_u, &[5.0, 5.0, 7.0, 7.0]], &points);
            for z in [0.0, 1.5, 7.0, 8.0] {
                for ([x, y], u) in [(rows[0], 0.0), (rows[2], 1.0), (rows[4], 3.0)] {
                    is_found(&surface, [x, y, z]);
                    let place = stored_place(&surface, &[x, y, z]);
                    assert_eq!(place, Some([u, 5.0 + z / 4.0]));
                }
                none_is_found(&surface, [1.0, 1.0, z]);
            }
            none_is_found(&surface, [1.0, 0.0, 8.5]);
        }
        // Parabolas both ways: their control points at knots.
        let knots: [&[f64]; 2] = [&[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]; 2];
        let points: Vec<[f64; 4]> = (0..9)
            .map(|i| [f64::from(i / 3), f64::from(i % 3), f64::from(i % 2), 1.0])
            .collect();
        let surface = nurbs([2, 2], knots, &points);
        is_found(&surface, [2.0, 2.0, 0.0]);
        is_found(&surface, [0.0, 2.0, 0.0]);
        none_is_found(&surface, [1.0, 1.0, 0.0]);
    }

    #[test]
    fn on_profiles() {
        let turned = |profile: Curve3, start: f64, transposed: bool| {
            let revolution = Revolution {
                origin: Point3::origin(),
                axis: Vector3::z(),
                angle: interval(start, start + 3.0),
                angle_domain: interval(7.0, 9.0),
                profile,
                transposed,
            };
            Surface::Revolution(Revolution::new(revolution).unwrap())
        };
        let line = || {
            let (from, to) = (Point3::new(3.0, 0.0, 0.0), Point3::new(1.0, 0.0, 4.0));
            Curve3::Line(Line::new(from, to, interval(0.0, 5.0)).unwrap())
        };
        for transposed in [false, true] {
            let surface = turned(line(), 0.0, transposed);
            is_found(&surface, [2.5, 0.0, 1.0]);
            is_found(&surface, [1.0, 0.0, 4.0]);
            none_is_found(&surface, [-2.5, 0.0, 1.0]);
            none_is_found(&surface, [0.5, 0.0, 5.0]);
        }
        none_is_found(&turned(line(), 0.5, false), [2.5, 0.0, 1.0]);
        let arc = |x: Vector3<f64>| {
            let arc = Arc {
                center: Point3::new(4.0, 0.0, 1.0),
                x,
                y: Vector3::z(),
                z: -Vector3::y(),
                radius: 1.5,
                angle: interval(-1.0, 2.0),
                domain: interval(0.0, 6.0),
            };
            Curve3::Arc(Arc::new(arc).unwrap())
        };
        let surface = turned(arc(Vector3::x()), 0.0, false);
        is_found(&surface, [5.5, 0.0, 1.0]);
        assert_eq!(stored_place(&surface, &[5.5, 0.0, 1.0]), Some([7.0, 2.0]));
        none_is_found(&surface, [2.5, 0.0, 1.0]);
    }
}
