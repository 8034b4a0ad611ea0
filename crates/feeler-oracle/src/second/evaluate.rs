//! Points and two derivatives of surfaces: exact rationals from truncated powers; cosines, sines and roots in fixed
//! point by series.

use super::fixed::Fixed;
use super::fraction::Fraction;
use super::pieces::{Linear, locate};
use super::rational::{enclosure, rational, rationals, signum};
use super::spline::basis;
use crate::truth::{Evaluation, OracleError, TruthEnclosure};
use feeler::brep::Brep;
use feeler::nurbs::{Arc, Curve3, NurbsSurface, Plane, Revolution, Surface};

/// Bits after the binary point where something is irrational: absolute, so that coordinates of 2^-200 still have 200.
const BITS: usize = 400;

type Vector = [Fraction; 3];
type Blurred = [Fixed; 3];

/// The point of a face's surface at `uv` and its derivatives up to the second; at a knot, from above. 0.1 to 5 ms, by degree.
///
/// # Errors
/// There must be such a face, and `uv` must be in its surface's domain.
pub fn evaluate(breps: &[&Brep], face: usize, uv: [f64; 2]) -> Result<Evaluation, OracleError> {
    let (brep, local) = locate(breps, face)?;
    let surface = brep.surface(local);
    let domain = surface.domain();
    if !(0..2).all(|i| domain[i].contains(uv[i])) {
        return Err(OracleError::Refused(
            "the point is outside the surface's domain".into(),
        ));
    }
    let at = [rational(uv[0])?, rational(uv[1])?];
    match surface {
        Surface::Nurbs(s) => Ok(exact(&of_nurbs(s, &at)?)),
        Surface::Plane(s) => Ok(exact(&of_plane(s, &at)?)),
        Surface::Sum(s) => {
            let base: Vector = triple(s.base.as_slice())?;
            let [p, du, duu] = of_curve(&s.first, &at[0])?;
            let [q, dv, dvv] = of_curve(&s.second, &at[1])?;
            let base = blurred(&base);
            let none = [0, 1, 2].map(|_| Fixed::integer(0, BITS));
            Ok(fixed(&[plus(&base, &plus(&p, &q)), du, dv, duu, none, dvv]))
        }
        Surface::Revolution(s) => of_revolution(s, &at),
    }
}

fn triple(x: &[f64]) -> Result<Vector, OracleError> {
    Ok([rational(x[0])?, rational(x[1])?, rational(x[2])?])
}

fn blurred(v: &Vector) -> Blurred {
    v.each_ref().map(|x| Fixed::new(x, BITS))
}

fn plus(a: &Blurred, b: &Blurred) -> Blurred {
    [0, 1, 2].map(|i| a[i].add(&b[i]))
}

fn times(a: &Blurred, x: &Fixed) -> Blurred {
    a.each_ref().map(|c| c.mul(x))
}

/// Point, du, dv, and the second derivatives: twice along u, along u and v, twice along v.
fn evaluation(all: [[TruthEnclosure; 3]; 6]) -> Evaluation {
    let [point, du, dv, duu, duv, dvv] = all;
    Evaluation {
        point,
        du,
        dv,
        second: [duu, duv, dvv],
    }
}

fn exact(all: &[Vector; 6]) -> Evaluation {
    evaluation(
        all.each_ref()
            .map(|v| v.each_ref().map(|x| enclosure(x, x))),
    )
}

fn fixed(all: &[Blurred; 6]) -> Evaluation {
    let one = |x: &Fixed| -> TruthEnclosure { enclosure(&x.lo(), &x.hi()) };
    evaluation(all.each_ref().map(|v| v.each_ref().map(one)))
}

