//! What convexity proves, where the least value is known.

use super::*;
use crate::brep::Brep;
use crate::nurbs::{NurbsSurface, Surface};
use crate::prepare::{Net, PreparedBrep, Quotient};
use crate::query::node::Node;
use crate::query::objective::Objective;
use crate::query::outcome::{Goal, Width};
use crate::query::task::Memory;
use crate::query::{Options, Probe, Sphere, Workspace, contact};
use nalgebra::{Point3, Vector4};

/// The distance of `(a, b, 1)` from points of a flat NURBS square: `f = 1 + |p - (a, b)|^2` is as convex along u as along v, and has no terms beyond: at any point
/// of the square the bound is the least value itself but for rounding, and never more, and the balls about it hold `(a, b)`. So it is with weights so small that squares of
/// `G`'s slopes underflow.
#[test]
fn the_bound_of_a_quadratic_is_its_least_value() {
    let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];
    let points = corners.map(|[x, y]| Vector4::new(x, y, 0.0, 1.0));
    let knots = [0, 1].map(|_| vec![0.0, 0.0, 1.0, 1.0]);
    let surface = NurbsSurface::new([1, 1], [2, 2], points.to_vec(), knots).unwrap();
    let brep = PreparedBrep::new(Brep::from_surface(Surface::Nurbs(surface)).unwrap());
    let goal = Goal {
        width: Width::Length(1e-9),
        all_below: None,
        extents: None,
        threshold: None,
        budget: 1000,
        closed: false,
        foot: false,
        hint: None,
    };
    /// `G`'s slopes are of the size of its square, and squares of those, 1e-328, are 0 in f64.
    const SMALL: f64 = 1e-82;
    let weights = [1.0, 1.0 / crate::brep::LARGEST_COORDINATE, SMALL];
    let places = [[0.5, 0.5], [0.25, 0.75], [0.375, 0.5]];
    for (weight, [a, b]) in weights.into_iter().flat_map(|w| places.map(|p| (w, p))) {
        let points = points.map(|p| (p * weight).data.0[0].map(Ball::exact));
        let net = &Net::<f64>::new(Bidegree { u: 1, v: 1 }, points.to_vec(), [0.0; 3]);
        let q = Point3::new(a, b, 1.0);
        let objective = Objective::SquaredDistance(q);
        let mut memory = Memory::default();
        let search = Search::new(&brep, &objective, goal, &mut memory);
        let f = Quotient::squared_distance(&q, net, &net.products());
        let node = Node::root(f, true);
        for p in [[0.5, 0.5], [0.25, 0.5], [0.125, 0.875], [0.75, 0.25]] {
            let sample = objective.rough_sample(net, p);
            let tau = sample.value().mid;
            let shape = node.shape(tau.hi);
            let cell = Cell::from(&node);
            let leaf = search.prove(&cell, (&shape, Dd::from(tau.hi)), p.map(Dd::from), &sample);
            let leaf = leaf.unwrap();
            assert!(
                leaf.lo <= Dd::ONE && leaf.lo.hi >= 1.0 - 1e-12,
                "{weight} {a} {b} {p:?}: {:?}",
                leaf.lo
            );
            let far = (p[0] - a).hypot(p[1] - b);
            assert!(
                leaf.rho >= far,
                "{weight} {a} {b} {p:?}: {} {far}",
                leaf.rho
            );
            let growth = Growth {
                speed: 1.0,
                ..leaf.growth
            };
            // Where `f <= 1` there is the least place alone; and it grows by 1/16 within a quarter.
            for (hi, more) in [(1.0, 0.0), (1.0625, 0.25)] {
                let radius = growth.radius(Dd::from(hi));
                assert!(
                    radius >= far + more,
                    "{weight} {a} {b} {p:?}: {radius} {far}"
                );
            }
        }
    }
}

/// The least distance of the whole surface is next to the trim at x = 0, beyond it by less than a parameter's leading digits tell: that of the face is that of the
/// trim's own point, the origin.
#[test]
fn a_minimum_beyond_a_trim_is_none() {
    let brep = crate::query::tests::bowl(0.0);
    for digits in [52, 60] {
        let h = 2f64.powi(-digits);
        let probe = Probe::Sphere(Sphere::new([h, 0.0, h].into(), 0.0).unwrap());
        let answer = contact(
            &brep,
            &probe,
            &Options::default(),
            &mut Workspace::default(),
        );
        let bounds = answer.separation.bounds;
        let truth = h * 2f64.sqrt();
        assert!(
            bounds.lo <= truth.next_up() && bounds.hi >= truth.next_down(),
            "{bounds:?}"
        );
    }
}

/// The least of a convex quadratic on the sides of a box, against many points of them.
#[test]
fn the_least_on_the_sides_of_a_box() {
    let mut seed = 11u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 40) as f64 / (1u64 << 23) as f64 - 1.0
    };
    for _ in 0..500 {
        let [a, b, c] = [random(), random(), random()];
        // A Hessian that is positive, narrow valleys among them.
        let h = [a * a + 1e-3, a * b, b * b + 1e-3];
        let slope = [4.0 * c, 4.0 * random()];
        let room = [0, 1].map(|_| {
            let low = random() - 1.0;
            [low, low + 1.0 + random().abs()]
        });
        let value = |s: [f64; 2]| {
            slope[0] * s[0]
                + slope[1] * s[1]
                + 0.5 * (h[0] * s[0] * s[0] + h[2] * s[1] * s[1])
                + h[1] * s[0] * s[1]
        };
        let places = least_on_sides(slope, h, room);
        let at: [f64; 2] = std::array::from_fn(|k| match places[k] {
            Place::End(high) => room[k][usize::from(high)],
            Place::Between(step) => step,
        });
        assert!(places.iter().any(|p| matches!(p, Place::End(_))));
        assert!((0..2).all(|k| room[k][0] <= at[k] && at[k] <= room[k][1]));
        for i in 0..=64 {
            let s = f64::from(i) / 64.0;
            let along = |k: usize| room[k][0] + s * (room[k][1] - room[k][0]);
            for end in [0, 1] {
                for other in [[room[0][end], along(1)], [along(0), room[1][end]]] {
                    assert!(
                        value(at) <= value(other) + 1e-12,
                        "{slope:?} {h:?} {room:?}"
                    );
                }
            }
        }
    }
}
