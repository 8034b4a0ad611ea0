//! Balls against one native sphere, or a part of it: the formula's answers against those of the search on patches.

use crate::scenes::{Random, polygon_face, with_and_without_formulas};
use feeler::brep::Brep;
use feeler::numeric::{Dd, Interval};
use feeler::nurbs::{Arc, Curve, Revolution, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, LineKind, LineProbe, Options, Probe, Sphere, Workspace, contact, line,
};
use nalgebra::{Point2, Point3, Rotation3, Vector3};
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

/// How far a profile reaches past a pole, as an angle: half of what a hole about a pole may be of the radius, 2^-24.
const PAST: f64 = 1.0 / (1u64 << 25) as f64;

/// A part of the unit sphere about the origin that goes past the pole by `PAST`: its azimuths are half a radian at most to either side of `x`,
/// and past the pole it is on the other side of the axis. Its frame is exact.
fn past_the_pole(transposed: bool) -> Brep {
    let latitudes = [-1.0, FRAC_PI_2 + PAST];
    let frame = Rotation3::identity();
    sphere(
        Point3::origin(),
        1.0,
        frame,
        latitudes,
        [-0.5, 0.5],
        transposed,
    )
}

/// Up along the axis, through a point so far from it.
fn beside_the_axis(x: f64) -> LineProbe {
    LineProbe {
        origin: Point3::new(x, 0.0, 0.5),
        direction: Vector3::z(),
        kind: LineKind::Ray,
    }
}

/// What a profile reaches past the axis stands half a turn off its azimuths: it is there all the same, for a ray and for a ball.
#[test]
fn what_is_past_a_pole_is_there() {
    // Of a ball's centre from the sphere. The border is farther from the foot than 2^-30, by `PAST sin(1/2) / 8` at least, so its distance is greater by
    // 2^-60 / (2 GAP) = 2^-41: far more than bounds are wide, 2^-52 of the gap.
    const GAP: f64 = 1.0 / (1u64 << 20) as f64;
    let slack = Dd::from(FINE);
    let full = Options {
        accuracy: Accuracy::Full,
        prediction: f64::INFINITY,
        ..Options::default()
    };
    for transposed in [false, true] {
        let brep = PreparedBrep::new(past_the_pole(transposed));
        let mut workspace = Workspace::default();
        for k in 1..8 {
            let x = -PAST * f64::from(k) / 8.0;
            let square = Dd::from(x) * Dd::from(x);

            let answer = line(&brep, &beside_the_axis(x), &full, &mut workspace);
            assert!(answer.undecided.is_none() && answer.hits.len() == 1, "{k}");
            let height = (Dd::ONE - square).sqrt();
            let (t, truth) = (answer.hits[0].t.bounds, height - Dd::from(0.5));
            let holds = Dd::from(t.lo) <= truth + slack && truth - slack <= Dd::from(t.hi);
            assert!(holds, "{k}: {t:?} {truth:?}");

            let z = 1.0 + GAP;
            let point = Sphere::new(Point3::new(x, 0.0, z), 0.0).unwrap();
            let answer = contact(&brep, &Probe::Sphere(point), &full, &mut workspace);
            let from_center = (square + Dd::from(z) * Dd::from(z)).sqrt();
            let (s, truth) = (answer.separation.bounds, from_center - Dd::ONE);
            let holds = Dd::from(s.lo) <= truth + slack && truth - slack <= Dd::from(s.hi);
            assert!(holds, "{k}: {s:?} {truth:?}");
        }
    }
}

/// Past a pole profile parameters are not those of points as far from the axis before it: a face that is all past the pole is hit where it is.
#[test]
fn a_face_past_a_pole_is_hit() {
    let brep = past_the_pole(false);
    let surface = brep.surface(0);
    let [us, vs] = surface.domain();
    // From a quarter to three quarters of what is past the pole: parameters are linear in the angle from the pole, which is the distance from the
    // axis but for its cube.
    let past = vs.length() * PAST / (1.0 + FRAC_PI_2 + PAST);
    let [low, high] = [0.75, 0.25].map(|part| vs.end - part * past);
    let corners = [
        [us.start, low],
        [us.end, low],
        [us.end, high],
        [us.start, high],
    ];
    let brep = polygon_face(surface, &corners.map(|[u, v]| Point2::new(u, v)));
    let mut workspace = Workspace::default();
    for k in [1, 3, 4, 5, 7] {
        let probe = beside_the_axis(-PAST * f64::from(k) / 8.0);
        let answer = line(&brep, &probe, &Options::default(), &mut workspace);
        let is_on = (3..=5).contains(&k);
        assert!(answer.undecided.is_none(), "{k}");
        assert_eq!(answer.hits.len(), usize::from(is_on), "{k}");
    }
}
