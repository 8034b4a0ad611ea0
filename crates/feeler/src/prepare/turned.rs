//! Images of trim curves on surfaces of revolution, of a degree that can be worked with.
//!
//! A patch of a revolution has degree 11 along the angle (19 in double-double, see [`circle`](super::circle)), on a sphere or a torus along both
//! parameters: composed with a cubic trim it would have degree 66 (114). But along a trim the angle itself is a
//! smooth function of one parameter, so its cosine and sine are replaced by polynomials along the trim, as [`circle`](super::circle)
//! replaces them along the angle, and what is left out goes into the radius of the coefficients. A cubic trim on a cylinder is then of
//! degree 15 or so in f64, not 36, and on a sphere of degree 25.
//!
//! # What is left out
//!
//! Let the trim be `s(x) = U(x) / W(x)` with `x` in `[-1, 1]`, `U` and `W` polynomials, `m` about `s(0)` and the angle `a + b s`.
//! Then `f(x) = cos(a + b m + d(x))`, `d = b (U - m W) / W`, is analytic where `W` has no zero. For `|z| <= r`, with
//! `D(r) = |b| sum |U_i - m W_i| r^i / (|W_0| - sum_(i>0) |W_i| r^i)` and a denominator above zero, `|d(z)| <= D` and so
//! `|f(z)| <= cosh(D) <= e^D` and `|f(z) - cos(a + b m)| <= D e^D`. By Cauchy's estimate the Taylor coefficients are `|f_k| <= E r^-k`
//! for `k > 0`, with `E = min(1, D) e^D`. With `q = 1 / r <= 1/2` and
//! `n` the degree that is kept, for `|x| <= 1`, `M = n + 1`:
//!
//! - what is left out is at most `E q^M / (1 - q)`,
//! - its derivative `E q^M M / (1 - q)^2`,
//! - its second derivative `E q^M (M^2 + M + 2) / (1 - q)^3`.
//!
//! The radius put into the coefficients is `R = 4 E q^M / (1 - q)^3`. The search allows `2 n R` and `4 n (n - 1) R` for the
//! derivatives in the local parameter `(x + 1) / 2`, whose derivatives are twice and four times those above (see
//! [`circle::Spans`](super::circle)): `2 M <= 8 n` holds, and `4 (M^2 + M + 2) <= 16 n (n - 1)` for `n >= 3`. A polynomial that
//! is exact, the angle being constant, leaves nothing out. Sine likewise.

use super::circle::{bernstein, next_row, row};
use super::compose::{MAX_COMPOSED_DEGREE, Poly, Products, compose, compose_bytes};
use super::net::Net;
use super::spline::{BezierCurve, Homogeneous};
use crate::numeric::bernstein::Bidegree;
use crate::numeric::{Ball, Dd, Real, sin_cos};
use std::sync::Arc;

/// How a patch of a surface of revolution is made of its profile and its angle.
#[derive(Clone, Debug)]
pub(crate) struct Turned<T> {
    /// Whether the angle runs along v.
    pub(super) transposed: bool,
    /// The angle at the patch's start, and how much further it is at its end.
    pub(super) angle: [Ball<Dd>; 2],
    /// The axis: a point and the unit vector.
    pub(super) origin: [f64; 3],
    pub(super) axis: [Ball<T>; 3],
    /// The profile over the patch, relative to the origin of space.
    pub(super) profile: Arc<BezierCurve<T, 4>>,
}

/// Curves of more points are not taken: binomials are exact up to here.
const MOST_POINTS: usize = 50;
/// The degree that is kept at most: in f64, and where the unit is finer.
const MOST_TERMS: [i32; 2] = [24, 40];
/// Nothing is asked for that is finer than this part of the size: the floor of full accuracy.
const FINEST: i32 = -96;
/// What is left out is to be below one unit of rounding by this factor (as a power of two)...
const SPARE_BITS: i32 = 2;
/// ...and is never above one unit of rounding by more than this: a shorter part of the curve does better.
const COARSE_BITS: i32 = 8;

