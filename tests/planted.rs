//! A gate that cannot fail is worthless: mistakes planted on purpose, each of which it must find.
//!
//! Mistakes in answers are put into one answer of a suite alone, those of all others being the kernel's: the
//! gate must fail, and name that query. Mistakes in the model (what a mistake in the code that reads or
//! evaluates it amounts to) make every query of the model suffer.

use feeler::brep::{Brep, BrepParts};
use feeler::nurbs::{NurbsSurface, Surface};
use feeler::query::Options;
use feeler::trim::Side;
use feeler_corpus::{Answer, Ask, Body, Claim, CorpusQuery, Model, Query, suites};
use feeler_gate::{Engine, FeelerEngine, Gate, Report, Row, run};
use std::path::{Path, PathBuf};

/// The error that the gate must find in a depth, in model units (mm).
const DEPTH_ERROR: f64 = 1e-9;
/// How near to a trim, in uv, the flipped sides are.
const NEAR: f64 = 1e-6;

fn corpus() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap().join("corpora")
}

fn gate(engine: &mut dyn Engine, suite: &str) -> Report {
    let gate = Gate {
        corpus: &corpus(),
        suite: Some(suite),
        tolerance: 0.0,
    };
    run(engine, &gate, &mut |_| {}).unwrap()
}

fn row(report: &Report) -> &Row {
    assert_eq!(report.suites.len(), 1);
    &report.suites[0]
}

/// The kernel, as the gate runs it; what it answered is kept.
#[derive(Default)]
struct Recording {
    engine: FeelerEngine,
    answers: Vec<Answer>,
}

impl Engine for Recording {
    fn name(&self) -> String {
        self.engine.name()
    }

    fn open(&mut self, model: &Model) -> Result<(), String> {
        self.engine.open(model)
    }

    fn answer(&mut self, query: &Query) -> Answer {
        let answer = self.engine.answer(query);
        self.answers.push(answer.clone());
        answer
    }
}

/// Gives those answers again, one of them with a mistake. What a mistake makes of an answer, `None` where it
/// changes nothing: of the kernel about the model, the query, its answer and the one before.
type Mistake = fn(&mut FeelerEngine, &Query, &Answer, Option<&Answer>) -> Option<Body>;

struct Planted {
    engine: FeelerEngine,
    model: PathBuf,
    answers: Vec<Answer>,
    at: usize,
    /// Queries whose answers are right without a mistake, with their models.
    right: Vec<CorpusQuery>,
    mistake: Mistake,
    /// How many answers that could suffer are let pass first.
    skip: usize,
    /// The model and the query whose answer got the mistake.
    planted: Option<(PathBuf, Query)>,
}

impl Engine for Planted {
    fn name(&self) -> String {
        "planted".to_owned()
    }

    fn open(&mut self, model: &Model) -> Result<(), String> {
        self.model = model.path.clone();
        self.engine.open(model)
    }

    fn answer(&mut self, query: &Query) -> Answer {
        let before = self.at.checked_sub(1).and_then(|i| self.answers.get(i));
        let mut answer = self.answers[self.at].clone();
        let same = |q: &CorpusQuery| q.query == *query && self.model.ends_with(&q.model);
        if self.planted.is_none()
            && self.right.iter().any(same)
            && let Some(body) = (self.mistake)(&mut self.engine, query, &answer, before)
        {
            if self.skip == 0 {
                answer.body = body;
                self.planted = Some((self.model.clone(), query.clone()));
            } else {
                self.skip -= 1;
            }
        }
        self.at += 1;
        answer
    }
}

/// The queries of a suite, with the places that the gate names them by.
fn queries(suite: &str) -> Vec<(String, CorpusQuery)> {
    let mut all = Vec::new();
    for suite in suites(&corpus(), Some(suite)).unwrap() {
        for file in &suite.files {
            let place = |n: usize| format!("{}:{n}", file.queries.display());
            let (queries, _) = file.queries().unwrap();
            all.extend(queries.into_iter().map(|q| (place(q.number), q)));
        }
    }
    all
}

