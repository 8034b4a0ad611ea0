//! The least value of an objective over the union of trimmed faces, by branch and bound.
//!
//! # What is searched
//! A minimiser of f over a face is one of
//! - a critical point of f(S(u, v)) inside a smooth cell of the surface (f has no lower value near it, so its gradient
//!   is 0 and its second derivatives along u and v are not negative; on the border of a cell across which the
//!   tangent plane does not break both hold for the formulas of both cells);
//! - a critical point of f(S(c(t))) on an arc c of a loop, inside the domain;
//! - one on a side of the domain or on a crease (a line across which the tangent plane may break), in the region;
//! - an end of one of those.
//!
//! Where an arc leaves the domain it crosses a side of it, and where a side leaves the region it crosses an
//! arc. So arcs that may leave the domain are never discarded for being monotone, and then sides may be.
//!
//! # Bounds
//! On a box X with middle m, from enclosures of f, its gradient g and its second derivatives H over X:
//! f >= its natural enclosure; f >= f(m) + g(m) d + d H d / 2 (Taylor; across creases f(m) + g(X) d).
//! (Across knot lines of continuous tangent planes g is Lipschitz, and H holds its generalised derivatives: the same
//! theorems.) A box is discarded if g or the mean value form g(m) + H d excludes 0, if H says that it holds no minimum, or if Krawczyk's
//! operator K(X) = m - Y g(m) + (1 - Y H(X)) (X - m) (R. Krawczyk, Computing 4, 1969) misses X. Where K of a
//! somewhat larger box lies inside that, there is exactly one critical point, which is then enclosed to all digits.
//!
//! First in f64 intervals, then what is left in balls of 256 bits.

use super::number::{Ball, Interval64, Number};
use super::region::{Place, Region};
use super::shape::{Shape, SurfaceJet, dot};
use feeler::brep::Brep;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

pub(crate) struct FaceShape<'a> {
    pub(crate) shape: Shape<'a>,
    pub(crate) region: Region<'a>,
    pub(crate) brep: usize,
}

/// A part of the problem.
pub(crate) enum Kind {
    /// The inside of a smooth cell.
    Cell([usize; 2]),
    /// An arc of a loop.
    Arc(usize),
    /// A line of constant parameter `fixed`.
    Iso { fixed: usize, at: Ball },
    /// A single point; whether it is on a loop.
    Point { on_loop: bool },
}

pub(crate) struct Seed {
    pub(crate) face: usize,
    pub(crate) kind: Kind,
    /// Parameters; along an arc [0, 1] and nothing.
    pub(crate) x: [Ball; 2],
    /// Its ends, exactly: `x` may reach beyond them by rounding.
    ends: [(Ball, Ball); 2],
    /// All of it is known to belong to the face.
    pub(super) inside: bool,
    /// Holds all of it in space.
    pub(super) bounds: [Interval64; 3],
}

impl Seed {
    /// Whether a point is on this part, and not on its formula's continuation.
    fn owns<N: Number>(&self, x: &[N; 2]) -> bool {
        (0..self.dims()).all(|c| {
            let x = x[c].ball();
            !x.below(&self.ends[c].0) && !self.ends[c].1.below(&x)
        })
    }

    /// The same without what lies beyond the ends.
    pub(super) fn clipped<N: Number>(&self, x: [N; 2]) -> [N; 2] {
        let mut all = x;
        for c in 0..self.dims() {
            let (from, to) = (
                N::of(&self.ends[c].0).lower(),
                N::of(&self.ends[c].1).upper(),
            );
            let below = all[c].lower().below(&from) && from.below(&all[c].upper());
            let lower = if below { from } else { all[c].lower() };
            let above = to.below(&all[c].upper()) && lower.below(&to);
            if above {
                all[c] = lower.hull(&to);
            } else if below {
                all[c] = lower.hull(&all[c].upper());
            }
        }
        all
    }

    pub(super) fn dims(&self) -> usize {
        match self.kind {
            Kind::Cell(_) => 2,
            Kind::Arc(_) | Kind::Iso { .. } => 1,
            Kind::Point { .. } => 0,
        }
    }
}

/// What is made small.
pub(crate) enum Goal {
    /// Half the square of the distance from a point.
    Distance([f64; 3]),
    /// n.x - h.
    Plane([f64; 3], f64),
}

