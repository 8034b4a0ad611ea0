//! Bezier pieces.

use super::{KnotVector, NurbsCurve, NurbsSurface};
use crate::numeric::Interval;
use nalgebra::{SVector, Vector4};

/// A rational Bezier curve over an interval.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierPiece<const H: usize> {
    /// Where the parameter of the curve it was cut from runs.
    pub domain: Interval,
    /// Homogeneous control points, `degree + 1` of them.
    pub control_points: Vec<SVector<f64, H>>,
}

/// A rational Bezier patch over a rectangle.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierPatch {
    /// Where the parameters of the surface it was cut from run.
    pub domain: [Interval; 2],
    /// Degrees along u and along v.
    pub degrees: [usize; 2],
    /// Homogeneous control points, `(i, j)` at `i * (degrees[1] + 1) + j`.
    pub control_net: Vec<Vector4<f64>>,
}

/// The value of the blossom of span `span`'s polynomial at `args` (as many as the degree), all within
/// the span (Ramshaw; The NURBS Book, section 5.2 for the use made of it here). Convex combinations
/// alone.
fn blossom<const H: usize>(
    knots: &KnotVector,
    span: usize,
    points: &[SVector<f64, H>],
    args: impl Iterator<Item = f64>,
) -> SVector<f64, H> {
    let p = knots.degree();
    let k = knots.knots();
    let mut local = points[span - p..=span].to_vec();
    for (level, t) in (1..=p).rev().zip(args) {
        for i in 0..level {
            let m = span + 1 - level + i;
            let (from, to) = (k[m], k[m + level]);
            let (a, b) = (local[i], local[i + 1]);
            local[i] = if t - from <= to - t {
                a + (b - a) * ((t - from) / (to - from))
            } else {
                b + (a - b) * ((to - t) / (to - from))
            };
        }
    }
    local[0]
}

/// The control points of all Bezier pieces in a row: `degree` for each span and one more; neighbours
/// share a point.
fn bezier_polygon<const H: usize>(
    knots: &KnotVector,
    points: &[SVector<f64, H>],
) -> Vec<SVector<f64, H>> {
    let p = knots.degree();
    let mut out = Vec::new();
    for (span, a, b) in knots.spans() {
        // Point j is the blossom at p - j times a and j times b. The first of a
        // piece is the last of the one before.
        let first = usize::from(!out.is_empty());
        for j in first..=p {
            let args = (0..p).map(|i| if i < p - j { a } else { b });
            out.push(blossom(knots, span, points, args));
        }
    }
    out
}

impl<const H: usize> NurbsCurve<H> {
    /// The curve as Bezier pieces, one for each span that is not empty, in order; pieces that follow
    /// one another share a control point bit for bit.
    ///
    /// Each homogeneous coordinate is off by at most gamma_{6p} of the magnitudes (see
    /// [`eval`](super::eval)); a curve that is a single clamped span keeps its points.
    /// Cost: O(p^3) for each span.
    pub fn bezier_pieces(&self) -> Vec<BezierPiece<H>> {
        self.each_bezier_piece().collect()
    }

    /// The [pieces](Self::bezier_pieces) one at a time: all take a multiple of the curve's memory, the degree times or so.
    pub fn each_bezier_piece(&self) -> impl Iterator<Item = BezierPiece<H>> + '_ {
        let p = self.degree();
        let mut shared = None;
        self.knots().spans().map(move |(span, start, end)| {
            // Point j is the blossom at p - j times the start and j times the end. The first of a piece is the last of the one before.
            let mut control_points = Vec::with_capacity(p + 1);
            control_points.extend(shared);
            for j in control_points.len()..=p {
                let args = (0..p).map(|i| if i < p - j { start } else { end });
                control_points.push(blossom(self.knots(), span, self.control_points(), args));
            }
            shared = control_points.last().copied();
            BezierPiece {
                domain: Interval { start, end },
                control_points,
            }
        })
    }
}

impl NurbsSurface {
    /// The surface as Bezier patches, one for each pair of spans that are not empty, the spans of v
    /// running fastest; neighbours share a row of control points bit for bit.
    ///
    /// Each homogeneous coordinate is off by at most gamma_{6(p+q)} of the magnitudes (see
    /// [`eval`](super::eval)).
    pub fn bezier_pieces(&self) -> Vec<BezierPatch> {
        let [p, q] = [self.knots_u().degree(), self.knots_v().degree()];
        let [_, count_v] = self.counts();
        let rows: Vec<Vec<Vector4<f64>>> = self
            .control_net()
            .chunks(count_v)
            .map(|row| bezier_polygon(self.knots_v(), row))
            .collect();
        let width = rows.first().map_or(0, Vec::len);
        let columns: Vec<Vec<Vector4<f64>>> = (0..width)
            .map(|j| {
                let column: Vec<_> = rows.iter().map(|r| r[j]).collect();
                bezier_polygon(self.knots_u(), &column)
            })
            .collect();
        let mut out = Vec::new();
        for (i, (_, u0, u1)) in self.knots_u().spans().enumerate() {
            for (j, (_, v0, v1)) in self.knots_v().spans().enumerate() {
                let mut control_net = Vec::with_capacity((p + 1) * (q + 1));
                for a in i * p..=(i + 1) * p {
                    for column in &columns[j * q..=(j + 1) * q] {
                        control_net.push(column[a]);
                    }
                }
                out.push(BezierPatch {
                    domain: [
                        Interval { start: u0, end: u1 },
                        Interval { start: v0, end: v1 },
                    ],
                    degrees: [p, q],
                    control_net,
                });
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boehm's insertion by hand: a knot t between the domain's ends 0 and 4 makes the joint ((4 - t) p1 + t p2) / 4 of a quadratic with that one
    /// inner knot, whichever end t is nearer to.
    #[test]
    fn the_joint_divides_its_leg_as_the_knot_divides_the_domain() {
        let points = [
            [0.0, 0.0, 1.0],
            [4.0, 0.0, 1.0],
            [4.0, 8.0, 2.0],
            [0.0, 8.0, 1.0],
        ];
        for t in [0.5, 1.0, 2.0, 3.0, 3.5] {
            let knots = vec![0.0, 0.0, 0.0, t, 4.0, 4.0, 4.0];
            let points: Vec<SVector<f64, 3>> = points.map(SVector::from).to_vec();
            let c = NurbsCurve::new(2, points.clone(), knots).unwrap();
            let joint = (points[1] * (4.0 - t) + points[2] * t) / 4.0;
            let pieces = c.bezier_pieces();
            assert_eq!(
                pieces[0].control_points,
                [points[0], points[1], joint],
                "{t}"
            );
            assert_eq!(
                pieces[1].control_points,
                [joint, points[2], points[3]],
                "{t}"
            );
        }
    }
}
