//! One rational Bezier piece of a loop: f64 first, double-double and integers on demand.

use super::source::{Ball3, Source};
use crate::numeric::polynomial::{Polynomial, binomials, signum};
use crate::numeric::roots;
use crate::numeric::{Ball, Dd, Dyadic, Real};
use dashu_int::IBig;
use std::cmp::Ordering;
use std::sync::OnceLock;

/// A piece of a loop: its source, and what is made from it. A face may have a hundred thousand: of those that no query comes near, nothing is kept
/// that can be made again.
#[derive(Debug)]
pub(super) struct Piece {
    pub(super) source: Source,
    /// Box of the piece, rounded outward: `[axis][lo, hi]`.
    pub(super) hull: [[f64; 2]; 2],
    made: OnceLock<Box<Made>>,
}

/// Bezier control points, homogeneous, in f64.
#[derive(Debug)]
pub(super) struct Control {
    pub(super) points: Box<[[f64; 3]]>,
    /// Proven error of each homogeneous coordinate of every control point.
    pub(super) radius: [f64; 3],
}

/// What is made when it is first asked for.
#[derive(Debug, Default)]
struct Made {
    control: OnceLock<Control>,
    coarse: OnceLock<Horner<f64>>,
    fine: OnceLock<Horner<Dd>>,
    exact: OnceLock<Option<Exact>>,
}

/// Coefficients `C(p, i) b_i`, and a bound on the error of each coordinate that
/// [`eval`](Self::eval) returns.
#[derive(Debug)]
pub(super) struct Horner<T> {
    coefficients: Box<[[T; 3]]>,
    /// Bound on the error of each coordinate, infinite where the arithmetic's range is left.
    pub(super) error: [f64; 2],
    /// What a relative error of 2 units in the parameter can move each coordinate by.
    pub(super) shift: [f64; 2],
}

/// The piece in integers: `C(p, i) b_i` of each homogeneous coordinate.
#[derive(Debug)]
pub(super) struct Exact {
    pub(super) u: Polynomial,
    pub(super) v: Polynomial,
    pub(super) w: Polynomial,
    /// Whether u, v are identically constant.
    pub(super) constant: [bool; 2],
}

/// Coordinates beyond this, or weights beyond this or its inverse, are left to integers.
const LARGEST: f64 = 1e90;

/// Products and sums that underflow in a Horner step lose at most [`TINY`](crate::numeric::TINY)
/// each; 3 a step, 25 steps, divided by a weight sum of at least `1 / LARGEST`, the binomials' factor
/// of at most 2^25 included: far below this.
const UNDERFLOW: f64 = 1e-170;

impl<T: Real> Horner<T> {
    /// Error analysis. Let `b_i` be the exact control points, `U` the largest `|X_i / W_i|`, and
    /// `x` the quotient t / (1 - t) as rounded (a slightly different parameter, see
    /// [`Horner::shift`]). Each coefficient is off by its radius and one rounding, and takes part in at
    /// most 2p more roundings, so with unit h and `g = (2p + 2) h / (1 - (2p + 2) h)`:
    /// `|X^ - X| <= sum C x^i (g |X_i| + r_i)`, and likewise W. As all weights are positive, a quotient
    /// of sums is at most the largest quotient of terms (mediant): `|X^ - X| / W <= g U + R` with
    /// `R = max r_i / W_i`, `|W^ - W| / W <= g + S`, `S = max s_i / W_i`. Then
    /// `|X^/W^ - X/W| <= (g U + R + U (g + S)) / (1 - g - S)`, and one more rounding of the quotient.
    pub(super) fn new(b: &[Ball3]) -> Self {
        let p = b.len() - 1;
        let unit = T::UNIT;
        let mut coefficients = Vec::with_capacity(p + 1);
        let mut largest = [0.0f64; 2];
        let mut spread = [0.0f64; 3];
        let mut in_range = true;
        for (point, c) in b.iter().zip(binomials(p)) {
            let c = c as f64;
            let low = point[2].lower();
            in_range &= low > 1.0 / LARGEST && point[2].upper() < LARGEST;
            let mut row = [T::ZERO; 3];
            for i in 0..3 {
                let (mid, lost) = T::from_dd(point[i].mid);
                row[i] = mid * T::from_f64(c);
                let radius = (point[i].rad + lost) * INFLATE;
                spread[i] = spread[i].max(radius / low * INFLATE);
                if i < 2 {
                    let m = point[i].magnitude();
                    in_range &= m < LARGEST;
                    largest[i] = largest[i].max(m / low * INFLATE);
                }
            }
            coefficients.push(row);
        }
        let g = (2 * p + 2) as f64 * unit * INFLATE;
        let s = g + spread[2];
        let error = [0, 1].map(|i| {
            let u = largest[i];
            let e = (g * u + spread[i] + u * s) / (1.0 - s) + 2.0 * T::DIV_UNIT * u;
            if in_range && s < 0.25 && u < LARGEST {
                e * INFLATE + UNDERFLOW
            } else {
                f64::INFINITY
            }
        });
        // x off by a factor 1 + d moves every term by at most (1 + d)^p - 1 <= 2 p d, relative
        // to its weight: the quotient by 4 p d U. d <= 2 UNIT + DIV_UNIT.
        let d = 2.0 * unit + T::DIV_UNIT;
        let shift = [0, 1].map(|i| 4.0 * p as f64 * d * largest[i] * INFLATE);
        Self {
            coefficients: coefficients.into(),
            error,
            shift,
        }
    }

