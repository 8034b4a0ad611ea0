//! Spheres recognised in other surfaces.
//!
//! # What is proven
//! A centre `c` is fitted to samples of the surface; that it is off by a little costs sharpness, not truth. On each patch
//! `|S - c|^2 = N / C`, the quotient that a distance to `c` searches, is a convex combination of the quotients of its coefficients
//! (weights are positive). Their least and their largest over all patches, in double-double with their errors, bound the
//! radius: all of the surface lies between two spheres about `c`, for a sphere written as NURBS some 1e-16 of its radius
//! apart. So no point of it is nearer to `q` than `max(|q - c| - outer, inner - |q - c|)`. Nothing is claimed about which points of the
//! shell are on the surface: an upper bound is always a point of the surface itself.

use super::closed::Target;
use super::{PreparedBrep, Quotient};
use crate::numeric::{Dd, Real};
use nalgebra::{Matrix4, Point3, Vector3, Vector4};

/// Two spheres about one centre with a surface between them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shell {
    center: Point3<f64>,
    inner: f64,
    outer: f64,
}

/// A fit whose samples are farther off than this part of the radius is no sphere.
const FIT: f64 = 1.0 / (1u64 << 36) as f64;
/// A shell thicker than this part of its radius serves no query.
const THICK: f64 = 1.0 / (1u64 << 30) as f64;
/// Spheres of more than this many times the samples' spread are as good as planes: their centre is ill-conditioned.
const FLAT: f64 = 64.0;

impl Shell {
    /// The shell of a face's surface; `None` where it is not seen to be a sphere.
    pub(super) fn new(brep: &PreparedBrep, face: usize) -> Option<Self> {
        let samples: Vec<Point3<f64>> = brep.double(face).seeds().iter().map(|s| s.point).collect();
        let (center, radius) = fit(&samples)?;
        if samples
            .iter()
            .any(|p| ((p - center).norm() - radius).abs() > FIT * radius)
        {
            return None;
        }
        let geometry = brep.double_double(face);
        let (mut low, mut high) = (f64::INFINITY, 0.0f64);
        for (index, patch) in geometry.patches.iter().enumerate() {
            let f = Quotient::squared_distance(&center, &patch.net, geometry.patch_products(index));
            let [a, b] = f.range()?;
            low = low.min(a);
            high = high.max(b);
        }
        if !(low > 0.0 && high.is_finite()) {
            return None;
        }
        // The square root is correctly rounded.
        let (inner, outer) = (low.sqrt().next_down(), high.sqrt().next_up());
        (outer - inner <= THICK * outer).then_some(Self {
            center,
            inner,
            outer,
        })
    }

    /// The radii of the two spheres.
    pub(super) fn radii(&self) -> [f64; 2] {
        [self.inner, self.outer]
    }

    /// A lower bound of the target on the surface.
    ///
    /// Rounding: a distance of differences is off by less than 8 units, heights by 8 units of their parts.
    pub(crate) fn least(&self, target: &Target) -> Dd {
        const SLACK: f64 = 8.0 * f64::EPSILON;
        let (Target::Point(v) | Target::Height(v, _)) = target;
        let x = Vector3::from(*v);
        match target {
            Target::Point(_) => {
                let d = (x - self.center.coords).norm();
                let off = d * SLACK;
                let gap = (d - off - self.outer).max(self.inner - d - off);
                // Two roundings of numbers no larger than these.
                let gap = (gap - f64::EPSILON * (d + self.outer)).max(0.0);
                Dd::product(gap, gap) - Dd::from(4.0 * Dd::UNIT * gap * gap)
            }
            Target::Height(_, h) => {
                let far = self.center.coords.norm() + self.outer;
                let reach = x.norm() * self.outer;
                let size = x.norm() * far + h.abs();
                let off = SLACK * size;
                Dd::from(x.dot(&self.center.coords) - h - reach - off)
            }
        }
    }
}

/// The sphere nearest to some points in the least squares of `|p|^2 - 2 c.p - k`; `None` where they do not tell.
fn fit(points: &[Point3<f64>]) -> Option<(Point3<f64>, f64)> {
    let count = points.len() as f64;
    let sum = points.iter().fold(Vector3::zeros(), |s, p| s + p.coords);
    let mean = sum / count;
    let spread = points
        .iter()
        .fold(0.0f64, |m, p| m.max((p.coords - mean).amax()));
    if !(spread > 0.0 && spread.is_finite()) {
        return None;
    }
    let (mut matrix, mut right) = (Matrix4::zeros(), Vector4::zeros());
    for p in points {
        let x = (p.coords - mean) / spread;
        let row = Vector4::new(x.x, x.y, x.z, 1.0);
        matrix += row * row.transpose();
        right += row * x.norm_squared();
    }
    // Coplanar points leave a centre open: the least singular value is then rounding.
    let svd = matrix.svd(true, true);
    if svd.singular_values.min() < f64::EPSILON.sqrt() * svd.singular_values.max() {
        return None;
    }
    let solved = svd.solve(&right, 0.0).ok()?;
    let center = solved.xyz() * 0.5;
    let radius = (solved.w + center.norm_squared()).sqrt();
    (radius > 0.0 && radius < FLAT).then(|| (Point3::from(mean + center * spread), radius * spread))
}
