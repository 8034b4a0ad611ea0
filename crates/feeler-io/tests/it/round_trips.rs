//! What is written as .3dm is read back as it was, number by number.

use crate::models::{models, wanted};
use feeler::brep::{Brep, Iso};
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve, Curve2, Line, NurbsCurve, Plane, Surface};
use feeler_io::{Document, Object, ObjectKind, read_3dm, read_file, write_3dm};
use nalgebra::{Point3, Vector3};
use std::f64::consts::TAU;
use std::path::Path;

fn negated(i: Interval) -> Interval {
    Interval::new(-i.end, -i.start).expect("an interval")
}

/// The same points at the negated parameters.
fn turned(curve: &Curve2) -> Curve2 {
    match curve {
        Curve::Line(l) => Curve::Line(Line::new(l.to, l.from, negated(l.domain)).expect("a line")),
        Curve::Arc(a) => Curve::Arc(Arc {
            // (The third axis is none in uv.)
            y: -a.y,
            angle: negated(a.angle),
            domain: negated(a.domain),
            ..a.clone()
        }),
        Curve::Nurbs(n) => {
            let points = n.control_points().iter().rev().copied().collect();
            let knots = n.knots().knots().iter().rev().map(|t| -t).collect();
            Curve::Nurbs(NurbsCurve::new(n.degree(), points, knots).expect("a curve"))
        }
        other => panic!("{other:?}"),
    }
}

/// Whether some trim of it runs against its curve.
fn has_turned(object: &Object) -> bool {
    match &object.kind {
        ObjectKind::Brep(b) | ObjectKind::Extrusion(b) => {
            b.parts().trims.iter().any(|t| t.reversed)
        }
        _ => false,
    }
}