    /// A point whose coordinates are within [`error`](Self::error) of a point of the curve at
    /// a parameter within a relative 3 units of `t` (of `1 - t` above 1/2).
    #[inline]
    pub(super) fn eval(&self, t: T) -> [T; 2] {
        let c = &self.coefficients;
        let s = T::ONE - t;
        let mut sum;
        if t <= s {
            let x = t / s;
            let (last, rest) = (c[c.len() - 1], &c[..c.len() - 1]);
            sum = last;
            for a in rest.iter().rev() {
                sum = [sum[0] * x + a[0], sum[1] * x + a[1], sum[2] * x + a[2]];
            }
        } else {
            let x = s / t;
            sum = c[0];
            for a in &c[1..] {
                sum = [sum[0] * x + a[0], sum[1] * x + a[1], sum[2] * x + a[2]];
            }
        }
        [sum[0] / sum[2], sum[1] / sum[2]]
    }
}

impl Horner<f64> {
    /// An enclosure of the point at `t`, `[axis][lo, hi]`; unbounded where f64 is out of range.
    pub(super) fn enclosure(&self, t: f64) -> [[f64; 2]; 2] {
        let p = self.eval(t);
        [0, 1].map(|i| {
            let e = (self.error[i] + self.shift[i]) * INFLATE;
            let (lo, hi) = ((p[i] - e).next_down(), (p[i] + e).next_up());
            if lo.is_nan() || hi.is_nan() {
                [f64::NEG_INFINITY, f64::INFINITY]
            } else {
                [lo, hi]
            }
        })
    }
}

/// A piece that hardly reaches past a line, by this share of their sizes (its box is rounded outward by a few ulps), may be beside it.
const GRAZING: f64 = 8.0 * f64::EPSILON;

/// Makes up for the rounding of up to 16 operations on bounds.
const INFLATE: f64 = 1.0 + 16.0 * f64::EPSILON;

impl Piece {
    pub(super) fn new(source: Source) -> Self {
        let balls = source.balls();
        Self::with_balls(source, &balls)
    }

    /// The same, given the source's control points.
    pub(super) fn with_balls(source: Source, balls: &[Ball3]) -> Self {
        let mut hull = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for b in balls {
            for (axis, side) in hull.iter_mut().enumerate() {
                let [lo, hi] = coordinate(b, axis);
                // NaN must widen, not vanish.
                side[0] = if lo >= side[0] { side[0] } else { lo };
                side[1] = if hi <= side[1] { side[1] } else { hi };
            }
        }
        for side in &mut hull {
            if side[0].is_nan() || side[1].is_nan() {
                *side = [f64::NEG_INFINITY, f64::INFINITY];
            }
        }
        Self {
            source: plain(balls).map_or(source, Source::Segment),
            hull,
            made: OnceLock::new(),
        }
    }

    /// The ends of a segment of f64.
    pub(super) fn segment(&self) -> Option<[[f64; 2]; 2]> {
        match &self.source {
            Source::Segment(ends) => Some(*ends),
            _ => None,
        }
    }

    fn made(&self) -> &Made {
        self.made.get_or_init(Box::default)
    }

    /// Its control points; made at the first call.
    pub(super) fn control(&self) -> &Control {
        let make = || Control::new(&self.source.balls());
        self.made().control.get_or_init(make)
    }

