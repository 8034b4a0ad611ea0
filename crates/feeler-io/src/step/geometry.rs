//! Points, placements, curves and surfaces: from entities to the forms that OCCT's `.brep` has, whose way into the kernel they share.
//!
//! | in the file | as |
//! |---|---|
//! | line, circle, ellipse, parabola, hyperbola | the same |
//! | B-spline curve or surface, rational or not, with knots, uniform, quasi-uniform, Bezier | B-spline with its knots written out |
//! | polyline | B-spline of degree 1 |
//! | trimmed curve, rectangular trimmed surface | its basis: edges and loops say the part |
//! | plane, cylinder, cone, sphere, torus | the same |
//! | surface of extrusion, of revolution | the same; a profile that is an ellipse or a hyperbola as rational quadratics |
//! | anything else | refused by name |

use super::entities::{Entities, Entity, form, shape, unsupported};
use crate::error::ReadError;
use crate::occt::curves::{Budget, Form, Frame, MAX_NESTED};
use crate::occt::splines::Knots;
use crate::occt::surfaces::{Axes, Form3};
use feeler::nurbs::{Curve, KnotVector};
use nalgebra::{Point, Point3, SVector, Vector3, Vector4};
use std::f64::consts::TAU;

/// A direction whose length is 1 up to this is taken as it stands: two roundings of its square.
const UNIT: f64 = 4.0 * f64::EPSILON;

/// The shortest part of a direction that still tells one, when it is made orthogonal to an axis.
const LEAST: f64 = 1.0 / (1 << 26) as f64;

/// How much more a file's uses of edges may become.
pub(super) struct Left {
    /// How many pieces of curves on elementary surfaces may still be proven here: some 25 us each.
    pub(super) pieces: usize,
    /// How many numbers the uses and the curves made for them may still hold: what a loop names at a few bytes, over and over, is to hold no
    /// more than a multiple of the file.
    pub(super) held: Budget,
    /// How many samples may be held at once, of a surface and of an edge, beside those that each of their knots has.
    pub(super) samples: usize,
}

/// What the entities' numbers mean, and how many more may be made of them.
pub(super) struct Geometry<'e> {
    pub(super) entities: &'e Entities,
    /// Radians in the file's unit of angle.
    pub(super) angle: f64,
    pub(super) numbers: Budget,
    /// How much proof the kernel may still be asked for, in pieces of cubics on bicubic patches: some 1 ms each.
    pub(super) proofs: usize,
    /// How much memory the kernel may take for the proof of an image, with what [`Left::held`] counts or the bodies take.
    pub(super) proof_bytes: usize,
    /// What the bodies take that are made.
    pub(super) kept_bytes: usize,
    pub(super) left: Left,
}

/// The curve of an edge: in space, whether the file's runs with it, and the curves in uv beside it.
pub(super) struct EdgeForm {
    pub(super) form: Form<3, 4>,
    pub(super) forward: bool,
    pub(super) pcurves: Vec<u64>,
}

fn unit<const D: usize>(v: SVector<f64, D>) -> Option<SVector<f64, D>> {
    let square = v.norm_squared();
    if !(square.is_finite() && square > f64::MIN_POSITIVE) {
        return None;
    }
    Some(if (square - 1.0).abs() <= UNIT {
        v
    } else {
        v / square.sqrt()
    })
}

pub(super) fn nurbs_remedy() -> &'static str {
    "convert it to a B-spline in the program that wrote it and export it again"
}

