//! Trim loops for property tests where sides are hard to tell: knots and points a few steps of f64 apart, slivers, cusps, tangents, joints at the height
//! of a point.
//!
//! Plain numbers, so that tests of other crates can include this file. What shrinks becomes straight, polynomial, and asked far from its loops.

use proptest::prelude::*;

/// A spline in uv: homogeneous control points, all of them exact, and knots in steps of 2^-52 above 1.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spline {
    pub(crate) degree: usize,
    pub(crate) net: Vec<[f64; 3]>,
    pub(crate) steps: Vec<i64>,
}

impl Spline {
    pub(crate) fn straight(from: [f64; 2], to: [f64; 2]) -> Self {
        Self {
            degree: 1,
            net: vec![[from[0], from[1], 1.0], [to[0], to[1], 1.0]],
            steps: vec![0, 0, 1, 1],
        }
    }

    pub(crate) fn knots(&self) -> Vec<f64> {
        let step = |k: &i64| 1.0 + *k as f64 * f64::EPSILON;
        self.steps.iter().map(step).collect()
    }

    /// The first and the last control point, which the curve runs through.
    pub(crate) fn ends(&self) -> [[f64; 2]; 2] {
        [0, self.net.len() - 1].map(|i| on(&self.net[i]))
    }

    /// The same curve run the other way.
    pub(crate) fn turned(&self) -> Self {
        let last = self.steps.iter().max().copied().unwrap_or(0);
        Self {
            degree: self.degree,
            net: self.net.iter().rev().copied().collect(),
            steps: self.steps.iter().rev().map(|k| last - k).collect(),
        }
    }

    /// With each control point moved.
    fn moved(&self, by: impl Fn([f64; 2]) -> [f64; 2]) -> Self {
        let one = |p: &[f64; 3]| {
            let [u, v] = by(on(p));
            [u * p[2], v * p[2], p[2]]
        };
        Self {
            net: self.net.iter().map(one).collect(),
            ..self.clone()
        }
    }

    /// A point of the curve, about, by de Boor's triangle: a part of its domain.
    pub(crate) fn at(&self, part: f64) -> [f64; 2] {
        let (p, n) = (self.degree, self.net.len());
        let knot = |i: usize| self.steps[i] as f64;
        let t = knot(p) + part * (knot(n) - knot(p));
        let last = |k: &usize| knot(*k) <= t && knot(*k) < knot(*k + 1);
        let span = (p..n).rev().find(last).unwrap_or(p);
        let mut d: Vec<[f64; 3]> = self.net[span - p..=span].to_vec();
        for r in 1..=p {
            for j in (r..=p).rev() {
                let (a, b) = (knot(span - p + j), knot(span + 1 + j - r));
                let s = (t - a) / (b - a);
                d[j] = [0, 1, 2].map(|i| d[j - 1][i] * (1.0 - s) + d[j][i] * s);
            }
        }
        on(&d[p])
    }
}

fn on(p: &[f64; 3]) -> [f64; 2] {
    [p[0] / p[2], p[1] / p[2]]
}

/// So many cases, or as many as `PROPTEST_CASES` says.
pub(crate) fn cases(few: u32) -> ProptestConfig {
    let told = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    match std::env::var_os("PROPTEST_CASES") {
        Some(_) => told,
        None => ProptestConfig { cases: few, ..told },
    }
}

/// So many f64 farther up or down.
pub(crate) fn stepped(x: f64, steps: i8) -> f64 {
    let one = |x: f64, _| {
        if steps > 0 {
            x.next_up()
        } else {
            x.next_down()
        }
    };
    (0..steps.unsigned_abs()).fold(x, one)
}

/// Inner knots: how far each is above the last one, in steps, and how often it stands there.
fn inner() -> impl Strategy<Value = Vec<(i64, usize)>> {
    let gap = prop_oneof![3 => 1i64..=4, 1 => Just(1i64 << 30), 1 => Just(1i64 << 49)];
    prop::collection::vec((gap, 1usize..=4), 0..4)
}

/// A control point: what it is made of, and how.
type Drawn = (u8, [i8; 2], usize);

/// Within 16 of the origin, on a grid of quarters or a few steps of f64 off it.
fn points(drawn: &[Drawn]) -> Vec<[f64; 2]> {
    let mut all: Vec<[f64; 2]> = Vec::new();
    for (kind, at, _) in drawn {
        let fresh = at.map(|x| f64::from(x) / 8.0);
        let last = all.last().copied().unwrap_or(fresh);
        let first = all.first().copied().unwrap_or(fresh);
        all.push(match kind {
            // A cusp, or an end without a tangent.
            0 => last,
            // Next to the last, or to the first.
            1 => [0, 1].map(|i| stepped(last[i], at[i] % 5)),
            2 => [0, 1].map(|i| stepped(first[i], at[i] % 5)),
            // Level with the first: a joint on the ray, or a tangent along it.
            3 => [fresh[0], first[1]],
            _ => fresh,
        });
    }
    all
}

