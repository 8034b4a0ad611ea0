//! Functions on a patch as quotients of polynomials.

use super::net::Coefficients;
use super::{Net, Products};
use crate::numeric::bernstein::{Bidegree, lesser};
use crate::numeric::{Ball, Dd, Real};
use nalgebra::Point3;

/// The bound on a sum of a few parts is itself rounded a few times.
const BOUND_UP: f64 = 1.0 + 32.0 * f64::EPSILON;

/// `f = N / C` on a patch or piece: coefficients, and bounds on the errors of those of each, in parts of the true ones of `C`
/// (see [`Coefficients`](super::net::Coefficients)).
#[derive(Clone, Debug)]
pub(crate) struct Quotient<T> {
    pub(crate) degree: Bidegree,
    pub(crate) n: Vec<T>,
    /// Empty where `C` is 1, exactly.
    pub(crate) c: Vec<T>,
    pub(crate) n_error: f64,
    pub(crate) c_error: f64,
    /// What an operation that underflows may lose, likewise.
    pub(crate) tiny: f64,
}

impl<T: Real> Quotient<T> {
    /// Whether all coefficients of `C` are proven to be positive.
    pub(crate) fn is_proper(&self) -> bool {
        // An error is no number, or infinite, where a weight may not be positive.
        self.c_error <= MOST_OFF && self.n_error.is_finite()
    }
}

/// `C` known worse than this is not known at all.
pub(super) const MOST_OFF: f64 = 1.0 / (1u64 << 10) as f64;

impl Quotient<Dd> {
    /// Bounds on `f` by the convex hull of its coefficients' quotients; `None` where a denominator may not be positive.
    pub(crate) fn range(&self) -> Option<[f64; 2]> {
        if !self.is_proper() {
            return None;
        }
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (i, n) in self.n.iter().enumerate() {
            let n = Ball { mid: *n, rad: 0.0 };
            let q = match self.c.get(i) {
                Some(c) => n / Ball { mid: *c, rad: 0.0 },
                None => n,
            };
            // The true `C` makes of `q` at most this much more or less; the true `N` adds its error.
            let off = self.n_error + 2.0 * self.c_error * q.magnitude();
            let q = q + Ball {
                mid: Dd::ZERO,
                rad: off,
            };
            // Fourth powers may leave the range of f64: what is no number bounds nothing.
            if !(q.lower() <= q.upper()) {
                return None;
            }
            low = low.min(q.lower());
            high = high.max(q.upper());
        }
        (low.is_finite() && high.is_finite()).then_some([low, high])
    }
}

impl<T: Real> Quotient<T> {
    /// Nothing yet: lists to be filled.
    pub(crate) const BLANK: Self = Self {
        degree: Bidegree { u: 0, v: 0 },
        n: Vec::new(),
        c: Vec::new(),
        n_error: 0.0,
        c_error: 0.0,
        tiny: 0.0,
    };

    /// `|S - q|^2` on a net, from its products.
    pub(crate) fn squared_distance(q: &Point3<f64>, net: &Net<T>, products: &Products<T>) -> Self {
        Self::BLANK.made_squared_distance(q, net, products)
    }

    /// The same in the lists of another, whatever they hold.
    pub(crate) fn made_squared_distance(
        self,
        q: &Point3<f64>,
        net: &Net<T>,
        products: &Products<T>,
    ) -> Self {
        let Self { mut n, mut c, .. } = self;
        n.clear();
        c.clear();
        let Arm { q, q2, n_error } = Arm::new(q, net, products);
        let two = T::from_f64(2.0);
        let [bx, by, bz] = &products.b;
        let triples = bx.values.iter().zip(&by.values).zip(&bz.values);
        let parts = products.a.values.iter().zip(triples);
        let less = parts.map(|(a, ((x, y), z))| {
            let cross = q[0].mid * *x + q[1].mid * *y + q[2].mid * *z;
            *a - two * cross
        });
        if net.unit_weights {
            n.extend(less.map(|x| x + q2.mid));
        } else {
            let squares = &products.c.values;
            n.extend(less.zip(squares).map(|(x, c)| x + q2.mid * *c));
            c.extend_from_slice(squares);
        }
        Self {
            degree: products.degree,
            n,
            n_error,
            c,
            c_error: if net.unit_weights {
                0.0
            } else {
                products.c.error
            },
            tiny: products.c.tiny,
        }
    }
}

