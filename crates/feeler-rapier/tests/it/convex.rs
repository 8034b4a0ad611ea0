//! Cuboids and convex polyhedra against closed forms and against Parry's own answers for two cuboids.

use crate::scenes::{Random, block, cube, part, shape};
use feeler::query::Undecided;
use feeler_rapier::{BrepDispatcher, BrepShape, PairAnswer};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::{DefaultQueryDispatcher, QueryDispatcher, distance};
use parry3d_f64::shape::{
    Cone, ConvexPolyhedron, Cuboid, Cylinder, RoundCuboid, RoundCylinder, Shape, SharedShape,
    Triangle,
};
use rapier3d_f64::prelude::{ColliderBuilder, PhysicsWorld, RigidBodyBuilder};

/// Asks in both orders; the answers must be the same to rounding.
fn ask(brep: &BrepShape, other: &dyn Shape, pose: &Pose) -> PairAnswer {
    let d = BrepDispatcher::new();
    let first = d.pair(pose, brep, other, 10.0).unwrap();
    let second = d.pair(&pose.inverse(), other, brep, 10.0).unwrap();
    let (a, b) = (first.separation, second.separation);
    assert!(
        a.bounds.lo <= b.bounds.hi && b.bounds.lo <= a.bounds.hi,
        "{a:?} {b:?}"
    );
    assert!(a.bounds.contains(a.value), "{a:?}");
    first
}

/// The truth within the bounds, and these no wider.
#[track_caller]
fn is(answer: &PairAnswer, truth: f64, widest: f64) {
    let b = answer.separation.bounds;
    assert!(
        b.lo - 1e-13 <= truth && truth <= b.hi + 1e-13,
        "{b:?} {truth}"
    );
    assert!(b.width() <= widest, "{b:?}");
}

#[test]
fn faces_edges_and_corners() {
    let brep = shape(cube());
    let half = Vector::new(0.25, 0.375, 0.125);
    let cuboid = Cuboid::new(half);
    // A face on a face, apart and in touch; a larger face, whose corners are all beside the cube.
    for height in [0.5, 0.0, -0.0625] {
        let pose = Pose::translation(0.5, 0.5, 1.0 + half.z + height);
        let answer = ask(&brep, &cuboid, &pose);
        is(&answer, height, 1e-10);
        let down: Vec<_> = answer
            .contacts
            .iter()
            .filter(|c| c.normal == Vector::Z)
            .collect();
        assert!(down.len() >= 4, "{answer:?}");
        let plate = Cuboid::new(Vector::new(3.0, 2.0, 0.125));
        let answer = ask(&brep, &plate, &pose);
        is(&answer, height, 1e-10);
        // The cube's four upper corners are in it, or as near.
        let corner = |x: f64, y: f64| {
            let at = Vector::new(x, y, 1.0);
            answer.contacts.iter().any(|c| {
                (c.on_brep - at).length() < 1e-9 && (c.separation.value - height).abs() < 1e-12
            })
        };
        for (x, y) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)] {
            assert!(corner(x, y), "{height} {answer:?}");
        }
    }
    // A corner above a face.
    let corner = Rotation::from_rotation_arc(Vector::splat(1.0 / 3f64.sqrt()), -Vector::Z);
    let pose = Pose::from_parts(Vector::new(0.5, 0.5, 2.0), corner);
    let unit = Cuboid::new(Vector::splat(0.25));
    is(&ask(&brep, &unit, &pose), 1.0 - 0.25 * 3f64.sqrt(), 1e-10);
    // An edge above a face, and across an edge.
    let edge = Rotation::from_axis_angle(Vector::X, std::f64::consts::FRAC_PI_4);
    let pose = Pose::from_parts(Vector::new(0.5, 0.5, 2.0), edge);
    is(&ask(&brep, &unit, &pose), 1.0 - 0.25 * 2f64.sqrt(), 1e-10);
    let crossed = Rotation::from_axis_angle(Vector::Z, std::f64::consts::FRAC_PI_2) * edge;
    let out = Vector::new(0.0, 1.0, 1.0) / 2f64.sqrt();
    let turned = Rotation::from_rotation_arc(Vector::Z, out);
    let pose = Pose::from_parts(Vector::new(0.5, 1.0, 1.0) + out, turned * crossed);
    is(&ask(&brep, &unit, &pose), 1.0 - 0.25 * 2f64.sqrt(), 1e-6);
}

