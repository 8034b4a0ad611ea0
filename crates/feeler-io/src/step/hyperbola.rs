//! Surfaces made of hyperbolas: the part of the curve that a body can hold, as a B-spline.
//!
//! A hyperbola has no end, and over a long range one rational quadratic of it has weights that grow with the exponential of its length. So it becomes
//! one quadratic between each two whole numbers of its parameter, exactly the curve's points, and so do the edges, whose quadratics then meet where the
//! surface's do: curves in uv bend there, and cubics fit between. They are made as on other surfaces.
//!
//! **How far.** `C(t) = c + x a cosh t + y b sinh t = c + (P e^t + M e^-t) / 2` with `P = a x + b y`, `M = a x - b y`. For `t >= 0` it is at least
//! `(|P| e^t - |M|) / 2 - |c|` long, so that beyond `t = ln((2 (r + |c|) + |M|) / |P|)` no point of it is within `r`; likewise below, with P and M
//! exchanged. A point of an extruded curve is within `r` only if what is left of `C(t)` across the direction is: there all three vectors are those
//! across. About an axis points keep their distance from each of its points `o`, here the one that the file names: a point within `r` of the origin is
//! within `r + |o|` of it, and `c` within `|c| + |o|`.

use super::entities::{form, shape, unsupported};
use crate::error::ReadError;
use crate::occt::curves::{Budget, Form, Frame};
use crate::occt::splines::Knots;
use crate::occt::surfaces::Form3;
use libm::{cosh, log, sinh};
use nalgebra::{Vector3, Vector4};

/// Parameters that are kept beyond what a body can hold: what roundings take.
const MARGIN: f64 = 0.25;
/// The farthest parameter: a direction that is an asymptote's up to rounding asks for more, as 2^-52 is `e^-36`; bodies and hyperbolas that are 8e13 apart
/// in size are no file's.
const MOST: f64 = 32.0;
/// No piece is shorter than this.
const LEAST: f64 = 1.0 / (1 << 20) as f64;

/// The surface, a hyperbola that it is made of as a B-spline as far as a body reaches of which no coordinate is larger than `size`.
pub(super) fn bounded(
    entity: u64,
    surface: Form3,
    size: f64,
    numbers: &mut Budget,
) -> Result<Form3, ReadError> {
    // Twice: edges may bulge beyond their vertices.
    let reach = 2.0 * 3.0_f64.sqrt() * size;
    Ok(match surface {
        Form3::Extrusion(direction, profile) => {
            let square = direction.norm_squared();
            let across = |v: Vector3<f64>| v - direction * (v.dot(&direction) / square);
            let own = spline(entity, *profile, reach, across, numbers)?;
            Form3::Extrusion(direction, Box::new(own))
        }
        Form3::Revolution(origin, axis, profile) => {
            let from = |v: Vector3<f64>| v;
            let reach = reach + 2.0 * origin.coords.norm();
            let own = spline(entity, *profile, reach, from, numbers)?;
            Form3::Revolution(origin, axis, Box::new(own))
        }
        other => other,
    })
}

fn spline(
    entity: u64,
    profile: Form<3, 4>,
    reach: f64,
    seen: impl Fn(Vector3<f64>) -> Vector3<f64>,
    numbers: &mut Budget,
) -> Result<Form<3, 4>, ReadError> {
    let Form::Hyperbola(frame, [a, b]) = profile else {
        return Ok(profile);
    };
    let (x, y) = (frame.x * a, frame.y * b);
    let [p, m] = [seen(x + y), seen(x - y)].map(|v| v.norm());
    let within = 2.0 * (reach + seen(frame.center.coords).norm());
    let end = |own: f64, other: f64| log((within + other) / own).max(0.0) + MARGIN;
    let (start, end) = (-end(m, p), end(p, m));
    if !(-MOST <= start && end <= MOST) {
        return Err(unsupported(
            entity,
            "a surface made of a hyperbola that is extruded along its asymptote",
            super::geometry::nurbs_remedy(),
        ));
    }
    pieces(entity, &frame, [a, b], [start.floor(), end.ceil()], numbers)
}

/// A part of a hyperbola, one quadratic between each two whole numbers.
pub(super) fn pieces(
    entity: u64,
    frame: &Frame<3>,
    radii: [f64; 2],
    [start, end]: [f64; 2],
    numbers: &mut Budget,
) -> Result<Form<3, 4>, ReadError> {
    // A range of a surface is rounded to whole numbers.
    if !(-MOST - 1.0 <= start && end <= MOST + 1.0) {
        let what = format!("a hyperbola over [{start:?}, {end:?}], 1e13 times as large as it is");
        return Err(shape(entity, what));
    }
    let (x, y) = (frame.x * radii[0], frame.y * radii[1]);
    // A point where tangents meet has the weight w, and is written times it.
    let point = |t: f64, w: f64| -> Vector4<f64> {
        (frame.center.coords * w + x * cosh(t) + y * sinh(t)).push(w)
    };
    let mut points = vec![point(start, 1.0)];
    let mut knots = vec![(start, 3)];
    let mut r = start;
    while r < end {
        numbers.take(8).map_err(form(entity))?;
        let whole = (r + LEAST).floor() + 1.0;
        let (s, count) = if whole < end - LEAST {
            (whole, 2)
        } else {
            (end, 3)
        };
        points.push(point(0.5 * (r + s), cosh(0.5 * (s - r))));
        points.push(point(s, 1.0));
        knots.push((s, count));
        r = s;
    }
    let knots = Knots::new(2, false, points.len(), knots).map_err(form(entity))?;
    Ok(Form::Spline(knots, points))
}
