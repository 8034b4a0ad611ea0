//! Every kind of surface and curve of OCCT's text format against what OCCT itself says of the files (`corpora/make_brep.py`).

use feeler::brep::Brep;
use feeler::prepare::PreparedBrep;
use feeler::query::*;
use feeler::trim::Side;
use feeler_io::{Document, ObjectKind, read_file};
use nalgebra::{Point3, Vector3};
use serde::Deserialize;
use std::path::PathBuf;

/// What OCCT says of a file.
#[derive(Deserialize)]
struct Said {
    solids: usize,
    faces: Vec<SaidFace>,
    /// x, y, z, distance from the faces, whether in a solid.
    distances: Vec<(f64, f64, f64, f64, bool)>,
}

#[derive(Deserialize)]
struct SaidFace {
    reversed: bool,
    /// u, v and the point there.
    points: Vec<[f64; 5]>,
}

/// OCCT evaluates in f64, and so does the test: some tens of roundings of the size.
const ROUNDINGS: f64 = 64.0 * f64::EPSILON;

/// To edges OCCT measures along their curves in space, which are off the faces by as much as their tolerance, 1e-7 here or
/// what an intersection was found to.
const OCCT: f64 = 2e-6;

/// The same where OCCT fitted the curves in space to straight ones in uv (`BRepLib::BuildCurves3d`): its default tolerance.
const FITTED: f64 = 1e-5;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/brep")
}

fn read(name: &str) -> (Document, Said) {
    let path = folder().join(name);
    let document = read_file(path.with_extension("brep")).expect("a file of the corpus");
    let said = std::fs::read_to_string(path.with_extension("json")).expect("a file of the corpus");
    (
        document,
        serde_json::from_str(&said).expect("what OCCT says"),
    )
}

fn breps(document: &Document) -> Vec<Brep> {
    let own = document.objects.iter().enumerate();
    let own = own.filter(|(_, o)| !o.block_member);
    own.flat_map(|(i, _)| document.parts(i))
        .map(|o| match &o.kind {
            ObjectKind::Brep(brep) => brep.clone(),
            other => panic!("{other:?}"),
        })
        .collect()
}

/// Points of all faces, their orientation, and whether each solid is one.
fn check_faces(name: &str, breps: &[Brep], said: &Said) {
    let faces = breps
        .iter()
        .flat_map(|b| (0..b.faces().len()).map(move |f| (b, f)));
    let faces: Vec<_> = faces.collect();
    assert_eq!(faces.len(), said.faces.len(), "{name}");
    assert_eq!(
        breps.iter().filter(|b| b.is_closed()).count(),
        said.solids,
        "{name}"
    );
    for (i, ((brep, f), said)) in faces.into_iter().zip(&said.faces).enumerate() {
        assert_eq!(brep.faces()[f].reversed, said.reversed, "{name} face {i}");
        let surface = brep.surface(f);
        let mut within = 0;
        for &[u, v, x, y, z] in &said.points {
            let [du, dv] = surface.domain();
            // OCCT's ranges of u and v may be wider than the face.
            if !du.contains(u) || !dv.contains(v) {
                continue;
            }
            within += 1;
            let p = Vector3::new(x, y, z);
            let off = (surface.point(u, v).coords - p).norm();
            let slack = ROUNDINGS * p.amax().max(1.0);
            assert!(off <= slack, "{name} face {i}: off by {off:e} at {u}, {v}");
        }
        assert!(within >= 8, "{name} face {i}");
    }
}

