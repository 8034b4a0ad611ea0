//! Casts of balls that touch a BREP at the start, and leave it there or roll along it: what else of it is in the way.

use crate::scenes::{Random, floor_and_wall, part, prism, shape, torus};
use feeler_rapier::{BrepDispatcher, BrepShape};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::details::ShapeCastOptions;
use parry3d_f64::query::{NonlinearRigidMotion, QueryDispatcher, ShapeCastHit, ShapeCastStatus};
use parry3d_f64::shape::{Ball, Shape};
use rapier3d_f64::prelude::{
    ColliderBuilder, PhysicsWorld, RigidBodyBuilder, SharedShape, Vector as WorldVector,
};

/// How exactly such a cast is promised, in sizes of the BREP.
const THERE: f64 = 1.0 / (1u64 << 20) as f64;

/// Contacts at the start that are left do not count.
fn leaving(until: f64) -> ShapeCastOptions {
    ShapeCastOptions {
        max_time_of_impact: until,
        stop_at_penetration: false,
        ..ShapeCastOptions::default()
    }
}

/// Casts in both orders, from a turned and moved frame, and as Rapier does.
fn cast(
    brep: &BrepShape,
    from: [f64; 3],
    velocity: [f64; 3],
    radius: f64,
    until: f64,
) -> Option<ShapeCastHit> {
    let d = BrepDispatcher::new();
    let ball = Ball::new(radius);
    let (from, velocity) = (Vector::from_array(from), Vector::from_array(velocity));
    let pose = Pose::from_translation(from);
    let one = d
        .cast_shapes(&pose, velocity, brep, &ball, leaving(until))
        .unwrap();
    // The BREP in the frame of a ball that is turned.
    let turned = Rotation::from_axis_angle(Vector::new(0.6, 0.0, 0.8), 0.7);
    let other = Pose::from_parts(from, turned).inverse();
    let own = turned.inverse() * velocity;
    let two = d
        .cast_shapes(&other, -own, &ball, brep, leaving(until))
        .unwrap();
    let still = NonlinearRigidMotion::constant_position(Pose::IDENTITY);
    let moves = NonlinearRigidMotion {
        start: pose,
        linvel: velocity,
        angvel: Vector::new(3.0, -2.0, 1.0),
        ..NonlinearRigidMotion::identity()
    };
    let three = d
        .cast_shapes_nonlinear(&moves, &ball, &still, brep, 0.0, until, false)
        .unwrap();
    let there = 2.0 * THERE * brep.brep().size() / velocity.length();
    for other in [&two, &three] {
        assert_eq!(one.is_some(), other.is_some(), "{one:?} {other:?}");
        if let (Some(a), Some(b)) = (&one, other) {
            let off = (a.time_of_impact - b.time_of_impact).abs();
            assert!(off <= there, "{a:?} {b:?}");
        }
    }
    one
}

/// It is stopped there: no later, and no earlier than promised.
#[track_caller]
fn stops(hit: Option<ShapeCastHit>, brep: &BrepShape, speed: f64, time: f64, normal: [f64; 3]) {
    let hit = hit.expect("a wall is in the way");
    let early = THERE * brep.brep().size() / speed;
    let t = hit.time_of_impact;
    assert!(t <= time + 1e-12 && t >= time - early, "{t} {time}");
    assert_eq!(hit.status, ShapeCastStatus::Converged);
    let normal = Vector::from_array(normal);
    // The place of the touch is known to the root of the time.
    assert!((hit.normal1 - normal).length() < 1e-2, "{hit:?}");
}

const FOREVER: f64 = f64::MAX;

