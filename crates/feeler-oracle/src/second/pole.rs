//! A minimum at a pole: a side of a face's domain that is one point in space.
//!
//! All derivatives along that side vanish there, so that they tell neither that f rises from it in every direction nor
//! that it falls. Instead the pole is enclosed.
//!
//! **Theorem.** Let one side of a face's domain be, in space, within a box P; let B be the band of the domain between that
//! side and a line L parallel to it. Suppose that
//! 1. B belongs to the face;
//! 2. f on L is larger than at some point of the side;
//! 3. every place of [`Spot`]s in B that does not fall lies within `join` of P.
//!
//! Then f has a local minimiser over the face within `join` of P, at a place that does not fall, and no other in B.
//!
//! **Proof.** B is compact, so f has a least value over it, attained at x say. By 2 that is less than f on L, so x is in
//! B without L, which is open in the domain and so, by 1, in the face: x is a local minimiser over the face. All
//! of these with f up to the limit are places that were found (`contacts`), and places that fall are none.
//!
//! Loops that leave or enter the domain by no more than rounding run on its sides here, as in `contacts`.

use super::contacts::{RAGGED, Spot, least_apart, most_apart};
use super::number::{Ball, Interval64, Number};
use super::region::Place;
use super::search::{Goal, Kind, Scene};
use super::standing::Standing;

/// Widths of bands that are tried, as parts of the domain, from wide to narrow: the theorem decides whether one serves, so they are steps
/// of a search and no tolerance. Wide ones stand out from the pole, narrow ones keep clear of loops and of other minima.
const BANDS: [f64; 5] = [0.1, 0.03, 0.01, 1e-3, 1e-4];
/// Parts of the line L, or of the loops, that are looked at.
const PARTS: usize = 4000;
/// Boxes that hold the band in space, for each of the surface's ranges along it.
const BOXES: u32 = 8;

type Box3 = [[f64; 2]; 3];

/// A side of a face's domain where parameter `fixed` has one value.
struct Side {
    fixed: usize,
    /// At the domain's end, not its start.
    last: bool,
    /// All of it, in space.
    at: [Interval64; 3],
}

fn box_of(p: &[Interval64; 3]) -> Box3 {
    p.each_ref().map(|x| [x.lo(), x.hi()])
}

