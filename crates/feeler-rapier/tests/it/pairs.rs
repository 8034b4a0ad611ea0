//! Separations at poses, in both orders, against closed forms.

use crate::scenes::{Random, block, cube, part, shape, to_cube, torus};
use dashu_ratio::RBig;
use feeler::query::Undecided;
use feeler_rapier::{BrepDispatcher, BrepShape, ball_gap, pose};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::details::ShapeCastOptions;
use parry3d_f64::query::{
    ClosestPoints, DefaultQueryDispatcher, NonlinearRigidMotion, QueryDispatcher, ShapeCastStatus,
};
use parry3d_f64::shape::{
    Ball, Capsule, Compound, Cuboid, HalfSpace, Segment, Shape, SharedShape, TriMesh,
};
use std::sync::{Arc, Mutex};

/// Rounding of the closed forms, which are computed in f64 from numbers up to about ten.
const ROUNDING: f64 = 2e-14;

/// Asks in both orders: bounds must hold the truth, and points and normals fit the answer.
fn both_orders(brep: &BrepShape, other: &dyn Shape, pos12: &Pose, truth: f64, widest: f64) {
    let d = BrepDispatcher::new();
    let inverse = pos12.inverse();
    let orders: [(&Pose, &dyn Shape, &dyn Shape); 2] =
        [(pos12, brep, other), (&inverse, other, brep)];
    for (pose, g1, g2) in orders {
        let answer = d.pair(pose, g1, g2, 10.0).unwrap();
        let b = answer.separation.bounds;
        assert!(
            b.lo - ROUNDING <= truth && truth <= b.hi + ROUNDING,
            "{b:?} {truth}"
        );
        assert!(b.width() <= widest, "{b:?}");
        assert!(b.contains(answer.separation.value));
        let c = d.contact(pose, g1, g2, 10.0).unwrap().unwrap();
        assert_eq!(c.dist, answer.separation.value);
        // The points, each in its own frame, are as far apart as is said, along the normal.
        let along = pose.transform_point(c.point2) - c.point1;
        assert!(
            (along - c.normal1 * c.dist).length() < 1e-11 + widest,
            "{c:?}"
        );
        let opposite = pose.transform_vector(c.normal2) + c.normal1;
        assert!(opposite.length() < 1e-14);
        assert_eq!(d.distance(pose, g1, g2).unwrap().distance, c.dist.max(0.0));
        let touching = d.intersection_test(pose, g1, g2).unwrap().intersecting;
        assert_eq!(touching, c.dist <= 0.0);
        match d.closest_points(pose, g1, g2, 10.0).unwrap() {
            ClosestPoints::Intersecting => assert!(c.dist <= 0.0),
            ClosestPoints::WithinMargin(p, q) => assert_eq!((p, q), (c.point1, c.point2)),
            ClosestPoints::Disjoint => panic!("{c:?}"),
        }
        assert!(
            d.contact(pose, g1, g2, c.dist - widest - 1e-9)
                .unwrap()
                .is_none()
        );
    }
}

#[test]
fn ball_and_cube() {
    let mut random = Random(1);
    let brep = shape(cube());
    for _ in 0..200 {
        let pose = Pose::from_parts(Vector::splat(0.5) + random.vector(1.5), random.rotation());
        let radius = random.between(0.01, 0.5);
        let truth = to_cube(pose.translation) - radius;
        both_orders(&brep, &Ball::new(radius), &pose, truth, 1e-11);
    }
}

#[test]
fn ball_in_the_socket() {
    let mut random = Random(2);
    let brep = shape(part("ball_joint_cavity.3dm"));
    for _ in 0..100 {
        // The hole has radius 2.5 about the origin.
        let off = random.vector(0.02);
        let pose = Pose::from_parts(off, random.rotation());
        let radius = random.between(2.4, 2.6);
        let truth = 2.5 - off.length() - radius;
        both_orders(&brep, &Ball::new(radius), &pose, truth, 1e-10);
    }
}

#[test]
fn ball_and_torus() {
    let mut random = Random(3);
    let brep = shape(torus(3.0, 1.0));
    for _ in 0..100 {
        let p = random.vector(5.0);
        let pose = Pose::from_parts(p, random.rotation());
        let from_circle = (p.x.hypot(p.y) - 3.0).hypot(p.z);
        let truth = (from_circle - 1.0).abs() - 0.3;
        both_orders(&brep, &Ball::new(0.3), &pose, truth, 1e-10);
    }
}

