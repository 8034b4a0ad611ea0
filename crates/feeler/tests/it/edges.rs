//! Lines next to where faces end: beside the cracks of edges, and beside trims by less than f64 tells; balls next to where a trim leaves its surface.

use crate::scenes::{loop_face, polygon_face};
use feeler::brep::{BrepBuilder, TrimSpec};
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Line, NurbsCurve, NurbsSurface, Plane, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, Feature, HalfSpace, LineAnswer, LineKind, LineProbe, Options, Probe, Sphere,
    Workspace, contact, line,
};
use nalgebra::{Point2, Point3, Vector3, Vector4};

fn ask(brep: &PreparedBrep, origin: [f64; 3], direction: [f64; 3]) -> LineAnswer {
    let probe = LineProbe::new(
        Point3::from(origin),
        Vector3::from(direction),
        LineKind::Line,
    );
    let (options, mut workspace) = (Options::default(), Workspace::default());
    line(brep, &probe.unwrap(), &options, &mut workspace)
}

fn trim(vertices: [usize; 2], [a, b]: [[f64; 2]; 2], edge: Option<usize>) -> TrimSpec {
    let unit = Interval::new(0.0, 1.0).unwrap();
    let line = Line::new(Point2::from(a), Point2::from(b), unit);
    TrimSpec {
        vertices,
        curve: Curve::Line(line.unwrap()),
        edge,
    }
}

/// Two slopes down from a ridge along y that should be one line: of the one at `z = 0`, of the other at `z = gap`. They fall by 4 on 3.
fn roof(gap: f64) -> PreparedBrep {
    let mut b = BrepBuilder::new();
    let points = [
        [0.0, -1.0, 0.0],
        [0.0, 1.0, 0.0],
        [-0.6, 1.0, -0.8],
        [-0.6, -1.0, -0.8],
        [0.6, -1.0, gap - 0.8],
        [0.6, 1.0, gap - 0.8],
    ];
    let v = points.map(|p| b.vertex(p));
    let edge = b.straight_edge([v[0], v[1]]).unwrap();
    let domain = Interval::new(-2.0, 2.0).unwrap();
    let slope = |z: f64, x: f64| {
        Surface::Plane(
            Plane::new(Plane {
                origin: Point3::new(0.0, 0.0, z),
                x: Vector3::new(x, 0.0, -0.8),
                y: Vector3::y(),
                domain: [domain; 2],
                extents: [domain; 2],
            })
            .unwrap(),
        )
    };
    let [a, z, y, x] = [[0.0, -1.0], [0.0, 1.0], [1.0, 1.0], [1.0, -1.0]];
    let left = [
        trim([v[0], v[1]], [a, z], Some(edge)),
        trim([v[1], v[2]], [z, y], None),
        trim([v[2], v[3]], [y, x], None),
        trim([v[3], v[0]], [x, a], None),
    ];
    let right = [
        trim([v[1], v[0]], [z, a], Some(edge)),
        trim([v[0], v[4]], [a, x], None),
        trim([v[4], v[5]], [x, y], None),
        trim([v[5], v[1]], [y, z], None),
    ];
    b.face_with_trims(slope(0.0, -0.6), vec![left.to_vec()])
        .unwrap();
    b.face_with_trims(slope(gap, 0.6), vec![right.to_vec()])
        .unwrap();
    PreparedBrep::new(b.build().unwrap())
}

/// Across a roof at `z = -h`, all lengths in widths of the ridge's crack: the left slope is met at `h / 0.8` from its end, the right one at `3/4 (h + 1)` aside of that. The line is
/// in the crack where `h` is below 1; the hits that are within 1 of an end are in that passage, and count once.
#[test]
fn hits_beside_a_crack_count_once_within_its_width_alone() {
    for k in [10, 20, 30] {
        let gap = 0.5f64.powi(k);
        let brep = roof(gap);
        let width = [brep.least_crack_width(0), brep.fine_crack_width(0)];
        assert!(
            width[0] > 0.99 * gap && width[1] < 1.01 * gap,
            "{gap} {width:?}"
        );
        for (h, hits, crossings, in_crack) in [
            (-0.4, 1, 1, false),
            // 0.25 and 0.92 from the left slope's end.
            (0.2, 2, 1, false),
            // 0.63 and 1.23.
            (0.5, 2, 2, false),
            // 1.13 and 1.69: neither is in the passage.
            (0.9, 2, 2, true),
            (1.2, 2, 2, false),
            (3.0, 2, 2, false),
        ] {
            let answer = ask(&brep, [0.0, 0.25, -h * gap], [1.0, 0.0, 0.0]);
            let told = (answer.undecided, answer.hits.len(), answer.crossings);
            assert_eq!(told, (None, hits, Some(crossings)), "{k} {h}");
            assert_eq!(answer.in_crack, in_crack, "{k} {h}");
        }
    }
}

