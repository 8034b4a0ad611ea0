//! The products of a patch of a surface of revolution, of half the degree that those of any net have along the angle.
//!
//! # What is proven
//! Let `c` be a point of the axis, exactly. A point `S` of the surface is as far from it as the point `P` of the profile that it was turned from. So, about the
//! net's zero `z`, with `d = c - z`, `X = (S - z) w` and the profile's homogeneous points `Q = (P - c) w`,
//! ```text
//! |X|^2 = |S - c|^2 w^2 + 2 d.(S - c) w^2 + |d|^2 w^2 = |Q|^2 - |d|^2 w^2 + 2 d.(X w),
//! ```
//! where `Q` and `w` hang on the profile's parameter alone, and `X w` is linear in the cosine and the sine of the angle: of the degree of these, and twice that of
//! the profile, are all of the parts of `N`. Where the profile is an arc, `P = m + r (cos b, sin b)`, its weights are 1 and
//! `|P - c|^2 = |m - c|^2 + r^2 + 2 (m - c).(P - m)` is linear in the cosine and the sine of `b`, too.
//!
//! What the polynomials of these leave out is in the radii (see [`Spans`](super::circle::Spans)), each of which allows for what first and second derivatives are off at any
//! degree from that of the cosine on; products with functions of the other parameter keep that.
//!
//! The sums cancel what is as large as `|d|^2`, so they are used where the axis is near (see [`NEAR`]): else the general products have more digits.

use super::net::{Coefficients, Net, Products};
use super::quotient::sum_bounds;
use super::spline::Homogeneous;
use super::turned::Turned;
use crate::numeric::bernstein::Bidegree;
use crate::numeric::{Ball, Real};

/// The axis is near where it is no farther from the net's zero than this times the net's size, in the largest coordinate of each: a whole turn is cut into spans of 22.5
/// degrees, so it is up to nine times where the profile is short. What is lost then is a few bits.
const NEAR: f64 = 16.0;
impl<T: Real> Turned<T> {
    /// The products of the patch's net; none where the axis is far from it.
    pub(super) fn products(&self, net: &Net<T>) -> Option<Products<T>> {
        let c = self.next_on_axis(&net.origin);
        let d: [Ball<T>; 3] = std::array::from_fn(|k| c[k] - Ball::exact(net.origin[k]));
        let size = |x: [f64; 3]| x[0].max(x[1]).max(x[2]);
        let reach = size([net.reach[0], net.reach[1], net.reach[2]]);
        // Negated: what is no number is not near.
        if !(size(d.map(|x| x.magnitude())) <= NEAR * reach) {
            return None;
        }
        let line = self.along_profile(self.profile.points.len() - 1);
        // `|Q|^2` and `w^2` along the profile, and `X w`.
        let (square, weight, b) = match &self.profile.arc {
            Some(_) => (
                self.square_of_arc(&c)?,
                Coefficients::ones(),
                std::array::from_fn(|k| net.coordinate(k)),
            ),
            None => {
                let q = self.profile.points.iter().map(|p| {
                    let q = |k: usize| p[k] - p[3] * c[k];
                    [q(0), q(1), q(2), p[3]]
                });
                let q = Net::new(line, q.collect(), [0.0; 3]);
                let w = q.coordinate(3);
                let weight = match net.unit_weights {
                    true => Coefficients::ones(),
                    false => w.times(line, &w, line),
                };
                let b = |k: usize| net.coordinate(k).times(net.degree, &w, line);
                (q.square(&weight), weight, [b(0), b(1), b(2)])
            }
        };
        let degree = match &self.profile.arc {
            Some(_) => net.degree,
            None => net.degree + line,
        };
        let weight = self.spread(degree, weight);
        let a = about(&d, self.spread(degree, square), &b, &weight);
        Some(Products {
            degree,
            a,
            b,
            c: weight,
            unit_weights: net.unit_weights,
        })
    }

    /// A point of the axis, exactly within its bounds, next to another.
    fn next_on_axis(&self, point: &[f64; 3]) -> [Ball<T>; 3] {
        let along = (0..3).map(|k| self.axis[k].mid.approximate() * (point[k] - self.origin[k]));
        let along = Ball::exact(along.sum());
        std::array::from_fn(|k| Ball::exact(self.origin[k]) + along * self.axis[k])
    }

    /// The degree of a function of the profile's parameter.
    fn along_profile(&self, n: usize) -> Bidegree {
        match self.transposed {
            true => Bidegree { u: n, v: 0 },
            false => Bidegree { u: 0, v: n },
        }
    }

