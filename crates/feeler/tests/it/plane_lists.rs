//! Lists of contacts with faces in a plane, against what plane geometry says of the nearest points of polygons, discs and plates with holes.

use crate::scenes;
use crate::scenes::Random;
use crate::scenes::loops::{face_of, polygon, square_plane};
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve2, Line, NurbsCurve, Plane, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    ContactAnswer, Contacts, HalfSpace, Options, Probe, Sphere, Undecided, Workspace, contact,
};
use feeler::trim::{Side, TrimRegion};
use nalgebra::{Point2, Point3, Vector2, Vector3};

fn all(brep: &PreparedBrep, q: [f64; 3], prediction: f64) -> ContactAnswer {
    let ball = Probe::Sphere(Sphere::new(q.into(), 0.125).unwrap());
    let options = Options {
        contacts: Contacts::All,
        prediction,
        ..Options::default()
    };
    contact(brep, &ball, &options, &mut Workspace::default())
}

/// Lists on a plane polygon against what plane geometry says.
#[test]
fn lists_on_polygons() {
    let mut r = Random::new(5);
    let mut total = 0;
    for round in 0..600 {
        let star = |r: &mut Random, n: usize, lo: f64, hi: f64, back: bool| -> Vec<Point2<f64>> {
            let mut p: Vec<Point2<f64>> = (0..n)
                .map(|k| {
                    let a = (k as f64 + r.between(-0.3, 0.3)) / n as f64 * std::f64::consts::TAU;
                    let m = r.between(lo, hi);
                    Point2::new(m * a.cos(), m * a.sin())
                })
                .collect();
            if back {
                p.reverse();
            }
            p
        };
        let n = 3 + r.below(8);
        let mut loops = vec![star(&mut r, n, 2., 5., false)];
        if r.below(2) == 0 && n >= 6 {
            let m = 3 + r.below(5);
            loops.push(star(&mut r, m, 0.1, 0.9, true));
        }
        let brep = face_of(square_plane(8.), loops.iter().map(|l| polygon(l)).collect());
        let region = TrimRegion::new(&brep, 0);
        let brep = PreparedBrep::new(brep);
        for _ in 0..6 {
            let p = Point2::new(r.between(-6., 6.), r.between(-6., 6.));
            let z = r.between(0.1, 2.0);
            let mut truth: Vec<Point2<f64>> = Vec::new();
            if region.side(p).side != Some(Side::Outside) {
                truth.push(p);
            }
            let mut close = false;
            for l in &loops {
                let n = l.len();
                for i in 0..n {
                    let (a, b, c) = (l[(i + n - 1) % n], l[i], l[(i + 1) % n]);
                    let d = c - b;
                    let s = (p - b).dot(&d) / d.norm_squared();
                    // Region is to the left.
                    let left = d.x * (p.y - b.y) - d.y * (p.x - b.x);
                    if (s.abs() < 1e-3) || ((s - 1.).abs() < 1e-3) || left.abs() < 1e-3 {
                        close = true;
                    }
                    if s > 0. && s < 1. && left < 0. {
                        truth.push(b + d * s);
                    }
                    let (e1, e2) = (a - b, c - b);
                    let convex = (b - a).x * e2.y - (b - a).y * e2.x > 0.;
                    if convex && e1.dot(&(b - p)) > 0. && e2.dot(&(b - p)) > 0. {
                        truth.push(b);
                    }
                }
            }
            if close {
                continue;
            }
            let a = all(&brep, [p.x, p.y, z], 100.);
            assert_eq!(a.undecided, None);
            total += truth.len();
            let found: Vec<_> = a
                .contacts
                .iter()
                .map(|c| Point2::new(c.on_brep.x, c.on_brep.y))
                .collect();
            for t in &truth {
                assert!(
                    found.iter().any(|f| (f - t).norm() < 1e-9),
                    "{round} lost {t} of {truth:?}: {found:?} {p} {loops:?}"
                );
            }
            assert_eq!(
                found.len(),
                truth.len(),
                "{round} {truth:?}: {found:?} {p} {loops:?}"
            );
        }
    }
    assert!(total > 1000, "{total}");
}