    /// In f64; made at the first call.
    #[inline]
    pub(super) fn coarse(&self) -> &Horner<f64> {
        let make = || Horner::new(&self.source.balls());
        self.made().coarse.get_or_init(make)
    }

    /// In double-double; made at the first call.
    pub(super) fn fine(&self) -> &Horner<Dd> {
        let make = || Horner::new(&self.source.balls());
        self.made().fine.get_or_init(make)
    }

    /// The same piece, without what has been made of it.
    pub(super) fn afresh(&self) -> Self {
        Self {
            source: self.source.clone(),
            hull: self.hull,
            made: OnceLock::new(),
        }
    }

    /// In integers; made at the first call. `None` where the data are not rational.
    pub(super) fn exact(&self) -> Option<&Exact> {
        let make = || {
            let b = self.source.exact()?;
            let column = |i: usize| {
                Polynomial::from_bernstein(&b.iter().map(|p| p[i].clone()).collect::<Vec<_>>())
            };
            let constant =
                [0, 1].map(|i: usize| b.iter().all(|p| &p[i] * &b[0][2] == &b[0][i] * &p[2]));
            Some(Exact {
                u: column(0),
                v: column(1),
                w: column(2),
                constant,
            })
        };
        self.made().exact.get_or_init(make).as_ref()
    }

    /// An enclosure of the point at `t`, `[axis][lo, hi]`, given the source's control points.
    pub(super) fn enclosure(&self, t: f64, balls: &[Ball3]) -> [[f64; 2]; 2] {
        let at_end = match t {
            0.0 => balls.first(),
            1.0 => balls.last(),
            _ => None,
        };
        if let Some(b) = at_end {
            return [coordinate(b, 0), coordinate(b, 1)];
        }
        let fine = self.fine();
        let point = fine.eval(Dd::from(t));
        [0, 1].map(|i| {
            let ball = Ball {
                mid: point[i],
                rad: (fine.error[i] + fine.shift[i]) * INFLATE,
            };
            let (lo, hi) = (ball.lower(), ball.upper());
            [
                if lo.is_nan() {
                    self.hull[i][0]
                } else {
                    lo.max(self.hull[i][0])
                },
                if hi.is_nan() {
                    self.hull[i][1]
                } else {
                    hi.min(self.hull[i][1])
                },
            ]
        })
    }

    /// No [enclosure](Horner::enclosure) of a point of it in f64 is wider along an axis.
    pub(super) fn blur(&self, coarse: &Horner<f64>, axis: usize) -> f64 {
        let size = self.hull[axis].iter().fold(0.0f64, |m, x| m.max(x.abs()));
        3.0 * (coarse.error[axis] + coarse.shift[axis]) + 8.0 * f64::EPSILON * size
    }

    /// Box of one coordinate over `[a, b]`, from the control points of that part (blossoms), given the source's.
    pub(super) fn sub_hull(&self, axis: usize, [a, b]: [f64; 2], points: &[Ball3]) -> [f64; 2] {
        let p = points.len() - 1;
        let [mut lo, mut hi] = [f64::INFINITY, f64::NEG_INFINITY];
        // The coordinate and the weight alone.
        let plain: Vec<[Ball<Dd>; 2]> = points.iter().map(|b| [b[axis], b[2]]).collect();
        let mut d = Vec::with_capacity(plain.len());
        for k in 0..=p {
            d.clear();
            d.extend_from_slice(&plain);
            for r in 1..=p {
                let t = if r > p - k { b } else { a };
                let (s, t) = (Ball::difference(1.0, t), Ball::exact(t));
                for j in 0..=p - r {
                    d[j] = [0, 1].map(|i| s * d[j][i] + t * d[j + 1][i]);
                }
            }
            let [x, w]: [Ball<Dd>; 2] = d[0];
            let [l, h] = quotient(x, w);
            (lo, hi) = (lo.min(l), hi.max(h));
        }
        [lo.max(self.hull[axis][0]), hi.min(self.hull[axis][1])]
    }

