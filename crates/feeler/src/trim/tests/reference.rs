//! The definition of the region, computed by other means: power-basis polynomials over the rationals from
//! the Cox-de Boor recursion, a ray in a skew direction, Sturm sequences.

use crate::brep::Brep;
use crate::nurbs::{Curve, Curve2};
use crate::trim::Side;
use dashu_ratio::RBig;

type Poly = Vec<RBig>;

fn r(x: f64) -> RBig {
    RBig::try_from(x).unwrap()
}

fn trim_zeros(mut p: Poly) -> Poly {
    while p.last().is_some_and(|c| *c == RBig::ZERO) {
        p.pop();
    }
    p
}

fn add(a: &Poly, b: &Poly) -> Poly {
    let n = a.len().max(b.len());
    trim_zeros(
        (0..n)
            .map(|i| {
                a.get(i).cloned().unwrap_or(RBig::ZERO) + b.get(i).cloned().unwrap_or(RBig::ZERO)
            })
            .collect(),
    )
}

fn scaled(a: &Poly, s: &RBig) -> Poly {
    trim_zeros(a.iter().map(|c| c * s).collect())
}

fn mul(a: &Poly, b: &Poly) -> Poly {
    if a.is_empty() || b.is_empty() {
        return vec![];
    }
    let mut c = vec![RBig::ZERO; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            c[i + j] += x * y;
        }
    }
    trim_zeros(c)
}

fn at(p: &Poly, t: &RBig) -> RBig {
    p.iter().rev().fold(RBig::ZERO, |s, c| s * t + c)
}

fn remainder(a: &Poly, d: &Poly) -> Poly {
    let mut a = a.clone();
    while a.len() >= d.len() {
        let f = a.last().unwrap() / d.last().unwrap();
        let base = a.len() - d.len();
        for (i, c) in d.iter().enumerate() {
            a[base + i] -= c * &f;
        }
        a.pop();
        a = trim_zeros(a);
    }
    a
}

fn derivative(p: &Poly) -> Poly {
    trim_zeros(
        p.iter()
            .enumerate()
            .skip(1)
            .map(|(i, c)| c * RBig::from(i))
            .collect(),
    )
}

fn gcd(a: &Poly, b: &Poly) -> Poly {
    let (mut a, mut b) = (a.clone(), b.clone());
    while !b.is_empty() {
        let rest = remainder(&a, &b);
        a = b;
        b = rest;
        if let Some(lead) = b.last().cloned() {
            b = scaled(&b, &(RBig::ONE / lead));
        }
    }
    a
}

/// Number of distinct roots in `(a, b]`.
fn sturm(p: &Poly, a: &RBig, b: &RBig) -> usize {
    let mut chain = vec![p.clone(), derivative(p)];
    while chain.last().is_some_and(|l| !l.is_empty()) {
        let n = chain.len();
        let rest = remainder(&chain[n - 2], &chain[n - 1]);
        // A positive factor keeps the numbers short.
        let size = rest
            .last()
            .map(|l| if *l < RBig::ZERO { -l } else { l.clone() });
        chain.push(match size {
            Some(s) => scaled(&rest, &(RBig::from(-1) / s)),
            None => rest,
        });
    }
    let changes = |t: &RBig| {
        let mut last = 0;
        let mut count = 0usize;
        for p in &chain {
            let v = at(p, t);
            let s = if v > RBig::ZERO {
                1
            } else if v < RBig::ZERO {
                -1
            } else {
                0
            };
            if s != 0 {
                count += usize::from(last != 0 && last != s);
                last = s;
            }
        }
        count
    };
    changes(a) - changes(b)
}

/// Homogeneous power-basis polynomials over `[from, to]`.
struct Piece {
    xyw: [Poly; 3],
    from: RBig,
    to: RBig,
}

fn spans(curve: &Curve2, span: [f64; 2]) -> Vec<Piece> {
    let (degree, points, knots): (usize, Vec<[f64; 3]>, Vec<f64>) = match curve {
        Curve::Line(l) => (
            1,
            vec![[l.from.x, l.from.y, 1.0], [l.to.x, l.to.y, 1.0]],
            vec![l.domain.start, l.domain.start, l.domain.end, l.domain.end],
        ),
        Curve::Polyline(l) => {
            let t = l.params();
            let mut knots = vec![t[0]];
            knots.extend(t);
            knots.push(t[t.len() - 1]);
            (
                1,
                l.points().iter().map(|p| [p.x, p.y, 1.0]).collect(),
                knots,
            )
        }
        Curve::Nurbs(n) => (
            n.degree(),
            n.control_points()
                .iter()
                .map(|p| [p[0], p[1], p[2]])
                .collect(),
            n.knots().knots().to_vec(),
        ),
        _ => panic!("not in the reference"),
    };
    let mut out = Vec::new();
    for i in degree..points.len() {
        let (lo, hi) = (knots[i].max(span[0]), knots[i + 1].min(span[1]));
        if lo >= hi {
            continue;
        }
        // Basis functions on this span, as polynomials.
        let mut basis: Vec<Poly> = vec![vec![]; points.len() + degree];
        basis[i] = vec![RBig::ONE];
        for p in 1..=degree {
            for j in 0..points.len() + degree - p {
                let mut sum = vec![];
                let width = r(knots[j + p]) - r(knots[j]);
                if width != RBig::ZERO {
                    let linear = vec![-r(knots[j]) / &width, RBig::ONE / &width];
                    sum = mul(&basis[j], &linear);
                }
                let width = r(knots[j + p + 1]) - r(knots[j + 1]);
                if width != RBig::ZERO {
                    let linear = vec![r(knots[j + p + 1]) / &width, RBig::from(-1) / &width];
                    sum = add(&sum, &mul(&basis[j + 1], &linear));
                }
                basis[j] = sum;
            }
        }
        let xyw = [0, 1, 2].map(|c| {
            points
                .iter()
                .zip(&basis)
                .fold(vec![], |s, (p, b)| add(&s, &scaled(b, &r(p[c]))))
        });
        out.push(Piece {
            xyw,
            from: r(lo),
            to: r(hi),
        });
    }
    out
}

