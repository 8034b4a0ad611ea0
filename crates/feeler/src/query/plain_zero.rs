//! The zero of a line's two forms well inside of a box, where a look at the whole box tells that there is one at most.
//!
//! # What is proven
//! As in the module `certify`, with the box itself for the zone: `K = Y L` with `|I - K'| <= e < 1` on it, so there is one zero within `rho = |K(x)| /
//! (1 - e)` of a point `x` of the box if that ball lies in it, and no other in the box. In f64 `L(x)` comes from the forms' coefficients over
//! the box: off by their own error and by what the module `jet` says of a value. Where `x` is on the patch is rounded once more.
//!
//! The line's parameter at a point of space next to it is its height over the origin along the longest coordinate of the direction, over that coordinate. It is
//! taken at `x`; the patch's point at the zero is off that at `x` by no more than `rho` in each parameter times the point's
//! greatest speed along it (`Net::speeds`), and the parameter by no more than that over the coordinate. Where that bound is wide, it is none to be had here.

use super::certify::{
    EXTENSION, Found, NEWTON_STEPS, POLISHED, POLISHING_STEPS, SETTLED, Sample, Solved, WIDE, Zone,
    forms_at, moved,
};
use super::forms::{Contraction, Forms, Pair, Stabber, range};
use super::zeros::{Digits, HitAt, Place, RawHit};
use crate::numeric::bernstein::largest;
use crate::numeric::{Ball, Dd, Real};
use crate::prepare::{Net, PreparedBrep, jet};

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// Coefficients that are kept without a list: those of a bicubic patch.
const ROOM: usize = 16;

/// What a look at a whole patch tells.
pub(super) enum Whole {
    /// The line misses it.
    Missed,
    /// There is one zero: the hit, local parameters and how far it is from there at most. Whether it is in the region is not looked at.
    Hit(RawHit, [Dd; 2], f64),
    /// Nothing.
    Open,
}

/// The zero of a patch that a look at all of it tells.
pub(super) fn whole_patch(
    brep: &PreparedBrep,
    stab: &Stabber,
    at: (usize, usize),
    net: &Net<f64>,
    digits: Digits,
) -> Whole {
    let count = net.points.len();
    if count > ROOM || net.degree.v == 0 || !jet::fits(net.degree) {
        return Whole::Open;
    }
    let (mut c, mut error) = ([[0.0; ROOM]; 2], [0.0; 2]);
    for k in 0..2 {
        let (values, own) = stab.plane(net, k, stab.offset(k, &net.origin));
        c[k].iter_mut()
            .zip(values)
            .for_each(|(x, value)| *x = value);
        error[k] = own;
        let r = range(&c[k][..count], own);
        if r[0] > 0.0 || r[1] < 0.0 {
            return Whole::Missed;
        }
    }
    let pair = Pair {
        degree: net.degree,
        c: [&c[0][..count], &c[1][..count]],
        error,
    };
    let mut turned = [[0.0; ROOM]; 2];
    let [first, second] = &mut turned;
    let look = pair.look(
        &pair.slopes().0,
        [&mut first[..count], &mut second[..count]],
    );
    if look.none {
        return Whole::Missed;
    }
    let Some(one) = look.one_at_most else {
        return Whole::Open;
    };
    match zero_in(brep, stab, at, digits, &pair, [[0.0, 1.0]; 2], &one) {
        Told::Zero((hit, local, rho)) => Whole::Hit(hit, local, rho),
        Told::Out | Told::Open => Whole::Open,
    }
}

/// What is told of the zero of a box.
pub(super) enum Told<T> {
    Zero(T),
    /// If there is one, it is hardly in the box.
    Out,
    /// Nothing.
    Open,
}

