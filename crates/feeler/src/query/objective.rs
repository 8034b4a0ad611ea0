//! What a search minimises: the squared distance to a point, or the height
//! over a plane, each a quotient `f = N / C` of polynomials on every patch and boundary piece.

use crate::numeric::{Ball, Dd, Real};
use crate::prepare::closed::Target;
use crate::prepare::{Homogeneous, Net, Products, Quotient, jet};
use nalgebra::{Point3, Vector3};

/// What is minimised over the BREP.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Objective {
    /// `f = |S - q|^2`: `N = |X - q w|^2`, `C = w^2`.
    SquaredDistance(Point3<f64>),
    /// `f = n.S - h`: `N = n.X - h w`, `C = w`.
    Height(Vector3<f64>, f64),
}

/// `N`, `C` and their first derivatives at one point, with bounds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) n: Ball<Dd>,
    pub(crate) c: Ball<Dd>,
    pub(crate) n_slope: [Ball<Dd>; 2],
    pub(crate) c_slope: [Ball<Dd>; 2],
    /// The homogeneous point, where it was found in double-double.
    pub(crate) point: Option<Homogeneous<Dd, 4>>,
}

impl Sample {
    /// The value `f`.
    pub(crate) fn value(&self) -> Ball<Dd> {
        quotient(self.n, self.c)
    }
}

/// `f` and its first and second derivatives at one point, in plain f64: a guide for Newton's method,
/// no proof rests on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Guide {
    pub(crate) value: f64,
    pub(crate) slope: [f64; 2],
    /// `f_ss`, `f_st`, `f_tt`.
    pub(crate) curvature: [f64; 3],
}

/// The bound on a sum of a few parts is itself rounded a few times.
const BOUND_UP: f64 = 1.0 + 32.0 * f64::EPSILON;

/// A ball that holds a range.
pub(super) fn ball_around([low, high]: [Dd; 2]) -> Ball<Dd> {
    let half = (high - low).half();
    let mid = low + half;
    // The difference, the sum and the half's leading part are off by a rounding each.
    let rad = half.magnitude() * (1.0 + 4.0 * f64::EPSILON) + 4.0 * Dd::UNIT * mid.magnitude();
    Ball { mid, rad }
}

impl Objective {
    /// The same for closed forms.
    pub(crate) fn target(&self) -> Target {
        match self {
            Self::SquaredDistance(q) => Target::Point(q.coords.into()),
            Self::Height(n, h) => Target::Height((*n).into(), *h),
        }
    }

    /// Whether `f` is never negative.
    pub(crate) fn is_squared(&self) -> bool {
        matches!(self, Self::SquaredDistance(_))
    }

    /// The quotient on a net. The bound counts, for each coefficient, what it inherits and at most
    /// eight roundings of parts no larger than the sum of the parts' largest.
    /// It takes the lists of another quotient, whatever they hold.
    pub(crate) fn quotient<'p, T: Real + 'p>(
        &self,
        net: &Net<T>,
        products: impl FnOnce() -> &'p Products<T>,
        spare: Quotient<T>,
    ) -> Quotient<T> {
        match self {
            Self::SquaredDistance(q) => spare.made_squared_distance(q, net, products()),
            Self::Height(n, h) => {
                let h = local_offset::<T>(n, *h, &net.origin);
                let normal: [T; 3] = std::array::from_fn(|c| T::from_f64(n[c]));
                let Quotient {
                    n: mut values,
                    mut c,
                    ..
                } = spare;
                values.clear();
                values.extend(net.points.iter().map(|p| {
                    normal[0] * p[0].mid + normal[1] * p[1].mid + normal[2] * p[2].mid
                        - h.mid * p[3].mid
                }));
                c.clear();
                if !net.unit_weights {
                    c.extend(net.points.iter().map(|p| p[3].mid));
                }
                // As of the coefficients of each coordinate.
                let (largest, off) = (net.reach, net.blur);
                let mut size = h.magnitude() * largest[3];
                let mut error = h.magnitude() * off[3] + h.rad * largest[3];
                for c in 0..3 {
                    size += n[c].abs() * largest[c];
                    error += n[c].abs() * off[c];
                }
                Quotient {
                    degree: net.degree,
                    n: values,
                    n_error: (error + 8.0 * (T::UNIT * size + net.tiny)) * BOUND_UP,
                    c_error: if net.unit_weights { 0.0 } else { off[3] },
                    tiny: net.tiny,
                    c,
                }
            }
        }
    }

    /// `N`, `C` and derivatives at a local point of a net.
    pub(crate) fn sample<T: Real>(&self, net: &Net<T>, s: Ball<T>, t: Ball<T>) -> Sample {
        let jet = net.jet(s, t);
        self.combined(&net.origin, &[jet.value, jet.s, jet.t])
    }

