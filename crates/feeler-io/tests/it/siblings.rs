//! Parts that the corpus holds both as .brep and as .3dm, written by two programs from one shape: what is read is the same.

use feeler::brep::{Brep, BrepParts, Defect};
use feeler::numeric::Interval;
use feeler::nurbs::Surface;
use feeler_io::{Document, Format, ObjectKind, Units, read_file};
use nalgebra::Point3;
use std::path::PathBuf;

const PARTS: [&str; 20] = [
    "ball",
    "ball_joint_cavity",
    "ball_joint_cavity_nurbs",
    "ball_joint_socket",
    "ball_joint_socket_nurbs",
    "cube_corner_cut",
    "cube_corner_cut_nurbs",
    "cube_corner_sphere_cut",
    "cube_corner_sphere_cut_nurbs",
    "cylinder",
    "cylinder_nurbs",
    "cylinder_nurbs_unclamped",
    "geneva4_wheel",
    "geneva4_wheel_nurbs",
    "geneva6_wheel_nurbs",
    "sheet_trimmed",
    "sheet_trimmed_nurbs",
    "shift_gate_nurbs",
    "shift_gate_straight",
    "shift_gate_straight_nurbs",
];

fn file(name: &str) -> Document {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/thesis");
    read_file(folder.join(name)).expect("a file of the corpus")
}

fn one(document: Document) -> Brep {
    let [object] = <[_; 1]>::try_from(document.objects).expect("one object");
    match object.kind {
        ObjectKind::Brep(brep) => brep,
        other => panic!("{other:?}"),
    }
}

/// Largest coordinate of a vertex.
fn size(brep: &Brep) -> f64 {
    let vertices = brep.parts().vertices.iter();
    vertices.map(|v| v.point.coords.amax()).fold(0.0, f64::max)
}

/// Half a unit in the 15th digit, to which OCCT prints ranges and points of vertices, of the value; twice, as the .3dm
/// has it from its own rounding.
const PRINTED: f64 = 1e-14;

/// The largest gap of a loop in space: the program that wrote the .3dm moved the ends of trims so that they meet.
fn gap(defects: &[Defect], of: usize) -> f64 {
    let gaps = defects.iter().filter_map(|d| match d {
        Defect::Gap {
            trim_loop, space, ..
        } if *trim_loop == of => Some(*space),
        _ => None,
    });
    gaps.fold(0.0, f64::max)
}

const STEPS: u8 = 8;

/// Points of a trim in space, in the direction of the loop.
fn trim_points(brep: &Brep, face: usize, trim: usize) -> Vec<Point3<f64>> {
    let parts = brep.parts();
    let t = &parts.trims[trim];
    let at = |k: u8| {
        let s = f64::from(k) / f64::from(STEPS);
        let curve = &parts.curves2[t.curve];
        let uv = curve.point(t.span.lerp(if t.reversed { 1.0 - s } else { s }));
        brep.surface(face).point(uv.x, uv.y)
    };
    (0..=STEPS).map(at).collect()
}

