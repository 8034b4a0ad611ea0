//! Answers held against exact arithmetic.

mod arrival;
mod line;
mod refute;

use crate::scene::Scene;
use feeler::brep::Brep;
use feeler::numeric::Dyadic;
use feeler::nurbs::{Curve, Surface, SurfacePoint};
use feeler::prepare::PreparedBrep;
use feeler::query::{self, Accuracy, Contacts, Options, Probe, Workspace};
use feeler_corpus::{
    Ask, Asked, AxisSplitTruth, Body, Hits, Query, SplitRootTruth, Truth, TruthEnclosure, Verdict,
    judge,
};
use feeler_oracle::second::{self, Second, TrimmedRegion};
use feeler_oracle::{AxisRootsTruth, OracleError, SideTruth};

/// How much is asked of the second method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// What is quick: exact sides (by halving Bernstein forms, as the kernel and the oracle decide them), evaluations, roots; exact points against separations.
    Loop,
    /// Separations, hits and sides in space too, and sides of curves up to degree [`CHAINED`] by Sturm chains, which share nothing with the kernel: milliseconds to a
    /// second a query.
    Full,
}

/// What is wrong, in words; `Ok` where nothing was found.
pub(crate) type Found = Result<(), String>;

/// How many nodes a query may cost here: enough for most; for the others an answer with what bound there is, which must hold too.
const NODES: usize = 1000;

/// Degrees up to this are given all the boxes of the second method; of higher ones, fewer by the square of what they are more.
const CHEAP: usize = 5;

/// Curves up to this degree are given to Sturm chains, whose coefficients grow with the square of the degree: at 25 a side can take half a minute.
const CHAINED: usize = 12;

/// How many boxes the second method may look at for a distance to this BREP, and whether these are fewer than it has by itself.
fn boxes(brep: &Brep) -> ([usize; 2], bool) {
    let parts = brep.parts();
    let surfaces = parts.surfaces.iter().map(|s| match s {
        Surface::Nurbs(s) => s.knots_u().degree().max(s.knots_v().degree()),
        Surface::Revolution(s) => highest(&s.profile),
        Surface::Sum(s) => highest(&s.first).max(highest(&s.second)),
        Surface::Plane(_) => 1,
    });
    let curves = parts.curves2.iter().map(highest);
    let degree = surfaces.chain(curves).max().unwrap_or(1).max(CHEAP);
    // At degree 25 a box costs milliseconds in balls.
    let fewer = |n: usize| (n * CHEAP * CHEAP / (degree * degree)).max(1);
    (second::BUDGET.map(fewer), degree > CHEAP)
}

/// What the second method can say of the distances and heights that a scene asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Distances {
    /// How many it asks for; arrivals are not counted.
    pub asked: usize,
    /// Of these, those whose bounds have no upper end or are wider than a thousandth of the BREP: hardly a claim would contradict them.
    pub wide: usize,
    /// Of all, those with fewer boxes than the second method has by itself, as of too high a degree.
    pub fewer: usize,
}

pub(crate) fn distances(scene: &Scene) -> Distances {
    const WIDE: f64 = 1e-3;
    let mut told = Distances::default();
    let second = second_of(&scene.brep);
    let size = PreparedBrep::new(scene.brep.clone()).size();
    for line in &scene.queries {
        let bound = match line.query().map(|q| q.ask) {
            Ok(Ask::Contact(Probe::Sphere(s))) => second.distance(s.center.coords.into()),
            Ok(Ask::Contact(Probe::HalfSpace(h))) => second.half_space(h.normal.into(), h.offset),
            _ => continue,
        };
        told.asked += 1;
        told.wide += usize::from(!bound.is_some_and(|b| b.width() <= WIDE * size));
    }
    if boxes(&scene.brep).1 {
        told.fewer = told.asked;
    }
    told
}

fn highest<const D: usize, const H: usize>(curve: &Curve<D, H>) -> usize {
    match curve {
        Curve::Nurbs(c) => c.degree(),
        // Not nested: taken apart when it was made.
        Curve::Poly(p) => p
            .segments()
            .iter()
            .map(|c| match c {
                Curve::Nurbs(c) => c.degree(),
                _ => 1,
            })
            .max()
            .unwrap_or(1),
        _ => 1,
    }
}

/// The second method on a scene, within the budget of the loop.
pub(crate) fn second_of(brep: &Brep) -> Second<'_> {
    Second::new(&[brep]).with_budget(boxes(brep).0)
}

fn options(query: &Query) -> Options {
    Options {
        accuracy: query.accuracy.unwrap_or(Accuracy::Full),
        prediction: query.prediction.unwrap_or(0.0),
        contacts: query.contacts.unwrap_or(Contacts::Deepest),
        node_budget: NODES,
    }
}

