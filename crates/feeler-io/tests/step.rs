//! STEP files: against the same shape's .brep, and against what OCCT says of the shape that they were written from.

use feeler::brep::Brep;
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, Contacts, LineKind, LineProbe, Options, Probe, Sphere, Workspace, contact, inside,
    line,
};
use feeler::trim::Side;
use feeler_io::{Document, Format, ObjectKind, Units, read_file};
use nalgebra::{Point3, Vector3};
use std::path::{Path, PathBuf};

fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models")
}

fn file(name: &str) -> Document {
    read_file(models().join(name)).unwrap_or_else(|e| panic!("{e}"))
}

/// The document's BREPs; none may be refused.
fn breps(name: &str, document: &Document) -> Vec<Brep> {
    for object in &document.objects {
        if let ObjectKind::Refused { class, reason } = &object.kind {
            panic!("{name}: {class}: {reason}");
        }
    }
    document.bodies().map(|(_, b)| b.clone()).collect()
}

/// Knuth's multiplier (MMIX): the same numbers everywhere.
struct Random(u64);

impl Random {
    /// From 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, half: f64) -> Point3<f64> {
        Point3::from([0; 3].map(|_| half * (2.0 * self.next() - 1.0)))
    }
}

fn largest(brep: &Brep) -> f64 {
    let vertices = brep.parts().vertices.iter();
    vertices.map(|v| v.point.coords.amax()).fold(0.0, f64::max)
}

fn options(accuracy: f64) -> Options {
    Options {
        accuracy: Accuracy::Length(accuracy),
        contacts: Contacts::None,
        ..Options::default()
    }
}

/// The thesis's parts that the project has as STEP.
const PARTS: [&str; 6] = [
    "ball_joint_socket",
    "cube_corner_cut",
    "cylinder",
    "geneva4_wheel",
    "sheet_trimmed",
    "shift_gate",
];

/// OCCT prints 12 decimals into STEP files: half a unit of a direction's, times the size, for each of a face's two directions and its
/// edges'.
const PRINTED: f64 = 2e-12;

#[test]
fn a_step_file_answers_as_its_brep() {
    for part in PARTS {
        let document = file(&format!("thesis/{part}.step"));
        assert_eq!((document.format, document.version), (Format::Step, 214));
        assert_eq!(document.units, Units::Millimetres);
        let ours = breps(part, &document);
        let theirs = breps(part, &file(&format!("thesis/{part}.brep")));
        assert_eq!((ours.len(), theirs.len()), (1, 1), "{part}");
        assert_eq!(ours[0].faces().len(), theirs[0].faces().len());
        assert_eq!(ours[0].is_closed(), theirs[0].is_closed(), "{part}");
        let size = largest(&theirs[0]);
        let slack = PRINTED * size;
        let both = [&ours[0], &theirs[0]].map(|b| PreparedBrep::new(b.clone()));
        let mut w = Workspace::default();
        let mut r = Random(1);
        let options = options(0.01 * slack);
        let mut decided = 0;
        for _ in 0..200 {
            let p = r.within(1.3 * size);
            let ball = Probe::Sphere(Sphere::new(p, 0.0).unwrap());
            let [a, b] = both
                .each_ref()
                .map(|brep| contact(brep, &ball, &options, &mut w).separation.bounds);
            assert!(
                a.lo <= b.hi + slack && b.lo <= a.hi + slack,
                "{part} at {p}: {a:?} and {b:?}"
            );
            let [x, y] = both.each_ref().map(|brep| inside(brep, p, &mut w).side);
            assert!(x == y || x.is_none() || y.is_none(), "{part} at {p}");
            let to = r.within(1.3 * size);
            let probe = LineProbe::new(p, to - p, LineKind::Line).unwrap();
            let [x, y] = both
                .each_ref()
                .map(|brep| line(brep, &probe, &options, &mut w));
            if x.undecided.is_some() || y.undecided.is_some() {
                continue;
            }
            decided += 1;
            assert_eq!(x.hits.len(), y.hits.len(), "{part} at {p}");
            for (h, k) in x.hits.iter().zip(&y.hits) {
                // Farther where the line is flat to the face.
                let sine = h.normal.dot(&probe.direction.normalize()).abs();
                assert!(
                    (h.point - k.point).norm() * sine <= 4.0 * slack,
                    "{part} at {p}"
                );
            }
        }
        assert!(decided >= 190, "{part}: {decided} lines decided");
    }
}

/// OCCT's own accuracy: it stops where a step is 1e-7, and edges that it intersected are within 1e-7 of their faces.
const OCCT: f64 = 4e-7;

