//! Hits of a line with a revolution that are exactly on its seam or at an end of its profile, and lines that lie in it.
//!
//! # What is exact
//! Let `f(t)` be the dyadic polynomial of degree two of the module `quadric`, whose roots are where the line `o + t d` meets the surface of
//! the second order. A plane `n.x = c` with dyadic `n`, `c` meets the line where the linear `l(t) = n.o - c + t n.d` is zero: everywhere if both
//! numbers are, else at one quotient `t_0`. A hit, a root of `f` in an enclosure, is on the plane if and only if `l` is zero everywhere,
//! or it is `t_0`: so if `f(t_0) = 0` and the other root is not in the enclosure. (Where both are in it nothing is told.)
//!
//! - The points of the surface of the profile's parameter `v` are at one height: that of the profile's point `P(v)` along the axis `a`, a quotient where the
//!   profile is a segment (whose height changes with `v`: so points of that height have that parameter), and the centre's where an arc's angle is
//!   zero if its direction `x` is orthogonal to the axis (its height there changes fastest, and is the same only half a turn from there, beyond the axis).
//! - Where the profile's plane holds the axis, exactly, points at angle zero are in it, on the profile's side of the axis.
//! - Where `f` is zero everywhere the line lies in the surface. If this is a cylinder or a cone (the profile's plane holds the axis), it is a copy of the profile, turned: the angle
//!   is that of any of its points, and `v` is linear in `t`.

use super::super::exact::{D3, Ratio, When, cross, dot, dyadic, scale, sub, vector};
use super::line::{ClosedHit, ClosedLine, stored};
use super::place::Places;
use super::revolution::RevolutionForm;
use super::{ClosedSurface, form};
use crate::numeric::{Ball, Dd, Dyadic};
use crate::nurbs::{Curve3, Revolution, Surface};

/// What is known exactly of a hit.
#[derive(Debug, Default)]
pub(crate) struct Exactly {
    /// Its native parameters, where they are these numbers.
    pub(crate) at: [Option<f64>; 2],
    /// Its parameter on the line.
    pub(crate) t: Option<When>,
}

/// A line in a cylinder or a cone.
pub(crate) struct Ruling {
    /// Which of the native parameters runs along it.
    pub(crate) along: usize,
    /// Copies of the other one.
    pub(crate) places: Places,
    /// It, where it is this number.
    pub(crate) at: Option<f64>,
    /// `top_0 / bottom` and how it changes.
    height: [Dyadic; 2],
    profile: Rise,
}

/// Heights along the axis, relative to a point of it, of the profile's ends: at these native parameters.
struct Rise {
    ends: [Dyadic; 2],
    at: [f64; 2],
}

impl Rise {
    /// The height at a native parameter, times what is above zero.
    fn at(&self, v: f64) -> Option<[Dyadic; 2]> {
        let [start, end] = [dyadic(self.at[0])?, dyadic(self.at[1])?];
        let (wide, part) = (&end - &start, &dyadic(v)? - &start);
        let rise = &(&self.ends[1] - &self.ends[0]) * &part;
        Some([&(&self.ends[0] * &wide) + &rise, wide])
    }
}

/// A linear function on the line: its value at zero and its rate.
type Linear = [Dyadic; 2];

/// Where a linear function on the line is zero, if it is at a hit.
enum Zero {
    No,
    Everywhere,
    At(Ratio),
}

impl RevolutionForm {
    /// Whether a linear function is zero at a hit; `None` where that is not known.
    fn zero_at(&self, line: &ClosedLine, hit: &ClosedHit, [value, rate]: &Linear) -> Option<Zero> {
        if rate.signum() == 0 {
            let everywhere = value.signum() == 0;
            return Some(if everywhere {
                Zero::Everywhere
            } else {
                Zero::No
            });
        }
        let t = Ratio::new(-value, rate.clone());
        let off = hit.t - t.enclosed();
        if off.is_above(0.0) || (-off).is_above(0.0) {
            return Some(Zero::No);
        }
        let [from, direction] = stored(line);
        let is_root = { self.quadric.as_ref()? }.is_root([&from, &direction], hit.t, &t)?;
        Some(if is_root { Zero::At(t) } else { Zero::No })
    }

