//! Lines in round numbers against a native cylinder with its caps: through its axis, its seam and its rims, along rulings, in the planes of caps, tangent.

use crate::scenes;
use feeler::prepare::PreparedBrep;
use feeler::query::{LineAnswer, LineKind, LineProbe, Options, Workspace, line};
use nalgebra::Vector3;

/// A native cylinder with caps, its edges as they are.
fn cylinder(at: [f64; 3], radius: f64, height: f64, wide: f64) -> PreparedBrep {
    PreparedBrep::new(scenes::cylinder(at, [radius; 2], height, wide))
}

fn ask(brep: &PreparedBrep, origin: [f64; 3], d: [f64; 3]) -> LineAnswer {
    let probe = LineProbe::new(origin.into(), d.into(), LineKind::Line).unwrap();
    line(brep, &probe, &Options::default(), &mut Workspace::default())
}

/// Faces, parameters rounded, ends of intervals, and whether a hit is tangential: sorted by face.
fn hits(answer: &LineAnswer) -> Vec<(usize, f64, Option<f64>, bool)> {
    let of = answer.hits.iter();
    let of = of.map(|h| (h.face, h.t.value, h.t_end.map(|t| t.value), h.tangential));
    let mut all: Vec<_> = of.collect();
    all.sort_by(|a, b| a.partial_cmp(b).unwrap());
    all
}

/// Caps' planes that end at the circle, and beyond it.
const WIDE: [f64; 2] = [1.0, 1.5];

#[test]
fn lines_in_the_plane_of_a_cap() {
    for wide in WIDE {
        let part = cylinder([0.; 3], 5., 8., wide);
        // Through the middle along three directions, and at 3 from the middle: half a chord of 4.
        for (origin, d, ends) in [
            ([-10., 0., 8.], [1., 0., 0.], [5., 15.]),
            ([10., 0., 8.], [-1., 0., 0.], [5., 15.]),
            ([0., -10., 8.], [0., 2., 0.], [2.5, 7.5]),
            ([-6., -8., 8.], [3., 4., 0.], [1., 3.]),
            ([-10., 3., 8.], [1., 0., 0.], [6., 14.]),
            ([-3., 10., 8.], [0., -1., 0.], [6., 14.]),
            ([-10., -4., 8.], [0.5, 0., 0.], [14., 26.]),
        ] {
            let answer = ask(&part, origin, d);
            let expected = [
                (0, ends[0], None, false),
                (0, ends[1], None, false),
                (2, ends[0], Some(ends[1]), true),
            ];
            assert_eq!(hits(&answer), expected, "{origin:?} {d:?} {answer:?}");
            assert_eq!(
                (answer.undecided, answer.crossings, answer.in_crack),
                (None, None, false)
            );
            // One unit above there is nothing but the crack, below it the side alone.
            let below = ask(&part, [origin[0], origin[1], 8f64.next_down()], d);
            assert_eq!(
                (below.undecided, below.crossings, below.hits.len()),
                (None, Some(2), 2)
            );
            let above = ask(&part, [origin[0], origin[1], 8f64.next_up()], d);
            assert!(above.hits.is_empty());
        }
        // A tangent: one point of the cap and of the side. (Where it touches at the seam, ends of arcs that are no quotients leave it open.)
        for (origin, d) in [
            ([-10., 5., 8.], [1., 0., 0.]),
            ([-5., -10., 0.], [0., 1., 0.]),
        ] {
            let answer = ask(&part, origin, d);
            let all: Vec<_> = answer
                .hits
                .iter()
                .map(|h| (h.t.value, h.tangential))
                .collect();
            assert_eq!(all, [(10., true); 2], "{origin:?} {answer:?}");
            for by in [-1f64, 1.] {
                let k = if d[0] == 0. { 0 } else { 1 };
                let mut moved = origin;
                moved[k] = if by * origin[k] > 0. {
                    origin[k].next_up()
                } else {
                    origin[k].next_down()
                };
                let out = origin[k].abs() < moved[k].abs();
                let found = ask(&part, moved, d);
                assert!(!out || found.hits.is_empty(), "{moved:?} {found:?}");
            }
        }
    }
}

