//! How much memory a prepared BREP holds once balls have come near each of its faces, at an accuracy of 1e-12 of the size and then at
//! full: patches, boundary pieces, products, images of trims, the BREP itself. A test binary of its own, as the allocator counts for all
//! threads.
//!
//! The aim is [`AIM`] bytes for each byte of the file. When it has been prepared no model takes more (one that is placed so often that the file does not hold it so
//! many times, [`PLACED`], counts once for each place). After the queries some do: which, how much more, and why stands in `prepared_memory.txt`, small files alone. A BREP
//! that is told so gives back what is beyond: no model takes more than the aim then, or than its BREPs took before the first query.

use feeler::numeric::Interval;
use feeler::prepare::PreparedBrep;
use feeler::query::{Accuracy, Options, Probe, Sphere, Workspace, contact, evaluate};
use feeler_corpus::{Model, read_text};
use nalgebra::{Point2, Vector3};
use peak_alloc::PeakAlloc;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Bytes held for each byte of the file.
const AIM: f64 = 20.0;
/// Files that place what they hold at several places, each of which is a BREP of its own; and how many.
const PLACED: [(&str, usize); 1] = [("brep/placed.brep", 5)];
/// Small files may take more than the aim, but not more bytes than this.
const SMALL: usize = 4_000_000;
/// A stored figure may grow so much, as the places that are asked about may see a patch more.
const ROOM: f64 = 1.05;
/// A figure below this part of the stored one is worth storing.
const WORTH_STORING: f64 = 0.9;

/// At the coarser accuracy, so many places along u and v of each face's domain...
const PLACES: usize = 2;
/// ...and at full, which takes far longer.
const FULL_PLACES: usize = 1;
/// So far off the face, and so large a ball, as a part of the model's size.
const OFF: f64 = 1e-3;
/// So many sides are asked for each edge before they are kept, and some.
const OFTEN: usize = 5;
/// The coarser accuracy, as a part of the size.
const COARSE: f64 = 1e-12;

/// Bytes of a file; of a compressed one, of its text.
fn size_of_file(path: &Path) -> usize {
    let compressed = path.extension().is_some_and(|e| e == "gz");
    let size = if compressed {
        read_text(path).map(|text| text.len())
    } else {
        std::fs::read(path).map(|bytes| bytes.len())
    };
    size.expect("a file of the corpus")
}

/// All files in a folder and those in it, in order.
fn files(folder: &Path, out: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).expect("a folder of the corpus");
    let mut entries: Vec<PathBuf> = entries.map(|e| e.expect("an entry").path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            files(&path, out);
        } else {
            out.push(path);
        }
    }
}

/// Balls near each face, trimmed away there or not: what is next to a hole is met at its border.
fn come_near(brep: &PreparedBrep, accuracy: Accuracy, places: usize) {
    let mut workspace = Workspace::default();
    let options = Options {
        prediction: f64::INFINITY,
        accuracy,
        ..Options::default()
    };
    let at =
        |d: Interval, k: usize| d.start + (d.end - d.start) * ((k as f64 + 0.5) / places as f64);
    let off = OFF * brep.size();
    for face in 0..brep.brep().faces().len() {
        let [u, v] = brep.brep().surface(face).domain();
        for k in 0..places * places {
            let uv = Point2::new(at(u, k / places), at(v, k % places));
            let p = evaluate(brep, face, uv).expect("a face");
            let normal = p.du.cross(&p.dv).try_normalize(0.0);
            let center = p.point + normal.unwrap_or(Vector3::z()) * off;
            if let Ok(ball) = Sphere::new(center, off) {
                contact(brep, &Probe::Sphere(ball), &options, &mut workspace);
            }
        }
    }
}

/// One ball so often that what is only worth while for many is made, too: of closed BREPs cells that keep sides of points, and for these the widths of all cracks.
fn ask_often(brep: &PreparedBrep) {
    if !brep.brep().is_closed() {
        return;
    }
    let mut workspace = Workspace::default();
    let options = Options {
        accuracy: Accuracy::Length(COARSE * brep.size()),
        ..Options::default()
    };
    let [u, v] = brep.brep().surface(0).domain();
    let p = evaluate(brep, 0, Point2::new(u.mid(), v.mid())).expect("a face");
    // Within the box of all faces, or one of both is.
    for side in [-1.0, 1.0] {
        let center = p.point + Vector3::repeat(side * OFF * brep.size());
        let ball = Sphere::new(center, 0.0).expect("a ball");
        for _ in 0..OFTEN * brep.brep().parts().edges.len() {
            contact(brep, &Probe::Sphere(ball), &options, &mut workspace);
        }
    }
}

