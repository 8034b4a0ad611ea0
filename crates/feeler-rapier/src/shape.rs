//! A BREP as a Parry shape.

use crate::mass::{MassEstimate, estimate};
use crate::pair::{from_point, from_vector, pack, to_point, to_vector};
use feeler::brep::{Brep, BrepParts};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, ContactAnswer, Contacts, Feature, HalfSpace, LineKind, LineProbe, Options, Probe,
    Sphere, Workspace, contact, inside, line,
};
use feeler::trim::Side;
use nalgebra::{Point3, Vector3};
use parry3d_f64::bounding_volume::{Aabb, BoundingSphere};
use parry3d_f64::mass_properties::MassProperties;
use parry3d_f64::math::{Matrix, Vector};
use parry3d_f64::query::{PointProjection, PointQuery, Ray, RayCast, RayIntersection};
use parry3d_f64::shape::{FeatureId, Shape, ShapeType, TypedShape};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

/// Width of enclosures that are asked for, in sizes, unless said otherwise.
const ACCURACY: f64 = 1.0 / (1u64 << 40) as f64;
/// Nodes that one query may spend.
const NODES: usize = 20_000;
/// How exactly the sides of the box are asked for, in sizes: a broad phase wants no more.
const BOX: f64 = 1.0 / (1u64 << 20) as f64;

/// Which contacts of a ball a manifold holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "files", serde(rename_all = "kebab-case"))]
pub enum Several {
    /// The deepest alone.
    Deepest,
    /// The deepest, and of each other face that comes near its nearest point, if it is a contact: microseconds a face.
    #[default]
    PerFace,
    /// All that the kernel finds ([`Contacts::All`]): milliseconds and more.
    All,
}

/// Why a BREP cannot be a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShapeError {
    /// It has no faces, or none with points.
    #[error("the BREP has no points: nothing can touch it")]
    Empty,
    /// No finite box around it is known.
    #[error("no finite box around the BREP is known")]
    Unbounded,
}

/// A single face, as a BREP of its own.
pub(crate) struct FaceAlone {
    brep: PreparedBrep,
    /// Its edges and vertices in the whole.
    edges: Vec<usize>,
    face: usize,
}

struct Inner {
    brep: Arc<PreparedBrep>,
    aabb: Aabb,
    mass: OnceLock<MassEstimate>,
    faces: Vec<OnceLock<Option<FaceAlone>>>,
    face_boxes: Vec<OnceLock<Aabb>>,
    vertex_faces: OnceLock<Vec<Vec<usize>>>,
    points: OnceLock<Vec<BorderPoint>>,
    undecided: AtomicU64,
    /// Whether a scale has been refused aloud.
    said: AtomicBool,
    #[cfg(feature = "files")]
    source: Option<crate::file::Source>,
}

/// A point of the BREP on one of its edges or vertices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BorderPoint {
    pub(crate) point: Vector,
    /// Its distance from a true point of the BREP: rounding, to first order.
    pub(crate) bound: f64,
    pub(crate) feature: Feature,
    pub(crate) number: usize,
}

/// A BREP as a Parry shape. A clone shares everything.
///
/// Lengths are in the model's units; a closed BREP is solid, an open one a sheet without inside or mass.
#[derive(Clone)]
pub struct BrepShape {
    inner: Arc<Inner>,
    accuracy: f64,
    several: Several,
}

impl std::fmt::Debug for BrepShape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BrepShape")
            .field("faces", &self.inner.brep.brep().faces().len())
            .field("aabb", &self.inner.aabb)
            .field("accuracy", &self.accuracy)
            .field("several", &self.several)
            .finish()
    }
}

impl BrepShape {
    /// A shape around a BREP. Finds its box by six queries; the rest is made when it is needed.
    ///
    /// # Errors
    /// The BREP has no points, or no finite box around it is known.
    pub fn new(brep: Arc<PreparedBrep>) -> Result<Self, ShapeError> {
        Self::with_source(
            brep,
            #[cfg(feature = "files")]
            None,
        )
    }

