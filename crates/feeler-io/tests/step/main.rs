//! STEP files: against the same shape's .brep, and against what OCCT says of the shape that they were written from.

mod faces;
mod images;
mod shapes;
mod writer;

use feeler::brep::Brep;
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, Contacts, LineKind, LineProbe, Options, Probe, Sphere, Workspace, contact, inside,
    line,
};
use feeler::trim::Side;
use feeler_io::{Document, Format, Object, ObjectKind, Units, read_file};
use nalgebra::{Point3, Vector3};
use std::path::{Path, PathBuf};
use writer::Writer;

fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models")
}

fn file(name: &str) -> Document {
    read_file(models().join(name)).unwrap_or_else(|e| panic!("{e}"))
}

/// The document's BREPs; none may be refused.
fn breps(name: &str, document: &Document) -> Vec<Brep> {
    for object in &document.objects {
        if let ObjectKind::Refused { class, reason } = &object.kind {
            panic!("{name}: {class}: {reason}");
        }
    }
    document.bodies().map(|(_, b)| b.into_owned()).collect()
}

/// Knuth's multiplier (MMIX): the same numbers everywhere.
struct Random(u64);

impl Random {
    /// From 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, half: f64) -> Point3<f64> {
        Point3::from([0; 3].map(|_| half * (2.0 * self.next() - 1.0)))
    }
}

fn largest(brep: &Brep) -> f64 {
    let vertices = brep.parts().vertices.iter();
    vertices.map(|v| v.point.coords.amax()).fold(0.0, f64::max)
}

fn options(accuracy: f64) -> Options {
    Options {
        accuracy: Accuracy::Length(accuracy),
        contacts: Contacts::None,
        ..Options::default()
    }
}

/// The thesis's parts that the project has as STEP.
const PARTS: [&str; 6] = [
    "ball_joint_socket",
    "cube_corner_cut",
    "cylinder",
    "geneva4_wheel",
    "sheet_trimmed",
    "shift_gate",
];

/// OCCT prints 12 decimals into STEP files: half a unit of a direction's, times the size, for each of a face's two directions and its
/// edges'.
const PRINTED: f64 = 2e-12;

#[test]
fn a_step_file_answers_as_its_brep() {
    for part in PARTS {
        let document = file(&format!("thesis/{part}.step"));
        assert_eq!((document.format, document.version), (Format::Step, 214));
        assert_eq!(document.units, Units::Millimetres);
        let ours = breps(part, &document);
        let theirs = breps(part, &file(&format!("thesis/{part}.brep")));
        assert_eq!((ours.len(), theirs.len()), (1, 1), "{part}");
        assert_eq!(ours[0].faces().len(), theirs[0].faces().len());
        assert_eq!(ours[0].is_closed(), theirs[0].is_closed(), "{part}");
        let size = largest(&theirs[0]);
        let slack = PRINTED * size;
        let both = [&ours[0], &theirs[0]].map(|b| PreparedBrep::new(b.clone()));
        let mut w = Workspace::default();
        let mut r = Random(1);
        let options = options(0.01 * slack);
        let mut decided = 0;
        for _ in 0..200 {
            let p = r.within(1.3 * size);
            let ball = Probe::Sphere(Sphere::new(p, 0.0).unwrap());
            let [a, b] = both
                .each_ref()
                .map(|brep| contact(brep, &ball, &options, &mut w).separation.bounds);
            assert!(
                a.lo <= b.hi + slack && b.lo <= a.hi + slack,
                "{part} at {p}: {a:?} and {b:?}"
            );
            let [x, y] = both.each_ref().map(|brep| inside(brep, p, &mut w).side);
            assert!(x == y || x.is_none() || y.is_none(), "{part} at {p}");
            let to = r.within(1.3 * size);
            let probe = LineProbe::new(p, to - p, LineKind::Line).unwrap();
            let [x, y] = both
                .each_ref()
                .map(|brep| line(brep, &probe, &options, &mut w));
            if x.undecided.is_some() || y.undecided.is_some() {
                continue;
            }
            decided += 1;
            assert_eq!(x.hits.len(), y.hits.len(), "{part} at {p}");
            for (h, k) in x.hits.iter().zip(&y.hits) {
                // Farther where the line is flat to the face.
                let sine = h.normal.dot(&probe.direction.normalize()).abs();
                assert!(
                    (h.point - k.point).norm() * sine <= 4.0 * slack,
                    "{part} at {p}"
                );
            }
        }
        assert!(decided >= 190, "{part}: {decided} lines decided");
    }
}

/// OCCT's own accuracy: it stops where a step is 1e-7, and edges that it intersected are within 1e-7 of their faces.
const OCCT: f64 = 4e-7;

