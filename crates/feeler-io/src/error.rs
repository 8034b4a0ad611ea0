//! What can be wrong with a file, and what to do about it.

use crate::file::MAX_FILE_SIZE;
use crate::occt::TextProblem;
use crate::step_problem::StepProblem;
use feeler::brep::BrepError;
use feeler::nurbs::GeometryError;
use std::fmt;
use std::path::PathBuf;

/// Which chunk of a file: its typecode and where its header starts. Typecode 0 is the file itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChunkId {
    /// The typecode, as stored.
    pub typecode: u32,
    /// Byte offset of the chunk's header from the start of the file.
    pub offset: usize,
}

impl ChunkId {
    /// The typecode's name, `"chunk"` if it is not one that this reader looks into.
    pub fn name(&self) -> &'static str {
        match self.typecode {
            0 => "file",
            0x0000_0001 => "comment",
            0x0000_7FFF => "end of file",
            0x0002_7FFA => "object",
            0x0002_7FFD => "user data",
            0x0002_FFFB => "class id",
            0x0002_FFFC => "class data",
            0x0200_8072 => "object attributes",
            0x1000_0010..=0x1000_0025 => match self.typecode {
                0x1000_0011 => "layer table",
                0x1000_0013 => "object table",
                0x1000_0014 => "properties table",
                0x1000_0015 => "settings table",
                0x1000_0021 => "block table",
                _ => "table",
            },
            0x2000_8031 => "units",
            0x2000_8050 => "layer record",
            0x2000_8070 => "object record",
            0x2000_8076 => "block record",
            0x4000_8000 => "part",
            0x4000_8002 => "attributes",
            _ => "chunk",
        }
    }
}

impl fmt::Display for ChunkId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { typecode, offset } = self;
        if *typecode == 0 {
            return f.write_str(self.name());
        }
        write!(f, "{} 0x{typecode:08X} at byte {offset}", self.name())
    }
}

/// Why a file, or one object of it, cannot be read. Each message is one line that names the
/// place and the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReadError {
    /// There are no bytes.
    #[error("the file is empty; export the model again")]
    Empty,
    /// No header of a .3dm file.
    #[error(
        "not a .3dm file: no \"3D Geometry File Format\" header in its {size} bytes; \
         export the model as .3dm (version 3 to 8)"
    )]
    NotA3dm {
        /// How many bytes were searched.
        size: usize,
    },
    /// A version that this reader does not read.
    #[error(
        "a .3dm file of version {found}; versions 1 to 8 are read: \
         open it in Rhino or with rhino3dm and save it as one of these"
    )]
    Version {
        /// The version field of the header.
        found: String,
    },
    /// Something wrong inside a chunk.
    #[error("{chunk}: {problem} (byte {at})")]
    Chunk {
        /// The innermost chunk that holds it.
        chunk: ChunkId,
        /// Byte offset of the place from the start of the file.
        at: usize,
        /// What is wrong.
        problem: Box<Problem>,
    },
    /// Something wrong with an object as a whole.
    #[error("object at byte {at}: {problem}")]
    Object {
        /// Byte offset of its record from the start of the file.
        at: usize,
        /// What is wrong.
        problem: Box<Problem>,
    },
    /// Something wrong in a line of a text file.
    #[error("line {line}: {problem}")]
    Line {
        /// The line, counted from 1.
        line: usize,
        /// What is wrong.
        problem: Box<TextProblem>,
    },
    /// Something wrong with a STEP file as a whole.
    #[error("{0}")]
    Step(Box<StepProblem>),
    /// Something wrong with an entity of a STEP file.
    #[error("#{entity}: {problem}")]
    Entity {
        /// Its number in the file.
        entity: u64,
        /// What is wrong.
        problem: Box<StepProblem>,
    },
}

