//! Loops and the sheet of the surface they lie on.
//!
//! The trimmed region of a face is cut with its surface's domain, and parity needs loops that close in
//! uv up to small gaps. Programs that write .3dm files mostly see to both: a loop that runs
//! around a closed surface takes the seam in as trims of its own. Two things are left:
//!
//! - Loops on a surface of revolution may lie across or beyond the seam, at angles up to 4 pi, and loops
//!   on a plane may bulge out of the rectangle the file gives it; readers follow them there, as
//!   both surfaces go on. [`open`] then takes the surface over a domain that holds its
//!   loops. It does so only where angle and parameter, or the plane's coordinates and
//!   parameters, are the same numbers: then every point stays exactly what it was.
//! - A loop without its seam cannot be mended without inventing trims. [`jumps`] reports it.

use feeler::brep::{Brep, BrepParts, TrimCurve, TrimKind};
use feeler::numeric::Interval;
use feeler::numeric::bernstein::{Bidegree, split_off};
use feeler::nurbs::{Arc, Curve2, NurbsCurve, Surface};
use nalgebra::Point2;
use std::f64::consts::TAU;

/// How far a span may stick out of its curve's domain and still be taken for a rounded copy of
/// the domain's end, relative to the domain's larger end: writers print as few as 12 digits
/// (2^-40 is 9e-13). Clamping moves the end point by no more than that.
pub(crate) const ROUNDING: f64 = 1.0 / (1_u64 << 40) as f64;

/// A gap as wide as this part of the surface's domain is no gap any more.
const JUMP: f64 = 0.5;

/// Grows `hull` by a range that holds the curve in coordinate `c`: that of its points, of its control
/// polygon (weights are positive) or of its circle.
pub(crate) fn grow(hull: &mut [f64; 2], curve: &Curve2, c: usize) {
    let mut add = |lo: f64, hi: f64| *hull = [hull[0].min(lo), hull[1].max(hi)];
    match curve {
        Curve2::Line(l) => {
            add(l.from[c], l.from[c]);
            add(l.to[c], l.to[c]);
        }
        Curve2::Arc(a) => {
            // Rounded to nearest, so one step outwards.
            let (lo, hi) = (a.center[c] - a.radius, a.center[c] + a.radius);
            add(lo.next_down(), hi.next_up());
        }
        Curve2::Polyline(p) => p.points().iter().for_each(|q| add(q[c], q[c])),
        Curve2::Nurbs(n) => {
            for q in n.control_points() {
                let x = q[c] / q[2];
                // Exact where the weight is 1; else one step outwards.
                if q[2] == 1.0 {
                    add(x, x);
                } else {
                    add(x.next_down(), x.next_up());
                }
            }
        }
        // Segments are never poly-curves themselves.
        Curve2::Poly(p) => p.segments().iter().for_each(|s| grow(hull, s, c)),
    }
}

/// Samples of a trim's curve on which its extremes are looked for.
pub(crate) const SAMPLES: u16 = 64;

/// Steps of the search between two samples; each leaves (sqrt 5 - 1) / 2 of the interval, so that 40
/// leave 4e-9 of it, and the value, flat there, is off by the square of that.
const STEPS: u32 = 40;

/// The part of an interval that one step of golden-section search leaves.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// A plane is opened this much wider than its loops, relative to their range: room for what the
/// search for extremes left out. The loops, not the domain, bound the face.
const MARGIN: f64 = 1.0 / (1 << 20) as f64;

/// The range of `x[c]` on the part of an arc that a trim uses, by formula.
fn of_arc(curve: &Curve2, arc: &Arc<2>, span: Interval, c: usize) -> [f64; 2] {
    let per = (arc.angle.end - arc.angle.start) / (arc.domain.end - arc.domain.start);
    let angle = |t: f64| arc.angle.start + (t - arc.domain.start) * per;
    let (from, to) = (angle(span.start), angle(span.end));
    let reaches = |sign: f64| {
        let peak = (sign * arc.y[c]).atan2(sign * arc.x[c]);
        let turns = ((from - peak) / TAU).ceil();
        peak + turns * TAU <= to
    };
    let is_at = [reaches(-1.0), reaches(1.0)];
    // By a rounding beside its end an arc is as far out as there.
    let ends = match is_at {
        [true, true] => [0.0; 2],
        _ => [span.start, span.end].map(|t| curve.point(t)[c]),
    };
    let low = -(-arc.center[c] + arc.radius);
    let high = arc.center[c] + arc.radius;
    [
        if is_at[0] { low } else { ends[0].min(ends[1]) },
        if is_at[1] { high } else { ends[0].max(ends[1]) },
    ]
}

