//! All contacts within a prediction, against what geometry says.

use crate::scenes::loops::face_of;
use crate::scenes::{Random, cube, cylinder, part_of_sphere, with_and_without_formulas};
use feeler::brep::Brep;
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve2, Curve3, Line, NurbsCurve, NurbsSurface, Revolution, Surface};
use feeler::prepare::{PreparedBrep, Shortcuts};
use feeler::query::{
    Contact, ContactAnswer, Contacts, HalfSpace, Options, Probe, Sphere, Workspace, contact,
};
use nalgebra::{Point3, Vector3, Vector4};

fn all(brep: &PreparedBrep, probe: &Probe, prediction: f64) -> ContactAnswer {
    let options = Options {
        contacts: Contacts::All,
        prediction,
        ..Options::default()
    };
    contact(brep, probe, &options, &mut Workspace::default())
}

/// Exactly these, in this order: where, and their separations.
fn must_be(answer: &ContactAnswer, expected: &[([f64; 3], f64)]) {
    assert_eq!(answer.undecided, None);
    assert_eq!(answer.contacts.len(), expected.len(), "{answer:#?}");
    for (c, (at, separation)) in answer.contacts.iter().zip(expected) {
        assert!((c.on_brep - Point3::from(*at)).norm() < 1e-12, "{c:#?}");
        assert!((c.separation.value - separation).abs() < 1e-14, "{c:#?}");
    }
}

#[test]
fn a_ball_about_a_box() {
    let cube = PreparedBrep::new(cube());
    let ask = |c: [f64; 3], r, p| {
        let ball = Probe::Sphere(Sphere::new(c.into(), r).unwrap());
        all(&cube, &ball, p)
    };
    // Before a corner and before an edge: where other faces and edges end there, they go on falling elsewhere.
    let d = (0.01f64 + 0.04 + 0.09).sqrt();
    must_be(&ask([1.1, 1.2, 1.3], 0.0, 5.0), &[([1.0; 3], d)]);
    let edge = [([1.0, 1.0, 0.25], 0.5)];
    must_be(&ask([1.3, 1.4, 0.25], 0.0, 5.0), &edge);
    // Before a face: its foot, and that of the face behind.
    let two = [([1.0, 0.5, 0.25], 0.25), ([0.0, 0.5, 0.25], 1.25)];
    must_be(&ask([1.5, 0.5, 0.25], 0.25, 5.0), &two);
    must_be(&ask([1.5, 0.5, 0.25], 0.25, 0.125), &[]);
    // In the box the nearest comes first; the others as far as ball and prediction reach, that distance included.
    let c = [0.875, 0.75, 0.5];
    must_be(&ask(c, 0.0625, 0.0625), &[([1.0, 0.75, 0.5], -0.1875)]);
    let two = [([1.0, 0.75, 0.5], -0.375), ([0.875, 1.0, 0.5], -0.5)];
    must_be(&ask(c, 0.25, 0.0), &two);
    assert_eq!(ask(c, 1.0, 0.0).contacts.len(), 6);
}

#[test]
fn a_half_space_and_a_box() {
    let cube = PreparedBrep::new(cube());
    let normal = Vector3::new(0.6, 0.48, 0.64);
    let below = Probe::HalfSpace(HalfSpace::new(normal, 0.0).unwrap());
    // The other vertices are none: along an edge each of them falls, though the steepest way leaves the face.
    must_be(&all(&cube, &below, 9.0), &[([0.0; 3], 0.0)]);
}

/// The patch `(x, y, p(x) + y^2)` over [-2, 2] x [-1, 1], `p` given by its coefficients in `s = (x + 2) / 4`.
fn valley(p: &[f64]) -> Brep {
    let n = p.len() - 1;
    let binomial =
        |n: usize, k: usize| (0..k).fold(1.0, |b, i| b * (n - i) as f64 / (i + 1) as f64);
    let mut net = Vec::new();
    for j in 0..=n {
        let z: f64 = (0..=j)
            .map(|i| p[i] * binomial(j, i) / binomial(n, i))
            .sum();
        for (y, square) in [(-1.0, 1.0), (0.0, -1.0), (1.0, 1.0)] {
            let x = 4.0 * j as f64 / n as f64 - 2.0;
            net.push(Vector4::new(x, y, z + square, 1.0));
        }
    }
    let clamped = |p: usize| [vec![0.0; p + 1], vec![1.0; p + 1]].concat();
    let surface = NurbsSurface::new([n, 2], [n + 1, 3], net, [clamped(n), clamped(2)]).unwrap();
    Brep::from_surface(Surface::Nurbs(surface)).unwrap()
}