#[test]
fn lines_along_a_ruling() {
    for wide in WIDE {
        let part = cylinder([0.; 3], 5., 8., wide);
        for (x, y) in [
            (5., 0.),
            (-5., 0.),
            (0., 5.),
            (0., -5.),
            (3., 4.),
            (-4., 3.),
            (3., -4.),
        ] {
            for (from, d, ends) in [(-1., 1., [1., 9.]), (10., -2., [1., 5.])] {
                let answer = ask(&part, [x, y, from], [0., 0., d]);
                let mut expected = vec![(0, ends[0], Some(ends[1]), true)];
                let at = if d > 0. { ends } else { [ends[1], ends[0]] };
                expected.extend([(1, at[0], None, false), (2, at[1], None, false)]);
                assert_eq!(hits(&answer), expected, "{x} {y} {answer:?}");
                assert_eq!(
                    (answer.undecided, answer.crossings, answer.in_crack),
                    (None, None, false)
                );
            }
        }
    }
}

#[test]
fn lines_through_the_seam() {
    for wide in WIDE {
        let part = cylinder([0.; 3], 5., 8., wide);
        for (origin, d, count) in [
            ([-10., 0., 4.], [1., 0., 0.], 2),
            ([10., 0., 4.], [-1., 0., 0.], 2),
            ([5., -10., 4.], [0., 1., 0.], 0),
            ([5., -10., 14.], [0., 1., -1.], 0),
            ([0., 0., 4.], [5., 0., 1.], 2),
            ([4., -3., 4.], [1., 3., 0.], 2),
        ] {
            let answer = ask(&part, origin, d);
            assert_eq!(answer.undecided, None, "{origin:?} {d:?}");
            // Where it touches at the seam, it is in the passage of the seam's crack, which counts once.
            let expected = if count == 0 { 1 } else { count };
            assert_eq!(
                answer.crossings,
                Some(expected),
                "{origin:?} {d:?} {answer:?}"
            );
        }
    }
}

/// What is decided of a segment with ends off the surface has the parity of its ends' sides, if it meets no edge.
#[test]
fn moved_and_scaled() {
    for (at, radius, height) in [
        ([0.1, -0.3, 0.7], 2.5, 10.),
        ([1e6, 3., -1e3], 0.75, 1e-3),
        ([1. / 3., 1. / 7., 1e-9], 1. / 3., 2.),
    ] {
        for wide in WIDE {
            let part = cylinder(at, radius, height, wide);
            let top = at[2] + height;
            // In the plane of the cap, exactly: half of a chord through the middle is the radius to a unit or so.
            for d in [[1., 0., 0.], [0., 1., 0.], [1., 1., 0.], [3., -4., 0.]] {
                let origin = [at[0], at[1], top];
                let answer = ask(&part, origin, d);
                let norm = Vector3::from(d).norm();
                let of = answer.hits.iter().filter(|h| h.face == 2);
                let own: Vec<_> = of.filter_map(|h| Some([h.t, h.t_end?])).collect();
                if answer.undecided.is_none() {
                    assert_eq!(own.len(), 1, "{origin:?} {d:?} {answer:?}");
                }
                for [start, end] in own {
                    let near =
                        |x: f64| (x.abs() * norm - radius).abs() < 1e-9 * at[0].abs().max(1.);
                    assert!(near(start.value) && near(end.value), "{answer:?}");
                }
            }
        }
    }
}

/// Through points of a rim and of the interior, exactly: the rim counts once, for both of its faces; moved by one unit the line meets either face, or its
/// crack, and crosses as often.
#[test]
fn lines_through_a_rim() {
    let part = cylinder([0.; 3], 5., 8., 1.5);
    for p in [
        [3., 4., 8.],
        [-4., 3., 8.],
        [0., 5., 8.],
        [-5., 0., 0.],
        [3., -4., 0.],
    ] {
        for q in [[0.5, -1., 3.], [0., 0., 4.], [-2., 1., 7.]] {
            let d = [0, 1, 2].map(|c: usize| q[c] - p[c]);
            let from = [0, 1, 2].map(|c: usize| p[c] - d[c]);
            let answer = ask(&part, from, d);
            assert_eq!(
                (answer.undecided, answer.crossings, answer.in_crack),
                (None, Some(2), false),
                "{p:?} {q:?} {answer:?}"
            );
            // Through the middle it meets the other rim too.
            let count = if q == [0., 0., 4.] { 4 } else { 3 };
            assert_eq!(answer.hits.len(), count, "{p:?} {q:?}");
            for c in 0..3 {
                for by in [f64::next_up, f64::next_down] {
                    let mut moved = from;
                    moved[c] = by(moved[c]);
                    let answer = ask(&part, moved, d);
                    let told = answer.undecided.is_some() || answer.crossings == Some(2);
                    assert!(told, "{p:?} {q:?} {moved:?} {answer:?}");
                }
            }
        }
    }
}

