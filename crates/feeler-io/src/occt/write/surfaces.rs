//! Surfaces on their way into a file: the first native form that the reader turns into the same numbers, else the first that is
//! the same up to rounding, and how a face's parameters become the form's.

use super::super::curves::{Budget, Form};
use super::super::motion::Motion;
use super::super::surfaces::{Axes, Form3};
use super::Problem;
use super::curves::{ROUNDED, form, knots, sine_cosine};
use super::paced::{paced, paced_all};
use super::text::{near, read_again};
use feeler::numeric::Interval;
use feeler::nurbs::{
    Arc, Curve, Curve2, Curve3, Line, NurbsCurve, Plane, Revolution, Sum, Surface,
};
use nalgebra::{Point2, Point3, Vector3, Vector4};

/// What takes the kernel's parameters to the form's.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chart {
    /// The form's ranges that stand for the kernel's domains, where they are others. In the kernel's order of u and v.
    scaled: [Option<[Interval; 2]>; 2],
    /// Whether u and v swap, after that. It turns the normal round.
    pub(super) swapped: bool,
}

/// A surface as the file has it.
pub(super) struct Written {
    pub(super) form: Form3,
    pub(super) chart: Chart,
    /// Whether the reader gives back the very numbers.
    pub(super) exact: bool,
    /// The largest distance seen between points of it and the kernel's, or what a conversion bounds it by.
    pub(super) off: f64,
}

impl Chart {
    const SAME: Self = Self {
        scaled: [None; 2],
        swapped: false,
    };

    /// The same with a parameter read over another range, unless that is the same.
    fn scale(mut self, c: usize, from: Interval, to: Interval) -> Self {
        self.scaled[c] = (from != to).then_some([from, to]);
        self
    }

    /// Whether curves in uv are rounded by it.
    pub(super) fn rounds(&self) -> bool {
        self.scaled.iter().any(Option::is_some)
    }

    fn coordinate(&self, c: usize, x: f64) -> f64 {
        match self.scaled[c] {
            Some([from, to]) if x == from.end => to.end,
            Some([from, to]) => to.start + (x - from.start) * (to.length() / from.length()),
            None => x,
        }
    }

    fn point(&self, p: Point2<f64>) -> Point2<f64> {
        let [u, v] = [0, 1].map(|c| self.coordinate(c, p[c]));
        if self.swapped {
            Point2::new(v, u)
        } else {
            Point2::new(u, v)
        }
    }

    /// A curve in uv over the same parameter. Exact where nothing is scaled.
    pub(super) fn curve(&self, curve: &Curve2) -> Result<Curve2, Problem> {
        if !self.rounds() && !self.swapped {
            return Ok(curve.clone());
        }
        Ok(match curve {
            Curve::Line(l) => {
                Curve::Line(Line::new(self.point(l.from), self.point(l.to), l.domain)?)
            }
            Curve::Arc(a) if !self.rounds() => Curve::Arc(Arc {
                center: a.center.yx(),
                x: a.x.yx(),
                y: a.y.yx(),
                ..a.clone()
            }),
            Curve::Nurbs(n) => {
                let points = n.control_points().iter().map(|p| {
                    let mut p = *p;
                    for c in 0..2 {
                        if let Some([from, to]) = self.scaled[c] {
                            let pace = to.length() / from.length();
                            p[c] = to.start * p[2] + (p[c] - from.start * p[2]) * pace;
                        }
                    }
                    if self.swapped {
                        p.swap_rows(0, 1);
                    }
                    p
                });
                let knots = n.knots().knots().to_vec();
                Curve::Nurbs(NurbsCurve::new(n.degree(), points.collect(), knots)?)
            }
            // An arc stretched: an ellipse.
            other => return self.curve(&Curve::Nurbs(other.to_nurbs()?.nurbs)),
        })
    }

    fn domain(&self, c: usize, domain: [Interval; 2]) -> Interval {
        self.scaled[c].map_or(domain[c], |[_, to]| to)
    }

    /// The form's ranges for the whole of a surface.
    fn ranges(&self, surface: &Surface) -> [[f64; 2]; 2] {
        let own = surface.domain();
        let mut ranges = [0, 1]
            .map(|c| self.domain(c, own))
            .map(|i| [i.start, i.end]);
        if self.swapped {
            ranges.swap(0, 1);
        }
        ranges
    }
}

