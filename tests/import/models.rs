//! Every model, against rhino3dm.

use crate::reference::{self, Counts};
use feeler::brep::{Brep, TrimCurve};
use feeler::numeric::Interval;
use feeler::nurbs::{Curve3, Surface};
use feeler_io::{Document, ObjectKind, read_file};
use nalgebra::Point3;
use std::f64::consts::TAU;
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
pub(crate) fn compare_surface(surface: &Surface, theirs: &reference::Surface, size: f64) -> f64 {
    let [u, v] = surface.domain();
    assert_eq!(
        [u.start, u.end, v.start, v.end],
        theirs.domain,
        "the domain"
    );
    assert_eq!(theirs.points.len(), 100);
    let points = theirs.points.iter().map(|[u, v, xyz @ ..]| (*u, *v, *xyz));
    worst_point(surface, points, size)
}

/// The same for a surface that import has given a larger domain, or other angles: points are
/// compared where they are within it, if need be one turn further. A turn is rounded to 2^-52, which moves a
/// point by that times its distance from the axis: part of the bound's 64 ulp.
fn compare_opened(surface: &Surface, theirs: &reference::Surface, size: f64) -> f64 {
    let [u, v] = surface.domain();
    let place = |x: f64, domain: &Interval| {
        let turns = [0.0, TAU, -TAU];
        turns
            .into_iter()
            .map(|t| x + t)
            .find(|x| domain.contains(*x))
    };
    let points: Vec<_> = theirs
        .points
        .iter()
        .filter_map(|[a, b, xyz @ ..]| Some((place(*a, &u)?, place(*b, &v)?, *xyz)))
        .collect();
    assert!(points.len() >= 10, "only {} points within it", points.len());
    worst_point(surface, points.into_iter(), size)
}

