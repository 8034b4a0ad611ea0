//! Volume and moments of a closed BREP, from its trimmed faces.
//!
//! # Method
//! By the divergence theorem volume, first and second moments are integrals over the faces; over a face, in its
//! parameters, of `g(S) . (S_u x S_v)`. With P the integral of that along u from the domain's start, Green's theorem makes of each
//! face the integral of P dv along its trims. Both are done by Gauss's rule of eight points: along u in pieces between the
//! surface's knots, along the trims in halves until two halves agree with the whole.
//!
//! No flag of a file is believed: the sign of each trim comes from the side of a point beside it, the outward side of each face
//! from which side of it is in material. Where neither point is told the face's flag decides, and [`MassEstimate::guessed`] counts.
//!
//! # Guarantee
//! None in the sense of an enclosure. [`MassEstimate::error`] is what was seen: the difference to coarser rules. For planes,
//! cylinders and spheres it is near rounding; a trim over a surface whose knots it crosses gets what bisection reaches. Cracks between
//! faces add what they add: of the order of their width over the size.

use feeler::brep::Brep;
use feeler::nurbs::Surface;
use feeler::prepare::PreparedBrep;
use feeler::query::{Workspace, inside, side};
use feeler::trim::Side;
use nalgebra::{Matrix3, Point2, Point3, SVector, Vector3};

/// Volume, the three first and the six second moments: xx, yy, zz, xy, yz, zx.
type Moments = SVector<f64, 10>;

/// Gauss's rule on [0, 1]: half of its points, symmetric, and their weights (Abramowitz and Stegun, table 25.4).
const GAUSS: [[f64; 2]; 4] = [
    [0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.525_532_409_916_329, 0.313_706_645_877_887_29],
    [0.796_666_477_413_626_7, 0.222_381_034_453_374_47],
    [0.960_289_856_497_536_2, 0.101_228_536_290_376_26],
];
/// Pieces of the domain along u, at least: arcs of revolutions turn within one span.
const PIECES: usize = 6;
/// How often a piece of a trim is halved.
const HALVINGS: usize = 7;
/// What two halves may differ from the whole, relative to the moments of a box of the size.
const AGREED: f64 = 1e-12;
/// Where to look beside a trim or a face, relative to the domain and the size.
const BESIDE: [f64; 3] = [
    1.0 / (1u64 << 20) as f64,
    1.0 / (1u64 << 14) as f64,
    1.0 / (1u64 << 8) as f64,
];

/// What a solid of density 1 weighs, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MassEstimate {
    /// Volume, in cubed model units.
    pub volume: f64,
    /// Centre of mass.
    pub center: [f64; 3],
    /// Inertia about the centre of mass, for density 1.
    pub inertia: [[f64; 3]; 3],
    /// The error that was seen, relative: of the volume, and of the moments in units of volume times size (squared).
    pub error: f64,
    /// Faces of which it is not known which side is outside, so that their flag was believed.
    pub guessed: usize,
}

fn gauss(from: f64, to: f64, mut f: impl FnMut(f64, f64)) {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    for [x, w] in GAUSS {
        f(middle - half * x, w * half);
        f(middle + half * x, w * half);
    }
}

struct Face<'a> {
    surface: &'a Surface,
    /// Everything is measured from here: no digits are lost far from the origin.
    origin: Vector3<f64>,
    breaks: Vec<f64>,
}

impl Face<'_> {
    fn density(&self, u: f64, v: f64) -> Moments {
        let d = self.surface.derivatives(u, v, 1);
        let p = d.get(0, 0) - self.origin;
        let n = d.get(1, 0).cross(&d.get(0, 1));
        let [x, y, z] = [p.x, p.y, p.z];
        Moments::from([
            p.dot(&n) / 3.0,
            0.5 * x * x * n.x,
            0.5 * y * y * n.y,
            0.5 * z * z * n.z,
            x * x * x * n.x / 3.0,
            y * y * y * n.y / 3.0,
            z * z * z * n.z / 3.0,
            0.5 * x * x * y * n.x,
            0.5 * y * y * z * n.y,
            0.5 * z * z * x * n.z,
        ])
    }

    /// The integral along u from the domain's start, in so many pieces for each of the breaks'.
    fn along_u(&self, u: f64, v: f64, finer: usize) -> Moments {
        let mut sum = Moments::zeros();
        for pair in self.breaks.windows(2) {
            let (from, to) = (pair[0], pair[1].min(u));
            if !(from < to) {
                break;
            }
            let step = (to - from) / finer as f64;
            for k in 0..finer {
                let start = from + step * k as f64;
                gauss(start, start + step, |u, w| sum += self.density(u, v) * w);
            }
        }
        sum
    }
}

