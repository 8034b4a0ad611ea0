//! One solid, or one set of faces, as a BREP.

use super::chart::{Chart, nearest};
use super::entities::{form, no_room, problem, shape, unsupported};
use super::geometry::{EdgeForm, Geometry};
use super::hyperbola::{bounded, pieces};
use super::loops::{Maker, Trouble, Use, closed, lifted};
use super::part21::Attribute;
use super::pcurve::{Made, grow, made, pole, taken};
use super::smooth::cut_off;
use crate::affine::rounded_up;
use crate::error::ReadError;
use crate::numbers::{numbers, numbers_of_spline, numbers_of_surface};
use crate::occt::builder::{Builder, EdgeUse};
use crate::occt::curves::Form;
use crate::occt::motion::{Motion, Place};
use crate::occt::surfaces::{Form3, wide};
use crate::sheets::{ROUNDING, jumps, kinds};
use crate::step_problem::StepProblem;
use feeler::brep::{Brep, Edge, Vertex};
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Curve2, Curve3};
use feeler::prepare::trim_offsets;
use nalgebra::{Point2, Point3};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::f64::consts::TAU;
use std::rc::Rc;

/// A face, or a set of them, with whether it is used as it stands.
#[derive(Clone, Copy)]
pub(super) struct FaceUse {
    pub(super) id: u64,
    pub(super) forward: bool,
}

/// How often a body is begun again because edges must be split; each time all that are seen to be are.
const MOST_SPLITS: usize = 256;

/// How deep lists of shells and faces may nest: files have three levels.
const MOST_NESTED: usize = 10;

/// What a use of an edge, and a fitted curve, count for among the numbers that a file may unfold to: files list the same edges and faces
/// again at a few bytes each, and each takes its time.
const USE: usize = 512;
const FITTED: usize = 4096;
/// Numbers that a use holds beside its curves, in lists that double: files have some 80 bytes for one.
const HELD: usize = 32;
/// And more in those that it is in once its curve in uv is made, which may take most of what is left.
const LISTED: usize = 16;
/// And a face beside its surface, with the seam and the poles that are made for it: a shell may list it again at three bytes.
const FACE: usize = 160;

/// What the kernel takes for proofs, in bytes, beside what it is given: lists of what is asked for.
const PROOF_WORK: usize = 1 << 10;

/// What a body has become.
pub(super) struct Made3 {
    pub(super) brep: Brep,
    pub(super) images: Images,
    pub(super) warnings: Vec<String>,
    /// Faces that cannot be read: the number and why.
    pub(super) left_out: Vec<(u64, ReadError)>,
}

/// What is known of how far the images of a body's trims are from its edges' curves.
#[derive(Clone, Copy)]
pub(super) struct Images {
    /// Of those that are proven, in the body's units.
    bound: f64,
    /// How many these are.
    proven: usize,
    /// How many are not proven.
    left: usize,
    /// How many curves in uv are fitted.
    fitted: usize,
}

impl Images {
    /// What to tell where the body is placed by a map that stretches no length more than `stretch` times, and whose roundings put points off by `off` at
    /// most: those of both, the image and the edge.
    pub(super) fn said(&self, stretch: f64, off: f64) -> Vec<String> {
        let mut said = Vec::new();
        if self.proven > 0 || self.left > 0 {
            let made = "curves in uv are made here where the file's are not used";
            let fit = match self.fitted {
                0 => String::new(),
                n => format!("; {n} of them are fitted"),
            };
            let which = match self.left {
                0 => "all".to_owned(),
                _ => self.proven.to_string(),
            };
            let bound = rounded_up(self.bound * stretch + 2.0 * off);
            said.push(match self.proven {
                0 => format!("{made}{fit}"),
                _ => format!(
                    "{made}: {which} images are within {bound} of the edges' curves (proven){fit}"
                ),
            });
        }
        if self.left > 0 {
            said.push(format!(
                "{} more are too many to be proven while reading, or take too much memory for the file's size: `inspect --health` does",
                self.left
            ));
        }
        said
    }
}

