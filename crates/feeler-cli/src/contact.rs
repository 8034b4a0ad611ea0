//! `feeler contact`.

use crate::{Bad, Outcome, write_error};
use clap::ValueEnum;
use feeler::query::Options;
use feeler_corpus::{
    AccuracyLine, Answer, Body, ContactsLine, Full, HalfSpaceLine, LineKindLine, LineLine, Model,
    QueryLine, SphereLine,
};
use feeler_gate::{Engine, FeelerEngine};
use feeler_io::Choice;
use serde::Deserialize;
use serde_json::{Value, json};
use std::io::{BufRead, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A line of standard input longer than this is refused: 1 MiB, far above any query.
const LONGEST_LINE: u64 = 1 << 20;

/// What queries are, for those who ask by lines.
const QUERIES: &str = r#"Queries, one a line:
  {"sphere": {"center": [x, y, z], "radius": r}}
  {"half_space": {"normal": [x, y, z], "offset": h}}
  {"line": {"origin": [x, y, z], "direction": [x, y, z], "kind": "line" | "ray" | "segment"}}
  {"inside": {"point": [x, y, z]}}
  {"side": {"face": 3, "uv": [u, v]}}
  {"evaluate": {"face": 3, "uv": [u, v]}}    u and v outside of the surface's domain are moved to its border first
  {"split": {"face": 3, "loop": 0, "trim": 1}}
Beside any: "id" (copied to the answer, also of a line that is refused), "accuracy" (a length or "full").
Beside sphere and half_space: "prediction", "contacts" ("deepest", "all", "none"), "velocity" with "until", "overlap": true.
Beside line: "hits" ("all", "first", "any"); t counts in lengths of the direction.
Beside what is in space: "pose": {"translation": [x, y, z], "rotation": [x, y, z, w]}.
An option beside a question that it means nothing to is refused."#;

#[derive(Debug, clap::Args)]
#[command(after_long_help = QUERIES)]
pub(crate) struct Args {
    /// The .3dm, .brep (OCCT, text) or .step file, or a model file of our own (.json, .json.gz).
    file: PathBuf,
    /// Ask about object N alone, as `feeler inspect` numbers them.
    #[arg(long, value_name = "N")]
    object: Option<usize>,
    /// Leave out hidden objects, and those on hidden layers.
    #[arg(long, conflicts_with = "object")]
    skip_hidden: bool,
    /// Leave out locked objects, and those on locked layers.
    #[arg(long, conflicts_with = "object")]
    skip_locked: bool,
    #[command(flatten)]
    probe: ProbeArgs,
    /// Width of the separation's enclosure: a length, or `full`.
    #[arg(long, value_name = "LENGTH", default_value = "full", value_parser = accuracy)]
    accuracy: AccuracyLine,
    /// Report contacts with separation up to this length.
    #[arg(
        long,
        value_name = "LENGTH",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    prediction: f64,
    /// Which contacts to report. With none, whether the nearest points are a continuum is not looked at, and the answer does not say.
    #[arg(long, value_enum, default_value_t = Which::Deepest)]
    contacts: Which,
}

/// Probes on the command line.
#[derive(Debug, clap::Args)]
pub(crate) struct ProbeArgs {
    /// A sphere: centre and radius.
    #[arg(long, value_name = "X,Y,Z,R", allow_hyphen_values = true, value_parser = numbers::<4>)]
    sphere: Option<[f64; 4]>,
    /// A half-space n.x <= h: outward unit normal and offset.
    #[arg(long, value_name = "NX,NY,NZ,H", allow_hyphen_values = true, value_parser = numbers::<4>)]
    half_space: Option<[f64; 4]>,
    /// A line: origin and direction.
    #[arg(long, value_name = "X,Y,Z,DX,DY,DZ", allow_hyphen_values = true, value_parser = numbers::<6>)]
    line: Option<[f64; 6]>,
    /// Which part of the line counts.
    #[arg(long, value_enum, default_value_t = Kind::Line, requires = "line")]
    kind: Kind,
    /// Ask when the sphere or half-space that moves so, in model units a unit of time, first comes within the prediction.
    #[arg(long, value_name = "VX,VY,VZ", allow_hyphen_values = true, value_parser = numbers::<3>, conflicts_with = "line")]
    velocity: Option<[f64; 3]>,
    /// Until when it moves; for ever if not given.
    #[arg(
        long,
        value_name = "TIME",
        requires = "velocity",
        allow_hyphen_values = true
    )]
    until: Option<f64>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Which {
    Deepest,
    All,
    None,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Kind {
    Line,
    Ray,
    Segment,
}

fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let all = text
        .split(',')
        .map(|x| x.trim().parse().map_err(|_| format!("`{x}` is no number")))
        .collect::<Result<Vec<f64>, _>>()?;
    let found = all.len();
    all.try_into()
        .map_err(|_| format!("{found} numbers, needed are {N} with commas between"))
}

