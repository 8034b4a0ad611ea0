//! Engines by name, as on a command line.

use super::{Engine, FeelerEngine, MeshEngine, ProcessEngine, ProcessOptions, ThesisEngine};
use feeler::prepare::Shortcuts;
use std::fmt;

/// Which engine is meant.
///
/// Read from its name by [`by_name`](Self::by_name) and written back by its `Display`:
///
/// | name | engine |
/// |---|---|
/// | `feeler` | the kernel of this project |
/// | `feeler:WAY` | the same in another way, or several with commas between: see [`FeelerWay`] |
/// | `parry:DEGREES` | a triangle mesh in parry; angle between neighbouring normals (`parry`: 10) |
/// | `thesis` | the algorithms of the 2014 thesis |
/// | `thesis:STARTS` | the same, Newton from the best of so many starts on a square grid |
/// | anything else | a command line that speaks the query protocol |
#[derive(Clone, Debug, PartialEq)]
pub enum EngineChoice {
    /// The kernel of this project.
    Feeler(FeelerWay),
    /// Triangles in `parry3d-f64`.
    Parry {
        /// Angle between neighbouring normals along parameter lines, in degrees; in (0, 180].
        degrees: f64,
    },
    /// The 2014 thesis.
    Thesis {
        /// How many points of a face Newton's method may start from: 1 (the middle), or a square number.
        starts: usize,
    },
    /// A program of its own, started by this command line.
    Command(String),
}

/// How the kernel is to work, to measure what its shortcuts save.
///
/// | name | way |
/// |---|---|
/// | `nurbs` | native surfaces are turned into NURBS first: see [`as_nurbs`](super::as_nurbs()) |
/// | `no-closed-forms`, `no-recognition`, `no-boxes`, `no-convex-leaves`, `no-monotone-borders`, `no-double-first`, `no-trim-cells`, `no-side-cells` | without that one of the [`Shortcuts`] |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FeelerWay {
    /// Whether native surfaces are turned into NURBS.
    pub nurbs: bool,
    /// What the kernel may leave out.
    pub shortcuts: Shortcuts,
}

const NURBS: &str = "nurbs";
/// One of the switches.
type Switch = fn(&mut Shortcuts) -> &mut bool;
/// Each shortcut, by the name of its absence.
const OFF: [(&str, Switch); 8] = [
    ("no-closed-forms", |s| &mut s.closed_forms),
    ("no-recognition", |s| &mut s.recognition),
    ("no-boxes", |s| &mut s.boxes),
    ("no-convex-leaves", |s| &mut s.convex_leaves),
    ("no-monotone-borders", |s| &mut s.monotone_borders),
    ("no-double-first", |s| &mut s.double_first),
    ("no-trim-cells", |s| &mut s.trim_cells),
    ("no-side-cells", |s| &mut s.side_cells),
];

impl FeelerWay {
    /// Reads names with commas between.
    ///
    /// # Errors
    /// Which is unknown, in one line.
    pub fn by_name(names: &str) -> Result<Self, String> {
        let mut way = Self::default();
        for name in names.split(',').map(str::trim) {
            match OFF.iter().find(|(off, _)| *off == name) {
                Some((_, of)) => *of(&mut way.shortcuts) = false,
                None if name == NURBS => way.nurbs = true,
                None => {
                    let known = OFF.map(|(off, _)| off).join(", ");
                    return Err(format!("feeler:{name}: give {NURBS} or one of {known}"));
                }
            }
        }
        Ok(way)
    }

    /// Each shortcut off in turn, by name.
    pub fn each_off() -> impl Iterator<Item = (&'static str, Self)> {
        OFF.into_iter().map(|(name, of)| {
            let mut way = Self::default();
            *of(&mut way.shortcuts) = false;
            (name, way)
        })
    }
}

impl fmt::Display for FeelerWay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shortcuts = self.shortcuts;
        let off = OFF.iter().filter(|(_, of)| !*of(&mut shortcuts));
        let names: Vec<&str> = off.map(|(name, _)| *name).collect();
        let nurbs = self.nurbs.then_some(NURBS);
        let names: Vec<&str> = nurbs.into_iter().chain(names).collect();
        write!(f, "{}", names.join(","))
    }
}

/// Degrees where `parry` stands alone.
const DEFAULT_DEGREES: f64 = 10.0;
/// More starts than this a face serve no one.
const MOST_STARTS: usize = 10_000;

