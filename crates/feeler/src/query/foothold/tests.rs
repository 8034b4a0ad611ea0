//! Bounds from footholds, against exact values all over the box.

use super::*;
use crate::numeric::bernstein::Bidegree;
use crate::prepare::Quotient;
use crate::query::node::Node;
use dashu_ratio::RBig as Q;
use proptest::prelude::*;

const DEGREE: Bidegree = Bidegree { u: 2, v: 2 };

fn exact(x: f64) -> Q {
    Q::try_from(x).expect("a number")
}

/// The squared distance of the point of a net at local parameters that are multiples of 1/8.
fn squared(points: &[[f64; 4]], origin: [f64; 3], center: [f64; 3], at: [u8; 2]) -> Q {
    let basis = |t: u8| {
        let t = Q::from(t) / Q::from(8);
        let s = Q::ONE - &t;
        [&s * &s, Q::from(2) * &s * &t, &t * &t]
    };
    let (bu, bv) = (basis(at[0]), basis(at[1]));
    let mut x = [Q::ZERO, Q::ZERO, Q::ZERO, Q::ZERO];
    for (i, p) in points.iter().enumerate() {
        let b = &bu[i / 3] * &bv[i % 3];
        for k in 0..4 {
            x[k] += &b * exact(p[k]);
        }
    }
    (0..3).fold(Q::ZERO, |sum, k| {
        let d = &x[k] / &x[3] + exact(origin[k]) - exact(center[k]);
        sum + &d * &d
    })
}

/// A shallow bowl over the unit square; weights have a dent of some depth along u and v.
fn points(heights: &[f64], dent: f64, scale: f64) -> Vec<[f64; 4]> {
    let at = |k: usize| {
        let (i, j) = (k / 3, k % 3);
        let along = |i: usize| if i == 1 { dent } else { 1.0 };
        let w = scale * along(i) * along(j);
        let (x, y) = (0.5 * i as f64, 0.5 * j as f64);
        [x * w, y * w, heights[k] * w, w]
    };
    (0..9).map(at).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1024, failure_persistence: None, ..ProptestConfig::default() })]

    /// Nowhere on the box is the surface nearer than is told, wherever the foothold is on it; and at the least place the bound is not far below.
    #[test]
    fn nothing_is_nearer_than_is_told(
        heights in prop::collection::vec(-0.2..0.2f64, 9),
        dent in prop::sample::select(vec![1.0, 1.0, 0.75, 0.5, 0.25]),
        scale in prop::sample::select(vec![1.0, 1.0, 2.0, 0.5]),
        center in ([-0.5..1.5f64, -0.5..1.5f64, -1.0..1.0f64], 0..40i32),
        foothold in [0..=8u8, 0..=8u8],
        corner in [any::<bool>(), any::<bool>()],
        tau_off in prop_oneof![-0.1..0.1f64, -100.0..100.0f64],
        shifted in any::<bool>(),
    ) {
        let points = points(&heights, dent, scale);
        let origin = if shifted { [1e6, -3.0, 0.1] } else { [0.0; 3] };
        let balls = points.iter().map(|p| p.map(Ball::exact)).collect();
        let net = Net::<f64>::new(DEGREE, balls, origin);
        // On the surface, but for so much.
        let (way, step) = center;
        let way: [f64; 3] = std::array::from_fn(|k| if k == 2 { way[2] * 0.5f64.powi(step) } else { way[k] });
        let center = Point3::from([way[0] + origin[0], way[1] + origin[1], way[2] + origin[2]]);
        let products = net.products();
        let half = |corner: bool| if corner { [0.5, 1.0] } else { [0.0, 0.5] };
        let [u, v] = corner.map(half);
        let cut = products.restricted(u, v).expect("a quarter");
        let node = Node::over(Quotient::squared_distance(&center, &net, &cut), u, v, true);
        // In the box.
        let start = corner.map(|c| if c { 4 } else { 0 });
        let at = [0, 1].map(|k| start[k] + foothold[k] / 2);
        let held = Foothold::new(&net, at.map(|x| f64::from(x) / 8.0));
        let tau = squared(&points, origin, center.coords.into(), at).to_f64().value() + tau_off;
        let cell = Cell::from(&node);
        let shape = node.shape(tau);
        let least = held.least(&center, &cell, (&shape, tau));
        if least.is_finite() {
            let told = exact(least);
            for i in 0..=4 {
                for j in 0..=4 {
                    let place = [start[0] + i, start[1] + j];
                    let truth = squared(&points, origin, center.coords.into(), place);
                    prop_assert!(told <= truth, "{place:?}: {least} {}", truth.to_f64().value());
                }
            }
        }
    }
}

/// The distance of `(x, y, 1)` from a flat square is a quadratic: its least value follows from any place, and at a border of the box that the foot is beyond the place
/// there tells it. So it does where all weights are another number than 1, be it so small that squares of `G`'s slopes underflow.
#[test]
fn of_a_flat_square_nothing_is_lost() {
    /// `G`'s slopes are of the size of its square, and squares of those, 1e-328, are 0 in f64.
    const SMALL: f64 = 1e-82;
    for scale in [1.0, 2.0, 0.5, 1.0 / crate::brep::LARGEST_COORDINATE, SMALL] {
        let points = points(&[0.0; 9], 1.0, scale);
        let balls = points.iter().map(|p| p.map(Ball::exact)).collect();
        let net = Net::<f64>::new(DEGREE, balls, [0.0; 3]);
        let products = net.products();
        for (center, at, truth) in [
            ([0.25, 0.5, 1.0], [0.5, 0.75], 1.0),
            ([0.375, 0.125, 1.0], [0.0, 0.0], 1.0),
            ([-0.5, 0.5, 1.0], [0.0, 0.25], 1.25),
            ([1.5, -1.0, 1.0], [1.0, 0.0], 2.25),
        ] {
            let center = Point3::from(center);
            let node = Node::root(Quotient::squared_distance(&center, &net, &products), true);
            // That of the place, lest the difference cost something.
            let tau = (at[0] - center.x).powi(2) + (at[1] - center.y).powi(2) + 1.0;
            let shape = node.shape(tau);
            let held = Foothold::new(&net, at);
            let least = held.least(&center, &Cell::from(&node), (&shape, tau));
            assert!(
                least <= truth && least > truth - 1e-12,
                "{center} {at:?}: {least} {truth}"
            );
        }
    }
}
