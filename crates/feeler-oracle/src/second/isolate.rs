//! The roots of an exact polynomial between 0 and 1: candidates from eigenvalues, certified and completed by Sturm chains.
//!
//! The parts between candidates across which a square-free factor changes its sign hold at least a root each. Are they as
//! many as Sturm's theorem counts on all of (0, 1), each holds exactly one, and none is elsewhere: no more is to be
//! proven. Where they are fewer, parts are halved by Sturm's counts until each holds one. An interval with one simple root
//! is narrowed by evaluations at equally spaced points of ever finer grids, the secant telling which (J. Abbott, *Quadratic
//! interval refinement for real roots*, 2006).

use super::candidates::candidates;
use super::fraction::Fraction;
use super::polynomial::{Chain, Polynomial};
use super::rational::{rational, sign};
use dashu_int::IBig;
use dashu_int::ops::{BitTest, UnsignedAbs};

/// A dyadic number `n / 2^e`.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) n: IBig,
    pub(crate) e: usize,
}

impl Place {
    pub(crate) fn new(n: IBig, e: usize) -> Self {
        Self { n, e }
    }

    fn at(&self, e: usize) -> IBig {
        self.n.clone() << (e - self.e)
    }

    pub(crate) fn rational(&self) -> Fraction {
        Fraction::from_parts(self.n.clone(), dashu_int::UBig::ONE << self.e)
    }

    fn value(&self, f: &Polynomial) -> IBig {
        // f(n / 2^e) 2^(e degree), by shifts.
        let mut sum = IBig::ZERO;
        for (k, a) in f.0.iter().rev().enumerate() {
            sum = sum * &self.n + (a.clone() << (self.e * k));
        }
        sum
    }

    fn mid(&self, other: &Self) -> Self {
        let e = self.e.max(other.e);
        Self::new(self.at(e) + other.at(e), e + 1)
    }
}

/// One root, strictly between `lo` and `hi`, where its factor has different signs; or itself both.
#[derive(Clone, Debug)]
pub(crate) struct Isolated {
    pub(crate) lo: Place,
    pub(crate) hi: Place,
    pub(crate) multiplicity: usize,
    factor: usize,
}

/// The roots of one polynomial in (0, 1).
#[derive(Clone, Debug, Default)]
pub(crate) struct Roots {
    pub(crate) roots: Vec<Isolated>,
    factors: Vec<Polynomial>,
    /// How many of them the candidates alone isolated.
    pub(crate) from_candidates: usize,
}

impl Roots {
    /// Of `f`, not zero, without roots at 0 and 1. Intervals are disjoint and no wider than 2^-bits.
    pub(crate) fn isolate(f: &Polynomial, bits: usize) -> Self {
        let mut all = Self::default();
        if f.degree() == 0 {
            return all;
        }
        let mut seeds = candidates(f);
        let chain = Chain::new(f);
        if chain.gcd().degree() == 0 {
            all.factors = vec![f.clone()];
            all.find(0, &chain, &seeds);
        } else {
            all.factors = f.square_free_factors();
            for k in 0..all.factors.len() {
                let factor = all.factors[k].clone();
                if factor.degree() > 0 {
                    // Multiple roots scatter eigenvalues: those of the factor are better.
                    seeds = candidates(&factor);
                    all.find(k, &Chain::new(&factor), &seeds);
                }
            }
        }
        all.refine(bits);
        all
    }

