//! Whether what is about as near to a ball's centre as its foot leads far from there: as the second derivatives at the foot say, and where these leave it open,
//! by [`Level`](super::Level). Values are f64, and no bound rests on it.

use super::{FAR, Low, SURELY};
use crate::prepare::Patch;
use crate::prepare::closed::Extent;
use crate::query::local::{on_trim, point};
use crate::query::outcome::{Foot, Locus, Outcome, Settled, Source};
use crate::query::place::{ON_VERTEX, rough_jet};
use nalgebra::{Point3, Vector3};

/// What could be as low so many times farther than it is does not lead far.
pub(super) const STEEP: f64 = 8.0;
/// Little is low where that is so small a part of the reach: at accuracies up to 2^-40 of the size, 16 times what counts in full.
const FINE: f64 = 1.0 / (1u64 << 28) as f64;
/// Where derivatives at the foot say of the reach that it is so many times higher than what is low, it is higher: over 2^-12 of the size, those of higher order
/// change less of it.
const PLAINLY: f64 = 4.0;

/// How the squared distance grows around a foot, along the way on which it grows least.
struct Bend {
    /// By so much times the square of the way.
    least: f64,
    /// That way, in local parameters, of length one in space.
    along: [f64; 2],
    /// The way down from a foot that is not quite where it is least; no numbers where it is.
    down: [f64; 2],
}

