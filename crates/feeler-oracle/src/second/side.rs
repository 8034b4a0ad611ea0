//! The side of a uv point: exact parity along a ray in a direction made from the point.
//!
//! For a direction d = (a, b) of small integers and a piece (X / W, Y / W), h = b (X - u W) - a (Y - v W) is 0 where the piece
//! meets the ray's line and g = a (X - u W) + b (Y - v W) > 0 on the ray. First the point itself: it is on the piece iff
//! the gcd of X - u W and Y - v W has a root in [0, 1]. Otherwise g is not 0 where h is. What the hull of the control points does not settle is
//! counted in one of two ways:
//!
//! - [`TrimmedRegion::side`]: by Sturm chains alone, as neither the first method nor the kernel does. The roots of h with g > 0 are half of (roots of h) + (sum of
//!   the signs of g there), two counts. A direction for which h vanishes at an end of a piece or has a multiple root in [0, 1] is put
//!   aside: then each root counted is a transversal crossing inside a piece, and the parity of all of them is that of the point. Another
//!   direction is taken; a piece rules out finitely many.
//! - [`TrimmedRegion::side_by_halving`]: quick, but as the first method and the kernel decide, so that it is no check on how they do. That the gcd is 1 is
//!   proven by residues modulo a prime where they can; then h and g are halved in Bernstein form, in integers, until one of them has one sign
//!   on each part: where g > 0, the ends of h tell whether the ray's line is passed there an odd number of times. A direction for which h
//!   vanishes at an end of a piece is put aside. The parity of all passages is that of the point, touchings with it, which pass an even
//!   number of times.
//!
//! A circular arc meets the line at the roots of a quadratic with rational coefficients; how often the arc
//! passes each is told by its angle in fixed point of growing precision. Segments to the ends of arcs likewise, by the
//! signs of h at their ends.

use super::fixed::Fixed;
use super::fraction::Fraction;
use super::pieces::{ArcPiece, RationalPiece, UvPiece, locate, uv_pieces};
use super::polynomial::{Chain, Polynomial, coprime_by_residues};
use super::rational::{rational, sign, signum};
use crate::truth::{OracleError, SideTruth};
use dashu_int::IBig;
use feeler::brep::Brep;
use feeler::trim::Side;

/// An end of a piece.
#[allow(clippy::large_enum_variant, reason = "arcs are few")]
#[derive(Clone, Debug)]
enum End {
    Point([Fraction; 2]),
    /// The point of an arc's circle at an angle.
    OnCircle(ArcPiece, Fraction),
}

/// What a loop is made of.
#[allow(clippy::large_enum_variant, reason = "arcs are few")]
#[derive(Clone, Debug)]
enum Part {
    Rational(RationalPiece),
    Arc(ArcPiece),
    /// A straight segment, one end of which at least is on a circle.
    Segment(End, End),
}

/// The trimmed region of a face, to be asked about many points.
#[derive(Debug)]
pub struct TrimmedRegion {
    parts: Vec<Part>,
    gaps: Vec<[End; 2]>,
    domain: [[Fraction; 2]; 2],
    whole: bool,
}

/// What a part does to the parity of a point.
enum Crossings {
    /// It holds the point.
    On,
    /// It is met so many times, or as good as: only whether the count is odd matters.
    Count(i64),
    /// The direction does not do.
    Degenerate,
}

/// How crossings of rational pieces are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Counting {
    Sturm,
    Halving,
}

/// Precisions that are tried for what is irrational; then another direction is.
const PRECISIONS: [usize; 3] = [160, 640, 2560];
/// Directions tried before nothing is said.
const DIRECTIONS: u64 = 40;

impl End {
    /// A rational point where it is known to be one: at angle 0 of a frame along an axis.
    fn settled(self) -> Self {
        if let Self::OnCircle(arc, angle) = &self
            && signum(angle) == 0
        {
            let axis = (0..2).find(|i| signum(&arc.x[1 - i]) == 0);
            if let Some(i) = axis {
                let mut at = arc.center.clone();
                let r = &arc.radius;
                at[i] = if signum(&arc.x[i]) > 0 {
                    &at[i] + r
                } else {
                    &at[i] - r
                };
                return Self::Point(at);
            }
        }
        self
    }

    fn fixed(&self, bits: usize) -> [Fixed; 2] {
        match self {
            Self::Point(p) => p.each_ref().map(|x| Fixed::new(x, bits)),
            Self::OnCircle(arc, angle) => arc.point(angle, bits),
        }
    }