#[test]
fn distances_and_sides_are_those_that_occt_says_of_the_shape() {
    let mut folder: Vec<PathBuf> = std::fs::read_dir(models().join("step"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "step"))
        .collect();
    folder.sort();
    folder.retain(|p| p.file_stem().unwrap() != REFUSED);
    assert!(folder.len() >= 60, "{} files", folder.len());
    let wrong: Vec<String> = folder.iter().filter_map(|p| of_occt(p).err()).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Its bores are closed B-splines, whose holes lie across the line where they start.
const REFUSED: &str = "bored_nurbs_seamless";

#[test]
fn what_is_not_supported_is_refused_by_its_number() {
    let document = file(&format!("step/{REFUSED}.step"));
    let [body, face] = &document.objects[..] else {
        panic!("{} objects", document.objects.len());
    };
    // The body lacks that face.
    let ObjectKind::Brep(body) = &body.kind else {
        panic!("{}", body.kind.name());
    };
    assert!(!body.is_closed());
    let ObjectKind::Refused { class, reason } = &face.kind else {
        panic!("{}", face.kind.name());
    };
    assert!(
        class.starts_with("face #") && class.ends_with(" of manifold_solid_brep"),
        "{class}"
    );
    let why = reason.to_string();
    assert!(
        why.starts_with('#') && why.contains("split closed faces at seams"),
        "{why}"
    );
}

/// One file; says what is wrong.
fn of_occt(path: &Path) -> Result<(), String> {
    let stem = path.file_stem().unwrap().to_str().unwrap();
    let base = ["_bare", "_inch_203", "_242", "_seamless"]
        .iter()
        .fold(stem, |s, end| s.strip_suffix(end).unwrap_or(s));
    let facts = std::fs::read_to_string(models().join(format!("step/{base}.json"))).unwrap();
    let facts: serde_json::Value = serde_json::from_str(&facts).unwrap();
    let mut document = read_file(path).map_err(|e| e.to_string())?;
    if stem.contains("inch") {
        assert_eq!(
            (document.units.clone(), document.version),
            (Units::Inches, 203)
        );
        document.convert_units(Units::Millimetres).unwrap();
    }
    assert_eq!(document.units, Units::Millimetres, "{stem}");
    for object in &document.objects {
        match &object.kind {
            ObjectKind::Refused { reason, .. } => return Err(format!("{stem}: {reason}")),
            ObjectKind::Brep(b) if !b.is_closed() => {
                return Err(format!("{stem}: open; {:?}", object.warnings));
            }
            _ => {}
        }
    }
    let bodies = document.bodies().map(|(_, b)| b.into_owned());
    let prepared: Vec<PreparedBrep> = bodies.map(PreparedBrep::new).collect();
    assert_eq!(prepared.len() as u64, facts["solids"], "{stem}");
    let mut w = Workspace::default();
    let options = options(1e-9);
    for fact in facts["points"].as_array().unwrap() {
        let at = |k: usize| fact["point"][k].as_f64().unwrap();
        let p = Point3::new(at(0), at(1), at(2));
        let ball = Probe::Sphere(Sphere::new(p, 0.0).unwrap());
        let mut least = f64::INFINITY;
        let mut is_inside = false;
        for b in &prepared {
            let answer = contact(b, &ball, &options, &mut w);
            if answer.undecided.is_some() {
                return Err(format!("{stem} at {p}: {answer:?}"));
            }
            least = least.min(answer.separation.value.abs());
            let side = inside(b, p, &mut w).side;
            if side.is_none() {
                return Err(format!("{stem} at {p}: the side is undecided"));
            }
            is_inside |= side == Some(Side::Inside);
        }
        let theirs = fact["distance"].as_f64().unwrap();
        if !((least - theirs).abs() <= OCCT) || fact["inside"].as_bool() != Some(is_inside) {
            let said = (theirs, fact["inside"].as_bool());
            return Err(format!(
                "{stem} at {p}: {least}, {is_inside}; OCCT {said:?}"
            ));
        }
    }
    Ok(())
}

/// Faces that turn their sides: the normals of hits point out of the material.
#[test]
fn normals_point_out_of_the_material() {
    for name in ["bored_bare", "filleted", "ball_and_cone", "revolution"] {
        let document = file(&format!("step/{name}.step"));
        let brep = breps(name, &document).remove(0);
        let size = largest(&brep);
        let prepared = PreparedBrep::new(brep);
        let mut w = Workspace::default();
        let mut r = Random(7);
        let mut hits = 0;
        for _ in 0..200 {
            let (p, q) = (r.within(2.0 * size), r.within(size));
            let probe = LineProbe::new(p, q - p, LineKind::Line).unwrap();
            for hit in line(&prepared, &probe, &options(1e-9 * size), &mut w).hits {
                let step: Vector3<f64> = hit.normal * (1e-3 * size);
                let [out, into] =
                    [hit.point + step, hit.point - step].map(|p| inside(&prepared, p, &mut w).side);
                if out != into {
                    assert_eq!(out, Some(Side::Outside), "{name} at {}", hit.point);
                    hits += 1;
                }
            }
        }
        assert!(hits > 20, "{name}: {hits}");
    }
}

/// How far a point is from the one body of a document.
fn distance(document: &Document, p: [f64; 3]) -> f64 {
    let all = breps("it", document);
    assert_eq!(all.len(), 1);
    let prepared = PreparedBrep::new(all[0].clone());
    let ball = Probe::Sphere(Sphere::new(Point3::from(p), 0.0).unwrap());
    let answer = contact(&prepared, &ball, &options(1e-9), &mut Workspace::default());
    assert!(answer.undecided.is_none(), "{answer:?}");
    answer.separation.value.abs()
}

/// Why the one body is refused.
fn refusal(document: &Document) -> String {
    let [object] = &document.objects[..] else {
        panic!("{} objects", document.objects.len());
    };
    match &object.kind {
        ObjectKind::Refused { reason, .. } => reason.to_string(),
        other => panic!("{}", other.name()),
    }
}

#[track_caller]
fn near(found: f64, expected: f64, slack: f64) {
    assert!((found - expected).abs() <= slack, "{found}, not {expected}");
}

const X: [f64; 3] = [1., 0., 0.];
const Y: [f64; 3] = [0., 1., 0.];
const Z: [f64; 3] = [0., 0., 1.];

/// Both coordinates of a torus come back: two rims without a seam bound what is on their left, not the rest.
#[test]
fn two_rims_on_a_torus_bound_what_is_on_their_left() {
    for (around, order) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let mut w = Writer::default();
        let axes = w.axes([0.; 3], Z, X);
        let torus = w.put(format!("TOROIDAL_SURFACE('',{axes},5.,1.5)"));
        let mut rims = if around == 0 {
            // The inner half, from the top of the tube to its bottom.
            let top = w.round([0., 0., 1.5], Z, X, 5.);
            let bottom = w.round([0., 0., -1.5], Z, X, 5.);
            [w.bound(&[(&top, true)]), w.bound(&[(&bottom, false)])]
        } else {
            // The half of negative x.
            let first = w.round([0., 5., 0.], X, Y, 1.5);
            let last = w.round([0., -5., 0.], [-1., 0., 0.], [0., -1., 0.], 1.5);
            [w.bound(&[(&first, false)]), w.bound(&[(&last, true)])]
        };
        rims.rotate_left(order);
        let face = w.face(&torus, &rims);
        w.sheet(&[face]);
        let document = w.document();
        let (on, away, to_rim) = if around == 0 {
            ([3.5, 0., 0.], [0., 6.5, 0.], 1.5_f64.hypot(1.5))
        } else {
            ([-6.5, 0., 0.], [6.5, 0., 0.], 6.5_f64.hypot(3.5))
        };
        near(distance(&document, on), 0.0, 1e-8);
        near(distance(&document, away), to_rim, 1e-8);
    }
}

/// The seam that closes a cap avoids its holes.
#[test]
fn a_cap_keeps_the_hole_that_lies_where_its_rim_starts() {
    let mut w = Writer::default();
    let axes = w.axes([0.; 3], Z, X);
    let sphere = w.put(format!("SPHERICAL_SURFACE('',{axes},3.)"));
    let rim = w.round([0.; 3], Z, X, 3.);
    let (c, d) = (0.5_f64.sqrt(), 2.9_f64);
    let r = (9.0 - d * d).sqrt();
    let hole = w.round([d * c, 0., d * c], [c, 0., c], Y, r);
    let bounds = [w.bound(&[(&rim, true)]), w.bound(&[(&hole, false)])];
    let face = w.face(&sphere, &bounds);
    w.sheet(&[face]);
    let document = w.document();
    // In the hole, at either side of its middle: as far as its circle is.
    for side in [-0.1_f64, 0.0, 0.1] {
        let (sin, cos) = side.sin_cos();
        let to = ((3.0 * cos - d).powi(2) + (r - 3.0 * sin.abs()).powi(2)).sqrt();
        let found = distance(&document, [3.0 * cos * c, 3.0 * sin, 3.0 * cos * c]);
        near(found, to, 1e-6);
    }
    near(distance(&document, [-3. * c, 0., 3. * c]), 0.0, 1e-6);
}

