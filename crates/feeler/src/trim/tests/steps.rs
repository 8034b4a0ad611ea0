//! What must not change a side where knots and points are a few steps of f64 apart; and the reference there.

use super::near::{Spline, aim, cases, loops, stepped};
use super::reference::Reference;
use super::shapes::{Use, face, nurbs};
use crate::brep::Brep;
use crate::trim::{Side, TrimRegion};
use proptest::prelude::*;

const WIDE: [f64; 4] = [-64.0, 64.0, -64.0, 64.0];

fn used(s: &Spline) -> Use {
    nurbs(s.degree, &s.net, &s.knots()).into()
}

fn brep(loops: &[Vec<Spline>], each: impl Fn(&Spline) -> Vec<Use>) -> Brep {
    let one = |l: &Vec<Spline>| l.iter().flat_map(&each).collect();
    face(WIDE, Some(loops.iter().map(one).collect()))
}

fn region(loops: &[Vec<Spline>], each: impl Fn(&Spline) -> Vec<Use>) -> TrimRegion {
    TrimRegion::new(&brep(loops, each), 0)
}

/// Each control point by a linear map of whole numbers or halves.
fn mapped(s: &Spline, map: [[f64; 2]; 2]) -> Spline {
    let row = |p: &[f64; 3], r: [f64; 2]| r[0] * p[0] + r[1] * p[1];
    Spline {
        net: s
            .net
            .iter()
            .map(|p| [row(p, map[0]), row(p, map[1]), p[2]])
            .collect(),
        ..s.clone()
    }
}

/// The use in two parts that meet at a parameter, where that is inside.
fn parts(s: &Spline, part: f64) -> Vec<Use> {
    let knots = s.knots();
    let (start, end) = (knots[0], knots[knots.len() - 1]);
    // Whole steps, so that it is a parameter: at knots and between, as they are all some steps apart.
    let last = s.steps.iter().max().copied().unwrap_or(0);
    let at = 1.0 + (part * last as f64).round() * f64::EPSILON;
    if !(start < at && at < end) {
        return vec![used(s)];
    }
    let both = [[start, at], [at, end]];
    both.map(|span| Use {
        span: Some(span),
        ..used(s)
    })
    .into()
}

