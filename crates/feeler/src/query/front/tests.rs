//! Bounds of kept parts about other centres, against exact squares.

use super::*;
use crate::numeric::Dyadic;
use crate::query::{Accuracy, Options, Probe, Sphere, Witness, Workspace, contact_from};
use proptest::prelude::*;

fn squared(a: [f64; 3], b: [f64; 3]) -> Dyadic {
    (0..3).fold(Dyadic::ZERO, |sum, k| {
        let exact = |x: f64| Dyadic::from_f64(x).expect("a number");
        let d = &exact(a[k]) - &exact(b[k]);
        &sum + &(&d * &d)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    /// A point of the part's box in space that is no nearer to the first centre than the part is known to be is not nearer to another one than is told.
    #[test]
    fn no_point_of_a_part_is_nearer_than_is_told(
        box_at in prop::array::uniform3(-4.0..4.0f64),
        size in prop::array::uniform3(0.0..1.0f64),
        within in prop::array::uniform3(0.0..=1.0f64),
        center in prop::array::uniform3(-4.0..4.0f64),
        way in prop::array::uniform3(-1.0..1.0f64),
        step in 0..30i32,
        with_hull in any::<bool>(),
        towards in any::<bool>(),
        point in any::<bool>(),
    ) {
        // Of a box that is a point nothing is lost by the box.
        let size = if point { [0.0; 3] } else { size };
        let hull: [[f64; 2]; 3] = std::array::from_fn(|k| [box_at[k], box_at[k] + size[k]]);
        let x: [f64; 3] = std::array::from_fn(|k| (box_at[k] + within[k] * size[k]).clamp(hull[k][0], hull[k][1]));
        // On the way to that point nothing is lost by the triangle inequality.
        let way = if towards { std::array::from_fn(|k| x[k] - center[k]) } else { way };
        let other: [f64; 3] = std::array::from_fn(|k| center[k] + way[k] * 0.5f64.powi(step));
        // As near as that point is: the greatest f64 that is no more.
        let square = squared(x, center);
        let mut away = square.approximate().sqrt().next_up();
        while away > 0.0 && Dyadic::from_f64(away).is_none_or(|a| &a * &a > square) {
            away = away.next_down();
        }
        let known = Known {
            center: Point3::from(center),
            away,
            hull: if with_hull { hull } else { EVERYWHERE },
        };
        let least = known.least(&Point3::from(other));
        let truth = squared(x, other);
        prop_assert!(Dyadic::from_f64(least).is_some_and(|l| l <= truth), "{} {}", least, truth.approximate());
        if with_hull {
            let other = Point3::from(other);
            for own in [known.least_of_hull(&other), least_squared(&hull, &other)] {
                prop_assert!(Dyadic::from_f64(own).is_some_and(|l| l <= truth), "{} {}", own, truth.approximate());
            }
        }
    }

    /// Parts are passed over for being far alone, and what is written down of these is no more than how far they are.
    #[test]
    fn what_may_be_near_is_looked_at(
        parts in prop::collection::vec((prop::array::uniform3(-4.0..4.0f64), 0.0..4.0f64, prop_oneof![8 => 0.5..4.0f64, 1 => Just(f64::NEG_INFINITY)]), 0..40),
        (travel, reach) in (0.0..2.0f64, 0.0..2.0f64),
    ) {
        let q = Point3::origin();
        let known: Vec<Known> = parts
            .iter()
            .map(|(center, away, _)| Known { center: Point3::from(*center), away: *away, hull: EVERYWHERE })
            .collect();
        let clear: Vec<f64> = parts.iter().map(|p| p.2).collect();
        let mut front = Front { travel, known: known.clone(), clear: clear.clone(), ..Front::default() };
        let (hi, mut near) = (reach * reach, Vec::new());
        front.near(&q, reach, hi, &mut near);
        for (k, (own, clear)) in known.iter().zip(clear).enumerate() {
            let exact = |x: f64| Dyadic::from_f64(x);
            let by_way = exact(clear).zip(exact(travel)).zip(exact(reach)).is_some_and(|((c, t), r)| &c - &t > r);
            let least = own.least(&q);
            let told = near.iter().find(|n| n.0 == k);
            prop_assert!(told.is_some() || by_way || least > hi);
            prop_assert!(told.is_none_or(|n| n.1 == least));
            if front.clear[k] != clear {
                prop_assert!(told.is_none());
                let away = Dyadic::from_f64(front.clear[k]).zip(Dyadic::from_f64(travel)).map(|(c, t)| &c - &t);
                let least = Dyadic::from_f64(least);
                prop_assert!(away.zip(least).is_some_and(|(a, l)| a <= Dyadic::ZERO || &a * &a <= l));
            }
        }
        prop_assert!(square_root_is_no_more(reach) && near.iter().all(|n| square_root_is_no_more(n.1)));
    }
}

fn square_root_is_no_more(x: f64) -> bool {
    let own = Dyadic::from_f64(root(x)).map(|r| &r * &r);
    own.zip(Dyadic::from_f64(x))
        .is_some_and(|(own, x)| own <= x)
}

/// A ball over the face teaches the box that its foot is on; the next one has its foot on the same surface beyond the trim at x = 1/4, where nothing is: it is nearest to the
/// trim at `(1/4, 0, 1/16)`.
#[test]
fn a_kept_box_may_be_out_of_its_region() {
    let brep = crate::query::tests::bowl(0.25);
    let (mut witness, mut workspace) = (Witness::default(), Workspace::default());
    let options = Options {
        accuracy: Accuracy::Length(0.125),
        prediction: f64::INFINITY,
        ..Options::default()
    };
    for x in [0.125, 0.375] {
        // 1/8 of the normal (-2 x, 0, 1) above (x, 0).
        let center = Point3::new(0.75 * x, 0.0, x * x + 0.125);
        let probe = Probe::Sphere(Sphere::new(center, 0.0).unwrap());
        let answer = contact_from(&brep, &probe, &mut witness, &options, &mut workspace);
        let bounds = answer.separation.bounds;
        let truth = if x < 0.25 {
            0.125 * (1.0 + 4.0 * x * x).sqrt()
        } else {
            (center - Point3::new(0.25, 0.0, 0.0625)).norm()
        };
        assert!(
            bounds.lo < truth + 1e-15 && bounds.hi > truth - 1e-15,
            "{x}: {bounds:?} {truth}"
        );
    }
}