/// The largest value of `sign * x[c]` on the part of a curve that a trim uses: samples, its ends among them, then golden-section search around the best.
/// Deterministic; of the search there is no proof.
fn extreme(curve: &Curve2, span: Interval, c: usize, sign: f64) -> f64 {
    let value = |t: f64| sign * curve.point(t)[c];
    let at = |k: u16| span.lerp(f64::from(k) / f64::from(SAMPLES));
    let (mut best, mut most) = (0, f64::NEG_INFINITY);
    for k in 0..=SAMPLES {
        let v = value(at(k));
        if v > most {
            (best, most) = (k, v);
        }
    }
    let (mut lo, mut hi) = (at(best.saturating_sub(1)), at((best + 1).min(SAMPLES)));
    let (mut a, mut b) = (hi - GOLDEN * (hi - lo), lo + GOLDEN * (hi - lo));
    let (mut va, mut vb) = (value(a), value(b));
    for _ in 0..STEPS {
        most = most.max(va).max(vb);
        // One of the two is at the ratio of what is left, too.
        if va < vb {
            lo = a;
            (a, va) = (b, vb);
            b = lo + GOLDEN * (hi - lo);
            vb = value(b);
        } else {
            hi = b;
            (b, vb) = (a, va);
            a = hi - GOLDEN * (hi - lo);
            va = value(a);
        }
    }
    most
}

/// Whether [`grow`] gives the very range of the part of a curve that a trim uses: that of a polygon, all of it.
fn hull_is_exact(curve: &Curve2, span: Interval) -> bool {
    matches!(curve, Curve2::Line(_) | Curve2::Polyline(_)) && span == curve.domain()
}

/// Widens a range by those of the parts of curves that trims use. An extreme is looked for only where a control polygon reaches over what there is,
/// the ends of all the parts among it.
fn widen(range: &mut [f64; 2], curves: &[(&Curve2, Interval)], c: usize) {
    let mut add = |lo: f64, hi: f64| *range = [range[0].min(lo), range[1].max(hi)];
    for (curve, span) in curves {
        if let Curve2::Arc(arc) = curve {
            let [lo, hi] = of_arc(curve, arc, *span, c);
            add(lo, hi);
        } else {
            let ends = [span.start, span.end].map(|t| curve.point(t)[c]);
            add(ends[0].min(ends[1]), ends[0].max(ends[1]));
        }
    }
    for (curve, span) in curves {
        if matches!(curve, Curve2::Arc(_) | Curve2::Line(_)) {
            continue;
        }
        let mut hull = [f64::INFINITY, f64::NEG_INFINITY];
        grow(&mut hull, curve, c);
        if hull[0] < range[0] {
            range[0] = range[0].min(-extreme(curve, *span, c, -1.0));
        }
        if hull[1] > range[1] {
            range[1] = range[1].max(extreme(curve, *span, c, 1.0));
        }
    }
}

/// A range, and how much farther out a bound on it is at each end: no farther where there are polygons alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach {
    pub(crate) range: [f64; 2],
    pub(crate) margin: f64,
    /// One loop alone goes around the surface by more than a turn, as that of a screw's thread does: it passes above itself, and one turn
    /// of the surface does not hold it.
    pub(crate) winds: bool,
}

/// How far the parts of curves reach in coordinate `c`. `None` if there are no curves.
pub(crate) fn reach<'c>(
    curves: impl Iterator<Item = (&'c Curve2, Interval)>,
    c: usize,
) -> Option<Reach> {
    let mut polygons = [f64::INFINITY, f64::NEG_INFINITY];
    let mut curved = Vec::new();
    for (curve, span) in curves {
        if hull_is_exact(curve, span) {
            grow(&mut polygons, curve, c);
        } else {
            curved.push((curve, span));
        }
    }
    let mut range = polygons;
    widen(&mut range, &curved, c);
    let margin = MARGIN * (range[1] - range[0]);
    (range[0] <= range[1]).then_some(Reach {
        range,
        margin: if curved.is_empty() { 0.0 } else { margin },
        winds: false,
    })
}