/// Discs and what an arc and its chord bound.
#[test]
fn lists_on_discs() {
    let mut r = Random::new(31);
    let tau = std::f64::consts::TAU;
    let unit = Interval::new(0., 1.).unwrap();
    let mut asked = 0;
    for round in 0..2000 {
        let whole = round % 2 == 0;
        let a = match r.below(4) {
            0 => 0.,
            1 => std::f64::consts::FRAC_PI_2,
            _ => r.between(-6., 6.),
        };
        let sweep = match (whole, r.below(5)) {
            (true, _) => tau,
            (_, 0) => std::f64::consts::PI,
            (_, 1) => tau - 1e-6,
            (_, 2) => r.between(1e-3, 1e-2),
            _ => r.between(0.1, 6.2),
        };
        let b = match (whole, r.below(3)) {
            (true, 0) => (a + sweep).next_up(),
            (true, 1) => (a + sweep).next_down(),
            _ => a + sweep,
        };
        let angle = Interval::new(a, b).unwrap();
        let domain = if r.below(2) == 0 {
            angle
        } else {
            Interval::new(0., 1.).unwrap()
        };
        let c = Point2::new(r.between(-1., 1.), r.between(-1., 1.));
        let radius = r.between(0.5, 3.);
        let t = r.between(0., 6.);
        let flip = if r.below(2) == 0 { 1. } else { -1. };
        let (x, y) = (
            Vector2::new(t.cos(), t.sin()),
            Vector2::new(-t.sin(), t.cos()) * flip,
        );
        let arc = Arc::new(Arc {
            center: c,
            x,
            y,
            z: Vector2::zeros(),
            radius,
            angle,
            domain,
        })
        .unwrap();
        let at = |g: f64| c + (x * g.cos() + y * g.sin()) * radius;
        let (p0, p1) = (at(a), at(b));
        let mut lp = vec![Curve2::Arc(arc)];
        if !whole {
            let q = lp[0].point(domain.end);
            lp.push(Curve2::Line(
                Line::new(q, lp[0].point(domain.start), unit).unwrap(),
            ));
        }
        let brep = face_of(square_plane(8.), vec![lp]);
        let region = TrimRegion::new(&brep, 0);
        let brep = PreparedBrep::new(brep);
        for _ in 0..4 {
            let p = Point2::new(r.between(-6., 6.), r.between(-6., 6.));
            let z = r.between(0.1, 2.);
            let mut truth = Vec::new();
            let mut close = false;
            let w = p - c;
            let rho = w.norm();
            close |= (rho - radius).abs() < 1e-3;
            if region.side(p).side != Some(Side::Outside) {
                truth.push(p);
            }
            let g = (w.dot(&y)).atan2(w.dot(&x));
            let mut off = (g - a).rem_euclid(tau);
            if !whole {
                close |= off < 1e-3 || (off - (b - a)).abs() < 1e-3 || tau - off < 1e-3;
            } else {
                off = 0.;
            }
            if rho > radius && off <= b - a {
                truth.push(c + w * (radius / rho));
            }
            if !whole {
                let d = p0 - p1;
                let s = (p - p1).dot(&d) / d.norm_squared();
                let side = |v: Point2<f64>| d.x * (v.y - p1.y) - d.y * (v.x - p1.x);
                let mid = at(a + 0.5 * (b - a));
                close |= side(p).abs() < 1e-3 * d.norm() || s.abs() < 1e-3 || (s - 1.).abs() < 1e-3;
                if s > 0. && s < 1. && side(p) * side(mid) < 0. {
                    truth.push(p1 + d * s);
                }
                let tan = |g: f64| y * g.cos() - x * g.sin();
                for (v, e1, e2) in [(p0, p1 - p0, tan(a)), (p1, p0 - p1, -tan(b))] {
                    let (k1, k2) = (e1.normalize().dot(&(v - p)), e2.dot(&(v - p)));
                    close |= k1.abs() < 1e-3 || k2.abs() < 1e-3;
                    if k1 > 0. && k2 > 0. {
                        truth.push(v);
                    }
                }
            }
            if close {
                continue;
            }
            asked += 1;
            let ans = all(&brep, [p.x, p.y, z], 100.);
            let found: Vec<_> = ans
                .contacts
                .iter()
                .map(|c| Point2::new(c.on_brep.x, c.on_brep.y))
                .collect();
            let ok = ans.undecided.is_none()
                && found.len() == truth.len()
                && truth
                    .iter()
                    .all(|t| found.iter().any(|f| (f - t).norm() < 1e-9));
            assert!(ok, "{round} {p} {z}: {truth:?}, {ans:?}");
        }
    }
    assert!(asked > 1000, "{asked}");
}