    /// The native parameter at angle zero, and the normal and a point of the plane of the profile, if the axis is in it.
    fn seam(&self, s: &Revolution) -> Option<(f64, D3, D3)> {
        let at = if s.angle.start == 0.0 {
            s.angle_domain.start
        } else if s.angle.end == 0.0 {
            s.angle_domain.end
        } else {
            return None;
        };
        let (origin, axis) = (
            vector(s.origin.coords.as_slice())?,
            vector(s.axis.as_slice())?,
        );
        let normal = match &s.profile {
            Curve3::Line(l) => {
                let [p, q] = [&l.from, &l.to].map(|p| vector(p.coords.as_slice()));
                let (p, q) = (sub(&p?, &origin), sub(&q?, &origin));
                let mut normal = cross(&axis, &p);
                if is_zero(&normal) {
                    normal = cross(&axis, &q);
                }
                (dot(&normal, &p).signum() == 0 && dot(&normal, &q).signum() == 0)
                    .then_some(normal)?
            }
            // Its centre is on the axis, or there is no quadric.
            Curve3::Arc(a) => {
                let normal = vector(a.z.as_slice())?;
                (dot(&normal, &axis).signum() == 0).then_some(normal)?
            }
            _ => return None,
        };
        (!is_zero(&normal)).then_some((at, normal, origin))
    }

    /// The profile's height, if it is a segment.
    fn rise(&self, s: &Revolution) -> Option<Rise> {
        let Curve3::Line(l) = &s.profile else {
            return None;
        };
        let (origin, axis) = (
            vector(s.origin.coords.as_slice())?,
            vector(s.axis.as_slice())?,
        );
        let height = |p: &[f64]| Some(dot(&sub(&vector(p)?, &origin), &axis));
        let ends = [
            height(l.from.coords.as_slice())?,
            height(l.to.coords.as_slice())?,
        ];
        (ends[0] != ends[1]).then_some(Rise {
            ends,
            at: [l.domain.start, l.domain.end],
        })
    }

    /// Whether a point is on the profile's side of the axis, surely.
    fn is_on_side(&self, point: &V) -> bool {
        let w = form::sub(point, &self.fine.origin);
        form::dot(&w, &self.fine.e).is_above(0.0)
    }
}

type V = form::V3;

fn is_zero(v: &D3) -> bool {
    v.iter().all(|x| x.signum() == 0)
}

/// `n.(o + t d - p)`.
fn linear(n: &D3, p: &D3, line: &ClosedLine) -> Option<Linear> {
    let [o, d] = stored(line);
    Some([dot(n, &sub(&vector(&o)?, p)), dot(n, &vector(&d)?)])
}

impl ClosedSurface {
    /// What is known exactly of a hit of a line with a revolution of the second order; `isos` are parameters of the profile that it may have.
    pub(crate) fn exactly(
        &self,
        surface: &Surface,
        line: &ClosedLine,
        hit: &ClosedHit,
        isos: &[f64],
    ) -> Option<Exactly> {
        let (Self::Revolution(r), Surface::Revolution(s)) = (self, surface) else {
            return None;
        };
        r.quadric.as_ref()?;
        let mut out = Exactly::default();
        let (angular, along) = if r.transposed() { (1, 0) } else { (0, 1) };
        let mut found = |zero: Zero| match zero {
            Zero::No => false,
            Zero::Everywhere => true,
            Zero::At(t) => {
                out.t.get_or_insert(When::Exact(t));
                true
            }
        };
        let mut at = [None; 2];
        if let Some((u, normal, origin)) = r.seam(s)
            && r.is_on_side(&hit.point)
            && found(r.zero_at(line, hit, &linear(&normal, &origin, line)?)?)
        {
            at[angular] = Some(u);
        }
        let (origin, axis) = (
            vector(s.origin.coords.as_slice())?,
            vector(s.axis.as_slice())?,
        );
        let [value, rate] = linear(&axis, &origin, line)?;
        if let Some(rise) = r.rise(s) {
            for v in isos {
                let [top, bottom] = rise.at(*v)?;
                let off = [&(&value * &bottom) - &top, &rate * &bottom];
                if found(r.zero_at(line, hit, &off)?) {
                    at[along] = Some(*v);
                }
            }
        }
        if let Curve3::Arc(a) = &s.profile {
            let (x, z) = (vector(a.x.as_slice())?, vector(a.z.as_slice())?);
            let level = dot(&x, &axis).signum() == 0 && dot(&z, &axis).signum() == 0;
            let v = if a.angle == a.domain {
                Some(0.0)
            } else if a.angle.start == 0.0 {
                Some(a.domain.start)
            } else if a.angle.end == 0.0 {
                Some(a.domain.end)
            } else {
                None
            };
            if let Some(v) = v
                && level
                && isos.contains(&v)
            {
                let center = vector(a.center.coords.as_slice())?;
                if found(r.zero_at(line, hit, &linear(&axis, &center, line)?)?) {
                    at[along] = Some(v);
                }
            }
        }
        out.at = at;
        if hit.touches && out.t.is_none() {
            let [from, direction] = stored(line);
            out.t = r
                .quadric
                .as_ref()?
                .touch(&from, &direction)
                .map(When::Exact);
        }
        Some(out)
    }