/// A half ball whose border is one circle through both poles.
#[test]
fn an_edge_through_poles_is_split_there() {
    let mut w = Writer::default();
    let axes = w.axes([0.; 3], Z, X);
    let sphere = w.put(format!("SPHERICAL_SURFACE('',{axes},3.)"));
    // Not at any sample.
    let (sin, cos) = 0.3_f64.sin_cos();
    let border = w.round([0.; 3], X, [0., cos, sin], 3.);
    let bound = w.bound(&[(&border, true)]);
    let half = w.face(&sphere, &[bound]);
    let axes = w.axes([0.; 3], [-1., 0., 0.], Y);
    let plane = w.put(format!("PLANE('',{axes})"));
    let bound = w.bound(&[(&border, false)]);
    let disc = w.face(&plane, &[bound]);
    let shell = w.put(format!("CLOSED_SHELL('',({half},{disc}))"));
    w.put(format!("MANIFOLD_SOLID_BREP('',{shell})"));
    let document = w.document();
    near(distance(&document, [4., 0., 0.]), 1.0, 1e-8);
    near(distance(&document, [-1., 1., 0.]), 1.0, 1e-8);
    near(distance(&document, [-4., 0., 3.]), 4.0, 1e-8);
    near(
        distance(&document, [1., 2., 1.]),
        3.0 - 6.0_f64.sqrt(),
        1e-8,
    );
    // The round face alone, close to a pole at either side of its border.
    w.text = w.text.replace("MANIFOLD_SOLID_BREP", "SKETCH");
    w.sheet(&[half]);
    let alone = w.document();
    for by in [-0.04_f64, -0.02, 0.0, 0.02, 0.04] {
        for out in [-0.004_f64, 0.004] {
            let (y, x) = (by.sin(), out.sin());
            let z = (1.0 - x * x - y * y).sqrt();
            let to = if out > 0.0 {
                0.0
            } else {
                // The circle's nearest point is straight above, but for its bend.
                (3.0 * x).hypot(3.0 - 3.0 * y.hypot(z))
            };
            near(distance(&alone, [3.0 * x, 3.0 * y, 3.0 * z]), to, 1e-8);
        }
    }
    let brep = breps("it", &document).remove(0);
    assert!(brep.is_closed());
    let prepared = PreparedBrep::new(brep);
    let mut work = Workspace::default();
    for (x, side) in [(1.0, Side::Inside), (-1.0, Side::Outside)] {
        let found = inside(&prepared, Point3::new(x, 0.5, 0.25), &mut work).side;
        assert_eq!(found, Some(side));
    }
}

/// A cylinder's piece over `[-0.5, 2]` along z, its profile a circle of radius 2 that is passed at its start.
fn wall(w: &mut Writer, profile: &str, direction: &str, off: f64) {
    let surface = w.put(format!(
        "SURFACE_OF_LINEAR_EXTRUSION('',{profile},{direction})"
    ));
    let s = 2.0 * 0.5_f64.sqrt();
    let corner = |y: f64, z: f64| [s + off, y, z];
    let [a, b, c, d] =
        [(-s, -0.5), (s, -0.5), (s, 2.0), (-s, 2.0)].map(|(y, z)| w.vertex(corner(y, z)));
    let low = w.circle([off, 0., -0.5], Z, X, 2.);
    let high = w.circle([off, 0., 2.0], Z, X, 2.);
    let up = |w: &mut Writer, y: f64| {
        let (p, z) = (w.point(corner(y, 0.0)), w.direction(Z));
        let v = w.put(format!("VECTOR('',{z},1.)"));
        w.put(format!("LINE('',{p},{v})"))
    };
    let (right, left) = (up(w, s), up(w, -s));
    let (low, high) = (w.edge(&a, &b, &low), w.edge(&d, &c, &high));
    let (right, left) = (w.edge(&b, &c, &right), w.edge(&a, &d, &left));
    let bound = w.bound(&[(&low, true), (&right, true), (&high, false), (&left, false)]);
    let face = w.face(&surface, &[bound]);
    w.sheet(&[face]);
}

#[test]
fn extrusions_go_past_the_start_of_their_profile() {
    // Where in the arc the profile starts.
    for start in [-0.5_f64, 0.0, 0.35] {
        let mut w = Writer::default();
        let circle = w.circle([0.; 3], Z, [start.cos(), start.sin(), 0.], 2.);
        let z = w.direction(Z);
        let along = w.put(format!("VECTOR('',{z},1.)"));
        wall(&mut w, &circle, &along, 0.0);
        let document = w.document();
        let prepared = PreparedBrep::new(breps("it", &document).remove(0));
        for edge in 0..prepared.brep().parts().edges.len() {
            for own in prepared.edge_offsets(edge) {
                assert!(own.at_most <= 1e-8, "{edge}: {own:?}");
            }
        }
        near(distance(&document, [2.0, 0., 1.]), 0.0, 1e-8);
        for angle in [-0.7_f64, -0.3, 0.3, 0.7] {
            let (sin, cos) = angle.sin_cos();
            near(distance(&document, [2.0 * cos, 2.0 * sin, 1.]), 0.0, 1e-8);
        }
        near(distance(&document, [3.0, 0., 1.]), 1.0, 1e-8);
        near(distance(&document, [2.0, 0., -1.5]), 1.0, 1e-8);
        let s = 2.0_f64.sqrt();
        near(
            distance(&document, [-2.0, 0., 1.]),
            (2.0 + s).hypot(s),
            1e-8,
        );
    }
}

#[test]
fn edges_that_are_not_on_their_faces_are_refused() {
    let mut w = Writer::default();
    let circle = w.circle([0.; 3], Z, X, 2.);
    let z = w.direction(Z);
    let along = w.put(format!("VECTOR('',{z},1.)"));
    wall(&mut w, &circle, &along, 0.25);
    let why = refusal(&w.document());
    assert!(why.contains("from the surface of a face"), "{why}");
}

#[test]
fn profiles_against_their_basis_are_refused() {
    for sense in ["T", "F"] {
        let mut w = Writer::default();
        let circle = w.circle([0.; 3], Z, X, 2.);
        let trimmed = w.put(format!(
            "TRIMMED_CURVE('',{circle},(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(3.)),.{sense}.,.PARAMETER.)"
        ));
        let z = w.direction(Z);
        let along = w.put(format!("VECTOR('',{z},1.)"));
        wall(&mut w, &trimmed, &along, 0.0);
        let document = w.document();
        if sense == "T" {
            near(distance(&document, [3.0, 0., 1.]), 1.0, 1e-8);
        } else {
            assert!(refusal(&document).contains("against its basis"));
        }
    }
    for (u, v) in [("T", "T"), ("F", "F"), ("T", "F"), ("F", "T")] {
        let mut w = Writer::default();
        let axes = w.axes([0.; 3], Z, X);
        let plane = w.put(format!("PLANE('',{axes})"));
        let part = w.put(format!(
            "RECTANGULAR_TRIMMED_SURFACE('',{plane},-5.,5.,-5.,5.,.{u}.,.{v}.)"
        ));
        let rim = w.round([0.; 3], Z, X, 2.);
        let bound = w.bound(&[(&rim, true)]);
        let face = w.face(&part, &[bound]);
        w.sheet(&[face]);
        let document = w.document();
        if u == v {
            near(distance(&document, [0., 0., 1.]), 1.0, 1e-9);
        } else {
            assert!(refusal(&document).contains("turns its basis over"));
        }
    }
}

/// A profile that is a line counts in its vector's length.
#[test]
fn a_profile_with_a_short_vector_reaches_as_far() {
    let mut w = Writer::default();
    let (p, x) = (w.point([0.; 3]), w.direction(X));
    let v = w.put(format!("VECTOR('',{x},1.E-3)"));
    let line = w.put(format!("LINE('',{p},{v})"));
    let y = w.direction(Y);
    let along = w.put(format!("VECTOR('',{y},1.)"));
    let surface = w.put(format!("SURFACE_OF_LINEAR_EXTRUSION('',{line},{along})"));
    let rim = w.round([0.; 3], Z, X, 2.);
    let bound = w.bound(&[(&rim, true)]);
    let face = w.face(&surface, &[bound]);
    w.sheet(&[face]);
    let document = w.document();
    near(distance(&document, [0., 0., 1.]), 1.0, 1e-6);
    near(distance(&document, [3., 0., 0.]), 1.0, 1e-6);
}