/// A piece of an edge, along its curve.
#[derive(Clone, Copy)]
struct Piece {
    key: usize,
    /// Among the BREP's: a copy for each use would be many times the file.
    curve: usize,
    span: Interval,
    vertices: [usize; 2],
}

/// An edge of the file.
struct FileEdge {
    pieces: Vec<Piece>,
    /// Whether the curve runs as the edge does.
    forward: bool,
    pcurves: Vec<u64>,
}

pub(super) struct Body<'g, 'e> {
    geometry: &'g mut Geometry<'e>,
    b: Builder,
    size: f64,
    tolerance: f64,
    edges: HashMap<u64, Rc<FileEdge>>,
    /// Edges that must be split, and where.
    splits: HashMap<u64, Vec<f64>>,
    /// The edge of each key.
    keys: Vec<u64>,
    /// How far images are from their edges, as far as that is known by formula.
    bound: f64,
    /// Trims whose bound the kernel must find, and what that costs.
    unbounded: Vec<(usize, usize)>,
    fitted: usize,
}

/// The faces of a set: of a shell, a body or a model.
pub(super) fn faces(geometry: &mut Geometry<'_>, body: u64) -> Result<Vec<FaceUse>, ReadError> {
    let entities = geometry.entities;
    let mut faces = Vec::new();
    // Lists that are not gone through yet, the innermost last.
    let first = Attribute::EntityRef(body);
    let mut open = vec![(std::slice::from_ref(&first).iter(), true)];
    while let Some((list, forward)) = open.last_mut() {
        let (next, forward) = (list.next(), *forward);
        let Some(next) = next else {
            open.pop();
            continue;
        };
        let Attribute::EntityRef(id) = *next else {
            let what = format!(
                "{} lists what is no shell or face",
                entities.described(body)
            );
            return Err(shape(body, what));
        };
        // Each may list all others, and again.
        geometry.numbers.take(USE).map_err(form(body))?;
        let Some(e) = entities.simple(id) else {
            return Err(entities.unexpected(id, id, "a shell or face"));
        };
        let one = |index: usize| {
            e.reference(index)
                .map(|_| e.get(index).map_or(&[][..], std::slice::from_ref))
        };
        match e.name {
            "MANIFOLD_SOLID_BREP" | "FACETED_BREP" => open.push((one(1)?.iter(), forward)),
            "BREP_WITH_VOIDS" => {
                open.push((e.list(2)?.iter(), forward));
                open.push((one(1)?.iter(), forward));
            }
            "SHELL_BASED_SURFACE_MODEL"
            | "FACE_BASED_SURFACE_MODEL"
            | "OPEN_SHELL"
            | "CLOSED_SHELL"
            | "CONNECTED_FACE_SET" => open.push((e.list(1)?.iter(), forward)),
            "ORIENTED_CLOSED_SHELL" | "ORIENTED_OPEN_SHELL" | "ORIENTED_FACE" => {
                open.push((one(2)?.iter(), forward == e.flag(3)?));
            }
            "ADVANCED_FACE" | "FACE_SURFACE" => {
                geometry.left.held.take(FACE).map_err(form(body))?;
                faces.push(FaceUse { id, forward });
            }
            _ => {
                let what = format!("a face or shell of kind {}", entities.described(id));
                return Err(unsupported(
                    id,
                    what,
                    "export the part as a solid or surfaces",
                ));
            }
        }
        if open.len() > MOST_NESTED {
            return Err(shape(id, "shells within each other too deep"));
        }
    }
    Ok(faces)
}

