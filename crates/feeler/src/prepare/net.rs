//! Homogeneous nets and the products that a distance needs of them.

use super::quotient::MOST_OFF;
use super::{Homogeneous, restrict};
use crate::numeric::bernstein::{
    Bidegree, border, greater, lesser, product, product_units, split_error, split_off,
};
use crate::numeric::{Ball, Real, TINY};
use std::sync::OnceLock;

/// `origin + X / w`, a patch (or, with `degree.v = 0`, a curve) in space.
#[derive(Clone, Debug)]
pub struct Net<T> {
    /// Degrees.
    pub degree: Bidegree,
    /// Homogeneous points `(X, w)` relative to the origin, `(i, j)` at `i * (degree.v + 1) + j`.
    pub points: Vec<Homogeneous<T, 4>>,
    /// Where the net's zero is.
    pub origin: [f64; 3],
    /// See [`plain`](Self::plain).
    plain: OnceLock<Box<[[f64; 4]]>>,
    /// The largest magnitude of each coordinate.
    pub(crate) largest: [f64; 4],
    /// The largest bound on the error of each coordinate.
    pub(crate) spread: [f64; 4],
    /// The largest `|x| / w` of each coordinate, infinite where a weight may not be positive.
    pub(crate) reach: [f64; 4],
    /// The largest error of a coordinate over `w`, likewise.
    pub(crate) blur: [f64; 4],
    /// [`TINY`] over the least weight.
    pub(crate) tiny: f64,
    /// Whether all weights are 1, exactly.
    pub(crate) unit_weights: bool,
}

/// Plain coefficients `x_k` of a polynomial, with bounds in parts of positive numbers `m_k`: of the coefficients of the power of the weight that
/// it is over (the weights for a coordinate, those of `w^2` for a product of two), 1 where all weights are 1.
///
/// `|x_k - true| <= error m_k` and `|x_k| <= largest m_k`, with the true `m_k`. Sums of products with positive factors keep such bounds: what is
/// done to the coefficients is done to the `m_k` as well. So where weights differ by many powers of ten the errors are small beside
/// small weights, too.
#[derive(Clone, Debug)]
pub(crate) struct Coefficients<T> {
    pub(crate) values: Vec<T>,
    pub(crate) error: f64,
    pub(crate) largest: f64,
    /// [`TINY`] in parts of the least `m_k`: what an operation that underflows may lose.
    pub(crate) tiny: f64,
}

impl<T: Real> Coefficients<T> {
    /// The product with others; see [`product_units`] for the bound.
    pub(super) fn times(&self, degree: Bidegree, other: &Self, other_degree: Bidegree) -> Self {
        let units = product_units(degree, other_degree);
        let inherited =
            self.largest * other.error + other.largest * self.error + self.error * other.error;
        let tiny = self.tiny * (other.tiny / TINY);
        // What underflows in one factor is multiplied by the other.
        let lost = self.tiny * other.largest + other.tiny * self.largest + tiny;
        let error = inherited + units * (T::UNIT * self.largest * other.largest + lost);
        // A few roundings of the bounds themselves.
        const UP: f64 = 1.0 + 16.0 * f64::EPSILON;
        Self {
            values: product(&self.values, degree, &other.values, other_degree),
            error: error * UP,
            largest: (self.largest * other.largest + error) * UP,
            tiny: tiny * UP,
        }
    }

    /// Those of 1, without a list.
    pub(super) fn ones() -> Self {
        Self {
            values: Vec::new(),
            error: 0.0,
            largest: 1.0,
            tiny: TINY,
        }
    }

    /// Sums of parts no larger than `size` together, in parts of `c`, which they are over.
    pub(super) fn summed(values: Vec<T>, [error, size]: [f64; 2], c: &Self) -> Self {
        let over = |i: usize| c.values.get(i).map_or(1.0, |c| c.magnitude());
        let parts = values
            .iter()
            .enumerate()
            .map(|(i, a)| a.magnitude() / over(i));
        // The computed ones are off by a few roundings, as are their quotients.
        let largest = parts.fold(0.0, f64::max) * (1.0 + 2.0 * c.error + 16.0 * f64::EPSILON);
        Self {
            values,
            error,
            largest: if largest < size { largest } else { size },
            tiny: c.tiny,
        }
    }

