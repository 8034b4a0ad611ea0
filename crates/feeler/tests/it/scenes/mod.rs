//! BREPs and random numbers for tests and benches of queries.
#![allow(dead_code, reason = "each test file uses its own part of this")]

pub(crate) mod loops;

use feeler::brep::{
    Brep, BrepBuilder, BrepParts, Edge, Face, Iso, LoopKind, TrimCurve, TrimKind, TrimLoop,
    TrimSpec, Vertex,
};
use feeler::numeric::Interval;
use feeler::nurbs::{
    Arc, Curve, Curve2, Line, NurbsCurve, NurbsSurface, Plane, Revolution, Surface,
};
use feeler::prepare::{PreparedBrep, Shortcuts};
use nalgebra::{Point2, Point3, Vector2, Vector3, Vector4};
use std::f64::consts::TAU;

/// A BREP as it is, and with every face searched: none has a formula.
pub(crate) fn with_and_without_formulas(brep: Brep) -> [PreparedBrep; 2] {
    let off = Shortcuts {
        closed_forms: false,
        ..Shortcuts::ALL
    };
    let searched = PreparedBrep::with_shortcuts(brep.clone(), off);
    [PreparedBrep::new(brep), searched]
}

/// A face within a polygon in uv; its edges have no curves of their own.
pub(crate) fn polygon_face(surface: &Surface, corners: &[Point2<f64>]) -> PreparedBrep {
    let points = corners.iter().map(|p| surface.point(p.x, p.y));
    let side = |i: usize| {
        let ends = [corners[i], corners[(i + 1) % corners.len()]];
        Curve::Line(Line::new(ends[0], ends[1], unit()).unwrap())
    };
    let sides = (0..corners.len()).map(side).collect();
    let face = loop_face(surface, sides, points.collect());
    PreparedBrep::new(face)
}

fn unit() -> Interval {
    Interval::new(0.0, 1.0).unwrap()
}

/// A face within a loop of curves over [0, 1] in uv, each from its vertex to the next one's; its edges have no curves of their own.
pub(crate) fn loop_face(
    surface: &Surface,
    curves: Vec<Curve2>,
    vertices: Vec<Point3<f64>>,
) -> Brep {
    let count = curves.len();
    let mut parts = BrepParts::default();
    for (i, point) in vertices.into_iter().enumerate() {
        let ends = [i, (i + 1) % count];
        parts.vertices.push(Vertex {
            point,
            edges: vec![(i + count - 1) % count, i],
            tolerance: None,
        });
        parts.edges.push(Edge {
            curve: None,
            span: unit(),
            reversed: false,
            vertices: ends,
            trims: vec![i],
            tolerance: None,
        });
        parts.trims.push(TrimCurve {
            curve: i,
            span: unit(),
            reversed: false,
            edge: Some(i),
            edge_reversed: false,
            vertices: ends,
            kind: TrimKind::Boundary,
            iso: Iso::None,
            trim_loop: 0,
        });
    }
    parts.curves2 = curves;
    parts.loops.push(TrimLoop {
        kind: LoopKind::Unknown,
        trims: (0..count).collect(),
        face: 0,
    });
    parts.surfaces.push(surface.clone());
    parts.faces.push(Face {
        surface: 0,
        loops: Some(vec![0]),
        reversed: false,
    });
    Brep::new(parts).unwrap()
}

/// Xorshift: the same numbers everywhere.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub(crate) fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * ((self.next() >> 11) as f64 / (1u64 << 53) as f64)
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() >> 11) as usize % n
    }

    pub(crate) fn direction(&mut self) -> Vector3<f64> {
        loop {
            let v = Vector3::from_fn(|_, _| self.between(-1.0, 1.0));
            let n = v.norm();
            if n > 0.1 && n < 1.0 {
                return v / n;
            }
        }
    }
}

/// The box [0, 1]^3: native planes.
pub(crate) fn cube() -> Brep {
    blocks(&[[[0.0; 3], [1.0; 3]]])
}

/// Boxes from one corner to the other: native planes.
pub(crate) fn blocks(corners: &[[[f64; 3]; 2]]) -> Brep {
    let mut b = BrepBuilder::new();
    for ends in corners {
        let corner = |i: usize| [0, 1, 2].map(|c| ends[i >> c & 1][c]);
        let v: Vec<usize> = (0..8).map(|i| b.vertex(corner(i))).collect();
        for face in [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ] {
            b.planar_face(&face.map(|i| v[i])).unwrap();
        }
    }
    b.build().unwrap()
}

