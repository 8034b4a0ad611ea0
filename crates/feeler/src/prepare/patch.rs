//! Rational Bezier patches of a face's surface, with bounds.

pub(super) mod boxes;

use super::circle::{Span, Spans, degree, normalized, span_count};
use super::compose::{compose, compose_bytes};
use super::spline::{BezierCurve, Blossom, curve_pieces, piece_count};
use super::turned::Turned;
use super::{Box3, Homogeneous, Net, ParamMap, Products};
use crate::numeric::bernstein::Bidegree;
use crate::numeric::{Ball, Dd, Interval, Real};
use crate::nurbs::{Curve3, KnotVector, NurbsSurface, Plane, Revolution, Surface};
use nalgebra::{Point3, Vector3};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

/// A rational Bezier patch on the unit square, and the native parameters it covers.
#[derive(Clone, Debug)]
pub struct Patch<T> {
    /// The surface over the unit square.
    pub net: Net<T>,
    /// Native parameters, u and v.
    pub maps: [ParamMap; 2],
    /// How it is made of an angle and a profile, where it is of a revolution.
    pub(crate) turned: Option<Box<Turned<T>>>,
}

impl<T: Real> Patch<T> {
    /// The homogeneous Bezier points, relative to the net's origin, of the image of a curve, which is homogeneous `(s w, t w, w)` in
    /// the local square; by whichever way gives the lower degree. `None` where that is too high.
    pub(crate) fn compose(&self, curve: &[Homogeneous<T, 3>]) -> Option<Vec<Homogeneous<T, 4>>> {
        let degree = self.composed_degree(curve);
        if degree > LOW
            && let Some(turned) = &self.turned
            && let Some(points) = turned.compose(curve, &self.net.origin)
            && points.len() <= degree
        {
            return Some(points);
        }
        compose(&self.net, curve)
    }

    /// See [`Products`]: those of the net, of a lower degree where it is turned.
    pub(super) fn products(&self) -> Products<T> {
        let turned = self.turned.as_ref().and_then(|t| t.products(&self.net));
        turned.unwrap_or_else(|| self.net.products())
    }

    /// Bytes that it takes, as large as its lists were reserved.
    pub(super) fn bytes(&self) -> usize {
        // (The piece of the profile is its source's.)
        let turned = self.turned.as_ref().map_or(0, |t| size_of_val(&**t));
        size_of::<Self>() + self.net.bytes() + turned
    }

    /// Bytes that the image of a curve of so many points takes at most while it is made: composed, or one of the patch's own curves.
    pub(super) fn work_bytes(&self, points: usize) -> usize {
        let k = points - 1;
        let degree = self.net.degree;
        let whole = compose_bytes::<T>(degree, k);
        let turned = self.turned.as_ref();
        let turned = turned.map_or(0, |t| t.compose_bytes(k));
        let line = Bidegree {
            u: degree.u.max(degree.v),
            v: 0,
        };
        // A row of the net, two copies of it, and the line with its numbers in f64.
        let own = (line.u + 1) * (4 * size_of::<Homogeneous<T, 4>>() + size_of::<[f64; 4]>());
        let of_line = own + compose_bytes::<T>(line, k);
        whole.max(turned).max(of_line) + points * size_of::<Homogeneous<T, 4>>()
    }

    fn composed_degree(&self, curve: &[Homogeneous<T, 3>]) -> usize {
        (curve.len() - 1) * (self.net.degree.u + self.net.degree.v)
    }

    /// Whether the image of a curve is better composed from shorter parts of it, in an arithmetic of this unit.
    pub(crate) fn wants_parts(&self, curve: &[Homogeneous<T, 3>], unit: f64) -> bool {
        let turned = self.turned.as_ref();
        self.composed_degree(curve) > LOW && turned.is_some_and(|t| !t.composes(curve, unit))
    }
}

/// Degrees up to this are composed as they are.
const LOW: usize = 20;
/// How often what [wants parts](Patch::wants_parts) is halved.
pub(super) const COMPOSE_HALVINGS: u32 = 6;

/// The patches of a surface, in order of u, then v: a grid.
pub(crate) fn surface_patches<T: Real>(surface: &Surface) -> Vec<Patch<T>> {
    match surface {
        Surface::Nurbs(s) => nurbs_patches(s),
        Surface::Plane(s) => vec![plane_patch(s)],
        Surface::Revolution(_) | Surface::Sum(_) => {
            let source = Source::new(surface);
            let [u, v] = source.counts();
            let all = (0..u).flat_map(|i| (0..v).map(move |j| [i, j]));
            all.map(|at| source.patch(at, true)).collect()
        }
    }
}