/// The ranges of u and v that hold all of some curves, for a plane on which they bound a face. `None` if there are no curves.
pub(crate) fn plane_domain<'c>(
    curves: impl Iterator<Item = &'c Curve2> + Clone,
) -> Option<[Interval; 2]> {
    let range = |c: usize| {
        let spans = curves.clone().map(|curve| (curve, curve.domain()));
        let Reach { range, margin, .. } = reach(spans, c)?;
        Interval::new(range[0] - margin, range[1] + margin)
    };
    Some([range(0)?, range(1)?])
}

/// Each trim with an edge becomes a border, a seam or mated, by how its edge is used.
pub(crate) fn kinds(parts: &mut BrepParts) {
    let mut kinds = Vec::with_capacity(parts.trims.len());
    for trim in &parts.trims {
        let uses = trim.edge.and_then(|e| parts.edges.get(e)).map(|e| &e.trims);
        let same = |t: &&usize| parts.trims.get(**t).map(|t| t.trim_loop) == Some(trim.trim_loop);
        kinds.push(match uses {
            None => TrimKind::Singular,
            Some(uses) if uses.len() == 1 => TrimKind::Boundary,
            // An edge used so often is no manifold's: one look at each of a few is enough.
            Some(uses) if uses.iter().take(8).filter(same).count() > 1 => TrimKind::Seam,
            Some(_) => TrimKind::Mated,
        });
    }
    for (trim, kind) in parts.trims.iter_mut().zip(kinds) {
        trim.kind = kind;
    }
}

/// The trims of some loops with their curves.
fn trims<'p>(
    parts: &'p BrepParts,
    loops: &'p [usize],
) -> impl Iterator<Item = (&'p TrimCurve, &'p Curve2)> {
    let loops = loops.iter().filter_map(|l| parts.loops.get(*l));
    let trims = loops.flat_map(|l| l.trims.iter().filter_map(|t| parts.trims.get(*t)));
    trims.filter_map(|t| parts.curves2.get(t.curve).map(|c| (t, c)))
}

/// How often a part of a curve may be halved to see that it stays within its surface's domain: where it touches the border some 20 times, for each
/// brings its polygon nearer by a factor of 4, and 2^-40 is the aim ([`ROUNDING`]).
const DEPTH: usize = 32;

/// How often all of a curve may be halved for that: more is dearer than [`extreme`].
const HALVINGS: usize = 256;

/// Curves whose pieces take more operations than this (their control points, times the square of the order) are left to [`extreme`]: many trims may
/// name one curve.
const MOST_WORK: usize = 1 << 16;

/// Whether `sign * x[c]` is at most `limit` all along a curve: its polynomial `sign x w - limit w` has Bernstein coefficients that
/// are not positive, on as small parts as it takes. `slack` is what rounding may add. False where that is not seen.
fn is_below(curve: &NurbsCurve<3>, c: usize, sign: f64, limit: f64, slack: f64) -> bool {
    let degree = Bidegree {
        u: curve.degree(),
        v: 0,
    };
    let points = curve.control_points();
    if points.len().saturating_mul((degree.u + 1) * (degree.u + 1)) > MOST_WORK {
        return false;
    }
    let size = |q: &nalgebra::Vector3<f64>| q[c].abs() + limit.abs() * q[2];
    let largest = points.iter().map(size).fold(0.0, f64::max);
    let lightest = points.iter().map(|q| q[2]).fold(f64::INFINITY, f64::min);
    // Per degree 6 units for the pieces' control points and one for each halving; 3 for the polynomial itself.
    let units = (6 + DEPTH) * degree.u + 3;
    if !(units as f64 * f64::EPSILON * largest <= slack * lightest) {
        return false;
    }
    let over = |q: &nalgebra::Vector3<f64>| sign * q[c] - limit * q[2];
    // A curve lies in the hull of its points, which mostly is enough.
    if points.iter().all(|q| over(q) <= 0.0) {
        return true;
    }
    let mut halvings = 0;
    for piece in curve.each_bezier_piece() {
        let own = piece.control_points.iter().map(over);
        let mut open: Vec<(Vec<f64>, usize)> = vec![(own.collect(), 0)];
        while let Some((mut part, depth)) = open.pop() {
            if part.iter().all(|x| *x <= 0.0) {
                continue;
            }
            // The ends are points of the curve.
            let ends = [part.first(), part.last()];
            if depth == DEPTH
                || halvings == HALVINGS
                || ends.iter().flatten().any(|x| !(**x <= 0.0))
            {
                return false;
            }
            halvings += 1;
            let right = split_off(&mut part, degree, true);
            open.extend([part, right].map(|p| (p, depth + 1)));
        }
    }
    true
}

