//! Zeros of a line's two forms on a patch: found by Newton's method, then proven.
//!
//! # What is proven
//! One zero: let `K = Y L` with a constant matrix `Y` and `|I - K'| <= e < 1` (maximum norm) on a convex box. For two
//! points `K(x) - K(p) = M (x - p)` with `|I - M| <= e` (mean values), so `|x - p| <= |K(x) - K(p)| / (1 - e)`: there is at most
//! one zero, it is within `rho = |K(p)| / (1 - e)` of `p`, and if the ball of that radius lies in the box there
//! is one (Brouwer's theorem on `x -> x - K(x)`, which maps the ball into itself).

use super::forms::{Forms, Stabber, contraction, parameter_slope, restrict, restrict_roughly};
use super::hit_side::OnBorder;
use super::zeros::{Digits, HitAt, Place, RawHit};
use crate::numeric::{Ball, Dd, Real};
use crate::prepare::{Net, PreparedBrep, jet};

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// Steps of Newton's method.
pub(super) const NEWTON_STEPS: usize = 12;
/// Newton's method stays in here: zeros farther off the patch are of no use.
const REACH: [f64; 2] = [-0.5 * EXTENSION, 1.0 + 0.5 * EXTENSION];
/// Steps in double-double with the Jacobian in f64: each gains about 50 bits.
pub(super) const POLISHING_STEPS: usize = 3;

/// A box that holds one zero at most, which is known.
pub(super) struct Solved {
    pub(super) u: [f64; 2],
    pub(super) v: [f64; 2],
}

/// A certified zero, its local parameters and the bound on them, and the border of the surface that it is on, exactly.
pub(super) type Found = (RawHit, [Dd; 2], f64, Option<OnBorder>);

/// The point of a net at local parameters near the unit square, and `L_1`, `L_2` there, with bounds.
pub(super) fn forms_at(
    stab: &Stabber,
    net: &Net<Dd>,
    offsets: &[Ball<Dd>; 2],
    p: [Dd; 2],
) -> ([Ball<Dd>; 4], [Ball<Dd>; 2]) {
    let p = p.map(ball);
    let value = jet::fine_value(net, p).unwrap_or_else(|| net.jet(p[0], p[1]).value);
    (value, stab.apply(&value, offsets))
}

/// Near a zero: the point where Newton's method in f64 ends, and the inverse of the Jacobian there. No bound: what is made of it
/// is proven afterwards.
fn newton(
    stab: &Stabber,
    net: &Net<f64>,
    offsets: &[Ball<Dd>; 2],
    start: [f64; 2],
) -> Option<Near> {
    let offsets = offsets.map(|x| x.mid.hi);
    let apply = |h: &[f64; 4]| -> [f64; 2] {
        std::array::from_fn(|k| {
            let n = &stab.normals[k];
            n[0] * h[0] + n[1] * h[1] + n[2] * h[2] + offsets[k] * h[3]
        })
    };
    let (mut p, mut last) = (start, f64::INFINITY);
    let mut y = [[0.0; 2]; 2];
    let mut tangent = false;
    for _ in 0..NEWTON_STEPS {
        let h: [[f64; 4]; 3] = if jet::fits(net.degree) {
            jet::jet1(net, p[0], p[1])
        } else {
            let j = net.jet(Ball::exact(p[0]), Ball::exact(p[1]));
            [j.value, j.s, j.t].map(|v| v.map(|x| x.mid))
        };
        let [l, ls, lt] = h.map(|h| apply(&h));
        let det = ls[0] * lt[1] - lt[0] * ls[1];
        if det == 0.0 || !det.is_finite() {
            return None;
        }
        y = [[lt[1] / det, -lt[0] / det], [-ls[1] / det, ls[0] / det]];
        let size = (ls[0].abs() + lt[0].abs()) * (ls[1].abs() + lt[1].abs());
        tangent = det.abs() < TANGENT * size;
        let mut moved: f64 = 0.0;
        for k in 0..2 {
            let step = y[k][0] * l[0] + y[k][1] * l[1];
            p[k] = (p[k] - step).clamp(REACH[0], REACH[1]);
            moved = moved.max(step.abs());
        }
        // In the end rounding moves it to and fro.
        if moved <= f64::EPSILON || (moved < SETTLED && moved >= 0.5 * last) {
            break;
        }
        last = moved;
    }
    Some(Near { p, y, tangent })
}