impl Written {
    /// The form with its ends: loops do not say them where there are none. Natural ends need not be said.
    pub(super) fn bounded(self, surface: &Surface) -> Form3 {
        let ranges = self.chart.ranges(surface);
        match self.form {
            whole @ Form3::Spline(..) => whole,
            form => Form3::Trimmed(ranges, Box::new(form)),
        }
    }
}

/// In how many steps along each parameter a form is held against its surface.
const STEPS: u32 = 8;

/// What products with weights come back as, and whether that is what they were.
fn read_weights(form: &Form3) -> (Form3, bool) {
    let again = |net: &[Vector4<f64>]| -> (Vec<Vector4<f64>>, bool) {
        let read: Vec<_> = net.iter().map(read_again).collect();
        let same = read == net;
        (read, same)
    };
    let profile = |p: &Form<3, 4>| match p {
        Form::Spline(k, net) => {
            let (net, same) = again(net);
            (Box::new(Form::Spline(k.clone(), net)), same)
        }
        other => (Box::new(other.clone()), true),
    };
    match form {
        Form3::Spline(k, net) => {
            let (net, same) = again(net);
            (Form3::Spline(k.clone(), net), same)
        }
        Form3::Extrusion(d, p) => {
            let (p, same) = profile(p);
            (Form3::Extrusion(*d, p), same)
        }
        Form3::Revolution(o, a, p) => {
            let (p, same) = profile(p);
            (Form3::Revolution(*o, *a, p), same)
        }
        other => (other.clone(), true),
    }
}

/// Holds what the reader makes of a form against the surface; `same` says that, products with weights aside, it is the same
/// surface by construction.
fn compared(surface: &Surface, form: Form3, chart: Chart, same: bool) -> Option<Written> {
    let mut numbers = Budget::new(usize::MAX);
    let (rounded, weights) = read_weights(&form);
    let ranges = chart.ranges(surface);
    let back = rounded
        .over(ranges, &Motion::identity(), &mut numbers)
        .ok()?;
    let as_stored = match back.clone() {
        Surface::Revolution(r) if chart.swapped => Surface::Revolution(Revolution {
            transposed: true,
            ..r
        }),
        Surface::Sum(s) if chart.swapped => Surface::Sum(Sum {
            base: s.base,
            first: s.second,
            second: s.first,
        }),
        other => other,
    };
    if as_stored == *surface || (same && weights && !chart.rounds()) {
        return Some(Written {
            form,
            chart,
            exact: true,
            off: 0.0,
        });
    }
    let [u, v] = surface.domain();
    let mut off: f64 = 0.0;
    for i in 0..=STEPS {
        for j in 0..=STEPS {
            let [s, t] = [(i, u), (j, v)].map(|(k, d)| d.lerp(f64::from(k) / f64::from(STEPS)));
            let q = chart.point(Point2::new(s, t));
            off = off.max((surface.point(s, t) - back.point(q.x, q.y)).norm());
        }
    }
    Some(Written {
        form,
        chart,
        exact: false,
        off,
    })
}

/// The largest coordinate of some points of a surface.
fn size(surface: &Surface) -> f64 {
    let [u, v] = surface.domain();
    let mut size: f64 = 0.0;
    for i in 0..=2 {
        for j in 0..=2 {
            let p = surface.point(u.lerp(0.5 * f64::from(i)), v.lerp(0.5 * f64::from(j)));
            size = size.max(p.coords.amax());
        }
    }
    size
}

/// A surface as the file has it.
pub(super) fn written(surface: &Surface) -> Result<Written, Problem> {
    let candidates = match surface {
        Surface::Plane(p) => plane(p)?,
        Surface::Revolution(r) => revolution(r)?,
        Surface::Sum(s) => sum(s)?,
        Surface::Nurbs(n) => {
            let form = Form3::Spline(
                [knots(n.knots_u())?, knots(n.knots_v())?],
                n.control_net().to_vec(),
            );
            vec![(form, Chart::SAME, true)]
        }
    };
    let slack = ROUNDED * size(surface);
    let mut best: Option<Written> = None;
    for (form, chart, same) in candidates {
        let Some(found) = compared(surface, form, chart, same) else {
            continue;
        };
        if found.exact {
            return Ok(found);
        }
        if best.is_none() && found.off <= slack {
            best = Some(found);
        }
    }
    match best {
        Some(best) => Ok(best),
        None => as_nurbs(surface),
    }
}