/// Lines past a rim by as little as 1e-31 meet the side or the cap there, not both, or that is left open: at `y = 1` a cylinder of radius 2 has `x = sqrt(3)`, which is no quotient, and the line
/// comes to the cap's plane at a convergent of it. (One of every two convergents is below.)
#[test]
fn lines_beside_a_rim() {
    // sqrt(3) = [1; 1, 2, 1, 2, ...].
    let mut convergents = vec![[1u64, 1], [2, 1]];
    const LARGEST: u64 = 1 << 53;
    /// A convergent is about 1 / q^2 off: from here on below 2^-88, some hundred thousand roundings of a double-double.
    const LEAST_UNTOLD: u64 = 1 << 44;
    for part in [2, 1].into_iter().cycle() {
        let [.., a, b] = convergents[..] else {
            unreachable!()
        };
        let next = [0, 1].map(|k| a[k] + part * b[k]);
        if next[0] > LARGEST {
            break;
        }
        convergents.push(next);
    }
    let unit = 0.5f64.powi(52);
    let part = cylinder([0.; 3], 2., 8., 1.);
    for [p, q] in convergents[2..].iter().copied() {
        // Both are below 2^53: exact.
        let (rise, fall) = (p as f64 * unit, -(q as f64) * unit);
        let answer = ask(&part, [0., 1., rise], [1., 0., fall]);
        // Where x is that quotient the line is in the cap's plane; where it is sqrt(3), on the side.
        let below = u128::from(p) * u128::from(p) < 3 * u128::from(q) * u128::from(q);
        let met = [0, usize::from(below)];
        let mut faces: Vec<_> = answer.hits.iter().map(|h| h.face).collect();
        faces.sort_unstable();
        if answer.undecided.is_none() {
            assert_eq!(faces, met, "{p} {q} {answer:?}");
            assert_eq!(answer.crossings, Some(2), "{p} {q} {answer:?}");
        } else {
            // Both places are within what double-double tells: what is listed all the same is met.
            assert!(q > LEAST_UNTOLD, "{p} {q} {answer:?}");
            let times = |all: &[usize], face| all.iter().filter(|f| **f == face).count();
            assert!(
                (0..2).all(|f| times(&faces, f) <= times(&met, f)),
                "{p} {q} {answer:?}"
            );
        }
    }
}

/// Lines in the plane of a cap along short chords: the crack is passed at both ends, and each end has its hit.
#[test]
fn short_chords_in_the_plane_of_a_cap() {
    let part = cylinder([0.; 3], 5., 8., 1.);
    for depth in 1..=24 {
        // No round number: it is no quotient where the line meets the circle.
        let y = 5.0 - 0.9371 * 0.5f64.powi(depth);
        let answer = ask(&part, [-10., y, 8.], [1., 0., 0.]);
        let half = ((5.0 - y) * (5.0 + y)).sqrt();
        let (first, last) = (10.0 - half, 10.0 + half);
        let found = hits(&answer);
        let expected = [
            (0, first, None, false),
            (0, last, None, false),
            (2, first, Some(last), true),
        ];
        // `half` and the sums are off by some roundings of numbers up to 16.
        const NEAR: f64 = 16.0 * f64::EPSILON;
        let near = |a: f64, b: f64| (a - b).abs() <= NEAR;
        let is_met = found.len() == expected.len()
            && found.iter().zip(expected).all(|(a, b)| {
                let ends = match (a.2, b.2) {
                    (Some(a), Some(b)) => near(a, b),
                    (a, b) => a == b,
                };
                a.0 == b.0 && near(a.1, b.1) && ends && a.3 == b.3
            });
        assert!(is_met, "{depth} {answer:?}");
        assert_eq!(
            (answer.undecided, answer.in_crack),
            (None, false),
            "{depth} {answer:?}"
        );
    }
}
