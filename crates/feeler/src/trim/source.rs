//! What a loop is made of, as stored: the exact data that every decision goes back to.

use super::circle::{ArcSpan, Blur};
use super::spline::{Param, Spline, SplineSpan};
use crate::brep::TrimCurve;
use crate::numeric::{Ball, Dd, Dyadic};
use crate::nurbs::{Curve2, NurbsCurve2, PolyCurve};
use dashu_int::IBig;
use dashu_int::ops::BitTest;
use nalgebra::Vector3;
use std::sync::Arc;

/// Homogeneous `(wu, wv, w)` up to a positive factor common to all control points.
pub(super) type Exact3 = [IBig; 3];
/// The same as balls.
pub(super) type Ball3 = [Ball<Dd>; 3];

/// The exact data of one piece, over its own parameter t in [0, 1].
#[derive(Clone, Debug)]
pub(super) enum Source {
    /// One span of a spline, from parameter `from` to `to` (`from > to` where the trim is reversed).
    Spline(SplineSpan),
    /// A straight segment.
    Segment([[f64; 2]; 2]),
    /// Bezier control points, exactly.
    Exact(Vec<Exact3>),
    /// A piece of a native arc: at most a quarter, from angle to angle.
    Arc(Box<ArcSpan>),
    /// A straight segment whose ends are known in enclosures only.
    Blurred(Box<[Blur; 2]>),
}

/// An end point of a run of a trim.
#[derive(Clone, Debug)]
pub(super) enum End {
    /// Coordinates that are f64.
    Point([f64; 2]),
    /// Homogeneous, f64.
    Weighted([f64; 3]),
    /// Homogeneous, exact.
    Rational(Exact3),
    /// An enclosure only.
    Blurred(Blur),
}

impl End {
    /// From a homogeneous control point.
    pub(super) fn weighted(p: [f64; 3]) -> Self {
        if p[2] == 1.0 {
            Self::Point([p[0], p[1]])
        } else {
            Self::Weighted(p)
        }
    }

    /// Homogeneous integers; `None` where the end is blurred.
    pub(super) fn exact(&self) -> Option<Exact3> {
        match self {
            Self::Point(p) => integers(&[[p[0], p[1], 1.0]])?.into_iter().next(),
            Self::Weighted(p) => integers(&[*p])?.into_iter().next(),
            Self::Rational(p) => Some(p.clone()),
            Self::Blurred(_) => None,
        }
    }

    /// Coordinates in balls.
    pub(super) fn ball(&self) -> [Ball<Dd>; 2] {
        match self {
            Self::Point(p) => p.map(Ball::exact),
            Self::Weighted(p) => quotient(&p.map(Ball::exact)),
            Self::Rational(p) => quotient(&to_balls(std::slice::from_ref(p))[0]),
            Self::Blurred(b) => b.at,
        }
    }

    fn blur(&self) -> Blur {
        if let Self::Blurred(b) = self {
            return *b;
        }
        // A quotient has an error of its own, though it may have come out exactly: at the height of a circle's centre, say.
        let mut at = self.ball();
        if let Some([u, v, w]) = self.exact() {
            for (ball, x) in at.iter_mut().zip([u, v]) {
                if is_quotient(ball.mid, &x, &w) {
                    ball.rad = 0.0;
                }
            }
        }
        Blur::plain(at)
    }

    /// Whether two ends are the same point; `None` where that cannot be known.
    pub(super) fn same(&self, other: &Self) -> Option<bool> {
        if let (Self::Point(a), Self::Point(b)) = (self, other) {
            return Some(a == b);
        }
        let (a, b) = (self.ball(), other.ball());
        let apart = |i: usize| a[i].lower() > b[i].upper() || b[i].lower() > a[i].upper();
        if apart(0) || apart(1) {
            return Some(false);
        }
        let (a, b) = (self.exact()?, other.exact()?);
        Some((0..2).all(|i| &a[i] * &b[2] == &b[i] * &a[2]))
    }
}

fn quotient(p: &Ball3) -> [Ball<Dd>; 2] {
    [p[0] / p[2], p[1] / p[2]]
}

/// Whether `x` is `top / bottom`, exactly; where that cannot be told it is not said.
fn is_quotient(x: Dd, top: &IBig, bottom: &IBig) -> bool {
    let [high, low] = [x.hi, x.lo].map(Dyadic::from_f64);
    let integer = |n: &IBig| Dyadic::new(n.clone(), 0);
    high.zip(low).is_some_and(|(high, low)| {
        let product = &(&high + &low) * &integer(bottom);
        (&product - &integer(top)).signum() == 0
    })
}

