//! How far images of curves in uv are off, proven without composing them: on cylinders, cones, spheres and tori.
//!
//! Let `f(x) = S(c(t)) - C(t)` over a piece of the parameter, `t = m + h x` and `x` in `[-1, 1]`, on which the curve in uv `c` and the edge
//! `C` are polynomials, or `C` an arc or rational, as ellipses are.
//!
//! **What is left out.** `f` is the sum of its Taylor series about 0, with coefficients that are vectors. With `u(x) = u_0 + d(x)`, and
//! `D = sum_(i>0) |u_i| r^i`, it is `|d(z)| <= D` where `|z| <= r`, there `|Im(u_0 + d)| <= D`, and the complex vector
//! `(cos u, sin u)` has length `sqrt(cosh(2 Im u)) <= e^D`. Likewise for v. So the part of `S` that is no polynomial has at most the length
//! - `(|R| + V |sin|) e^D` of a cylinder or cone, `V` as `D` but with `|v_0|` (along the axis it is a polynomial of c's own degree);
//! - `(R + r' e^E) e^D + r' e^E` of a torus with the radii `R` and `r'`, `E` being `D` of v; a sphere is one with `R = 0`;
//!
//! and an arc of radius `rho` and `a` radians over half the piece `rho e^(a r)`. A rational `C = N / w` has, but for the constant `k = N_0 / w_0`, at most the
//! length `sum_i |N_i - k w_i| r^i / (w_0 - sum_(i>0) |w_i| r^i)`, where what is divided by is positive. With `M` the sum of these, Cauchy's estimate is
//! `|f_k| <= M r^-k` for every k above the degrees of the polynomials. With `n` no less than these, `p` the series up to `x^n`, and `q = 1 / r`,
//! `|f - p| <= e = M q^(n+1) / (1 - q)` on `[-1, 1]`. Each piece has the least such n for which `e` is nothing beside the roundings, or the highest that is kept.
//!
//! **What is left.** A polynomial of degree n that is largest at `cos a` is there in absolute value at most
//! `1 / cos(n pi / 2 N)` times its largest value at the `N + 1` points `cos(j pi / N)`, `N > n`, as one of these is within `pi / 2 N` of `a` as an
//! angle, and a trigonometric polynomial `g` of degree n that is largest at `a` has `g(b) >= g(a) cos(n (a - b))` for `|a - b| <= pi / n` (M. Riesz;
//! H. Ehlich and K. Zeller, "Schwankung von Polynomen zwischen Gitterpunkten", Math. Z. 86, 1964). It serves for vectors: take the component
//! along the largest. Here `N = 4 n`, so the factor is `1 / cos(pi / 8)`, and
//! `|f| <= (max_j |f(x_j)| + e) / cos(pi / 8) + e`.
//!
//! **Roundings.** What is computed of positive numbers alone has a thousandth to spare, which is also room for a middle that is off by `2 PLACE h`. The Taylor
//! coefficients of `c` and of `C` come from derivatives at the middle. The k-th of a spline of degree p is made by k difference quotients, each with four
//! roundings, over spans no shorter than the piece, `2 h`, and `p - k` steps of de Boor's triangle with six each, so that `h^k / k!` times it is off by less
//! than `C(p, k)` times `3 p` units of the largest control point, and no larger than `C(p, k)` times that point: [`COEFFICIENT`] has room for degrees up to 5.
//! Horner's rule adds `p` units to each, and an `x` that is off by two `2 p`: of all the sum is off by less than `2^p 8 p` units in a coordinate ([`horner`]), and
//! in space by less than twice that. Edges of a higher degree than [`DEGREE`] are evaluated by de Boor's triangles of degree 16 at most, 96 roundings of half a unit of the
//! largest control point (of an arc no more: [`Points`]), and there are some dozen for the surface, of numbers up to [`Chart::far`]; an angle that is off moves
//! the point by as much times that: [`FORMULA`], twice, times 1 and the largest angles. The homogeneous points of a rational curve are off by as much of the
//! largest weight `W`, so a point is by twice that times `W / w`. The points `x_j` are hit at the ends of the piece, elsewhere to `2 PLACE`: as
//! angles to 2^-20, as the sine is at least sin(pi / 64) there; [`FACTOR`] has room for that.
//!
//! **The domain.** The image is that of the curve clamped to the surface's domain, which is made to hold it; what straight curves are
//! outside is measured and added ([`cut_off`]); a spline is at most [`slack`] outside ([`stays`]), or the bound is not used: `2^-40` of the domain's larger end, but of no more than 8 in an angle, and of 8 times the body's
//! size where v is a length along a straight line. Each moves a point by no more than that times the farthest, or by that: both together by no more than
//! [`STRAY`], 16 times `2^-40`, times the numbers that roundings are of.