#[test]
fn a_brep_is_its_3dm() {
    for part in PARTS {
        let ours = file(&format!("{part}.brep"));
        assert_eq!((ours.format, ours.version), (Format::Occt, 3));
        assert_eq!(ours.units, Units::None);
        assert_eq!(ours.warnings, [""; 0]);
        assert_eq!(ours.objects[0].warnings, [""; 0], "{part}");
        let (ours, theirs) = (one(ours), one(file(&format!("{part}.3dm"))));
        let (a, b) = (ours.parts(), theirs.parts());
        let counts = |p: &BrepParts| {
            let BrepParts {
                faces,
                loops,
                trims,
                edges,
                vertices,
                ..
            } = p;
            [
                faces.len(),
                loops.len(),
                trims.len(),
                edges.len(),
                vertices.len(),
            ]
        };
        assert_eq!(counts(a), counts(b), "{part}");
        assert_eq!(ours.is_closed(), !part.starts_with("sheet"), "{part}");
        assert_eq!(ours.is_closed(), theirs.is_closed(), "{part}");
        let slack = PRINTED * size(&theirs);
        let defects = ours.defects();
        for (f, (x, y)) in a.faces.iter().zip(&b.faces).enumerate() {
            let name = format!("{part} face {f}");
            assert_eq!(x.reversed, y.reversed, "{name}");
            let (s, t) = (ours.surface(f), theirs.surface(f));
            if matches!(t, Surface::Nurbs(_)) && part != "cylinder_nurbs_unclamped" {
                assert_eq!(s, t, "{name}");
            }
            let (x, y) = (x.loops.as_ref().unwrap(), y.loops.as_ref().unwrap());
            // Holes are listed in another order, and loops may start at another trim.
            for k in x {
                let slack = slack + gap(&defects, *k);
                let k = &a.loops[*k];
                let n = k.trims.len();
                let like = |l: &usize| {
                    let l = &b.loops[*l];
                    let shifts = if (l.trims.len(), l.kind) == (n, k.kind) {
                        n
                    } else {
                        0
                    };
                    (0..shifts)
                        .map(|shift| {
                            let pairs = (0..n).map(|i| [k.trims[i], l.trims[(i + shift) % n]]);
                            pairs
                                .map(|trims| difference([&ours, &theirs], f, trims))
                                .fold(0.0, f64::max)
                        })
                        .fold(f64::INFINITY, f64::min)
                };
                let best = y.iter().map(like).fold(f64::INFINITY, f64::min);
                assert!(best <= slack, "{name}: trims differ by {best:e}");
            }
            // The surfaces, at the same parameters where both have them.
            let both = |c: usize| {
                let (a, b) = (s.domain()[c], t.domain()[c]);
                Interval::new(a.start.max(b.start), a.end.min(b.end)).expect("a common part")
            };
            let (u, v) = (both(0), both(1));
            for i in 0..=8 {
                for j in 0..=8 {
                    let (u, v) = (u.lerp(f64::from(i) / 8.0), v.lerp(f64::from(j) / 8.0));
                    let off = (s.point(u, v) - t.point(u, v)).norm();
                    assert!(
                        off <= slack,
                        "{name}: surfaces differ by {off:e} at {u}, {v}"
                    );
                }
            }
        }
        // Vertices and edges are listed in another order.
        for v in &a.vertices {
            let off = b.vertices.iter().map(|w| (v.point - w.point).norm());
            let off = off.fold(f64::INFINITY, f64::min);
            assert!(off <= slack, "{part}: a vertex is off by {off:e}");
        }
        let worst = |all: &[Defect]| all.iter().map(Defect::severity).max();
        assert_eq!(worst(&defects), worst(&theirs.defects()), "{part}");
    }
}

/// The largest distance between points of two trims.
fn difference(breps: [&Brep; 2], face: usize, trims: [usize; 2]) -> f64 {
    let [p, q] = [0, 1].map(|i| trim_points(breps[i], face, trims[i]));
    let each = p.iter().zip(&q);
    each.map(|(p, q)| (p - q).norm()).fold(0.0, f64::max)
}

/// A periodic or unclamped B-spline is the sphere or cylinder that its clamped sibling is.
#[test]
fn periodic_and_unclamped_knots_give_the_same_surface() {
    for (part, sibling) in [
        ("ball_nurbs.brep", "ball.3dm"),
        ("ball_nurbs_periodic.brep", "ball.3dm"),
        ("ball_nurbs_unclamped.brep", "ball.3dm"),
        ("cylinder_nurbs_periodic.brep", "cylinder_nurbs.3dm"),
        ("cylinder_nurbs_unclamped.brep", "cylinder_nurbs.3dm"),
    ] {
        let (ours, theirs) = (one(file(part)), one(file(sibling)));
        assert!(ours.is_closed());
        assert_eq!(ours.faces().len(), theirs.faces().len());
        let slack = PRINTED * size(&theirs);
        for f in 0..ours.faces().len() {
            let [s, t] = [&ours, &theirs].map(|b| b.surface(f));
            let ([u, v], [u2, v2]) = (s.domain(), t.domain());
            assert!(
                (u.start - u2.start).abs() <= slack && (v.end - v2.end).abs() <= slack,
                "{part}"
            );
            for i in 0..=12 {
                for j in 0..=8 {
                    let (u, v) = (u.lerp(f64::from(i) / 12.0), v.lerp(f64::from(j) / 8.0));
                    let p = s.point(u, v);
                    let off = if part.starts_with("ball") {
                        // A NURBS sphere has other parameters: its radius is what counts.
                        (p.coords.norm() - BALL).abs()
                    } else {
                        (p - t.point(u, v)).norm()
                    };
                    assert!(off <= slack, "{part} face {f}: off by {off:e} at {u}, {v}");
                }
            }
        }
    }
}

/// The radius of the thesis's ball, in mm.
const BALL: f64 = 2.45;
