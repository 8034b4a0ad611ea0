//! Halving against Sturm chains, which count crossings one by one; both against polynomials whose roots are known.

use super::super::polynomial::binomials;
use super::*;

fn big(c: &[i64]) -> Vec<IBig> {
    c.iter().map(|x| IBig::from(*x)).collect()
}

/// Numbers without pattern.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, n: i64) -> i64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as i64 % n
    }

    /// From -size to size, times 2^shift, all of its bits in use.
    fn about(&mut self, size: i64, shift: usize) -> IBig {
        let mut n = IBig::from(self.below(2 * size + 1) - size);
        for _ in 0..shift.div_ceil(30) {
            n = (n << 30) + IBig::from(self.below(1 << 30));
        }
        n
    }
}

/// Where both ways say something they must agree; whether h and g have a common root, or how often the ray is passed.
#[derive(PartialEq)]
enum Both {
    Shared,
    Passed(i64),
    Neither,
}

fn both(h: &[IBig], g: &[IBig]) -> Both {
    let [p, q] = [h, g].map(Polynomial::from_bernstein);
    let is_shared = have_common_root(&p, &q);
    assert_eq!(holds_origin(h, g), is_shared, "{h:?} {g:?}");
    if is_shared {
        return Both::Shared;
    }
    let Some(count) = crossings(&p, &Chain::query(&p, &q)) else {
        return Both::Neither;
    };
    let is_odd = passes_oddly(h.to_vec(), g.to_vec());
    assert_eq!(is_odd, count % 2 != 0, "{h:?} {g:?}");
    Both::Passed(count)
}

#[test]
fn the_parity_is_that_of_sturms_count() {
    let mut numbers = Numbers(20_261);
    let (mut odd, mut even, mut shared) = (0, 0, 0);
    for k in 0..3000 {
        let degree = 1 + numbers.below(9) as usize;
        // Small numbers, so that there are zeros at the middle, at ends, and in common; and some of hundreds of bits.
        let size = [3, 7, 1000][numbers.below(3) as usize];
        let shift = if k % 10 == 0 {
            numbers.below(600) as usize
        } else {
            0
        };
        let mut make =
            || -> Vec<IBig> { (0..=degree).map(|_| numbers.about(size, shift)).collect() };
        match both(&make(), &make()) {
            Both::Shared => shared += 1,
            Both::Passed(n) if n % 2 == 0 => even += 1,
            Both::Passed(_) => odd += 1,
            Both::Neither => {}
        }
    }
    assert!(
        odd > 300 && even > 300 && shared > 20,
        "{odd} {even} {shared}"
    );
}

/// In Bernstein form of a degree, up to a positive factor.
fn in_bernstein(f: &Polynomial, degree: usize) -> Vec<IBig> {
    let row = binomials(degree);
    let all = row.iter().fold(IBig::ONE, |a, b| a * b);
    let mut out = vec![IBig::ZERO; degree + 1];
    for (k, a) in f.0.iter().enumerate() {
        // t^k = sum of C(i, k) / C(n, k) over the basis functions i.
        for (i, x) in out.iter_mut().enumerate().skip(k) {
            *x += a * &binomials(i)[k] * (&all / &row[k]);
        }
    }
    out
}

