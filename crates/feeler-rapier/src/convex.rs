//! A BREP and a convex polyhedron: a cuboid, a triangle, a convex hull, and these with round borders.
//!
//! # The separation
//! The least signed distance d of the BREP over the points p of the polyhedron C, less the border's radius: apart, the distance of the two; else the
//! depth of C's deepest point in material.
//!
//! # What is certified
//! The enclosure. From above by d at a point of C. From below by a plane: with the BREP within {n.x <= m} and C within {n.x >= c}, both known
//! from the kernel and from C's vertices, no point of C is nearer than c - m, nor deeper than m - c, since the ball about it in material is
//! within the half-space. And by d at C's middle less C's radius, as d changes by no more than the way. The
//! first is tight where a plane parts the two, up to their depth: faces on faces, on convex parts always. In a groove or a hole the second
//! holds, and the enclosure is about as wide as C. The pose's rounding is in both, and [`ROUNDING`] for what is computed here.
//!
//! # What is not
//! Which point of C is the deepest is found by going downhill from its vertices and its middle, which proves nothing (the enclosure says how much
//! may be missed). Contacts are approximate: C's vertices, each with the BREP's certified distance about it; the deepest point that was found;
//! and points of the BREP's edges and its vertices that are within C, with their distance from C's faces.

use crate::ball::{ball_at, nothing_known};
use crate::pair::{Ask, Memory, PairAnswer, PairContact, pack, to_vector};
use crate::pose::{Placed, Placement, up};
use crate::shape::BrepShape;
use feeler::numeric::Enclosure;
use feeler::query::{Contacts, HalfSpace, Probe, Separation, contact};
use parry3d_f64::math::Vector;
use parry3d_f64::shape::{ConvexPolyhedron, PackedFeatureId, Shape, TypedShape};

/// Of points, in coordinates: some sums and products of three.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Vertices that are asked about, the nearest first.
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

/// A convex polyhedron in its own frame.
pub(crate) struct Hull {
    vertices: Vec<Vector>,
    /// Corners of each.
    triangles: Vec<[usize; 3]>,
    /// Of a round border.
    border: f64,
}

impl Hull {
    /// The polyhedron that a shape is, if it is one.
    pub(crate) fn of(shape: &dyn Shape) -> Option<Self> {
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
        Self {
            vertices: (0..8).map(corner).collect(),
            triangles: sides.iter().flat_map(|s| fan(s)).collect(),
            border,
        }
    }

    fn triangle(corners: &[Vector; 3], border: f64) -> Self {
        Self {
            vertices: corners.to_vec(),
            triangles: vec![[0, 1, 2]],
            border,
        }
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
        Self {
            triangles: sides.collect(),
            vertices: p.points().to_vec(),
            border,
        }
    }
}

/// A convex polygon in triangles.
fn fan(corners: &[usize]) -> Vec<[usize; 3]> {
    let pairs = corners.windows(2).skip(1);
    pairs.map(|p| [corners[0], p[0], p[1]]).collect()
}

/// The polyhedron where it stands, in the BREP's frame.
struct Body {
    vertices: Vec<Vector>,
    triangles: Vec<[usize; 3]>,
    /// A point on each side of it, and its outward normal; none where it has no inside.
    sides: Vec<(Vector, Vector)>,
    border: f64,
    /// How far vertices, and hence any of its points, may be from the true ones.
    bound: f64,
    middle: Vector,
    radius: f64,
}

impl Body {
    fn new(hull: Hull, placement: &Placement<'_>) -> Option<Self> {
        let placed: Vec<Placed> = hull
            .vertices
            .iter()
            .map(|v| placement.to_brep(*v))
            .collect();
        let vertices: Vec<Vector> = placed.iter().map(|p| p.point).collect();
        let middle = vertices.iter().copied().sum::<Vector>() / vertices.len() as f64;
        let radius = vertices.iter().map(|v| (*v - middle).length());
        let radius = up(radius.fold(0.0, f64::max));
        let off = placed.iter().map(|p| p.bound).fold(0.0, f64::max);
        let bound = up(off + ROUNDING * (middle.length() + radius));
        if !(bound + radius).is_finite() {
            return None;
        }
        let mut body = Self {
            vertices,
            triangles: hull.triangles,
            sides: Vec::new(),
            border: hull.border,
            bound,
            middle,
            radius,
        };
        if body.triangles.len() > 1 {
            // One without area says nothing of where the inside is: a flat box has none.
            let sides: Option<Vec<_>> = body.triangles.iter().map(|t| body.side(t)).collect();
            body.sides = sides.unwrap_or_default();
        }
        Some(body)
    }

