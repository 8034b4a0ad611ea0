//! Algorithm 2: Newton's method on a face, from one start.

use super::Target;
use feeler::nurbs::Surface;
use feeler::query::LineProbe;
use nalgebra::{Matrix2, Matrix3, Point2, Point3, Vector2, Vector3};

/// Steps before Newton's method is given up.
const STEPS: usize = 50;
/// A step below this part of the domain ends the search.
const SMALL: f64 = 1e-13;
/// A gradient below this part of what its factors allow is zero.
const FLAT: f64 = 1e-12;
/// A determinant below this part of what its entries allow is zero.
const SINGULAR: f64 = 1e-12;

/// Where to start: the middle of the domain, or of the middles of `starts` equal cells the one of least `cost`.
pub(super) fn start(
    surface: &Surface,
    starts: usize,
    cost: impl Fn(&Point3<f64>) -> f64,
) -> Point2<f64> {
    let [u, v] = surface.domain();
    let n = starts.isqrt().max(1);
    let at = |k: usize| (k as f64 + 0.5) / n as f64;
    let all = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let all = all.map(|(i, j)| Point2::new(u.lerp(at(i)), v.lerp(at(j))));
    let costs = all.map(|uv| (cost(&surface.point(uv.x, uv.y)), uv));
    let best = costs.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or(Point2::new(u.start, v.start), |b| b.1)
}

/// Whether the surface comes back to where it started along u, along v: judged in the middle.
fn closed(surface: &Surface) -> [bool; 2] {
    /// Two points nearer than this part of the way round are one.
    const SAME: f64 = 1e-9;
    let [u, v] = surface.domain();
    let point = |s: f64, r: f64| surface.point(u.lerp(s), v.lerp(r));
    let same =
        |a: Point3<f64>, b: Point3<f64>, c: Point3<f64>| (a - b).norm() <= SAME * (a - c).norm();
    [
        same(point(0.0, 0.5), point(1.0, 0.5), point(0.5, 0.5)),
        same(point(0.5, 0.0), point(0.5, 1.0), point(0.5, 0.5)),
    ]
}

/// Back into the domain in closed directions; `None` where it left in an open one.
fn kept(surface: &Surface, closed: [bool; 2], uv: Point2<f64>) -> Option<Point2<f64>> {
    let mut kept = uv;
    for (k, d) in surface.domain().iter().enumerate() {
        if closed[k] {
            kept[k] = d.start + (uv[k] - d.start).rem_euclid(d.length());
        }
        if !(d.start <= kept[k] && kept[k] <= d.end) {
            return None;
        }
    }
    Some(kept)
}

/// A stationary point of the distance or the height, from one start. `None` where Newton leaves the domain or
/// does not settle.
pub(super) fn foot(surface: &Surface, target: &Target, start: Point2<f64>) -> Option<Point2<f64>> {
    let closed = closed(surface);
    let lengths = surface.domain().map(|d| d.length());
    let mut uv = start;
    for _ in 0..STEPS {
        let d = surface.derivatives(uv.x, uv.y, 2);
        let (du, dv) = (d.get(1, 0), d.get(0, 1));
        let (way, metric) = match target {
            Target::Point(c) => (
                d.get(0, 0) - c.coords,
                Matrix2::new(du.dot(&du), du.dot(&dv), du.dot(&dv), dv.dot(&dv)),
            ),
            Target::Along(n) => (*n, Matrix2::zeros()),
        };
        let gradient = Vector2::new(way.dot(&du), way.dot(&dv));
        let scale = way.norm();
        let flat = |g: f64, of: &Vector3<f64>| g.abs() <= FLAT * scale * of.norm();
        if flat(gradient.x, &du) && flat(gradient.y, &dv) {
            return Some(uv);
        }
        let mixed = way.dot(&d.get(1, 1));
        let hessian =
            metric + Matrix2::new(way.dot(&d.get(2, 0)), mixed, mixed, way.dot(&d.get(0, 2)));
        let step = solve(&hessian, &gradient)?;
        uv = kept(surface, closed, uv - step)?;
        if step.x.abs() <= SMALL * lengths[0] && step.y.abs() <= SMALL * lengths[1] {
            // Settled, but perhaps only in the directions in which the matrix is not singular.
            let settled = |g: f64, of: &Vector3<f64>| g.abs() <= FLAT.sqrt() * scale * of.norm();
            let there = settled(gradient.x, &du) && settled(gradient.y, &dv);
            return there.then_some(uv);
        }
    }
    None
}

/// The solution of `H x = g`, of least length where H is singular; `None` where H is zero.
fn solve(h: &Matrix2<f64>, g: &Vector2<f64>) -> Option<Vector2<f64>> {
    let scale = h.norm_squared();
    if scale == 0.0 || !scale.is_finite() {
        return None;
    }
    if h.determinant().abs() > SINGULAR * scale {
        return Some(h.try_inverse()? * g);
    }
    // A symmetric matrix of rank 1 is its trace times a projection.
    Some(h * g / (h.trace() * h.trace()))
}

/// Where a line meets the surface, from one start: parameters of both.
pub(super) fn hit(
    surface: &Surface,
    line: &LineProbe,
    starts: usize,
) -> Option<(Point2<f64>, f64)> {
    let along =
        |p: &Point3<f64>| (p - line.origin).dot(&line.direction) / line.direction.norm_squared();
    let off = |p: &Point3<f64>| (p - line.origin - line.direction * along(p)).norm();
    let mut uv = start(surface, starts, off);
    let mut t = along(&surface.point(uv.x, uv.y));
    let closed = closed(surface);
    let lengths = surface.domain().map(|d| d.length());
    for _ in 0..STEPS {
        let d = surface.derivatives(uv.x, uv.y, 1);
        let rest = d.get(0, 0) - line.origin.coords - line.direction * t;
        let jacobian = Matrix3::from_columns(&[d.get(1, 0), d.get(0, 1), -line.direction]);
        let step = jacobian.try_inverse()? * rest;
        uv = kept(surface, closed, uv - step.xy())?;
        t -= step.z;
        let small = [step.x / lengths[0], step.y / lengths[1], step.z];
        if small.iter().all(|s| s.abs() <= SMALL * t.abs().max(1.0)) {
            return Some((uv, t));
        }
    }
    None
}
