//! What an answer earned against the truth.
//!
//! Every comparison of a claim with the truth is exact: both are dyadic. Only sizes of errors, which
//! are reported and held against a suite's ceilings, are rounded.

mod contacts;

use crate::answer::{AxisSplitLine, Body, Claim, ContactLine, HitLine};
use crate::query::Hits;
use crate::truth::{AxisSplitTruth, HitTruth, Truth, TruthEnclosure};
pub use contacts::CONTINUUM_SLACK;
use contacts::{contacts_verdict, foot_verdict, normal_verdict, standing_verdict};
use feeler::numeric::Dyadic;
use feeler::query::{Accuracy, Probe};
use serde::{Deserialize, Serialize};

/// What an answer earned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The truth lies within every claim.
    Right,
    /// A claim and the truth are disjoint, or a count, side or flag differs.
    Wrong,
    /// The truth lies partly within the claim: it must be made narrower.
    Indeterminate,
    /// No claim is wrong, but the bound is wider than was asked, or there is none.
    Undecided,
}

/// In what an answer failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// A contact that is due was not reported: the one thing a physics engine cannot forgive.
    MissedContact,
    /// A contact was reported where there is none, or twice.
    FalseContact,
    /// Another side, or another sign of an overlap.
    Side,
    /// Another number of hits or crossings, or another kind of hit.
    Hits,
    /// A value whose claim does not hold the truth.
    Value,
    /// A face, edge or vertex, or parameters, that the point is not on.
    Place,
    /// A continuum that is told as one contact, or the other way round.
    Continuum,
    /// Another number or kind of derivative roots.
    Roots,
    /// The query was refused, or answered with something else.
    Refused,
}

/// A verdict, and how large the error was.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// What the answer earned.
    pub verdict: Verdict,
    /// Why, where it is not right.
    pub reason: Option<String>,
    /// In what it failed, where it is wrong.
    pub fault: Option<Fault>,
    /// Error of the value to use, in model units (of `t`, times the direction's length); absent for sides.
    pub error: Option<f64>,
    /// The same in units in the last place of the true value, never of less than the floor of full
    /// accuracy.
    pub ulps: Option<f64>,
    /// Largest error of a first derivative, relative to the largest derivative.
    pub derivative_error: Option<f64>,
    /// Whether a claim is infinite: nothing was proven.
    pub unbounded: bool,
}

/// What the judge needs to know of a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Width of the enclosure asked for.
    pub accuracy: Accuracy,
    /// Longest side of the model's box, in model units.
    pub size: f64,
    /// Report contacts with separation <= this.
    pub prediction: f64,
    /// Whether contacts were asked for.
    pub contacts: bool,
    /// Which hits were.
    pub hits: Hits,
    /// Length of a line's direction; 1 for other queries.
    pub scale: f64,
    /// A value without bounds of its own, as of an engine without certificates, is taken to claim that it is
    /// off by this at most, in model units.
    pub tolerance: f64,
    /// The sphere or half-space, which says where the normal of a known foot points; `None` of other queries.
    pub probe: Option<Probe>,
}

/// Full accuracy asks for no less than this fraction of the model's size.
const FLOOR: f64 = 1.0 / (1u128 << 96) as f64;

impl Asked {
    fn floor(&self) -> f64 {
        FLOOR * self.size
    }

    /// The widest enclosure of this separation that was asked for.
    fn widest(&self, lo: f64, hi: f64) -> f64 {
        match self.accuracy {
            Accuracy::Full => (2.0 * ulp(lo.abs().max(hi.abs()))).max(self.floor()),
            Accuracy::Length(a) => a,
        }
    }
}

/// The distance from |x| to the next larger f64.
pub fn ulp(x: f64) -> f64 {
    let x = x.abs();
    x.next_up() - x
}

impl Verdict {
    /// The worse, the more.
    fn rank(self) -> u8 {
        match self {
            Self::Wrong => 3,
            Self::Indeterminate => 2,
            Self::Undecided => 1,
            Self::Right => 0,
        }
    }
}

