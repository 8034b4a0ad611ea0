//! `cargo xtask truth --verify`: the stored truth against the second method.

use feeler::numeric::Dyadic;
use feeler::query::Probe;
use feeler::trim::Side;
use feeler_corpus::{
    Ask, CorpusQuery, HitTruth, MODELS, Model, Query, Truth, TruthEnclosure, suites,
};
use feeler_oracle::SideTruth;
use feeler_oracle::second::number::Number;
use feeler_oracle::second::{
    self, Bound, Second, SecondHit, SecondLine, SecondSide, TrimmedRegion,
};
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

#[derive(Debug, Clone, clap::Args)]
// It is part of `truth::Args`, whose group has the name that this one's would have.
#[group(skip)]
pub(crate) struct Args {
    /// Compute nothing: hold the stored truth against the second method, and stop where they disagree.
    #[arg(long, group = "timed")]
    pub(crate) verify: bool,
    /// With --verify: go on after a disagreement.
    #[arg(long, requires = "verify")]
    pub(crate) keep_going: bool,
}

/// Faces whose trims have more pieces than this are not given to the second method.
const MOST_PIECES: usize = 10_000;

/// What holding one truth against the second method gave.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Outcome {
    /// They agree; how wide the second enclosure is, relative to the model's size (0 for a side).
    Agrees(f64),
    /// The second method says nothing that the truth could contradict.
    Undecided(String),
    /// They cannot both be right.
    Disagrees(String),
    /// There is no second method for this yet.
    None,
}

/// A suite of witnesses, made when there is one.
pub(crate) const REGRESSIONS: &str = "regressions";

struct Job<'a> {
    suite: &'a str,
    path: &'a Path,
    query: CorpusQuery,
    truth: Truth,
}

struct Done {
    kind: &'static str,
    outcome: Outcome,
    time: Duration,
}