#[test]
fn half_space_and_cube() {
    let mut random = Random(4);
    let brep = shape(cube());
    for _ in 0..100 {
        let pose = random.pose(2.0);
        let n = random.vector(1.0).normalize();
        let in_brep = pose.transform_vector(n);
        let heights = (0..8).map(|i| {
            let corner = Vector::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
            in_brep.dot(corner - pose.translation)
        });
        let truth = heights.fold(f64::INFINITY, f64::min);
        both_orders(&brep, &HalfSpace::new(n), &pose, truth, 1e-11);
    }
}

#[test]
fn capsules_and_segments() {
    let mut random = Random(5);
    let brep = shape(cube());
    for k in 0..30 {
        // Upright beside a face, above it, and with an end inside.
        let (x, y) = (random.between(0.2, 0.8), random.between(0.2, 0.8));
        let above = random.between(-0.1, 0.5);
        let half = random.between(0.2, 1.0);
        let radius = if k % 3 == 0 { 0.0 } else { 0.125 };
        let pose = Pose::translation(x, y, 1.0 + above + half);
        let truth = if above >= 0.0 {
            above - radius
        } else {
            // The whole axis from there on up: the deepest point is the lower end.
            to_cube(Vector::new(x, y, 1.0 + above)) - radius
        };
        let widest = 2.0 * half / 500.0;
        if radius == 0.0 {
            let s = Segment::new(Vector::new(0., 0., -half), Vector::new(0., 0., half));
            both_orders(&brep, &s, &pose, truth, widest);
        } else {
            let c = Capsule::new_z(half, radius);
            both_orders(&brep, &c, &pose, truth, widest);
        }
    }
    // Across an edge: the nearest point of the axis is inside it.
    let c = Capsule::new_z(1.0, 0.25);
    let tilted = Rotation::from_axis_angle(Vector::X, std::f64::consts::FRAC_PI_4);
    let pose = Pose::from_parts(Vector::new(0.5, 1.5, 1.5), tilted);
    both_orders(&brep, &c, &pose, 0.5f64.sqrt() - 0.25, 0.02);
}

/// Where the pieces of the axis are used up, the bounds are wide, and it is told.
#[test]
fn a_capsule_along_a_face_is_known_less_well() {
    let brep = shape(cube());
    let d = BrepDispatcher::new();
    let capsule = Capsule::new_z(0.25, 0.125);
    let (stands, lies) = (
        Pose::translation(0.5, 0.5, 1.5),
        Pose::from_parts(
            Vector::new(0.5, 0.5, 1.25),
            Rotation::from_axis_angle(Vector::X, std::f64::consts::FRAC_PI_2),
        ),
    );
    let before = brep.undecided();
    let upright = d.pair(&stands, &brep, &capsule, 1.0).unwrap();
    assert_eq!(upright.undecided, None);
    assert_eq!(brep.undecided(), before);
    let flat = d.pair(&lies, &brep, &capsule, 1.0).unwrap();
    let b = flat.separation.bounds;
    assert!(b.contains(0.125) && b.width() > 0.5 / 1024.0, "{b:?}");
    assert_eq!(flat.undecided, Some(Undecided::Budget));
    assert!(brep.undecided() > before);
}

/// A capsule whose ends are one point, or all but one, is a ball: known as well, for some queries. Nothing is as exact as is asked here, so that each query
/// of the kernel is counted.
#[test]
fn a_capsule_without_a_length_is_a_ball() {
    let brep = shape(cube()).with_accuracy(0.0);
    let d = BrepDispatcher::new();
    let mut random = Random(8);
    for length in [0.0, 1e-300, 1e-20, 1e-9] {
        let pose = Pose::from_parts(Vector::new(0.3, 0.7, 1.5), random.rotation());
        let ends = [-Vector::X, Vector::X].map(|x| x * (0.5 * length));
        let capsule = Capsule::new(ends[0], ends[1], 0.25);
        let before = brep.undecided();
        let answer = d.pair(&pose, &brep, &capsule, 1.0).unwrap();
        let asked = brep.undecided() - before;
        assert!((1..50).contains(&asked), "{length} {asked}");
        let b = answer.separation.bounds;
        assert!(b.lo - length <= 0.25 && 0.25 <= b.hi + length, "{b:?}");
        assert!(b.width() < 1e-12 + length, "{b:?}");
        // One place, unless its ends can be told apart.
        assert!(answer.contacts.len() == 1 || length == 1e-9, "{answer:?}");
    }
}

