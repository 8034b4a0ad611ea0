//! Faces in closed form within the search.
//!
//! # All minima
//! Where all local minima are asked for, one on a face in closed form is in the face's interior, where there is one at most (a curve, or all of it, where
//! the formula is not unique: then any of its points stands for it), or on a curve that bounds the face. Where it is a local minimum on
//! the face it is one along the curve. A squared distance along a segment is convex: it has one. Along an arc it is, as a height is, a sine of the
//! angle: one where that is least, if it is on the arc, else and beside it the ends. A height along a segment is least at an end. Of a curve that was moved
//! into the domain only parts may be in the region; they end where others do: all ends count. Other curves are
//! searched. Which of these candidates are minima is looked at where the list is made (module `local`).

use super::outcome::{Foot, FormulaMinimum, Locus, Settled, Spread};
use super::place::ON_VERTEX;
use super::search::{QUARTER, Search};
use super::task::{Arithmetic, Bunched, Task};
use super::upper::{NEIGHBOURS, step_ulp};
use super::whole_faces::place_inside;
use crate::numeric::{Dd, Real};
use crate::prepare::PreparedBrep;
use crate::prepare::closed::{Boxes, ClosedCurve, ClosedFace, Critical, Minimum, lead, widened};
use crate::trim::{BoxSide, Side};
use nalgebra::{Point2, Point3};
use std::collections::BinaryHeap;
use std::ops::Range;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 16.0 * f64::EPSILON;

