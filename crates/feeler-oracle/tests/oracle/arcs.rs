//! Sides in uv where loops hold circular arcs, and where they are many, against exact predicates.

use crate::scene::{Random, brep, changed, interval, line, plane, polygon};
use dashu_int::IBig;
use dashu_ratio::RBig;
use feeler::brep::Brep;
use feeler::numeric::Dyadic;
use feeler::nurbs::{Arc, Curve2};
use feeler::query::LineKind;
use feeler::trim::Side;
use feeler_oracle::Oracle;
use nalgebra::{Point2, Vector2};
use std::cmp::Ordering;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn oracle(b: &Brep) -> Oracle {
    Oracle::new(&[b]).unwrap()
}

fn exact(x: f64) -> RBig {
    let d = Dyadic::from_f64(x).unwrap();
    let power = IBig::ONE << usize::try_from(d.exponent().unsigned_abs()).unwrap();
    if d.exponent() >= 0 {
        RBig::from(d.mantissa() * power)
    } else {
        RBig::from_parts(d.mantissa().clone(), power.try_into().unwrap())
    }
}

/// `|q - c|^2` against `r^2`.
fn against(q: [f64; 2], c: [f64; 2], r: f64) -> Ordering {
    let d = [exact(q[0]) - exact(c[0]), exact(q[1]) - exact(c[1])];
    (&d[0] * &d[0] + &d[1] * &d[1]).cmp(&(exact(r) * exact(r)))
}

/// The sign of `(b - a) x (q - a)`.
fn left_of(a: [f64; 2], b: [f64; 2], q: [f64; 2]) -> Ordering {
    let at = |p: [f64; 2], k: usize| exact(p[k]) - exact(a[k]);
    (at(b, 0) * at(q, 1)).cmp(&(at(b, 1) * at(q, 0)))
}

fn arc(c: [f64; 2], r: f64, x: [f64; 2], clockwise: bool, angle: [f64; 2]) -> Curve2 {
    let turn = if clockwise { -1.0 } else { 1.0 };
    Curve2::Arc(
        Arc::new(Arc {
            center: Point2::from(c),
            x: Vector2::from(x),
            // Any vector on that side.
            y: Vector2::new(-x[1] * turn + 0.25 * x[0], x[0] * turn + 0.25 * x[1]),
            z: Vector2::zeros(),
            radius: r,
            angle: interval(angle[0], angle[1]),
            domain: interval(-1.0, 3.0),
        })
        .unwrap(),
    )
}

fn nudged(x: f64, ulps: i32) -> f64 {
    (0..ulps.unsigned_abs()).fold(x, |x, _| if ulps > 0 { x.next_up() } else { x.next_down() })
}

/// Points within some ulps of the circle, spread over it, and near angle `special`.
fn near_circle(g: &mut Random, c: [f64; 2], r: f64, special: &[f64]) -> [f64; 2] {
    let a = if g.next() < 0.5 {
        g.range(0.0, TAU)
    } else {
        let at = ((g.next() * special.len() as f64) as usize).min(special.len() - 1);
        special[at] + 10f64.powf(g.range(-17.0, -1.0)) * (2.0 * g.next() - 1.0)
    };
    let r = r * (1.0 + 10f64.powf(g.range(-18.0, -1.0)) * (2.0 * g.next() - 1.0));
    let mut q = [c[0] + r * a.cos(), c[1] + r * a.sin()];
    for x in &mut q {
        *x = nudged(*x, (g.range(-3.0, 3.0)).round() as i32);
    }
    q
}

