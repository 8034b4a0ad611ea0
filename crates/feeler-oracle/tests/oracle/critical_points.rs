//! Distances and contacts against all critical points, by the bivariate algebraic kernel.

use crate::scene::{Random, brep, patch};
use feeler::nurbs::{NurbsSurface, Surface};
use feeler::query::Probe;
use feeler::query::Sphere;
use feeler_oracle::{CriticalPoints, Oracle, TruthEnclosure, critical_points};
use nalgebra::Point3;
use std::time::Instant;

fn nurbs(s: &Surface) -> &NurbsSurface {
    match s {
        Surface::Nurbs(s) => s,
        _ => unreachable!("a NURBS surface"),
    }
}

fn overlap(a: &TruthEnclosure, b: &TruthEnclosure) -> bool {
    a.lo <= b.hi && b.lo <= a.hi
}

/// The least distance.
fn least(c: &CriticalPoints) -> TruthEnclosure {
    let ends = |f: fn(&TruthEnclosure) -> &feeler::numeric::Dyadic| {
        c.points
            .iter()
            .map(|p| f(&p.distance))
            .min()
            .unwrap()
            .clone()
    };
    TruthEnclosure {
        lo: ends(|e| &e.lo),
        hi: ends(|e| &e.hi),
    }
}

/// A wavy patch over the unit square.
fn wavy(g: &mut Random, p: usize, q: usize) -> Surface {
    let mut net = Vec::new();
    for i in 0..=p {
        for j in 0..=q {
            let mut off = || g.range(-0.25, 0.25);
            net.push([
                i as f64 / p as f64 + off(),
                j as f64 / q as f64 + off(),
                6.0 * off(),
                1.0,
            ]);
        }
    }
    patch(p, q, net)
}

#[test]
fn distances_and_contacts_are_those_of_the_critical_points() {
    let mut g = Random(21);
    let (mut inner, mut minima, mut many) = (0, 0, 0);
    let mut times = Vec::new();
    for (p, q, queries) in [
        (1, 1, 4),
        (1, 2, 3),
        (2, 1, 3),
        (2, 2, 5),
        (2, 2, 5),
        (2, 2, 5),
        (1, 3, 2),
        (2, 3, 1),
        (3, 3, 1),
    ] {
        let surface = wavy(&mut g, p, q);
        let b = brep(surface.clone(), None);
        let o = Oracle::new(&[&b]).unwrap();
        for _ in 0..queries {
            let at = [g.range(-0.2, 1.2), g.range(-0.2, 1.2), g.range(-0.7, 0.7)];
            let start = Instant::now();
            let c = critical_points(nurbs(&surface), at).unwrap().unwrap();
            let time = start.elapsed().as_secs_f64();
            println!("{p}x{q}: {} points in {time:.2} s", c.points.len());
            times.push(time);
            assert!(c.all, "{c:?}");
            let truth = o.distance(at, None).unwrap().unwrap().enclosure;
            let other = least(&c);
            assert!(overlap(&truth, &other), "{truth:?} {other:?}");
            assert!(other.width().approximate() < 1e-30, "{other:?}");
            inner += c.points.iter().filter(|p| p.inner).count();

            // All contacts within a prediction.
            let radius = 0.125;
            let reach = truth.hi.approximate() + 1.0;
            let probe = Probe::Sphere(Sphere {
                center: Point3::from(at),
                radius,
            });
            let contacts = o.contacts(&probe, reach - radius).unwrap();
            assert!(contacts.whole);
            let due: Vec<_> = c
                .points
                .iter()
                .filter(|p| p.distance.hi.approximate() < reach)
                .filter(|p| p.minimum != Some(false))
                .collect();
            for minimum in &due {
                assert_eq!(minimum.minimum, Some(true), "{minimum:?}");
                let boxes = contacts.contacts.iter().filter(|c| {
                    (0..3).all(|k| c.at[k][0] <= minimum.at[k][1] && minimum.at[k][0] <= c.at[k][1])
                });
                assert_eq!(boxes.count(), 1, "{minimum:?} {:?}", contacts.contacts);
            }
            let proven = contacts.contacts.iter().filter(|c| c.proven && c.within);
            assert_eq!(proven.count(), due.len(), "{due:?} {:?}", contacts.contacts);
            minima += due.len();
            many += usize::from(due.len() > 1);
        }
    }
    times.sort_by(f64::total_cmp);
    println!(
        "{} queries, {inner} critical points inside, {minima} minimisers, {many} times several; median {:.2} s, longest {:.2} s",
        times.len(),
        times[times.len() / 2],
        times[times.len() - 1],
    );
    assert!(inner > 20 && many > 3);
}

/// z = x y over the unit square, from a point above a foot that is known; and what is refused or has curves of them.
#[test]
fn known_feet() {
    let bilinear = |w: f64| {
        let net = (0..4).map(|k| {
            let (x, y) = ((k / 2) as f64, (k % 2) as f64);
            [x * w, y * w, x * y * w, w]
        });
        patch(1, 1, net.collect())
    };
    // From (u, v) along the normal (-v, -u, 1).
    let (u, v, s) = (0.5, 0.25, 0.25);
    let at = [u - s * v, v - s * u, u * v + s];
    let c = critical_points(nurbs(&bilinear(1.0)), at).unwrap().unwrap();
    assert!(c.all);
    let foot: Vec<_> = c.points.iter().filter(|p| p.inner).collect();
    let truth = s * (1.0 + u * u + v * v).sqrt();
    assert!(foot.iter().any(|p| {
        (p.distance.lo.approximate() - truth).abs() < 1e-15
            && p.minimum == Some(true)
            && (0..3).all(|k| p.at[k][0] <= [u, v, u * v][k] && [u, v, u * v][k] <= p.at[k][1])
    }));
    assert!((least(&c).lo.approximate() - truth).abs() < 1e-15);
    assert!(
        critical_points(nurbs(&bilinear(2.0)), at)
            .unwrap()
            .is_none()
    );
    assert!(critical_points(nurbs(&bilinear(1.0)), [f64::NAN; 3]).is_err());
    // A patch that is a segment: each of its points is critical along v.
    let net = vec![
        [0.0, 0.0, 0.0, 1.0],
        [0.0, 0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0, 1.0],
    ];
    let c = critical_points(nurbs(&patch(1, 1, net)), [0.5, 1.0, 0.0])
        .unwrap()
        .unwrap();
    assert!(!c.all);
}