/// A native cylinder with both caps about an axis along z through a point, of a radius and a height: the second radius is that of its edges' circles in space. The caps' planes are so many
/// radii wide.
pub(crate) fn cylinder(
    [x, y, z]: [f64; 3],
    [radius, edge_radius]: [f64; 2],
    height: f64,
    wide: f64,
) -> Brep {
    let interval = |a: f64, b: f64| Interval::new(a, b).unwrap();
    let mut b = BrepBuilder::new();
    let at = |h: f64| [x + radius, y, z + h];
    let (low, high) = (b.vertex(at(0.)), b.vertex(at(height)));
    let circle = |h: f64| {
        Curve::Arc(
            Arc::new(Arc {
                center: Point3::new(x, y, z + h),
                x: Vector3::x(),
                y: Vector3::y(),
                z: Vector3::z(),
                radius: edge_radius,
                angle: interval(0., TAU),
                domain: interval(0., TAU),
            })
            .unwrap(),
        )
    };
    let bottom = b.edge([low, low], circle(0.)).unwrap();
    let top = b.edge([high, high], circle(height)).unwrap();
    let seam = b.straight_edge([low, high]).unwrap();
    let profile = Line::new(
        Point3::from(at(0.)),
        Point3::from(at(height)),
        interval(0., 1.),
    );
    let side = Revolution::new(Revolution {
        origin: Point3::new(x, y, z),
        axis: Vector3::z(),
        angle: interval(0., TAU),
        angle_domain: interval(0., TAU),
        profile: Curve::Line(profile.unwrap()),
        transposed: false,
    });
    let trim = |vertices, curve, edge| TrimSpec {
        vertices,
        curve,
        edge: Some(edge),
    };
    let straight = |a: [f64; 2], b: [f64; 2]| -> Curve2 {
        Curve::Line(Line::new(Point2::from(a), Point2::from(b), interval(0., 1.)).unwrap())
    };
    let around = vec![
        trim([low, low], straight([0., 0.], [TAU, 0.]), bottom),
        trim([low, high], straight([TAU, 0.], [TAU, 1.]), seam),
        trim([high, high], straight([TAU, 1.], [0., 1.]), top),
        trim([high, low], straight([0., 1.], [0., 0.]), seam),
    ];
    b.face_with_trims(Surface::Revolution(side.unwrap()), vec![around])
        .unwrap();
    for (h, edge, vertex, sign) in [(0., bottom, low, -1.), (height, top, high, 1.)] {
        let own = interval(-radius * wide, radius * wide);
        let plane = Plane::new(Plane {
            origin: Point3::new(x, y, z + h),
            x: Vector3::x(),
            y: Vector3::y() * sign,
            domain: [own; 2],
            extents: [own; 2],
        });
        let curve = Arc::new(Arc {
            center: Point2::origin(),
            x: Vector2::x(),
            y: Vector2::y(),
            z: Vector2::zeros(),
            radius,
            angle: interval(0., TAU),
            domain: interval(0., TAU),
        });
        b.face_with_trims(
            Surface::Plane(plane.unwrap()),
            vec![vec![trim(
                [vertex, vertex],
                Curve::Arc(curve.unwrap()),
                edge,
            )]],
        )
        .unwrap();
    }
    b.build().unwrap()
}

/// A bicubic surface of 8 x 8 control points over the unit square, wavy in height.
pub(crate) fn bicubic() -> Brep {
    Brep::from_surface(Surface::Nurbs(wave())).unwrap()
}

fn wave() -> NurbsSurface {
    let mut random = Random::new(0x9e37_79b9_7f4a_7c15);
    let knots: Vec<f64> = [vec![0.0; 4], vec![0.2, 0.4, 0.6, 0.8], vec![1.0; 4]].concat();
    // The Greville abscissas: u and v are x and y.
    let at = |k: usize| (knots[k + 1] + knots[k + 2] + knots[k + 3]) / 3.0;
    let mut net = Vec::new();
    for i in 0..8 {
        for j in 0..8 {
            net.push(Vector4::new(at(i), at(j), random.between(-0.25, 0.25), 1.0));
        }
    }
    NurbsSurface::new([3, 3], [8, 8], net, [knots.clone(), knots]).unwrap()
}

