//! What edges make of a line's hits: which count once, and whether the line slips through a crack.
//!
//! # Definitions
//! An edge of two images or more has a crack of width `d`, the largest Frechet distance of two of them. The line is *in the crack* where it
//! is within `d` of an image. A *passage* is all of these stretches of the line that are no farther than `d` apart from the next. Hits
//! in one passage are linked and count once, through whatever others; a hit in no passage counts once where it crosses. The line
//! is `in_crack` if some passage has no hit. What is beyond the ends of a ray or a segment does not count.
//!
//! # What is proven
//! `d` is known to be in `[least, most]`. The images are cut into parts short against the width. A part farther than `most` is put aside.
//! Of the others the projection to the line is known: a point of the line within `d` of a point of the part is within
//! `most` of it. A part is *sure* if it is within `least`: then its projection is in the crack.
//!
//! - Parts whose projections are more than `3 most` apart are of different passages: those about each reach no farther than `most`
//!   beyond it, and are then more than `most >= d` apart. So the parts fall into groups, with one passage each, several, or none.
//! - A group is *one* passage if its sure parts are no farther apart than `least`, and no other part is farther than that from one
//!   of them: whatever is in the crack is then within `least <= d` of something that surely is. Where this is asked, parts are no longer than a
//!   [`SHORT`]th of `least`, which is allowed for.
//! - Images that are one segment, exactly, have no crack: `d` is zero.
//! - *Stretches.* A point of one image is within `d` of each other one. What is in the crack by an image that is a segment is one stretch of the line, as the distance from a
//!   segment is convex along it. Let an image `C` be part of a circle of radius `r` about an axis that the line is orthogonal to, and the line, at distance `rho` from the axis
//!   and height `h` from the plane of the circle, run away from the foot of the axis, so that `rho` grows. The set `K` of `|rho - r| <= sqrt(d^2 - h^2)`,
//!   within `d` of the circle, is an interval. A point of `K` that is seen from the axis in the direction of a point of `C` is within `d` of that. The direction turns by less than a quarter in all.
//!   Where it passes an end of `C` the point is within `d` of this end; what is within `d` of an end is an interval, and in `K`. So if no end is within `d` of the line, all
//!   directions over `K` are of points of `C`, or none is; if one is, what is within `d` of `C` is an interval of `K` and one about that end that meet. If the line meets the axis
//!   the direction is one: of a point of `C`, then all of `K` counts; or of none: then with ends at angles `e <= f` from it, below a quarter, `(r cos f - r cos e)^2 + (r sin e)^2 <= (r sin f)^2`: if there is
//!   anything within `d` of the one at `f`, then its foot on the line, which is within `d` of the other too. So on either side of the foot of the axis what is in the crack by `C` is one stretch
//!   at most. (An end beyond a quarter is farther than `d` from what is farther than that from the axis.)
//!   Where the line touches the circle at the foot, `rho - r` is nowhere below zero and `K` is one interval about the foot: the same without taking sides. A line along the
//!   axis is at one distance from the axis: squares of distances from points of `C` are `(t - h)^2 |d|^2` and numbers that do not change, and what is within `d` of any is an interval about `h`.
//!   Let `C` be part of any circle of radius `r`, and `m` bound the distances of its points that are within `d` of the line in the group from each other. Suppose `x_1` and `x_2` on the line
//!   are within `d` of `c_1`, `c_2` in `C`, and nothing between them is of any point of `C`. The arc from `c_1` to `c_2` is in `C`, if not both ends of `C` are within `m` of these. It is within `s <= |c_1
//!   c_2|^2 / (4 r)` of its chord. The middles of `x_1 x_2` and of the chord are no nearer than `d - s`, but no farther than the root of `d^2 - |e|^2 / 4` with `e = (x_2 - x_1) - (c_2 - c_1)`: so `|e|^2 < 8 d
//!   s <= 2 d |c_1 c_2|^2 / r`. But `|e|` is no less than `|c_1 c_2|` times the sine of the angle between line and chord. Where this is at least `2 sqrt(2 d / r)` that cannot be. A chord runs
//!   along a tangent of its arc: within `4 m / r` of that next to a place in the group that is within `d` of `C`.
//!   If one place is in all stretches of a group, they are one passage.
//! - A hit is surely in a passage of its group if it is within `least` of an image, surely not if it is farther than `most` from all.
//!
//! The numbers that follow are given where they are the same whatever is not known.