pub(crate) fn run(
    args: &Args,
    sample: Option<usize>,
    slow: Option<f64>,
    corpora: &Path,
    suite: Option<&str>,
) -> Result<(), String> {
    #[cfg(not(feature = "cgal"))]
    println!(
        "Without Eigen's eigenvalues and CGAL's critical points: for these too, `cargo run --release \
         -p xtask --features cgal -- truth --verify`."
    );
    let text = |e: feeler_corpus::CorpusError| e.to_string();
    let found = suites(corpora, suite).map_err(text)?;
    let mut jobs = Vec::new();
    for suite in &found {
        for file in &suite.files {
            let (queries, hash) = file.queries().map_err(text)?;
            let (_, truths) = file.truth(queries.len(), &hash).map_err(text)?;
            let step = sample.map_or(1, |n| (queries.len() / n.max(1)).max(1));
            let all = queries.into_iter().zip(truths).step_by(step);
            jobs.extend(all.map(|(query, truth)| Job {
                suite: &suite.name,
                path: &file.queries,
                query,
                truth,
            }));
        }
    }
    let mut models: BTreeMap<String, Model> = BTreeMap::new();
    for job in &jobs {
        if !models.contains_key(&job.query.model) {
            let path = corpora.join(MODELS).join(&job.query.model);
            let model = Model::load(&path, None).map_err(|e| e.to_string())?;
            models.insert(job.query.model.clone(), model);
        }
    }
    let bar = ProgressBar::new(jobs.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("verify {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    let next = AtomicUsize::new(0);
    let stop = AtomicBool::new(false);
    let done: Mutex<Vec<Done>> = Mutex::new(Vec::new());
    let witnesses: Mutex<Vec<(usize, String)>> = Mutex::new(Vec::new());
    let work = || {
        let mut checker: Option<(&str, Checker<'_>)> = None;
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let Some(job) = jobs.get(i) else { return };
            if stop.load(Ordering::Relaxed) {
                return;
            }
            let name = &job.query.model;
            if checker.as_ref().is_none_or(|(of, _)| of != name)
                && let Some(model) = models.get(name)
            {
                checker = Some((name, Checker::new(model)));
            }
            let Some((_, checker)) = &mut checker else {
                return;
            };
            let begun = Instant::now();
            let outcome = checker.held(&job.query.query, &job.truth);
            let time = begun.elapsed();
            if slow.is_some_and(|s| time.as_secs_f64() >= s) {
                let line = job.query.line.to_text();
                bar.suspend(|| println!("{:.1} s, {outcome:?}: {line}", time.as_secs_f64()));
            }
            if let Outcome::Disagrees(why) = &outcome {
                stop.store(!args.keep_going, Ordering::Relaxed);
                if let Ok(mut all) = witnesses.lock() {
                    all.push((i, why.clone()));
                }
            }
            if let Ok(mut all) = done.lock() {
                all.push(Done {
                    kind: kind(&job.query.query),
                    outcome,
                    time,
                });
            }
            bar.inc(1);
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(work);
        }
    });
    bar.finish_and_clear();
    table(&done.into_inner().unwrap_or_default());
    let mut witnesses = witnesses.into_inner().unwrap_or_default();
    witnesses.sort();
    for (i, why) in &witnesses {
        let job = &jobs[*i];
        println!(
            "{}:{} ({}): {why}\n  {}",
            job.path.display(),
            job.query.number,
            job.suite,
            job.query.line.to_text()
        );
        if job.suite != REGRESSIONS {
            keep(corpora, &job.query.line.to_text())?;
        }
    }
    match witnesses.len() {
        0 => Ok(()),
        n => Err(format!(
            "{n} truths that the second method contradicts; the queries are in {}/{REGRESSIONS}. \
             Find out which method is wrong, correct it, then `cargo xtask truth`",
            corpora.display()
        )),
    }
}

/// Adds a witness to the suite of regressions.
fn keep(corpora: &Path, line: &str) -> Result<(), String> {
    let folder = corpora.join(REGRESSIONS);
    let text = |e: std::io::Error| format!("{}: {e}", folder.display());
    fs::create_dir_all(&folder).map_err(text)?;
    let suite = folder.join("suite.json");
    if !suite.exists() {
        let content = "{\n  \"description\": \"queries on which two methods once disagreed\",\n  \
                       \"ceilings\": {}\n}\n";
        fs::write(&suite, content).map_err(text)?;
    }
    let path = folder.join("queries.jsonl");
    let old = fs::read_to_string(&path).unwrap_or_default();
    if old.lines().any(|l| l == line) {
        return Ok(());
    }
    let mut file = fs::OpenOptions::new()
        .create(true)
        .append(true)
        .open(&path)
        .map_err(text)?;
    writeln!(file, "{line}").map_err(text)
}

fn kind(query: &Query) -> &'static str {
    match query.ask {
        Ask::Contact(Probe::Sphere(_)) => "sphere",
        Ask::Contact(Probe::HalfSpace(_)) => "half_space",
        Ask::Arrival(..) => "arrival",
        Ask::Line(_) => "line",
        Ask::Side(..) => "side",
        Ask::Inside(_) => "inside",
        Ask::Evaluate(..) => "evaluate",
        Ask::Split(_) => "split",
    }
}

fn quantile(sorted: &[f64], q: f64) -> f64 {
    match sorted.len() {
        0 => f64::NAN,
        n => sorted[((n - 1) as f64 * q).round() as usize],
    }
}

