//! Whether points as low as the minimum reach far from its foot. No bound rests on it.

mod ball;

use super::answer::{Accuracy, Contacts, Options};
use super::level::{Level, Lies};
use super::local::{Spot, point};
use super::objective::Objective;
use super::outcome::{Foot, Goal, Locus, Outcome, Source, Width};
use super::place::{ON_VERTEX, rough_jet};
use super::search::minimize;
use super::task::Memory;
use super::upper::patch_at;
use crate::numeric::{Ball, Dd};
use crate::prepare::closed::Extent;
use crate::prepare::{Net, ParamMap, Patch, PreparedBrep, curve_jet};
use crate::trim::{BoxSide, Side};
use nalgebra::{Point2, Point3, Vector3};

/// The minimum is a continuum when points within max(accuracy, this times the size) of it...
const CONTINUUM_SLACK: f64 = 1.0 / (1u64 << 44) as f64;
/// ...reach farther than this times the size from one foot.
pub(super) const CONTINUUM_REACH: f64 = 1.0 / (1u64 << 12) as f64;

/// By how much a distance or height may be larger than the least to count as least.
#[inline]
pub(super) fn continuum_slack(brep: &PreparedBrep, options: &Options) -> f64 {
    let slack = CONTINUUM_SLACK * brep.size();
    match options.accuracy {
        Accuracy::Length(a) => slack.max(a),
        Accuracy::Full => slack,
    }
}

/// Whether the minimum that a search found is a continuum, and how many nodes it took to tell.
///
/// The extents of what it settled say so, or points as low that are seen where it left something open. A search for the deepest contact passes over what is as
/// low as its foot. Of a distance, that is as low along an edge as it says; but a half-space rests on edges, generators and faces as soon as on one of their ends, so
/// that next to a foot that nothing proves to stand alone (on the border of a face, above all) it is looked for again, by a search for all that is so low.
/// Needles that are as low are found by [`Level`]: of a half-space wherever its foot may not stand alone; of a ball where derivatives at its foot leave it open (from edges
/// that takes far longer than the answer, so where little is low it is asked of those only from which a search left something open).
pub(super) fn is_continuum(
    brep: &PreparedBrep,
    objective: &Objective,
    found: &Outcome,
    (goal, options): (&Goal, &Options),
    memory: &mut Memory,
) -> (bool, usize) {
    let slack = continuum_slack(brep, options);
    let low = Low {
        brep,
        objective,
        limit: raised(found, objective, slack),
        slack,
        reach: CONTINUUM_REACH * brep.size(),
    };
    if low.is_told(found, false) {
        return (true, 0);
    }
    let normal = match *objective {
        Objective::SquaredDistance(center) => return (low.leads_far_from_ball(found, &center), 0),
        Objective::Height(normal, _) => normal,
    };
    if found.left_open && found.foot.as_ref().is_some_and(|f| low.is_seen_from(f)) {
        return (true, 0);
    }
    let may_lie_along = !low.stands_alone(found) && !low.rises_from_corner(found, &normal);
    // What is as low within a face in closed form its formula tells.
    let may_lead_far = (may_lie_along && !low.is_within_closed(found)) || low.is_on_border(found);
    let lies = if may_lead_far {
        low.leads(found)
    } else {
        Lies::Open
    };
    if lies == Lies::Far {
        return (true, 0);
    }
    let left = goal.budget.saturating_sub(found.nodes);
    // A list has looked at all that is so low, but where formulas say of a face that nothing in it is least: a generator may be so but for a rounding.
    let by_formula = |f: &Foot| matches!(f.spot, Locus::Closed { .. });
    let was_seen =
        options.contacts == Contacts::All && !found.foot.as_ref().is_some_and(by_formula);
    if was_seen || !may_lie_along || lies == Lies::Near || left == 0 {
        return (false, 0);
    }
    let goal = Goal {
        all_below: Some(low.limit),
        extents: Some(found.hi),
        width: Width::Length(0.5 * slack),
        budget: left.min(MOST_NODES),
        closed: true,
        foot: false,
        hint: None,
        ..*goal
    };
    let again = minimize(brep, objective, goal, memory, None);
    let told = (low.is_told(&again, true), again.nodes);
    memory.keep(again);
    told
}

/// How many nodes a search for what is as low as a foot may visit: what is not found out by then is told as a point.
const MOST_NODES: usize = 512;

/// `f` at a distance or height larger by `slack`.
fn raised(found: &Outcome, objective: &Objective, slack: f64) -> f64 {
    if objective.is_squared() {
        let d = found.hi.hi.sqrt() + slack;
        d * d
    } else {
        found.hi.hi + slack
    }
}

