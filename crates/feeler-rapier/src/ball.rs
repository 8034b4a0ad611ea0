//! A BREP and a ball.
//!
//! # What is certified
//! The kernel's enclosure of the separation about the rounded centre, wider by the centre's bound e on both sides: the distance
//! from a set changes by at most e when the point moves by e. The sign is that of the rounded centre. It is that of the
//! true one, too, unless the way from one to the other, no longer than e, passes the faces; then both distances are at most e, and
//! the signed distance has changed by at most their sum, which is no more than the length of the way. If the way slips through the
//! crack of an edge of width d_e instead: what fills the crack lies within d_e / 2 of an image of the edge, and the side is told only
//! beyond d_e of it, so that the way has a chord of at least sqrt(3) d_e in the crack, and both distances together are at most
//! e + d_e <= 1.6 e. [`CRACKS`] takes the place of 1.6. (The box of a vertex whose ends are farther apart than the rounding has no such bound:
//! within it the sign is that of the rounded centre.)
//!
//! # Several contacts
//! After the deepest contact, certified over all faces, each other face that comes near is asked on its own ([`Several::PerFace`]): its
//! nearest point is certified to be that of this face. It is a contact if no face falls below it there: at a point inside a
//! face nothing can; at an edge or vertex each face that meets there is tested by steps, which is no proof. A face
//! that touches the ball in two places gives one of them.
//!
//! Where the kernel finds that the deepest contact is a continuum, it is asked again from centres a little beside,
//! in 14 directions; their feet that are as near to the ball's centre, and apart from each other, join the list.

use crate::pair::{Ask, Memory, PairAnswer, PairContact, from_point, from_vector, pack, to_point};
use crate::pair::{to_vector, widened};
use crate::pose::{Placed, Placement, up};
use crate::shape::{BrepShape, Several};
use feeler::numeric::Enclosure;
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, Contact, ContactAnswer, Contacts, Feature, Options, Probe, Separation, Sphere,
    Undecided, Workspace, contact, contact_from,
};
use nalgebra::Point3;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::shape::PackedFeatureId;

/// See the module: at least 1.6.
const CRACKS: f64 = 2.0;
/// Feet nearer to each other than this times the size are one contact: as in the kernel.
const SAME: f64 = 1.0 / (1u64 << 24) as f64;
/// Steps from a foot on an edge, in sizes, to look for lower points of the faces that meet there; besides one that is short enough for any slope.
const STEPS: [f64; 2] = [1.0 / (1u64 << 12) as f64, 1.0 / (1u64 << 20) as f64];
/// What counts as lower, in sizes: above the rounding of the feet.
const LOWER: f64 = 1.0 / (1u64 << 44) as f64;
/// How far beside the centre a continuum is asked from, in sizes; and how far apart its points are at least.
const BESIDE: f64 = 1.0 / (1u64 << 10) as f64;
const APART: f64 = 1.0 / (1u64 << 6) as f64;

/// The gap of a ball at the poses of two bodies, in the world: what is rounded on the way is in the bounds. What an engine
/// reports may differ, since it rounds the pose of one body relative to the other first.
pub fn ball_gap(shape: &BrepShape, pose: &Pose, center: Vector, radius: f64) -> Separation {
    let center = crate::pose::into(pose, center);
    let mut workspace = Workspace::default();
    let options = shape.options(f64::INFINITY, Contacts::None);
    let answer = Sphere::new(to_point(center.point), radius)
        .map(|s| contact(shape.brep(), &Probe::Sphere(s), &options, &mut workspace));
    match answer {
        Ok(answer) => settled(shape, &answer, center.bound).0,
        Err(_) => nothing_known().separation,
    }
}

/// The separation of an answer with the pose's rounding, and why it is not settled.
fn settled(
    shape: &BrepShape,
    answer: &ContactAnswer,
    bound: f64,
) -> (Separation, Option<Undecided>) {
    let mut separation = answer.separation;
    if answer.undecided.is_some() {
        shape.note_undecided();
    }
    if answer.undecided == Some(Undecided::Degenerate) {
        // Both signs are possible: engines keep balls outside.
        separation.value = separation.bounds.hi;
    }
    (widened(separation, up(CRACKS * bound)), answer.undecided)
}

pub(crate) fn nothing_known() -> PairAnswer {
    PairAnswer {
        separation: Separation {
            value: f64::INFINITY,
            bounds: Enclosure {
                lo: f64::NEG_INFINITY,
                hi: f64::INFINITY,
            },
        },
        contacts: Vec::new(),
        continuum: false,
        undecided: Some(Undecided::Degenerate),
    }
}

