//! `cargo xtask tidy`: clang-format and clang-tidy over `cpp/`.

use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use xtask_test::root;

/// What both programs are, and how to get them.
const REMEDY: &str = "install it (on Debian: apt-get install clang-format clang-tidy)";

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Only these files of `cpp/`, by their names; a file takes some 18 s of a core, all 61 some 20 min.
    files: Vec<String>,
}

pub(crate) fn run(args: &Args) -> Result<(), String> {
    let root = root();
    format(&root)?;
    tidy(&root, &args.files)
}

/// The C++ of the oracle with this extension, by name.
fn sources(root: &Path, extensions: &[&str]) -> Result<Vec<PathBuf>, String> {
    let folder = root.join("cpp");
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut all: Vec<PathBuf> = entries
        .filter_map(|e| e.ok().map(|e| e.path()))
        .filter(|p| {
            p.extension()
                .is_some_and(|e| extensions.iter().any(|x| e == *x))
        })
        .collect();
    all.sort();
    Ok(all)
}

/// Whether every file is as clang-format writes it.
pub(crate) fn format(root: &Path) -> Result<(), String> {
    let status = Command::new("clang-format")
        .args(["--dry-run", "-Werror"])
        .args(sources(root, &["cpp", "hpp"])?)
        .status()
        .map_err(|e| format!("clang-format cannot be started: {e}; {REMEDY}"))?;
    if status.success() {
        Ok(())
    } else {
        Err("run `clang-format -i cpp/*.cpp cpp/*.hpp`".to_owned())
    }
}

fn tidy(root: &Path, only: &[String]) -> Result<(), String> {
    let mut files = sources(root, &["cpp"])?;
    if !only.is_empty() {
        let is = |p: &PathBuf, name: &String| p.file_name().is_some_and(|f| f == name.as_str());
        if let Some(none) = only.iter().find(|n| !files.iter().any(|p| is(p, n))) {
            return Err(format!(
                "cpp/ has no source {none}; name files as in `distance.cpp`"
            ));
        }
        files.retain(|p| only.iter().any(|n| is(p, n)));
    }
    let include = bridge_includes(root)?;
    let bar = ProgressBar::new(files.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("clang-tidy {bar:30} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    let next = AtomicUsize::new(0);
    let complaints = Mutex::new(Vec::new());
    let work = || {
        while let Some(file) = files.get(next.fetch_add(1, Ordering::Relaxed)) {
            let output = Command::new("clang-tidy")
                .arg("--quiet")
                .arg(file)
                .arg("--")
                .args(["-std=c++17", "-frounding-math", "-ffp-contract=off"])
                .args(["-DCGAL_USE_MPFI=1", "-DCGAL_LICENSE_ERROR=1"])
                .arg(format!("-I{}", root.join("cpp").display()))
                .args(include.iter().map(|i| format!("-isystem{}", i.display())))
                .output();
            let complaint = match output {
                Ok(o) if o.status.success() => None,
                Ok(o) => Some(String::from_utf8_lossy(&o.stdout).into_owned()),
                Err(e) => Some(format!("clang-tidy cannot be started: {e}; {REMEDY}")),
            };
            if let Ok(mut all) = complaints.lock() {
                all.extend(complaint);
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
    let complaints = complaints.into_inner().unwrap_or_default();
    if complaints.is_empty() {
        println!("clang-tidy: nothing to say about {} files", files.len());
        Ok(())
    } else {
        Err(format!("clang-tidy:\n{}", complaints.join("\n")))
    }
}

/// Where the build put the headers that cxx makes.
fn bridge_includes(root: &Path) -> Result<Vec<PathBuf>, String> {
    let build = root.join("target/release/build");
    let newest = std::fs::read_dir(&build)
        .into_iter()
        .flatten()
        .filter_map(|e| e.ok().map(|e| e.path().join("out/cxxbridge/include")))
        .filter(|p| p.join("feeler-oracle").exists())
        .max_by_key(|p| p.metadata().and_then(|m| m.modified()).ok());
    newest.map(|p| vec![p]).ok_or_else(|| {
        "the oracle is not built; run `cargo build --release -p feeler-oracle --features cgal`"
            .to_owned()
    })
}
