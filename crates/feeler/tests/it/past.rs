//! Balls that touch at the start, and leave or go along what they touch: when they come to the rest, against closed forms and small steps.

use crate::scenes::{
    bicubic, blocks, native_sphere, nurbs_cylinder, nurbs_sphere, trimmed_bicubic,
};
use feeler::brep::{Brep, BrepBuilder};
use feeler::nurbs::{NurbsSurface, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, ArrivalAnswer, Contacts, Feature, Options, Probe, Sphere, StraightWay, Undecided,
    Way, Workspace, arrival_along, arrival_past, contact,
};
use nalgebra::{Point3, Vector3, Vector4};

const FOREVER: f64 = f64::INFINITY;

fn way(center: [f64; 3], velocity: [f64; 3]) -> StraightWay {
    StraightWay {
        center: Point3::from(center),
        center_bound: 0.0,
        velocity: Vector3::from(velocity),
        velocity_bound: 0.0,
    }
}

/// Asks with an allowance of a 128th of the radius.
fn ask(brep: &PreparedBrep, radius: f64, way: &dyn Way, until: f64) -> ArrivalAnswer {
    let (options, mut workspace) = (Options::default(), Workspace::default());
    let span = [0.0, until];
    arrival_past(
        brep,
        radius,
        way,
        span,
        radius / 128.0,
        &options,
        &mut workspace,
    )
}

/// The ball arrives at this time, known as exactly as promised.
#[track_caller]
fn arrives(answer: &ArrivalAnswer, size: f64, speed: f64, expected: f64) {
    let b = answer.time.expect("something is in the way").bounds;
    let rounding = 1e-14 * (1.0 + expected);
    assert!(
        b.lo <= expected + rounding && expected - rounding <= b.hi,
        "{b:?} {expected}"
    );
    assert!(b.width() <= size / (1u64 << 20) as f64 / speed, "{b:?}");
    assert_eq!(answer.undecided, None);
    assert_eq!(answer.contacts.len(), 1);
}

/// A plate, and two walls on it that are no part of its faces.
fn plate_and_walls() -> PreparedBrep {
    PreparedBrep::new(blocks(&[
        [[-8.0, -2.0, -1.0], [8.0, 2.0, 0.0]],
        [[4.0, -2.0, 0.0], [5.0, 2.0, 3.0]],
        [[-3.0, -2.0, 0.0], [-2.0, 2.0, 3.0]],
    ]))
}

#[test]
fn along_a_plate_to_a_wall() {
    let brep = plate_and_walls();
    let radius = 0.5;
    // In touch exactly, sunk in, and above it by less than anyone can tell.
    for sunk in [0.0, 1e-4, 1e-3, -1e-15] {
        let z = radius - sunk;
        // As deep in the wall as in the plate.
        let counts = radius - f64::max(sunk, 0.0);
        for [x, y] in [[1.0, 0.0], [0.25, 0.125], [1024.0, -512.0]] {
            let answer = ask(&brep, radius, &way([0.0, 0.0, z], [x, y, 0.0]), FOREVER);
            let gone = y.abs() * (4.0 - counts) / x;
            assert!(gone < 2.0, "it would fall off the plate");
            arrives(&answer, 16.0, x.hypot(y), (4.0 - counts) / x);
            let contact = &answer.contacts[0];
            assert!(matches!(contact.feature, Feature::Face(_)), "{contact:?}");
            assert!((contact.normal + Vector3::x()).norm() < 1e-2);
            assert!((contact.on_brep.x - 4.0).abs() < 1e-12);
            let answer = ask(&brep, radius, &way([0.0, 0.0, z], [-x, y, 0.0]), FOREVER);
            arrives(&answer, 16.0, x.hypot(y), (2.0 - counts) / x);
            // The time is up before.
            let until = (3.99 - counts) / x;
            let answer = ask(&brep, radius, &way([0.0, 0.0, z], [x, y, 0.0]), until);
            assert_eq!((answer.time, answer.undecided), (None, None));
        }
        for velocity in [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1e-3], [0.0; 3]] {
            let answer = ask(&brep, radius, &way([0.0, 0.0, z], velocity), FOREVER);
            assert_eq!(
                (answer.time, answer.undecided),
                (None, None),
                "{velocity:?}"
            );
        }
        // Straight down it is there.
        let answer = ask(
            &brep,
            radius,
            &way([0.0, 0.0, z], [0.0, 0.0, -1.0]),
            FOREVER,
        );
        let b = answer.time.unwrap().bounds;
        assert!(b.lo == 0.0 && b.hi < 1e-4, "{b:?}");
    }
}

