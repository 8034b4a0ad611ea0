//! Closed forms of native surfaces against the search, with the formulas switched off. Both prove what they say, so their enclosures must meet.

use feeler::nurbs::Surface;
use feeler::prepare::{Form, PreparedBrep, Searched, Shortcuts};
use feeler::query::*;
use feeler_corpus::Model;
use nalgebra::{Point3, Vector3};
use std::path::Path;

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn direction(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| 2.0 * self.unit() - 1.0).normalize()
    }
}

fn load(model: &str) -> PreparedBrep {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models");
    let model = Model::load(&models.join(model), None).expect("a model of the corpus");
    PreparedBrep::new(model.breps.into_iter().next().expect("a BREP"))
}

/// Centres on axes and at centres of the model's revolutions, and near its surfaces, seams and poles.
fn centers(brep: &PreparedBrep, random: &mut Random) -> Vec<Point3<f64>> {
    let mut out = Vec::new();
    for face in 0..brep.brep().faces().len().min(4) {
        let surface = brep.brep().surface(face);
        if let Surface::Revolution(s) = surface {
            let axis = s.axis.normalize();
            out.push(s.origin);
            out.push(s.origin + axis * (0.3 * brep.size()));
            out.push(s.origin + axis * 0.1 + random.direction() * 1e-12);
        }
        let [u, v] = surface.domain();
        let at = |a: f64, b: f64| surface.point(u.lerp(a), v.lerp(b));
        let spots = [
            [random.unit(), random.unit()],
            [0.0, random.unit()],
            [1.0, 1.0],
        ];
        for [a, b] in spots {
            let off = brep.size() * 10f64.powf(-12.0 * random.unit());
            out.push(at(a, b) + random.direction() * off);
        }
    }
    out
}

fn meet([by_formula, searched]: [&PreparedBrep; 2], probe: &Probe) {
    let mut workspace = Workspace::default();
    let options = Options {
        prediction: 0.0,
        contacts: Contacts::None,
        ..Options::default()
    };
    let mut ask = |brep: &PreparedBrep| contact(brep, probe, &options, &mut workspace);
    let (formula, search) = (ask(by_formula), ask(searched));
    let (a, b) = (formula.separation.bounds, search.separation.bounds);
    assert!(a.lo <= a.hi, "{probe:?}: {a:?}");
    assert!(
        a.lo <= b.hi && b.lo <= a.hi,
        "{probe:?}: the formula says {a:?}, the search {b:?}"
    );
    // A formula may not fall short where the search does not.
    assert!(
        formula.undecided.is_none() || search.undecided.is_some(),
        "{probe:?}: {a:?} is wider than {b:?}"
    );
}

fn compare(model: &str) {
    let brep = load(model);
    let off = Shortcuts {
        closed_forms: false,
        ..Shortcuts::ALL
    };
    let searched = PreparedBrep::with_shortcuts(brep.brep().clone(), off);
    let both = [&brep, &searched];
    let mut random = Random(0x1234_5678_9abc_def1);
    for center in centers(&brep, &mut random) {
        // No radius that reaches anything: all minima would be sought.
        let sphere = Sphere::new(center, 0.0).expect("a sphere");
        meet(both, &Probe::Sphere(sphere));
    }
    let mut normals: Vec<Vector3<f64>> = (0..4).map(|_| random.direction()).collect();
    normals.extend([Vector3::x(), -Vector3::y(), Vector3::z()]);
    for normal in normals {
        let half_space = HalfSpace::new(normal, -10.0 * brep.size()).expect("a unit normal");
        meet(both, &Probe::HalfSpace(half_space));
    }
}

#[test]
fn spheres() {
    compare("thesis/ball.3dm");
    compare("analytic/sphere.json.gz");
}

/// In frames that are off by roundings.
#[test]
fn turned_spheres() {
    compare("brep/mirrored.brep");
    compare("thesis/shift_gate.brep");
    compare("thesis/cube_corner_sphere_cut.brep");
}

#[test]
fn cylinders() {
    compare("thesis/cylinder.3dm");
    compare("analytic/cylinder_slanted.json.gz");
}

#[test]
fn cones_and_tori() {
    compare("analytic/cone.json.gz");
    compare("analytic/frustum.json.gz");
    compare("analytic/torus.json.gz");
}

#[test]
fn trimmed_parts() {
    compare("thesis/cube_corner_sphere_cut.3dm");
    compare("thesis/ball_joint_socket.3dm");
    compare("thesis/geneva4_wheel.3dm");
}

/// Discs whose circle touches the border of their plane's domain, and a cone whose generator ends on the axis: formulas alone.
#[test]
fn caps_and_apexes_are_answered_by_formula() {
    for model in [
        "analytic/cone.json.gz",
        "analytic/frustum.json.gz",
        "analytic/cylinder.json.gz",
        "thesis/cylinder.3dm",
    ] {
        for face in load(model).plan() {
            let searched = match face.form {
                Form::Closed {
                    searched_curves, ..
                } => searched_curves,
                Form::Searched(_) => usize::MAX,
            };
            assert_eq!(searched, 0, "{model}: {face:?}");
        }
    }
}