use super::chart::Chart;
use super::pcurve::{FIT, FORMULA};
use super::points::Points;
use crate::sheets::{ROUNDING, stays};
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Curve2, Curve3, NurbsCurve};
use nalgebra::{Point2, SVector};
use std::f64::consts::PI;

/// Edges up to this degree are taken by their Taylor coefficients, others point by point, up to [`MOST_DEGREE`].
const DEGREE: usize = 8;
const MOST_DEGREE: usize = 16;
/// Curves in uv: straight, or fitted cubics and quintics.
const DEGREE_UV: usize = 5;
/// Rational edges.
const DEGREE_RATIONAL: usize = 3;
/// The degree that is kept of what is no polynomial: with less, pieces would be shorter.
const KEPT: usize = 12;
/// What is left out is to be no more than this part of what fitted curves come near, ...
const LEFT_OUT: f64 = FIT / 16.0;
/// ...or pieces are halved, so often and so many.
const HALVINGS: u32 = 10;
const MOST_PIECES: usize = 1024;
/// Where it is no more than this part of the roundings that a bound counts, too, the degree that is kept is high enough.
const ROUNDED_OUT: f64 = 1.0 / 64.0;
/// Discs of radius 2^1 to 2^this are tried.
const RADII: i32 = 8;
/// Roundings of a Taylor coefficient, relative to the largest control point.
const COEFFICIENT: f64 = 1.0 / (1_u64 << 44) as f64;
/// See the [module](self): twice [`MOST_OUTSIDE`] times [`ROUNDING`].
const STRAY: f64 = 1.0 / (1_u64 << 36) as f64;
const MOST_OUTSIDE: f64 = 8.0;
/// A place on a piece is hit to this part of the piece, or there is no bound.
const PLACE: f64 = 1.0 / (1_u64 << 26) as f64;
/// `1 / cos(pi / 8)`, 1.0823923, and room for places that are not hit: `16 tan(pi / 8) 2^-20` is a part of 1e-5.
const FACTOR: f64 = 1.082_45;

/// Bounds on what a coordinate does where `|x| <= r`: from its value in the middle, and in absolute value.
#[derive(Clone, Copy)]
pub(super) struct Disc {
    pub(super) off: f64,
    pub(super) most: f64,
}

