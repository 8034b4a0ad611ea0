//! The builder, and defects planted one at a time.

use crate::scenes::cube;
use feeler::brep::{
    Brep, BrepBuilder, BrepParts, BuildError, Defect, LARGEST_COORDINATE, LoopKind, Part, Severity,
    TrimSpec,
};
use feeler::numeric::Interval;
use feeler::nurbs::{
    Arc, Curve, Curve2, Curve3, Line, NurbsCurve, NurbsSurface, Plane, Polyline, Revolution,
    Surface,
};
use feeler::prepare::PreparedBrep;
use nalgebra::{Point2, Point3, Vector3, Vector4};
use std::f64::consts::{PI, TAU};

fn interval(start: f64, end: f64) -> Interval {
    Interval::new(start, end).unwrap()
}

/// The plane z = 0 over a square.
fn square(side: Interval) -> Surface {
    let plane = Plane::new(Plane {
        origin: Point3::origin(),
        x: Vector3::x(),
        y: Vector3::y(),
        domain: [side; 2],
        extents: [side; 2],
    });
    Surface::Plane(plane.unwrap())
}

/// The cube's defects after a change.
fn after(change: impl FnOnce(&mut BrepParts)) -> Vec<Defect> {
    let mut parts = cube().parts().clone();
    change(&mut parts);
    Brep::new(parts).unwrap().defects()
}

fn line2(a: [f64; 2], b: [f64; 2]) -> Curve2 {
    Curve::Line(Line::new(Point2::from(a), Point2::from(b), interval(0., 1.)).unwrap())
}

/// A straight curve in uv, run through slower towards its end.
fn uneven(a: [f64; 2], b: [f64; 2]) -> Curve2 {
    let at =
        |s: f64| nalgebra::Vector3::new(a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), 1.);
    let points = vec![at(0.), at(0.875), at(1.)];
    Curve::Nurbs(NurbsCurve::new(2, points, vec![0., 0., 0., 1., 1., 1.]).unwrap())
}

/// A cylinder of radius 2 and height 5 with both caps: seam, arcs, circles in uv.
fn cylinder() -> Brep {
    let mut b = BrepBuilder::new();
    let (low, high) = (b.vertex([2., 0., 0.]), b.vertex([2., 0., 5.]));
    let circle = |z: f64| -> Curve3 {
        Curve::Arc(
            Arc::new(Arc {
                center: Point3::new(0., 0., z),
                x: Vector3::x(),
                y: Vector3::y(),
                z: Vector3::z(),
                radius: 2.,
                angle: interval(0., TAU),
                domain: interval(0., TAU),
            })
            .unwrap(),
        )
    };
    let bottom = b.edge([low, low], circle(0.)).unwrap();
    let top = b.edge([high, high], circle(5.)).unwrap();
    let seam = b.straight_edge([low, high]).unwrap();
    let side = Surface::Revolution(
        Revolution::new(Revolution {
            origin: Point3::origin(),
            axis: Vector3::z(),
            angle: interval(0., TAU),
            angle_domain: interval(0., TAU),
            profile: Curve::Line(
                Line::new(
                    Point3::new(2., 0., 0.),
                    Point3::new(2., 0., 5.),
                    interval(0., 1.),
                )
                .unwrap(),
            ),
            transposed: false,
        })
        .unwrap(),
    );
    let trim = |vertices, curve, edge| TrimSpec {
        vertices,
        curve,
        edge: Some(edge),
    };
    b.face_with_trims(
        side,
        vec![vec![
            // Not at the pace of the edge: samples fall elsewhere, close to where the rim closes.
            trim([low, low], uneven([0., 0.], [TAU, 0.]), bottom),
            trim([low, high], line2([TAU, 0.], [TAU, 1.]), seam),
            trim([high, high], line2([TAU, 1.], [0., 1.]), top),
            trim([high, low], line2([0., 1.], [0., 0.]), seam),
        ]],
    )
    .unwrap();
    for (z, edge, vertex, sign) in [(0., bottom, low, -1.), (5., top, high, 1.)] {
        let plane = Surface::Plane(
            Plane::new(Plane {
                origin: Point3::new(0., 0., z),
                x: Vector3::x(),
                y: Vector3::y() * sign,
                domain: [interval(-3., 3.); 2],
                extents: [interval(-3., 3.); 2],
            })
            .unwrap(),
        );
        // The circle in uv; on the bottom its image runs the other way.
        let curve = Curve::Arc(
            Arc::new(Arc {
                center: Point2::origin(),
                x: nalgebra::Vector2::x(),
                y: nalgebra::Vector2::y(),
                z: nalgebra::Vector2::zeros(),
                radius: 2.,
                angle: interval(0., TAU),
                domain: interval(0., 1.),
            })
            .unwrap(),
        );
        b.face_with_trims(plane, vec![vec![trim([vertex, vertex], curve, edge)]])
            .unwrap();
    }
    b.build().unwrap()
}

