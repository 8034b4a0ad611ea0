//! Loops in uv for examples and benches.

use super::Random;
use feeler::brep::*;
use feeler::numeric::Interval;
use feeler::nurbs::*;
use feeler::trim::TrimRegion;
use nalgebra::{Point2, Point3, Vector2, Vector3};

/// The plane of x and y, so far to each side of the origin.
pub(crate) fn square_plane(half: f64) -> Surface {
    let d = Interval::new(-half, half).expect("a domain");
    Surface::Plane(Plane {
        origin: Point3::origin(),
        x: Vector3::x(),
        y: Vector3::y(),
        domain: [d, d],
        extents: [d, d],
    })
}

/// The sides of a polygon.
pub(crate) fn polygon(corners: &[Point2<f64>]) -> Vec<Curve2> {
    let unit = Interval::new(0.0, 1.0).expect("a domain");
    let side = |i: usize| Line::new(corners[i], corners[(i + 1) % corners.len()], unit);
    (0..corners.len())
        .map(|i| Curve::Line(side(i).expect("a side")))
        .collect()
}

/// A face of the plane within loops.
pub(crate) fn face_within(loops: Vec<Vec<Curve2>>) -> Brep {
    face_of(square_plane(10.0), loops)
}

/// A face of any surface within loops, each trim with an edge of its own.
pub(crate) fn face_of(surface: Surface, loops: Vec<Vec<Curve2>>) -> Brep {
    let mut parts = BrepParts {
        surfaces: vec![surface],
        vertices: vec![Vertex {
            point: Point3::origin(),
            edges: vec![],
            tolerance: None,
        }],
        ..BrepParts::default()
    };
    parts.faces.push(Face {
        surface: 0,
        loops: Some((0..loops.len()).collect()),
        reversed: false,
    });
    for (l, curves) in loops.into_iter().enumerate() {
        let first = parts.trims.len();
        for c in curves {
            parts.trims.push(TrimCurve {
                curve: parts.curves2.len(),
                span: c.domain(),
                reversed: false,
                edge: Some(parts.edges.len()),
                edge_reversed: false,
                vertices: [0, 0],
                kind: TrimKind::Unknown,
                iso: Iso::None,
                trim_loop: l,
            });
            parts.edges.push(Edge {
                curve: None,
                span: c.domain(),
                reversed: false,
                vertices: [0, 0],
                trims: vec![parts.trims.len() - 1],
                tolerance: None,
            });
            parts.curves2.push(c);
        }
        parts.loops.push(TrimLoop {
            kind: LoopKind::Unknown,
            trims: (first..parts.trims.len()).collect(),
            face: 0,
        });
    }
    Brep::new(parts).expect("a BREP")
}

/// A wavy loop of `n` rational cubics around the origin.
pub(crate) fn wavy(n: usize, random: &mut Random) -> Vec<Curve2> {
    let at = |a: f64, r: f64| [r * a.cos(), r * a.sin()];
    let turn = std::f64::consts::TAU / n as f64;
    let radius: Vec<f64> = (0..n)
        .map(|_| 4.0 + 2.0 * random.between(0.0, 1.0))
        .collect();
    (0..n)
        .map(|k| {
            let (a, b) = (k as f64 * turn, (k + 1) as f64 * turn);
            let (ra, rb) = (radius[k], radius[(k + 1) % n]);
            let end = if k + 1 == n { 0.0 } else { b };
            let stretch = 1.0 + turn * turn / 18.0;
            let points = [
                at(a, ra),
                at(a + turn / 3.0, ra * stretch),
                at(b - turn / 3.0, rb * stretch),
                at(end, rb),
            ];
            let weights = [
                1.0,
                0.8 + 0.4 * random.between(0.0, 1.0),
                0.8 + 0.4 * random.between(0.0, 1.0),
                1.0,
            ];
            let net = points
                .iter()
                .zip(weights)
                .map(|(p, w)| [p[0] * w, p[1] * w, w].into())
                .collect();
            let knots = vec![0., 0., 0., 0., 1., 1., 1., 1.];
            Curve::Nurbs(NurbsCurve::new(3, net, knots).expect("a cubic"))
        })
        .collect()
}

/// A comb of `n` cubics in all: teeth as high as the comb.
pub(crate) fn comb(n: usize) -> Vec<Curve2> {
    let teeth = n / 2;
    let width = 16.0 / teeth as f64;
    let mut corners = vec![[-8.0, -8.0]];
    for k in 0..teeth {
        let x = -8.0 + k as f64 * width;
        corners.push([x + 0.3 * width, 8.0]);
        corners.push([x + width, if k + 1 == teeth { -8.0 } else { -7.9 }]);
    }
    corners
        .windows(2)
        .chain([[corners[corners.len() - 1], corners[0]].as_slice()])
        .map(|c| {
            let (a, b) = (c[0], c[1]);
            let mix = |s: f64, off: f64| {
                [
                    a[0] + s * (b[0] - a[0]) + off * 0.1 * width,
                    a[1] + s * (b[1] - a[1]),
                    1.0,
                ]
            };
            let net = [
                mix(0.0, 0.0),
                mix(0.33, 1.0),
                mix(0.67, -1.0),
                mix(1.0, 0.0),
            ];
            let knots = vec![0., 0., 0., 0., 1., 1., 1., 1.];
            Curve::Nurbs(NurbsCurve::new(3, net.map(Into::into).to_vec(), knots).expect("a cubic"))
        })
        .collect()
}

