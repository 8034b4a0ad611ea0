//! Where a ray from a point meets a part of a piece: f64, then double-double, then integers.

use super::piece::{Control, Exact, Horner, Piece};
use super::source::Ball3;
use super::split::{Trend, split};
use crate::numeric::polynomial::{Parameter, Polynomial};
use crate::numeric::roots::Roots;
use crate::numeric::{Ball, Dd};

/// A part of a piece between two parameters, with boxes: what most questions about it need is in one line of a processor's cache.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(super) struct Part {
    /// Box of the part, rounded outward, `[axis][lo, hi]`.
    pub(super) hull: [[f64; 2]; 2],
    /// Proven range of [`Chord::level`] over the part; unbounded where it is not known.
    band: [f64; 2],
    /// Which piece it is of.
    pub(super) piece: u32,
    /// Which joint it starts at, if it has [any](Loops::joints).
    joint: u32,
    /// A number farther within the hull's range of a coordinate than this is between the coordinates of the ends; infinite where these are
    /// not the least and the greatest.
    margin: f32,
    /// Whether it joins two ends that do not meet.
    pub(super) join: bool,
    pub(super) trends: [Trend; 2],
}

const _: () = assert!(size_of::<Part>() == 64);

/// Where a part starts or ends on its piece.
#[derive(Debug, Clone, Copy)]
pub(super) struct Joint {
    pub(super) t: f64,
    /// Enclosure of the point there, `[axis][lo, hi]`.
    pub(super) at: [[f64; 2]; 2],
}

/// What a region's loops are made of.
#[derive(Debug, Default)]
pub(super) struct Loops {
    /// In the order of the loops.
    pub(super) pieces: Vec<Piece>,
    /// What these are split into, in their order.
    pub(super) parts: Vec<Part>,
    /// Where the parts of a piece start and end, each where the one before it ends. A part has none whose ends are corners of its box and those of its piece, as
    /// all segments are.
    joints: Vec<Joint>,
}

impl Loops {
    /// Splits a piece, given its source's control points, and adds it and its parts; its box becomes that of its parts.
    pub(super) fn push(&mut self, mut piece: Piece, is_join: bool, balls: &[Ball3]) {
        let (index, control) = (self.pieces.len() as u32, Control::new(balls));
        let first = self.joints.len();
        let split = split(&piece, balls);
        let joints = split.t.iter().map(|t| Joint {
            t: *t,
            at: piece.enclosure(*t, balls),
        });
        self.joints.extend(joints);
        let mut hull = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for (i, trends) in split.trends.iter().enumerate() {
            let ends = [self.joints[first + i], self.joints[first + i + 1]];
            let [a, b] = ends.map(|e| e.at);
            let part_hull = [0, 1].map(|axis| {
                if trends[axis] == Trend::Mixed {
                    piece.sub_hull(axis, ends.map(|e| e.t), balls)
                } else {
                    [a[axis][0].min(b[axis][0]), a[axis][1].max(b[axis][1])]
                }
            });
            for axis in 0..2 {
                hull[axis][0] = hull[axis][0].min(part_hull[axis][0]);
                hull[axis][1] = hull[axis][1].max(part_hull[axis][1]);
            }
            let mut part = Part {
                hull: part_hull,
                band: [f64::NEG_INFINITY, f64::INFINITY],
                piece: index,
                joint: (first + i) as u32,
                margin: f32::INFINITY,
                join: is_join,
                trends: *trends,
            };
            if part.is_monotone() {
                part.set_band(&control, ends.map(|e| e.t));
                part.margin = part.end_margin([a, b]);
            }
            self.parts.push(part);
        }
        if let ([.., part], [_]) = (&mut *self.parts, &*split.trends) {
            let ends = [self.joints[first], self.joints[first + 1]];
            let alone = part.ends_alone();
            if part.is_monotone()
                && (0..2).all(|e| ends[e].t == alone[e].t && ends[e].at == alone[e].at)
            {
                part.joint = ALONE;
                self.joints.truncate(first);
            }
        }
        if !split.trends.is_empty() {
            // They are together a narrower box than that of its control points.
            piece.hull = hull;
        }
        // Most pieces are never asked again for what the ends of their parts took.
        self.pieces.push(piece.afresh());
    }

