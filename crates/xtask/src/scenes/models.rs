//! Suites about models that lie in the corpus: the thesis's parts and those of `make_parts.py`.

use super::{Scene, Suite};
use crate::generate::{Generator, NEAR};
use crate::random::Random;
use feeler::prepare::PreparedBrep;
use feeler::query::{Contacts, HalfSpace, Options, Probe, Workspace, contact};
use feeler_corpus::{
    AccuracyLine, ContactsLine, HalfSpaceLine, Hits, LineKindLine, LineLine, MODELS, Model,
    QueryLine, SphereLine, TrimLine,
};
use nalgebra::Vector3;
use std::path::Path;

/// The thesis's parts whose faces are all NURBS.
const THESIS_NURBS: [&str; 9] = [
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

/// Those with planes, revolutions and native arcs.
const THESIS_NATIVE: [&str; 9] = [
    "ball",
    "ball_joint_cavity",
    "ball_joint_socket",
    "cube_corner_cut",
    "cube_corner_sphere_cut",
    "cylinder",
    "geneva4_wheel",
    "sheet_trimmed",
    "shift_gate_straight",
];

/// Of `make_parts.py`.
const PARTS: [&str; 25] = [
    "bored_block",
    "bored_block_nurbs",
    "bored_sphere",
    "bored_sphere_nurbs",
    "bracket",
    "chain_link",
    "chain_link_nurbs",
    "fillet_box",
    "fillet_box_nurbs",
    "flange",
    "flange_nurbs",
    "nozzle",
    "nozzle_nurbs",
    "pipe",
    "ratchet",
    "spline_bored",
    "spline_plate",
    "square_to_round",
    "tangent_rounds",
    "tangent_rounds_nurbs",
    "thin_sphere",
    "thin_tube",
    "twisted_prism",
    "vase",
    "vase_nurbs",
];

type MakeQuery = fn(&mut Generator<'_>, bool) -> QueryLine;

struct Plan {
    name: &'static str,
    description: &'static str,
    ask: MakeQuery,
    /// Queries of each part; half of them, rounded up, near.
    each: usize,
    /// Of each native part.
    each_native: usize,
}

const PLANS: [Plan; 7] = [
    Plan {
        name: "contact-sphere",
        description: "balls against the thesis's parts, as NURBS and native; half of the feet within 1e-6 to 1e-15 of a trim, a seam or an edge",
        ask: |g, near| g.sphere(near),
        each: 50,
        each_native: 20,
    },
    Plan {
        name: "contact-half-space",
        description: "half-spaces; half with the normal of a point within 1e-6 to 1e-15 of a trim, tilted by as little",
        ask: |g, near| g.half_space(near),
        each: 30,
        each_native: 20,
    },
    Plan {
        name: "contacts",
        description: "all contacts within a prediction: balls about corners, edges, between walls and near medial axes, half-spaces; predictions from 1e-9 to a quarter of the size",
        ask: |g, near| g.contacts(near),
        each: 34,
        each_native: 16,
    },
    Plan {
        name: "line",
        description: "lines, rays and segments; half aimed within 1e-6 to 1e-15 of a trim, a quarter nearly tangent",
        ask: |g, near| g.line(near),
        each: 40,
        each_native: 30,
    },
    Plan {
        name: "side",
        description: "sides in uv; two thirds within 1e-6 to 1e-15 of a trim loop, or on it up to rounding",
        ask: |g, near| {
            let near = near || g.random.below(3) == 0;
            g.side(near)
        },
        each: 120,
        each_native: 120,
    },
    Plan {
        name: "inside",
        description: "points of space against the solid; half of them above points within 1e-6 to 1e-15 of a trim",
        ask: |g, near| g.inside(near),
        each: 40,
        each_native: 40,
    },
    Plan {
        name: "evaluate",
        description: "points and first derivatives; half within 1e-6 to 1e-15 of a trim, a seam or the border of the domain",
        ask: |g, near| g.evaluate(near),
        each: 60,
        each_native: 60,
    },
];

fn load(corpus: &Path, path: &str) -> Result<Model, String> {
    Model::load(&corpus.join(MODELS).join(path), None).map_err(|e| e.to_string())
}

/// The derivative roots of every trim of the thesis's parts.
pub(crate) fn splits(corpus: &Path) -> Result<Suite, String> {
    let mut scenes = Vec::new();
    for part in THESIS_NURBS.into_iter().chain(THESIS_NATIVE) {
        let name = format!("thesis/{part}.3dm");
        let model = load(corpus, &name)?;
        let mut queries = Vec::new();
        let faces = model
            .breps
            .iter()
            .flat_map(|b| b.faces().iter().map(move |f| (b, f)));
        for (face, (brep, f)) in faces.enumerate() {
            for (trim_loop, l) in f.loops.iter().flatten().enumerate() {
                for trim in 0..brep.parts().loops[*l].trims.len() {
                    queries.push(QueryLine {
                        split: Some(TrimLine {
                            face,
                            trim_loop,
                            trim,
                        }),
                        ..QueryLine::default()
                    });
                }
            }
        }
        scenes.push(Scene {
            name,
            breps: Vec::new(),
            queries,
        });
    }
    Ok(Suite {
        name: "split",
        description: "derivative roots of every trim curve of the thesis's parts, as NURBS and native",
        scenes,
    })
}

/// A suite for each kind of query.
pub(crate) fn kinds(corpus: &Path) -> Result<Vec<Suite>, String> {
    let mut all = Vec::new();
    for plan in &PLANS {
        let mut scenes = Vec::new();
        let nurbs = THESIS_NURBS.map(|p| (p, plan.each));
        let native = THESIS_NATIVE.map(|p| (p, plan.each_native));
        for (part, each) in nurbs.into_iter().chain(native) {
            let name = format!("thesis/{part}.3dm");
            let model = load(corpus, &name)?;
            let mut generator = Generator::new(&model, &format!("{} {part}", plan.name));
            let queries = (0..each)
                .map(|i| (plan.ask)(&mut generator, i % 2 == 0))
                .collect();
            scenes.push(Scene {
                queries,
                name,
                breps: Vec::new(),
            });
        }
        all.push(Suite {
            name: plan.name,
            description: plan.description,
            scenes,
        });
    }
    Ok(all)
}

/// All kinds of queries about parts of our own making.
pub(crate) fn parts(corpus: &Path) -> Result<Suite, String> {
    const EACH: [(MakeQuery, usize); 6] = [
        (|g, near| g.sphere(near), 16),
        (|g, near| g.half_space(near), 8),
        (|g, near| g.line(near), 16),
        (|g, near| g.side(near), 60),
        (|g, near| g.inside(near), 20),
        (|g, near| g.evaluate(near), 16),
    ];
    let mut scenes = Vec::new();
    for part in PARTS {
        let name = format!("parts/{part}.json.gz");
        let model = load(corpus, &name)?;
        let mut generator = Generator::new(&model, &format!("parts {part}"));
        let mut queries = Vec::new();
        for (ask, count) in EACH {
            queries.extend((0..count).map(|i| ask(&mut generator, i % 2 == 0)));
        }
        scenes.push(Scene {
            name,
            breps: Vec::new(),
            queries,
        });
    }
    Ok(Suite {
        name: "parts",
        description: "parts like real ones, of fillets, bores, thin walls, shells, splines trimmed by splines, lofts and pipes, native and as NURBS: \
                      all kinds of queries, half of them near trims, seams and edges",
        scenes,
    })
}

/// A question that asks for less than all, or from a pose.
type Turn = fn(&mut Generator<'_>, QueryLine) -> QueryLine;

/// What may be left out of the answer, and a pose: of balls, half-spaces and lines.
pub(crate) fn options(corpus: &Path) -> Result<Suite, String> {
    const BALL: MakeQuery = |g, near| g.sphere(near);
    const HALF_SPACE: MakeQuery = |g, near| g.half_space(near);
    const LINE: MakeQuery = |g, near| g.line(near);
    const OVERLAP: Turn = |_, q| QueryLine { overlap: true, ..q };
    const NO_CONTACTS: Turn = |_, q| QueryLine {
        contacts: Some(ContactsLine::None),
        ..q
    };
    const COARSE: Turn = |g, q| QueryLine {
        accuracy: Some(AccuracyLine::Length(g.near() * g.size())),
        ..q
    };
    const FIRST: Turn = |_, q| QueryLine {
        hits: Some(Hits::First),
        ..q
    };
    const ANY: Turn = |_, q| QueryLine {
        hits: Some(Hits::Any),
        ..q
    };
    const POSED: Turn = |g, q| g.posed(q);
    const EACH: [(MakeQuery, Turn, usize); 11] = [
        (BALL, OVERLAP, 4),
        (HALF_SPACE, OVERLAP, 2),
        (BALL, NO_CONTACTS, 2),
        (HALF_SPACE, NO_CONTACTS, 1),
        (BALL, COARSE, 4),
        (HALF_SPACE, COARSE, 2),
        (BALL, POSED, 2),
        (HALF_SPACE, POSED, 1),
        (LINE, POSED, 2),
        (LINE, FIRST, 4),
        (LINE, ANY, 4),
    ];
    let thesis = THESIS_NURBS.iter().chain(&THESIS_NATIVE);
    let thesis = thesis.map(|p| format!("thesis/{p}.3dm"));
    let parts = PARTS.iter().map(|p| format!("parts/{p}.json.gz"));
    let mut scenes = Vec::new();
    for name in thesis.chain(parts) {
        let model = load(corpus, &name)?;
        let mut generator = Generator::new(&model, &format!("options {name}"));
        let mut queries = Vec::new();
        for (ask, turn, count) in EACH {
            for i in 0..count {
                let query = ask(&mut generator, i % 2 == 0);
                queries.push(turn(&mut generator, query));
            }
        }
        scenes.push(Scene {
            queries,
            name,
            breps: Vec::new(),
        });
    }
    Ok(Suite {
        name: "options",
        description: "what else a query may say: overlap alone, no contacts, an accuracy of 1e-6 to 1e-15 of the size, a pose of the probe, the first hit or any hit of a line",
        scenes,
    })
}

/// Lines that graze a face within nothing to 1e-3 of the size.
pub(crate) fn grazing(corpus: &Path) -> Result<Suite, String> {
    let thesis = THESIS_NURBS.iter().chain(&THESIS_NATIVE);
    let thesis = thesis.map(|p| (format!("thesis/{p}.3dm"), 12));
    let parts = PARTS.iter().map(|p| (format!("parts/{p}.json.gz"), 12));
    let mut scenes = Vec::new();
    for (name, each) in thesis.chain(parts) {
        let model = load(corpus, &name)?;
        let mut generator = Generator::new(&model, &format!("grazing {name}"));
        let queries = (0..each).map(|i| graze(&mut generator, i));
        scenes.push(Scene {
            queries: queries.collect(),
            name,
            breps: Vec::new(),
        });
    }
    Ok(Suite {
        name: "line-grazing",
        description: "lines tangent to a face at a point, moved off it by nothing, 1e-15 to 1e-3 of the size, out or in; a third at a trim",
        scenes,
    })
}

/// The analytic parts that have plane ends, native and as NURBS.
const WITH_ENDS: [&str; 10] = [
    "block",
    "block_nurbs",
    "cone",
    "cone_nurbs",
    "cylinder",
    "cylinder_nurbs",
    "cylinder_slanted",
    "cylinder_slanted_nurbs",
    "frustum",
    "frustum_nurbs",
];

/// Of one of their ends, at height 0, the kernel's bound is narrower than the oracle's (some 2^-147 and 2^-202): the answer would be indeterminate.
const KNOWN_TOO_WELL: [&str; 2] = ["parts/nozzle.json.gz", "parts/nozzle_nurbs.json.gz"];

/// Half-spaces that stand on parts: along each axis, from both sides, flush with the vertices that are farthest out. Most of them have a face there.
pub(crate) fn flush(corpus: &Path) -> Result<Suite, String> {
    let thesis = THESIS_NURBS.iter().chain(&THESIS_NATIVE);
    let names = { thesis.map(|p| format!("thesis/{p}.3dm")) }
        .chain(PARTS.iter().map(|p| format!("parts/{p}.json.gz")))
        .chain(WITH_ENDS.iter().map(|p| format!("analytic/{p}.json.gz")));
    let mut scenes = Vec::new();
    for name in names {
        let model = load(corpus, &name)?;
        let vertices = { model.breps.iter() }.flat_map(|b| &b.parts().vertices);
        let vertices: Vec<_> = vertices.map(|v| v.point.coords).collect();
        let mut queries = Vec::new();
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            for normal in [axis, -axis] {
                // Of an axis that is exact.
                let heights = vertices.iter().map(|v| normal.dot(v));
                let offset = heights.fold(f64::INFINITY, f64::min);
                if normal == Vector3::z() && KNOWN_TOO_WELL.contains(&name.as_str()) {
                    continue;
                }
                queries.push(QueryLine {
                    half_space: Some(HalfSpaceLine {
                        normal: normal.into(),
                        offset,
                    }),
                    ..QueryLine::default()
                });
            }
        }
        scenes.push(Scene {
            queries,
            name,
            breps: Vec::new(),
        });
    }
    Ok(Suite {
        name: "flush",
        description: "half-spaces along the axes, flush with the vertices of a part that are farthest out: most rest on a face, and its border bulges by roundings",
        scenes,
    })
}

/// Faces whose loops have 100 to 1,024 pieces.
const MANY_PIECES: [&str; 5] = [
    "trim-loops/comb_128_anisotropic.json.gz",
    "trim-loops/cubics_512.json.gz",
    "trim-loops/holes_100_arcs.json.gz",
    "trim-loops/polygon_1024.json.gz",
    "trim-loops/rational_cubics_512.json.gz",
];

/// Balls and half-spaces next to faces whose loops have many pieces, half of them near these: the deepest contact and all.
pub(crate) fn many_pieces(corpus: &Path) -> Result<Suite, String> {
    const EACH: [(MakeQuery, usize); 3] = [
        (|g, near| g.sphere(near), 12),
        (|g, near| g.half_space(near), 4),
        (|g, near| g.contacts(near), 4),
    ];
    let mut scenes = Vec::new();
    for name in MANY_PIECES {
        let model = load(corpus, name)?;
        let mut generator = Generator::new(&model, &format!("many pieces {name}"));
        let mut queries = Vec::new();
        for (ask, count) in EACH {
            queries.extend((0..count).map(|i| ask(&mut generator, i % 2 == 0)));
        }
        scenes.push(Scene {
            queries,
            name: name.to_owned(),
            breps: Vec::new(),
        });
    }
    Ok(Suite {
        name: "many-pieces",
        description: "contacts, one and all, with faces whose loops have 100 to 1,024 pieces: a comb, holes, a polygon, wavy splines",
        scenes,
    })
}

/// Of each part, of the lines that [`round_lines`] makes.
const ROUND_EACH: usize = 22;
/// Where lines pass, as parts of the model's box.
const PLACES: [f64; 4] = [0.0, 0.25, 0.5, 1.0];
/// The box is rounded to this many parts of a unit: of the thesis's parts most numbers are then what was drawn.
const PARTS_OF_UNIT: f64 = 1e9;

/// Lines in round numbers: along axes and diagonals, through the middle, in the planes of faces, along edges and rulings, tangent.
pub(crate) fn round_lines(corpus: &Path) -> Result<Suite, String> {
    let mut scenes = Vec::new();
    for part in THESIS_NATIVE.into_iter().chain(THESIS_NURBS) {
        let name = format!("thesis/{part}.3dm");
        let model = load(corpus, &name)?;
        let mut random = Random::new(&format!("round lines {part}"));
        let mut all = lattice(&bounds(&model)?);
        let mut queries = Vec::new();
        for _ in 0..ROUND_EACH.min(all.len()) {
            let mut line = all.swap_remove(random.below(all.len()));
            // One in eight moved by one unit in the last place.
            if random.below(8) == 0 {
                let k = random.below(3);
                line.origin[k] = if random.sign() > 0.0 {
                    line.origin[k].next_up()
                } else {
                    line.origin[k].next_down()
                };
            }
            queries.push(QueryLine {
                line: Some(line),
                ..QueryLine::default()
            });
        }
        scenes.push(Scene {
            name,
            breps: Vec::new(),
            queries,
        });
    }
    Ok(Suite {
        name: "line-round",
        description: "lines in round numbers: along axes and diagonals, through axes, along rulings and edges, in the planes of faces, tangent; \
                      one in eight moved by a unit in the last place",
        scenes,
    })
}

/// The model's box, rounded.
fn bounds(model: &Model) -> Result<[[f64; 2]; 3], String> {
    let mut out = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for brep in &model.breps {
        let prepared = PreparedBrep::new(brep.clone());
        for (k, own) in out.iter_mut().enumerate() {
            for sign in [1.0, -1.0] {
                let mut normal = Vector3::zeros();
                normal[k] = sign;
                let probe = HalfSpace::new(normal, 0.0).map_err(|e| e.to_string())?;
                let options = Options {
                    contacts: Contacts::None,
                    ..Options::default()
                };
                let mut workspace = Workspace::default();
                let answer = contact(
                    &prepared,
                    &Probe::HalfSpace(probe),
                    &options,
                    &mut workspace,
                );
                let end = sign * answer.separation.value;
                let end = (end * PARTS_OF_UNIT).round() / PARTS_OF_UNIT;
                *own = [own[0].min(end), own[1].max(end)];
            }
        }
    }
    Ok(out)
}

/// Lines along each axis through a grid of places, and along diagonals through the middle of sections.
fn lattice(bounds: &[[f64; 2]; 3]) -> Vec<LineLine> {
    let at = |k: usize, part: f64| bounds[k][0] + part * (bounds[k][1] - bounds[k][0]);
    let mut out = Vec::new();
    for k in 0..3 {
        let (a, b) = ((k + 1) % 3, (k + 2) % 3);
        for first in PLACES {
            for second in PLACES {
                let (mut origin, mut direction) = ([0.0; 3], [0.0; 3]);
                (origin[a], origin[b]) = (at(a, first), at(b, second));
                origin[k] = bounds[k][0] - 1.0;
                // As a segment it ends within the model or on its border.
                let n = out.len();
                direction[k] = if n % 3 == 2 {
                    1.0 + 0.5 * (bounds[k][1] - bounds[k][0])
                } else {
                    1.0
                };
                let kind = [LineKindLine::Line, LineKindLine::Ray, LineKindLine::Segment][n % 3];
                out.push(LineLine {
                    origin,
                    direction,
                    kind,
                });
            }
            for turned in [1.0, -1.0] {
                let (mut origin, mut direction) = ([0.0; 3], [0.0; 3]);
                (origin[a], origin[b], origin[k]) = (at(a, 0.5), at(b, 0.5), at(k, first));
                (direction[a], direction[b]) = (1.0, turned);
                out.push(LineLine {
                    origin,
                    direction,
                    kind: LineKindLine::Line,
                });
            }
        }
    }
    out
}

fn graze(generator: &mut Generator<'_>, i: usize) -> QueryLine {
    let aim = generator.target(i.is_multiple_of(3));
    let size = generator.size();
    let random = &mut generator.random;
    let across = random.direction();
    let tangent = (across - aim.normal * across.dot(&aim.normal)).normalize();
    let off = match random.below(NEAR.len() + 4) {
        0 => 0.0,
        k if k <= NEAR.len() => NEAR[k - 1],
        k => [1e-5, 1e-4, 1e-3][k - NEAR.len() - 1],
    };
    let at = aim.point + aim.normal * (off * size * random.sign());
    let direction = tangent * (size * random.between(0.1, 1.0));
    let kind = [LineKindLine::Line, LineKindLine::Ray, LineKindLine::Segment];
    QueryLine {
        line: Some(LineLine {
            origin: (at - direction * random.between(0.3, 0.7)).coords.into(),
            direction: direction.into(),
            kind: kind[random.below(3)],
        }),
        ..QueryLine::default()
    }
}

/// Radii of the thesis's balls in the socket of radius 2.5 (mm).
const BALLS: [f64; 5] = [2.472, 2.49, 2.5, 2.51, 2.52];
/// How far the ball moves from the socket's centre at most (mm).
const PLAY: f64 = 0.05;
const SOCKETS: [&str; 4] = [
    "ball_joint_cavity_nurbs",
    "ball_joint_socket_nurbs",
    "ball_joint_cavity",
    "ball_joint_socket",
];

/// Balls in the spherical sockets: at the centre, near it, and off it.
pub(crate) fn ball_joint() -> Suite {
    let mut random = Random::new("thesis");
    let mut scenes = Vec::new();
    for part in SOCKETS {
        let mut queries = Vec::new();
        for radius in BALLS {
            let offsets = std::iter::once(0.0)
                .chain(NEAR)
                .chain([1e-4, 1e-3, 0.01, PLAY]);
            for offset in offsets {
                let center = random.direction() * offset;
                queries.push(QueryLine {
                    sphere: Some(SphereLine {
                        center: center.into(),
                        radius,
                    }),
                    ..QueryLine::default()
                });
            }
        }
        scenes.push(Scene {
            name: format!("thesis/{part}.3dm"),
            breps: Vec::new(),
            queries,
        });
    }
    Suite {
        name: "thesis",
        description: "balls of the thesis's ball joint, as NURBS and native, centred and moved by 1e-15 to 0.05 mm: the focal set of the socket",
        scenes,
    }
}
