//! Where the coordinates of a trim curve are stationary, in the curve's own parameter.
//!
//! Rational pieces by their exact derivative numerators (see [`derivative`](super::derivative)). An arc's coordinate
//! `cos a P + sin a R` by the sign of its derivative `R cos a - P sin a` in double-double: its zeros are pi apart, so a step of
//! half a radian over which the sign changes holds exactly one, and halving narrows it to neighbouring f64.

use super::derivative::AxisRoots;
use super::piece::Piece;
use super::source::{Source, simple_runs};
use super::spline::Param;
use crate::brep::TrimCurve;
use crate::numeric::polynomial::{Polynomial, signum};
use crate::numeric::roots::Roots;
use crate::numeric::{Ball, Dd, Dyadic, Enclosure, sin_cos};
use crate::nurbs::{Arc, Curve2};

/// A place where the derivative of one coordinate of a trim curve vanishes or changes sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stationary {
    /// The parameter of the trim's curve, within the bounds.
    pub t: f64,
    /// Proven to hold the parameter, and no other such place of this coordinate unless two are closer than f64 can tell.
    pub bounds: Enclosure,
    /// How often the derivative vanishes, seen from below and from above: they differ only at a joint of
    /// pieces. 0 where it does not, where the coordinate is constant, and beyond the trim's span.
    pub multiplicity: [usize; 2],
    /// The derivative's sign just below and just above; 0 where the coordinate is constant, and beyond
    /// the span.
    pub sign: [i8; 2],
}

impl Stationary {
    /// Whether the coordinate turns here: a monotone arc ends.
    pub fn turns(&self) -> bool {
        self.sign[0] * self.sign[1] < 0
    }
}

/// Where one coordinate of a trim curve is stationary.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxisSplit {
    /// Ascending. A joint of pieces is listed where the derivative vanishes on either side or the sign differs; an end
    /// of the span, where the derivative vanishes there.
    pub places: Vec<Stationary>,
    /// The maximal parts of the span on which the coordinate is constant, by their ends.
    pub constant: Vec<[Enclosure; 2]>,
}

type Parameter = Ball<Dd>;

/// One coordinate on one piece.
#[derive(Debug, Default)]
struct Stretch {
    constant: bool,
    /// Multiplicity and sign inward at the two ends.
    ends: [(usize, i8); 2],
    /// Parameters and multiplicities between them.
    inside: Vec<(Parameter, usize)>,
}

/// Both coordinates of a piece, and its ends.
type Stretches = Vec<([Stretch; 2], [Parameter; 2])>;

/// A linear map between intervals, exact at the ends.
struct Map {
    from: [f64; 2],
    to: [f64; 2],
}

impl Map {
    fn at(&self, x: f64) -> Parameter {
        match x {
            x if x == self.from[0] => Ball::exact(self.to[0]),
            x if x == self.from[1] => Ball::exact(self.to[1]),
            _ => self.ball(Ball::exact(x)),
        }
    }

    fn ball(&self, x: Parameter) -> Parameter {
        if self.from == self.to {
            return x;
        }
        let s = (x - Ball::exact(self.from[0])) / Ball::difference(self.from[1], self.from[0]);
        Ball::exact(self.to[0]) + s * Ball::difference(self.to[1], self.to[0])
    }
}

/// Where u and v of a trim are stationary over its span, whatever its direction. `None` where an arc ends too near an
/// extremum for double-double to tell, or has thousands of turns.
///
/// Bounds are a few ulp wide. Cost: as [`derivative_roots`](super::derivative_roots), and some 60 exact evaluations a root.
pub fn trim_split(trim: &TrimCurve, curve: &Curve2) -> Option<[AxisSplit; 2]> {
    let span = [trim.span.start, trim.span.end];
    let mut all: Stretches = Vec::new();
    match curve {
        Curve2::Poly(poly) => {
            for (segment, w) in poly.segments().iter().zip(poly.params().windows(2)) {
                if w[0] >= span[1] || w[1] <= span[0] {
                    continue;
                }
                let own = segment.domain();
                let map = Map {
                    from: [own.start, own.end],
                    to: [w[0], w[1]],
                };
                simple(segment, &map, span, &mut all)?;
            }
        }
        other => {
            let d = other.domain();
            let map = Map {
                from: [d.start, d.end],
                to: [d.start, d.end],
            };
            simple(other, &map, span, &mut all)?;
        }
    }
    Some([joined(&all, 0, span), joined(&all, 1, span)])
}

/// The pieces of a curve that is no poly-curve; `map` takes its parameter to the outer one, in which `span` is.
fn simple(curve: &Curve2, map: &Map, span: [f64; 2], all: &mut Stretches) -> Option<()> {
    let cut = |t: f64| Param::mapped(t, map.to, map.from);
    // Cut ends are f64 outside, though perhaps not inside.
    let outer = [span[0].max(map.to[0]), span[1].min(map.to[1])];
    if let Curve2::Arc(arc) = curve {
        all.push((arc_stretches(arc, map, outer)?, outer.map(Ball::exact)));
        return Some(());
    }
    for run in simple_runs(curve, &cut(span[0]), &cut(span[1])) {
        let count = run.pieces.len();
        for (i, p) in run.pieces.into_iter().enumerate() {
            let from = if i == 0 {
                Ball::exact(outer[0])
            } else {
                map.at(p.params[0])
            };
            let to = if i + 1 == count {
                Ball::exact(outer[1])
            } else {
                map.at(p.params[1])
            };
            all.push((rational_stretches(p.source, [from, to])?, [from, to]));
        }
    }
    Some(())
}

