//! Locations of a `.brep` that are no rigid motions: what scales evenly or mirrors is placed, what shears is refused by the location's number, and
//! the rest is read.

use feeler::prepare::PreparedBrep;
use feeler::query::{Options, Probe, Sphere, Workspace, contact};
use feeler_io::{ObjectKind, read_brep};
use nalgebra::{Matrix3, Point3, Vector3};
use std::path::Path;

/// A part placed by locations, the first of which moves by (0, 7, 1).
fn placed() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/brep/placed.brep");
    std::fs::read_to_string(path).expect("a file of the corpus")
}

/// The same with other numbers in the first location's matrix.
fn with(rows: [&str; 3]) -> String {
    let whole = placed();
    let mut lines: Vec<&str> = whole.lines().collect();
    let first = lines
        .iter()
        .position(|l| l.starts_with("Locations"))
        .expect("a table")
        + 2;
    assert_eq!(
        lines[first].split_whitespace().collect::<Vec<_>>(),
        ["1", "0", "0", "0"]
    );
    lines[first..first + 3].copy_from_slice(&rows);
    lines.join("\n")
}

/// How many parts are placed, and why those that are refused are.
fn refusals(text: &str) -> (usize, Vec<String>) {
    let document = read_brep(text.as_bytes()).expect("a file");
    let own = document.objects.iter().enumerate();
    let own = own.filter(|(_, o)| !o.block_member);
    let parts: Vec<_> = own.flat_map(|(i, _)| document.parts(i)).collect();
    let refused = parts.iter().filter_map(|o| match &o.kind {
        ObjectKind::Refused { reason, .. } => Some(reason.to_string()),
        _ => None,
    });
    (parts.len(), refused.collect())
}

#[test]
fn sheared_locations_are_refused_by_number() {
    let (all, none) = refusals(&placed());
    assert!(all > 0 && none.is_empty(), "{none:?}");
    for rows in [
        ["1 0 0 0", "0 1 0 7", "0 0 3 1"],
        ["1 0.5 0 0", "0 1 0 7", "0 0 1 1"],
        ["1 0 0 0", "0 0 0 7", "0 0 1 1"],
        ["0 0 0 0", "0 0 0 7", "0 0 0 1"],
    ] {
        let (count, refused) = refusals(&with(rows));
        // A compound that cannot be placed is refused as one.
        assert!(count <= all && !refused.is_empty(), "{rows:?}");
        for reason in refused {
            let named = reason.contains("location 1 keeps no shapes")
                && reason.contains("changes squared lengths");
            assert!(named && reason.starts_with("line "), "{reason}");
        }
    }
}

/// The signed distance of a point from what is placed: a box of 3 x 2 x 1 with a hole of radius 0.5 along z at (1, 1); where the point is
/// above or below the hole it is not asked.
fn from_part(p: &Point3<f64>) -> f64 {
    let outside = |x: f64, length: f64| (x - length).max(-x);
    let off = [outside(p.x, 3.0), outside(p.y, 2.0), outside(p.z, 1.0)];
    let to_box = match off.iter().fold(f64::NEG_INFINITY, |a: f64, x| a.max(*x)) {
        most if most <= 0.0 => most,
        _ => off.iter().map(|x| x.max(0.0).powi(2)).sum::<f64>().sqrt(),
    };
    let to_hole = 0.5 - (p.x - 1.0).hypot(p.y - 1.0);
    assert!(to_hole < 0.0 || (0.0..=1.0).contains(&p.z));
    to_box.max(to_hole)
}

/// The first part stands at location 1 alone: whatever it scales, turns or mirrors by, distances from it are those from the part itself, scaled.
#[test]
fn mirrored_and_scaled_locations_place_what_they_say() {
    for rows in [
        ["1 0 0 0", "0 1 0 7", "0 0 1 1"],
        ["-1 0 0 0", "0 1 0 7", "0 0 1 1"],
        ["2 0 0 0", "0 2 0 7", "0 0 2 1"],
        ["0 -0.75 0 4", "0 0 0.75 7", "0.75 0 0 1"],
        // Turned by an angle of (0.6, 0.8), mirrored in z, thrice the size.
        ["1.8 -2.4 0 0", "2.4 1.8 0 7", "0 0 -3 1"],
    ] {
        let (_, refused) = refusals(&with(rows));
        assert!(refused.is_empty(), "{refused:?}");
        let numbers = rows.map(|r| {
            let words = r.split_whitespace().map(|w| w.parse::<f64>().unwrap());
            words.collect::<Vec<_>>()
        });
        let matrix = Matrix3::from_fn(|i, j| numbers[i][j]);
        let translation = Vector3::from_fn(|i, _| numbers[i][3]);
        let scale = matrix.determinant().abs().cbrt();
        let document = read_brep(with(rows).as_bytes()).unwrap();
        let (_, brep) = document.bodies().next().expect("a solid");
        assert!(brep.is_closed());
        for d in brep.defects() {
            assert!(
                d.severity() <= feeler::brep::Severity::Note,
                "{rows:?}: {d}"
            );
        }
        let prepared = PreparedBrep::new(brep.into_owned());
        let mut workspace = Workspace::default();
        for i in 0..9 {
            for j in 0..7 {
                for k in 0..5 {
                    let [x, y, z] = [i, j, k].map(f64::from);
                    let p = Point3::new(-0.55 + 0.5 * x, -0.45 + 0.5 * y, -0.35 + 0.4 * z);
                    if !(0.0..=1.0).contains(&p.z) && (p.x - 1.0).hypot(p.y - 1.0) <= 0.5 {
                        continue;
                    }
                    let q = Point3::from(matrix * p.coords + translation);
                    let ball = Probe::Sphere(Sphere::new(q, 0.0).unwrap());
                    let answer = contact(&prepared, &ball, &Options::default(), &mut workspace);
                    let (found, known) = (answer.separation.value, scale * from_part(&p));
                    assert!(
                        (found - known).abs() < 1e-13,
                        "{rows:?} {p}: {found} {known}"
                    );
                }
            }
        }
    }
}
