//! Times of arrival against closed forms.

use crate::scenes::{bicubic, blocks, cube, native_sphere, nurbs_cylinder, nurbs_sphere};
use feeler::brep::Brep;
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, ArrivalAnswer, Contacts, Feature, HalfSpace, Motion, Options, Probe, Sphere,
    StraightWay, Undecided, Way, Workspace, arrival, arrival_along,
};
use nalgebra::{Point3, Vector3};

fn ask(brep: &Brep, probe: &Probe, velocity: [f64; 3], until: f64) -> ArrivalAnswer {
    let brep = PreparedBrep::new(brep.clone());
    let motion = Motion::new(velocity.into(), until).unwrap();
    let options = Options::default();
    arrival(&brep, probe, &motion, &options, &mut Workspace::default())
}

fn ball(center: [f64; 3], radius: f64) -> Probe {
    Probe::Sphere(Sphere::new(Point3::from(center), radius).unwrap())
}

const FOREVER: f64 = f64::INFINITY;

/// The ball arrives at this time, known as exactly as promised; the expected value is itself off by `rounding`.
#[track_caller]
fn arrives(answer: &ArrivalAnswer, size: f64, speed: f64, expected: f64, rounding: f64) {
    let time = answer.time.unwrap();
    let b = time.bounds;
    assert!(
        b.lo <= expected + rounding && expected - rounding <= b.hi,
        "{b:?} {expected}"
    );
    let width = size / (1u64 << 40) as f64 / speed;
    assert!(b.width() <= width, "{b:?}");
    assert!(b.contains(time.value));
    assert_eq!(answer.undecided, None);
    assert_eq!(answer.contacts.len(), 1);
    // It touches there, up to the rounding of where it is.
    let b = answer.contacts[0].separation.bounds;
    assert!(b.lo <= 0.0 && b.hi <= 64.0 * f64::EPSILON * size, "{b:?}");
}

#[test]
fn a_plane() {
    // Head on, aslant, and nearly along the face: a ball of radius 1/4 from 1 above the cube's top, whole numbers in binary.
    for along in [0.0, 1.0, 1.0 / 16.0, -0.125] {
        let from = [0.5 - 0.75 * along, 0.5, 2.0];
        let velocity = [along, 0.0, -1.0];
        let answer = ask(&cube(), &ball(from, 0.25), velocity, FOREVER);
        arrives(&answer, 1.0, velocity[0].hypot(1.0), 0.75, 0.0);
        assert_eq!(answer.contacts[0].feature, Feature::Face(1));
        assert_eq!(answer.contacts[0].normal, Vector3::z());
    }
    // At one in sixteen the way is long, and the face long enough.
    let velocity = [1.0 / 16.0, 0.0, -1.0 / 256.0];
    let answer = ask(&cube(), &ball([0.0, 0.5, 1.28125], 0.25), velocity, FOREVER);
    let speed = velocity[0].hypot(velocity[2]);
    arrives(&answer, 1.0, speed, 8.0, 0.0);
}

#[test]
fn spheres_and_cylinders() {
    // Radius 2.5 and 2.5: centres 5 apart at the touch, 3 beside and 4 before it.
    let probe = ball([10.0, 3.0, 0.0], 2.5);
    for brep in [native_sphere(), nurbs_sphere(), nurbs_cylinder()] {
        let answer = ask(&brep, &probe, [-2.0, 0.0, 0.0], FOREVER);
        // The NURBS are spheres to 2^-50.
        arrives(&answer, 8.0, 2.0, 3.0, 1e-14);
        let touch = Vector3::new(2.0, 1.5, 0.0);
        let off = answer.contacts[0].on_brep.coords - touch;
        assert!(off.norm() < 1e-10, "{off}");
    }
    // Within, from the centre.
    let answer = ask(
        &native_sphere(),
        &ball([0.0; 3], 2.0),
        [0.0, 0.0, 0.25],
        FOREVER,
    );
    arrives(&answer, 5.0, 0.25, 2.0, 0.0);
    // Along the cylinder, aslant: 3 and 4 of 5 beside the axis, while it climbs.
    let answer = ask(
        &nurbs_cylinder(),
        &ball([10.0, 3.0, -3.0], 2.5),
        [-2.0, 0.0, 1.0],
        FOREVER,
    );
    arrives(&answer, 8.0, 5f64.sqrt(), 3.0, 1e-14);
}

