//! Closed forms: planes, and revolutions of a segment or an arc (cylinders, cones, spheres, tori), with boundary curves
//! that are segments and arcs in space.
//!
//! The critical points of a distance or a height on such a face, and its least values on such curves, are formulas:
//! they are computed in double-double with running bounds, so that nothing is searched.

mod curve;
mod foot;
mod form;
mod gap;
mod line;
mod place;
mod plane;
mod quadric;
mod revolution;
mod sphere;
mod torus;
mod upon;

pub(crate) use curve::{ClosedCurve, CurveShape};
use curve::{Of, UvPath};
pub(crate) use form::{
    Boxes, Critical, Extent, Minimum, Target, V3, distance_range, exact, lead, widened,
};
pub(crate) use gap::frechet;
pub(crate) use line::{ClosedHit, ClosedLine};
pub(crate) use place::Places;
pub(crate) use sphere::{SphereFoot, SphereForm};
pub(crate) use upon::Exactly;

use plane::PlaneForm;
use revolution::RevolutionForm;

use super::boundary::{UvCurve, curve_sources, uv_curve};
use super::bunches::{self, Bunches};
use crate::brep::Brep;
use crate::numeric::{Ball, Dd, Interval, Real};
use crate::nurbs::{Arc, Curve2, Surface};
use crate::trim::{PieceOrigin, TrimRegion};
use std::ops::Range;

/// A surface in closed form.
#[derive(Clone, Debug)]
pub(crate) enum ClosedSurface {
    Plane(Box<PlaneForm>),
    Revolution(Box<RevolutionForm>),
}

/// A face whose surface has a closed form, and what bounds it.
#[derive(Debug)]
pub(crate) struct ClosedFace {
    pub(crate) surface: ClosedSurface,
    /// Boundary curves in closed form.
    pub(crate) curves: Vec<ClosedCurve>,
    /// Which of the face's other uv curves have none, in order: they are left to the pieces.
    pub(crate) others: Vec<usize>,
    /// The trims (or, of segments that join two, the first) that these are part of, in order.
    other_trims: Vec<usize>,
    /// Of the others: trims whose whole images are nearly arcs, in no order.
    nearly: Vec<NearlyArc>,
    /// Which curves are parts of what, in the order of that.
    parts: Vec<(Of, Range<u32>)>,
    /// Boxes around the curves, where there are many.
    pub(crate) bunches: Option<Bunches>,
    /// Whether some of them were moved into the domain.
    pub(crate) any_moved: bool,
}

/// A trim whose image is an arc up to roundings of the plane's axes.
#[derive(Debug)]
struct NearlyArc {
    trim: usize,
    shape: CurveShape,
    /// How far the image may be from it.
    slack: f64,
    /// Whether it runs against the trim.
    against: bool,
}

/// The whole image of a trim, or of a segment that joins two, in closed form.
pub(crate) struct ClosedImage<'a> {
    pub(crate) shape: &'a CurveShape,
    /// Whether it runs against the trim.
    pub(crate) against: bool,
    /// How far the image may be from it.
    pub(crate) slack: f64,
}

