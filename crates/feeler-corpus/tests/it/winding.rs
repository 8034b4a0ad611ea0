//! Faces that wind around their surface by more than a turn (`corpora/make_brep.py`: a thread, a band on a cylinder and one on a cone), against
//! analysis; and OCCT's own part with such faces, where it is.

use feeler::nurbs::Surface;
use feeler::prepare::PreparedBrep;
use feeler::query::*;
use feeler::trim::Side;
use feeler_io::{Document, ObjectKind, read_3dm, read_file, write_3dm};
use nalgebra::{Point3, Vector3};
use std::f64::consts::TAU;
use std::path::Path;

fn document() -> Document {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/brep/winding.brep");
    read_file(path).expect("a file of the corpus")
}

fn prepared(document: Document) -> Vec<PreparedBrep> {
    let breps = document.objects.into_iter().map(|o| match o.kind {
        ObjectKind::Brep(brep) => PreparedBrep::new(brep),
        other => panic!("{other:?}"),
    });
    breps.collect()
}

fn parts() -> Vec<PreparedBrep> {
    prepared(document())
}

/// As NURBS from a .3dm, which has no surface of revolution over more than a turn.
fn written() -> Vec<PreparedBrep> {
    let written = write_3dm(&document()).expect("three objects");
    let said = { written.notes.iter() }.filter(|n| n.contains("over more than a turn"));
    assert_eq!(said.count(), 3, "{:?}", written.notes);
    let back = prepared(read_3dm(&written.bytes).expect("a document"));
    for part in &back {
        for surface in &part.brep().parts().surfaces {
            if let Surface::Revolution(r) = surface {
                assert!(r.angle.length() <= TAU);
            }
        }
    }
    back
}

/// The band in uv, between straight lines from -4 to 11.5: its lower edge.
fn lower(u: f64) -> f64 {
    5.0 * (u + 4.0) / 15.5
}

const BAND: [f64; 2] = [-4.0, 11.5];
const WIDE: f64 = 0.5;

/// A surface turned about the z axis through `at`: its radius at height 0 and its slope, as (sin, cos).
struct Turned {
    at: [f64; 2],
    radius: f64,
    slope: (f64, f64),
}

impl Turned {
    fn point(&self, u: f64, v: f64) -> Point3<f64> {
        let r = self.radius + v * self.slope.0;
        let [x, y] = self.at;
        Point3::new(x + r * u.cos(), y + r * u.sin(), v * self.slope.1)
    }

    fn normal(&self, u: f64) -> Vector3<f64> {
        let (sin, cos) = self.slope;
        Vector3::new(cos * u.cos(), cos * u.sin(), -sin)
    }
}

fn bands() -> [(usize, Turned); 2] {
    let cylinder = Turned {
        at: [8.0, 0.0],
        radius: 2.0,
        slope: (0.0, 1.0),
    };
    let cone = Turned {
        at: [0.0, 8.0],
        radius: 1.0,
        slope: 0.25_f64.sin_cos(),
    };
    [(1, cylinder), (2, cone)]
}

/// A point beside the middle of the band is as far from it as it is from the surface, to the surface's own rounding.
#[test]
fn balls_beside_bands() {
    for parts in [parts(), written()] {
        balls_beside(&parts);
    }
}

fn balls_beside(parts: &[PreparedBrep]) {
    let mut workspace = Workspace::default();
    for (part, surface) in bands() {
        for k in 0..=30 {
            let u = BAND[0] + 0.1 + 0.5 * f64::from(k);
            let v = lower(u) + 0.5 * WIDE;
            for off in [0.2, -0.125, 0.01] {
                let q = surface.point(u, v) + surface.normal(u) * off;
                let probe = Probe::Sphere(Sphere::new(q, 0.0).expect("a point"));
                let answer = contact(&parts[part], &probe, &Options::default(), &mut workspace);
                let found = answer.separation.value;
                assert!((found - off.abs()).abs() < 1e-14, "{part}, {u}: {found}");
            }
        }
    }
}

/// A line from the axis outward hits a band where one of the turns of its angle is within it, once.
#[test]
fn lines_through_bands() {
    for parts in [parts(), written()] {
        lines_through(&parts);
    }
}

