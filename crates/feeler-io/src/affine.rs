//! Curves, surfaces and BREPs under affine maps: blocks in place, other units.
//!
//! **What is exact.** A map whose matrix is a signed permutation times a power of two leaves every digit of a coordinate as it is;
//! with a translation it is exact where no sum rounds, which is looked at number by number. [`Moved::off`] is 0 then.
//!
//! **What is not** is bounded. Let `rho` be the largest coordinate (radii included), `s` the scale, and of a map that is a product of others `S` the product of
//! their largest stretches and `T` the greatest length that a translation comes to on the way: `|t|` of one map, `S_A T_B + T_A` of `A` after `B`. (What translations there and
//! back leave may be far smaller than their roundings, which `T` keeps.) A coordinate is a sum of four
//! products: off by at most gamma_4 (sum |m_ij| |x_j| + |t_i|), and a point of a NURBS by no more than its control points
//! divided by their weights are (their weights stay). A direction `M d` is off by the angle sqrt(3) gamma_3 at most (the matrix of
//! absolute values has at most sqrt(3) times the norm of `M = s R`); an axis that leans by an angle `a` moves what turns about it by at most `2 a`
//! times its distance from the axis' origin, up to `2 sqrt(3) s rho`. A radius is off by one rounding of `s r` and of `s`. A product of two matrices is off by gamma_3 `|A| |B|`, entry by
//! entry, no more than 3 gamma_3 `S` in norm, and its translation by gamma_4 `sqrt(3) T`. Together less
//! than `64 epsilon (sqrt(3) S rho sqrt(3) + T)` per map that was multiplied into this one. A matrix that is `s R` only up to a relative `delta` (in its squared lengths) has
//! native circles taken for circles: by no more than `16 delta s rho` off in all, by the same lemma.

use feeler::brep::{Brep, BrepError};
use feeler::numeric::Interval;
use feeler::nurbs::{
    Arc, Curve, Curve2, Curve3, GeometryError, Line, NurbsCurve, NurbsSurface, Plane, PolyCurve,
    Polyline, Revolution, Sum, Surface,
};
use nalgebra::{Matrix3, Matrix4, Point, Point2, Point3, SVector, Vector2, Vector3, Vector4};

/// Squared lengths and angles may differ by this part of themselves, for a map to be taken as one that keeps shapes: what a file prints or
/// a chain of rotations loses.
const SIMILAR: f64 = 1.0 / (1_u64 << 40) as f64;

/// Roundings of the size for each map: see the [module](self).
const ROUNDINGS: f64 = 64.0 * f64::EPSILON;

/// The image `origin + x axes[0] + y axes[1]` of a curve in uv, in space or in another uv. With a `normal` the axes are taken as orthonormal,
/// and arcs stay arcs, about the normal; otherwise they become NURBS.
pub(crate) fn image<const D: usize, const H: usize>(
    curve: &Curve2,
    origin: Point<f64, D>,
    axes: [SVector<f64, D>; 2],
    normal: Option<SVector<f64, D>>,
) -> Result<Curve<D, H>, GeometryError> {
    let [x, y] = axes;
    let at = |p: &Point2<f64>| origin + x * p.x + y * p.y;
    let along = |v: &Vector2<f64>| x * v.x + y * v.y;
    Ok(match (curve, normal) {
        (Curve::Line(l), _) => Curve::Line(Line::new(at(&l.from), at(&l.to), l.domain)?),
        (Curve::Arc(a), Some(normal)) => Curve::Arc(Arc::new(Arc {
            center: at(&a.center),
            x: along(&a.x),
            y: along(&a.y),
            z: if a.x.perp(&a.y) < 0.0 {
                -normal
            } else {
                normal
            },
            radius: a.radius,
            angle: a.angle,
            domain: a.domain,
        })?),
        (Curve::Arc(_), None) => {
            let nurbs = Curve::Nurbs(curve.to_nurbs()?.nurbs);
            return image(&nurbs, origin, axes, None);
        }
        (Curve::Polyline(p), _) => {
            let points = p.points().iter().map(at).collect();
            Curve::Polyline(Polyline::new(points, p.params().to_vec())?)
        }
        (Curve::Nurbs(n), _) => {
            let points = n.control_points().iter().map(|p| {
                let q = origin.coords * p.z + x * p.x + y * p.y;
                SVector::from_fn(|i, _| q.get(i).copied().unwrap_or(p.z))
            });
            let knots = n.knots().knots().to_vec();
            Curve::Nurbs(NurbsCurve::new(n.degree(), points.collect(), knots)?)
        }
        // Segments are never poly-curves themselves.
        (Curve::Poly(p), _) => {
            let segments = p.segments().iter();
            let segments = segments.map(|s| image(s, origin, axes, normal));
            let segments = segments.collect::<Result<_, _>>()?;
            Curve::Poly(PolyCurve::new(segments, p.params().to_vec())?)
        }
    })
}

