//! Surfaces over the square in which loops are drawn, sheets and solids.

use crate::loops::{Loops, Use, interval};
use crate::source::{HALF, Source};
use feeler::brep::{
    Brep, BrepBuilder, BrepParts, Edge, Face, Iso, LoopKind, TrimCurve, TrimKind, TrimLoop,
    TrimSpec, Vertex,
};
use feeler::numeric::Interval;
use feeler::nurbs::{
    Arc, Curve, Curve3, Line, NurbsCurve, NurbsSurface, Plane, Revolution, Sum, Surface,
};
use nalgebra::{Point2, Point3, Vector3, Vector4};

const SQUARE: Interval = Interval {
    start: -HALF,
    end: HALF,
};

/// The plane z = 0, whose parameters are x and y.
pub(crate) fn level(domain: [Interval; 2]) -> Surface {
    Surface::Plane(Plane {
        origin: Point3::origin(),
        x: Vector3::x(),
        y: Vector3::y(),
        domain,
        extents: domain,
    })
}

/// One face of this surface, each trim with an edge of its own; the whole domain without loops. None
/// where there is no such BREP.
pub(crate) fn sheet(surface: Surface, loops: Option<&[Vec<Use>]>) -> Option<Brep> {
    let mut parts = BrepParts::default();
    for (l, uses) in loops.into_iter().flatten().enumerate() {
        let first = parts.trims.len();
        for (i, used) in uses.iter().enumerate() {
            let trim = first + i;
            let next = first + (i + 1) % uses.len();
            let [u, v] = used.start();
            let point = surface.point(u, v);
            parts.vertices.push(Vertex {
                point,
                edges: vec![trim],
                tolerance: None,
            });
            parts.edges.push(Edge {
                curve: None,
                span: interval(0.0, 1.0),
                reversed: false,
                vertices: [trim, next],
                trims: vec![trim],
                tolerance: None,
            });
            parts.trims.push(TrimCurve {
                curve: parts.curves2.len(),
                span: used.span,
                reversed: used.reversed,
                edge: Some(trim),
                edge_reversed: false,
                vertices: [trim, next],
                kind: TrimKind::Boundary,
                iso: Iso::None,
                trim_loop: l,
            });
            parts.curves2.push(used.curve.clone());
        }
        parts.loops.push(TrimLoop {
            kind: LoopKind::Unknown,
            trims: (first..parts.trims.len()).collect(),
            face: 0,
        });
    }
    parts.surfaces.push(surface);
    parts.faces.push(Face {
        surface: 0,
        loops: loops.map(|l| (0..l.len()).collect()),
        reversed: false,
    });
    Brep::new(parts).ok()
}

/// A surface over the square.
pub(crate) fn surface(s: &mut Source<'_>) -> Option<Surface> {
    match s.below(12) {
        0..=6 => nurbs(s),
        7 => plane(s),
        8..=9 => revolution(s),
        10 => sum(s),
        _ => round(s),
    }
}

fn vector(s: &mut Source<'_>) -> Vector3<f64> {
    Vector3::from(s.triple())
}

fn plane(s: &mut Source<'_>) -> Option<Surface> {
    let plane = Plane {
        origin: Point3::from(s.triple()),
        x: vector(s),
        y: vector(s),
        domain: [SQUARE; 2],
        extents: [SQUARE; 2],
    };
    Plane::new(plane).ok().map(Surface::Plane)
}

