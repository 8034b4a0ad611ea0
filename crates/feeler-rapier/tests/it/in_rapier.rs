//! In Rapier's own loop.

use crate::scenes::{block, cube, part, shape};
use feeler_rapier::{BrepDispatcher, BrepShape, ball_gap};
use parry3d_f64::query::{DefaultQueryDispatcher, QueryDispatcher};
use parry3d_f64::shape::HalfSpace;
use rapier3d_f64::prelude::*;

/// Gravity along z; nothing of earlier steps is taken for a contact of this one (see the crate's documentation).
fn world(gravity: f64, unit: f64) -> PhysicsWorld {
    let mut w = PhysicsWorld::new();
    w.narrow_phase
        .set_query_dispatcher(BrepDispatcher::new().chain(DefaultQueryDispatcher));
    w.gravity = Vector::new(0.0, 0.0, -gravity);
    w.integration_parameters.length_unit = unit;
    w.integration_parameters.contact_recycling = false;
    w.integration_parameters.contact_clustering = false;
    w
}

fn fixed(w: &mut PhysicsWorld, brep: &BrepShape) -> ColliderHandle {
    let body = w.insert_body(RigidBodyBuilder::fixed());
    let collider = ColliderBuilder::new(SharedShape::new(brep.clone())).friction(0.5);
    w.insert_collider(collider, Some(body))
}

fn ball(w: &mut PhysicsWorld, at: [f64; 3], radius: f64) -> RigidBodyHandle {
    let body = w.insert_body(RigidBodyBuilder::dynamic().translation(at.into()));
    w.insert_collider(ColliderBuilder::ball(radius).friction(0.5), Some(body));
    body
}

#[test]
fn a_ball_settles_on_a_plate_and_sleeps() {
    let mut w = world(9.81, 1.0);
    let plate = shape(block([-5.0, -5.0, -1.0], [5.0, 5.0, 0.0]));
    fixed(&mut w, &plate);
    let b = ball(&mut w, [0.3, 0.2, 1.0], 0.5);
    for _ in 0..600 {
        w.step();
    }
    let body = &w.bodies[b];
    let at = body.translation();
    let gap = ball_gap(&plate, &Pose::IDENTITY, at, 0.5);
    // Rapier's slop is 0.005 of the length unit.
    assert!(gap.value > -0.0051 && gap.value < 1e-3, "{gap:?}");
    assert!(
        (at.x - 0.3).abs() < 1e-9 && (at.y - 0.2).abs() < 1e-9,
        "{at:?}"
    );
    assert!(body.is_sleeping());
    assert_eq!(plate.undecided(), 0);
}

/// Kinetic and potential energy.
fn energy(w: &PhysicsWorld, b: RigidBodyHandle) -> f64 {
    let body = &w.bodies[b];
    body.kinetic_energy() - body.mass() * w.gravity.z * body.translation().z
}

/// A fifth of a second of a ball that rolls in the hole of radius 2.5 about the origin (a NURBS): the most energy that is gained,
/// relative to that at the start. All else is checked here.
fn roll(dt: f64) -> f64 {
    let gravity = 9810.0;
    let mut w = world(gravity, 0.5);
    w.integration_parameters.dt = dt;
    w.integration_parameters.contact_softness.natural_frequency = 2000.0;
    w.integration_parameters
        .static_contact_softness
        .natural_frequency = 2000.0;
    w.integration_parameters.normalized_allowed_linear_error = 1e-6;
    let socket = shape(part("ball_joint_cavity_nurbs.3dm"));
    fixed(&mut w, &socket);
    let radius = 0.5;
    let tilt: f64 = 0.3;
    let away = 2.5 - radius;
    let at = [away * tilt.sin(), 0.0, -away * tilt.cos()];
    let b = ball(&mut w, at, radius);
    let bottom = w.bodies[b].mass() * gravity * away;
    let start = energy(&w, b) + bottom;
    let (mut jump, mut most) = (0.0f64, f64::NEG_INFINITY);
    let mut crossings = Vec::new();
    let mut before = (w.bodies[b].linvel(), at[0]);
    for k in 0..(0.2 / dt) as usize {
        w.step();
        let (at, v) = (w.bodies[b].translation(), w.bodies[b].linvel());
        let gap = away - at.length();
        assert!(gap.abs() < 1e-3, "{gap}");
        jump = jump.max((v - before.0).length() / (gravity * dt));
        if before.1.signum() != at.x.signum() {
            crossings.push(k as f64);
        }
        before = (v, at.x);
        most = most.max(energy(&w, b) + bottom);
    }
    // No bump: no step changes the velocity by more than the way down does at the steepest, 5/7 sin tilt (the normal's
    // share, v^2 / away, is below that here).
    let steepest = 5.0 / 7.0 * tilt.sin();
    assert!((jump / steepest - 1.0).abs() < 0.02, "{jump} {steepest}");
    // The period of a ball that rolls without slipping in a bowl, to the second order of the angle.
    let slow = (1.4 * away / gravity).sqrt();
    let period = std::f64::consts::TAU * slow * (1.0 + tilt * tilt / 16.0);
    let halves = (crossings.len() - 1) as f64;
    let measured = 2.0 * dt * (crossings[crossings.len() - 1] - crossings[0]) / halves;
    assert!(
        (measured / period - 1.0).abs() < 0.01,
        "{measured} {period}"
    );
    assert_eq!(socket.undecided(), 0);
    most / start - 1.0
}

