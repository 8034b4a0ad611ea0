//! Where a line meets a surface in closed form.

use super::form::{V3, along, dot, sub};
use super::plane::PlaneForm;
use super::quadric::Root;
use super::revolution::{Profile, RevolutionForm};
use super::{ClosedSurface, form, torus};
use crate::numeric::{Ball, Dd};
use std::cmp::Ordering;

/// The line `origin + t direction`, and how far from `t = middle` a face can be.
pub(crate) struct ClosedLine {
    pub(crate) origin: V3,
    pub(crate) direction: V3,
    /// Points of the face are at parameters `|t - middle| <= reach`.
    pub(crate) middle: f64,
    pub(crate) reach: f64,
}

/// A point where the line crosses or touches the surface.
#[derive(Clone, Debug)]
pub(crate) struct ClosedHit {
    pub(crate) t: Ball<Dd>,
    pub(crate) point: V3,
    /// Boxes of native parameters, one of which holds it if it is in the domain.
    pub(crate) boxes: form::Boxes,
    pub(crate) uv: [f64; 2],
    pub(crate) touches: bool,
}

/// A centre nearer to the axis than this part of the radius is on it: the sphere's equation is then off by less than
/// anything that a double-double holds.
const ON_AXIS: f64 = 1e-200;
/// Profiles that rise along the axis by less than this part of what they rise across are left to the search.
const LEAST_RISE: f64 = 1.0 / (1u64 << 20) as f64;

impl ClosedSurface {
    /// All meetings with the surface, those beyond its domain included; `None` where the line may lie in it, nearly touches a torus, or where
    /// there is no formula.
    pub(crate) fn hits(&self, line: &ClosedLine) -> Option<Vec<ClosedHit>> {
        match self {
            Self::Plane(p) => plane_hits(p, line),
            Self::Revolution(r) => {
                if r.is_ring() {
                    return torus::hits(r, line);
                }
                let roots = roots(r, line).or_else(|| exact_roots(r, line))?;
                revolution_hits(r, line, &roots)
            }
        }
    }
}

/// Where a line meets a plane, in numbers that are f64: `t` and native parameters.
pub(crate) struct RoughHit {
    pub(crate) t: Ball<f64>,
    pub(crate) uv: [Ball<f64>; 2],
}

impl ClosedSurface {
    /// The meeting with a plane, to most digits of f64; `None` where there are no digits, or another surface.
    pub(crate) fn rough_hit(&self, origin: &[f64; 3], direction: &[f64; 3]) -> Option<RoughHit> {
        let Self::Plane(p) = self else {
            return None;
        };
        let hit = p.rough_hit(origin, direction);
        let known = hit.t.rad.is_finite() && hit.uv.iter().all(|x| x.rad.is_finite());
        known.then_some(hit)
    }

    /// The parameters of a point of a plane in f64; `None` of another surface. A meeting of a line nearly along the plane is known by its point
    /// to more digits than [`rough_hit`](Self::rough_hit) has of them.
    pub(crate) fn rough_parameters(&self, point: &[f64; 3]) -> Option<[f64; 2]> {
        match self {
            Self::Plane(p) => Some(p.rough_parameters(point)),
            Self::Revolution(_) => None,
        }
    }

    /// The parameter of the same to the digits of double-double; `None` where they are few, or of another surface.
    pub(crate) fn plane_parameter(&self, line: &ClosedLine) -> Option<Ball<Dd>> {
        let Self::Plane(p) = self else {
            return None;
        };
        let [offset, rate] = height_and_rate(p, line);
        let t = offset / rate;
        (t.rad <= ENOUGH * line.reach).then_some(t)
    }

    /// Where a hit whose enclosure holds `end` is beside it, exactly; `None` where there is no telling.
    pub(crate) fn order(&self, line: &ClosedLine, hit: &ClosedHit, end: f64) -> Option<Ordering> {
        let Self::Revolution(r) = self else {
            return None;
        };
        let [from, direction] = stored(line);
        let quadric = r.quadric.as_ref()?;
        quadric.order(&from, &direction, end, hit.t, hit.touches)
    }

    /// The native parameters of a hit, if they are those of f64 that are given: then they are exact.
    pub(crate) fn is_exactly_at(&self, line: &ClosedLine, uv: [f64; 2]) -> bool {
        match self {
            Self::Plane(p) => p.meets_at(stored(line), uv).unwrap_or(false),
            Self::Revolution(_) => false,
        }
    }
}

/// Origin and direction, which were made of f64.
pub(super) fn stored(line: &ClosedLine) -> [[f64; 3]; 2] {
    [&line.origin, &line.direction].map(|v| v.map(|x| x.mid.hi))
}

/// Parameters that are less sharp than this, in parts of the reach of a face, have no digits to spare.
const ENOUGH: f64 = 1.0 / (1u64 << 60) as f64;

/// `n.(P - o)` and `n.d`.
fn height_and_rate(p: &PlaneForm, line: &ClosedLine) -> [Ball<Dd>; 2] {
    let rate = dot(&p.normal, &line.direction);
    let offset = dot(&p.normal, &sub(&form::exact(&p.origin), &line.origin));
    [offset, rate]
}

