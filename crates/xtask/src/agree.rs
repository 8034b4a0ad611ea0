//! `cargo xtask agree FILE`: the kernel against the oracle, live, on random queries.

#[cfg(any(feature = "cgal", test))]
use feeler_corpus::{Judgement, Verdict};
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .3dm or .brep file.
    file: PathBuf,
    /// How many queries.
    #[arg(long, default_value_t = 200)]
    queries: usize,
    /// One object alone.
    #[arg(long)]
    object: Option<usize>,
}

/// What the answers to one kind of query earned.
#[cfg(any(feature = "cgal", test))]
#[derive(Default)]
struct Row {
    /// In the order of [`Verdict`]; and those without truth.
    counts: [usize; 5],
    /// The largest error of a value, in ulp: of all answers but the undecided. None where no answer is a number.
    ulps: Option<f64>,
}

#[cfg(any(feature = "cgal", test))]
impl Row {
    fn add(&mut self, judgement: &Judgement) {
        self.counts[judgement.verdict as usize] += 1;
        if judgement.verdict != Verdict::Undecided {
            self.ulps = self.ulps.into_iter().chain(judgement.ulps).reduce(f64::max);
        }
    }
}

#[cfg(not(feature = "cgal"))]
pub(crate) fn run(_args: &Args) -> Result<(), String> {
    crate::truth::again_with_oracle()
}

#[cfg(feature = "cgal")]
pub(crate) use with_oracle::run;

#[cfg(feature = "cgal")]
mod with_oracle {
    use super::{Args, Row};
    use crate::generate::Generator;
    use crate::truth::{oracle_of, truth_of};
    use feeler::query::Options;
    use feeler_corpus::{Model, QueryLine, Verdict, judge};
    use feeler_gate::{Engine, FeelerEngine, asked, model_size};
    use std::collections::BTreeMap;

    type Ask = fn(&mut Generator<'_>, bool) -> QueryLine;
    const KINDS: [(&str, Ask); 6] = [
        ("sphere", |g, near| g.sphere(near)),
        ("half_space", |g, near| g.half_space(near)),
        ("line", |g, near| g.line(near)),
        ("side", |g, near| g.side(near)),
        ("inside", |g, near| g.inside(near)),
        ("evaluate", |g, near| g.evaluate(near)),
    ];

    pub(crate) fn run(args: &Args) -> Result<(), String> {
        let model = Model::load(&args.file, args.object).map_err(|e| e.to_string())?;
        let oracle = oracle_of(&model)?;
        let size = model_size(&model);
        let mut generator = Generator::new(&model, "agree");
        let mut engine = FeelerEngine::new(Options::default());
        engine.open(&model)?;
        let mut rows: BTreeMap<&str, Row> = BTreeMap::new();
        let mut wrong = Vec::new();
        for i in 0..args.queries {
            let (kind, ask) = KINDS[i % KINDS.len()];
            let line = ask(&mut generator, (i / KINDS.len()).is_multiple_of(2));
            let query = line.query().map_err(|e| e.to_string())?;
            let row = rows.entry(kind).or_default();
            let truth = match truth_of(&oracle, &query, size) {
                Ok(truth) => truth,
                Err(why) => {
                    row.counts[4] += 1;
                    println!("no truth: {why}: {}", line.to_text());
                    continue;
                }
            };
            let answer = engine.answer(&query);
            let judgement = judge(&asked(&query, size, 0.0), &answer.body, &truth);
            row.add(&judgement);
            if matches!(judgement.verdict, Verdict::Wrong | Verdict::Indeterminate) {
                let reason = judgement.reason.unwrap_or_default();
                wrong.push(format!("{reason}\n  {}", line.to_text()));
            }
        }
        println!(
            "{:<12}{:>8}{:>8}{:>15}{:>11}{:>10}{:>8}",
            "query", "right", "wrong", "indeterminate", "undecided", "no truth", "ulps"
        );
        for (kind, row) in &rows {
            let [right, wrong, indeterminate, undecided, untold] = row.counts;
            let ulps = row.ulps.map_or("-".to_owned(), |e| format!("{e:.2}"));
            println!(
                "{kind:<12}{right:>8}{wrong:>8}{indeterminate:>15}{undecided:>11}{untold:>10}{ulps:>8}"
            );
        }
        if wrong.is_empty() {
            Ok(())
        } else {
            Err(format!("kernel and oracle differ:\n{}", wrong.join("\n")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler::query::Accuracy;
    use feeler_corpus::{Asked, Body, Claim, Hits, Truth, TruthEnclosure, judge};

    /// 1/3 lies a third of an ulp above the next f64, two thirds below the one after.
    #[test]
    fn the_largest_error_of_what_is_answered() {
        let asked = Asked {
            accuracy: Accuracy::Full,
            size: 10.0,
            prediction: 0.0,
            contacts: false,
            hits: Hits::All,
            scale: 1.0,
            tolerance: 0.0,
            probe: None,
        };
        let third = Truth::Separation(TruthEnclosure {
            lo: "5555555555555555555555555555555555555555p-160"
                .parse()
                .unwrap(),
            hi: "5555555555555555555555555555555555555556p-160"
                .parse()
                .unwrap(),
        });
        let mut row = Row::default();
        let mut ask = |value: f64, lo: f64, hi: f64| {
            let body = Body::Contact {
                separation: Claim {
                    value,
                    lo: Some(lo),
                    hi: Some(hi),
                },
                continuum: None,
                contacts: vec![],
                undecided: None,
            };
            row.add(&judge(&asked, &body, &third));
            (row.counts, row.ulps)
        };
        let near = |ulps: Option<f64>, x: f64| (ulps.unwrap() - x).abs() < 1e-6;
        let (below, above) = (1.0 / 3.0, (1.0f64 / 3.0).next_up());
        let (_, ulps) = ask(below, below, above);
        assert!(near(ulps, 1.0 / 3.0), "{ulps:?}");
        let (_, ulps) = ask(above, below, above);
        assert!(near(ulps, 2.0 / 3.0), "{ulps:?}");
        // Nearer, and undecided, however far off: neither counts.
        ask(below, below, above);
        let (counts, ulps) = ask(0.5, 0.0, 1.0);
        assert!(near(ulps, 2.0 / 3.0), "{ulps:?}");
        assert_eq!(counts, [3, 0, 0, 1, 0]);
        // What is wrong is shown.
        let (counts, ulps) = ask(above.next_up(), above, above.next_up());
        assert!(near(ulps, 5.0 / 3.0), "{ulps:?}");
        assert_eq!(counts, [3, 1, 0, 1, 0]);
    }
}
