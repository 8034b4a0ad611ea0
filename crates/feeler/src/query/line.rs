//! Hits of a line with the trimmed faces.
//!
//! # What is proven
//! The line `o + t d` is the zero set of two linear forms `n_k.x - n_k.o` whose normals are exactly
//! orthogonal to `d` (their entries are entries of `d`). On a patch each becomes a polynomial `L_k` in Bernstein form.
//! A box of the patch is put aside when
//! - some combination of `L_1`, `L_2` has one sign on it (then there is no zero), or
//! - the box does not meet the region, or the line's parameter does not reach it, or
//! - it lies within a box that is known to hold one zero only, which is already listed.
//!
//! One zero: let `K = Y L` with a constant matrix `Y` and `|I - K'| <= e < 1` (maximum norm) on a convex box. For two
//! points `K(x) - K(p) = M (x - p)` with `|I - M| <= e` (mean values), so `|x - p| <= |K(x) - K(p)| / (1 - e)`: there is at most
//! one zero, it is within `rho = |K(p)| / (1 - e)` of `p`, and if the ball of that radius lies in the box there
//! is one (Brouwer's theorem on `x -> x - K(x)`, which maps the ball into itself).
//!
//! What cannot be settled so (a tangent line, a hit within rounding of the region's border) makes the answer
//! `Undecided`; it is never dropped.

use super::answer::{
    Feature, Hit, LineAnswer, LineKind, LineProbe, Options, Separation, Undecided,
};
use super::search::Arithmetic;
use crate::numeric::bernstein::{Bidegree, largest, split, split_error};
use crate::numeric::{Ball, Dd, Enclosure, Real};
use crate::prepare::{Net, PreparedBrep};
use crate::trim::{BoxSide, Side};
use nalgebra::{Point2, Point3, Vector3};

/// Boxes on which a form is below this many of its error bounds are left to the next arithmetic.
const NOISE_FACTOR: f64 = 8.0;
/// Boxes are not split below this width in local parameters.
const LEAST_WIDTH: f64 = 1.0 / (1u64 << 40) as f64;
/// Steps of Newton's method; each double-double step gains about 50 bits.
const NEWTON_STEPS: usize = 12;
/// Two hits of one face nearer than this in the line's own length units, relative to the model's
/// size, on patches that share a border, are one.
const SAME_HIT: f64 = 1.0 / (1u64 << 36) as f64;
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;

/// The line in exact terms.
pub(super) struct Stabber {
    origin: Point3<f64>,
    direction: Vector3<f64>,
    /// Normals of two planes through the line, exactly orthogonal to the direction.
    normals: [Vector3<f64>; 2],
    /// The coordinate in which the direction is longest.
    axis: usize,
    /// Range of t.
    range: [f64; 2],
}

impl Stabber {
    pub(super) fn new(probe: &LineProbe) -> Self {
        let d = probe.direction;
        let axis = d.iamax();
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let normal = |other: usize| {
            let mut n = Vector3::zeros();
            n[other] = d[axis];
            n[axis] = -d[other];
            n
        };
        Self {
            origin: probe.origin,
            direction: d,
            normals: [normal(b), normal(c)],
            axis,
            range: match probe.kind {
                LineKind::Line => [f64::NEG_INFINITY, f64::INFINITY],
                LineKind::Ray => [0.0, f64::INFINITY],
                LineKind::Segment => [0.0, 1.0],
            },
        }
    }

    /// `n_k.(origin of the net - o)`.
    fn offset(&self, k: usize, net_origin: &[f64; 3]) -> Ball<Dd> {
        let mut sum = Ball::ZERO;
        for c in 0..3 {
            sum = sum
                + Ball::exact(self.normals[k][c]) * Ball::difference(net_origin[c], self.origin[c]);
        }
        sum
    }

    /// `L_k` and the numerator of `t`: coefficients and one bound for each of the three.
    fn forms<T: Real>(&self, net: &Net<T>) -> Forms<T> {
        let x: [_; 3] = std::array::from_fn(|c| net.coordinate(c));
        let w = net.coordinate(3);
        let form = |n: &Vector3<f64>, offset: Ball<Dd>| {
            let offset = Ball::<T>::from_dd(offset.mid, offset.rad);
            let m: [T; 3] = std::array::from_fn(|c| T::from_f64(n[c]));
            let values: Vec<T> = (0..net.degree.count())
                .map(|i| {
                    m[0] * x[0].values[i]
                        + m[1] * x[1].values[i]
                        + m[2] * x[2].values[i]
                        + offset.mid * w.values[i]
                })
                .collect();
            let mut size = offset.magnitude() * w.largest;
            let mut error = offset.magnitude() * w.error + offset.rad * w.largest;
            for c in 0..3 {
                size += n[c].abs() * x[c].largest;
                error += n[c].abs() * x[c].error;
            }
            // At most eight roundings of parts no larger than the sum of the largest.
            (values, (error + 8.0 * T::UNIT * size) * UP)
        };
        let (l1, e1) = form(&self.normals[0], self.offset(0, &net.origin));
        let (l2, e2) = form(&self.normals[1], self.offset(1, &net.origin));
        let mut unit = Vector3::zeros();
        unit[self.axis] = 1.0;
        let shift = Ball::difference(net.origin[self.axis], self.origin[self.axis]);
        let (t, et) = form(&unit, shift);
        Forms {
            degree: net.degree,
            c: [l1, l2, t, w.values],
            error: [e1, e2, et, w.error],
            u: [0.0, 1.0],
            v: if net.degree.v == 0 {
                [0.0, 0.0]
            } else {
                [0.0, 1.0]
            },
        }
    }

