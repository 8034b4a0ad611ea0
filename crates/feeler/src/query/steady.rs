//! What is proven of a box about one centre, kept for centres nearby.
//!
//! # What is proven
//! With `S = X / w` on a box, `G = N - tau C` for a centre `q` has `N = |X - q w|^2` and `C = w^2`. For another centre `c = q + d`
//! and another `tau'`, with `b' = X w - q w^2`,
//! ```text
//! G' = G - 2 d.b' + (|d|^2 - (tau' - tau)) C,
//! ```
//! for `|X - c w|^2 = |X - q w|^2 - 2 d.(X - q w) w + |d|^2 w^2`. All of these are polynomials of the same degrees, so differences of the
//! coefficients of `G'` are those of `G` up to the same combination of differences of the coefficients of `b'` and `C`: of these the ranges
//! are kept (a [`Sway`]). What [`Bends`] say of the box about `q` is moved and widened by that, and these ranges hold the true
//! coefficients about `c` (a box that the ball moves away from falls the more steeply the farther that is): what they tell ([`Bends::monotone`], [`Bends::bent`]) is proven of `c`, in time that hangs on no degree.

use super::node::Node;
use super::shape::{Bends, Shape};
use crate::numeric::bernstein::{Bidegree, greater, largest, lesser};
use crate::numeric::{Ball, Real, TINY};
use crate::prepare::{Net, Products};
use nalgebra::Point3;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;

/// What is asked of a box about other centres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Asked {
    /// Whether `f` falls along u (0) or v (1).
    Slope(usize),
    /// The second derivatives of `G`.
    Seconds,
}

/// Bounds on the coefficients of a polynomial, and ranges of those of their differences that are asked for, in the order of [`Bends`].
#[derive(Clone, Copy, Debug, Default)]
struct Sway {
    largest: f64,
    slope: [f64; 2],
    seconds: [[f64; 2]; 3],
}

/// See the [module](self).
#[derive(Clone, Debug)]
pub(super) struct Steady {
    center: Point3<f64>,
    tau: f64,
    asked: Asked,
    bends: Bends,
    /// Of the coordinates of `b'`.
    arms: [Sway; 3],
    /// Of `C`.
    base: Sway,
}

impl Sway {
    /// Of coefficients none of which is above `top` and that are off by `error` each.
    fn of(asked: Asked, values: &[f64], degree: Bidegree, [top, error]: [f64; 2]) -> Self {
        // The errors of the coefficients, and the roundings of differences of differences.
        let range = |(low, high): (f64, f64), count: f64| {
            outward([low, high], (count * error + 8.0 * f64::UNIT * top) * UP)
        };
        let mut out = Self {
            largest: (top + error) * UP,
            ..Self::default()
        };
        match asked {
            Asked::Slope(k) => {
                let degree_along = if k == 0 { degree.u } else { degree.v };
                if degree_along > 0 {
                    out.slope = range(Node::<f64>::differences(values, degree, k == 0), 2.0);
                }
            }
            Asked::Seconds => {
                for (second, (du, dv)) in out.seconds.iter_mut().zip([(2, 0), (0, 2), (1, 1)]) {
                    let found = Node::<f64>::second_differences(values, degree, du, dv);
                    *second = range(found, 4.0);
                }
            }
        }
        out
    }
}

/// Of `b'` about a centre, where no coefficient of `C` is above `most`.
fn weighted_arm(
    asked: Asked,
    (net, products): (&Net<f64>, &Products<f64>),
    (center, k): (&Point3<f64>, usize),
    most: f64,
) -> Sway {
    let q = Ball::<f64>::difference(center[k], net.origin[k]);
    let (b, c) = (&products.b[k], &products.c);
    let values: Vec<f64> = b
        .values
        .iter()
        .zip(&c.values)
        .map(|(b, c)| b - q.mid * c)
        .collect();
    let size = b.largest + q.magnitude() * c.largest;
    let error =
        b.error + q.magnitude() * c.error + q.rad * c.largest + 4.0 * (f64::UNIT * size + c.tiny);
    let top = largest(&values);
    Sway::of(asked, &values, products.degree, [top, error * most * UP])
}

