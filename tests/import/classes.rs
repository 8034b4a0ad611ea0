//! Files made up byte by byte: every class, with what the models do not have.

use crate::fixture::{self as f, Writer};
use crate::models::{brep_of, compare_edge, compare_others, compare_surface};
use crate::reference;
use feeler::brep::Iso;
use feeler::nurbs::{Curve, Surface};
use feeler_io::{Document, ObjectKind, read_3dm};
use nalgebra::{Point2, Vector3, Vector4};

/// Every version that is read.
const VERSIONS: [u32; 7] = [3, 4, 5, 50, 60, 70, 80];

/// All curves and surfaces, by their first id.
pub(crate) fn simple(w: &mut Writer) {
    w.record("line", f::LINE, |w| {
        f::line(w, [1.0, 2.0, 3.0], [4.0, 5.0, 7.0], [-1.0, 1.0], 3);
    });
    w.record("arc", f::ARC, f::arc);
    w.record("polyline", f::POLYLINE, |w| {
        let points = [[0.0; 3], [1.0, 0.0, 0.5], [1.0, 1.0, -3.0]];
        f::polyline(w, &points, &[0.0, 0.5, 3.0], 3);
    });
    w.record("NURBS curve", f::NURBS_CURVE, f::nurbs_curve);
    w.record("poly-curve", f::POLY_CURVE, f::poly_curve);
    w.record("plane", f::PLANE, |w| f::plane(w, [-2.0, 5.0, 1.0, 4.0]));
    w.record("revolution", f::REV, |w| f::revolution(w, 0x20, 0));
    w.record("transposed", f::REV, |w| f::revolution(w, 0x20, 1));
    w.record("sum", f::SUM, f::sum);
    w.record("NURBS surface", f::NURBS_SURFACE, f::nurbs_surface);
    w.record("sheet", f::BREP, f::brep);
}

fn read(bytes: &[u8]) -> Document {
    let document = read_3dm(bytes).expect("a file");
    assert_eq!(document.warnings, Vec::<String>::new());
    for object in &document.objects {
        if let ObjectKind::Refused { class, reason } = &object.kind {
            panic!("{class} {}: {reason}", object.name);
        }
    }
    document
}

fn only(id: &str, data: impl Fn(&mut Writer)) -> ObjectKind {
    let bytes = f::file(60, |w| w.record("it", id, data));
    read(&bytes).objects.remove(0).kind
}

#[test]
fn every_version_says_the_same() {
    let first = read(&f::file(3, simple));
    let names: Vec<_> = first.objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names[0], "line");
    assert_eq!(names.len(), 11);
    for version in VERSIONS {
        let document = read(&f::file(version, simple));
        assert_eq!(document.version, version);
        assert_eq!(document.units.symbol(), "mm");
        assert_eq!(document.tolerance, Some(0.001));
        for (object, other) in document.objects.iter().zip(&first.objects) {
            assert_eq!((&object.name, &object.kind), (&other.name, &other.kind));
        }
    }
}

/// Plug-ins attach data of their own to objects, and to curves and surfaces within them.
#[test]
fn user_data_changes_nothing() {
    for version in VERSIONS {
        let plain = read(&f::file(version, simple));
        let bytes = f::with_user_data(|| f::file(version, simple));
        let attached = bytes.windows(16).filter(|w| *w == [0xAB; 16]).count();
        // Two each: the objects alone are eleven, and the sheet has surfaces and curves.
        assert!(attached > 2 * 15, "{attached}");
        let with = read(&bytes);
        assert_eq!(plain.objects.len(), with.objects.len());
        for (object, other) in plain.objects.iter().zip(&with.objects) {
            assert_eq!((&object.name, &object.kind), (&other.name, &other.kind));
        }
    }
}

#[test]
fn made_up_files_evaluate_as_in_another_reader() {
    let dir = std::env::temp_dir().join(format!("feeler-import-{}", std::process::id()));
    std::fs::create_dir_all(&dir).expect("a directory");
    let versions = [3, 4, 50, 60, 70, 80];
    let paths = versions.map(|v| dir.join(format!("v{v}.3dm")));
    for (path, version) in paths.iter().zip(versions) {
        std::fs::write(path, f::file(version, simple)).expect("written");
    }
    let references = reference::read(&paths);
    std::fs::remove_dir_all(&dir).expect("removed");
    for (reference, version) in references.iter().flatten().zip(versions) {
        let document = read(&f::file(version, simple));
        assert_eq!(
            compare_others(&document, reference),
            10,
            "version {version}"
        );
        assert_eq!(reference.breps.len(), 1);
        let theirs = &reference.breps[0];
        let brep = brep_of(&document, theirs.object);
        let off = compare_surface(brep.surface(0), &theirs.faces[0].surface, 7.0);
        assert!(off <= 64.0, "{off} ulp");
        for (i, edge) in theirs.edges.iter().enumerate() {
            let off = compare_edge(brep, i, edge, 7.0);
            assert!(off <= 1.0, "edge {i}: {off} bounds");
        }
    }
}