/// Why a BREP cannot be moved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MapError {
    /// A matrix that is no affine map of space onto itself.
    #[error("the map is not one of space onto itself (its determinant is {determinant:?})")]
    Singular {
        /// Its determinant.
        determinant: f64,
    },
    /// Uneven scaling or shear of what has circles.
    #[error(
        "the map scales unevenly or shears (squared lengths by up to {off:?} of themselves), which circles and surfaces of revolution do \
         not survive; make the geometry NURBS first (Rhino: ToNURBS)"
    )]
    Uneven {
        /// By how much.
        off: f64,
    },
    /// Geometry that the kernel refuses.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A BREP that the kernel refuses.
    #[error(transparent)]
    Brep(#[from] BrepError),
}

/// `x -> matrix x + translation`.
#[derive(Clone, Debug, PartialEq)]
pub struct Affine {
    matrix: Matrix3<f64>,
    translation: Vector3<f64>,
    /// How many maps were multiplied into this one.
    factors: u32,
    /// See the [module](self): `S` and `T` there.
    through: [f64; 2],
}

/// A BREP moved, and how far any of its points may be from where the exact map takes it, in the units of the result.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// The BREP.
    pub brep: Brep,
    /// The bound; 0: nothing was rounded.
    pub off: f64,
}

impl Affine {
    /// The map of a matrix by rows, the last of which must be `0 0 0 c`, `c` not 0; `None` for others.
    pub fn from_rows(rows: &[f64; 16]) -> Option<Self> {
        let m = Matrix4::from_row_slice(rows);
        let c = m[(3, 3)];
        let last = [m[(3, 0)], m[(3, 1)], m[(3, 2)]];
        if rows.iter().any(|x| !x.is_finite()) || last != [0.0; 3] || c == 0.0 {
            return None;
        }
        let (matrix, translation) = (m.fixed_view::<3, 3>(0, 0), m.fixed_view::<3, 1>(0, 3));
        // Dividing by 1 is nothing.
        let factors = if c == 1.0 { 1 } else { 2 };
        Some(Self::new(matrix / c, translation / c, factors))
    }

    fn new(matrix: Matrix3<f64>, translation: Vector3<f64>, factors: u32) -> Self {
        let mut map = Self {
            matrix,
            translation,
            factors,
            through: [0.0; 2],
        };
        map.through = [map.stretch(), translation.norm()];
        map
    }

    /// The same, each of whose numbers has been rounded once more before.
    #[must_use]
    pub(crate) fn rounded(self) -> Self {
        Self {
            factors: self.factors.saturating_add(1),
            ..self
        }
    }

    /// Scaling by a factor about the origin.
    pub fn scaling(factor: f64) -> Self {
        Self::new(Matrix3::identity() * factor, Vector3::zeros(), 1)
    }

    /// First `other`, then this.
    #[must_use]
    pub fn after(&self, other: &Self) -> Self {
        Self {
            matrix: self.matrix * other.matrix,
            translation: self.matrix * other.translation + self.translation,
            factors: self.factors.saturating_add(other.factors),
            through: [
                self.through[0] * other.through[0],
                self.through[0] * other.through[1] + self.through[1],
            ],
        }
    }

