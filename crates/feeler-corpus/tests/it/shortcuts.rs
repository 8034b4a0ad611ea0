//! Each shortcut of a prepared BREP off in turn: both ways prove what they say, so their enclosures must meet.

use feeler::prepare::{PreparedBrep, Shortcuts};
use feeler::query::*;
use feeler::trim::Side;
use feeler_corpus::Model;
use nalgebra::{Point2, Point3, Vector3};
use std::path::Path;

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

const MODELS: [&str; 3] = [
    "thesis/ball_joint_cavity.3dm",
    "thesis/ball_joint_cavity_nurbs.3dm",
    "thesis/cube_corner_sphere_cut_nurbs.3dm",
];

fn load(model: &str, shortcuts: Shortcuts) -> PreparedBrep {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models");
    let model = Model::load(&models.join(model), None).expect("a model of the corpus");
    let brep = model.breps.into_iter().next().expect("a BREP");
    PreparedBrep::with_shortcuts(brep, shortcuts)
}

fn each_off() -> [Shortcuts; 8] {
    let all = Shortcuts::ALL;
    [
        Shortcuts {
            closed_forms: false,
            ..all
        },
        Shortcuts {
            recognition: false,
            ..all
        },
        Shortcuts {
            boxes: false,
            ..all
        },
        Shortcuts {
            convex_leaves: false,
            ..all
        },
        Shortcuts {
            monotone_borders: false,
            ..all
        },
        Shortcuts {
            double_first: false,
            ..all
        },
        Shortcuts {
            trim_cells: false,
            ..all
        },
        Shortcuts {
            side_cells: false,
            ..all
        },
    ]
}

/// Points in and about a model, half of them next to its surfaces.
fn points(brep: &PreparedBrep, random: &mut Random) -> Vec<Point3<f64>> {
    let mut out = Vec::new();
    for face in 0..brep.brep().faces().len() {
        let surface = brep.brep().surface(face);
        let [u, v] = surface.domain();
        let foot = surface.point(u.lerp(random.unit()), v.lerp(random.unit()));
        let off = brep.size() * 10f64.powf(-9.0 * random.unit());
        out.push(foot + Vector3::from_fn(|_, _| off * (2.0 * random.unit() - 1.0)));
    }
    out
}

#[test]
fn distances_agree_without_each_shortcut() {
    let options = |brep: &PreparedBrep| Options {
        accuracy: Accuracy::Length(1e-9 * brep.size()),
        contacts: Contacts::None,
        ..Options::default()
    };
    for model in MODELS {
        let all = load(model, Shortcuts::ALL);
        let centers = points(&all, &mut Random(5));
        for shortcuts in each_off() {
            let without = load(model, shortcuts);
            for c in &centers {
                let probe = Probe::Sphere(Sphere::new(*c, 0.0).expect("a ball"));
                let ask = |brep: &PreparedBrep| {
                    contact(brep, &probe, &options(brep), &mut Workspace::default())
                };
                let (a, b) = (ask(&all), ask(&without));
                let [x, y] = [a.separation.bounds, b.separation.bounds];
                assert!(
                    x.lo <= y.hi && y.lo <= x.hi,
                    "{model} at {c}: {x:?}, and {y:?} with {shortcuts:?}"
                );
                assert!(
                    b.undecided.is_none(),
                    "{model} at {c}: {b:?} with {shortcuts:?}"
                );
            }
        }
    }
}

#[test]
fn lines_and_sides_agree_without_closed_forms_and_cells() {
    for model in MODELS {
        let all = load(model, Shortcuts::ALL);
        let mut random = Random(7);
        let centers = points(&all, &mut random);
        for shortcuts in [each_off()[0], each_off()[5]] {
            let without = load(model, shortcuts);
            for (i, c) in centers.iter().enumerate() {
                let along = Vector3::from_fn(|_, _| 2.0 * random.unit() - 1.0);
                let probe = LineProbe::new(*c, along, LineKind::Line).expect("a line");
                let ask = |brep: &PreparedBrep| {
                    let options = Options::default();
                    line(brep, &probe, &options, &mut Workspace::default())
                };
                let (a, b) = (ask(&all), ask(&without));
                if a.undecided.is_none() && b.undecided.is_none() {
                    assert_eq!(a.hits.len(), b.hits.len(), "{model} at {c} along {along}");
                }
                let [u, v] = all.brep().surface(i).domain();
                let uv = Point2::new(u.lerp(random.unit()), v.lerp(random.unit()));
                let of = |brep: &PreparedBrep| side(brep, i, uv).and_then(|s| s.side);
                assert_eq!(of(&all), of(&without), "{model} face {i} at {uv}");
                assert!(of(&all) != Some(Side::Boundary));
            }
        }
    }
}

