//! `cargo xtask scenes`: the corpus's queries, from fixed seeds.

use crate::generate::{Generator, NEAR};
use crate::random::Random;
use feeler_corpus::{Ceilings, MODELS, Model, QueryLine, SphereLine, SuiteFile};
use std::path::Path;

/// Parts whose faces are all NURBS.
const PARTS: [&str; 9] = [
    "ball_joint_cavity_nurbs",
    "ball_joint_socket_nurbs",
    "cube_corner_cut_nurbs",
    "cube_corner_sphere_cut_nurbs",
    "cylinder_nurbs",
    "cylinder_nurbs_unclamped",
    "sheet_trimmed_nurbs",
    "shift_gate_straight_nurbs",
    "geneva4_wheel_nurbs",
];

type Ask = fn(&mut Generator<'_>, bool) -> QueryLine;

struct Plan {
    name: &'static str,
    description: &'static str,
    ask: Ask,
    /// Queries of each part; half of them, rounded up, near.
    each: usize,
}

const PLANS: [Plan; 6] = [
    Plan {
        name: "contact-sphere",
        description: "balls against the thesis's parts as NURBS; half of the feet within 1e-6 to 1e-15 of a trim, a seam or an edge",
        ask: |g, near| g.sphere(near),
        each: 50,
    },
    Plan {
        name: "contact-half-space",
        description: "half-spaces; half with the normal of a point within 1e-6 to 1e-15 of a trim, tilted by as little",
        ask: |g, near| g.half_space(near),
        each: 24,
    },
    Plan {
        name: "line",
        description: "lines, rays and segments; half aimed within 1e-6 to 1e-15 of a trim, a quarter nearly tangent",
        ask: |g, near| g.line(near),
        each: 40,
    },
    Plan {
        name: "side",
        description: "sides in uv; two thirds within 1e-6 to 1e-15 of a trim loop, or on it up to rounding",
        ask: |g, near| {
            let near = near || g.random.below(3) == 0;
            g.side(near)
        },
        each: 80,
    },
    Plan {
        name: "inside",
        description: "points of space against the solid; half of them above points within 1e-6 to 1e-15 of a trim",
        ask: |g, near| g.inside(near),
        each: 16,
    },
    Plan {
        name: "evaluate",
        description: "points and first derivatives; half within 1e-6 to 1e-15 of a trim, a seam or the border of the domain",
        ask: |g, near| g.evaluate(near),
        each: 40,
    },
];

/// Radii of the thesis's balls in the socket of radius 2.5 (mm).
const BALLS: [f64; 5] = [2.472, 2.49, 2.5, 2.51, 2.52];
/// How far the ball moves from the socket's centre at most (mm).
const PLAY: f64 = 0.05;
const SOCKETS: [&str; 2] = ["ball_joint_cavity_nurbs", "ball_joint_socket_nurbs"];

pub(crate) fn run(corpus: &Path) -> Result<(), String> {
    let mut total = 0;
    for plan in &PLANS {
        let mut lines = Vec::new();
        for part in PARTS {
            let name = format!("thesis/{part}.3dm");
            let path = corpus.join(MODELS).join(&name);
            let model = Model::load(&path, None).map_err(|e| e.to_string())?;
            let mut generator = Generator::new(&model, &format!("{} {part}", plan.name));
            for i in 0..plan.each {
                let line = (plan.ask)(&mut generator, i % 2 == 0);
                lines.push(QueryLine {
                    model: Some(name.clone()),
                    ..line
                });
            }
        }
        total += lines.len();
        write(corpus, plan.name, plan.description, &lines)?;
    }
    let lines = ball_joint();
    total += lines.len();
    write(
        corpus,
        "thesis",
        "balls of the thesis's ball joint, centred and moved by 1e-15 to 0.05 mm: the focal set of the socket",
        &lines,
    )?;
    println!("{total} queries written; now run `cargo xtask truth`");
    Ok(())
}

/// Balls in the spherical sockets: at the centre, near it, and off it.
fn ball_joint() -> Vec<QueryLine> {
    let mut random = Random::new("thesis");
    let mut lines = Vec::new();
    for part in SOCKETS {
        for radius in BALLS {
            let offsets = std::iter::once(0.0)
                .chain(NEAR)
                .chain([1e-4, 1e-3, 0.01, PLAY]);
            for offset in offsets {
                let center = random.direction() * offset;
                lines.push(QueryLine {
                    model: Some(format!("thesis/{part}.3dm")),
                    sphere: Some(SphereLine {
                        center: center.into(),
                        radius,
                    }),
                    ..QueryLine::default()
                });
            }
        }
    }
    lines
}

/// Writes the queries; `suite.json` only where there is none, for its ceilings are set by hand.
fn write(corpus: &Path, suite: &str, description: &str, lines: &[QueryLine]) -> Result<(), String> {
    let folder = corpus.join(suite);
    let fail = |e: std::io::Error| format!("{}: {e}", folder.display());
    std::fs::create_dir_all(&folder).map_err(fail)?;
    let text: String = lines.iter().map(|l| l.to_text() + "\n").collect();
    std::fs::write(folder.join("queries.jsonl"), text).map_err(fail)?;
    let path = folder.join("suite.json");
    if !path.exists() {
        let file = SuiteFile {
            description: description.to_owned(),
            ceilings: Ceilings::default(),
        };
        let text = serde_json::to_string_pretty(&file).map_err(|e| e.to_string())?;
        std::fs::write(path, text + "\n").map_err(fail)?;
    }
    Ok(())
}
