//! A query and its answer as things to draw.

use crate::Part;
use feeler::query::{Feature, LineKind, Probe};
use feeler::trim::Side;
use feeler_corpus::{Answer, Ask, Body, Claim, Model, Query, QueryLine, TrimLine, side_word};
use feeler_gate::{Engine, FeelerEngine};
use nalgebra::Vector3;
use serde::Serialize;

/// What stands for a probe. Points are relative to the part's centre, in model units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ProbeShape {
    /// A ball.
    Ball {
        /// Its centre.
        center: [f32; 3],
        /// Its radius.
        radius: f32,
    },
    /// A square of a half-space's border.
    Plane(Plane),
    /// What is shown of a line.
    Line(Stretch),
}

fn is_finite(v: &[f32; 3]) -> bool {
    v.iter().all(|x| x.is_finite())
}

impl ProbeShape {
    fn is_drawable(&self) -> bool {
        match self {
            Self::Ball { center, radius } => is_finite(center) && radius.is_finite(),
            Self::Plane(p) => is_finite(&p.center) && is_finite(&p.normal),
            Self::Line(l) => is_finite(&l.from) && is_finite(&l.to),
        }
    }
}

impl Mark {
    /// Without normals that are none (a face has none at an apex) and points that are too far away; nothing where the mark itself is.
    fn drawable(mut self) -> Option<Self> {
        let is_unit = |n: &[f32; 3]| n.iter().map(|x| x * x).sum::<f32>() > 0.25;
        self.normal = self.normal.filter(|n| is_finite(n) && is_unit(n));
        self.to = self.to.filter(is_finite);
        self.until = self.until.filter(is_finite);
        is_finite(&self.at).then_some(self)
    }
}

/// A square of the border of a half-space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Plane {
    /// Its middle: next to the part's centre.
    pub center: [f32; 3],
    /// Unit normal, out of the half-space.
    pub normal: [f32; 3],
    /// Half of a side.
    pub half: f32,
}

/// What is shown of a line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stretch {
    /// One end.
    pub from: [f32; 3],
    /// The other.
    pub to: [f32; 3],
    /// Where it starts, if it does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<[f32; 3]>,
}

/// What a point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MarkKind {
    /// On the BREP.
    Brep,
    /// Asked about, and inside.
    Inside,
    /// Asked about, and outside.
    Outside,
}

/// A point of an answer. Points are relative to the part's centre.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mark {
    /// Where.
    pub at: [f32; 3],
    /// What.
    pub kind: MarkKind,
    /// The contact's normal, from the BREP to the probe, or the face's where a line hits it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<[f32; 3]>,
    /// The point on the probe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<[f32; 3]>,
    /// Where a line leaves the face again that it lies in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub until: Option<[f32; 3]>,
    /// Unit directions of derivatives.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub arrows: Vec<[f32; 3]>,
}

/// A query, its answer, and what to draw of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shown {
    /// Which of the view's parts it is about.
    pub part: usize,
    /// What to call it.
    pub label: String,
    /// The answer in a few words.
    pub summary: String,
    /// `answered`, `undecided`, `refused`; where there is truth `right`, `wrong`, `indeterminate`.
    pub state: &'static str,
    /// What it earned against the truth, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub judged: Option<String>,
    /// The query as the protocol writes it.
    pub query: String,
    /// The answer as the protocol writes it.
    pub answer: String,
    /// The probe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probe: Option<ProbeShape>,
    /// The answer's points.
    pub marks: Vec<Mark>,
}

impl Shown {
    /// Asks a query of an engine that has opened the model, and takes down its answer.
    pub(crate) fn ask(
        model: &Model,
        part: &Part,
        engine: &mut FeelerEngine,
        number: usize,
        line: &Result<QueryLine, String>,
    ) -> Self {
        let query = line
            .as_ref()
            .map_err(Clone::clone)
            .and_then(|l| l.query().map_err(|e| e.to_string()));
        match query {
            Ok(query) => {
                let answer = engine.answer(&query);
                Self::new(model, part, number, &query, &answer)
            }
            Err(error) => Self {
                part: 0,
                label: format!("{number}"),
                summary: error.clone(),
                state: "refused",
                judged: None,
                query: line.as_ref().map(QueryLine::to_text).unwrap_or_default(),
                answer: error,
                probe: None,
                marks: Vec::new(),
            },
        }
    }

