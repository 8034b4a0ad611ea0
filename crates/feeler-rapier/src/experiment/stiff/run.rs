//! One run, and what is measured in it.

use super::motion::{Law, State, Tally, energy, step};
use super::scene::Scene;
use super::wall::{Closed, Wall};
use super::{GRAVITY, MASS};
use ::nalgebra::{Point3, Vector3};
use std::time::Instant;

/// s between samples of the path: a multiple of every step.
const SAMPLE: f64 = 1e-3;
/// A run is cut short after this, s.
const SECONDS: f64 = 10.0;
/// Steps in which the push forms: their normals and pushes are not counted.
const FORMING: usize = 3;
/// Points of a run's push that are drawn.
const DRAWN: usize = 400;
/// Newton steps that set the ball to its depth at the start.
const SETTING: usize = 20;

pub(super) struct Run<'a> {
    pub(super) scene: &'a Scene,
    /// N/m.
    pub(super) stiffness: f64,
    /// s.
    pub(super) step: f64,
    /// Centres at the samples.
    pub(super) reference: Option<&'a [Point3<f64>]>,
}

/// What was measured.
#[derive(Default)]
pub(super) struct Found {
    /// Centres at the samples, mm.
    pub(super) path: Vec<Point3<f64>>,
    /// Largest distance from the reference at a sample, mm.
    pub(super) off: f64,
    /// Largest change of the energy, of the scene's.
    pub(super) drift: f64,
    /// Stiffness times error of the depth at the samples, of m g: median.
    pub(super) noise: f64,
    /// Push less the closed form's, of m g: median and largest.
    pub(super) push: [f64; 2],
    /// Largest turn of the normal in a step beyond that of the way, radians.
    pub(super) jump: f64,
    /// Time and push over m g.
    pub(super) pushes: Vec<(f64, f64)>,
    /// Of the steps alone.
    pub(super) seconds: f64,
    pub(super) tally: Tally,
    /// Simulated time, if it was cut short.
    pub(super) cut: Option<f64>,
}

/// What the wall pushes with in the closed form, from place and energy.
fn closed_push(truth: &mut Closed, law: &Law, at: &Point3<f64>, energy: f64) -> f64 {
    let normal = truth.near(at).normal;
    // Kinetic energy is m v^2 / 2, or 7/5 of it.
    let part = if law.rolls { 1.4 } else { 1.0 };
    let square = 2.0 * (energy / MASS + law.gravity.dot(&at.coords)) / part;
    MASS * (square.max(0.0) * truth.bend(at) - law.gravity.dot(&normal))
}

/// The ball at rest in the wall's surface, as deep as the push at the start makes it.
fn begin(wall: &mut dyn Wall, run: &Run<'_>, law: &Law) -> State {
    let scene = run.scene;
    let mut truth = scene.truth;
    let speed = scene.velocity.norm_squared();
    let normal = truth.near(&scene.at).normal;
    let push = MASS * (speed * truth.bend(&scene.at) - law.gravity.dot(&normal));
    let mut at = scene.at;
    for _ in 0..SETTING {
        let near = wall.near(&at);
        at += near.normal * (near.depth - push / run.stiffness);
    }
    State {
        at,
        velocity: scene.velocity,
        spin: Vector3::zeros(),
        push,
        grip: Vector3::zeros(),
        normal: wall.near(&at).normal,
    }
}

pub(super) fn simulate(wall: &mut dyn Wall, run: &Run<'_>) -> Found {
    let law = Law {
        stiffness: run.stiffness,
        rolls: run.scene.rolls,
        gravity: run.scene.down * GRAVITY,
    };
    let mut truth = run.scene.truth;
    let weight = MASS * GRAVITY;
    let mut s = begin(wall, run, &law);
    let mut found = Found {
        path: vec![s.at],
        ..Found::default()
    };
    let start = energy(wall, &law, &s);
    let samples = (run.scene.time / SAMPLE).round() as usize;
    let each = (SAMPLE / run.step).round() as usize;
    let every = (samples * each).div_ceil(DRAWN);
    let (mut noises, mut pushes) = (Vec::new(), Vec::new());
    for sample in 1..=samples {
        for k in 0..each {
            let begun = Instant::now();
            let next = step(wall, &law, &s, run.step, &mut found.tally);
            found.seconds += begun.elapsed().as_secs_f64();
            if found.tally.steps > FORMING {
                let angle = (next.normal.cross(&s.normal).norm()).atan2(next.normal.dot(&s.normal));
                let turn = (next.at - s.at).norm() * truth.bend(&next.at);
                found.jump = found.jump.max(angle - turn);
                let closed = closed_push(&mut truth, &law, &next.at, start);
                pushes.push((next.push - closed).abs() / weight);
            }
            s = next;
            if ((sample - 1) * each + k).is_multiple_of(every) {
                let time = found.tally.steps as f64 * run.step;
                found.pushes.push((time, s.push / weight));
            }
        }
        found.path.push(s.at);
        let change = (energy(wall, &law, &s) - start).abs() / run.scene.energy;
        found.drift = found.drift.max(change);
        let error = wall.near(&s.at).depth - truth.near(&s.at).depth;
        noises.push(run.stiffness * error.abs() / weight);
        if let Some(reference) = run.reference {
            found.off = found.off.max((s.at - reference[sample]).norm());
        }
        if found.seconds > SECONDS {
            found.cut = Some(sample as f64 * SAMPLE);
            break;
        }
    }
    found.noise = super::super::median(&noises);
    found.push = [
        super::super::median(&pushes),
        pushes.iter().copied().fold(0.0, f64::max),
    ];
    found
}
