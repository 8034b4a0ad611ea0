//! What queries learn from those before changes the work, not the truth of an answer.

use crate::scenes::{
    Random, as_nurbs, bicubic, cube, native_sphere, nurbs_sphere, octant, sphere, trimmed_bicubic,
    wavy_prism,
};
use feeler::brep::{BrepBuilder, TrimSpec};
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Line, NurbsSurface, Surface};
use feeler::prepare::{PreparedBrep, Shortcuts};
use feeler::query::{
    Accuracy, Contact, ContactAnswer, Contacts, HalfSpace, Options, Probe, Sphere, Witness,
    Workspace, contact, contact_from,
};
use nalgebra::{Point2, Point3, Vector3, Vector4};

fn options() -> Options {
    Options {
        prediction: f64::INFINITY,
        ..Options::default()
    }
}

/// The answers with and without a hint must be as narrow, and both hold the truth: so they meet.
fn must_agree(brep: &PreparedBrep, probe: &Probe, witness: &mut Witness) -> [usize; 2] {
    agreed(brep, probe, witness).1
}

/// The same, with the one with a hint.
fn agreed(
    brep: &PreparedBrep,
    probe: &Probe,
    witness: &mut Witness,
) -> (ContactAnswer, [usize; 2]) {
    let mut workspace = Workspace::default();
    let cold = contact(brep, probe, &options(), &mut workspace);
    let dear = workspace.work().nodes;
    let warm = contact_from(brep, probe, witness, &options(), &mut workspace);
    let cheap = workspace.work().nodes;
    let (a, b) = (cold.separation.bounds, warm.separation.bounds);
    assert!(a.lo <= b.hi && b.lo <= a.hi, "{cold:?} {warm:?}");
    assert_eq!(cold.undecided, warm.undecided, "{probe:?}");
    assert_eq!(cold.contacts.len(), warm.contacts.len());
    let ulp = a.lo.abs().next_up() - a.lo.abs();
    if cold.undecided.is_none() {
        let size = brep.size() / (1u128 << 96) as f64;
        assert!(b.width() <= size.max(4.0 * ulp), "{warm:?}");
    }
    (warm, [cheap, dear])
}

#[test]
fn along_a_path() {
    let mut random = Random::new(31);
    for (brep, radius) in [(bicubic(), 0.05), (nurbs_sphere(), 2.0), (cube(), 0.1)] {
        let brep = PreparedBrep::new(brep);
        let (mut cheap, mut dear) = (0, 0);
        for _ in 0..10 {
            let from = Vector3::from_fn(|_, _| random.between(0.1, 0.9));
            let step = random.direction() * 1e-3;
            let at = |k: f64| Probe::Sphere(Sphere::new((from + step * k).into(), radius).unwrap());
            let mut witness = Witness::default();
            for k in 0..20 {
                let probe = at(f64::from(k));
                let [warm, cold] = must_agree(&brep, &probe, &mut witness);
                (cheap, dear) = (cheap + warm, dear + cold);
            }
        }
        assert!(cheap <= dear, "{cheap} {dear}");
    }
}

/// A witness is right wherever the ball goes: steps of all lengths, along the face and away from it, with trims, edges, closed
/// forms and cracks about.
#[test]
fn what_is_left_out_is_no_nearer() {
    let mut random = Random::new(43);
    // Each with a box to begin in.
    let models = [
        (bicubic(), [0.0, 1.0], [-0.3, 0.3]),
        (trimmed_bicubic(), [0.0, 1.0], [-0.3, 0.3]),
        (nurbs_sphere(), [-2.5, 2.5], [-2.5, 2.5]),
        (native_sphere(), [-2.5, 2.5], [-2.5, 2.5]),
        (wavy_prism(8), [-6.0, 6.0], [-1.0, 1.0]),
        (cube(), [-0.5, 1.5], [-0.5, 1.5]),
    ];
    for (brep, xy, z) in models {
        let brep = PreparedBrep::new(brep);
        let size = brep.size();
        let (mut cheap, mut dear) = (0, 0);
        for length in [1e-9, 1e-4, 1e-3, 1e-2, 0.1] {
            let mut witness = Witness::default();
            let mut at = Point3::from([xy, xy, z].map(|[a, b]| random.between(a, b)));
            for _ in 0..60 {
                let probe = Probe::Sphere(Sphere::new(at, 0.01 * size).unwrap());
                let [warm, cold] = must_agree(&brep, &probe, &mut witness);
                (cheap, dear) = (cheap + warm, dear + cold);
                at += random.direction() * (size * length);
            }
        }
        assert!(cheap <= dear, "{cheap} {dear}");
    }
}