/// A quotient of two polynomials about the middle of the unit interval, in powers of `x = 2 t - 1`.
struct Course {
    /// `U - m W` and `W`.
    top: Vec<Ball<Dd>>,
    bottom: Vec<Ball<Dd>>,
    /// `m`, exactly.
    middle: Dd,
}

/// Powers of `x = 2 t - 1` from Bernstein coefficients in `t`.
fn powers<T: Real>(coefficients: impl ExactSizeIterator<Item = Ball<T>>) -> Vec<Ball<Dd>> {
    let n = coefficients.len() - 1;
    let mut polar = row(n);
    let binomial: Vec<f64> = polar.iter().map(|b| b.abs()).collect();
    let mut out = vec![Ball::<Dd>::ZERO; n + 1];
    for (j, b) in coefficients.enumerate() {
        let b = b.to_dd();
        // b_j C(n, j) ((1 - x) / 2)^(n-j) ((1 + x) / 2)^j; the powers of two are exact.
        let b = b * Ball::exact(binomial[j] * power_of_two(-(n as i32)));
        if j > 0 {
            next_row(&mut polar);
        }
        for (o, r) in out.iter_mut().zip(&polar) {
            *o = *o + b * Ball::exact(*r);
        }
    }
    out
}

/// `2^e`, for exponents of normal numbers.
fn power_of_two(e: i32) -> f64 {
    f64::from_bits(((e + 1023).clamp(1, 2046) as u64) << 52)
}

/// The exponent of a number above zero: that of the smallest normal one for those below it.
fn exponent(x: f64) -> i32 {
    ((x.to_bits() >> 52) as i32).max(1) - 1023
}

impl Course {
    /// The coordinate `c` of a homogeneous curve over the unit interval; none where nothing can be said of it.
    fn new<T: Real>(curve: &[Homogeneous<T, 3>], c: usize) -> Option<Self> {
        if curve.len() > MOST_POINTS {
            return None;
        }
        let u = powers(curve.iter().map(|p| p[c]));
        let bottom = if curve.iter().all(|p| p[2].rad == 0.0 && p[2].mid == T::ONE) {
            vec![Ball::ONE]
        } else {
            powers(curve.iter().map(|p| p[2]))
        };
        let middle = (u[0] / bottom[0]).mid;
        let m = Ball {
            mid: middle,
            rad: 0.0,
        };
        let of = |w: usize| bottom.get(w).copied().unwrap_or(Ball::ZERO);
        let top: Vec<_> = u.iter().enumerate().map(|(i, x)| *x - m * of(i)).collect();
        let known = top.iter().chain(&bottom).all(|b| b.rad.is_finite());
        (known && bottom[0].is_above(0.0)).then_some(Self {
            top,
            bottom,
            middle,
        })
    }

    /// The first `count` coefficients of `U / W - m`.
    fn series(&self, count: usize) -> Vec<Ball<Dd>> {
        let mut out: Vec<Ball<Dd>> = Vec::with_capacity(count);
        for i in 0..count {
            let mut rest = self.top.get(i).copied().unwrap_or(Ball::ZERO);
            for (j, w) in self.bottom.iter().enumerate().skip(1).take(i) {
                rest = rest - *w * out[i - j];
            }
            out.push(match self.bottom.len() {
                1 if self.bottom[0].mid == Dd::ONE => rest,
                _ => rest / self.bottom[0],
            });
        }
        out
    }

    /// `D(r)` for a factor `|b|`, from above; infinite where the denominator is not proven to be above zero.
    fn majorant(&self, factor: f64, radius: f64) -> f64 {
        let (mut top, mut bottom, mut power) = (0.0, 0.0, 1.0);
        for i in 0..self.top.len().max(self.bottom.len()) {
            top += self.top.get(i).map_or(0.0, Ball::magnitude) * power;
            if i > 0 {
                bottom += self.bottom.get(i).map_or(0.0, Ball::magnitude) * power;
            }
            power *= radius;
        }
        // Fewer than 128 roundings of sums of positive numbers.
        let left = self.bottom[0].lower() - bottom * UP;
        if left > 0.0 {
            factor * top / left * UP
        } else {
            f64::INFINITY
        }
    }
}

