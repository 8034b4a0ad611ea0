//! Hits of a line next to a pole: to a border of a patch that is nearly one point in space.
//!
//! # What is proven
//! All of such a border is near the line where any of it is, and next to it the forms `L_k` of the module `zeros` hardly change along it: a box
//! that tells anything is far narrower across the border than along, and next to 1 there are no f64 for its ends. So the patch is turned
//! round such that the border is at `b = 0`, and the strip next to it is searched again in double-double, by the means of that module: a box is put aside
//! where some combination of the forms has one sign on it, where the line's parameter does not reach it, and where it is within a zone that holds one
//! zero only, which is known. Boxes at the border are halved across it while the forms there are next to nothing beside what they are farther in.
//! What is left open leaves the whole strip open.

use super::certify::{KnownZero, known_zero, parameter_at};
use super::forms::{Forms, Stabber, restrict};
use super::zeros::{Digits, FaceHits, HitAt, Place, RawHit};
use crate::numeric::bernstein::{Bidegree, largest};
use crate::numeric::{Ball, Dd, Real};
use crate::prepare::{Net, PreparedBrep};
use crate::trim::Side;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// How wide the strip is, in local parameters.
const STRIP: f64 = 1.0 / (1u64 << 20) as f64;
/// On a pole's border the forms are below this part of what they are on the patch: it is about one point, and the line passes near it.
const POLE: f64 = 1.0 / (1u64 << 20) as f64;
/// A box is halved across a border while the forms are there below this part of what they are on the box.
const SMALL: f64 = 1.0 / 8.0;
/// What `1 - b` is rounded by.
const TURNING: f64 = 2.0 * Dd::UNIT;
/// Boxes are no narrower along the border than this...
const LEAST_LENGTH: f64 = 1.0 / (1u64 << 40) as f64;
/// ...and not across it than this.
const LEAST_WIDTH: f64 = 1.0 / (1u128 << 100) as f64;

/// A border of a patch: across which coordinate, and whether it is the upper one.
#[derive(Clone, Copy)]
struct Border {
    across: usize,
    upper: bool,
}

const BORDERS: [Border; 4] = [
    Border {
        across: 0,
        upper: false,
    },
    Border {
        across: 0,
        upper: true,
    },
    Border {
        across: 1,
        upper: false,
    },
    Border {
        across: 1,
        upper: true,
    },
];

/// The largest magnitude of both forms on a border of a box.
fn border_most<T: Real>(node: &Forms<T>, Border { across, upper }: Border) -> f64 {
    let width = node.degree.v + 1;
    let forms = node.c[..2].iter();
    let most = |c: &Vec<T>| {
        let rows = c.len() / width;
        if across == 0 {
            let first = if upper { (rows - 1) * width } else { 0 };
            largest(&c[first..first + width])
        } else {
            let column = if upper { width - 1 } else { 0 };
            (0..rows).fold(0.0, |m: f64, i| m.max(c[i * width + column].magnitude()))
        }
    };
    forms.map(most).fold(0.0, f64::max)
}

/// Whether the forms are on a border of a box below a part of what they are on the box.
fn is_small<T: Real>(node: &Forms<T>, border: Border, part: f64) -> bool {
    border_most(node, border) <= part * largest(&node.c[0]).max(largest(&node.c[1]))
}

/// Across which coordinate (u: true) a box is to be halved that touches a border of its patch where the forms are next to nothing. `change` is how
/// much both change along u and v at most.
pub(super) fn split_across<T: Real>(node: &Forms<T>, change: [f64; 2]) -> Option<bool> {
    let width = node.degree.v + 1;
    let mut touched = BORDERS.iter().filter(|b| {
        let r = if b.across == 0 { node.u } else { node.v };
        let touches = if b.upper { r[1] == 1.0 } else { r[0] == 0.0 };
        // On the box they are no larger than on the border and this change together: one corner often tells.
        touches && {
            let corner = match (b.across, b.upper) {
                (_, false) => 0,
                (0, true) => node.c[0].len() - width,
                (_, true) => width - 1,
            };
            let most = SMALL / (1.0 - SMALL) * change[b.across];
            (0..2).all(|k| node.c[k][corner].magnitude() <= most)
        }
    });
    let found = touched.find(|b| is_small(node, **b, SMALL))?;
    Some(found.across == 0)
}

