//! The spherical ball joint of the thesis (5.1): a ball in a spherical hole that a motor turns.
//!
//! The part with the hole turns about the x axis, which is level; the ball does not turn, and is free to move. It climbs until the
//! wall is as steep as the friction bears, at the angle atan mu, and slides: friction is then m g sin(atan mu), and the motor
//! needs m g R sin(atan mu), R the hole's radius, whatever that of the ball.

use super::plot::{Line, Marks, Plot};
use super::world::{Body, DAMPING, Edges, HERTZ, brep_body, mesh_body, world};
use super::{Extent, Finding, Scene, ball_query, median, part, short, spread, table};
use crate::{BrepDispatcher, BrepShape, ball_gap};
use parry3d_f64::query::{DefaultQueryDispatcher, PersistentQueryDispatcher, QueryDispatcher};
use rapier3d_f64::prelude::*;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

/// Radius of the hole, mm.
const HOLE: f64 = 2.5;
/// Balls, mm.
const BALLS: [f64; 3] = [2.472, 2.5, 2.51];
/// kg.
const MASS: f64 = 1.0;
const FRICTION: f64 = 0.5;
/// mm/s^2.
const GRAVITY: f64 = 9810.0;
/// Revolutions a second: what the plots and most tables are about, and a second speed for one table.
const SPEED: f64 = 2.0;
const FASTER: f64 = 2.5;
/// s. The centre of the smallest ball goes round a circle of 0.028 mm, the wall at 31 mm/s: in steps of 1e-3 s, within which the engine keeps
/// the normal, the ball would be flung through the wall.
const STEP: f64 = 2e-5;
/// Prediction (0.02) and slop (1e-6) of the engine go by it, mm.
const UNIT: f64 = 0.1;
/// kg mm^2: of the part, given to it; it does not matter once it turns evenly.
const INERTIA: f64 = 1.0;
/// Of the ball's motion, 1/s: its swing about the angle at which it slides dies away; where it rests it does not matter.
const BALL_DAMPING: f64 = 100.0;
/// Of the motor, 1/s: it holds the speed to what the torque is of this times inertia and speed, a thousandth.
const GAIN: f64 = 1e6;
/// From kg mm^2/s^2 to N mm.
const NEWTON_MM: f64 = 1e-3;
/// What is as near as this counts as touching on the page that shows it, mm: four times the ball's depth at rest, g / (2 pi f)^2.
const SHOWN: f64 = 1e-3;
/// From which part of a run the ball is taken to slide evenly.
const EVEN: f64 = 0.5;
/// Depths and torques below this are not drawn.
const LEAST: f64 = 1e-6;
/// A run of many triangles is cut short after this, quick and whole.
const SECONDS: [f64; 2] = [15.0, 150.0];

/// One run, a number a step.
#[derive(Default)]
struct Track {
    time: Vec<f64>,
    /// Mean depth of the engine's deepest contact, mm; negative apart.
    depth: Vec<f64>,
    /// The certified gap of ball and BREP at the two poses, mm.
    gap: Vec<f64>,
    /// Width of its enclosure.
    width: Vec<f64>,
    /// N mm.
    torque: Vec<f64>,
    /// Revolutions a second.
    speed: Vec<f64>,
    step_us: Vec<f64>,
    update_us: Vec<f64>,
    cut_short: bool,
}

/// A setting of the engine's solver, as it is changed from that of the experiment.
struct Solver {
    name: &'static str,
    set: fn(&mut IntegrationParameters),
}

/// The experiment's.
const USUAL: Solver = Solver {
    name: "as above",
    set: |_| {},
};

/// What the growth of the depth might hang on.
const SOLVERS: [Solver; 9] = [
    USUAL,
    Solver {
        name: "softness of 4000 Hz",
        set: |p| p.contact_softness.natural_frequency = 4.0 * HERTZ,
    },
    Solver {
        name: "softness of 250 Hz",
        set: |p| p.contact_softness.natural_frequency = 0.25 * HERTZ,
    },
    Solver {
        name: "no limit of the corrective velocity",
        set: |p| p.normalized_max_corrective_velocity = Real::MAX,
    },
    Solver {
        name: "steps half as long",
        set: |p| p.dt *= 0.5,
    },
    Solver {
        name: "16 solver iterations for 4",
        set: |p| p.num_solver_iterations = 16,
    },
    Solver {
        name: "8 internal iterations for 1",
        set: |p| p.num_internal_pgs_iterations = 8,
    },
    Solver {
        name: "joints warm-started",
        set: |p| p.warmstart_joints = true,
    },
    Solver {
        name: "friction in the bias pass, too",
        set: |p| p.friction_in_bias_pass = true,
    },
];