impl Judgement {
    fn new(verdict: Verdict, reason: impl Into<String>) -> Self {
        Self {
            verdict,
            reason: Some(reason.into()),
            fault: None,
            error: None,
            ulps: None,
            derivative_error: None,
            unbounded: false,
        }
    }

    /// A wrong answer.
    pub fn wrong(fault: Fault, reason: impl Into<String>) -> Self {
        Self {
            fault: Some(fault),
            ..Self::new(Verdict::Wrong, reason)
        }
    }

    fn right() -> Self {
        Self {
            reason: None,
            ..Self::new(Verdict::Right, "")
        }
    }

    /// Wrong beats indeterminate beats undecided beats right; errors are the larger ones.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        if other.verdict.rank() > self.verdict.rank() {
            self.verdict = other.verdict;
            self.reason = other.reason;
        }
        // Of several faults the gravest is named.
        self.fault = match (self.fault, other.fault) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        self.error = larger(self.error, other.error);
        self.ulps = larger(self.ulps, other.ulps);
        self.derivative_error = larger(self.derivative_error, other.derivative_error);
        self.unbounded |= other.unbounded;
        self
    }
}

fn larger(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.max(b)),
        _ => a.or(b),
    }
}

/// Holds an answer against the truth.
pub fn judge(asked: &Asked, answer: &Body, truth: &Truth) -> Judgement {
    let judgement = match (answer, truth) {
        (_, Truth::Unknown { why }) => {
            Judgement::new(Verdict::Indeterminate, format!("no truth: {why}"))
        }
        (Body::Error { error }, _) => Judgement::wrong(Fault::Refused, format!("refused: {error}")),
        (
            Body::Contact {
                separation,
                contacts,
                continuum,
                undecided,
            },
            Truth::Separation(truth),
        ) => {
            let judgement = contact_verdict(asked, separation, contacts, truth);
            match contacts.first() {
                Some(c) => {
                    judgement.and(standing_verdict(asked, c, truth, (*continuum, undecided)))
                }
                None => judgement,
            }
        }
        (
            Body::Contact {
                separation,
                contacts,
                continuum,
                undecided,
            },
            Truth::Contact {
                separation: truth,
                foot,
                contacts: all,
            },
        ) => {
            let mut judgement = contact_verdict(asked, separation, contacts, truth);
            if let (Some(deepest), Some(foot), false) =
                (contacts.first(), foot, *continuum == Some(true))
            {
                judgement = judgement
                    .and(foot_verdict(deepest, foot))
                    .and(normal_verdict(asked, deepest, truth, foot));
            }
            if let (true, Some(all)) = (asked.contacts, all) {
                judgement = judgement.and(contacts_verdict(asked, contacts, all, undecided));
            }
            // Last: what the truth tells of a foot says more.
            if let Some(deepest) = contacts.first() {
                judgement = judgement.and(standing_verdict(
                    asked,
                    deepest,
                    truth,
                    (*continuum, undecided),
                ));
            }
            judgement
        }
        (
            Body::Overlap {
                overlap: Some(overlap),
                ..
            },
            Truth::Separation(truth)
            | Truth::Contact {
                separation: truth, ..
            },
        ) => {
            let negative = truth.hi.signum() < 0;
            if !negative && truth.lo.signum() < 0 {
                Judgement::new(Verdict::Indeterminate, "the truth's sign is not certain")
            } else if *overlap == negative {
                Judgement::right()
            } else {
                Judgement::wrong(Fault::Side, format!("overlap is {negative}"))
            }
        }
        (
            Body::Side {
                side: Some(side),
                in_gap,
                ..
            },
            Truth::Side {
                side: true_side,
                in_gap: true_gap,
            },
        ) => {
            if side != true_side {
                Judgement::wrong(
                    Fault::Side,
                    format!("{side:?}, and the truth is {true_side:?}"),
                )
            } else if let Some(reason) = differ("in_gap", *in_gap, *true_gap) {
                Judgement::wrong(Fault::Side, reason)
            } else {
                Judgement::right()
            }
        }
        (
            Body::Line {
                hits,
                crossings,
                in_crack,
                undecided,
            },
            Truth::Line {
                hits: true_hits,
                crossings: true_crossings,
                in_crack: true_crack,
            },
        ) => {
            if let Some(why) = undecided {
                Judgement::new(Verdict::Undecided, why)
            } else {
                let mut all = match asked.hits {
                    Hits::All => hits_verdict(asked, hits, true_hits),
                    Hits::First | Hits::Any => one_hit_verdict(asked, hits, true_hits),
                };
                let differences = [
                    differ("crossings", *crossings, *true_crossings),
                    differ("in_crack", *in_crack, *true_crack),
                ];
                for reason in differences.into_iter().flatten() {
                    all = all.and(Judgement::wrong(Fault::Hits, reason));
                }
                all
            }
        }
        (
            Body::Evaluate {
                point,
                du,
                dv,
                bound,
            },
            Truth::Evaluate {
                point: true_point,
                du: true_du,
                dv: true_dv,
            },
        ) => {
            let mut all = point_verdict(asked, point, *bound, true_point);
            all.derivative_error = Some(derivative_error([du, dv], [true_du, true_dv]));
            all
        }
        (
            Body::Split {
                u,
                v,
                undecided: None,
            },
            Truth::Split {
                u: true_u,
                v: true_v,
            },
        ) => split_verdict("u", u, true_u).and(split_verdict("v", v, true_v)),
        (Body::Overlap { .. } | Body::Side { .. } | Body::Split { .. }, _)
            if answer.undecided().is_some() =>
        {
            Judgement::right()
        }
        _ => Judgement::wrong(Fault::Refused, "an answer to another question"),
    };
    match answer.undecided() {
        Some(why) => judgement.and(Judgement::new(Verdict::Undecided, why)),
        None => judgement,
    }
}