/// The plane of the plate is left at once where the ball flies over a gap: what is beyond counts from its edge on, if the ball sinks.
#[test]
fn over_a_gap_to_an_edge() {
    let brep = PreparedBrep::new(blocks(&[
        [[-8.0, -2.0, -1.0], [0.0, 2.0, 0.0]],
        [[3.0, -2.0, -1.0], [8.0, 2.0, 0.25]],
    ]));
    // In touch with the plate, flying on level: the edge at x = 3 is 1/4 above it. The centre is 1/4 above the edge: 3 - sqrt(r^2 - 1/16).
    let answer = ask(&brep, 0.5, &way([-1.0, 0.0, 0.5], [2.0, 0.0, 0.0]), FOREVER);
    let reach = (0.25f64 - 0.0625).sqrt();
    arrives(&answer, 16.0, 2.0, (4.0 - reach) / 2.0);
    assert!(matches!(answer.contacts[0].feature, Feature::Edge(_)));
}

/// In a tube, along it: nothing is in the way, not even where the ball fits the tube; across it the ball is stopped before it is deeper than is
/// overlooked, and after the tube's wall has risen by half of that.
#[test]
fn in_a_tube() {
    let tube = 2.5;
    let brep = PreparedBrep::new(nurbs_cylinder());
    for radius in [1.0, 2.0, 2.4, 2.499, 2.5] {
        for sunk in [0.0, 1e-3] {
            let from = [0.0, radius + sunk - tube, 0.0];
            let answer = ask(&brep, radius, &way(from, [0.0, 0.0, 1.0]), FOREVER);
            assert_eq!(
                (answer.time, answer.undecided),
                (None, None),
                "{radius} {sunk}"
            );
        }
    }
    for radius in [1.0, 2.0] {
        let answer = ask(
            &brep,
            radius,
            &way([0.0, radius - tube, 0.0], [1.0, 0.0, 0.0]),
            1.0,
        );
        // A point at the height h above the lowest line is passed at r - h, and is sqrt(2 R h - h^2) away.
        let met = |h: f64| {
            let leg = |r: f64| (2.0 * r * h - h * h).sqrt();
            leg(tube) - leg(radius)
        };
        let most = radius / 128.0;
        let b = answer.time.unwrap().bounds;
        let slack = 8.0 / (1u64 << 20) as f64;
        assert!(b.lo >= met(0.5 * most) - slack, "{b:?}");
        assert!(b.hi <= met(most) + slack, "{b:?}");
        let depth = |x: f64| (tube - radius).hypot(x) + radius - tube;
        assert!(depth(b.hi) > 0.0 && depth(b.hi) <= most);
        // Straight up to the other side.
        let answer = ask(
            &brep,
            radius,
            &way([0.0, radius - tube, 0.0], [0.0, 2.0, 0.0]),
            9.0,
        );
        arrives(&answer, 8.0, 2.0, tube - radius);
    }
}

/// Away from a round part, in all directions that do not go into it; and out of a round hole that it fills.
#[test]
fn away_from_spheres() {
    let mut random = crate::scenes::Random::new(3);
    for sphere in [native_sphere(), nurbs_sphere()] {
        let brep = PreparedBrep::new(sphere);
        for _ in 0..10 {
            let n = random.direction();
            let side = n.cross(&random.direction()).normalize();
            let up = random.between(0.0, 1.0);
            let velocity: [f64; 3] = (side + n * up).into();
            for sunk in [0.0, 1e-3] {
                let from: [f64; 3] = (n * (3.0 - sunk)).into();
                let answer = ask(&brep, 0.5, &way(from, velocity), FOREVER);
                assert_eq!((answer.time, answer.undecided), (None, None));
            }
        }
        // The ball fills the hole: whichever way, it comes into the wall at once.
        let answer = ask(&brep, 2.5, &way([0.0; 3], [1.0, 0.0, 0.0]), 1.0);
        let b = answer.time.unwrap().bounds;
        assert!(b.lo < 1e-4 && b.hi < 1e-2, "{b:?}");
    }
}

