//! Lists of all contacts of a sphere or a half-space.

use super::answer::{Contact, Options, Probe, Separation};
use super::contact::separation;
use super::local::{Spot, Surroundings, point};
use super::objective::{Objective, ball_around};
use super::outcome::{FormulaMinimum, Locus, Outcome, Settled, Source};
use super::place::{Centre, Place, make_contact, place_of, trim_at};
use crate::numeric::{Ball, Dd, Enclosure, Real};
use crate::prepare::PreparedBrep;
use crate::trim::Side;
use nalgebra::Point3;
use std::collections::BTreeSet;

/// Feet nearer to each other than this times the size are one contact.
const SAME_CONTACT: f64 = 1.0 / (1u64 << 24) as f64;

/// What grows with the distance of a contact's foot. In material the nearest has the largest separation; where the side is not
/// known the bounds are those of both, and their upper end is as on the outside.
fn nearness(c: &Contact, material: Option<bool>) -> f64 {
    match material {
        Some(false) => c.separation.value,
        Some(true) => -c.separation.value,
        None => c.separation.bounds.hi,
    }
}

/// The separation of the nearer of two places, whichever it is: faces may be a rounding apart at an edge.
fn nearer([a, b]: [Separation; 2], material: Option<bool>) -> Separation {
    let ([a_lo, a_hi], [b_lo, b_hi]) = ([a.bounds.lo, a.bounds.hi], [b.bounds.lo, b.bounds.hi]);
    let (lo, hi, value) = match material {
        Some(false) => (a_lo.min(b_lo), a_hi.min(b_hi), a.value.min(b.value)),
        Some(true) => (a_lo.max(b_lo), a_hi.max(b_hi), a.value.max(b.value)),
        None => (a_lo.min(b_lo), a_hi.max(b_hi), a.value),
    };
    Separation {
        value: value.clamp(lo, hi),
        bounds: Enclosure { lo, hi },
    }
}

/// What may be one of all contacts.
struct Candidate {
    place: Place,
    /// Bounds of `f`.
    range: [Dd; 2],
    /// `f` at the place. Where all of a node is one value up to rounding its minimum is elsewhere on it, and a way falls only if it falls by more.
    value: Ball<Dd>,
}

impl Candidate {
    /// The local minimum of a settled node, if it has one.
    fn of_node(brep: &PreparedBrep, objective: &Objective, s: &Settled) -> Option<Self> {
        // At the end of the face, or on a crease, a patch alone goes on falling: whether another is lower is tested of every candidate.
        if !(s.local_minimum || s.on_border) {
            return None;
        }
        let (mut place, index, mut local) = place_of(brep, s)?;
        let patch = &brep.double_double(place.face).patches[index];
        if let Some(Source::Patch { face, .. }) = s.source {
            // A foot beside the region is none: the border's own is.
            if brep.region(face).side(place.uv).side == Some(Side::Outside) {
                return None;
            }
            let at = [place.uv.x, place.uv.y];
            local = [0, 1].map(|k| patch.maps[k].to_local(Ball::exact(at[k])));
            place.spot = Locus::Patch {
                patch: index,
                local,
                point: None,
            };
        }
        // A piece that passes the border of its patch is known to be on it there, up to a slack: the ball holds the patch's own point.
        for x in &mut local {
            let inside = if x.mid < Dd::ZERO {
                Dd::ZERO
            } else if x.mid > Dd::ONE {
                Dd::ONE
            } else {
                continue;
            };
            x.rad = (x.rad + (x.mid - inside).magnitude()) * (1.0 + 4.0 * f64::EPSILON);
            x.mid = inside;
        }
        // Below: the bound of the node. Above: f at the point itself.
        let f = objective.value(&patch.net, local);
        let hi = f.mid + Dd::from(f.rad * (1.0 + 16.0 * f64::EPSILON));
        let more = match s.flat {
            true => (f.mid - s.lo).magnitude(),
            false => 0.0,
        };
        Some(Self {
            place,
            range: [s.lo, hi],
            value: Ball {
                mid: f.mid,
                rad: f.rad + more,
            },
        })
    }

    fn of_formula(m: &FormulaMinimum) -> Self {
        let value = ball_around(m.here);
        let place = Place {
            face: m.face,
            trim: m.trim,
            spot: Locus::Closed { point: m.point },
            uv: m.uv,
        };
        Self {
            place,
            range: m.range,
            value,
        }
    }
}