/// Integers proportional to finite numbers; `None` if one is not finite.
pub(super) fn integers(points: &[[f64; 3]]) -> Option<Vec<Exact3>> {
    let dyadics: Option<Vec<Dyadic>> = points
        .iter()
        .flatten()
        .map(|x| Dyadic::from_f64(*x))
        .collect();
    let mut integers = dyadics_to_integers(&dyadics?).into_iter();
    Some(
        points
            .iter()
            .map(|_| [0, 1, 2].map(|_| integers.next().unwrap_or(IBig::ZERO)))
            .collect(),
    )
}

/// Integers proportional to dyadics, by a common power of two.
pub(super) fn dyadics_to_integers(dyadics: &[Dyadic]) -> Vec<IBig> {
    let lowest = dyadics
        .iter()
        .filter_map(|d| Some(d.exponent() + d.mantissa().trailing_zeros()? as i64))
        .min()
        .unwrap_or(0);
    dyadics
        .iter()
        .map(|d| {
            let shift = d.exponent() - lowest;
            if shift >= 0 {
                d.mantissa().clone() << shift as usize
            } else {
                d.mantissa().clone() >> (-shift) as usize
            }
        })
        .collect()
}

/// One number at a power of two, as a ball: 106 bits are kept, so the radius is at most 2^-105
/// relative; below the range of f64 the absolute radius covers it.
fn to_ball(x: &IBig, exponent: i64) -> Ball<Dd> {
    const TOP: usize = 53;
    let bits = x.bit_len();
    if bits == 0 {
        return Ball::ZERO;
    }
    let head = |x: &IBig| {
        let cut = x.bit_len().saturating_sub(TOP);
        let sign_free = x.clone() >> cut;
        let head = i64::try_from(sign_free).map_or(f64::NAN, |m| m as f64);
        (head, cut)
    };
    // Truncated towards minus infinity by the shift: the rest is what is missing, exactly.
    let (hi, cut) = head(x);
    let rest = x - (IBig::from(hi as i64) << cut);
    let (lo, low_cut) = if rest == IBig::ZERO {
        (0.0, 0)
    } else {
        head(&rest)
    };
    let inexact = low_cut > 0;
    let scaled = |m: f64, e: i64| scale(m, e);
    let d = Dd::new(
        scaled(hi, cut as i64 + exponent),
        scaled(lo, low_cut as i64 + exponent),
    );
    let small = bits as i64 + exponent < -800;
    // The rest is below 2^53 ulps of the cut: at most 2^-105 of x, doubled for rounding.
    let rad = if inexact {
        d.hi.abs() * 4.0 * f64::EPSILON * f64::EPSILON
    } else {
        0.0
    } + if small { crate::numeric::TINY } else { 0.0 };
    Ball::from_dd(d, rad)
}

/// `m 2^e` in steps that neither overflow nor underflow early.
fn scale(m: f64, mut e: i64) -> f64 {
    let mut m = m;
    while e != 0 && m != 0.0 && m.is_finite() {
        let step = e.clamp(-900, 900);
        m *= f64::from_bits(((1023 + step) as u64) << 52);
        e -= step;
    }
    m
}

/// Balls proportional to integers, the largest near 1.
pub(super) fn to_balls(points: &[Exact3]) -> Vec<Ball3> {
    let bits = points
        .iter()
        .flatten()
        .map(BitTest::bit_len)
        .max()
        .unwrap_or(0);
    points
        .iter()
        .map(|p| [0, 1, 2].map(|i| to_ball(&p[i], -(bits as i64))))
        .collect()
}

impl Source {
    /// Bezier control points in integers; `None` where there are none (arcs).
    pub(super) fn exact(&self) -> Option<Vec<Exact3>> {
        match self {
            Self::Spline(s) => s.exact(),
            Self::Segment([a, b]) => integers(&[[a[0], a[1], 1.0], [b[0], b[1], 1.0]]),
            Self::Exact(points) => Some(points.clone()),
            Self::Arc(_) | Self::Blurred(_) => None,
        }
    }

    /// Bezier control points in balls, up to a common positive factor.
    pub(super) fn balls(&self) -> Vec<Ball3> {
        let affine = |p: [Ball<Dd>; 2]| [p[0], p[1], Ball::ONE];
        match self {
            Self::Spline(s) => s.balls(),
            Self::Segment(ends) => ends.iter().map(|p| affine(p.map(Ball::exact))).collect(),
            Self::Exact(points) => to_balls(points),
            Self::Blurred(ends) => ends.iter().map(|p| affine(p.at)).collect(),
            Self::Arc(arc) => arc.balls(),
        }
    }
}

/// One piece with the parameters of the original curve it covers.
#[derive(Clone, Debug)]
pub(super) struct SourcePiece {
    pub(super) source: Source,
    /// Parameters of the original curve at t = 0 and t = 1.
    pub(super) params: [f64; 2],
}