/// Nets of more points are not written: those of a sum are as many as both curves' together, multiplied.
const MOST_POINTS: usize = 1 << 20;

/// About how many control points a curve has as NURBS.
fn points_of(curve: &Curve3) -> usize {
    match curve {
        Curve::Nurbs(c) => c.control_points().len(),
        Curve::Polyline(c) => c.points().len(),
        Curve::Poly(c) => c.segments().iter().map(points_of).sum(),
        Curve::Line(_) | Curve::Arc(_) => 2,
    }
}

/// As NURBS, where that leaves the parameters as they are.
fn as_nurbs(surface: &Surface) -> Result<Written, Problem> {
    let converted = match surface {
        Surface::Sum(s) => {
            let (first, second) = (paced_all(&s.first)?, paced_all(&s.second)?);
            let count = points_of(&first).saturating_mul(points_of(&second));
            if count > MOST_POINTS {
                return Err(Problem::new(format!(
                    "a sum of two curves in many pieces: its net would have {count} points, more than {MOST_POINTS}; split it first"
                )));
            }
            Surface::Sum(Sum {
                base: s.base,
                first,
                second,
            })
            .to_nurbs()?
        }
        other => other.to_nurbs()?,
    };
    if !converted.maps.iter().all(|m| m.is_identity()) {
        return Err(Problem::new(format!(
            "a surface ({}) has no equal in the format, and as NURBS would have other parameters; convert it to NURBS first",
            surface.type_name()
        )));
    }
    let n = &converted.nurbs;
    let form = Form3::Spline(
        [knots(n.knots_u())?, knots(n.knots_v())?],
        n.control_net().to_vec(),
    );
    let found = compared(surface, form, Chart::SAME, false);
    let mut found = found.ok_or_else(|| Problem::new("a surface cannot be written as NURBS"))?;
    found.off = found.off.max(converted.bound);
    Ok(found)
}

/// Forms, how parameters become theirs, and whether each is the same surface by construction but for products with weights.
type Candidates = Vec<(Form3, Chart, bool)>;

fn is_unit(v: &Vector3<f64>) -> bool {
    (v.norm() - 1.0).abs() <= ROUNDED
}

fn plane(p: &Plane) -> Result<Candidates, Problem> {
    if !(is_unit(&p.x) && is_unit(&p.y) && p.x.dot(&p.y).abs() <= ROUNDED) {
        // OCCT makes axes orthonormal: only four corners say where this plane is.
        return Ok(Vec::new());
    }
    let axes = Axes {
        origin: p.origin,
        z: p.x.cross(&p.y).normalize(),
        x: p.x,
        y: p.y,
    };
    let mut chart = Chart::SAME;
    for c in 0..2 {
        chart = chart.scale(c, p.domain[c], p.extents[c]);
    }
    Ok(vec![(Form3::Plane(axes), chart, true)])
}

fn revolution(r: &Revolution) -> Result<Candidates, Problem> {
    let (angular, along) = if r.transposed { (1, 0) } else { (0, 1) };
    let mut chart = Chart::SAME.scale(angular, r.angle_domain, r.angle);
    chart.swapped = r.transposed;
    let mut found = Vec::new();
    match &r.profile {
        Curve::Line(l) => found.extend(cylinder_or_cone(r, l)),
        Curve::Arc(a) => {
            chart = chart.scale(along, a.domain, a.angle);
            found.extend(sphere_or_torus(r, a));
        }
        _ => {}
    }
    // The profile as it is, its ends with it.
    let profile = match &r.profile {
        Curve::Arc(a) => {
            let own = Curve::Arc(Arc {
                domain: a.angle,
                ..a.clone()
            });
            form(&own).map(|f| Form::Trimmed([a.angle.start, a.angle.end], Box::new(f)))
        }
        other => form(&paced(other)?),
    };
    if let Ok(profile) = profile {
        let profile = match profile {
            straight @ Form::Line { .. } => {
                let ends = r.profile.domain();
                Form::Trimmed([ends.start, ends.end], Box::new(straight))
            }
            other => other,
        };
        found.push(Form3::Revolution(r.origin, r.axis, Box::new(profile)));
    }
    // A curve in pieces became one, rounded.
    let in_pieces = matches!(r.profile, Curve::Poly(_));
    let as_it_is = |f: &Form3| matches!(f, Form3::Revolution(..)) && !in_pieces;
    let found = found.into_iter();
    Ok(found
        .map(|f| (as_it_is(&f), f))
        .map(|(same, f)| (f, chart, same))
        .collect())
}