    /// Becomes its lower half along u (or v); the upper one.
    fn split(&mut self, degree: Bidegree, along_u: bool) -> Self {
        let own = split_error::<T>(degree, along_u, self.largest, self.tiny);
        let high = split_off(&mut self.values, degree, along_u);
        const UP: f64 = 1.0 + 16.0 * f64::EPSILON;
        self.error = (self.error + own) * UP;
        self.largest = (self.largest + own) * UP;
        Self {
            values: high,
            ..*self
        }
    }
}

/// The parts of `N = |X - q w|^2 = a - 2 q.b + |q|^2 c`, linear in `(1, q, |q|^2)`.
#[derive(Clone, Debug)]
pub(crate) struct Products<T> {
    pub(crate) degree: Bidegree,
    /// `|X|^2`.
    pub(crate) a: Coefficients<T>,
    /// `X w`, each coordinate.
    pub(crate) b: [Coefficients<T>; 3],
    /// `w^2`; no list where all weights are 1, exactly: all of these are, too.
    pub(crate) c: Coefficients<T>,
    /// Whether they are.
    pub(crate) unit_weights: bool,
}

impl<T: Real> Products<T> {
    /// Bytes that it takes, as large as its lists were reserved.
    pub(super) fn bytes(&self) -> usize {
        let lists = [&self.a, &self.c].into_iter().chain(&self.b);
        let values: usize = lists.map(|c| c.values.capacity()).sum();
        size_of::<Self>() + values * size_of::<T>()
    }

    /// The same over a box that halving reaches; `None` for any other.
    pub(crate) fn restricted(&self, u: [f64; 2], v: [f64; 2]) -> Option<Self> {
        let mut out = self.clone();
        for (along_u, degree, target) in [(true, self.degree.u, u), (false, self.degree.v, v)] {
            let mut range = [0.0, 1.0];
            while degree > 0 && range != target {
                let middle = 0.5 * (range[0] + range[1]);
                let high = target[0] >= middle;
                range[usize::from(!high)] = middle;
                if !(range[0] <= target[0] && target[0] < target[1] && target[1] <= range[1]) {
                    return None;
                }
                let upper = out.split(along_u);
                if high {
                    out = upper;
                }
            }
        }
        Some(out)
    }

    /// Becomes its lower half along u (or v); the upper one.
    pub(crate) fn split(&mut self, along_u: bool) -> Self {
        let degree = self.degree;
        Self {
            degree,
            a: self.a.split(degree, along_u),
            b: self.b.each_mut().map(|b| b.split(degree, along_u)),
            c: if self.unit_weights {
                self.c.clone()
            } else {
                self.c.split(degree, along_u)
            },
            unit_weights: self.unit_weights,
        }
    }

    /// A box in space that holds what they are of; `None` where a weight may not be positive.
    ///
    /// The point is `origin + b / c`, thus a convex combination of the quotients of the coefficients. The computed `b` is off by
    /// `error` parts of the true `c`, and the computed `c` by its own.
    pub(crate) fn hull(&self, origin: &[f64; 3]) -> Option<[[f64; 2]; 3]> {
        let mut out = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        for (k, own) in out.iter_mut().enumerate() {
            let b = &self.b[k];
            let mut take = |at: f64| *own = [lesser(own[0], at), greater(own[1], at)];
            if self.unit_weights {
                b.values.iter().for_each(|x| take(x.approximate()));
            } else {
                let quotients = b.values.iter().zip(&self.c.values);
                quotients.for_each(|(x, c)| take(x.approximate() / c.approximate()));
            }
            let size = b.largest + b.error;
            let off = b.error + size * (2.0 * self.c.error + 16.0 * f64::EPSILON) + TINY;
            // What the origin adds is a rounding of the sum.
            const UP: f64 = 1.0 + 16.0 * f64::EPSILON;
            let off = (off + 4.0 * f64::EPSILON * (origin[k].abs() + size)) * UP;
            *own = [origin[k] + own[0] - off, origin[k] + own[1] + off];
        }
        let bounded = out.iter().flatten().all(|x| x.is_finite());
        (bounded && self.c.error <= MOST_OFF).then_some(out)
    }

