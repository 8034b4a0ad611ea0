//! `cargo xtask agree FILE`: the kernel against the oracle, live, on random queries.

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

#[cfg(not(feature = "cgal"))]
pub(crate) fn run(_args: &Args) -> Result<(), String> {
    crate::truth::again_with_oracle()
}

#[cfg(feature = "cgal")]
pub(crate) use with_oracle::run;

#[cfg(feature = "cgal")]
mod with_oracle {
    use super::Args;
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
        // Right, wrong, indeterminate, undecided; and without truth.
        let mut counts: BTreeMap<&str, [usize; 5]> = BTreeMap::new();
        let mut wrong = Vec::new();
        for i in 0..args.queries {
            let (kind, ask) = KINDS[i % KINDS.len()];
            let line = ask(&mut generator, (i / KINDS.len()).is_multiple_of(2));
            let query = line.query().map_err(|e| e.to_string())?;
            let row = counts.entry(kind).or_default();
            let truth = match truth_of(&oracle, &query, size) {
                Ok(truth) => truth,
                Err(why) => {
                    row[4] += 1;
                    println!("no truth: {why}: {}", line.to_text());
                    continue;
                }
            };
            let answer = engine.answer(&query);
            let judgement = judge(&asked(&query, size, 0.0), &answer.body, &truth);
            let column = match judgement.verdict {
                Verdict::Right => 0,
                Verdict::Wrong => 1,
                Verdict::Indeterminate => 2,
                Verdict::Undecided => 3,
            };
            row[column] += 1;
            if matches!(column, 1 | 2) {
                let reason = judgement.reason.unwrap_or_default();
                wrong.push(format!("{reason}\n  {}", line.to_text()));
            }
        }
        println!(
            "{:<12}{:>8}{:>8}{:>15}{:>11}{:>10}",
            "query", "right", "wrong", "indeterminate", "undecided", "no truth"
        );
        for (kind, c) in &counts {
            println!(
                "{kind:<12}{:>8}{:>8}{:>15}{:>11}{:>10}",
                c[0], c[1], c[2], c[3], c[4]
            );
        }
        if wrong.is_empty() {
            Ok(())
        } else {
            Err(format!("kernel and oracle differ:\n{}", wrong.join("\n")))
        }
    }
}
