//! Batches, and threads that share a BREP: the same bits as queries one by one.

use crate::scenes::{Random, bicubic, cube, nurbs_sphere};
use feeler::brep::Brep;
use feeler::prepare::PreparedBrep;
use feeler::query::{
    HalfSpace, LineKind, LineProbe, Options, Probe, Sphere, Workspace, any_hit, batch, contact,
    inside, line, overlap,
};
use nalgebra::{Point3, Vector3};

const COUNT: usize = 60;

struct Queries {
    probes: Vec<Probe>,
    lines: Vec<LineProbe>,
    points: Vec<Point3<f64>>,
}

fn queries() -> Queries {
    let mut random = Random::new(23);
    let points: Vec<_> = (0..COUNT)
        .map(|_| Point3::from(Vector3::from_fn(|_, _| random.between(-0.5, 1.5))))
        .collect();
    let probe = |(i, p): (usize, &Point3<f64>)| match i % 3 {
        0 => Probe::HalfSpace(HalfSpace::new(random.direction(), p.x).unwrap()),
        _ => Probe::Sphere(Sphere::new(*p, 0.1).unwrap()),
    };
    let probes = points.iter().enumerate().map(probe).collect();
    let line = |p: &Point3<f64>| LineProbe::new(*p, random.direction(), LineKind::Line).unwrap();
    Queries {
        probes,
        lines: points.iter().map(line).collect(),
        points,
    }
}

fn options() -> Options {
    Options {
        prediction: f64::INFINITY,
        ..Options::default()
    }
}

/// All answers, as text that shows every bit of a number and the sign of zero.
fn one_by_one(brep: &PreparedBrep, q: &Queries, order: impl Fn(usize) -> usize) -> Vec<String> {
    let o = options();
    let mut w = Workspace::default();
    let mut out = vec![String::new(); COUNT];
    for i in (0..COUNT).map(order) {
        let (p, l) = (&q.probes[i], &q.lines[i]);
        out[i] = format!(
            "{:?} {:?} {:?} {:?} {:?}",
            contact(brep, p, &o, &mut w),
            overlap(brep, p, &o, &mut w),
            line(brep, l, &o, &mut w),
            any_hit(brep, l, &o, &mut w),
            inside(brep, q.points[i], &mut w),
        );
    }
    out
}

fn batches(brep: &PreparedBrep, q: &Queries) -> Vec<String> {
    let o = options();
    let (mut contacts, mut overlaps) = (Vec::new(), Vec::new());
    let (mut lines, mut any, mut sides) = (Vec::new(), Vec::new(), Vec::new());
    // What a list held before is gone.
    for _ in 0..2 {
        batch::contact(brep, &q.probes, &o, &mut contacts);
        batch::overlap(brep, &q.probes, &o, &mut overlaps);
        batch::line(brep, &q.lines, &o, &mut lines);
        batch::any_hit(brep, &q.lines, &o, &mut any);
        batch::inside(brep, &q.points, &mut sides);
    }
    let counts = [
        contacts.len(),
        overlaps.len(),
        lines.len(),
        any.len(),
        sides.len(),
    ];
    assert_eq!(counts, [COUNT; 5]);
    (0..COUNT)
        .map(|i| {
            format!(
                "{:?} {:?} {:?} {:?} {:?}",
                contacts[i], overlaps[i], lines[i], any[i], sides[i]
            )
        })
        .collect()
}

fn scenes() -> [Brep; 3] {
    [bicubic(), nurbs_sphere(), cube()]
}

#[test]
fn a_batch_has_the_bits_of_its_queries() {
    let q = queries();
    for brep in scenes() {
        let expected = one_by_one(&PreparedBrep::new(brep.clone()), &q, |i| i);
        assert_eq!(batches(&PreparedBrep::new(brep), &q), expected);
    }
}

#[test]
fn threads_and_orders_change_no_bit() {
    let q = queries();
    for brep in scenes() {
        let expected = one_by_one(&PreparedBrep::new(brep.clone()), &q, |i| i);
        let shared = PreparedBrep::new(brep);
        // Each goes through the queries in an order of its own, while others make what it needs.
        std::thread::scope(|s| {
            let (shared, q) = (&shared, &q);
            let ask = |step| s.spawn(move || one_by_one(shared, q, |i| i * step % COUNT));
            let threads: Vec<_> = [1, 7, 11, 59].map(ask).into_iter().collect();
            for t in threads {
                assert_eq!(t.join().unwrap(), expected);
            }
        });
    }
}

#[cfg(feature = "rayon")]
#[test]
fn any_number_of_rayon_threads_has_the_same_bits() {
    let q = queries();
    for brep in scenes() {
        let expected = one_by_one(&PreparedBrep::new(brep.clone()), &q, |i| i);
        for threads in [1, 2, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let fresh = PreparedBrep::new(brep.clone());
            let found = pool.build().unwrap().install(|| batches(&fresh, &q));
            assert_eq!(found, expected, "{threads} threads");
        }
    }
}