fn accuracy(text: &str) -> Result<AccuracyLine, String> {
    let line = if text == "full" {
        AccuracyLine::Word(Full::Full)
    } else {
        AccuracyLine::Length(text.parse().map_err(|_| "a length or `full`".to_owned())?)
    };
    line.accuracy().map_err(|e| e.to_string())?;
    Ok(line)
}

impl ProbeArgs {
    /// The queries that the command line itself asks, with their flags.
    pub(crate) fn queries(&self) -> Vec<(&'static str, QueryLine)> {
        let mut all = Vec::new();
        let moving = QueryLine {
            velocity: self.velocity,
            until: self.until,
            ..QueryLine::default()
        };
        if let Some([x, y, z, radius]) = self.sphere {
            let sphere = Some(SphereLine {
                center: [x, y, z],
                radius,
            });
            let line = QueryLine {
                sphere,
                ..moving.clone()
            };
            all.push(("--sphere", line));
        }
        if let Some([x, y, z, offset]) = self.half_space {
            let half_space = Some(HalfSpaceLine {
                normal: [x, y, z],
                offset,
            });
            let line = QueryLine {
                half_space,
                ..moving.clone()
            };
            all.push(("--half-space", line));
        }
        if let Some([x, y, z, dx, dy, dz]) = self.line {
            let line = Some(LineLine {
                origin: [x, y, z],
                direction: [dx, dy, dz],
                kind: match self.kind {
                    Kind::Line => LineKindLine::Line,
                    Kind::Ray => LineKindLine::Ray,
                    Kind::Segment => LineKindLine::Segment,
                },
            });
            let line = QueryLine {
                line,
                ..QueryLine::default()
            };
            all.push(("--line", line));
        }
        all
    }
}

impl Args {
    fn options(&self) -> Result<Options, Bad> {
        if !self.prediction.is_finite() {
            return Err(Bad("--prediction: not finite; give a length".into()));
        }
        let contacts = match self.contacts {
            Which::Deepest => ContactsLine::Deepest,
            Which::All => ContactsLine::All,
            Which::None => ContactsLine::None,
        };
        Ok(Options {
            accuracy: self
                .accuracy
                .accuracy()
                .map_err(|e| Bad(format!("--accuracy: {e}")))?,
            prediction: self.prediction,
            contacts: contacts.into(),
            ..Options::default()
        })
    }
}

/// A line that is no query.
struct Unread {
    id: Option<Value>,
    error: String,
}

impl Unread {
    /// One that has no id to be told.
    fn nameless(error: String) -> Self {
        Self { id: None, error }
    }
}

fn read_query(line: &[u8]) -> Result<QueryLine, Unread> {
    let text = std::str::from_utf8(line).map_err(|e| Unread::nameless(e.to_string()))?;
    QueryLine::parse(text).map_err(|e| Unread {
        id: QueryLine::id_of(text),
        error: e.to_string(),
    })
}

/// Answers queries and remembers how it went.
struct Answering {
    engine: FeelerEngine,
    refused: Option<String>,
    refusals: usize,
    undecided: bool,
}

impl Answering {
    fn answer(&mut self, place: &str, line: Result<QueryLine, Unread>) -> Answer {
        let query = line.and_then(|line| {
            line.query().map_err(|e| Unread {
                id: line.id,
                error: e.to_string(),
            })
        });
        let answer = match query {
            Ok(query) => self.engine.answer(&query),
            Err(Unread { id, error }) => Answer {
                id,
                body: Body::Error { error },
            },
        };
        if let Body::Error { error } = &answer.body {
            self.refusals += 1;
            self.refused
                .get_or_insert_with(|| format!("{place}: {error}"));
        }
        self.undecided |= answer.body.undecided().is_some();
        answer
    }
}

pub(crate) fn run(args: &Args) -> Result<Outcome, Bad> {
    let options = args.options()?;
    let asked = args.probe.queries();
    let model = match args.object {
        Some(_) => Model::load(&args.file, args.object),
        None => Model::load_chosen(
            &args.file,
            Choice {
                hidden: !args.skip_hidden,
                locked: !args.skip_locked,
            },
        ),
    };
    let model = model.map_err(|e| Bad(e.to_string()))?;
    let mut answering = Answering {
        engine: FeelerEngine::new(options),
        refused: None,
        refusals: 0,
        undecided: false,
    };
    answering
        .engine
        .open(&model)
        .map_err(|e| Bad(format!("{}: {e}", args.file.display())))?;
    // Probes are checked before anything is written: a bad one is bad usage.
    for (flag, line) in &asked {
        line.query().map_err(|e| {
            Bad(format!(
                "{}: {flag}: {e}; nothing was asked",
                args.file.display()
            ))
        })?;
    }
    let mut out = BufWriter::new(std::io::stdout().lock());
    if asked.is_empty() {
        from_input(&mut answering, &mut out, false)?;
    } else {
        for (flag, line) in asked {
            let answer = answering.answer(flag, Ok(line));
            writeln!(out, "{}", answer.to_text()).map_err(write_error)?;
        }
    }
    out.flush().map_err(write_error)?;
    if let Some(first) = &answering.refused {
        let more = match answering.refusals {
            1 => String::new(),
            n => format!(" (and {} more)", n - 1),
        };
        eprintln!(
            "error: {}: {first}{more}; correct the query, the others were answered",
            args.file.display()
        );
        return Ok(Outcome::Refused);
    }
    Ok(if answering.undecided {
        Outcome::Short
    } else {
        Outcome::Good
    })
}

