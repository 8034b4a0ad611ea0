//! Casts of balls as bodies move, on ways that are straight but for a little, from other times than 0, with shapes that are not to be exact, of both balls of a pair.

use crate::scenes::{Random, floor_and_wall, part, prism, shape};
use feeler_rapier::{BrepDispatcher, BrepShape, ball_gap};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::details::ShapeCastOptions;
use parry3d_f64::query::{NonlinearRigidMotion, QueryDispatcher, ShapeCastHit, ShapeCastStatus};
use parry3d_f64::shape::{Ball, Shape};

/// What is overlooked, in radii.
const ALLOWANCE: f64 = 1.0 / 128.0;

/// Both orders, against a BREP that stands still; contacts at the start that are left do not count.
fn cast(
    brep: &BrepShape,
    moves: &NonlinearRigidMotion,
    radius: f64,
    [from, until]: [f64; 2],
) -> Option<ShapeCastHit> {
    let d = BrepDispatcher::new();
    let (still, ball) = (NonlinearRigidMotion::identity(), Ball::new(radius));
    let one = d.cast_shapes_nonlinear(&still, brep, moves, &ball, from, until, false);
    let two = d.cast_shapes_nonlinear(moves, &ball, &still, brep, from, until, false);
    let [one, two] = [one, two].map(|hit| hit.unwrap());
    assert_eq!(one.map(|h| h.time_of_impact), two.map(|h| h.time_of_impact));
    one
}

/// A ball whose centre is as far off the centre of mass, so that it goes round it on a circle twice as wide.
fn off_centre(from: Vector, arm: f64, velocity: Vector) -> NonlinearRigidMotion {
    NonlinearRigidMotion {
        start: Pose::from_translation(from),
        local_center: Vector::new(arm, 0.0, 0.0),
        linvel: velocity,
        angvel: Vector::new(0.0, 0.0, 7.0),
    }
}

/// Bends of 1.4e-6 to 6e-5 (an allowance is 4e-3, a 64th of it 6.1e-5): the wall is met as if the way were straight, early by 32 bends of way at the most, and nothing is undecided.
#[test]
fn ways_that_bend_by_little() {
    let brep = floor_and_wall(8.0);
    let radius = 0.5;
    let there = brep.brep().size() / f64::from(1 << 20);
    for bend in [1.4e-6, 5e-6, 1e-5, 3e-5, 6e-5] {
        for [x, y] in [[2.0, 0.0], [2.0, 1.5], [100.0, -30.0]] {
            let velocity = Vector::new(x, y, 0.0);
            let from = Vector::new(-1.0, 0.0, radius - 1e-3);
            let moves = off_centre(from, 0.5 * bend, velocity);
            let hit = cast(&brep, &moves, radius, [0.0, 9.0]).expect("the wall");
            assert_eq!(hit.status, ShapeCastStatus::Converged, "{bend} {hit:?}");
            // As deep in the wall as it is in the floor.
            let expected = (4.0 - radius + 1e-3 + 1.0) / x;
            let early = (there + 34.0 * bend) / velocity.length();
            let t = hit.time_of_impact;
            assert!(t <= expected + bend / x, "{bend} {t} {expected}");
            assert!(t >= expected - early, "{bend} {t} {expected}");
        }
    }
    assert_eq!(brep.undecided(), 0);
}