/// Pieces that meet exactly, in the direction of the trim, and their outer ends.
#[derive(Debug)]
pub(super) struct Run {
    pub(super) pieces: Vec<SourcePiece>,
    pub(super) start: End,
    pub(super) end: End,
}

/// The runs of a trim, in its direction: one, or one a segment for poly-curves, whose segments
/// need not meet.
pub(super) fn trim_runs(trim: &TrimCurve, curve: &Curve2) -> Vec<Run> {
    let span = [trim.span.start, trim.span.end];
    let mut runs = match curve {
        Curve2::Poly(poly) => poly_runs(poly, span),
        other => simple_runs(other, &Param::f64(span[0]), &Param::f64(span[1])),
    };
    if trim.reversed {
        runs.reverse();
        for run in &mut runs {
            reverse(run);
        }
    }
    runs
}

pub(super) fn reverse(run: &mut Run) {
    std::mem::swap(&mut run.start, &mut run.end);
    run.pieces.reverse();
    for piece in &mut run.pieces {
        piece.params.reverse();
        match &mut piece.source {
            Source::Spline(s) => s.reverse(),
            Source::Segment(ends) => ends.reverse(),
            Source::Exact(points) => points.reverse(),
            Source::Blurred(ends) => ends.reverse(),
            Source::Arc(arc) => arc.reverse(),
        }
    }
}

fn poly_runs(poly: &PolyCurve<2, 3>, span: [f64; 2]) -> Vec<Run> {
    let mut runs = Vec::new();
    for (segment, w) in poly.segments().iter().zip(poly.params().windows(2)) {
        if w[0] >= span[1] || w[1] <= span[0] {
            continue;
        }
        let own = segment.domain();
        let (outer, own) = ([w[0], w[1]], [own.start, own.end]);
        let from = Param::mapped(span[0], outer, own);
        let to = Param::mapped(span[1], outer, own);
        let mut part = simple_runs(segment, &from, &to);
        for t in part
            .iter_mut()
            .flat_map(|r| &mut r.pieces)
            .flat_map(|p| &mut p.params)
        {
            let s = (*t - own[0]) / (own[1] - own[0]);
            *t = (w[0] + s * (w[1] - w[0])).clamp(w[0], w[1]);
        }
        runs.extend(part);
    }
    runs
}

/// The runs of a curve that is no poly-curve.
pub(super) fn simple_runs(curve: &Curve2, from: &Param, to: &Param) -> Vec<Run> {
    match curve {
        Curve2::Line(line) => vec![polyline_run(
            &[line.from.coords.into(), line.to.coords.into()],
            &[line.domain.start, line.domain.end],
            from,
            to,
        )],
        Curve2::Polyline(line) => {
            let points: Vec<[f64; 2]> = line.points().iter().map(|p| p.coords.into()).collect();
            vec![polyline_run(&points, line.params(), from, to)]
        }
        Curve2::Nurbs(nurbs) => nurbs_run(nurbs, from, to).into_iter().collect(),
        Curve2::Arc(arc) => super::circle::arc_run(arc, from, to).into_iter().collect(),
        // Poly-curves hold none.
        Curve2::Poly(_) => Vec::new(),
    }
}

/// The point of segment `a b` over `[w0, w1]` at `x`.
fn point_on(points: [[f64; 2]; 2], w: [f64; 2], x: &Param) -> End {
    if x.is(w[0]) {
        return End::Point(points[0]);
    }
    if x.is(w[1]) {
        return End::Point(points[1]);
    }
    // A line is a spline of degree 1.
    let line = Arc::new(Spline {
        degree: 1,
        knots: [w[0], w[0], w[1], w[1]].into(),
        points: points.map(|p| Vector3::new(p[0], p[1], 1.0)).into(),
    });
    match SplineSpan::new(&line, 1, [x.clone(), Param::f64(w[1])]).exact() {
        Some(mut exact) => End::Rational(exact.swap_remove(0)),
        None => End::Point(points[0]),
    }
}

fn polyline_run(points: &[[f64; 2]], params: &[f64], from: &Param, to: &Param) -> Run {
    use std::cmp::Ordering::{Greater, Less};
    let mut pieces = Vec::new();
    let mut outer: [Option<End>; 2] = [None, None];
    for (p, w) in points.windows(2).zip(params.windows(2)) {
        // Half-open on both sides: a segment that only touches the used span is left out.
        if from.compare(w[1]) != Less || to.compare(w[0]) != Greater {
            continue;
        }
        let (p, w) = ([p[0], p[1]], [w[0], w[1]]);
        let a = if from.compare(w[0]) == Greater {
            from.clone()
        } else {
            Param::f64(w[0])
        };
        let b = if to.compare(w[1]) == Less {
            to.clone()
        } else {
            Param::f64(w[1])
        };
        let ends = [point_on(p, w, &a), point_on(p, w, &b)];
        pieces.push(SourcePiece {
            source: segment(&ends[0], &ends[1]),
            params: [a.near, b.near],
        });
        let [start, end] = ends;
        outer[0].get_or_insert(start);
        outer[1] = Some(end);
    }
    let [start, end] = outer;
    Run {
        pieces,
        start: start.unwrap_or(End::Point(points[0])),
        end: end.unwrap_or(End::Point(points[0])),
    }
}

