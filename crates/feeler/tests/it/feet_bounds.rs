//! What is proven of a contact's place: feet on faces, edges and vertices, whose true places are simple numbers.

use crate::scenes::blocks;
use feeler::brep::{Brep, BrepBuilder};
use feeler::numeric::{Dyadic, Interval};
use feeler::nurbs::{Curve3, Line, Revolution, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, Contact, ContactAnswer, Feature, HalfSpace, Options, Probe, Sphere, Workspace,
    contact,
};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

/// Of the box, along each axis; its planes are exactly there.
const FROM: [f64; 3] = [-1.0, -0.75, 0.125];
const TO: [f64; 3] = [1.25, 0.875, 2.0];

/// Bounds are narrower than this: thousands of roundings of coordinates below 4, far below the coarser accuracy of 1e-9.
const NARROW: f64 = 1e-12;

fn block() -> Brep {
    blocks(&[[FROM, TO]])
}

fn asked(brep: &PreparedBrep, probe: &Probe, accuracy: Accuracy) -> ContactAnswer {
    let options = Options {
        accuracy,
        prediction: f64::INFINITY,
        ..Options::default()
    };
    contact(brep, probe, &options, &mut Workspace::default())
}

fn exact(x: f64) -> Dyadic {
    Dyadic::from_f64(x).unwrap()
}

/// Whether the foot is as near to its true place as it claims: exactly.
fn is_near(c: &Contact, bound: f64, truth: &[f64; 3]) -> bool {
    let square = (0..3).fold(Dyadic::ZERO, |sum, k| {
        let off = &exact(c.on_brep[k]) - &exact(truth[k]);
        &sum + &(&off * &off)
    });
    square <= &exact(bound) * &exact(bound)
}

/// Whether the normal turns from a direction by no more than it claims and is rounded.
fn is_along(c: &Contact, direction: &Vector3<f64>) -> bool {
    const ROUNDINGS: f64 = 16.0 * f64::EPSILON;
    let chord = (c.normal - direction.normalize()).norm();
    c.normal_bound.is_some_and(|b| chord <= b + ROUNDINGS)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// The nearest point of a box is the centre's, each coordinate cut to the box's range.
    #[test]
    fn feet_on_a_box_are_bounded(
        at in prop::array::uniform3(-3.0..3.0f64),
        coarse in any::<bool>(),
    ) {
        let brep = PreparedBrep::new(block());
        let foot = [0, 1, 2].map(|k| at[k].clamp(FROM[k], TO[k]));
        let outside = (0..3).filter(|k| foot[*k] != at[*k]).count();
        prop_assume!(outside > 0);
        let accuracy = if coarse { Accuracy::Length(1e-9) } else { Accuracy::Full };
        let probe = Probe::Sphere(Sphere::new(Point3::from(at), 0.5).unwrap());
        let answer = asked(&brep, &probe, accuracy);
        let [c] = answer.contacts.as_slice() else {
            return Err(TestCaseError::fail(format!("{answer:?}")));
        };
        let kind = match c.feature {
            Feature::Face(_) => 1,
            Feature::Edge(_) => 2,
            Feature::Vertex(_) => 3,
        };
        // Next to an edge it is on it.
        let next = (0..3).any(|k| {
            let off = (at[k] - FROM[k]).abs().min((at[k] - TO[k]).abs());
            off < 1e-9
        });
        prop_assert!(next || kind == outside, "{:?}, {} coordinates outside", c, outside);
        let bound = c.position_bound;
        prop_assert!(bound.is_some_and(|b| b < NARROW && is_near(c, b, &foot)), "{:?}: {:?}", foot, c);
        prop_assert!(is_along(c, &(Point3::from(at) - Point3::from(foot))), "{:?}", c);
    }

    /// A half-space that is level with no edge touches a vertex.
    #[test]
    fn feet_of_half_spaces_on_a_box_are_bounded(
        part in prop::array::uniform3(0.1..1.0f64),
        low in prop::array::uniform3(any::<bool>()),
        coarse in any::<bool>(),
    ) {
        let brep = PreparedBrep::new(block());
        let normal = Vector3::from_fn(|k, _| if low[k] { part[k] } else { -part[k] }).normalize();
        let foot = [0, 1, 2].map(|k| if low[k] { FROM[k] } else { TO[k] });
        let accuracy = if coarse { Accuracy::Length(1e-9) } else { Accuracy::Full };
        let probe = Probe::HalfSpace(HalfSpace::new(normal, 0.5).unwrap());
        let answer = asked(&brep, &probe, accuracy);
        let [c] = answer.contacts.as_slice() else {
            return Err(TestCaseError::fail(format!("{answer:?}")));
        };
        prop_assert!(matches!(c.feature, Feature::Vertex(_)), "{:?}", c);
        let bound = c.position_bound;
        prop_assert!(bound.is_some_and(|b| b < NARROW && is_near(c, b, &foot)), "{:?}: {:?}", foot, c);
        prop_assert!(is_along(c, &-normal), "{:?}", c);
    }
}

