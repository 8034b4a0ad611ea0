//! Compounds with a BREP: each pair of their parts on its own.
//!
//! Parry's own dispatcher takes compounds apart without asking those before it in a chain, and its manifolds of compounds have one normal for a
//! pair of parts. Here pairs of parts with a BREP are asked as they are alone; the others are Parry's. What is certified of a pair of parts
//! is so for the pose of the one relative to the other, which is composed in f64: what that rounds is in no bound.

use crate::dispatcher::BrepDispatcher;
use crate::shape::BrepShape;
use parry3d_f64::bounding_volume::{Aabb, BoundingVolume};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::details::ShapeCastOptions;
use parry3d_f64::query::{
    ClosestPoints, Contact, ContactManifold, ContactManifoldsWorkspace, DefaultQueryDispatcher,
    NonlinearRigidMotion, PersistentQueryDispatcher, QueryDispatcher, ShapeCastHit,
    TypedWorkspaceData, Unsupported, WorkspaceData,
};
use parry3d_f64::shape::Shape;
use std::collections::BTreeMap;

/// Boxes of parts are turned in f64: they are taken to be larger by this part of their size.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A part of a shape, which may be all of it.
#[derive(Clone, Copy)]
struct Part<'a> {
    number: u32,
    /// In the frame of the whole; none where it is the whole.
    pose: Option<&'a Pose>,
    shape: &'a dyn Shape,
}

/// A part of either shape.
pub(crate) struct Parts<'a> {
    one: Part<'a>,
    two: Part<'a>,
    /// The pose of the second part in the frame of the first.
    pos12: Pose,
}

fn parts(shape: &dyn Shape) -> Vec<Part<'_>> {
    let Some(compound) = shape.as_compound() else {
        return vec![Part {
            number: 0,
            pose: None,
            shape,
        }];
    };
    let numbered = (0u32..).zip(compound.shapes());
    numbered
        .map(|(number, (pose, shape))| Part {
            number,
            pose: Some(pose),
            shape: &**shape,
        })
        .collect()
}

fn is_brep(shape: &dyn Shape) -> bool {
    shape.as_shape::<BrepShape>().is_some()
}

/// The pairs of parts of two shapes, of which one is a compound and one has a BREP; otherwise none.
pub(crate) fn pairs<'a>(
    pos12: &Pose,
    g1: &'a dyn Shape,
    g2: &'a dyn Shape,
) -> Option<Vec<Parts<'a>>> {
    if g1.as_compound().is_none() && g2.as_compound().is_none() {
        return None;
    }
    let (ones, twos) = (parts(g1), parts(g2));
    let mut all = ones.iter().chain(&twos);
    if !all.any(|p| is_brep(p.shape)) {
        return None;
    }
    let mut found = Vec::with_capacity(ones.len() * twos.len());
    for one in &ones {
        for two in &twos {
            let to_two = two.pose.map_or(*pos12, |pose| *pos12 * *pose);
            found.push(Parts {
                one: *one,
                two: *two,
                pos12: one.pose.map_or(to_two, |pose| pose.inv_mul(&to_two)),
            });
        }
    }
    Some(found)
}

impl Parts<'_> {
    fn has_brep(&self) -> bool {
        is_brep(self.one.shape) || is_brep(self.two.shape)
    }

    /// The dispatcher that knows this pair.
    fn ask<'d>(&self, breps: &'d BrepDispatcher) -> &'d dyn QueryDispatcher {
        match self.has_brep() {
            true => breps,
            false => &DefaultQueryDispatcher,
        }
    }

    /// Points and normals of the parts' frames in those of the wholes.
    fn out(&self, points: [Vector; 2], normals: [Vector; 2]) -> ([Vector; 2], [Vector; 2]) {
        let point = |p: &Part<'_>, x: Vector| p.pose.map_or(x, |pose| *pose * x);
        let normal = |p: &Part<'_>, x: Vector| p.pose.map_or(x, |pose| pose.rotation * x);
        let ([p1, p2], [n1, n2]) = (points, normals);
        (
            [point(&self.one, p1), point(&self.two, p2)],
            [normal(&self.one, n1), normal(&self.two, n2)],
        )
    }

    fn contact_out(&self, c: &Contact) -> Contact {
        let ([p1, p2], [n1, n2]) = self.out([c.point1, c.point2], [c.normal1, c.normal2]);
        Contact::new(p1, p2, n1, n2, c.dist)
    }

    fn hit_out(&self, h: &ShapeCastHit) -> ShapeCastHit {
        let ([witness1, witness2], [normal1, normal2]) =
            self.out([h.witness1, h.witness2], [h.normal1, h.normal2]);
        ShapeCastHit {
            witness1,
            witness2,
            normal1,
            normal2,
            subshape1: match self.one.pose {
                Some(_) => self.one.number,
                None => h.subshape1,
            },
            subshape2: match self.two.pose {
                Some(_) => self.two.number,
                None => h.subshape2,
            },
            ..*h
        }
    }

    fn may_touch(&self, prediction: f64) -> bool {
        let near = |b: Aabb| b.loosened(prediction.max(0.0) + ROUNDING * b.extents().length());
        let one = self.one.shape.compute_local_aabb();
        let two = self.two.shape.compute_aabb(&self.pos12);
        // An unbounded part is near everything.
        let bounded = one.half_extents().is_finite() && two.half_extents().is_finite();
        !bounded || near(one).intersects(&near(two))
    }
}

