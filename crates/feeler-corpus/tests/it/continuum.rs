//! Whether a contact is told as a continuum, against what the shapes of a block, a cylinder and a cone say. Both ways of asking must tell it.

use feeler::prepare::PreparedBrep;
use feeler::query::{Accuracy, Contacts, HalfSpace, Options, Probe, Sphere, Workspace, contact};
use feeler_corpus::Model;
use nalgebra::{Point3, Vector3};
use std::path::Path;

fn told(brep: &PreparedBrep, probe: Probe, expected: bool, what: &str) {
    for accuracy in [Accuracy::Full, Accuracy::Length(1e-9)] {
        for contacts in [Contacts::Deepest, Contacts::All] {
            let options = Options {
                accuracy,
                contacts,
                prediction: 16.0,
                node_budget: 2_000,
            };
            let answer = contact(brep, &probe, &options, &mut Workspace::default());
            let all = contacts == Contacts::All;
            assert!(answer.undecided.is_none() || all, "{what}: {answer:?}");
            // A list that is cut short may not have come to it.
            if answer.undecided.is_none() {
                assert_eq!(
                    answer.continuum, expected,
                    "{what} {probe:?} {options:?} {answer:?}"
                );
            }
        }
    }
}

fn half_space(brep: &PreparedBrep, normal: [f64; 3], expected: bool, what: &str) {
    let normal = Vector3::from(normal).normalize();
    let probe = HalfSpace::new(normal, 0.25).expect("a half-space");
    told(brep, Probe::HalfSpace(probe), expected, what);
}

fn ball(brep: &PreparedBrep, center: [f64; 3], expected: bool, what: &str) {
    let probe = Sphere::new(Point3::from(center), 0.125).expect("a ball");
    told(brep, Probe::Sphere(probe), expected, what);
}

fn each(name: &str, check: impl Fn(&PreparedBrep, &str)) {
    each_of("analytic", name, check);
}

fn each_of(folder: &str, name: &str, check: impl Fn(&PreparedBrep, &str)) {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models");
    for suffix in ["", "_nurbs"] {
        let name = format!("{name}{suffix}");
        let model = Model::load(&models.join(folder).join(format!("{name}.json.gz")), None);
        let brep = model.expect("a model of the corpus").breps.remove(0);
        check(&PreparedBrep::new(brep), &name);
    }
}

/// `[-1, 2] x [-2, 2] x [1/2, 11/2]`: a half-space rests on a face or an edge where a component of its normal is zero, else on a vertex.
#[test]
fn on_a_block() {
    each("block", |brep, what| {
        for a in [-1.0, 1.0] {
            for b in [-1.0, 0.75] {
                for k in 0..3 {
                    let normal = |p: f64, q: f64, r: f64| {
                        let all = [p, q, r];
                        std::array::from_fn(|c| all[(c + k) % 3])
                    };
                    half_space(brep, normal(a, 0.0, 0.0), true, what);
                    half_space(brep, normal(a, b, 0.0), true, what);
                    half_space(brep, normal(a, b, 0.5), false, what);
                    half_space(brep, normal(a, b, 1e-3), false, what);
                }
            }
        }
        for (center, why) in [
            ([0.5, 0.25, 6.0], "beside a face"),
            ([0.5, 2.25, 6.0], "beside an edge"),
            ([2.5, 2.25, 6.0], "beside a vertex"),
            ([2.0, 2.0, 6.0], "over a vertex"),
            ([2.0, 0.5, 6.0], "over an edge"),
        ] {
            ball(brep, center, false, &format!("{what}, {why}"));
        }
    });
}