/// Bytes that the model's prepared BREPs hold: before the first query, after all, and once they have given back what is beyond the aim for a file of that size; `None`
/// for a file that is none.
fn held(path: &Path, size: usize) -> Option<[usize; 3]> {
    let before = ALLOCATOR.current_usage();
    let held = || ALLOCATOR.current_usage().saturating_sub(before);
    let breps = Model::load(path, None).ok()?.breps;
    let mut prepared: Vec<PreparedBrep> = breps.into_iter().map(PreparedBrep::new).collect();
    let first = held();
    for brep in &prepared {
        come_near(brep, Accuracy::Length(COARSE * brep.size()), PLACES);
        come_near(brep, Accuracy::Full, FULL_PLACES);
        ask_often(brep);
    }
    let all = held();
    for brep in &mut prepared {
        let beyond = held().saturating_sub((AIM * size as f64) as usize);
        if beyond > 0 {
            brep.shrink_to(brep.bytes().saturating_sub(beyond));
        }
    }
    Some([first, all, held()])
}

/// The stored figures by model.
fn stored() -> BTreeMap<String, f64> {
    let lines = include_str!("prepared_memory.txt").lines();
    let lines = lines.filter(|l| !l.starts_with('#') && !l.is_empty());
    let one = |line: &str| {
        let (figure, model) = line.trim().split_once(' ')?;
        Some((model.to_owned(), figure.parse().ok()?))
    };
    lines
        .map(|l| one(l).unwrap_or_else(|| panic!("prepared_memory.txt: `{l}`")))
        .collect()
}

#[test]
fn a_prepared_brep_takes_no_more_than_20_times_its_file_or_what_is_known() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpora/models");
    let mut all = Vec::new();
    files(&folder, &mut all);
    let mut stored = stored();
    let (mut table, mut more, mut count) = (String::new(), Vec::new(), 0);
    let (mut unshrunk, mut large, mut at_first) = (Vec::new(), Vec::new(), Vec::new());
    for path in all {
        let size = size_of_file(&path);
        let Some([first, held, kept]) = held(&path, size) else {
            continue;
        };
        count += 1;
        let name = path.strip_prefix(&folder).expect("a file in it");
        let name = name.to_string_lossy().into_owned();
        if held > SMALL.max((AIM * size as f64) as usize) {
            large.push(format!("{name}: {held} bytes of {size}"));
        }
        let places = PLACED.iter().find(|(file, _)| *file == name);
        let [first, figure, kept] = [first, held, kept].map(|bytes| bytes as f64 / size as f64);
        if first > AIM * places.map_or(1.0, |(_, places)| *places as f64) {
            at_first.push(format!("{name}: {first:.1}"));
        }
        if kept > AIM.max(first) {
            unshrunk.push(format!(
                "{name}: {kept:.1} of {figure:.1}, {first:.1} at first"
            ));
        }
        let known = stored.remove(&name);
        if figure > AIM {
            table += &format!("{figure:.1} {name}\n");
        }
        if figure > AIM.max(known.unwrap_or(0.0) * ROOM) {
            more.push(format!(
                "{name}: {figure:.1} bytes a byte of the file, {} are known",
                known.unwrap_or(AIM)
            ));
        } else if known.is_some_and(|k| figure < k * WORTH_STORING) {
            println!("{name}: {figure:.1} bytes a byte of the file: less than is stored");
        }
    }
    assert!(count > 300, "{count} models");
    assert!(large.is_empty(), "more than {SMALL}: {large:#?}");
    assert!(at_first.is_empty(), "once prepared: {at_first:#?}");
    assert!(unshrunk.is_empty(), "not given back: {unshrunk:#?}");
    more.extend(stored.keys().map(|gone| format!("{gone}: no such model")));
    assert!(
        more.is_empty(),
        "{}\nthe lines of tests/prepared_memory.txt as they are now:\n{table}",
        more.join("\n")
    );
}
