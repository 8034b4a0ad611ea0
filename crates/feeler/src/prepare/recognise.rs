//! Which round surface a surface may be, by fits to samples. Nothing here is proven: `shell` proves what comes of it.
//!
//! The axis of a surface of revolution meets all its normals: with a point's normal as a line `(n, m)`, `m = p x n`, and the axis as
//! `(c, c')`, `n.c' + m.c = 0` (H. Pottmann, T. Randrup, *Rotational and helical surface approximation for reverse engineering*,
//! Computing 60 (1998)). In a frame about it the profile is a point, a line or a circle.

use super::{FaceGeometry, Seed, jet};
use nalgebra::{Matrix3, Point3, SMatrix, SVector, SymmetricEigen, Vector3, Vector4};

/// Rows of a rotation, but for rounding, about an origin: `y = A (x - o)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) origin: Point3<f64>,
    pub(super) rows: [Vector3<f64>; 3],
}

/// A round surface; the third row of its frame is its axis.
#[derive(Clone, Copy, Debug)]
pub(super) enum Round {
    Sphere {
        frame: Frame,
    },
    Cylinder {
        frame: Frame,
    },
    /// The apex is the origin; `z` is above zero on it. The cosine and the sine of half its opening angle.
    Cone {
        frame: Frame,
        cos: f64,
        sin: f64,
    },
    /// The radius of its circle and that around it.
    Torus {
        frame: Frame,
        radius: f64,
        tube: f64,
    },
}

impl Round {
    pub(super) fn frame(&self) -> &Frame {
        match self {
            Self::Sphere { frame }
            | Self::Cylinder { frame }
            | Self::Cone { frame, .. }
            | Self::Torus { frame, .. } => frame,
        }
    }

    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Sphere { .. } => "sphere",
            Self::Cylinder { .. } => "cylinder",
            Self::Cone { .. } => "cone",
            Self::Torus { .. } => "torus",
        }
    }
}

/// A fit whose samples are farther off than this part of their spread is none.
const FIT: f64 = 1.0 / (1u64 << 36) as f64;
/// Radii of more than this many times the samples' spread are as good as infinite: their centres are ill-conditioned.
const FLAT: f64 = 64.0;
/// Directions with less than this part of the most have none: what is left of a cylinder's normals along its axis.
const NOTHING: f64 = 1e-13;

/// More samples would say no more.
const ENOUGH: usize = 40;
/// Pivots below this part of the largest (roots of the normal equations') leave a solution open.
const LEAST_PIVOT: f64 = 1.0 / (1u64 << 13) as f64;

/// A point of the surface and its normal, about the mean of all and over their spread.
struct Sample {
    point: Vector3<f64>,
    normal: Vector3<f64>,
}

/// The round surface that a face's surface is, as far as some of its points show.
pub(super) fn recognise(geometry: &FaceGeometry<f64>) -> Option<Round> {
    let all = geometry.seeds();
    let seeds: Vec<&Seed> = all.iter().step_by(all.len() / ENOUGH + 1).collect();
    let sum = seeds
        .iter()
        .fold(Vector3::zeros(), |s, p| s + p.point.coords);
    let mean = sum / seeds.len() as f64;
    let spread = seeds
        .iter()
        .fold(0.0f64, |m, p| m.max((p.point.coords - mean).amax()));
    if !(spread > 0.0 && spread.is_finite()) {
        return None;
    }
    let mut samples = Vec::with_capacity(seeds.len());
    let mut lent = None;
    for s in &seeds {
        // Of one patch some follow one another.
        let patch = match lent.take() {
            Some((index, patch)) if index == s.patch() => patch,
            _ => geometry.patches.lent(s.patch()),
        };
        let (_, patch) = lent.insert((s.patch(), patch));
        let [u, v] = s.local();
        // Seeds are on patches whose degree fits alone.
        let [h, along_s, along_t, ..] = jet::jet2(&patch.net, u, v);
        let x = |d: &[f64; 4]| Vector3::from_fn(|c, _| d[c] - d[3] * h[c] / h[3]);
        let normal = x(&along_s).cross(&x(&along_t)).try_normalize(0.0);
        samples.push(Sample {
            point: (s.point.coords - mean) / spread,
            // A point without a normal has none to say.
            normal: normal.filter(is_finite).unwrap_or_default(),
        });
    }
    let mut round = sphere(&samples).or_else(|| revolved(&samples))?;
    round.refine(&samples);
    Some(round.placed(&mean, spread))
}

