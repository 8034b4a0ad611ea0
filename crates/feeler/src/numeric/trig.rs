//! Sine and cosine from our own arithmetic: the same bits on every platform, with a proven
//! bound.

use super::{Ball, Dd, atan2};

/// Angles beyond this magnitude, in radians, get balls that only say "between -1 and 1".
pub const MAX_ANGLE: f64 = (1u64 << 30) as f64;

/// pi/2 as a sum of three f64, each the nearest to what the ones before leave; the rest is
/// below 2^-163.
const HALF_PI: [f64; 3] = [
    std::f64::consts::FRAC_PI_2,
    6.123233995736766e-17,
    -1.4973849048591698e-33,
];
/// The f64 nearest to 2/pi; it only picks the quadrant.
const TWO_OVER_PI: f64 = std::f64::consts::FRAC_2_PI;

/// `1/n!` at index n, each off by at most half an ulp of `lo`: relatively 2^-106.
const INVERSE_FACTORIALS: [Dd; 29] = [
    Dd { hi: 1.0, lo: 0.0 },
    Dd { hi: 1.0, lo: 0.0 },
    Dd { hi: 0.5, lo: 0.0 },
    Dd {
        hi: 0.16666666666666666,
        lo: 9.25185853854297e-18,
    },
    Dd {
        hi: 0.041666666666666664,
        lo: 2.3129646346357427e-18,
    },
    Dd {
        hi: 0.008333333333333333,
        lo: 1.1564823173178714e-19,
    },
    Dd {
        hi: 0.001388888888888889,
        lo: -5.300543954373577e-20,
    },
    Dd {
        hi: 0.0001984126984126984,
        lo: 1.7209558293420705e-22,
    },
    Dd {
        hi: 2.48015873015873e-05,
        lo: 2.1511947866775882e-23,
    },
    Dd {
        hi: 2.7557319223985893e-06,
        lo: -1.858393274046472e-22,
    },
    Dd {
        hi: 2.755731922398589e-07,
        lo: 2.3767714622250297e-23,
    },
    Dd {
        hi: 2.505210838544172e-08,
        lo: -1.448814070935912e-24,
    },
    Dd {
        hi: 2.08767569878681e-09,
        lo: -1.20734505911326e-25,
    },
    Dd {
        hi: 1.6059043836821613e-10,
        lo: 1.2585294588752098e-26,
    },
    Dd {
        hi: 1.1470745597729725e-11,
        lo: 2.0655512752830745e-28,
    },
    Dd {
        hi: 7.647163731819816e-13,
        lo: 7.03872877733453e-30,
    },
    Dd {
        hi: 4.779477332387385e-14,
        lo: 4.399205485834081e-31,
    },
    Dd {
        hi: 2.8114572543455206e-15,
        lo: 1.6508842730861433e-31,
    },
    Dd {
        hi: 1.5619206968586225e-16,
        lo: 1.1910679660273754e-32,
    },
    Dd {
        hi: 8.22063524662433e-18,
        lo: 2.2141894119604265e-34,
    },
    Dd {
        hi: 4.110317623312165e-19,
        lo: 1.4412973378659527e-36,
    },
    Dd {
        hi: 1.9572941063391263e-20,
        lo: -1.3643503830087908e-36,
    },
    Dd {
        hi: 8.896791392450574e-22,
        lo: -7.911402614872376e-38,
    },
    Dd {
        hi: 3.868170170630684e-23,
        lo: -8.843177655482344e-40,
    },
    Dd {
        hi: 1.6117375710961184e-24,
        lo: -3.6846573564509766e-41,
    },
    Dd {
        hi: 6.446950284384474e-26,
        lo: -1.9330404233703465e-42,
    },
    Dd {
        hi: 2.4795962632247976e-27,
        lo: -1.2953730964765229e-43,
    },
    Dd {
        hi: 9.183689863795546e-29,
        lo: 1.4303150396787322e-45,
    },
    Dd {
        hi: 3.279889237069838e-30,
        lo: 1.5117542744029879e-46,
    },
];

