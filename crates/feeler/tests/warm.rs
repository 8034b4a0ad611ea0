//! A warm start is a seed: it changes the work, not the truth of an answer.

#[path = "scenes/mod.rs"]
mod scenes;

use feeler::prepare::PreparedBrep;
use feeler::query::{Contact, HalfSpace, Options, Probe, Sphere, Workspace, contact, contact_from};
use nalgebra::{Point2, Point3, Vector3};
use scenes::{Random, bicubic, cube, native_sphere, nurbs_sphere};

fn options() -> Options {
    Options {
        prediction: f64::INFINITY,
        ..Options::default()
    }
}

/// The answers with and without a hint must be as narrow, and both hold the truth: so they meet.
fn must_agree(brep: &PreparedBrep, probe: &Probe, last: &Contact) -> [usize; 2] {
    let mut workspace = Workspace::default();
    let cold = contact(brep, probe, &options(), &mut workspace);
    let dear = workspace.work().nodes;
    let warm = contact_from(brep, probe, last, &options(), &mut workspace);
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
    [cheap, dear]
}

#[test]
fn along_a_path() {
    let mut random = Random::new(31);
    for (brep, radius) in [(bicubic(), 0.05), (nurbs_sphere(), 2.0), (cube(), 0.1)] {
        let brep = PreparedBrep::new(brep);
        let mut workspace = Workspace::default();
        let (mut cheap, mut dear) = (0, 0);
        for _ in 0..10 {
            let from = Vector3::from_fn(|_, _| random.between(0.1, 0.9));
            let step = random.direction() * 1e-3;
            let at = |k: f64| Probe::Sphere(Sphere::new((from + step * k).into(), radius).unwrap());
            let mut last = contact(&brep, &at(0.0), &options(), &mut workspace).contacts[0];
            for k in 1..20 {
                let probe = at(f64::from(k));
                let [warm, cold] = must_agree(&brep, &probe, &last);
                (cheap, dear) = (cheap + warm, dear + cold);
                let next = contact_from(&brep, &probe, &last, &options(), &mut workspace);
                last = next.contacts[0];
            }
        }
        assert!(cheap <= dear, "{cheap} {dear}");
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
            must_agree(&brep, &ball(b.into()), &last);
            let n = Probe::HalfSpace(HalfSpace::new(b.normalize(), 0.0).unwrap());
            must_agree(&brep, &n, &last);
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
                must_agree(&brep, &ball(b.into()), &last);
            }
        }
    }
}