fn lines_through(parts: &[PreparedBrep]) {
    let mut workspace = Workspace::default();
    let mut counts = [0; 2];
    for (part, surface) in bands() {
        for i in 0..40 {
            let angle = 0.05 + TAU * f64::from(i) / 40.0;
            for j in 0..20 {
                let v = -0.45 + 0.35 * f64::from(j);
                let turns = (-2..=2).map(|k| angle + TAU * f64::from(k));
                let is_in = |u: &f64| {
                    let up = v - lower(*u);
                    // None of those asked is next to a border, where roundings would count.
                    assert!(up.abs() > 1e-6 && (up - WIDE).abs() > 1e-6);
                    BAND[0] < *u && *u < BAND[1] && 0.0 < up && up < WIDE
                };
                let expected = turns.filter(is_in).count();
                let to = surface.point(angle, v);
                let from = Point3::new(surface.at[0], surface.at[1], to.z);
                let probe = LineProbe::new(from, to - from, LineKind::Ray).expect("a line");
                let answer = line(&parts[part], &probe, &Options::default(), &mut workspace);
                assert_eq!(answer.undecided, None, "{part}, {angle}, {v}");
                assert_eq!(answer.hits.len(), expected, "{part}, {angle}, {v}");
                assert!(answer.hits.iter().all(|h| (h.t.value - 1.0).abs() < 1e-14));
                counts[expected] += 1;
            }
        }
    }
    assert!(counts[0] > 200 && counts[1] > 200, "{counts:?}");
}

/// Along the middle of the thread, over more than a turn, and between its turns.
#[test]
fn sides_of_a_thread() {
    let parts = parts();
    assert!(parts[0].brep().is_closed());
    for defect in parts[0].brep().defects() {
        let note = feeler::brep::Severity::Note;
        assert!(defect.severity() <= note, "{defect}");
    }
    let mut workspace = Workspace::default();
    // At a radius of 2.25 it is 0.2 high or more where it is here, half an ellipse above its chord; one turn is 1 up.
    for k in 0..=40 {
        let u = TAU - 4.0 + 0.2 * f64::from(k);
        let chord = 2.0 + (u - TAU) / TAU;
        for (up, side) in [
            (0.1, Side::Inside),
            (-0.1, Side::Outside),
            (0.5, Side::Outside),
            (-0.5, Side::Outside),
        ] {
            let q = Point3::new(2.25 * u.cos(), 2.25 * u.sin(), chord + up);
            let found = inside(&parts[0], q, &mut workspace).side;
            assert_eq!(found, Some(side), "{u}, {up}");
        }
    }
}

/// The bottle of OCCT's tutorial, of Debian's package occt-misc: the thread of its neck winds.
#[test]
fn the_bottle_of_occt() {
    let folder = std::env::var("FEELER_OCCT").unwrap_or("/usr/share/opencascade/data/occ".into());
    let path = Path::new(&folder).join("bottle.brep");
    if !path.exists() {
        eprintln!(
            "SKIPPED: no {} (Debian's package occt-misc; FEELER_OCCT names another folder)",
            path.display()
        );
        return;
    }
    let document = read_file(path).expect("a part of OCCT");
    let [object] = &document.objects[..] else {
        panic!("one solid");
    };
    let ObjectKind::Brep(brep) = &object.kind else {
        panic!("{:?}", object.kind);
    };
    let said: Vec<String> = brep.defects().iter().map(|d| d.to_string()).collect();
    assert!(
        !said
            .iter()
            .any(|d| d.contains("leaves the surface's domain")),
        "{said:?}"
    );
    let prepared = PreparedBrep::new(brep.clone());
    let mut workspace = Workspace::default();
    // Its neck is a ring from 6.9 to 7.5 about the z axis, 55 high; the body below is hollow, its wall 0.6 thick.
    for (q, side) in [
        ([0.0, 0.0, 30.0], Side::Outside),
        ([0.0, 0.0, 60.0], Side::Outside),
        ([0.0, 7.2, 54.5], Side::Inside),
        ([0.0, -7.2, 51.0], Side::Inside),
        ([0.0, 0.0, 0.25], Side::Inside),
        ([0.0, 3.0, 52.0], Side::Outside),
        ([30.0, 0.0, 10.0], Side::Outside),
    ] {
        let found = inside(&prepared, q.into(), &mut workspace).side;
        assert_eq!(found, Some(side), "{q:?}");
    }
}