/// The BREP of some faces; of those that can be read, if there are any. `tolerance`: how far apart what the file says to be one may be, in
/// its units.
pub(super) fn brep(
    id: u64,
    geometry: &mut Geometry<'_>,
    faces: &[FaceUse],
    size: f64,
    tolerance: f64,
) -> Result<Made3, ReadError> {
    let mut splits = HashMap::new();
    // By place: what a face that fails has begun is not kept, so that all is begun again without it.
    let mut left_out: BTreeMap<usize, ReadError> = BTreeMap::new();
    let held = geometry.left.held.clone();
    for _ in 0..MOST_SPLITS {
        // What was begun before is let go.
        geometry.left.held = held.clone();
        let mut body = Body {
            geometry: &mut *geometry,
            b: Builder::default(),
            size,
            tolerance,
            edges: HashMap::new(),
            splits: std::mem::take(&mut splits),
            keys: Vec::new(),
            bound: 0.0,
            unbounded: Vec::new(),
            fitted: 0,
        };
        // All edges that this time shows to be split, each once: what is begun again then finds them so.
        let mut found: HashMap<u64, f64> = HashMap::new();
        let mut failed = Vec::new();
        for (i, face) in faces.iter().enumerate() {
            if left_out.contains_key(&i) {
                continue;
            }
            match body.face(*face) {
                Ok(None) => {}
                Ok(Some((edge, at))) => {
                    found.entry(edge).or_insert(at);
                }
                Err(problem) => match no_room(id, &problem) {
                    // No face is bad for it, and others would fail alike.
                    Some(of_body) => return Err(of_body),
                    // May be no error once the edges are split.
                    None if !found.is_empty() => {}
                    None => failed.push((i, problem)),
                },
            }
        }
        if found.is_empty() && failed.is_empty() {
            return body.finish(id, faces, left_out);
        }
        splits = body.splits;
        if found.is_empty() {
            left_out.extend(failed);
            if left_out.len() == faces.len()
                && let Some((_, first)) = left_out.pop_first()
            {
                return Err(first);
            }
        }
        for (edge, at) in found {
            splits.entry(edge).or_default().push(at);
        }
    }
    Err(problem(
        id,
        StepProblem::Limit {
            what: "edges to split",
            limit: MOST_SPLITS,
        },
    ))
}

struct Seams<'b> {
    b: &'b mut Builder,
    chart: &'b Chart,
}

impl Maker for Seams<'_> {
    fn vertex(&mut self, uv: Point2<f64>) -> usize {
        vertex(self.b, self.chart.point(&uv))
    }

    fn seam(&mut self, vertices: [usize; 2]) -> usize {
        let key = self.b.edges.len();
        edge(self.b, key, None, vertices);
        key
    }
}

fn vertex(b: &mut Builder, point: Point3<f64>) -> usize {
    b.parts.vertices.push(Vertex {
        point,
        edges: Vec::new(),
        tolerance: None,
    });
    b.parts.vertices.len() - 1
}

/// Adds an edge; keys count them.
fn edge(b: &mut Builder, key: usize, curve: Option<(usize, Interval)>, vertices: [usize; 2]) {
    let index = b.parts.edges.len();
    b.edges.insert((key, Place::HERE), index);
    // Of no meaning where there is no curve.
    let nothing = Interval {
        start: 0.0,
        end: 1.0,
    };
    b.parts.edges.push(Edge {
        curve: curve.map(|(curve, _)| curve),
        span: curve.map_or(nothing, |(_, span)| span),
        reversed: false,
        vertices,
        trims: Vec::new(),
        tolerance: None,
    });
    let [start, end] = vertices;
    for v in if start == end {
        vec![start]
    } else {
        vec![start, end]
    } {
        if let Some(vertex) = b.parts.vertices.get_mut(v) {
            vertex.edges.push(index);
        }
    }
}

/// How many numbers a curve holds that may be many.
fn held<const D: usize, const H: usize>(curve: &Curve<D, H>) -> usize {
    match curve {
        Curve::Nurbs(n) => numbers_of_spline(n),
        _ => 0,
    }
}