/// Boehm's insertion in whole numbers: of a knot that is there, or one between; none where the control points would be rounded.
fn with_knot(s: &Spline, part: f64) -> Option<Spline> {
    let p = s.degree;
    let last = s.steps[s.net.len()];
    let t = (part * last as f64).round() as i64;
    let times = s.steps.iter().filter(|k| **k == t).count();
    if t <= 0 || t >= last || times >= p {
        return None;
    }
    let span = s.steps.iter().rposition(|k| *k <= t)?;
    let first = span + 1 - p;
    let shares: Vec<(i64, i64)> = (first..=span - times)
        .map(|i| (t - s.steps[i], s.steps[i + p] - s.steps[i]))
        .collect();
    let gcd = |mut a: i64, mut b: i64| {
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    // All control points times this: the same curve, in numbers without a remainder.
    let factor = shares
        .iter()
        .try_fold(1i64, |l, (_, d)| (l / gcd(l, *d)).checked_mul(*d))?;
    let times_f64 = |x: f64, n: i64| {
        let product = x * n as f64;
        (n as f64 as i64 == n && x.mul_add(n as f64, -product) == 0.0).then_some(product)
    };
    let sum = |a: f64, b: f64| {
        let sum = a + b;
        // Knuth: what is lost.
        let (x, y) = (sum - b, sum - (sum - b));
        ((a - x) + (b - y) == 0.0).then_some(sum)
    };
    let scaled = |q: &[f64; 3], n: i64| -> Option<[f64; 3]> {
        Some([
            times_f64(q[0], n)?,
            times_f64(q[1], n)?,
            times_f64(q[2], n)?,
        ])
    };
    let mut net = Vec::new();
    for q in &s.net[..first] {
        net.push(scaled(q, factor)?);
    }
    for (k, (up, whole)) in shares.iter().enumerate() {
        let i = first + k;
        let share = factor / whole;
        let (a, b) = (
            scaled(&s.net[i - 1], share * (whole - up))?,
            scaled(&s.net[i], share * up)?,
        );
        net.push([sum(a[0], b[0])?, sum(a[1], b[1])?, sum(a[2], b[2])?]);
    }
    for q in &s.net[span - times..] {
        net.push(scaled(q, factor)?);
    }
    let mut steps = s.steps.clone();
    steps.insert(span + 1, t);
    Some(Spline {
        degree: p,
        net,
        steps,
    })
}

proptest! {
    #![proptest_config(cases(64))]

    /// Loops that run the other way, u and v swapped, twice as large and mirrored, in twice as many trims, over other parameters, with a knot more.
    #[test]
    fn nothing_that_is_the_same_changes_a_side(
        loops in loops(),
        aims in prop::collection::vec(aim(), 8),
        part in 0.0..1.0f64,
    ) {
        let whole = region(&loops, |s| vec![used(s)]);
        let turned: Vec<Vec<Spline>> = loops
            .iter()
            .map(|l| l.iter().rev().map(Spline::turned).collect())
            .collect();
        let against = region(&loops.iter().map(|l| l.iter().rev().cloned().collect()).collect::<Vec<_>>(), |s| {
            vec![Use { reversed: true, ..used(s) }]
        });
        let turned = region(&turned, |s| vec![used(s)]);
        let map = |m| move |s: &Spline| vec![used(&mapped(s, m))];
        let swapped = region(&loops, map([[0.0, 1.0], [1.0, 0.0]]));
        let mirrored = region(&loops, map([[-2.0, 0.0], [0.0, 2.0]]));
        let split = region(&loops, |s| parts(s, part));
        // The same steps about 0, and as large.
        let moved = region(&loops, |s| {
            let knots: Vec<f64> = s.steps.iter().map(|k| *k as f64).collect();
            vec![nurbs(s.degree, &s.net, &knots).into()]
        });
        let inserted = region(&loops, |s| vec![used(&with_knot(s, part).unwrap_or_else(|| s.clone()))]);
        for a in &aims {
            let q = a.at(&loops);
            let told = whole.side(q.into());
            prop_assert!(told.side.is_some(), "{:?}", q);
            for (how, other, at) in [
                ("against", &against, q),
                ("turned", &turned, q),
                ("swapped", &swapped, [q[1], q[0]]),
                ("mirrored", &mirrored, [-2.0 * q[0], 2.0 * q[1]]),
                ("in two parts", &split, q),
                ("over other knots", &moved, q),
                ("with a knot", &inserted, q),
            ] {
                prop_assert_eq!(told, other.side(at.into()), "{}, {:?}", how, q);
            }
        }
    }

}

proptest! {
    #![proptest_config(cases(16))]

    /// The reference finds roots by Sturm's sequences along a skew ray.
    #[test]
    fn the_reference_says_the_same(loops in loops(), aims in prop::collection::vec(aim(), 2)) {
        let brep = brep(&loops, |s| vec![used(s)]);
        let region = TrimRegion::new(&brep, 0);
        let reference = Reference::new(&brep);
        for a in &aims {
            let q = a.at(&loops);
            prop_assert_eq!(region.side(q.into()).side, Some(reference.side(q)), "{:?}", q);
        }
    }
}

/// A value of a polynomial on [0, 1] with whole control values, times `n^degree`, at a part k / n: exactly.
fn height(values: &[i64], k: i128, n: i128) -> i128 {
    let mut d: Vec<i128> = values.iter().map(|x| i128::from(*x)).collect();
    while d.len() > 1 {
        d = d.windows(2).map(|w| w[0] * (n - k) + w[1] * k).collect();
    }
    d[0]
}

proptest! {
    #![proptest_config(cases(64))]

    /// Between the graph of a polynomial and the same some steps of f64 higher: inside is what is above the one and below the other, in whole numbers.
    #[test]
    fn a_sliver_along_a_graph(
        // Degrees with u = t in f64.
        values in prop::sample::select(vec![2usize, 3, 5]).prop_flat_map(|n| prop::collection::vec(-64i64..=64, n)),
        wide in 1i64..=4,
        at in prop::collection::vec((0i128..=4096, -5i64..=9), 16),
        swap in any::<bool>(),
    ) {
        // Heights in steps of 2^-52 above 1.
        let base = 1i64 << 20;
        let step = |k: i64| 1.0 + (base + k) as f64 * f64::EPSILON;
        let degree = values.len() - 1;
        let at_uv = |p: [f64; 2]| if swap { [p[1], p[0]] } else { p };
        let net = |up: i64| -> Vec<[f64; 3]> {
            values
                .iter()
                .enumerate()
                .map(|(i, h)| {
                    let [u, v] = at_uv([i as f64 / degree as f64, step(h + up)]);
                    [u, v, 1.0]
                })
                .collect()
        };
        let curve = |up| Spline { degree, net: net(up), steps: [vec![0; degree + 1], vec![1; degree + 1]].concat() };
        let (low, high) = (curve(0), curve(wide).turned());
        let (a, b) = (low.ends(), high.ends());
        let sliver = vec![vec![low, Spline::straight(a[1], b[0]), high, Spline::straight(b[1], a[0])]];
        let region = region(&sliver, |s| vec![used(s)]);
        let n = 4096i128;
        for (k, off) in at {
            let scale = n.pow(u32::try_from(degree).unwrap());
            let exact = height(&values, k, n);
            let near = i64::try_from(exact.div_euclid(scale)).unwrap() + off;
            let above = i128::from(near) * scale - exact;
            let room = i128::from(wide) * scale;
            let at_end = k == 0 || k == n;
            let expected = if above < 0 || above > room {
                Side::Outside
            } else if above == 0 || above == room || at_end {
                Side::Boundary
            } else {
                Side::Inside
            };
            let q = at_uv([k as f64 / n as f64, step(near)]);
            prop_assert_eq!(region.side(q.into()).side, Some(expected), "{:?}", q);
        }
    }
}

#[test]
fn a_knot_more_is_the_same_curve() {
    let s = Spline {
        degree: 2,
        net: vec![
            [0.0, 0.0, 1.0],
            [1.0, 4.0, 1.0],
            [5.0, 1.0, 1.0],
            [6.0, 0.0, 1.0],
        ],
        steps: vec![0, 0, 0, 1, 4, 4, 4],
    };
    let more = with_knot(&s, 0.5).unwrap();
    assert_eq!(more.steps, [0, 0, 0, 1, 2, 4, 4, 4]);
    for k in 0..=8 {
        let (a, b) = (s.at(f64::from(k) / 8.0), more.at(f64::from(k) / 8.0));
        assert!((0..2).all(|i| (a[i] - b[i]).abs() < 1e-14), "{a:?} {b:?}");
    }
    assert_eq!(stepped(1.0, 2), 1.0 + 2.0 * f64::EPSILON);
}