impl Goal {
    pub(super) fn value<N: Number>(&self, p: &[N; 3]) -> N {
        match self {
            Self::Distance(q) => {
                let mut all = N::zero();
                for c in 0..3 {
                    all = all.plus(&p[c].minus(&N::exact(q[c])).squared());
                }
                all.times(&N::exact(0.5))
            }
            Self::Plane(n, h) => dot(&n.map(N::exact), p).minus(&N::exact(*h)),
        }
    }
    /// Its derivative along `d`.
    pub(super) fn first<N: Number>(&self, p: &[N; 3], d: &[N; 3]) -> N {
        match self {
            Self::Distance(q) => {
                let r: [N; 3] = std::array::from_fn(|c| p[c].minus(&N::exact(q[c])));
                dot(&r, d)
            }
            Self::Plane(n, _) => dot(&n.map(N::exact), d),
        }
    }
    /// Its second derivative along `a` and `b`, of which `ab` is the mixed derivative.
    fn second<N: Number>(&self, p: &[N; 3], a: &[N; 3], b: &[N; 3], ab: &[N; 3]) -> N {
        match self {
            Self::Distance(_) => {
                let own = if std::ptr::eq(a, b) {
                    let mut all = a[0].squared();
                    for x in &a[1..] {
                        all = all.plus(&x.squared());
                    }
                    all
                } else {
                    dot(a, b)
                };
                own.plus(&self.first(p, ab))
            }
            Self::Plane(..) => self.first(p, ab),
        }
    }
}

/// f, its gradient and second derivatives (uu, uv, vv) on a box, and where the box is.
pub(crate) struct Local<N> {
    pub(crate) f: N,
    pub(crate) g: [N; 2],
    pub(super) h: [N; 3],
    pub(crate) uv: [N; 2],
    /// The only cell it meets.
    pub(super) cell: Option<[usize; 2]>,
    /// No crease passes through it: f has continuous first derivatives.
    pub(super) smooth: bool,
}

pub(crate) struct Item<N> {
    pub(super) seed: usize,
    pub(super) x: [N; 2],
    pub(super) low: N,
    /// All of it is known to belong to the face.
    pub(super) inside: bool,
}

impl<N: Number> PartialEq for Item<N> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl<N: Number> Eq for Item<N> {}
impl<N: Number> PartialOrd for Item<N> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl<N: Number> Ord for Item<N> {
    /// Least first.
    fn cmp(&self, other: &Self) -> Ordering {
        if self.low.below(&other.low) {
            Ordering::Greater
        } else if other.low.below(&self.low) {
            Ordering::Less
        } else {
            Ordering::Equal
        }
    }
}

/// The only critical point in the box `x` of a seed; it lies in `k`.
pub(crate) struct Candidate {
    pub(super) seed: usize,
    /// The cell whose formula it is; none where it is of several.
    pub(super) cell: Option<[usize; 2]>,
    pub(super) x: [Ball; 2],
    pub(super) k: [Ball; 2],
    pub(super) low: Ball,
}

/// The faces of several BREPs, and what is searched of them.
pub(crate) struct Scene<'a> {
    pub(crate) faces: Vec<FaceShape<'a>>,
    pub(crate) seeds: Vec<Seed>,
    /// The largest coordinate.
    pub(crate) scale: f64,
    pub(crate) closed: Vec<bool>,
}

/// What a search found of the least value.
pub(crate) struct Least {
    pub(crate) low: Ball,
    /// Attained on a face; none if no point was proven to belong to one.
    pub(crate) high: Option<Ball>,
    /// Boxes in f64 and in balls.
    pub(crate) nodes: [usize; 2],
}

/// Parameters on the surface, and the only cell they meet.
type Placed<N> = ([N; 2], Option<[usize; 2]>);

fn point_of<N: Number>(x: &[Ball; 2]) -> [N; 2] {
    [N::of(&x[0]), N::of(&x[1])]
}

