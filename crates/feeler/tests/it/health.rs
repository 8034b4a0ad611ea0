//! Health reports of parts with one thing wrong, whose size is known.

use crate::scenes::{self, cube};
use feeler::brep::{Brep, BrepBuilder, BrepParts, Defect, TrimSpec};
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Line, NurbsCurve, NurbsSurface, Plane, Surface};
use feeler::prepare::{Direction, Health, PreparedBrep, Turn, Undefined};
use feeler::trim::MeetingKind;
use nalgebra::{Point2, Point3, Vector3, Vector4};

/// What the bound of a Frechet distance may be above the true one: `prepare::matching` stops there.
const GOOD: f64 = 1.125;

fn interval(start: f64, end: f64) -> Interval {
    Interval::new(start, end).unwrap()
}

fn health(brep: Brep) -> Health {
    PreparedBrep::new(brep).health()
}

/// The cube's health after a change.
fn after(change: impl FnOnce(&mut BrepParts)) -> Health {
    let mut parts = cube().parts().clone();
    change(&mut parts);
    health(Brep::new(parts).unwrap())
}

/// Edges of the bottom, face 0.
fn bottom() -> Vec<usize> {
    let cube = cube();
    let p = cube.parts();
    let trims = &p.loops[0].trims;
    trims.iter().filter_map(|t| p.trims[*t].edge).collect()
}

/// A cylinder of radius 2 and height 5 with both caps, its edges' circles in space of another radius.
fn cylinder(edge_radius: f64) -> Brep {
    scenes::cylinder([0.; 3], [2., edge_radius], 5., 1.5)
}

/// A flat sheet with these corners, at height 0; its edges are the given corners' sides.
fn sheet(corners: &[[f64; 2]]) -> Brep {
    let mut b = BrepBuilder::new();
    let at: Vec<usize> = corners.iter().map(|c| b.vertex([c[0], c[1], 0.])).collect();
    let plane = Plane::new(Plane {
        origin: Point3::origin(),
        x: Vector3::x(),
        y: Vector3::y(),
        domain: [interval(-8., 8.); 2],
        extents: [interval(-8., 8.); 2],
    });
    b.face(plane.unwrap(), &[&at]).unwrap();
    b.build().unwrap()
}

#[test]
fn sound_parts() {
    for (name, part) in [("cube", cube()), ("cylinder", cylinder(2.))] {
        let h = health(part);
        assert!(h.is_closed && h.undefined.is_empty(), "{name}: {h:#?}");
        assert!(h.defects.is_empty(), "{name}: {:?}", h.defects);
        for f in &h.faces {
            assert!(
                !f.is_sliver() && f.own_meetings().next().is_none(),
                "{name} {f:?}"
            );
            for l in &f.loops {
                assert_eq!(l.turn, Turn::CounterClockwise);
                assert!(l.widest_gap().is_none_or(|g| g.space.hi <= h.rounding));
            }
        }
        for e in &h.edges {
            assert_eq!(e.direction, Direction::Fits, "{name} {e:?}");
            assert!(!e.is_tiny && e.faces.len() == 2);
            assert!(e.crack.hi <= h.rounding, "{name} {e:?}");
            assert!(
                e.worst_offset().unwrap().at_most <= h.rounding,
                "{name} {e:?}"
            );
        }
    }
    // Sizes as they are: the unit square has area 1 and a border of 4; a disc of radius 2 and the side of the cylinder more.
    let h = health(cube());
    let f = &h.faces[3];
    assert!(f.area >= 1.0 && (3.99..=4.0).contains(&f.border), "{f:?}");
    assert!(h.edges[0].reach >= 1.0 && h.edges[0].reach <= 1.0 + 1e-9);
}

#[test]
fn gaps() {
    // The end of a side, moved by 2^-12 times (3, 4): the plane's axes are orthonormal.
    let by = 1. / 4096.;
    let h = after(|p| {
        let Curve::Line(line) = &mut p.curves2[0] else {
            unreachable!()
        };
        line.to.x -= 3. * by;
        line.to.y += 4. * by;
    });
    let gaps = &h.faces[0].loops[0].gaps;
    assert_eq!(gaps.len(), 1);
    let g = &gaps[0];
    assert_eq!(g.after, 0);
    for size in [g.uv, g.space] {
        assert!(size.contains(5. * by) && size.width() < h.rounding, "{g:?}");
    }
    assert!(h.undefined.contains(&Undefined::InGaps(1)));
    // The crack: both ends of the side are matched with those of its mate, one of them that far.
    let edge = &h.edges[bottom()[0]];
    assert!(
        edge.crack.lo >= 5. * by - 1e-14 && edge.crack.hi <= 5. * by * GOOD,
        "{edge:?}"
    );
    for l in h.faces[1..].iter().flat_map(|f| &f.loops) {
        assert!(l.gaps.is_empty());
    }
}