    /// Whether a box in space can meet the line; each product may be off by a few roundings.
    fn meets(&self, b: &[[f64; 2]; 3]) -> bool {
        let (mut low, mut high) = (self.range[0], self.range[1]);
        for c in 0..3 {
            let (o, d) = (self.origin[c], self.direction[c]);
            if d == 0.0 {
                if o < b[c][0] || o > b[c][1] {
                    return false;
                }
                continue;
            }
            let (p, q) = ((b[c][0] - o) / d, (b[c][1] - o) / d);
            let slack = 4.0 * f64::EPSILON * p.abs().max(q.abs());
            low = low.max(p.min(q) - slack);
            high = high.min(p.max(q) + slack);
        }
        !(low > high)
    }

    /// `t` of a homogeneous point relative to a net's origin.
    fn parameter(&self, point: &[Ball<Dd>; 4], net_origin: &[f64; 3]) -> Ball<Dd> {
        let shift = Ball::difference(net_origin[self.axis], self.origin[self.axis]);
        (point[self.axis] / point[3] + shift) / Ball::exact(self.direction[self.axis])
    }

    /// `L_1`, `L_2` of a homogeneous vector.
    fn apply(&self, h: &[Ball<Dd>; 4], offsets: &[Ball<Dd>; 2]) -> [Ball<Dd>; 2] {
        std::array::from_fn(|k| {
            let n = &self.normals[k];
            Ball::exact(n[0]) * h[0]
                + Ball::exact(n[1]) * h[1]
                + Ball::exact(n[2]) * h[2]
                + offsets[k] * h[3]
        })
    }
}

/// `L_1`, `L_2`, the numerator of `t d_axis`, and `w`, over a box.
#[derive(Clone, Debug)]
struct Forms<T> {
    degree: Bidegree,
    c: [Vec<T>; 4],
    error: [f64; 4],
    u: [f64; 2],
    v: [f64; 2],
}

/// `(min, max)` of coefficients, widened by their error and by the rounding to f64.
fn range<T: Real>(c: &[T], error: f64) -> [f64; 2] {
    let r = c.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |r, x| {
        let x = x.approximate();
        [r[0].min(x), r[1].max(x)]
    });
    [
        r[0] - error * UP - f64::EPSILON * r[0].abs(),
        r[1] + error * UP + f64::EPSILON * r[1].abs(),
    ]
}

/// Range of the derivative along u or v, in coordinates that run over the box from 0 to 1.
fn slope_range<T: Real>(c: &[T], degree: Bidegree, along_u: bool, error: f64) -> [f64; 2] {
    let width = degree.v + 1;
    let (step, factor) = if along_u {
        (width, degree.u)
    } else {
        (1, degree.v)
    };
    let mut out = [f64::INFINITY, f64::NEG_INFINITY];
    for i in 0..=degree.u {
        for j in 0..=degree.v {
            if (along_u && i == degree.u) || (!along_u && j == degree.v) {
                continue;
            }
            let at = i * width + j;
            let d = (c[at + step] - c[at]).approximate();
            out = [out[0].min(d), out[1].max(d)];
        }
    }
    if factor == 0 {
        return [0.0, 0.0];
    }
    let size = out[0].abs().max(out[1].abs());
    let slack = 2.0 * error + 4.0 * f64::EPSILON * size;
    let f = factor as f64;
    [
        (out[0] - slack) * f * signed_up(out[0], false),
        (out[1] + slack) * f * signed_up(out[1], true),
    ]
}

/// A factor next to 1 that moves `x` outward.
fn signed_up(x: f64, high: bool) -> f64 {
    if (x > 0.0) == high {
        UP
    } else {
        1.0 - 64.0 * f64::EPSILON
    }
}

impl<T: Real> Forms<T> {
    fn has_no_zero(&self) -> bool {
        (0..2).any(|k| {
            let r = range(&self.c[k], self.error[k]);
            r[0] > 0.0 || r[1] < 0.0
        })
    }