fn of_nurbs(s: &NurbsSurface, at: &[Fraction; 2]) -> Result<[Vector; 6], OracleError> {
    let (ku, kv) = (s.knots_u(), s.knots_v());
    let (i0, bu) = basis(ku.degree(), &rationals(ku.knots())?, &at[0]);
    let (j0, bv) = basis(kv.degree(), &rationals(kv.knots())?, &at[1]);
    let count = s.counts()[1];
    let zero = || {
        [
            Fraction::ZERO,
            Fraction::ZERO,
            Fraction::ZERO,
            Fraction::ZERO,
        ]
    };
    // X, Y, Z, W: derived k times along u and l times along v, in the order of the answer.
    const ORDERS: [(usize, usize); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];
    let mut sums = ORDERS.map(|_| zero());
    for (i, nu) in bu.iter().enumerate() {
        let mut rows = [zero(), zero(), zero()];
        for (j, nv) in bv.iter().enumerate() {
            let p = &s.control_net()[(i0 + i) * count + j0 + j];
            for c in 0..4 {
                let x = rational(p[c])?;
                for l in 0..3 {
                    rows[l][c] += &nv[l] * &x;
                }
            }
        }
        for (sum, (k, l)) in sums.iter_mut().zip(ORDERS) {
            for c in 0..4 {
                sum[c] += &nu[k] * &rows[l][c];
            }
        }
    }
    let [w, wu, wv, wuu, wuv, wvv] = sums.each_ref().map(|s| &s[3]);
    let a = |k: usize| [0, 1, 2].map(|c| sums[k][c].clone());
    // The product rule for w S = A, solved for the derivatives of S.
    let solve = |a: Vector, terms: &[(&Fraction, &Vector)]| {
        [0, 1, 2].map(|c| {
            let taken = terms
                .iter()
                .fold(Fraction::ZERO, |t, (w, s)| t + *w * &s[c]);
            (&a[c] - taken) / w
        })
    };
    let two = Fraction::from(2u8);
    let point = solve(a(0), &[]);
    let du = solve(a(1), &[(wu, &point)]);
    let dv = solve(a(2), &[(wv, &point)]);
    let duu = solve(a(3), &[(&(wu * &two), &du), (wuu, &point)]);
    let duv = solve(a(4), &[(wu, &dv), (wv, &du), (wuv, &point)]);
    let dvv = solve(a(5), &[(&(wv * two), &dv), (wvv, &point)]);
    Ok([point, du, dv, duu, duv, dvv])
}

fn of_plane(s: &Plane, at: &[Fraction; 2]) -> Result<[Vector; 6], OracleError> {
    let mut map = Vec::with_capacity(2);
    for i in 0..2 {
        let ends = |x: feeler::numeric::Interval| {
            Ok::<_, OracleError>([rational(x.start)?, rational(x.end)?])
        };
        map.push(Linear::new(ends(s.domain[i])?, ends(s.extents[i])?));
    }
    let (x, y) = (triple(s.x.as_slice())?, triple(s.y.as_slice())?);
    let origin = triple(s.origin.coords.as_slice())?;
    let (a, b) = (map[0].at(&at[0]), map[1].at(&at[1]));
    let zero = || [Fraction::ZERO, Fraction::ZERO, Fraction::ZERO];
    Ok([
        [0, 1, 2].map(|c| &origin[c] + &a * &x[c] + &b * &y[c]),
        [0, 1, 2].map(|c| map[0].slope() * &x[c]),
        [0, 1, 2].map(|c| map[1].slope() * &y[c]),
        zero(),
        zero(),
        zero(),
    ])
}

