//! Isolation of the roots of integer polynomials in [0, 1], exactly.

use super::polynomial::{Parameter, Polynomial};

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