/// Many small loops in a square.
pub(crate) fn islands(n: usize, random: &mut Random) -> Vec<Vec<Curve2>> {
    let side = ((n / 4) as f64).sqrt().ceil() as usize;
    let mut out = Vec::new();
    for i in 0..side {
        for j in 0..side {
            let c = [i, j].map(|k| -9.0 + 18.0 * (k as f64 + 0.5) / side as f64);
            let s = 1.6 / side as f64;
            let mut curves = wavy(4, random);
            for curve in &mut curves {
                if let Curve::Nurbs(n) = curve {
                    let net = n
                        .control_points()
                        .iter()
                        .map(|p| [p[0] * s + c[0] * p[2], p[1] * s + c[1] * p[2], p[2]].into())
                        .collect();
                    *curve = Curve::Nurbs(
                        NurbsCurve::new(3, net, n.knots().knots().to_vec()).expect("a cubic"),
                    );
                }
            }
            out.push(curves);
        }
    }
    out
}

/// How the holes of a plate are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Holes {
    Arcs,
    Splines,
    /// Of so many sides.
    Polygons(usize),
}

/// The distance of holes from each other, and their radius.
pub(crate) const PITCH: f64 = 0.5;
pub(crate) const HOLE: f64 = 0.125;

/// A square of half a side of `PITCH side / 2` with round holes in it, `side` a side, and their centres.
pub(crate) fn perforated(side: usize, holes: Holes) -> (Vec<Vec<Curve2>>, Vec<Point2<f64>>) {
    let half = 0.5 * PITCH * side as f64;
    let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
    let mut loops = vec![polygon(&corners.map(Point2::from))];
    let at = |k: usize| (k as f64 + 0.5) * PITCH - half;
    let centers = (0..side * side).map(|k| Point2::new(at(k / side), at(k % side)));
    let centers: Vec<Point2<f64>> = centers.collect();
    loops.extend(centers.iter().map(|c| hole(*c, holes)));
    (loops, centers)
}

/// Places over holes and their rims.
pub(crate) fn over_holes(
    centers: &[Point2<f64>],
    count: usize,
    random: &mut Random,
) -> Vec<Point3<f64>> {
    let mut at = |_| {
        let c = centers[random.below(centers.len())];
        let [x, y] = [c.x, c.y].map(|c| c + HOLE * random.between(-1.0, 1.0));
        Point3::new(x, y, HOLE * random.between(0.0, 1.0))
    };
    (0..count).map(&mut at).collect()
}

fn hole(center: Point2<f64>, holes: Holes) -> Vec<Curve2> {
    match holes {
        Holes::Arcs => {
            let turn = Interval::new(0.0, std::f64::consts::TAU).expect("a turn");
            vec![Curve::Arc(Arc {
                center,
                x: Vector2::x(),
                y: Vector2::y(),
                z: Vector2::zeros(),
                radius: HOLE,
                angle: turn,
                domain: turn,
            })]
        }
        Holes::Splines => {
            // The NURBS Book, figure 7.16: a circle of four quarters.
            let w = std::f64::consts::FRAC_1_SQRT_2;
            let round = [
                [1, 0],
                [1, 1],
                [0, 1],
                [-1, 1],
                [-1, 0],
                [-1, -1],
                [0, -1],
                [1, -1],
                [1, 0],
            ];
            let net = round.iter().enumerate().map(|(i, [x, y])| {
                let w = if i % 2 == 0 { 1.0 } else { w };
                let [x, y] = [(x, center.x), (y, center.y)].map(|(k, c)| c + HOLE * f64::from(*k));
                [x * w, y * w, w].into()
            });
            let knots = vec![0., 0., 0., 1., 1., 2., 2., 3., 3., 4., 4., 4.];
            let circle = NurbsCurve::new(2, net.collect(), knots);
            vec![Curve::Nurbs(circle.expect("a circle"))]
        }
        Holes::Polygons(sides) => {
            let corner = |k: usize| {
                let (sin, cos) = (k as f64 * std::f64::consts::TAU / sides as f64).sin_cos();
                center + Vector2::new(cos, sin) * HOLE
            };
            polygon(&(0..sides).map(corner).collect::<Vec<_>>())
        }
    }
}

/// Points anywhere in the box around a region's boundary.
pub(crate) fn anywhere(region: &TrimRegion, count: usize, random: &mut Random) -> Vec<Point2<f64>> {
    let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for p in region.pieces() {
        for (b, h) in bounds.iter_mut().zip(p.hull) {
            *b = [b[0].min(h[0]), b[1].max(h[1])];
        }
    }
    let at = |_| {
        let [u, v] = bounds.map(|b| random.between(b[0], b[1]));
        Point2::new(u, v)
    };
    (0..count).map(at).collect()
}

/// Points within a distance (in u and in v) of a region's boundary.
pub(crate) fn near(
    region: &TrimRegion,
    distance: f64,
    count: usize,
    random: &mut Random,
) -> Vec<Point2<f64>> {
    let at = |_| {
        let p = region.piece(random.below(region.pieces().len()));
        let t = random.between(0.0, 1.0);
        let mut d = p.control_points();
        while d.len() > 1 {
            let mix = |w: &[[f64; 3]]| [0, 1, 2].map(|i| w[0][i] * (1.0 - t) + w[1][i] * t);
            d = d.windows(2).map(mix).collect();
        }
        let off = [0, 1].map(|_| random.between(-distance, distance));
        Point2::new(d[0][0] / d[0][2] + off[0], d[0][1] / d[0][2] + off[1])
    };
    (0..count).map(at).collect()
}