/// A disc by itself, with its vertex where its circle begins: beside the rim there is one contact.
#[test]
fn one_contact_at_the_rim_of_a_disc() {
    let tau = std::f64::consts::TAU;
    let mut r = Random::new(43);
    let circle = Curve2::Arc(
        Arc::new(Arc {
            center: Point2::origin(),
            x: Vector2::x(),
            y: Vector2::y(),
            z: Vector2::zeros(),
            radius: 1.,
            angle: Interval::new(0., tau).unwrap(),
            domain: Interval::new(0., 1.).unwrap(),
        })
        .unwrap(),
    );
    let brep = scenes::loop_face(
        &square_plane(8.),
        vec![circle],
        vec![Point3::new(1., 0., 0.)],
    );
    let part = PreparedBrep::new(brep);
    for _ in 0..400 {
        let a = r.between(-0.3, 0.3);
        let rho = r.between(1.05, 6.);
        let q = [rho * a.cos(), rho * a.sin(), r.between(0.1, 2.)];
        let answer = all(&part, q, 100.);
        assert_eq!(answer.contacts.len(), 1, "{q:?}: {answer:?}");
    }
}

/// A plate with round holes: inside a hole's outline its rim has one nearest point.
#[test]
fn lists_on_plates_with_holes() {
    let tau = std::f64::consts::TAU;
    let mut r = Random::new(47);
    let mut asked = 0;
    for round in 0..300 {
        let scale = [1., 1e-6, 1e9, 0.3][r.below(4)];
        let off = [0., 0., 100., 3e4][r.below(4)] * scale;
        let sq = |w: f64| {
            vec![
                Point2::new(off - w, off - w),
                Point2::new(off + w, off - w),
                Point2::new(off + w, off + w),
                Point2::new(off - w, off + w),
            ]
        };
        let w = 6. * scale;
        let mut loops = vec![polygon(&sq(w))];
        let mut holes = Vec::new();
        for k in 0..1 + r.below(2) {
            let c = Point2::new(
                off + if k == 0 { -2.5 } else { 2.5 } * scale,
                off + r.between(-2., 2.) * scale,
            );
            let radius = r.between(0.5, 2.2) * scale;
            let a = r.between(-6., 6.);
            let a = if r.below(2) == 0 { 0. } else { a };
            let flip = if r.below(2) == 0 { 1. } else { -1. };
            let t = r.between(0., 6.);
            let (x, y) = (
                Vector2::new(t.cos(), t.sin()),
                Vector2::new(-t.sin(), t.cos()) * flip,
            );
            let angle = Interval::new(a, a + tau).unwrap();
            if r.below(3) == 0 {
                // Nine points of degree two.
                let s = std::f64::consts::FRAC_1_SQRT_2;
                let p = [
                    [1., 0.],
                    [1., 1.],
                    [0., 1.],
                    [-1., 1.],
                    [-1., 0.],
                    [-1., -1.],
                    [0., -1.],
                    [1., -1.],
                    [1., 0.],
                ];
                let pts = p
                    .iter()
                    .enumerate()
                    .map(|(i, p)| {
                        let w = if i % 2 == 1 { s } else { 1. };
                        let q = c + (x * p[0] + y * p[1]) * radius;
                        nalgebra::Vector3::new(q.x * w, q.y * w, w)
                    })
                    .collect();
                loops.push(vec![Curve2::Nurbs(
                    NurbsCurve::new(
                        2,
                        pts,
                        vec![0., 0., 0., 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1., 1., 1.],
                    )
                    .unwrap(),
                )]);
            } else {
                loops.push(vec![Curve2::Arc(
                    Arc::new(Arc {
                        center: c,
                        x,
                        y,
                        z: Vector2::zeros(),
                        radius,
                        angle,
                        domain: angle,
                    })
                    .unwrap(),
                )]);
            }
            holes.push((c, radius));
        }
        let d = Interval::new(off - 2. * w, off + 2. * w).unwrap();
        let surface = Surface::Plane(Plane {
            origin: Point3::origin(),
            x: Vector3::x(),
            y: Vector3::y(),
            domain: [d, d],
            extents: [d, d],
        });
        let brep = face_of(surface, loops);
        let brep = PreparedBrep::new(brep);
        for _ in 0..8 {
            let p = Point2::new(
                off + r.between(-5.9, 5.9) * scale,
                off + r.between(-5.9, 5.9) * scale,
            );
            let mut truth = p;
            let mut close = false;
            for (c, radius) in &holes {
                let w = p - c;
                close |= (w.norm() - radius).abs() < 1e-2 * scale || w.norm() < 1e-2 * scale;
                if w.norm() < *radius {
                    truth = c + w * (radius / w.norm());
                }
            }
            if close {
                continue;
            }
            asked += 1;
            let ball = Probe::Sphere(
                Sphere::new(
                    Point3::new(p.x, p.y, r.between(0.1, 2.) * scale),
                    0.125 * scale,
                )
                .unwrap(),
            );
            let options = Options {
                contacts: Contacts::All,
                prediction: 100. * scale,
                ..Options::default()
            };
            let a = contact(&brep, &ball, &options, &mut Workspace::default());
            let found: Vec<_> = a
                .contacts
                .iter()
                .map(|c| Point2::new(c.on_brep.x, c.on_brep.y))
                .collect();
            let ok = a.undecided.is_none()
                && found.len() == 1
                && (found[0] - truth).norm() < 1e-6 * scale;
            assert!(ok, "{round} {p}: {truth:?}, {a:?}");
        }
    }
    assert!(asked > 1000, "{asked}");
}

