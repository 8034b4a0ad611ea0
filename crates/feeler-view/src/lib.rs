//! Pictures of parts, probes and answers.
//!
//! A [`View`] is parts cut into triangles ([`Part`]) and queries with their answers ([`Shown`]). [`View::page`] is one HTML file that
//! needs nothing else: WebGL 2 in the browser, turned and zoomed by mouse. [`View::glb`] is the same as binary glTF 2.0.
//!
//! # What is shown
//! - Faces, as triangles whose chords stay within a part of the model's size that is stated on the page; how far the largest found is
//!   off, too. The method is [`feeler_gate::tessellate`]'s: an edge is cut once for all faces at it, so there are no
//!   cracks but those the BREP has. Shading takes the surface's normals, not the triangles'.
//! - Edges: of two faces, seams, and open borders (or edges used more than twice).
//! - Of a query the probe, and the answer: contacts with both points and the normal, hits with the faces' normals, points on their side.
//!   What is drawn are the numbers of the answer, rounded to f32 from the part's centre.
//!
//! Pictures prove nothing: triangles are off by their chords, and a gap smaller than a pixel is not seen.
#![forbid(unsafe_code)]

mod glb;
mod page;
mod part;
mod shapes;
mod shown;
mod suite;

pub use glb::GlbError;
pub use part::{EdgeKind, FaceRange, Fineness, MOST_TRIANGLES, Part, Polyline};
pub use shown::{Mark, MarkKind, Plane, ProbeShape, Shown, Stretch};
pub use suite::suite;

use feeler_corpus::{Model, QueryLine};
use feeler_gate::{Engine, FeelerEngine};

/// Queries beyond these are not drawn: a list longer than this is no picture.
pub const MOST_QUERIES: usize = 2000;

/// A query by the number of its line; or why the line is none.
pub type NumberedLine = (usize, Result<QueryLine, String>);

/// Parts, and what was asked about them.
#[derive(Clone, Debug, Default)]
pub struct View {
    /// A headline.
    pub title: String,
    /// What else there is to say, a line each.
    pub notes: Vec<String>,
    /// The parts.
    pub parts: Vec<Part>,
    /// Queries and answers, each about one of the parts.
    pub queries: Vec<Shown>,
    /// Whether the page opens with a picture of each query.
    pub overview: bool,
}

impl View {
    /// A model by itself.
    ///
    /// # Errors
    /// In one line: a face cannot be cut into triangles, or there would be too many of them.
    pub fn new(title: &str, model: &Model, fineness: &Fineness) -> Result<Self, String> {
        Ok(Self {
            title: title.to_owned(),
            parts: vec![Part::new(title, model, fineness)?],
            ..Self::default()
        })
    }

    /// Asks the kernel lines of queries about the one part and draws its answers. A line's `model` must end the path of the model, or
    /// the line is about another one and left out; a line that is refused is listed with what is wrong. At most [`MOST_QUERIES`] are
    /// taken. How many were refused.
    ///
    /// # Errors
    /// The kernel cannot open the model.
    pub fn ask(
        &mut self,
        model: &Model,
        engine: &mut FeelerEngine,
        lines: impl IntoIterator<Item = NumberedLine>,
    ) -> Result<usize, String> {
        let Some(part) = self.parts.first() else {
            return Ok(0);
        };
        let mut lines = lines.into_iter().peekable();
        if lines.peek().is_none() {
            return Ok(0);
        }
        engine.open(model)?;
        let (mut refused, mut others) = (0, 0);
        for (number, line) in lines {
            let about = |l: &QueryLine| l.model.as_ref().is_none_or(|m| model.path.ends_with(m));
            if line.as_ref().is_ok_and(|l| !about(l)) {
                others += 1;
                continue;
            }
            if self.queries.len() == MOST_QUERIES {
                let note = format!("more than {MOST_QUERIES} queries: the first are shown");
                self.notes.push(note);
                break;
            }
            let shown = Shown::ask(model, part, engine, number, &line);
            refused += usize::from(shown.state == "refused");
            self.queries.push(shown);
        }
        if others > 0 {
            self.notes
                .push(format!("{others} queries name another model: not shown"));
        }
        Ok(refused)
    }
}