/// Over the bottom of a groove of right angles both sides are equally near: the bound holds both feet, or there is none.
#[test]
fn two_feet_are_within_the_bound_of_one() {
    let mut b = BrepBuilder::new();
    let at = [
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 1.0],
        [1.0, 0.0, 1.0],
        [-1.0, 1.0, 1.0],
        [-1.0, 0.0, 1.0],
    ];
    let [a0, a1, r1, r0, l1, l0] = at.map(|p| b.vertex(p));
    b.planar_face(&[a0, r0, r1, a1]).unwrap();
    b.planar_face(&[a0, a1, l1, l0]).unwrap();
    let brep = PreparedBrep::new(b.build().unwrap());
    let mut bounded = 0;
    for digits in 4..40 {
        let height = 2f64.powi(-digits);
        let probe = Probe::Sphere(Sphere::new(Point3::new(0.0, 0.5, height), 0.0).unwrap());
        for accuracy in [Accuracy::Full, Accuracy::Length(1e-9)] {
            let answer = asked(&brep, &probe, accuracy);
            let c = answer.contacts[0];
            let Some(bound) = c.position_bound else {
                continue;
            };
            bounded += 1;
            let half = 0.5 * height;
            for foot in [[half, 0.5, half], [-half, 0.5, half]] {
                assert!(is_near(&c, bound, &foot), "{height:e}, {accuracy:?}: {c:?}");
            }
        }
    }
    assert!(bounded > 20, "{bounded}");
}

/// A part of the cylinder of radius 2 about the z axis, from 0 to 1, without caps.
fn cylinder(angle: [f64; 2]) -> PreparedBrep {
    let interval = |start: f64, end: f64| Interval::new(start, end).unwrap();
    let (from, to) = (Point3::new(2.0, 0.0, 0.0), Point3::new(2.0, 0.0, 1.0));
    let revolution = Revolution {
        origin: Point3::origin(),
        axis: Vector3::z(),
        angle: interval(angle[0], angle[1]),
        angle_domain: interval(angle[0], angle[1]),
        profile: Curve3::Line(Line::new(from, to, interval(0.0, 1.0)).unwrap()),
        transposed: false,
    };
    let surface = Surface::Revolution(Revolution::new(revolution).unwrap());
    PreparedBrep::new(Brep::from_surface(surface).unwrap())
}

/// Over the rim, along (3, 4): the foot is (6/5, 8/5, 1).
#[test]
fn feet_on_a_rim_are_bounded() {
    let brep = cylinder([0.0, std::f64::consts::TAU]);
    for scale in [0.125, 0.25, 1.0, 4.0] {
        for accuracy in [Accuracy::Full, Accuracy::Length(1e-9)] {
            let center = Point3::new(3.0 * scale, 4.0 * scale, 1.5);
            let probe = Probe::Sphere(Sphere::new(center, 0.25).unwrap());
            let answer = asked(&brep, &probe, accuracy);
            let c = answer.contacts[0];
            let bound = c.position_bound;
            // 6/5 and 8/5 are rounded.
            let rounded = |b: f64| b + 2.0 * f64::EPSILON;
            assert!(
                bound.is_some_and(|b| b < NARROW && is_near(&c, rounded(b), &[1.2, 1.6, 1.0])),
                "{scale}: {answer:?}"
            );
        }
    }
}

/// Behind a part of a turn both ends of its rim are equally near, and nothing bounds where the foot is.
#[test]
fn of_two_ends_that_are_equally_near_none_is_the_foot() {
    let brep = cylinder([-1.0, 1.0]);
    for z in [2.0, 1.5, 1.25] {
        let probe = Probe::Sphere(Sphere::new(Point3::new(-1.0, 0.0, z), 0.25).unwrap());
        for accuracy in [Accuracy::Full, Accuracy::Length(1e-9)] {
            let answer = asked(&brep, &probe, accuracy);
            let c = answer.contacts[0];
            assert!(c.position_bound.is_none_or(|b| b > 3.0), "{z}: {c:?}");
        }
    }
}

/// Where the budget is spent before the separation is known the point on a half-space is in its plane all the same, straight below the foot.
#[test]
fn the_point_on_a_half_space_is_on_it() {
    let brep = PreparedBrep::new(crate::scenes::bicubic());
    let normal = Vector3::new(2.0, 3.0, 6.0) / 7.0;
    // Products and sums of numbers below 2, some ten of them.
    const ROUNDED: f64 = 16.0 * f64::EPSILON;
    let mut undecided = 0;
    for budget in 1..40 {
        let options = Options {
            prediction: f64::INFINITY,
            node_budget: budget,
            ..Options::default()
        };
        let probe = Probe::HalfSpace(HalfSpace::new(normal, 0.125).unwrap());
        let answer = contact(&brep, &probe, &options, &mut Workspace::default());
        undecided += usize::from(answer.undecided.is_some());
        for c in &answer.contacts {
            let height = normal.dot(&c.on_probe.coords) - 0.125;
            assert!(height.abs() <= ROUNDED, "{budget}: {height:e} {c:?}");
            let along = (c.on_brep - c.on_probe).cross(&normal).norm();
            assert!(along <= ROUNDED, "{budget}: {along:e} {c:?}");
        }
    }
    assert!(undecided > 0);
}
