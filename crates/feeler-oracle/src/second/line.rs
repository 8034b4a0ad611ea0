//! Lines and the side of a point in space, by the second method.
//!
//! **Hits.** S(u, v) = o + t d in the unknowns u, v, t: the component along which d is longest gives t, and two
//! equations G(u, v) = 0 are left, exact combinations with the components of d. On a box: G or its mean value form
//! excludes 0, or Krawczyk's operator finds exactly one root, or the box is halved. The roots are then enclosed in balls
//! and put to the region. What is not settled within the budget (tangencies, a line in a face) is `open`.
//!
//! **Side.** Parity along rays in fixed directions without pattern. A ray counts if nothing of it is open and every
//! root, on surfaces that go on a little beyond their domains, is farther than a margin in uv from every loop, so
//! that no crack is near it. Two rays that count must agree. This is a check and no proof: cracks wider than the
//! margin are not looked for.

use super::number::{Ball, Interval64, Number};
use super::region::Place;
use super::search::{Kind, Scene, Seed};
use super::shape::SurfaceJet;
use super::space::Second;
use feeler::query::LineKind;

/// A hit, as found by the second method.
#[derive(Clone, Debug)]
pub struct SecondHit {
    /// The face.
    pub face: usize,
    /// The parameter.
    pub t: Ball,
    /// The root lies in the face's region, as proven; otherwise it is on a loop, up to 2^-150.
    pub certain: bool,
    /// It is farther from every loop than a small part of the domain, in uv.
    pub clear: bool,
    /// About where.
    pub uv: [f64; 2],
}

/// All hits of a line, as far as the second method settles them.
#[derive(Clone, Debug, Default)]
pub struct SecondLine {
    /// Hits, by t. All are simple roots.
    pub hits: Vec<SecondHit>,
    /// Faces and ranges of t where there may be more, and only there.
    pub open: Vec<(usize, [f64; 2])>,
}

/// The side of a point in space, as the second method finds it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SecondSide {
    /// In material.
    Inside,
    /// Not in material.
    Outside,
    /// Not found.
    Undecided,
}

/// Boxes a line and face.
const BUDGET: usize = 2000;
/// The same in balls.
const BALL_BUDGET: usize = 300;
/// Distance from loops in uv, and how far surfaces go on, relative to the domain.
const MARGIN: f64 = 1e-5;

struct Probe {
    origin: [f64; 3],
    direction: [f64; 3],
    /// The component that gives t.
    k: usize,
}

struct Equations<N> {
    g: [N; 2],
    /// Rows: derivatives of one equation.
    j: [[N; 2]; 2],
    t: Option<N>,
}

impl Probe {
    fn new(origin: [f64; 3], direction: [f64; 3]) -> Self {
        let mut k = 0;
        for c in 1..3 {
            if direction[c].abs() > direction[k].abs() {
                k = c;
            }
        }
        Self {
            origin,
            direction,
            k,
        }
    }

    fn of<N: Number>(&self, s: &SurfaceJet<N>) -> Equations<N> {
        let e = |x: f64| N::exact(x);
        let k = self.k;
        let r: [N; 3] = std::array::from_fn(|c| s.p[c].minus(&e(self.origin[c])));
        let combine = |v: &[N; 3], i: usize| {
            v[i].times(&e(self.direction[k]))
                .minus(&v[k].times(&e(self.direction[i])))
        };
        let others = [(k + 1) % 3, (k + 2) % 3];
        Equations {
            g: others.map(|i| combine(&r, i)),
            j: others.map(|i| [combine(&s.u, i), combine(&s.v, i)]),
            t: r[k].over(&e(self.direction[k])),
        }
    }
}

/// A box, the smallest that is known to hold the root, and whether there is exactly one.
struct Root {
    face: usize,
    cell: [usize; 2],
    x: [Ball; 2],
    k: [Ball; 2],
}