/// How many patches a surface has along u and v: nothing of them is made.
pub(super) fn patch_counts(surface: &Surface) -> [usize; 2] {
    let pieces = |curve: &Curve3| {
        let domain = curve.domain();
        piece_count(curve, domain.start, domain.end).pieces
    };
    match surface {
        Surface::Nurbs(s) => [s.knots_u(), s.knots_v()].map(|k| k.spans().count()),
        Surface::Plane(_) => [1, 1],
        Surface::Revolution(s) => {
            let domain = s.angle_domain;
            let turns = span_count(s.angle, domain, domain.start, domain.end);
            let pieces = pieces(&s.profile);
            if s.transposed {
                [pieces, turns]
            } else {
                [turns, pieces]
            }
        }
        Surface::Sum(s) => [pieces(&s.first), pieces(&s.second)],
    }
}

/// What the patches of a surface are made of, each by itself.
#[derive(Debug)]
pub(crate) enum Source<T> {
    Plane(Box<Plane>),
    Nurbs {
        surface: Box<NurbsSurface>,
        spans: [Vec<KnotSpan>; 2],
    },
    Revolution(Box<Turns<T>>),
    Sum {
        base: Vector3<f64>,
        pieces: [Vec<BezierCurve<T, 4>>; 2],
    },
}

/// The spans of the angle and the pieces of the profile of a surface of revolution.
#[derive(Debug)]
pub(crate) struct Turns<T> {
    transposed: bool,
    origin: Point3<f64>,
    axis: [Ball<T>; 3],
    turns: Spans,
    /// Those that patches have been made of.
    made: Box<[OnceLock<Box<Span<T>>>]>,
    /// Patches made of them share them.
    profile: Box<[Arc<BezierCurve<T, 4>>]>,
}

impl<T: Real> Source<T> {
    fn new(surface: &Surface) -> Self {
        let pieces = |curve: &Curve3| {
            let mut out = Vec::new();
            let domain = curve.domain();
            curve_pieces(curve, domain.start, domain.end, &mut out);
            out
        };
        match surface {
            Surface::Plane(s) => Self::Plane(Box::new(s.clone())),
            Surface::Nurbs(s) => Self::Nurbs {
                surface: Box::new(s.clone()),
                spans: [s.knots_u(), s.knots_v()].map(|k| k.spans().collect()),
            },
            Surface::Revolution(s) => {
                let domain = s.angle_domain;
                let turns = Spans::new(s.angle, domain, domain.start, domain.end);
                Self::Revolution(Box::new(Turns {
                    transposed: s.transposed,
                    origin: s.origin,
                    axis: unit_axis(s),
                    made: (0..turns.len()).map(|_| OnceLock::new()).collect(),
                    turns,
                    profile: pieces(&s.profile).into_iter().map(Arc::new).collect(),
                }))
            }
            Surface::Sum(s) => Self::Sum {
                base: s.base,
                pieces: [pieces(&s.first), pieces(&s.second)],
            },
        }
    }

    /// Native parameters of the patches along u and v.
    fn maps(&self) -> [Vec<ParamMap>; 2] {
        let of_pieces =
            |pieces: &[BezierCurve<T, 4>]| pieces.iter().map(|p| p.map.clone()).collect();
        match self {
            Self::Plane(s) => [0, 1].map(|c| vec![map(s.domain[c])]),
            Self::Nurbs { spans, .. } => {
                let map = |&(_, start, end): &KnotSpan| ParamMap::new(start, end);
                [0, 1].map(|c| spans[c].iter().map(map).collect())
            }
            Self::Revolution(s) => {
                let turns = (0..s.turns.len()).map(|k| map(s.turns.range(k))).collect();
                let profile = s.profile.iter().map(|p| p.map.clone()).collect();
                if s.transposed {
                    [profile, turns]
                } else {
                    [turns, profile]
                }
            }
            Self::Sum { pieces, .. } => [0, 1].map(|c| of_pieces(&pieces[c])),
        }
    }

    /// Those of one patch.
    fn maps_of(&self, [i, j]: [usize; 2]) -> [ParamMap; 2] {
        match self {
            Self::Plane(s) => s.domain.map(map),
            Self::Nurbs { spans, .. } => {
                let map = |(_, start, end): KnotSpan| ParamMap::new(start, end);
                [map(spans[0][i]), map(spans[1][j])]
            }
            Self::Revolution(s) if s.transposed => {
                [s.profile[i].map.clone(), map(s.turns.range(j))]
            }
            Self::Revolution(s) => [map(s.turns.range(i)), s.profile[j].map.clone()],
            Self::Sum { pieces, .. } => [pieces[0][i].map.clone(), pieces[1][j].map.clone()],
        }
    }

