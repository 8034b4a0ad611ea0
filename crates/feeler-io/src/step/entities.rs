//! The entities of a file and their attributes, with errors that name them.

use super::part21::{Attribute, Graph, Part, RawEntity};
use crate::error::ReadError;
use crate::occt::TextProblem;
use crate::step_problem::StepProblem;

/// The entities of a file.
pub(super) struct Entities {
    graph: Graph,
}

/// An entity: its number and, of one in several parts, the part that is meant.
#[derive(Clone, Copy)]
pub(super) struct Entity<'e> {
    pub(super) id: u64,
    pub(super) name: &'e str,
    attributes: &'e [Attribute],
}

pub(super) fn problem(entity: u64, problem: StepProblem) -> ReadError {
    ReadError::Entity {
        entity,
        problem: Box::new(problem),
    }
}

/// What cannot be turned into geometry, said of an entity.
pub(super) fn form(entity: u64) -> impl Fn(TextProblem) -> ReadError {
    move |p| {
        let said = match p {
            TextProblem::Limit { limit, .. } => StepProblem::Room { limit },
            other => StepProblem::Form(other),
        };
        problem(entity, said)
    }
}

/// Where what a file may unfold to is used up, the same said of the `whole` that was being made: it is no fault of its part.
pub(super) fn no_room(whole: u64, error: &ReadError) -> Option<ReadError> {
    match error {
        ReadError::Entity { problem: p, .. } => match **p {
            StepProblem::Room { limit } => Some(problem(whole, StepProblem::Room { limit })),
            _ => None,
        },
        _ => None,
    }
}

pub(super) fn shape(entity: u64, what: impl Into<String>) -> ReadError {
    problem(entity, StepProblem::Shape { what: what.into() })
}

pub(super) fn unsupported(entity: u64, what: impl Into<String>, remedy: &'static str) -> ReadError {
    let what = what.into();
    problem(entity, StepProblem::Unsupported { what, remedy })
}

/// The longest name of a kind that messages show.
const SHOWN: usize = 60;

impl Entities {
    pub(super) fn new(graph: Graph) -> Self {
        Self { graph }
    }

    pub(super) fn graph(&self) -> &Graph {
        &self.graph
    }

    fn raw(&self, id: u64) -> Option<&RawEntity> {
        self.graph.get(id)
    }

    /// Byte offset of an entity.
    pub(super) fn offset(&self, id: u64) -> usize {
        self.raw(id).map_or(0, |e| e.offset)
    }

    /// The names of its kinds.
    pub(super) fn kinds(&self, id: u64) -> impl Iterator<Item = &str> + Clone {
        let parts = self.raw(id).map_or(&[][..], |e| &e.parts);
        parts.iter().map(|p| &*p.name)
    }

    /// What it is, for messages.
    pub(super) fn described(&self, id: u64) -> String {
        let mut text = self.kinds(id).take(SHOWN).collect::<Vec<_>>().join("+");
        if let Some((at, _)) = text.char_indices().nth(SHOWN) {
            text.truncate(at);
            text.push_str("...");
        }
        text
    }

    /// The entity, or that part of it, of a kind.
    pub(super) fn part<'e>(&'e self, id: u64, name: &str) -> Option<Entity<'e>> {
        let parts = &self.raw(id)?.parts;
        let part = parts.iter().find(|p| &*p.name == name)?;
        Some(Entity::of(id, part))
    }

    pub(super) fn is(&self, id: u64, name: &str) -> bool {
        self.part(id, name).is_some()
    }

    /// The entity of one part.
    pub(super) fn simple(&self, id: u64) -> Option<Entity<'_>> {
        let raw = self.raw(id).filter(|e| !e.is_complex)?;
        Some(Entity::of(id, raw.parts.first()?))
    }

    /// The entity `id` that `from` refers to as `what`, which must be of a kind.
    pub(super) fn expect<'e>(
        &'e self,
        from: u64,
        id: u64,
        name: &str,
        what: &'static str,
    ) -> Result<Entity<'e>, ReadError> {
        if let Some(entity) = self.part(id, name) {
            return Ok(entity);
        }
        Err(self.unexpected(from, id, what))
    }

    /// That an entity cannot stand where another refers to it.
    pub(super) fn unexpected(&self, from: u64, id: u64, what: &'static str) -> ReadError {
        if self.raw(id).is_none() {
            return problem(from, StepProblem::Missing { target: id });
        }
        let found = self.described(id);
        problem(id, StepProblem::Kind { what, found })
    }
}

