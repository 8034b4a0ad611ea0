//! Isolation of the roots of integer polynomials in [0, 1], exactly.

use super::polynomial::{Parameter, Polynomial, signum};

/// One real root in [0, 1], by an isolating interval: the only root in `[lo, hi]`, and
/// itself `lo` where `lo == hi`; otherwise strictly between them.
#[derive(Clone, Debug)]
pub struct Root {
    /// Lower end.
    pub lo: Parameter,
    /// Upper end.
    pub hi: Parameter,
    /// How often the polynomial vanishes there, at least 1. Odd: it changes sign
    /// (at t = 0 and t = 1, only in its continuation).
    pub multiplicity: usize,
}

impl Root {
    fn point(at: Parameter, multiplicity: usize) -> Self {
        Self {
            lo: at.clone(),
            hi: at,
            multiplicity,
        }
    }

    /// Whether the root is known exactly.
    pub fn is_exact(&self) -> bool {
        self.lo == self.hi
    }
}

/// The isolated roots of one polynomial, refinable on demand.
#[derive(Clone, Debug)]
pub struct Roots {
    /// A polynomial with the same roots in (0, 1), all of them simple.
    simple: Polynomial,
    roots: Vec<Root>,
}

/// How deep the first attempt goes before it looks for multiple roots: intervals of 2^-48 are
/// ample for roots that are not made to be close.
const FIRST_DEPTH: usize = 48;

impl Roots {
    /// All roots of `f` in [0, 1], ascending, with their multiplicities; `None` where `f` is
    /// identically zero.
    ///
    /// Bisection with Descartes' rule in Bernstein form: no sign variation, no root; one, exactly
    /// one. It ends on square-free polynomials (Rouillier and Zimmermann, *Efficient isolation of
    /// polynomial's real roots*, JCAM 162 (2004)); where intervals stay undecided at first, multiple roots
    /// are taken out by exact gcds.
    pub fn isolate(f: &Polynomial) -> Option<Self> {
        if f.is_zero() {
            return None;
        }
        let mut inner = f.clone();
        let (at_zero, at_one) = inner.deflate_ends();
        let (simple, mut roots) = match bisect(&inner, Some(FIRST_DEPTH)) {
            Some(roots) => (inner, roots),
            None => multiple(&inner),
        };
        if at_zero > 0 {
            roots.insert(0, Root::point(Parameter::zero(), at_zero));
        }
        if at_one > 0 {
            roots.push(Root::point(Parameter::one(), at_one));
        }
        Some(Self { simple, roots })
    }

    /// The roots, ascending.
    pub fn as_slice(&self) -> &[Root] {
        &self.roots
    }

    /// Halves the isolating interval of root `index`; nothing happens to a root that is
    /// exact or does not exist.
    pub fn refine(&mut self, index: usize) {
        let Some(root) = self.roots.get_mut(index) else {
            return;
        };
        if root.is_exact() {
            return;
        }
        let mid = root.lo.mid(&root.hi);
        let here = self.simple.sign_at(&mid);
        if here == 0 {
            root.lo = mid.clone();
            root.hi = mid;
        } else if here == self.simple.sign_at(&root.lo) {
            root.lo = mid;
        } else {
            root.hi = mid;
        }
    }
}

/// Proven: `f` has no root in [0, 1]. False also where roots that are next to each other, or all but met, would have to be told apart at length.
pub(crate) fn none(f: &Polynomial) -> bool {
    let c = f.coefficients();
    let ends = [c.first(), c.last()].map(|c| c.map_or(0, signum));
    ends[0] * ends[1] > 0 && bisect(f, Some(FIRST_DEPTH)).is_some_and(|roots| roots.is_empty())
}

/// Isolates the roots in (0, 1) of `f`, which has none at 0 or 1. `None` where an interval
/// at `depth` is still undecided; without a limit `f` must be square-free.
fn bisect(f: &Polynomial, depth: Option<usize>) -> Option<Vec<Root>> {
    let mut roots = Vec::new();
    // Popped from the left: the roots come out ascending.
    let mut stack = vec![(f.clone(), Parameter::zero(), Parameter::one(), 0)];
    while let Some((mut f, lo, hi, level)) = stack.pop() {
        // A root at the left end was found as a midpoint; one at the right end will be.
        let (at_lo, _) = f.deflate_ends();
        match at_lo {
            0 => {}
            // f is square-free or this root is simple: it stands for itself.
            1 => roots.push(Root::point(lo.clone(), 1)),
            _ => return None,
        }
        match f.sign_variations() {
            0 => {}
            1 => roots.push(Root {
                lo,
                hi,
                multiplicity: 1,
            }),
            _ if depth.is_some_and(|d| level >= d) => return None,
            _ => {
                let mid = lo.mid(&hi);
                let (left, right) = f.halves();
                stack.push((right, mid.clone(), hi, level + 1));
                stack.push((left, lo, mid, level + 1));
            }
        }
    }
    // Isolating intervals may share an end that is itself a root: move off it.
    for i in 0..roots.len() {
        let touches = |r: &Root, at: &Parameter| !r.is_exact() && (r.lo == *at || r.hi == *at);
        if roots[i].is_exact() {
            let at = roots[i].lo.clone();
            for j in [i.wrapping_sub(1), i + 1] {
                while roots.get(j).is_some_and(|r| touches(r, &at)) {
                    shrink_away(f, &mut roots[j], &at);
                }
            }
        }
    }
    Some(roots)
}

