//! Casts of balls as bodies move that touch a BREP at the start: on ways that bend, driven in, and as good as straight.

use crate::scenes::{Random, floor_and_wall, part, prism, shape};
use feeler_rapier::{BrepDispatcher, BrepShape, ball_gap};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::details::ShapeCastOptions;
use parry3d_f64::query::{NonlinearRigidMotion, QueryDispatcher, ShapeCastHit, ShapeCastStatus};
use parry3d_f64::shape::{Ball, Shape};
use rapier3d_f64::prelude::{
    ColliderBuilder, PhysicsWorld, RigidBodyBuilder, SharedShape, SpringCoefficients,
    Vector as WorldVector,
};

/// What is overlooked, in radii; it is known to a 64th of itself.
const ALLOWANCE: f64 = 1.0 / 128.0;

/// Both orders, contacts at the start that are left do not count.
fn cast(
    brep: &BrepShape,
    [of_brep, of_ball]: [&NonlinearRigidMotion; 2],
    radius: f64,
    until: f64,
) -> Option<ShapeCastHit> {
    let d = BrepDispatcher::new();
    let ball = Ball::new(radius);
    let one = d
        .cast_shapes_nonlinear(of_brep, brep, of_ball, &ball, 0.0, until, false)
        .unwrap();
    let two = d
        .cast_shapes_nonlinear(of_ball, &ball, of_brep, brep, 0.0, until, false)
        .unwrap();
    assert_eq!(one.map(|h| h.time_of_impact), two.map(|h| h.time_of_impact));
    one
}

/// It is stopped before the time at which it is deeper by the allowance, by no more than a 64th of that.
#[track_caller]
fn stops(hit: Option<ShapeCastHit>, [soonest, latest]: [f64; 2]) {
    let hit = hit.expect("something is in the way");
    let t = hit.time_of_impact;
    assert!(t >= soonest && t <= latest, "{t} {soonest} {latest}");
    assert_eq!(hit.status, ShapeCastStatus::Converged);
}

/// The ball rests on a plate that turns below it about the z axis, and shifts as it does: in the plate's frame it goes round on a circle of radius 3.8, until it
/// is in the wall by the allowance more than in the floor: 3.8 cos = 4 - r + sunk + r / 128.
#[test]
fn a_wall_comes_round() {
    let brep = floor_and_wall(8.0);
    let radius = 0.5;
    for sunk in [0.0, 1e-4, -1e-6] {
        for shift in [Vector::ZERO, Vector::new(3.0, -1.0, 2.0)] {
            // From a quarter of a turn before the x axis of the plate.
            let plate = NonlinearRigidMotion {
                angvel: Vector::new(0.0, 0.0, -0.5),
                linvel: shift,
                ..NonlinearRigidMotion::identity()
            };
            let rests = NonlinearRigidMotion {
                start: Pose::translation(0.0, -3.8, radius - sunk),
                linvel: shift,
                ..NonlinearRigidMotion::identity()
            };
            let known = 1.0 / 64.0;
            let met = |part: f64| {
                let x = 4.0 - radius + f64::max(sunk, 0.0) + part * radius * ALLOWANCE;
                (std::f64::consts::FRAC_PI_2 - (x / 3.8).acos()) / 0.5
            };
            let hit = cast(&brep, [&plate, &rests], radius, 9.0);
            stops(hit, [met(1.0 - known), met(1.0) + 1e-9]);
            // Not yet.
            assert!(cast(&brep, [&plate, &rests], radius, met(0.9)).is_none());
            // Away from the wall, half round.
            let back = NonlinearRigidMotion {
                angvel: -plate.angvel,
                ..plate
            };
            assert!(cast(&brep, [&back, &rests], radius, 6.0).is_none());
        }
    }
    assert_eq!(brep.undecided(), 0);
}