/// What is counted grows as queries come near faces, and not when they come again.
#[test]
fn memory_is_what_was_made() {
    let brep = load(MODELS[1], Shortcuts::ALL);
    let ask = || {
        let ball = Sphere::new(Point3::new(0.01, 0.02, 0.03), 2.51).expect("a ball");
        let options = Options::default();
        contact(
            &brep,
            &Probe::Sphere(ball),
            &options,
            &mut Workspace::default(),
        )
    };
    let before = brep.bytes();
    ask();
    let after = brep.bytes();
    // The socket's 8 patches with 3 by 3 homogeneous points with bounds, twice as wide in double-double: at the least.
    assert!(after > before + 8 * 9 * 4 * (16 + 24), "{before} {after}");
    ask();
    assert_eq!(brep.bytes(), after);
    // 10 MB would be a leak: the file has 25 kB.
    assert!(after < 10_000_000, "{after}");
}

/// What queries had it make is given back in part or whole, and made again by the next: answers are the same bits.
#[test]
fn memory_is_given_back_and_made_again() {
    for model in MODELS {
        let mut brep = load(model, Shortcuts::ALL);
        let ask = |brep: &PreparedBrep| -> Vec<String> {
            let mut random = Random(7);
            let mut workspace = Workspace::default();
            let balls = (0..24).map(|_| {
                let center = Point3::from([0; 3].map(|_| 6.0 * random.unit() - 3.0));
                let ball = Sphere::new(center, 1.0).expect("a ball");
                let options = Options {
                    prediction: f64::INFINITY,
                    ..Options::default()
                };
                // Written out, a number says all of its bits.
                format!(
                    "{:?}",
                    contact(brep, &Probe::Sphere(ball), &options, &mut workspace)
                )
            });
            balls.collect()
        };
        let before = brep.bytes();
        let first = ask(&brep);
        let full = brep.bytes();
        assert!(full > before, "{model}");
        assert_eq!(
            brep.shrink_to(full),
            full,
            "{model}: nothing is to be given back"
        );
        let mut kept = full;
        for part in [0.9, 0.5, 0.2, 0.0] {
            let most = (part * full as f64) as usize;
            let held = brep.shrink_to(most);
            assert_eq!(held, brep.bytes(), "{model}");
            assert!(
                held <= most.max(before) && held <= kept,
                "{model} {part}: {held}"
            );
            assert_eq!(ask(&brep), first, "{model} {part}");
            kept = brep.bytes();
        }
        assert_eq!(brep.shrink_to(0), before, "{model}");
    }
}

/// The side of a centre that is far from the surface is taken from the middle of a cell, once many were asked: it is the side that a ray finds, and what was answered before is
/// answered again, bit for bit.
#[test]
fn kept_sides_are_those_of_rays() {
    let mut random = Random(11);
    let (mut compared, mut inner) = (0, 0);
    // Trims that leave their domains by roundings, along many sides of them.
    let strays = [
        "thesis/geneva4_wheel_nurbs.3dm",
        "thesis/shift_gate_nurbs.3dm",
    ];
    for model in MODELS.into_iter().chain(strays) {
        let brep = load(model, Shortcuts::ALL);
        assert!(brep.brep().is_closed(), "{model}");
        let options = Options {
            accuracy: Accuracy::Length(1e-9 * brep.size()),
            contacts: Contacts::None,
            ..Options::default()
        };
        let mut answers = Vec::new();
        for _ in 0..400 {
            // Between two points of the part's surface, or beyond one of them.
            let on = points(&brep, &mut random);
            let mix = |random: &mut Random| on[(random.unit() * on.len() as f64) as usize];
            let (a, b, t) = (mix(&mut random), mix(&mut random), random.unit());
            let center = a + (b - a) * (1.4 * t - 0.2);
            let ray = inside(&brep, center, &mut Workspace::default());
            let probe = Probe::Sphere(Sphere::new(center, 0.0).expect("a ball"));
            let answer = contact(&brep, &probe, &options, &mut Workspace::default());
            let bounds = answer.separation.bounds;
            answers.push((probe, format!("{answer:?}")));
            let (Some(side), false) = (ray.side, bounds.lo <= 0.0 && bounds.hi >= 0.0) else {
                continue;
            };
            assert_eq!(
                side == feeler::trim::Side::Inside,
                bounds.hi < 0.0,
                "{model} at {center}: {side:?}, {answer:?}"
            );
            compared += 1;
            inner += usize::from(bounds.hi < 0.0);
        }
        for (probe, first) in answers {
            let again = contact(&brep, &probe, &options, &mut Workspace::default());
            assert_eq!(format!("{again:?}"), first, "{model}");
        }
    }
    assert!(compared > 1500 && inner > 500, "{compared} {inner}");
}
