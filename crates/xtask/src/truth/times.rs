//! `cargo xtask truth --times`: how long the oracle's functions take on the corpora, and how wide their truths are.
//!
//! Times are those of the processor for the thread, so that other work on the machine counts little. What queries share is
//! made, and timed, before the first that needs it (`Oracle::prepare`). Parts of many faces, of which there are few, are
//! asked some queries more.

use super::Args;
use super::check::sample;
use super::parallel::in_parallel;
use super::with_oracle::{Loaded, load, oracle_of};
use feeler::query::{Contacts, Probe};
use feeler_corpus::{Ask, CorpusQuery, Query, suites};
use feeler_oracle::{Oracle, OracleError, Shared, TruthEnclosure};
use rustix::time::{ClockId, clock_gettime};
use std::collections::BTreeMap;
use std::path::Path;

/// Queries of each suite.
const SAMPLE: usize = 20;
/// A part with at least so many faces is a large one.
const LARGE: usize = 40;

/// One call of a function.
struct Call {
    function: &'static str,
    milliseconds: f64,
    faces: usize,
    /// Of what the goal speaks of, relative to the model's size; `None` where nothing has a width.
    width: Option<f64>,
}

/// Milliseconds of processor time that this thread has had.
fn clock() -> f64 {
    let t = clock_gettime(ClockId::ThreadCPUTime);
    t.tv_sec as f64 * 1e3 + t.tv_nsec as f64 * 1e-6
}

fn widest<'a>(all: impl IntoIterator<Item = &'a TruthEnclosure>, unit: f64) -> Option<f64> {
    let widths = all.into_iter().map(|e| e.width().approximate() / unit);
    widths.reduce(f64::max)
}

/// What the query shares with others, and what making it is called.
fn shared(query: &Query, closed: bool) -> Option<(Shared, &'static str)> {
    const PIECES: (Shared, &str) = (Shared::Pieces, "prepare a model's pieces");
    const EDGES: (Shared, &str) = (Shared::Edges, "prepare pieces and edges");
    match query.ask {
        Ask::Contact(_) if query.contacts == Some(Contacts::All) => Some(EDGES),
        // The sign of a distance takes the edges.
        Ask::Contact(Probe::Sphere(_)) if closed => Some(EDGES),
        Ask::Contact(_) => Some(PIECES),
        Ask::Line(_) | Ask::Inside(_) => Some(EDGES),
        Ask::Side(face, _) | Ask::Evaluate(face, _) => {
            Some((Shared::Face(face), "prepare a face in uv"))
        }
        Ask::Split(_) | Ask::Arrival(..) => None,
    }
}