    /// Whether two ends are the same; `None` where that is not known.
    fn same(&self, other: &Self) -> Option<bool> {
        match (self, other) {
            (Self::Point(a), Self::Point(b)) => return Some(a == b),
            (Self::OnCircle(a, x), Self::OnCircle(b, y)) => {
                let circle = a.center == b.center && a.radius == b.radius;
                if circle && a.x == b.x && a.clockwise == b.clockwise && x == y {
                    return Some(true);
                }
            }
            _ => {}
        }
        PRECISIONS.iter().find_map(|bits| {
            let (a, b) = (self.fixed(*bits), other.fixed(*bits));
            (0..2).any(|i| a[i].sub(&b[i]).sign() != 0).then_some(false)
        })
    }
}

impl ArcPiece {
    /// x' of the frame.
    fn frame(&self, bits: usize) -> [Fixed; 2] {
        let size = [0, 1]
            .map(|i| {
                if signum(&self.x[i]) < 0 {
                    -self.x[i].clone()
                } else {
                    self.x[i].clone()
                }
            })
            .into_iter()
            .max()
            .unwrap_or(Fraction::ONE);
        let x = self.x.each_ref().map(|c| c / &size);
        let norm = Fixed::new(&(&x[0] * &x[0] + &x[1] * &x[1]), bits).sqrt();
        // Scaled, the norm is between 1 and 2.
        x.each_ref().map(|c| {
            let c = Fixed::new(c, bits);
            c.div(&norm).unwrap_or(c)
        })
    }

    fn point(&self, angle: &Fraction, bits: usize) -> [Fixed; 2] {
        let x = self.frame(bits);
        let (c, s) = Fixed::direction(angle, bits);
        let s = if self.clockwise { s.neg() } else { s };
        let r = Fixed::new(&self.radius, bits);
        let d = [
            x[0].mul(&c).sub(&x[1].mul(&s)),
            x[1].mul(&c).add(&x[0].mul(&s)),
        ];
        [0, 1].map(|i| Fixed::new(&self.center[i], bits).add(&r.mul(&d[i])))
    }

    /// How often the arc passes the point of its circle at offset `o` from the centre (not to scale); `None` where that is not
    /// known.
    fn passes(&self, o: &[Fixed; 2], bits: usize) -> Option<i64> {
        let x = self.frame(bits);
        let along = x[0].mul(&o[0]).add(&x[1].mul(&o[1]));
        let across = x[0].mul(&o[1]).sub(&x[1].mul(&o[0]));
        let across = if self.clockwise { across.neg() } else { across };
        let a = Fixed::angle(&along, &across)?;
        let turn = Fixed::pi(bits).times(2);
        let (start, end) = (
            Fixed::new(&self.angle[0], bits),
            Fixed::new(&self.angle[1], bits),
        );
        // Start where the angle is below the arc's start for sure.
        let first = (&self.angle[0] / turn.hi()).floor();
        let mut k = i64::try_from(first).ok()? - 2;
        let mut count = 0;
        loop {
            let here = a.add(&turn.times(k));
            k += 1;
            match (here.sub(&start).sign(), end.sub(&here).sign()) {
                (-1, _) => {}
                (_, -1) => return Some(count),
                (1, 1) => count += 1,
                _ => return None,
            }
        }
    }
}

impl TrimmedRegion {
    /// Of face `face` of one BREP.
    ///
    /// # Errors
    /// The face must be there; ends of arcs must be tellable apart.
    pub fn new(brep: &Brep, face: usize) -> Result<Self, OracleError> {
        let mut domain = Vec::with_capacity(2);
        for d in brep.surface(face).domain() {
            domain.push([rational(d.start)?, rational(d.end)?]);
        }
        let [Some(v), Some(u)] = [domain.pop(), domain.pop()] else {
            return Err(OracleError::Defect("a domain of two intervals"));
        };
        let loops = &brep.faces()[face].loops;
        let mut region = Self {
            parts: Vec::new(),
            gaps: Vec::new(),
            domain: [u, v],
            whole: loops.is_none(),
        };
        let parts = brep.parts();
        for l in loops.iter().flatten() {
            // Ends of all pieces in the order of the loop.
            let mut ends: Vec<[End; 2]> = Vec::new();
            for t in &parts.loops[*l].trims {
                let trim = &parts.trims[*t];
                let mut pieces = uv_pieces(trim, &parts.curves2[trim.curve])?;
                if trim.reversed {
                    pieces.reverse();
                }
                for piece in pieces {
                    let (mut pair, part) = match piece {
                        UvPiece::Rational(p) => (
                            [End::Point(p.end(false)), End::Point(p.end(true))],
                            Part::Rational(p),
                        ),
                        UvPiece::Arc(p) => (
                            [0, 1].map(|i: usize| {
                                End::OnCircle(p.clone(), p.angle[i].clone()).settled()
                            }),
                            Part::Arc(p),
                        ),
                    };
                    if trim.reversed {
                        pair.reverse();
                    }
                    ends.push(pair);
                    region.parts.push(part);
                }
            }
            for i in 0..ends.len() {
                let next = &ends[(i + 1) % ends.len()][0];
                region.join(&ends[i][1], next)?;
            }
        }
        Ok(region)
    }