/// The rotation of a quaternion's exact normalisation, in rationals.
fn exactly(q: &Rotation, x: Vector) -> [RBig; 3] {
    let r = |x: f64| RBig::try_from(x).unwrap();
    let [a, b, c, w] = [q.x, q.y, q.z, q.w].map(r);
    let v = [a, b, c];
    let x = x.to_array().map(r);
    let cross = |p: &[RBig; 3], q: &[RBig; 3]| {
        [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &p[i] * &q[j] - &p[j] * &q[i])
    };
    let n = v.iter().fold(&w * &w, |n, c| n + c * c);
    let once = cross(&v, &x);
    let twice = cross(&v, &once);
    [0, 1, 2].map(|c| &x[c] + r(2.0) * (&w * &once[c] + &twice[c]) / &n)
}

#[test]
fn the_bound_of_a_pose_holds_and_is_near() {
    let mut random = Random(6);
    let mut worst: f64 = 0.0;
    for k in 0..2000 {
        // Not normalised on purpose.
        let [x, y, z, w] = [0; 4].map(|_| random.between(-1.0, 1.0));
        let q = Rotation::from_xyzw(x, y, z, w);
        let pose = Pose::from_parts(random.vector(10.0), q);
        // Lengths whose squares are below all numbers, too: what they are rounded by is as small, but counts where they are multiplied by long times.
        let tiny = if k % 4 == 0 { 1e-170 } else { 1.0 };
        let p = random.vector(3.0) * tiny;
        let turned = exactly(&q, p);
        let r = |x: f64| RBig::try_from(x).unwrap();
        let alone = pose::rotate(&q, p);
        let at = alone.point.to_array();
        let off: [RBig; 3] = [0, 1, 2].map(|c| &turned[c] - r(at[c]));
        let square = off.iter().fold(RBig::ZERO, |s, o| s + o * o);
        assert!(square <= r(alone.bound) * r(alone.bound), "{tiny}");
        if tiny < 1.0 {
            continue;
        }
        let placed = pose::out_of(&pose, p);
        let t = pose.translation.to_array();
        let there = placed.point.to_array();
        let off: [RBig; 3] = [0, 1, 2].map(|c| &turned[c] + r(t[c]) - r(there[c]));
        let square = off.iter().fold(RBig::ZERO, |s, o| s + o * o);
        assert!(square <= r(placed.bound) * r(placed.bound));
        worst = worst.max(square.to_f64().value().sqrt() / placed.bound);
        // And back: into(out_of(p)) is p within both bounds.
        let back = pose::into(&pose, placed.point);
        assert!((back.point - p).length() <= (back.bound + placed.bound) * 1.01);
    }
    // A bound that nothing comes near would be no use.
    assert!(worst > 0.03, "{worst}");
    let not_a_pose = Pose::from_parts(Vector::ZERO, Rotation::from_xyzw(0.0, 0.0, 0.0, 0.0));
    assert_eq!(pose::out_of(&not_a_pose, Vector::X).bound, f64::INFINITY);
}

#[test]
fn poses_that_are_none_give_no_contact() {
    let brep = shape(cube());
    let d = BrepDispatcher::new();
    let ball = Ball::new(0.5);
    let before = brep.undecided();
    let lost = Pose::translation(f64::NAN, 0.0, 0.0);
    assert!(d.contact(&lost, &brep, &ball, 1.0).unwrap().is_none());
    assert!(d.contact(&lost, &ball, &brep, 1.0).unwrap().is_none());
    assert!(brep.undecided() > before);
}

#[test]
fn the_gap_at_two_poses() {
    let mut random = Random(7);
    let brep = shape(block([-1.0; 3], [1.0; 3]));
    for _ in 0..50 {
        let pose = random.pose(5.0);
        let inside = Vector::new(1.5, random.between(-0.9, 0.9), random.between(-0.9, 0.9));
        let center = pose.transform_point(inside);
        let gap = ball_gap(&brep, &pose, center, 0.25);
        assert!((gap.value - 0.25).abs() < ROUNDING);
        assert!(gap.bounds.lo - ROUNDING <= 0.25 && 0.25 <= gap.bounds.hi + ROUNDING);
    }
}