/// A bound on the distance of the image of `made` from `curve` at the same parameter all over `span`; `None` of other surfaces, of curves in uv that are
/// rational, of rational edges of a high degree, of poly-curves, and where pieces would have to be too small or too many. `pieces`: how many there may still be of the file; some 30 points
/// are evaluated on each.
pub(super) fn bound(
    chart: &Chart,
    curve: &Curve3,
    made: &Curve2,
    span: Interval,
    size: f64,
    pieces: &mut usize,
) -> Option<f64> {
    if *pieces == 0 || !chart.is_elementary() {
        return None;
    }
    let degree_uv = polynomial(made).filter(|n| *n <= DEGREE_UV)?;
    let rest = Rest::of(curve)?;
    let own_degree = match rest {
        Rest::Nothing(n) => n.max(degree_uv),
        _ => degree_uv,
    };
    let most_degree = own_degree.max(KEPT);
    let angles = 1.0
        + largest(made, 0)
        + if chart.is_ruled() {
            0.0
        } else {
            largest(made, 1)
        };
    let far = chart.far(largest(made, 1)).max(size);
    let far = (0..3).fold(far, |a: f64, c| a.max(largest(curve, c)));
    let of_edge = match curve {
        Curve::Nurbs(n) if n.degree() <= DEGREE => 2.0 * horner(n.degree()),
        _ => 0.0,
    };
    let of_points = (2.0 * FORMULA + of_edge) * rest.rounding();
    let rounding = (of_points + horner(degree_uv) + STRAY) * far * angles;
    // What is less than roundings, or than what fitted curves are off, needs no higher degree, which takes more points.
    let of_fit = if degree_uv > 1 {
        ROUNDED_OUT * FIT * size
    } else {
        0.0
    };
    let enough = of_fit.max(ROUNDED_OUT * rounding);
    let of_coefficients = [0, 1].map(|c| COEFFICIENT * largest(made, c));
    let mut ends: Vec<f64> = curve.breaks();
    ends.extend(made.breaks());
    ends.retain(|t| span.start < *t && *t < span.end);
    ends.extend([span.start, span.end]);
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    let mut nodes: [Vec<f64>; MOST_DEGREE + 1] = Default::default();
    let points = Points::of(curve);
    let mut worst = 0.0_f64;
    let mut done = 0;
    let mut open: Vec<([f64; 2], u32)> = Vec::new();
    for (k, w) in ends.windows(2).enumerate() {
        let waiting = ends.len() - 2 - k;
        open.push(([w[0], w[1]], 0));
        while let Some(([a, b], depth)) = open.pop() {
            *pieces = pieces.checked_sub(1)?;
            let (m, h) = (0.5 * (a + b), 0.5 * (b - a));
            let is_clear = PLACE * h > f64::EPSILON * a.abs().max(b.abs());
            if done + waiting + open.len() >= MOST_PIECES || !is_clear {
                return None;
            }
            let uv = Local::new(made.derivatives(m, degree_uv), h);
            let edge = rest.local(curve, [m, h]);
            let discs = Discs::new(chart, &uv, of_coefficients, &rest, &edge, h)?;
            if !(discs.left_out(most_degree) <= LEFT_OUT * size) {
                if depth == HALVINGS {
                    return None;
                }
                open.extend([([m, b], depth + 1), ([a, m], depth + 1)]);
                continue;
            }
            done += 1;
            let mut degrees = own_degree..most_degree;
            let n = degrees.find(|n| discs.left_out(*n) <= enough);
            let n = n.unwrap_or(most_degree);
            let left_out = discs.left_out(n);
            let inner = nodes.get_mut(n)?;
            if inner.is_empty() {
                let angle = |j: usize| PI * j as f64 / (4 * n) as f64;
                inner.extend((1..4 * n).map(|j| libm::cos(angle(j))));
            }
            let mut own: f64 = 0.0;
            for t in inner.iter().map(|x| m + h * x).chain([a, b]) {
                // Where it is hit.
                let x = (t - m) / h;
                let p = match &edge {
                    Edge::Polynomial(own) => own.at(x),
                    Edge::Rational(own) => {
                        let q = own.at(x);
                        q.xyz() / q.w
                    }
                    Edge::Other => points.proven(t).coords,
                };
                let off = (chart.point(&Point2::from(uv.at(x))).coords - p).norm();
                // No number is no bound.
                if !(off < f64::INFINITY) {
                    return None;
                }
                own = own.max(off);
            }
            worst = worst.max((own + rounding + left_out) * FACTOR + left_out);
        }
    }
    (worst < f64::INFINITY).then_some(worst)
}

/// How far [`Local::at`] is off in a coordinate, relative to the largest control point: see the [module](self).
fn horner(degree: usize) -> f64 {
    ((8 * degree) << degree) as f64 * f64::EPSILON
}

/// The Taylor coefficients of a curve about the middle of a piece, of its parameter there from -1 to 1.
struct Local<const N: usize>(Vec<SVector<f64, N>>);

