//! What is drawn is the part: closed where it is, as near to it as is said, its outside outside; and files that others can read.

use feeler::prepare::PreparedBrep;
use feeler::query::{self, Contacts, Options, Probe, Sphere, Workspace};
use feeler::trim::Side;
use feeler_corpus::{Model, QueryLine};
use feeler_gate::FeelerEngine;
use feeler_view::{EdgeKind, Fineness, MarkKind, Part, ProbeShape, View};
use nalgebra::{Point3, Vector3};
use std::collections::{HashMap, HashSet};
use std::f64::consts::PI;
use std::path::PathBuf;

fn corpora() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../corpora"))
}

fn model(name: &str) -> Model {
    Model::load(&corpora().join("models").join(name), None).unwrap()
}

fn cut(name: &str, chord: f64, degrees: f64) -> Part {
    let fineness = Fineness {
        chord,
        degrees,
        ..Fineness::default()
    };
    Part::new(name, &model(name), &fineness).unwrap()
}

fn corner(part: &Part, i: u32) -> Vector3<f64> {
    Vector3::from(part.positions[i as usize]).map(f64::from)
}

fn bits(p: &[f32; 3]) -> [u32; 3] {
    // The two zeros are one place.
    p.map(|x| (x + 0.0).to_bits())
}

/// Sides of triangles, by the bits of their ends, that no other triangle runs the other way.
fn open_sides(part: &Part) -> usize {
    let mut uses: HashMap<([u32; 3], [u32; 3]), i32> = HashMap::new();
    for t in &part.triangles {
        for k in 0..3 {
            let [a, b] = [t[k], t[(k + 1) % 3]].map(|i| bits(&part.positions[i as usize]));
            let (key, way) = if a < b { ((a, b), 1) } else { ((b, a), -1) };
            *uses.entry(key).or_default() += way;
        }
    }
    uses.values().map(|n| n.unsigned_abs() as usize).sum()
}

fn area_and_volume(part: &Part) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for t in &part.triangles {
        let [a, b, c] = t.map(|i| corner(part, i));
        sums[0] += (b - a).cross(&(c - a)).norm() / 2.0;
        sums[1] += a.dot(&b.cross(&c)) / 6.0;
    }
    sums
}

#[test]
fn what_is_drawn_of_closed_parts_is_closed_bit_for_bit() {
    let mut parts = 0;
    for folder in ["thesis", "analytic", "parts"] {
        for entry in std::fs::read_dir(corpora().join("models").join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let model = Model::load(&path, None).unwrap();
            if !model.breps.iter().all(|b| b.is_closed()) {
                continue;
            }
            let fineness = Fineness {
                chord: 4e-3,
                ..Fineness::default()
            };
            let part = Part::new("", &model, &fineness).unwrap();
            let name = path.display();
            assert_eq!(open_sides(&part), 0, "{name}");
            let [area, volume] = area_and_volume(&part);
            assert!(area > 0.0 && volume > 0.0, "{name}: {area} {volume}");
            // No crack at an edge: its points are corners of triangles.
            let corners: HashSet<_> = part.positions.iter().map(bits).collect();
            for edge in &part.edges {
                assert_ne!(edge.kind, EdgeKind::Border, "{name}");
                for p in &edge.points {
                    assert!(corners.contains(&bits(p)), "{name} {p:?}");
                }
            }
            parts += 1;
        }
    }
    assert!(parts > 50, "{parts}");
}

#[test]
fn area_and_volume_go_to_the_closed_forms_with_the_chord() {
    // A ball of radius 2; a torus of radii 4 and 1; a cube of side 10 with a hole of radius 2.5.
    let sphere = [16.0 * PI, 32.0 * PI / 3.0];
    let hole = 2.5f64;
    let socket = [
        600.0 + 4.0 * PI * hole * hole,
        1000.0 - 4.0 / 3.0 * PI * hole.powi(3),
    ];
    for (name, [area, volume]) in [
        ("analytic/sphere.json.gz", sphere),
        ("analytic/sphere_nurbs.json.gz", sphere),
        ("analytic/torus.json.gz", torus()),
        ("analytic/torus_nurbs.json.gz", torus()),
        ("thesis/ball_joint_cavity.3dm", socket),
        ("thesis/ball_joint_cavity_nurbs.3dm", socket),
    ] {
        let mut before: Option<[f64; 2]> = None;
        for chord in [8e-3, 2e-3, 5e-4] {
            let part = cut(name, chord, 90.0);
            let [a, v] = area_and_volume(&part);
            let lost = [(area - a).abs() / area, (volume - v).abs() / volume];
            // Off by the chord on all of the surface at most.
            let most = 2.0 * chord * part.size * area / volume;
            assert!(lost[1] <= most, "{name} {chord}: {v}, not {volume}");
            if let Some(before) = before {
                for k in 0..2 {
                    let gain = before[k] / lost[k];
                    assert!((2.5..6.5).contains(&gain), "{name} {chord} {k}: {gain}");
                }
            }
            before = Some(lost);
        }
    }
}