/// The same over the edge of a step that is only just too high to be overlooked: it is passed at a small angle.
#[test]
fn a_step_that_only_just_counts() {
    let (radius, from) = (0.5, -1.0);
    for part in [1.05, 1.5, 4.0] {
        let step = part * radius * ALLOWANCE;
        let profile = [
            [-8.0, -1.0],
            [9.0, -1.0],
            [9.0, step],
            [4.0, step],
            [4.0, 0.0],
            [-8.0, 0.0],
        ];
        let brep = shape(prism(&profile, [-2.0, 2.0]));
        let there = brep.brep().size() / f64::from(1 << 20);
        for bend in [0.0, 3e-5, 6e-5] {
            let start = Vector::new(from, 0.0, radius);
            let moves = off_centre(start, 0.5 * bend, Vector::new(2.0, 0.0, 0.0));
            let hit = cast(&brep, &moves, radius, [0.0, 2.5]).expect("the step");
            assert_eq!(hit.status, ShapeCastStatus::Converged, "{part} {hit:?}");
            let reach = (2.0 * radius * step - step * step).sqrt();
            let expected = (4.0 - reach - from) / 2.0;
            let t = hit.time_of_impact;
            // At this angle what the centre is off moves the time by some 8 times as much.
            assert!(
                t <= expected + 12.0 * bend / 2.0 + 1e-12,
                "{part} {bend} {t}"
            );
            let early = there + (32.0 + 12.0) * bend;
            assert!(t >= expected - early / 2.0, "{part} {bend} {t} {expected}");
        }
        assert_eq!(brep.undecided(), 0, "{part}");
    }
}

/// A cast from a later time tells the same: along a floor, round a centre of mass, and driven in from when the ball touches.
#[test]
fn from_a_later_time() {
    let brep = floor_and_wall(8.0);
    let radius = 0.5;
    let early = brep.brep().size() / f64::from(1 << 20);
    let moves = NonlinearRigidMotion {
        start: Pose::translation(-1.0, 0.0, radius),
        linvel: Vector::new(2.0, 0.0, 0.0),
        ..NonlinearRigidMotion::identity()
    };
    let wall = (4.0 - radius + 1.0) / 2.0;
    for from in [-1.0, 0.0, 0.375, 2.0] {
        let t = cast(&brep, &moves, radius, [from, 9.0])
            .unwrap()
            .time_of_impact;
        assert!(t <= wall && t >= wall - early, "{from} {t} {wall}");
        assert!(cast(&brep, &moves, radius, [from, wall - 0.01]).is_none());
    }
    // It falls, and touches at the time 1.
    let falls = NonlinearRigidMotion {
        start: Pose::translation(-1.0, 0.0, radius + 1.0),
        linvel: Vector::new(0.5, 0.0, -1.0),
        ..NonlinearRigidMotion::identity()
    };
    let deeper = radius * ALLOWANCE;
    let t = cast(&brep, &falls, radius, [1.0, 2.0])
        .unwrap()
        .time_of_impact;
    assert!(t <= 1.0 + deeper && t >= 1.0 + 0.95 * deeper, "{t}");
    let t = cast(&brep, &falls, radius, [0.5, 2.0])
        .unwrap()
        .time_of_impact;
    assert!((1.0 - 1e-8..=1.0).contains(&t), "{t}");
    // Swung down about a centre of mass at the ball's height, 0.75 beside it, while that rises at 1.5: z = r + 1/4 + 1.5 t - 0.75 sin(4 t), which is r at some time.
    let swings = NonlinearRigidMotion {
        start: Pose::translation(-1.0, 0.0, radius + 0.25),
        local_center: Vector::new(-0.75, 0.0, 0.0),
        linvel: Vector::new(0.0, 0.0, 1.5),
        angvel: Vector::new(0.0, 4.0, 0.0),
    };
    let height = |t: f64| 0.25 + 1.5 * t - 0.75 * (4.0 * t).sin();
    assert!((swings.position_at_time(0.3).translation.z - radius - height(0.3)).abs() < 1e-12);
    let falls_to = |wanted: f64| {
        // It falls until cos 4t = 1/2.
        let (mut lo, mut hi) = (0.0, std::f64::consts::FRAC_PI_3 / 4.0);
        for _ in 0..80 {
            let middle = 0.5 * (lo + hi);
            match height(middle) > wanted {
                true => lo = middle,
                false => hi = middle,
            }
        }
        hi
    };
    let touches = falls_to(0.0);
    for from in [touches, falls_to(-1e-4)] {
        let start = height(from).min(0.0);
        let t = cast(&brep, &swings, radius, [from, 0.3])
            .unwrap()
            .time_of_impact;
        let [soonest, latest] = [61.0 / 64.0, 1.0].map(|part| falls_to(start - part * deeper));
        assert!(t >= soonest && t <= latest + 1e-9, "{from} {t}");
    }
    assert_eq!(brep.undecided(), 0);
}