    fn find(&mut self, factor: usize, chain: &Chain, seeds: &[f64]) {
        let f = self.factors[factor].clone();
        let ends = [Place::new(IBig::ZERO, 0), Place::new(IBig::ONE, 0)];
        let total = chain.between(&ends[0].rational(), &ends[1].rational());
        if total == 0 {
            return;
        }
        let mut places = vec![(ends[0].clone(), sign(&ends[0].value(&f)))];
        let middles = seeds.windows(2).map(|w| 0.5 * w[0] + 0.5 * w[1]);
        for x in middles.filter(|x| *x > 0.0 && *x < 1.0) {
            let Some(place) = dyadic(x) else { continue };
            let s = sign(&place.value(&f));
            // A root itself is no wall.
            if s != 0 {
                places.push((place, s));
            }
        }
        let s = sign(&ends[1].value(&f));
        places.push((ends[1].clone(), s));
        let changes = places.windows(2).filter(|w| w[0].1 * w[1].1 < 0).count() as i64;
        let simple = changes == total;
        if simple {
            self.from_candidates += changes as usize;
        }
        let mut found = |lo: &Place, hi: &Place| {
            self.roots.push(Isolated {
                lo: lo.clone(),
                hi: hi.clone(),
                multiplicity: factor + 1,
                factor,
            });
        };
        for w in places.windows(2) {
            if simple {
                if w[0].1 * w[1].1 < 0 {
                    found(&w[0].0, &w[1].0);
                }
                continue;
            }
            // Parts with their variations at both ends.
            let count = |p: &Place| chain.variations(&p.rational());
            let mut stack = vec![(
                w[0].0.clone(),
                count(&w[0].0),
                w[1].0.clone(),
                count(&w[1].0),
            )];
            while let Some((lo, at_lo, hi, at_hi)) = stack.pop() {
                match at_lo - at_hi {
                    ..=0 => {}
                    1 => found(&lo, &hi),
                    _ => {
                        // A root at the middle cannot be a wall: others near it are tried. f has finitely many.
                        let mut mid = lo.mid(&hi);
                        while mid.value(&f) == IBig::ZERO {
                            mid = lo.mid(&mid);
                        }
                        let here = count(&mid);
                        stack.push((mid.clone(), here, hi, at_hi));
                        stack.push((lo, at_lo, mid, here));
                    }
                }
            }
        }
    }

    /// Narrows all intervals to 2^-bits, and further until they are disjoint; in order.
    fn refine(&mut self, mut bits: usize) {
        loop {
            for root in &mut self.roots {
                narrow(&self.factors[root.factor], root, bits);
            }
            self.roots.sort_by_key(|r| r.lo.rational());
            let apart = |w: &[Isolated]| w[0].hi.rational() < w[1].lo.rational();
            if self.roots.windows(2).all(apart) {
                return;
            }
            bits *= 2;
        }
    }

    /// Narrows one interval to 2^-bits.
    pub(crate) fn narrow(&mut self, index: usize, bits: usize) {
        let root = &mut self.roots[index];
        narrow(&self.factors[root.factor], root, bits);
    }

    /// Whether `x`, which is in the interval of root `index`, is that root.
    pub(crate) fn is_at(&self, index: usize, x: &Fraction) -> bool {
        self.factors[self.roots[index].factor].sign_at(x) == 0
    }

    /// Whether a polynomial, all of whose roots are roots of this one's, has root `index`.
    pub(crate) fn shares(&self, index: usize, divisor: &Polynomial) -> bool {
        let root = &self.roots[index];
        // Square-free, so that it changes its sign at each of its roots.
        let factors = divisor.square_free_factors();
        factors.iter().any(|f| {
            let (a, b) = (sign(&root.lo.value(f)), sign(&root.hi.value(f)));
            f.degree() > 0 && (a * b < 0 || (a == 0 && root.is_exact()))
        })
    }
}

impl Isolated {
    fn is_exact(&self) -> bool {
        let e = self.lo.e.max(self.hi.e);
        self.lo.at(e) == self.hi.at(e)
    }
}

/// `x` in [0, 1], exactly.
fn dyadic(x: f64) -> Option<Place> {
    let x = rational(x).ok()?;
    let e = x.denominator().trailing_zeros()?;
    Some(Place::new(x.numerator().clone(), e))
}