/// A ball about the origin of its frame.
pub(crate) fn ball(
    shape: &BrepShape,
    ask: &Ask<'_>,
    radius: f64,
    memory: &mut Memory,
) -> PairAnswer {
    let center = ask.placement.to_brep(Vector::ZERO);
    let feature = PackedFeatureId::face(0);
    ball_at(shape, ask, center, radius, feature, memory)
}

/// A ball about a point of the BREP's frame.
pub(crate) fn ball_at(
    shape: &BrepShape,
    ask: &Ask<'_>,
    center: Placed,
    radius: f64,
    feature_other: PackedFeatureId,
    memory: &mut Memory,
) -> PairAnswer {
    let Ok(sphere) = Sphere::new(to_point(center.point), radius) else {
        shape.note_undecided();
        return nothing_known();
    };
    if !center.bound.is_finite() {
        shape.note_undecided();
        return nothing_known();
    }
    let probe = Probe::Sphere(sphere);
    let several = if ask.several {
        shape.several()
    } else {
        Several::Deepest
    };
    let wanted = match several {
        Several::All => Contacts::All,
        _ => Contacts::Deepest,
    };
    let options = shape.options(ask.prediction, wanted);
    let Memory { witness, workspace } = memory;
    let answer = contact_from(shape.brep(), &probe, witness, &options, workspace);
    let (separation, undecided) = settled(shape, &answer, center.bound);
    let mut found = answer.contacts;
    if let Some(deepest) = found.first_mut() {
        deepest.separation.value = separation.value;
    }
    let outside = separation.value > -radius;
    if let (Several::PerFace, true, Some(deepest)) = (several, outside, found.first().copied()) {
        if answer.continuum {
            spread(shape, &sphere, &deepest, workspace, &mut found);
        }
        let mut faces = Faces {
            shape,
            sphere,
            options,
            workspace,
        };
        faces.others(&deepest, &mut found);
    }
    let dress = |c: &Contact| PairContact {
        separation: widened(c.separation, up(CRACKS * center.bound)),
        ..dressed(c, center.point, radius, feature_other)
    };
    PairAnswer {
        separation,
        contacts: found.iter().map(dress).collect(),
        continuum: answer.continuum,
        undecided,
    }
}

/// The kernel's contact of a ball about a point of the BREP's frame.
pub(crate) fn dressed(
    c: &Contact,
    center: Vector,
    radius: f64,
    feature_other: PackedFeatureId,
) -> PairContact {
    let normal = from_vector(&c.normal);
    PairContact {
        on_brep: from_point(&c.on_brep),
        on_other: center - normal * radius,
        normal,
        separation: c.separation,
        feature: pack(c.feature, 0),
        feature_other,
    }
}

/// Other points of a continuum.
fn spread(
    shape: &BrepShape,
    sphere: &Sphere,
    deepest: &Contact,
    workspace: &mut Workspace,
    found: &mut Vec<Contact>,
) {
    let size = shape.brep().size();
    let options = shape.options(f64::INFINITY, Contacts::Deepest);
    let slack = match options.accuracy {
        Accuracy::Length(a) => a,
        Accuracy::Full => 0.0,
    };
    let most = deepest.separation.bounds.hi + slack.max(LOWER * size);
    for direction in directions() {
        let beside = sphere.center + to_vector(direction * (BESIDE * size));
        let Ok(moved) = Sphere::new(beside, sphere.radius) else {
            continue;
        };
        let answer = contact(shape.brep(), &Probe::Sphere(moved), &options, workspace);
        let Some(mut c) = answer.contacts.first().copied() else {
            continue;
        };
        let off = sphere.center - c.on_brep;
        let distance = off.norm();
        // A place of the BREP, known to the rounding of its coordinates and of the norm.
        let rounding = up(8.0 * f64::EPSILON * (c.on_brep.coords.norm() + distance));
        let value = distance - sphere.radius;
        let apart = |o: &Contact| (o.on_brep - c.on_brep).norm() > APART * size;
        if value - rounding <= most && distance > 0.0 && found.iter().all(apart) {
            c.separation = Separation {
                value,
                bounds: Enclosure {
                    lo: deepest.separation.bounds.lo,
                    hi: value + rounding,
                },
            };
            c.normal = off / distance;
            found.push(c);
        }
    }
}

/// Along the axes and the diagonals.
fn directions() -> impl Iterator<Item = Vector> {
    let axes = (0..6).map(|k| {
        let mut d = [0.0; 3];
        d[k / 2] = if k % 2 == 0 { 1.0 } else { -1.0 };
        Vector::from_array(d)
    });
    let sign = |bit: usize| if bit == 0 { 1.0 } else { -1.0 };
    let diagonals = (0..8).map(move |k| {
        Vector::new(sign(k & 1), sign(k >> 1 & 1), sign(k >> 2)) * (1.0 / 3f64.sqrt())
    });
    axes.chain(diagonals)
}