/// What is known of the pairs, if of any.
fn known<T>(
    pairs: &[Parts<'_>],
    mut ask: impl FnMut(&Parts<'_>) -> Result<T, Unsupported>,
) -> Result<Vec<T>, Unsupported> {
    let found: Vec<T> = pairs.iter().filter_map(|p| ask(p).ok()).collect();
    if found.is_empty() && !pairs.is_empty() {
        return Err(Unsupported);
    }
    Ok(found)
}

/// What is known of all pairs: of what is left out nothing could be said.
fn known_of_all<T>(
    pairs: &[Parts<'_>],
    ask: impl FnMut(&Parts<'_>) -> Result<T, Unsupported>,
) -> Result<Vec<T>, Unsupported> {
    pairs.iter().map(ask).collect()
}

pub(crate) fn intersect(breps: &BrepDispatcher, pairs: &[Parts<'_>]) -> Result<bool, Unsupported> {
    let ask = |p: &Parts<'_>| {
        let (one, two) = (p.one.shape, p.two.shape);
        p.ask(breps).intersection_test(&p.pos12, one, two)
    };
    let mut all = true;
    for pair in pairs {
        match ask(pair) {
            Ok(found) if found.intersecting => return Ok(true),
            Ok(_) => {}
            Err(Unsupported) => all = false,
        }
    }
    if all { Ok(false) } else { Err(Unsupported) }
}

pub(crate) fn distance(breps: &BrepDispatcher, pairs: &[Parts<'_>]) -> Result<f64, Unsupported> {
    let ask = |p: &Parts<'_>| {
        let (one, two) = (p.one.shape, p.two.shape);
        p.ask(breps).distance(&p.pos12, one, two)
    };
    let found = known_of_all(pairs, ask)?;
    Ok(found.iter().fold(f64::MAX, |d, x| d.min(x.distance)))
}

pub(crate) fn contact(
    breps: &BrepDispatcher,
    pairs: &[Parts<'_>],
    prediction: f64,
) -> Result<Option<Contact>, Unsupported> {
    let ask = |p: &Parts<'_>| {
        let (one, two) = (p.one.shape, p.two.shape);
        let found = p.ask(breps).contact(&p.pos12, one, two, prediction)?;
        Ok(found.map(|c| p.contact_out(&c)))
    };
    let found = known(pairs, ask)?.into_iter().flatten();
    Ok(found.min_by(|a, b| a.dist.total_cmp(&b.dist)))
}

pub(crate) fn closest_points(
    breps: &BrepDispatcher,
    pairs: &[Parts<'_>],
    pos12: &Pose,
    max_dist: f64,
) -> Result<ClosestPoints, Unsupported> {
    let ask = |p: &Parts<'_>| {
        let (one, two) = (p.one.shape, p.two.shape);
        let found = p.ask(breps).closest_points(&p.pos12, one, two, max_dist)?;
        Ok(match found {
            ClosestPoints::WithinMargin(a, b) => {
                let ([a, b], _) = p.out([a, b], [a, b]);
                ClosestPoints::WithinMargin(a, b)
            }
            other => other,
        })
    };
    // Those that intersect before those that are near, and these by how near they are.
    let rank = |c: &ClosestPoints| match c {
        ClosestPoints::Intersecting => -1.0,
        ClosestPoints::WithinMargin(a, b) => (*pos12 * *b - *a).length(),
        ClosestPoints::Disjoint => f64::INFINITY,
    };
    let found = known(pairs, ask)?.into_iter();
    let best = found.min_by(|a, b| rank(a).total_cmp(&rank(b)));
    Ok(best.unwrap_or(ClosestPoints::Disjoint))
}

fn first(
    pairs: &[Parts<'_>],
    ask: impl FnMut(&Parts<'_>) -> Result<Option<ShapeCastHit>, Unsupported>,
) -> Result<Option<ShapeCastHit>, Unsupported> {
    let found = known_of_all(pairs, ask)?.into_iter().flatten();
    Ok(found.min_by(|a, b| a.time_of_impact.total_cmp(&b.time_of_impact)))
}

pub(crate) fn cast(
    breps: &BrepDispatcher,
    pairs: &[Parts<'_>],
    velocity: Vector,
    options: ShapeCastOptions,
) -> Result<Option<ShapeCastHit>, Unsupported> {
    first(pairs, |p| {
        let (one, two) = (p.one.shape, p.two.shape);
        let own = p
            .one
            .pose
            .map_or(velocity, |pose| pose.rotation.inverse() * velocity);
        let found = p.ask(breps).cast_shapes(&p.pos12, own, one, two, options)?;
        Ok(found.map(|h| p.hit_out(&h)))
    })
}

pub(crate) fn cast_nonlinear(
    breps: &BrepDispatcher,
    pairs: &[Parts<'_>],
    motions: [&NonlinearRigidMotion; 2],
    [start, end]: [f64; 2],
    stop_at_penetration: bool,
) -> Result<Option<ShapeCastHit>, Unsupported> {
    first(pairs, |p| {
        let own = |part: &Part<'_>, whole: &NonlinearRigidMotion| {
            part.pose.map_or(*whole, |pose| whole.prepend(*pose))
        };
        let (one, two) = (own(&p.one, motions[0]), own(&p.two, motions[1]));
        let found = p.ask(breps).cast_shapes_nonlinear(
            &one,
            p.one.shape,
            &two,
            p.two.shape,
            start,
            end,
            stop_at_penetration,
        )?;
        Ok(found.map(|h| p.hit_out(&h)))
    })
}

/// What the manifolds of a pair of parts are made with.
#[derive(Clone, Default)]
struct Slot {
    workspace: Option<ContactManifoldsWorkspace>,
    /// How many there are of them.
    count: usize,
}

/// Of two compounds, in the order of the manifolds.
#[derive(Clone, Default)]
struct CompoundMemory {
    slots: BTreeMap<(u32, u32), Slot>,
}

impl CompoundMemory {
    fn of(slot: &mut Option<ContactManifoldsWorkspace>) -> &mut Self {
        if !slot.as_ref().is_some_and(|w| w.0.is::<Self>()) {
            *slot = None;
        }
        let slot = slot.get_or_insert_with(|| Self::default().into());
        match slot.0.downcast_mut::<Self>() {
            Some(memory) => memory,
            None => unreachable!("it was just made or checked"),
        }
    }
}

impl WorkspaceData for CompoundMemory {
    fn as_typed_workspace_data(&self) -> TypedWorkspaceData<'_> {
        TypedWorkspaceData::Custom
    }

    fn clone_dyn(&self) -> Box<dyn WorkspaceData> {
        Box::new(self.clone())
    }
}

/// The manifolds of each pair of parts, in the order of the parts, with the parts' numbers and poses; what the engine knows of a manifold stays
/// with its pair.
pub(crate) fn manifolds<M, C>(
    breps: &BrepDispatcher,
    pairs: &[Parts<'_>],
    prediction: f64,
    manifolds: &mut Vec<ContactManifold<M, C>>,
    workspace: &mut Option<ContactManifoldsWorkspace>,
) where
    M: Default + Clone + Send + Sync,
    C: Default + Copy + Send + Sync,
{
    let memory = CompoundMemory::of(workspace);
    let mut old = std::mem::take(&mut memory.slots);
    let mut known: BTreeMap<(u32, u32), Vec<ContactManifold<M, C>>> = BTreeMap::new();
    if old.values().map(|s| s.count).sum::<usize>() == manifolds.len() {
        let mut all = manifolds.drain(..);
        for (key, slot) in &old {
            known.insert(*key, all.by_ref().take(slot.count).collect());
        }
    } else {
        // Another dispatcher's: nothing is known of them.
        old.clear();
    }
    manifolds.clear();
    for pair in pairs.iter().filter(|p| p.may_touch(prediction)) {
        let key = (pair.one.number, pair.two.number);
        let mut slot = old.remove(&key).unwrap_or_default();
        let mut own = known.remove(&key).unwrap_or_default();
        let (one, two) = (pair.one.shape, pair.two.shape);
        let ask: &dyn PersistentQueryDispatcher<M, C> = match pair.has_brep() {
            true => breps,
            false => &DefaultQueryDispatcher,
        };
        let workspace = &mut slot.workspace;
        let found = ask.contact_manifolds(&pair.pos12, one, two, prediction, &mut own, workspace);
        if found.is_err() {
            continue;
        }
        for m in &mut own {
            if let Some(pose) = pair.one.pose {
                m.subshape1 = pair.one.number;
                m.set_subshape_pos1(Some(*pose));
            }
            if let Some(pose) = pair.two.pose {
                m.subshape2 = pair.two.number;
                m.set_subshape_pos2(Some(*pose));
            }
        }
        slot.count = own.len();
        memory.slots.insert(key, slot);
        manifolds.append(&mut own);
    }
}
