//! Compounds with a BREP.

use crate::scenes::{block, cube, shape};
use feeler_rapier::BrepDispatcher;
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::details::ShapeCastOptions;
use parry3d_f64::query::{
    ClosestPoints, ContactManifold, DefaultQueryDispatcher, NonlinearRigidMotion,
    PersistentQueryDispatcher, QueryDispatcher,
};
use parry3d_f64::shape::{Ball, Compound, Cuboid, Shape, SharedShape};
use rapier3d_f64::prelude::{ColliderBuilder, PhysicsWorld, RigidBodyBuilder};

/// A cube as a BREP, from (2, 0, 0) on, turned by a quarter about z at its corner, and a cuboid of Parry from (-4, 0, 0) to (-2, 1, 1): the
/// first reaches over x from 1 to 2.
fn compound() -> Compound {
    let quarter = Rotation::from_axis_angle(Vector::Z, std::f64::consts::FRAC_PI_2);
    let brep = Pose::from_parts(Vector::new(2.0, 0.0, 0.0), quarter);
    let cuboid = Pose::translation(-3.0, 0.5, 0.5);
    Compound::new(vec![
        (
            cuboid,
            SharedShape::new(Cuboid::new(Vector::new(1.0, 0.5, 0.5))),
        ),
        (brep, SharedShape::new(shape(cube()))),
    ])
}

#[test]
fn both_orders_of_all_queries() {
    let d = BrepDispatcher::new().chain(DefaultQueryDispatcher);
    let compound = compound();
    let ball = Ball::new(0.25);
    // Over the BREP, over Parry's own cuboid, and between the two.
    for (center, gap, part, way) in [
        ([1.5, 0.5, 1.5], 0.25, 1, Vector::Z),
        ([1.5, 0.5, 1.125], -0.125, 1, Vector::Z),
        ([-3.0, 0.5, 1.125], -0.125, 0, Vector::Z),
        ([0.5, 0.5, 0.5], 0.25, 1, -Vector::X),
    ] {
        let pose = Pose::from_translation(center.into());
        let inverse = pose.inverse();
        let orders: [(&Pose, &dyn Shape, &dyn Shape); 2] =
            [(&pose, &compound, &ball), (&inverse, &ball, &compound)];
        for (k, (pose, g1, g2)) in orders.into_iter().enumerate() {
            let near = |x: f64, y: f64| (x - y).abs() < 1e-9;
            let c = d.contact(pose, g1, g2, 1.0).unwrap().unwrap();
            assert!(near(c.dist, gap), "{c:?}");
            // In the compound's frame, and along the normal.
            let (point, normal) = [(c.point1, c.normal1), (c.point2, c.normal2)][k];
            let foot = Vector::from_array(center) - way * (0.25 + gap);
            assert!((point - foot).length() < 1e-9, "{c:?}");
            assert!((normal - way).length() < 1e-9, "{c:?}");
            let distance = d.distance(pose, g1, g2).unwrap().distance;
            assert!(near(distance, gap.max(0.0)));
            let touching = d.intersection_test(pose, g1, g2).unwrap().intersecting;
            assert_eq!(touching, gap <= 0.0);
            match d.closest_points(pose, g1, g2, 1.0).unwrap() {
                ClosestPoints::Intersecting => assert!(gap <= 0.0),
                ClosestPoints::WithinMargin(p, q) => {
                    assert!(near((*pose * q - p).length(), gap));
                }
                ClosestPoints::Disjoint => panic!("{c:?}"),
            }
            // Towards it at speed 1.
            let velocity = [-way, way][k];
            let options = ShapeCastOptions::default();
            let hit = d.cast_shapes(pose, velocity, g1, g2, options);
            let hit = hit.unwrap().unwrap();
            assert!((hit.time_of_impact - gap.max(0.0)).abs() < 1e-6, "{hit:?}");
            let number = [hit.subshape1, hit.subshape2][k];
            // Parry does not tell which part, where the pair is its own.
            if gap > 0.0 {
                assert_eq!(number, part, "{hit:?}");
                let witness = [hit.witness1, hit.witness2][k];
                assert!((witness - foot).length() < 1e-6, "{hit:?}");
            }
            let still = NonlinearRigidMotion::constant_position(Pose::IDENTITY);
            let moves = NonlinearRigidMotion {
                start: *[&Pose::IDENTITY, pose][1],
                linvel: velocity,
                ..NonlinearRigidMotion::identity()
            };
            let hit = d.cast_shapes_nonlinear(&still, g1, &moves, g2, 0.0, 10.0, true);
            let hit = hit.unwrap().unwrap();
            assert!((hit.time_of_impact - gap.max(0.0)).abs() < 1e-6, "{hit:?}");
        }
    }
    let far = Pose::translation(0.0, 0.0, 50.0);
    assert!(d.contact(&far, &compound, &ball, 1.0).unwrap().is_none());
}

type Manifolds = Vec<ContactManifold<(), u32>>;

