//! Queries about a model: random ones, and ones near trims, seams and edges.

use crate::random::Random;
use feeler_corpus::{
    ContactsLine, FacePoint, HalfSpaceLine, LineKindLine, LineLine, Model, Pose, QueryLine,
    SpacePoint, SphereLine,
};
use nalgebra::{Point2, Point3, Unit, UnitQuaternion, Vector2, Vector3};

/// How near is near: lengths relative to the model's (or the domain's) size.
pub(crate) const NEAR: [f64; 10] = [
    1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14, 1e-15,
];

/// A source of queries about one model.
pub(crate) struct Generator<'a> {
    pub(crate) model: &'a Model,
    pub(crate) random: Random,
    /// Longest side of the model's box.
    size: f64,
    /// Faces to aim at: those that are not flat where there are such, every other time.
    curved: Vec<usize>,
}

/// A point of a face, roughly, with its normal.
pub(crate) struct Aim {
    pub(crate) face: usize,
    pub(crate) uv: Point2<f64>,
    pub(crate) point: Point3<f64>,
    pub(crate) normal: Vector3<f64>,
}

impl<'a> Generator<'a> {
    pub(crate) fn new(model: &'a Model, seed: &str) -> Self {
        let mut generator = Self {
            model,
            random: Random::new(seed),
            size: feeler_gate::model_size(model),
            curved: Vec::new(),
        };
        generator.curved = (0..model.faces())
            .filter(|f| generator.is_curved(*f))
            .collect();
        generator
    }

    /// Longest side of the model's box.
    pub(crate) fn size(&self) -> f64 {
        self.size
    }

    fn face(&mut self) -> usize {
        if !self.curved.is_empty() && self.random.below(4) > 0 {
            self.curved[self.random.below(self.curved.len())]
        } else {
            self.random.below(self.model.faces())
        }
    }

    /// Whether the normal turns by more than rounding between a few points.
    fn is_curved(&self, face: usize) -> bool {
        let Some((b, f)) = self.model.face(face) else {
            return false;
        };
        let [du, dv] = self.model.breps[b].surface(f).domain();
        let normal = |s: f64, t: f64| {
            self.aim(face, Point2::new(du.lerp(s), dv.lerp(t)))
                .map(|a| a.normal)
        };
        let Some(first) = normal(0.3, 0.4) else {
            return true;
        };
        [(0.6, 0.4), (0.3, 0.7), (0.8, 0.9)].iter().any(|&(s, t)| {
            normal(s, t).is_none_or(|n| n.cross(&first).norm() > 1024.0 * f64::EPSILON)
        })
    }

    /// `None` where the surface is singular.
    fn aim(&self, face: usize, uv: Point2<f64>) -> Option<Aim> {
        let (b, f) = self.model.face(face)?;
        let brep = &self.model.breps[b];
        let all = brep.surface(f).derivatives(uv.x, uv.y, 1);
        let normal = all.get(1, 0).cross(&all.get(0, 1)).try_normalize(0.0)?;
        let outward = if brep.faces()[f].reversed {
            -normal
        } else {
            normal
        };
        Some(Aim {
            face,
            uv,
            point: all.get(0, 0).into(),
            normal: outward,
        })
    }

    /// A random uv of a face's domain.
    fn anywhere(&mut self, face: usize) -> Point2<f64> {
        let Some((b, f)) = self.model.face(face) else {
            return Point2::origin();
        };
        let [du, dv] = self.model.breps[b].surface(f).domain();
        Point2::new(du.lerp(self.random.unit()), dv.lerp(self.random.unit()))
    }

    /// A uv within one of [`NEAR`] (relative to the domain) of a trim of the face, on either
    /// side of it; at times on it, up to the rounding of the point.
    fn near_trim(&mut self, face: usize) -> Option<Point2<f64>> {
        let (b, f) = self.model.face(face)?;
        let brep = &self.model.breps[b];
        let parts = brep.parts();
        let loops = brep.faces()[f].loops.as_ref().filter(|l| !l.is_empty())?;
        let trims = &parts.loops[loops[self.random.below(loops.len())]].trims;
        if trims.is_empty() {
            return None;
        }
        let trim = &parts.trims[trims[self.random.below(trims.len())]];
        let curve = &parts.curves2[trim.curve];
        // One in eight at an end, where trims meet.
        let s = match self.random.below(16) {
            0 => 0.0,
            1 => 1.0,
            _ => self.random.unit(),
        };
        let t = trim.span.lerp(s);
        let both = curve.derivatives(t, 1);
        let (at, along) = (both[0], both[1]);
        let across = Vector2::new(-along.y, along.x).try_normalize(0.0)?;
        let [du, dv] = brep.surface(f).domain();
        let scale = du.length().max(dv.length());
        let off = match self.random.below(NEAR.len() + 1) {
            k if k < NEAR.len() => NEAR[k] * self.random.sign() * scale,
            _ => 0.0,
        };
        let uv = at + across * off;
        Some(Point2::from(uv))
    }

