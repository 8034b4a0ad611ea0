//! All contacts within a prediction, by the second method.
//!
//! **Definition.** Points of the faces nearer to each other than `join` (2^-36 of the size) are joined. A contact is a
//! strict local minimiser of f (the distance, or n.x - h) over every face that comes within `join` of it. A face
//! is taken with that much around its domain: trims that leave it by rounding count as on its side.
//!
//! **Method.** On each face the places where f may have a local minimum over it: critical points inside cells, along arcs
//! and along sides of the domain, joints of arcs, corners (`search`), without a best value to discard by: boxes go
//! whose f is above the limit or whose gradient excludes 0. Each place then *stands* or *falls*:
//! - a critical point in a cell stands where the second derivative is positive definite, as a minimiser over any set
//!   that it belongs to; it falls where that has a negative eigenvalue;
//! - one along an arc stands where it is a minimum along it and the derivative of f into the region is positive: a point
//!   of the region next to it is c(t) + r n with r >= 0, and f there >= f(c(t)) >= f at the place. It falls if either
//!   is negative. Which way the region is shows the parity of a point on each side, no other arc being near;
//! - a joint stands where f rises along both arcs and the region lies in the convex sector between them: f then
//!   rises along every direction of the sector. It falls if f falls along one, or if the sector is the other one, which
//!   holds the direction of steepest descent;
//! - sides and corners of the domain likewise, with the cells' own derivatives; an arc that is one point in space (a
//!   pole) falls where a derivative into the region says so, and whether a minimum is there tells a band about it (`pole`).
//!
//! A place that stands is a contact if on each face that comes within `join` of it a place within `join` stands, and
//! none falls there. It is none if from one that falls there a way leads to values lower by more than `join`. (At a seam
//! one end of a face may stand, and the other fall on, or by rounding only: which of the two, is left open.)
//!
//! **Guarantee.** [`SecondContacts::All`] is all of them. Wherever something is not proven (degenerate minima,
//! continua, borders that are neither on a side nor clear of it, a fall beside a place that stands or is open
//! which no straight way shows to be deep, faces apart by more than `join` and less than what counts as the same
//! place) the answer is [`SecondContacts::Open`]: next to a pole often, where boxes do not settle.

use super::number::{Ball, Interval64, Number};
use super::region::Place;
use super::search::{
    Candidate, Goal, Item, Kind, Newton, Scene, Step, excludes_zero, no_minimum, split, weights,
};
use super::space::Second;
use super::standing::{Standing, all_rise, both};
use feeler::numeric::Dyadic;

/// What is joined, as a part of the size.
const JOIN: f64 = 1.0 / (1u64 << 36) as f64;
/// Contacts nearer than this part of the size are not told apart.
const SAME: f64 = 1.0 / (1u64 << 24) as f64;
/// Trims that leave the domain by no more than this part of it run on its side.
pub(super) const RAGGED: f64 = 1.0 / (1u64 << 44) as f64;
/// Boxes of a face, in f64 and in balls.
const BUDGET: [usize; 2] = [20_000, 3000];

/// What lies on both sides of a number that may be a knot: far below what tells two of them apart.
pub(super) const KNOT: f64 = 1e-60;

/// One contact.
#[derive(Clone, Debug)]
pub struct SecondContact {
    /// Encloses the distance, or n.x - h.
    pub f: [Dyadic; 2],
    /// Holds it, in space.
    pub at: [[f64; 2]; 3],
}

/// What the second method knows of all contacts.
#[derive(Clone, Debug)]
pub enum SecondContacts {
    /// They are these, each apart from the others.
    All(Vec<SecondContact>),
    /// Not known, and why.
    Open(String),
}

/// A place on a face where f may have a local minimum over it.
#[derive(Clone, Debug)]
pub(super) struct Spot {
    pub(super) face: usize,
    pub(super) at: [Ball; 3],
    pub(super) f: Ball,
    pub(super) standing: Standing,
    /// A way leads from here to values lower by more than `join`.
    pub(super) deep: bool,
    /// An arc or a side that is one point in space.
    pub(super) pole: bool,
}

impl Spot {
    pub(super) fn box64(&self) -> [[f64; 2]; 3] {
        self.at.each_ref().map(|x| [x.lo(), x.hi()])
    }
}

