//! Lines through the joints of a surface's patches, and past the edges of faces.

use feeler::brep::{Brep, BrepBuilder, TrimSpec};
use feeler::numeric::{Dd, Interval};
use feeler::nurbs::{
    Arc, Curve, Line, NurbsCurve, NurbsSurface, Plane, Polyline, Revolution, Surface,
};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, LineAnswer, LineKind, LineProbe, Options, ProbeError, Workspace, any_hit, line,
};
use nalgebra::{Point2, Point3, Vector2, Vector3, Vector4};

fn sheet(surface: NurbsSurface) -> PreparedBrep {
    PreparedBrep::new(Brep::from_surface(Surface::Nurbs(surface)).unwrap())
}

/// `z = -slope |x|` over `[-1, 1]^2`: a ridge along y, a joint of two patches.
fn ridge(slope: f64) -> PreparedBrep {
    let rows = [-1.0, 0.0, 1.0f64];
    let net = rows
        .iter()
        .flat_map(|x| [-1.0, 1.0].map(|y| Vector4::new(*x, y, -slope * x.abs(), 1.0)));
    let knots = [vec![0.0, 0.0, 0.5, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
    sheet(NurbsSurface::new([1, 1], [3, 2], net.collect(), knots).unwrap())
}

fn ask(brep: &PreparedBrep, origin: [f64; 3], direction: [f64; 3]) -> LineAnswer {
    let probe = LineProbe::new(
        Point3::from(origin),
        Vector3::from(direction),
        LineKind::Line,
    );
    line(
        brep,
        &probe.unwrap(),
        &Options::default(),
        &mut Workspace::default(),
    )
}

/// Below the ridge by `e` a line along x meets both slopes, at `x = -e / slope` and `e / slope`, however near these are.
#[test]
fn hits_beside_a_ridge_are_two() {
    for slope in [0.25, 1.0, 4.0] {
        let brep = ridge(slope);
        for k in [4, 20, 30, 36, 40, 44, 50, 70, 90] {
            let e = 0.5f64.powi(k);
            let answer = ask(&brep, [0.0, 0.25, -e * slope], [1.0, 0.0, 0.0]);
            assert_eq!(answer.undecided, None, "{slope} {k}");
            assert_eq!(
                (answer.hits.len(), answer.crossings),
                (2, Some(2)),
                "{slope} {k}"
            );
            for (hit, x) in answer.hits.iter().zip([-e, e]) {
                assert!(
                    hit.t.bounds.lo <= x && x <= hit.t.bounds.hi,
                    "{slope} {k} {hit:?}"
                );
            }
            let over = ask(&brep, [0.0, 0.25, e * slope], [1.0, 0.0, 0.0]);
            assert_eq!((over.undecided, over.hits.len()), (None, 0), "{slope} {k}");
        }
    }
}

/// A line that touches the ridge in its top meets both slopes there, and stays above: not one crossing.
#[test]
fn a_line_that_touches_a_ridge_does_not_cross_it() {
    let brep = ridge(1.0);
    for d in [[1.0, 0.0, 0.0], [1.0, 0.5, 0.25], [-1.0, 2.0, 0.75]] {
        let answer = ask(&brep, [0.0, 0.25, 0.0], d);
        assert!(answer.undecided.is_some(), "{answer:?}");
        // It says where: at the start, on one of the faces.
        let place = answer.unsettled.expect("a place");
        let t = place.t.expect("where on the line");
        assert!(place.face < 2 && t.abs() < 1e-3, "{place:?}");
        assert!(place.to_string().starts_with("face "), "{place}");
    }
    let past = ask(&brep, [0.0, 0.25, 0.25], [1.0, 0.0, 0.0]);
    assert_eq!((past.undecided, past.unsettled), (None, None));
}

/// Where it is not known which hits there are, neither is how often the line crosses.
#[test]
fn an_undecided_line_counts_no_crossings() {
    // Across the ridge's top; across the bottom of a trough, `z = x^2`.
    let trough = [(-1.0, 1.0), (0.0, -1.0), (1.0, 1.0)];
    let net = trough
        .iter()
        .flat_map(|(x, z)| [-1.0, 1.0].map(|y| Vector4::new(*x, y, *z, 1.0)));
    let knots = [vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
    let trough = sheet(NurbsSurface::new([2, 1], [3, 2], net.collect(), knots).unwrap());
    for (brep, d) in [
        (ridge(1.0), [1.0, 0.0, 0.0]),
        (ridge(1.0), [1.0, 0.5, 0.25]),
        (trough, [1.0, 0.5, 0.0]),
    ] {
        let answer = ask(&brep, [0.0, 0.25, 0.0], d);
        // Once it is settled, nothing is crossed.
        let known = answer.undecided.is_none().then_some(0);
        assert_eq!(answer.crossings, known, "{answer:?}");
    }
}

/// One that passes through it at the top crosses it once.
#[test]
fn a_line_through_a_ridge_crosses_it_once() {
    let brep = ridge(1.0);
    for d in [[0.0, 0.0, 1.0], [0.5, 0.25, 1.0], [-0.75, 2.0, 1.0]] {
        let answer = ask(&brep, [0.0, 0.25, 0.0], d);
        assert_eq!(answer.undecided, None, "{d:?}");
        assert_eq!((answer.hits.len(), answer.crossings), (1, Some(1)), "{d:?}");
        let t = answer.hits[0].t.bounds;
        assert!(t.lo <= 0.0 && 0.0 <= t.hi, "{d:?} {t:?}");
        let probe = LineProbe::new(
            Point3::new(0.0, 0.25, 0.0),
            Vector3::from(d),
            LineKind::Line,
        );
        let any = any_hit(
            &brep,
            &probe.unwrap(),
            &Options::default(),
            &mut Workspace::default(),
        );
        assert!(any.hit.is_some(), "{d:?}");
    }
}

/// Through or beside the corner of four patches, with and without kinks, `z = -slope (|x| + |y|)`: a steep line crosses once, whichever
/// patches' enclosures hold it.
#[test]
fn a_line_about_the_corner_of_four_patches_crosses_once() {
    for slope in [0.0, 0.5] {
        let rows = [-1.0, 0.0, 1.0f64];
        let net = rows
            .iter()
            .flat_map(|x| rows.map(|y| Vector4::new(*x, y, -slope * (x.abs() + y.abs()), 1.0)));
        // Spans of different lengths.
        let knots = [
            vec![0.0, 0.0, 0.5, 1.0, 1.0],
            vec![0.0, 0.0, 0.125, 8.0, 8.0],
        ];
        let surface = NurbsSurface::new([1, 1], [3, 3], net.collect(), knots);
        let brep = sheet(surface.unwrap());
        let coarse = Options {
            accuracy: Accuracy::Length(1e-6),
            ..Options::default()
        };
        let sizes = [
            0.0, 1e-14, 1e-16, 1e-17, 1e-25, 1e-30, 1e-31, 1e-32, 1e-33, 1e-35,
        ];
        let offsets: Vec<f64> = sizes.iter().flat_map(|s| [*s, -s]).collect();
        let (mut told, mut open) = (0, 0);
        for d in [[0.0, 0.0, 1.0], [0.25, 0.5, 1.0], [-0.5, 0.125, 1.0]] {
            for (x, y) in offsets
                .iter()
                .flat_map(|x| offsets.iter().map(move |y| (*x, *y)))
            {
                for options in [&coarse, &Options::default()] {
                    let probe =
                        LineProbe::new(Point3::new(x, y, 0.0), Vector3::from(d), LineKind::Line);
                    let answer = line(&brep, &probe.unwrap(), options, &mut Workspace::default());
                    // At the end of double-double it need not be told which patch's it is.
                    let fine = [x, y].iter().any(|o| *o != 0.0 && o.abs() < 1e-28);
                    if fine && answer.undecided.is_some() {
                        open += 1;
                        continue;
                    }
                    let found = (answer.undecided, answer.hits.len(), answer.crossings);
                    assert_eq!(found, (None, 1, Some(1)), "{slope} {d:?} {x:e} {y:e}");
                    told += 1;
                }
            }
        }
        assert!(told > 8 * open, "{told} {open}");
    }
}

/// Two faces in `z = 0` that share an edge, of which each has its own image, from `y = -1` to `y = 1`: a polyline, with the first face to its
/// left and the second to its right. The crack is as wide as these are apart.
fn split(images: [&[[f64; 2]]; 2]) -> PreparedBrep {
    let mut b = BrepBuilder::new();
    let [from, to] = [images[0][0], images[0][images[0].len() - 1]];
    let v = [from, to, [-1.0, -1.0], [-1.0, 1.0], [3.0, -1.0], [3.0, 1.0]]
        .map(|[x, y]| b.vertex([x, y, 0.0]));
    let edge = b.straight_edge([v[0], v[1]]).unwrap();
    let wide = Interval {
        start: -4.0,
        end: 4.0,
    };
    let plane = Plane::new(Plane {
        origin: Point3::origin(),
        x: Vector3::x(),
        y: Vector3::y(),
        domain: [wide; 2],
        extents: [wide; 2],
    });
    let trim = |vertices: [usize; 2], points: &[[f64; 2]], edge| {
        let points: Vec<_> = points.iter().map(|p| Point2::from(*p)).collect();
        let params = (0..points.len()).map(|i| i as f64).collect();
        let curve = Polyline::new(points, params).unwrap();
        TrimSpec {
            vertices,
            curve: Curve::Polyline(curve),
            edge,
        }
    };
    let plane = Surface::Plane(plane.unwrap());
    let [a, z] = images.map(|i| (i[0], i[i.len() - 1]));
    let first = [
        trim([v[0], v[1]], images[0], Some(edge)),
        trim([v[1], v[3]], &[a.1, [-1.0, 1.0]], None),
        trim([v[3], v[2]], &[[-1.0, 1.0], [-1.0, -1.0]], None),
        trim([v[2], v[0]], &[[-1.0, -1.0], a.0], None),
    ];
    let back: Vec<_> = images[1].iter().rev().copied().collect();
    let second = [
        trim([v[1], v[0]], &back, Some(edge)),
        trim([v[0], v[4]], &[z.0, [3.0, -1.0]], None),
        trim([v[4], v[5]], &[[3.0, -1.0], [3.0, 1.0]], None),
        trim([v[5], v[1]], &[[3.0, 1.0], z.1], None),
    ];
    b.face_with_trims(plane.clone(), vec![first.to_vec()])
        .unwrap();
    b.face_with_trims(plane, vec![second.to_vec()]).unwrap();
    PreparedBrep::new(b.build().unwrap())
}

/// Two faces in `z = 0` whose edges along `x = 0` should be one: of the first at `x = 0`, of the second at `x = gap`. The edge's
/// crack is `gap` wide; with `gap < 0` the faces overlap.
fn cracked(gap: f64) -> PreparedBrep {
    let at = |x: f64| [[x, -1.0], [x, 1.0]];
    split([&at(0.0), &at(gap)])
}

/// A bent edge whose images are one in a part and apart in another: that a line meets both at a hit in the one says nothing of the other, past which it
/// slips through the crack.
#[test]
fn a_line_through_the_crack_of_a_bent_edge() {
    let gap = 0.5f64.powi(20);
    let bent = |gap: f64| {
        [
            [0.0, -1.0],
            [0.0, 0.5],
            [1.0, 0.5],
            [1.0 + gap, -0.5],
            [2.0, -0.5],
            [2.0, 1.0],
        ]
    };
    let brep = split([&bent(0.0), &bent(gap)]);
    let width = [brep.least_crack_width(0), brep.fine_crack_width(0)];
    assert!(0.0 < width[0] && width[1] < 2.0 * gap, "{width:?}");
    for part in [0.25, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0 - 1e-6] {
        let answer = ask(&brep, [0.0, 0.0, 0.0], [1.0, 0.0, part * width[0]]);
        let found: Vec<_> = answer.hits.iter().map(|h| h.t.value).collect();
        assert_eq!(found, [0.0, 0.0], "{part}");
        let open = answer.undecided.is_some();
        assert!(answer.in_crack || open, "{part} {answer:?}");
    }
}

/// Hits, crossings, whether in a crack.
fn counts(brep: &PreparedBrep, x: f64, d: [f64; 3]) -> (usize, usize, bool) {
    let answer = ask(brep, [x, 0.125, 0.0], d);
    assert_eq!(answer.undecided, None, "{x:e} {d:?}");
    (
        answer.hits.len(),
        answer.crossings.unwrap(),
        answer.in_crack,
    )
}

/// A line through `z = 0` at `x` is in the crack where that is within its width of either image.
#[test]
fn a_line_through_a_crack() {
    for k in [4, 20, 36, 46] {
        let gap = 0.5f64.powi(k);
        let open = cracked(gap);
        assert!(open.least_crack_width(0) <= gap && gap <= open.fine_crack_width(0));
        for d in [[0.0, 0.0, 1.0], [0.5, 0.25, 1.0], [0.0, 2.0, -1.0]] {
            // Between the images it meets neither face.
            for part in [0.25, 0.5, 0.875] {
                assert_eq!(counts(&open, part * gap, d), (0, 0, true), "{k} {d:?}");
            }
            // Beside them it meets one, within the crack's width or not.
            for part in [-8.0, -0.5, 1.5, 9.0] {
                assert_eq!(
                    counts(&open, part * gap, d),
                    (1, 1, false),
                    "{k} {d:?} {part}"
                );
            }
        }
        let folded = cracked(-gap);
        for d in [[0.0, 0.0, 1.0], [0.5, 0.25, 1.0], [0.0, 2.0, -1.0]] {
            // Where the faces overlap it meets both, once.
            for part in [-0.875, -0.5, -0.25] {
                assert_eq!(counts(&folded, part * gap, d), (2, 1, false), "{k} {d:?}");
            }
            for part in [-9.0, -1.5, 0.5, 8.0] {
                assert_eq!(
                    counts(&folded, part * gap, d),
                    (1, 1, false),
                    "{k} {d:?} {part}"
                );
            }
        }
    }
}

/// What is beyond the end of a segment is not on it.
#[test]
fn a_segment_that_ends_before_a_crack() {
    let gap = 0.5f64.powi(30);
    let brep = cracked(gap);
    let ask = |length: f64| {
        let probe = LineProbe::new(
            Point3::new(0.5 * gap, 0.125, 1.0),
            Vector3::new(0.0, 0.0, -length),
            LineKind::Segment,
        );
        line(
            &brep,
            &probe.unwrap(),
            &Options::default(),
            &mut Workspace::default(),
        )
    };
    let through = ask(2.0);
    assert_eq!((through.undecided, through.in_crack), (None, true));
    let before = ask(0.5);
    assert_eq!((before.undecided, before.in_crack), (None, false));
    // It ends within the crack's width of both images: whether its passage counts is not said.
    let within = ask(1.0 - 0.25 * gap);
    assert!(within.undecided.is_some(), "{within:?}");
}

/// The intervals that are hits: start, end where the line lies in the face, whether it crosses.
fn hits(answer: &LineAnswer) -> Vec<(usize, f64, Option<f64>, bool)> {
    let one = |h: &feeler::query::Hit| {
        let bounds = [Some(&h.t), h.t_end.as_ref()];
        for t in bounds.into_iter().flatten() {
            assert!(t.bounds.hi - t.bounds.lo <= 1e-15, "{h:?}");
        }
        let end = h.t_end.map(|t| t.value);
        (h.face, h.t.value, end, !h.tangential)
    };
    answer.hits.iter().map(one).collect()
}

fn unit_cube() -> PreparedBrep {
    PreparedBrep::new(crate::scenes::cube())
}

/// A line in the plane of a face lies in it from one edge to the other, where it meets the faces beside it on their edges.
#[test]
fn a_line_in_a_face_of_a_cube() {
    let cube = unit_cube();
    let answer = ask(&cube, [-1.0, 0.25, 1.0], [2.0, 0.0, 0.0]);
    assert_eq!(answer.undecided, None);
    assert_eq!((answer.crossings, answer.in_crack), (None, false));
    let found = hits(&answer);
    assert_eq!(found.len(), 3, "{found:?}");
    let runs: Vec<_> = found.iter().filter(|h| h.2.is_some()).collect();
    assert_eq!(runs.len(), 1);
    assert_eq!((runs[0].1, runs[0].2, runs[0].3), (0.5, Some(1.0), false));
    let points: Vec<_> = found.iter().filter(|h| h.2.is_none()).collect();
    assert_eq!(
        points.iter().map(|h| (h.1, h.3)).collect::<Vec<_>>(),
        [(0.5, true), (1.0, true)]
    );
    // Slanted, and as a segment that begins inside the face.
    let probe = LineProbe::new(
        Point3::new(0.5, 0.25, 1.0),
        Vector3::new(1.0, 0.5, 0.0),
        LineKind::Segment,
    );
    let answer = line(
        &cube,
        &probe.unwrap(),
        &Options::default(),
        &mut Workspace::default(),
    );
    assert_eq!(answer.undecided, None);
    let runs: Vec<_> = hits(&answer)
        .into_iter()
        .filter(|h| h.2.is_some())
        .collect();
    assert_eq!(
        runs.iter().map(|h| (h.1, h.2)).collect::<Vec<_>>(),
        [(0.0, Some(0.5))]
    );
}

/// Above the plane by as little as there is, it meets nothing.
#[test]
fn a_line_above_a_face_of_a_cube() {
    let answer = ask(
        &unit_cube(),
        [-1.0, 0.25, 1.0f64.next_up()],
        [2.0, 0.0, 0.0],
    );
    assert_eq!((answer.undecided, answer.hits.len()), (None, 0));
}

/// Through a point of an edge it meets both faces there, and passes once, or touches.
#[test]
fn a_line_through_an_edge_of_a_cube() {
    let cube = unit_cube();
    // In over the edge z = 1, x = 1, out of the bottom.
    let answer = ask(&cube, [2.0, 0.25, 2.5], [-1.0, 0.125, -1.5]);
    assert_eq!(
        (answer.undecided, answer.crossings),
        (None, Some(2)),
        "{answer:?}"
    );
    let at: Vec<f64> = hits(&answer).iter().map(|h| h.1).collect();
    assert_eq!(at, [1.0, 1.0, 2.5 / 1.5]);
    // It meets the same edge from outside, and stays there.
    let answer = ask(&cube, [2.0, 0.25, 0.0], [-1.0, 0.0, 1.0]);
    assert_eq!(
        (answer.undecided, answer.hits.len(), answer.crossings),
        (None, 2, Some(1))
    );
    // Beside it by one unit in the last place: through, or past.
    let answer = ask(&cube, [2.0f64.next_down(), 0.25, 0.0], [-1.0, 0.0, 1.0]);
    assert_eq!(
        (answer.undecided, answer.hits.len(), answer.crossings),
        (None, 2, Some(2))
    );
    let answer = ask(&cube, [2.0f64.next_up(), 0.25, 0.0], [-1.0, 0.0, 1.0]);
    assert_eq!(
        (answer.undecided, answer.hits.len(), answer.crossings),
        (None, 0, Some(0))
    );
}

/// Through a corner it meets three faces there.
#[test]
fn a_line_through_a_corner_of_a_cube() {
    let cube = unit_cube();
    let answer = ask(&cube, [1.75, 2.0, 2.5], [-0.75, -1.0, -1.5]);
    assert_eq!(
        (answer.undecided, answer.crossings),
        (None, Some(2)),
        "{answer:?}"
    );
    assert_eq!(answer.hits.len(), 4);
    let diagonal = ask(&cube, [-1.0; 3], [1.0; 3]);
    assert_eq!(
        (diagonal.undecided, diagonal.hits.len(), diagonal.crossings),
        (None, 6, Some(2))
    );
}

/// Rulings of length 2 over a unit circle in four rational quadrants, its seam at `(1, 0, z)`.
fn tube() -> PreparedBrep {
    sheet(tube_surface())
}

fn tube_surface() -> NurbsSurface {
    let half = 0.5f64.sqrt();
    let square = [
        [1.0, 0.0],
        [1.0, 1.0],
        [0.0, 1.0],
        [-1.0, 1.0],
        [-1.0, 0.0],
        [-1.0, -1.0],
        [0.0, -1.0],
        [1.0, -1.0],
        [1.0, 0.0],
    ];
    let net = square.iter().enumerate().flat_map(|(i, [x, y])| {
        let w = if i % 2 == 0 { 1.0 } else { half };
        [-1.0, 1.0].map(|z| Vector4::new(w * x, w * y, w * z, w))
    });
    let around = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    let knots = [around, vec![0.0, 0.0, 1.0, 1.0]];
    NurbsSurface::new([2, 1], [9, 2], net.collect(), knots).unwrap()
}

/// A seam is no end of the surface: a line through it, or beside it by any number of digits, crosses there once.
#[test]
fn a_line_through_a_seam_crosses_once() {
    let brep = tube();
    for k in [0, 30, 52, 60, 80, 100, 200] {
        for y in [0.0, 0.5f64.powi(k), -(0.5f64.powi(k))] {
            // Not the very top of the circle.
            let y = 0.25 * y;
            let answer = ask(&brep, [2.0, y, 0.25], [-1.0, 0.0, 0.125]);
            assert_eq!(answer.undecided, None, "{y}");
            assert_eq!((answer.hits.len(), answer.crossings), (2, Some(2)), "{y}");
            let x = (1.0 - y * y).sqrt();
            for (hit, t) in answer.hits.iter().zip([2.0 - x, 2.0 + x]) {
                // Weights are rounded: the circle is off by less than two roundings.
                assert!((hit.t.value - t).abs() < 4.0 * f64::EPSILON, "{y} {hit:?}");
                assert!(!hit.tangential);
            }
        }
    }
}

/// The tube's trims run along its seam on either side of it by as little as digits allow. A point on the seam is in the region where it is on one of the
/// sides: once, whichever, and not where the trims leave a gap.
#[test]
fn a_line_through_a_seam_between_trims_that_bulge() {
    for e in [0.5f64.powi(50), 0.5f64.powi(48), 1e-12, 0.5f64.powi(20)] {
        for (low, high, count) in [(e, e, 1), (-e, -e, 1), (-e, e, 1), (e, -e, 0), (0.0, -e, 1)] {
            let curve = |points: &[[f64; 2]]| {
                let ends = [[0.0; 3], [1.0; 3]].concat();
                let degree = points.len() - 1;
                let knots = ends[2 - degree..4 + degree].to_vec();
                let points = points.iter().map(|[u, v]| Vector3::new(*u, *v, 1.0));
                Curve::Nurbs(NurbsCurve::new(degree, points.collect(), knots).unwrap())
            };
            let mut b = BrepBuilder::new();
            let [bottom, top] = [-1.0, 1.0].map(|z| b.vertex([1.0, 0.0, z]));
            let trim = |vertices, points: &[[f64; 2]]| TrimSpec {
                vertices,
                curve: curve(points),
                edge: None,
            };
            let trims = vec![
                trim([bottom; 2], &[[0.0, 0.0], [4.0, 0.0]]),
                trim([bottom, top], &[[4.0, 0.0], [4.0 + high, 0.5], [4.0, 1.0]]),
                trim([top; 2], &[[4.0, 1.0], [0.0, 1.0]]),
                trim([top, bottom], &[[0.0, 1.0], [low, 0.5], [0.0, 0.0]]),
            ];
            b.face_with_trims(Surface::Nurbs(tube_surface()), vec![trims])
                .unwrap();
            let brep = PreparedBrep::new(b.build().unwrap());
            for d in [[-1.0, 0.0, 0.125], [-0.5, 0.0, 0.25], [-1.0, 0.0, 0.0]] {
                let answer = ask(&brep, [1.0 - d[0], 0.0, 0.25 - d[2]], d);
                assert_eq!(answer.undecided, None, "{low:e} {high:e} {d:?}");
                let at_seam = answer.hits.iter().filter(|h| h.point.x > 0.0);
                assert_eq!(at_seam.count(), count, "{low:e} {high:e} {d:?}");
                assert_eq!(answer.crossings, Some(answer.hits.len()));
            }
            // In the plane that is tangent there.
            for d in [[0.0, 1.0, 0.0], [0.0, -2.0, 0.0], [0.0, 1.0, 0.5]] {
                let answer = ask(&brep, [1.0, -d[1], 0.25 - d[2]], d);
                assert_eq!(answer.undecided, None, "{low:e} {high:e} {d:?}");
                let at: Vec<_> = answer
                    .hits
                    .iter()
                    .map(|h| (h.t.value, h.tangential))
                    .collect();
                assert_eq!(at, vec![(1.0, true); count], "{low:e} {high:e} {d:?}");
                assert_eq!(answer.crossings, Some(0));
            }
            // Along the seam, which ends where the trims do; in a gap these points are all there is.
            if count > 0 {
                let answer = ask(&brep, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
                assert_eq!(answer.undecided, None, "{low:e} {high:e}");
                let [run] = &answer.hits[..] else {
                    panic!("{low:e} {high:e} {:?}", answer.hits);
                };
                let end = run.t_end.map(|t| t.value);
                assert_eq!((run.t.value, end), (-1.0, Some(1.0)));
            }
        }
    }
}

/// Walls that are closed in themselves, whose first and last parts leave the plane x = 0 at the seam as parabolas, or as lines that are all but in it: a line in the plane
/// touches where both are on one side of it, and else passes.
#[test]
fn a_line_in_the_tangent_plane_of_a_seam() {
    let hair = 0.5f64.powi(51);
    for (first, last) in [
        ([0.0, -1.0], [-1.0, 0.0]),
        ([0.0, -1.0], [1.0, 0.0]),
        ([0.0, 1.0], [-1.0, -hair]),
        ([-hair, -1.0], [-1.0, 0.0]),
        ([-hair, -1.0], [1.0, hair]),
        ([hair, 1.0], [1.0, hair]),
    ] {
        let passes = first[1] != last[0];
        // Beyond both parts, the rest meets the line where these end on either side of it.
        let wall = [
            [0.0, 0.0],
            [first[0], 1.0],
            [first[1], 2.0],
            [if passes { 8.0 } else { 8.0 * first[1] }, 0.0],
            [last[0], -2.0],
            [last[1], -1.0],
            [0.0, 0.0],
        ];
        let net = wall
            .iter()
            .flat_map(|[x, y]| [0.0, 1.0].map(|z| Vector4::new(*x, *y, z, 1.0)));
        let around = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 3.0];
        let knots = [around, vec![0.0, 0.0, 1.0, 1.0]];
        let surface = NurbsSurface::new([2, 1], [7, 2], net.collect(), knots).unwrap();
        let brep = PreparedBrep::new(Brep::from_surface(Surface::Nurbs(surface)).unwrap());
        for d in [[0.0, 1.0, 0.0], [0.0, 1.0, 0.125], [0.0, -0.5, -0.0625]] {
            let answer = ask(&brep, [-d[0], -d[1], 0.375 - d[2]], d);
            let what = format!("{first:?} {last:?} {d:?} {answer:?}");
            assert_eq!(answer.undecided, None, "{what}");
            let at_seam = answer.hits.iter().filter(|h| h.point.y.abs() < 0.5);
            let at_seam: Vec<_> = at_seam.map(|h| (h.t.value, h.tangential)).collect();
            assert_eq!(at_seam, [(1.0, !passes)], "{what}");
            let crossings = if passes { 2 } else { 0 };
            let own = answer.hits.iter().filter(|h| !h.tangential).count();
            assert_eq!(
                (own, answer.crossings),
                (crossings, Some(crossings)),
                "{what}"
            );
        }
    }
}

/// A unit sphere, and a cylinder and a cone whose circles at height 0 are its equator, about the z axis, native.
fn round() -> [PreparedBrep; 3] {
    let turn = Interval::new(0.0, std::f64::consts::TAU).unwrap();
    let half = Interval::new(-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2).unwrap();
    let segment = |from: [f64; 3], to: [f64; 3]| {
        Curve::Line(Line {
            from: Point3::from(from),
            to: Point3::from(to),
            domain: Interval::new(0.0, 1.0).unwrap(),
        })
    };
    let meridian = Curve::Arc(Arc {
        center: Point3::origin(),
        x: Vector3::x(),
        y: Vector3::z(),
        z: -Vector3::y(),
        radius: 1.0,
        angle: half,
        domain: half,
    });
    let profiles = [
        meridian,
        segment([1.0, 0.0, -1.0], [1.0, 0.0, 1.0]),
        segment([2.0, 0.0, -1.0], [0.5, 0.0, 0.5]),
    ];
    profiles.map(|profile| {
        let surface = Surface::Revolution(Revolution {
            origin: Point3::new(0.0, 0.0, 0.5),
            axis: Vector3::new(0.0, 0.0, 3.0),
            angle: turn,
            angle_domain: turn,
            profile,
            transposed: false,
        });
        PreparedBrep::new(Brep::from_surface(surface).unwrap())
    })
}

/// Level lines at the equator touch, miss and meet a native surface as exact arithmetic has it, by one ulp.
#[test]
fn level_lines_about_a_circle() {
    for (brep, name) in round().iter().zip(["sphere", "cylinder", "cone"]) {
        // At the height of the equator, in a direction along which the tangent at `(0, 1)` runs.
        let ask = |y: f64| ask(brep, [-3.0, y, 0.0], [2.0, 0.0, 0.0]);
        let touch = ask(1.0);
        assert_eq!(
            (touch.undecided, touch.crossings),
            (None, Some(0)),
            "{name}"
        );
        assert_eq!(touch.hits.len(), 1, "{name}");
        let hit = &touch.hits[0];
        assert!(hit.tangential && hit.t.bounds.lo <= 1.5 && 1.5 <= hit.t.bounds.hi);
        let beyond = ask(1.0f64.next_up());
        assert_eq!((beyond.undecided, beyond.hits.len()), (None, 0), "{name}");
        // 1 - 2^-53: x^2 = 2^-52 - 2^-106, so that x is 2^-26 but for one part in 2^55.
        let through = ask(1.0f64.next_down());
        assert_eq!(
            (through.undecided, through.crossings),
            (None, Some(2)),
            "{name}"
        );
        for (hit, sign) in through.hits.iter().zip([-1.0, 1.0]) {
            let t = 1.5 + sign * 0.5f64.powi(27);
            assert!(
                !hit.tangential && (hit.t.value - t).abs() <= f64::EPSILON,
                "{name} {hit:?}"
            );
        }
    }
}

/// Next to a pole a sphere is crossed as elsewhere. The meridian of the native one ends at pi/2 as f64, 6.1e-17 before the pole: through the
/// hole that is left, a line along the axis meets nothing.
#[test]
fn lines_next_to_a_pole() {
    let [native, ..] = round();
    let nurbs = PreparedBrep::new(crate::scenes::nurbs_sphere());
    for (brep, radius, least) in [(&native, 1.0, 4e-16), (&nurbs, 2.5, 1e-14)] {
        for off in [1e-6, 1e-9, 1e-12, 1e-13, 2e-14, least] {
            for (turn, d) in [
                (0.3, [0.0, 0.0, 1.0]),
                (2.9, [0.0, 0.0, -0.5]),
                (4.4, [0.3, 0.25, 1.0]),
                (5.6, [-0.125, 0.5, 0.75]),
            ] {
                let (sin, cos) = f64::sin_cos(turn);
                let origin = [off * cos, off * sin, radius];
                let answer = ask(brep, origin, d);
                let name = format!("{radius} {off:e} {d:?}");
                assert_eq!(answer.undecided, None, "{name}");
                assert_eq!(
                    (answer.hits.len(), answer.crossings),
                    (2, Some(2)),
                    "{name}"
                );
                // |o + t d|^2 = R^2.
                let (o, d) = (Vector3::from(origin), Vector3::from(d));
                let (a, b) = (d.dot(&d), o.dot(&d));
                let c = off * off;
                let root = (b * b - a * c).sqrt();
                let mut expected = [-b / a - root / a, -b / a + root / a];
                expected.sort_by(f64::total_cmp);
                for (hit, t) in answer.hits.iter().zip(expected) {
                    // The weights and the points of the NURBS sphere are rounded.
                    assert!(
                        (hit.t.value - t).abs() < 64.0 * f64::EPSILON,
                        "{name} {hit:?} {t}"
                    );
                }
            }
        }
    }
    for off in [0.0, 1e-20, 5e-17] {
        let answer = ask(&native, [off, 0.0, 3.0], [0.0, 0.0, -1.0]);
        assert_eq!((answer.undecided, answer.hits.len()), (None, 0), "{off:e}");
    }
}

/// At the seam and the rim of a native cylinder at once: its height ends at 1 exactly, its angle at 2 pi as f64, 2.4e-16 before the whole turn.
#[test]
fn lines_at_the_corner_of_a_cylinder() {
    let [_, cylinder, _] = round();
    let below = 1.0f64.next_down();
    for (y, z, expected) in [
        (1e-20, below, 2),
        (1e-26, below, 2),
        (-1e-15, below, 2),
        // In the slit of the seam, on its near side alone.
        (-1e-20, below, 1),
        (-2e-16, below, 1),
        (1e-20, 1.0f64.next_up(), 0),
        (-1e-15, 1.0f64.next_up(), 0),
        (1e-20, -below, 2),
        (1e-20, -1.0f64.next_up(), 0),
    ] {
        let answer = ask(&cylinder, [3.0, y, z], [-2.0, 0.0, 0.0]);
        assert_eq!(
            (answer.undecided, answer.hits.len(), answer.crossings),
            (None, expected, Some(expected)),
            "{y:e} {z}"
        );
    }
}

/// Rays and segments that begin or end on a native surface, exactly, and by one ulp before or beyond it.
#[test]
fn rays_that_begin_on_a_surface() {
    let of_kind = |brep: &PreparedBrep, origin: [f64; 3], d: [f64; 3], kind| {
        let probe = LineProbe::new(Point3::from(origin), Vector3::from(d), kind).unwrap();
        let answer = line(brep, &probe, &Options::default(), &mut Workspace::default());
        assert_eq!(answer.undecided, None, "{origin:?} {d:?}");
        let hits = answer.hits.iter();
        hits.map(|h| (h.t.value, h.tangential)).collect::<Vec<_>>()
    };
    for brep in &round() {
        let ray = |y: f64, d| of_kind(brep, [0.0, y, 0.0], d, LineKind::Ray);
        let (inward, outward) = ([0.0, -0.5, 0.0], [0.0, 0.5, 0.0]);
        assert_eq!(ray(1.0, inward), [(0.0, false), (4.0, false)]);
        assert_eq!(ray(1.0, outward), [(0.0, false)]);
        assert_eq!(ray(1.0f64.next_down(), inward).len(), 1);
        assert_eq!(ray(1.0f64.next_up(), inward).len(), 2);
        assert_eq!(ray(1.0f64.next_up(), outward), []);
        // A tangent.
        assert_eq!(ray(1.0, [0.5, 0.0, 0.0]), [(0.0, true)]);
        let segment = |x: f64| of_kind(brep, [x, 1.0, 0.0], [0.5, 0.0, 0.0], LineKind::Segment);
        assert_eq!(segment(-0.5), [(1.0, true)]);
        assert_eq!(segment((-0.5f64).next_down()), []);
        assert_eq!(segment((-0.5f64).next_up()).len(), 1);
        assert_eq!(segment(5e-324), []);
    }
}

/// A line across a disc meets its rim where that is, exactly: at (3, 4) of the radius 5, say.
#[test]
fn lines_through_the_rim_of_a_disc() {
    let interval = |a, b| Interval::new(a, b).unwrap();
    let turn = interval(0.0, std::f64::consts::TAU);
    let circle = Curve::Arc(Arc {
        center: Point2::origin(),
        x: Vector2::x(),
        y: Vector2::y(),
        z: Vector2::zeros(),
        radius: 5.0,
        angle: turn,
        domain: turn,
    });
    let mut b = BrepBuilder::new();
    let at = b.vertex([5.0, 0.0, 0.0]);
    let trim = TrimSpec {
        vertices: [at, at],
        curve: circle,
        edge: None,
    };
    let wide = interval(-8.0, 8.0);
    let plane = Surface::Plane(Plane {
        origin: Point3::origin(),
        x: Vector3::x(),
        y: Vector3::y(),
        domain: [wide; 2],
        extents: [wide; 2],
    });
    b.face_with_trims(plane, vec![vec![trim]]).unwrap();
    let disc = PreparedBrep::new(b.build().unwrap());
    for [x, y] in [
        [3.0f64, 4.0],
        [-4.0, 3.0],
        [0.0, -5.0],
        [-5.0, 0.0],
        [1.4, 4.8],
    ] {
        // 1.4^2 + 4.8^2 is 25, but neither is a f64: where they are rounded to tells.
        let level = Dd::product(x, x) + Dd::product(y, y) - Dd::from(25.0);
        let slanted = [x - 0.75, y + 0.5, -1.0];
        for (origin, d) in [
            ([x, y, -1.0], [0.0, 0.0, 0.5]),
            (slanted, [0.75, -0.5, 1.0]),
        ] {
            let count = |by: f64| {
                let answer = ask(&disc, [origin[0] + by * x, origin[1] + by * y, -1.0], d);
                assert_eq!(answer.undecided, None, "{x} {y} {by:e}");
                answer.hits.len()
            };
            if origin[0] == x || x.fract() == 0.0 {
                assert_eq!(count(0.0), usize::from(level <= Dd::ZERO), "{x} {y} {d:?}");
            }
            assert_eq!([count(1e-15), count(-1e-15)], [0, 1], "{x} {y} {d:?}");
        }
    }
}

/// A sheet ends at its border, exactly: a line that meets the border itself meets the sheet, by one ulp beyond it does not.
#[test]
fn lines_through_the_border_of_a_sheet() {
    // Bent, so that it is no plane: z = x^2 over [-1, 1]^2.
    let net = [(-1.0, 1.0), (0.0, -1.0), (1.0, 1.0)];
    let net = net
        .iter()
        .flat_map(|(x, z)| [-1.0, 1.0].map(|y| Vector4::new(*x, y, *z, 1.0)));
    let knots = [vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
    let brep = sheet(NurbsSurface::new([2, 1], [3, 2], net.collect(), knots).unwrap());
    for y in [-1.0, 1.0f64] {
        for d in [[0.0, 0.0, 1.0], [0.5, 0.0, 2.0], [0.25, 0.0, -1.0]] {
            let ask = |y: f64| {
                let answer = ask(&brep, [0.3 - d[0], y, 0.09 - d[2]], d);
                assert_eq!(answer.undecided, None, "{y} {d:?}");
                answer.hits.len()
            };
            // As many as in the sheet's middle: it is the same all along y.
            assert!(ask(0.5 * y) > 0);
            assert_eq!(ask(y), ask(0.5 * y), "{y} {d:?}");
            assert_eq!(ask(y * 1.0f64.next_up()), 0, "{y} {d:?}");
            assert_eq!(ask(y * 1.0f64.next_down()), ask(y), "{y} {d:?}");
        }
    }
}

/// A line that meets a sphere (or a cylinder) at the start of a ray and again next to it, nearer than double-double tells, meets it there once as far
/// as the ray goes: or that is said to be open.
#[test]
fn roots_next_to_the_start_of_a_ray() {
    let range = Interval::new(-1.0, 2.0).unwrap();
    let arc = Interval::new(-1.0, 1.0).unwrap();
    let meridian = Curve::Arc(Arc {
        center: Point3::origin(),
        x: Vector3::x(),
        y: Vector3::z(),
        z: -Vector3::y(),
        radius: 1.0,
        angle: arc,
        domain: arc,
    });
    let ruling = Curve::Line(Line {
        from: Point3::new(1.0, 0.0, -1.0),
        to: Point3::new(1.0, 0.0, 1.0),
        domain: arc,
    });
    for profile in [meridian, ruling] {
        let surface = Surface::Revolution(Revolution {
            origin: Point3::origin(),
            axis: Vector3::z(),
            angle: range,
            angle_domain: range,
            profile,
            transposed: false,
        });
        let brep = PreparedBrep::new(Brep::from_surface(surface).unwrap());
        for e in [
            0.5f64.powi(110),
            3.7e-33,
            1e-60,
            0.5f64.powi(90),
            0.5f64.powi(40),
        ] {
            for (e, kind) in [
                (e, LineKind::Ray),
                (e, LineKind::Segment),
                (-e, LineKind::Ray),
            ] {
                // |(1 + t e, t)| = 1 at t = 0 and at t = -2 e / (1 + e^2).
                let probe =
                    LineProbe::new(Point3::new(1.0, 0.0, 0.0), Vector3::new(e, 1.0, 0.0), kind);
                let answer = line(
                    &brep,
                    &probe.unwrap(),
                    &Options::default(),
                    &mut Workspace::default(),
                );
                let expected = if e > 0.0 { 1 } else { 2 };
                let told = (answer.undecided, answer.hits.len());
                assert!(
                    told.0.is_some() || told.1 == expected,
                    "{e:e} {kind:?} {answer:?}"
                );
                // What doubles can tell is told.
                assert!(
                    told.0.is_none() || e.abs() < 0.5f64.powi(95),
                    "{e:e} {kind:?}"
                );
            }
        }
    }
}

/// A ring of four corners about the z axis, its section a square on its corner: closed across both coordinates, whose borders meet at its outermost corner (3, 0, 0). No line that
/// touches it there crosses: these have all else of the ring on one side, as `x <= 3 - |y|` and `|z| <= 3 - x` nearby.
#[test]
fn a_line_that_touches_the_corner_of_a_ring_does_not_cross() {
    let section = [[3.0, 0.0], [2.0, 1.0], [1.0, 0.0], [2.0, -1.0], [3.0, 0.0]];
    let turns = [
        [1.0, 0.0],
        [0.0, 1.0],
        [-1.0, 0.0],
        [0.0, -1.0],
        [1.0, 0.0f64],
    ];
    let net = turns
        .iter()
        .flat_map(|[x, y]| section.map(|[r, z]| Vector4::new(r * x, r * y, z, 1.0)));
    let knots = vec![0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.0];
    let surface = NurbsSurface::new([1, 1], [5, 5], net.collect(), [knots.clone(), knots]).unwrap();
    let brep = sheet(surface);
    for d in [
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 1.0, 0.5],
        [0.25, 1.0, 0.5],
        [-0.25, 1.0, 0.125],
    ] {
        let origin = [3.0 - 2.0 * d[0], -2.0 * d[1], -2.0 * d[2]];
        let answer = ask(&brep, origin, d);
        let open = answer.undecided.is_some() || answer.crossings.is_none();
        assert!(open || answer.crossings == Some(0), "{d:?}: {answer:?}");
    }
    // Through it.
    let answer = ask(&brep, [1.0, -0.5, -0.25], [1.0, 0.25, 0.125]);
    assert_eq!(answer.crossings, Some(4), "{answer:?}");
}

/// A direction times a power of two divides the parameters of hits by it, exactly. One so short that they would be too large is refused.
#[test]
fn the_length_of_a_direction_divides_the_parameters() {
    let breps: Vec<PreparedBrep> = [unit_cube(), tube()].into_iter().chain(round()).collect();
    let direction = Vector3::new(0.5, 0.3, -0.2);
    for (index, brep) in breps.iter().enumerate() {
        let plain = ask(brep, [0.3, 0.2, 0.4], direction.into());
        assert!(!plain.hits.is_empty(), "BREP {index}");
        for power in [-440, -30, 30, 198] {
            let scale = 2f64.powi(power);
            let own = ask(brep, [0.3, 0.2, 0.4], (direction * scale).into());
            let parameters = |a: &LineAnswer, scale: f64| -> Vec<[f64; 3]> {
                let ends = |h: &feeler::query::Hit| {
                    [h.t.bounds.lo, h.t.value, h.t.bounds.hi].map(|t| t * scale)
                };
                a.hits.iter().map(ends).collect()
            };
            let (own, plain) = (parameters(&own, scale), parameters(&plain, 1.0));
            assert_eq!(own, plain, "BREP {index}, 2^{power}");
        }
    }
    // Where squares underflow it may be undecided: what is told is a number all the same, and right.
    for power in [-520, -600, -700, -796] {
        let scale = 2f64.powi(power);
        for brep in &breps {
            let plain = ask(brep, [0.3, 0.2, 0.4], direction.into());
            let own = ask(brep, [0.3, 0.2, 0.4], (direction * scale).into());
            assert!(own.undecided.is_some() || own.hits.len() == plain.hits.len());
            for h in &own.hits {
                let meets = |p: &feeler::query::Hit| {
                    let [lo, hi] = [h.t.bounds.lo, h.t.bounds.hi].map(|t| t * scale);
                    lo <= p.t.bounds.hi && p.t.bounds.lo <= hi
                };
                assert!(plain.hits.iter().any(meets), "2^{power}: {h:?}");
            }
        }
    }
    let short = Vector3::new(0.0, 1.5e-323, 0.0);
    let probe = LineProbe::new(Point3::origin(), short, LineKind::Line);
    assert_eq!(probe, Err(ProbeError::ShortDirection));
}
