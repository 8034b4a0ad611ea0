//! A query, as a line of JSON and as the kernel takes it.

use feeler::query::{
    Accuracy, Contacts, HalfSpace, LineKind, LineProbe, Motion, Probe, ProbeError, Sphere,
};
use nalgebra::{Point2, Point3, Quaternion, Vector3};
use serde::de::{self, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;
use std::fmt;

/// A line as it is written: one of the seven questions, and options beside it.
///
/// Unknown and doubled fields are refused, and [`query`](Self::query) refuses an option beside a question that it means nothing to. An
/// accuracy may stand beside any: what is exact meets it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QueryLine {
    /// Copied to the answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id: Option<Value>,
    /// The model asked, in a corpus: a path from the corpus's `models` folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// The separation of a ball.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sphere: Option<SphereLine>,
    /// The separation of a half-space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub half_space: Option<HalfSpaceLine>,
    /// The hits of a line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line: Option<LineLine>,
    /// The side of a point of a face's parameter space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side: Option<FacePoint>,
    /// The side of a point of space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inside: Option<SpacePoint>,
    /// A point of a face's surface and first derivatives there; parameters outside of the surface's domain are moved to its border first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evaluate: Option<FacePoint>,
    /// Where the coordinates of a trim curve are stationary.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub split: Option<TrimLine>,
    /// Report contacts of a sphere or half-space with separation <= this, in model units.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prediction: Option<f64>,
    /// Which contacts of a sphere or half-space to report. With none, whether the nearest points are a continuum is not looked at, and the
    /// answer does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contacts: Option<ContactsLine>,
    /// Which hits of a line to report.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hits: Option<Hits>,
    /// Width of the separation's enclosure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracyLine>,
    /// Where the probe stands: a sphere, a half-space, a line or a point of space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose: Option<Pose>,
    /// Ask when the ball or half-space that moves so first comes within the prediction; in model units a unit of time, in the model's
    /// frame: the pose does not turn it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
    /// Until when it moves; for ever if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
    /// Ask only whether a sphere or half-space and the BREP overlap.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub overlap: bool,
}

/// A ball: centre and radius in model units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereLine {
    /// Centre.
    pub center: [f64; 3],
    /// Radius.
    pub radius: f64,
}

/// The half-space `normal . x <= offset`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HalfSpaceLine {
    /// Outward unit normal.
    pub normal: [f64; 3],
    /// Offset in model units.
    pub offset: f64,
}

/// `origin + t direction`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LineLine {
    /// The point at t = 0.
    pub origin: [f64; 3],
    /// Direction; t counts in its length.
    pub direction: [f64; 3],
    /// Which part of it counts.
    #[serde(default)]
    pub kind: LineKindLine,
}

/// Which part of a line counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LineKindLine {
    /// All t.
    #[default]
    Line,
    /// t >= 0.
    Ray,
    /// 0 <= t <= 1.
    Segment,
}

/// A point of a face's parameter space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FacePoint {
    /// The face, counted through the BREPs of the file.
    pub face: usize,
    /// Parameters.
    pub uv: [f64; 2],
}

/// A trim of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrimLine {
    /// The face, counted through the BREPs of the file.
    pub face: usize,
    /// The loop, counted in the face.
    #[serde(rename = "loop")]
    pub trim_loop: usize,
    /// The trim, counted in the loop.
    pub trim: usize,
}

/// A point of space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpacePoint {
    /// Coordinates in model units.
    pub point: [f64; 3],
}

/// Which contacts to report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ContactsLine {
    /// The deepest.
    Deepest,
    /// All within the prediction.
    All,
    /// None: the separation alone.
    None,
}

/// Which hits to report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Hits {
    /// All of them.
    #[default]
    All,
    /// The one of least t.
    First,
    /// At most one, whichever.
    Any,
}

/// A length, or `"full"`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum AccuracyLine {
    /// The word.
    Word(Full),
    /// A length in model units.
    Length(f64),
}