/// Whether a node may hold a minimum that is one of all contacts: not if a way along its trim, or across the face, leads down to below all that
/// is on it.
pub(super) fn may_be_contact(around: &Surroundings, s: &Settled) -> bool {
    let Some(Source::Piece { face, index }) = s.source else {
        return true;
    };
    let piece = around.brep.double(face).piece(index);
    let Some(trim) = piece.trim else {
        return true;
    };
    let flat = Settled { flat: true, ..*s };
    let candidate = Candidate::of_node(around.brep, around.objective, &flat);
    candidate.is_none_or(|c| {
        let Place { face, uv, .. } = c.place;
        let point = point(around.brep, Spot { face, uv });
        let [start, end] = piece.span;
        let parameter = start + s.at[0] * (end - start);
        !around.falls_about((trim, parameter), &point, c.value)
    })
}

/// What a list of all contacts is made of.
pub(super) struct List<'a> {
    pub(super) brep: &'a PreparedBrep,
    pub(super) probe: &'a Probe,
    pub(super) options: &'a Options,
    pub(super) objective: &'a Objective,
    pub(super) material: Option<bool>,
}

/// A list in the making.
struct Made<'a> {
    out: &'a mut Vec<Contact>,
    /// Where their feet are.
    feet: Feet,
    around: Surroundings<'a>,
    /// Whether the first is the deepest of all.
    with_deepest: bool,
}

impl List<'_> {
    /// Adds all contacts but the deepest, which is there if there is one, in order. How many nodes that took, and whether all places were looked at: it has a
    /// budget of its own, however the search went, so that what is found is told.
    pub(super) fn fill(&self, found: &Outcome, out: &mut Vec<Contact>) -> (usize, bool) {
        let with_deepest = !out.is_empty();
        let mut feet = Feet::apart(SAME_CONTACT * self.brep.size());
        for (k, c) in out.iter().enumerate() {
            feet.add(k, &c.on_brep);
        }
        let mut made = Made {
            out,
            feet,
            around: Surroundings::new(self.brep, self.objective),
            with_deepest,
        };
        let nodes = found
            .settled
            .iter()
            .filter_map(|s| Candidate::of_node(self.brep, self.objective, s));
        let formulas = found.formulas.iter().map(Candidate::of_formula);
        let (mut places, mut spent) = (0, 0);
        let mut is_whole = true;
        for candidate in nodes.chain(formulas).filter(|c| self.is_near(c)) {
            if spent >= self.options.node_budget {
                is_whole = false;
                break;
            }
            self.add(&candidate, &mut made);
            places += 1;
            spent = places + made.around.nodes();
        }
        out[usize::from(with_deepest)..].sort_by(|a, b| {
            let by_distance = nearness(a, self.material).total_cmp(&nearness(b, self.material));
            by_distance.then(a.feature.cmp(&b.feature))
        });
        (spent, is_whole)
    }

    /// Whether one is within reach.
    fn is_near(&self, candidate: &Candidate) -> bool {
        // In material, too, it is the distance that counts.
        let reach = Dd::from(self.probe.radius()) + Dd::from(self.options.prediction);
        let most = if self.options.prediction == f64::INFINITY {
            // Sums and products with it are no numbers.
            Dd::from(f64::INFINITY)
        } else if !self.objective.is_squared() {
            reach
        } else if reach > Dd::ZERO {
            reach * reach
        } else {
            return false;
        };
        let value = candidate.value;
        !(value.mid - Dd::from(value.rad) > most)
    }

    /// Adds one, if it is new and a minimum.
    fn add(&self, candidate: &Candidate, made: &mut Made) {
        let Candidate {
            place,
            range,
            value,
        } = candidate;
        let (brep, radius) = (self.brep, self.probe.radius());
        let near = separation(*range, self.objective, radius, self.material);
        let c = make_contact(
            brep,
            self.probe,
            place,
            near,
            Centre {
                in_material: self.material == Some(true),
                may_touch: !(range[0] > Dd::ZERO),
            },
            self.options.accuracy,
            None,
        );
        let is_same = |k: usize| (made.out[k].on_brep - c.on_brep).norm() <= made.feet.apart;
        if let Some(i) = made.feet.first_near(&c.on_brep, is_same) {
            // The first is the deepest of all: its separation is the answer's.
            if i > 0 || !made.with_deepest {
                let other = &mut made.out[i];
                let both = nearer([other.separation, c.separation], self.material);
                // The lower one is the contact's foot. (With the centre in material the nearer one.)
                if nearness(&c, self.material) < nearness(other, self.material) {
                    made.feet.remove(i, &other.on_brep);
                    made.feet.add(i, &c.on_brep);
                    *other = c;
                }
                other.separation = both;
            }
            return;
        }
        let own = Spot {
            face: place.face,
            uv: place.uv,
        };
        let trim = place.trim.or_else(|| trim_at(brep, place));
        if made.around.is_minimum(own, trim, &c.on_brep, *value) {
            made.feet.add(made.out.len(), &c.on_brep);
            made.out.push(c);
        }
    }
}