    fn counts(&self) -> [usize; 2] {
        match self {
            Self::Plane(_) => [1, 1],
            Self::Nurbs { spans, .. } => [0, 1].map(|c| spans[c].len()),
            Self::Revolution(s) if s.transposed => [s.profile.len(), s.turns.len()],
            Self::Revolution(s) => [s.turns.len(), s.profile.len()],
            Self::Sum { pieces, .. } => [0, 1].map(|c| pieces[c].len()),
        }
    }

    /// One of the [patches](surface_patches), the same to the last bit; `keep`: whether others will be made of the same turn.
    fn patch(&self, [i, j]: [usize; 2], keep: bool) -> Patch<T> {
        match self {
            Self::Plane(s) => plane_patch(s),
            Self::Nurbs { surface, spans } => nurbs_patch(surface, [spans[0][i], spans[1][j]]),
            Self::Revolution(s) if s.transposed => s.patch(j, i, keep),
            Self::Revolution(s) => s.patch(i, j, keep),
            Self::Sum { base, pieces } => sum_patch(base, [&pieces[0][i], &pieces[1][j]]),
        }
    }

    /// Bytes that one of the patches takes at most, while it is made.
    fn bytes_to_make(&self, [i, j]: [usize; 2]) -> usize {
        let point = size_of::<Homogeneous<T, 4>>();
        let net = |points: usize| points * (point + size_of::<[f64; 4]>());
        let beside = match self {
            Self::Plane(_) => net(4),
            Self::Nurbs { surface, .. } => {
                let [p, q] = [surface.knots_u(), surface.knots_v()].map(KnotVector::degree);
                // The columns, and the weights and the points of a span along each.
                let span = |p: usize| 2 * p * (p + 1) * size_of::<Ball<T>>() + 3 * (p + 1) * point;
                let column = (p + 1) * point + size_of::<Vec<()>>();
                net((p + 1) * (q + 1)) + (q + 1) * column + span(p) + span(q)
            }
            Self::Revolution(s) => {
                let piece = if s.transposed { i } else { j };
                let points = s.profile[piece].points.len();
                let own = size_of::<Turned<T>>();
                let turn = degree::<T>() + 1;
                let of_turn = size_of::<Span<T>>() + 2 * turn * size_of::<Ball<T>>();
                net(turn * points) + own + of_turn
            }
            Self::Sum { pieces, .. } => net(pieces[0][i].points.len() * pieces[1][j].points.len()),
        };
        size_of::<Kept<T>>() + beside
    }

    /// Bytes of its lists.
    fn bytes(&self) -> usize {
        let of_pieces = |pieces: &Vec<BezierCurve<T, 4>>| {
            let own = pieces.iter().map(BezierCurve::bytes);
            pieces.capacity() * size_of::<BezierCurve<T, 4>>() + own.sum::<usize>()
        };
        match self {
            Self::Plane(_) => size_of::<Plane>(),
            Self::Nurbs { surface, spans } => {
                // (Its lists are the BREP's.)
                let spans: usize = spans.iter().map(Vec::capacity).sum();
                size_of_val(&**surface) + spans * size_of::<KnotSpan>()
            }
            Self::Revolution(s) => {
                let made = s.made.iter().filter_map(OnceLock::get);
                let of_turn = |t: &Span<T>| (t.cos.len() + t.sin.len()) * size_of::<Ball<T>>();
                let turns = made.map(|t| size_of::<Span<T>>() + of_turn(t));
                let profile = s.profile.iter().map(|p| size_of_val(&**p) + p.bytes());
                size_of_val(&**s)
                    + size_of_val(&*s.made)
                    + turns.sum::<usize>()
                    + size_of_val(&*s.profile)
                    + profile.sum::<usize>()
            }
            Self::Sum { pieces, .. } => pieces.iter().map(of_pieces).sum(),
        }
    }
}

/// The direction of the axis.
fn unit_axis<T: Real>(s: &Revolution) -> [Ball<T>; 3] {
    let axis: [Ball<Dd>; 3] = normalized(&std::array::from_fn(|c| Ball::exact(s.axis[c])));
    axis.map(|b| Ball::from_dd(b.mid, b.rad))
}

fn map(range: Interval) -> ParamMap {
    ParamMap::new(range.start, range.end)
}

