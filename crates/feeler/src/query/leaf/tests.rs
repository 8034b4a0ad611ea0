//! What convexity proves, where the least value is known.

use super::*;
use crate::brep::Brep;
use crate::nurbs::{NurbsSurface, Surface};
use crate::prepare::{PreparedBrep, Quotient};
use crate::query::node::Node;
use crate::query::objective::Objective;
use crate::query::outcome::{Goal, Width};
use crate::query::task::Memory;
use crate::query::{Options, Probe, Sphere, Workspace, contact};
use nalgebra::{Point3, Vector4};

/// The distance of `(a, b, 1)` from points of a flat NURBS square: `f = 1 + |p - (a, b)|^2` is as convex along u as along v, and has no terms beyond: at any point
/// of the square the bound is the least value itself but for rounding, and never more, and the ball about it holds `(a, b)`.
#[test]
fn the_bound_of_a_quadratic_is_its_least_value() {
    let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];
    let points = corners.map(|[x, y]| Vector4::new(x, y, 0.0, 1.0));
    let knots = [0, 1].map(|_| vec![0.0, 0.0, 1.0, 1.0]);
    let surface = NurbsSurface::new([1, 1], [2, 2], points.to_vec(), knots).unwrap();
    let brep = PreparedBrep::new(Brep::from_surface(Surface::Nurbs(surface)).unwrap());
    let net = &brep.double(0).patches[0].net;
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
    for [a, b] in [[0.5, 0.5], [0.25, 0.75], [0.375, 0.5]] {
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
                "{a} {b} {p:?}: {:?}",
                leaf.lo
            );
            let far = (p[0] - a).hypot(p[1] - b);
            assert!(leaf.rho >= far, "{a} {b} {p:?}: {} {far}", leaf.rho);
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