/// `t = n.(P - o) / n.d`.
fn plane_hits(p: &PlaneForm, line: &ClosedLine) -> Option<Vec<ClosedHit>> {
    let origin = form::exact(&p.origin);
    let [offset, rate] = height_and_rate(p, line);
    let t = offset / rate;
    // Nearly parallel.
    if !(t.rad <= ENOUGH * line.reach) {
        // The line stays on one side over all of the face.
        let away = Ball::exact(line.middle) * rate - offset;
        let most = rate.magnitude() * line.reach;
        let clear = away.lower().max(-away.upper());
        return (clear > most * (1.0 + 4.0 * f64::EPSILON)).then(Vec::new);
    }
    let w = along(&sub(&line.origin, &origin), t, &line.direction);
    let uv = p.parameters(&w);
    Some(vec![ClosedHit {
        t,
        point: along(&line.origin, t, &line.direction),
        boxes: form::Boxes::one(uv.map(|x| [x.lower(), x.upper()])),
        uv: uv.map(|x| x.mid.hi),
        touches: false,
    }])
}

/// `A x^2 + 2 B x + C = 0` with `x = t - middle`.
///
/// Sphere: `|w + x d|^2 = R^2`. Segment: with `s` the segment's own parameter at the height of the line's point, linear in `x`: `r^2 =
/// a(s)^2 + b(s)^2` with linear `a`, `b`: exact, skew or not.
fn roots(r: &RevolutionForm, line: &ClosedLine) -> Option<Vec<Root>> {
    let middle = Ball::exact(line.middle);
    let w = along(&sub(&line.origin, &r.fine.origin), middle, &line.direction);
    let d = &line.direction;
    let [a, b, c] = match &r.fine.profile {
        Profile::Arc { center, radius, .. } => {
            if center[0].magnitude().max(center[1].magnitude()) > ON_AXIS * radius {
                return None;
            }
            let w = along(&w, -center[2], &r.fine.axis);
            let square = Ball::exact(*radius).square();
            [dot(d, d), dot(&w, d), dot(&w, &w) - square]
        }
        Profile::Line { ends: [p, q], .. } => {
            let rise: [Ball<Dd>; 3] = std::array::from_fn(|k| q[k] - p[k]);
            if !(rise[2].mid.hi.abs() > LEAST_RISE * rise[0].mid.hi.abs() && rise[2].mid.hi != 0.0)
            {
                return None;
            }
            let (we, wb, wh) = (
                dot(&w, &r.fine.e),
                dot(&w, &r.fine.b),
                dot(&w, &r.fine.axis),
            );
            let (de, db, dh) = (dot(d, &r.fine.e), dot(d, &r.fine.b), dot(d, &r.fine.axis));
            let (s0, s1) = ((wh - p[2]) / rise[2], dh / rise[2]);
            let (a0, b0) = (p[0] + rise[0] * s0, p[1] + rise[1] * s0);
            let (a1, b1) = (rise[0] * s1, rise[1] * s1);
            [
                de.square() + db.square() - a1.square() - b1.square(),
                we * de + wb * db - a0 * a1 - b0 * b1,
                we.square() + wb.square() - a0.square() - b0.square(),
            ]
        }
    };
    // The constant outweighs the rest as far as the face goes.
    let most = (a.magnitude() * line.reach + 2.0 * b.magnitude()) * line.reach;
    if c.lower().max(-c.upper()) > most * (1.0 + 16.0 * f64::EPSILON) {
        return Some(Vec::new());
    }
    let discriminant = b.square() - a * c;
    if discriminant.upper() < 0.0 {
        return Some(Vec::new());
    }
    if !(discriminant.lower() > 0.0) {
        return None;
    }
    let root = discriminant.sqrt();
    let q = if b.mid < Dd::ZERO {
        root - b
    } else {
        -(root + b)
    };
    within_reach([q / a, c / q].map(|x| Root { x, double: false }), line)
}

/// The same for lines that touch the surface, or nearly.
fn exact_roots(r: &RevolutionForm, line: &ClosedLine) -> Option<Vec<Root>> {
    let [from, direction] = stored(line);
    within_reach(
        r.quadric.as_ref()?.roots(&from, &direction, line.middle)?,
        line,
    )
}

/// Those roots that may be on the face; `None` where one of them is not known well enough.
fn within_reach(roots: impl IntoIterator<Item = Root>, line: &ClosedLine) -> Option<Vec<Root>> {
    let mut out = Vec::new();
    for root in roots {
        let x = root.x;
        // Of no use: a leading coefficient that may be zero, or a double root nearly.
        const ENOUGH: f64 = 1.0 / (1u64 << 60) as f64;
        if x.rad <= ENOUGH * line.reach {
            out.push(root);
        } else if !(x.rad.is_finite() && x.lower().max(-x.upper()) > line.reach) {
            return None;
        }
    }
    Some(out)
}