/// One ball of a pair on a rod, the centre of mass 0.75 above it: it touches the floor, swings up, and comes to the wall:
/// x = x0 + v t + 0.75 sin(w t).
#[test]
fn a_ball_that_goes_round_its_centre_of_mass() {
    let brep = floor_and_wall(8.0);
    let (radius, arm, speed) = (0.5, 0.75, 20.0);
    for spin in [1.0, 8.0] {
        let moves = NonlinearRigidMotion {
            start: Pose::translation(0.0, 0.0, radius),
            local_center: Vector::new(0.0, 0.0, arm),
            linvel: Vector::new(speed, 0.0, 0.0),
            angvel: Vector::new(0.0, -spin, 0.0),
        };
        let still = NonlinearRigidMotion::identity();
        let at = |t: f64| moves.position_at_time(t).translation;
        let x = |t: f64| speed * t + arm * (spin * t).sin();
        assert!((at(0.1).x - x(0.1)).abs() < 1e-12);
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
        let hit = cast(&brep, [&still, &moves], radius, 1.0);
        stops(hit, [met(1.0 - 1.0 / 64.0), met(1.0) + 1e-9]);
        assert!(cast(&brep, [&still, &moves], radius, met(0.9)).is_none());
    }
    assert_eq!(brep.undecided(), 0);
}

/// What a body's frame leaves of a centre of mass by rounding makes no way bend: the wall is met where the ball is as deep in it as in the floor.
#[test]
fn a_centre_of_mass_that_is_off_by_rounding() {
    let brep = floor_and_wall(8.0);
    let still = NonlinearRigidMotion::identity();
    for off in [0.0, 1e-16, 1e-10] {
        let moves = NonlinearRigidMotion {
            start: Pose::translation(-1.0, 0.0, 0.5 - 1e-3),
            local_center: Vector::new(off, -off, 0.0),
            linvel: Vector::new(2.0, 0.0, 0.0),
            angvel: Vector::new(3.0, -2.0, 1.0),
        };
        let hit = cast(&brep, [&still, &moves], 0.5, 9.0);
        let expected = (4.0 - 0.5 + 1e-3 + 1.0) / 2.0;
        let there = brep.brep().size() / f64::from(1 << 20);
        stops(hit, [expected - there, expected + off]);
    }
    assert_eq!(brep.undecided(), 0);
}

/// Along the floor into the wall, which it touches as well: wherever of the two the contact at the start is said to be, it is stopped later than at the start, where an
/// engine would pass it over.
#[test]
fn a_ball_in_a_corner() {
    let brep = floor_and_wall(8.0);
    let (radius, still) = (0.5, NonlinearRigidMotion::identity());
    for [into_wall, into_floor] in [[0.0, 0.0], [1e-3, 1e-3], [1e-13, 0.0], [0.0, 1e-13]] {
        for speed in [1.0, 100.0] {
            let moves = NonlinearRigidMotion {
                start: Pose::translation(4.0 - radius + into_wall, 0.0, radius - into_floor),
                linvel: Vector::new(speed, 0.0, 0.0),
                ..NonlinearRigidMotion::identity()
            };
            let deeper = radius * ALLOWANCE / speed;
            let hit = cast(&brep, [&still, &moves], radius, 0.1);
            let t = hit.expect("the wall is in the way").time_of_impact;
            assert!(t > 0.0 && t <= deeper * (1.0 + 1e-9), "{t} {deeper}");
        }
    }
    assert_eq!(brep.undecided(), 0);
    // A centre in material is said to be unknown.
    let moves = NonlinearRigidMotion {
        start: Pose::translation(0.0, 0.0, -0.01),
        linvel: Vector::new(0.0, 0.0, -1.0),
        ..NonlinearRigidMotion::identity()
    };
    cast(&brep, [&still, &moves], radius, 1.0);
    assert!(brep.undecided() > 0);
}

