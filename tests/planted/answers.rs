//! Mistakes in answers.

use crate::{found_where, gate, must_be_found, row};
use feeler::query::Options;
use feeler::trim::Side;
use feeler_corpus::{Answer, Ask, Body, Claim, Model, Query, Truth};
use feeler_gate::{Engine, FeelerEngine};

/// The error that the gate must find in a depth, in model units (mm).
const DEPTH_ERROR: f64 = 1e-9;
/// How near to a trim, in uv, the flipped sides are.
const NEAR: f64 = 1e-6;

/// The claim of a separation, where the kernel decided it.
fn decided(answer: &Answer) -> Option<(Claim, f64, f64)> {
    match &answer.body {
        Body::Contact {
            separation,
            undecided: None,
            ..
        } => Some((*separation, separation.lo?, separation.hi?)),
        _ => None,
    }
}

/// The same answer with another separation.
fn with_separation(answer: &Answer, separation: Claim) -> Option<Body> {
    let mut body = answer.body.clone();
    if let Body::Contact {
        separation: s,
        contacts,
        ..
    } = &mut body
    {
        *s = separation;
        contacts.iter_mut().for_each(|c| c.separation = separation);
    }
    Some(body)
}

/// The value and both bounds: an enclosure as narrow as the right one, but elsewhere.
#[test]
fn a_depth_error_of_1e_9() {
    for suite in ["contact-half-space", "contact-sphere", "thesis"] {
        must_be_found(suite, "a depth error of 1e-9", |_, _, answer, _| {
            let (claim, lo, hi) = decided(answer)?;
            let off = Claim {
                value: claim.value - DEPTH_ERROR,
                lo: Some(lo - DEPTH_ERROR),
                hi: Some(hi - DEPTH_ERROR),
            };
            (hi < 0.0).then(|| with_separation(answer, off))?
        });
    }
}

/// The next two f64s above the proven enclosure.
#[test]
fn an_enclosure_that_excludes_the_truth() {
    for suite in ["contact-half-space", "contact-sphere"] {
        must_be_found(
            suite,
            "an enclosure that excludes the truth",
            |_, _, answer, _| {
                let (_, _, hi) = decided(answer)?;
                let lo = hi.next_up();
                let claim = Claim {
                    value: lo,
                    lo: Some(lo),
                    hi: Some(lo.next_up()),
                };
                with_separation(answer, claim)
            },
        );
    }
    must_be_found(
        "evaluate",
        "a point outside its bound",
        |_, _, answer, _| {
            let mut body = answer.body.clone();
            let Body::Evaluate { bound, point, .. } = &mut body else {
                return None;
            };
            // By more than twice the bound, which stays.
            point[0] = (point[0] + 2.0 * (*bound)?).next_up();
            Some(body)
        },
    );
}

#[test]
fn a_missed_hit_and_a_hit_too_many() {
    must_be_found("line", "a missed hit", |_, _, answer, _| {
        let mut body = answer.body.clone();
        let Body::Line {
            hits,
            undecided: None,
            ..
        } = &mut body
        else {
            return None;
        };
        // Two of one t are an edge's, which may count once.
        let last = hits.pop()?;
        let apart = hits.last().is_none_or(|h| h.t.hi < last.t.lo);
        apart.then_some(body)
    });
    must_be_found("line", "a hit too many", |_, _, answer, _| {
        let mut body = answer.body.clone();
        let Body::Line {
            hits,
            undecided: None,
            ..
        } = &mut body
        else {
            return None;
        };
        let again = hits.last()?.clone();
        hits.extend([again.clone(), again]);
        Some(body)
    });
}

/// Inside and outside swapped for a point next to a trim: one of four points around it is on the other side.
#[test]
fn a_flipped_side_at_a_trim() {
    must_be_found(
        "side",
        "a flipped side at a trim",
        |engine, query, answer, _| {
            let (Ask::Side(face, uv), Body::Side { side, in_gap, .. }) = (&query.ask, &answer.body)
            else {
                return None;
            };
            let flipped = match (*side)? {
                Side::Inside => Side::Outside,
                Side::Outside => Side::Inside,
                Side::Boundary => return None,
            };
            let mut around = [[NEAR, 0.0], [-NEAR, 0.0], [0.0, NEAR], [0.0, -NEAR]]
                .into_iter()
                .map(|[du, dv]| {
                    let mut near = query.clone();
                    near.ask = Ask::Side(*face, [uv.x + du, uv.y + dv].into());
                    engine.answer(&near).body
                });
            let near =
                around.any(|b| matches!(b, Body::Side { side, .. } if side == Some(flipped)));
            near.then_some(Body::Side {
                side: Some(flipped),
                in_gap: *in_gap,
                undecided: None,
            })
        },
    );
}

/// The answer to the query before, to a query of the same kind.
#[test]
fn a_stale_answer() {
    for suite in ["contact-half-space", "contact-sphere", "evaluate", "side"] {
        must_be_found(suite, "a stale answer", |_, _, answer, before| {
            let before = &before?.body;
            match (before, &answer.body) {
                // One that could be right by chance shows nothing.
                (Body::Side { side: a, .. }, Body::Side { side: b, .. }) if a == b => None,
                (Body::Evaluate { point: a, .. }, Body::Evaluate { point: b, .. }) if a == b => {
                    None
                }
                (Body::Contact { separation: a, .. }, Body::Contact { separation: b, .. })
                    if a == b =>
                {
                    None
                }
                _ => Some(before.clone()),
            }
        });
    }
}

