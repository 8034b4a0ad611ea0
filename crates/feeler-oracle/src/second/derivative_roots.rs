//! Derivative roots of a trim curve: eigenvalue candidates, Sturm's theorem.
//!
//! The definitions are those of [`DerivativeRootsTruth`](crate::DerivativeRootsTruth). The numerators are `X'W - XW'` in
//! the power basis of each Bezier piece (made by inserting knots); see `isolate` for their roots. An arc's
//! coordinate `cos a P + sin a R` is stationary where `a` is the angle of (P, R), up to half turns.

use super::candidates::bernstein;
use super::fixed::Fixed;
use super::fraction::Fraction;
use super::isolate::{Roots, brackets};
use super::pieces::{ArcPiece, Linear, RationalPiece, UvPiece, locate, uv_pieces};
use super::polynomial::Polynomial;
use super::rational::{enclosure, sign, signum};
use crate::truth::{
    AxisRootsTruth, DerivativeRootTruth, DerivativeRootsTruth, OracleError, TruthEnclosure,
};
use dashu_int::{IBig, UBig};
use feeler::brep::Brep;

/// Width of the intervals, as a part of the piece.
const BITS: usize = 168;
/// Bits of a root's parameter that are known, however near to 0 it is,
const DIGITS: usize = 120;
/// unless that takes more than so many bits of the piece.
const MOST_BITS: usize = 1 << 14;

/// Whether an interval of parameters is as narrow as it is to be for its distance from 0, or cannot be made so.
fn is_narrow(t: [&Fraction; 2], bits: usize) -> bool {
    let [lo, hi] = t;
    let nearest = match signum(lo) * signum(hi) {
        1 if signum(lo) > 0 => lo.clone(),
        1 => -hi.clone(),
        _ => Fraction::ZERO,
    };
    lo == hi || bits > MOST_BITS || (hi - lo) * Fraction::from(IBig::ONE << DIGITS) <= nearest
}

/// The parameters about root `index`, of which `map` tells from its place on the piece: 0 itself, or as narrow an interval as that takes.
fn parameters(roots: &mut Roots, index: usize, map: &Linear) -> TruthEnclosure {
    let mut bits = BITS;
    loop {
        let root = &roots.roots[index];
        let t = [&root.lo, &root.hi].map(|x| map.at(&x.rational()));
        if signum(&t[0]) * signum(&t[1]) <= 0
            && roots.is_at(index, &map.inverse().at(&Fraction::ZERO))
        {
            return point(&Fraction::ZERO);
        }
        if is_narrow([&t[0], &t[1]], bits) {
            return enclosure(&t[0], &t[1]);
        }
        bits *= 2;
        roots.narrow(index, bits);
    }
}

/// One coordinate on one piece.
#[derive(Clone, Debug, Default)]
struct Stretch {
    constant: bool,
    /// At the start and at the end: multiplicity, sign beside it inside, whether it is a cusp.
    ends: [(usize, i8, bool); 2],
    inside: Vec<DerivativeRootTruth>,
}

/// All roots of u' and v' of a trim over its span. See [`DerivativeRootsTruth`]. 0.2 ms a cubic piece, up to
/// 100 ms at degree 25.
///
/// # Errors
/// There must be such a face and trim.
pub fn derivative_roots(
    breps: &[&Brep],
    face: usize,
    trim_loop: usize,
    trim: usize,
) -> Result<DerivativeRootsTruth, OracleError> {
    let pieces = pieces_of(breps, face, trim_loop, trim)?;
    let mut all = Vec::with_capacity(pieces.len());
    for piece in &pieces {
        all.push(match piece {
            UvPiece::Rational(p) => (of_rational(p), [p.from.clone(), p.to.clone()]),
            UvPiece::Arc(p) => (of_arc(p)?, [p.from.clone(), p.to.clone()]),
        });
    }
    Ok(DerivativeRootsTruth {
        axes: [0, 1].map(|axis| {
            let stretches: Vec<_> = all.iter().map(|(s, ends)| (&s[axis], ends)).collect();
            joined(&stretches)
        }),
    })
}

fn pieces_of(
    breps: &[&Brep],
    face: usize,
    trim_loop: usize,
    trim: usize,
) -> Result<Vec<UvPiece>, OracleError> {
    let (brep, local) = locate(breps, face)?;
    let parts = brep.parts();
    let none = || OracleError::Refused("there is no such trim".into());
    let loops = brep.faces()[local].loops.as_ref().ok_or_else(none)?;
    let owner = &parts.loops[*loops.get(trim_loop).ok_or_else(none)?];
    let trim = &parts.trims[*owner.trims.get(trim).ok_or_else(none)?];
    uv_pieces(trim, &parts.curves2[trim.curve])
}

