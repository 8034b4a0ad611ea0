//! Circular arcs as polynomial pieces with a proven error.
//!
//! Native arcs and revolutions are parametrised by the angle, and so are the trims on them; a
//! rational circle has another parametrisation. So cosine and sine are replaced by their Taylor
//! polynomials on short spans, and what is left out goes into the radius of the coefficients.

use super::spline::{ArcPiece, BezierCurve, Homogeneous};
use crate::numeric::sin_cos;
use crate::numeric::{Ball, Dd, Interval, Real, TINY};
use crate::nurbs::Arc;
use nalgebra::Point;

/// Degree of the Taylor polynomials: what they leave out (see [`Spans`]) is a fourth of a unit in f64 and below one in
/// double-double.
pub(crate) const fn degree<T: Real>() -> usize {
    if T::UNIT < f64::UNIT { 19 } else { 11 }
}
/// Longest span, in radians: a little more than a sixteenth of a turn, so that whole turns
/// need 16 and no seventeenth for rounding.
const LONGEST_SPAN: f64 = std::f64::consts::FRAC_PI_8 * (1.0 + 1.0 / 1024.0);

/// Bernstein coefficients of cosine and sine over a span, and the native parameters it covers.
#[derive(Debug)]
pub(crate) struct Span<T> {
    pub(crate) cos: Vec<Ball<T>>,
    pub(crate) sin: Vec<Ball<T>>,
    pub(crate) range: Interval,
    /// The angle at the start, and how much further it is at the end.
    pub(crate) angle: [Ball<Dd>; 2],
}

/// Cuts `[from, to]` of a domain, over which the angle runs linearly, into spans.
///
/// On a span with middle `m` and half-width `h`, `cos(m + h x) = sum_i c_i h^i x^i / i! + e(x)`, the `c_i` being
/// `cos m, -sin m, -cos m, sin m, ...` and `|e| <= h^(n+1) / (n+1)!` with `n` = [`degree`] (Lagrange). The Bernstein
/// coefficient `j` of `x^i` is the polar form of `x^i` at `n - j` times -1 and `j` times +1: the coefficient of
/// `z^i` in `(1-z)^(n-j) (1+z)^j`, over `C(n, i)` (Ramshaw).
///
/// The function is then `sum (b_j +- r) B_j` as far as its values go. The search also uses first and second
/// differences of coefficients as bounds of derivatives, allowing `2 n r` and `4 n (n-1) r` for their error
/// (with the composed degree for `n`). `e' <= h^n/n!` and `e'' <= h^(n-1)/(n-1)!` in `x`, so in the local parameter
/// (`dx = 2 ds`) `2 (n+1) |e|` and `4 n (n+1) |e|`: less than what is allowed if `r >= 4 |e|`. Products and compositions
/// keep the relation, since they multiply both sides by the same factors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spans {
    angle: Interval,
    domain: Interval,
    from: f64,
    to: f64,
    count: usize,
}