    /// The same in f64 at an exact point, for nets that [fit](jet::fits): far cheaper.
    pub(crate) fn rough_sample(&self, net: &Net<f64>, p: [f64; 2]) -> Sample {
        self.combined(&net.origin, &jet::jet(net, p[0], p[1]))
    }

    /// That, with the homogeneous point.
    pub(crate) fn rough_point(&self, net: &Net<f64>, p: [f64; 2]) -> ([Ball<f64>; 4], Sample) {
        let jet = jet::jet(net, p[0], p[1]);
        (jet[0], self.combined(&net.origin, &jet))
    }

    /// The value alone of that.
    pub(crate) fn rough_value(&self, net: &Net<f64>, p: [f64; 2]) -> Ball<Dd> {
        let (n, c) = self.values(&net.origin, &jet::point(net, p[0], p[1]));
        quotient(n, c)
    }

    /// The same with values in double-double, derivatives in f64.
    pub(crate) fn fine_sample(
        &self,
        coarse: &Net<f64>,
        net: &Net<Dd>,
        p: [f64; 2],
    ) -> Option<Sample> {
        let value = jet::fine_value(net, p.map(Ball::exact))?;
        let [_, s, t] = jet::jet(coarse, p[0], p[1]);
        let rounded = value.map(|b| Ball::<f64>::from_dd(b.mid, b.rad));
        // Each net has an origin of its own.
        let slopes = self.slopes([&net.origin, &coarse.origin], &[rounded, s, t]);
        let (n, c) = self.values(&net.origin, &value);
        let point = Some(value);
        Some(Sample {
            n,
            c,
            point,
            ..slopes
        })
    }

    /// `f` at a local point of a net, in double-double.
    pub(crate) fn value(&self, net: &Net<Dd>, local: [Ball<Dd>; 2]) -> Ball<Dd> {
        match jet::fine_value(net, local) {
            Some(value) => {
                let (n, c) = self.values(&net.origin, &value);
                quotient(n, c)
            }
            None => self.sample(net, local[0], local[1]).value(),
        }
    }

    fn combined<T: Real>(&self, origin: &[f64; 3], jet: &[[Ball<T>; 4]; 3]) -> Sample {
        let (n, c) = self.values(origin, &jet[0]);
        Sample {
            n,
            c,
            ..self.slopes([origin; 2], jet)
        }
    }

    /// `X - q w`: the cancellation happens here, on exact q. Nothing is multiplied by a weight that is 1.
    fn offset<T: Real>(q: &Point3<f64>, origin: &[f64; 3], h: &[Ball<T>; 4]) -> [Ball<T>; 3] {
        let unit = h[3].is_one();
        std::array::from_fn(|c| {
            let q = Ball::difference(q[c], origin[c]);
            h[c] - if unit { q } else { q * h[3] }
        })
    }

    /// The derivative of that, of a weight that is `w`.
    fn offset_slope<T: Real>(
        q: &Point3<f64>,
        origin: &[f64; 3],
        w: &Ball<T>,
        h: &[Ball<T>; 4],
    ) -> [Ball<T>; 3] {
        if w.is_one() {
            return [h[0], h[1], h[2]];
        }
        Self::offset(q, origin, h)
    }

    fn height<T: Real>(n: &Vector3<f64>, h: f64, origin: &[f64; 3], p: &[Ball<T>; 4]) -> Ball<T> {
        let h = local_offset(n, h, origin);
        let n: [Ball<T>; 3] = std::array::from_fn(|c| Ball::exact(n[c]));
        n[0] * p[0] + n[1] * p[1] + n[2] * p[2] - h * p[3]
    }

    /// `N` and `C`.
    fn values<T: Real>(&self, origin: &[f64; 3], value: &[Ball<T>; 4]) -> (Ball<Dd>, Ball<Dd>) {
        match self {
            Self::SquaredDistance(q) => {
                let m = Self::offset(q, origin, value);
                let w = value[3];
                let c = if w.is_one() { w } else { w.square() };
                (dot(&m, &m).to_dd(), c.to_dd())
            }
            Self::Height(n, h) => (Self::height(n, *h, origin, value).to_dd(), value[3].to_dd()),
        }
    }

