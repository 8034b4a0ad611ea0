//! Curves and surfaces in their native form.

use super::chunks::Writer;
use feeler::nurbs::{
    Arc, Curve, KnotVector, Line, NurbsCurve, NurbsSurface, Plane, PolyCurve, Polyline, Revolution,
    Sum, Surface,
};
use nalgebra::{Point, Point3, SVector, Vector3};

const LINE: &str = "4ED7D4DB-E947-11d3-BFE5-0010830122F0";
const ARC: &str = "CF33BE2A-09B4-11d4-BFFB-0010830122F0";
const POLYLINE: &str = "4ED7D4E6-E947-11d3-BFE5-0010830122F0";
const NURBS_CURVE: &str = "4ED7D4DD-E947-11d3-BFE5-0010830122F0";
const POLY_CURVE: &str = "4ED7D4E0-E947-11d3-BFE5-0010830122F0";
const PLANE: &str = "4ED7D4DF-E947-11d3-BFE5-0010830122F0";
const REVOLUTION: &str = "A16220D3-163B-11d4-8000-0010830122F0";
const SUM: &str = "C4CD5359-446D-4690-9FF5-29059732472B";
const NURBS_SURFACE: &str = "4ED7D4DE-E947-11d3-BFE5-0010830122F0";

/// How many neighbours of a rounded sum are tried for one whose difference is the axis.
const NEIGHBOURS: usize = 4;

/// A box along the axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Bounds {
    pub(super) fn empty() -> Self {
        Self {
            low: Vector3::repeat(f64::INFINITY),
            high: Vector3::repeat(f64::NEG_INFINITY),
        }
    }

    pub(super) fn add(&mut self, p: Vector3<f64>) {
        self.low = self.low.inf(&p);
        self.high = self.high.sup(&p);
    }

    pub(super) fn write(&self, w: &mut Writer) {
        w.f64s(self.low.as_slice());
        w.f64s(self.high.as_slice());
    }
}

/// In three coordinates, as the format stores all points.
fn spatial<const D: usize>(v: &SVector<f64, D>) -> Vector3<f64> {
    Vector3::from_fn(|i, _| v.get(i).copied().unwrap_or(0.0))
}

/// Grows a box by what holds a curve.
pub(super) fn bound<const D: usize, const H: usize>(curve: &Curve<D, H>, bounds: &mut Bounds) {
    match curve {
        Curve::Line(l) => {
            bounds.add(spatial(&l.from.coords));
            bounds.add(spatial(&l.to.coords));
        }
        Curve::Arc(a) => {
            let center = spatial(&a.center.coords);
            let mut reach = Vector3::repeat(a.radius);
            if D == 2 {
                reach.z = 0.0;
            }
            bounds.add(center - reach);
            bounds.add(center + reach);
        }
        Curve::Polyline(p) => p
            .points()
            .iter()
            .for_each(|q| bounds.add(spatial(&q.coords))),
        Curve::Nurbs(n) => n.control_points().iter().for_each(|p| {
            let point: SVector<f64, D> = SVector::from_fn(|i, _| p[i] / p[H - 1]);
            bounds.add(spatial(&point));
        }),
        // Segments are never poly-curves themselves.
        Curve::Poly(p) => p.segments().iter().for_each(|s| bound(s, bounds)),
    }
}

/// Grows a box by what holds a surface.
pub(super) fn bound_surface(surface: &Surface, bounds: &mut Bounds) {
    match surface {
        Surface::Plane(p) => {
            for a in [p.extents[0].start, p.extents[0].end] {
                for b in [p.extents[1].start, p.extents[1].end] {
                    bounds.add(p.origin.coords + p.x * a + p.y * b);
                }
            }
        }
        Surface::Nurbs(n) => n
            .control_net()
            .iter()
            .for_each(|p| bounds.add(p.xyz() / p.w)),
        Surface::Revolution(r) => {
            // A ball about each corner's foot on the axis holds its circle.
            let mut profile = Bounds::empty();
            bound(&r.profile, &mut profile);
            let axis = r.axis.normalize();
            for corner in 0..8 {
                let pick = |i: usize| {
                    if corner >> i & 1 == 0 {
                        profile.low[i]
                    } else {
                        profile.high[i]
                    }
                };
                let p = Vector3::new(pick(0), pick(1), pick(2));
                let foot = r.origin.coords + axis * (p - r.origin.coords).dot(&axis);
                let reach = Vector3::repeat((p - foot).norm());
                bounds.add(foot - reach);
                bounds.add(foot + reach);
            }
        }
        Surface::Sum(s) => {
            let (mut first, mut second) = (Bounds::empty(), Bounds::empty());
            bound(&s.first, &mut first);
            bound(&s.second, &mut second);
            bounds.add(s.base + first.low + second.low);
            bounds.add(s.base + first.high + second.high);
        }
    }
}