// By hand, for what is said of anything else: serde would name the type's variants.
impl<'de> Deserialize<'de> for AccuracyLine {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Either;
        impl Visitor<'_> for Either {
            type Value = AccuracyLine;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a positive length or \"full\"")
            }

            fn visit_f64<E: de::Error>(self, x: f64) -> Result<AccuracyLine, E> {
                Ok(AccuracyLine::Length(x))
            }

            fn visit_u64<E: de::Error>(self, x: u64) -> Result<AccuracyLine, E> {
                Ok(AccuracyLine::Length(x as f64))
            }

            fn visit_i64<E: de::Error>(self, x: i64) -> Result<AccuracyLine, E> {
                Ok(AccuracyLine::Length(x as f64))
            }

            fn visit_str<E: de::Error>(self, word: &str) -> Result<AccuracyLine, E> {
                match word {
                    "full" => Ok(AccuracyLine::Word(Full::Full)),
                    _ => Err(E::invalid_value(Unexpected::Str(word), &self)),
                }
            }
        }
        d.deserialize_any(Either)
    }
}

/// The word `"full"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Full {
    /// As narrow as two units in the last place, down to a floor: see [`Accuracy::Full`].
    Full,
}

/// Moves the probe: first turned, then moved.
///
/// The probe that results is **rounded** to f64: its coordinates once each under a translation, several
/// times under a rotation. The query is about the rounded probe, and that is what
/// the bound of the answer holds for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// Added to the turned probe, in model units.
    #[serde(default)]
    pub translation: [f64; 3],
    /// Unit quaternion `[x, y, z, w]`: `|q|^2` within 2^-50 of 1.
    #[serde(default = "identity")]
    pub rotation: [f64; 4],
}

const IDENTITY: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

fn identity() -> [f64; 4] {
    IDENTITY
}

/// Why a line is refused.
#[derive(Debug, thiserror::Error)]
pub enum QueryError {
    /// Not JSON, or not of the format.
    #[error("{}", json_message(.0))]
    Json(#[from] serde_json::Error),
    /// A list instead of an object.
    #[error("a query is an object, {{\"sphere\": ...}}, not a list")]
    NoObject,
    /// Not exactly one question.
    #[error(
        "a query asks one of sphere, half_space, line, side, inside, evaluate, split; this asks {0} of them: write one object for each"
    )]
    Questions(usize),
    /// A probe that the kernel refuses.
    #[error("{0}")]
    Probe(#[from] ProbeError),
    /// An option beside a question that it means nothing to.
    #[error("`{option}` means nothing to {asked}, only to {to}: leave it out")]
    Beside {
        /// The option's name.
        option: &'static str,
        /// What is asked.
        asked: &'static str,
        /// What it means something to.
        to: &'static str,
    },
    /// A number that has no meaning here.
    #[error("{0}")]
    Number(&'static str),
}

/// What serde says, without its line number: a query is one line, and who reads it knows which.
fn json_message(error: &serde_json::Error) -> String {
    use serde_json::error::Category;
    let text = error.to_string();
    let (what, _) = text.rsplit_once(" at line ").unwrap_or((&text, ""));
    let column = error.column();
    match error.classify() {
        Category::Data => format!("not a query: {what} (column {column})"),
        _ => format!(
            "not valid JSON: {what} (column {column}); write one object a line, and finite numbers only"
        ),
    }
}

/// What a query asks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ask {
    /// Separation and contacts of a sphere or half-space.
    Contact(Probe),
    /// When a sphere or half-space that moves first comes within the prediction.
    Arrival(Probe, Motion),
    /// The hits of a line.
    Line(LineProbe),
    /// The side of a point of a face's parameter space.
    Side(usize, Point2<f64>),
    /// The side of a point of space.
    Inside(Point3<f64>),
    /// A point of a face and first derivatives.
    Evaluate(usize, Point2<f64>),
    /// The derivative roots of a trim curve.
    Split(TrimLine),
}