/// Ways along a wavy sheet, on which the ball lies: by small steps it is never deeper than is overlooked before the time told, and in touch at it.
#[test]
fn along_waves() {
    let mut random = crate::scenes::Random::new(5);
    let mut arrived = 0;
    let sheets: [Brep; 2] = [bicubic(), trimmed_bicubic()];
    for k in 0..60 {
        let brep = PreparedBrep::new(sheets[k % 2].clone());
        let radius = [0.02, 0.05, 0.1][k % 3];
        let sunk = [0.0, 1e-4, 1e-3][k / 3 % 3];
        let (options, mut workspace) = (Options::default(), Workspace::default());
        let from = [random.between(0.3, 0.7), random.between(0.3, 0.7), 1.0];
        let down = way(from, [0.0, 0.0, -1.0]);
        let met = arrival_along(&brep, radius, &down, [0.0, 2.0], &options, &mut workspace);
        let Some(time) = met.time else { continue };
        let normal = met.contacts[0].normal;
        let start = down.center(time.value).0 - normal * sunk;
        let any = random.direction();
        let velocity = any - normal * any.dot(&normal).min(0.0);
        let go = way(start.into(), velocity.into());
        let answer = ask(&brep, radius, &go, 2.0);
        assert_eq!(answer.undecided, None, "{k}");
        let separation = |time: f64, workspace: &mut Workspace| {
            let probe = Sphere::new(start + velocity * time, radius).unwrap();
            let options = Options {
                contacts: Contacts::None,
                accuracy: Accuracy::Length(1e-12),
                ..Options::default()
            };
            let found = contact(&brep, &Probe::Sphere(probe), &options, workspace);
            found.separation.value
        };
        let first = separation(0.0, &mut workspace).min(0.0);
        let free = answer.time.map_or(2.0, |t| t.bounds.lo);
        for k in 0..=300 {
            let s = separation(free * f64::from(k) / 300.0, &mut workspace);
            assert!(s >= first - radius / 128.0 - 1e-11, "{s} {first}");
        }
        if let Some(time) = answer.time {
            let s = separation(time.bounds.hi, &mut workspace);
            assert!(s <= first + 1e-11, "{s} {first}");
            arrived += 1;
        }
    }
    assert!((15..60).contains(&arrived), "{arrived}");
}

/// Whatever the budget, what is said holds.
#[test]
fn with_little_to_spend() {
    let brep = plate_and_walls();
    let mut undecided = 0;
    for node_budget in [0, 1, 10, 30, 100, 100_000] {
        let options = Options {
            node_budget,
            ..Options::default()
        };
        let go = way([0.0, 0.0, 0.5], [1.0, 0.25, 0.0]);
        let mut workspace = Workspace::default();
        let span = [0.0, FOREVER];
        let answer = arrival_past(&brep, 0.5, &go, span, 0.01, &options, &mut workspace);
        let b = answer.time.unwrap().bounds;
        assert!(b.lo <= 3.5 && 3.5 <= b.hi + 1e-14, "{b:?}");
        undecided += usize::from(answer.undecided.is_some());
    }
    assert!((3..6).contains(&undecided), "{undecided}");
}