/// The zero in a box of a patch, if it is well inside, and the forms are of f64.
pub(super) fn plainly<T: Real>(
    brep: &PreparedBrep,
    stab: &Stabber,
    at: &Place<T>,
    node: &Forms<T>,
    one: &Contraction,
) -> Told<(Option<Found>, Solved)> {
    let count = node.c[0].len();
    if T::UNIT < f64::UNIT || count > ROOM || node.degree.v == 0 || !jet::fits(node.degree) {
        return Told::Open;
    }
    let mut c = [[0.0; ROOM]; 2];
    for k in 0..2 {
        let values = c[k].iter_mut().zip(&node.c[k]);
        values.for_each(|(x, value)| *x = value.approximate());
    }
    let pair = Pair {
        degree: node.degree,
        c: [&c[0][..count], &c[1][..count]],
        error: [node.error[0], node.error[1]],
    };
    let (u, v) = (node.u, node.v);
    match zero_in(
        brep,
        stab,
        (at.face, at.patch),
        at.digits,
        &pair,
        [u, v],
        one,
    ) {
        Told::Zero((hit, local, rho)) => {
            Told::Zero((Some((hit, local, rho, None)), Solved { u, v }))
        }
        Told::Out => Told::Out,
        Told::Open => Told::Open,
    }
}

/// A certified zero: the hit, its local parameters, and how far it is from there at most.
type Zero = (RawHit, [Dd; 2], f64);

/// A zero in a box: where Newton's method ends, in coordinates that run over the box from 0 to 1, how far the zero is from there at most, and
/// the inverse of the Jacobian there.
struct Near {
    x: [f64; 2],
    rho: f64,
    inverse: [[f64; 2]; 2],
}

/// Where Newton's method takes the middle of a box.
enum Led {
    Inside(Near),
    /// Plainly out of the box, or off the patch: what the box holds halves of it tell.
    Out,
    /// Next to its border, or nowhere.
    Open,
}

/// Newton's method is followed this far out of the box, in its widths; a place as far out is plainly out.
const OUT: f64 = 0.25;

fn newton(pair: &Pair<f64>, one: &Contraction, node: [[f64; 2]; 2]) -> Led {
    let mut pairs = [[0.0; 2]; ROOM];
    for (i, both) in pairs.iter_mut().enumerate().take(pair.c[0].len()) {
        *both = [pair.c[0][i], pair.c[1][i]];
    }
    let pairs = &pairs[..pair.c[0].len()];
    let (mut x, mut last) = ([0.5; 2], f64::INFINITY);
    for _ in 0..NEWTON_STEPS {
        let [l, ls, lt] = jet::pair_jet1(pairs, pair.degree, x[0], x[1]);
        let det = ls[0] * lt[1] - lt[0] * ls[1];
        if det == 0.0 || !det.is_finite() {
            return Led::Open;
        }
        let over = 1.0 / det;
        let inverse = [[lt[1] * over, -lt[0] * over], [-ls[1] * over, ls[0] * over]];
        let step = inverse.map(|row| row[0] * l[0] + row[1] * l[1]);
        let moved = step[0].abs().max(step[1].abs());
        // In the end rounding moves it to and fro.
        if moved <= f64::EPSILON || (moved < SETTLED && moved >= 0.5 * last) {
            let rho = radius(pair, one, l);
            let inside = |x: f64| x > rho * UP && 1.0 - x > rho * UP;
            let off_patch = |k: usize| {
                let at = node[k][0] + x[k] * (node[k][1] - node[k][0]);
                !(-EXTENSION..=1.0 + EXTENSION).contains(&at)
            };
            return if inside(x[0]) && inside(x[1]) {
                Led::Inside(Near { x, rho, inverse })
            } else if off_patch(0) || off_patch(1) {
                Led::Out
            } else {
                Led::Open
            };
        }
        for k in 0..2 {
            x[k] -= step[k];
        }
        if x.iter().any(|x| !(-OUT..=1.0 + OUT).contains(x)) {
            return Led::Out;
        }
        last = moved;
    }
    Led::Open
}

/// `|K(x)| / (1 - e)` from above, given the computed `L(x)`.
fn radius(pair: &Pair<f64>, one: &Contraction, l: [f64; 2]) -> f64 {
    let units = jet::pair_error(pair.degree);
    let off = [0, 1].map(|k| units * largest(pair.c[k]) + pair.error[k]);
    let mut residual: f64 = 0.0;
    for row in &one.y {
        let (a, b) = (row[0] * l[0], row[1] * l[1]);
        let rounded = 4.0 * f64::UNIT * (a.abs() + b.abs());
        let inherited = row[0].abs() * off[0] + row[1].abs() * off[1];
        residual = residual.max((a + b).abs() + rounded + inherited);
    }
    residual / (1.0 - one.e) * UP / (1.0 - f64::EPSILON)
}

