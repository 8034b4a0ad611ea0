//! A place on a box on which `G` is strictly convex, from which a bound of the box follows for any centre: in plain f64, for boxes that are kept.
//!
//! # What is proven
//! The bound of [`Leaf`](super::leaf::Leaf), at a place `p` whose point `S`, tangents `S_k` and weight `w` are known, about a centre `c`: with `tau = f(p) = |S - c|^2`
//! and `G = N - tau C` it is `G(p) = 0` and `grad G(p) = C grad f = 2 w^2 (S - c).S_k`. If the Hessian of `G` is at least `lambda` on the box, and `free` is the
//! square of those components of the gradient that are not pinned (in coordinates that run over the box from 0 to 1),
//! ```text
//! f >= tau - free / (2 lambda min C).
//! ```
//! `lambda` comes from elsewhere, with some other tau: the difference counts (`convexity` there). Nothing is evaluated: the place hangs on
//! no centre, and a ball that has moved a little moves the bound by the square of its way along the surface.
//!
//! # Roundings
//! `S` is known within `off` in each coordinate, the tangents within `slope_off`; `r = S - c` is off by a rounding more. Below, `|r|_1` and `|t|_1` are sums of sizes. A
//! sum of three products of `r` and `t` is off by at most `|r|_1 slope_off + (|t|_1 + 3 slope_off) (off + eps |r|_1) + 4 eps |r|_1 |t|_1`, the sum of the squares of `r` by
//! `2 |r|_1 (off + eps |r|_1) + 4 eps |r|_1^2` and the square of what `r` is off.

use super::leaf::{Cell, convexity};
use super::shape::Shape;
use super::upper::{blocked, newton_step};
use crate::numeric::{Ball, TINY};
use crate::prepare::{Net, jet};
use nalgebra::Point3;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;

/// See the [module](self).
#[derive(Clone, Copy, Debug)]
pub(super) struct Foothold {
    /// Local parameters.
    pub(super) at: [f64; 2],
    point: [f64; 3],
    off: f64,
    tangents: [[f64; 3]; 2],
    slope_off: [f64; 2],
    /// `w^2` is at most this.
    weight: f64,
}

/// The middles of some numbers, and what they are known within.
fn parts(x: [Ball<f64>; 3]) -> ([f64; 3], f64) {
    let off = x[0].rad.max(x[1].rad).max(x[2].rad);
    // Negated: of what is no number nothing is known.
    let known = off >= 0.0 && x.iter().all(|x| x.rad <= off);
    let off = if known { off } else { f64::INFINITY };
    ([x[0].mid, x[1].mid, x[2].mid], off)
}

impl Foothold {
    /// On a net that [fits](jet::fits).
    pub(super) fn new(net: &Net<f64>, at: [f64; 2]) -> Self {
        let [value, s, t] = jet::jet(net, at[0], at[1]);
        let w = value[3];
        let unit = w.is_one();
        let over = |x: Ball<f64>| if unit { x } else { x / w };
        let [x, y, z, _] = value;
        let local = [over(x), over(y), over(z)];
        let tangent = |d: [Ball<f64>; 4]| {
            let along = |k: usize| match unit {
                true => d[k],
                false => over(d[k] - d[3] * local[k]),
            };
            parts([along(0), along(1), along(2)])
        };
        let moved = |k: usize| local[k] + Ball::exact(net.origin[k]);
        let (point, off) = parts([moved(0), moved(1), moved(2)]);
        let ((s, s_off), (t, t_off)) = (tangent(s), tangent(t));
        Self {
            at,
            point,
            off,
            tangents: [s, t],
            slope_off: [s_off, t_off],
            weight: w.square().magnitude(),
        }
    }

    /// A Newton step within the box, not damped, given about what the Hessian is there (in coordinates that run over the box). No proof rests on it.
    pub(super) fn step(&self, center: &Point3<f64>, cell: &Cell<f64>, bend: [f64; 3]) -> [f64; 2] {
        let ranges = [cell.u, cell.v];
        let widths = ranges.map(|r| r[1] - r[0]);
        let slope: [f64; 2] = std::array::from_fn(|k| {
            let dot: f64 = (0..3)
                .map(|c| (self.point[c] - center[c]) * self.tangents[k][c])
                .sum();
            2.0 * self.weight * dot * widths[k]
        });
        let step = newton_step(slope, bend, blocked(self.at, slope, ranges));
        std::array::from_fn(|k| {
            (self.at[k] + step[k] * widths[k]).clamp(ranges[k][0], ranges[k][1])
        })
    }

    /// No squared distance of a box that holds the place is less than this, given what is known of its shape with some tau. (It may be no number.)
    pub(super) fn least(
        &self,
        center: &Point3<f64>,
        cell: &Cell<f64>,
        (shape, shape_tau): (&Shape, f64),
    ) -> f64 {
        let r: [f64; 3] = std::array::from_fn(|k| self.point[k] - center[k]);
        let sum = |x: &[f64; 3]| x[0].abs() + x[1].abs() + x[2].abs();
        let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let size = sum(&r);
        let off = (self.off + f64::EPSILON * size) * UP;
        let value = dot(&r, &r);
        let value_off =
            (2.0 * size * off + 3.0 * off * off + 4.0 * f64::EPSILON * size * size + TINY) * UP;
        let tau_error = ((value - shape_tau).abs() + value_off) * UP;
        let lambda = convexity(shape, cell, tau_error);
        if !(lambda > 0.0 && shape.c_range[0] > 0.0) {
            return f64::NEG_INFINITY;
        }
        let mut drop = 0.0;
        for (k, range) in [cell.u, cell.v].into_iter().enumerate() {
            let width = range[1] - range[0];
            if width == 0.0 {
                continue;
            }
            let (t, slope_off) = (&self.tangents[k], self.slope_off[k]);
            let along = sum(t);
            let slope = dot(&r, t);
            let slope_off = (size * slope_off
                + (along + 3.0 * slope_off) * off
                + 4.0 * f64::EPSILON * size * along
                + TINY)
                * UP;
            let pinned = self.at[k] == range[0] && slope > slope_off
                || self.at[k] == range[1] && -slope > slope_off;
            if !pinned {
                let g = 2.0 * self.weight * (slope.abs() + slope_off) * width * UP;
                // Divided first: of small weights the squares underflow.
                drop += g * (g / (2.0 * lambda)) / shape.c_range[0] * UP;
            }
        }
        value - (value_off + drop + f64::EPSILON * value) * UP
    }
}

#[cfg(test)]
mod tests;
