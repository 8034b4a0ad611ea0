//! Six thousand files of the corpus, each damaged in its own way: truncated, bits flipped, lengths and counts and numbers replaced, pieces moved,
//! said twice or blanked. Each loads or gives one clear line, at once. (`memory.rs` watches allocation.) `FEELER_DAMAGED=5000` asks for so many of
//! each format.

use crate::random::Random;
use feeler_io::{Document, ObjectKind, Problem, ReadError, read_3dm, read_brep, read_step};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How many of each kind.
const OF_3DM: u32 = 1_500;
const OF_3DM_MENDED: u32 = 1_500;
const OF_BREP: u32 = 2_000;
const OF_STEP: u32 = 1_000;

/// Files of at most this many bytes are damaged: reading them takes some milliseconds.
const SMALL: u64 = 50_000;
const LONG: Duration = Duration::from_secs(5);
/// How many checksums of a file are made to fit: more do not differ after a few changes.
const MENDED: usize = 64;

/// How many files of a kind are damaged: those said here, or as many as one asks for.
fn wanted(usual: u32) -> u32 {
    let asked = std::env::var("FEELER_DAMAGED").ok();
    asked.map_or(usual, |n| n.parse().expect("FEELER_DAMAGED is a number"))
}

fn files(extension: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpora/models");
    let mut open = vec![root];
    let mut found = Vec::new();
    while let Some(dir) = open.pop() {
        for entry in std::fs::read_dir(&dir)
            .expect("a folder of the corpus")
            .flatten()
        {
            let path = entry.path();
            let size = entry.metadata().map_or(0, |m| m.len());
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == extension) && size <= SMALL {
                found.push(path);
            }
        }
    }
    found.sort();
    let read = |p: PathBuf| {
        let bytes = std::fs::read(&p).expect("a file of the corpus");
        (p, bytes)
    };
    found.into_iter().map(read).collect()
}

const WILD: [[u8; 8]; 12] = [
    [0; 8],
    [0xFF; 8],
    [1, 0, 0, 0, 0, 0, 0, 0],
    [0xFF, 0xFF, 0xFF, 0x7F, 0, 0, 0, 0],
    [0, 0, 0, 0x80, 0, 0, 0, 0],
    [0, 0, 1, 0, 0, 0, 0, 0],
    [2, 0, 0, 0, 1, 0, 0, 0],
    // NaN, an infinity, the largest, the smallest, -1.
    [0, 0, 0, 0, 0, 0, 0xF8, 0x7F],
    [0, 0, 0, 0, 0, 0, 0xF0, 0x7F],
    [0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xEF, 0x7F],
    [1, 0, 0, 0, 0, 0, 0, 0x80],
    [0, 0, 0, 0, 0, 0, 0xF0, 0xBF],
];

