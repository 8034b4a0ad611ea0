//! `feeler view`.

use crate::contact::ProbeArgs;
use crate::{Bad, Outcome};
use feeler::query::Options;
use feeler_corpus::{MAX_TEXT, Model, QueryLine, read_text};
use feeler_gate::FeelerEngine;
use feeler_io::Choice;
use feeler_view::{Fineness, MOST_TRIANGLES, NumberedLine, View};
use std::io::Read;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .3dm, .brep (OCCT, text) or .step file, or a model file of our own (.json, .json.gz).
    #[arg(required_unless_present = "suite", conflicts_with = "suite")]
    file: Option<PathBuf>,
    /// The file to write: one page by the name .html, binary glTF by .glb.
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// Queries to answer and draw, a line of JSON each, as `feeler contact` reads them; `-` for standard input.
    #[arg(long, value_name = "FILE", conflicts_with = "suite")]
    queries: Option<PathBuf>,
    /// Instead of a file: all queries of this suite of the corpus, with what the answers earn against the stored truth.
    #[arg(long, value_name = "NAME")]
    suite: Option<String>,
    /// The corpus.
    #[arg(long, default_value = "corpora", requires = "suite")]
    corpora: PathBuf,
    /// Show object N alone, as `feeler inspect` numbers them.
    #[arg(long, value_name = "N", conflicts_with = "suite")]
    object: Option<usize>,
    /// Leave out hidden objects, and those on hidden layers.
    #[arg(long, conflicts_with_all = ["object", "suite"])]
    skip_hidden: bool,
    /// Leave out locked objects, and those on locked layers.
    #[arg(long, conflicts_with_all = ["object", "suite"])]
    skip_locked: bool,
    #[command(flatten)]
    probe: ProbeArgs,
    /// How far triangles may be from their faces, as a part of the model's size.
    #[arg(long, value_name = "PART", default_value_t = Fineness::default().chord, value_parser = positive)]
    chord: f64,
    /// The largest angle between neighbouring normals, in degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = Fineness::default().degrees, value_parser = positive)]
    angle: f64,
    /// The most triangles: a model that would have more is cut more coarsely, which is said.
    #[arg(long, value_name = "N", default_value_t = MOST_TRIANGLES)]
    triangles: usize,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x > 0.0 && f64::is_finite(x) => Ok(x),
        _ => Err("a number above 0 is needed".to_owned()),
    }
}

/// The formats that are written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Format {
    Page,
    Glb,
}

fn format(out: &Path) -> Result<Format, Bad> {
    let ending = out.extension().map(|e| e.to_ascii_lowercase());
    match ending.as_ref().and_then(|e| e.to_str()) {
        Some("html" | "htm") => Ok(Format::Page),
        Some("glb") => Ok(Format::Glb),
        _ => Err(Bad(format!(
            "{}: the name says no format that is written; end it with .html or .glb",
            out.display()
        ))),
    }
}

/// The text of a file, or of the standard input.
fn text(path: &Path) -> Result<String, Bad> {
    let name = path.display();
    let fail = |e: std::io::Error| Bad(format!("{name}: {e}; check the path and its permissions"));
    if path.as_os_str() != "-" {
        return read_text(path).map_err(fail);
    }
    let mut text = String::new();
    let limited = std::io::stdin().lock().take(MAX_TEXT + 1);
    std::io::BufReader::new(limited)
        .read_to_string(&mut text)
        .map_err(fail)?;
    if text.len() as u64 > MAX_TEXT {
        return Err(Bad(format!(
            "standard input: more than {MAX_TEXT} bytes; give fewer queries"
        )));
    }
    Ok(text)
}

/// The queries of a text by their line numbers; blank lines are none.
fn lines(text: &str) -> impl Iterator<Item = NumberedLine> + '_ {
    let numbered = text.lines().enumerate();
    let filled = numbered.filter(|(_, line)| !line.trim().is_empty());
    filled.map(|(i, line)| (i + 1, QueryLine::parse(line).map_err(|e| e.to_string())))
}

fn one(args: &Args, file: &Path, fineness: &Fineness) -> Result<(View, usize), Bad> {
    // What is asked on the command line is checked before anything is made of it.
    let mut asked: Vec<NumberedLine> = Vec::new();
    for (flag, line) in args.probe.queries() {
        line.query()
            .map_err(|e| Bad(format!("{flag}: {e}; nothing was written")))?;
        asked.push((asked.len() + 1, Ok(line)));
    }
    let text = args.queries.as_deref().map(text).transpose()?;
    let text = text.unwrap_or_default();
    let model = match args.object {
        Some(_) => Model::load(file, args.object),
        None => Model::load_chosen(
            file,
            Choice {
                hidden: !args.skip_hidden,
                locked: !args.skip_locked,
            },
        ),
    };
    let model = model.map_err(|e| Bad(e.to_string()))?;
    let named = |e: String| Bad(format!("{}: {e}", file.display()));
    let name = file.file_name().unwrap_or(file.as_os_str());
    let mut view = View::new(&name.to_string_lossy(), &model, fineness).map_err(named)?;
    let mut engine = FeelerEngine::new(Options::default());
    let refused = view
        .ask(&model, &mut engine, asked.into_iter().chain(lines(&text)))
        .map_err(named)?;
    Ok((view, refused))
}

pub(crate) fn run(args: &Args) -> Result<Outcome, Bad> {
    let format = format(&args.out)?;
    let fineness = Fineness {
        chord: args.chord,
        degrees: args.angle,
        most: args.triangles,
    };
    let (view, refused) = match (&args.suite, &args.file) {
        (Some(name), _) if format == Format::Page => {
            let view = feeler_view::suite(&args.corpora, name, &fineness).map_err(Bad)?;
            (view, 0)
        }
        (Some(_), _) => {
            return Err(Bad(
                "--suite: binary glTF shows one model; write a page (.html)".into(),
            ));
        }
        (None, Some(file)) => one(args, file, &fineness)?,
        (None, None) => return Err(Bad("name a file, or a suite with --suite".into())),
    };
    let bytes = match format {
        Format::Page => view.page().into_bytes(),
        Format::Glb => view
            .glb()
            .map_err(|e| Bad(format!("{}: {e}", args.out.display())))?,
    };
    std::fs::write(&args.out, &bytes)
        .map_err(|e| Bad(format!("{}: cannot be written: {e}", args.out.display())))?;
    let count = |of: fn(&feeler_view::Part) -> usize| view.parts.iter().map(of).sum::<usize>();
    println!(
        "{}: {} faces, {} triangles, {} queries, {} bytes",
        args.out.display(),
        count(|p| p.faces.len()),
        count(|p| p.triangles.len()),
        view.queries.len(),
        bytes.len()
    );
    let notes = view.parts.iter().flat_map(|p| &p.notes);
    for note in notes.chain(&view.notes) {
        println!("  note: {note}");
    }
    let states = |state: &str| view.queries.iter().filter(|q| q.state == state).count();
    if refused > 0 {
        let first = view.queries.iter().find(|q| q.state == "refused");
        let what = first.map(|q| format!("query {}: {}", q.label, q.summary));
        eprintln!(
            "error: {}; {refused} refused, the others are shown",
            what.unwrap_or_default()
        );
        return Ok(Outcome::Refused);
    }
    Ok(
        match states("undecided") + states("wrong") + states("indeterminate") {
            0 => Outcome::Good,
            _ => Outcome::Short,
        },
    )
}