fn revolution_hits(
    r: &RevolutionForm,
    line: &ClosedLine,
    roots: &[Root],
) -> Option<Vec<ClosedHit>> {
    let middle = Ball::exact(line.middle);
    let start = along(&line.origin, middle, &line.direction);
    let w = sub(&start, &r.fine.origin);
    let hit = |root: &Root| {
        let (boxes, uv) = r.locate(&along(&w, root.x, &line.direction))?;
        let t = middle + root.x;
        Some(ClosedHit {
            t,
            point: along(&line.origin, t, &line.direction),
            boxes,
            uv,
            touches: root.double,
        })
    };
    Some(roots.iter().filter_map(hit).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::{Dyadic, Interval};
    use crate::nurbs::Plane;
    use nalgebra::{Point3, Vector3};

    fn random(seed: &mut u64) -> f64 {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        (*seed >> 11) as f64 / (1u64 << 53) as f64
    }

    /// What f64 says of a meeting with a plane holds what double-double says: axes skew and of different lengths, lines nearly along the
    /// plane, origins far away.
    #[test]
    fn rough_hits_hold_fine_ones() {
        let mut seed = 0x853c_49e6_748f_ea9b;
        let mut sharp = 0;
        for k in 0..20_000 {
            let vector = |seed: &mut u64| Vector3::from_fn(|_, _| random(seed) - 0.5);
            let size = 10f64.powi(k % 7 * 4 - 12);
            let far = [0.0, 1.0, 1e9][(k % 3) as usize];
            let x = vector(&mut seed) * [1.0, 1e-3, 1e4][(k % 5 % 3) as usize];
            let y = vector(&mut seed) + x * [0.0, 3.0, 1e3][(k % 11 % 3) as usize];
            let wide = Interval::new(-10.0, 10.0).unwrap();
            let to = if k % 2 == 0 {
                wide
            } else {
                Interval::new(-0.3, 7.0).unwrap()
            };
            let plane = Plane {
                origin: Point3::from(vector(&mut seed) * size * far),
                x: x * size,
                y: y * size,
                domain: [wide; 2],
                extents: [to; 2],
            };
            let Some(form) = PlaneForm::new(&plane) else {
                continue;
            };
            let surface = ClosedSurface::Plane(Box::new(form));
            let at = plane.origin + plane.x * random(&mut seed) + plane.y * random(&mut seed);
            let flat = [0.0, 1e-3, 1e-9][(k % 13 % 3) as usize];
            let d = vector(&mut seed) * (if flat == 0.0 { 1.0 } else { flat })
                + (x + y) * if flat == 0.0 { 0.0 } else { 1.0 };
            let from = at - d * size * 10f64.powf(8.0 * random(&mut seed) - 4.0);
            let Some(rough) = surface.rough_hit(&from.into(), &d.into()) else {
                continue;
            };
            let line = ClosedLine {
                origin: form::exact(from.coords.as_slice()),
                direction: form::exact(d.as_slice()),
                middle: 0.0,
                reach: f64::MAX,
            };
            let fine = &surface.hits(&line).unwrap()[0];
            let off =
                |a: Ball<f64>, b: Ball<Dd>| (Dd::from(a.mid) - b.mid).hi.abs() - b.rad <= a.rad;
            assert!(off(rough.t, fine.t), "{k} {:?} {:?}", rough.t, fine.t);
            let ClosedSurface::Plane(p) = &surface else {
                unreachable!()
            };
            let w = along(
                &sub(&line.origin, &form::exact(&p.origin)),
                fine.t,
                &line.direction,
            );
            for (a, b) in rough.uv.iter().zip(p.parameters(&w)) {
                assert!(off(*a, b), "{k} {a:?} {b:?}");
            }
            sharp += usize::from(rough.uv.iter().all(|x| x.rad < 1e-9));
        }
        assert!(sharp > 5000, "{sharp}");
    }

    /// Parameters below what f64 holds in full are off by what underflows.
    #[test]
    fn rough_hits_hold_what_underflows() {
        let wide = Interval::new(-10.0, 10.0).unwrap();
        let plane = Plane {
            origin: Point3::origin(),
            x: Vector3::x(),
            y: Vector3::y(),
            domain: [wide; 2],
            extents: [wide; 2],
        };
        let form = PlaneForm::new(&plane).unwrap();
        let surface = ClosedSurface::Plane(Box::new(form));
        let mut tiny = 0;
        for k in 0..64 {
            let height = 1.1 * 10f64.powi(-240 - k % 32);
            let d = [0.0, 0.0, -(3.0 + f64::from(k)) * 1e58];
            let hit = surface.rough_hit(&[0.25, 0.5, height], &d).unwrap();
            let [t, rad, z, rate] =
                [hit.t.mid, hit.t.rad, height, -d[2]].map(|x| Dyadic::from_f64(x).unwrap());
            let off = &(&t * &rate) - &z;
            let off = if off.signum() < 0 { -&off } else { off };
            assert!((&off - &(&rad * &rate)).signum() <= 0, "{:?}", hit.t);
            tiny += usize::from(hit.t.mid < f64::MIN_POSITIVE);
        }
        assert!(tiny > 10);
    }
}