    fn join(&mut self, a: &End, b: &End) -> Result<(), OracleError> {
        match a.same(b) {
            Some(true) => return Ok(()),
            Some(false) => {}
            None => {
                return Err(OracleError::Refused(
                    "ends of arcs that cannot be told apart".into(),
                ));
            }
        }
        self.gaps.push([a.clone(), b.clone()]);
        self.parts.push(match (a, b) {
            (End::Point(a), End::Point(b)) => {
                Part::Rational(RationalPiece::segment(a, b, Fraction::ZERO, Fraction::ONE))
            }
            _ => Part::Segment(a.clone(), b.clone()),
        });
        Ok(())
    }

    /// The side of a point, by Sturm chains: independent of the first method and of the kernel. 20 to 500 us and 1 us a piece up to
    /// degree 10 or so; seconds at degree 25 with coefficients of very different size.
    ///
    /// # Errors
    /// `uv` must be finite; a point so near an arc's end that no precision tells is refused.
    pub fn side(&self, uv: [f64; 2]) -> Result<SideTruth, OracleError> {
        self.counted(uv, Counting::Sturm)
    }

    /// The same by halving Bernstein forms: quick at any degree, and no check on how the first method and the kernel decide, which is the
    /// same way.
    ///
    /// # Errors
    /// As [`side`](Self::side).
    pub fn side_by_halving(&self, uv: [f64; 2]) -> Result<SideTruth, OracleError> {
        self.counted(uv, Counting::Halving)
    }

    fn counted(&self, uv: [f64; 2], counting: Counting) -> Result<SideTruth, OracleError> {
        let q = [rational(uv[0])?, rational(uv[1])?];
        Ok(SideTruth {
            side: self.side_of(&q, uv, counting)?,
            in_gap: self.in_gap(&q)?,
        })
    }

    fn side_of(
        &self,
        q: &[Fraction; 2],
        seed: [f64; 2],
        counting: Counting,
    ) -> Result<Side, OracleError> {
        let d = &self.domain;
        if (0..2).any(|i| q[i] < d[i][0] || q[i] > d[i][1]) {
            return Ok(Side::Outside);
        }
        let mut state = seed[0].to_bits() ^ seed[1].to_bits().rotate_left(23);
        let mut unsettled = false;
        for _ in 0..DIRECTIONS {
            // SplitMix64; the least bits would be those of the mantissas.
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            let a = (z % 127) as i64 - 63;
            let b = ((z >> 32) % 127) as i64 - 63;
            if a == 0 && b == 0 {
                continue;
            }
            let mut odd = self.whole;
            unsettled = false;
            for part in &self.parts {
                match part.crossings(q, [a, b], counting) {
                    Crossings::On => return Ok(Side::Boundary),
                    Crossings::Count(n) => odd ^= n % 2 != 0,
                    // Other parts may still hold the point, for any direction: go on.
                    Crossings::Degenerate => unsettled = true,
                }
            }
            if unsettled {
                continue;
            }
            let border = (0..2).any(|i| q[i] == d[i][0] || q[i] == d[i][1]);
            return Ok(match (odd, border) {
                (false, _) => Side::Outside,
                (true, true) => Side::Boundary,
                (true, false) => Side::Inside,
            });
        }
        debug_assert!(unsettled);
        Err(OracleError::Refused("no direction settles the side".into()))
    }

