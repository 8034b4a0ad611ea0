//! A model as triangles and lines.

use feeler::brep::Brep;
use feeler::nurbs::Surface;
use feeler_corpus::Model;
use feeler_gate::tessellate::{Mesh, Rule, tessellate_with_uv};
use nalgebra::{Point2, Point3, Vector3};
use std::collections::HashMap;

/// As many triangles as a browser turns without stutter, and a page of some 50 MB.
pub const MOST_TRIANGLES: usize = 1_000_000;

/// How finely to cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// How far a chord may be from the surface, as a part of the model's size.
    pub chord: f64,
    /// The angle between neighbouring normals, in degrees: what a chord does not see of small roundings.
    pub degrees: f64,
    /// No more triangles than this: the part is cut more coarsely instead, which is said.
    pub most: usize,
}

impl Default for Fineness {
    fn default() -> Self {
        Self {
            chord: 1e-3,
            degrees: 20.0,
            most: MOST_TRIANGLES,
        }
    }
}

/// The triangles of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaceRange {
    /// Its number through the model's BREPs.
    pub face: usize,
    /// What its surface is stored as.
    pub kind: &'static str,
    /// Its first triangle.
    pub first: usize,
    /// How many it has.
    pub count: usize,
}

/// What an edge is to the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// Between two faces.
    Shared,
    /// Used twice by one face.
    Seam,
    /// Used once, or more than twice.
    Border,
}

/// An edge.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// What it is.
    pub kind: EdgeKind,
    /// Its points, relative to the part's centre: bit for bit corners of triangles of the faces at it.
    pub points: Vec<[f32; 3]>,
}

/// A model cut into triangles.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// What it is called.
    pub name: String,
    /// The middle of its box, in model units: where its coordinates count from.
    pub center: [f64; 3],
    /// Distance of the farthest corner from the centre, in model units.
    pub radius: f64,
    /// Longest side of the box of all faces, in model units.
    pub size: f64,
    /// Chords asked for, in model units.
    pub chord: f64,
    /// The largest chord error found, in model units: sampled.
    pub chord_found: f64,
    /// What there is to say.
    pub notes: Vec<String>,
    /// The faces, in order; all their triangles.
    pub faces: Vec<FaceRange>,
    /// Corners relative to the centre; a corner for each normal there.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals of the faces at the corners, outward as the face says.
    pub normals: Vec<[f32; 3]>,
    /// Three corners each, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The edges.
    pub edges: Vec<Polyline>,
}

/// How often a part is cut more coarsely before it is refused.
const COARSER: usize = 12;
/// A step towards coarser chords; triangles go with the inverse.
const COARSER_BY: f64 = 4.0;
/// No coarser angle than this.
const WIDEST: f64 = 90.0;

/// No chord below this part of the size, and no angle below this, is drawn: edges are cut before triangles can be counted.
const LEAST_CHORD: f64 = 1e-9;
const LEAST_DEGREES: f64 = 1e-2;

impl Part {
    /// Cuts a model.
    ///
    /// # Errors
    /// In one line: the fineness is none, a face cannot be cut, or there are too many triangles even coarsely.
    pub fn new(name: &str, model: &Model, fineness: &Fineness) -> Result<Self, String> {
        if !(fineness.chord >= LEAST_CHORD && fineness.degrees >= LEAST_DEGREES) {
            return Err(format!(
                "no chord below {LEAST_CHORD:e} of the size and no angle below {LEAST_DEGREES} degrees is drawn"
            ));
        }
        let size = size(model);
        let mut rule = Rule {
            degrees: fineness.degrees,
            chord: fineness.chord * size,
        };
        // A model of one point has no size.
        if rule.chord.is_nan() || rule.chord <= 0.0 {
            rule.chord = f64::INFINITY;
        }
        let asked = rule.chord;
        for _ in 0..COARSER {
            if let Some(found) = meshes(model, &rule, fineness.most)? {
                let goal = rule.chord;
                let found = finer(model, rule, fineness.most, found)?;
                let mut part = Self::of(name, model, &found, size, goal);
                if part.chord_found > goal {
                    part.notes.push(format!(
                        "chords are off by up to {:.3e} where {goal:.3e} was asked for; where faces do not meet at their edge, which is cut once for both, no finer ones help \
                         (`feeler inspect --health` names such cracks)",
                        part.chord_found
                    ));
                }
                if goal > asked {
                    let n = fineness.most;
                    part.notes.push(format!("cut more coarsely than asked (chords within {asked:.3e}): it would have more than {n} triangles"));
                }
                return Ok(part);
            }
            rule.chord *= COARSER_BY;
            rule.degrees = (rule.degrees * COARSER_BY.sqrt()).min(WIDEST);
        }
        Err(format!(
            "more than {} triangles, however coarsely it is cut",
            fineness.most
        ))
    }