/// One to four changes. Words of text are as good as bytes for this.
fn damage(bytes: &mut Vec<u8>, r: &mut Random) {
    for _ in 0..=r.below(4) {
        let at = r.below(bytes.len());
        let rest = bytes.len() - at;
        let size = (1 + r.below(64)).min(rest);
        match r.below(9) {
            0 => bytes.truncate(at.max(1)),
            1 | 2 => bytes[at] ^= 1 << r.below(8),
            3 | 4 => {
                let wild = WILD[r.below(WILD.len())];
                let size = [4, 8][r.below(2)].min(rest);
                bytes[at..at + size].copy_from_slice(&wild[..size]);
            }
            5 => {
                let piece = bytes[at..at + size].to_vec();
                let to = r.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            6 => drop(bytes.drain(at..at + size)),
            7 => bytes[at..at + size].fill(b'0'),
            _ => {
                // A piece written over another: lengths, counts and indices that are someone else's.
                let to = r.below(bytes.len() - size + 1);
                bytes.copy_within(at..at + size, to);
            }
        }
        if bytes.is_empty() {
            bytes.push(b' ');
        }
    }
}

#[derive(Default)]
struct Tally {
    errors: usize,
    refusals: usize,
    loaded: usize,
}

fn one_line(reason: &ReadError) {
    let text = reason.to_string();
    assert_eq!(text.lines().count(), 1, "{text}");
    assert!(!text.is_empty() && text.len() < 600, "{text}");
}

/// Whether an object, or one that a block reference places, was refused; all that was said is one line.
fn refused(kind: &ObjectKind) -> bool {
    match kind {
        ObjectKind::Refused { reason, .. } => {
            one_line(reason);
            true
        }
        ObjectKind::Brep(b) | ObjectKind::Surface(b) | ObjectKind::Extrusion(b) => {
            b.defects()
                .iter()
                .for_each(|d| assert!(!d.to_string().is_empty()));
            false
        }
        _ => false,
    }
}

impl Tally {
    fn take(&mut self, what: &str, read: impl FnOnce() -> Result<Document, ReadError>) {
        let start = Instant::now();
        let result = read();
        match &result {
            Err(reason) => {
                one_line(reason);
                self.errors += 1;
            }
            Ok(document) => {
                // What references place, one by one, is looked at too.
                let parts = (0..document.objects.len()).flat_map(|i| document.parts(i));
                let refusals = parts.filter(|p| refused(&p.kind)).count();
                if refusals > 0 {
                    self.refusals += 1;
                } else {
                    self.loaded += 1;
                }
            }
        }
        let time = start.elapsed();
        assert!(time < LONG, "{what}: {time:?}");
    }

    fn all(&self) -> usize {
        self.errors + self.refusals + self.loaded
    }
}

/// Makes the checksums of damaged chunks fit, one after the other, so that the damage gets past them.
pub(crate) fn mend(bytes: &mut [u8]) {
    let checksum = |reason: &ReadError| match reason {
        ReadError::Chunk { at, problem, .. } => match **problem {
            Problem::Checksum { computed, .. } => Some((*at, computed.to_le_bytes())),
            _ => None,
        },
        _ => None,
    };
    for _ in 0..MENDED {
        let found = match read_3dm(bytes) {
            Err(reason) => checksum(&reason),
            Ok(document) => document.objects.iter().find_map(|o| match &o.kind {
                ObjectKind::Refused { reason, .. } => checksum(reason),
                _ => None,
            }),
        };
        match found {
            Some((at, crc)) if bytes.get(at..at + 4).is_some_and(|old| old != crc) => {
                bytes[at..at + 4].copy_from_slice(&crc);
            }
            _ => return,
        }
    }
}

#[test]
fn six_thousand_damaged_files_load_or_say_one_line() {
    let rhino = files("3dm");
    let (occt, step) = (files("brep"), files("step"));
    let found = [rhino.len(), occt.len(), step.len()];
    assert!(found.iter().all(|n| *n >= 15), "{found:?}");
    let [mut raw, mut mended, mut text, mut entities] = [(); 4].map(|()| Tally::default());
    let (of_3dm, of_3dm_mended) = (wanted(OF_3DM), wanted(OF_3DM_MENDED));
    let (of_brep, of_step) = (wanted(OF_BREP), wanted(OF_STEP));
    for i in 0..of_3dm + of_3dm_mended {
        let mut r = Random(u64::from(i));
        r.next();
        let (path, whole) = &rhino[r.below(rhino.len())];
        let mut bytes = whole.clone();
        damage(&mut bytes, &mut r);
        let what = format!("{} {i}", path.display());
        if i < of_3dm {
            raw.take(&what, || read_3dm(&bytes));
        } else {
            mend(&mut bytes);
            mended.take(&what, || read_3dm(&bytes));
        }
    }
    for i in 0..of_brep {
        let mut r = Random(u64::from(i) + (1 << 32));
        r.next();
        let (path, whole) = &occt[r.below(occt.len())];
        let mut bytes = whole.clone();
        damage(&mut bytes, &mut r);
        text.take(&format!("{} {i}", path.display()), || read_brep(&bytes));
    }
    for i in 0..of_step {
        let mut r = Random(u64::from(i) + (1 << 33));
        r.next();
        let (path, whole) = &step[r.below(step.len())];
        let mut bytes = whole.clone();
        damage(&mut bytes, &mut r);
        entities.take(&format!("{} {i}", path.display()), || read_step(&bytes));
    }
    for (name, tally) in [
        (".3dm", &raw),
        (".3dm, checksums mended", &mended),
        (".brep", &text),
        (".step", &entities),
    ] {
        let Tally {
            errors,
            refusals,
            loaded,
        } = tally;
        println!("{name}: {errors} errors, {refusals} with refused objects, {loaded} loaded");
        // Each way out is taken: the damage neither misses all the time nor kills all at once.
        assert!(*errors > 20 && *loaded > 20, "{name}");
    }
    assert!(raw.refusals > 20 && mended.refusals > 20);
    assert_eq!(
        raw.all() + mended.all() + text.all() + entities.all(),
        (of_3dm + of_3dm_mended + of_brep + of_step) as usize
    );
}