impl Geometry<'_> {
    fn coordinates<const D: usize>(&self, e: Entity<'_>) -> Result<SVector<f64, D>, ReadError> {
        let numbers = e.numbers(1)?;
        let all: Result<[f64; D], _> = numbers.try_into();
        all.map(SVector::from).map_err(|_| {
            shape(
                e.id,
                format!("a point or direction of other than {D} coordinates"),
            )
        })
    }

    fn point<const D: usize>(&self, from: u64, id: u64) -> Result<Point<f64, D>, ReadError> {
        let e = self
            .entities
            .expect(from, id, "CARTESIAN_POINT", "a point")?;
        Ok(Point::from(self.coordinates(e)?))
    }

    pub(super) fn point3(&self, from: u64, id: u64) -> Result<Point3<f64>, ReadError> {
        self.point(from, id)
    }

    fn direction<const D: usize>(&self, from: u64, id: u64) -> Result<SVector<f64, D>, ReadError> {
        let e = self.entities.expect(from, id, "DIRECTION", "a direction")?;
        unit(self.coordinates(e)?).ok_or_else(|| shape(id, "a direction of no length"))
    }

    fn vector<const D: usize>(&self, from: u64, id: u64) -> Result<SVector<f64, D>, ReadError> {
        let e = self.entities.expect(from, id, "VECTOR", "a vector")?;
        Ok(self.direction::<D>(id, e.reference(1)?)? * e.number(2)?)
    }

    /// A placement in space; its axes are orthonormal and right-handed.
    pub(super) fn axes(&self, from: u64, id: u64) -> Result<Axes, ReadError> {
        let e = self
            .entities
            .expect(from, id, "AXIS2_PLACEMENT_3D", "a placement")?;
        let origin = self.point::<3>(id, e.reference(1)?)?;
        let z = match e.optional(2) {
            Some(axis) => self.direction::<3>(id, axis)?,
            None => Vector3::z(),
        };
        let given = match e.optional(3) {
            Some(reference) => Some(self.direction::<3>(id, reference)?),
            None => None,
        };
        let across = |v: Vector3<f64>| {
            let along = v.dot(&z);
            let rest = if along.abs() <= UNIT {
                v
            } else {
                v - z * along
            };
            let x = (rest.norm() > LEAST).then(|| unit(rest)).flatten()?;
            // Where little was left, that has much of the axis' rounding: once more is enough.
            let along = x.dot(&z);
            if along.abs() <= UNIT {
                Some(x)
            } else {
                unit(x - z * along)
            }
        };
        // What the standard says where none is given, or none that tells.
        let choices = [given, Some(Vector3::x()), Some(Vector3::y())];
        let x = choices.into_iter().flatten().find_map(across);
        let x = x.ok_or_else(|| shape(id, "a placement without directions"))?;
        Ok(Axes {
            origin,
            z,
            x,
            y: z.cross(&x),
        })
    }

    fn frame<const D: usize>(&self, from: u64, id: u64) -> Result<Frame<D>, ReadError> {
        if D == 3 {
            let a = self.axes(from, id)?;
            let of = |v: &Vector3<f64>| SVector::from_fn(|i, _| v.get(i).copied().unwrap_or(0.0));
            return Ok(Frame {
                center: Point::from(of(&a.origin.coords)),
                x: of(&a.x),
                y: of(&a.y),
                z: of(&a.z),
            });
        }
        let e = self
            .entities
            .expect(from, id, "AXIS2_PLACEMENT_2D", "a placement")?;
        let center = self.point(id, e.reference(1)?)?;
        let mut x = SVector::<f64, D>::zeros();
        x[0] = 1.0;
        if let Some(reference) = e.optional(2) {
            x = self.direction(id, reference)?;
        }
        let mut y = SVector::zeros();
        y[0] = -x[1];
        y[1] = x[0];
        Ok(Frame {
            center,
            x,
            y,
            z: SVector::zeros(),
        })
    }

    fn length(&self, e: Entity<'_>, index: usize) -> Result<f64, ReadError> {
        let r = e.number(index)?;
        if r > 0.0 {
            Ok(r)
        } else {
            Err(shape(e.id, format!("a radius of {r:?}")))
        }
    }

    /// The curve of an edge.
    pub(super) fn edge_form(&mut self, from: u64, id: u64) -> Result<EdgeForm, ReadError> {
        let mut result = EdgeForm {
            form: Form::Offset,
            forward: true,
            pcurves: Vec::new(),
        };
        let mut at = id;
        for _ in 0..MAX_NESTED {
            let with_pcurves = ["SURFACE_CURVE", "SEAM_CURVE", "INTERSECTION_CURVE"];
            let found = with_pcurves.iter().find_map(|k| self.entities.part(at, k));
            if let Some(e) = found {
                // In one part the name comes first.
                let first = usize::from(self.entities.simple(at).is_some());
                let (inner, beside) = match self.entities.part(at, "SURFACE_CURVE") {
                    Some(s) if first == 0 => (s.reference(0)?, s.references(1)?),
                    _ => (e.reference(1)?, e.references(2)?),
                };
                result.pcurves = beside;
                at = inner;
            } else if let Some(e) = self.entities.part(at, "TRIMMED_CURVE") {
                result.forward ^= !e.flag(4)?;
                at = e.reference(1)?;
            } else {
                result.form = self.curve(from, at, 0)?;
                return Ok(result);
            }
        }
        Err(shape(id, "curves defined by each other too deep"))
    }

    /// A curve.
    pub(super) fn curve<const D: usize, const H: usize>(
        &mut self,
        from: u64,
        id: u64,
        depth: u32,
    ) -> Result<Form<D, H>, ReadError> {
        if depth >= MAX_NESTED {
            return Err(shape(id, "curves defined by each other too deep"));
        }
        let entities = self.entities;
        if let Some(e) = entities.part(id, "B_SPLINE_CURVE") {
            return self.spline(id, e, 0);
        }
        let Some(e) = entities.simple(id) else {
            if entities.kinds(id).next().is_none() {
                return Err(entities.unexpected(from, id, "a curve"));
            }
            let what = format!("a curve of kind {}", entities.described(id));
            return Err(unsupported(id, what, nurbs_remedy()));
        };
        self.numbers.take(2 * H).map_err(form(id))?;
        match e.name {
            "LINE" => Ok(Form::Line {
                from: self.point(id, e.reference(1)?)?,
                direction: self.vector(id, e.reference(2)?)?,
            }),
            "CIRCLE" => Ok(Form::Circle(
                self.frame(id, e.reference(1)?)?,
                self.length(e, 2)?,
            )),
            "ELLIPSE" => Ok(Form::Ellipse(
                self.frame(id, e.reference(1)?)?,
                [self.length(e, 2)?, self.length(e, 3)?],
            )),
            "PARABOLA" => Ok(Form::Parabola(
                self.frame(id, e.reference(1)?)?,
                self.length(e, 2)?,
            )),
            "HYPERBOLA" => Ok(Form::Hyperbola(
                self.frame(id, e.reference(1)?)?,
                [self.length(e, 2)?, self.length(e, 3)?],
            )),
            "POLYLINE" => {
                let ids = e.references(1)?;
                self.numbers.take(H * ids.len()).map_err(form(id))?;
                let points = self.points::<D, H>(id, &ids)?;
                let n = points.len();
                let last = n.saturating_sub(1);
                let knots = (0..n).map(|i| (i as f64, if i == 0 || i == last { 2 } else { 1 }));
                let knots = Knots::new(1, false, n, knots.collect()).map_err(form(id))?;
                Ok(Form::Spline(knots, points))
            }
            "B_SPLINE_CURVE_WITH_KNOTS"
            | "BEZIER_CURVE"
            | "UNIFORM_CURVE"
            | "QUASI_UNIFORM_CURVE" => self.spline(id, e, 1),
            // Edges see to their own; of a profile it turns the surface over.
            "TRIMMED_CURVE" if !e.flag(4)? => Err(unsupported(
                id,
                "a TRIMMED_CURVE against its basis, as part of a surface,",
                nurbs_remedy(),
            )),
            "TRIMMED_CURVE" | "SURFACE_CURVE" | "SEAM_CURVE" | "INTERSECTION_CURVE" => {
                self.curve(id, e.reference(1)?, depth + 1)
            }
            _ => Err(unsupported(
                id,
                format!("a curve of kind {}", entities.described(id)),
                nurbs_remedy(),
            )),
        }
    }

    fn points<const D: usize, const H: usize>(
        &self,
        from: u64,
        ids: &[u64],
    ) -> Result<Vec<SVector<f64, H>>, ReadError> {
        let mut all = Vec::with_capacity(ids.len());
        for p in ids {
            let p = self.point::<D>(from, *p)?;
            all.push(SVector::from_fn(|i, _| {
                p.coords.get(i).copied().unwrap_or(1.0)
            }));
        }
        Ok(all)
    }

    /// A B-spline curve: attributes start at `first` in the part that has the degree.
    fn spline<const D: usize, const H: usize>(
        &mut self,
        id: u64,
        e: Entity<'_>,
        first: usize,
    ) -> Result<Form<D, H>, ReadError> {
        let degree = self.degree(e, first)?;
        let ids = e.references(first + 1)?;
        self.numbers.take(H * ids.len()).map_err(form(id))?;
        let mut points = self.points::<D, H>(id, &ids)?;
        if let Some(r) = self.entities.part(id, "RATIONAL_B_SPLINE_CURVE") {
            let weights = r.numbers(0)?;
            if weights.len() != points.len() {
                return Err(shape(id, "not as many weights as control points"));
            }
            for (p, w) in points.iter_mut().zip(weights) {
                *p *= w;
            }
        }
        let written = match self.entities.part(id, "B_SPLINE_CURVE_WITH_KNOTS") {
            Some(k) => {
                let at = if first == 0 { 0 } else { 6 };
                Some((k.integers(at)?, k.numbers(at + 1)?))
            }
            None => None,
        };
        let knots = self.knots(id, "CURVE", degree, points.len(), written)?;
        Ok(Form::Spline(knots, points))
    }

    fn degree(&self, e: Entity<'_>, index: usize) -> Result<usize, ReadError> {
        let degree = e.integer(index)?;
        if (1..=KnotVector::MAX_DEGREE).contains(&degree) {
            return Ok(degree);
        }
        let what = format!(
            "a B-spline of degree {degree} (1 to {} are)",
            KnotVector::MAX_DEGREE
        );
        Err(unsupported(
            e.id,
            what,
            "approximate it by one of lower degree",
        ))
    }

    /// The knots, where they are written, or else by the kind of spline: `BEZIER_`, `UNIFORM_` or `QUASI_UNIFORM_`.
    fn knots(
        &mut self,
        id: u64,
        of: &'static str,
        degree: usize,
        count: usize,
        written: Option<(Vec<usize>, Vec<f64>)>,
    ) -> Result<Knots, ReadError> {
        let is = |kind: &str| self.entities.is(id, &format!("{kind}_{of}"));
        let distinct: Vec<(f64, usize)> = match written {
            Some((multiplicities, knots)) => {
                let increasing = knots.windows(2).all(|w| w[0] < w[1]);
                let fits = multiplicities.iter().all(|m| (1..=degree + 1).contains(m));
                if multiplicities.len() != knots.len() || !increasing || !fits {
                    return Err(shape(
                        id,
                        "knots that do not increase, or whose multiplicities do not fit them",
                    ));
                }
                knots.into_iter().zip(multiplicities).collect()
            }
            None if count <= degree => Vec::new(),
            None if is("UNIFORM") => (0..=count + degree)
                .map(|i| (i as f64 - degree as f64, 1))
                .collect(),
            None if is("QUASI_UNIFORM") => {
                let last = count - degree;
                let ends = |i: usize| if i == 0 || i == last { degree + 1 } else { 1 };
                (0..=last).map(|i| (i as f64, ends(i))).collect()
            }
            None if is("BEZIER") && (count - 1).is_multiple_of(degree) => {
                let last = (count - 1) / degree;
                let ends = |i: usize| {
                    if i == 0 || i == last {
                        degree + 1
                    } else {
                        degree
                    }
                };
                (0..=last).map(|i| (i as f64, ends(i))).collect()
            }
            None => return Err(shape(id, "a B-spline without knots")),
        };
        Knots::new(degree, false, count, distinct).map_err(form(id))
    }

    /// A surface.
    pub(super) fn surface(&mut self, from: u64, id: u64, depth: u32) -> Result<Form3, ReadError> {
        let entities = self.entities;
        if depth >= MAX_NESTED {
            return Err(shape(id, "surfaces defined by each other too deep"));
        }
        if let Some(e) = entities.part(id, "B_SPLINE_SURFACE") {
            return self.net(id, e, 0);
        }
        let Some(e) = entities.simple(id) else {
            if entities.kinds(id).next().is_none() {
                return Err(entities.unexpected(from, id, "a surface"));
            }
            let what = format!("a surface of kind {}", entities.described(id));
            return Err(unsupported(id, what, nurbs_remedy()));
        };
        let axes = |this: &Self| this.axes(id, e.reference(1)?);
        Ok(match e.name {
            "PLANE" => Form3::Plane(axes(self)?),
            "CYLINDRICAL_SURFACE" => Form3::Cylinder(axes(self)?, self.length(e, 2)?),
            "CONICAL_SURFACE" => {
                let radius = e.number(2)?;
                let half = e.number(3)? * self.angle;
                if !(radius >= 0.0 && half.abs() > LEAST && half.abs() < 0.25 * TAU - LEAST) {
                    return Err(shape(
                        id,
                        format!("a cone of radius {radius:?} and half angle {half:?}"),
                    ));
                }
                Form3::Cone(axes(self)?, radius, half)
            }
            "SPHERICAL_SURFACE" => Form3::Sphere(axes(self)?, self.length(e, 2)?),
            "TOROIDAL_SURFACE" => {
                Form3::Torus(axes(self)?, [self.length(e, 2)?, self.length(e, 3)?])
            }
            "SURFACE_OF_LINEAR_EXTRUSION" => {
                let profile = self.profile(id, e.reference(1)?)?;
                Form3::Extrusion(self.vector(id, e.reference(2)?)?, Box::new(profile))
            }
            "SURFACE_OF_REVOLUTION" => {
                let profile = self.profile(id, e.reference(1)?)?;
                let place = e.reference(2)?;
                let a = entities.expect(id, place, "AXIS1_PLACEMENT", "an axis")?;
                let origin = self.point(place, a.reference(1)?)?;
                let axis = match a.optional(2) {
                    Some(axis) => self.direction(place, axis)?,
                    None => Vector3::z(),
                };
                Form3::Revolution(origin, axis, Box::new(profile))
            }
            "RECTANGULAR_TRIMMED_SURFACE" => {
                if e.flag(6)? != e.flag(7)? {
                    return Err(unsupported(
                        id,
                        "a RECTANGULAR_TRIMMED_SURFACE that turns its basis over",
                        nurbs_remedy(),
                    ));
                }
                return self.surface(id, e.reference(1)?, depth + 1);
            }
            "B_SPLINE_SURFACE_WITH_KNOTS"
            | "BEZIER_SURFACE"
            | "UNIFORM_SURFACE"
            | "QUASI_UNIFORM_SURFACE" => return self.net(id, e, 1),
            _ => {
                let what = format!("a surface of kind {}", entities.described(id));
                return Err(unsupported(id, what, nurbs_remedy()));
            }
        })
    }

    /// A curve that a surface is made of. An ellipse, which has another parameter in the kernel, becomes a B-spline here: the curves in uv are made
    /// to fit.
    fn profile(&mut self, from: u64, id: u64) -> Result<Form<3, 4>, ReadError> {
        let profile = self.curve::<3, 4>(from, id, 0)?;
        // Of a hyperbola a part is taken once it is known how far the body reaches: [`hyperbola`](super::hyperbola).
        if !matches!(profile, Form::Ellipse(..)) {
            return Ok(profile);
        }
        let (part, _) = profile
            .part([0.0, TAU], &mut self.numbers)
            .map_err(form(id))?;
        let Curve::Nurbs(n) = part else {
            return Err(shape(id, "an ellipse"));
        };
        let mut distinct: Vec<(f64, usize)> = Vec::new();
        for &k in n.knots().knots() {
            match distinct.last_mut() {
                Some((last, m)) if *last == k => *m += 1,
                _ => distinct.push((k, 1)),
            }
        }
        let points = n.control_points().to_vec();
        let knots = Knots::new(n.degree(), false, points.len(), distinct).map_err(form(id))?;
        Ok(Form::Spline(knots, points))
    }

    /// A B-spline surface.
    fn net(&mut self, id: u64, e: Entity<'_>, first: usize) -> Result<Form3, ReadError> {
        use super::part21::Attribute;
        let degrees = [self.degree(e, first)?, self.degree(e, first + 1)?];
        let rows = e.list(first + 2)?;
        let of_row = |row: &Attribute| match row {
            Attribute::List(row) => row.len(),
            _ => 0,
        };
        let mut net: Vec<Vector4<f64>> = Vec::with_capacity(rows.iter().map(of_row).sum());
        let mut counts = [rows.len(), 0];
        let uneven = || shape(id, "a net of control points whose rows differ");
        for row in rows {
            let Attribute::List(row) = row else {
                return Err(uneven());
            };
            if counts[1] == 0 {
                counts[1] = row.len();
            }
            if row.len() != counts[1] {
                return Err(uneven());
            }
            self.numbers.take(4 * row.len()).map_err(form(id))?;
            for p in row {
                let Attribute::EntityRef(p) = p else {
                    return Err(uneven());
                };
                let p = self.point::<3>(id, *p)?;
                net.push(p.coords.push(1.0));
            }
        }
        if let Some(r) = self.entities.part(id, "RATIONAL_B_SPLINE_SURFACE") {
            let mut at = 0;
            for row in r.list(0)? {
                let Attribute::List(row) = row else {
                    return Err(uneven());
                };
                for w in row {
                    let (Attribute::Real(w), Some(p)) = (w, net.get_mut(at)) else {
                        return Err(shape(id, "weights that do not go with the control points"));
                    };
                    *p *= *w;
                    at += 1;
                }
            }
            if at != net.len() {
                return Err(shape(id, "weights that do not go with the control points"));
            }
        }
        let mut written = [None, None];
        if let Some(k) = self.entities.part(id, "B_SPLINE_SURFACE_WITH_KNOTS") {
            let at = if first == 0 { 0 } else { 8 };
            written = [
                Some((k.integers(at)?, k.numbers(at + 2)?)),
                Some((k.integers(at + 1)?, k.numbers(at + 3)?)),
            ];
        }
        let [u, v] = written;
        let u = self.knots(id, "SURFACE", degrees[0], counts[0], u)?;
        let v = self.knots(id, "SURFACE", degrees[1], counts[1], v)?;
        Ok(Form3::Spline([u, v], net))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Also where the reference direction is nearly the axis, of which little is left.
    #[test]
    fn axes_are_orthogonal_to_the_last_digit() {
        for z in ["1.,2.,3.", "0.3,-0.7,0.2", "-5.,1.,0.4"] {
            let first: f64 = z.split(',').next().unwrap().parse().unwrap();
            let rest = z.split_once(',').unwrap().1;
            let text = format!(
                "ISO-10303-21;HEADER;ENDSEC;DATA;#1=CARTESIAN_POINT('',(0.,0.,0.));#2=DIRECTION('',({z}));\
                 #3=DIRECTION('',({:?},{rest}));#4=AXIS2_PLACEMENT_3D('',#1,#2,#3);ENDSEC;",
                first * (1.0 + 1e-6)
            );
            let graph = super::super::part21::parse(text.as_bytes()).unwrap();
            let geometry = Geometry {
                entities: &Entities::new(graph),
                angle: 1.0,
                proofs: 0,
                proof_bytes: 0,
                kept_bytes: 0,
                left: Left {
                    pieces: 0,
                    held: Budget::new(0),
                    samples: 0,
                },
                numbers: Budget::new(0),
            };
            let a = geometry.axes(4, 4).unwrap();
            assert!(a.x.dot(&a.z).abs() <= UNIT, "{:e}", a.x.dot(&a.z));
            assert!((a.x.norm() - 1.0).abs() <= UNIT);
        }
    }
}
