//! Hits of a line that holds a whole row of a face: a parameter line `u = a` or `v = a`, a ruling or a pole.
//!
//! # What is proven
//! On a row that lies in the line, exactly ([`row_in_line`]), all points are hits: an interval of `t`, or where the row is one point (a pole), this. Both
//! forms `L_k` of the module `zeros` vanish on it, so no box about a part of it is ever put aside, nor holds one zero. But `L_k = (a - s) M_k` with
//! polynomials `M_k` of one degree less along `a`, whose coefficients follow from those of `L_k` one by one from the end where `s` is the farther: what
//! is not on the row is a zero of both `M_k`. They have none in a strip about the row where combinations of them have one sign on boxes that cover it; the
//! rest of the patch is searched as ever.
//!
//! A row that is one point is left to others unless it is on a border of the surface that does not close about it: whether the line crosses there hangs on
//! all that is about it. There the point is on a border of the face, and the `M_k` have no common zero there: the line is along no direction of the face, it is not tangent.

use super::forms::{Forms, Stabber, restrict};
use super::hit_side::row_side;
use super::zeros::{HitAt, RawHit};
use crate::numeric::bernstein::{Bidegree, split_off};
use crate::numeric::{Ball, Dd};
use crate::nurbs::Surface;
use crate::prepare::{Meeting, PreparedBrep, Ratio, When, row_in_line};
use crate::trim::BoxSide;
use std::cmp::Ordering;

/// Half of the widths of strips that are tried, in local parameters.
const STRIPS: [f64; 4] = [
    1.0,
    1.0 / (1u64 << 4) as f64,
    1.0 / (1u64 << 10) as f64,
    1.0 / (1u64 << 20) as f64,
];
/// So many boxes cover a strip at most.
const MOST_BOXES: usize = 256;
/// Where a row may be is looked for as closely as this, in local parameters.
const CLOSE: f64 = 1.0 / (1u64 << 40) as f64;
/// Halvings of a range of f64 that leave nothing of it.
const HALVINGS: usize = 64;
/// At a row that f64 found the forms are below this part of their largest coefficient.
const NEXT_TO_NOTHING: f64 = 1.0 / (1u64 << 30) as f64;

/// A row of a face that lies in the line.
struct Row {
    across: usize,
    at: f64,
    /// `t` at both ends.
    t: [Ratio; 2],
}

/// Rows of one face that lie in the line.
#[derive(Default)]
pub(super) struct Rows {
    found: Vec<Row>,
    /// Parameter lines that were looked at: across which coordinate, where, and `t` at both ends if they are in the line. They are the same from all
    /// patches that they are on, for the surface is continuous.
    tried: Vec<(usize, f64, Option<[Ratio; 2]>)>,
}

impl Rows {
    /// The boxes of a patch that are left to search if it has a row in the line; `None` if it has none, or if this cannot tell within the budget.
    pub(super) fn leave_out(
        &mut self,
        brep: &PreparedBrep,
        stab: &Stabber,
        (face, patch): (usize, usize),
        root: &Forms<f64>,
        budget: &mut usize,
    ) -> Option<Vec<[[f64; 2]; 2]>> {
        let at = (0..2).filter_map(|across| Some((across, place(root, across)?)));
        at.into_iter().find_map(|(across, near)| {
            self.leave_out_row(brep, stab, (face, patch), (across, near), budget)
        })
    }