impl<T: Real> Turns<T> {
    /// `O + along + cos a r + sin a (axis x r)` for each point of the profile, split into its part along the
    /// axis and its part `r` across it: linear in homogeneous points, so it maps control points.
    fn patch(&self, turn: usize, piece: usize, keep: bool) -> Patch<T> {
        let make = || Box::new(self.turns.span(turn));
        let own;
        let turn = match self.made[turn].get() {
            Some(made) => made,
            None if keep => self.made[turn].get_or_init(make),
            None => {
                own = make();
                &own
            }
        };
        let piece = &self.profile[piece];
        let (origin, axis) = (&self.origin, &self.axis);
        let point = |i: usize, p: &Homogeneous<T, 4>| -> Homogeneous<T, 4> {
            let q: [Ball<T>; 3] = std::array::from_fn(|c| p[c] - p[3] * Ball::exact(origin[c]));
            let height = q[0] * axis[0] + q[1] * axis[1] + q[2] * axis[2];
            std::array::from_fn(|c| {
                if c == 3 {
                    return p[3];
                }
                let (j, k) = ((c + 1) % 3, (c + 2) % 3);
                let along = height * axis[c];
                let across = q[c] - along;
                let turned = axis[j] * q[k] - axis[k] * q[j];
                p[3] * Ball::exact(origin[c]) + along + turn.cos[i] * across + turn.sin[i] * turned
            })
        };
        let points = &piece.points;
        let count = turn.cos.len();
        let mut net = Vec::with_capacity(count * points.len());
        let (degree, maps) = if self.transposed {
            for p in points {
                net.extend((0..count).map(|i| point(i, p)));
            }
            (
                [points.len() - 1, count - 1],
                [piece.map.clone(), map(turn.range)],
            )
        } else {
            for i in 0..count {
                net.extend(points.iter().map(|p| point(i, p)));
            }
            (
                [count - 1, points.len() - 1],
                [map(turn.range), piece.map.clone()],
            )
        };
        let [u, v] = degree;
        Patch {
            net: Net::centered(Bidegree { u, v }, net),
            maps,
            turned: Some(Box::new(Turned {
                transposed: self.transposed,
                angle: turn.angle,
                origin: origin.coords.into(),
                axis: *axis,
                profile: Arc::clone(piece),
            })),
        }
    }
}

/// `base + X_1 / w_1 + X_2 / w_2`: a rational patch with weights `w_1 w_2`.
fn sum_patch<T: Real>(base: &Vector3<f64>, [a, b]: [&BezierCurve<T, 4>; 2]) -> Patch<T> {
    let mut net = Vec::with_capacity(a.points.len() * b.points.len());
    for p in &a.points {
        for q in &b.points {
            let w = p[3] * q[3];
            net.push(std::array::from_fn(|c| {
                if c == 3 {
                    w
                } else {
                    p[c] * q[3] + q[c] * p[3] + Ball::exact(base[c]) * w
                }
            }));
        }
    }
    let degree = Bidegree {
        u: a.points.len() - 1,
        v: b.points.len() - 1,
    };
    Patch {
        net: Net::centered(degree, net),
        maps: [a.map.clone(), b.map.clone()],
        turned: None,
    }
}

fn plane_patch<T: Real>(plane: &Plane) -> Patch<T> {
    let mut net = Vec::with_capacity(4);
    for a in [plane.extents[0].start, plane.extents[0].end] {
        for b in [plane.extents[1].start, plane.extents[1].end] {
            net.push(std::array::from_fn(|c| {
                if c == 3 {
                    return Ball::ONE;
                }
                Ball::exact(plane.origin[c])
                    + Ball::exact(plane.x[c]) * Ball::exact(a)
                    + Ball::exact(plane.y[c]) * Ball::exact(b)
            }));
        }
    }
    Patch {
        net: Net::centered(Bidegree { u: 1, v: 1 }, net),
        maps: plane.domain.map(map),
        turned: None,
    }
}

fn nurbs_patches<T: Real>(surface: &NurbsSurface) -> Vec<Patch<T>> {
    let (ku, kv) = (surface.knots_u(), surface.knots_v());
    let along_v: Vec<_> = kv.spans().map(|s| Span1::new(kv, s)).collect();
    let mut patches = Vec::new();
    for span in ku.spans() {
        let along_u = Span1::new(ku, span);
        let columns: Vec<_> = (0..kv.control_points())
            .map(|j| column(surface, &along_u, j))
            .collect();
        let made = along_v
            .iter()
            .map(|along_v| of_columns(surface, [&along_u, along_v], |i, j| columns[j][i]));
        patches.extend(made);
    }
    patches
}