/// The kernel's answer to a query about one BREP.
pub fn answer(brep: &PreparedBrep, query: &Query, workspace: &mut Workspace) -> Body {
    let none = |what: &str| Body::Error {
        error: format!("there is no such {what}"),
    };
    let options = options(query);
    match query.ask {
        Ask::Contact(probe) if query.overlap => {
            let found = query::overlap(brep, &probe, &options, workspace);
            Body::Overlap {
                overlap: found.overlap,
                undecided: found.undecided.map(|u| u.to_string()),
            }
        }
        Ask::Contact(probe) => (&query::contact(brep, &probe, &options, workspace)).into(),
        Ask::Line(l) if query.hits != Hits::All => {
            let found = query::any_hit(brep, &l, &options, workspace);
            Body::Line {
                hits: found.hit.iter().map(Into::into).collect(),
                crossings: None,
                in_crack: None,
                undecided: found.undecided.map(|u| u.to_string()),
            }
        }
        Ask::Arrival(probe, motion) => {
            (&query::arrival(brep, &probe, &motion, &options, workspace)).into()
        }
        Ask::Line(l) => (&query::line(brep, &l, &options, workspace)).into(),
        Ask::Side(face, uv) => match query::side(brep, face, uv) {
            Some(found) => found.into(),
            None => none("face"),
        },
        Ask::Inside(p) => query::inside(brep, p, workspace).into(),
        Ask::Evaluate(face, uv) => match query::evaluate(brep, face, uv) {
            Some(found) => found.into(),
            None => none("face"),
        },
        Ask::Split(at) => match query::split(brep, at.face, at.trim_loop, at.trim) {
            Some(found) => found.into(),
            None => none("trim"),
        },
    }
}

/// A BREP, prepared, with what exact checks of its faces take.
pub(crate) struct Subject<'a> {
    scene: &'a Scene,
    prepared: PreparedBrep,
    /// The regions of the faces, exactly; made when one is asked about.
    regions: Vec<Option<Result<TrimmedRegion, OracleError>>>,
    workspace: Workspace,
}

impl<'a> Subject<'a> {
    fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            prepared: PreparedBrep::new(scene.brep.clone()),
            regions: scene.brep.faces().iter().map(|_| None).collect(),
            workspace: Workspace::default(),
        }
    }

    /// The exact side of a point of a face; none where the second method has none.
    fn side(&mut self, face: usize, uv: [f64; 2], effort: Effort) -> Option<SideTruth> {
        let brep = &self.scene.brep;
        let region = self
            .regions
            .get_mut(face)?
            .get_or_insert_with(|| TrimmedRegion::new(brep, face));
        let region = region.as_ref().ok()?;
        let curves = &brep.parts().curves2;
        if effort == Effort::Full && curves.iter().all(|c| highest(c) <= CHAINED) {
            region.side(uv).ok()
        } else {
            region.side_by_halving(uv).ok()
        }
    }
}

/// Holds the answers to all queries of a scene against what can be known of them: the number of the first that is wrong, and why.
///
/// # Errors
/// What was found.
pub fn examine(scene: &Scene, effort: Effort) -> Result<(), (usize, String)> {
    let mut subject = Subject::new(scene);
    for (i, line) in scene.queries.iter().enumerate() {
        // Checked when the scene was made.
        let Ok(query) = line.query() else { continue };
        one(&mut subject, &query, effort).map_err(|why| (i, why))?;
    }
    Ok(())
}

fn one(subject: &mut Subject<'_>, query: &Query, effort: Effort) -> Found {
    match query.ask {
        Ask::Contact(probe) => refute::contact(subject, query, &probe, effort),
        Ask::Line(probe) => line::line(subject, query, &probe, effort),
        Ask::Arrival(probe, motion) => arrival::arrival(subject, query, &probe, &motion, effort),
        Ask::Inside(point) => {
            let body = answer(&subject.prepared, query, &mut subject.workspace);
            if effort == Effort::Full
                && let Body::Side {
                    side: Some(side), ..
                } = body
            {
                let second = second_of(&subject.scene.brep);
                agree_in_space(&second, point.coords.into(), side)?;
            }
            Ok(())
        }
        Ask::Side(..) | Ask::Evaluate(..) | Ask::Split(..) => exact(subject, query, effort),
    }
}

/// A side in space against the second method's.
pub(crate) fn agree_in_space(
    second: &Second<'_>,
    point: [f64; 3],
    side: feeler::trim::Side,
) -> Found {
    use feeler::trim::Side;
    use second::SecondSide;
    match (second.inside(point), side) {
        (SecondSide::Inside, Side::Outside) | (SecondSide::Outside, Side::Inside) => {
            Err(format!("in space {side:?}, which it is not"))
        }
        _ => Ok(()),
    }
}