/// Whether a curve is seen to stay within `domain`, give or take `slack`, in coordinate `c`.
pub(crate) fn stays(curve: &Curve2, c: usize, domain: Interval, slack: f64) -> bool {
    // A quarter of it is for rounding.
    let (off, rounding) = (0.75 * slack, 0.25 * slack);
    match curve {
        Curve2::Nurbs(n) => {
            is_below(n, c, 1.0, domain.end + off, rounding)
                && is_below(n, c, -1.0, off - domain.start, rounding)
        }
        // Segments are never poly-curves themselves.
        Curve2::Poly(p) => p.segments().iter().all(|s| stays(s, c, domain, slack)),
        _ => {
            let mut hull = [f64::INFINITY, f64::NEG_INFINITY];
            grow(&mut hull, curve, c);
            hull[0] >= domain.start - slack && hull[1] <= domain.end + slack
        }
    }
}

/// The range of a face's trims in coordinate `c`, if it leaves `domain` by more than rounding.
fn outside(parts: &BrepParts, loops: &[usize], c: usize, domain: Interval) -> Option<Interval> {
    let slack = ROUNDING * domain.start.abs().max(domain.end.abs());
    let inside = |[lo, hi]: [f64; 2]| lo >= domain.start - slack && hi <= domain.end + slack;
    let mut hull = [f64::INFINITY, f64::NEG_INFINITY];
    trims(parts, loops).for_each(|(_, curve)| grow(&mut hull, curve, c));
    // Not an empty list, and not the usual case: now look closely.
    if hull[0] > hull[1] || inside(hull) {
        return None;
    }
    if trims(parts, loops).all(|(_, curve)| stays(curve, c, domain, slack)) {
        return None;
    }
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    let mut open = Vec::new();
    for (trim, curve) in trims(parts, loops) {
        let mut own = [f64::INFINITY, f64::NEG_INFINITY];
        grow(&mut own, curve, c);
        if hull_is_exact(curve, trim.span) || inside(own) {
            range = [range[0].min(own[0]), range[1].max(own[1])];
        } else {
            open.push((curve, trim.span));
        }
    }
    widen(&mut range, &open, c);
    if inside(range) {
        return None;
    }
    Interval::new(range[0], range[1])
}

/// Gives each plane and surface of revolution a domain that holds its face's loops, where that is exact
/// (see the [module](self)). Returns a line for each face whose loops leave the domain.
pub(crate) fn open(parts: &mut BrepParts) -> Vec<String> {
    let mut notes = Vec::new();
    for f in 0..parts.faces.len() {
        for (c, name) in ["u", "v"].into_iter().enumerate() {
            let Some(face) = parts.faces.get(f) else {
                continue;
            };
            let (Some(loops), Some(surface)) =
                (face.loops.as_deref(), parts.surfaces.get(face.surface))
            else {
                continue;
            };
            let domain = surface.domain()[c];
            let Some(range) = outside(parts, loops, c, domain) else {
                continue;
            };
            let opened = opened(surface, c, range);
            let what = match opened {
                Some(_) => "the surface goes on there and is taken so",
                None => "the region is cut at the domain's border",
            };
            notes.push(format!(
                "face {f}: loops reach over {name} in [{:?}, {:?}], the surface's domain is \
                 [{:?}, {:?}]: {what}",
                range.start, range.end, domain.start, domain.end
            ));
            if let Some(surface) = opened {
                let place = parts.surfaces.len();
                parts.surfaces.push(surface);
                if let Some(face) = parts.faces.get_mut(f) {
                    face.surface = place;
                }
            }
        }
    }
    notes
}