/// On the floor, sunk into it by what a solver leaves, or just above it: whichever way it goes, the wall stops it.
#[test]
fn a_ball_that_rolls_along_a_floor_is_stopped_by_the_wall() {
    let brep = floor_and_wall(2.0);
    let radius = 0.5;
    for sunk in [0.0, 1e-4, 1e-3, -1e-13, -1e-5] {
        let from = [-1.0, 0.25, radius - sunk];
        for [x, y, z] in [
            [1.0, 0.0, 0.0],
            [2.0, 0.25, 0.0],
            [1.0, 0.0, 0.125],
            [300.0, -1.0, 0.0],
        ] {
            for until in [FOREVER, 8.0 / x] {
                let hit = cast(&brep, from, [x, y, z], radius, until);
                let speed = Vector::new(x, y, z).length();
                // The wall counts from where the ball is as deep in it as in the floor.
                let time = (4.0 - radius + sunk.max(0.0) + 1.0) / x;
                stops(hit, &brep, speed, time, [-1.0, 0.0, 0.0]);
            }
            // Not before the time is up, nor where there is none.
            assert!(cast(&brep, from, [x, y, z], radius, 4.0 / x).is_none());
            assert!(cast(&brep, from, [-x, y, z], radius, FOREVER).is_none());
        }
        // Up, it never comes back; over the wall neither.
        assert!(cast(&brep, from, [0.0, 0.0, 1.0], radius, FOREVER).is_none());
        assert!(cast(&brep, from, [1.0, 0.0, 1.0], radius, FOREVER).is_none());
    }
    assert_eq!(brep.undecided(), 0);
}

/// What a solver leaves of the velocity into the floor is no arrival, if the ball sinks by less than is overlooked while it is asked about.
#[test]
fn a_velocity_into_the_floor_by_rounding_is_overlooked() {
    let brep = floor_and_wall(2.0);
    let hit = cast(&brep, [-1.0, 0.25, 0.499], [100.0, 0.0, -1e-3], 0.5, 0.1);
    // From the wall 5 - 1e-3 - 0.5 + 1e-3 away.
    stops(hit, &brep, 100.0, 0.045 + 1e-5, [-1.0, 0.0, 0.0]);
}

/// In the concave edge the ball touches both faces: away from both, along the edge, and along either up to a ramp.
#[test]
fn a_ball_at_a_concave_edge() {
    // As above, with a ramp of 3 in 4 from x = -4 up to the left.
    let profile = [
        [-8.0, -1.0],
        [5.0, -1.0],
        [5.0, 3.0],
        [4.0, 3.0],
        [4.0, 0.0],
        [-4.0, 0.0],
        [-8.0, 3.0],
    ];
    let brep = shape(prism(&profile, [-2.0, 2.0]));
    let radius = 0.5;
    for sunk in [0.0, 1e-3] {
        let from = [4.0 - radius + sunk, 0.0, radius - sunk];
        assert!(cast(&brep, from, [0.0, 1.0, 0.0], radius, FOREVER).is_none());
        assert!(cast(&brep, from, [-1.0, 0.0, 1.0], radius, 0.5).is_none());
        // The ball as it counts, of radius r - sunk: its centre is at that height, so that it meets the ramp where its distance from
        // the ramp's line is as large: 0.6 (x + 4) + 0.8 z = r - sunk.
        let counts = radius - sunk;
        let time = from[0] + 4.0 - 0.2 * counts / 0.6;
        let hit = cast(&brep, from, [-1.0, 0.0, 0.0], radius, FOREVER);
        stops(hit, &brep, 1.0, time, [0.6, 0.0, 0.8]);
        // Up along the wall: it is over at its end.
        assert!(cast(&brep, from, [0.0, 0.0, 1.0], radius, FOREVER).is_none());
    }
    assert_eq!(brep.undecided(), 0);
}

/// In the groove of a torus, seen from within: along a tangent the ball comes into the outer flank, deeper and deeper, and is stopped while
/// it is no deeper than is overlooked; away from it, it is stopped where the tube is on the other side.
#[test]
fn a_ball_in_the_groove_of_a_torus() {
    let (major, minor, radius) = (3.0, 1.0, 0.5);
    let brep = shape(torus(major, minor));
    let separation = |p: Vector| minor - (p.x.hypot(p.y) - major).hypot(p.z) - radius;
    // At the lowest line, in touch.
    let from = [major, 0.0, radius - minor];
    let hit = cast(&brep, from, [0.0, 1.0, 0.0], radius, FOREVER).unwrap();
    let at = Vector::from_array(from) + Vector::Y * hit.time_of_impact;
    let depth = -separation(at);
    assert!(hit.time_of_impact > 0.1, "{hit:?}");
    assert!(depth >= 0.0 && depth <= radius / 128.0, "{depth}");
    // Across, to the other side of the tube.
    let hit = cast(&brep, from, [0.0, 0.0, 1.0], radius, FOREVER);
    stops(hit, &brep, 1.0, 2.0 * (minor - radius), [0.0, 0.0, -1.0]);
    assert_eq!(brep.undecided(), 0);
}