    /// The derivatives of `N` and `C`; values are left at zero. The point is relative to one origin, its derivatives (which hang on it as the weight's do) to
    /// another.
    fn slopes<T: Real>(
        &self,
        [origin, slope_origin]: [&[f64; 3]; 2],
        jet: &[[Ball<T>; 4]; 3],
    ) -> Sample {
        let (n_slope, c_slope) = match self {
            Self::SquaredDistance(q) => {
                let m = Self::offset(q, origin, &jet[0]);
                let w = jet[0][3];
                let twice = |x: Ball<T>| x + x;
                let n =
                    |k: usize| twice(dot(&m, &Self::offset_slope(q, slope_origin, &w, &jet[k])));
                let c = |k: usize| match w.is_one() {
                    true => Ball::ZERO,
                    false => twice(w * jet[k][3]),
                };
                // Written out: `map` is not inlined.
                ([n(1), n(2)], [c(1), c(2)])
            }
            Self::Height(n, h) => (
                [1, 2].map(|k| Self::height(n, *h, slope_origin, &jet[k])),
                [1, 2].map(|k| jet[k][3]),
            ),
        };
        Sample {
            n: Ball::ZERO,
            c: Ball::ZERO,
            n_slope: n_slope.map(Ball::to_dd),
            c_slope: c_slope.map(Ball::to_dd),
            point: None,
        }
    }

    /// `f` in f64, as [`guide`](Self::guide) has it.
    pub(crate) fn guide_value(&self, net: &Net<f64>, s: f64, t: f64) -> f64 {
        if !jet::fits(net.degree) {
            return self.guide(net, s, t).value;
        }
        let h = jet::value(net, s, t);
        let x: [f64; 3] = std::array::from_fn(|c| h[c] / h[3]);
        match self {
            Self::SquaredDistance(q) => (0..3)
                .map(|c| (x[c] - (q[c] - net.origin[c])).powi(2))
                .sum(),
            Self::Height(n, h) => {
                (0..3).map(|c| n[c] * x[c]).sum::<f64>()
                    + (0..3).map(|c| n[c] * net.origin[c]).sum::<f64>()
                    - h
            }
        }
    }

    /// `f` and its derivatives in f64.
    pub(crate) fn guide(&self, net: &Net<f64>, s: f64, t: f64) -> Guide {
        let j = if jet::fits(net.degree) {
            jet::jet2(net, s, t)
        } else {
            jet2(net, s, t)
        };
        let w = 1.0 / j[0][3];
        let at = |k: usize, c: usize| j[k][c];
        let mut x = j.map(|h| [h[0], h[1], h[2]]);
        // The quotient rule, term by term (The NURBS Book, eq. 4.20), where it is one.
        for c in 0..if net.unit_weights { 0 } else { 3 } {
            let p = at(0, c) * w;
            let ps = (at(1, c) - at(1, 3) * p) * w;
            let pt = (at(2, c) - at(2, 3) * p) * w;
            x[0][c] = p;
            x[1][c] = ps;
            x[2][c] = pt;
            x[3][c] = (at(3, c) - 2.0 * at(1, 3) * ps - at(3, 3) * p) * w;
            x[4][c] = (at(4, c) - at(1, 3) * pt - at(2, 3) * ps - at(4, 3) * p) * w;
            x[5][c] = (at(5, c) - 2.0 * at(2, 3) * pt - at(5, 3) * p) * w;
        }
        let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        match self {
            Self::SquaredDistance(q) => {
                let r: [f64; 3] = std::array::from_fn(|c| x[0][c] - (q[c] - net.origin[c]));
                let second =
                    |a: usize, b: usize, k: usize| 2.0 * (dot(&x[a], &x[b]) + dot(&r, &x[k]));
                Guide {
                    value: dot(&r, &r),
                    slope: [2.0 * dot(&r, &x[1]), 2.0 * dot(&r, &x[2])],
                    curvature: [second(1, 1, 3), second(1, 2, 4), second(2, 2, 5)],
                }
            }
            Self::Height(n, h) => {
                let n = [n.x, n.y, n.z];
                Guide {
                    value: dot(&n, &x[0]) + dot(&n, &net.origin) - h,
                    slope: [dot(&n, &x[1]), dot(&n, &x[2])],
                    curvature: [dot(&n, &x[3]), dot(&n, &x[4]), dot(&n, &x[5])],
                }
            }
        }
    }
}

/// `N / C`.
fn quotient(n: Ball<Dd>, c: Ball<Dd>) -> Ball<Dd> {
    if c.is_one() { n } else { n / c }
}

/// `h - n.o`, in double-double at least.
fn local_offset<T: Real>(n: &Vector3<f64>, h: f64, origin: &[f64; 3]) -> Ball<T> {
    if T::UNIT < Dd::UNIT {
        return offset_in(n, h, origin);
    }
    let offset = offset_in::<Dd>(n, h, origin);
    Ball::from_dd(offset.mid, offset.rad)
}

fn offset_in<T: Real>(n: &Vector3<f64>, h: f64, origin: &[f64; 3]) -> Ball<T> {
    let mut sum = Ball::exact(h);
    for c in 0..3 {
        sum = sum - Ball::exact(n[c]) * Ball::exact(origin[c]);
    }
    sum
}