/// How many roots of a trim's derivatives there are inside its pieces, and how many of them the eigenvalues isolated without help
/// from Sturm's counts; arcs left out. To measure what they gain.
#[doc(hidden)]
pub fn isolated_by_candidates(breps: &[&Brep], face: usize) -> Result<[usize; 2], OracleError> {
    let (brep, local) = locate(breps, face)?;
    let parts = brep.parts();
    let mut counts = [0; 2];
    for l in brep.faces()[local].loops.iter().flatten() {
        for t in &parts.loops[*l].trims {
            let trim = &parts.trims[*t];
            for piece in uv_pieces(trim, &parts.curves2[trim.curve])? {
                let UvPiece::Rational(p) = piece else {
                    continue;
                };
                for f in numerators(&p) {
                    if let Some((_, roots, _)) = stationary(&f) {
                        counts[0] += roots.roots.len();
                        counts[1] += roots.from_candidates;
                    }
                }
            }
        }
    }
    Ok(counts)
}

fn numerators(p: &RationalPiece) -> [Polynomial; 2] {
    let power = p.power();
    [0, 1].map(|axis| {
        let (x, w) = (&power[axis], &power[2]);
        let mut n = vec![IBig::ZERO; x.len() + w.len()];
        for (i, a) in x.iter().enumerate() {
            for (j, b) in w.iter().enumerate() {
                if i != j {
                    n[i + j - 1] += a * b * (IBig::from(i) - IBig::from(j));
                }
            }
        }
        Polynomial::new(n)
    })
}

/// Finds what may be roots in [0, 1] of a polynomial with these Bernstein coefficients, ascending.
pub type Candidates = dyn Fn(&[f64]) -> Result<Vec<f64>, OracleError>;

/// Intervals of a trim's span, about `candidates` of the roots of u' and of v', across which that has exactly proven
/// different signs: each holds a root of odd multiplicity, and they are disjoint. Arcs are left out. `candidates`, of a
/// polynomial with these Bernstein coefficients, ascending, may be anything: a wrong one gives no interval.
///
/// # Errors
/// There must be such a face and trim; or those of `candidates`.
pub fn root_brackets(
    breps: &[&Brep],
    at: [usize; 3],
    candidates: &Candidates,
) -> Result<[Vec<TruthEnclosure>; 2], OracleError> {
    let [face, trim_loop, trim] = at;
    let mut found = [Vec::new(), Vec::new()];
    for piece in &pieces_of(breps, face, trim_loop, trim)? {
        let UvPiece::Rational(p) = piece else {
            continue;
        };
        let map = Linear::new(
            [Fraction::ZERO, Fraction::ONE],
            [p.from.clone(), p.to.clone()],
        );
        for (f, found) in numerators(p).iter().zip(&mut found) {
            let Some((_, f)) = without_ends(f) else {
                continue;
            };
            for [lo, hi] in brackets(&f, &candidates(&bernstein(&f))?) {
                found.push(enclosure(&map.at(&lo.rational()), &map.at(&hi.rational())));
            }
        }
    }
    Ok(found)
}

/// Multiplicities at 0 and at 1, and the polynomial divided by these factors t and t - 1; `None` for zero.
fn without_ends(f: &Polynomial) -> Option<([usize; 2], Polynomial)> {
    let first = f.0.iter().position(|a| *a != IBig::ZERO)?;
    let mut rest = Polynomial::new(f.0[first..].to_vec());
    let mut last = 0;
    // Divided by t - 1 while that is a factor.
    while rest.0.iter().sum::<IBig>() == IBig::ZERO {
        let mut q = Vec::with_capacity(rest.0.len() - 1);
        let mut carry = IBig::ZERO;
        for a in rest.0.iter().skip(1).rev() {
            carry += a;
            q.push(carry.clone());
        }
        q.reverse();
        rest = Polynomial::new(q);
        last += 1;
    }
    Some(([first, last], rest))
}

/// Multiplicities at 0 and 1, the roots between, and the signs beside 0 and 1; `None` for zero.
fn stationary(f: &Polynomial) -> Option<([usize; 2], Roots, [i8; 2])> {
    let ([first, last], rest) = without_ends(f)?;
    let start = sign(&f.0[first]) as i8;
    // Below 1 each factor t - 1 is negative.
    let at_one = sign(&rest.0.iter().sum::<IBig>()) as i8;
    let end = if last % 2 == 1 { -at_one } else { at_one };
    Some(([first, last], Roots::isolate(&rest, BITS), [start, end]))
}

