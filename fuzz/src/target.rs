//! The targets: what bytes are put to.

use crate::check::{Distances, Effort, answer, distances, examine};
use crate::scene::{Kind, Scene};
use crate::source::Source;
use crate::words::{mutated_brep, mutated_step};
use feeler::prepare::PreparedBrep;
use feeler::query::Workspace;
use feeler_corpus::{Answer, QueryLine};
use feeler_io::{Document, ObjectKind, Problem, ReadError, read_3dm, read_brep, read_step};
use feeler_oracle::{Oracle, OracleError};
use std::fmt::Write as _;

/// What became of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It made nothing to check.
    Rejected,
    /// Nothing was found.
    Checked,
}

/// A target.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name, as that of the program.
    pub name: &'static str,
    /// What it makes scenes of, if it does.
    pub kind: Option<Kind>,
    /// Bytes that an input may take.
    pub memory: usize,
    body: fn(&[u8]) -> Result<Outcome, String>,
}

/// 256 MB: some tens of times what the largest scenes of 16 kB take.
const MEMORY: usize = 256 << 20;

macro_rules! scenes {
    ($($name:literal $kind:ident)*) => {
        [$(Target {
            name: $name,
            kind: Some(Kind::$kind),
            memory: MEMORY,
            body: |bytes| scene(Kind::$kind, bytes),
        }),*]
    };
}

/// All targets that make scenes.
const SCENES: [Target; 6] = scenes! {
    "side" Side
    "sphere" Sphere
    "half_space" HalfSpace
    "line" Line
    "evaluate" Evaluate
    "split" Split
};

const fn other(name: &'static str, body: fn(&[u8]) -> Result<Outcome, String>) -> Target {
    Target {
        name,
        kind: None,
        memory: MEMORY,
        body,
    }
}

/// All targets.
pub const TARGETS: [Target; 11] = [
    SCENES[0],
    SCENES[1],
    SCENES[2],
    SCENES[3],
    SCENES[4],
    SCENES[5],
    other("read_3dm", read),
    other("read_brep", |bytes| {
        read_text(bytes, b"CASCADE Topology V", mutated_brep, read_brep)
    }),
    other("read_step", |bytes| {
        read_text(bytes, b"ISO-10303-21", mutated_step, read_step)
    }),
    other("queries", queries),
    other("oracle_boundary", oracle_boundary),
];

/// The target of this name.
pub fn target(name: &str) -> Option<Target> {
    TARGETS.into_iter().find(|t| t.name == name)
}

impl Target {
    /// Gives it an input.
    ///
    /// # Panics
    /// With what was found.
    pub fn run(&self, bytes: &[u8]) -> Outcome {
        match (self.body)(bytes) {
            Ok(outcome) => outcome,
            Err(found) => panic!("{}: {found}", self.name),
        }
    }

    /// Whether an input is one of those given to the second method whole.
    pub fn is_whole(&self, bytes: &[u8]) -> bool {
        let scene = self.kind.and_then(|k| Scene::decode(k, bytes));
        effort(bytes) == Effort::Full && scene.is_some()
    }

    /// How well the second method knows the distances that an input asks for: milliseconds to a second each.
    pub fn distances(&self, bytes: &[u8]) -> Distances {
        let scene = self.kind.and_then(|k| Scene::decode(k, bytes));
        scene.as_ref().map(distances).unwrap_or_default()
    }

    /// The same, with what was found as a value (panics are still panics).
    ///
    /// # Errors
    /// What was found.
    pub fn try_run(&self, bytes: &[u8]) -> Result<Outcome, String> {
        (self.body)(bytes)
    }
}

/// One input in this many is given to the second method whole.
const WHOLE: u64 = 100;
/// Of one file in this many that a reader takes the BREPs are asked: preparing and asking them takes as long as reading or longer, and tells of the
/// kernel more than of the reader. Which ones hangs on the bytes, so that an input is always treated alike.
const ASKED_OF: u64 = 16;

/// FNV-1a.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h: u64, b| {
        (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3)
    })
}

fn effort(bytes: &[u8]) -> Effort {
    if hash(bytes).is_multiple_of(WHOLE) {
        Effort::Full
    } else {
        Effort::Loop
    }
}

fn scene(kind: Kind, bytes: &[u8]) -> Result<Outcome, String> {
    let Some(scene) = Scene::decode(kind, bytes) else {
        return Ok(Outcome::Rejected);
    };
    let effort = effort(bytes);
    match examine(&scene, effort) {
        Ok(()) => Ok(Outcome::Checked),
        Err((i, why)) => Err(format!("{why}\n{}", scene.queries[i].to_text())),
    }
}