/// `1/n!` as a ball.
fn inverse_factorial(n: usize) -> Ball<Dd> {
    // |1/n! - c| <= ulp(lo)/2 <= 2^-53 |lo| <= 2^-106 |hi|; twice that to be plain.
    let c = INVERSE_FACTORIALS[n];
    Ball::from_dd(c, 2.0 * f64::EPSILON * f64::EPSILON * c.hi)
}

/// The ball of all that is within `by` of one; the last factor makes up for the sum's rounding.
fn widened(b: Ball<Dd>, by: f64) -> Ball<Dd> {
    Ball::from_dd(b.mid, (b.rad + by) * (1.0 + 4.0 * f64::EPSILON))
}

/// `(sin a, cos a)` of every angle `a` in the ball, in radians.
///
/// Method: with k the integer nearest to `2a/pi`, `r = a - k pi/2` by Cody and Waite's
/// reduction: pi/2 is three f64, the products with k are exact double-doubles, and what is left
/// of pi is below `|k| 2^-163`. Then the Taylor series of sine (to r^27/27!) and cosine (to
/// r^28/28!) by Horner's rule, and the quadrant by `k mod 4`.
///
/// Guarantee: it is all done in [`Ball`]s, so that the radii returned are proven. For an exact angle
/// they are below 2^-98 (absolute). The series alternate and their terms fall, so the first term left
/// out bounds the rest: with `|r| <= 0.79`, `r^29/29! <= 2^-112` and
/// `r^30/30! <= 2^-117`. Beyond [`MAX_ANGLE`], or for a radius above 1, the answer is `0 +- 1`.
///
/// Cost: about 30 double-double products.
pub fn sin_cos(angle: Ball<Dd>) -> (Ball<Dd>, Ball<Dd>) {
    let anything = Ball::from_dd(Dd::ZERO, 1.0);
    // NaN fails both tests too.
    let usable = angle.mid.hi.abs() <= MAX_ANGLE && angle.rad <= 1.0;
    if !usable {
        return (anything, anything);
    }
    let k = (angle.mid.hi * TWO_OVER_PI).round();
    let mut r = angle;
    if k != 0.0 {
        r = r - Ball::from_dd(Dd::product(k, HALF_PI[0]), 0.0);
        r = r - Ball::from_dd(Dd::product(k, HALF_PI[1]), 0.0);
        /// What [`HALF_PI`] leaves of pi/2: 2^-163.
        const REST: f64 = 1.0 / ((1u128 << 100) as f64 * (1u64 << 63) as f64);
        r = r - Ball::from_dd(Dd::product(k, HALF_PI[2]), 0.0);
        r = widened(r, k.abs() * REST);
    }
    // |r.mid| <= pi/4 + the error of k, below 0.786; the series are taken at r.mid, exact,
    // and r.rad is added after: sine and cosine have slopes of at most 1.
    let x = Ball::from_dd(r.mid, 0.0);
    let s = x * x;
    /// 2^-112 and 2^-117, as above.
    const SIN_REST: f64 = 1.0 / (1u128 << 112) as f64;
    const COS_REST: f64 = 1.0 / (1u128 << 117) as f64;
    let series = |first: usize, last: usize| {
        let mut sum = inverse_factorial(last);
        let mut n = last;
        while n > first {
            n -= 2;
            sum = inverse_factorial(n) - s * sum;
        }
        sum
    };
    // The rest of the sine is |r| times one of the bracket, so small angles keep their digits.
    let sine = widened(x * widened(series(1, 27), SIN_REST), r.rad);
    let cosine = widened(series(0, 28), COS_REST + r.rad);
    // k is an integer of at most 31 bits.
    match (k as i64).rem_euclid(4) {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// 2 pi.
pub(crate) fn full_turn() -> Ball<Dd> {
    let [a, b, c] = HALF_PI.map(|x| 4.0 * x);
    // What the third leaves is far below a unit of it.
    Ball::from_dd(Dd { hi: a, lo: b }, c.abs() * (1.0 + f64::EPSILON))
}

/// The angle of the vector `(x, y)` from the x axis, in radians; `None` where that is not known within [`SMALL`].
///
/// Method: turned back by the angle `a` that f64 gives, exactly, the vector is at a small angle `atan z = z - z^3/3 + ...`, `z` the quotient of its
/// coordinates; the series alternates and its terms fall, so that the rest is below `|z|^5 / 5`, and `|z|` is below [`SMALL`].
pub(crate) fn vector_angle(y: Ball<Dd>, x: Ball<Dd>) -> Option<Ball<Dd>> {
    let about = Ball::exact(atan2(y.mid.hi, x.mid.hi));
    let (sin, cos) = sin_cos(about);
    let (along, across) = (x * cos + y * sin, y * cos - x * sin);
    if !along.is_above(0.0) {
        return None;
    }
    let z = across / along;
    let most = z.magnitude();
    // Negated: what is not a number is not known.
    if !(most <= SMALL) {
        return None;
    }
    let series = z - z * z * z / Ball::exact(3.0);
    Some(about + widened(series, most.powi(5) * 0.25))
}

/// Angles within which two terms of the series of the arc tangent leave less than 2^-122.
const SMALL: f64 = 1.0 / (1u64 << 24) as f64;

#[cfg(test)]
#[allow(
    clippy::approx_constant,
    reason = "the table is of digits, not of names"
)]
mod tests {
    use super::*;
    use crate::numeric::Dyadic;
    use dashu_int::{IBig, UBig};