/// A spline of degree 1 to 5 whose first and last control points are its ends.
pub(crate) fn spline() -> impl Strategy<Value = Spline> {
    let weights = prop::sample::select(vec![1.0, 1.0, 1.0, 0.5, 2.0, 4.0, 1.0 / 1024.0]);
    let drawn = (0u8..8, prop::array::uniform2(-127i8..=127), 0usize..7);
    (1usize..=5, inner(), prop::bool::ANY).prop_flat_map(move |(degree, inner, rational)| {
        let mut steps = vec![0; degree + 1];
        let mut at = 0;
        for (gap, times) in inner {
            at += gap;
            steps.extend(std::iter::repeat_n(at, times.min(degree)));
        }
        steps.extend(std::iter::repeat_n(at + 3, degree + 1));
        let count = steps.len() - degree - 1;
        let weights = prop::collection::vec(weights.clone(), count);
        (prop::collection::vec(drawn.clone(), count), weights).prop_map(move |(drawn, weights)| {
            let weight = |w: f64| if rational { w } else { 1.0 };
            let net = points(&drawn).into_iter().zip(weights);
            Spline {
                degree,
                net: net
                    .map(|([u, v], w)| [u * weight(w), v * weight(w), weight(w)])
                    .collect(),
                steps: steps.clone(),
            }
        })
    })
}

/// How far apart the sides of a sliver are: steps of f64, or a length.
fn width() -> impl Strategy<Value = [(i8, f64); 2]> {
    let one = prop_oneof![
        (-4i8..=4).prop_map(|n| (n, 0.0)),
        (30i32..52, any::<bool>()).prop_map(|(e, up)| {
            let length = (-f64::from(e)).exp2();
            (0, if up { length } else { -length })
        }),
    ];
    [one.clone(), one]
}

/// A spline there, and the same back, moved by a little: a sliver that may cross itself.
pub(crate) fn sliver() -> impl Strategy<Value = Vec<Spline>> {
    (spline(), width()).prop_map(|(there, width)| {
        let near = |p: [f64; 2]| [0, 1].map(|i| stepped(p[i] + width[i].1, width[i].0));
        let back = there.moved(near).turned();
        let (a, b) = (there.ends(), back.ends());
        vec![
            there,
            Spline::straight(a[1], b[0]),
            back,
            Spline::straight(b[1], a[0]),
        ]
    })
}

/// A spline and its chord.
fn bow() -> impl Strategy<Value = Vec<Spline>> {
    spline().prop_map(|s| {
        let [a, b] = s.ends();
        vec![s, Spline::straight(b, a)]
    })
}

/// A sliver or a bow.
pub(crate) fn one_loop() -> impl Strategy<Value = Vec<Spline>> {
    prop_oneof![bow(), sliver()]
}

/// One to three loops: slivers, bows, and a bow beside a sliver along its own curve.
pub(crate) fn loops() -> impl Strategy<Value = Vec<Vec<Spline>>> {
    let beside = (sliver(), any::<bool>()).prop_map(|(sliver, which)| {
        let along = sliver[if which { 0 } else { 2 }].clone();
        let [a, b] = along.ends();
        vec![sliver, vec![along, Spline::straight(b, a)]]
    });
    prop_oneof![prop::collection::vec(one_loop(), 1..=2), beside]
}

/// A point to ask about, of whatever loops there are.
#[derive(Clone, Debug)]
pub(crate) struct Aim {
    kind: u8,
    which: prop::sample::Index,
    part: f64,
    steps: [i8; 2],
}

pub(crate) fn aim() -> impl Strategy<Value = Aim> {
    let part = prop_oneof![0.0..=1.0f64, Just(0.0), Just(1.0)];
    let steps = prop::array::uniform2(-4i8..=4);
    (0u8..4, any::<prop::sample::Index>(), part, steps).prop_map(|(kind, which, part, steps)| Aim {
        kind,
        which,
        part,
        steps,
    })
}

impl Aim {
    /// Anywhere; up to 4 steps of f64 from a curve; likewise, but at the height of a joint; next to a control point.
    pub(crate) fn at(&self, loops: &[Vec<Spline>]) -> [f64; 2] {
        let all: Vec<&Spline> = loops.iter().flatten().collect();
        let curve = all[self.which.index(all.len())];
        let part = curve.at(self.part);
        let mark = on(&curve.net[self.which.index(curve.net.len())]);
        let near = match self.kind {
            0 => [32.0 * self.part - 16.0, 4.0 * f64::from(self.steps[0])],
            1 => part,
            2 => [part[0], curve.ends()[0][1]],
            _ => mark,
        };
        [0, 1].map(|i| stepped(near[i], self.steps[i]))
    }
}