/// How a flag or a count differs from the truth, where both are given: what is left out is not claimed.
fn differ<T: PartialEq + std::fmt::Display>(
    what: &str,
    claim: Option<T>,
    truth: Option<T>,
) -> Option<String> {
    let (claim, truth) = (claim?, truth?);
    (claim != truth).then(|| format!("{what} is {claim}, and the truth is {truth}"))
}

/// NaN and infinity have no exact value; they are treated where they may occur.
fn exact(x: f64) -> Dyadic {
    Dyadic::from_f64(x).unwrap_or(Dyadic::ZERO)
}

/// The largest distance of `x` from a point of the truth, rounded.
fn distance(x: f64, truth: &TruthEnclosure) -> f64 {
    let x = exact(x);
    let below = (&x - &truth.lo).approximate().abs();
    let above = (&truth.hi - &x).approximate().abs();
    below.max(above)
}

enum Where {
    Within,
    Partly,
    Disjoint,
}

/// Where the truth lies relative to `[lo, hi]`; infinite ends are allowed.
fn locate(lo: f64, hi: f64, truth: &TruthEnclosure) -> Where {
    let above_lo = |x: &Dyadic| lo == f64::NEG_INFINITY || (lo.is_finite() && exact(lo) <= *x);
    let below_hi = |x: &Dyadic| hi == f64::INFINITY || (hi.is_finite() && *x <= exact(hi));
    if above_lo(&truth.lo) && below_hi(&truth.hi) {
        Where::Within
    } else if above_lo(&truth.hi) && below_hi(&truth.lo) {
        Where::Partly
    } else {
        Where::Disjoint
    }
}