    /// Whether the line's range of t misses the box.
    fn beyond(&self, stab: &Stabber) -> bool {
        let [low, high] = stab.range;
        if low == f64::NEG_INFINITY {
            return false;
        }
        let d = stab.direction[stab.axis];
        // t - low = (T - low d w) / (d w): the sign of T - low d w times that of d.
        let side = |bound: f64| {
            let (limit, sign) = (T::from_f64(bound) * T::from_f64(d), T::from_f64(d.signum()));
            let values: Vec<T> = self.c[2]
                .iter()
                .zip(&self.c[3])
                .map(|(t, w)| (*t - limit * *w) * sign)
                .collect();
            let size = largest(&self.c[2]) + (bound * d).abs() * largest(&self.c[3]);
            let error = self.error[2] + (bound * d).abs() * self.error[3] + 8.0 * T::UNIT * size;
            range(&values, error * UP)
        };
        side(low)[1] < 0.0 || (high.is_finite() && side(high)[0] > 0.0)
    }

    fn halves(&self, along_u: bool) -> [Self; 2] {
        let mut low = self.clone();
        let mut high = self.clone();
        for k in 0..4 {
            let (a, b) = split(&self.c[k], self.degree, along_u);
            let e = self.error[k] + split_error::<T>(self.degree, along_u, largest(&self.c[k]));
            (low.c[k], high.c[k]) = (a, b);
            (low.error[k], high.error[k]) = (e * UP, e * UP);
        }
        if along_u {
            let m = 0.5 * (self.u[0] + self.u[1]);
            (low.u[1], high.u[0]) = (m, m);
        } else {
            let m = 0.5 * (self.v[0] + self.v[1]);
            (low.v[1], high.v[0]) = (m, m);
        }
        [low, high]
    }

    /// The Jacobian of `(L_1, L_2)` in the middle of the box, roughly, by mean differences.
    fn jacobian(&self) -> [[f64; 2]; 2] {
        std::array::from_fn(|k| {
            std::array::from_fn(|along| {
                let r = slope_range(&self.c[k], self.degree, along == 0, 0.0);
                0.5 * (r[0] + r[1])
            })
        })
    }

    /// A linear combination of `L_1` and `L_2`, and its error.
    fn combine(&self, y: [f64; 2]) -> (Vec<T>, f64) {
        let [p, q] = y.map(T::from_f64);
        let values = self.c[0]
            .iter()
            .zip(&self.c[1])
            .map(|(a, b)| p * *a + q * *b)
            .collect();
        let size: f64 = (0..2).map(|k| y[k].abs() * largest(&self.c[k])).sum();
        let error: f64 = (0..2).map(|k| y[k].abs() * self.error[k]).sum();
        (values, (error + 4.0 * T::UNIT * size) * UP)
    }
}

/// A hit before it is dressed up.
#[derive(Clone, Debug)]
pub(super) struct RawHit {
    pub(super) face: usize,
    pub(super) patch: usize,
    /// Local parameters on the patch, within `rho` of the true ones.
    pub(super) local: [Dd; 2],
    pub(super) rho: f64,
    pub(super) t: Ball<Dd>,
    /// Whether the hit is proven to be in the region's interior.
    pub(super) inside: bool,
}

/// All hits with one face's patches, or what could not be settled.
pub(super) struct FaceHits {
    pub(super) hits: Vec<RawHit>,
    /// Local boxes that may hold hits that could not be settled: patch, u, v.
    pub(super) open: Vec<(usize, [f64; 2], [f64; 2])>,
}

/// Finds the hits of a line with one face.
pub(super) fn face_hits(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    budget: &mut usize,
) -> Option<FaceHits> {
    let geometry = brep.double(face);
    let mut out = FaceHits {
        hits: Vec::new(),
        open: Vec::new(),
    };
    for (index, patch) in geometry.patches.iter().enumerate() {
        if geometry.patch_boxes[index]
            .as_ref()
            .is_some_and(|b| !stab.meets(b))
        {
            continue;
        }
        let roots = vec![stab.forms(&patch.net)];
        patch_hits(brep, stab, face, index, roots, budget, &mut out);
    }
    // What f64 cannot settle (a line nearly tangent to the face) is tried again in double-double.
    let open = std::mem::take(&mut out.open);
    for (index, _) in geometry.patches.iter().enumerate() {
        let boxes: Vec<_> = open.iter().filter(|o| o.0 == index).collect();
        if boxes.is_empty() {
            continue;
        }
        let root = stab.forms(&brep.double_double(face).patches[index].net);
        let roots = boxes.iter().map(|o| narrow(&root, o.1, o.2)).collect();
        patch_hits(brep, stab, face, index, roots, budget, &mut out);
    }
    Some(out)
}

/// A box that holds one zero at most, which is known.
struct Solved {
    u: [f64; 2],
    v: [f64; 2],
}

/// The part of a root over a box that was reached by halving it.
fn narrow(root: &Forms<Dd>, u: [f64; 2], v: [f64; 2]) -> Forms<Dd> {
    let mut node = root.clone();
    for (along_u, target) in [(true, u), (false, v)] {
        loop {
            let r = if along_u { node.u } else { node.v };
            if r[1] - r[0] <= target[1] - target[0] {
                break;
            }
            let [low, high] = node.halves(along_u);
            node = if target[1] <= 0.5 * (r[0] + r[1]) {
                low
            } else {
                high
            };
        }
    }
    node
}