/// Area 4 pi^2 R r and volume 2 pi^2 R r^2.
fn torus() -> [f64; 2] {
    [16.0 * PI * PI, 8.0 * PI * PI]
}

#[test]
fn triangles_stay_within_the_chord_and_turn_outward() {
    let options = Options {
        contacts: Contacts::None,
        ..Options::default()
    };
    for name in [
        "analytic/torus.json.gz",
        "thesis/ball_joint_cavity_nurbs.3dm",
        "thesis/cylinder.3dm",
        "thesis/geneva4_wheel.3dm",
        "parts/vase_nurbs.json.gz",
        "parts/spline_plate.json.gz",
        "parts/flange.json.gz",
    ] {
        let model = model(name);
        let part = cut(name, 2e-3, 30.0);
        assert!(part.chord_found <= part.chord, "{name}");
        let prepared = PreparedBrep::new(model.breps[0].clone());
        let mut work = Workspace::default();
        let center = Vector3::from(part.center);
        let step = (part.triangles.len() / 300).max(1);
        let (mut off, mut turned) = (0.0f64, 0);
        for t in part.triangles.iter().step_by(step) {
            let corners = t.map(|i| corner(&part, i) + center);
            let mut distance = |p: Vector3<f64>| {
                let ball = Sphere::new(Point3::from(p), 0.0).unwrap();
                let found = query::contact(&prepared, &Probe::Sphere(ball), &options, &mut work);
                found.separation.value.abs()
            };
            for c in corners {
                // Rounded to f32 once, about the centre.
                assert!(distance(c) <= 2e-7 * part.size, "{name} {c}");
            }
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let halves = [0, 1, 2].map(|k| (corners[k] + corners[(k + 1) % 3]) / 2.0);
            for p in halves.into_iter().chain([middle]) {
                off = off.max(distance(p));
            }
            let flat = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
            let sides = [0, 1, 2].map(|k| (corners[k] - corners[(k + 1) % 3]).norm());
            // One that is no higher than the chord (next to a pole, along the seam) may lie any way.
            if flat.norm() / sides.into_iter().fold(0.0, f64::max) < 2.0 * part.chord {
                continue;
            }
            turned += 1;
            let flat = flat.normalize();
            for i in t {
                let n = Vector3::from(part.normals[*i as usize]).map(f64::from);
                assert!((n.norm() - 1.0).abs() < 1e-6);
                assert!(n.dot(&flat) > 0.8, "{name}: {n} against {flat}");
            }
            for (way, side) in [(1.0, Side::Outside), (-1.0, Side::Inside)] {
                let p = middle + flat * (way * 2.5 * part.chord);
                let found = query::inside(&prepared, Point3::from(p), &mut work);
                assert_eq!(found.side, Some(side), "{name} {p}");
            }
        }
        assert!(off <= part.chord, "{name}: {off} of {}", part.chord);
        assert!(turned > 50, "{name}: {turned}");
    }
}

/// An open sheet has borders, and holes where its inner loops are.
#[test]
fn holes_are_holes() {
    let part = cut("thesis/sheet_trimmed.3dm", 1e-3, 20.0);
    assert!(part.edges.iter().all(|e| e.kind == EdgeKind::Border));
    assert_eq!(part.edges.len(), 8);
    // Each side of a triangle that no other has is part of an edge.
    let sides: usize = part.edges.iter().map(|e| e.points.len() - 1).sum();
    assert_eq!(open_sides(&part), sides);
    // V - E + F of a disc with two holes.
    let corners: HashSet<_> = part.positions.iter().map(bits).collect();
    let mut edges = HashSet::new();
    for t in &part.triangles {
        for k in 0..3 {
            let [a, b] = [t[k], t[(k + 1) % 3]].map(|i| bits(&part.positions[i as usize]));
            edges.insert((a.min(b), a.max(b)));
        }
    }
    let euler = corners.len() as i64 - edges.len() as i64 + part.triangles.len() as i64;
    assert_eq!(euler, -1);
}

