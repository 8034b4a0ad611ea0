//! `cargo xtask truth`: what the oracle says of every query of the corpus.

#[cfg(feature = "cgal")]
mod check;
#[cfg(feature = "cgal")]
mod log;
#[cfg(feature = "cgal")]
mod parallel;
#[cfg(feature = "cgal")]
mod times;

use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// One suite alone.
    #[arg(long)]
    pub(crate) suite: Option<String>,
    /// The corpus.
    #[arg(long, default_value = "corpora")]
    pub(crate) corpora: PathBuf,
    /// How many threads, each with an oracle of its own; as many as there are cores if not said. The
    /// truth is the same for any number.
    #[arg(long)]
    jobs: Option<usize>,
    /// Also suites whose stored truth is that of their queries and models.
    #[arg(long)]
    force: bool,
    /// Where results are kept until a suite is done: a run that was stopped goes on from there.
    #[arg(long, default_value = "target/truth")]
    partial: PathBuf,
    /// Remove queries that the oracle cannot settle from their files, and say how many.
    #[arg(long)]
    prune: bool,
    /// Write nothing: compute a sample of the stored truth again, and fail where it differs in any bit.
    #[arg(long, conflicts_with_all = ["force", "prune", "times"])]
    check: bool,
    /// Write nothing: print how long each of the oracle's functions takes on a sample, and how wide the truths are.
    #[arg(long, conflicts_with_all = ["force", "prune"], group = "timed")]
    times: bool,
    /// With --verify or --times: print queries that take at least so many seconds.
    #[arg(long, requires = "timed")]
    pub(crate) slow: Option<f64>,
    /// With --verify, --check or --times: about so many queries of each suite.
    #[arg(long)]
    pub(crate) sample: Option<usize>,
    #[command(flatten)]
    pub(crate) verify: crate::verify::Args,
}

/// Runs this command again, with the oracle built in.
#[cfg(not(feature = "cgal"))]
pub(crate) fn again_with_oracle() -> Result<(), String> {
    println!("building with the oracle (feature `cgal`) ...");
    let status = std::process::Command::new(env!("CARGO"))
        .args([
            "run",
            "--release",
            "--quiet",
            "--package",
            "xtask",
            "--features",
            "cgal",
            "--",
        ])
        .args(std::env::args_os().skip(1))
        .status()
        .map_err(|e| format!("cargo cannot be started: {e}"))?;
    if status.success() {
        Ok(())
    } else {
        Err("see above".into())
    }
}

#[cfg(not(feature = "cgal"))]
pub(crate) fn run(_args: &Args) -> Result<(), String> {
    again_with_oracle()
}

#[cfg(feature = "cgal")]
pub(crate) use with_oracle::{oracle_of, truth_of};

/// Computes what is missing of the truth of a corpus.
#[cfg(feature = "cgal")]
pub(crate) fn of_corpus(corpora: &std::path::Path) -> Result<(), String> {
    run(&Args {
        suite: None,
        corpora: corpora.to_path_buf(),
        jobs: None,
        force: false,
        partial: corpora.join("partial"),
        prune: false,
        check: false,
        times: false,
        slow: None,
        sample: None,
        verify: crate::verify::Args {
            verify: false,
            keep_going: false,
        },
    })
}

#[cfg(feature = "cgal")]
pub(crate) fn run(args: &Args) -> Result<(), String> {
    if args.check {
        check::run(args)
    } else if args.times {
        times::run(args)
    } else {
        with_oracle::run(args)
    }
}

#[cfg(feature = "cgal")]
mod with_oracle {
    use super::Args;
    use super::log::{self, Log, sources_hash};
    use super::parallel::in_parallel;
    use feeler::query::{Contacts, Probe};
    use feeler::trim::Side;
    use feeler_corpus::{
        Ask, AxisSplitTruth, ContactTruth, CorpusQuery, HitTruth, MODELS, Model, Query, QueryFile,
        SplitRootTruth, Truth, TruthEnclosure, TruthHeader, suites,
    };
    use feeler_oracle::{AxisRootsTruth, InsideTruth, Oracle};
    use indicatif::{ProgressBar, ProgressStyle};
    use std::collections::BTreeMap;
    use std::path::Path;
    use std::time::{Duration, Instant};

    const ORACLE: &str = concat!(
        "feeler-oracle ",
        env!("CARGO_PKG_VERSION"),
        " over CGAL, tested with 5.5.1"
    );