/// `feeler engine`: the query protocol from its first line on, for whoever starts the kernel as a program.
pub(crate) fn serve() -> Result<Outcome, Bad> {
    let mut first = String::new();
    std::io::Read::take(std::io::stdin().lock(), LONGEST_LINE)
        .read_line(&mut first)
        .map_err(|e| Bad(format!("standard input: {e}")))?;
    let mut out = BufWriter::new(std::io::stdout().lock());
    let (line, answering) = match opened(&first) {
        Ok((faces, answering)) => {
            let version = env!("CARGO_PKG_VERSION");
            let line = json!({"engine": "feeler", "version": version, "faces": faces});
            (line, Some(answering))
        }
        Err(error) => (json!({"error": error}), None),
    };
    writeln!(out, "{line}").map_err(write_error)?;
    out.flush().map_err(write_error)?;
    let Some(mut answering) = answering else {
        return Ok(Outcome::Refused);
    };
    from_input(&mut answering, &mut out, true)?;
    Ok(match (answering.refusals, answering.undecided) {
        (0, false) => Outcome::Good,
        (0, true) => Outcome::Short,
        _ => Outcome::Refused,
    })
}

/// The first line of the protocol.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FirstLine {
    model: String,
    object: Option<usize>,
    accuracy: Option<AccuracyLine>,
}

/// How it is written.
const FIRST_LINE: &str = r#"{"model": "PATH", "object": 0, "accuracy": 1e-9 or "full"}"#;

/// What the first line of the protocol names, and how many faces it has.
fn opened(first: &str) -> Result<(usize, Answering), String> {
    // serde would take a list for a structure's fields in order.
    let read = match first.trim_start().starts_with('[') {
        true => Err("a list".to_owned()),
        false => {
            serde_json::from_str::<FirstLine>(first.trim_end()).map_err(|e| match e.is_data() {
                true => e.to_string(),
                false => format!("not valid JSON: {e}"),
            })
        }
    };
    let line = read.map_err(|what| {
        // serde counts lines, and this is one.
        let what = what.replace(" at line 1 column ", ", column ");
        format!("the first line: {what}; write {FIRST_LINE}, of which only the model must be there")
    })?;
    let accuracy = line.accuracy.unwrap_or(AccuracyLine::Word(Full::Full));
    let options = Options {
        accuracy: accuracy.accuracy().map_err(|e| e.to_string())?,
        ..Options::default()
    };
    let model = Model::load(Path::new(&line.model), line.object).map_err(|e| e.to_string())?;
    let mut answering = Answering {
        engine: FeelerEngine::new(options),
        refused: None,
        refusals: 0,
        undecided: false,
    };
    answering.engine.open(&model)?;
    Ok((model.faces(), answering))
}

/// One answer a line, in order; a line that is refused gets its answer too. Flushed one by one where whoever asks
/// waits for each.
fn from_input(
    answering: &mut Answering,
    out: &mut impl Write,
    one_by_one: bool,
) -> Result<(), Bad> {
    let mut input = std::io::stdin().lock();
    let read_error = |e: std::io::Error| Bad(format!("standard input: {e}"));
    let mut number = 0;
    let mut bytes = Vec::new();
    loop {
        bytes.clear();
        let mut limited = std::io::Read::take(&mut input, LONGEST_LINE);
        let read = limited.read_until(b'\n', &mut bytes).map_err(read_error)?;
        if read == 0 {
            return Ok(());
        }
        number += 1;
        let ended = bytes.last() == Some(&b'\n');
        let line = if !ended && read as u64 == LONGEST_LINE {
            skip_line(&mut input).map_err(read_error)?;
            Err(Unread::nameless(format!(
                "longer than {LONGEST_LINE} bytes; write one object a line"
            )))
        } else {
            read_query(&bytes)
        };
        let answer = answering.answer(&format!("query line {number}"), line);
        writeln!(out, "{}", answer.to_text()).map_err(write_error)?;
        if one_by_one {
            out.flush().map_err(write_error)?;
        }
    }
}

fn skip_line(input: &mut impl BufRead) -> std::io::Result<()> {
    loop {
        let buffer = input.fill_buf()?;
        if buffer.is_empty() {
            return Ok(());
        }
        match buffer.iter().position(|b| *b == b'\n') {
            Some(at) => {
                input.consume(at + 1);
                return Ok(());
            }
            None => {
                let all = buffer.len();
                input.consume(all);
            }
        }
    }
}
