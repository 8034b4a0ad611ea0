//! Model files: exact both ways, and hostile ones refused.

use super::*;
use crate::Model;
use crate::hash::breps_hash;
use feeler::brep::BrepBuilder;
use nalgebra::{Point2, Point3, Vector2, Vector3};
use std::path::{Path, PathBuf};

fn cube() -> Brep {
    let mut cube = BrepBuilder::new();
    for i in 0..8 {
        let [x, y, z] = [i & 1, i >> 1 & 1, i >> 2].map(|c| f64::from(c) * 0.1);
        cube.vertex([x, y, z]);
    }
    for corners in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [1, 3, 7, 5],
        [3, 2, 6, 7],
        [2, 0, 4, 6],
    ] {
        cube.planar_face(&corners).unwrap();
    }
    cube.build().unwrap()
}

/// One of each kind of surface and curve, with numbers that are easily lost.
fn menagerie() -> Brep {
    let unit = interval([0.0, 1.0]);
    let arc = Arc::new(Arc {
        center: Point3::new(-0.0, 5e-324, 1.0 / 3.0),
        x: Vector3::x(),
        y: Vector3::y(),
        z: Vector3::z(),
        radius: 0.1 + 0.2,
        angle: interval([0.0, 1.5]),
        domain: unit,
    })
    .unwrap();
    let arc2 = Arc::new(Arc {
        center: Point2::new(0.5, 0.5),
        x: Vector2::x(),
        y: -Vector2::y(),
        z: Vector2::zeros(),
        radius: 0.25,
        angle: interval([-1.0, 5.0]),
        domain: interval([2.0, 3.0]),
    })
    .unwrap();
    let line = Line::new(
        Point3::new(1.0, 0.0, -1e22),
        Point3::new(1.0, 0.0, 1.0),
        unit,
    )
    .unwrap();
    let points = [[0.0, 0.0], [0.3, 1e-300], [0.7, 0.9]].map(Point2::from);
    let polyline = Polyline::new(points.to_vec(), vec![0.0, 0.1, 0.2]).unwrap();
    let nurbs = NurbsCurve::new(
        1,
        vec![
            SVector::from([0.7, 0.9, 1e-12]),
            SVector::from([0.1, 0.2, 1e12]),
        ],
        vec![0.0, 0.0, 1.0, 1.0],
    )
    .unwrap();
    let pieces = vec![Curve::Polyline(polyline), Curve::Nurbs(nurbs)];
    let poly = Curve::Poly(PolyCurve::new(pieces, vec![0.0, 0.2, 1.2]).unwrap());
    let net = (0..6).map(|i| Vector4::new(f64::from(i), 0.1 * f64::from(i * i), 0.0, 1.5));
    let patch = NurbsSurface::new(
        [2, 1],
        [3, 2],
        net.collect(),
        [vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], vec![0.0, 0.0, 2.0, 2.0]],
    )
    .unwrap();
    let revolution = Revolution {
        origin: Point3::origin(),
        axis: Vector3::new(0.0, 0.0, 3.0),
        angle: interval([0.0, 6.0]),
        angle_domain: interval([-1.0, 1.0]),
        profile: Curve::Line(line.clone()),
        transposed: true,
    };
    let sum = Sum {
        base: Vector3::new(1.0, 2.0, 3.0),
        first: Curve::Arc(arc),
        second: Curve::Line(line),
    };
    let mut parts = cube().parts().clone();
    parts.surfaces.extend([
        Surface::Nurbs(patch),
        Surface::Revolution(Revolution::new(revolution).unwrap()),
        Surface::Sum(sum),
    ]);
    parts.curves2.extend([poly, Curve::Arc(arc2)]);
    let first = parts.surfaces.len() - 3;
    for (k, loops) in [(0, None), (1, Some(vec![])), (2, None)] {
        parts.faces.push(Face {
            surface: first + k,
            loops,
            reversed: k == 1,
        });
    }
    parts.vertices[3].tolerance = Some(1e-7);
    parts.edges[5].curve = None;
    parts.trims[2].edge = None;
    parts.trims[2].kind = TrimKind::Singular;
    parts.trims[2].iso = Iso::North;
    parts.loops[1].kind = LoopKind::Slit;
    Brep::new(parts).unwrap()
}

#[test]
fn breps_come_back_bit_for_bit() {
    let breps = [cube(), menagerie()];
    let text = to_text(&breps, Some("mm"));
    let again = from_text(&text).unwrap();
    assert_eq!(again, breps);
    // The hash sees the sign of a zero too.
    let hash = |b: &[Brep]| breps_hash(&b.iter().collect::<Vec<_>>());
    assert_eq!(hash(&again), hash(&breps));
    assert_eq!(to_text(&again, Some("mm")), text);
}

#[test]
fn the_thesis_parts_come_back_bit_for_bit() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/thesis");
    for name in ["ball_joint_cavity_nurbs", "geneva4_wheel_nurbs"] {
        let model = Model::load(&folder.join(format!("{name}.3dm")), None).unwrap();
        let again = from_text(&to_text(&model.breps, None)).unwrap();
        let all: Vec<&Brep> = again.iter().collect();
        assert_eq!(breps_hash(&all), model.hash(), "{name}");
    }
}

fn refused(text: &str) -> Problem {
    match from_text(text) {
        Ok(_) => panic!("accepted: {}", &text[..text.len().min(300)]),
        Err(p) => p,
    }
}

