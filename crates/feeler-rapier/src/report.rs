//! Pairs that nothing is known about, said aloud.

use parry3d_f64::shape::{Shape, ShapeType};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// A kind of pair that is not supported, and how often it was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnsupportedPair {
    /// The query.
    pub query: &'static str,
    /// The kind of the shape beside the BREP.
    pub other: String,
    /// How often it was asked.
    pub count: u64,
}

type Say = Box<dyn Fn(&str) + Send + Sync>;

/// Counts, and says the first of each kind.
pub(crate) struct Report {
    counts: Mutex<BTreeMap<(&'static str, String), u64>>,
    say: Say,
}

impl Report {
    pub(crate) fn new(say: Say) -> Self {
        Self {
            counts: Mutex::default(),
            say,
        }
    }

    pub(crate) fn note(&self, query: &'static str, other: &dyn Shape) {
        let name = match other.shape_type() {
            // Two shapes of other crates may differ; a BREP is told from the rest.
            ShapeType::Custom if other.as_shape::<crate::BrepShape>().is_some() => {
                "BREP".to_owned()
            }
            kind => format!("{kind:?}"),
        };
        let message = format!(
            "feeler-rapier: {query} of a BREP and a {name} is not supported: the engine takes the pair not to touch \
             (said once for this kind)"
        );
        let first = {
            let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
            let count = counts.entry((query, name)).or_default();
            *count += 1;
            *count == 1
        };
        if first {
            (self.say)(&message);
        }
    }

    pub(crate) fn pairs(&self) -> Vec<UnsupportedPair> {
        let counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        let one = |((query, other), count): (&(&'static str, String), &u64)| UnsupportedPair {
            query,
            other: other.clone(),
            count: *count,
        };
        counts.iter().map(one).collect()
    }
}