/// All the pieces of all loops of face 0, with the joins.
pub(super) struct Reference {
    pieces: Vec<Piece>,
    domain: [[RBig; 2]; 2],
    untrimmed: bool,
}

/// Of slivers and cusps some steps of f64 away coincidences rule out several.
const DIRECTIONS: [(i64, i64); 12] = [
    (101, 7919),
    (7907, -307),
    (-5003, 1009),
    (-211, -6007),
    (3_000_017, 1_000_003),
    (-1_299_709, 15_485_863),
    (-2_750_159, -611_953),
    (32_452_843, -49_979_687),
    (67_867_967, 86_028_121),
    (-104_395_301, 9_737_333),
    (-7_368_787, -141_650_939),
    (179_424_673, -1_986_001),
];

impl Reference {
    pub(super) fn new(brep: &Brep) -> Self {
        let parts = brep.parts();
        let d = brep.surface(0).domain();
        let mut pieces = Vec::new();
        for &l in parts.faces[0].loops.iter().flatten() {
            let mut ends: Vec<[[RBig; 2]; 2]> = Vec::new();
            for &t in &parts.loops[l].trims {
                let trim = &parts.trims[t];
                let curve = &parts.curves2[trim.curve];
                let own = spans(curve, [trim.span.start, trim.span.end]);
                let point = |p: &Piece, t: &RBig| {
                    let w = at(&p.xyw[2], t);
                    [at(&p.xyw[0], t) / &w, at(&p.xyw[1], t) / &w]
                };
                let first = point(&own[0], &own[0].from);
                let last = own.last().unwrap();
                let last = point(last, &last.to);
                ends.push(if trim.reversed {
                    [last, first]
                } else {
                    [first, last]
                });
                pieces.extend(own);
            }
            for i in 0..ends.len() {
                let (a, b) = (&ends[i][1], &ends[(i + 1) % ends.len()][0]);
                if a != b {
                    let linear = |k: usize| trim_zeros(vec![a[k].clone(), &b[k] - &a[k]]);
                    pieces.push(Piece {
                        xyw: [linear(0), linear(1), vec![RBig::ONE]],
                        from: RBig::ZERO,
                        to: RBig::ONE,
                    });
                }
            }
        }
        Self {
            pieces,
            domain: d.map(|i| [r(i.start), r(i.end)]),
            untrimmed: parts.faces[0].loops.is_none(),
        }
    }

    pub(super) fn side(&self, q: [f64; 2]) -> Side {
        let q = q.map(r);
        let d = &self.domain;
        if (0..2).any(|i| q[i] < d[i][0] || q[i] > d[i][1]) {
            return Side::Outside;
        }
        let border = (0..2).any(|i| q[i] == d[i][0] || q[i] == d[i][1]);
        let mut odd = self.untrimmed;
        if !self.untrimmed {
            // A direction that some coincidence rules out is replaced by the next.
            let parity = DIRECTIONS
                .into_iter()
                .find_map(|d| self.parity(&q, [RBig::from(d.0), RBig::from(d.1)]));
            match parity.expect("a direction in general position") {
                None => return Side::Boundary,
                Some(p) => odd = p,
            }
        }
        match (odd, border) {
            (false, _) => Side::Outside,
            (true, true) => Side::Boundary,
            (true, false) => Side::Inside,
        }
    }

    /// `None`: not in general position; `Some(None)`: on a loop.
    fn parity(&self, q: &[RBig; 2], d: [RBig; 2]) -> Option<Option<bool>> {
        let mut odd = false;
        for p in &self.pieces {
            let offset = |i: usize| add(&p.xyw[i], &scaled(&p.xyw[2], &-&q[i]));
            let (x, y) = (offset(0), offset(1));
            let common = gcd(&x, &y);
            if common.is_empty() || at(&common, &p.from) == RBig::ZERO {
                return Some(None);
            }
            if common.len() > 1 && sturm(&common, &p.from, &p.to) > 0 {
                return Some(None);
            }
            let across = add(&scaled(&x, &d[1]), &scaled(&y, &-&d[0]));
            let ahead = add(&scaled(&x, &d[0]), &scaled(&y, &d[1]));
            if across.is_empty()
                || gcd(&across, &derivative(&across)).len() > 1
                || at(&across, &p.from) == RBig::ZERO
                || at(&across, &p.to) == RBig::ZERO
            {
                return None;
            }
            let mut stack = vec![(p.from.clone(), p.to.clone())];
            while let Some((a, b)) = stack.pop() {
                let n = sturm(&across, &a, &b);
                if n == 0 {
                    continue;
                }
                let ahead_roots = if ahead.is_empty() {
                    1
                } else {
                    sturm(&ahead, &a, &b) + usize::from(at(&ahead, &a) == RBig::ZERO)
                };
                if n == 1 && ahead_roots == 0 {
                    odd ^= at(&ahead, &b) > RBig::ZERO;
                    continue;
                }
                let mid = (&a + &b) / RBig::from(2);
                stack.push((a, mid.clone()));
                stack.push((mid, b));
            }
        }
        Some(Some(odd))
    }
}
