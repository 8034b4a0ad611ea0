//! Widths of cracks, and the side of points next to edges, against what is known by construction.

use crate::scene;
use crate::scene::{changed, dyadic, model};
use feeler::brep::{Brep, BrepBuilder};
use feeler::numeric::Dyadic;
use feeler::nurbs::Surface;
use feeler::query::LineKind;
use feeler_oracle::{InsideTruth, Oracle};

/// The unit cube of planes.
fn cube() -> Brep {
    let mut cube = BrepBuilder::new();
    for i in 0..8 {
        let [x, y, z] = [i & 1, i >> 1 & 1, i >> 2].map(f64::from);
        cube.vertex([x, y, z]);
    }
    for corners in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [1, 3, 7, 5],
        [3, 2, 6, 7],
        [2, 0, 4, 6],
    ] {
        cube.planar_face(&corners).unwrap();
    }
    cube.build().unwrap()
}

/// The cube with its top (face 1) moved.
fn cracked(by: [f64; 3]) -> Brep {
    changed(&cube(), |parts| {
        let surface = parts.faces[1].surface;
        match &mut parts.surfaces[surface] {
            Surface::Plane(p) => p.origin += nalgebra::Vector3::from(by),
            other => panic!("{other:?}"),
        }
    })
}

/// The edges of the top.
fn top_edges(b: &Brep) -> Vec<usize> {
    let parts = b.parts();
    (0..parts.edges.len())
        .filter(|e| {
            parts.edges[*e]
                .trims
                .iter()
                .any(|t| parts.loops[parts.trims[*t].trim_loop].face == 1)
        })
        .collect()
}

fn floor(size: f64) -> Dyadic {
    dyadic(size * (-100f64).exp2())
}

#[test]
fn width_of_a_planted_crack_is_its_shift() {
    let c = (-20f64).exp2();
    // Up (a gap), down (an overlap), and askew: each image is moved as a whole, so that matched
    // points are that far apart, and no end is nearer to the other image than that unless it slides along it.
    for by in [
        [0.0, 0.0, c],
        [0.0, 0.0, -c],
        [0.0, 0.0, 1e-15],
        [0.0, 0.0, 0.25],
    ] {
        let b = cracked(by);
        let shift = dyadic(by[2].abs());
        let o = Oracle::new(&[&b]).unwrap();
        let top = top_edges(&b);
        assert_eq!(top.len(), 4);
        for e in 0..12 {
            let d = o.crack_width(e).unwrap().unwrap();
            if top.contains(&e) {
                // 1 + 1e-15 is not a number: the shift is what the plane's origin became.
                let shift = if by[2] == 1e-15 {
                    dyadic(1.0 + by[2] - 1.0)
                } else {
                    shift.clone()
                };
                assert!(d.contains(&shift), "{by:?} {e} {d:?}");
                let limit = &shift + &(&shift * &dyadic(0.001));
                assert!(
                    d.hi <= limit && d.width() <= &shift * &dyadic(0.001),
                    "{d:?}"
                );
            } else {
                assert!(
                    d.lo == Dyadic::ZERO && d.hi <= floor(2.0),
                    "{by:?} {e} {d:?}"
                );
            }
        }
    }
    // Sideways by c along x: the images of the edges along x slide along themselves, and their ends are c
    // off; the others are c apart throughout.
    let o = Oracle::new(&[&cracked([c, 0.0, 0.0])]).unwrap();
    for e in top_edges(&cube()) {
        let d = o.crack_width(e).unwrap().unwrap();
        assert!(d.contains(&dyadic(c)), "{e} {d:?}");
        assert!(d.width() <= dyadic(c * 0.001), "{e} {d:?}");
    }
    // An edge used once has none.
    let sheet = scene::brep(
        scene::plane(2.0),
        Some(vec![scene::polygon(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])]),
    );
    let o = Oracle::new(&[&sheet]).unwrap();
    assert_eq!(o.crack_width(0).unwrap(), None);
    assert!(o.crack_width(3).is_err());
}

#[test]
fn sides_next_to_a_cube_are_known() {
    let o = Oracle::new(&[&cube()]).unwrap();
    // From a corner, an edge and a face, off by -e, 0 or e along each axis, down to the last bit.
    for e in [1e-6, 1e-9, 1e-12, 1e-14, 1e-15, f64::EPSILON] {
        for at in [[1.0, 1.0, 1.0], [1.0, 1.0, 0.3], [0.7, 0.3, 1.0]] {
            for k in 0..27 {
                let p = [k % 3, k / 3 % 3, k / 9]
                    .map(|s| f64::from(s) - 1.0)
                    .iter()
                    .zip(at)
                    .map(|(s, x)| x + s * e)
                    .collect::<Vec<_>>();
                let p = [p[0], p[1], p[2]];
                let expected = if p.iter().any(|x| *x > 1.0) {
                    InsideTruth::Outside
                } else if p.contains(&1.0) {
                    InsideTruth::Boundary
                } else {
                    InsideTruth::Inside
                };
                assert_eq!(o.inside_by_rays(p, 3).unwrap(), expected, "{p:?}");
            }
        }
    }
}