/// Settles the open boxes of a face that are next to poles, where that can be done.
pub(super) fn settle(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    budget: &mut usize,
    out: &mut FaceHits,
) {
    for patch in 0..brep.double(face).patches.len() {
        for border in BORDERS {
            let is_near = |o: &(usize, [f64; 2], [f64; 2])| {
                let r = if border.across == 0 { o.1 } else { o.2 };
                o.0 == patch
                    && if border.upper {
                        r[0] >= 1.0 - STRIP
                    } else {
                        r[1] <= STRIP
                    }
            };
            let mut near = out.open.iter().filter(|o| is_near(o)).peekable();
            if near.peek().is_none() {
                continue;
            }
            let along = near.fold([1.0, 0.0], |hull: [f64; 2], o| {
                let r = if border.across == 0 { o.2 } else { o.1 };
                [hull[0].min(r[0]), hull[1].max(r[1])]
            });
            let strip = Strip::new(brep, stab, face, patch, border);
            if !is_small(&strip.root, TURNED, POLE) {
                continue;
            }
            if let Some(hits) = strip.hits(along, &out.hits, budget) {
                out.open.retain(|o| !is_near(o));
                out.hits.extend(hits);
            }
        }
    }
}

/// The border of a turned patch.
const TURNED: Border = Border {
    across: 1,
    upper: false,
};

/// A patch, turned such that a border is at the second coordinate's zero.
struct Strip<'a> {
    brep: &'a PreparedBrep,
    stab: &'a Stabber,
    face: usize,
    patch: usize,
    border: Border,
    net: Net<Dd>,
    root: Forms<Dd>,
}

impl<'a> Strip<'a> {
    fn new(
        brep: &'a PreparedBrep,
        stab: &'a Stabber,
        face: usize,
        patch: usize,
        border: Border,
    ) -> Self {
        let net = turned(&brep.double_double(face).patches[patch].net, border);
        Self {
            root: stab.planes(&net),
            brep,
            stab,
            face,
            patch,
            border,
            net,
        }
    }

    /// To the patch's own local parameters, or from them.
    fn turn(&self, [a, b]: [Dd; 2]) -> [Dd; 2] {
        let Border { across, upper } = self.border;
        if across == 1 {
            [a, if upper { Dd::ONE - b } else { b }]
        } else if upper {
            // From (a, b) to (1 - b, a).
            [Dd::ONE - b, a]
        } else {
            [b, a]
        }
    }

    /// From the patch's own local parameters.
    fn turn_back(&self, [u, v]: [Dd; 2]) -> [Dd; 2] {
        let Border { across, upper } = self.border;
        let (a, b) = if across == 1 { (u, v) } else { (v, u) };
        [a, if upper { Dd::ONE - b } else { b }]
    }

    /// The hits in the strip over a range of the border that are not known yet; `None` where that cannot be told.
    fn hits(&self, along: [f64; 2], known: &[RawHit], budget: &mut usize) -> Option<Vec<RawHit>> {
        let at = Place {
            face: self.face,
            patch: self.patch,
            net: &self.net,
            root: &self.root,
            digits: Digits::All,
        };
        let mut zeros: Vec<KnownZero> = Vec::new();
        let mut hits = Vec::new();
        let mut turned: [Vec<Dd>; 2] = Default::default();
        let mut stack = vec![restrict(&self.root, along, [0.0, STRIP])];
        while let Some(node) = stack.pop() {
            let within = |z: &[[f64; 2]; 2]| {
                let held = |z: [f64; 2], r: [f64; 2]| z[0] <= r[0] && r[1] <= z[1];
                held(z[0], node.u) && held(z[1], node.v)
            };
            if node.has_no_zero() || node.beyond(self.stab) || zeros.iter().any(|z| within(&z.zone))
            {
                continue;
            }
            *budget = budget.checked_sub(1)?;
            let (j, change) = node.slopes();
            let look = node.look(&j, &mut turned);
            if look.none {
                continue;
            }
            if look.noise {
                return None;
            }
            if look.one_at_most.is_some()
                && let Some(zero) = known_zero(self.stab, &at, &node)
            {
                let settled = within(&zero.zone);
                if !zeros.iter().any(|z| z.holds(zero.at, zero.reach)) {
                    // It may be one of these, or not.
                    if !zeros.iter().all(|z| z.is_apart(zero.at, zero.reach)) {
                        return None;
                    }
                    hits.extend(self.hit_of(&zero, known)?);
                    zeros.push(zero);
                }
                if settled {
                    continue;
                }
            }
            let across = node.v[0] == 0.0 && is_small(&node, TURNED, SMALL);
            let length = node.u[1] - node.u[0];
            if across && node.v[1] <= LEAST_WIDTH || length <= LEAST_LENGTH {
                return None;
            }
            stack.extend(node.halves(!across && change[0] >= change[1]));
        }
        Some(hits)
    }

