//! Rational Bezier patches of a face's surface, with bounds.

use super::spline::{Unsupported, bezier_of_span};
use super::{Box3, Homogeneous, Net, ParamMap};
use crate::numeric::bernstein::Bidegree;
use crate::numeric::{Ball, Real};
use crate::nurbs::{NurbsSurface, Plane, Surface};

/// A rational Bezier patch on the unit square, and the native parameters it covers.
#[derive(Clone, Debug)]
pub struct Patch<T> {
    /// The surface over the unit square.
    pub net: Net<T>,
    /// Native parameters, u and v.
    pub maps: [ParamMap; 2],
}

/// The patches of a surface, in order of u, then v.
pub(crate) fn surface_patches<T: Real>(surface: &Surface) -> Result<Vec<Patch<T>>, Unsupported> {
    match surface {
        Surface::Nurbs(s) => Ok(nurbs_patches(s)),
        Surface::Plane(s) => Ok(vec![plane_patch(s)]),
        Surface::Revolution(_) | Surface::Sum(_) => Err(Unsupported),
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
    let map = |i: usize| ParamMap {
        start: plane.domain[i].start,
        end: plane.domain[i].end,
    };
    Patch {
        net: Net::centered(Bidegree { u: 1, v: 1 }, net),
        maps: [map(0), map(1)],
    }
}

fn nurbs_patches<T: Real>(surface: &NurbsSurface) -> Vec<Patch<T>> {
    let (ku, kv) = (surface.knots_u(), surface.knots_v());
    let degree = Bidegree {
        u: ku.degree(),
        v: kv.degree(),
    };
    let count_v = kv.control_points();
    let mut patches = Vec::new();
    for (iu, ua, ub) in ku.spans() {
        // Bezier in u first: for each column of the net, p + 1 points.
        let columns: Vec<Vec<Homogeneous<T, 4>>> = (0..count_v)
            .map(|j| {
                bezier_of_span(ku, iu, ua, ub, |i| {
                    let p = &surface.control_net()[i * count_v + j];
                    std::array::from_fn(|c| Ball::exact(p[c]))
                })
            })
            .collect();
        for (iv, va, vb) in kv.spans() {
            let mut net = Vec::with_capacity(degree.len());
            for i in 0..=degree.u {
                net.extend(bezier_of_span(kv, iv, va, vb, |j| columns[j][i]));
            }
            let maps = [
                ParamMap { start: ua, end: ub },
                ParamMap { start: va, end: vb },
            ];
            patches.push(Patch {
                net: Net::centered(degree, net),
                maps,
            });
        }
    }
    patches
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
            let whole = Net {
                degree: Bidegree { u: 0, v: 0 },
                points,
                origin: [0.0; 3],
            };
            whole.bounding_box()
        }
        Surface::Plane(s) => plane_patch::<f64>(s).net.bounding_box(),
        Surface::Revolution(_) | Surface::Sum(_) => None,
    }
}
