//! Extrusions, blocks, hidden and locked objects against what rhino3dm says of the files (`corpora/make_3dm.py`).

use feeler::brep::{Brep, Severity};
use feeler::prepare::PreparedBrep;
use feeler::query::*;
use feeler::trim::Side;
use feeler_corpus::Model;
use feeler_io::{Choice, Document, Object, ObjectKind, Units, read_file};
use nalgebra::{Point3, Vector3};
use serde::Deserialize;
use std::borrow::Cow;
use std::path::PathBuf;

#[derive(Deserialize)]
struct Said<T> {
    objects: Vec<T>,
}

#[derive(Deserialize)]
struct Shape {
    solid: bool,
    faces: usize,
    /// Points of the faces with outward normals.
    on: Vec<[f64; 6]>,
    /// Those that do not lie on a face's border.
    beside: Vec<[f64; 6]>,
}

#[derive(Deserialize)]
struct Extrusion {
    object: usize,
    name: String,
    #[serde(flatten)]
    shape: Shape,
}

#[derive(Deserialize)]
struct Block {
    object: usize,
    block: String,
    exact: bool,
    parts: Vec<Shape>,
}

#[derive(Deserialize)]
struct Mode {
    object: usize,
    name: String,
    layer: String,
    hidden: bool,
    locked: bool,
}

/// rhino3dm evaluates in f64, and import rounds: some hundred roundings of the size (coordinates up to 50).
const OFF: f64 = 256.0 * f64::EPSILON * 50.0;
/// How far beside a face its sides are asked: less than anything is thick here.
const STEP: f64 = 1e-3;

fn file(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../corpora/models/3dm")
        .join(name)
}

fn read<T: for<'a> Deserialize<'a>>(name: &str, said: &str) -> (Document, Vec<T>) {
    let document = read_file(file(name)).expect("a file of the corpus");
    let said = std::fs::read_to_string(file(said)).expect("a file of the corpus");
    let said: Said<T> = serde_json::from_str(&said).expect("what rhino3dm says");
    (document, said.objects)
}

fn check(what: &str, brep: &Brep, said: &Shape) {
    assert_eq!(brep.faces().len(), said.faces, "{what}");
    assert_eq!(brep.is_closed(), said.solid, "{what}");
    for d in brep.defects() {
        assert!(d.severity() <= Severity::Note, "{what}: {d}");
    }
    let prepared = PreparedBrep::new(brep.clone());
    let mut workspace = Workspace::default();
    let options = Options {
        accuracy: Accuracy::Length(1e-13),
        prediction: 1.0,
        ..Options::default()
    };
    assert!(said.on.len() >= 4, "{what}");
    for p in &said.on {
        let q = Point3::new(p[0], p[1], p[2]);
        let probe = Probe::Sphere(Sphere::new(q, 0.0).expect("a point"));
        let answer = contact(&prepared, &probe, &options, &mut workspace);
        let off = answer.separation.value.abs();
        assert!(off <= OFF, "{what}: {off:e} off at {q}");
    }
    if !said.solid {
        return;
    }
    for p in &said.beside {
        let q = Point3::new(p[0], p[1], p[2]);
        let n = Vector3::new(p[3], p[4], p[5]);
        for (side, by) in [(Side::Outside, STEP), (Side::Inside, -STEP)] {
            let found = inside(&prepared, q + n * by, &mut workspace).side;
            assert_eq!(found, Some(side), "{what}: beside {q} along {n}");
        }
        // The contact's normal is the face's, turned by its flag: it points out of the material.
        let probe = Probe::Sphere(Sphere::new(q + n * STEP, 0.0).expect("a point"));
        let answer = contact(&prepared, &probe, &options, &mut workspace);
        let normal = answer.contacts[0].normal;
        assert!(
            (normal - n).norm() < 1e-9,
            "{what}: {normal} at {q}, {n} said"
        );
    }
}

/// Faces whose stored direction is against the outward normal are marked, and no others.
fn check_directions(what: &str, brep: &Brep, said: &Shape) {
    if !said.solid {
        return;
    }
    let prepared = PreparedBrep::new(brep.clone());
    let mut workspace = Workspace::default();
    for (f, face) in brep.faces().iter().enumerate() {
        let surface = brep.surface(f);
        let [u, v] = surface.domain();
        let mid = |d: feeler::numeric::Interval| d.lerp(0.5);
        let (a, b) = (mid(u), mid(v));
        let h = 1e-6;
        let p = surface.point(a, b);
        let n = (surface.point(a + h, b) - p).cross(&(surface.point(a, b + h) - p));
        let n = n.normalize() * if face.reversed { -STEP } else { STEP };
        let at = |q: Point3<f64>, w: &mut Workspace| inside(&prepared, q, w).side;
        let sides = [at(p + n, &mut workspace), at(p - n, &mut workspace)];
        // The middle of a cap may lie in a hole.
        if sides[0] != sides[1] {
            assert_eq!(
                sides,
                [Some(Side::Outside), Some(Side::Inside)],
                "{what}: face {f}"
            );
        }
    }
}

#[test]
fn extrusions_are_what_rhino3dm_says() {
    for name in ["extrusions.3dm", "extrusions_v5.3dm"] {
        let (document, said) = read::<Extrusion>(name, "extrusions.json");
        assert_eq!(document.objects.len(), said.len());
        for extrusion in said {
            let what = format!("{name}, {}", extrusion.name);
            let object = &document.objects[extrusion.object];
            assert_eq!(object.name, extrusion.name);
            let ObjectKind::Extrusion(brep) = &object.kind else {
                panic!("{what}: {:?}", object.kind);
            };
            check(&what, brep, &extrusion.shape);
            check_directions(&what, brep, &extrusion.shape);
        }
        assert_eq!(document.bodies().count(), document.objects.len());
    }
}

