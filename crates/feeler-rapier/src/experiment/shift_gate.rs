//! The shift gate of the thesis (5.2): a stick of connected spheres, pulled through the gate by a spring.
//!
//! The part is an H of round channels, open above by less than the lowest ball's width, with a spherical hole in the middle. Its four ends are
//! gears 1 to 4, the middle, where the ball sinks in, stands for gear 5. The spring pulls the uppermost ball along, and carries
//! most of the weight while the lowest one runs on a channel's floor.

use super::plot::{Line, Marks, Plot};
use super::world::{Body, DAMPING, Edges, HERTZ, brep_body, mesh_body, world};
use super::{Extent, Finding, Scene, ball_query, median, part, short, table};
use feeler::brep::Brep;
use rapier3d_f64::prelude::*;
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

/// The stick's balls: height over the lowest, radius, mm.
const BALLS: [[f64; 2]; 6] = [
    [0.0, 1.4],
    [1.7, 1.0],
    [3.2, 0.8],
    [4.6, 0.8],
    [6.0, 0.8],
    [7.6, 1.2],
];
/// kg.
const MASS: f64 = 0.05;
/// None: the way out of the middle is so steep (85 degrees) that friction of 0.1 would jam it.
const FRICTION: f64 = 0.0;
/// mm/s^2.
const GRAVITY: f64 = 9810.0;
/// kg/s^2, which is N/m.
const SPRING: f64 = 500.0;
/// Of the uppermost ball, kg/s.
const DAMPER: f64 = 10.0;
/// Of the stick's motion, 1/s: its swing under the spring, some 16 rad/s, dies away.
const AIR: f64 = 20.0;
/// What the spring carries of the weight.
const CARRIED: f64 = 0.7;
/// How far above the uppermost ball the spring's other end is, mm, when the lowest one is on a channel's floor: it pulls by so much of
/// the weight that a stick that leans is raised, and its lowest ball pressed on the end of a channel.
const ABOVE: f64 = CARRIED * MASS * GRAVITY / SPRING;
/// mm/s, and s at each end.
const SPEED: f64 = 60.0;
const REST: f64 = 0.3;
/// s.
const STEP: f64 = 1e-3;
/// How far the ends of the spring's way lie beyond those of the channels, mm: the wall stops the ball.
const BEYOND: f64 = 1.0;
/// What the lowest ball is smaller than the channels, mm: so far it may stand off the centre of an end.
const GAP: f64 = 1.5 - BALLS[0][1];
/// What it is smaller than the hole in the middle, mm.
const SINK: f64 = 2.5 - BALLS[0][1];
/// What it may stand off a gear besides, mm: depths, and swings about the middle that have not died away.
const PLAY: f64 = 0.05;
/// From kg mm/s^2 to N.
const NEWTON: f64 = 1e-3;
/// Prediction (0.02) and slop (1e-6) go by it, mm.
const UNIT: f64 = 1.0;

/// A gear's number, if it is one, and its place.
type Stop = (Option<usize>, [f64; 2]);

/// Where the spring's end goes: gears' ends lie in the H's four corners.
const WAY: [Stop; 10] = [
    (None, [0.0, 0.0]),
    (None, [-10.0, 0.0]),
    (Some(1), [-10.0, 8.0]),
    (Some(2), [-10.0, -8.0]),
    (None, [-10.0, 0.0]),
    (None, [10.0, 0.0]),
    (Some(3), [10.0, 8.0]),
    (Some(4), [10.0, -8.0]),
    (None, [10.0, 0.0]),
    (Some(5), [0.0, 0.0]),
];

/// When a leg begins, from where to where, how long it takes, and the gear in which it ends.
type Leg = (f64, [f64; 2], [f64; 2], f64, Option<usize>);

/// The spring's end over time: straight lines, rests at the stops.
struct Way {
    legs: Vec<Leg>,
    time: f64,
}

impl Way {
    fn new() -> Self {
        let beyond = |(gear, p): &Stop| {
            let y = match gear {
                Some(1..=4) => p[1] + BEYOND * p[1].signum(),
                _ => p[1],
            };
            [p[0], y]
        };
        let mut legs = Vec::new();
        let mut time = REST;
        for pair in WAY.windows(2) {
            let (from, to) = (beyond(&pair[0]), beyond(&pair[1]));
            let takes = (to[0] - from[0]).hypot(to[1] - from[1]) / SPEED;
            legs.push((time, from, to, takes, pair[1].0));
            time += takes + REST;
        }
        Self { legs, time }
    }

    fn at(&self, time: f64) -> [f64; 2] {
        let mut at = WAY[0].1;
        for (begin, from, to, takes, _) in &self.legs {
            if time >= *begin {
                let part = ((time - begin) / takes).min(1.0);
                at = [0, 1].map(|k| from[k] + part * (to[k] - from[k]));
            }
        }
        at
    }