impl<'a> Scene<'a> {
    pub(crate) fn new(breps: &[&'a Brep]) -> Self {
        let mut scene = Self {
            faces: Vec::new(),
            seeds: Vec::new(),
            scale: 0.0,
            closed: breps.iter().map(|b| b.is_closed()).collect(),
        };
        for (b, brep) in breps.iter().enumerate() {
            for (i, face) in brep.faces().iter().enumerate() {
                let shape = Shape::new(brep.surface(i));
                let region = Region::new(brep, face, shape.domain);
                scene.faces.push(FaceShape {
                    shape,
                    region,
                    brep: b,
                });
                let nothing = face.loops.as_ref().is_some_and(Vec::is_empty);
                if !nothing {
                    scene.seed(scene.faces.len() - 1);
                }
            }
        }
        scene
    }

    fn add(&mut self, face: usize, kind: Kind, ends: [(Ball, Ball); 2]) {
        let x = ends.each_ref().map(|(a, b)| a.hull(b));
        let parts = &self.faces[face];
        let inside = match &kind {
            Kind::Arc(a) => {
                (0..2).all(|c| parts.region.arcs[*a].piece.within(c, parts.shape.domain[c]))
            }
            _ => false,
        };
        let mut seed = Seed {
            face,
            inside,
            kind,
            x,
            ends,
            bounds: [Interval64::new(f64::NEG_INFINITY, f64::INFINITY); 3],
        };
        let x = point_of::<Interval64>(&seed.x);
        if let Some((jet, _)) = self.jets(&seed, &x, None) {
            seed.bounds = jet.p;
        }
        for b in &seed.bounds {
            if b.magnitude().is_finite() {
                self.scale = self.scale.max(b.magnitude());
            }
        }
        self.seeds.push(seed);
    }

    fn seed(&mut self, face: usize) {
        let zero = || Ball::exact(0.0);
        let none = || (zero(), zero());
        let (ranges, creases, domain) = {
            let s = &self.faces[face].shape;
            let ranges: [Vec<(Ball, Ball)>; 2] = std::array::from_fn(|c| {
                s.ranges[c]
                    .iter()
                    .map(|r| (r.from.clone(), r.to.clone()))
                    .collect()
            });
            (ranges, s.creases.clone(), s.domain)
        };
        for i in 0..ranges[0].len() {
            for j in 0..ranges[1].len() {
                let x = [ranges[0][i].clone(), ranges[1][j].clone()];
                self.add(face, Kind::Cell([i, j]), x);
            }
        }
        for a in 0..self.faces[face].region.arcs.len() {
            let unit = (zero(), Ball::exact(1.0));
            self.add(face, Kind::Arc(a), [unit, none()]);
            let start = self.faces[face].region.arcs[a].start.clone();
            let start = start.map(|x| (x.clone(), x));
            self.add(face, Kind::Point { on_loop: true }, start);
        }
        for fixed in 0..2 {
            let mut lines = vec![
                Ball::exact(domain[fixed].start),
                Ball::exact(domain[fixed].end),
            ];
            lines.extend(creases[fixed].iter().cloned());
            for at in lines {
                for r in &ranges[1 - fixed] {
                    let at = at.clone();
                    self.add(face, Kind::Iso { fixed, at }, [r.clone(), none()]);
                }
            }
        }
        // Corners of all cells.
        for u in corners(&ranges[0]) {
            for v in corners(&ranges[1]) {
                let both = [(u.clone(), u.clone()), (v.clone(), v)];
                self.add(face, Kind::Point { on_loop: false }, both);
            }
        }
    }

    /// The surface or curve over a box (of a curve the derivatives along it are those along u), and uv.
    pub(super) fn jets<N: Number>(
        &self,
        seed: &Seed,
        x: &[N; 2],
        cell: Option<[usize; 2]>,
    ) -> Option<(SurfaceJet<N>, Placed<N>)> {
        let face = &self.faces[seed.face];
        let across = |uv: &[N; 2]| -> Option<(SurfaceJet<N>, Option<[usize; 2]>)> {
            if let Some(cell) = cell {
                return Some((face.shape.jet(cell, uv)?, Some(cell)));
            }
            let (i, j) = (face.shape.met(0, &uv[0]), face.shape.met(1, &uv[1]));
            if i.len() == 1 && j.len() == 1 {
                let cell = [i.start, j.start];
                return Some((face.shape.jet(cell, uv)?, Some(cell)));
            }
            Some((face.shape.jet_across(uv)?, None))
        };
        let none = || std::array::from_fn(|_| N::zero());
        match &seed.kind {
            Kind::Cell(own) => {
                let jet = face.shape.jet(*own, x)?;
                Some((jet, (x.clone(), Some(*own))))
            }
            Kind::Arc(a) => {
                let c = face.region.arcs[*a].piece.jet(&x[0])?;
                let (s, cell) = across(&c.p)?;
                let (du, dv) = (&c.d[0], &c.d[1]);
                let two = N::exact(2.0);
                let (uu, uv, vv) = (du.squared(), two.times(du).times(dv), dv.squared());
                let along = |k: usize| s.u[k].times(du).plus(&s.v[k].times(dv));
                let second = |k: usize| {
                    s.uu[k]
                        .times(&uu)
                        .plus(&s.uv[k].times(&uv))
                        .plus(&s.vv[k].times(&vv))
                        .plus(&s.u[k].times(&c.dd[0]))
                        .plus(&s.v[k].times(&c.dd[1]))
                };
                let jet = SurfaceJet {
                    u: std::array::from_fn(along),
                    uu: std::array::from_fn(second),
                    p: s.p,
                    v: none(),
                    uv: none(),
                    vv: none(),
                };
                Some((jet, (c.p, cell)))
            }
            Kind::Iso { fixed, at } => {
                let at = N::of(at);
                let uv = if *fixed == 0 {
                    [at, x[0].clone()]
                } else {
                    [x[0].clone(), at]
                };
                let (s, cell) = across(&uv)?;
                let (u, uu) = if *fixed == 0 {
                    (s.v, s.vv)
                } else {
                    (s.u, s.uu)
                };
                let jet = SurfaceJet {
                    p: s.p,
                    u,
                    uu,
                    v: none(),
                    uv: none(),
                    vv: none(),
                };
                Some((jet, (uv, cell)))
            }
            Kind::Point { .. } => {
                let (s, cell) = across(x)?;
                Some((s, (x.clone(), cell)))
            }
        }
    }

    pub(super) fn local<N: Number>(
        &self,
        goal: &Goal,
        seed: &Seed,
        x: &[N; 2],
        cell: Option<[usize; 2]>,
    ) -> Option<Local<N>> {
        let (s, (uv, cell)) = self.jets(seed, x, cell)?;
        let smooth = cell.is_some() || !self.faces[seed.face].shape.creased(&uv);
        let f = goal.value(&s.p);
        let (g, h) = if seed.dims() == 2 {
            (
                [goal.first(&s.p, &s.u), goal.first(&s.p, &s.v)],
                [
                    goal.second(&s.p, &s.u, &s.u, &s.uu),
                    goal.second(&s.p, &s.u, &s.v, &s.uv),
                    goal.second(&s.p, &s.v, &s.v, &s.vv),
                ],
            )
        } else {
            (
                [goal.first(&s.p, &s.u), N::zero()],
                [goal.second(&s.p, &s.u, &s.u, &s.uu), N::zero(), N::zero()],
            )
        };
        Some(Local {
            f,
            g,
            h,
            uv,
            cell,
            smooth,
        })
    }

    pub(super) fn place<N: Number>(&self, seed: &Seed, uv: &[N; 2]) -> Place {
        let region = &self.faces[seed.face].region;
        match seed.kind {
            Kind::Arc(_) | Kind::Point { on_loop: true } => match region.in_domain(uv) {
                None => Place::Outside,
                Some(true) => Place::Inside,
                Some(false) => Place::Mixed,
            },
            _ => region.place(uv),
        }
    }

    /// Branch and bound over `start`; what is left may hold the minimum, and only that and the candidates.
    fn run<N: Number>(
        &self,
        goal: &Goal,
        start: Vec<Item<N>>,
        best: &mut Option<Ball>,
        noise: f64,
        budget: usize,
        candidates: &mut Vec<Candidate>,
    ) -> (Vec<Item<N>>, usize) {
        let (mut points, start): (Vec<_>, Vec<_>) = start
            .into_iter()
            .partition(|i| self.seeds[i.seed].dims() == 0);
        let mut heap: BinaryHeap<Item<N>> = start.into();
        let mut left = Vec::new();
        let mut nodes = 0;
        let mut high: Option<N> = best.as_ref().map(N::of);
        // Points first: a minimum in one is below every box about it, which would be halved for ever.
        points.sort_by(|a, b| b.cmp(a));
        for item in points {
            if let Step::Left(item) = self.examine(goal, item, &mut high, best, candidates) {
                left.push(item);
            }
        }
        while let Some(item) = heap.pop() {
            let settled = high
                .as_ref()
                .is_some_and(|b| b.minus(&N::exact(noise)).below(&item.low));
            if settled || nodes >= budget {
                left.push(item);
                left.extend(heap.drain());
                break;
            }
            nodes += 1;
            let before = best.clone();
            match self.examine(goal, item, &mut high, best, candidates) {
                Step::Gone => {}
                Step::Left(item) => left.push(item),
                Step::Parts(parts) => heap.extend(parts),
            }
            if best.is_some() && before.is_none() {
                high = best.as_ref().map(N::of);
            }
        }
        if let Some(b) = best {
            let b = N::of(b);
            left.retain(|i| !b.below(&i.low));
        }
        (left, nodes)
    }

    fn examine<N: Number>(
        &self,
        goal: &Goal,
        mut item: Item<N>,
        high: &mut Option<N>,
        best: &mut Option<Ball>,
        candidates: &mut Vec<Candidate>,
    ) -> Step<N> {
        let seed = &self.seeds[item.seed];
        let dims = seed.dims();
        let too_high = |low: &N, high: &Option<N>| high.as_ref().is_some_and(|b| b.below(low));
        if too_high(&item.low, high) {
            return Step::Gone;
        }
        let Some(over) = self.local(goal, seed, &item.x, None) else {
            return split(seed, item, dims, &[1.0, 1.0]);
        };
        let raise = |item: &mut Item<N>, low: N| {
            if item.low.below(&low) {
                item.low = low;
            }
        };
        raise(&mut item, over.f.lower());
        if too_high(&item.low, high) {
            return Step::Gone;
        }
        if !item.inside {
            match self.place(seed, &over.uv) {
                Place::Outside => return Step::Gone,
                Place::Inside => item.inside = true,
                Place::Mixed => {}
            }
        }
        let improve = |value: &N,
                       x: &[N; 2],
                       uv: &[N; 2],
                       high: &mut Option<N>,
                       best: &mut Option<Ball>,
                       inside: bool| {
            let value = value.upper();
            let better = high.as_ref().is_none_or(|b| value.below(b));
            if better && seed.owns(x) && (inside || self.place(seed, uv) == Place::Inside) {
                *best = Some(value.ball().upper());
                *high = Some(value);
            }
        };
        if dims == 0 {
            improve(&over.f, &item.x, &over.uv, high, best, item.inside);
            return Step::Left(item);
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
        improve(&at.f, &middle, &at.uv, high, best, item.inside);
        let d: [N; 2] = std::array::from_fn(|c| item.x[c].minus(&middle[c]));
        let product = |a: &N, b: &N, c: &N| a.times(&d[0]).plus(&b.times(&d[1])).plus(c);
        let smooth = over.smooth;
        let low = if smooth {
            let half = N::exact(0.5);
            let two = N::exact(2.0);
            let square = over.h[0]
                .times(&d[0].squared())
                .plus(&two.times(&over.h[1]).times(&d[0].times(&d[1])))
                .plus(&over.h[2].times(&d[1].squared()))
                .times(&half);
            product(&at.g[0], &at.g[1], &at.f).plus(&square)
        } else {
            product(&over.g[0], &over.g[1], &at.f)
        };
        raise(&mut item, low.lower());
        if too_high(&item.low, high) {
            return Step::Gone;
        }
        let weight = weights(&item, &over, dims);
        if !smooth || !critical {
            return split(seed, item, dims, &weight);
        }
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
                let cell = over.cell;
                if let Some(there) = self.local(goal, seed, &k, cell) {
                    raise(&mut item, there.f.lower());
                    if too_high(&item.low, high) {
                        return Step::Gone;
                    }
                }
                // The nearest point of the box is a point of the face, if the place is right.
                let near = clamped(&k, &seed.clipped(item.x.clone()));
                if let Some(there) = self.local(goal, seed, &near, cell) {
                    improve(&there.f, &near, &there.uv, high, best, item.inside);
                }
                let ball = |x: &[N; 2]| [x[0].ball(), x[1].ball()];
                candidates.push(Candidate {
                    seed: item.seed,
                    cell,
                    x: ball(&item.x),
                    k: ball(&k),
                    low: item.low.ball(),
                });
                Step::Gone
            }
        }
    }

