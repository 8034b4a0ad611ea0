//! Reading answers, which engines of others write.

use super::{Answer, AxisSplitLine, Body, Claim, ContactLine, HitLine};
use crate::query::{Ask, Query};
use feeler::trim::Side;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value};

/// Why a line is no answer to its query.
#[derive(Debug, thiserror::Error)]
pub enum AnswerError {
    /// Not one object of JSON.
    #[error("not an object of JSON: `{0}`")]
    Json(String),
    /// Fields are missing, misspelt or of another type.
    #[error("no answer to a query of kind {kind}: {why}")]
    Fields {
        /// What was asked.
        kind: &'static str,
        /// What is wrong.
        why: String,
    },
}

/// How much of a line that is no answer is shown.
const SHOWN: usize = 80;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ErrorText {
    error: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ContactText {
    separation: Claim,
    continuum: Option<bool>,
    contacts: Vec<ContactLine>,
    undecided: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ArrivalText {
    // Present, be it `null`: never is an answer, and must be said.
    #[serde(deserialize_with = "Option::deserialize")]
    arrival: Option<Claim>,
    continuum: Option<bool>,
    contacts: Vec<ContactLine>,
    undecided: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OverlapText {
    overlap: Option<bool>,
    undecided: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LineText {
    hits: Vec<HitLine>,
    crossings: Option<usize>,
    in_crack: Option<bool>,
    undecided: Option<String>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum SideText {
    Inside,
    Outside,
    Boundary,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SideAnswerText {
    side: Option<SideText>,
    in_gap: Option<bool>,
    undecided: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EvaluateText {
    point: [f64; 3],
    du: [f64; 3],
    dv: [f64; 3],
    #[serde(default, deserialize_with = "upper")]
    bound: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SplitText {
    u: AxisSplitLine,
    v: AxisSplitLine,
    undecided: Option<String>,
}

/// A bound that is given; `null` is how an infinite one is written.
fn given<'de, D: Deserializer<'de>>(d: D, infinite: f64) -> Result<Option<f64>, D::Error> {
    Ok(Some(Option::deserialize(d)?.unwrap_or(infinite)))
}

pub(super) fn lower<'de, D: Deserializer<'de>>(d: D) -> Result<Option<f64>, D::Error> {
    given(d, f64::NEG_INFINITY)
}

pub(super) fn upper<'de, D: Deserializer<'de>>(d: D) -> Result<Option<f64>, D::Error> {
    given(d, f64::INFINITY)
}

impl Answer {
    /// Reads the answer to a query.
    ///
    /// Bounds, `in_gap`, `crossings`, `in_crack`, `tangential`, `feature`, `uv` and `continuum` may be left out. What was asked must be there, or `undecided` in its place. A field that the
    /// protocol does not know is refused: misspelt, it would go unjudged.
    ///
    /// # Errors
    /// [`AnswerError`], in one line.
    pub fn read(text: &str, query: &Query) -> Result<Self, AnswerError> {
        let Ok(mut fields) = serde_json::from_str::<Map<String, Value>>(text) else {
            return Err(AnswerError::Json(text.trim().chars().take(SHOWN).collect()));
        };
        let id = fields.remove("id");
        let body = body(fields, query).map_err(|why| AnswerError::Fields {
            kind: query.ask.word(),
            why,
        })?;
        Ok(Self { id, body })
    }
}

fn take<T: DeserializeOwned>(fields: Map<String, Value>) -> Result<T, String> {
    serde_json::from_value(Value::Object(fields)).map_err(|e| e.to_string())
}

/// What was asked is there, or why not.
fn settled<T>(what: &str, found: Option<T>, why: &Option<String>) -> Result<Option<T>, String> {
    match (&found, why) {
        (None, None) => Err(format!(
            "missing field `{what}`, or `undecided` in its place"
        )),
        _ => Ok(found),
    }
}

fn body(fields: Map<String, Value>, query: &Query) -> Result<Body, String> {
    if fields.contains_key("error") {
        let ErrorText { error } = take(fields)?;
        return Ok(Body::Error { error });
    }
    Ok(match query.ask {
        Ask::Contact(_) if query.overlap => {
            let a: OverlapText = take(fields)?;
            Body::Overlap {
                overlap: settled("overlap", a.overlap, &a.undecided)?,
                undecided: a.undecided,
            }
        }
        Ask::Contact(_) => {
            let a: ContactText = take(fields)?;
            Body::Contact {
                separation: a.separation,
                continuum: a.continuum,
                contacts: a.contacts,
                undecided: a.undecided,
            }
        }
        Ask::Arrival(..) => {
            let a: ArrivalText = take(fields)?;
            Body::Arrival {
                arrival: a.arrival,
                continuum: a.continuum,
                contacts: a.contacts,
                undecided: a.undecided,
            }
        }
        Ask::Line(_) => {
            let a: LineText = take(fields)?;
            Body::Line {
                hits: a.hits,
                crossings: a.crossings,
                in_crack: a.in_crack,
                undecided: a.undecided,
            }
        }
        Ask::Side(..) | Ask::Inside(_) => {
            let a: SideAnswerText = take(fields)?;
            let side = settled("side", a.side, &a.undecided)?;
            Body::Side {
                side: side.map(|s| match s {
                    SideText::Inside => Side::Inside,
                    SideText::Outside => Side::Outside,
                    SideText::Boundary => Side::Boundary,
                }),
                in_gap: a.in_gap,
                undecided: a.undecided,
            }
        }
        Ask::Evaluate(..) => {
            let a: EvaluateText = take(fields)?;
            Body::Evaluate {
                point: a.point,
                du: a.du,
                dv: a.dv,
                bound: a.bound,
            }
        }
        Ask::Split(_) => {
            let a: SplitText = take(fields)?;
            Body::Split {
                u: a.u,
                v: a.v,
                undecided: a.undecided,
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::QueryLine;

    const SPHERE: &str = r#"{"sphere":{"center":[0.0,0.0,0.1],"radius":1.0}}"#;
    const ARRIVAL: &str =
        r#"{"sphere":{"center":[0.0,0.0,0.1],"radius":1.0},"velocity":[0.0,0.0,-1.0],"until":5.0}"#;
    const LINE: &str =
        r#"{"line":{"origin":[0.0,0.0,0.0],"direction":[0.0,0.0,1.0],"kind":"ray"}}"#;
    const SIDE: &str = r#"{"side":{"face":3,"uv":[0.1,0.2]}}"#;
    const SPLIT: &str = r#"{"split":{"face":0,"loop":1,"trim":2}}"#;
    const EVALUATE: &str = r#"{"evaluate":{"face":3,"uv":[0.1,0.2]}}"#;

    fn query(text: &str) -> Query {
        QueryLine::parse(text).unwrap().query().unwrap()
    }

    /// Whole answers, as the kernel writes them, and the least that an engine without certificates says.
    #[test]
    fn what_is_written_is_read() {
        for (asked, answers) in [
            (
                SPHERE,
                &[
                    r#"{"id":7,"separation":{"value":-0.1,"lo":null,"hi":0.5},"continuum":true,"contacts":[{"on_brep":[0.0,0.0,0.0],"on_probe":[0.0,0.0,0.0],"normal":[0.0,0.0,1.0],"separation":{"value":1.0},"feature":{"edge":3},"uv":[0.1,0.2],"position_bound":null,"normal_bound":1e-9}],"undecided":"node budget spent"}"#,
                    r#"{"separation":{"value":0.1},"continuum":false,"contacts":[]}"#,
                    r#"{"separation":{"value":0.1},"contacts":[]}"#,
                    r#"{"error":"not today"}"#,
                ][..],
            ),
            (
                ARRIVAL,
                &[
                    r#"{"arrival":{"value":0.5,"lo":0.4,"hi":null},"continuum":false,"contacts":[],"undecided":"node budget spent"}"#,
                    r#"{"arrival":null,"continuum":false,"contacts":[]}"#,
                ],
            ),
            (
                LINE,
                &[
                    r#"{"hits":[{"t":{"value":0.5,"lo":0.4,"hi":0.6},"t_end":{"value":1.0},"point":[0.0,0.0,0.5],"normal":[0.0,0.0,1.0],"feature":{"vertex":0},"uv":[0.1,0.2],"tangential":false}],"crossings":1,"in_crack":false}"#,
                    r#"{"hits":[{"t":{"value":0.5},"point":[0.0,0.0,0.5],"normal":[0.0,0.0,1.0]}]}"#,
                ],
            ),
            (
                SIDE,
                &[
                    r#"{"side":"boundary","in_gap":true}"#,
                    r#"{"id":"a","side":"outside"}"#,
                    r#"{"in_gap":false,"undecided":"crack"}"#,
                ],
            ),
            (
                EVALUATE,
                &[
                    r#"{"point":[0.1,0.2,0.3],"du":[1.0,0.0,0.0],"dv":[0.0,1.0,0.0],"bound":null}"#,
                    r#"{"point":[0.1,0.2,0.3],"du":[1.0,0.0,0.0],"dv":[0.0,1.0,0.0]}"#,
                ],
            ),
            (
                SPLIT,
                &[
                    r#"{"u":{"roots":[{"t":{"value":0.5,"lo":0.5,"hi":0.5},"multiplicity":[1,1],"turns":true}],"constant":[]},"v":{"roots":[],"constant":[[{"value":0.0},{"value":1.0}]]}}"#,
                ],
            ),
        ] {
            for text in answers {
                let answer = Answer::read(text, &query(asked)).unwrap();
                assert_eq!(&answer.to_text(), text);
            }
        }
        let text = r#"{"separation":{"value":0.1,"lo":null,"hi":null},"contacts":[]}"#;
        let Body::Contact { separation, .. } = Answer::read(text, &query(SPHERE)).unwrap().body
        else {
            panic!("not of a contact");
        };
        let bounds = (separation.lo, separation.hi);
        assert_eq!(bounds, (Some(f64::NEG_INFINITY), Some(f64::INFINITY)));
    }

    #[test]
    fn what_is_no_answer_is_named() {
        for (asked, text, what) in [
            (SPHERE, "hello", "not an object of JSON: `hello`"),
            (SPHERE, "[1]", "not an object"),
            (
                SPHERE,
                r#"{"separation":{"value":NaN},"contacts":[]}"#,
                "not an object",
            ),
            (
                SPHERE,
                r#"{"separation":{"value":null},"contacts":[]}"#,
                "null",
            ),
            (
                SPHERE,
                r#"{"separation":{"value":1.0}}"#,
                "missing field `contacts`",
            ),
            (SPHERE, r#"{"contacts":[]}"#, "missing field `separation`"),
            (
                SPHERE,
                r#"{"side":"inside"}"#,
                "kind sphere: unknown field `side`",
            ),
            (SIDE, "{}", "missing field `side`"),
            (SIDE, r#"{"in_gap":false}"#, "missing field `side`"),
            (SIDE, r#"{"side":"in"}"#, "unknown variant `in`"),
            (
                SIDE,
                r#"{"side":"inside","in_gapp":true}"#,
                "unknown field `in_gapp`",
            ),
            (ARRIVAL, r#"{"contacts":[]}"#, "missing field `arrival`"),
            (LINE, r#"{"crossings":1}"#, "missing field `hits`"),
            (
                LINE,
                r#"{"hits":[{"t":{"value":1.0}}]}"#,
                "missing field `point`",
            ),
            (EVALUATE, r#"{"point":[0.1,0.2]}"#, "length 2"),
        ] {
            let error = Answer::read(text, &query(asked)).unwrap_err().to_string();
            assert!(error.contains(what), "{text}: {error}");
        }
    }

    #[test]
    fn a_query_can_be_written_again() {
        for text in [
            SPHERE,
            ARRIVAL,
            LINE,
            SIDE,
            SPLIT,
            EVALUATE,
            r#"{"id":7,"half_space":{"normal":[0.0,0.0,1.0],"offset":0.5},"prediction":0.25,"contacts":"all","accuracy":"full"}"#,
            r#"{"sphere":{"center":[0.0,0.0,0.1],"radius":1.0},"accuracy":1e-9,"overlap":true}"#,
            r#"{"inside":{"point":[0.0,0.1,0.2]}}"#,
        ] {
            assert_eq!(QueryLine::from(&query(text)).to_text(), text);
        }
        // The probe stands where its pose put it.
        let posed = query(
            r#"{"line":{"origin":[1.0,0.0,0.0],"direction":[0.0,0.0,1.0],"kind":"ray"},"pose":{"translation":[0.0,0.0,2.0]},"hits":"first"}"#,
        );
        assert_eq!(
            QueryLine::from(&posed).to_text(),
            r#"{"line":{"origin":[1.0,0.0,2.0],"direction":[0.0,0.0,1.0],"kind":"ray"},"hits":"first"}"#
        );
        assert_eq!(QueryLine::from(&posed).query().unwrap(), posed);
    }
}