impl ClosedFace {
    /// The closed form of a face; `None` where its surface has none. With `recognise`, NURBS that are planes have one.
    ///
    /// *Loops that leave the domain.* A point x of the domain's border that is in the region without a loop through it has
    /// odd parity beside it. On the way from x straight out of the domain the parity becomes even: a loop is met, at a
    /// point whose nearest point in the domain is x. So the region's boundary lies on the loops moved to the
    /// nearest points in the domain. A straight segment stays one if it is moved as a whole; others that leave the
    /// domain are not in closed form, and then nor is the face. What was moved need not be in the region: such
    /// curves give lower bounds, and upper ones only where a test says so.
    ///
    /// *Ends on the border up to rounding.* Let an end of a segment be known within a ball that reaches across the border (an end of an arc that touches it, in
    /// double-double). A point of the moved segment has the coordinate `min(x, e)`, `x = (1 - s) a + s b`, `e` the border. If `x > e`, then
    /// `(1 - s) min(a, e) + s min(b, e) <= e < x`; between these two the ends may be chosen so that it is `e`, in their balls, as balls are convex and hold
    /// `min(a, e)` where they reach across. So each point moved is on a segment between some points of both balls, and a bound from below that holds for
    /// all of these, as the image under an affine map, holds for it. The curve counts as moved.
    pub(crate) fn new(
        brep: &Brep,
        face: usize,
        region: &TrimRegion,
        size: f64,
        recognise: bool,
    ) -> Option<Self> {
        let whole_domain = brep.faces()[face].loops.is_none();
        let surface = ClosedSurface::new(brep.surface(face), size, recognise)?;
        let mut out = Self {
            surface,
            curves: Vec::new(),
            others: Vec::new(),
            other_trims: Vec::new(),
            nearly: Vec::new(),
            parts: Vec::new(),
            bunches: None,
            any_moved: false,
        };
        let domain = brep.surface(face).domain();
        let arc_of = |trim: Option<usize>| match trim.map(|t| (t, &brep.parts().trims[t])) {
            Some((t, trim)) => match &brep.parts().curves2[trim.curve] {
                Curve2::Arc(arc) => Some((t, arc, trim.span)),
                _ => None,
            },
            None => None,
        };
        let leaving = leaving_trims(region);
        let stays_inside = |trim: usize| leaving.binary_search(&trim).is_err();
        let mut last_arc = None;
        let (borders, sources) = match whole_domain {
            true => (borders(domain), Vec::new()),
            false => (Vec::new(), curve_sources(brep, face)),
        };
        for index in 0..borders.len() + sources.len() {
            let source = sources.get(index);
            let arc = arc_of(source.and_then(|s| s.trim()));
            // Its pieces come one after the other.
            if arc.is_some_and(|(t, ..)| last_arc == Some(t)) {
                continue;
            }
            if let (Some((t, arc, span)), ClosedSurface::Plane(p)) = (arc, &out.surface)
                && (stays_inside(t) || circle_inside(arc, domain))
            {
                let against = brep.parts().trims[t].reversed;
                if let Some(mut curve) = p.arc(arc, span, t) {
                    last_arc = Some(t);
                    curve.against = against;
                    out.curves.push(curve);
                    continue;
                }
                // Its pieces come one after the other.
                if out.nearly.last().is_none_or(|n| n.trim != t)
                    && let Some((shape, slack)) = p.nearly_arc(arc, span)
                {
                    out.nearly.push(NearlyArc {
                        trim: t,
                        shape,
                        slack,
                        against,
                    });
                }
            }
            // Of arcs on planes none is made, which takes longest.
            let c = match source {
                Some(source) => &uv_curve(brep, *source),
                None => &borders[index],
            };
            let Some(ends) = segment(c) else {
                if !c.trim.is_some_and(stays_inside) {
                    return None;
                }
                out.others.push(index);
                out.other_trims.extend(c.trim.or(c.after));
                continue;
            };
            let of = Of::new(c.trim, c.after);
            let moved = ends.map(|p| [0, 1].map(|k| clamp(p[k], domain[k])));
            // On a plane a ball may reach across the border (see above).
            let is_plane = matches!(out.surface, ClosedSurface::Plane(_));
            let proven = |x: Ball<Dd>, d: Interval| {
                let [low, high] = limits(x);
                low >= Dd::from(d.start) && high <= Dd::from(d.end)
            };
            let all_proven = { moved.iter() }.all(|p| (0..2).all(|k| proven(p[k], domain[k])));
            if !(all_proven || is_plane && !whole_domain) {
                return None;
            }
            let was_moved = (0..2).any(|e| (0..2).any(|k| moved[e][k].mid != ends[e][k].mid));
            let whole = !was_moved
                || (0..2).any(|k| moved[0][k].mid == moved[1][k].mid && moved[0][k].rad == 0.0);
            let point = (0..2).all(|k| {
                moved[0][k].mid == moved[1][k].mid && moved[0][k].rad + moved[1][k].rad == 0.0
            });
            if point {
                let at = out.surface.point(moved[0].map(|x| x.mid.hi));
                let mut curve = ClosedCurve::segment(at, at, moved, of);
                curve.moved = was_moved;
                out.curves.push(curve);
                continue;
            }
            match out.surface.image(moved, of) {
                Some(mut curve) if whole => {
                    curve.moved = was_moved || !all_proven;
                    out.curves.push(curve);
                }
                // Borders of a domain without loops are no pieces: nothing else would search them.
                _ if was_moved || whole_domain => return None,
                _ => {
                    out.others.push(index);
                    out.other_trims.extend(c.trim.or(c.after));
                }
            }
        }
        out.curves.shrink_to_fit();
        out.others.shrink_to_fit();
        out.other_trims.sort_unstable();
        out.other_trims.dedup();
        out.other_trims.shrink_to_fit();
        out.nearly.shrink_to_fit();
        out.any_moved = out.curves.iter().any(|c| c.moved);
        out.parts = parts_of(&out.curves);
        out.bunches = (out.curves.len() > bunches::FEW).then(|| {
            let slack = out.surface.pole_slack();
            let box_of = |c: &ClosedCurve| match c.shape.get() {
                Some(shape) => shape.bounds(),
                // For this alone it is not kept.
                None => out.surface.straight(c.uv).bounds(),
            };
            let boxes = out.curves.iter().map(box_of);
            Bunches::new(boxes.map(|b| Some(super::widened(&b, slack))))
        });
        Some(out)
    }

