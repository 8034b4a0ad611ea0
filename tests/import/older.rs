//! BREPs of files of versions 1 and 2, and blocks that are linked to other files (`corpora/make_old_3dm.py`; what rhino3dm makes of the
//! same files is held against ours in `models.rs`).

use crate::fixture as f;
use crate::mutated::mend;
use feeler::brep::{Brep, Iso, LoopKind, TrimKind};
use feeler::nurbs::{Curve, Surface};
use feeler_io::{Document, ObjectKind, read_3dm};
use nalgebra::{Point3, Vector4};
use std::path::Path;

fn bytes(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpora/models/3dm");
    std::fs::read(folder.join(name)).expect("a file of the corpus")
}

fn read(name: &str) -> Document {
    read_3dm(&bytes(name)).expect("a file of the corpus")
}

fn brep(document: &Document, object: usize) -> &Brep {
    match &document.objects[object].kind {
        ObjectKind::Brep(brep) => brep,
        other => panic!("{other:?}"),
    }
}

fn is_the_pyramid(brep: &Brep) {
    let p = brep.parts();
    assert!(brep.is_closed());
    let [corner, apex] = [Point3::origin(), Point3::new(1.0, 1.0, 1.5)];
    let points: Vec<_> = p.vertices.iter().map(|v| v.point).collect();
    assert_eq!(points, [corner, apex]);
    let edges: Vec<_> = p.edges.iter().map(|e| (e.vertices, &e.trims[..])).collect();
    assert_eq!(edges, [([0, 0], &[0, 4][..]), ([0, 1], &[1, 3][..])]);
    assert_eq!(p.edges[0].tolerance, Some(1e-3));
    let kinds: Vec<_> = p.trims.iter().map(|t| t.kind).collect();
    use TrimKind::{Mated, Seam, Singular};
    assert_eq!(kinds, [Mated, Seam, Singular, Seam, Mated]);
    let iso: Vec<_> = p.trims.iter().map(|t| t.iso).collect();
    assert_eq!(
        iso,
        [Iso::South, Iso::East, Iso::North, Iso::West, Iso::None]
    );
    let ends: Vec<_> = p.trims.iter().map(|t| t.vertices).collect();
    assert_eq!(ends, [[0, 0], [0, 1], [1, 1], [1, 0], [0, 0]]);
    let loops: Vec<_> = p.loops.iter().map(|l| (l.kind, l.trims.len())).collect();
    assert_eq!(loops, [(LoopKind::Outer, 4), (LoopKind::Outer, 1)]);
    let reversed: Vec<_> = p.faces.iter().map(|f| f.reversed).collect();
    assert_eq!(reversed, [false, true]);
    // The ridge, whose apex has weight 2.
    let Curve::Nurbs(ridge) = &p.curves3[1] else {
        panic!("a spline");
    };
    assert_eq!(ridge.control_points()[1], Vector4::new(2.0, 2.0, 3.0, 2.0));
    // The base is bounded by four segments.
    assert!(matches!(&p.curves2[4], Curve::Poly(c) if c.segments().len() == 4));
}

#[test]
fn old_breps_get_their_topology_back() {
    for name in ["pyramid_v1.3dm", "pyramid_v2.3dm"] {
        let document = read(name);
        assert_eq!(document.units.symbol(), "mm", "{name}");
        assert_eq!(document.tolerance, Some(0.001), "{name}");
        assert_eq!(document.objects[0].name, "pyramid", "{name}");
        is_the_pyramid(brep(&document, 0));
        assert_eq!(document.objects[0].warnings, Vec::<String>::new(), "{name}");
    }
    let [first, second] = ["pyramid_v1.3dm", "pyramid_v2.3dm"].map(read);
    let surfaces = |d: &Document| -> Vec<Surface> { brep(d, 0).parts().surfaces.clone() };
    assert_eq!(surfaces(&first), surfaces(&second));
}

