//! Triangles instead of trimmed faces.
//!
//! # Method
//! 1. Each surface gets a grid of parameters (`steps`): so many that the normal turns by at most
//!    [`Rule::degrees`] from one grid line to the next along a parameter line, and that the chords stay
//!    within [`Rule::chord`]. Both are judged from samples of the derivatives.
//! 2. Each edge is cut once (`edges`), by the turning of its tangent and of the normals beside it. Its points lie
//!    on the image of **one** of its trims, and all faces at the edge use them: closed BREPs give closed meshes.
//! 3. Each face (`face`): grid cells clear of all trims become two triangles each; the rest, between these cells
//!    and the trims, is a constrained Delaunay triangulation in the parameter space of the grid. Triangles are
//!    kept by the parity of the polygons that stand for the loops. Where polygons of a closed BREP cross, since chords cut
//!    corners, all is done again with edges cut twice as finely.
//!
//! # Guarantee
//! None in the sense of an enclosure. [`Mesh::chord_error`] is the largest distance *found*: from triangles to their
//! surface (at four points of some 2,000 triangles a face), and from edges to their chords (in the middle of
//! each). [`Mesh::open_edges`] counts where the mesh is not closed: at coarse angles different patches may share their corner
//! points and fall into one. Triangles turn as their faces say; where a file's flags of orientation are wrong, so
//! is the mesh, and [`Mesh::open_edges`] shows it.
//!
//! # Cost
//! Proportional to the triangles, about 1 us each; 1 degree on a sphere gives some 1e5.

mod edges;
mod face;
mod steps;

use feeler::brep::Brep;
use nalgebra::Point2;
use std::collections::HashMap;

/// How finely to cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Angle between neighbouring normals along parameter lines, and between neighbouring tangents
    /// along edges, in degrees; above 0. 180: the corner points of each patch, as far as
    /// patches turn by less than 150.
    pub degrees: f64,
    /// How far a chord may be from the surface, in model units; infinite for no such limit.
    pub chord: f64,
}

/// Triangles that stand for a BREP.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corners.
    pub vertices: Vec<[f64; 3]>,
    /// Three corners each; counter-clockwise seen from the side the face's normal points to.
    pub triangles: Vec<[u32; 3]>,
    /// The face that each triangle stands for.
    pub faces: Vec<u32>,
    /// The largest distance found between a face and the triangle that stands for it, in model units: sampled.
    pub chord_error: f64,
    /// The BREP's edges, and trims that have none, as the faces beside them use them; not poles.
    pub edges: Vec<EdgeLine>,
    /// Where the corners of each triangle lie on the surface of its face; empty unless [`tessellate_with_uv`] made it.
    pub uv: Vec<[Point2<f64>; 3]>,
    /// Whether to keep [`uv`](Self::uv).
    keep_uv: bool,
}

/// An edge as corners of a [`Mesh`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EdgeLine {
    /// The edge; `None` for a trim that has none.
    pub edge: Option<usize>,
    /// The faces that use it, one for each use: twice the same at a seam.
    pub faces: Vec<usize>,
    /// Its corners, in order.
    pub vertices: Vec<u32>,
}

/// How often the angle for edges is halved where polygons that stand for loops cross.
const FINER: usize = 4;

/// More triangles than this are refused: 13 million are 0.1 degrees on the ball joint.
pub const MOST_TRIANGLES: usize = 40_000_000;

/// Cuts a BREP into triangles.
///
/// # Errors
/// In one line: the rule is no rule, or asks for more than [`MOST_TRIANGLES`]; a face cannot be
/// triangulated.
pub fn tessellate(brep: &Brep, rule: &Rule) -> Result<Mesh, String> {
    made(brep, rule, false, MOST_TRIANGLES).map_err(|why| match why {
        Stopped::TooMany => {
            format!("more than {MOST_TRIANGLES} triangles: ask for a larger angle")
        }
        Stopped::Face(why) => why,
    })
}