    /// Those on one border: at the low or the high end of u (or v).
    pub(crate) fn border(&self, along_u: bool, high: bool) -> Self {
        let Bidegree { u, v } = self.degree;
        let take = |part: &Coefficients<T>| Coefficients {
            values: border(&part.values, self.degree, along_u, high),
            ..*part
        };
        Self {
            degree: if along_u {
                Bidegree { u: 0, v }
            } else {
                Bidegree { u, v: 0 }
            },
            a: take(&self.a),
            b: self.b.each_ref().map(take),
            c: match self.unit_weights {
                true => self.c.clone(),
                false => take(&self.c),
            },
            unit_weights: self.unit_weights,
        }
    }
}

impl<T: Real> Net<T> {
    /// A net of homogeneous points relative to `origin`.
    pub(crate) fn new(degree: Bidegree, points: Vec<Homogeneous<T, 4>>, origin: [f64; 3]) -> Self {
        let most = |of: fn(&Ball<T>) -> f64, c: usize| {
            points.iter().fold(0.0, |m: f64, p| m.max(of(&p[c])))
        };
        let unit_weights = points.iter().all(|p| p[3].mid == T::ONE && p[3].rad == 0.0);
        let (largest, spread) = (
            std::array::from_fn(|c| most(|x| x.mid.magnitude(), c)),
            std::array::from_fn(|c| most(|x| x.rad, c)),
        );
        let (mut reach, mut blur, mut tiny) = (largest, spread, TINY);
        if !unit_weights {
            (reach, blur, tiny) = ([0.0; 4], [0.0; 4], 0.0);
            for p in &points {
                let low = p[3].lower();
                // One rounding.
                let part = if low > 0.0 {
                    (1.0 + 4.0 * f64::EPSILON) / low
                } else {
                    f64::INFINITY
                };
                for (c, x) in p.iter().enumerate() {
                    reach[c] = greater(reach[c], x.mid.magnitude() * part);
                    blur[c] = greater(blur[c], x.rad * part);
                }
                tiny = greater(tiny, TINY * part);
            }
            if !tiny.is_finite() {
                (reach, blur) = ([f64::INFINITY; 4], [f64::INFINITY; 4]);
            }
        }
        Self {
            plain: OnceLock::new(),
            largest,
            spread,
            reach,
            blur,
            tiny,
            unit_weights,
            degree,
            points,
            origin,
        }
    }

    /// The points, rounded: made when first asked for, as many nets are searched by their products alone.
    pub(crate) fn plain(&self) -> &[[f64; 4]] {
        self.plain.get_or_init(|| {
            let points = self.points.iter();
            points.map(|p| p.map(|x| x.mid.approximate())).collect()
        })
    }

    /// Whether these have been made.
    pub(super) fn has_plain(&self) -> bool {
        self.plain.get().is_some()
    }

    /// One coordinate of all points.
    pub(crate) fn coordinate(&self, c: usize) -> Coefficients<T> {
        Coefficients {
            values: self.points.iter().map(|p| p[c].mid).collect(),
            error: self.blur[c],
            largest: self.reach[c],
            tiny: self.tiny,
        }
    }

    /// The products.
    pub(crate) fn products(&self) -> Products<T> {
        let w = self.coordinate(3);
        let c = match self.unit_weights {
            true => Coefficients::ones(),
            false => w.times(self.degree, &w, self.degree),
        };
        Products {
            degree: self.degree + self.degree,
            a: self.square(&c),
            b: std::array::from_fn(|k| self.coordinate(k).times(self.degree, &w, self.degree)),
            c,
            unit_weights: self.unit_weights,
        }
    }

    /// `|X|^2`, given `w^2`.
    pub(super) fn square(&self, c: &Coefficients<T>) -> Coefficients<T> {
        let squares: [_; 3] = std::array::from_fn(|k| {
            let x = self.coordinate(k);
            x.times(self.degree, &x, self.degree)
        });
        let mut values = squares[0].values.clone();
        for s in &squares[1..] {
            for (a, b) in values.iter_mut().zip(&s.values) {
                *a = *a + *b;
            }
        }
        let size: f64 = squares.iter().map(|s| s.largest).sum();
        let error: f64 = squares.iter().map(|s| s.error).sum();
        // Two additions of parts no larger than `size`.
        let error = (error + 2.0 * T::UNIT * size) * (1.0 + 16.0 * f64::EPSILON);
        Coefficients::summed(values, [error, size], c)
    }