    pub(super) fn newton<N: Number>(
        &self,
        goal: &Goal,
        seed: &Seed,
        item: &Item<N>,
        at: &Local<N>,
        over: &Local<N>,
        dims: usize,
    ) -> Newton<N> {
        let Some(y) = inverse(&at.h, dims) else {
            return Newton::Unknown;
        };
        let middle = [item.x[0].middle(), item.x[1].middle()];
        let (k, contraction) = krawczyk(&item.x, &middle, at, &over.h, &y, dims);
        let Some(k) = k else {
            return Newton::Unknown;
        };
        let mut shrunk = item.x.clone();
        let mut smaller = false;
        for c in 0..dims {
            let Some(x) = item.x[c].meet(&k[c]) else {
                return Newton::Nothing;
            };
            smaller |= x.radius() < 0.25 * item.x[c].radius();
            shrunk[c] = x;
        }
        if contraction > 0.6 {
            return if smaller {
                Newton::Shrunk(shrunk)
            } else {
                Newton::Unknown
            };
        }
        // A box half as large again, on which the cell's formula goes on.
        let mut wide: [N; 2] = std::array::from_fn(|c| {
            let r = item.x[c].radius();
            if c < dims {
                item.x[c].widened(0.5 * r)
            } else {
                item.x[c].clone()
            }
        });
        let Some(h) = self.local(goal, seed, &wide, over.cell) else {
            return Newton::Unknown;
        };
        if !h.smooth {
            return Newton::Unknown;
        }
        let (k, _) = krawczyk(&wide, &middle, at, &h.h, &y, dims);
        let Some(mut k) = k else {
            return Newton::Unknown;
        };
        let strictly = (0..dims)
            .all(|c| wide[c].lower().below(&k[c].lower()) && k[c].upper().below(&wide[c].upper()));
        if !strictly {
            return if smaller {
                Newton::Shrunk(shrunk)
            } else {
                Newton::Unknown
            };
        }
        // Exactly one zero in `wide`, and it is in k. Again, as long as it becomes smaller.
        for _ in 0..60 {
            if (0..dims).any(|c| k[c].meet(&item.x[c]).is_none()) {
                return Newton::Nothing;
            }
            let before = (0..dims).fold(0.0f64, |m, c| m.max(k[c].radius()));
            wide = k.clone();
            match self.refined(goal, seed, &wide, over.cell, dims) {
                Some(better) => k = better,
                None => break,
            }
            let after = (0..dims).fold(0.0f64, |m, c| m.max(k[c].radius()));
            if !(after < 0.9 * before) {
                break;
            }
        }
        Newton::Only(k)
    }

