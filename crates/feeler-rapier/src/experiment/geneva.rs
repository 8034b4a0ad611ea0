//! A pin of spheres that turns the Geneva wheel of the thesis (5.3).
//!
//! The wheel (n slots) stands about the z axis; the driver turns about a parallel axis at distance a, its pin at the radius R = a sin(pi / n).
//! While the pin is in a slot, the slot's middle line goes through the pin's centre, up to the play between them; elsewhere a brake
//! holds the wheel. The driver's locking disc is left out: the brake stands for it.

use super::plot::{Line, Marks, Plot};
use super::world::{DAMPING, HERTZ, brep_body, world};
use super::{Extent, Finding, Scene, ball_query, median, part, short, table};
use feeler::brep::Brep;
use parry3d_f64::shape::FeatureId;
use rapier3d_f64::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

/// Between the axes, mm.
const APART: f64 = 40.0;
/// Of the pin's spheres, mm; half of a slot's width.
const PIN: f64 = 3.0;
const SLOT: f64 = 3.1;
/// Heights of the spheres; the wheel goes from 0 to 6 mm.
const HEIGHTS: [f64; 3] = [1.0, 3.0, 5.0];
/// Revolutions of the driver a second.
const SPEED: f64 = 1.0;
/// kg/mm^3: steel.
const DENSITY: f64 = 7.85e-6;
/// The brake, N mm: a fifth to a half of what it takes to turn the wheel so fast.
const BRAKE: f64 = 2.0;
/// From kg mm^2/s^2 to N mm.
const NEWTON_MM: f64 = 1e-3;
/// None: steel on oiled steel would have little, and what it adds hides what is looked for.
const FRICTION: f64 = 0.0;
/// s. The pin moves by 0.036 mm in it, less than its play.
const STEP: f64 = 2e-4;
/// Prediction (0.02) and slop (1e-6) go by it, mm.
const UNIT: f64 = 1.0;
/// What depths of the engine's contacts may add to the play, mm.
const DEPTH: f64 = 0.02;
/// Pins drawn on the page.
const DRAWN: usize = 9;

/// A wheel, and how it was told from its file's name.
struct Wheel {
    file: &'static str,
    slots: usize,
}

const WHEELS: [Wheel; 3] = [
    Wheel {
        file: "geneva4_wheel.3dm",
        slots: 4,
    },
    Wheel {
        file: "geneva4_wheel_nurbs.3dm",
        slots: 4,
    },
    Wheel {
        file: "geneva6_wheel_nurbs.3dm",
        slots: 6,
    },
];

impl Wheel {
    /// Half of the angle by which it goes on in a turn.
    fn half(&self) -> f64 {
        PI / self.slots as f64
    }

    fn crank(&self) -> f64 {
        APART * self.half().sin()
    }

    /// The pin's centre, the driver turned by this from where the pin is farthest from the wheel.
    fn pin(&self, driver: f64) -> [f64; 2] {
        let r = self.crank();
        [APART + r * driver.cos(), r * driver.sin()]
    }

    /// Whether the pin is in a slot, after how many turns, and the wheel's angle then, free of play: the slot that the pin
    /// enters stands at half a step.
    fn ideal(&self, driver: f64) -> (bool, f64) {
        let turns = (driver / TAU).floor();
        let from_middle = driver - turns * TAU - PI;
        let start = self.half() * (1.0 - 2.0 * turns);
        if from_middle.abs() >= 0.5 * PI - self.half() {
            let gone = if from_middle > 0.0 {
                2.0 * self.half()
            } else {
                0.0
            };
            return (false, start - gone);
        }
        let [x, y] = self.pin(driver);
        (true, start - self.half() + y.atan2(x))
    }

    /// By how much the wheel may be off for the play, the pin as far from its axis as it is.
    fn play(&self, driver: f64) -> f64 {
        let [x, y] = self.pin(driver);
        (SLOT - PIN + DEPTH) / x.hypot(y)
    }

    /// How far a point of the wheel's frame is from the planes of the nearest slot's walls.
    fn beside_walls(&self, p: Vector) -> f64 {
        let step = 2.0 * self.half();
        let slot = (p.y.atan2(p.x) / step).round() * step;
        let (sin, cos) = slot.sin_cos();
        ((p.y * cos - p.x * sin).abs() - SLOT).abs()
    }