/// Numbers that a radius may have been, most likely first: short decimals, then neighbours.
fn radii(r: f64) -> impl Iterator<Item = f64> {
    let short = (12..=16).filter_map(move |digits: usize| format!("{r:.digits$e}").parse().ok());
    short.chain(near(r))
}

/// An axis as long as 1.
fn unit_axis(r: &Revolution) -> Vector3<f64> {
    if is_unit(&r.axis) {
        r.axis
    } else {
        r.axis.normalize()
    }
}

fn cylinder_or_cone(r: &Revolution, l: &Line<3>) -> Option<Form3> {
    let [s, t] = [l.domain.start, l.domain.end];
    let pace = (l.to - l.from) / (t - s);
    if !is_unit(&pace) {
        return None;
    }
    let axis = unit_axis(r);
    let up = if pace.dot(&axis) < 0.0 { -axis } else { axis };
    let cos = pace.dot(&up);
    // Where the line would be at parameter 0, from a point of the axis.
    let start = l.from - pace * s - r.origin;
    let height = start.dot(&up);
    let radial = start - up * height;
    // The radial direction, where the profile starts at the apex: that of its end.
    let far = l.to - r.origin;
    let far = far - up * far.dot(&up);
    let direction = if far.norm() > radial.norm() {
        far
    } else {
        radial
    };
    let x = direction.try_normalize(0.0)?;
    let sin = pace.dot(&x);
    let slack = ROUNDED * (start.norm() + r.origin.coords.amax()).max(1.0);
    // The format's origin lies on the axis where the parameter is 0.
    let origin = if height.abs() <= slack {
        r.origin
    } else {
        r.origin + up * height
    };
    let radius = radial.dot(&x);
    let axes = |x: Vector3<f64>| Axes {
        origin,
        z: up,
        x,
        y: axis.cross(&x),
    };
    if sin.abs() <= ROUNDED {
        let from = |x: f64, r: f64, c: usize, v: f64| origin[c] + x * r + up[c] * v;
        for radius in radii(radius).filter(|r| *r > 0.0) {
            let mut best = Vector3::zeros();
            let fits = (0..3).all(|c| {
                let x = near(radial[c] / radius).chain([0.0]).find(|x| {
                    from(*x, radius, c, s) == l.from[c] && from(*x, radius, c, t) == l.to[c]
                });
                best[c] = x.unwrap_or(0.0);
                x.is_some()
            });
            if fits && is_unit(&best) {
                return Some(Form3::Cylinder(axes(best), radius));
            }
        }
        return (radius > 0.0).then(|| Form3::Cylinder(axes(x), radius));
    }
    if cos <= ROUNDED || radius < 0.0 {
        // Flat, or with its parameter 0 beyond the apex.
        return None;
    }
    let half = sin.atan2(cos);
    let (sin, cos) = sine_cosine(half);
    for radius in radii(radius) {
        let mut best = x;
        let at = |x: f64, c: usize, v: f64| origin[c] + x * (radius + v * sin) + up[c] * (v * cos);
        let fits = (0..3).all(|c| {
            let x = near(x[c])
                .chain([0.0])
                .find(|x| at(*x, c, s) == l.from[c] && at(*x, c, t) == l.to[c]);
            best[c] = x.unwrap_or(0.0);
            x.is_some()
        });
        if fits && is_unit(&best) {
            return Some(Form3::Cone(axes(best), radius, half));
        }
    }
    Some(Form3::Cone(axes(x), radius, half))
}

fn sphere_or_torus(r: &Revolution, a: &Arc<3>) -> Option<Form3> {
    let axis = unit_axis(r);
    let up = a.y;
    let along = up.dot(&axis).signum();
    let is_meridian = (up * along - axis).amax() <= ROUNDED
        && is_unit(&a.x)
        && a.x.dot(&up).abs() <= ROUNDED
        && (a.x.cross(&up) - a.z.normalize()).amax() <= ROUNDED;
    if !is_meridian {
        return None;
    }
    let offset = a.center - r.origin;
    let radial = offset - axis * offset.dot(&axis);
    let slack = ROUNDED * (offset.norm() + r.origin.coords.amax()).max(a.radius);
    let axes = |origin: Point3<f64>| Axes {
        origin,
        z: up,
        x: a.x,
        y: axis.cross(&a.x),
    };
    if radial.norm() <= slack {
        let quarter = std::f64::consts::FRAC_PI_2;
        let within = a.angle.start >= -quarter && a.angle.end <= quarter;
        return within.then(|| Form3::Sphere(axes(a.center), a.radius));
    }
    let major = radial.dot(&a.x);
    if !(major > 0.0) || (radial - a.x * major).norm() > slack {
        return None;
    }
    let fits = |major: f64| (r.origin + a.x * major) == a.center;
    if let Some(major) = radii(major).find(|m| fits(*m)) {
        return Some(Form3::Torus(axes(r.origin), [major, a.radius]));
    }
    Some(Form3::Torus(
        axes(a.center - a.x * major),
        [major, a.radius],
    ))
}