    pub(crate) fn with_source(
        brep: Arc<PreparedBrep>,
        #[cfg(feature = "files")] source: Option<crate::file::Source>,
    ) -> Result<Self, ShapeError> {
        let aabb = aabb(&brep)?;
        let slots = brep.brep().faces().len();
        let accuracy = ACCURACY * brep.size();
        Ok(Self {
            inner: Arc::new(Inner {
                aabb,
                mass: OnceLock::new(),
                faces: (0..slots).map(|_| OnceLock::new()).collect(),
                face_boxes: (0..slots).map(|_| OnceLock::new()).collect(),
                vertex_faces: OnceLock::new(),
                points: OnceLock::new(),
                undecided: AtomicU64::new(0),
                said: AtomicBool::new(false),
                #[cfg(feature = "files")]
                source,
                brep,
            }),
            accuracy,
            several: Several::default(),
        })
    }

    /// The same, with enclosures no wider than this length; 2^-40 of the size unless said. The engine gets the middle.
    #[must_use]
    pub fn with_accuracy(mut self, accuracy: f64) -> Self {
        self.accuracy = accuracy;
        self
    }

    /// The same, with other contacts of balls in its manifolds.
    #[must_use]
    pub fn with_several(mut self, several: Several) -> Self {
        self.several = several;
        self
    }

    /// The BREP.
    pub fn brep(&self) -> &Arc<PreparedBrep> {
        &self.inner.brep
    }

    /// Volume and moments of the solid. Made at the first call, in milliseconds a face.
    pub fn mass(&self) -> &MassEstimate {
        let make = || estimate(&self.inner.brep);
        self.inner.mass.get_or_init(make)
    }

    /// How many answers of this shape and its clones fell short of the accuracy, or left open on which side a ball's centre is.
    pub fn undecided(&self) -> u64 {
        self.inner.undecided.load(Ordering::Relaxed)
    }

    pub(crate) fn note_undecided(&self) {
        self.inner.undecided.fetch_add(1, Ordering::Relaxed);
    }

    #[cfg(feature = "files")]
    pub(crate) fn source(&self) -> Option<&crate::file::Source> {
        self.inner.source.as_ref()
    }

    pub(crate) fn accuracy(&self) -> f64 {
        self.accuracy
    }

    pub(crate) fn several(&self) -> Several {
        self.several
    }

    pub(crate) fn options(&self, prediction: f64, contacts: Contacts) -> Options {
        Options {
            accuracy: Accuracy::Length(self.accuracy),
            prediction,
            contacts,
            node_budget: NODES,
        }
    }

    pub(crate) fn aabb(&self) -> &Aabb {
        &self.inner.aabb
    }

    /// A face on its own. It is made of parts that have been checked, so that it is always there; if it were not, each query that
    /// misses it would count as undecided.
    pub(crate) fn face_alone(&self, face: usize) -> Option<&FaceAlone> {
        let slot = &self.inner.faces[face];
        let made = slot.get_or_init(|| FaceAlone::new(self.inner.brep.brep(), face));
        if made.is_none() {
            self.note_undecided();
        }
        made.as_ref()
    }

    /// Whether a face may come as near to a point as this.
    pub(crate) fn is_face_near(&self, face: usize, point: &Point3<f64>, reach: f64) -> bool {
        let make = || {
            let own = self.face_alone(face).map(|f| aabb(&f.brep));
            own.and_then(Result::ok).unwrap_or(self.inner.aabb)
        };
        let b = self.inner.face_boxes[face].get_or_init(make);
        let p = Vector::new(point.x, point.y, point.z);
        let (low, high) = (b.mins - p, p - b.maxs);
        // Differences are rounded; what is lost is less than what an ulp more of reach brings back.
        let within = |off: f64| off <= reach.next_up();
        (0..3).all(|c| within(low[c]) && within(high[c]))
    }