/// Y, K(X) and how much it contracts.
fn krawczyk<N: Number>(
    x: &[N; 2],
    middle: &[N; 2],
    at: &Equations<N>,
    j: &[[N; 2]; 2],
) -> Option<([N; 2], f64)> {
    let mid = |n: &N| 0.5 * n.lo() + 0.5 * n.hi();
    let a: [[f64; 2]; 2] = std::array::from_fn(|r| std::array::from_fn(|c| mid(&at.j[r][c])));
    let det = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    let y = [
        [a[1][1] / det, -a[0][1] / det],
        [-a[1][0] / det, a[0][0] / det],
    ];
    if y.iter().flatten().any(|v| !v.is_finite()) {
        return None;
    }
    let d: [N; 2] = std::array::from_fn(|c| x[c].minus(&middle[c]));
    let mut contraction = 0.0f64;
    let mut k = x.clone();
    for r in 0..2 {
        let mut all = middle[r].clone();
        let mut sum = 0.0;
        for c in 0..2 {
            all = all.minus(&N::exact(y[r][c]).times(&at.g[c]));
            let mut entry = if r == c { N::exact(1.0) } else { N::zero() };
            for i in 0..2 {
                entry = entry.minus(&N::exact(y[r][i]).times(&j[i][c]));
            }
            let size = entry.magnitude() * d[c].magnitude();
            sum += if size == 0.0 {
                0.0
            } else {
                size / d[r].magnitude()
            };
            all = all.plus(&entry.times(&d[c]));
        }
        if !all.magnitude().is_finite() {
            return None;
        }
        contraction = contraction.max(sum);
        k[r] = all;
    }
    Some((k, contraction))
}

fn middle<N: Number>(x: &[N; 2]) -> [N; 2] {
    [x[0].middle(), x[1].middle()]
}

