//! Looking for defects.

use super::{Brep, Defect, LoopKind, Part, TrimCurve, TrimKind};
use crate::numeric::Interval;
use crate::nurbs::{Curve, Curve2, Curve3, Surface};
use nalgebra::{Point2, Point3, Vector2, Vector3};

/// Deviations below this share of the size of the model (in space) or of the domain (in uv) are not
/// reported: a writer's own f64 evaluation is off by that much. 2^-40: 13 bits, or a few thousand
/// roundings, above 2^-53.
const ROUNDING: f64 = 1.0 / (1u64 << 40) as f64;
/// Stored axes off by less than this are as good as f64 makes them: 8 roundings of 2^-53.
const FRAME_ROUNDING: f64 = 8.0 * f64::EPSILON;
/// Samples of a curve: at least this many on each piece between breaks, ...
const SAMPLES_A_PIECE: usize = 8;
/// ... but no more than this in all (plus one for each piece), so that the cost stays linear.
const MAX_SAMPLES: usize = 256;
/// Pieces of a trim over which its area is integrated: of more than these, some are taken together.
const MAX_PIECES: usize = 512;
/// From how many parts of an edge's curve it is tried: those whose chords are nearest. Two may share the end that is nearest, and other
/// runs of the curve may lie between.
const STARTS: usize = 6;
/// Steps of Newton's method, or halvings where it leads astray, towards the nearest point of an edge's curve.
const NEWTON_STEPS: usize = 24;
/// A step that is no longer than this part of the larger end of the parameter's range is one rounding.
const STILL: f64 = f64::EPSILON;
/// Positive abscissae and weights of Gauss-Legendre quadrature with 8 points on [-1, 1]: exact for
/// polynomials up to degree 15 (Abramowitz and Stegun, table 25.4).
const GAUSS: [(f64, f64); 4] = [
    (0.1834346424956498, 0.362683783378362),
    (0.525532409916329, 0.31370664587788727),
    (0.7966664774136267, 0.22238103445337448),
    (0.9602898564975363, 0.10122853629037626),
];

/// The breaks that lie within `span`, with its ends; thinned out to `cap` pieces or so.
fn pieces(breaks: &[f64], span: Interval, cap: usize) -> Vec<f64> {
    let from = breaks.partition_point(|t| *t <= span.start);
    let to = breaks.partition_point(|t| *t < span.end).max(from);
    let inside = &breaks[from..to];
    let stride = inside.len() / cap + 1;
    let mut all = vec![span.start];
    all.extend(inside.iter().step_by(stride));
    all.push(span.end);
    all
}

/// Parameters to look at: breaks and some between.
fn samples(breaks: &[f64], span: Interval) -> Vec<f64> {
    let breaks = pieces(breaks, span, MAX_SAMPLES);
    // A curve of one piece is looked at more closely: it may be an arc or of high degree.
    let wanted = if breaks.len() == 2 {
        8 * SAMPLES_A_PIECE
    } else {
        SAMPLES_A_PIECE
    };
    let each = wanted.min(MAX_SAMPLES / (breaks.len() - 1)).max(1);
    let mut all = Vec::with_capacity(breaks.len() * each + 1);
    for w in breaks.windows(2) {
        let on = Interval {
            start: w[0],
            end: w[1],
        };
        all.extend((0..each).map(|i| on.lerp(i as f64 / each as f64)));
    }
    all.push(span.end);
    all
}

/// The largest; infinite if one is NaN.
fn largest(sizes: impl Iterator<Item = f64>) -> f64 {
    sizes
        .map(|x| if x.is_nan() { f64::INFINITY } else { x })
        .fold(0.0, f64::max)
}

/// Start and end of a trim in uv, in its own direction.
fn ends(curve: &Curve2, trim: &TrimCurve) -> [Point2<f64>; 2] {
    let (a, b) = (curve.point(trim.span.start), curve.point(trim.span.end));
    if trim.reversed { [b, a] } else { [a, b] }
}

fn image(surface: &Surface, uv: Point2<f64>) -> Point3<f64> {
    surface.point(uv.x, uv.y)
}

