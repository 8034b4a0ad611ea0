//! Manifolds: which contacts, their features, and what the engine keeps of them.

use crate::scenes::{Random, block, cube, part, shape};
use feeler::brep::{Brep, BrepBuilder};
use feeler::nurbs::{NurbsSurface, Surface};
use feeler_rapier::{BrepDispatcher, BrepShape, Several};
use nalgebra::Vector4;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::{ContactManifold, ContactManifoldsWorkspace, PersistentQueryDispatcher};
use parry3d_f64::shape::{Ball, HalfSpace, Shape};

/// The walls x = 0, y = 0 and z = 0 of a room, as squares with sides of 10 towards positive coordinates.
fn corner() -> Brep {
    let mut b = BrepBuilder::new();
    let v: Vec<usize> = (0..7)
        .map(|i| b.vertex([0, 1, 2].map(|c| if i >> c & 1 == 1 { 10.0 } else { 0.0 })))
        .collect();
    for face in [[0, 1, 3, 2], [0, 4, 5, 1], [0, 2, 6, 4]] {
        b.planar_face(&face.map(|i: usize| v[i])).unwrap();
    }
    b.build().unwrap()
}

/// A flat plate of two squares, [0, 1] and [1, 2] by [0, 1].
fn two_squares() -> Brep {
    let mut b = BrepBuilder::new();
    let at = [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]];
    let v = at.map(|[x, y]| b.vertex([f64::from(x), f64::from(y), 0.0]));
    b.planar_face(&[v[0], v[1], v[4], v[3]]).unwrap();
    b.planar_face(&[v[1], v[2], v[5], v[4]]).unwrap();
    b.build().unwrap()
}

type Manifold = ContactManifold<(), u32>;

/// A pair as an engine holds it.
#[derive(Default)]
struct Held {
    manifolds: Vec<Manifold>,
    workspace: Option<ContactManifoldsWorkspace>,
}

impl Held {
    fn update(
        &mut self,
        pose: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        prediction: f64,
    ) -> Vec<(Vector, f64)> {
        let d = BrepDispatcher::new();
        d.contact_manifolds(
            pose,
            g1,
            g2,
            prediction,
            &mut self.manifolds,
            &mut self.workspace,
        )
        .unwrap();
        self.contacts()
    }

    /// Normals of the first shape and gaps.
    fn contacts(&self) -> Vec<(Vector, f64)> {
        let each = |m: &Manifold| {
            let n = m.local_n1;
            m.points
                .iter()
                .map(move |p| (n, p.dist))
                .collect::<Vec<_>>()
        };
        self.manifolds.iter().flat_map(each).collect()
    }
}

fn ball_at(brep: &BrepShape, at: [f64; 3], radius: f64, prediction: f64) -> Vec<(Vector, f64)> {
    let pose = Pose::from_translation(at.into());
    Held::default().update(&pose, brep, &Ball::new(radius), prediction)
}

#[test]
fn a_ball_in_a_corner_touches_three_walls() {
    for several in [Several::PerFace, Several::All] {
        let brep = shape(corner()).with_several(several);
        let mut found = ball_at(&brep, [0.99, 1.0, 1.01], 1.0, 0.02);
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
        assert_eq!(found.len(), 3, "{several:?} {found:?}");
        for ((normal, gap), (axis, truth)) in
            found
                .iter()
                .zip([(Vector::X, -0.01), (Vector::Y, 0.0), (Vector::Z, 0.01)])
        {
            assert!((*normal - axis).length() < 1e-12);
            assert!((gap - truth).abs() < 1e-12);
        }
        assert_eq!(ball_at(&brep, [0.99, 1.0, 1.01], 1.0, 0.005).len(), 2);
    }
    let brep = shape(corner()).with_several(Several::Deepest);
    assert_eq!(ball_at(&brep, [0.99, 1.0, 1.01], 1.0, 0.02).len(), 1);
}

#[test]
fn faces_that_go_on_smoothly_give_one_contact() {
    let brep = shape(two_squares());
    for x in [0.5, 0.9, 0.999, 1.0, 1.0 + 1e-9, 1.001, 1.3] {
        let found = ball_at(&brep, [x, 0.5, 0.5], 0.5, 0.1);
        assert_eq!(found.len(), 1, "{x} {found:?}");
        // A foot at whose distance of 0.5 the accuracy of 2^-40 sizes of 2 allows this angle.
        let angle = (2.0 * 2.0 / (1u64 << 40) as f64 / 0.5).sqrt();
        assert!((found[0].0 - Vector::Z).length() < angle, "{x} {found:?}");
    }
    // Beyond a convex edge, and at a vertex, too.
    let brep = shape(cube());
    assert_eq!(ball_at(&brep, [1.2, 0.5, 1.2], 0.3, 0.1).len(), 1);
    assert_eq!(ball_at(&brep, [1.2, 1.1, 1.2], 0.3, 0.1).len(), 1);
    // A ball that hangs over the edge of a top touches the top alone, though the side is within its reach.
    assert_eq!(ball_at(&brep, [0.95, 0.5, 1.25], 0.3, 0.1).len(), 1);
}

