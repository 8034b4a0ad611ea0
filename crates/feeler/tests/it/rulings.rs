//! Lines that hold a whole parameter line of a face: a ruling, or a pole.

use feeler::brep::Brep;
use feeler::nurbs::{NurbsSurface, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{LineAnswer, LineKind, LineProbe, Options, Workspace, any_hit, line};
use nalgebra::{Point3, Vector3, Vector4};

/// `x`, `y`, `z` as polynomials over `[0, 1]^2`: entry `[i][j]` is the coefficient of `u^i v^j`.
type Polynomials = [[[f64; 3]; 3]; 3];

/// The biquadratic sheet of these, in control points: `sum_k C(i, k) / C(2, k) a_k` in either direction.
fn net(polynomials: &Polynomials) -> Vec<Vector4<f64>> {
    let share = [[1.0, 0.0, 0.0], [1.0, 0.5, 0.0], [1.0, 1.0, 1.0]];
    let entry = |a: &[[f64; 3]; 3], i: usize, j: usize| {
        let mut sum = 0.0;
        for (k, row) in a.iter().enumerate() {
            for (l, x) in row.iter().enumerate() {
                sum += share[i][k] * share[j][l] * x;
            }
        }
        sum
    };
    let mut points = Vec::new();
    for i in 0..3 {
        for j in 0..3 {
            let [x, y, z] = [0, 1, 2].map(|c| entry(&polynomials[c], i, j));
            points.push(Vector4::new(x, y, z, 1.0));
        }
    }
    points
}

fn prepared(surface: NurbsSurface) -> PreparedBrep {
    PreparedBrep::new(Brep::from_surface(Surface::Nurbs(surface)).unwrap())
}

fn sheet(polynomials: Polynomials) -> PreparedBrep {
    let knots = || vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let surface = NurbsSurface::new([2, 2], [3, 3], net(&polynomials), [knots(), knots()]);
    prepared(surface.unwrap())
}

const ZERO: [f64; 3] = [0.0; 3];
const U: [[f64; 3]; 3] = [ZERO, [1.0, 0.0, 0.0], ZERO];
const V: [[f64; 3]; 3] = [[0.0, 1.0, 0.0], ZERO, ZERO];

/// `z = (x - 1/4) (y + 1)`, with the roles of u and v swapped or not.
fn saddle(swapped: bool) -> PreparedBrep {
    let z = [[-0.25, -0.25, 0.0], [1.0, 1.0, 0.0], ZERO];
    if !swapped {
        return sheet([U, V, z]);
    }
    let transposed = [0, 1, 2].map(|i| [0, 1, 2].map(|j| z[j][i]));
    sheet([V, U, transposed])
}

fn ask(brep: &PreparedBrep, origin: [f64; 3], direction: [f64; 3], kind: LineKind) -> LineAnswer {
    let probe = LineProbe::new(Point3::from(origin), Vector3::from(direction), kind).unwrap();
    let any = any_hit(brep, &probe, &Options::default(), &mut Workspace::default());
    let answer = line(brep, &probe, &Options::default(), &mut Workspace::default());
    if answer.undecided.is_none() {
        assert_eq!(any.undecided, None);
        assert_eq!(any.hit.is_some(), !answer.hits.is_empty());
    }
    answer
}

/// All hits: where each begins and, if it is an interval, ends, and whether it is told as tangential. The values are to be those that are expected, bit for
/// bit: what is expected is a f64, and the enclosures are a few ulp of it or of one wide.
fn hits(answer: &LineAnswer) -> Vec<(f64, Option<f64>, bool)> {
    assert_eq!(answer.undecided, None);
    let hit = |h: &feeler::query::Hit| {
        let exact = |s: &feeler::query::Parameter| {
            assert!(s.bounds.lo <= s.value && s.value <= s.bounds.hi, "{h:?}");
            assert!(
                s.bounds.hi - s.bounds.lo <= 4.0 * f64::EPSILON * (1.0 + s.value),
                "{h:?}"
            );
            s.value
        };
        (exact(&h.t), h.t_end.as_ref().map(exact), h.tangential)
    };
    answer.hits.iter().map(hit).collect()
}

/// The plane x = a meets the saddle in the line z = (a - 1/4) (y + 1), y from 0 to 1; the plane y = b in z = (x - 1/4) (b + 1), x from 0 to 1.
#[test]
fn a_line_that_is_a_ruling_lies_in_the_face() {
    for swapped in [false, true] {
        let brep = saddle(swapped);
        for a in [0.0, 0.25, 0.3125, 0.5, 0.71875, 1.0] {
            let slope = a - 0.25;
            let along_y = ([a, -1.0, 0.0], [0.0, 1.0, slope], [1.0, 2.0]);
            // At x = -1: z = -5/4 (a + 1).
            let along_x = (
                [-1.0, a, -1.25 * (a + 1.0)],
                [0.5, 0.0, 0.5 * (a + 1.0)],
                [2.0, 4.0],
            );
            for (o, d, [start, end]) in [along_y, along_x] {
                let all = |kind| hits(&ask(&brep, o, d, kind));
                let whole = vec![(start, Some(end), true)];
                assert_eq!(all(LineKind::Line), whole, "{a} {d:?}");
                assert_eq!(all(LineKind::Ray), whole, "{a} {d:?}");
                let answer = ask(&brep, o, d, LineKind::Line);
                assert_eq!(answer.crossings, None);
                let p = Point3::from(o) + Vector3::from(d) * start;
                assert_eq!(answer.hits[0].point, p);
                // From the middle on, and the other way.
                let middle = 0.5 * (start + end);
                let m = [0, 1, 2].map(|c| o[c] + middle * d[c]);
                let rest = end - middle;
                let from = hits(&ask(&brep, m, d, LineKind::Ray));
                assert_eq!(from, [(0.0, Some(rest), true)]);
                let back = hits(&ask(&brep, m, d.map(|x| -x), LineKind::Segment));
                assert_eq!(back, [(0.0, Some(rest.min(1.0)), true)]);
                let answer = ask(&brep, m, d, LineKind::Ray);
                assert!((answer.hits[0].point - Point3::from(m)).norm() < 1e-15);
                let uv = answer.hits[0].uv;
                let at = if swapped { [uv.y, uv.x] } else { [uv.x, uv.y] };
                assert!(
                    (at[0] - m[0]).abs() + (at[1] - m[1]).abs() < 1e-14,
                    "{uv:?}"
                );
            }
        }
    }
}

/// Lines next to a ruling: parallel to it they meet nothing, turned about a point of it they meet this alone.
#[test]
fn a_line_next_to_a_ruling() {
    let brep = saddle(false);
    for e in [1e-3, 1e-6, 1e-9] {
        let above = ask(
            &brep,
            [0.5, 0.0, 0.25 + e],
            [0.0, 1.0, 0.25],
            LineKind::Line,
        );
        assert_eq!(hits(&above), []);
        let turned = ask(
            &brep,
            [0.5, 0.5, 0.375],
            [0.0, 1.0, 0.25 + e],
            LineKind::Line,
        );
        assert_eq!(turned.undecided, None, "{e}");
        assert_eq!((turned.hits.len(), turned.crossings), (1, Some(1)));
        assert!(turned.hits[0].t.bounds.lo <= 0.0 && turned.hits[0].t.bounds.hi >= 0.0);
    }
}

/// x = (u - 1/4)(v - 1/2) and z = (u - 1/4)(u - 3/4) are zero at u = 1/4 and at (3/4, 1/2); y = v + c u there from c / 4 to 1 + c / 4, and 1/2 + 3 c / 4.
#[test]
fn what_a_line_meets_beside_a_ruling() {
    let x = [[0.125, -0.25, 0.0], [-0.5, 1.0, 0.0], ZERO];
    let z = [[0.1875, 0.0, 0.0], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    for (c, beside) in [(2.0, Some(2.0)), (-2.0, Some(-1.0)), (0.5, None)] {
        let y = [[0.0, 1.0, 0.0], [c, 0.0, 0.0], ZERO];
        let answer = ask(&sheet([x, y, z]), [0.0; 3], [0.0, 1.0, 0.0], LineKind::Line);
        assert_eq!(answer.undecided, None, "{c}");
        let runs: Vec<_> = answer.hits.iter().filter(|h| h.t_end.is_some()).collect();
        assert_eq!(runs.len(), 1);
        let ends = [runs[0].t.value, runs[0].t_end.unwrap().value];
        assert_eq!(ends, [0.25 * c, 1.0 + 0.25 * c]);
        let points: Vec<_> = answer.hits.iter().filter(|h| h.t_end.is_none()).collect();
        assert_eq!(points.len(), usize::from(beside.is_some()), "{c}");
        for (hit, t) in points.iter().zip(beside) {
            assert!(hit.t.bounds.lo <= t && t <= hit.t.bounds.hi, "{hit:?}");
            assert!(!hit.tangential);
        }
    }
}

/// A ruling that is the joint of two patches, and runs over three: one hit.
#[test]
fn a_ruling_on_a_joint_of_patches() {
    // z = |x| (y + 1) / 2 over [-1, 1] x [0, 1], its knots at x = 0 and y = 1/4, 1/2.
    let mut points = Vec::new();
    for x in [-1.0, 0.0, 1.0f64] {
        for y in [0.0, 0.25, 0.5, 1.0] {
            points.push(Vector4::new(x, y, 0.5 * x.abs() * (y + 1.0), 1.0));
        }
    }
    let knots = [
        vec![-1.0, -1.0, 0.0, 1.0, 1.0],
        vec![0.0, 0.0, 0.25, 0.5, 1.0, 1.0],
    ];
    let brep = prepared(NurbsSurface::new([1, 1], [3, 4], points, knots).unwrap());
    for x in [-1.0, -0.5, 0.0, 0.75, 1.0f64] {
        let z = 0.5 * x.abs();
        let found = ask(&brep, [x, 0.0, z], [0.0, 1.0, z], LineKind::Line);
        assert_eq!(hits(&found), [(0.0, Some(1.0), true)], "{x}");
    }
}

/// Over a quarter of the plane z = x + y up to rising squares: (v (1 - u), v u, v^2), whose row v = 0 is the origin.
#[test]
fn a_line_through_a_pole_on_the_border() {
    let x = [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], ZERO];
    let y = [ZERO, [0.0, 1.0, 0.0], ZERO];
    let z = [[0.0, 0.0, 1.0], ZERO, ZERO];
    let brep = sheet([x, y, z]);
    for (d, others) in [
        ([0.0, 0.0, 1.0], vec![]),
        ([1.0, -1.0, 0.0], vec![]),
        ([-1.0, -1.0, 1.0], vec![]),
        // v (1 - u) = v u = v^2 at u = v = 1/2.
        ([1.0, 1.0, 1.0], vec![0.25]),
        // v (1 - u) = t, v u = 3 t, v^2 = 2 t: v = 4 t, so 16 t^2 = 2 t.
        ([1.0, 3.0, 2.0], vec![0.125]),
    ] {
        let answer = ask(&brep, d.map(|x| -x), d, LineKind::Line);
        assert_eq!(answer.undecided, None, "{d:?}");
        assert_eq!(answer.hits.len(), 1 + others.len(), "{d:?}");
        let first = &answer.hits[0];
        assert!(first.t.bounds.lo <= 1.0 && first.t.bounds.hi >= 1.0);
        assert_eq!((first.t_end, first.tangential), (None, false));
        assert_eq!(first.point, Point3::origin());
        for (hit, t) in answer.hits[1..].iter().zip(others) {
            let t = 1.0 + t;
            assert!(
                hit.t.bounds.lo <= t && t <= hit.t.bounds.hi,
                "{d:?} {hit:?}"
            );
        }
    }
    // Along the face's direction at u = 1/2 it is tangent: what is said must not be wrong.
    let answer = ask(&brep, [0.0; 3], [1.0, 1.0, 0.0], LineKind::Line);
    assert!(answer.undecided.is_some() || hits(&answer) == [(0.0, None, true)]);
}

/// z = x y over [0, 25] x [0, 1] in polynomials of degree 25: exact arithmetic on their knots goes beyond what f64 hold, and the borders' parameters
/// have all digits.
#[test]
fn rulings_of_high_degree() {
    let points: Vec<_> = (0..26)
        .flat_map(|i| [0.0, 1.0].map(|y| Vector4::new(i as f64, y, i as f64 * y, 1.0)))
        .collect();
    for (start, end) in [
        (0.0, 10.0),
        (0.0, 0.1),
        (-1e3, 1e3),
        (0.0, 1e-9),
        (0.3, 1e7),
    ] {
        let u = [vec![start; 26], vec![end; 26]].concat();
        let knots = [u, vec![0.0, 0.0, 1.0, 1.0]];
        let brep = prepared(NurbsSurface::new([25, 1], [26, 2], points.clone(), knots).unwrap());
        // In the middle of the domain x is 12.5, if the middle is a f64.
        for x in [0.0, 12.5, 25.0] {
            if x == 12.5 && (start + end != 10.0 && start + end != 0.0) {
                continue;
            }
            let found = ask(&brep, [x, 0.0, 0.0], [0.0, 1.0, x], LineKind::Line);
            assert_eq!(found.undecided, None, "{start} {end} {x}");
            assert_eq!(hits(&found), [(0.0, Some(1.0), true)]);
        }
    }
}

/// A sheet whose first and last rows are on the y axis, from 0 to 1 and from 1/2 to 2: one hit, told where the row is that it is on.
#[test]
fn rulings_that_overlap() {
    let rows = [
        [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        [[1.0, 0.0, 1.0], [1.0, 1.0, 2.0]],
        [[0.0, 0.5, 0.0], [0.0, 2.0, 0.0]],
    ];
    let points = rows.iter().flatten();
    let points = points.map(|[x, y, z]| Vector4::new(*x, *y, *z, 1.0));
    let knots = [vec![0.0, 0.0, 1.0, 2.0, 2.0], vec![0.0, 0.0, 1.0, 1.0]];
    let surface = NurbsSurface::new([1, 1], [3, 2], points.collect(), knots).unwrap();
    let brep = prepared(surface.clone());
    for (y, end) in [(-1.0, 3.0), (0.25, 1.75), (1.5, 0.5)] {
        let answer = ask(&brep, [0.0, y, 0.0], [0.0, 1.0, 0.0], LineKind::Ray);
        let start = 0.0f64.max(-y);
        assert_eq!(hits(&answer), [(start, Some(end), true)], "{y}");
        let hit = &answer.hits[0];
        let there = Surface::Nurbs(surface.clone()).point(hit.uv.x, hit.uv.y);
        assert!((there - hit.point).norm() < 1e-15, "{hit:?}");
    }
}