/// A box without height has no inside: what is in its plane beside it is not in it.
#[test]
fn a_flat_box_beside_a_cube() {
    let brep = shape(cube());
    for (gap, height) in [(0.2, 0.5), (0.2, 1.25), (0.0625, 0.0)] {
        let flat = Cuboid::new(Vector::new(1.0, 1.0, 0.0));
        let answer = ask(&brep, &flat, &Pose::translation(2.0 + gap, 0.5, height));
        let above: f64 = f64::max(height - 1.0, 0.0);
        is(&answer, gap.hypot(above), 1.0);
    }
}

#[test]
fn two_cuboids_are_as_far_apart_as_parry_says() {
    /// Parry's distances of cuboids are right to about this.
    const PARRY: f64 = 1e-6;
    let mut random = Random(41);
    let brep = shape(block([-0.5; 3], [0.5; 3]));
    let same = Cuboid::new(Vector::splat(0.5));
    let mut widths = Vec::new();
    for _ in 0..150 {
        let half = random.vector(0.4).abs() + Vector::splat(0.1);
        let other = Cuboid::new(half);
        let pose = random.pose(2.0);
        let truth = distance(&Pose::IDENTITY, &same, &pose, &other);
        let truth = truth.unwrap().distance;
        if truth == 0.0 {
            continue;
        }
        let b = ask(&brep, &other, &pose).separation.bounds;
        assert!(
            b.lo <= truth + PARRY && truth - PARRY <= b.hi,
            "{b:?} {truth}"
        );
        widths.push(b.width());
    }
    widths.sort_by(f64::total_cmp);
    assert!(widths.len() > 50);
    assert!(widths[widths.len() / 2] < 1e-6, "{widths:?}");
}

#[test]
fn a_round_face_and_other_polyhedra() {
    // A ball of the corpora, about the origin.
    let brep = shape(part("ball.3dm"));
    let radius = brep.brep().size() / 2.0;
    let cuboid = Cuboid::new(Vector::new(2.0, 3.0, 0.5));
    for gap in [0.25, -0.015625] {
        let pose = Pose::translation(0.1, -0.2, -(radius + 0.5 + gap));
        is(&ask(&brep, &cuboid, &pose), gap, 1e-6);
        let round = RoundCuboid {
            inner_shape: Cuboid::new(Vector::new(2.0, 3.0, 0.375)),
            border_radius: 0.125,
        };
        is(&ask(&brep, &round, &pose), gap, 1e-6);
    }
    // An octahedron's corner over a face, and a triangle's side beside an edge.
    let cube = shape(cube());
    let corners: Vec<Vector> = [Vector::X, Vector::Y, Vector::Z]
        .into_iter()
        .flat_map(|v| [v, -v])
        .collect();
    let octahedron = ConvexPolyhedron::from_convex_hull(&corners).unwrap();
    let pose = Pose::translation(0.375, 0.5, 2.25);
    is(&ask(&cube, &octahedron, &pose), 0.25, 1e-10);
    let triangle = Triangle::new(
        Vector::new(-1.0, 0.0, 0.0),
        Vector::new(1.0, 0.0, 0.0),
        Vector::new(0.0, 3.0, 4.0),
    );
    let pose = Pose::translation(0.5, 1.75, 2.0);
    is(&ask(&cube, &triangle, &pose), 1.25, 1e-6);
}

/// In a hole no plane parts the two: the bounds hold all the same, and say that they are wide.
#[test]
fn in_a_hole() {
    let brep = shape(part("ball_joint_cavity.3dm"));
    let half = 1.25;
    let cuboid = Cuboid::new(Vector::splat(half));
    let answer = ask(&brep, &cuboid, &Pose::IDENTITY);
    is(&answer, 2.5 - half * 3f64.sqrt(), 2.0 * half * 3f64.sqrt());
    // The corners, all as near.
    let near = |c: &feeler_rapier::PairContact| {
        (c.separation.value - (2.5 - half * 3f64.sqrt())).abs() < 1e-9
    };
    assert_eq!(answer.contacts.iter().filter(|c| near(c)).count(), 8);
}