    /// A smaller enclosure of the critical point that is known to be in `x`.
    pub(super) fn refined<N: Number>(
        &self,
        goal: &Goal,
        seed: &Seed,
        x: &[N; 2],
        cell: Option<[usize; 2]>,
        dims: usize,
    ) -> Option<[N; 2]> {
        let middle = [x[0].middle(), x[1].middle()];
        let at = self.local(goal, seed, &middle, cell)?;
        let over = self.local(goal, seed, x, cell)?;
        let y = inverse(&at.h, dims)?;
        let (k, _) = krawczyk(x, &middle, &at, &over.h, &y, dims);
        let k = k?;
        let mut all = x.clone();
        for c in 0..dims {
            all[c] = x[c].meet(&k[c]).unwrap_or_else(|| x[c].clone());
        }
        Some(all)
    }

    /// The candidate to all digits: a bound of f there, or `None` if it is no minimum of a face.
    fn settle(&self, goal: &Goal, candidate: &Candidate, best: &mut Option<Ball>) -> Option<Ball> {
        if best.as_ref().is_some_and(|b| b.below(&candidate.low)) {
            return None;
        }
        let seed = &self.seeds[candidate.seed];
        let dims = seed.dims();
        let cell = candidate.cell;
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
            return None;
        }
        let middle = [k[0].middle(), k[1].middle()];
        let d: [Ball; 2] = std::array::from_fn(|c| k[c].minus(&middle[c]));
        let at = self.local(goal, seed, &middle, cell)?;
        let over = self.local(goal, seed, &k, cell)?;
        let value =
            at.f.plus(&over.g[0].times(&d[0]))
                .plus(&over.g[1].times(&d[1]));
        let low = value.lower();
        if best.as_ref().is_some_and(|b| b.below(&low)) {
            return None;
        }
        let place = self.place(seed, &over.uv);
        if place == Place::Outside {
            return None;
        }
        let near: [Ball; 2] = std::array::from_fn(|c| {
            let ((from, to), m) = (&seed.ends[c], k[c].middle());
            match (m.below(from), to.below(&m)) {
                (true, _) => from.clone(),
                (_, true) => to.clone(),
                _ => m,
            }
        });
        if let Some(there) = self.local(goal, seed, &near, cell) {
            let high = there.f.upper();
            if best.as_ref().is_none_or(|b| high.below(b))
                && seed.owns(&near)
                && self.place(seed, &there.uv) == Place::Inside
            {
                *best = Some(high);
            }
        }
        Some(low)
    }

    /// Encloses the least value over the faces of one BREP, or of all.
    pub(crate) fn least(
        &self,
        goal: &Goal,
        brep: Option<usize>,
        budget: [usize; 2],
    ) -> Option<Least> {
        let of = |face: usize| brep.is_none_or(|b| b == self.faces[face].brep);
        self.least_of(goal, of, budget)
    }

    /// The same over some faces.
    pub(super) fn least_of(
        &self,
        goal: &Goal,
        of: impl Fn(usize) -> bool,
        budget: [usize; 2],
    ) -> Option<Least> {
        let mut start = Vec::new();
        for (i, seed) in self.seeds.iter().enumerate() {
            if !of(seed.face) {
                continue;
            }
            start.push(Item {
                seed: i,
                x: point_of::<Interval64>(&seed.x),
                low: goal.value(&seed.bounds).lower(),
                inside: seed.inside,
            });
        }
        if start.is_empty() {
            return None;
        }
        let far = match goal {
            Goal::Distance(q) => q.iter().fold(self.scale, |m, x| m.max(x.abs())),
            Goal::Plane(_, h) => self.scale.max(h.abs()),
        };
        let unit = match goal {
            Goal::Distance(_) => far * far,
            Goal::Plane(..) => far,
        };
        let mut best = None;
        let mut candidates = Vec::new();
        let noise = NOISE * unit;
        let (left, nodes64) = self.run(goal, start, &mut best, noise, budget[0], &mut candidates);
        let start = left
            .into_iter()
            .map(|i| Item {
                seed: i.seed,
                // Points and ends are known to more digits than f64.
                x: if self.seeds[i.seed].dims() == 0 {
                    self.seeds[i.seed].x.clone()
                } else {
                    self.seeds[i.seed].clipped([i.x[0].ball(), i.x[1].ball()])
                },
                low: i.low.ball().lower(),
                inside: i.inside,
            })
            .collect();
        // What is already proven unique gives the best upper bounds: first.
        candidates.sort_by(|a, b| a.low.lo().total_cmp(&b.low.lo()));
        let mut low: Option<Ball> = None;
        let mut lowest = |x: Ball| {
            if low.as_ref().is_none_or(|l| x.below(l)) {
                low = Some(x);
            }
        };
        for c in candidates.drain(..) {
            if let Some(x) = self.settle(goal, &c, &mut best) {
                lowest(x);
            }
        }
        let noise = BALL_NOISE * unit;
        let (left, nodes) = self.run(goal, start, &mut best, noise, budget[1], &mut candidates);
        for c in candidates.drain(..) {
            if let Some(x) = self.settle(goal, &c, &mut best) {
                lowest(x);
            }
        }
        for item in left {
            lowest(item.low);
        }
        // What could be lower than the best is in the bounds above.
        if let Some(b) = &best
            && low.as_ref().is_none_or(|l| b.below(l))
        {
            low = Some(b.clone());
        }
        Some(Least {
            low: low?,
            high: best,
            nodes: [nodes64, nodes],
        })
    }
}