/// The breaks of a surface along u within its domain, and enough of them.
fn breaks(surface: &Surface) -> Vec<f64> {
    let [domain, _] = surface.domain();
    let even = (0..=PIECES).map(|k| domain.lerp(k as f64 / PIECES as f64));
    let mut all: Vec<f64> = even.collect();
    match surface {
        Surface::Nurbs(s) => all.extend(s.knots_u().knots()),
        Surface::Revolution(r) if r.transposed => all.extend(r.profile.breaks()),
        Surface::Sum(s) => all.extend(s.first.breaks()),
        _ => {}
    }
    all.retain(|u| domain.contains(*u));
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// A trim as a curve of a parameter from 0 to 1, in its own direction.
struct Path<'a> {
    at: &'a dyn Fn(f64) -> (Point2<f64>, f64),
    from: f64,
    to: f64,
}

fn over(face: &Face<'_>, path: &Path<'_>, finer: usize) -> Moments {
    let mut sum = Moments::zeros();
    gauss(path.from, path.to, |t, w| {
        let (uv, dv) = (path.at)(t);
        if dv != 0.0 {
            sum += face.along_u(uv.x, uv.y, finer) * (w * dv);
        }
    });
    sum
}

/// Halves a path until it agrees with its halves; adds what is left to `error`.
fn refined(face: &Face<'_>, path: Path<'_>, unit: &Moments, error: &mut Moments) -> Moments {
    let mut total = Moments::zeros();
    let whole = over(face, &path, 1);
    let mut waiting = vec![(path.from, path.to, whole, 0)];
    while let Some((from, to, whole, depth)) = waiting.pop() {
        let middle = 0.5 * (from + to);
        let half = |from, to| {
            let at = path.at;
            over(face, &Path { at, from, to }, 1)
        };
        let (a, b) = (half(from, middle), half(middle, to));
        let off = (a + b - whole).abs();
        if depth == HALVINGS || off.zip_map(unit, |o, u| o / u).max() <= AGREED {
            // The rule along u, checked on one of them.
            let finer = Path {
                at: path.at,
                from,
                to,
            };
            *error += off + (over(face, &finer, 2) - whole).abs();
            total += a + b;
        } else {
            waiting.push((from, middle, a, depth + 1));
            waiting.push((middle, to, b, depth + 1));
        }
    }
    total
}

/// Moments of one face, as its surface's normal points; and the error that was seen.
fn face_moments(
    prepared: &PreparedBrep,
    index: usize,
    unit: &Moments,
    origin: Vector3<f64>,
) -> (Moments, Moments) {
    let brep = prepared.brep();
    let parts = brep.parts();
    let surface = brep.surface(index);
    let face = Face {
        surface,
        origin,
        breaks: breaks(surface),
    };
    let mut error = Moments::zeros();
    let mut sum = Moments::zeros();
    let [u, v] = surface.domain();
    let Some(loops) = &brep.faces()[index].loops else {
        // The whole domain: the eastern side alone counts, since P is 0 on the western.
        let at = |t: f64| (Point2::new(u.end, v.lerp(t)), v.length());
        let path = Path {
            at: &at,
            from: 0.0,
            to: 1.0,
        };
        let sum = refined(&face, path, unit, &mut error);
        return (sum, error);
    };
    for own_loop in loops {
        let mut last: Option<Point2<f64>> = None;
        let mut first = None;
        let trims = &parts.loops[*own_loop].trims;
        let mut loop_sum = Moments::zeros();
        let mut sign = None;
        let join = |from: Point2<f64>, to: Point2<f64>, error: &mut Moments| {
            let at = |t: f64| (from + (to - from) * t, to.y - from.y);
            let path = Path {
                at: &at,
                from: 0.0,
                to: 1.0,
            };
            if from.y == to.y {
                return Moments::zeros();
            }
            refined(&face, path, unit, error)
        };
        for trim in trims.iter().map(|t| &parts.trims[*t]) {
            let curve = &parts.curves2[trim.curve];
            let span = trim.span;
            let turned = if trim.reversed { -1.0 } else { 1.0 };
            let place = |t: f64| {
                let s = if trim.reversed { 1.0 - t } else { t };
                let d = curve.derivatives(span.lerp(s), 1);
                (Point2::from(d[0]), d[1] * (span.length() * turned))
            };
            let at = |t: f64| {
                let (p, d) = place(t);
                let clamped = Point2::new(p.x.clamp(u.start, u.end), p.y.clamp(v.start, v.end));
                (clamped, d.y)
            };
            let mut knots: Vec<f64> = curve
                .breaks()
                .into_iter()
                .map(|k| (k - span.start) / span.length())
                .map(|s| if trim.reversed { 1.0 - s } else { s })
                .filter(|s| *s > 0.0 && *s < 1.0)
                .collect();
            knots.extend([0.0, 1.0]);
            knots.sort_by(f64::total_cmp);
            for pair in knots.windows(2).filter(|p| p[0] < p[1]) {
                let path = Path {
                    at: &at,
                    from: pair[0],
                    to: pair[1],
                };
                loop_sum += refined(&face, path, unit, &mut error);
            }
            sign = sign.or_else(|| {
                [0.37, 0.61].iter().find_map(|t| {
                    let (p, d) = place(*t);
                    left_is_inside(prepared, index, p, d)
                })
            });
            let (start, end) = (place(0.0).0, place(1.0).0);
            if let Some(last) = last.replace(end) {
                loop_sum += join(last, start, &mut error);
            }
            first = first.or(Some(start));
        }
        if let (Some(last), Some(first)) = (last, first) {
            loop_sum += join(last, first, &mut error);
        }
        sum += loop_sum * sign.unwrap_or(1.0);
    }
    (sum, error)
}