    /// The same, without what has been made of pieces.
    pub(super) fn afresh(&self) -> Self {
        Self {
            pieces: self.pieces.iter().map(Piece::afresh).collect(),
            parts: self.parts.clone(),
            joints: self.joints.clone(),
        }
    }

    pub(super) fn shrink_to_fit(&mut self) {
        self.pieces.shrink_to_fit();
        self.parts.shrink_to_fit();
        self.joints.shrink_to_fit();
    }

    /// Bytes that its lists hold, what is made of pieces when it is asked for aside.
    pub(super) fn bytes(&self) -> usize {
        self.pieces.capacity() * size_of::<Piece>()
            + self.parts.capacity() * size_of::<Part>()
            + self.joints.capacity() * size_of::<Joint>()
    }
}

/// Stands for no joint.
const ALONE: u32 = u32::MAX;

/// The line through two points, any two: `level(p) = (u - u0) dv - (v - v0) du`, exactly, is what it says.
pub(super) struct Chord {
    pub(super) base: [f64; 2],
    pub(super) step: [f64; 2],
}

impl Chord {
    /// The level of a point in f64, and a bound on its error: two differences, two products and their
    /// difference are each off by at most u = 2^-53 relative, so the sum is off by
    /// at most 4u (1 + 4u) times the magnitudes of the two products; 6u leaves room for the comparison's own rounding.
    #[inline]
    pub(super) fn level(&self, q: [f64; 2]) -> (f64, f64) {
        let a = (q[0] - self.base[0]) * self.step[1];
        let b = (q[1] - self.base[1]) * self.step[0];
        (
            a - b,
            3.0 * f64::EPSILON * (a.abs() + b.abs()) + f64::MIN_POSITIVE,
        )
    }
}

/// What a part does to the parity along the ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Crossing {
    /// An even number of crossings.
    Even,
    /// An odd number.
    Odd,
    /// The point is on the part.
    On,
    /// Could not be settled (only on parts known in enclosures).
    Unknown,
}

/// What is told of a part without its piece.
enum AtOnce {
    Told(Crossing),
    /// Nothing but that a monotone part crosses the height once.
    Once,
    Nothing,
}

impl Crossing {
    pub(super) fn odd(odd: bool) -> Self {
        if odd { Self::Odd } else { Self::Even }
    }
}

impl Part {
    /// The ends of a monotone part that is all of its piece and ends in corners of its box.
    fn ends_alone(&self) -> [Joint; 2] {
        let Chord { base, step: _ } = self.chord();
        let far = [0, 1].map(|axis| {
            let [low, high] = self.hull[axis];
            if base[axis] == low { high } else { low }
        });
        let end = |t: f64, p: [f64; 2]| Joint {
            t,
            at: p.map(|x| [x, x]),
        };
        [end(0.0, base), end(1.0, far)]
    }

    /// Where it starts and ends.
    pub(super) fn ends(&self, loops: &Loops) -> [Joint; 2] {
        if self.joint == ALONE {
            return self.ends_alone();
        }
        let first = self.joint as usize;
        [loops.joints[first], loops.joints[first + 1]]
    }

    /// The range of its piece's parameter.
    #[inline]
    pub(super) fn t(&self, loops: &Loops) -> [f64; 2] {
        if self.joint == ALONE {
            return [0.0, 1.0];
        }
        let first = self.joint as usize;
        [loops.joints[first].t, loops.joints[first + 1].t]
    }