    /// The wheel's speed over the driver's when the pin is nearest to it.
    fn fastest(&self) -> f64 {
        let r = self.crank();
        r / (APART - r)
    }
}

#[derive(Default)]
struct Track {
    driver: Vec<f64>,
    angle: Vec<f64>,
    ideal: Vec<f64>,
    /// Steps at which each face, edge or vertex of the wheel was touched.
    features: BTreeMap<(u8, u32), usize>,
    /// Largest distance of a contact's point on the wheel from the planes of its slot's walls, mm.
    beside: f64,
    deepest: f64,
    /// Largest angle off the ideal one over what play allows, while the pin is in a slot.
    off: f64,
    /// Angle gone in each whole turn.
    turns: Vec<f64>,
    fastest: f64,
    step_us: Vec<f64>,
    undecided: u64,
}

fn kind(feature: FeatureId) -> (u8, u32) {
    match feature {
        FeatureId::Face(f) => (0, f),
        FeatureId::Edge(e) => (1, e),
        FeatureId::Vertex(v) => (2, v),
        FeatureId::Unknown => (3, 0),
    }
}

fn simulate(wheel: &Wheel, brep: &Brep, turns: usize) -> Result<Track, String> {
    let (body, shape) = brep_body(brep.clone())?;
    let mut w = world(0.0, UNIT, STEP, &body);
    let ground = w.insert_body(RigidBodyBuilder::fixed());
    let own = RigidBodyBuilder::dynamic()
        .rotation(Vector::new(0.0, 0.0, wheel.half()))
        .can_sleep(false);
    let own = w.insert_body(own);
    let collider = ColliderBuilder::new(body.shape.clone());
    let collider = w.insert_collider(collider.density(DENSITY).friction(FRICTION), Some(own));
    let brake = RevoluteJointBuilder::new(Vector::Z)
        .motor_velocity(0.0, 1e6)
        .motor_max_force(BRAKE / NEWTON_MM);
    w.insert_impulse_joint(ground, own, brake);
    let speed = TAU * SPEED;
    let driver = RigidBodyBuilder::kinematic_velocity_based()
        .translation(Vector::new(APART, 0.0, 0.0))
        .angvel(Vector::new(0.0, 0.0, speed));
    let driver = w.insert_body(driver);
    let pins = HEIGHTS.map(|z| {
        let at = Vector::new(wheel.crank(), 0.0, z);
        // Without mass: a body turns about its centre of mass, and this one's is to be the driver's axis.
        let ball = ColliderBuilder::ball(PIN).density(0.0).translation(at);
        w.insert_collider(ball.friction(FRICTION), Some(driver))
    });
    let mut t = Track::default();
    let mut angle = wheel.half();
    let mut at_turn = angle;
    let steps = (turns as f64 / SPEED / STEP).round() as usize;
    for k in 0..steps {
        let begun = Instant::now();
        w.step();
        t.step_us.push(begun.elapsed().as_secs_f64() * 1e6);
        let turned = (k + 1) as f64 * STEP * speed;
        let x = w.bodies[own].position().transform_vector(Vector::X);
        let now = x.y.atan2(x.x);
        // To the nearest turn of where it was.
        angle += (now - angle + PI).rem_euclid(TAU) - PI;
        let (engaged, ideal) = wheel.ideal(turned);
        t.driver.push(turned);
        t.angle.push(angle);
        t.ideal.push(ideal);
        t.fastest = t.fastest.max(w.bodies[own].angvel().z.abs() / speed);
        if engaged {
            t.off = t.off.max((angle - ideal).abs() / wheel.play(turned));
        }
        for pin in pins {
            let Some(pair) = w.contact_pair(collider, pin) else {
                continue;
            };
            for m in pair.manifolds() {
                for point in m.points.iter().filter(|p| p.dist <= 0.0) {
                    let first = pair.collider1 == collider;
                    let feature = if first { point.fid1 } else { point.fid2 };
                    *t.features.entry(kind(feature.unpack())).or_default() += 1;
                    t.deepest = t.deepest.max(-point.dist);
                    let on_wheel = if first {
                        point.local_p1
                    } else {
                        point.local_p2
                    };
                    t.beside = t.beside.max(wheel.beside_walls(on_wheel));
                }
            }
        }
        if (k + 1) % (steps / turns) == 0 {
            t.turns.push(at_turn - angle);
            at_turn = angle;
        }
    }
    t.undecided = shape.undecided();
    Ok(t)
}

