//! BREPs built for scenes.

use super::loops::Loops;
use feeler::brep::{
    Brep, BrepParts, Edge, Face, Iso, LoopKind, TrimCurve, TrimKind, TrimLoop, Vertex,
};
use feeler::numeric::Interval;
use feeler::nurbs::{NurbsSurface, Plane, Surface};
use nalgebra::{Point3, Vector3, Vector4};

/// The plane z = 0 over a rectangle from `a` to `b`.
pub(crate) fn unit_plane(a: [f64; 2], b: [f64; 2]) -> Surface {
    let ranges = [0, 1].map(|k| Interval {
        start: a[k],
        end: b[k],
    });
    Surface::Plane(Plane {
        origin: Point3::origin(),
        x: Vector3::x(),
        y: Vector3::y(),
        domain: ranges,
        extents: ranges,
    })
}

/// A Bezier patch over the unit square from its points, with weights.
pub(crate) fn patch(
    degrees: [usize; 2],
    point: impl Fn(usize, usize) -> ([f64; 3], f64),
) -> Result<Surface, String> {
    let counts = degrees.map(|p| p + 1);
    let mut net = Vec::new();
    for i in 0..counts[0] {
        for j in 0..counts[1] {
            let ([x, y, z], w) = point(i, j);
            net.push(Vector4::new(x * w, y * w, z * w, w));
        }
    }
    let knots = counts.map(|n| (0..2 * n).map(|i| f64::from(u8::from(i >= n))).collect());
    let made = NurbsSurface::new(degrees, counts, net, knots);
    made.map(Surface::Nurbs).map_err(|e| e.to_string())
}

/// A hyperbolic paraboloid over the unit square.
pub(crate) fn bilinear() -> Result<Surface, String> {
    patch([1, 1], |i, j| {
        let z = if i == j { 0.25 } else { -0.125 };
        ([i as f64, j as f64, z], 1.0)
    })
}

/// One face with these loops; each trim has an edge of its own, without a curve in space.
pub(crate) fn face_of(surface: Surface, loops: Option<&Loops>) -> Result<Brep, String> {
    let mut parts = BrepParts::default();
    let mut indices = Vec::new();
    for (number, curves) in loops.into_iter().flatten().enumerate() {
        let first = parts.trims.len();
        for (i, curve) in curves.iter().enumerate() {
            let trim = first + i;
            let next = first + (i + 1) % curves.len();
            let span = curve.domain();
            let start = curve.point(span.start);
            parts.vertices.push(Vertex {
                point: surface.point(start.x, start.y),
                edges: vec![trim],
                tolerance: None,
            });
            if next != trim {
                // Each vertex ends one edge and starts the next.
                let before = first + (i + curves.len() - 1) % curves.len();
                parts.vertices[trim].edges = vec![before, trim];
            }
            parts.edges.push(Edge {
                curve: None,
                span,
                reversed: false,
                vertices: [trim, next],
                trims: vec![trim],
                tolerance: None,
            });
            parts.trims.push(TrimCurve {
                curve: parts.curves2.len(),
                span,
                reversed: false,
                edge: Some(trim),
                edge_reversed: false,
                vertices: [trim, next],
                kind: TrimKind::Boundary,
                iso: Iso::None,
                trim_loop: number,
            });
            parts.curves2.push(curve.clone());
        }
        parts.loops.push(TrimLoop {
            kind: if number == 0 {
                LoopKind::Outer
            } else {
                LoopKind::Inner
            },
            trims: (first..first + curves.len()).collect(),
            face: 0,
        });
        indices.push(number);
    }
    parts.surfaces.push(surface);
    parts.faces.push(Face {
        surface: 0,
        loops: loops.map(|_| indices),
        reversed: false,
    });
    Brep::new(parts).map_err(|e| e.to_string())
}