    /// Proven: nowhere on the piece is this coordinate equal to `q`. Exact; asked in earnest only where the coordinate's range on a
    /// part of the piece, `[lo, hi]`, lies on one side of `q` but for what it may be off.
    pub(super) fn is_beside(&self, axis: usize, [lo, hi]: [f64; 2], q: f64) -> bool {
        let slack = GRAZING * (lo.abs().max(hi.abs()) + q.abs());
        if slack == f64::INFINITY || (hi > q + slack && lo < q - slack) {
            return false;
        }
        match &self.source {
            Source::Blurred(ends) => {
                let orders = ends.each_ref().map(|e| e.compare(axis, q));
                orders == [Some(Ordering::Less); 2] || orders == [Some(Ordering::Greater); 2]
            }
            Source::Arc(span) => span.is_beside(axis, q),
            _ => self
                .exact()
                .and_then(|exact| exact.offset(axis, q))
                .is_some_and(|g| roots::none(&g)),
        }
    }

    /// Whether `q` is in the closed box of the two end points: exactly, or where the
    /// ends are known in enclosures only (in double-double, so far below an ulp) and their circles do not tell, in the box of those.
    pub(super) fn in_box(&self, q: [f64; 2]) -> bool {
        if let Source::Blurred(ends) = &self.source {
            return (0..2).all(|axis| {
                let orders = ends.each_ref().map(|e| e.compare(axis, q[axis]));
                // Not certainly on one side of both.
                orders != [Some(Ordering::Less); 2] && orders != [Some(Ordering::Greater); 2]
            });
        }
        let Some(exact) = self.exact() else {
            return true;
        };
        (0..2).all(|axis| {
            exact.offset(axis, q[axis]).is_some_and(|g| {
                let c = g.coefficients();
                let (a, b) = (signum(&c[0]), signum(&c[c.len() - 1]));
                a * b <= 0
            })
        })
    }
}

impl Control {
    /// From its balls.
    pub(super) fn new(balls: &[Ball3]) -> Self {
        let mut radius = [0.0f64; 3];
        for b in balls {
            for i in 0..3 {
                radius[i] = radius[i].max((b[i].rad + b[i].mid.lo.abs()) * INFLATE);
            }
        }
        let points = balls.iter().map(|b| b.map(|x| x.mid.hi));
        Self {
            points: points.collect(),
            radius,
        }
    }

    /// The control points of the part over `[t[0], t[1]]`, by blossoms in f64.
    pub(super) fn sub_points(&self, t: [f64; 2]) -> Vec<[Ball<f64>; 3]> {
        let ball = |p: &[f64; 3]| {
            [0, 1, 2].map(|i| Ball {
                mid: p[i],
                rad: self.radius[i],
            })
        };
        let points: Vec<[Ball<f64>; 3]> = self.points.iter().map(ball).collect();
        if t == [0.0, 1.0] {
            return points;
        }
        let p = points.len() - 1;
        (0..=p)
            .map(|k| {
                let mut d = points.clone();
                for r in 1..=p {
                    let x = if r > p - k { t[1] } else { t[0] };
                    let (s, x) = (Ball::difference(1.0, x), Ball::exact(x));
                    for j in 0..=p - r {
                        d[j] = [0, 1, 2].map(|i| s * d[j][i] + x * d[j + 1][i]);
                    }
                }
                d[0]
            })
            .collect()
    }

    /// Proven: no second derivative of u and of v by t is larger, on a piece in this box; infinite where that is not known.
    ///
    /// With `u - base = Y / W`: `u'' = Y'' / W - (2 Y' W' + Y W'') / W^2 + 2 Y W'^2 / W^3`. Derivatives are at most p, and p (p - 1), times
    /// the greatest first and second differences of control points.
    pub(super) fn bend(&self, hull: &[[f64; 2]; 2]) -> [f64; 2] {
        let Self { points: b, radius } = self;
        let p = b.len().saturating_sub(1) as f64;
        // Each value is off by `off`, its differences by 2 and 4 times that.
        let derivatives = |value: &dyn Fn(&[f64; 3]) -> f64, off: f64| {
            let most = |x: f64, y: f64| if x.abs() > y { x.abs() } else { y };
            let value0 = b.iter().map(value).fold(0.0, |m, x| most(x, m));
            let first = b.windows(2).map(|w| value(&w[1]) - value(&w[0]));
            let second = b
                .windows(3)
                .map(|w| value(&w[2]) - 2.0 * value(&w[1]) + value(&w[0]));
            [
                value0 + off,
                p * (first.fold(0.0, |m, x| most(x, m)) + 2.0 * off),
                p * (p - 1.0) * (second.fold(0.0, |m, x| most(x, m)) + 4.0 * off),
            ]
        };
        let size = |i: usize| b.iter().fold(0.0f64, |m, x| m.max(x[i].abs()));
        let rounding = 16.0 * f64::EPSILON;
        let w_off = radius[2] + rounding * size(2);
        let w = derivatives(&|x| x[2], w_off);
        let least = b.iter().fold(f64::INFINITY, |m, x| m.min(x[2])) - w_off;
        [0, 1].map(|i| {
            let [lo, hi] = hull[i];
            let base = 0.5 * (lo + hi);
            let off =
                radius[i] + base.abs() * radius[2] + rounding * (size(i) + base.abs() * size(2));
            let y = derivatives(&|x| x[i] - base * x[2], off);
            let bend = (y[2]
                + (2.0 * y[1] * w[1] + y[0] * w[2] + 2.0 * y[0] * w[1] * w[1] / least) / least)
                / least;
            let known = least > 1.0 / LARGEST && bend < LARGEST;
            if known {
                bend * (1.0 + 2.0 * rounding) + UNDERFLOW
            } else {
                f64::INFINITY
            }
        })
    }
}

