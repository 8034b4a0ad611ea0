//! Convex solids, where they stand: polyhedra, cylinders and cones, with a round border or without.
//!
//! What a search needs of one: how far it reaches against a direction, its point nearest to another, how far a point is out of it, and some
//! points of its rim. All are closed forms; what they round is within [`ROUNDING`] of the coordinates and sizes.

use crate::pose::{Placed, Placement, up};
use parry3d_f64::math::Vector;
use parry3d_f64::shape::{ConvexPolyhedron, PackedFeatureId, Shape, TypedShape};
use std::f64::consts::TAU;

/// Of points, in coordinates: some sums and products of three.
pub(crate) const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Points on a round rim that are asked about wherever it leans to: three stand firm, and some of six are left at an edge.
const RIM: usize = 6;
/// A direction nearer to the axis than this, in its length, has no lowest point of a rim: it would be one of rounding.
const UPRIGHT: f64 = 1.0 / (1u64 << 20) as f64;

/// A convex solid in its own frame.
pub(crate) struct Hull {
    form: HullForm,
    /// Of a round border.
    border: f64,
}

enum HullForm {
    Polyhedron {
        vertices: Vec<Vector>,
        /// Corners of each.
        triangles: Vec<[usize; 3]>,
    },
    /// About the y axis.
    Turned { half: f64, radius: f64, cone: bool },
}

impl Hull {
    /// The solid that a shape is, if it is one.
    pub(crate) fn of(shape: &dyn Shape) -> Option<Self> {
        let turned = |half: f64, radius: f64, cone: bool, border: f64| Self {
            // Scaled by negative factors they are negative: the solid is the same.
            form: HullForm::Turned {
                half: half.abs(),
                radius: radius.abs(),
                cone,
            },
            border,
        };
        Some(match shape.as_typed_shape() {
            TypedShape::Cuboid(c) => Self::cuboid(c.half_extents, 0.0),
            TypedShape::RoundCuboid(c) => Self::cuboid(c.inner_shape.half_extents, c.border_radius),
            TypedShape::Triangle(t) => Self::triangle(t.vertices(), 0.0),
            TypedShape::RoundTriangle(t) => {
                Self::triangle(t.inner_shape.vertices(), t.border_radius)
            }
            TypedShape::ConvexPolyhedron(p) => Self::polyhedron(p, 0.0),
            TypedShape::RoundConvexPolyhedron(p) => {
                Self::polyhedron(&p.inner_shape, p.border_radius)
            }
            TypedShape::Cylinder(c) => turned(c.half_height, c.radius, false, 0.0),
            TypedShape::RoundCylinder(c) => {
                let inner = &c.inner_shape;
                turned(inner.half_height, inner.radius, false, c.border_radius)
            }
            TypedShape::Cone(c) => turned(c.half_height, c.radius, true, 0.0),
            TypedShape::RoundCone(c) => {
                let inner = &c.inner_shape;
                turned(inner.half_height, inner.radius, true, c.border_radius)
            }
            _ => return None,
        })
    }

    fn cuboid(half: Vector, border: f64) -> Self {
        let sign = |k: usize, c: usize| if k >> c & 1 == 0 { -1.0 } else { 1.0 };
        let corner = |k: usize| Vector::new(sign(k, 0), sign(k, 1), sign(k, 2)) * half;
        let sides = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let form = HullForm::Polyhedron {
            vertices: (0..8).map(corner).collect(),
            triangles: sides.iter().flat_map(|s| fan(s)).collect(),
        };
        Self { form, border }
    }

    fn triangle(corners: &[Vector; 3], border: f64) -> Self {
        let form = HullForm::Polyhedron {
            vertices: corners.to_vec(),
            triangles: vec![[0, 1, 2]],
        };
        Self { form, border }
    }

