//! Knots and control points: Bezier and B-spline, periodic or not.
//!
//! The format stores distinct knots with multiplicities. Without periodicity they are, written out, the
//! knots of The NURBS Book, clamped or not. A periodic spline of degree p stores one period: N control
//! points, knots `k_0 < .. < k_m`, the last as often as the first. Written out from the first copy of `k_0` on,
//! without the copies of `k_m`, they are `t_0 .. t_(N-1)`, and `t_(j+N) = t_j + k_m - k_0`; `k_0` is
//! the start of the first span, to which control points `0 .. p` belong, so that span `[t_j, t_(j+1))` has
//! the control points `j - q .. j - q + p` modulo N, q being the multiplicity of `k_0` less one.
//! So any run of spans is a spline without periodicity, exactly up to the rounding of shifted knots.

use super::error::TextProblem;
use super::tokens::Tokens;
use crate::error::ReadError;
use crate::sheets::ROUNDING;
use feeler::nurbs::KnotVector;
use nalgebra::SVector;

/// The most periods that one curve may run over.
const MAX_PERIODS: f64 = 8.0;

/// Knots of one direction.
#[derive(Clone, Debug)]
pub(crate) struct Knots {
    pub(crate) degree: usize,
    pub(crate) periodic: bool,
    pub(crate) control_points: usize,
    /// Distinct knots with their multiplicities.
    distinct: Vec<(f64, usize)>,
}

/// Some spans of a spline: which control points, in order, and the knots, written out.
pub(crate) struct Window {
    pub(crate) points: Vec<usize>,
    pub(crate) knots: Vec<f64>,
}

/// A degree, from 1 to what the kernel takes.
pub(super) fn degree(t: &mut Tokens<'_>) -> Result<usize, ReadError> {
    let found = t.integer("a degree")?;
    match usize::try_from(found) {
        Ok(degree) if (1..=KnotVector::MAX_DEGREE).contains(&degree) => Ok(degree),
        _ => {
            let expected = format!("1 to {}", KnotVector::MAX_DEGREE);
            Err(t.unexpected("a degree", found.to_string().as_bytes(), expected))
        }
    }
}

impl Knots {
    /// Those of a Bezier curve, whose parameter runs from 0 to 1.
    pub(crate) fn bezier(degree: usize) -> Self {
        Self {
            degree,
            periodic: false,
            control_points: degree + 1,
            distinct: vec![(0.0, degree + 1), (1.0, degree + 1)],
        }
    }

    /// Reads `count` knots with their multiplicities.
    pub(super) fn read(
        t: &mut Tokens<'_>,
        degree: usize,
        periodic: bool,
        control_points: usize,
        count: usize,
    ) -> Result<Self, ReadError> {
        let mut distinct = Vec::with_capacity(count);
        for _ in 0..count {
            let knot = t.number("a knot")?;
            let found = t.integer("a knot's multiplicity")?;
            let multiplicity = usize::try_from(found).ok();
            let Some(multiplicity) = multiplicity.filter(|m| (1..=degree + 1).contains(m)) else {
                let expected = format!("1 to {}", degree + 1);
                let found = found.to_string();
                return Err(t.unexpected("a knot's multiplicity", found.as_bytes(), expected));
            };
            if distinct.last().is_some_and(|(last, _)| !(*last < knot)) {
                let found = format!("{knot:?}");
                return Err(t.unexpected("a knot", found.as_bytes(), "more than the one before"));
            }
            distinct.push((knot, multiplicity));
        }
        Self::new(degree, periodic, control_points, distinct).map_err(|problem| t.fail(problem))
    }

    /// Distinct knots, increasing, with multiplicities of 1 or more.
    pub(crate) fn new(
        degree: usize,
        periodic: bool,
        control_points: usize,
        distinct: Vec<(f64, usize)>,
    ) -> Result<Self, TextProblem> {
        let sum: usize = distinct.iter().map(|(_, m)| m).sum();
        let bad = match (distinct.first(), distinct.last()) {
            // The control points of one period are as many as its knots.
            (Some(first), Some(last)) if periodic => {
                first.1 != last.1 || first.1 > degree || sum - last.1 != control_points
            }
            _ => sum != control_points + degree + 1,
        };
        if bad || distinct.len() < 2 {
            return Err(TextProblem::Shape {
                what: format!(
                    "{sum} knots do not go with {control_points} control points of degree {degree}"
                ),
            });
        }
        Ok(Self {
            degree,
            periodic,
            control_points,
            distinct,
        })
    }

    /// Distinct knots with their multiplicities.
    pub(super) fn distinct(&self) -> &[(f64, usize)] {
        &self.distinct
    }

    /// From the first knot to the last.
    pub(crate) fn period(&self) -> Option<f64> {
        Some(self.distinct.last()?.0 - self.distinct.first()?.0)
    }

    /// All spans, or where the spline is periodic those that hold `range`; `None` if that is too long.
    pub(crate) fn window(&self, range: Option<[f64; 2]>) -> Option<Window> {
        let written = |knots: &[(f64, usize)]| -> Vec<f64> {
            let mut all = Vec::with_capacity(knots.iter().map(|(_, m)| m).sum());
            for (k, m) in knots {
                all.extend(std::iter::repeat_n(*k, *m));
            }
            all
        };
        if !self.periodic {
            return Some(Window {
                points: (0..self.control_points).collect(),
                knots: written(&self.distinct),
            });
        }
        let (&(start, first), &(end, _)) = (self.distinct.first()?, self.distinct.last()?);
        let period = end - start;
        let t = written(self.distinct.get(..self.distinct.len() - 1)?);
        let n = t.len() as i64;
        let knot = |j: i64| {
            let (turn, k) = (j.div_euclid(n), j.rem_euclid(n));
            // Exact where nothing is shifted, and the end of the first period as it is stored.
            match (turn, t.get(k as usize)) {
                (0, Some(k)) => *k,
                (1, Some(k)) if *k == start => end,
                (_, Some(k)) => k + turn as f64 * period,
                (_, None) => f64::NAN,
            }
        };
        let [lo, hi] = range.unwrap_or([start, end]);
        if !(hi - lo <= MAX_PERIODS * period) {
            return None;
        }
        let turns = ((lo - start) / period).floor();
        if !(turns.abs() <= MAX_PERIODS) {
            return None;
        }
        // The last span that starts at or before `lo`, up to the first that ends at or after `hi`.
        let slack = ROUNDING * lo.abs().max(hi.abs()).max(period);
        let mut a = (turns as i64 - 1) * n;
        while knot(a + 1) <= lo + slack {
            a += 1;
        }
        let mut b = a + 1;
        while knot(b) < hi - slack {
            b += 1;
        }
        let (p, q) = (self.degree as i64, first as i64 - 1);
        let points = (a - q..b - q + p).map(|i| i.rem_euclid(n) as usize);
        Some(Window {
            points: points.collect(),
            knots: (a - p..=b + p).map(knot).collect(),
        })
    }
}

/// Control points, homogeneous: the format has them as points and weights.
pub(super) fn control_points<const H: usize>(
    t: &mut Tokens<'_>,
    count: usize,
    rational: bool,
) -> Result<Vec<SVector<f64, H>>, ReadError> {
    let mut points = Vec::with_capacity(count);
    for _ in 0..count {
        let mut p = SVector::<f64, H>::repeat(1.0);
        for c in 0..H - 1 {
            p[c] = t.number("a control point")?;
        }
        if rational {
            let w = t.number("a weight")?;
            p *= w;
        }
        points.push(p);
    }
    Ok(points)
}