    /// A uv within one of [`NEAR`] of the border of the domain, inside.
    fn near_border(&mut self, face: usize) -> Point2<f64> {
        let mut uv = self.anywhere(face);
        if let Some((b, f)) = self.model.face(face) {
            let domain = self.model.breps[b].surface(f).domain();
            let k = self.random.below(2);
            let near = NEAR[self.random.below(NEAR.len())];
            let s = [near, 1.0 - near][self.random.below(2)];
            uv[k] = domain[k].lerp(s);
        }
        uv
    }

    /// A point of a face near one of its trims (of its border where nothing is trimmed), or anywhere.
    pub(crate) fn target(&mut self, near: bool) -> Aim {
        // A model may have no trims at all.
        let trimmed = (0..self.model.faces()).any(|f| {
            let face = self.model.face(f);
            let face = face.map(|(b, f)| &self.model.breps[b].faces()[f]);
            face.is_some_and(|f| f.loops.as_ref().is_some_and(|l| !l.is_empty()))
        });
        loop {
            let face = self.face();
            let uv = match (near, trimmed) {
                (true, true) => self.near_trim(face),
                (true, false) => Some(self.near_border(face)),
                (false, _) => Some(self.anywhere(face)),
            };
            if let Some(aim) = uv.and_then(|uv| self.aim(face, uv)) {
                return aim;
            }
        }
    }

    /// One of [`NEAR`].
    pub(crate) fn near(&mut self) -> f64 {
        NEAR[self.random.below(NEAR.len())]
    }

    /// The same probe, up to roundings, from a pose: turned, and moved by up to the model's size.
    pub(crate) fn posed(&mut self, query: QueryLine) -> QueryLine {
        let axis = Unit::new_normalize(self.random.direction());
        let turn = UnitQuaternion::from_axis_angle(&axis, self.random.between(-3.0, 3.0));
        let shift = self.random.direction() * (self.random.unit() * self.size);
        let back = |v: [f64; 3]| -> Vector3<f64> { turn.inverse_transform_vector(&v.into()) };
        let place = |p: [f64; 3]| -> [f64; 3] { back((Vector3::from(p) - shift).into()).into() };
        QueryLine {
            pose: Some(Pose {
                translation: shift.into(),
                rotation: turn.coords.into(),
            }),
            sphere: query.sphere.map(|s| SphereLine {
                center: place(s.center),
                ..s
            }),
            half_space: query.half_space.map(|h| HalfSpaceLine {
                normal: back(h.normal).normalize().into(),
                offset: h.offset - Vector3::from(h.normal).dot(&shift),
            }),
            line: query.line.map(|l| LineLine {
                origin: place(l.origin),
                direction: back(l.direction).into(),
                ..l
            }),
            ..query
        }
    }

    /// A length that is small or moderate, with sign.
    fn offset(&mut self) -> f64 {
        let scale = match self.random.below(3) {
            0 => NEAR[self.random.below(NEAR.len())],
            1 => self.random.between(0.001, 0.01),
            _ => self.random.between(0.02, 0.2),
        };
        scale * self.size * self.random.sign()
    }

    pub(crate) fn sphere(&mut self, near: bool) -> QueryLine {
        let aim = self.target(near);
        let height = self.offset();
        let center = aim.point + aim.normal * height;
        // Touching within `NEAR`, or of any size.
        let radius = match self.random.below(2) {
            0 => (height.abs() + NEAR[self.random.below(NEAR.len())] * self.random.sign()).abs(),
            _ => self.random.between(0.0, 0.2) * self.size,
        };
        QueryLine {
            sphere: Some(SphereLine {
                center: center.coords.into(),
                radius,
            }),
            ..QueryLine::default()
        }
    }