fn worst_point(
    surface: &Surface,
    points: impl Iterator<Item = (f64, f64, [f64; 3])>,
    size: f64,
) -> f64 {
    let mut worst = 0.0_f64;
    for (u, v, xyz) in points {
        let (point, bound) = surface.point_with_bound(u, v);
        assert!(bound <= f64::EPSILON * size, "bound {bound} at {u}, {v}");
        worst = worst.max(distance(&xyz, &point));
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
                if document.version <= 2 && vertex.point != Point3::from(*theirs) {
                    // Files as old as that have no vertices: the mean of edges' ends, in which a few roundings differ.
                    let off = (vertex.point - Point3::from(*theirs)).amax();
                    let size = vertex.point.coords.amax();
                    assert!(off <= 4.0 * f64::EPSILON * size, "{}", reference.file);
                    continue;
                }
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
    let (mut faces, mut opened, mut edges, mut others) = (0, 0, 0, 0);
    for (path, reference) in files.iter().zip(&references) {
        let document = read_file(path).expect("a model");
        for other in &reference.breps {
            let brep = brep_of(&document, other.object);
            let points = other.faces.iter().flat_map(|f| &f.surface.points);
            let size = largest(points.flat_map(|p| p[2..].iter().copied()));
            for (i, theirs) in other.faces.iter().enumerate() {
                let warnings = &document.objects[other.object].warnings;
                let was_opened = format!("face {i}: loops reach over");
                let off = if warnings.iter().any(|w| w.starts_with(&was_opened)) {
                    opened += 1;
                    compare_opened(brep.surface(i), &theirs.surface, size)
                } else {
                    compare_surface(brep.surface(i), &theirs.surface, size)
                };
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
        others += compare_others(&document, reference);
    }
    eprintln!(
        "{faces} faces ({opened} over another domain), at most {worst_face:.1} ulp apart; {edges} \
         edges, at most {worst_edge:.2} of their bounds; {others} other curves and surfaces"
    );
}

/// Compares curves and surfaces that are no part of a BREP; how many.
pub(crate) fn compare_others(document: &Document, reference: &reference::File) -> usize {
    for theirs in &reference.surfaces {
        let ObjectKind::Surface(brep) = &document.objects[theirs.object].kind else {
            panic!("object {} is no surface", theirs.object);
        };
        let size = largest(
            theirs
                .surface
                .points
                .iter()
                .flat_map(|p| p[2..].iter().copied()),
        );
        let off = compare_surface(brep.surface(0), &theirs.surface, size);
        assert!(off <= POINT_ULP, "surface {}: {off} ulp", theirs.object);
    }
    for theirs in &reference.curves {
        let ObjectKind::Curve(curve) = &document.objects[theirs.object].kind else {
            panic!("object {} is no curve", theirs.object);
        };
        let size = largest(theirs.points.iter().flatten().copied());
        let off = compare_curve(curve, curve.domain(), false, &theirs.points, size);
        assert!(off <= 1.0, "curve {}: {off} bounds", theirs.object);
    }
    reference.surfaces.len() + reference.curves.len()
}

/// The worst difference of an edge from its reference, as a part of the bound.
pub(crate) fn compare_edge(brep: &Brep, edge: usize, points: &[[f64; 3]], size: f64) -> f64 {
    let parts = brep.parts();
    let edge = &parts.edges[edge];
    let curve = &parts.curves3[edge.curve.expect("a curve")];
    compare_curve(curve, edge.span, edge.reversed, points, size)
}

/// The worst difference of a part of a curve from points evenly spaced in its parameter, as a part of the
/// bound.
fn compare_curve(
    curve: &Curve3,
    span: Interval,
    reversed: bool,
    points: &[[f64; 3]],
    size: f64,
) -> f64 {
    let last = (points.len() - 1) as f64;
    let mut worst = 0.0_f64;
    for (k, theirs) in points.iter().enumerate() {
        let s = k as f64 / last;
        let t = span.lerp(if reversed { 1.0 - s } else { s });
        let both = curve.derivatives(t, 1);
        let parameter = span.start.abs().max(span.end.abs());
        let bound = f64::EPSILON * (POINT_ULP * size + PARAMETER_ULP * parameter * both[1].norm());
        worst = worst.max(distance(theirs, &Point3::from(both[0])) / bound);
    }
    worst
}

/// How far trims may lie from their vertices and edges, times the largest tolerance that the file
/// states for the BREP or the model: tolerances are estimates of their writer.
const TOLERANCES: f64 = 1.25;

/// The distance of `p` from a polyline.
fn to_polyline(p: &Point3<f64>, line: &[Point3<f64>]) -> f64 {
    let to_segment = |w: &[Point3<f64>]| {
        let (d, q) = (w[1] - w[0], p - w[0]);
        let length = d.norm_squared();
        let s = if length > 0.0 {
            (q.dot(&d) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (q - d * s).norm()
    };
    line.windows(2)
        .map(to_segment)
        .fold(f64::INFINITY, f64::min)
}

/// Points along a trim in space, at fractions k/8 of its span in its own direction.
pub(crate) fn along_trim(brep: &Brep, trim: &TrimCurve) -> Vec<Point3<f64>> {
    let parts = brep.parts();
    let surface = brep.surface(parts.loops[trim.trim_loop].face);
    (0..=8)
        .map(|k| {
            let s = f64::from(k) / 8.0;
            let t = trim.span.lerp(if trim.reversed { 1.0 - s } else { s });
            let uv = parts.curves2[trim.curve].point(t);
            surface.point(uv[0], uv[1])
        })
        .collect()
}

/// No other reader gives out trims' curves, but a trim's image must run from vertex to vertex
/// along its edge, both of which are checked against one.
#[test]
fn trims_run_along_their_edges() {
    let mut trims = 0;
    for path in models() {
        let document = read_file(&path).expect("a model");
        // Programs that write version 2 turn surfaces of revolution into NURBS and keep the trims, whose
        // parameter is then no angle any more: 0.02 off in ball_joint_socket_v2.
        if document.version < 3 {
            continue;
        }
        for (_, brep) in document.breps() {
            let p = brep.parts();
            let vertices = p.vertices.iter().map(|v| v.tolerance);
            let stored = p
                .edges
                .iter()
                .map(|e| e.tolerance)
                .chain(vertices)
                .flatten();
            let allowed = TOLERANCES * stored.fold(document.tolerance.unwrap_or(0.0), f64::max);
            for (i, trim) in p.trims.iter().enumerate() {
                let image = along_trim(brep, trim);
                let [start, end] = trim.vertices.map(|v| p.vertices[v].point);
                let mut off = (image[0] - start).norm().max((image[8] - end).norm());
                if let Some(edge) = trim.edge {
                    let edge = &p.edges[edge];
                    let curve = &p.curves3[edge.curve.expect("a curve")];
                    let at = |k: i32| curve.point(edge.span.lerp(f64::from(k) / 512.0));
                    let line: Vec<_> = (0..=512).map(at).collect();
                    let ends = if trim.edge_reversed != edge.reversed {
                        [512, 0]
                    } else {
                        [0, 512]
                    };
                    off = off.max((image[0] - line[ends[0]]).norm());
                    off = off.max((image[8] - line[ends[1]]).norm());
                    for q in &image {
                        off = off.max(to_polyline(q, &line));
                    }
                }
                assert!(off <= allowed, "trim {i} of {}: {off}", path.display());
                trims += 1;
            }
        }
    }
    eprintln!("{trims} trims");
}