impl<const N: usize> Local<N> {
    fn new(mut derivatives: Vec<SVector<f64, N>>, h: f64) -> Self {
        let mut scale = 1.0;
        for (k, d) in (1..).zip(derivatives.iter_mut().skip(1)) {
            scale *= h / f64::from(k);
            *d *= scale;
        }
        Self(derivatives)
    }

    fn at(&self, x: f64) -> SVector<f64, N> {
        { self.0.iter().rev() }.fold(SVector::zeros(), |sum, c| sum * x + c)
    }
}

/// An edge on one piece.
enum Edge {
    Polynomial(Local<3>),
    /// Its homogeneous points.
    Rational(Local<4>),
    /// An arc, or of a high degree.
    Other,
}

/// How far a fitted curve in uv may be outside of a domain in coordinate `c` where [`bound`] is to hold.
fn slack(chart: &Chart, c: usize, domain: Interval, size: f64) -> f64 {
    let end = domain.start.abs().max(domain.end.abs());
    if !chart.is_elementary() {
        return ROUNDING * end;
    }
    let is_length = c == 1 && chart.is_ruled();
    ROUNDING
        * end.min(if is_length {
            MOST_OUTSIDE * size
        } else {
            MOST_OUTSIDE
        })
}

/// How far the domain of a surface moves the image of a curve in uv at most beyond what its bound counts: the image is that of the curve clamped to the
/// domain. `None`: that is not known.
///
/// - Straight: it is farthest out at an end, by `x` in u and `y` in v, measured there. From a point to the clamped one go by u, then by v: these ways
///   are within what the ends hold of u and v, so no longer than `x` and `y` times the speeds there. (Of two rims that start beside each other, one turn
///   holds one.)
/// - Splines: how far they reach was searched for, not proven; here it is, up to [`slack`]. For that the bounds on elementary surfaces have room; on planes,
///   which are opened a little wider than what was found, most are proven to be within the domain by as much, and of the others it counts.
/// - An arc lies on a plane, whose domain holds it by formula, up to a rounding, for which the bound has room, too.
pub(super) fn cut_off(
    chart: &Chart,
    curve: &Curve2,
    domain: [Interval; 2],
    size: f64,
) -> Option<f64> {
    match curve {
        Curve::Line(l) => {
            let out = [0, 1].map(|c| {
                let beyond = |x: f64| (domain[c].start - x).max(x - domain[c].end);
                beyond(l.from[c]).max(beyond(l.to[c])).max(0.0)
            });
            if out == [0.0; 2] {
                return Some(0.0);
            }
            let speeds = chart.speeds(l.from.y.abs().max(l.to.y.abs()))?;
            let moved = [0, 1].map(|c| {
                if out[c] > 0.0 {
                    out[c] * speeds[c]
                } else {
                    0.0
                }
            });
            // A thousandth for roundings.
            let moved = 1.001 * (moved[0] + moved[1]);
            moved.is_finite().then_some(moved)
        }
        Curve::Nurbs(_) => {
            let slack = [0, 1].map(|c| slack(chart, c, domain[c], size));
            let is_within = |by: f64| {
                (0..2).all(|c| {
                    let inner = Interval::new(
                        domain[c].start + by * slack[c],
                        domain[c].end - by * slack[c],
                    );
                    inner.is_some_and(|d| stays(curve, c, d, slack[c]))
                })
            };
            if chart.is_elementary() {
                return is_within(0.0).then_some(0.0);
            }
            if is_within(1.0) {
                return Some(0.0);
            }
            let speeds = chart.speeds(0.0)?;
            let cut = 1.001 * (slack[0] * speeds[0] + slack[1] * speeds[1]);
            is_within(0.0).then_some(cut)
        }
        Curve::Arc(_) => Some(0.0),
        Curve::Polyline(_) | Curve::Poly(_) => None,
    }
}

/// What an edge's curve is on its pieces beside polynomials.
enum Rest {
    /// A polynomial of this degree.
    Nothing(usize),
    /// An arc.
    Arc {
        radius: f64,
        /// Radians for a unit of the parameter.
        rate: f64,
    },
    /// A rational curve.
    Rational(Box<Homogeneous>),
}

