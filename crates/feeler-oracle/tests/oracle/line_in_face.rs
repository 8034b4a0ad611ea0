//! Lines that lie in curved faces, pass poles and seams, or hit loops exactly.

use crate::scene::{bezier, brep, dyadic, line as segment, patch, polygon};
use feeler::numeric::Dyadic;
use feeler::nurbs::{Curve2, NurbsSurface, Surface};
use feeler::query::LineKind;
use feeler_oracle::{LineTruth, Oracle, TruthEnclosure};
use nalgebra::Vector4;

fn oracle(s: Surface, loops: Option<Vec<Vec<Curve2>>>) -> Oracle {
    Oracle::new(&[&brep(s, loops)]).unwrap()
}

fn line(o: &Oracle, origin: [f64; 3], direction: [f64; 3]) -> LineTruth {
    let t = o.line(origin, direction, LineKind::Line).unwrap();
    assert!(t.open.is_empty(), "{origin:?} {direction:?} {t:?}");
    t
}

/// Whether `e` holds `x` and is no wider than 2^-150.
fn is_narrow_about(e: &TruthEnclosure, x: f64) -> bool {
    let limit: Dyadic = "1p-150".parse().unwrap();
    e.contains(&dyadic(x)) && e.width() <= limit
}

/// The intervals on which the line lies in the face.
fn assert_intervals(t: &LineTruth, expected: &[[f64; 2]]) {
    assert_eq!(t.hits.len(), expected.len(), "{t:?}");
    for (h, [from, to]) in t.hits.iter().zip(expected) {
        let end = h.t_end.as_ref().expect("an interval");
        assert!(is_narrow_about(&h.t, *from), "{from} {t:?}");
        assert!(is_narrow_about(end, *to), "{to} {t:?}");
        assert!(h.tangential && !h.transversal && h.multiplicity.is_none());
    }
}

/// z = x^2 - y^2 over [-1, 1]^2.
fn saddle() -> Surface {
    let square = [1.0, -1.0, 1.0];
    let net = (0..9)
        .map(|k| {
            let (i, j) = (k / 3, k % 3);
            [i as f64 - 1.0, j as f64 - 1.0, square[i] - square[j], 1.0]
        })
        .collect();
    patch(2, 2, net)
}

/// The circle of radius `r` about (1/2, 1/2) in uv, counter-clockwise.
fn round(r: f64) -> Vec<Curve2> {
    (0..4)
        .map(|k| {
            let turn = |[x, y, w]: [f64; 3]| match k {
                0 => [x + 0.5 * w, y + 0.5 * w, w],
                1 => [-y + 0.5 * w, x + 0.5 * w, w],
                2 => [-x + 0.5 * w, -y + 0.5 * w, w],
                _ => [y + 0.5 * w, -x + 0.5 * w, w],
            };
            bezier(&[
                turn([r, 0.0, 1.0]),
                turn([r, r, 1.0]),
                turn([0.0, 2.0 * r, 2.0]),
            ])
        })
        .collect()
}

#[test]
fn rulings_of_a_saddle() {
    let o = oracle(saddle(), None);
    // x = y, z = 0; then x - y = 1/4, x + y = s, z = s / 4.
    assert_intervals(&line(&o, [0.0; 3], [1.0, 1.0, 0.0]), &[[-1.0, 1.0]]);
    let t = line(&o, [0.25, 0.0, 0.0625], [1.0, 1.0, 0.5]);
    assert_intervals(&t, &[[-1.0, 0.75]]);
    // Beside it by the least double there is: two crossings or none, no interval.
    let t = line(&o, [0.25, 0.0, 0.0625f64.next_up()], [1.0, 1.0, 0.5]);
    assert!(t.hits.iter().all(|h| h.t_end.is_none()), "{t:?}");
    // Only a part of it.
    let t = o
        .line([0.0; 3], [0.5, 0.5, 0.0], LineKind::Segment)
        .unwrap();
    assert!(t.open.is_empty());
    assert_intervals(&t, &[[0.0, 1.0]]);

    // Trimmed by a disc with a hole: x = y = 2 u - 1 is in it for |x| in sqrt(1/2) [1/4, 3/4].
    let hole: Vec<Curve2> = round(0.125);
    let o = oracle(saddle(), Some(vec![round(0.375), hole]));
    let t = line(&o, [0.0; 3], [1.0, 1.0, 0.0]);
    assert_eq!(t.hits.len(), 2, "{t:?}");
    let (near, far) = (0.25 * 0.5f64.sqrt(), 0.75 * 0.5f64.sqrt());
    for (h, ends) in t.hits.iter().zip([[-far, -near], [near, far]]) {
        let found = [&h.t, h.t_end.as_ref().unwrap()];
        for (e, x) in found.iter().zip(ends) {
            assert!((e.lo.approximate() - x).abs() < 1e-15, "{t:?}");
            assert!(e.width() < dyadic(1e-45));
        }
    }

    // Trimmed by a triangle that touches it in a corner, at x = y = 1/2.
    let corner = polygon(&[[0.75, 0.75], [1.0, 0.0], [1.0, 0.5]]);
    let o = oracle(saddle(), Some(vec![corner]));
    let t = line(&o, [0.0; 3], [1.0, 1.0, 0.0]);
    assert_eq!(t.hits.len(), 1, "{t:?}");
    assert!(t.hits[0].boundary && t.hits[0].t_end.is_none());
    assert!(is_narrow_about(&t.hits[0].t, 0.5));
}

