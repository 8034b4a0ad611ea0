//! Regions that other tests do not have: curves that hardly rise, cuts that are no f64, more parts than a grid may hold.

use super::shapes::*;
use crate::nurbs::{Curve, PolyCurve};
use crate::trim::decide::{Joint, Part};
use crate::trim::piece::Piece;
use crate::trim::spline::Param;
use crate::trim::split::Trend;
use crate::trim::{BoxSide, Side, TrimRegion};

const WIDE: [f64; 4] = [-10.0, 10.0, -10.0, 10.0];

fn side(region: &TrimRegion, q: [f64; 2]) -> Side {
    region.side(q.into()).side.unwrap()
}

/// `v = 1 + 2^-20 u^2` has the height `1 + m^2 2^-52` at `u = m 2^-16`, both f64: next to it in u, where f64 cannot tell the heights apart.
#[test]
fn beside_a_curve_that_hardly_rises() {
    let rise = 2f64.powi(-20);
    let corners = [[1.0, 1.0 + rise], [1.0, 1.0], [0.0, 1.0]];
    let parabola = bezier(&[[0.0, 1.0, 1.0], [0.5, 1.0, 1.0], [1.0, 1.0 + rise, 1.0]]);
    let mut sides: Vec<Use> = vec![parabola.into()];
    sides.extend([[0, 1], [1, 2]].map(|[i, j]| Use::from(line(corners[i], corners[j]))));
    let region = TrimRegion::new(&face(WIDE, Some(vec![sides])), 0);
    for m in (1..65_536).step_by(61) {
        let (u, v) = (
            f64::from(m) / 65_536.0,
            1.0 + f64::from(m).powi(2) * 2f64.powi(-52),
        );
        assert_eq!(side(&region, [u, v]), Side::Boundary, "{m}");
        for off in [1e-8, 1e-10, 1e-12, 1e-15] {
            assert_eq!(side(&region, [u + off, v]), Side::Inside, "{m} {off:e}");
            assert_eq!(side(&region, [u - off, v]), Side::Outside, "{m} {off:e}");
        }
    }
}

/// An arch that ends on the domain's border and whose control points are beyond it, though none of its points is: the border bounds nothing.
#[test]
fn a_curve_within_a_domain_that_its_control_points_leave() {
    let arch = bezier(&[
        [1.0, 0.0, 1.0],
        [1.0, 1.25, 1.0],
        [0.0, 1.25, 1.0],
        [0.0, 0.0, 1.0],
    ]);
    for (top, inside) in [(1.0, true), (0.93751, true), (0.93749, false)] {
        let sides = vec![arch.clone().into(), line([0.0, 0.0], [1.0, 0.0]).into()];
        let region = TrimRegion::new(&face([0.0, 1.0, 0.0, top], Some(vec![sides])), 0);
        assert_eq!(region.pieces().all(|p| p.inside_domain), inside, "{top}");
        assert_eq!(region.pieces().len(), if inside { 2 } else { 6 }, "{top}");
        // Its greatest height is 15/16, at the middle.
        let [low, high] = region.piece(0).hull[1];
        assert!(
            low == 0.0 && (0.9375..0.9376).contains(&high),
            "{low} {high}"
        );
    }
}

