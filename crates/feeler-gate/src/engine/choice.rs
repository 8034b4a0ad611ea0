//! Engines by name, as on a command line.

use super::{Engine, FeelerEngine, MeshEngine, ProcessEngine, ProcessOptions, ThesisEngine};
use feeler::query::Options;
use std::fmt;

/// Which engine is meant.
///
/// Read from its name by [`by_name`](Self::by_name) and written back by its `Display`:
///
/// | name | engine |
/// |---|---|
/// | `feeler` | the kernel of this project |
/// | `parry:DEGREES` | a triangle mesh in parry; angle between neighbouring normals (`parry`: 10) |
/// | `thesis` | the algorithms of the 2014 thesis |
/// | `thesis:STARTS` | the same, Newton from the best of so many starts on a square grid |
/// | anything else | a command line that speaks the query protocol |
#[derive(Clone, Debug, PartialEq)]
pub enum EngineChoice {
    /// The kernel of this project.
    Feeler,
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
            ("feeler", None) => Ok(Self::Feeler),
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
            Self::Feeler => Ok(Box::new(FeelerEngine::new(Options::default()))),
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
        matches!(self, Self::Feeler)
    }
}

impl fmt::Display for EngineChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Feeler => write!(f, "feeler"),
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
            ("feeler", EngineChoice::Feeler),
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
        ] {
            assert!(EngineChoice::by_name(name).is_err(), "{name:?}");
        }
    }
}
