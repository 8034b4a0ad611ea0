//! What is said of feet: lists of contacts hold none next to an edge beyond which the other face leads down, and no
//! bound is claimed where the nearest point may be on a trim that was not searched.

use feeler::brep::Brep;
use feeler::nurbs::{Curve, NurbsCurve};
use feeler::prepare::PreparedBrep;
use feeler::query::{Contacts, Feature, HalfSpace, Options, Probe, Sphere, Workspace, contact};
use feeler_corpus::Model;
use nalgebra::{Point3, Vector3};
use std::path::Path;

fn prepared(path: &str) -> PreparedBrep {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models");
    let model = Model::load(&models.join(path), None).expect("a model of the corpus");
    PreparedBrep::new(model.breps.into_iter().next().expect("a BREP"))
}

/// The centre is on the cube's top (z = 10), `radius` from the circle in which a sphere about (10, 10, 10) cuts a corner
/// off. Over the spherical face alone the distance has its least value on that circle; but from there the top leads
/// straight to the centre, where it is 0: the one contact there is.
#[test]
fn a_foot_next_to_an_edge_is_no_contact_where_the_other_face_leads_down() {
    let brep = prepared("thesis/cube_corner_sphere_cut.3dm");
    let center = Point3::new(7.726805820561969, 6.612428456800106, 10.0);
    let radius = 0.07958977576723691;
    let probe = Probe::Sphere(Sphere::new(center, radius).expect("a sphere"));
    let options = Options {
        contacts: Contacts::All,
        ..Options::default()
    };
    let found = contact(&brep, &probe, &options, &mut Workspace::default());
    assert_eq!(found.contacts.len(), 1, "{found:?}");
    // The top's plane and trim are those of the file, within roundings.
    let off = 1e-14;
    assert!(
        (found.contacts[0].on_brep - center).norm() < off,
        "{found:?}"
    );
}

/// At the pole of the cavity a trim without an edge runs once around in uv: with weights of 1 and 4096, as the same segment of another parameter, nearly all of its parameters
/// are at one end. The ways down from the pole are as they were, to the two contacts that the stored truth of the suite `contacts` has.
#[test]
fn a_pole_is_no_contact_whatever_the_parameter_of_its_trim() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models");
    let path = models.join("thesis/ball_joint_cavity.3dm");
    let model = Model::load(&path, None).expect("a model of the corpus");
    let brep = model.breps.into_iter().next().expect("a BREP");
    let normal = Vector3::new(
        0.2566149055275333,
        -0.43320080610679446,
        -0.8639941272077712,
    );
    let below = HalfSpace::new(normal, 2.191873733884125).expect("a half-space");
    let options = Options {
        contacts: Contacts::All,
        prediction: 1e-7,
        ..Options::default()
    };
    for weight in [1.0, 4096.0] {
        let mut parts = brep.parts().clone();
        let poles: Vec<usize> = { parts.trims.iter() }
            .filter(|t| t.edge.is_none())
            .map(|t| t.curve)
            .collect();
        assert!(!poles.is_empty());
        for curve in poles {
            let Curve::Line(line) = &parts.curves2[curve] else {
                panic!("{:?}", parts.curves2[curve]);
            };
            let (from, to, d) = (line.from, line.to, line.domain);
            let points = vec![from.coords.push(1.0), to.coords.push(1.0) * weight];
            let nurbs = NurbsCurve::new(1, points, vec![d.start, d.start, d.end, d.end]);
            parts.curves2[curve] = Curve::Nurbs(nurbs.expect("a segment"));
        }
        let brep = PreparedBrep::new(Brep::new(parts).expect("a BREP"));
        let probe = Probe::HalfSpace(below);
        let found = contact(&brep, &probe, &options, &mut Workspace::default());
        assert_eq!(found.contacts.len(), 2, "{weight}: {found:?}");
    }
}