/// A bound that is off by some roundings.
const UP: f64 = 1.0 + 256.0 * f64::EPSILON;

/// How many terms to keep, and the radius for what is left out.
fn terms(course: &Course, factor: f64, unit: f64) -> Option<(usize, f64)> {
    let still = course.top[1..].iter().all(|b| b.magnitude() == 0.0);
    if factor == 0.0 || still && course.bottom.len() == 1 {
        return Some((0, 0.0));
    }
    let most = MOST_TERMS[usize::from(unit < f64::UNIT)];
    // Units are powers of two.
    let unit = exponent(unit).max(FINEST);
    let mut best: Option<(usize, i32)> = None;
    for e in 1..=10 {
        let grown = course.majorant(factor, power_of_two(e));
        if !(grown <= 512.0) {
            break;
        }
        // e^D <= 2^(1.45 D), D < 2^(its exponent + 1); 4 / (1 - q)^3 <= 2^5 for q = 1/2, and less for smaller q.
        let head = 5 + (1.45 * grown).ceil() as i32 + (exponent(grown) + 1).min(0);
        let least = (head - (unit - SPARE_BITS) + e - 1) / e;
        let n = (least - 1).clamp(3, most);
        let left_out = head - e * (n + 1);
        let better = best.is_none_or(|(m, l)| (n as usize, left_out) < (m, l));
        if left_out <= unit + COARSE_BITS && better {
            best = Some((n as usize, left_out));
        }
    }
    best.map(|(n, e)| (n, power_of_two(e.max(-1000))))
}

/// Cosine and sine of `angle[0] + angle[1] s` along a coordinate of a curve: Bernstein coefficients.
fn cos_and_sin<T: Real>(
    angle: &[Ball<Dd>; 2],
    curve: &[Homogeneous<T, 3>],
    c: usize,
) -> Option<[Poly<T>; 2]> {
    let course = Course::new(curve, c)?;
    let (n, left_out) = terms(&course, angle[1].magnitude(), T::UNIT)?;
    let d: Vec<_> = course.series(n + 1).iter().map(|x| *x * angle[1]).collect();
    let m = Ball {
        mid: course.middle,
        rad: 0.0,
    };
    let (sin, cos) = sin_cos(angle[0] + angle[1] * m + d[0]);
    // f' = -g d' and g' = f d' for f = cos, g = sin.
    let (mut f, mut g) = (vec![cos], vec![sin]);
    for k in 1..=n {
        let (mut df, mut dg) = (Ball::ZERO, Ball::ZERO);
        for j in 1..=k {
            let slope = d[j] * Ball::exact(j as f64);
            df = df - slope * g[k - j];
            dg = dg + slope * f[k - j];
        }
        let k = Ball::exact(k as f64);
        f.push(df / k);
        g.push(dg / k);
    }
    let known = f.iter().chain(&g).all(|b| b.rad.is_finite());
    known.then(|| [bernstein(&f, left_out), bernstein(&g, left_out)])
}

/// The sum of two polynomials in Bernstein form of one degree.
fn sum<T: Real>(a: &Poly<T>, b: &Poly<T>) -> Poly<T> {
    a.iter().zip(b).map(|(x, y)| *x + *y).collect()
}

fn difference<T: Real>(a: &Poly<T>, b: &Poly<T>) -> Poly<T> {
    a.iter().zip(b).map(|(x, y)| *x - *y).collect()
}

fn times<T: Real>(a: &Poly<T>, b: Ball<T>) -> Poly<T> {
    a.iter().map(|x| *x * b).collect()
}

impl<T: Real> Turned<T> {
    /// Whether [`compose`](Self::compose) in an arithmetic of this unit leaves out no more than it may; a part of the curve may
    /// do where the whole does not.
    pub(super) fn composes(&self, curve: &[Homogeneous<T, 3>], unit: f64) -> bool {
        let along = usize::from(self.transposed);
        let does = |c: usize, turn: &Ball<Dd>| {
            let course = Course::new(curve, c);
            course.is_some_and(|course| terms(&course, turn.magnitude(), unit).is_some())
        };
        let arc = self.profile.arc.as_ref();
        does(along, &self.angle[1]) && arc.is_none_or(|arc| does(1 - along, &arc.angle[1]))
    }