/// A query whose numbers have been checked and whose probe stands in its pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Query {
    /// Copied to the answer.
    pub id: Option<Value>,
    /// What is asked.
    pub ask: Ask,
    /// Report contacts with separation <= this; `None` where the line leaves it to the engine's
    /// default.
    pub prediction: Option<f64>,
    /// Which contacts to report; `None` likewise.
    pub contacts: Option<Contacts>,
    /// Which hits to report.
    pub hits: Hits,
    /// Width of the enclosure; `None` likewise.
    pub accuracy: Option<Accuracy>,
    /// Ask only whether probe and BREP overlap.
    pub overlap: bool,
}

impl QueryLine {
    /// Reads one line.
    pub fn parse(line: &str) -> Result<Self, QueryError> {
        // serde would take a list for a structure's fields in order.
        if line.trim_start().starts_with('[') {
            return Err(QueryError::NoObject);
        }
        Ok(serde_json::from_str(line)?)
    }

    /// The id of a line that is an object, be the rest of it a query or not: who asked without waiting knows by it which line was
    /// refused. None where the line is no object, or gives none or two.
    pub fn id_of(line: &str) -> Option<Value> {
        #[derive(Deserialize)]
        struct IdAlone {
            id: Option<Value>,
        }
        // serde would take a list for a structure's fields in order.
        if !line.trim_start().starts_with('{') {
            return None;
        }
        serde_json::from_str::<IdAlone>(line).ok()?.id
    }

    /// The line as text, numbers in shortest round-trip form.
    pub fn to_text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Checks the numbers and puts the probe in its pose.
    pub fn query(&self) -> Result<Query, QueryError> {
        let pose = self.pose.as_ref().map(Pose::checked).transpose()?;
        let questions = [
            self.sphere.map(|s| ask_sphere(&s, pose)),
            self.half_space.map(|h| ask_half_space(&h, pose)),
            self.line.map(|l| ask_line(&l, pose)),
            self.side.map(|s| Ok(Ask::Side(s.face, uv(s.uv)?))),
            self.inside.map(|s| ask_inside(s.point, pose)),
            self.evaluate.map(|s| Ok(Ask::Evaluate(s.face, uv(s.uv)?))),
            self.split.map(|s| Ok(Ask::Split(s))),
        ];
        let mut asked: Vec<_> = questions.into_iter().flatten().collect();
        let count = asked.len();
        let ask = match (asked.pop(), count) {
            (Some(ask), 1) => self.moving(ask?)?,
            _ => return Err(QueryError::Questions(count)),
        };
        self.suits(&ask)?;
        if self.prediction.is_some_and(|p| !p.is_finite()) {
            return Err(QueryError::Number(
                "the prediction is not finite: give a length",
            ));
        }
        let accuracy = self.accuracy.map(AccuracyLine::accuracy).transpose()?;
        Ok(Query {
            id: self.id.clone(),
            ask,
            prediction: self.prediction,
            contacts: self.contacts.map(Contacts::from),
            hits: self.hits.unwrap_or_default(),
            accuracy,
            overlap: self.overlap,
        })
    }
}

impl QueryLine {
    /// Refuses options that the question takes no notice of: who gives one expects something of it.
    fn suits(&self, ask: &Ask) -> Result<(), QueryError> {
        const PROBES: &str = "sphere and half_space";
        let probe = matches!(ask, Ask::Contact(_) | Ask::Arrival(..));
        let line = matches!(ask, Ask::Line(_));
        let in_space = probe || line || matches!(ask, Ask::Inside(_));
        for (given, suits, option, to) in [
            (self.prediction.is_some(), probe, "prediction", PROBES),
            (self.contacts.is_some(), probe, "contacts", PROBES),
            (self.overlap, probe, "overlap", PROBES),
            (self.hits.is_some(), line, "hits", "line"),
            (
                self.pose.is_some(),
                in_space,
                "pose",
                "sphere, half_space, line and inside",
            ),
        ] {
            if given && !suits {
                let asked = ask.word();
                return Err(QueryError::Beside { option, asked, to });
            }
        }
        Ok(())
    }