/// Coefficients of the product of two polynomials.
fn times(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            out[i + j] += x * y;
        }
    }
    out
}

/// A minimum that is flat to the fourth order is a contact like any other, or the answer is undecided; it is never left out in
/// silence, whatever the search may use.
#[test]
fn a_flat_minimum_is_not_lost() {
    // ((x^2 - 1)^4 - (x - 1)^4 / 8 with x = 4 s - 2: minima at 1, where it is 0, and where 16 x (x + 1)^3 = 1, lower.
    let power = |a: &[f64], n: usize| (0..n).fold(vec![1.0], |p, _| times(&p, a));
    let (minus, plus) = ([-3.0, 4.0], [-1.0, 4.0]);
    let mut p = power(&times(&minus, &plus), 4);
    for (i, c) in power(&minus, 4).into_iter().enumerate() {
        p[i] -= c / 8.0;
    }
    let below = Probe::HalfSpace(HalfSpace::new(Vector3::z(), -3.0).unwrap());
    for convex_leaves in [true, false] {
        let shortcuts = Shortcuts {
            convex_leaves,
            ..Shortcuts::default()
        };
        let brep = PreparedBrep::with_shortcuts(valley(&p), shortcuts);
        let answer = all(&brep, &below, 5.0);
        let near = |x: f64| {
            let near = |p: Point3<f64>| (p.x - x).abs() < 0.05 && p.y.abs() < 0.05;
            answer.contacts.iter().any(|c| near(c.on_brep))
        };
        assert!(
            answer.undecided.is_some() || near(1.0) && near(-1.358),
            "{convex_leaves}: {answer:#?}"
        );
    }
}

/// Patches over [a, a + 2] x [0, 4] for each `a`, one after the other, with the height `x^2 + y^2 + x (slope + twist y)`, where `y` counts from `middle` and `x`
/// from the nearer of 2 and 6: convex on each patch, and least there, as it rises from them along x on both sides.
fn creased(from: &[f64], slope: f64, twist: f64, middle: f64) -> Brep {
    let mut net = Vec::new();
    let mut row = |x: [f64; 2], crease: f64| {
        for y in [[0.0, 0.0], [0.0, 4.0], [4.0, 4.0]] {
            // Polar forms: coefficients of the square are products.
            let off = x.map(|x| (x - crease).abs());
            let up = y.map(|y| y - middle);
            let mean = |a: [f64; 2]| 0.5 * (a[0] + a[1]);
            let height = off[0] * off[1] + up[0] * up[1] + mean(off) * (slope + twist * mean(up));
            net.push(Vector4::new(mean(x), mean(y), height, 1.0));
        }
    };
    let (mut knots, mut count) = (vec![from[0]; 3], 1);
    for (i, a) in from.iter().enumerate() {
        let crease = if *a < 4.0 { 2.0 } else { 6.0 };
        let b = a + 2.0;
        if i == 0 {
            row([*a, *a], crease);
        }
        row([*a, b], crease);
        row([b, b], crease);
        knots.extend([b, b]);
        count += 2;
    }
    knots.push(from[from.len() - 1] + 2.0);
    let across = [[0.0; 3], [4.0; 3]].concat();
    let surface = NurbsSurface::new([2, 2], [count, 3], net, [knots, across]).unwrap();
    Brep::from_surface(Surface::Nurbs(surface)).unwrap()
}