/// A range, wider by so much at both ends: the sums are off by half an epsilon of their terms at most.
#[inline(always)]
fn outward([low, high]: [f64; 2], e: f64) -> [f64; 2] {
    let own = |x: f64| (e + f64::EPSILON * x.abs()) * UP;
    [low - own(low), high + own(high)]
}

impl Steady {
    /// Of a node with its net and products, and what its derivatives are bounded by with some tau; and what was kept of the same box about another centre, if anything
    /// was.
    pub(super) fn new(
        asked: Asked,
        node: &Node<f64>,
        (net, products): (&Net<f64>, &Products<f64>),
        center: &Point3<f64>,
        (tau, bends): (f64, Bends),
        before: Option<&Self>,
    ) -> Self {
        let most = bends.c_range[1];
        if let Some(before) = before
            && net.unit_weights
            && before.asked == asked
        {
            // `b' = b - q`, and `C` is 1.
            return Self {
                center: *center,
                tau,
                bends,
                ..*before
            };
        }
        let arm = |k: usize| {
            if net.unit_weights {
                // `b' = b - q`: its differences are those of `b`, whatever the centre is.
                let b = &products.b[k];
                Sway::of(asked, &b.values, products.degree, [b.largest, b.error])
            } else {
                weighted_arm(asked, (net, products), (center, k), most)
            }
        };
        let base = if bends.constant {
            Sway::default()
        } else {
            let error = node.f.c_error * most * UP;
            Sway::of(
                asked,
                &node.f.c,
                products.degree,
                [largest(&node.f.c), error],
            )
        };
        Self {
            center: *center,
            tau,
            asked,
            bends,
            arms: [arm(0), arm(1), arm(2)],
            base,
        }
    }

    pub(super) fn asked(&self) -> Asked {
        self.asked
    }

    pub(super) fn degree(&self) -> Bidegree {
        self.bends.degree
    }

    /// About what the Hessian of `G` is (`_uu`, `_uv`, `_vv`), in coordinates that run over the box from 0 to 1. No proof rests on it.
    pub(super) fn bend(&self) -> [f64; 3] {
        let Bends {
            degree, seconds, ..
        } = &self.bends;
        let (p, q) = (degree.u as f64, degree.v as f64);
        let mid = |m: usize| 0.5 * (seconds[m][0] + seconds[m][1]);
        [
            p * (p - 1.0) * mid(0),
            p * q * mid(2),
            q * (q - 1.0) * mid(1),
        ]
    }

    /// Whether `C` is 1, exactly.
    pub(super) fn is_polynomial(&self) -> bool {
        self.bends.constant
    }

    /// Whether `f` is proven to fall one way along u (or v), as is asked, about another centre and another tau: given by the sign of its derivative.
    pub(super) fn falls(&self, sign: i8, center: &Point3<f64>, tau: f64) -> bool {
        let Asked::Slope(along) = self.asked else {
            return false;
        };
        let way = self.way(center, tau);
        let range = self.slopes(&way, along);
        self.bends.monotone(along, range, self.largest(&way)) == sign
    }

    /// What is proven about the second derivatives of `G`, where these are asked for, about another centre and another tau. (Nobody asks of what is kept whether
    /// `G` is noise.)
    pub(super) fn shape(&self, center: &Point3<f64>, tau: f64) -> Option<Shape> {
        if self.asked != Asked::Seconds {
            return None;
        }
        let way = self.way(center, tau);
        // Written out, here and below: `map` is not inlined.
        let seconds = [
            self.seconds(&way, 0),
            self.seconds(&way, 1),
            self.seconds(&way, 2),
        ];
        Some(self.bends.bent(&seconds, [0; 2], f64::INFINITY))
    }