    pub(crate) fn faces_at_edge(&self, edge: usize) -> Vec<usize> {
        let brep = self.inner.brep.brep();
        let of = |t: &usize| brep.parts().loops[brep.parts().trims[*t].trim_loop].face;
        let mut faces: Vec<usize> = brep.parts().edges[edge].trims.iter().map(of).collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    }

    pub(crate) fn faces_at_vertex(&self, vertex: usize) -> Vec<usize> {
        let make = || {
            let parts = self.inner.brep.brep().parts();
            let mut faces = vec![Vec::new(); parts.vertices.len()];
            for trim in &parts.trims {
                for v in trim.vertices {
                    faces[v].push(parts.loops[trim.trim_loop].face);
                }
            }
            for list in &mut faces {
                list.sort_unstable();
                list.dedup();
            }
            faces
        };
        self.inner.vertex_faces.get_or_init(make)[vertex].clone()
    }

    /// Points along all edges.
    pub(crate) fn border_points(&self) -> &[BorderPoint] {
        let make = || border_points(self.inner.brep.brep());
        self.inner.points.get_or_init(make)
    }

    fn nearest(&self, point: Vector) -> Option<ContactAnswer> {
        let probe = Probe::Sphere(Sphere::new(to_point(point), 0.0).ok()?);
        let options = self.options(f64::INFINITY, Contacts::Deepest);
        let answer = contact(self.brep(), &probe, &options, &mut Workspace::default());
        if answer.undecided.is_some() {
            self.note_undecided();
        }
        (!answer.contacts.is_empty()).then_some(answer)
    }
}

impl FaceAlone {
    fn new(brep: &Brep, face: usize) -> Option<Self> {
        let parts = brep.parts();
        let mut own = BrepParts::default();
        let mut edges = Vec::new();
        let mut kept = parts.faces[face].clone();
        own.surfaces.push(parts.surfaces[kept.surface].clone());
        kept.surface = 0;
        // Vertices keep their numbers: they are few, and name the same places.
        own.vertices = parts.vertices.clone();
        own.vertices.iter_mut().for_each(|v| v.edges.clear());
        if let Some(loops) = &mut kept.loops {
            for own_loop in loops.iter_mut() {
                let mut l = parts.loops[*own_loop].clone();
                l.face = 0;
                for t in &mut l.trims {
                    let mut trim = parts.trims[*t].clone();
                    own.curves2.push(parts.curves2[trim.curve].clone());
                    trim.curve = own.curves2.len() - 1;
                    trim.trim_loop = own.loops.len();
                    let number = own.trims.len();
                    if let Some(edge) = trim.edge {
                        // One for each trim: an edge used once makes no solid of a face that closes upon itself.
                        let mut made = parts.edges[edge].clone();
                        made.trims = vec![number];
                        if let Some(curve) = made.curve {
                            own.curves3.push(parts.curves3[curve].clone());
                            made.curve = Some(own.curves3.len() - 1);
                        }
                        let [start, end] = made.vertices;
                        own.vertices[start].edges.push(edges.len());
                        if end != start {
                            own.vertices[end].edges.push(edges.len());
                        }
                        own.edges.push(made);
                        edges.push(edge);
                        trim.edge = Some(edges.len() - 1);
                    }
                    own.trims.push(trim);
                    *t = number;
                }
                *own_loop = own.loops.len();
                own.loops.push(l);
            }
        }
        own.faces.push(kept);
        let brep = PreparedBrep::new(Brep::new(own).ok()?);
        Some(Self { brep, edges, face })
    }

    pub(crate) fn brep(&self) -> &PreparedBrep {
        &self.brep
    }

    /// A feature of the face alone as one of the whole.
    pub(crate) fn feature(&self, own: Feature) -> Feature {
        match own {
            Feature::Face(_) => Feature::Face(self.face),
            Feature::Edge(e) => Feature::Edge(self.edges[e]),
            Feature::Vertex(v) => Feature::Vertex(v),
        }
    }
}