/// A box whose bound is within this of the best is left to the balls, relative to the objective's size.
const NOISE: f64 = 1e-13;
/// In f64, curves that are not known to belong to a face are not halved below this share of theirs.
const HUGGING: f64 = 1e-5;
/// And here it is settled.
const BALL_NOISE: f64 = 1e-62;

pub(super) enum Step<N> {
    Gone,
    Left(Item<N>),
    Parts(Vec<Item<N>>),
}

pub(super) enum Newton<N> {
    Nothing,
    Unknown,
    Shrunk([N; 2]),
    Only([N; 2]),
}

fn corners(ranges: &[(Ball, Ball)]) -> Vec<Ball> {
    let mut all = vec![ranges[0].0.clone()];
    all.extend(ranges.iter().map(|r| r.1.clone()));
    all
}

/// The point of `x` nearest to the middle of `k`, up to rounding inside.
fn clamped<N: Number>(k: &[N; 2], x: &[N; 2]) -> [N; 2] {
    std::array::from_fn(|c| {
        let m = k[c].middle();
        if m.below(&x[c].lower()) {
            x[c].lower()
        } else if x[c].upper().below(&m) {
            x[c].upper()
        } else {
            m
        }
    })
}

pub(super) fn excludes_zero<N: Number>(g: &[N; 2], dims: usize) -> bool {
    (0..dims).any(|c| !g[c].may_be_zero())
}