impl Body<'_, '_> {
    fn finish(
        self,
        id: u64,
        faces: &[FaceUse],
        mut left_out: BTreeMap<usize, ReadError>,
    ) -> Result<Made3, ReadError> {
        let Self {
            geometry,
            b,
            unbounded,
            mut bound,
            fitted,
            ..
        } = self;
        let Builder { mut parts, odd, .. } = b;
        kinds(&mut parts);
        let brep = Brep::new(parts).map_err(|e| problem(id, StepProblem::Brep(e)))?;
        // Where whole shells are lost (a cavity) what is left would have another inside.
        if brep.is_closed()
            && let Some((_, first)) = left_out.pop_first()
        {
            return Err(first);
        }
        let mut warnings: Vec<String> = odd.iter().map(|(what, n)| format!("{n} {what}")).collect();
        let mut left = 0;
        // It is kept, beside other bodies' proofs, too.
        let own = numbers(&brep).saturating_mul(size_of::<f64>());
        geometry.kept_bytes = geometry.kept_bytes.saturating_add(own);
        if !unbounded.is_empty() {
            // Of an edge all trims or none.
            let mut of_edges: BTreeMap<usize, (usize, Vec<usize>)> = BTreeMap::new();
            for (trim, cost) in unbounded {
                let Some(edge) = brep.parts().trims.get(trim).and_then(|t| t.edge) else {
                    continue;
                };
                let (all, trims) = of_edges.entry(edge).or_default();
                *all = all.saturating_add(cost);
                trims.push(trim);
            }
            let mut proven = Vec::new();
            for (cost, trims) in of_edges.into_values() {
                let Some(rest) = geometry.proofs.checked_sub(cost) else {
                    left += trims.len();
                    continue;
                };
                geometry.proofs = rest;
                proven.extend(trims);
            }
            let held = geometry.left.held.used().saturating_mul(size_of::<f64>());
            // What is held has become the bodies: it is there once.
            let kept = held.max(geometry.kept_bytes).saturating_add(PROOF_WORK);
            let room = geometry.proof_bytes.saturating_sub(kept);
            for own in trim_offsets(&brep, &proven, room) {
                if own.at_most.is_finite() {
                    bound = bound.max(own.at_most);
                } else {
                    left += 1;
                }
            }
        }
        let edged = brep.parts().trims.iter().filter(|t| t.edge.is_some());
        let edged = edged.count();
        let images = Images {
            bound,
            proven: edged.saturating_sub(left),
            left,
            fitted,
        };
        if !left_out.is_empty() {
            warnings.push(format!(
                "{} of {} faces cannot be read and are left out, each named by itself: the body is open there, and nothing tells its inside",
                left_out.len(),
                faces.len()
            ));
        }
        warnings.extend(jumps(&brep));
        let left_out = left_out.into_iter();
        let left_out = left_out.filter_map(|(i, why)| Some((faces.get(i)?.id, why)));
        Ok(Made3 {
            brep,
            images,
            warnings,
            left_out: left_out.collect(),
        })
    }

    fn point_of(&self, from: u64, id: u64) -> Result<Point3<f64>, ReadError> {
        let entities = self.geometry.entities;
        let e = entities.expect(from, id, "VERTEX_POINT", "a vertex")?;
        self.geometry.point3(id, e.reference(1)?)
    }

    fn vertex(&mut self, id: u64, point: Point3<f64>) -> usize {
        let key = (usize::try_from(id).unwrap_or(usize::MAX), Place::HERE);
        if let Some(v) = self.b.vertices.get(&key) {
            return *v;
        }
        let v = vertex(&mut self.b, point);
        self.b.vertices.insert(key, v);
        v
    }