#[test]
fn grazing() {
    let brep = native_sphere();
    for gap in [1.0, 1e-3, 1e-5] {
        let probe = ball([10.0, 5.0 + gap, 0.0], 2.5);
        let answer = ask(&brep, &probe, [-1.0, 0.0, 0.0], FOREVER);
        assert_eq!(answer.time, None, "{gap}");
        assert_eq!(answer.undecided, None, "{gap}");
    }
    for depth in [1e-3, 1e-5, 1e-9] {
        let beside: f64 = 5.0 - depth;
        let answer = ask(
            &brep,
            &ball([10.0, beside, 0.0], 2.5),
            [-1.0, 0.0, 0.0],
            FOREVER,
        );
        // (5 - b)(5 + b): the difference is exact.
        let half = ((5.0 - beside) * (5.0 + beside)).sqrt();
        // The time is as uncertain as rounding, 16 epsilon of sums up to 25 and a little more, is over the slope there.
        let rounding = 32.0 * f64::EPSILON * 25.0 / (half / 5.0);
        let b = answer.time.unwrap().bounds;
        assert!(b.lo <= 10.0 - half + 4e-15 && 10.0 - half - 4e-15 <= b.hi);
        assert!(b.width() <= 5.0 / (1u64 << 40) as f64 + rounding, "{b:?}");
        assert_eq!(answer.contacts.len(), 1);
    }
    // Exactly: it touches at 10, and nothing proves it.
    let answer = ask(
        &brep,
        &ball([10.0, 5.0, 0.0], 2.5),
        [-1.0, 0.0, 0.0],
        FOREVER,
    );
    let time = answer.time.unwrap();
    assert!(time.bounds.lo > 9.9 && time.bounds.lo <= 10.0, "{time:?}");
    assert!(time.bounds.hi >= 10.0);
    assert!(answer.undecided.is_some());
}

#[test]
fn in_touch_away_and_out_of_time() {
    let probe = ball([0.5, 0.5, 1.25 - 1e-9], 0.25);
    for velocity in [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0; 3]] {
        let answer = ask(&cube(), &probe, velocity, 1.0);
        let time = answer.time.unwrap();
        assert_eq!([time.bounds.lo, time.bounds.hi], [0.0; 2]);
        assert_eq!(answer.contacts.len(), 1);
    }
    // Exactly in touch, which the kernel knows to the last digit, but not that it is none more.
    let answer = ask(
        &cube(),
        &ball([0.5, 0.5, 1.25], 0.25),
        [0.0, 0.0, -1.0],
        1.0,
    );
    let b = answer.time.unwrap().bounds;
    assert!(b.lo == 0.0 && b.hi < 1e-12, "{b:?}");
    let apart = ball([0.5, 0.5, 2.25], 0.25);
    // Tiny speeds and huge ones, too.
    for velocity in [
        [0.0, 0.0, 1.0],
        [1.0, 1e-200, 0.0],
        [0.0; 3],
        [0.0, 3e-160, 0.0],
        [1e50, 0.0, 0.0],
    ] {
        let answer = ask(&cube(), &apart, velocity, FOREVER);
        assert_eq!(answer.time, None, "{velocity:?}");
        assert_eq!(answer.undecided, None, "{velocity:?}");
    }
    let down = [0.0, 0.0, -1.0];
    assert_eq!(ask(&cube(), &apart, down, 0.875).time, None);
    let answer = ask(&cube(), &apart, down, 1.25);
    arrives(&answer, 1.0, 1.0, 1.0, 0.0);
}

#[test]
fn within_a_prediction() {
    let brep = PreparedBrep::new(cube());
    let motion = Motion::new(Vector3::new(0.0, 0.0, -1.0), FOREVER).unwrap();
    let probe = ball([0.5, 0.5, 2.25], 0.25);
    for (prediction, expected) in [(0.5, 0.5), (-0.125, 1.125)] {
        let options = Options {
            prediction,
            accuracy: Accuracy::Length(1e-6),
            ..Options::default()
        };
        let answer = arrival(&brep, &probe, &motion, &options, &mut Workspace::default());
        let b = answer.time.unwrap().bounds;
        assert!(b.contains(expected), "{b:?}");
        assert!(b.width() <= 1e-6, "{b:?}");
    }
    // A plane from 2 below, a quarter a unit of time.
    let motion = Motion::new(Vector3::new(0.0, 0.0, 0.25), FOREVER).unwrap();
    let plane = Probe::HalfSpace(HalfSpace::new(Vector3::z(), -2.0).unwrap());
    for (prediction, expected) in [(0.5, 6.0), (-0.5, 10.0), (2.0, 0.0)] {
        let options = Options {
            prediction,
            ..Options::default()
        };
        let answer = arrival(&brep, &plane, &motion, &options, &mut Workspace::default());
        let b = answer.time.unwrap().bounds;
        assert!(b.contains(expected) && b.width() < 1e-12, "{b:?}");
    }
}

