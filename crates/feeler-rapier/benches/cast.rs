//! Times of casts of balls in the thesis's ball joint, beside Parry's own against triangles: `cargo bench -p feeler-rapier --features experiments`.
//!
//! One iteration is [`QUERIES`] casts of a ball of radius 0.5 mm within the hole of radius 2.5 mm; they go round a list of 200. *Free* ones
//! start off the wall and fly into it; *along* ones start in touch with it, go off along a tangent and are asked when they
//! come to the wall again, which is deeper in by what a cast overlooks (`feeler-rapier`) or at once (Parry: its meshes are in the way of any tangent).
//!
//! One cast, the fastest of 15 samples with builds on both cores beside it (medians up to five times as much):
//!
//! | | free | off the BREP's time, as a way, in the mean | along |
//! |---|---|---|---|
//! | BREP, to 2^-36 of the size (along: 2^-20) | 150 us | | 620 us |
//! | BREP, to 1e-4 mm, the kernel alone | 67 us | 2.8e-5 mm | |
//! | Parry, 1 degree mesh of 128,892 triangles | 19 ms | 1.2e-4 mm | 6.1 ms |
//! | Parry, 10 degree mesh of 1,236 triangles | 110 us | 1.2e-2 mm | 66 us |
//!
//! Before it is timed each says how far its times are from those of the BREP as ways, at the most and in the mean.

use divan::{Bencher, black_box};
use feeler::brep::Brep;
use feeler::prepare::PreparedBrep;
use feeler::query::{Accuracy, Contacts, Options, StraightWay, Workspace, arrival_along};
use feeler_gate::tessellate::{Rule, tessellate};
use feeler_io::{ObjectKind, read_file};
use feeler_rapier::{BrepDispatcher, BrepShape};
use nalgebra::{Point3, Vector3};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::details::ShapeCastOptions;
use parry3d_f64::query::{DefaultQueryDispatcher, QueryDispatcher};
use parry3d_f64::shape::{Ball, Shape, TriMesh};
use std::sync::Arc;

fn main() {
    divan::main();
}

const QUERIES: usize = 20;
/// mm.
const RADIUS: f64 = 0.5;
const HOLE: f64 = 2.5;

/// From where, and how fast; speeds are 1.
type Cast = (Vector, Vector);

/// Numbers that are the same on every machine (Vigna's splitmix64).
struct Random(u64);

impl Random {
    fn between(&mut self, a: f64, b: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        a + (b - a) * ((z >> 11) as f64 / (1u64 << 53) as f64)
    }

    fn direction(&mut self) -> Vector {
        loop {
            let v = Vector::from_array([0; 3].map(|_| self.between(-1.0, 1.0)));
            if v.length() > 0.1 && v.length() < 1.0 {
                return v.normalize();
            }
        }
    }
}

fn part() -> Brep {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../corpora/models/thesis/ball_joint_cavity_nurbs.3dm"
    );
    let objects = read_file(path).expect("a thesis part").objects.into_iter();
    let brep = objects.into_iter().find_map(|object| match object.kind {
        ObjectKind::Brep(brep) => Some(brep),
        _ => None,
    });
    brep.expect("a BREP")
}

/// Where the hole is open its wall is missing: casts keep to its lower half.
fn free() -> Vec<Cast> {
    let mut random = Random(3);
    (0..200)
        .map(|_| {
            let from = random.direction() * random.between(0.0, 1.5);
            let to = random.direction();
            let to = Vector::new(to.x, to.y, -to.z.abs());
            (from, (to * HOLE - from).normalize())
        })
        .collect()
}

fn along() -> Vec<Cast> {
    let mut random = Random(5);
    (0..200)
        .map(|_| {
            let n = random.direction();
            let n = Vector::new(n.x, n.y, -0.2 - n.z.abs()).normalize();
            let along = n.cross(random.direction()).normalize();
            (n * (HOLE - RADIUS), along)
        })
        .collect()
}

fn options(stop_at_penetration: bool) -> ShapeCastOptions {
    ShapeCastOptions {
        stop_at_penetration,
        max_time_of_impact: 4.0,
        ..ShapeCastOptions::default()
    }
}

type Ask<'a> = Box<dyn Fn(&Cast) -> Option<f64> + 'a>;