    /// What there is to draw of an answer.
    pub(crate) fn new(
        model: &Model,
        part: &Part,
        number: usize,
        query: &Query,
        answer: &Answer,
    ) -> Self {
        let name = match &query.id {
            Some(serde_json::Value::String(id)) => id.clone(),
            Some(id) => id.to_string(),
            None => format!("{number} {}", query.ask.word().replace('_', "-")),
        };
        let state = match &answer.body {
            Body::Error { .. } => "refused",
            body if body.undecided().is_some() => "undecided",
            _ => "answered",
        };
        Self {
            part: 0,
            label: name,
            summary: summary(&answer.body),
            state,
            judged: None,
            query: QueryLine::from(query).to_text(),
            answer: answer.to_text(),
            // What is too far away for f32 is not drawn.
            probe: probe(part, &asked(query, &answer.body)).filter(ProbeShape::is_drawable),
            marks: marks(model, part, query, &answer.body)
                .into_iter()
                .filter_map(Mark::drawable)
                .collect(),
        }
    }
}

fn number(claim: &Claim) -> String {
    match (claim.lo, claim.hi) {
        (Some(lo), Some(hi)) if lo.is_finite() && hi.is_finite() => {
            format!("{} ± {:.0e}", claim.value, (hi - lo) / 2.0)
        }
        _ => format!("{}, not bounded", claim.value),
    }
}

fn feature(f: Option<Feature>) -> String {
    match f {
        Some(Feature::Face(i)) => format!("face {i}"),
        Some(Feature::Edge(i)) => format!("edge {i}"),
        Some(Feature::Vertex(i)) => format!("vertex {i}"),
        None => "no feature".to_owned(),
    }
}

fn summary(body: &Body) -> String {
    let said = match body {
        Body::Error { error } => return error.clone(),
        Body::Contact {
            separation,
            continuum,
            contacts,
            ..
        } => {
            let at = match contacts.len() {
                0 => "no contact".to_owned(),
                1 => feature(contacts[0].feature),
                n => format!("{n} contacts"),
            };
            let spread = if *continuum == Some(true) {
                ", continuum"
            } else {
                ""
            };
            format!("separation {}, {at}{spread}", number(separation))
        }
        Body::Arrival {
            arrival, contacts, ..
        } => match (arrival, contacts.first()) {
            (None, _) => "never arrives".to_owned(),
            (Some(t), Some(c)) => format!("arrives at {}, {}", number(t), feature(c.feature)),
            (Some(t), None) => format!("arrives at {}", number(t)),
        },
        Body::Overlap { overlap, .. } => match overlap {
            Some(true) => "overlap".to_owned(),
            Some(false) => "no overlap".to_owned(),
            None => String::new(),
        },
        Body::Line { hits, .. } => {
            let t = hits.iter().map(|h| format!("{:.6}", h.t.value));
            let t: Vec<String> = t.collect();
            match t.len() {
                0 => "no hit".to_owned(),
                _ => format!("hits at t = {}", t.join(", ")),
            }
        }
        Body::Side { side, .. } => side.map(side_word).unwrap_or_default().to_owned(),
        Body::Evaluate { point, .. } => format!("point {point:?}"),
        Body::Split { u, v, .. } => {
            let n = u.roots.len() + v.roots.len();
            format!("{n} derivative roots")
        }
    };
    match body.undecided() {
        Some(why) => format!("{said} ({why})"),
        None => said,
    }
}

fn f32s(v: &Vector3<f64>) -> [f32; 3] {
    [0, 1, 2].map(|c| v[c] as f32)
}

/// What was asked; of a probe that moves, where it stands when it arrives.
fn asked(query: &Query, body: &Body) -> Ask {
    let Ask::Arrival(mut probe, motion) = query.ask else {
        return query.ask;
    };
    if let Body::Arrival {
        arrival: Some(time),
        ..
    } = body
    {
        let way = motion.velocity * time.value;
        match &mut probe {
            Probe::Sphere(s) => s.center += way,
            Probe::HalfSpace(h) => h.offset += h.normal.dot(&way),
        }
    }
    Ask::Contact(probe)
}