/// Disjoint intervals about candidates (ascending, in [0, 1]) at whose ends `f`, which is not 0 at 0 and 1, has different
/// signs, as narrow as the candidates allow.
pub(crate) fn brackets(f: &Polynomial, candidates: &[f64]) -> Vec<[Place; 2]> {
    /// Radii to try: a candidate is off by a few ulp where the root is simple and well apart.
    const RADII: [f64; 6] = [44.0, 36.0, 28.0, 20.0, 12.0, 4.0];
    let mut found = Vec::new();
    for (i, x) in candidates.iter().enumerate() {
        // Half way to the neighbours, rounded inwards.
        let below = i
            .checked_sub(1)
            .map_or(1.0, |k| 0.499 * (x - candidates[k]));
        let above = candidates.get(i + 1).map_or(1.0, |y| 0.499 * (y - x));
        let most = below.min(above);
        for r in RADII.iter().map(|e| (-e).exp2()).take_while(|r| *r < most) {
            let ends = [(x - r).max(0.0), (x + r).min(1.0)].map(dyadic);
            let [Some(lo), Some(hi)] = ends else {
                break;
            };
            if sign(&lo.value(f)) * sign(&hi.value(f)) < 0 {
                found.push([lo, hi]);
                break;
            }
        }
    }
    found
}

/// Down to a width of 2^-bits.
fn narrow(f: &Polynomial, root: &mut Isolated, bits: usize) {
    if root.is_exact() {
        return;
    }
    let e = root.lo.e.max(root.hi.e);
    let (mut lo, mut hi, mut e) = (root.lo.at(e), root.hi.at(e), e);
    let value = |n: &IBig, e: usize| Place::new(n.clone(), e).value(f);
    let mut at_lo = value(&lo, e);
    let mut at_hi = value(&hi, e);
    let exact = |root: &mut Isolated, n: IBig, e: usize| {
        root.lo = Place::new(n.clone(), e);
        root.hi = Place::new(n, e);
    };
    // The grid has 2^k parts.
    let mut k = 1usize;
    while (&hi - &lo).unsigned_abs().bit_len() as i64 - e as i64 > -(bits as i64) {
        // The same numbers at the grid's denominator; values are scaled with it.
        let rise = &at_hi - &at_lo;
        let step = &hi - &lo;
        let scale = k * f.degree();
        let (a, b) = (lo.clone() << k, hi.clone() << k);
        let (fa, fb) = (at_lo.clone() << scale, at_hi.clone() << scale);
        // Nearest grid point to the secant's zero, kept off the ends.
        let parts = IBig::ONE << k;
        let mut index = (((-&at_lo) << (k + 1)) / &rise + IBig::ONE) >> 1;
        index = index.clamp(IBig::ONE, &parts - IBig::ONE);
        let here = &a + &index * &step;
        let at = value(&here, e + k);
        let s = sign(&at) * sign(&fa);
        if s == 0 {
            exact(root, here, e + k);
            return;
        }
        let (other, beyond) = if s > 0 {
            (&here + &step, 1)
        } else {
            (&here - &step, -1)
        };
        let at_other = if other == b {
            fb.clone()
        } else if other == a {
            fa.clone()
        } else {
            value(&other, e + k)
        };
        let hit = sign(&at_other);
        if hit == 0 {
            exact(root, other, e + k);
            return;
        }
        e += k;
        if hit * sign(&at) < 0 {
            // One part of the grid.
            (lo, at_lo, hi, at_hi) = if beyond > 0 {
                (here, at, other, at_other)
            } else {
                (other, at_other, here, at)
            };
            k *= 2;
        } else {
            // Not where the secant said: at least that much is known.
            (lo, at_lo, hi, at_hi) = if beyond > 0 {
                (other, at_other, b, fb)
            } else {
                (a, fa, other, at_other)
            };
            k = (k / 2).max(1);
        }
        // Halve where the secant was of no use, and cut common powers of two.
        let zeros = [&lo, &hi]
            .into_iter()
            .map(|x| x.trailing_zeros().unwrap_or(usize::MAX))
            .min()
            .unwrap_or(0)
            .min(e);
        if zeros > 0 && zeros != usize::MAX {
            lo >>= zeros;
            hi >>= zeros;
            e -= zeros;
            at_lo = value(&lo, e);
            at_hi = value(&hi, e);
        }
    }
    root.lo = Place::new(lo, e);
    root.hi = Place::new(hi, e);
}