fn rational_stretches(source: Source, ends: [Parameter; 2]) -> Option<[Stretch; 2]> {
    let piece = Piece::new(source);
    let exact = piece.exact()?;
    let of = |axis: usize| {
        let numerator = exact.derivative(axis);
        let roots = if exact.constant[axis] {
            AxisRoots::Constant
        } else {
            Roots::isolate(&numerator).map_or(AxisRoots::Constant, AxisRoots::At)
        };
        match roots {
            AxisRoots::Constant => Stretch {
                constant: true,
                ..Stretch::default()
            },
            AxisRoots::At(roots) => stretch(&numerator, roots, ends),
        }
    };
    Some([of(0), of(1)])
}

/// Intervals are halved until they are this part of their distance from 0.
const NARROW: u32 = 64;
/// Halvings of one interval: roots below 2^-MOST are known no better.
const MOST: usize = 1100;

fn stretch(numerator: &Polynomial, mut roots: Roots, ends: [Parameter; 2]) -> Stretch {
    let c = numerator.coefficients();
    let signs = [
        c.iter().map(signum).find(|s| *s != 0),
        c.iter().rev().map(signum).find(|s| *s != 0),
    ];
    let mut out = Stretch {
        ends: signs.map(|s| (0, s.unwrap_or(0) as i8)),
        ..Stretch::default()
    };
    let one = Dyadic::new(1.into(), 0);
    for i in 0..roots.as_slice().len() {
        for _ in 0..MOST {
            let r = &roots.as_slice()[i];
            let (lo, hi) = (r.lo.to_dyadic(), r.hi.to_dyadic());
            let part = Dyadic::new(hi.mantissa().clone(), hi.exponent() - i64::from(NARROW));
            if &hi - &lo <= part {
                break;
            }
            roots.refine(i);
        }
        let r = &roots.as_slice()[i];
        let (lo, hi) = (r.lo.to_dyadic(), r.hi.to_dyadic());
        if r.is_exact() && hi == Dyadic::ZERO {
            out.ends[0].0 = r.multiplicity;
        } else if r.is_exact() && lo == one {
            out.ends[1].0 = r.multiplicity;
        } else {
            let at = ends[0] + ball(&lo, &hi) * (ends[1] - ends[0]);
            out.inside.push((at, r.multiplicity));
        }
    }
    out
}

/// A ball that holds `[lo, hi]`, in [0, 1].
fn ball(lo: &Dyadic, hi: &Dyadic) -> Parameter {
    let near = lo.approximate();
    let Some(exact) = Dyadic::from_f64(near) else {
        return Ball::from_dd(Dd::from(0.5), 0.5);
    };
    let rest = (lo - &exact).approximate();
    // The rest is known to a relative 2^-50, as is the width.
    let width = (hi - lo).approximate();
    let rad = (rest.abs() * (8.0 * f64::EPSILON) + width) * (1.0 + 16.0 * f64::EPSILON);
    Ball::from_dd(
        Dd::sum(near, rest),
        rad + f64::MIN_POSITIVE * f64::from(u8::from(width != 0.0 || rest != 0.0)),
    )
}

/// More turns than any drawing has.
const MOST_STEPS: f64 = 8192.0;

fn arc_stretches(arc: &Arc<2>, map: &Map, outer: [f64; 2]) -> Option<[Stretch; 2]> {
    let cross = Dd::product(arc.x[0], arc.y[1]) - Dd::product(arc.x[1], arc.y[0]);
    let turn = if cross.hi >= 0.0 { 1.0 } else { -1.0 };
    let inward = Map {
        from: map.to,
        to: map.from,
    };
    let angles = Map {
        from: [arc.domain.start, arc.domain.end],
        to: [arc.angle.start, arc.angle.end],
    };
    let back = Map {
        from: angles.to,
        to: angles.from,
    };
    // Both maps are exact at the ends of the curve.
    let angle = |t: f64| {
        let own = inward.at(t);
        if own.rad == 0.0 && own.mid.lo == 0.0 {
            angles.at(own.mid.hi)
        } else {
            angles.ball(own)
        }
    };
    let ends = outer.map(angle);
    let outward = |a: Parameter| {
        let own = back.ball(a);
        map.ball(own)
    };
    let u = arc_axis(arc.x[0], -turn * arc.x[1], ends, &outward)?;
    let v = arc_axis(arc.x[1], turn * arc.x[0], ends, &outward)?;
    Some([u, v])
}