fn parts(document: &Document, index: usize) -> (&str, Vec<Cow<'_, Object>>) {
    let block = document.block(&document.objects[index]);
    let block = block.unwrap_or_else(|| panic!("{:?}", document.objects[index]));
    (&block.name, document.parts(index).collect())
}

#[test]
fn blocks_stand_where_rhino3dm_puts_them() {
    for name in ["blocks.3dm", "blocks_v5.3dm"] {
        let (document, said) = read::<Block>(name, "blocks.json");
        for block in &said {
            let (found, parts) = parts(&document, block.object);
            assert_eq!(found, block.block);
            let refused: Vec<String> = parts
                .iter()
                .filter_map(|p| match &p.kind {
                    ObjectKind::Refused { reason, .. } => Some(reason.to_string()),
                    _ => None,
                })
                .collect();
            // One reference stretches a cylinder.
            if !refused.is_empty() {
                assert_eq!(parts.len(), 2, "{name}");
                assert!(refused[0].contains("scales unevenly"), "{refused:?}");
            }
            let breps: Vec<Cow<'_, Object>> = parts
                .into_iter()
                .filter(|p| matches!(p.kind, ObjectKind::Brep(_) | ObjectKind::Extrusion(_)))
                .collect();
            assert_eq!(
                breps.len(),
                block.parts.len(),
                "{name}, {found}: {refused:?}"
            );
            for (object, shape) in breps.into_iter().zip(&block.parts) {
                let what = format!("{name}, object {}, {}", block.object, object.name);
                let (ObjectKind::Brep(brep) | ObjectKind::Extrusion(brep)) = &object.kind else {
                    continue;
                };
                check(&what, brep, shape);
                check_directions(&what, brep, shape);
                let rounded = object
                    .warnings
                    .iter()
                    .any(|w| w.contains("off by no more than"));
                // The rod's points have all digits, and a shift may round them.
                if !block.exact || object.name == "crate" {
                    assert_eq!(rounded, !block.exact, "{what}: {:?}", object.warnings);
                }
            }
        }
        // Members are not the model's own; what was placed is.
        let members = document.objects.iter().filter(|o| o.block_member).count();
        assert!(members >= 5, "{members}");
        let placed: usize = said.iter().map(|b| b.parts.len()).sum();
        assert_eq!(document.bodies().count(), placed, "{name}");
    }
}

/// A map that keeps digits keeps them: the moved BREP is the member's own, number by number.
#[test]
fn moved_digits_are_the_same() {
    let document = read_file(file("blocks.3dm")).expect("a file of the corpus");
    let member = document
        .objects
        .iter()
        .find(|o| o.name == "crate")
        .expect("a member");
    let ObjectKind::Brep(own) = &member.kind else {
        panic!("{member:?}");
    };
    let moved = |i: usize| match &parts(&document, i).1[0].kind {
        ObjectKind::Brep(brep) => brep.clone(),
        other => panic!("{other:?}"),
    };
    let first = document
        .objects
        .iter()
        .position(|o| matches!(o.kind, ObjectKind::Block { .. }));
    let first = first.expect("a reference");
    let (turned, mirrored, doubled) = (moved(first), moved(first + 1), moved(first + 2));
    for (i, v) in own.parts().vertices.iter().enumerate() {
        let p = v.point;
        let at = |b: &Brep| b.parts().vertices[i].point;
        assert_eq!(at(&turned), Point3::new(10.0 - p.y, 0.5 + p.x, p.z - 2.0));
        assert_eq!(at(&mirrored), Point3::new(-p.x, p.y, p.z));
        assert_eq!(
            at(&doubled),
            Point3::new(2.0 * p.x, 2.0 * p.y + 20.0, 2.0 * p.z)
        );
    }
    for (i, face) in own.faces().iter().enumerate() {
        assert_eq!(turned.faces()[i].reversed, face.reversed);
        assert_eq!(mirrored.faces()[i].reversed, !face.reversed);
    }
}

#[test]
fn hidden_and_locked_objects_are_known_and_chosen() {
    let (document, said) = read::<Mode>("modes.3dm", "modes.json");
    for mode in &said {
        let object = &document.objects[mode.object];
        assert_eq!(object.name, mode.name);
        assert_eq!(
            object.layer.as_deref(),
            Some(mode.layer.as_str()),
            "{}",
            mode.name
        );
        assert_eq!(object.hidden, mode.hidden, "{}", mode.name);
        assert_eq!(object.locked, mode.locked, "{}", mode.name);
    }
    for (hidden, locked) in [(true, true), (true, false), (false, true), (false, false)] {
        let wanted = said
            .iter()
            .filter(|m| (hidden || !m.hidden) && (locked || !m.locked));
        let wanted: Vec<usize> = wanted.map(|m| m.object).collect();
        let choice = Choice { hidden, locked };
        let found: Vec<usize> = document.chosen(choice).map(|(i, _)| i).collect();
        assert_eq!(found, wanted);
        let model = Model::load_chosen(&file("modes.3dm"), choice).expect("a file of the corpus");
        assert_eq!(model.breps.len(), wanted.len());
    }
    let meshes = document
        .objects
        .iter()
        .filter(|o| o.kind == ObjectKind::Mesh);
    assert_eq!(meshes.count(), 2);
    assert_eq!(document.units, Units::Millimetres);
}
