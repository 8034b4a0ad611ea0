//! A BREP and a half-space.
//!
//! # What is certified
//! Parry's half-space is {x : n.(x - t) <= 0} with t the origin of its frame; n stands for its exact normalisation. The kernel
//! is asked about the rounded normal n' and the rounded offset h of n'.t, and gives the least n'.x - h over the BREP. The true
//! height of a point x differs by (n - n').(x - t) and by the rounding of h: at most |n - n'| D + 4u |t|, with D the largest distance
//! of t from the box around the BREP. |n - n'| is the bound of the rotation, and some u for the normalisation before and after.
//!
//! # Several contacts
//! A half-space is convex: each point of the BREP may serve as a contact. A plate that lies flat wants several, and the
//! same ones at every step: after the deepest, the vertices and seven points on each edge that are within the prediction, deepest
//! first. The engine chooses from them. Each has the height of its own point, with rounding in the bounds.

use crate::ball::nothing_known;
use crate::pair::widened;
use crate::pair::{Ask, Memory, PairAnswer, PairContact, from_point, from_vector, pack, to_vector};
use crate::pose::up;
use crate::shape::BrepShape;
use feeler::numeric::Enclosure;
use feeler::query::{Contacts, HalfSpace, Probe, Separation, contact_from};
use parry3d_f64::math::Vector;
use parry3d_f64::shape::PackedFeatureId;

/// Half a unit in the last place of 1.
const U: f64 = f64::EPSILON / 2.0;
/// What two normalisations of a vector may be off: squares, root and quotient, twice.
const NORMALISED: f64 = 16.0 * U;
/// Most contacts in the list: an engine takes four.
const MOST: usize = 32;

pub(crate) fn half_space(
    shape: &BrepShape,
    ask: &Ask<'_>,
    normal: Vector,
    memory: &mut Memory,
) -> PairAnswer {
    let turned = ask.placement.turn_to_brep(normal / normal.length());
    let normal = turned.point / turned.point.length();
    let origin = ask.placement.to_brep(Vector::ZERO);
    let offset = normal.dot(origin.point);
    let Ok(probe) = HalfSpace::new(to_vector(normal), offset) else {
        shape.note_undecided();
        return nothing_known();
    };
    let aabb = shape.aabb();
    let farthest = (aabb.maxs - origin.point)
        .abs()
        .max((origin.point - aabb.mins).abs());
    let off = turned.bound + NORMALISED;
    let bound = up(off * farthest.length() + 4.0 * U * origin.point.length() + origin.bound);
    if !bound.is_finite() {
        shape.note_undecided();
        return nothing_known();
    }
    let options = shape.options(ask.prediction, Contacts::Deepest);
    let Memory { witness, workspace } = memory;
    let probe = Probe::HalfSpace(probe);
    let answer = contact_from(shape.brep(), &probe, witness, &options, workspace);
    if answer.undecided.is_some() {
        shape.note_undecided();
    }
    let feature_other = PackedFeatureId::face(0);
    let deepest = answer.contacts.first().map(|c| PairContact {
        on_brep: from_point(&c.on_brep),
        on_other: from_point(&c.on_probe),
        normal: from_vector(&c.normal),
        separation: widened(c.separation, bound),
        feature: pack(c.feature, 0),
        feature_other,
    });
    let mut contacts: Vec<PairContact> = deepest.into_iter().collect();
    if ask.several && !contacts.is_empty() {
        let own = 4.0 * U;
        let others = shape.border_points().iter().filter_map(|p| {
            let height = normal.dot(p.point) - offset;
            if !(height <= ask.prediction) {
                return None;
            }
            let rounding = own * (p.point.length() + offset.abs()) + p.bound + bound;
            Some(PairContact {
                on_brep: p.point,
                on_other: p.point - normal * height,
                normal: -normal,
                separation: Separation {
                    value: height,
                    bounds: Enclosure {
                        lo: (height - rounding).next_down(),
                        hi: (height + rounding).next_up(),
                    },
                },
                feature: pack(p.feature, p.number),
                feature_other,
            })
        });
        let first = contacts[0];
        let apart = shape.brep().size() / (1u64 << 12) as f64;
        let mut others: Vec<_> = others
            .filter(|c| (c.on_brep - first.on_brep).length() > apart)
            .collect();
        others.sort_by(|a, b| a.separation.value.total_cmp(&b.separation.value));
        others.truncate(MOST - 1);
        contacts.extend(others);
    }
    PairAnswer {
        separation: widened(answer.separation, bound),
        contacts,
        continuum: answer.continuum,
        undecided: answer.undecided,
    }
}
