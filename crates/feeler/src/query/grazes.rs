//! Lines in a plane that is tangent to a face along its seam: they touch the face there, or pass it.
//!
//! # What is proven
//! Next to a seam there is a zero of the forms `L_k` of the module `zeros` that is double, or of a slope that is lost in rounding: no box about it holds one zero that is told
//! by slopes. But let one form vanish on the seam, exactly, for it does on the control points there; and let it be, with `b` the parameter from the seam inward, of one sign on the patch
//! in front of it where `b > 0`. It is so if it is of this sign on the last row of the patch's coefficients across, and of no other on those between: the first of these, which may be next to
//! nothing, is made of the second row of control points alone, with weights that are positive, and so has their sign, exactly (the surface is clamped, so that the row's
//! blossom takes the seam's knot and one other, where the patch ends); the rest is told from the zero by double-double.
//!
//! So zeros of the patch are on the seam. There the other form is monotone if the differences of its coefficients have one sign: there is one zero where its signs at the ends differ, none where they do not. The
//! zero is a corner if both forms vanish on that, exactly.
//!
//! With both patches at the seam of this kind, all zeros of both are known. Next to the zero the first form has one sign before the seam and one after it, and the other changes its sign along it.
//! If the first changes its sign over the seam, the map of both has the degree 1 or -1: the line passes to the other side of the surface. If not, it has the degree 0: the line touches it.

use super::border::{corner_in_line, has_sign, vanishes};
use super::certify::{POLISHED, forms_at};
use super::forms::{Forms, Stabber};
use super::hit_side::{OnBorder, side_at};
use super::zeros::{HitAt, RawHit};
use crate::numeric::{Ball, Dd, Real};
use crate::nurbs::Surface;
use crate::prepare::PreparedBrep;
use crate::trim::BoxSide;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// Halvings on the way to a zero, then steps along secants: near a tangency these begin well.
const HALVINGS: usize = 48;
const STEPS: usize = 12;
/// How many times, and by how much, what is about a zero is widened until the signs on either side are known.
const WIDENINGS: usize = 6;
const WIDER: f64 = 4.0;

/// What two patches have of the line, that meet at a seam.
pub(super) struct Graze {
    /// The patch beyond the seam; none where the patch itself has no zero.
    pub(super) mate: Option<usize>,
    /// All that is met of both: the hit, and where it is.
    pub(super) hit: Option<(RawHit, BoxSide)>,
}

/// A patch at a seam that all its zeros are on.
struct Flank {
    /// The sign of the form that vanishes on the seam, on all the rest of the patch.
    sign: i32,
    zero: Option<Zero>,
}

/// The zero on the seam.
struct Zero {
    /// In the local parameter along the seam.
    at: Ball<Dd>,
    /// Whether it is the upper end of that, or the lower, exactly.
    end: Option<bool>,
}

/// All that the line has of a patch and of the one beyond its seam, if all of it is on that; `root` are the forms on the patch.
pub(super) fn settle(
    brep: &PreparedBrep,
    stab: &Stabber,
    (face, patch): (usize, usize),
    root: &Forms<f64>,
) -> Option<Graze> {
    let Surface::Nurbs(surface) = brep.brep().surface(face) else {
        return None;
    };
    let patches = &brep.double(face).patches;
    let own = patches.maps_of(patch);
    let domain = surface.domain();
    for across in 0..2 {
        if !brep.meets_itself(face, across == 0) {
            continue;
        }
        let d = domain[across];
        for upper in [false, true] {
            let (here, there) = if upper {
                (own[across].end, d.start)
            } else {
                (own[across].start, d.end)
            };
            if here != if upper { d.end } else { d.start } {
                continue;
            }
            for form in 0..2 {
                if !may_vanish(root, form, across, upper)
                    || !vanishes(stab, surface, (across, upper), form)
                {
                    continue;
                }
                let flank = |patch: usize, upper: bool| {
                    Flank::new(brep, stab, (face, patch), (across, upper), form)
                };
                let Some(flank_here) = flank(patch, upper) else {
                    continue;
                };
                let Some(zero) = &flank_here.zero else {
                    return Some(Graze {
                        mate: None,
                        hit: None,
                    });
                };
                let is_mate = |p: &usize| {
                    let maps = patches.maps_of(*p);
                    let end = if upper {
                        maps[across].start
                    } else {
                        maps[across].end
                    };
                    end == there && maps[1 - across] == own[1 - across]
                };
                let mate = (0..patches.len()).find(is_mate)?;
                let beyond = flank(mate, !upper)?;
                // It is the same polynomial there, up to a factor, and has the same zero.
                let place = |patch: usize, upper: bool| PatchSide {
                    face,
                    patch,
                    across,
                    upper,
                };
                let sides = [place(patch, upper), place(mate, !upper)].map(|p| p.side(brep, zero));
                let side = if sides.contains(&BoxSide::Inside) {
                    BoxSide::Inside
                } else if sides == [BoxSide::Outside; 2] {
                    BoxSide::Outside
                } else {
                    return None;
                };
                let touches = flank_here.sign == beyond.sign;
                let hit = place(patch, upper).hit(brep, stab, zero, touches);
                return Some(Graze {
                    mate: Some(mate),
                    hit: Some((hit, side)),
                });
            }
        }
    }
    None
}