impl Round {
    /// A step of Gauss and Newton's method in all parameters at once, by the pseudo-inverse: an axis from normals is off by more than rounding.
    ///
    /// With `y + t + w x y` for `y` the function of a kind changes by `g.t + (y x g).w`, `g` its gradient, and with its own parameter.
    fn refine(&mut self, samples: &[Sample]) {
        let Frame { origin, rows } = *self.frame();
        let mut matrix = SMatrix::<f64, 8, 8>::zeros();
        let mut right = SVector::<f64, 8>::zeros();
        let local = |s: &Sample| {
            let [x, y, z] = rows.map(|r| r.dot(&(s.point - origin.coords)));
            ((x * x + y * y).sqrt(), [x, y, z])
        };
        let mean = samples.iter().map(|s| local(s).0).sum::<f64>() / samples.len() as f64;
        for s in samples {
            let (rho, [x, y, z]) = local(s);
            let out = Vector3::new(x / rho, y / rho, 0.0);
            // The value it should have not, the gradient, and by how much the two own parameters change the value.
            let (off, g, own) = match self {
                // Its fit is one of least squares already.
                Self::Sphere { .. } => return,
                Self::Cylinder { .. } => (rho - mean, out, [0.0, -1.0]),
                Self::Cone { cos, sin, .. } => {
                    let g = out * *cos - Vector3::z() * *sin;
                    (*cos * rho - *sin * z, g, [-*sin * rho - *cos * z, 0.0])
                }
                Self::Torus { radius, tube, .. } => {
                    let across = out * (rho - *radius) + Vector3::z() * z;
                    let value = across.norm();
                    let g = across / value;
                    (value - *tube, g, [-g.dot(&out), -1.0])
                }
            };
            let turn = Vector3::new(x, y, z).cross(&g);
            let row = [g.x, g.y, g.z, turn.x, turn.y, turn.z, own[0], own[1]];
            let row = SVector::from(row);
            matrix += row * row.transpose();
            right -= row * off;
        }
        if !matrix.iter().chain(&right).all(|x| x.is_finite()) {
            return;
        }
        let eigen = SymmetricEigen::new(matrix);
        let most = eigen.eigenvalues.max();
        let mut step = SVector::<f64, 8>::zeros();
        for (value, vector) in eigen
            .eigenvalues
            .iter()
            .zip(eigen.eigenvectors.column_iter())
        {
            if *value > NOTHING * most {
                step += vector * (vector.dot(&right) / *value);
            }
        }
        match self {
            Self::Sphere { .. } | Self::Cylinder { .. } => {}
            Self::Cone { cos, sin, .. } => {
                // By a small angle.
                let [c, s] = [*cos - step[6] * *sin, *sin + step[6] * *cos];
                let long = (c * c + s * s).sqrt();
                (*cos, *sin) = (c / long, s / long);
            }
            Self::Torus { radius, tube, .. } => {
                *radius += step[6];
                *tube += step[7];
            }
        }
        let moved = rows[0] * step[0] + rows[1] * step[1] + rows[2] * step[2];
        let axis = rows[2] - rows[0] * step[4] + rows[1] * step[3];
        *self.frame_mut() = Frame {
            origin: origin - moved,
            rows: frame(axis.normalize()),
        };
    }

    fn frame_mut(&mut self) -> &mut Frame {
        match self {
            Self::Sphere { frame }
            | Self::Cylinder { frame }
            | Self::Cone { frame, .. }
            | Self::Torus { frame, .. } => frame,
        }
    }

    /// The same for points in their own place and size.
    fn placed(mut self, mean: &Vector3<f64>, spread: f64) -> Self {
        if let Self::Torus { radius, tube, .. } = &mut self {
            *radius *= spread;
            *tube *= spread;
        }
        let frame = self.frame_mut();
        frame.origin = Point3::from(mean + frame.origin.coords * spread);
        self
    }
}

fn is_finite(v: &Vector3<f64>) -> bool {
    v.iter().all(|x| x.is_finite())
}

/// Whether all numbers are as good as zero.
fn fits(mut off: impl Iterator<Item = f64>) -> bool {
    off.all(|x| x.abs() <= FIT)
}

/// The solution of the least squares of `row.x = right`; `None` where the rows leave it open.
///
/// By normal equations, whose loss of digits is made up for by solving for what is left.
fn least_squares<const N: usize>(
    equations: impl Iterator<Item = (SVector<f64, N>, f64)> + Clone,
) -> Option<SVector<f64, N>> {
    let mut matrix = SMatrix::<f64, N, N>::zeros();
    for (row, _) in equations.clone() {
        matrix += row * row.transpose();
    }
    let solver = matrix.cholesky()?;
    let pivots = solver.l_dirty().diagonal();
    if !(pivots.min() > LEAST_PIVOT * pivots.max()) {
        return None;
    }
    let mut x = SVector::<f64, N>::zeros();
    for _ in 0..3 {
        let mut left = SVector::<f64, N>::zeros();
        for (row, right) in equations.clone() {
            left += row * (right - row.dot(&x));
        }
        x += solver.solve(&left);
    }
    x.iter().all(|v| v.is_finite()).then_some(x)
}