/// Points that are as low as a minimum, and far from where it is.
struct Low<'a> {
    brep: &'a PreparedBrep,
    objective: &'a Objective,
    /// No point above this is low.
    limit: f64,
    /// By how much that is above the minimum, in length.
    slack: f64,
    /// None that is nearer is far.
    reach: f64,
}

impl Low<'_> {
    /// Whether what a search settled extends so far: by a formula, or as is seen from where it is least. (What is known of a box may be no more than its size, and
    /// of a curve no more than how far `f` is as low along it: beside all of these is looked, too, if that is wanted.)
    fn is_told(&self, found: &Outcome, beside: bool) -> bool {
        let mut low = found.settled.iter().filter(|s| s.lo.hi <= self.limit);
        let mut looks = 0..MOST_LOOKS;
        low.any(|s| {
            let extends = s.extent.length(self.limit - s.lo.hi) > self.reach;
            if s.source.is_none() && extends {
                return true;
            }
            if !(extends || beside) || looks.next().is_none() {
                return false;
            }
            let geometry = self.brep.double(s.face);
            match s.source {
                None => {
                    let found = patch_at(&geometry.patches, s.at.into());
                    found.is_some_and(|(patch, at)| self.is_seen_on(s.face, patch, at))
                }
                Some(Source::Patch { face, index }) => {
                    extends && self.is_seen_on(face, index, s.at)
                }
                Some(Source::Piece { face, index }) => {
                    let piece = geometry.piece(index);
                    let on_patch = || {
                        let (p, _) = curve_jet(&piece.local, Ball::exact(s.at[0]));
                        let at = [0, 1].map(|k| (p[k].mid / p[2].mid).clamp(0.0, 1.0));
                        self.is_seen_on(face, piece.patch, at)
                    };
                    extends && self.is_seen_along(face, index, s.at[0]) || beside && on_patch()
                }
            }
        })
    }

    /// Whether a foot is in a face's interior and proven to be the only low place around.
    fn stands_alone(&self, found: &Outcome) -> bool {
        let Some(foot) = found.foot.as_ref().filter(|f| f.trim.is_none()) else {
            return false;
        };
        let source = foot.found.map(|f| f.0);
        found.settled.iter().any(|s| {
            let growth = (self.limit - s.lo.hi).max(0.0);
            let length = s.extent.length(growth);
            (s.face, s.source) == (foot.face, source)
                && s.local_minimum
                && length <= self.reach
                && self.rises_into_patch(foot, s.extent, length)
                && self.is_clear_of_trims(foot, length)
        })
    }

    /// Whether values rise from a border of a patch into it, by far more than it takes; of a foot that is on none, whether its extent tells more than that it is a point.
    ///
    /// (What settles a border knows of that alone, and what settles a corner of nothing. From a corner all rises that does along both borders, as every way into the
    /// patch is made of these. What is low within `length` of a foot inside may be low up to the border, and beyond it no less: a foot that is so near counts as on it.)
    fn rises_into_patch(&self, foot: &Foot, extent: Extent, length: f64) -> bool {
        let Locus::Patch { patch, local, .. } = foot.spot else {
            return false;
        };
        let Patch { net, .. } = &self.brep.double(foot.face).patches[patch];
        let at = local.map(|x| x.mid.hi);
        let [here, along_u, along_v] = rough_jet(net, at);
        let rise = match *self.objective {
            Objective::SquaredDistance(q) => {
                let off = here - (q - Point3::from(net.origin));
                off / off.norm()
            }
            Objective::Height(normal, _) => normal,
        };
        (0..2).zip([along_u, along_v]).all(|(k, along)| {
            let speed = along.norm();
            let inward = match at[k] {
                x if x * speed <= length => 1.0,
                x if (1.0 - x) * speed <= length => -1.0,
                _ => return !matches!(extent, Extent::Root(0.0)),
            };
            // Negated in effect: what is no number does not rise.
            inward * rise.dot(&along) / speed * self.reach > SURELY * self.slack
        })
    }

    /// Whether no trim passes within a length of a foot on a patch, as fast as the patch is there: beyond one another face may be low, which nothing that settled
    /// this one knows of.
    fn is_clear_of_trims(&self, foot: &Foot, length: f64) -> bool {
        let Locus::Patch { patch, local, .. } = foot.spot else {
            return false;
        };
        let Patch { net, maps, .. } = &self.brep.double(foot.face).patches[patch];
        let at = local.map(|x| x.mid.hi);
        let [_, along_u, along_v] = rough_jet(net, at);
        let speeds = [along_u.norm(), along_v.norm()];
        // What is no number is the whole patch.
        let around = [0, 1].map(|k| {
            let by = (length / speeds[k]).min(1.0);
            [at[k] - by, at[k] + by]
        });
        // A box up to a trim along the border of the domain is inside, but for that.
        let brep = self.brep.brep();
        let domain = brep.surface(foot.face).domain();
        let is_at_end = |k: usize| {
            let [low, high] = around[k];
            (low <= 0.0 && maps[k].start <= domain[k].start)
                || (high >= 1.0 && domain[k].end <= maps[k].end)
        };
        let has_trims = brep.parts().faces[foot.face].loops.is_some();
        if has_trims && (is_at_end(0) || is_at_end(1)) {
            return false;
        }
        let [u, v] = [0, 1].map(|k| {
            let [low, high] = around[k].map(|x| x.clamp(0.0, 1.0));
            maps[k].to_native_range(low, high)
        });
        self.brep.region(foot.face).classify_box(u, v) == BoxSide::Inside
    }

    /// Whether a foot is within a face that is searched in closed form, on no trim.
    fn is_within_closed(&self, found: &Outcome) -> bool {
        let is_closed = |f: &Foot| matches!(f.spot, Locus::Closed { .. });
        found
            .foot
            .as_ref()
            .is_some_and(|f| f.trim.is_none() && is_closed(f))
    }

    /// Whether a foot is on the border of a patch, and so may be on that of its face, without a trim that says so.
    fn is_on_border(&self, found: &Outcome) -> bool {
        found.foot.as_ref().is_some_and(|f| match f.spot {
            Locus::Patch { local, .. } => {
                let is_end = |x: f64| x <= 0.0 || x >= 1.0;
                f.trim.is_none() && local.iter().any(|x| is_end(x.mid.hi))
            }
            Locus::Closed { .. } => false,
        })
    }

    /// Whether a low way leads far from a foot.
    fn leads_far(&self, found: &Outcome) -> bool {
        self.leads(found) == Lies::Far
    }

    /// How what is low lies about a foot.
    fn leads(&self, found: &Outcome) -> Lies {
        let Some(foot) = found.foot.as_ref() else {
            return Lies::Open;
        };
        let at = Spot {
            face: foot.face,
            uv: foot.uv,
        };
        let foot_point = point(self.brep, at);
        let (limit, most) = match *self.objective {
            Objective::SquaredDistance(q) => (self.limit.sqrt(), q.coords.amax()),
            Objective::Height(_, h) => (self.limit, h.abs()),
        };
        let rounded = ROUNDED * self.brep.size().max(foot_point.coords.amax()).max(most);
        // What f64 cannot tell is not looked at.
        let level = Level {
            brep: self.brep,
            objective: self.objective,
            foot: foot_point,
            limit,
            slack: self.slack,
            reach: self.reach,
        };
        // Of a distance more is asked than that: see `leads_far_from_ball`.
        let stands_alone = !self.objective.is_squared() && self.stands_alone(found);
        if rounded <= self.slack {
            level.from(at, foot.trim, stands_alone)
        } else {
            Lies::Open
        }
    }

    /// Whether a foot is a vertex from which all edges rise, and on no face of which the half-space lies: what is as low is not connected with it then.
    fn rises_from_corner(&self, found: &Outcome, normal: &Vector3<f64>) -> bool {
        let brep = self.brep.brep();
        let parts = brep.parts();
        let Some(foot) = &found.foot else {
            return false;
        };
        let Some(trim) = foot.trim.map(|t| &parts.trims[t]) else {
            return false;
        };
        let point = brep.surface(foot.face).point(foot.uv.x, foot.uv.y);
        let off = |x: Point3<f64>| (x - point).norm();
        let [a, b] = trim.vertices.map(|v| off(parts.vertices[v].point));
        let vertex = trim.vertices[usize::from(b < a)];
        // Negated in effect: what is no number is no vertex.
        let is_vertex = a.min(b) <= ON_VERTEX * self.brep.size();
        let edges = &parts.vertices[vertex].edges;
        let mut trims = edges.iter().flat_map(|e| &parts.edges[*e].trims);
        is_vertex && !edges.is_empty() && trims.all(|t| self.rises_along(*t, &off, normal))
    }

    /// The same of a trim that ends there, and of its face.
    fn rises_along(
        &self,
        trim: usize,
        off: &impl Fn(Point3<f64>) -> f64,
        normal: &Vector3<f64>,
    ) -> bool {
        let brep = self.brep.brep();
        let parts = brep.parts();
        let trim = &parts.trims[trim];
        let surface = brep.surface(parts.loops[trim.trim_loop].face);
        let curve = &parts.curves2[trim.curve];
        let steep = |sine: f64| sine * self.reach > SURELY * self.slack;
        let mut ends = 0;
        for s in [0.0, 1.0] {
            let at = curve.point(trim.span.lerp(s));
            let jet = surface.first_derivatives_with_bound(at.x, at.y);
            if !(off(jet.point) <= NEAR_CORNER * self.brep.size()) {
                continue;
            }
            // A little way along, by uv.
            let way = curve.point(trim.span.lerp((s - ALONG).abs())) - at;
            let (along, across) = (jet.du * way.x + jet.dv * way.y, jet.du.cross(&jet.dv));
            let rises = steep(normal.dot(&along).abs() / along.norm());
            if !(rises && steep(normal.cross(&across).norm() / across.norm())) {
                return false;
            }
            ends += 1;
        }
        ends > 0
    }

    /// Whether some are seen from a foot: where a search stopped at an enclosure that is narrow enough, it did not look for them.
    fn is_seen_from(&self, foot: &Foot) -> bool {
        match foot.spot {
            Locus::Patch { patch, local, .. } => {
                self.is_seen_on(foot.face, patch, local.map(|x| x.mid.hi))
            }
            Locus::Closed { .. } => false,
        }
    }

    /// Whether some are seen from a place on a patch.
    fn is_seen_on(&self, face: usize, patch: usize, at: [f64; 2]) -> bool {
        let Patch { net, maps, .. } = &self.brep.double(face).patches[patch];
        let [here, along_u, along_v] = rough_jet(net, at);
        AROUND.iter().any(|d| {
            // On a border only along it.
            let open = |k: usize| {
                let out = at[k] <= 0.0 && d[k] < 0.0 || at[k] >= 1.0 && d[k] > 0.0;
                if out { 0.0 } else { d[k] }
            };
            let speed = (along_u * open(0) + along_v * open(1)).norm();
            // A step in the patch that goes so far, roughly, or to the patch's border.
            let step = (FAR * self.reach / speed).min(1.0);
            let there = [0, 1].map(|k| (at[k] + step * d[k]).clamp(0.0, 1.0));
            speed > 0.0
                && self.is_far_and_low(net, here, there)
                && self.is_in_region(face, maps, there)
        })
    }

    fn is_in_region(&self, face: usize, maps: &[ParamMap; 2], at: [f64; 2]) -> bool {
        let uv = [0, 1].map(|k| maps[k].to_native(Dd::from(at[k])));
        let side = self.brep.region(face).side(Point2::new(uv[0], uv[1])).side;
        matches!(side, Some(Side::Inside | Side::Boundary))
    }

    /// Whether some are seen from a place on a boundary piece, along it.
    fn is_seen_along(&self, face: usize, piece: usize, at: f64) -> bool {
        let Some(net) = &self.brep.double(face).piece(piece).space else {
            return false;
        };
        let [here, along, _] = rough_jet(net, [at, 0.0]);
        let step = FAR * self.reach / along.norm();
        [-step, step].into_iter().any(|step| {
            let there = (at + step).clamp(0.0, 1.0);
            self.is_far_and_low(net, here, [there, 0.0])
        })
    }

    /// Whether a place is low, and far from a point (relative to the net's origin).
    fn is_far_and_low(&self, net: &Net<f64>, here: Vector3<f64>, there: [f64; 2]) -> bool {
        // Negated in effect: what is no number is not low.
        self.objective.guide_value(net, there[0], there[1]) <= self.limit
            && (rough_jet(net, there)[0] - here).norm() > self.reach
    }
}

/// What values may be off by, for a slack to tell anything: some roundings of coordinates.
const ROUNDED: f64 = 64.0 * f64::EPSILON;
/// Of what is settled, so much is looked at.
const MOST_LOOKS: usize = 64;
/// An end of a trim that is no farther from a vertex than this part of the size is there.
const NEAR_CORNER: f64 = 1.0 / (1u64 << 20) as f64;
/// The part of a trim over which its direction at an end is taken.
const ALONG: f64 = 1.0 / (1u64 << 12) as f64;
/// What rises by so many times the slack is not level, whatever is rounded.
const SURELY: f64 = 16.0;
/// Directions in which to look.
const AROUND: [[f64; 2]; 8] = [
    [1.0, 0.0],
    [-1.0, 0.0],
    [0.0, 1.0],
    [0.0, -1.0],
    [0.7, 0.7],
    [-0.7, 0.7],
    [0.7, -0.7],
    [-0.7, -0.7],
];
/// How far is looked, in units of the reach.
const FAR: f64 = 1.125;

#[cfg(test)]
mod tests;