/// The ends of what is a segment of f64, however it was given.
fn plain(balls: &[Ball3]) -> Option<[[f64; 2]; 2]> {
    let [a, b] = balls else {
        return None;
    };
    let exact = |x: &Ball<Dd>| x.rad == 0.0 && x.mid.lo == 0.0;
    let all = a.iter().chain(b).all(exact) && a[2].mid.hi == 1.0 && b[2].mid.hi == 1.0;
    all.then(|| [a, b].map(|p| [p[0].mid.hi, p[1].mid.hi]))
}

/// Enclosure of one coordinate of a homogeneous point.
fn coordinate(b: &Ball3, axis: usize) -> [f64; 2] {
    quotient(b[axis], b[2])
}

/// Enclosure of a quotient; a single number where it is one.
fn quotient(x: Ball<Dd>, w: Ball<Dd>) -> [f64; 2] {
    if x.rad == 0.0 && w.rad == 0.0 && x.mid.lo == 0.0 && w.mid.lo == 0.0 && w.mid.hi > 0.0 {
        if w.mid.hi == 1.0 {
            return [x.mid.hi, x.mid.hi];
        }
        let q = x.mid.hi / w.mid.hi;
        let back = Dd::product(q, w.mid.hi);
        let plain = |x: f64| x == 0.0 || (x.abs() > 1e-200 && x.abs() < 1e200);
        if back.hi == x.mid.hi && back.lo == 0.0 && plain(q) && plain(w.mid.hi) && plain(x.mid.hi) {
            return [q, q];
        }
    }
    let q = x / w;
    let (lo, hi) = (q.lower(), q.upper());
    if lo.is_nan() || hi.is_nan() || !w.is_above(0.0) {
        return [f64::NEG_INFINITY, f64::INFINITY];
    }
    [lo, hi]
}

impl Exact {
    /// `X - q W` for one axis.
    pub(super) fn offset(&self, axis: usize, q: f64) -> Option<Polynomial> {
        let q = Dyadic::from_f64(q)?;
        let x = if axis == 0 { &self.u } else { &self.v };
        let up = q.exponent().max(0) as usize;
        let down = (-q.exponent()).max(0) as usize;
        let m: IBig = q.mantissa().clone() << up;
        Some(Polynomial::new(
            x.coefficients()
                .iter()
                .zip(self.w.coefficients())
                .map(|(x, w)| (x.clone() << down) - &m * w)
                .collect(),
        ))
    }