struct Run<'a> {
    solver: &'a Solver,
    body: &'a Body,
    brep: &'a BrepShape,
    radius: f64,
    steps: usize,
    /// Revolutions a second that the motor holds.
    speed: f64,
    /// Most torque of the motor, N mm.
    most: f64,
    /// It ends after so much time on the clock, s.
    seconds: f64,
}

fn simulate(run: &Run<'_>) -> Track {
    let mut w = world(GRAVITY, UNIT, STEP, run.body);
    (run.solver.set)(&mut w.integration_parameters);
    let dt = w.integration_parameters.dt;
    let iterations = w.integration_parameters.num_solver_iterations as f64;
    let ground = w.insert_body(RigidBodyBuilder::fixed());
    let inertia = Vector::splat(INERTIA);
    let mass = MassProperties::new(Vector::ZERO, MASS, inertia);
    let part = RigidBodyBuilder::dynamic()
        .additional_mass_properties(mass)
        .can_sleep(false);
    let part = w.insert_body(part);
    let collider = ColliderBuilder::new(run.body.shape.clone());
    let collider = collider.density(0.0).friction(FRICTION);
    let hole = w.insert_collider(collider, Some(part));
    let low = Vector::new(0.0, 0.0, -(HOLE - run.radius).max(0.0));
    let ball = RigidBodyBuilder::dynamic()
        .translation(low)
        .lock_rotations()
        .linear_damping(BALL_DAMPING)
        .can_sleep(false);
    let ball = w.insert_body(ball);
    let collider = ColliderBuilder::ball(run.radius)
        .mass(MASS)
        .friction(FRICTION);
    let ball_collider = w.insert_collider(collider, Some(ball));
    let joint = RevoluteJointBuilder::new(Vector::X)
        .motor_velocity(TAU * run.speed, GAIN)
        .motor_max_force(run.most / NEWTON_MM);
    let joint = w.insert_impulse_joint(ground, part, joint);
    let dispatcher = BrepDispatcher::new().chain(DefaultQueryDispatcher);
    let other = parry3d_f64::shape::Ball::new(run.radius);
    let mut track = Track::default();
    let mut manifolds: Vec<parry3d_f64::query::ContactManifold<(), ()>> = Vec::new();
    let mut memory = None;
    let begun = Instant::now();
    for k in 0..run.steps {
        let start = Instant::now();
        w.step();
        track.step_us.push(start.elapsed().as_secs_f64() * 1e6);
        // The update of the contacts alone, as the engine asks for it.
        let (pose, at) = (*w.bodies[part].position(), *w.bodies[ball].position());
        let pos12 = pose.inv_mul(&at);
        let reach = w.integration_parameters.prediction_distance();
        let start = Instant::now();
        let shape = &*run.body.shape;
        let _ =
            dispatcher.contact_manifolds(&pos12, shape, &other, reach, &mut manifolds, &mut memory);
        track.update_us.push(start.elapsed().as_secs_f64() * 1e6);
        let gap = ball_gap(run.brep, &pose, at.translation, run.radius);
        let pair = w.contact_pair(hole, ball_collider);
        let deepest = pair.and_then(|p| p.find_deepest_contact());
        // The impulse of the last of the substeps.
        let motor = w
            .impulse_joints
            .get(joint)
            .map(|j| j.data.motors[JointAxis::AngX as usize].impulse);
        track.time.push((k + 1) as f64 * dt);
        track.depth.push(deepest.map_or(f64::NAN, |(_, c)| -c.dist));
        track.gap.push(gap.value);
        track.width.push(gap.bounds.width());
        track
            .torque
            .push(motor.unwrap_or(f64::NAN).abs() * iterations / dt * NEWTON_MM);
        track.speed.push(w.bodies[part].angvel().x / TAU);
        if begun.elapsed().as_secs_f64() > run.seconds {
            track.cut_short = true;
            break;
        }
    }
    track
}