    /// `|P - c|^2` along an arc.
    fn square_of_arc(&self, c: &[Ball<T>; 3]) -> Option<Coefficients<T>> {
        let arc = self.profile.arc.as_ref()?;
        let squared = |x: &[Ball<T>; 3]| x[0].square() + x[1].square() + x[2].square();
        let [m, x] = [&arc.center, &arc.x].map(|p| [p[0], p[1], p[2]]);
        let to_center = std::array::from_fn(|k| m[k] - c[k]);
        let least = squared(&to_center) + squared(&x);
        let two = Ball::exact(2.0);
        let points = self.profile.points.iter().map(|p| {
            let dot = (0..3).fold(Ball::ZERO, |s, k| s + to_center[k] * (p[k] - m[k]));
            [least + two * dot, Ball::ZERO, Ball::ZERO, Ball::ONE]
        });
        let points: Vec<Homogeneous<T, 4>> = points.collect();
        let line = self.along_profile(points.len() - 1);
        Some(Net::new(line, points, [0.0; 3]).coordinate(0))
    }

    /// A function of the profile's parameter, of its degree along that, as one of both.
    fn spread(&self, degree: Bidegree, line: Coefficients<T>) -> Coefficients<T> {
        let own = line.values.iter().copied();
        let values = match self.transposed {
            true => own
                .flat_map(|x| std::iter::repeat_n(x, degree.v + 1))
                .collect(),
            false => std::iter::repeat_n(own, degree.u + 1).flatten().collect(),
        };
        Coefficients { values, ..line }
    }
}

/// `a - |d|^2 c + 2 d.b`.
fn about<T: Real>(
    d: &[Ball<T>; 3],
    a: Coefficients<T>,
    b: &[Coefficients<T>; 3],
    c: &Coefficients<T>,
) -> Coefficients<T> {
    let square = d[0].square() + d[1].square() + d[2].square();
    let bounds = sum_bounds((d, &square), &a, b, c);
    let two = T::from_f64(2.0);
    let of = |k: usize| c.values.get(k).copied().unwrap_or(T::ONE);
    let sum = a.values.iter().enumerate().map(|(k, a)| {
        let along =
            d[0].mid * b[0].values[k] + d[1].mid * b[1].values[k] + d[2].mid * b[2].values[k];
        *a - square.mid * of(k) + two * along
    });
    let values: Vec<T> = sum.collect();
    Coefficients::summed(values, bounds, c)
}

#[cfg(test)]
mod tests {
    use super::super::Quotient;
    use super::super::patch::{Patch, surface_patches};
    use super::super::turned::tests::{arc, line, revolution};
    use super::*;
    use crate::numeric::{Dd, Interval};
    use crate::nurbs::{Curve3, Line, NurbsCurve, Surface};
    use nalgebra::{Point3, Vector4};

    /// A segment, an arc, a cubic, and one with weights.
    fn profiles() -> [Curve3; 4] {
        let cubic = |weights: [f64; 4]| {
            let points = [[2.0, 0.0], [3.0, 1.0], [1.5, 1.5], [2.5, 3.0]];
            let points = points.iter().zip(weights);
            let points = points.map(|([x, z], w)| Vector4::new(x * w, 0.1 * w, z * w, w));
            let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
            Curve3::Nurbs(NurbsCurve::new(3, points.collect(), knots).unwrap())
        };
        let weights = [1.0, 0.5, 8.0, 2.0];
        [line(), arc(), cubic([1.0; 4]), cubic(weights)]
    }

    /// With the stored point of the axis some way off.
    fn far_along(profile: &Curve3, transposed: bool) -> Surface {
        let mut surface = revolution(profile.clone(), transposed);
        if let Surface::Revolution(s) = &mut surface {
            s.origin -= s.axis * 50.0;
        }
        surface
    }

    /// The value of a polynomial and what its derivatives along u and v are.
    fn jet(c: &[f64], degree: Bidegree, [s, t]: [f64; 2]) -> [Ball<Dd>; 3] {
        let line = |mut c: Vec<[Ball<Dd>; 2]>, x: f64| {
            let n = c.len() - 1;
            let x = Ball::exact(x);
            let y = Ball::ONE - x;
            let mut slope = Ball::ZERO;
            for left in (1..=n).rev() {
                if left == 1 {
                    slope = (c[1][0] - c[0][0]) * Ball::exact(n as f64);
                }
                for i in 0..left {
                    c[i] = [0, 1].map(|k| y * c[i][k] + x * c[i + 1][k]);
                }
            }
            [c[0][0], c[0][1], slope]
        };
        let rows = c.chunks_exact(degree.v + 1).map(|row| {
            let row = row.iter().map(|x| [Ball::exact(*x), Ball::ZERO]);
            let [value, _, slope] = line(row.collect(), t);
            [value, slope]
        });
        let [value, along_v, along_u] = line(rows.collect(), s);
        [value, along_u, along_v]
    }