/// The stationary angles of `cos a p + sin a r`.
fn arc_axis(
    p: f64,
    r: f64,
    ends: [Parameter; 2],
    outward: &dyn Fn(Parameter) -> Parameter,
) -> Option<Stretch> {
    // Scaled: frames may be of any length.
    let size = p.abs().max(r.abs());
    let (bp, br) = (
        Ball::exact(p) / Ball::exact(size),
        Ball::exact(r) / Ball::exact(size),
    );
    let zero = |a: &Parameter| r == 0.0 && a.rad == 0.0 && a.mid == Dd::ZERO;
    let slope = |a: Parameter| -> Option<i8> {
        let (sin, cos) = sin_cos(a);
        let d = br * cos - bp * sin;
        if d.lower() > 0.0 {
            Some(1)
        } else if d.upper() < 0.0 {
            Some(-1)
        } else {
            None
        }
    };
    let mut out = Stretch::default();
    for i in 0..2 {
        // Beside angle 0 the derivative is -p a.
        out.ends[i] = if zero(&ends[i]) {
            let rising = (p < 0.0) == (i == 0);
            (1, if rising { 1 } else { -1 })
        } else {
            (0, slope(ends[i])?)
        };
    }
    let (start, end) = (ends[0].upper(), ends[1].lower());
    const STEP: f64 = 0.5;
    if end - start > MOST_STEPS * STEP {
        return None;
    }
    let mut sign = out.ends[0].1;
    let mut at = start;
    while at < end {
        let mut next = at + STEP;
        let here = loop {
            if next >= end {
                next = end;
                break Some(out.ends[1].1);
            }
            match slope(Ball::exact(next)) {
                // A zero itself is no end of a step: one a little farther is none.
                None => next += 0.125,
                found => break found,
            }
        }?;
        if here != sign {
            out.inside
                .push((outward(bisect(at, next, sign, &slope)), 1));
            sign = here;
        }
        at = next;
    }
    Some(out)
}

/// The zero between two angles, the sign at the first being `sign`.
fn bisect(
    mut lo: f64,
    mut hi: f64,
    sign: i8,
    slope: &dyn Fn(Parameter) -> Option<i8>,
) -> Parameter {
    loop {
        let mid = 0.5 * lo + 0.5 * hi;
        if mid <= lo || mid >= hi {
            break;
        }
        match slope(Ball::exact(mid)) {
            Some(s) if s == sign => lo = mid,
            Some(_) => hi = mid,
            // As near as double-double can tell; 0 of a frame along an axis is met exactly.
            None => break,
        }
    }
    let half = 0.5 * (hi - lo);
    Ball::from_dd(Dd::sum(lo, half), half * (1.0 + 4.0 * f64::EPSILON))
}

fn enclosure(at: &Parameter, span: [f64; 2]) -> Enclosure {
    Enclosure {
        lo: at.lower().clamp(span[0], span[1]),
        hi: at.upper().clamp(span[0], span[1]),
    }
}

fn joined(all: &Stretches, axis: usize, span: [f64; 2]) -> AxisSplit {
    let mut out = AxisSplit::default();
    let mut place = |at: &Parameter, multiplicity: [usize; 2], sign: [i8; 2]| {
        let bounds = enclosure(at, span);
        out.places.push(Stationary {
            t: at.mid.hi.clamp(bounds.lo, bounds.hi),
            bounds,
            multiplicity,
            sign,
        });
    };
    for i in 0..=all.len() {
        let before = i.checked_sub(1).and_then(|i| all.get(i));
        let after = all.get(i);
        let a = before.map_or((0, 0), |s| s.0[axis].ends[1]);
        let b = after.map_or((0, 0), |s| s.0[axis].ends[0]);
        let at = after.map(|s| s.1[0]).or(before.map(|s| s.1[1]));
        if let Some(at) = at
            && (a.0 > 0 || b.0 > 0 || a.1 * b.1 < 0)
        {
            place(&at, [a.0, b.0], [a.1, b.1]);
        }
        let Some((stretches, _)) = after else {
            continue;
        };
        let mut sign = b.1;
        for (at, m) in &stretches[axis].inside {
            let next = if m % 2 == 1 { -sign } else { sign };
            place(at, [*m, *m], [sign, next]);
            sign = next;
        }
    }
    let mut level = false;
    for (stretches, ends) in all {
        let ends = [enclosure(&ends[0], span), enclosure(&ends[1], span)];
        if stretches[axis].constant {
            match out.constant.last_mut() {
                Some(last) if level => last[1] = ends[1],
                _ => out.constant.push(ends),
            }
        }
        level = stretches[axis].constant;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exact_root_stays_exact() {
        let half = Dyadic::new(1.into(), -1);
        let found = ball(&half, &half);
        assert_eq!((found.mid, found.rad), (Dd::from(0.5), 0.0));
        // 1/2 + 2^-70 is no f64, and with 2^-1070 more no double-double.
        let more = |e: i64| &half + &Dyadic::new(1.into(), e);
        let found = ball(&more(-70), &more(-70));
        assert!(found.rad > 0.0 && found.rad < 2f64.powi(-110), "{found:?}");
        let found = ball(&half, &more(-60));
        assert!(found.upper() >= 0.5 + 2f64.powi(-60) && found.lower() <= 0.5);
    }
}