#[test]
fn full_circles_are_decided_exactly() {
    let mut g = Random(17);
    // (3, 4) has a rational length, (1, 2) has not: the ends of the loop are irrational then even at
    // angle 0.
    for (x, clockwise, c, r) in [
        ([1.0, 0.0], false, [0.0, 0.0], 5.0),
        ([0.0, 3.0], true, [0.125, -1.5], 2.5),
        ([3.0, 4.0], false, [0.3, 0.7], 0.1),
        ([1.0, 2.0], false, [-0.3, 1.0], 3.0),
        ([-2.0, 1e-3], true, [1.0 / 3.0, 0.1], 1.7),
    ] {
        for (parts, reversed) in [([0.0, PI, TAU], false), ([-0.3, 1.0, TAU - 0.3], true)] {
            let loops = if reversed {
                vec![
                    arc(c, r, x, clockwise, [parts[1], parts[2]]),
                    arc(c, r, x, clockwise, [parts[0], parts[1]]),
                ]
            } else {
                vec![
                    arc(c, r, x, clockwise, [parts[0], parts[1]]),
                    arc(c, r, x, clockwise, [parts[1], parts[2]]),
                ]
            };
            let b = changed(&brep(plane(8.0), Some(vec![loops])), |p| {
                for t in &mut p.trims {
                    t.reversed = reversed;
                }
            });
            let o = oracle(&b);
            let turn = if clockwise { -1.0 } else { 1.0 };
            let own = x[1].atan2(x[0]);
            let special = [
                own,
                own + turn * parts[0],
                own + turn * parts[1],
                0.0,
                FRAC_PI_2,
                PI,
                -FRAC_PI_2,
            ];
            let mut seen = [0; 3];
            for k in 0..500 {
                let mut q = near_circle(&mut g, c, r, &special);
                if k % 10 == 0 {
                    // Exactly on it, where that is representable.
                    q = [
                        [c[0] + r, c[1]],
                        [c[0] - r, c[1]],
                        [c[0], c[1] + r],
                        [c[0], c[1] - r],
                        [c[0] + 0.6 * r, c[1] - 0.8 * r],
                    ][k / 10 % 5];
                }
                let truth = o.side(0, q).unwrap();
                // In the box of the loop's two ends, which do not quite meet, the segment decides.
                if truth.in_gap {
                    continue;
                }
                let expected = match against(q, c, r) {
                    Ordering::Less => Side::Inside,
                    Ordering::Equal => Side::Boundary,
                    Ordering::Greater => Side::Outside,
                };
                seen[expected as usize] += 1;
                assert_eq!(truth.side, expected, "{x:?} {clockwise} {reversed} {q:?}");
            }
            assert!(seen[0] > 50 && seen[1] > 50, "{seen:?}");
        }
    }
}

#[test]
fn rounded_rectangles_are_decided_exactly() {
    // [-3, 3] x [-2, 2] with corners of radius 0.75, and a hole likewise, clockwise.
    fn rounded(w: f64, h: f64, r: f64) -> Vec<Curve2> {
        let (a, b) = (w - r, h - r);
        let x = [1.0, 0.0];
        vec![
            line([-a, -h], [a, -h]),
            arc([a, -b], r, x, false, [-FRAC_PI_2, 0.0]),
            line([w, -b], [w, b]),
            arc([a, b], r, x, false, [0.0, FRAC_PI_2]),
            line([a, h], [-a, h]),
            arc([-a, b], r, x, false, [FRAC_PI_2, PI]),
            line([-w, b], [-w, -b]),
            arc([-a, -b], r, [0.0, -1.0], true, [0.0, FRAC_PI_2]),
        ]
    }
    fn inside(q: [f64; 2], w: f64, h: f64, r: f64) -> Ordering {
        let (x, y) = (q[0].abs(), q[1].abs());
        let (a, b) = (w - r, h - r);
        if x > a && y > b {
            return against([x, y], [a, b], r);
        }
        if x > w || y > h {
            return Ordering::Greater;
        }
        if x == w || y == h {
            Ordering::Equal
        } else {
            Ordering::Less
        }
    }
    // The last corner is given clockwise from below: it is run backwards.
    let b = changed(
        &brep(
            plane(8.0),
            Some(vec![rounded(3.0, 2.0, 0.75), rounded(1.5, 1.0, 0.25)]),
        ),
        |p| {
            p.trims[7].reversed = true;
            p.trims[15].reversed = true;
        },
    );
    let o = oracle(&b);
    let mut g = Random(23);
    let mut gaps = 0;
    for k in 0..3000 {
        let (w, h, r) = if k % 2 == 0 {
            (3.0, 2.0, 0.75)
        } else {
            (1.5, 1.0, 0.25)
        };
        let q = match k % 6 {
            0 | 1 => [g.range(-4.0, 4.0), g.range(-3.0, 3.0)],
            2 | 3 => {
                let c = [w - r, h - r];
                let q = near_circle(&mut g, c, r, &[0.0, FRAC_PI_2]);
                let flip = |x: f64, f: f64| if f < 0.5 { -x } else { x };
                [flip(q[0], g.next()), flip(q[1], g.next())]
            }
            _ => {
                let up = (g.range(-3.0, 3.0)).round() as i32;
                if g.next() < 0.5 {
                    [nudged(w, up), g.range(-h, h)]
                } else {
                    [g.range(-w, w), nudged(-h, up)]
                }
            }
        };
        let truth = o.side(0, q).unwrap();
        if truth.in_gap {
            gaps += 1;
            continue;
        }
        let (outer, inner) = (inside(q, 3.0, 2.0, 0.75), inside(q, 1.5, 1.0, 0.25));
        let expected = match (outer, inner) {
            (Ordering::Equal, _) | (_, Ordering::Equal) => Side::Boundary,
            (Ordering::Less, Ordering::Greater) => Side::Inside,
            _ => Side::Outside,
        };
        assert_eq!(truth.side, expected, "{q:?}");
    }
    assert!(gaps < 100, "{gaps}");
}

