//! The trimmed region of every face of the models at hand.

use feeler::brep::Brep;
use feeler::trim::{BoxSide, Side, TrimRegion};
use feeler_io::{ObjectKind, read_file};
use std::path::{Path, PathBuf};

fn models() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/models");
    let mut out = Vec::new();
    for dir in ["thesis/3dm", "real"] {
        let Ok(entries) = std::fs::read_dir(root.join(dir)) else {
            eprintln!("SKIPPED: no models in {}", root.join(dir).display());
            continue;
        };
        out.extend(
            entries
                .flatten()
                .map(|e| e.path())
                .filter(|p| p.extension().is_some_and(|e| e == "3dm")),
        );
    }
    out.sort();
    out
}

/// Every face's sides are known at all points, and agree with those of the same region with u and v
/// swapped (another ray) and with what boxes say.
fn check(name: &str, brep: &Brep) -> [usize; 4] {
    let mut seen = [0; 4];
    let other = swapped(brep);
    for face in 0..brep.faces().len() {
        let region = TrimRegion::new(brep, face);
        let turned = TrimRegion::new(&other, face);
        let [u, v] = region.domain();
        let mut points = Vec::new();
        for i in 0..24 {
            for j in 0..24 {
                let s = |k: i32| (f64::from(k) + 0.37) / 24.0;
                points.push([u.lerp(s(i)), v.lerp(s(j))]);
            }
        }
        let step = 1 + region.pieces().len() / 200;
        for p in region.pieces().step_by(step) {
            let of_piece = p.control_points();
            for c in [of_piece[0], of_piece[of_piece.len() / 2]] {
                points.push([c[0] / c[2], c[1] / c[2]]);
            }
        }
        for q in points {
            let side = region.side(q.into());
            assert!(side.side.is_some(), "{name} face {face}: {q:?}");
            let swapped = turned.side([q[1], q[0]].into());
            assert_eq!(side, swapped, "{name} face {face}: {q:?}");
            seen[match side.side {
                Some(Side::Inside) => 0,
                Some(Side::Outside) => 1,
                Some(Side::Boundary) => 2,
                None => 3,
            }] += 1;
            let (du, dv) = (u.length() / 100.0, v.length() / 100.0);
            let b = region.classify_box([q[0] - du, q[0] + du], [q[1] - dv, q[1] + dv]);
            match (side.side, b) {
                (Some(Side::Inside | Side::Boundary), BoxSide::Outside) => panic!("{name} {q:?}"),
                (Some(Side::Outside), BoxSide::Inside) if u.contains(q[0]) && v.contains(q[1]) => {
                    panic!("{name} {q:?}")
                }
                _ => {}
            }
        }
    }
    seen
}

/// The same faces with u and v swapped: planes stand in for the surfaces, of which a region sees the
/// domain alone.
fn swapped(brep: &Brep) -> Brep {
    use feeler::nurbs::*;
    use nalgebra::{Point2, Point3, Vector2, Vector3};
    fn turn(c: &Curve2) -> Curve2 {
        let p = |p: &Point2<f64>| Point2::new(p.y, p.x);
        match c {
            Curve::Line(l) => Curve::Line(Line {
                from: p(&l.from),
                to: p(&l.to),
                domain: l.domain,
            }),
            Curve::Polyline(l) => Curve::Polyline(
                Polyline::new(l.points().iter().map(p).collect(), l.params().to_vec()).unwrap(),
            ),
            Curve::Nurbs(n) => Curve::Nurbs(
                NurbsCurve::new(
                    n.degree(),
                    n.control_points()
                        .iter()
                        .map(|p| [p[1], p[0], p[2]].into())
                        .collect(),
                    n.knots().knots().to_vec(),
                )
                .unwrap(),
            ),
            Curve::Arc(a) => {
                let mut a = a.clone();
                a.center = p(&a.center);
                (a.x, a.y) = (Vector2::new(a.x.y, a.x.x), Vector2::new(a.y.y, a.y.x));
                Curve::Arc(a)
            }
            Curve::Poly(q) => Curve::Poly(
                PolyCurve::new(q.segments().iter().map(turn).collect(), q.params().to_vec())
                    .unwrap(),
            ),
        }
    }
    let mut parts = brep.parts().clone();
    for c in &mut parts.curves2 {
        *c = turn(c);
    }
    for s in &mut parts.surfaces {
        let [u, v] = s.domain();
        *s = Surface::Plane(Plane {
            origin: Point3::origin(),
            x: Vector3::x(),
            y: Vector3::y(),
            domain: [v, u],
            extents: [v, u],
        });
    }
    Brep::new(parts).unwrap()
}

#[test]
fn every_face_has_a_region() {
    let models = models();
    for path in &models {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let Ok(document) = read_file(path) else {
            eprintln!("{name}: refused");
            continue;
        };
        let start = std::time::Instant::now();
        let (mut faces, mut seen, mut pieces) = (0, [0; 4], 0);
        for object in &document.objects {
            if let ObjectKind::Brep(brep) = &object.kind {
                faces += brep.faces().len();
                for f in 0..brep.faces().len() {
                    pieces += TrimRegion::new(brep, f).pieces().len();
                }
                for (a, b) in seen.iter_mut().zip(check(&name, brep)) {
                    *a += b;
                }
            }
        }
        eprintln!(
            "{name}: {faces} faces, {pieces} pieces, in/out/on {seen:?}, {:?}",
            start.elapsed()
        );
    }
}