fn of_rational(p: &RationalPiece) -> [Stretch; 2] {
    let n = numerators(p);
    let common = n[0].gcd(&n[1]);
    let map = Linear::new(
        [Fraction::ZERO, Fraction::ONE],
        [p.from.clone(), p.to.clone()],
    );
    [0, 1].map(|axis| {
        let Some((multiplicity, mut roots, signs)) = stationary(&n[axis]) else {
            return Stretch {
                constant: true,
                ..Stretch::default()
            };
        };
        let cusp_at = |x: &Fraction| common.sign_at(x) == 0;
        let mut current = signs[0];
        let inside = (0..roots.roots.len())
            .map(|i| {
                let m = roots.roots[i].multiplicity;
                let next = if m % 2 == 1 { -current } else { current };
                let root = DerivativeRootTruth {
                    t: parameters(&mut roots, i, &map),
                    multiplicity: [m, m],
                    sign: [current, next],
                    cusp: common.degree() > 0 && roots.shares(i, &common),
                };
                current = next;
                root
            })
            .collect();
        debug_assert_eq!(current, signs[1]);
        Stretch {
            constant: false,
            ends: [0, 1].map(|end| {
                let cusp = multiplicity[end] > 0 && cusp_at(&Fraction::from(end));
                (multiplicity[end], signs[end], cusp)
            }),
            inside,
        }
    })
}

fn of_arc(p: &ArcPiece) -> Result<[Stretch; 2], OracleError> {
    let turned = if p.clockwise {
        [p.x[1].clone(), -p.x[0].clone()]
    } else {
        [-p.x[1].clone(), p.x[0].clone()]
    };
    let map = Linear::new(p.angle.clone(), [p.from.clone(), p.to.clone()]);
    let mut out = [Stretch::default(), Stretch::default()];
    for axis in 0..2 {
        let row = [&p.x[axis], &turned[axis]];
        // An end is never a zero but at 0 (see `cpp/derivative_roots.hpp` for why): some precision decides.
        let mut bits = BITS + 64;
        out[axis] = loop {
            if let Some(found) = arc_stretch(row, &p.angle, &map, bits) {
                break found;
            }
            if bits > 1 << 16 {
                return Err(OracleError::Refused(
                    "an arc's end too near an extremum".into(),
                ));
            }
            bits *= 2;
        };
    }
    Ok(out)
}

/// The derivative of `cos a P + sin a R` is `R cos a - P sin a`; `None` where the precision does not do.
fn arc_stretch(
    row: [&Fraction; 2],
    angle: &[Fraction; 2],
    map: &Linear,
    bits: usize,
) -> Option<Stretch> {
    let [p, r] = row;
    // The derivative at a = 0 is R; its next one there is -P.
    let level = signum(r) == 0;
    let scale = Fraction::from_parts(IBig::ONE, UBig::ONE << BITS);
    let widest = (&angle[1] - &angle[0]) * scale;
    // Scaled, so that fixed point sees small frames.
    let size = if p.clone() * p > r.clone() * r { p } else { r };
    let size = if signum(size) < 0 {
        -size.clone()
    } else {
        size.clone()
    };
    let (p1, r1) = (
        Fixed::new(&(p / &size), bits),
        Fixed::new(&(r / &size), bits),
    );
    let slope = |a: &Fraction| -> Option<i8> {
        let (c, s) = Fixed::direction(a, bits);
        let value = Fixed::new(r, bits)
            .mul(&c)
            .sub(&Fixed::new(p, bits).mul(&s));
        match value.sign() {
            0 => None,
            s => Some(s as i8),
        }
    };
    let phi = if level {
        Fixed::integer(0, bits)
    } else {
        Fixed::angle(&p1, &r1)?
    };
    let pi = Fixed::pi(bits);
    let first = (angle[0].clone() / pi.hi()).floor();
    let mut k = i64::try_from(first).ok()? - 3;
    let mut stretch = Stretch::default();
    let zero_at = |x: &Fraction| level && signum(x) == 0;
    for (end, a) in angle.iter().enumerate() {
        // Just above 0 the derivative has the sign of -P, below it that of P.
        stretch.ends[end] = if zero_at(a) {
            let inward = if end == 0 { -signum(p) } else { signum(p) };
            (1, inward as i8, false)
        } else {
            (0, slope(&a.clone())?, false)
        };
    }
    let mut current = stretch.ends[0].1;
    loop {
        let zero = phi.add(&pi.times(k));
        let (lo, hi) = if level && k == 0 {
            (Fraction::ZERO, Fraction::ZERO)
        } else {
            (zero.lo(), zero.hi())
        };
        k += 1;
        if hi < angle[0] || (lo == hi && lo == angle[0]) {
            continue;
        }
        if lo > angle[1] || (lo == hi && hi == angle[1]) {
            break;
        }
        let t = [map.at(&lo), map.at(&hi)];
        if lo <= angle[0]
            || hi >= angle[1]
            || &hi - &lo > widest
            || !is_narrow([&t[0], &t[1]], bits)
        {
            return None;
        }
        stretch.inside.push(DerivativeRootTruth {
            t: enclosure(&t[0], &t[1]),
            multiplicity: [1, 1],
            sign: [current, -current],
            cusp: false,
        });
        current = -current;
    }
    (current == stretch.ends[1].1).then_some(stretch)
}