fn shapes<'a>(d: &'a dyn QueryDispatcher, shape: &'a dyn Shape, stop: bool) -> Ask<'a> {
    Box::new(move |(from, velocity)| {
        let pose = Pose::from_translation(*from);
        let ball = Ball::new(RADIUS);
        let found = d.cast_shapes(&pose, *velocity, shape, &ball, options(stop));
        found.expect("supported").map(|h| h.time_of_impact)
    })
}

fn mesh(degrees: f64) -> TriMesh {
    let rule = Rule {
        degrees,
        chord: f64::INFINITY,
    };
    let mesh = tessellate(&part(), &rule).expect("a mesh");
    let points = mesh.vertices.iter().map(|v| Vector::from_array(*v));
    eprintln!(
        "{} triangles, within {:.1e} mm",
        mesh.triangles.len(),
        mesh.chord_error
    );
    TriMesh::new(points.collect(), mesh.triangles).expect("triangles")
}

fn time(bencher: Bencher, casts: &[Cast], truth: &Ask<'_>, ask: &Ask<'_>) {
    let (mut most, mut sum, mut both, mut missed) = (0.0_f64, 0.0, 0, 0);
    for cast in casts {
        match (truth(cast), ask(cast)) {
            (Some(a), Some(b)) => {
                most = most.max((a - b).abs());
                sum += (a - b).abs();
                both += 1;
            }
            (None, None) => {}
            _ => missed += 1,
        }
    }
    eprintln!(
        "{both} hits, {most:.1e} mm off at the most, {:.1e} in the mean; {missed} that one has and not the other",
        sum / f64::from(both)
    );
    let mut next = 0;
    bencher.bench_local(|| {
        for _ in 0..QUERIES {
            next = (next + 1) % casts.len();
            black_box(ask(black_box(&casts[next])));
        }
    });
}

const WITH: [&str; 4] = ["BREP", "BREP to 1e-4", "mesh 1 degree", "mesh 10 degrees"];

#[divan::bench(args = WITH)]
fn free_ball(bencher: Bencher, with: &str) {
    let shape = BrepShape::new(Arc::new(PreparedBrep::new(part()))).expect("a shape");
    let (own, theirs) = (BrepDispatcher::new(), DefaultQueryDispatcher);
    let truth = shapes(&own, &shape, true);
    let casts = free();
    match with {
        "BREP" => time(bencher, &casts, &truth, &truth),
        "BREP to 1e-4" => {
            // The kernel alone, as exactly as the finer mesh is.
            let ask: Ask<'_> = Box::new(|(from, velocity)| {
                let way = StraightWay {
                    center: Point3::from(from.to_array()),
                    center_bound: 0.0,
                    velocity: Vector3::from(velocity.to_array()),
                    velocity_bound: 0.0,
                };
                let options = Options {
                    accuracy: Accuracy::Length(1e-4),
                    contacts: Contacts::None,
                    ..Options::default()
                };
                let mut workspace = Workspace::default();
                let brep = shape.brep();
                let span = [0.0, 4.0];
                let answer = arrival_along(brep, RADIUS, &way, span, &options, &mut workspace);
                answer.time.map(|t| t.bounds.lo)
            });
            time(bencher, &casts, &truth, &ask);
        }
        "mesh 1 degree" => time(bencher, &casts, &truth, &shapes(&theirs, &mesh(1.0), true)),
        _ => time(bencher, &casts, &truth, &shapes(&theirs, &mesh(10.0), true)),
    }
}

#[divan::bench(args = ["BREP", "mesh 1 degree", "mesh 10 degrees"])]
fn ball_along_the_wall(bencher: Bencher, with: &str) {
    let shape = BrepShape::new(Arc::new(PreparedBrep::new(part()))).expect("a shape");
    let (own, theirs) = (BrepDispatcher::new(), DefaultQueryDispatcher);
    let truth = shapes(&own, &shape, false);
    let casts = along();
    match with {
        "BREP" => time(bencher, &casts, &truth, &truth),
        "mesh 1 degree" => time(bencher, &casts, &truth, &shapes(&theirs, &mesh(1.0), false)),
        _ => time(
            bencher,
            &casts,
            &truth,
            &shapes(&theirs, &mesh(10.0), false),
        ),
    }
}