    /// The profile along a curve: homogeneous coordinates, each a polynomial.
    fn profile(&self, curve: &[Homogeneous<T, 3>], c: usize) -> Option<[Poly<T>; 4]> {
        if let Some(arc) = &self.profile.arc {
            let [cos, sin] = cos_and_sin(&arc.angle, curve, c)?;
            return Some(std::array::from_fn(|i| {
                let one = vec![arc.center[i]; cos.len()];
                sum(&one, &sum(&times(&cos, arc.x[i]), &times(&sin, arc.y[i])))
            }));
        }
        let along: Vec<Homogeneous<T, 3>> =
            curve.iter().map(|p| [p[c], Ball::ZERO, p[2]]).collect();
        let u = self.profile.points.len() - 1;
        let net = Net::new(Bidegree { u, v: 0 }, self.profile.points.clone(), [0.0; 3]);
        let points = compose(&net, &along)?;
        Some(std::array::from_fn(|i| {
            points.iter().map(|p| p[i]).collect()
        }))
    }

    /// Bytes that [`compose`](Self::compose) takes at most for a curve of degree `k`, with what it gives.
    pub(super) fn compose_bytes(&self, k: usize) -> usize {
        let series = MOST_TERMS[usize::from(T::UNIT < f64::UNIT)] as usize + 1;
        let line = Bidegree {
            u: self.profile.points.len() - 1,
            v: 0,
        };
        // Of the profile along the curve: coefficients of a coordinate, and the work for them.
        let (n, work) = if self.profile.arc.is_some() {
            (series, 0)
        } else if k * line.u > MAX_COMPOSED_DEGREE {
            return 0;
        } else {
            let point = size_of::<Homogeneous<T, 4>>() + size_of::<[f64; 4]>();
            let net = self.profile.points.len() * point;
            (k * line.u + 1, net + compose_bytes::<T>(line, k))
        };
        let ball = size_of::<Ball<T>>();
        // Cosine and sine of two angles, about the middle in double-double first.
        let angles = 8 * series * size_of::<Ball<Dd>>() + 8 * (k + 1) * size_of::<Ball<Dd>>();
        // The profile's coordinates, relative to the axis, and what a coordinate's products are made of.
        let own = Products::<T>::bytes(n, series) + (24 * n + 16 * series) * ball;
        own.max(work + 4 * n * ball).max(angles)
    }