/// What energy is gained is that of the engine's time steps: it goes with them.
#[test]
fn a_ball_rolls_in_a_spherical_socket() {
    let (coarse, fine) = (roll(1e-4), roll(2.5e-5));
    assert!(coarse < 0.05, "{coarse}");
    assert!(fine < 0.5 * coarse, "{fine} {coarse}");
}

#[test]
fn a_brep_falls_flat_on_the_ground_and_turns_as_it_should() {
    let mut w = world(9.81, 1.0);
    let ground = w.insert_body(RigidBodyBuilder::fixed());
    let plane = ColliderBuilder::new(SharedShape::new(HalfSpace::new(Vector::Z))).friction(0.5);
    w.insert_collider(plane, Some(ground));
    let brep = shape(cube());
    let body = RigidBodyBuilder::dynamic()
        .translation(Vector::new(0.0, 0.0, 0.5))
        .rotation(Vector::new(0.4, 0.3, 0.0));
    let body = w.insert_body(body);
    w.insert_collider(
        ColliderBuilder::new(SharedShape::new(brep)).density(2.0),
        Some(body),
    );
    for _ in 0..900 {
        w.step();
    }
    let b = &w.bodies[body];
    assert!((b.mass() - 2.0).abs() < 1e-9);
    let com = b.center_of_mass();
    assert!((com.z - 0.5).abs() < 0.01, "{com:?}");
    assert!(b.linvel().length() < 1e-2 && b.angvel().length() < 1e-2);
    // Some face is down: one axis of the cube is upright.
    let up = b.rotation().inverse() * Vector::Z;
    assert!(up.abs().max_element() > 0.9999, "{up:?}");
}

#[test]
fn fast_balls_do_not_tunnel_with_ccd() {
    let mut w = world(0.0, 1.0);
    let plate = shape(block([-5.0, -5.0, -0.01], [5.0, 5.0, 0.0]));
    fixed(&mut w, &plate);
    let body = RigidBodyBuilder::dynamic()
        .translation(Vector::new(0.0, 0.0, 2.0))
        .linvel(Vector::new(1.0, 0.0, -300.0))
        .ccd_enabled(true);
    let b = w.insert_body(body);
    w.insert_collider(ColliderBuilder::ball(0.1), Some(b));
    for _ in 0..10 {
        w.step();
    }
    assert!(
        w.bodies[b].translation().z > 0.0,
        "{:?}",
        w.bodies[b].translation()
    );
}

/// Nothing but balls is cast: that Rapier does not stop a fast box is said.
#[test]
fn that_other_fast_shapes_are_not_stopped_is_said() {
    let mut w = world(0.0, 1.0);
    let d = BrepDispatcher::with_report(|_| ());
    w.narrow_phase
        .set_query_dispatcher(d.clone().chain(DefaultQueryDispatcher));
    fixed(&mut w, &shape(block([-5.0, -5.0, -0.01], [5.0, 5.0, 0.0])));
    for collider in [
        ColliderBuilder::cuboid(0.1, 0.1, 0.1),
        ColliderBuilder::capsule_z(0.1, 0.1),
    ] {
        let body = RigidBodyBuilder::dynamic()
            .translation(Vector::new(0.0, 0.0, 2.0))
            .linvel(Vector::new(1.0, 0.0, -300.0))
            .ccd_enabled(true);
        let b = w.insert_body(body);
        w.insert_collider(collider, Some(b));
        w.step();
        w.remove_body(b);
    }
    let said: Vec<_> = d
        .unsupported()
        .into_iter()
        .map(|u| (u.query, u.other))
        .collect();
    let expected = ["Capsule", "Cuboid"].map(|s| ("nonlinear shape cast", s.to_owned()));
    assert_eq!(said, expected);
}

#[test]
fn two_runs_have_the_same_bits() {
    let run = || {
        let mut w = world(9810.0, 0.5);
        w.integration_parameters.dt = 1e-3;
        let socket = shape(part("ball_joint_cavity_nurbs.3dm"));
        fixed(&mut w, &socket);
        let at = [[0.5, 0.2, -1.0], [-0.6, 0.1, -0.9], [0.1, -0.7, -0.2]];
        let balls = at.map(|at| ball(&mut w, at, 0.4));
        for _ in 0..200 {
            w.step();
        }
        balls.map(|b| w.bodies[b].translation().to_array().map(f64::to_bits))
    };
    assert_eq!(run(), run());
}