/// What a feature of the wheel is, as its name on the page of the view.
fn name(&(kind, number): &(u8, u32)) -> String {
    match kind {
        0 => format!("face {number}"),
        1 => format!("edge {}", number >> crate::pair::WITHIN),
        2 => format!("vertex {number}"),
        _ => "unknown".to_owned(),
    }
}

/// The pin's middle sphere in the wheel's frame, at times spread over the first engagement.
fn scene(wheel: &Wheel, brep: Brep, t: &Track) -> Scene {
    let within = |d: &f64| *d < TAU && wheel.ideal(*d).0;
    let steps: Vec<usize> = (0..t.driver.len())
        .filter(|k| within(&t.driver[*k]))
        .collect();
    let queries = (0..DRAWN).filter_map(|k| {
        let step = *steps.get(k * steps.len().saturating_sub(1) / (DRAWN - 1))?;
        let [x, y] = wheel.pin(t.driver[step]);
        let (sin, cos) = t.angle[step].sin_cos();
        let center = [x * cos + y * sin, y * cos - x * sin, HEIGHTS[1]];
        let name = format!("driver at {:.1} degrees", t.driver[step].to_degrees());
        Some(ball_query(&name, center, PIN, 2.0 * (SLOT - PIN)))
    });
    Scene {
        name: wheel.file.trim_end_matches(".3dm").to_owned(),
        queries: queries.collect(),
        brep,
    }
}

pub(super) fn run(
    models: &Path,
    extent: Extent,
    progress: &mut dyn FnMut(&str),
) -> Result<Finding, String> {
    let (wheels, turns) = match extent {
        Extent::Quick => (&WHEELS[..1], 2),
        Extent::Whole | Extent::Finest => (&WHEELS[..], 4),
    };
    let mut finding = Finding::default();
    let (mut rows, mut touched) = (Vec::new(), Vec::new());
    let (mut lines, mut offs) = (Vec::new(), Vec::new());
    for wheel in wheels {
        progress(&format!("{}, {turns} turns", wheel.file));
        let brep = part(models, wheel.file)?;
        let t = simulate(wheel, &brep, turns)?;
        let step = 2.0 * wheel.half();
        let worst = t.turns.iter().map(|gone| (gone - step).abs());
        let worst = worst.fold(0.0, f64::max).to_degrees();
        let mean = t.turns.iter().sum::<f64>() / t.turns.len() as f64;
        // It may stand at either end of its play before and after.
        let most = 2.0 * wheel.play(PI - (0.5 * PI - wheel.half())).to_degrees();
        rows.push(vec![
            wheel.file.to_owned(),
            format!("{:.4}", mean.to_degrees()),
            format!("{:.0}", step.to_degrees()),
            format!("{} (play {})", short(worst), short(most)),
            short(t.off),
            format!(
                "{} (free of play {})",
                short(t.fastest),
                short(wheel.fastest())
            ),
            short(t.deepest),
            short(t.beside),
            short(median(&t.step_us)),
            t.undecided.to_string(),
        ]);
        let features: Vec<String> = t
            .features
            .iter()
            .map(|(f, n)| format!("{} ({n})", name(f)))
            .collect();
        touched.push((wheel.file, features.join(", ")));
        let points = |y: &[f64]| {
            let degrees = t.driver.iter().zip(y);
            // Ten a degree are enough to draw.
            let few = degrees.step_by(t.driver.len() / 3000 + 1);
            few.map(|(x, y)| (x.to_degrees(), y.to_degrees())).collect()
        };
        let off: Vec<f64> = t.angle.iter().zip(&t.ideal).map(|(a, b)| a - b).collect();
        offs.push(Line {
            name: wheel.file.to_owned(),
            points: points(&off),
            marks: Marks::None,
        });
        lines.push(Line {
            name: wheel.file.to_owned(),
            points: points(&t.angle),
            marks: Marks::None,
        });
        if wheel.file.contains("nurbs") || wheels.len() == 1 {
            lines.push(Line {
                name: format!("{} slots, closed form", wheel.slots),
                points: points(&t.ideal),
                marks: Marks::None,
            });
        }
        finding.scenes.push(scene(wheel, brep, &t));
    }
    let plot = Plot {
        title: "A pin of spheres turns the Geneva wheel".to_owned(),
        x: "driver, degrees".to_owned(),
        y: "wheel, degrees".to_owned(),
        lines,
        log: [false; 2],
    };
    finding.plots.push(("geneva.svg".to_owned(), plot.svg()));
    let plot = Plot {
        title: "The wheel's angle off the closed form: its play".to_owned(),
        x: "driver, degrees".to_owned(),
        y: "off, degrees".to_owned(),
        lines: offs,
        log: [false; 2],
    };
    finding
        .plots
        .push(("geneva-off.svg".to_owned(), plot.svg()));
    finding.page = page(turns, &rows, &touched, &finding.scenes);
    Ok(finding)
}

