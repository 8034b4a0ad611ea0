//! Balls whose way is known up to a bound alone: whatever the true way is within it, what is told of the time holds of it.

use crate::scenes::blocks;
use feeler::numeric::Enclosure;
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, ArrivalAnswer, Options, StraightWay, Workspace, arrival_along, arrival_past,
};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use std::sync::LazyLock;

const RADIUS: f64 = 0.5;
/// Of ways past what a ball goes along.
const ALLOWANCE: f64 = 1.0 / 64.0;
/// The way's end is some ten units of time away: what its velocity adds is as much as the start's bound.
const LONG: f64 = 16.0;

/// A floor up to z = 0, and a wall on it from x = 4 on.
static WALL: LazyLock<PreparedBrep> = LazyLock::new(|| {
    PreparedBrep::new(blocks(&[
        [[-8.0, -2.0, -1.0], [8.0, 2.0, 0.0]],
        [[4.0, -2.0, 0.0], [5.0, 2.0, 3.0]],
    ]))
});

/// A ball from x = 0 along x, and what is off: the true way starts at `off` from it and goes by `drift` faster, with bounds that hold both.
fn nominal(start: [f64; 3], bound: f64) -> StraightWay {
    StraightWay {
        center: Point3::from(start),
        center_bound: bound,
        velocity: Vector3::x(),
        velocity_bound: bound / LONG,
    }
}

fn past(brep: &PreparedBrep, way: &StraightWay, options: &Options) -> ArrivalAnswer {
    arrival_past(
        brep,
        RADIUS,
        way,
        [0.0, 8.0],
        ALLOWANCE,
        options,
        &mut Workspace::default(),
    )
}

/// What is rounded in these few operations with numbers below 16.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

fn holds(bounds: &Enclosure, time: f64) -> bool {
    bounds.lo <= time + ROUNDING && time <= bounds.hi + ROUNDING
}

/// A vector of at most unit length, often along the way itself, where it counts most.
fn off() -> impl Strategy<Value = Vector3<f64>> {
    let any = prop::array::uniform3(-0.57..0.57f64).prop_map(Vector3::from);
    prop_oneof![Just(Vector3::x()), Just(-Vector3::x()), any,]
}

/// Bounds as large as the allowance lets pass, and far smaller ones.
fn bound() -> impl Strategy<Value = f64> {
    (11..30i32).prop_map(|k| (-f64::from(k)).exp2())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// The ball hovers above a floor and comes to a wall, by its middle: the least and the latest time that the bounds leave are within what is told.
    #[test]
    fn the_wall_is_met_within_the_bounds(
        bound in bound(),
        (off, drift) in (off(), off()),
        height in prop_oneof![Just(4.0), 4.0..1e3f64],
    ) {
        let start = [0.0, 0.0, RADIUS + height * bound];
        let way = nominal(start, bound);
        let options = Options { accuracy: Accuracy::Length(bound / 16.0), ..Options::default() };
        let speed = 1.0 + drift.x * way.velocity_bound;
        let time = (4.0 - RADIUS - off.x * bound) / speed;
        // Where nothing but the wall is near, a way that need not be straight is followed, too.
        let above = nominal([0.0, 0.0, 1.5], bound);
        let along = arrival_along(&WALL, RADIUS, &above, [0.0, 8.0], &options, &mut Workspace::default());
        for (what, answer) in [("past", past(&WALL, &way, &options)), ("along", along)] {
            let told = answer.time.map(|t| t.bounds);
            prop_assert!(told.is_some_and(|t| holds(&t, time)), "{} {:?} {}", what, told, time);
            // Both ends are of some use all the same: the start's bound, what the velocity adds until then, and what the way is asked for.
            let room = 2.0 * bound * (1.0 + 8.0 / LONG) + bound / 16.0;
            prop_assert!(told.is_some_and(|t| t.lo >= 4.0 - RADIUS - 2.0 * room), "{} {:?}", what, told);
        }
    }

    /// The ball passes the edge of a block at its side, as near as just counts if the true way is nearer to the block than the nominal one.
    #[test]
    fn what_the_true_way_touches_is_not_passed_by(
        bound in bound(),
        within in 0.02..0.98f64,
        toward in 0.5..1.0f64,
    ) {
        // Of the true way it counts, by a part of the bound; of the nominal one it does not, by the rest.
        let counts = RADIUS - ALLOWANCE;
        let side = counts + within * toward * bound;
        let block = PreparedBrep::new(blocks(&[[[4.0, side, -1.0], [5.0, 3.0, 1.0]]]));
        let answer = past(&block, &nominal([0.0; 3], bound), &Options::default());
        let beside = side - toward * bound;
        prop_assert!(beside < counts - ROUNDING);
        // The side of the block is level with the way: its edge is met first.
        let time = 4.0 - (RADIUS * RADIUS - beside * beside).sqrt();
        let told = answer.time.map(|t| t.bounds);
        prop_assert!(told.is_some_and(|t| t.lo <= time + ROUNDING), "{:?} {}", told, time);
    }
}