    /// Its piece.
    #[inline]
    pub(super) fn piece<'a>(&self, loops: &'a Loops) -> &'a Piece {
        &loops.pieces[self.piece as usize]
    }

    /// The margin of a monotone part: its hull is the box of its ends, so each coordinate is least in the enclosure of one end and greatest in
    /// that of the other.
    fn end_margin(&self, ends: [[[f64; 2]; 2]; 2]) -> f32 {
        let mut margin = 0.0f64;
        for axis in 0..2 {
            let [a, b] = ends.map(|e| e[axis]);
            let (low, high) = if a[0] <= b[0] { (a, b) } else { (b, a) };
            let [least, most] = self.hull[axis];
            margin = margin.max(low[1] - least).max(most - high[0]);
        }
        // Rounded up, with what the comparisons round; none where the ends are exact.
        let size = self
            .hull
            .iter()
            .flatten()
            .fold(0.0, |m: f64, x| m.max(x.abs()));
        if margin == 0.0 {
            return 0.0;
        }
        let wide = 2.0 * margin + 4.0 * f64::EPSILON * size;
        if wide > 0.0 && wide < f64::from(f32::MAX) {
            (wide as f32).next_up()
        } else {
            f32::INFINITY
        }
    }

    /// How wide, along each axis, an enclosure of a point of the part is at most.
    /// (Of a segment of f64 no point is enclosed but its ends.)
    pub(super) fn blur(&self, loops: &Loops, coarse: Option<&Horner<f64>>) -> [f64; 2] {
        let (piece, ends) = (self.piece(loops), self.ends(loops));
        [0, 1].map(|axis| {
            let width = |[low, high]: [f64; 2]| high - low;
            let [a, b] = ends.map(|e| width(e.at[axis]));
            let within = coarse.map_or(0.0, |c| piece.blur(c, axis));
            // Rounded up.
            a.max(b).max(within) * (1.0 + f64::EPSILON)
        })
    }

    /// Whether both coordinates are strictly monotone or constant.
    #[inline]
    pub(super) fn is_monotone(&self) -> bool {
        self.trends[0] != Trend::Mixed && self.trends[1] != Trend::Mixed
    }

    /// The transitions of `[h(t) > q_h]` at points with `r(t) > q_r`, modulo 2, where `r` is
    /// coordinate `ray` and `h` the other; `On` where the point is on the part (in which case nothing
    /// else matters).
    ///
    /// Transitions over the parts of a closed curve are crossings of the ray at height `q_h + 0`;
    /// a joint on the ray needs no special case, since the state at a joint is the same for
    /// the two parts that share it.
    #[inline]
    pub(super) fn crossing_in(&self, loops: &Loops, q: [f64; 2], ray: usize) -> Crossing {
        match self.at_once(q, ray) {
            AtOnce::Told(crossing) => crossing,
            AtOnce::Once => self.crossing_once(loops, q, ray),
            AtOnce::Nothing => self.crossing(loops, q, ray),
        }
    }

    /// What the box and the band tell: the first questions of [`crossing`](Self::crossing), from fewer numbers.
    #[inline]
    fn at_once(&self, q: [f64; 2], ray: usize) -> AtOnce {
        let h = 1 - ray;
        let [low, high] = self.hull[h];
        if q[h] > high || q[h] < low || q[ray] > self.hull[ray][1] {
            return AtOnce::Told(Crossing::Even);
        }
        let margin = f64::from(self.margin);
        if !(q[h] > low + margin && q[h] < high - margin) {
            return AtOnce::Nothing;
        }
        // One end is above the height, the other below.
        if q[ray] < self.hull[ray][0] {
            return AtOnce::Told(Crossing::Odd);
        }
        match self.by_chord(q, ray) {
            Some(odd) => AtOnce::Told(Crossing::odd(odd)),
            None => AtOnce::Once,
        }
    }

    /// The crossing of a monotone part whose ends are on different sides of the height.
    #[inline(never)]
    fn crossing_once(&self, loops: &Loops, q: [f64; 2], ray: usize) -> Crossing {
        match self.solve(loops, q, ray) {
            Ok(odd) => Crossing::odd(odd),
            Err(near) => self.crossing_fine(loops, q, ray, near),
        }
    }

    /// Where the box and the band do not tell.
    #[inline(never)]
    fn crossing(&self, loops: &Loops, q: [f64; 2], ray: usize) -> Crossing {
        let h = 1 - ray;
        if q[h] > self.hull[h][1] || q[h] < self.hull[h][0] || q[ray] > self.hull[ray][1] {
            return Crossing::Even;
        }
        let ends = self.ends(loops);
        let state = |end: usize| {
            let [lo, hi] = ends[end].at[h];
            if q[h] < lo {
                Some(true)
            } else if q[h] > hi {
                Some(false)
            } else {
                None
            }
        };
        let states = [state(0), state(1)];
        let monotone = self.is_monotone();
        if let [Some(a), Some(b)] = states {
            if q[ray] < self.hull[ray][0] {
                // All of the part is beyond the point: only the states at its ends count.
                return Crossing::odd(a != b);
            }
            if monotone {
                if a == b {
                    // h never takes the value q_h.
                    return Crossing::Even;
                }
                if let Some(odd) = self.by_chord(q, ray) {
                    return Crossing::odd(odd);
                }
                return self.crossing_once(loops, q, ray);
            }
        }
        self.crossing_exact(loops, q, ray, None)
    }

    #[cold]
    fn crossing_fine(&self, loops: &Loops, q: [f64; 2], ray: usize, near: f64) -> Crossing {
        match self.solve_fine(loops, q, ray, near) {
            Ok(odd) => Crossing::odd(odd),
            Err(near) => self.crossing_exact(loops, q, ray, Some(near)),
        }
    }

    /// f64 alone: `None` where that does not settle it. Only for monotone parts.
    #[inline]
    pub(super) fn crossing_coarse(&self, loops: &Loops, q: [f64; 2], ray: usize) -> Option<bool> {
        self.by_chord(q, ray)
            .or_else(|| self.solve(loops, q, ray).ok())
    }

    /// The chord, up to the rounding of the ends' enclosures.
    #[inline]
    fn chord(&self) -> Chord {
        let ends = [0, 1].map(|axis| {
            let [low, high] = self.hull[axis];
            if self.trends[axis] == Trend::Down {
                [high, low]
            } else {
                [low, high]
            }
        });
        Chord {
            base: ends.map(|e| e[0]),
            step: ends.map(|e| e[1] - e[0]),
        }
    }

    /// Finds the range of levels over the part from the control points of just this part (blossoms), as a
    /// quotient of positive weights is within the range of its terms.
    fn set_band(&mut self, control: &Control, t: [f64; 2]) {
        let chord = self.chord();
        let exact = Ball::<f64>::exact;
        let mut band = [f64::INFINITY, f64::NEG_INFINITY];
        for p in control.sub_points(t) {
            let along =
                |i: usize, k: usize| (p[i] - p[2] * exact(chord.base[i])) * exact(chord.step[k]);
            let level = (along(0, 1) - along(1, 0)) / p[2];
            let (lo, hi) = (level.lower(), level.upper());
            if lo.is_nan() || hi.is_nan() || !p[2].is_above(0.0) {
                return;
            }
            band = [band[0].min(lo), band[1].max(hi)];
        }
        self.band = band;
    }

    /// Decides by the chord alone where the point is outside the band of levels that the part keeps to. At
    /// the same height, levels grow with u where dv > 0, and with v where du < 0.
    #[inline]
    fn by_chord(&self, q: [f64; 2], ray: usize) -> Option<bool> {
        let chord = self.chord();
        let (level, error) = chord.level(q);
        let above = if level - error > self.band[1] {
            true
        } else if level + error < self.band[0] {
            false
        } else {
            return None;
        };
        let grows = if ray == 0 {
            chord.step[1] > 0.0
        } else {
            chord.step[0] < 0.0
        };
        // Above the band with levels that grow along the ray: the part is behind.
        Some(above != grows)
    }

    /// On a monotone part whose end states differ, the crossing is where `h(t) = q_h`. Let `g_r`, `g_h` be
    /// the coordinates minus the point's, turned so that both increase. At any t with `g_r > 0 > g_h` the
    /// crossing comes later, so `g_r > 0` there; with `g_r < 0 < g_h` it came earlier, and `g_r < 0` there.
    /// Such t lie between the roots of `g_r` and `g_h`, and so does the root of any positive combination
    /// of the two: that root is what is searched, by false position (Illinois).
    ///
    /// Gives whether the crossing is at `r > q_r`, or the last parameter where f64 could not tell.
    fn solve(&self, loops: &Loops, q: [f64; 2], ray: usize) -> Result<bool, f64> {
        const STEPS: usize = 24;
        let (curve, ends) = (self.piece(loops).coarse(), self.t(loops));
        let h = 1 - ray;
        let (sr, sh) = (sign_of(self.trends[ray]), sign_of(self.trends[h]));
        // The ends are those of the chord, nearly.
        let Chord { base, step } = self.chord();
        let (er, eh) = (curve.error[ray], curve.error[h]);
        // Scales that make both coordinates count.
        let scale = |axis: usize| 1.0 / step[axis].abs();
        let (kr, kh) = (scale(ray), scale(h));
        let f_at = |end: f64| {
            let off = |axis: usize| base[axis] + end * step[axis] - q[axis];
            sr * off(ray) * kr + sh * off(h) * kh
        };
        // The evaluated point belongs to a parameter within 3 units of t: keep clear of the ends.
        let (mut lo, mut hi) = (
            ends[0] + 4.0 * f64::EPSILON * ends[1],
            ends[1] - 4.0 * f64::EPSILON * ends[1],
        );
        let (mut f_lo, mut f_hi) = (f_at(0.0), f_at(1.0));
        let mut t = 0.5 * (lo + hi);
        if lo >= hi || sr == 0.0 || sh == 0.0 {
            return Err(t);
        }
        let mut last = 0;
        for _ in 0..STEPS {
            let s = lo + (hi - lo) * (f_lo / (f_lo - f_hi));
            t = if s > lo && s < hi {
                s
            } else if s <= lo {
                lo
            } else if s >= hi {
                hi
            } else {
                0.5 * (lo + hi)
            };
            let p = curve.eval(t);
            let (gr, gh) = (sr * (p[ray] - q[ray]), sh * (p[h] - q[h]));
            if gr > er && gh < -eh {
                return Ok(sr > 0.0);
            }
            if gr < -er && gh > eh {
                return Ok(sr < 0.0);
            }
            let f = gr * kr + gh * kh;
            if (gr.abs() <= er && gh.abs() <= eh) || f.is_nan() || f == 0.0 {
                return Err(t);
            }
            if f < 0.0 {
                if t <= lo && last == -1 {
                    return Err(t);
                }
                lo = t;
                f_lo = f;
                if last == -1 {
                    f_hi *= 0.5;
                }
                last = -1;
            } else {
                if t >= hi && last == 1 {
                    return Err(t);
                }
                hi = t;
                f_hi = f;
                if last == 1 {
                    f_lo *= 0.5;
                }
                last = 1;
            }
            if lo >= hi {
                return Err(t);
            }
        }
        Err(t)
    }

    /// The same in double-double from a parameter near: Newton steps with a slope from f64.
    fn solve_fine(&self, loops: &Loops, q: [f64; 2], ray: usize, near: f64) -> Result<bool, Dd> {
        const STEPS: usize = 4;
        let piece = self.piece(loops);
        let (curve, ends) = (piece.fine(), self.ends(loops));
        let range = ends.map(|e| e.t);
        let h = 1 - ray;
        let (sr, sh) = (sign_of(self.trends[ray]), sign_of(self.trends[h]));
        let mut t = Dd::from(near);
        if sr == 0.0 || sh == 0.0 {
            return Err(t);
        }
        let width = range[1] - range[0];
        let scale = |axis: usize| {
            let [a, b] = ends.map(|e| e.at[axis][0]);
            1.0 / (b - a).abs()
        };
        let (kr, kh) = (scale(ray), scale(h));
        // Slope of the combination by a difference across a millionth of the part.
        let step = width * 1e-6;
        let (a, b) = ((near - step).max(range[0]), (near + step).min(range[1]));
        let (pa, pb) = (piece.coarse().eval(a), piece.coarse().eval(b));
        let slope = (sr * (pb[ray] - pa[ray]) * kr + sh * (pb[h] - pa[h]) * kh) / (b - a);
        let usable = slope.is_finite() && slope > 0.0;
        // Clear of the ends by more than the parameter's own error, about 2^-101 relative.
        let margin = Dd::from(range[1] * f64::EPSILON * f64::EPSILON * 16.0);
        let (lo, hi) = (Dd::from(range[0]) + margin, Dd::from(range[1]) - margin);
        for _ in 0..STEPS {
            if t <= lo || t >= hi {
                t = if t <= lo { lo } else { hi };
                if lo >= hi {
                    return Err(t);
                }
            }
            let p = curve.eval(t);
            let gr = (p[ray] - Dd::from(q[ray])) * Dd::from(sr);
            let gh = (p[h] - Dd::from(q[h])) * Dd::from(sh);
            // The subtraction's own rounding is relative to the difference: 8 u² << 1.
            let er = Dd::from(curve.error[ray] * (1.0 + 4.0 * f64::EPSILON));
            let eh = Dd::from(curve.error[h] * (1.0 + 4.0 * f64::EPSILON));
            if gr > er && gh < -eh {
                return Ok(sr > 0.0);
            }
            if gr < -er && gh > eh {
                return Ok(sr < 0.0);
            }
            let f = gr * Dd::from(kr) + gh * Dd::from(kh);
            if (gr.abs() <= er && gh.abs() <= eh) || !usable || f.hi.is_nan() {
                return Err(t);
            }
            t = t - f * Dd::from(1.0 / slope);
        }
        Err(t)
    }

    /// The same question in integers, for every kind of part.
    #[cold]
    fn crossing_exact(&self, loops: &Loops, q: [f64; 2], ray: usize, near: Option<Dd>) -> Crossing {
        let piece = self.piece(loops);
        let Some(exact) = piece.exact() else {
            return super::circle::crossing(piece, q, ray);
        };
        self.settle(exact, self.t(loops), q, ray, near)
            .unwrap_or(Crossing::Unknown)
    }

    /// `None` only for numbers that are not finite.
    fn settle(
        &self,
        exact: &Exact,
        t: [f64; 2],
        q: [f64; 2],
        ray: usize,
        near: Option<Dd>,
    ) -> Option<Crossing> {
        let h = 1 - ray;
        let (gr, gh) = (exact.offset(ray, q[ray])?, exact.offset(h, q[h])?);
        let (lo, hi) = (Parameter::from_f64(t[0])?, Parameter::from_f64(t[1])?);
        if self.is_monotone() {
            Some(monotone_crossing(&gr, &gh, lo, hi, near))
        } else {
            Some(general_crossing(
                &gr.restricted(&lo, &hi),
                &gh.restricted(&lo, &hi),
            ))
        }
    }
}