/// The patch over two spans: one of these, the same to the last bit.
fn nurbs_patch<T: Real>(surface: &NurbsSurface, [u, v]: [KnotSpan; 2]) -> Patch<T> {
    let along_u = Span1::new(surface.knots_u(), u);
    let along_v = Span1::new(surface.knots_v(), v);
    let first = v.0 - surface.knots_v().degree();
    let columns: Vec<_> = (first..=v.0)
        .map(|j| column(surface, &along_u, j))
        .collect();
    of_columns(surface, [&along_u, &along_v], |i, j| columns[j - first][i])
}

/// Index, start and end.
type KnotSpan = (usize, f64, f64);

/// A span of a knot vector.
struct Span1<T> {
    blossom: Blossom<T>,
    map: ParamMap,
}

impl<T: Real> Span1<T> {
    fn new(knots: &KnotVector, (index, start, end): KnotSpan) -> Self {
        Self {
            blossom: Blossom::new(knots, index, start, end),
            map: ParamMap::new(start, end),
        }
    }
}

/// Column `j` of a net, in Bezier form along u.
fn column<T: Real>(surface: &NurbsSurface, along_u: &Span1<T>, j: usize) -> Vec<Homogeneous<T, 4>> {
    let count_v = surface.knots_v().control_points();
    along_u.blossom.apply(|i| {
        let p = &surface.control_net()[i * count_v + j];
        std::array::from_fn(|c| Ball::exact(p[c]))
    })
}

/// A patch from columns in Bezier form along u.
fn of_columns<T: Real>(
    surface: &NurbsSurface,
    [along_u, along_v]: [&Span1<T>; 2],
    columns: impl Fn(usize, usize) -> Homogeneous<T, 4>,
) -> Patch<T> {
    let degree = Bidegree {
        u: surface.knots_u().degree(),
        v: surface.knots_v().degree(),
    };
    let mut net = Vec::with_capacity(degree.count());
    for i in 0..=degree.u {
        net.extend(along_v.blossom.apply(|j| columns(i, j)));
    }
    // Pieces are affine combinations of the control points: where all weights are 1, so are those of the pieces, exactly.
    if surface.control_net().iter().all(|p| p[3] == 1.0) {
        net.iter_mut()
            .for_each(|p: &mut Homogeneous<T, 4>| p[3] = Ball::ONE);
    }
    Patch {
        net: Net::centered(degree, net),
        maps: [along_u.map.clone(), along_v.map.clone()],
        turned: None,
    }
}

/// A patch, and what is made of it when it is first asked for.
#[derive(Debug)]
struct Kept<T> {
    patch: Patch<T>,
    products: OnceLock<Box<Products<T>>>,
    speeds: OnceLock<[f64; 2]>,
}

/// The patches of a surface in order of u, then v: a grid. Each is made when it is first asked for.
#[derive(Debug)]
pub(crate) struct Patches<T> {
    source: Source<T>,
    count_v: usize,
    slots: Box<[OnceLock<Box<Kept<T>>>]>,
    /// Bytes of those that are made, but for what is made of them.
    made: AtomicUsize,
}

/// A patch that is kept, or one that is not.
#[derive(Debug)]
pub(crate) enum Lent<'a, T> {
    Kept(&'a Patch<T>),
    Own(Box<Patch<T>>),
}

impl<T> std::ops::Deref for Lent<'_, T> {
    type Target = Patch<T>;

    fn deref(&self) -> &Patch<T> {
        match self {
            Self::Kept(patch) => patch,
            Self::Own(patch) => patch,
        }
    }
}

impl<T> Lent<'_, T> {
    pub(super) fn is_kept(&self) -> bool {
        matches!(self, Self::Kept(_))
    }
}

impl<T: Real> Patches<T> {
    /// Patches that are made when they are needed.
    pub(super) fn on_demand(surface: &Surface) -> Self {
        let source = Source::new(surface);
        let [count_u, count_v] = source.counts();
        Self {
            source,
            count_v,
            slots: (0..count_u * count_v).map(|_| OnceLock::new()).collect(),
            made: AtomicUsize::new(0),
        }
    }

    /// The same with all of them made.
    fn all(surface: &Surface) -> Self {
        let mut patches = Self::on_demand(surface);
        let made = surface_patches(surface).into_iter();
        patches.slots = made.map(|p| OnceLock::from(patches.keep(p))).collect();
        patches
    }

