//! Making BREPs by hand.

use super::{
    Brep, BrepError, BrepParts, Edge, Face, Iso, LoopKind, TrimCurve, TrimKind, TrimLoop, Vertex,
};
use crate::numeric::Interval;
use crate::nurbs::{Curve, Curve2, Curve3, GeometryError, Line, Plane, Surface};
use nalgebra::{Point2, Point3, Vector3};
use std::collections::BTreeMap;

/// Why a face or BREP cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// There is no such vertex.
    #[error("vertex {vertex} was not added; there are {count}")]
    Vertex {
        /// Its number.
        vertex: usize,
        /// How many there are.
        count: usize,
    },
    /// There is no such edge.
    #[error("edge {edge} was not added; there are {count}")]
    Edge {
        /// Its number.
        edge: usize,
        /// How many there are.
        count: usize,
    },
    /// A loop too short, or a face without loops.
    #[error("a loop of {found} vertices bounds nothing: at least {needed} are needed")]
    Loop {
        /// How many it has.
        found: usize,
        /// How many are needed.
        needed: usize,
    },
    /// A trim whose ends are not those of its edge.
    #[error("a trim from vertex {from} to {to} cannot use edge {edge} from {} to {}", .ends[0], .ends[1])]
    Ends {
        /// Start vertex of the trim.
        from: usize,
        /// End vertex of the trim.
        to: usize,
        /// The edge.
        edge: usize,
        /// The edge's vertices.
        ends: [usize; 2],
    },
    /// The outer loop encloses no area on its surface.
    #[error("the outer loop encloses no area")]
    NoArea,
    /// Pieces of geometry that cannot be.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The whole is refused.
    #[error(transparent)]
    Brep(#[from] BrepError),
}

/// One trim of a loop, for [`BrepBuilder::face_with_trims`].
#[derive(Clone, Debug, PartialEq)]
pub struct TrimSpec {
    /// Start and end vertex in the direction of the loop.
    pub vertices: [usize; 2],
    /// The curve in uv over its whole domain, in the direction of the loop.
    pub curve: Curve2,
    /// The edge; `None` for a singular trim.
    pub edge: Option<usize>,
}

/// Builds a [`Brep`] from vertices, edges and faces. Straight edges are made where faces need them, and
/// shared by all faces that join the same two vertices; curves in uv of straight
/// edges on planes are made too.
///
/// The unit cube; each face is given by its corners, counter-clockwise seen from outside:
///
/// ```
/// use feeler::brep::BrepBuilder;
///
/// let mut cube = BrepBuilder::new();
/// for i in 0..8 {
///     let [x, y, z] = [i & 1, i >> 1 & 1, i >> 2].map(f64::from);
///     cube.vertex([x, y, z]);
/// }
/// for corners in [
///     [0, 2, 3, 1], // bottom
///     [4, 5, 7, 6], // top
///     [0, 1, 5, 4],
///     [1, 3, 7, 5],
///     [3, 2, 6, 7],
///     [2, 0, 4, 6],
/// ] {
///     cube.planar_face(&corners)?;
/// }
/// let cube = cube.build()?;
///
/// assert_eq!(cube.parts().edges.len(), 12);
/// assert!(cube.is_closed());
/// assert!(cube.defects().is_empty());
/// # Ok::<(), feeler::brep::BuildError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct BrepBuilder {
    parts: BrepParts,
    /// Straight edges by their vertices, the smaller first.
    straight: BTreeMap<[usize; 2], usize>,
}

/// The domain of all curves made here.
const UNIT: Interval = Interval {
    start: 0.0,
    end: 1.0,
};

impl BrepBuilder {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a vertex; its number, counting from 0.
    pub fn vertex(&mut self, point: impl Into<Point3<f64>>) -> usize {
        self.parts.vertices.push(Vertex {
            point: point.into(),
            edges: Vec::new(),
            tolerance: None,
        });
        self.parts.vertices.len() - 1
    }

    /// Adds an edge along the whole of a curve from one vertex to another; its number. Straight edges
    /// between vertices need not be added.
    pub fn edge(&mut self, vertices: [usize; 2], curve: Curve3) -> Result<usize, BuildError> {
        for v in vertices {
            self.check_vertex(v)?;
        }
        let span = curve.domain();
        self.parts.curves3.push(curve);
        let edge = self.parts.edges.len();
        self.parts.edges.push(Edge {
            curve: Some(self.parts.curves3.len() - 1),
            span,
            reversed: false,
            vertices,
            trims: Vec::new(),
            tolerance: None,
        });
        for v in vertices {
            let edges = &mut self.parts.vertices[v].edges;
            if edges.last() != Some(&edge) {
                edges.push(edge);
            }
        }
        Ok(edge)
    }

