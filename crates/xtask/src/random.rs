//! A small random number generator, the same everywhere.

/// SplitMix64 (G. L. Steele, D. Lea, C. H. Flood, "Fast splittable pseudorandom number generators",
/// OOPSLA 2014): one 64-bit state, good enough to spread queries.
pub(crate) struct Random(u64);

impl Random {
    /// Equal words give equal numbers.
    pub(crate) fn new(word: &str) -> Self {
        // FNV-1a.
        let hash = word.bytes().fold(0xcbf2_9ce4_8422_2325, |h: u64, b| {
            (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
        });
        Self(hash)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In `[0, 1)`.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// In `[a, b)`.
    pub(crate) fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    /// Below `n`, which is not 0.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// 1 or -1.
    pub(crate) fn sign(&mut self) -> f64 {
        if self.next() & 1 == 0 { 1.0 } else { -1.0 }
    }

    /// A unit vector, uniform: by rejection from the cube, so that only a square root is needed.
    pub(crate) fn direction(&mut self) -> nalgebra::Vector3<f64> {
        loop {
            let v = nalgebra::Vector3::from_fn(|_, _| self.between(-1.0, 1.0));
            let n = v.norm();
            if (0.1..1.0).contains(&n) {
                return v / n;
            }
        }
    }
}