/// Of `z = x^2` over `[-1, 1] x [0, 1]` what is left of `x = 1/2 - y`: along `y = 1/2` that is `x < 0`. A steep line at `x = e` meets it where `e` is negative, and
/// nowhere where it is positive, however small it is: or that is said to be open.
#[test]
fn lines_beside_a_trim() {
    let net = [(-1.0, 1.0), (0.0, -1.0), (1.0, 1.0)];
    let net = net
        .iter()
        .flat_map(|(x, z)| [0.0, 1.0].map(|y| Vector4::new(*x, y, *z, 1.0)));
    let knots = [vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
    let surface = NurbsSurface::new([2, 1], [3, 2], net.collect(), knots).unwrap();
    let corners = [[0.0, 0.0], [0.75, 0.0], [0.25, 1.0], [0.0, 1.0]];
    let mut b = BrepBuilder::new();
    let v = corners.map(|[u, v]| {
        let x = 2.0 * u - 1.0;
        b.vertex([x, v, x * x])
    });
    let next = |i: usize| (i + 1) % 4;
    let loops = (0..4).map(|i| trim([v[i], v[next(i)]], [corners[i], corners[next(i)]], None));
    b.face_with_trims(Surface::Nurbs(surface), vec![loops.collect()])
        .unwrap();
    let brep = PreparedBrep::new(b.build().unwrap());
    let mut told = 0;
    for k in 1..130 {
        for d in [[0.0, 0.0, 1.0], [0.0, 0.25, 1.0], [0.0, -0.5, 2.0]] {
            for sign in [1.0, -1.0] {
                let e = sign * 0.5f64.powi(k);
                // At z = e^2 where the line is at y = 1/2; on it the trim is at x = 0 there, exactly.
                let answer = ask(&brep, [e, 0.5, 0.0], d);
                // Elsewhere than at y = 1/2 the face ends elsewhere: by what y moves.
                let shift = e * e * d[1] / d[2];
                let inside = e + shift < 0.0;
                if answer.undecided.is_some() {
                    continue;
                }
                told += 1;
                assert_eq!(answer.hits.len(), usize::from(inside), "{e:e} {d:?}");
            }
        }
    }
    // What f64 tells is told.
    assert!(told > 6 * 45, "{told}");
}

/// A trim along `u = t' (1 - 2048 t')` but for `off`, with `t' = 1 - t`, leaves the domain at `t' = 1/2048`, which halving reaches, before that by next to
/// nothing: what goes on from there is all outside. The nearest point is where it leaves; v has few digits, so that no point of f64 is near it.
#[test]
fn a_ball_is_nearest_to_where_a_trim_leaves_the_domain() {
    let far = 2f64.powi(40);
    let b = 1433.0 / 4096.0;
    for (off, weight) in [(-98, 0), (-85, 0), (-60, 0), (-82, -30)] {
        let (e, w) = (2f64.powi(off + 22), 2f64.powi(weight));
        let net = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];
        let net = net.map(|[x, y]| Vector4::new(x, y, 0.5 * x * y, 1.0));
        let ends = |a: f64| vec![a, a, a + 1.0, a + 1.0];
        let surface = NurbsSurface::new([1, 1], [2, 2], net.to_vec(), [ends(0.0), ends(far)]);
        let points = [[-e, far + 2.0 * b], [-1023.5, far + b], [1.0, far]];
        let curve = NurbsCurve::new(
            2,
            points.map(|[u, v]| Vector3::new(u * w, v * w, w)).to_vec(),
            vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
        );
        let mut builder = BrepBuilder::new();
        let v = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 2.0 * b, 0.0]].map(|p| builder.vertex(p));
        let trims = vec![
            trim([v[0], v[1]], [[1.0, far], [1.0, far + 1.0]], None),
            trim([v[1], v[2]], [[1.0, far + 1.0], points[0]], None),
            TrimSpec {
                vertices: [v[2], v[0]],
                curve: Curve::Nurbs(curve.unwrap()),
                edge: None,
            },
        ];
        let surface = Surface::Nurbs(surface.unwrap());
        builder.face_with_trims(surface, vec![trims]).unwrap();
        let brep = PreparedBrep::new(builder.build().unwrap());
        let (center, radius) = (Point3::new(-1.0, -1.0, 0.0), 0.5);
        let probe = Probe::Sphere(Sphere::new(center, radius).unwrap());
        // It leaves within `off` of that.
        let truth = (1.0 + (1.0 + b / 1024.0).powi(2)).sqrt() - radius;
        for accuracy in [Accuracy::Full, Accuracy::Length(1e-9)] {
            let options = Options {
                accuracy,
                ..Options::default()
            };
            let found = contact(&brep, &probe, &options, &mut Workspace::default());
            let bounds = found.separation.bounds;
            let slack = 4.0 * f64::EPSILON + 2f64.powi(off + 2);
            assert!(
                bounds.lo <= truth + slack && truth - slack <= bounds.hi,
                "{off} {weight}: {bounds:?}, not {truth}"
            );
        }
    }
}