#[test]
fn sound_parts_have_no_defects() {
    assert!(cube().is_closed());
    assert_eq!(cube().defects(), []);
    assert!(cylinder().is_closed());
    assert_eq!(cylinder().defects(), []);
    // The tilted tetrahedron: nothing is exact there.
    let mut b = BrepBuilder::new();
    for p in [
        [0.1, 0., 0.3],
        [1., 0.2, 0.],
        [0.3, 1.1, 0.],
        [0.3, 0.4, 0.9],
    ] {
        b.vertex(p);
    }
    for f in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
        b.planar_face(&f).unwrap();
    }
    let tetrahedron = b.build().unwrap();
    assert!(tetrahedron.is_closed());
    assert_eq!(tetrahedron.defects(), []);
    // Its normals point out: away from the middle.
    let middle = Point3::new(0.4, 0.4, 0.3);
    for f in 0..4 {
        let d = tetrahedron.surface(f).derivatives(0.1, 0.1, 1);
        let out = d.get(0, 0) - middle.coords;
        assert!(d.get(1, 0).cross(&d.get(0, 1)).dot(&out) > 0.0);
        assert!(!tetrahedron.faces()[f].reversed);
    }
}

#[test]
fn a_plane_facing_the_other_way_gives_a_reversed_face() {
    let mut b = BrepBuilder::new();
    for p in [[0., 0., 0.], [4., 0., 0.], [4., 4., 0.], [0., 4., 0.]] {
        b.vertex(p);
    }
    for p in [[1., 1., 0.], [1., 3., 0.], [3., 3., 0.], [3., 1., 0.]] {
        b.vertex(p);
    }
    // Parameters run over [0, 1]; the normal is -z.
    let plane = Plane::new(Plane {
        origin: Point3::origin(),
        x: Vector3::y(),
        y: Vector3::x(),
        domain: [interval(0., 1.); 2],
        extents: [interval(0., 4.); 2],
    })
    .unwrap();
    b.face(plane, &[&[0, 1, 2, 3], &[4, 5, 6, 7]]).unwrap();
    let sheet = b.build().unwrap();
    assert!(sheet.faces()[0].reversed && !sheet.is_closed());
    // A sheet has borders and nothing else to report; its loops run the right way in uv.
    let defects = sheet.defects();
    assert_eq!(defects.len(), 8);
    assert!(
        defects
            .iter()
            .all(|d| matches!(d, Defect::BoundaryEdge { .. }) && d.severity() == Severity::Note)
    );
    assert_eq!(
        sheet
            .parts()
            .loops
            .iter()
            .map(|l| l.kind)
            .collect::<Vec<_>>(),
        [LoopKind::Outer, LoopKind::Inner]
    );
}