/// The last part of a run, what is not a number left out.
fn even(values: &[f64]) -> Vec<f64> {
    let from = (values.len() as f64 * EVEN) as usize;
    values[from..]
        .iter()
        .copied()
        .filter(|v| v.is_finite())
        .collect()
}

/// How many steps a run has that was cut short.
fn cut_short(t: &Track) -> String {
    match t.cut_short {
        true => format!(" ({} steps)", t.time.len()),
        false => String::new(),
    }
}

fn row(body: &Body, radius: f64, t: &Track, analytic: f64) -> Vec<String> {
    let [depth, depth_noise] = spread(&even(&t.depth));
    let [gap, _] = spread(&even(&t.gap));
    let [torque, noise] = spread(&even(&t.torque));
    let width = even(&t.width).into_iter().fold(0.0, f64::max);
    let triangles = body.triangles.map_or("-".to_owned(), |n| n.to_string());
    vec![
        format!("{radius}"),
        body.name.clone() + &cut_short(t),
        triangles,
        short(median(&t.update_us)),
        short(median(&t.step_us)),
        format!("{} ± {}", short(depth), short(depth_noise)),
        format!("{} ({width:.0e})", short(-gap)),
        format!("{} ± {}", short(torque), short(noise)),
        format!("{:+.2} %", 100.0 * (torque / analytic - 1.0)),
        short(median(&even(&t.speed))),
    ]
}

pub(super) fn run(
    models: &Path,
    extent: Extent,
    progress: &mut dyn FnMut(&str),
) -> Result<Finding, String> {
    let brep = part(models, "ball_joint_cavity_nurbs.3dm")?;
    let (own, shape) = brep_body(brep.clone())?;
    let (degrees, steps, seconds): (&[f64], usize, f64) = match extent {
        Extent::Quick => (&[180.0, 30.0], 3000, SECONDS[0]),
        Extent::Whole => (&[180.0, 10.0, 1.0], 10_000, SECONDS[1]),
        Extent::Finest => (&[180.0, 10.0, 1.0, 0.1], 10_000, SECONDS[1]),
    };
    let mut bodies = vec![own];
    for d in degrees {
        bodies.push(mesh_body(&brep, *d, Edges::Fixed { turned: false })?);
    }
    let analytic = MASS * GRAVITY * HOLE * FRICTION.atan().sin() * NEWTON_MM;
    let mut rows = Vec::new();
    let mut finding = Finding::default();
    for radius in BALLS {
        let mut depth = Vec::new();
        let mut torque = Vec::new();
        for body in &bodies {
            progress(&format!("ball of {radius} mm, {}", body.name));
            let run = Run {
                solver: &USUAL,
                body,
                brep: &shape,
                radius,
                steps,
                speed: SPEED,
                most: 1e9,
                seconds,
            };
            let t = simulate(&run);
            rows.push(row(body, radius, &t, analytic));
            // Logarithmic: what is not above 0, a ball that is apart or a motor that rests, has no place in it.
            let line = |values: &[f64]| {
                let points = t.time.iter().copied().zip(values.iter().copied());
                Line {
                    name: body.name.clone(),
                    points: points.filter(|p| p.1 > LEAST).collect(),
                    marks: Marks::None,
                }
            };
            depth.push(line(&t.depth));
            torque.push(line(&t.torque));
        }
        let last = steps as f64 * STEP;
        torque.push(Line {
            name: "closed form (sliding)".to_owned(),
            points: vec![(0.0, analytic), (last, analytic)],
            marks: Marks::None,
        });
        for (what, y, lines) in [
            ("depth", "engine's depth, mm", depth),
            ("torque", "torque of the motor, N mm", torque),
        ] {
            let plot = Plot {
                title: format!(
                    "Ball of {radius} mm in the hole of 2.5 mm, {SPEED} revolutions a second"
                ),
                x: "time, s".to_owned(),
                y: y.to_owned(),
                lines,
                log: [false, true],
            };
            finding
                .plots
                .push((format!("ball-joint-{what}-{radius}.svg"), plot.svg()));
        }
    }
    let mut limited = Vec::new();
    let mut reached = Vec::new();
    for share in [0.98, 1.02] {
        progress(&format!(
            "ball of 2.472 mm, torque limited to {share} of what is needed"
        ));
        let run = Run {
            solver: &USUAL,
            body: &bodies[0],
            brep: &shape,
            radius: BALLS[0],
            steps,
            speed: SPEED,
            most: share * analytic,
            seconds,
        };
        let t = simulate(&run);
        reached.push((share, t.speed.last().copied().unwrap_or(f64::NAN)));
        limited.push(Line {
            name: format!("{share} of m g R sin(atan mu)"),
            points: t.time.into_iter().zip(t.speed).collect(),
            marks: Marks::None,
        });
    }
    let plot = Plot {
        title: "BREP, ball of 2.472 mm, torque limited".to_owned(),
        x: "time, s".to_owned(),
        y: "revolutions a second".to_owned(),
        lines: limited,
        log: [false; 2],
    };
    finding
        .plots
        .push(("ball-joint-limited.svg".to_owned(), plot.svg()));
    // As far up the wall as friction bears: where each ball slides in the closed form.
    let (sin, cos) = FRICTION.atan().sin_cos();
    let slides = |radius: f64| {
        let off = (HOLE - radius).max(0.0);
        let name = format!("ball of {radius} mm where it slides");
        ball_query(&name, [0.0, off * sin, -off * cos], radius, SHOWN)
    };
    finding.scenes.push(Scene {
        name: "ball-joint".to_owned(),
        queries: BALLS.map(slides).to_vec(),
        brep,
    });
    finding.page = page(&rows, analytic, steps, &reached, &finding.plots);
    if extent != Extent::Quick {
        finding.page += &faster(&bodies, &shape, steps, analytic, progress);
    }
    finding.page += &creeps(&bodies, &shape, steps, analytic, progress);
    Ok(finding)
}