/// Whether a form may be zero on all of a border, by what f64 gives of it.
fn may_vanish(root: &Forms<f64>, form: usize, across: usize, upper: bool) -> bool {
    let [rows, columns] = [root.degree.u + 1, root.degree.v + 1];
    let count = if across == 0 { columns } else { rows };
    (0..count).all(|i| {
        let index = match (across, upper) {
            (0, false) => i,
            (0, true) => (rows - 1) * columns + i,
            (_, false) => i * columns,
            (_, true) => i * columns + columns - 1,
        };
        root.c[form][index].abs() <= root.error[form] * UP
    })
}

impl Flank {
    fn new(
        brep: &PreparedBrep,
        stab: &Stabber,
        (face, patch): (usize, usize),
        (across, upper): (usize, bool),
        form: usize,
    ) -> Option<Self> {
        let Surface::Nurbs(surface) = brep.brep().surface(face) else {
            return None;
        };
        let net = &brep.double_double(face).patches[patch].net;
        let forms = stab.planes(net);
        let offsets = [0, 1].map(|k| stab.offset(k, &net.origin));
        let [rows, columns] = [net.degree.u + 1, net.degree.v + 1];
        let (depth, length) = if across == 0 {
            (rows, columns)
        } else {
            (columns, rows)
        };
        if depth < 2 || length < 2 {
            return None;
        }
        // The i-th from the seam, the j-th along it.
        let at = |k: usize, i: usize, j: usize| {
            let i = if upper { depth - 1 - i } else { i };
            let index = if across == 0 {
                i * columns + j
            } else {
                j * columns + i
            };
            forms.c[k][index]
        };
        let known = |x: Dd, error: f64| -> Option<i32> {
            let off = Dd::from(error * UP);
            if x > off {
                Some(1)
            } else {
                (x < -off).then_some(-1)
            }
        };
        let sign = known(at(form, depth - 1, 0), forms.error[form])?;
        let told =
            |i: usize| (0..length).all(|j| known(at(form, i, j), forms.error[form]) == Some(sign));
        if !(2..depth).all(told) {
            return None;
        }
        if depth == 2 {
            if !told(1) {
                return None;
            }
        } else if !told(1) {
            let border = (across, upper);
            if !has_sign(stab, surface, border, 1, form, |s| s != -sign) {
                return None;
            }
        }
        // Along the seam.
        let other = 1 - form;
        let along = |j: usize| at(other, 0, j);
        let error = forms.error[other];
        // A difference is off by both, and by its own rounding.
        let mut steps = (1..length).map(|j| along(j) - along(j - 1));
        let off =
            2.0 * error + Dd::UNIT * (0..length).fold(0.0, |m: f64, j| m.max(along(j).magnitude()));
        let rising = known(along(1) - along(0), off)?;
        if !steps.all(|step| known(step, off) == Some(rising)) {
            return None;
        }
        let ends = [along(0), along(length - 1)].map(|x| known(x, error));
        let zero = match ends {
            [Some(a), Some(b)] if a == b => None,
            [Some(_), Some(_)] => {
                let value = |x: Dd| {
                    let mut local = [Dd::from(if upper { 1.0 } else { 0.0 }); 2];
                    local[1 - across] = x;
                    forms_at(stab, net, &offsets, local).1[other]
                };
                Some(Zero {
                    at: zero_of(value, rising)?,
                    end: None,
                })
            }
            [a, _] => {
                let end = a.is_some();
                let mut corner = [upper; 2];
                corner[1 - across] = end;
                let map = &brep.double(face).patches.maps_of(patch)[1 - across];
                let d = surface.domain()[1 - across];
                let on_domain = if end {
                    map.end == d.end
                } else {
                    map.start == d.start
                };
                if !(on_domain && corner_in_line(stab, brep.brep().surface(face), corner)) {
                    return None;
                }
                Some(Zero {
                    at: if end { Ball::ONE } else { Ball::ZERO },
                    end: Some(end),
                })
            }
        };
        Some(Self { sign, zero })
    }
}