#[test]
fn gaps_are_measured() {
    let found = after(|p| {
        let Curve::Line(line) = &mut p.curves2[0] else {
            unreachable!()
        };
        line.to.x -= 3e-7;
        line.to.y += 4e-7;
    });
    let gap = found
        .iter()
        .find_map(|d| match d {
            Defect::Gap {
                face: 0,
                trim_loop: 0,
                trims: [0, 1],
                count: 1,
                uv,
                space,
                ..
            } => Some((*uv, *space)),
            _ => None,
        })
        .unwrap();
    assert!(
        (gap.0 - 5e-7).abs() < 1e-15 && (gap.1 - 5e-7).abs() < 1e-15,
        "{gap:?}"
    );
    // The moved end is off its vertex and its edge as well, by as much as it moved.
    for d in &found {
        match d {
            Defect::VertexOffFace { distance, .. } => assert!((distance - 5e-7).abs() < 1e-15),
            Defect::EdgeOffSurface { distance, .. } => assert!((1e-8..=5.1e-7).contains(distance)),
            Defect::Gap { .. } => {}
            other => panic!("{other}"),
        }
    }
}

#[test]
fn trims_outside_the_domain() {
    let found = after(|p| {
        let Curve::Line(line) = &mut p.curves2[0] else {
            unreachable!()
        };
        line.to.y -= 0.25;
    });
    assert!(found.iter().any(|d| matches!(
        d,
        Defect::OutsideDomain { face: 0, trim: 0, uv } if *uv == 0.25
    )));
}

#[test]
fn tolerances_make_notes() {
    let severity = |tolerance| {
        after(|p| {
            p.vertices[0].point.z -= 1e-4;
            p.vertices[0].tolerance = tolerance;
        })
        .iter()
        .map(Defect::severity)
        .max()
    };
    assert_eq!(severity(None), Some(Severity::Warning));
    assert_eq!(severity(Some(1e-5)), Some(Severity::Warning));
    assert_eq!(severity(Some(1e-3)), Some(Severity::Note));
}

#[test]
fn vertices_off_edges_and_faces() {
    let found = after(|p| p.vertices[7].point.z += 0.125);
    // Three edges and three faces meet there; each of these has two trims that end there.
    let count =
        |f: fn(&Defect) -> Option<f64>| -> Vec<f64> { found.iter().filter_map(f).collect() };
    let edges = count(|d| match d {
        Defect::VertexOffEdge {
            vertex: 7,
            distance,
            ..
        } => Some(*distance),
        _ => None,
    });
    let faces = count(|d| match d {
        Defect::VertexOffFace {
            vertex: 7,
            distance,
            ..
        } => Some(*distance),
        _ => None,
    });
    assert_eq!((edges, faces), (vec![0.125; 3], vec![0.125; 6]));
    assert_eq!(found.len(), 9);
}

#[test]
fn orientation_goes_by_area() {
    let found = after(|p| {
        // The loop of face 0 run backwards.
        p.loops[0].trims.reverse();
        for t in 0..4 {
            p.trims[t].reversed = true;
            p.trims[t].vertices.reverse();
            p.trims[t].edge_reversed ^= true;
        }
    });
    assert_eq!(
        found,
        [Defect::Orientation {
            face: 0,
            trim_loop: 0,
            kind: LoopKind::Outer,
            area: -1.0,
        }]
    );
    let found = after(|p| p.loops[2].kind = LoopKind::Inner);
    assert!(matches!(
        found[..],
        [
            Defect::OuterLoops { face: 2, count: 0 },
            Defect::Orientation {
                face: 2,
                kind: LoopKind::Inner,
                ..
            }
        ]
    ));
    // The area of a circle, not only its sign.
    let mut parts = cylinder().parts().clone();
    let cap = parts.faces[1].loops.clone().unwrap()[0];
    parts.loops[cap].kind = LoopKind::Inner;
    let found = Brep::new(parts).unwrap().defects();
    let area = found.iter().find_map(|d| match d {
        Defect::Orientation { area, .. } => Some(*area),
        _ => None,
    });
    assert!((area.unwrap() - 4.0 * PI).abs() < 1e-13, "{area:?}");
}

