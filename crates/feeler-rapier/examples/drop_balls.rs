//! A five-minute guide: a .3dm part in Rapier, balls dropped on it, and the contacts.
//!
//! ```sh
//! cargo run --release -p feeler-rapier --example drop_balls -- corpora/models/thesis/ball_joint_socket.3dm
//! ```

use feeler::prepare::PreparedBrep;
use feeler_io::{ObjectKind, read_file};
use feeler_rapier::{BrepDispatcher, BrepShape, ball_gap};
use parry3d_f64::query::{DefaultQueryDispatcher, QueryDispatcher};
use rapier3d_f64::prelude::*;
use std::error::Error;
use std::sync::Arc;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "corpora/models/thesis/ball_joint_socket.3dm".to_owned());

    // 1. The part. Nothing is scaled: lengths are the file's, here mm.
    let document = read_file(&path)?;
    let brep = document
        .objects
        .into_iter()
        .find_map(|object| match object.kind {
            ObjectKind::Brep(brep) => Some(brep),
            _ => None,
        })
        .ok_or("there is no BREP in the file")?;
    let part = BrepShape::new(Arc::new(PreparedBrep::new(brep)))?;
    let aabb = part.compute_local_aabb();
    println!(
        "{path}: from {:.3} to {:.3} {}",
        aabb.mins, aabb.maxs, document.units
    );
    let mass = part.mass();
    println!(
        "volume {:.6}, relative error seen {:.0e}",
        mass.volume, mass.error
    );

    // 2. The world: our dispatcher before Parry's, which answers for all other pairs.
    let dispatcher = BrepDispatcher::new();
    let mut world = PhysicsWorld::new();
    world
        .narrow_phase
        .set_query_dispatcher(dispatcher.clone().chain(DefaultQueryDispatcher));
    world.gravity = Vector::new(0.0, 0.0, -9810.0); // mm/s^2
    let radius = 0.05 * aabb.half_extents().max_element();
    let settings = &mut world.integration_parameters;
    settings.length_unit = 2.0 * radius; // slop and prediction go by it
    settings.dt = 1e-3;
    // A resting ball sinks in by about g / (2 pi f)^2: 0.07 mm at Rapier's 60 Hz, 0.25 um at 1000.
    settings.contact_softness.natural_frequency = 1000.0;
    settings.static_contact_softness.natural_frequency = 1000.0;
    settings.contact_recycling = false; // else curved faces get facets: see the crate's documentation
    settings.contact_clustering = false; // else normals up to 5 degrees apart become one

    // 3. The part stands still, balls fall on it.
    let body = world.insert_body(RigidBodyBuilder::fixed());
    let collider = ColliderBuilder::new(SharedShape::new(part.clone())).friction(0.5);
    let part_collider = world.insert_collider(collider, Some(body));
    let mut balls = Vec::new();
    for k in 0..5 {
        let off = f64::from(k - 2) * 2.5 * radius;
        let at = aabb.center() + Vector::new(off, 0.3 * off, 0.0);
        let top = Vector::new(at.x, at.y, aabb.maxs.z + 2.0 * radius);
        let body = world.insert_body(RigidBodyBuilder::dynamic().translation(top));
        let ball = ColliderBuilder::ball(radius).friction(0.5);
        balls.push((body, world.insert_collider(ball, Some(body))));
    }

    // 4. Contacts after each tenth of a second; the engine's gap, and the certified one at the poses.
    for step in 1..=300 {
        world.step();
        if step % 100 != 0 {
            continue;
        }
        println!(
            "t = {:.1} s",
            f64::from(step) * world.integration_parameters.dt
        );
        for (k, (body, ball)) in balls.iter().enumerate() {
            let at = world.bodies[*body].translation();
            let gap = ball_gap(&part, &Pose::IDENTITY, at, radius);
            let (lo, hi) = (gap.bounds.lo, gap.bounds.hi);
            println!("  ball {k} at {at:.4}: gap in [{lo:.12e}, {hi:.12e}]");
            let Some(pair) = world.contact_pair(part_collider, *ball) else {
                continue;
            };
            for manifold in pair.manifolds() {
                for point in &manifold.points {
                    let normal = manifold.data.normal;
                    println!(
                        "    contact {:?}: engine's gap {:+.3e}, normal {normal:.4}, impulse {:.3e}",
                        point.fid1.unpack(),
                        point.dist,
                        point.data.impulse
                    );
                }
            }
        }
    }
    for pair in dispatcher.unsupported() {
        println!(
            "unsupported: {} with {}, {} times",
            pair.query, pair.other, pair.count
        );
    }
    println!("answers that fell short: {}", part.undecided());
    Ok(())
}