/// 1 if the region lies to the left of a trim, -1 if to the right.
fn left_is_inside(
    brep: &PreparedBrep,
    face: usize,
    at: Point2<f64>,
    along: nalgebra::Vector2<f64>,
) -> Option<f64> {
    let [u, v] = brep.brep().surface(face).domain();
    let left = nalgebra::Vector2::new(-along.y, along.x);
    let length = left.norm();
    if !(length > 0.0) {
        return None;
    }
    let unit = left / length;
    BESIDE.iter().find_map(|step| {
        let by = unit * (step * u.length().min(v.length()));
        let side_of = |p| side(brep, face, p).and_then(|s| s.side);
        match (side_of(at + by), side_of(at - by)) {
            (Some(Side::Inside), Some(Side::Outside)) => Some(1.0),
            (Some(Side::Outside), Some(Side::Inside)) => Some(-1.0),
            _ => None,
        }
    })
}

/// 1 if the surface's normal points out of the solid, -1 if into it.
fn outward(prepared: &PreparedBrep, face: usize, workspace: &mut Workspace) -> Option<f64> {
    /// Points along each side of the domain, coarse first.
    const GRIDS: [usize; 3] = [3, 8, 21];
    /// Points inside the region that are tried.
    const TRIED: usize = 6;
    let surface = prepared.brep().surface(face);
    let [u, v] = surface.domain();
    let mut tried = 0;
    for n in GRIDS {
        for k in 0..n * n {
            let at = |i: usize| (i as f64 + 0.5) / n as f64;
            let uv = Point2::new(u.lerp(at(k % n)), v.lerp(at(k / n)));
            if side(prepared, face, uv).and_then(|s| s.side) != Some(Side::Inside) {
                continue;
            }
            let p = surface.first_derivatives_with_bound(uv.x, uv.y);
            let normal = p.du.cross(&p.dv);
            if !(normal.norm() > 0.0) {
                continue;
            }
            let normal = normal.normalize();
            for step in BESIDE {
                let by = normal * (step * prepared.size());
                let mut in_material = |p: Point3<f64>| inside(prepared, p, workspace).side;
                match (in_material(p.point + by), in_material(p.point - by)) {
                    (Some(Side::Outside), Some(Side::Inside)) => return Some(1.0),
                    (Some(Side::Inside), Some(Side::Outside)) => return Some(-1.0),
                    _ => {}
                }
            }
            tried += 1;
            if tried == TRIED {
                return None;
            }
        }
    }
    None
}

fn middle(brep: &Brep) -> Vector3<f64> {
    let vertices = &brep.parts().vertices;
    let sum: Vector3<f64> = vertices.iter().map(|v| v.point.coords).sum();
    sum / vertices.len().max(1) as f64
}

/// See the [module](self); of an open BREP, meaningless.
pub(crate) fn estimate(prepared: &PreparedBrep) -> MassEstimate {
    let size = prepared.size();
    let unit = Moments::from_fn(|k, _| match k {
        0 => size.powi(3),
        1..=3 => size.powi(4),
        _ => size.powi(5),
    });
    let origin = middle(prepared.brep());
    let mut workspace = Workspace::default();
    let (mut sum, mut error, mut guessed) = (Moments::zeros(), Moments::zeros(), 0);
    for face in 0..prepared.brep().faces().len() {
        let (own, off) = face_moments(prepared, face, &unit, origin);
        let sign = outward(prepared, face, &mut workspace).unwrap_or_else(|| {
            guessed += 1;
            if prepared.brep().faces()[face].reversed {
                -1.0
            } else {
                1.0
            }
        });
        sum += own * sign;
        error += off;
    }
    let volume = sum[0];
    let center = Vector3::new(sum[1], sum[2], sum[3]) / volume;
    let second = Matrix3::new(
        sum[4], sum[7], sum[9], sum[7], sum[5], sum[8], sum[9], sum[8], sum[6],
    );
    let second = second - center * center.transpose() * volume;
    let inertia = Matrix3::identity() * second.trace() - second;
    let relative = error.zip_map(&unit, |e, u| e / u).max() * unit[0] / volume.abs();
    MassEstimate {
        volume,
        center: (center + origin).into(),
        inertia: inertia.into(),
        error: relative,
        guessed,
    }
}