#[test]
fn many_triangles_are_cut_more_coarsely_and_said() {
    let model = model("analytic/sphere.json.gz");
    let fineness = Fineness {
        chord: 1e-6,
        degrees: 0.1,
        most: 5000,
    };
    let part = Part::new("", &model, &fineness).unwrap();
    assert!(part.triangles.len() <= 5000);
    assert!(part.chord > 1e-6 * part.size && part.notes.len() == 1);
    assert!(part.chord_found <= part.chord);
    let none = Fineness {
        most: 3,
        ..fineness
    };
    assert!(Part::new("", &model, &none).is_err());
    for chord in [f64::NAN, 0.0, 1e-300] {
        let bad = Fineness { chord, ..fineness };
        assert!(Part::new("", &model, &bad).is_err());
    }
    let degrees = 1e-300;
    let bad = Fineness {
        degrees,
        ..fineness
    };
    assert!(Part::new("", &model, &bad).is_err());
}

/// Lines with a direction whose square is zero are drawn; what is beyond f32 is not, and numbers stay numbers.
#[test]
fn far_and_tiny_probes_leave_a_sound_file() {
    let model = model("thesis/cylinder.3dm");
    let mut view = View::new("", &model, &Fineness::default()).unwrap();
    let lines = [
        r#"{"line":{"origin":[-30,1.5,2.25],"direction":[1e-200,0,0]}}"#,
        r#"{"sphere":{"center":[1e39,0,0],"radius":1}}"#,
    ];
    let lines = lines
        .iter()
        .map(|text| (1, Ok(QueryLine::parse(text).unwrap())));
    assert_eq!(view.ask(&model, &mut FeelerEngine::default(), lines), Ok(0));
    assert!(
        matches!(view.queries[0].probe, Some(ProbeShape::Line(l)) if l.from[0] < -5.0 && l.to[0] > 5.0)
    );
    assert_eq!(view.queries[1].probe, None);
    let file = gltf::Gltf::from_slice(&view.glb().unwrap()).unwrap();
    let numbers = file.blob.unwrap();
    let nodes = file.document.nodes();
    for node in nodes {
        assert!(
            node.transform()
                .matrix()
                .iter()
                .flatten()
                .all(|x| x.is_finite())
        );
    }
    assert!(!numbers.is_empty());
}

fn asked() -> View {
    let name = "thesis/ball_joint_cavity.3dm";
    let model = model(name);
    let mut view = View::new("socket </script>", &model, &Fineness::default()).unwrap();
    let lines = [
        r#"{"id":"ball","sphere":{"center":[0.01,0.02,0.03],"radius":2.51}}"#,
        r#"{"half_space":{"normal":[0.0,0.0,1.0],"offset":-4.75}}"#,
        r#"{"line":{"origin":[-9,0.5,0.25],"direction":[1,0,0]},"model":"thesis/ball_joint_cavity.3dm"}"#,
        r#"{"inside":{"point":[4.9,0,0]}}"#,
        r#"{"side":{"face":6,"uv":[1.0,0.5]}}"#,
        r#"{"evaluate":{"face":6,"uv":[1.0,0.5]}}"#,
        r#"{"sphere":{"center":[0,0,0],"radius":-1}}"#,
        r#"{"model":"thesis/cylinder.3dm","inside":{"point":[0,0,0]}}"#,
    ];
    let parsed = lines.iter().enumerate().map(|(i, text)| {
        let line = QueryLine::parse(text).map_err(|e| e.to_string());
        (i + 1, line)
    });
    let refused = view.ask(&model, &mut FeelerEngine::default(), parsed);
    assert_eq!(refused, Ok(1));
    assert_eq!(view.queries.len(), 7);
    assert_eq!(view.notes.len(), 1);
    view
}

#[test]
fn marks_stand_where_the_numbers_say() {
    let view = asked();
    let center = Vector3::from(view.parts[0].center);
    let place = |p: [f32; 3]| Vector3::from(p).map(f64::from) + center;
    // The socket's centre is the origin, its radius 2.5: the ball leaves towards (1, 2, 3).
    let way = Vector3::new(1.0, 2.0, 3.0).normalize();
    let ball = &view.queries[0];
    assert_eq!((ball.label.as_str(), ball.state), ("ball", "answered"));
    let mark = &ball.marks[0];
    assert!((place(mark.at) - way * 2.5).norm() < 1e-6);
    let probe_at = Vector3::new(0.01, 0.02, 0.03) + way * 2.51;
    assert!((place(mark.to.unwrap()) - probe_at).norm() < 1e-6);
    let normal = Vector3::from(mark.normal.unwrap()).map(f64::from);
    assert!((normal + way).norm() < 1e-6);
    let Some(ProbeShape::Ball { radius, .. }) = ball.probe else {
        panic!("{:?}", ball.probe)
    };
    assert_eq!(radius, 2.51);
    let Some(ProbeShape::Plane(plane)) = view.queries[1].probe else {
        panic!()
    };
    assert!((place(plane.center).z + 4.75).abs() < 1e-6);
    // The line goes in and out of the block and of the hole.
    let hits = &view.queries[2].marks;
    assert_eq!(hits.len(), 4);
    let hole = (2.5f64 * 2.5 - 0.25 - 0.0625).sqrt();
    for (mark, x) in hits.iter().zip([-5.0, -hole, hole, 5.0]) {
        assert!((place(mark.at) - Vector3::new(x, 0.5, 0.25)).norm() < 1e-6);
    }
    assert_eq!(view.queries[3].marks[0].kind, MarkKind::Inside);
    assert_eq!(view.queries[5].marks[0].arrows.len(), 2);
    assert_eq!(view.queries[6].state, "refused");
}

