//! Rational Bezier patches of a face's surface, with bounds.

use super::circle::{Span, normalized, spans};
use super::compose::compose;
use super::spline::{BezierCurve, Blossom, curve_pieces};
use super::turned::Turned;
use super::{Box3, Homogeneous, Net, ParamMap};
use crate::numeric::bernstein::Bidegree;
use crate::numeric::{Ball, Dd, Interval, Real};
use crate::nurbs::{Curve3, KnotVector, NurbsSurface, Plane, Revolution, Sum, Surface};
use std::sync::OnceLock;

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
        Surface::Revolution(s) => revolution_patches(s),
        Surface::Sum(s) => sum_patches(s),
    }
}

/// How many patches a surface has.
pub(super) fn patch_count(surface: &Surface) -> usize {
    let pieces = |curve: &Curve3| {
        let mut out: Vec<BezierCurve<f64, 4>> = Vec::new();
        let domain = curve.domain();
        curve_pieces(curve, domain.start, domain.end, &mut out);
        out.len()
    };
    match surface {
        Surface::Nurbs(s) => s.knots_u().spans().count() * s.knots_v().spans().count(),
        Surface::Plane(_) => 1,
        Surface::Revolution(s) => {
            let domain = s.angle_domain;
            spans::<f64>(s.angle, domain, domain.start, domain.end).len() * pieces(&s.profile)
        }
        Surface::Sum(s) => pieces(&s.first) * pieces(&s.second),
    }
}

/// `O + along + cos a r + sin a (axis x r)` for each point of the profile, split into its part along the
/// axis and its part `r` across it: linear in homogeneous points, so it maps control points.
fn revolution_patches<T: Real>(s: &Revolution) -> Vec<Patch<T>> {
    let axis: [Ball<Dd>; 3] = normalized(&std::array::from_fn(|c| Ball::exact(s.axis[c])));
    let axis = axis.map(|b| Ball::<T>::from_dd(b.mid, b.rad));
    let mut profile = Vec::new();
    let domain = s.profile.domain();
    curve_pieces(&s.profile, domain.start, domain.end, &mut profile);
    let turns = spans::<T>(
        s.angle,
        s.angle_domain,
        s.angle_domain.start,
        s.angle_domain.end,
    );
    let point = |turn: &Span<T>, i: usize, p: &Homogeneous<T, 4>| -> Homogeneous<T, 4> {
        let q: [Ball<T>; 3] = std::array::from_fn(|c| p[c] - p[3] * Ball::exact(s.origin[c]));
        let height = q[0] * axis[0] + q[1] * axis[1] + q[2] * axis[2];
        std::array::from_fn(|c| {
            if c == 3 {
                return p[3];
            }
            let (j, k) = ((c + 1) % 3, (c + 2) % 3);
            let along = height * axis[c];
            let across = q[c] - along;
            let turned = axis[j] * q[k] - axis[k] * q[j];
            p[3] * Ball::exact(s.origin[c]) + along + turn.cos[i] * across + turn.sin[i] * turned
        })
    };
    let map = |r: Interval| ParamMap {
        start: r.start,
        end: r.end,
    };
    let turned = |turn: &Span<T>, piece: &BezierCurve<T, 4>| {
        Some(Box::new(Turned {
            transposed: s.transposed,
            angle: turn.angle,
            origin: s.origin.coords.into(),
            axis,
            profile: piece.points.clone(),
            arc: piece.arc.clone(),
        }))
    };
    let mut out = Vec::new();
    if s.transposed {
        for piece in &profile {
            for turn in &turns {
                let points = &piece.points;
                let net = points
                    .iter()
                    .flat_map(|p| (0..turn.cos.len()).map(move |i| point(turn, i, p)))
                    .collect();
                let degree = Bidegree {
                    u: points.len() - 1,
                    v: turn.cos.len() - 1,
                };
                out.push(Patch {
                    net: Net::centered(degree, net),
                    maps: [piece.map, map(turn.range)],
                    turned: turned(turn, piece),
                });
            }
        }
        return out;
    }
    for turn in &turns {
        for piece in &profile {
            let points = &piece.points;
            let net = (0..turn.cos.len())
                .flat_map(|i| points.iter().map(move |p| point(turn, i, p)))
                .collect();
            let degree = Bidegree {
                u: turn.cos.len() - 1,
                v: points.len() - 1,
            };
            out.push(Patch {
                net: Net::centered(degree, net),
                maps: [map(turn.range), piece.map],
                turned: turned(turn, piece),
            });
        }
    }
    out
}