/// Whether a claim holds, however wide it is. A value without bounds claims to be off by `tolerance` at most.
fn claim_verdict(claim: &Claim, truth: &TruthEnclosure, what: &str, tolerance: f64) -> Judgement {
    let (lo, hi) = (
        claim.lo.unwrap_or(claim.value - tolerance),
        claim.hi.unwrap_or(claim.value + tolerance),
    );
    // Also false where one is NaN.
    if !(lo <= claim.value && claim.value <= hi && claim.value.is_finite()) {
        let reason = format!("{what}: the value {} is not in [{lo}, {hi}]", claim.value);
        return Judgement::wrong(Fault::Value, reason);
    }
    let error = distance(claim.value, truth);
    let mut judgement = match locate(lo, hi, truth) {
        Where::Within => Judgement::right(),
        Where::Partly => Judgement::new(
            Verdict::Indeterminate,
            format!("{what}: the truth is not narrow enough to judge [{lo}, {hi}]"),
        ),
        Where::Disjoint => Judgement::wrong(
            Fault::Value,
            format!(
                "{what}: [{lo}, {hi}], and the truth is near {:e}; the value is off by {error:e}",
                truth.lo.approximate()
            ),
        ),
    };
    judgement.error = Some(error);
    judgement.unbounded = lo.is_infinite() || hi.is_infinite();
    judgement
}

fn separation_verdict(asked: &Asked, claim: &Claim, truth: &TruthEnclosure) -> Judgement {
    let mut judgement = claim_verdict(claim, truth, "separation", asked.tolerance);
    if let Some(error) = judgement.error {
        // Half the widest enclosure at full accuracy: 1 ulp, down to the floor.
        let unit = ulp(truth.lo.approximate()).max(0.5 * asked.floor());
        judgement.ulps = Some(error / unit);
    }
    if let (Some(lo), Some(hi)) = (claim.lo, claim.hi) {
        let width = hi - lo;
        let widest = asked.widest(lo, hi);
        if width > widest {
            let reason = format!("enclosure {width:.1e} wide, asked were {widest:.1e}");
            judgement = judgement.and(Judgement::new(Verdict::Undecided, reason));
        }
    }
    judgement
}

/// The separation, and that of the deepest contact.
fn contact_verdict(
    asked: &Asked,
    separation: &Claim,
    contacts: &[ContactLine],
    truth: &TruthEnclosure,
) -> Judgement {
    let mut all = separation_verdict(asked, separation, truth);
    let deepest = contacts.first().map(|c| c.separation);
    if let Some(deepest) = &deepest {
        let mut of_contact = claim_verdict(deepest, truth, "the deepest contact", asked.tolerance);
        // Its width is the contact's own affair: the separation's is what was asked.
        of_contact.error = None;
        all = all.and(of_contact);
    }
    if asked.contacts {
        let slack = match separation.lo {
            Some(_) => 0.0,
            None => asked.tolerance,
        };
        let settled = matches!(all.verdict, Verdict::Right | Verdict::Wrong);
        let touching = truth.hi <= exact(asked.prediction - slack);
        if touching && deepest.is_none() && settled {
            let reason = "no contact reported";
            all = all.and(Judgement::wrong(Fault::MissedContact, reason));
        }
        // An enclosure that holds both the truth and the prediction leaves the choice.
        let open =
            all.verdict != Verdict::Wrong && separation.lo.is_some_and(|lo| lo <= asked.prediction);
        let apart = truth.lo > exact(asked.prediction + slack);
        if apart && deepest.is_some() && !open {
            let reason = "a contact reported beyond the prediction";
            all = all.and(Judgement::wrong(Fault::FalseContact, reason));
        }
    }
    all
}

/// The one hit that was asked for, of all true ones in the order of t: the first, or any.
fn one_hit_verdict(asked: &Asked, claims: &[HitLine], truths: &[HitTruth]) -> Judgement {
    let [_] = claims else {
        let expected = truths.len().min(1);
        if claims.len() == expected {
            return Judgement::right();
        }
        let reason = format!(
            "{} hits for one, and the truth is {}",
            claims.len(),
            truths.len()
        );
        return Judgement::wrong(Fault::Hits, reason);
    };
    let first = truths.first();
    let is_first = |t: &HitTruth| first.is_some_and(|first| t.t.lo <= first.t.hi);
    truths
        .iter()
        .filter(|t| asked.hits == Hits::Any || is_first(t))
        .map(|t| hits_verdict(asked, claims, std::slice::from_ref(t)))
        .min_by_key(|own| own.verdict.rank())
        .unwrap_or_else(|| Judgement::wrong(Fault::Hits, "a hit, and the truth is none"))
}

