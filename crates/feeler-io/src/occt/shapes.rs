//! The tables of a file, as they stand there.

use super::curves::Form;
use super::error::TextProblem;
use super::motion::{Place, Places};
use super::surfaces::Form3;
use super::tokens::Tokens;
use crate::error::ReadError;
use nalgebra::Point3;

/// Something of a table, and the line where it starts.
pub(super) struct At<T> {
    pub(super) line: usize,
    pub(super) item: T,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Orientation {
    Forward,
    Reversed,
    /// Inside of what it is part of: bounds nothing.
    Internal,
    /// Outside of it: bounds nothing.
    External,
}

impl Orientation {
    /// That of a part with this orientation in a whole with that of `whole`.
    pub(super) fn within(self, whole: Self) -> Self {
        match (whole, self) {
            (Self::Forward, own) => own,
            (Self::Reversed, Self::Forward) => Self::Reversed,
            (Self::Reversed, Self::Reversed) => Self::Forward,
            (Self::Reversed, own) => own,
            (Self::Internal | Self::External, _) => whole,
        }
    }

    pub(super) fn bounds(self) -> bool {
        matches!(self, Self::Forward | Self::Reversed)
    }
}

/// A shape as part of another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sub {
    /// Its number in the table, from 0.
    pub(super) shape: usize,
    pub(super) orientation: Orientation,
    pub(super) place: Place,
}

/// The curve of an edge on a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct OnSurface {
    pub(super) curve: usize,
    /// The one for the reversed edge, on a seam.
    pub(super) second: Option<usize>,
    pub(super) surface: usize,
    pub(super) place: Place,
    pub(super) range: [f64; 2],
}

/// The curve of an edge in space.
#[derive(Clone, Copy, Debug)]
pub(super) struct InSpace {
    pub(super) curve: usize,
    pub(super) place: Place,
    pub(super) range: [f64; 2],
}

#[derive(Debug)]
pub(super) struct Edge {
    pub(super) tolerance: f64,
    pub(super) degenerated: bool,
    pub(super) in_space: Option<InSpace>,
    pub(super) on_surfaces: Vec<OnSurface>,
}

/// What a shape is, without its parts.
#[derive(Debug)]
pub(super) enum Kind {
    Vertex {
        tolerance: f64,
        point: Point3<f64>,
    },
    Edge(Edge),
    Wire,
    Face {
        /// `None`: only a triangulation.
        surface: Option<usize>,
        place: Place,
    },
    Shell,
    Solid,
    CompSolid,
    Compound,
}

impl Kind {
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Vertex { .. } => "vertex",
            Self::Edge(_) => "edge",
            Self::Wire => "wire",
            Self::Face { .. } => "face",
            Self::Shell => "shell",
            Self::Solid => "solid",
            Self::CompSolid => "compsolid",
            Self::Compound => "compound",
        }
    }
}

pub(super) struct Shape {
    pub(super) line: usize,
    /// Byte offset of its record.
    pub(super) offset: usize,
    pub(super) kind: Kind,
    /// Shapes before it in the table: there are no circles.
    pub(super) parts: Vec<Sub>,
}

/// The whole file.
pub(super) struct Tables {
    pub(super) places: Places,
    pub(super) curves2: Vec<At<Form<2, 3>>>,
    pub(super) curves3: Vec<At<Form<3, 4>>>,
    pub(super) surfaces: Vec<At<Form3>>,
    pub(super) shapes: Vec<Shape>,
    /// Triangulations and polygons: not used.
    pub(super) meshes: usize,
    /// The shape that the file is about.
    pub(super) root: Sub,
}

/// Sizes of the tables that edges and faces refer to.
struct Counts {
    curves2: usize,
    curves3: usize,
    surfaces: usize,
    polygons: usize,
    polygons_on: usize,
    triangulations: usize,
    version: u32,
}

