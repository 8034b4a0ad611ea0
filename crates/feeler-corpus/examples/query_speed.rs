//! How long queries take, by kind and by file:
//! `cargo run --release -p feeler-corpus --example query_speed [-- [-n QUERIES] [--kind KIND] [--slowest] FILE...]`.
//!
//! Without files: the thesis's native parts. Half of the probes are anywhere about the part, half are near its
//! surface. Times are of one query, on one thread, with everything prepared that a first pass prepared.

use feeler::numeric::Interval;
use feeler::prepare::PreparedBrep;
use feeler::query::*;
use feeler_corpus::Model;
use nalgebra::{Point3, Vector3};
use std::path::{Path, PathBuf};
use std::time::Instant;

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn direction(&mut self) -> Vector3<f64> {
        loop {
            let v = Vector3::from_fn(|_, _| 2.0 * self.unit() - 1.0);
            let n = v.norm();
            if n > 0.1 && n < 1.0 {
                return v / n;
            }
        }
    }
}

/// A point of a random face, in its domain or not far from the region.
fn surface_point(brep: &PreparedBrep, random: &mut Random) -> Point3<f64> {
    let faces = brep.brep().faces().len();
    let mut point = Point3::origin();
    for _ in 0..20 {
        let face = (random.unit() * faces as f64) as usize;
        let domain = brep.brep().surface(face).domain();
        let at = |d: Interval, random: &mut Random| d.lerp(random.unit());
        let uv = nalgebra::Point2::new(at(domain[0], random), at(domain[1], random));
        point = brep.brep().surface(face).point(uv.x, uv.y);
        let on = side(brep, face, uv).is_some_and(|s| s.side == Some(feeler::trim::Side::Inside));
        if on {
            break;
        }
    }
    point
}

fn near_point(brep: &PreparedBrep, random: &mut Random) -> Point3<f64> {
    let off = brep.size() * 10f64.powf(-6.0 * random.unit());
    surface_point(brep, random) + random.direction() * off
}

/// A probe that is not near the surface is so far from it, relative to the size.
const FAR: f64 = 0.05;

struct Times {
    kind: &'static str,
    all: Vec<(f64, String)>,
    undecided: usize,
}

impl Times {
    fn new(kind: &'static str) -> Self {
        Self {
            kind,
            all: Vec::new(),
            undecided: 0,
        }
    }

    fn take(&mut self, what: String, query: impl Fn() -> bool) {
        self.undecided += usize::from(query());
        let start = Instant::now();
        query();
        self.all.push((start.elapsed().as_secs_f64() * 1e6, what));
    }

    fn print(mut self, slowest: bool) {
        self.all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let n = self.all.len();
        let at = |k: usize| self.all[k.min(n - 1)].0;
        println!(
            "  {:12} median {:9.1}  p99 {:9.1}  max {:9.1} us   undecided {} of {n}",
            self.kind,
            at(n / 2),
            at(n * 99 / 100),
            at(n - 1),
            self.undecided
        );
        if slowest {
            for (time, what) in self.all.iter().rev().take(3) {
                println!("    {time:9.1} us: {what}");
            }
        }
    }
}

fn measure(path: &Path, queries: usize, only: Option<&str>, slowest: bool) {
    let model = match Model::load(path, None) {
        Ok(model) => model,
        Err(e) => return eprintln!("{e}"),
    };
    let Some(brep) = model.breps.into_iter().next() else {
        return;
    };
    let start = Instant::now();
    let brep = PreparedBrep::new(brep);
    println!(
        "{}: {} faces, prepared in {:.1} us",
        path.display(),
        brep.brep().faces().len(),
        start.elapsed().as_secs_f64() * 1e6
    );
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let w = || Workspace::default();
    let kinds = ["sphere", "far", "coarse", "half-space", "inside", "line"];
    for kind in kinds {
        if only.is_some_and(|o| o != kind) {
            continue;
        }
        let mut times = Times::new(kind);
        for _ in 0..queries {
            let p = match kind {
                "far" => {
                    surface_point(&brep, &mut random) + random.direction() * (FAR * brep.size())
                }
                _ => near_point(&brep, &mut random),
            };
            let n = random.direction();
            let x = [p.x, p.y, p.z].map(|x| x.to_string()).join(",");
            let y = [n.x, n.y, n.z].map(|x| x.to_string()).join(",");
            let accuracy = match kind {
                "coarse" => Accuracy::Length(1e-12 * brep.size()),
                _ => Accuracy::Full,
            };
            let options = Options {
                accuracy,
                prediction: f64::INFINITY,
                ..Options::default()
            };
            match kind {
                "sphere" | "far" | "coarse" => {
                    let Ok(s) = Sphere::new(p, 0.1 * brep.size()) else {
                        continue;
                    };
                    times.take(format!("--sphere {x},{}", s.radius), || {
                        contact(&brep, &Probe::Sphere(s), &options, &mut w())
                            .undecided
                            .is_some()
                    });
                }
                "half-space" => {
                    let Ok(h) = HalfSpace::new(n, 0.0) else {
                        continue;
                    };
                    times.take(format!("--half-space {y},0"), || {
                        contact(&brep, &Probe::HalfSpace(h), &options, &mut w())
                            .undecided
                            .is_some()
                    });
                }
                "inside" => times.take(format!("inside {x}"), || {
                    inside(&brep, p, &mut w()).undecided.is_some()
                }),
                _ => {
                    let Ok(l) = LineProbe::new(p, n, LineKind::Line) else {
                        continue;
                    };
                    times.take(format!("--line {x},{y}"), || {
                        line(&brep, &l, &options, &mut w()).undecided.is_some()
                    });
                }
            }
        }
        times.print(slowest);
    }
}

fn main() {
    let mut files: Vec<PathBuf> = Vec::new();
    let (mut queries, mut slowest, mut kind) = (200, false, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(a) = arguments.next() {
        match a.as_str() {
            "-n" => {
                queries = arguments
                    .next()
                    .and_then(|n| n.parse().ok())
                    .unwrap_or(queries)
            }
            "--kind" => kind = arguments.next(),
            "--slowest" => slowest = true,
            _ => files.push(a.into()),
        }
    }
    if files.is_empty() {
        let thesis = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/thesis");
        files = [
            "ball",
            "ball_joint_cavity",
            "ball_joint_socket",
            "cube_corner_cut",
            "cube_corner_sphere_cut",
            "cylinder",
            "geneva4_wheel",
            "shift_gate_straight",
        ]
        .map(|f| thesis.join(f).with_extension("3dm"))
        .to_vec();
    }
    for f in files {
        measure(&f, queries, kind.as_deref(), slowest);
    }
}