/// A curve as one that a surface of the format may be made of, its parameter's range changed in the chart.
fn profile(curve: &Curve3, c: usize, chart: Chart) -> Result<(Curve3, Chart), Problem> {
    Ok(match curve {
        Curve::Arc(a) => {
            let own = Arc {
                domain: a.angle,
                ..a.clone()
            };
            (Curve::Arc(own), chart.scale(c, a.domain, a.angle))
        }
        other => (paced(other)?, chart),
    })
}

fn shifted(curve: &Curve3, by: Vector3<f64>) -> Result<Curve3, Problem> {
    if by == Vector3::zeros() {
        return Ok(curve.clone());
    }
    Ok(match curve {
        Curve::Line(l) => Curve::Line(Line::new(l.from + by, l.to + by, l.domain)?),
        Curve::Arc(a) => Curve::Arc(Arc {
            center: a.center + by,
            ..a.clone()
        }),
        Curve::Nurbs(n) => {
            let points = n.control_points().iter().map(|p| {
                let mut p = *p;
                for c in 0..3 {
                    p[c] += by[c] * p[3];
                }
                p
            });
            let knots = n.knots().knots().to_vec();
            Curve::Nurbs(NurbsCurve::new(n.degree(), points.collect(), knots)?)
        }
        other => shifted(&Curve::Nurbs(other.to_nurbs()?.nurbs), by)?,
    })
}

/// A curve and a line: an extrusion.
fn sum(s: &Sum) -> Result<Candidates, Problem> {
    let (line, curve, swapped) = match (&s.first, &s.second) {
        (curve, Curve::Line(line)) => (line, curve, false),
        (Curve::Line(line), curve) => (line, curve, true),
        _ => return Ok(Vec::new()),
    };
    let (along, across) = if swapped { (0, 1) } else { (1, 0) };
    let [from, to] = [line.domain.start, line.domain.end];
    // The reader's line starts at the direction times the parameter.
    let mut exact = Vector3::zeros();
    let fits = s.base == Vector3::zeros()
        && (0..3).all(|c| {
            let slope = (line.to[c] - line.from[c]) / (to - from);
            let found = near(slope).find(|d| d * from == line.from[c] && d * to == line.to[c]);
            exact[c] = found.unwrap_or(0.0);
            found.is_some()
        });
    let pace = (line.to - line.from) / (to - from);
    let speed = pace.norm();
    if !(speed > 0.0) {
        return Ok(Vec::new());
    }
    let mut chart = Chart::SAME;
    chart.swapped = swapped;
    let (direction, by) = if fits && is_unit(&exact) {
        (exact, Vector3::zeros())
    } else {
        let by = s.base + (line.from.coords - pace * from);
        if (speed - 1.0).abs() <= ROUNDED {
            (pace, by)
        } else {
            let Some(own) = Interval::new(from * speed, to * speed) else {
                return Ok(Vec::new());
            };
            chart = chart.scale(along, line.domain, own);
            (pace / speed, by)
        }
    };
    let in_pieces = matches!(curve, Curve::Poly(_));
    let (curve, chart) = profile(curve, across, chart)?;
    let Ok(basis) = form(&shifted(&curve, by)?) else {
        return Ok(Vec::new());
    };
    let ends = curve.domain();
    let basis = match basis {
        whole @ (Form::Line { .. } | Form::Circle(..)) => {
            Form::Trimmed([ends.start, ends.end], Box::new(whole))
        }
        other => other,
    };
    let same = fits && by == Vector3::zeros() && !in_pieces;
    let extrusion = Form3::Extrusion(direction, Box::new(basis));
    Ok(vec![(extrusion, chart, same)])
}