pub(crate) fn dot<T: Real>(a: &[Ball<T>; 3], b: &[Ball<T>; 3]) -> Ball<T> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Value, `_s`, `_t`, `_ss`, `_st`, `_tt` of the homogeneous point, in plain f64, of any degree.
fn jet2(net: &Net<f64>, s: f64, t: f64) -> [[f64; 4]; 6] {
    let rows = net.points.chunks_exact(net.degree.v + 1);
    let rows: Vec<[[f64; 4]; 3]> = rows
        .map(|row| line_jet2(row.iter().map(|p| p.map(|x| x.mid)), t))
        .collect();
    let column = |k: usize| line_jet2(rows.iter().map(|r| r[k]), s);
    let (value, along_t, along_tt) = (column(0), column(1), column(2));
    [
        value[0],
        value[1],
        along_t[0],
        value[2],
        along_t[1],
        along_tt[0],
    ]
}

/// Point, first and second derivative of a Bezier curve: from the last three of de Casteljau's triangle, the points of the curves without two of its first and last
/// control points, each as `sum binomial(n, i) t^i s^(n - i) p_i` with running powers, in as many steps as there are points.
fn line_jet2(mut points: impl ExactSizeIterator<Item = [f64; 4]>, t: f64) -> [[f64; 4]; 3] {
    let degree = points.len() - 1;
    let s = 1.0 - t;
    const NONE: [f64; 4] = [0.0; 4];
    let mut next = || points.next().unwrap_or(NONE);
    let mut a = next();
    if degree == 0 {
        return [a, NONE, NONE];
    }
    let mix = |a: [f64; 4], b: [f64; 4]| std::array::from_fn(|c| s * a[c] + t * b[c]);
    let less = |a: [f64; 4], b: [f64; 4]| std::array::from_fn(|c| b[c] - a[c]);
    let mut b = next();
    if degree == 1 {
        return [mix(a, b), less(a, b), NONE];
    }
    let n = degree - 2;
    let [mut low, mut middle, mut high] = [NONE; 3];
    let (mut power, mut binomial) = (1.0, 1.0);
    for i in 0..=n {
        let c = next();
        let factor = power * binomial;
        for k in 0..4 {
            low[k] = low[k] * s + factor * a[k];
            middle[k] = middle[k] * s + factor * b[k];
            high[k] = high[k] * s + factor * c[k];
        }
        (a, b) = (b, c);
        power *= t;
        binomial = binomial * (n - i) as f64 / (i + 1) as f64;
    }
    let slopes = [less(low, middle), less(middle, high)];
    let (first, second) = (degree as f64, (degree * (degree - 1)) as f64);
    [
        mix(mix(low, middle), mix(middle, high)),
        mix(slopes[0], slopes[1]).map(|x: f64| first * x),
        less(slopes[0], slopes[1]).map(|x: f64| second * x),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::curve_jet;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

        /// Of curves of any degree, against `curve_jet` in double-double, which rationals hold, the second derivative as the first one of the curve of differences.
        #[test]
        fn points_and_derivatives_of_any_degree(
            points in prop::collection::vec(prop::array::uniform4(-1.0..1.0f64), 1..200),
            t in prop_oneof![Just(0.0), Just(1.0), 0.0..1.0f64, (-40..0i32).prop_map(|e| 2f64.powi(e))],
        ) {
            // A factor of a sum meets 3 roundings a step and the sum itself 2, each a unit of what is added at most, of positive numbers that sum to 1; with some to spare.
            const ROUNDINGS: f64 = 8.0;
            let degree = points.len() - 1;
            let exact = |p: &[f64; 4]| p.map(Ball::<Dd>::exact);
            let fine: Vec<Homogeneous<Dd, 4>> = points.iter().map(exact).collect();
            let scale = Ball::exact(degree as f64);
            let differences: Vec<Homogeneous<Dd, 4>> = fine
                .windows(2)
                .map(|w| std::array::from_fn(|c| scale * (w[1][c] - w[0][c])))
                .collect();
            let (value, slope) = curve_jet(&fine, Ball::exact(t));
            let second = match differences.is_empty() {
                true => [Ball::ZERO; 4],
                false => curve_jet(&differences, Ball::exact(t)).1,
            };
            let found = line_jet2(points.iter().copied(), t);
            let mut unit = ROUNDINGS * (degree + 1) as f64 * f64::UNIT;
            for (k, truth) in [value, slope, second].iter().enumerate() {
                for c in 0..4 {
                    let off = (truth[c].mid - Dd::from(found[k][c])).magnitude();
                    prop_assert!(off <= unit + truth[c].rad, "{} {} {} {}", degree, t, k, off / unit);
                }
                // Differences of numbers that are off by as much each.
                unit *= 2.0 * degree as f64;
            }
        }
    }
}