#[test]
fn edges_off_their_surfaces() {
    let mut parts = cylinder().parts().clone();
    // The rim of the side bulges: the circle's radius is off by a millionth.
    let Curve::Arc(arc) = &mut parts.curves3[0] else {
        unreachable!()
    };
    arc.radius += 1e-6;
    let found = Brep::new(parts).unwrap().defects();
    let distances: Vec<f64> = found
        .iter()
        .filter_map(|d| match d {
            Defect::EdgeOffSurface {
                edge: 0, distance, ..
            } => Some(*distance),
            _ => None,
        })
        .collect();
    assert_eq!(distances.len(), 2);
    assert!(
        distances.iter().all(|d| (d - 1e-6).abs() < 1e-12),
        "{distances:?}"
    );
}

/// The trim has breaks of its own, so that its samples are not the edge's: next to the kink they are on the one leg or the other.
#[test]
fn edges_with_kinks_are_followed_on_both_sides() {
    let mut b = BrepBuilder::new();
    let v = [[0., 0., 0.], [2., -1., 0.], [4., 0., 0.]].map(|p| b.vertex(p));
    let at = |x: f64, y: f64| Vector4::new(x, y, 0., 1.);
    let points = vec![at(4., 0.), at(2., 3.), at(0., 0.)];
    let bent = NurbsCurve::new(1, points, vec![0., 0., 1., 2., 2.]).unwrap();
    let edge = b.edge([v[2], v[0]], Curve::Nurbs(bent)).unwrap();
    let plane = square(interval(-8., 8.));
    let path = [[4., 0.], [2.25, 2.625], [2., 3.], [1.875, 2.8125], [0., 0.]];
    let path = path.map(Point2::from).to_vec();
    let bent = Polyline::new(path, vec![0., 1., 2., 3., 4.]).unwrap();
    let straight = |from: usize, to: usize, a, b| TrimSpec {
        vertices: [v[from], v[to]],
        curve: line2(a, b),
        edge: None,
    };
    let trims = vec![
        straight(0, 1, [0., 0.], [2., -1.]),
        straight(1, 2, [2., -1.], [4., 0.]),
        TrimSpec {
            vertices: [v[2], v[0]],
            curve: Curve::Polyline(bent),
            edge: Some(edge),
        },
    ];
    b.face_with_trims(plane, vec![trims]).unwrap();
    let found = b.build().unwrap().defects();
    let off = |d: &Defect| matches!(d, Defect::EdgeOffSurface { .. });
    assert!(!found.iter().any(off), "{found:?}");
}

/// A serpentine whose trim runs at another speed than its edge: samples of the other runs are nearer than those of the own one.
#[test]
fn edges_are_followed_whatever_the_speed_of_their_trims() {
    let mut b = BrepBuilder::new();
    // Runs along x at four heights; the edge has many breaks on all but the second.
    let turns = [
        [0.0, 0.0],
        [8.0, 0.0],
        [8.0, 0.2],
        [0.0, 0.2],
        [0.0, 0.4],
        [8.0, 0.4],
        [8.0, 0.6],
        [0.0, 0.6],
    ];
    let mut edge_points = Vec::new();
    for w in turns.windows(2) {
        let long = w[0][1] == w[1][1] && w[0][1] != 0.2;
        let parts = if long { 16 } else { 1 };
        for k in 0..parts {
            let s = f64::from(k) / f64::from(parts);
            let at = |c: usize| w[0][c] + s * (w[1][c] - w[0][c]);
            edge_points.push(Vector4::new(at(0), at(1), 0., 1.));
        }
    }
    edge_points.push(Vector4::new(0., 0.6, 0., 1.));
    let count = edge_points.len();
    let mut knots: Vec<f64> = (0..count).map(|k| k as f64).collect();
    knots.insert(0, 0.0);
    knots.push((count - 1) as f64);
    let v = [[0., 0., 0.], [0., 0.6, 0.], [-1., 0.3, 0.]].map(|p| b.vertex(p));
    let bent = NurbsCurve::new(1, edge_points, knots).unwrap();
    let edge = b.edge([v[0], v[1]], Curve::Nurbs(bent)).unwrap();
    let plane = square(interval(-16., 16.));
    // A third of the way along each run it changes its speed.
    let mut path = vec![Point2::from(turns[0])];
    let mut at = vec![0.0];
    for w in turns.windows(2) {
        let third = |c: usize| w[0][c] + (w[1][c] - w[0][c]) / 3.0;
        path.push(Point2::new(third(0), third(1)));
        path.push(Point2::from(w[1]));
        let t = at.len() as f64;
        at.extend([t, t + 1.0]);
    }
    let bent = Polyline::new(path, at).unwrap();
    let straight = |from: usize, to: usize, a, b| TrimSpec {
        vertices: [v[from], v[to]],
        curve: line2(a, b),
        edge: None,
    };
    let trims = vec![
        TrimSpec {
            vertices: [v[0], v[1]],
            curve: Curve::Polyline(bent),
            edge: Some(edge),
        },
        straight(1, 2, [0., 0.6], [-1., 0.3]),
        straight(2, 0, [-1., 0.3], [0., 0.]),
    ];
    b.face_with_trims(plane, vec![trims]).unwrap();
    let brep = b.build().unwrap();
    let found = brep.defects();
    let off = |d: &Defect| matches!(d, Defect::EdgeOffSurface { .. });
    assert!(!found.iter().any(off), "{found:?}");
    for e in PreparedBrep::new(brep).health().edges {
        for o in e.offsets {
            assert!(o.about.is_none_or(|about| about <= o.at_most), "{o:?}");
        }
    }
}