    /// An edge, as pieces.
    fn edge(&mut self, from: u64, id: u64) -> Result<Rc<FileEdge>, ReadError> {
        if let Some(found) = self.edges.get(&id) {
            return Ok(Rc::clone(found));
        }
        let e = self
            .geometry
            .entities
            .expect(from, id, "EDGE_CURVE", "an edge")?;
        let ids = [e.reference(1)?, e.reference(2)?];
        let EdgeForm {
            form: curve,
            forward,
            pcurves,
        } = self.geometry.edge_form(id, e.reference(3)?)?;
        let mut forward = forward == e.flag(4)?;
        let mut ids = if forward { ids } else { [ids[1], ids[0]] };
        let mut points = [self.point_of(id, ids[0])?, self.point_of(id, ids[1])?];
        let (mut range, swapped) = self.range(id, &curve, points, ids[0] == ids[1])?;
        if swapped {
            forward = !forward;
            ids.reverse();
            points.reverse();
            *self.b.odd.entry(SWAPPED).or_default() += 1;
        }
        if range[1] - range[0] > TAU && matches!(curve, Form::Circle(..) | Form::Ellipse(..)) {
            range[1] = range[0] + TAU;
        }
        let numbers = &mut self.geometry.numbers;
        let curve = match curve {
            Form::Hyperbola(f, radii) => pieces(id, &f, radii, range, numbers)?,
            other => other,
        };
        let (curve, span) = curve.part(range, numbers).map_err(form(id))?;
        let ends = [
            self.vertex(ids[0], points[0]),
            self.vertex(ids[1], points[1]),
        ];
        let mut at = self.splits.get(&id).cloned().unwrap_or_default();
        at.retain(|t| span.start < *t && *t < span.end);
        at.sort_by(f64::total_cmp);
        at.dedup();
        let place = self.b.parts.curves3.len();
        let mut pieces = Vec::with_capacity(at.len() + 1);
        let (mut from, mut start) = (span.start, ends[0]);
        for to in at.into_iter().chain([span.end]) {
            let end = if to == span.end {
                ends[1]
            } else {
                vertex(&mut self.b, curve.point(to))
            };
            let Some(own) = Interval::new(from, to) else {
                continue;
            };
            if !pieces.is_empty() {
                let left = &mut self.geometry.left;
                left.held.take(HELD).map_err(form(id))?;
            }
            let key = self.b.edges.len();
            self.keys.resize(key + 1, 0);
            if let Some(k) = self.keys.get_mut(key) {
                *k = id;
            }
            edge(&mut self.b, key, Some((place, own)), [start, end]);
            pieces.push(Piece {
                key,
                curve: place,
                span: own,
                vertices: [start, end],
            });
            (from, start) = (to, end);
        }
        self.b.parts.curves3.push(curve);
        let edge = Rc::new(FileEdge {
            pieces,
            forward,
            pcurves,
        });
        self.edges.insert(id, Rc::clone(&edge));
        Ok(edge)
    }

    /// From which parameter to which a curve runs between two points, and whether it does so the other way than said.
    fn range(
        &mut self,
        id: u64,
        curve: &Form<3, 4>,
        [p, q]: [Point3<f64>; 2],
        is_closed: bool,
    ) -> Result<([f64; 2], bool), ReadError> {
        let turn = |a: f64| {
            let a = a - (a / TAU).floor() * TAU;
            // The last moment of a turn is the first.
            if TAU - a <= ROUNDING { 0.0 } else { a }
        };
        let open = |t: [f64; 2]| {
            if t[0] < t[1] {
                Ok((t, false))
            } else if t[1] < t[0] {
                Ok(([t[1], t[0]], true))
            } else {
                Err(shape(id, "an edge of no length"))
            }
        };
        match curve {
            Form::Line { from, direction } => {
                let square = direction.norm_squared();
                let at = |p: Point3<f64>| (p - from).dot(direction) / square;
                open([at(p), at(q)])
            }
            Form::Circle(..) | Form::Ellipse(..) => {
                let (f, [a, b]) = match curve {
                    Form::Ellipse(f, radii) => (f, *radii),
                    Form::Circle(f, r) => (f, [*r; 2]),
                    _ => return Err(shape(id, "no conic")),
                };
                let at = |p: Point3<f64>| {
                    let d = p - f.center;
                    turn(libm::atan2(d.dot(&f.y) / b, d.dot(&f.x) / a))
                };
                let start = at(p);
                if is_closed {
                    return Ok(([start, start + TAU], false));
                }
                let mut end = at(q);
                if end - start <= ROUNDING * TAU {
                    end += TAU;
                }
                Ok(([start, end], false))
            }
            Form::Parabola(f, _) => open([(p - f.center).dot(&f.y), (q - f.center).dot(&f.y)]),
            Form::Hyperbola(f, [_, b]) => {
                let at = |p: Point3<f64>| libm::asinh((p - f.center).dot(&f.y) / b);
                open([at(p), at(q)])
            }
            Form::Spline(..) => {
                let bounds = curve
                    .bounds()
                    .ok_or_else(|| shape(id, "a curve of no length"))?;
                let (whole, _) = curve
                    .part(bounds, &mut self.geometry.numbers)
                    .map_err(form(id))?;
                let domain = whole.domain();
                let ends = [whole.point(domain.start), whole.point(domain.end)];
                let slack = self.tolerance + ROUNDING * self.size;
                let loops = (ends[0] - ends[1]).norm() <= 2.0 * slack;
                if is_closed {
                    return if loops {
                        Ok((bounds, false))
                    } else {
                        Err(shape(
                            id,
                            "an edge from a vertex to itself on an open curve",
                        ))
                    };
                }
                let at = |p: Point3<f64>, first: usize| {
                    // Most edges are all of their curve.
                    for k in [first, 1 - first] {
                        if (ends[k] - p).norm() <= ROUNDING * self.size {
                            return bounds[k];
                        }
                    }
                    let t = nearest(&whole, None, None, |c, d| (c - p.coords, *d));
                    let own = (whole.point(t) - p).norm();
                    for k in [first, 1 - first] {
                        if (ends[k] - p).norm() <= 2.0 * own + slack {
                            return bounds[k];
                        }
                    }
                    t
                };
                let t = [at(p, 0), at(q, 1)];
                if t[0] >= t[1] && loops {
                    return Err(unsupported(
                        id,
                        "an edge across the seam of a closed B-spline",
                        "split the curve where it starts, or export the part as .brep or .3dm",
                    ));
                }
                open(t)
            }
            Form::Trimmed(..) | Form::Offset => Err(shape(id, "an edge without a curve")),
        }
    }