#[test]
fn ends_of_arcs_are_decided_exactly() {
    // A slice of a pie: its straight sides end at f64, the arc at transcendental points.
    let (c, r) = ([0.25, -0.5], 3.0);
    let mut g = Random(29);
    for [from, to] in [
        [0.3, 1.1],
        [-0.2, 0.2],
        [1.5, 1.7],
        [2.0, 4.9],
        [-1e-9, 1e-9],
    ] {
        let end = |a: f64| [c[0] + r * a.cos(), c[1] + r * a.sin()];
        let (p, q) = (end(from), end(to));
        let o = oracle(&brep(
            plane(8.0),
            Some(vec![vec![
                line(c, p),
                arc(c, r, [1.0, 0.0], false, [from, to]),
                line(q, c),
            ]]),
        ));
        let convex = to - from < PI;
        assert_eq!(o.side(0, p).unwrap().side, Side::Boundary);
        assert_eq!(o.side(0, q).unwrap().side, Side::Boundary);
        assert!(o.side(0, p).unwrap().in_gap);
        let mut gaps = 0;
        for _ in 0..800 {
            let at = near_circle(&mut g, c, r, &[from, to]);
            let truth = o.side(0, at).unwrap();
            if truth.in_gap {
                gaps += 1;
                continue;
            }
            let (after, before) = (left_of(c, p, at), left_of(c, q, at).reverse());
            let between = if convex {
                after.min(before)
            } else {
                after.max(before)
            };
            let expected = match (against(at, c, r), between) {
                (Ordering::Greater, _) | (_, Ordering::Less) => Side::Outside,
                (Ordering::Less, Ordering::Greater) => Side::Inside,
                _ => Side::Boundary,
            };
            // A point on the line beyond its end is on no side of the slice.
            assert_eq!(truth.side, expected, "[{from}, {to}] {at:?}");
        }
        assert!(gaps < 400, "{gaps}");
    }
}

#[test]
fn many_turns_count_modulo_two() {
    // Two turns and a half: the circle is boundary, its upper half is odd, closed by the diameter.
    let c = [0.0, 0.0];
    let at = |turns: f64, q: [f64; 2]| {
        let loops = vec![arc(c, 2.0, [1.0, 0.0], false, [0.0, turns * TAU])];
        oracle(&brep(plane(8.0), Some(vec![loops])))
            .side(0, q)
            .unwrap()
            .side
    };
    assert_eq!(at(2.5, [0.1, 1.0]), Side::Inside);
    assert_eq!(at(2.5, [0.1, -1.0]), Side::Outside);
    assert_eq!(at(2.5, [0.0, -2.0]), Side::Boundary);
    assert_eq!(at(3.0, [0.1, -1.0]), Side::Inside);
    assert_eq!(at(4.0, [0.1, -1.0]), Side::Outside);
    assert_eq!(at(4.0, [-2.0, 0.0]), Side::Boundary);
    assert_eq!(at(4.0, [-2.1, 0.0]), Side::Outside);
    assert_eq!(at(100_000_000.5, [0.1, 1.9]), Side::Inside);
}

