//! A BREP and queries about it: from bytes, from text, and back to text.

use crate::loops::{Loops, Use, aimed, domain};
use crate::source::{HALF, Source};
use crate::surfaces::{body, level, sheet};
use feeler::brep::Brep;
use feeler_corpus::{
    AccuracyLine, ContactsLine, FacePoint, HalfSpaceLine, Hits, LineKindLine, LineLine, Model,
    QueryLine, SpacePoint, SphereLine, TrimLine,
};
use nalgebra::{Point3, Vector3};
use std::path::Path;

/// Inputs are no longer than this; a seed that is, is left out.
pub const LARGEST_INPUT: usize = 16 * 1024;

/// What a scene's queries ask.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Sides of points in uv, next to trim loops.
    Side,
    /// Balls.
    Sphere,
    /// Half-spaces.
    HalfSpace,
    /// Lines, and sides of points in space.
    Line,
    /// Points of surfaces and derivatives.
    Evaluate,
    /// Where coordinates of trim curves are stationary.
    Split,
}

/// A BREP and queries about it.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The BREP.
    pub brep: Brep,
    /// About it; all valid.
    pub queries: Vec<QueryLine>,
}

impl Scene {
    /// From bytes; none where they make no valid geometry. Text (see [`to_text`](Self::to_text)) is taken as it is, whatever it asks.
    pub fn decode(kind: Kind, bytes: &[u8]) -> Option<Self> {
        if bytes.first() == Some(&b'{') {
            return Self::from_text(std::str::from_utf8(bytes).ok()?);
        }
        let mut s = Source::new(bytes);
        let mut scene = match kind {
            Kind::Side | Kind::Split => trimmed(kind, &mut s)?,
            _ => in_space(kind, &mut s)?,
        };
        scene.queries.retain(|q| q.query().is_ok());
        (!scene.queries.is_empty()).then_some(scene)
    }

    /// The queries, a line each, an empty line, and the model as its files hold it.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for q in &self.queries {
            text += &q.to_text();
            text.push('\n');
        }
        text.push('\n');
        text + &Model::to_text(std::slice::from_ref(&self.brep), None)
    }

    /// What [`to_text`](Self::to_text) wrote, or something near it; none if the model is not one BREP, or no query is valid.
    pub fn from_text(text: &str) -> Option<Self> {
        let (queries, model) = text.split_once("\n\n")?;
        let mut breps = Model::from_text(Path::new("scene"), model).ok()?;
        let brep = breps.pop()?;
        if !breps.is_empty() || brep.faces().is_empty() {
            return None;
        }
        let queries: Vec<QueryLine> = queries
            .lines()
            .filter_map(|l| QueryLine::parse(l).ok())
            .filter(|q| q.query().is_ok())
            .collect();
        (!queries.is_empty()).then_some(Self { brep, queries })
    }
}

/// Loops in the plane.
fn trimmed(kind: Kind, s: &mut Source<'_>) -> Option<Scene> {
    let area = domain(s);
    let drawn = Loops::draw(s);
    let brep = sheet(level(area), Some(&drawn.loops))?;
    let queries = if kind == Kind::Split {
        let counts = drawn.loops.iter().map(Vec::len).enumerate();
        let all = counts.flat_map(|(l, n)| (0..n).map(move |t| (l, t)));
        all.take(8)
            .map(|(trim_loop, trim)| QueryLine {
                split: Some(TrimLine {
                    face: 0,
                    trim_loop,
                    trim,
                }),
                ..QueryLine::default()
            })
            .collect()
    } else {
        (0..8)
            .map(|_| QueryLine {
                side: Some(FacePoint {
                    face: 0,
                    uv: aimed(s, &drawn.loops, &drawn.marks, area),
                }),
                ..QueryLine::default()
            })
            .collect()
    };
    Some(Scene { brep, queries })
}

fn in_space(kind: Kind, s: &mut Source<'_>) -> Option<Scene> {
    let (brep, drawn) = body(s)?;
    let count = if kind == Kind::Evaluate { 6 } else { 2 };
    let queries = (0..count)
        .filter_map(|_| match kind {
            Kind::Sphere => sphere(s, &brep, &drawn),
            Kind::HalfSpace => half_space(s, &brep, &drawn),
            Kind::Line => line(s, &brep, &drawn),
            _ => {
                let (face, uv) = place(s, &brep, &drawn);
                Some(QueryLine {
                    evaluate: Some(FacePoint { face, uv }),
                    ..QueryLine::default()
                })
            }
        })
        .collect();
    Some(Scene { brep, queries })
}