fn sign_of(trend: Trend) -> f64 {
    match trend {
        Trend::Up => 1.0,
        Trend::Down => -1.0,
        Trend::Flat | Trend::Mixed => 0.0,
    }
}

/// Both coordinates strictly monotone or constant on `[lo, hi]`; signs of `gr` and `gh` are those of
/// `r - q_r` and `h - q_h`.
pub(super) fn monotone_crossing(
    gr: &Polynomial,
    gh: &Polynomial,
    mut lo: Parameter,
    mut hi: Parameter,
    near: Option<Dd>,
) -> Crossing {
    let signs = |t: &Parameter| (gr.sign_at(t), gh.sign_at(t));
    let (mut r_lo, mut h_lo) = signs(&lo);
    let (mut r_hi, mut h_hi) = signs(&hi);
    if (r_lo, h_lo) == (0, 0) || (r_hi, h_hi) == (0, 0) {
        return Crossing::On;
    }
    if h_lo == 0 && h_hi == 0 {
        // h is constant and equal to q_h (were it strictly monotone, it could not be at both ends).
        return if r_lo * r_hi < 0 {
            Crossing::On
        } else {
            Crossing::Even
        };
    }
    if (h_lo > 0) == (h_hi > 0) {
        return Crossing::Even;
    }
    // The bracket from double-double first: it leaves little to bisect.
    let mut tries: Vec<Parameter> = near.map(around).unwrap_or_default();
    let mut checked_common = false;
    loop {
        // The crossing is in [lo, hi], its h signs differ (as > 0 against <= 0).
        if h_lo == 0 {
            return Crossing::odd(r_lo > 0);
        }
        if h_hi == 0 {
            return Crossing::odd(r_hi > 0);
        }
        // h is not zero at the ends: the crossing is strictly inside, where a strictly monotone r has left
        // its value at either end.
        if r_lo >= 0 && r_hi >= 0 {
            return if r_lo + r_hi > 0 {
                Crossing::Odd
            } else {
                Crossing::On
            };
        }
        if r_lo <= 0 && r_hi <= 0 {
            return Crossing::Even;
        }
        let mid = match tries.pop() {
            Some(t) if t > lo && t < hi => t,
            Some(_) => continue,
            None => {
                if !checked_common {
                    checked_common = true;
                    // A common root is On: it is the only root of each in [lo, hi], of odd multiplicity in
                    // both (they change sign), so their gcd changes sign there.
                    let (mut a, mut b) = (gr.clone(), gh.clone());
                    a.deflate_ends();
                    b.deflate_ends();
                    let g = a.gcd(&b);
                    if g.degree() > 0 && g.sign_at(&lo) * g.sign_at(&hi) < 0 {
                        return Crossing::On;
                    }
                }
                // The roots differ: bisection separates them.
                lo.mid(&hi)
            }
        };
        let (r, h) = signs(&mid);
        if (r, h) == (0, 0) {
            return Crossing::On;
        }
        if (h > 0) == (h_lo > 0) {
            (lo, r_lo, h_lo) = (mid, r, h);
        } else {
            (hi, r_hi, h_hi) = (mid, r, h);
        }
    }
}