    /// The straight edge between two vertices, made if there is none.
    pub fn straight_edge(&mut self, vertices: [usize; 2]) -> Result<usize, BuildError> {
        let [a, b] = vertices;
        if let Some(&edge) = self.straight.get(&[a.min(b), a.max(b)]) {
            return Ok(edge);
        }
        let (from, to) = (self.check_vertex(a)?, self.check_vertex(b)?);
        let curve = Curve::Line(Line::new(from, to, UNIT)?);
        let edge = self.edge(vertices, curve)?;
        self.straight.insert([a.min(b), a.max(b)], edge);
        Ok(edge)
    }

    fn check_vertex(&self, vertex: usize) -> Result<Point3<f64>, BuildError> {
        let count = self.parts.vertices.len();
        match self.parts.vertices.get(vertex) {
            Some(v) => Ok(v.point),
            None => Err(BuildError::Vertex { vertex, count }),
        }
    }

    /// Adds a flat face bounded by straight edges through `corners`, counter-clockwise seen from outside; its
    /// number. The plane goes through the first corner; its normal is Newell's mean of all.
    pub fn planar_face(&mut self, corners: &[usize]) -> Result<usize, BuildError> {
        let points = self.points(corners)?;
        let o = points[0];
        let mut normal = Vector3::zeros();
        for (i, p) in points.iter().enumerate() {
            let q = points[(i + 1) % points.len()];
            normal += (p - o).cross(&(q - o));
        }
        let along = points.iter().map(|p| p - o).find(|d| d.norm() > 0.0);
        let (Some(z), Some(x)) = (
            normal.try_normalize(0.0),
            along.and_then(|d| d.try_normalize(0.0)),
        ) else {
            return Err(BuildError::NoArea);
        };
        // Exactly normal to it where the corners are flat.
        let Some(y) = z.cross(&x).try_normalize(0.0) else {
            return Err(BuildError::NoArea);
        };
        let mut plane = Plane {
            origin: o,
            x,
            y,
            domain: [UNIT; 2],
            extents: [UNIT; 2],
        };
        let uv: Vec<Point2<f64>> = points.iter().map(|p| plane_uv(&plane, p)).collect();
        for i in 0..2 {
            let (start, end) = uv
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| {
                    (a.min(p[i]), b.max(p[i]))
                });
            plane.domain[i] = Interval { start, end };
        }
        plane.extents = plane.domain;
        let plane = Plane::new(plane)?;
        self.face(plane, &[corners])
    }

    fn points(&self, corners: &[usize]) -> Result<Vec<Point3<f64>>, BuildError> {
        if corners.len() < 3 {
            return Err(BuildError::Loop {
                found: corners.len(),
                needed: 3,
            });
        }
        corners.iter().map(|v| self.check_vertex(*v)).collect()
    }

    /// Adds a face of a plane bounded by loops of straight edges, the outer loop first and
    /// counter-clockwise seen from outside, holes the other way round; its number.
    /// Where that is against the plane's normal, the face is marked as reversed.
    pub fn face(&mut self, plane: Plane, loops: &[&[usize]]) -> Result<usize, BuildError> {
        let mut specs = Vec::new();
        for corners in loops {
            let uv: Vec<Point2<f64>> = self
                .points(corners)?
                .iter()
                .map(|p| plane_uv(&plane, p))
                .collect();
            let mut trims = Vec::new();
            for (i, &a) in corners.iter().enumerate() {
                let j = (i + 1) % corners.len();
                let edge = self.straight_edge([a, corners[j]])?;
                trims.push(TrimSpec {
                    vertices: [a, corners[j]],
                    curve: Curve::Line(Line::new(uv[i], uv[j], UNIT)?),
                    edge: Some(edge),
                });
            }
            specs.push(trims);
        }
        self.face_with_trims(Surface::Plane(plane), specs)
    }

    /// Adds a face of any surface bounded by loops of trims, the outer loop first and counter-clockwise
    /// seen from outside, holes the other way round; its number.
    /// Where that is against the surface's normal, the face is marked as reversed.
    pub fn face_with_trims(
        &mut self,
        surface: Surface,
        loops: Vec<Vec<TrimSpec>>,
    ) -> Result<usize, BuildError> {
        let area = match loops.first() {
            Some(outer) if !outer.is_empty() => turning_area(outer),
            _ => {
                return Err(BuildError::Loop {
                    found: 0,
                    needed: 1,
                });
            }
        };
        if area == 0.0 || !area.is_finite() {
            return Err(BuildError::NoArea);
        }
        // Check everything first, so that a refused face leaves nothing behind.
        for trim in loops.iter().flatten() {
            for v in trim.vertices {
                self.check_vertex(v)?;
            }
            let Some(edge) = trim.edge else { continue };
            let count = self.parts.edges.len();
            let ends = match self.parts.edges.get(edge) {
                Some(e) => e.vertices,
                None => return Err(BuildError::Edge { edge, count }),
            };
            let [from, to] = trim.vertices;
            if ends != [from, to] && ends != [to, from] {
                return Err(BuildError::Ends {
                    from,
                    to,
                    edge,
                    ends,
                });
            }
        }
        let reversed = area < 0.0;
        let domain = surface.domain();
        let face = self.parts.faces.len();
        self.parts.surfaces.push(surface);
        let mut indices = Vec::new();
        for (i, mut trims) in loops.into_iter().enumerate() {
            let trim_loop = self.parts.loops.len();
            indices.push(trim_loop);
            if reversed {
                trims.reverse();
            }
            let trims = trims
                .into_iter()
                .map(|t| self.trim(t, reversed, trim_loop, domain))
                .collect();
            self.parts.loops.push(TrimLoop {
                kind: if i == 0 {
                    LoopKind::Outer
                } else {
                    LoopKind::Inner
                },
                trims,
                face,
            });
        }
        self.parts.faces.push(Face {
            surface: self.parts.surfaces.len() - 1,
            loops: Some(indices),
            reversed,
        });
        Ok(face)
    }

    fn trim(
        &mut self,
        spec: TrimSpec,
        reversed: bool,
        trim_loop: usize,
        domain: [Interval; 2],
    ) -> usize {
        let [from, to] = spec.vertices;
        let vertices = if reversed { [to, from] } else { [from, to] };
        let trim = self.parts.trims.len();
        let mut edge_reversed = false;
        if let Some(e) = spec.edge {
            let edge = &mut self.parts.edges[e];
            edge.trims.push(trim);
            edge_reversed = if from == to {
                // Both ends are one vertex: the second use runs the other way.
                edge.trims.len().is_multiple_of(2)
            } else {
                edge.vertices != vertices
            };
        }
        let iso = Iso::of(&spec.curve, domain);
        let span = spec.curve.domain();
        self.parts.curves2.push(spec.curve);
        self.parts.trims.push(TrimCurve {
            curve: self.parts.curves2.len() - 1,
            span,
            reversed,
            edge: spec.edge,
            edge_reversed,
            vertices,
            kind: if spec.edge.is_some() {
                TrimKind::Unknown
            } else {
                TrimKind::Singular
            },
            iso,
            trim_loop,
        });
        trim
    }

    /// Adds a face that is the whole of a surface, without loops; its number.
    pub fn whole_surface(&mut self, surface: Surface) -> usize {
        self.parts.surfaces.push(surface);
        self.parts.faces.push(Face {
            surface: self.parts.surfaces.len() - 1,
            loops: None,
            reversed: false,
        });
        self.parts.faces.len() - 1
    }

    /// The BREP. Each trim becomes a boundary, seam or mated trim by how its edge is used.
    pub fn build(mut self) -> Result<Brep, BuildError> {
        for i in 0..self.parts.trims.len() {
            let Some(edge) = self.parts.trims[i].edge else {
                continue;
            };
            let uses = &self.parts.edges[edge].trims;
            let trim_loop = self.parts.trims[i].trim_loop;
            let same = |t: &&usize| self.parts.trims[**t].trim_loop == trim_loop;
            let kind = if uses.len() == 1 {
                TrimKind::Boundary
            } else if uses.iter().filter(same).count() > 1 {
                TrimKind::Seam
            } else {
                TrimKind::Mated
            };
            self.parts.trims[i].kind = kind;
        }
        Ok(Brep::new(self.parts)?)
    }
}

