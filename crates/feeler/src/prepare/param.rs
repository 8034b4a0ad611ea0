//! How a native parameter runs over a Bezier piece.

use crate::numeric::{Ball, Dd, Real};

/// The map between a piece's local parameter in `[0, 1]` and the native one in
/// `[start, end]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParamMap {
    /// Native parameter at local 0.
    pub start: f64,
    /// Native parameter at local 1.
    pub end: f64,
}

impl ParamMap {
    /// The local parameter of a native one: `(t - start) / (end - start)`; exact at the ends.
    pub fn to_local<T: Real>(&self, t: Ball<T>) -> Ball<T> {
        if t.rad == 0.0 && t.mid == T::from_f64(self.start) {
            return Ball::ZERO;
        }
        if t.rad == 0.0 && t.mid == T::from_f64(self.end) {
            return Ball::ONE;
        }
        (t - Ball::exact(self.start)) / Ball::difference(self.end, self.start)
    }

    /// The native parameter of a local one, rounded, never outside `[start, end]`.
    pub fn to_native(&self, local: f64) -> f64 {
        let t = (1.0 - local) * self.start + local * self.end;
        t.clamp(self.start, self.end)
    }

    /// The same of a local parameter with more digits, rounded once as a rule: of a native parameter that is a number of f64 that number.
    pub fn nearest_native(&self, local: Dd) -> f64 {
        let t = Dd::from(self.start) + local * Dd::difference(self.end, self.start);
        t.hi.clamp(self.start, self.end)
    }

    /// A native interval that holds the image of the local `[a, b]`, `0 <= a <= b <= 1`; exact at 0 and 1.
    pub fn to_native_range(&self, a: f64, b: f64) -> [f64; 2] {
        // Three roundings of numbers no larger than the ends.
        let slack = 2.0 * f64::EPSILON * self.start.abs().max(self.end.abs());
        let at = |local: f64, slack: f64| {
            if local <= 0.0 {
                self.start
            } else if local >= 1.0 {
                self.end
            } else {
                (1.0 - local) * self.start + local * self.end + slack
            }
        };
        [at(a, -slack), at(b, slack)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In f64 the way back misses by some units of a number that is nearer to 0 than the ends.
    #[test]
    fn a_native_parameter_comes_back() {
        let (start, end) = (-0.527_071_077_530_392_8, 0.472_928_922_469_607_16);
        let map = ParamMap { start, end };
        for native in [-0.200_984_391_879_907_85, start, end, 1e-9, -3e-17] {
            let local = map.to_local(Ball::<Dd>::exact(native));
            assert_eq!(map.nearest_native(local.mid), native);
        }
    }
}
