//! A BREP and a convex solid: a cuboid, a triangle, a convex hull, a cylinder, a cone, and these with round borders.
//!
//! # The separation
//! The least signed distance d of the BREP over the points p of the solid C, less the border's radius: apart, the distance of the two; else the
//! depth of C's deepest point in material.
//!
//! # What is certified
//! The enclosure. From above by d at a point of C. From below by a plane: with the BREP within {n.x <= m} and C within {n.x >= c}, both known,
//! from the kernel and from C's support in closed form, no point of C is nearer than c - m, nor deeper than m - c, since the ball about it in material is
//! within the half-space. And by d at C's middle less C's radius, as d changes by no more than the way. The
//! first is tight where a plane parts the two, up to their depth: faces on faces, on convex parts always. In a groove or a hole the second
//! holds, and the enclosure is about as wide as C, which is said (`undecided`). The pose's rounding is in both, and [`ROUNDING`] for what is computed here.
//!
//! # What is not
//! Which point of C is the deepest is found by going downhill from its rim and its middle, which proves nothing (the enclosure says how much
//! may be missed). Contacts are approximate: points of C's rim, each with the BREP's certified distance about it; the deepest point that was found;
//! and points of the BREP's edges and its vertices that are within C, with their distance from C's sides.
//!
//! Where a plane parts the two up to their depth, that depth along its normal frees them. A corner that stands flush with a side of
//! the BREP is as near to that side, and its contact would push sideways by nothing: such contacts are turned to the plane's normal where the
//! two face each other there, and left out where they do not.

use crate::ball::{ball_at, nothing_known};
use crate::pair::{Ask, Memory, PairAnswer, PairContact, pack, to_vector};
use crate::pose::{Placed, Placement, up};
use crate::shape::BrepShape;
use crate::solid::{Body, Hull, ROUNDING};
use feeler::numeric::Enclosure;
use feeler::query::{Contacts, HalfSpace, Probe, Separation, Undecided, contact};
use parry3d_f64::math::Vector;
use parry3d_f64::shape::PackedFeatureId;

/// Points of the rim that are asked about, the nearest first.
const VERTICES: usize = 16;
/// Places from which to go downhill, and most steps of one.
const STARTS: usize = 3;
const STEPS: usize = 32;
/// A step downhill that gains less than this part of C's radius is the last.
const GAIN: f64 = 1.0 / (1u64 << 30) as f64;
/// Contacts nearer to each other than this part of C's radius are one.
const SAME: f64 = 1.0 / 1024.0;
/// Most contacts in the list.
const MOST: usize = 12;

/// A plane parts the two where it bounds the depth to this part of C's radius, and a place within it of another is there.
const TIGHT: f64 = 1.0 / (1u64 << 20) as f64;
/// Normals within this cosine of the plane's (about 26 degrees) are its.
const SAME_WAY: f64 = 0.9;

/// What is known about a point of the solid.
struct Found {
    point: Vector,
    contact: PairContact,
}

/// A plane with the BREP on one side.
struct Plane {
    normal: Vector,
    /// How far the BREP reaches along the normal, at the most.
    top: f64,
    /// The separation is at least this.
    bound: f64,
}

struct Search<'a> {
    shape: &'a BrepShape,
    body: &'a Body,
    placement: Placement<'a>,
    memory: &'a mut Memory,
    hi: f64,
}