/// One answer of a suite gets a mistake, once early in the suite and once far into it: each time the
/// gate must fail with one wrong answer more than without it, and name the query.
fn must_be_found(suite: &str, what: &str, mistake: Mistake) {
    let mut recording = Recording::default();
    let unplanted = gate(&mut recording, suite);
    let unplanted = row(&unplanted);
    let fell = |place: &String| unplanted.failures.iter().any(|f| f.place == *place);
    let queries = queries(suite);
    let right = queries.iter().filter(|(place, _)| !fell(place));
    let right: Vec<CorpusQuery> = right.map(|(_, q)| q.clone()).collect();
    let wrong = unplanted.wrong;
    for skip in [0, 17] {
        let mut engine = Planted {
            engine: FeelerEngine::new(Options::default()),
            model: PathBuf::new(),
            answers: recording.answers.clone(),
            at: 0,
            right: right.clone(),
            mistake,
            skip,
            planted: None,
        };
        let report = gate(&mut engine, suite);
        let (model, query) = engine
            .planted
            .unwrap_or_else(|| panic!("{suite}: no answer for {what}"));
        assert!(!report.passed(), "{suite}: the gate let pass {what}");
        let row = row(&report);
        assert_eq!(
            row.wrong,
            wrong + 1,
            "{suite}: {what}: {}",
            report.shortfalls()
        );
        let same = |q: &CorpusQuery| q.query == query && model.ends_with(&q.model);
        let places = queries.iter().filter(|(_, q)| same(q));
        let places: Vec<&String> = places.map(|(place, _)| place).collect();
        let named = row
            .failures
            .iter()
            .find(|f| f.verdict == "wrong" && places.contains(&&f.place))
            .unwrap_or_else(|| panic!("{suite}: {what}: {places:?} is not named"));
        assert!(named.command.contains("contact"), "{}", named.command);
        println!("{suite}: {what}: {}: {}", named.place, named.reason);
    }
}

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

#[test]
fn unplanted_suites_pass() {
    for suite in ["evaluate", "side", "contact-half-space"] {
        let report = gate(&mut FeelerEngine::new(Options::default()), suite);
        assert!(report.passed(), "{}", report.shortfalls());
        assert!(row(&report).queries > 100);
    }
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

/// The kernel on models with a mistake in them. The gate itself reads the models as they are.
struct OnChanged {
    engine: FeelerEngine,
    change: fn(&mut BrepParts) -> usize,
    changes: usize,
}

impl Engine for OnChanged {
    fn name(&self) -> String {
        "changed".to_owned()
    }

    fn open(&mut self, model: &Model) -> Result<(), String> {
        let mut changed = model.clone();
        for brep in &mut changed.breps {
            let mut parts = brep.parts().clone();
            self.changes += (self.change)(&mut parts);
            *brep = Brep::new(parts).map_err(|e| e.to_string())?;
        }
        self.engine.open(&changed)
    }

    fn answer(&mut self, query: &Query) -> Answer {
        self.engine.answer(query)
    }
}

fn must_fail_on_changed(suite: &str, what: &str, change: fn(&mut BrepParts) -> usize) {
    let unplanted = gate(&mut FeelerEngine::new(Options::default()), suite);
    let mut engine = OnChanged {
        engine: FeelerEngine::new(Options::default()),
        change,
        changes: 0,
    };
    let report = gate(&mut engine, suite);
    assert!(engine.changes > 0, "{suite}: no model for {what}");
    assert!(!report.passed(), "{suite}: the gate let pass {what}");
    let (before, after) = (row(&unplanted).wrong, row(&report));
    assert!(
        after.wrong > before,
        "{suite}: {what}: {before} wrong before and {} after",
        after.wrong
    );
    let first = &after.failures[0];
    assert_eq!(first.verdict, "wrong");
    assert!(first.place.contains(suite), "{}", first.place);
    println!(
        "{suite}: {what}: {} wrong, first {}: {}",
        after.wrong, first.place, first.reason
    );
}

/// Control points gathered for the span before the right one, along u, wherever there is one before.
fn span_off_by_one(parts: &mut BrepParts) -> usize {
    let mut changes = 0;
    for surface in &mut parts.surfaces {
        let Surface::Nurbs(s) = surface else { continue };
        let (ku, kv) = (s.knots_u(), s.knots_v());
        let [rows, columns] = s.counts();
        if rows == ku.degree() + 1 {
            continue;
        }
        let mut net = s.control_net()[..columns].to_vec();
        net.extend_from_slice(&s.control_net()[..(rows - 1) * columns]);
        let degrees = [ku.degree(), kv.degree()];
        let knots = [ku.knots().to_vec(), kv.knots().to_vec()];
        *s = NurbsSurface::new(degrees, [rows, columns], net, knots).unwrap();
        changes += 1;
    }
    changes
}

#[test]
fn an_off_by_one_span() {
    for suite in ["evaluate", "contact-half-space", "thesis"] {
        must_fail_on_changed(suite, "an off-by-one span", span_off_by_one);
    }
}

#[test]
fn a_dropped_trim_loop() {
    fn drop_last_loop(parts: &mut BrepParts) -> usize {
        let mut changes = 0;
        for face in &mut parts.faces {
            if let Some(loops) = &mut face.loops
                && loops.len() > 1
            {
                loops.pop();
                changes += 1;
            }
        }
        changes
    }
    for suite in ["side", "contact-sphere"] {
        must_fail_on_changed(suite, "a dropped inner loop", drop_last_loop);
    }
}

/// Every face is its whole surface.
#[test]
fn a_face_without_its_trims() {
    fn untrim(parts: &mut BrepParts) -> usize {
        parts.faces.iter_mut().for_each(|f| f.loops = None);
        parts.faces.len()
    }
    for suite in ["side", "contact-half-space"] {
        must_fail_on_changed(suite, "faces without their trims", untrim);
    }
}