/// Reads bytes as a file, the checksums mended, or no input would get past them.
fn read(input: &[u8]) -> Result<Outcome, String> {
    const MENDED: usize = 64;
    const MAGIC: &[u8] = b"3D Geometry File Format ";
    let mut bytes = if input.windows(MAGIC.len()).any(|w| w == MAGIC) {
        input.to_vec()
    } else {
        // What has no header gets one: of version 4 or 5, whose chunks differ in the length of their lengths.
        let version: &[u8] = match input.first() {
            Some(b) if b & 1 == 1 => b"       4",
            _ => b"      50",
        };
        [MAGIC, version, input].concat()
    };
    for _ in 0..MENDED {
        let found = read_3dm(&bytes);
        // All that one reading tells, or a file of many objects is read as often.
        let wrong: Vec<(usize, [u8; 4])> = match &found {
            Err(e) => checksum(e).into_iter().collect(),
            Ok(document) => { document.objects.iter() }
                .filter_map(|o| match &o.kind {
                    ObjectKind::Refused { reason, .. } => checksum(reason),
                    _ => None,
                })
                .collect(),
        };
        let mut mended = false;
        for (at, crc) in wrong {
            if let Some(old) = bytes.get_mut(at..at + 4)
                && *old != crc
            {
                old.copy_from_slice(&crc);
                mended = true;
            }
        }
        if !mended {
            return settled(input, &found);
        }
    }
    settled(input, &read_3dm(&bytes))
}