    /// Which native parameter is the profile's, of a revolution.
    pub(crate) fn profile_axis(&self) -> Option<usize> {
        match self {
            Self::Plane(_) => None,
            Self::Revolution(r) => Some(if r.transposed() { 0 } else { 1 }),
        }
    }

    /// The ruling of a cylinder or a cone that holds all of a line, if one does.
    pub(crate) fn ruling(&self, surface: &Surface, line: &ClosedLine) -> Option<Ruling> {
        let (Self::Revolution(r), Surface::Revolution(s)) = (self, surface) else {
            return None;
        };
        let [from, direction] = stored(line);
        if !r.quadric.as_ref()?.holds_line(&from, &direction)? {
            return None;
        }
        // The plane of the profile holds the axis, whatever the angle at which it is a border.
        let (origin, axis) = (
            vector(s.origin.coords.as_slice())?,
            vector(s.axis.as_slice())?,
        );
        let Curve3::Line(l) = &s.profile else {
            return None;
        };
        let [p, q] = [&l.from, &l.to].map(|p| vector(p.coords.as_slice()));
        let (p, q) = (sub(&p?, &origin), sub(&q?, &origin));
        if dot(&cross(&axis, &p), &q).signum() != 0 {
            return None;
        }
        // Both ends on one side of the axis: an apex is at an end or beyond.
        let across = |v: &D3| -> D3 {
            let square = dot(&axis, &axis);
            sub(&scale(v, &square), &scale(&axis, &dot(v, &axis)))
        };
        let (across_p, across_q) = (across(&p), across(&q));
        if dot(&across_p, &across_q).signum() <= 0 {
            return None;
        }
        let profile = r.rise(s)?;
        let height = linear(&axis, &origin, line)?;
        if height[1].signum() == 0 {
            return None;
        }
        let along = if r.transposed() { 0 } else { 1 };
        // At the height of the profile's middle it is on the profile's half of a cone.
        let half = &(&profile.ends[0] + &profile.ends[1]) * &dyadic(0.5)?;
        let t = Ratio::new(&half - &height[0], height[1].clone()).enclosed();
        let point = form::along(&line.origin, t, &line.direction);
        let at = match r.seam(s) {
            Some((u, normal, origin)) => {
                let off = linear(&normal, &origin, line)?;
                let in_plane = off.iter().all(|x| x.signum() == 0);
                (in_plane && r.is_on_side(&point)).then_some(u)
            }
            None => None,
        };
        Some(Ruling {
            along,
            places: self.places(&point)?,
            at,
            height,
            profile,
        })
    }
}

impl Ruling {
    /// The line's parameter at a native parameter along it.
    pub(crate) fn parameter(&self, v: f64) -> Option<Ratio> {
        let [top, bottom] = self.profile.at(v)?;
        let off = &top - &(&self.height[0] * &bottom);
        Some(Ratio::new(off, &self.height[1] * &bottom))
    }

    /// Copies of the parameter across it that may be in the domain.
    pub(crate) fn across(&self) -> impl Iterator<Item = Ball<Dd>> {
        self.places.iter().map(|uv| uv[1 - self.along])
    }
}