/// Whether f has no local minimum in a box of derivatives `over`, whose middle has `at`, `d` off it: the gradient, by
/// the mean-value form, excludes 0, or f is concave along a parameter (also on the box's border, which the enclosure
/// holds too).
pub(super) fn no_minimum<N: Number>(
    over: &Local<N>,
    at: &Local<N>,
    d: &[N; 2],
    dims: usize,
) -> bool {
    let moved = |a: &N, b: &N, c: &N| a.times(&d[0]).plus(&b.times(&d[1])).plus(c);
    let g = [
        moved(&over.h[0], &over.h[1], &at.g[0]),
        moved(&over.h[1], &over.h[2], &at.g[1]),
    ];
    excludes_zero(&g, dims) || (0..dims).any(|c| over.h[2 * c].is_negative())
}

/// How much each direction adds to the uncertainty of f over a box.
pub(super) fn weights<N: Number>(item: &Item<N>, over: &Local<N>, dims: usize) -> [f64; 2] {
    std::array::from_fn(|c| {
        let r = item.x[c].radius();
        if c >= dims {
            0.0
        } else if over.smooth {
            r * over.h[2 * c].magnitude().sqrt()
        } else {
            r * over.g[c].magnitude()
        }
    })
}

/// Halves of the box across the direction of the larger weight.
pub(super) fn split<N: Number>(
    seed: &Seed,
    item: Item<N>,
    dims: usize,
    weight: &[f64; 2],
) -> Step<N> {
    // A line that may be on either side of a border all along: only balls can tell.
    let hugging = dims == 1 && !item.inside && N::UNIT == f64::EPSILON;
    let splittable = |c: usize| {
        let x = &item.x[c];
        let m = x.middle();
        let limit = if hugging {
            HUGGING * seed.x[c].radius()
        } else {
            N::SMALL.max(N::UNIT * x.magnitude())
        };
        let wide = x.radius() > limit;
        c < dims && wide && x.lower().below(&m) && m.below(&x.upper())
    };
    let first = usize::from(dims == 2 && !(weight[0] >= weight[1]));
    let Some(c) = [first, 1 - first].into_iter().find(|c| splittable(*c)) else {
        return Step::Left(item);
    };
    let m = item.x[c].middle();
    let part = |x: N| {
        let mut all = item.x.clone();
        all[c] = x;
        Item {
            seed: item.seed,
            x: seed.clipped(all),
            low: item.low.clone(),
            inside: item.inside,
        }
    };
    let (a, b) = (item.x[c].lower().hull(&m), m.hull(&item.x[c].upper()));
    Step::Parts(vec![part(a), part(b)])
}