fn table(done: &[Done]) {
    println!(
        "{:<12}{:>8}{:>8}{:>11}{:>10}{:>12}{:>12}{:>12}{:>11}{:>9}",
        "query",
        "checked",
        "agree",
        "undecided",
        "disagree",
        "width min",
        "median",
        "widest",
        "median ms",
        "p99 ms"
    );
    let mut kinds: BTreeMap<&str, Vec<&Done>> = BTreeMap::new();
    for d in done {
        kinds.entry(d.kind).or_default().push(d);
    }
    for (kind, all) in kinds {
        let count = |f: fn(&Outcome) -> bool| all.iter().filter(|d| f(&d.outcome)).count();
        let mut widths: Vec<f64> = all
            .iter()
            .filter_map(|d| match d.outcome {
                Outcome::Agrees(w) => Some(w),
                _ => None,
            })
            .collect();
        widths.sort_by(f64::total_cmp);
        let mut times: Vec<f64> = all.iter().map(|d| d.time.as_secs_f64() * 1e3).collect();
        times.sort_by(f64::total_cmp);
        println!(
            "{kind:<12}{:>8}{:>8}{:>11}{:>10}{:>12.1e}{:>12.1e}{:>12.1e}{:>11.1}{:>9.0}",
            all.len(),
            widths.len(),
            count(|o| matches!(o, Outcome::Undecided(_) | Outcome::None)),
            count(|o| matches!(o, Outcome::Disagrees(_))),
            quantile(&widths, 0.0),
            quantile(&widths, 0.5),
            quantile(&widths, 1.0),
            quantile(&times, 0.5),
            quantile(&times, 0.99),
        );
    }
}

/// A second enclosure against the true one.
fn overlap(truth: &TruthEnclosure, bound: &Bound, size: f64) -> Outcome {
    let below = bound.hi.as_ref().is_some_and(|hi| *hi < truth.lo);
    if below || truth.hi < bound.lo {
        return Outcome::Disagrees(format!(
            "the truth is near {:e}, the second method says [{:e}, {:e}]",
            truth.lo.approximate(),
            bound.lo.approximate(),
            bound.hi.as_ref().map_or(f64::INFINITY, Dyadic::approximate),
        ));
    }
    if bound.hi.is_none() {
        return Outcome::Undecided("no point proven to be on a face".to_owned());
    }
    Outcome::Agrees(bound.width() / size)
}

/// The second oracle of a model, with what is kept between queries.
pub(crate) struct Checker<'a> {
    second: Second<'a>,
    model: &'a Model,
    size: f64,
    regions: BTreeMap<usize, Result<TrimmedRegion, String>>,
}

impl<'a> Checker<'a> {
    pub(crate) fn new(model: &'a Model) -> Self {
        let breps: Vec<_> = model.breps.iter().collect();
        Self {
            second: Second::new(&breps),
            model,
            size: feeler_gate::model_size(model),
            regions: BTreeMap::new(),
        }
    }

    /// The exact side in uv, by Sturm chains; nothing of loops so large that exact arithmetic without an index takes minutes.
    fn side(&mut self, face: usize, uv: [f64; 2]) -> Result<SideTruth, String> {
        let region = self.regions.entry(face).or_insert_with(|| {
            let (brep, own) = self.model.face(face).ok_or("no such face")?;
            let curves = &self.model.breps[brep].parts().curves2;
            let pieces: usize = curves.iter().map(|c| c.breaks().len()).sum();
            if pieces > MOST_PIECES {
                return Err(format!("{pieces} pieces of trims"));
            }
            TrimmedRegion::new(&self.model.breps[brep], own).map_err(|e| e.to_string())
        });
        match region {
            Ok(region) => region.side(uv).map_err(|e| e.to_string()),
            Err(why) => Err(why.clone()),
        }
    }

    /// One truth against the second method, and, where they are few, against all critical points.
    pub(crate) fn held(&mut self, query: &Query, truth: &Truth) -> Outcome {
        let outcome = self.by_second(query, truth);
        match (query.ask, truth) {
            (
                Ask::Contact(Probe::Sphere(s)),
                Truth::Separation(truth)
                | Truth::Contact {
                    separation: truth, ..
                },
            ) if !matches!(outcome, Outcome::Disagrees(_)) => {
                match of_center(truth, s.radius).as_ref().map(without_sign) {
                    Some(d) => {
                        let center = s.center.coords.into();
                        crate::verify_critical::held(self.model, center, &d, outcome)
                    }
                    None => outcome,
                }
            }
            _ => outcome,
        }
    }