/// The same surface over a domain that holds `range` in coordinate `c`, if that is exact. On a surface
/// of revolution the domain becomes the range itself, which must be at most one turn.
fn opened(surface: &Surface, c: usize, range: Interval) -> Option<Surface> {
    match surface {
        Surface::Plane(plane) => {
            let old = plane.domain.get(c).copied()?;
            if plane.extents.get(c) != Some(&old) {
                return None;
            }
            let margin = MARGIN * range.length();
            let start = old.start.min(range.start - margin);
            let new = Interval::new(start, old.end.max(range.end + margin))?;
            let mut plane = plane.clone();
            *plane.domain.get_mut(c)? = new;
            *plane.extents.get_mut(c)? = new;
            Some(Surface::Plane(plane))
        }
        Surface::Revolution(revolution) => {
            let angular = (c == 1) == revolution.transposed;
            if !angular || revolution.angle != revolution.angle_domain || range.length() > TAU {
                return None;
            }
            let mut revolution = revolution.clone();
            revolution.angle = range;
            revolution.angle_domain = range;
            Some(Surface::Revolution(revolution))
        }
        _ => None,
    }
}

/// Where a trim starts (`0`) or ends (`1`) in uv.
fn end(brep: &Brep, trim: &TrimCurve, which: usize) -> Option<Point2<f64>> {
    let curve = brep.parts().curves2.get(trim.curve)?;
    let t = if (which == 0) == trim.reversed {
        trim.span.end
    } else {
        trim.span.start
    };
    Some(curve.point(t))
}

/// So many of the places where loops jump are named.
const NAMED: usize = 16;