/// A poly-curve that is cut at a third of a segment, which no f64 is: its point there is one, `(1, 1)` of `(3 s, 9 s^2)`.
#[test]
fn cut_at_a_third() {
    let points = [[0.0, 0.0, 1.0], [1.5, 0.0, 1.0], [3.0, 9.0, 1.0]];
    let parabola = nurbs(2, &points, &[1.0, 1.0, 1.0, 3.0, 3.0, 3.0]);
    let poly = PolyCurve::new(vec![parabola], vec![5.0, 11.0]).unwrap();
    for reversed in [false, true] {
        let cut = Use {
            curve: Curve::Poly(poly.clone()),
            span: Some([5.0, 7.0]),
            reversed,
        };
        let mut sides = polygon(&[[1.0, 1.0], [0.0, 1.0], [0.0, 0.0]]);
        sides.pop();
        sides.insert(0, cut);
        if reversed {
            let back = [([0.0, 0.0], [0.0, 1.0]), ([0.0, 1.0], [1.0, 1.0])];
            sides.splice(1.., back.map(|(a, b)| line(a, b).into()));
        }
        let region = TrimRegion::new(&face(WIDE, Some(vec![sides])), 0);
        // No gap anywhere: nothing had to be joined.
        assert_eq!(region.pieces().len(), 3);
        let mut expected = [5.0, 7.0];
        if reversed {
            expected.reverse();
        }
        let params = region.piece(0).params;
        let off = [0, 1].map(|i: usize| (params[i] - expected[i]).abs());
        assert!(off[0].max(off[1]) < 1e-14, "{params:?}");
        for k in 1..64 {
            let u = f64::from(k) / 64.0;
            assert_eq!(side(&region, [u, u * u]), Side::Boundary, "{u}");
            assert_eq!(side(&region, [u, (u * u).next_up()]), Side::Inside, "{u}");
            assert_eq!(
                side(&region, [u, (u * u).next_down()]),
                Side::Outside,
                "{u}"
            );
        }
        assert_eq!(side(&region, [1.0, 1.0]), Side::Boundary);
        assert_eq!(side(&region, [1.0f64.next_up(), 1.0]), Side::Outside);
    }
}

/// Boxes within a circle, beside it, across it.
#[test]
fn boxes_and_a_circle() {
    let region = TrimRegion::new(&face(WIDE, Some(vec![circle([0.0, 0.0], 5.0)])), 0);
    let of = |c: [f64; 2], h: f64| region.classify_box([c[0] - h, c[0] + h], [c[1] - h, c[1] + h]);
    for turn in [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]] {
        let at = |x: f64, y: f64| [turn[0] * x, turn[1] * y];
        assert_eq!(of(at(0.0, 0.0), 1.0), BoxSide::Inside);
        // The corner farthest out is at 4.95, nearest in at 5.09 from the centre; the box across holds (3, 4).
        assert_eq!(of(at(2.5, 2.5), 1.0), BoxSide::Inside);
        assert_eq!(of(at(4.6, 4.6), 1.0), BoxSide::Outside);
        assert_eq!(of(at(3.0, 4.0), 0.01), BoxSide::Mixed);
        assert_eq!(of(at(8.0, 0.0), 1.0), BoxSide::Outside);
    }
}

/// A star of 401 sides that each pass through nearly all of it: more parts a cell than a grid of that many cells may hold.
#[test]
fn a_star_of_long_sides() {
    const POINTS: usize = 401;
    let corner = |k: usize| {
        let a = (k * (POINTS / 2) % POINTS) as f64 / POINTS as f64 * std::f64::consts::TAU;
        [8.0 * a.cos(), 8.0 * a.sin()]
    };
    let corners: Vec<_> = (0..POINTS).map(corner).collect();
    let region = TrimRegion::new(&face(WIDE, Some(vec![polygon(&corners)])), 0);
    for i in 0..400 {
        let (r, a) = (8.0 * f64::from(i) / 400.0, f64::from(i) * 0.618);
        let q = [r * a.cos(), r * a.sin()];
        // By the definition, in f64; points nearer than that tells to a side are left out.
        let mut odd = false;
        let mut clear = true;
        for k in 0..POINTS {
            let (a, b) = (corners[k], corners[(k + 1) % POINTS]);
            let level = (b[0] - a[0]) * (q[1] - a[1]) - (b[1] - a[1]) * (q[0] - a[0]);
            clear &= level.abs() > 1e-9;
            odd ^= ((a[1] > q[1]) != (b[1] > q[1])) && ((level > 0.0) == (b[1] > a[1]));
        }
        if clear {
            let expected = if odd { Side::Inside } else { Side::Outside };
            assert_eq!(side(&region, q), expected, "{q:?}");
        }
    }
}