/// The same at the thesis's other speed.
fn faster(
    bodies: &[Body],
    brep: &BrepShape,
    steps: usize,
    analytic: f64,
    progress: &mut dyn FnMut(&str),
) -> String {
    let mut rows = Vec::new();
    for radius in BALLS {
        for body in &bodies[..bodies.len().min(COARSE)] {
            progress(&format!(
                "{FASTER} revolutions a second, ball of {radius} mm, {}",
                body.name
            ));
            let t = simulate(&Run {
                solver: &USUAL,
                body,
                brep,
                radius,
                steps,
                speed: FASTER,
                most: 1e9,
                seconds: SECONDS[0],
            });
            rows.push(row(body, radius, &t, analytic));
        }
    }
    format!(
        "## At {FASTER} revolutions a second\n\n\
        The closed form knows no speed: the torque should be the same.\n\n{}\n",
        table(&HEAD, &rows)
    )
}

/// How fast the depth grows over the last part of a run, mm/s: of the line from its first to its last value.
fn creep(t: &Track) -> f64 {
    let from = (t.time.len() as f64 * EVEN) as usize;
    let last = t.time.len() - 1;
    (t.depth[last] - t.depth[from]) / (t.time[last] - t.time[from])
}

/// What the growth of the depth hangs on.
fn creeps(
    bodies: &[Body],
    brep: &BrepShape,
    steps: usize,
    analytic: f64,
    progress: &mut dyn FnMut(&str),
) -> String {
    let mut rows = Vec::new();
    for solver in &SOLVERS {
        for body in &bodies[..bodies.len().min(COARSE)] {
            progress(&format!(
                "growth of the depth, {}, {}",
                solver.name, body.name
            ));
            let t = simulate(&Run {
                solver,
                body,
                brep,
                radius: BALLS[0],
                steps,
                speed: SPEED,
                most: 1e9,
                seconds: SECONDS[0],
            });
            let [torque, noise] = spread(&even(&t.torque));
            rows.push(vec![
                solver.name.to_owned(),
                body.name.clone() + &cut_short(&t),
                short(creep(&t)),
                short(t.depth.last().copied().unwrap_or(f64::NAN)),
                format!("{} ± {}", short(torque), short(noise)),
                format!("{:+.2} %", 100.0 * (torque / analytic - 1.0)),
            ]);
        }
    }
    let head = [
        "solver",
        "shape of the hole",
        "growth of the depth mm/s",
        "depth at the end mm",
        "torque N mm",
        "torque off the closed form",
    ];
    format!(
        "## What the growth of the depth hangs on\n\n\
        The depth grows as long as the part turns, on meshes as on the BREP. The same run (ball of {} mm) with one setting of the engine's solver changed at a time; the growth is that of the engine's depth over the \
        second half.\n\n{}\n\
        It is the engine's limit of the velocity with which it pushes overlapping bodies apart, 3 length units a second, here {} mm/s: without it the depth on the BREP settles, and nothing else but stiffer \
        contacts or more substeps (which bring the depth down) slows it by much. The experiment keeps Rapier's limit: without it a ball on a coarse mesh, which overlaps by the chords' height from the start, is flung \
        about.\n",
        BALLS[0],
        table(&head, &rows),
        short(IntegrationParameters::default().normalized_max_corrective_velocity * UNIT)
    )
}