/// A way that is not straight, a centre in material, allowances that roundings take up, and what is no number: nothing is known, and that is said.
#[test]
fn what_is_not_known() {
    struct Bent;
    impl Way for Bent {
        fn center(&self, time: f64) -> (Point3<f64>, f64) {
            (Point3::new(time, 0.0, 0.5 + time * time), 1e-15)
        }
        fn least_time(&self, _: f64, length: f64) -> f64 {
            length / 8.0
        }
        fn velocity(&self, time: f64) -> Vector3<f64> {
            Vector3::new(1.0, 0.0, 2.0 * time)
        }
    }
    /// Straight, but nobody knows where it is once half of the time is over.
    struct Fading;
    impl Way for Fading {
        fn center(&self, time: f64) -> (Point3<f64>, f64) {
            let off = if time > 0.5 { f64::NAN } else { 0.0 };
            (Point3::new(time, 0.0, 0.5), off)
        }
        fn least_time(&self, _: f64, length: f64) -> f64 {
            length
        }
        fn velocity(&self, _: f64) -> Vector3<f64> {
            Vector3::x()
        }
        fn steady(&self) -> Option<(Vector3<f64>, f64)> {
            Some((Vector3::x(), 0.0))
        }
    }
    let brep = plate_and_walls();
    let mut workspace = Workspace::default();
    let options = Options::default();
    let far = way([0.0, 0.0, 0.5], [1.0, 0.0, 0.0]);
    // So slow that its speed has no digits.
    let slow = way([0.0, 0.0, 0.5], [5e-324, 5e-324, 0.0]);
    let deep = way([0.0, 0.0, -0.25], [1.0, 0.0, 0.0]);
    let lost = way([0.0, 0.0, 0.5], [f64::NAN, 0.0, 0.0]);
    let endless = way([0.0, 0.0, 0.5], [f64::INFINITY, 0.0, 0.0]);
    let cases: [(&dyn Way, f64, Undecided); 8] = [
        (&Fading, 0.01, Undecided::Degenerate),
        (&slow, 0.01, Undecided::Degenerate),
        (&Bent, 0.01, Undecided::Degenerate),
        (&deep, 0.01, Undecided::Degenerate),
        (&lost, 0.01, Undecided::Degenerate),
        (&endless, 0.01, Undecided::Degenerate),
        (&far, 1e-15, Undecided::Precision),
        (&far, f64::NAN, Undecided::Precision),
    ];
    for (way, allowance, why) in cases {
        let span = [0.0, 1.0];
        let found = arrival_past(&brep, 0.5, way, span, allowance, &options, &mut workspace);
        assert_eq!(found.undecided, Some(why), "{allowance}");
        let b = found.time.unwrap().bounds;
        assert_eq!([b.lo, b.hi], [0.0, FOREVER]);
    }
}

/// What is just ahead is not there at the start: on another side of the face that is touched, nearer than the way is asked for, where what is left behind
/// is looked at last.
#[test]
fn the_other_side_of_a_socket_is_not_there_yet() {
    let brep = PreparedBrep::new(nurbs_sphere());
    let mut workspace = Workspace::default();
    let options = Options {
        accuracy: Accuracy::Length(1e-4),
        ..Options::default()
    };
    let mut random = crate::scenes::Random::new(9);
    for k in 0..40 {
        let gap = [1e-5, 1e-6, 1e-8][k % 3];
        let n = random.direction();
        let radius = 2.5 - 0.5 * gap;
        let go = way((n * (-0.5 * gap)).into(), n.into());
        let span = [0.0, 1.0];
        let allowance = 0.02;
        let answer = arrival_past(
            &brep,
            radius,
            &go,
            span,
            allowance,
            &options,
            &mut workspace,
        );
        let b = answer.time.unwrap().bounds;
        // The NURBS is a sphere to 2^-50.
        let slack = 1e-12;
        assert!(b.lo <= gap + slack && gap <= b.hi + slack, "{b:?} {gap}");
        assert!(b.lo > 0.0, "{k} {b:?} {gap}");
        assert_eq!(answer.undecided, None);
    }
}

/// Squares of these speeds are below all numbers.
#[test]
fn at_a_tiny_speed() {
    let brep = plate_and_walls();
    for speed in [1e-200, 3e-160, 1e-290] {
        let go = way([0.0, 0.0, 0.5], [speed, 0.0, 0.0]);
        let answer = ask(&brep, 0.5, &go, FOREVER);
        let b = answer.time.expect("the wall").bounds;
        assert!(
            b.lo * speed <= 3.5 + 1e-12 && 3.5 <= b.hi * speed + 1e-12,
            "{b:?}"
        );
        assert!(b.width() * speed <= 1e-4, "{b:?}");
        // Aslant onto the plate, from 1 above it, where steps of what is free alone never end.
        let go = way([-1.0, 0.0, 1.5], [speed, 0.0, -0.5 * speed]);
        let (options, mut workspace) = (Options::default(), Workspace::default());
        let span = [0.0, FOREVER];
        let answer = arrival_along(&brep, 0.5, &go, span, &options, &mut workspace);
        assert_eq!(answer.undecided, None, "{speed}");
        let b = answer.time.expect("the plate").bounds;
        assert!(
            b.lo * speed <= 2.0 && 2.0 - 1e-12 <= b.hi * speed,
            "{speed} {b:?}"
        );
    }
}

