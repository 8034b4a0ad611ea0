//! Rolling without bumps: a ball in the groove of a torus, on the BREP and on meshes.
//!
//! # Closed form
//! A ball without friction in a tube of radius a about a level circle of radius R, its centre c = a - r off that circle at the angle
//! theta from straight down: with speed v, v^2 = g rho tan theta, rho = R + c sin theta, it stays at this angle for ever. Its
//! energy is constant, its velocity turns evenly, and its centre runs along a circle. What a run deviates from that is the
//! engine's own time steps, and the shape.

use super::plot::{Line, Marks, Plot};
use super::world::{Body, DAMPING, Edges, HERTZ, brep_body, mesh_body, world};
use super::{Extent, Finding, drawn, median, short, table};
use ::nalgebra::{Point3, Vector3};
use feeler::brep::Brep;
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve, Revolution, Surface};
use rapier3d_f64::prelude::*;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::time::Instant;

/// Radii of the circle, the tube and the ball, m.
const CIRCLE: f64 = 0.5;
const TUBE: f64 = 0.1;
const BALL: f64 = 0.03;
/// Angle of the ball in the tube, from straight down.
const THETA: f64 = 0.5;
/// m/s^2.
const GRAVITY: f64 = 9.81;
/// s.
const STEP: f64 = 1e-3;
/// Steps in which the contact forms: their jumps are not counted.
const FORMING: usize = 5;
/// The BREP is run with steps this much shorter, too: what then goes away is not the shape's.
const SHORTER: f64 = 0.1;
/// Laps.
const LAPS: f64 = 1.0;

fn groove() -> Result<Brep, String> {
    let interval = |a, b| Interval::new(a, b).ok_or("an interval");
    let profile = Arc {
        center: Point3::new(CIRCLE, 0.0, 0.0),
        x: Vector3::x(),
        y: Vector3::z(),
        z: -Vector3::y(),
        radius: TUBE,
        angle: interval(-PI, PI)?,
        domain: interval(0.0, 1.0)?,
    };
    let turned = Revolution {
        origin: Point3::origin(),
        axis: Vector3::z(),
        angle: interval(0.0, TAU)?,
        angle_domain: interval(0.0, 1.0)?,
        profile: Curve::Arc(Arc::new(profile).map_err(|e| e.to_string())?),
        transposed: false,
    };
    let turned = Revolution::new(turned).map_err(|e| e.to_string())?;
    Brep::from_surface(Surface::Revolution(turned)).map_err(|e| e.to_string())
}

/// The even motion: radius of the circle of the centre, its height, the speed.
fn even() -> [f64; 3] {
    let off = TUBE - BALL;
    let rho = CIRCLE + off * THETA.sin();
    [
        rho,
        -off * THETA.cos(),
        (GRAVITY * rho * THETA.tan()).sqrt(),
    ]
}

#[derive(Default)]
struct Track {
    time: Vec<f64>,
    /// Relative to the kinetic energy at the start.
    energy: Vec<f64>,
    /// Distance of the centre from the circle it should run along, m.
    path: Vec<f64>,
    /// How far the change of velocity in a step is from that of the even motion, in units of gravity.
    bump: Vec<f64>,
    step_us: Vec<f64>,
    places: Vec<[f64; 3]>,
}

