//! Boundary curves and pieces in line for the search: one by one, or by the bunch where there are many.
//!
//! No point of what is in a bunch is outside of its box, so that what bounds `f` there bounds it on all of these. Of a piece that is so for what lies on its patch: the rest
//! does not matter (see [`Piece`](crate::prepare::Piece)).

use super::front::Part;
use super::outcome::Source;
use super::search::Search;
use super::task::{Arithmetic, Bunched, Kind, Task};
use crate::numeric::{Dd, Real};
use crate::prepare::{Bunch, Bunches, Within};
use std::collections::BinaryHeap;
use std::ops::Range;

impl Search<'_> {
    /// The boundary pieces of a face, or bunches of them: those of curves that are not searched in closed form.
    pub(super) fn push_pieces<T: Real + Arithmetic>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        face: usize,
        lo: Dd,
        covered: bool,
    ) {
        if let Some(bunches) = self.brep.double(face).bunches() {
            return self.push_bunches(heap, bunches, (face, Bunched::Pieces), lo, covered);
        }
        let all = 0..self.brep.double(face).piece_count();
        self.push_some_pieces(heap, face, lo, covered, all);
    }

    fn push_some_pieces<T: Real + Arithmetic>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        face: usize,
        lo: Dd,
        covered: bool,
        pieces: Range<usize>,
    ) {
        let geometry = T::geometry(self.brep, face);
        let brep = self.brep;
        let form = brep.closed(face).filter(|_| self.goal.closed);
        let boxes = brep.double(face).piece_boxes();
        for index in pieces {
            let curve = geometry.piece_curve(index);
            if form.is_some_and(|f| f.others.binary_search(&curve).is_err()) {
                continue;
            }
            let own = boxes[index].as_ref().map_or(lo, |b| self.box_bound(b));
            let lo = if own > lo { own } else { lo };
            self.push(heap, lo, covered, Kind::Root(Source::Piece { face, index }));
        }
    }

    /// All of what is in bunches.
    pub(super) fn push_bunches<T>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        bunches: &Bunches,
        of: (usize, Bunched),
        lo: Dd,
        covered: bool,
    ) {
        for bunch in bunches.highest() {
            self.push_bunch(heap, bunches, of, bunch, (lo, covered));
        }
    }

    fn push_bunch<T>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        bunches: &Bunches,
        (face, of): (usize, Bunched),
        bunch: Bunch,
        (lo, covered): (Dd, bool),
    ) {
        let own = bunches.bounds(bunch).map_or(lo, |b| self.box_bound(b));
        let lo = if own > lo { own } else { lo };
        self.push(heap, lo, covered, Kind::Bunch(face, of, bunch));
    }

    /// Puts what is in a bunch in line, or looks at it.
    pub(super) fn open_bunch<T: Real + Arithmetic>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        (face, of, bunch): (usize, Bunched, Bunch),
        lo: Dd,
        covered: bool,
    ) {
        let (brep, form) = (self.brep, self.brep.closed(face));
        let bunches = match of {
            Bunched::Curves => form.and_then(|f| f.bunches.as_ref()),
            Bunched::Pieces => brep.double(face).bunches(),
        };
        match (bunches.map(|b| (b, b.within(bunch))), of) {
            (Some((bunches, Within::Bunches(more))), _) => {
                for bunch in more {
                    self.push_bunch(heap, bunches, (face, of), bunch, (lo, covered));
                }
            }
            (Some((_, Within::Things(pieces))), Bunched::Pieces) => {
                self.push_some_pieces(heap, face, lo, covered, pieces);
            }
            (Some((_, Within::Things(curves))), Bunched::Curves) => {
                if let Some(form) = form {
                    self.open_curves(form, face, lo, curves);
                }
            }
            (None, _) => {}
        }
    }

    /// Writes down what is in a bunch: of curves in closed form their face is.
    pub(super) fn leave_bunch(
        &mut self,
        (face, of, bunch): (usize, Bunched, Bunch),
        lo: Dd,
        covered: bool,
    ) {
        if covered || of == Bunched::Curves {
            return;
        }
        let bunches = self.brep.double(face).bunches();
        for index in bunches.into_iter().flat_map(|b| b.all_within(bunch)) {
            self.leave(lo, covered, Part::Root(Source::Piece { face, index }));
        }
    }
}