/// Readers give a plane room about the curves of its loops: none of them leaves it.
#[test]
fn no_loop_of_a_read_plane_leaves_it() {
    for model in [
        "brep/primitives.brep",
        "brep/version1.brep",
        "brep/conics.brep",
        "thesis/cube_corner_sphere_cut.brep",
    ] {
        for (i, face) in load(model).plan().into_iter().enumerate() {
            let leaves = face.form == Form::Searched(Searched::Loops);
            assert!(!leaves, "{model}: face {i}: {face:?}");
        }
    }
}

/// The cone's apex is `(0, 0, 4)`, and its normals `(4 cos, 4 sin, 3) / 5`: it is the nearest to what is above it by more than 3/4 of what it is beside it.
/// The distances are those of Pythagorean quadruples, at every scale that f64 holds beside 4.
#[test]
fn next_to_an_apex() {
    let cone = load("analytic/cone.json.gz");
    let mut workspace = Workspace::default();
    for exponent in 4..=47 {
        let scale = 2f64.powi(-exponent);
        for ([x, y, z], length) in [
            ([0.0, 0.0, 1.0], 1.0),
            ([1.0, 2.0, 2.0], 3.0),
            ([-2.0, -1.0, 2.0], 3.0),
            ([0.0, -3.0, 4.0], 5.0),
            ([2.0, -3.0, 6.0], 7.0),
        ] {
            let center = Point3::new(x * scale, y * scale, 4.0 + z * scale);
            let probe = Probe::Sphere(Sphere::new(center, 0.0).expect("a sphere"));
            let answer = contact(&cone, &probe, &Options::default(), &mut workspace);
            let bounds = answer.separation.bounds;
            assert!(
                answer.undecided.is_none() && bounds.contains(length * scale),
                "{center}: {answer:?}"
            );
        }
    }
}

/// The hits of a line with a native sphere, cylinder and plane, where they are known: at distances from the axis
/// that are sums of squares.
#[test]
fn hits_where_they_are_known() {
    let ask = |brep: &PreparedBrep, origin: [f64; 3], direction: [f64; 3]| {
        let probe =
            LineProbe::new(origin.into(), direction.into(), LineKind::Line).expect("a line");
        let answer = line(brep, &probe, &Options::default(), &mut Workspace::default());
        assert_eq!(answer.undecided, None);
        let bounds = |h: &Hit| h.t.bounds;
        answer.hits.iter().map(bounds).collect::<Vec<_>>()
    };
    // Radius 2.5, height 10, along z from 0: 1.5^2 + 2^2 = 2.5^2.
    let cylinder = load("thesis/cylinder.3dm");
    let hits = ask(&cylinder, [-8.0, 1.5, 3.0], [1.0, 0.0, 0.0]);
    assert_eq!(hits.len(), 2);
    assert!(hits[0].contains(6.0) && hits[1].contains(10.0), "{hits:?}");
    assert!(hits.iter().all(|h| h.width() < 1e-14));
    let hits = ask(&cylinder, [0.5, 0.25, -4.0], [0.0, 0.0, 2.0]);
    assert!(
        hits.len() == 2 && hits[0].contains(2.0) && hits[1].contains(7.0),
        "{hits:?}"
    );
    assert!(ask(&cylinder, [-8.0, 3.0, 3.0], [1.0, 0.0, 0.0]).is_empty());
    assert!(ask(&cylinder, [-8.0, 1.5, 10.5], [1.0, 0.0, 0.0]).is_empty());
    // Radius 2 about (0.5, -0.25, 1): 1.2^2 + 1.6^2 = 2^2.
    let sphere = load("analytic/sphere.json.gz");
    let hits = ask(&sphere, [0.5 - 1.25, -10.25, 1.0], [0.0, 1.0, 0.0]);
    let half = (4.0f64 - 1.25 * 1.25).sqrt();
    assert_eq!(hits.len(), 2);
    for (h, t) in hits.iter().zip([10.0 - half, 10.0 + half]) {
        assert!((h.mid() - t).abs() < 1e-14 && h.width() < 1e-14, "{hits:?}");
    }
}

/// A few ulps above the top of the block at 5.5, over its edge: rays down hit within rounding of the border.
#[test]
fn a_side_next_to_an_edge() {
    let block = load("analytic/block.json.gz");
    let point = Point3::new(2.0, 1.9599302881944904, 5.500000000000002);
    let found = inside(&block, point, &mut Workspace::default());
    assert_eq!(found.side, Some(feeler::trim::Side::Outside));
}