    /// The same question of a probe that moves, if this one does.
    fn moving(&self, ask: Ask) -> Result<Ask, QueryError> {
        let Some(velocity) = self.velocity else {
            return match self.until {
                Some(_) => Err(QueryError::Number(
                    "until without a velocity: give one, or leave until out",
                )),
                None => Ok(ask),
            };
        };
        let until = self.until.unwrap_or(f64::INFINITY);
        let motion = Motion::new(velocity.into(), until)?;
        match ask {
            Ask::Contact(_) if self.overlap => Err(QueryError::Number(
                "overlap and a velocity: ask for one of them",
            )),
            Ask::Contact(probe) => Ok(Ask::Arrival(probe, motion)),
            _ => Err(QueryError::Number(
                "a velocity of what does not move: give it to a sphere or half-space",
            )),
        }
    }
}

impl AccuracyLine {
    /// Refuses what is no length.
    pub fn accuracy(self) -> Result<Accuracy, QueryError> {
        match self {
            Self::Word(Full::Full) => Ok(Accuracy::Full),
            Self::Length(a) if a.is_finite() && a > 0.0 => Ok(Accuracy::Length(a)),
            Self::Length(_) => Err(QueryError::Number(
                "the accuracy must be a positive length or \"full\"",
            )),
        }
    }
}

impl From<&Query> for QueryLine {
    /// The line that asks this: the probe as it stands, without a pose.
    fn from(q: &Query) -> Self {
        let mut line = Self {
            id: q.id.clone(),
            prediction: q.prediction,
            contacts: q.contacts.map(ContactsLine::from),
            hits: (q.hits != Hits::All).then_some(q.hits),
            accuracy: q.accuracy.map(AccuracyLine::from),
            overlap: q.overlap,
            ..Self::default()
        };
        let on_face = |face, uv: Point2<f64>| FacePoint {
            face,
            uv: uv.coords.into(),
        };
        if let Ask::Arrival(_, motion) = q.ask {
            line.velocity = Some(motion.velocity.into());
            line.until = motion.until.is_finite().then_some(motion.until);
        }
        match q.ask {
            Ask::Contact(Probe::Sphere(s)) | Ask::Arrival(Probe::Sphere(s), _) => {
                line.sphere = Some(SphereLine {
                    center: s.center.coords.into(),
                    radius: s.radius,
                });
            }
            Ask::Contact(Probe::HalfSpace(h)) | Ask::Arrival(Probe::HalfSpace(h), _) => {
                line.half_space = Some(HalfSpaceLine {
                    normal: h.normal.into(),
                    offset: h.offset,
                });
            }
            Ask::Line(l) => {
                line.line = Some(LineLine {
                    origin: l.origin.coords.into(),
                    direction: l.direction.into(),
                    kind: l.kind.into(),
                });
            }
            Ask::Side(face, uv) => line.side = Some(on_face(face, uv)),
            Ask::Inside(p) => {
                line.inside = Some(SpacePoint {
                    point: p.coords.into(),
                });
            }
            Ask::Evaluate(face, uv) => line.evaluate = Some(on_face(face, uv)),
            Ask::Split(at) => line.split = Some(at),
        }
        line
    }
}

impl Ask {
    /// The protocol's word for what is asked.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Contact(Probe::Sphere(_)) | Self::Arrival(Probe::Sphere(_), _) => "sphere",
            Self::Contact(Probe::HalfSpace(_)) | Self::Arrival(Probe::HalfSpace(_), _) => {
                "half_space"
            }
            Self::Line(_) => "line",
            Self::Side(..) => "side",
            Self::Inside(_) => "inside",
            Self::Evaluate(..) => "evaluate",
            Self::Split(_) => "split",
        }
    }
}

impl From<Accuracy> for AccuracyLine {
    fn from(a: Accuracy) -> Self {
        match a {
            Accuracy::Full => Self::Word(Full::Full),
            Accuracy::Length(a) => Self::Length(a),
        }
    }
}

impl From<Contacts> for ContactsLine {
    fn from(c: Contacts) -> Self {
        match c {
            Contacts::Deepest => Self::Deepest,
            Contacts::All => Self::All,
            Contacts::None => Self::None,
        }
    }
}