use super::forms::{Forms, Stabber, range};
use super::inside::all_near_edges;
use super::runs::{Run, is_one, runs};
use super::zeros::RawHit;
use crate::numeric::{Ball, Dd, Real};
use crate::prepare::closed::V3;
use crate::prepare::{Course, Image, Meeting, PreparedBrep, Round, SharedEdge, When, distance};
use std::cell::OnceCell;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// Parts are this many times shorter than the width they are compared with.
const SHORT: f64 = 8.0;
/// Where all that is known of a width is that it is no more than `most`, parts are no shorter than this part of that.
const UNKNOWN: f64 = 1.0 / 16.0;

/// What the hits of a line amount to.
pub(super) struct Crossings {
    /// `None` where it is not known.
    pub(super) count: Option<usize>,
    /// `None` where it is not known.
    pub(super) in_crack: Option<bool>,
}

/// A part of an image near the line.
struct Part {
    /// Of the edge's.
    image: usize,
    /// Holds its projection, as a parameter of the line.
    t: [Dd; 2],
    /// Whether it is not short against the width.
    long: bool,
    /// Whether some of it is surely in the crack; no long one is.
    sure: bool,
}

/// Parts of one edge that may make passages, which no others touch.
struct Group {
    /// Holds all passages.
    t: [Dd; 2],
    sure: bool,
    one: bool,
    /// Those that have parts in it.
    images: Vec<usize>,
}

/// Crossings of a line with these hits.
pub(super) fn crossings(
    brep: &PreparedBrep,
    stab: &Stabber,
    hits: &[RawHit],
    budget: &mut usize,
) -> Crossings {
    let mut links = Links::new(hits.len());
    let (mut slips, mut may_slip) = (false, false);
    for shared in all_near_edges(brep, stab, budget) {
        let Some(edge) = Edge::new(brep, stab, shared) else {
            return Crossings {
                count: None,
                in_crack: None,
            };
        };
        let Some(groups) = edge.all_groups(stab, hits, budget) else {
            return Crossings {
                count: None,
                in_crack: None,
            };
        };
        for group in groups {
            let here = group.is_within(stab.range);
            if here == Some(false) {
                continue;
            }
            let (mut members, mut others) = (Vec::new(), Vec::new());
            for (index, hit) in hits.iter().enumerate() {
                // A hit that runs in its face counts where it begins: a line that leaves the face through a crack is flagged.
                let there = group.holds(&hit.t);
                if there == Some(false) {
                    continue;
                }
                match edge.holds(stab, hit) {
                    Some(true) if there.is_some() => members.push(index),
                    Some(false) => {}
                    _ => others.push(index),
                }
            }
            let [covered, together] = if group.one && !members.is_empty() {
                [true, false]
            } else if edge.is_apart(stab) {
                break;
            } else {
                edge.covers(stab, &group, hits)
            };
            links.add(&members, |a, b| {
                let same = match (&hits[a].exact, &hits[b].exact) {
                    (Some(a), Some(b)) => a.t.is(&b.t),
                    _ => false,
                };
                group.one || together || same
            });
            links.hold(&members, &others);
            others.extend(&members);
            links.add(&others, |_, _| false);
            slips |= others.is_empty() && group.sure && here == Some(true);
            may_slip |= !covered && (members.is_empty() || !group.one);
        }
    }
    Crossings {
        count: links.count(hits),
        in_crack: if slips {
            Some(true)
        } else {
            (!may_slip).then_some(false)
        },
    }
}

/// Which hits count once together, and which are in a passage at all: surely, and perhaps.
struct Links {
    sure: Vec<usize>,
    perhaps: Vec<usize>,
    held: Vec<[bool; 2]>,
}

impl Links {
    fn new(count: usize) -> Self {
        Self {
            sure: (0..count).collect(),
            perhaps: (0..count).collect(),
            held: vec![[false; 2]; count],
        }
    }

