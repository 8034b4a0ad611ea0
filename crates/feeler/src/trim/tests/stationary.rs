//! Stationary places of trim curves against closed forms.

use super::shapes::{bezier, line, nurbs};
use crate::brep::{Iso, TrimCurve, TrimKind};
use crate::numeric::{Ball, Dd, Interval, full_turn};
use crate::nurbs::{Arc, Curve, Curve2, PolyCurve};
use crate::trim::{AxisSplit, Stationary, trim_split};
use nalgebra::{Point2, Vector2};
use std::f64::consts::PI;

fn trim(span: [f64; 2], reversed: bool) -> TrimCurve {
    TrimCurve {
        curve: 0,
        span: Interval::new(span[0], span[1]).unwrap(),
        reversed,
        edge: None,
        edge_reversed: false,
        vertices: [0, 0],
        kind: TrimKind::Unknown,
        iso: Iso::None,
        trim_loop: 0,
    }
}

/// Of a trim in either direction.
fn split_over(curve: &Curve2, span: [f64; 2]) -> [AxisSplit; 2] {
    let found = trim_split(&trim(span, false), curve).unwrap();
    assert_eq!(trim_split(&trim(span, true), curve).unwrap(), found);
    for axis in &found {
        for pair in axis.places.windows(2) {
            assert!(pair[0].bounds.hi < pair[1].bounds.lo, "{pair:?}");
        }
        for place in &axis.places {
            let b = place.bounds;
            assert!(b.contains(place.t) && span[0] <= b.lo && b.hi <= span[1]);
            let ulp = place.t.abs().max(span[1] - span[0]) * f64::EPSILON;
            assert!(b.width() <= 8.0 * ulp, "{place:?}");
        }
    }
    found
}

fn split(curve: &Curve2) -> [AxisSplit; 2] {
    let d = curve.domain();
    split_over(curve, [d.start, d.end])
}

/// A place as it should be: where, how often the derivative vanishes below and above, its signs there.
type Wanted = (Ball<Dd>, [usize; 2], [i8; 2]);

fn at(t: f64) -> Ball<Dd> {
    Ball::exact(t)
}

fn assert_places(found: &[Stationary], wanted: &[Wanted]) {
    assert_eq!(found.len(), wanted.len(), "{found:?}");
    for (place, (t, multiplicity, sign)) in found.iter().zip(wanted) {
        let b = place.bounds;
        // To 1e-30, as far as the expectation itself is known.
        assert!(b.lo <= t.upper() && t.lower() <= b.hi, "{place:?} {t:?}");
        assert_eq!((place.multiplicity, place.sign), (*multiplicity, *sign));
        assert_eq!(place.turns(), sign[0] * sign[1] < 0);
    }
}

/// `u = 3 t`, `v' = 3 b(t)` for a quadratic in Bernstein form, over a domain.
fn integral(b: [f64; 3], domain: [f64; 2]) -> Curve2 {
    let v = [0.0, b[0], b[0] + b[1], b[0] + b[1] + b[2]];
    let points: Vec<[f64; 3]> = (0..4).map(|i| [f64::from(i), v[i as usize], 1.0]).collect();
    nurbs(3, &points, &[[domain[0]; 4], [domain[1]; 4]].concat())
}

#[test]
fn of_polynomials() {
    // (3t - 1)(4t - 3), on three domains; a third of a length is no f64.
    for domain in [[0.0, 1.0], [10.0, 14.0], [-7.0, -1.0]] {
        let third = (at(domain[0]) * at(2.0) + at(domain[1])) / at(3.0);
        let quarters = 0.25 * domain[0] + 0.75 * domain[1];
        let c = integral([3.0, -3.5, 2.0], domain);
        let [u, v] = split(&c);
        assert_eq!(u, AxisSplit::default());
        let wanted = [(third, [1, 1], [1, -1]), (at(quarters), [1, 1], [-1, 1])];
        assert_places(&v.places, &wanted);
        assert!(v.constant.is_empty());
        // A span that ends at one of them, and leaves the other out.
        let [_, v] = split_over(&c, [quarters, domain[1]]);
        assert_places(&v.places, &[(at(quarters), [0, 1], [0, 1])]);
        let [_, v] = split_over(&c, [domain[0], quarters]);
        let wanted = [(third, [1, 1], [1, -1]), (at(quarters), [1, 0], [-1, 0])];
        assert_places(&v.places, &wanted);
    }
    // (2t - 1)^2: no turn.
    let [_, v] = split(&integral([1.0, -1.0, 1.0], [0.0, 1.0]));
    assert_places(&v.places, &[(at(0.5), [2, 2], [1, 1])]);
    // t^2 and (1 - t)^2.
    let [_, v] = split(&integral([0.0, 0.0, 1.0], [0.0, 1.0]));
    assert_places(&v.places, &[(at(0.0), [0, 2], [0, 1])]);
    let [_, v] = split(&integral([-1.0, 0.0, 0.0], [0.0, 1.0]));
    assert_places(&v.places, &[(at(1.0), [2, 0], [-1, 0])]);
    // v' = 2 ((1 - t) e - t (1 + e)) vanishes at e / (1 + 2 e), whose bounds are narrow beside itself.
    let tiny = 2f64.powi(-60);
    let [_, v] = split(&bezier(&[
        [0.0, 0.0, 1.0],
        [1.0, tiny, 1.0],
        [2.0, -1.0, 1.0],
    ]));
    let root = at(tiny) / (at(1.0) + at(2.0 * tiny));
    assert_places(&v.places, &[(root, [1, 1], [1, -1])]);
    assert!(v.places[0].bounds.width() <= tiny * 1e-14);
}

