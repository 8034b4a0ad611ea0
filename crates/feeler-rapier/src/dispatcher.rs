//! Queries of pairs, for Parry and Rapier.

use crate::advance::{straight, turning};
use crate::along::along;
use crate::ball::ball;
use crate::compound;
use crate::convex::convex;
use crate::half_space::half_space;
use crate::pair::{Ask, Memory, PairAnswer, PairContact};
use crate::pose::{Order, Placement};
use crate::report::{Report, UnsupportedPair};
use crate::shape::BrepShape;
use crate::solid::Hull;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::details::{NormalConstraints, ShapeCastOptions};
use parry3d_f64::query::{
    ClosestPoints, Contact, ContactManifold, ContactManifoldsWorkspace, NonlinearRigidMotion,
    PersistentQueryDispatcher, QueryDispatcher, ShapeCastHit, ShapeDistance, ShapeIntersection,
    TrackedContact, Unsupported,
};
use parry3d_f64::shape::{PackedFeatureId, Shape, TypedShape};
use std::sync::Arc;

/// Answers for pairs of a [`BrepShape`] and another shape; knows nothing of other pairs, and so stands in a chain before Parry's
/// `DefaultQueryDispatcher`.
///
/// A pair with a BREP that it does not support is said on standard error, once for each kind of query and shape, and
/// counted: Rapier itself drops Parry's `Unsupported` in silence, and lets the bodies fall through each other. A
/// clone shares the counts.
#[derive(Clone)]
pub struct BrepDispatcher {
    report: Arc<Report>,
}

impl Default for BrepDispatcher {
    fn default() -> Self {
        Self::new()
    }
}

/// A pair with a BREP, from its side.
struct Pair<'a> {
    shape: &'a BrepShape,
    other: &'a dyn Shape,
    order: Order,
}

impl BrepDispatcher {
    /// Says unsupported pairs on standard error.
    pub fn new() -> Self {
        Self::with_report(|message| eprintln!("{message}"))
    }

    /// Says them to a function.
    pub fn with_report(say: impl Fn(&str) + Send + Sync + 'static) -> Self {
        Self {
            report: Arc::new(Report::new(Box::new(say))),
        }
    }

    /// The kinds of pairs that were asked for and are not supported.
    pub fn unsupported(&self) -> Vec<UnsupportedPair> {
        self.report.pairs()
    }

    /// What is known of a BREP and another shape, at most `prediction` apart, in the BREP's frame; `None` if the pair has no BREP,
    /// is one of compounds or is not supported. This is what the manifolds are made of, with its bounds.
    pub fn pair(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        prediction: f64,
    ) -> Option<PairAnswer> {
        let pair = Self::find(g1, g2).ok()?;
        let mut memory = Memory::default();
        let answer = self.answer("contact", &pair, pos12, prediction, true, &mut memory);
        answer.ok()
    }

    fn find<'a>(g1: &'a dyn Shape, g2: &'a dyn Shape) -> Result<Pair<'a>, Unsupported> {
        let pair = |shape, other, order| Pair {
            shape,
            other,
            order,
        };
        if let Some(shape) = g1.as_shape::<BrepShape>() {
            return Ok(pair(shape, g2, Order::First));
        }
        if let Some(shape) = g2.as_shape::<BrepShape>() {
            return Ok(pair(shape, g1, Order::Second));
        }
        Err(Unsupported)
    }

