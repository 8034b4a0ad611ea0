//! Balls against one native sphere, or a part of it: the formula's answers against those of the search on patches.

use crate::scenes::{Random, with_and_without_formulas};
use feeler::brep::Brep;
use feeler::numeric::{Dd, Interval};
use feeler::nurbs::{Arc, Curve, Revolution, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, LineKind, LineProbe, Options, Probe, Sphere, Workspace, contact, line,
};
use nalgebra::{Point3, Rotation3, Vector3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// What is computed in double-double is off by no more.
const FINE: f64 = 1e-29;

/// A sphere about a centre, between two latitudes and turned by so much, its axes those of a rotation.
fn sphere(
    center: Point3<f64>,
    radius: f64,
    frame: Rotation3<f64>,
    latitudes: [f64; 2],
    turn: [f64; 2],
    transposed: bool,
) -> Brep {
    let interval = |[a, b]: [f64; 2]| Interval::new(a, b).unwrap();
    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|v| frame * v);
    let profile = Arc {
        center,
        x,
        y: z,
        z: -y,
        radius,
        angle: interval(latitudes),
        domain: interval([2.0, 5.0]),
    };
    let turned = Revolution {
        origin: center,
        axis: z,
        angle: interval(turn),
        angle_domain: interval([-1.0, 7.0]),
        profile: Curve::Arc(Arc::new(profile).unwrap()),
        transposed,
    };
    Brep::from_surface(Surface::Revolution(Revolution::new(turned).unwrap())).unwrap()
}

#[test]
fn formulas_agree_with_the_search() {
    let mut random = Random::new(29);
    let mut formulas = 0;
    for round in 0..36 {
        let center = Point3::from(random.direction() * random.between(0.0, 20.0));
        let radius = random.between(0.1, 5.0);
        let frame = match round % 3 {
            0 => Rotation3::identity(),
            // A quarter turn, exactly.
            1 => Rotation3::from_matrix_unchecked(nalgebra::Matrix3::new(
                0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0,
            )),
            _ => Rotation3::new(random.direction() * random.between(0.0, 3.0)),
        };
        let from = random.between(-20.0, 20.0);
        let (latitudes, turn) = match round % 4 {
            0 => ([-FRAC_PI_2, FRAC_PI_2], [0.0, TAU]),
            1 => ([-FRAC_PI_2, random.between(-1.0, 1.0)], [from, from + 3.0]),
            2 => ([-1.0, random.between(-0.5, 1.5)], [from, from + TAU]),
            _ => ([0.5, 1.0], [from, from + random.between(0.5, 6.0)]),
        };
        let brep = sphere(center, radius, frame, latitudes, turn, round % 2 == 1);
        let [brep, searched] = with_and_without_formulas(brep);
        let (mut one, mut other) = (Workspace::default(), Workspace::default());
        for k in 0..20 {
            let off = 10f64.powf(random.between(-9.0, 0.5)) * radius;
            let q = match k % 4 {
                // Next to the surface.
                3 => center + random.direction() * (radius + 1e-6 * off),
                _ => center + random.direction() * off,
            };
            let probe = Probe::Sphere(Sphere::new(q, random.between(0.0, 2.0)).unwrap());
            let accuracy = match k % 2 {
                0 => Accuracy::Full,
                _ => Accuracy::Length(1e-10 * radius),
            };
            let options = Options {
                accuracy,
                prediction: f64::INFINITY,
                ..Options::default()
            };
            let a = contact(&brep, &probe, &options, &mut one);
            let b = contact(&searched, &probe, &options, &mut other);
            let (x, y) = (a.separation.bounds, b.separation.bounds);
            assert!(x.lo <= y.hi && y.lo <= x.hi, "{probe:?}: {x:?} {y:?}");
            assert!(x.lo <= a.separation.value && a.separation.value <= x.hi);
            if one.work().nodes == 0 {
                formulas += 1;
                // Within psi of the foot squared distances grow by R D psi^2. The reach is told to a factor: by the formula
                // as by the search.
                let slack = 2f64.powi(-44) * brep.size();
                let slack = match accuracy {
                    Accuracy::Full => slack,
                    Accuracy::Length(a) => slack.max(a),
                };
                let from_center = (q - center).norm();
                let growth = slack * (2.0 * (from_center - radius).abs() + slack);
                let reach = (growth * radius / from_center).sqrt() / (2f64.powi(-12) * brep.size());
                if !(0.25..4.0).contains(&reach) {
                    assert_eq!(a.continuum, reach > 1.0, "{probe:?}");
                    assert_eq!(a.continuum, b.continuum, "{probe:?}");
                }
            }
            let (c, d) = (&a.contacts[0], &b.contacts[0]);
            let at = brep.brep().surface(0).point(c.uv.x, c.uv.y);
            assert!(
                (at - c.on_brep).norm() < 1e-13 * (radius + 20.0),
                "{probe:?}"
            );
            if let (Some(p), Some(r)) = (c.position_bound, d.position_bound) {
                let apart = (c.on_brep - d.on_brep).norm();
                assert!(apart <= p + r, "{probe:?}: {apart:e} {p:e} {r:e}");
            }
            if let (Some(p), Some(r)) = (c.normal_bound, d.normal_bound) {
                let apart = c.normal.cross(&d.normal).norm();
                assert!(c.normal.dot(&d.normal) > 0.0 && apart <= p + r, "{probe:?}");
            }
        }
    }
    // Those whose foot is in the part of the sphere that there is.
    assert!(formulas > 100, "{formulas} by the formula");
}