    /// The control points of one side: of the curve at the start or the end of s (or of t).
    pub(crate) fn side(&self, of_s: bool, end: bool) -> Vec<Homogeneous<T, 4>> {
        let row = self.degree.v + 1;
        let last = |degree: usize| if end { degree } else { 0 };
        if of_s {
            let first = last(self.degree.u) * row;
            self.points[first..first + row].to_vec()
        } else {
            let lines = self.points.chunks_exact(row);
            lines.map(|l| l[last(self.degree.v)]).collect()
        }
    }

    /// The box of the net in space by the convex hull of its control points; `None` where a
    /// weight is not proven to be positive.
    pub(crate) fn bounding_box(&self) -> Option<[[f64; 2]; 3]> {
        hull(&self.points, &self.origin)
    }

    /// The same of the part over `u` and `v`, by its own control points.
    pub(super) fn box_over(&self, [u, v]: [[f64; 2]; 2]) -> Option<[[f64; 2]; 3]> {
        let lines = self.points.chunks_exact(self.degree.v + 1);
        let lines: Vec<_> = lines.map(|l| restrict(l, v[0], v[1])).collect();
        let columns = (0..=self.degree.v).flat_map(|j| {
            let column: Vec<_> = lines.iter().map(|l| l[j]).collect();
            restrict(&column, u[0], u[1])
        });
        hull(&columns.collect::<Vec<_>>(), &self.origin)
    }

    /// How fast the point moves along s and t, in units of length, at most; infinite where nothing is known.
    ///
    /// For a fixed t the patch is a curve in s with the points `Q_i` of its rows and weights between the least and the greatest, so
    /// `|S_s| <= p (max w / min w)^2 max |Q_(i+1) - Q_i|` (M. Floater, *Derivatives of rational Bezier curves*, CAGD 9 (1992)). `Q_i` is an average
    /// of its row, `sum l_j P_ij`, and `Q_(i+1)` one of the next, `sum l'_j P_(i+1,j)`, of the same Bernstein polynomials with other weights:
    /// `l'_j / l_j = r_j / r`, where `r_j = w_(i+1,j) / w_ij` and `r` is an average of these. So `Q_(i+1) - Q_i = sum l'_j (P_(i+1,j) - P_ij) + sum
    /// (l'_j - l_j) P_ij`; in the last sum positive factors are, together, at most 1 and at most `max r_j / min r_j - 1`, and negative ones as much:
    /// it is no longer than that times the row's diameter. Likewise in t.
    pub(crate) fn speeds(&self) -> [f64; 2] {
        const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
        let (mut w_min, mut w_max) = (f64::INFINITY, 0.0f64);
        for p in &self.points {
            w_min = w_min.min(p[3].lower());
            w_max = w_max.max(p[3].upper());
        }
        if !(w_min > 0.0) {
            return [f64::INFINITY; 2];
        }
        let place = |i: usize| {
            let p = &self.points[i];
            [0, 1, 2].map(|c| p[c] / p[3])
        };
        // What is no number is more than any.
        let most = |a: f64, b: f64| if b <= a { a } else { b };
        // Of two lines of points, the first and the next, given by their places.
        let gap = |line: &mut dyn Iterator<Item = (usize, usize)>| {
            let (mut step, mut ratios) = (0.0f64, [f64::INFINITY, 0.0f64]);
            let mut around = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
            for (from, to) in line {
                let (p, q) = (place(from), place(to));
                let squares = (0..3).map(|c| (q[c] - p[c]).magnitude().powi(2));
                step = most(step, squares.sum::<f64>().sqrt() * UP);
                let (w, next) = (&self.points[from][3], &self.points[to][3]);
                ratios[0] = ratios[0].min(next.lower() / w.upper());
                ratios[1] = ratios[1].max(next.upper() / w.lower());
                for (range, x) in around.iter_mut().zip(&p) {
                    *range = [range[0].min(x.lower()), range[1].max(x.upper())];
                }
            }
            let wide = around.map(|[low, high]| (high - low).powi(2));
            let diameter = wide.iter().sum::<f64>().sqrt() * UP;
            let share = (ratios[1] / ratios[0] * UP - 1.0).min(1.0);
            (step + share * diameter) * UP
        };
        let (rows, row) = (self.degree.u + 1, self.degree.v + 1);
        let along_u = (1..rows).map(|i| {
            let (low, high) = ((i - 1) * row, i * row);
            gap(&mut (0..row).map(|j| (low + j, high + j)))
        });
        let along_v = (1..row).map(|j| gap(&mut (0..rows).map(|i| (i * row + j - 1, i * row + j))));
        let ratio = (w_max / w_min).powi(2) * UP;
        let speed = |gap: f64, degree: usize| {
            let speed = ratio * gap * degree as f64 * UP;
            if speed.is_nan() { f64::INFINITY } else { speed }
        };
        [
            speed(along_u.fold(0.0, most), self.degree.u),
            speed(along_v.fold(0.0, most), self.degree.v),
        ]
    }