impl Search<'_> {
    /// The closed form of a face, where it serves.
    pub(super) fn closed(&self, face: usize) -> Option<&ClosedFace> {
        self.brep.closed(face).filter(|_| self.goal.closed)
    }

    /// Whether all minima are asked for.
    fn is_listing(&self) -> bool {
        self.goal.all_below.is_some() && self.goal.extents.is_none()
    }

    /// Puts down what may be a minimum, where all are asked for.
    fn list(&mut self, face: usize, trim: Option<usize>, minimum: &Minimum, here: [Dd; 2]) {
        let wanted = self.is_listing() && !self.hopeless(minimum.range[0]);
        if wanted {
            self.out.formulas.push(FormulaMinimum {
                face,
                trim,
                uv: Point2::new(minimum.uv[0], minimum.uv[1]),
                point: minimum.point,
                range: minimum.range,
                here,
            });
        }
    }

    pub(super) fn open_closed<T: Real + Arithmetic>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        face: usize,
        lo: Dd,
    ) {
        let brep = self.brep;
        let Some(form) = brep.closed(face) else {
            return;
        };
        self.out.used_closed = true;
        if let Some((minimum, side)) = self.interior(face, form) {
            if side != BoxSide::Outside {
                // The face's box bounds it too.
                let least = if lo > minimum.range[0] {
                    lo
                } else {
                    minimum.range[0]
                };
                self.settle_closed(face, least, &minimum, 0.0);
            }
            match side {
                BoxSide::Inside => {
                    self.keep_closed(face, None, &minimum);
                    self.list(face, None, &minimum, minimum.range);
                    if !self.is_listing() {
                        return;
                    }
                }
                BoxSide::Mixed => self.try_closed_point(face, form, &minimum),
                BoxSide::Outside => {}
            }
        }
        match &form.bunches {
            None => self.open_curves(form, face, lo, 0..form.curves.len()),
            Some(bunches) => {
                self.push_bunches(heap, bunches, (face, Bunched::Curves), lo, true);
            }
        }
        if !form.others.is_empty() {
            self.push_pieces::<T>(heap, face, lo, true);
        }
    }

    /// Looks at some of the curves that bound a face.
    pub(super) fn open_curves(
        &mut self,
        form: &ClosedFace,
        face: usize,
        lo: Dd,
        curves: Range<usize>,
    ) {
        let slack = form.surface.pole_slack();
        for curve in &form.curves[curves] {
            let shape = form.shape(curve);
            let least = widened(&self.target, [shape.least(&self.target); 2], slack)[0];
            if self.hopeless(least) {
                continue;
            }
            let mut minimum = curve.minimum(shape, &self.target);
            minimum.range = widened(&self.target, minimum.range, slack);
            if self.hopeless(minimum.range[0]) {
                continue;
            }
            if self.is_listing() {
                self.list_curve(form, face, curve, &minimum);
            }
            if !curve.moved || self.place_on_face(face, &minimum) == BoxSide::Inside {
                self.keep_closed(face, self.trim_of(curve, &minimum), &minimum);
            } else {
                self.try_closed_point(face, form, &minimum);
            }
            let least = if lo > minimum.range[0] {
                lo
            } else {
                minimum.range[0]
            };
            self.settle_closed(face, least, &minimum, slack);
        }
    }

    /// The same of a curve: its least, and its ends where they may be local minima (all, where some curve was moved). What was moved into the domain counts where
    /// it may be in the region.
    fn list_curve(&mut self, form: &ClosedFace, face: usize, curve: &ClosedCurve, least: &Minimum) {
        let (target, slack) = (self.target, form.surface.pole_slack());
        let shape = form.shape(curve);
        let mut ends = curve.ends(shape, &target);
        let low = form.any_moved || shape.may_end_low(&target, &ends);
        for end in &mut ends {
            end.range = widened(&target, end.range, slack);
        }
        let ends = ends.iter().filter(|_| low);
        for found in ends.chain([least]) {
            if !curve.moved || self.place_on_face(face, found) != BoxSide::Outside {
                self.list(face, self.trim_of(curve, found), found, found.range);
            }
        }
    }

    /// The trim that a place on a curve is on. On a segment that joins two trims it is on the one before if the vertex between them is next to it: what is there
    /// belongs to neither, and may be a rounding within the region, as if it were on no border.
    fn trim_of(&self, curve: &ClosedCurve, at: &Minimum) -> Option<usize> {
        let Some(trim) = curve.of.trim_before() else {
            return curve.of.trim();
        };
        let parts = self.brep.brep().parts();
        let vertex = parts.vertices[parts.trims[trim].vertices[1]].point;
        let point = Point3::from(at.point.map(|x| x.mid.hi));
        ((point - vertex).norm() <= ON_VERTEX * self.brep.size()).then_some(trim)
    }

    /// The minimum in a face's interior, if there may be one, and whether its place is in the region.
    ///
    /// Numbers in f64 tell most places from the borders, and bound the value to nearly all of f64's digits; where that is not
    /// enough, double-double does. What either says is proven, so what the one leaves open the other may settle.
    fn interior(&self, face: usize, form: &ClosedFace) -> Option<(Minimum, BoxSide)> {
        let target = &self.target;
        let rough = form.surface.critical(target)?;
        let side = boxes_side(self.brep, face, &rough.boxes);
        let beside = side == BoxSide::Outside || self.hopeless(rough.minimum.range[0]);
        let sharp = side == BoxSide::Inside && rough.sharp;
        if beside || sharp && self.is_fine(&rough.minimum) {
            return Some((rough.minimum, side));
        }
        if sharp {
            let minimum = form.surface.sharpened(target, &rough);
            return Some((self.at_foot((face, form), &rough, minimum), side));
        }
        let mut fine = form.surface.critical_fine(target)?;
        let side = match boxes_side(self.brep, face, &fine.boxes) {
            BoxSide::Mixed if fine.minimum.unique => {
                self.side_of_foot(face, form, &mut fine.minimum)
            }
            BoxSide::Inside => {
                let minimum = self.at_foot((face, form), &fine, fine.minimum);
                return Some((minimum, BoxSide::Inside));
            }
            side => side,
        };
        Some((fine.minimum, side))
    }

    /// A minimum whose boxes are in the region, known by the surface itself where the formula's model of it is not enough.
    fn at_foot(
        &self,
        (face, form): (usize, &ClosedFace),
        found: &Critical,
        mut minimum: Minimum,
    ) -> Minimum {
        if !self.is_fine(&minimum)
            && let Some([low, high]) =
                form.surface
                    .at_foot(self.brep.brep().surface(face), &self.target, found)
        {
            let [l, h] = minimum.range;
            minimum.range = [
                if low > l { low } else { l },
                if high < h { high } else { h },
            ];
        }
        minimum
    }

    /// Whether a foot is in the region, where boxes of f64 do not tell: by its parameters in double-double. Of their copies at whole turns it is then told by the one that is.
    fn side_of_foot(&self, face: usize, form: &ClosedFace, foot: &mut Minimum) -> BoxSide {
        let places = form.surface.places(&foot.point);
        match places.and_then(|p| place_inside(self.brep, face, &p)) {
            Some(Some(uv)) => {
                let domain = self.brep.brep().surface(face).domain();
                foot.uv = [0, 1].map(|k| uv[k].clamp(domain[k].start, domain[k].end));
                BoxSide::Inside
            }
            Some(None) => BoxSide::Outside,
            None => BoxSide::Mixed,
        }
    }

    /// Whether the value of a minimum is known well enough for what is asked.
    fn is_fine(&self, minimum: &Minimum) -> bool {
        let [low, high] = minimum.range;
        let told = self.goal.threshold.is_some_and(|t| high < t || low >= t);
        told || low >= self.near(high, QUARTER)
    }

    /// Where a point of a curve that was moved into the domain is.
    fn place_on_face(&self, face: usize, minimum: &Minimum) -> BoxSide {
        let region = self.brep.region(face);
        let [u, v] = minimum.uv;
        if minimum.uv_off == [0.0; 2] {
            return match region.side(Point2::new(u, v)).side {
                Some(Side::Inside | Side::Boundary) => BoxSide::Inside,
                Some(Side::Outside) => BoxSide::Outside,
                None => BoxSide::Mixed,
            };
        }
        let domain = self.brep.brep().surface(face).domain();
        let b = [0, 1].map(|k| {
            let (x, off) = (minimum.uv[k], minimum.uv_off[k]);
            [(x - off).max(domain[k].start), (x + off).min(domain[k].end)]
        });
        region.classify_box(b[0], b[1])
    }

    /// Keeps the minimum of a face's interior or of a curve, which is within `slack` of its place if that is the only one.
    fn settle_closed(&mut self, face: usize, lo: Dd, minimum: &Minimum, slack: f64) {
        if self.hopeless(lo) {
            return;
        }
        self.lower(lo);
        let spread = minimum.unique.then(|| {
            let point = minimum.point.map(lead);
            let off = slack + point.iter().map(|x| x.rad).sum::<f64>();
            Spread::At {
                point: point.map(|x| x.mid),
                off: off * UP,
            }
        });
        self.out.settled.push(Settled {
            face,
            source: None,
            lo,
            at: minimum.uv,
            spread,
            extent: minimum.extent,
            local_minimum: true,
            on_border: false,
            flat: false,
        });
    }

    fn keep_closed(&mut self, face: usize, trim: Option<usize>, minimum: &Minimum) {
        if minimum.range[1] < self.out.hi {
            self.out.hi = minimum.range[1];
            self.out.foot = Some(Foot {
                face,
                trim,
                uv: Point2::new(minimum.uv[0], minimum.uv[1]),
                spot: Locus::Closed {
                    point: minimum.point,
                },
                found: None,
            });
        }
    }

    /// A point in f64 next to the minimum that the exact test finds in the region.
    fn try_closed_point(&mut self, face: usize, form: &ClosedFace, minimum: &Minimum) {
        let domain = self.brep.brep().surface(face).domain();
        for (du, dv) in NEIGHBOURS {
            let uv = [step_ulp(minimum.uv[0], du), step_ulp(minimum.uv[1], dv)];
            if !(0..2).all(|k| domain[k].contains(uv[k])) {
                continue;
            }
            let side = self.brep.region(face).side(Point2::new(uv[0], uv[1])).side;
            if !matches!(side, Some(Side::Inside | Side::Boundary)) {
                continue;
            }
            let point = form.surface.point(uv);
            let here = self.target.range_at(&point);
            let tried = Minimum {
                range: [minimum.range[0], here[1]],
                point,
                uv,
                uv_off: [0.0; 2],
                unique: false,
                extent: minimum.extent,
            };
            // Where not even the place of the minimum is known (at a pole, where it has any azimuth) this one may be far from it, and far above.
            let here = if self.is_fine(&tried) {
                tried.range
            } else {
                here
            };
            self.list(face, None, &tried, here);
            return self.keep_closed(face, None, &tried);
        }
    }
}

/// Where some of the boxes of native parameters, which together hold one point's copies, lie.
pub(super) fn boxes_side(brep: &PreparedBrep, face: usize, boxes: &Boxes) -> BoxSide {
    let domain = brep.brep().surface(face).domain();
    let mut all_out = true;
    for b in boxes.iter() {
        let within = (0..2).all(|k| domain[k].start <= b[k][0] && b[k][1] <= domain[k].end);
        match brep.region(face).classify_box(b[0], b[1]) {
            BoxSide::Inside if within => return BoxSide::Inside,
            BoxSide::Outside => {}
            _ => all_out = false,
        }
    }
    if all_out {
        BoxSide::Outside
    } else {
        BoxSide::Mixed
    }
}