/// Where a patch is convex and least on its border, that is a minimum if the face ends there or rises beyond: on a crease each patch on its own
/// falls towards the other.
#[test]
fn minima_on_borders_and_creases_are_not_lost() {
    let mut random = Random::new(0x51ed_270b_9d1f_3a55);
    for _ in 0..40 {
        let slope = 10f64.powf(random.between(-3.0, 1.0));
        let (twist, middle) = (random.between(-1.0, 1.0), random.between(1.0, 3.0));
        let normal = Vector3::new(-0.25 * slope, 0.0, 1.0).normalize();
        let below = Probe::HalfSpace(HalfSpace::new(normal, 0.0).unwrap());
        // So far away that it sees no more of the slope than of the height.
        let center = Point3::new(3.75, middle, -10.0 / slope);
        let ball = Probe::Sphere(Sphere::new(center, 0.0).unwrap());
        for patches in [&[0.0, 2.0, 4.0, 6.0][..], &[2.0, 4.0]] {
            let brep = PreparedBrep::new(creased(patches, slope, twist, middle));
            for probe in [&below, &ball] {
                let answer = all(&brep, probe, 2e4);
                assert_eq!(answer.undecided, None);
                let mut at: Vec<f64> = answer.contacts.iter().map(|c| c.on_brep.x).collect();
                at.sort_by(f64::total_cmp);
                assert_eq!(
                    at,
                    [2.0, 6.0],
                    "{slope} {twist} {middle} {patches:?} {probe:?}"
                );
                for c in &answer.contacts {
                    assert!((c.on_brep.y - middle).abs() < 1e-6, "{c:?}");
                }
            }
        }
    }
}

/// Without its proof of convexity the search must not lose what it finds with it.
#[test]
fn contacts_do_not_hang_on_a_shortcut() {
    let shortcuts = Shortcuts {
        convex_leaves: false,
        closed_forms: false,
        ..Shortcuts::default()
    };
    let (full, less) = (
        PreparedBrep::new(cube()),
        PreparedBrep::with_shortcuts(cube(), shortcuts),
    );
    let mut decided = 0;
    for k in 0..20 {
        let t = f64::from(k) / 20.0;
        let centre = Point3::new(0.3 + 0.4 * t, 0.6 - 0.2 * t, 0.5 + 0.3 * t);
        let ball = Probe::Sphere(Sphere::new(centre, 0.55).unwrap());
        let (a, b) = (all(&full, &ball, 0.0), all(&less, &ball, 0.0));
        assert!(a.undecided.is_none());
        decided += usize::from(b.undecided.is_none());
        for c in &a.contacts {
            let found = b
                .contacts
                .iter()
                .any(|o| (o.on_brep - c.on_brep).norm() < 1e-6);
            assert!(found || b.undecided.is_some(), "{centre}: {c:#?} of {b:#?}");
        }
    }
    println!("{decided} of 20 decided without convexity");
}

/// Corners with one vanishing derivative, or both, and a surface that is a curve: what touches there is a contact all the same.
#[test]
fn a_point_without_a_normal_is_touched() {
    let corner = [1.0, 1.0, 0.25];
    // The last two points of one row coincide; those of both rows; both rows are the same.
    let rows: [[[f64; 3]; 8]; 3] = [
        [
            [0.0, 0.0, 0.0],
            [0.25, 0.5, 0.0],
            [0.5, 0.75, 0.25],
            [0.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.25, 0.5, 0.0],
            corner,
            corner,
        ],
        [
            [0.0, 0.0, 0.0],
            [0.25, 0.5, 0.0],
            corner,
            corner,
            [1.0, 0.0, 0.0],
            [1.25, 0.5, 0.0],
            corner,
            corner,
        ],
        [
            [0.0, 0.0, 0.0],
            [0.25, 0.5, 0.0],
            [0.5, 0.75, 0.25],
            corner,
            [0.0, 0.0, 0.0],
            [0.25, 0.5, 0.0],
            [0.5, 0.75, 0.25],
            corner,
        ],
    ];
    for (i, points) in rows.into_iter().enumerate() {
        let net = points.map(|[x, y, z]| Vector4::new(x, y, z, 1.0)).to_vec();
        let cubic = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
        let knots = [vec![0.0, 0.0, 1.0, 1.0], cubic];
        let surface = NurbsSurface::new([1, 3], [2, 4], net, knots).unwrap();
        let brep = PreparedBrep::new(Brep::from_surface(Surface::Nurbs(surface)).unwrap());
        for radius in [0.0, 0.125] {
            let ball = Probe::Sphere(Sphere::new(corner.into(), radius).unwrap());
            let options = Options::default();
            let found = contact(&brep, &ball, &options, &mut Workspace::default());
            assert_eq!(found.contacts.len(), 1, "{i} {radius}: {found:?}");
            let normal = found.contacts[0].normal;
            assert!((normal.norm() - 1.0).abs() < 1e-15, "{normal}");
        }
    }
}