/// Where Newton's method ended, the inverse of the Jacobian there, and whether the line is near to tangent, so that f64 does not tell
/// either well.
struct Near {
    p: [f64; 2],
    y: [[f64; 2]; 2],
    tangent: bool,
}

/// A Jacobian whose determinant is below this part of its products.
const TANGENT: f64 = 1.0 / (1u64 << 20) as f64;

/// A step below this, in local parameters, is not worth taking: 2^-96 of the size is what full accuracy asks for.
pub(super) const POLISHED: f64 = 1.0 / (1u128 << 102) as f64;

/// Whether a point is farther from a node than half its width.
fn is_apart<T>(p: [f64; 2], node: &Forms<T>) -> bool {
    let apart = |x: f64, r: [f64; 2]| (r[0] - x).max(x - r[1]).max(0.0) / (r[1] - r[0]);
    apart(p[0], node.u) > 0.5 || apart(p[1], node.v) > 0.5
}

/// Steps below this are near rounding.
pub(super) const SETTLED: f64 = 1.0 / (1u64 << 32) as f64;

/// The same in double-double throughout, for lines next to tangent: the Jacobian in f64 is then not near enough to the true one.
fn newton_fine(
    stab: &Stabber,
    net: &Net<Dd>,
    offsets: &[Ball<Dd>; 2],
    start: [f64; 2],
) -> Option<([Dd; 2], [[f64; 2]; 2])> {
    let (mut p, mut last) = (start.map(Dd::from), f64::INFINITY);
    let mut y = [[0.0; 2]; 2];
    for _ in 0..NEWTON_STEPS {
        let jet = net.jet(ball(p[0]), ball(p[1]));
        let l = stab.apply(&jet.value, offsets);
        let (ls, lt) = (stab.apply(&jet.s, offsets), stab.apply(&jet.t, offsets));
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
            p[k] = if next.hi < REACH[0] {
                Dd::from(REACH[0])
            } else if next.hi > REACH[1] {
                Dd::from(REACH[1])
            } else {
                next
            };
            moved = moved.max(step.abs());
        }
        // In the end rounding moves it to and fro.
        if moved < f64::EPSILON * f64::EPSILON || (moved < f64::EPSILON && moved >= 0.5 * last) {
            break;
        }
        last = moved;
    }
    Some((p, y))
}

/// The point and `L_1`, `L_2` at a place of a patch, with bounds.
pub(super) struct Sample {
    pub(super) value: [Ball<Dd>; 4],
    pub(super) l: [Ball<Dd>; 2],
    /// What the point is relative to: each arithmetic's net has its own.
    pub(super) origin: [f64; 3],
}

/// The zero near a node, and a box about it in which it is the only one.
pub(super) fn certify<T: Real>(
    brep: &PreparedBrep,
    stab: &Stabber,
    at: &Place<T>,
    node: &Forms<T>,
) -> Option<(Option<Found>, Solved)> {
    let (face, patch) = (at.face, at.patch);
    let middle = [node.u, node.v].map(|r| 0.5 * (r[0] + r[1]));
    let coarse = &brep.double(face).patches[patch].net;
    let offsets = |origin: &[f64; 3]| [0, 1].map(|k| stab.offset(k, origin));
    let near = newton(stab, coarse, &offsets(&coarse.origin), middle);
    // What f64 does not tell about a line near to tangent, and what it left open, is looked at more finely below.
    let last = T::UNIT >= f64::UNIT && near.as_ref().is_some_and(|n| !n.tangent);
    // Held back at the end of what is looked at, it is not at a zero.
    let held = |p: &[f64; 2]| p.iter().any(|x| *x <= REACH[0] || *x >= REACH[1]);
    let zone = near.as_ref().and_then(|n| Zone::new(at, node, n.p, n.y));
    if last && (zone.is_none() || near.as_ref().is_some_and(|n| held(&n.p))) {
        return None;
    }
    let on_patch = |p: &[f64; 2]| p.iter().all(|x| (0.0..=1.0).contains(x));
    if at.digits == Digits::Double
        && jet::fits(coarse.degree)
        && let (Some(n), Some(zone)) = (&near, &zone)
        && on_patch(&n.p)
    {
        let [value, ..] = jet::jet(coarse, n.p[0], n.p[1]);
        let value = value.map(|x| Ball {
            mid: Dd::from(x.mid),
            rad: x.rad,
        });
        let sample = Sample {
            l: stab.apply(&value, &offsets(&coarse.origin)),
            value,
            origin: coarse.origin,
        };
        return prove(brep, stab, at, zone, n.p.map(Dd::from), &sample);
    }
    let fine = &brep.double_double(face).patches[patch].net;
    let offsets = offsets(&fine.origin);
    let sample_at = |p: [Dd; 2]| {
        let (value, l) = forms_at(stab, fine, &offsets, p);
        Sample {
            value,
            l,
            origin: fine.origin,
        }
    };
    if let (Some(n), Some(zone)) = (&near, &zone) {
        let mut p = n.p.map(Dd::from);
        for _ in 0..=POLISHING_STEPS {
            let sample = sample_at(p);
            let step: [Dd; 2] = std::array::from_fn(|k| {
                Dd::from(n.y[k][0]) * sample.l[0].mid + Dd::from(n.y[k][1]) * sample.l[1].mid
            });
            let moved = step[0].hi.abs().max(step[1].hi.abs());
            if moved <= POLISHED {
                let found = prove(brep, stab, at, zone, p, &sample);
                if last || found.is_some() {
                    return found;
                }
                break;
            }
            if !(moved < SETTLED) {
                break;
            }
            p = [0, 1].map(|k| p[k] - step[k]);
        }
    }
    let (p, y) = newton_fine(stab, fine, &offsets, middle)?;
    let zone = Zone::new(at, node, p.map(|x| x.hi), y)?;
    prove(brep, stab, at, &zone, p, &sample_at(p))
}