fn patch_hits<T: Real + Arithmetic>(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    patch: usize,
    roots: Vec<Forms<T>>,
    budget: &mut usize,
    out: &mut FaceHits,
) {
    let geometry = brep.double(face);
    let maps = &geometry.patches[patch].maps;
    let classify = |u: [f64; 2], v: [f64; 2]| {
        brep.region(face).classify_box(
            maps[0].to_native_range(u[0], u[1]),
            maps[1].to_native_range(v[0], v[1]),
        )
    };
    let mut solved: Vec<Solved> = Vec::new();
    let mut stack: Vec<_> = roots.into_iter().map(|r| (r, false)).collect();
    while let Some((node, mut inside)) = stack.pop() {
        let within = |s: &Solved| {
            s.u[0] <= node.u[0] && node.u[1] <= s.u[1] && s.v[0] <= node.v[0] && node.v[1] <= s.v[1]
        };
        if node.has_no_zero() || node.beyond(stab) || solved.iter().any(within) {
            continue;
        }
        if *budget == 0 {
            out.open.push((patch, node.u, node.v));
            continue;
        }
        *budget -= 1;
        if !inside {
            match classify(node.u, node.v) {
                BoxSide::Outside => continue,
                BoxSide::Inside => inside = true,
                BoxSide::Mixed => {}
            }
        }
        let j = node.jacobian();
        let det = j[0][0] * j[1][1] - j[0][1] * j[1][0];
        let size = (j[0][0].abs() + j[0][1].abs()) * (j[1][0].abs() + j[1][1].abs());
        // The combination with the least slope: a line that passes the patch has one sign there.
        let flat = if j[0][0].abs() + j[0][1].abs() >= j[1][0].abs() + j[1][1].abs() {
            let k = if j[0][0].abs() >= j[0][1].abs() { 0 } else { 1 };
            if j[0][k] == 0.0 {
                [1.0, 0.0]
            } else {
                [-j[1][k] / j[0][k], 1.0]
            }
        } else {
            let k = if j[1][0].abs() >= j[1][1].abs() { 0 } else { 1 };
            [1.0, -j[0][k] / j[1][k]]
        };
        let (c, e) = node.combine(flat);
        let r = range(&c, e);
        if r[0] > 0.0 || r[1] < 0.0 {
            continue;
        }
        let noise = largest(&c) <= NOISE_FACTOR * e;
        if det.abs() > 64.0 * f64::EPSILON * size {
            let y = [
                [j[1][1] / det, -j[0][1] / det],
                [-j[1][0] / det, j[0][0] / det],
            ];
            let signs = (0..2).any(|k| {
                let (c, e) = node.combine(y[k]);
                let r = range(&c, e);
                r[0] > 0.0 || r[1] < 0.0
            });
            if signs {
                continue;
            }
            if contraction(&node, &y) < 1.0
                && let Some((hit, zone)) = certify(brep, stab, face, patch, &node)
            {
                let settled = within(&zone);
                if let Some(hit) = hit {
                    let known = solved.iter().any(|s| {
                        s.u[0] <= hit.local[0].hi
                            && hit.local[0].hi <= s.u[1]
                            && s.v[0] <= hit.local[1].hi
                            && hit.local[1].hi <= s.v[1]
                    });
                    // Or an earlier pass found it: then the balls overlap.
                    let listed = out.hits.iter().any(|o| {
                        o.patch == patch
                            && (0..2).all(|k| {
                                (o.local[k] - hit.local[k]).hi.abs() <= UP * (o.rho + hit.rho)
                            })
                    });
                    if !known && !listed {
                        accept(stab, hit, classify, inside, out);
                    }
                }
                solved.push(zone);
                if settled {
                    continue;
                }
            }
        }
        let wide = (node.u[1] - node.u[0]).max(node.v[1] - node.v[0]);
        if noise || wide <= LEAST_WIDTH {
            out.open.push((patch, node.u, node.v));
            continue;
        }
        let along_u = node.u[1] - node.u[0] >= node.v[1] - node.v[0];
        let [a, b] = node.halves(along_u);
        stack.push((b, inside));
        stack.push((a, inside));
    }
}

/// Takes a certified zero in, unless it is outside the region or the line's range.
fn accept(
    stab: &Stabber,
    mut hit: RawHit,
    classify: impl Fn([f64; 2], [f64; 2]) -> BoxSide,
    inside: bool,
    out: &mut FaceHits,
) {
    let r = hit.rho * UP + 4.0 * f64::EPSILON;
    let around = |k: usize| {
        [
            (hit.local[k].hi - r).max(0.0),
            (hit.local[k].hi + r).min(1.0),
        ]
    };
    let side = match classify(around(0), around(1)) {
        BoxSide::Outside => return,
        BoxSide::Inside => true,
        BoxSide::Mixed => inside,
    };
    hit.inside &= side;
    if hit.t.upper() < stab.range[0] || hit.t.lower() > stab.range[1] {
        return;
    }
    out.hits.push(hit);
}