    fn of(name: &str, model: &Model, meshes: &[Mesh], size: f64, chord: f64) -> Self {
        let mut lo = Vector3::repeat(f64::INFINITY);
        let mut hi = -lo;
        for p in meshes.iter().flat_map(|m| &m.vertices) {
            (lo, hi) = (lo.inf(&(*p).into()), hi.sup(&(*p).into()));
        }
        let center = match lo.x <= hi.x {
            true => lo + (hi - lo) / 2.0,
            false => Vector3::zeros(), // No face has any triangle.
        };
        let all = meshes.iter().flat_map(|m| &m.vertices);
        let radius = all.fold(0.0f64, |r, p| r.max((Vector3::from(*p) - center).norm()));
        let found = meshes.iter().fold(0.0f64, |e, m| e.max(m.chord_error));
        let mut part = Self {
            name: name.to_owned(),
            center: center.into(),
            radius: radius.max(f64::MIN_POSITIVE),
            size,
            chord,
            chord_found: found,
            ..Self::default()
        };
        let mut faces = 0;
        for (brep, mesh) in model.breps.iter().zip(meshes) {
            part.add(brep, mesh, faces);
            faces += brep.faces().len();
        }
        part
    }

    /// A point of the model as it is drawn.
    pub fn local(&self, p: &[f64; 3]) -> [f32; 3] {
        [0, 1, 2].map(|c| (p[c] - self.center[c]) as f32)
    }

    /// The faces of one BREP, whose numbers start at `before`.
    fn add(&mut self, brep: &Brep, mesh: &Mesh, before: usize) {
        let at = |v: u32| self.local(&mesh.vertices[v as usize]);
        let places: Vec<[f32; 3]> = (0..mesh.vertices.len() as u32).map(at).collect();
        let mut next = 0;
        for face in 0..brep.faces().len() {
            let first = self.triangles.len();
            let surface = brep.surface(face);
            let reversed = brep.faces()[face].reversed;
            let mut corners: HashMap<(u32, [i16; 3]), u32> = HashMap::new();
            // The triangles of a face lie together, in the order of faces.
            while next < mesh.triangles.len() && mesh.faces[next] as usize == face {
                let ids = mesh.triangles[next];
                let uv = mesh.uv[next];
                let flat = flat_normal(ids.map(|i| mesh.vertices[i as usize]));
                let triangle = [0, 1, 2].map(|k| {
                    let own = normal(surface, &uv, k).map(|n| if reversed { -n } else { n });
                    let n = own.or(flat).unwrap_or(Vector3::z());
                    let key = (ids[k], quantised(&n));
                    *corners.entry(key).or_insert_with(|| {
                        self.positions.push(places[ids[k] as usize]);
                        self.normals.push([0, 1, 2].map(|c| n[c] as f32));
                        (self.positions.len() - 1) as u32
                    })
                });
                self.triangles.push(triangle);
                next += 1;
            }
            self.faces.push(FaceRange {
                face: before + face,
                kind: kind(surface),
                first,
                count: self.triangles.len() - first,
            });
            if brep.faces()[face].loops.is_none() {
                let from = mesh.faces.partition_point(|f| (*f as usize) < face);
                self.edges
                    .extend(domain_border(surface, mesh, from, next, &places));
            }
        }
        for edge in &mesh.edges {
            let kind = match edge.faces[..] {
                [a, b] if a == b => EdgeKind::Seam,
                [_, _] => EdgeKind::Shared,
                _ => EdgeKind::Border,
            };
            let points = edge.vertices.iter().map(|v| places[*v as usize]).collect();
            self.edges.push(Polyline { kind, points });
        }
    }
}