    fn in_gap(&self, q: &[Fraction; 2]) -> Result<bool, OracleError> {
        for [a, b] in &self.gaps {
            let inside = |i: usize| -> Option<bool> {
                PRECISIONS.iter().find_map(|bits| {
                    let x = Fixed::new(&q[i], *bits);
                    let side = |e: &End| match e {
                        End::Point(p) => Some(signum(&(&p[i] - &q[i]))),
                        other => match other.fixed(*bits)[i].sub(&x).sign() {
                            0 => None,
                            s => Some(s),
                        },
                    };
                    Some(side(a)? * side(b)? <= 0)
                })
            };
            let none = || OracleError::Refused("an end too near the point".into());
            match (inside(0), inside(1)) {
                (Some(false), _) | (_, Some(false)) => {}
                (Some(true), Some(true)) => return Ok(true),
                _ => return Err(none()),
            }
        }
        Ok(false)
    }
}

impl Part {
    fn crossings(&self, q: &[Fraction; 2], d: [i64; 2], counting: Counting) -> Crossings {
        match self {
            Self::Rational(p) => rational_crossings(p, q, d, counting),
            Self::Arc(p) => arc_crossings(p, q, d),
            Self::Segment(a, b) => segment_crossings(a, b, q, d),
        }
    }
}

/// All are < 0, = 0, > 0.
const BELOW: [bool; 3] = [true, false, false];
const NOTHING: [bool; 3] = [false, true, false];
const ABOVE: [bool; 3] = [false, false, true];

/// The signs of numbers: some < 0, some = 0, some > 0.
fn signs<'a>(all: impl IntoIterator<Item = &'a IBig>) -> [bool; 3] {
    let mut out = [false; 3];
    for x in all {
        out[(sign(x) + 1) as usize] = true;
    }
    out
}

fn rational_crossings(
    p: &RationalPiece,
    q: &[Fraction; 2],
    d: [i64; 2],
    counting: Counting,
) -> Crossings {
    // X - u W and Y - v W, times positive numbers of their own.
    let offset = |axis: usize, c: &[IBig; 3]| {
        let (n, m) = (q[axis].numerator(), q[axis].denominator());
        &c[axis] * IBig::from(m.clone()) - n * &c[2]
    };
    let scale = [0, 1].map(|i: usize| IBig::from(q[1 - i].denominator().clone()));
    let offsets: Vec<[IBig; 2]> = p
        .bernstein
        .iter()
        .map(|c| [offset(0, c) * &scale[0], offset(1, c) * &scale[1]])
        .collect();
    let d = d.map(IBig::from);
    let h: Vec<IBig> = offsets
        .iter()
        .map(|o| &d[1] * &o[0] - &d[0] * &o[1])
        .collect();
    // The curve lies in the hull of its control points.
    let s = signs(&h);
    if s == BELOW || s == ABOVE {
        return Crossings::Count(0);
    }
    let g: Vec<IBig> = offsets
        .iter()
        .map(|o| &d[0] * &o[0] + &d[1] * &o[1])
        .collect();
    let ahead = signs(&g);
    if ahead == BELOW {
        return Crossings::Count(0);
    }
    let ends = [sign(&h[0]), sign(&h[h.len() - 1])];
    if ahead == ABOVE && ends[0] * ends[1] != 0 {
        // All of it is ahead: its ends tell.
        return Crossings::Count(i64::from(ends[0] != ends[1]));
    }
    let [x, y] = [0, 1].map(|i: usize| offsets.iter().map(|o| o[i].clone()).collect::<Vec<_>>());
    match counting {
        Counting::Sturm => {
            let [x, y, h, g] = [&x, &y, &h, &g].map(|f| Polynomial::from_bernstein(f));
            let sums = Chain::query(&h, &g);
            // Where x and y have a common root, so have h and g.
            if (h.is_zero() || sums.gcd().degree() > 0) && have_common_root(&x, &y) {
                return Crossings::On;
            }
            crossings(&h, &sums).map_or(Crossings::Degenerate, Crossings::Count)
        }
        Counting::Halving => {
            let is_here = |o: &[IBig; 2]| signs(o) == NOTHING;
            if is_here(&offsets[0]) || is_here(&offsets[offsets.len() - 1]) || holds_origin(&x, &y)
            {
                return Crossings::On;
            }
            if ends[0] == 0 || ends[1] == 0 {
                return Crossings::Degenerate;
            }
            Crossings::Count(i64::from(passes_oddly(h, g)))
        }
    }
}

/// Whether two polynomials have a common root in [0, 1]: Euclid's algorithm and Sturm's theorem.
fn have_common_root(x: &Polynomial, y: &Polynomial) -> bool {
    let common = x.gcd(y);
    common.is_zero() || roots_in_unit(&common) > 0
}