/// Near where a closed edge closes, the nearest sample may be at its other end.
#[test]
fn closed_edges_close() {
    let mut parts = cylinder().parts().clone();
    let circle = parts.curves3[0].to_nurbs().unwrap().nurbs;
    let mut points = circle.control_points().to_vec();
    *points.last_mut().unwrap() = points[0];
    let knots = circle.knots().knots().to_vec();
    parts.curves3[0] = Curve::Nurbs(NurbsCurve::new(2, points, knots).unwrap());
    assert_eq!(Brep::new(parts).unwrap().defects(), []);
}

#[test]
fn frames_are_measured() {
    let found = after(|p| {
        let Surface::Plane(s) = &mut p.surfaces[0] else {
            unreachable!()
        };
        s.x *= 1.0 + 1e-9;
    });
    let off = found.iter().find_map(|d| match d {
        Defect::Frame {
            owner: Part::Face(0),
            off,
            ..
        } => Some(*off),
        _ => None,
    });
    assert!((off.unwrap() - 1e-9).abs() < 1e-15);
    let mut parts = cylinder().parts().clone();
    let Curve::Arc(arc) = &mut parts.curves3[1] else {
        unreachable!()
    };
    arc.y = -arc.y;
    let found = Brep::new(parts).unwrap().defects();
    assert!(
        matches!(found[..], [Defect::Frame { owner: Part::Edge(1), off, .. }] if off == 2.0),
        "{found:?}"
    );
}

#[test]
fn how_often_edges_are_used() {
    let found = after(|p| {
        // Face 5 lost: four open edges. (Its loop stays, and says it belongs to a face that is not there.)
        p.faces[5].loops = Some(Vec::new());
    });
    assert!(found.iter().any(|d| matches!(
        d,
        Defect::BackReference {
            from: Part::Loop(5),
            to: Part::Face(5)
        }
    )));
    let mut b = BrepBuilder::new();
    for p in [
        [0., 0., 0.],
        [1., 0., 0.],
        [0., 1., 0.],
        [0., 0., 1.],
        [0., -1., 0.],
    ] {
        b.vertex(p);
    }
    for top in [2, 3, 4] {
        b.planar_face(&[0, 1, top]).unwrap();
    }
    let book = b.build().unwrap();
    let worst: Vec<_> = book
        .defects()
        .into_iter()
        .filter(|d| d.severity() == Severity::Error)
        .collect();
    assert_eq!(worst, [Defect::NonManifoldEdge { edge: 0, uses: 3 }]);
    assert!(!book.is_closed());
}