    /// How far it is to another centre along each axis, and by how much `G` changes in parts of `C`.
    fn way(&self, center: &Point3<f64>, tau: f64) -> ([f64; 3], f64) {
        let d: [f64; 3] = std::array::from_fn(|k| center[k] - self.center[k]);
        let square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        let fall = tau - self.tau;
        let lift = (square - fall).abs() + 8.0 * f64::EPSILON * (square + fall.abs()) + TINY;
        (d, lift)
    }

    /// Where a range of differences is about another centre. Each of the three products and their sums are off by a few roundings of the largest.
    #[inline(always)]
    fn moved(
        &self,
        (d, lift): &([f64; 3], f64),
        [low, high]: [f64; 2],
        of: impl Fn(&Sway) -> [f64; 2],
    ) -> [f64; 2] {
        let (mut sum, mut size) = ([low, high], 0.0);
        for (d, arm) in d.iter().zip(&self.arms) {
            let ends = of(arm);
            let [a, b] = [-2.0 * d * ends[0], -2.0 * d * ends[1]];
            sum[0] += lesser(a, b);
            sum[1] += greater(a, b);
            size += greater(a.abs(), b.abs());
        }
        let base = of(&self.base);
        let base = greater(base[0].abs(), base[1].abs());
        let size = size + greater(low.abs(), high.abs());
        outward(sum, lift * base + 8.0 * f64::EPSILON * size + TINY)
    }

    #[inline(always)]
    fn slopes(&self, way: &([f64; 3], f64), k: usize) -> [f64; 2] {
        self.moved(way, self.bends.slopes[k], |s| s.slope)
    }

    #[inline(always)]
    fn seconds(&self, way: &([f64; 3], f64), m: usize) -> [f64; 2] {
        self.moved(way, self.bends.seconds[m], |s| s.seconds[m])
    }