/// The same within a closed curve of four rational quadratics.
pub(crate) fn trimmed_bicubic() -> Brep {
    let s = std::f64::consts::FRAC_1_SQRT_2;
    let knots = vec![0., 0., 0., 1., 1., 2., 2., 3., 3., 4., 4., 4.];
    let ring = [
        (1, 0),
        (1, 1),
        (0, 1),
        (-1, 1),
        (-1, 0),
        (-1, -1),
        (0, -1),
        (1, -1),
        (1, 0),
    ];
    let point = |(k, &(x, y)): (usize, &(i32, i32))| {
        let w = if k % 2 == 0 { 1.0 } else { s };
        let at = |x: i32| (0.5 + 0.4 * f64::from(x)) * w;
        Vector3::new(at(x), at(y), w)
    };
    let net = ring.iter().enumerate().map(point).collect();
    let curve = NurbsCurve::new(2, net, knots).unwrap();
    let mut b = BrepBuilder::new();
    let at = b.vertex([0.9, 0.5, 0.0]);
    // The copy of the curve in space is for display only.
    let circle = Arc {
        center: Point3::new(0.5, 0.5, 0.0),
        x: Vector3::x(),
        y: Vector3::y(),
        z: Vector3::z(),
        radius: 0.4,
        angle: Interval::new(0.0, std::f64::consts::TAU).unwrap(),
        domain: Interval::new(0.0, 1.0).unwrap(),
    };
    let circle = Curve::Arc(Arc::new(circle).unwrap());
    let trim = TrimSpec {
        vertices: [at, at],
        curve: Curve::Nurbs(curve),
        edge: Some(b.edge([at, at], circle).unwrap()),
    };
    b.face_with_trims(Surface::Nurbs(wave()), vec![vec![trim]])
        .unwrap();
    b.build().unwrap()
}

/// A sphere of radius 2.5 about the origin as a revolution; an open sheet.
pub(crate) fn sphere() -> Surface {
    let half = std::f64::consts::FRAC_PI_2;
    part_of_sphere([-half, half], 4.0 * half)
}

/// An eighth of it.
pub(crate) fn octant() -> Surface {
    let half = std::f64::consts::FRAC_PI_2;
    part_of_sphere([0.0, half], half)
}

/// What is of it between two latitudes, turned by so much.
pub(crate) fn part_of_sphere(latitudes: [f64; 2], turn: f64) -> Surface {
    let interval = |a, b| Interval::new(a, b).unwrap();
    let profile = Arc {
        center: Point3::origin(),
        x: Vector3::x(),
        y: Vector3::z(),
        z: -Vector3::y(),
        radius: 2.5,
        angle: interval(latitudes[0], latitudes[1]),
        domain: interval(0.0, 1.0),
    };
    let turned = Revolution {
        origin: Point3::origin(),
        axis: Vector3::z(),
        angle: interval(0.0, turn),
        angle_domain: interval(0.0, 1.0),
        profile: Curve::Arc(Arc::new(profile).unwrap()),
        transposed: false,
    };
    Surface::Revolution(Revolution::new(turned).unwrap())
}

/// The same in closed form.
pub(crate) fn native_sphere() -> Brep {
    Brep::from_surface(sphere()).unwrap()
}

/// The same as NURBS.
pub(crate) fn nurbs_sphere() -> Brep {
    as_nurbs(&sphere())
}

/// A sheet of one surface as NURBS.
pub(crate) fn as_nurbs(surface: &Surface) -> Brep {
    Brep::from_surface(Surface::Nurbs(surface.to_nurbs().unwrap().nurbs)).unwrap()
}

/// A cylinder around z as NURBS, of the sphere's radius and 8 high.
pub(crate) fn nurbs_cylinder() -> Brep {
    let at = |z: f64| Point3::new(2.5, 0.0, z);
    let interval = |a, b| Interval::new(a, b).unwrap();
    let turned = Revolution {
        origin: Point3::origin(),
        axis: Vector3::z(),
        angle: interval(0.0, std::f64::consts::TAU),
        angle_domain: interval(0.0, 1.0),
        profile: Curve::Line(Line::new(at(-4.0), at(4.0), interval(0.0, 1.0)).unwrap()),
        transposed: false,
    };
    let surface = Surface::Revolution(Revolution::new(turned).unwrap());
    Brep::from_surface(Surface::Nurbs(surface.to_nurbs().unwrap().nurbs)).unwrap()
}