impl Search<'_> {
    /// The BREP's distance about a point.
    fn ask(&mut self, point: Vector, feature: PackedFeatureId) -> Option<Found> {
        let ask = Ask {
            placement: self.placement,
            prediction: f64::INFINITY,
            several: false,
        };
        let at = Placed {
            point,
            bound: self.body.bound,
        };
        let found = ball_at(self.shape, &ask, at, self.body.border, feature, self.memory);
        self.hi = self.hi.min(found.separation.bounds.hi);
        let contact = *found.contacts.first()?;
        Some(Found { point, contact })
    }

    /// Downhill from a point, within the polyhedron.
    fn descend(&mut self, from: Found) -> Found {
        let least = GAIN * self.body.radius;
        let mut best = from;
        // As far as the nearest point of the BREP to begin with; further where that gains, less far where it does not.
        let mut step = best.contact.separation.value.abs().max(least);
        for _ in 0..STEPS {
            let to = self.body.nearest(best.point - best.contact.normal * step);
            if step < least {
                break;
            }
            let next = match (to - best.point).length() > 0.0 {
                true => self.ask(to, PackedFeatureId::face(0)),
                false => None,
            };
            match next {
                Some(next) if next.contact.separation.value < best.contact.separation.value => {
                    best = next;
                    step *= 4.0;
                }
                _ => step *= 0.25,
            }
        }
        best
    }

    /// A bound of the separation from below, by a plane across this direction.
    fn plane(&mut self, n: Vector) -> Plane {
        let n = n / n.length();
        let unknown = Plane {
            normal: n,
            top: f64::INFINITY,
            bound: f64::NEG_INFINITY,
        };
        let Ok(plane) = HalfSpace::new(to_vector(-n), 0.0) else {
            return unknown;
        };
        let options = self.shape.options(f64::NEG_INFINITY, Contacts::None);
        let probe = Probe::HalfSpace(plane);
        let workspace = &mut self.memory.workspace;
        let found = contact(self.shape.brep(), &probe, &options, workspace);
        // The BREP is below -lo.
        let lo = found.separation.bounds.lo;
        let lowest = self.body.lowest(n);
        let rounding =
            2.0 * self.body.bound + ROUNDING * (lo.abs() + lowest.abs() + self.body.border);
        let bound = lowest + lo - self.body.border - up(rounding);
        if bound.is_nan() {
            return unknown;
        }
        Plane {
            normal: n,
            top: -lo,
            bound,
        }
    }

    /// A contact along the normal of a plane that parts the two, if they face each other where it is; `None` if not.
    fn turned(&mut self, c: PairContact, plane: &Plane) -> Option<PairContact> {
        let n = plane.normal;
        if c.normal.dot(n) >= SAME_WAY {
            return Some(c);
        }
        let body = self.body;
        let there = TIGHT * body.radius;
        let (on_brep, on_other, bound) = if c.feature_other == PackedFeatureId::face(0) {
            // A point of the BREP: C's point above it.
            let up = body.lowest(n) - n.dot(c.on_brep);
            let above = c.on_brep + n * up;
            let off = (body.nearest(above) - above).length();
            if !(off <= there) {
                return None;
            }
            let bound = off + (c.separation.bounds.hi - c.separation.value).abs();
            (c.on_brep, above - n * body.border, bound)
        } else {
            // A point of C: the BREP's below it, where the plane touches it.
            let corner = c.on_other + c.normal * body.border;
            let below = corner - n * (n.dot(corner) - plane.top);
            let found = self.ask(below, c.feature_other)?.contact;
            let off = (found.separation.value + body.border).abs();
            if !(off <= there) {
                return None;
            }
            (below, corner - n * body.border, off + body.bound)
        };
        let value = n.dot(on_other - on_brep);
        let bound = up(bound + ROUNDING * (on_brep.length() + on_other.length()));
        Some(PairContact {
            on_brep,
            on_other,
            normal: n,
            separation: Separation {
                value,
                bounds: Enclosure {
                    lo: (value - bound).next_down(),
                    hi: (value + bound).next_up(),
                },
            },
            ..c
        })
    }

    /// Points of the BREP's edges and its vertices within the polyhedron, or as near as this.
    fn border_points(&self, prediction: f64) -> Vec<PairContact> {
        let body = self.body;
        let reach = body.radius + body.border + prediction.max(0.0);
        let near = self.shape.border_points().iter();
        let near = near.filter(|p| (p.point - body.middle).length() <= reach);
        let contact = |p: &crate::shape::BorderPoint| {
            let (height, side) = body.out(p.point)?;
            // So near that the way there is one of rounding.
            let (value, normal) = if height <= GAIN * body.radius {
                (height, -side)
            } else {
                let off = body.nearest(p.point) - p.point;
                let length = off.length();
                (length, if length > 0.0 { off / length } else { -side })
            };
            let value = value - body.border;
            let bound = up(p.bound + 2.0 * body.bound);
            (value <= prediction).then(|| PairContact {
                on_brep: p.point,
                on_other: p.point + normal * value,
                normal,
                separation: Separation {
                    value,
                    bounds: Enclosure {
                        lo: (value - bound).next_down(),
                        hi: (value + bound).next_up(),
                    },
                },
                feature: pack(p.feature, p.number),
                feature_other: PackedFeatureId::face(0),
            })
        };
        near.filter_map(contact).collect()
    }
}

