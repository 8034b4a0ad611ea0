//! The angle of a vector, from our own arithmetic: the same bits on every platform.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// [`atan2`] is off by at most this, in radians.
///
/// With `z = min/max` of the magnitudes (one rounding), `k = z` rounded to sixteenths and `c = k/16` exactly,
/// `atan z = atan c + atan w`, `w = (z - c) / (1 + c z)`, `|w| <= 1/32 + 2^-50`. `z` is off by 2^-54, which moves the angle by no
/// more; `w` by four roundings of a number below 1/32 (2^-56 in all); the series is cut at `w^13 / 13 < 2^-68` and rounded like
/// `w` (a few 2^-58); the table by 2^-54; their sum (below 0.8) by 2^-54. `PI/2 - a`, `PI - a` and the constants add at most
/// 2^-53 for a sum below 2, 2^-52 for one below 4, each, and `PI` as f64 is off by 2^-52. All told below
/// 2^-52 * (1/4 + 1/16 + 1/16 + 1/4 + 1/4 + 1/2 + 1/4 + 1 + 1) < 2^-50.
pub(crate) const ATAN_ERROR: f64 = 1.0 / (1u64 << 50) as f64;

/// `atan(k/16)`, each the nearest f64.
const TABLE: [f64; 17] = [
    0.0,
    0.06241880999595735,
    0.12435499454676144,
    0.18534794999569476,
    0.24497866312686414,
    0.3028848683749714,
    0.35877067027057225,
    0.4124104415973873,
    0.4636476090008061,
    0.5123894603107377,
    0.5585993153435624,
    0.6022873461349642,
    0.6435011087932844,
    0.6823165548747481,
    0.7188299996216245,
    0.7531512809621944,
    FRAC_PI_4,
];

/// The angle of `(x, y)` from the x axis, in `[-PI, PI]`, within [`ATAN_ERROR`]; for finite numbers that are neither
/// both zero nor so small that their quotient is lost to underflow (then any angle).
pub(crate) fn atan2(y: f64, x: f64) -> f64 {
    let (a, b) = (x.abs(), y.abs());
    let (small, large) = if a < b { (a, b) } else { (b, a) };
    if large == 0.0 {
        return 0.0;
    }
    let z = small / large;
    let k = (16.0 * z + 0.5) as usize;
    let c = k as f64 / 16.0;
    let w = (z - c) / (1.0 + c * z);
    let s = w * w;
    let tail = s * (-1.0 / 3.0 + s * (1.0 / 5.0 + s * (-1.0 / 7.0 + s * (1.0 / 9.0 - s / 11.0))));
    let first = TABLE[k.min(16)] + (w + w * tail);
    let upper = if a < b { FRAC_PI_2 - first } else { first };
    let upper = if x < 0.0 { PI - upper } else { upper };
    if y < 0.0 { -upper } else { upper }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::{Ball, Dd, sin_cos};

    /// The sine of the difference of the true and the computed angle is the cross product of the vector
    /// with the computed direction, over its length.
    #[test]
    fn angles_are_as_good_as_said() {
        let mut worst: f64 = 0.0;
        let mut check = |x: f64, y: f64| {
            let (sin, cos) = sin_cos(Ball::exact(atan2(y, x)));
            let (x, y) = (Ball::<Dd>::exact(x), Ball::exact(y));
            let length = (x.square() + y.square()).sqrt();
            let off = ((x * sin - y * cos) / length).magnitude();
            assert!((x * cos + y * sin).is_above(0.0));
            worst = worst.max(off);
        };
        let mut seed = 9u64;
        for k in 0..40_000 {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            let t = (seed >> 11) as f64 / (1u64 << 53) as f64;
            let size = 2f64.powi(k % 40 - 20);
            for (x, y) in [(1.0, t), (t, 1.0), (1.0, t * size), (t - 0.5, size)] {
                for (sx, sy) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
                    check(sx * x, sy * y);
                }
            }
        }
        for k in 0..=32 {
            let z = f64::from(k) / 32.0;
            for z in [z.next_down(), z, z.next_up()] {
                check(1.0, z);
                check(-z, -1.0);
            }
        }
        check(0.0, -1.0);
        check(-1.0, 0.0);
        assert!(worst <= ATAN_ERROR, "{worst:e}");
    }
}
