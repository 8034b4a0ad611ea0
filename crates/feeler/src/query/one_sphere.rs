//! Balls against a BREP of one face on a native sphere: nothing is searched.
//!
//! The argument is in the module [`prepare::closed::sphere`](crate::prepare::closed::SphereForm): the distance is `|D - R|` within the slack, and the
//! foot where the formula says, if its parameters are within the face's region. Whatever f64 or double-double leaves open (next to the centre,
//! the surface itself, the poles, the border of the region) is the search's.

use super::Workspace;
use super::answer::{Contact, ContactAnswer, Contacts, Feature, Options, Separation, Sphere};
use super::contact::{CONTINUUM_REACH, continuum_slack, in_material, target_width};
use super::outcome::Width;
use crate::numeric::{Ball, Dd, Enclosure, Real};
use crate::prepare::PreparedBrep;
use crate::prepare::closed::{SphereFoot, SphereForm, distance_range};
use crate::trim::BoxSide;
use nalgebra::{Point2, Point3, Vector3};

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 16.0 * f64::EPSILON;

/// The separation and the deepest contact; `None` where the search has to tell.
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
    let [u, v] = foot.around;
    if brep.region(0).classify_box(u, v) != BoxSide::Inside {
        return None;
    }
    let rough = foot.distance - Ball::exact(form.radius);
    let told = |gap: Ball<Dd>| {
        let distance = Distance::new(gap, form.slack)?;
        let s = distance.separation(ball.radius, false);
        let enough = s.bounds.width() <= target_width(width, &s, ball.radius, false);
        enough.then_some((distance, s))
    };
    let known = if width.is_full() {
        None
    } else {
        told(rough.to_dd())
    };
    let (gap, (distance, mut separation)) = match known {
        Some(known) => (rough, known),
        None => {
            let gap = form.gap(q);
            (Ball::from_dd(gap.mid, gap.rad), told(gap)?)
        }
    };
    let mut material = false;
    if brep.brep().is_closed() {
        let squared = distance_range(gap, form.slack)[0];
        material = in_material(brep, ball.center, squared, workspace)?;
        separation = distance.separation(ball.radius, material);
        if separation.bounds.width() > target_width(width, &separation, ball.radius, material) {
            return None;
        }
    }
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
    let growth = slack * (2.0 * distance.mid.hi + slack);
    let reach = (growth * form.radius / foot.distance.mid).sqrt();
    answer.continuum = reach > CONTINUUM_REACH * brep.size();
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

/// The distance of a point from the surface.
struct Distance {
    mid: Dd,
    /// Of what it is off.
    off: f64,
}

impl Distance {
    /// From how far outside of the sphere it is; `None` where it may be on the surface.
    fn new(gap: Ball<Dd>, slack: f64) -> Option<Self> {
        let off = (gap.rad + slack) * UP;
        let mid = if gap.mid.hi < 0.0 { -gap.mid } else { gap.mid };
        (mid.hi > 2.0 * off).then_some(Self { mid, off })
    }

    /// Less a radius; of what is in material the negative.
    fn separation(&self, radius: f64, material: bool) -> Separation {
        let mid = if material { -self.mid } else { self.mid };
        let mid = mid - Dd::from(radius);
        // The difference, and those below, are off by two units each at most.
        let off = Dd::from((self.off + 8.0 * Dd::UNIT * mid.hi.abs()) * UP);
        let bounds = Enclosure {
            lo: (mid - off).floor_f64(),
            hi: (mid + off).ceil_f64(),
        };
        Separation {
            value: mid.hi.clamp(bounds.lo, bounds.hi),
            bounds,
        }
    }
}

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
    let step = gap / foot.distance;
    let point: [Ball<f64>; 3] = std::array::from_fn(|c| Ball::exact(q[c]) - step * foot.off[c]);
    let outward = (gap.mid > 0.0) != material;
    let length = if outward {
        foot.distance.mid
    } else {
        -foot.distance.mid
    };
    let normal = Vector3::from_fn(|c, _| foot.off[c].mid / length);
    let rounded = point.iter().map(|x| x.rad * x.rad).sum::<f64>().sqrt();
    let shift = form.shift(foot.distance.mid);
    let turned = foot.off.iter().map(|x| x.rad).sum::<f64>() / foot.distance.mid;
    let apart = gap.mid.abs() - gap.rad - form.slack;
    // The angle at the ball's centre between the sphere's nearest point and the surface's: its sine is `shift / apart` at most, and
    // asin x <= 1.6 x.
    let angle = 1.6 * shift / apart + 2.0 * turned + 4.0 * f64::EPSILON;
    Contact {
        on_brep: Point3::from(point.map(|x| x.mid)),
        on_probe: q - normal * ball.radius,
        normal,
        separation,
        feature: Feature::Face(0),
        face: 0,
        uv: Point2::from(foot.uv),
        position_bound: Some((rounded + shift) * UP).filter(|x| x.is_finite()),
        normal_bound: (shift < apart).then_some(angle * UP),
    }
}
