//! Zeros that lie on a border of a surface exactly.
//!
//! # What is proven
//! No enclosure tells that a zero is on a border. But where one of the forms of the line vanishes on all of the border, exactly, for it does on all of its control points (the border's
//! curve is in one of the two planes through the line: that of a seam of a revolution, say), and the other changes its sign along the part of
//! the border that is in a zone with one zero only, then that zero is on the border.
//!
//! A corner of a surface that is clamped in both coordinates is a control point: where both forms vanish on that, exactly, the corner is a zero, and the one in a zone that holds it.

use super::forms::Stabber;
use crate::numeric::{Ball, Dd, Dyadic};
use crate::nurbs::{NurbsSurface, Surface};
use crate::prepare::Net;
use nalgebra::Vector4;

/// Whether the zero in a zone of a patch is on a border of the surface that is one of the patch: across the first or the second coordinate, the
/// upper one or the lower.
pub(super) fn holds_zero(
    stab: &Stabber,
    surface: &Surface,
    net: &Net<Dd>,
    (across, upper): (usize, bool),
    zone: [[f64; 2]; 2],
) -> bool {
    let Surface::Nurbs(surface) = surface else {
        return false;
    };
    let flat = |k: &usize| vanishes(stab, surface, (across, upper), *k);
    let Some(flat) = (0..2).find(flat) else {
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

/// Whether a form is zero on all control points of a border of a surface, and these make the border.
pub(super) fn vanishes(
    stab: &Stabber,
    surface: &NurbsSurface,
    border: (usize, bool),
    form: usize,
) -> bool {
    has_sign(stab, surface, border, 0, form, |sign| sign == 0)
}

/// Whether the signs of a form on the control points of a border of a surface, or so many rows from there, are as wanted; the surface must be clamped across it.
pub(super) fn has_sign(
    stab: &Stabber,
    surface: &NurbsSurface,
    (across, upper): (usize, bool),
    inward: usize,
    form: usize,
    wanted: impl Fn(i32) -> bool,
) -> bool {
    let knots = if across == 0 {
        surface.knots_u()
    } else {
        surface.knots_v()
    };
    let Some(offset) = offset(stab, form).filter(|_| knots.is_clamped()) else {
        return false;
    };
    let [rows, width] = surface.counts();
    let count = if across == 0 { width } else { rows };
    (0..count).all(|i| {
        let index = match (across, upper) {
            (0, false) => inward * width + i,
            (0, true) => (rows - 1 - inward) * width + i,
            (_, false) => i * width + inward,
            (_, true) => i * width + width - 1 - inward,
        };
        sign(stab, form, &offset, &surface.control_net()[index]).is_some_and(&wanted)
    })
}

/// What a form is at the origin of space.
fn offset(stab: &Stabber, form: usize) -> Option<Dyadic> {
    let number = Dyadic::from_f64;
    (0..3).try_fold(Dyadic::ZERO, |sum, c| {
        let part = &number(stab.normals[form][c])? * &number(stab.origin[c])?;
        Some(&sum - &part)
    })
}

/// The sign of a form, given its offset, on a homogeneous point.
fn sign(stab: &Stabber, form: usize, offset: &Dyadic, point: &Vector4<f64>) -> Option<i32> {
    let number = Dyadic::from_f64;
    let start = offset * &number(point.w)?;
    let value = (0..3).try_fold(start, |sum, c| {
        let part = &number(stab.normals[form][c])? * &number(point[c])?;
        Some(&sum + &part)
    })?;
    Some(value.signum())
}

/// Whether a corner of a surface, at the upper ends of its coordinates or not, is in the line.
pub(super) fn corner_in_line(stab: &Stabber, surface: &Surface, upper: [bool; 2]) -> bool {
    let Surface::Nurbs(surface) = surface else {
        return false;
    };
    let [rows, width] = surface.counts();
    let row = if upper[0] { rows - 1 } else { 0 };
    let column = if upper[1] { width - 1 } else { 0 };
    let point = &surface.control_net()[row * width + column];
    let sign = |k: usize| sign(stab, k, &offset(stab, k)?, point);
    let clamped = surface.knots_u().is_clamped() && surface.knots_v().is_clamped();
    clamped && (0..2).all(|k| sign(k) == Some(0))
}