    /// The shape of one of the [`curves`](Self::curves).
    #[inline]
    pub(crate) fn shape<'a>(&self, curve: &'a ClosedCurve) -> &'a CurveShape {
        curve.shape.get_or_init(|| self.surface.straight(curve.uv))
    }

    /// The whole image of a trim, where it is one segment or arc.
    pub(crate) fn image_of(&self, trim: usize) -> Option<ClosedImage<'_>> {
        let [curve] = self.curves_of(Of::Trim(trim as u32)) else {
            return None;
        };
        let whole = self.other_trims.binary_search(&trim).is_err();
        whole.then(|| self.image(curve))
    }

    /// The same where it is nearly one, too: for distances that need no more digits than f64 has.
    pub(crate) fn nearly_image_of(&self, trim: usize) -> Option<ClosedImage<'_>> {
        self.image_of(trim).or_else(|| {
            let found = self.nearly.iter().find(|n| n.trim == trim)?;
            Some(ClosedImage {
                shape: &found.shape,
                against: found.against,
                slack: found.slack,
            })
        })
    }

    /// The image of the segment that joins a trim to the next, likewise: `Err` where it is not in closed form, or
    /// may not be.
    pub(crate) fn join_of(&self, trim: usize) -> Result<Option<ClosedImage<'_>>, ()> {
        if self.other_trims.binary_search(&trim).is_ok() {
            return Err(());
        }
        let found = self.curves_of(Of::JoinAfter(trim as u32)).first();
        Ok(found.map(|c| self.image(c)))
    }

    fn image<'a>(&'a self, curve: &'a ClosedCurve) -> ClosedImage<'a> {
        ClosedImage {
            shape: self.shape(curve),
            against: curve.against,
            slack: self.surface.pole_slack(),
        }
    }

    fn curves_of(&self, of: Of) -> &[ClosedCurve] {
        let found = self.parts.binary_search_by_key(&of, |(own, _)| *own);
        let range = found.map_or(0..0, |i| self.parts[i].1.clone());
        &self.curves[range.start as usize..range.end as usize]
    }

    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> usize {
        let shapes = self.curves.iter().filter_map(|c| c.shape.get());
        size_of::<Self>()
            + self.curves.capacity() * size_of::<ClosedCurve>()
            + shapes.map(CurveShape::bytes).sum::<usize>()
            + self.nearly.capacity() * size_of::<NearlyArc>()
            + { self.nearly.iter() }
                .map(|n| n.shape.bytes())
                .sum::<usize>()
            + (self.others.capacity() + self.other_trims.capacity()) * size_of::<usize>()
            + self.parts.capacity() * size_of::<(Of, Range<u32>)>()
            + self.bunches.as_ref().map_or(0, Bunches::bytes)
    }
}

