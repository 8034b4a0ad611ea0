//! Images of straight lines of uv, each with the line's own parameter, up to rounding:
//! - along u or v of a NURBS surface: a row of control points once the surface is cut there; of a sum: one of its curves, moved; of a revolution: a
//!   circle, or the profile turned;
//! - across a NURBS surface: in each of the rectangles that the knots cut the line into, it is a diagonal, so that the image is of the degree of
//!   u and v together, and its control points are means of those of the rectangle: with `i + j = k`, the binomials
//!   `C(p, i) C(q, j) / C(p + q, k)` sum up to 1.
//!
//! Lines that leave the surface's domain have none: a point outside counts as the nearest one inside.

use crate::affine::Affine;
use feeler::numeric::{Interval, sin_cos};
use feeler::nurbs::{
    Arc, Curve, Curve3, Line, NurbsCurve, NurbsSurface, PolyCurve, Polyline, Revolution, Sum,
    Surface,
};
use nalgebra::{Matrix3, Point2, Vector3, Vector4};

/// Control points of surfaces that may be gone through for one curve, for each byte of what says it: a file of a megabyte takes seconds at most, and a
/// line across a net of 200 x 200 has room.
const STEPS_A_BYTE: usize = 32;

/// What the lines of one curve may take together: a file that lists few numbers may ask for very many.
pub(super) struct Room {
    steps: usize,
    points: usize,
}

impl Room {
    /// For a curve that a file says in so many bytes: control points of the image take up to some times as many.
    pub(super) fn new(bytes: usize) -> Self {
        Self {
            steps: bytes.saturating_mul(STEPS_A_BYTE),
            points: bytes / 4,
        }
    }

    fn take(&mut self, steps: usize, points: usize) -> Option<()> {
        self.steps = self.steps.checked_sub(steps)?;
        self.points = self.points.checked_sub(points)?;
        Some(())
    }
}

/// How many points a curve has.
fn count(curve: &Curve3) -> usize {
    match curve {
        Curve::Line(_) | Curve::Arc(_) => 2,
        Curve::Polyline(p) => p.points().len(),
        Curve::Nurbs(n) => n.control_points().len(),
        // Segments are never poly-curves themselves.
        Curve::Poly(p) => p.segments().iter().map(count).sum(),
    }
}

/// A linear map of parameters: `from` (in any order) onto a domain.
#[derive(Clone, Copy)]
struct Onto {
    from: [f64; 2],
    to: Interval,
}

impl Onto {
    fn at(&self, t: f64) -> f64 {
        let [a, b] = self.from;
        if t == a {
            self.to.start
        } else if t == b {
            self.to.end
        } else {
            self.to.start + (t - a) / (b - a) * self.to.length()
        }
    }

    fn is_turned(&self) -> bool {
        self.from[0] > self.from[1]
    }

    fn low_and_high(&self) -> [f64; 2] {
        let [a, b] = self.from;
        [a.min(b), a.max(b)]
    }
}

/// The image of a line of uv; `None` where there is none here.
pub(super) fn image(line: &Line<2>, surface: &Surface, room: &mut Room) -> Option<Curve3> {
    let domain = surface.domain();
    let inside =
        |p: &Point2<f64>| (0..2).all(|c| (domain[c].start..=domain[c].end).contains(&p[c]));
    if !inside(&line.from) || !inside(&line.to) {
        return None;
    }
    let moves = [0, 1].map(|c| line.from[c] != line.to[c]);
    let runs = match moves {
        [true, false] => 0,
        [false, true] => 1,
        [false, false] => return None,
        [true, true] => {
            return match surface {
                Surface::Nurbs(surface) => across(line, surface, room),
                _ => None,
            };
        }
    };
    let onto = Onto {
        from: [line.from[runs], line.to[runs]],
        to: line.domain,
    };
    let fixed = line.from[1 - runs];
    match surface {
        Surface::Nurbs(surface) => {
            room.take(surface.control_net().len(), surface.counts()[runs])?;
            row(surface, runs, fixed, &onto)
        }
        Surface::Sum(sum) => {
            let both = count(&sum.first).saturating_add(count(&sum.second));
            room.take(both, both)?;
            part(&of_sum(sum, runs, fixed)?, &onto)
        }
        Surface::Revolution(turned) => {
            room.take(count(&turned.profile), count(&turned.profile))?;
            // u is the angle but where the surface is transposed.
            if (runs == 0) == turned.transposed {
                part(&profile(turned, fixed)?, &onto)
            } else {
                part(&circle(turned, fixed)?, &onto)
            }
        }
        Surface::Plane(_) => None,
    }
}

