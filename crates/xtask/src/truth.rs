//! `cargo xtask truth`: what the oracle says of every query of the corpus.

use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// One suite alone.
    #[arg(long)]
    suite: Option<String>,
    /// The corpus.
    #[arg(long, default_value = "corpora")]
    corpora: PathBuf,
    /// How many threads; each has an oracle of its own.
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Remove queries that the oracle cannot settle from their files, and say how many.
    #[arg(long)]
    prune: bool,
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
pub(crate) use with_oracle::{oracle_of, run, truth_of};

#[cfg(feature = "cgal")]
mod with_oracle {
    use super::Args;
    use feeler::query::Probe;
    use feeler::trim::Side;
    use feeler_corpus::{
        Ask, CorpusQuery, HitTruth, MODELS, Model, Query, QueryFile, Truth, TruthEnclosure,
        TruthHeader, suites,
    };
    use feeler_oracle::{InsideTruth, Oracle};
    use indicatif::{ProgressBar, ProgressStyle};
    use std::collections::BTreeMap;
    use std::sync::atomic::{AtomicUsize, Ordering};

    const ORACLE: &str = concat!(
        "feeler-oracle ",
        env!("CARGO_PKG_VERSION"),
        " over CGAL, tested with 5.5.1"
    );

    pub(crate) fn run(args: &Args) -> Result<(), String> {
        let found = suites(&args.corpora, args.suite.as_deref()).map_err(|e| e.to_string())?;
        for suite in &found {
            for file in &suite.files {
                truth_file(args, &suite.name, file)?;
            }
        }
        Ok(())
    }

    fn truth_file(args: &Args, suite: &str, file: &QueryFile) -> Result<(), String> {
        let (queries, mut hash) = file.queries().map_err(|e| e.to_string())?;
        let mut models = BTreeMap::new();
        for q in &queries {
            if !models.contains_key(&q.model) {
                let path = args.corpora.join(MODELS).join(&q.model);
                let model = Model::load(&path, None).map_err(|e| e.to_string())?;
                models.insert(q.model.clone(), model);
            }
        }
        let bar = ProgressBar::new(queries.len() as u64);
        if let Ok(style) = ProgressStyle::with_template("{msg} {bar:30} {pos}/{len} {eta}") {
            bar.set_style(style);
        }
        bar.set_message(suite.to_owned());
        let truths = all_truths(&queries, &models, args.jobs.max(1), &bar);
        bar.finish_and_clear();
        let open = truths
            .iter()
            .filter(|t| matches!(t, Truth::Unknown { .. }))
            .count();
        let mut kept = Vec::with_capacity(truths.len());
        let mut text = String::new();
        for (query, truth) in queries.iter().zip(truths) {
            if let Truth::Unknown { why } = &truth {
                eprintln!("{suite}:{}: no truth: {why}", query.number);
                if args.prune {
                    continue;
                }
            }
            text += &(query.line.to_text() + "\n");
            kept.push(truth);
        }
        if args.prune && open > 0 {
            std::fs::write(&file.queries, &text)
                .map_err(|e| format!("{}: {e}", file.queries.display()))?;
            hash = feeler_corpus::bytes_hash(text.as_bytes());
        }
        let header = TruthHeader {
            oracle: ORACLE.to_owned(),
            queries: hash,
            models: models.iter().map(|(n, m)| (n.clone(), m.hash())).collect(),
        };
        file.write_truth(&header, &kept)
            .map_err(|e| e.to_string())?;
        let what = if args.prune { "removed" } else { "kept" };
        println!(
            "{suite}: {} truths, {open} queries the oracle cannot settle ({what})",
            kept.len()
        );
        Ok(())
    }

    fn all_truths(
        queries: &[CorpusQuery],
        models: &BTreeMap<String, Model>,
        jobs: usize,
        bar: &ProgressBar,
    ) -> Vec<Truth> {
        let next = AtomicUsize::new(0);
        let work = || {
            // An oracle is neither `Send` nor `Sync`: each thread makes its own, and the queries
            // come by model.
            let mut oracle: Option<(&str, Result<Oracle, String>)> = None;
            let mut done = Vec::new();
            loop {
                let i = next.fetch_add(1, Ordering::Relaxed);
                let Some(q) = queries.get(i) else {
                    return done;
                };
                if oracle.as_ref().is_none_or(|(name, _)| *name != q.model)
                    && let Some(model) = models.get(&q.model)
                {
                    oracle = Some((&q.model, oracle_of(model)));
                }
                let truth = match &oracle {
                    Some((_, Ok(oracle))) => truth_of(oracle, &q.query),
                    Some((_, Err(why))) => Err(why.clone()),
                    None => Err("no model".to_owned()),
                };
                done.push((i, truth.unwrap_or_else(|why| Truth::Unknown { why })));
                bar.inc(1);
            }
        };
        let mut all: Vec<(usize, Truth)> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..jobs).map(|_| scope.spawn(work)).collect();
            threads
                .into_iter()
                .flat_map(|t| t.join().unwrap_or_default())
                .collect()
        });
        all.sort_by_key(|(i, _)| *i);
        all.into_iter().map(|(_, t)| t).collect()
    }

    pub(crate) fn oracle_of(model: &Model) -> Result<Oracle, String> {
        let breps: Vec<_> = model.breps.iter().collect();
        Oracle::new(&breps).map_err(|e| e.to_string())
    }

    /// A truth must be narrower than the floor of full accuracy, 2^-96 of the model's size; the
    /// models are larger than 4.
    const LARGEST_WIDTH: f64 = 4.0 / (1u128 << 100) as f64;

    fn narrow(e: &feeler_oracle::TruthEnclosure) -> Result<TruthEnclosure, String> {
        let width = e.width().approximate();
        if width <= LARGEST_WIDTH {
            Ok(enclosure(e))
        } else {
            Err(format!("the truth is {width:e} wide (an undecided side?)"))
        }
    }

    fn enclosure(e: &feeler_oracle::TruthEnclosure) -> TruthEnclosure {
        TruthEnclosure {
            lo: e.lo.clone(),
            hi: e.hi.clone(),
        }
    }

    /// The truth of a query, or why the oracle has none.
    pub(crate) fn truth_of(oracle: &Oracle, query: &Query) -> Result<Truth, String> {
        let three = |e: &[feeler_oracle::TruthEnclosure; 3]| e.each_ref().map(enclosure);
        let text = |e: feeler_oracle::OracleError| e.to_string();
        match query.ask {
            Ask::Contact(probe) => {
                let found = match probe {
                    Probe::Sphere(s) => oracle.sphere(s.center.coords.into(), s.radius, None),
                    Probe::HalfSpace(h) => oracle.half_space(h.normal.into(), h.offset, None),
                };
                let found = found.map_err(text)?.ok_or("the model has no face")?;
                Ok(Truth::Separation(narrow(&found.enclosure)?))
            }
            Ask::Line(l) => {
                let found = oracle
                    .line(l.origin.coords.into(), l.direction.into(), l.kind)
                    .map_err(text)?;
                if let Some(open) = found.open.first() {
                    return Err(open.why.clone());
                }
                let hits = found.hits.iter().map(|h| {
                    Ok(HitTruth {
                        t: narrow(&h.t)?,
                        t_end: h.t_end.as_ref().map(narrow).transpose()?,
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
                    // The oracle does not compute the cracks' widths: not judged.
                    in_crack: None,
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
}