/// About a focal point f64 sees noise alone: parts put aside for that are known too.
#[test]
fn noise_is_not_left_out() {
    let mut random = Random::new(47);
    let searched = Shortcuts {
        recognition: false,
        ..Shortcuts::default()
    };
    for (surface, shortcuts) in [
        (sphere(), Shortcuts::default()),
        (sphere(), searched),
        (octant(), searched),
    ] {
        let brep = PreparedBrep::with_shortcuts(as_nurbs(&surface), shortcuts);
        for length in [1e-16, 1e-13, 1e-10, 1e-7] {
            let mut witness = Witness::default();
            for _ in 0..20 {
                let at = Point3::from(random.direction() * length);
                let probe = Probe::Sphere(Sphere::new(at, 2.0).unwrap());
                must_agree(&brep, &probe, &mut witness);
            }
        }
    }
}

/// What is left out because the answer is narrow enough without it still counts in its lower end.
#[test]
fn coarse_answers_hold_the_truth() {
    let mut random = Random::new(59);
    let mut workspace = Workspace::default();
    for brep in [bicubic(), trimmed_bicubic(), wavy_prism(8)] {
        let brep = PreparedBrep::new(brep);
        let size = brep.size();
        for share in [1e-1, 1e-2, 1e-3] {
            let coarse = Options {
                accuracy: Accuracy::Length(share * size),
                ..options()
            };
            let mut witness = Witness::default();
            let mut at = Point3::new(0.4, 0.5, 0.2);
            for _ in 0..100 {
                let probe = Probe::Sphere(Sphere::new(at, 0.01 * size).unwrap());
                let truth = contact(&brep, &probe, &options(), &mut workspace);
                let told = contact_from(&brep, &probe, &mut witness, &coarse, &mut workspace);
                let (a, b) = (truth.separation.bounds, told.separation.bounds);
                assert!(a.lo <= b.hi && b.lo <= a.hi, "{truth:?} {told:?}");
                assert!(b.width() <= share * size);
                at += random.direction() * (0.5 * share * size);
            }
        }
    }
}

/// What a witness knows hangs on no options, and on no question but a ball's.
#[test]
fn whatever_was_asked_before() {
    let mut random = Random::new(53);
    for brep in [bicubic(), trimmed_bicubic(), nurbs_sphere(), wavy_prism(8)] {
        let brep = PreparedBrep::new(brep);
        let mut workspace = Workspace::default();
        let mut witness = Witness::default();
        let mut at = Point3::new(0.4, 0.5, 0.2);
        for k in 0..80 {
            let other = match k % 4 {
                0 => Options {
                    accuracy: Accuracy::Length(1e-2),
                    ..options()
                },
                1 => Options {
                    contacts: Contacts::All,
                    prediction: 0.01,
                    ..Options::default()
                },
                2 => Options {
                    node_budget: 3,
                    ..options()
                },
                _ => Options {
                    contacts: Contacts::None,
                    ..options()
                },
            };
            let aside = at + random.direction() * 1e-2;
            let probe = if k % 5 == 4 {
                Probe::HalfSpace(HalfSpace::new(Vector3::z(), 0.0).unwrap())
            } else {
                Probe::Sphere(Sphere::new(aside, 0.01).unwrap())
            };
            contact_from(&brep, &probe, &mut witness, &other, &mut workspace);
            let probe = Probe::Sphere(Sphere::new(at, 0.01).unwrap());
            must_agree(&brep, &probe, &mut witness);
            at += random.direction() * 1e-3;
        }
    }
}

/// What one BREP taught is not believed of another.
#[test]
fn a_witness_of_another_brep_is_none() {
    let [near, far] = [bicubic(), cube()].map(PreparedBrep::new);
    let mut witness = Witness::default();
    let probe = Probe::Sphere(Sphere::new(Point3::new(0.4, 0.6, 0.2), 0.01).unwrap());
    for brep in [&near, &far, &near, &far] {
        must_agree(brep, &probe, &mut witness);
    }
}

