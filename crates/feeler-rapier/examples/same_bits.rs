//! Whether a run has the same bits whatever the number of threads: prints a hash of all places and velocities of all its steps.
//!
//! ```sh
//! cargo run --release -p feeler-rapier --example same_bits
//! RAYON_NUM_THREADS=1 cargo run --release -p feeler-rapier --example same_bits --features parallel
//! RAYON_NUM_THREADS=4 cargo run --release -p feeler-rapier --example same_bits --features parallel
//! ```

use feeler::prepare::PreparedBrep;
use feeler_io::{ObjectKind, read_file};
use feeler_rapier::{BrepDispatcher, BrepShape};
use parry3d_f64::query::{DefaultQueryDispatcher, QueryDispatcher};
use rapier3d_f64::prelude::*;
use std::error::Error;
use std::sync::Arc;

/// mm, s.
const RADIUS: f64 = 0.3;
const STEP: f64 = 5e-4;
const STEPS: usize = 400;

fn main() -> Result<(), Box<dyn Error>> {
    let run = run(STEPS)?;
    let kind = if cfg!(feature = "parallel") {
        "parallel"
    } else {
        "serial"
    };
    let threads = std::env::var("RAYON_NUM_THREADS").unwrap_or_else(|_| "any".to_owned());
    println!(
        "{kind}, {threads} threads: {:016x} ({STEPS} steps, {} pairs, undecided {})",
        run.hash, run.pairs, run.undecided
    );
    Ok(())
}

/// What is left of a run.
#[derive(Debug, PartialEq)]
pub(crate) struct Run {
    /// Of all places and velocities of all steps.
    pub(crate) hash: u64,
    /// Pairs that were near each other, over all steps.
    pub(crate) pairs: usize,
    pub(crate) undecided: u64,
}

/// Bodies that fall into the thesis's socket.
pub(crate) fn run(steps: usize) -> Result<Run, Box<dyn Error>> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../corpora/models/thesis/ball_joint_cavity_nurbs.3dm"
    );
    let objects = read_file(path)?.objects.into_iter();
    let brep = objects.into_iter().find_map(|object| match object.kind {
        ObjectKind::Brep(brep) => Some(brep),
        _ => None,
    });
    let part = BrepShape::new(Arc::new(PreparedBrep::new(brep.ok_or("no BREP")?)))?;
    let mut world = PhysicsWorld::new();
    world
        .narrow_phase
        .set_query_dispatcher(BrepDispatcher::new().chain(DefaultQueryDispatcher));
    world.gravity = Vector::new(0.0, 0.0, -9810.0);
    let settings = &mut world.integration_parameters;
    (settings.length_unit, settings.dt) = (2.0 * RADIUS, STEP);
    (settings.contact_recycling, settings.contact_clustering) = (false, false);
    let ground = world.insert_body(RigidBodyBuilder::fixed());
    let socket = ColliderBuilder::new(SharedShape::new(part.clone()));
    world.insert_collider(socket.friction(0.3), Some(ground));
    // Balls, boxes, cylinders and pairs of balls fall into the hole of radius 2.5 about the origin, and onto each other.
    let mut bodies = Vec::new();
    for k in 0..64 {
        let [x, y, z] = [k % 4, k / 4 % 4, k / 16].map(|c| f64::from(c) - 1.5);
        let body = RigidBodyBuilder::dynamic().translation(Vector::new(x, y, z) * 0.7);
        let body = world.insert_body(body);
        let shape = match k % 4 {
            0 | 1 => SharedShape::ball(RADIUS),
            2 => SharedShape::cuboid(0.2, 0.15, 0.25),
            _ if k % 8 == 3 => SharedShape::cylinder(0.2, 0.2),
            _ => SharedShape::compound(vec![
                (Pose::translation(-0.1, 0.0, 0.0), SharedShape::ball(0.2)),
                (Pose::translation(0.1, 0.0, 0.0), SharedShape::ball(0.2)),
            ]),
        };
        world.insert_collider(ColliderBuilder::new(shape).friction(0.3), Some(body));
        bodies.push(body);
    }
    // FNV-1a.
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    let mut touching = 0;
    for _ in 0..steps {
        world.step();
        touching += world.narrow_phase.contact_pairs().count();
        for body in &bodies {
            let body = &world.bodies[*body];
            let (at, turn) = (body.translation(), body.rotation());
            let (way, spin) = (body.linvel(), body.angvel());
            let vectors = [at, way, spin].into_iter().flat_map(|v| v.to_array());
            for x in vectors.chain([turn.x, turn.y, turn.z, turn.w]) {
                for byte in x.to_bits().to_le_bytes() {
                    hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
                }
            }
        }
    }
    Ok(Run {
        hash,
        pairs: touching,
        undecided: part.undecided(),
    })
}