/// Hits in the order of t. Two faces that meet at an edge may give one parameter or two; a claim must
/// have at least as many hits as there are distinct parameters, and at most as many as there are
/// true hits on faces. Hits that the truth does not tell apart by t are in no order: they are compared kind by kind.
fn hits_verdict(asked: &Asked, claims: &[HitLine], truths: &[HitTruth]) -> Judgement {
    let mut distinct: Vec<HitTruth> = Vec::new();
    for t in truths {
        match distinct.last_mut() {
            Some(last) if t.t.lo <= last.t.hi && last.t_end.is_none() && t.t_end.is_none() => {
                // What touches one of the faces and crosses another may be called either.
                last.tangential = last.tangential.filter(|_| last.tangential == t.tangential);
            }
            _ => distinct.push(t.clone()),
        }
    }
    let mut expected: Vec<&HitTruth> = if claims.len() == truths.len() {
        truths.iter().collect()
    } else if claims.len() == distinct.len() {
        distinct.iter().collect()
    } else {
        let reason = format!("{} hits, and the truth is {}", claims.len(), truths.len());
        return Judgement::wrong(Fault::Hits, reason);
    };
    let mut claims: Vec<&HitLine> = claims.iter().collect();
    let mut start = 0;
    for run in expected.chunk_by_mut(|a, b| b.t.lo <= a.t.hi) {
        let own = &mut claims[start..start + run.len()];
        pair_by_kind(own, run);
        start += run.len();
    }
    let tolerance = asked.tolerance / asked.scale;
    let mut all = Judgement::right();
    for (i, (claim, truth)) in claims.into_iter().zip(expected).enumerate() {
        let what = format!("hit {i}");
        all = all.and(claim_verdict(&claim.t, &truth.t, &what, tolerance));
        match (&claim.t_end, &truth.t_end) {
            (Some(claim), Some(truth)) => {
                all = all.and(claim_verdict(claim, truth, &what, tolerance))
            }
            (None, None) => {}
            _ => {
                let reason = format!("{what}: a point against a whole interval");
                all = all.and(Judgement::wrong(Fault::Hits, reason));
            }
        }
        if let Some(reason) = differ("tangential", claim.tangential, truth.tangential) {
            let reason = format!("{what}: {reason}");
            all = all.and(Judgement::wrong(Fault::Hits, reason));
        }
        let ends = claim.t_end.as_ref().zip(truth.t_end.as_ref());
        for (t, truth) in [(&claim.t, &truth.t)].into_iter().chain(ends) {
            // The value of t is used as a point: in ulp of the farther of it and the direction's length.
            let unit = ulp(truth.lo.approximate()).max(ulp(1.0));
            all.ulps = larger(all.ulps, Some(distance(t.value, truth) / unit));
        }
        if let (Some(lo), Some(hi)) = (claim.t.lo, claim.t.hi)
            && let Accuracy::Length(a) = asked.accuracy
            && (hi - lo) * asked.scale > a
        {
            let reason = format!("{what}: enclosure {:e} wide", (hi - lo) * asked.scale);
            all = all.and(Judgement::new(Verdict::Undecided, reason));
        }
    }
    all.error = all.error.map(|e| e * asked.scale);
    all
}

/// Brings hits that no parameter tells apart into an order in which points stand by points and, where there is a
/// way, no kind by another: each claimed kind takes the truths of that kind first, then those that say
/// nothing; claims that say nothing take what is left.
fn pair_by_kind(claims: &mut [&HitLine], truths: &mut [&HitTruth]) {
    claims.sort_by_key(|c| (c.t_end.is_some(), c.tangential.is_none()));
    for (i, claim) in claims.iter().enumerate() {
        let of_kind = |t: &&HitTruth, kind: Option<bool>| {
            t.t_end.is_some() == claim.t_end.is_some() && t.tangential == kind
        };
        let left = &truths[i..];
        let best = (left.iter().position(|t| of_kind(t, claim.tangential)))
            .or_else(|| left.iter().position(|t| of_kind(t, None)))
            .or_else(|| {
                left.iter()
                    .position(|t| t.t_end.is_some() == claim.t_end.is_some())
            });
        if let Some(best) = best {
            truths.swap(i, i + best);
        }
    }
}