/// Reads bytes as a text; what has no header says how to change one that has.
fn read_text(
    bytes: &[u8],
    magic: &[u8],
    mutated: fn(&mut Source<'_>) -> String,
    read: fn(&[u8]) -> Result<Document, ReadError>,
) -> Result<Outcome, String> {
    let result = if bytes.windows(magic.len()).any(|w| w == magic) {
        read(bytes)
    } else {
        read(mutated(&mut Source::new(bytes)).as_bytes())
    };
    settled(bytes, &result)
}

/// What is refused is refused in a line, and what was read of an input is looked at.
fn settled(input: &[u8], result: &Result<Document, ReadError>) -> Result<Outcome, String> {
    match result {
        Ok(document) => {
            for object in &document.objects {
                if let ObjectKind::Refused { reason, .. } = &object.kind {
                    said(reason)?;
                }
            }
            look_at(document, hash(input).is_multiple_of(ASKED_OF));
        }
        Err(error) => said(error)?,
    }
    Ok(Outcome::Checked)
}

/// A refusal is one line of bounded length.
fn said(error: &ReadError) -> Result<(), String> {
    let text = error.to_string();
    if text.lines().count() == 1 && text.len() < 1000 {
        Ok(())
    } else {
        Err(format!("no line: {text}"))
    }
}

/// So many bodies of a document are looked at.
const PLACED: usize = 100;

fn look_at(document: &Document, asks: bool) {
    let mut text = String::new();
    // A small file may place very many.
    for (_, brep) in document.bodies().take(PLACED) {
        // Each defect has its words, and none of them panics.
        for d in brep.defects() {
            let _ = write!(text, "{d}");
        }
        if asks && brep.faces().len() <= 32 {
            ask_a_little(&PreparedBrep::new(brep.into_owned()));
        }
    }
}

fn checksum(error: &ReadError) -> Option<(usize, [u8; 4])> {
    match error {
        ReadError::Chunk { at, problem, .. } => match **problem {
            Problem::Checksum { computed, .. } => Some((*at, computed.to_le_bytes())),
            _ => None,
        },
        _ => None,
    }
}

/// One query of each kind.
const ASKED: [&str; 6] = [
    r#"{"sphere":{"center":[0.5,1.0,2.0],"radius":1.0},"accuracy":1e-6}"#,
    r#"{"half_space":{"normal":[0.0,0.0,1.0],"offset":0.0},"accuracy":1e-6}"#,
    r#"{"line":{"origin":[0.1,0.2,0.3],"direction":[1.0,2.0,3.0]},"accuracy":1e-6}"#,
    r#"{"side":{"face":0,"uv":[0.5,0.5]}}"#,
    r#"{"evaluate":{"face":0,"uv":[0.5,0.5]}}"#,
    r#"{"split":{"face":0,"loop":0,"trim":0}}"#,
];

fn ask_a_little(brep: &PreparedBrep) {
    let mut workspace = Workspace::default();
    for text in ASKED {
        if let Ok(query) = QueryLine::parse(text)
            .map_err(drop)
            .and_then(|l| l.query().map_err(drop))
        {
            answer(brep, &query, &mut workspace);
        }
    }
}

/// Lines of the protocol with hostile numbers.
fn asked(s: &mut Source<'_>) -> String {
    let mut text = String::new();
    for _ in 0..8 {
        let kind = s.below(7);
        let options = s.below(6);
        let mut n = || {
            let x = s.hostile();
            if x.is_finite() {
                format!("{x:e}")
            } else {
                // JSON knows no such number; one above the range comes nearest.
                "1e400".to_owned()
            }
        };
        let question = match kind {
            0 => format!(
                r#""sphere":{{"center":[{},{},{}],"radius":{}}}"#,
                n(),
                n(),
                n(),
                n()
            ),
            1 => format!(
                r#""half_space":{{"normal":[0.6,-0.8,{}],"offset":{}}}"#,
                n(),
                n()
            ),
            2 => format!(
                r#""line":{{"origin":[{},{},{}],"direction":[{},{},{}],"kind":"segment"}}"#,
                n(),
                n(),
                n(),
                n(),
                n(),
                n()
            ),
            3 => format!(r#""side":{{"face":{},"uv":[{},{}]}}"#, n(), n(), n()),
            4 => format!(r#""inside":{{"point":[{},{},{}]}}"#, n(), n(), n()),
            5 => format!(r#""evaluate":{{"face":2,"uv":[{},{}]}}"#, n(), n()),
            _ => r#""split":{"face":1,"loop":0,"trim":3}"#.to_owned(),
        };
        let option = match options {
            0 => format!(r#","accuracy":{}"#, n()),
            1 => format!(r#","prediction":{},"contacts":"all""#, n()),
            2 => format!(r#","pose":{{"translation":[{},{},{}]}}"#, n(), n(), n()),
            3 => r#","overlap":true"#.to_owned(),
            _ => String::new(),
        };
        let _ = writeln!(text, "{{{question}{option}}}");
    }
    text
}

/// The cube of the kernel's documentation, and lines of the protocol about it.
fn queries(bytes: &[u8]) -> Result<Outcome, String> {
    use feeler::brep::BrepBuilder;
    /// Of one input.
    const LINES: usize = 16;
    static CUBE: std::sync::OnceLock<Option<PreparedBrep>> = std::sync::OnceLock::new();
    let cube = CUBE.get_or_init(|| {
        let mut b = BrepBuilder::new();
        for i in 0..8 {
            b.vertex([i & 1, i >> 1 & 1, i >> 2].map(f64::from));
        }
        for corners in [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [1, 3, 7, 5],
            [3, 2, 6, 7],
            [2, 0, 4, 6],
        ] {
            b.planar_face(&corners).ok()?;
        }
        b.build().ok().map(PreparedBrep::new)
    });
    let Some(cube) = cube else {
        return Ok(Outcome::Rejected);
    };
    let text = match std::str::from_utf8(bytes) {
        Ok(text) if text.contains('{') => text.to_owned(),
        _ => asked(&mut Source::new(bytes)),
    };
    let mut workspace = Workspace::default();
    for line in text.lines().take(LINES) {
        let Ok(parsed) = QueryLine::parse(line) else {
            continue;
        };
        // What is written is what was read.
        let again = QueryLine::parse(&parsed.to_text()).map_err(|e| format!("{e}: {line}"))?;
        if again != parsed {
            return Err(format!("{} is not {line}", parsed.to_text()));
        }
        let Ok(query) = parsed.query() else { continue };
        let answer = Answer {
            id: query.id.clone(),
            body: answer(cube, &query, &mut workspace),
        };
        let written = answer.to_text();
        Answer::read(&written, &query).map_err(|e| format!("{e}: {written}: {line}"))?;
    }
    Ok(Outcome::Checked)
}

/// Hostile numbers over the bridge into C++: an answer or a refusal, and the process goes on.
fn oracle_boundary(bytes: &[u8]) -> Result<Outcome, String> {
    let mut s = Source::new(bytes);
    let kind = s.one_of(&[Kind::Side, Kind::Sphere, Kind::Split]);
    let numbers: [f64; 6] = [(); 6].map(|()| s.hostile());
    let face = s.below(3);
    let rest = bytes.get(64..).unwrap_or(&[]);
    let Some(scene) = Scene::decode(kind, rest) else {
        return Ok(Outcome::Rejected);
    };
    let oracle = match Oracle::new(&[&scene.brep]) {
        Ok(oracle) => oracle,
        Err(OracleError::Defect(why)) => return Err(format!("defect: {why}")),
        Err(_) => return Ok(Outcome::Rejected),
    };
    let [x, y, z, a, b, c] = numbers;
    /// Boxes of a search.
    const NODES: u32 = 200;
    let defects = [
        oracle.evaluate(face, [x, y]).err(),
        oracle.side(face, [x, y]).err(),
        oracle.distance([x, y, z], Some(NODES)).err(),
        oracle.half_space([x, y, z], a, Some(NODES)).err(),
        oracle.sphere([x, y, z], a, Some(NODES)).err(),
        oracle.derivative_roots(face, s.below(3), s.below(3)).err(),
        oracle.crack_width(s.below(3)).err(),
        // The costly ones for some.
        (face == 1)
            .then(|| {
                oracle
                    .line([x, y, z], [a, b, c], feeler::query::LineKind::Line)
                    .err()
            })
            .flatten(),
        (face == 2)
            .then(|| oracle.inside([x, y, z]).err())
            .flatten(),
    ];
    for e in defects.into_iter().flatten() {
        if let OracleError::Defect(why) = e {
            return Err(format!("defect: {why}: {numbers:?}"));
        }
    }
    Ok(Outcome::Checked)
}