#[test]
fn a_ruling_and_another_crossing() {
    // z = x y (x - y / 2 + ...): the line y = 0 = z lies in z = y (x^2 + y^2 - 1/4), and so do no others.
    // Bernstein of y in degree 3: -1, -1/3, 1/3, 1; homogeneous times 3. Of y^3: -1, 1, -1, 1.
    let (one, linear, cube) = ([3.0; 4], [-3.0, -1.0, 1.0, 3.0], [-3.0, 3.0, -3.0, 3.0]);
    let square = [1.0, -1.0, 1.0];
    let mut net = Vec::new();
    for i in 0..3 {
        for j in 0..4 {
            let x = i as f64 - 1.0;
            // y (x^2 - 1/4) + y^3
            let z = linear[j] * (square[i] - 0.25) + cube[j];
            net.push([3.0 * x, linear[j], z, one[j]]);
        }
    }
    let o = oracle(patch(2, 3, net), None);
    assert_intervals(&line(&o, [0.0; 3], [2.0, 0.0, 0.0]), &[[-0.5, 0.5]]);
    // x = 0 = z crosses where y = 0, 1/2 and -1/2.
    let t = line(&o, [0.0; 3], [0.0, 1.0, 0.0]);
    assert_eq!(t.hits.len(), 3, "{t:?}");
    for (h, y) in t.hits.iter().zip([-0.5, 0.0, 0.5]) {
        assert!(is_narrow_about(&h.t, y), "{t:?}");
        assert_eq!(h.multiplicity, Some(1));
    }
}

#[test]
fn planar_nurbs() {
    // z = x / 2 + y over [0, 4]^2 as a bilinear patch, less a square.
    let net = [[0.0, 0.0], [0.0, 4.0], [4.0, 0.0], [4.0, 4.0]]
        .map(|[x, y]| [x, y, 0.5 * x + y, 1.0])
        .to_vec();
    let frame = polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let hole = polygon(&[[0.25, 0.25], [0.25, 0.75], [0.75, 0.75], [0.75, 0.25]]);
    let o = oracle(patch(1, 1, net), Some(vec![frame, hole]));
    let t = line(&o, [-2.0, 2.0, 1.0], [1.0, 0.0, 0.5]);
    assert_intervals(&t, &[[2.0, 3.0], [5.0, 6.0]]);
    // Along the hole's edge, then the whole way.
    let t = line(&o, [-2.0, 1.0, 0.0], [1.0, 0.0, 0.5]);
    assert_intervals(&t, &[[2.0, 6.0]]);
    // Along the border.
    let t = line(&o, [-2.0, 4.0, 3.0], [1.0, 0.0, 0.5]);
    assert_intervals(&t, &[[2.0, 6.0]]);
    assert!(t.hits[0].boundary);
}

/// The whole cylinder of radius 5 about z, 0 <= z <= 1, or the cone with its apex at (0, 0, 1): four
/// exact rational quarters, the weights of each twice those of the one before.
fn turned(cone: bool) -> Surface {
    let quarter = [[5.0, 0.0, 1.0], [5.0, 5.0, 1.0], [0.0, 10.0, 2.0]];
    let mut net = Vec::new();
    for k in 0..4 {
        for (i, &[x, y, w]) in quarter.iter().enumerate() {
            if k > 0 && i == 0 {
                continue;
            }
            let s = 2f64.powi(k);
            let [x, y] = match k {
                0 => [x, y],
                1 => [-y, x],
                2 => [-x, -y],
                _ => [y, -x],
            };
            net.push(Vector4::new(s * x, s * y, 0.0, s * w));
            net.push(if cone {
                Vector4::new(0.0, 0.0, s * w, s * w)
            } else {
                Vector4::new(s * x, s * y, s * w, s * w)
            });
        }
    }
    let knots_u = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    Surface::Nurbs(
        NurbsSurface::new([2, 1], [9, 2], net, [knots_u, vec![0.0, 0.0, 1.0, 1.0]]).unwrap(),
    )
}