#[test]
fn half_spaces() {
    // The ground rises to the cube's underside.
    let plane = |offset: f64| Probe::HalfSpace(HalfSpace::new(Vector3::z(), offset).unwrap());
    let up = [1.0, 0.0, 0.25];
    let answer = ask(&cube(), &plane(-2.0), up, FOREVER);
    arrives(&answer, 1.0, 0.25, 8.0, 0.0);
    assert_eq!(ask(&cube(), &plane(-2.0), up, 7.5).time, None);
    assert_eq!(
        ask(&cube(), &plane(-2.0), [1.0, 0.0, -0.25], FOREVER).time,
        None
    );
    assert_eq!(
        ask(&cube(), &plane(-2.0), [1.0, 0.0, 0.0], FOREVER).time,
        None
    );
    let there = ask(&cube(), &plane(0.5), [0.0, 0.0, -1.0], FOREVER);
    let b = there.time.unwrap().bounds;
    assert_eq!([b.lo, b.hi], [0.0; 2]);
}

/// Free until `lo`, touching at `hi`: asked of the kernel itself at times between, on a wavy face.
#[test]
fn the_way_is_free() {
    let brep = bicubic();
    let prepared = PreparedBrep::new(brep.clone());
    let mut random = crate::scenes::Random::new(7);
    let mut arrived = 0;
    for _ in 0..12 {
        let from = [random.between(0.2, 0.8), random.between(0.2, 0.8), 1.0];
        let to = [random.between(-0.1, 1.1), random.between(0.0, 1.0), 0.0];
        let velocity = [0, 1, 2].map(|c| to[c] - from[c]);
        let answer = ask(&brep, &ball(from, 0.05), velocity, 2.0);
        let free = answer.time.map_or(2.0, |t| t.bounds.lo);
        assert_ne!(answer.undecided, Some(Undecided::Budget));
        let separation = |time: f64| {
            let at = [0, 1, 2].map(|c| from[c] + velocity[c] * time);
            let options = Options::default();
            let mut workspace = Workspace::default();
            let probe = ball(at, 0.05);
            let found = feeler::query::contact(&prepared, &probe, &options, &mut workspace);
            found.separation.value
        };
        for k in 0..40 {
            assert!(separation(free * f64::from(k) / 40.0) > 0.0);
        }
        if let Some(time) = answer.time {
            assert!(separation(time.bounds.hi + 1e-9) <= 0.0);
            arrived += 1;
        }
    }
    assert!(arrived > 6);
}

/// Past an oblique face with a narrow gap, the ball never arrives, however long one waits: it is found from the plane between them.
#[test]
fn a_ball_that_leaves_askew_never_arrives() {
    let off = 2.601 / 2f64.sqrt();
    let leaving = ball([off, off, 0.0], 0.1);
    let sphere = native_sphere();
    assert_eq!(ask(&sphere, &leaving, [1.0, 1.0, 0.0], FOREVER).time, None);
}

/// Far away a centre is rounded by more than its distance is known: the contacts' separations hold for the true one.
#[test]
fn contacts_of_a_ball_from_afar() {
    // At the time t the separation is 1e6 - 1.25 - t / 10, with the tenth as it is stored.
    let probe = ball([0.5, 0.5, 1e6], 0.25);
    let answer = ask(&cube(), &probe, [0.0, 0.0, -0.1], FOREVER);
    let time = answer.time.unwrap().value;
    let exact = |x: f64| feeler::numeric::Dyadic::from_f64(x).unwrap();
    let truth = &(&exact(1e6) - &exact(1.25)) - &(&exact(time) * &exact(0.1));
    assert!(!answer.contacts.is_empty());
    for contact in &answer.contacts {
        let b = contact.separation.bounds;
        assert!(exact(b.lo) <= truth && truth <= exact(b.hi), "{b:?}");
    }
}