/// The zero near a place, on the patch or not: its local parameters, known within the radius, and what was said of the zone in
/// which it is the only one; `zone_at` makes this about the place where Newton's method ends, with the inverse of the Jacobian there.
pub(super) fn zero_near<R>(
    stab: &Stabber,
    at: &Place<Dd>,
    start: [f64; 2],
    zone_at: impl Fn([f64; 2], [[f64; 2]; 2]) -> Option<(Zone, R)>,
) -> Option<([Dd; 2], f64, R)> {
    let offsets = [0, 1].map(|k| stab.offset(k, &at.net.origin));
    let (p, y) = newton_fine(stab, at.net, &offsets, start)?;
    let (zone, said) = zone_at(p.map(|x| x.hi), y)?;
    let (value, l) = forms_at(stab, at.net, &offsets, p);
    let sample = Sample {
        value,
        l,
        origin: at.net.origin,
    };
    let widest = (zone.u[1] - zone.u[0]).max(zone.v[1] - zone.v[0]);
    let rho = zone.radius(p, &sample)? * widest * UP;
    Some((p, rho, said))
}

/// A zero of the forms: its local parameters, how far it can be from there in each, and a box about it in which it is the only one.
pub(super) struct KnownZero {
    pub(super) at: [Dd; 2],
    pub(super) reach: [Dd; 2],
    pub(super) zone: [[f64; 2]; 2],
}

/// The zero near the middle of a box, on the patch or not.
pub(super) fn known_zero(stab: &Stabber, at: &Place<Dd>, node: &Forms<Dd>) -> Option<KnownZero> {
    let offsets = [0, 1].map(|k| stab.offset(k, &at.net.origin));
    let middle = [node.u, node.v].map(|r| 0.5 * (r[0] + r[1]));
    let (p, y) = newton_fine(stab, at.net, &offsets, middle)?;
    let zone = Zone::new(at, node, p.map(|x| x.hi), y)?;
    let (value, l) = forms_at(stab, at.net, &offsets, p);
    let sample = Sample {
        value,
        l,
        origin: at.net.origin,
    };
    let rho = zone.radius(p, &sample)?;
    let reach = [zone.u, zone.v].map(|r| Dd::from(rho * (r[1] - r[0]) * UP));
    Some(KnownZero {
        at: p,
        reach,
        zone: [zone.u, zone.v],
    })
}

/// The parameter of the line at a zero that is known so, and the point, rounded; `None` where a weight may not be positive.
pub(super) fn parameter_at(
    stab: &Stabber,
    net: &Net<Dd>,
    KnownZero { at, reach, zone }: &KnownZero,
) -> Option<(Ball<Dd>, [f64; 3])> {
    let offsets = [0, 1].map(|k| stab.offset(k, &net.origin));
    let (value, _) = forms_at(stab, net, &offsets, *at);
    let t = stab.parameter(&value, &net.origin);
    // t moves with the point: bounded by the slopes over the zone, for coordinates that run over it from 0 to 1.
    let clock = restrict(&stab.clock(net), zone[0], zone[1]);
    let share = (0..2).map(|k| reach[k].hi / (zone[k][1] - zone[k][0]));
    let off = parameter_slope(&clock, stab, t.mid.hi) * share.fold(0.0, f64::max) * UP;
    let t = Ball {
        mid: t.mid,
        rad: (t.rad + off) * UP,
    };
    let point = [0, 1, 2].map(|c| {
        let x = value[c] / value[3] + Ball::exact(net.origin[c]);
        x.mid.hi
    });
    t.rad.is_finite().then_some((t, point))
}

