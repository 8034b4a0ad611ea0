//! An answer, as a line of JSON.
//!
//! What an engine cannot know it leaves out: that is not claimed, and hence not judged.

use feeler::numeric::Enclosure;
use feeler::nurbs::SurfacePoint;
use feeler::query::{
    ArrivalAnswer, Contact, ContactAnswer, Feature, Hit, LineAnswer, Parameter, Separation,
    SideAnswer, Undecided, Unsettled,
};
use feeler::trim::{AxisSplit, Side, Stationary};
use serde::{Deserialize, Serialize, Serializer};
use serde_json::Value;

mod read;

pub use read::AnswerError;

/// A value and what is claimed of it.
///
/// `lo` and `hi` are left out by engines without certificates. A claim that is infinite
/// (nothing is known) is written as `null`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// The value to use.
    pub value: f64,
    /// Proven lower bound.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "read::lower"
    )]
    pub lo: Option<f64>,
    /// Proven upper bound.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "read::upper"
    )]
    pub hi: Option<f64>,
}

/// One contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactLine {
    /// Point on the BREP.
    pub on_brep: [f64; 3],
    /// Point on the probe.
    pub on_probe: [f64; 3],
    /// Unit normal from BREP to probe.
    pub normal: [f64; 3],
    /// Signed gap here.
    pub separation: Claim,
    /// What is touched, counted through the file's BREPs; none from engines that do not know, as of a mesh.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        with = "feature_text"
    )]
    pub feature: Option<Feature>,
    /// Parameters on the face; none likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uv: Option<[f64; 2]>,
    /// Bound on the distance of `on_brep` from the true point.
    #[serde(default)]
    pub position_bound: Option<f64>,
    /// Bound on the angle of `normal`, in radians.
    #[serde(default)]
    pub normal_bound: Option<f64>,
    /// Whether `normal` is one of many; written where it is.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub normal_is_choice: bool,
}

/// One hit of a line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HitLine {
    /// The parameter.
    pub t: Claim,
    /// The other end of a whole interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub t_end: Option<Claim>,
    /// The point.
    pub point: [f64; 3],
    /// The face's normal.
    pub normal: [f64; 3],
    /// What is hit, counted through the file's BREPs; none from engines that do not know.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        with = "feature_text"
    )]
    pub feature: Option<Feature>,
    /// Parameters on the face; none likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uv: Option<[f64; 2]>,
    /// Whether it touches without crossing; none likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tangential: Option<bool>,
}

/// What an answer says.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Body {
    /// The query was refused.
    Error {
        /// Why.
        error: String,
    },
    /// Of a sphere or half-space.
    Contact {
        /// From the union of the BREPs.
        separation: Claim,
        /// Whether the closest points reach beyond one foot box; none where that was not looked at, as when no contacts are asked for.
        #[serde(skip_serializing_if = "Option::is_none")]
        continuum: Option<bool>,
        /// Deepest first.
        contacts: Vec<ContactLine>,
        /// Why the bound is wider than asked.
        #[serde(skip_serializing_if = "Option::is_none")]
        undecided: Option<String>,
    },
    /// Of a sphere or half-space with a velocity.
    Arrival {
        /// When it first comes within the prediction: not before `lo`, and at `value`, unless `hi` is infinite; `null` if proven never, until
        /// the time asked about.
        arrival: Option<Claim>,
        /// Whether the closest points then reach beyond one foot box; none likewise.
        #[serde(skip_serializing_if = "Option::is_none")]
        continuum: Option<bool>,
        /// The contacts at `value`, deepest first.
        contacts: Vec<ContactLine>,
        /// Why the enclosure is wider than asked.
        #[serde(skip_serializing_if = "Option::is_none")]
        undecided: Option<String>,
    },
    /// Of a query with `"overlap": true`.
    Overlap {
        /// Whether the separation is negative; none where undecided.
        #[serde(skip_serializing_if = "Option::is_none")]
        overlap: Option<bool>,
        /// Why it is not known.
        #[serde(skip_serializing_if = "Option::is_none")]
        undecided: Option<String>,
    },
    /// Of a line.
    Line {
        /// In the order of t.
        hits: Vec<HitLine>,
        /// How often the line passes through; none from engines that do not say.
        #[serde(skip_serializing_if = "Option::is_none")]
        crossings: Option<usize>,
        /// Whether it passes an edge within its crack; none likewise.
        #[serde(skip_serializing_if = "Option::is_none")]
        in_crack: Option<bool>,
        /// Why the hits are not settled.
        #[serde(skip_serializing_if = "Option::is_none")]
        undecided: Option<String>,
    },
    /// Of a side, in uv or in space.
    Side {
        /// The side; none where undecided.
        #[serde(serialize_with = "write_side", skip_serializing_if = "Option::is_none")]
        side: Option<Side>,
        /// Whether it lies in the box of a gap; none from engines that do not say.
        #[serde(skip_serializing_if = "Option::is_none")]
        in_gap: Option<bool>,
        /// Why it is not known.
        #[serde(skip_serializing_if = "Option::is_none")]
        undecided: Option<String>,
    },
    /// Of an evaluation.
    Evaluate {
        /// The point.
        point: [f64; 3],
        /// Derivative along u.
        du: [f64; 3],
        /// Derivative along v.
        dv: [f64; 3],
        /// Bound on each coordinate of the point; none from engines without certificates.
        #[serde(skip_serializing_if = "Option::is_none")]
        bound: Option<f64>,
    },
    /// Of a split.
    Split {
        /// Where u is stationary.
        u: AxisSplitLine,
        /// Where v is.
        v: AxisSplitLine,
        /// Why they are not known; the lists are empty then.
        #[serde(skip_serializing_if = "Option::is_none")]
        undecided: Option<String>,
    },
}