#[test]
fn unsupported_pairs_are_said_once_and_counted() {
    let said = Arc::new(Mutex::new(Vec::new()));
    let to = Arc::clone(&said);
    let d = BrepDispatcher::with_report(move |m| to.lock().unwrap().push(m.to_owned()));
    let chain = d.clone().chain(DefaultQueryDispatcher);
    let brep = shape(cube());
    let points = [Vector::ZERO, Vector::X, Vector::Y];
    let mesh = TriMesh::new(points.to_vec(), vec![[0, 1, 2]]).unwrap();
    let pose = Pose::translation(1.0, 0.0, 0.0);
    for _ in 0..3 {
        // Parry takes the mesh apart, and finds nothing that it knows.
        assert!(d.contact(&pose, &brep, &mesh, 1.0).is_err());
        assert!(d.contact(&pose, &mesh, &brep, 1.0).is_err());
    }
    assert!(chain.distance(&pose, &brep, &brep).is_err());
    // What has no BREP is none of its business.
    let ball = Ball::new(1.0);
    assert!(chain.contact(&pose, &ball, &ball, 1.0).is_ok());
    let parts = vec![(Pose::IDENTITY, SharedShape::new(brep.clone()))];
    let compound = Compound::new(parts);
    assert!(chain.contact(&pose, &compound, &ball, 1.0).is_ok());
    assert!(d.contact(&pose, &compound, &mesh, 1.0).is_err());
    // Nothing but balls is cast.
    let cuboid = Cuboid::new(Vector::splat(0.5));
    let still = NonlinearRigidMotion::identity();
    let options = ShapeCastOptions::default();
    for other in [&cuboid as &dyn Shape, &compound] {
        let cast = d.cast_shapes(&pose, Vector::X, &brep, other, options);
        assert!(!matches!(cast, Ok(Some(_))), "{cast:?}");
        let cast = d.cast_shapes_nonlinear(&still, other, &still, &brep, 0.0, 1.0, true);
        assert!(!matches!(cast, Ok(Some(_))), "{cast:?}");
    }
    let counts: Vec<_> = d
        .unsupported()
        .into_iter()
        .map(|u| (u.query, u.other, u.count))
        .collect();
    let expected = [
        ("contact", "TriMesh", 7),
        ("distance", "BREP", 1),
        ("nonlinear shape cast", "BREP", 1),
        ("nonlinear shape cast", "Cuboid", 1),
        ("shape cast", "BREP", 1),
        ("shape cast", "Cuboid", 1),
    ];
    let expected = expected.map(|(q, o, n)| (q, o.to_owned(), n));
    assert_eq!(counts, expected);
    assert_eq!(said.lock().unwrap().len(), expected.len(), "{said:?}");
}

fn cast(
    brep: &BrepShape,
    from: Vector,
    velocity: Vector,
    radius: f64,
    options: ShapeCastOptions,
) -> Option<(f64, ShapeCastStatus)> {
    let d = BrepDispatcher::new();
    let ball = Ball::new(radius);
    let pose = Pose::from_translation(from);
    let one = d
        .cast_shapes(&pose, velocity, brep, &ball, options)
        .unwrap();
    // The BREP as the second shape, which moves the other way.
    let other = pose.inverse();
    let two = d
        .cast_shapes(&other, -velocity, &ball, brep, options)
        .unwrap();
    assert_eq!(one.is_some(), two.is_some());
    let (one, two) = (one?, two?);
    assert!((one.time_of_impact - two.time_of_impact).abs() < 1e-9);
    assert!((one.witness1 - two.witness2).length() < 1e-6);
    Some((one.time_of_impact, one.status))
}