/// The tip of a sliver whose width is a few roundings is a contact like any other, though the trim passes its length within three
/// steps of its parameter.
#[test]
fn the_tip_of_a_sliver_is_not_lost() {
    let net = [
        [-1.375, -2.875, 1.75],
        [-2.125, 1.375, -1.375],
        [0.875, -2.5, -1.75],
        [-2.5, 2.625, 0.0],
    ];
    let net = net.map(|p| Vector4::new(p[0], p[1], p[2], 1.0)).to_vec();
    let knots = || vec![-16.0, -16.0, 16.0, 16.0];
    let surface = NurbsSurface::new([1, 1], [2, 2], net, [knots(), knots()]).unwrap();
    let tip = [15.25, -1.25];
    let back = [15.249999999999996, -1.2499999999999993];
    let line = |points: &[[f64; 2]], knots: Vec<f64>| {
        let net = points
            .iter()
            .map(|p| Vector3::new(p[0], p[1], 1.0))
            .collect();
        Curve2::Nurbs(NurbsCurve::new(1, net, knots).unwrap())
    };
    let steps = [
        0.0,
        0.0,
        0.125,
        0.125 + 2.0 * f64::EPSILON,
        0.125 + 3.0 * f64::EPSILON,
    ];
    let end = 0.125 + 6.0 * f64::EPSILON;
    let steps = steps
        .into_iter()
        .chain([end, end])
        .map(|s| 1.0 + s)
        .collect();
    let zero = [0.0; 2];
    let trims = vec![
        line(&[zero, zero, zero, tip, back], steps),
        line(&[back, zero], vec![1.0, 1.0, 2.0, 2.0]),
    ];
    let brep = PreparedBrep::new(face_of(Surface::Nurbs(surface), vec![trims]));
    let below = Probe::HalfSpace(HalfSpace::new(Vector3::new(0.48, 0.6, 0.64), -0.25).unwrap());
    let answer = all(&brep, &below, 1.0);
    let at = Point3::new(
        -0.705039978027344,
        -0.15593719482421875,
        -0.9139938354492188,
    );
    let told = answer
        .contacts
        .iter()
        .any(|c| (c.on_brep - at).norm() < 1e-12);
    assert!(told || answer.undecided.is_some(), "{answer:#?}");
}

/// A ball whose centre is on the surface has the face's normal; on an edge and a vertex the normalised sum of the faces' normals, which is told to be a choice.
#[test]
fn normals_on_edges_and_vertices() {
    const ROUNDINGS: f64 = 8.0 * f64::EPSILON;
    let ask = |brep: &PreparedBrep, centre: [f64; 3]| {
        let ball = Probe::Sphere(Sphere::new(centre.into(), 0.25).unwrap());
        let options = Options::default();
        let answer = contact(brep, &ball, &options, &mut Workspace::default());
        let [c] = answer.contacts.as_slice() else {
            panic!("{answer:#?}")
        };
        let off = (c.on_probe - (Point3::from(centre) - 0.25 * c.normal)).norm();
        assert!(off <= ROUNDINGS, "{c:#?}");
        (c.normal, c.normal_is_choice)
    };
    let cube = PreparedBrep::new(cube());
    for (centre, sum, is_choice) in [
        ([1.0, 0.5, 0.25], [1.0, 0.0, 0.0], false),
        ([1.0, 1.0, 0.25], [1.0, 1.0, 0.0], true),
        ([0.0, 0.75, 0.0], [-1.0, 0.0, -1.0], true),
        ([1.0, 1.0, 1.0], [1.0, 1.0, 1.0], true),
        ([0.0, 1.0, 0.0], [-1.0, 1.0, -1.0], true),
        // Next to an edge the way to the centre tells.
        ([1.0 + 1e-9, 1.0, 0.25], [1.0, 0.0, 0.0], false),
    ] {
        let (normal, told) = ask(&cube, centre);
        let expected = Vector3::from(sum).normalize();
        assert!(
            (normal - expected).norm() <= ROUNDINGS,
            "{centre:?}: {normal}"
        );
        assert_eq!(told, is_choice, "{centre:?}");
    }
    // The rim of a cylinder: a cap and the side, whose seam ends there.
    let rim = PreparedBrep::new(cylinder([0.0; 3], [1.0, 1.0], 2.0, 2.0));
    for (x, y) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)] {
        let (normal, told) = ask(&rim, [x, y, 2.0]);
        let expected = Vector3::new(x, y, 1.0).normalize();
        assert!((normal - expected).norm() <= ROUNDINGS, "{x} {y}: {normal}");
        assert!(told);
    }
}