/// The second file with other fields in its last trim: its twin and its edge.
fn with_last_trim(twin: i32, edge: i32) -> Document {
    let mut bytes = bytes("pyramid_v2.3dm");
    // Its number, its twin, whether it has the edge, the edge, its direction and flags, its tolerance.
    let trim = |twin: i32, edge: i32| {
        let mut bytes = [4, twin].map(i32::to_le_bytes).concat();
        bytes.push(0);
        bytes.extend([edge, 0, 0, 0].map(i32::to_le_bytes).concat());
        bytes.extend(1e-3_f64.to_le_bytes());
        bytes
    };
    let stored = trim(0, 0);
    let at: Vec<usize> = (0..bytes.len() - stored.len())
        .filter(|i| bytes[*i..].starts_with(&stored))
        .collect();
    let [at] = at[..] else {
        panic!("one such trim: {at:?}");
    };
    bytes[at..at + stored.len()].copy_from_slice(&trim(twin, edge));
    mend(&mut bytes);
    read_3dm(&bytes).expect("a file")
}

#[test]
fn a_trim_may_name_its_twin_in_place_of_its_edge() {
    is_the_pyramid(brep(&with_last_trim(0, -1), 0));
}

/// The border of the base, which is no point: a square from its corner, of sides of 2.
#[test]
fn a_lost_edge_is_no_pole_without_a_word() {
    let document = with_last_trim(-1, -1);
    assert!(!brep(&document, 0).is_closed());
    let [said] = &document.objects[0].warnings[..] else {
        panic!("{:?}", document.objects[0].warnings);
    };
    assert!(
        said.starts_with("face 1, trim 4: has no edge, and is no pole: it reaches 2.828e0"),
        "{said}"
    );
}

#[test]
fn files_of_version_1_have_layers_and_curves() {
    let document = read("pyramid_v1.3dm");
    assert_eq!(document.warnings, Vec::<String>::new());
    let [pyramid, base, curves @ ..] = &document.objects[..] else {
        panic!("{document:?}");
    };
    let shown = (Some("shapes"), false, false);
    for object in curves.iter().chain([pyramid]) {
        assert_eq!(
            (object.layer.as_deref(), object.hidden, object.locked),
            shown
        );
    }
    assert_eq!((base.layer.as_deref(), base.hidden), (Some("shapes"), true));
    let ObjectKind::Brep(base) = &base.kind else {
        panic!("{base:?}");
    };
    assert!(!base.is_closed());
    assert_eq!(base.parts().trims[0].kind, TrimKind::Boundary);
    let knots = [
        [-1.0, -1.0, 0.0, 0.5, 1.0, 2.0, 2.0],
        [0.0, 0.0, 0.0, 0.5, 1.0, 2.0, 2.0],
        [-1.0, -1.0, 0.0, 0.5, 1.0, 1.0, 1.0],
        [0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0],
    ];
    assert_eq!(curves.len(), knots.len());
    for (curve, knots) in curves.iter().zip(knots) {
        let ObjectKind::Curve(Curve::Nurbs(curve)) = &curve.kind else {
            panic!("{curve:?}");
        };
        assert_eq!(curve.knots().knots(), knots);
        // Stored as (1, 2, 0) with weight 0.5.
        assert_eq!(curve.control_points()[1], Vector4::new(0.5, 1.0, 0.0, 0.5));
    }
}

#[test]
fn damage_to_files_of_version_1_is_told() {
    let whole = bytes("pyramid_v1.3dm");
    // A coordinate of the ridge's end with its weight.
    let apex = [1.0_f64, 1.0, 1.5, 2.0].map(f64::to_le_bytes).concat();
    let mut places = (0..whole.len() - 32).filter(|i| whole[*i..*i + 32] == apex[..]);
    let at = places.next_back().expect("the apex");
    let mut damaged = whole.clone();
    damaged[at] ^= 1;
    let document = read_3dm(&damaged).expect("a file");
    let ObjectKind::Refused { reason, .. } = &document.objects[0].kind else {
        panic!("{:?}", document.objects[0].kind);
    };
    let text = reason.to_string();
    assert!(
        text.contains("checksum") && text.contains("0x00010109"),
        "{text}"
    );
    let whole_ones = document.objects.iter().skip(1);
    assert!(
        whole_ones
            .into_iter()
            .all(|o| !matches!(o.kind, ObjectKind::Refused { .. }))
    );
    let error = read_3dm(&whole[..whole.len() - 1]).expect_err("a part of a file");
    assert!(error.to_string().contains("truncated"), "{error}");
    // What an old toolkit wrote is refused by name.
    let mut other = whole;
    other.extend([0x0B, 0, 2, 0, 0, 0, 0, 0]);
    let document = read_3dm(&other).expect("a file");
    let ObjectKind::Refused { reason, .. } = &document.objects.last().expect("objects").kind else {
        panic!("refused");
    };
    assert!(
        reason.to_string().contains("save it as version 5"),
        "{reason}"
    );
}