    fn by_second(&mut self, query: &Query, truth: &Truth) -> Outcome {
        match (query.ask, truth) {
            (Ask::Side(face, uv), Truth::Side { side, in_gap }) => {
                match self.side(face, uv.coords.into()) {
                    Err(why) => Outcome::Undecided(why),
                    Ok(found) if found.side != *side => {
                        Outcome::Disagrees(format!("truly {side:?}, second {:?}", found.side))
                    }
                    Ok(found) if in_gap.is_some_and(|g| g != found.in_gap) => {
                        Outcome::Disagrees(format!("in_gap is not {}", !found.in_gap))
                    }
                    Ok(_) => Outcome::Agrees(0.0),
                }
            }
            (Ask::Evaluate(face, uv), Truth::Evaluate { point, du, dv }) => {
                let breps: Vec<_> = self.model.breps.iter().collect();
                match second::evaluate(&breps, face, uv.coords.into()) {
                    Err(why) => Outcome::Undecided(why.to_string()),
                    Ok(found) => {
                        let pairs = [(&found.point, point), (&found.du, du), (&found.dv, dv)];
                        same_numbers(pairs, self.size)
                    }
                }
            }
            (Ask::Split(at), Truth::Split { u, v }) => {
                let breps: Vec<_> = self.model.breps.iter().collect();
                crate::verify_split::held(&breps, at, [u, v])
            }
            (
                Ask::Contact(probe),
                Truth::Contact {
                    contacts: Some(all),
                    ..
                },
            ) => {
                // Also where the separation is not known: the list is another truth.
                let separation = in_space(&self.second, self.size, query, truth);
                let breps = self.model.breps.len();
                let list = crate::verify_contacts::held(
                    &self.second,
                    breps,
                    self.size,
                    query,
                    &probe,
                    all,
                );
                match (separation, list) {
                    (Outcome::Disagrees(why), _) | (_, Outcome::Disagrees(why)) => {
                        Outcome::Disagrees(why)
                    }
                    (Outcome::Agrees(a), Outcome::Agrees(b)) => Outcome::Agrees(a.max(b)),
                    (Outcome::Agrees(_), other) | (other, _) => other,
                }
            }
            _ => in_space(&self.second, self.size, query, truth),
        }
    }
}

fn same_numbers(
    pairs: [(&[feeler_oracle::TruthEnclosure; 3], &[TruthEnclosure; 3]); 3],
    size: f64,
) -> Outcome {
    let mut width = 0.0f64;
    for (found, truth) in pairs {
        for (f, t) in found.iter().zip(truth) {
            if f.hi < t.lo || t.hi < f.lo {
                return Outcome::Disagrees(format!(
                    "a number is truly near {:e}, second {:e}",
                    t.lo.approximate(),
                    f.lo.approximate()
                ));
            }
            width = width.max(f.width().approximate());
        }
    }
    Outcome::Agrees(width / size)
}

/// The signed distance of a sphere's centre.
fn of_center(separation: &TruthEnclosure, radius: f64) -> Option<TruthEnclosure> {
    let r = Dyadic::from_f64(radius)?;
    Some(TruthEnclosure {
        lo: &separation.lo + &r,
        hi: &separation.hi + &r,
    })
}

fn without_sign(signed: &TruthEnclosure) -> TruthEnclosure {
    if signed.hi.signum() < 0 {
        TruthEnclosure {
            lo: -&signed.hi,
            hi: -&signed.lo,
        }
    } else {
        signed.clone()
    }
}