/// Driven into the floor by more than is overlooked in the time asked about: as bodies move it is stopped where it is deeper than at the start by as much; as shapes
/// are cast it hits at the start.
#[test]
fn a_ball_that_is_driven_in() {
    let brep = floor_and_wall(8.0);
    let (radius, sunk) = (0.5, 1e-3);
    let from = Vector::new(-1.0, 0.25, radius - sunk);
    for velocity in [
        Vector::new(1.0, 0.0, -1.0),
        Vector::new(300.0, 0.0, -10.0),
        Vector::new(0.0, 0.0, -100.0),
    ] {
        let moves = NonlinearRigidMotion {
            start: Pose::from_translation(from),
            linvel: velocity,
            ..NonlinearRigidMotion::identity()
        };
        let deeper = radius * ALLOWANCE / -velocity.z;
        let still = NonlinearRigidMotion::identity();
        let hit = cast(&brep, [&still, &moves], radius, 0.1);
        stops(hit, [deeper * (1.0 - 1.0 / 32.0), deeper * (1.0 + 1e-9)]);
        let options = ShapeCastOptions {
            max_time_of_impact: 0.1,
            stop_at_penetration: false,
            ..ShapeCastOptions::default()
        };
        let d = BrepDispatcher::new();
        let pose = Pose::from_translation(from);
        let hit = d.cast_shapes(&pose, velocity, &brep, &Ball::new(radius), options);
        let hit = hit.unwrap().unwrap();
        assert_eq!(hit.time_of_impact, 0.0);
        assert_eq!(hit.status, ShapeCastStatus::PenetratingOrWithinTargetDist);
    }
    // What is apart hits when it touches.
    let gap = 1e-3;
    let moves = NonlinearRigidMotion {
        start: Pose::translation(-1.0, 0.25, radius + gap),
        linvel: Vector::new(1.0, 0.0, -1.0),
        ..NonlinearRigidMotion::identity()
    };
    let hit = cast(
        &brep,
        [&NonlinearRigidMotion::identity(), &moves],
        radius,
        0.1,
    );
    stops(hit, [gap - 1e-8, gap + 1e-12]);
    assert_eq!(brep.undecided(), 0);
}

/// A point that is to keep a distance: what it goes along at less than that is no hit, the wall is.
#[test]
fn a_point_with_a_distance() {
    let brep = floor_and_wall(8.0);
    let d = BrepDispatcher::new();
    let point = Ball::new(0.0);
    let keep = 0.25;
    for height in [0.25, 0.125, 0.25 + 1e-6] {
        let options = ShapeCastOptions {
            target_distance: keep,
            stop_at_penetration: false,
            ..ShapeCastOptions::default()
        };
        let pose = Pose::translation(-1.0, 0.0, height);
        let go = |v: Vector| d.cast_shapes(&pose, v, &brep, &point, options).unwrap();
        let hit = go(Vector::new(2.0, 0.0, 0.0)).expect("the wall");
        let expected = (5.0 - f64::min(height, keep)) / 2.0;
        let there = brep.brep().size() / f64::from(1 << 20);
        let t = hit.time_of_impact;
        assert!(
            t <= expected + 1e-12 && t >= expected - there,
            "{t} {expected}"
        );
        assert_eq!(hit.status, ShapeCastStatus::Converged);
        assert!(go(Vector::new(-2.0, 0.0, 1.0)).is_none());
    }
    assert_eq!(brep.undecided(), 0);
}

/// A wall that is just ahead, by less than numbers tell, is no overlap at the start: nobody knows.
#[test]
fn a_wall_that_may_be_ahead() {
    let brep = floor_and_wall(8.0);
    let d = BrepDispatcher::new();
    let options = ShapeCastOptions {
        stop_at_penetration: false,
        ..ShapeCastOptions::default()
    };
    let ball = Ball::new(0.5);
    for gap in [1e-7, 1e-10] {
        let pose = Pose::translation(3.5 - gap, 0.0, 0.5);
        let hit = d.cast_shapes(&pose, Vector::X, &brep, &ball, options);
        let hit = hit.unwrap().expect("the wall");
        let t = hit.time_of_impact;
        assert!(t > 0.0 && t <= gap, "{t} {gap}");
        assert_eq!(hit.status, ShapeCastStatus::Converged);
    }
    assert_eq!(brep.undecided(), 0);
    let pose = Pose::translation(3.5 - 1e-13, 0.0, 0.5);
    let hit = d.cast_shapes(&pose, Vector::X, &brep, &ball, options);
    let hit = hit.unwrap().expect("the wall");
    assert_eq!(hit.status, ShapeCastStatus::OutOfIterations, "{hit:?}");
    assert_eq!(brep.undecided(), 1);
}