#[test]
fn aliases_are_the_same_classes() {
    let surface = only(f::NURBS_SURFACE, f::nurbs_surface);
    for id in f::NURBS_SURFACE_ALIASES {
        assert_eq!(only(id, f::nurbs_surface), surface);
    }
    let curve = only(f::NURBS_CURVE, f::nurbs_curve);
    for id in f::NURBS_CURVE_ALIASES {
        assert_eq!(only(id, f::nurbs_curve), curve);
    }
    let poly = only(f::POLY_CURVE, f::poly_curve);
    assert_eq!(only(f::POLY_CURVE_ALIAS, f::poly_curve), poly);
    let turned = |w: &mut Writer| f::revolution(w, 0x20, 0);
    assert_eq!(only(f::REV_ALIAS, turned), only(f::REV, turned));
    assert_eq!(only(f::SUM_ALIAS, f::sum), only(f::SUM, f::sum));
    for id in f::BREP_ALIASES {
        assert_eq!(only(id, f::brep), only(f::BREP, f::brep));
    }
}

#[test]
fn numbers_keep_their_bits() {
    let ObjectKind::Curve(Curve::Nurbs(curve)) = only(f::NURBS_CURVE, f::nurbs_curve) else {
        panic!("a NURBS curve");
    };
    assert_eq!(curve.degree(), 2);
    // The two knots that the format leaves out are added; homogeneous points stay as stored.
    assert_eq!(curve.knots().knots()[1..7], f::KNOTS);
    assert_eq!(curve.knots().knots().len(), 8);
    assert_eq!(curve.domain().start, 0.0);
    assert_eq!(curve.domain().end, 2.0);
    assert_eq!(curve.control_points()[2], Vector4::new(4.0, 0.2, 2.0, 2.0));

    let turned = |layout, transposed| {
        let kind = only(f::REV, |w| f::revolution(w, layout, transposed));
        let ObjectKind::Surface(brep) = kind else {
            panic!("a surface");
        };
        assert_eq!(brep.faces()[0].loops, None);
        brep.surface(0).clone()
    };
    let (Surface::Revolution(old), Surface::Revolution(new)) = (turned(0x10, 1), turned(0x20, 1))
    else {
        panic!("surfaces of revolution");
    };
    // In layout 1 the parameter was the angle.
    assert_eq!(old.angle_domain, old.angle);
    assert_eq!((new.angle_domain.start, new.angle_domain.end), (0.0, 10.0));
    assert_eq!((new.angle.start, new.angle.end), (0.5, 3.0));
    assert_eq!(new.axis, Vector3::new(0.0, 3.0, 4.0));
    assert!(new.transposed);
}

#[test]
fn poly_curves_are_flattened() {
    let ObjectKind::Curve(Curve::Poly(poly)) = only(f::POLY_CURVE, f::poly_curve) else {
        panic!("a poly-curve");
    };
    // The inner one's [-1, 2] is mapped onto [1, 4].
    assert_eq!(poly.params(), [0.0, 1.0, 2.0, 4.0]);
    assert_eq!(poly.segments().len(), 3);
}

#[test]
fn holes_are_renumbered_and_directions_kept() {
    let ObjectKind::Brep(brep) = only(f::BREP, f::brep) else {
        panic!("a BREP");
    };
    let p = brep.parts();
    assert_eq!((p.curves2.len(), p.curves3.len()), (2, 2));
    assert_eq!(
        p.trims.iter().map(|t| t.curve).collect::<Vec<_>>(),
        [0, 0, 0, 1]
    );
    assert_eq!(
        p.edges.iter().map(|e| e.curve).collect::<Vec<_>>(),
        [0, 0, 0, 1].map(Some)
    );
    assert_eq!(
        p.trims.iter().map(|t| t.reversed).collect::<Vec<_>>(),
        [false, false, false, true]
    );
    let iso: Vec<_> = p.trims.iter().map(|t| t.iso).collect();
    assert_eq!(iso, [Iso::South, Iso::East, Iso::North, Iso::West]);
    assert_eq!(p.vertices[0].tolerance, None);
    assert_eq!(p.vertices[1].tolerance, Some(0.0));
    assert_eq!(p.edges[0].tolerance, Some(1e-6));
    // Head to tail around the square, exactly.
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Point2::from);
    for (i, t) in p.trims.iter().enumerate() {
        let mut ends = [t.span.start, t.span.end];
        if t.reversed {
            ends.reverse();
        }
        let curve = &p.curves2[t.curve];
        assert_eq!(
            ends.map(|s| curve.point(s)),
            [corners[i], corners[(i + 1) % 4]]
        );
    }
}