impl Low<'_> {
    /// Whether points that are as low lead far from the foot of a ball.
    ///
    /// What a search settled or a formula knows it told before. Of a foot on a trim that is all where little is low, but for a search that left something open.
    pub(super) fn leads_far_from_ball(&self, found: &Outcome, center: &Point3<f64>) -> bool {
        let Some(foot) = &found.foot else {
            return false;
        };
        let is_fine = self.slack <= FINE * self.reach;
        let is_settled = is_fine && !found.left_open;
        let growth = self.limit - found.hi.hi;
        let told = match (foot.spot, foot.trim, foot.found) {
            (Locus::Closed { .. }, None, _) => Some(false),
            (Locus::Closed { .. }, Some(_), _) => is_fine.then_some(false),
            (Locus::Patch { .. }, None, _) if self.is_steep(found, foot) => Some(false),
            (Locus::Patch { .. }, None, _) if is_settled => None,
            (Locus::Patch { .. }, None, _) => self
                .told_at_end(foot, growth, center)
                .or_else(|| self.told_within_face(foot, growth)),
            (Locus::Patch { .. }, Some(_), _) if is_settled => Some(false),
            (Locus::Patch { .. }, Some(_), Some((Source::Piece { face, index }, [at, _]))) => {
                self.told_on_trim(found, foot, (face, index, at), center)
            }
            (Locus::Patch { .. }, Some(_), _) => None,
        };
        told.unwrap_or_else(|| self.leads_far(found))
    }

    /// Whether the distance rises from a foot inside of a face by far more than it takes, as far as what settled it says: it still will a little beyond that.
    fn is_steep(&self, found: &Outcome, foot: &Foot) -> bool {
        let Some((source, _)) = foot.found else {
            return true;
        };
        let is_steep = |s: &Settled| {
            let growth = (self.limit - s.lo.hi).max(0.0);
            match s.extent {
                Extent::Root(0.0) => self.rises_into_patch(foot, s.extent, 0.0),
                Extent::Root(_) => {
                    STEEP * s.extent.length(growth) <= self.reach || self.bends_up(foot, growth)
                }
                // Of boxes that are not convex only their size is known.
                Extent::Linear { .. } | Extent::Ring { .. } => false,
            }
        };
        let mut own =
            { found.settled.iter() }.filter(|s| (s.face, s.source) == (foot.face, Some(source)));
        own.any(is_steep)
    }

    /// The same from the second derivatives at the foot, within a box that is convex: what is known of the whole box may say ten times as little. Where the square that
    /// they make is [`STEEP`]² times what is low at the reach, it is four times that at a quarter of it, and what is convex does not come down again: derivatives of
    /// higher order would have to take away three quarters of it within 2^-14 of the size.
    pub(super) fn bends_up(&self, foot: &Foot, growth: f64) -> bool {
        let bend = self.bend(foot);
        bend.is_some_and(|b| b.least * self.reach * self.reach > STEEP * STEEP * growth)
    }

    /// `None` in closed form, and where the parameters' lines are not apart.
    fn bend(&self, foot: &Foot) -> Option<Bend> {
        let Locus::Patch { patch, local, .. } = foot.spot else {
            return None;
        };
        let net = &self.brep.double(foot.face).patches[patch].net;
        let at = local.map(|x| x.mid.hi);
        let [_, along_u, along_v] = rough_jet(net, at);
        // Second derivatives along e, the way of u, and along n, across it in the tangent plane.
        let (p, q) = (along_u.norm(), along_v.norm());
        let cosine = along_u.dot(&along_v) / (p * q);
        let sine = along_u.cross(&along_v).norm() / (p * q);
        let guide = self.objective.guide(net, at[0], at[1]);
        let [uu, uv, vv] = guide.curvature;
        let (ee, ev, vv) = (uu / (p * p), uv / (p * q), vv / (q * q));
        let en = (ev - cosine * ee) / sine;
        let nn = (vv - 2.0 * cosine * ev + cosine * cosine * ee) / (sine * sine);
        let half = 0.5 * (ee - nn);
        let root = (half * half + en * en).sqrt();
        // `f` grows by half of the second derivative along a way times its square.
        let least = 0.5 * (0.5 * (ee + nn) - root);
        if !least.is_finite() {
            return None;
        }
        // Across the way on which it grows most; of what is alike on all sides any way is one.
        let way = if half > 0.0 {
            [-en, half + root]
        } else {
            [half - root, en]
        };
        let unit = |[e, n]: [f64; 2]| {
            let length = (e * e + n * n).sqrt();
            [e / length, n / length]
        };
        let local = |[e, n]: [f64; 2]| [(e - n * cosine / sine) / p, n / (sine * q)];
        let along = if way == [0.0; 2] {
            [1.0, 0.0]
        } else {
            unit(way)
        };
        let slope = [guide.slope[0] / p, guide.slope[1] / q];
        let down = [-slope[0], (cosine * slope[0] - slope[1]) / sine];
        Some(Bend {
            least,
            along: local(along),
            down: local(unit(down)),
        })
    }

    /// What second derivatives tell of a foot within a face.
    fn told_within_face(&self, foot: &Foot, growth: f64) -> Option<bool> {
        let (Some(bend), Locus::Patch { patch, local, .. }) = (self.bend(foot), foot.spot) else {
            return None;
        };
        if bend.least * self.reach * self.reach > PLAINLY * growth {
            return Some(false);
        }
        // Else what is a little farther than the reach is looked at; where the patch or the face ends before, that tells nothing.
        let Patch { net, maps, .. } = &self.brep.double(foot.face).patches[patch];
        let at = local.map(|x| x.mid.hi);
        let here = rough_jet(net, at)[0];
        let mut is_told = bend.least > 0.0;
        for way in [bend.along, bend.along.map(|x| -x), bend.down] {
            let there = [0, 1].map(|k| at[k] + FAR * self.reach * way[k]);
            if there.iter().any(|x| x.is_nan()) {
                continue;
            }
            if there.iter().any(|x| !(0.0..=1.0).contains(x)) {
                is_told = false;
            } else if self.is_far_and_low(net, here, there) {
                if self.is_in_region(foot.face, maps, there) {
                    return Some(true);
                }
                is_told = false;
            }
        }
        is_told.then_some(false)
    }

    /// What is told of a foot on a border of its patch, where its face may end, by how the distance grows along that and into the patch.
    fn told_at_end(&self, foot: &Foot, growth: f64, center: &Point3<f64>) -> Option<bool> {
        let Locus::Patch { patch, local, .. } = foot.spot else {
            return None;
        };
        let at = local.map(|x| x.mid.hi);
        let is_end = |k: usize| at[k] <= 0.0 || at[k] >= 1.0;
        let along = match [is_end(0), is_end(1)] {
            [false, false] => return None,
            // From a corner all rises that does along both borders.
            [true, true] => {
                let rises = self.rises_into_patch(foot, Extent::Root(0.0), 0.0);
                return rises.then_some(false);
            }
            [true, false] => 1,
            [false, true] => 0,
        };
        let net = &self.brep.double(foot.face).patches[patch].net;
        let [here, along_u, along_v] = rough_jet(net, at);
        let away = Point3::from(net.origin) + here - center;
        let guide = self.objective.guide(net, at[0], at[1]);
        let step = self.reach / [along_u, along_v][along].norm();
        let rises_along = 0.5 * guide.curvature[2 * along] * step * step > PLAINLY * growth;
        let rises = self.rises_beside(&away, &along_u.cross(&along_v));
        (rises && rises_along).then_some(false)
    }

    /// What is told of a foot on a trim's piece, at one of its local parameters, by how the distance grows along it, and into the faces beside it.
    fn told_on_trim(
        &self,
        found: &Outcome,
        foot: &Foot,
        (face, index, at): (usize, usize, f64),
        center: &Point3<f64>,
    ) -> Option<bool> {
        let Locus::Patch { patch, local, .. } = foot.spot else {
            return None;
        };
        let geometry = self.brep.double(foot.face);
        let Patch { net, .. } = &geometry.patches[patch];
        let [here, along_u, along_v] = rough_jet(net, local.map(|x| x.mid.hi));
        let here = Point3::from(net.origin) + here;
        let away = here - center;
        let rises = self.rises_beside(&away, &along_u.cross(&along_v));
        let parts = self.brep.brep().parts();
        let trim = foot.trim?;
        let off = |v: usize| (parts.vertices[v].point - here).norm();
        let ends = parts.trims[trim].vertices.map(off);
        if ends.into_iter().any(|x| x <= ON_VERTEX * self.brep.size()) {
            let up = away / away.norm();
            let rises = rises && self.rises_from_corner(found, &up);
            return rises.then_some(false);
        }
        let piece = geometry.piece(index);
        let own = self.objective.guide(piece.space.as_ref()?, at, 0.0);
        // No faster than the piece is anywhere.
        let step = self.reach / geometry.piece_speeds(index)[0];
        let growth = self.limit - found.hi.hi;
        let rises_along = 0.5 * own.curvature[0] * step * step > PLAINLY * growth;
        if !rises_along && self.is_seen_along(face, index, at) {
            return Some(true);
        }
        let is_clear = ends.into_iter().all(|x| x > FAR * self.reach);
        if !(rises && rises_along && is_clear) {
            return None;
        }
        // Where the foot is on the trims of the faces beside: mostly they have it at about the same part.
        let edge = parts.trims[trim].edge?;
        let span = parts.trims[trim].span;
        let part = piece.span[0] + (piece.span[1] - piece.span[0]) * at;
        let part = (part - span.start) / span.length();
        let others = { parts.edges[edge].trims.iter() }.filter(|t| **t != trim);
        let mut rise = others.map(|t| {
            let near = |s: &f64| {
                let there = point(self.brep, on_trim(self.brep, *t, *s));
                (there - here).norm() <= NEAR * self.brep.size()
            };
            let s = [part, 1.0 - part].into_iter().find(near)?;
            let at = on_trim(self.brep, *t, s);
            let surface = self.brep.brep().surface(at.face);
            let jet = surface.first_derivatives_with_bound(at.uv.x, at.uv.y);
            Some(self.rises_beside(&away, &jet.du.cross(&jet.dv)))
        });
        rise.all(|r| r == Some(true)).then_some(false)
    }

    /// Whether the distance rises from a foot into a face that ends there, by far more than what is low, given the way from the centre and one across the face. (What it
    /// rises by straight into the face it rises by there or along the end, and by no less in between.)
    fn rises_beside(&self, away: &Vector3<f64>, across: &Vector3<f64>) -> bool {
        // Negated in effect: what is no number does not rise.
        let sine = away.cross(across).norm() / (away.norm() * across.norm());
        sine * self.reach > SURELY * self.slack
    }
}

/// What is so near to a foot, as a part of the size, is about there.
const NEAR: f64 = 1.0 / (1u64 << 20) as f64;