/// Moves the end of `root` that is the other root `at` inward until it no longer is a root.
fn shrink_away(f: &Polynomial, root: &mut Root, at: &Parameter) {
    let mid = root.lo.mid(&root.hi);
    let here = f.sign_at(&mid);
    if here == 0 {
        root.lo = mid.clone();
        root.hi = mid;
        return;
    }
    // The end that is no root tells the side; a root end has the sign of nothing.
    let (far, low) = if root.lo == *at {
        (f.sign_at(&root.hi), true)
    } else {
        (f.sign_at(&root.lo), false)
    };
    let beyond = if far == 0 {
        // Both ends are roots: count by variations between the middle and the far end.
        let part = if low {
            f.restricted(&mid, &root.hi)
        } else {
            f.restricted(&root.lo, &mid)
        };
        let mut part = part;
        part.deflate_ends();
        part.sign_variations() % 2 == 1
    } else {
        far != here
    };
    match (low, beyond) {
        (true, true) => root.lo = mid,
        (true, false) => root.hi = mid,
        (false, true) => root.hi = mid,
        (false, false) => root.lo = mid,
    }
}

/// The roots of an `f` that may have multiple ones, and its square-free part.
fn multiple(f: &Polynomial) -> (Polynomial, Vec<Root>) {
    let simple = f.square_free();
    let mut roots = bisect(&simple, None).unwrap_or_default();
    let factors = f.square_free_factors();
    for root in &mut roots {
        // Exactly one factor vanishes at the root, and it has no other root near: its sign
        // changes across the interval.
        for (k, factor) in factors.iter().enumerate() {
            let hit = if root.is_exact() {
                factor.degree() > 0 && factor.sign_at(&root.lo) == 0
            } else {
                factor.sign_at(&root.lo) * factor.sign_at(&root.hi) < 0
            };
            if hit {
                root.multiplicity = k + 1;
            }
        }
    }
    (simple, roots)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dashu_int::IBig;

    /// `prod (q t - p)^k`, by its roots `p / q`.
    fn with_roots(roots: &[(i64, i64, usize)]) -> Polynomial {
        let mut f = Polynomial::from_bernstein(&[IBig::ONE]);
        for &(p, q, k) in roots {
            let factor = Polynomial::from_bernstein(&[IBig::from(-p), IBig::from(q - p)]);
            for _ in 0..k {
                f = f.times(&factor);
            }
        }
        f
    }

    /// Whether the rational root is where the interval says: on its one end, or between its two.
    fn is_held((p, q, k): (i64, i64, usize), root: &Root) -> bool {
        let factor = with_roots(&[(p, q, 1)]);
        let signs = (factor.sign_at(&root.lo), factor.sign_at(&root.hi));
        let expected = if root.is_exact() { (0, 0) } else { (-1, 1) };
        signs == expected && root.multiplicity == k
    }

    #[test]
    fn roots_are_those_that_were_multiplied() {
        for roots in [
            vec![(1, 3, 1)],
            // Next to midpoints of the bisection that are roots themselves, on either side, on both.
            vec![(1, 2, 1), (3, 5, 1)],
            vec![(2, 5, 1), (1, 2, 1)],
            vec![(1, 4, 1), (2, 5, 1), (1, 2, 1)],
            vec![(1, 4, 1), (2, 7, 1), (1, 2, 1)],
            vec![(1, 4, 1), (3, 8, 1), (1, 2, 1), (501, 1000, 1)],
            // Multiple ones, known exactly or not, and at the ends.
            vec![(1, 3, 3), (1, 2, 2)],
            vec![(1, 2, 3), (2, 3, 2), (3, 4, 1)],
            vec![(0, 1, 2), (1, 3, 1), (1, 2, 2), (1, 1, 3)],
            vec![(1, 7, 2), (3, 7, 2), (5, 7, 5), (6, 7, 1)],
        ] {
            let f = with_roots(&roots);
            let mut found = Roots::isolate(&f).unwrap();
            for turn in 0..12 {
                let all = found.as_slice();
                assert_eq!(all.len(), roots.len(), "{roots:?}");
                for (wanted, root) in roots.iter().zip(all) {
                    assert!(is_held(*wanted, root), "{roots:?} {turn}: {root:?}");
                }
                // Isolating: none reaches another's.
                for pair in all.windows(2) {
                    assert!(pair[0].hi <= pair[1].lo, "{roots:?}: {pair:?}");
                    assert!(pair[0].hi < pair[1].lo || !pair.iter().any(Root::is_exact));
                }
                let mids: Vec<_> = all.iter().map(|r| r.lo.mid(&r.hi)).collect();
                for (i, mid) in mids.iter().enumerate() {
                    found.refine(i);
                    let root = &found.as_slice()[i];
                    assert!(root.lo.cmp(mid).is_eq() || root.hi.cmp(mid).is_eq());
                }
            }
        }
    }

    #[test]
    fn no_roots_and_all() {
        let f = |c: &[i64]| Polynomial::new(c.iter().map(|x| IBig::from(*x)).collect());
        assert!(Roots::isolate(&f(&[0, 0])).is_none());
        // Two variations without a root: (1 - t)^2 - t (1 - t) + t^2 > 0.
        assert!(
            Roots::isolate(&f(&[1, -1, 1]))
                .unwrap()
                .as_slice()
                .is_empty()
        );
        assert!(Roots::isolate(&f(&[1, 2])).unwrap().as_slice().is_empty());
    }
}
