//! The answer about a BREP and another shape, in the BREP's frame.

use crate::pose::Placement;
use feeler::numeric::Enclosure;
use feeler::query::{Feature, Separation, Undecided, Witness, Workspace};
use nalgebra::{Point3, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::{ContactManifoldsWorkspace, TypedWorkspaceData, WorkspaceData};
use parry3d_f64::shape::PackedFeatureId;

/// Where a shape touches a BREP, or nearly so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairContact {
    /// The point on the BREP, in its frame.
    pub on_brep: Vector,
    /// The point on the other shape, in the BREP's frame.
    pub on_other: Vector,
    /// Unit normal from the BREP to the other shape, in the BREP's frame.
    pub normal: Vector,
    /// Signed gap here, the pose's rounding in the bounds; > 0 apart, < 0 overlapping.
    pub separation: Separation,
    /// What is touched of the BREP: its index of a face or vertex, of an edge 16 times its index and, for a half-space, the number of
    /// the point on it.
    pub feature: PackedFeatureId,
    /// What is touched of the other shape.
    pub feature_other: PackedFeatureId,
}

/// What is known of a BREP and another shape.
#[derive(Clone, Debug, PartialEq)]
pub struct PairAnswer {
    /// The signed gap, the pose's rounding in the bounds.
    pub separation: Separation,
    /// Contacts with a separation within the prediction, the deepest first.
    pub contacts: Vec<PairContact>,
    /// Whether the deepest contact is a continuum, of which there are some points in the list.
    pub continuum: bool,
    /// Set where the kernel could not settle it as exactly as asked. The bounds hold.
    pub undecided: Option<Undecided>,
}

/// A separation whose bounds are wider by a length on both sides.
pub(crate) fn widened(s: Separation, by: f64) -> Separation {
    if by == 0.0 {
        return s;
    }
    Separation {
        value: s.value,
        bounds: Enclosure {
            lo: (s.bounds.lo - by).next_down(),
            hi: (s.bounds.hi + by).next_up(),
        },
    }
}

pub(crate) fn to_point(v: Vector) -> Point3<f64> {
    Point3::new(v.x, v.y, v.z)
}

pub(crate) fn to_vector(v: Vector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

pub(crate) fn from_point(p: &Point3<f64>) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

pub(crate) fn from_vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// Bits of a number within an edge.
pub(crate) const WITHIN: usize = 4;
/// Bits of Parry's feature numbers.
const CODE: u32 = (1 << 30) - 1;

/// A feature as Parry numbers it; `k` counts points on an edge.
pub(crate) fn pack(feature: Feature, k: usize) -> PackedFeatureId {
    let code = |n: usize| (n as u32) & CODE;
    match feature {
        Feature::Face(f) => PackedFeatureId::face(code(f)),
        Feature::Edge(e) => PackedFeatureId::edge(code((e << WITHIN) + k)),
        Feature::Vertex(v) => PackedFeatureId::vertex(code(v)),
    }
}

/// What the queries of one pair of shapes learn from each other.
#[derive(Default)]
pub(crate) struct Memory {
    pub(crate) witness: Witness,
    pub(crate) workspace: Workspace,
}

impl Memory {
    /// The pair's own, made anew if another dispatcher has left its own there.
    pub(crate) fn of(slot: &mut Option<ContactManifoldsWorkspace>) -> &mut Self {
        let ours = slot.as_ref().is_some_and(|w| w.0.is::<Self>());
        if !ours {
            *slot = None;
        }
        let slot = slot.get_or_insert_with(|| Self::default().into());
        match slot.0.downcast_mut::<Self>() {
            Some(memory) => memory,
            None => unreachable!("it was just made or checked"),
        }
    }
}

impl WorkspaceData for Memory {
    fn as_typed_workspace_data(&self) -> TypedWorkspaceData<'_> {
        TypedWorkspaceData::Custom
    }

    fn clone_dyn(&self) -> Box<dyn WorkspaceData> {
        Box::new(Self {
            witness: self.witness.clone(),
            workspace: Workspace::default(),
        })
    }
}

/// What is asked of a pair.
pub(crate) struct Ask<'a> {
    pub(crate) placement: Placement<'a>,
    /// Contacts are wanted up to this separation.
    pub(crate) prediction: f64,
    /// Whether more than the deepest contact is wanted.
    pub(crate) several: bool,
}
