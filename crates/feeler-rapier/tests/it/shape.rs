//! The shape alone: box, rays, points, mass.

use crate::scenes::{Random, block, cube, part, shape, to_cube};
use feeler::brep::Brep;
use feeler::brep::BrepParts;
use feeler::prepare::PreparedBrep;
use feeler_rapier::{BrepShape, ShapeError};
use parry3d_f64::math::Vector;
use parry3d_f64::query::{PointQuery, Ray, RayCast};
use parry3d_f64::shape::{FeatureId, Shape};
use std::f64::consts::PI;
use std::sync::Arc;

#[test]
fn boxes() {
    let b = shape(block([1.0, 2.0, 3.0], [4.0, 6.0, 8.0])).compute_local_aabb();
    let near = |a: Vector, x, y, z| (a - Vector::new(x, y, z)).length() < 1e-12;
    assert!(
        near(b.mins, 1.0, 2.0, 3.0) && near(b.maxs, 4.0, 6.0, 8.0),
        "{b:?}"
    );
    assert!(b.mins.x <= 1.0 && b.maxs.z >= 8.0);
    let b = shape(part("ball.3dm")).compute_local_aabb();
    // A ball of radius 2.45: the sides are asked for to 2^-20 of its size.
    for (low, high) in b.mins.to_array().into_iter().zip(b.maxs.to_array()) {
        let beyond = 2.45..2.45001;
        assert!(beyond.contains(&-low) && beyond.contains(&high), "{b:?}");
    }
    let empty = Brep::new(BrepParts::default()).unwrap();
    let refused = BrepShape::new(Arc::new(PreparedBrep::new(empty)));
    assert_eq!(refused.unwrap_err(), ShapeError::Empty);
}

#[test]
fn rays() {
    let brep = shape(cube());
    let ray = |from: [f64; 3], to: [f64; 3]| Ray::new(from.into(), to.into());
    let down = ray([0.25, 0.5, 3.0], [0.0, 0.0, -2.0]);
    let hit = brep
        .cast_local_ray_and_get_normal(&down, 10.0, true)
        .unwrap();
    assert_eq!(hit.time_of_impact, 1.0);
    assert_eq!(hit.normal, Vector::Z);
    assert!(matches!(hit.feature, FeatureId::Face(_)));
    assert!(brep.cast_local_ray(&down, 0.99, true).is_none());
    assert!(!brep.intersects_local_ray(&ray([1.5, 0.5, 3.0], [0.0, 0.0, -1.0]), 10.0));
    // From inside: a solid is hit at once, a hollow one at its wall, from within.
    let inside = ray([0.25, 0.5, 0.5], [0.0, 0.0, -2.0]);
    assert_eq!(brep.cast_local_ray(&inside, 10.0, true), Some(0.0));
    let hit = brep
        .cast_local_ray_and_get_normal(&inside, 10.0, false)
        .unwrap();
    assert_eq!((hit.time_of_impact, hit.normal), (0.25, Vector::Z));
    // A ray that stands still is none.
    assert!(
        brep.cast_local_ray(&ray([0.5; 3], [0.0; 3]), 1.0, true)
            .is_none()
    );
}

#[test]
fn rays_in_the_cavity() {
    let mut random = Random(11);
    // A hole of radius 2.5 about the origin, closed all around.
    let brep = shape(part("ball_joint_cavity.3dm"));
    for _ in 0..50 {
        let from = random.vector(1.0);
        let ray = Ray::new(from, random.vector(1.0).normalize());
        let hit = brep.cast_local_ray_and_get_normal(&ray, 100.0, true);
        let hit = hit.unwrap();
        let b = from.dot(ray.dir);
        let on_sphere = -b + (b * b - from.length_squared() + 6.25).sqrt();
        assert!((hit.time_of_impact - on_sphere).abs() < 1e-12);
        let inward = -ray.point_at(on_sphere) / 2.5;
        assert!((hit.normal - inward).length() < 1e-9);
    }
}