fn in_space(second: &Second<'_>, size: f64, query: &Query, truth: &Truth) -> Outcome {
    match (query.ask, truth) {
        (
            Ask::Contact(Probe::HalfSpace(h)),
            Truth::Separation(truth)
            | Truth::Contact {
                separation: truth, ..
            },
        ) => match second.half_space(h.normal.into(), h.offset) {
            Some(bound) => overlap(truth, &bound, size),
            None => Outcome::Disagrees("no face".to_owned()),
        },
        (
            Ask::Contact(Probe::Sphere(s)),
            Truth::Separation(truth)
            | Truth::Contact {
                separation: truth, ..
            },
        ) => {
            let Some(signed) = of_center(truth, s.radius) else {
                return Outcome::Undecided("no radius".to_owned());
            };
            let unsigned = without_sign(&signed);
            let (lo, hi) = (signed.lo, signed.hi);
            let center = s.center.coords.into();
            let outcome = match second.distance(center) {
                Some(bound) => overlap(&unsigned, &bound, size),
                None => Outcome::Disagrees("no face".to_owned()),
            };
            // The sign, unless the centre may be on a face.
            let truly = match (hi.signum() < 0, lo.signum() > 0) {
                (true, _) => Side::Inside,
                (_, true) => Side::Outside,
                _ => return outcome,
            };
            match (outcome, side(second, center, truly)) {
                (Outcome::Agrees(_), Outcome::Disagrees(why)) => Outcome::Disagrees(why),
                (Outcome::Agrees(_), Outcome::Undecided(why)) => Outcome::Undecided(why),
                (outcome, _) => outcome,
            }
        }
        (Ask::Inside(point), Truth::Side { side: truly, .. }) => {
            side(second, point.coords.into(), *truly)
        }
        (
            Ask::Line(l),
            Truth::Line {
                hits, crossings, ..
            },
        ) => {
            let found = second.line(l.origin.coords.into(), l.direction.into(), l.kind);
            line(&found, hits, *crossings, l.direction.norm() / size)
        }
        _ => Outcome::None,
    }
}

fn side(second: &Second<'_>, point: [f64; 3], truly: Side) -> Outcome {
    match (second.inside(point), truly) {
        (SecondSide::Inside, Side::Inside) | (SecondSide::Outside, Side::Outside) => {
            Outcome::Agrees(0.0)
        }
        (SecondSide::Undecided, _) => Outcome::Undecided("no rays that agree".to_owned()),
        (found, truly) => Outcome::Disagrees(format!("truly {truly:?}, second {found:?}")),
    }
}

/// Every true hit must be one of the second method's, or where that is open; and the other way round for those
/// that it is certain of.
fn line(found: &SecondLine, truths: &[HitTruth], crossings: Option<usize>, scale: f64) -> Outcome {
    let meets = |h: &SecondHit, truth: &HitTruth| {
        let Some((lo, hi)) = h.t.ends() else {
            return true;
        };
        let end = truth.t_end.as_ref().unwrap_or(&truth.t);
        h.face == truth.face && lo <= end.hi && truth.t.lo <= hi
    };
    let mut width = 0.0f64;
    for truth in truths {
        let open = found.open.iter().any(|(face, [lo, hi])| {
            let (a, b) = (truth.t.lo.approximate(), truth.t.hi.approximate());
            *face == truth.face && *lo <= b && a <= *hi
        });
        match found.hits.iter().find(|h| meets(h, truth)) {
            Some(h) => width = width.max(2.0 * h.t.radius() * scale),
            None if open => {}
            None => {
                let t = truth.t.lo.approximate();
                let reason = format!("the hit with face {} at t = {t:e} is none", truth.face);
                return Outcome::Disagrees(reason);
            }
        }
    }
    for h in found.hits.iter().filter(|h| h.certain) {
        if !truths.iter().any(|t| meets(h, t)) {
            let t = h.t.lo();
            let reason = format!("face {} is hit at t = {t:e}, uv {:?}", h.face, h.uv);
            return Outcome::Disagrees(reason);
        }
    }
    let settled = found.open.is_empty() && found.hits.iter().all(|h| h.certain && h.clear);
    if let Some(n) = crossings
        && settled
        && n != found.hits.len()
    {
        let reason = format!(
            "{n} crossings, and the second method has {}",
            found.hits.len()
        );
        return Outcome::Disagrees(reason);
    }
    if found.open.is_empty() {
        Outcome::Agrees(width)
    } else {
        Outcome::Undecided("open parts of the line".to_owned())
    }
}

#[cfg(test)]
mod tests;