/// How often a model is cut anew because a chord was found to be off by more than asked: chords are judged from samples before the cut.
const AGAIN: usize = 4;

fn worst(meshes: &[Mesh]) -> f64 {
    meshes.iter().fold(0.0f64, |e, m| e.max(m.chord_error))
}

/// The same model cut so finely that no chord is found to be off by more than asked, as far as the triangles allow.
fn finer(model: &Model, rule: Rule, most: usize, first: Vec<Mesh>) -> Result<Vec<Mesh>, String> {
    /// A little more than what is missing.
    const MORE: f64 = 0.9;
    let mut found = first;
    let mut tried = rule;
    for _ in 0..AGAIN {
        let off = worst(&found);
        if !(off > rule.chord) {
            break;
        }
        tried.chord *= MORE * rule.chord / off;
        match meshes(model, &tried, most)? {
            Some(next) if worst(&next) < off => found = next,
            _ => break,
        }
    }
    Ok(found)
}

/// All BREPs cut; none where there are more triangles than allowed.
fn meshes(model: &Model, rule: &Rule, most: usize) -> Result<Option<Vec<Mesh>>, String> {
    let mut all = Vec::with_capacity(model.breps.len());
    let mut left = most;
    for brep in &model.breps {
        let Some(mesh) = tessellate_with_uv(brep, rule, left)? else {
            return Ok(None);
        };
        left -= mesh.triangles.len().min(left);
        all.push(mesh);
    }
    Ok(Some(all))
}

/// The longest side of the box of all faces, from samples: off by a few parts in a hundred, and by more only where a face
/// of few trims is far from flat between them.
fn size(model: &Model) -> f64 {
    /// Samples a trim, and each way across the trims' box in uv.
    const SAMPLES: usize = 8;
    let part = |k: usize| k as f64 / SAMPLES as f64;
    let mut lo = Vector3::repeat(f64::INFINITY);
    let mut hi = -lo;
    for brep in &model.breps {
        let parts = brep.parts();
        for (index, face) in brep.faces().iter().enumerate() {
            let surface = brep.surface(index);
            let mut box_uv = surface.domain().map(|d| [d.start, d.end]);
            let mut uv = Vec::new();
            if let Some(loops) = &face.loops {
                for trim in loops.iter().flat_map(|l| &parts.loops[*l].trims) {
                    let trim = &parts.trims[*trim];
                    let curve = &parts.curves2[trim.curve];
                    uv.extend((0..=SAMPLES).map(|k| curve.point(trim.span.lerp(part(k)))));
                }
                for axis in 0..2 {
                    let [from, to] = box_uv[axis];
                    let along = uv.iter().map(|p| p[axis]);
                    let least = along.clone().fold(to, f64::min).max(from);
                    box_uv[axis] = [least, along.fold(from, f64::max).min(to)];
                }
            }
            let at = |axis: usize, k: usize| {
                let [from, to] = box_uv[axis];
                from + (to - from) * part(k)
            };
            let grid = (0..=SAMPLES).flat_map(|i| (0..=SAMPLES).map(move |j| (i, j)));
            // Trimmed away at the corners, perhaps; of a face of few trims the middle counts.
            if uv.len() <= 4 * (SAMPLES + 1) {
                uv.extend(grid.map(|(i, j)| Point2::new(at(0, i), at(1, j))));
            }
            for p in uv {
                let p = surface.point(p.x, p.y).coords;
                (lo, hi) = (lo.inf(&p), hi.sup(&p));
            }
        }
    }
    (hi - lo).max().max(0.0)
}