    /// Moves the zero of `points` (given relative to the zero of space) to the middle of
    /// their box.
    pub(crate) fn centered(degree: Bidegree, mut points: Vec<Homogeneous<T, 4>>) -> Self {
        let mut origin = [0.0; 3];
        for (c, o) in origin.iter_mut().enumerate() {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for p in &points {
                let x = p[c].mid.approximate() / p[3].mid.approximate();
                low = low.min(x);
                high = high.max(x);
            }
            *o = 0.5 * (low + high);
        }
        for p in &mut points {
            for c in 0..3 {
                p[c] = p[c] - p[3] * Ball::exact(origin[c]);
            }
        }
        Self::new(degree, points, origin)
    }

    /// The part over a box, relative to a point `q`. Next to `q` what cancels does so here, on the points: products of what is left are off by parts of themselves,
    /// while products about another place are off by parts of the squared distance from there. (A dimension of a box without width is at 0 or 1.)
    pub(crate) fn about(&self, q: [f64; 3], [u, v]: [[f64; 2]; 2]) -> Self {
        let part = |points: &[Homogeneous<T, 4>], range: [f64; 2]| match points {
            [first, .., last] if range[0] == range[1] => {
                vec![if range[0] == 0.0 { *first } else { *last }]
            }
            _ => part_of(points, range.map(T::from_f64)),
        };
        let rows = self.points.chunks_exact(self.degree.v + 1);
        let rows: Vec<_> = rows.map(|row| part(row, v)).collect();
        let columns: Vec<_> = (0..rows[0].len())
            .map(|j| part(&rows.iter().map(|r| r[j]).collect::<Vec<_>>(), u))
            .collect();
        let degree = Bidegree {
            u: columns[0].len() - 1,
            v: columns.len() - 1,
        };
        let away: [Ball<T>; 3] = std::array::from_fn(|c| Ball::difference(q[c], self.origin[c]));
        let points = (0..=degree.u).flat_map(|i| columns.iter().map(move |column| column[i]));
        let points = points.map(|p| {
            // Averages of 1 are 1.
            let w = if self.unit_weights { Ball::ONE } else { p[3] };
            let at = |c: usize| match self.unit_weights {
                true => p[c] - away[c],
                false => p[c] - away[c] * w,
            };
            [at(0), at(1), at(2), w]
        });
        Self::new(degree, points.collect(), q)
    }

    /// Bytes of its lists, as large as they were reserved.
    pub(super) fn bytes(&self) -> usize {
        self.points.capacity() * size_of::<Homogeneous<T, 4>>()
            + self.plain.get().map_or(0, |p| size_of_val(&**p))
    }