/// All queries of a search share the budget; the contacts at the end may spend as much again.
#[test]
fn the_budget_is_that_of_the_whole_search() {
    let brep = PreparedBrep::new(bicubic());
    let motion = Motion::new(Vector3::new(0.1, 0.05, -1.0), FOREVER).unwrap();
    let mut workspace = Workspace::default();
    for node_budget in [0, 5, 20, 80] {
        let options = Options {
            node_budget,
            ..Options::default()
        };
        let probe = ball([0.4, 0.5, 1.0], 0.05);
        let answer = arrival(&brep, &probe, &motion, &options, &mut workspace);
        // The last node of a query may open a handful of others before the count is looked at.
        let most = 2 * (node_budget + 16);
        let spent = workspace.work().nodes;
        assert!(spent <= most, "{spent} {node_budget}");
        // What is said holds all the same: without a budget it arrives where the next test's checks say.
        let full = arrival(&brep, &probe, &motion, &Options::default(), &mut workspace);
        let (some, all) = (answer.time.unwrap().bounds, full.time.unwrap().bounds);
        assert!(some.lo <= all.hi && all.lo <= some.hi, "{some:?} {all:?}");
    }
}

#[test]
fn predictions_that_are_no_lengths() {
    let brep = PreparedBrep::new(cube());
    let motion = Motion::new(Vector3::new(0.0, 0.0, -1.0), FOREVER).unwrap();
    let above = ball([0.5, 0.5, 2.25], 0.25);
    let ground = Probe::HalfSpace(HalfSpace::new(-Vector3::z(), -3.0).unwrap());
    for probe in [above, ground] {
        let ask = |prediction| {
            let options = Options {
                prediction,
                ..Options::default()
            };
            arrival(&brep, &probe, &motion, &options, &mut Workspace::default())
        };
        // However far is near enough; nothing is; and nothing is known.
        let b = ask(f64::INFINITY).time.unwrap().bounds;
        assert_eq!([b.lo, b.hi], [0.0; 2]);
        let never = ask(f64::NEG_INFINITY);
        assert_eq!((never.time, never.undecided), (None, None));
        let unknown = ask(f64::NAN);
        let b = unknown.time.unwrap().bounds;
        assert_eq!([b.lo, b.hi], [0.0, f64::INFINITY]);
        assert_eq!(unknown.undecided, Some(Undecided::Degenerate));
    }
}

/// The same of contacts: whatever they are asked with, an answer, and the separation unmoved.
#[test]
fn contacts_within_what_is_no_length() {
    for brep in [cube(), bicubic(), nurbs_sphere()] {
        let brep = PreparedBrep::new(brep);
        let plane = HalfSpace::new(-Vector3::z(), -3.0).unwrap();
        for probe in [ball([0.25, 0.5, 7.0], 0.25), Probe::HalfSpace(plane)] {
            for contacts in [Contacts::Deepest, Contacts::All] {
                let mut workspace = Workspace::default();
                let mut ask = |prediction| {
                    let options = Options {
                        prediction,
                        contacts,
                        accuracy: Accuracy::Length(1e-9),
                        ..Options::default()
                    };
                    feeler::query::contact(&brep, &probe, &options, &mut workspace)
                };
                let usual = ask(100.0);
                assert!(!usual.contacts.is_empty());
                assert_eq!(ask(f64::INFINITY).contacts[0], usual.contacts[0]);
                for none in [f64::NEG_INFINITY, f64::NAN] {
                    let found = ask(none);
                    assert!(found.contacts.is_empty(), "{none} {found:?}");
                    let (a, b) = (found.separation.bounds, usual.separation.bounds);
                    assert!(a.lo <= b.hi && b.lo <= a.hi);
                }
            }
        }
    }
}

/// A way that says of itself how it goes: round the z axis at a radius of 3, a turn in 2 pi.
struct Round;

