//! Health reports of all parts there are: proven bounds against samples, counts against the lists of defects.

use feeler::brep::{Brep, Defect, LoopKind};
use feeler::prepare::{Direction, Health, PreparedBrep, Turn};
use feeler_io::{ObjectKind, read_file};
use nalgebra::Point3;
use std::path::{Path, PathBuf};

/// All .3dm and .brep files in a folder, in order.
fn find(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            find(&path, found);
        } else if path.extension().is_some_and(|e| e == "3dm" || e == "brep") {
            found.push(path);
        }
    }
}

/// The corpus's models, and those beside the project (or at `FEELER_MODELS`); says so where there are none.
fn models() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut found = Vec::new();
    find(&root.join("corpora"), &mut found);
    assert!(found.len() > 50, "the corpus has models");
    let beside = std::env::var_os("FEELER_MODELS");
    let beside = beside.map_or_else(|| root.join("../shared/models"), PathBuf::from);
    let before = found.len();
    find(&beside, &mut found);
    if found.len() == before {
        eprintln!("SKIPPED in part: no models in {}", beside.display());
    }
    found
}

fn breps(path: &Path) -> Vec<Brep> {
    // Files that are refused are the readers' to test.
    let Ok(document) = read_file(path) else {
        return Vec::new();
    };
    let objects = document.objects.into_iter().filter_map(|o| match o.kind {
        ObjectKind::Brep(brep) | ObjectKind::Surface(brep) | ObjectKind::Extrusion(brep) => {
            Some(brep)
        }
        _ => None,
    });
    objects.collect()
}

/// The images of the ends of a trim's curve.
fn ends(brep: &Brep, trim: usize) -> [Point3<f64>; 2] {
    let p = brep.parts();
    let t = &p.trims[trim];
    let surface = brep.surface(p.loops[t.trim_loop].face);
    let at = |x: f64| {
        let uv = p.curves2[t.curve].point(x);
        surface.point(uv.x, uv.y)
    };
    let [a, b] = [at(t.span.start), at(t.span.end)];
    if t.reversed { [b, a] } else { [a, b] }
}

/// Any matching of two curves matches their ends, in the one direction or the other.
fn between_ends(brep: &Brep, s: usize, t: usize) -> f64 {
    let ([a, b], [c, d]) = (ends(brep, s), ends(brep, t));
    let with = (a - c).norm().max((b - d).norm());
    let turned = (a - d).norm().max((b - c).norm());
    with.min(turned)
}

