//! Hits of lines with faces in planes against the sides of points in uv, which are decided otherwise.

use crate::scenes;
use crate::scenes::Random;
use crate::scenes::loops::{face_of, polygon, square_plane};
use feeler::brep::BrepBuilder;
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve2, Line, NurbsCurve, NurbsSurface, Plane, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{LineKind, LineProbe, Options, Undecided, Workspace, any_hit, line};
use feeler::trim::{Side, TrimRegion};
use nalgebra::{Point2, Point3, Vector2, Vector3, Vector4};

fn square() -> PreparedBrep {
    let mut b = BrepBuilder::new();
    let v: Vec<usize> = [[0., 0., 0.], [4., 0., 0.], [4., 4., 0.], [0., 4., 0.]]
        .into_iter()
        .map(|p| b.vertex(p))
        .collect();
    b.planar_face(&v).unwrap();
    PreparedBrep::new(b.build().unwrap())
}

/// A segment that begins within a face in its plane: `uv` is that of the point.
#[test]
fn uv_is_that_of_the_point_where_a_run_is_cut() {
    let part = square();
    let probe =
        LineProbe::new([1., 2., 0.].into(), [2., 0., 0.].into(), LineKind::Segment).unwrap();
    let a = line(
        &part,
        &probe,
        &Options::default(),
        &mut Workspace::default(),
    );
    assert_eq!(a.hits.len(), 1);
    let h = &a.hits[0];
    let s = part.brep().surface(h.face).point(h.uv.x, h.uv.y);
    assert!((s - h.point).norm() < 1e-12, "{h:#?} {s}");
}

/// The same in a cylinder.
#[test]
fn uv_is_that_of_the_point_where_a_ruling_is_cut() {
    let part = PreparedBrep::new(scenes::cylinder([0.; 3], [5.; 2], 8., 1.));
    let probe =
        LineProbe::new([3., 4., 2.].into(), [0., 0., 2.].into(), LineKind::Segment).unwrap();
    let a = line(
        &part,
        &probe,
        &Options::default(),
        &mut Workspace::default(),
    );
    assert!(!a.hits.is_empty(), "{a:?}");
    for h in &a.hits {
        let s = part.brep().surface(h.face).point(h.uv.x, h.uv.y);
        assert!((s - h.point).norm() < 1e-12, "{h:#?} {s}");
    }
}

/// And of lines that are nearly along a leaning plane, where parameters in f64 have few digits before the point is known.
#[test]
fn uv_is_that_of_the_point_of_grazing_lines() {
    let corners = [[1.87, 2.345, 0.1], [-0.67, 2.92, 0.3], [0.3, 0.1, 2.1]];
    let mut b = BrepBuilder::new();
    let v = corners.map(|p| b.vertex(p));
    b.planar_face(&v).unwrap();
    let part = PreparedBrep::new(b.build().unwrap());
    let [p, q, r] = corners.map(Vector3::from);
    let normal = (q - p).cross(&(r - p)).normalize();
    let mut random = Random::new(3);
    let (mut hits, mut worst) = (0, 0.0_f64);
    for k in 0..400 {
        let [s, t, x, y] = [0; 4].map(|_| random.between(0.1, 0.4));
        let foot = p + (q - p) * s + (r - p) * t;
        let along = (q - p) * x - (r - p) * y + normal * 0.5_f64.powi(k % 30);
        let probe = LineProbe::new((foot - along * 3.0).into(), along, LineKind::Line).unwrap();
        let mut workspace = Workspace::default();
        let a = line(&part, &probe, &Options::default(), &mut workspace);
        for h in &a.hits {
            let s = part.brep().surface(h.face).point(h.uv.x, h.uv.y);
            worst = worst.max((s - h.point).norm());
            hits += 1;
        }
    }
    // Roundings of coordinates up to 8 or so.
    assert!(worst < 32.0 * f64::EPSILON, "{worst:e}");
    assert_eq!(hits, 400);
}

/// Coordinates are at most 1e60: no NaN in an answer.
#[test]
fn no_nan_on_large_planes() {
    for size in [
        1e20, 1e25, 1e27, 1e30, 1e40, 1e59, 1e-20, 1e-27, 1e-30, 1e-40,
    ] {
        let p = |x: f64, y: f64| Point2::new(x * size, y * size);
        let sides = polygon(&[p(-1., -1.), p(1., -1.), p(1., 1.), p(-1., 1.)]);
        let brep = PreparedBrep::new(face_of(square_plane(2.0 * size), vec![sides]));
        // Two across and one in the plane.
        for (z, d) in [
            (1., [0., 0., -1.]),
            (1., [0.25, 0.5, -1.]),
            (0., [1., 0.5, 0.]),
        ] {
            for [x, y] in [[1., 0.], [1., 1.], [0.5, 0.]] {
                let from = Point3::new(x * size, y * size, z * size);
                let probe = LineProbe::new(from, d.into(), LineKind::Line).unwrap();
                let mut workspace = Workspace::default();
                let answer = line(&brep, &probe, &Options::default(), &mut workspace);
                for h in &answer.hits {
                    let t = [h.t.value, h.t.bounds.lo, h.t.bounds.hi];
                    let own = h.uv.iter().chain(h.normal.iter()).chain(h.point.iter());
                    assert!(own.chain(&t).all(|x| x.is_finite()), "{size:e} {h:#?}");
                }
            }
        }
    }
}

