//! Curves that surfaces are made of, as NURBS with the parameter that they have.
//!
//! As a rational curve an arc is run at another pace than its angle, and with it all curves in uv of the face would change. So arcs in curves
//! in pieces become polynomials of the angle: the Taylor polynomial about the middle of each piece of at most 45 degrees. Its
//! remainder, at [`DEGREE`] and half a piece, is (pi/8)^15 / 15! < 7e-19 of the radius: less than rounding.

use super::Problem;
use super::curves::sine_cosine;
use feeler::nurbs::{Arc, Curve, Curve3, NurbsCurve, PolyCurve};
use nalgebra::{Vector3, Vector4};
use std::f64::consts::{FRAC_PI_4, TAU};

/// OCCT holds degrees up to 25.
const DEGREE: usize = 14;

/// A curve in pieces as NURBS over the same parameter; others as they are. Rounded.
pub(super) fn paced(curve: &Curve3) -> Result<Curve3, Problem> {
    let Curve::Poly(poly) = curve else {
        return Ok(curve.clone());
    };
    let mut segments = Vec::with_capacity(poly.segments().len());
    for segment in poly.segments() {
        segments.push(match segment {
            Curve::Arc(a) => Curve::Nurbs(of_angle(a)?),
            other => other.clone(),
        });
    }
    let joined = PolyCurve::new(segments, poly.params().to_vec())?;
    Ok(Curve::Nurbs(Curve3::Poly(joined).to_nurbs()?.nurbs))
}

/// Any curve but a line as NURBS over the same parameter. Rounded.
pub(super) fn paced_all(curve: &Curve3) -> Result<Curve3, Problem> {
    match curve {
        Curve::Arc(a) => Ok(Curve::Nurbs(of_angle(a)?)),
        other => paced(other),
    }
}

/// For each Bernstein polynomial of [`DEGREE`] on [-1, 1] its coefficient in `x^k`: that of `t^k` in
/// `(1 - t)^(n - j) (1 + t)^j`, divided by the binomial coefficient of `n` over `k`.
fn bernstein(k: usize) -> [f64; DEGREE + 1] {
    std::array::from_fn(|j| {
        let mut product = [0.0; DEGREE + 1];
        product[0] = 1.0;
        for factor in 0..DEGREE {
            let sign = if factor < j { 1.0 } else { -1.0 };
            for i in (0..=factor).rev() {
                product[i + 1] += sign * product[i];
            }
        }
        let binomial = (0..k).fold(1.0, |b, i| b * (DEGREE - i) as f64 / (i + 1) as f64);
        product[k] / binomial
    })
}

/// Arcs of more turns are refused, as where the kernel makes NURBS of them: a file may say any number.
const MOST_TURNS: f64 = 64.0;

/// An arc as a spline whose parameter is its own.
fn of_angle(arc: &Arc<3>) -> Result<NurbsCurve<4>, Problem> {
    let turn = arc.angle.length();
    // Negated: what is not a number is refused, too.
    if !(turn <= MOST_TURNS * TAU) {
        return Err(Problem::new(format!(
            "an arc of {:.0} turns: more than {MOST_TURNS:.0} are not written; cut it to one turn first",
            turn / TAU
        )));
    }
    let pieces = (turn / FRAC_PI_4).ceil().max(1.0);
    // The axes, as long as the radius, as the kernel takes them.
    let x = arc.x.normalize();
    let z = arc.z.normalize();
    let x = (x - z * x.dot(&z)).normalize() * arc.radius;
    let y = z.cross(&x);
    let y = if y.dot(&arc.y) < 0.0 { -y } else { y };
    let powers: Vec<_> = (0..=DEGREE).map(bernstein).collect();
    let half = 0.5 * turn / pieces;
    let count = pieces as usize;
    let mut points: Vec<Vector4<f64>> = Vec::with_capacity(count * DEGREE + 1);
    let mut knots = vec![arc.domain.start; DEGREE + 1];
    for piece in 0..count {
        let middle = arc.angle.lerp((piece as f64 + 0.5) / pieces);
        let (sin, cos) = sine_cosine(middle);
        let mut all = [arc.center.coords; DEGREE + 1];
        // Small terms first.
        let mut sums = [Vector3::zeros(); DEGREE + 1];
        for k in (0..=DEGREE).rev() {
            let scale = (1..=k).fold(1.0, |s, i| s * half / i as f64);
            // The k-th derivatives of cosine and sine.
            let (c, s) = [(cos, sin), (-sin, cos), (-cos, -sin), (sin, -cos)][k % 4];
            for (sum, b) in sums.iter_mut().zip(&powers[k]) {
                *sum += (x * c + y * s) * (scale * b);
            }
        }
        for (p, sum) in all.iter_mut().zip(sums) {
            *p += sum;
        }
        if piece > 0 {
            points.pop();
        }
        points.extend(all.map(|p| p.push(1.0)));
        let last = piece + 1 == count;
        let end = if last {
            arc.domain.end
        } else {
            arc.domain.lerp((piece + 1) as f64 / pieces)
        };
        knots.extend(std::iter::repeat_n(end, DEGREE + usize::from(last)));
    }
    Ok(NurbsCurve::new(DEGREE, points, knots)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler::numeric::Interval;
    use nalgebra::Point3;

    /// Against the kernel's own arcs.
    #[test]
    fn arcs_keep_their_pace() {
        for (from, to) in [(0.0, 0.3), (-1.0, 2.0), (0.5, 6.5)] {
            let arc = Arc {
                center: Point3::new(1.0, -2.0, 0.5),
                x: Vector3::new(0.6, 0.8, 0.0),
                y: Vector3::new(0.0, 0.0, 1.0),
                z: Vector3::new(0.8, -0.6, 0.0),
                radius: 2.5,
                angle: Interval::new(from, to).unwrap(),
                domain: Interval::new(3.0, 5.0).unwrap(),
            };
            let spline = Curve3::Nurbs(of_angle(&arc).unwrap());
            let arc = Curve3::Arc(arc);
            for i in 0..=100 {
                let t = arc.domain().lerp(f64::from(i) / 100.0);
                let off = (spline.point(t) - arc.point(t)).amax();
                assert!(off <= 16.0 * f64::EPSILON * 4.0, "{off:e} at {t}");
            }
        }
    }
}
