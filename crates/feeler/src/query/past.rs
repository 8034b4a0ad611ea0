//! When a ball that touches a BREP at the start, and leaves it there or goes along it, comes to the BREP again.
//!
//! # Definition
//! A ball of radius r goes a straight way c(t) at one speed. Let s be its separation at the start (from above: the upper end of an enclosure that is no wider than
//! a / 64 and the accuracy that is asked of the way, or else the answer is undecided), or the prediction where that is less, and
//! a > 0 a length, the *allowance*. A point x of the faces *counts* if the way, continued ahead for ever, brings the centre nearer to it than
//! r + s - a. The ball arrives at the least time at which a point that counts is no farther from its centre than r + s.
//!
//! So what the ball lies on and rolls along does not count, however long it is, nor does what it leaves: the way never brings these nearer than they
//! are at the start. A wall counts from where the ball is as deep in it as it was in anything at the start. A curved face, a ramp, a fillet
//! count where the ball would come into them by more than the allowance; which points of one face those are is found by cutting it up.
//!
//! # Guarantee
//! Until `lo` no point that counts is within r + s, and no point of the faces at all nearer than r + s - a (where the start is not wider than a): **the ball is nowhere deeper
//! than it was at the start, by more than the allowance**. At `hi` a point that the way brings nearer than r + s - a / 2 is within r + s.
//! Between r + s - a and r + s - a / 2 a point may count or not. "Never" is proven: the first two hold until the end.
//!
//! *Argument.* The search holds boxes of patches, each with a time before which no point of it that counts is within r + s, that of the least
//! first. In the beginning these are all patches, from the start. With b(x) the distance of a point from the way's line and a(x) how far ahead
//! of the start's centre it is along the way, a box is
//! - put aside if it does not meet the face's region;
//! - put aside if b >= r + s - a on it: none of its points counts;
//! - put aside if a <= 0 on it: the distance |x - c|^2 = |x - c(0)|^2 - 2 a l + l^2 then grows with the length l of the way gone, so that it is never
//!   less than at the start, where no point is nearer than r + s up to the start's own enclosure: none of its points counts;
//! - moved on in time: a point is within r + s no sooner than where l = a - sqrt((r + s)^2 - b^2). And a point at the distance d or more, d > r + s, from the
//!   centre at the box's time is ahead of it by sqrt(d^2 - b^2) or more, or behind it for good: it is within r + s no sooner than when the ball has gone
//!   on by sqrt(d^2 - b^2) - sqrt((r + s)^2 - b^2), which grows with b (conservative advancement, of each box on its own, by more than d - (r + s): so it does not slow down
//!   where the ball comes near at a small angle);
//! - put aside if that is past the end, or past a time at which the ball is proven to have arrived;
//! - or else cut in two.
//!
//! Distances and the ranges of a and b come from Bernstein coefficients (module `node`). The time of the first box is the answer's `lo`. For the points
//! that do not count the distance is at least r + s - a at all times, by definition. Since that is positive, the centre stays on its
//! side of the faces, so that distances tell the separation (where r + s - a is no less than half of a crack's width wherever the way leads through one). (Where the centre may be in material at the start nothing is said: see below.) After
//! all faces are behind the centre none comes near again: the way need not be looked at farther.
//!
//! All of this is asked of a *nominal* way: from the rounded centre at the start, with the rounded velocity. The true centre is within a length `place` of the nominal one at all times:
//! the two are apart at the ends of the span by no more than that, and by what is between where the way is straight; a way that bends within a bound of its centre has that bound. So it is
//! within r + s of a point no sooner than the nominal one is within r + s + `place`, and has been once that was within r + s - `place`: `lo` and `hi` are apart by what the ball needs
//! to come nearer by 2 `place`, past a point that only just counts some 2 sqrt((r + s) / a) `place` long. And it is nearer than r + s - a to no point with b >= r + s - a + `place`.
//! (What is behind the start is left: it may come nearer than it was there by 2 `place` at the most, for which, and for roundings, an eighth of a is put by.)
//!
//! Roundings: the line's frame, its length and centres are off by no more than `rounding`, which is taken off each distance.
//!
//! # Cost
//! Boxes of a face along the way are cut to some sqrt(a (r + s)) where the ball goes along it. Where a face is met within its region the bounds converge
//! with the square of the boxes' size, at trims that cross the patches with the size itself.