impl From<LineKind> for LineKindLine {
    fn from(k: LineKind) -> Self {
        match k {
            LineKind::Line => Self::Line,
            LineKind::Ray => Self::Ray,
            LineKind::Segment => Self::Segment,
        }
    }
}

impl From<ContactsLine> for Contacts {
    fn from(c: ContactsLine) -> Self {
        match c {
            ContactsLine::Deepest => Self::Deepest,
            ContactsLine::All => Self::All,
            ContactsLine::None => Self::None,
        }
    }
}

impl From<LineKindLine> for LineKind {
    fn from(k: LineKindLine) -> Self {
        match k {
            LineKindLine::Line => Self::Line,
            LineKindLine::Ray => Self::Ray,
            LineKindLine::Segment => Self::Segment,
        }
    }
}

fn uv(at: [f64; 2]) -> Result<Point2<f64>, QueryError> {
    if at.iter().all(|x| x.is_finite()) {
        Ok(Point2::from(at))
    } else {
        Err(QueryError::Number("uv is not finite: give two numbers"))
    }
}

/// A pose that has been checked; no rotation if it is the identity.
#[derive(Clone, Copy)]
struct Placement {
    translation: Vector3<f64>,
    rotation: Option<Quaternion<f64>>,
}

impl Pose {
    fn checked(&self) -> Result<Placement, QueryError> {
        // The same allowance as for a half-space's normal: what was normalised in f64 passes.
        const LIMIT: f64 = 1.0 / (1u64 << 50) as f64;
        let [x, y, z, w] = self.rotation;
        let rotation = Quaternion::new(w, x, y, z);
        let off = (rotation.norm_squared() - 1.0).abs();
        if off.is_nan() || off > LIMIT {
            return Err(QueryError::Number(
                "the pose's rotation is not a unit quaternion: divide it by its length (|q|^2 must be within 2^-50 of 1)",
            ));
        }
        if self.translation.iter().any(|t| !t.is_finite()) {
            return Err(QueryError::Number(
                "the pose's translation is not finite: give three numbers",
            ));
        }
        Ok(Placement {
            translation: Vector3::from(self.translation),
            rotation: (self.rotation != IDENTITY).then_some(rotation),
        })
    }
}

impl Placement {
    fn turn(&self, v: Vector3<f64>) -> Vector3<f64> {
        match self.rotation {
            // v + 2 w (a x v) + 2 a x (a x v), a the vector part.
            Some(q) => {
                let a = q.imag();
                let t = 2.0 * a.cross(&v);
                v + q.scalar() * t + a.cross(&t)
            }
            None => v,
        }
    }

    fn place(&self, p: [f64; 3]) -> Point3<f64> {
        Point3::from(self.turn(Vector3::from(p)) + self.translation)
    }
}

fn place(pose: Option<Placement>, p: [f64; 3]) -> Point3<f64> {
    pose.map_or(Point3::from(p), |pose| pose.place(p))
}

fn ask_sphere(s: &SphereLine, pose: Option<Placement>) -> Result<Ask, QueryError> {
    let sphere = Sphere::new(place(pose, s.center), s.radius)?;
    Ok(Ask::Contact(Probe::Sphere(sphere)))
}

fn ask_half_space(h: &HalfSpaceLine, pose: Option<Placement>) -> Result<Ask, QueryError> {
    let stored = HalfSpace::new(Vector3::from(h.normal), h.offset)?;
    let posed = match pose {
        Some(pose) => {
            let normal = match pose.rotation {
                // Turning rounds; made a unit vector again, to stay within what is accepted.
                Some(_) => pose.turn(stored.normal).normalize(),
                None => stored.normal,
            };
            HalfSpace::new(normal, stored.offset + normal.dot(&pose.translation))?
        }
        None => stored,
    };
    Ok(Ask::Contact(Probe::HalfSpace(posed)))
}

fn ask_line(l: &LineLine, pose: Option<Placement>) -> Result<Ask, QueryError> {
    let direction = Vector3::from(l.direction);
    let direction = pose.map_or(direction, |pose| pose.turn(direction));
    let line = LineProbe::new(place(pose, l.origin), direction, l.kind.into())?;
    Ok(Ask::Line(line))
}