    /// Counts work as numbers.
    fn work(&mut self, id: u64, count: usize) -> Result<(), ReadError> {
        self.geometry.numbers.take(count).map_err(form(id))
    }

    /// A face. `Some`: this edge must be split there, and all begun again.
    fn face(&mut self, face: FaceUse) -> Result<Option<(u64, f64)>, ReadError> {
        let entities = self.geometry.entities;
        let id = face.id;
        let e = entities
            .simple(id)
            .ok_or_else(|| shape(id, "no simple face"))?;
        let (mut bounds, surface_id, same_sense) = (e.references(1)?, e.reference(2)?, e.flag(3)?);
        // They are a set: one that is said again is in it already.
        let mut listed = BTreeSet::new();
        bounds.retain(|bound| listed.insert(*bound));
        self.work(id, USE)?;
        let surface = self.geometry.surface(id, surface_id, 0)?;
        let surface = bounded(surface_id, surface, self.size, &mut self.geometry.numbers)?;
        let (left, numbers) = (&self.geometry.left, &mut self.geometry.numbers);
        let chart = Chart::new(surface_id, &surface, self.size, left, numbers)?;
        let mut rough: Vec<(Vec<Use>, [i32; 2])> = Vec::new();
        for bound in bounds {
            let known = ["FACE_BOUND", "FACE_OUTER_BOUND"];
            let found = known.iter().find_map(|k| entities.part(bound, k));
            let Some(b) = found else {
                return Err(entities.unexpected(id, bound, "a bound of a face"));
            };
            let (loop_id, forward) = (b.reference(1)?, b.flag(2)? == same_sense);
            if entities.is(loop_id, "VERTEX_LOOP") {
                // A border of one point: a pole, which the surface itself has.
                continue;
            }
            if entities.is(loop_id, "POLY_LOOP") {
                return Err(unsupported(
                    loop_id,
                    "a POLY_LOOP (a faceted face)",
                    "export the part with edges (advanced BREP), or its mesh as a mesh",
                ));
            }
            let l = entities.expect(bound, loop_id, "EDGE_LOOP", "a loop")?;
            let mut listed = l.references(1)?;
            if !forward {
                listed.reverse();
            }
            let mut uses: Vec<Use> = Vec::new();
            for o in listed {
                let oriented = entities.expect(loop_id, o, "ORIENTED_EDGE", "an edge of a loop")?;
                let along = oriented.flag(4)? == forward;
                let edge_id = oriented.reference(3)?;
                let edge = self.edge(o, edge_id)?;
                let along = along == edge.forward;
                for k in 0..edge.pieces.len() {
                    let k = if along { k } else { edge.pieces.len() - 1 - k };
                    let piece = edge.pieces.get(k).copied();
                    let curve = piece.and_then(|p| self.b.parts.curves3.get(p.curve));
                    let (Some(piece), Some(curve)) = (piece, curve) else {
                        continue;
                    };
                    // Its image may have as many numbers.
                    let held = held(curve);
                    let left = &mut *self.geometry;
                    left.numbers
                        .take(USE.saturating_add(held))
                        .map_err(form(edge_id))?;
                    left.left.held.take(HELD + held).map_err(form(edge_id))?;
                    if let Some(at) = pole(&chart, curve, piece.span) {
                        return Ok(Some((edge_id, at)));
                    }
                    let on = Face {
                        chart: &chart,
                        surface: &surface,
                        surface_id,
                        size: self.size,
                        tolerance: self.tolerance,
                    };
                    let made = on.pcurve(self.geometry, edge_id, &edge, curve, piece.span)?;
                    let mut more = LISTED;
                    if made.fitted {
                        self.work(edge_id, FITTED)?;
                        self.fitted += 1;
                    } else {
                        // An arc's may be an ellipse, as a spline.
                        more += self::held(&made.curve).saturating_sub(held);
                    }
                    let left = &mut self.geometry.left;
                    left.held.take(more).map_err(form(edge_id))?;
                    grow(&mut uses, 1);
                    uses.push(Use::new(
                        piece.key,
                        !along,
                        made,
                        piece.span,
                        piece.vertices,
                    ));
                }
            }
            let listed = uses.len();
            match lifted(&chart, &mut uses) {
                Ok(turns) => {
                    // Poles may lie between any two.
                    let more = (HELD + LISTED) * uses.len().saturating_sub(listed);
                    let left = &mut self.geometry.left;
                    left.held.take(more).map_err(form(id))?;
                    rough.push((uses, turns));
                }
                Err(trouble) => return Err(said(id, &trouble)),
            }
        }
        let mut seams = Seams {
            b: &mut self.b,
            chart: &chart,
        };
        let done = match closed(&chart, rough, &mut seams) {
            Ok(done) => done,
            Err(Trouble::Unbounded(why)) => {
                return Err(shape(
                    id,
                    format!("the loops of a face bound nothing: {why}"),
                ));
            }
            Err(Trouble::Split { key, parameter }) => {
                let edge = self.keys.get(key).copied().unwrap_or(0);
                return Ok(Some((edge, parameter)));
            }
        };
        self.put(id, &chart, &surface, done, same_sense != face.forward)?;
        Ok(None)
    }

