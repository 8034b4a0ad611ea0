//! Time per step at 1 to 1,000 balls against one BREP, beside a mesh of it and beside a plane.

use super::sheet::{SIDE, height, sheet, upward};
use super::world::{Body, DAMPING, Edges, HERTZ, brep_body, mesh_body, world};
use super::{Extent, Finding, drawn, median, short, table};
use rapier3d_f64::prelude::*;
use std::time::Instant;

/// Radius, mm: a thousand lie side by side on the sheet.
const BALL: f64 = 0.3;
/// Centres are this far apart.
const APART: f64 = 0.7;
/// mm/s^2.
const GRAVITY: f64 = 9810.0;
/// s.
const STEP: f64 = 2e-4;
/// Steps before the clock is read, and steps that count.
const WARM: usize = 10;

/// Median time of a step, us, balls that touch the ground at the end, and the deepest overlap with it, mm.
struct Found {
    step_us: f64,
    touching: usize,
    deepest: f64,
    /// Centres at the end.
    places: Vec<[f64; 3]>,
}

fn simulate(body: &Body, count: usize, steps: usize, flat: bool) -> Found {
    let mut w = world(GRAVITY, BALL, STEP, body);
    let ground = w.insert_body(RigidBodyBuilder::fixed());
    let collider = ColliderBuilder::new(body.shape.clone()).friction(0.3);
    let ground = w.insert_collider(collider, Some(ground));
    // From the middle outwards, on a grid.
    let side = (2.0 * (SIDE - APART) / APART) as i32;
    let mut places: Vec<[f64; 2]> = (0..side * side)
        .map(|k| [k / side, k % side].map(|c| (f64::from(c) - 0.5 * f64::from(side - 1)) * APART))
        .collect();
    places.sort_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])));
    let balls: Vec<_> = places[..count]
        .iter()
        .map(|[x, y]| {
            let (z, up) = match flat {
                true => (0.0, [0.0, 0.0, 1.0]),
                false => (height(*x, *y), upward(*x, *y).into()),
            };
            // In touch: where the sheet is steep, a ball as high above its place would stand 0.1 mm deep in it.
            let at = Vector::new(*x, *y, z) + Vector::from_array(up) * BALL;
            let own = RigidBodyBuilder::dynamic().translation(at).can_sleep(false);
            let own = w.insert_body(own);
            let collider = ColliderBuilder::ball(BALL).mass(1e-6).friction(0.3);
            w.insert_collider(collider, Some(own))
        })
        .collect();
    let mut times = Vec::new();
    for k in 0..WARM + steps {
        let begun = Instant::now();
        w.step();
        if k >= WARM {
            times.push(begun.elapsed().as_secs_f64() * 1e6);
        }
    }
    let depths: Vec<f64> = balls
        .iter()
        .filter_map(|b| w.contact_pair(ground, *b)?.find_deepest_contact())
        .map(|(_, c)| -c.dist)
        .collect();
    let center = |b: &ColliderHandle| w.colliders[*b].translation().to_array();
    Found {
        places: balls.iter().map(center).collect(),
        step_us: median(&times),
        touching: depths.iter().filter(|d| **d >= 0.0).count(),
        deepest: depths.into_iter().fold(f64::NEG_INFINITY, f64::max),
    }
}

pub(super) fn run(extent: Extent, progress: &mut dyn FnMut(&str)) -> Result<Finding, String> {
    let brep = sheet(&[[-SIDE, 0.0], [0.0, SIDE]])?;
    let (counts, degrees, steps): (&[usize], &[f64], usize) = match extent {
        Extent::Quick => (&[1, 10], &[6.0], 20),
        Extent::Whole | Extent::Finest => (&[1, 10, 100, 1000], &[6.0, 0.6, 0.06], 100),
    };
    let mut bodies = vec![brep_body(brep.clone())?.0];
    for d in degrees {
        bodies.push(mesh_body(&brep, *d, Edges::Plain)?);
    }
    let plane = Body {
        name: "plane (Parry's half-space)".to_owned(),
        shape: SharedShape::halfspace(Vector::Z),
        triangles: None,
    };
    bodies.push(plane);
    let (mut rows, mut scenes) = (Vec::new(), Vec::new());
    for (k, body) in bodies.iter().enumerate() {
        let flat = k + 1 == bodies.len();
        let mut row = vec![
            body.name.clone(),
            body.triangles.map_or("-".to_owned(), |n| n.to_string()),
        ];
        for count in counts {
            progress(&format!("{count} balls, {}", body.name));
            let found = simulate(body, *count, steps, flat);
            if k == 0 && counts.last() == Some(count) {
                scenes.push(drawn("balls", brep.clone(), BALL, &found.places));
            }
            row.push(format!(
                "{} ({} touch, {} mm)",
                short(found.step_us),
                found.touching,
                short(found.deepest)
            ));
        }
        rows.push(row);
    }
    let heads: Vec<String> = counts.iter().map(|n| format!("{n} balls, us")).collect();
    let mut head = vec!["ground", "triangles"];
    head.extend(heads.iter().map(String::as_str));
    let page = format!(
        "# Many balls against one BREP\n\n\
        Balls of radius {BALL} mm, {APART} mm apart, let go on the bicubic sheet of `simulate rolling` (four faces), on meshes of it, and on a plane, which shows what the engine itself takes: Rapier 0.36 (f64), one thread, \
        steps of {STEP} s, the median time of {steps} steps after the first {WARM}; contact recycling off, softness {HERTZ} Hz with a damping ratio of {DAMPING}. In brackets how many balls touch the ground at the \
        end, and the deepest overlap (on a plane 0.25 um by the softness). Times of one run on a machine that did other work, too: what counts are ratios within a column.\n\n{}",
        table(&head, &rows)
    );
    Ok(Finding {
        page,
        scenes,
        ..Finding::default()
    })
}