    /// The hit that a zero is, unless it is known already or does not count; `None` where that cannot be told.
    fn hit_of(&self, zero: &KnownZero, known: &[RawHit]) -> Option<Option<RawHit>> {
        let KnownZero { at, reach, .. } = zero;
        // Beyond the border it is none; at other borders the next patch has a part in it.
        if at[1] + reach[1] < Dd::ZERO {
            return Some(None);
        }
        let on_patch = at[1] - reach[1] > Dd::ZERO
            && at[0] - reach[0] > Dd::ZERO
            && at[0] + reach[0] < Dd::ONE;
        if !on_patch {
            return None;
        }
        for hit in known {
            let HitAt::Patch {
                patch, local, rho, ..
            } = &hit.at
            else {
                continue;
            };
            if *patch != self.patch || hit.face != self.face {
                continue;
            }
            let (local, off) = (self.turn_back(*local), [Dd::from((rho + TURNING) * UP); 2]);
            if zero.holds(local, off) {
                return Some(None);
            }
            if !zero.is_apart(local, off) {
                return None;
            }
        }
        let (t, point) = parameter_at(self.stab, &self.net, zero)?;
        if self.stab.is_beyond(&t) {
            return Some(None);
        }
        let local = self.turn(*at);
        let maps = &self.brep.double(self.face).patches[self.patch].maps;
        let off = if self.border.across == 1 {
            *reach
        } else {
            [reach[1], reach[0]]
        };
        let uv = [0, 1].map(|k| {
            let x = Ball {
                mid: local[k],
                rad: (off[k].hi + TURNING) * UP,
            };
            maps[k].to_native_ball(x)
        });
        let side = self.brep.region(self.face).side_of_ball(uv);
        if side == Some(Side::Outside) {
            return Some(None);
        }
        Some(Some(RawHit {
            face: self.face,
            at: HitAt::Patch {
                patch: self.patch,
                local,
                rho: (reach[0].hi.max(reach[1].hi) + TURNING) * UP,
                point,
            },
            t,
            inside: side == Some(Side::Inside),
            at_joint: false,
            touches: false,
            exact: None,
        }))
    }
}

impl KnownZero {
    /// Whether what is within `off` of a place is in the zone in which this zero is the only one.
    fn holds(&self, p: [Dd; 2], off: [Dd; 2]) -> bool {
        (0..2).all(|k| {
            let [low, high] = self.zone[k].map(Dd::from);
            low <= p[k] - off[k] && p[k] + off[k] <= high
        })
    }

    /// Whether it is surely not.
    fn is_apart(&self, p: [Dd; 2], off: [Dd; 2]) -> bool {
        (0..2).any(|k| {
            let [low, high] = self.zone[k].map(Dd::from);
            p[k] + off[k] < low || p[k] - off[k] > high
        })
    }
}

/// A patch's net, turned such that a border is at the second coordinate's zero.
fn turned(net: &Net<Dd>, Border { across, upper }: Border) -> Net<Dd> {
    let Bidegree { u, v } = net.degree;
    let (along, over) = if across == 1 { (u, v) } else { (v, u) };
    let mut points = Vec::with_capacity(net.points.len());
    for i in 0..=along {
        for j in 0..=over {
            let j = if upper { over - j } else { j };
            let (p, q) = if across == 1 { (i, j) } else { (j, i) };
            points.push(net.points[p * (v + 1) + q]);
        }
    }
    Net::new(Bidegree { u: along, v: over }, points, net.origin)
}