/// An assembly: the relation of a part to it, plain or with a placement, in the units of each.
#[test]
fn parts_of_assemblies_are_placed_in_their_own_units() {
    for plain in [false, true] {
        let mut w = Writer::default();
        let (mm, inch) = (w.millimetres(), w.inches());
        let (mm, inch) = (w.context(&mm, ""), w.context(&inch, ""));
        let ball = w.ball([0.; 3], 1.0);
        let from = w.axes([1., 0., 0.], Z, X);
        let to = w.axes([0., 0., 254.], Z, X);
        let part = w.representation(&format!("{from},{ball}"), &inch);
        let whole = w.representation(&to, &mm);
        let relation = if plain {
            w.put(format!(
                "SHAPE_REPRESENTATION_RELATIONSHIP('','',{part},{whole})"
            ))
        } else {
            let t = w.put(format!("ITEM_DEFINED_TRANSFORMATION('','',{from},{to})"));
            w.put(format!(
                "(REPRESENTATION_RELATIONSHIP('','',{part},{whole})\
                 REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({t})SHAPE_REPRESENTATION_RELATIONSHIP())"
            ))
        };
        let shape = w.put("PRODUCT_DEFINITION_SHAPE('','',$)");
        w.put(format!(
            "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({relation},{shape})"
        ));
        let document = w.document();
        assert_eq!(document.units, Units::Inches);
        // One inch to the left of where 254 mm are, which is at 10 inches.
        let centre = if plain { [0.; 3] } else { [-1., 0., 10.] };
        let p = [centre[0], centre[1] + 3.0, centre[2]];
        near(distance(&document, p), 2.0, 1e-9);
        near(distance(&document, [p[0], -2.0, p[2]]), 1.0, 1e-9);
    }
}

#[test]
fn assemblies_that_are_part_of_themselves_are_refused() {
    let mut w = Writer::default();
    let mm = w.millimetres();
    let mm = w.context(&mm, "");
    let ball = w.ball([0.; 3], 1.0);
    let from = w.axes([0.; 3], Z, X);
    let to = w.axes([0., 0., 5.], Z, X);
    let a = w.representation(&ball, &mm);
    let b = w.representation(&to, &mm);
    let t = w.put(format!("ITEM_DEFINED_TRANSFORMATION('','',{from},{to})"));
    let shape = w.put("PRODUCT_DEFINITION_SHAPE('','',$)");
    for (child, parent) in [(&a, &b), (&b, &a)] {
        let relation = w.put(format!(
            "(REPRESENTATION_RELATIONSHIP('','',{child},{parent})\
             REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({t})SHAPE_REPRESENTATION_RELATIONSHIP())"
        ));
        w.put(format!(
            "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({relation},{shape})"
        ));
    }
    let why = w.read().unwrap_err().to_string();
    assert!(
        why.starts_with('#') && why.contains("part of itself"),
        "{why}"
    );
}