    /// Bits after the binary point of the reference.
    const BITS: usize = 400;

    fn exact(x: Dd) -> Dyadic {
        &Dyadic::from_f64(x.hi).unwrap() + &Dyadic::from_f64(x.lo).unwrap()
    }

    /// pi * 2^BITS by Machin's formula, in integers, off by a few hundred units.
    fn pi() -> IBig {
        let arctan_inverse = |x: i64| {
            let mut term = (IBig::ONE << BITS) / x;
            let mut sum = IBig::ZERO;
            let mut n = 1i64;
            while term != IBig::ZERO {
                let t = &term / n;
                sum += if n % 4 == 1 { t } else { -t };
                term /= x * x;
                n += 2;
            }
            sum
        };
        (arctan_inverse(5) * 4 - arctan_inverse(239)) * 4
    }

    /// `(sin, cos)` of `angle`, in units of 2^-BITS: remainder modulo 2 pi, then the plain Taylor
    /// series with 400 bits; off by less than 2^-300.
    fn reference(angle: &Dyadic) -> (Dyadic, Dyadic) {
        let shift = angle.exponent() + BITS as i64;
        let mut x = if shift >= 0 {
            angle.mantissa().clone() << shift as usize
        } else {
            angle.mantissa().clone() >> (-shift) as usize
        };
        let turn = pi() * 2;
        x %= &turn;
        let one = IBig::ONE << BITS;
        let (mut sin, mut cos) = (IBig::ZERO, IBig::ZERO);
        let mut term = one;
        let mut n = 0i64;
        while term != IBig::ZERO {
            match n % 4 {
                0 => cos += &term,
                1 => sin += &term,
                2 => cos -= &term,
                _ => sin -= &term,
            }
            n += 1;
            term = ((&term * &x) >> BITS) / n;
            if term == -IBig::ONE {
                break;
            }
        }
        let d = |m: IBig| Dyadic::new(m, -(BITS as i64));
        (d(sin), d(cos))
    }

    fn holds(b: &Ball<Dd>, truth: &Dyadic) -> bool {
        let e = &exact(b.mid) - truth;
        let e = if e.signum() < 0 { -&e } else { e };
        // 2^-300 for the reference itself.
        e <= &Dyadic::from_f64(b.rad).unwrap() + &Dyadic::new(IBig::ONE, -300)
    }

    fn check(angle: Dd) {
        let (s, c) = sin_cos(Ball::from_dd(angle, 0.0));
        let (rs, rc) = reference(&exact(angle));
        assert!(holds(&s, &rs), "sin {angle:?}: {s:?}");
        assert!(holds(&c, &rc), "cos {angle:?}: {c:?}");
        // 2^-98.
        let limit = 1.0 / (1u128 << 98) as f64;
        assert!(s.rad < limit && c.rad < limit, "{angle:?}: {s:?} {c:?}");
    }