/// The curve of a sum that runs along u (0) or v (1).
fn of_sum(sum: &Sum, runs: usize, fixed: f64) -> Option<Curve3> {
    let (curve, other) = if runs == 0 {
        (&sum.first, &sum.second)
    } else {
        (&sum.second, &sum.first)
    };
    moved(
        curve,
        &Matrix3::identity(),
        &(sum.base + other.point(fixed).coords),
    )
}

/// A curve under `x -> matrix x + by`.
fn moved(curve: &Curve3, matrix: &Matrix3<f64>, by: &Vector3<f64>) -> Option<Curve3> {
    let mut rows = [0.0; 16];
    for i in 0..3 {
        for j in 0..3 {
            rows[4 * i + j] = matrix[(i, j)];
        }
        rows[4 * i + 3] = by[i];
    }
    rows[15] = 1.0;
    Affine::from_rows(&rows)?.curve(curve).ok()
}

/// The circle of a surface of revolution through a point of its profile, over all of its angles; `None` on the axis.
fn circle(turned: &Revolution, at: f64) -> Option<Curve3> {
    let axis = turned.axis.normalize();
    let from = turned.profile.point(at) - turned.origin;
    let center = turned.origin + axis * from.dot(&axis);
    let out = turned.profile.point(at) - center;
    let radius = out.norm();
    let x = out / radius;
    let arc = Arc::new(Arc {
        center,
        x,
        y: axis.cross(&x),
        z: axis,
        radius,
        angle: turned.angle,
        domain: turned.angle_domain,
    });
    arc.ok().map(Curve::Arc)
}

/// The profile of a surface of revolution where its angular parameter is `at`.
fn profile(turned: &Revolution, at: f64) -> Option<Curve3> {
    let onto = Onto {
        from: [turned.angle_domain.start, turned.angle_domain.end],
        to: turned.angle,
    };
    let (sin, cos) = sin_cos(feeler::numeric::Ball::exact(onto.at(at)));
    let (sin, cos) = (sin.mid.hi, cos.mid.hi);
    // Rodrigues' formula.
    let axis = turned.axis.normalize();
    let across = axis.cross_matrix();
    let matrix = Matrix3::identity() * cos + across * sin + axis * axis.transpose() * (1.0 - cos);
    let origin = turned.origin.coords;
    moved(&turned.profile, &matrix, &(origin - matrix * origin))
}

/// The part of a curve that `onto` maps, with the parameter that it has there.
fn part(curve: &Curve3, onto: &Onto) -> Option<Curve3> {
    let [low, high] = onto.low_and_high();
    match curve {
        Curve::Line(_) => {
            let [from, to] = onto.from.map(|t| curve.point(t));
            Line::new(from, to, onto.to).ok().map(Curve::Line)
        }
        Curve::Arc(arc) => {
            let angle = Onto {
                from: [arc.domain.start, arc.domain.end],
                to: arc.angle,
            };
            let [a, b] = onto.from.map(|t| angle.at(t));
            let (angle, sign) = if onto.is_turned() {
                ([-a, -b], -1.0)
            } else {
                ([a, b], 1.0)
            };
            let part = Arc::new(Arc {
                y: arc.y * sign,
                z: arc.z * sign,
                angle: Interval::new(angle[0], angle[1])?,
                domain: onto.to,
                ..arc.clone()
            });
            part.ok().map(Curve::Arc)
        }
        Curve::Polyline(polyline) => {
            let within = polyline.params().iter().filter(|t| low < **t && **t < high);
            let mut at: Vec<f64> = [low].into_iter().chain(within.copied()).collect();
            at.push(high);
            if onto.is_turned() {
                at.reverse();
            }
            let points = at.iter().map(|t| curve.point(*t)).collect();
            let params = at.iter().map(|t| onto.at(*t)).collect();
            Polyline::new(points, params).ok().map(Curve::Polyline)
        }
        Curve::Nurbs(n) => {
            let part = n.restricted(low, high).ok()?;
            spline(
                part.degree(),
                part.control_points().to_vec(),
                part.knots().knots(),
                onto,
            )
        }
        Curve::Poly(poly) => {
            let mut pieces: Vec<(f64, f64, Curve3)> = Vec::new();
            for (segment, w) in poly.segments().iter().zip(poly.params().windows(2)) {
                let (from, to) = (w[0].max(low), w[1].min(high));
                if from >= to {
                    continue;
                }
                let own = Onto {
                    from: [w[0], w[1]],
                    to: segment.domain(),
                };
                let ends = if onto.is_turned() {
                    [to, from]
                } else {
                    [from, to]
                };
                let own = Onto {
                    from: ends.map(|t| own.at(t)),
                    to: Interval::new(onto.at(ends[0]), onto.at(ends[1]))?,
                };
                // Segments are never poly-curves themselves.
                pieces.push((own.to.start, own.to.end, part(segment, &own)?));
            }
            if onto.is_turned() {
                pieces.reverse();
            }
            joined(pieces)
        }
    }
}