/// The same, and where on their surfaces the triangles' corners lie: for normals that do not depend on the triangles. Costs 48 bytes a
/// triangle. `None` where there would be more than `most` triangles, those included that trims cut off of the faces' grids.
///
/// # Errors
/// As [`tessellate`].
pub fn tessellate_with_uv(brep: &Brep, rule: &Rule, most: usize) -> Result<Option<Mesh>, String> {
    let limit = most.min(MOST_TRIANGLES);
    match made(brep, rule, true, limit) {
        Ok(mesh) => Ok((mesh.triangles.len() <= limit).then_some(mesh)),
        Err(Stopped::TooMany) => Ok(None),
        Err(Stopped::Face(why)) => Err(why),
    }
}

/// Why there is no mesh.
#[derive(Debug)]
enum Stopped {
    /// More triangles than are allowed.
    TooMany,
    /// A face cannot be triangulated.
    Face(String),
}

fn made(brep: &Brep, rule: &Rule, keep_uv: bool, most: usize) -> Result<Mesh, Stopped> {
    if !(rule.degrees > 0.0 && rule.chord > 0.0) {
        return Err(Stopped::Face(
            "the angle and the chord must be above 0".into(),
        ));
    }
    let mut finer = *rule;
    for attempt in 0..=FINER {
        let mut mesh = Mesh {
            keep_uv,
            ..Mesh::default()
        };
        let edges = edges::cut(brep, &finer, &mut mesh);
        let mut crossed = false;
        for face in 0..brep.faces().len() {
            crossed |=
                face::triangulate(brep, face, rule, &edges, most, &mut mesh).map_err(|why| {
                    match why {
                        Stopped::TooMany => Stopped::TooMany,
                        Stopped::Face(why) => Stopped::Face(format!("face {face}: {why}")),
                    }
                })?;
        }
        // Loops of an open sheet may well cross; those of a solid do so since their chords are too coarse.
        if !crossed || !brep.is_closed() || attempt == FINER {
            return Ok(mesh);
        }
        finer.degrees = finer.degrees.min(steps::WIDEST) / 2.0;
    }
    Ok(Mesh::default())
}

impl Mesh {
    fn vertex(&mut self, point: [f64; 3]) -> u32 {
        self.vertices.push(point);
        (self.vertices.len() - 1) as u32
    }

    /// A triangle, unless two of its corners are one (at a pole). `uv` is asked where it is kept.
    fn triangle(&mut self, corners: [u32; 3], face: usize, uv: impl FnOnce() -> [Point2<f64>; 3]) {
        let [a, b, c] = corners;
        if a != b && b != c && c != a {
            self.triangles.push(corners);
            self.faces.push(face as u32);
            if self.keep_uv {
                self.uv.push(uv());
            }
        }
    }

    /// How many sides of triangles have no partner that runs the other way. 0: the mesh is closed, each of its edges
    /// used exactly twice, and all triangles agree about which side is outside.
    pub fn open_edges(&self) -> usize {
        let mut uses: HashMap<(u32, u32), [usize; 2]> = HashMap::new();
        for t in &self.triangles {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                uses.entry((a.min(b), a.max(b))).or_default()[usize::from(a > b)] += 1;
            }
        }
        let odd = |u: &[usize; 2]| if *u == [1, 1] { 0 } else { u[0] + u[1] };
        uses.values().map(odd).sum()
    }

    /// The volume enclosed, positive where the triangles turn outward; meaningless for an open mesh.
    pub fn volume(&self) -> f64 {
        let at = |i: u32| nalgebra::Vector3::from(self.vertices[i as usize]);
        let six = |t: &[u32; 3]| at(t[0]).dot(&at(t[1]).cross(&at(t[2])));
        self.triangles.iter().map(six).sum::<f64>() / 6.0
    }

    /// The sum of the triangles' areas.
    pub fn area(&self) -> f64 {
        let at = |i: u32| nalgebra::Vector3::from(self.vertices[i as usize]);
        let twice = |t: &[u32; 3]| (at(t[1]) - at(t[0])).cross(&(at(t[2]) - at(t[0]))).norm();
        self.triangles.iter().map(twice).sum::<f64>() / 2.0
    }
}