#[test]
fn an_answer_that_is_no_number_and_a_refusal() {
    must_be_found("contact-half-space", "a NaN", |_, _, answer, _| {
        let (claim, ..) = decided(answer)?;
        let value = f64::NAN;
        with_separation(answer, Claim { value, ..claim })
    });
    must_be_found("side", "a refusal", |_, _, _, _| {
        let error = "not today".to_owned();
        Some(Body::Error { error })
    });
}

/// No claim is wrong, but nothing is claimed either: that is not wrong, and must not pass.
#[test]
fn an_answer_without_a_bound() {
    struct Boundless(FeelerEngine);
    impl Engine for Boundless {
        fn name(&self) -> String {
            "boundless".to_owned()
        }
        fn open(&mut self, model: &Model) -> Result<(), String> {
            self.0.open(model)
        }
        fn answer(&mut self, query: &Query) -> Answer {
            let mut answer = self.0.answer(query);
            if let Body::Contact { separation, .. } = &mut answer.body {
                separation.lo = Some(f64::NEG_INFINITY);
                separation.hi = Some(f64::INFINITY);
            }
            answer
        }
    }
    let mut engine = Boundless(FeelerEngine::new(Options::default()));
    let report = gate(&mut engine, "contact-half-space");
    assert!(!report.passed());
    let row = row(&report);
    assert_eq!((row.wrong, row.unbounded), (0, row.queries));
}

/// A line's count of passages and its flag of cracks, where the truth says what they are.
#[test]
fn a_wrong_count_of_crossings_and_a_wrong_crack() {
    let counted = |truth: &Truth| {
        matches!(
            truth,
            Truth::Line {
                crossings: Some(_),
                ..
            }
        )
    };
    let flagged = |truth: &Truth| {
        matches!(
            truth,
            Truth::Line {
                in_crack: Some(_),
                ..
            }
        )
    };
    for suite in ["line", "line-grazing"] {
        for by in [1, 2] {
            // The same parity, too: 2 hits taken for one passage each that are one's.
            let mistake: crate::Mistake = match by {
                1 => |_, _, answer, _| with_line(answer, |crossings, _| *crossings += 1),
                _ => |_, _, answer, _| with_line(answer, |crossings, _| *crossings += 2),
            };
            let reasons = found_where(suite, "a wrong count of crossings", counted, mistake);
            assert!(
                reasons.iter().all(|r| r.contains("crossings")),
                "{reasons:?}"
            );
        }
        let reasons = found_where(suite, "a wrong crack", flagged, |_, _, answer, _| {
            with_line(answer, |_, in_crack| *in_crack = !*in_crack)
        });
        assert!(
            reasons.iter().all(|r| r.contains("in_crack")),
            "{reasons:?}"
        );
    }
}

/// The same answer to a line, its hits alone unchanged.
fn with_line(answer: &Answer, change: fn(&mut usize, &mut bool)) -> Option<Body> {
    let mut body = answer.body.clone();
    let Body::Line {
        crossings,
        in_crack,
        undecided: None,
        ..
    } = &mut body
    else {
        return None;
    };
    change(crossings.as_mut()?, in_crack.as_mut()?);
    Some(body)
}

/// A derivative root missed, one too many, one elsewhere, and a double one taken for a simple one.
#[test]
fn wrong_splits() {
    must_be_found("split", "a missed root", |_, _, answer, _| {
        with_split(answer, |axis| axis.roots.pop().map(|_| ()))
    });
    must_be_found("split", "a root too many", |_, _, answer, _| {
        with_split(answer, |axis| {
            let again = axis.roots.last()?.clone();
            axis.roots.push(again);
            Some(())
        })
    });
    must_be_found("split", "a root elsewhere", |_, _, answer, _| {
        with_split(answer, |axis| {
            // The next f64 above the proven enclosure.
            let t = &mut axis.roots.last_mut()?.t;
            let next = t.hi?.next_up();
            *t = Claim {
                value: next,
                lo: Some(next),
                hi: Some(next),
            };
            Some(())
        })
    });
    must_be_found("split", "a wrong multiplicity", |_, _, answer, _| {
        with_split(answer, |axis| {
            axis.roots.last_mut()?.multiplicity[0] += 2;
            Some(())
        })
    });
    must_be_found("split", "a turn that is none", |_, _, answer, _| {
        with_split(answer, |axis| {
            let root = axis.roots.last_mut()?;
            root.turns = !root.turns;
            Some(())
        })
    });
    must_be_found("split", "a constant part too many", |_, _, answer, _| {
        with_split(answer, |axis| {
            let t = axis.roots.last()?.t;
            axis.constant.push([t, t]);
            Some(())
        })
    });
}

/// The same answer to a split, with a change in the first axis that can suffer it.
fn with_split(
    answer: &Answer,
    change: fn(&mut feeler_corpus::AxisSplitLine) -> Option<()>,
) -> Option<Body> {
    let mut body = answer.body.clone();
    let Body::Split {
        u,
        v,
        undecided: None,
    } = &mut body
    else {
        return None;
    };
    change(u).or_else(|| change(v))?;
    Some(body)
}