#[test]
fn margins_to_arcs_are_exact() {
    // Lines through a plate with a round hole: `crossings` is known where the box of 2^-10 of the
    // domain around the hit is clear of the loops.
    let (c, r, half) = ([0.5, -0.25], 1.5, 4.0);
    let square = polygon(&[[-half, -half], [half, -half], [half, half], [-half, half]]);
    let hole = vec![
        arc(c, r, [1.0, 0.0], true, [0.0, PI]),
        arc(c, r, [1.0, 0.0], true, [PI, TAU]),
    ];
    let o = oracle(&brep(plane(half), Some(vec![square, hole])));
    let margin = 2.0 * half / 1024.0;
    let mut g = Random(31);
    let mut known = 0;
    for _ in 0..400 {
        let a = g.range(0.0, TAU);
        let d = r + margin * g.range(-1.6, 1.6);
        let q = [c[0] + d * a.cos(), c[1] + d * a.sin()];
        let truth = o
            .line([q[0], q[1], 1.0], [0.0, 0.0, -1.0], LineKind::Line)
            .unwrap();
        // Corner differences to the centre: the nearest and the farthest.
        let mut near = [0.0; 2];
        let mut far = [0.0; 2];
        for k in 0..2 {
            let x = (q[k] - c[k]).abs();
            near[k] = (x - margin).max(0.0);
            far[k] = x + margin;
        }
        let reach = |v: [f64; 2]| v[0].hypot(v[1]);
        // Doubles do for all but the closest calls.
        let slack = 1e-12;
        if reach(near) > r + slack || reach(far) < r - slack {
            assert!(truth.crossings.is_some(), "{q:?}");
            assert_eq!(truth.crossings, Some(usize::from(d > r)));
            known += 1;
        } else if let Some(crossings) = truth.crossings {
            // Within the margin of the arc, but off its image, as far as that is known.
            assert_eq!(crossings, usize::from(d > r), "{q:?}");
        }
    }
    assert!((50..350).contains(&known), "{known}");
}

// ---- many arcs

/// Teeth of width 1/2 at k, k + 1, ... from v = 0 to 1 above a bar down to -1, as one loop of
/// about 4 n arcs. With round tips.
fn comb(n: usize, round: bool) -> Vec<Curve2> {
    let mut loops = vec![line([n as f64, -1.0], [n as f64, 0.0])];
    for k in (0..n).rev() {
        let x = k as f64;
        loops.push(line([x + 1.0, 0.0], [x + 0.5, 0.0]));
        loops.push(line([x + 0.5, 0.0], [x + 0.5, 1.0]));
        if round {
            loops.push(arc([x + 0.25, 1.0], 0.25, [1.0, 0.0], false, [0.0, PI]));
        } else {
            loops.push(line([x + 0.5, 1.0], [x, 1.0]));
        }
        loops.push(line([x, 1.0], [x, 0.0]));
    }
    loops.push(line([0.0, 0.0], [0.0, -1.0]));
    loops.push(line([0.0, -1.0], [n as f64, -1.0]));
    loops
}

fn comb_side(q: [f64; 2], n: usize, round: bool) -> Side {
    let (x, y) = (q[0] - q[0].floor(), q[1]);
    if !(0.0..=n as f64).contains(&q[0]) || y < -1.0 {
        return Side::Outside;
    }
    if y == -1.0 || q[0] == 0.0 && y <= 1.0 || q[0] == n as f64 && y <= 0.0 {
        return Side::Boundary;
    }
    if y < 0.0 {
        return Side::Inside;
    }
    if q[0] == n as f64 {
        return Side::Outside;
    }
    if y == 0.0 && (x >= 0.5 || x == 0.0) {
        return Side::Boundary;
    }
    if y <= 1.0 {
        return match x.partial_cmp(&0.5).unwrap() {
            _ if x == 0.0 => Side::Boundary,
            Ordering::Equal => Side::Boundary,
            Ordering::Greater => Side::Outside,
            Ordering::Less if y == 1.0 && !round => Side::Boundary,
            Ordering::Less => Side::Inside,
        };
    }
    if !round {
        return Side::Outside;
    }
    match against(q, [q[0].floor() + 0.25, 1.0], 0.25) {
        Ordering::Less => Side::Inside,
        Ordering::Equal => Side::Boundary,
        Ordering::Greater => Side::Outside,
    }
}

