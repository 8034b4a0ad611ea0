//! What a query allocates when its workspace and its BREP have been used before. A test of its own: the counting allocator
//! counts for all threads.

#[path = "it/scenes/mod.rs"]
mod scenes;

use feeler::brep::Brep;
use feeler::prepare::PreparedBrep;
use feeler::query::{Accuracy, Contacts, Options, Probe, Sphere, Workspace, contact, overlap};
use nalgebra::{Point3, Vector3};
use scenes::{Random, bicubic, cube, native_sphere, nurbs_sphere, trimmed_bicubic};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static COUNTING: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Allocations of one piece of work, growing lists included.
fn count(work: impl FnOnce()) -> usize {
    let region = Region::new(COUNTING);
    work();
    let change = region.change();
    change.allocations + change.reallocations
}

/// The most that any query allocates once the same places have been asked about some times: lists have grown by then as much as they will.
fn later_round(brep: Brep, radius: f64, options: &Options, sign_only: bool) -> usize {
    let brep = PreparedBrep::new(brep);
    let mut random = Random::new(41);
    let mut workspace = Workspace::default();
    let mut ask = |at: &Point3<f64>| {
        let probe = Probe::Sphere(Sphere::new(*at, radius).unwrap());
        if sign_only {
            std::hint::black_box(overlap(&brep, &probe, options, &mut workspace));
        } else {
            std::hint::black_box(contact(&brep, &probe, options, &mut workspace));
        }
    };
    let places: Vec<Point3<f64>> = (0..100)
        .map(|_| Point3::from(Vector3::from_fn(|_, _| random.between(0.1, 0.9))))
        .collect();
    for _ in 0..8 {
        places.iter().for_each(&mut ask);
    }
    places.iter().map(|p| count(|| ask(p))).max().unwrap_or(0)
}

#[test]
fn a_query_that_was_asked_before_allocates_little() {
    let full = Options {
        prediction: f64::INFINITY,
        ..Options::default()
    };
    let none = Options {
        contacts: Contacts::None,
        ..full
    };
    let coarse = Options {
        accuracy: Accuracy::Length(1e-12),
        ..none
    };
    // The answer's list, and for formulas a list of boxes a face. Boxes that are searched, dozens a query, have none; points in double-double on
    // the border of a face have some, and so have pieces of trims that are cut to be proven on their patch.
    const MOST: usize = 8;
    const BORDERS: usize = 16;
    const TRIMS: usize = 64;
    let cases: [(&str, Brep, f64, &Options, bool, usize); 9] = [
        ("native sphere", native_sphere(), 2.0, &full, false, MOST),
        (
            "native sphere, no contacts",
            native_sphere(),
            2.0,
            &none,
            false,
            MOST,
        ),
        (
            "native sphere, overlap",
            native_sphere(),
            2.0,
            &none,
            true,
            MOST,
        ),
        ("cube", cube(), 0.1, &full, false, MOST),
        ("bicubic", bicubic(), 0.1, &full, false, BORDERS),
        ("bicubic, coarse", bicubic(), 0.1, &coarse, false, BORDERS),
        ("bicubic, overlap", bicubic(), 0.1, &none, true, BORDERS),
        (
            "bicubic, trimmed",
            trimmed_bicubic(),
            0.1,
            &full,
            false,
            TRIMS,
        ),
        ("nurbs sphere", nurbs_sphere(), 2.0, &full, false, MOST),
    ];
    for (name, brep, radius, options, sign_only, limit) in cases {
        let most = later_round(brep, radius, options, sign_only);
        assert!(most <= limit, "{name}: {most}");
    }
}