/// Two faces in one plane: the edge between them is no wall.
#[test]
fn a_seam_of_two_faces_in_a_plane_is_no_wall() {
    let profile = [
        [-8.0, -1.0],
        [5.0, -1.0],
        [5.0, 3.0],
        [4.0, 3.0],
        [4.0, 0.0],
        [0.0, 0.0],
        [-8.0, 0.0],
    ];
    let brep = shape(prism(&profile, [-2.0, 2.0]));
    for sunk in [0.0, 1e-3] {
        let hit = cast(&brep, [-1.0, 0.25, 0.5 - sunk], [1.0, 0.0, 0.0], 0.5, 9.0);
        stops(hit, &brep, 1.0, 4.5 + sunk, [-1.0, 0.0, 0.0]);
    }
}

/// Random ways of balls that were brought down onto a BREP, into its box of `size` about `middle`, against small steps: never deeper than what is overlooked before
/// the time that is told, and at that time as deep as at the start. How many of a hundred hit; `FEELER_WAYS=50` tries as many times more.
fn against_small_steps(
    brep: &BrepShape,
    [middle, size]: [Vector; 2],
    radii: [f64; 2],
    (seed, count): (u64, usize),
) -> usize {
    let more = std::env::var("FEELER_WAYS").ok();
    let more = more.and_then(|x| x.parse().ok()).unwrap_or(1);
    let mut random = Random(seed);
    let d = BrepDispatcher::new();
    let mut hits = 0;
    for _ in 0..count * more {
        let radius = random.between(radii[0], radii[1]);
        let ball = Ball::new(radius);
        let from = middle + random.vector(1.0) * size;
        let options = ShapeCastOptions::default();
        let down = random.vector(1.0).normalize();
        let pose = Pose::from_translation(from);
        let met = d.cast_shapes(&pose, down, brep, &ball, options).unwrap();
        let Some(met) = met.filter(|m| m.status == ShapeCastStatus::Converged) else {
            continue;
        };
        let sunk = [0.0, 1e-3, -1e-4][(random.between(0.0, 3.0)) as usize] * radius;
        let start = from + down * met.time_of_impact - met.normal1 * sunk;
        // Along it, away, or a little into it.
        let free = random.vector(1.0);
        let out = free.dot(met.normal1);
        let kept = [0.0, out.max(0.0), -1e-8][(random.between(0.0, 3.0)) as usize];
        let velocity = (free - met.normal1 * (out - kept)).normalize();
        let until = random.between(0.0, 2.0) * size.length();
        let gap = |t: f64| {
            let pose = Pose::from_translation(start + velocity * t);
            let found = d.contact(&pose, brep, &ball, f64::INFINITY).unwrap();
            found.unwrap().dist
        };
        let first = gap(0.0).min(0.0);
        let pose = Pose::from_translation(start);
        let hit = d.cast_shapes(&pose, velocity, brep, &ball, leaving(until));
        let hit = hit.unwrap();
        let free = hit.map_or(until, |h| h.time_of_impact);
        let rounding = 1e-11 * brep.brep().size();
        for k in 0..=100 {
            let g = gap(free * f64::from(k) / 100.0);
            assert!(g >= first - radius / 128.0 - rounding, "{g} {first}");
        }
        if let Some(hit) = hit {
            assert_eq!(hit.status, ShapeCastStatus::Converged, "{hit:?}");
            let there = THERE * brep.brep().size();
            let soonest = (0..=32).map(|k| gap(free + 2.0 * there * f64::from(k) / 32.0));
            let g = soonest.fold(f64::INFINITY, f64::min);
            assert!(g <= first + 0.1 * there, "{g} {first} {hit:?}");
            hits += 1;
        }
    }
    assert_eq!(brep.undecided(), 0);
    100 * hits / (count * more)
}