/// Calls the functions of which the query's truth is made. `made` is what was prepared before.
fn calls(
    oracle: &Oracle,
    query: &Query,
    loaded: &Loaded,
    made: &mut Vec<Shared>,
) -> Result<Vec<Call>, OracleError> {
    let mut out = Vec::new();
    let faces = oracle.faces();
    let size = loaded.size;
    let closed = loaded.model.breps.iter().any(|b| b.is_closed());
    if let Some((what, name)) = shared(query, closed).filter(|(w, _)| !made.contains(w)) {
        let begun = clock();
        oracle.prepare(what)?;
        made.push(what);
        out.push(Call {
            function: name,
            milliseconds: clock() - begun,
            faces,
            width: None,
        });
    }
    let mut note = |function, begun: f64, width| {
        out.push(Call {
            function,
            milliseconds: clock() - begun,
            faces,
            width,
        });
    };
    match query.ask {
        Ask::Contact(probe) => {
            let begun = clock();
            let separation = match probe {
                Probe::Sphere(s) => {
                    let center = s.center.coords.into();
                    let d = oracle.distance(center, None)?;
                    note(
                        "distance",
                        begun,
                        widest(d.iter().map(|d| &d.enclosure), size),
                    );
                    let begun = clock();
                    let d = oracle.sphere(center, s.radius, None)?;
                    note("sphere (with the side)", begun, None);
                    d
                }
                Probe::HalfSpace(h) => {
                    let d = oracle.half_space(h.normal.into(), h.offset, None)?;
                    note(
                        "half-space",
                        begun,
                        widest(d.iter().map(|d| &d.enclosure), size),
                    );
                    d
                }
            };
            let begun = clock();
            if query.contacts == Some(Contacts::All) {
                let found = oracle.contacts(&probe, query.prediction.unwrap_or(0.0))?;
                let due = found.contacts.iter();
                let due = due.filter(|c| c.proven && c.within && !c.continuum);
                note("contacts", begun, widest(due.map(|c| &c.separation), size));
            } else if let Some(d) = separation {
                let exact = TruthEnclosure {
                    lo: d.enclosure.lo,
                    hi: d.enclosure.hi,
                };
                oracle.foot(&probe, &exact)?;
                note("foot", begun, None);
            }
        }
        Ask::Line(l) => {
            let begun = clock();
            let found = oracle.line(l.origin.coords.into(), l.direction.into(), l.kind)?;
            let unit = size / l.direction.norm();
            let hits = found.hits.iter();
            let ends = hits.flat_map(|h| std::iter::once(&h.t).chain(&h.t_end));
            note("line", begun, widest(ends, unit));
        }
        Ask::Side(face, uv) => {
            let begun = clock();
            oracle.side(face, uv.coords.into())?;
            note("side", begun, None);
        }
        Ask::Inside(point) => {
            let begun = clock();
            oracle.inside(point.coords.into())?;
            note("inside", begun, None);
        }
        Ask::Arrival(..) => {}
        Ask::Split(at) => {
            let begun = clock();
            let found = oracle.derivative_roots(at.face, at.trim_loop, at.trim)?;
            let roots = found.axes.iter().flat_map(|a| &a.roots);
            let all = roots.map(|r| &r.t);
            // Of the curve's parameter.
            note("split", begun, widest(all, 1.0));
        }
        Ask::Evaluate(face, uv) => {
            let begun = clock();
            let found = oracle.evaluate(face, uv.coords.into())?;
            note("evaluate", begun, widest(&found.point, size));
        }
    }
    Ok(out)
}

/// The value that a part of them do not exceed.
fn quantile(sorted: &[f64], part: f64) -> f64 {
    let last = sorted.len().saturating_sub(1);
    sorted
        .get((part * last as f64).round() as usize)
        .copied()
        .unwrap_or(f64::NAN)
}

fn row(name: &str, calls: &[&Call], time: impl Fn(&Call) -> f64) {
    if calls.is_empty() {
        return;
    }
    let mut times: Vec<f64> = calls.iter().map(|c| time(c)).collect();
    times.sort_by(f64::total_cmp);
    let widths = calls.iter().filter_map(|c| c.width);
    let width = widths.reduce(f64::max).map_or("-".to_owned(), |w| {
        if w > 0.0 {
            format!("2^{:.0}", w.log2().ceil())
        } else {
            "0".to_owned()
        }
    });
    println!(
        "{name:32} {:>6} {:>10.3} {:>10.3} {:>10.1} {width:>8}",
        times.len(),
        quantile(&times, 0.5),
        quantile(&times, 0.99),
        quantile(&times, 1.0),
    );
}

