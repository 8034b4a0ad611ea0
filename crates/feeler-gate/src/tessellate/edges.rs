//! Edges, cut once for all faces that meet there.

use super::steps::{angle, curve_breaks, cut as cut_pieces, normal, step, surface_breaks};
use super::{EdgeLine, Mesh, Rule};
use feeler::brep::{Brep, TrimKind};
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Curve2, Surface};
use nalgebra::{Point2, Point3, Vector3};

/// An image that ends further from its vertex than this part of the size gets a vertex of its own: the BREP has
/// a gap there, and so has the mesh.
const GAP: f64 = 1e-5;
/// A parameter guessed from the other trim serves as it is if its image is this near, as a part of the size.
const SAME: f64 = 1e-9;
/// Samples for each point that is looked for on another image of the edge.
const OVERSAMPLED: usize = 8;
/// Newton steps along another image.
const NEWTON: usize = 8;

/// The points of a trim in its own direction, both ends included.
#[derive(Clone, Debug, Default)]
pub(super) struct TrimPoints {
    /// Where on the face.
    pub(super) uv: Vec<Point2<f64>>,
    /// Which corner of the mesh.
    pub(super) vertices: Vec<u32>,
}

/// One use of an edge, run along the edge.
struct Use<'a> {
    trim: usize,
    face: usize,
    surface: &'a Surface,
    curve: &'a Curve2,
    span: Interval,
    /// Whether the edge runs as the trim's curve does.
    forward: bool,
}

impl Use<'_> {
    /// The curve's parameter at a part of the edge.
    fn parameter(&self, s: f64) -> f64 {
        self.span.lerp(if self.forward { s } else { 1.0 - s })
    }

    fn uv(&self, s: f64) -> Point2<f64> {
        self.curve.point(self.parameter(s))
    }

    fn point(&self, s: f64) -> Point3<f64> {
        let uv = self.uv(s);
        self.surface.point(uv.x, uv.y)
    }

    /// Direction of the image, not of unit length.
    fn tangent(&self, s: f64) -> Vector3<f64> {
        let c = self.curve.derivatives(self.parameter(s), 1);
        let d = self.surface.derivatives(c[0].x, c[0].y, 1);
        d.get(1, 0) * c[1].x + d.get(0, 1) * c[1].y
    }

    /// Where its pieces end, as parts of the edge: those of the curve, and the lines of the surface that an
    /// isoparametric trim crosses.
    fn breaks(&self) -> Vec<f64> {
        let part = |t: f64| {
            let s = (t - self.span.start) / self.span.length();
            if self.forward { s } else { 1.0 - s }
        };
        let mut all: Vec<f64> = curve_breaks(self.curve).into_iter().map(part).collect();
        if let Curve::Line(line) = self.curve {
            let way = line.to - line.from;
            for (axis, breaks) in surface_breaks(self.surface).iter().enumerate() {
                if way[1 - axis] == 0.0 && way[axis] != 0.0 {
                    let at = |x: &f64| (x - line.from[axis]) / way[axis];
                    all.extend(breaks.iter().map(|x| part(line.domain.lerp(at(x)))));
                }
            }
        }
        /// Pieces shorter than this part of an edge are none: roundings.
        const SHORT: f64 = 1e-9;
        all.retain(|s| *s > SHORT && *s < 1.0 - SHORT);
        all.extend([0.0, 1.0]);
        all.sort_by(f64::total_cmp);
        all.dedup_by(|b, a| *b - *a < SHORT && *b < 1.0);
        all
    }

    /// Parts of the edge at which this image is nearest to points in order, the ends kept.
    fn follow(&self, points: &[Point3<f64>], guesses: &[f64], size: f64) -> Vec<f64> {
        let near = |s: f64, p: &Point3<f64>| (self.point(s) - p).norm();
        let fits = |(p, s): (&Point3<f64>, &f64)| near(*s, p) <= SAME * size;
        if points.iter().zip(guesses).all(fits) {
            return guesses.to_vec();
        }
        let last = points.len() - 1;
        let samples = OVERSAMPLED * points.len().max(OVERSAMPLED);
        let at = |k: usize| k as f64 / samples as f64;
        let image: Vec<Point3<f64>> = (0..=samples).map(|k| self.point(at(k))).collect();
        let mut found = vec![0.0];
        let mut from = 0;
        for (i, p) in points.iter().enumerate().take(last).skip(1) {
            let distance = |k: usize| (image[k] - p).norm();
            let best = (from..samples).min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
            let best = best.unwrap_or(from);
            let (lo, hi) = (at(best.saturating_sub(1)), at((best + 1).min(samples)));
            let mut s = at(best);
            for _ in 0..NEWTON {
                let t =
                    self.tangent(s) * if self.forward { 1.0 } else { -1.0 } * self.span.length();
                let more = (p - self.point(s)).dot(&t) / t.norm_squared();
                let next = (s + more).clamp(lo, hi);
                if !next.is_finite() || next == s {
                    break;
                }
                s = next;
            }
            if near(at(best), p) < near(s, p) {
                s = at(best);
            }
            // In order, and short of the end.
            let previous = found[i - 1];
            found.push(s.max(previous + (1.0 - previous) * SAME));
            from = best;
        }
        found.push(1.0);
        found
    }
}