/// A BREP and a convex solid.
pub(crate) fn convex(
    shape: &BrepShape,
    ask: &Ask<'_>,
    hull: Hull,
    memory: &mut Memory,
) -> PairAnswer {
    let Some(body) = Body::new(hull, &ask.placement) else {
        shape.note_undecided();
        return nothing_known();
    };
    let mut search = Search {
        shape,
        body: &body,
        placement: ask.placement,
        memory,
        hi: f64::INFINITY,
    };
    let Some(middle) = search.ask(body.middle, PackedFeatureId::face(0)) else {
        shape.note_undecided();
        return nothing_known();
    };
    // What is computed here is off by more than what the kernel is asked for.
    let exactly = shape.accuracy() + GAIN * body.radius + 4.0 * body.bound;
    let around = (middle.contact.separation.bounds.lo - body.radius).next_down();
    let answer = |lo: f64, hi: f64, value: f64, contacts: Vec<PairContact>| {
        // A bound that is wider than what was asked, but for shapes that are farther apart than anyone asks.
        let settled = hi - lo <= exactly || ask.several && lo > ask.prediction;
        if !settled {
            shape.note_undecided();
        }
        PairAnswer {
            separation: Separation {
                value: value.clamp(lo, hi),
                bounds: Enclosure { lo, hi },
            },
            contacts,
            continuum: false,
            undecided: (!settled).then_some(Undecided::Precision),
        }
    };
    if ask.several && around > ask.prediction {
        let s = middle.contact.separation;
        return answer(around, s.bounds.hi, s.value, Vec::new());
    }
    // The points that are lowest along the way to the BREP.
    let mut order = body.corners(middle.contact.normal);
    order.truncate(VERTICES);
    let vertex = |(at, feature): &(Vector, PackedFeatureId)| search.ask(*at, *feature);
    let mut corners: Vec<Found> = order.iter().filter_map(vertex).collect();
    corners.sort_by(|a, b| {
        let depth = |f: &Found| f.contact.separation.value;
        depth(a).total_cmp(&depth(b))
    });
    let copy = |f: &Found| Found {
        point: f.point,
        contact: f.contact,
    };
    let gain = GAIN * body.radius;
    let mut deepest = search.descend(copy(&middle));
    for start in corners.iter().take(STARTS) {
        let found = search.descend(copy(start));
        // By more than rounding: of corners flush with a side of the BREP the normal is any.
        if found.contact.separation.value < deepest.contact.separation.value - gain {
            deepest = found;
        }
    }
    let normal = deepest.contact.normal;
    // Across the side that faces the BREP, too: it is known better than the normal of a round face.
    let facing = body.facing(normal).map(|out| -out);
    let across = [Some(normal), facing].into_iter().flatten();
    let planes: Vec<Plane> = across.map(|n| search.plane(n)).collect();
    let best = planes
        .into_iter()
        .max_by(|a, b| a.bound.total_cmp(&b.bound));
    let lo = best.as_ref().map_or(around, |p| around.max(p.bound));
    if !(lo <= search.hi) {
        // Bounds that contradict each other are no bounds.
        // Bounds that contradict each other are no bounds.
        shape.note_undecided();
        return nothing_known();
    }
    let hi = search.hi;
    let value = deepest.contact.separation.value;
    let mut contacts = vec![deepest.contact];
    if ask.several {
        // A corner that is as deep takes the deepest point's place: it is the same one at the next step.
        let apart = SAME * body.radius;
        let mut others: Vec<PairContact> = corners.iter().map(|f| f.contact).collect();
        others.extend(search.border_points(ask.prediction));
        let parts = |p: &Plane| value - p.bound <= TIGHT * body.radius;
        if let Some(plane) = best.filter(parts) {
            let turned = others.into_iter();
            others = turned.filter_map(|c| search.turned(c, &plane)).collect();
        }
        // The deepest first; of those as deep corners before points of edges.
        let rank = |c: &PairContact| {
            let edge = c.feature.is_edge() && c.feature_other == PackedFeatureId::face(0);
            ((c.separation.value / apart).round(), edge)
        };
        others.sort_by(|a, b| {
            let (x, y) = (rank(a), rank(b));
            x.0.total_cmp(&y.0).then(x.1.cmp(&y.1))
        });
        if others
            .first()
            .is_some_and(|c| c.separation.value <= value + gain)
        {
            contacts.clear();
        }
        for c in others {
            let same = |o: &PairContact| (o.on_brep - c.on_brep).length() <= apart;
            if contacts.len() < MOST && !contacts.iter().any(same) {
                contacts.push(c);
            }
        }
    }
    contacts.retain(|c| c.separation.value <= ask.prediction);
    answer(lo, hi, value, contacts)
}