/// Point and two derivatives of a curve in space; at a break, from above.
fn of_curve(curve: &Curve3, t: &Fraction) -> Result<[Blurred; 3], OracleError> {
    let segment = |a: &[f64], b: &[f64], from: [f64; 2]| {
        let map = Linear::new(
            [rational(from[0])?, rational(from[1])?],
            [Fraction::ZERO, Fraction::ONE],
        );
        let (a, b) = (triple(a)?, triple(b)?);
        let (s, slope) = (map.at(t), map.slope());
        let point = [0, 1, 2].map(|c| &a[c] + &s * (&b[c] - &a[c]));
        let derivative = [0, 1, 2].map(|c| &slope * (&b[c] - &a[c]));
        let none = [0, 1, 2].map(|_| Fixed::integer(0, BITS));
        Ok([blurred(&point), blurred(&derivative), none])
    };
    // The part [w_i, w_(i+1)) that holds t; the last one is closed.
    let part = |params: &[f64]| -> Result<usize, OracleError> {
        let w = rationals(params)?;
        Ok(w[..w.len() - 1].iter().rposition(|x| x <= t).unwrap_or(0))
    };
    match curve {
        Curve3::Line(l) => segment(
            l.from.coords.as_slice(),
            l.to.coords.as_slice(),
            [l.domain.start, l.domain.end],
        ),
        Curve3::Polyline(l) => {
            let i = part(l.params())?;
            let (p, w) = (l.points(), l.params());
            segment(
                p[i].coords.as_slice(),
                p[i + 1].coords.as_slice(),
                [w[i], w[i + 1]],
            )
        }
        Curve3::Nurbs(c) => {
            let (first, b) = basis(c.degree(), &rationals(c.knots().knots())?, t);
            let zero = || {
                [
                    Fraction::ZERO,
                    Fraction::ZERO,
                    Fraction::ZERO,
                    Fraction::ZERO,
                ]
            };
            let mut sums = [zero(), zero(), zero()];
            for (i, n) in b.iter().enumerate() {
                let p = &c.control_points()[first + i];
                for k in 0..4 {
                    let x = rational(p[k])?;
                    for l in 0..3 {
                        sums[l][k] += &n[l] * &x;
                    }
                }
            }
            let [a, d, e] = sums;
            let point = [0, 1, 2].map(|k| &a[k] / &a[3]);
            let first = [0, 1, 2].map(|k| (&d[k] - &d[3] * &point[k]) / &a[3]);
            let two = Fraction::from(2u8);
            let second =
                [0, 1, 2].map(|k| (&e[k] - &two * &d[3] * &first[k] - &e[3] * &point[k]) / &a[3]);
            Ok([point, first, second].each_ref().map(blurred))
        }
        Curve3::Arc(arc) => of_arc(arc, t),
        Curve3::Poly(poly) => {
            let i = part(poly.params())?;
            let own = poly.segments()[i].domain();
            let w = [rational(poly.params()[i])?, rational(poly.params()[i + 1])?];
            let map = Linear::new(w, [rational(own.start)?, rational(own.end)?]);
            let [point, first, second] = of_curve(&poly.segments()[i], &map.at(t))?;
            let slope = Fixed::new(&map.slope(), BITS);
            let bend = times(&times(&second, &slope), &slope);
            Ok([point, times(&first, &slope), bend])
        }
    }
}

fn dot(a: &Vector, b: &Vector) -> Fraction {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &a[i] * &b[j] - &a[j] * &b[i])
}

/// Divided by its largest coordinate, which fixed point needs before squares; `None` for zero.
fn scaled(v: &Vector) -> Option<Vector> {
    let size = v
        .iter()
        .map(|x| if signum(x) < 0 { -x.clone() } else { x.clone() })
        .max()?;
    (signum(&size) > 0).then(|| v.each_ref().map(|x| x / &size))
}

/// The unit vector along `v`.
fn unit(v: &Vector) -> Result<Blurred, OracleError> {
    let none = || OracleError::Refused("a frame without a direction".into());
    let v = scaled(v).ok_or_else(none)?;
    let norm = Fixed::new(&dot(&v, &v), BITS).sqrt();
    let mut out = blurred(&v);
    for x in &mut out {
        *x = x.div(&norm).ok_or_else(none)?;
    }
    Ok(out)
}