/// What a region holds is at least its lists, and lists hold no more than twice what is in them.
#[test]
fn bytes_are_those_of_the_lists() {
    let brep = face([-9.0, 9.0, -9.0, 9.0], Some(vec![circle([0.0, 0.0], 2.0)]));
    let region = TrimRegion::new(&brep, 0);
    let (pieces, parts) = (region.pieces().len(), region.loops().parts.len());
    let lists = pieces * size_of::<Piece>() + parts * (size_of::<Part>() + size_of::<Joint>());
    let bytes = region.bytes();
    assert!(lists <= bytes && bytes <= 2 * lists, "{lists} {bytes}");
    // A reference point for each of at least 256 cells, and a place in the list.
    region.side(nalgebra::Point2::new(0.1, 0.1));
    let cells = region.bytes() - bytes;
    assert!((256 * 5..256 * 64).contains(&cells), "{cells}");
}

/// What touches a rectangle from within is not proven to be inside, but along the border of the domain.
#[test]
fn boxes_that_touch_a_rectangle() {
    let region = |domain: [f64; 4]| {
        let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        TrimRegion::new(&face(domain, Some(vec![polygon(&corners)])), 0)
    };
    let (wide, tight) = (region(WIDE), region([0.0, 4.0, 0.0, 4.0]));
    for (u, v) in [
        ([0.0, 1.0], [1.0, 2.0]),
        ([3.0, 4.0], [1.0, 2.0]),
        ([1.0, 2.0], [0.0, 1.0]),
        ([1.0, 2.0], [3.0, 4.0]),
    ] {
        assert_eq!(wide.classify_box(u, v), BoxSide::Mixed, "{u:?} {v:?}");
        assert_eq!(tight.classify_box(u, v), BoxSide::Inside, "{u:?} {v:?}");
    }
    assert_eq!(wide.classify_box([1.0, 2.0], [1.0, 2.0]), BoxSide::Inside);
    assert_eq!(wide.classify_box([4.0, 5.0], [1.0, 2.0]), BoxSide::Mixed);
}

/// A loop that goes on beyond a border of the domain leaves boxes at it inside; one that ends short of it, by as little, does not.
#[test]
fn boxes_at_a_border_that_a_loop_goes_beyond() {
    for off in [0.5f64.powi(49), 0.5f64.powi(20), 1.0] {
        for (off, inside) in [(off, true), (-off, false)] {
            let corners = [
                [0.0, 0.0],
                [4.0, 0.0],
                [4.0 + off, 2.0],
                [4.0, 4.0],
                [0.0, 4.0],
            ];
            let region = TrimRegion::new(
                &face([0.0, 4.0, 0.0, 4.0], Some(vec![polygon(&corners)])),
                0,
            );
            let near = 4.0 - 0.5f64.powi(40);
            for (u, v) in [
                ([near, 4.0], [1.0, 1.25]),
                ([near, 4.0], [1.5, 2.5]),
                ([near, 4.0], [0.0, 4.0]),
                ([near, 5.0], [1.0, 1.25]),
            ] {
                let side = region.classify_box(u, v);
                assert_eq!(side == BoxSide::Inside, inside, "{off} {u:?} {v:?}");
            }
        }
    }
}