impl Scene<'_> {
    /// The places of a face, where those next to a pole are taken as one that stands if a minimum there is proven.
    pub(super) fn with_poles(
        &self,
        goal: &Goal,
        face: usize,
        limit: f64,
        join: f64,
        mut spots: Vec<Spot>,
    ) -> Vec<Spot> {
        for side in self.poles(face, join) {
            let pole = box_of(&side.at);
            let f = goal.value(&side.at);
            let near = |s: &Spot| most_apart(&s.box64(), &pole) <= join;
            let (beside, others): (Vec<_>, Vec<_>) = spots.into_iter().partition(near);
            let proven = f.hi() <= limit
                && !beside.iter().any(|s| s.deep)
                && BANDS
                    .iter()
                    .any(|share| self.is_enclosed(goal, face, &side, *share, &f, &others));
            let mut may_be = beside
                .iter()
                .filter(|s| s.standing != Standing::Falls)
                .cloned();
            spots = others;
            match (proven, may_be.next()) {
                (true, Some(first)) => spots.push(may_be.fold(
                    Spot {
                        standing: Standing::Stands,
                        pole: true,
                        ..first
                    },
                    |all, s| Spot {
                        at: std::array::from_fn(|k| all.at[k].hull(&s.at[k])),
                        f: all.f.hull(&s.f),
                        ..all
                    },
                )),
                _ => spots.extend(beside),
            }
        }
        spots
    }

    /// The sides of the domain that are one point in space, nearly.
    fn poles(&self, face: usize, join: f64) -> Vec<Side> {
        let domain = self.faces[face].shape.domain;
        let mut all = Vec::new();
        for (fixed, last) in [(0, false), (0, true), (1, false), (1, true)] {
            let value = if last {
                domain[fixed].end
            } else {
                domain[fixed].start
            };
            let here = |kind: &Kind| match kind {
                Kind::Iso { fixed: f, at } => {
                    *f == fixed && at.is_point() && at.center() == Ball::exact(value).center()
                }
                _ => false,
            };
            let parts = self
                .seeds
                .iter()
                .filter(|s| s.face == face && here(&s.kind));
            let at = parts
                .map(|s| s.bounds)
                .reduce(|a, b| std::array::from_fn(|k| a[k].hull(&b[k])));
            if let Some(at) = at
                && at.iter().all(|x| x.hi() - x.lo() <= join / 4.0)
            {
                all.push(Side { fixed, last, at });
            }
        }
        all
    }

    /// Whether the theorem's conditions hold for the band that is this share of the domain; `f` holds the pole's value.
    fn is_enclosed(
        &self,
        goal: &Goal,
        face: usize,
        side: &Side,
        share: f64,
        f: &Interval64,
        others: &[Spot],
    ) -> bool {
        let domain = self.faces[face].shape.domain[side.fixed];
        let length = domain.end - domain.start;
        let (border, line) = if side.last {
            (domain.end, domain.end - share * length)
        } else {
            (domain.start, domain.start + share * length)
        };
        let band = Interval64::new(border.min(line), border.max(line));
        self.band_belongs(face, side, &band)
            && self.rises_to(goal, face, side.fixed, line, f)
            && self.band_boxes(face, side.fixed, &band).is_some_and(|all| {
                others.iter().all(|s| {
                    let at = s.box64();
                    s.standing == Standing::Falls || all.iter().all(|b| least_apart(b, &at) > 0.0)
                })
            })
    }

    fn with_fixed(fixed: usize, at: Interval64, along: Interval64) -> [Interval64; 2] {
        if fixed == 0 { [at, along] } else { [along, at] }
    }

    /// The surface's ranges along a side.
    fn ranges_along(&self, face: usize, fixed: usize) -> Vec<Interval64> {
        let ranges = self.faces[face].shape.ranges[1 - fixed].iter();
        ranges
            .map(|r| Interval64::of(&r.from).hull(&Interval64::of(&r.to)))
            .collect()
    }

    /// Condition 2: f on the line is above `f`; by the mean value form, which holds across knots too.
    fn rises_to(&self, goal: &Goal, face: usize, fixed: usize, line: f64, f: &Interval64) -> bool {
        let shape = &self.faces[face].shape;
        let mut stack = self.ranges_along(face, fixed);
        let mut budget = PARTS;
        while let Some(x) = stack.pop() {
            if budget == 0 {
                return false;
            }
            budget -= 1;
            let middle = x.middle();
            let at = |x: Interval64| {
                shape.jet_across(&Self::with_fixed(fixed, Interval64::exact(line), x))
            };
            let (Some(over), Some(there)) = (at(x), at(middle)) else {
                return false;
            };
            let slope = goal.first(&over.p, if fixed == 0 { &over.v } else { &over.u });
            let formed = goal.value(&there.p).plus(&slope.times(&x.minus(&middle)));
            if f.below(&goal.value(&over.p)) || f.below(&formed) {
                continue;
            }
            if !(x.lower().below(&middle) && middle.below(&x.upper())) {
                return false;
            }
            stack.extend([x.lower().hull(&middle), middle.hull(&x.upper())]);
        }
        true
    }

    /// Boxes that hold the band in space.
    fn band_boxes(&self, face: usize, fixed: usize, band: &Interval64) -> Option<Vec<Box3>> {
        let shape = &self.faces[face].shape;
        let mut all = Vec::new();
        for range in self.ranges_along(face, fixed) {
            let (from, length) = (range.lo(), range.hi() - range.lo());
            for i in 0..BOXES {
                let end = |i: u32| from + length * f64::from(i) / f64::from(BOXES);
                // The parts' ends are the same numbers, so that nothing is left out between them.
                let last = if i + 1 == BOXES {
                    range.hi()
                } else {
                    end(i + 1)
                };
                let uv = Self::with_fixed(fixed, *band, Interval64::new(end(i), last));
                all.push(box_of(&shape.jet_across(&uv)?.p));
            }
        }
        Some(all)
    }

    /// Condition 1: no loop enters the band but along the sides of the domain, and a point of it is inside.
    fn band_belongs(&self, face: usize, side: &Side, band: &Interval64) -> bool {
        let parts = &self.faces[face];
        let (domain, lengths) = (parts.shape.domain, self.lengths(face));
        let [along, fixed] = [1 - side.fixed, side.fixed];
        let middle = domain[along].start + 0.5 * (domain[along].end - domain[along].start);
        let inner = Self::with_fixed(fixed, band.middle(), Interval64::exact(middle));
        if parts.region.place(&inner) != Place::Inside {
            return false;
        }
        let slack = lengths.map(|l| RAGGED * l);
        // On a side: never farther from it than the slack, on whichever side of it.
        let on_side = |p: &[Ball; 2]| {
            p[along].hi() <= domain[along].start + slack[along]
                || p[along].lo() >= domain[along].end - slack[along]
                || if side.last {
                    p[fixed].lo() >= domain[fixed].end - slack[fixed]
                } else {
                    p[fixed].hi() <= domain[fixed].start + slack[fixed]
                }
        };
        let mut budget = PARTS;
        for (i, arc) in parts.region.arcs.iter().enumerate() {
            let mut stack = vec![(0.0, 1.0)];
            while let Some((a, b)) = stack.pop() {
                if budget == 0 {
                    return false;
                }
                let part = parts.region.part(i, &Interval64::new(a, b));
                if part.lo[fixed] > band.hi() || part.hi[fixed] < band.lo() {
                    continue;
                }
                budget -= 1;
                let (from, to) = (Ball::exact(a), Ball::exact(b));
                let there = arc.piece.jet(&from.hull(&to));
                if there.is_some_and(|c| on_side(&c.p)) {
                    continue;
                }
                let m = 0.5 * (a + b);
                if !(a < m && m < b) {
                    return false;
                }
                stack.extend([(a, m), (m, b)]);
            }
        }
        true
    }
}