/// Distances of points from all faces, and their sides.
fn check_distances(name: &str, breps: &[Brep], said: &Said, most: f64) {
    let prepared: Vec<_> = breps
        .iter()
        .map(|b| PreparedBrep::new((*b).clone()))
        .collect();
    let mut workspace = Workspace::default();
    assert!(said.distances.len() >= 8, "{name}");
    for &(x, y, z, distance, is_inside) in &said.distances {
        let q = Point3::new(x, y, z);
        let options = Options {
            accuracy: Accuracy::Length(1e-9),
            contacts: Contacts::None,
            ..Options::default()
        };
        let sphere = Probe::Sphere(Sphere::new(q, 0.0).expect("a point"));
        let nearest = prepared.iter().map(|b| {
            contact(b, &sphere, &options, &mut workspace)
                .separation
                .value
        });
        let nearest = nearest.map(f64::abs).fold(f64::INFINITY, f64::min);
        assert!(
            (nearest - distance).abs() <= most,
            "{name}, {q}: {nearest}, OCCT says {distance}"
        );
        let sides: Vec<_> = prepared
            .iter()
            .map(|b| inside(b, q, &mut workspace).side)
            .collect();
        assert!(sides.iter().all(Option::is_some), "{name}, {q}: {sides:?}");
        assert_eq!(
            sides.contains(&Some(Side::Inside)),
            is_inside,
            "{name}, {q}"
        );
    }
}

#[test]
fn every_kind_of_surface_and_curve_is_what_occt_says() {
    for name in [
        "primitives",
        "mirrored",
        "seams",
        "placed",
        "surfaces",
        "planar",
        "version1",
        "version2",
        "version3",
        "torus_nurbs",
    ] {
        let (document, said) = read(name);
        let breps = breps(&document);
        check_faces(name, &breps, &said);
        check_distances(name, &breps, &said, OCCT);
        for brep in breps {
            for d in brep.defects() {
                // Loose faces have borders; an intersection is as good as OCCT found it.
                assert!(d.severity() <= feeler::brep::Severity::Note, "{name}: {d}");
            }
        }
    }
}

/// Faces that wind, and conics that are extruded or turned, whose surfaces have other parameters here.
#[test]
fn distances_of_threads_and_conics_are_what_occt_says() {
    for (name, most) in [("winding", FITTED), ("conics", OCCT)] {
        let (document, said) = read(name);
        let breps = breps(&document);
        assert_eq!(
            breps.iter().filter(|b| b.is_closed()).count(),
            said.solids,
            "{name}"
        );
        check_distances(name, &breps, &said, most);
    }
}

#[test]
fn versions_differ_in_nothing_that_is_read() {
    let [one, two, three] = ["version1", "version2", "version3"].map(|v| read(v).0);
    assert_eq!([one.version, two.version, three.version], [1, 2, 3]);
    // Seven triangulations, and 31 edges on them.
    let warning = "38 triangulations and polygons are for display: not read";
    assert_eq!(one.warnings, [warning]);
    // Where they stand in the file differs.
    let kinds = |d: Document| d.objects.into_iter().map(|o| o.kind).collect::<Vec<_>>();
    let one = kinds(one);
    assert!(one == kinds(two));
    assert!(one == kinds(three));
}

#[test]
fn what_has_no_exact_form_is_refused_by_name_and_costs_nothing_else() {
    let (document, _) = read("refused");
    let reasons: Vec<String> = document
        .objects
        .iter()
        .map(|o| match &o.kind {
            ObjectKind::Refused { class, reason } => {
                assert_eq!(class, "brep of a shell");
                reason.to_string()
            }
            kind => kind.name().to_owned(),
        })
        .collect();
    let expected = ["an offset surface", "brep", "brep", "brep", "brep"];
    assert_eq!(reasons.len(), expected.len());
    for (reason, expected) in reasons.iter().zip(expected) {
        assert!(reason.contains(expected), "{reason}");
    }
}

/// Moved by locations of the file, nested and to powers: said, and where OCCT has it.
#[test]
fn locations_are_said() {
    let (document, _) = read("placed");
    // Five solids of one shape, in compounds within compounds.
    let placed: Vec<_> = document.placements(0).collect();
    assert_eq!(placed.len(), 5);
    assert!(placed.iter().all(|p| p.index == placed[0].index));
    let parts = placed.iter().map(|p| p.placed());
    let warned = parts.filter(|o| o.warnings.iter().any(|w| w.starts_with("moved")));
    assert_eq!(warned.count(), 5);
}
