//! What can be wrong with a STEP file, and what to do about it.

use crate::occt::TextProblem;
use feeler::brep::BrepError;

/// What is wrong with a STEP file or one of its entities.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StepProblem {
    /// The program was built without the reader.
    #[error(
        "a STEP file, and this program reads none: build feeler-io with its feature `step`, or export the model as .brep or .3dm"
    )]
    NotBuilt,
    /// Not the syntax of ISO 10303-21.
    #[error("{message}; the file is damaged or no STEP file: export the model again")]
    Syntax {
        /// What the parser says, with the place.
        message: String,
    },
    /// An entity that is referred to and is not there.
    #[error(
        "it refers to #{target}, which does not exist; the file is damaged: export the model again"
    )]
    Missing {
        /// Its number.
        target: u64,
    },
    /// An entity of a kind that cannot stand there.
    #[error(
        "{what} cannot be {found}; the file is damaged or written wrongly: export the model again"
    )]
    Kind {
        /// As what it is used.
        what: &'static str,
        /// What it is.
        found: String,
    },
    /// An attribute that is not what it should be.
    #[error(
        "attribute {index} of {of} is no {expected}; the file is damaged or written wrongly: export the model again"
    )]
    Attribute {
        /// The entity's kind.
        of: String,
        /// The attribute, counted from 1.
        index: usize,
        /// What it should be.
        expected: &'static str,
    },
    /// Something that is not supported.
    #[error("{what} is not supported; {remedy}")]
    Unsupported {
        /// What.
        what: String,
        /// What to do.
        remedy: &'static str,
    },
    /// Something that contradicts itself.
    #[error("{what}; repair the part in the program that wrote it and export it again")]
    Shape {
        /// What.
        what: String,
    },
    /// More than is taken.
    #[error("more than {limit} {what}; export the parts one by one")]
    Limit {
        /// Of what.
        what: &'static str,
        /// How many may be.
        limit: usize,
    },
    /// What a file may unfold to is used up: nothing need be wrong with the entity itself.
    #[error(
        "no room is left for it: the file unfolds to more than {limit} numbers, as its faces and edges are used again and again or \
         have very many points; export its bodies one by one, each as a file of its own"
    )]
    Room {
        /// How many numbers there may be.
        limit: usize,
    },
    /// Geometry that has no form here.
    #[error("{0}")]
    Form(#[from] TextProblem),
    /// A BREP that the kernel refuses.
    #[error("{0}; repair the part in the program that wrote it and export it again")]
    Brep(#[from] BrepError),
}