fn check(name: &str, brep: &Brep, h: &Health) {
    let p = brep.parts();
    let defects = brep.defects();
    assert_eq!(h.is_closed, brep.is_closed(), "{name}");
    assert_eq!(
        (h.faces.len(), h.edges.len()),
        (p.faces.len(), p.edges.len())
    );
    for e in &h.edges {
        let trims = &p.edges[e.edge].trims;
        assert!(e.crack.lo <= e.crack.hi, "{name}: {e:?}");
        for (i, s) in trims.iter().enumerate() {
            for t in &trims[i + 1..] {
                assert!(
                    between_ends(brep, *s, *t) <= e.crack.hi + h.rounding,
                    "{name}: {e:?}"
                );
            }
        }
        for trim in trims {
            let [a, b] = ends(brep, *trim);
            assert!((a - b).norm() <= e.reach + h.rounding, "{name}: {e:?}");
        }
        for o in &e.offsets {
            assert!(
                o.about.is_none_or(|about| about <= o.at_most),
                "{name}: edge {} {o:?}",
                e.edge
            );
            // What samples say by themselves is no larger, but for rounding.
            let seen = defects.iter().find_map(|d| match d {
                Defect::EdgeOffSurface { trim, distance, .. } if *trim == o.trim => Some(*distance),
                _ => None,
            });
            assert!(
                seen.unwrap_or(0.0) <= o.at_most * (1.0 + 1e-9) + h.rounding,
                "{name}: edge {} {o:?}, {seen:?} by samples",
                e.edge
            );
        }
    }
    for f in &h.faces {
        let listed = p.faces[f.face].loops.as_ref().map_or(0, Vec::len);
        assert_eq!(f.loops.len(), listed, "{name}");
        for l in &f.loops {
            for g in &l.gaps {
                assert!(
                    g.space.hi.is_finite() && g.uv.lo <= g.uv.hi,
                    "{name}: {g:?}"
                );
            }
        }
    }
    let loops = || h.faces.iter().flat_map(|f| &f.loops);
    for d in &defects {
        match d {
            Defect::Gap { trim_loop, uv, .. } => {
                let of = loops().find(|l| l.trim_loop == *trim_loop).unwrap();
                let widest = of.gaps.iter().map(|g| g.uv.hi).fold(0.0, f64::max);
                assert!(widest >= uv * (1.0 - 1e-9), "{name}: {d}");
            }
            Defect::Orientation {
                trim_loop, area, ..
            } => {
                let of = loops().find(|l| l.trim_loop == *trim_loop).unwrap();
                let told = of.is_turned_wrong() || of.turn == Turn::Undecided;
                assert!(
                    told && of.area.lo <= *area && *area <= of.area.hi,
                    "{name}: {d}"
                );
            }
            _ => {}
        }
    }
    let count = |pred: &dyn Fn(&Defect) -> bool| defects.iter().filter(|d| pred(d)).count();
    assert_eq!(
        h.edges.iter().filter(|e| e.is_naked()).count(),
        count(&|d| matches!(d, Defect::BoundaryEdge { .. })),
        "{name}"
    );
    assert_eq!(
        h.edges.iter().filter(|e| e.is_non_manifold()).count(),
        count(&|d| matches!(d, Defect::NonManifoldEdge { .. })),
        "{name}"
    );
}

#[test]
fn every_part() {
    let mut turned = 0;
    for path in models() {
        for (i, brep) in breps(&path).into_iter().enumerate() {
            let prepared = PreparedBrep::new(brep);
            let h = prepared.health();
            check(&format!("{}: {i}", path.display()), prepared.brep(), &h);
            let loops = h.faces.iter().flat_map(|f| &f.loops);
            turned += loops
                .filter(|l| l.kind != LoopKind::Unknown && l.turn != Turn::Undecided)
                .count();
        }
    }
    assert!(turned > 500, "{turned} loops");
}

/// Parts made by construction: sound in all that is decided.
#[test]
fn sound_parts() {
    let thesis = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpora/models/thesis");
    for name in [
        "cylinder.3dm",
        "cylinder_nurbs.3dm",
        "cube_corner_cut_nurbs.3dm",
        "cube_corner_sphere_cut.3dm",
        "ball_joint_cavity.3dm",
        "ball_joint_cavity_nurbs.brep",
        "ball_nurbs_periodic.brep",
        "cube_corner_sphere_cut_nurbs.brep",
    ] {
        for brep in breps(&thesis.join(name)) {
            let h = PreparedBrep::new(brep).health();
            assert_eq!(h.undefined, [], "{name}");
            assert!(h.is_closed, "{name}");
        }
    }
}

/// The normals of hits along lines through them turn out and in by turns. (Some have circles for edges, whose ends are together but for roundings.)
#[test]
fn no_face_of_the_thesis_parts_is_inside_out() {
    let mut parts = Vec::new();
    let thesis = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpora/models/thesis");
    find(&thesis, &mut parts);
    assert!(parts.len() > 20, "{parts:?}");
    for path in parts {
        for brep in breps(&path) {
            let h = PreparedBrep::new(brep).health();
            let mut edges = h.edges.iter();
            let inside_out = edges.find(|e| e.direction == Direction::Against);
            assert!(inside_out.is_none(), "{}: {inside_out:?}", path.display());
        }
    }
}