/// Lists by formula against those of the search, which knows no closed form: a cylinder with caps, and parts of spheres, cones and tori, whole or ending in arcs below and beyond
/// half a turn.
#[test]
fn lists_by_formula_are_those_of_the_search() {
    /// Feet are known better than this, and no two contacts of these parts are nearer.
    const SAME: f64 = 1e-6;
    /// A search for all minima of a native face may take seconds: this much is given to it.
    const BUDGET: usize = 2000;
    let sheet = |s: Surface| Brep::from_surface(s).unwrap();
    let interval = |a, b| Interval::new(a, b).unwrap();
    let turned = |profile: Curve3, turn: f64| {
        let revolution = Revolution {
            origin: Point3::origin(),
            axis: Vector3::z(),
            angle: interval(0.0, turn),
            angle_domain: interval(0.0, 1.0),
            profile,
            transposed: false,
        };
        sheet(Surface::Revolution(Revolution::new(revolution).unwrap()))
    };
    let slope = Line {
        from: Point3::new(1.5, 0.0, -1.0),
        to: Point3::new(0.0, 0.0, 1.0),
        domain: interval(0.0, 1.0),
    };
    let ring = |end| {
        let arc = Arc {
            center: Point3::new(2.0, 0.0, 0.0),
            x: Vector3::x(),
            y: Vector3::z(),
            z: -Vector3::y(),
            radius: 0.75,
            angle: interval(0.0, end),
            domain: interval(0.0, 1.0),
        };
        Curve3::Arc(Arc::new(arc).unwrap())
    };
    let whole = std::f64::consts::TAU;
    let parts = [
        cylinder([0.0; 3], [1.0, 1.0], 2.0, 2.0),
        sheet(part_of_sphere([0.0, 1.25], 1.5)),
        sheet(part_of_sphere([-0.5, 0.75], 5.0)),
        turned(Curve3::Line(slope.clone()), whole),
        turned(Curve3::Line(slope), 4.0),
        turned(ring(whole), whole),
        turned(ring(4.0), 4.0),
    ];
    let mut random = Random::new(11);
    let (mut asked, mut compared, mut listed) = (0, 0, 0);
    for brep in parts {
        let [brep, searched] = with_and_without_formulas(brep);
        for k in 0..24 {
            let direction = random.direction();
            let probe = if k % 2 == 0 {
                let center = Point3::from(direction * random.between(0.2, 4.0));
                Probe::Sphere(Sphere::new(center, 0.5).unwrap())
            } else {
                Probe::HalfSpace(HalfSpace::new(direction, random.between(-1.0, 1.0)).unwrap())
            };
            let options = Options {
                contacts: Contacts::All,
                prediction: 20.0,
                node_budget: BUDGET,
                ..Options::default()
            };
            let ask = |b: &PreparedBrep| contact(b, &probe, &options, &mut Workspace::default());
            let (formula, search) = (ask(&brep), ask(&searched));
            assert_eq!(formula.undecided, None, "{probe:?}");
            asked += 1;
            listed += formula.contacts.len();
            if search.undecided.is_some() {
                continue;
            }
            compared += 1;
            for (a, b) in [(&formula, &search), (&search, &formula)] {
                for c in &a.contacts {
                    let is = |o: &Contact| (o.on_brep - c.on_brep).norm() < SAME;
                    assert!(b.contacts.iter().any(is), "{probe:?}: {c:#?} of {b:#?}");
                }
            }
        }
    }
    println!("{compared} of {asked} compared, {listed} contacts");
    assert!(2 * compared > asked && listed > asked);
}