    /// The homogeneous point and first derivatives (relative to the origin) at local `(s, t)`,
    /// by de Casteljau; derivatives are with respect to the local parameters.
    pub(crate) fn jet(&self, s: Ball<T>, t: Ball<T>) -> Jet<T> {
        let lines: Vec<_> = self
            .points
            .chunks_exact(self.degree.v + 1)
            .map(|r| curve_jet(r, t))
            .collect();
        let values: Vec<_> = lines.iter().map(|l| l.0).collect();
        let slopes: Vec<_> = lines.iter().map(|l| l.1).collect();
        let (value, along_s) = curve_jet(&values, s);
        let (along_t, _) = curve_jet(&slopes, s);
        Jet {
            value,
            s: along_s,
            t: along_t,
        }
    }
}

/// The control points over `[from, to]` of a curve over `[0, 1]`: of what is up to its end that beyond its start, by de Casteljau twice. (Pieces that are kept are
/// made by blossoms, which take more by the degree and have fewer roundings.)
pub(crate) fn part_of<T: Real, const H: usize>(
    points: &[Homogeneous<T, H>],
    [from, to]: [T; 2],
) -> Vec<Homogeneous<T, H>> {
    let known = |mid: T| Ball { mid, rad: 0.0 };
    let mut d = points.to_vec();
    let n = d.len();
    // An average: the other form, a + t (b - a), would treble radii at each step.
    let blend = |a: &Homogeneous<T, H>, b: &Homogeneous<T, H>, t: Ball<T>| {
        let rest = Ball::ONE - t;
        std::array::from_fn(|c| rest * a[c] + t * b[c])
    };
    if to != T::ONE {
        // Level by level; each leaves its first point in place.
        for k in 1..n {
            for i in (k..n).rev() {
                d[i] = blend(&d[i - 1], &d[i], known(to));
            }
        }
    }
    if from != T::ZERO {
        let t = if to == T::ONE {
            known(from)
        } else {
            known(from) / known(to)
        };
        // Each leaves its last.
        for k in 1..n {
            for i in 0..n - k {
                d[i] = blend(&d[i], &d[i + 1], t);
            }
        }
    }
    d
}

/// The control points of both halves of a curve over `[0, 1]`.
pub(crate) fn halves_of<T: Real, const H: usize>(
    points: &[Homogeneous<T, H>],
) -> [Vec<Homogeneous<T, H>>; 2] {
    let (mut low, mut high) = (points.to_vec(), points.to_vec());
    let n = points.len();
    for k in 1..n {
        for i in 0..n - k {
            high[i] = std::array::from_fn(|c| (high[i][c] + high[i + 1][c]).half());
        }
        low[k] = high[0];
    }
    [low, high]
}

/// A homogeneous point and its derivatives along s and t.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jet<T> {
    pub(crate) value: Homogeneous<T, 4>,
    pub(crate) s: Homogeneous<T, 4>,
    pub(crate) t: Homogeneous<T, 4>,
}

/// So many points take de Casteljau's triangle, which has fewer roundings; of more the time would go with their square.
const MOST_SHORT: usize = 8;
/// Of so many points all binomials, and what they are made of, are integers below 2^53; those of more are rounded.
const MOST_BINOMIAL: usize = 50;

/// Point and derivative of a homogeneous Bezier curve at `t`.
pub(crate) fn curve_jet<T: Real, const H: usize>(
    points: &[Homogeneous<T, H>],
    t: Ball<T>,
) -> (Homogeneous<T, H>, Homogeneous<T, H>) {
    let n = points.len();
    if n < 2 {
        return (points[0], [Ball::ZERO; H]);
    }
    let s = Ball::ONE - t;
    let mut short = [[Ball::ZERO; H]; MOST_SHORT];
    // The last two of the triangle: the points of the curves without the last and the first control point.
    let [low, high] = match short.get_mut(..n) {
        Some(d) => {
            d.copy_from_slice(points);
            triangle(d, [s, t])
        }
        None => pair_of_points(points, [s, t]),
    };
    let degree = Ball::exact((n - 1) as f64);
    (
        std::array::from_fn(|c| s * low[c] + t * high[c]),
        std::array::from_fn(|c| degree * (high[c] - low[c])),
    )
}

fn triangle<T: Real, const H: usize>(
    d: &mut [Homogeneous<T, H>],
    [s, t]: [Ball<T>; 2],
) -> [Homogeneous<T, H>; 2] {
    for k in (2..d.len()).rev() {
        for i in 0..k {
            for c in 0..H {
                d[i][c] = s * d[i][c] + t * d[i + 1][c];
            }
        }
    }
    [d[0], d[1]]
}

