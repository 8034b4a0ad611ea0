//! Lists of contacts where trims pass from patch to patch: of surfaces made of planes, on which each contact is a point that can be
//! computed exactly.

use crate::common::{abs, q};
use crate::scenes::polygon_face;
use dashu_ratio::RBig as Q;
use feeler::nurbs::{NurbsSurface, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, ContactAnswer, Contacts, HalfSpace, Options, Probe, Workspace, contact,
};
use nalgebra::{Point2, Vector3, Vector4};
use proptest::prelude::*;

/// `z = first(x) + second(y)`, both linear between their knots, above the line between two points on the first and last knots of x.
#[derive(Clone, Debug)]
struct Folded {
    /// Knots and heights along x and along y.
    folds: [Vec<[f64; 2]>; 2],
    /// Where the line begins and ends along y.
    ends: [f64; 2],
    swapped: bool,
}

impl Folded {
    fn brep(&self) -> PreparedBrep {
        let [x, y] = [0, 1].map(|k| {
            let f = &self.folds[k];
            (f[0][0], f[f.len() - 1][0])
        });
        let knots = |k: usize| {
            let own: Vec<f64> = self.folds[k].iter().map(|f| f[0]).collect();
            [&own[..1], &own, &own[own.len() - 1..]].concat()
        };
        let order = if self.swapped { [1, 0] } else { [0, 1] };
        let turned = |p: [f64; 2]| Point2::new(p[order[0]], p[order[1]]);
        let [rows, columns] = order.map(|k| &self.folds[k]);
        let net = rows.iter().flat_map(|a| {
            columns.iter().map(move |b| {
                let at = turned([a[0], b[0]]);
                Vector4::new(at.x, at.y, a[1] + b[1], 1.0)
            })
        });
        let counts = [rows.len(), columns.len()];
        let surface = NurbsSurface::new([1; 2], counts, net.collect(), order.map(knots)).unwrap();
        let mut corners = vec![
            [x.0, self.ends[0]],
            [x.1, self.ends[1]],
            [x.1, y.1],
            [x.0, y.1],
        ];
        if self.swapped {
            corners.reverse();
        }
        let corners: Vec<Point2<f64>> = corners.into_iter().map(turned).collect();
        polygon_face(&Surface::Nurbs(surface), &corners)
    }

    /// The function along x or y, with the height times `up` and the place times `along` added, and its slopes before and after: at a place.
    fn along(&self, k: usize, at: &Q, [along, up]: [f64; 2]) -> (Q, [Q; 2]) {
        let folds = &self.folds[k];
        let slope = |i: usize| {
            let [a, b] = [&folds[i], &folds[i + 1]];
            q(along) + q(up) * (q(b[1]) - q(a[1])) / (q(b[0]) - q(a[0]))
        };
        let last = folds.len() - 2;
        let before = (0..=last).rfind(|i| q(folds[*i][0]) < *at).unwrap_or(0);
        let after = (0..=last).rfind(|i| q(folds[*i][0]) <= *at).unwrap_or(0);
        let from = &folds[after];
        let height = q(along) * q(from[0]) + q(up) * q(from[1]);
        let value = height + slope(after) * (at - q(from[0]));
        (value, [slope(before), slope(after)])
    }

    /// All strict local minima of a height over the face, and whether all of what was compared is clearly not equal.
    fn minima(&self, normal: [f64; 3]) -> Option<Vec<([Q; 2], Q)>> {
        let [xs, ys] = [0, 1].map(|k| self.folds[k].iter().map(|f| q(f[0])).collect::<Vec<_>>());
        let (x0, x1, y1) = (&xs[0], &xs[xs.len() - 1], &ys[ys.len() - 1]);
        let [from, to] = self.ends.map(q);
        let rise = (&to - &from) / (x1 - x0);
        let line = |x: &Q| &from + &rise * (x - x0);
        let mut places: Vec<[Q; 2]> = Vec::new();
        for x in &xs {
            let on_line = line(x);
            places.extend(
                ys.iter()
                    .filter(|y| **y > on_line)
                    .map(|y| [x.clone(), y.clone()]),
            );
            places.push([x.clone(), on_line]);
        }
        if rise != Q::ZERO {
            for y in &ys {
                let x = x0 + (y - &from) / &rise;
                if *x0 < x && x < *x1 && !xs.contains(&x) {
                    places.push([x, y.clone()]);
                }
            }
        }
        // Places next to each other are one contact, and slopes that differ by little are not told apart in the steps that decide what is one.
        let clear = q(1.0 / 64.0);
        let near = |a: &[Q; 2], b: &[Q; 2]| (0..2).all(|k| abs(&(&a[k] - &b[k])) < clear);
        if (1..places.len()).any(|i| places[..i].iter().any(|p| near(p, &places[i]))) {
            return None;
        }
        let mut out = Vec::new();
        for p in places {
            let (a, slopes_x) = self.along(0, &p[0], [normal[0], normal[2]]);
            let (b, slopes_y) = self.along(1, &p[1], [normal[1], normal[2]]);
            let on_line = p[1] == line(&p[0]);
            let one = Q::ONE;
            let mut ways = vec![
                [one.clone(), Q::ZERO],
                [-one.clone(), Q::ZERO],
                [Q::ZERO, one.clone()],
                [Q::ZERO, -one.clone()],
            ];
            if on_line {
                ways.push([one.clone(), rise.clone()]);
                ways.push([-one.clone(), -rise.clone()]);
            }
            let stays = |d: &[Q; 2]| {
                let up = &d[1] - &rise * &d[0];
                (p[0] != *x0 || d[0] >= Q::ZERO)
                    && (p[0] != *x1 || d[0] <= Q::ZERO)
                    && (p[1] != *y1 || d[1] <= Q::ZERO)
                    && (!on_line || up >= Q::ZERO)
            };
            let mut least = true;
            for d in ways.iter().filter(|d| stays(d)) {
                let part = |slopes: &[Q; 2], d: &Q| &slopes[usize::from(*d > Q::ZERO)] * d;
                let grows = part(&slopes_x, &d[0]) + part(&slopes_y, &d[1]);
                if abs(&grows) < clear {
                    return None;
                }
                least &= grows > Q::ZERO;
            }
            if least {
                out.push((p, a + b));
            }
        }
        Some(out)
    }
}