    /// Hits that may be in one passage, and surely are where `sure` says so.
    fn add(&mut self, hits: &[usize], sure: impl Fn(usize, usize) -> bool) {
        for (i, a) in hits.iter().enumerate() {
            for b in &hits[i + 1..] {
                join(&mut self.perhaps, *a, *b);
                if sure(*a, *b) {
                    join(&mut self.sure, *a, *b);
                }
            }
        }
    }

    /// Hits that are in a passage, and others that may be.
    fn hold(&mut self, members: &[usize], others: &[usize]) {
        for m in members {
            self.held[*m] = [true; 2];
        }
        for o in others {
            self.held[*o][1] = true;
        }
    }

    /// How many there are, if that is the same either way: of linked ones one, of others those that cross.
    fn count(&self, hits: &[RawHit]) -> Option<usize> {
        let touches = |(h, held): (&RawHit, &[bool; 2])| !h.crosses() && held[0] != held[1];
        if hits.iter().zip(&self.held).any(touches) {
            return None;
        }
        let count = |of: &[usize]| {
            let counted = (0..of.len()).filter(|i| hits[*i].crosses() || self.held[*i][0]);
            let mut names: Vec<usize> = counted.map(|i| of[i]).collect();
            names.sort_unstable();
            names.dedup();
            names.len()
        };
        let (most, least) = (count(&self.sure), count(&self.perhaps));
        (most == least).then_some(most)
    }
}

/// Gives all of one name the other's.
fn join(names: &mut [usize], a: usize, b: usize) {
    let (from, to) = (names[a], names[b]);
    for n in names.iter_mut().filter(|n| **n == from) {
        *n = to;
    }
}

/// An edge that the line comes near, with bounds of its crack's width.
struct Edge<'a> {
    images: Vec<&'a Image<Dd>>,
    trims: &'a [usize],
    /// What images are exactly, where that was asked for.
    courses: Vec<OnceCell<Option<Course>>>,
    least: f64,
    most: f64,
    edge: usize,
    brep: Option<&'a PreparedBrep>,
    /// Parameters for a unit of length, rounded up.
    scale: f64,
}

impl<'a> Edge<'a> {
    /// `None` where an image is not known.
    fn new(brep: &'a PreparedBrep, stab: &Stabber, shared: &SharedEdge) -> Option<Self> {
        let trims = &brep.brep().parts().edges[shared.edge].trims;
        let images: Option<Vec<_>> = trims.iter().map(|t| brep.fine_trim_image(*t)).collect();
        let most = brep.fine_crack_width(shared.edge);
        most.is_finite().then_some(Self {
            images: images?,
            trims,
            courses: vec![OnceCell::new(); trims.len()],
            brep: Some(brep),
            edge: shared.edge,
            least: brep.least_crack_width(shared.edge),
            most,
            scale: UP / stab.direction.norm(),
        })
    }

    /// Whether what is in the crack by each image that is near the line in a group is one stretch there that holds the place of a hit: then all passages of the
    /// group have a hit. And whether a hit is in the group that all of these stretches hold: then it is one passage. See the module.
    fn covers(&self, stab: &Stabber, group: &Group, hits: &[RawHit]) -> [bool; 2] {
        let exact = || hits.iter().filter_map(|h| h.exact.as_deref());
        let own = |on: &[usize]| on.iter().any(|t| self.trims.contains(t));
        // The far end of a hit that runs in its face is the place of another hit, or does not count.
        let at = |t: &When| exact().any(|m| m.t.is(t));
        let first = |m: &&Meeting| own(&m.on);
        let last = |m: &Meeting| m.end.clone().filter(|t| own(&m.end_on) && at(t));
        let places = || {
            let first = exact().filter(first).map(|m| m.t.clone());
            first.chain(exact().filter_map(last))
        };
        let held = |t: &When| group.holds(&t.enclosed()) == Some(true);
        let here = places().find(held);
        let anywhere = here.is_some() || places().next().is_some();
        let covered = anywhere
            && group
                .images
                .iter()
                .all(|image| match (self.course(*image), &here) {
                    (Some(Course::Straight), _) => true,
                    (Some(course), Some(t)) => {
                        let level = match course {
                            Course::Round(round) => {
                                let on = |m: &Meeting| m.on.contains(&self.trims[*image]);
                                let touched = |foot: &When| exact().any(|m| on(m) && m.t.is(foot));
                                self.is_one_stretch(stab, group, *image, round, touched)
                            }
                            _ => false,
                        };
                        level || self.is_passed(stab, group, *image, course, t)
                    }
                    _ => false,
                });
        [covered, covered && here.is_some()]
    }