/// The same along the border for a loop that is no rectangle: a box with a side on it is inside, one across a loop's other side is not.
#[test]
fn boxes_along_the_border_of_the_domain() {
    let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 2.0], [0.0, 4.0]];
    let region = TrimRegion::new(
        &face([0.0, 4.0, 0.0, 4.0], Some(vec![polygon(&corners)])),
        0,
    );
    for (u, v) in [
        ([0.0, 0.5], [0.5, 1.0]),
        ([3.5, 4.0], [0.5, 1.0]),
        ([1.0, 3.0], [0.0, 1.0]),
        ([0.0, 4.0], [0.0, 1.0]),
    ] {
        assert_eq!(region.classify_box(u, v), BoxSide::Inside, "{u:?} {v:?}");
    }
    // A box at the border, within the notch, that nothing of the region meets; one across the notch.
    assert_eq!(
        region.classify_box([1.5, 2.5], [3.0, 4.0]),
        BoxSide::Outside
    );
    assert_eq!(region.classify_box([1.0, 3.0], [1.0, 3.0]), BoxSide::Mixed);
    // Along a side that is flat, and no border.
    let low = [[1.0, 1.0], [3.0, 1.0], [3.0, 4.0], [2.0, 2.0], [1.0, 4.0]];
    let region = TrimRegion::new(&face([0.0, 4.0, 0.0, 4.0], Some(vec![polygon(&low)])), 0);
    assert_eq!(region.classify_box([1.2, 1.4], [1.0, 1.5]), BoxSide::Mixed);
    assert_eq!(region.classify_box([1.0, 1.4], [1.2, 1.5]), BoxSide::Mixed);
}

/// Boxes next to the corner of a loop that is on a side of the domain: beside it, however little, they are outside, within it inside; with it
/// they are neither.
#[test]
fn boxes_beside_a_corner_on_a_line() {
    let corners = [[0.0, 0.0], [4.0, 0.0], [2.0, 4.0]];
    let turn = |k: usize, [u, v]: [f64; 2]| match k {
        0 => [u, v],
        1 => [v, u],
        2 => [u, 4.0 - v],
        _ => [4.0 - v, u],
    };
    let hair = 2.0 * f64::EPSILON;
    for k in 0..4 {
        let triangle = polygon(&corners.map(|p| turn(k, p)));
        let region = TrimRegion::new(&face([0.0, 4.0, 0.0, 4.0], Some(vec![triangle])), 0);
        let of = |u: [f64; 2], v: [f64; 2]| {
            let (a, b) = (turn(k, [u[0], v[0]]), turn(k, [u[1], v[1]]));
            let range = |i: usize| [a[i].min(b[i]), a[i].max(b[i])];
            region.classify_box(range(0), range(1))
        };
        for v in [[4.0, 4.0], [4.0, 5.0]] {
            assert_eq!(of([2.0 + hair, 3.0], v), BoxSide::Outside, "{k} {v:?}");
            assert_eq!(of([1.0, 2.0 - hair], v), BoxSide::Outside, "{k} {v:?}");
            assert_eq!(of([2.0 - hair, 2.0 + hair], v), BoxSide::Mixed, "{k} {v:?}");
            assert_eq!(of([2.0, 3.0], v), BoxSide::Mixed, "{k} {v:?}");
        }
        // The sides are 5e-12 from the corner in u at the lower height.
        let v = [4.0 - 1e-11, 4.0];
        assert_eq!(of([2.0 - 2e-10, 2.0 - 1e-11], v), BoxSide::Outside, "{k}");
        assert_eq!(of([2.0 + 1e-11, 2.0 + 2e-10], v), BoxSide::Outside, "{k}");
        assert_eq!(of([2.0 - 2e-10, 2.0 - 4e-12], v), BoxSide::Mixed, "{k}");
        let within = of([2.0 - 4e-12, 2.0 + 4e-12], [4.0 - 2e-11, 4.0 - 1e-11]);
        assert_eq!(within, BoxSide::Inside, "{k}");
    }
}

/// A parabola that comes nearer to a side of the domain than f64 tells: on that side nothing is in the region, unless it is reached.
#[test]
fn a_side_that_a_curve_hardly_reaches() {
    // 1/4 (y0 + 1/2) + 1/2 y1 is about the top of the parabola: 2^-56 below 1 at first.
    let low = 0.5 - 2f64.powi(-54);
    for (top, expected) in [(1.5, BoxSide::Outside), (1.5f64.next_up(), BoxSide::Mixed)] {
        let cap = bezier(&[[0.25, low, 1.0], [0.5, top, 1.0], [0.75, 0.5, 1.0]]);
        let sides = vec![cap.into(), line([0.75, 0.5], [0.25, low]).into()];
        let region = TrimRegion::new(&face([0.0, 1.0, 0.0, 1.0], Some(vec![sides])), 0);
        let side = region.classify_box([0.0, 1.0], [1.0, 1.0]);
        assert_eq!(side, expected, "{top}");
    }
}