/// The fewest words of a curve, of a surface and of a shape.
const CURVE_WORDS: usize = 5;
const SURFACE_WORDS: usize = 8;
const SHAPE_WORDS: usize = 3;

fn table<T>(
    t: &mut Tokens<'_>,
    name: &'static str,
    what: &'static str,
    words: usize,
    mut read: impl FnMut(&mut Tokens<'_>) -> Result<T, ReadError>,
) -> Result<Vec<At<T>>, ReadError> {
    t.expect("the name of a table", name)?;
    let count = t.count(what, words)?;
    let mut all = Vec::new();
    for _ in 0..count {
        t.peek();
        let line = t.last_line();
        let item = read(t)?;
        all.push(At { line, item });
    }
    Ok(all)
}

fn polygon(t: &mut Tokens<'_>) -> Result<(), ReadError> {
    let nodes = t.count("nodes of a polygon", 3)?;
    let parameters = t.flag("whether a polygon has parameters")?;
    let words = nodes * if parameters { 4 } else { 3 };
    t.skip("a polygon", 1 + words)
}

fn polygon_on(t: &mut Tokens<'_>) -> Result<(), ReadError> {
    let nodes = t.count("nodes of a polygon", 1)?;
    t.skip("a polygon", nodes)?;
    t.expect("the parameters of a polygon", "p")?;
    t.number("a polygon's deflection")?;
    if t.flag("whether a polygon has parameters")? {
        t.skip("a polygon's parameters", nodes)?;
    }
    Ok(())
}

fn triangulation(t: &mut Tokens<'_>, version: u32) -> Result<(), ReadError> {
    let nodes = t.count("nodes of a triangulation", 3)?;
    let triangles = t.count("triangles", 3)?;
    let uv = t.flag("whether a triangulation has parameters")?;
    let normals = version >= 3 && t.flag("whether a triangulation has normals")?;
    let words = 3 + if uv { 2 } else { 0 } + if normals { 3 } else { 0 };
    t.skip("a triangulation", 1 + nodes * words + 3 * triangles)
}

impl Tables {
    /// Reads what follows the header.
    pub(super) fn read(t: &mut Tokens<'_>, version: u32) -> Result<Self, ReadError> {
        let places = Places::read(t)?;
        let curves2 = table(t, "Curve2ds", "curves in uv", CURVE_WORDS, |t| {
            Form::read(t, 0)
        })?;
        let curves3 = table(t, "Curves", "curves", CURVE_WORDS, |t| Form::read(t, 0))?;
        let polygons = table(t, "Polygon3D", "polygons", 3, polygon)?.len();
        let polygons_on = table(t, "PolygonOnTriangulations", "polygons", 5, polygon_on)?.len();
        let surfaces = table(t, "Surfaces", "surfaces", SURFACE_WORDS, |t| {
            Form3::read(t, 0)
        })?;
        let triangulations = table(t, "Triangulations", "triangulations", 4, |t| {
            triangulation(t, version)
        })?
        .len();
        t.expect("the name of a table", "TShapes")?;
        let count = t.count("shapes", SHAPE_WORDS)?;
        let counts = Counts {
            curves2: curves2.len(),
            curves3: curves3.len(),
            surfaces: surfaces.len(),
            polygons,
            polygons_on,
            triangulations,
            version,
        };
        let mut shapes = Vec::new();
        for own in 0..count {
            shapes.push(shape(t, &places, &counts, own, count)?);
        }
        let Some(root) = sub(t, &places, count, count)? else {
            return Err(t.fail(TextProblem::Shape {
                what: "the file has no shape".into(),
            }));
        };
        Ok(Self {
            places,
            curves2,
            curves3,
            surfaces,
            shapes,
            meshes: polygons + polygons_on + triangulations,
            root,
        })
    }
}

/// A reference to a shape among the first `known` of `count`: they are numbered from the end. `None` for the
/// end of a list.
fn sub(
    t: &mut Tokens<'_>,
    places: &Places,
    known: usize,
    count: usize,
) -> Result<Option<Sub>, ReadError> {
    const WHAT: &str = "a part of a shape";
    let word = t.word(WHAT)?;
    let (orientation, number) = match word.split_first() {
        Some((b'*', [])) => return Ok(None),
        Some((b'+', number)) => (Orientation::Forward, number),
        Some((b'-', number)) => (Orientation::Reversed, number),
        Some((b'i', number)) => (Orientation::Internal, number),
        Some((b'e', number)) => (Orientation::External, number),
        _ => return Err(t.unexpected(WHAT, word, "+, -, i or e and a number, or `*`")),
    };
    let found = std::str::from_utf8(number)
        .ok()
        .and_then(|w| w.parse::<i64>().ok());
    let Some(found) = found else {
        return Err(t.unexpected(WHAT, word, "+, -, i or e and a number, or `*`"));
    };
    let shape = usize::try_from(found)
        .ok()
        .and_then(|n| count.checked_sub(n));
    match shape {
        Some(shape) if shape < known => Ok(Some(Sub {
            shape,
            orientation,
            place: places.reference(t)?,
        })),
        _ => Err(t.fail(TextProblem::Reference {
            what: "among the shapes before it, shape",
            found,
            count: known,
        })),
    }
}

fn shape(
    t: &mut Tokens<'_>,
    places: &Places,
    counts: &Counts,
    own: usize,
    count: usize,
) -> Result<Shape, ReadError> {
    let word = t.word("the kind of a shape")?;
    let (line, offset) = (t.last_line(), t.position() - word.len());
    let kind = match word {
        b"Ve" => vertex(t, places, counts)?,
        b"Ed" => Kind::Edge(edge(t, places, counts)?),
        b"Wi" => Kind::Wire,
        b"Fa" => face(t, places, counts)?,
        b"Sh" => Kind::Shell,
        b"So" => Kind::Solid,
        b"CS" => Kind::CompSolid,
        b"Co" => Kind::Compound,
        _ => {
            let expected = "Ve, Ed, Wi, Fa, Sh, So, CS or Co";
            return Err(t.unexpected("the kind of a shape", word, expected));
        }
    };
    let flags = t.word("a shape's flags")?;
    if flags.len() != 7 || flags.iter().any(|b| !matches!(b, b'0' | b'1')) {
        return Err(t.unexpected("a shape's flags", flags, "seven digits 0 or 1"));
    }
    let mut parts = Vec::new();
    while let Some(part) = sub(t, places, own, count)? {
        parts.push(part);
    }
    Ok(Shape {
        line,
        offset,
        kind,
        parts,
    })
}

/// What a vertex is on (curves and surfaces) is not used: its point says where it is.
fn vertex(t: &mut Tokens<'_>, places: &Places, counts: &Counts) -> Result<Kind, ReadError> {
    let tolerance = t.number("a vertex's tolerance")?;
    let point = Point3::from(t.numbers::<3>("a vertex's point")?);
    loop {
        t.number("a vertex's parameter")?;
        match t.word("what a vertex is on")? {
            b"0" => return Ok(Kind::Vertex { tolerance, point }),
            b"1" => {
                t.index("curve", counts.curves3)?;
            }
            b"2" => {
                t.index("curve in uv", counts.curves2)?;
                t.index("surface", counts.surfaces)?;
            }
            b"3" => {
                t.number("a vertex's parameter")?;
                t.index("surface", counts.surfaces)?;
            }
            other => return Err(t.unexpected("what a vertex is on", other, "0 to 3")),
        }
        places.reference(t)?;
    }
}

/// How smooth two faces meet; not used. It may hang on the number before it.
fn regularity(t: &mut Tokens<'_>, word: &[u8]) -> Result<(), ReadError> {
    match word {
        b"C0" | b"C1" | b"C2" | b"C3" | b"CN" | b"G1" | b"G2" => Ok(()),
        _ => Err(t.unexpected("a continuity", word, "C0, C1, C2, C3, CN, G1 or G2")),
    }
}

/// The number of a curve in uv with a continuity behind it.
fn second(t: &mut Tokens<'_>, count: usize) -> Result<usize, ReadError> {
    const WHAT: &str = "curve in uv";
    let word = t.word(WHAT)?;
    let digits = word.iter().take_while(|b| b.is_ascii_digit()).count();
    let (number, rest) = word.split_at(digits);
    let found = std::str::from_utf8(number)
        .ok()
        .and_then(|w| w.parse::<i64>().ok());
    let Some(found) = found else {
        return Err(t.unexpected(WHAT, word, "a number"));
    };
    match usize::try_from(found) {
        Ok(i @ 1..) if i <= count => {
            let smooth = if rest.is_empty() {
                t.word("a continuity")?
            } else {
                rest
            };
            regularity(t, smooth)?;
            Ok(i - 1)
        }
        _ => Err(t.fail(TextProblem::Reference {
            what: WHAT,
            found,
            count,
        })),
    }
}

fn edge(t: &mut Tokens<'_>, places: &Places, counts: &Counts) -> Result<Edge, ReadError> {
    let tolerance = t.number("an edge's tolerance")?;
    t.flag("whether an edge's curves have the same parameter")?;
    t.flag("whether an edge's curves have the same range")?;
    let degenerated = t.flag("whether an edge is degenerated")?;
    let mut edge = Edge {
        tolerance,
        degenerated,
        in_space: None,
        on_surfaces: Vec::new(),
    };
    loop {
        let kind = t.word("a representation of an edge")?;
        match kind {
            b"0" => return Ok(edge),
            b"1" => {
                // 0 says that there is none.
                let curve = t.optional_index("curve", counts.curves3)?;
                let place = places.reference(t)?;
                let range = t.numbers("an edge's range")?;
                edge.in_space = curve.map(|curve| InSpace {
                    curve,
                    place,
                    range,
                });
            }
            b"2" | b"3" => {
                let curve = t.index("curve in uv", counts.curves2)?;
                let second = match kind {
                    b"3" => Some(second(t, counts.curves2)?),
                    _ => None,
                };
                let surface = t.index("surface", counts.surfaces)?;
                let place = places.reference(t)?;
                let range = t.numbers("an edge's range on a surface")?;
                if counts.version == 2 {
                    // The ends in uv, once more.
                    t.skip(
                        "the ends of an edge in uv",
                        if second.is_some() { 8 } else { 4 },
                    )?;
                }
                edge.on_surfaces.push(OnSurface {
                    curve,
                    second,
                    surface,
                    place,
                    range,
                });
            }
            b"4" => {
                let smooth = t.word("a continuity")?;
                regularity(t, smooth)?;
                for _ in 0..2 {
                    t.index("surface", counts.surfaces)?;
                    places.reference(t)?;
                }
            }
            b"5" => {
                t.optional_index("polygon", counts.polygons)?;
                places.reference(t)?;
            }
            b"6" | b"7" => {
                for _ in 0..if kind == b"6" { 1 } else { 2 } {
                    t.optional_index("polygon", counts.polygons_on)?;
                }
                t.optional_index("triangulation", counts.triangulations)?;
                places.reference(t)?;
            }
            _ => return Err(t.unexpected("a representation of an edge", kind, "0 to 7")),
        }
    }
}

fn face(t: &mut Tokens<'_>, places: &Places, counts: &Counts) -> Result<Kind, ReadError> {
    t.flag("whether a face has its surface's borders")?;
    t.number("a face's tolerance")?;
    let surface = t.optional_index("surface", counts.surfaces)?;
    let place = places.reference(t)?;
    // Flags have seven digits.
    if t.peek() == Some(b"2") {
        t.skip("a face's triangulation", 1)?;
        t.optional_index("triangulation", counts.triangulations)?;
    }
    Ok(Kind::Face { surface, place })
}