    /// No coefficient of `G` is larger, where `C` is not 1: else nothing is multiplied by it.
    #[inline(always)]
    fn largest(&self, (d, lift): &([f64; 3], f64)) -> f64 {
        if self.bends.constant {
            return 0.0;
        }
        let arms = d
            .iter()
            .zip(&self.arms)
            .map(|(d, arm)| d.abs() * arm.largest);
        let off = 2.0 * arms.sum::<f64>() + lift * self.base.largest + TINY;
        (self.bends.g_largest + off * UP) * UP
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Dd;
    use crate::prepare::Quotient;
    use proptest::prelude::*;

    const DEGREE: Bidegree = Bidegree { u: 2, v: 1 };

    fn net<T: Real>(points: &[[f64; 4]]) -> Net<T> {
        let points = points.iter().map(|p| p.map(Ball::exact)).collect();
        Net::new(DEGREE, points, [0.5, -0.25, 1.0])
    }

    fn node<T: Real>(net: &Net<T>, products: &Products<T>, q: &Point3<f64>) -> Node<T> {
        let f = Quotient::squared_distance(q, net, products);
        Node::over(f, [0.0, 0.5], [0.5, 1.0], true)
    }

    fn cut<T: Real>(net: &Net<T>) -> Products<T> {
        let products = net.products();
        products.restricted([0.0, 0.5], [0.5, 1.0]).expect("a half")
    }

    /// The differences in double-double of `G` about `c` that the ranges must hold; their own errors are far below the rounding that the
    /// ranges allow for.
    fn check(points: &[[f64; 4]], [q, c]: [[f64; 3]; 2], [tau, other]: [f64; 2]) {
        let (q, c) = (Point3::from(q), Point3::from(c));
        let rough = net::<f64>(points);
        let products = cut(&rough);
        let about_q = node(&rough, &products, &q);
        let first = (tau, about_q.bends(tau));
        let asked = |asked| Steady::new(asked, &about_q, (&rough, &products), &q, first, None);
        let steady = [Asked::Slope(0), Asked::Slope(1), Asked::Seconds].map(asked);
        let way = steady[2].way(&c, other);
        let slopes = [0, 1].map(|k| steady[k].slopes(&way, k));
        let seconds = [0, 1, 2].map(|m| steady[2].seconds(&way, m));
        let largest = steady[0].largest(&way);
        let constant = steady[0].is_polynomial();
        let fine = net::<Dd>(points);
        let about_c = node(&fine, &cut(&fine), &c);
        let g: Vec<Dd> = (0..about_c.f.n.len())
            .map(|i| {
                let c = about_c.f.c.get(i).copied().unwrap_or(Dd::ONE);
                about_c.f.n[i] - Dd::from(other) * c
            })
            .collect();
        let holds = |range: [f64; 2], x: Dd| Dd::from(range[0]) <= x && x <= Dd::from(range[1]);
        let (rows, width) = (2 * DEGREE.u + 1, 2 * DEGREE.v + 1);
        let at = |i: usize, j: usize| g[i * width + j];
        for i in 0..rows {
            for j in 0..width {
                assert!(constant || at(i, j).magnitude() <= largest);
                if i + 1 < rows {
                    assert!(holds(slopes[0], at(i + 1, j) - at(i, j)));
                }
                if j + 1 < width {
                    assert!(holds(slopes[1], at(i, j + 1) - at(i, j)));
                }
                if i + 2 < rows {
                    let second = (at(i + 2, j) - at(i + 1, j)) - (at(i + 1, j) - at(i, j));
                    assert!(holds(seconds[0], second));
                }
                if j + 2 < width {
                    let second = (at(i, j + 2) - at(i, j + 1)) - (at(i, j + 1) - at(i, j));
                    assert!(holds(seconds[1], second));
                }
                if i + 1 < rows && j + 1 < width {
                    let mixed = (at(i + 1, j + 1) - at(i, j + 1)) - (at(i + 1, j) - at(i, j));
                    assert!(holds(seconds[2], mixed));
                }
            }
        }
    }

    /// A flat patch, next to which the ball is: the farther it goes away the more surely the distance grows along u; over the patch it does not.
    #[test]
    fn a_box_left_behind_falls_however_far_the_ball_has_gone() {
        let points: Vec<[f64; 4]> = (0..6)
            .map(|k| [0.5 * f64::from(k / 2), f64::from(k % 2), 0.0, 1.0])
            .collect();
        let rough = net::<f64>(&points);
        let products = cut(&rough);
        let [x, y, z] = rough.origin;
        let q = Point3::new(x - 1.0, y + 0.5, z + 1.0);
        let about_q = node(&rough, &products, &q);
        let given = (&rough, &products);
        let steady = Steady::new(
            Asked::Slope(0),
            &about_q,
            given,
            &q,
            (2.0, about_q.bends(2.0)),
            None,
        );
        for (off, falls) in [
            (0.0, true),
            (-1e3, true),
            (-1e9, true),
            (0.9, true),
            (1.1, false),
            (2.0, false),
        ] {
            let c = Point3::new(q.x + off, q.y, q.z);
            assert_eq!(steady.falls(1, &c, 2.0), falls, "{off}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn what_is_kept_holds_about_other_centres(
            points in prop::collection::vec(([-4.0..4.0f64, -4.0..4.0f64, -4.0..4.0f64], -3i32..=3), 6),
            polynomial in any::<bool>(),
            q in [-4.0..4.0f64, -4.0..4.0f64, -4.0..4.0f64],
            way in [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64],
            step in 0..40i32,
            tau in [-4.0..16.0f64, -4.0..16.0f64],
        ) {
            let points: Vec<[f64; 4]> = points
                .iter()
                .map(|(p, e)| {
                    let w = if polynomial { 1.0 } else { 2f64.powi(*e) };
                    [p[0] * w, p[1] * w, p[2] * w, w]
                })
                .collect();
            let c = std::array::from_fn(|k| q[k] + way[k] * 0.5f64.powi(step));
            check(&points, [q, c], tau);
            check(&points, [q, c], [tau[0]; 2]);
        }
    }
}