/// The trims between a bore and a sphere, and between two bores, have images of too high a degree: only their patch bounds
/// them. The lowest and nearest points are on such trims, on these places as the oracle encloses them to 1e-14: the
/// stored truth of the suite `parts`.
#[test]
fn a_bound_on_the_foot_counts_trims_that_were_not_searched() {
    let normal = Vector3::new(0.9353579263971028, 0.07693770206934603, -0.3452334565571542);
    let half_space = HalfSpace::new(normal, -8.203662682939845).expect("a half-space");
    let center = Point3::new(11.997735888075539, -0.23164965091333686, 5.184654816469871);
    let sphere = Sphere::new(center, 3.9896194710549557).expect("a sphere");
    for (model, probe, foot) in [
        (
            "parts/bored_sphere.json.gz",
            Probe::HalfSpace(half_space),
            Point3::new(-10.95536996441265, -1.2104358137022477, 4.744967237373946),
        ),
        (
            "parts/nozzle.json.gz",
            Probe::Sphere(sphere),
            Point3::new(11.94357290251745, -1.162353784889138, 5.948121130844522),
        ),
    ] {
        let brep = prepared(model);
        let found = contact(
            &brep,
            &probe,
            &Options::default(),
            &mut Workspace::default(),
        );
        for c in &found.contacts {
            let off = (c.on_brep - foot).norm();
            // What the place above is rounded by.
            let least = off - 1e-13;
            assert!(
                c.position_bound.is_none_or(|b| b >= least),
                "{model} {off}: {c:?}"
            );
        }
    }
}

/// A hole's circle ends a rounding beside its start, and the segment that joins both belongs to no trim. What touches there touches
/// the vertex: that it is a rounding within the face must not make it the face's.
#[test]
fn where_a_circle_closes_it_is_the_vertex_that_is_touched() {
    let brep = prepared("cases/F2.json.gz");
    let options = Options {
        contacts: Contacts::All,
        prediction: 0.125,
        ..Options::default()
    };
    let mut at_vertex = 0;
    for k in 54..70 {
        for y in [-1.0, 1.0].map(|sign| sign * 2f64.powi(-k)) {
            let probe = Probe::Sphere(Sphere::new(Point3::new(0.0, y, 0.0), 0.5).expect("a ball"));
            let found = contact(&brep, &probe, &options, &mut Workspace::default());
            for c in &found.contacts {
                assert_ne!(c.feature, Feature::Face(0), "{y:e}: {c:?}");
                at_vertex += usize::from(c.feature == Feature::Vertex(1));
            }
        }
    }
    assert!(at_vertex > 0);
}

/// The centre is the pole of a sphere that is turned by a rounding, where no azimuth is known of its foot. What is listed is within the prediction all
/// the same, decided or not: not some place of the sphere.
#[test]
fn at_a_pole_no_other_place_of_the_sphere_is_listed() {
    let brep = prepared("step/ball_and_cone.step");
    let pole = Point3::new(0.9188527477558506, -1.1282791216337753, 2.884837364898327);
    for (radius, prediction) in [(0.0, 0.5), (1e-3, 0.5), (0.0, 5.0), (1e-3, 5.0)] {
        let probe = Probe::Sphere(Sphere::new(pole, radius).expect("a ball"));
        let options = Options {
            contacts: Contacts::All,
            prediction,
            ..Options::default()
        };
        let found = contact(&brep, &probe, &options, &mut Workspace::default());
        assert!(!found.contacts.is_empty(), "{found:?}");
        for c in &found.contacts {
            // A sphere has one nearest point, and the cone's tip and rim are lower elsewhere.
            assert!((c.on_brep - pole).norm() < 1e-6, "{prediction}: {c:?}");
        }
    }
}

/// The outer loop leaves the domain, so that the face ends where the surface does: the middle of that end is far from all trims, and on the edge that is straight out of it.
#[test]
fn where_a_surface_ends_within_a_loop_a_foot_is_on_the_edge_beyond() {
    let brep = prepared("trim-loops/tiny_hole_1e-15.json.gz");
    let center = Point3::new(-0.25, 0.46875, 0.0);
    let probe = Probe::Sphere(Sphere::new(center, 0.5).expect("a sphere"));
    let found = contact(
        &brep,
        &probe,
        &Options::default(),
        &mut Workspace::default(),
    );
    let [only] = found.contacts.as_slice() else {
        panic!("{found:?}");
    };
    assert_eq!(only.on_brep, Point3::new(0.0, 0.46875, 0.0));
    // Of four edges around the face, from the lower side on, the last: from u = -0.5, v = 0.9375 to v = -0.5.
    assert_eq!(only.feature, Feature::Edge(3), "{found:?}");
}