fn probe(part: &Part, ask: &Ask) -> Option<ProbeShape> {
    /// Squares and lines reach beyond the part by this factor.
    const BEYOND: f64 = 1.15;
    let center = Vector3::from(part.center);
    match *ask {
        Ask::Contact(Probe::Sphere(s)) => Some(ProbeShape::Ball {
            center: part.local(&s.center.coords.into()),
            radius: s.radius as f32,
        }),
        Ask::Contact(Probe::HalfSpace(h)) => {
            let off = h.normal.dot(&center) - h.offset;
            Some(ProbeShape::Plane(Plane {
                center: f32s(&(h.normal * -off)),
                normal: f32s(&h.normal),
                half: (BEYOND * part.radius) as f32,
            }))
        }
        Ask::Line(l) => {
            let at = |t: f64| part.local(&(l.origin + l.direction * t).coords.into());
            // Scaled first, so that squares of tiny ones survive.
            let scale = l.direction.amax();
            let direction = l.direction / scale;
            let near =
                (center - l.origin.coords).dot(&direction) / direction.norm_squared() / scale;
            let reach = BEYOND * part.radius / direction.norm() / scale;
            let (from, to) = match l.kind {
                LineKind::Line => (near - reach, near + reach),
                // The whole way to the part, and through it.
                LineKind::Ray => (0.0, (near + reach).max(reach)),
                LineKind::Segment => (0.0, 1.0),
            };
            Some(ProbeShape::Line(Stretch {
                from: at(from),
                to: at(to),
                start: (l.kind != LineKind::Line).then(|| at(0.0)),
            }))
        }
        _ => None,
    }
}

fn mark(at: [f32; 3], kind: MarkKind) -> Mark {
    Mark {
        at,
        kind,
        normal: None,
        to: None,
        until: None,
        arrows: Vec::new(),
    }
}

/// Boundary counts as on the BREP.
fn of_side(side: Option<Side>) -> MarkKind {
    match side {
        Some(Side::Inside) => MarkKind::Inside,
        Some(Side::Outside) => MarkKind::Outside,
        Some(Side::Boundary) | None => MarkKind::Brep,
    }
}

fn marks(model: &Model, part: &Part, query: &Query, body: &Body) -> Vec<Mark> {
    let narrow = |v: [f64; 3]| v.map(|x| x as f32);
    match (body, query.ask) {
        (Body::Contact { contacts, .. } | Body::Arrival { contacts, .. }, _) => {
            let one = |c: &feeler_corpus::ContactLine| Mark {
                normal: Some(narrow(c.normal)),
                to: Some(part.local(&c.on_probe)),
                ..mark(part.local(&c.on_brep), MarkKind::Brep)
            };
            contacts.iter().map(one).collect()
        }
        (Body::Line { hits, .. }, Ask::Line(line)) => {
            let one = |h: &feeler_corpus::HitLine| {
                let end = h.t_end.map(|t| line.origin + line.direction * t.value);
                Mark {
                    normal: Some(narrow(h.normal)),
                    until: end.map(|p| part.local(&p.coords.into())),
                    ..mark(part.local(&h.point), MarkKind::Brep)
                }
            };
            hits.iter().map(one).collect()
        }
        (Body::Side { side, .. }, Ask::Inside(p)) => {
            vec![mark(part.local(&p.coords.into()), of_side(*side))]
        }
        (Body::Side { side, .. }, Ask::Side(face, uv)) => {
            match on_face(model, face, [uv.x, uv.y]) {
                Some(p) => vec![mark(part.local(&p), of_side(*side))],
                None => Vec::new(),
            }
        }
        (Body::Evaluate { point, du, dv, .. }, _) => {
            let unit = |d: &[f64; 3]| {
                let v = Vector3::from(*d);
                let n = v.norm();
                (n > 0.0 && n.is_finite()).then(|| f32s(&(v / n)))
            };
            vec![Mark {
                arrows: [du, dv].into_iter().filter_map(unit).collect(),
                ..mark(part.local(point), MarkKind::Brep)
            }]
        }
        (Body::Split { u, v, .. }, Ask::Split(at)) => {
            let roots = u.roots.iter().chain(&v.roots);
            let found = roots.filter_map(|r| on_trim(model, &at, r.t.value));
            found
                .map(|p| mark(part.local(&p), MarkKind::Brep))
                .collect()
        }
        _ => Vec::new(),
    }
}

/// A point of a face's surface; none outside its domain.
fn on_face(model: &Model, face: usize, uv: [f64; 2]) -> Option<[f64; 3]> {
    let (brep, face) = model.face(face)?;
    let surface = model.breps[brep].surface(face);
    let inside = |c: usize| surface.domain()[c].start <= uv[c] && uv[c] <= surface.domain()[c].end;
    (inside(0) && inside(1)).then(|| surface.point(uv[0], uv[1]).coords.into())
}

fn on_trim(model: &Model, at: &TrimLine, t: f64) -> Option<[f64; 3]> {
    let (brep, face) = model.face(at.face)?;
    let parts = model.breps[brep].parts();
    let loops = parts.faces[face].loops.as_ref()?;
    let trims = &parts.loops[*loops.get(at.trim_loop)?].trims;
    let trim = &parts.trims[*trims.get(at.trim)?];
    let uv = parts.curves2[trim.curve].point(t);
    on_face(model, at.face, [uv.x, uv.y])
}