/// Curves in a row, each with the parameters where it starts and ends.
pub(super) fn joined(pieces: Vec<(f64, f64, Curve3)>) -> Option<Curve3> {
    let mut params = vec![pieces.first()?.0];
    params.extend(pieces.iter().map(|p| p.1));
    let mut segments: Vec<Curve3> = pieces.into_iter().map(|p| p.2).collect();
    if segments.len() == 1 {
        return segments.pop();
    }
    PolyCurve::new(segments, params).ok().map(Curve::Poly)
}

/// A spline whose knots are mapped.
fn spline(
    degree: usize,
    mut points: Vec<Vector4<f64>>,
    knots: &[f64],
    onto: &Onto,
) -> Option<Curve3> {
    let mut knots: Vec<f64> = knots.iter().map(|k| onto.at(*k)).collect();
    if onto.is_turned() {
        points.reverse();
        knots.reverse();
    }
    let curve = NurbsCurve::new(degree, points, knots);
    curve.ok().map(Curve::Nurbs)
}

/// The line of a NURBS surface along u (0) or v (1).
fn row(surface: &NurbsSurface, runs: usize, fixed: f64, onto: &Onto) -> Option<Curve3> {
    let rests = 1 - runs;
    let domain = surface.domain()[rests];
    // The side of the part that the line is.
    let (cut, is_first) = if fixed < domain.end {
        ([fixed, domain.end], true)
    } else {
        ([domain.start, fixed], false)
    };
    let mut rectangle = [onto.low_and_high(); 2];
    rectangle[rests] = cut;
    let part = surface.restricted(rectangle[0], rectangle[1]).ok()?;
    let [count_u, count_v] = part.counts();
    let net = part.control_net();
    let points: Vec<Vector4<f64>> = match (runs, is_first) {
        (0, true) => net.iter().step_by(count_v).copied().collect(),
        (0, false) => { net.iter().skip(count_v.checked_sub(1)?) }
            .step_by(count_v)
            .copied()
            .collect(),
        (_, true) => net.iter().take(count_v).copied().collect(),
        (_, false) => { net.iter() }
            .skip(count_u.checked_sub(1)? * count_v)
            .copied()
            .collect(),
    };
    let knots = if runs == 0 {
        part.knots_u()
    } else {
        part.knots_v()
    };
    spline(knots.degree(), points, knots.knots(), onto)
}

/// `C(n, k)`, as exact as f64 has it.
fn binomial(n: usize, k: usize) -> f64 {
    (0..k.min(n - k)).fold(1.0, |b, i| b * (n - i) as f64 / (i + 1) as f64)
}

/// Where a line of uv is cut.
struct Cut {
    /// The fraction of the line.
    at: f64,
    uv: Point2<f64>,
}

/// Fractions of a line nearer to each other than this are one: some roundings.
const SLIVER: f64 = 16.0 * f64::EPSILON;

/// A line's ends, and where it goes over knots: there on them to the last digit.
fn cuts(line: &Line<2>, surface: &NurbsSurface) -> Vec<Cut> {
    let by = line.to - line.from;
    let mut crossed: Vec<(f64, usize, f64)> = Vec::new();
    for (c, knots) in [surface.knots_u(), surface.knots_v()]
        .into_iter()
        .enumerate()
    {
        let all = knots
            .spans()
            .map(|(_, start, _)| ((start - line.from[c]) / by[c], c, start));
        crossed.extend(all.filter(|(s, ..)| 0.0 < *s && *s < 1.0));
    }
    crossed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut cuts = vec![Cut {
        at: 0.0,
        uv: line.from,
    }];
    let mut end = Cut {
        at: 1.0,
        uv: line.to,
    };
    for (at, c, knot) in crossed {
        if 1.0 - at <= SLIVER {
            end.uv[c] = knot;
            continue;
        }
        match cuts.last_mut() {
            Some(last) if at - last.at <= SLIVER => last.uv[c] = knot,
            _ => {
                let mut uv = line.from + by * at;
                uv[c] = knot;
                cuts.push(Cut { at, uv });
            }
        }
    }
    cuts.push(end);
    cuts
}