impl Brep {
    /// One face that is the whole of a surface.
    pub fn from_surface(surface: Surface) -> Result<Self, BuildError> {
        let mut builder = BrepBuilder::new();
        builder.whole_surface(surface);
        builder.build()
    }
}

/// The parameters of the point of a plane nearest to `p`: exact up to rounding for any axes.
fn plane_uv(plane: &Plane, p: &Point3<f64>) -> Point2<f64> {
    let d = p - plane.origin;
    let (xx, xy, yy) = (
        plane.x.norm_squared(),
        plane.x.dot(&plane.y),
        plane.y.norm_squared(),
    );
    let (dx, dy) = (d.dot(&plane.x), d.dot(&plane.y));
    let determinant = xx * yy - xy * xy;
    let coordinates = [
        (dx * yy - dy * xy) / determinant,
        (dy * xx - dx * xy) / determinant,
    ];
    let parameter = |i: usize| {
        let (from, to) = (plane.extents[i], plane.domain[i]);
        if from == to {
            coordinates[i]
        } else {
            to.lerp((coordinates[i] - from.start) / from.length())
        }
    };
    Point2::new(parameter(0), parameter(1))
}

/// Signed area of the polygon through some points of each curve: its sign says which way the loop runs.
fn turning_area(trims: &[TrimSpec]) -> f64 {
    const SAMPLES: usize = 32;
    let points: Vec<Point2<f64>> = trims
        .iter()
        .flat_map(|t| {
            let d = t.curve.domain();
            (0..SAMPLES).map(move |i| t.curve.point(d.lerp(i as f64 / SAMPLES as f64)))
        })
        .collect();
    let o = points[0];
    let mut area = 0.0;
    for w in points.windows(2) {
        let (a, b) = (w[0] - o, w[1] - o);
        area += 0.5 * (a.x * b.y - a.y * b.x);
    }
    area
}