/// `|I - K'|` in the maximum norm over the box, for `K = Y L`.
fn contraction<T: Real>(node: &Forms<T>, y: &[[f64; 2]; 2]) -> f64 {
    let mut worst: f64 = 0.0;
    for k in 0..2 {
        let (c, e) = node.combine(y[k]);
        let mut row = 0.0;
        for along in 0..2 {
            let r = slope_range(&c, node.degree, along == 0, e);
            let target = if k == along { 1.0 } else { 0.0 };
            row += (r[0] - target).abs().max((r[1] - target).abs());
        }
        worst = worst.max(row * UP);
    }
    worst
}

/// The zero near a node, and a box about it in which it is the only one.
fn certify<T: Real + Arithmetic>(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    patch: usize,
    node: &Forms<T>,
) -> Option<(Option<RawHit>, Solved)> {
    let geometry = brep.double_double(face);
    let net = &geometry.patches[patch].net;
    let offsets = [0, 1].map(|k| stab.offset(k, &net.origin));
    let mut p = [
        Dd::from(0.5 * (node.u[0] + node.u[1])),
        Dd::from(0.5 * (node.v[0] + node.v[1])),
    ];
    let mut y = [[0.0; 2]; 2];
    for _ in 0..NEWTON_STEPS {
        let jet = net.jet(ball(p[0]), ball(p[1]));
        let l = stab.apply(&jet.value, &offsets);
        let (ls, lt) = (stab.apply(&jet.s, &offsets), stab.apply(&jet.t, &offsets));
        let j = [[ls[0].mid.hi, lt[0].mid.hi], [ls[1].mid.hi, lt[1].mid.hi]];
        let det = j[0][0] * j[1][1] - j[0][1] * j[1][0];
        if det == 0.0 || !det.is_finite() {
            return None;
        }
        y = [
            [j[1][1] / det, -j[0][1] / det],
            [-j[1][0] / det, j[0][0] / det],
        ];
        let mut moved: f64 = 0.0;
        for k in 0..2 {
            let step = -(y[k][0] * l[0].mid.hi + y[k][1] * l[1].mid.hi);
            let next = p[k] + Dd::from(step);
            // Stay near the patch: zeros far off are of no use.
            p[k] = if next.hi < -0.5 * EXTENSION {
                Dd::from(-0.5 * EXTENSION)
            } else if next.hi > 1.0 + 0.5 * EXTENSION {
                Dd::from(1.0 + 0.5 * EXTENSION)
            } else {
                next
            };
            moved = moved.max(step.abs());
        }
        if moved < f64::EPSILON * f64::EPSILON {
            break;
        }
    }
    // The zone: twice the node's width about p, within the extended patch.
    let zone = |k: usize, r: [f64; 2]| {
        let h = r[1] - r[0];
        [
            (p[k].hi - h).max(-EXTENSION),
            (p[k].hi + h).min(1.0 + EXTENSION),
        ]
    };
    let (u, v) = (zone(0, node.u), zone(1, node.v));
    let widths = [u[1] - u[0], v[1] - v[0]];
    let near = restrict(
        &stab.forms(&T::geometry(brep, face).patches[patch].net),
        u,
        v,
    );
    // Y for coordinates that run over the zone from 0 to 1.
    let scaled = [0, 1].map(|k| y[k].map(|x| x / widths[k]));
    let e = contraction(&near, &scaled);
    if !(e < 1.0) {
        return None;
    }
    let jet = net.jet(ball(p[0]), ball(p[1]));
    let l = stab.apply(&jet.value, &offsets);
    let mut residual: f64 = 0.0;
    for row in &scaled {
        let k = Ball::exact(row[0]) * l[0] + Ball::exact(row[1]) * l[1];
        residual = residual.max(k.magnitude());
    }
    let rho = residual / (1.0 - e) * UP / (1.0 - f64::EPSILON);
    let local_rho = rho * widths[0].max(widths[1]) * UP;
    // Within the node, or at least not far from it: else another node will find it.
    let apart = |x: f64, r: [f64; 2]| (r[0] - x).max(x - r[1]).max(0.0) / (r[1] - r[0]);
    if apart(p[0].hi, node.u) > 0.5 || apart(p[1].hi, node.v) > 0.5 {
        return None;
    }
    // A zero exists if its ball is in the zone.
    let reach = |k: usize| Dd::from(rho * widths[k] * UP);
    let exists = (0..2).all(|k| {
        let r = if k == 0 { u } else { v };
        (p[k] - reach(k)).hi > r[0] && (p[k] + reach(k)).hi < r[1]
    });
    if !exists {
        return None;
    }
    // It counts if it is on the patch. One that is not is on the next patch, or nowhere: on a joint the
    // two patches are the same curve, so that they agree on which side of it the line passes.
    let off = |k: usize| p[k] + reach(k) < Dd::ZERO || p[k] - reach(k) > Dd::ONE;
    if off(0) || off(1) {
        return Some((None, Solved { u, v }));
    }
    // Within rounding of the border of the whole surface the hit cannot be settled; on a joint it is
    // found on both sides and listed once.
    let domain = brep.brep().surface(face).domain();
    let maps = &geometry.patches[patch].maps;
    let on_edge = (0..2).any(|k| {
        let low = p[k] - reach(k) < Dd::ZERO && maps[k].start == domain[k].start;
        let high = p[k] + reach(k) > Dd::ONE && maps[k].end == domain[k].end;
        low || high
    });
    let t = stab.parameter(&jet.value, &net.origin);
    // t moves with the point: bounded by the slopes over the zone.
    let reach = parameter_slope(&near, stab) * rho * UP;
    let t = Ball {
        mid: t.mid,
        rad: (t.rad + reach) * UP,
    };
    let hit = RawHit {
        face,
        patch,
        local: p,
        rho: local_rho,
        t,
        inside: !on_edge,
    };
    Some((Some(hit), Solved { u, v }))
}