/// "Infinite: however far they are."
#[test]
fn an_infinite_prediction_lists_what_a_large_one_does() {
    let cube = PreparedBrep::new(scenes::cube());
    let ball = Probe::Sphere(Sphere::new([1.5, 0.5, 0.25].into(), 0.25).unwrap());
    let ask = |prediction: f64| {
        let options = Options {
            contacts: Contacts::All,
            prediction,
            ..Options::default()
        };
        contact(&cube, &ball, &options, &mut Workspace::default())
    };
    let large = ask(5.0);
    for p in [1e30, 1e160, f64::MAX, f64::INFINITY] {
        let a = ask(p);
        assert_eq!(a.contacts.len(), large.contacts.len(), "{p:e} {a:#?}");
    }
}

/// The tips of a zigzag, each a contact of a half-space: a list has them all, or says that its budget is spent, which it keeps to.
#[test]
fn a_list_keeps_to_its_budget() {
    const TEETH: usize = 300;
    /// What a place takes that is begun with a node left: some values on each face and along each trim there, of which a few make a node.
    const LAST: usize = 64;
    /// What all tips take at least: 24 ways are looked for from each, and eight points count for a node. (The search before takes a third of a node a tip.)
    const LEAST: usize = TEETH * 24 / 8;
    let mut corners = vec![Point2::new(1.0, 1.0), Point2::new(-1.0, 1.0)];
    let mut depths = Vec::new();
    for k in 0..TEETH {
        let x = -1.0 + 2.0 * k as f64 / TEETH as f64;
        let depth = 0.5 + (k * 7 % TEETH) as f64 / 1024.0;
        depths.push(depth);
        corners.push(Point2::new(x, 0.0));
        corners.push(Point2::new(x + 1.0 / TEETH as f64, -depth));
    }
    corners.push(Point2::new(1.0, 0.0));
    depths.sort_by(|a, b| b.total_cmp(a));
    let brep = face_of(square_plane(8.0), vec![polygon(&corners)]);
    let brep = PreparedBrep::new(brep);
    let below = Probe::HalfSpace(HalfSpace::new(Vector3::y(), 0.0).unwrap());
    let mut seen = [false; 2];
    for node_budget in [0, 1, 20, 400, 1000, 3000, 200_000] {
        let options = Options {
            contacts: Contacts::All,
            node_budget,
            ..Options::default()
        };
        let mut workspace = Workspace::default();
        let found = contact(&brep, &below, &options, &mut workspace);
        let spent = workspace.work().nodes;
        assert!(spent <= 2 * node_budget + LAST, "{node_budget}: {spent}");
        assert!(
            found.undecided.is_some() || node_budget >= LEAST,
            "{node_budget}"
        );
        let told: Vec<f64> = found.contacts.iter().map(|c| -c.on_brep.y).collect();
        if found.undecided.is_none() {
            assert_eq!(told, depths, "{node_budget}");
            seen[0] = true;
        } else {
            assert_eq!(found.undecided, Some(Undecided::Budget), "{node_budget}");
            assert!(told.len() < TEETH, "{node_budget}");
            assert!(told.iter().all(|d| depths.contains(d)), "{node_budget}");
            seen[1] |= told.len() > 2;
        }
    }
    assert_eq!(seen, [true; 2]);
}