    fn side(&self, triangle: &[usize; 3]) -> Option<(Vector, Vector)> {
        let [a, b, c] = triangle.map(|k| self.vertices[k]);
        let normal = (b - a).cross(c - a);
        let length = normal.length();
        if !(length > 0.0) {
            return None;
        }
        let normal = normal / length;
        let outward = if normal.dot(a - self.middle) < 0.0 {
            -normal
        } else {
            normal
        };
        Some((a, outward))
    }

    /// How far a point is out of the side that it is farthest out of, and that side's normal.
    fn out(&self, x: Vector) -> Option<(f64, Vector)> {
        let heights = self.sides.iter().map(|(at, n)| (n.dot(x - *at), *n));
        heights.max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The point of the polyhedron that is nearest.
    fn nearest(&self, x: Vector) -> Vector {
        if self.out(x).is_some_and(|(height, _)| height <= 0.0) {
            return x;
        }
        let near = |t: &[usize; 3]| on_triangle(t.map(|k| self.vertices[k]), x);
        let all = self.triangles.iter().map(near);
        let best = all.min_by(|a, b| (*a - x).length().total_cmp(&(*b - x).length()));
        best.unwrap_or(self.middle)
    }

    /// How far it reaches against a direction.
    fn lowest(&self, n: Vector) -> f64 {
        let heights = self.vertices.iter().map(|v| n.dot(*v));
        heights.fold(f64::INFINITY, f64::min)
    }
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

/// What is known about a point of the polyhedron.
struct Found {
    point: Vector,
    contact: PairContact,
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
    fn plane(&mut self, n: Vector) -> f64 {
        let length = n.length();
        let n = n / length;
        let Ok(plane) = HalfSpace::new(to_vector(-n), 0.0) else {
            return f64::NEG_INFINITY;
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
            f64::NEG_INFINITY
        } else {
            bound
        }
    }

    /// Points of the BREP's edges and its vertices within the polyhedron, or as near as this.
    fn border_points(&self, prediction: f64) -> Vec<PairContact> {
        let body = self.body;
        let reach = body.radius + body.border + prediction.max(0.0);
        let near = self.shape.border_points().iter();
        let near = near.filter(|p| (p.point - body.middle).length() <= reach);
        let contact = |p: &crate::shape::BorderPoint| {
            let (height, side) = body.out(p.point)?;
            let (value, normal) = if height <= 0.0 {
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

/// A BREP and a convex polyhedron.
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
    let around = (middle.contact.separation.bounds.lo - body.radius).next_down();
    let answer = |lo: f64, hi: f64, value: f64, contacts: Vec<PairContact>| PairAnswer {
        separation: Separation {
            value: value.clamp(lo, hi),
            bounds: Enclosure { lo, hi },
        },
        contacts,
        continuum: false,
        undecided: None,
    };
    if ask.several && around > ask.prediction {
        let s = middle.contact.separation;
        return answer(around, s.bounds.hi, s.value, Vec::new());
    }
    // The vertices that are lowest along the way to the BREP.
    let down = middle.contact.normal;
    let mut order: Vec<usize> = (0..body.vertices.len()).collect();
    order.sort_by(|a, b| {
        let height = |k: &usize| down.dot(body.vertices[*k]);
        height(a).total_cmp(&height(b))
    });
    order.truncate(VERTICES);
    let vertex = |k: &usize| {
        let feature = PackedFeatureId::vertex(*k as u32);
        search.ask(body.vertices[*k], feature)
    };
    let mut corners: Vec<Found> = order.iter().filter_map(vertex).collect();
    corners.sort_by(|a, b| {
        let depth = |f: &Found| f.contact.separation.value;
        depth(a).total_cmp(&depth(b))
    });
    let copy = |f: &Found| Found {
        point: f.point,
        contact: f.contact,
    };
    let mut deepest = search.descend(copy(&middle));
    for start in corners.iter().take(STARTS) {
        let found = search.descend(copy(start));
        if found.contact.separation.value < deepest.contact.separation.value {
            deepest = found;
        }
    }
    let mut lo = around;
    let normal = deepest.contact.normal;
    // Across the side that faces the BREP, too: it is known better than the normal of a round face.
    let facing = body.sides.iter().map(|(_, out)| -*out);
    let facing = facing.max_by(|a, b| a.dot(normal).total_cmp(&b.dot(normal)));
    for n in [Some(normal), facing].into_iter().flatten() {
        lo = lo.max(search.plane(n));
    }
    if !(lo <= search.hi) {
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
            .is_some_and(|c| c.separation.value <= value + GAIN * body.radius)
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