fn of_arc(arc: &Arc<3>, t: &Fraction) -> Result<[Blurred; 3], OracleError> {
    let map = Linear::new(
        [rational(arc.domain.start)?, rational(arc.domain.end)?],
        [rational(arc.angle.start)?, rational(arc.angle.end)?],
    );
    let (x, z) = (triple(arc.x.as_slice())?, triple(arc.z.as_slice())?);
    let none = || OracleError::Refused("a frame without a direction".into());
    let z = scaled(&z).ok_or_else(none)?;
    // x made orthogonal to z, exactly; y along z x x.
    let share = dot(&x, &z) / dot(&z, &z);
    let x = [0, 1, 2].map(|i| &x[i] - &share * &z[i]);
    let (x, y) = (unit(&x)?, unit(&cross(&z, &x))?);
    let (cos, sin) = Fixed::direction(&map.at(t), BITS);
    let radius = Fixed::new(&rational(arc.radius)?, BITS);
    let center = blurred(&triple(arc.center.coords.as_slice())?);
    let along = plus(&times(&x, &cos), &times(&y, &sin));
    let across = plus(&times(&x, &sin.neg()), &times(&y, &cos));
    let slope = Fixed::new(&map.slope(), BITS);
    let speed = radius.mul(&slope);
    Ok([
        plus(&center, &times(&along, &radius)),
        times(&across, &speed),
        times(&along, &speed.mul(&slope).neg()),
    ])
}

/// Turned by O. Rodrigues' formula.
fn of_revolution(s: &Revolution, at: &[Fraction; 2]) -> Result<Evaluation, OracleError> {
    let (turn, t) = if s.transposed {
        (&at[1], &at[0])
    } else {
        (&at[0], &at[1])
    };
    let map = Linear::new(
        [
            rational(s.angle_domain.start)?,
            rational(s.angle_domain.end)?,
        ],
        [rational(s.angle.start)?, rational(s.angle.end)?],
    );
    let [p, dp, ddp] = of_curve(&s.profile, t)?;
    let origin = blurred(&triple(s.origin.coords.as_slice())?);
    let axis = unit(&triple(s.axis.as_slice())?)?;
    let (cos, sin) = Fixed::direction(&map.at(turn), BITS);
    // cos d + (1 - cos) (a.d) a + sin (a x d), and its derivative in the angle.
    let along = |d: &Blurred| {
        let share = axis[0]
            .mul(&d[0])
            .add(&axis[1].mul(&d[1]))
            .add(&axis[2].mul(&d[2]));
        times(&axis, &share)
    };
    let turned = |d: &Blurred| {
        [(1usize, 2usize), (2, 0), (0, 1)].map(|(i, j)| axis[i].mul(&d[j]).sub(&axis[j].mul(&d[i])))
    };
    let rotated = |d: &Blurred| {
        let fixed = along(d);
        let moving = [0, 1, 2].map(|i| d[i].sub(&fixed[i]));
        plus(
            &fixed,
            &plus(&times(&moving, &cos), &times(&turned(d), &sin)),
        )
    };
    let slope = Fixed::new(&map.slope(), BITS);
    let moving = |d: &Blurred| {
        let fixed = along(d);
        [0, 1, 2].map(|i| d[i].sub(&fixed[i]))
    };
    // The derivatives of `rotated` in the parameter of the angle: once and twice.
    let about = |d: &Blurred| {
        times(
            &plus(&times(&moving(d), &sin.neg()), &times(&turned(d), &cos)),
            &slope,
        )
    };
    let about_twice = |d: &Blurred| {
        let inward = plus(&times(&moving(d), &cos), &times(&turned(d), &sin));
        times(&times(&inward, &slope), &slope.neg())
    };
    let d = [0, 1, 2].map(|i| p[i].sub(&origin[i]));
    let point = plus(&origin, &rotated(&d));
    let (turn, profile) = (about(&d), rotated(&dp));
    let (turn_twice, profile_twice) = (about_twice(&d), rotated(&ddp));
    let mixed = about(&dp);
    Ok(if s.transposed {
        fixed(&[point, profile, turn, profile_twice, mixed, turn_twice])
    } else {
        fixed(&[point, turn, profile, turn_twice, mixed, profile_twice])
    })
}