    #[test]
    fn constants_are_right() {
        let mut factorial = UBig::ONE;
        for (n, c) in INVERSE_FACTORIALS.iter().enumerate() {
            factorial *= UBig::from(n.max(1));
            // |c n! - 1| <= 2^-106.
            let residue = &(&exact(*c) * &Dyadic::new(IBig::from(factorial.clone()), 0))
                - &Dyadic::from_f64(1.0).unwrap();
            let size = if residue.signum() < 0 {
                -&residue
            } else {
                residue
            };
            assert!(size <= Dyadic::new(IBig::ONE, -106), "1/{n}!");
        }
        let sum = HALF_PI
            .iter()
            .fold(Dyadic::ZERO, |s, x| &s + &Dyadic::from_f64(*x).unwrap());
        let rest = &Dyadic::new(pi(), -(BITS as i64) - 1) - &sum;
        let size = if rest.signum() < 0 { -&rest } else { rest };
        assert!(size < Dyadic::new(IBig::ONE, -163));
        assert!((TWO_OVER_PI * HALF_PI[0] - 1.0).abs() <= f64::EPSILON);
    }

    #[test]
    fn balls_hold_the_truth() {
        let mut seed = 0x9e37_79b9_7f4a_7c15u64;
        for i in 0..4000 {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            let unit = (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
            let x = unit * [2.0, 8.0, 2e4, 1e9, 1e-9][i % 5];
            check(Dd::new(x, unit * 1e-17 * x));
            check(Dd::from(x));
        }
        // Multiples of pi/4 as f64, where quadrants meet, and their neighbours.
        for k in -100..=100 {
            let x = f64::from(k) * std::f64::consts::FRAC_PI_4;
            for x in [x.next_down(), x, x.next_up()] {
                check(Dd::from(x));
            }
        }
        for x in [
            0.0, -0.0, 1e-310, 1e-200, MAX_ANGLE, -MAX_ANGLE, 22.0, 355.0, 1e4,
        ] {
            check(Dd::from(x));
        }
    }

    #[test]
    fn high_precision_values() {
        // From mpmath 1.3.0 (mp.prec = 200), printed to 36 digits and split into two f64.
        for (x, sin, cos) in TABLE {
            let (s, c) = sin_cos(Ball::exact(*x));
            // The table is rounded to double-double: 2^-106.
            let close = |b: Ball<Dd>, t: &Dd| {
                (b - Ball::from_dd(*t, 0.0)).magnitude()
                    <= 3.0 * b.rad + f64::EPSILON * f64::EPSILON
            };
            assert!(close(s, sin) && close(c, cos), "{x}: {s:?} {c:?}");
        }
    }

    #[test]
    fn a_full_turn_is_held() {
        let turn = full_turn();
        assert!(holds(&turn, &Dyadic::new(pi() * 2, -(BITS as i64))));
        // Double-double has 106 bits of it.
        assert!(turn.rad < 8.0 / (1u128 << 106) as f64, "{turn:?}");
    }

    /// What is turned by a known angle is found at it, to 1e-29, however short the vector is.
    #[test]
    fn angles_of_vectors() {
        for k in -31..=31 {
            let angle = Ball::exact(f64::from(k) * 0.1);
            let (sin, cos) = sin_cos(angle);
            for length in [1.0, 1e-16, 3e-40, 1e30] {
                let by = Ball::exact(length);
                let found = vector_angle(sin * by, cos * by).unwrap();
                let off = found - angle;
                assert!(
                    off.mid.hi.abs() <= off.rad && off.rad < 1e-29,
                    "{k} {length:e}: {off:?}"
                );
            }
        }
        let vague = Ball::from_dd(Dd::from(1e-16), 1e-20);
        assert!(vector_angle(vague, vague).is_none());
        assert!(vector_angle(Ball::ZERO, Ball::ZERO).is_none());
        let (sin, cos) = sin_cos(full_turn());
        assert!(sin.magnitude() < 1e-31 && (cos - Ball::ONE).magnitude() < 1e-30);
    }

    #[test]
    fn small_angles_keep_their_digits() {
        let (s, _) = sin_cos(Ball::exact(1e-100));
        assert!(s.mid.hi == 1e-100 && s.rad < 1e-128, "{s:?}");
        // sin(fl(pi)) = pi - fl(pi) to 2^-100 of itself.
        let (s, _) = sin_cos(Ball::exact(std::f64::consts::PI));
        assert_eq!(s.mid.hi, 2.0 * HALF_PI[1]);
        assert!(s.rad < 1e-44, "{s:?}");
    }

    #[test]
    fn what_is_too_large_is_unknown() {
        for x in [2.0 * MAX_ANGLE, 1e300, f64::INFINITY, f64::NAN] {
            let (s, c) = sin_cos(Ball::exact(x));
            assert!(s.rad == 1.0 && c.rad == 1.0 && s.mid == Dd::ZERO && c.mid == Dd::ZERO);
        }
        let (s, _) = sin_cos(Ball::from_dd(Dd::ONE, f64::NAN));
        assert_eq!(s.rad, 1.0);
    }

    const TABLE: &[(f64, Dd, Dd)] = &[
        (
            0.1,
            Dd {
                hi: 0.09983341664682815,
                lo: 3.08001512929492e-18,
            },
            Dd {
                hi: 0.9950041652780258,
                lo: -5.50210156918377e-17,
            },
        ),
        (
            0.5,
            Dd {
                hi: 0.479425538604203,
                lo: -5.103969860556013e-18,
            },
            Dd {
                hi: 0.8775825618903728,
                lo: -4.2623149864279997e-17,
            },
        ),
        (
            0.7853981633974483,
            Dd {
                hi: 0.7071067811865475,
                lo: 4.1036934489363755e-17,
            },
            Dd {
                hi: 0.7071067811865476,
                lo: -2.6687565161377232e-17,
            },
        ),
        (
            1.0,
            Dd {
                hi: 0.8414709848078965,
                lo: 1.776845092935536e-18,
            },
            Dd {
                hi: 0.5403023058681398,
                lo: -4.760954612604417e-17,
            },
        ),
        (
            2.0,
            Dd {
                hi: 0.9092974268256817,
                lo: -1.4020906557816256e-17,
            },
            Dd {
                hi: -0.4161468365471424,
                lo: 1.990596398957495e-17,
            },
        ),
        (
            3.0,
            Dd {
                hi: 0.1411200080598672,
                lo: 8.577269787017502e-18,
            },
            Dd {
                hi: -0.9899924966004454,
                lo: -4.2060261566099734e-17,
            },
        ),
        (
            -4.5,
            Dd {
                hi: 0.977530117665097,
                lo: 4.619499329500834e-17,
            },
            Dd {
                hi: -0.2107957994307797,
                lo: -1.036476988089257e-17,
            },
        ),
        (
            6.283185307179586,
            Dd {
                hi: -2.4492935982947064e-16,
                lo: 5.9895396194366814e-33,
            },
            Dd {
                hi: 1.0,
                lo: -2.999519565323715e-32,
            },
        ),
        (
            100.0,
            Dd {
                hi: -0.5063656411097588,
                lo: -3.050947053792115e-18,
            },
            Dd {
                hi: 0.8623188722876839,
                lo: 4.334809858136501e-17,
            },
        ),
        (
            -1234.5678,
            Dd {
                hi: -0.07803344920002027,
                lo: 2.762970751686303e-18,
            },
            Dd {
                hi: -0.9969507414140119,
                lo: 3.7057717162849634e-17,
            },
        ),
        (
            10000.0,
            Dd {
                hi: -0.30561438888825215,
                lo: 1.1737169553511932e-17,
            },
            Dd {
                hi: -0.9521553682590148,
                lo: -3.9690952362333257e-17,
            },
        ),
    ];

    /// 1 + 2^-53 is no f64, and rounds down.
    #[test]
    fn a_widened_ball_holds_what_rounding_takes() {
        let b = widened(Ball::from_dd(Dd::ONE, 1.0), 0.5 * f64::EPSILON);
        assert!(b.rad > 1.0 && b.rad < 1.0 + 1e-14, "{b:?}");
    }
}