/// Where one coordinate of a trim curve is stationary.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisSplitLine {
    /// By the curve's parameter.
    pub roots: Vec<SplitRootLine>,
    /// The parts on which the coordinate is constant, by their ends.
    pub constant: Vec<[Claim; 2]>,
}

/// A derivative root, or a joint where the coordinate turns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SplitRootLine {
    /// The parameter of the trim's curve.
    pub t: Claim,
    /// How often the derivative vanishes, from below and from above.
    pub multiplicity: [usize; 2],
    /// Whether the coordinate turns.
    pub turns: bool,
}

/// An answer: what it says, with the id of its query.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// Copied from the query.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<Value>,
    /// What it says.
    #[serde(flatten)]
    pub body: Body,
}

impl Answer {
    /// The line, numbers in shortest round-trip form.
    pub fn to_text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

impl Body {
    /// Leaves out what is not looked at where no contacts are asked for.
    pub fn without_continuum(mut self) -> Self {
        if let Self::Contact { continuum, .. } | Self::Arrival { continuum, .. } = &mut self {
            *continuum = None;
        }
        self
    }

    /// Why the answer has only a bound, if so.
    pub fn undecided(&self) -> Option<&str> {
        match self {
            Self::Contact { undecided, .. }
            | Self::Arrival { undecided, .. }
            | Self::Overlap { undecided, .. }
            | Self::Line { undecided, .. }
            | Self::Side { undecided, .. }
            | Self::Split { undecided, .. } => undecided.as_deref(),
            Self::Evaluate { .. } | Self::Error { .. } => None,
        }
    }
}

impl From<Separation> for Claim {
    fn from(s: Separation) -> Self {
        Self {
            value: s.value,
            lo: Some(s.bounds.lo),
            hi: Some(s.bounds.hi),
        }
    }
}

impl From<&Contact> for ContactLine {
    fn from(c: &Contact) -> Self {
        Self {
            on_brep: c.on_brep.coords.into(),
            on_probe: c.on_probe.coords.into(),
            normal: c.normal.into(),
            separation: c.separation.into(),
            feature: Some(c.feature),
            uv: Some(c.uv.coords.into()),
            position_bound: c.position_bound,
            normal_bound: c.normal_bound,
            normal_is_choice: c.normal_is_choice,
        }
    }
}

impl From<Parameter> for Claim {
    fn from(t: Parameter) -> Self {
        Self {
            value: t.value,
            lo: Some(t.bounds.lo),
            hi: Some(t.bounds.hi),
        }
    }
}

impl From<&Hit> for HitLine {
    fn from(h: &Hit) -> Self {
        Self {
            t: h.t.into(),
            t_end: h.t_end.map(Claim::from),
            point: h.point.coords.into(),
            normal: h.normal.into(),
            feature: Some(h.feature),
            uv: Some(h.uv.coords.into()),
            tangential: Some(h.tangential),
        }
    }
}

fn why(u: Option<Undecided>) -> Option<String> {
    u.map(|u| u.to_string())
}

/// Why the hits of a line are not settled, and where.
pub fn why_at(undecided: Option<Undecided>, place: Option<Unsettled>) -> Option<String> {
    let why = undecided?;
    Some(match place {
        Some(place) => format!("{place}: {why}"),
        None => why.to_string(),
    })
}

impl From<&ContactAnswer> for Body {
    fn from(a: &ContactAnswer) -> Self {
        Self::Contact {
            separation: a.separation.into(),
            continuum: Some(a.continuum),
            contacts: a.contacts.iter().map(ContactLine::from).collect(),
            undecided: why(a.undecided),
        }
    }
}

impl From<&ArrivalAnswer> for Body {
    fn from(a: &ArrivalAnswer) -> Self {
        Self::Arrival {
            arrival: a.time.map(Claim::from),
            continuum: Some(a.continuum),
            contacts: a.contacts.iter().map(ContactLine::from).collect(),
            undecided: why(a.undecided),
        }
    }
}

impl From<&LineAnswer> for Body {
    fn from(a: &LineAnswer) -> Self {
        Self::Line {
            hits: a.hits.iter().map(HitLine::from).collect(),
            crossings: a.crossings,
            in_crack: Some(a.in_crack),
            undecided: why_at(a.undecided, a.unsettled),
        }
    }
}

impl From<SideAnswer> for Body {
    fn from(a: SideAnswer) -> Self {
        Self::Side {
            side: a.side,
            in_gap: Some(a.in_gap),
            undecided: why(a.undecided),
        }
    }
}

impl From<Enclosure> for Claim {
    fn from(e: Enclosure) -> Self {
        Self {
            value: e.mid(),
            lo: Some(e.lo),
            hi: Some(e.hi),
        }
    }
}

impl From<&AxisSplit> for AxisSplitLine {
    fn from(axis: &AxisSplit) -> Self {
        let root = |s: &Stationary| SplitRootLine {
            t: Claim {
                value: s.t,
                ..s.bounds.into()
            },
            multiplicity: s.multiplicity,
            turns: s.turns(),
        };
        Self {
            roots: axis.places.iter().map(root).collect(),
            constant: axis.constant.iter().map(|c| c.map(Claim::from)).collect(),
        }
    }
}

impl From<Option<[AxisSplit; 2]>> for Body {
    fn from(found: Option<[AxisSplit; 2]>) -> Self {
        let [u, v] = found.as_ref().map_or_else(Default::default, |axes| {
            axes.each_ref().map(AxisSplitLine::from)
        });
        Self::Split {
            u,
            v,
            undecided: why(found.is_none().then_some(Undecided::Degenerate)),
        }
    }
}

impl From<SurfacePoint> for Body {
    fn from(e: SurfacePoint) -> Self {
        Self::Evaluate {
            point: e.point.coords.into(),
            du: e.du.into(),
            dv: e.dv.into(),
            bound: Some(e.bound),
        }
    }
}

/// The protocol's word for a side.
pub fn side_word(side: Side) -> &'static str {
    match side {
        Side::Inside => "inside",
        Side::Outside => "outside",
        Side::Boundary => "boundary",
    }
}