/// A closed prism of height 2 over a wavy loop of `sides` rational cubics around the z axis, control points at radii from 4 to 6: sides of
/// bidegree (3, 1), and two flat faces trimmed by the cubics.
pub(crate) fn wavy_prism(sides: usize) -> Brep {
    let heights = [-1.0, 1.0];
    let unit = Interval::new(0.0, 1.0).unwrap();
    let cubic = |net: Vec<Vector3<f64>>| {
        let knots = vec![0., 0., 0., 0., 1., 1., 1., 1.];
        NurbsCurve::new(3, net, knots).unwrap()
    };
    let curves: Vec<Vec<Vector3<f64>>> = loops::wavy(sides, &mut Random::new(5))
        .iter()
        .map(|c| match c {
            Curve::Nurbs(c) => c.control_points().to_vec(),
            _ => unreachable!("a NURBS curve"),
        })
        .collect();
    let mut b = BrepBuilder::new();
    let raised = |p: &Vector3<f64>, z: f64| Vector4::new(p.x, p.y, z * p.z, p.z);
    // Vertices and cubic edges at the bottom, then at the top.
    let corners = heights.map(|z| -> Vec<usize> {
        let at = |c: &Vec<Vector3<f64>>| b.vertex([c[0].x / c[0].z, c[0].y / c[0].z, z]);
        curves.iter().map(at).collect()
    });
    let next = |k: usize| (k + 1) % sides;
    let rims = [0, 1].map(|e| -> Vec<usize> {
        let edge = |(k, c): (usize, &Vec<Vector3<f64>>)| {
            let net = c.iter().map(|p| raised(p, heights[e])).collect();
            let curve = NurbsCurve::new(3, net, vec![0., 0., 0., 0., 1., 1., 1., 1.]).unwrap();
            let ends = [corners[e][k], corners[e][next(k)]];
            b.edge(ends, Curve::Nurbs(curve)).unwrap()
        };
        curves.iter().enumerate().map(edge).collect()
    });
    for (k, c) in curves.iter().enumerate() {
        let both = |p: &Vector3<f64>| heights.map(|z| raised(p, z));
        let net = c.iter().flat_map(both).collect();
        let knots = [vec![0., 0., 0., 0., 1., 1., 1., 1.], vec![0., 0., 1., 1.]];
        let surface = NurbsSurface::new([3, 1], [4, 2], net, knots).unwrap();
        let uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Point2::from);
        let v = [
            corners[0][k],
            corners[0][next(k)],
            corners[1][next(k)],
            corners[1][k],
        ];
        let edges = [
            rims[0][k],
            b.straight_edge([v[1], v[2]]).unwrap(),
            rims[1][k],
            b.straight_edge([v[3], v[0]]).unwrap(),
        ];
        let trim = |i: usize| TrimSpec {
            vertices: [v[i], v[(i + 1) % 4]],
            curve: Curve::Line(Line::new(uv[i], uv[(i + 1) % 4], unit).unwrap()),
            edge: Some(edges[i]),
        };
        let trims = (0..4).map(trim).collect();
        b.face_with_trims(Surface::Nurbs(surface), vec![trims])
            .unwrap();
    }
    let wide = Interval::new(-10.0, 10.0).unwrap();
    for e in 0..2 {
        let plane = Plane {
            origin: Point3::new(0.0, 0.0, heights[e]),
            x: Vector3::x(),
            y: Vector3::y(),
            domain: [wide; 2],
            extents: [wide; 2],
        };
        // Counter-clockwise as seen from outside.
        let trim = |k: usize| {
            let ends = [corners[e][k], corners[e][next(k)]];
            let net = curves[k].clone();
            let backward = |mut x: Vec<Vector3<f64>>| {
                x.reverse();
                x
            };
            TrimSpec {
                vertices: if e == 0 { [ends[1], ends[0]] } else { ends },
                curve: Curve::Nurbs(cubic(if e == 0 { backward(net) } else { net })),
                edge: Some(rims[e][k]),
            }
        };
        let mut trims: Vec<_> = (0..sides).map(trim).collect();
        if e == 0 {
            trims.reverse();
        }
        b.face_with_trims(Surface::Plane(Plane::new(plane).unwrap()), vec![trims])
            .unwrap();
    }
    b.build().unwrap()
}