/// `base + X_1 / w_1 + X_2 / w_2`: a rational patch with weights `w_1 w_2`.
fn sum_patches<T: Real>(s: &Sum) -> Vec<Patch<T>> {
    let pieces = |c: &Curve3| {
        let mut out = Vec::new();
        let domain = c.domain();
        curve_pieces::<T, 3, 4>(c, domain.start, domain.end, &mut out);
        out
    };
    let (first, second) = (pieces(&s.first), pieces(&s.second));
    let mut out = Vec::new();
    for a in &first {
        for b in &second {
            let mut net = Vec::with_capacity(a.points.len() * b.points.len());
            for p in &a.points {
                for q in &b.points {
                    let w = p[3] * q[3];
                    net.push(std::array::from_fn(|c| {
                        if c == 3 {
                            w
                        } else {
                            p[c] * q[3] + q[c] * p[3] + Ball::exact(s.base[c]) * w
                        }
                    }));
                }
            }
            let degree = Bidegree {
                u: a.points.len() - 1,
                v: b.points.len() - 1,
            };
            out.push(Patch {
                net: Net::centered(degree, net),
                maps: [a.map, b.map],
                turned: None,
            });
        }
    }
    out
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
    let map = |i: usize| ParamMap {
        start: plane.domain[i].start,
        end: plane.domain[i].end,
    };
    Patch {
        net: Net::centered(Bidegree { u: 1, v: 1 }, net),
        maps: [map(0), map(1)],
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
            map: ParamMap { start, end },
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
        maps: [along_u.map, along_v.map],
        turned: None,
    }
}

/// The patches of a surface in order of u, then v: a grid.
#[derive(Debug)]
pub(crate) enum Patches<T> {
    /// All of them.
    Made(Vec<Patch<T>>),
    /// Those of a NURBS surface, each made when it is first asked for.
    OnDemand {
        surface: Box<NurbsSurface>,
        spans: [Vec<KnotSpan>; 2],
        slots: Vec<OnceLock<Patch<T>>>,
    },
}

impl<T: Real> Patches<T> {
    pub(super) fn all(surface: &Surface) -> Self {
        Self::Made(surface_patches(surface))
    }

    /// Patches that are made when they are needed, where that can be.
    pub(super) fn on_demand(surface: &Surface) -> Self {
        let Surface::Nurbs(s) = surface else {
            return Self::all(surface);
        };
        let spans = [s.knots_u(), s.knots_v()].map(|k| k.spans().collect::<Vec<_>>());
        let count = spans[0].len() * spans[1].len();
        Self::OnDemand {
            surface: Box::new(s.clone()),
            spans,
            slots: (0..count).map(|_| OnceLock::new()).collect(),
        }
    }

    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Made(all) => all.len(),
            Self::OnDemand { slots, .. } => slots.len(),
        }
    }

    pub(crate) fn iter(&self) -> impl DoubleEndedIterator<Item = &Patch<T>> + ExactSizeIterator {
        (0..self.len()).map(|i| &self[i])
    }

    /// Bytes of its lists, and of the patches that have been made as `patch` tells.
    pub(super) fn bytes(&self, patch: impl Fn(&Patch<T>) -> usize) -> usize {
        match self {
            Self::Made(all) => {
                let own = all.iter().map(patch);
                all.capacity() * size_of::<Patch<T>>() + own.sum::<usize>()
            }
            Self::OnDemand { surface, slots, .. } => {
                let own = slots.iter().filter_map(OnceLock::get).map(patch);
                slots.capacity() * size_of::<OnceLock<Patch<T>>>()
                    + size_of_val(surface.control_net())
                    + own.sum::<usize>()
            }
        }
    }
}

impl<T: Real> std::ops::Index<usize> for Patches<T> {
    type Output = Patch<T>;

    fn index(&self, index: usize) -> &Patch<T> {
        match self {
            Self::Made(all) => &all[index],
            Self::OnDemand {
                surface,
                spans: [u, v],
                slots,
            } => slots[index]
                .get_or_init(|| nurbs_patch(surface, [u[index / v.len()], v[index % v.len()]])),
        }
    }
}

/// A box around a whole surface, by the convex hull of its control points; `None` where none is known.
pub(crate) fn surface_box(surface: &Surface) -> Option<Box3> {
    match surface {
        Surface::Nurbs(s) => {
            let points = s
                .control_net()
                .iter()
                .map(|p| std::array::from_fn(|c| Ball::<f64>::exact(p[c])))
                .collect();
            Net::new(Bidegree { u: 0, v: 0 }, points, [0.0; 3]).bounding_box()
        }
        Surface::Plane(s) => plane_patch::<f64>(s).net.bounding_box(),
        Surface::Revolution(_) | Surface::Sum(_) => {
            let mut out: Option<Box3> = None;
            for patch in surface_patches::<f64>(surface) {
                let b = patch.net.bounding_box()?;
                let all = out.get_or_insert(b);
                for c in 0..3 {
                    all[c] = [all[c][0].min(b[c][0]), all[c][1].max(b[c][1])];
                }
            }
            out
        }
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
