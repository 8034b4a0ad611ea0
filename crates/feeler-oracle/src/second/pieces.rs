//! Trim curves cut into pieces: rational Bezier curves with integer control points, and circular arcs.

use super::fraction::Fraction;
use super::polynomial::binomials;
use super::rational::{integers, rational, rationals};
use super::spline;
use crate::truth::OracleError;
use dashu_int::IBig;
use feeler::brep::{Brep, TrimCurve};
use feeler::nurbs::{Arc, Curve2};

/// `(X / W, Y / W)` over s in [0, 1], the curve's parameter running from `from` to `to`, linearly.
#[derive(Clone, Debug)]
pub(crate) struct RationalPiece {
    /// Homogeneous Bernstein coefficients, by a common positive factor; W > 0.
    pub(crate) bernstein: Vec<[IBig; 3]>,
    pub(crate) from: Fraction,
    pub(crate) to: Fraction,
}

/// `center + radius (cos a x' + sin a y')`, a from `angle[0]` to `angle[1]` as the curve's parameter runs from `from`
/// to `to`, linearly; x' is x normalised, y' is x' turned by +90 degrees, by -90 if `clockwise`.
#[derive(Clone, Debug)]
pub(crate) struct ArcPiece {
    pub(crate) center: [Fraction; 2],
    pub(crate) x: [Fraction; 2],
    pub(crate) clockwise: bool,
    pub(crate) radius: Fraction,
    pub(crate) angle: [Fraction; 2],
    pub(crate) from: Fraction,
    pub(crate) to: Fraction,
}

#[allow(clippy::large_enum_variant, reason = "arcs are few")]
#[derive(Clone, Debug)]
pub(crate) enum UvPiece {
    Rational(RationalPiece),
    Arc(ArcPiece),
}

impl RationalPiece {
    /// Power basis of X, Y, W, by the same factor.
    pub(crate) fn power(&self) -> [Vec<IBig>; 3] {
        let n = self.bernstein.len() - 1;
        let row = binomials(n);
        [0, 1, 2].map(|axis| {
            let mut differences: Vec<IBig> =
                self.bernstein.iter().map(|p| p[axis].clone()).collect();
            let mut out = Vec::with_capacity(n + 1);
            for k in 0..=n {
                out.push(&differences[0] * &row[k]);
                differences = differences.windows(2).map(|w| &w[1] - &w[0]).collect();
            }
            out
        })
    }

    /// The point at s = 0 or s = 1.
    pub(crate) fn end(&self, last: bool) -> [Fraction; 2] {
        let p = &self.bernstein[if last { self.bernstein.len() - 1 } else { 0 }];
        [0, 1].map(|i| Fraction::from(p[i].clone()) / Fraction::from(p[2].clone()))
    }

    /// From homogeneous rational control points.
    pub(crate) fn new(points: &[Vec<Fraction>], from: Fraction, to: Fraction) -> Self {
        let flat: Vec<Fraction> = points.iter().flatten().cloned().collect();
        let bernstein = integers(&flat)
            .chunks_exact(3)
            .map(|c| [c[0].clone(), c[1].clone(), c[2].clone()])
            .collect();
        Self {
            bernstein,
            from,
            to,
        }
    }

    /// The straight segment between two points.
    pub(crate) fn segment(
        a: &[Fraction; 2],
        b: &[Fraction; 2],
        from: Fraction,
        to: Fraction,
    ) -> Self {
        let point = |p: &[Fraction; 2]| vec![p[0].clone(), p[1].clone(), Fraction::ONE];
        Self::new(&[point(a), point(b)], from, to)
    }
}

/// The linear map that takes `from` to `to`.
#[derive(Clone, Debug)]
pub(crate) struct Linear {
    from: [Fraction; 2],
    to: [Fraction; 2],
}

impl Linear {
    pub(crate) fn new(from: [Fraction; 2], to: [Fraction; 2]) -> Self {
        Self { from, to }
    }

    pub(crate) fn at(&self, t: &Fraction) -> Fraction {
        let ([a, b], [c, d]) = (&self.from, &self.to);
        c + (t - a) / (b - a) * (d - c)
    }

    pub(crate) fn slope(&self) -> Fraction {
        let ([a, b], [c, d]) = (&self.from, &self.to);
        (d - c) / (b - a)
    }

    pub(crate) fn inverse(&self) -> Self {
        Self::new(self.to.clone(), self.from.clone())
    }
}

fn max(a: &Fraction, b: &Fraction) -> Fraction {
    if a > b { a.clone() } else { b.clone() }
}

fn min(a: &Fraction, b: &Fraction) -> Fraction {
    if a < b { a.clone() } else { b.clone() }
}