/// The straight segment between two ends.
pub(super) fn segment(a: &End, b: &End) -> Source {
    if let (End::Point(a), End::Point(b)) = (a, b) {
        return Source::Segment([*a, *b]);
    }
    match (a.exact(), b.exact()) {
        (Some(a), Some(b)) => Source::Exact(balanced(a, b)),
        _ => Source::Blurred(Box::new([a.blur(), b.blur()])),
    }
}

/// Two points, each proportional to what it was, whose weights are about as large: bounds of errors are common to both.
fn balanced(a: Exact3, b: Exact3) -> Vec<Exact3> {
    let [m, n] = [&a, &b].map(|p| p[2].bit_len());
    let raised = |p: Exact3, by: usize| p.map(|x| x << by);
    vec![
        raised(a, n.saturating_sub(m)),
        raised(b, m.saturating_sub(n)),
    ]
}

/// The spans of a NURBS curve between two parameters; `None` if there are none.
fn nurbs_run(curve: &NurbsCurve2, from: &Param, to: &Param) -> Option<Run> {
    use std::cmp::Ordering::{Greater, Less};
    let all = Arc::new(Spline {
        degree: curve.degree(),
        knots: curve.knots().shared(),
        points: curve.shared_points(),
    });
    let mut pieces = Vec::new();
    for (i, lo, hi) in curve.knots().spans() {
        if from.compare(hi) != Less || to.compare(lo) != Greater {
            continue;
        }
        let a = if from.compare(lo) == Greater {
            from.clone()
        } else {
            Param::f64(lo)
        };
        let b = if to.compare(hi) == Less {
            to.clone()
        } else {
            Param::f64(hi)
        };
        pieces.push(SourcePiece {
            params: [a.near, b.near],
            source: Source::Spline(SplineSpan::new(&all, i, [a, b])),
        });
    }
    let end_of = |piece: &SourcePiece, last: bool| match &piece.source {
        Source::Spline(s) => s.end(last),
        _ => None,
    };
    let start = end_of(pieces.first()?, false)?;
    let end = end_of(pieces.last()?, true)?;
    Some(Run { pieces, start, end })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `x 2^e` is in its ball, which has 105 bits of it, or the allowance for what underflows.
    #[test]
    fn integers_as_balls() {
        let odd = |bits: usize| (IBig::ONE << (bits - 1)) + (IBig::ONE << (bits / 3)) + IBig::ONE;
        for bits in [1, 2, 52, 53, 54, 105, 106, 107, 160, 400, 3000] {
            for e in [-3100, -1100, -900, -801, -100, 0, 7] {
                for x in [odd(bits), -odd(bits)] {
                    if bits as i64 + e > 1000 {
                        continue;
                    }
                    let ball = to_ball(&x, e);
                    let exact = |x: f64| Dyadic::from_f64(x).unwrap();
                    let mid = &exact(ball.mid.hi) + &exact(ball.mid.lo);
                    let truth = Dyadic::new(x, e);
                    let (off, limit) = (&mid - &truth, exact(ball.rad));
                    assert!(&off * &off <= &limit * &limit, "{bits} {e}: {ball:?}");
                    let most = ball.mid.hi.abs() * 2f64.powi(-102) + 2.0 * crate::numeric::TINY;
                    assert!(ball.rad <= most, "{bits} {e}: {ball:?}");
                }
            }
        }
        assert_eq!(to_ball(&IBig::ZERO, 5).rad, 0.0);
        let three = to_ball(&IBig::from(-3), 1);
        assert_eq!((three.mid, three.rad), (Dd::from(-6.0), 0.0));
    }

    /// Ends in enclosures that are apart in a coordinate, whichever way, are two; those whose enclosures meet may be one.
    #[test]
    fn ends_in_enclosures() {
        let end = |u: f64, v: f64| {
            End::Blurred(Blur::plain(
                [u, v].map(|x| Ball::from_dd(Dd::from(x), 0.25)),
            ))
        };
        let middle = end(0.0, 0.0);
        for (u, v) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            assert_eq!(middle.same(&end(u, v)), Some(false), "{u} {v}");
        }
        assert_eq!(middle.same(&end(0.125, 0.0)), None);
        assert_eq!(middle.same(&End::Point([1.0, 0.0])), Some(false));
    }
}