    fn answer(
        &self,
        query: &'static str,
        pair: &Pair<'_>,
        pos12: &Pose,
        prediction: f64,
        several: bool,
        memory: &mut Memory,
    ) -> Result<PairAnswer, Unsupported> {
        let ask = Ask {
            placement: Placement {
                pos12,
                order: pair.order,
            },
            prediction,
            several,
        };
        let shape = pair.shape;
        Ok(match pair.other.as_typed_shape() {
            TypedShape::Ball(b) => ball(shape, &ask, b.radius, memory),
            TypedShape::HalfSpace(h) => half_space(shape, &ask, h.normal, memory),
            TypedShape::Segment(s) => along(shape, &ask, [s.a, s.b], 0.0, memory),
            TypedShape::Capsule(c) => {
                along(shape, &ask, [c.segment.a, c.segment.b], c.radius, memory)
            }
            _ => match Hull::of(pair.other) {
                Some(hull) => convex(shape, &ask, hull, memory),
                None => {
                    self.report.note(query, pair.other);
                    return Err(Unsupported);
                }
            },
        })
    }

    /// The same for a single question: no contacts, or the deepest.
    fn once(
        &self,
        query: &'static str,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        prediction: f64,
    ) -> Result<(PairAnswer, Order), Unsupported> {
        let pair = Self::find(g1, g2)?;
        let mut memory = Memory::default();
        let answer = self.answer(query, &pair, pos12, prediction, false, &mut memory)?;
        Ok((answer, pair.order))
    }
}

/// A contact as Parry has it: points and normals of both shapes, each in its own frame, the BREP's first.
struct Local {
    points: [Vector; 2],
    normals: [Vector; 2],
}

fn local(c: &PairContact, placement: &Placement<'_>, ball: Option<f64>) -> Local {
    let turned = placement.turn_to_other(-c.normal);
    // On a ball the point is where the normal is: no way through the pose.
    let point = match ball {
        Some(radius) => turned * radius,
        None => placement.to_other(c.on_other),
    };
    Local {
        points: [c.on_brep, point],
        normals: [c.normal, turned],
    }
}

fn swap_if(order: Order, [a, b]: [Vector; 2]) -> [Vector; 2] {
    match order {
        Order::First => [a, b],
        Order::Second => [b, a],
    }
}

impl QueryDispatcher for BrepDispatcher {
    fn intersection_test(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
    ) -> Result<ShapeIntersection, Unsupported> {
        if let Some(pairs) = compound::pairs(pos12, g1, g2) {
            return compound::intersect(self, &pairs).map(ShapeIntersection::new);
        }
        let (answer, _) = self.once("intersection", pos12, g1, g2, f64::NEG_INFINITY)?;
        Ok(ShapeIntersection::new(answer.separation.value <= 0.0))
    }

    fn distance(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
    ) -> Result<ShapeDistance, Unsupported> {
        if let Some(pairs) = compound::pairs(pos12, g1, g2) {
            return compound::distance(self, &pairs).map(ShapeDistance::new);
        }
        let (answer, _) = self.once("distance", pos12, g1, g2, f64::NEG_INFINITY)?;
        Ok(ShapeDistance::new(answer.separation.value.max(0.0)))
    }

    fn contact(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        prediction: f64,
    ) -> Result<Option<Contact>, Unsupported> {
        if let Some(pairs) = compound::pairs(pos12, g1, g2) {
            return compound::contact(self, &pairs, prediction);
        }
        let (answer, order) = self.once("contact", pos12, g1, g2, prediction)?;
        let other = match order {
            Order::First => g2,
            Order::Second => g1,
        };
        let radius = other.as_ball().map(|b| b.radius);
        let placement = Placement { pos12, order };
        Ok(answer.contacts.first().map(|c| {
            let local = local(c, &placement, radius);
            let [p1, p2] = swap_if(order, local.points);
            let [n1, n2] = swap_if(order, local.normals);
            Contact::new(p1, p2, n1, n2, c.separation.value)
        }))
    }

    fn closest_points(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        max_dist: f64,
    ) -> Result<ClosestPoints, Unsupported> {
        if let Some(pairs) = compound::pairs(pos12, g1, g2) {
            return compound::closest_points(self, &pairs, pos12, max_dist);
        }
        let Some(c) = self.contact(pos12, g1, g2, max_dist)? else {
            return Ok(ClosestPoints::Disjoint);
        };
        Ok(if c.dist <= 0.0 {
            ClosestPoints::Intersecting
        } else if c.dist <= max_dist {
            ClosestPoints::WithinMargin(c.point1, c.point2)
        } else {
            ClosestPoints::Disjoint
        })
    }