/// The axis is `x = 1/4, y = 1/2`, the radius 3/2, and z goes from -1 to 4.
#[test]
fn on_a_cylinder() {
    each("cylinder", |brep, what| {
        for [x, y] in [
            [1.0, 0.0],
            [-1.0, 0.0],
            [0.0, 1.0],
            [0.0, -1.0],
            [0.6, 0.8],
            [-0.28, 0.96],
        ] {
            half_space(brep, [x, y, 0.0], true, what);
            half_space(brep, [x, y, 0.5], false, what);
            half_space(brep, [x, y, -1e-3], false, what);
            ball(brep, [0.25 + 2.0 * x, 0.5 + 2.0 * y, 0.5], false, what);
            ball(brep, [0.25 + 2.0 * x, 0.5 + 2.0 * y, 4.5], false, what);
            ball(brep, [0.25 + x, 0.5 + y, 3.0], false, what);
        }
        half_space(brep, [0.0, 0.0, 1.0], true, what);
        half_space(brep, [0.0, 0.0, -1.0], true, what);
        ball(brep, [0.25, 0.5, 1.5], true, what);
        ball(brep, [0.25, 0.5, 4.5], false, what);
    });
}

/// The base has radius 3 about the origin, the apex is `(0, 0, 4)`: a half-space rests on a generator where its normal is `-(4 cos, 4 sin, 3) / 5`.
#[test]
fn on_a_cone() {
    each("cone", |brep, what| {
        for [x, y] in [
            [1.0, 0.0],
            [-1.0, 0.0],
            [0.0, 1.0],
            [0.6, 0.8],
            [-0.28, 0.96],
        ] {
            half_space(brep, [-4.0 * x, -4.0 * y, -3.0], true, what);
            half_space(brep, [-4.0 * x, -4.0 * y, -2.5], false, what);
            half_space(brep, [-4.0 * x, -4.0 * y, -3.5], false, what);
            half_space(brep, [4.0 * x, 4.0 * y, 3.0], false, what);
        }
        half_space(brep, [0.0, 0.0, 1.0], true, what);
        half_space(brep, [0.0, 0.0, -1.0], false, what);
        ball(brep, [0.0, 0.0, 1.0], false, what);
    });
}

/// The centre is `(1/2, -1/4, 1)`, the radius 2, and the poles are along z: on their axis as anywhere else but in the centre one point is nearest, and one is lowest.
#[test]
fn on_a_sphere() {
    each("sphere", |brep, what| {
        for direction in [
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
            [1.0, 0.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.6, 0.0, 0.8],
            [-0.48, 0.64, -0.6],
        ] {
            for far in [0.5, 1.75, 2.25, 8.0] {
                let [x, y, z] = direction.map(|d| far * d);
                ball(brep, [0.5 + x, -0.25 + y, 1.0 + z], false, what);
            }
            half_space(brep, direction, false, what);
        }
        ball(brep, [0.5, -0.25, 1.0], true, what);
    });
}

/// A round of radius 2 goes on along x from 5 to 25 as a cylinder, and round a corner at either end as a torus, whose foot is next to the edge by roundings: what is
/// as low is on the other face.
#[test]
fn beside_an_edge_of_the_face_that_is_as_low() {
    each_of("parts", "tangent_rounds", |brep, what| {
        for k in 1..16 {
            let tilt = f64::from(k) / 64.0;
            half_space(brep, [0.0, tilt, -1.0], true, what);
            half_space(brep, [1e-3, tilt, -1.0], false, what);
        }
    });
}

/// The body is a cylinder of radius 12 from z = 1.5 to 10, and leans inward above: along the generator where a half-space touches it all is at one height. What leans
/// inward stands alone at its end, where a loop runs along the border of its domain.
#[test]
fn on_a_generator_that_ends_where_another_face_leans_inward() {
    each_of("parts", "nozzle", |brep, what| {
        for normal in [
            [0.0, -1.0, 0.0],
            [0.0, 1.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.6, 0.8, 0.0],
        ] {
            half_space(brep, normal, true, what);
        }
        for normal in [[0.0, -1.0, 1e-3], [0.0, -1.0, -1e-3]] {
            half_space(brep, normal, false, what);
        }
    });
}
