//! The side of a point in space, and lines near edges.

use super::answer::{LineKind, LineProbe, SideAnswer, Undecided};
use super::forms::{NOISE_FACTOR, Stabber, range};
use super::line::all_hits;
use super::on_face::{on_level_face, on_some_face};
use super::zeros::{Digits, RawHit};
use crate::numeric::Real;
use crate::numeric::bernstein::{greater, largest, lesser};
use crate::prepare::{Image, Net, PreparedBrep, SharedEdge, Stretch};
use crate::trim::Side;
use nalgebra::{Point3, Vector3};

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;

/// Directions for the parity test: none along an axis or a diagonal, none near another.
pub(super) const DIRECTIONS: [[f64; 3]; 8] = [
    [0.352, 0.521, 0.778],
    [-0.677, 0.283, 0.679],
    [0.187, -0.911, 0.367],
    [0.823, 0.149, -0.548],
    [-0.419, -0.713, -0.562],
    [0.566, -0.307, 0.765],
    [-0.231, 0.891, -0.391],
    [0.937, -0.263, 0.229],
];
/// Nodes that one direction may cost.
pub(super) const PARITY_BUDGET: usize = 20_000;

/// The side of a point in space: whether it is in the solid's material.
///
/// By the parity of certified hits along a ray that keeps clear of every crack and of the regions around vertices; several directions are
/// tried. (Moved across an edge, which bounds two faces, a ray leaves one as it meets the other; elsewhere hits come and go in pairs.
/// So parity does not depend on the ray, if it is clear of the cracks, where faces do not meet.) Open BREPs have no
/// material: `Outside`. A point so near the surface that the hit's enclosure holds it is undecided, but for one that is proven to be
/// exactly on a face: `Boundary`. That is looked for on planes, native quadrics and straight borders.
///
/// What it allocates: see [`Workspace`](super::Workspace).
pub fn inside(
    brep: &PreparedBrep,
    point: Point3<f64>,
    workspace: &mut super::Workspace,
) -> SideAnswer {
    let answer = |side, undecided| SideAnswer {
        side,
        in_gap: false,
        undecided,
    };
    if !brep.brep().is_closed() {
        return answer(Some(Side::Outside), None);
    }
    if brep.is_beyond(&point) {
        return answer(Some(Side::Outside), None);
    }
    if on_level_face(brep, point) {
        return answer(Some(Side::Boundary), None);
    }
    let mut why = Undecided::Degenerate;
    for d in DIRECTIONS {
        let Ok(probe) = LineProbe::new(point, Vector3::from(d), LineKind::Ray) else {
            return answer(None, Some(Undecided::Degenerate));
        };
        workspace.work.rays += 1;
        let stab = Stabber::new(&probe);
        let mut budget = PARITY_BUDGET;
        if meets_vertex(brep, &stab) || near_edges(brep, &stab, &mut budget) {
            why = Undecided::Crack;
            continue;
        }
        let on_surface = |hits: &[RawHit]| hits.iter().any(|h| h.t.lower() <= 0.0);
        let lines = &mut workspace.lines;
        let mut undecided = all_hits(brep, &stab, Digits::Double, &mut budget, lines);
        if undecided.is_some() || on_surface(&lines.hits) {
            // f64 sees only so far.
            undecided = all_hits(brep, &stab, Digits::All, &mut budget, lines);
        }
        let hits = &lines.hits;
        let off_edges = |h: &RawHit| h.exact.as_ref().is_none_or(|m| m.on.is_empty());
        let plain = |h: &RawHit| h.crosses() && !h.is_row() && off_edges(h);
        if undecided.is_some() || !hits.iter().all(plain) {
            why = Undecided::Degenerate;
            continue;
        }
        if on_surface(hits) {
            // On the surface, up to the enclosure: no direction will tell.
            why = Undecided::Degenerate;
            break;
        }
        let side = if hits.len() % 2 == 1 {
            Side::Inside
        } else {
            Side::Outside
        };
        return answer(Some(side), None);
    }
    if on_some_face(brep, point) {
        return answer(Some(Side::Boundary), None);
    }
    answer(None, Some(why))
}

