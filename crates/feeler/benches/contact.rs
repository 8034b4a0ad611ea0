//! Times of contact queries: `cargo bench -p feeler --bench contact`.
//!
//! The scenes are those of the table of figures to beat. One iteration is 20 queries; they go round a
//! list of 500 places.

#[path = "../tests/it/scenes/mod.rs"]
mod scenes;

use divan::{Bencher, black_box};
use feeler::brep::Brep;
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, Contacts, Options, Probe, Sphere, Witness, Workspace, contact, contact_from, overlap,
};
use nalgebra::Point3;
use scenes::loops::{Holes, face_within, over_holes, perforated};
use scenes::{Random, bicubic, native_sphere, nurbs_sphere, trimmed_bicubic};

fn main() {
    divan::main();
}

/// Queries an iteration: divan's own sample of one would be noise.
const QUERIES: usize = 20;

/// How exact the answer must be, as a share of the model's size; `None` is full accuracy.
const ACCURACIES: [(&str, Option<f64>); 3] =
    [("1e-6", Some(1e-6)), ("1e-12", Some(1e-12)), ("full", None)];

/// Runs sphere queries around a list of centres.
fn spheres(
    bencher: Bencher,
    brep: Brep,
    radius: f64,
    accuracy: Option<f64>,
    centers: &[Point3<f64>],
) {
    let brep = PreparedBrep::new(brep);
    let options = Options {
        accuracy: accuracy.map_or(Accuracy::Full, |a| Accuracy::Length(a * brep.size())),
        prediction: f64::INFINITY,
        ..Options::default()
    };
    let mut workspace = Workspace::default();
    let mut ask = |center: Point3<f64>| {
        let probe = Probe::Sphere(Sphere::new(center, radius).expect("a sphere"));
        contact(&brep, &probe, &options, &mut workspace)
    };
    let mut undecided = 0;
    for c in centers {
        undecided += usize::from(ask(*c).undecided.is_some());
    }
    if undecided > 0 {
        eprintln!("{undecided} of {} undecided", centers.len());
    }
    let mut next = 0;
    bencher.bench_local(|| {
        for _ in 0..QUERIES {
            next = (next + 1) % centers.len();
            black_box(ask(black_box(centers[next])));
        }
    });
}

fn accuracy(name: &str) -> Option<f64> {
    ACCURACIES.iter().find(|a| a.0 == name).expect("known").1
}

fn over_the_wave() -> Vec<Point3<f64>> {
    let mut random = Random::new(7);
    let mut at = |_| {
        Point3::new(
            random.between(0.1, 0.9),
            random.between(0.1, 0.9),
            random.between(-0.3, 0.3),
        )
    };
    (0..500).map(&mut at).collect()
}

fn off_center(least: f64, most: f64) -> Vec<Point3<f64>> {
    let mut random = Random::new(11);
    let mut at = |_| {
        let off = least * (most / least).powf(random.between(0.0, 1.0));
        Point3::origin() + random.direction() * off
    };
    (0..500).map(&mut at).collect()
}

const NAMES: [&str; 3] = [ACCURACIES[0].0, ACCURACIES[1].0, ACCURACIES[2].0];

#[divan::bench(args = NAMES)]
fn bicubic_8x8(bencher: Bencher, name: &str) {
    spheres(bencher, bicubic(), 0.01, accuracy(name), &over_the_wave());
}

#[divan::bench(args = NAMES)]
fn bicubic_8x8_trimmed(bencher: Bencher, name: &str) {
    spheres(
        bencher,
        trimmed_bicubic(),
        0.01,
        accuracy(name),
        &over_the_wave(),
    );
}

/// Over holes of a plate with 1,024.
#[divan::bench(args = ["arcs", "splines", "polygons"])]
fn perforated_plate(bencher: Bencher, name: &str) {
    let holes = match name {
        "arcs" => Holes::Arcs,
        "splines" => Holes::Splines,
        _ => Holes::Polygons(24),
    };
    let (loops, centers) = perforated(32, holes);
    let over = over_holes(&centers, 500, &mut Random::new(3));
    spheres(bencher, face_within(loops), 0.01, None, &over);
}

#[divan::bench(args = NAMES)]
fn ball_joint_nurbs(bencher: Bencher, name: &str) {
    spheres(
        bencher,
        nurbs_sphere(),
        2.49,
        accuracy(name),
        &off_center(1e-3, 1.25),
    );
}

#[divan::bench(args = NAMES)]
fn ball_joint_nurbs_near_the_centre(bencher: Bencher, name: &str) {
    spheres(
        bencher,
        nurbs_sphere(),
        2.49,
        accuracy(name),
        &off_center(1e-16, 1e-3),
    );
}