/// The longest side of the box of all vertices and sampled surfaces: for tolerances only.
fn size(brep: &Brep) -> f64 {
    let mut lo = Vector3::repeat(f64::INFINITY);
    let mut hi = -lo;
    for face in 0..brep.faces().len() {
        let surface = brep.surface(face);
        let [u, v] = surface.domain();
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let p = surface
                .point(u.lerp(i as f64 / 2.0), v.lerp(j as f64 / 2.0))
                .coords;
            (lo, hi) = (lo.inf(&p), hi.sup(&p));
        }
    }
    (hi - lo).max().max(f64::MIN_POSITIVE)
}

/// Cuts all edges, and trims that have none: the points of each trim.
pub(super) fn cut(brep: &Brep, rule: &Rule, mesh: &mut Mesh) -> Vec<TrimPoints> {
    let parts = brep.parts();
    let size = size(brep);
    let mut points = vec![TrimPoints::default(); parts.trims.len()];
    let mut corners = vec![None; parts.vertices.len()];
    // Trims by edge; those without stand alone.
    let mut groups: Vec<Vec<usize>> = vec![Vec::new(); parts.edges.len()];
    for face in brep.faces() {
        for &l in face.loops.iter().flatten() {
            for &trim in &parts.loops[l].trims {
                match parts.trims[trim].edge {
                    Some(edge) => groups[edge].push(trim),
                    None => groups.push(vec![trim]),
                }
            }
        }
    }
    for group in groups.iter().filter(|g| !g.is_empty()) {
        let uses: Vec<Use<'_>> = group
            .iter()
            .map(|&trim| {
                let t = &parts.trims[trim];
                let face = parts.loops[t.trim_loop].face;
                Use {
                    trim,
                    face,
                    surface: brep.surface(face),
                    curve: &parts.curves2[t.curve],
                    span: t.span,
                    forward: t.reversed == t.edge_reversed,
                }
            })
            .collect();
        cut_edge(brep, rule, &uses, size, &mut corners, mesh, &mut points);
    }
    points
}

fn cut_edge(
    brep: &Brep,
    rule: &Rule,
    uses: &[Use<'_>],
    size: f64,
    corners: &mut [Option<u32>],
    mesh: &mut Mesh,
    points: &mut [TrimPoints],
) {
    let trims = &brep.parts().trims;
    // The image with the most pieces, so that corners of all are met.
    let mut lead = 0;
    let mut breaks = Vec::new();
    for (i, one) in uses.iter().enumerate() {
        let own = one.breaks();
        if own.len() > breaks.len() {
            (lead, breaks) = (i, own);
        }
    }
    let main = &uses[lead];
    let trim = &trims[main.trim];
    let parts = if trim.kind == TrimKind::Singular {
        vec![0.0, 1.0]
    } else {
        let step = step(rule);
        cut_pieces(&breaks, |from, to| {
            let (a, b) = (main.tangent(from), main.tangent(to));
            let mut turn = angle(&a, &b);
            for one in uses {
                let of = |s: f64| normal(one.surface, one.uv(s));
                let beside = angle(&of(from), &of(to));
                if beside.is_finite() {
                    turn = turn.max(beside);
                }
            }
            let mut cost = turn / step;
            if rule.chord.is_finite() {
                // The sagitta of an arc of this length that turns so far is length * turn / 8.
                let length = (main.point(to) - main.point(from)).norm();
                cost = cost.max((length * turn / (2.0 * rule.chord)).sqrt());
            }
            cost
        })
    };
    for piece in parts.windows(2) {
        let middle = main.point(0.5 * (piece[0] + piece[1]));
        let (a, b) = (main.point(piece[0]), main.point(piece[1]));
        let way = (b - a).normalize();
        let off = (middle - a) - way * (middle - a).dot(&way);
        // NaN where the ends are one: a pole.
        mesh.chord_error = mesh.chord_error.max(off.norm());
    }
    let images: Vec<Point3<f64>> = parts.iter().map(|s| main.point(*s)).collect();
    let last = images.len() - 1;
    let ends = {
        // The trim's ends, along the edge.
        let [a, b] = trim.vertices;
        if trim.edge_reversed { [b, a] } else { [a, b] }
    };
    let mut ids = Vec::with_capacity(images.len());
    for (i, p) in images.iter().enumerate() {
        let vertex = match i {
            0 => Some(ends[0]),
            _ if i == last => Some(ends[1]),
            _ => None,
        };
        let id = match vertex.map(|v| (v, corners[v])) {
            Some((_, Some(id))) => {
                let there = Point3::from(mesh.vertices[id as usize]);
                if (there - p).norm() <= GAP * size {
                    id
                } else {
                    mesh.vertex(p.coords.into())
                }
            }
            Some((v, None)) => {
                let id = mesh.vertex(p.coords.into());
                corners[v] = Some(id);
                id
            }
            None => mesh.vertex(p.coords.into()),
        };
        ids.push(id);
    }
    if trim.kind != TrimKind::Singular {
        mesh.edges.push(EdgeLine {
            edge: trim.edge,
            faces: uses.iter().map(|one| one.face).collect(),
            vertices: ids.clone(),
        });
    }
    for (i, one) in uses.iter().enumerate() {
        let at = if i == lead {
            parts.clone()
        } else {
            one.follow(&images, &parts, size)
        };
        let mut own = TrimPoints {
            uv: at.iter().map(|s| one.uv(*s)).collect(),
            vertices: ids.clone(),
        };
        if trims[one.trim].edge_reversed {
            own.uv.reverse();
            own.vertices.reverse();
        }
        points[one.trim] = own;
    }
}
