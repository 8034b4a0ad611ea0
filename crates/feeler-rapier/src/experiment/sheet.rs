//! Rolling without bumps, second part: a ball on a bicubic sheet, in one face and in four.
//!
//! # Reference
//! Frictionless motion on a sheet of this kind has no closed form. The reference is the same ball on the same BREP under penalty contact of 1e12 N/m, a depth of
//! 2.5e-12 mm, by the integrator of the experiment `stiff` (order 5), which shares nothing with Rapier but the BREP's answers; its own error is that of
//! twice its step. Energy is constant.

use super::plot::{Line, Marks, Plot};
use super::stiff::{BALL, BrepWall, GRAVITY, Law, MASS, State, Tally, Wall, step};
use super::world::{Body, Edges, brep_body, mesh_body, world};
use super::{Extent, Finding, drawn, median, short, table};
use ::nalgebra::{Point3, Vector3, Vector4};
use feeler::brep::{Brep, BrepBuilder};
use feeler::nurbs::{NurbsSurface, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::Accuracy;
use rapier3d_f64::prelude::*;
use std::fmt::Write;
use std::sync::Arc;
use std::time::Instant;

/// Half the side of the sheet, mm.
pub(super) const SIDE: f64 = 12.0;
/// z, as powers of x and y and their factors: a bowl that is no quadric.
const POWERS: [(usize, usize, f64); 5] = [
    (2, 0, 1.0 / 64.0),
    (0, 2, 1.0 / 48.0),
    (3, 0, 1.0 / 2048.0),
    (1, 2, 1.0 / 1024.0),
    (2, 2, 1.0 / 16384.0),
];
/// Where the ball sets out (its foot), and how fast, mm and mm/s.
const FROM: f64 = 6.0;
const SPEED: f64 = 110.0;
/// s.
const TIME: f64 = 0.4;
const STEP: f64 = 2e-4;
const SHORTER: f64 = 0.1;
const STIFFNESS: f64 = 1e12;
/// Steps in which the contact forms: their jumps are not counted.
const FORMING: usize = 20;

/// z of the sheet.
pub(super) fn height(x: f64, y: f64) -> f64 {
    let each = POWERS.iter();
    each.map(|(i, j, f)| f * x.powi(*i as i32) * y.powi(*j as i32))
        .sum()
}

/// The unit normal of the sheet, upwards.
pub(super) fn upward(x: f64, y: f64) -> Vector3<f64> {
    // The derivative of t^n.
    let fall = |t: f64, n: usize| match n {
        0 => 0.0,
        n => n as f64 * t.powi(n as i32 - 1),
    };
    let each = POWERS.iter().map(|(i, j, f)| {
        let by_x = f * fall(x, *i) * y.powi(*j as i32);
        let by_y = f * x.powi(*i as i32) * fall(y, *j);
        Vector3::new(-by_x, -by_y, 0.0)
    });
    (each.sum::<Vector3<f64>>() + Vector3::z()).normalize()
}

/// x^power as coefficients of the cubic B-splines over some knots: its polar form at the three knots within each.
fn polar(knots: &[f64], power: usize) -> Vec<f64> {
    let at = |t: &[f64]| match power {
        0 => 1.0,
        1 => (t[0] + t[1] + t[2]) / 3.0,
        2 => (t[0] * t[1] + t[0] * t[2] + t[1] * t[2]) / 3.0,
        _ => t[0] * t[1] * t[2],
    };
    knots[1..knots.len() - 1].windows(3).map(at).collect()
}

/// The sheet between some x and some y: clamped cubic splines with a knot in the middle.
fn face(x: [f64; 2], y: [f64; 2]) -> Result<Surface, String> {
    let knots = |[a, b]: [f64; 2]| {
        let mut all = vec![a; 4];
        all.push(0.5 * (a + b));
        all.extend([b; 4]);
        all
    };
    let (u, v) = (knots(x), knots(y));
    let count = u.len() - 4;
    let powers = |k: &[f64]| [0, 1, 2, 3].map(|p| polar(k, p));
    let (xs, ys) = (powers(&u), powers(&v));
    let mut net = Vec::new();
    for a in 0..count {
        for b in 0..count {
            let z = POWERS.iter().map(|(i, j, f)| f * xs[*i][a] * ys[*j][b]);
            net.push(Vector4::new(xs[1][a], ys[1][b], z.sum(), 1.0));
        }
    }
    let made = NurbsSurface::new([3, 3], [count, count], net, [u, v]);
    made.map(Surface::Nurbs).map_err(|e| e.to_string())
}

pub(super) fn sheet(parts: &[[f64; 2]]) -> Result<Brep, String> {
    let mut builder = BrepBuilder::new();
    for x in parts {
        for y in parts {
            builder.whole_surface(face(*x, *y)?);
        }
    }
    builder.build().map_err(|e| e.to_string())
}

/// Centre and velocity at each step's end.
type Way = Vec<(Point3<f64>, Vector3<f64>)>;

/// The centre over the start.
fn start(brep: &Arc<PreparedBrep>) -> (Point3<f64>, Vector3<f64>) {
    let mut wall = BrepWall::new(brep, Accuracy::Full);
    let mut at = Point3::new(FROM, 0.0, height(FROM, 0.0) + BALL);
    let mut normal = Vector3::z();
    for _ in 0..20 {
        let near = wall.near(&at);
        normal = near.normal;
        at += normal * near.depth;
    }
    (at, normal)
}

fn reference(brep: &Arc<PreparedBrep>, part: usize) -> Way {
    let mut wall = BrepWall::new(brep, Accuracy::Full);
    let law = Law {
        stiffness: STIFFNESS,
        rolls: false,
        gravity: Vector3::new(0.0, 0.0, -GRAVITY),
    };
    let (at, normal) = start(brep);
    let mut s = State {
        at,
        velocity: Vector3::y() * SPEED,
        spin: Vector3::zeros(),
        push: MASS * GRAVITY,
        grip: Vector3::zeros(),
        normal,
    };
    let mut tally = Tally::default();
    let mut way = vec![(s.at, s.velocity)];
    for _ in 0..(TIME / STEP).round() as usize {
        for _ in 0..part {
            let h = STEP / part as f64;
            s = step(&mut wall, &law, &s, h, &mut tally);
        }
        way.push((s.at, s.velocity));
    }
    way
}

#[derive(Default)]
struct Track {
    time: Vec<f64>,
    /// Distance from the reference, mm.
    off: Vec<f64>,
    /// Change of the energy, of the kinetic one at the start.
    energy: Vec<f64>,
    /// How far the change of velocity in a step is from the reference's, in units of gravity.
    bump: Vec<f64>,
    step_us: Vec<f64>,
    places: Vec<[f64; 3]>,
}

fn simulate(body: &Body, from: (Point3<f64>, Vector3<f64>), way: &Way, parts: usize) -> Track {
    let dt = STEP / parts as f64;
    let mut w = world(GRAVITY, BALL, dt, body);
    let ground = w.insert_body(RigidBodyBuilder::fixed());
    let collider = ColliderBuilder::new(body.shape.clone());
    w.insert_collider(collider.friction(0.0), Some(ground));
    let ball = RigidBodyBuilder::dynamic()
        .translation(Vector::new(from.0.x, from.0.y, from.0.z))
        .linvel(Vector::new(0.0, SPEED, 0.0))
        .can_sleep(false);
    let ball = w.insert_body(ball);
    let collider = ColliderBuilder::ball(BALL).mass(MASS).friction(0.0);
    w.insert_collider(collider, Some(ball));
    let mut track = Track::default();
    let energy = |z: f64, v: &Vector3<f64>| 0.5 * v.norm_squared() + GRAVITY * z;
    let kinetic = 0.5 * SPEED * SPEED;
    let whole = energy(from.0.z, &(Vector3::y() * SPEED));
    let mut before = Vector3::y() * SPEED;
    for (k, pair) in way.windows(2).enumerate() {
        let begun = Instant::now();
        for _ in 0..parts {
            w.step();
        }
        track
            .step_us
            .push(begun.elapsed().as_secs_f64() * 1e6 / parts as f64);
        let body = &w.bodies[ball];
        let at = Point3::from(body.translation().to_array());
        let now = Vector3::from(body.linvel().to_array());
        track.time.push((k + 1) as f64 * STEP);
        track.places.push(body.translation().to_array());
        track.off.push((at - pair[1].0).norm());
        track.energy.push((energy(at.z, &now) - whole) / kinetic);
        let even = pair[1].1 - pair[0].1;
        track
            .bump
            .push((now - before - even).norm() / STEP / GRAVITY);
        before = now;
    }
    track
}

fn most(values: &[f64]) -> f64 {
    values.iter().map(|v| v.abs()).fold(0.0, f64::max)
}

fn row(name: String, body: &Body, t: &Track) -> Vec<String> {
    vec![
        name,
        body.triangles.map_or("-".to_owned(), |n| n.to_string()),
        short(median(&t.step_us)),
        short(most(&t.off)),
        short(most(&t.energy)),
        short(most(&t.bump[FORMING..])),
        short(median(&t.bump)),
    ]
}

pub(super) fn run(extent: Extent, progress: &mut dyn FnMut(&str)) -> Result<Finding, String> {
    let one = sheet(&[[-SIDE, SIDE]])?;
    let four = sheet(&[[-SIDE, 0.0], [0.0, SIDE]])?;
    let degrees: &[f64] = match extent {
        Extent::Quick => &[6.0],
        Extent::Whole | Extent::Finest => &[6.0, 0.6, 0.06],
    };
    let parts = match extent {
        Extent::Quick => 1,
        Extent::Whole | Extent::Finest => 4,
    };
    let (mut body, _) = brep_body(one.clone())?;
    body.name = "BREP, one face".to_owned();
    let (mut seams, _) = brep_body(four.clone())?;
    seams.name = "BREP, four faces".to_owned();
    let mut bodies = vec![body, seams.clone()];
    for edges in [Edges::Plain, Edges::Fixed { turned: false }] {
        for d in degrees {
            bodies.push(mesh_body(&one, *d, edges)?);
        }
    }
    progress("sheet, reference");
    let prepared = Arc::new(PreparedBrep::new(one));
    let way = reference(&prepared, 2 * parts);
    let coarse = reference(&prepared, parts);
    let apart = way.iter().zip(&coarse).map(|(a, b)| (a.0 - b.0).norm());
    let own = apart.fold(0.0, f64::max);
    let from = way[0];
    let mut rows = Vec::new();
    let mut bumps = Vec::new();
    let mut scenes = Vec::new();
    let mut against: [Vec<Line>; 2] = Default::default();
    for body in &bodies {
        progress(&format!("sheet, {}", body.name));
        let t = simulate(body, from, &way, 1);
        rows.push(row(body.name.clone(), body, &t));
        if body.name == seams.name {
            scenes.push(drawn("rolling-sheet", four.clone(), BALL, &t.places));
        }
        let values = [most(&t.off) / BALL, most(&t.bump[FORMING..])];
        for (k, value) in values.into_iter().enumerate() {
            let kind = match body.triangles {
                None => body.name.as_str(),
                Some(_) if body.name.ends_with("fixed") => "mesh, fixed",
                Some(_) => "mesh",
            };
            let what = ["off the path, ball radii", "jump of velocity, g"][k];
            let name = format!("{kind}: {what}");
            let found = against[k].iter_mut().find(|l| l.name == name);
            let points = match body.triangles {
                Some(n) => vec![(n as f64, value)],
                None => vec![(1e2, value), (1e6, value)],
            };
            match found {
                Some(line) => line.points.extend(points),
                None => against[k].push(Line {
                    name,
                    points,
                    marks: if body.triangles.is_some() {
                        Marks::Too
                    } else {
                        Marks::None
                    },
                }),
            }
        }
        if !body.name.contains("one face") {
            bumps.push(Line {
                name: body.name.clone(),
                points: t
                    .time
                    .iter()
                    .copied()
                    .zip(t.bump.iter().map(|v| v.max(1e-6)))
                    .collect(),
                marks: Marks::None,
            });
        }
    }
    progress("sheet, BREP, shorter steps");
    let fine = simulate(&bodies[1], from, &way, (1.0 / SHORTER) as usize);
    let name = format!("BREP, four faces, steps of {:.0e} s", STEP * SHORTER);
    rows.insert(2, row(name, &bodies[1], &fine));
    // The first are drawn over by the last: meshes are rougher.
    bumps.reverse();
    let plots = [
        (
            "rolling-sheet.svg",
            Plot {
                title: "A ball on a bicubic sheet: largest deviation from the reference".to_owned(),
                x: "triangles".to_owned(),
                y: "largest deviation".to_owned(),
                lines: against.into_iter().flatten().collect(),
                log: [true, true],
            },
        ),
        (
            "rolling-sheet-bumps.svg",
            Plot {
                title: "Bicubic sheet: jump of the velocity in a step, beside the reference's"
                    .to_owned(),
                x: "time, s".to_owned(),
                y: "in units of gravity".to_owned(),
                lines: bumps,
                log: [false, true],
            },
        ),
    ];
    let plots: Vec<_> = plots
        .into_iter()
        .map(|(n, p)| (n.to_owned(), p.svg()))
        .collect();
    let head = [
        "shape",
        "triangles",
        "step us",
        "off the path, mm",
        "energy, most",
        "jump of velocity, most, g",
        "median, g",
    ];
    let mut page = format!(
        "## A bicubic sheet, and seams of faces\n\n\
        A ball of radius {BALL} mm without friction on a sheet of {:.0} mm by {:.0} mm, a bicubic spline: a bowl that is no quadric. It sets out {FROM} mm off the middle at {SPEED} mm/s across the slope, and runs for \
        {TIME} s in steps of {STEP} s, as above. The BREP is one face, or four whose seams the ball crosses again and again; the meshes are those of the one face. There is no closed form: the reference is the ball \
        under a penalty of {STIFFNESS:.0e} N/m by the integrator of `simulate stiff` in steps of {:.1e} s, and is within {} mm of itself in steps twice as long. In Rapier the ball rests {:.1e} mm deep (softness). Energies are relative to the kinetic one at the \
        start; *jump*: how far the change of velocity in one step is from the reference's, the first {FORMING} steps left out.\n\n",
        2.0 * SIDE,
        2.0 * SIDE,
        STEP / (2 * parts) as f64,
        short(own),
        GRAVITY / (std::f64::consts::TAU * super::world::HERTZ).powi(2),
    );
    page += &table(&head, &rows);
    page += "\nThe four faces share no edges, only places. The border of a face that the ball has not reached is no contact of its own where another \
        face goes on below it, so that the ball crosses their seams as it runs over the one face.\n\n";
    for (name, _) in &plots {
        let _ = writeln!(page, "![{name}]({name})\n");
    }
    Ok(Finding {
        page,
        plots,
        scenes,
    })
}