/// A box around the trimmed faces, from six half-spaces: the lower end of the separation from `n.x <= 0` is below n.x.
fn aabb(brep: &PreparedBrep) -> Result<Aabb, ShapeError> {
    let options = Options {
        accuracy: Accuracy::Length(BOX * brep.size()),
        prediction: 0.0,
        contacts: Contacts::None,
        node_budget: NODES,
    };
    let mut workspace = Workspace::default();
    let mut least = |normal: Vector3<f64>| {
        let probe = Probe::HalfSpace(HalfSpace {
            normal,
            offset: 0.0,
        });
        contact(brep, &probe, &options, &mut workspace)
            .separation
            .bounds
            .lo
    };
    let (mut mins, mut maxs) = ([0.0; 3], [0.0; 3]);
    for c in 0..3 {
        let axis = Vector3::from_fn(|k, _| f64::from(u8::from(k == c)));
        mins[c] = least(axis);
        maxs[c] = -least(-axis);
    }
    // Nothing is infinitely far away.
    if mins.contains(&f64::INFINITY) {
        return Err(ShapeError::Empty);
    }
    if mins.iter().chain(&maxs).any(|x| !x.is_finite()) {
        return Err(ShapeError::Unbounded);
    }
    Ok(Aabb::new(mins.into(), maxs.into()))
}

/// Points on each edge, its ends left out: they are vertices.
const ON_EDGE: usize = 7;

/// On the image of one trim of each edge, and at its vertices.
fn border_points(brep: &Brep) -> Vec<BorderPoint> {
    let parts = brep.parts();
    let mut out = Vec::new();
    let mut seen = vec![false; parts.vertices.len()];
    for (number, edge) in parts.edges.iter().enumerate() {
        let Some(trim) = edge.trims.first().map(|t| &parts.trims[*t]) else {
            continue;
        };
        let face = parts.loops[trim.trim_loop].face;
        let surface = brep.surface(face);
        for k in 0..=ON_EDGE + 1 {
            let feature = if k == 0 || k == ON_EDGE + 1 {
                let vertex = trim.vertices[usize::from(k > 0)];
                if std::mem::replace(&mut seen[vertex], true) {
                    continue;
                }
                Feature::Vertex(vertex)
            } else {
                Feature::Edge(number)
            };
            let t = k as f64 / (ON_EDGE + 1) as f64;
            let t = if trim.reversed { 1.0 - t } else { t };
            let (uv, uv_bound) = parts.curves2[trim.curve].point_with_bound(trim.span.lerp(t));
            let at = surface.first_derivatives_with_bound(uv.x, uv.y);
            // The surface at the rounded uv: off the image of the true uv by this, to first order, twice to be safe.
            let beside = 2.0 * uv_bound * (at.du.norm() + at.dv.norm());
            let bound = 2.0 * (at.bound + beside);
            out.push(BorderPoint {
                point: from_point(&at.point),
                bound,
                feature,
                number: k,
            });
        }
    }
    out
}

impl BrepShape {
    #[cfg(feature = "files")]
    fn scaled(&self, by: Vector) -> Option<Self> {
        let scaled = crate::file::scaled(self.brep().brep(), by)?;
        let shape = Self::new(Arc::new(PreparedBrep::new(scaled))).ok()?;
        let accuracy = self.accuracy * by.x.abs();
        Some(shape.with_accuracy(accuracy).with_several(self.several))
    }

    #[cfg(not(feature = "files"))]
    fn scaled(&self, _: Vector) -> Option<Self> {
        None
    }
}

impl PointQuery for BrepShape {
    fn project_local_point(&self, pt: Vector, solid: bool) -> PointProjection {
        self.project(pt, solid).0
    }

    fn project_local_point_and_get_feature(&self, pt: Vector) -> (PointProjection, FeatureId) {
        self.project(pt, false)
    }
}