/// The zero from 0 to 1 of a function that is monotone there, and changes its sign, from that at 0 to this: between two places where the signs are known.
fn zero_of(f: impl Fn(Dd) -> Ball<Dd>, rising: i32) -> Option<Ball<Dd>> {
    let mut ends = [Dd::ZERO, Dd::ONE];
    for _ in 0..HALVINGS {
        let middle = (ends[0] + ends[1]) * Dd::from(0.5);
        let above = f(middle).mid > Dd::ZERO;
        ends[usize::from(above == (rising > 0))] = middle;
    }
    let [mut before, mut x] = ends;
    let (mut value, mut last) = (f(x), f(before).mid);
    let mut slope = 0.0;
    for _ in 0..STEPS {
        let (run, over) = (value.mid - last, x - before);
        if run == Dd::ZERO || over == Dd::ZERO {
            break;
        }
        slope = (run / over).hi.abs();
        let step = value.mid * over / run;
        (before, last) = (x, value.mid);
        x = x - step;
        value = f(x);
        if step.hi.abs() <= POLISHED {
            break;
        }
    }
    let mut off = (value.magnitude() / slope).max(Dd::UNIT);
    for _ in 0..WIDENINGS {
        off *= WIDER;
        let place = |by: f64| {
            let y = x + Dd::from(by);
            if y < Dd::ZERO {
                Dd::ZERO
            } else if y > Dd::ONE {
                Dd::ONE
            } else {
                y
            }
        };
        let [low, high] = [f(place(-off)), f(place(off))];
        let [low, high] = if rising > 0 { [low, high] } else { [high, low] };
        if low.upper() < 0.0 && high.is_above(0.0) {
            return Some(Ball {
                mid: x,
                rad: off * UP,
            });
        }
    }
    None
}

/// The side of a patch that is on the seam: across which coordinate, and at which end of it.
struct PatchSide {
    face: usize,
    patch: usize,
    across: usize,
    upper: bool,
}

impl PatchSide {
    fn local(&self, zero: &Zero) -> [Ball<Dd>; 2] {
        let mut local = [zero.at; 2];
        local[self.across] = if self.upper { Ball::ONE } else { Ball::ZERO };
        local
    }

    /// Where it is in the face's region, over the seam too.
    fn side(&self, brep: &PreparedBrep, zero: &Zero) -> BoxSide {
        let domain = brep.brep().surface(self.face).domain();
        let at = |k: usize, upper: bool| {
            if upper {
                domain[k].end
            } else {
                domain[k].start
            }
        };
        let border = match zero.end {
            None => OnBorder::Seam(self.across),
            Some(end) => {
                let mut corner = [0.0; 2];
                corner[self.across] = at(self.across, self.upper);
                corner[1 - self.across] = at(1 - self.across, end);
                OnBorder::Corner(corner)
            }
        };
        let local = self.local(zero).map(|x| x.mid);
        side_at(
            brep,
            (self.face, self.patch),
            (local, zero.at.rad, Some(border)),
            None,
        )
    }

    fn hit(&self, brep: &PreparedBrep, stab: &Stabber, zero: &Zero, touches: bool) -> RawHit {
        let net = &brep.double_double(self.face).patches[self.patch].net;
        let local = self.local(zero);
        let value = net.jet(local[0], local[1]).value;
        RawHit {
            face: self.face,
            at: HitAt::Patch {
                patch: self.patch,
                local: local.map(|x| x.mid),
                rho: zero.at.rad,
                point: [0, 1, 2].map(|c| (value[c] / value[3] + Ball::exact(net.origin[c])).mid.hi),
            },
            t: stab.parameter(&value, &net.origin),
            inside: true,
            at_joint: false,
            touches,
            exact: None,
        }
    }
}