/// A rational curve's homogeneous points.
struct Homogeneous {
    curve: Curve<4, 5>,
    /// What roundings of its coordinates' coefficients are.
    rounding: [f64; 4],
    /// The largest weight against the least.
    weights: f64,
}

impl Rest {
    /// `None`: a curve of which nothing is said here.
    fn of(curve: &Curve3) -> Option<Self> {
        match curve {
            Curve::Arc(a) => Some(Self::Arc {
                radius: a.radius,
                rate: a.angle.length() / a.domain.length(),
            }),
            Curve::Nurbs(n) if polynomial(curve).is_none() => {
                if n.degree() > DEGREE_RATIONAL {
                    return None;
                }
                let weights = n.control_points().iter().map(|p| p.w);
                let [least, most] = weights.fold([f64::INFINITY, 0.0], |[a, b]: [f64; 2], w| {
                    [a.min(w), b.max(w)]
                });
                let points = n.control_points().iter().map(|p| p.push(1.0)).collect();
                let knots = n.knots().knots().to_vec();
                let homogeneous = NurbsCurve::new(n.degree(), points, knots).ok()?;
                let curve = Curve::Nurbs(homogeneous);
                Some(Self::Rational(Box::new(Homogeneous {
                    rounding: [0, 1, 2, 3].map(|c| COEFFICIENT * largest(&curve, c)),
                    curve,
                    weights: most / least,
                })))
            }
            _ => {
                let degree = polynomial(curve)?;
                (degree <= MOST_DEGREE).then_some(Self::Nothing(degree))
            }
        }
    }

    /// By how much more than a polynomial's its points are off by roundings.
    fn rounding(&self) -> f64 {
        match self {
            Self::Rational(own) => 2.0 * own.weights,
            _ => 1.0,
        }
    }

    /// The edge on the piece with the middle `m` that is `2 h` long.
    fn local(&self, curve: &Curve3, [m, h]: [f64; 2]) -> Edge {
        match self {
            Self::Rational(own) => {
                Edge::Rational(Local::new(own.curve.derivatives(m, DEGREE_RATIONAL), h))
            }
            Self::Nothing(n) if *n <= DEGREE => {
                Edge::Polynomial(Local::new(curve.derivatives(m, *n), h))
            }
            Self::Nothing(_) | Self::Arc { .. } => Edge::Other,
        }
    }

    /// How long it is at most over the disc of radius `r`, of the edge on the piece.
    fn most_in(&self, edge: &Edge, h: f64, r: f64) -> f64 {
        match self {
            Self::Nothing(_) => 0.0,
            Self::Arc { radius, rate } => radius * libm::exp((rate * h).abs() * r),
            Self::Rational(own) => {
                let Edge::Rational(Local(all)) = edge else {
                    return f64::INFINITY;
                };
                let [first, rest @ ..] = &all[..] else {
                    return f64::INFINITY;
                };
                let k = first.xyz() / first.w;
                let rounding = own.rounding;
                let of_point = rounding[0] + rounding[1] + rounding[2] + k.lp_norm(1) * rounding[3];
                let (mut above, mut below) = (of_point, first.w - rounding[3]);
                let mut grown = 1.0;
                for c in rest {
                    grown *= r;
                    above += ((c.xyz() - k * c.w).norm() + of_point) * grown;
                    below -= (c.w.abs() + rounding[3]) * grown;
                }
                if below > 0.0 {
                    above / below
                } else {
                    f64::INFINITY
                }
            }
        }
    }
}

/// The degree of a curve that is a polynomial on each of its pieces.
fn polynomial<const D: usize, const H: usize>(curve: &Curve<D, H>) -> Option<usize> {
    match curve {
        Curve::Line(_) => Some(1),
        Curve::Nurbs(n) => {
            let mut weights = n.control_points().iter().map(|p| p[H - 1]);
            let first = weights.next()?;
            weights.all(|w| w == first).then(|| n.degree())
        }
        Curve::Arc(_) | Curve::Polyline(_) | Curve::Poly(_) => None,
    }
}

