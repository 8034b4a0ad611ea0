//! The last stage of the decision, which few points reach, against the definition: transitions of `[h(t) > 0]` where `r(t) > 0`.

use crate::numeric::polynomial::{Parameter, Polynomial};
use crate::numeric::{Dd, Dyadic};
use crate::trim::decide::{Chord, Crossing, general_crossing, monotone_crossing};
use dashu_int::IBig;

/// A polynomial `sign * (d t - n)^m * ...`.
#[derive(Clone, Debug)]
struct Factors {
    sign: i32,
    /// `n`, `d` and `m`.
    roots: Vec<(i64, i64, usize)>,
}

impl Factors {
    fn polynomial(&self) -> Polynomial {
        let start = Polynomial::new(vec![IBig::from(self.sign)]);
        self.roots.iter().fold(start, |p, &(n, d, m)| {
            let factor = Polynomial::new(vec![IBig::from(-n), IBig::from(d - n)]);
            (0..m).fold(p, |p, _| p.times(&factor))
        })
    }

    /// The sign at `n / d`.
    fn sign(&self, (n, d): (i64, i64)) -> i32 {
        self.roots.iter().fold(self.sign, |s, &(rn, rd, m)| {
            let one = (n * rd - rn * d).signum() as i32;
            s * one.pow(m as u32)
        })
    }
}

/// By the definition, on `[lo, hi]`: the state before each root and behind it.
fn defined(r: &Factors, h: &Factors, [lo, hi]: [(i64, i64); 2]) -> Crossing {
    let less = |a: (i64, i64), b: (i64, i64)| a.0 * b.1 < b.0 * a.1;
    let middle = |a: (i64, i64), b: (i64, i64)| (a.0 * b.1 + b.0 * a.1, 2 * a.1 * b.1);
    let mut stops = vec![lo, hi];
    let within = |t: &(i64, i64)| !less(*t, lo) && !less(hi, *t);
    let roots = h.roots.iter().map(|&(n, d, _)| (n, d));
    stops.extend(roots.filter(within));
    stops.sort_by(|a, b| (a.0 * b.1).cmp(&(b.0 * a.1)));
    stops.dedup_by(|a, b| a.0 * b.1 == b.0 * a.1);
    let above = |t: (i64, i64)| h.sign(t) > 0;
    let mut odd = false;
    for (i, &t) in stops.iter().enumerate() {
        if h.sign(t) == 0 && r.sign(t) == 0 {
            return Crossing::On;
        }
        // At the ends the part's own state counts: the next part begins with it.
        let before = match i {
            0 => above(t),
            _ => above(middle(stops[i - 1], t)),
        };
        let behind = match stops.get(i + 1) {
            None => above(t),
            Some(next) => above(middle(t, *next)),
        };
        odd ^= before != behind && r.sign(t) > 0;
    }
    Crossing::odd(odd)
}

const WHOLE: [(i64, i64); 2] = [(0, 1), (1, 1)];

#[test]
fn roots_of_any_multiplicity_and_at_the_ends() {
    // Of h: at both ends, at dyadics, at others; touching, crossing, flat crossing. Of r: between those, and at some of them.
    let places = [(0, 1), (1, 4), (3, 7), (5, 7), (1, 1)];
    let mut cases = 0;
    let mut seen = [0; 3];
    for number in 0..4usize.pow(5) {
        let times = [0, 1, 2, 3, 4].map(|i| number / 4usize.pow(i) % 4);
        let roots = { places.iter().zip(times) }
            .filter(|(_, m)| *m > 0)
            .map(|(&(n, d), m)| (n, d, m))
            .collect();
        let h = Factors {
            sign: if number % 3 == 0 { -1 } else { 1 },
            roots,
        };
        let r = Factors {
            sign: if number % 2 == 0 { -1 } else { 1 },
            roots: match number % 5 {
                0 => vec![],
                1 => vec![(1, 3, 1)],
                2 => vec![(1, 2, 2)],
                3 => vec![(1, 2, 1), (6, 7, 3)],
                _ => vec![(5, 7, 1)],
            },
        };
        let found = general_crossing(&r.polynomial(), &h.polynomial());
        assert_eq!(found, defined(&r, &h, WHOLE), "{r:?} {h:?}");
        seen[found as usize] += 1;
        cases += 1;
    }
    assert_eq!(cases, 1024);
    assert!(seen.iter().all(|n| *n > 50), "{seen:?}");
}