#[test]
fn moving_balls_meet_when_they_should() {
    let brep = shape(cube());
    let options = ShapeCastOptions::default();
    let at = |x, y, z| Vector::new(x, y, z);
    // Head on: a gap of 3 less the radius, at speed 2.
    let (t, status) = cast(&brep, at(0.5, 0.5, 4.0), at(0., 0., -2.), 0.5, options).unwrap();
    assert!(t <= 1.25 && t > 1.25 - 1e-9, "{t}");
    assert_eq!(status, ShapeCastStatus::Converged);
    // A long way off, at a slant: the centre meets the plane at height 1.5.
    let (t, _) = cast(&brep, at(-6.5, 0.5, 8.5), at(1., 0., -1.), 0.5, options).unwrap();
    assert!(t <= 7.0 && t > 7.0 - 1e-8, "{t}");
    // Past it, and away from it.
    assert!(cast(&brep, at(-4., 0.5, 1.75), at(1., 0., 0.), 0.5, options).is_none());
    assert!(cast(&brep, at(0.5, 0.5, 2.0), at(0., 0., 1.), 0.5, options).is_none());
    // Not before the time is up.
    let short = ShapeCastOptions::with_max_time_of_impact(1.0);
    assert!(cast(&brep, at(0.5, 0.5, 4.0), at(0., 0., -2.), 0.5, short).is_none());
    // Overlapping from the start.
    let (t, status) = cast(&brep, at(0.5, 0.5, 1.25), at(0., 0., 1.), 0.5, options).unwrap();
    assert_eq!(
        (t, status),
        (0.0, ShapeCastStatus::PenetratingOrWithinTargetDist)
    );
    let leave = ShapeCastOptions {
        stop_at_penetration: false,
        ..options
    };
    assert!(cast(&brep, at(0.5, 0.5, 1.25), at(0., 0., 1.), 0.5, leave).is_none());
    assert!(cast(&brep, at(0.5, 0.5, 1.25), at(0., 0., -1.), 0.5, leave).is_some());
}

/// Above the top by less than is known of its place, late in time: it may touch from the edge on, or never. That is told.
#[test]
fn an_arrival_that_may_never_be_is_not_settled() {
    let brep = shape(cube());
    let late = f64::from(1u32 << 20);
    let still = NonlinearRigidMotion::constant_position(Pose::IDENTITY);
    let moves = NonlinearRigidMotion {
        start: Pose::translation(-4.0 - late, 0.5, 1.25 + 1e-12),
        linvel: Vector::X,
        ..NonlinearRigidMotion::identity()
    };
    let (d, ball) = (BrepDispatcher::new(), Ball::new(0.25));
    let hit = d.cast_shapes_nonlinear(&still, &brep, &moves, &ball, late, late + 9.0, true);
    let hit = hit.unwrap().unwrap();
    let t = hit.time_of_impact - late;
    assert!(t > 3.9 && t < 5.0, "{t}");
    assert_eq!(hit.status, ShapeCastStatus::OutOfIterations);
    assert_eq!(brep.undecided(), 1);
}

#[test]
fn a_turning_cube_meets_a_ball_at_rest() {
    let d = BrepDispatcher::new();
    let brep = shape(block([-1.0; 3], [1.0; 3]));
    // The edge at (1, 1) sweeps a circle of radius sqrt 2 about z; the ball waits on the x axis.
    let quarter = std::f64::consts::FRAC_PI_4;
    let turning = NonlinearRigidMotion {
        angvel: Vector::new(0.0, 0.0, quarter),
        ..NonlinearRigidMotion::identity()
    };
    let radius = 0.25;
    let away = 2f64.sqrt() + radius;
    let ball = Ball::new(radius);
    let waits = NonlinearRigidMotion::constant_position(Pose::translation(away - 1e-3, 0.0, 0.0));
    let hit = d
        .cast_shapes_nonlinear(&turning, &brep, &waits, &ball, 0.0, 2.0, true)
        .unwrap()
        .unwrap();
    // It would touch at an eighth of a turn, after 1; a little overlap makes it somewhat earlier: the ball's surface
    // is a parabola about the x axis there.
    assert!(
        hit.time_of_impact < 1.0 && hit.time_of_impact > 0.9,
        "{hit:?}"
    );
    let spot = turning.position_at_time(hit.time_of_impact);
    let gap = ball_gap(&brep, &spot, Vector::new(away - 1e-3, 0.0, 0.0), radius);
    assert!(gap.value.abs() < 1e-9, "{gap:?}");
    let far = NonlinearRigidMotion::constant_position(Pose::translation(away + 1e-3, 0.0, 0.0));
    let none = d.cast_shapes_nonlinear(&turning, &brep, &far, &ball, 0.0, 2.0, true);
    assert!(none.unwrap().is_none());
}
