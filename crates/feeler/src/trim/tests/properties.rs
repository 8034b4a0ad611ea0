//! What must not change a side, and numbers that must not break one.

use super::shapes::*;
use crate::trim::{Side, TrimRegion};
use proptest::prelude::*;

const WIDE: [f64; 4] = [-4096.0, 4096.0, -4096.0, 4096.0];

/// Halves of a Bezier curve at 1/2; exact for small dyadics.
fn halves(points: &[[f64; 3]]) -> [Vec<[f64; 3]>; 2] {
    let mut d = points.to_vec();
    let (mut left, mut right) = (vec![], vec![]);
    while !d.is_empty() {
        left.push(d[0]);
        right.push(d[d.len() - 1]);
        d = d
            .windows(2)
            .map(|w| [0, 1, 2].map(|i| 0.5 * (w[0][i] + w[1][i])))
            .collect();
    }
    right.reverse();
    [left, right]
}

/// Homogeneous control points on a coarse grid, with weights 1/2 .. 2.
fn net() -> impl Strategy<Value = Vec<[f64; 3]>> {
    let point = (-64i32..=64, -64i32..=64, 2i32..=8).prop_map(|(x, y, w)| {
        let w = f64::from(w) / 4.0;
        [f64::from(x) * w / 4.0, f64::from(y) * w / 4.0, w]
    });
    proptest::collection::vec(point, 3..=6)
}

