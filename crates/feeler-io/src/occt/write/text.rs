//! Forms as the file has them: the counterpart of what `curves`, `surfaces` and `splines` read. Numbers are the shortest that
//! give the same f64 back.

use super::super::curves::{Form, Frame};
use super::super::splines::Knots;
use super::super::surfaces::{Axes, Form3};
use super::Problem;
use nalgebra::{Point, SVector};
use std::fmt::Write;

/// A number and a space.
pub(super) fn number(out: &mut String, x: f64) {
    // Writing to a string does not fail.
    let _ = write!(out, "{x:?} ");
}

pub(super) fn numbers<'a>(out: &mut String, all: impl IntoIterator<Item = &'a f64>) {
    all.into_iter().for_each(|x| number(out, *x));
}

/// Integers and flags, each with a space.
pub(super) fn integers(out: &mut String, all: impl IntoIterator<Item = usize>) {
    for i in all {
        let _ = write!(out, "{i} ");
    }
}

fn point<const D: usize>(out: &mut String, p: &Point<f64, D>) {
    numbers(out, p.coords.as_slice());
}

fn frame<const D: usize>(out: &mut String, f: &Frame<D>) {
    point(out, &f.center);
    if D == 3 {
        numbers(out, f.z.as_slice());
    }
    numbers(out, f.x.as_slice());
    numbers(out, f.y.as_slice());
}

/// How far each way a number is looked for whose product or sum rounds to what is wanted.
const NEIGHBOURS: usize = 4;

/// A number and its neighbours, nearest first.
pub(super) fn near(x: f64) -> impl Iterator<Item = f64> + Clone {
    let ways = std::iter::successors(Some((x, x)), |(up, down)| {
        Some((up.next_up(), down.next_down()))
    });
    ways.take(NEIGHBOURS + 1)
        .enumerate()
        .flat_map(|(i, (up, down))| [Some(up), (i > 0).then_some(down)])
        .flatten()
}

/// The number that times the weight is `wx` when rounded; where there is none, one beside it.
fn without_weight(wx: f64, w: f64) -> f64 {
    let x = wx / w;
    near(x).find(|x| x * w == wx).unwrap_or(x)
}

/// What comes back of a control point that is written.
pub(super) fn read_again<const H: usize>(p: &SVector<f64, H>) -> SVector<f64, H> {
    let w = p[H - 1];
    let mut again = *p;
    if w != 1.0 {
        for c in 0..H - 1 {
            again[c] = without_weight(p[c], w) * w;
        }
    }
    again
}

/// How far control points of a curve come back from where they were.
pub(super) fn off_by_weights<const D: usize, const H: usize>(form: &Form<D, H>) -> f64 {
    let Form::Spline(_, points) = form else {
        return 0.0;
    };
    let off = points.iter().map(|p| (read_again(p) - p).amax() / p[H - 1]);
    off.fold(0.0, f64::max)
}

fn control_points<const H: usize>(out: &mut String, points: &[SVector<f64, H>], rational: bool) {
    for p in points {
        let w = p[H - 1];
        for c in 0..H - 1 {
            let x = if rational {
                without_weight(p[c], w)
            } else {
                p[c]
            };
            number(out, x);
        }
        if rational {
            number(out, w);
        }
    }
    out.push('\n');
}

fn knots(out: &mut String, knots: &Knots) {
    for (knot, multiplicity) in knots.distinct() {
        number(out, *knot);
        integers(out, [*multiplicity]);
    }
    out.push('\n');
}

fn is_rational<const H: usize>(points: &[SVector<f64, H>]) -> bool {
    points.iter().any(|p| p[H - 1] != 1.0)
}

/// What the writer makes no form of: it would be left out in silence.
fn offset() -> Problem {
    Problem::new("an offset curve or surface is not written; convert it to NURBS first")
}

pub(super) fn curve<const D: usize, const H: usize>(
    out: &mut String,
    form: &Form<D, H>,
) -> Result<(), Problem> {
    match form {
        Form::Line { from, direction } => {
            out.push_str("1 ");
            point(out, from);
            numbers(out, direction.as_slice());
        }
        Form::Circle(f, radius) => {
            out.push_str("2 ");
            frame(out, f);
            number(out, *radius);
        }
        Form::Ellipse(f, radii) => {
            out.push_str("3 ");
            frame(out, f);
            numbers(out, radii);
        }
        Form::Parabola(f, focal) => {
            out.push_str("4 ");
            frame(out, f);
            number(out, *focal);
        }
        Form::Hyperbola(f, radii) => {
            out.push_str("5 ");
            frame(out, f);
            numbers(out, radii);
        }
        Form::Spline(k, points) => {
            let rational = is_rational(points);
            out.push_str("7 ");
            let distinct = k.distinct().len();
            integers(
                out,
                [rational.into(), 0, k.degree, k.control_points, distinct],
            );
            control_points(out, points, rational);
            knots(out, k);
            return Ok(());
        }
        Form::Trimmed(range, basis) => {
            out.push_str("8 ");
            numbers(out, range);
            out.push('\n');
            return curve(out, basis);
        }
        Form::Offset => return Err(offset()),
    }
    out.push('\n');
    Ok(())
}

fn axes(out: &mut String, a: &Axes) {
    point(out, &a.origin);
    for v in [a.z, a.x, a.y] {
        numbers(out, v.as_slice());
    }
}

pub(super) fn surface(out: &mut String, form: &Form3) -> Result<(), Problem> {
    match form {
        Form3::Plane(a) => {
            out.push_str("1 ");
            axes(out, a);
        }
        Form3::Cylinder(a, radius) => {
            out.push_str("2 ");
            axes(out, a);
            number(out, *radius);
        }
        Form3::Cone(a, radius, half) => {
            out.push_str("3 ");
            axes(out, a);
            numbers(out, &[*radius, *half]);
        }
        Form3::Sphere(a, radius) => {
            out.push_str("4 ");
            axes(out, a);
            number(out, *radius);
        }
        Form3::Torus(a, radii) => {
            out.push_str("5 ");
            axes(out, a);
            numbers(out, radii);
        }
        Form3::Extrusion(direction, profile) => {
            out.push_str("6 ");
            numbers(out, direction.as_slice());
            out.push('\n');
            return curve(out, profile);
        }
        Form3::Revolution(origin, axis, profile) => {
            out.push_str("7 ");
            point(out, origin);
            numbers(out, axis.as_slice());
            out.push('\n');
            return curve(out, profile);
        }
        Form3::Spline(k, net) => {
            let rational = usize::from(is_rational(net));
            out.push_str("9 ");
            integers(out, [rational, rational, 0, 0]);
            integers(out, k.iter().map(|k| k.degree));
            integers(out, k.iter().map(|k| k.control_points));
            integers(out, k.iter().map(|k| k.distinct().len()));
            control_points(out, net, rational == 1);
            k.iter().for_each(|k| knots(out, k));
            return Ok(());
        }
        Form3::Trimmed(ranges, basis) => {
            out.push_str("10 ");
            numbers(out, ranges.as_flattened());
            out.push('\n');
            return surface(out, basis);
        }
        Form3::Offset => return Err(offset()),
    }
    out.push('\n');
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_written_says_so() {
        let mut out = String::new();
        let trimmed = Form::<2, 3>::Trimmed([0.0, 1.0], Box::new(Form::Offset));
        assert!(curve(&mut out, &trimmed).is_err());
        let trimmed = Form3::Trimmed([[0.0, 1.0]; 2], Box::new(Form3::Offset));
        assert!(surface(&mut out, &trimmed).is_err());
    }
}