/// No points of the boxes are nearer.
pub(super) fn least_apart(a: &[[f64; 2]; 3], b: &[[f64; 2]; 3]) -> f64 {
    let gap = |k: usize| (a[k][0] - b[k][1]).max(b[k][0] - a[k][1]).max(0.0);
    gap(0).hypot(gap(1)).hypot(gap(2))
}

/// No points of the boxes are farther.
pub(super) fn most_apart(a: &[[f64; 2]; 3], b: &[[f64; 2]; 3]) -> f64 {
    let gap = |k: usize| (a[k][1] - b[k][0]).max(b[k][1] - a[k][0]);
    gap(0).hypot(gap(1)).hypot(gap(2))
}

impl Scene<'_> {
    /// Whether uv lies in the domain, or beyond it by no more than rounding.
    fn nearly_in_domain<N: Number>(&self, face: usize, uv: &[N; 2]) -> bool {
        let domain = self.faces[face].shape.domain;
        let lengths = self.lengths(face);
        (0..2).all(|c| {
            let slack = RAGGED * lengths[c];
            uv[c].lo() >= domain[c].start - slack && uv[c].hi() <= domain[c].end + slack
        })
    }

    /// Where a box of a seed lies; arcs on sides of the domain are inside.
    fn standing_place<N: Number>(&self, item: &Item<N>, uv: &[N; 2]) -> Place {
        let seed = &self.seeds[item.seed];
        match seed.kind {
            Kind::Arc(_) | Kind::Point { on_loop: true }
                if item.inside || self.nearly_in_domain(seed.face, uv) =>
            {
                Place::Inside
            }
            _ => self.place(seed, uv),
        }
    }

    /// Finds the critical points of f with f <= limit; what is left may hold some too.
    fn hunt<N: Number>(
        &self,
        goal: &Goal,
        mut stack: Vec<Item<N>>,
        limit: f64,
        mut budget: usize,
        found: &mut Vec<Candidate>,
    ) -> Vec<Item<N>> {
        let limit = N::exact(limit);
        let mut left = Vec::new();
        while let Some(item) = stack.pop() {
            if budget == 0 {
                left.push(item);
                left.append(&mut stack);
                break;
            }
            budget -= 1;
            match self.sift(goal, item, &limit, found) {
                Step::Gone => {}
                Step::Left(item) => left.push(item),
                Step::Parts(parts) => stack.extend(parts),
            }
        }
        left
    }

    fn sift<N: Number>(
        &self,
        goal: &Goal,
        mut item: Item<N>,
        limit: &N,
        found: &mut Vec<Candidate>,
    ) -> Step<N> {
        let seed = &self.seeds[item.seed];
        let dims = seed.dims();
        let Some(over) = self.local(goal, seed, &item.x, None) else {
            return split(seed, item, dims, &[1.0, 1.0]);
        };
        if limit.below(&over.f) {
            return Step::Gone;
        }
        if !item.inside {
            match self.standing_place(&item, &over.uv) {
                Place::Outside => return Step::Gone,
                // A line on a loop stays mixed: only what is proven inside is remembered.
                Place::Inside => item.inside = true,
                Place::Mixed => {}
            }
        }
        // An arc that may leave the domain may have its minimum where it does.
        let critical = item.inside || !matches!(seed.kind, Kind::Arc(_));
        if critical && excludes_zero(&over.g, dims) {
            return Step::Gone;
        }
        let middle = [item.x[0].middle(), item.x[1].middle()];
        let Some(at) = self.local(goal, seed, &middle, over.cell) else {
            return split(seed, item, dims, &[1.0, 1.0]);
        };
        let weight = weights(&item, &over, dims);
        if !over.smooth || !critical {
            return split(seed, item, dims, &weight);
        }
        let d: [N; 2] = std::array::from_fn(|c| item.x[c].minus(&middle[c]));
        if no_minimum(&over, &at, &d, dims) {
            return Step::Gone;
        }
        match self.newton(goal, seed, &item, &at, &over, dims) {
            Newton::Nothing => Step::Gone,
            Newton::Unknown => split(seed, item, dims, &weight),
            Newton::Shrunk(x) => {
                item.x = x;
                Step::Parts(vec![item])
            }
            Newton::Only(k) => {
                let ball = |x: &[N; 2]| [x[0].ball(), x[1].ball()];
                found.push(Candidate {
                    seed: item.seed,
                    cell: over.cell,
                    x: ball(&item.x),
                    k: ball(&k),
                    low: item.low.ball(),
                });
                Step::Gone
            }
        }
    }

    /// All places on a face with f up to the limit. An error where something is open.
    fn spots(&self, goal: &Goal, face: usize, limit: f64, join: f64) -> Result<Vec<Spot>, String> {
        let mut start: Vec<Item<Interval64>> = Vec::new();
        let mut spots: Vec<Spot> = Vec::new();
        let high = Interval64::exact(limit);
        for (i, seed) in self.seeds.iter().enumerate() {
            if seed.face != face || high.below(&goal.value(&seed.bounds).lower()) {
                continue;
            }
            let dims = seed.dims();
            let width = |b: &Interval64| b.hi() - b.lo();
            let pole = dims == 1 && seed.bounds.iter().all(|b| width(b) <= join / 4.0);
            if dims > 0 && !pole {
                start.push(Item {
                    seed: i,
                    x: [Interval64::of(&seed.x[0]), Interval64::of(&seed.x[1])],
                    low: high,
                    inside: seed.inside,
                });
                continue;
            }
            let Some(local) = self.local::<Ball>(goal, seed, &seed.x, None) else {
                return Err("no derivative".to_owned());
            };
            let shape = &self.faces[face].shape;
            let mut start = local.uv.clone();
            let standing = match &seed.kind {
                kind if pole => {
                    let (standing, from) = self.pole(goal, face, kind, &seed.x[0]);
                    start = from.unwrap_or(start);
                    standing
                }
                Kind::Point { on_loop: true } => {
                    let arcs = &self.faces[face].region.arcs;
                    let same = |a: &Ball, b: &Ball| a.center() == b.center();
                    let arc = (0..arcs.len())
                        .find(|a| (0..2).all(|c| same(&arcs[*a].start[c], &seed.x[c])));
                    match arc {
                        Some(arc) if self.nearly_in_domain(face, &seed.x) => {
                            self.joint(goal, face, arc)
                        }
                        Some(_) => match self.place(seed, &local.uv) {
                            Place::Outside => continue,
                            _ => Standing::Open("a joint next to a side of the domain"),
                        },
                        None => Standing::Open("a joint without an arc"),
                    }
                }
                _ => {
                    let edge = |c: usize| {
                        let x = &seed.x[c];
                        let near = x.widened(KNOT * x.magnitude().max(KNOT));
                        shape.met(c, &near).len() == 1
                            || shape.creases[c].iter().any(|k| near.meet(k).is_some())
                    };
                    if !edge(0) && !edge(1) {
                        continue;
                    }
                    match self.place(seed, &local.uv) {
                        Place::Outside => continue,
                        Place::Mixed => Standing::Open("a corner on a border"),
                        Place::Inside => self.rises_across(goal, face, &seed.x, &[0, 1]),
                    }
                }
            };
            let Some((jet, _)) = self.jets::<Ball>(seed, &seed.x, None) else {
                return Err("no point".to_owned());
            };
            spots.push(self.judged(
                goal,
                Spot {
                    face,
                    at: jet.p,
                    f: local.f,
                    standing,
                    deep: false,
                    pole,
                },
                &start,
                join,
            ));
        }
        let mut found = Vec::new();
        let left = self.hunt(goal, start, limit, BUDGET[0], &mut found);
        let left = left
            .into_iter()
            .map(|i| Item {
                seed: i.seed,
                x: self.seeds[i.seed].clipped([i.x[0].ball(), i.x[1].ball()]),
                low: i.low.ball(),
                inside: i.inside,
            })
            .collect();
        let left = self.hunt::<Ball>(goal, left, limit, BUDGET[1], &mut found);
        for item in left {
            let seed = &self.seeds[item.seed];
            let Some((jet, _)) = self.jets::<Ball>(seed, &item.x, None) else {
                return Err("no point".to_owned());
            };
            spots.push(Spot {
                face,
                f: goal.value(&jet.p),
                at: jet.p,
                standing: Standing::Open("a box that is not settled"),
                deep: false,
                pole: false,
            });
        }
        for candidate in &found {
            spots.extend(self.spot(goal, candidate, join)?);
        }
        spots.retain(|s| s.f.lo() <= limit);
        Ok(spots)
    }

    /// A critical point, to all digits.
    fn spot(&self, goal: &Goal, candidate: &Candidate, join: f64) -> Result<Option<Spot>, String> {
        let seed = &self.seeds[candidate.seed];
        let (dims, cell, face) = (seed.dims(), candidate.cell, seed.face);
        let mut k = candidate.k.clone();
        for _ in 0..40 {
            let radius = |k: &[Ball; 2]| (0..dims).fold(0.0f64, |m, c| m.max(k[c].radius()));
            let before = radius(&k);
            let Some(better) = self.refined(goal, seed, &k, cell, dims) else {
                break;
            };
            k = better;
            if !(radius(&k) < 0.9 * before) {
                break;
            }
        }
        if (0..dims).any(|c| k[c].below(&candidate.x[c]) || candidate.x[c].below(&k[c])) {
            return Ok(None);
        }
        let (Some(at), Some((jet, _))) = (
            self.local(goal, seed, &k, cell),
            self.jets::<Ball>(seed, &k, cell),
        ) else {
            return Err("no point".to_owned());
        };
        let item = Item {
            seed: candidate.seed,
            x: k.clone(),
            low: at.f.clone(),
            inside: seed.inside,
        };
        let standing = match self.standing_place(&item, &at.uv) {
            Place::Outside => return Ok(None),
            Place::Mixed => Standing::Open("a critical point on a border"),
            Place::Inside => {
                let determinant = at.h[0].times(&at.h[2]).minus(&at.h[1].squared());
                match &seed.kind {
                    Kind::Cell(_) => all_rise(&[at.h[0].clone(), at.h[2].clone(), determinant]),
                    Kind::Arc(a) => both(
                        all_rise(&at.h[..1]),
                        self.rises_inward(goal, face, *a, &k[0]),
                    ),
                    Kind::Iso { fixed, .. } => both(
                        all_rise(&at.h[..1]),
                        self.rises_across(goal, face, &at.uv, &[*fixed]),
                    ),
                    Kind::Point { .. } => Standing::Open("no critical point"),
                }
            }
        };
        let spot = Spot {
            face,
            at: jet.p,
            f: at.f,
            standing,
            deep: false,
            pole: false,
        };
        Ok(Some(self.judged(goal, spot, &at.uv, join)))
    }

    /// The same, with whether a way that starts at `uv` leads down from it.
    fn judged(&self, goal: &Goal, spot: Spot, uv: &[Ball; 2], join: f64) -> Spot {
        let deep = spot.standing == Standing::Falls
            && self.falls_far(goal, spot.face, uv, &spot.box64(), join);
        Spot { deep, ..spot }
    }

    /// Whether a face comes within `join` of a place; `None` where that is not certain, or where it comes
    /// within `same` only.
    fn comes_near(&self, face: usize, at: &[[f64; 2]; 3], join: f64, same: f64) -> Option<bool> {
        let near = self.seeds.iter().any(|s| {
            let bounds = s.bounds.each_ref().map(|b| [b.lo(), b.hi()]);
            s.face == face && least_apart(&bounds, at) <= same
        });
        if !near {
            return Some(false);
        }
        let middle = at.map(|[lo, hi]| 0.5 * (lo + hi));
        let spread = (0..3).map(|k| at[k][1] - at[k][0]).fold(0.0, f64::max);
        let goal = Goal::Distance(middle);
        let least = self.least_of(&goal, |f| f == face, [3000, 100])?;
        let root = |b: &Ball| b.times(&Ball::exact(2.0)).root();
        if root(&least.low).lo() > same + spread {
            return Some(false);
        }
        let high = root(&least.high?).hi();
        (high + 2.0 * spread <= join).then_some(true)
    }
}