#[test]
fn cracks() {
    // The bottom, lowered: its images are parallel segments.
    let by = 1. / 1024.;
    let h = after(|p| {
        let Surface::Plane(plane) = &mut p.surfaces[0] else {
            unreachable!()
        };
        plane.origin.z -= by;
    });
    let cracked = bottom();
    for e in &h.edges {
        if cracked.contains(&e.edge) {
            assert!(e.crack.lo <= by && by <= e.crack.hi, "{e:?}");
            assert!(
                e.crack.lo >= by * (1. - 1e-12) && e.crack.hi <= by * GOOD,
                "{e:?}"
            );
            // Its own trim is off the curve, its mate's is not.
            let off: Vec<bool> = e.offsets.iter().map(|o| o.at_most >= by).collect();
            assert_eq!(off.iter().filter(|x| **x).count(), 1, "{e:?}");
        } else {
            assert!(e.crack.hi <= h.rounding, "{e:?}");
        }
    }
    let told: Vec<f64> = h
        .undefined
        .iter()
        .filter_map(|u| match u {
            Undefined::NearCracks(width) => Some(*width),
            _ => None,
        })
        .collect();
    assert!(told.len() == 1 && (by..=by * GOOD).contains(&told[0]));
}

#[test]
fn edge_curves_off_their_trims() {
    // Circles about one centre are as far apart as their radii.
    let by = 1. / 256.;
    let h = health(cylinder(2. + by));
    for edge in [0, 1] {
        let e = &h.edges[edge];
        assert_eq!(e.offsets.len(), 2);
        for o in &e.offsets {
            assert!(by <= o.at_most && o.at_most <= by * GOOD, "{o:?}");
            assert!((o.about.unwrap() - by).abs() < 1e-9);
        }
        // That is no crack between the faces.
        assert!(e.crack.hi <= h.rounding, "{e:?}");
    }
    // A side as a parabola of height 1/64: its top is that far from the straight image, and no point is farther from the one above it.
    let high = 1. / 64.;
    let edge = bottom()[0];
    let h = after(|p| {
        let curve = p.edges[edge].curve.unwrap();
        let Curve::Line(line) = &p.curves3[curve] else {
            unreachable!()
        };
        let (a, b) = (line.from.coords, line.to.coords);
        let top = 0.5 * (a + b) - Vector3::z() * (2. * high);
        let points = [a, top, b]
            .map(|x| Vector4::new(x.x, x.y, x.z, 1.))
            .to_vec();
        let bent = NurbsCurve::new(2, points, vec![0., 0., 0., 1., 1., 1.]);
        p.curves3[curve] = Curve::Nurbs(bent.unwrap());
    });
    for o in &h.edges[edge].offsets {
        assert!(high <= o.at_most && o.at_most <= high * GOOD, "{o:?}");
    }
}

