//! Numbers from bytes.

use arbitrary::Unstructured;

/// Half the width of the square in which loops are drawn, and about the size of everything in space.
pub(crate) const HALF: f64 = 8.0;

/// Bytes read as numbers that mostly make valid geometry; after the last byte, zeros.
pub(crate) struct Source<'a>(Unstructured<'a>);

impl<'a> Source<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self(Unstructured::new(bytes))
    }

    pub(crate) fn byte(&mut self) -> u8 {
        self.0.arbitrary().unwrap_or(0)
    }

    /// Below `n`, which is from 1 to 256.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        usize::from(self.byte()) % n
    }

    /// True for `n` of 256 bytes, not for the byte 0.
    pub(crate) fn rarely(&mut self, n: u8) -> bool {
        self.byte() > 255 - n
    }

    pub(crate) fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    /// Any f64 at all.
    pub(crate) fn hostile(&mut self) -> f64 {
        const WELL_KNOWN: [f64; 12] = [
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::MAX,
            f64::MIN_POSITIVE,
            5e-324,
            -0.0,
            1e60,
            -1e60,
            1.000_000_000_000_000_2e60,
            1e-300,
            1e308,
        ];
        match self.below(4) {
            0 => self.one_of(&WELL_KNOWN),
            1 => f64::from_bits(self.0.arbitrary().unwrap_or(0)),
            _ => self.coordinate(),
        }
    }

    /// `x`, or an f64 up to 4 steps from it; from 0 mostly steps of 2^-52.
    pub(crate) fn nudged(&mut self, x: f64) -> f64 {
        let b = self.byte();
        if b < 96 {
            return x;
        }
        let steps = 1 + b % 4;
        if x == 0.0 && b & 128 == 0 {
            // Next to 0 as next to 1: the numbers next to it are 2^-1074.
            let off = f64::from(steps) * f64::EPSILON;
            return if b & 64 == 0 { off } else { -off };
        }
        (0..steps).fold(x, |x, _| {
            if b & 64 == 0 {
                x.next_up()
            } else {
                x.next_down()
            }
        })
    }

    /// Mostly on a grid, so that points coincide and joints lie on rays; in `[-HALF, HALF]` but for a few.
    pub(crate) fn coordinate(&mut self) -> f64 {
        const ODD: [f64; 8] = [-0.0, 5e-324, 1e-300, -1e-160, 1e9, -1e15, 1e-9, 0.1];
        let kind = self.byte();
        let grid = f64::from(self.byte() as i8) / 16.0;
        match kind {
            0..=179 => grid,
            180..=214 => self.nudged(grid),
            215..=239 => {
                let fine: i32 = self.0.arbitrary().unwrap_or(0);
                f64::from(fine) / f64::from(1 << 28)
            }
            240..=252 => grid * (-f64::from(10 * (1 + kind % 5))).exp2(),
            _ => self.one_of(&ODD),
        }
    }

    pub(crate) fn pair(&mut self) -> [f64; 2] {
        [self.coordinate(), self.coordinate()]
    }

    pub(crate) fn triple(&mut self) -> [f64; 3] {
        [self.coordinate(), self.coordinate(), self.coordinate()]
    }

    /// In `[0, 1]`; at times an end, or close to one.
    pub(crate) fn fraction(&mut self) -> f64 {
        match self.byte() {
            0..=159 => f64::from(self.byte()) / 255.0,
            160..=191 => 0.5,
            192..=207 => 0.0,
            208..=223 => 1.0,
            224..=239 => (-f64::from(self.byte() % 64)).exp2(),
            _ => self.nudged(1.0).min(1.0),
        }
    }

    /// A positive weight: 1, near it, or extreme.
    pub(crate) fn weight(&mut self) -> f64 {
        match self.byte() {
            0..=139 => 1.0,
            140..=199 => f64::from(1 + self.byte() % 32) / 8.0,
            200..=239 => f64::from((self.byte() % 41) as i8 - 20).exp2(),
            240..=251 => f64::from((self.byte() % 81) as i8 - 40).exp2(),
            _ => self.one_of(&[1e-59, 1e59, 1e-12, 1e12]),
        }
    }

    /// A power of two: what is multiplied by it and divided again is the same.
    pub(crate) fn exact_weight(&mut self) -> f64 {
        match self.byte() {
            0..=191 => 1.0,
            _ => f64::from((self.byte() % 25) as i8 - 12).exp2(),
        }
    }

    /// A degree: low, as a rule.
    pub(crate) fn degree(&mut self, highest: usize) -> usize {
        let found = match self.byte() {
            0..=31 => 1,
            32..=127 => 2,
            128..=207 => 3,
            208..=231 => 4,
            232..=243 => 5,
            244..=252 => 6 + self.below(4),
            _ => 10 + self.below(16),
        };
        found.min(highest)
    }

    /// Knots over `[from, to]`, clamped, with up to three knots inside, on the grid of sixteenths or a few steps of f64
    /// from it, or from each other; and how many control points that makes. Multiplicities may be too high: then there is no such spline.
    pub(crate) fn knots(&mut self, degree: usize, [from, to]: [f64; 2]) -> (Vec<f64>, usize) {
        let mut inner: Vec<f64> = Vec::new();
        let places = match self.byte() {
            0..=127 => 0,
            128..=191 => 1,
            192..=231 => 2,
            _ => 3,
        };
        for _ in 0..places {
            let s = f64::from(1 + self.byte() % 15) / 16.0;
            let again = inner.last().copied().filter(|_| self.rarely(96));
            let at = again.unwrap_or(from + (to - from) * s);
            // Not by steps of 2^-1074: the exact reference then takes integers of a million bits.
            let at = if at == 0.0 { at } else { self.nudged(at) };
            let times = 1 + if self.rarely(64) {
                self.below(degree)
            } else {
                0
            };
            if from < at && at < to {
                inner.extend(std::iter::repeat_n(at, times));
            }
        }
        inner.sort_by(f64::total_cmp);
        let points = degree + 1 + inner.len();
        let mut knots = vec![from; degree + 1];
        knots.extend(inner);
        knots.extend(vec![to; degree + 1]);
        (knots, points)
    }
}