/// BREP and coarse meshes: the fine ones take their time, and tell the same.
const COARSE: usize = 3;

const HEAD: [&str; 10] = [
    "ball mm",
    "shape of the hole",
    "triangles",
    "contact update us",
    "whole step us",
    "engine's depth mm",
    "depth at the poses mm (width of its enclosure)",
    "torque N mm",
    "torque off the closed form",
    "revolutions a second",
];

fn page(
    rows: &[Vec<String>],
    analytic: f64,
    steps: usize,
    reached: &[(f64, f64)],
    plots: &[(String, String)],
) -> String {
    let mut page = format!(
        "# Spherical ball joint\n\n\
        A part with a hole of radius {HOLE} mm (a NURBS) is turned about a level axis by a motor at {SPEED} revolutions a second; in the \
        hole a ball of {MASS} kg that does not turn, friction {FRICTION}. {steps} steps of {STEP} s in Rapier 0.36 (f64), of which the \
        second half counts. Contact recycling is off, contact softness {HERTZ} Hz with a damping ratio of {DAMPING}, slop {:.0e} mm, prediction \
        {:.0e} mm; for meshes Rapier's remedies are on: clustering of contacts, and normals at inner edges fixed. \
        The part's inertia is {INERTIA} kg mm^2, the ball's damping {BALL_DAMPING} /s, so that its swing dies away.\n\n",
        1e-6 * UNIT,
        0.02 * UNIT
    );
    page += &table(&HEAD, rows);
    let _ = write!(
        page,
        "\nClosed form for a ball that fits: m g R sin(atan mu) = {analytic:.4} N mm, whatever its radius below {HOLE}. \
        The times are medians of one run on a machine that did other work, too. *Depth at the poses* is certified, from the BREP, for \
        meshes as well: what the ball really overlaps; *engine's depth* is what the shape in use reports to the solver.\n\n\
        A ball of 2.5 mm is as large as the hole, one of 2.51 mm is too large: a real one would be jammed. On the BREP the engine gets the \
        deepest contact, and several only where the ball is in the very middle, so that it treats either as one that fits, deeper by what it \
        is too large. On a mesh it gets contacts all around, and the torque is what it takes to drag the ball through them.\n\n\
        Where a run was cut short for its time the number of steps is given; the last numbers of such a run are those of its start. A depth at \
        the poses that is the same on the BREP and on a coarse mesh is the solver's.\n\n\
        The thesis gives 70 to 630 ms for one update of its BREP. Its torques and depths are not part of this repository, so that they \
        do not stand beside ours.\n\n"
    );
    for (share, speed) in reached {
        let _ = writeln!(
            page,
            "- Torque limited to {share} of the closed form: {speed:.3} revolutions a second at the end."
        );
    }
    page.push('\n');
    for (name, _) in plots {
        let _ = writeln!(page, "![{name}]({name})\n");
    }
    page += "[The part with the balls where they slide](ball-joint.html)\n\n";
    page
}
