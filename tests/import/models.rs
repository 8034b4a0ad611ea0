//! Every model, against rhino3dm.

use crate::reference::{self, Counts};
use feeler::brep::Brep;
use feeler::nurbs::Surface;
use feeler_io::{Document, ObjectKind, read_file};
use nalgebra::Point3;
use std::path::{Path, PathBuf};

/// How far the two evaluations may differ, in ulp of the largest coordinate of the BREP's points.
///
/// Ours is evaluated in double-double and rounded once: half an ulp. The other is de Boor's algorithm in
/// f64, whose error is at most gamma_{12(p+q)+1} max|x_i| (see `feeler::nurbs::eval`), which is 60.5 ulp for
/// degrees p + q = 10, the highest sum in the models.
const POINT_ULP: f64 = 64.0;

/// How far the parameters may differ, in ulp of the largest parameter: two linear maps of one to three
/// roundings each.
const PARAMETER_ULP: f64 = 8.0;

/// Finds `*.3dm` below `dir`, in order.
fn find(dir: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(dir) else {
        return;
    };
    let mut paths: Vec<_> = entries.flatten().map(|e| e.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            find(&path, found);
        } else if path.extension().is_some_and(|e| e == "3dm") {
            found.push(path);
        }
    }
}

/// The corpus's models, and those of `../shared/models` (or `FEELER_MODELS`) where they are.
pub(crate) fn models() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut found = Vec::new();
    find(&root.join("corpora"), &mut found);
    let shared = std::env::var_os("FEELER_MODELS")
        .map_or_else(|| root.join("../shared/models"), PathBuf::from);
    let before = found.len();
    find(&shared, &mut found);
    if found.len() == before {
        eprintln!("SKIPPED in part: no models in {}", shared.display());
    }
    found
}

/// What must hold for one object.
pub(crate) fn brep_of(document: &Document, object: usize) -> &Brep {
    match &document.objects[object].kind {
        ObjectKind::Brep(brep) => brep,
        ObjectKind::Refused { class, reason } => panic!("object {object}: {class}: {reason}"),
        other => panic!("object {object} is a {}", other.name()),
    }
}

fn largest(points: impl Iterator<Item = f64>) -> f64 {
    points.fold(0.0, |m: f64, x| m.max(x.abs()))
}

fn distance(a: &[f64], b: &Point3<f64>) -> f64 {
    a.iter()
        .zip(b.iter())
        .map(|(x, y)| (x - y).abs())
        .fold(0.0, f64::max)
}

/// Compares a surface with its reference; the worst difference in ulp of `size`.
pub(crate) fn compare_surface(
    surface: &Surface,
    domain: [f64; 4],
    points: &[[f64; 5]],
    size: f64,
) -> f64 {
    let [u, v] = surface.domain();
    assert_eq!([u.start, u.end, v.start, v.end], domain, "the domain");
    assert_eq!(points.len(), 100);
    let mut worst = 0.0_f64;
    for [u, v, xyz @ ..] in points {
        let (point, bound) = surface.point_with_bound(*u, *v);
        assert!(bound <= f64::EPSILON * size, "bound {bound} at {u}, {v}");
        worst = worst.max(distance(xyz, &point));
    }
    worst / (f64::EPSILON * size)
}

#[test]
fn breps_have_the_counts_of_another_reader() {
    let files = models();
    let Some(references) = reference::read(&files) else {
        return;
    };
    let mut breps = 0;
    for (path, reference) in files.iter().zip(&references) {
        let document = read_file(path).expect("a model");
        assert_eq!(
            document.objects.len(),
            reference.objects,
            "{}",
            reference.file
        );
        assert_eq!(document.breps().count(), reference.breps.len());
        for other in &reference.breps {
            let parts = brep_of(&document, other.object).parts();
            let counts = Counts {
                faces: parts.faces.len(),
                loops: parts.loops.len(),
                trims: parts.trims.len(),
                edges: parts.edges.len(),
                vertices: parts.vertices.len(),
            };
            assert_eq!(counts, other.counts, "{}", reference.file);
            let loops = parts
                .faces
                .iter()
                .flat_map(|f| f.loops.as_deref().unwrap_or(&[]));
            for (l, theirs) in loops.zip(&other.loops) {
                let ours = &parts.loops[*l].trims;
                assert_eq!(ours.len(), theirs.len(), "loop {l} of {}", reference.file);
                for (t, theirs) in ours.iter().zip(theirs) {
                    let ours = &parts.trims[*t];
                    assert_eq!(ours.edge, usize::try_from(theirs.edge).ok());
                    assert_eq!(ours.vertices, [theirs.start, theirs.end]);
                }
            }
            for (face, theirs) in parts.faces.iter().zip(&other.faces) {
                assert_eq!(face.reversed, theirs.reversed);
            }
            for (vertex, theirs) in parts.vertices.iter().zip(&other.vertices) {
                assert_eq!(vertex.point, Point3::from(*theirs));
            }
            breps += 1;
        }
    }
    eprintln!("{breps} BREPs in {} files", files.len());
}

#[test]
fn faces_and_edges_evaluate_as_in_another_reader() {
    let files = models();
    let Some(references) = reference::read(&files) else {
        return;
    };
    let (mut worst_face, mut worst_edge) = (0.0_f64, 0.0_f64);
    let (mut faces, mut edges) = (0, 0);
    for (path, reference) in files.iter().zip(&references) {
        let document = read_file(path).expect("a model");
        for other in &reference.breps {
            let brep = brep_of(&document, other.object);
            let points = other.faces.iter().flat_map(|f| &f.points);
            let size = largest(points.flat_map(|p| p[2..].iter().copied()));
            for (i, theirs) in other.faces.iter().enumerate() {
                let off = compare_surface(brep.surface(i), theirs.domain, &theirs.points, size);
                let name = &reference.file;
                assert!(off <= POINT_ULP, "face {i} of {name}: {off} ulp");
                worst_face = worst_face.max(off);
                faces += 1;
            }
            for (i, theirs) in other.edges.iter().enumerate() {
                let off = compare_edge(brep, i, theirs, size);
                assert!(off <= 1.0, "edge {i} of {}: {off} bounds", reference.file);
                worst_edge = worst_edge.max(off);
                edges += 1;
            }
        }
    }
    eprintln!(
        "{faces} faces, at most {worst_face:.1} ulp apart; {edges} edges, at most {worst_edge:.2} of \
         their bounds"
    );
}

/// The worst difference of an edge from its reference, as a part of the bound.
pub(crate) fn compare_edge(brep: &Brep, edge: usize, points: &[[f64; 3]], size: f64) -> f64 {
    let parts = brep.parts();
    let edge = &parts.edges[edge];
    let curve = &parts.curves3[edge.curve.expect("a curve")];
    let last = (points.len() - 1) as f64;
    let mut worst = 0.0_f64;
    for (k, theirs) in points.iter().enumerate() {
        let s = k as f64 / last;
        let t = edge.span.lerp(if edge.reversed { 1.0 - s } else { s });
        let both = curve.derivatives(t, 1);
        let parameter = edge.span.start.abs().max(edge.span.end.abs());
        let bound = f64::EPSILON * (POINT_ULP * size + PARAMETER_ULP * parameter * both[1].norm());
        worst = worst.max(distance(theirs, &Point3::from(both[0])) / bound);
    }
    worst
}