/// Up to seven corners in round numbers, joined by segments or, where it may be curved, by parabolas and hyperbolas in part; or a circle. It may cross itself.
fn random_loop(r: &mut Random, curved: bool) -> Vec<Curve2> {
    let unit = Interval::new(0., 1.).unwrap();
    if curved && r.below(3) == 0 {
        let (center, radius) = (
            Point2::new(r.below(7) as f64 - 3., r.below(7) as f64 - 3.),
            [1., 2., 5., 2.5][r.below(4)],
        );
        let turn = Interval::new(0., std::f64::consts::TAU).unwrap();
        return vec![Curve2::Arc(
            Arc::new(Arc {
                center,
                x: Vector2::x(),
                y: Vector2::y(),
                z: Vector2::zeros(),
                radius,
                angle: turn,
                domain: turn,
            })
            .unwrap(),
        )];
    }
    let n = 2 + r.below(6);
    let c: Vec<Point2<f64>> = (0..n)
        .map(|_| Point2::new(r.below(13) as f64 - 6., r.below(13) as f64 - 6.))
        .collect();
    let mut out = Vec::new();
    for i in 0..n {
        let (a, b) = (c[i], c[(i + 1) % n]);
        if curved && r.below(2) == 0 {
            let m = Point2::new(r.below(13) as f64 - 6., r.below(13) as f64 - 6.);
            let w = [1., 2., 0.5, 3.][r.below(4)];
            let pts = vec![
                nalgebra::Vector3::new(a.x, a.y, 1.),
                nalgebra::Vector3::new(m.x * w, m.y * w, w),
                nalgebra::Vector3::new(b.x, b.y, 1.),
            ];
            out.push(Curve2::Nurbs(
                NurbsCurve::new(2, pts, vec![0., 0., 0., 1., 1., 1.]).unwrap(),
            ));
        } else if a != b {
            out.push(Curve2::Line(Line::new(a, b, unit).unwrap()));
        }
    }
    out
}

#[test]
fn lines_against_sides() {
    let mut r = Random::new(77);
    let (mut told, mut open, mut inplane, mut inopen) = (0, 0, 0, 0);
    for round in 0..400 {
        let curved = round % 2 == 1;
        let loops: Vec<Vec<Curve2>> = (0..1 + r.below(3))
            .map(|_| random_loop(&mut r, curved))
            .filter(|l| !l.is_empty())
            .collect();
        if loops.is_empty() {
            continue;
        }
        let wide = [8., 4., 3.][r.below(3)];
        let brep = face_of(square_plane(wide), loops);
        let region = TrimRegion::new(&brep, 0);
        let brep = PreparedBrep::new(brep);
        let mut ws = Workspace::default();
        for _ in 0..60 {
            let p = Point2::new(r.below(25) as f64 / 2. - 6., r.below(25) as f64 / 2. - 6.);
            let (a, b) = (r.below(7) as f64 - 3., r.below(7) as f64 - 3.);
            // Across.
            let d = Vector3::new(a, b, -1.);
            let o = Point3::new(p.x - a * 2., p.y - b * 2., 2.);
            let probe = LineProbe::new(o, d, LineKind::Line).unwrap();
            let ans = any_hit(&brep, &probe, &Options::default(), &mut ws);
            match (ans.undecided, region.side(p).side) {
                (None, Some(side)) => {
                    told += 1;
                    assert_eq!(
                        ans.hit.is_some(),
                        side != Side::Outside,
                        "{round} {p} {d} {ans:?} {side:?} {:#?}",
                        brep.brep().parts().curves2
                    );
                }
                _ => open += 1,
            }
            if a == 0. && b == 0. {
                continue;
            }
            let probe = LineProbe::new(
                Point3::new(p.x, p.y, 0.),
                Vector3::new(a, b, 0.),
                LineKind::Line,
            )
            .unwrap();
            let ans = line(&brep, &probe, &Options::default(), &mut ws);
            // Listed hits are certain, whatever is undecided.
            for h in &ans.hits {
                let s = brep.brep().surface(0).point(h.uv.x, h.uv.y);
                assert!((s - h.point).norm() < 1e-9, "{h:?}");
            }
            // An undecided crack leaves hits known.
            if ans.unsettled.is_some() || !matches!(ans.undecided, None | Some(Undecided::Crack)) {
                inopen += 1;
                continue;
            }
            inplane += 1;
            for k in -96..=96 {
                let t = k as f64 / 8.;
                let q = Point2::new(p.x + t * a, p.y + t * b);
                let Some(side) = region.side(q).side else {
                    continue;
                };
                let mut sure = false;
                let mut may = false;
                for h in &ans.hits {
                    let (lo, hi) = (h.t.bounds, h.t_end.map_or(h.t.bounds, |e| e.bounds));
                    may |= lo.lo <= t && t <= hi.hi;
                    sure |= lo.hi <= t && t <= hi.lo;
                }
                if side == Side::Outside {
                    assert!(
                        !sure,
                        "{round} {p} {a} {b} {t} {ans:#?} {:#?}",
                        brep.brep().parts().curves2
                    );
                } else {
                    assert!(
                        may,
                        "{round} {p} {a} {b} {t} {side:?} {ans:#?} {:#?}",
                        brep.brep().parts().curves2
                    );
                }
            }
        }
    }
    assert!(
        told > 4 * open && inplane > 4 * inopen,
        "{told} {open} {inplane} {inopen}"
    );
}