#[test]
fn random_ways_against_small_steps() {
    let profile = [
        [-4.0, -1.0],
        [4.0, -1.0],
        [4.0, 2.0],
        [3.0, 2.0],
        [2.5, 0.125],
        [1.0, 0.0],
        [0.5, 0.5],
        [0.0, 0.0],
        [-3.0, 0.0],
        [-3.5, 2.0],
        [-4.0, 2.0],
    ];
    let brep = shape(prism(&profile, [-2.0, 2.0]));
    let room = [Vector::new(0.0, 0.0, 2.0), Vector::new(2.5, 1.5, 0.5)];
    let hits = against_small_steps(&brep, room, [0.1, 0.4], (11, 100));
    assert!(hits > 10, "{hits}");
    let tube = shape(torus(3.0, 1.0));
    let room = [Vector::ZERO, Vector::new(3.0, 3.0, 0.5)];
    let hits = against_small_steps(&tube, room, [0.1, 0.6], (12, 50));
    assert!(hits > 20, "{hits}");
}

#[test]
fn random_ways_on_parts_against_small_steps() {
    for (name, radii) in [
        ("ball_joint_cavity_nurbs.3dm", [0.03, 0.1]),
        ("shift_gate_nurbs.3dm", [0.01, 0.05]),
        ("geneva4_wheel.3dm", [0.01, 0.05]),
        ("sheet_trimmed_nurbs.3dm", [0.01, 0.05]),
    ] {
        let brep = shape(part(name));
        let bounds = brep.compute_local_aabb();
        let room = [bounds.center(), bounds.half_extents()];
        // Into the socket.
        let part_of_it = if name.starts_with("ball") { 0.25 } else { 1.0 };
        let room = [room[0], room[1] * part_of_it];
        let radii = radii.map(|r| r * room[1].length());
        let hits = against_small_steps(&brep, room, radii, (13, 40));
        assert!(hits > 1, "{name} {hits}");
    }
}

/// In Rapier: a fast ball that rolls on a floor does not pass the thin wall on it.
#[test]
fn a_fast_ball_that_rolls_does_not_tunnel() {
    let profile = [
        [-8.0, -1.0],
        [8.0, -1.0],
        [8.0, 0.0],
        [4.0, 0.0],
        [4.0, 1.0],
        [3.99, 1.0],
        [3.99, 0.0],
        [-8.0, 0.0],
    ];
    let plate = shape(prism(&profile, [-2.0, 2.0]));
    for (speed, dt) in [
        (200.0, 1.0 / 60.0),
        (1000.0, 1.0 / 240.0),
        (30.0, 1.0 / 60.0),
    ] {
        let mut w = PhysicsWorld::new();
        use parry3d_f64::query::DefaultQueryDispatcher;
        w.narrow_phase
            .set_query_dispatcher(BrepDispatcher::new().chain(DefaultQueryDispatcher));
        w.gravity = WorldVector::new(0.0, 0.0, -9.81);
        w.integration_parameters.dt = dt;
        w.integration_parameters.contact_recycling = false;
        w.integration_parameters.contact_clustering = false;
        let ground = w.insert_body(RigidBodyBuilder::fixed());
        w.insert_collider(
            ColliderBuilder::new(SharedShape::new(plate.clone())).friction(0.5),
            Some(ground),
        );
        let body = RigidBodyBuilder::dynamic()
            .translation(WorldVector::new(-2.0, 0.0, 0.1))
            .linvel(WorldVector::new(speed, 0.0, 0.0))
            .ccd_enabled(true);
        let b = w.insert_body(body);
        w.insert_collider(ColliderBuilder::ball(0.1).friction(0.5), Some(b));
        let mut farthest = f64::NEG_INFINITY;
        for _ in 0..60 {
            w.step();
            farthest = farthest.max(w.bodies[b].translation().x);
        }
        // It comes there, and no farther than what Rapier lets it overlap.
        assert!(farthest > 3.8 && farthest < 3.9, "{speed} {farthest}");
    }
}