/// The distance of a point from the part of a curve given by `params` (in order) and the `points`
/// there: from the chords that are nearest on, by Newton's method, whatever the speeds at which curves run. An estimate from above; one
/// that is no more than `enough` is as good as any.
fn distance_to_curve(
    p: Point3<f64>,
    curve: &Curve3,
    params: &[f64],
    points: &[Point3<f64>],
    enough: f64,
) -> f64 {
    if let (Curve::Line(_), [a, .., b]) = (curve, points) {
        return distance_to_chord(p, a, b);
    }
    let at_samples = points.iter().map(|x| (x - p).norm());
    let mut best = at_samples.fold(f64::INFINITY, f64::min);
    // By chords, not by samples: between two of these the curve may be nearer than where it comes by elsewhere.
    let mut nearest = [(f64::INFINITY, 0); STARTS];
    for (i, ends) in points.windows(2).enumerate() {
        let off = distance_to_chord(p, &ends[0], &ends[1]);
        let place = nearest.partition_point(|(x, _)| *x <= off);
        if place < STARTS {
            nearest[place..].rotate_right(1);
            nearest[place] = (off, i);
        }
    }
    for (off, i) in nearest {
        if best <= enough || off == f64::INFINITY {
            break;
        }
        // The curve bulges by less than half its chord.
        let bulge = 0.5 * (points[i + 1] - points[i]).norm();
        if let Some(&[low, high]) = params.get(i..i + 2)
            && off - bulge < best
        {
            best = best.min(descend(p, curve, low, high));
        }
    }
    best
}