/// Whether the line may meet a region around a vertex.
fn meets_vertex(brep: &PreparedBrep, stab: &Stabber) -> bool {
    brep.vertices()
        .meet(brep, &stab.skewer(), |b| !stab.meets(b))
}

/// Whether the line may come within the width of its crack of an edge that two trims use. Errs on the side of yes.
pub(super) fn near_edges(brep: &PreparedBrep, stab: &Stabber, budget: &mut usize) -> bool {
    let edges = brep.shared_edges();
    let near = |index: usize| is_near_images(brep, stab, &edges[index], budget);
    brep.edges_by_line(&stab.skewer(), |b| !stab.meets(b), near)
}

/// The edges for which that is so.
pub(super) fn all_near_edges<'a>(
    brep: &'a PreparedBrep,
    stab: &Stabber,
    budget: &mut usize,
) -> Vec<&'a SharedEdge> {
    let edges = brep.shared_edges();
    let mut near = Vec::new();
    brep.edges_by_line(
        &stab.skewer(),
        |b| !stab.meets(b),
        |index| {
            near.push(index);
            false
        },
    );
    near.sort_unstable();
    let near = near.into_iter().map(|index| &edges[index]);
    near.filter(|shared| is_near_images(brep, stab, shared, budget))
        .collect()
}

/// Whether the line may come within the width of its crack of the images of an edge's trims.
fn is_near_images(
    brep: &PreparedBrep,
    stab: &Stabber,
    shared: &SharedEdge,
    budget: &mut usize,
) -> bool {
    let d = stab.direction / stab.direction.norm();
    let (o, d) = (stab.origin.coords.into(), d.into());
    let edge = shared.edge;
    let e = &brep.brep().parts().edges[edge];
    let margin = brep.crack_width(edge);
    let mut near = e.trims.iter().filter(|t| {
        if let Some(image) = brep.nearly_closed_image(**t)
            && image.shape.is_clear_of(&o, &d, (margin + image.slack) * UP)
        {
            return false;
        }
        let image = brep.trim_image(**t);
        image.is_none_or(|image| near_image(stab, image, margin, budget))
    });
    let Some(first) = near.next() else {
        return false;
    };
    // f64 sees only so far: what it finds near is looked at again.
    let rest: Vec<_> = std::iter::once(first).chain(near).copied().collect();
    let margin = brep.fine_crack_width(edge);
    rest.into_iter().any(|t| {
        let image = brep.fine_trim_image(t);
        image.is_none_or(|image| near_image(stab, image, margin, budget))
    })
}

/// Whether the line comes within a distance of an image.
fn near_image<T: Real>(stab: &Stabber, image: &Image<T>, margin: f64, budget: &mut usize) -> bool {
    // |L_k| / w is the distance from plane k times |n_k|.
    let norms = [0, 1].map(|k| stab.normals[k].norm() * UP);
    image.stretches.iter().any(|s: &Stretch<T>| {
        let margin = (margin + s.slack + image.extra) * UP;
        let wide = s
            .bounds
            .map(|r| [(r[0] - margin).next_down(), (r[1] + margin).next_up()]);
        // A place of the curve whose height along the line is beyond an end of it may be within the margin of that end.
        let stab = stab.longer(margin);
        let reach = norms.map(|n| margin * n);
        stab.meets(&wide) && !passes(&stab, s, reach) && near_curve(&stab, &s.net(), reach, budget)
    })
}

/// Whether both `|L_k| / w <= reach[k]` somewhere on a curve, as far as the arithmetic can tell.
fn near_curve<T: Real>(
    stab: &Stabber,
    space: &Net<T>,
    reach: [f64; 2],
    budget: &mut usize,
) -> bool {
    let mut stack = vec![(stab.forms(space), 0)];
    while let Some((node, depth)) = stack.pop() {
        let w = range(&node.c[3], node.error[3]);
        let clear = (0..2).any(|k| {
            let r = range(&node.c[k], node.error[k]);
            r[0] > reach[k] * w[1] * UP || r[1] < -reach[k] * w[1] * UP
        });
        if clear || node.beyond(stab) {
            continue;
        }
        let noise = (0..2).all(|k| largest(&node.c[k]) <= NOISE_FACTOR * node.error[k]);
        if *budget == 0 || noise || depth >= NEAR_DEPTH {
            return true;
        }
        *budget -= 1;
        stack.extend(node.halves(true).map(|half| (half, depth + 1)));
    }
    false
}