    fn polyhedron(p: &ConvexPolyhedron, border: f64) -> Self {
        let sides = p.faces().iter().flat_map(|f| {
            let first = f.first_vertex_or_edge as usize;
            let count = f.num_vertices_or_edges as usize;
            let corners = p.vertices_adj_to_face().get(first..first + count);
            let corners: Vec<usize> = corners
                .unwrap_or_default()
                .iter()
                .map(|v| *v as usize)
                .collect();
            fan(&corners)
        });
        let form = HullForm::Polyhedron {
            triangles: sides.collect(),
            vertices: p.points().to_vec(),
        };
        Self { form, border }
    }
}

/// A convex polygon in triangles.
fn fan(corners: &[usize]) -> Vec<[usize; 3]> {
    let pairs = corners.windows(2).skip(1);
    pairs.map(|p| [corners[0], p[0], p[1]]).collect()
}

/// The solid where it stands, in the BREP's frame.
pub(crate) struct Body {
    form: Form,
    pub(crate) border: f64,
    /// How far any of its points may be from the true ones.
    pub(crate) bound: f64,
    pub(crate) middle: Vector,
    /// No point is farther from the middle.
    pub(crate) radius: f64,
}

enum Form {
    Polyhedron {
        vertices: Vec<Vector>,
        triangles: Vec<[usize; 3]>,
        /// A point on each side of it, and its outward normal; none where it has no inside.
        sides: Vec<(Vector, Vector)>,
    },
    /// The unit axis points to the apex of a cone.
    Turned {
        axis: Vector,
        half: f64,
        radius: f64,
        cone: bool,
    },
}

impl Body {
    pub(crate) fn new(hull: Hull, placement: &Placement<'_>) -> Option<Self> {
        let border = hull.border;
        let (form, middle, radius, off) = match hull.form {
            HullForm::Polyhedron {
                vertices,
                triangles,
            } => polyhedron(&vertices, triangles, placement),
            HullForm::Turned { half, radius, cone } => {
                let middle = placement.to_brep(Vector::ZERO);
                let axis = placement.turn_to_brep(Vector::Y);
                // No point is farther along the axis than half, nor farther from it than the radius.
                let off = middle.bound + axis.bound * (half + radius);
                let form = Form::Turned {
                    axis: axis.point,
                    half,
                    radius,
                    cone,
                };
                (form, middle.point, up(half.hypot(radius)), off)
            }
        };
        let bound = up(off + ROUNDING * (middle.length() + radius));
        (bound + radius).is_finite().then_some(Self {
            form,
            border,
            bound,
            middle,
            radius,
        })
    }