/// Manifolds name the parts they are of, and keep what the engine knows of each contact while the bodies move.
#[test]
fn manifolds_name_their_parts_and_are_kept() {
    let d = BrepDispatcher::new().chain(DefaultQueryDispatcher);
    let compound = compound();
    // A beam across both, and a BREP across both.
    let beam = Cuboid::new(Vector::new(5.0, 0.25, 0.25));
    let plate = shape(block([-5.0, -0.25, -0.25], [5.0, 0.25, 0.25]));
    let ball = Ball::new(0.25);
    let others: [(&dyn Shape, &[u32]); 3] = [(&beam, &[0, 1]), (&plate, &[0]), (&ball, &[1])];
    for (other, parts) in others {
        let pose = Pose::translation(1.5, 0.5, 1.25 - 1e-3);
        let inverse = pose.inverse();
        let orders: [(&Pose, &dyn Shape, &dyn Shape); 2] =
            [(&pose, &compound, other), (&inverse, other, &compound)];
        for (k, (pose, g1, g2)) in orders.into_iter().enumerate() {
            let mut manifolds: Manifolds = Vec::new();
            let mut workspace = None;
            let mut ask = |pose: &Pose, manifolds: &mut Manifolds| {
                let m = manifolds;
                d.contact_manifolds(pose, g1, g2, 1e-2, m, &mut workspace)
                    .unwrap();
            };
            ask(pose, &mut manifolds);
            let of = |m: &ContactManifold<(), u32>| [m.subshape1, m.subshape2][k];
            let touching = |m: &&ContactManifold<(), u32>| !m.points.is_empty();
            let mut found: Vec<u32> = manifolds.iter().filter(touching).map(of).collect();
            found.dedup();
            assert_eq!(found, parts, "{manifolds:?}");
            let mut count = 0;
            for m in manifolds.iter_mut().filter(|m| !m.points.is_empty()) {
                let part = compound.shapes()[of(m) as usize].0;
                let own = [m.subshape_pos1(), m.subshape_pos2()];
                assert_eq!(own[k], Some(&part));
                assert_eq!(own[1 - k], None);
                // Straight up from the compound, in its own frame.
                let normal = part.rotation * [m.local_n1, m.local_n2][k];
                assert!((normal - Vector::Z).length() < 1e-6, "{m:?}");
                for p in &mut m.points {
                    assert!((p.dist + 1e-3).abs() < 1e-6, "{m:?}");
                    count += 1;
                    p.data = count;
                }
            }
            let names = |all: &Manifolds| -> Vec<_> {
                let each = all.iter().flat_map(|m| {
                    let parts = [m.subshape1, m.subshape2];
                    let contact = move |p: &parry3d_f64::query::TrackedContact<u32>| {
                        (parts, p.fid1, p.fid2, p.data)
                    };
                    m.points.iter().map(contact)
                });
                each.collect()
            };
            let before = names(&manifolds);
            // A little aside and down: the same contacts, as the engine knows them.
            let moved = Pose::translation(1.5 + 1e-5, 0.5, 1.25 - 1.1e-3);
            let moved = [moved, moved.inverse()][k];
            ask(&moved, &mut manifolds);
            assert_eq!(names(&manifolds), before);
            // Away, and the pairs of parts are gone.
            let away = Pose::translation(1.5, 0.5, 9.0);
            ask(&[away, away.inverse()][k], &mut manifolds);
            assert!(manifolds.iter().all(|m| m.points.is_empty()));
        }
    }
}

/// A compound of a BREP and a ball stands on the ground of another BREP by the ball and on a plate by the BREP.
#[test]
fn a_compound_comes_to_rest() {
    let mut w = PhysicsWorld::new();
    w.narrow_phase
        .set_query_dispatcher(BrepDispatcher::new().chain(DefaultQueryDispatcher));
    w.gravity = Vector::new(0.0, 0.0, -9.81);
    w.integration_parameters.contact_recycling = false;
    let ground = w.insert_body(RigidBodyBuilder::fixed());
    // Parry's ground, which the BREP stands on; the balls stand on a BREP.
    let slab = ColliderBuilder::cuboid(5.0, 5.0, 0.5)
        .translation(Vector::new(0.0, 0.0, -0.5))
        .friction(0.5);
    w.insert_collider(slab, Some(ground));
    let body = RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.0, 0.2));
    let body = w.insert_body(body);
    let legs = [[-2.0, -1.0], [-2.0, 1.0]].map(|[x, y]| {
        let at = Pose::translation(x, y, 0.25);
        (at, SharedShape::ball(0.25))
    });
    let block = SharedShape::new(shape(block([1.0, -1.0, 0.0], [2.0, 1.0, 1.0])));
    let parts = legs.into_iter().chain([(Pose::IDENTITY, block)]);
    let whole = ColliderBuilder::compound(parts.collect()).friction(0.5);
    w.insert_collider(whole, Some(body));
    for _ in 0..400 {
        w.step();
    }
    let at = w.bodies[body].position();
    assert!(at.translation.length() < 0.01, "{at:?}");
    let up = at.transform_vector(Vector::Z);
    assert!(up.z > 1.0 - 1e-5, "{up:?}");
    assert!(w.bodies[body].is_sleeping());
}