/// How far the polynomials of a patch are followed past its border, in local parameters.
const EXTENSION: f64 = 1.0 / 1024.0;

/// `|dt/dx|` over a zone, summed over both directions: `t = T / (w d)`.
fn parameter_slope<T: Real>(near: &Forms<T>, stab: &Stabber) -> f64 {
    let w = range(&near.c[3], near.error[3]);
    if !(w[0] > 0.0) {
        return f64::INFINITY;
    }
    let t_max = largest(&near.c[2]) + near.error[2];
    let mut sum = 0.0;
    for along_u in [true, false] {
        let dt = slope_range(&near.c[2], near.degree, along_u, near.error[2]);
        let dw = slope_range(&near.c[3], near.degree, along_u, near.error[3]);
        let dt = dt[0].abs().max(dt[1].abs());
        let dw = dw[0].abs().max(dw[1].abs());
        sum += dt / w[0] + t_max * dw / (w[0] * w[0]);
    }
    sum / stab.direction[stab.axis].abs() * UP
}

/// The forms over `[u] x [v]` of a root, by blossoming; each of the `degree` steps in each
/// direction adds three roundings of numbers no larger than the largest coefficient.
fn restrict<T: Real>(root: &Forms<T>, u: [f64; 2], v: [f64; 2]) -> Forms<T> {
    let mut out = root.clone();
    for k in 0..4 {
        let d = root.degree;
        let size = largest(&root.c[k]);
        let mut c = root.c[k].clone();
        c = restrict_along(&c, d, true, u);
        c = restrict_along(&c, d, false, v);
        let steps = 3 * (d.u + d.v) + 2;
        // Past the border a step is no average but grows by 1 + 2 EXTENSION at most: less than twofold
        // over 50 steps.
        out.error[k] = 2.0 * (root.error[k] + steps as f64 * T::UNIT * size) * UP;
        out.c[k] = c;
    }
    out.u = u;
    out.v = v;
    out
}

fn restrict_along<T: Real>(c: &[T], d: Bidegree, along_u: bool, r: [f64; 2]) -> Vec<T> {
    let (stride, count, lines, step) = if along_u {
        (d.v + 1, d.u, d.v + 1, 1)
    } else {
        (1, d.v, d.u + 1, d.v + 1)
    };
    let mut out = c.to_vec();
    for line in 0..lines {
        for k in 0..=count {
            let mut row: Vec<T> = (0..=count).map(|i| c[line * step + i * stride]).collect();
            for level in 0..count {
                let x = T::from_f64(if level < count - k { r[0] } else { r[1] });
                let y = T::ONE - x;
                for i in 0..count - level {
                    row[i] = y * row[i] + x * row[i + 1];
                }
            }
            out[line * step + k * stride] = row[0];
        }
    }
    out
}

fn ball(x: Dd) -> Ball<Dd> {
    Ball { mid: x, rad: 0.0 }
}