fn simulate(body: &Body, dt: f64) -> Track {
    let mut w = world(GRAVITY, BALL, dt, body);
    let ground = w.insert_body(RigidBodyBuilder::fixed());
    let collider = ColliderBuilder::new(body.shape.clone());
    w.insert_collider(collider.friction(0.0), Some(ground));
    let [rho, z, v] = even();
    let ball = RigidBodyBuilder::dynamic()
        .translation(Vector::new(rho, 0.0, z))
        .linvel(Vector::new(0.0, v, 0.0))
        .can_sleep(false);
    let ball = w.insert_body(ball);
    let collider = ColliderBuilder::ball(BALL).mass(1.0).friction(0.0);
    w.insert_collider(collider, Some(ball));
    let mut track = Track::default();
    let steps = (LAPS * TAU * rho / v / dt).ceil() as usize;
    let energy = |at: Vector, v: Vector| 0.5 * v.length_squared() + GRAVITY * at.z;
    let kinetic = 0.5 * v * v;
    let start = energy(Vector::new(rho, 0.0, z), Vector::new(0.0, v, 0.0));
    let mut before = w.bodies[ball].linvel();
    for k in 0..steps {
        let begun = Instant::now();
        w.step();
        track.step_us.push(begun.elapsed().as_secs_f64() * 1e6);
        let (at, now) = (w.bodies[ball].translation(), w.bodies[ball].linvel());
        let across = at.x.hypot(at.y);
        track.time.push((k + 1) as f64 * dt);
        track.places.push(at.to_array());
        track.energy.push((energy(at, now) - start) / kinetic);
        track.path.push((across - rho).hypot(at.z - z));
        // Even motion: towards the axis, v^2 / rho.
        let inward = Vector::new(at.x, at.y, 0.0) * (-v * v / rho / across);
        track
            .bump
            .push(((now - before) / dt - inward).length() / GRAVITY);
        before = now;
    }
    track
}

fn most(values: &[f64]) -> f64 {
    values.iter().map(|v| v.abs()).fold(0.0, f64::max)
}

/// Deviations: of the path in radii of the ball, of the energy, of the velocity in a step.
fn worst(t: &Track) -> [f64; 3] {
    [
        most(&t.path) / BALL,
        most(&t.energy),
        most(&t.bump[FORMING..]),
    ]
}

fn row(name: String, body: &Body, t: &Track) -> Vec<String> {
    let [path, energy, bump] = worst(t);
    vec![
        name,
        body.triangles.map_or("-".to_owned(), |n| n.to_string()),
        short(median(&t.step_us)),
        short(path * BALL * 1e3),
        short(t.energy.last().copied().unwrap_or(f64::NAN)),
        short(energy),
        short(bump),
        short(median(&t.bump)),
    ]
}