/// Writes geometry and remembers what the format had no room for.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    outer_knots: usize,
    axes: usize,
    axis_off: f64,
}

impl Geometry {
    /// What did not get into the file as it was, a line each.
    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.outer_knots > 0 {
            notes.push(format!(
                "{} splines are not clamped: their two outer knots, on which no point depends, are repeated ones when read back",
                self.outer_knots
            ));
        }
        if self.axes > 0 {
            notes.push(format!(
                "{} axes of revolution are rounded, by up to {:.1e} of their length: the format keeps two points",
                self.axes, self.axis_off
            ));
        }
        notes
    }

    /// A curve with its wrapper.
    pub(super) fn curve<const D: usize, const H: usize>(
        &mut self,
        w: &mut Writer,
        curve: &Curve<D, H>,
    ) {
        match curve {
            Curve::Line(c) => w.object(LINE, |w| line(w, c)),
            Curve::Arc(c) => w.object(ARC, |w| arc(w, c)),
            Curve::Polyline(c) => w.object(POLYLINE, |w| polyline(w, c)),
            Curve::Nurbs(c) => w.object(NURBS_CURVE, |w| self.nurbs::<D, H>(w, c, curve)),
            Curve::Poly(c) => w.object(POLY_CURVE, |w| self.poly(w, c, curve)),
        }
    }

    /// A surface with its wrapper.
    pub(super) fn surface(&mut self, w: &mut Writer, surface: &Surface) {
        match surface {
            Surface::Plane(s) => w.object(PLANE, |w| plane(w, s)),
            Surface::Revolution(s) => w.object(REVOLUTION, |w| self.revolution(w, s, surface)),
            Surface::Sum(s) => w.object(SUM, |w| self.sum(w, s, surface)),
            Surface::Nurbs(s) => w.object(NURBS_SURFACE, |w| self.nurbs_surface(w, s, surface)),
        }
    }

    fn nurbs<const D: usize, const H: usize>(
        &mut self,
        w: &mut Writer,
        n: &NurbsCurve<H>,
        curve: &Curve<D, H>,
    ) {
        let points = n.control_points();
        let rational = points.iter().any(|p| p[H - 1] != 1.0);
        w.u8(0x10);
        w.index(D);
        w.i32(i32::from(rational));
        w.index(n.degree() + 1);
        w.index(points.len());
        w.i32(0);
        w.i32(0);
        let mut bounds = Bounds::empty();
        bound(curve, &mut bounds);
        bounds.write(w);
        self.knots(w, n.knots());
        w.index(points.len());
        let stored = if rational { H } else { D };
        for p in points {
            w.f64s(&p.as_slice()[..stored]);
        }
    }

    /// Without the two outer ones.
    fn knots(&mut self, w: &mut Writer, knots: &KnotVector) {
        let all = knots.knots();
        if let [first, inner @ .., last] = all {
            if inner.first() != Some(first) || inner.last() != Some(last) {
                self.outer_knots += 1;
            }
            w.f64_array(inner);
        }
    }

    fn poly<const D: usize, const H: usize>(
        &mut self,
        w: &mut Writer,
        p: &PolyCurve<D, H>,
        curve: &Curve<D, H>,
    ) {
        w.u8(0x10);
        w.index(p.segments().len());
        w.i32(0);
        w.i32(0);
        let mut bounds = Bounds::empty();
        bound(curve, &mut bounds);
        bounds.write(w);
        w.f64_array(p.params());
        for segment in p.segments() {
            self.curve(w, segment);
        }
    }

    fn revolution(&mut self, w: &mut Writer, r: &Revolution, surface: &Surface) {
        w.u8(0x20);
        w.f64s(r.origin.coords.as_slice());
        let to = self.axis_end(r.origin, r.axis);
        w.f64s(to.as_slice());
        for i in [r.angle, r.angle_domain] {
            w.f64s(&[i.start, i.end]);
        }
        let mut bounds = Bounds::empty();
        bound_surface(surface, &mut bounds);
        bounds.write(w);
        w.i32(i32::from(r.transposed));
        w.u8(1);
        self.curve(w, &r.profile);
    }

    /// The point that gives the axis back when the origin is taken from it. Where the axis was such a difference there is
    /// one, some roundings off the sum.
    fn axis_end(&mut self, origin: Point3<f64>, axis: Vector3<f64>) -> Vector3<f64> {
        let mut off: f64 = 0.0;
        let end = Vector3::from_fn(|i, _| {
            let (from, wanted) = (origin[i], axis[i]);
            let sum = from + wanted;
            let (mut up, mut down) = (sum, sum);
            for _ in 0..=NEIGHBOURS {
                for candidate in [up, down] {
                    let is_it = (candidate - from).to_bits() == wanted.to_bits();
                    // The difference of equal numbers is +0.
                    if is_it || (wanted == 0.0 && candidate == from) {
                        return candidate;
                    }
                }
                (up, down) = (up.next_up(), down.next_down());
            }
            off = off.max((sum - from - wanted).abs());
            sum
        });
        if off > 0.0 {
            self.axes += 1;
            self.axis_off = self.axis_off.max(off / axis.norm());
        }
        end
    }

    fn sum(&mut self, w: &mut Writer, s: &Sum, surface: &Surface) {
        w.u8(0x10);
        w.f64s(s.base.as_slice());
        let mut bounds = Bounds::empty();
        bound_surface(surface, &mut bounds);
        bounds.write(w);
        self.curve(w, &s.first);
        self.curve(w, &s.second);
    }

    fn nurbs_surface(&mut self, w: &mut Writer, n: &NurbsSurface, surface: &Surface) {
        let rational = n.control_net().iter().any(|p| p.w != 1.0);
        w.u8(0x10);
        w.i32(3);
        w.i32(i32::from(rational));
        w.index(n.knots_u().degree() + 1);
        w.index(n.knots_v().degree() + 1);
        n.counts().iter().for_each(|c| w.index(*c));
        w.i32(0);
        w.i32(0);
        let mut bounds = Bounds::empty();
        bound_surface(surface, &mut bounds);
        bounds.write(w);
        self.knots(w, n.knots_u());
        self.knots(w, n.knots_v());
        w.index(n.control_net().len());
        let stored = if rational { 4 } else { 3 };
        // u is the outer loop, as in the kernel.
        for p in n.control_net() {
            w.f64s(&p.as_slice()[..stored]);
        }
    }
}