fn mid<N: Number>(x: &N) -> f64 {
    0.5 * x.lo() + 0.5 * x.hi()
}

/// About the inverse of the symmetric matrix.
fn inverse<N: Number>(h: &[N; 3], dims: usize) -> Option<[[f64; 2]; 2]> {
    let h = h.each_ref().map(mid);
    let y = if dims == 1 {
        [[1.0 / h[0], 0.0], [0.0, 0.0]]
    } else {
        let det = h[0] * h[2] - h[1] * h[1];
        [[h[2] / det, -h[1] / det], [-h[1] / det, h[0] / det]]
    };
    y.iter().flatten().all(|x| x.is_finite()).then_some(y)
}

/// K(X) with the matrix Y, and how much it contracts (the row sums of |1 - Y H|). `at` is at `middle`, a point
/// of X.
fn krawczyk<N: Number>(
    x: &[N; 2],
    middle: &[N; 2],
    at: &Local<N>,
    h: &[N; 3],
    y: &[[f64; 2]; 2],
    dims: usize,
) -> (Option<[N; 2]>, f64) {
    let d: [N; 2] = std::array::from_fn(|c| x[c].minus(&middle[c]));
    let full = [[&h[0], &h[1]], [&h[1], &h[2]]];
    let mut k = x.clone();
    let mut contraction = 0.0f64;
    for r in 0..dims {
        let mut all = middle[r].clone();
        let mut sum = 0.0;
        for c in 0..dims {
            all = all.minus(&N::exact(y[r][c]).times(&at.g[c]));
            let mut entry = if r == c { N::exact(1.0) } else { N::zero() };
            for i in 0..dims {
                entry = entry.minus(&N::exact(y[r][i]).times(full[i][c]));
            }
            let size = entry.magnitude() * d[c].magnitude();
            sum += if size == 0.0 {
                0.0
            } else {
                size / d[r].magnitude()
            };
            all = all.plus(&entry.times(&d[c]));
        }
        contraction = contraction.max(sum);
        if !all.magnitude().is_finite() {
            return (None, f64::INFINITY);
        }
        k[r] = all;
    }
    (Some(k), contraction)
}