    /// Puts a face's loops into the BREP.
    fn put(
        &mut self,
        id: u64,
        chart: &Chart,
        surface: &Form3,
        done: Vec<Vec<Use>>,
        reversed: bool,
    ) -> Result<(), ReadError> {
        let has_loops = !done.is_empty();
        let mut loops: Vec<Vec<EdgeUse>> = Vec::new();
        // Of each trim, the bound that is known, and what a proof costs.
        let mut proofs = Vec::new();
        // The degree of an image, against that of a cubic on a bicubic patch; products of polynomials cost its square.
        let weight = |curve: &Curve2| match (surface, curve) {
            (Form3::Spline([u, v], _), Curve::Nurbs(n)) => {
                let degree = (u.degree + v.degree).saturating_mul(n.degree().max(3));
                degree.saturating_mul(degree).div_ceil(18 * 18)
            }
            (Form3::Spline([u, v], _), _) => ((u.degree + v.degree).pow(2)).div_ceil(36),
            (_, Curve::Nurbs(n)) if n.degree() > 3 => 3,
            _ => 1,
        };
        for uses in done {
            let mut own = Vec::with_capacity(uses.len());
            for u in uses {
                let curve = self.b.parts.curves2.len();
                proofs.push((
                    u.bound,
                    u.curve.breaks().len().saturating_mul(weight(&u.curve)),
                ));
                self.b.parts.curves2.push(u.curve);
                own.push(EdgeUse {
                    shape: u.key.unwrap_or(usize::MAX),
                    place: Place::HERE,
                    reversed: u.reversed,
                    curve,
                    span: u.span,
                    vertices: u.vertices,
                    degenerated: u.key.is_none(),
                });
            }
            loops.push(own);
        }
        if chart.domain.is_none() {
            self.b.lift(&mut loops, chart.periods);
        }
        let reach = self.b.reach(&loops, surface.periods());
        let reach = reach.map(|r| r.map(wide));
        let part = surface.part(reach, &Motion::identity(), &mut self.geometry.numbers);
        let part = part.map_err(form(id))?;
        let domain = part.domain();
        let kept = numbers_of_surface(&part);
        self.geometry.left.held.take(kept).map_err(form(id))?;
        self.b.parts.surfaces.push(part);
        let index = self.b.parts.surfaces.len() - 1;
        let first = self.b.parts.trims.len();
        for (k, (u, (bound, cost))) in loops.iter().flatten().zip(proofs).enumerate() {
            let curve = self.b.parts.curves2.get(u.curve);
            let all = bound
                .zip(curve)
                .and_then(|(bound, curve)| Some(bound + cut_off(chart, curve, domain, self.size)?));
            match all {
                Some(all) => self.bound = self.bound.max(all),
                None => self.unbounded.push((first + k, cost)),
            }
        }
        self.b.face(index, has_loops, loops, reversed);
        Ok(())
    }
}

