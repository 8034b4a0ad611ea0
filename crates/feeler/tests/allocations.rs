//! What a query allocates when its workspace and its BREP have been used before. A test of its own: the counting allocator
//! counts for all threads.

#[path = "it/scenes/mod.rs"]
mod scenes;

use feeler::brep::Brep;
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, Contacts, HalfSpace, LineKind, LineProbe, Motion, Options, Probe, Sphere, Witness,
    Workspace, any_hit, arrival, contact, contact_from, evaluate, inside, line, overlap, side,
};
use nalgebra::{Point2, Point3, Vector3};
use scenes::{Random, bicubic, cube, native_sphere, nurbs_sphere, trimmed_bicubic, wavy_prism};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;
use std::hint::black_box;

#[global_allocator]
static COUNTING: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Allocations of one piece of work, growing lists included.
fn count(work: impl FnOnce()) -> usize {
    let region = Region::new(COUNTING);
    work();
    let change = region.change();
    change.allocations + change.reallocations
}

/// What is asked at a place, and with what.
struct At<'a> {
    brep: &'a PreparedBrep,
    place: Point3<f64>,
    radius: f64,
    workspace: &'a mut Workspace,
    witness: &'a mut Witness,
}

impl At<'_> {
    fn ball(&self) -> Probe {
        Probe::Sphere(Sphere::new(self.place, self.radius).unwrap())
    }

    fn half_space(&self) -> Probe {
        let normal = (self.place.coords - Vector3::repeat(0.4)).normalize();
        Probe::HalfSpace(HalfSpace::new(normal, 0.0).unwrap())
    }

    fn line(&self) -> LineProbe {
        let direction = Vector3::new(0.3, -0.7, 1.1);
        LineProbe::new(self.place, direction, LineKind::Line).unwrap()
    }

    fn contact(&mut self, probe: &Probe, options: Options) {
        black_box(contact(self.brep, probe, &options, self.workspace));
    }

    fn go_on(&mut self, probe: &Probe) {
        let options = options(Contacts::Deepest, Accuracy::Full);
        let found = contact_from(self.brep, probe, self.witness, &options, self.workspace);
        black_box(found);
    }

    fn overlap(&mut self, probe: &Probe) {
        black_box(overlap(
            self.brep,
            probe,
            &Options::default(),
            self.workspace,
        ));
    }

    fn uv(&self) -> Point2<f64> {
        self.place.xy()
    }
}

fn options(contacts: Contacts, accuracy: Accuracy) -> Options {
    Options {
        prediction: f64::INFINITY,
        contacts,
        accuracy,
        ..Options::default()
    }
}

/// The most that any query allocates once the same places have been asked about some times: lists have grown by then as much as they will.
fn later_round(brep: &PreparedBrep, radius: f64, ask: fn(&mut At), places: usize) -> usize {
    let mut random = Random::new(41);
    let mut workspace = Workspace::default();
    let mut witness = Witness::default();
    let mut ask = |place: &Point3<f64>| {
        ask(&mut At {
            brep,
            place: *place,
            radius,
            workspace: &mut workspace,
            witness: &mut witness,
        });
    };
    let places: Vec<Point3<f64>> = (0..places)
        .map(|_| Point3::from(Vector3::from_fn(|_, _| random.between(0.1, 0.9))))
        .collect();
    for _ in 0..4 {
        places.iter().for_each(&mut ask);
    }
    // What the test's harness allocates meanwhile, in its own thread, is not counted twice.
    let mut least = |p| count(|| ask(p)).min(count(|| ask(p)));
    places.iter().map(&mut least).max().unwrap_or(0)
}

const FULL: Accuracy = Accuracy::Full;
const COARSE: Accuracy = Accuracy::Length(1e-12);