#[divan::bench(args = NAMES)]
fn ball_joint_native(bencher: Bencher, name: &str) {
    let brep = native_sphere();
    spheres(
        bencher,
        brep,
        2.49,
        accuracy(name),
        &off_center(1e-12, 1.25),
    );
}

/// The questions that ask less, about the same places: whether the ball overlaps, and the separation alone.
const QUESTIONS: [&str; 3] = ["overlap", "separation", "deepest contact"];

fn asked(bencher: Bencher, brep: Brep, radius: f64, question: &str, centers: &[Point3<f64>]) {
    let brep = PreparedBrep::new(brep);
    let options = Options {
        prediction: f64::INFINITY,
        contacts: match question {
            "separation" => Contacts::None,
            _ => Contacts::Deepest,
        },
        ..Options::default()
    };
    let mut workspace = Workspace::default();
    let mut ask = |center: Point3<f64>| {
        let probe = Probe::Sphere(Sphere::new(center, radius).expect("a sphere"));
        if question == "overlap" {
            black_box(overlap(&brep, &probe, &options, &mut workspace));
        } else {
            black_box(contact(&brep, &probe, &options, &mut workspace));
        }
    };
    centers.iter().for_each(|c| ask(*c));
    let mut next = 0;
    bencher.bench_local(|| {
        for _ in 0..QUERIES {
            next = (next + 1) % centers.len();
            ask(black_box(centers[next]));
        }
    });
}

#[divan::bench(args = QUESTIONS)]
fn question_bicubic_8x8(bencher: Bencher, question: &str) {
    let brep = bicubic();
    asked(bencher, brep, 0.1, question, &over_the_wave());
}

#[divan::bench(args = QUESTIONS)]
fn question_bicubic_8x8_trimmed(bencher: Bencher, question: &str) {
    asked(bencher, trimmed_bicubic(), 0.1, question, &over_the_wave());
}

#[divan::bench(args = QUESTIONS)]
fn question_ball_joint_nurbs(bencher: Bencher, question: &str) {
    asked(
        bencher,
        nurbs_sphere(),
        2.0,
        question,
        &off_center(1e-3, 1.25),
    );
}

/// Balls that move over the wave, each asked from scratch or with what those before have learnt: to and fro on lines between some places, in so many steps each.
fn path(bencher: Bencher, brep: Brep, name: &str, steps: u32, warm: bool) {
    let brep = PreparedBrep::new(brep);
    let options = Options {
        accuracy: accuracy(name).map_or(Accuracy::Full, |a| Accuracy::Length(a * brep.size())),
        prediction: f64::INFINITY,
        ..Options::default()
    };
    let corners = over_the_wave();
    let places: Vec<Point3<f64>> = corners
        .windows(2)
        .take((PLACES / steps) as usize)
        .flat_map(|w| (0..steps).map(|k| w[0] + (w[1] - w[0]) * (f64::from(k) / f64::from(steps))))
        .collect();
    let mut workspace = Workspace::default();
    let mut witness = Witness::default();
    let mut ask = |center: Point3<f64>| {
        let probe = Probe::Sphere(Sphere::new(center, 0.01).expect("a sphere"));
        black_box(if warm {
            contact_from(&brep, &probe, &mut witness, &options, &mut workspace)
        } else {
            contact(&brep, &probe, &options, &mut workspace)
        });
    };
    places.iter().for_each(|c| ask(*c));
    let mut next = 0;
    bencher.bench_local(|| {
        for _ in 0..QUERIES {
            next = (next + 1) % places.len();
            ask(black_box(places[next]));
        }
    });
}

/// Each step is about a third of a percent of the size, or a tenth of that.
const STEPS: u32 = 100;
const SLOW_STEPS: u32 = 1000;
const PLACES: u32 = 2000;

#[divan::bench(args = NAMES)]
fn path_cold(bencher: Bencher, name: &str) {
    path(bencher, bicubic(), name, STEPS, false);
}

#[divan::bench(args = NAMES)]
fn path_warm(bencher: Bencher, name: &str) {
    path(bencher, bicubic(), name, STEPS, true);
}

#[divan::bench(args = NAMES)]
fn path_warm_slow(bencher: Bencher, name: &str) {
    path(bencher, bicubic(), name, SLOW_STEPS, true);
}

/// One foot in six is on the trim.
#[divan::bench(args = NAMES)]
fn path_warm_trimmed(bencher: Bencher, name: &str) {
    path(bencher, trimmed_bicubic(), name, STEPS, true);
}

#[divan::bench(args = NAMES)]
fn path_warm_slow_trimmed(bencher: Bencher, name: &str) {
    path(bencher, trimmed_bicubic(), name, SLOW_STEPS, true);
}