use super::Workspace;
use super::advance::{DOWN, UP, Way};
use super::answer::{
    Accuracy, ContactAnswer, Contacts, Options, Probe, Separation, Sphere, Undecided,
};
use super::arrival::{ArrivalAnswer, widened};
use super::contact::{contact, separation};
use super::node::Node;
use super::objective::Objective;
use super::outcome::Locus;
use super::place::{Centre, Place, make_contact, rough_jet};
use super::upper::upper_end;
use crate::numeric::{Ball, Dd, Enclosure};
use crate::prepare::{Net, Patch, PreparedBrep, Products, Quotient};
use crate::trim::{BoxSide, Side};
use nalgebra::{Point2, Point3, Vector3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// How exactly `full` knows the way to the arrival, in sizes: see the module on costs.
const FULL: f64 = 1.0 / (1u64 << 20) as f64;
/// Of the roundings of a frame and of places along the way, in sums of the sizes of all numbers that are in them: some 30 operations.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// The largest part of the allowance that roundings may take.
const MOST_ROUNDING: f64 = 1.0 / 8.0;
/// Boxes are not cut below this width in local parameters.
const LEAST_WIDTH: f64 = 1.0 / (1u64 << 50) as f64;
/// How exactly the separation at the start is asked for, in allowances.
const START: f64 = 1.0 / 64.0;
/// A box that can be moved on by more than this part of its size is not cut yet.
const WORTH: f64 = 0.25;
/// By how many times a centre's bound a signed distance may be off: see the module `advance`.
const CRACKS: f64 = 2.0;

/// When a ball that may touch a BREP at the start, and leaves it there or goes along it, comes to it again.
///
/// Let s be the separation at the start, or the prediction where that is less. The ball arrives where its separation from a point of the faces is s or less, if the
/// way, continued ahead for ever, brings it to less than s - allowance there. So what it rolls along is no arrival, a wall is: from where the ball is as
/// deep in it as it was in anything at the start. Until `lo`, and until the end where it never arrives, the ball is proven to be nowhere deeper
/// than s - allowance; a positive radius with s must be left of it.
///
/// The way must be straight and of one speed ([`Way::steady`]); for others, for a ball whose centre may be in material at the start, and where
/// roundings are as large as the allowance, the answer is undecided from the start on. The accuracy is a length: the enclosure is no wider than a time in which the
/// ball cannot move farther; `full` stands for 2^-20 of the model's size. There is one contact in the answer, the point that is come to; the ball may be deeper in what it goes along.
pub fn arrival_past(
    brep: &PreparedBrep,
    radius: f64,
    way: &dyn Way,
    span: [f64; 2],
    allowance: f64,
    options: &Options,
    workspace: &mut Workspace,
) -> ArrivalAnswer {
    let unknown = |why| {
        let time = Enclosure {
            lo: span[0],
            hi: f64::INFINITY,
        };
        ArrivalAnswer::at(time, None, Some(why))
    };
    let line = match Line::new(brep, radius, way, span, allowance, options, workspace) {
        Ok(Some(line)) => line,
        Ok(None) => return ArrivalAnswer::default(),
        Err(why) => return unknown(why),
    };
    let mut search = Search {
        brep,
        way,
        line,
        hi: f64::INFINITY,
        foot: None,
        order: 0,
        heap: BinaryHeap::new(),
    };
    search.run(radius, options, workspace)
}

/// The way, and what of it is known.
struct Line {
    start: Point3<f64>,
    /// Two unit vectors across it, and one along.
    frame: [Vector3<f64>; 3],
    from: f64,
    until: f64,
    /// r + s, from above.
    reach: f64,
    allowance: f64,
    /// How far the true centre may be from the nominal one.
    place: f64,
    /// What is rounded along the nominal way.
    rounding: f64,
    velocity: Vector3<f64>,
    speed: f64,
    /// How exactly the way is asked for.
    exactly: f64,
    /// Why the start is known less exactly than it was asked for, where it is what is sought: all that is proven to be free is so, but what is come to may be farther off than the
    /// ball's true place at the start had it.
    wide: Option<Undecided>,
}

impl Line {
    /// `None`: the ball never comes to anything.
    fn new(
        brep: &PreparedBrep,
        radius: f64,
        way: &dyn Way,
        [from, until]: [f64; 2],
        allowance: f64,
        options: &Options,
        workspace: &mut Workspace,
    ) -> Result<Option<Self>, Undecided> {
        let (start, off) = way.center(from);
        let (Some((velocity, velocity_bound)), Ok(ball)) =
            (way.steady(), Sphere::new(start, radius))
        else {
            return Err(Undecided::Degenerate);
        };
        if velocity == Vector3::zeros() && velocity_bound == 0.0 || from > until {
            return Ok(None);
        }
        let scale = velocity.amax();
        let along = (velocity / scale).normalize();
        let speed = scale * (velocity / scale).norm();
        // Of speeds below the least normal number no digit is known.
        let slowest = speed * (1.0 - ROUNDING) - velocity_bound * UP - f64::MIN_POSITIVE;
        let known = slowest > 0.0 && speed.is_finite() && off.is_finite() && from <= until;
        if !known || options.prediction.is_nan() {
            return Err(Undecided::Degenerate);
        }
        if !(allowance > 0.0) {
            return Err(Undecided::Precision);
        }
        let Some(faces) = brep.bounding_box() else {
            return Err(Undecided::Degenerate);
        };
        let exactly = match options.accuracy {
            Accuracy::Full => FULL * brep.size(),
            Accuracy::Length(a) => a,
        };
        let asked = Options {
            contacts: Contacts::None,
            accuracy: Accuracy::Length(exactly.min(START * allowance)),
            ..*options
        };
        let found = contact(brep, &Probe::Sphere(ball), &asked, workspace);
        let bounds = found.separation.bounds;
        if bounds.lo == f64::INFINITY {
            return Ok(None);
        }
        // A centre in material has a separation of at most -r.
        if !(bounds.lo - CRACKS * off >= -radius && bounds.hi.is_finite()) {
            return Err(found.undecided.unwrap_or(Undecided::Degenerate));
        }
        let sought = options.prediction.min(bounds.hi + off);
        let reach = (radius + sought) * UP;
        // Up to where all faces are behind.
        let far: Vector3<f64> = Vector3::from_fn(|c, _| {
            let [low, high] = faces[c];
            (start[c] - low).abs().max((high - start[c]).abs())
        });
        let far = far.norm() * UP;
        let until = until.min(from + far / slowest * UP);
        let (end, end_off) = way.center(until);
        let sizes = [start, end].map(|p| p.coords.abs().sum());
        let sizes = sizes[0] + sizes[1] + far + reach.abs();
        let rounding = ROUNDING * sizes;
        let nominal = start + velocity * (until - from);
        let at_end = (end - nominal).norm() + end_off;
        // Asked by itself, for a maximum drops what is no number.
        if !at_end.is_finite() {
            return Err(Undecided::Degenerate);
        }
        let place = UP * off.max(at_end);
        let allowance = allowance.min(0.5 * reach);
        if !(rounding + 2.0 * place <= MOST_ROUNDING * allowance) {
            return Err(Undecided::Precision);
        }
        let least = along.iamin();
        let across = along.cross(&Vector3::ith(least, 1.0)).normalize();
        Ok(Some(Self {
            start,
            frame: [across, along.cross(&across), along],
            from,
            until,
            reach,
            allowance,
            place,
            rounding,
            velocity,
            speed,
            exactly,
            wide: found
                .undecided
                .filter(|_| bounds.lo - off < options.prediction),
        }))
    }

    /// The nominal centre at a time.
    fn at(&self, time: f64) -> Point3<f64> {
        self.start + self.velocity * (time - self.from)
    }

    /// No sooner than this after a time has the nominal centre gone so far.
    fn gone(&self, time: f64, length: f64) -> f64 {
        if !(length > 0.0) {
            return time;
        }
        let fastest = self.speed * (1.0 + ROUNDING) + f64::MIN_POSITIVE;
        let takes = (length / fastest * DOWN).min(f64::MAX);
        (time + takes).next_down().max(time)
    }

    /// A net as it is seen along the way: its places across it, from the way.
    fn across(&self, net: &Net<f64>) -> Net<f64> {
        let offset: [Ball<f64>; 3] =
            std::array::from_fn(|c| Ball::difference(net.origin[c], self.start[c]));
        let on = |e: &Vector3<f64>, x: &[Ball<f64>; 3]| {
            Ball::exact(e.x) * x[0] + Ball::exact(e.y) * x[1] + Ball::exact(e.z) * x[2]
        };
        let points = net.points.iter().map(|p| {
            let x: [Ball<f64>; 3] = std::array::from_fn(|c| p[c] + offset[c] * p[3]);
            [
                on(&self.frame[0], &x),
                on(&self.frame[1], &x),
                Ball::ZERO,
                p[3],
            ]
        });
        Net::new(net.degree, points.collect(), [0.0; 3])
    }

    /// How far points are ahead of the start, or behind it.
    fn height(&self, sign: f64) -> Objective {
        let along = self.frame[2] * sign;
        Objective::Height(along, along.dot(&self.start.coords))
    }
}

/// A box of a patch, cut off with all that is known of it.
struct Piece {
    face: usize,
    patch: usize,
    /// Whether it is known to lie in the region.
    inside: bool,
    /// For squared distances from any centre.
    products: Products<f64>,
    /// The squared distance from the way's line.
    beside: Node<f64>,
    ahead: Node<f64>,
    behind: Node<f64>,
}

enum Part {
    Face(usize),
    Piece(Box<Piece>),
}

/// What is left to look at, and until when it is proven to be free.
struct Task {
    free: f64,
    order: u64,
    part: Part,
}

impl PartialEq for Task {
    fn eq(&self, o: &Self) -> bool {
        self.cmp(o) == Ordering::Equal
    }
}
impl Eq for Task {}
impl PartialOrd for Task {
    fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
        Some(self.cmp(o))
    }
}
impl Ord for Task {
    /// The heap gives the largest first: the earliest, of those the newest, which is the smallest.
    fn cmp(&self, o: &Self) -> Ordering {
        let by_time = o.free.total_cmp(&self.free);
        by_time.then(self.order.cmp(&o.order))
    }
}