impl Second<'_> {
    /// All contacts with f up to `limit`: the distance from `center`, or `normal . x - offset`. Of one BREP, not
    /// of several. Tens of milliseconds to seconds.
    pub fn sphere_contacts(&self, center: [f64; 3], limit: f64, size: f64) -> SecondContacts {
        self.contacts(&Goal::Distance(center), limit, size)
    }

    /// The same of a half-space.
    pub fn half_space_contacts(
        &self,
        normal: [f64; 3],
        offset: f64,
        limit: f64,
        size: f64,
    ) -> SecondContacts {
        self.contacts(&Goal::Plane(normal, offset), limit, size)
    }

    fn contacts(&self, goal: &Goal, limit: f64, size: f64) -> SecondContacts {
        match self.found_contacts(goal, limit, size) {
            Ok(all) => SecondContacts::All(all),
            Err(why) => SecondContacts::Open(why),
        }
    }

    fn found_contacts(
        &self,
        goal: &Goal,
        limit: f64,
        size: f64,
    ) -> Result<Vec<SecondContact>, String> {
        let scene = &self.scene;
        let (join, same) = (JOIN * size, SAME * size);
        // Places joined to a contact may be higher by `join`.
        let reach = limit + 4.0 * join;
        let high = match goal {
            Goal::Distance(_) if reach < 0.0 => return Ok(Vec::new()),
            Goal::Distance(_) => (0.5 * reach * reach).next_up().next_up(),
            Goal::Plane(..) => reach,
        };
        let mut spots = Vec::new();
        for face in 0..scene.faces.len() {
            let all = scene.spots(goal, face, high, join)?;
            let all = scene.with_poles(goal, face, high, join, all);
            // What is open is joined to a contact that it is next to, and is none where a way leads down. Next to a
            // place that falls by rounding only it may be one.
            let known: Vec<[[f64; 2]; 3]> = all
                .iter()
                .filter(|s| s.standing == Standing::Stands || s.deep)
                .map(Spot::box64)
                .collect();
            for s in all {
                if let Standing::Open(why) = s.standing {
                    let at = s.box64();
                    if known.iter().any(|k| most_apart(k, &at) <= join) {
                        continue;
                    }
                    return Err(format!("face {face}, near {:?}: {why}", at.map(|x| x[0])));
                }
                spots.push(s);
            }
        }
        let boxes: Vec<[[f64; 2]; 3]> = spots.iter().map(Spot::box64).collect();
        // A pole is taken as a whole: f falls from somewhere on it, but where to is not known.
        for (i, s) in spots.iter().enumerate() {
            let beside = |j: usize| {
                let o = &spots[j];
                o.face == s.face
                    && o.standing == Standing::Stands
                    && most_apart(&boxes[i], &boxes[j]) <= join
            };
            if s.pole && !s.deep && !(0..spots.len()).any(beside) {
                return Err(format!("face {}: a pole from which f may fall", s.face));
            }
        }
        let mut contacts: Vec<(SecondContact, [[f64; 2]; 3])> = Vec::new();
        'spots: for (i, s) in spots.iter().enumerate() {
            if s.standing != Standing::Stands {
                continue;
            }
            for face in 0..scene.faces.len() {
                let there: Vec<&Spot> = (0..spots.len())
                    .filter(|j| spots[*j].face == face && most_apart(&boxes[i], &boxes[*j]) <= join)
                    .map(|j| &spots[j])
                    .collect();
                let stands = there.iter().any(|s| s.standing == Standing::Stands);
                if there.iter().any(|s| s.deep) {
                    continue 'spots;
                }
                if there.iter().any(|s| s.standing == Standing::Falls) {
                    return Err(format!(
                        "face {face} near {:?}: f falls from one end of it, by how much is not known",
                        boxes[i].map(|x| x[0])
                    ));
                }
                if stands {
                    continue;
                }
                match scene.comes_near(face, &boxes[i], join, same) {
                    Some(false) => {}
                    // It may go on falling there, by how much is not known.
                    Some(true) | None => {
                        return Err(format!(
                            "face {face} near {:?}: joined or not",
                            boxes[i].map(|x| x[0])
                        ));
                    }
                }
            }
            let f = match goal {
                Goal::Distance(_) => s.f.times(&Ball::exact(2.0)).root(),
                Goal::Plane(..) => s.f.clone(),
            };
            let mut one = SecondContact {
                f: [f.lower().center(), f.upper().center()],
                at: boxes[i],
            };
            // The same one on another face, or as another kind of place.
            if let Some((old, _)) = contacts
                .iter_mut()
                .find(|(_, b)| most_apart(b, &boxes[i]) <= 2.0 * join)
            {
                if one.f[0] < old.f[0] {
                    std::mem::swap(old, &mut one);
                }
                continue;
            }
            if contacts
                .iter()
                .any(|(_, b)| least_apart(b, &boxes[i]) <= same)
            {
                return Err("contacts next to each other".to_owned());
            }
            contacts.push((one, boxes[i]));
        }
        Ok(contacts.into_iter().map(|(c, _)| c).collect())
    }
}