#[test]
fn points_within_a_planted_crack_are_undecided_and_no_others() {
    let c = (-20f64).exp2();
    let crack = InsideTruth::Undecided("crack".to_owned());
    // A gap: the images of the edge at y = 1 run at z = 1 and z = 1 + c.
    let o = Oracle::new(&[&cracked([0.0, 0.0, c])]).unwrap();
    let at = |y: f64, z: f64| {
        o.inside_by_rays([0.5, 1.0 + y * c, 1.0 + z * c], 2)
            .unwrap()
    };
    for (y, z, expected) in [
        (0.0, 0.5, &crack),
        (0.9, 0.1, &crack),
        (-0.8, 1.5, &crack),
        (0.1, -0.99, &crack),
        (0.1, 1.99, &crack),
        (1.01, 0.5, &InsideTruth::Outside),
        (0.2, 2.01, &InsideTruth::Outside),
        (-0.9, 0.5, &InsideTruth::Inside), // sqrt(0.81 + 0.25) > 1
        (-0.2, -1.01, &InsideTruth::Inside),
        (-3.0, 0.9, &InsideTruth::Inside),
        (-3.0, 1.1, &InsideTruth::Outside),
        (-3.0, 1.0, &InsideTruth::Boundary),
        // On the side face, though in the crack.
        (0.0, -0.5, &InsideTruth::Boundary),
    ] {
        assert_eq!(&at(y, z), expected, "{y} {z}");
    }
    // Between the corners of the two: a vertex region.
    assert_eq!(o.inside([1.0, 1.0, 1.0 + 0.5 * c]).unwrap(), crack);
    // An overlap: the sides stand out over the top by c.
    let o = Oracle::new(&[&cracked([0.0, 0.0, -c])]).unwrap();
    let at = |y: f64, z: f64| {
        o.inside_by_rays([0.5, 1.0 + y * c, 1.0 + z * c], 2)
            .unwrap()
    };
    assert_eq!(at(-0.3, -0.4), crack);
    assert_eq!(at(-3.0, -0.5), InsideTruth::Outside);
    assert_eq!(at(-3.0, -1.5), InsideTruth::Inside);
    // The sign of the separation goes with it; in the crack it may be either.
    let d = o
        .sphere([0.5, 1.0 - 3.0 * c, 1.0 - 1.5 * c], 0.0, None)
        .unwrap()
        .unwrap();
    assert!(d.enclosure.hi < Dyadic::ZERO);
    let d = o
        .sphere([0.5, 1.0 - 0.3 * c, 1.0 - 0.4 * c], 0.0, None)
        .unwrap()
        .unwrap();
    assert_eq!(d.enclosure.lo, -&d.enclosure.hi);
    assert!(d.enclosure.hi > Dyadic::ZERO && d.enclosure.hi <= dyadic(c));
}

/// Balls and cylinders as NURBS are so up to rounding: 1e-13 and more away from their surface the side is that of the
/// exact shape, however near the point is to a seam, a pole or a rim.
#[test]
fn sides_next_to_rims_seams_and_poles_are_known() {
    for name in ["thesis/3dm/ball_nurbs.3dm", "thesis/3dm/cylinder_nurbs.3dm"] {
        let Some(breps) = model(name) else { continue };
        let b = &breps[0];
        let o = Oracle::new(&[b]).unwrap();
        let parts = b.parts();
        for (e, edge) in parts.edges.iter().enumerate() {
            let d = o.crack_width(e).unwrap().unwrap();
            assert!(d.hi < dyadic(1e-14), "{name} {e} {d:?}");
            assert_eq!(edge.trims.len(), 2);
        }
        let mut g = scene::Random(5);
        for trim in &parts.trims {
            let surface = b.surface(parts.loops[trim.trim_loop].face);
            for _ in 0..3 {
                let uv = parts.curves2[trim.curve].point(trim.span.lerp(g.next()));
                let at = surface.point(uv.x, uv.y);
                for off in [1e-6, 1e-9, 1e-12, 2e-13] {
                    let p = [0, 1, 2].map(|k| at[k] + off * g.range(-1.0, 1.0));
                    let Some(expected) = side_of_shape(name, p) else {
                        continue;
                    };
                    assert_eq!(o.inside(p).unwrap(), expected, "{name} {p:?}");
                }
            }
        }
    }
}