/// So near the centre that squares are lost, or all but: a contact is one all the same, be it of many.
#[test]
fn centres_next_to_the_sphere_s_own() {
    for radius in [1.0, 1e-60] {
        let latitudes = [-1.0, 1.0];
        let whole = [0.0, TAU];
        let frame = Rotation3::identity();
        let brep = sphere(Point3::origin(), radius, frame, latitudes, whole, false);
        let brep = PreparedBrep::new(brep);
        let mut workspace = Workspace::default();
        for exponent in -160..-20 {
            let off = Vector3::new(-0.6, 0.8, 0.01).normalize() * 10f64.powi(exponent);
            let probe =
                Probe::Sphere(Sphere::new(Point3::from(off * radius), 0.5 * radius).unwrap());
            for accuracy in [Accuracy::Full, Accuracy::Length(1e-9 * radius)] {
                let options = Options {
                    accuracy,
                    prediction: f64::INFINITY,
                    ..Options::default()
                };
                let answer = contact(&brep, &probe, &options, &mut workspace);
                assert!(answer.separation.bounds.contains(0.5 * radius));
                let c = &answer.contacts[0];
                assert!((c.normal.norm() - 1.0).abs() < 1e-12, "{exponent}");
                let from_center = c.on_brep.coords.norm() / radius;
                assert!(
                    (from_center - 1.0).abs() < 1e-12,
                    "{exponent}: {from_center}"
                );
                assert!(answer.continuum || c.position_bound.is_none_or(f64::is_finite));
            }
        }
    }
}