/// Of a part of a parabola: it holds both its ends and what is between, and is no more than its control polygon's.
#[test]
fn boxes_of_parts_hold_their_ends() {
    // (t, 4 t (1 - t)): over [a, b] the middle control point is ((a + b) / 2, 2 (a + b) - 4 a b).
    let cap = vec![
        bezier(&[[0.0, 0.0, 1.0], [0.5, 2.0, 1.0], [1.0, 0.0, 1.0]]).into(),
        line([1.0, 0.0], [0.0, 0.0]).into(),
    ];
    let region = TrimRegion::new(&face(WIDE, Some(vec![cap])), 0);
    // Before it is told how far its parts reach.
    let piece = Piece::new(region.loops().pieces[0].source.clone());
    for (a, b) in [(0.0, 1.0), (0.125, 0.375), (0.25, 0.75), (0.5, 1.0)] {
        let height = |t: f64| 4.0 * t * (1.0 - t);
        let middle = 2.0 * (a + b) - 4.0 * a * b;
        let heights = [height(a), height(b), middle];
        let expected = [
            [a, b],
            [
                heights.iter().fold(f64::INFINITY, |m, x| m.min(*x)),
                heights.iter().fold(0.0, |m: f64, x| m.max(*x)),
            ],
        ];
        for axis in 0..2 {
            let [lo, hi] = piece.sub_hull(axis, [a, b], &piece.source.balls());
            let [from, to] = expected[axis];
            assert!(lo <= from && from - lo < 1e-14, "{axis} [{a}, {b}]: {lo}");
            assert!(hi >= to && hi - to < 1e-14, "{axis} [{a}, {b}]: {hi}");
        }
    }
}

/// A curve cut where it is lowest, at a parameter where its control points are no f64: it rises from there on, as the integers tell.
#[test]
fn cut_where_the_derivative_is_zero() {
    // (s, c s^2) / (1 + s^2) with s = t - 1/4, c of few bits, so that all of its control points are f64.
    let c = f64::from(0.7_f32);
    let [s, squared] = [[-4.0, 4.0, 12.0], [1.0, -3.0, 9.0]].map(|b| b.map(|x| x / 16.0));
    let points = [0, 1, 2].map(|i| [s[i], c * squared[i], 1.0 + squared[i]]);
    let cut = Use {
        curve: bezier(&points),
        span: Some([0.25, 1.0]),
        reversed: false,
    };
    let end = [points[2][0] / points[2][2], points[2][1] / points[2][2]];
    let sides = vec![cut, line(end, [0.0, 0.0]).into()];
    let region = TrimRegion::new(&face(WIDE, Some(vec![sides])), 0);
    let parts = region.loops().parts.iter().filter(|p| p.piece == 0);
    let parts: Vec<_> = parts.map(|p| (p.trends, p.t(region.loops()))).collect();
    assert_eq!(parts, [([Trend::Up; 2], [0.0, 1.0])]);
}

/// 1/3, against f64 on either side.
#[test]
fn parameters_that_are_no_f64() {
    use std::cmp::Ordering::{Equal, Greater, Less};
    let third = Param::mapped(1.0, [0.0, 3.0], [0.0, 1.0]);
    // As f64 it is rounded down.
    let near: f64 = 1.0 / 3.0;
    for (x, is) in [
        (0.25, Greater),
        (near, Greater),
        (near.next_up(), Less),
        (0.5, Less),
        (1.0, Less),
    ] {
        assert_eq!(third.compare(x), is, "{x}");
    }
    assert_eq!(
        Param::mapped(3.0, [0.0, 3.0], [0.0, 1.0]).compare(1.0),
        Equal
    );
}