#[test]
fn points() {
    let mut random = Random(12);
    let brep = shape(cube());
    for _ in 0..100 {
        let p = Vector::splat(0.5) + random.vector(1.0);
        let truth = to_cube(p);
        let hollow = brep.project_local_point(p, false);
        assert_eq!(hollow.is_inside, truth <= 0.0);
        assert!(((hollow.point - p).length() - truth.abs()).abs() < 1e-12);
        assert!((brep.distance_to_local_point(p, false) - truth).abs() < 1e-12);
        assert_eq!(brep.contains_local_point(p), truth <= 0.0);
        let solid = brep.project_local_point(p, true);
        assert_eq!(solid.point == p, truth <= 0.0);
    }
    let (_, feature) = brep.project_local_point_and_get_feature(Vector::new(0.5, 0.5, 2.0));
    assert!(matches!(feature, FeatureId::Face(_)));
    let (_, feature) = brep.project_local_point_and_get_feature(Vector::new(2.0, 0.5, 2.0));
    assert!(matches!(feature, FeatureId::Edge(_)));
    let (_, feature) = brep.project_local_point_and_get_feature(Vector::splat(2.0));
    assert!(matches!(feature, FeatureId::Vertex(_)));
}

#[test]
fn mass_of_a_block() {
    let brep = shape(block([1.0, 2.0, 3.0], [3.0, 5.0, 8.0]));
    let m = brep.mass();
    assert!((m.volume - 30.0).abs() < 1e-11, "{m:?}");
    assert!(m.error < 1e-10 && m.guessed == 0, "{m:?}");
    for (c, at) in m.center.iter().zip([2.0, 3.5, 5.5]) {
        assert!((c - at).abs() < 1e-12);
    }
    let [x, y, z] = [2.0f64, 3.0, 5.0].map(|s| s * s / 12.0 * 30.0);
    for (k, about) in [y + z, z + x, x + y].into_iter().enumerate() {
        assert!((m.inertia[k][k] - about).abs() < 1e-9, "{m:?}");
    }
    assert!(m.inertia[0][1].abs() < 1e-9);
    let props = brep.mass_properties(2.0);
    assert!((props.mass() - 60.0).abs() < 1e-9);
    assert_eq!(brep.mass_properties(0.0).mass(), 0.0);
}

#[test]
fn mass_of_a_ball_and_of_the_joint() {
    let ball = |r: f64| 4.0 / 3.0 * PI * r.powi(3);
    let about = |r: f64| 0.4 * ball(r) * r * r;
    // A ball of radius 2.45, and a cube of side 10 with a hole of radius 2.5, all about the origin.
    let joint = (1000.0 - ball(2.5), 1000.0 * 200.0 / 12.0 - about(2.5));
    for (name, (volume, inertia), exactly) in [
        ("ball.3dm", (ball(2.45), about(2.45)), 1e-11),
        ("ball_joint_cavity.3dm", joint, 1e-11),
        ("ball_joint_cavity_nurbs.3dm", joint, 1e-9),
    ] {
        let brep = shape(part(name));
        let m = brep.mass();
        assert!((m.volume / volume - 1.0).abs() < exactly, "{name} {m:?}");
        // What was seen is not far below what is.
        let seen = m.error.max(1e-15);
        assert!((m.volume / volume - 1.0).abs() < 1e3 * seen, "{name} {m:?}");
        assert!(m.error < 10.0 * exactly && m.guessed == 0, "{name} {m:?}");
        for k in 0..3 {
            assert!(m.center[k].abs() < 10.0 * exactly, "{name} {m:?}");
            assert!(
                (m.inertia[k][k] / inertia - 1.0).abs() < 10.0 * exactly,
                "{name} {m:?}"
            );
        }
    }
}

#[test]
fn scaling_is_exact_or_refused() {
    let brep = shape(cube());
    for by in [Vector::splat(1.5), Vector::new(2.0, 1.0, 1.0), Vector::ZERO] {
        assert!(brep.scale_dyn(by, 1).is_none());
    }
    assert!(brep.scale_dyn(Vector::splat(f64::NAN), 1).is_none());
    assert!(brep.scale_dyn(Vector::splat(1.0), 1).is_some());
    let half = brep.scale_dyn(Vector::splat(0.5), 1);
    assert_eq!(half.is_some(), cfg!(feature = "files"));
}