/// Some contact queries about each part of many faces.
fn of_large_parts(
    corpora: &Path,
    suite: Option<&str>,
    models: &mut BTreeMap<String, Loaded>,
    each: usize,
) -> Result<Vec<CorpusQuery>, String> {
    let text = |e: feeler_corpus::CorpusError| e.to_string();
    let mut out = Vec::new();
    for suite in suites(corpora, suite).map_err(text)? {
        for file in &suite.files {
            let (queries, _) = file.queries().map_err(text)?;
            load(corpora, &queries, models)?;
            let mut by_model: BTreeMap<&str, Vec<&CorpusQuery>> = BTreeMap::new();
            for q in &queries {
                let large = models.get(&q.model).is_some_and(|loaded| {
                    let faces = loaded.model.breps.iter().map(|b| b.faces().len());
                    faces.sum::<usize>() >= LARGE
                });
                if large && matches!(q.query.ask, Ask::Contact(_)) {
                    by_model.entry(&q.model).or_default().push(q);
                }
            }
            for all in by_model.values() {
                let step = (all.len() / each.max(1)).max(1);
                out.extend(all.iter().step_by(step).take(each).map(|q| (*q).clone()));
            }
        }
    }
    Ok(out)
}

pub(super) fn run(args: &Args) -> Result<(), String> {
    let mut models = BTreeMap::new();
    let each = args.sample.unwrap_or(SAMPLE);
    let suite = args.suite.as_deref();
    let sampled = sample(&args.corpora, suite, &mut models, each)?;
    let mut asked: Vec<CorpusQuery> = sampled.into_iter().map(|(_, query, _)| query).collect();
    asked.extend(of_large_parts(&args.corpora, suite, &mut models, each)?);
    // Those about one model one after another, so that what they share is made once.
    asked.sort_by(|a, b| a.model.cmp(&b.model));
    let jobs = args
        .jobs
        .or_else(|| std::thread::available_parallelism().ok().map(Into::into));
    let found = in_parallel(asked.len(), jobs.unwrap_or(1), || {
        let mut oracle: Option<(&str, Result<Oracle, String>)> = None;
        let mut made = Vec::new();
        let (asked, models) = (&asked, &models);
        move |i| {
            let query = &asked[i];
            let loaded = models.get(&query.model).ok_or("no model")?;
            if oracle.as_ref().is_none_or(|(name, _)| *name != query.model) {
                oracle = Some((&query.model, oracle_of(&loaded.model)));
                made.clear();
            }
            let found = match &oracle {
                Some((_, Ok(oracle))) => {
                    calls(oracle, &query.query, loaded, &mut made).map_err(|e| e.to_string())
                }
                Some((_, Err(why))) => Err(why.clone()),
                None => Err("no oracle".to_owned()),
            }?;
            for call in &found {
                if args.slow.is_some_and(|s| call.milliseconds >= s * 1e3) {
                    let line = query.line.to_text();
                    println!(
                        "{:.1} s, {}: {line}",
                        call.milliseconds * 1e-3,
                        call.function
                    );
                }
            }
            Ok::<_, String>(found)
        }
    })?;
    let mut all: Vec<Call> = Vec::new();
    for calls in found {
        all.extend(calls?);
    }
    println!(
        "{:32} {:>6} {:>10} {:>10} {:>10} {:>8}",
        "function", "calls", "median ms", "p99 ms", "most ms", "widest"
    );
    for function in [
        "prepare a face in uv",
        "prepare a model's pieces",
        "prepare pieces and edges",
        "distance",
        "half-space",
        "sphere (with the side)",
        "foot",
        "contacts",
        "line",
        "inside",
        "side",
        "split",
        "evaluate",
    ] {
        let of: Vec<&Call> = all.iter().filter(|c| c.function == function).collect();
        row(function, &of, |c| c.milliseconds);
        if ["distance", "half-space", "sphere (with the side)"].contains(&function) {
            row("  by face", &of, |c| c.milliseconds / c.faces.max(1) as f64);
            let of_faces = |least: usize, most: usize| -> Vec<&Call> {
                let of = of.iter().filter(|c| (least..=most).contains(&c.faces));
                of.copied().collect()
            };
            row("  of one face", &of_faces(1, 1), |c| c.milliseconds);
            let large = format!("  of {LARGE} faces and more");
            row(&large, &of_faces(LARGE, usize::MAX), |c| c.milliseconds);
        }
    }
    Ok(())
}
