//! Knot insertion, splitting, clamping.

use super::{GeometryError, NurbsCurve, NurbsSurface};
use nalgebra::{SVector, Vector4};

/// Inserts `u`, which lies in the domain, once into `knots`, and a control point into each of the
/// control polygons over them (The NURBS Book, A5.1 with r = 1; Boehm 1980). Convex combinations
/// alone, so each step is off by at most gamma_6 of the magnitudes (see [`eval`](super::eval)).
/// Works for unclamped knots and at both ends of the domain; `u` occurs less than `degree` times.
fn insert<const H: usize>(
    degree: usize,
    knots: &mut Vec<f64>,
    polygons: &mut [Vec<SVector<f64, H>>],
    u: f64,
) {
    let above = knots.partition_point(|k| *k <= u);
    let multiplicity = above - knots.partition_point(|k| *k < u);
    let span = above - 1;
    for points in polygons {
        // From the last, so that each step still finds the old neighbour.
        let last = span - multiplicity;
        points.insert(last, points[last.min(points.len() - 1)]);
        for i in (span + 1 - degree..=last).rev() {
            let (from, to) = (knots[i], knots[i + degree]);
            let (below, above) = (points[i - 1], points[i]);
            // From the nearer end; equal coordinates stay equal.
            points[i] = if u - from <= to - u {
                below + (above - below) * ((u - from) / (to - from))
            } else {
                above + (below - above) * ((to - u) / (to - from))
            };
        }
    }
    knots.insert(above, u);
}

/// How often `u` occurs.
fn multiplicity(knots: &[f64], u: f64) -> usize {
    knots.partition_point(|k| *k <= u) - knots.partition_point(|k| *k < u)
}

/// Restricts polygons to `[from, to]`, within the domain and clamped at both ends.
fn restrict<const H: usize>(
    degree: usize,
    knots: &mut Vec<f64>,
    polygons: &mut [Vec<SVector<f64, H>>],
    [from, to]: [f64; 2],
) {
    for u in [from, to] {
        while multiplicity(knots, u) < degree {
            insert(degree, knots, polygons, u);
        }
    }
    let start = knots.partition_point(|k| *k <= from) - 1;
    let end = knots.partition_point(|k| *k < to);
    for points in polygons {
        points.truncate(end);
        points.drain(..start - degree);
    }
    let mut clamped = vec![from; degree + 1];
    clamped.extend_from_slice(&knots[start + 1..end]);
    clamped.extend(std::iter::repeat_n(to, degree + 1));
    *knots = clamped;
}

fn check_inside(u: f64, domain: crate::numeric::Interval) -> Result<(), GeometryError> {
    if domain.start < u && u < domain.end {
        Ok(())
    } else {
        Err(GeometryError::OutsideDomain {
            parameter: u,
            start: domain.start,
            end: domain.end,
        })
    }
}

impl<const H: usize> NurbsCurve<H> {
    /// The same curve with knot `u` inserted `times` more times, as far as it stays below multiplicity
    /// `degree + 1`: fewer where it is that already. `u` must lie strictly inside the domain.
    /// Each insertion rounds: gamma_6 of the magnitudes.
    pub fn with_knot(&self, u: f64, times: usize) -> Result<Self, GeometryError> {
        check_inside(u, self.domain())?;
        let mut knots = self.knots().knots().to_vec();
        let mut polygons = [self.control_points().to_vec()];
        let room = self.degree() - multiplicity(&knots, u).min(self.degree());
        for _ in 0..times.min(room) {
            insert(self.degree(), &mut knots, &mut polygons, u);
        }
        let [points] = polygons;
        Self::new(self.degree(), points, knots)
    }

    /// The part over `[from, to]`, clamped at both ends, which must lie in the domain.
    pub fn restricted(&self, from: f64, to: f64) -> Result<Self, GeometryError> {
        let domain = self.domain();
        let ordered = domain.start <= from && from < to && to <= domain.end;
        if !ordered {
            return Err(GeometryError::EmptyInterval {
                what: "the part of a curve",
            });
        }
        let mut knots = self.knots().knots().to_vec();
        let mut polygons = [self.control_points().to_vec()];
        restrict(self.degree(), &mut knots, &mut polygons, [from, to]);
        let [points] = polygons;
        Self::new(self.degree(), points, knots)
    }

    /// The parts below and above `u`, which lies strictly inside the domain; both clamped. The
    /// last control point of one is the first of the other, bit for bit.
    pub fn split(&self, u: f64) -> Result<(Self, Self), GeometryError> {
        check_inside(u, self.domain())?;
        let whole = self.with_knot(u, self.degree())?;
        let domain = self.domain();
        Ok((
            whole.restricted(domain.start, u)?,
            whole.restricted(u, domain.end)?,
        ))
    }

    /// The same curve with clamped ends; a periodic or otherwise unclamped curve loses the knots
    /// beyond its domain. Already clamped curves keep their control points bit for bit.
    pub fn to_clamped(&self) -> Result<Self, GeometryError> {
        let domain = self.domain();
        self.restricted(domain.start, domain.end)
    }
}

/// A net as one polygon for each row (along v), or for each column (along u).
fn rows(net: &[Vector4<f64>], count_v: usize) -> Vec<Vec<Vector4<f64>>> {
    net.chunks(count_v).map(<[_]>::to_vec).collect()
}

fn transposed(rows: &[Vec<Vector4<f64>>]) -> Vec<Vec<Vector4<f64>>> {
    let count = rows.first().map_or(0, Vec::len);
    (0..count)
        .map(|j| rows.iter().map(|r| r[j]).collect())
        .collect()
}

impl NurbsSurface {
    /// The part over a rectangle within the domain, clamped on all four sides.
    pub fn restricted(&self, u: [f64; 2], v: [f64; 2]) -> Result<Self, GeometryError> {
        let inside = |d: crate::numeric::Interval, x: [f64; 2]| {
            d.start <= x[0] && x[0] < x[1] && x[1] <= d.end
        };
        let [du, dv] = self.domain();
        if !inside(du, u) || !inside(dv, v) {
            return Err(GeometryError::EmptyInterval {
                what: "the part of a surface",
            });
        }
        let degrees = [self.knots_u().degree(), self.knots_v().degree()];
        let mut knots = [
            self.knots_u().knots().to_vec(),
            self.knots_v().knots().to_vec(),
        ];
        let mut along_v = rows(self.control_net(), self.counts()[1]);
        restrict(degrees[1], &mut knots[1], &mut along_v, v);
        let mut along_u = transposed(&along_v);
        restrict(degrees[0], &mut knots[0], &mut along_u, u);
        let counts = [along_u[0].len(), along_u.len()];
        let net = transposed(&along_u).concat();
        Self::new(degrees, counts, net, knots)
    }

    /// The same surface with clamped sides. Already clamped surfaces keep their control points bit
    /// for bit.
    pub fn to_clamped(&self) -> Result<Self, GeometryError> {
        let [u, v] = self.domain();
        self.restricted([u.start, u.end], [v.start, v.end])
    }
}