/// `None` where the shape's rounding may decide.
fn side_of_shape(name: &str, [x, y, z]: [f64; 3]) -> Option<InsideTruth> {
    const NOISE: f64 = 1e-14;
    let outward = if name.contains("ball") {
        vec![(x * x + y * y + z * z).sqrt() - 2.45]
    } else {
        vec![(x * x + y * y).sqrt() - 2.5, z - 10.0, -z]
    };
    if outward.iter().any(|d| *d > NOISE) {
        Some(InsideTruth::Outside)
    } else if outward.iter().all(|d| *d < -NOISE) {
        Some(InsideTruth::Inside)
    } else {
        None
    }
}

/// Hits, crossings, in_crack.
fn count(
    o: &Oracle,
    origin: [f64; 3],
    direction: [f64; 3],
    kind: LineKind,
) -> (usize, Option<usize>, Option<bool>) {
    let t = o.line(origin, direction, kind).unwrap();
    assert!(t.open.is_empty(), "{t:?}");
    (t.hits.len(), t.crossings, t.in_crack)
}

#[test]
fn crossings_of_a_planted_crack_are_those_of_the_definition() {
    let c = (-20f64).exp2();
    let (whole, no, yes) = (LineKind::Line, Some(false), Some(true));
    // A gap at the upper edges, c high.
    let o = Oracle::new(&[&cracked([0.0, 0.0, c])]).unwrap();
    // Through two gaps, below the top: no hit at all.
    let gap = [0.5, 2.0, 1.0 + 0.5 * c];
    assert_eq!(count(&o, gap, [0.0, -1.0, 0.0], whole), (0, Some(0), yes));
    // Through one, then the bottom.
    let gap = [0.5, 1.0, 1.0 + 0.5 * c];
    let down = [0.0, -1.0, -2.0];
    assert_eq!(count(&o, gap, down, whole), (1, Some(1), yes));
    // The same as a ray from either side of the gap, and one that ends within the crack: not decided.
    let moved = |t: f64| [0.5, 1.0 - t, 1.0 + 0.5 * c - 2.0 * t];
    assert_eq!(
        count(&o, moved(-0.25), down, LineKind::Ray),
        (1, Some(1), yes)
    );
    assert_eq!(
        count(&o, moved(0.25), down, LineKind::Ray),
        (1, Some(1), no)
    );
    assert_eq!(
        count(&o, moved(-0.25), down, LineKind::Segment),
        (1, Some(1), yes)
    );
    assert_eq!(
        count(&o, moved(0.0), down, LineKind::Ray),
        (1, Some(1), None)
    );
    // Beside the edge, 2 c and 0.5 c off its images, without a hit there.
    let beside = |y: f64, z: f64| [0.5, 1.0 + y * c, 1.0 + z * c];
    let away = [0.0, 1.0, -1.0];
    assert_eq!(count(&o, beside(1.5, 1.5), away, whole), (0, Some(0), no));
    assert_eq!(count(&o, beside(0.5, 1.0), away, whole), (0, Some(0), yes));
    // A sheet beside the cube that the line meets in that crack: the sheet's hit is none of the cube's.
    let mut sheet = BrepBuilder::new();
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]];
    let corners = corners.map(|[x, y]| sheet.vertex([x, y, 1.0 + c]));
    sheet.planar_face(&corners).unwrap();
    let sheet = sheet.build().unwrap();
    let both = Oracle::new(&[&cracked([0.0, 0.0, c]), &sheet]).unwrap();
    let met = count(&both, beside(0.5, 1.0), away, whole);
    assert_eq!(met, (1, Some(1), yes));
    // An overlap: the sides stand out over the top. The line hits both within c, and the bottom.
    let o = Oracle::new(&[&cracked([0.0, 0.0, -c])]).unwrap();
    let over = [0.5, 1.0, 1.0 - 0.5 * c];
    assert_eq!(count(&o, over, down, whole), (3, Some(2), no));
    // Farther down the side the second hit is in no crack: side, then bottom.
    let below = [0.5, 1.0, 1.0 - 4.0 * c];
    assert_eq!(count(&o, below, down, whole), (2, Some(2), no));
    // The exact cube: through an edge, and through a corner; the edge touched from outside is hit, and counts.
    let o = Oracle::new(&[&cube()]).unwrap();
    assert_eq!(count(&o, [0.5, 1.0, 1.0], down, whole), (3, Some(2), no));
    assert_eq!(
        count(&o, [1.0, 1.0, 1.0], [-1.0, -1.5, -2.0], whole),
        (4, Some(2), no)
    );
    assert_eq!(
        count(&o, [0.5, 1.0, 1.0], [0.0, -1.0, 1.0], whole),
        (2, Some(1), no)
    );
    // Next to it by one unit in the last place: no.
    assert_eq!(
        count(&o, [0.5, 1.0 + f64::EPSILON, 1.0], [0.0, -1.0, 1.0], whole),
        (0, Some(0), no)
    );
    // Along a face: hits, but no number of crossings.
    let t = o.line([0.5, 2.0, 1.0], [0.0, -1.0, 0.0], whole).unwrap();
    assert_eq!(t.crossings, None);
}