/// A quarter of a cylinder of radius 1 about y, from y = 0 on, whose second span is 4e-8 long beside parameters of 84: a rounding of them is much of it. Its edges' curves are
/// those of its border, the straight ones lowered by `by`, and one trim waves by 2e-13 in v, as trims do that were computed.
fn short_span(by: f64) -> Brep {
    let (a, d) = (83.6613993513201, 84.7655501742753);
    let ends = [a, a + 4.2e-8, 84.0400520881385, d];
    let mut knots = vec![a; 4];
    knots.extend([[ends[1]; 3], [ends[2]; 3]].concat());
    knots.extend([d; 4]);
    // y = v - a: control points of the spans in thirds.
    let mut ys = vec![0.];
    for e in ends.windows(2) {
        ys.extend([1., 2., 3.].map(|k| e[0] - a + (e[1] - e[0]) * k / 3.));
    }
    let w = std::f64::consts::FRAC_1_SQRT_2;
    let quarter = [[1., 0., 1.], [w, w, w], [0., 1., 1.]];
    let net = { quarter.iter() }
        .flat_map(|[x, z, w]| ys.iter().map(move |y| Vector4::new(*x, y * w, *z, *w)));
    let count = ys.len();
    let knots = [vec![0., 0., 0., 1., 1., 1.], knots];
    let surface = NurbsSurface::new([2, 3], [3, count], net.collect(), knots).unwrap();
    let mut b = BrepBuilder::new();
    let length = ys[ys.len() - 1];
    let corners = [
        [1., 0., 0.],
        [0., 0., 1.],
        [0., length, 1.],
        [1., length, 0.],
    ];
    let vertices = corners.map(|c| b.vertex(c));
    let arc = |y: f64| {
        let points = quarter
            .map(|[x, z, w]| Vector4::new(x, y * w, z, w))
            .to_vec();
        Curve::Nurbs(NurbsCurve::new(2, points, vec![0., 0., 0., 1., 1., 1.]).unwrap())
    };
    let straight = |from: [f64; 3], to: [f64; 3]| {
        let [from, to] = [from, to].map(|p| Point3::new(p[0], p[1], p[2] - by));
        Curve::Line(Line::new(from, to, interval(0., 1.)).unwrap())
    };
    let curves = [
        arc(0.),
        straight(corners[1], corners[2]),
        arc(length),
        straight(corners[0], corners[3]),
    ];
    let ends = [[0, 1], [1, 2], [3, 2], [0, 3]];
    let in_uv = [
        [[0., a], [1., a]],
        [[1., a], [1., d]],
        [[1., d], [0., d]],
        [[0., d], [0., a]],
    ];
    let trims = (0..4).map(|k| {
        let [p, q] = in_uv[k].map(|p| Point2::new(p[0], p[1]));
        let edge = b
            .edge(ends[k].map(|i| vertices[i]), curves[k].clone())
            .unwrap();
        let curve = match k {
            0 => {
                let points = [p.x, 0.5, q.x]
                    .map(|x| Vector3::new(x, if x == 0.5 { a + 4e-13 } else { a }, 1.));
                let wave = NurbsCurve::new(2, points.to_vec(), vec![0., 0., 0., 1., 1., 1.]);
                Curve::Nurbs(wave.unwrap())
            }
            _ => Curve::Line(Line::new(p, q, interval(0., 1.)).unwrap()),
        };
        TrimSpec {
            vertices: [vertices[k], vertices[(k + 1) % 4]],
            curve,
            edge: Some(edge),
        }
    });
    let trims = trims.collect();
    b.face_with_trims(Surface::Nurbs(surface), vec![trims])
        .unwrap();
    b.build().unwrap()
}

#[test]
fn edges_over_short_spans() {
    /// The wave and some thousand roundings of parameters of 84.
    const NEAR: f64 = 1e-11;
    for e in &health(short_span(0.)).edges {
        assert!(e.offsets[0].at_most <= NEAR, "{e:?}");
    }
    let by = 1. / 65536.;
    let lowered = health(short_span(by)).edges;
    for e in [&lowered[1], &lowered[3]] {
        let o = &e.offsets[0];
        assert!(by <= o.at_most && o.at_most <= by * GOOD, "{o:?}");
    }
}

#[test]
fn faces_inside_out() {
    let h = after(|p| p.faces[0].reversed = true);
    let against = bottom();
    for e in &h.edges {
        let is = if against.contains(&e.edge) {
            Direction::Against
        } else {
            Direction::Fits
        };
        assert_eq!(e.direction, is, "{e:?}");
    }
    assert_eq!(h.undefined, [Undefined::Normals(4)]);
    // What the file says of a trim's direction along its edge does not count where the ends tell.
    let h = after(|p| p.trims[0].edge_reversed ^= true);
    assert!(h.edges.iter().all(|e| e.direction == Direction::Fits));
    // Nor of a circle, whose ends do not tell, but whose images do.
    let mut parts = cylinder(2.).parts().clone();
    for t in &mut parts.trims {
        t.edge_reversed ^= t.edge == Some(0) && t.trim_loop == 0;
    }
    let h = health(Brep::new(parts).unwrap());
    assert!(h.edges.iter().all(|e| e.direction == Direction::Fits));
    // The bottom inside out.
    let mut parts = cylinder(2.).parts().clone();
    parts.faces[1].reversed = true;
    let h = health(Brep::new(parts).unwrap());
    let told: Vec<_> = h.edges.iter().map(|e| e.direction).collect();
    assert_eq!(told, [Direction::Against, Direction::Fits, Direction::Fits]);
}