impl EngineChoice {
    /// Reads a name.
    ///
    /// # Errors
    /// What is wrong with it, in one line: nothing named, or a number that does not do.
    pub fn by_name(name: &str) -> Result<Self, String> {
        let name = name.trim();
        let (word, number) = match name.split_once(':') {
            Some((word, number)) => (word, Some(number)),
            None => (name, None),
        };
        match (word, number) {
            ("", None) => {
                Err("no engine named: give feeler, parry:DEGREES, thesis or a command line".into())
            }
            ("feeler", None) => Ok(Self::Feeler(FeelerWay::default())),
            ("feeler", Some(ways)) => FeelerWay::by_name(ways).map(Self::Feeler),
            ("parry", None) => Ok(Self::Parry {
                degrees: DEFAULT_DEGREES,
            }),
            ("parry", Some(number)) => match number.parse::<f64>() {
                Ok(degrees) if degrees > 0.0 && degrees <= 180.0 => Ok(Self::Parry { degrees }),
                _ => Err(format!(
                    "parry:{number}: give an angle above 0 and up to 180 degrees, as in parry:10"
                )),
            },
            ("thesis", None) => Ok(Self::Thesis { starts: 1 }),
            ("thesis", Some(number)) => match number.parse::<usize>() {
                Ok(starts)
                    if (1..=MOST_STARTS).contains(&starts) && starts.isqrt().pow(2) == starts =>
                {
                    Ok(Self::Thesis { starts })
                }
                _ => Err(format!(
                    "thesis:{number}: give a square number of starts up to {MOST_STARTS}, as in thesis:100"
                )),
            },
            _ => Ok(Self::Command(name.to_owned())),
        }
    }

    /// The engine itself.
    ///
    /// # Errors
    /// Why it cannot be had, in one line.
    pub fn engine(&self) -> Result<Box<dyn Engine>, String> {
        match self {
            Self::Feeler(way) => Ok(Box::new(FeelerEngine::with(*way))),
            Self::Command(line) => {
                let engine = ProcessEngine::new(line, ProcessOptions::default())?;
                Ok(Box::new(engine))
            }
            Self::Parry { degrees } => Ok(Box::new(MeshEngine::new(*degrees))),
            Self::Thesis { starts } => Ok(Box::new(ThesisEngine::new(*starts))),
        }
    }

    /// Whether its answers carry bounds of their own; those of the others are held to a tolerance.
    pub fn certifies(&self) -> bool {
        matches!(self, Self::Feeler(way) if !way.nurbs)
    }
}

impl fmt::Display for EngineChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Feeler(way) if *way == FeelerWay::default() => write!(f, "feeler"),
            Self::Feeler(way) => write!(f, "feeler:{way}"),
            Self::Parry { degrees } => write!(f, "parry:{degrees}"),
            Self::Thesis { starts: 1 } => write!(f, "thesis"),
            Self::Thesis { starts } => write!(f, "thesis:{starts}"),
            Self::Command(line) => write!(f, "{line}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_and_written_back() {
        let named = [
            ("feeler", EngineChoice::Feeler(FeelerWay::default())),
            ("parry:10", EngineChoice::Parry { degrees: 10.0 }),
            ("parry:0.1", EngineChoice::Parry { degrees: 0.1 }),
            ("parry:180", EngineChoice::Parry { degrees: 180.0 }),
            ("thesis", EngineChoice::Thesis { starts: 1 }),
            ("thesis:100", EngineChoice::Thesis { starts: 100 }),
            (
                "python3 occt.py --fast",
                EngineChoice::Command("python3 occt.py --fast".into()),
            ),
        ];
        for (name, choice) in named {
            assert_eq!(EngineChoice::by_name(name), Ok(choice.clone()));
            assert_eq!(choice.to_string(), name);
        }
        for (name, way) in FeelerWay::each_off() {
            let choice = EngineChoice::Feeler(way);
            let name = format!("feeler:{name}");
            assert_eq!(EngineChoice::by_name(&name), Ok(choice.clone()));
            assert_eq!(choice.to_string(), name);
        }
        let both = EngineChoice::by_name("feeler:no-boxes, nurbs").unwrap();
        assert_eq!(both.to_string(), "feeler:nurbs,no-boxes");
        assert!(!both.certifies());
        assert_eq!(
            EngineChoice::by_name("parry"),
            EngineChoice::by_name("parry:10")
        );
        assert_eq!(
            EngineChoice::by_name("thesis:1"),
            EngineChoice::by_name("thesis")
        );
    }

    #[test]
    fn numbers_that_do_not_do_are_refused() {
        for name in [
            "",
            "  ",
            "parry:",
            "parry:0",
            "parry:-1",
            "parry:181",
            "parry:NaN",
            "parry:inf",
            "thesis:0",
            "thesis:99",
            "thesis:1e2",
            "thesis:10201",
            "feeler:",
            "feeler:fast",
        ] {
            assert!(EngineChoice::by_name(name).is_err(), "{name:?}");
        }
    }
}