#[test]
fn a_later_body_under_the_first_header_is_read() {
    let mut bytes = bytes("pyramid_v2.3dm");
    bytes[31] = b'1';
    let document = read_3dm(&bytes).expect("a file");
    assert_eq!(document.version, 2);
    is_the_pyramid(brep(&document, 0));
}

#[test]
fn linked_blocks_say_what_they_want() {
    for name in ["blocks_linked_v4.3dm", "blocks_linked_v8.3dm"] {
        let document = read(name);
        assert_eq!(document.warnings, Vec::<String>::new(), "{name}");
        let index = |wanted: &str| {
            let found = document.objects.iter().position(|o| o.name == wanted);
            found.unwrap_or_else(|| panic!("{name}: no {wanted}"))
        };
        let of = |wanted: &str| &document.objects[index(wanted)];
        let asks =
            "the block `bolt` is linked to `C:\\parts\\bolt.3dm`, which is not loaded; embed it";
        let ObjectKind::Refused { reason, .. } = &of("bolt").kind else {
            panic!("{name}: {:?}", of("bolt").kind);
        };
        assert!(reason.to_string().contains(asks), "{name}: {reason}");
        // With a copy.
        let block = document.block(of("nut")).expect("a reference");
        let parts: Vec<_> = document.parts(index("nut")).collect();
        assert_eq!((block.name.as_str(), parts.len()), ("nut", 1));
        let ObjectKind::Surface(sheet) = &parts[0].kind else {
            panic!("{name}: {:?}", parts[0].kind);
        };
        assert_eq!(
            sheet.surface(0).point(0.5, 1.0),
            Point3::new(10.5, 1.0, 0.0)
        );
        let note = &block.warnings[0];
        assert!(
            note.contains("`C:\\parts\\bolt.3dm`, which is not opened"),
            "{name}: {note}"
        );
        // Within another block: what there is is placed, the rest refused.
        let parts: Vec<_> = document.parts(index("both")).collect();
        let [sheet, bolt] = &parts[..] else {
            panic!("{name}: {parts:?}");
        };
        assert!(matches!(&sheet.kind, ObjectKind::Surface(_)), "{name}");
        let ObjectKind::Refused { reason, .. } = &bolt.kind else {
            panic!("{name}: {:?}", bolt.kind);
        };
        assert!(reason.to_string().contains(asks), "{name}: {reason}");
        let ObjectKind::Refused { reason, .. } = &of("nothing").kind else {
            panic!("{name}: {:?}", of("nothing").kind);
        };
        assert!(
            reason.to_string().contains("is not in the file"),
            "{reason}"
        );
    }
}