fn nurbs(s: &mut Source<'_>) -> Option<Surface> {
    /// Control points of one surface: degree 9 by 3 with a knot or two.
    const MOST: usize = 60;
    let degrees = [s.degree(9), s.degree(5)];
    let (knots_u, nu) = s.knots(degrees[0], [-HALF, HALF]);
    let (knots_v, nv) = s.knots(degrees[1], [-HALF, HALF]);
    if nu * nv > MOST {
        return None;
    }
    let form = s.byte();
    let rational = s.rarely(80);
    let mut net = Vec::with_capacity(nu * nv);
    let mut pole = [0.0; 3];
    for i in 0..nu {
        for j in 0..nv {
            let x = -HALF + 2.0 * HALF * i as f64 / (nu - 1) as f64;
            let y = -HALF + 2.0 * HALF * j as f64 / (nv - 1) as f64;
            let mut p = match form {
                // A graph.
                0..=119 => [x, y, s.coordinate()],
                // About a graph.
                120..=199 => {
                    let [a, b, c] = s.triple();
                    [x + a / 8.0, y + b / 8.0, c / 2.0]
                }
                // A slope, exactly or up to rounding.
                200..=215 => [x, y, 0.25 * x - 0.5 * y],
                _ => s.triple(),
            };
            if i == 0 && form % 8 == 7 {
                // One side is a point.
                if j == 0 {
                    pole = p;
                }
                p = pole;
            }
            if s.rarely(6)
                && let Some(last) = net.last().map(|l: &Vector4<f64>| l.xyz() / l.w)
            {
                p = last.into();
            }
            let w = if rational { s.weight() } else { 1.0 };
            net.push(Vector4::new(p[0] * w, p[1] * w, p[2] * w, w));
        }
    }
    let made = NurbsSurface::new(degrees, [nu, nv], net, [knots_u, knots_v]);
    made.ok().map(Surface::Nurbs)
}

/// A curve in space over the side of the square.
fn curve(s: &mut Source<'_>) -> Option<Curve3> {
    match s.below(4) {
        0 => {
            let ends = [s.triple(), s.triple()].map(Point3::from);
            Line::new(ends[0], ends[1], SQUARE).ok().map(Curve::Line)
        }
        1 => {
            let start = f64::from(s.byte() as i8) / 64.0;
            let arc = Arc {
                center: Point3::from(s.triple()),
                x: vector(s),
                y: Vector3::zeros(),
                z: vector(s),
                radius: f64::from(1 + s.byte() % 64) / 16.0,
                angle: interval(start, start + f64::from(1 + s.byte() % 48) / 8.0),
                domain: SQUARE,
            };
            Arc::new(arc).ok().map(Curve::Arc)
        }
        _ => {
            let degree = s.degree(5);
            let (knots, count) = s.knots(degree, [-HALF, HALF]);
            let rational = s.rarely(80);
            let net = (0..count).map(|_| {
                let p = s.triple();
                let w = if rational { s.weight() } else { 1.0 };
                Vector4::new(p[0] * w, p[1] * w, p[2] * w, w)
            });
            let net = net.collect();
            NurbsCurve::new(degree, net, knots).ok().map(Curve::Nurbs)
        }
    }
}

fn revolution(s: &mut Source<'_>) -> Option<Surface> {
    use std::f64::consts::TAU;
    let start = f64::from(s.byte() as i8) / 64.0;
    let turn = match s.byte() {
        0..=159 => TAU,
        b => f64::from(b) / 42.0,
    };
    let made = Revolution {
        origin: Point3::from(s.triple()),
        axis: if s.rarely(96) {
            vector(s)
        } else {
            Vector3::z()
        },
        angle: interval(start, start + turn),
        angle_domain: SQUARE,
        profile: curve(s)?,
        transposed: s.rarely(64),
    };
    Revolution::new(made).ok().map(Surface::Revolution)
}

fn sum(s: &mut Source<'_>) -> Option<Surface> {
    Some(Surface::Sum(Sum {
        base: vector(s),
        first: curve(s)?,
        second: curve(s)?,
    }))
}

/// An eighth of a sphere, or a cylinder's quarter, as NURBS: focal points that are points, and a pole.
fn round(s: &mut Source<'_>) -> Option<Surface> {
    let r = f64::from(1 + s.byte() % 64) / 16.0;
    let center = s.triple();
    // The quarter (1 - t^2, 2t) / (1 + t^2), twice.
    let quarter = [[1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 2.0, 2.0]];
    let cylinder = s.rarely(128);
    let mut net = Vec::new();
    for a in quarter {
        for b in quarter {
            let w = a[2] * b[2];
            // Around by a, up by b.
            let p = if cylinder {
                [r * a[0] * b[2], r * a[1] * b[2], r * b[1] * a[2]]
            } else {
                [r * a[0] * b[0], r * a[1] * b[0], r * a[2] * b[1]]
            };
            let [x, y, z] = [0, 1, 2].map(|i| p[i] + center[i] * w);
            net.push(Vector4::new(x, y, z, w));
        }
    }
    let knots = || {
        let mut k = vec![-HALF; 3];
        k.extend([HALF; 3]);
        k
    };
    let made = NurbsSurface::new([2, 2], [3, 3], net, [knots(), knots()]);
    made.ok().map(Surface::Nurbs)
}