#[test]
fn loops_turned_wrong() {
    let h = after(|p| {
        p.loops[0].trims.reverse();
        for t in 0..4 {
            p.trims[t].reversed = true;
            p.trims[t].vertices.reverse();
            p.trims[t].edge_reversed ^= true;
        }
    });
    let l = &h.faces[0].loops[0];
    assert!(l.turn == Turn::Clockwise && l.is_turned_wrong());
    assert!(l.area.contains(-1.) && l.area.width() < 1e-12);
    let wrong = h.faces.iter().flat_map(|f| &f.loops);
    assert_eq!(wrong.filter(|l| l.is_turned_wrong()).count(), 1);
    let unknown = bottom();
    for e in &h.edges {
        assert_eq!(e.direction == Direction::Unknown, unknown.contains(&e.edge));
    }
}

#[test]
fn loops_that_cross() {
    // y = x and y = 1 - x, and a little more area on one side so that the loop has a turn.
    let h = health(sheet(&[[0., 0.], [1., 1.], [1., 0.], [0., 2.]]));
    let found: Vec<_> = h.faces[0].own_meetings().collect();
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].kind, MeetingKind::Crossing);
    // y = x and y = 2 - 2x.
    for k in 0..2 {
        let [lo, hi] = found[0].place[k];
        assert!(lo <= 2. / 3. && 2. / 3. <= hi);
    }
    assert!(h.undefined.contains(&Undefined::CrossedLoops(1)));
    assert_eq!(h.faces[0].area, f64::INFINITY);
}

#[test]
fn naked_and_non_manifold_edges() {
    let mut open = BrepBuilder::new();
    for i in 0..4 {
        open.vertex([f64::from(i & 1), f64::from(i >> 1), 0.]);
    }
    open.vertex([0., 0., 1.]);
    open.vertex([1., 0., 1.]);
    open.vertex([0., -1., 0.]);
    open.vertex([1., -1., 0.]);
    // Three pages at the edge from vertex 0 to 1.
    for corners in [[0, 1, 3, 2], [1, 0, 4, 5], [0, 1, 7, 6]] {
        open.planar_face(&corners).unwrap();
    }
    let h = health(open.build().unwrap());
    assert!(!h.is_closed && h.undefined.contains(&Undefined::Material));
    let uses = |n: usize| h.edges.iter().filter(|e| e.faces.len() == n).count();
    assert_eq!((uses(1), uses(3)), (9, 1));
    for e in &h.edges {
        assert_eq!(e.is_naked(), e.faces.len() == 1);
        assert_eq!(e.is_non_manifold(), e.faces.len() == 3);
        assert_eq!(e.direction, Direction::NotTwo);
    }
}

#[test]
fn tiny_edges_and_slivers() {
    // A corner cut off by 2^-24, on a sheet whose plane is of size 16.
    let cut = 1. / f64::from(1 << 24);
    let h = health(sheet(&[
        [0., 0.],
        [1., 0.],
        [1., 1. - cut],
        [1. - cut, 1.],
        [0., 1.],
    ]));
    let tiny: Vec<usize> = h
        .edges
        .iter()
        .filter(|e| e.is_tiny)
        .map(|e| e.edge)
        .collect();
    assert_eq!(tiny, [2]);
    let reach = h.edges[2].reach;
    assert!(
        reach >= cut * std::f64::consts::SQRT_2 && reach <= 2. * cut,
        "{reach:e}"
    );

    // Strips 1 long and w wide have a mean width of w / (1 + w).
    for (w, is) in [(1. / 4096., true), (1. / 64., false)] {
        let h = health(sheet(&[[0., 0.], [1., 0.], [1., w], [0., w]]));
        let f = &h.faces[0];
        let mean = w / (1. + w);
        // A bound from above: that of a plane's slopes is off by `PAST` in each direction.
        assert!(
            f.mean_width() >= mean && f.mean_width() <= 1.5 * mean,
            "{f:?}"
        );
        assert_eq!(f.is_sliver(), is);
    }
}

#[test]
fn frames_are_kept_among_the_defects() {
    let h = after(|p| {
        let Surface::Plane(plane) = &mut p.surfaces[0] else {
            unreachable!()
        };
        plane.x *= 1. + 1. / 1024.;
    });
    let off = h.defects.iter().find_map(|d| match d {
        Defect::Frame { off, .. } => Some(*off),
        _ => None,
    });
    assert!((off.unwrap() - 1. / 1024.).abs() < 1e-15);
}
