//! Zeros that lie on a border of a patch exactly.
//!
//! # What is proven
//! No enclosure tells that a zero is on a border. But where one of the forms of the line vanishes on all of the border, exactly (the border's
//! curve is in one of the two planes through the line: that of a seam of a revolution, say), and the other changes its sign along the part of
//! the border that is in a zone with one zero only, then that zero is on the border.

use super::forms::Stabber;
use crate::numeric::{Ball, Dd, Dyadic};
use crate::prepare::Net;

/// Whether the zero in a zone is on a border of the patch: across the first or the second coordinate, the upper one or the lower.
pub(super) fn holds_zero(
    stab: &Stabber,
    net: &Net<Dd>,
    across: usize,
    upper: bool,
    zone: [[f64; 2]; 2],
) -> bool {
    let Some(flat) = (0..2).find(|k| vanishes(stab, net, across, upper, *k) == Some(true)) else {
        return false;
    };
    let offsets = [0, 1].map(|k| stab.offset(k, &net.origin));
    let place = Ball::exact(if upper { 1.0 } else { 0.0 });
    let [low, high] = zone[1 - across].map(|x| {
        let along = Ball::exact(x.clamp(0.0, 1.0));
        let [s, t] = if across == 0 {
            [place, along]
        } else {
            [along, place]
        };
        stab.apply(&net.jet(s, t).value, &offsets)[1 - flat]
    });
    let negative = |x: Ball<Dd>| x.upper() < 0.0;
    let positive = |x: Ball<Dd>| x.is_above(0.0);
    negative(low) && positive(high) || positive(low) && negative(high)
}

/// Whether a form is zero on all of a border; `None` where its points are not known exactly.
fn vanishes(
    stab: &Stabber,
    net: &Net<Dd>,
    across: usize,
    upper: bool,
    form: usize,
) -> Option<bool> {
    let normal = &stab.normals[form];
    let mut offset = Dyadic::ZERO;
    let number = Dyadic::from_f64;
    for c in 0..3 {
        let off = &number(net.origin[c])? - &number(stab.origin[c])?;
        offset = &offset + &(&number(normal[c])? * &off);
    }
    let (rows, width) = (net.degree.u + 1, net.degree.v + 1);
    let count = if across == 0 { width } else { rows };
    for i in 0..count {
        let index = match (across, upper) {
            (0, false) => i,
            (0, true) => (rows - 1) * width + i,
            (_, false) => i * width,
            (_, true) => i * width + width - 1,
        };
        let exact = net.points[index].map(|x| {
            let known = x.rad == 0.0;
            known.then_some(&number(x.mid.hi)? + &number(x.mid.lo)?)
        });
        let [x, y, z, w] = exact;
        let mut value = &offset * &w?;
        for (n, x) in normal.iter().zip([x?, y?, z?]) {
            value = &value + &(&number(*n)? * &x);
        }
        if value.signum() != 0 {
            return Some(false);
        }
    }
    Some(true)
}