    pub(crate) fn half_space(&mut self, near: bool) -> QueryLine {
        let normal = if near {
            // The normal of a face near its border, tilted a little: the support is there
            // wherever the part is convex.
            let aim = self.target(true);
            let tilt = NEAR[self.random.below(NEAR.len())];
            (self.random.direction() * tilt - aim.normal).normalize()
        } else {
            self.random.direction()
        };
        let offset = self.random.between(-0.5, 0.5) * self.size;
        QueryLine {
            half_space: Some(HalfSpaceLine {
                normal: normal.into(),
                offset,
            }),
            ..QueryLine::default()
        }
    }

    /// All contacts: of balls that touch in one place and in several, and of half-spaces.
    pub(crate) fn contacts(&mut self, near: bool) -> QueryLine {
        let prediction = match self.random.below(4) {
            0 => 0.0,
            1 => NEAR[self.random.below(4)],
            _ => self.random.between(0.0, 0.25),
        } * self.size;
        let query = match self.random.below(4) {
            0 => self.half_space_above(near),
            1 => self.between(),
            _ => self.sphere(near),
        };
        QueryLine {
            prediction: Some(prediction),
            contacts: Some(ContactsLine::All),
            ..query
        }
    }

    /// A half-space that touches a face's tangent plane, more or less.
    fn half_space_above(&mut self, near: bool) -> QueryLine {
        let aim = self.target(near);
        let tilt = self.random.between(0.0, 0.3);
        let normal = (self.random.direction() * tilt - aim.normal).normalize();
        let offset = normal.dot(&aim.point.coords) + self.random.between(-0.1, 0.1) * self.size;
        QueryLine {
            half_space: Some(HalfSpaceLine {
                normal: normal.into(),
                offset,
            }),
            ..QueryLine::default()
        }
    }

    /// A ball midway, about, between two points of the model: near a medial axis where they face each other.
    fn between(&mut self) -> QueryLine {
        let (a, b) = (self.target(false), self.target(false));
        let middle = a.point + (b.point - a.point) * 0.5;
        let off = NEAR[self.random.below(NEAR.len())] * self.size;
        let center = middle + self.random.direction() * off;
        let radius = 0.5 * (b.point - a.point).norm() * self.random.between(0.5, 1.1);
        QueryLine {
            sphere: Some(SphereLine {
                center: center.coords.into(),
                radius,
            }),
            ..QueryLine::default()
        }
    }

    pub(crate) fn line(&mut self, near: bool) -> QueryLine {
        let aim = self.target(near);
        let across = self.random.direction();
        // One in four nearly tangent.
        let direction = if self.random.below(4) == 0 {
            let tilt = NEAR[self.random.below(4)];
            let tangent = across - aim.normal * across.dot(&aim.normal);
            tangent + aim.normal * tilt
        } else {
            across
        };
        let length = self.random.between(0.1, 2.0);
        let direction = direction * (length * self.size);
        let back = self.random.between(0.2, 0.8);
        let kind = match self.random.below(3) {
            0 => LineKindLine::Line,
            1 => LineKindLine::Ray,
            _ => LineKindLine::Segment,
        };
        QueryLine {
            line: Some(LineLine {
                origin: (aim.point - direction * back).coords.into(),
                direction: direction.into(),
                kind,
            }),
            ..QueryLine::default()
        }
    }

    pub(crate) fn side(&mut self, near: bool) -> QueryLine {
        let aim = self.target(near);
        QueryLine {
            side: Some(FacePoint {
                face: aim.face,
                uv: aim.uv.coords.into(),
            }),
            ..QueryLine::default()
        }
    }

    /// Near: at 1e-6 to 1e-15 of a trim, cut with the domain (often at its border, a seam).
    pub(crate) fn evaluate(&mut self, near: bool) -> QueryLine {
        let aim = self.target(near);
        let mut uv = aim.uv;
        if let Some((b, f)) = self.model.face(aim.face) {
            let [du, dv] = self.model.breps[b].surface(f).domain();
            uv.x = uv.x.clamp(du.start, du.end);
            uv.y = uv.y.clamp(dv.start, dv.end);
        }
        QueryLine {
            evaluate: Some(FacePoint {
                face: aim.face,
                uv: uv.coords.into(),
            }),
            ..QueryLine::default()
        }
    }

    pub(crate) fn inside(&mut self, near: bool) -> QueryLine {
        let aim = self.target(near);
        let point = aim.point + aim.normal * self.offset();
        QueryLine {
            inside: Some(SpacePoint {
                point: point.coords.into(),
            }),
            ..QueryLine::default()
        }
    }
}