    /// A query file, read, and what its truth depends on.
    struct Work<'a> {
        suite: &'a str,
        file: &'a QueryFile,
        queries: Vec<CorpusQuery>,
        hash: String,
        models: BTreeMap<String, String>,
    }

    /// A model, its hash, and the longest side of its box.
    pub(super) struct Loaded {
        pub(super) model: Model,
        hash: String,
        pub(super) size: f64,
    }

    pub(super) fn run(args: &Args) -> Result<(), String> {
        let text = |e: feeler_corpus::CorpusError| e.to_string();
        let found = suites(&args.corpora, args.suite.as_deref()).map_err(text)?;
        let sources = sources_hash(&xtask_test::root())?;
        let mut models = BTreeMap::new();
        let mut todo = Vec::new();
        for suite in &found {
            for file in &suite.files {
                let (queries, hash) = file.queries().map_err(text)?;
                let work = Work {
                    models: load(&args.corpora, &queries, &mut models)?,
                    suite: &suite.name,
                    file,
                    queries,
                    hash,
                };
                if !args.force && work.is_current() {
                    println!("{}: as stored ({})", suite.name, work.queries.len());
                } else {
                    todo.push(work);
                }
            }
        }
        let bar = ProgressBar::new(todo.iter().map(|w| w.queries.len() as u64).sum());
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
            bar.set_style(style);
        }
        for work in &todo {
            bar.set_message(work.suite.to_owned());
            let name = format!("{}/{}", work.suite, work.file.name());
            let path = args.partial.join(name + ".log");
            let log = Log::open(&path)?;
            let started = Instant::now();
            let truths = work.truths(&models, args.jobs, &sources, &log, &bar)?;
            work.store(truths, args.prune, &bar, started.elapsed())?;
            log.remove();
        }
        bar.finish_and_clear();
        Ok(())
    }

    /// Reads the models that the queries are about and that are not read yet; their hashes.
    pub(super) fn load(
        corpora: &Path,
        queries: &[CorpusQuery],
        models: &mut BTreeMap<String, Loaded>,
    ) -> Result<BTreeMap<String, String>, String> {
        let mut hashes = BTreeMap::new();
        for q in queries {
            if !models.contains_key(&q.model) {
                let path = corpora.join(MODELS).join(&q.model);
                let model = Model::load(&path, None).map_err(|e| e.to_string())?;
                let loaded = Loaded {
                    hash: model.hash(),
                    size: feeler_gate::model_size(&model),
                    model,
                };
                models.insert(q.model.clone(), loaded);
            }
            if let Some(loaded) = models.get(&q.model) {
                hashes.insert(q.model.clone(), loaded.hash.clone());
            }
        }
        Ok(hashes)
    }

    impl Work<'_> {
        fn header(&self, hash: String) -> TruthHeader {
            TruthHeader {
                oracle: ORACLE.to_owned(),
                queries: hash,
                models: self.models.clone(),
            }
        }

        /// Whether the stored truth is that of these queries and models, all of it settled.
        fn is_current(&self) -> bool {
            let stored = self.file.truth(self.queries.len(), &self.hash);
            stored.is_ok_and(|(header, truths)| {
                header == self.header(self.hash.clone())
                    && !truths.iter().any(|t| matches!(t, Truth::Unknown { .. }))
            })
        }

        fn truths(
            &self,
            models: &BTreeMap<String, Loaded>,
            jobs: Option<usize>,
            sources: &str,
            log: &Log,
            bar: &ProgressBar,
        ) -> Result<Vec<Truth>, String> {
            let jobs = jobs.or_else(|| std::thread::available_parallelism().ok().map(Into::into));
            in_parallel(self.queries.len(), jobs.unwrap_or(1), || {
                // An oracle is neither `Send` nor `Sync`: each thread makes its own, and the queries
                // come by model.
                let mut oracle: Option<(&str, Result<Oracle, String>)> = None;
                move |i| {
                    let q = &self.queries[i];
                    let Some(loaded) = models.get(&q.model) else {
                        return unknown("no model".to_owned());
                    };
                    let key = log::key(sources, &loaded.hash, &q.line.to_text());
                    if let Some(truth) = log.get(&key) {
                        bar.inc(1);
                        return truth.clone();
                    }
                    if oracle.as_ref().is_none_or(|(name, _)| *name != q.model) {
                        oracle = Some((&q.model, oracle_of(&loaded.model)));
                    }
                    let truth = match &oracle {
                        Some((_, Ok(oracle))) => truth_of(oracle, &q.query, loaded.size),
                        Some((_, Err(why))) => Err(why.clone()),
                        None => Err("no oracle".to_owned()),
                    };
                    let truth = truth.unwrap_or_else(unknown);
                    log.add(key, &truth);
                    bar.inc(1);
                    truth
                }
            })
        }

        /// Writes the truth, and says what is open.
        fn store(
            &self,
            truths: Vec<Truth>,
            prune: bool,
            bar: &ProgressBar,
            time: Duration,
        ) -> Result<(), String> {
            let mut reasons: BTreeMap<String, usize> = BTreeMap::new();
            let mut kept = Vec::with_capacity(truths.len());
            let mut text = String::new();
            for (query, truth) in self.queries.iter().zip(truths) {
                if let Truth::Unknown { why } = &truth {
                    *reasons.entry(why.clone()).or_default() += 1;
                    if prune {
                        continue;
                    }
                }
                text += &(query.line.to_text() + "\n");
                kept.push(truth);
            }
            let open: usize = reasons.values().sum();
            let mut hash = self.hash.clone();
            if prune && open > 0 {
                let path = &self.file.queries;
                feeler_corpus::write_text(path, &text)
                    .map_err(|e| format!("{}: {e}", path.display()))?;
                hash = feeler_corpus::bytes_hash(text.as_bytes());
            }
            self.file
                .write_truth(&self.header(hash), &kept)
                .map_err(|e| e.to_string())?;
            let what = if prune { "removed" } else { "kept" };
            bar.suspend(|| {
                println!(
                    "{}: {} truths in {:.0} s; {open} queries the oracle cannot settle ({what})",
                    self.suite,
                    kept.len(),
                    time.as_secs_f64()
                );
                for (why, count) in reasons {
                    println!("  {count}: {why}");
                }
            });
            Ok(())
        }
    }

    pub(super) fn unknown(why: String) -> Truth {
        Truth::Unknown { why }
    }

    pub(crate) fn oracle_of(model: &Model) -> Result<Oracle, String> {
        let breps: Vec<_> = model.breps.iter().collect();
        Oracle::new(&breps).map_err(|e| e.to_string())
    }

    /// A truth must be narrower than the floor of full accuracy, 2^-96 of the model's size, by far.
    const LARGEST_WIDTH: f64 = 1.0 / (1u128 << 100) as f64;

    fn narrow(e: &feeler_oracle::TruthEnclosure, limit: f64) -> Result<TruthEnclosure, String> {
        let width = e.width().approximate();
        if width <= limit {
            Ok(enclosure(e))
        } else {
            // Rounded, so that many reasons of a kind are counted as one.
            Err(format!("the truth is 1e{:.0} wide", width.log10()))
        }
    }

    fn enclosure(e: &feeler_oracle::TruthEnclosure) -> TruthEnclosure {
        TruthEnclosure {
            lo: e.lo.clone(),
            hi: e.hi.clone(),
        }
    }

    /// The truth of the contacts beside the separation: all of them, or the place of the deepest alone.
    fn contact_truth(
        oracle: &Oracle,
        query: &Query,
        probe: &Probe,
        separation: TruthEnclosure,
        limit: f64,
    ) -> Result<Truth, String> {
        if query.contacts == Some(Contacts::All) {
            // The protocol's default.
            let prediction = query.prediction.unwrap_or(0.0);
            let found = oracle
                .contacts(probe, prediction)
                .map_err(|e| e.to_string())?;
            if !found.whole {
                return Err("contacts: the budget is spent".to_owned());
            }
            let mut contacts = Vec::new();
            for c in &found.contacts {
                let due = c.proven && c.within;
                // An answer is held against it: where the oracle's is too wide, there is no truth.
                let own = if due && !c.continuum {
                    narrow(&c.separation, limit).map_err(|e| format!("a contact: {e}"))?
                } else {
                    enclosure(&c.separation)
                };
                contacts.push(ContactTruth {
                    separation: own,
                    at: c.at,
                    due,
                    continuum: c.continuum,
                });
            }
            return Ok(Truth::Contact {
                separation,
                foot: None,
                contacts: Some(contacts),
            });
        }
        // With several feet, or none that is a point, the separation is all that is said.
        let exact = feeler_oracle::TruthEnclosure {
            lo: separation.lo.clone(),
            hi: separation.hi.clone(),
        };
        let foot = match query.contacts {
            Some(Contacts::None) => None,
            _ => oracle.foot(probe, &exact).map_err(|e| e.to_string())?,
        };
        Ok(match foot {
            Some(_) => Truth::Contact {
                separation,
                foot,
                contacts: None,
            },
            None => Truth::Separation(separation),
        })
    }

    fn split_truth(axis: &AxisRootsTruth) -> AxisSplitTruth {
        AxisSplitTruth {
            roots: axis
                .roots
                .iter()
                .map(|r| SplitRootTruth {
                    t: enclosure(&r.t),
                    multiplicity: r.multiplicity,
                    turns: r.turns(),
                })
                .collect(),
            constant: axis
                .constant
                .iter()
                .map(|c| c.each_ref().map(enclosure))
                .collect(),
        }
    }

    /// The truth of a query about a model of this size, or why the oracle has none.
    pub(crate) fn truth_of(oracle: &Oracle, query: &Query, size: f64) -> Result<Truth, String> {
        let limit = LARGEST_WIDTH * size;
        let three = |e: &[feeler_oracle::TruthEnclosure; 3]| e.each_ref().map(enclosure);
        let text = |e: feeler_oracle::OracleError| e.to_string();
        match query.ask {
            Ask::Contact(probe) => {
                let found = match probe {
                    Probe::Sphere(s) => oracle.sphere(s.center.coords.into(), s.radius, None),
                    Probe::HalfSpace(h) => oracle.half_space(h.normal.into(), h.offset, None),
                };
                let found = found.map_err(text)?.ok_or("the model has no face")?;
                contact_truth(
                    oracle,
                    query,
                    &probe,
                    narrow(&found.enclosure, limit)?,
                    limit,
                )
            }
            Ask::Line(l) => {
                // Of t, which counts in the direction's length.
                let limit = limit / l.direction.norm();
                let found = oracle
                    .line(l.origin.coords.into(), l.direction.into(), l.kind)
                    .map_err(text)?;
                if let Some(open) = found.open.first() {
                    return Err(open.why.clone());
                }
                let hits = found.hits.iter().map(|h| {
                    Ok(HitTruth {
                        t: narrow(&h.t, limit)?,
                        t_end: h.t_end.as_ref().map(|e| narrow(e, limit)).transpose()?,
                        face: h.face,
                        tangential: match (h.tangential, h.transversal) {
                            (true, _) => Some(true),
                            (_, true) => Some(false),
                            _ => None,
                        },
                    })
                });
                Ok(Truth::Line {
                    hits: hits.collect::<Result<_, String>>()?,
                    crossings: found.crossings,
                    in_crack: found.in_crack,
                })
            }
            Ask::Side(face, uv) => {
                let found = oracle.side(face, uv.coords.into()).map_err(text)?;
                Ok(Truth::Side {
                    side: found.side,
                    in_gap: Some(found.in_gap),
                })
            }
            Ask::Inside(point) => {
                let side = match oracle.inside(point.coords.into()).map_err(text)? {
                    InsideTruth::Inside => Side::Inside,
                    InsideTruth::Outside => Side::Outside,
                    InsideTruth::Boundary => Side::Boundary,
                    InsideTruth::Undecided(why) => return Err(why),
                };
                Ok(Truth::Side { side, in_gap: None })
            }
            Ask::Arrival(..) => Err("the oracle knows nothing of what moves".into()),
            Ask::Split(at) => {
                let found = oracle
                    .derivative_roots(at.face, at.trim_loop, at.trim)
                    .map_err(text)?;
                let [u, v] = found.axes.each_ref().map(split_truth);
                Ok(Truth::Split { u, v })
            }
            Ask::Evaluate(face, uv) => {
                let found = oracle.evaluate(face, uv.coords.into()).map_err(text)?;
                Ok(Truth::Evaluate {
                    point: three(&found.point),
                    du: three(&found.du),
                    dv: three(&found.dv),
                })
            }
        }
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        /// The first queries of each suite: the truth as stored, with one thread, with three, and gone on
        /// with by three after a run of one was stopped.
        #[test]
        fn truth_is_the_same_for_any_number_of_threads_and_after_a_stop() {
            let corpora = xtask_test::root().join("corpora");
            let folder = std::env::temp_dir().join(format!("feeler-truth-{}", std::process::id()));
            let bar = ProgressBar::hidden();
            let mut models = BTreeMap::new();
            for suite in suites(&corpora, None).unwrap() {
                if !["contact-half-space", "evaluate", "inside", "line", "side"]
                    .contains(&&*suite.name)
                {
                    continue;
                }
                for file in &suite.files {
                    let (mut queries, hash) = file.queries().unwrap();
                    let (_, stored) = file.truth(queries.len(), &hash).unwrap();
                    queries.truncate(4);
                    let work = Work {
                        models: load(&corpora, &queries, &mut models).unwrap(),
                        suite: &suite.name,
                        file,
                        queries,
                        hash,
                    };
                    let stopped = Work {
                        queries: work.queries[..2].to_vec(),
                        models: work.models.clone(),
                        hash: work.hash.clone(),
                        ..work
                    };
                    for (runs, jobs) in [
                        (vec![&work], 1),
                        (vec![&work], 3),
                        (vec![&stopped, &work], 3),
                    ] {
                        for (i, run) in runs.iter().enumerate() {
                            let log = Log::open(&folder.join(&suite.name)).unwrap();
                            let jobs = if i + 1 < runs.len() { 1 } else { jobs };
                            let truths = run.truths(&models, Some(jobs), "", &log, &bar).unwrap();
                            assert_eq!(truths, stored[..truths.len()], "{}", suite.name);
                            if i + 1 == runs.len() {
                                log.remove();
                            }
                        }
                    }
                }
            }
            std::fs::remove_dir_all(&folder).unwrap();
        }
    }
}