    /// Whether the line passes an image that is part of a circle at an angle, next to a place in a group.
    fn is_passed(
        &self,
        stab: &Stabber,
        group: &Group,
        image: usize,
        course: &Course,
        t: &When,
    ) -> bool {
        let d = stab.direction;
        let p = stab.origin + d * t.enclosed().mid.hi;
        let Some((tangent, radius)) = course.tangent(&p) else {
            return false;
        };
        // Points of the image that count are no farther from each other.
        let span = (group.t[1] - group.t[0]).hi * d.norm() * UP;
        let reach = (span + 2.0 * self.most) * UP;
        let size = p.coords.amax().max(stab.origin.coords.amax());
        let ample = size * f64::EPSILON <= SHARP * radius && 8.0 * self.most <= radius;
        let sine = tangent.cross(&d).norm() / (tangent.norm() * d.norm());
        let turned = SHARP + 4.0 * reach / radius;
        let steep = sine - turned >= 2.0 * (2.0 * self.most / radius).sqrt();
        ample && steep && self.ends_near(stab, image, 2.0 * reach) < 2
    }

    /// How many ends of an image may be within the width, and as much more, of the line.
    fn ends_near(&self, stab: &Stabber, image: usize, more: f64) -> usize {
        let image = self.images[image];
        let near = |p: &V3, slack: f64| {
            let w: V3 = std::array::from_fn(|c| p[c] - Ball::exact(stab.origin[c]));
            let d = stab.direction;
            let away: [f64; 3] = std::array::from_fn(|c| {
                let (i, j) = ((c + 1) % 3, (c + 2) % 3);
                let x = w[i] * Ball::exact(d[j]) - w[j] * Ball::exact(d[i]);
                x.lower().max(-x.upper()).max(0.0)
            });
            let away = away.iter().map(|x| x * x).sum::<f64>().sqrt() * self.scale / UP / UP;
            !(away > (self.most + slack + more) * UP)
        };
        let (Some(first), Some(last)) = (image.stretches.first(), image.stretches.last()) else {
            return 2;
        };
        let ends = [(first, 0.0), (last, 1.0)];
        let ends = ends
            .iter()
            .filter(|(s, at)| near(&s.point(Dd::from(*at)), (s.slack + image.extra) * UP));
        ends.count()
    }

    /// Whether what is in the crack by an image that is part of a circle is one stretch, where it is in a group.
    /// `touched` says whether the line is on the circle at its foot.
    fn is_one_stretch(
        &self,
        stab: &Stabber,
        group: &Group,
        image: usize,
        round: &Round,
        touched: impl Fn(&When) -> bool,
    ) -> bool {
        if round.is_along(&stab.direction) {
            return true;
        }
        let Some((foot, meets_axis)) = round.foot(&stab.origin, &stab.direction) else {
            return false;
        };
        if touched(&When::Exact(foot.clone())) {
            return self.ends_near(stab, image, 0.0) < 2;
        }
        // All of the group on one side of the foot, by more than the width.
        let foot = foot.enclosed();
        let far = CLEAR * self.most * self.scale;
        let (low, high) = (
            below(foot.mid, foot.rad + far),
            above(foot.mid, foot.rad + far),
        );
        if !(group.t[1] < low || group.t[0] > high) {
            return false;
        }
        meets_axis || self.ends_near(stab, image, 0.0) < 2
    }

    fn course(&self, image: usize) -> Option<&Course> {
        let make = || self.brep?.course(self.trims[image]);
        self.courses[image].get_or_init(make).as_ref()
    }

    /// Whether its images are one segment, exactly, that the line does not meet: then there is no passage.
    fn is_apart(&self, stab: &Stabber) -> bool {
        let meets = |b: &PreparedBrep| b.meets_joined(self.edge, &stab.origin, &stab.direction);
        self.brep.and_then(meets) == Some(false)
    }