#[test]
fn a_cuboid_comes_to_rest_and_sleeps() {
    let mut w = PhysicsWorld::new();
    w.narrow_phase
        .set_query_dispatcher(BrepDispatcher::new().chain(DefaultQueryDispatcher));
    w.gravity = Vector::new(0.0, 0.0, -9.81);
    w.integration_parameters.contact_recycling = false;
    let ground = w.insert_body(RigidBodyBuilder::fixed());
    let plate = shape(block([-5.0, -5.0, -1.0], [5.0, 5.0, 0.0]));
    let plate = ColliderBuilder::new(SharedShape::new(plate)).friction(0.5);
    w.insert_collider(plate, Some(ground));
    let tilt = Rotation::from_axis_angle(Vector::X, 0.3);
    let own = RigidBodyBuilder::dynamic().pose(Pose::from_parts(Vector::new(0.2, 0.1, 1.0), tilt));
    let own = w.insert_body(own);
    w.insert_collider(
        ColliderBuilder::cuboid(0.5, 0.4, 0.25).friction(0.5),
        Some(own),
    );
    for _ in 0..600 {
        w.step();
    }
    let body = &w.bodies[own];
    let up = body.position().transform_vector(Vector::Z);
    assert!(up.z > 1.0 - 1e-6, "{up:?}");
    // Rapier's slop is 0.005 of the length unit.
    let height = body.translation().z - 0.25;
    assert!(height > -0.006 && height < 1e-3, "{height}");
    assert!(body.is_sleeping());
}

/// A cuboid whose sides are flush with the BREP's: it stands on it, and nothing pushes it aside.
#[test]
fn a_flush_cuboid_has_no_sideways_contacts() {
    let brep = shape(cube());
    let other = Cuboid::new(Vector::splat(0.5));
    for height in [1e-3, 0.0, -1e-3] {
        // Flush all around, on one side, and along the other axes.
        for (aside, out) in [
            (Vector::ZERO, Vector::Z),
            (Vector::new(0.25, 0.0, 0.0), Vector::Z),
            (Vector::ZERO, Vector::X),
            (Vector::new(0.0, 0.0, -0.5), -Vector::Y),
        ] {
            let at = Vector::splat(0.5) + aside + out * (1.0 + height);
            let answer = ask(&brep, &other, &Pose::from_translation(at));
            is(&answer, height, 1e-10);
            assert_eq!(answer.undecided, None);
            let near = answer.contacts.iter().filter(|c| c.separation.value < 0.01);
            let near: Vec<_> = near.collect();
            assert!(near.len() >= 4, "{height} {aside} {near:?}");
            for c in &near {
                assert!((c.normal - out).length() < 1e-6, "{height} {aside} {c:?}");
                assert!((c.separation.value - height).abs() < 1e-9, "{c:?}");
                assert!(c.separation.bounds.contains(height), "{c:?}");
            }
            // They hold it at its corners, not in the middle.
            let spread = |axis: Vector| {
                let all = near.iter().map(|c| c.on_brep.dot(axis));
                all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
            };
            let across = [Vector::X, Vector::Y, Vector::Z];
            for axis in across.into_iter().filter(|a| a.dot(out) == 0.0) {
                let overlap = 1.0 - aside.dot(axis).abs();
                assert!(spread(axis) > 0.99 * overlap, "{height} {aside} {near:?}");
            }
        }
    }
}

/// Wide bounds are told as such.
#[test]
fn what_is_not_known_as_exactly_as_asked_is_undecided() {
    let brep = shape(part("ball_joint_cavity.3dm"));
    let before = brep.undecided();
    let pose = Pose::translation(0.125, 0.0625, 0.0);
    let answer = ask(&brep, &Cuboid::new(Vector::splat(1.25)), &pose);
    assert_eq!(answer.undecided, Some(Undecided::Precision));
    assert!(brep.undecided() > before);
}