/// No point of the curve has a larger coordinate `c`.
pub(super) fn largest<const D: usize, const H: usize>(curve: &Curve<D, H>, c: usize) -> f64 {
    match curve {
        Curve::Nurbs(n) => {
            let points = n.control_points().iter();
            points.fold(0.0, |a: f64, p| a.max((p[c] / p[H - 1]).abs()))
        }
        Curve::Line(l) => l.from[c].abs().max(l.to[c].abs()),
        Curve::Arc(a) => a.center[c].abs() + a.radius,
        Curve::Polyline(_) | Curve::Poly(_) => f64::INFINITY,
    }
}

/// What the discs of radius 2, 4, ... around the middle of a piece say.
struct Discs([f64; RADII as usize]);

impl Discs {
    /// `rounding`: of the Taylor coefficients of the curve in uv.
    fn new(
        chart: &Chart,
        uv: &Local<2>,
        rounding: [f64; 2],
        rest: &Rest,
        edge: &Edge,
        h: f64,
    ) -> Option<Self> {
        let (first, others) = uv.0.split_first()?;
        let mut all = [0.0; RADII as usize];
        for (e, own) in (1..).zip(&mut all) {
            let r = f64::from(1 << e);
            let disc = |c: usize| {
                let each = others.iter().map(|d| d[c].abs() + rounding[c]);
                let off = each.rev().fold(0.0, |sum, x| (sum + x) * r);
                let most = first[c].abs() + rounding[c] + off;
                Disc { off, most }
            };
            *own = chart.most_in(disc(0), disc(1))? + rest.most_in(edge, h, r);
        }
        Some(Self(all))
    }

    /// The least `e` where the series are kept up to degree `n`.
    fn left_out(&self, n: usize) -> f64 {
        let mut least = f64::INFINITY;
        for (e, most) in (1..).zip(&self.0) {
            let r = f64::from(1 << e);
            let left = most * r.powi(-(n as i32 + 1)) / (1.0 - 1.0 / r) * 1.001;
            // What is no number is no bound.
            if left < least {
                least = left;
            }
        }
        least
    }
}

#[cfg(test)]
mod tests {
    use super::super::geometry::Left;
    use super::*;
    use crate::occt::curves::Budget;
    use crate::occt::surfaces::{Axes, Form3};
    use feeler::nurbs::{Arc, Line};
    use nalgebra::{Point3, Vector3, Vector4};

    fn axes() -> Axes {
        Axes {
            origin: Point3::new(1.0, -2.0, 0.5),
            x: Vector3::new(0.6, 0.8, 0.0),
            y: Vector3::new(-0.8, 0.6, 0.0),
            z: Vector3::z(),
        }
    }

    fn chart(form: Form3) -> Chart {
        let left = Left {
            pieces: 0,
            held: Budget::new(1000),
            samples: 100,
        };
        Chart::new(1, &form, 10.0, &left, &mut Budget::new(1000)).unwrap()
    }