#[test]
fn the_page_needs_nothing_else() {
    let page = asked().page();
    for outside in ["http:", "https:", "src=", "href=", "import ", "fetch("] {
        assert!(!page.contains(outside), "{outside}");
    }
    // The title's `</script>` ends nothing.
    assert_eq!(page.matches("</script>").count(), 2);
    let (_, data) = page
        .split_once(r#"<script type="application/json" id="data">"#)
        .unwrap();
    let (data, _) = data.split_once("</script>").unwrap();
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    assert_eq!(data["title"], "socket </script>");
    assert_eq!(data["queries"].as_array().unwrap().len(), 7);
    assert_eq!(data["parts"][0]["faces"].as_array().unwrap().len(), 7);
}

#[test]
fn others_read_the_binary_gltf() {
    let view = asked();
    let bytes = view.glb().unwrap();
    // Checks the file against the specification while it reads.
    let file = gltf::Gltf::from_slice(&bytes).unwrap();
    assert_eq!(file.scenes().count(), 8);
    let faces = file.meshes().find(|m| m.name() == Some("faces")).unwrap();
    let primitive = faces.primitives().next().unwrap();
    let reader = primitive.reader(|_| file.blob.as_deref());
    let part = &view.parts[0];
    let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
    assert_eq!(positions, part.positions);
    assert_eq!(reader.read_normals().unwrap().count(), part.positions.len());
    let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    assert_eq!(indices, part.triangles.as_flattened());
    // A part of nothing, too.
    let empty = View::default().glb().unwrap();
    assert!(gltf::Gltf::from_slice(&empty).is_ok());
    let page = View::default().page();
    assert!(page.contains("feeler"));
}

/// A face without loops is its whole domain; a closed one has no border.
#[test]
fn faces_without_loops_are_whole() {
    use feeler::brep::{Brep, BrepParts, Face};
    let closed = model("analytic/torus_nurbs.json.gz");
    let whole = |surface: feeler::nurbs::Surface| {
        let face = Face {
            surface: 0,
            loops: None,
            reversed: false,
        };
        let parts = BrepParts {
            surfaces: vec![surface],
            faces: vec![face],
            ..BrepParts::default()
        };
        let model = Model {
            path: PathBuf::new(),
            breps: vec![Brep::new(parts).unwrap()],
        };
        Part::new("", &model, &Fineness::default()).unwrap()
    };
    let part = whole(closed.breps[0].surface(0).clone());
    assert!(part.edges.iter().all(|e| e.kind == EdgeKind::Seam));
    assert_eq!(part.edges.len(), 2);
    let [area, _] = area_and_volume(&part);
    assert!((area / torus()[0] - 1.0).abs() < 1e-2);
    let sheet = model("thesis/sheet_trimmed.3dm");
    let part = whole(sheet.breps[0].surface(0).clone());
    assert_eq!(part.edges.len(), 4);
    assert!(part.edges.iter().all(|e| e.kind == EdgeKind::Border));
}

#[test]
fn a_suite_says_what_its_answers_earn() {
    let view = feeler_view::suite(&corpora(), "functionality", &Fineness::default()).unwrap();
    assert!(view.overview && view.parts.len() == 8);
    assert_eq!(view.queries.len(), 64);
    for q in &view.queries {
        assert_eq!(q.state, "right", "{}: {:?}", q.label, q.judged);
        // Each is drawn with its probe, about its own part.
        assert!(q.probe.is_some(), "{}", q.label);
        let nurbs = view.parts[q.part].name.contains("_nurbs");
        assert_eq!(nurbs, q.label.ends_with("(NURBS)"), "{}", q.label);
    }
    assert!(feeler_view::suite(&corpora(), "no such", &Fineness::default()).is_err());
}