#[test]
fn hostile_files_are_refused_with_place_and_reason() {
    let good = to_text(&[menagerie()], None);
    assert!(from_text(&good).is_ok());
    let swap = |from: &str, to: &str| {
        assert!(good.contains(from), "no {from}");
        good.replacen(from, to, 1)
    };
    for (text, place, reason) in [
        (String::new(), "line 1", "EOF"),
        ("[]".to_owned(), "line 1", ""),
        ("[".repeat(100_000), "line 1", ""),
        (good[..good.len() / 2].to_owned(), "line 1", "EOF"),
        (
            r#"{"feeler_model":1,"breps":[]}"#.to_owned(),
            "whole",
            "no BREP",
        ),
        (
            swap("\"feeler_model\":1", "\"feeler_model\":2"),
            "whole",
            "version 2",
        ),
        (
            swap(
                "\"feeler_model\":1",
                "\"feeler_model\":2,\"compression\":\"zstd\"",
            ),
            "whole",
            "version 2",
        ),
        (
            swap("\"faces\":", "\"fases\":"),
            "line 1",
            "unknown field `fases`",
        ),
        (
            swap("\"degrees\":[2,1]", "\"degrees\":[18446744073709551615,1]"),
            "surfaces 6",
            "too few",
        ),
        (
            swap("\"degrees\":[2,1]", "\"degrees\":[26,1]"),
            "surfaces 6",
            "",
        ),
        (
            swap("\"degrees\":[2,1]", "\"degrees\":[0,1]"),
            "surfaces 6",
            "degree 0",
        ),
        (
            swap("\"degrees\":[2,1]", "\"degrees\":[-2,1]"),
            "line 1",
            "",
        ),
        (
            swap("\"degree\":1,", "\"degree\":18446744073709551615,"),
            "curves2 24",
            "degree",
        ),
        (
            swap("\"radius\":0.30000000000000004", "\"radius\":-1"),
            "surfaces 8",
            "radius",
        ),
        (
            swap("\"radius\":0.30000000000000004", "\"radius\":1e999"),
            "line 1",
            "range",
        ),
        (
            swap("\"radius\":0.30000000000000004", "\"radius\":NaN"),
            "line 1",
            "",
        ),
        (
            swap("\"surface\":6", "\"surface\":600000"),
            "brep 0",
            "face 6 refers to surface 600000, but there are 9",
        ),
        (
            swap("\"loop\":0", "\"loop\":18446744073709551615"),
            "brep 0",
            "refers to loop",
        ),
        (swap("\"loop\":0", "\"loop\":-1"), "line 1", ""),
        (
            swap("\"span\":[0.0,", "\"span\":[2.0,"),
            "brep 0",
            "of a curve with domain",
        ),
        (
            swap("\"from\":[", "\"from\":[0,"),
            "surfaces 7",
            "4 numbers, no multiple of 3",
        ),
        (
            swap(",1000000000000.0]", ",-1.0]"),
            "curves2 24",
            "not positive",
        ),
        (
            swap("\"params\":[0.0,0.1,0.2]", "\"params\":[0.0,0.2,0.1]"),
            "curves2 24",
            "reversed",
        ),
        (
            swap("\"point\":[0.0,0.0,0.0]", "\"point\":[0.0,0.0]"),
            "line 1",
            "length",
        ),
    ] {
        let p = refused(&text);
        let short = &text[..text.len().min(100)];
        assert!(p.place.contains(place), "{short}: {p:?}");
        assert!(p.reason.contains(reason), "{short}: {p:?}");
        assert!(!p.reason.contains('\n'), "{p:?}");
    }
}

/// A poly-curve in a poly-curve in a ... : the depth of JSON is limited, not our stack.
#[test]
fn nesting_is_bounded() {
    let line = r#"{"line":{"from":[0,0],"to":[1,1],"domain":[0,1]}}"#;
    let nested = |depth: usize| {
        let open = r#"{"poly":{"segments":["#.repeat(depth);
        let close = r#"],"params":[0,1]}}"#.repeat(depth);
        format!(
            r#"{{"feeler_model":1,"breps":[{{"surfaces":[],"curves2":[{open}{line}{close}],"curves3":[],"vertices":[],"edges":[],"trims":[],"loops":[],"faces":[]}}]}}"#
        )
    };
    assert_eq!(from_text(&nested(30)).unwrap()[0].parts().curves2.len(), 1);
    assert!(refused(&nested(10_000)).reason.contains("recursion"));
}

struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn models_load_by_extension_and_errors_name_the_file() {
    let folder =
        Folder(std::env::temp_dir().join(format!("feeler-model-file-{}", std::process::id())));
    std::fs::create_dir_all(&folder.0).unwrap();
    let breps = [cube(), menagerie()];
    for name in ["a.json", "a.json.gz"] {
        let path = folder.0.join(name);
        Model::write(&path, &breps, Some("mm")).unwrap();
        assert_eq!(Model::load(&path, None).unwrap().breps, breps);
        assert_eq!(
            Model::load(&path, Some(1)).unwrap().breps,
            [breps[1].clone()]
        );
        let error = Model::load(&path, Some(2)).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains("has 2"), "{error}");
    }
    let bad = folder.0.join("bad.json");
    std::fs::write(&bad, "{\"feeler_model\":1").unwrap();
    let error = Model::load(&bad, None).unwrap_err().to_string();
    assert!(error.contains("bad.json: line 1 column 17: EOF"), "{error}");
    let error = Model::load(&folder.0.join("none.json.gz"), None).unwrap_err();
    assert!(error.to_string().contains("none.json.gz: No such file"));
}