/// What edges of a face are projected onto.
struct Face<'f> {
    chart: &'f Chart,
    surface: &'f Form3,
    surface_id: u64,
    size: f64,
    tolerance: f64,
}

impl Face<'_> {
    /// The curve in uv of a piece of an edge.
    fn pcurve(
        &self,
        geometry: &mut Geometry<'_>,
        edge_id: u64,
        edge: &FileEdge,
        curve: &Curve3,
        span: Interval,
    ) -> Result<Made, ReadError> {
        // By formula where there is one; else the file's, if it is good.
        let chart = self.chart;
        let by_formula = chart.plane().is_some() || chart.is_elementary();
        if !by_formula && matches!(self.surface, Form3::Spline(..)) {
            let entities = geometry.entities;
            for &p in &edge.pcurves {
                let Some(e) = entities.part(p, "PCURVE") else {
                    continue;
                };
                if e.reference(1)? != self.surface_id {
                    continue;
                }
                let d = e.reference(2)?;
                let Some(d) = entities.part(d, "DEFINITIONAL_REPRESENTATION") else {
                    continue;
                };
                let Some(&in_uv) = d.references(1)?.first() else {
                    continue;
                };
                let range = [span.start, span.end];
                let own = geometry.curve::<2, 3>(p, in_uv, 0);
                let own = own.and_then(|own| {
                    let part = own.part(range, &mut geometry.numbers);
                    part.map_err(form(p))
                });
                let own = match own {
                    Ok((own, _)) => own,
                    // One that is bad is done without.
                    Err(problem) => match no_room(p, &problem) {
                        Some(of_curve) => return Err(of_curve),
                        None => continue,
                    },
                };
                let slack = 2.0 * self.tolerance + super::pcurve::FIT * self.size;
                if let Some(made) = taken(chart, curve, span, own, slack) {
                    let left = &mut geometry.left;
                    left.held.take(held(&made.curve)).map_err(form(p))?;
                    return Ok(made);
                }
            }
        }
        let (size, tolerance) = (self.size, self.tolerance);
        let left = &mut geometry.left;
        made(edge_id, chart, curve, span, size, tolerance, left)
    }
}

fn said(face: u64, trouble: &Trouble) -> ReadError {
    let why = match trouble {
        Trouble::Unbounded(why) => why,
        Trouble::Split { .. } => "an edge must be split",
    };
    unsupported(
        face,
        format!("a face whose loops do not bound it by themselves ({why})"),
        "let the program that wrote it split closed faces at seams, or export the part as .brep or .3dm",
    )
}

const SWAPPED: &str = "edges run against their curve, other than the file says";