impl<'e> Entity<'e> {
    fn of(id: u64, part: &'e Part) -> Self {
        Self {
            id,
            name: &part.name,
            attributes: &part.attributes,
        }
    }

    fn bad(&self, index: usize, expected: &'static str) -> ReadError {
        problem(
            self.id,
            StepProblem::Attribute {
                of: self.name.chars().take(SHOWN).collect(),
                index: index + 1,
                expected,
            },
        )
    }

    pub(super) fn get(&self, index: usize) -> Option<&'e Attribute> {
        self.attributes.get(index)
    }

    pub(super) fn reference(&self, index: usize) -> Result<u64, ReadError> {
        match self.get(index) {
            Some(Attribute::EntityRef(id)) => Ok(*id),
            _ => Err(self.bad(index, "reference")),
        }
    }

    pub(super) fn optional(&self, index: usize) -> Option<u64> {
        match self.get(index) {
            Some(Attribute::EntityRef(id)) => Some(*id),
            _ => None,
        }
    }

    pub(super) fn list(&self, index: usize) -> Result<&'e [Attribute], ReadError> {
        match self.get(index) {
            Some(Attribute::List(list)) => Ok(list),
            _ => Err(self.bad(index, "list")),
        }
    }

    pub(super) fn references(&self, index: usize) -> Result<Vec<u64>, ReadError> {
        let each = self.list(index)?.iter().map(|a| match a {
            Attribute::EntityRef(id) => Ok(*id),
            _ => Err(self.bad(index, "list of references")),
        });
        each.collect()
    }

    pub(super) fn number(&self, index: usize) -> Result<f64, ReadError> {
        let found = self.get(index).and_then(number);
        found.ok_or_else(|| self.bad(index, "number"))
    }

    pub(super) fn numbers(&self, index: usize) -> Result<Vec<f64>, ReadError> {
        let each = self.list(index)?.iter();
        let each = each.map(|a| number(a).ok_or_else(|| self.bad(index, "list of numbers")));
        each.collect()
    }

    pub(super) fn integers(&self, index: usize) -> Result<Vec<usize>, ReadError> {
        let each = self.list(index)?.iter().map(|a| match a {
            Attribute::Integer(i) => usize::try_from(*i).ok(),
            _ => None,
        });
        let all: Option<Vec<usize>> = each.collect();
        all.ok_or_else(|| self.bad(index, "list of counts"))
    }

    pub(super) fn integer(&self, index: usize) -> Result<usize, ReadError> {
        match self.get(index) {
            Some(Attribute::Integer(i)) => usize::try_from(*i).ok(),
            _ => None,
        }
        .ok_or_else(|| self.bad(index, "count"))
    }

    /// `.T.` or `.F.`; anything else is false only where it says so.
    pub(super) fn flag(&self, index: usize) -> Result<bool, ReadError> {
        match self.get(index) {
            Some(Attribute::Enum(word)) if &**word == "T" => Ok(true),
            Some(Attribute::Enum(word)) if &**word == "F" => Ok(false),
            _ => Err(self.bad(index, "logical value")),
        }
    }

    pub(super) fn word(&self, index: usize) -> Option<&'e str> {
        match self.get(index) {
            Some(Attribute::Enum(word)) => Some(word),
            _ => None,
        }
    }

    pub(super) fn text(&self, index: usize) -> &'e str {
        match self.get(index) {
            Some(Attribute::Text(text)) => text,
            _ => "",
        }
    }
}

/// A number, typed or not; finite.
fn number(attribute: &Attribute) -> Option<f64> {
    match attribute {
        Attribute::Real(x) => Some(*x).filter(|x| x.is_finite()),
        Attribute::Integer(i) => Some(*i as f64),
        // `LENGTH_MEASURE(1.)`: of one level, which is all there is.
        Attribute::Typed(value) => match **value {
            Attribute::Real(x) => Some(x).filter(|x| x.is_finite()),
            Attribute::Integer(i) => Some(i as f64),
            _ => None,
        },
        _ => None,
    }
}
