//! Faces for tests.

use crate::brep::*;
use crate::numeric::Interval;
use crate::nurbs::*;
use nalgebra::{Point2, Point3, Vector3};

/// A use of a curve: reversed or not, over a part of it or the whole.
pub(in crate::trim) struct Use {
    pub(in crate::trim) curve: Curve2,
    pub(in crate::trim) span: Option<[f64; 2]>,
    pub(in crate::trim) reversed: bool,
}

impl From<Curve2> for Use {
    fn from(curve: Curve2) -> Self {
        Self {
            curve,
            span: None,
            reversed: false,
        }
    }
}

/// A polygon with one corner that turns inward.
pub(in crate::trim) const L_SHAPE: [[f64; 2]; 6] = [
    [0.0, 0.0],
    [2.0, 0.0],
    [2.0, 1.0],
    [1.0, 1.0],
    [1.0, 2.0],
    [0.0, 2.0],
];

/// A planar face with this domain and these loops.
pub(in crate::trim) fn face(domain: [f64; 4], loops: Option<Vec<Vec<Use>>>) -> Brep {
    let interval = |a, b| Interval::new(a, b).unwrap();
    let d = [
        interval(domain[0], domain[1]),
        interval(domain[2], domain[3]),
    ];
    let mut parts = BrepParts {
        surfaces: vec![Surface::Plane(Plane {
            origin: Point3::origin(),
            x: Vector3::x(),
            y: Vector3::y(),
            domain: d,
            extents: d,
        })],
        vertices: vec![Vertex {
            point: Point3::origin(),
            edges: vec![],
            tolerance: None,
        }],
        ..BrepParts::default()
    };
    parts.faces.push(Face {
        surface: 0,
        loops: loops.as_ref().map(|l| (0..l.len()).collect()),
        reversed: false,
    });
    for (l, uses) in loops.into_iter().flatten().enumerate() {
        let first = parts.trims.len();
        for u in uses {
            parts.trims.push(TrimCurve {
                curve: parts.curves2.len(),
                span: u.span.map_or(u.curve.domain(), |s| interval(s[0], s[1])),
                reversed: u.reversed,
                edge: None,
                edge_reversed: false,
                vertices: [0, 0],
                kind: TrimKind::Unknown,
                iso: Iso::None,
                trim_loop: l,
            });
            parts.curves2.push(u.curve);
        }
        parts.loops.push(TrimLoop {
            kind: LoopKind::Unknown,
            trims: (first..parts.trims.len()).collect(),
            face: 0,
        });
    }
    Brep::new(parts).unwrap()
}

pub(in crate::trim) fn line(a: [f64; 2], b: [f64; 2]) -> Curve2 {
    Curve::Line(
        Line::new(
            Point2::from(a),
            Point2::from(b),
            Interval::new(0.0, 1.0).unwrap(),
        )
        .unwrap(),
    )
}

/// A closed polygon as lines.
pub(in crate::trim) fn polygon(points: &[[f64; 2]]) -> Vec<Use> {
    (0..points.len())
        .map(|i| line(points[i], points[(i + 1) % points.len()]).into())
        .collect()
}

pub(in crate::trim) fn nurbs(degree: usize, points: &[[f64; 3]], knots: &[f64]) -> Curve2 {
    Curve::Nurbs(
        NurbsCurve::new(
            degree,
            points.iter().map(|p| (*p).into()).collect(),
            knots.to_vec(),
        )
        .unwrap(),
    )
}

/// One Bezier curve.
pub(in crate::trim) fn bezier(points: &[[f64; 3]]) -> Curve2 {
    let p = points.len() - 1;
    let knots: Vec<f64> = [vec![0.0; p + 1], vec![1.0; p + 1]].concat();
    nurbs(p, points, &knots)
}

/// The exact unit circle, scaled and moved: quarters x = (1 - t²) / (1 + t²), y = 2t / (1 + t²), whose
/// control points are integers.
pub(in crate::trim) fn circle(center: [f64; 2], radius: f64) -> Vec<Use> {
    let turn = |k: usize, p: [f64; 2]| match k {
        0 => p,
        1 => [-p[1], p[0]],
        2 => [-p[0], -p[1]],
        _ => [p[1], -p[0]],
    };
    (0..4)
        .map(|k| {
            let points: Vec<[f64; 3]> = [[1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 2.0, 2.0]]
                .iter()
                .map(|p| {
                    let q = turn(k, [p[0], p[1]]);
                    [
                        radius * q[0] + center[0] * p[2],
                        radius * q[1] + center[1] * p[2],
                        p[2],
                    ]
                })
                .collect();
            bezier(&points).into()
        })
        .collect()
}