    /// Whether a hit is within the width of an image.
    fn holds(&self, stab: &Stabber, hit: &RawHit) -> Option<bool> {
        let exactly = |m: &Meeting| m.on.iter().any(|t| self.trims.contains(t));
        if hit.exact.as_deref().is_some_and(exactly) {
            return Some(true);
        }
        let t = &hit.t;
        let p: V3 = std::array::from_fn(|c| {
            Ball::exact(stab.origin[c]) + *t * Ball::exact(stab.direction[c])
        });
        let mut out = Some(false);
        for image in &self.images {
            let [low, high] = distance(&p, image, self.least, self.most);
            if high <= self.least {
                return Some(true);
            }
            if low <= self.most {
                out = None;
            }
        }
        out
    }

    /// All groups, by parts that are short against the width or, where neither these nor what images are exactly tell that each group is one passage, by runs.
    fn all_groups(
        &self,
        stab: &Stabber,
        hits: &[RawHit],
        budget: &mut usize,
    ) -> Option<Vec<Group>> {
        let mut first = FIRST.min(*budget);
        *budget -= first;
        let by_parts = self.groups(stab, &mut first);
        *budget += first;
        let is_open = |g: &&Group| !g.one && g.is_within(stab.range) != Some(false);
        let open = |groups: &Vec<Group>| groups.iter().filter(is_open).count();
        let told = |g: &Group| {
            let near = || hits.iter().filter(|h| g.holds(&h.t) != Some(false)).count();
            let [covered, together] = self.covers(stab, g, hits);
            covered && (together || near() <= 1)
        };
        let all_told = |groups: &Vec<Group>| {
            open(groups) == 0 || self.is_apart(stab) || groups.iter().filter(is_open).all(told)
        };
        if by_parts.as_ref().is_some_and(all_told) {
            return by_parts;
        }
        let by_runs = self.groups_by_runs(stab, budget);
        match (&by_parts, &by_runs) {
            (Some(parts), Some(runs)) if open(runs) <= open(parts) => by_runs,
            (None, Some(runs)) if open(runs) == 0 => by_runs,
            (Some(_), _) => by_parts,
            _ => self.groups(stab, budget).or(by_runs),
        }
    }

    /// The groups of runs; `None` where the budget does not suffice, or nothing is known of the width from below: then nothing is sure.
    fn groups_by_runs(&self, stab: &Stabber, budget: &mut usize) -> Option<Vec<Group>> {
        if !(self.least > 0.0) {
            return None;
        }
        let mut all: Vec<Run> = Vec::new();
        for (index, image) in self.images.iter().enumerate() {
            let bounds = [self.least, self.most];
            all.extend(runs(stab, (index, image), bounds, self.scale, budget)?);
        }
        // The rest covers the rounding of parameters.
        let gap = Dd::from(LINKED * self.least * self.scale / UP / UP);
        let whole = |r: &Run| (r.t, r.image, r.sure.is_some());
        Some(self.grouped(all, whole, |group| is_one(group, gap)))
    }

    /// What is near the line, in groups whose passages are apart. `whole` gives the projection of one, its image and whether some of it is surely in the crack;
    /// `is_one` whether some in order of these are one passage or none.
    fn grouped<X>(
        &self,
        mut all: Vec<X>,
        whole: impl Fn(&X) -> ([Dd; 2], usize, bool),
        is_one: impl Fn(&[X]) -> bool,
    ) -> Vec<Group> {
        let t = |x: &X| whole(x).0;
        all.sort_by(|a, b| {
            let by_t = t(a)[0].partial_cmp(&t(b)[0]);
            by_t.unwrap_or(std::cmp::Ordering::Equal)
        });
        let mut groups = Vec::new();
        let mut rest = &all[..];
        while let Some(first) = rest.first() {
            let [start, mut end] = t(first);
            let count = rest
                .iter()
                .take_while(|p| {
                    let near = t(p)[0] <= above(end, 3.0 * self.most * self.scale);
                    if near && t(p)[1] > end {
                        end = t(p)[1];
                    }
                    near
                })
                .count();
            let (group, others) = rest.split_at(count);
            let reach = self.most * self.scale;
            groups.push(Group {
                t: [below(start, reach), above(end, reach)],
                sure: group.iter().any(|x| whole(x).2),
                one: is_one(group),
                images: (0..self.images.len())
                    .filter(|i| group.iter().any(|x| whole(x).1 == *i))
                    .collect(),
            });
            rest = others;
        }
        groups
    }