#[test]
fn cylinders_and_cones() {
    let brep = shape(cube());
    let lies = Rotation::from_axis_angle(Vector::X, 0.0);
    let stands = Rotation::from_axis_angle(Vector::X, std::f64::consts::FRAC_PI_2);
    let (half, radius) = (0.375, 0.25);
    let cylinder = Cylinder::new(half, radius);
    let round = RoundCylinder {
        inner_shape: Cylinder::new(half - 0.125, radius - 0.125),
        border_radius: 0.125,
    };
    let cone = Cone::new(half, radius);
    let at =
        |height: f64, turn: Rotation| Pose::from_parts(Vector::new(0.5, 0.5, 1.0 + height), turn);
    for gap in [0.25, 0.0, -0.015625] {
        for shape in [&cylinder as &dyn Shape, &round] {
            // The axis, y, along the face, upright, and at 45 degrees: a rim's lowest point.
            let answer = ask(&brep, shape, &at(radius + gap, lies));
            is(&answer, gap, 1e-9);
            let lowest = answer.contacts.iter();
            let lowest = lowest.filter(|c| (c.separation.value - gap).abs() < 1e-9);
            assert!(lowest.count() >= 2, "{answer:?}");
            let answer = ask(&brep, shape, &at(half + gap, stands));
            is(&answer, gap, 1e-9);
            let lowest = answer.contacts.iter();
            let lowest = lowest.filter(|c| (c.separation.value - gap).abs() < 1e-9);
            assert!(lowest.count() >= 3, "{answer:?}");
        }
        let leans = Rotation::from_axis_angle(Vector::X, std::f64::consts::FRAC_PI_4);
        let reach = (half + radius) / 2f64.sqrt();
        is(&ask(&brep, &cylinder, &at(reach + gap, leans)), gap, 1e-6);
        // On its apex, on its base, and lying on its side: the middle of the axis is half r / sqrt(r^2 + 4 half^2) above.
        let down = Rotation::from_axis_angle(Vector::X, -std::f64::consts::FRAC_PI_2);
        is(&ask(&brep, &cone, &at(half + gap, down)), gap, 1e-6);
        is(&ask(&brep, &cone, &at(half + gap, stands)), gap, 1e-9);
        let slant = (radius / (2.0 * half)).atan();
        let lying = Rotation::from_axis_angle(Vector::X, -slant);
        let above = half * slant.sin();
        is(&ask(&brep, &cone, &at(above + gap, lying)), gap, 1e-6);
    }
    // Beside the cube's edge, the axis along it: from axis to edge.
    let beside = Pose::translation(1.5, 0.5, 1.5);
    is(
        &ask(&brep, &cylinder, &beside),
        0.5f64.sqrt() - radius,
        1e-6,
    );
}

/// Parry's own distances of cylinders and cones from a cuboid lie within the bounds.
#[test]
fn round_solids_are_as_far_apart_as_parry_says() {
    /// Parry's distances of these, by GJK, are right to about this.
    const PARRY: f64 = 1e-5;
    let mut random = Random(43);
    let brep = shape(block([-0.5; 3], [0.5; 3]));
    let same = Cuboid::new(Vector::splat(0.5));
    let mut widths = Vec::new();
    for k in 0..120 {
        let (half, radius) = (random.between(0.05, 0.5), random.between(0.05, 0.5));
        let other: &dyn Shape = match k % 2 {
            0 => &Cylinder::new(half, radius),
            _ => &Cone::new(half, radius),
        };
        let pose = random.pose(2.0);
        let truth = distance(&Pose::IDENTITY, &same, &pose, other);
        let truth = truth.unwrap().distance;
        if truth == 0.0 {
            continue;
        }
        let b = ask(&brep, other, &pose).separation.bounds;
        assert!(
            b.lo <= truth + PARRY && truth - PARRY <= b.hi,
            "{k} {b:?} {truth}"
        );
        widths.push(b.width());
    }
    widths.sort_by(f64::total_cmp);
    assert!(widths.len() > 50);
    assert!(widths[widths.len() / 2] < 1e-6, "{widths:?}");
}

/// A cylinder that leans by next to nothing: its rim's lowest point is one of its own, and it keeps its contacts.
#[test]
fn nearly_upright_cylinders_keep_their_contacts() {
    let brep = shape(cube());
    let (half, radius, depth) = (0.375, 0.25, 1e-4);
    let cylinder = Cylinder::new(half, radius);
    let stands = Rotation::from_axis_angle(Vector::X, std::f64::consts::FRAC_PI_2);
    for tilt in [2e-6f64, 1e-5, 1e-4, 1e-3] {
        for step in 0..48 {
            let (sin, cos) = (f64::from(step) * 0.131).sin_cos();
            let leans = Rotation::from_axis_angle(Vector::new(cos, sin, 0.0), tilt);
            let height = half * tilt.cos() + radius * tilt.sin() - depth;
            let pose = Pose::from_parts(Vector::new(0.5, 0.5, 1.0 + height), leans * stands);
            let answer = ask(&brep, &cylinder, &pose);
            let bounds = answer.separation.bounds;
            // The rotation and the height are rounded a few times.
            let rounding = 32.0 * f64::EPSILON;
            let holds = bounds.lo <= -depth + rounding && -depth - rounding <= bounds.hi;
            assert!(holds, "{tilt} {step} {answer:?}");
            assert!(!answer.contacts.is_empty(), "{tilt} {step} {answer:?}");
        }
    }
}

/// A half turn that is given as a scale leaves a radius below zero: the solid is the same.
#[test]
fn a_cone_of_negative_radius_is_the_same() {
    let brep = shape(cube());
    let pose = Pose::translation(0.5, 0.5, 1.75);
    let answers = [0.25, -0.25].map(|radius| ask(&brep, &Cone::new(0.375, radius), &pose));
    assert_eq!(answers[0].separation.value, answers[1].separation.value);
}