/// Against an exact truth of the second method, as the gate judges.
fn exact(subject: &mut Subject<'_>, query: &Query, effort: Effort) -> Found {
    let body = answer(&subject.prepared, query, &mut subject.workspace);
    if matches!(body, Body::Error { .. }) {
        // Of text that asks for what is not there.
        return Ok(());
    }
    let Some(truth) = exact_truth(subject, query, effort) else {
        return Ok(());
    };
    let asked = Asked {
        accuracy: query.accuracy.unwrap_or(Accuracy::Full),
        size: subject.prepared.size(),
        prediction: query.prediction.unwrap_or(0.0),
        contacts: false,
        hits: query.hits,
        scale: 1.0,
        tolerance: 0.0,
        probe: None,
    };
    let mut found = judge(&asked, &body, &truth);
    if let (
        Ask::Side(face, _),
        Body::Side {
            in_gap: claimed, ..
        },
        Truth::Side {
            side,
            in_gap: Some(false),
        },
    ) = (query.ask, &body, &truth)
        && claimed.is_some_and(|g| g)
        && has_arcs(subject, face)
    {
        // Next to the ends of arcs, which are no f64, it errs on this side; and the rest of the answer counts.
        let truth = Truth::Side {
            side: *side,
            in_gap: None,
        };
        found = judge(&asked, &body, &truth);
    }
    if matches!(found.verdict, Verdict::Wrong | Verdict::Indeterminate) {
        return Err(found.reason.unwrap_or_default());
    }
    match query.ask {
        Ask::Side(face, _) if found.verdict == Verdict::Undecided && !has_arcs(subject, face) => {
            Err("undecided, on a face without arcs".to_owned())
        }
        Ask::Evaluate(face, uv) => match (query::evaluate(&subject.prepared, face, uv), &truth) {
            (Some(found), Truth::Evaluate { du, dv, .. }) => derivatives(&found, du, dv),
            _ => Ok(()),
        },
        _ => Ok(()),
    }
}

/// Next to the ends of native arcs alone a side may be undecided.
fn has_arcs(subject: &Subject<'_>, face: usize) -> bool {
    let parts = subject.scene.brep.parts();
    let loops = subject.scene.brep.faces()[face].loops.iter().flatten();
    let mut trims = loops.flat_map(|l| &parts.loops[*l].trims);
    trims.any(|t| match &parts.curves2[parts.trims[*t].curve] {
        Curve::Arc(_) => true,
        Curve::Poly(p) => p.segments().iter().any(|c| matches!(c, Curve::Arc(_))),
        _ => false,
    })
}

fn corpus(e: &feeler_oracle::TruthEnclosure) -> TruthEnclosure {
    TruthEnclosure {
        lo: e.lo.clone(),
        hi: e.hi.clone(),
    }
}

fn exact_truth(subject: &mut Subject<'_>, query: &Query, effort: Effort) -> Option<Truth> {
    let brep = &subject.scene.brep;
    match query.ask {
        Ask::Side(face, uv) => {
            let found = subject.side(face, uv.coords.into(), effort)?;
            Some(Truth::Side {
                side: found.side,
                in_gap: Some(found.in_gap),
            })
        }
        Ask::Evaluate(face, uv) => {
            let domain = brep.surface(face).domain();
            let at = [0, 1].map(|i| uv[i].clamp(domain[i].start, domain[i].end));
            let found = second::evaluate(&[brep], face, at).ok()?;
            let [point, du, dv] =
                [&found.point, &found.du, &found.dv].map(|v| v.each_ref().map(corpus));
            Some(Truth::Evaluate { point, du, dv })
        }
        Ask::Split(at) => {
            let found = second::derivative_roots(&[brep], at.face, at.trim_loop, at.trim).ok()?;
            let [u, v] = found.axes.each_ref().map(split_truth);
            Some(Truth::Split { u, v })
        }
        _ => None,
    }
}

fn split_truth(axis: &AxisRootsTruth) -> AxisSplitTruth {
    AxisSplitTruth {
        roots: axis
            .roots
            .iter()
            .map(|r| SplitRootTruth {
                t: corpus(&r.t),
                multiplicity: r.multiplicity,
                turns: r.turns(),
            })
            .collect(),
        constant: axis
            .constant
            .iter()
            .map(|c| c.each_ref().map(corpus))
            .collect(),
    }
}

/// The bounds of first derivatives hold the truth.
fn derivatives(found: &SurfacePoint, du: &[TruthEnclosure; 3], dv: &[TruthEnclosure; 3]) -> Found {
    let all = [
        ("du", &found.du, found.du_bound, du),
        ("dv", &found.dv, found.dv_bound, dv),
    ];
    for (what, claim, bound, truth) in all {
        for i in 0..3 {
            let (Some(x), Some(b)) = (Dyadic::from_f64(claim[i]), Dyadic::from_f64(bound)) else {
                continue;
            };
            if &x + &b < truth[i].lo || truth[i].hi < &x - &b {
                return Err(format!(
                    "{what}[{i}] is {:e} within {bound:e}, and the truth is {:e}",
                    claim[i],
                    truth[i].lo.approximate()
                ));
            }
        }
    }
    Ok(())
}

/// A ball or half-space as the refuter sees it.
pub(crate) fn radius(probe: &Probe) -> f64 {
    match probe {
        Probe::Sphere(s) => s.radius,
        Probe::HalfSpace(_) => 0.0,
    }
}
