//! `cargo xtask plant`: mistakes put into the kernel one at a time, and who notices.
//!
//! The mistakes stand in `plants.txt`. All are put into a copy of the tree (`target/plant/tree`) at once, each behind a switch that an
//! environment variable sets, so that the copy is built once and a mistake costs only the asking: mutant schemata (R. H. Untch, A. J.
//! Offutt, M. J. Harrold, ISSTA 1993). The kernel itself has no such switch. `--rebuild` builds the copy for each mistake alone instead,
//! without switches: the check on the switches.
//!
//! Four watchers are asked: the kernel's unit tests, its property tests and tests of whole queries, the fuzz targets on some inputs, and the gate, suite
//! by suite, with a sample of its queries, and with all where fewer than two noticed. Each is ended at the first thing it finds wrong, and starts with what takes least.

mod text;
mod watch;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use text::{Form, Plant, plants};
pub(crate) use watch::{MEMORY, artifacts};
use watch::{SWITCH, WATCHERS, Watcher};
use xtask_test::root;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Only mistakes whose words hold this, or one of these.
    #[arg(long)]
    only: Vec<String>,
    /// Only list them.
    #[arg(long)]
    list: bool,
    /// Inputs of each fuzz target.
    #[arg(long, default_value_t = 150)]
    inputs: usize,
    /// Build for each mistake alone, without switches: takes long.
    #[arg(long)]
    rebuild: bool,
    /// Where to write the table, too.
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
}

const PLANTS: &str = include_str!("../plants.txt");

/// Who noticed what, by watcher.
type Noticed = [Option<String>; 4];

pub(crate) fn run(args: &Args) -> Result<(), String> {
    let all = plants(PLANTS)?;
    let is_chosen = |p: &Plant<'_>| {
        args.only.is_empty() || args.only.iter().any(|o| p.name.contains(o.as_str()))
    };
    if args.list {
        for p in all.iter().filter(|p| is_chosen(p)) {
            println!("{}", p.name);
        }
        return Ok(());
    }
    let place = root().join("target/plant");
    let tree = place.join("tree");
    let numbered = || (1..).zip(&all);
    let switched = numbered().map(|(n, p)| (p, Form::Switched(n)));
    println!("==> build, and without a mistake");
    let mut watchers = build(args, &place, switched)?;
    for watcher in &mut watchers {
        watcher.settle(&tree)?;
    }
    watchers.sort_by_key(|w| (w.of, w.is_late, w.usual()));
    for (i, name) in WATCHERS.iter().enumerate() {
        let all = watchers.iter().filter(|w| w.of == i);
        let seconds = |w: &Watcher| w.usual().as_secs_f64();
        let (late, soon): (Vec<&Watcher>, Vec<&Watcher>) = all.partition(|w| w.is_late);
        let sum = |some: &[&Watcher]| {
            some.iter()
                .map(|w| seconds(w))
                .fold(0.0, std::ops::Add::add)
        };
        println!("{name}: {:.0} s, then {:.0} s", sum(&soon), sum(&late));
    }
    let mut table: Vec<(&str, Noticed)> = Vec::new();
    for (n, plant) in numbered().filter(|(_, p)| is_chosen(p)) {
        let begun = Instant::now();
        if args.rebuild {
            build(args, &place, [(plant, Form::Wrong)])
                .map_err(|e| format!("`{}`: {e}", plant.name))?;
        }
        let mut noticed = Noticed::default();
        for w in &watchers {
            let enough = w.is_late && noticed.iter().flatten().count() >= 2;
            if noticed[w.of].is_none() && !enough {
                noticed[w.of] = w.ask(&tree, n)?;
            }
        }
        println!("{} ({:.0} s)", plant.name, begun.elapsed().as_secs_f64());
        for (name, by) in WATCHERS.iter().zip(&noticed) {
            println!("    {name:<10}{}", by.as_deref().unwrap_or("-"));
        }
        table.push((plant.name, noticed));
    }
    let (text, few) = summary(&table);
    print!("\n{text}");
    if let Some(path) = &args.table {
        std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    if few.is_empty() {
        Ok(())
    } else {
        Err(format!("noticed by fewer than two: {}", few.join("; ")))
    }
}

/// The copy with mistakes in it, built: who may be asked.
fn build<'a>(
    args: &Args,
    place: &Path,
    chosen: impl IntoIterator<Item = (&'a Plant<'a>, Form)>,
) -> Result<Vec<Watcher>, String> {
    let tree = place.join("tree");
    let mut planted = text::planted(chosen, read)?;
    const KERNEL: &str = "crates/feeler/src/lib.rs";
    planted.insert(KERNEL, read(KERNEL)? + &switch());
    lay(&tree, &planted)?;
    watch::build(&tree, &place.join("build"), args.inputs)
}