    /// The numerator of the derivative of one coordinate, up to a positive factor; of degree p - 1 for
    /// constant weights, else 2p - 2.
    pub(super) fn derivative(&self, axis: usize) -> Polynomial {
        let x = if axis == 0 { &self.u } else { &self.v };
        let n = x.degree();
        let c = binomials(n);
        let w = self.w.coefficients();
        // w_i = C(n, i) times a constant.
        if (0..=n).all(|i| w[i] == &w[0] * IBig::from(c[i])) {
            let b: Vec<IBig> = (0..=n)
                .map(|i| &x.coefficients()[i] / IBig::from(c[i]))
                .collect();
            let d: Vec<IBig> = b.windows(2).map(|p| &p[1] - &p[0]).collect();
            return Polynomial::from_bernstein(&d);
        }
        x.quotient_derivative(&self.w)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn balls(x: f64, radius: f64, w: f64, weight_radius: f64) -> Ball3 {
        let ball = |x: f64, rad| Ball {
            mid: Dd::from(x),
            rad,
        };
        [ball(x, radius), ball(x, radius), ball(w, weight_radius)]
    }

    /// A quotient is one number only if it is: `lo w <= x <= hi w`, exactly, and more than one where `q w = x` for no f64.
    #[test]
    fn coordinates_are_enclosed() {
        let exact = |x: f64| Dyadic::from_f64(x).unwrap();
        for x in [
            1.0, 0.7, 1e-10, 1e150, 1e-150, 1e-250, 1e-300, 1e-307, 3e-323,
        ] {
            for w in [1.0, 2.0, 0.5, 3.0, 0.1, 1e-60, 1e60] {
                for x in [x, -x, 3.0 * x] {
                    let [lo, hi] = coordinate(&balls(x, 0.0, w, 0.0), 0);
                    assert!(&exact(lo) * &exact(w) <= exact(x), "{x:e} {w:e}");
                    assert!(&exact(hi) * &exact(w) >= exact(x), "{x:e} {w:e}");
                }
            }
        }
        // Plain ones are single numbers.
        for (x, w, q) in [
            (1.0, 2.0, 0.5),
            (0.0, 3.0, 0.0),
            (-6.0, 3.0, -2.0),
            (0.1, 1.0, 0.1),
        ] {
            assert_eq!(coordinate(&balls(x, 0.0, w, 0.0), 1), [q, q]);
        }
        let [lo, hi] = coordinate(&balls(1.0, 0.0, 2.0, 1e-3), 0);
        assert!(lo <= 1.0 / 2.001 && hi >= 1.0 / 1.999);
        let unknown = [f64::NEG_INFINITY, f64::INFINITY];
        assert_eq!(coordinate(&balls(1.0, 0.0, 1e-3, 2e-3), 0), unknown);
    }

    /// As the proof counts, for control points of size 1 and weights 1 with radii: `(g U + R + U (g + S)) / (1 - g - S)` and the quotient's rounding.
    #[test]
    fn errors_of_evaluation_are_at_least_the_proofs() {
        fn check<T: Real>(radius: f64, weight_radius: f64) {
            for p in [1, 3, 7] {
                let points = vec![balls(1.0, radius, 1.0, weight_radius); p + 1];
                let g = (2 * p + 2) as f64 * T::UNIT;
                let least = g + radius + (g + weight_radius) + T::DIV_UNIT;
                let horner = Horner::<T>::new(&points);
                for error in horner.error {
                    assert!((least..=1.5 * least).contains(&error), "{p}: {error:e}");
                }
                // Relative 2 units of the parameter, and the quotient's: 4 p d U.
                let moved = 4.0 * p as f64 * (2.0 * T::UNIT + T::DIV_UNIT);
                for shift in horner.shift {
                    assert!((moved..=1.2 * moved).contains(&shift), "{p}: {shift:e}");
                }
            }
        }
        for (radius, weight_radius) in [(0.0, 0.0), (1e-9, 1e-8), (1e-8, 0.0)] {
            check::<f64>(radius, weight_radius);
            check::<Dd>(radius, weight_radius);
        }
        // Coordinates of size x with exact points: all of it x times.
        for x in [16.0, 1.0 / 16.0] {
            let horner = Horner::<f64>::new(&[balls(x, 0.0, 1.0, 0.0); 4]);
            let least = x * (2.0 * 8.0 * f64::UNIT + f64::DIV_UNIT);
            for error in horner.error {
                assert!((least..=1.5 * least).contains(&error), "{x}: {error:e}");
            }
        }
        // Out of the range in which they hold, there is none.
        for (x, w) in [(1e100, 1.0), (1e100, 1e85), (1.0, 1e100), (1.0, 1e-100)] {
            let error = Horner::<f64>::new(&[balls(x, 0.0, w, 0.0); 2]).error;
            assert_eq!(error, [f64::INFINITY; 2]);
        }
        // Weights known within 0.15: the quotient is up to 1 / 0.85.
        let error = Horner::<f64>::new(&[balls(1.0, 0.0, 1.0, 0.15); 2]).error;
        assert!(error[0] >= 1.0 / 0.85 - 1.0 && error[0] < 0.3, "{error:?}");
        let vague = Horner::<f64>::new(&[balls(1.0, 0.0, 1.0, 0.3); 2]).error;
        assert_eq!(vague, [f64::INFINITY; 2]);
    }
}