fn point(x: &Fraction) -> TruthEnclosure {
    enclosure(x, x)
}

fn joined(stretches: &[(&Stretch, &[Fraction; 2])]) -> AxisRootsTruth {
    let mut out = AxisRootsTruth::default();
    let mut before: Option<&Stretch> = None;
    let nothing = (0, 0, false);
    let mut push = |at: &Fraction, before: Option<&Stretch>, after: Option<&Stretch>| {
        let a = before.map_or(nothing, |s| s.ends[1]);
        let b = after.map_or(nothing, |s| s.ends[0]);
        if a.0 > 0 || b.0 > 0 || a.1 * b.1 < 0 {
            out.roots.push(DerivativeRootTruth {
                t: point(at),
                multiplicity: [a.0, b.0],
                sign: [a.1, b.1],
                cusp: a.2 || b.2,
            });
        }
        if let Some(s) = after {
            out.roots.extend(s.inside.iter().cloned());
        }
    };
    for (s, ends) in stretches {
        push(&ends[0], before, Some(s));
        before = Some(s);
    }
    if let Some((_, ends)) = stretches.last() {
        push(&ends[1], before, None);
    }
    let mut constant: Vec<[Fraction; 2]> = Vec::new();
    for (i, (s, ends)) in stretches.iter().enumerate() {
        if !s.constant {
            continue;
        }
        match constant.last_mut() {
            Some(last) if i > 0 && stretches[i - 1].0.constant => last[1] = ends[1].clone(),
            _ => constant.push((*ends).clone()),
        }
    }
    out.constant = constant
        .iter()
        .map(|c| [point(&c[0]), point(&c[1])])
        .collect();
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn power_of_two(e: usize) -> Fraction {
        Fraction::from_parts(IBig::ONE, UBig::ONE << e)
    }

    /// The parabola with these Bernstein coefficients for u, over [from, to].
    fn parabola(u: [Fraction; 3], from: i64, to: i64) -> RationalPiece {
        let points: Vec<_> = u
            .into_iter()
            .map(|u| vec![u, Fraction::ZERO, Fraction::ONE])
            .collect();
        RationalPiece::new(&points, Fraction::from(from), Fraction::from(to))
    }

    #[test]
    fn roots_next_to_0_are_known_to_many_digits() {
        for e in [60, 200, 1070] {
            // u = t^2 - 2 e t (1 - t): stationary at e / (1 + 2 e).
            let small = power_of_two(e);
            let root = &small / (Fraction::ONE + &small + &small);
            let piece = parabola([Fraction::ZERO, -small, Fraction::ONE], 0, 1);
            let [u, v] = of_rational(&piece);
            assert!(v.constant && u.inside.len() == 1);
            let t = &u.inside[0].t;
            let [lo, hi] = [&t.lo, &t.hi].map(super::super::rational::of_dyadic);
            assert!(lo <= root && root <= hi, "2^-{e}: {t:?}");
            assert!((hi - &lo) <= &root * power_of_two(100), "2^-{e}: {t:?}");
        }
    }

    #[test]
    fn a_root_at_0_is_told_exactly() {
        // t^2 over [-1, 2], where 0 is at a third.
        let piece = parabola([1, -2, 4].map(Fraction::from), -1, 2);
        let t = &of_rational(&piece)[0].inside[0].t;
        assert!(t.lo.signum() == 0 && t.hi.signum() == 0, "{t:?}");
    }

    #[test]
    fn extremes_of_arcs_next_to_0_are_known_to_many_digits() {
        // x' = (1, 2^-300): v is stationary a quarter turn on, u at the angle atan 2^-300, between 2^-300 (1 - 2^-600) and 2^-300.
        let arc = ArcPiece {
            center: [Fraction::ZERO, Fraction::ZERO],
            x: [Fraction::ONE, -power_of_two(300)],
            clockwise: false,
            radius: Fraction::ONE,
            angle: [-1, 1].map(Fraction::from),
            from: Fraction::from(-1),
            to: Fraction::ONE,
        };
        let [u, _] = of_arc(&arc).unwrap();
        let t = &u.inside[0].t;
        let [lo, hi] = [&t.lo, &t.hi].map(super::super::rational::of_dyadic);
        let most = power_of_two(300);
        let least = &most * (Fraction::ONE - power_of_two(600));
        assert!(lo <= most && least <= hi, "{t:?}");
        assert!((hi - lo) <= most * power_of_two(100), "{t:?}");
    }
}