    /// `|X - q w|^2` and its derivatives, by the net in double-double.
    fn truth(fine: &Patch<Dd>, q: &Point3<f64>, [s, t]: [f64; 2]) -> [Ball<Dd>; 3] {
        let net = &fine.net;
        let j = net.jet(Ball::exact(s), Ball::exact(t));
        let arm = |h: &Homogeneous<Dd, 4>| -> [Ball<Dd>; 3] {
            std::array::from_fn(|k| h[k] - h[3] * Ball::difference(q[k], net.origin[k]))
        };
        let dot = |a: &[Ball<Dd>; 3], b: &[Ball<Dd>; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let [x, along_u, along_v] = [j.value, j.s, j.t].map(|h| arm(&h));
        let two = Ball::exact(2.0);
        [
            dot(&x, &x),
            two * dot(&x, &along_u),
            two * dot(&x, &along_v),
        ]
    }

    #[test]
    fn they_hold_the_distance_and_its_slopes() {
        for (profile, transposed) in profiles().iter().flat_map(|p| [(p, false), (p, true)]) {
            let surface = far_along(profile, transposed);
            let fine = surface_patches::<Dd>(&surface);
            for (k, coarse) in surface_patches::<f64>(&surface).iter().enumerate() {
                let net = &coarse.net;
                let own = coarse
                    .turned
                    .as_ref()
                    .and_then(|t| t.products(net))
                    .unwrap();
                let general = net.products();
                let turn = if transposed {
                    own.degree.v
                } else {
                    own.degree.u
                };
                assert_eq!(turn, super::super::circle::degree::<f64>());
                let q = Point3::new(0.5 * k as f64, 1.0 - 0.25 * k as f64, 2.0);
                let [f, other] = [&own, &general].map(|p| Quotient::squared_distance(&q, net, p));
                assert!(
                    f.n_error < 64.0 * other.n_error,
                    "{} {}",
                    f.n_error,
                    other.n_error
                );
                let most = f.c.iter().copied().fold(1.0, f64::max);
                for at in [
                    [0.0, 0.0],
                    [0.3, 0.9],
                    [0.5, 0.5],
                    [1.0, 0.25],
                    [0.0625, 1.0],
                ] {
                    let found = jet(&f.n, f.degree, at);
                    let told = truth(&fine[k], &q, at);
                    let allowed = [
                        f.n_error,
                        2.0 * f.degree.u as f64 * f.n_error,
                        2.0 * f.degree.v as f64 * f.n_error,
                    ];
                    for (m, allowed) in allowed.into_iter().enumerate() {
                        let off = (found[m] - told[m]).magnitude();
                        assert!(off <= allowed * most, "{m} {off:e} {allowed:e} {profile:?}");
                    }
                    if !f.c.is_empty() {
                        let weight = fine[k]
                            .net
                            .jet(Ball::exact(at[0]), Ball::exact(at[1]))
                            .value[3];
                        let off = (jet(&f.c, f.degree, at)[0] - weight.square()).magnitude();
                        assert!(off <= f.c_error * most, "{off:e}");
                    }
                }
            }
        }
    }

    /// A patch of a millionth of the radius: what would cancel is far above it.
    #[test]
    fn next_to_a_far_axis_there_are_none() {
        const NARROW: f64 = 1e-6;
        let ends = [0.5, 0.5 + NARROW].map(|z| Point3::new(2.0, 0.0, z));
        let domain = Interval {
            start: 0.0,
            end: NARROW,
        };
        let short = Line::new(ends[0], ends[1], domain).unwrap();
        let mut surface = revolution(Curve3::Line(short), false);
        if let Surface::Revolution(s) = &mut surface {
            s.angle = domain;
        }
        let patches = surface_patches::<f64>(&surface);
        assert!(!patches.is_empty());
        for patch in patches {
            let turned = patch.turned.as_ref().expect("a revolution's");
            assert!(turned.products(&patch.net).is_none());
        }
    }
}