fn ask(
    brep: &PreparedBrep,
    normal: [f64; 3],
    accuracy: Accuracy,
    contacts: Contacts,
) -> ContactAnswer {
    let below = HalfSpace::new(Vector3::from(normal), 0.0).unwrap();
    let options = Options {
        accuracy,
        contacts,
        prediction: 1000.0,
        ..Options::default()
    };
    contact(
        brep,
        &Probe::HalfSpace(below),
        &options,
        &mut Workspace::default(),
    )
}

/// Steps and heights; knots are no round numbers as a rule.
fn folds() -> impl Strategy<Value = Vec<[f64; 2]>> {
    let step = prop_oneof![0.25f64..2.0, Just(0.5), Just(1.0)];
    let part = (step, -12i32..=12);
    (
        prop_oneof![Just(0.0), -4.0f64..4.0],
        prop::collection::vec(part, 2..5),
    )
        .prop_map(|(from, parts)| {
            let mut at = from;
            let one = |(step, height): (f64, i32)| {
                let here = at;
                at += step;
                [here, f64::from(height) / 4.0]
            };
            parts.into_iter().map(one).collect()
        })
}

fn folded() -> impl Strategy<Value = Folded> {
    let end = prop_oneof![0.0f64..0.9, Just(0.5), Just(0.25)];
    ([folds(), folds()], [end.clone(), end], any::<bool>()).prop_map(|(folds, ends, swapped)| {
        let y = &folds[1];
        let (low, high) = (y[0][0], y[y.len() - 1][0]);
        Folded {
            ends: ends.map(|t| low + t * (high - low)),
            folds,
            swapped,
        }
    })
}

const NORMALS: [[f64; 3]; 4] = [
    [0.0, 0.0, 1.0],
    [0.48, 0.6, 0.64],
    [-0.28, 0.0, 0.96],
    [0.6, -0.8, 0.0],
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]

    #[test]
    fn lists_of_folded_planes(
        face in folded(), normal in prop::sample::select(&NORMALS[..]),
        accuracy in prop::sample::select(vec![
            Accuracy::Full, Accuracy::Length(1e-12), Accuracy::Length(1e-6), Accuracy::Length(1e-2),
        ]),
    ) {
        let Some(minima) = face.minima(normal) else { return Ok(()) };
        let brep = face.brep();
        let least = minima.iter().map(|(_, truth)| truth).min();
        let found = ask(&brep, normal, accuracy, Contacts::All);
        for answer in [&found, &ask(&brep, normal, accuracy, Contacts::Deepest)] {
            let bounds = answer.separation.bounds;
            // In full a separation may be known to a little less than is wanted of it: next to 0, and once in some ten thousand times.
            let most = 1e-17f64.max(2.0 * f64::EPSILON * bounds.hi.abs());
            let known = answer.undecided.is_none() || bounds.hi - bounds.lo < most;
            // At the coarsest accuracy what is as low as that reaches far.
            let spreads = answer.continuum && accuracy != Accuracy::Length(1e-2);
            prop_assert!(known && !spreads, "{:?}", answer);
            prop_assert!(least.is_some_and(|t| q(bounds.lo) <= *t && *t <= q(bounds.hi)), "{:?}", answer);
        }
        let float = |x: &Q| x.to_f64().value();
        for c in &found.contacts {
            let near = |at: &[Q; 2]| (0..2).all(|k| (float(&at[k]) - c.on_brep[k]).abs() < 1e-6);
            let own = minima.iter().find(|(at, _)| near(at));
            prop_assert!(own.is_some(), "no minimum: {:?} of {:?}", c, minima);
            let bounds = c.separation.bounds;
            if let Some((_, truth)) = own {
                prop_assert!(
                    q(bounds.lo) <= *truth && *truth <= q(bounds.hi),
                    "{:?} does not hold {} (by {:e}, {:e})", bounds, truth,
                    float(&(truth - q(bounds.lo))), float(&(q(bounds.hi) - truth))
                );
            }
        }
        prop_assert_eq!(found.contacts.len(), minima.len(), "{:?} {:?}", found.contacts, minima.iter().map(|(p, v)| [float(&p[0]), float(&p[1]), float(v)]).collect::<Vec<_>>());
    }
}