/// The trough z = x^2 / 8 over [-1, 1]^2 in two halves that share a border, but no edge.
fn halves() -> Brep {
    let mut b = BrepBuilder::new();
    for [from, to] in [[-1.0, 0.0], [0.0, 1.0]] {
        let mut net = Vec::new();
        for (x, z) in [
            (from, from * from),
            (0.5 * (from + to), from * to),
            (to, to * to),
        ] {
            net.push(Vector4::new(x, -1.0, z / 8.0, 1.0));
            net.push(Vector4::new(x, 1.0, z / 8.0, 1.0));
        }
        let knots = [vec![0., 0., 0., 1., 1., 1.], vec![0., 0., 1., 1.]];
        let half = NurbsSurface::new([2, 1], [3, 2], net, knots).unwrap();
        b.whole_surface(Surface::Nurbs(half));
    }
    b.build().unwrap()
}

/// The nearest point of the other half is on the border that both share, where this half goes on down.
#[test]
fn halves_without_a_common_edge_give_one_contact() {
    for several in [Several::PerFace, Several::All] {
        let brep = shape(halves()).with_several(several);
        for x in [-0.05, -1e-3, 1e-4, 0.01, 0.1] {
            // A ball of radius 1 whose foot is at x, 0.001 deep.
            let normal = Vector::new(-x / 4.0, 0.0, 1.0).normalize();
            let center = Vector::new(x, 0.0, x * x / 8.0) + normal * 0.999;
            let found = ball_at(&brep, center.into(), 1.0, 0.1);
            assert_eq!(found.len(), 1, "{several:?} {x} {found:?}");
            assert!((found[0].1 + 0.001).abs() < 1e-9, "{x} {found:?}");
            assert!((found[0].0 - normal).length() < 1e-5, "{x} {found:?}");
        }
    }
}

#[test]
fn a_centred_ball_touches_its_socket_all_around() {
    let brep = shape(part("ball_joint_cavity.3dm"));
    let found = ball_at(&brep, [0.0; 3], 2.51, 0.02);
    // 14 directions, and the deepest, which may be one of them.
    assert!((14..=15).contains(&found.len()), "{found:?}");
    for (_, gap) in &found {
        assert!((gap + 0.01).abs() < 1e-9, "{gap}");
    }
    for (k, a) in found.iter().enumerate() {
        assert!(found[..k].iter().all(|b| a.0.dot(b.0) < 0.999));
    }
}

#[test]
fn a_block_lies_flat_on_its_corners() {
    let brep = shape(cube());
    let ground = HalfSpace::new(Vector::Z);
    // The half-space in the block's frame: the block is 0.001 in the ground.
    let pose = Pose::translation(0.0, 0.0, 0.001);
    let mut held = Held::default();
    let found = held.update(&pose, &brep, &ground, 0.01);
    assert!(
        found.iter().all(|c| (c.1 + 0.001).abs() < 1e-12),
        "{found:?}"
    );
    let corners = held.manifolds[0].points.iter();
    let corners: Vec<_> = corners
        .filter(|p| p.fid1.is_vertex())
        .map(|p| p.local_p1)
        .collect();
    for x in [0.0, 1.0] {
        for y in [0.0, 1.0] {
            let at = Vector::new(x, y, 0.0);
            assert!(
                corners.iter().any(|c| (*c - at).length() < 1e-12),
                "{corners:?}"
            );
        }
    }
    assert_eq!(held.manifolds.len(), 1);
    // The other way round, tilted so that one edge is within reach.
    let tilted = Pose::new(Vector::ZERO, Vector::new(0.1, 0.0, 0.0));
    let mut held = Held::default();
    let found = held.update(&tilted, &ground, &brep, 0.01);
    assert!(
        found.iter().all(|c| c.1 < 0.01) && found.len() >= 2,
        "{found:?}"
    );
    assert!(found.iter().all(|c| c.0 == found[0].0));
}