    fn charts() -> [(&'static str, Chart); 4] {
        let made = chart;
        [
            ("cylinder", made(Form3::Cylinder(axes(), 2.0))),
            ("cone", made(Form3::Cone(axes(), 2.0, 0.4))),
            ("sphere", made(Form3::Sphere(axes(), 2.0))),
            ("torus", made(Form3::Torus(axes(), [3.0, 1.0]))),
        ]
    }

    fn interval(a: f64, b: f64) -> Interval {
        Interval::new(a, b).unwrap()
    }

    /// What a thousand samples see.
    fn seen(chart: &Chart, curve: &Curve3, made: &Curve2, span: Interval) -> f64 {
        (0..=1000)
            .map(|k| span.lerp(f64::from(k) / 1000.0))
            .map(|t| (chart.point(&made.point(t)) - curve.point(t)).norm())
            .fold(0.0, f64::max)
    }

    /// A cubic with a joint in uv, and edges of many shapes near it or far from it: the bound is above what samples see, and not by much.
    #[test]
    fn bounds_are_above_samples_and_close() {
        let span = interval(-1.0, 2.0);
        let knots = vec![-1.0, -1.0, -1.0, -1.0, 0.5, 2.0, 2.0, 2.0, 2.0];
        let uv = [[0.1, 0.2], [0.5, 0.3], [1.1, -0.2], [1.3, 0.4], [2.0, 0.7]];
        let uv = uv.map(|[u, v]| Vector3::new(u, v, 1.0)).to_vec();
        let cubic: Curve2 = Curve::Nurbs(NurbsCurve::new(3, uv, knots.clone()).unwrap());
        let line = Line::new(Point2::new(0.3, -0.2), Point2::new(1.9, 0.6), span).unwrap();
        for (name, chart) in charts() {
            for made in [cubic.clone(), Curve::Line(line.clone())] {
                let near = |t: f64| chart.point(&made.point(t)).coords;
                // A spline through points of the image at parameters that are not its own: off by some hundredths.
                let through = |wave: f64| {
                    let points = (0..5).map(|k| {
                        let t = span.lerp(f64::from(k) / 4.0);
                        let p = near(t) + Vector3::new(wave, -wave, wave) * f64::from(k % 2);
                        Vector4::new(p.x, p.y, p.z, 1.0)
                    });
                    let spline = NurbsCurve::new(3, points.collect(), knots.clone());
                    Curve::Nurbs(spline.unwrap())
                };
                let arc = Arc {
                    center: Point3::new(1.0, -2.0, 1.0),
                    x: Vector3::x(),
                    y: Vector3::y(),
                    z: Vector3::z(),
                    radius: 2.5,
                    angle: interval(0.5, 4.0),
                    domain: span,
                };
                let ends = [span.start, span.end].map(|t| Point3::from(near(t)));
                let chord = Line::new(ends[0], ends[1], span).unwrap();
                // Weights of an ellipse by thirds of a turn, and of a cubic.
                let rational = |degree: usize, weights: &[f64], knots: Vec<f64>| {
                    let n = weights.len() - 1;
                    let points = weights.iter().enumerate().map(|(k, w)| {
                        let p = near(span.lerp(k as f64 / n as f64)) * *w;
                        Vector4::new(p.x, p.y, p.z, *w)
                    });
                    let curve = NurbsCurve::new(degree, points.collect(), knots);
                    Curve::Nurbs(curve.unwrap())
                };
                let thirds = vec![-1.0, -1.0, -1.0, 0.5, 0.5, 2.0, 2.0, 2.0];
                let edges: [Curve3; 6] = [
                    through(0.0),
                    through(0.25),
                    Curve::Arc(Arc::new(arc).unwrap()),
                    Curve::Line(chord),
                    rational(2, &[1.0, 0.5, 1.0, 0.5, 1.0], thirds),
                    rational(3, &[1.0, 0.25, 3.0, 0.5, 2.0], knots.clone()),
                ];
                for (i, edge) in edges.iter().enumerate() {
                    let proven =
                        bound(&chart, edge, &made, span, 10.0, &mut 10_000).expect("a bound");
                    let seen = seen(&chart, edge, &made, span);
                    assert!(seen > 1e-3, "{name} {i}: {seen}");
                    assert!(proven >= seen, "{name} {i}: {proven} < {seen}");
                    assert!(proven <= 1.09 * seen, "{name} {i}: {proven} > {seen}");
                }
            }
        }
    }

    /// A meridian of a torus is a circle: the image is the edge, and only rounding is left.
    #[test]
    fn what_is_exact_is_known_to_rounding() {
        let charts = charts();
        let torus = &charts[3].1;
        let span = interval(0.0, 3.0);
        let made = Line::new(Point2::new(0.0, 0.0), Point2::new(0.0, 3.0), span).unwrap();
        let a = axes();
        let arc = Arc {
            center: a.origin + a.x * 3.0,
            x: a.x,
            y: a.z,
            z: a.x.cross(&a.z),
            radius: 1.0,
            angle: span,
            domain: span,
        };
        let arc: Curve3 = Curve::Arc(Arc::new(arc).unwrap());
        let proven =
            bound(torus, &arc, &Curve::Line(made), span, 10.0, &mut 10_000).expect("a bound");
        assert!(proven <= 3.0 * LEFT_OUT * 10.0, "{proven:e}");
    }

    /// A peak between the samples: what is off at one place alone, by a knot span that samples pass over, is seen.
    #[test]
    fn narrow_peaks_are_seen() {
        let span = interval(0.0, 1.0);
        let (a, b) = (0.400_1, 0.400_3);
        let knots = vec![0.0, 0.0, 0.0, a, 0.5 * (a + b), b, 1.0, 1.0, 1.0];
        let [(_, cylinder), ..] = charts();
        let at = |u: f64, v: f64| Vector3::new(u, v, 1.0);
        let mut uv: Vec<_> = (0..6).map(|k| at(0.5, f64::from(k) / 5.0)).collect();
        uv[2].x += 0.1;
        let made: Curve2 = Curve::Nurbs(NurbsCurve::new(2, uv, knots).unwrap());
        let ends = [0.0, 1.0].map(|t| cylinder.point(&made.point(t)));
        let edge: Curve3 = Curve::Line(Line::new(ends[0], ends[1], span).unwrap());
        let proven = bound(&cylinder, &edge, &made, span, 10.0, &mut 10_000).expect("a bound");
        let peak = (0..=1000)
            .map(|k| interval(a, b).lerp(f64::from(k) / 1000.0))
            .map(|t| (cylinder.point(&made.point(t)) - edge.point(t)).norm())
            .fold(0.0, f64::max);
        assert!(proven >= peak && peak > 0.05, "{proven} {peak}");
    }

    /// However long a domain is, what is cut off at its ends moves no point by more than there is room for.
    #[test]
    fn what_is_cut_off_has_room() {
        let size = 10.0;
        for (name, chart) in charts() {
            for end in [1.0, 7.0, 90.0, 1e6] {
                let off = [0, 1].map(|c| slack(&chart, c, interval(0.0, end), size));
                let far = chart.far(0.0).max(size);
                // Of a cone the radius grows with v, which the numbers of the bound do, too.
                let [near, moved] = [[0.0; 2], off].map(Point2::from);
                let by = (chart.point(&moved) - chart.point(&near)).norm();
                let rounded = 4.0 * f64::EPSILON * far;
                assert!(by <= STRAY * far + rounded, "{name}, {end}: {by:e}");
                // And it is something, where the domain is as long as usual.
                assert!(off[0] > 0.0 && off[1] > 0.0);
            }
        }
    }

    /// Of rational curves in uv, of those of a high degree and of other surfaces nothing is said.
    #[test]
    fn others_have_no_bound_here() {
        let span = interval(0.0, 1.0);
        let [(_, cylinder), ..] = charts();
        let plane = chart(Form3::Plane(axes()));
        let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let conic = |w: f64| {
            let uv = [[0.0, 0.0, 1.0], [0.5 * w, 0.0, w], [1.0, 1.0, 1.0]].map(Vector3::from);
            Curve::Nurbs(NurbsCurve::new(2, uv.to_vec(), knots.clone()).unwrap())
        };
        let edge: Curve3 =
            Curve::Line(Line::new(Point3::origin(), Point3::new(1.0, 0.0, 0.0), span).unwrap());
        assert!(bound(&cylinder, &edge, &conic(1.0), span, 10.0, &mut 10_000).is_some());
        assert!(bound(&cylinder, &edge, &conic(2.0), span, 10.0, &mut 10_000).is_none());
        assert!(bound(&plane, &edge, &conic(1.0), span, 10.0, &mut 10_000).is_none());
        assert!(bound(&cylinder, &edge, &conic(1.0), span, 10.0, &mut 0).is_none());
    }
}
