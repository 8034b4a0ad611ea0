//! Lines that touch a face, or nearly, against analysis.

use crate::scene::{Random, brep, dyadic, patch};
use feeler::numeric::Dyadic;
use feeler::nurbs::Surface;
use feeler::query::LineKind;
use feeler_oracle::{LineTruth, Oracle, TruthEnclosure};

fn oracle(s: Surface) -> Oracle {
    Oracle::new(&[&brep(s, None)]).unwrap()
}

fn line(o: &Oracle, origin: [f64; 3], direction: [f64; 3]) -> LineTruth {
    o.line(origin, direction, LineKind::Line).unwrap()
}

/// Whether `e` holds `x` and is no wider than 2^-150.
fn is_narrow_about(e: &TruthEnclosure, x: f64) -> bool {
    let limit: Dyadic = "1p-150".parse().unwrap();
    e.contains(&dyadic(x)) && e.width() <= limit
}

/// Bernstein coefficients over [0, 1] of a polynomial in x = 2 u - 1, degree 4, given its power
/// coefficients in x; exact for the small integers used here.
fn bernstein4(power: [f64; 5]) -> [f64; 5] {
    // (2 u - 1)^k has, in degree 4, the coefficients: sum over j of C(k, j) C(4 - k, i - j) (-1)^(k - j)
    // divided by C(4, i).
    let choose = |n: i32, k: i32| -> f64 {
        if k < 0 || k > n {
            return 0.0;
        }
        (0..k).fold(1.0, |c, i| c * f64::from(n - i) / f64::from(i + 1))
    };
    std::array::from_fn(|i| {
        let i = i as i32;
        (0..5)
            .map(|k: i32| {
                let sum: f64 = (0..=k)
                    .map(|j| {
                        let sign = if (k - j) % 2 == 0 { 1.0 } else { -1.0 };
                        sign * choose(k, j) * choose(4 - k, i - j)
                    })
                    .sum();
                power[k as usize] * sum / choose(4, i)
            })
            .sum()
    })
}

/// z = f(x) + g(y) over [-1, 1]^2, polynomials of degree 4 of which 24 times the coefficients are
/// integers; homogeneous points times 24, so that all is exact.
fn sum_of(f: [f64; 5], g: [f64; 5]) -> Surface {
    let exact = |c: [f64; 5]| bernstein4(c).map(|x| (24.0 * x).round());
    let (f, g) = (exact(f), exact(g));
    let mut net = Vec::new();
    for i in 0..5 {
        for j in 0..5 {
            let (x, y) = (i as f64 * 12.0 - 24.0, j as f64 * 12.0 - 24.0);
            net.push([x, y, f[i] + g[j], 24.0]);
        }
    }
    patch(4, 4, net)
}

#[test]
fn contacts_of_every_order() {
    // z = x^n + y: the line z = 0 = y meets it at x = 0, n-fold.
    for n in 1..=4usize {
        let mut f = [0.0; 5];
        f[n] = 1.0;
        let o = oracle(sum_of(f, [0.0, 1.0, 0.0, 0.0, 0.0]));
        let t = line(&o, [0.25, 0.0, 0.0], [1.0, 0.0, 0.0]);
        assert!(t.open.is_empty(), "{n}: {t:?}");
        assert_eq!(t.hits.len(), 1, "{n}: {t:?}");
        let h = &t.hits[0];
        assert!(is_narrow_about(&h.t, -0.25), "{n}: {t:?}");
        assert_eq!(h.multiplicity, Some(n as u32), "{t:?}");
        assert_eq!(h.transversal, n % 2 == 1);
        assert_eq!(h.tangential, n % 2 == 0);
        assert!(!h.boundary);
    }
}

#[test]
fn several_contacts_of_one_line() {
    // z = (x^2 - 1/4)^2 + y touches at x = -1/2 and 1/2, and z = (x^2 - 1/2)^2 + y at the conjugate pair
    // +-sqrt(1/2): no rational point helps there.
    for (square, root) in [(0.25, 0.5), (0.5, 0.5f64.sqrt())] {
        let f = [square * square, 0.0, -2.0 * square, 0.0, 1.0].map(|c: f64| 16.0 * c);
        let o = oracle(sum_of(f, [0.0, 16.0, 0.0, 0.0, 0.0]));
        let t = line(&o, [0.0; 3], [1.0, 0.0, 0.0]);
        assert!(t.open.is_empty(), "{t:?}");
        assert_eq!(t.hits.len(), 2, "{t:?}");
        for (h, x) in t.hits.iter().zip([-root, root]) {
            assert_eq!((h.multiplicity, h.tangential), (Some(2), true), "{t:?}");
            assert!((h.t.lo.approximate() - x).abs() < 1e-15);
            assert!(h.t.width() < dyadic(1e-45));
        }
    }
    // A touch and a crossing: z = x^2 (2 x + 1) + y.
    let o = oracle(sum_of([0.0, 0.0, 1.0, 2.0, 0.0], [0.0, 1.0, 0.0, 0.0, 0.0]));
    let t = line(&o, [0.0; 3], [1.0, 0.0, 0.0]);
    assert!(t.open.is_empty() && t.hits.len() == 2, "{t:?}");
    assert_eq!(t.hits[0].multiplicity, Some(1));
    assert_eq!(t.hits[1].multiplicity, Some(2));
    assert!(is_narrow_about(&t.hits[0].t, -0.5) && is_narrow_about(&t.hits[1].t, 0.0));
}