/// A sphere in a frame that is off by roundings, with both poles, is exactly one all the same: by formula to the last digit but for feet next to the poles.
#[test]
fn turned_spheres_with_poles_are_exact() {
    let mut random = Random::new(31);
    let mut counts = [0; 2];
    for round in 0..24 {
        let center = Point3::from(random.direction() * random.between(0.0, 20.0));
        let radius = random.between(0.1, 5.0);
        let frame = Rotation3::new(random.direction() * random.between(0.1, 3.0));
        let (latitudes, turn) = ([-FRAC_PI_2, FRAC_PI_2], [0.0, TAU]);
        let brep = sphere(center, radius, frame, latitudes, turn, round % 2 == 1);
        let [brep, searched] = with_and_without_formulas(brep);
        let axis = frame * Vector3::z();
        let full = Options {
            accuracy: Accuracy::Full,
            prediction: f64::INFINITY,
            ..Options::default()
        };
        let (mut one, mut other) = (Workspace::default(), Workspace::default());
        for k in 0..24 {
            let across = axis.cross(&random.direction()).normalize();
            let aside = match k % 3 {
                0 => random.between(0.1, 3.0),
                _ => 10f64.powf(random.between(-20.0, -1.0)),
            };
            let pole = if k % 2 == 0 { axis } else { -axis };
            let direction = pole * aside.cos() + across * aside.sin();
            let q = center + direction * (radius * random.between(0.2, 3.0));
            let ball = Sphere::new(q, 0.25).unwrap();
            let normal = feeler::query::HalfSpace::new(-direction.normalize(), -60.0);
            for probe in [Probe::Sphere(ball), Probe::HalfSpace(normal.unwrap())] {
                let a = contact(&brep, &probe, &full, &mut one);
                let b = contact(&searched, &probe, &full, &mut other);
                let (x, y) = (a.separation.bounds, b.separation.bounds);
                let is_known = x.width() <= 2.0 * f64::EPSILON * x.lo.abs().max(x.hi.abs());
                assert!(is_known && a.undecided.is_none(), "{probe:?}: {x:?}");
                assert!(x.lo <= y.hi && y.lo <= x.hi, "{probe:?}: {x:?} {y:?}");
                if let Probe::Sphere(_) = probe {
                    let off: [Dd; 3] = std::array::from_fn(|c| Dd::difference(q[c], center[c]));
                    let from_center = (off[0] * off[0] + off[1] * off[1] + off[2] * off[2]).sqrt();
                    let gap = from_center - Dd::from(radius);
                    let gap = if gap < Dd::ZERO { -gap } else { gap };
                    let truth = gap - Dd::from(0.25);
                    // Double-double is off by a few units, 1e-32, of lengths up to 30.
                    let slack = Dd::from(FINE);
                    let holds = Dd::from(x.lo) <= truth + slack && truth - slack <= Dd::from(x.hi);
                    assert!(holds, "{probe:?}: {x:?} {truth:?}");
                    if k % 3 == 0 {
                        counts[usize::from(one.work().nodes == 0)] += 1;
                    }
                }
            }
        }
    }
    let [searched, formulas] = counts;
    assert!(
        formulas > 20 * searched,
        "{formulas} by the formula, {searched} searched"
    );
}

/// Lines through a part of a turned sphere next to a pole, where azimuths are not those of the formula's model: a hit is one on the part that there is, and where it says.
#[test]
fn lines_next_to_the_poles_of_a_part() {
    let mut random = Random::new(43);
    let mut counts = [0; 2];
    for round in 0..12 {
        let center = Point3::from(random.direction() * random.between(0.0, 20.0));
        let frame = Rotation3::new(random.direction() * random.between(0.1, 3.0));
        let (latitudes, turn) = ([-FRAC_PI_2, FRAC_PI_2], [1.0, 3.0]);
        let brep = sphere(center, 2.0, frame, latitudes, turn, round % 2 == 1);
        let brep = PreparedBrep::new(brep);
        let mut workspace = Workspace::default();
        let [x, y, axis] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|v| frame * v);
        for k in 0..24 {
            // Inside of the part by an azimuth of 0.1 at least, or outside; the frame is off by some 1e-16, the centre by some 1e-15.
            let is_on = k % 2 == 0;
            let azimuth = match is_on {
                true => random.between(1.1, 2.9),
                false => random.between(3.1, 7.1),
            };
            let aside = 10f64.powf(random.between(-12.5, -7.0));
            let out = (x * azimuth.cos() + y * azimuth.sin()) * aside;
            let pole = if k % 4 < 2 { axis } else { -axis };
            let probe = LineProbe {
                origin: center + out + pole,
                direction: pole,
                kind: LineKind::Ray,
            };
            let answer = line(&brep, &probe, &Options::default(), &mut workspace);
            assert!(answer.undecided.is_none(), "{probe:?}");
            assert_eq!(answer.hits.len(), usize::from(is_on), "{probe:?}");
            for hit in &answer.hits {
                let at = brep.brep().surface(0).point(hit.uv.x, hit.uv.y);
                let off = (at - hit.point).norm();
                assert!(off < 1e-13, "{probe:?}: {off:e}");
            }
            counts[usize::from(is_on)] += 1;
        }
    }
    assert_eq!(counts, [144; 2]);
}