fn zero_in(
    brep: &PreparedBrep,
    stab: &Stabber,
    at: (usize, usize),
    digits: Digits,
    pair: &Pair<f64>,
    node: [[f64; 2]; 2],
    one: &Contraction,
) -> Told<Zero> {
    let near = match newton(pair, one, node) {
        Led::Inside(near) => near,
        Led::Out => return Told::Out,
        Led::Open => return Told::Open,
    };
    proven(brep, stab, at, digits, node, one, &near).map_or(Told::Open, Told::Zero)
}

fn proven(
    brep: &PreparedBrep,
    stab: &Stabber,
    (face, patch): (usize, usize),
    digits: Digits,
    node: [[f64; 2]; 2],
    one: &Contraction,
    near: &Near,
) -> Option<Zero> {
    let widths = node.map(|r| r[1] - r[0]);
    let local = [0, 1].map(|k| node[k][0] + near.x[k] * widths[k]);
    let geometry = brep.double(face);
    let (local, off, point, t) = match digits {
        Digits::Double => {
            // Two roundings of numbers up to one, of which a whole patch has none.
            let rounded = if node == [[0.0, 1.0]; 2] {
                0.0
            } else {
                f64::EPSILON
            };
            let off = widths.map(|w| (near.rho * w + rounded) * UP);
            if !(0..2).all(|k| off[k] < local[k] && local[k] + off[k] < 1.0 - f64::EPSILON) {
                return None;
            }
            let net = &geometry.patches[patch].net;
            let value = jet::point(net, local[0], local[1]);
            let axis = stab.axis;
            let shift = Ball::<f64>::difference(net.origin[axis], stab.origin[axis]);
            let t = (value[axis] / value[3] + shift) / Ball::exact(stab.direction[axis]);
            let point = [0, 1, 2].map(|c| value[c].mid / value[3].mid + net.origin[c]);
            (local.map(Dd::from), off, point, t.to_dd())
        }
        Digits::All => {
            let fine = &brep.double_double(face).patches[patch].net;
            let offsets = [0, 1].map(|k| stab.offset(k, &fine.origin));
            let inverse = [0, 1].map(|k| near.inverse[k].map(|x| x * widths[k]));
            let (p, sample) = polished(stab, fine, &offsets, local, inverse)?;
            let zone = Zone {
                u: node[0],
                v: node[1],
                scaled: one.y,
                e: one.e,
            };
            let rho = zone.radius(p, &sample)?;
            let off = widths.map(|w| rho * w * UP);
            let t = stab.parameter(&sample.value, &sample.origin);
            let point = [0, 1, 2].map(|c| {
                let x = sample.value[c] / sample.value[3] + Ball::exact(sample.origin[c]);
                x.mid.hi
            });
            (p, off, point, t)
        }
    };
    let moved = moved(brep, stab, (face, patch), off);
    if !(t.rad.is_finite() && moved <= WIDE * t.rad) {
        return None;
    }
    let t = Ball {
        mid: t.mid,
        rad: (t.rad + moved) * UP,
    };
    let rho = off[0].max(off[1]);
    let hit = RawHit {
        face,
        at: HitAt::Patch {
            patch,
            local,
            rho,
            point,
        },
        t,
        inside: true,
        at_joint: false,
        touches: false,
        exact: None,
    };
    Some((hit, local, rho))
}

/// The zero next to a place to the digits of double-double, and the forms there.
fn polished(
    stab: &Stabber,
    net: &Net<Dd>,
    offsets: &[Ball<Dd>; 2],
    start: [f64; 2],
    inverse: [[f64; 2]; 2],
) -> Option<([Dd; 2], Sample)> {
    let mut p = start.map(Dd::from);
    for _ in 0..=POLISHING_STEPS {
        let (value, l) = forms_at(stab, net, offsets, p);
        let step: [Dd; 2] = std::array::from_fn(|k| {
            Dd::from(inverse[k][0]) * l[0].mid + Dd::from(inverse[k][1]) * l[1].mid
        });
        let moved = step[0].hi.abs().max(step[1].hi.abs());
        if moved <= POLISHED {
            let origin = net.origin;
            return Some((p, Sample { value, l, origin }));
        }
        if !(moved < SETTLED) {
            return None;
        }
        p = [0, 1].map(|k| p[k] - step[k]);
    }
    None
}