/// One line for each place where a loop jumps; one for all beyond the first [`NAMED`].
pub(crate) fn jumps(brep: &Brep) -> Vec<String> {
    let parts = brep.parts();
    let mut found = Vec::new();
    let mut more = 0_usize;
    for (l, trim_loop) in parts.loops.iter().enumerate() {
        let face = parts.faces.get(trim_loop.face);
        let Some(surface) = face.and_then(|f| parts.surfaces.get(f.surface)) else {
            continue;
        };
        let domain = surface.domain();
        let next = trim_loop.trims.iter().cycle().skip(1);
        for (&a, &b) in trim_loop.trims.iter().zip(next) {
            let (Some(ta), Some(tb)) = (parts.trims.get(a), parts.trims.get(b)) else {
                continue;
            };
            let (Some(p), Some(q)) = (end(brep, ta, 1), end(brep, tb, 0)) else {
                continue;
            };
            for (c, name) in ["u", "v"].into_iter().enumerate() {
                let gap = (q[c] - p[c]).abs();
                if !(gap > JUMP * domain[c].length()) {
                    continue;
                }
                if found.len() == NAMED {
                    more += 1;
                } else {
                    found.push(format!(
                        "loop {l} of face {} jumps by {gap} in {name} from trim {a} to trim {b}: \
                         a seam is missing",
                        trim_loop.face
                    ));
                }
            }
        }
    }
    if more > 0 {
        found.push(format!("{more} more jumps of loops are not named"));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector2, Vector3};

    /// No point of a part of an arc is farther out than the formula says, and some point is as far.
    #[test]
    fn extremes_of_arcs() {
        for (from, to, turned) in [
            (0.0, 1.0, 1.0),
            (0.3, 2.0, 1.0),
            (-4.0, 1.5, -1.0),
            (5.0, 5.5, -1.0),
            (-0.25, TAU - 0.25, 1.0),
        ] {
            let (x, y) = (Vector2::new(0.6, 0.8), Vector2::new(-0.8, 0.6) * turned);
            let arc = Arc {
                center: Point2::new(0.5, -2.0),
                x,
                y,
                z: Vector2::zeros(),
                radius: 1.5,
                angle: Interval::new(from, to).unwrap(),
                domain: Interval::new(2.0, 3.0).unwrap(),
            };
            let curve = Curve2::Arc(arc);
            for span in [[2.0, 3.0], [2.25, 2.5], [2.5, 3.0]] {
                let span = Interval::new(span[0], span[1]).unwrap();
                for (c, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
                    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
                    widen(&mut range, &[(&curve, span)], c);
                    let [low, high] = range;
                    let found = if sign < 0.0 { -low } else { high };
                    let samples =
                        (0..=4096).map(|k| sign * curve.point(span.lerp(f64::from(k) / 4096.0))[c]);
                    let most = samples.fold(f64::NEG_INFINITY, f64::max);
                    // Between samples it may rise by the square of half a step.
                    assert!(
                        most <= found + 1e-15 && found <= most + 1e-5,
                        "{found} {most}"
                    );
                }
            }
        }
    }

    const BEZIER: [f64; 6] = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];

    /// A quarter of a circle about the origin, from the x axis.
    fn quarter(radius: f64, scale: f64) -> NurbsCurve<3> {
        let w = std::f64::consts::FRAC_1_SQRT_2;
        let points = [[1.0, 0.0, 1.0], [w, w, w], [0.0, 1.0, 1.0]];
        let points = points.map(|[x, y, w]| Vector3::new(radius * x, radius * y, w) * scale);
        NurbsCurve::new(2, points.to_vec(), BEZIER.to_vec()).unwrap()
    }

    /// Its control polygon goes farther than a quarter of a circle, which touches the border of a domain as wide as its radius, and leaves one that is narrower by
    /// more than the slack.
    #[test]
    fn what_touches_a_border_stays() {
        let both = |end: f64| Interval::new(0.0, end).unwrap();
        for (radius, scale) in [(1.0, 1.0), (3.0, 0.25), (1e-3, 8.0)] {
            let curve = Curve2::Nurbs(quarter(radius, scale));
            let slack = ROUNDING * radius;
            for c in [0, 1] {
                assert!(stays(&curve, c, both(radius), slack));
                assert!(stays(
                    &curve,
                    c,
                    both(radius * (1.0 - 0.25 * ROUNDING)),
                    slack
                ));
                assert!(!stays(
                    &curve,
                    c,
                    both(radius * (1.0 - 2.0 * ROUNDING)),
                    slack
                ));
                let within = Interval::new(2.0 * slack, 2.0 * radius).unwrap();
                assert!(!stays(&curve, c, within, slack));
            }
        }
        // A light control point makes rounding count, and much work is not done.
        let light = [[0.0, 0.0, 1.0], [0.5e-6, 0.5e-6, 1e-6], [1.0, 1.0, 1.0]];
        let light = light.map(Vector3::from).to_vec();
        let light = Curve2::Nurbs(NurbsCurve::new(2, light, BEZIER.to_vec()).unwrap());
        assert!(stays(&light, 1, both(1.0), 1e-3));
        assert!(!stays(&light, 1, both(1.0), 1e-9));
        let line = |count: u16| {
            let points = (0..count)
                .map(|k| Vector3::new(f64::from(k), 0.5, 1.0))
                .collect();
            let inner = (1..count - 1).map(f64::from);
            let end = f64::from(count - 1);
            let knots = [0.0; 2].into_iter().chain(inner).chain([end; 2]).collect();
            Curve2::Nurbs(NurbsCurve::new(1, points, knots).unwrap())
        };
        assert!(stays(&line(1000), 1, both(1.0), ROUNDING));
        assert!(!stays(&line(40_000), 1, both(1.0), ROUNDING));
        // (x, y) = (t, 4 s t (1 - t)): s at most, in the middle, and its control polygon goes to 2 s.
        let points = [[0.0, 0.0], [0.5, 2.0], [1.0, 0.0]];
        let points = points.map(|[x, y]| Vector3::new(x, y, 1.0)).to_vec();
        let hill = Curve2::Nurbs(NurbsCurve::new(2, points, BEZIER.to_vec()).unwrap());
        assert!(stays(&hill, 1, both(1.0), ROUNDING));
        assert!(!stays(&hill, 1, both(1.0 - 2.0 * ROUNDING), ROUNDING));
        assert!(!stays(&hill, 1, both(0.5), ROUNDING));
        // What is found of its parts: the height in the middle, at their ends, and of two the higher.
        let span = |from: f64, to: f64| Interval::new(from, to).unwrap();
        let high = |spans: &[Interval]| {
            let mut range = [f64::INFINITY, f64::NEG_INFINITY];
            let parts: Vec<_> = spans.iter().map(|s| (&hill, *s)).collect();
            widen(&mut range, &parts, 1);
            range[1]
        };
        assert!((high(&[span(0.0, 0.875)]) - 1.0).abs() <= 1e-15);
        assert_eq!(high(&[span(0.75, 1.0)]), 0.75);
        assert!((high(&[span(0.75, 1.0), span(0.0, 0.625)]) - 1.0).abs() <= 1e-15);
    }
}