/// Whether the line comes within the width of a crack (taken [`CRACK_FACTOR`] times, plus `clearance`) of a
/// boundary piece of a face. Errs on the side of yes.
fn near_boundary(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    clearance: f64,
    budget: &mut usize,
) -> bool {
    let geometry = brep.double(face);
    let norms = [0, 1].map(|k| stab.normals[k].norm() * UP);
    for index in 0..geometry.piece_count() {
        let trim = geometry.piece_trim(index);
        let crack = match trim.map(|t| brep.brep().parts().trims[t].edge) {
            Some(Some(edge)) => brep.cracks()[edge],
            // A pole.
            Some(None) => 0.0,
            // A gap between two trims.
            None => brep.widest_crack(),
        };
        let margin = CRACK_FACTOR * crack + clearance;
        // |L_k| / w is the distance from plane k times |n_k|.
        let reach = norms.map(|n| margin * n);
        if let Some(b) = &geometry.patch_boxes[geometry.piece_patch(index)] {
            let wide = b.map(|r| [r[0] - margin, r[1] + margin]);
            if !stab.meets(&wide) {
                continue;
            }
        }
        let Some(space) = &geometry.piece(index).space else {
            return true;
        };
        if !near_curve(stab, space, reach, budget) {
            continue;
        }
        // f64 sees only so far: what it finds near is looked at again.
        let fine = &brep.double_double(face).piece(index).space;
        if fine
            .as_ref()
            .is_none_or(|space| near_curve(stab, space, reach, budget))
        {
            return true;
        }
    }
    false
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

/// A part of a boundary piece this many halvings deep that is not clear of the line counts as near.
const NEAR_DEPTH: usize = 64;

/// All hits of a line with the trimmed faces.
///
/// `hits` holds every parameter where the line meets a face, in order of `t`, each with a proven
/// enclosure; a hit on an edge is listed for each of its faces. `crossings` counts transversal passages, hits within
/// the width of a crack of each other at an edge counting once. A line that touches a face or runs in it, or meets it within
/// rounding of its border, is `Undecided`, with what was found.
pub fn line(
    brep: &PreparedBrep,
    probe: &LineProbe,
    options: &Options,
    _workspace: &mut super::Workspace,
) -> LineAnswer {
    let stab = Stabber::new(probe);
    let mut budget = options.node_budget;
    let (raw, mut undecided) = all_hits(brep, &stab, &mut budget);
    // A closed range of t: a hit whose enclosure holds an end of it is not settled.
    let at_end = |h: &RawHit| {
        stab.range.iter().any(|e| {
            e.is_finite()
                && h.t.lower() <= *e
                && *e <= h.t.upper()
                && h.t.rad > 0.0
                && h.t.mid != Dd::from(*e)
        })
    };
    if raw.iter().any(at_end) {
        undecided = Some(Undecided::Degenerate);
    }
    let near =
        (CRACK_FACTOR * brep.widest_crack() + SAME_HIT * brep.size()) / probe.direction.norm();
    let mut crossings = 0;
    let mut last: Option<&RawHit> = None;
    for hit in &raw {
        let merged = last.is_some_and(|l| {
            l.face != hit.face
                && (hit.t.mid - l.t.mid).hi.abs() <= near
                && (close_to_border(brep, l) || close_to_border(brep, hit))
        });
        if !merged {
            crossings += 1;
        }
        last = Some(hit);
    }
    // Only what is certain is listed.
    let hits: Vec<Hit> = raw
        .iter()
        .filter(|h| h.inside)
        .filter_map(|h| dress(brep, &stab, h))
        .collect();
    let in_crack = passes_crack(brep, &stab, &raw);
    LineAnswer {
        hits,
        crossings,
        in_crack,
        undecided,
    }
}

/// The hits with all faces in order of t, those on a shared border of two patches of a face once.
fn all_hits(
    brep: &PreparedBrep,
    stab: &Stabber,
    budget: &mut usize,
) -> (Vec<RawHit>, Option<Undecided>) {
    let mut raw: Vec<RawHit> = Vec::new();
    let mut undecided = None;
    let apart = SAME_HIT * brep.size() / stab.direction.norm();
    for face in 0..brep.brep().faces().len() {
        if brep.face_box(face).is_some_and(|b| !stab.meets(b)) {
            continue;
        }
        let Some(found) = face_hits(brep, stab, face, budget) else {
            undecided = Some(Undecided::Degenerate);
            continue;
        };
        if !found.open.is_empty() {
            undecided = Some(if *budget == 0 {
                Undecided::Budget
            } else {
                Undecided::Degenerate
            });
        }
        let first = raw.len();
        for hit in found.hits {
            if !hit.inside {
                undecided = Some(Undecided::Degenerate);
            }
            let same = raw[first..].iter().any(|o: &RawHit| {
                o.patch != hit.patch
                    && (o.t.mid - hit.t.mid).hi.abs() <= apart
                    && on_border(o)
                    && on_border(&hit)
            });
            if !same {
                raw.push(hit);
            }
        }
    }
    raw.sort_by(|a, b| {
        let by_t = a.t.mid.partial_cmp(&b.t.mid);
        by_t.unwrap_or(std::cmp::Ordering::Equal)
            .then(a.face.cmp(&b.face))
    });
    (raw, undecided)
}

/// Directions for the parity test: none along an axis or a diagonal, none near another.
const DIRECTIONS: [[f64; 3]; 8] = [
    [0.352, 0.521, 0.778],
    [-0.677, 0.283, 0.679],
    [0.187, -0.911, 0.367],
    [0.823, 0.149, -0.548],
    [-0.419, -0.713, -0.562],
    [0.566, -0.307, 0.765],
    [-0.231, 0.891, -0.391],
    [0.937, -0.263, 0.229],
];
/// A crack's width is sampled: it is taken this many times where it must not be missed.
const CRACK_FACTOR: f64 = 2.0;
/// A parity ray keeps this far from edges, relative to the model's size, beyond the cracks: more than the
/// rounding of the crack's estimate.
const CLEARANCE: f64 = 1.0 / (1u64 << 49) as f64;
/// Nodes that one direction may cost.
const PARITY_BUDGET: usize = 20_000;

/// The side of a point in space: whether it is in the solid's material.
///
/// By the parity of certified hits along a ray that stays clear of every edge by twice the width of its
/// crack; several directions are tried. Open BREPs have no material: `Outside`. A point so near the
/// surface that the hit's enclosure holds it is undecided.
pub fn inside(
    brep: &PreparedBrep,
    point: Point3<f64>,
    _workspace: &mut super::Workspace,
) -> super::SideAnswer {
    let answer = |side, undecided| super::SideAnswer {
        side,
        in_gap: false,
        undecided,
    };
    if !brep.brep().is_closed() {
        return answer(Some(Side::Outside), None);
    }
    let clearance = CLEARANCE * brep.size();
    let faces = brep.brep().faces().len();
    let mut why = Undecided::Degenerate;
    for d in DIRECTIONS {
        let Ok(probe) = LineProbe::new(point, Vector3::from(d), LineKind::Ray) else {
            return answer(None, Some(Undecided::Degenerate));
        };
        let stab = Stabber::new(&probe);
        let mut budget = PARITY_BUDGET;
        if (0..faces).any(|f| near_boundary(brep, &stab, f, clearance, &mut budget)) {
            why = Undecided::Crack;
            continue;
        }
        let (hits, undecided) = all_hits(brep, &stab, &mut budget);
        if undecided.is_some() {
            why = Undecided::Degenerate;
            continue;
        }
        if hits.iter().any(|h| h.t.lower() <= 0.0) {
            // On the surface, up to the enclosure: no direction will tell.
            return answer(None, Some(Undecided::Degenerate));
        }
        let side = if hits.len() % 2 == 1 {
            Side::Inside
        } else {
            Side::Outside
        };
        return answer(Some(side), None);
    }
    answer(None, Some(why))
}

fn on_border(h: &RawHit) -> bool {
    let near = SAME_HIT;
    h.local.iter().any(|x| x.hi <= near || x.hi >= 1.0 - near)
}

/// Whether the hit lies so near the border of its region that the other face of the edge may
/// be hit too.
fn close_to_border(brep: &PreparedBrep, h: &RawHit) -> bool {
    let geometry = brep.double(h.face);
    let patch = &geometry.patches[h.patch];
    let jet = patch
        .net
        .jet(Ball::exact(h.local[0].hi), Ball::exact(h.local[1].hi));
    let w = jet.value[3].mid;
    let speed = |d: &[Ball<f64>; 4]| {
        let v = Vector3::from_fn(|c, _| (d[c].mid - d[3].mid * jet.value[c].mid / w) / w);
        v.norm().max(f64::MIN_POSITIVE)
    };
    let reach = CRACK_FACTOR * brep.widest_crack() + SAME_HIT * brep.size();
    let around = |k: usize, speed: f64| {
        let r = (reach / speed).min(1.0);
        let x = h.local[k].hi;
        patch.maps[k].to_native_range((x - r).max(0.0), (x + r).min(1.0))
    };
    let side = brep
        .region(h.face)
        .classify_box(around(0, speed(&jet.s)), around(1, speed(&jet.t)));
    side != BoxSide::Inside
}

/// Whether the line passes an edge within the width of its crack where it hits no face.
fn passes_crack(brep: &PreparedBrep, stab: &Stabber, hits: &[RawHit]) -> bool {
    if brep.widest_crack() == 0.0 || !brep.brep().is_closed() {
        return false;
    }
    let touched = hits.iter().any(|h| close_to_border(brep, h));
    let mut budget = PARITY_BUDGET;
    !touched
        && (0..brep.brep().faces().len()).any(|f| near_boundary(brep, stab, f, 0.0, &mut budget))
}

fn dress(brep: &PreparedBrep, stab: &Stabber, h: &RawHit) -> Option<Hit> {
    let geometry = brep.double_double(h.face);
    let patch = &geometry.patches[h.patch];
    let jet = patch.net.jet(ball(h.local[0]), ball(h.local[1]));
    let w = jet.value[3];
    let point = Point3::from(Vector3::from_fn(|c, _| {
        (jet.value[c] / w + Ball::exact(patch.net.origin[c])).mid.hi
    }));
    let along = |d: &[Ball<Dd>; 4]| -> Vector3<f64> {
        Vector3::from_fn(|c, _| ((d[c] - d[3] * (jet.value[c] / w)) / w).mid.hi)
    };
    let mut normal = along(&jet.s).cross(&along(&jet.t));
    if brep.brep().faces()[h.face].reversed {
        normal = -normal;
    }
    let norm = normal.norm();
    let bounds = Enclosure {
        lo: h.t.lower().max(stab.range[0]),
        hi: h.t.upper().min(stab.range[1]),
    };
    Some(Hit {
        t: Separation {
            value: h.t.mid.hi.clamp(bounds.lo.min(bounds.hi), bounds.hi),
            bounds,
        },
        t_end: None,
        point,
        normal: if norm > 0.0 { normal / norm } else { normal },
        feature: Feature::Face(h.face),
        face: h.face,
        uv: Point2::new(
            patch.maps[0].to_native(h.local[0].hi),
            patch.maps[1].to_native(h.local[1].hi),
        ),
        tangential: false,
    })
}