    /// Parts that are not farther than `most` from the line, in groups; `None` where the budget does not suffice.
    /// Parts of segments that are too many are left whole.
    fn groups(&self, stab: &Stabber, budget: &mut usize) -> Option<Vec<Group>> {
        let mut parts = Vec::new();
        for index in 0..self.images.len() {
            let short = self.least.max(UNKNOWN * self.most) / SHORT;
            let count = parts.len();
            let mut few = FEW.min(*budget);
            let before = few;
            let cut = self.parts(stab, index, (short, false), &mut few, &mut parts);
            *budget -= before - few;
            if cut.is_some() && !parts[count..].iter().any(|p| p.long) {
                continue;
            }
            // Of a circle it is of use to know where it is near the line, if its parts are short or not. A line along a segment: what is in the crack
            // by that is one stretch, however long its parts are.
            match (self.course(index), cut) {
                (Some(Course::Straight) | None, Some(())) => {}
                (Some(Course::Straight), None) => {
                    parts.truncate(count);
                    self.parts(stab, index, (f64::INFINITY, false), budget, &mut parts)?;
                }
                (Some(_), Some(())) => {
                    let kept = parts.split_off(count);
                    let mut few = FEW.min(*budget);
                    let before = few;
                    let cut = self.parts(stab, index, (short, true), &mut few, &mut parts);
                    *budget -= before - few;
                    if cut.is_none() {
                        parts.truncate(count);
                        parts.extend(kept);
                    }
                }
                (_, None) => {
                    parts.truncate(count);
                    self.parts(stab, index, (short, false), budget, &mut parts)?;
                }
            }
        }
        let whole = |p: &Part| (p.t, p.image, p.sure);
        Some(self.grouped(parts, whole, |group| self.is_one(group)))
    }

    /// Whether a group, in order of `t`, is proven to be one passage or none.
    fn is_one(&self, group: &[Part]) -> bool {
        // Parts are short against `most` only, or not even that.
        if UNKNOWN * self.most > self.least || group.iter().any(|p| p.long) {
            return false;
        }
        // Points of two parts are no farther apart than these are, and their lengths: in all three quarters of `least`. The rest
        // covers the rounding of parameters, of which a short part is no less than 64 units long.
        let gap = Dd::from(0.5 * self.least * self.scale / UP / UP);
        let sure: Vec<&Part> = group.iter().filter(|p| p.sure).collect();
        let mut end = match sure.first() {
            Some(first) => first.t[1],
            None => return false,
        };
        let first = sure[0].t[0];
        for p in &sure {
            if p.t[0] > end + gap {
                return false;
            }
            if p.t[1] > end {
                end = p.t[1];
            }
        }
        group
            .iter()
            .all(|p| p.t[1] + gap >= first && p.t[0] <= end + gap)
    }

    fn parts(
        &self,
        stab: &Stabber,
        index: usize,
        (short, local): (f64, bool),
        budget: &mut usize,
        out: &mut Vec<Part>,
    ) -> Option<()> {
        let image = self.images[index];
        let wanted = self.least.max(UNKNOWN * self.most) / SHORT;
        for s in &image.stretches {
            let slack = (s.slack + image.extra) * UP;
            let mut stack = vec![(stab.forms(&s.net()), 0)];
            while let Some((node, depth)) = stack.pop() {
                let place = Place::new(stab, &node)?;
                if place.away[0] > (self.most + slack) * UP {
                    continue;
                }
                let long = (place.length + 2.0 * slack) * UP > short;
                // What the slack makes long stays so.
                let far = local && place.length > LOCAL * slack;
                let shrinks = depth < DEPTH && place.length > ROUNDED * place.rounding;
                if long && shrinks && (2.0 * slack * UP <= short || far) {
                    *budget = budget.checked_sub(1)?;
                    stack.extend(node.halves(true).map(|half| (half, depth + 1)));
                    continue;
                }
                let by = slack * self.scale;
                let long = long || (place.length + 2.0 * slack) * UP > wanted;
                out.push(Part {
                    image: index,
                    t: [below(place.t[0], by), above(place.t[1], by)],
                    long,
                    sure: !long && (place.away[1] + slack) * UP <= self.least,
                });
            }
        }
        Some(())
    }
}