/// A box in which there is one zero at most.
pub(super) struct Zone {
    pub(super) u: [f64; 2],
    pub(super) v: [f64; 2],
    /// `Y` for coordinates that run over it from 0 to 1.
    pub(super) scaled: [[f64; 2]; 2],
    /// The contraction there.
    pub(super) e: f64,
}

impl Zone {
    /// Twice a node's width about a point in it or not far from it (else another node will find the zero), within the
    /// extended patch. `y` is about the inverse of the Jacobian.
    fn new<T: Real>(at: &Place<T>, node: &Forms<T>, p: [f64; 2], y: [[f64; 2]; 2]) -> Option<Self> {
        if is_apart(p, node) {
            return None;
        }
        let around = |k: usize, r: [f64; 2]| {
            let h = r[1] - r[0];
            [(p[k] - h).max(-EXTENSION), (p[k] + h).min(1.0 + EXTENSION)]
        };
        Self::over(at, [around(0, node.u), around(1, node.v)], y)
    }

    /// The zone over a box within the extended patch.
    pub(super) fn over<T: Real>(
        at: &Place<T>,
        [u, v]: [[f64; 2]; 2],
        y: [[f64; 2]; 2],
    ) -> Option<Self> {
        let widths = [u[1] - u[0], v[1] - v[0]];
        let scaled = [0, 1].map(|k: usize| y[k].map(|x| x / widths[k]));
        let turned = |near: &Forms<T>| {
            let mut turned: [Vec<T>; 2] = Default::default();
            let errors = [0, 1].map(|k| near.combine(scaled[k], &mut turned[k]));
            (turned, errors)
        };
        let told = |turned: &[Vec<T>; 2], errors: [f64; 2]| {
            let [first, second] = turned;
            contraction([(first, errors[0]), (second, errors[1])], at.root.degree)
        };
        let (near, errors) = turned(&restrict_roughly(at.root, [u, v]));
        let mut e = told(&near, errors);
        if !(e < 1.0) && told(&near, [0.0; 2]) < 1.0 {
            // Weights of very different sizes leave few digits to be lost.
            let (near, errors) = turned(&restrict(at.root, u, v));
            e = told(&near, errors);
        }
        (e < 1.0).then_some(Self { u, v, scaled, e })
    }

    /// How far the zero is from a point at most, in widths of the zone; `None` where none is known to be there.
    pub(super) fn radius(&self, p: [Dd; 2], sample: &Sample) -> Option<f64> {
        let widths = [self.u[1] - self.u[0], self.v[1] - self.v[0]];
        let mut residual: f64 = 0.0;
        for row in &self.scaled {
            let k = Ball::exact(row[0]) * sample.l[0] + Ball::exact(row[1]) * sample.l[1];
            residual = residual.max(k.magnitude());
        }
        let rho = residual / (1.0 - self.e) * UP / (1.0 - f64::EPSILON);
        // A zero exists if its ball is in the zone.
        let reach = |k: usize| Dd::from(rho * widths[k] * UP);
        let exists = (0..2).all(|k| {
            let r = if k == 0 { self.u } else { self.v };
            (p[k] - reach(k)).hi > r[0] && (p[k] + reach(k)).hi < r[1]
        });
        exists.then_some(rho)
    }
}

/// How far the line's parameter at a point of a patch is from that at a point of it that is off by so much in each local parameter, at most:
/// the points are no farther apart than the patch's greatest speeds make them, and the parameter is a coordinate over that of the direction.
pub(super) fn moved(
    brep: &PreparedBrep,
    stab: &Stabber,
    (face, patch): (usize, usize),
    off: [f64; 2],
) -> f64 {
    let speeds = brep.double(face).patch_speeds(patch);
    (speeds[0] * off[0] + speeds[1] * off[1]) / stab.direction[stab.axis].abs() * UP
}

/// A bound that widens an enclosure of a parameter more than so many times is worth a better one: speeds say little of patches whose weights differ
/// by many powers of ten.
pub(super) const WIDE: f64 = 64.0;