/// What is wrong inside a chunk.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Problem {
    /// A field needs more bytes than its chunk has left.
    #[error(
        "{what} needs {needed} bytes and {left} are left; \
         the file is truncated or damaged: copy or save it again"
    )]
    Truncated {
        /// The field.
        what: &'static str,
        /// How many bytes it needs.
        needed: u64,
        /// How many are left in the chunk.
        left: u64,
    },
    /// A chunk longer than the chunk it is in.
    #[error(
        "it holds 0x{typecode:08X} of {length} bytes where {left} are left; \
         the file is truncated or damaged: copy or save it again"
    )]
    ChunkLength {
        /// The inner chunk's typecode.
        typecode: u32,
        /// The length it claims.
        length: i64,
        /// How many bytes are left.
        left: u64,
    },
    /// A count that is negative or that the bytes left cannot hold.
    #[error(
        "{count} {what} cannot be in the {left} bytes that are left; \
         the file is damaged: copy or save it again"
    )]
    Count {
        /// Of what.
        what: &'static str,
        /// The count, as stored.
        count: i64,
        /// How many bytes are left in the chunk.
        left: u64,
    },
    /// A checksum that does not fit.
    #[error(
        "checksum 0x{stored:08X} stored, 0x{computed:08X} computed; \
         the file is damaged: copy or save it again"
    )]
    Checksum {
        /// The CRC-32 in the file.
        stored: u32,
        /// The CRC-32 of the bytes.
        computed: u32,
    },
    /// Chunks or curves nested too deep.
    #[error("chunks nested more than {limit} deep; explode nested poly-curves and save again")]
    Depth {
        /// How deep they may nest.
        limit: u32,
    },
    /// One kind of chunk was expected and another is there.
    #[error(
        "{expected} expected, 0x{found:08X} found; the file is damaged or not written by a \
         known program: save it again from Rhino"
    )]
    Unexpected {
        /// What should be there.
        expected: &'static str,
        /// The typecode that is there.
        found: u32,
    },
    /// A layout newer or older than those known.
    #[error("{class} {major}.{minor} is not read; save the file as version {remedy}")]
    Layout {
        /// The class.
        class: &'static str,
        /// Major version of its layout.
        major: u8,
        /// Minor version of its layout.
        minor: u8,
        /// Which file versions to save as.
        remedy: &'static str,
    },
    /// A class that cannot be used here.
    #[error("{class} cannot be used as {role}; {remedy}")]
    Class {
        /// The class's name, or its id if it is unknown.
        class: String,
        /// As what.
        role: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// A value outside what its field may hold.
    #[error("{what} is {found}, {expected} expected; the file is damaged or was written wrongly")]
    Value {
        /// The field.
        what: String,
        /// The value.
        found: String,
        /// What it may be.
        expected: String,
    },
    /// A reference to a part of the BREP that is missing.
    #[error(
        "{owner} {index} refers to {what} {target}, which does not exist (there are {count}); \
         repair the object (Rhino: SelBadObjects, ExtractBadSrf) and save again"
    )]
    Reference {
        /// What holds the reference.
        owner: &'static str,
        /// Which one.
        index: usize,
        /// What it refers to.
        what: &'static str,
        /// The index, as stored.
        target: i32,
        /// How many there are.
        count: usize,
    },
    /// A block reference that places nothing, or what cannot be placed.
    #[error("a block reference: {why}")]
    Block {
        /// Why.
        why: String,
    },
    /// Geometry that the kernel refuses.
    #[error("{class}: {source}; repair the object and save again")]
    Geometry {
        /// The class.
        class: &'static str,
        /// Why.
        source: GeometryError,
    },
    /// A BREP that the kernel refuses.
    #[error("{0}; repair the object and save again")]
    Brep(#[from] BrepError),
}

/// A file that cannot be read, by name.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// Why.
    #[source]
    pub problem: FileProblem,
}

/// Why a file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum FileProblem {
    /// The system says so.
    #[error("cannot be read: {0}; check the path and its permissions")]
    Io(#[from] std::io::Error),
    /// Larger than [`MAX_FILE_SIZE`].
    #[error("larger than {MAX_FILE_SIZE} bytes; split the model or export only the part needed")]
    TooLarge,
    /// Its content is wrong.
    #[error("{0}")]
    Read(#[from] ReadError),
}

/// What cannot be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WriteError {
    /// A whole surface among other faces.
    #[error(
        "object {object}: face {face} has no loops, which the format cannot say of one face among others; give it its border as a loop"
    )]
    NoLoops {
        /// The object.
        object: usize,
        /// The face.
        face: usize,
    },
    /// Something that the format has no room for.
    #[error("object {object}: {what}")]
    Unsupported {
        /// The object.
        object: usize,
        /// What it is, where, and the remedy.
        what: String,
    },
}