/// Directions that are rounded are off by less, where coordinates have digits enough: some ten roundings of numbers of these sizes.
const SHARP: f64 = 1.0 / (1u64 << 20) as f64;
/// How many widths a group is from the foot of the axis, along the line.
const CLEAR: f64 = 4.0;
/// Runs no farther apart than this part of `least` are linked.
const LINKED: f64 = 1.0 - 1.0 / 64.0;
/// Parts of all images are halved so often in all before runs are looked for.
const FIRST: usize = 2 * FEW;
/// Parts of a segment or a circle are halved so often in all before they are taken otherwise: a line that passes one needs some hundred.
const FEW: usize = 1 << 11;
/// Parts of a circle whose slack is more than what is short are halved to this many slacks.
const LOCAL: f64 = 64.0;
/// Nor parts that are no longer than so many of their roundings: there would be more and more of them, none of them shorter.
const ROUNDED: f64 = 4.0;
/// Parts are not halved more often than this.
pub(super) const DEPTH: u32 = 100;

impl Group {
    /// Whether its passages are on the part of the line that counts; `None` where that is not known.
    fn is_within(&self, [low, high]: [f64; 2]) -> Option<bool> {
        let ([a, b], [low, high]) = (self.t, [low, high]);
        // An end at infinity takes no part in double-double.
        let beyond =
            (low.is_finite() && b < Dd::from(low)) || (high.is_finite() && a > Dd::from(high));
        if beyond {
            return Some(false);
        }
        let inside =
            (!low.is_finite() || a >= Dd::from(low)) && (!high.is_finite() || b <= Dd::from(high));
        inside.then_some(true)
    }

    /// Whether a parameter is in its range; `None` where that is not known.
    fn holds(&self, t: &Ball<Dd>) -> Option<bool> {
        let (low, high) = (below(t.mid, t.rad), above(t.mid, t.rad));
        if high < self.t[0] || low > self.t[1] {
            return Some(false);
        }
        (low >= self.t[0] && high <= self.t[1]).then_some(true)
    }
}

/// Where a part of an image is about the line.
pub(super) struct Place {
    /// Bounds of the distance of its points from the line.
    pub(super) away: [f64; 2],
    /// A bound of how far two of its points can be from each other.
    pub(super) length: f64,
    /// How much of that is roundings, which no halving makes less.
    rounding: f64,
    /// Holds the projection to the line.
    pub(super) t: [Dd; 2],
    /// Ranges of the coordinates of the cross product with the direction, up to sign: along the two others than the longest of that, then along this.
    pub(super) across: [[f64; 2]; 3],
}

