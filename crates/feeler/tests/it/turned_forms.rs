//! Balls and half-spaces against tori, cylinders and cones in frames that are off by roundings: what formulas and the surface's own points say, against the search
//! on patches.

use crate::scenes::{Random, with_and_without_formulas};
use feeler::brep::Brep;
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve, Line, Revolution, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, HalfSpace, LineKind, LineProbe, Options, Probe, Sphere, Workspace, contact, evaluate,
    line,
};
use nalgebra::{Point2, Point3, Rotation3, Vector3};
use std::f64::consts::TAU;

/// A hit's parameters are off by the twist of a frame at most, some hundred roundings, and by those of points up to 30 from the origin.
const PLACED: f64 = 1e-12;

#[derive(Clone, Copy)]
enum Kind {
    Torus,
    Cylinder,
    Cone,
}

/// A part of a surface about an axis through a point: turned by `turn`, not by a whole turn.
fn surface(
    kind: &Kind,
    center: Point3<f64>,
    frame: &Rotation3<f64>,
    turn: f64,
    transposed: bool,
) -> Brep {
    let interval = |a: f64, b: f64| Interval::new(a, b).unwrap();
    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|v| frame * v);
    let at = |a: f64, h: f64| center + x * a + z * h;
    let profile = match kind {
        Kind::Torus => Curve::Arc(
            Arc::new(Arc {
                center: at(3.0, 0.25),
                x,
                y: z,
                z: -y,
                radius: 0.75,
                angle: interval(-2.0, 3.0),
                domain: interval(1.0, 2.0),
            })
            .unwrap(),
        ),
        Kind::Cylinder | Kind::Cone => {
            let top = if matches!(kind, Kind::Cone) { 0.5 } else { 2.0 };
            Curve::Line(Line {
                from: at(2.0, -1.0),
                to: at(top, 3.0),
                domain: interval(0.0, 7.0),
            })
        }
    };
    let turned = Revolution {
        origin: center,
        axis: z,
        angle: interval(0.5, 0.5 + turn),
        angle_domain: interval(-1.0, 2.0),
        profile,
        transposed,
    };
    Brep::from_surface(Surface::Revolution(Revolution::new(turned).unwrap())).unwrap()
}

/// One of the kinds in some frame, with formulas and without.
fn part(random: &mut Random, round: usize) -> [PreparedBrep; 2] {
    let kind = [Kind::Torus, Kind::Cylinder, Kind::Cone][round % 3];
    let center = Point3::from(random.direction() * random.between(0.0, 20.0));
    let frame = Rotation3::new(random.direction() * random.between(0.1, 3.0));
    let turn = if round.is_multiple_of(2) { TAU } else { 4.0 };
    let brep = surface(&kind, center, &frame, turn, round % 4 < 2);
    with_and_without_formulas(brep)
}

fn full() -> Options {
    Options {
        accuracy: Accuracy::Full,
        prediction: f64::INFINITY,
        ..Options::default()
    }
}

#[test]
fn values_are_full_without_the_search() {
    let mut random = Random::new(37);
    let (mut by_formula, mut all) = (0, 0);
    for round in 0..18 {
        let [brep, searched] = part(&mut random, round);
        let full = full();
        let (mut one, mut other) = (Workspace::default(), Workspace::default());
        for k in 0..24 {
            // Next to the surface, and anywhere.
            let s = brep.brep().surface(0);
            let [u, v] = s.domain();
            let on = s.point(
                u.lerp(random.between(0.0, 1.0)),
                v.lerp(random.between(0.0, 1.0)),
            );
            let off = 10f64.powf(random.between(-6.0, 0.5));
            let q = on + random.direction() * off;
            let probe = if k % 4 == 3 {
                Probe::HalfSpace(HalfSpace::new(random.direction(), -60.0).unwrap())
            } else {
                Probe::Sphere(Sphere::new(q, 0.25).unwrap())
            };
            let a = contact(&brep, &probe, &full, &mut one);
            let b = contact(&searched, &probe, &full, &mut other);
            let (x, y) = (a.separation.bounds, b.separation.bounds);
            assert!(x.lo <= y.hi && y.lo <= x.hi, "{probe:?}: {x:?} {y:?}");
            assert!(a.undecided.is_none(), "{probe:?}: {x:?}");
            all += 1;
            by_formula += usize::from(one.work().nodes < 3);
        }
    }
    assert!(
        20 * by_formula > 19 * all,
        "{by_formula} of {all} by formula"
    );
}

