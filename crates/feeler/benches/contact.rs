//! Times of contact queries: `cargo bench -p feeler --bench contact`.
//!
//! The scenes are those of the table of figures to beat. One iteration is 20 queries; they go round a
//! list of 500 places.

use divan::{Bencher, black_box};
use feeler::brep::{Brep, BrepBuilder, TrimSpec};
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve, NurbsCurve, NurbsSurface, Revolution, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, Contact, Contacts, Options, Probe, Sphere, Workspace, contact, contact_from, overlap,
};
use nalgebra::{Point3, Vector3, Vector4};

fn main() {
    divan::main();
}

/// Queries an iteration: divan's own sample of one would be noise.
const QUERIES: usize = 20;

/// How exact the answer must be, as a share of the model's size; `None` is full accuracy.
const ACCURACIES: [(&str, Option<f64>); 3] =
    [("1e-6", Some(1e-6)), ("1e-12", Some(1e-12)), ("full", None)];

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    fn direction(&mut self) -> Vector3<f64> {
        loop {
            let v = Vector3::from_fn(|_, _| self.between(-1.0, 1.0));
            let n = v.norm();
            if n > 0.1 && n < 1.0 {
                return v / n;
            }
        }
    }
}

fn interval(a: f64, b: f64) -> Interval {
    Interval::new(a, b).expect("an interval")
}

/// A bicubic surface with 8 x 8 control points over the unit square, wavy in height.
fn bicubic() -> NurbsSurface {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let knots: Vec<f64> = [vec![0.0; 4], vec![0.2, 0.4, 0.6, 0.8], vec![1.0; 4]].concat();
    let mut net = Vec::new();
    for i in 0..8 {
        for j in 0..8 {
            // The Greville abscissas: u and v are x and y.
            let at = |k: usize| (knots[k + 1] + knots[k + 2] + knots[k + 3]) / 3.0;
            net.push(Vector4::new(at(i), at(j), random.between(-0.25, 0.25), 1.0));
        }
    }
    NurbsSurface::new([3, 3], [8, 8], net, [knots.clone(), knots]).expect("a bicubic")
}

/// The face of [`bicubic`] within a closed curve of four rational quadratics.
fn trimmed_bicubic() -> Brep {
    let s = std::f64::consts::FRAC_1_SQRT_2;
    let knots = vec![0., 0., 0., 1., 1., 2., 2., 3., 3., 4., 4., 4.];
    let ring = [
        (1, 0),
        (1, 1),
        (0, 1),
        (-1, 1),
        (-1, 0),
        (-1, -1),
        (0, -1),
        (1, -1),
        (1, 0),
    ];
    let net = ring
        .iter()
        .enumerate()
        .map(|(k, &(x, y))| {
            let w = if k % 2 == 0 { 1.0 } else { s };
            let at = |x: i32| (0.5 + 0.4 * f64::from(x)) * w;
            [at(x), at(y), w].into()
        })
        .collect();
    let curve = NurbsCurve::new(2, net, knots).expect("a circle");
    let mut b = BrepBuilder::new();
    let at = b.vertex([0.9, 0.5, 0.0]);
    // The copy of the curve in space is for display only.
    let circle = Arc {
        center: Point3::new(0.5, 0.5, 0.0),
        x: Vector3::x(),
        y: Vector3::y(),
        z: Vector3::z(),
        radius: 0.4,
        angle: interval(0.0, std::f64::consts::TAU),
        domain: interval(0.0, 1.0),
    };
    let circle = Curve::Arc(Arc::new(circle).expect("a circle"));
    let trim = TrimSpec {
        vertices: [at, at],
        curve: Curve::Nurbs(curve),
        edge: Some(b.edge([at, at], circle).expect("an edge")),
    };
    b.face_with_trims(Surface::Nurbs(bicubic()), vec![vec![trim]])
        .expect("a face");
    b.build().expect("a BREP")
}

/// A sphere of radius 2.5: an arc turned about the z axis.
fn sphere() -> Surface {
    let half = std::f64::consts::FRAC_PI_2;
    let profile = Arc {
        center: Point3::origin(),
        x: Vector3::x(),
        y: Vector3::z(),
        z: -Vector3::y(),
        radius: 2.5,
        angle: interval(-half, half),
        domain: interval(0.0, 1.0),
    };
    let turned = Revolution {
        origin: Point3::origin(),
        axis: Vector3::z(),
        angle: interval(0.0, 4.0 * half),
        angle_domain: interval(0.0, 1.0),
        profile: Curve::Arc(Arc::new(profile).expect("an arc")),
        transposed: false,
    };
    Surface::Revolution(Revolution::new(turned).expect("a sphere"))
}

fn nurbs_sphere() -> Brep {
    let surface = sphere().to_nurbs().expect("a sphere").nurbs;
    Brep::from_surface(Surface::Nurbs(surface)).expect("a BREP")
}

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
    let mut random = Random(7);
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
    let mut random = Random(11);
    let mut at = |_| {
        let off = least * (most / least).powf(random.unit());
        Point3::origin() + random.direction() * off
    };
    (0..500).map(&mut at).collect()
}

const NAMES: [&str; 3] = [ACCURACIES[0].0, ACCURACIES[1].0, ACCURACIES[2].0];

#[divan::bench(args = NAMES)]
fn bicubic_8x8(bencher: Bencher, name: &str) {
    let brep = Brep::from_surface(Surface::Nurbs(bicubic())).expect("a BREP");
    spheres(bencher, brep, 0.01, accuracy(name), &over_the_wave());
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
    let brep = Brep::from_surface(sphere()).expect("a BREP");
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
    let brep = Brep::from_surface(Surface::Nurbs(bicubic())).expect("a BREP");
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

/// Balls that move over the wave in small steps, each asked from scratch or from the last contact.
fn path(bencher: Bencher, name: &str, warm: bool) {
    let brep = Brep::from_surface(Surface::Nurbs(bicubic())).expect("a BREP");
    let brep = PreparedBrep::new(brep);
    let options = Options {
        accuracy: accuracy(name).map_or(Accuracy::Full, |a| Accuracy::Length(a * brep.size())),
        prediction: f64::INFINITY,
        ..Options::default()
    };
    // To and fro on lines between some places, 100 steps each.
    let corners = over_the_wave();
    let places: Vec<Point3<f64>> = corners
        .windows(2)
        .take(20)
        .flat_map(|w| (0..100).map(|k| w[0] + (w[1] - w[0]) * (f64::from(k) / 100.0)))
        .collect();
    let mut workspace = Workspace::default();
    let mut last: Option<Contact> = None;
    let mut ask = |center: Point3<f64>| {
        let probe = Probe::Sphere(Sphere::new(center, 0.01).expect("a sphere"));
        let answer = match &last {
            Some(c) if warm => contact_from(&brep, &probe, c, &options, &mut workspace),
            _ => contact(&brep, &probe, &options, &mut workspace),
        };
        last = answer.contacts.first().copied();
        black_box(answer);
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

#[divan::bench(args = NAMES)]
fn path_cold(bencher: Bencher, name: &str) {
    path(bencher, name, false);
}

#[divan::bench(args = NAMES)]
fn path_warm(bencher: Bencher, name: &str) {
    path(bencher, name, true);
}