#[test]
fn generators_and_seams_of_a_cylinder() {
    let o = oracle(turned(false), None);
    // Generators: inside a patch, on a joint, on the seam.
    for [x, y] in [[3.0, 4.0], [-4.0, 3.0], [0.0, 5.0], [5.0, 0.0]] {
        assert_intervals(&line(&o, [x, y, -3.0], [0.0, 0.0, 2.0]), &[[1.5, 2.0]]);
    }
    for x in [5f64.next_up(), 5f64.next_down()] {
        assert!(line(&o, [x, 0.0, -3.0], [0.0, 0.0, 2.0]).hits.is_empty());
    }
    // Across: at the seam once.
    let t = line(&o, [0.0, 0.0, 0.5], [1.0, 0.0, 0.0]);
    assert_eq!(t.hits.len(), 2, "{t:?}");
    assert!(is_narrow_about(&t.hits[0].t, -5.0) && is_narrow_about(&t.hits[1].t, 5.0));
    assert!(t.hits[1].boundary && !t.hits[0].boundary);
    assert!(
        t.hits
            .iter()
            .all(|h| h.transversal && h.multiplicity == Some(1))
    );
    // Tangent: on a joint, on the seam, inside a patch.
    for [x, y] in [[0.0, 5.0], [5.0, 0.0], [3.0, 4.0], [-4.0, -3.0]] {
        let t = line(&o, [x, y, 0.5], [-y, x, 0.0]);
        assert_eq!(t.hits.len(), 1, "{t:?}");
        assert!(is_narrow_about(&t.hits[0].t, 0.0), "{t:?}");
        assert!(!t.hits[0].transversal);
        assert_eq!(t.hits[0].multiplicity, Some(2), "{x} {y} {t:?}");
        // Nearly so.
        let far = 1.0 + 2f64.powi(-50);
        assert!(
            line(&o, [far * x, far * y, 0.5], [-y, x, 0.0])
                .hits
                .is_empty()
        );
        let near = 1.0 - 2f64.powi(-50);
        let t = line(&o, [near * x, near * y, 0.5], [-y, x, 0.0]);
        assert_eq!(t.hits.len(), 2, "{t:?}");
        // Half the chord is 5 sqrt(1 - near^2), and the direction 5 long.
        let half = ((1.0 - near) * (1.0 + near)).sqrt();
        for (h, at) in t.hits.iter().zip([-half, half]) {
            assert!((h.t.lo.approximate() - at).abs() < 1e-15 * half, "{t:?}");
        }
    }
    // Along the rim in its plane: a point of the border.
    let t = line(&o, [0.0, 4.0, 1.0], [1.0, 0.0, 0.0]);
    assert_eq!(t.hits.len(), 2, "{t:?}");
    for (h, x) in t.hits.iter().zip([-3.0, 3.0]) {
        assert!(h.boundary && is_narrow_about(&h.t, x));
    }
}

/// A line along the tangent of one of two patches at their joint: what the other is like there tells whether it touches the surface or passes it.
#[test]
fn what_is_touched_on_one_side_of_a_joint() {
    // z over x from -1 to 1, in two pieces: -x^2 at one side, and these at the other.
    for (other, passes) in [
        ([1.0, 0.5], true),    // -x
        ([-1.0, -0.5], false), // x
        ([-1.0, 0.0], false),  // -x^2
        ([1.0, 0.0], true),    // x^2
    ] {
        for mirrored in [false, true] {
            let z = [other[0], other[1], 0.0, 0.0, -1.0];
            let net = (0..5).flat_map(|i| {
                let z = z[if mirrored { 4 - i } else { i }];
                let x = 0.5 * i as f64 - 1.0;
                [-1.0, 1.0].map(|y| Vector4::new(x, y, z, 1.0))
            });
            let knots = [
                vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0],
                vec![0.0, 0.0, 1.0, 1.0],
            ];
            let surface = NurbsSurface::new([2, 1], [5, 2], net.collect(), knots).unwrap();
            let o = oracle(Surface::Nurbs(surface), None);
            // As its forms are taken in either order.
            for direction in [[1.0, 0.25, 0.0], [0.25, 1.0, 0.0], [-1.0, 0.5, 0.0]] {
                let t = line(&o, [0.0, 0.25, 0.0], direction);
                assert_eq!(t.hits.len(), 1, "{t:?}");
                let h = &t.hits[0];
                assert_eq!(
                    (h.transversal, h.tangential),
                    (passes, !passes),
                    "{other:?} {mirrored} {direction:?}"
                );
            }
        }
    }
}