fn distance_to_chord(p: Point3<f64>, a: &Point3<f64>, b: &Point3<f64>) -> f64 {
    let along = b - a;
    let square = along.norm_squared();
    let s = if square > 0.0 {
        ((p - a).dot(&along) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (p - a - along * s).norm()
}

/// Newton's method from the middle of a part of a curve without kinks within; the least distance it meets. It stays where the slopes
/// met so far have a minimum between them.
fn descend(p: Point3<f64>, curve: &Curve3, start: f64, end: f64) -> f64 {
    let mut best = f64::INFINITY;
    let still = STILL * start.abs().max(end.abs());
    let (mut low, mut high) = (start, end);
    let mut ends_seen = [false; 2];
    let mut t = low + 0.5 * (high - low);
    for _ in 0..NEWTON_STEPS {
        let d = curve.derivatives(t, 2);
        let off = d[0] - p.coords;
        best = best.min(off.norm());
        let slope = off.dot(&d[1]);
        let outward = if slope > 0.0 {
            high = t;
            t == start
        } else {
            low = t;
            t == end
        };
        if outward {
            break;
        }
        // Where the second derivative does not help, that of Gauss and Newton.
        let curvature = d[1].norm_squared() + off.dot(&d[2]);
        let curvature = if curvature > 0.0 {
            curvature
        } else {
            d[1].norm_squared()
        };
        let newton = t - slope / curvature;
        let next = if newton < low && low == start && !ends_seen[0] {
            ends_seen[0] = true;
            start
        } else if newton > high && high == end && !ends_seen[1] {
            ends_seen[1] = true;
            end
        } else if (low..=high).contains(&newton) {
            newton
        } else {
            // Astray; so is NaN, at a stationary point of the curve.
            low + 0.5 * (high - low)
        };
        // A rounding's step is nothing.
        if (next - t).abs() <= still {
            break;
        }
        t = next;
    }
    best
}

/// The part of a loop's signed area that a trim contributes: half the integral of
/// (c - o) x c' dt, about `o` to keep digits.
fn area_below(curve: &Curve2, breaks: &[f64], trim: &TrimCurve, o: Point2<f64>) -> f64 {
    let mut sum = 0.0;
    let pieces = pieces(breaks, trim.span, MAX_PIECES);
    // An arc has no breaks: eight pieces make a full turn exact to about 1e-16.
    let each = if pieces.len() == 2 { 8 } else { 1 };
    for w in pieces.windows(2) {
        for k in 0..each {
            let on = Interval {
                start: w[0],
                end: w[1],
            };
            let (a, b) = (
                on.lerp(f64::from(k) / f64::from(each)),
                on.lerp(f64::from(k + 1) / f64::from(each)),
            );
            let (mid, half) = (0.5 * a + 0.5 * b, 0.5 * (b - a));
            for (x, weight) in GAUSS {
                for x in [-x, x] {
                    let d = curve.derivatives(mid + half * x, 1);
                    sum += weight * half * cross(d[0] - o.coords, d[1]);
                }
            }
        }
    }
    0.5 * if trim.reversed { -sum } else { sum }
}

fn cross(a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    a.x * b.y - a.y * b.x
}

/// How far axes are from an orthonormal frame.
fn frame_off(units: &[Vector3<f64>], orthogonal: &[(Vector3<f64>, Vector3<f64>)]) -> f64 {
    let lengths = units.iter().map(|v| (v.norm() - 1.0).abs());
    let cosines = orthogonal.iter().map(|(a, b)| {
        let scale = a.norm() * b.norm();
        if scale > 0.0 {
            (a.dot(b) / scale).abs()
        } else {
            1.0
        }
    });
    lengths.chain(cosines).fold(0.0, f64::max)
}

impl Brep {
    /// Everything found to be wrong or worth knowing, in the order of faces, edges and references.
    ///
    /// Deviations below 2^-40 of the size of the model, or of a face's domain, are left out as rounding;
    /// otherwise sizes are reported, not judged: [`Defect::severity`] goes by the file's own
    /// tolerance where there is one. Deviations along curves are sampled (up to about 256 places
    /// a curve, each followed by Newton's method), so that they are estimates.
    ///
    /// Cost: some hundred evaluations a trim that is on its edge, up to some ten thousand one that is off it.
    pub fn defects(&self) -> Vec<Defect> {
        let mut found = Vec::new();
        let checks = Checks::new(self);
        let mut seen = vec![false; self.parts().loops.len()];
        for face in 0..self.faces().len() {
            checks.face(face, &mut seen, &mut found);
        }
        checks.edges(&mut found);
        checks.references(&mut found);
        found
    }
}

struct Checks<'a> {
    brep: &'a Brep,
    /// [`ROUNDING`] of the model's size, in model units.
    rounding: f64,
    /// Where each curve in uv may be less smooth.
    breaks: Vec<Vec<f64>>,
    /// Parameters and points along each edge's curve.
    edge_samples: Vec<(Vec<f64>, Vec<Point3<f64>>)>,
}

impl<'a> Checks<'a> {
    fn new(brep: &'a Brep) -> Self {
        let p = brep.parts();
        let breaks3: Vec<_> = p.curves3.iter().map(Curve::breaks).collect();
        let edge_samples: Vec<_> = p
            .edges
            .iter()
            .map(|e| {
                let Some((curve, breaks)) = e.curve.map(|c| (&p.curves3[c], &breaks3[c])) else {
                    return (Vec::new(), Vec::new());
                };
                let params = samples(breaks, e.span);
                let points = params.iter().map(|t| curve.point(*t)).collect();
                (params, points)
            })
            .collect();
        let corners = (0..p.faces.len()).flat_map(|f| {
            let surface = brep.surface(f);
            let [u, v] = surface.domain();
            [
                surface.point(u.start, v.start),
                surface.point(u.end, v.end),
                surface.point(u.mid(), v.mid()),
            ]
        });
        let all = p
            .vertices
            .iter()
            .map(|v| v.point)
            .chain(
                edge_samples
                    .iter()
                    .flat_map(|(_, points)| points.iter().copied()),
            )
            .chain(corners);
        let (mut low, mut high) = (
            Vector3::repeat(f64::INFINITY),
            Vector3::repeat(f64::NEG_INFINITY),
        );
        let mut largest = 0.0f64;
        for x in all {
            low = low.inf(&x.coords);
            high = high.sup(&x.coords);
            largest = largest.max(x.coords.amax());
        }
        let size = (high - low).norm();
        // Far from the origin, coordinates round more than the size says.
        let size = if size.is_finite() {
            size.max(largest)
        } else {
            0.0
        };
        Self {
            brep,
            rounding: ROUNDING * size,
            breaks: p.curves2.iter().map(Curve::breaks).collect(),
            edge_samples,
        }
    }

    fn face(&self, face: usize, seen: &mut [bool], found: &mut Vec<Defect>) {
        let p = self.brep.parts();
        let surface = self.brep.surface(face);
        self.surface_frame(face, surface, found);
        let Some(loops) = &p.faces[face].loops else {
            return;
        };
        let kinds = || loops.iter().map(|l| p.loops[*l].kind);
        let outer = kinds().filter(|k| *k == LoopKind::Outer).count();
        if outer != 1 && !kinds().any(|k| k == LoopKind::Unknown) {
            found.push(Defect::OuterLoops { face, count: outer });
        }
        for &trim_loop in loops {
            // Listed by another face, or twice: reported with the references, and not looked at
            // again, so that the cost stays linear. Likewise trims.
            let own = p.loops[trim_loop].face == face;
            if !own || std::mem::replace(&mut seen[trim_loop], true) {
                continue;
            }
            let trims = &p.loops[trim_loop].trims;
            if trims.is_empty() {
                found.push(Defect::EmptyLoop { face, trim_loop });
                continue;
            }
            self.gaps(face, trim_loop, found);
            let mut sorted = trims.clone();
            sorted.sort_unstable();
            sorted.dedup();
            sorted.retain(|t| p.trims[*t].trim_loop == trim_loop);
            if sorted.len() == trims.len() {
                self.orientation(face, trim_loop, found);
            }
            for trim in sorted {
                self.trim(face, trim, found);
            }
        }
    }

    fn surface_frame(&self, face: usize, surface: &Surface, found: &mut Vec<Defect>) {
        let (form, off) = match surface {
            Surface::Plane(s) => ("plane", frame_off(&[s.x, s.y], &[(s.x, s.y)])),
            Surface::Revolution(s) => {
                self.arc_frame(Part::Face(face), &s.profile, found);
                return;
            }
            Surface::Sum(s) => {
                self.arc_frame(Part::Face(face), &s.first, found);
                self.arc_frame(Part::Face(face), &s.second, found);
                return;
            }
            Surface::Nurbs(_) => return,
        };
        if off > FRAME_ROUNDING {
            let owner = Part::Face(face);
            found.push(Defect::Frame { owner, form, off });
        }
    }

    fn arc_frame(&self, owner: Part, curve: &Curve3, found: &mut Vec<Defect>) {
        let check = |c: &Curve3| match c {
            Curve::Arc(a) => frame_off(
                &[a.x, a.y, a.z],
                // y must also be z cross x, not its opposite: then both are orthogonal to it.
                &[(a.x, a.z), (a.y, a.x), (a.y, a.z)],
            )
            .max((a.y - a.z.cross(&a.x)).norm()),
            _ => 0.0,
        };
        let off = match curve {
            Curve::Poly(poly) => poly.segments().iter().map(check).fold(0.0, f64::max),
            one => check(one),
        };
        if off > FRAME_ROUNDING {
            let form = "arc";
            found.push(Defect::Frame { owner, form, off });
        }
    }

    fn gaps(&self, face: usize, trim_loop: usize, found: &mut Vec<Defect>) {
        let p = self.brep.parts();
        let surface = self.brep.surface(face);
        let [du, dv] = surface.domain();
        let limit = [ROUNDING * du.length(), ROUNDING * dv.length()];
        let trims = &p.loops[trim_loop].trims;
        let mut worst: Option<Defect> = None;
        let mut gaps = 0;
        let mut largest = 0.0;
        for (i, &a) in trims.iter().enumerate() {
            let b = trims[(i + 1) % trims.len()];
            let [_, from] = ends(&p.curves2[p.trims[a].curve], &p.trims[a]);
            let [to, _] = ends(&p.curves2[p.trims[b].curve], &p.trims[b]);
            let step = to - from;
            if step.x.abs() <= limit[0] && step.y.abs() <= limit[1] {
                continue;
            }
            gaps += 1;
            let space = (image(surface, to) - image(surface, from)).norm();
            let uv = step.norm();
            if worst.is_none() || uv > largest {
                largest = uv;
                worst = Some(Defect::Gap {
                    face,
                    trim_loop,
                    trims: [a, b],
                    count: 0,
                    uv,
                    space,
                    tolerance: p.vertices[p.trims[a].vertices[1]].tolerance,
                });
            }
        }
        if let Some(Defect::Gap { count, .. }) = &mut worst {
            *count = gaps;
        }
        found.extend(worst);
    }

    fn orientation(&self, face: usize, trim_loop: usize, found: &mut Vec<Defect>) {
        let p = self.brep.parts();
        let kind = p.loops[trim_loop].kind;
        let trims = &p.loops[trim_loop].trims;
        let o = ends(&p.curves2[p.trims[trims[0]].curve], &p.trims[trims[0]])[0];
        let mut area = 0.0;
        for (i, &a) in trims.iter().enumerate() {
            let b = trims[(i + 1) % trims.len()];
            let curve = &p.curves2[p.trims[a].curve];
            area += area_below(curve, &self.breaks[p.trims[a].curve], &p.trims[a], o);
            // The straight segment that joins it to the next.
            let [_, from] = ends(curve, &p.trims[a]);
            let [to, _] = ends(&p.curves2[p.trims[b].curve], &p.trims[b]);
            area += 0.5 * cross(from - o, to - from);
        }
        let wrong = match kind {
            LoopKind::Outer => area <= 0.0,
            LoopKind::Inner => area >= 0.0,
            LoopKind::Unknown | LoopKind::Slit => false,
        };
        if wrong {
            found.push(Defect::Orientation {
                face,
                trim_loop,
                kind,
                area,
            });
        }
    }

    fn trim(&self, face: usize, index: usize, found: &mut Vec<Defect>) {
        let p = self.brep.parts();
        let trim = &p.trims[index];
        let curve = &p.curves2[trim.curve];
        let surface = self.brep.surface(face);
        let [du, dv] = surface.domain();
        let uv: Vec<Point2<f64>> = samples(&self.breaks[trim.curve], trim.span)
            .into_iter()
            .map(|t| curve.point(t))
            .collect();
        // How far outside, in units of the domain's length to decide, in uv to report.
        let outside = |x: f64, d: Interval| {
            let by = (d.start - x).max(x - d.end);
            if by > ROUNDING * d.length() { by } else { 0.0 }
        };
        let out = largest(uv.iter().map(|q| outside(q.x, du).max(outside(q.y, dv))));
        if out > 0.0 {
            found.push(Defect::OutsideDomain {
                face,
                trim: index,
                uv: out,
            });
        }
        let space: Vec<Point3<f64>> = uv.iter().map(|q| image(surface, *q)).collect();
        let (Some(first), Some(last)) = (space.first(), space.last()) else {
            return;
        };
        let (first, last) = if trim.reversed {
            (*last, *first)
        } else {
            (*first, *last)
        };
        for (vertex, at) in [(trim.vertices[0], first), (trim.vertices[1], last)] {
            let distance = (p.vertices[vertex].point - at).norm();
            if distance > self.rounding {
                found.push(Defect::VertexOffFace {
                    vertex,
                    face,
                    trim: index,
                    distance,
                    tolerance: p.vertices[vertex].tolerance,
                });
            }
        }
        match trim.edge {
            Some(edge) if trim.kind != TrimKind::Singular => {
                let Some(on) = p.edges[edge].curve.map(|c| &p.curves3[c]) else {
                    return;
                };
                let (params, points) = &self.edge_samples[edge];
                // On a plane, straight is straight.
                let straight = matches!(curve, Curve::Line(_))
                    && matches!(on, Curve::Line(_))
                    && matches!(surface, Surface::Plane(_));
                let distance = if straight {
                    largest(
                        [first, last]
                            .iter()
                            .map(|x| distance_to_curve(*x, on, params, points, self.rounding)),
                    )
                } else {
                    largest(
                        space
                            .iter()
                            .map(|x| distance_to_curve(*x, on, params, points, self.rounding)),
                    )
                };
                if distance > self.rounding {
                    found.push(Defect::EdgeOffSurface {
                        face,
                        trim: index,
                        edge,
                        distance,
                        tolerance: p.edges[edge].tolerance,
                    });
                }
            }
            _ => {
                let size = largest(space.iter().map(|x| (x - first).norm()));
                if size > self.rounding {
                    found.push(Defect::SingularTrim {
                        face,
                        trim: index,
                        size,
                    });
                }
            }
        }
    }

    fn edges(&self, found: &mut Vec<Defect>) {
        let p = self.brep.parts();
        for (edge, e) in p.edges.iter().enumerate() {
            match e.trims.len() {
                0 => found.push(Defect::UnusedEdge { edge }),
                1 => found.push(Defect::BoundaryEdge { edge }),
                2 => {}
                uses => found.push(Defect::NonManifoldEdge { edge, uses }),
            }
            let Some(curve) = e.curve.map(|c| &p.curves3[c]) else {
                found.push(Defect::NoCurve { edge });
                continue;
            };
            self.arc_frame(Part::Edge(edge), curve, found);
            let (a, b) = (curve.point(e.span.start), curve.point(e.span.end));
            let at = if e.reversed { [b, a] } else { [a, b] };
            for (vertex, at) in e.vertices.into_iter().zip(at) {
                let distance = (p.vertices[vertex].point - at).norm();
                if distance > self.rounding {
                    found.push(Defect::VertexOffEdge {
                        vertex,
                        edge,
                        distance,
                        tolerance: p.vertices[vertex].tolerance,
                    });
                }
            }
        }
    }

    fn references(&self, found: &mut Vec<Defect>) {
        let p = self.brep.parts();
        let edge_trims = Links::new(p.edges.iter().map(|e| &e.trims[..]));
        let vertex_edges = Links::new(p.vertices.iter().map(|v| &v.edges[..]));
        let loop_trims = Links::new(p.loops.iter().map(|l| &l.trims[..]));
        let face_loops = Links::new(
            p.faces
                .iter()
                .map(|f| f.loops.as_deref().unwrap_or_default()),
        );
        let mut broken = |from, to| found.push(Defect::BackReference { from, to });
        for (e, t) in &edge_trims.repeated {
            broken(Part::Edge(*e), Part::Trim(*t));
        }
        for (l, t) in &loop_trims.repeated {
            broken(Part::Loop(*l), Part::Trim(*t));
        }
        for (f, l) in &face_loops.repeated {
            broken(Part::Face(*f), Part::Loop(*l));
        }
        for (e, t) in edge_trims.all() {
            if p.trims[t].edge != Some(e) {
                broken(Part::Edge(e), Part::Trim(t));
            }
        }
        for (e, edge) in p.edges.iter().enumerate() {
            for v in edge.vertices {
                if !vertex_edges.has(v, e) {
                    broken(Part::Edge(e), Part::Vertex(v));
                }
            }
        }
        for (v, e) in vertex_edges.all() {
            if !p.edges[e].vertices.contains(&v) {
                broken(Part::Vertex(v), Part::Edge(e));
            }
        }
        for (t, trim) in p.trims.iter().enumerate() {
            if let Some(e) = trim.edge.filter(|e| !edge_trims.has(*e, t)) {
                broken(Part::Trim(t), Part::Edge(e));
            }
            if !loop_trims.has(trim.trim_loop, t) {
                broken(Part::Trim(t), Part::Loop(trim.trim_loop));
            }
        }
        for (l, t) in loop_trims.all() {
            if p.trims[t].trim_loop != l {
                broken(Part::Loop(l), Part::Trim(t));
            }
        }
        for (l, one) in p.loops.iter().enumerate() {
            if !face_loops.has(one.face, l) {
                broken(Part::Loop(l), Part::Face(one.face));
            }
        }
        for (f, l) in face_loops.all() {
            if p.loops[l].face != f {
                broken(Part::Face(f), Part::Loop(l));
            }
        }
    }
}

/// Which part lists which.
struct Links {
    /// In order, once each.
    all: Vec<(usize, usize)>,
    /// Those listed more than once. (A vertex may list an edge twice that starts and ends there.)
    repeated: Vec<(usize, usize)>,
}

impl Links {
    fn new<'a>(lists: impl Iterator<Item = &'a [usize]>) -> Self {
        let mut all: Vec<_> = lists
            .enumerate()
            .flat_map(|(from, list)| list.iter().map(move |to| (from, *to)))
            .collect();
        all.sort_unstable();
        let mut repeated: Vec<_> = all
            .windows(2)
            .filter(|w| w[0] == w[1])
            .map(|w| w[0])
            .collect();
        repeated.dedup();
        all.dedup();
        Self { all, repeated }
    }

    fn has(&self, from: usize, to: usize) -> bool {
        self.all.binary_search(&(from, to)).is_ok()
    }

    fn all(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.all.iter().copied()
    }
}
