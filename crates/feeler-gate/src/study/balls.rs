//! Table 1 of the thesis: balls in the spherical hole of the ball joint.
//!
//! The thesis let a motor turn the joint and gave the time of one update. Here the ball stands still in 64 places
//! around the hole's centre, each one update: what a physics engine asks of the shape in a step. The hole has a
//! radius of 2.5 mm (as NURBS up to 1e-15), so that the separation of a ball of radius r whose centre is e off the
//! hole's is 2.5 - e - r: the expectation needs no oracle.

use super::contender::Contender;
use super::measure::{Plan, accuracy};
use super::numbers::{Spread, quantile};
use crate::cases::load;
use feeler::query::{Contacts, Probe, Sphere};
use feeler_corpus::{Ask, Body, CorpusError, Hits, MODELS, Query};
use nalgebra::Point3;
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// Radius of the hole in mm.
const HOLE: f64 = 2.5;
/// Radii of the thesis's balls in mm, and how far off the centre they stand: touching, in the middle of a joint
/// that just fits, and pressed in.
pub const BALLS: [(f64, f64); 3] = [(2.472, 0.028), (2.5, 0.001), (2.51, 0.005)];
/// Places on the way around.
const PLACES: usize = 64;
/// How often the way is gone.
const ROUNDS: usize = 5;
/// The largest deviation of the NURBS hole from a sphere, and of places from the way, in mm.
const ROUNDING: f64 = 2e-15;

/// What one engine gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BallRow {
    /// The engine and its setting.
    pub engine: String,
    /// The part, native or as NURBS.
    pub model: String,
    /// Of the shape that it works with, where there is one: the BREP's file, or the mesh as binary STL.
    pub file_bytes: Option<u64>,
    /// Bytes held in memory.
    pub bytes: Option<usize>,
    /// Milliseconds to open the part and answer a first query, which prepares what it needs.
    pub open_milliseconds: f64,
    /// For each of [`BALLS`].
    pub balls: Vec<BallCell>,
    /// Why there is no answer, if so.
    pub error: Option<String>,
}

/// One engine and one ball.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BallCell {
    /// Radius in mm.
    pub radius: f64,
    /// Microseconds an update.
    pub microseconds: Spread,
    /// Error of the separation in mm; what is below the rounding of the hole counts as nothing.
    pub error: Spread,
    /// Places where an overlap deeper than the rounding was not reported.
    pub missed: usize,
}

/// A place of the way: a spiral from pole to pole.
fn place(k: usize, off: f64) -> Point3<f64> {
    let z = 1.0 - (2 * k + 1) as f64 / PLACES as f64;
    let ring = (1.0 - z * z).sqrt();
    // The angle between neighbours on a spiral of evenly spread points; its exact value does not matter.
    let angle = 2.4 * k as f64;
    Point3::new(off * ring * angle.cos(), off * ring * angle.sin(), off * z)
}

/// One row: an engine on the part.
///
/// # Errors
/// The part cannot be read.
pub(crate) fn row(
    contender: &mut Contender,
    corpus: &Path,
    model: &str,
    plan: &Plan,
) -> Result<BallRow, CorpusError> {
    let loaded = load(corpus, model)?;
    let start = Instant::now();
    let opened = contender.engine.open(&loaded.model);
    let ask = |radius: f64, center: Point3<f64>| Query {
        ask: Ask::Contact(Probe::Sphere(Sphere { center, radius })),
        id: None,
        prediction: None,
        contacts: Some(Contacts::Deepest),
        hits: Hits::All,
        accuracy: Some(accuracy(contender.accuracy, loaded.size)),
        overlap: false,
    };
    let (radius, off) = BALLS[0];
    if opened.is_ok() {
        contender.engine.answer(&ask(radius, place(0, off)));
    }
    let open_milliseconds = start.elapsed().as_secs_f64() * 1e3;
    let file = std::fs::metadata(corpus.join(MODELS).join(model));
    let mut row = BallRow {
        engine: format!("{} {}", contender.name, contender.setting),
        model: model.to_owned(),
        file_bytes: match contender.engine.triangles() {
            // A binary STL file has 84 bytes of header and 50 a triangle.
            Some(triangles) => Some(84 + 50 * triangles as u64),
            None => file.ok().map(|f| f.len()),
        },
        bytes: None,
        open_milliseconds,
        balls: Vec::new(),
        error: opened.err(),
    };
    if row.error.is_some() {
        return Ok(row);
    }
    for (radius, off) in BALLS {
        let mut errors = Vec::new();
        let mut missed = 0;
        let mut times = vec![Vec::new(); PLACES];
        let begun = Instant::now();
        for round in 0..ROUNDS {
            // The first is whole: errors are taken from it.
            if round > 0 && begun.elapsed().as_secs_f64() > plan.seconds {
                break;
            }
            for (k, times) in times.iter_mut().enumerate() {
                let center = place(k, off);
                let query = ask(radius, center);
                let start = Instant::now();
                let body = contender.engine.answer(&query).body;
                times.push(start.elapsed().as_secs_f64() * 1e6);
                if round > 0 {
                    continue;
                }
                let truth = HOLE - center.coords.norm() - radius;
                match body {
                    Body::Contact {
                        separation,
                        contacts,
                        ..
                    } => {
                        let error = (separation.value - truth).abs();
                        errors.push(if error <= ROUNDING { 0.0 } else { error });
                        missed += usize::from(truth < -ROUNDING && contacts.is_empty());
                    }
                    Body::Error { error } => row.error = Some(error),
                    _ => row.error = Some("an answer to another question".to_owned()),
                }
            }
        }
        let medians = times.iter_mut().filter_map(|t| {
            t.sort_by(f64::total_cmp);
            quantile(t, 0.5)
        });
        row.bytes = contender.engine.memory();
        row.balls.push(BallCell {
            radius,
            microseconds: Spread::of(medians).unwrap_or_default(),
            error: Spread::of(errors).unwrap_or_default(),
            missed,
        });
    }
    Ok(row)
}