/// How many roots `h` has in (0, 1) with `g > 0`, where the two have no common root in [0, 1]: half of (roots of h) + (sum of the signs of g there), the latter by
/// the chain of the two. `None` where h is 0 at an end or has a multiple root in [0, 1].
fn crossings(h: &Polynomial, sums: &Chain) -> Option<i64> {
    let (zero, one) = (Fraction::ZERO, Fraction::ONE);
    if h.sign_at(&zero) * h.sign_at(&one) == 0 {
        return None;
    }
    let chain = Chain::new(h);
    if roots_in_unit(chain.gcd()) > 0 {
        return None;
    }
    Some((chain.between(&zero, &one) + sums.between(&zero, &one)) / 2)
}

/// Whether two polynomials in Bernstein form have a common root in [0, 1], residues first.
fn holds_origin(x: &[IBig], y: &[IBig]) -> bool {
    !coprime_by_residues(x, y)
        && have_common_root(
            &Polynomial::from_bernstein(x),
            &Polynomial::from_bernstein(y),
        )
}

/// Whether `[h > 0]` changes an odd number of times where `g > 0`, over [0, 1]; in Bernstein form, of one degree, without a common
/// root in [0, 1], and `h` not 0 at the ends.
///
/// Halved until on each part `h` has one sign, or `g` has. A part with `g > 0` counts by the ends of `h`, others not at all: where `h` is 0 in the
/// middle, both halves take it for `h < 0`, as the curve would have it a little to that side. Ends since h and g have no common root.
fn passes_oddly(h: Vec<IBig>, g: Vec<IBig>) -> bool {
    let mut odd = false;
    let mut parts = vec![(h, g)];
    while let Some((h, g)) = parts.pop() {
        let (s, ahead) = (signs(&h), signs(&g));
        if s == BELOW || s == ABOVE || ahead == BELOW {
            continue;
        }
        if ahead == ABOVE {
            odd ^= (sign(&h[0]) > 0) != (sign(&h[h.len() - 1]) > 0);
            continue;
        }
        let ([h, h2], [g, g2]) = (halves(h), halves(g));
        parts.push((h2, g2));
        parts.push((h, g));
    }
    odd
}

/// A polynomial in Bernstein form over the two halves of its interval, times a power of two (de Casteljau).
fn halves(mut c: Vec<IBig>) -> [Vec<IBig>; 2] {
    let n = c.len() - 1;
    let mut first = Vec::with_capacity(n + 1);
    // After k steps c[i] is 2^k times the value that it stands for.
    for k in 0..=n {
        first.push(c[0].clone() << (n - k));
        for i in 0..n - k {
            c[i] = &c[i] + &c[i + 1];
        }
    }
    // c[i] was last written in step n - i.
    let last = c
        .into_iter()
        .enumerate()
        .map(|(i, x)| x << i)
        .collect::<Vec<_>>();
    [first, last].map(|mut half| {
        let zeros = half.iter().filter_map(IBig::trailing_zeros).min();
        if let Some(zeros) = zeros.filter(|z| *z > 0) {
            for x in &mut half {
                *x >>= zeros;
            }
        }
        half
    })
}

/// The number of distinct roots of a polynomial, not zero, in [0, 1].
fn roots_in_unit(f: &Polynomial) -> i64 {
    if f.degree() == 0 {
        return 0;
    }
    let (zero, one) = (Fraction::ZERO, Fraction::ONE);
    let at = [f.sign_at(&zero), f.sign_at(&one)];
    if at[0] == 0 || at[1] == 0 {
        return 1;
    }
    Chain::new(f).between(&zero, &one)
}

fn arc_crossings(p: &ArcPiece, q: &[Fraction; 2], d: [i64; 2]) -> Crossings {
    let o = [0, 1].map(|i| &q[i] - &p.center[i]);
    let d = d.map(Fraction::from);
    // |o + s d|^2 = r^2: a s^2 + 2 b s + c = 0.
    let a = &d[0] * &d[0] + &d[1] * &d[1];
    let b = &d[0] * &o[0] + &d[1] * &o[1];
    let c = &o[0] * &o[0] + &o[1] * &o[1] - &p.radius * &p.radius;
    if signum(&c) == 0 {
        // On the circle: is it on the arc?
        let passes = PRECISIONS.iter().find_map(|bits| {
            let o = o.each_ref().map(|x| Fixed::new(x, *bits));
            p.passes(&o, *bits)
        });
        match passes {
            Some(0) => {}
            Some(_) => return Crossings::On,
            // An end that is the point itself: at angle 0 of a frame along an axis.
            None => {
                let end = |i: usize| End::OnCircle(p.clone(), p.angle[i].clone()).settled();
                let here = |e: End| matches!(e, End::Point(x) if x == *q);
                return if here(end(0)) || here(end(1)) {
                    Crossings::On
                } else {
                    Crossings::Degenerate
                };
            }
        }
    }
    on_line(p, &o, &d, &a, &b, &c)
}