/// A point that is come to.
struct Foot {
    face: usize,
    patch: usize,
    local: [Ball<Dd>; 2],
    uv: Point2<f64>,
}

struct Search<'a> {
    brep: &'a PreparedBrep,
    way: &'a dyn Way,
    line: Line,
    /// A time at which the ball is proven to have arrived.
    hi: f64,
    foot: Option<Foot>,
    order: u64,
    heap: BinaryHeap<Task>,
}

/// A lower bound of a distance from that of its square.
fn root(squared: Dd) -> f64 {
    squared.floor_f64().max(0.0).sqrt().next_down().max(0.0)
}

impl Search<'_> {
    fn push(&mut self, free: f64, part: Part) {
        if free < self.hi && free <= self.line.until {
            self.order += 1;
            let order = self.order;
            self.heap.push(Task { free, order, part });
        }
    }

    fn run(&mut self, radius: f64, options: &Options, workspace: &mut Workspace) -> ArrivalAnswer {
        let from = self.line.from;
        for face in 0..self.brep.brep().faces().len() {
            let apart = self.brep.face_box(face).map_or(0.0, |b| self.to_box(b));
            let line = &self.line;
            let free = line.gone(from, apart - line.reach - line.place - line.rounding);
            self.push(free, Part::Face(face));
        }
        let mut nodes = workspace.work.nodes;
        let (mut lo, mut undecided) = (f64::INFINITY, None);
        while let Some(task) = self.heap.pop() {
            let near = self.way.least_time(task.free, self.line.exactly);
            // At the start itself only what is there is an arrival: just beyond it is not yet.
            let close = self.hi.is_finite() && self.hi - task.free <= near && task.free > from;
            if self.hi <= task.free || close {
                lo = task.free;
                break;
            }
            if nodes >= options.node_budget {
                (lo, undecided) = (task.free, Some(Undecided::Budget));
                break;
            }
            nodes += 1;
            match task.part {
                Part::Face(face) => self.open(face, task.free),
                Part::Piece(piece) => {
                    if !self.visit(*piece, task.free) {
                        (lo, undecided) = (task.free, Some(Undecided::Precision));
                        break;
                    }
                }
            }
        }
        workspace.work.nodes = nodes;
        if lo == f64::INFINITY && self.hi == f64::INFINITY {
            return ArrivalAnswer::default();
        }
        let hi = self.hi;
        let time = Enclosure { lo: lo.min(hi), hi };
        let undecided = undecided.or(self.line.wide);
        ArrivalAnswer::at(time, self.contact(radius, options), undecided)
    }

    /// How far the start's centre is from a box.
    fn to_box(&self, b: &[[f64; 2]; 3]) -> f64 {
        let apart = Vector3::from_fn(|c, _| {
            let x = self.line.start[c];
            (b[c][0] - x).max(x - b[c][1]).max(0.0)
        });
        apart.norm() * (1.0 - ROUNDING)
    }

    fn open(&mut self, face: usize, free: f64) {
        let brep = self.brep;
        let geometry = brep.double(face);
        for patch in 0..geometry.patches.len() {
            let Patch { net, .. } = &geometry.patches[patch];
            let flat = self.line.across(net);
            let beside = Quotient::squared_distance(&Point3::origin(), &flat, &flat.products());
            let height = |sign: f64| {
                let height = self.line.height(sign);
                Node::root(
                    height.quotient(net, || geometry.patch_products(patch), Quotient::BLANK),
                    false,
                )
            };
            let piece = Piece {
                face,
                patch,
                inside: false,
                products: geometry.patch_products(patch).clone(),
                beside: Node::root(beside, true),
                ahead: height(1.0),
                behind: height(-1.0),
            };
            self.push(free, Part::Piece(Box::new(piece)));
        }
    }

    /// Looks at a box that is free until a time; false where it is too small to be cut.
    fn visit(&mut self, mut piece: Piece, free: f64) -> bool {
        let (u, v) = (piece.beside.u, piece.beside.v);
        let geometry = self.brep.double(piece.face);
        let Patch { net, maps, .. } = &geometry.patches[piece.patch];
        if !piece.inside {
            let region = self.brep.region(piece.face);
            let u = maps[0].to_native_range(u[0], u[1]);
            let v = maps[1].to_native_range(v[0], v[1]);
            match region.classify_box(u, v) {
                BoxSide::Outside => return true,
                BoxSide::Inside => piece.inside = true,
                BoxSide::Mixed => {}
            }
        }
        let (line, rounding) = (&self.line, self.line.rounding);
        let beside = root(piece.beside.lo) - rounding;
        let behind = piece.behind.lo.floor_f64() - rounding;
        if beside - line.place >= line.reach - line.allowance || behind >= 0.0 {
            return true;
        }
        let beside = beside.max(0.0);
        // Of the nominal way.
        let reach = (line.reach + line.place + rounding) * UP;
        // From above: the root of a difference that is rounded up.
        let before = (reach * reach * UP - beside * beside).max(0.0);
        let ahead = piece.ahead.lo.floor_f64() - before.sqrt() * UP - rounding;
        let mut later = free.max(line.gone(line.from, ahead));
        let distance = Quotient::squared_distance(&line.at(later), net, &piece.products);
        let distance = root(Node::over(distance, u, v, true).lo) - rounding;
        // With the distance d, what is ahead is reached after sqrt(d^2 - b^2) - sqrt(R^2 - b^2), which grows with b; b is below R, or the box was put aside.
        if distance > reach {
            let leg = |hypotenuse: f64| ((hypotenuse - beside) * (hypotenuse + beside)).sqrt();
            let gap = (distance - reach) * (distance + reach) / (leg(distance) + leg(reach));
            later = line.gone(later, gap * (1.0 - ROUNDING));
        }
        if later >= self.hi || later > line.until {
            return true;
        }
        self.try_points(&piece);
        let [along_u, along_v] = geometry.patch_speeds(piece.patch);
        let (long, wide) = (along_u * (u[1] - u[0]), along_v * (v[1] - v[0]));
        let gained = (later - free) * self.line.speed;
        if gained > WORTH * long.max(wide) {
            self.push(later, Part::Piece(Box::new(piece)));
            return true;
        }
        let widths = [u[1] - u[0], v[1] - v[0]];
        let along_u = match (long.is_finite() && wide.is_finite(), widths) {
            (_, [u, v]) if u <= LEAST_WIDTH && v <= LEAST_WIDTH => return false,
            (_, [u, _]) if u <= LEAST_WIDTH => false,
            (_, [_, v]) if v <= LEAST_WIDTH => true,
            (true, _) => long >= wide,
            (false, [u, v]) => u >= v,
        };
        let halves = [[0.0, 0.5], [0.5, 1.0]];
        let whole = [0.0, 1.0];
        let own = |node: &Node<f64>, squared| node.clone().halves(along_u, squared);
        let nodes = own(&piece.beside, true).into_iter();
        let heights = own(&piece.ahead, false)
            .into_iter()
            .zip(own(&piece.behind, false));
        for ((beside, (ahead, behind)), half) in nodes.zip(heights).zip(halves) {
            let [u, v] = if along_u {
                [half, whole]
            } else {
                [whole, half]
            };
            let Some(products) = piece.products.restricted(u, v) else {
                return false;
            };
            let part = Piece {
                products,
                beside,
                ahead,
                behind,
                ..piece
            };
            self.push(later, Part::Piece(Box::new(part)));
        }
        true
    }

    /// Whether the ball comes to the middle of a box, or to its corners, sooner than is known.
    fn try_points(&mut self, piece: &Piece) {
        let (u, v) = (piece.beside.u, piece.beside.v);
        let middle = [0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1])];
        let corners = [[u[0], v[0]], [u[0], v[1]], [u[1], v[0]], [u[1], v[1]]];
        for local in std::iter::once(middle).chain(corners) {
            self.try_point(piece.face, piece.patch, local);
        }
    }

    fn try_point(&mut self, face: usize, patch: usize, local: [f64; 2]) {
        let Patch { net, maps, .. } = &self.brep.double(face).patches[patch];
        let line = &self.line;
        let [point, ..] = rough_jet(net, local);
        let off = point + Vector3::from(net.origin) - line.start.coords;
        let ahead = off.dot(&line.frame[2]);
        let beside = (off - line.frame[2] * ahead).norm();
        // A little nearer than need be: it is to be proven.
        let reach = line.reach - line.place - 2.0 * line.rounding;
        let counts = line.reach - 0.5 * line.allowance - line.place - line.rounding;
        if !(ahead > 0.0 && beside < counts) {
            return;
        }
        let gone = (ahead - (reach * reach - beside * beside).max(0.0).sqrt()).max(0.0);
        let time = line.from + gone / line.speed;
        if !(time < self.hi && time <= line.until) {
            return;
        }
        let uv = [0, 1].map(|k| maps[k].to_native(Dd::from(local[k])));
        let uv = Point2::new(uv[0], uv[1]);
        let side = self.brep.region(face).side(uv).side;
        if !matches!(side, Some(Side::Inside | Side::Boundary)) {
            return;
        }
        let fine = &self.brep.double_double(face).patches[patch];
        let local = [0, 1].map(|k| fine.maps[k].to_local(Ball::<Dd>::exact(uv[k])));
        let squared = Objective::SquaredDistance(line.at(time)).value(&fine.net, local);
        let distance = upper_end(squared).ceil_f64().max(0.0).sqrt().next_up();
        if distance + line.rounding + line.place * UP <= line.reach {
            self.hi = time;
            self.foot = Some(Foot {
                face,
                patch,
                local,
                uv,
            });
        }
    }

    /// The point that is come to, as a contact of the ball there.
    fn contact(&self, radius: f64, options: &Options) -> Option<ContactAnswer> {
        let foot = self.foot.as_ref()?;
        let (center, off) = self.way.center(self.hi);
        let ball = Sphere::new(center, radius).ok()?;
        let objective = Objective::SquaredDistance(center);
        let fine = &self.brep.double_double(foot.face).patches[foot.patch];
        let f = objective.value(&fine.net, foot.local);
        let lower = f.mid - Dd::from(f.rad * UP);
        let near: Separation = separation([lower, upper_end(f)], &objective, radius, Some(false));
        let place = Place {
            face: foot.face,
            trim: None,
            spot: Locus::Patch {
                patch: foot.patch,
                local: foot.local,
                point: None,
            },
            uv: foot.uv,
        };
        let contact = make_contact(
            self.brep,
            &Probe::Sphere(ball),
            &place,
            near,
            Centre {
                in_material: false,
                may_touch: !(lower > Dd::ZERO),
            },
            Accuracy::Full,
            None,
        );
        let wanted = options.contacts != Contacts::None;
        let found = ContactAnswer {
            separation: near,
            continuum: false,
            contacts: wanted.then_some(contact).into_iter().collect(),
            undecided: None,
        };
        Some(widened(found, off))
    }
}