/// A face and a point of its domain, mostly.
fn place(s: &mut Source<'_>, brep: &Brep, drawn: &Loops) -> (usize, [f64; 2]) {
    let face = s.below(brep.faces().len());
    let surface = brep.surface(face);
    let area = surface.domain();
    let none: [Vec<Use>; 0] = [];
    let loops = if drawn.loops.is_empty() {
        &none[..]
    } else {
        &drawn.loops
    };
    let uv = match s.byte() {
        // Where pieces meet, or next to it.
        0..=47 => {
            let breaks = |s: &mut Source<'_>, i: usize| {
                let all = knots(brep, face, i);
                let at = all[s.below(all.len().min(256))];
                s.nudged(at)
            };
            [breaks(s, 0), breaks(s, 1)]
        }
        48..=127 => [0, 1].map(|i| area[i].lerp(s.fraction())),
        _ => aimed(s, loops, &drawn.marks, area),
    };
    let inside = [0, 1].map(|i| uv[i].clamp(area[i].start, area[i].end));
    (face, inside)
}

/// The knots of a surface along u or v, or the ends of its domain.
fn knots(brep: &Brep, face: usize, i: usize) -> Vec<f64> {
    let surface = brep.surface(face);
    let d = surface.domain()[i];
    match surface {
        feeler::nurbs::Surface::Nurbs(s) => {
            let all = [s.knots_u(), s.knots_v()][i];
            all.spans().map(|(_, a, _)| a).chain([d.end]).collect()
        }
        _ => vec![d.start, d.end],
    }
}

/// A point of a face, about, a unit normal there, and a radius of curvature, where there are such.
struct Spot {
    point: Point3<f64>,
    du: Vector3<f64>,
    normal: Vector3<f64>,
    radius: Option<f64>,
}

fn spot(s: &mut Source<'_>, brep: &Brep, drawn: &Loops) -> Spot {
    let (face, uv) = place(s, brep, drawn);
    let all = brep.surface(face).derivatives(uv[0], uv[1], 2);
    let (du, dv) = (all.get(1, 0), all.get(0, 1));
    let normal = du.cross(&dv).try_normalize(0.0).unwrap_or(Vector3::z());
    let along = if s.rarely(128) {
        (all.get(2, 0), du)
    } else {
        (all.get(0, 2), dv)
    };
    let radius = along.1.norm_squared() / along.0.dot(&normal);
    Spot {
        point: all.get(0, 0).into(),
        du,
        normal,
        radius: radius.is_finite().then_some(radius),
    }
}

fn options(s: &mut Source<'_>, line: QueryLine) -> QueryLine {
    let accuracy = match s.byte() {
        0..=191 => None,
        b => Some(AccuracyLine::Length((-f64::from(b % 50)).exp2())),
    };
    let contacts = match s.byte() {
        0..=223 => None,
        224..=251 => Some(ContactsLine::None),
        _ => Some(ContactsLine::All),
    };
    QueryLine {
        accuracy,
        contacts,
        prediction: Some(64.0).filter(|_| s.rarely(64)),
        ..line
    }
}

fn sphere(s: &mut Source<'_>, brep: &Brep, drawn: &Loops) -> Option<QueryLine> {
    let at = spot(s, brep, drawn);
    let off = match s.below(8) {
        0 => 0.0,
        1..=2 => s.coordinate() / 8.0,
        3 => s.coordinate() * 1e-12,
        // A centre of curvature, or next to it.
        4..=5 => s.nudged(at.radius.unwrap_or(1.0)),
        6 => at.radius.unwrap_or(1.0) * (1.0 + s.coordinate() * 1e-6),
        _ => s.coordinate(),
    };
    let mut center: [f64; 3] = match s.byte() {
        0..=207 => (at.point + at.normal * off).coords.into(),
        _ => s.triple(),
    };
    if s.rarely(96) {
        center = center.map(|x| s.nudged(x));
    }
    let radius = match s.below(4) {
        0 => 0.0,
        1 => off.abs(),
        2 => s.nudged(off.abs()),
        _ => s.coordinate().abs(),
    };
    let line = QueryLine {
        sphere: Some(SphereLine {
            center,
            radius: radius.max(0.0),
        }),
        ..QueryLine::default()
    };
    let line = options(s, line);
    Some(moving(s, line, &at))
}