/// A bicubic over the unit square, below z = 0.3, whose weights differ by up to 1e24, at random; and a plate at z = 2.
fn ill_weighted(random: &mut crate::scenes::Random) -> PreparedBrep {
    let mut net = Vec::new();
    for i in 0..16 {
        let w = 10f64.powf(random.between(-12.0, 12.0));
        let [x, y] = [i / 4, i % 4].map(|k| f64::from(k) / 3.0);
        let z = random.between(-0.3, 0.3);
        net.push(Vector4::new(x * w, y * w, z * w, w));
    }
    let knots = [[0.0; 4], [1.0; 4]].concat();
    let surface = NurbsSurface::new([3; 2], [4; 2], net, [knots.clone(), knots]).unwrap();
    let mut b = BrepBuilder::new();
    b.whole_surface(Surface::Nurbs(surface));
    let plate = [[-2.0, -2.0], [3.0, -2.0], [3.0, 3.0], [-2.0, 3.0]];
    let plate = plate.map(|[x, y]| b.vertex([x, y, 2.0]));
    b.planar_face(&plate).unwrap();
    PreparedBrep::new(b.build().unwrap())
}

/// Where nobody knows the start as exactly as was asked, it is not known how deep the ball may come into what it arrives at, however well the way to that is known.
#[test]
fn a_start_that_is_known_less_exactly_than_asked() {
    let mut random = crate::scenes::Random::new(77);
    let (radius, mut workspace) = (0.1, Workspace::default());
    let options = Options {
        accuracy: Accuracy::Length(1e-6),
        node_budget: 10_000,
        ..Options::default()
    };
    let mut arrived = 0;
    for _ in 0..8 {
        let brep = ill_weighted(&mut random);
        for _ in 0..20 {
            let [x, y] = [0; 2].map(|_| random.between(0.0, 1.0));
            let from = Point3::new(x, y, random.between(0.3, 0.4));
            let probe = Probe::Sphere(Sphere::new(from, radius).unwrap());
            let start = contact(&brep, &probe, &options, &mut workspace);
            if start.undecided != Some(Undecided::Precision) {
                continue;
            }
            let (go, span) = (way(from.into(), [0.0, 0.0, 1.0]), [0.0, 9.0]);
            // In touch it is known to be; as near as it was at the start, at the most.
            let most = start.separation.bounds.hi;
            let why = Some(Undecided::Precision);
            for (prediction, sought, why) in [(0.0, 0.0, None), (FOREVER, most, why)] {
                if start.separation.bounds.lo <= 0.0 {
                    continue;
                }
                let options = Options {
                    prediction,
                    ..options
                };
                let answer = arrival_past(&brep, radius, &go, span, 1e-3, &options, &mut workspace);
                assert_eq!(answer.undecided, why);
                let b = answer.time.expect("the plate").bounds;
                let time = 1.9 - from.z - sought;
                assert!(b.lo <= time + 1e-12 && time <= b.hi + 1e-12, "{b:?} {time}");
                assert!(b.width() <= 1e-6, "{b:?}");
                arrived += 1;
            }
        }
    }
    assert!(arrived > 0);
}

/// The start is known no better than it must be: in a socket that the ball all but fills, the last digits of its depth would take most of the nodes.
#[test]
fn the_start_leaves_the_budget_to_the_rest() {
    let brep = PreparedBrep::new(nurbs_sphere());
    // The ball touches below, and the socket's top is twice the difference of the radii above it.
    let least = 1.0 / f64::from(1 << 20);
    let go = way([0.0, 0.0, -least], [0.0, 0.0, 1.0]);
    let mut workspace = Workspace::default();
    let options = Options {
        node_budget: 100,
        accuracy: Accuracy::Length(1e-9),
        ..Options::default()
    };
    let span = [0.0, 1.0];
    let answer = arrival_past(
        &brep,
        2.5 - least,
        &go,
        span,
        1e-3,
        &options,
        &mut workspace,
    );
    assert_eq!(answer.undecided, None);
    // The NURBS is a sphere to 2^-50.
    let b = answer.time.unwrap().bounds;
    let slack = 1e-9 + 1e-14;
    assert!(
        b.lo <= 2.0 * least + slack && 2.0 * least - slack <= b.hi,
        "{b:?}"
    );
    assert!(b.width() <= 1e-9, "{b:?}");
}
