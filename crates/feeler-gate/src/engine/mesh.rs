//! A triangle mesh in parry: what physics engines do with a smooth part today.
//!
//! The mesh is [our own](crate::tessellate); the queries are `parry3d-f64`'s: its tree of boxes, its projection of a
//! point on the mesh, its intersection of a ray with a triangle, and its pseudo-normals for the side (J. A. Bærentzen and
//! H. Aanæs, *Signed Distance Computation Using the Angle Weighted Pseudonormal*, 2005). All hits of a line and the
//! lowest vertex along a normal are found by walking parry's tree, since it has no such query of its own.
//!
//! Values are those of the mesh and carry no bounds. It treats no question about a face's parameters, and of all contacts it knows
//! the deepest alone.

use super::{Engine, value_alone};
use crate::tessellate::{Rule, tessellate};
use feeler::query::{Contacts, Feature, HalfSpace, LineKind, LineProbe, Probe, Sphere};
use feeler::trim::Side;
use feeler_corpus::{Answer, Ask, Body, ContactLine, HitLine, Hits, Model, Query};
use nalgebra::{Point3, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::TraversalAction;
use parry3d_f64::query::details::local_ray_intersection_with_triangle;
use parry3d_f64::query::{PointQueryWithLocation, Ray};
use parry3d_f64::shape::{TriMesh, TriMeshFlags};

/// Two hits nearer than this part of the size that cross in the same way are one, on an edge of the mesh.
const SAME_HIT: f64 = 1e-12;

/// One BREP as a mesh.
struct Part {
    mesh: TriMesh,
    /// The face of each triangle, counted through the model.
    faces: Vec<u32>,
    closed: bool,
}

/// Triangles in `parry3d-f64`.
pub struct MeshEngine {
    degrees: f64,
    parts: Vec<Part>,
    size: f64,
    chord_error: f64,
}

/// A place on the mesh.
#[derive(Clone, Copy)]
struct Found {
    value: f64,
    on_brep: Point3<f64>,
    normal: Vector3<f64>,
    face: u32,
}

fn to_parry(p: &Vector3<f64>) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

fn from_parry(p: Vector) -> Vector3<f64> {
    Vector3::new(p.x, p.y, p.z)
}

impl MeshEngine {
    /// An engine whose meshes have this angle between neighbouring normals: see [`Rule`].
    pub fn new(degrees: f64) -> Self {
        Self {
            degrees,
            parts: Vec::new(),
            size: 0.0,
            chord_error: 0.0,
        }
    }

    /// How many triangles the open model has.
    pub fn triangles(&self) -> usize {
        self.parts.iter().map(|p| p.faces.len()).sum()
    }

    /// The largest distance found between the open model and its mesh, in model units; sampled.
    pub fn chord_error(&self) -> f64 {
        self.chord_error
    }

    /// The nearest place; its value is the distance, negative inside.
    fn nearest(&self, center: &Point3<f64>) -> Option<Found> {
        let one = |part: &Part| {
            let at = to_parry(&center.coords);
            let (foot, (triangle, _)) = part.mesh.project_local_point_and_get_location(at, false);
            let on_brep = Point3::from(from_parry(foot.point));
            let way = center - on_brep;
            let distance = way.norm();
            let inside = part.closed && foot.is_inside && distance > 0.0;
            let normal = if distance > 0.0 {
                way / if inside { -distance } else { distance }
            } else {
                part.normal(triangle)
            };
            Found {
                value: if inside { -distance } else { distance },
                on_brep,
                normal,
                face: part.faces[triangle as usize],
            }
        };
        let all = self.parts.iter().map(one);
        all.min_by(|a, b| a.value.total_cmp(&b.value))
    }

    /// The place least along a normal; its value is n.x.
    fn lowest(&self, n: &Vector3<f64>) -> Option<Found> {
        let mut best: Option<Found> = None;
        for part in &self.parts {
            let mut least = best.map_or(f64::INFINITY, |b| b.value);
            let mut found = None;
            part.mesh.bvh().traverse(|node| {
                let (lo, hi) = (from_parry(node.mins()), from_parry(node.maxs()));
                let low: f64 = (0..3).map(|k| (n[k] * lo[k]).min(n[k] * hi[k])).sum();
                if low >= least {
                    return TraversalAction::Prune;
                }
                if let Some(triangle) = node.leaf_data() {
                    let t = part.mesh.triangle(triangle);
                    for corner in [t.a, t.b, t.c] {
                        let p = from_parry(corner);
                        if n.dot(&p) < least {
                            least = n.dot(&p);
                            found = Some((triangle, p));
                        }
                    }
                }
                TraversalAction::Continue
            });
            if let Some((triangle, p)) = found {
                best = Some(Found {
                    value: least,
                    on_brep: p.into(),
                    // From the BREP into the half-space.
                    normal: -n,
                    face: part.faces[triangle as usize],
                });
            }
        }
        best
    }

    fn contact(&self, probe: &Probe, query: &Query) -> Option<Body> {
        let (found, value, on_probe) = match probe {
            Probe::Sphere(Sphere { center, radius }) => {
                let found = self.nearest(center)?;
                (found, found.value - radius, center - found.normal * *radius)
            }
            Probe::HalfSpace(HalfSpace { normal, offset }) => {
                let found = self.lowest(normal)?;
                let value = found.value - offset;
                (found, value, found.on_brep - normal * value)
            }
        };
        if query.overlap {
            return Some(Body::Overlap {
                overlap: Some(value < 0.0),
                undecided: None,
            });
        }
        let separation = value_alone(value);
        let wanted = query.contacts != Some(Contacts::None);
        let mut contacts = Vec::new();
        if wanted && value <= query.prediction.unwrap_or(0.0) {
            contacts.push(ContactLine {
                on_brep: found.on_brep.coords.into(),
                on_probe: on_probe.coords.into(),
                normal: found.normal.into(),
                separation,
                feature: Some(Feature::Face(found.face as usize)),
                uv: None,
                position_bound: None,
                normal_bound: None,
                normal_is_choice: false,
            });
        }
        Some(Body::Contact {
            separation,
            continuum: None,
            contacts,
            undecided: None,
        })
    }

    fn line(&self, line: &LineProbe, wanted: Hits) -> Body {
        let mut hits: Vec<(f64, Vector3<f64>, u32)> = Vec::new();
        for part in &self.parts {
            part.hits(line, &mut hits);
        }
        hits.sort_by(|a, b| a.0.total_cmp(&b.0));
        let same = SAME_HIT * self.size / line.direction.norm();
        hits.dedup_by(|b, a| {
            let way = |n: &Vector3<f64>| n.dot(&line.direction) > 0.0;
            b.0 - a.0 <= same && way(&a.1) == way(&b.1)
        });
        hits.retain(|(t, _, _)| match line.kind {
            LineKind::Line => true,
            LineKind::Ray => *t >= 0.0,
            LineKind::Segment => (0.0..=1.0).contains(t),
        });
        let crossings = Some(hits.len());
        if wanted != Hits::All {
            hits.truncate(1);
        }
        let hit = |(t, normal, face): &(f64, Vector3<f64>, u32)| HitLine {
            t: value_alone(*t),
            t_end: None,
            point: (line.origin + line.direction * *t).coords.into(),
            normal: (*normal).into(),
            feature: Some(Feature::Face(*face as usize)),
            uv: None,
            tangential: None,
        };
        Body::Line {
            hits: hits.iter().map(hit).collect(),
            crossings,
            in_crack: None,
            undecided: None,
        }
    }

    fn inside(&self, point: &Point3<f64>) -> Body {
        let within = |p: &Part| {
            let at = to_parry(&point.coords);
            p.closed
                && p.mesh
                    .project_local_point_and_get_location(at, false)
                    .0
                    .is_inside
        };
        Body::Side {
            side: Some(match self.parts.iter().any(within) {
                true => Side::Inside,
                false => Side::Outside,
            }),
            in_gap: None,
            undecided: None,
        }
    }
}

impl Part {
    fn normal(&self, triangle: u32) -> Vector3<f64> {
        let normal = self.mesh.triangle(triangle).normal();
        normal.map_or(Vector3::z(), from_parry)
    }

    /// All hits of the whole line: parameter, normal and face.
    fn hits(&self, line: &LineProbe, hits: &mut Vec<(f64, Vector3<f64>, u32)>) {
        // parry knows rays only: one that starts before the box.
        let root = self.mesh.local_aabb();
        let way = line.direction.norm_squared();
        let middle = from_parry((root.mins + root.maxs) * 0.5);
        let reach = (root.maxs - root.mins).length() / way.sqrt();
        let start = (middle - line.origin.coords).dot(&line.direction) / way - reach;
        let origin = line.origin.coords + line.direction * start;
        let ray = Ray::new(to_parry(&origin), to_parry(&line.direction));
        self.mesh.bvh().traverse(|node| {
            if node.cast_ray(&ray, f64::MAX) == f64::MAX {
                return TraversalAction::Prune;
            }
            if let Some(triangle) = node.leaf_data() {
                let t = self.mesh.triangle(triangle);
                if let Some((hit, _)) = local_ray_intersection_with_triangle(t.a, t.b, t.c, &ray) {
                    let face = self.faces[triangle as usize];
                    hits.push((start + hit.time_of_impact, self.normal(triangle), face));
                }
            }
            TraversalAction::Continue
        });
    }
}

impl Engine for MeshEngine {
    fn name(&self) -> String {
        format!("parry3d-f64 0.31, mesh of {} degrees", self.degrees)
    }

    fn open(&mut self, model: &Model) -> Result<(), String> {
        self.parts.clear();
        (self.size, self.chord_error) = (0.0, 0.0);
        let rule = Rule {
            degrees: self.degrees,
            chord: f64::INFINITY,
        };
        let mut faces = 0;
        for brep in &model.breps {
            let mesh = tessellate(brep, &rule)?;
            self.chord_error = self.chord_error.max(mesh.chord_error);
            let first = faces;
            faces += brep.faces().len() as u32;
            if mesh.triangles.is_empty() {
                continue;
            }
            let vertices = mesh.vertices.into_iter().map(Vector::from_array).collect();
            let flags = TriMeshFlags::ORIENTED;
            let shape = TriMesh::with_flags(vertices, mesh.triangles, flags)
                .map_err(|e| format!("parry refuses the mesh: {e}"))?;
            let aabb = shape.local_aabb();
            self.size = self.size.max((aabb.maxs - aabb.mins).max_element());
            self.parts.push(Part {
                mesh: shape,
                faces: mesh.faces.into_iter().map(|f| f + first).collect(),
                closed: brep.is_closed(),
            });
        }
        match self.parts.is_empty() {
            true => Err("no triangle is left of the model".into()),
            false => Ok(()),
        }
    }

    fn answer(&mut self, query: &Query) -> Answer {
        let not_treated = || Body::Error {
            error: "a mesh knows no faces and their parameters".into(),
        };
        let empty = || Body::Error {
            error: "no model is open".into(),
        };
        let body = match &query.ask {
            Ask::Contact(probe) => self.contact(probe, query).unwrap_or_else(empty),
            Ask::Line(line) => self.line(line, query.hits),
            Ask::Inside(point) => self.inside(point),
            Ask::Arrival(..) => Body::Error {
                error: "a mesh is asked about no motion here".into(),
            },
            Ask::Side(..) | Ask::Evaluate(..) | Ask::Split(..) => not_treated(),
        };
        Answer {
            id: query.id.clone(),
            body,
        }
    }

    fn treats(&self, query: &Query) -> bool {
        match query.ask {
            Ask::Contact(_) => query.contacts != Some(Contacts::All),
            Ask::Line(_) | Ask::Inside(_) => true,
            Ask::Arrival(..) | Ask::Side(..) | Ask::Evaluate(..) | Ask::Split(..) => false,
        }
    }

    fn triangles(&self) -> Option<usize> {
        // The inherent one.
        Some(Self::triangles(self))
    }

    fn memory(&self) -> Option<usize> {
        let bytes = |p: &Part| p.mesh.total_memory_size() + p.faces.capacity() * size_of::<u32>();
        Some(self.parts.iter().map(bytes).sum())
    }
}