/// The same at a seam, of which one side is off the region by a hair: the surface goes on there.
#[test]
fn what_is_touched_at_a_seam_out_of_the_region() {
    let tiny = 2f64.powi(-50);
    let loops = || vec![polygon(&[[tiny, 0.0], [4.0, 0.0], [4.0, 1.0], [tiny, 1.0]])];
    for (off, passes) in [(-2f64.powi(-40), false), (2f64.powi(-40), true)] {
        let Surface::Nurbs(whole) = turned(false) else {
            unreachable!()
        };
        let mut net = whole.control_net().to_vec();
        // The last control points but one, in front of the tangent plane at the seam or behind it.
        for p in &mut net[14..16] {
            p.x += off;
        }
        let knots = [whole.knots_u(), whole.knots_v()].map(|k| k.knots().to_vec());
        let surface = || NurbsSurface::new([2, 1], [9, 2], net.clone(), knots.clone()).unwrap();
        for loops in [None, Some(loops())] {
            let o = oracle(Surface::Nurbs(surface()), loops);
            let t = line(&o, [5.0, 0.0, 0.5], [0.0, 1.0, 0.0]);
            assert_eq!(t.hits.len(), if passes { 2 } else { 1 }, "{t:?}");
            let at = t.hits.iter().find(|h| is_narrow_about(&h.t, 0.0)).unwrap();
            assert_eq!((at.transversal, at.tangential), (passes, !passes), "{t:?}");
        }
    }
}

#[test]
fn poles_and_generators_of_a_cone() {
    let o = oracle(turned(true), None);
    // Through the apex only; through the apex and along generators.
    let t = line(&o, [0.0; 3], [0.0, 0.0, 1.0]);
    assert_eq!(t.hits.len(), 1, "{t:?}");
    assert!(t.hits[0].boundary && is_narrow_about(&t.hits[0].t, 1.0));
    for [x, y] in [[3.0, 4.0], [0.0, 5.0], [5.0, 0.0], [-4.0, 3.0]] {
        assert_intervals(&line(&o, [x, y, 0.0], [-x, -y, 1.0]), &[[0.0, 1.0]]);
    }
    // Trimmed to two separate parts of the pole's side, and to none of it: v = 1 is the pole.
    let wedge = |a: f64, b: f64| polygon(&[[a, 0.5], [b, 0.5], [b, 1.0], [a, 1.0]]);
    let o = oracle(turned(true), Some(vec![wedge(0.1, 0.2), wedge(3.1, 3.2)]));
    assert_eq!(line(&o, [0.0; 3], [0.0, 0.0, 1.0]).hits.len(), 1);
    let below = polygon(&[[0.5, 0.25], [1.5, 0.25], [1.5, 0.75], [0.5, 0.75]]);
    let o = oracle(turned(true), Some(vec![below]));
    assert!(line(&o, [0.0; 3], [0.0, 0.0, 1.0]).hits.is_empty());
}

#[test]
fn hits_on_curved_loops() {
    // The saddle trimmed by a circle of radius 5/16; it passes (1/2 + 3/16, 1/2 + 4/16), which is
    // x = 3/8, y = 1/2.
    let o = oracle(saddle(), Some(vec![round(0.3125)]));
    for (x, y) in [(0.375, 0.5), (-0.5, 0.375), (0.625, 0.0)] {
        let t = line(&o, [x, y, 3.0], [0.0, 0.0, -1.0]);
        assert_eq!(t.hits.len(), 1, "{t:?}");
        assert!(t.hits[0].boundary && is_narrow_about(&t.hits[0].t, 3.0 - (x * x - y * y)));
        let t = line(&o, [x + 1e-16f64.copysign(x), y, 3.0], [0.0, 0.0, -1.0]);
        assert!(t.hits.len() <= 1);
        let t = line(&o, [x * (1.0 + 1e-15), y, 3.0], [0.0, 0.0, -1.0]);
        assert!(t.hits.is_empty(), "{t:?}");
    }
    // On a slanted straight loop.
    let triangle = vec![
        segment([0.0, 0.0], [1.0, 0.5]),
        segment([1.0, 0.5], [0.5, 1.0]),
        segment([0.5, 1.0], [0.0, 0.0]),
    ];
    let o = oracle(saddle(), Some(vec![triangle]));
    let t = line(&o, [0.5, 0.75 - 1.0, 3.0], [0.0, 0.0, -1.0]);
    // u = 3/4, v = 3/8: on the first side.
    assert!(t.hits.len() == 1 && t.hits[0].boundary, "{t:?}");
}