fn write_side<S: Serializer>(side: &Option<Side>, s: S) -> Result<S::Ok, S::Error> {
    side.map(side_word).serialize(s)
}

/// A feature as `{"face": 3}`.
mod feature_text {
    use feeler::query::Feature;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Text {
        Face(usize),
        Edge(usize),
        Vertex(usize),
    }

    pub(super) fn serialize<S: Serializer>(f: &Option<Feature>, s: S) -> Result<S::Ok, S::Error> {
        let text = f.map(|f| match f {
            Feature::Face(i) => Text::Face(i),
            Feature::Edge(i) => Text::Edge(i),
            Feature::Vertex(i) => Text::Vertex(i),
        });
        text.serialize(s)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        d: D,
    ) -> Result<Option<Feature>, D::Error> {
        let text = Option::<Text>::deserialize(d)?;
        Ok(text.map(|t| match t {
            Text::Face(i) => Feature::Face(i),
            Text::Edge(i) => Feature::Edge(i),
            Text::Vertex(i) => Feature::Vertex(i),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_look_as_the_protocol_says() {
        let claim = Claim {
            value: -0.1,
            lo: Some(f64::NEG_INFINITY),
            hi: Some(0.5),
        };
        let answer = Answer {
            id: Some(7.into()),
            body: Body::Contact {
                separation: claim,
                continuum: Some(false),
                contacts: vec![ContactLine {
                    on_brep: [0.0; 3],
                    on_probe: [0.0; 3],
                    normal: [0.0, 0.0, 1.0],
                    separation: Claim {
                        value: 1.0,
                        lo: None,
                        hi: None,
                    },
                    feature: Some(Feature::Edge(3)),
                    uv: Some([0.1, 0.2]),
                    position_bound: None,
                    normal_bound: Some(1e-9),
                    normal_is_choice: false,
                }],
                undecided: Some("node budget spent".into()),
            },
        };
        assert_eq!(
            answer.to_text(),
            r#"{"id":7,"separation":{"value":-0.1,"lo":null,"hi":0.5},"continuum":false,"contacts":[{"on_brep":[0.0,0.0,0.0],"on_probe":[0.0,0.0,0.0],"normal":[0.0,0.0,1.0],"separation":{"value":1.0},"feature":{"edge":3},"uv":[0.1,0.2],"position_bound":null,"normal_bound":1e-9}],"undecided":"node budget spent"}"#
        );
        let body = Body::from(SideAnswer {
            side: Some(Side::Boundary),
            in_gap: true,
            undecided: None,
        });
        let answer = Answer { id: None, body };
        assert_eq!(answer.to_text(), r#"{"side":"boundary","in_gap":true}"#);
    }
}