/// The same planes stored otherwise: axes that lean, other domains, bilinear patches.
#[test]
fn lines_against_leaning_planes() {
    let mut r = Random::new(321);
    let (mut told, mut open, mut inplane, mut inopen) = (0, 0, 0, 0);
    for round in 0..300 {
        let loops: Vec<Vec<Curve2>> = (0..1 + r.below(2))
            .map(|_| random_loop(&mut r, round % 2 == 0))
            .filter(|l| !l.is_empty())
            .collect();
        if loops.is_empty() {
            continue;
        }
        let wide = [8., 4., 3.][r.below(3)];
        let d = Interval::new(-wide, wide).unwrap();
        let e = Interval::new(-1., 3.).unwrap();
        let (x, y, o) = (
            Vector3::new(1., 0.5, 0.25),
            Vector3::new(-0.5, 1., 2.),
            Point3::new(16., -3., 0.5),
        );
        let k = r.below(3);
        let surface = match k {
            0 => Surface::Plane(Plane {
                origin: o,
                x,
                y,
                domain: [d, d],
                extents: [d, d],
            }),
            1 => Surface::Plane(Plane {
                origin: o,
                x,
                y,
                domain: [d, d],
                extents: [d, e],
            }),
            _ => {
                let corner = |a: f64, b: f64| {
                    let p = o + x * a * wide + y * b * wide;
                    Vector4::new(p.x, p.y, p.z, 1.)
                };
                let net = vec![
                    corner(-1., -1.),
                    corner(-1., 1.),
                    corner(1., -1.),
                    corner(1., 1.),
                ];
                let kn = || vec![-wide, -wide, wide, wide];
                Surface::Nurbs(NurbsSurface::new([1, 1], [2, 2], net, [kn(), kn()]).unwrap())
            }
        };
        if k == 1 && wide == 3. {
            continue;
        }
        let brep = face_of(surface.clone(), loops);
        let region = TrimRegion::new(&brep, 0);
        let brep = PreparedBrep::new(brep);
        let at = |p: Point2<f64>| {
            let b = if k == 1 {
                -1. + (p.y + wide) * (2. / wide)
            } else {
                p.y
            };
            o + x * p.x + y * b
        };
        let mut ws = Workspace::default();
        for _ in 0..60 {
            let p = Point2::new(r.below(25) as f64 / 2. - 6., r.below(25) as f64 / 2. - 6.);
            let Some(side) = region.side(p).side else {
                continue;
            };
            let n = Vector3::new(
                r.below(5) as f64 - 2.,
                r.below(5) as f64 - 2.,
                r.below(5) as f64 - 2.,
            );
            if x.cross(&y).dot(&n) == 0. {
                continue;
            }
            let probe = LineProbe::new(at(p) + n * 2., n, LineKind::Line).unwrap();
            let ans = any_hit(&brep, &probe, &Options::default(), &mut ws);
            if ans.undecided.is_none() {
                told += 1;
                assert_eq!(
                    ans.hit.is_some(),
                    side != Side::Outside,
                    "{round} {k} {p:?} {n} {ans:?} {side:?}"
                );
            } else {
                open += 1;
            }
            let (a, b) = (r.below(7) as f64 - 3., r.below(7) as f64 - 3.);
            if a == 0. && b == 0. {
                continue;
            }
            let dir = at(Point2::new(a, b)) - at(Point2::origin());
            let probe = LineProbe::new(at(p), dir, LineKind::Line).unwrap();
            let ans = line(&brep, &probe, &Options::default(), &mut ws);
            if ans.unsettled.is_some() || !matches!(ans.undecided, None | Some(Undecided::Crack)) {
                inopen += 1;
                continue;
            }
            inplane += 1;
            for k in -96..=96 {
                let t = k as f64 / 8.;
                let Some(side) = region.side(Point2::new(p.x + t * a, p.y + t * b)).side else {
                    continue;
                };
                let (mut sure, mut may) = (false, false);
                for h in &ans.hits {
                    let (lo, hi) = (h.t.bounds, h.t_end.map_or(h.t.bounds, |e| e.bounds));
                    may |= lo.lo <= t && t <= hi.hi;
                    sure |= lo.hi <= t && t <= hi.lo;
                }
                assert!(
                    if side == Side::Outside { !sure } else { may },
                    "{round} {p:?} {a} {b} {t} {side:?} {ans:#?}"
                );
            }
        }
    }
    assert!(
        told > 4 * open && inplane > 4 * inopen,
        "{told} {open} {inplane} {inopen}"
    );
}