pub(super) fn run(extent: Extent, progress: &mut dyn FnMut(&str)) -> Result<Finding, String> {
    let brep = groove()?;
    let degrees: &[f64] = match extent {
        Extent::Quick => &[30.0],
        Extent::Whole | Extent::Finest => &[60.0, 30.0, 10.0, 3.0, 1.0, 0.5],
    };
    let mut bodies = vec![brep_body(brep.clone())?.0];
    for edges in [Edges::Plain, Edges::Fixed { turned: true }] {
        for d in degrees {
            bodies.push(mesh_body(&brep, *d, edges)?);
        }
    }
    let mut rows = Vec::new();
    let (mut path, mut bump) = (Vec::new(), Vec::new());
    // Of plain meshes, then of fixed ones: the path and the jumps.
    let mut marks: [[Vec<(f64, f64)>; 2]; 2] = Default::default();
    let mut own = [0.0; 2];
    let mut scenes = Vec::new();
    for body in &bodies {
        progress(&format!("torus groove, {}", body.name));
        let t = simulate(body, STEP);
        let worst = worst(&t);
        match body.triangles {
            Some(n) => {
                let kind = usize::from(body.name.ends_with("fixed"));
                marks[kind][0].push((n as f64, worst[0]));
                marks[kind][1].push((n as f64, worst[2]));
            }
            None => {
                own = [worst[0], worst[2]];
                scenes.push(drawn("rolling-torus", brep.clone(), BALL, &t.places));
            }
        }
        rows.push(row(body.name.clone(), body, &t));
        // Lines over time for some: the others differ little from these.
        const SHOWN: [&str; 4] = [
            "BREP",
            "10 degree mesh",
            "10 degree mesh, inner edges fixed",
            "1 degree mesh, inner edges fixed",
        ];
        if SHOWN.contains(&body.name.as_str()) {
            let line = |values: &[f64]| Line {
                name: body.name.clone(),
                points: t
                    .time
                    .iter()
                    .copied()
                    .zip(values.iter().map(|v| v.max(1e-12)))
                    .collect(),
                marks: Marks::None,
            };
            path.push(line(&t.path));
            bump.push(line(&t.bump));
        }
    }
    progress("torus groove, BREP, shorter steps");
    let fine = simulate(&bodies[0], SHORTER * STEP);
    let name = format!("BREP, steps of {:.0e} s", SHORTER * STEP);
    rows.insert(1, row(name, &bodies[0], &fine));
    let mut against = Vec::new();
    let names = ["off the path, ball radii", "jump of velocity, g"];
    let counts = || bodies.iter().filter_map(|b| b.triangles).map(|n| n as f64);
    let from = counts().fold(f64::INFINITY, f64::min);
    let to = counts().fold(from * 1.001, f64::max);
    for (k, name) in names.iter().enumerate() {
        for (kind, what) in ["mesh", "mesh, fixed"].iter().enumerate() {
            against.push(Line {
                name: format!("{what}: {name}"),
                points: marks[kind][k].clone(),
                marks: Marks::Too,
            });
        }
        against.push(Line {
            name: format!("BREP: {name}"),
            points: vec![(from, own[k]), (to, own[k])],
            marks: Marks::None,
        });
    }
    let plots = [
        (
            "rolling-torus.svg",
            Plot {
                title: "One lap in the groove of a torus: largest deviation from the closed form"
                    .to_owned(),
                x: "triangles".to_owned(),
                y: "largest deviation".to_owned(),
                lines: against,
                log: [true, true],
            },
        ),
        (
            "rolling-torus-bumps.svg",
            Plot {
                title: "Jump of the velocity in a step, beside that of even motion".to_owned(),
                x: "time, s".to_owned(),
                y: "in units of gravity".to_owned(),
                lines: bump,
                log: [false, true],
            },
        ),
        (
            "rolling-torus-path.svg",
            Plot {
                title: "Distance of the ball's centre from the circle it should run along"
                    .to_owned(),
                x: "time, s".to_owned(),
                y: "m".to_owned(),
                lines: path,
                log: [false, true],
            },
        ),
    ];
    let mut plots: Vec<_> = plots
        .into_iter()
        .map(|(n, p)| (n.to_owned(), p.svg()))
        .collect();
    let head = [
        "shape",
        "triangles",
        "step us",
        "off the path, mm",
        "energy at the end",
        "energy, most",
        "jump of velocity, most, g",
        "median, g",
    ];
    let [rho, _, v] = even();
    let mut page = format!(
        "# Rolling without bumps\n\n\
        A ball of radius {BALL} m without friction in the groove of a torus (a tube of radius {TUBE} m about a level circle of radius \
        {CIRCLE} m), set off so that it should run for ever along a circle of radius {rho:.4} m at {v:.4} m/s. {LAPS} lap, \
        steps of {STEP} s in Rapier 0.36 (f64); contact recycling off, softness {HERTZ} Hz with a damping ratio of {DAMPING}, slop {:.0e} m. Meshes have Rapier's clustering of contacts, and are shown \
        plain and with Parry's `FIX_INTERNAL_EDGES` (*fixed*). \
        Energies are relative to the kinetic one. *Jump*: how far the change of velocity in one step is from that of even \
        motion, per step length, in units of gravity; a smooth wall gives small ones (the first {FORMING} steps, in which the contact forms, left out).\n\n",
        1e-6 * BALL
    );
    page += &table(&head, &rows);
    page.push('\n');
    for (name, _) in &plots {
        let _ = writeln!(page, "![{name}]({name})\n");
    }
    let sheet = super::sheet::run(extent, progress)?;
    page += &sheet.page;
    plots.extend(sheet.plots);
    scenes.extend(sheet.scenes);
    Ok(Finding {
        page,
        plots,
        scenes,
    })
}