fn point<const D: usize>(w: &mut Writer, p: &Point<f64, D>) {
    w.f64s(spatial(&p.coords).as_slice());
}

fn line<const D: usize>(w: &mut Writer, l: &Line<D>) {
    w.u8(0x10);
    point(w, &l.from);
    point(w, &l.to);
    w.f64s(&[l.domain.start, l.domain.end]);
    w.index(D);
}

/// Origin, axes, normal and equation.
fn frame(w: &mut Writer, origin: Vector3<f64>, x: Vector3<f64>, y: Vector3<f64>, z: Vector3<f64>) {
    for v in [origin, x, y, z] {
        w.f64s(v.as_slice());
    }
    w.f64s(z.as_slice());
    w.f64s(&[-z.dot(&origin)]);
}

fn arc<const D: usize>(w: &mut Writer, a: &Arc<D>) {
    let [center, x, y] = [spatial(&a.center.coords), spatial(&a.x), spatial(&a.y)];
    let z = if D == 3 {
        spatial(&a.z)
    } else {
        Vector3::new(
            0.0,
            0.0,
            if a.x[0] * a.y[1] < a.x[1] * a.y[0] {
                -1.0
            } else {
                1.0
            },
        )
    };
    w.u8(0x10);
    frame(w, center, x, y, z);
    w.f64s(&[a.radius]);
    // Points at 0, a quarter and half a turn.
    for p in [
        center + x * a.radius,
        center + y * a.radius,
        center - x * a.radius,
    ] {
        w.f64s(p.as_slice());
    }
    for i in [a.angle, a.domain] {
        w.f64s(&[i.start, i.end]);
    }
    w.index(D);
}

fn polyline<const D: usize>(w: &mut Writer, p: &Polyline<D>) {
    w.u8(0x10);
    w.index(p.points().len());
    p.points().iter().for_each(|q| point(w, q));
    w.f64_array(p.params());
    w.index(D);
}

fn plane(w: &mut Writer, p: &Plane) {
    w.u8(0x11);
    let normal = p.x.cross(&p.y).normalize();
    frame(w, p.origin.coords, p.x, p.y, normal);
    for i in p.domain.iter().chain(&p.extents) {
        w.f64s(&[i.start, i.end]);
    }
}