    fn keep(&self, patch: Patch<T>) -> Box<Kept<T>> {
        let bytes = size_of::<Kept<T>>() - size_of::<Patch<T>>() + patch.bytes();
        self.made.fetch_add(bytes, Ordering::Relaxed);
        Box::new(Kept {
            patch,
            products: OnceLock::new(),
            speeds: OnceLock::new(),
        })
    }

    fn kept(&self, index: usize) -> &Kept<T> {
        self.slots[index].get_or_init(|| self.keep(self.source.patch(self.place(index), true)))
    }

    /// The row and the column of a patch.
    fn place(&self, index: usize) -> [usize; 2] {
        [index / self.count_v, index % self.count_v]
    }

    pub(crate) fn len(&self) -> usize {
        self.slots.len()
    }

    /// All of them.
    pub(super) fn make_all(&self) -> impl Iterator<Item = &Patch<T>> {
        (0..self.len()).map(|i| &self[i])
    }

    /// Whether a patch takes far more than what it is made of.
    pub(super) fn are_large(&self) -> bool {
        matches!(self.source, Source::Revolution(_) | Source::Sum { .. })
    }

    /// A patch, made for this once where it has not been made: for those who look at all of them, once.
    pub(crate) fn lent(&self, index: usize) -> Lent<'_, T> {
        match self.slots[index].get() {
            Some(kept) => Lent::Kept(&kept.patch),
            None => {
                // In f64 all are looked at, row by row; beyond, some.
                let keep = T::UNIT >= f64::UNIT;
                Lent::Own(Box::new(self.source.patch(self.place(index), keep)))
            }
        }
    }

    /// Native parameters of a patch, which need not be made for this.
    pub(crate) fn maps_of(&self, index: usize) -> [ParamMap; 2] {
        self.source.maps_of(self.place(index))
    }

    /// The first patch that holds a point, given in native parameters.
    pub(crate) fn holding(&self, uv: [f64; 2]) -> Option<usize> {
        (0..self.len()).find(|index| {
            let maps = self.maps_of(*index);
            (0..2).all(|k| maps[k].start <= uv[k] && uv[k] <= maps[k].end)
        })
    }

    /// See [`Patch::wants_parts`].
    pub(super) fn wants_parts(
        &self,
        index: usize,
        curve: impl FnOnce() -> Vec<Homogeneous<T, 3>>,
        unit: f64,
    ) -> bool {
        // Of no other surface are the patches turned.
        let turned = matches!(self.source, Source::Revolution(_));
        turned && self.lent(index).wants_parts(&curve(), unit)
    }

    /// See [`Net::products`].
    pub(super) fn products(&self, index: usize) -> &Products<T> {
        let kept = self.kept(index);
        let make = || Box::new(kept.patch.products());
        kept.products.get_or_init(make)
    }

    /// See [`Net::speeds`].
    pub(super) fn speeds(&self, index: usize) -> [f64; 2] {
        let kept = self.kept(index);
        *kept.speeds.get_or_init(|| kept.patch.net.speeds())
    }

    /// Native parameters of the patches along u and v.
    pub(super) fn maps(&self) -> [Vec<ParamMap>; 2] {
        self.source.maps()
    }

    /// Bytes of its lists, of the patches that have been made, and of their products.
    pub(super) fn bytes(&self) -> usize {
        let made = self.slots.iter().filter_map(OnceLock::get);
        let made = made.map(|kept| {
            let products = kept.products.get();
            size_of::<Kept<T>>() - size_of::<Patch<T>>()
                + kept.patch.bytes()
                + products.map_or(0, |p| p.bytes())
        });
        size_of_val(&*self.slots) + self.source.bytes() + made.sum::<usize>()
    }

    /// Bytes that it takes to make a patch; none of one that is there.
    pub(super) fn bytes_to_make(&self, index: usize) -> usize {
        match self.slots[index].get() {
            Some(_) => 0,
            None => self.source.bytes_to_make(self.place(index)),
        }
    }

    /// Bytes of the patches that were made.
    pub(super) fn made(&self) -> usize {
        self.made.load(Ordering::Relaxed)
    }
}

impl Patches<f64> {
    /// Those of a face, and a box around each. The large ones are made when they are needed: of these only the boxes are there from the start.
    /// Those of a NURBS surface are made row by row, for less than one by one.
    pub(super) fn with_boxes(surface: &Surface) -> (Self, Box<[Option<Box3>]>) {
        let patches = match surface {
            Surface::Nurbs(_) | Surface::Plane(_) => Self::all(surface),
            Surface::Revolution(_) | Surface::Sum(_) => Self::on_demand(surface),
        };
        let boxes = boxes::patch_boxes(&patches).into();
        (patches, boxes)
    }