/// Points of the curve itself, nudged, and points anywhere on the grid.
fn asked(points: &[[f64; 3]], seeds: &[(u8, u8, i8, i8)]) -> Vec<[f64; 2]> {
    seeds
        .iter()
        .map(|(kind, t, i, j)| {
            if *kind < 64 {
                return [f64::from(*i) / 8.0, f64::from(*j) / 8.0];
            }
            let t = f64::from(*t) / 255.0;
            let mut d = points.to_vec();
            while d.len() > 1 {
                d = d
                    .windows(2)
                    .map(|w| [0, 1, 2].map(|i| w[0][i] * (1.0 - t) + w[1][i] * t))
                    .collect();
            }
            let nudge = |x: f64, n: i8| {
                (0..n.unsigned_abs() % 4)
                    .fold(x, |x, _| if n > 0 { x.next_up() } else { x.next_down() })
            };
            [nudge(d[0][0] / d[0][2], *i), nudge(d[0][1] / d[0][2], *j)]
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// A curve, its two halves as two trims, the same with a knot inserted, and the same moved by whole numbers.
    #[test]
    fn subdivision_knot_insertion_and_translation(
        points in net(),
        seeds in proptest::collection::vec(any::<(u8, u8, i8, i8)>(), 24),
        shift in (-512i32..512, -512i32..512),
    ) {
        let [left, right] = halves(&points);
        let p = points.len() - 1;
        let whole = TrimRegion::new(&face(WIDE, Some(vec![vec![bezier(&points).into()]])), 0);
        let split = TrimRegion::new(
            &face(WIDE, Some(vec![vec![bezier(&left).into(), bezier(&right).into()]])), 0);
        // The knot 1/2 with multiplicity p: the halves in one spline.
        let mut net = left.clone();
        net.extend(&right[1..]);
        let mut knots = vec![0.0; p + 1];
        knots.extend(vec![0.5; p]);
        knots.extend(vec![1.0; p + 1]);
        let inserted = TrimRegion::new(&face(WIDE, Some(vec![vec![nurbs(p, &net, &knots).into()]])), 0);
        let d = [f64::from(shift.0), f64::from(shift.1)];
        let moved: Vec<_> = points.iter().map(|q| [q[0] + d[0] * q[2], q[1] + d[1] * q[2], q[2]]).collect();
        let moved = TrimRegion::new(&face(WIDE, Some(vec![vec![bezier(&moved).into()]])), 0);
        for q in asked(&points, &seeds) {
            let side = whole.side(q.into());
            prop_assert!(side.side.is_some());
            prop_assert_eq!(side.side, split.side(q.into()).side, "halves, {:?}", q);
            prop_assert_eq!(side.side, inserted.side(q.into()).side, "knot, {:?}", q);
            let at = [q[0] + d[0], q[1] + d[1]];
            // Only where the point itself moves exactly.
            if at[0] - d[0] == q[0] && at[1] - d[1] == q[1] {
                prop_assert_eq!(side.side, moved.side(at.into()).side, "moved, {:?}", q);
            }
        }
    }
}

/// Linear maps of whole numbers: turns, mirrors, shears, scalings.
const MAPS: [[[f64; 2]; 2]; 6] = [
    [[0.0, 1.0], [1.0, 0.0]],
    [[0.0, -1.0], [1.0, 0.0]],
    [[1.0, 3.0], [0.0, 1.0]],
    [[-2.0, 0.0], [0.0, 0.125]],
    [[2.0, 1.0], [1.0, 1.0]],
    [[1.0, -1.0], [5.0, 3.0]],
];

/// The image of a point, if it is an f64 exactly.
fn mapped(m: &[[f64; 2]; 2], shift: [f64; 2], q: [f64; 2]) -> Option<[f64; 2]> {
    let exact = |x: f64| crate::numeric::Dyadic::from_f64(x).unwrap();
    let at = |k: usize| {
        let sum = m[k][0] * q[0] + m[k][1] * q[1] + shift[k];
        let products = &(&exact(m[k][0]) * &exact(q[0])) + &(&exact(m[k][1]) * &exact(q[1]));
        (&products + &exact(shift[k]) == exact(sum)).then_some(sum)
    };
    Some([at(0)?, at(1)?])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// Two curves, each closed by its chord: mapped affinely (u and v exchanged among the maps), their loops run the other way, in
    /// the other order, and from another trim on.
    #[test]
    fn affine_maps_and_the_order_of_loops(
        first in net(),
        second in net(),
        seeds in proptest::collection::vec(any::<(u8, u8, i8, i8)>(), 24),
        map in proptest::sample::select(&MAPS[..]),
        shift in (-64i32..64, -64i32..64),
    ) {
        let corner = |p: &[f64; 3]| [p[0] / p[2], p[1] / p[2]];
        // Exact: numbers of few digits, as their quotients are.
        let ends = |c: &[[f64; 3]]| (corner(&c[0]), corner(&c[c.len() - 1]));
        let closed = |c: &[[f64; 3]]| -> Vec<Use> {
            let (a, b) = ends(c);
            vec![bezier(c).into(), line(b, a).into()]
        };
        let both = |x: &[[f64; 3]], y: &[[f64; 3]]| {
            TrimRegion::new(&face(WIDE, Some(vec![closed(x), closed(y)])), 0)
        };
        let whole = both(&first, &second);
        let shift = [f64::from(shift.0), f64::from(shift.1)];
        let moved: Vec<Vec<[f64; 3]>> = [&first, &second]
            .iter()
            .map(|c| c.iter().map(|p| {
                let at = |k: usize| map[k][0] * p[0] + map[k][1] * p[1] + shift[k] * p[2];
                [at(0), at(1), p[2]]
            }).collect())
            .collect();
        let image = both(&moved[0], &moved[1]);
        let against = |c: &[[f64; 3]]| -> Vec<Use> {
            let (a, b) = ends(c);
            let back = Use { reversed: true, ..bezier(c).into() };
            vec![line(a, b).into(), back]
        };
        let other = TrimRegion::new(&face(WIDE, Some(vec![against(&second), against(&first)])), 0);
        for q in asked(&first, &seeds) {
            let side = whole.side(q.into());
            prop_assert!(side.side.is_some());
            prop_assert_eq!(side, other.side(q.into()), "the other way, {:?}", q);
            if let Some(at) = mapped(&map, shift, q) {
                prop_assert_eq!(side.side, image.side(at.into()).side, "mapped, {:?}", q);
            }
        }
    }
}

#[test]
fn numbers_at_the_edge_of_range() {
    // The range of a BREP ends at 1e60; small numbers go down to subnormal ones.
    let huge = 1e58;
    for s in [huge, 1e-300, 5e-324 * 1e8] {
        let corners = [
            [0.0, 0.0],
            [4.0 * s, 0.0],
            [4.0 * s, 4.0 * s],
            [0.0, 4.0 * s],
        ];
        let domain = [-8.0 * s, 8.0 * s, -8.0 * s, 8.0 * s];
        let region = TrimRegion::new(&face(domain, Some(vec![polygon(&corners)])), 0);
        let side = |q: [f64; 2]| region.side(q.into()).side;
        assert_eq!(side([s, s]), Some(Side::Inside), "{s}");
        assert_eq!(side([4.0 * s, s]), Some(Side::Boundary), "{s}");
        assert_eq!(side([5.0 * s, s]), Some(Side::Outside), "{s}");
        assert_eq!(side([-s, s]), Some(Side::Outside), "{s}");
        let round = TrimRegion::new(&face(domain, Some(vec![circle([0.0, 0.0], 5.0 * s)])), 0);
        let side = |q: [f64; 2]| round.side(q.into()).side;
        assert_eq!(side([3.0 * s, 2.0 * s]), Some(Side::Inside), "{s}");
        assert_eq!(side([5.0 * s, 0.0]), Some(Side::Boundary), "{s}");
        assert_eq!(side([4.0 * s, 4.0 * s]), Some(Side::Outside), "{s}");
    }
    // Weights at both ends of the range in one curve.
    let w = [1e59, 1e-59, 1.0];
    let p = [[-2.0, 0.0], [0.0, 2.0], [2.0, 0.0]];
    let net: Vec<[f64; 3]> = (0..3)
        .map(|i| [p[i][0] * w[i], p[i][1] * w[i], w[i]])
        .collect();
    let region = TrimRegion::new(&face(WIDE, Some(vec![vec![bezier(&net).into()]])), 0);
    assert_eq!(region.side([-1.0, 0.5].into()).side, Some(Side::Outside));
    assert_eq!(region.side([0.0, 0.0].into()).side, Some(Side::Boundary));
    for q in [[f64::INFINITY, 0.0], [f64::NEG_INFINITY, f64::INFINITY]] {
        assert_eq!(region.side(q.into()).side, Some(Side::Outside));
    }
}

#[test]
fn irregular_knots_at_high_degree_stay_affordable() {
    let mut x = 0.123_456_789_f64;
    let mut random = || {
        x = (x * 997.0 + 0.271_828_183).fract();
        x
    };
    for degree in [8usize, 25] {
        let n = degree + 4;
        let mut knots: Vec<f64> = (0..n + degree + 1)
            .map(|_| random() * 10f64.powi((random() * 6.0) as i32))
            .collect();
        knots.sort_by(f64::total_cmp);
        let net: Vec<[f64; 3]> = (0..n)
            .map(|_| {
                let w = 0.5 + random();
                [(random() * 8.0 - 4.0) * w, (random() * 8.0 - 4.0) * w, w]
            })
            .collect();
        let start = std::time::Instant::now();
        let region = TrimRegion::new(
            &face(WIDE, Some(vec![vec![nurbs(degree, &net, &knots).into()]])),
            0,
        );
        let mut undecided = 0;
        for p in region.pieces() {
            // Ends of pieces: as close to the boundary as f64 comes.
            let points = p.control_points();
            for c in [points[0], points[points.len() - 1]] {
                let side = region.side([c[0] / c[2], c[1] / c[2]].into());
                undecided += usize::from(side.side.is_none());
            }
        }
        assert_eq!(undecided, 0);
        eprintln!("degree {degree}: {:?}", start.elapsed());
        assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
    }
}