/// Blocks in blocks: each copy stands where all the maps that it is under put it, shifted along x by 0 to 7.
#[test]
fn nested_blocks_stand_where_they_should() {
    let document = read_3dm(&f::nested_blocks(3, false)).expect("a file");
    let own = document.breps().next().expect("the member").1;
    let placed: Vec<_> = document.bodies().collect();
    assert_eq!(placed.len(), 8);
    let mut shifts = Vec::new();
    for (_, brep) in &placed {
        let vertices = { brep.parts().vertices.iter() }.zip(&own.parts().vertices);
        let mut all = vertices.map(|(v, own)| v.point - own.point);
        let first = all.next().expect("a vertex");
        assert!(all.all(|other| other == first));
        assert_eq!((first.y, first.z), (0.0, 0.0));
        shifts.push(first.x);
    }
    shifts.sort_by(f64::total_cmp);
    assert_eq!(shifts, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
}

/// A reference within a block hides what it places, as one of the model does: left is the one copy that no shifted reference places.
#[test]
fn hidden_references_within_blocks_hide_what_they_place() {
    let document = read_3dm(&f::nested_blocks(3, false)).expect("a file");
    let seen = feeler_io::Choice {
        hidden: false,
        locked: true,
    };
    let own = document.breps().next().expect("the member").1;
    let left: Vec<_> = document.chosen(seen).collect();
    assert_eq!(left.len(), 1);
    assert_eq!(left[0].1.parts().vertices, own.parts().vertices);
    // What is placed knows it, too.
    let marks = document.parts(0).map(|part| part.hidden);
    assert_eq!(marks.filter(|hidden| !hidden).count(), 1);
}

/// A reference whose record is damaged behind it is refused, whatever it would place.
#[test]
fn damaged_references_place_nothing() {
    let mut bytes = f::nested_blocks(1, false);
    let code = 0x0200_8072_u32.to_le_bytes();
    let at = bytes
        .windows(4)
        .position(|w| w == code)
        .expect("attributes");
    // Longer than the record that they are in.
    bytes[at + 4..at + 12].copy_from_slice(&(1_i64 << 40).to_le_bytes());
    let document = read_3dm(&bytes).expect("a file");
    let refused = |o: &feeler_io::Object| matches!(o.kind, ObjectKind::Refused { .. });
    assert_eq!(document.objects.iter().filter(|o| refused(o)).count(), 1);
    assert_eq!(document.bodies().count(), 1);
}

/// In other units what blocks place is where their maps take it, within what is said: bodies of the converted file and bodies moved, and then converted, differ by no
/// more than that and what each is off when it is moved.
#[test]
fn units_are_converted_through_blocks() {
    let document = read_3dm(&f::nested_blocks(12, false)).expect("a file");
    let mut feet = document.clone();
    let unit = feeler_io::Units::Feet;
    let off = feet.convert_units(unit).expect("millimetres");
    let ratio = 1.0 / 304.8;
    let size = ratio * 4096.0;
    assert!(off > 0.0 && off < 64.0 * f64::EPSILON * size, "{off:e}");
    let mut most: f64 = 0.0;
    for ((_, a), (_, b)) in document.bodies().zip(feet.bodies()) {
        for (p, q) in a.parts().vertices.iter().zip(&b.parts().vertices) {
            most = most.max((p.point.coords * ratio - q.point.coords).amax());
        }
    }
    // And the test's own roundings, and those of moving.
    assert!(most <= off + 64.0 * f64::EPSILON * size, "{most:e}");
}

/// What places more copies than there may be, or itself, is refused where it is placed, and nothing else is.
#[test]
fn blocks_that_unfold_without_end_are_refused() {
    for (levels, is_ring, why) in [
        (20, false, "unfold to too much"),
        (30, false, "unfold to too much"),
        (1, true, "holds itself"),
        (5, true, "holds itself"),
    ] {
        let document = read_3dm(&f::nested_blocks(levels, is_ring)).expect("a file");
        for object in document.objects.iter().filter(|o| !o.block_member) {
            let ObjectKind::Refused { reason, .. } = &object.kind else {
                panic!("{:?}", object.kind);
            };
            assert!(reason.to_string().contains(why), "{reason}");
        }
        assert_eq!(document.breps().count(), 1);
        assert_eq!(document.bodies().count(), 0);
    }
}

#[test]
fn edges_have_the_images_of_curves_on_surfaces() {
    let read = |write: fn(&mut f::Writer)| {
        let bytes = f::file(60, |w| w.record("it", f::BREP, write));
        read_3dm(&bytes).expect("a file")
    };
    let document = read(f::brep_on_surface);
    let parts = brep(&document, 0).parts();
    // A line on a plane: the same as is stored in space otherwise.
    assert_eq!(parts.curves3, brep(&read(f::brep), 0).parts().curves3);
    let said = &document.objects[0].warnings;
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(
        said[0].starts_with("edge 3: its curve is a curve on a surface")
            && said[0].ends_with("the curve in space that it is, rounded"),
        "{said:?}"
    );
    // One that is damaged is done without.
    let document = read(f::brep_on_damaged_surface);
    let p = brep(&document, 0).parts();
    let curves: Vec<_> = p.edges.iter().map(|e| e.curve).collect();
    assert_eq!(curves, [Some(0), Some(0), Some(0), None]);
    let said = &document.objects[0].warnings;
    assert!(said[0].ends_with("the faces' trims are used"), "{said:?}");
}