impl Scene<'_> {
    /// A smaller enclosure of the one root in `x`.
    fn refined_root<N: Number>(
        &self,
        probe: &Probe,
        face: usize,
        cell: [usize; 2],
        x: &[N; 2],
    ) -> Option<[N; 2]> {
        let shape = &self.faces[face].shape;
        let m = middle(x);
        let at = probe.of(&shape.jet(cell, &m)?);
        let over = probe.of(&shape.jet(cell, x)?);
        let (k, _) = krawczyk(x, &m, &at, &over.j)?;
        Some(std::array::from_fn(|c| {
            x[c].meet(&k[c]).unwrap_or_else(|| x[c].clone())
        }))
    }

    fn shrink<N: Number>(
        &self,
        probe: &Probe,
        face: usize,
        cell: [usize; 2],
        mut k: [N; 2],
    ) -> [N; 2] {
        for _ in 0..60 {
            let size = |k: &[N; 2]| k[0].radius().max(k[1].radius());
            let before = size(&k);
            match self.refined_root(probe, face, cell, &k) {
                Some(better) => k = better,
                None => break,
            }
            if !(size(&k) < 0.9 * before) {
                break;
            }
        }
        k
    }

    /// Roots on one cell, in `stack` with whether boxes are known to lie in the region. `extended`: also outside the
    /// region. What is smaller than `smallest` (of the cell) is left.
    fn cell_roots<N: Number>(
        &self,
        probe: &Probe,
        seed: &Seed,
        cell: [usize; 2],
        mut stack: Vec<([N; 2], bool)>,
        extended: bool,
        found: &mut Found,
    ) {
        let parts = &self.faces[seed.face];
        let face = seed.face;
        let smallest = if N::UNIT < f64::EPSILON {
            SMALLEST_BALL
        } else {
            SMALLEST
        };
        let size: [f64; 2] = std::array::from_fn(|c| smallest * seed.x[c].radius());
        while let Some((x, mut inside)) = stack.pop() {
            let over = parts.shape.jet(cell, &x).map(|s| probe.of(&s));
            if over
                .as_ref()
                .is_some_and(|o| o.g.iter().any(|g| !g.may_be_zero()))
            {
                continue;
            }
            if !extended && !inside {
                match parts.region.place(&x) {
                    Place::Outside => continue,
                    Place::Inside => inside = true,
                    Place::Mixed => {}
                }
            }
            if found.budget == 0 {
                let range = match over.as_ref().and_then(|o| o.t.as_ref()) {
                    Some(t) => [t.lo(), t.hi()],
                    None => [f64::NEG_INFINITY, f64::INFINITY],
                };
                found.open.push((face, range));
                continue;
            }
            found.budget -= 1;
            let m = middle(&x);
            let at = parts.shape.jet(cell, &m).map(|s| probe.of(&s));
            if let (Some(over), Some(at)) = (&over, &at) {
                let d: [N; 2] = std::array::from_fn(|c| x[c].minus(&m[c]));
                let missed = (0..2).any(|r| {
                    let all = at.g[r]
                        .plus(&over.j[r][0].times(&d[0]))
                        .plus(&over.j[r][1].times(&d[1]));
                    !all.may_be_zero()
                });
                if missed {
                    continue;
                }
                if let Some((k, contraction)) = krawczyk(&x, &m, at, &over.j) {
                    if (0..2).any(|c| k[c].meet(&x[c]).is_none()) {
                        continue;
                    }
                    let wide: [N; 2] = std::array::from_fn(|c| x[c].widened(0.5 * x[c].radius()));
                    let there = parts.shape.jet(cell, &wide).map(|s| probe.of(&s));
                    if contraction < 0.6
                        && let Some(there) = there
                        && let Some((k, _)) = krawczyk(&wide, &m, at, &there.j)
                        && (0..2).all(|c| {
                            wide[c].lower().below(&k[c].lower())
                                && k[c].upper().below(&wide[c].upper())
                        })
                    {
                        let k = self.shrink(probe, face, cell, k);
                        if (0..2).all(|c| k[c].meet(&x[c]).is_some()) {
                            found.roots.push(Root {
                                face,
                                cell,
                                x: [x[0].ball(), x[1].ball()],
                                k: [k[0].ball(), k[1].ball()],
                            });
                        }
                        continue;
                    }
                }
            }
            // The direction that matters more.
            let weight = |c: usize| {
                let slope = over
                    .as_ref()
                    .map_or(1.0, |o| o.j[0][c].magnitude().max(o.j[1][c].magnitude()));
                slope * x[c].radius()
            };
            let first = usize::from(weight(1) > weight(0));
            let Some(c) = [first, 1 - first]
                .into_iter()
                .find(|c| x[*c].radius() >= size[*c])
            else {
                found.small.push(([x[0].ball(), x[1].ball()], inside));
                continue;
            };
            for half in [x[c].lower().hull(&m[c]), m[c].hull(&x[c].upper())] {
                let mut part = x.clone();
                part[c] = half;
                stack.push((part, inside));
            }
        }
    }

    fn roots(
        &self,
        probe: &Probe,
        extended: bool,
        brep: Option<usize>,
    ) -> (Vec<Root>, Vec<(usize, [f64; 2])>) {
        let mut found = Found::default();
        let mut budgets = [BUDGET, BALL_BUDGET];
        let mut last = usize::MAX;
        for seed in &self.seeds {
            let Kind::Cell(cell) = seed.kind else {
                continue;
            };
            if brep.is_some_and(|b| b != self.faces[seed.face].brep) {
                continue;
            }
            if seed.face != last {
                budgets = [BUDGET, BALL_BUDGET];
                last = seed.face;
            }
            let shape = &self.faces[seed.face].shape;
            let start: [Interval64; 2] = std::array::from_fn(|c| {
                let x = Interval64::of(&seed.x[c]);
                if extended {
                    x.widened(MARGIN * shape.domain[c].length())
                } else {
                    x
                }
            });
            found.budget = budgets[0];
            self.cell_roots(
                probe,
                seed,
                cell,
                vec![(start, false)],
                extended,
                &mut found,
            );
            budgets[0] = found.budget;
            // Nearly tangent: f64 does not tell one root from the other, or from none.
            found.budget = budgets[1];
            let small = std::mem::take(&mut found.small);
            self.cell_roots(probe, seed, cell, small, extended, &mut found);
            budgets[1] = found.budget;
            for (x, _) in std::mem::take(&mut found.small) {
                let t = shape.jet(cell, &x).and_then(|s| probe.of(&s).t);
                let range = t.map_or([f64::NEG_INFINITY, f64::INFINITY], |t| [t.lo(), t.hi()]);
                found.open.push((seed.face, range));
            }
        }
        (found.roots, found.open)
    }
}