/// The image of a line that runs along neither u nor v.
fn across(line: &Line<2>, surface: &NurbsSurface, room: &mut Room) -> Option<Curve3> {
    let degree = surface.knots_u().degree() + surface.knots_v().degree();
    let cuts = cuts(line, surface);
    let pieces = cuts.len().saturating_sub(1);
    room.take(
        surface.control_net().len().saturating_mul(pieces),
        degree.saturating_mul(pieces),
    )?;
    let (mut points, mut knots) = (Vec::new(), vec![line.domain.start; degree + 1]);
    for w in cuts.windows(2) {
        let [a, b] = w else { return None };
        let own = diagonal(surface, a.uv, b.uv)?;
        // The first is the last of the piece before, up to rounding.
        points.extend(own.into_iter().skip(usize::from(!points.is_empty())));
        let end = if b.at == 1.0 {
            line.domain.end
        } else {
            line.domain.lerp(b.at)
        };
        knots.extend(std::iter::repeat_n(end, degree));
    }
    knots.push(line.domain.end);
    let curve = NurbsCurve::new(degree, points, knots);
    curve.ok().map(Curve::Nurbs)
}

/// The control points of a surface's image of the straight line between two points of uv, no knots within.
fn diagonal(surface: &NurbsSurface, a: Point2<f64>, b: Point2<f64>) -> Option<Vec<Vector4<f64>>> {
    let ranges = [0, 1].map(|c| [a[c].min(b[c]), a[c].max(b[c])]);
    let part = surface.restricted(ranges[0], ranges[1]).ok()?;
    let [p, q] = [part.knots_u(), part.knots_v()].map(|k| k.degree());
    let [count_u, count_v] = part.counts();
    // A knot within: not by the cuts above.
    if [count_u, count_v] != [p + 1, q + 1] {
        return None;
    }
    let mut points = vec![Vector4::zeros(); p + q + 1];
    for (i, row) in part.control_net().chunks_exact(count_v).enumerate() {
        let i = if a.x < b.x { i } else { p - i };
        for (j, point) in row.iter().enumerate() {
            let j = if a.y < b.y { j } else { q - j };
            let share = binomial(p, i) * binomial(q, j) / binomial(p + q, i + j);
            *points.get_mut(i + j)? += point * share;
        }
    }
    Some(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of bilinear patches, and a line across all of them: its image costs the whole net for each rectangle that it passes.
    #[test]
    fn lines_take_what_their_bytes_allow() {
        const PATCHES: usize = 30;
        let side = PATCHES + 1;
        let mut knots: Vec<f64> = (0..side).map(|i| i as f64).collect();
        knots.insert(0, 0.0);
        knots.push(PATCHES as f64);
        let net = (0..side * side)
            .map(|i| Vector4::new((i / side) as f64, (i % side) as f64, 0.0, 1.0))
            .collect();
        let sheet = NurbsSurface::new([1, 1], [side, side], net, [knots.clone(), knots]);
        let surface = Surface::Nurbs(sheet.unwrap());
        let end = PATCHES as f64;
        let domain = Interval::new(0.0, 1.0).unwrap();
        let line = Line::new([0.0, 0.5].into(), [end, end - 0.5].into(), domain).unwrap();
        // It crosses a line of u between any two lines of v but at the middle, where it meets both at once.
        let rectangles = 2 * PATCHES - 2;
        let enough = (rectangles * side * side).div_ceil(STEPS_A_BYTE);
        let image = |bytes: usize| image(&line, &surface, &mut Room::new(bytes));
        assert_eq!(count(&image(enough).unwrap()), 2 * rectangles + 1);
        assert!(image(enough - 1).is_none());
        // And one line after the other takes from what is left.
        let mut room = Room::new(2 * enough);
        let taken = (0..5).filter(|_| super::image(&line, &surface, &mut room).is_some());
        assert_eq!(taken.count(), 2);
    }
}