/// Speeds whose squares are below all numbers are none the less speeds: what moves or turns so comes there, if it has the time.
#[test]
fn tiny_velocities() {
    let brep = floor_and_wall(8.0);
    let d = BrepDispatcher::new();
    let still = NonlinearRigidMotion::identity();
    let ball = Ball::new(0.5);
    let tiny = 1e-200;
    let ask = |plate: &NonlinearRigidMotion, moves: &NonlinearRigidMotion, until: f64| {
        d.cast_shapes_nonlinear(plate, &brep, moves, &ball, 0.0, until, true)
            .unwrap()
    };
    let above = NonlinearRigidMotion::constant_position(Pose::translation(-1.0, 0.0, 0.75));
    let falls = NonlinearRigidMotion {
        linvel: Vector::new(0.0, 0.0, -tiny),
        ..above
    };
    let hit = ask(&still, &falls, 1e201).expect("it comes down");
    let t = hit.time_of_impact * tiny;
    assert!(t <= 0.25 && t > 0.25 - 1e-9, "{t}");
    // Swung down about a centre of mass 2 beside: by a quarter of a turn at the most.
    let swings = NonlinearRigidMotion {
        local_center: Vector::new(-2.0, 0.0, 0.0),
        angvel: Vector::new(0.0, tiny, 0.0),
        ..above
    };
    let t = ask(&still, &swings, 1.0 / tiny)
        .expect("it swings down")
        .time_of_impact
        * tiny;
    let expected = (0.25f64 / 2.0).asin();
    assert!(
        t <= expected + 1e-9 && t > expected - 1e-9,
        "{t} {expected}"
    );
    // The plate turns up to it.
    let turns = NonlinearRigidMotion {
        angvel: Vector::new(0.0, tiny, 0.0),
        ..still
    };
    let t = ask(&turns, &above, 1.0 / tiny)
        .expect("it turns up")
        .time_of_impact
        * tiny;
    // The floor is turned by the angle t about y: the centre's height over it is x sin + z cos.
    let height = -t.sin() + 0.75 * t.cos();
    assert!((height - 0.5).abs() < 1e-9, "{t} {height}");
    assert_eq!(brep.undecided(), 0);
}

/// Random ways that bend, on parts, against small steps: never deeper than what is overlooked before the time that is told.
#[test]
fn random_bends_against_small_steps() {
    for (name, radii) in [
        ("ball_joint_cavity_nurbs.3dm", [0.03, 0.1]),
        ("geneva4_wheel.3dm", [0.01, 0.05]),
    ] {
        let brep = shape(part(name));
        let bounds = brep.compute_local_aabb();
        let part_of_it = if name.starts_with("ball") { 0.25 } else { 1.0 };
        let (middle, size) = (bounds.center(), bounds.half_extents() * part_of_it);
        let mut random = Random(17);
        let d = BrepDispatcher::new();
        let mut hits = 0;
        for k in 0..60 {
            let radius = random.between(radii[0], radii[1]) * size.length();
            let ball = Ball::new(radius);
            let from = middle + random.vector(1.0) * size;
            let down = random.vector(1.0).normalize();
            let pose = Pose::from_translation(from);
            let met = d.cast_shapes(&pose, down, &brep, &ball, ShapeCastOptions::default());
            let Some(met) = met.unwrap() else { continue };
            if met.status != ShapeCastStatus::Converged {
                continue;
            }
            let sunk = [0.0, 1e-3, -1e-4][k % 3] * radius;
            let start = from + down * met.time_of_impact - met.normal1 * sunk;
            let turned = Rotation::from_scaled_axis(random.vector(1.0));
            let moves = NonlinearRigidMotion {
                start: Pose::from_parts(start, turned),
                local_center: random.vector(2.0 * radius),
                linvel: random.vector(1.0) * radius * 8.0,
                angvel: random.vector(2.0),
            };
            let plate = NonlinearRigidMotion {
                local_center: middle,
                angvel: random.vector([0.0, 0.25][k % 2]),
                linvel: random.vector(radius),
                ..NonlinearRigidMotion::identity()
            };
            let gap = |t: f64| {
                let center = moves.position_at_time(t).translation;
                ball_gap(&brep, &plate.position_at_time(t), center, radius).value
            };
            let hit = cast(&brep, [&plate, &moves], radius, 1.0);
            let free = hit.map_or(1.0, |h| h.time_of_impact);
            let first = gap(0.0).min(0.0);
            let rounding = 1e-11 * brep.brep().size();
            for k in 0..=100 {
                let g = gap(free * f64::from(k) / 100.0);
                assert!(g >= first - radius * ALLOWANCE - rounding, "{g} {first}");
            }
            if let Some(hit) = hit {
                assert_eq!(hit.status, ShapeCastStatus::Converged, "{hit:?}");
                assert!(hit.time_of_impact > 0.0);
                // As deep as it may come; or in touch, if it was driven in from apart.
                let g = gap(free);
                let deep = g <= first - 0.9 * radius * ALLOWANCE;
                assert!(deep || sunk < 0.0 && g.abs() <= rounding, "{g} {hit:?}");
                hits += 1;
            }
        }
        assert!(hits > 3, "{name} {hits}");
        assert_eq!(brep.undecided(), 0);
    }
}