#[test]
fn a_useless_hint_does_no_harm() {
    let mut random = Random::new(37);
    for brep in [bicubic(), nurbs_sphere(), native_sphere(), cube()] {
        let brep = PreparedBrep::new(brep);
        let mut workspace = Workspace::default();
        let ball = |p: Point3<f64>| Probe::Sphere(Sphere::new(p, 0.1).unwrap());
        for _ in 0..30 {
            let [a, b] = [0, 1].map(|_| Vector3::from_fn(|_, _| random.between(-1.0, 2.0)));
            // Anywhere else: the nearest point of another place.
            let last = contact(&brep, &ball(a.into()), &options(), &mut workspace).contacts[0];
            must_agree(&brep, &ball(b.into()), &mut Witness::at(&last));
            let n = Probe::HalfSpace(HalfSpace::new(b.normalize(), 0.0).unwrap());
            must_agree(&brep, &n, &mut Witness::at(&last));
            // Of another model: no such face, no such parameters.
            let nonsense = [
                Contact { face: 1000, ..last },
                Contact {
                    uv: Point2::new(f64::NAN, 0.5),
                    ..last
                },
                Contact {
                    uv: Point2::new(1e300, -7.0),
                    ..last
                },
            ];
            for last in nonsense {
                must_agree(&brep, &ball(b.into()), &mut Witness::at(&last));
            }
        }
    }
}

/// A ridge between two patches that one trim crosses, under a bowl: the ball comes down from the bowl, next to which its last foot was, until the ridge is nearer. `f` is convex on either patch
/// and has no critical point there; nor is it monotone, for below `y = 0.2` the ridge is a valley.
#[test]
fn a_ridge_within_a_trim() {
    let mut b = BrepBuilder::new();
    let point = |x: f64, y: f64, z: f64| Vector4::new(x, y, z, 1.0);
    let slope = |y: f64| -0.15 * (y - 0.2);
    let ridge = [0.0, 0.5, 1.0]
        .map(|x| [0.0, 1.0].map(|y| point(x, y, if x == 0.5 { 0.0 } else { slope(y) })));
    let knots = [vec![0.0, 0.0, 0.5, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
    let ridge = NurbsSurface::new([1, 1], [3, 2], ridge.concat(), knots).unwrap();
    // z = 2.2 + 0.4 ((x - 0.5)^2 + (y - 0.5)^2), by its blossom.
    let one = |a: f64, b: f64| 0.4 * (a - 0.5) * (b - 0.5);
    let ends = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let bowl = ends.map(|[a, b]| {
        ends.map(|[c, d]| point(0.5 * (a + b), 0.5 * (c + d), 2.2 + one(a, b) + one(c, d)))
    });
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let bowl = NurbsSurface::new([2, 2], [3, 3], bowl.concat(), [knots.clone(), knots]).unwrap();
    let unit = Interval::new(0.0, 1.0).unwrap();
    for (surface, corners) in [
        (
            ridge,
            [[0.05, 0.02], [0.97, 0.04], [0.94, 0.96], [0.06, 0.98]],
        ),
        (bowl, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
    ] {
        let surface = Surface::Nurbs(surface);
        let places = corners.map(|[x, y]| surface.point(x, y));
        let vertices = places.map(|p| b.vertex(p));
        let side = |i: usize| TrimSpec {
            vertices: [vertices[i], vertices[(i + 1) % 4]],
            curve: Curve::Line(
                Line::new(corners[i].into(), corners[(i + 1) % 4].into(), unit).unwrap(),
            ),
            edge: None,
        };
        let sides = (0..4).map(side).collect();
        b.face_with_trims(surface.clone(), vec![sides]).unwrap();
    }
    let brep = PreparedBrep::new(b.build().unwrap());
    for aside in [0.0, 0.003, -0.01] {
        let mut witness = Witness::default();
        let mut feet = 0;
        for step in 0..200 {
            let z = 1.105 - 0.0005 * f64::from(step);
            let center = Point3::new(0.5 + aside, 0.6, z);
            let probe = Probe::Sphere(Sphere::new(center, 0.0).unwrap());
            let (warm, _) = agreed(&brep, &probe, &mut witness);
            if z < 1.09 {
                feet += 1;
                // Two roundings each, of numbers near 1.
                let off = warm.separation.value - aside.hypot(z);
                assert!(off.abs() <= 4.0 * f64::EPSILON, "{center} {off:e}");
            }
        }
        assert!(feet > 90);
    }
}
