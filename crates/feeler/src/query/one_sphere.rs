//! Balls against a BREP of one face on a native sphere: nothing is searched.
//!
//! The argument is in the module [`prepare::closed::sphere`](crate::prepare::closed::SphereForm): the distance is `|D - R|` within the slack, and the
//! foot where the formula says, if its parameters are within the face's region. Whatever f64 or double-double leaves open (next to the centre,
//! the surface itself, the poles, the border of the region) is the search's.

use super::Workspace;
use super::answer::{Contact, ContactAnswer, Contacts, Feature, Options, Separation, Sphere};
use super::contact::{in_material, target_width};
use super::continuum::{CONTINUUM_REACH, continuum_slack};
use super::outcome::Width;
use crate::numeric::{Ball, Dd, Enclosure, Real};
use crate::prepare::PreparedBrep;
use crate::prepare::closed::{SphereFoot, SphereForm, distance_range};
use crate::trim::BoxSide;
use nalgebra::{Point2, Vector3};

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 16.0 * f64::EPSILON;

/// The separation and the deepest contact; `None` where the search has to tell.
#[inline]
pub(super) fn contact(
    brep: &PreparedBrep,
    ball: &Sphere,
    options: &Options,
    width: Width,
    workspace: &mut Workspace,
) -> Option<ContactAnswer> {
    let form = brep.only_sphere()?;
    if options.contacts == Contacts::All {
        return None;
    }
    let q: &[f64; 3] = ball.center.coords.as_ref();
    let foot = form.foot(q)?;
    let region = brep.region(0);
    if !region.is_untrimmed() {
        let [u, v] = form.around(&foot);
        if region.classify_box(u, v) != BoxSide::Inside {
            return None;
        }
    }
    let rough = rough_gap(&foot, form.radius);
    let material = brep.brep().is_closed() && {
        let squared = distance_range(rough, form.slack)[0];
        in_material(brep, ball.center, squared, workspace)?
    };
    let is_enough =
        |s: &Separation| s.bounds.width() <= target_width(width, s, ball.radius, material);
    let coarse = match width.is_full() {
        true => None,
        false => rough_separation(rough, form.slack, ball.radius, material).filter(is_enough),
    };
    let (gap, separation) = match coarse {
        Some(separation) => (rough, separation),
        None => {
            let gap = form.gap(q);
            let fine = separation(gap, form.slack, ball.radius, material).filter(is_enough)?;
            (Ball::from_dd(gap.mid, gap.rad), fine)
        }
    };
    let mut answer = ContactAnswer {
        separation,
        continuum: false,
        contacts: Vec::new(),
        undecided: None,
    };
    if options.contacts == Contacts::None {
        return Some(answer);
    }
    // Within `psi` of the foot the squared distance grows by `R D psi^2`.
    let slack = continuum_slack(brep, options);
    let growth = slack * (2.0 * gap.mid.abs() + slack);
    let reach = CONTINUUM_REACH * brep.size();
    answer.continuum = growth * form.radius > reach * reach * foot.distance;
    if separation.bounds.lo <= options.prediction {
        let contact = make_contact(ball, form, &foot, gap, separation, material);
        let hidden = answer.continuum;
        answer.contacts = vec![Contact {
            position_bound: contact.position_bound.filter(|_| !hidden),
            normal_bound: contact.normal_bound.filter(|_| !hidden),
            ..contact
        }];
        workspace.work.contacts = 1;
    }
    Some(answer)
}

/// How far a foot's point is outside of the sphere: its distance less the radius, in f64.
fn rough_gap(foot: &SphereFoot, radius: f64) -> Ball<f64> {
    let mid = foot.distance - radius;
    let rad = (foot.error + f64::EPSILON * mid.abs()) * UP;
    Ball { mid, rad }
}

/// The separation from f64 alone; `None` where the point may be on the surface.
fn rough_separation(gap: Ball<f64>, slack: f64, radius: f64, material: bool) -> Option<Separation> {
    let off = (gap.rad + slack) * UP;
    let distance = gap.mid.abs();
    let value = if material { -distance } else { distance } - radius;
    // The difference, and those below, are off by half a unit each; what they have of `off` is in its share of `UP`.
    let off = (off + 2.0 * f64::EPSILON * value.abs()) * UP;
    let bounds = Enclosure {
        lo: value - off,
        hi: value + off,
    };
    (distance > 2.0 * off).then_some(Separation { value, bounds })
}

/// The separation in double-double; `None` where the point may be on the surface.
fn separation(gap: Ball<Dd>, slack: f64, radius: f64, material: bool) -> Option<Separation> {
    let off = (gap.rad + slack) * UP;
    let distance = if gap.mid.hi < 0.0 { -gap.mid } else { gap.mid };
    if !(distance.hi > 2.0 * off) {
        return None;
    }
    let mid = if material { -distance } else { distance } - Dd::from(radius);
    // The difference, and those below, are off by two units each at most.
    let off = Dd::from((off + 8.0 * Dd::UNIT * mid.hi.abs()) * UP);
    let bounds = Enclosure {
        lo: (mid - off).floor_f64(),
        hi: (mid + off).ceil_f64(),
    };
    let value = mid.hi.clamp(bounds.lo, bounds.hi);
    Some(Separation { value, bounds })
}

#[inline]
fn make_contact(
    ball: &Sphere,
    form: &SphereForm,
    foot: &SphereFoot,
    gap: Ball<f64>,
    separation: Separation,
    material: bool,
) -> Contact {
    let q = ball.center;
    // From the centre of the ball towards that of the sphere, or away from it.
    let step = gap.mid / foot.distance;
    let off = Vector3::from(foot.off);
    let on_brep = q - off * step;
    let outward = (gap.mid > 0.0) != material;
    let normal = off * (if outward { 1.0 } else { -1.0 } / foot.distance);
    // The unit vector is off by both errors over the length; the step by what the gap is, and a quotient, products and differences by half a unit each
    // of what they are.
    let turned = 2.0 * foot.error / foot.distance;
    let sizes = on_brep.coords.abs().sum();
    let rounded = gap.rad + gap.mid.abs() * (turned + 2.0 * f64::EPSILON) + f64::EPSILON * sizes;
    let shift = form.shift(foot.distance);
    let apart = gap.mid.abs() - gap.rad - form.slack;
    // The angle at the ball's centre between the sphere's nearest point and the surface's: its sine is `shift / apart` at most, and
    // asin x <= 1.6 x.
    let angle = 1.6 * shift / apart + 2.0 * turned + 4.0 * f64::EPSILON;
    Contact {
        on_brep,
        on_probe: q - normal * ball.radius,
        normal,
        separation,
        feature: Feature::Face(0),
        face: 0,
        uv: Point2::from(form.uv(foot)),
        position_bound: Some((rounded + shift) * UP).filter(|x| x.is_finite()),
        normal_bound: (shift < apart).then_some(angle * UP),
        normal_is_choice: false,
    }
}