/// Its name, and how it is asked.
type Question = (&'static str, fn(&mut At));

/// What is asked.
const QUESTIONS: [Question; 17] = [
    ("ball", |at| {
        at.contact(&at.ball(), options(Contacts::Deepest, FULL))
    }),
    ("ball, coarse", |at| {
        at.contact(&at.ball(), options(Contacts::Deepest, COARSE))
    }),
    ("ball, no contacts", |at| {
        at.contact(&at.ball(), options(Contacts::None, FULL))
    }),
    ("ball, all contacts", |at| {
        at.contact(&at.ball(), options(Contacts::All, COARSE))
    }),
    ("ball, from the last", |at| at.go_on(&at.ball())),
    ("ball, overlap", |at| at.overlap(&at.ball())),
    ("half-space", |at| {
        at.contact(&at.half_space(), options(Contacts::Deepest, FULL))
    }),
    ("half-space, no contacts", |at| {
        at.contact(&at.half_space(), options(Contacts::None, FULL))
    }),
    ("half-space, all contacts", |at| {
        at.contact(&at.half_space(), options(Contacts::All, COARSE))
    }),
    ("half-space, from the last", |at| at.go_on(&at.half_space())),
    ("half-space, overlap", |at| at.overlap(&at.half_space())),
    ("line", |at| {
        black_box(line(at.brep, &at.line(), &Options::default(), at.workspace));
    }),
    ("line, any hit", |at| {
        black_box(any_hit(
            at.brep,
            &at.line(),
            &Options::default(),
            at.workspace,
        ));
    }),
    ("inside", |at| {
        black_box(inside(at.brep, at.place, at.workspace));
    }),
    ("arrival", |at| {
        let motion = Motion::new(Vector3::new(0.1, 0.2, -0.3), 1.0).unwrap();
        let none = options(Contacts::None, COARSE);
        let none = Options {
            prediction: 0.0,
            ..none
        };
        black_box(arrival(at.brep, &at.ball(), &motion, &none, at.workspace));
    }),
    ("side", |at| {
        black_box(side(at.brep, 0, at.uv()));
    }),
    ("evaluate", |at| {
        black_box(evaluate(at.brep, 0, at.uv()));
    }),
];

#[test]
fn a_query_that_was_asked_before_allocates_no_more_than_it_does_today() {
    // What each takes today, in the order of the questions. Of a contact 1 is the answer's own list; that of a half-space
    // takes more where it is looked for what lies along with its foot.
    let scenes: [(&str, Brep, f64, [usize; QUESTIONS.len()]); 6] = [
        (
            "native sphere",
            native_sphere(),
            2.0,
            [1, 1, 0, 109, 1, 1, 2, 0, 2538, 2, 1, 4, 3, 0, 1, 0, 2],
        ),
        (
            "cube",
            cube(),
            0.1,
            [1, 1, 0, 4876, 1, 0, 15, 0, 6037, 15, 198, 1, 0, 0, 4, 0, 1],
        ),
        (
            "nurbs sphere",
            nurbs_sphere(),
            2.0,
            [1, 1, 0, 8964, 1, 0, 2, 0, 8651, 2, 0, 245, 107, 0, 4, 0, 23],
        ),
        (
            "wavy prism",
            wavy_prism(6),
            0.1,
            [1, 1, 0, 4126, 1, 0, 23, 21, 4827, 23, 3, 1, 0, 0, 4, 0, 25],
        ),
        (
            "bicubic",
            bicubic(),
            0.1,
            [
                13, 13, 12, 7546, 67, 0, 5, 4, 986, 5, 2, 25, 23, 0, 290, 0, 24,
            ],
        ),
        (
            "bicubic, trimmed",
            trimmed_bicubic(),
            0.1,
            [
                27, 27, 26, 2942, 9, 0, 72, 53, 2758, 72, 24, 23, 23, 0, 293, 0, 24,
            ],
        ),
    ];
    let mut found = Vec::new();
    for (name, brep, radius, limits) in scenes {
        let brep = PreparedBrep::new(brep);
        for ((what, ask), limit) in QUESTIONS.iter().zip(limits) {
            // Lists of contacts take milliseconds to seconds.
            let places = if what.contains("all contacts") { 2 } else { 30 };
            let most = later_round(&brep, radius, *ask, places);
            if most > limit {
                found.push(format!(
                    "{name}, {what}: {most} allocations, {limit} are allowed"
                ));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}
