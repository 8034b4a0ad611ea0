//! BREPs made by hand, and random numbers, for the tests.
#![allow(dead_code, reason = "each test uses a part of it")]

#[cfg(feature = "cgal")]
pub(crate) mod contacts;
pub(crate) mod native;
pub(crate) mod stress;

use dashu_int::IBig;
use dashu_ratio::RBig;
use feeler::brep::{
    Brep, BrepParts, Edge, Face, Iso, LoopKind, TrimCurve, TrimKind, TrimLoop, Vertex,
};
use feeler::numeric::{Dyadic, Interval};
use feeler::nurbs::{Curve2, Line, NurbsCurve, NurbsSurface, Plane, Surface};
use nalgebra::{Point2, Point3, Vector3, Vector4};
use std::path::Path;

pub(crate) fn interval(start: f64, end: f64) -> Interval {
    Interval { start, end }
}

pub(crate) fn dyadic(x: f64) -> Dyadic {
    Dyadic::from_f64(x).unwrap()
}

pub(crate) fn sq(x: &Dyadic) -> Dyadic {
    x * x
}

pub(crate) fn rational(d: &Dyadic) -> RBig {
    let power = IBig::ONE << usize::try_from(d.exponent().unsigned_abs()).unwrap();
    if d.exponent() >= 0 {
        RBig::from(d.mantissa() * power)
    } else {
        RBig::from_parts(d.mantissa().clone(), power.try_into().unwrap())
    }
}

/// `x` as a fraction.
pub(crate) fn exact(x: f64) -> RBig {
    rational(&dyadic(x))
}

/// A face whose loops are lists of curves, each used over its whole domain.
pub(crate) fn brep(surface: Surface, loops: Option<Vec<Vec<Curve2>>>) -> Brep {
    let mut parts = BrepParts::default();
    parts.surfaces.push(surface);
    let vertex = Vertex {
        point: Point3::origin(),
        edges: Vec::new(),
        tolerance: None,
    };
    parts.vertices.push(vertex);
    let mut indices = Vec::new();
    for (l, curves) in loops.iter().flatten().enumerate() {
        let mut trims = Vec::new();
        for curve in curves {
            let t = parts.trims.len();
            trims.push(t);
            parts.edges.push(Edge {
                curve: None,
                span: interval(0.0, 1.0),
                reversed: false,
                vertices: [0; 2],
                trims: vec![t],
                tolerance: None,
            });
            parts.trims.push(TrimCurve {
                curve: t,
                span: curve.domain(),
                reversed: false,
                edge: Some(t),
                edge_reversed: false,
                vertices: [0; 2],
                kind: TrimKind::Boundary,
                iso: Iso::None,
                trim_loop: l,
            });
            parts.curves2.push(curve.clone());
        }
        parts.loops.push(TrimLoop {
            kind: LoopKind::Unknown,
            trims,
            face: 0,
        });
        indices.push(l);
    }
    parts.faces.push(Face {
        surface: 0,
        loops: loops.map(|_| indices),
        reversed: false,
    });
    Brep::new(parts).unwrap()
}

/// The same BREP with its parts changed.
pub(crate) fn changed(b: &Brep, change: impl FnOnce(&mut BrepParts)) -> Brep {
    let mut parts = b.parts().clone();
    change(&mut parts);
    Brep::new(parts).unwrap()
}

/// The plane z = 0, x = u, y = v, over [-size, size]^2.
pub(crate) fn plane(size: f64) -> Surface {
    let range = interval(-size, size);
    Surface::Plane(
        Plane::new(Plane {
            origin: Point3::origin(),
            x: Vector3::x(),
            y: Vector3::y(),
            domain: [range, range],
            extents: [range, range],
        })
        .unwrap(),
    )
}

pub(crate) fn line(a: [f64; 2], b: [f64; 2]) -> Curve2 {
    Curve2::Line(Line::new(Point2::from(a), Point2::from(b), interval(0.0, 1.0)).unwrap())
}

/// The loop through these points.
pub(crate) fn polygon(points: &[[f64; 2]]) -> Vec<Curve2> {
    (0..points.len())
        .map(|i| line(points[i], points[(i + 1) % points.len()]))
        .collect()
}

/// A Bezier curve through homogeneous points.
pub(crate) fn bezier(points: &[[f64; 3]]) -> Curve2 {
    let p = points.len() - 1;
    let mut knots = vec![0.0; p + 1];
    knots.extend(vec![1.0; p + 1]);
    let points = points.iter().map(|q| (*q).into()).collect();
    Curve2::Nurbs(NurbsCurve::new(p, points, knots).unwrap())
}

/// The circle of this radius as four exact rational quadratics with weights 1, 1, 2: the point at t is
/// r ((1 - t^2), 2 t) / (1 + t^2) in the first quadrant, turned exactly.
pub(crate) fn circle(r: f64) -> Vec<Curve2> {
    let turn = |k: usize, [x, y, w]: [f64; 3]| match k {
        0 => [x, y, w],
        1 => [-y, x, w],
        2 => [-x, -y, w],
        _ => [y, -x, w],
    };
    (0..4)
        .map(|k| {
            bezier(&[
                turn(k, [r, 0.0, 1.0]),
                turn(k, [r, r, 1.0]),
                turn(k, [0.0, 2.0 * r, 2.0]),
            ])
        })
        .collect()
}

/// A Bezier patch; homogeneous point (i, j) at `i * (q + 1) + j`.
pub(crate) fn patch(p: usize, q: usize, net: Vec<[f64; 4]>) -> Surface {
    let knots = |d: usize| [vec![0.0; d + 1], vec![1.0; d + 1]].concat();
    Surface::Nurbs(
        NurbsSurface::new(
            [p, q],
            [p + 1, q + 1],
            net.into_iter().map(Vector4::from).collect(),
            [knots(p), knots(q)],
        )
        .unwrap(),
    )
}

/// SplitMix64 in [0, 1).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn range(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.next()
    }
}

/// The BREPs of a model file, or `None`, said aloud, where it is not there.
pub(crate) fn model(name: &str) -> Option<Vec<Brep>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/models")
        .join(name);
    if !path.exists() {
        println!("absent, not tested: {}", path.display());
        return None;
    }
    let document = feeler_io::read_file(&path).unwrap();
    Some(
        document
            .objects
            .into_iter()
            .filter_map(|o| match o.kind {
                feeler_io::ObjectKind::Brep(b) => Some(b),
                _ => None,
            })
            .collect(),
    )
}