impl Spans {
    pub(crate) fn new(angle: Interval, domain: Interval, from: f64, to: f64) -> Self {
        Self {
            angle,
            domain,
            from,
            to,
            count: span_count(angle, domain, from, to),
        }
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// The native parameters that one covers.
    pub(crate) fn range(&self, k: usize) -> Interval {
        let (from, to) = (self.from, self.to);
        let cut = |k: usize| {
            if k == 0 {
                from
            } else if k == self.count {
                to
            } else {
                let s = k as f64 / self.count as f64;
                ((1.0 - s) * from + s * to).clamp(from, to)
            }
        };
        Interval {
            start: cut(k),
            end: cut(k + 1),
        }
    }

    /// The angle where one of them begins, or the last ends.
    pub(super) fn border(&self, k: usize) -> Ball<Dd> {
        let t = if k < self.count {
            self.range(k).start
        } else {
            self.to
        };
        angle_at(self.angle, self.domain)(t)
    }

    /// One of them.
    pub(crate) fn span<T: Real>(&self, k: usize) -> Span<T> {
        let at = angle_at(self.angle, self.domain);
        let range = self.range(k);
        let (a, b) = (at(range.start), at(range.end));
        let middle = (a + b).half();
        let half = (b - a).half();
        let (sin, cos) = sin_cos(middle);
        Span {
            cos: taylor(cos, -sin, half),
            sin: taylor(sin, cos, half),
            range,
            angle: [a, b - a],
        }
    }
}

/// The angle at a parameter.
fn angle_at(angle: Interval, domain: Interval) -> impl Fn(f64) -> Ball<Dd> {
    let width = Ball::<Dd>::difference(domain.end, domain.start);
    let turn = Ball::<Dd>::difference(angle.end, angle.start);
    move |t: f64| {
        if t == domain.end {
            return Ball::exact(angle.end);
        }
        let s = Ball::difference(t, domain.start) / width;
        Ball::exact(angle.start) + s * turn
    }
}

/// How many [`Spans`] there are.
pub(crate) fn span_count(angle: Interval, domain: Interval, from: f64, to: f64) -> usize {
    let at = angle_at(angle, domain);
    let total = (at(to) - at(from)).mid.hi;
    // The angle of a BREP is finite; a coil of so many turns is cut coarsely and gets wide radii.
    const MOST: f64 = 4096.0;
    (total / LONGEST_SPAN).ceil().clamp(1.0, MOST) as usize
}

/// Bernstein coefficients of the function with value `f` and derivative `g` in the middle and `f'' = -f`.
fn taylor<T: Real>(f: Ball<Dd>, g: Ball<Dd>, half: Ball<Dd>) -> Vec<Ball<T>> {
    let n = degree::<T>();
    let mut terms = Vec::with_capacity(n + 1);
    let mut power = Ball::<Dd>::ONE;
    for i in 0..=n {
        let c = match i % 4 {
            0 => f,
            1 => g,
            2 => -f,
            _ => -g,
        };
        terms.push(c * power);
        power = power * half / Ball::exact((i + 1) as f64);
    }
    // `power` is now h^(n+1) / (n+1)!; the fourfold of it, see `Spans`.
    let left_out = 4.0 * power.magnitude();
    bernstein(&terms, left_out)
}

/// Bernstein coefficients over `[0, 1]` of a polynomial in powers of `x = 2 t - 1`, with a radius for what it leaves out. See
/// [`Spans`] for the formula: no coefficient of a power of `x` is above 1.
pub(super) fn bernstein<T: Real>(powers: &[Ball<Dd>], left_out: f64) -> Vec<Ball<T>> {
    let n = powers.len() - 1;
    // The row of `j = 0` holds the binomials, with signs.
    let mut polar = row(n);
    let binomial: Vec<f64> = polar.iter().map(|b| b.abs()).collect();
    (0..=n)
        .map(|j| {
            if j > 0 {
                next_row(&mut polar);
            }
            let mut sum = Ball::<Dd>::ZERO;
            for i in 0..=n {
                sum = sum + powers[i] * Ball::exact(polar[i]) / Ball::exact(binomial[i]);
            }
            Ball::from_dd(sum.mid, sum.rad + left_out)
        })
        .collect()
}

/// The coefficients of `(1 - z)^n`: whole numbers of at most 2^n, exact up to 53.
pub(super) fn row(n: usize) -> Vec<f64> {
    let mut c = vec![0.0; n + 1];
    c[0] = 1.0;
    for k in 0..n {
        for i in (0..=k).rev() {
            c[i + 1] -= c[i];
        }
    }
    c
}

/// From the coefficients of `(1 - z)^minus (1 + z)^plus`, with `minus` above zero, to those with one factor `1 + z` for one `1 - z`. The quotient by `1 - z`
/// has the sums of the first coefficients: those of `(1 - z)^(minus - 1) (1 + z)^plus`, whole numbers of at most
/// 2^(minus + plus), exact as in [`row`].
pub(super) fn next_row(c: &mut [f64]) {
    let mut quotient = 0.0;
    for x in c {
        let before = quotient;
        quotient += *x;
        *x = quotient + before;
    }
}

/// A vector with bounds.
pub(crate) type Vector<const D: usize> = [Ball<Dd>; D];

pub(crate) fn dot<const D: usize>(a: &Vector<D>, b: &Vector<D>) -> Ball<Dd> {
    let mut sum = Ball::ZERO;
    for c in 0..D {
        sum = sum + a[c] * b[c];
    }
    sum
}

/// Components smaller than this part of another change the length by a factor of 1 + 1e-400 at most.
const NOTHING: f64 = 1e-200;

/// `a / |a|`; along a coordinate axis all but exactly.
pub(crate) fn normalized<const D: usize>(a: &Vector<D>) -> Vector<D> {
    for c in 0..D {
        let size = (a[c].mid.hi.abs() * (1.0 - f64::EPSILON) - a[c].rad) * (1.0 - f64::EPSILON);
        let small = |i: usize| a[i].magnitude() <= NOTHING * size;
        if size > 0.0 && (0..D).all(|i| i == c || small(i)) {
            let exact = (0..D).all(|i| i == c || a[i].magnitude() == 0.0);
            return std::array::from_fn(|i| Ball {
                mid: if i == c {
                    Dd::from(a[c].mid.hi.signum())
                } else {
                    Dd::ZERO
                },
                rad: match (i == c, exact) {
                    (_, true) => 0.0,
                    (true, false) => TINY,
                    (false, false) => a[i].magnitude() / size * (1.0 + 8.0 * f64::EPSILON) + TINY,
                },
            });
        }
    }
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

pub(crate) fn cross(a: &Vector<3>, b: &Vector<3>) -> Vector<3> {
    std::array::from_fn(|c| {
        let (i, j) = ((c + 1) % 3, (c + 2) % 3);
        a[i] * b[j] - a[j] * b[i]
    })
}

/// The exact axes `x'`, `y'` of an arc (see [`Arc`]).
pub(crate) fn axes<const D: usize>(arc: &Arc<D>) -> [Vector<D>; 2] {
    let exact = |v: &[f64]| -> Vector<D> { std::array::from_fn(|c| Ball::exact(v[c])) };
    let x = exact(arc.x.as_slice());
    if D == 3 {
        let three = |v: &Vector<D>| -> Vector<3> { std::array::from_fn(|c| v[c]) };
        let z = normalized(&three(&exact(arc.z.as_slice())));
        let x = three(&x);
        let along = dot(&x, &z);
        let x = normalized(&std::array::from_fn(|c| x[c] - along * z[c]));
        let y = cross(&z, &x);
        let back = |v: Vector<3>| -> Vector<D> { std::array::from_fn(|c| v[c]) };
        return [back(x), back(y)];
    }
    let x = normalized(&x);
    // +90 degrees, or -90 where the stored y lies on that side (the sign of an exact cross product).
    let turn = Dd::product(arc.x[0], arc.y[1]) - Dd::product(arc.x[1], arc.y[0]);
    let sign = if turn < Dd::ZERO {
        -Ball::ONE
    } else {
        Ball::ONE
    };
    let y = std::array::from_fn(|c| match c {
        0 => -(sign * x[1]),
        _ => sign * x[0],
    });
    [x, y]
}

/// The pieces of an arc over `[from, to]` of its domain, each by itself.
pub(crate) struct ArcPieces<T, const D: usize> {
    center: Point<f64, D>,
    /// The axes, as long as the radius.
    axes: [[Ball<T>; D]; 2],
    spans: Spans,
}

impl<T: Real, const D: usize> ArcPieces<T, D> {
    pub(crate) fn new(arc: &Arc<D>, from: f64, to: f64) -> Self {
        let convert = |b: Ball<Dd>| Ball::<T>::from_dd(b.mid, b.rad);
        let radius = Ball::exact(arc.radius);
        Self {
            center: arc.center,
            axes: axes(arc).map(|axis| axis.map(|b| convert(radius * b))),
            spans: Spans::new(arc.angle, arc.domain, from, to),
        }
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.spans.len()
    }

    /// One of them.
    pub(crate) fn piece<const H: usize>(&self, k: usize) -> BezierCurve<T, H> {
        let [x, y] = &self.axes;
        let center = |c: usize| Ball::exact(self.center[c]);
        let coordinates = |of: &dyn Fn(usize) -> Ball<T>, last: Ball<T>| -> Homogeneous<T, H> {
            std::array::from_fn(|c| if c < D { of(c) } else { last })
        };
        let span = self.spans.span::<T>(k);
        let points = (0..=degree::<T>()).map(|j| {
            let of = |c: usize| center(c) + span.cos[j] * x[c] + span.sin[j] * y[c];
            coordinates(&of, Ball::ONE)
        });
        BezierCurve {
            points: points.collect(),
            map: super::ParamMap::new(span.range.start, span.range.end),
            arc: Some(Box::new(ArcPiece {
                center: coordinates(&center, Ball::ONE),
                x: coordinates(&|c| x[c], Ball::ZERO),
                y: coordinates(&|c| y[c], Ball::ZERO),
                angle: span.angle,
            })),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{next_row, row};

    /// Against products of the factors, one by one.
    #[test]
    fn rows_are_products_of_their_factors() {
        for n in 0..=53 {
            let mut polar = row(n);
            for plus in 0..=n {
                if plus > 0 {
                    next_row(&mut polar);
                }
                let mut product = vec![1_i64];
                for k in 0..n {
                    let sign = if k < plus { 1 } else { -1 };
                    product.push(0);
                    for i in (1..product.len()).rev() {
                        product[i] += sign * product[i - 1];
                    }
                }
                let product: Vec<f64> = product.iter().map(|c| *c as f64).collect();
                assert_eq!(polar, product, "{n}, {plus}");
            }
        }
    }
}