    fn cast_shapes(
        &self,
        pos12: &Pose,
        local_vel12: Vector,
        g1: &dyn Shape,
        g2: &dyn Shape,
        options: ShapeCastOptions,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        if let Some(pairs) = compound::pairs(pos12, g1, g2) {
            return compound::cast(self, &pairs, local_vel12, options);
        }
        let pair = Self::find(g1, g2)?;
        let Some(ball) = pair.other.as_ball() else {
            self.report.note("shape cast", pair.other);
            return Err(Unsupported);
        };
        let placement = Placement {
            pos12,
            order: pair.order,
        };
        let radius = ball.radius;
        Ok(straight(
            pair.shape,
            placement,
            local_vel12,
            radius,
            &options,
        ))
    }

    fn cast_shapes_nonlinear(
        &self,
        motion1: &NonlinearRigidMotion,
        g1: &dyn Shape,
        motion2: &NonlinearRigidMotion,
        g2: &dyn Shape,
        start_time: f64,
        end_time: f64,
        stop_at_penetration: bool,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        if let Some(pairs) = compound::pairs(&Pose::IDENTITY, g1, g2) {
            let (motions, time) = ([motion1, motion2], [start_time, end_time]);
            return compound::cast_nonlinear(self, &pairs, motions, time, stop_at_penetration);
        }
        let query = "nonlinear shape cast";
        let pair = Self::find(g1, g2)?;
        let Some(ball) = pair.other.as_ball() else {
            self.report.note(query, pair.other);
            return Err(Unsupported);
        };
        let motions = match pair.order {
            Order::First => [motion1, motion2],
            Order::Second => [motion2, motion1],
        };
        let time = [start_time, end_time];
        let (order, radius) = (pair.order, ball.radius);
        Ok(turning(
            pair.shape,
            order,
            motions,
            radius,
            time,
            stop_at_penetration,
        ))
    }
}

/// Contacts whose normals are within this cosine of each other (about 26 degrees) may be one that went from face to face.
const SAME_WAY: f64 = 0.9;

impl<M, C> PersistentQueryDispatcher<M, C> for BrepDispatcher
where
    M: Default + Clone + Send + Sync,
    C: Default + Copy + Send + Sync,
{
    /// One manifold for each normal: a single one for a half-space, one a contact for the rest.
    ///
    /// A contact takes the place, and with it what the engine knows for its warm start, of the earlier one with the same features; or
    /// else of one whose normal is nearly the same, so that a ball that rolls from face to face does not start
    /// afresh. Manifolds are emptied, not removed, but for those of a pair of parts of compounds whose boxes are apart.
    fn contact_manifolds(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        prediction: f64,
        manifolds: &mut Vec<ContactManifold<M, C>>,
        workspace: &mut Option<ContactManifoldsWorkspace>,
    ) -> Result<(), Unsupported> {
        if let Some(pairs) = compound::pairs(pos12, g1, g2) {
            compound::manifolds(self, &pairs, prediction, manifolds, workspace);
            return Ok(());
        }
        let pair = Self::find(g1, g2)?;
        let memory = Memory::of(workspace);
        let answer = self.answer("contact", &pair, pos12, prediction, true, memory);
        let Ok(answer) = answer else {
            manifolds.clear();
            return Err(Unsupported);
        };
        let order = pair.order;
        let placement = Placement { pos12, order };
        let radius = pair.other.as_ball().map(|b| b.radius);
        let tracked = |c: &PairContact| {
            let local = local(c, &placement, radius);
            let [p1, p2] = swap_if(order, local.points);
            let [fid1, fid2] = match order {
                Order::First => [c.feature, c.feature_other],
                Order::Second => [c.feature_other, c.feature],
            };
            let contact = TrackedContact::new(p1, p2, fid1, fid2, c.separation.value);
            (contact, swap_if(order, local.normals))
        };
        let found: Vec<_> = answer
            .contacts
            .iter()
            .filter(|c| c.separation.value < prediction)
            .map(tracked)
            .collect();
        if matches!(pair.other.as_typed_shape(), TypedShape::HalfSpace(_)) {
            one_manifold(manifolds, &found);
        } else {
            one_each(manifolds, &found);
        }
        Ok(())
    }

    fn contact_manifold_convex_convex(
        &self,
        _pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        _normal_constraints1: Option<&dyn NormalConstraints>,
        _normal_constraints2: Option<&dyn NormalConstraints>,
        _prediction: f64,
        _manifold: &mut ContactManifold<M, C>,
    ) -> Result<(), Unsupported> {
        // A BREP is not convex, and nothing that knows this asks.
        if let Ok(pair) = Self::find(g1, g2) {
            self.report.note("convex contact", pair.other);
        }
        Err(Unsupported)
    }
}