#[test]
fn references_go_both_ways() {
    let back = |change: fn(&mut BrepParts)| -> Vec<(Part, Part)> {
        after(change)
            .into_iter()
            .filter_map(|d| match d {
                Defect::BackReference { from, to } => Some((from, to)),
                _ => None,
            })
            .collect()
    };
    assert_eq!(
        back(|p| p.trims[3].edge = Some(7)),
        [
            (Part::Edge(3), Part::Trim(3)),
            (Part::Trim(3), Part::Edge(7))
        ]
    );
    assert_eq!(
        back(|p| p.edges[2].trims.push(2)),
        [(Part::Edge(2), Part::Trim(2))]
    );
    assert_eq!(back(|p| p.vertices[0].edges.clear()).len(), 3);
    assert_eq!(
        back(|p| p.trims[0].trim_loop = 1),
        [
            (Part::Trim(0), Part::Loop(1)),
            (Part::Loop(0), Part::Trim(0))
        ]
    );
}

#[test]
fn singular_trims_must_be_points() {
    let found = after(|p| {
        p.trims[0].edge = None;
    });
    let size = found.iter().find_map(|d| match d {
        Defect::SingularTrim { trim: 0, size, .. } => Some(*size),
        _ => None,
    });
    assert_eq!(size, Some(1.0));
}

#[test]
fn bad_building_is_refused() {
    let mut b = BrepBuilder::new();
    for p in [[0., 0., 0.], [1., 0., 0.], [2., 0., 0.]] {
        b.vertex(p);
    }
    assert_eq!(b.planar_face(&[0, 1, 2]), Err(BuildError::NoArea));
    assert!(matches!(
        b.planar_face(&[0, 1]),
        Err(BuildError::Loop { .. })
    ));
    assert!(matches!(
        b.planar_face(&[0, 1, 9]),
        Err(BuildError::Vertex {
            vertex: 9,
            count: 3
        })
    ));
    assert!(matches!(
        b.straight_edge([0, 5]),
        Err(BuildError::Vertex { .. })
    ));
    let nan = b.vertex([f64::NAN, 0., 0.]);
    assert!(b.planar_face(&[0, 1, nan]).is_err());
    assert!(b.build().is_err());
}

#[test]
fn one_surface_is_a_brep() {
    let surface = cylinder().surface(0).clone();
    let whole = Brep::from_surface(surface).unwrap();
    assert!(whole.faces()[0].loops.is_none());
    assert_eq!(whole.defects(), []);
}

/// Weights of a prepared BREP are multiplied by powers of two where that leaves them in range: not where they are at both ends of it already.
#[test]
fn scaled_weights_stay_in_range() {
    const LARGEST: f64 = LARGEST_COORDINATE;
    for (weights, is_scaled) in [
        ([LARGEST, 1.0], true),
        ([LARGEST, 1.0 / LARGEST], false),
        ([1.0 / LARGEST, LARGEST], false),
    ] {
        // Homogeneous coordinates are in range whatever the weight.
        let net = (0..4u8).map(|k| {
            let w = weights[usize::from(k % 2)];
            let part = w.min(1.0);
            Vector4::new(f64::from(k / 2) * part, f64::from(k % 2) * part, 0.0, w)
        });
        let knots = || vec![0.0, 0.0, 1.0, 1.0];
        let net = net.collect();
        let surface = NurbsSurface::new([1, 1], [2, 2], net, [knots(), knots()]).unwrap();
        let given = Brep::from_surface(Surface::Nurbs(surface)).unwrap();
        let prepared = PreparedBrep::new(given.clone());
        assert_eq!(prepared.brep() != &given, is_scaled, "{weights:?}");
    }
}

#[test]
fn defects_read_as_sentences() {
    let found = after(|p| {
        p.vertices[7].point.z += 0.125;
        p.vertices[7].tolerance = Some(0.01);
    });
    assert_eq!(
        found.last().unwrap().to_string(),
        "vertex 7: 1.250e-1 model units off the end of edge 11 (the file allows 0.01)"
    );
}