/// The summit of two quadratics that meet at a knot, where both are stationary.
#[test]
fn at_knots() {
    let points = [
        [0.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [3.0, 1.0, 1.0],
        [4.0, 0.0, 1.0],
    ];
    let c = nurbs(2, &points, &[0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0]);
    let [u, v] = split(&c);
    assert_eq!(u, AxisSplit::default());
    assert_places(&v.places, &[(at(1.0), [1, 1], [1, -1])]);
    assert_eq!(v.places[0].bounds.width(), 0.0);
}

#[test]
fn of_lines_in_a_row() {
    let corners = [
        [0.0, 0.0],
        [1.0, 2.0],
        [2.0, 0.0],
        [3.0, 0.0],
        [4.0, 0.0],
        [4.0, 1.0],
        [4.0, 3.0],
    ];
    let segments = corners.windows(2).map(|w| line(w[0], w[1])).collect();
    let params = vec![0.0, 1.0, 3.0, 4.0, 6.0, 7.0, 9.0];
    let c: Curve2 = Curve::Poly(PolyCurve::new(segments, params).unwrap());
    let [u, v] = split(&c);
    assert_places(&u.places, &[]);
    assert_places(&v.places, &[(at(1.0), [0, 0], [1, -1])]);
    let constant = |s: &AxisSplit| -> Vec<[f64; 2]> {
        let ends = s.constant.iter();
        ends.map(|c| c.map(|e| e.lo)).collect()
    };
    assert_eq!(
        (constant(&u), constant(&v)),
        (vec![[6.0, 9.0]], vec![[3.0, 6.0]])
    );
    // Segments that only touch the span are no part of it.
    let [u, v] = split_over(&c, [1.0, 3.0]);
    assert_eq!((&u, &v), (&AxisSplit::default(), &AxisSplit::default()));
    let [u, v] = split_over(&c, [0.5, 3.5]);
    assert_places(&v.places, &[(at(1.0), [0, 0], [1, -1])]);
    assert_eq!((constant(&u), constant(&v)), (vec![], vec![[3.0, 3.5]]));
}

fn arc(x: [f64; 2], y: [f64; 2], angle: [f64; 2], domain: [f64; 2]) -> Curve2 {
    let interval = |i: [f64; 2]| Interval::new(i[0], i[1]).unwrap();
    let arc = Arc {
        center: Point2::new(5.0, -3.0),
        x: Vector2::from(x),
        y: Vector2::from(y),
        z: Vector2::zeros(),
        radius: 2.0,
        angle: interval(angle),
        domain: interval(domain),
    };
    Curve::Arc(Arc::new(arc).unwrap())
}

/// `k pi / 2`.
fn quarters(k: f64) -> Ball<Dd> {
    full_turn() * at(0.25 * k)
}

#[test]
fn of_arcs() {
    // u = cos, v = sin; then turned, mirrored, and of other lengths; each with the angles of its extrema in quarter turns.
    for (x, y, in_u, in_v) in [
        ([1.0, 0.0], [0.0, 1.0], (2.0, -1), (1.0, 1)),
        ([0.0, 3.0], [-1.0, 0.0], (1.0, -1), (2.0, -1)),
        ([-1.0, 0.0], [0.0, -2.0], (2.0, 1), (1.0, -1)),
        ([1e-3, 0.0], [0.0, -1.0], (2.0, -1), (1.0, -1)),
        ([0.0, -1.0], [-1.0, 0.0], (1.0, -1), (2.0, 1)),
    ] {
        // The parameter is the angle, or moves at another pace.
        for domain in [[0.5, 4.0], [-1.0, 6.0]] {
            let [u, v] = split(&arc(x, y, [0.5, 4.0], domain));
            for (found, (k, sign)) in [(u, in_u), (v, in_v)] {
                let share = (quarters(k) - at(0.5)) / at(3.5);
                let t = at(domain[0]) + share * Ball::difference(domain[1], domain[0]);
                assert_places(&found.places, &[(t, [1, 1], [sign, -sign])]);
                assert!(found.constant.is_empty());
            }
        }
    }
    // The direction 3 : 4 is at atan(4/3) before the extremum of v, and as far as pi - that before u's.
    let [u, v] = split(&arc([3.0, 4.0], [-4.0, 3.0], [0.25, 3.0], [0.25, 3.0]));
    for (found, t) in [
        (u, PI - (4f64 / 3.0).atan()),
        (v, PI / 2.0 - (4f64 / 3.0).atan()),
    ] {
        assert_eq!(found.places.len(), 1);
        assert!((found.places[0].t - t).abs() < 2e-15);
    }
}

#[test]
fn of_arcs_that_begin_or_end_at_an_extremum() {
    let quarter = quarters(1.0);
    for (x, sign) in [(1.0, -1), (-1.0, 1)] {
        let [u, v] = split(&arc([x, 0.0], [0.0, x], [0.0, 2.0], [0.0, 2.0]));
        assert_places(&u.places, &[(at(0.0), [0, 1], [0, sign])]);
        assert_places(&v.places, &[(quarter, [1, 1], [-sign, sign])]);
        let [u, _] = split(&arc([x, 0.0], [0.0, x], [-1.0, 0.0], [3.0, 4.0]));
        assert_places(&u.places, &[(at(4.0), [1, 0], [-sign, 0])]);
    }
}

#[test]
fn of_arcs_of_many_turns() {
    let [u, v] = split(&arc([1.0, 0.0], [0.0, 1.0], [0.1, 40.1], [0.1, 40.1]));
    // Multiples of pi, and halves between: 40.1 / pi = 12.76.
    let wanted = |first: f64, count: u32, sign: i8| -> Vec<Wanted> {
        let one = |i: u32| {
            let s = if i.is_multiple_of(2) { sign } else { -sign };
            (quarters(first + 2.0 * f64::from(i)), [1, 1], [s, -s])
        };
        (0..count).map(one).collect()
    };
    assert_places(&u.places, &wanted(2.0, 12, -1));
    assert_places(&v.places, &wanted(1.0, 13, 1));
    // More turns than are asked for: some 650.
    let many = arc([1.0, 0.0], [0.0, 1.0], [0.1, 4097.0], [0.0, 1.0]);
    assert!(trim_split(&trim([0.0, 1.0], false), &many).is_none());
}

/// An arc within a poly-curve, at another pace, and cut.
#[test]
fn of_arcs_in_a_row() {
    let first = arc([1.0, 0.0], [0.0, 1.0], [0.5, 4.0], [0.0, 1.0]);
    let from = first.point(1.0);
    let link = line(from.coords.into(), [3.0, 3.0]);
    let poly = PolyCurve::new(vec![first, link], vec![5.0, 9.0, 10.0]).unwrap();
    let c: Curve2 = Curve::Poly(poly);
    let t = |k: f64| at(5.0) + (quarters(k) - at(0.5)) * at(4.0) / at(3.5);
    // cos falls until pi and rises until 4, sin rises until pi / 2 and falls until 4; the line falls in u and rises in v.
    let joint = at(9.0);
    let [u, v] = split(&c);
    assert_places(
        &u.places,
        &[(t(2.0), [1, 1], [-1, 1]), (joint, [0, 0], [1, -1])],
    );
    assert_places(
        &v.places,
        &[(t(1.0), [1, 1], [1, -1]), (joint, [0, 0], [-1, 1])],
    );
    let [u, v] = split_over(&c, [7.0, 8.75]);
    assert_places(&u.places, &[(t(2.0), [1, 1], [-1, 1])]);
    assert_places(&v.places, &[]);
    // The arc only touches this span.
    assert_eq!(split_over(&c, [9.0, 10.0]), <[AxisSplit; 2]>::default());
}