/// Balls that touch such a surface, and half-spaces on tori: of separations of 1e-16 the last digits, too.
#[test]
fn what_touches_is_told_without_the_search() {
    let mut random = Random::new(41);
    let (mut by_formula, mut all) = (0, 0);
    for round in 0..18 {
        let [brep, searched] = part(&mut random, round);
        let full = full();
        let (mut one, mut other) = (Workspace::default(), Workspace::default());
        for k in 0..12 {
            let s = brep.brep().surface(0);
            let [u, v] = s.domain();
            let [u, v] = [u, v].map(|d| d.lerp(random.between(0.05, 0.95)));
            let on = evaluate(&brep, 0, Point2::new(u, v)).unwrap();
            let normal = on.du.cross(&on.dv).normalize();
            // On either side; nearer than where the next sheet of any of these is as near.
            let off = 10f64.powf(random.between(-6.0, -0.7));
            let off = if k % 2 == 0 { off } else { -off };
            let q = on.point + normal * off;
            let probe = Probe::Sphere(Sphere::new(q, off.abs()).unwrap());
            let a = contact(&brep, &probe, &full, &mut one);
            let b = contact(&searched, &probe, &full, &mut other);
            let (x, y) = (a.separation.bounds, b.separation.bounds);
            assert!(x.lo <= y.hi && y.lo <= x.hi, "{probe:?}: {x:?} {y:?}");
            assert!(x.hi < 1e-14, "{probe:?}: {x:?}");
            assert!(a.undecided.is_none(), "{probe:?}: {x:?}");
            all += 1;
            by_formula += usize::from(one.work().nodes < 3);
        }
    }
    assert!(
        20 * by_formula > 19 * all,
        "{by_formula} of {all} by formula"
    );
}

/// Lines through tori, turned and not: each hit that the search proves, and no other.
#[test]
fn lines_through_tori() {
    let mut random = Random::new(41);
    let (mut counts, mut lost) = ([0; 5], 0);
    for round in 0..12 {
        let center = Point3::from(random.direction() * random.between(0.0, 20.0));
        let frame = match round % 3 {
            0 => Rotation3::identity(),
            _ => Rotation3::new(random.direction() * random.between(0.1, 3.0)),
        };
        let turn = if round % 2 == 0 { TAU } else { 4.0 };
        let brep = surface(&Kind::Torus, center, &frame, turn, round % 4 < 2);
        let [brep, searched] = with_and_without_formulas(brep);
        let (mut one, mut other) = (Workspace::default(), Workspace::default());
        for k in 0..60 {
            let s = brep.brep().surface(0);
            let [u, v] = s.domain();
            let mut on = || {
                s.point(
                    u.lerp(random.between(0.0, 1.0)),
                    v.lerp(random.between(0.0, 1.0)),
                )
            };
            let (a, b) = (on(), on());
            let d = match k % 4 {
                // Through two points; along an axis; nearly a tangent.
                0 | 1 => b - a,
                2 => Vector3::from_fn(|c, _| f64::from(u8::from(c == k / 4 % 3))),
                _ => {
                    let n = (a - center).cross(&random.direction()).normalize();
                    n + random.direction() * 10f64.powf(random.between(-6.0, 0.0))
                }
            };
            let from = a - d * random.between(0.0, 2.0);
            let probe = LineProbe {
                origin: from,
                direction: d,
                kind: LineKind::Line,
            };
            let x = line(&brep, &probe, &Options::default(), &mut one);
            let y = line(&searched, &probe, &Options::default(), &mut other);
            if x.undecided.is_some() || y.undecided.is_some() {
                lost += usize::from(y.undecided.is_none());
                continue;
            }
            assert_eq!(x.hits.len(), y.hits.len(), "{probe:?}");
            for (x, y) in x.hits.iter().zip(&y.hits) {
                assert!(
                    x.t.bounds.lo <= y.t.bounds.hi && y.t.bounds.lo <= x.t.bounds.hi,
                    "{probe:?}: {x:?} {y:?}"
                );
                let off = (s.point(x.uv.x, x.uv.y) - x.point).norm();
                assert!(off < PLACED, "{probe:?}: {off:e}");
            }
            counts[x.hits.len().min(4)] += 1;
        }
    }
    // A formula may not fall short where the search does not.
    assert_eq!(lost, 0);
    assert!(counts[1..].iter().all(|n| *n > 20), "{counts:?}");
}
