//! Stored truth: one line a query, after a line that says what it was made for.

use crate::answer::side_word;
use feeler::numeric::Dyadic;
use feeler::trim::Side;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;

/// Proven by the oracle to hold the true value.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TruthEnclosure {
    /// Lower end.
    #[serde(with = "dyadic")]
    pub lo: Dyadic,
    /// Upper end.
    #[serde(with = "dyadic")]
    pub hi: Dyadic,
}

impl TruthEnclosure {
    /// Both ends with a number added: the sums are exact, and rounded once. Of a large ball's separation f64 has no digit left of how far its centre is.
    pub fn raised(&self, by: f64) -> [f64; 2] {
        let sum =
            |end: &Dyadic| Dyadic::from_f64(by).map_or(f64::NAN, |by| (end + &by).approximate());
        [sum(&self.lo), sum(&self.hi)]
    }
}

/// The first line of a truth file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TruthHeader {
    /// Who computed it, with version.
    pub oracle: String,
    /// [`bytes_hash`](crate::bytes_hash) of the query file.
    pub queries: String,
    /// [`Model::hash`](crate::Model::hash) of each model the queries name.
    pub models: BTreeMap<String, String>,
}

/// One hit of a line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HitTruth {
    /// The parameter.
    pub t: TruthEnclosure,
    /// The other end of a whole interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub t_end: Option<TruthEnclosure>,
    /// The face.
    pub face: usize,
    /// Whether the line touches it without crossing; `None` where the oracle does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tangential: Option<bool>,
}

/// `[lo, hi]` of x, y and z.
pub type SpaceBox = [[f64; 2]; 3];

/// Where a contact is, or may be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactTruth {
    /// The separation there, if it is due.
    pub separation: TruthEnclosure,
    /// A box that holds the contact.
    pub at: SpaceBox,
    /// Whether there is a contact in the box, and within the prediction: an answer must have it. Otherwise it may.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub due: bool,
    /// Whether the contact may be no point (or its box is too large to tell): nothing is said of the foot.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub continuum: bool,
}

/// Where one coordinate of a trim curve is stationary.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisSplitTruth {
    /// By the curve's parameter.
    pub roots: Vec<SplitRootTruth>,
    /// The maximal parts on which the coordinate is constant, by their ends.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constant: Vec<[TruthEnclosure; 2]>,
}

/// A derivative root, or a joint of Bezier pieces where the coordinate turns.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SplitRootTruth {
    /// The parameter of the trim's curve.
    pub t: TruthEnclosure,
    /// How often the derivative vanishes, seen from below and from above.
    pub multiplicity: [usize; 2],
    /// Whether the derivative changes its sign.
    pub turns: bool,
}

/// The truth of one query.
#[allow(
    clippy::large_enum_variant,
    reason = "a few thousand at once, and evaluations are a sixth of them"
)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Truth {
    /// Of a sphere or half-space.
    Separation(TruthEnclosure),
    /// Of a sphere or half-space, with its contacts.
    Contact {
        /// From the union of the BREPs.
        separation: TruthEnclosure,
        /// A box that holds the foot of the deepest contact, where there is just one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        foot: Option<SpaceBox>,
        /// Every contact is in one of these; `None` where all were not asked for.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        contacts: Option<Vec<ContactTruth>>,
    },
    /// Of a side, in uv or in space.
    Side {
        /// The side.
        #[serde(with = "side")]
        side: Side,
        /// Whether it lies in the box of a gap; `None` in space.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        in_gap: Option<bool>,
    },
    /// Of a line.
    Line {
        /// In the order of t.
        hits: Vec<HitTruth>,
        /// How often it passes through the faces; `None` where the oracle does not say, near edges.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        crossings: Option<usize>,
        /// Whether it passes an edge within its crack; `None` likewise.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        in_crack: Option<bool>,
    },
    /// Of an evaluation.
    Evaluate {
        /// The point.
        point: [TruthEnclosure; 3],
        /// Derivative along u, from above at a knot.
        du: [TruthEnclosure; 3],
        /// Derivative along v, likewise.
        dv: [TruthEnclosure; 3],
    },
    /// Of a split: u and v.
    Split {
        /// Where u is stationary.
        u: AxisSplitTruth,
        /// Where v is.
        v: AxisSplitTruth,
    },
    /// The oracle could not settle it; every such line counts as indeterminate.
    Unknown {
        /// Why.
        why: String,
    },
}

mod dyadic {
    use super::*;

    pub(super) fn serialize<S: Serializer>(d: &Dyadic, s: S) -> Result<S::Ok, S::Error> {
        s.collect_str(d)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Dyadic, D::Error> {
        String::deserialize(d)?.parse().map_err(D::Error::custom)
    }
}

mod side {
    use super::*;

    pub(super) fn serialize<S: Serializer>(side: &Side, s: S) -> Result<S::Ok, S::Error> {
        s.serialize_str(side_word(*side))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Side, D::Error> {
        match String::deserialize(d)?.as_str() {
            "inside" => Ok(Side::Inside),
            "outside" => Ok(Side::Outside),
            "boundary" => Ok(Side::Boundary),
            other => Err(D::Error::custom(format!("no side: {other}"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_round_trips_as_text() {
        let third = TruthEnclosure {
            lo: "5555p-16".parse().unwrap(),
            hi: "5556p-16".parse().unwrap(),
        };
        let text = serde_json::to_string(&Truth::Separation(third.clone())).unwrap();
        assert_eq!(text, r#"{"separation":{"lo":"5555p-16","hi":"5556p-16"}}"#);
        for truth in [
            Truth::Separation(third.clone()),
            Truth::Side {
                side: Side::Boundary,
                in_gap: Some(false),
            },
            Truth::Contact {
                separation: third.clone(),
                foot: Some([[0.1, 0.25], [-1e-300, 0.0], [2.0, 2.0]]),
                contacts: Some(vec![ContactTruth {
                    separation: third.clone(),
                    at: [[0.1, 0.1 + f64::EPSILON], [0.0, 1.0], [-3.0, -3.0]],
                    due: true,
                    continuum: false,
                }]),
            },
            Truth::Line {
                hits: vec![HitTruth {
                    t: third,
                    t_end: None,
                    face: 3,
                    tangential: Some(true),
                }],
                crossings: Some(1),
                in_crack: None,
            },
        ] {
            let text = serde_json::to_string(&truth).unwrap();
            assert_eq!(serde_json::from_str::<Truth>(&text).unwrap(), truth);
        }
        assert!(serde_json::from_str::<Truth>(r#"{"separation":{"lo":"1","hi":"1p0"}}"#).is_err());
    }
}