/// The places one by one: count, order, multiplicities, turns, and each parameter within its claim.
fn split_verdict(axis: &str, claim: &AxisSplitLine, truth: &AxisSplitTruth) -> Judgement {
    let counts = [claim.roots.len(), claim.constant.len()];
    if counts != [truth.roots.len(), truth.constant.len()] {
        let reason = format!(
            "{axis}: {} roots and {} constant parts, and the truth is {} and {}",
            counts[0],
            counts[1],
            truth.roots.len(),
            truth.constant.len()
        );
        return Judgement::wrong(Fault::Roots, reason);
    }
    let mut all = Judgement::right();
    for (i, (claim, truth)) in claim.roots.iter().zip(&truth.roots).enumerate() {
        let what = format!("{axis}, root {i}");
        if (claim.multiplicity, claim.turns) != (truth.multiplicity, truth.turns) {
            let reason = format!(
                "{what}: multiplicity {:?}, turns: {}, and the truth is {:?}, {}",
                claim.multiplicity, claim.turns, truth.multiplicity, truth.turns
            );
            all = all.and(Judgement::wrong(Fault::Roots, reason));
        }
        let mut one = claim_verdict(&claim.t, &truth.t, &what, 0.0);
        // A parameter is no length; near 0 its ulp means nothing.
        one.error = None;
        all = all.and(one);
    }
    for (claim, truth) in claim.constant.iter().zip(&truth.constant) {
        for end in 0..2 {
            let mut one = claim_verdict(&claim[end], &truth[end], axis, 0.0);
            one.error = None;
            all = all.and(one);
        }
    }
    all
}

/// Each coordinate of the truth must lie within the claimed point +- bound, exactly.
fn point_verdict(
    asked: &Asked,
    point: &[f64; 3],
    bound: Option<f64>,
    truth: &[TruthEnclosure; 3],
) -> Judgement {
    let bound = bound.unwrap_or(asked.tolerance);
    if bound.is_nan() || bound < 0.0 || point.iter().any(|x| !x.is_finite()) {
        return Judgement::wrong(Fault::Value, "the point or its bound is not a number");
    }
    if bound.is_infinite() {
        let mut judgement = Judgement::new(Verdict::Undecided, "no bound");
        judgement.unbounded = true;
        return judgement;
    }
    let largest = point.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let mut all = Judgement::right();
    for (c, (x, truth)) in point.iter().zip(truth).enumerate() {
        let (lo, hi) = (&exact(*x) - &exact(bound), &exact(*x) + &exact(bound));
        let error = distance(*x, truth);
        let mut one = if lo <= truth.lo && truth.hi <= hi {
            Judgement::right()
        } else if truth.hi < lo || hi < truth.lo {
            let reason = format!("coordinate {c} is off by {error:e}, the bound is {bound:e}");
            Judgement::wrong(Fault::Value, reason)
        } else {
            Judgement::new(Verdict::Indeterminate, "the truth is not narrow enough")
        };
        one.error = Some(error);
        one.ulps = Some(error / ulp(largest.max(f64::MIN_POSITIVE)));
        all = all.and(one);
    }
    all
}

fn derivative_error(claims: [&[f64; 3]; 2], truths: [&[TruthEnclosure; 3]; 2]) -> f64 {
    let (mut error, mut largest) = (0.0f64, 0.0f64);
    for (claim, truth) in claims.into_iter().zip(truths) {
        for (x, t) in claim.iter().zip(truth) {
            let one = if x.is_finite() {
                distance(*x, t)
            } else {
                f64::INFINITY
            };
            error = error.max(one);
            largest = largest.max(t.lo.approximate().abs());
        }
    }
    if error == 0.0 { 0.0 } else { error / largest }
}

#[cfg(test)]
mod tests;