/// The arc's passages through the circle's points on the ray; the point itself is not on the arc.
fn on_line(
    p: &ArcPiece,
    o: &[Fraction; 2],
    d: &[Fraction; 2],
    a: &Fraction,
    b: &Fraction,
    c: &Fraction,
) -> Crossings {
    let discriminant = b * b - a * c;
    match signum(&discriminant) {
        -1 => return Crossings::Count(0),
        0 => return Crossings::Degenerate,
        _ => {}
    }
    // s = (-b -+ sqrt(b^2 - a c)) / a. Their product is c / a, their sum -2 b / a: signs are exact.
    let (product, sum) = (signum(c), -signum(b));
    let ahead = match (product, sum) {
        (-1, _) => [false, true],
        (1, 1) => [true, true],
        (1, _) => [false, false],
        (_, 1) => [false, true],
        _ => [false, false],
    };
    let count = PRECISIONS.iter().find_map(|bits| {
        let root = Fixed::new(&discriminant, *bits).sqrt();
        let b = Fixed::new(b, *bits);
        let mut count = 0;
        for (i, ahead) in ahead.into_iter().enumerate() {
            if !ahead {
                continue;
            }
            let s = if i == 0 {
                b.neg().sub(&root)
            } else {
                root.sub(&b)
            };
            let s = s.div(&Fixed::new(a, *bits))?;
            let at =
                [0, 1].map(|k| Fixed::new(&o[k], *bits).add(&s.mul(&Fixed::new(&d[k], *bits))));
            count += p.passes(&at, *bits)?;
        }
        Some(count)
    });
    count.map_or(Crossings::Degenerate, Crossings::Count)
}

/// A point of the plane of algebraic coordinates is not on the open segment: no line through it holds a point of a circle at
/// a rational angle other than 0. It may be an end that is rational. Otherwise some precision and direction tell.
fn segment_crossings(a: &End, b: &End, q: &[Fraction; 2], d: [i64; 2]) -> Crossings {
    let is_end = |e: &End| matches!(e, End::Point(p) if p == q);
    if is_end(a) || is_end(b) {
        return Crossings::On;
    }
    let count = PRECISIONS.iter().find_map(|bits| {
        let q = q.each_ref().map(|x| Fixed::new(x, *bits));
        let offset = |e: &End| {
            let at = e.fixed(*bits);
            let o = [at[0].sub(&q[0]), at[1].sub(&q[1])];
            let h = o[0].times(d[1]).sub(&o[1].times(d[0]));
            let g = o[0].times(d[0]).add(&o[1].times(d[1]));
            (o, h, g)
        };
        let (x, y) = (offset(a), offset(b));
        let (hx, hy) = (x.1.sign(), y.1.sign());
        if hx * hy == 0 {
            return None;
        }
        if hx == hy || (x.2.sign() < 0 && y.2.sign() < 0) {
            return Some(0);
        }
        if x.2.sign() > 0 && y.2.sign() > 0 {
            return Some(1);
        }
        // Which side of the line through the ends the point is on: (a - q) x (b - q), against the direction of
        // travel across the ray, tells whether the crossing is ahead.
        let cross = x.0[0].mul(&y.0[1]).sub(&x.0[1].mul(&y.0[0])).sign();
        // h > 0 is to the right of d; from right to left ahead of q turns counter-clockwise about it.
        (cross != 0).then_some(i64::from(cross == hx))
    });
    count.map_or(Crossings::Degenerate, Crossings::Count)
}

/// The side of a point of a face's parameter space. Makes the region anew: see [`TrimmedRegion`] for many points.
///
/// # Errors
/// As [`TrimmedRegion::new`] and [`TrimmedRegion::side`].
pub fn side(breps: &[&Brep], face: usize, uv: [f64; 2]) -> Result<SideTruth, OracleError> {
    let (brep, local) = locate(breps, face)?;
    TrimmedRegion::new(brep, local)?.side(uv)
}

#[cfg(test)]
mod tests;
