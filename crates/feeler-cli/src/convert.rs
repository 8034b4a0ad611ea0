//! `feeler convert`.

use crate::{Bad, Outcome, write_error};
use feeler_corpus::Model;
use feeler_io::{Document, Units, Written};
use std::io::Write;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .3dm, .brep (OCCT, text) or .step file, or a model file of our own (.json, .json.gz).
    file: PathBuf,
    /// The file to write, by its name: .3dm (version 5) or .brep (OCCT, text).
    out: PathBuf,
    /// Give all lengths in this unit (um, mm, cm, m, km, mil, in, ft, ...): coordinates are multiplied, and how far that rounds is said.
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    unit: Option<Units>,
}

fn unit(symbol: &str) -> Result<Units, String> {
    Units::from_symbol(symbol)
        .ok_or_else(|| "one of um, mm, cm, m, km, uin, mil, in, ft, mi is needed".to_owned())
}

/// What a file holds, whatever its format.
fn read(path: &Path) -> Result<Document, Bad> {
    if !Model::is_own(path) {
        return feeler_io::read_file(path).map_err(|e| Bad(e.to_string()));
    }
    let model = Model::load(path, None).map_err(|e| Bad(e.to_string()))?;
    Ok(Document::of_breps(model.breps))
}

pub(crate) fn run(args: &Args) -> Result<Outcome, Bad> {
    let extension = args.out.extension().map(|e| e.to_ascii_lowercase());
    let is_brep = extension.as_ref().is_some_and(|e| e == "brep");
    if !is_brep && extension.is_none_or(|e| e != "3dm") {
        return Err(Bad(format!(
            "{}: the name says no format that is written; end it with .3dm or .brep",
            args.out.display()
        )));
    }
    let write = if is_brep {
        feeler_io::write_brep
    } else {
        feeler_io::write_3dm
    };
    let mut document = read(&args.file)?;
    let from = document.units.to_string();
    let in_units = match &document.units {
        Units::None => String::new(),
        units => format!(" {units}"),
    };
    let scaled = match &args.unit {
        Some(unit) => document.convert_units(unit.clone()),
        None => Ok(0.0),
    };
    let scaled = scaled.map_err(|e| Bad(format!("{}: {e}", args.file.display())))?;
    let written = write(&document).map_err(|e| Bad(format!("{}: {e}", args.file.display())))?;
    // What is off before it is moved is off by that where it is moved to: the first bound says so.
    let off = scaled + written.off;
    // The nearest two digits are off by half of the last, a twentieth at most.
    let up = off * 1.0501;
    let mut lines = Vec::new();
    match &args.unit {
        Some(unit) if off > 0.0 => lines.push(format!(
            "lengths from {from} to {unit}: rounded, points off by no more than {up:.1e} {unit}"
        )),
        Some(unit) => lines.push(format!("lengths from {from} to {unit}: nothing is rounded")),
        None if off > 0.0 => lines.push(format!(
            "moved to where block references put it: rounded, points off by no more than {up:.1e}{in_units}"
        )),
        None => {}
    }
    let Written {
        bytes,
        notes,
        objects,
        ..
    } = written;
    std::fs::write(&args.out, &bytes)
        .map_err(|e| Bad(format!("{}: cannot be written: {e}", args.out.display())))?;
    let units = match (&document.units, is_brep) {
        (Units::None, true) => "no units".to_owned(),
        // The format has none.
        (units, true) => format!("no units (were {units})"),
        (units, false) => format!("units {units}"),
    };
    lines.push(format!(
        "{}: {objects} objects, {units}, {} bytes",
        args.out.display(),
        bytes.len()
    ));
    lines.extend(notes.into_iter().map(|n| format!("  note: {n}")));
    let mut out = std::io::stdout().lock();
    let text = lines.join("\n") + "\n";
    out.write_all(text.as_bytes()).map_err(write_error)?;
    Ok(Outcome::Good)
}