    fn leave_out_row(
        &mut self,
        brep: &PreparedBrep,
        stab: &Stabber,
        (face, patch): (usize, usize),
        (across, near): (usize, f64),
        budget: &mut usize,
    ) -> Option<Vec<[[f64; 2]; 2]>> {
        let Surface::Nurbs(surface) = brep.brep().surface(face) else {
            return None;
        };
        let maps = &brep.double(face).patches[patch].maps;
        let map = &maps[across];
        let [low, high] = map.to_native_range((near - CLOSE).max(0.0), (near + CLOSE).min(1.0));
        let at = if low <= map.start {
            map.start
        } else if high >= map.end {
            map.end
        } else {
            simplest([low, high])
        };
        let known = self.tried.iter().find(|r| (r.0, r.1) == (across, at));
        let t = match known {
            Some((.., t)) => t.clone(),
            None => {
                let count = surface.counts()[1 - across];
                *budget = budget.checked_sub(count)?;
                let line = (&stab.origin, &stab.direction);
                let t = row_in_line(surface, across, at, [map.start, map.end], line);
                self.tried.push((across, at, t.clone()));
                t
            }
        }?;
        // A point that the surface may close about is left to others.
        let domain = surface.domain();
        let on_border = at == domain[across].start || at == domain[across].end;
        if t[0].cmp(&t[1]).is_eq() && (!on_border || brep.meets_itself(face, across == 1)) {
            return None;
        }
        // All of the row is in the region, or none of it.
        let side = row_side(brep, face, across, at);
        if side == BoxSide::Mixed {
            return None;
        }
        let root = stab.planes(&brep.double_double(face).patches[patch].net);
        let s = map.to_local(Ball::exact(at));
        let others = deflated(&root, across, s);
        let strip = STRIPS.iter().find_map(|half| {
            let strip = [(s.mid.hi - half).max(0.0), (s.mid.hi + half).min(1.0)];
            let mut b = [[0.0, 1.0]; 2];
            b[across] = strip;
            let outside = |b: [[f64; 2]; 2]| {
                let native = [0, 1].map(|k| maps[k].to_native_range(b[k][0], b[k][1]));
                brep.region(face).classify_box(native[0], native[1]) == BoxSide::Outside
            };
            has_no_zero(&others, b, stab, outside, budget).then_some(strip)
        })?;
        let known = |r: &Row| r.across == across && r.at == at;
        if side == BoxSide::Inside && !self.found.iter().any(known) {
            self.found.push(Row { across, at, t });
        }
        let rest = [[0.0, strip[0]], [strip[1], 1.0]];
        let boxes = rest.into_iter().filter(|r| r[0] < r[1]).map(|r| {
            let mut b = [[0.0, 1.0]; 2];
            b[across] = r;
            b
        });
        Some(boxes.collect())
    }
}

/// Where, in local parameters, a row may be on which both forms vanish: on each of its columns each has a zero.
fn place(root: &Forms<f64>, across: usize) -> Option<f64> {
    let Bidegree { u, v } = root.degree;
    let [degree, others] = if across == 0 { [u, v] } else { [v, u] };
    if degree == 0 {
        return None;
    }
    let index = |i: usize, j: usize| match across {
        0 => i * (v + 1) + j,
        _ => j * (v + 1) + i,
    };
    let (mut largest, mut best) = (0.0, None);
    for k in 0..2 {
        for j in 0..=others {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for i in 0..=degree {
                let x = root.c[k][index(i, j)];
                (low, high) = (low.min(x), high.max(x));
            }
            if low > root.error[k] || high < -root.error[k] {
                return None;
            }
            let size = high.max(-low);
            if size > largest {
                (largest, best) = (size, Some((k, j)));
            }
        }
    }
    let (k, j) = best?;
    let column: Vec<f64> = (0..=degree).map(|i| root.c[k][index(i, j)]).collect();
    let is_row = |s: &f64| {
        let mut b = [[0.0, 1.0]; 2];
        b[across] = [*s; 2];
        let row = restrict(root, b[0], b[1]);
        let small = |x: &f64| x.abs() <= NEXT_TO_NOTHING * largest;
        row.c[..2].iter().flatten().all(small)
    };
    // Borders first: a zero there may be double, and is then told from its neighbours by no digits.
    let ends = [0.0, 1.0].into_iter().find(is_row);
    ends.or_else(|| zeros_of(column).into_iter().find(is_row))
}

/// Where a polynomial may have zeros from 0 to 1, to [`CLOSE`]: no more than its degree are told. Of what is told nothing is believed.
fn zeros_of(column: Vec<f64>) -> Vec<f64> {
    let most = column.len();
    let size = column.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let noise = 4.0 * f64::EPSILON * most as f64 * size;
    let mut zeros: Vec<f64> = Vec::new();
    let mut stack = vec![(column, [0.0, 1.0])];
    while let Some((mut low, [a, b])) = stack.pop() {
        let range = |r: [f64; 2], x: &f64| [r[0].min(*x), r[1].max(*x)];
        let [least, largest] = low.iter().fold([f64::INFINITY, f64::NEG_INFINITY], range);
        if least > noise || largest < -noise || zeros.len() >= most {
            continue;
        }
        let m = 0.5 * (a + b);
        if b - a <= CLOSE {
            // What is next to an end of a box is in both.
            if !zeros.iter().any(|z| (m - z).abs() <= 4.0 * CLOSE) {
                zeros.push(m);
            }
            continue;
        }
        let high = split_off(&mut low, Bidegree { u: most - 1, v: 0 }, true);
        stack.push((high, [m, b]));
        stack.push((low, [a, m]));
    }
    zeros
}