    /// How far a point is out of the side that it is farthest out of, and that side's normal; `None` where it has no inside.
    pub(crate) fn out(&self, x: Vector) -> Option<(f64, Vector)> {
        match &self.form {
            Form::Polyhedron { sides, .. } => {
                let heights = sides.iter().map(|(at, n)| (n.dot(x - *at), *n));
                heights.max_by(|a, b| a.0.total_cmp(&b.0))
            }
            Form::Turned {
                axis,
                half,
                radius,
                cone,
            } => {
                let (y, away, from) = self.about(*axis, x);
                let base = (-y - half, -*axis);
                let side = if *cone {
                    let [across, along] = slant(*half, *radius)?;
                    let height = (away - radius) * across + (y + half) * along;
                    (height, from * across + *axis * along)
                } else {
                    (away - radius, from)
                };
                let top = (y - half, *axis);
                let mut all = vec![base, side];
                if !*cone {
                    all.push(top);
                }
                all.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))
            }
        }
    }

    /// The point of the solid that is nearest.
    pub(crate) fn nearest(&self, x: Vector) -> Vector {
        if self.out(x).is_some_and(|(height, _)| height <= 0.0) {
            return x;
        }
        match &self.form {
            Form::Polyhedron {
                vertices,
                triangles,
                ..
            } => {
                let near = |t: &[usize; 3]| on_triangle(t.map(|k| vertices[k]), x);
                let all = triangles.iter().map(near);
                let best = all.min_by(|a, b| (*a - x).length().total_cmp(&(*b - x).length()));
                best.unwrap_or(self.middle)
            }
            Form::Turned {
                axis,
                half,
                radius,
                cone,
            } => {
                let (y, away, from) = self.about(*axis, x);
                let [away, y] = if *cone {
                    on_slope([away, y], *half, *radius)
                } else {
                    [away.min(*radius), y.clamp(-half, *half)]
                };
                self.middle + *axis * y + from * away
            }
        }
    }

    /// How far it reaches against a direction, its border left out.
    pub(crate) fn lowest(&self, n: Vector) -> f64 {
        match &self.form {
            Form::Polyhedron { vertices, .. } => {
                let heights = vertices.iter().map(|v| n.dot(*v));
                heights.fold(f64::INFINITY, f64::min)
            }
            Form::Turned {
                axis,
                half,
                radius,
                cone,
            } => {
                let along = n.dot(*axis);
                let rim = radius * (n - *axis * along).length();
                let lowest = match cone {
                    true => (-along * half - rim).min(along * half),
                    false => -along.abs() * half - rim,
                };
                n.dot(self.middle) + lowest
            }
        }
    }

    /// Points at its rims, the lowest along a direction first.
    pub(crate) fn corners(&self, down: Vector) -> Vec<(Vector, PackedFeatureId)> {
        let mut found: Vec<(Vector, PackedFeatureId)> = Vec::new();
        match &self.form {
            Form::Polyhedron { vertices, .. } => {
                let numbered = (0u32..).zip(vertices);
                found.extend(numbered.map(|(k, v)| (*v, PackedFeatureId::vertex(k))));
            }
            Form::Turned {
                axis,
                half,
                radius,
                cone,
            } => {
                let x = axis.any_orthonormal_vector();
                let y = axis.cross(x);
                let lean = across(*axis, down);
                let leans = lean.length() > UPRIGHT * down.length();
                let ends = [-half, *half];
                for (end, k) in ends.into_iter().zip(0u32..) {
                    let center = self.middle + *axis * end;
                    if *cone && k == 1 {
                        found.push((center, PackedFeatureId::vertex(RIM as u32)));
                        continue;
                    }
                    // The lowest, which rolls along the rim, and some that stay.
                    if leans {
                        let low = center - lean * (radius / lean.length());
                        found.push((low, PackedFeatureId::edge(k)));
                    }
                    let first = k * RIM as u32;
                    found.extend((0..RIM).map(|i| {
                        let (sin, cos) = (TAU * i as f64 / RIM as f64).sin_cos();
                        let at = center + (x * cos + y * sin) * *radius;
                        (at, PackedFeatureId::vertex(first + i as u32))
                    }));
                }
            }
        }
        found.sort_by(|a, b| down.dot(a.0).total_cmp(&down.dot(b.0)));
        found
    }

    /// The outward normal that looks against a direction the most; `None` where it has no sides.
    pub(crate) fn facing(&self, n: Vector) -> Option<Vector> {
        let mut all: Vec<Vector> = Vec::new();
        match &self.form {
            Form::Polyhedron { sides, .. } => all.extend(sides.iter().map(|s| s.1)),
            Form::Turned {
                axis,
                half,
                radius,
                cone,
            } => {
                all.push(-*axis);
                if !*cone {
                    all.push(*axis);
                }
                let away = -across(*axis, n);
                let length = away.length();
                if length > UPRIGHT * n.length() {
                    let away = away / length;
                    match cone {
                        true => all.extend(
                            slant(*half, *radius)
                                .map(|[across, along]| away * across + *axis * along),
                        ),
                        false => all.push(away),
                    }
                }
            }
        }
        all.into_iter().min_by(|a, b| a.dot(n).total_cmp(&b.dot(n)))
    }

    /// A point's height along the axis, its distance from it, and the direction from the axis to it.
    fn about(&self, axis: Vector, x: Vector) -> (f64, f64, Vector) {
        let off = x - self.middle;
        let y = off.dot(axis);
        let beside = across(axis, off);
        let away = beside.length();
        let from = match away > 0.0 {
            true => beside / away,
            false => axis.any_orthonormal_vector(),
        };
        (y, away, from)
    }
}