    /// The same map where all lengths are `factor` times as long.
    #[must_use]
    pub(crate) fn rescaled(&self, factor: f64) -> Self {
        let mut exact = true;
        let translation = self.translation.map(|x| product(x, factor, &mut exact));
        Self {
            matrix: self.matrix,
            translation,
            factors: self.factors.saturating_add(u32::from(!exact)),
            through: [self.through[0], self.through[1] * factor],
        }
    }

    /// What one rounding of each coordinate of its translation comes to.
    pub(crate) fn rounding(&self) -> f64 {
        f64::EPSILON * self.through[1]
    }

    /// The scale, and how far squared lengths and angles are from being scaled by it, relative to its square.
    fn scale(&self) -> (f64, f64) {
        let square = self.matrix.transpose() * self.matrix;
        let s2 = square.trace() / 3.0;
        let off = (square - Matrix3::identity() * s2).amax() / s2;
        (s2.sqrt(), off)
    }

    /// No length becomes longer than this many times its own: no eigenvalue of a symmetric matrix of order 3 is farther from `s` than three times the
    /// largest entry of what it differs from `s` times the identity by. The last factor is for roundings.
    pub(crate) fn stretch(&self) -> f64 {
        let (scale, off) = self.scale();
        scale * (1.0 + 3.0 * off).sqrt() * (1.0 + 1e-12)
    }

    /// Whether each axis goes to an axis, or against it, times the same power of two.
    fn keeps_digits(&self) -> bool {
        let entries = self.matrix.iter().filter(|x| **x != 0.0);
        let size = self.matrix.amax();
        let one_each = (0..3).all(|i| {
            let count = |v: &mut dyn Iterator<Item = &f64>| v.filter(|x| **x != 0.0).count() == 1;
            count(&mut self.matrix.row(i).iter()) && count(&mut self.matrix.column(i).iter())
        });
        // A power of two has no digits but the leading one.
        let is_power = size.is_normal() && size.to_bits() & ((1 << 52) - 1) == 0;
        one_each && is_power && { entries }.all(|x| x.abs() == size)
    }

    /// The BREP under this map. Under one that mirrors, faces are reversed where they were not.
    ///
    /// # Errors
    /// [`MapError`]: uneven scaling of circles, or results the kernel refuses.
    ///
    /// # Cost
    /// O(size).
    pub fn apply(&self, brep: &Brep) -> Result<Moved, MapError> {
        let mut map = self.mapper()?;
        let (scale, off) = (map.scale, map.off);
        let mut parts = brep.parts().clone();
        for surface in &mut parts.surfaces {
            *surface = map.surface(surface)?;
        }
        for curve in &mut parts.curves3 {
            *curve = map.curve(curve, true)?;
        }
        for vertex in &mut parts.vertices {
            vertex.point = map.point(&vertex.point);
            vertex.tolerance = vertex.tolerance.map(|t| t * scale);
        }
        for edge in &mut parts.edges {
            edge.tolerance = edge.tolerance.map(|t| t * scale);
        }
        if map.mirrors {
            for face in &mut parts.faces {
                face.reversed = !face.reversed;
            }
        }
        let bound = if map.exact {
            0.0
        } else {
            let reach = map.largest * 3.0_f64.sqrt();
            let roundings = ROUNDINGS * f64::from(self.factors);
            let uneven = if map.natives {
                16.0 * off * scale * reach
            } else {
                0.0
            };
            let [stretch, shift] = self.through;
            roundings * (3.0_f64.sqrt() * stretch * reach + shift) + uneven
        };
        Ok(Moved {
            brep: Brep::new(parts)?,
            off: bound,
        })
    }

    /// A curve under this map, up to the same roundings.
    pub(crate) fn curve(&self, curve: &Curve3) -> Result<Curve3, MapError> {
        self.mapper()?.curve(curve, true)
    }

    /// A surface under this map, up to the same roundings.
    pub(crate) fn surface(&self, surface: &Surface) -> Result<Surface, MapError> {
        self.mapper()?.surface(surface)
    }