/// A unit vector: that of a face, one along an axis, exact ones, or any.
fn direction(s: &mut Source<'_>, normal: Vector3<f64>) -> Option<Vector3<f64>> {
    const EXACT: [[f64; 3]; 6] = [
        [1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.6, 0.8, 0.0],
        [0.0, 0.28, -0.96],
        [-0.352, 0.36, 0.864],
    ];
    let found = match s.below(4) {
        0 => normal,
        1 => -normal,
        2 => Vector3::from(s.one_of(&EXACT)),
        _ => Vector3::from(s.triple()),
    };
    found.try_normalize(0.0)
}

fn half_space(s: &mut Source<'_>, brep: &Brep, drawn: &Loops) -> Option<QueryLine> {
    let at = spot(s, brep, drawn);
    let normal = direction(s, at.normal)?;
    let on = normal.dot(&at.point.coords);
    let offset = match s.below(4) {
        0 => 0.0,
        1 => on,
        2 => s.nudged(on),
        _ => s.coordinate(),
    };
    let line = QueryLine {
        half_space: Some(HalfSpaceLine {
            normal: normal.into(),
            offset,
        }),
        ..QueryLine::default()
    };
    let line = options(s, line);
    Some(moving(s, line, &at))
}

/// Gives some probes a velocity: towards a face, along it or nearly so, along an axis, or any; and some an end.
fn moving(s: &mut Source<'_>, line: QueryLine, at: &Spot) -> QueryLine {
    if !s.rarely(48) {
        return line;
    }
    let velocity = match s.below(6) {
        0 => -at.normal,
        1 => at.normal * s.coordinate(),
        2 => at.du,
        3 => at.du - at.normal * (s.coordinate() * s.one_of(&[1.0, 1e-2, 1e-6, 1e-12])),
        4 => Vector3::from(s.one_of(&[[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]])),
        _ => Vector3::from(s.triple()),
    };
    let until = s.rarely(64).then(|| s.coordinate().abs());
    // Back to where it comes from, so that most arrive after a while.
    let back = s.one_of(&[0.0, 1.0, 4.0]);
    let sphere = line.sphere.map(|ball| SphereLine {
        center: [0, 1, 2].map(|i| ball.center[i] - back * velocity[i]),
        ..ball
    });
    QueryLine {
        velocity: Some(velocity.into()),
        until,
        sphere,
        // What is far ahead is no prediction of a touch.
        prediction: line.prediction.map(|_| 0.25),
        ..line
    }
}

fn line(s: &mut Source<'_>, brep: &Brep, drawn: &Loops) -> Option<QueryLine> {
    let (at, other) = (spot(s, brep, drawn), spot(s, brep, drawn));
    if s.rarely(64) {
        let off = s.coordinate() * s.one_of(&[1.0, 1e-3, 1e-9, 1e-14]);
        let p = at.point + at.normal * off;
        return Some(QueryLine {
            inside: Some(SpacePoint {
                point: p.coords.into(),
            }),
            ..QueryLine::default()
        });
    }
    let direction = match s.below(8) {
        0..=1 => at.normal,
        2..=3 => other.point - at.point,
        // Nearly tangent.
        4 => at.du + at.normal * (s.coordinate() * s.one_of(&[0.0, 1e-2, 1e-6, 1e-12])),
        5 => Vector3::from(s.one_of(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])),
        _ => Vector3::from(s.triple()),
    };
    // Most lines start well outside.
    let back = s.one_of(&[0.0, 1.0, HALF, 64.0]);
    let reach = direction.norm();
    let origin = if reach > 0.0 {
        at.point - direction * (back / reach)
    } else {
        at.point
    };
    Some(QueryLine {
        line: Some(LineLine {
            origin: origin.coords.into(),
            direction: direction.into(),
            kind: s.one_of(&[
                LineKindLine::Line,
                LineKindLine::Line,
                LineKindLine::Ray,
                LineKindLine::Segment,
            ]),
        }),
        hits: Some(Hits::Any).filter(|_| s.rarely(32)),
        ..QueryLine::default()
    })
}