/// Parameters close to a double-double on both sides.
fn around(t: Dd) -> Vec<Parameter> {
    let exact = |x: f64| crate::numeric::Dyadic::from_f64(x);
    let Some(center) = exact(t.hi).zip(exact(t.lo)).map(|(a, b)| &a + &b) else {
        return Vec::new();
    };
    let mut out = Vec::new();
    // Tried from the last: within 2^-100, then within 2^-50.
    for k in [50, 100] {
        let d = crate::numeric::Dyadic::new(dashu_int::IBig::ONE, -k);
        for t in [&center - &d, &center + &d] {
            if t.exponent() <= 0 {
                out.extend(Parameter::new(
                    t.mantissa().clone(),
                    (-t.exponent()) as usize,
                ));
            }
        }
    }
    out
}

/// Any part, on [0, 1]: the roots of `gh` of odd multiplicity, each with the sign of `gr` there.
pub(super) fn general_crossing(gr: &Polynomial, gh: &Polynomial) -> Crossing {
    if gr.is_zero() && gh.is_zero() {
        return Crossing::On;
    }
    // The common roots first: the point is on the part at any of them.
    let common = if gr.is_zero() {
        gh.clone()
    } else if gh.is_zero() {
        gr.clone()
    } else {
        let (zero, one) = (Parameter::zero(), Parameter::one());
        for t in [&zero, &one] {
            if gr.sign_at(t) == 0 && gh.sign_at(t) == 0 {
                return Crossing::On;
            }
        }
        let (mut a, mut b) = (gr.clone(), gh.clone());
        a.deflate_ends();
        b.deflate_ends();
        a.gcd(&b)
    };
    match Roots::isolate(&common) {
        Some(roots) if !roots.as_slice().is_empty() => return Crossing::On,
        _ => {}
    }
    if gr.is_zero() || gh.is_zero() {
        // h is constantly q_h: no transition; r is constantly q_r: none beyond.
        return Crossing::Even;
    }
    let Some(mut roots) = Roots::isolate(gh) else {
        return Crossing::Even;
    };
    let mut odd = false;
    for i in 0..roots.as_slice().len() {
        // Halvings between two looks at all of gr on what is left, which take much longer: as many as all before, where its
        // root is close.
        let mut halvings = 1;
        loop {
            let root = &roots.as_slice()[i];
            let at_zero = root.is_exact() && root.lo == Parameter::zero();
            let at_one = root.is_exact() && root.lo == Parameter::one();
            // At an end the state is "not above"; inside it is what comes next to the end.
            let counts = if at_zero || at_one {
                inner_sign(gh, at_one) > 0
            } else {
                root.multiplicity % 2 == 1
            };
            if !counts {
                break;
            }
            if root.is_exact() {
                odd ^= gr.sign_at(&root.lo) > 0;
                break;
            }
            // gr has no root in common with gh: on a narrow enough interval it has none at all.
            let part = gr.restricted(&root.lo, &root.hi);
            if part.sign_variations() == 0 {
                let sign = part
                    .coefficients()
                    .iter()
                    .map(crate::numeric::polynomial::signum)
                    .find(|s| *s != 0)
                    .unwrap_or(0);
                odd ^= sign > 0;
                break;
            }
            for _ in 0..halvings {
                roots.refine(i);
            }
            halvings *= 2;
        }
    }
    Crossing::odd(odd)
}

/// The sign of `f` just inside the end t = 0 (or t = 1), a root of it.
fn inner_sign(f: &Polynomial, at_one: bool) -> i32 {
    let signs: Vec<i32> = f
        .coefficients()
        .iter()
        .map(crate::numeric::polynomial::signum)
        .collect();
    let found = if at_one {
        signs.iter().rev().find(|s| **s != 0)
    } else {
        signs.iter().find(|s| **s != 0)
    };
    found.copied().unwrap_or(0)
}