#[test]
fn units_and_tolerances_are_those_of_lengths() {
    let mut w = Writer::default();
    let unit = w.inches();
    let angle = w.put("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
    let length = w.put(format!(
        "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-5),{unit},'','')"
    ));
    let other = w.put(format!(
        "UNCERTAINTY_MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE(0.5),{angle},'','')"
    ));
    let context = w.context(&format!("{unit},{angle}"), &format!("{length},$,{other}"));
    let ball = w.ball([0.; 3], 1.0);
    w.representation(&ball, &context);
    let document = w.document();
    assert_eq!(document.units, Units::Inches);
    assert_eq!(document.tolerance, Some(1e-5));
}

/// The half angle of a cone is in the file's unit of angle.
#[test]
fn angles_may_be_in_degrees() {
    let mut w = Writer::default();
    let mm = w.millimetres();
    let radian = w.put("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
    let degree = w.put(format!(
        "PLANE_ANGLE_MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE(0.017453292519943295),{radian})"
    ));
    let degree = w.put(format!(
        "(CONVERSION_BASED_UNIT('DEGREE',{degree})NAMED_UNIT($)PLANE_ANGLE_UNIT())"
    ));
    let context = w.context(&format!("{mm},{degree}"), "");
    let axes = w.axes([0.; 3], Z, X);
    let cone = w.put(format!("CONICAL_SURFACE('',{axes},1.,30.)"));
    let slope = 1.0 / 3.0_f64.sqrt();
    let low = w.round([0.; 3], Z, X, 1.);
    let high = w.round([0., 0., 3.], Z, X, 1. + 3. * slope);
    let bounds = [w.bound(&[(&low, true)]), w.bound(&[(&high, false)])];
    let face = w.face(&cone, &bounds);
    let sheet = w.sheet(&[face]);
    w.representation(&sheet, &context);
    let document = w.document();
    let on = |z: f64| 1. + z * slope;
    near(distance(&document, [0., on(2.), 2.]), 0.0, 1e-8);
    // From the axis, along the normal: the cosine of 30 degrees of the radius there.
    let foot = 3.0_f64.sqrt() / 2.0;
    near(distance(&document, [0., 0., 2.]), on(2.) * foot, 1e-8);
}

/// Tubes without seams whose rims start at other angles, more of them than a body may be begun again for splits.
#[test]
fn many_rims_may_start_where_they_like() {
    let mut w = Writer::default();
    let mut faces = Vec::new();
    for i in 0..300 {
        let at = |z: f64| [3. * f64::from(i), 0., z];
        let axes = w.axes(at(0.), Z, X);
        let tube = w.put(format!("CYLINDRICAL_SURFACE('',{axes},1.)"));
        let (sin, cos) = (0.1 + 0.02 * f64::from(i)).sin_cos();
        let (low, high) = (
            w.round(at(0.), Z, X, 1.),
            w.round(at(2.), Z, [cos, sin, 0.], 1.),
        );
        let bounds = [w.bound(&[(&low, true)]), w.bound(&[(&high, false)])];
        faces.push(w.face(&tube, &bounds));
    }
    w.sheet(&faces);
    let document = w.document();
    for x in [0.0, 3.0 * 299.0] {
        near(distance(&document, [x, 0.25, 1.]), 0.75, 1e-8);
    }
}

/// The size is that of the body: a point of nothing, far off, changes nothing; coordinates may be written as integers.
#[test]
fn the_size_is_that_of_what_bodies_are_made_of() {
    let mut w = Writer::default();
    let circle = w.circle([0.; 3], Z, X, 2.);
    let z = w.direction(Z);
    let along = w.put(format!("VECTOR('',{z},1.)"));
    w.point([0., 0., 1e15]);
    wall(&mut w, &circle, &along, 0.25);
    let why = refusal(&w.document());
    assert!(why.contains("from the surface of a face"), "{why}");
}

#[test]
fn few_bytes_do_not_unfold_to_much() {
    // Shells that list each other.
    let mut w = Writer::default();
    for k in 0..8 {
        let next = vec![format!("#{}", k + 2); 100].join(",");
        w.put(format!("OPEN_SHELL('',({next}))"));
    }
    w.put("OPEN_SHELL('',())");
    w.put("SHELL_BASED_SURFACE_MODEL('',(#2))");
    let why = refusal(&w.document());
    assert!(why.contains("numbers"), "{why}");
    // A long name, and more bodies than may be.
    let mut w = Writer::default();
    let mm = w.millimetres();
    let mm = w.context(&mm, "");
    let ball = w.ball([0.; 3], 1.0);
    let long = w.text.replace(
        "SOLID_BREP(''",
        &format!("SOLID_BREP('{}'", "n".repeat(1 << 16)),
    );
    w.text = long;
    w.representation(&ball, &mm);
    assert_eq!(w.document().objects[0].name.len(), 256);
    // (Listed again in one representation, which is a set, it would be there once.)
    for _ in 0..100_001 {
        w.representation(&ball, &mm);
    }
    let document = w.document();
    let refused = document.objects.iter().filter_map(|o| match &o.kind {
        ObjectKind::Refused { reason, .. } => Some(reason.to_string()),
        _ => None,
    });
    let refused: Vec<String> = refused.collect();
    let placed = document.bodies().count();
    assert!(placed > 10_000 && placed + refused.len() == 100_002);
    assert!(refused.iter().all(|why| why.contains("placed parts")));
}

/// A torus as a B-spline, closed both ways, bounded by its two seams: wherever the loop starts.
#[test]
fn a_face_bounded_by_seams_alone_is_where_its_surface_is() {
    // Nine points of the square about a circle, and their weights.
    let h = 0.5_f64.sqrt();
    let square = [
        (1, 0),
        (1, 1),
        (0, 1),
        (-1, 1),
        (-1, 0),
        (-1, -1),
        (0, -1),
        (1, -1),
        (1, 0),
    ];
    let square = square.map(|(x, y)| (f64::from(x), f64::from(y)));
    let weight = |i: usize| if i % 2 == 1 { h } else { 1.0 };
    for first in 0..4 {
        let mut w = Writer::default();
        let (mut net, mut weights) = (Vec::new(), Vec::new());
        for (i, (cu, su)) in square.iter().enumerate() {
            let mut row = Vec::new();
            let mut row_weights = Vec::new();
            for (j, (cv, sv)) in square.iter().enumerate() {
                let r = 5.0 + 1.5 * cv;
                row.push(w.point([r * cu, r * su, 1.5 * sv]));
                row_weights.push(format!("{:?}", weight(i) * weight(j)));
            }
            net.push(format!("({})", row.join(",")));
            weights.push(format!("({})", row_weights.join(",")));
        }
        let knots = "(3,2,2,2,3),(3,2,2,2,3),(0.,1.,2.,3.,4.),(0.,1.,2.,3.,4.),.UNSPECIFIED.";
        let surface = w.put(format!(
            "(BOUNDED_SURFACE()B_SPLINE_SURFACE(2,2,({}),.UNSPECIFIED.,.T.,.T.,.F.)\
             B_SPLINE_SURFACE_WITH_KNOTS({knots})GEOMETRIC_REPRESENTATION_ITEM()\
             RATIONAL_B_SPLINE_SURFACE(({}))REPRESENTATION_ITEM('')SURFACE())",
            net.join(","),
            weights.join(",")
        ));
        let v = w.vertex([6.5, 0., 0.]);
        let around = w.circle([0.; 3], Z, X, 6.5);
        let around = w.edge(&v, &v, &around);
        let tube = w.circle([5., 0., 0.], [0., -1., 0.], X, 1.5);
        let tube = w.edge(&v, &v, &tube);
        let mut uses = [
            (&*around, true),
            (&*tube, true),
            (&*around, false),
            (&*tube, false),
        ];
        uses.rotate_left(first);
        let bound = w.bound(&uses);
        let face = w.face(&surface, &[bound]);
        let shell = w.put(format!("CLOSED_SHELL('',({face}))"));
        w.put(format!("MANIFOLD_SOLID_BREP('',{shell})"));
        let document = w.document();
        near(distance(&document, [-7., 0., 0.]), 0.5, 1e-6);
        near(distance(&document, [0., 3., 0.]), 0.5, 1e-6);
        near(distance(&document, [0., 5., 2.]), 0.5, 1e-6);
    }
}

/// Of a box with a bad face, or a bad edge, the rest is read: an open shell, of which is said what it lacks.
#[test]
fn bad_faces_are_left_out_and_named() {
    let text = std::fs::read_to_string(models().join("step/box.step")).expect("a file");
    let damaged = |kind: &str, of: usize, attribute: usize| {
        // One attribute of one entity of this kind refers to what is not there.
        let start = text.match_indices(kind).nth(of).expect("an entity").0;
        let (before, entity) = text.split_at(start);
        let end = entity.find(';').expect("its end");
        let (entity, rest) = entity.split_at(end);
        let parts: Vec<&str> = entity.split("#").collect();
        let mut parts: Vec<String> = parts.into_iter().map(str::to_owned).collect();
        let digits = parts[attribute].find(|c: char| !c.is_ascii_digit());
        parts[attribute].replace_range(..digits.expect("a delimiter"), "987654");
        format!("{before}{}{rest}", parts.join("#"))
    };
    let loaded = |text: &str| feeler_io::read_step(text.as_bytes()).expect("a file");
    let of = |document: &Document| -> (usize, Vec<String>) {
        let ObjectKind::Brep(brep) = &document.objects[0].kind else {
            panic!("{:?}", document.objects[0].kind);
        };
        assert!(!brep.is_closed());
        let left = document.objects[1..].iter().map(|o| match &o.kind {
            ObjectKind::Refused { class, reason } => format!("{class}: {reason}"),
            other => panic!("{other:?}"),
        });
        (brep.faces().len(), left.collect())
    };
    // The surface of the second face: its bounds come first.
    let document = loaded(&damaged("ADVANCED_FACE", 1, 2));
    let (faces, left) = of(&document);
    assert_eq!((faces, left.len()), (5, 1), "{left:?}");
    assert!(
        left[0].starts_with("face #") && left[0].contains("#987654"),
        "{left:?}"
    );
    let said = &document.objects[0].warnings;
    assert!(
        said.iter()
            .any(|w| w.starts_with("1 of 6 faces cannot be read")),
        "{said:?}"
    );
    // Two faces meet at an edge.
    let (faces, left) = of(&loaded(&damaged("EDGE_CURVE", 3, 3)));
    assert_eq!((faces, left.len()), (4, 2), "{left:?}");
    // The same body in a second representation: an object once, and the face is still told to whoever takes the model.
    let lacking = damaged("ADVANCED_FACE", 1, 2);
    let solid = { text.lines().find(|l| l.contains("MANIFOLD_SOLID_BREP")) }.expect("a solid");
    let solid = solid.split_once(' ').expect("its number").0;
    let again = format!("#90001=SHAPE_REPRESENTATION('',({solid}),$);\nENDSEC;\nEND-ISO");
    let document = loaded(&lacking.replacen("ENDSEC;\nEND-ISO", &again, 1));
    assert_eq!(document.bodies().count(), 2);
    let told = document.objects.iter().filter(|o| !o.block_member);
    let told = told.filter(|o| matches!(o.kind, ObjectKind::Refused { .. }));
    assert_eq!(told.count(), 1);
    // Where nothing is left, the body is refused.
    let none = text.replace("PLANE(", "NO_PLANE(");
    let document = loaded(&none);
    assert_eq!(document.objects.len(), 1);
    assert!(matches!(
        document.objects[0].kind,
        ObjectKind::Refused { .. }
    ));
}

/// A cavity that cannot be read is not left out: the body would be closed without it, and solid where it is hollow.
#[test]
fn a_body_without_its_cavity_is_refused() {
    let text = std::fs::read_to_string(models().join("step/box.step")).expect("a file");
    let start = text.find("MANIFOLD_SOLID_BREP").expect("a solid");
    let (before, solid) = text.split_at(start);
    let end = solid.find(");").expect("its end");
    let (solid, rest) = solid.split_at(end);
    let hollow = solid.replace("MANIFOLD_SOLID_BREP", "BREP_WITH_VOIDS");
    let (data, tail) = rest.split_at(rest.rfind("ENDSEC").expect("the end of the data"));
    let cavity = "#90001=CLOSED_SHELL('',(#90002));\n#90002=ADVANCED_FACE('',(),#987654,.T.);\n\
                  #90003=ORIENTED_CLOSED_SHELL('',*,#90001,.F.);\n";
    let text = format!("{before}{hollow},(#90003){data}{cavity}{tail}");
    let document = feeler_io::read_step(text.as_bytes()).expect("a file");
    let ObjectKind::Refused { reason, .. } = &document.objects[0].kind else {
        panic!("{:?}", document.objects[0].kind);
    };
    assert!(reason.to_string().contains("#987654"), "{reason}");
}

/// A polygon of so many points around the origin in the plane z = 0, as one B-spline of degree 1 from a vertex to itself.
fn polygon(w: &mut Writer, count: usize) -> String {
    let points: Vec<String> = (0..=count)
        .map(|k| {
            let a = std::f64::consts::TAU * (k % count) as f64 / count as f64;
            w.point([2.0 * a.cos(), 2.0 * a.sin(), 0.0])
        })
        .collect();
    let inner = vec!["1"; count - 1].join(",");
    let knots: Vec<String> = (0..=count).map(|k| format!("{k}.")).collect();
    let curve = w.put(format!(
        "B_SPLINE_CURVE_WITH_KNOTS('',1,({}),.UNSPECIFIED.,.T.,.F.,(2,{inner},2),({}),.UNSPECIFIED.)",
        points.join(","),
        knots.join(",")
    ));
    let v = w.put(format!("VERTEX_POINT('',{})", points[0]));
    w.edge(&v, &v, &curve)
}

fn flat(w: &mut Writer) -> String {
    let axes = w.axes([0.; 3], Z, X);
    w.put(format!("PLANE('',{axes})"))
}

/// What a file lists as a set is there once, however often it is said: items of a representation, and bounds of a face.
#[test]
fn sets_hold_each_once() {
    let mut w = Writer::default();
    let mm = w.millimetres();
    let mm = w.context(&mm, "");
    let edge = polygon(&mut w, 4);
    let plane = flat(&mut w);
    let bound = w.bound(&[(&edge, true)]);
    let face = w.face(&plane, &[bound.clone(), bound]);
    let sheet = w.sheet(&[face]);
    w.representation(&vec![sheet; 3].join(","), &mm);
    let document = w.document();
    let [only] = &document.objects[..] else {
        panic!("{} objects", document.objects.len());
    };
    let ObjectKind::Brep(brep) = &only.kind else {
        panic!("{}", only.kind.name());
    };
    assert_eq!(brep.parts().loops.len(), 1);
}

/// The unit is that of the first body, wherever it is among parts without any.
#[test]
fn empty_parts_have_no_say_in_the_unit() {
    let mut w = Writer::default();
    let (mm, inch) = (w.millimetres(), w.inches());
    let (mm, inch) = (w.context(&mm, ""), w.context(&inch, ""));
    let ball = w.ball([0.; 3], 1.0);
    let far = w.ball([254., 0., 0.], 25.4);
    let here = w.axes([0.; 3], Z, X);
    let nothing = w.representation(&here, &inch);
    let part = w.representation(&format!("{here},{ball}"), &inch);
    let mut mapped = |what: &str| {
        let map = w.put(format!("REPRESENTATION_MAP({here},{what})"));
        w.put(format!("MAPPED_ITEM('',{map},{here})"))
    };
    let items = [mapped(&nothing), mapped(&part), mapped(&nothing)];
    w.representation(&items.join(","), &inch);
    w.representation(&far, &mm);
    let document = w.document();
    assert_eq!(document.units, Units::Inches);
    let balls = breps("it", &document);
    assert_eq!(balls.len(), 2);
    // The other ball, of 25.4 mm at 254, is one of an inch at 10.
    let sizes = balls.iter().map(largest).collect::<Vec<_>>();
    assert!(
        (sizes[0] - 1.0).abs() < 1e-9 && (sizes[1] - 10.0).abs() < 1e-9,
        "{sizes:?}"
    );
}

/// A body that two representations of one thing list is there once.
#[test]
fn a_body_of_one_thing_is_there_once() {
    let mut w = Writer::default();
    let mm = w.millimetres();
    let mm = w.context(&mm, "");
    let ball = w.ball([0.; 3], 1.0);
    let (a, b) = (w.representation(&ball, &mm), w.representation(&ball, &mm));
    w.put(format!("SHAPE_REPRESENTATION_RELATIONSHIP('','',{a},{b})"));
    let document = w.document();
    assert_eq!(document.bodies().count(), 1);
    assert_eq!(document.objects.len(), 1);
}

/// What is placed again is there once; references that place more in all than there is room for are refused.
#[test]
fn copies_are_kept_once() {
    let mut w = Writer::default();
    let mm = w.millimetres();
    let mm = w.context(&mm, "");
    let edge = polygon(&mut w, 2000);
    let plane = flat(&mut w);
    let bound = w.bound(&[(&edge, true)]);
    let face = w.face(&plane, &[bound]);
    let sheet = w.sheet(&[face]);
    for _ in 0..12_000 {
        w.representation(&sheet, &mm);
    }
    let document = w.document();
    let [references @ .., body] = &document.objects[..] else {
        panic!("no objects");
    };
    assert!(matches!(body.kind, ObjectKind::Brep(_)) && body.block_member);
    assert!(!body.warnings.is_empty());
    assert_eq!(references.len(), 12_000);
    let is_placed = |o: &Object| matches!(o.kind, ObjectKind::Block { .. });
    let placed = references.iter().take_while(|o| is_placed(o)).count();
    assert!((100..12_000).contains(&placed), "{placed}");
    assert_eq!(document.bodies().count(), placed);
    let all_the_same = (0..placed).flat_map(|i| document.placements(i));
    assert!({ all_the_same }.all(|p| p.index == 12_000 && p.map.is_none()));
    for last in &references[placed..] {
        let ObjectKind::Refused { reason, .. } = &last.kind else {
            panic!("{}", last.kind.name());
        };
        assert!(reason.to_string().contains("placed parts"), "{reason}");
    }
}

/// A part in a part in a part, each twice: every copy stands where all the maps that it is under put it.
#[test]
fn nested_copies_stand_where_they_should() {
    let mut w = Writer::default();
    let mm = w.millimetres();
    let mm = w.context(&mm, "");
    let ball = w.ball([0., 0.5, 0.], 0.25);
    let origin = w.axes([0.; 3], Z, X);
    let mut inner = w.representation(&format!("{origin},{ball}"), &mm);
    // Each places what it holds as it is, and shifted by a power of two; the last also turned about x by a right angle.
    for k in 0..3 {
        let here = w.axes([0.; 3], Z, X);
        let turned = if k == 2 { [0., 1., 0.] } else { Z };
        let there = w.axes([f64::from(1 << k), 0., 0.], turned, X);
        let map = w.put(format!("REPRESENTATION_MAP({origin},{inner})"));
        let items = [here, there].map(|to| w.put(format!("MAPPED_ITEM('',{map},{to})")));
        inner = w.representation(&items.join(","), &mm);
    }
    let document = w.document();
    let members = document.objects.iter().filter(|o| o.block_member).count();
    assert_eq!((document.objects.len(), members), (2, 1));
    assert_eq!(document.blocks().len(), 4);
    let centres: Vec<Point3<f64>> = document
        .bodies()
        .map(|(_, b)| {
            let points = b.parts().vertices.iter().map(|v| v.point.coords);
            let count = points.clone().count() as f64;
            Point3::from(points.sum::<Vector3<f64>>() / count)
        })
        .collect();
    let own = centres[0];
    let expected = (0..8).map(|k| {
        let shift = Vector3::new(f64::from(k), 0.0, 0.0);
        // The map takes x to x and z to y.
        let own = if k >= 4 {
            Point3::new(own.x, own.z, -own.y)
        } else {
            own
        };
        own + shift
    });
    assert_eq!(centres.len(), 8);
    for (found, known) in centres.iter().zip(expected) {
        assert!((found - known).norm() < 1e-12, "{found} {known}");
    }
}

/// Where a face that is good by itself is more than there is room for, its body is refused, which says so: no face is left out as if it were bad.
#[test]
fn bodies_without_room_are_no_bodies_with_bad_faces() {
    let mut w = Writer::default();
    let edge = polygon(&mut w, 2000);
    let plane = flat(&mut w);
    let [once, often] = [1, 1500].map(|n| w.bound(&vec![(&*edge, true); n]));
    let [small, large] = [once, often].map(|bound| w.face(&plane, &[bound]));
    let fits = w.sheet(std::slice::from_ref(&small));
    let body = w.sheet(&[small, large]);
    let document = w.document();
    let [first, second] = &document.objects[..] else {
        panic!("{:?}", document.objects.len());
    };
    assert!(matches!(first.kind, ObjectKind::Brep(_)), "{fits}");
    let ObjectKind::Refused { reason, .. } = &second.kind else {
        panic!("{}", second.kind.name());
    };
    let text = reason.to_string();
    assert!(
        text.starts_with(&format!("{body}: no room is left for it")),
        "{text}"
    );
    assert!(text.contains("export its bodies one by one"), "{text}");
}

/// What is to be proven counts, not what shares its edge: one beside thousands whose bounds are known is proven, of hundreds some are left.
#[test]
fn proofs_are_counted_by_the_trims_that_need_one() {
    let mut w = Writer::default();
    let edge = w.round([0.; 3], Z, X, 2.);
    let plane = flat(&mut w);
    let bound = w.bound(&[(&edge, true)]);
    // Flat, too, but not run evenly: a curve in uv has to be fitted.
    let mut rows = Vec::new();
    for x in [-4., -1., 4.] {
        let row: Vec<String> = [-4., -1., 4.].map(|y| w.point([x, y, 0.])).to_vec();
        rows.push(format!("({})", row.join(",")));
    }
    let uneven = w.put(format!(
        "B_SPLINE_SURFACE_WITH_KNOTS('',2,2,({}),.UNSPECIFIED.,.F.,.F.,.F.,(3,3),(3,3),(0.,1.),(0.,1.),.UNSPECIFIED.)",
        rows.join(",")
    ));
    let own = w.bound(&[(&edge, true)]);
    let fitted = w.face(&uneven, &[own]);
    // What a file has besides: one of a few thousand bytes may not unfold to so many uses, nor take the room that the proof of so many pieces does.
    for k in 0..12_000 {
        w.point([0., 0., f64::from(k)]);
    }
    for (others, count, left) in [(10, 1, false), (2100, 1, false), (0, 600, true)] {
        let mut w = Writer {
            text: w.text.clone(),
            count: w.count,
        };
        let face = w.face(&plane, std::slice::from_ref(&bound));
        let mut faces = vec![face; others];
        faces.resize(others + count, fitted.clone());
        w.sheet(&faces);
        let document = w.document();
        let said = &document.objects[0].warnings;
        assert!(
            said.iter()
                .any(|s| s.contains(&format!("{count} of them are fitted"))),
            "{said:?}"
        );
        let found = said
            .iter()
            .any(|s| s.contains(" more are too many to be proven"));
        assert_eq!(found, left, "{others}, {count}: {said:?}");
    }
}

/// What is exact is no length with an exponent.
#[test]
fn exact_images_are_said_to_be_exact() {
    let document = read_file(models().join("step/sphere.step")).unwrap();
    let said = document.objects[0].warnings.join("; ");
    let exact = "all images are within 0 of the edges";
    assert!(said.contains(exact), "{said}");
}

/// Two meridians that leave a pole almost in one direction are taken to do so in one: the second is moved, and the bound on how far images are from
/// their edges says so.
#[test]
fn what_is_moved_at_a_pole_counts_in_the_bound() {
    let angle = 1e-6_f64;
    let radius = 2.;
    let mut w = Writer::default();
    let axes = w.axes([0.; 3], Z, X);
    let sphere = w.put(format!("SPHERICAL_SURFACE('',{axes},{radius:?})"));
    let (sin, cos) = angle.sin_cos();
    let [p, q, pole] = [
        [radius, 0., 0.],
        [radius * cos, radius * sin, 0.],
        [0., 0., radius],
    ]
    .map(|at| w.vertex(at));
    let equator = w.circle([0.; 3], Z, X, radius);
    let along = w.edge(&p, &q, &equator);
    let first = w.circle([0.; 3], [sin, -cos, 0.], [cos, sin, 0.], radius);
    let up = w.edge(&q, &pole, &first);
    let second = w.circle([0.; 3], [0., -1., 0.], X, radius);
    let down = w.edge(&p, &pole, &second);
    let bound = w.bound(&[(&along, true), (&up, true), (&down, false)]);
    let face = w.face(&sphere, &[bound]);
    w.sheet(&[face]);
    let document = w.document();
    // There is no room for its proof beside so small a file, which is said; beside a larger one there is.
    let said = document.objects[0].warnings.join("; ");
    assert!(said.contains("1 more are too many to be proven"), "{said}");
    // Of the others it says how many they are.
    assert!(said.contains(": 2 images are within "), "{said}");
    for k in 0..64 {
        w.point([0., 0., f64::from(k)]);
    }
    let document = w.document();
    let found = said_bound(&document);
    assert!(found >= 0.9 * radius * angle && found < 1e-5, "{found:e}");
    let said = document.objects[0].warnings.join("; ");
    assert!(!said.contains(" more are too many"), "{said}");
}

/// The bound that is said of images of curves in uv.
fn said_bound(document: &Document) -> f64 {
    let object = &document.objects[0];
    let said = object.warnings.join("; ");
    if let ObjectKind::Refused { reason, .. } = &object.kind {
        panic!("{reason}");
    }
    bound_in(&said)
}

fn bound_in(said: &str) -> f64 {
    let (_, after) = said.split_once("images are within ").expect("a bound");
    let found = after.split(' ').next().and_then(|x| x.parse().ok());
    found.unwrap_or_else(|| panic!("{said}"))
}

/// Two rims that start a millionth of a radian beside each other: one turn of the surface does not hold both, and what of one is cut off at its end is
/// off its circle by as much. Along the other parameter, the same on a torus.
#[test]
fn what_sticks_out_of_one_turn_counts_in_the_bound() {
    let off = 1e-6_f64;
    let (sin, cos) = off.sin_cos();
    let mut w = Writer::default();
    let axes = w.axes([0.; 3], Z, X);
    let cylinder = w.put(format!("CYLINDRICAL_SURFACE('',{axes},10.)"));
    let low = w.round([0.; 3], Z, X, 10.);
    let high = w.round([0., 0., 5.], Z, [cos, sin, 0.], 10.);
    let bounds = [w.bound(&[(&low, true)]), w.bound(&[(&high, false)])];
    let face = w.face(&cylinder, &bounds);
    w.sheet(&[face]);
    let rims = (w.document(), 10.);

    let mut w = Writer::default();
    let axes = w.axes([0.; 3], Z, X);
    let torus = w.put(format!("TOROIDAL_SURFACE('',{axes},10.,3.)"));
    let first = w.round([10., 0., 0.], [0., -1., 0.], X, 3.);
    let last = w.round([0., 10., 0.], X, [0., cos, sin], 3.);
    let bounds = [w.bound(&[(&first, true)]), w.bound(&[(&last, false)])];
    let face = w.face(&torus, &bounds);
    w.sheet(&[face]);
    let meridians = (w.document(), 3.);

    for (document, radius) in [rims, meridians] {
        let brep = &breps("it", &document)[0];
        // The worst of all trims, at the parameters of their edges: where the curve is beyond the domain, the face has its border.
        let mut seen = 0.0_f64;
        for trim in &brep.parts().trims {
            let Some(edge) = trim.edge.map(|e| &brep.parts().edges[e]) else {
                continue;
            };
            let Some(curve) = edge.curve.map(|c| &brep.parts().curves3[c]) else {
                continue;
            };
            let surface = brep.surface(brep.parts().loops[trim.trim_loop].face);
            let [u, v] = surface.domain();
            for k in 0..=100 {
                let t = edge.span.lerp(f64::from(k) / 100.);
                let uv = brep.parts().curves2[trim.curve].point(t);
                let uv = [uv.x.clamp(u.start, u.end), uv.y.clamp(v.start, v.end)];
                seen = seen.max((surface.point(uv[0], uv[1]) - curve.point(t)).norm());
            }
        }
        near(seen, radius * off, 1e-3 * radius * off);
        let bound = said_bound(&document);
        // Two digits are said.
        assert!(
            bound >= 0.95 * seen && bound <= 2. * seen,
            "{bound:e}, {seen:e}"
        );
    }
}

/// One branch of a hyperbola, extruded and turned: as far as the edges go, and its points are those of the curve.
#[test]
fn surfaces_made_of_hyperbolas_reach_as_far_as_their_edges() {
    let (a, b) = (2.0_f64, 1.0_f64);
    let on = |t: f64| [a * t.cosh(), b * t.sinh()];
    // Far out a hyperbola is nearly its asymptotes.
    for ends in [[-1.0, 1.5], [0.5, 3.0], [-4.0, 4.0]] {
        let mut w = Writer::default();
        let branch = |w: &mut Writer, z: f64| {
            let axes = w.axes([0., 0., z], Z, X);
            w.put(format!("HYPERBOLA('',{axes},{a:?},{b:?})"))
        };
        let line = |w: &mut Writer, [x, y]: [f64; 2]| {
            let (p, z) = (w.point([x, y, 0.]), w.direction(Z));
            let v = w.put(format!("VECTOR('',{z},1.)"));
            w.put(format!("LINE('',{p},{v})"))
        };
        let (profile, z) = (branch(&mut w, 7.), w.direction(Z));
        let along = w.put(format!("VECTOR('',{z},2.)"));
        let surface = w.put(format!("SURFACE_OF_LINEAR_EXTRUSION('',{profile},{along})"));
        let [p, q] = ends.map(on);
        let at = |w: &mut Writer, [x, y]: [f64; 2], z: f64| w.vertex([x, y, z]);
        let low = [at(&mut w, p, 0.), at(&mut w, q, 0.)];
        let high = [at(&mut w, p, 3.), at(&mut w, q, 3.)];
        let curves = [branch(&mut w, 0.), branch(&mut w, 3.)];
        let (left, right) = (line(&mut w, p), line(&mut w, q));
        let edges = [
            w.edge(&low[0], &low[1], &curves[0]),
            w.edge(&low[1], &high[1], &right),
            w.edge(&high[0], &high[1], &curves[1]),
            w.edge(&low[0], &high[0], &left),
        ];
        let senses = [true, true, false, false];
        let uses: Vec<_> = edges.iter().map(String::as_str).zip(senses).collect();
        let bound = w.bound(&uses);
        let face = w.face(&surface, &[bound]);
        w.sheet(&[face]);
        let document = w.document();
        let far = on(4.0)[0];
        assert!(said_bound(&document) <= 1e-8 * far);
        for k in 0..=8 {
            let [x, y] = on(ends[0] + (ends[1] - ends[0]) * f64::from(k) / 8.0);
            near(distance(&document, [x, y, 1.5]), 0.0, 1e-8 * far);
        }
        // The square of the distance from the center is least at the vertex, or the end next to it.
        let least = on(ends[0].max(0.0));
        near(
            distance(&document, [0., 0., 1.5]),
            least[0].hypot(least[1]),
            1e-8 * far,
        );
        // Beyond the ends there is nothing of it.
        let beyond = on(ends[1] + 1.0);
        assert!(distance(&document, [beyond[0], beyond[1], 1.5]) > 1.0);
    }
    // Turned about the other axis: a hyperboloid of one sheet between two circles.
    let mut w = Writer::default();
    let axes = w.axes([0.; 3], [0., -1., 0.], X);
    let profile = w.put(format!("HYPERBOLA('',{axes},{a:?},{b:?})"));
    let (origin, z) = (w.point([0., 0., 5.]), w.direction(Z));
    let axis = w.put(format!("AXIS1_PLACEMENT('',{origin},{z})"));
    let surface = w.put(format!("SURFACE_OF_REVOLUTION('',{profile},{axis})"));
    let [low, high] = [-1.0, 1.5].map(on);
    let (text, count) = (w.text.clone(), w.count);
    let low = w.round([0., 0., low[1]], Z, X, low[0]);
    let high = w.round([0., 0., high[1]], Z, X, high[0]);
    let bounds = [w.bound(&[(&low, true)]), w.bound(&[(&high, false)])];
    let face = w.face(&surface, &bounds);
    w.sheet(&[face]);
    let document = w.document();
    near(distance(&document, [0.; 3]), a, 1e-8);
    for t in [-0.9, 0.0, 0.4, 1.4] {
        let [x, z] = on(t);
        near(distance(&document, [0.6 * x, -0.8 * x, z]), 0.0, 1e-8);
    }
    // What a rim is off is what is said.
    near(said_bound(&document), 0.0, 1e-11);
    let off = 3e-6;
    let mut w = Writer { text, count };
    let rims = [-1.0, 1.5].map(on);
    let rims = rims.map(|[x, z]| w.round([0., 0., z], Z, X, x + off));
    let bounds = [w.bound(&[(&rims[0], true)]), w.bound(&[(&rims[1], false)])];
    let face = w.face(&surface, &bounds);
    w.sheet(&[face]);
    // The surface next to a rim is as near as its slope lets it be.
    let said = said_bound(&w.document());
    assert!(said >= 0.3 * off && said <= 1.1 * off, "{said:e}");
}

/// A hyperbola that is extruded along its asymptote has no end in the plane across: it is refused.
#[test]
fn hyperbolas_along_their_asymptotes_are_refused() {
    let mut w = Writer::default();
    let axes = w.axes([0.; 3], Z, X);
    let profile = w.put(format!("HYPERBOLA('',{axes},1.,1.)"));
    let direction = w.direction([1., 1., 0.]);
    let along = w.put(format!("VECTOR('',{direction},1.)"));
    wall(&mut w, &profile, &along, 0.0);
    let said = refusal(&w.document());
    assert!(said.contains("asymptote"), "{said}");
}
