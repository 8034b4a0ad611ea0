//! What single steps of answers are by their definitions.

use super::advance::StraightWay;
use super::answer::{HalfSpace, Options, Probe};
use super::arrival::{Motion, arrival};
use super::contact::separation;
use super::objective::Objective;
use super::past::arrival_past;
use super::{Accuracy, Workspace};
use crate::brep::BrepBuilder;
use crate::numeric::Dd;
use crate::prepare::PreparedBrep;
use nalgebra::{Point3, Vector3};

/// The square in the plane x = 4 with y and z from -1 to 1.
fn wall() -> PreparedBrep {
    let mut b = BrepBuilder::new();
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let corners = corners.map(|[y, z]| b.vertex([4.0, y, z]));
    b.planar_face(&corners).unwrap();
    PreparedBrep::new(b.build().unwrap())
}

/// The distance is in [3, 5], the radius 1: outside it is d - r, in material -d - r, and where that is not known anything between.
#[test]
fn the_sign_of_a_separation() {
    let squares = [9.0, 25.0].map(Dd::from);
    let about = Objective::SquaredDistance(Point3::origin());
    // In material the farther a boundary is, the lower the separation.
    for (material, expected) in [
        (Some(false), [2.0, 4.0]),
        (Some(true), [-6.0, -4.0]),
        (None, [-6.0, 4.0]),
    ] {
        let bounds = separation(squares, &about, 1.0, material).bounds;
        let [lo, hi] = expected;
        assert!(bounds.lo <= lo && lo <= bounds.lo.next_up(), "{bounds:?}");
        assert!(bounds.hi >= hi && hi >= bounds.hi.next_down(), "{bounds:?}");
    }
}

/// A plane that moves arrives where what is left between the two is the prediction, not nothing.
#[test]
fn a_plane_arrives_at_its_prediction() {
    let brep = wall();
    let plane = Probe::HalfSpace(HalfSpace::new(Vector3::x(), 0.0).unwrap());
    let motion = Motion::new(Vector3::new(2.0, 0.0, 0.0), f64::INFINITY).unwrap();
    for prediction in [0.0, 0.5, -0.25] {
        let options = Options {
            prediction,
            ..Options::default()
        };
        let found = arrival(&brep, &plane, &motion, &options, &mut Workspace::default());
        let time = found.time.unwrap().bounds;
        assert!(
            time.contains((4.0 - prediction) / 2.0),
            "{prediction} {time:?}"
        );
        assert!(time.width() < 1e-12, "{prediction} {time:?}");
    }
}

/// A ball straight to a wall, from a place known to a bound: it may come sooner by that and later by that; a wall that it misses by less is not missed.
#[test]
fn a_ball_whose_place_is_known_to_a_bound() {
    let brep = wall();
    let (radius, allowance, bound) = (0.5, 1.0 / 32.0, 1.0 / 1024.0);
    let options = Options {
        accuracy: Accuracy::Length(bound / 64.0),
        ..Options::default()
    };
    let ask = |y: f64| {
        let way = StraightWay {
            center: Point3::new(0.0, y, 0.0),
            center_bound: bound,
            velocity: Vector3::x(),
            velocity_bound: 0.0,
        };
        let span = [0.0, 8.0];
        arrival_past(
            &brep,
            radius,
            &way,
            span,
            allowance,
            &options,
            &mut Workspace::default(),
        )
        .time
    };
    let head_on = ask(0.0).unwrap().bounds;
    assert!(
        head_on.lo <= 3.5 - bound && 3.5 + bound <= head_on.hi,
        "{head_on:?}"
    );
    // The rim at y = 1 counts where it is nearer to the way than r - a.
    let counts = 1.0 + radius - allowance;
    assert!(ask(counts + 0.5 * bound).is_some());
    assert!(ask(counts + 2.0 * bound).is_none());
}