/// A centre, relative to a net's origin.
struct Arm<T> {
    q: [Ball<T>; 3],
    q2: Ball<T>,
    /// What the coefficients of `N` about it are off.
    n_error: f64,
}

impl<T: Real> Arm<T> {
    fn new(q: &Point3<f64>, net: &Net<T>, products: &Products<T>) -> Self {
        let q: [Ball<T>; 3] = std::array::from_fn(|c| Ball::difference(q[c], net.origin[c]));
        let q2 = q[0].square() + q[1].square() + q[2].square();
        let Products { a, b, c, .. } = products;
        let [n_error, _] = sum_bounds((&q, &q2), a, b, c);
        Self { q, q2, n_error }
    }
}

/// What a sum or difference of `a`, `2 q.b` and `|q|^2 c` may be off, and how large its parts are together, given `q` and `|q|^2`: each coefficient inherits what its parts are off, and
/// takes at most eight roundings of parts no larger than the sum of the parts' largest.
pub(super) fn sum_bounds<T: Real>(
    (q, q2): (&[Ball<T>; 3], &Ball<T>),
    a: &Coefficients<T>,
    b: &[Coefficients<T>; 3],
    c: &Coefficients<T>,
) -> [f64; 2] {
    let most = q2.magnitude();
    let mut size = a.largest + most * c.largest;
    let mut error = a.error + most * c.error + q2.rad * c.largest;
    for (q, b) in q.iter().zip(b) {
        let most = q.magnitude();
        size += 2.0 * most * b.largest;
        error += 2.0 * (most * b.error + q.rad * b.largest);
    }
    let error = (error + 8.0 * (T::UNIT * size + c.tiny)) * BOUND_UP;
    [error, size]
}

/// A lower bound of `|S - q|^2` on a net whose weights are 1, by the coefficients that [`Quotient::squared_distance`] has, without keeping them.
///
/// `f` is a convex combination of its coefficients, thus at least the least of the true ones, which is no less than the least computed one less `n_error`. (These
/// are computed as there: doubling is exact, and as rounding is monotone what all have in common is added to the least.) Of the last subtractions one rounding is of the least,
/// four times counted, and one of `n_error`, for which [`BOUND_UP`] has room.
pub(crate) fn least_squared_distance(
    q: &Point3<f64>,
    net: &Net<f64>,
    products: &Products<f64>,
) -> f64 {
    const LANES: usize = 4;
    let Arm { q, q2, n_error } = Arm::new(q, net, products);
    let [x, y, z] = q.map(|q| 2.0 * q.mid);
    let at = |a: f64, b: [f64; 3]| a - (x * b[0] + y * b[1] + z * b[2]);
    let [bx, by, bz] = products.b.each_ref().map(|b| b.values.as_chunks::<LANES>());
    let (a, rest) = products.a.values.as_chunks::<LANES>();
    // In lanes, so that they are taken at once.
    let mut low = [f64::INFINITY; LANES];
    for (a, ((bx, by), bz)) in a.iter().zip(bx.0.iter().zip(by.0).zip(bz.0)) {
        for k in 0..LANES {
            low[k] = lesser(low[k], at(a[k], [bx[k], by[k], bz[k]]));
        }
    }
    let mut least = low.into_iter().fold(f64::INFINITY, lesser);
    for (a, ((bx, by), bz)) in rest.iter().zip(bx.1.iter().zip(by.1).zip(bz.1)) {
        least = lesser(least, at(*a, [*bx, *by, *bz]));
    }
    let least = least + q2.mid;
    // What is subtracted, and the rounding of that.
    (least - n_error - 4.0 * f64::EPSILON * least.abs()).max(0.0)
}