/// What a search of a cell found, and what work is left to it.
#[derive(Default)]
struct Found {
    budget: usize,
    roots: Vec<Root>,
    /// Boxes too small to be halved, and whether they lie in the region.
    small: Vec<([Ball; 2], bool)>,
    open: Vec<(usize, [f64; 2])>,
}

/// Boxes are not halved below this share of their cell: in f64, where two roots so near are not told apart, and in balls.
const SMALLEST: f64 = 1e-6;
const SMALLEST_BALL: f64 = 1e-24;

impl Second<'_> {
    /// All hits of a line with the trimmed faces. Milliseconds; more where it is tangent to a face.
    pub fn line(&self, origin: [f64; 3], direction: [f64; 3], kind: LineKind) -> SecondLine {
        let probe = Probe::new(origin, direction);
        let (roots, open) = self.scene.roots(&probe, false, None);
        let mut all = SecondLine {
            hits: Vec::new(),
            open,
        };
        let mut found: Vec<[Ball; 2]> = Vec::new();
        for root in roots {
            let parts = &self.scene.faces[root.face];
            let k = self.scene.shrink(&probe, root.face, root.cell, root.k);
            // Not of this box, or of the formula's continuation beyond its cell.
            let beyond = (0..2).any(|c| {
                let r = &parts.shape.ranges[c][root.cell[c]];
                k[c].below(&r.from) || r.to.below(&k[c])
            });
            if beyond || (0..2).any(|c| k[c].below(&root.x[c]) || root.x[c].below(&k[c])) {
                continue;
            }
            let place = parts.region.place(&k);
            if place == Place::Outside {
                continue;
            }
            let Some(t) = parts.shape.jet(root.cell, &k).and_then(|s| probe.of(&s).t) else {
                continue;
            };
            let before = match kind {
                LineKind::Line => false,
                LineKind::Ray | LineKind::Segment => t.is_negative(),
            };
            if before || kind == LineKind::Segment && Ball::exact(1.0).below(&t) {
                continue;
            }
            // On the common border of two cells: once.
            let known =
                all.hits.iter().zip(&found).any(|(h, uv)| {
                    h.face == root.face && (0..2).all(|c| uv[c].meet(&k[c]).is_some())
                });
            if known {
                continue;
            }
            // At the very end of a ray or segment: not known to count.
            let end = kind != LineKind::Line
                && (t.may_be_zero() || kind == LineKind::Segment && !t.below(&Ball::exact(1.0)));
            let wide: [Interval64; 2] = std::array::from_fn(|c| {
                Interval64::of(&k[c]).widened(MARGIN * parts.shape.domain[c].length())
            });
            all.hits.push(SecondHit {
                face: root.face,
                clear: parts.region.place(&wide) == Place::Inside,
                certain: place == Place::Inside && !end,
                uv: [k[0].middle().lo(), k[1].middle().lo()],
                t,
            });
            found.push(k);
        }
        all.hits.sort_by(|a, b| a.t.lo().total_cmp(&b.t.lo()));
        all
    }

    /// The side of a point: in material of any of the closed BREPs. Tens of milliseconds.
    pub fn inside(&self, point: [f64; 3]) -> SecondSide {
        let mut undecided = false;
        for brep in 0..self.scene.closed.len() {
            match self.inside_of(brep, point) {
                SecondSide::Inside => return SecondSide::Inside,
                SecondSide::Outside => {}
                SecondSide::Undecided => undecided = true,
            }
        }
        if undecided {
            SecondSide::Undecided
        } else {
            SecondSide::Outside
        }
    }

    fn inside_of(&self, brep: usize, point: [f64; 3]) -> SecondSide {
        if !self.scene.closed[brep] {
            return SecondSide::Outside;
        }
        let mut votes = [0, 0];
        for direction in DIRECTIONS {
            let probe = Probe::new(point, direction);
            let Some([forward, backward]) = self.parities(brep, &probe) else {
                continue;
            };
            if forward != backward {
                continue;
            }
            votes[usize::from(forward)] += 1;
            if votes[0] > 0 && votes[1] > 0 {
                return SecondSide::Undecided;
            }
            if votes[usize::from(forward)] == 2 {
                return if forward {
                    SecondSide::Inside
                } else {
                    SecondSide::Outside
                };
            }
        }
        SecondSide::Undecided
    }

    /// Whether a line has an odd number of crossings for t > 0 and for t < 0; `None` if it does not count.
    fn parities(&self, brep: usize, probe: &Probe) -> Option<[bool; 2]> {
        let (roots, open) = self.scene.roots(probe, true, Some(brep));
        if !open.is_empty() {
            return None;
        }
        let mut odd = [false; 2];
        let mut found: Vec<(usize, [Ball; 2])> = Vec::new();
        for root in roots {
            let parts = &self.scene.faces[root.face];
            let k = self.scene.shrink(probe, root.face, root.cell, root.k);
            if (0..2).any(|c| k[c].below(&root.x[c]) || root.x[c].below(&k[c])) {
                continue;
            }
            // Beyond its own cell, but inside the domain, it is another cell's root.
            let range = |c: usize| {
                let r = &parts.shape.ranges[c][root.cell[c]];
                (r.from.clone(), r.to.clone())
            };
            let inner = (0..2).any(|c| {
                let (from, to) = range(c);
                let d = parts.shape.domain[c];
                let below = k[c].below(&from) && Ball::exact(d.start).below(&from);
                let above = to.below(&k[c]) && to.below(&Ball::exact(d.end));
                below || above
            });
            if inner {
                continue;
            }
            if found
                .iter()
                .any(|(f, uv)| *f == root.face && (0..2).all(|c| uv[c].meet(&k[c]).is_some()))
            {
                continue;
            }
            let wide: [Interval64; 2] = std::array::from_fn(|c| {
                Interval64::of(&k[c]).widened(MARGIN * parts.shape.domain[c].length())
            });
            match parts.region.place(&wide) {
                Place::Inside => {
                    let t = probe.of(&parts.shape.jet(root.cell, &k)?).t?;
                    if t.may_be_zero() {
                        return None;
                    }
                    let side = usize::from(t.is_negative());
                    odd[side] = !odd[side];
                }
                Place::Outside if parts.region.in_domain(&wide).is_some() => {}
                _ => return None,
            }
            found.push((root.face, k));
        }
        Some(odd)
    }
}

/// Without pattern; no part has edges or planes along them.
const DIRECTIONS: [[f64; 3]; 8] = [
    [0.6132, 0.2871, 0.7359],
    [-0.3317, 0.8123, 0.4796],
    [0.1249, -0.5381, 0.8336],
    [0.9016, 0.3947, -0.1768],
    [0.4477, -0.8689, -0.2113],
    [-0.7293, -0.1574, 0.6658],
    [0.0731, 0.9718, -0.2243],
    [0.5519, 0.5023, 0.6657],
];