/// The nearest points of single faces.
struct Faces<'a> {
    shape: &'a BrepShape,
    sphere: Sphere,
    options: Options,
    workspace: &'a mut Workspace,
}

impl Faces<'_> {
    fn others(&mut self, deepest: &Contact, found: &mut Vec<Contact>) {
        let reach = up(self.sphere.radius + self.options.prediction.max(0.0));
        let size = self.shape.brep().size();
        for face in 0..self.shape.brep().brep().faces().len() {
            if face == deepest.face || !self.shape.is_face_near(face, &self.sphere.center, reach) {
                continue;
            }
            let Some(alone) = self.shape.face_alone(face) else {
                continue;
            };
            let probe = Probe::Sphere(self.sphere);
            let answer = contact(alone.brep(), &probe, &self.options, self.workspace);
            let Some(mut c) = answer.contacts.first().copied() else {
                continue;
            };
            let same = |o: &Contact| (o.on_brep - c.on_brep).norm() <= SAME * size;
            if found.iter().any(same) {
                continue;
            }
            c.face = face;
            c.feature = alone.feature(c.feature);
            if self.is_lowest(&c) {
                found.push(c);
            }
        }
        found[1..].sort_by(|a, b| {
            let by_depth = a.separation.value.total_cmp(&b.separation.value);
            by_depth.then(a.feature.cmp(&b.feature))
        });
    }

    /// Whether no face that meets at a contact's place goes on to lower points, as far as steps tell.
    fn is_lowest(&mut self, c: &Contact) -> bool {
        let joined = match c.feature {
            Feature::Face(_) => Vec::new(),
            Feature::Edge(edge) => self.shape.faces_at_edge(edge),
            Feature::Vertex(vertex) => self.shape.faces_at_vertex(vertex),
        };
        // Faces may meet without an edge that says so.
        let near = SAME * self.shape.brep().size();
        let faces = 0..self.shape.brep().brep().faces().len();
        faces.into_iter().all(|face| {
            if joined.contains(&face) {
                return !self.falls(face, c, f64::INFINITY);
            }
            face == c.face
                || !self.shape.is_face_near(face, &c.on_brep, near)
                || !self.falls(face, c, near)
        })
    }

    /// Whether a face that comes as near as this to a contact's place goes on to lower points.
    fn falls(&mut self, face: usize, c: &Contact, near: f64) -> bool {
        let Some(alone) = self.shape.face_alone(face) else {
            return false;
        };
        let size = self.shape.brep().size();
        let center = self.sphere.center;
        let away = (center - c.on_brep).norm();
        let Some(own) = self.foot(alone.brep(), c.on_brep) else {
            return false;
        };
        if (own.on_brep - c.on_brep).norm() > near {
            return false;
        }
        let surface = self.shape.brep().brep().surface(face);
        let at = surface.first_derivatives_with_bound(own.uv.x, own.uv.y);
        let normal = at.du.cross(&at.dv);
        let length = normal.norm();
        if !(length > 0.0) {
            return false;
        }
        let normal = normal / length;
        let off = center - c.on_brep;
        let along = off - normal * off.dot(&normal);
        let slope = along.norm();
        if !(slope > LOWER * size) {
            return false;
        }
        // A step is lower while it is shorter than about twice the slope.
        let steps = STEPS.map(|step| step * size).into_iter();
        steps.chain([0.5 * slope]).any(|length| {
            let to = c.on_brep + along * (length / slope);
            let foot = self.foot(alone.brep(), to);
            foot.is_some_and(|f| (center - f.on_brep).norm() < away - LOWER * size)
        })
    }

    fn foot(&mut self, face: &PreparedBrep, at: Point3<f64>) -> Option<Contact> {
        let probe = Probe::Sphere(Sphere::new(at, 0.0).ok()?);
        let options = Options {
            prediction: f64::INFINITY,
            ..self.options
        };
        let answer = contact(face, &probe, &options, self.workspace);
        answer.contacts.first().copied()
    }
}

/// The separation of a ball alone, whose centre is in the BREP's frame.
pub(crate) fn separation_at(
    shape: &BrepShape,
    center: Placed,
    radius: f64,
    memory: &mut Memory,
) -> Separation {
    let placement = Placement {
        pos12: &Pose::IDENTITY,
        order: crate::pose::Order::First,
    };
    let ask = Ask {
        placement,
        prediction: f64::INFINITY,
        several: false,
    };
    let feature = PackedFeatureId::face(0);
    ball_at(shape, &ask, center, radius, feature, memory).separation
}
