//! What the experiments have in common.

use crate::{BrepDispatcher, BrepShape};
use feeler::brep::Brep;
use feeler::prepare::PreparedBrep;
use feeler_gate::tessellate::{Rule, tessellate};
use parry3d_f64::query::{DefaultQueryDispatcher, QueryDispatcher};
use parry3d_f64::shape::TriMeshFlags;
use rapier3d_f64::prelude::*;
use std::sync::Arc;

/// Softness of contacts: hertz, for Rapier's soft constraints.
pub(super) const HERTZ: f64 = 1000.0;

/// Their damping ratio: Rapier's 10 pushes bodies apart ten times as slowly.
pub(super) const DAMPING: f64 = 1.0;

/// A BREP or triangles for it.
#[derive(Clone)]
pub(super) struct Body {
    pub(super) name: String,
    pub(super) shape: SharedShape,
    pub(super) triangles: Option<usize>,
}

pub(super) fn brep_body(brep: Brep) -> Result<(Body, BrepShape), String> {
    let shape = BrepShape::new(Arc::new(PreparedBrep::new(brep))).map_err(|e| e.to_string())?;
    let body = Body {
        name: "BREP".to_owned(),
        shape: SharedShape::new(shape.clone()),
        triangles: None,
    };
    Ok((body, shape))
}

/// What is done about the inner edges of a mesh, and on which side of it the ball is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Edges {
    /// Nothing.
    Plain,
    /// Parry's `FIX_INTERNAL_EDGES`: normals of contacts are kept within the fan of those of the triangles around. It needs
    /// to know the outer side: that of the face's normal, or the other one.
    Fixed { turned: bool },
}

pub(super) fn mesh_body(brep: &Brep, degrees: f64, edges: Edges) -> Result<Body, String> {
    let rule = Rule {
        degrees,
        chord: f64::INFINITY,
    };
    let mesh = tessellate(brep, &rule)?;
    let points = mesh.vertices.iter().map(|v| Vector::from_array(*v));
    let count = mesh.triangles.len();
    let mut triangles = mesh.triangles;
    let mut name = format!("{degrees} degree mesh");
    let flags = match edges {
        Edges::Plain => TriMeshFlags::empty(),
        Edges::Fixed { turned } => {
            if turned {
                triangles.iter_mut().for_each(|t| t.swap(1, 2));
            }
            name += ", inner edges fixed";
            // Faces have corners of their own where they close upon themselves.
            TriMeshFlags::FIX_INTERNAL_EDGES | TriMeshFlags::MERGE_DUPLICATE_VERTICES
        }
    };
    let shape = SharedShape::trimesh_with_flags(points.collect(), triangles, flags);
    Ok(Body {
        name,
        shape: shape.map_err(|e| e.to_string())?,
        triangles: Some(count),
    })
}

/// Gravity along -z. The same for BREP and mesh but for clustering, which is Rapier's own remedy for many contacts of a
/// mesh and would only blur the normals of a BREP.
pub(super) fn world(gravity: f64, unit: f64, dt: f64, body: &Body) -> PhysicsWorld {
    let mut w = PhysicsWorld::new();
    w.narrow_phase
        .set_query_dispatcher(BrepDispatcher::new().chain(DefaultQueryDispatcher));
    w.gravity = Vector::new(0.0, 0.0, -gravity);
    let p = &mut w.integration_parameters;
    p.dt = dt;
    p.length_unit = unit;
    p.contact_recycling = false;
    p.contact_clustering = body.triangles.is_some();
    p.friction_model = FrictionModel::Coulomb;
    p.normalized_allowed_linear_error = 1e-6;
    let softness = SpringCoefficients::new(HERTZ, DAMPING);
    (p.contact_softness, p.static_contact_softness) = (softness, softness);
    w
}
