//! Halving against Sturm chains, which count crossings one by one.

use super::*;

fn big(c: &[i64]) -> Vec<IBig> {
    c.iter().map(|x| IBig::from(*x)).collect()
}

/// Roots of h in (0, 1) with g > 0: half of (roots of h) + (sum of the signs of g there). `None` where h is 0 at an end or has a
/// multiple root there.
fn by_sturm(h: &[IBig], g: &[IBig]) -> Option<i64> {
    if sign(&h[0]) * sign(&h[h.len() - 1]) == 0 {
        return None;
    }
    let (h, g) = (Polynomial::from_bernstein(h), Polynomial::from_bernstein(g));
    let chain = Chain::new(&h);
    if chain.gcd().degree() > 0 && roots_in_unit(chain.gcd()) > 0 {
        return None;
    }
    let (zero, one) = (RBig::ZERO, RBig::ONE);
    let all = chain.between(&zero, &one);
    Some((all + Chain::query(&h, &g).between(&zero, &one)) / 2)
}

#[test]
fn the_parity_is_that_of_sturms_count() {
    let mut state = 20_261_u64;
    let mut next = |n: i64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as i64 % n
    };
    let (mut odd, mut even, mut shared) = (0, 0, 0);
    for _ in 0..3000 {
        let degree = 1 + next(9) as usize;
        // Small numbers, so that there are zeros at the middle, at ends, and in common.
        let size = [3, 7, 1000][next(3) as usize];
        let mut make = || -> Vec<IBig> {
            (0..=degree)
                .map(|_| IBig::from(next(2 * size + 1) - size))
                .collect()
        };
        let (h, g) = (make(), make());
        let common = Polynomial::from_bernstein(&h).gcd(&Polynomial::from_bernstein(&g));
        let is_shared = common.is_zero() || roots_in_unit(&common) > 0;
        assert_eq!(holds_origin(&h, &g), is_shared, "{h:?} {g:?}");
        if is_shared {
            shared += 1;
            continue;
        }
        let Some(count) = by_sturm(&h, &g) else {
            continue;
        };
        assert_eq!(
            passes_oddly(h.clone(), g.clone()),
            count % 2 != 0,
            "{h:?} {g:?}"
        );
        if count % 2 == 0 { even += 1 } else { odd += 1 }
    }
    assert!(
        odd > 300 && even > 300 && shared > 20,
        "{odd} {even} {shared}"
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