/// Which curves are parts of what: those of one trim come one after the other.
fn parts_of(curves: &[ClosedCurve]) -> Vec<(Of, Range<u32>)> {
    let mut out: Vec<(Of, Range<u32>)> = Vec::new();
    for (i, c) in (0..).zip(curves) {
        match out.last_mut() {
            Some((of, range)) if *of == c.of => range.end = i + 1,
            _ => out.push((c.of, i..i + 1)),
        }
    }
    out.sort_unstable_by_key(|(of, _)| *of);
    out.shrink_to_fit();
    out
}

/// The trims of which some piece may leave the domain, in order.
fn leaving_trims(region: &TrimRegion) -> Vec<usize> {
    let leaving = region.pieces().filter(|p| !p.inside_domain);
    let trim = |origin: PieceOrigin| match origin {
        PieceOrigin::Trim { trim, .. } => Some(trim),
        PieceOrigin::Join { .. } | PieceOrigin::Domain => None,
    };
    let mut out: Vec<usize> = leaving.filter_map(|p| trim(p.origin)).collect();
    out.sort_unstable();
    out.dedup();
    out
}

/// Whether the whole circle of an arc is in the domain: exactly.
fn circle_inside(arc: &Arc<2>, domain: [Interval; 2]) -> bool {
    (0..2).all(|k| {
        Dd::difference(arc.center[k], arc.radius) >= Dd::from(domain[k].start)
            && Dd::sum(arc.center[k], arc.radius) <= Dd::from(domain[k].end)
    })
}

/// The borders of a domain: they bound the region of a face without loops.
fn borders(domain: [Interval; 2]) -> Vec<UvCurve<Dd>> {
    let [u, v] = domain.map(|d| [d.start, d.end]);
    let corners = [[u[0], v[0]], [u[1], v[0]], [u[1], v[1]], [u[0], v[1]]];
    let point = |[x, y]: [f64; 2]| [Ball::exact(x), Ball::exact(y), Ball::ONE];
    (0..4)
        .map(|i| UvCurve {
            trim: None,
            after: None,
            points: vec![point(corners[i]), point(corners[(i + 1) % 4])],
            span: [0.0; 2],
        })
        .collect()
}

/// Proven bounds, finer than f64.
fn limits(x: Ball<Dd>) -> [Dd; 2] {
    if x.rad == 0.0 {
        return [x.mid; 2];
    }
    let off = (x.rad + 4.0 * Dd::UNIT * x.mid.magnitude()) * (1.0 + 4.0 * f64::EPSILON);
    [x.mid - Dd::from(off), x.mid + Dd::from(off)]
}

/// The nearest number in the domain; the same if it may be in it.
fn clamp(x: Ball<Dd>, domain: Interval) -> Ball<Dd> {
    let [low, high] = limits(x);
    if high < Dd::from(domain.start) {
        Ball::exact(domain.start)
    } else if low > Dd::from(domain.end) {
        Ball::exact(domain.end)
    } else {
        x
    }
}

/// The ends of a straight segment in uv.
fn segment(c: &UvCurve<Dd>) -> Option<[[Ball<Dd>; 2]; 2]> {
    let [a, b] = c.points.as_slice() else {
        return None;
    };
    let plain = |w: Ball<Dd>| w.rad == 0.0 && w.mid == Dd::ONE;
    (plain(a[2]) && plain(b[2])).then_some([[a[0], a[1]], [b[0], b[1]]])
}

impl ClosedSurface {
    /// The closed form of a surface; `None` where it has none.
    pub(super) fn new(surface: &Surface, size: f64, recognise: bool) -> Option<Self> {
        Some(match surface {
            Surface::Plane(s) => Self::Plane(Box::new(PlaneForm::new(s)?)),
            Surface::Revolution(s) => Self::Revolution(Box::new(RevolutionForm::new(s, size)?)),
            Surface::Nurbs(s) if recognise => Self::Plane(Box::new(PlaneForm::recognised(s)?)),
            Surface::Sum(_) | Surface::Nurbs(_) => return None,
        })
    }