/// A face, whole or trimmed, or a solid.
pub(crate) fn body(s: &mut Source<'_>) -> Option<(Brep, Loops)> {
    match s.byte() {
        // The byte 0 of an input that has ended: the plainest.
        0..=95 => Some((sheet(surface(s)?, None)?, Loops::default())),
        96..=199 => {
            let made = surface(s)?;
            let loops = Loops::draw(s);
            let brep = sheet(made, Some(&loops.loops))?;
            Some((brep, loops))
        }
        200..=219 => Some((prism(s)?, Loops::default())),
        _ => Some((block(s)?, Loops::default())),
    }
}

/// A prism over a polygon, with flat faces up to rounding.
fn prism(s: &mut Source<'_>) -> Option<Brep> {
    let n = 3 + s.below(4);
    let up = vector(s);
    let mut b = BrepBuilder::new();
    let base: Vec<[f64; 2]> = (0..n).map(|_| s.pair()).collect();
    for lift in [Vector3::zeros(), up] {
        for [x, y] in &base {
            b.vertex(Point3::new(*x, *y, 0.0) + lift);
        }
    }
    let bottom: Vec<usize> = (0..n).rev().collect();
    b.planar_face(&bottom).ok()?;
    let top: Vec<usize> = (n..2 * n).collect();
    b.planar_face(&top).ok()?;
    for i in 0..n {
        let j = (i + 1) % n;
        b.planar_face(&[i, j, n + j, n + i]).ok()?;
    }
    b.build().ok()
}

/// A block with bulging faces; the edges are straight, and exact where their thirds are.
fn block(s: &mut Source<'_>) -> Option<Brep> {
    const FACES: [[usize; 4]; 6] = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [1, 3, 7, 5],
        [3, 2, 6, 7],
        [2, 0, 4, 6],
    ];
    let size = s.triple().map(|x| 0.25 + x.abs());
    let shaken = s.rarely(128);
    let mut b = BrepBuilder::new();
    let mut corners = Vec::new();
    for i in 0..8 {
        let at = [i & 1, i >> 1 & 1, i >> 2].map(f64::from);
        let mut p = [0, 1, 2].map(|k| at[k] * size[k]);
        if shaken {
            let [x, y, z] = s.triple();
            p = [p[0] + x / 16.0, p[1] + y / 16.0, p[2] + z / 16.0];
        }
        corners.push(Vector3::from(p));
        b.vertex(Point3::from(p));
    }
    for quad in FACES {
        let [p, q, r, t] = quad.map(|i| corners[i]);
        let degree = 1 + s.below(3);
        let n = degree + 1;
        let out = (q - p).cross(&(t - p)).try_normalize(0.0)?;
        let mut net = Vec::new();
        for i in 0..n {
            for j in 0..n {
                let (x, y) = (i as f64 / degree as f64, j as f64 / degree as f64);
                let inner = (1..degree).contains(&i) && (1..degree).contains(&j);
                let flat = (p * (1.0 - x) + q * x) * (1.0 - y) + (t * (1.0 - x) + r * x) * y;
                // On the border exactly between the corners.
                let at = if inner {
                    flat + out * (s.coordinate() / 8.0)
                } else {
                    flat
                };
                net.push(Vector4::new(at.x, at.y, at.z, 1.0));
            }
        }
        let knots = || {
            let mut k = vec![0.0; n];
            k.extend(vec![1.0; n]);
            k
        };
        let made = NurbsSurface::new([degree; 2], [n; 2], net, [knots(), knots()]).ok()?;
        let uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Point2::from);
        let mut trims = Vec::new();
        for k in 0..4 {
            let ends = [quad[k], quad[(k + 1) % 4]];
            let edge = b.straight_edge(ends).ok()?;
            let line = Line::new(uv[k], uv[(k + 1) % 4], interval(0.0, 1.0)).ok()?;
            trims.push(TrimSpec {
                vertices: ends,
                curve: Curve::Line(line),
                edge: Some(edge),
            });
        }
        b.face_with_trims(Surface::Nurbs(made), vec![trims]).ok()?;
    }
    b.build().ok()
}
