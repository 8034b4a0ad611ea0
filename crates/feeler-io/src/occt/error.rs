//! What can be wrong with a .brep file, and what to do about it.

use feeler::brep::BrepError;
use feeler::nurbs::GeometryError;

/// What is wrong in a line of a .brep file, or with what stands there.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TextProblem {
    /// No header.
    #[error(
        "not a .brep file: no line \"CASCADE Topology V1\" to \"V3\" at its start; export the shape with \
         OCCT's BRepTools::Write, or the model as .3dm"
    )]
    Header,
    /// OCCT's other format.
    #[error("OCCT's binary format is not read; write the shape as text (BRepTools::Write)")]
    Binary,
    /// A version that this reader does not read.
    #[error(
        "a .brep file of version {found}; versions 1 to 3 are read: write it as one of these with \
         BRepTools::Write"
    )]
    Version {
        /// The version, as written.
        found: String,
    },
    /// The file ends too early.
    #[error("the file ends where {what} should stand; it is cut off: copy or write it again")]
    Truncated {
        /// What should stand there.
        what: &'static str,
    },
    /// A word that cannot stand there.
    #[error(
        "{what} is `{found}`, {expected} expected; the file is damaged: copy or write it again"
    )]
    Word {
        /// The field.
        what: &'static str,
        /// The word, shortened.
        found: String,
        /// What it may be.
        expected: String,
    },
    /// A count that what is left of the file cannot hold.
    #[error(
        "{count} {what} cannot be in the {left} bytes that are left; the file is damaged: copy or \
         write it again"
    )]
    Count {
        /// Of what.
        what: &'static str,
        /// The count, as written.
        count: u64,
        /// How many bytes are left.
        left: usize,
    },
    /// A number of something that is not in the file, or not yet.
    #[error(
        "{what} {found} does not exist here, there are {count}; the file is damaged: copy or write it again"
    )]
    Reference {
        /// What is referred to.
        what: &'static str,
        /// Its number, as written.
        found: i64,
        /// How many there are.
        count: usize,
    },
    /// Curves or surfaces defined by each other too often.
    #[error(
        "curves and surfaces defined by each other more than {limit} deep; convert the shape to NURBS \
         (BRepBuilderAPI_NurbsConvert) and write it again"
    )]
    Nested {
        /// How deep they may be.
        limit: u32,
    },
    /// A form that the kernel cannot hold exactly.
    #[error("{what} has no exact form here; {remedy} and write it again")]
    Unsupported {
        /// The form.
        what: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A placement that is more than a motion.
    #[error(
        "location {location} keeps no shapes: {why}; apply the transformation to the shape \
         (BRepBuilderAPI_GTransform) and write it again"
    )]
    Uneven {
        /// Its number.
        location: usize,
        /// In what way.
        why: String,
    },
    /// Something in the shape contradicts itself.
    #[error("{what}; repair the shape (ShapeFix_Shape) and write it again")]
    Shape {
        /// What.
        what: String,
    },
    /// The file unfolds to too much.
    #[error(
        "the file unfolds to more than {limit} {what}: it places its shapes too often; write the parts one by one"
    )]
    Limit {
        /// Of what.
        what: &'static str,
        /// How many may be.
        limit: usize,
    },
    /// Geometry that the kernel refuses.
    #[error("{what}: {source}; repair the shape (ShapeFix_Shape) and write it again")]
    Geometry {
        /// What it is of.
        what: &'static str,
        /// Why.
        source: GeometryError,
    },
    /// A BREP that the kernel refuses.
    #[error("{0}; repair the shape (ShapeFix_Shape) and write it again")]
    Brep(#[from] BrepError),
}