    /// The sphere that it is on, if it is.
    pub(crate) fn sphere(&self) -> Option<&SphereForm> {
        match self {
            Self::Plane(_) => None,
            Self::Revolution(r) => r.sphere.as_ref(),
        }
    }

    /// What it is called; of what lies near two kinds, one.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Plane(_) => "plane",
            Self::Revolution(r) => r.name(),
        }
    }

    /// The image of a straight segment in uv, where it is a segment or an arc.
    fn image(&self, ends: [[Ball<Dd>; 2]; 2], of: Of) -> Option<ClosedCurve> {
        match self {
            Self::Plane(p) => Some(p.segment(ends, of)),
            Self::Revolution(r) => r.iso_curve(ends, of),
        }
    }

    /// The segment between the images of the ends of a path in uv (of a circle, a point: its arcs are made with the face).
    fn straight(&self, uv: UvPath) -> CurveShape {
        let ends = match uv {
            UvPath::Straight(ends) => ends,
            UvPath::Circle { center, .. } => [center; 2],
        };
        let [a, b] = ends.map(|p| self.point(p));
        CurveShape::segment(a, b)
    }

    /// How far a boundary curve may be from the true one, and a minimum over it, as a length: a pole is taken for a point. All others are exact: parallels and
    /// meridians are made of the profile's own points, skew or not.
    pub(crate) fn pole_slack(&self) -> f64 {
        match self {
            Self::Plane(_) => 0.0,
            Self::Revolution(r) => r.pole_slack,
        }
    }

    /// A proven lower bound of the target on the whole surface.
    pub(crate) fn least(&self, target: &Target) -> Dd {
        match self {
            Self::Plane(p) => p.least(target),
            Self::Revolution(r) => r.least(target),
        }
    }

    /// Where the objective can have a local minimum within the surface's domain; `None` for nowhere. From numbers in f64.
    pub(crate) fn critical(&self, target: &Target) -> Option<Critical> {
        match self {
            Self::Plane(p) => p.critical(target),
            Self::Revolution(r) => r.critical(target),
        }
    }

    /// The same from numbers in double-double.
    pub(crate) fn critical_fine(&self, target: &Target) -> Option<Critical> {
        match self {
            Self::Plane(p) => p.critical_fine(target),
            Self::Revolution(r) => r.critical_fine(target),
        }
    }

    /// The same minimum with its value to the last digits, of one that is [sharp](Critical::sharp).
    pub(crate) fn sharpened(&self, target: &Target, found: &Critical) -> Minimum {
        match self {
            Self::Plane(p) => p.sharpened(target, found),
            Self::Revolution(r) => r.sharpened(target, found),
        }
    }

    /// Bounds of what is least at a foot in the face's region whose boxes are, where the form is not quite the surface that it was made of; see [`RevolutionForm::at_foot`].
    pub(crate) fn at_foot(
        &self,
        surface: &Surface,
        target: &Target,
        found: &Critical,
    ) -> Option<[Dd; 2]> {
        match (self, surface) {
            (Self::Revolution(r), Surface::Revolution(s)) => r.at_foot(s, target, found),
            _ => None,
        }
    }

    /// The point at native parameters, with a bound.
    pub(crate) fn point(&self, uv: [f64; 2]) -> V3 {
        match self {
            Self::Plane(p) => p.point(uv.map(Ball::exact)),
            Self::Revolution(r) => r.point(uv),
        }
    }

    /// A vector along `S_u x S_v` at native parameters, rounded; zero at a pole.
    pub(crate) fn normal(&self, uv: [f64; 2]) -> [f64; 3] {
        match self {
            Self::Plane(p) => p.normal.map(|x| x.mid.hi),
            Self::Revolution(r) => r.normal(uv),
        }
    }
}
