//! All contacts within a prediction, against what geometry says.

use feeler::brep::{Brep, BrepBuilder};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    ContactAnswer, Contacts, HalfSpace, Options, Probe, Sphere, Workspace, contact,
};
use nalgebra::{Point3, Vector3};

/// The box [0, 1]^3.
fn cube() -> Brep {
    let mut b = BrepBuilder::new();
    let corner = |i: usize| [(i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64];
    let v: Vec<usize> = (0..8).map(|i| b.vertex(corner(i))).collect();
    for face in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ] {
        b.planar_face(&face.map(|i| v[i])).unwrap();
    }
    b.build().unwrap()
}

fn all(brep: &PreparedBrep, probe: &Probe, prediction: f64) -> ContactAnswer {
    let options = Options {
        contacts: Contacts::All,
        prediction,
        ..Options::default()
    };
    contact(brep, probe, &options, &mut Workspace::default())
}

/// Exactly these, in this order: where, and their separations.
fn must_be(answer: &ContactAnswer, expected: &[([f64; 3], f64)]) {
    assert_eq!(answer.undecided, None);
    assert_eq!(answer.contacts.len(), expected.len(), "{answer:#?}");
    for (c, (at, separation)) in answer.contacts.iter().zip(expected) {
        assert!((c.on_brep - Point3::from(*at)).norm() < 1e-12, "{c:#?}");
        assert!((c.separation.value - separation).abs() < 1e-14, "{c:#?}");
    }
}

#[test]
fn a_ball_about_a_box() {
    let cube = PreparedBrep::new(cube());
    let ask = |c: [f64; 3], r, p| {
        let ball = Probe::Sphere(Sphere::new(c.into(), r).unwrap());
        all(&cube, &ball, p)
    };
    // Before a corner and before an edge: where other faces and edges end there, they go on falling elsewhere.
    let d = (0.01f64 + 0.04 + 0.09).sqrt();
    must_be(&ask([1.1, 1.2, 1.3], 0.0, 5.0), &[([1.0; 3], d)]);
    let edge = [([1.0, 1.0, 0.25], 0.5)];
    must_be(&ask([1.3, 1.4, 0.25], 0.0, 5.0), &edge);
    // Before a face: its foot, and that of the face behind.
    let two = [([1.0, 0.5, 0.25], 0.25), ([0.0, 0.5, 0.25], 1.25)];
    must_be(&ask([1.5, 0.5, 0.25], 0.25, 5.0), &two);
    must_be(&ask([1.5, 0.5, 0.25], 0.25, 0.125), &[]);
    // In the box the nearest comes first; the others as far as ball and prediction reach, that distance included.
    let c = [0.875, 0.75, 0.5];
    must_be(&ask(c, 0.0625, 0.0625), &[([1.0, 0.75, 0.5], -0.1875)]);
    let two = [([1.0, 0.75, 0.5], -0.375), ([0.875, 1.0, 0.5], -0.5)];
    must_be(&ask(c, 0.25, 0.0), &two);
    assert_eq!(ask(c, 1.0, 0.0).contacts.len(), 6);
}

#[test]
fn a_half_space_and_a_box() {
    let cube = PreparedBrep::new(cube());
    let normal = Vector3::new(0.6, 0.48, 0.64);
    let below = Probe::HalfSpace(HalfSpace::new(normal, 0.0).unwrap());
    // The other vertices are none: along an edge each of them falls, though the steepest way leaves the face.
    must_be(&all(&cube, &below, 9.0), &[([0.0; 3], 0.0)]);
}