    /// The homogeneous Bezier points of a curve's image, relative to `zero`; `curve` is homogeneous `(s w, t w, w)` in the patch's
    /// local square. `None` where too much would be left out, see [`composes`](Self::composes), or the profile's degree is too high.
    pub(super) fn compose(
        &self,
        curve: &[Homogeneous<T, 3>],
        zero: &[f64; 3],
    ) -> Option<Vec<Homogeneous<T, 4>>> {
        let along = usize::from(self.transposed);
        let [cos, sin] = cos_and_sin(&self.angle, curve, along)?;
        let [x, y, z, w] = self.profile(curve, 1 - along)?;
        // Of the profile's coordinates with cosine and sine.
        let products = Products::new(w.len() - 1, cos.len() - 1);
        // `O + along + cos a r + sin a (axis x r)`, each times the weight.
        let q: Vec<Poly<T>> = [x, y, z]
            .iter()
            .enumerate()
            .map(|(c, p)| difference(p, &times(&w, Ball::exact(self.origin[c]))))
            .collect();
        let axis = &self.axis;
        let height = sum(
            &sum(&times(&q[0], axis[0]), &times(&q[1], axis[1])),
            &times(&q[2], axis[2]),
        );
        let coordinate = |c: usize| {
            let (j, k) = ((c + 1) % 3, (c + 2) % 3);
            let up = times(&height, axis[c]);
            let across = difference(&q[c], &up);
            let turned = difference(&times(&q[k], axis[j]), &times(&q[j], axis[k]));
            let base = Ball::difference(self.origin[c], zero[c]);
            let fixed = products.elevated(&sum(&times(&w, base), &up));
            sum(
                &fixed,
                &sum(&products.of(&across, &cos), &products.of(&turned, &sin)),
            )
        };
        let all = [
            coordinate(0),
            coordinate(1),
            coordinate(2),
            products.elevated(&w),
        ];
        Some(
            (0..all[0].len())
                .map(|i| std::array::from_fn(|c| all[c][i]))
                .collect(),
        )
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::patch::surface_patches;
    use super::super::{Patch, curve_jet, restrict};
    use super::*;
    use crate::numeric::Interval;
    use crate::nurbs::{Arc, Curve3, Line, Revolution, Surface};
    use nalgebra::{Point3, Vector3};

    /// The widest a bound of a composed point may be, in units of the arithmetic...
    const LOOSE: f64 = 4e4;
    /// ...but for what the series leaves out, which is far above a unit of double-double.
    const SERIES: f64 = 1e-28;

    fn random(seed: &mut u64) -> f64 {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        (*seed >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(in super::super) fn revolution(profile: Curve3, transposed: bool) -> Surface {
        let whole = Interval {
            start: 0.0,
            end: std::f64::consts::TAU,
        };
        Surface::Revolution(Revolution {
            profile,
            origin: Point3::new(0.1, -0.2, 0.3),
            axis: Vector3::new(0.0, 0.6, 0.8),
            angle: whole,
            angle_domain: Interval {
                start: -1.0,
                end: 3.0,
            },
            transposed,
        })
    }

    pub(in super::super) fn line() -> Curve3 {
        Curve3::Line(Line {
            from: Point3::new(2.0, 0.0, 0.5),
            to: Point3::new(2.5, 0.25, 4.0),
            domain: Interval {
                start: 0.0,
                end: 1.0,
            },
        })
    }

    pub(in super::super) fn arc() -> Curve3 {
        let angle = Interval {
            start: 0.25,
            end: 1.75,
        };
        Curve3::Arc(Arc {
            center: Point3::new(3.0, 0.0, 0.5),
            x: Vector3::x(),
            y: Vector3::z(),
            z: -Vector3::y(),
            radius: 0.75,
            angle,
            domain: angle,
        })
    }

    /// What the coefficients of a polynomial of degree `n` claim of its values and of its first and second derivatives in the
    /// local parameter: half-widths.
    fn claims<T: Real>(curve: &[Homogeneous<T, 4>], c: usize) -> [f64; 3] {
        let n = (curve.len() - 1) as f64;
        let r = curve.iter().map(|p| p[c].rad).fold(0.0, f64::max);
        [r, 2.0 * n * r, 4.0 * n * (n - 1.0) * r]
    }

    fn derivative<T: Real>(points: &[Homogeneous<T, 4>]) -> Vec<Homogeneous<T, 4>> {
        let n = Ball::exact((points.len() - 1) as f64);
        let step = |p: &[Homogeneous<T, 4>]| std::array::from_fn(|c| n * (p[1][c] - p[0][c]));
        points.windows(2).map(step).collect()
    }

    /// Against the patch itself, evaluated at points of the curve; the derivatives against those of the exact composition, where its
    /// degree allows one.
    fn check<T: Real>(patch: &Patch<T>, curve: &[Homogeneous<T, 3>]) -> usize {
        let turned = patch.turned.as_ref().unwrap();
        let image = turned.compose(curve, &patch.net.origin);
        assert_eq!(image.is_some(), turned.composes(curve, T::UNIT));
        let Some(image) = image else {
            // Both halves; this ends, or the stack does.
            let halves = [[0.0, 0.5], [0.5, 1.0]].map(|[a, b]| restrict(curve, a, b));
            return halves.iter().map(|h| check(patch, h)).max().unwrap();
        };
        let degree = (curve.len() - 1) * (patch.net.degree.u + patch.net.degree.v);
        let exact = compose(&patch.net, curve);
        let two = |image: &[Homogeneous<T, 4>]| {
            let first = derivative(image);
            let second = derivative(&first);
            [first, second]
        };
        let exact = exact.filter(|_| degree <= 60).map(|e| (two(&e), e));
        let own = two(&image);
        for k in 0..=8 {
            let t = Ball::exact(f64::from(k) / 8.0);
            let (p, _) = curve_jet(curve, t);
            let there = patch.net.jet(p[0] / p[2], p[1] / p[2]).value;
            let (here, _) = curve_jet(&image, t);
            for c in 0..3 {
                // As points: the homogeneous ones differ by a factor.
                let apart = here[c] / here[3] - there[c] / there[3];
                assert!(!apart.is_above(0.0) && !(-apart).is_above(0.0), "{apart:?}");
                // And the bounds are good for something.
                let slack = LOOSE * T::UNIT.max(SERIES);
                assert!(
                    (here[c] / here[3]).rad < slack,
                    "{:e}",
                    (here[c] / here[3]).rad
                );
            }
            // Where no weights vary the coordinates themselves, and so their derivatives, are alike.
            let plain = curve.iter().all(|p| p[2].mid == T::ONE);
            let Some(exact) = exact.as_ref().filter(|_| plain) else {
                continue;
            };
            for c in 0..3 {
                let (own_claims, exact_claims) = (claims(&image, c), claims(&exact.1, c));
                for order in 0..2 {
                    let (a, _) = curve_jet(&own[order], t);
                    let (b, _) = curve_jet(&exact.0[order], t);
                    let mut apart = a[c] - b[c];
                    // Each has the differences' own radii, far above what is claimed, for roundings: the middles are compared.
                    let rounding = 1e4 * T::UNIT * (image.len() * degree).pow(2) as f64;
                    let room = own_claims[order + 1] + exact_claims[order + 1] + rounding;
                    apart.rad = 0.0;
                    assert!(apart.magnitude() <= room, "{order} {apart:?} {room:e}");
                }
            }
        }
        image.len() - 1
    }

    fn checks<T: Real>() -> (usize, usize) {
        let mut seed = 0x2545_f491_4f6c_dd1d;
        let mut most = (0, 0);
        for (profile, round) in [(line(), false), (arc(), true)] {
            for transposed in [false, true] {
                let patches = surface_patches::<T>(&revolution(profile.clone(), transposed));
                for degree in [1, 2, 3] {
                    for rational in [false, true] {
                        for k in 0..3 {
                            let patch = &patches[(k * 7) % patches.len()];
                            // A trim with a bend, from somewhere to somewhere on the patch.
                            let mut r = || random(&mut seed);
                            let ends = [[r(), r()], [r(), r()]];
                            let curve: Vec<Homogeneous<T, 3>> = (0..=degree)
                                .map(|i| {
                                    let x = i as f64 / degree as f64;
                                    let w = if rational { 0.5 + r() } else { 1.0 };
                                    let p: [f64; 2] = std::array::from_fn(|c| {
                                        (1.0 - x) * ends[0][c] + x * ends[1][c] + 0.1 * r()
                                    });
                                    [p[0] * w, p[1] * w, w].map(Ball::exact)
                                })
                                .collect();
                            let n = check(patch, &curve);
                            {
                                let most = if round { &mut most.1 } else { &mut most.0 };
                                *most = n.max(*most);
                            }
                        }
                    }
                }
            }
        }
        most
    }

    #[test]
    fn images_are_those_of_the_patch() {
        let (cone, torus) = checks::<f64>();
        assert!(cone <= 27 && torus <= 48, "degrees {cone} and {torus}");
        let (cone, torus) = checks::<Dd>();
        assert!(cone <= 43 && torus <= 80, "degrees {cone} and {torus}");
    }

    /// An angle that does not vary costs next to nothing.
    #[test]
    fn a_constant_angle() {
        let patches = surface_patches::<f64>(&revolution(line(), false));
        let curve: Vec<Homogeneous<f64, 3>> = [0.0, 0.5, 1.0]
            .map(|v| [0.25, v, 1.0].map(Ball::exact))
            .to_vec();
        let turned = patches[3].turned.as_ref().unwrap();
        let image = turned.compose(&curve, &patches[3].net.origin).unwrap();
        assert!(image.len() <= 6, "{}", image.len());
    }
}