/// The number with the fewest digits from one to another.
fn simplest([low, high]: [f64; 2]) -> f64 {
    if low <= 0.0 && high >= 0.0 {
        return 0.0;
    }
    let mut found = low;
    // From steps that hold both ends down: with the first that has a multiple between them this is found.
    let exponent = low.abs().max(high.abs()).to_bits() >> (f64::MANTISSA_DIGITS - 1);
    let mut step = f64::from_bits((exponent + 1) << (f64::MANTISSA_DIGITS - 1));
    while step > 0.0 && step.is_finite() {
        let multiple = (low / step).ceil() * step;
        if multiple <= high {
            found = multiple;
            break;
        }
        step *= 0.5;
    }
    found
}

/// `M_1` and `M_2` over a patch with its own degree, and the rest as it was, given that both forms are zero at `s` across.
fn deflated(root: &Forms<Dd>, across: usize, s: Ball<Dd>) -> Forms<Dd> {
    let Bidegree { u, v } = root.degree;
    let [degree, others] = if across == 0 { [u, v] } else { [v, u] };
    let index = |i: usize, j: usize| match across {
        0 => i * (v + 1) + j,
        _ => j * (v + 1) + i,
    };
    let number = |n: usize| Ball::<Dd>::exact(n as f64);
    let left = Ball::ONE - s;
    let mut out = root.clone();
    for k in 0..2 {
        out.error[k] = 0.0;
        for j in 0..=others {
            let l = |i: usize| Ball {
                mid: root.c[k][index(i, j)],
                rad: root.error[k],
            };
            // With the binomials: p L_i = (1 - s) i M_(i-1) - s (p - i) M_i.
            let mut m = vec![Ball::<Dd>::ZERO; degree];
            if s.mid.hi < 0.5 {
                for i in (1..=degree).rev() {
                    let next = m.get(i).copied().unwrap_or(Ball::ZERO);
                    let top = number(degree) * l(i) + s * number(degree - i) * next;
                    m[i - 1] = top / (left * number(i));
                }
            } else {
                for i in 0..degree {
                    let before = if i > 0 { m[i - 1] } else { Ball::ZERO };
                    let top = left * number(i) * before - number(degree) * l(i);
                    m[i] = top / (s * number(degree - i));
                }
            }
            for i in 0..=degree {
                let before = if i > 0 { m[i - 1] } else { Ball::ZERO };
                let here = m.get(i).copied().unwrap_or(Ball::ZERO);
                let raised = (number(i) * before + number(degree - i) * here) / number(degree);
                out.c[k][index(i, j)] = raised.mid;
                // Negated: what is not a number bounds nothing.
                if !(raised.rad <= out.error[k]) {
                    out.error[k] = raised.rad;
                }
            }
        }
    }
    out
}

/// Whether forms surely have no zero on a box, but in what is outside of the region or of the line's range.
fn has_no_zero(
    forms: &Forms<Dd>,
    b: [[f64; 2]; 2],
    stab: &Stabber,
    outside: impl Fn([[f64; 2]; 2]) -> bool,
    budget: &mut usize,
) -> bool {
    let mut turned: [Vec<Dd>; 2] = Default::default();
    let mut stack = vec![restrict(forms, b[0], b[1])];
    for _ in 0..MOST_BOXES {
        let Some(node) = stack.pop() else {
            return true;
        };
        if *budget == 0 {
            return false;
        }
        *budget -= 1;
        if node.has_no_zero() || node.beyond(stab) {
            continue;
        }
        let (jacobian, change) = node.slopes();
        if node.look(&jacobian, &mut turned).none || outside([node.u, node.v]) {
            continue;
        }
        stack.extend(node.halves(change[0] >= change[1]));
    }
    stack.is_empty()
}