#[test]
fn bowl_touched_and_nearly_so() {
    // z = x^2 + y^2. The line through (a, b, a^2 + b^2) with direction (c, d, 2 (a c + b d)) touches.
    let bowl = [0.0, 0.0, 1.0, 0.0, 0.0];
    let o = oracle(sum_of(bowl, bowl));
    let mut g = Random(5);
    let mut eighth = || (g.range(-6.0, 7.0)).floor() / 8.0;
    for _ in 0..12 {
        let (a, b, c, d) = (eighth(), eighth(), eighth(), eighth() + 1.0);
        let at = [a, b, a * a + b * b];
        let direction = [c, d, 2.0 * (a * c + b * d)];
        let t = line(&o, at, direction);
        assert!(t.open.is_empty(), "{at:?} {direction:?} {t:?}");
        assert_eq!(t.hits.len(), 1, "{at:?} {direction:?} {t:?}");
        assert!(is_narrow_about(&t.hits[0].t, 0.0), "{t:?}");
        assert_eq!(t.hits[0].multiplicity, Some(2));
        // The next doubles above and below: two hits at +-sqrt(ulp / (c^2 + d^2)), and none.
        for (z, count) in [(at[2].next_up(), 2), (at[2].next_down(), 0)] {
            let t = line(&o, [a, b, z], direction);
            assert!(t.open.is_empty(), "{at:?} {direction:?} {t:?}");
            assert_eq!(t.hits.len(), count, "{at:?} {direction:?} {t:?}");
            let offset = ((z - at[2]) / (c * c + d * d)).sqrt();
            for (h, sign) in t.hits.iter().zip([-1.0, 1.0]) {
                assert_eq!(h.multiplicity, Some(1));
                assert!((h.t.lo.approximate() - sign * offset).abs() < 1e-12 * offset);
            }
        }
    }
    // Down to what a double can express next to the apex.
    for exponent in [-60, -200, -1000] {
        let z = 2f64.powi(exponent);
        let t = line(&o, [0.0, 0.0, z], [1.0, 0.0, 0.0]);
        assert!(t.open.is_empty() && t.hits.len() == 2, "{t:?}");
        for (h, x) in t
            .hits
            .iter()
            .zip([-2f64.powi(exponent / 2), 2f64.powi(exponent / 2)])
        {
            assert!(is_narrow_about(&h.t, x), "{t:?}");
        }
        let t = line(&o, [0.0, 0.0, -z], [1.0, 0.0, 0.0]);
        assert!(t.open.is_empty() && t.hits.is_empty(), "{t:?}");
    }
}

/// A rational biquadratic patch: a part of the unit sphere, by stereographic coordinates
/// (2 x, 2 y, 1 - x^2 - y^2) / (1 + x^2 + y^2), x and y over [-1/2, 1/2].
fn sphere_part() -> Surface {
    let mut net = Vec::new();
    // Bernstein of x: -1/2, 0, 1/2; of x^2: 1/4, -1/4, 1/4.
    let (x1, x2) = ([-0.5, 0.0, 0.5], [0.25, -0.25, 0.25]);
    for i in 0..3 {
        for j in 0..3 {
            let s = x2[i] + x2[j];
            net.push([2.0 * x1[i], 2.0 * x1[j], 1.0 - s, 1.0 + s]);
        }
    }
    patch(2, 2, net)
}

#[test]
fn sphere_against_its_quadric() {
    let o = oracle(sphere_part());
    let mut g = Random(11);
    let mut counts = [0; 3];
    for round in 0..60 {
        // Near the cap's top, tangent directions tilted and lifted by 1e-16 to 1e-2.
        let (a, b) = (g.range(-0.3, 0.3), g.range(-0.3, 0.3));
        let angle = g.range(0.0, std::f64::consts::TAU);
        let (c, d) = (angle.cos(), angle.sin());
        let z = (1.0 - a * a - b * b).sqrt();
        let lift = 10f64.powi(-(round % 15) - 2) * if round % 2 == 0 { 1.0 } else { -1.0 };
        let at = [a * (1.0 + lift), b * (1.0 + lift), z * (1.0 + lift)];
        let direction = [c, d, -(a * c + b * d) / z];
        // |at + t d|^2 = 1 exactly.
        let e = |x: f64| dyadic(x);
        let dot = |p: [f64; 3], q: [f64; 3]| {
            (0..3).fold(Dyadic::ZERO, |s, k| &s + &(&e(p[k]) * &e(q[k])))
        };
        let (aa, bb) = (dot(direction, direction), dot(at, direction));
        let cc = &dot(at, at) - &e(1.0);
        let discriminant = &(&bb * &bb) - &(&aa * &cc);
        let expected = match discriminant.approximate() {
            d if d > 0.0 => 2,
            d if d < 0.0 => 0,
            _ => 1,
        };
        let t = line(&o, at, direction);
        assert!(t.open.is_empty(), "{at:?} {direction:?} {t:?}");
        // The hits lie in the cap: their distance from `at` is at most 2 sqrt(lift).
        assert_eq!(t.hits.len(), expected, "{at:?} {direction:?} {t:?}");
        counts[expected] += 1;
        for h in &t.hits {
            // The quadric at the middle of t is about 0.
            let m = &h.t.lo;
            let f = &(&(&(&aa * m) + &(&bb * &e(2.0))) * m) + &cc;
            assert!(f.approximate().abs() < 1e-45, "{at:?} {direction:?} {t:?}");
        }
    }
    println!("none, one, two hits: {counts:?}");
    assert!(counts[0] > 10 && counts[2] > 10);
}