fn micros(mut times: Vec<std::time::Duration>) -> [f64; 2] {
    times.sort();
    [times.len() / 2, times.len() * 99 / 100].map(|i| times[i].as_secs_f64() * 1e6)
}

fn ask_comb(n: usize, round: bool, queries: usize) {
    let o = oracle(&brep(plane(2.0 * n as f64), Some(vec![comb(n, round)])));
    let start = std::time::Instant::now();
    let _ = o.side(0, [0.25, 0.5]).unwrap();
    let prepared = start.elapsed();
    let mut g = Random(37);
    let mut times = Vec::new();
    for k in 0..queries {
        let x = g.range(-0.01, 1.01) * n as f64;
        let ulps = (g.range(-2.0, 2.0)).round() as i32;
        let q = match k % 5 {
            0 => [x, g.range(-1.5, 1.5)],
            1 => [nudged((2.0 * x).round() / 2.0, ulps), g.range(-1.2, 1.2)],
            2 => [x, [0.0, 1.0, -1.0][k % 3]],
            3 => [x, nudged([0.0, 1.0, -1.0][k % 3], ulps)],
            _ => [
                nudged(x.floor() + 0.25 + 0.15, ulps),
                nudged(1.0 + 0.2, ulps),
            ],
        };
        let start = std::time::Instant::now();
        let truth = o.side(0, q).unwrap();
        times.push(start.elapsed());
        if !truth.in_gap {
            assert_eq!(truth.side, comb_side(q, n, round), "{q:?}");
        }
    }
    let [median, p99] = micros(times);
    println!(
        "comb of {} arcs, round {round}: prepared in {prepared:?}, side {median:.1} / {p99:.1} us",
        4 * n + 3
    );
}

#[test]
fn combs_are_decided_exactly() {
    ask_comb(50, false, 1000);
    ask_comb(50, true, 1000);
    ask_comb(2500, false, 1000);
}

/// Figures: `cargo test --release -p feeler-oracle --features cgal --test arcs -- --ignored
/// --nocapture`.
#[test]
#[ignore = "a measurement"]
fn large_combs() {
    ask_comb(50_000, false, 5000);
    ask_comb(50_000, true, 5000);
}

#[test]
fn nested_islands_are_decided_exactly() {
    // Squares and circles within each other: the parity changes at each.
    let n = 300;
    let loops: Vec<Vec<Curve2>> = (1..=n)
        .map(|k| {
            let r = f64::from(k);
            if k % 2 == 0 {
                // Between the circles of radius k - 1 and k + 1 (in the Chebyshev norm a square of
                // this half width would cut them).
                let a = 0.6875 * r;
                polygon(&[[-a, -a], [a, -a], [a, a], [-a, a]])
            } else {
                vec![
                    arc([0.0; 2], r, [1.0, 0.0], false, [0.0, PI]),
                    arc([0.0; 2], r, [1.0, 0.0], false, [PI, TAU]),
                ]
            }
        })
        .collect();
    let o = oracle(&brep(plane(2.0 * f64::from(n)), Some(loops)));
    let mut g = Random(41);
    let mut times = Vec::new();
    for _ in 0..1000 {
        let size = f64::from(n) * g.next();
        let q = [size * g.range(-1.0, 1.0), size * g.range(-1.0, 1.0)];
        let mut odd = false;
        for k in 1..=n {
            let r = f64::from(k);
            odd ^= if k % 2 == 0 {
                let a = 0.6875 * r;
                q[0].abs() < a && q[1].abs() < a
            } else {
                against(q, [0.0; 2], r) == Ordering::Less
            };
        }
        let start = std::time::Instant::now();
        let truth = o.side(0, q).unwrap();
        times.push(start.elapsed());
        assert_eq!(truth.side == Side::Inside, odd, "{q:?}");
    }
    let [median, p99] = micros(times);
    println!("{n} nested islands: side {median:.1} / {p99:.1} us");
}