/// A curve of so many control points is looked at without lists...
const ROOM: usize = 8;
/// ...and halved so often.
const HALVINGS: u32 = 4;

/// Whether a curve plainly passes the line, part by part on the side of its chord.
///
/// `H = a L_1 + b L_2` is the height over the plane with normal `a n_1 + b n_2` through the line, times `w`; where the curve is within `reach` of the
/// line, `|H| <= (|a| reach_1 + |b| reach_2) w`. Of all such planes the one along a part's chord is tried, or one next to it: any does. In f64 a
/// coefficient of `L_k` is off by at most eight roundings of the sum of the magnitudes that make it (the rounding of the curve's points and that of
/// the offset to f64 among them), each halving adds one per degree, and `H` three: [`ROUNDINGS`] are more, of the largest such sum. Weights are positive averages
/// of those of the curve, which are off by as many roundings of themselves at most.
fn passes<T: Real>(stab: &Stabber, curve: &Stretch<T>, reach: [f64; 2]) -> bool {
    const ROUNDINGS: f64 = 32.0 * f64::EPSILON;
    const _: () = assert!(8 + HALVINGS as usize * (ROOM - 1) + 3 < 64);
    let count = curve.points.len();
    if !(2..=ROOM).contains(&count) {
        return false;
    }
    let known = [0, 1].map(|k| stab.offset(k, &curve.origin));
    // What the offsets themselves are off: their parts may cancel.
    let (offsets, rad) = (known.map(|x| x.mid.hi), known.map(|x| x.rad));
    let mut whole = [[0.0; 3]; ROOM];
    let (mut size, mut weight) = ([0.0; 2], 0.0);
    for (at, p) in whole.iter_mut().zip(&curve.points) {
        let x = p.map(|x| x.approximate());
        for k in 0..2 {
            let n = &stab.normals[k];
            let parts = [n[0] * x[0], n[1] * x[1], n[2] * x[2], offsets[k] * x[3]];
            at[k] = parts[0] + parts[1] + parts[2] + parts[3];
            let sum = parts.iter().fold(0.0, |sum, x| sum + x.abs());
            size[k] = greater(size[k], sum);
        }
        at[2] = x[3];
        weight = greater(weight, x[3]);
    }
    let clear = |part: &[[f64; 3]]| {
        let (from, to) = (part[0], part[part.len() - 1]);
        let [a, b] = [1, 0].map(|k| to[k] / to[2] - from[k] / from[2]);
        let b = -b;
        let range = part
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |r, p| {
                let height = a * p[0] + b * p[1];
                [lesser(r[0], height), greater(r[1], height)]
            });
        let within = (a.abs() * reach[0] + b.abs() * reach[1]) * weight;
        let off = a.abs() * size[0] + b.abs() * size[1];
        let inherited = (a.abs() * rad[0] + b.abs() * rad[1]) * weight;
        let far = (within + inherited + ROUNDINGS * off) * UP + f64::MIN_POSITIVE;
        range[0] > far || range[1] < -far
    };
    let mut stack = [(whole, 0); HALVINGS as usize + 1];
    let mut waiting = 1;
    while waiting > 0 {
        waiting -= 1;
        let (mut part, depth) = stack[waiting];
        if clear(&part[..count]) {
            continue;
        }
        if depth == HALVINGS {
            return false;
        }
        let mut high = part;
        for level in 1..count {
            for i in 0..count - level {
                for c in 0..3 {
                    high[i][c] = 0.5 * (high[i][c] + high[i + 1][c]);
                }
            }
            part[level] = high[0];
        }
        stack[waiting] = (high, depth + 1);
        stack[waiting + 1] = (part, depth + 1);
        waiting += 2;
    }
    true
}