/// Polynomials made of their roots, some multiple, some shared, their coefficients long: what is known of them without any chain.
#[test]
fn multiple_roots_and_long_coefficients() {
    let mut numbers = Numbers(5);
    let (mut multiple, mut shared, mut odd, mut even) = (0, 0, 0, 0);
    for k in 0..300 {
        // Roots in 64ths (so that halving meets them), or in parts of 2^90 + 1.
        let parts = if k % 2 == 0 {
            IBig::from(64)
        } else {
            (IBig::ONE << 90) + IBig::ONE
        };
        let mut root =
            || &parts * IBig::from(numbers.below(193) - 64) / IBig::from(64) + IBig::from(k % 2);
        // With multiplicities 1 to 3; the last one of g is sometimes one of h.
        let h: Vec<(IBig, usize)> = (0..3).map(|m| (root(), 1 + (k + m) % 3)).collect();
        let mut g: Vec<(IBig, usize)> = (0..2).map(|m| (root(), 1 + m % 2)).collect();
        if k % 5 == 0 {
            g[1].0 = h[k % 3].0.clone();
        }
        let of = |roots: &[(IBig, usize)]| {
            let one = Polynomial::new(vec![IBig::ONE]);
            roots.iter().fold(one, |f, (r, m)| {
                (0..*m).fold(f, |f, _| f.times(&Polynomial::new(vec![-r, parts.clone()])))
            })
        };
        let (f, e) = (of(&h), of(&g));
        let degree = f.degree().max(e.degree()) + k % 3;
        let [hb, gb] = [&f, &e].map(|f| in_bernstein(f, degree));
        assert_eq!(Polynomial::from_bernstein(&hb), f);
        let in_unit = |r: &IBig| *r >= IBig::ZERO && *r <= parts;
        let is_shared = h
            .iter()
            .any(|(r, _)| in_unit(r) && g.iter().any(|(s, _)| s == r));
        assert_eq!(holds_origin(&hb, &gb), is_shared, "{h:?} {g:?}");
        assert_eq!(have_common_root(&f, &e), is_shared, "{h:?} {g:?}");
        if is_shared {
            shared += 1;
            continue;
        }
        if h.iter().any(|(r, _)| *r == IBig::ZERO || *r == parts) {
            assert_eq!(crossings(&f, &Chain::query(&f, &e)), None);
            continue;
        }
        // g > 0 at a root of h where an even number of its own are above it.
        let mut roots: Vec<(IBig, usize)> = Vec::new();
        for (r, m) in &h {
            match roots.iter_mut().find(|(s, _)| s == r) {
                Some(same) => same.1 += m,
                None => roots.push((r.clone(), *m)),
            }
        }
        let within = |r: &IBig| in_unit(r);
        let above = |r: &IBig| {
            g.iter()
                .filter(|(s, _)| s > r)
                .map(|(_, m)| m)
                .sum::<usize>()
        };
        let ahead = |(r, _): &&(IBig, usize)| within(r) && above(r) % 2 == 0;
        let passed = roots
            .iter()
            .filter(ahead)
            .filter(|(_, m)| m % 2 == 1)
            .count();
        assert_eq!(passes_oddly(hb, gb), passed % 2 == 1, "{h:?} {g:?}");
        if roots.iter().any(|(r, m)| within(r) && *m > 1) {
            multiple += 1;
            assert_eq!(crossings(&f, &Chain::query(&f, &e)), None, "{h:?} {g:?}");
        } else {
            assert_eq!(
                crossings(&f, &Chain::query(&f, &e)),
                Some(passed as i64),
                "{h:?} {g:?}"
            );
        }
        if passed % 2 == 1 { odd += 1 } else { even += 1 }
    }
    assert!(
        multiple > 50 && shared > 20 && odd > 50 && even > 50,
        "{multiple} {shared} {odd} {even}"
    );
}

#[test]
fn touchings_pass_an_even_number_of_times() {
    // (2 t - 1)^2 three times, and (2 t - 1)^3, in degree 3.
    let (square, cube) = (big(&[3, -1, -1, 3]), big(&[-1, 1, -1, 1]));
    for (h, is_odd) in [(square, false), (cube, true)] {
        // g = 1, -1, and then
        assert_eq!(passes_oddly(h.clone(), big(&[1; 4])), is_odd);
        assert!(!passes_oddly(h.clone(), big(&[-1; 4])));
        // 8 t - 5, < 0 at the root, and 8 t - 3, > 0 there; times 3.
        assert!(!passes_oddly(h.clone(), big(&[-15, -7, 1, 9])));
        assert_eq!(passes_oddly(h, big(&[-9, -1, 7, 15])), is_odd);
    }
}

#[test]
fn parts_of_halves() {
    // t^2: on the halves t^2 / 4 and (1 + t)^2 / 4.
    let [a, b] = halves(big(&[0, 0, 1]));
    assert_eq!((a, b), (big(&[0, 0, 1]), big(&[1, 2, 4])));
}