impl Way for Round {
    fn center(&self, time: f64) -> (Point3<f64>, f64) {
        let (sin, cos) = time.sin_cos();
        let bound = 16.0 * f64::EPSILON;
        (Point3::new(3.0 * cos, 3.0 * sin, 0.5), bound)
    }
    fn least_time(&self, _: f64, length: f64) -> f64 {
        length / 3.0 * (1.0 - 4.0 * f64::EPSILON)
    }
    fn velocity(&self, time: f64) -> Vector3<f64> {
        let (sin, cos) = time.sin_cos();
        Vector3::new(-3.0 * sin, 3.0 * cos, 0.0)
    }
}

#[test]
fn a_ball_on_a_round_way() {
    // The cube's nearest points to the ring are those of the edge at (1, 1), or of faces: from 3 away on the x axis it comes to
    // the block x <= 0.5, y >= 2.5 from above: touch where 3 cos t = 0.5 + r, for y is beyond its lower edge there.
    let brep = PreparedBrep::new(blocks(&[[[-1.0, 2.5, 0.0], [0.5, 3.5, 1.0]]]));
    let radius = 0.25;
    let expected = (0.75f64 / 3.0).acos();
    let options = Options::default();
    let mut workspace = Workspace::default();
    let mut ask =
        |span: [f64; 2]| arrival_along(&brep, radius, &Round, span, &options, &mut workspace);
    let answer = ask([0.0, 6.0]);
    let b = answer.time.unwrap().bounds;
    assert!(
        b.lo <= expected + 1e-15 && expected - 1e-15 <= b.hi,
        "{b:?}"
    );
    assert!(b.width() <= 4.0 / (1u64 << 40) as f64, "{b:?}");
    assert_eq!(answer.undecided, None);
    assert_eq!(answer.contacts.len(), 1);
    assert!((answer.contacts[0].normal - Vector3::x()).norm() < 1e-9);
    // From a later time on, and until an earlier one.
    let later = ask([1.0, 6.0]).time.unwrap().bounds;
    assert!(later.lo <= b.hi && b.lo <= later.hi);
    assert_eq!(ask([0.0, 1.25]).time, None);
    assert_eq!(ask([4.0, 6.0]).time, None);
}

/// Two faces that are reached together are both told.
#[test]
fn all_contacts_on_arrival() {
    // Into the slot between two blocks, 2 wide: it hangs on the edges 0.75 above them, all but as near to either.
    let slot = blocks(&[
        [[-3.0, -5.0, 0.0], [-1.0, 5.0, 1.0]],
        [[1.0, -5.0, 0.0], [3.0, 5.0, 1.0]],
    ]);
    let beside = 1.0 / (1u64 << 42) as f64;
    let probe = ball([beside - 0.125, -0.5, 2.75], 1.25);
    let motion = Motion::new(Vector3::new(0.125, 0.25, -1.0), FOREVER).unwrap();
    let options = Options {
        contacts: Contacts::All,
        ..Options::default()
    };
    let brep = PreparedBrep::new(slot);
    let answer = arrival(&brep, &probe, &motion, &options, &mut Workspace::default());
    let b = answer.time.unwrap().bounds;
    assert!(b.lo <= 1.0 + 1e-12 && 1.0 - 1e-12 <= b.hi, "{b:?}");
    assert_eq!(answer.contacts.len(), 2, "{answer:?}");
}

/// Of a velocity that is no number, or beyond all, nothing is proven: not that the ball never arrives.
#[test]
fn velocities_that_are_no_numbers() {
    let brep = PreparedBrep::new(cube());
    for (center, velocity) in [
        ([0.5, 0.5, 2.0], [0.0, 0.0, f64::NEG_INFINITY]),
        ([3.0, 0.5, 0.5], [f64::NAN, 0.0, 0.0]),
        ([0.5, 0.5, 2.0], [0.0, 0.0, f64::NAN]),
        ([0.5, 0.5, 2.0], [f64::INFINITY, 0.0, -1.0]),
    ] {
        let way = StraightWay {
            center: Point3::from(center),
            center_bound: 0.0,
            velocity: Vector3::from(velocity),
            velocity_bound: 0.0,
        };
        let options = Options::default();
        let mut workspace = Workspace::default();
        let answer = arrival_along(&brep, 0.25, &way, [0.0, 1.0], &options, &mut workspace);
        assert!(answer.undecided.is_some(), "{velocity:?} {answer:?}");
        let time = answer.time.expect("from when on nothing is known").bounds;
        assert_eq!(time.lo, 0.0, "{velocity:?}");
    }
}