/// Each ball of a pair that turns about an upright axis while it goes along the floor: x = x0 + v t -+ sin(w t) / 4.
#[test]
fn both_balls_of_a_pair() {
    let brep = floor_and_wall(8.0);
    let (radius, arm, speed) = (0.5, 0.25, 20.0);
    for spin in [1.0f64, 12.0] {
        for side in [1.0, -1.0] {
            let moves = NonlinearRigidMotion {
                start: Pose::translation(0.0, side * arm, radius),
                local_center: Vector::new(0.0, -side * arm, 0.0),
                linvel: Vector::new(speed, 0.0, 0.0),
                angvel: Vector::new(0.0, 0.0, spin),
            };
            let x = |t: f64| speed * t - side * arm * (spin * t).sin();
            let met = |part: f64| {
                let wanted = 4.0 - radius + part * radius * ALLOWANCE;
                let (mut lo, mut hi) = (0.0, 1.0);
                for _ in 0..80 {
                    let middle = 0.5 * (lo + hi);
                    match x(middle) < wanted {
                        true => lo = middle,
                        false => hi = middle,
                    }
                }
                hi
            };
            let hit = cast(&brep, &moves, radius, [0.0, 1.0]).expect("the wall");
            let t = hit.time_of_impact;
            assert!(t >= met(62.0 / 64.0) && t <= met(1.0) + 1e-9, "{side} {t}");
            assert_eq!(hit.status, ShapeCastStatus::Converged);
        }
    }
    assert_eq!(brep.undecided(), 0);
}

/// Shapes whose contacts are to be known to no better than four radii of the ball: casts know them as well as they need, on straight ways and on others.
#[test]
fn coarse_shapes() {
    let name = "sheet_trimmed_nurbs.3dm";
    let fine = shape(part(name));
    let bounds = fine.compute_local_aabb();
    let size = bounds.half_extents();
    let d = BrepDispatcher::new();
    let mut random = Random(23);
    let mut hits = 0;
    for k in 0..24 {
        let radius = random.between(0.01, 0.05) * size.length();
        let ball = Ball::new(radius);
        let coarse = shape(part(name)).with_accuracy(4.0 * radius);
        // Brought down onto it.
        let from = bounds.center() + random.vector(0.5) * size + Vector::Z * (2.0 * size.length());
        let pose = Pose::from_translation(from);
        let options = ShapeCastOptions::default();
        let met = d
            .cast_shapes(&pose, -Vector::Z, &fine, &ball, options)
            .unwrap();
        let Some(met) = met else { continue };
        let start = from - Vector::Z * met.time_of_impact - met.normal1 * (1e-3 * radius);
        let moves = NonlinearRigidMotion {
            start: Pose::from_parts(start, Rotation::from_scaled_axis(random.vector(1.0))),
            local_center: random.vector([0.0, radius][k % 2]),
            linvel: random.vector(6.0 * radius),
            angvel: random.vector(2.0),
        };
        let hit = cast(&coarse, &moves, radius, [0.0, 1.0]);
        let gap = |t: f64| {
            let center = moves.position_at_time(t).translation;
            ball_gap(&fine, &Pose::IDENTITY, center, radius).value
        };
        let free = hit.map_or(1.0, |h| h.time_of_impact);
        let first = gap(0.0).min(0.0);
        for i in 0..=20 {
            let g = gap(free * f64::from(i) / 20.0);
            assert!(g >= first - radius * ALLOWANCE - 1e-10, "{k} {g} {first}");
        }
        if let Some(hit) = hit {
            assert_eq!(hit.status, ShapeCastStatus::Converged, "{k} {hit:?}");
            assert!(hit.time_of_impact > 0.0, "{k}");
            hits += 1;
        }
        assert_eq!(coarse.undecided(), 0, "{k}");
    }
    assert!(hits > 6, "{hits}");
}