/// The sphere nearest to the samples in the least squares of `|p|^2 - 2 c.p - k`.
fn sphere(samples: &[Sample]) -> Option<Round> {
    let equation = |s: &Sample| {
        let p = s.point;
        (Vector4::new(p.x, p.y, p.z, 1.0), p.norm_squared())
    };
    let solved = least_squares(samples.iter().map(equation))?;
    let center = solved.xyz() * 0.5;
    let radius = (solved.w + center.norm_squared()).sqrt();
    let off = |s: &Sample| (s.point - center).norm() - radius;
    (radius > 0.0 && radius < FLAT && fits(samples.iter().map(off))).then(|| Round::Sphere {
        frame: Frame {
            origin: Point3::from(center),
            rows: [Vector3::x(), Vector3::y(), Vector3::z()],
        },
    })
}

/// A surface of revolution with a simple profile.
fn revolved(samples: &[Sample]) -> Option<Round> {
    let (origin, axis) = axis(samples)?;
    let rows = frame(axis);
    let profile: Vec<[f64; 2]> = samples
        .iter()
        .map(|s| {
            let [x, y, z] = rows.map(|r| r.dot(&(s.point - origin)));
            [(x * x + y * y).sqrt(), z]
        })
        .collect();
    let place = |z: f64| Frame {
        origin: Point3::from(origin + axis * z),
        rows,
    };
    let count = profile.len() as f64;
    let mean = |k: usize| profile.iter().map(|p| p[k]).sum::<f64>() / count;
    let [rho, z] = [mean(0), mean(1)];
    if !(rho < FLAT) {
        return None;
    }
    if fits(profile.iter().map(|p| p[0] - rho)) {
        return Some(Round::Cylinder { frame: place(z) });
    }
    // The line through the middle along which the profile varies most, outward.
    let varies = |j: usize, k: usize| {
        let means = [rho, z];
        let products = profile
            .iter()
            .map(|p| (p[j] - means[j]) * (p[k] - means[k]));
        products.sum::<f64>()
    };
    let (outward, along) = (varies(0, 1), varies(1, 1));
    let slope = outward / along;
    let long = (1.0 + slope * slope).sqrt();
    let (cos, sin) = (1.0 / long, slope.abs() / long);
    let line = |p: &[f64; 2]| (p[0] - rho) - slope * (p[1] - z);
    if sin > 0.0 && fits(profile.iter().map(|p| line(p) * cos)) {
        let mut frame = place(z - rho / slope);
        if slope < 0.0 {
            // A half turn about the first row.
            frame.rows = [rows[0], -rows[1], -rows[2]];
        }
        return Some(Round::Cone { frame, cos, sin });
    }
    let circle = least_squares(profile.iter().map(|p| {
        let row = Vector3::new(2.0 * p[0], 2.0 * p[1], 1.0);
        (row, p[0] * p[0] + p[1] * p[1])
    }))?;
    let [radius, height, rest] = circle.into();
    let tube = (rest + radius * radius + height * height).sqrt();
    let off = |p: &[f64; 2]| ((p[0] - radius).powi(2) + (p[1] - height).powi(2)).sqrt() - tube;
    let good = radius > 0.0 && radius < FLAT && tube > 0.0 && tube < FLAT;
    (good && fits(profile.iter().map(off))).then(|| Round::Torus {
        frame: place(height),
        radius,
        tube,
    })
}

/// A point of the axis that all normals meet, and its direction; `None` where that is none.
fn axis(samples: &[Sample]) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let [mut mm, mut mn, mut nn] = [Matrix3::<f64>::zeros(); 3];
    for s in samples {
        let (n, m) = (s.normal, s.point.cross(&s.normal));
        mm += m * m.transpose();
        mn += m * n.transpose();
        nn += n * n.transpose();
    }
    // The best moment for a direction is `-nn^-1 mn^T c`; what is left for it then is a quadratic form.
    let own = SymmetricEigen::new(nn);
    let most = own.eigenvalues.max();
    let mut inverse = Matrix3::<f64>::zeros();
    for (value, vector) in own.eigenvalues.iter().zip(own.eigenvectors.column_iter()) {
        if *value > NOTHING * most {
            inverse += vector * vector.transpose() / *value;
        }
    }
    let form = SymmetricEigen::new(mm - mn * inverse * mn.transpose());
    let direction = form
        .eigenvectors
        .column(form.eigenvalues.imin())
        .into_owned();
    let direction = direction.try_normalize(0.0)?;
    let moment = -(inverse * (mn.transpose() * direction));
    let origin = direction.cross(&moment);
    (origin.norm() < FLAT).then_some((origin, direction))
}

/// Rows of a rotation whose third is this direction.
fn frame(axis: Vector3<f64>) -> [Vector3<f64>; 3] {
    let mut least = Vector3::zeros();
    least[axis.iamin()] = 1.0;
    let x = axis.cross(&least).normalize();
    [x, axis.cross(&x).normalize(), axis]
}