/// The pieces of a trim over its span, in the direction of the curve's parameter.
pub(crate) fn uv_pieces(trim: &TrimCurve, curve: &Curve2) -> Result<Vec<UvPiece>, OracleError> {
    let span = [rational(trim.span.start)?, rational(trim.span.end)?];
    let mut out = Vec::new();
    match curve {
        Curve2::Poly(poly) => {
            let params = rationals(poly.params())?;
            for (segment, w) in poly.segments().iter().zip(params.windows(2)) {
                let own = segment.domain();
                let own = [rational(own.start)?, rational(own.end)?];
                let (from, to) = (max(&span[0], &w[0]), min(&span[1], &w[1]));
                if from >= to {
                    continue;
                }
                let inward = Linear::new([w[0].clone(), w[1].clone()], own);
                simple(
                    segment,
                    &inward.at(&from),
                    &inward.at(&to),
                    &inward.inverse(),
                    &mut out,
                )?;
            }
        }
        other => {
            let same = Linear::new(span.clone(), span.clone());
            simple(other, &span[0], &span[1], &same, &mut out)?;
        }
    }
    Ok(out)
}

/// Of a curve that is no poly-curve, over `[from, to]` of its own parameter.
fn simple(
    curve: &Curve2,
    from: &Fraction,
    to: &Fraction,
    outward: &Linear,
    out: &mut Vec<UvPiece>,
) -> Result<(), OracleError> {
    let mut polyline = |points: &[[f64; 2]], params: &[f64]| -> Result<(), OracleError> {
        let params = rationals(params)?;
        for (p, w) in points.windows(2).zip(params.windows(2)) {
            let (a, b) = (max(from, &w[0]), min(to, &w[1]));
            if a >= b {
                continue;
            }
            let ends = [rationals(&p[0])?, rationals(&p[1])?];
            let at = |t: &Fraction| {
                [0, 1].map(|i| {
                    let range = [ends[0][i].clone(), ends[1][i].clone()];
                    Linear::new([w[0].clone(), w[1].clone()], range).at(t)
                })
            };
            let segment = RationalPiece::segment(&at(&a), &at(&b), outward.at(&a), outward.at(&b));
            out.push(UvPiece::Rational(segment));
        }
        Ok(())
    };
    match curve {
        Curve2::Line(l) => polyline(
            &[l.from.coords.into(), l.to.coords.into()],
            &[l.domain.start, l.domain.end],
        )?,
        Curve2::Polyline(l) => {
            let points: Vec<[f64; 2]> = l.points().iter().map(|p| p.coords.into()).collect();
            polyline(&points, l.params())?;
        }
        Curve2::Nurbs(c) => {
            let knots = rationals(c.knots().knots())?;
            let points = c
                .control_points()
                .iter()
                .map(|p| rationals(p.as_slice()))
                .collect::<Result<Vec<_>, _>>()?;
            for p in spline::pieces(c.degree(), &knots, &points, from, to) {
                out.push(UvPiece::Rational(RationalPiece::new(
                    &p.points,
                    outward.at(&p.from),
                    outward.at(&p.to),
                )));
            }
        }
        Curve2::Arc(arc) => out.push(UvPiece::Arc(arc_piece(arc, from, to, outward)?)),
        Curve2::Poly(_) => {
            return Err(OracleError::Refused("a poly-curve in a poly-curve".into()));
        }
    }
    Ok(())
}

fn arc_piece(
    arc: &Arc<2>,
    from: &Fraction,
    to: &Fraction,
    outward: &Linear,
) -> Result<ArcPiece, OracleError> {
    let pair = |a: f64, b: f64| Ok::<_, OracleError>([rational(a)?, rational(b)?]);
    let domain = pair(arc.domain.start, arc.domain.end)?;
    let angles = Linear::new(domain, pair(arc.angle.start, arc.angle.end)?);
    let x = pair(arc.x[0], arc.x[1])?;
    let y = pair(arc.y[0], arc.y[1])?;
    Ok(ArcPiece {
        center: pair(arc.center.x, arc.center.y)?,
        clockwise: &x[0] * &y[1] < &x[1] * &y[0],
        x,
        radius: rational(arc.radius)?,
        angle: [angles.at(from), angles.at(to)],
        from: outward.at(from),
        to: outward.at(to),
    })
}

/// The BREP of a face, and its number there.
pub(crate) fn locate<'a>(
    breps: &[&'a Brep],
    face: usize,
) -> Result<(&'a Brep, usize), OracleError> {
    let mut local = face;
    let mut count = 0;
    for brep in breps {
        let faces = brep.faces().len();
        if local < faces {
            return Ok((brep, local));
        }
        local -= faces;
        count += faces;
    }
    Err(OracleError::NoFace { face, count })
}