/// The numbers of contacts, by where their feet are: those near a point are found without a look at all of them.
struct Feet {
    /// Nearer to each other than this they are one.
    apart: f64,
    cells: BTreeSet<([i64; 3], usize)>,
}

impl Feet {
    /// Sides of cells in parts of `apart`: a power of two, so that nothing is rounded but where a foot is far from the origin, and there
    /// neighbours share their cells...
    const SIDE: f64 = 4.0;
    /// ...and how far around a point they are looked for, with room for roundings.
    const REACH: f64 = 1.5;

    fn apart(apart: f64) -> Self {
        Self {
            apart,
            cells: BTreeSet::new(),
        }
    }

    /// The cell of a point moved by so much along all axes. (What is beyond the range of the numbers is at its end, in one cell with all others there.)
    fn cell(&self, p: &Point3<f64>, by: f64) -> [i64; 3] {
        [0, 1, 2].map(|c| ((p[c] + by) / (Self::SIDE * self.apart)).floor() as i64)
    }

    fn add(&mut self, k: usize, foot: &Point3<f64>) {
        self.cells.insert((self.cell(foot, 0.0), k));
    }

    fn remove(&mut self, k: usize, foot: &Point3<f64>) {
        self.cells.remove(&(self.cell(foot, 0.0), k));
    }

    /// The first of those in cells about a point that is one of these.
    ///
    /// A foot within `apart` of it is within `REACH` times that as computed, or shares its coordinate, as rounding keeps order: so its cell is
    /// from that of the one end to that of the other, two at most along each axis.
    fn first_near(&self, p: &Point3<f64>, is_one: impl Fn(usize) -> bool) -> Option<usize> {
        let reach = Self::REACH * self.apart;
        let [low, high] = [self.cell(p, -reach), self.cell(p, reach)];
        let all = (0..8usize).filter_map(|corner| {
            let is_high = |c: usize| corner >> c & 1 == 1;
            // Where both ends are in one cell it is looked at once.
            if (0..3).any(|c| is_high(c) && low[c] == high[c]) {
                return None;
            }
            let cell = [0, 1, 2].map(|c| if is_high(c) { high[c] } else { low[c] });
            let own = self.cells.range((cell, 0)..=(cell, usize::MAX));
            own.map(|(_, k)| *k).find(|k| is_one(*k))
        });
        all.min()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Feet found by their cells are those that a look at all of them finds, near the borders of cells, far out, and beyond what cells count.
    #[test]
    fn feet_near_a_point_are_found() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            (state >> 40) as f64 / (1u64 << 24) as f64
        };
        let mut hits = 0;
        /// How far feet of one contact are apart at most, and how far all are from the origin, in units of length: at the last, and where
        /// they are 1e24 times as far out, cells are not counted any more.
        const SCENES: [(f64, f64); 5] = [
            (1.0, 0.0),
            (0.1, 1e3),
            (1e-12, 1.0),
            (1e-9, 1e15),
            (0.0, 1.0),
        ];
        for (apart, far) in SCENES {
            let mut feet = Feet::apart(apart);
            let mut all: Vec<Point3<f64>> = Vec::new();
            for round in 0..600 {
                // On a grid as often as not, whose points are that far apart.
                let step = |x: f64| if round % 2 == 0 { x.floor() } else { x };
                let p = Point3::from([0, 1, 2].map(|_| far + apart * step(8.0 * random() - 4.0)));
                let is_one = |k: usize| (all[k] - p).norm() <= apart;
                let first = (0..all.len()).find(|k| is_one(*k));
                assert_eq!(feet.first_near(&p, is_one), first, "{apart} {far} {round}");
                match first {
                    Some(k) => {
                        hits += 1;
                        feet.remove(k, &all[k]);
                        feet.add(k, &p);
                        all[k] = p;
                    }
                    None => {
                        feet.add(all.len(), &p);
                        all.push(p);
                    }
                }
            }
        }
        assert!(hits > 600, "{hits}");
    }
}