fn world(plate: &BrepShape) -> PhysicsWorld {
    use parry3d_f64::query::DefaultQueryDispatcher;
    let mut w = PhysicsWorld::new();
    w.narrow_phase
        .set_query_dispatcher(BrepDispatcher::new().chain(DefaultQueryDispatcher));
    w.gravity = WorldVector::new(0.0, 0.0, -9.81);
    w.integration_parameters.contact_recycling = false;
    w.integration_parameters.contact_clustering = false;
    let ground = w.insert_body(RigidBodyBuilder::fixed());
    let collider = ColliderBuilder::new(SharedShape::new(plate.clone()));
    w.insert_collider(collider.friction(0.0), Some(ground));
    w
}

/// A floor at z = 0, and a wall of a hundredth on it at x = 4.
fn thin_wall() -> BrepShape {
    let profile = [
        [-8.0, -1.0],
        [16.0, -1.0],
        [16.0, 0.0],
        [4.0, 0.0],
        [4.0, 1.0],
        [3.99, 1.0],
        [3.99, 0.0],
        [-8.0, 0.0],
    ];
    shape(prism(&profile, [-2.0, 2.0]))
}

/// In Rapier: a pair of balls on a rod slides along the floor, turning about the upright axis, and does not pass the thin wall.
#[test]
fn a_fast_pair_of_balls_does_not_tunnel() {
    let plate = thin_wall();
    for spin in [0.0, 6.0, 30.0] {
        let mut w = world(&plate);
        let body = RigidBodyBuilder::dynamic()
            .translation(WorldVector::new(-2.0, 0.0, 0.1))
            .linvel(WorldVector::new(200.0, 0.0, 0.0))
            .angvel(WorldVector::new(0.0, 0.0, spin))
            .ccd_enabled(true);
        let b = w.insert_body(body);
        for y in [-0.3, 0.3] {
            let ball = ColliderBuilder::ball(0.1).translation(WorldVector::new(0.0, y, 0.0));
            w.insert_collider(ball.friction(0.0), Some(b));
        }
        let mut farthest = f64::NEG_INFINITY;
        for _ in 0..30 {
            w.step();
            farthest = farthest.max(w.bodies[b].translation().x);
        }
        assert!(farthest > 3.5 && farthest < 4.0, "{spin} {farthest}");
    }
}

/// In Rapier: contacts too soft to stop a ball that is shot into the floor; casts do, and the wall stops it, too.
#[test]
fn a_fast_ball_that_is_driven_in_does_not_tunnel() {
    let plate = thin_wall();
    let mut w = world(&plate);
    w.integration_parameters.contact_softness = SpringCoefficients {
        natural_frequency: 0.5,
        damping_ratio: 1.0,
    };
    w.integration_parameters.static_contact_softness = w.integration_parameters.contact_softness;
    let body = RigidBodyBuilder::dynamic()
        .translation(WorldVector::new(-2.0, 0.0, 0.0999))
        .linvel(WorldVector::new(100.0, 0.0, -20.0))
        .ccd_enabled(true);
    let b = w.insert_body(body);
    w.insert_collider(ColliderBuilder::ball(0.1).friction(0.0), Some(b));
    let (mut farthest, mut lowest) = (f64::NEG_INFINITY, f64::INFINITY);
    for _ in 0..60 {
        w.step();
        let at = w.bodies[b].translation();
        (farthest, lowest) = (farthest.max(at.x), lowest.min(at.z));
    }
    assert!(farthest < 4.0, "{farthest}");
    assert!(lowest > 0.0, "{lowest}");
}