    /// A box around what a patch has over a box of native parameters; `None` where none is known. Of surfaces whose patches are made when they are needed none is made
    /// for it: there it may be one around what is next to the patch, too.
    pub(super) fn box_over(
        &self,
        surface: &Surface,
        index: usize,
        range: &[[f64; 2]; 2],
    ) -> Option<Box3> {
        if self.are_large() {
            return boxes::box_over(surface, range);
        }
        let Patch { net, maps, .. } = &self[index];
        net.box_over([0, 1].map(|k| {
            let ends = range[k].map(|x| maps[k].to_local(Ball::<f64>::exact(x)));
            [ends[0].lower(), ends[1].upper()].map(|x| x.clamp(0.0, 1.0))
        }))
    }
}

impl<T: Real> std::ops::Index<usize> for Patches<T> {
    type Output = Patch<T>;

    fn index(&self, index: usize) -> &Patch<T> {
        &self.kept(index).patch
    }
}

/// The coordinate that all points of a surface have in common, exactly, and its value: a plane across an axis.
pub(crate) fn level(surface: &Surface) -> Option<(usize, f64)> {
    match surface {
        Surface::Plane(s) => (0..3)
            .find(|&c| s.x[c] == 0.0 && s.y[c] == 0.0)
            .map(|c| (c, s.origin[c])),
        Surface::Nurbs(s) => {
            let net = s.control_net();
            let first = net.first()?;
            (0..3).find_map(|c| {
                let at = first[c] / first[3];
                let on = |p: &nalgebra::Vector4<f64>| Dd::product(at, p[3]) == Dd::from(p[c]);
                net.iter().all(on).then_some((c, at))
            })
        }
        Surface::Revolution(_) | Surface::Sum(_) => None,
    }
}

/// Whether a surface's two borders across u (or v) are the same curve with the same parameter, exactly, so that one may go on over its seam: a
/// clamped NURBS surface whose first and last control points there are equal.
pub(crate) fn meets_itself(surface: &Surface, along_u: bool) -> bool {
    let Surface::Nurbs(s) = surface else {
        return false;
    };
    let knots = if along_u { s.knots_u() } else { s.knots_v() };
    let [count_u, count_v] = s.counts();
    let net = s.control_net();
    let same = if along_u {
        net[..count_v] == net[(count_u - 1) * count_v..]
    } else {
        net.chunks_exact(count_v)
            .all(|row| row[0] == row[count_v - 1])
    };
    knots.is_clamped() && same
}

#[cfg(test)]
mod tests {
    use super::super::spline::{PieceCount, curve_piece, piece_places};
    use super::*;
    use crate::nurbs::{Arc, Line, NurbsCurve, NurbsSurface, PolyCurve, Polyline, Revolution, Sum};
    use std::f64::consts::TAU;

    fn interval(a: f64, b: f64) -> Interval {
        Interval::new(a, b).unwrap()
    }

    fn line(t: [f64; 2]) -> Curve3 {
        let ends = [Point3::new(2.0, 0.0, 0.0), Point3::new(3.0, 0.0, 4.0)];
        Curve3::Line(Line::new(ends[0], ends[1], interval(t[0], t[1])).unwrap())
    }

    fn arc(angle: [f64; 2], domain: [f64; 2]) -> Curve3 {
        let arc = Arc {
            center: Point3::new(5.0, 0.0, 0.0),
            x: Vector3::x(),
            y: Vector3::z(),
            z: -Vector3::y(),
            radius: 1.5,
            angle: interval(angle[0], angle[1]),
            domain: interval(domain[0], domain[1]),
        };
        Curve3::Arc(Arc::new(arc).unwrap())
    }

    /// A curve of each kind; spans of no length, whole and several turns, and segments that are poly-lines and arcs.
    fn curves() -> Vec<Curve3> {
        let points = (0..9).map(|k| {
            let x = f64::from(k);
            Point3::new(3.0 + x * x / 16.0, 0.0, x)
        });
        let points: Vec<_> = points.collect();
        let homogeneous = points.iter().map(|p| p.coords.push(1.0)).collect();
        let knots = vec![
            0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 2.5, 3.0, 3.0, 3.0, 3.0,
        ];
        let nurbs = NurbsCurve::new(3, homogeneous, knots).unwrap();
        let params = (0..9).map(|k| f64::from(k) * 0.75).collect();
        let polyline = Curve3::Polyline(Polyline::new(points, params).unwrap());
        let own = [line([0.0, 1.0]), arc([0.0, 3.0], [0.0, 3.0]), polyline];
        let poly = PolyCurve::new(own.to_vec(), vec![0.0, 0.5, 1.5, 7.0]).unwrap();
        let mut all = vec![
            line([-1.0, 2.0]),
            arc([0.0, TAU], [0.0, TAU]),
            arc([-1.0, 0.25], [3.0, 4.0]),
            Curve3::Nurbs(nurbs),
            Curve3::Poly(poly),
        ];
        all.extend(own);
        all
    }