type Found<C> = (TrackedContact<C>, [Vector; 2]);

fn empty<M: Default, C: Default + Copy>() -> ContactManifold<M, C> {
    ContactManifold::with_data(0, 0, M::default())
}

fn set<M, C: Default + Copy>(m: &mut ContactManifold<M, C>, [n1, n2]: [Vector; 2]) {
    (m.local_n1, m.local_n2) = (n1, n2);
}

fn one_manifold<M: Default + Clone, C: Default + Copy>(
    manifolds: &mut Vec<ContactManifold<M, C>>,
    found: &[Found<C>],
) {
    manifolds.truncate(1);
    if manifolds.is_empty() {
        manifolds.push(empty());
    }
    let m = &mut manifolds[0];
    let old = std::mem::take(&mut m.points);
    m.points.extend(found.iter().map(|f| f.0));
    m.match_contacts(&old);
    if let Some((_, normals)) = found.first() {
        set(m, *normals);
    }
}

fn one_each<M: Default + Clone, C: Default + Copy>(
    manifolds: &mut Vec<ContactManifold<M, C>>,
    found: &[Found<C>],
) {
    let features = |c: &TrackedContact<C>| -> [PackedFeatureId; 2] { [c.fid1, c.fid2] };
    let mut taken = vec![false; manifolds.len()];
    let mut places: Vec<Option<usize>> = vec![None; found.len()];
    for pass in 0..3 {
        for (place, (contact, normals)) in places.iter_mut().zip(found) {
            if place.is_some() {
                continue;
            }
            let fits = |m: &ContactManifold<M, C>| match (pass, m.points.first()) {
                (0, Some(old)) => {
                    features(old) == features(contact) && m.local_n1.dot(normals[0]) > SAME_WAY
                }
                (1, Some(_)) => m.local_n1.dot(normals[0]) > SAME_WAY,
                // A place that was empty before, so that a contact which is gone leaves nothing behind.
                (2, None) => true,
                _ => false,
            };
            let at = (0..manifolds.len()).find(|k| !taken[*k] && fits(&manifolds[*k]));
            if let Some(at) = at {
                taken[at] = true;
                *place = Some(at);
            }
        }
    }
    for (manifold, taken) in manifolds.iter_mut().zip(&taken) {
        if !taken {
            manifold.points.clear();
        }
    }
    for (place, (contact, normals)) in places.iter().zip(found) {
        let at = place.unwrap_or_else(|| {
            manifolds.push(empty());
            manifolds.len() - 1
        });
        let m = &mut manifolds[at];
        match m.points.first_mut() {
            Some(old) => old.copy_geometry_from(*contact),
            None => m.points.push(*contact),
        }
        set(m, *normals);
    }
    if manifolds.is_empty() {
        manifolds.push(empty());
    }
}