    /// The gear in which the spring's end rests for the last half of its rest.
    fn resting(&self, time: f64) -> Option<usize> {
        self.legs.iter().find_map(|(begin, _, _, takes, gear)| {
            let since = time - begin - takes;
            gear.filter(|_| (0.5 * REST..REST).contains(&since))
        })
    }
}

#[derive(Default)]
struct Track {
    time: Vec<f64>,
    /// Of the spring, N.
    pull: Vec<f64>,
    /// The lowest ball's centre, mm.
    path: Vec<[f64; 3]>,
    /// Where the stick touches the part, mm, and how deep at most at all times.
    contacts: Vec<[f64; 3]>,
    deepest: f64,
    /// Largest distance from each gear's place, seen from above, mm, in the last half of the spring's rest there.
    off: [f64; 5],
    step_us: Vec<f64>,
}

fn simulate(body: &Body) -> Track {
    let mut w = world(GRAVITY, UNIT, STEP, body);
    let ground = w.insert_body(RigidBodyBuilder::fixed());
    let collider = ColliderBuilder::new(body.shape.clone()).friction(FRICTION);
    let part = w.insert_collider(collider, Some(ground));
    let stick = RigidBodyBuilder::dynamic()
        .linear_damping(AIR)
        .angular_damping(AIR)
        .can_sleep(false);
    let stick = w.insert_body(stick);
    let balls = BALLS.map(|[height, radius]| {
        let collider = ColliderBuilder::ball(radius)
            .translation(Vector::new(0.0, 0.0, height))
            .mass(MASS / BALLS.len() as f64)
            .friction(FRICTION);
        w.insert_collider(collider, Some(stick))
    });
    let way = Way::new();
    let top = Vector::new(0.0, 0.0, BALLS[BALLS.len() - 1][0]);
    let mut track = Track {
        off: [f64::INFINITY; 5],
        ..Track::default()
    };
    for k in 0..(way.time / STEP).ceil() as usize {
        let time = k as f64 * STEP;
        let [x, y] = way.at(time);
        let end = Vector::new(x, y, top.z - GAP + ABOVE);
        let own = &mut w.bodies[stick];
        let knob = own.position().transform_point(top);
        let pull = (end - knob) * SPRING - own.velocity_at_point(knob) * DAMPER;
        own.reset_forces(true);
        own.reset_torques(true);
        own.add_force_at_point(pull, knob, true);
        let begun = Instant::now();
        w.step();
        track.step_us.push(begun.elapsed().as_secs_f64() * 1e6);
        let at = w.bodies[stick].translation();
        track.time.push(time + STEP);
        track.pull.push(pull.length() * NEWTON);
        track.path.push(at.to_array());
        if let Some(gear) = way.resting(time + STEP) {
            let place = WAY.iter().find(|s| s.0 == Some(gear));
            let off = place.map_or(f64::INFINITY, |(_, p)| (at.x - p[0]).hypot(at.y - p[1]));
            let worst = &mut track.off[gear - 1];
            *worst = if worst.is_finite() {
                worst.max(off)
            } else {
                off
            };
        }
        for ball in balls {
            let Some(pair) = w.contact_pair(part, ball) else {
                continue;
            };
            for point in pair.manifolds().iter().flat_map(|m| &m.points) {
                if point.dist <= 0.0 {
                    let first = pair.collider1 == part;
                    let on_part = if first {
                        point.local_p1
                    } else {
                        point.local_p2
                    };
                    track.contacts.push(on_part.to_array());
                    track.deepest = track.deepest.max(-point.dist);
                }
            }
        }
    }
    track
}

/// The lowest ball at the end of each rest in a gear.
fn scene(brep: &Brep, t: &Track) -> Scene {
    let way = Way::new();
    let last = |gear: usize| {
        t.time
            .iter()
            .rposition(|time| way.resting(*time) == Some(gear))
    };
    let balls = (1..=5).filter_map(|gear| {
        let at = t.path[last(gear)?];
        Some(ball_query(&format!("gear {gear}"), at, BALLS[0][1], 0.01))
    });
    Scene {
        name: "shift-gate".to_owned(),
        brep: brep.clone(),
        queries: balls.collect(),
    }
}

fn gears(t: &Track) -> Vec<usize> {
    let within = |g: usize| if g == 5 { 0.5 * SINK } else { GAP + PLAY };
    let reached = |g: &usize| t.off[g - 1] <= within(*g);
    (1..=5).filter(reached).collect()
}

/// Change of the pull in a step, N: bumps of the wall.
fn jumps(t: &Track) -> Vec<f64> {
    let steps = t.pull.windows(2);
    steps.map(|p| (p[1] - p[0]).abs()).collect()
}

fn row(body: &Body, t: &Track) -> Vec<String> {
    let reached = gears(t).iter().map(usize::to_string).collect::<Vec<_>>();
    let off = t.off.map(short).join(" ");
    vec![
        body.name.clone(),
        body.triangles.map_or("-".to_owned(), |n| n.to_string()),
        reached.join(" "),
        off,
        short(t.pull.iter().copied().fold(0.0, f64::max)),
        short(median(&t.pull)),
        short(jumps(t).into_iter().fold(0.0, f64::max)),
        short(t.deepest),
        short(median(&t.step_us)),
    ]
}