impl Place {
    /// From the forms on a part of a curve; `None` where weights are not known to be positive.
    ///
    /// With `a` the coordinate in which the direction `d` is longest and `b`, `c` the others in turn, `x - o` has with `d` the cross
    /// product `(L_c d_b - L_b d_c) / d_a` along `a`, up to sign, and `L_c`, `L_b` along the others: its length over `|d|` is the
    /// distance. The projection is at `t = x_a' / d_a + (d_b L_b + d_c L_c) / (d_a |d|^2)`, where `x' = x - o`.
    pub(super) fn new(stab: &Stabber, node: &Forms<Dd>) -> Option<Self> {
        let w = range(&node.c[3], node.error[3]);
        if !(w[0] > 0.0) {
            return None;
        }
        let quotient = |k: usize| {
            let r = range(&node.c[k], node.error[k]);
            let low = if r[0] > 0.0 { r[0] / w[1] } else { r[0] / w[0] };
            let high = if r[1] > 0.0 { r[1] / w[0] } else { r[1] / w[1] };
            widened([low, high])
        };
        let (a, b, c) = (stab.axis, (stab.axis + 1) % 3, (stab.axis + 2) % 3);
        let d = stab.direction;
        let [p, q] = [0, 1].map(quotient);
        let times = |r: [f64; 2], f: f64| {
            let (x, y) = (r[0] * f, r[1] * f);
            [x.min(y), x.max(y)]
        };
        let sum = |x: [f64; 2], y: [f64; 2]| {
            let (x, y) = (widened(x), widened(y));
            widened([x[0] + y[0], x[1] + y[1]])
        };
        let third = widened(sum(times(q, d[b] / d[a]), times(p, -d[c] / d[a])));
        let norm = d.norm();
        let parts = [p, q, third];
        let away = [0, 1].map(|end| {
            let squares = parts.iter().map(|r| {
                let x = if end == 1 {
                    r[0].abs().max(r[1].abs())
                } else {
                    r[0].max(-r[1]).max(0.0)
                };
                x * x
            });
            squares.sum::<f64>().sqrt() / norm
        });
        let across = parts
            .iter()
            .map(|r| (r[1] - r[0]).powi(2))
            .sum::<f64>()
            .sqrt()
            / norm;
        // Along the line in double-double: quotients of coefficients, and what the planes add.
        let along = widened(sum(
            times(p, d[b] / (d[a] * norm * norm)),
            times(q, d[c] / (d[a] * norm * norm)),
        ));
        let mut t: Option<[Dd; 2]> = None;
        let mut most_off = 0.0f64;
        for (x, w) in node.c[2].iter().zip(&node.c[3]) {
            let x = Ball {
                mid: *x,
                rad: node.error[2],
            };
            let w = Ball {
                mid: *w,
                rad: node.error[3],
            };
            let value = x / w / Ball::exact(d[a]);
            let off = value.rad * UP + 4.0 * Dd::UNIT * value.mid.magnitude();
            most_off = most_off.max(off);
            let off = Dd::from(off);
            let (low, high) = (value.mid - off, value.mid + off);
            t = Some(match t {
                None => [low, high],
                Some([l, h]) => [
                    if low < l { low } else { l },
                    if high > h { high } else { h },
                ],
            });
        }
        let [low, high] = t?;
        let t = [low + Dd::from(along[0]), high + Dd::from(along[1])];
        let length = across + (t[1] - t[0]).hi * norm;
        let good = away[1].is_finite() && t[0].hi.is_finite() && t[1].hi.is_finite();
        good.then_some(Self {
            away: [away[0] / UP, away[1] * UP],
            length: length * UP,
            rounding: 2.0 * most_off * norm,
            t,
            across: parts,
        })
    }
}

/// A parameter less a length in parameters, or below that.
pub(super) fn below(t: Dd, by: f64) -> Dd {
    t - Dd::from(by * UP + 4.0 * Dd::UNIT * t.magnitude())
}

/// A parameter and a length in parameters, or above that.
pub(super) fn above(t: Dd, by: f64) -> Dd {
    t + Dd::from(by * UP + 4.0 * Dd::UNIT * t.magnitude())
}

/// Outward by a few roundings.
pub(super) fn widened([low, high]: [f64; 2]) -> [f64; 2] {
    let off = |x: f64| 16.0 * f64::EPSILON * x.abs() + f64::MIN_POSITIVE;
    [low - off(low), high + off(high)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A long part in a group reaches to where nothing is surely in the crack: passages may be two.
    #[test]
    fn a_group_with_a_long_part_is_not_known_to_be_one_passage() {
        let edge = Edge {
            images: Vec::new(),
            trims: &[],
            courses: Vec::new(),
            brep: None,
            least: 1.0,
            most: 1.0,
            edge: 0,
            scale: 1.0,
        };
        let part = |t: [f64; 2], long: bool| Part {
            image: 0,
            t: t.map(Dd::from),
            long,
            sure: !long,
        };
        let short = [part([0.0, 0.1], false), part([0.2, 0.3], false)];
        assert!(edge.is_one(&short));
        let long = [part([0.0, 0.1], false), part([0.05, 8.0], true)];
        assert!(!edge.is_one(&long));
    }
}
