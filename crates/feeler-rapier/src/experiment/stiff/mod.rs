//! Stiff: a ball slides and rolls in a spherical socket and over seams under penalty contact, far stiffer than its steps resolve.
//!
//! # Closed forms
//! The energy is constant. A ball that swings in the socket of radius R is a pendulum of length L = R - r, up to the elastic
//! depth m g / k; where it rolls its mass counts 7/5 along the way. The wall pushes with `m (-g.n + v^2 b)`, b the curvature of the way of
//! the ball's centre. The way over time is held against the same motion on the closed form of the wall in steps of 1e-6 s, whose own
//! error is that of twice these steps. A test holds that against the pendulum's period (Gauss's mean).

mod motion;
mod page;
mod run;
mod scene;
#[cfg(test)]
mod tests;
mod wall;

pub(super) use motion::{Law, State, Tally, step};
pub(super) use wall::{BrepWall, Wall};

use super::{Extent, Finding, drawn};
use page::Results;
use run::{Found, Run, simulate};
use scene::{Case, Scene, seam, socket};
use std::path::Path;

/// mm.
const HOLE: f64 = 2.5;
/// mm.
pub(super) const BALL: f64 = 2.0;
/// kg: of steel, as good as.
pub(super) const MASS: f64 = 2.5e-4;
/// mm/s^2.
pub(super) const GRAVITY: f64 = 9810.0;
/// Of the step of the reference.
const REFERENCE: f64 = 1e-6;

/// What is run.
struct Grid {
    stiffnesses: Vec<f64>,
    /// s, the longest first.
    steps: Vec<f64>,
    /// Of the tables and plots over the stiffness.
    usual: f64,
    /// Of the reference.
    reference: f64,
    /// Angles of meshes, degrees.
    meshes: Vec<f64>,
    /// Of the socket: all walls, or the NURBS at full accuracy and meshes.
    all: bool,
}

fn grid(extent: Extent) -> Grid {
    match extent {
        Extent::Quick => Grid {
            stiffnesses: vec![1e4, 1e12],
            steps: vec![1e-3, 1e-4],
            usual: 1e-4,
            reference: 10.0 * REFERENCE,
            meshes: vec![10.0],
            all: false,
        },
        Extent::Whole | Extent::Finest => Grid {
            stiffnesses: vec![1e2, 1e4, 1e6, 1e8, 1e10, 1e12],
            steps: vec![1e-3, 1e-4, 1e-5, 1e-6],
            usual: 1e-5,
            reference: REFERENCE,
            meshes: vec![10.0, 1.0],
            all: true,
        },
    }
}

/// The closed form in short steps, and how far it is from itself in steps twice as long.
fn reference(scene: &Scene, stiffness: f64, step: f64) -> (Found, f64) {
    let run = |step: f64, path: Option<&Found>| {
        let mut wall = scene.truth;
        simulate(
            &mut wall,
            &Run {
                scene,
                stiffness,
                step,
                reference: path.map(|f| &f.path[..]),
            },
        )
    };
    let fine = run(step, None);
    let error = run(2.0 * step, Some(&fine)).off;
    (fine, error)
}

/// All walls at some stiffnesses and steps.
fn all(
    scene: &Scene,
    cases: &mut [Case],
    stiffnesses: &[f64],
    steps: &[f64],
    grid: &Grid,
    progress: &mut dyn FnMut(&str),
) -> Results {
    let mut results = Results::new(scene.name, scene.loss);
    for k in stiffnesses {
        progress(&format!("{}, {k:.0e} N/m, reference", scene.name));
        let (fine, error) = reference(scene, *k, grid.reference);
        results.reference.push((*k, error));
        for case in &mut *cases {
            progress(&format!("{}, {k:.0e} N/m, {}", scene.name, case.name));
            for step in steps {
                let run = Run {
                    scene,
                    stiffness: *k,
                    step: *step,
                    reference: Some(&fine.path),
                };
                let wall: &mut dyn Wall = &mut *case.wall;
                let found = simulate(wall, &run);
                results.add(&case.name, *k, *step, found);
            }
        }
    }
    results
}

pub(super) fn run(
    models: &Path,
    extent: Extent,
    progress: &mut dyn FnMut(&str),
) -> Result<Finding, String> {
    let grid = grid(extent);
    let mut cases = socket::cases(models, &grid.meshes, grid.all)?;
    let slide = socket::scene(false);
    let slid = all(
        &slide,
        &mut cases,
        &grid.stiffnesses,
        &grid.steps,
        &grid,
        progress,
    );
    let few: Vec<f64> = grid
        .stiffnesses
        .iter()
        .copied()
        .filter(|k| [1e4, 1e8, 1e12].contains(k))
        .collect();
    let mut scenes = vec![drawn(
        "stiff-socket",
        socket::part(models)?,
        BALL,
        &slid.way(),
    )];
    let roll = socket::scene(true);
    let rolled = all(&roll, &mut cases, &few, &[grid.usual], &grid, progress);
    let mut seams = Vec::new();
    for power in [1, 2, 3] {
        let (scene, mut cases) = seam::scene_and_cases(power, &grid.meshes)?;
        let step = [grid.usual];
        let found = all(&scene, &mut cases, &few, &step, &grid, progress);
        let name = format!("stiff-{}", ["c0", "g1", "g2"][seams.len()]);
        scenes.push(drawn(&name, seam::sheet(power)?, BALL, &found.way()));
        seams.push(found);
    }
    let mut finding = page::page(&slid, &rolled, &seams, &grid);
    finding.scenes = scenes;
    Ok(finding)
}