#[test]
fn monotone_parts_that_end_on_the_ray() {
    let places = [
        (-1, 1),
        (0, 1),
        (1, 4),
        (1, 3),
        (1, 2),
        (5, 7),
        (1, 1),
        (2, 1),
    ];
    let spans = [WHOLE, [(1, 4), (1, 1)], [(0, 1), (1, 2)], [(1, 4), (1, 2)]];
    let mut seen = [0; 3];
    for (i, &(a, b)) in places.iter().enumerate() {
        for (j, &(c, d)) in places.iter().enumerate() {
            for signs in 0..4 {
                for (k, span) in spans.iter().enumerate() {
                    let h = Factors {
                        sign: [1, -1][signs % 2],
                        roots: vec![(a, b, 1 + 2 * ((i + k) % 2))],
                    };
                    let r = Factors {
                        sign: [1, -1][signs / 2],
                        roots: vec![(c, d, 1 + 2 * ((j + k) % 2))],
                    };
                    let [lo, hi] = span.map(|(n, d)| {
                        Parameter::from_f64(n as f64 / d as f64).expect("a dyadic of [0, 1]")
                    });
                    let near = [None, Some(Dd::from(a as f64 / b as f64))];
                    for near in near {
                        let (pr, ph) = (r.polynomial(), h.polynomial());
                        let found = monotone_crossing(&pr, &ph, lo.clone(), hi.clone(), near);
                        assert_eq!(found, defined(&r, &h, *span), "{r:?} {h:?} {span:?}");
                        seen[found as usize] += 1;
                    }
                }
            }
        }
    }
    assert!(seen.iter().all(|n| *n > 50), "{seen:?}");
}

#[test]
fn a_chord_knows_its_rounding() {
    let exact = |x: f64| Dyadic::from_f64(x).unwrap();
    let mut state = 1u64;
    let mut unit = || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut rounded = 0;
    for _ in 0..2000 {
        let (base, step) = ([unit(), 1e3 * unit()], [unit() - 0.5, unit() - 0.5]);
        let t = unit();
        // On the chord but for rounding, where products cancel.
        let q = [0, 1].map(|k| base[k] + t * step[k]);
        let (level, error) = Chord { base, step }.level(q);
        let along = |k: usize| &exact(q[k]) - &exact(base[k]);
        let truth = &(&along(0) * &exact(step[1])) - &(&along(1) * &exact(step[0]));
        let off = &truth - &exact(level);
        assert!(
            off <= exact(error) && -&off <= exact(error),
            "{base:?} {step:?} {q:?}"
        );
        rounded += usize::from(off != Dyadic::ZERO);
    }
    assert!(rounded > 1000, "{rounded}");
}

/// A root that both have beyond the part is none on it: both rise on [0, 1], h is 0 at 1/3, r before it or after it.
#[test]
fn common_roots_elsewhere() {
    let of = |n, d| {
        let roots = vec![(-1, 1, 1), (n, d, 1)];
        Factors { sign: 1, roots }.polynomial()
    };
    for (n, d, expected) in [(1, 4, Crossing::Odd), (1, 2, Crossing::Even)] {
        let (lo, hi) = (Parameter::zero(), Parameter::one());
        let found = monotone_crossing(&of(n, d), &of(1, 3), lo, hi, None);
        assert_eq!(found, expected, "{n}/{d}");
    }
}