fn lines(body: &Body, t: &Track) -> Line {
    Line {
        name: body.name.clone(),
        points: t.time.iter().copied().zip(t.pull.iter().copied()).collect(),
        marks: Marks::None,
    }
}

pub(super) fn run(
    models: &Path,
    extent: Extent,
    progress: &mut dyn FnMut(&str),
) -> Result<Finding, String> {
    let brep = part(models, "shift_gate_nurbs.3dm")?;
    let (own, shape) = brep_body(brep.clone())?;
    let mut scenes = Vec::new();
    let degrees: &[f64] = match extent {
        Extent::Quick => &[],
        Extent::Whole | Extent::Finest => &[30.0, 10.0, 3.0],
    };
    let mut bodies = vec![own];
    for d in degrees {
        bodies.push(mesh_body(&brep, *d, Edges::Fixed { turned: false })?);
    }
    let mut rows = Vec::new();
    let mut pulls = Vec::new();
    let mut above = Vec::new();
    for body in &bodies {
        progress(&format!("shift gate, {}", body.name));
        let t = simulate(body);
        rows.push(row(body, &t));
        pulls.push(lines(body, &t));
        if body.triangles.is_none() {
            scenes.push(scene(&brep, &t));
            above = vec![
                Line {
                    name: "contacts".to_owned(),
                    points: t.contacts.iter().map(|p| (p[0], p[1])).collect(),
                    marks: Marks::Only,
                },
                Line {
                    name: "centre of the lowest ball".to_owned(),
                    points: t.path.iter().map(|p| (p[0], p[1])).collect(),
                    marks: Marks::None,
                },
                Line {
                    name: "the spring's end at its stops".to_owned(),
                    points: WAY.iter().map(|s| (s.1[0], s.1[1])).collect(),
                    marks: Marks::Only,
                },
            ];
        }
    }
    let plots = [
        (
            "shift-gate-above.svg",
            Plot {
                title: "The gate from above: where the stick touches it (BREP)".to_owned(),
                x: "x, mm".to_owned(),
                y: "y, mm".to_owned(),
                lines: above,
                log: [false; 2],
            },
        ),
        (
            "shift-gate-pull.svg",
            Plot {
                title: "Through gears 1 to 5: pull of the spring".to_owned(),
                x: "time, s".to_owned(),
                y: "N".to_owned(),
                lines: pulls,
                log: [false; 2],
            },
        ),
    ];
    let plots: Vec<_> = plots
        .into_iter()
        .map(|(n, p)| (n.to_owned(), p.svg()))
        .collect();
    let head = [
        "gate",
        "triangles",
        "gears reached",
        "distances from them mm",
        "pull, most N",
        "median N",
        "largest change of the pull in a step N",
        "deepest contact mm",
        "whole step us",
    ];
    let way = Way::new();
    let mut page = format!(
        "# Shift gate\n\n\
        A stick of {} connected balls ({} kg, the lowest of radius {} mm) stands in the gate of the thesis, an H of channels of radius 1.5 mm with a spherical hole of radius 2.5 mm in \
        the middle (a NURBS). A spring of {SPRING} N/m pulls its uppermost ball through the gears; its other end goes at {SPEED} mm/s, rests {REST} s at each stop, and goes {BEYOND} mm \
        beyond the ends of the channels. The part of this repository has four ends: they are gears 1 to 4, and the middle, where the ball sinks in, stands for the fifth. \
        No friction. Rapier 0.36 (f64), steps of {STEP} s for {:.2} s; contact recycling off, softness {HERTZ} Hz with a damping ratio of {DAMPING}; meshes have \
        Rapier's clustering of contacts and normals at inner edges fixed.\n\n\
        A gear is *reached* if the lowest ball's centre, seen from above, is within {GAP:.1} mm (its play in the channel) and {PLAY} mm of the gear's place throughout the last half of the \
        spring's rest there; gear 5 if it is within half of the {SINK} mm that it is smaller than the hole.\n\n",
        BALLS.len(),
        MASS,
        BALLS[0][1],
        way.time,
    );
    page += &table(&head, &rows);
    let _ = write!(
        page,
        "\nThe pull is that of the spring and its damper. In the middle, where the floor is deep, the stick hangs in the spring, and the pull is its weight, {:.3} N; on the floor of a channel \
        the spring carries {CARRIED} of it, and the rest of the pull presses the ball on the channel's end. Times are medians of one run on a machine that did other work, too. Queries that fell short of their accuracy or \
        left the side open: {}.\n\n",
        MASS * GRAVITY * NEWTON,
        shape.undecided()
    );
    for (name, _) in &plots {
        let _ = writeln!(page, "![{name}]({name})\n");
    }
    page += "[The gate with the stick's lowest ball in each gear](shift-gate.html)\n";
    Ok(Finding {
        page,
        plots,
        scenes,
    })
}