fn page(
    turns: usize,
    rows: &[Vec<String>],
    touched: &[(&str, String)],
    scenes: &[Scene],
) -> String {
    let head = [
        "wheel",
        "goes on in a turn, degrees",
        "should",
        "worst turn off, degrees",
        "off while driven, in plays",
        "fastest, over the driver",
        "deepest contact mm",
        "contacts off the walls mm",
        "whole step us",
        "undecided",
    ];
    let mut page = format!(
        "# Geneva wheel\n\n\
        A driver turns at {SPEED} revolution a second about an axis {APART} mm beside the wheel's. Its pin, {} connected spheres of radius {PIN} mm, turns the wheel by its slots, {} mm wide. The wheel \
        is steel ({DENSITY:.2e} kg/mm^3; its moment comes from the BREP), its brake holds {BRAKE} N mm and stands for the driver's locking disc, which is left out. No friction at the pin. Rapier 0.36 (f64), {turns} turns in steps of {STEP} s; \
        contact recycling off, softness {HERTZ} Hz with a damping ratio of {DAMPING}.\n\n",
        HEIGHTS.len(),
        2.0 * SLOT,
    );
    page += &table(&head, rows);
    page += "\nFree of play, the wheel goes on by one slot in a turn; while the pin is in a slot, the slot's middle line goes through the pin's centre. The play is what the slot is wider than the pin \
        and 0.02 mm of depth, over the pin's distance from the wheel's axis: *off while driven* is the largest angle off the closed form in these plays, at most 1 where the pin is held by the slot's walls. Contacts off the planes of the walls are at the slot's round inner end, within the play.\n\n\
        What of the wheel was touched, and how often (contacts of a sphere in a step):\n\n";
    for (file, features) in touched {
        let _ = writeln!(page, "- {file}: {features}");
    }
    page += "\n![wheel over driver](geneva.svg)\n\n![off the closed form](geneva-off.svg)\n\n";
    for scene in scenes {
        let _ = writeln!(
            page,
            "- [{0}: the pin in the wheel's first slot, with the kernel's contacts]({0}.html)",
            scene.name
        );
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closed_form_is_that_of_textbooks() {
        // Four slots: the largest ratio of speeds is 1 / (sqrt 2 - 1) = 2.41, and the wheel rests for three quarters of a turn.
        let wheel = &WHEELS[0];
        assert!((wheel.fastest() - 2.414).abs() < 1e-3);
        let engaged = (0..1000).filter(|k| wheel.ideal(f64::from(*k) * TAU / 1000.0).0);
        assert!((engaged.count() as i32 - 250).abs() <= 1);
        // It goes on without a jump, from turn to turn.
        let mut last = wheel.ideal(0.0).1;
        for k in 1..=4000 {
            let now = wheel.ideal(f64::from(k) * TAU / 1000.0).1;
            assert!((now - last).abs() < 1.01 * wheel.fastest() * TAU / 1000.0);
            last = now;
        }
        assert!((last - wheel.half() + TAU).abs() < 1e-12);
    }
}