/// A part of a boundary piece this many halvings deep that is not clear of the line counts as near.
const NEAR_DEPTH: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Dd;
    use nalgebra::Vector3;

    fn random(seed: &mut u64) -> f64 {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        (*seed >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A line through a point of a curve, off it by less than the margin, never passes it; most that are well off it do.
    #[test]
    fn lines_that_meet_a_curve_do_not_pass_it() {
        let mut seed = 0x853c_49e6_748f_ea9b;
        let mut passed = 0;
        for k in 0..4000 {
            let count = 2 + k % 7;
            let size = 10f64.powi((k % 5) as i32 * 3 - 6);
            let origin = [0, 1, 2].map(|_| 1e3 * size * (random(&mut seed) - 0.5));
            let bend = [1.0, 1e-3, 1e-9, 0.0][k % 4];
            let points: Vec<[Dd; 4]> = (0..count)
                .map(|i| {
                    let w = 10f64.powf(2.0 * random(&mut seed) - 1.0);
                    let x = [0, 1, 2].map(|c| {
                        let along = i as f64 * [1.0, 0.3, -0.2][c];
                        size * w * (along + bend * (random(&mut seed) - 0.5))
                    });
                    [x[0], x[1], x[2], w].map(Dd::from)
                })
                .collect();
            let curve = Stretch {
                points,
                origin,
                slack: 0.0,
                bounds: [[0.0; 2]; 3],
            };
            let s = random(&mut seed);
            let value = curve
                .net()
                .jet(crate::numeric::Ball::exact(s), crate::numeric::Ball::ZERO)
                .value;
            let at = [0, 1, 2].map(|c| (value[c] / value[3]).mid.hi + origin[c]);
            let d =
                Vector3::from_fn(|_, _| random(&mut seed) - 0.5) * size.powi((k % 3) as i32 - 1);
            let back = random(&mut seed) * 100.0;
            let from = Point3::from(at) - d * (back * size / d.norm());
            let probe = |by: f64| {
                let across = d.cross(&Vector3::new(0.3, 0.4, 0.5)).normalize();
                LineProbe::new(from + across * by, d, LineKind::Line).unwrap()
            };
            // The line is off the curve by roundings of its numbers, the margin is many of these.
            let margin = 1e-9 * size;
            let stab = Stabber::new(&probe(0.5 * margin));
            let reach = |stab: &Stabber| [0, 1].map(|k| margin * stab.normals[k].norm() * UP);
            assert!(!passes(&stab, &curve, reach(&stab)), "{k}");
            let stab = Stabber::new(&probe(100.0 * count as f64 * size));
            passed += usize::from(passes(&stab, &curve, reach(&stab)));
        }
        assert!(passed > 3500, "{passed}");
    }

    /// From so far that the parts of its planes' offsets cancel but for what they are rounded by, far more than the curve is long: exactly through the middle
    /// of the curve, so that it does not pass.
    #[test]
    fn lines_from_afar_do_not_pass_what_they_meet() {
        let mut seed = 0x853c_49e6_748f_ea9b;
        for k in 0..400 {
            let digits = |seed: &mut u64| (random(seed) * (1u64 << 26) as f64).floor() + 1.0;
            // The curve's origin less the line's is `d (near + away)`, exactly.
            let d = [0, 1, 2].map(|_| digits(&mut seed));
            let [near, away] = [0, 1].map(|_| digits(&mut seed));
            let near = near * 0.5f64.powi(20 + k % 30);
            let origin = d.map(|x| x * near);
            let from = Point3::from(d.map(|x| -x * away));
            let probe = LineProbe::new(from, Vector3::from(d), LineKind::Line).unwrap();
            let aside = [0, 1, 2].map(|_| 1e-40 * (random(&mut seed) - 0.5));
            let points = [-1.0, 1.0].map(|side| {
                let [x, y, z] = aside.map(|x| Dd::from(side * x));
                [x, y, z, Dd::ONE]
            });
            let curve = Stretch {
                points: points.to_vec(),
                origin,
                slack: 0.0,
                bounds: [[0.0; 2]; 3],
            };
            assert!(!passes(&Stabber::new(&probe), &curve, [0.0; 2]), "{k}");
        }
    }
}