impl Rows {
    /// Adds the hits to those with the rest of the face: each part of the line that rows cover is one, and what else is met there adds none.
    pub(super) fn add_hits(
        self,
        brep: &PreparedBrep,
        stab: &Stabber,
        face: usize,
        hits: &mut Vec<RawHit>,
    ) {
        let mut rows = self.found;
        rows.sort_by(|a, b| a.least().cmp(b.least()));
        let mut merged: Vec<(Vec<Row>, Ratio)> = Vec::new();
        for row in rows {
            let most = row.most().clone();
            match merged.last_mut() {
                Some((together, end)) if row.least().cmp(end).is_le() => {
                    if most.cmp(end).is_gt() {
                        *end = most;
                    }
                    together.push(row);
                }
                _ => merged.push((vec![row], most)),
            }
        }
        for (together, end) in merged {
            let ends = [together[0].least().enclosed(), end.enclosed()];
            hits.retain_mut(|h| {
                let within = ends[0].upper() <= h.t.lower() && h.t.upper() <= ends[1].lower();
                let apart = h.t.upper() < ends[0].lower() || ends[1].upper() < h.t.lower();
                h.inside &= within || apart;
                !within
            });
            hits.extend(hit(brep, stab, face, &together, end));
        }
    }
}

/// The hit of rows that are one together, up to an end; `None` where it is beyond the line's range.
fn hit(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    together: &[Row],
    end: Ratio,
) -> Option<RawHit> {
    let start = together.first()?.least().clone();
    let point = start.cmp(&end).is_eq();
    let meeting = Meeting {
        t: When::Exact(start),
        end: (!point).then_some(When::Exact(end)),
        touches: !point,
        on: Vec::new(),
        end_on: Vec::new(),
        along: Vec::new(),
        // Looked for below.
        uv: [0.0; 2],
    };
    let meeting = meeting.within(stab.range, |_| [0.0; 2])??;
    let When::Exact(start) = &meeting.t else {
        return None;
    };
    let holds = |r: &&Row| r.least().cmp(start).is_le() && r.most().cmp(start).is_ge();
    let row = together.iter().find(holds)?;
    let t = meeting.t.enclosed();
    let (patch, local) = local(brep, face, row.place(brep, stab, face, t.mid.hi))?;
    let point = |c: usize| {
        (Ball::exact(stab.origin[c]) + t * Ball::exact(stab.direction[c]))
            .mid
            .hi
    };
    Some(RawHit {
        face,
        at: HitAt::Patch {
            patch,
            local: local.map(Dd::from),
            rho: 0.0,
            point: [0, 1, 2].map(point),
        },
        t,
        inside: true,
        at_joint: false,
        touches: meeting.touches,
        exact: Some(Box::new(meeting)),
    })
}

impl Row {
    fn least(&self) -> &Ratio {
        match self.t[0].cmp(&self.t[1]) {
            Ordering::Greater => &self.t[1],
            _ => &self.t[0],
        }
    }

    fn most(&self) -> &Ratio {
        match self.t[0].cmp(&self.t[1]) {
            Ordering::Greater => &self.t[0],
            _ => &self.t[1],
        }
    }

    /// The row's parameters at a place of the line, rounded: `t` is that of one of its ends at an end, and runs through all between.
    fn place(&self, brep: &PreparedBrep, stab: &Stabber, face: usize, t: f64) -> [f64; 2] {
        let surface = brep.brep().surface(face);
        let domain = surface.domain()[1 - self.across];
        let uv = |along: f64| {
            let mut uv = [along; 2];
            uv[self.across] = self.at;
            uv
        };
        let ends = [0, 1].map(|k| self.t[k].enclosed().mid.hi);
        let mut range = [domain.start, domain.end];
        if let Some(k) = (0..2).find(|k| ends[*k] == t) {
            return uv(range[k]);
        }
        let c = stab.axis;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (range[0] + range[1]);
            let [u, v] = uv(middle);
            let here = (surface.point(u, v)[c] - stab.origin[c]) / stab.direction[c];
            let first = (here < t) == (ends[0] <= ends[1]);
            range[usize::from(!first)] = middle;
        }
        uv(0.5 * (range[0] + range[1]))
    }
}

/// The patch that native parameters are on, and where.
fn local(brep: &PreparedBrep, face: usize, uv: [f64; 2]) -> Option<(usize, [f64; 2])> {
    let patches = &brep.double(face).patches;
    let index = patches.holding(uv)?;
    let maps = patches.maps_of(index);
    let local = [0, 1].map(|k| {
        let x: Ball<f64> = maps[k].to_local(Ball::exact(uv[k]));
        x.mid.clamp(0.0, 1.0)
    });
    Some((index, local))
}