fn ask_inside(p: [f64; 3], pose: Option<Placement>) -> Result<Ask, QueryError> {
    // A ball of radius 0 has the same requirements.
    let sphere = Sphere::new(place(pose, p), 0.0)?;
    Ok(Ask::Inside(sphere.center))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(line: &str) -> String {
        match QueryLine::parse(line).and_then(|l| l.query()) {
            Ok(q) => panic!("{line} was accepted: {q:?}"),
            Err(e) => e.to_string(),
        }
    }

    #[test]
    fn bad_lines_are_refused_with_a_reason() {
        for (line, part) in [
            ("", "EOF"),
            ("{", "EOF"),
            ("[]", "not a list"),
            ("{}", "asks 0"),
            (
                r#"{"sphere": {"center": [0,0,0], "radius": NaN}}"#,
                "expected",
            ),
            (
                r#"{"sphere": {"center": [0,0,0], "radius": 1e999}}"#,
                "out of range",
            ),
            (
                r#"{"sphere": {"center": [0,0,0], "radius": -1}}"#,
                "negative",
            ),
            (r#"{"sphere": {"center": [0,0], "radius": 1}}"#, "length"),
            (
                r#"{"sphere": {"center": [0,0,0], "radius": 1, "r": 1}}"#,
                "unknown field",
            ),
            (r#"{"sphere": {"center": [0,0,0]}}"#, "radius"),
            (
                r#"{"ball": {"center": [0,0,0], "radius": 1}}"#,
                "unknown field",
            ),
            (
                r#"{"sphere": {"center": [0,0,0], "radius": 1}, "inside": {"point": [0,0,0]}}"#,
                "asks 2",
            ),
            (
                r#"{"sphere": {"center": [0,0,0], "radius": 1}, "sphere": {"center": [0,0,0], "radius": 1}}"#,
                "duplicate",
            ),
            (
                r#"{"line": {"origin": [0,0,0], "direction": [0,0,0]}}"#,
                "zero",
            ),
            (
                r#"{"half_space": {"normal": [0,0,2], "offset": 1}}"#,
                "unit",
            ),
            (r#"{"inside": {"point": [0,0,1e200]}}"#, "range"),
            (
                r#"{"inside": {"point": [0,0,0]}, "velocity": [1,0,0]}"#,
                "sphere or half-space",
            ),
            (
                r#"{"sphere": {"center": [0,0,0], "radius": 1}, "until": 1}"#,
                "without a velocity",
            ),
            (
                r#"{"sphere": {"center": [0,0,0], "radius": 1}, "velocity": [1,0,0], "until": -1}"#,
                "negative",
            ),
            (
                r#"{"sphere": {"center": [0,0,0], "radius": 1}, "velocity": [1,0,0], "overlap": true}"#,
                "one of them",
            ),
            (r#"{"side": {"face": -1, "uv": [0,0]}}"#, "invalid value"),
            (
                r#"{"inside": {"point": [0,0,0]}, "accuracy": 0}"#,
                "accuracy",
            ),
            (
                r#"{"inside": {"point": [0,0,0]}, "accuracy": "fine"}"#,
                r#"not a query: invalid value: string "fine", expected a positive length or "full" (column"#,
            ),
            (
                r#"{"inside": {"point": [0,0,0]}, "accuracy": [1]}"#,
                r#"expected a positive length or "full""#,
            ),
            (
                r#"{"inside": {"point": [0,0,0]}, "pose": {"rotation": [0,0,0,2]}}"#,
                "is not a unit quaternion: divide it by its length",
            ),
            (
                r#"{"line": {"origin": [0,0,0], "direction": [0,0,1]}, "overlap": true}"#,
                "`overlap` means nothing to line, only to sphere and half_space: leave it out",
            ),
            (
                r#"{"side": {"face": 0, "uv": [0,0]}, "overlap": true}"#,
                "`overlap` means nothing to side",
            ),
            (
                r#"{"sphere": {"center": [0,0,0], "radius": 1}, "hits": "all"}"#,
                "`hits` means nothing to sphere, only to line: leave it out",
            ),
            (
                r#"{"side": {"face": 0, "uv": [0,0]}, "pose": {"translation": [0,0,1]}}"#,
                "`pose` means nothing to side, only to sphere, half_space, line and inside",
            ),
            (
                r#"{"evaluate": {"face": 0, "uv": [0,0]}, "pose": {}}"#,
                "`pose` means nothing to evaluate",
            ),
            (
                r#"{"inside": {"point": [0,0,0]}, "prediction": 1}"#,
                "`prediction` means nothing to inside",
            ),
            (
                r#"{"line": {"origin": [0,0,0], "direction": [0,0,1]}, "contacts": "all"}"#,
                "`contacts` means nothing to line",
            ),
        ] {
            let e = error(line);
            assert!(e.contains(part), "{line}: {e}");
            assert!(!e.contains('\n'), "{line}: {e}");
        }
    }

    /// An accuracy is met by what is exact, too.
    #[test]
    fn an_accuracy_may_stand_beside_any_question() {
        for asked in [
            r#""sphere": {"center": [0,0,0], "radius": 1}"#,
            r#""line": {"origin": [0,0,0], "direction": [0,0,1]}"#,
            r#""side": {"face": 0, "uv": [0,0]}"#,
            r#""evaluate": {"face": 0, "uv": [0,0]}"#,
        ] {
            for accuracy in [r#""full""#, "1", "0.5"] {
                let line = format!(r#"{{{asked}, "accuracy": {accuracy}}}"#);
                let found = QueryLine::parse(&line).unwrap();
                assert!(found.query().unwrap().accuracy.is_some(), "{line}");
                assert_eq!(QueryLine::parse(&found.to_text()).unwrap(), found);
            }
        }
    }

    #[test]
    fn the_id_of_a_refused_line_is_found() {
        for (line, id) in [
            (
                r#"{"inside":{"point":[1,2]},"id":14}"#,
                Some(Value::from(14)),
            ),
            (r#" {"id":"a","ball":{}}"#, Some(Value::from("a"))),
            (
                r#"{"id":{"n":1},"inside":{"point":[0,0,1e999]}}"#,
                Some(serde_json::json!({"n": 1})),
            ),
            (r#"{"inside":{"point":[0,0,0]}}"#, None),
            (r#"{"id":1,"id":2}"#, None),
            (r#"[14]"#, None),
            (r#"{"id":14"#, None),
            ("14", None),
        ] {
            assert_eq!(QueryLine::id_of(line), id, "{line}");
        }
    }

    #[test]
    fn numbers_round_trip() {
        let line = QueryLine {
            sphere: Some(SphereLine {
                center: [0.1, -2.5e-17, 1.0 / 3.0],
                radius: 2.510_000_000_000_000_3,
            }),
            ..QueryLine::default()
        };
        assert_eq!(QueryLine::parse(&line.to_text()).unwrap(), line);
    }

    #[test]
    fn a_pose_turns_then_moves() {
        // A quarter turn about z takes x to y.
        let h = 0.5f64.sqrt();
        let line = format!(
            r#"{{"sphere": {{"center": [1,0,0], "radius": 1}},
                "pose": {{"translation": [0,0,5], "rotation": [0,0,{h},{h}]}}}}"#
        );
        let q = QueryLine::parse(&line).unwrap().query().unwrap();
        let Ask::Contact(Probe::Sphere(s)) = q.ask else {
            panic!("{q:?}")
        };
        assert!((s.center - Point3::new(0.0, 1.0, 5.0)).norm() < 4.0 * f64::EPSILON);
        // A half-space moves along its normal.
        let line =
            r#"{"half_space": {"normal": [0,0,1], "offset": 1}, "pose": {"translation": [7,0,5]}}"#;
        let q = QueryLine::parse(line).unwrap().query().unwrap();
        let Ask::Contact(Probe::HalfSpace(s)) = q.ask else {
            panic!("{q:?}")
        };
        assert_eq!((s.normal, s.offset), (Vector3::z(), 6.0));
    }
}