/// That there is one zero near a point: see the module.
fn prove<T: Real>(
    brep: &PreparedBrep,
    stab: &Stabber,
    at: &Place<T>,
    zone: &Zone,
    p: [Dd; 2],
    sample: &Sample,
) -> Option<(Option<Found>, Solved)> {
    let (face, patch) = (at.face, at.patch);
    let &Zone { u, v, .. } = zone;
    let widths = [u[1] - u[0], v[1] - v[0]];
    let rho = zone.radius(p, sample)?;
    let local_rho = rho * widths[0].max(widths[1]) * UP;
    let reach = |k: usize| Dd::from(rho * widths[k] * UP);
    // It counts if it is on the patch. One that may be just beyond is settled with the next patch's: see the module `joints`.
    let off = |k: usize| p[k] + reach(k) < Dd::ZERO || p[k] - reach(k) > Dd::ONE;
    if off(0) || off(1) {
        return Some((None, Solved { u, v }));
    }
    // Within rounding of the border of the whole surface the hit cannot be settled, unless that is a seam: a joint as any other.
    let domain = brep.brep().surface(face).domain();
    let maps = &brep.double(face).patches[patch].maps;
    let (mut on_edge, mut at_joint, mut border) = (false, false, None);
    let mut ends = [None; 2];
    for k in 0..2 {
        let (low, high) = (p[k] - reach(k) <= Dd::ZERO, p[k] + reach(k) >= Dd::ONE);
        if !(low || high) {
            continue;
        }
        let of_surface =
            low && maps[k].start == domain[k].start || high && maps[k].end == domain[k].end;
        ends[k] = (of_surface && low != high).then_some(high);
        let exact = || {
            let net = &brep.double_double(face).patches[patch].net;
            let surface = brep.brep().surface(face);
            low != high && super::border::holds_zero(stab, surface, net, (k, high), [u, v])
        };
        if !of_surface {
            at_joint = true;
        } else if brep.meets_itself(face, k == 0) {
            at_joint = true;
            if exact() {
                border = Some(OnBorder::Seam(k));
            }
        } else if exact() {
            let end = if high { domain[k].end } else { domain[k].start };
            border = border.or(Some(OnBorder::End(k, end)));
        } else {
            on_edge = true;
        }
    }
    if let [Some(u), Some(v)] = ends
        && super::border::corner_in_line(stab, brep.brep().surface(face), [u, v])
    {
        let at = |k: usize, high: bool| if high { domain[k].end } else { domain[k].start };
        // Where both borders are seams the surface goes on on all sides: the line may touch a kink there.
        at_joint &= brep.meets_itself(face, true) && brep.meets_itself(face, false);
        on_edge = false;
        border = Some(OnBorder::Corner([at(0, u), at(1, v)]));
    }
    let t = stab.parameter(&sample.value, &sample.origin);
    // t moves with the point: on the patch by no more than this does, else it is bounded by the slopes over the zone.
    let on_patch = |k: usize| p[k] - reach(k) >= Dd::ZERO && p[k] + reach(k) <= Dd::ONE;
    let moved = if on_patch(0) && on_patch(1) {
        let off = widths.map(|w| rho * w * UP);
        moved(brep, stab, (face, patch), off)
    } else {
        f64::INFINITY
    };
    let reach = if moved <= WIDE * t.rad {
        moved
    } else {
        let clock = restrict(&stab.clock(at.net), u, v);
        let slope = parameter_slope(&clock, stab, t.mid.hi) * rho * UP;
        if slope <= moved { slope } else { moved }
    };
    let t = Ball {
        mid: t.mid,
        rad: (t.rad + reach) * UP,
    };
    let hit = RawHit {
        face,
        at: HitAt::Patch {
            patch,
            local: p,
            rho: local_rho,
            point: [0, 1, 2].map(|c| {
                let x = sample.value[c] / sample.value[3] + Ball::exact(sample.origin[c]);
                x.mid.hi
            }),
        },
        t,
        inside: !on_edge,
        at_joint,
        touches: false,
        exact: None,
    };
    Some((Some((hit, p, local_rho, border)), Solved { u, v }))
}

/// How far the polynomials of a patch are followed past its border, in local parameters.
pub(super) const EXTENSION: f64 = 1.0 / 1024.0;

fn ball(x: Dd) -> Ball<Dd> {
    Ball { mid: x, rad: 0.0 }
}