fn kind(surface: &Surface) -> &'static str {
    match surface {
        Surface::Plane(_) => "plane",
        Surface::Revolution(_) => "revolution",
        Surface::Sum(_) => "extrusion or sum",
        Surface::Nurbs(_) => "NURBS",
    }
}

/// As in the page: two normals that are one there need one corner.
pub(crate) fn quantised(n: &Vector3<f64>) -> [i16; 3] {
    [0, 1, 2].map(|c| (n[c] * f64::from(i16::MAX)).round() as i16)
}

/// The surface's normal at a corner of a triangle, taken a little inside it, where knots and poles do no harm.
fn normal(surface: &Surface, uv: &[Point2<f64>; 3], k: usize) -> Option<Vector3<f64>> {
    /// Parts of the way to the triangle's middle; the second for poles of higher order.
    const INSIDE: [f64; 2] = [1e-4, 1e-2];
    let middle = (uv[0].coords + uv[1].coords + uv[2].coords) / 3.0;
    INSIDE.iter().find_map(|s| {
        let at = uv[k].coords.lerp(&middle, *s);
        let d = surface.derivatives(at.x, at.y, 1);
        let n = d.get(1, 0).cross(&d.get(0, 1));
        let unit = n / n.norm();
        unit.iter().all(|x| x.is_finite()).then_some(unit)
    })
}

fn flat_normal(corners: [[f64; 3]; 3]) -> Option<Vector3<f64>> {
    let [a, b, c] = corners.map(Vector3::from);
    let n = (b - a).cross(&(c - a));
    let unit = n / n.norm();
    unit.iter().all(|x| x.is_finite()).then_some(unit)
}

/// The border of the domain of a face without loops, through corners of its triangles: a seam where two sides fall into one, nothing at poles.
fn domain_border(
    surface: &Surface,
    mesh: &Mesh,
    first: usize,
    end: usize,
    places: &[[f32; 3]],
) -> Vec<Polyline> {
    /// Sides nearer than this part of a side's length are one.
    const SAME: f64 = 1e-9;
    let domain = surface.domain();
    let mut sides: Vec<[Vec<(f64, u32)>; 2]> = Vec::new();
    for axis in 0..2 {
        let mut both: [Vec<(f64, u32)>; 2] = Default::default();
        for t in first..end {
            for k in 0..3 {
                let uv = mesh.uv[t][k];
                let ends = [domain[axis].start, domain[axis].end];
                for (to, end) in both.iter_mut().zip(ends) {
                    if uv[axis] == end {
                        to.push((uv[1 - axis], mesh.triangles[t][k]));
                    }
                }
            }
        }
        for side in &mut both {
            side.sort_by(|a, b| a.0.total_cmp(&b.0));
            side.dedup_by_key(|s| s.1);
        }
        sides.push(both);
    }
    let point = |v: u32| Point3::from(mesh.vertices[v as usize]);
    let mut found = Vec::new();
    for [low, high] in sides {
        let length = |side: &[(f64, u32)]| {
            let steps = side.windows(2);
            steps
                .map(|w| (point(w[1].1) - point(w[0].1)).norm())
                .sum::<f64>()
        };
        let longest = length(&low).max(length(&high));
        let closed = low.len() == high.len()
            && low
                .iter()
                .zip(&high)
                .all(|(a, b)| (point(a.1) - point(b.1)).norm() <= SAME * longest);
        let kind = match closed {
            true => EdgeKind::Seam,
            false => EdgeKind::Border,
        };
        for side in if closed { vec![low] } else { vec![low, high] } {
            if length(&side) > SAME * longest {
                let points = side.iter().map(|s| places[s.1 as usize]).collect();
                found.push(Polyline { kind, points });
            }
        }
    }
    found
}