/// A straight trim drawn in degree 10 on a surface of degrees 7 and 6 bounds a ball's distance as the same one does that is drawn in degree 1.
#[test]
fn a_trim_of_a_high_degree_on_a_surface_of_a_high_degree() {
    let net = (0..8)
        .flat_map(|i| (0..7).map(move |j| (i, j)))
        .map(|(i, j)| {
            let z = f64::from((5 * i * i + 3 * i * j + 7 * j) % 11) / 16.0;
            Vector4::new(f64::from(i), f64::from(j), z, 1.0)
        });
    let bezier = |p: usize| [vec![0.0; p + 1], vec![1.0; p + 1]].concat();
    let knots = [bezier(7), bezier(6)];
    let surface = NurbsSurface::new([7, 6], [8, 7], net.collect(), knots);
    let surface = Surface::Nurbs(surface.unwrap());
    let side = |a: [f64; 2], b: [f64; 2], degree: usize| {
        let at = |k: usize| {
            let t = k as f64 / degree as f64;
            Vector3::new(a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), 1.0)
        };
        let points = (0..=degree).map(at).collect();
        Curve::Nurbs(NurbsCurve::new(degree, points, bezier(degree)).unwrap())
    };
    let corners = [[0.0, 0.5], [1.0, 0.5], [1.0, 1.0], [0.0, 1.0]];
    let face = |degree: usize| {
        let sides = (0..4).map(|i| {
            side(
                corners[i],
                corners[(i + 1) % 4],
                if i == 0 { degree } else { 1 },
            )
        });
        let at = corners.map(|c| surface.point(c[0], c[1]));
        PreparedBrep::new(loop_face(&surface, sides.collect(), at.to_vec()))
    };
    let (high, low) = (face(10), face(1));
    for center in [[2.0, 1.0, 3.0], [5.5, 2.0, -1.0], [3.5, 2.5, 0.5]] {
        let probe = Probe::Sphere(Sphere::new(Point3::from(center), 0.25).unwrap());
        let of = |brep| contact(brep, &probe, &Options::default(), &mut Workspace::default());
        let (a, b) = (of(&high), of(&low));
        assert!(
            a.undecided.is_none() && b.undecided.is_none(),
            "{a:?} {b:?}"
        );
        let (a, b) = (a.separation.bounds, b.separation.bounds);
        assert!(a.lo <= b.hi && b.lo <= a.hi, "{a:?} {b:?}");
    }
}

/// A plane's patch three ulps wide, which a side of a triangle crosses: that side's piece is cut next to the patch, not on it. Every point of the triangle is as
/// near as any other, and so is the one of the patch nearest to where the piece ends, which is not on the side.
#[test]
fn a_foot_on_a_narrow_patch_is_not_called_one_of_a_side_that_it_is_beside() {
    let narrow = -7.0 - 16.0 * f64::EPSILON;
    let inner = -3.0 - 8.0 * f64::EPSILON;
    let u = [-8.0, -8.0, -8.0, inner, inner, 8.0, 8.0, 8.0];
    let v = [
        -8.0, -8.0, -8.0, -8.0, narrow, -7.0, 1.0, 8.0, 8.0, 8.0, 8.0,
    ];
    let third = |j: usize| j as f64 / 3.0;
    let points = (0..5).flat_map(|i| {
        (0..7).map(move |j| {
            let i = i as f64;
            let [x, y] = [-8.0 + 4.0 * i, -8.0 + 8.0 * third(j)];
            Vector4::new(x, y, 2.0 + i - 4.0 * third(j), 1.0)
        })
    });
    let surface = NurbsSurface::new([2, 3], [5, 7], points.collect(), [u.to_vec(), v.to_vec()]);
    let surface = Surface::Nurbs(surface.expect("a plane"));
    let from = Point2::new(0.0, 0.0);
    let to = Point2::new(-1.6250000186264515, -7.0625);
    let corners = [
        from,
        to,
        Point2::new(-1.375, -0.125),
        Point2::new(0.0, 1.4375),
    ];
    let brep = polygon_face(&surface, &corners);
    let normal = Vector3::new(-1.0, 2.0, 4.0).normalize();
    let ask = Probe::HalfSpace(HalfSpace::new(normal, 0.0).expect("a half-space"));
    let options = Options {
        prediction: f64::INFINITY,
        ..Options::default()
    };
    let answer = contact(&brep, &ask, &options, &mut Workspace::default());
    let foot = answer.contacts.first().expect("a foot");
    if let Feature::Edge(0) = foot.feature {
        let [side, own] = [to - from, foot.uv - from];
        let off = (side.x * own.y - side.y * own.x).abs() / side.norm();
        // A uv is rounded, to 2^-51 at most where coordinates are below 8.
        assert!(off <= 8.0 * f64::EPSILON, "{off:e} beside the side");
    }
}