    fn mapper(&self) -> Result<Mapper<'_>, MapError> {
        let determinant = self.matrix.determinant();
        if !(determinant.is_finite() && determinant != 0.0) {
            return Err(MapError::Singular { determinant });
        }
        let (scale, off) = self.scale();
        Ok(Mapper {
            map: self,
            scale,
            mirrors: determinant < 0.0,
            keeps_circles: (off <= SIMILAR).then_some(()),
            off,
            exact: self.keeps_digits() && self.factors == 1,
            largest: 0.0,
            natives: false,
        })
    }
}

/// Three digits of a bound, no less than it is: the nearest three are off by half of the last, a two-hundredth part at most.
pub(crate) fn rounded_up(bound: f64) -> String {
    if bound == 0.0 {
        return "0".to_owned();
    }
    /// Half of the third digit of 1.00, and what the product rounds.
    const UP: f64 = 1.0 + 0.005 + 1e-6;
    format!("{:.2e}", bound * UP)
}

/// First the inner, then the outer; `None` is the identity.
pub(crate) fn composed(outer: Option<&Affine>, inner: Option<&Affine>) -> Option<Affine> {
    match (outer, inner) {
        (Some(a), Some(b)) => Some(a.after(b)),
        (Some(a), None) | (None, Some(a)) => Some(a.clone()),
        (None, None) => None,
    }
}

/// A sum and whether nothing of it was rounded.
fn sum(a: f64, b: f64, exact: &mut bool) -> f64 {
    let s = a + b;
    // Knuth's two-sum: what s lacks.
    let b_part = s - a;
    let lost = (a - (s - b_part)) + (b - b_part);
    *exact &= lost == 0.0;
    s
}

fn product(a: f64, b: f64, exact: &mut bool) -> f64 {
    let p = a * b;
    *exact &= a == 0.0 || b == 0.0 || (p.is_normal() && a.mul_add(b, -p) == 0.0);
    p
}

struct Mapper<'m> {
    map: &'m Affine,
    scale: f64,
    mirrors: bool,
    /// There if circles stay circles.
    keeps_circles: Option<()>,
    off: f64,
    exact: bool,
    /// The largest coordinate met.
    largest: f64,
    natives: bool,
}