    fn surfaces() -> Vec<Surface> {
        let mut all = Vec::new();
        let plane = Plane {
            origin: Point3::origin(),
            x: Vector3::x(),
            y: Vector3::y(),
            domain: [interval(0.0, 1.0), interval(-2.0, 2.0)],
            extents: [interval(0.0, 1.0), interval(0.0, 8.0)],
        };
        all.push(Surface::Plane(plane));
        let net = (0..20).map(|k| {
            let (i, j) = (f64::from(k / 5), f64::from(k % 5));
            Vector3::new(i, j, i * j).push(1.0)
        });
        let knots = [
            vec![0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0],
            vec![0.0, 0.0, 1.0, 1.5, 1.75, 2.0, 2.0],
        ];
        let [u, v] = knots;
        let net = net.collect();
        let nurbs = NurbsSurface::new([2, 1], [4, 5], net, [u, v]).unwrap();
        all.push(Surface::Nurbs(nurbs));
        for profile in curves() {
            for (angle, domain) in [
                ([0.0, TAU], [0.0, TAU]),
                ([0.5, 0.625], [0.0, 1.0]),
                ([-1.0, 40.0], [0.0, 7.0]),
            ] {
                for transposed in [false, true] {
                    let revolution = Revolution {
                        origin: Point3::origin(),
                        axis: Vector3::z(),
                        profile: profile.clone(),
                        angle: interval(angle[0], angle[1]),
                        angle_domain: interval(domain[0], domain[1]),
                        transposed,
                    };
                    all.push(Surface::Revolution(revolution));
                }
            }
            for second in curves() {
                let sum = Sum {
                    base: Vector3::new(1.0, 2.0, 3.0),
                    first: profile.clone(),
                    second,
                };
                all.push(Surface::Sum(sum));
            }
        }
        all
    }

    /// Counted without making any, there are as many patches as are made, and each that is made by itself is the same.
    #[test]
    fn patches_are_as_many_as_counted() {
        for surface in surfaces() {
            let all = surface_patches::<f64>(&surface);
            let [u, v] = patch_counts(&surface);
            assert_eq!(u * v, all.len(), "{surface:?}");
            let alone = Patches::<f64>::on_demand(&surface);
            assert_eq!(alone.len(), all.len());
            for k in [0, all.len() / 2, all.len() - 1] {
                assert_eq!(format!("{:?}", alone[k]), format!("{:?}", all[k]));
            }
            let maps = alone.maps();
            let maps_of = |k| alone.maps_of(k);
            assert_eq!(maps.each_ref().map(Vec::len), [u, v]);
            for k in 0..all.len() {
                assert_eq!(maps_of(k), all[k].maps);
                let own = [&maps[0][k / v], &maps[1][k % v]];
                assert_eq!(own, all[k].maps.each_ref());
            }
        }
    }

    /// The same of the pieces of curves, and of parts of these; each by itself is the same, too.
    #[test]
    fn pieces_are_as_many_as_counted() {
        for curve in curves() {
            let domain = curve.domain();
            for [a, b] in [[0.0, 1.0], [0.0, 0.3], [0.25, 0.26], [0.5, 1.0]] {
                let (from, to) = (domain.lerp(a), domain.lerp(b));
                let mut pieces: Vec<BezierCurve<f64, 4>> = Vec::new();
                curve_pieces(&curve, from, to, &mut pieces);
                let made = PieceCount {
                    pieces: pieces.len(),
                    points: pieces.iter().map(|p| p.points.len()).sum(),
                };
                assert_eq!(piece_count(&curve, from, to), made, "{curve:?} {a} {b}");
                let mut places = Vec::new();
                piece_places(&curve, from, to, &mut places);
                let alone = places.into_iter();
                let alone: Option<Vec<BezierCurve<f64, 4>>> =
                    alone.map(|p| curve_piece(&curve, from, to, p)).collect();
                let alone = alone.expect("pieces");
                assert_eq!(format!("{alone:?}"), format!("{pieces:?}"));
            }
        }
    }
}