/// What is across an axis: taken twice, for next to the axis what rounding leaves of it is not small beside the rest.
fn across(axis: Vector, x: Vector) -> Vector {
    let once = x - axis * x.dot(axis);
    once - axis * once.dot(axis)
}

/// The outward normal of a cone's side, away from and along its axis; `None` of one without extent.
fn slant(half: f64, radius: f64) -> Option<[f64; 2]> {
    let length = radius.hypot(2.0 * half);
    (length > 0.0).then(|| [2.0 * half / length, radius / length])
}

/// The point of a cone's half section nearest to one outside it: coordinates away from and along its axis.
fn on_slope([away, y]: [f64; 2], half: f64, radius: f64) -> [f64; 2] {
    let base = [away.clamp(0.0, radius), -half];
    // From the rim up to the apex.
    let way = [-radius, 2.0 * half];
    let square = way[0] * way[0] + way[1] * way[1];
    let along = (away - radius) * way[0] + (y + half) * way[1];
    let t = if square > 0.0 {
        (along / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let side = [radius + t * way[0], -half + t * way[1]];
    let off = |p: &[f64; 2]| (p[0] - away).hypot(p[1] - y);
    if off(&side) < off(&base) { side } else { base }
}

/// Form, middle, radius and how far vertices may be off.
fn polyhedron(
    vertices: &[Vector],
    triangles: Vec<[usize; 3]>,
    placement: &Placement<'_>,
) -> (Form, Vector, f64, f64) {
    let placed: Vec<Placed> = vertices.iter().map(|v| placement.to_brep(*v)).collect();
    let vertices: Vec<Vector> = placed.iter().map(|p| p.point).collect();
    let middle = vertices.iter().copied().sum::<Vector>() / vertices.len() as f64;
    let radius = vertices.iter().map(|v| (*v - middle).length());
    let radius = up(radius.fold(0.0, f64::max));
    let off = placed.iter().map(|p| p.bound).fold(0.0, f64::max);
    let side = |triangle: &[usize; 3]| {
        let [a, b, c] = triangle.map(|k| vertices[k]);
        let normal = (b - a).cross(c - a);
        let length = normal.length();
        if !(length > 0.0) {
            return None;
        }
        let normal = normal / length;
        let outward = if normal.dot(a - middle) < 0.0 {
            -normal
        } else {
            normal
        };
        Some((a, outward))
    };
    let sides = match triangles.len() > 1 {
        // One without area says nothing of where the inside is: a flat box has none.
        true => triangles.iter().map(side).collect::<Option<Vec<_>>>(),
        false => None,
    };
    let form = Form::Polyhedron {
        sides: sides.unwrap_or_default(),
        triangles,
        vertices,
    };
    (form, middle, radius, off)
}

/// The point of a triangle nearest to another (Ericson, *Real-Time Collision Detection*, 5.1.5).
fn on_triangle([a, b, c]: [Vector; 3], p: Vector) -> Vector {
    let (ab, ac) = (b - a, c - a);
    let at = |o: Vector| (ab.dot(p - o), ac.dot(p - o));
    let ((d1, d2), (d3, d4), (d5, d6)) = (at(a), at(b), at(c));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let (e, f) = (d4 - d3, d5 - d6);
        return b + (c - b) * (e / (e + f));
    }
    let sum = va + vb + vc;
    if !(sum > 0.0) {
        // A triangle without area: its corners' middle is one of its points.
        return (a + b + c) / 3.0;
    }
    a + ab * (vb / sum) + ac * (vc / sum)
}