impl Mapper<'_> {
    /// `matrix v + translation w`.
    fn linear(&mut self, v: &Vector3<f64>, w: f64) -> Vector3<f64> {
        let mut result = Vector3::zeros();
        for i in 0..3 {
            let mut total = 0.0;
            for j in 0..3 {
                let term = product(self.map.matrix[(i, j)], v[j], &mut self.exact);
                total = sum(total, term, &mut self.exact);
            }
            let shift = product(self.map.translation[i], w, &mut self.exact);
            result[i] = sum(total, shift, &mut self.exact);
        }
        result
    }

    fn point(&mut self, p: &Point3<f64>) -> Point3<f64> {
        self.largest = self.largest.max(p.coords.amax());
        Point3::from(self.linear(&p.coords, 1.0))
    }

    fn vector(&mut self, v: &Vector3<f64>) -> Vector3<f64> {
        self.linear(v, 0.0)
    }

    /// A direction about which things turn: mirrored, the turn goes the other way.
    fn axis(&mut self, v: &Vector3<f64>) -> Vector3<f64> {
        let moved = self.vector(v);
        if self.mirrors { -moved } else { moved }
    }

    /// A direction of the same length.
    fn direction(&mut self, v: &Vector3<f64>) -> Vector3<f64> {
        let moved = self.vector(v);
        moved.map(|x| {
            let q = x / self.scale;
            self.exact &= product(q, self.scale, &mut true) == x;
            q
        })
    }

    fn place(&mut self, p: &Point3<f64>, moves: bool) -> Point3<f64> {
        if moves {
            self.point(p)
        } else {
            self.largest = self.largest.max(p.coords.amax());
            Point3::from(self.vector(&p.coords))
        }
    }

    fn homogeneous(&mut self, p: &Vector4<f64>, moves: bool) -> Vector4<f64> {
        self.largest = self.largest.max(p.xyz().amax() / p.w);
        let moved = self.linear(&p.xyz(), if moves { p.w } else { 0.0 });
        Vector4::new(moved.x, moved.y, moved.z, p.w)
    }

    fn circles(&mut self) -> Result<(), MapError> {
        self.natives = true;
        self.keeps_circles.ok_or(MapError::Uneven { off: self.off })
    }

    /// A curve; one that is a difference of places (`moves` false) turns but does not move.
    fn curve(&mut self, curve: &Curve3, moves: bool) -> Result<Curve3, MapError> {
        Ok(match curve {
            Curve::Line(l) => {
                let (from, to) = (self.place(&l.from, moves), self.place(&l.to, moves));
                Curve::Line(Line::new(from, to, l.domain)?)
            }
            Curve::Arc(a) => {
                self.circles()?;
                self.largest = self.largest.max(a.radius);
                Curve::Arc(Arc::new(Arc {
                    center: self.place(&a.center, moves),
                    x: self.direction(&a.x),
                    y: self.direction(&a.y),
                    z: if self.mirrors {
                        -self.direction(&a.z)
                    } else {
                        self.direction(&a.z)
                    },
                    radius: product(a.radius, self.scale, &mut self.exact),
                    angle: a.angle,
                    domain: a.domain,
                })?)
            }
            Curve::Polyline(p) => {
                let points = p.points().iter().map(|q| self.place(q, moves)).collect();
                Curve::Polyline(Polyline::new(points, p.params().to_vec())?)
            }
            Curve::Nurbs(n) => {
                let points = n.control_points().iter();
                let points = points.map(|p| self.homogeneous(p, moves)).collect();
                let knots = n.knots().knots().to_vec();
                Curve::Nurbs(NurbsCurve::new(n.degree(), points, knots)?)
            }
            // Segments are never poly-curves themselves.
            Curve::Poly(p) => {
                let segments = p.segments().iter().map(|s| self.curve(s, moves));
                let segments = segments.collect::<Result<_, _>>()?;
                Curve::Poly(PolyCurve::new(segments, p.params().to_vec())?)
            }
        })
    }

    fn surface(&mut self, surface: &Surface) -> Result<Surface, MapError> {
        Ok(match surface {
            Surface::Plane(p) => {
                for (axis, range) in [(p.x, p.extents[0]), (p.y, p.extents[1])] {
                    let far = range.start.abs().max(range.end.abs());
                    self.largest = self.largest.max(axis.amax() * far);
                }
                let origin = self.point(&p.origin);
                // Unit axes stay unit axes, where shapes are kept.
                let (x, y, extents) = if self.keeps_circles.is_some() {
                    let mut wider = |t| product(t, self.scale, &mut self.exact);
                    let extents = p.extents.map(|e| Interval {
                        start: wider(e.start),
                        end: wider(e.end),
                    });
                    (self.direction(&p.x), self.direction(&p.y), extents)
                } else {
                    (self.vector(&p.x), self.vector(&p.y), p.extents)
                };
                Surface::Plane(Plane::new(Plane {
                    origin,
                    x,
                    y,
                    domain: p.domain,
                    extents,
                })?)
            }
            Surface::Revolution(r) => {
                self.circles()?;
                Surface::Revolution(Revolution::new(Revolution {
                    origin: self.point(&r.origin),
                    axis: self.axis(&r.axis),
                    angle: r.angle,
                    angle_domain: r.angle_domain,
                    profile: self.curve(&r.profile, true)?,
                    transposed: r.transposed,
                })?)
            }
            Surface::Sum(s) => {
                self.largest = self.largest.max(s.base.amax());
                Surface::Sum(Sum {
                    base: self.vector(&s.base),
                    first: self.curve(&s.first, true)?,
                    second: self.curve(&s.second, false)?,
                })
            }
            Surface::Nurbs(n) => {
                let net = n.control_net().iter();
                let net = net.map(|p| self.homogeneous(p, true)).collect();
                let knots = [n.knots_u(), n.knots_v()].map(|k| k.knots().to_vec());
                let degrees = [n.knots_u().degree(), n.knots_v().degree()];
                Surface::Nurbs(NurbsSurface::new(degrees, n.counts(), net, knots)?)
            }
        })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use feeler::brep::BrepBuilder;
    use feeler::numeric::Dyadic;

    pub(crate) fn rows(m: &Affine) -> [[f64; 4]; 3] {
        [0, 1, 2].map(|i| {
            let r = m.matrix.row(i);
            [r[0], r[1], r[2], m.translation[i]]
        })
    }

    pub(crate) fn exact(x: f64) -> Dyadic {
        Dyadic::from_f64(x).expect("a number")
    }

    /// Exactly where a map of f64 takes a point.
    pub(crate) fn image(m: &[[f64; 4]; 3], p: &[Dyadic; 3]) -> [Dyadic; 3] {
        [0, 1, 2].map(|i| {
            let terms = [0, 1, 2].map(|j| &exact(m[i][j]) * &p[j]);
            terms.into_iter().fold(exact(m[i][3]), |a, b| &a + &b)
        })
    }

    fn turned(angle: f64, factor: f64, translation: [f64; 3]) -> Affine {
        let (sin, cos) = libm::sincos(angle);
        let [x, y, z] = translation;
        let (s, c) = (factor * sin, factor * cos);
        let rows = [
            c, -s, 0.0, x, s, c, 0.0, y, 0.0, 0.0, factor, z, 0.0, 0.0, 0.0, 1.0,
        ];
        Affine::from_rows(&rows).expect("a map")
    }

    /// Far away and back, large and back, many times: points are as near to where the exact product of the maps takes them as is said.
    #[test]
    fn products_of_maps_are_off_by_no_more_than_is_said() {
        let mut b = BrepBuilder::new();
        let corners = [[0.1, 0.2, 0.3], [1.7, 0.4, 0.3], [0.6, 2.3, 0.9]];
        let v = corners.map(|p| b.vertex(p));
        b.planar_face(&v).expect("a triangle");
        let brep = b.build().expect("a BREP");
        let mut most_of_bound: f64 = 0.0;
        for far in [0.0, 1.0, 1e3, 1e9, 1e15] {
            for (angle, factor) in [(0.0, 1.0), (0.7, 1.0), (0.7, 1e6), (2.1, 1e-6), (1.1, 3.0)] {
                let shift = [far * 0.3, far * 0.7, -far * 0.11];
                let there = turned(angle, factor, shift);
                // Nearly the inverse, rounded as readers do.
                let (sin, cos) = libm::sincos(angle);
                let [x, y, z] = shift;
                let back = turned(
                    -angle,
                    1.0 / factor,
                    [-(cos * x + sin * y), sin * x - cos * y, -z].map(|x| x / factor),
                );
                let maps = [
                    back.clone(),
                    there.clone(),
                    back,
                    there,
                    turned(0.3, 2.0, [0.1, 0.2, 0.3]),
                ];
                for count in 1..=maps.len() {
                    let whole = maps[1..count]
                        .iter()
                        .fold(maps[0].clone(), |inner, m| m.after(&inner));
                    let moved = whole.apply(&brep).expect("a similarity");
                    for (own, found) in brep
                        .parts()
                        .vertices
                        .iter()
                        .zip(&moved.brep.parts().vertices)
                    {
                        let p = [0, 1, 2].map(|c| exact(own.point[c]));
                        let known = maps[..count].iter().fold(p, |p, m| image(&rows(m), &p));
                        for c in 0..3 {
                            let off = (&exact(found.point[c]) - &known[c]).approximate().abs();
                            assert!(
                                off <= moved.off,
                                "{far} {angle} {factor} {count}: {off:e} {:e}",
                                moved.off
                            );
                            if off > 0.0 {
                                most_of_bound = most_of_bound.max(off / moved.off);
                            }
                        }
                    }
                }
            }
        }
        // The bound is none of anything.
        assert!(most_of_bound > 1e-4, "{most_of_bound:e}");
    }
}