impl BrepShape {
    fn project(&self, pt: Vector, solid: bool) -> (PointProjection, FeatureId) {
        let Some(answer) = self.nearest(pt) else {
            // Parry has no word for it; a point that is not finite ends here.
            let nowhere = PointProjection::new(false, Vector::splat(f64::MAX));
            return (nowhere, FeatureId::Unknown);
        };
        let c = &answer.contacts[0];
        // On the face counts as inside, as in Parry.
        let is_inside = answer.separation.value <= 0.0;
        let point = if is_inside && solid {
            pt
        } else {
            from_point(&c.on_brep)
        };
        (
            PointProjection::new(is_inside, point),
            pack(c.feature, 0).unpack(),
        )
    }
}

impl RayCast for BrepShape {
    fn cast_local_ray_and_get_normal(
        &self,
        ray: &Ray,
        max_time_of_impact: f64,
        solid: bool,
    ) -> Option<RayIntersection> {
        let mut workspace = Workspace::default();
        let (origin, direction) = (to_point(ray.origin), to_vector(ray.dir));
        let probe = LineProbe::new(origin, direction, LineKind::Ray).ok()?;
        if solid && self.brep().brep().is_closed() {
            let side = inside(self.brep(), origin, &mut workspace).side;
            if side.is_none() {
                self.note_undecided();
            }
            if matches!(side, Some(Side::Inside | Side::Boundary)) {
                return Some(RayIntersection::new(0.0, Vector::ZERO, FeatureId::Unknown));
            }
        }
        let options = self.options(0.0, Contacts::Deepest);
        let answer = line(self.brep(), &probe, &options, &mut workspace);
        if answer.undecided.is_some() {
            self.note_undecided();
        }
        let hit = answer.hits.first()?;
        if hit.t.value > max_time_of_impact {
            return None;
        }
        // Against the ray, as Parry's other shapes have it.
        let normal = if hit.normal.dot(&direction) > 0.0 {
            -hit.normal
        } else {
            hit.normal
        };
        let feature = pack(hit.feature, 0).unpack();
        Some(RayIntersection::new(
            hit.t.value.max(0.0),
            from_vector(&normal),
            feature,
        ))
    }
}

impl Shape for BrepShape {
    fn compute_local_aabb(&self) -> Aabb {
        self.inner.aabb
    }

    fn compute_local_bounding_sphere(&self) -> BoundingSphere {
        let b = &self.inner.aabb;
        let radius = b.half_extents().length() * (1.0 + 8.0 * f64::EPSILON);
        BoundingSphere::new(b.center(), radius)
    }

    fn clone_dyn(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    /// By a power of two, the same along all axes but for the sign, a BREP scales exactly (with the feature `files`; without, by 1 alone). Other
    /// scales are refused, once aloud on standard error: the BREP would have other, rounded numbers.
    fn scale_dyn(&self, scale: Vector, _num_subdivisions: u32) -> Option<Box<dyn Shape>> {
        if scale == Vector::splat(1.0) {
            return Some(self.clone_dyn());
        }
        let scaled = self.scaled(scale);
        if scaled.is_none() && !self.inner.said.swap(true, Ordering::Relaxed) {
            eprintln!(
                "feeler-rapier: a BREP is not scaled by {scale}: it would be rounded; take a power of two along all axes, or scale the model                  (said once for this BREP)"
            );
        }
        scaled.map(|s| Box::new(s) as Box<dyn Shape>)
    }

    /// Of a closed BREP, from [`BrepShape::mass`]: approximate, with the error stated there. An open one has none.
    fn mass_properties(&self, density: f64) -> MassProperties {
        if density == 0.0 || !self.brep().brep().is_closed() {
            return MassProperties::default();
        }
        let m = self.mass();
        let inertia = Matrix::from_cols_array_2d(&m.inertia) * density;
        MassProperties::with_inertia_matrix(m.center.into(), m.volume * density, inertia)
    }

    fn shape_type(&self) -> ShapeType {
        ShapeType::Custom
    }

    fn as_typed_shape(&self) -> TypedShape<'_> {
        TypedShape::Custom(self)
    }

    fn ccd_thickness(&self) -> f64 {
        // A sheet has none.
        0.0
    }

    fn ccd_angular_thickness(&self) -> f64 {
        std::f64::consts::FRAC_PI_4
    }
}
