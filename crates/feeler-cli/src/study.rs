//! `feeler study`.

use crate::{Bad, Outcome, write_error};
use feeler_gate::census::Census;
use feeler_io::{Format, ObjectKind, read_file};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::Write;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A folder of .3dm, .brep (.brp) and .step (.stp) files, looked through with all folders in it.
    folder: PathBuf,
    /// Where `study.md` and `study.svg` go.
    #[arg(long, default_value = "target/study")]
    out: PathBuf,
}

/// Names of files that are read, in lower case.
const ENDINGS: [&str; 5] = ["3dm", "brep", "brp", "step", "stp"];

/// The files of a folder and the folders in it, in order. Links to folders are not followed: they may lead back.
fn parts(folder: &Path) -> Result<Vec<PathBuf>, Bad> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        let fail = |e: std::io::Error| {
            let name = folder.display();
            Bad(format!("{name}: {e}; name a folder that can be read"))
        };
        for entry in std::fs::read_dir(&folder).map_err(fail)? {
            let entry = entry.map_err(fail)?;
            let path = entry.path();
            if entry.file_type().map_err(fail)?.is_dir() {
                open.push(path);
                continue;
            }
            let ending = path.extension().map(|e| e.to_ascii_lowercase());
            if ending.is_some_and(|e| ENDINGS.iter().any(|own| e == *own)) && path.is_file() {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

fn add(census: &mut Census, path: &Path) {
    let document = match read_file(path) {
        Ok(document) => document,
        Err(why) => return census.unreadable(why.to_string()),
    };
    census.file();
    for object in &document.objects {
        match &object.kind {
            ObjectKind::Brep(brep) | ObjectKind::Surface(brep) | ObjectKind::Extrusion(brep) => {
                census.brep(brep);
            }
            // Only a .3dm has references of its own; those of assemblies and compounds are made in reading.
            ObjectKind::Block { .. } if document.format != Format::Rhino => {}
            ObjectKind::Refused { class, .. } => census.other(format!("refused: {class}")),
            other => census.other(other.name()),
        }
    }
}

pub(crate) fn run(args: &Args) -> Result<Outcome, Bad> {
    let parts = parts(&args.folder)?;
    if parts.is_empty() {
        return Err(Bad(format!(
            "{}: no .3dm, .brep, .brp, .step or .stp file in it; name a folder of parts",
            args.folder.display()
        )));
    }
    // indicatif draws on a terminal only.
    let bar = ProgressBar::new(parts.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{msg} {bar:30} {pos}/{len}") {
        bar.set_style(style);
    }
    let mut census = Census::new();
    for path in &parts {
        let name = path.file_name().unwrap_or(path.as_os_str());
        bar.set_message(name.to_string_lossy().into_owned());
        add(&mut census, path);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let text = census.markdown();
    let page = format!("{text}\n![Uses of surfaces and curves](study.svg)\n");
    for (name, content) in [("study.svg", census.svg()), ("study.md", page)] {
        let path = args.out.join(name);
        std::fs::create_dir_all(&args.out)
            .and_then(|()| std::fs::write(&path, content))
            .map_err(|e| {
                let path = path.display();
                Bad(format!("{path}: {e}; name another folder with --out"))
            })?;
    }
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).map_err(write_error)?;
    writeln!(
        out,
        "\nSee {} for the plot",
        args.out.join("study.svg").display()
    )
    .map_err(write_error)?;
    Ok(Outcome::Good)
}