/// The points at `t` of the curves of all control points but the last, and but the first: `sum binomial(m, i) t^i s^(m - i) p_i` with running powers, in as many steps as
/// there are points.
fn pair_of_points<T: Real, const H: usize>(
    points: &[Homogeneous<T, H>],
    [s, t]: [Ball<T>; 2],
) -> [Homogeneous<T, H>; 2] {
    let degree = points.len() - 2;
    let [mut low, mut high] = [points[0], points[1]];
    let is_exact = points.len() <= MOST_BINOMIAL;
    let (mut power, mut binomial, mut rounded) = (Ball::ONE, 1.0, Ball::ONE);
    for i in 1..=degree {
        power = power * t;
        let [rest, i_th] = [degree + 1 - i, i].map(|x| x as f64);
        let factor = if is_exact {
            binomial = binomial * rest / i_th;
            power * Ball::exact(binomial)
        } else {
            rounded = rounded * Ball::exact(rest) / Ball::exact(i_th);
            power * rounded
        };
        for c in 0..H {
            low[c] = low[c] * s + factor * points[i][c];
            high[c] = high[c] * s + factor * points[i + 1][c];
        }
    }
    [low, high]
}

/// A box that holds what homogeneous control points relative to an origin make; `None` where a weight is not proven to be positive.
pub(super) fn hull<T: Real>(
    points: &[Homogeneous<T, 4>],
    origin: &[f64; 3],
) -> Option<[[f64; 2]; 3]> {
    let mut out = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for p in points {
        if !p[3].is_above(0.0) {
            return None;
        }
        for (c, range) in out.iter_mut().enumerate() {
            let x = p[c] / p[3] + Ball::exact(origin[c]);
            let (low, high) = (x.lower(), x.upper());
            if !(low.is_finite() && high.is_finite()) {
                return None;
            }
            *range = [range[0].min(low), range[1].max(high)];
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Dd;
    use dashu_ratio::RBig as Q;

    /// In rationals: what is found of curves of all degrees holds the exact point and derivative, and is known to nearly all digits.
    #[test]
    fn points_and_derivatives_of_any_degree() {
        let q = |x: f64| Q::try_from(x).expect("a number");
        let mut seed = 7u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 40) as f64 / (1u64 << 23) as f64 - 1.0
        };
        for degree in [1, 7, 8, 12, 25, 48, 49, 50, 60, 120, 192] {
            let values: Vec<f64> = (0..=degree).map(|_| random()).collect();
            let points: Vec<[Ball<Dd>; 1]> = values.iter().map(|x| [Ball::exact(*x)]).collect();
            for t in [0.0, 1e-20, 0.3, 0.5, 0.9375, 1.0] {
                let (value, slope) = curve_jet(&points, Ball::exact(t));
                let (t, one) = (q(t), Q::ONE);
                let mut rows: Vec<Q> = values.iter().map(|x| q(*x)).collect();
                while rows.len() > 2 {
                    let between = |p: &[Q]| &p[0] * (&one - &t) + &p[1] * &t;
                    rows = rows.windows(2).map(between).collect();
                }
                let exact = [
                    &rows[0] * (&one - &t) + &rows[1] * &t,
                    (&rows[1] - &rows[0]) * Q::from(degree),
                ];
                for (found, exact) in [value[0], slope[0]].iter().zip(exact) {
                    let off = q(found.mid.hi) + q(found.mid.lo) - exact;
                    let off = if off < Q::ZERO { -off } else { off };
                    assert!(off <= q(found.rad), "{degree}: {found:?}");
                    // Some units for each level, of values up to 1 and slopes up to twice the degree.
                    let most = 64.0 * (degree * degree) as f64 * Dd::UNIT;
                    assert!(found.rad <= most, "{degree}: {found:?}");
                }
            }
        }
    }

    /// Weights that are no products: at (0, 1/2) rows of one length are averaged unlike, and the point moves along them.
    #[test]
    fn speeds_hold_where_weights_are_no_products() {
        for e in [0.1, 0.001] {
            let weighted = |x: f64, y: f64, w: f64| [x * w, y * w, 0.0, w].map(Ball::exact);
            let points = vec![
                weighted(0.0, 0.0, 1.0),
                weighted(0.0, 10.0, 1.0),
                weighted(e, 0.0, 1.0),
                weighted(e, 10.0, 2.0),
            ];
            let net = Net::<f64>::new(Bidegree { u: 1, v: 1 }, points, [0.0; 3]);
            // w = 1 and w_s = (0 + 1) / 2 there, y w = 5 and (y w)_s = (0 + 10) / 2: y_s = 5 - 5 / 2.
            assert!(net.speeds()[0] >= 2.5, "{:?}", net.speeds());
        }
    }

    /// In rationals, by blossoms: a part relative to a point next to it holds the exact points, and is known to digits of the patch's size at most, so that squares of distances of
    /// `d` are known to digits of `d` times that.
    #[test]
    fn parts_about_a_point() {
        let q = |x: f64| Q::try_from(x).expect("a number");
        let exact = |x: Dd| q(x.hi) + q(x.lo);
        let degree = Bidegree { u: 2, v: 1 };
        let apex = [3.0, 4.0, 12.0];
        for weights in [[1.0; 6], [1.0, 0.75, 0.5, 0.3, 1.0, 1e-3]] {
            let places = [
                [0.0, 0.0, 0.0],
                apex,
                [1.0, 0.1, 0.2],
                apex,
                [2.0, 0.7, 0.3],
                apex,
            ];
            let points: Vec<[f64; 4]> = places
                .iter()
                .zip(weights)
                .map(|(p, w)| [p[0] * w, p[1] * w, p[2] * w, w])
                .collect();
            let net = Net::<Dd>::new(
                degree,
                points.iter().map(|p| p.map(Ball::exact)).collect(),
                [0.5, 0.25, -1.0],
            );
            let center = [3.5, 4.25, 11.0 + 1e-9];
            let end = 1.0 - 1.0 / (1u64 << 40) as f64;
            for [u, v] in [
                [[0.25, 0.5], [end, 1.0]],
                [[0.0, 1.0], [1.0, 1.0]],
                [[0.0, 0.0], [0.75, 1.0]],
                [[0.5, 1.0], [0.0, 1.0]],
            ] {
                let about = net.about(center, [u, v]);
                let count = |r: [f64; 2], d: usize| if r[0] == r[1] { 0 } else { d };
                let of = Bidegree {
                    u: count(u, 2),
                    v: count(v, 1),
                };
                assert_eq!((about.degree, about.origin), (of, center));
                assert_eq!(about.unit_weights, weights == [1.0; 6]);
                let blend = |t: f64, a: &Q, b: &Q| a * (Q::ONE - q(t)) + b * q(t);
                for (k, found) in about.points.iter().enumerate() {
                    let (i, j) = (k / (of.v + 1), k % (of.v + 1));
                    // Of a blossom's arguments i are the end, the others the start.
                    let at_u = if i == 2 {
                        [u[1]; 2]
                    } else if i == 1 {
                        [u[0], u[1]]
                    } else {
                        [u[0]; 2]
                    };
                    let at_v = v[j];
                    for c in 0..4 {
                        let value = |m: usize| {
                            q(points[m][c])
                                - if c < 3 {
                                    (q(center[c]) - q(net.origin[c])) * q(points[m][3])
                                } else {
                                    Q::ZERO
                                }
                        };
                        let row = |m: usize| blend(at_v, &value(2 * m), &value(2 * m + 1));
                        let first = [
                            blend(at_u[0], &row(0), &row(1)),
                            blend(at_u[0], &row(1), &row(2)),
                        ];
                        let truth = blend(at_u[1], &first[0], &first[1]);
                        let off = exact(found[c].mid) - truth;
                        let off = if off < Q::ZERO { -off } else { off };
                        assert!(off <= q(found[c].rad), "{u:?} {v:?} {k} {c}");
                        assert!(found[c].rad <= 512.0 * Dd::UNIT, "{:?}", found[c]);
                    }
                }
            }
        }
    }
}