/// All numbers of a value as it is printed: `{:?}` of an f64 has all its digits and the sign of zero.
fn print(object: &Object, along: bool) -> String {
    match &object.kind {
        // An extrusion is written as the BREP that it is.
        ObjectKind::Brep(b) | ObjectKind::Extrusion(b) => {
            let mut parts = b.parts().clone();
            // Flags that are set to fit where import has widened a domain.
            parts.trims.iter_mut().for_each(|t| t.iso = Iso::None);
            // Curves that trims run against come back turned: each trim's own, the way it runs.
            if along {
                let curves = std::mem::take(&mut parts.curves2);
                for (k, t) in parts.trims.iter_mut().enumerate() {
                    let curve = &curves[t.curve];
                    parts.curves2.push(if t.reversed {
                        turned(curve)
                    } else {
                        curve.clone()
                    });
                    if t.reversed {
                        t.span = negated(t.span);
                    }
                    (t.curve, t.reversed) = (k, false);
                }
            }
            format!("{parts:?}")
        }
        ObjectKind::Surface(s) => format!("{s:?}"),
        ObjectKind::Curve(c) => format!("{c:?}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn every_model_comes_back_bit_for_bit() {
    let (mut files, mut objects, mut noted, mut turned) = (0, 0, Vec::new(), 0);
    for path in models() {
        if path.extension().is_some_and(|e| e == "step") {
            continue;
        }
        let Ok(document) = read_file(&path) else {
            continue;
        };
        let written = write_3dm(&document).expect("faces with loops");
        let back = read_3dm(&written.bytes).expect("what was written");
        assert_eq!(back.warnings, [""; 0], "{}", path.display());
        assert_eq!(back.units, document.units, "{}", path.display());
        assert_eq!(back.tolerance, document.tolerance, "{}", path.display());
        let wanted = wanted(&document);
        assert_eq!(back.objects.len(), wanted.len(), "{}", path.display());
        assert_eq!(written.objects, wanted.len());
        let is_noted = written.notes.iter().any(|n| n.starts_with("object"));
        if is_noted {
            noted.push(path.file_name().unwrap_or_default().to_owned());
        }
        for (ours, theirs) in back.objects.iter().zip(wanted) {
            assert_eq!(ours.name, theirs.name);
            assert_eq!(
                ours.layer.as_deref(),
                Some(theirs.layer.as_deref().unwrap_or("Default"))
            );
            assert_eq!(
                (ours.hidden, ours.locked && !ours.hidden),
                (theirs.hidden, theirs.locked && !theirs.hidden)
            );
            if !is_noted {
                let along = has_turned(&theirs);
                turned += usize::from(along);
                assert!(
                    print(ours, along) == print(&theirs, along),
                    "{}: {}",
                    path.display(),
                    ours.name
                );
            }
            objects += 1;
        }
        // What was written once is written the same again, notes or none.
        let again = write_3dm(&back).expect("faces with loops");
        let again = read_3dm(&again.bytes).expect("what was written");
        let mut pairs = again.objects.iter().zip(&back.objects);
        assert!(
            pairs.all(|(a, b)| print(a, false) == print(b, false)),
            "{}",
            path.display()
        );
        files += 1;
    }
    assert!(
        files >= 60 && objects >= 80 && turned > 0,
        "{files} files, {objects} objects, {turned} of them turned"
    );
    // Only .brep files, and what was moved, have knots and axes that .3dm has no room for.
    let expected = |name: &std::ffi::OsString| {
        let name = name.to_string_lossy();
        name.ends_with(".brep") || name.starts_with("blocks")
    };
    assert!(noted.iter().all(expected), "{noted:?}");
    println!("{files} files, {objects} objects; with notes: {noted:?}");
}

/// Other units: points times the ratio, one rounding each here, and the bound holds it.
#[test]
fn units_are_converted_within_the_bound_said() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models");
    let whole = read_file(root.join("thesis/ball_joint_cavity.3dm")).expect("a model");
    let mut inches = whole.clone();
    let inch = feeler_io::Units::Inches;
    let off = inches.convert_units(inch.clone()).expect("millimetres");
    assert_eq!(inches.units, inch);
    assert!(off > 0.0 && off < 1e-12, "{off:e}");
    let of = |d: &Document| d.bodies().next().expect("a BREP").1.into_owned();
    let (a, b) = (of(&whole), of(&inches));
    for (f, _) in a.faces().iter().enumerate() {
        let [u, v] = a.surface(f).domain();
        for i in 0..=6 {
            for j in 0..=6 {
                let (s, t) = (u.lerp(f64::from(i) / 6.0), v.lerp(f64::from(j) / 6.0));
                let p = a.surface(f).point(s, t).coords / 25.4;
                let q = b.surface(f).point(s, t).coords;
                // Two roundings of the test's own.
                assert!((p - q).amax() <= off + 2.0 * f64::EPSILON * p.amax());
            }
        }
    }
    // A power of two rounds nothing.
    let mut same = whole.clone();
    assert_eq!(
        same.convert_units(feeler_io::Units::Millimetres)
            .expect("mm"),
        0.0
    );
    // Equal numbers: the sign of a zero may have gone.
    assert!(of(&same) == of(&whole));
    let mut none = Document::of_breps(vec![of(&whole)]);
    let said = none.convert_units(inch).expect_err("no unit").to_string();
    assert!(said.contains("has no length"), "{said}");
}

/// A damaged file asked for 83 million turns of a circle, with which a query takes seconds.
#[test]
fn many_turns_are_refused() {
    let interval = |a, b| Interval::new(a, b).unwrap();
    for (end, is_read) in [
        (TAU, true),
        (32.0 * TAU, true),
        (33.0 * TAU, false),
        (522_133_279.0, false),
    ] {
        let arc = Arc {
            center: Point3::origin(),
            x: Vector3::x(),
            y: Vector3::y(),
            z: Vector3::z(),
            radius: 1.0,
            angle: interval(0.0, end),
            domain: interval(0.0, 1.0),
        };
        let sheet = Plane {
            origin: Point3::origin(),
            x: Vector3::x(),
            y: Vector3::y(),
            domain: [interval(0.0, 1.0); 2],
            extents: [interval(0.0, 1.0); 2],
        };
        let sheet = Surface::Plane(Plane::new(sheet).unwrap());
        let mut document = Document::of_breps(vec![Brep::from_surface(sheet).unwrap()]);
        document.objects[0].kind = ObjectKind::Curve(Curve::Arc(Arc::new(arc).unwrap()));
        let written = write_3dm(&document).expect("a curve");
        let back = read_3dm(&written.bytes).expect("a document");
        let told = format!("{:?}", back.objects[0].kind);
        assert_eq!(told.contains("32 turns at most"), !is_read, "{told}");
    }
}
