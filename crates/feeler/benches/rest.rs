//! Times of lines, sides in uv, preparation and one evaluation: `cargo bench -p feeler --bench rest`.
//!
//! One iteration is 20 queries, as in the bench `contact`; they go round a list of 500 (sides: 10,000) places. A preparation is
//! that of one surface of 25 patches and its first answer.

#[path = "../tests/it/scenes/mod.rs"]
mod scenes;

use divan::{Bencher, black_box};
use feeler::brep::Brep;
use feeler::nurbs::Curve2;
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, LineKind, LineProbe, Options, Probe, Sphere, Workspace, contact, line,
};
use feeler::trim::TrimRegion;
use nalgebra::{Point2, Point3};
use scenes::loops::{anywhere, comb, face_within, islands, near, wavy};
use scenes::{Random, bicubic, nurbs_sphere, wavy_prism};

fn main() {
    divan::main();
}

const QUERIES: usize = 20;

/// How exact the answer must be, as a share of the model's size; `None` is full accuracy.
fn accuracy(name: &str, size: f64) -> Accuracy {
    match name {
        "1e-12" => Accuracy::Length(1e-12 * size),
        _ => Accuracy::Full,
    }
}

const NAMES: [&str; 2] = ["1e-12", "full"];

/// Lines through points near the middle of a part, in all directions.
fn lines(bencher: Bencher, brep: Brep, name: &str, reach: [f64; 3]) {
    let brep = PreparedBrep::new(brep);
    let options = Options {
        accuracy: accuracy(name, brep.size()),
        ..Options::default()
    };
    let mut random = Random::new(13);
    let probes: Vec<LineProbe> = (0..500)
        .map(|_| {
            let at = Point3::from(reach.map(|r| random.between(-r, r)));
            LineProbe::new(at, random.direction(), LineKind::Line).expect("a line")
        })
        .collect();
    let mut workspace = Workspace::default();
    let mut ask = |probe: &LineProbe| line(&brep, probe, &options, &mut workspace);
    let (mut undecided, mut hits) = (0, 0);
    for p in &probes {
        let answer = ask(p);
        undecided += usize::from(answer.undecided.is_some());
        hits += answer.hits.len();
    }
    eprintln!("{undecided} of {} undecided, {hits} hits", probes.len());
    let mut next = 0;
    bencher.bench_local(|| {
        for _ in 0..QUERIES {
            next = (next + 1) % probes.len();
            black_box(ask(black_box(&probes[next])));
        }
    });
}

#[divan::bench(args = NAMES)]
fn line_40_faces(bencher: Bencher, name: &str) {
    lines(bencher, wavy_prism(38), name, [6.0, 6.0, 1.0]);
}

#[divan::bench(args = NAMES)]
fn line_nurbs_sphere(bencher: Bencher, name: &str) {
    lines(bencher, nurbs_sphere(), name, [1.5; 3]);
}

#[divan::bench(args = NAMES)]
fn line_bicubic(bencher: Bencher, name: &str) {
    lines(bencher, bicubic(), name, [1.0, 1.0, 0.25]);
}

fn sides(bencher: Bencher, loops: Vec<Vec<Curve2>>, places: &str) {
    let brep = face_within(loops);
    let region = TrimRegion::new(&brep, 0);
    let mut random = Random::new(7);
    let points: Vec<Point2<f64>> = match places {
        "within 1e-12" => near(&region, 1e-12, 10_000, &mut random),
        _ => anywhere(&region, 10_000, &mut random),
    };
    points.iter().for_each(|p| {
        black_box(region.side(*p));
    });
    let mut next = 0;
    bencher.bench_local(|| {
        for _ in 0..QUERIES {
            next = (next + 1) % points.len();
            black_box(region.side(black_box(points[next])));
        }
    });
}

#[divan::bench(args = ["random", "within 1e-12"])]
fn side_64_cubics(bencher: Bencher, places: &str) {
    sides(bencher, vec![wavy(64, &mut Random::new(1))], places);
}

#[divan::bench(args = ["comb", "islands"])]
fn side_200k_arcs(bencher: Bencher, kind: &str) {
    let loops = match kind {
        "comb" => vec![comb(200_000)],
        _ => islands(200_000, &mut Random::new(1)),
    };
    sides(bencher, loops, "random");
}

/// Patches of [`bicubic`].
#[divan::bench(args = NAMES)]
fn prepare_25_patches(bencher: Bencher, name: &str) {
    let brep = bicubic();
    let probe = Sphere::new(Point3::new(0.4, 0.6, 0.1), 0.1).expect("a sphere");
    let accuracy = accuracy(name, 1.0);
    let options = Options {
        accuracy,
        prediction: f64::INFINITY,
        ..Options::default()
    };
    bencher
        .with_inputs(|| (brep.clone(), Workspace::default()))
        .bench_local_values(|(brep, mut workspace)| {
            let brep = PreparedBrep::new(brep);
            black_box(contact(
                &brep,
                &Probe::Sphere(probe),
                &options,
                &mut workspace,
            ));
            brep
        });
}

/// What the others may be counted in: a point of the same surface with its first and second derivatives.
#[divan::bench]
fn evaluation_bicubic(bencher: Bencher) {
    let brep = bicubic();
    let mut random = Random::new(3);
    let places: Vec<[f64; 2]> = (0..500)
        .map(|_| [0, 1].map(|_| random.between(0.0, 1.0)))
        .collect();
    let mut next = 0;
    bencher.bench_local(|| {
        for _ in 0..QUERIES {
            next = (next + 1) % places.len();
            let [u, v] = black_box(places[next]);
            black_box(brep.surface(0).derivatives(u, v, 2));
        }
    });
}