#[test]
fn distances_and_sides_are_those_that_occt_says_of_the_shape() {
    let mut folder: Vec<PathBuf> = std::fs::read_dir(models().join("step"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "step"))
        .collect();
    folder.sort();
    folder.retain(|p| p.file_stem().unwrap() != REFUSED);
    assert!(folder.len() >= 60, "{} files", folder.len());
    let wrong: Vec<String> = folder.iter().filter_map(|p| of_occt(p).err()).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Its bores are closed B-splines, whose holes lie across the line where they start.
const REFUSED: &str = "bored_nurbs_seamless";

#[test]
fn what_is_not_supported_is_refused_by_its_number() {
    let document = file(&format!("step/{REFUSED}.step"));
    let [object] = &document.objects[..] else {
        panic!("{} objects", document.objects.len());
    };
    let ObjectKind::Refused { class, reason } = &object.kind else {
        panic!("{}", object.kind.name());
    };
    assert_eq!(class, "manifold_solid_brep");
    let why = reason.to_string();
    assert!(
        why.starts_with('#') && why.contains("split closed faces at seams"),
        "{why}"
    );
}

/// One file; says what is wrong.
fn of_occt(path: &Path) -> Result<(), String> {
    let stem = path.file_stem().unwrap().to_str().unwrap();
    let base = ["_bare", "_inch_203", "_242", "_seamless"]
        .iter()
        .fold(stem, |s, end| s.strip_suffix(end).unwrap_or(s));
    let facts = std::fs::read_to_string(models().join(format!("step/{base}.json"))).unwrap();
    let facts: serde_json::Value = serde_json::from_str(&facts).unwrap();
    let mut document = read_file(path).map_err(|e| e.to_string())?;
    if stem.contains("inch") {
        assert_eq!(
            (document.units.clone(), document.version),
            (Units::Inches, 203)
        );
        document.convert_units(Units::Millimetres).unwrap();
    }
    assert_eq!(document.units, Units::Millimetres, "{stem}");
    for object in &document.objects {
        match &object.kind {
            ObjectKind::Refused { reason, .. } => return Err(format!("{stem}: {reason}")),
            ObjectKind::Brep(b) if !b.is_closed() => {
                return Err(format!("{stem}: open; {:?}", object.warnings));
            }
            _ => {}
        }
    }
    let bodies = document.bodies().map(|(_, b)| b.clone());
    let prepared: Vec<PreparedBrep> = bodies.map(PreparedBrep::new).collect();
    assert_eq!(prepared.len() as u64, facts["solids"], "{stem}");
    let mut w = Workspace::default();
    let options = options(1e-9);
    for fact in facts["points"].as_array().unwrap() {
        let at = |k: usize| fact["point"][k].as_f64().unwrap();
        let p = Point3::new(at(0), at(1), at(2));
        let ball = Probe::Sphere(Sphere::new(p, 0.0).unwrap());
        let mut least = f64::INFINITY;
        let mut is_inside = false;
        for b in &prepared {
            let answer = contact(b, &ball, &options, &mut w);
            if answer.undecided.is_some() {
                return Err(format!("{stem} at {p}: {answer:?}"));
            }
            least = least.min(answer.separation.value.abs());
            let side = inside(b, p, &mut w).side;
            if side.is_none() {
                return Err(format!("{stem} at {p}: the side is undecided"));
            }
            is_inside |= side == Some(Side::Inside);
        }
        let theirs = fact["distance"].as_f64().unwrap();
        if !((least - theirs).abs() <= OCCT) || fact["inside"].as_bool() != Some(is_inside) {
            let said = (theirs, fact["inside"].as_bool());
            return Err(format!(
                "{stem} at {p}: {least}, {is_inside}; OCCT {said:?}"
            ));
        }
    }
    Ok(())
}

/// Faces that turn their sides: the normals of hits point out of the material.
#[test]
fn normals_point_out_of_the_material() {
    for name in ["bored_bare", "filleted", "ball_and_cone", "revolution"] {
        let document = file(&format!("step/{name}.step"));
        let brep = breps(name, &document).remove(0);
        let size = largest(&brep);
        let prepared = PreparedBrep::new(brep);
        let mut w = Workspace::default();
        let mut r = Random(7);
        let mut hits = 0;
        for _ in 0..200 {
            let (p, q) = (r.within(2.0 * size), r.within(size));
            let probe = LineProbe::new(p, q - p, LineKind::Line).unwrap();
            for hit in line(&prepared, &probe, &options(1e-9 * size), &mut w).hits {
                let step: Vector3<f64> = hit.normal * (1e-3 * size);
                let [out, into] =
                    [hit.point + step, hit.point - step].map(|p| inside(&prepared, p, &mut w).side);
                if out != into {
                    assert_eq!(out, Some(Side::Outside), "{name} at {}", hit.point);
                    hits += 1;
                }
            }
        }
        assert!(hits > 20, "{name}: {hits}");
    }
}