#[test]
fn what_the_engine_keeps_stays_with_the_contact() {
    let brep = shape(two_squares());
    let ball = Ball::new(0.5);
    let mut held = Held::default();
    // From one square to the other: the feature changes, the contact is the same one.
    let mut features = Vec::new();
    for k in 0..=40 {
        let x = 0.9 + 0.005 * f64::from(k);
        held.update(&Pose::translation(x, 0.5, 0.49), &brep, &ball, 0.1);
        let point = &mut held.manifolds[0].points[0];
        if k > 0 {
            assert_eq!(point.data, 7, "at {x}");
        }
        point.data = 7;
        features.push(point.fid1);
    }
    features.dedup();
    assert!(features.len() >= 2, "{features:?}");
    // Gone, and back: nothing is left.
    assert!(
        held.update(&Pose::translation(1.0, 0.5, 2.0), &brep, &ball, 0.1)
            .is_empty()
    );
    held.update(&Pose::translation(1.0, 0.5, 0.49), &brep, &ball, 0.1);
    assert_eq!(held.manifolds[0].points[0].data, 0);
}

#[test]
fn contacts_of_a_corner_keep_their_own() {
    let brep = shape(corner());
    let ball = Ball::new(1.0);
    let mut held = Held::default();
    let mark = |n: Vector| 1 + n.to_array().iter().position(|x| *x > 0.5).unwrap() as u32;
    held.update(&Pose::translation(0.99, 1.0, 1.01), &brep, &ball, 0.02);
    for m in &mut held.manifolds {
        m.points[0].data = mark(m.local_n1);
    }
    // The deepest is another one now, and one of three goes.
    for at in [[1.01, 1.0, 0.99], [1.0, 0.98, 1.001], [1.0, 1.1, 1.0]] {
        held.update(&Pose::from_translation(at.into()), &brep, &ball, 0.02);
        for m in held.manifolds.iter().filter(|m| !m.points.is_empty()) {
            assert_eq!(m.points[0].data, mark(m.local_n1));
        }
    }
    assert_eq!(held.contacts().len(), 2);
}

#[test]
fn an_unsupported_pair_leaves_no_old_contacts() {
    let brep = shape(cube());
    let mut held = Held::default();
    let pose = Pose::translation(0.5, 0.5, 1.4);
    assert_eq!(held.update(&pose, &brep, &Ball::new(0.5), 0.1).len(), 1);
    let d = BrepDispatcher::with_report(|_| {});
    let other = shape(cube());
    let Held {
        manifolds,
        workspace,
    } = &mut held;
    let answer = d.contact_manifolds(&pose, &brep, &other, 0.1, manifolds, workspace);
    assert!(answer.is_err() && held.contacts().is_empty());
}

/// What is made on demand is the same whichever thread asks first.
#[test]
fn threads_get_the_same_bits() {
    let mut random = Random(21);
    let poses: Vec<Pose> = (0..64)
        .map(|_| Pose::from_translation(random.vector(3.0)))
        .collect();
    let ball = Ball::new(0.7);
    let ask = |brep: &BrepShape, pose: &Pose| -> Vec<[u64; 4]> {
        let found = Held::default().update(pose, brep, &ball, 0.5);
        let bits = |(n, d): &(Vector, f64)| [n.x, n.y, n.z, *d].map(f64::to_bits);
        found.iter().map(bits).collect()
    };
    for make in [
        || block([-1.0; 3], [1.0; 3]),
        || part("ball_joint_socket_nurbs.3dm"),
    ] {
        let serial = shape(make());
        let serial: Vec<_> = poses.iter().map(|p| ask(&serial, p)).collect();
        let shared = shape(make());
        let (ask, poses, shared) = (&ask, &poses, &shared);
        let parallel: Vec<_> = std::thread::scope(|s| {
            let jobs: Vec<_> = (0..4)
                .map(|k| {
                    s.spawn(move || {
                        let own = poses.iter().enumerate().skip(k).step_by(4);
                        own.rev_order()
                            .map(|(i, p)| (i, ask(shared, p)))
                            .collect::<Vec<_>>()
                    })
                })
                .collect();
            let mut all: Vec<_> = jobs.into_iter().flat_map(|j| j.join().unwrap()).collect();
            all.sort_by_key(|(i, _)| *i);
            all.into_iter().map(|(_, a)| a).collect()
        });
        assert_eq!(serial, parallel);
    }
}

trait Backwards: Iterator + Sized {
    /// The same in the opposite order.
    fn rev_order(self) -> std::iter::Rev<std::vec::IntoIter<Self::Item>> {
        self.collect::<Vec<_>>().into_iter().rev()
    }
}

impl<I: Iterator> Backwards for I {}