/// The table in Markdown, and the mistakes noticed by fewer than two.
fn summary<'a>(table: &[(&'a str, Noticed)]) -> (String, Vec<&'a str>) {
    let mut text = format!(
        "| mistake | {} |\n|---|---|---|---|---|\n",
        WATCHERS.join(" | ")
    );
    let (mut each, mut few) = ([0; 4], Vec::new());
    let mut by_count: BTreeMap<usize, usize> = BTreeMap::new();
    for (name, noticed) in table {
        let marks = noticed.each_ref().map(|by| by.is_some());
        text += &format!("| {name} ");
        for (i, mark) in marks.iter().enumerate() {
            text += if *mark { "| x " } else { "| " };
            each[i] += usize::from(*mark);
        }
        text += "|\n";
        let count = marks.iter().filter(|m| **m).count();
        *by_count.entry(count).or_default() += 1;
        if count < 2 {
            few.push(*name);
        }
    }
    text += &format!("| of {} ", table.len());
    text += &each.map(|n| format!("| {n} ")).concat();
    text += "|\n\nNoticed by so many of the four:";
    for (count, n) in by_count.iter().rev() {
        text += &format!(" {count}: {n};");
    }
    (text.trim_end_matches(';').to_owned() + ".\n", few)
}

/// A file of the tree as it is.
pub(crate) fn read(name: &str) -> Result<String, String> {
    std::fs::read_to_string(root().join(name)).map_err(|e| format!("{name}: {e}"))
}

/// Lays out the tracked files, and those not yet tracked, with some changed. A file that is the same stays as it is, so that nothing is built for it.
pub(crate) fn lay(tree: &Path, changed: &BTreeMap<&str, String>) -> Result<(), String> {
    let root = root();
    let listed = Command::new("git")
        .args([
            "ls-files",
            "--cached",
            "--others",
            "--exclude-standard",
            "-z",
        ])
        .current_dir(&root)
        .output()
        .map_err(|e| format!("git cannot be started: {e}"))?;
    let listed = String::from_utf8_lossy(&listed.stdout);
    for name in listed.split('\0').filter(|n| !n.is_empty()) {
        let to = tree.join(name);
        let bytes = match changed.get(name) {
            Some(text) => text.clone().into_bytes(),
            None => match std::fs::read(root.join(name)) {
                Ok(bytes) => bytes,
                Err(_) => continue,
            },
        };
        if std::fs::read(&to).is_ok_and(|old| old == bytes) {
            continue;
        }
        let io = |e: std::io::Error| format!("{}: {e}", to.display());
        std::fs::create_dir_all(to.parent().unwrap_or(tree)).map_err(io)?;
        std::fs::write(&to, bytes).map_err(io)?;
    }
    Ok(())
}

/// What the scratch copy's kernel asks.
fn switch() -> String {
    format!(
        "\n#[inline]\npub(crate) fn planted(n: usize) -> bool {{\n    \
         static ON: std::sync::LazyLock<usize> = std::sync::LazyLock::new(|| {{\n        \
         let value = std::env::var(\"{SWITCH}\");\n        \
         value.ok().and_then(|v| v.parse().ok()).unwrap_or(0)\n    }});\n    *ON == n\n}}\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mistake_finds_its_lines_and_all_fit_together() {
        let all = plants(PLANTS).unwrap();
        assert!(all.len() >= 30, "{}", all.len());
        let read =
            |file: &str| std::fs::read_to_string(root().join(file)).map_err(|e| e.to_string());
        for plant in &all {
            for (file, text) in text::planted([(plant, Form::Wrong)], read).unwrap() {
                assert_ne!(text, read(file).unwrap(), "{}", plant.name);
            }
        }
        let together = all.iter().enumerate().map(|(n, p)| (p, Form::Switched(n)));
        for (file, text) in text::planted(together, read).unwrap() {
            if let Err(e) = syn::parse_file(&text) {
                panic!("{file}, line {}: {e}", e.span().start().line);
            }
        }
    }

    #[test]
    fn the_table_counts() {
        let by = |who: [bool; 4]| who.map(|w| w.then(|| "it".to_owned()));
        let table = [
            ("a", by([true, false, false, true])),
            ("b", by([false, false, true, false])),
        ];
        let (text, few) = summary(&table);
        assert!(
            text.contains("| a | x | | | x |\n| b | | | x | |\n| of 2 | 1 | 0 | 1 | 1 |"),
            "{text}"
        );
        assert!(text.ends_with(" 2: 1; 1: 1.\n"), "{text}");
        assert_eq!(few, ["b"]);
    }
}
