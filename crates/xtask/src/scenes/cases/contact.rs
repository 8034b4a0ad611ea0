//! C: contacts and lines.
//!
//! Shapes and their measures are those of `analytic.rs` and `corpora/make_parts.py`: a sphere of radius 2 about
//! (0.5, -0.25, 1), a cylinder of radius 1.5 about x = 0.25, y = 0.5 from z = -1 to 4, a cone of radius 3 and height 4 on
//! the origin, a torus of radii 4 and 1 about (0.125, 0.25, -0.5), a block from (-1, -2, 0.5) to (2, 2, 5.5).

use super::super::loops::{circle, rectangle};
use super::super::shapes::{face_of, unit_plane};
use super::super::stress::block;
use super::{Maker, ball, half_space, line, ulps};
use feeler::brep::BrepBuilder;
use feeler_corpus::{ContactsLine, QueryLine};
use nalgebra::{Point3, Vector3};

/// Both forms of a model of `analytic`.
fn both(name: &str) -> [String; 2] {
    ["", "_nurbs"].map(|k| format!("analytic/{name}{k}.json.gz"))
}

const JOINT: [&str; 2] = [
    "thesis/ball_joint_cavity.3dm",
    "thesis/ball_joint_cavity_nurbs.3dm",
];
/// Radius of the joint's hole.
const HOLE: f64 = 2.5;

fn all_within(query: QueryLine, prediction: f64) -> QueryLine {
    QueryLine {
        contacts: Some(ContactsLine::All),
        prediction: Some(prediction),
        ..query
    }
}

fn vector(x: f64, y: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, y, z)
}

pub(super) fn add(m: &mut Maker) -> Result<(), String> {
    for joint in JOINT {
        for (what, clearance) in [("0", 0.0), ("1e-3", 1e-3), ("1e-9", 1e-9), ("1e-15", 1e-15)] {
            m.ask(
                joint,
                &format!("C1 clearance={what}"),
                ball([0.0; 3], HOLE - clearance),
            );
        }
        m.ask(joint, "C1 easy", ball([0.75, 0.5, -0.25], 1.0));
        for (what, e) in [
            ("1e-15", 1e-15),
            ("1e-12", 1e-12),
            ("1e-9", 1e-9),
            ("1e-6", 1e-6),
            ("1e-3", 1e-3),
            ("0.1", 0.1),
            ("0.9", 0.9),
        ] {
            for direction in [[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.48, 0.64, 0.6]] {
                let id = if e > 0.5 {
                    "C2 easy".to_owned()
                } else {
                    format!("C2 e={what} R")
                };
                m.ask(joint, &id, ball(direction.map(|x| x * e * HOLE), 2.0));
            }
        }
    }
    for (name, at, away) in [
        ("cylinder", [0.25, 0.5, 1.5], [0.75, 0.25, 1.5]),
        ("cone", [0.0, 0.0, 1.0], [0.5, 0.25, 1.0]),
        ("torus", [4.125, 0.25, -0.5], [4.5, 0.75, -0.25]),
        ("torus", [0.125, 0.25, -0.5], [1.0, 0.5, 0.5]),
    ] {
        for model in both(name) {
            m.ask(&model, "C3 on the axis", ball(at, 0.5));
            m.ask(
                &model,
                "C3 1e-9 off",
                ball([at[0] + 1e-9, at[1], at[2]], 0.5),
            );
            m.ask(&model, "C3 easy", ball(away, 0.5));
        }
    }
    for y in [0.125, 0.5, 0.875] {
        let parabola = "stress/parabola.json.gz";
        m.ask(parabola, "C4 on the evolute", ball([0.0, y, 1.0], 1.0));
        m.ask(parabola, "C4 1ulp", ball([0.0, y, ulps(1.0, 1)], 1.0));
        m.ask(parabola, "C4 1e-9", ball([0.0, y, 1.0 + 1e-9], 1.0));
        m.ask(parabola, "C4 easy", ball([0.0, y, 0.5], 0.25));
    }
    for model in both("block") {
        for k in [-4, -1, 0, 1, 4] {
            let at = [ulps(0.5, k), 0.0, 3.0];
            m.ask(
                &model,
                &format!("C5 k={k}"),
                all_within(ball(at, 1.5), 1e-3),
            );
        }
        m.ask(
            &model,
            "C5 easy",
            all_within(ball([1.5, 0.0, 3.0], 0.75), 1e-3),
        );
        // Outside an edge along z, and outside a face.
        for (d, r) in [(0.3, 0.5), (1e-9, 1e-9), (0.0, 0.25)] {
            m.ask(&model, "C6 edge", ball([2.0 + d, 2.0 + d, 3.0], r));
        }
        m.ask(&model, "C6 easy", ball([2.5, 0.5, 3.0], 0.6));
    }
    // Two sheets that meet at almost a straight angle.
    for (what, drop) in [("1e-3", 1e-3), ("1e-6", 1e-6), ("1e-9", 1e-9)] {
        let mut b = BrepBuilder::new();
        let ridge = [b.vertex([0.0, 0.0, 0.0]), b.vertex([0.0, 1.0, 0.0])];
        let left = [b.vertex([-1.0, 1.0, -drop]), b.vertex([-1.0, 0.0, -drop])];
        let right = [b.vertex([1.0, 0.0, -drop]), b.vertex([1.0, 1.0, -drop])];
        let fail = |e: feeler::brep::BuildError| e.to_string();
        b.planar_face(&[ridge[0], ridge[1], left[0], left[1]])
            .map_err(fail)?;
        b.planar_face(&[ridge[1], ridge[0], right[0], right[1]])
            .map_err(fail)?;
        let name = format!("C6_{what}");
        m.model(&name, b.build().map_err(fail)?);
        for x in [0.0, 1e-12, drop, 0.25] {
            m.ask(&name, &format!("C6 ridge {what}"), ball([x, 0.5, 0.5], 0.5));
        }
    }
    for n in [3, 7, 20] {
        let path = format!("stress/pyramid_{n}.json.gz");
        m.ask(&path, &format!("C7 {n} edges"), ball([0.0, 0.0, 2.5], 0.5));
        m.ask(
            &path,
            &format!("C7 {n} edges, 1e-9 off"),
            ball([1e-9, 0.0, 2.5], 0.5),
        );
        m.ask(&path, "C7 easy", ball([0.1, 0.0, -0.5], 0.6));
    }
    for model in both("cone") {
        m.ask(&model, "C7 apex", ball([0.0, 0.0, 4.5], 0.5));
        m.ask(&model, "C7 in the apex", ball([0.0, 0.0, 4.0], 0.0));
    }
    let plate = vec![
        rectangle([0.0; 2], [1.0; 2]),
        circle([0.5, 0.5], 0.25, 1, true),
    ];
    m.model(
        "plate",
        face_of(unit_plane([0.0; 2], [1.0; 2]), Some(&plate))?,
    );
    for z in [0.0, 0.1, 1.0] {
        m.ask(
            "plate",
            "C8 over the hole's centre",
            ball([0.5, 0.5, z], 0.25),
        );
        m.ask("plate", "C8 over the hole", ball([0.4, 0.45, z], 0.25));
        m.ask("plate", "C8 easy", ball([0.875, 0.875, z], 0.05));
        for k in [-1, 0, 1] {
            m.ask(
                "plate",
                &format!("C9 k={k}"),
                ball([ulps(0.75, k), 0.5, z + 0.01], 0.1),
            );
        }
        m.ask("plate", "C9 easy", ball([0.85, 0.5, z + 0.01], 0.1));
    }
    for model in both("block") {
        m.ask(&model, "C10 larger than all", ball([0.5, 0.0, 3.0], 100.0));
        m.ask(&model, "C10 past the middle", ball([0.4, 0.1, 2.9], 3.0));
        m.ask(&model, "C10 easy", ball([0.5, 0.0, 5.75], 0.5));
        for (what, gap) in [
            ("0", 0.0),
            ("+1ulp", f64::EPSILON / 2.0),
            ("-1ulp", -f64::EPSILON / 2.0),
            ("1e-9", 1e-9),
        ] {
            let query = half_space(vector(0.0, 0.0, 1.0), 0.5 + gap);
            m.ask(&model, &format!("C11 gap {what}"), query);
        }
        m.ask(&model, "C11 easy", half_space(vector(0.6, 0.0, 0.8), 0.25));
    }
    for model in both("cylinder") {
        for (what, tilt) in [("0", 0.0), ("1e-12", 1e-12), ("1e-6", 1e-6)] {
            let normal = vector(1.0, 0.0, tilt).normalize();
            m.ask(
                &model,
                &format!("C12 tilt {what}"),
                half_space(normal, -1.25),
            );
        }
        m.ask(&model, "C12 easy", half_space(vector(0.6, 0.0, 0.8), -2.0));
    }
    for tilt in [0.0, 1e-9, 0.1] {
        let normal = vector(tilt, 0.0, 1.0).normalize();
        let id = if tilt > 0.05 {
            "C13 easy".to_owned()
        } else {
            format!("C13 tilt {tilt:e}")
        };
        m.ask(
            "stress/saddle.json.gz",
            &id,
            all_within(half_space(normal, -0.2), 0.4),
        );
    }
    for model in both("sphere") {
        m.ask(&model, "C14 pole", half_space(vector(0.0, 0.0, 1.0), -1.0));
        m.ask(
            &model,
            "C14 pole above",
            half_space(vector(0.0, 0.0, -1.0), -3.0),
        );
        m.ask(&model, "C14 easy", half_space(vector(0.6, 0.0, 0.8), -1.5));
    }
    for model in both("cylinder") {
        m.ask(
            &model,
            "C15 generator",
            line([1.75, 0.5, 0.0], [0.0, 0.0, 1.0]),
        );
        m.ask(&model, "C15 easy", line([0.5, 0.5, 0.0], [0.0, 0.0, 1.0]));
    }
    for (what, by) in [
        ("0", 0.0),
        ("1e-16", 1e-16),
        ("1e-12", 1e-12),
        ("1e-8", 1e-8),
        ("0.1", 0.1),
    ] {
        for sign in [-1.0, 1.0] {
            let z = 1.0 + 2.0 * (1.0 + sign * by);
            let id = if by > 0.05 {
                "C16 easy".to_owned()
            } else {
                format!("C16 R(1{}{what})", if sign > 0.0 { "+" } else { "-" })
            };
            for model in both("sphere") {
                m.ask(&model, &id, line([-4.0, -0.25, z], [1.0, 0.0, 0.0]));
            }
            for model in both("cylinder") {
                let y = 0.5 + 1.5 * (1.0 + sign * by);
                m.ask(&model, &id, line([-4.0, y, 1.0], [1.0, 0.0, 0.0]));
            }
        }
    }
    for model in both("block") {
        m.ask(&model, "C17 edge", line([3.0, 1.0, 3.0], [-1.0, 1.0, 0.0]));
        m.ask(
            &model,
            "C17 through an edge",
            line([3.0, 3.0, 3.0], [-1.0, -1.0, 0.0]),
        );
        m.ask(
            &model,
            "C17 vertex",
            line([3.0, 3.0, 6.5], [-1.0, -1.0, -1.0]),
        );
        m.ask(
            &model,
            "C17 easy",
            line([3.0, 2.5, 6.0], [-1.0, -1.0, -1.0]),
        );
    }
    m.ask("plate", "C18 rim", line([0.75, 0.5, 1.0], [0.0, 0.0, -1.0]));
    m.ask(
        "plate",
        "C18 rim 1ulp",
        line([ulps(0.75, 1), 0.5, 1.0], [0.0, 0.0, -1.0]),
    );
    m.ask(
        "plate",
        "C18 easy",
        line([0.85, 0.5, 1.0], [0.0, 0.0, -1.0]),
    );
    for model in both("sphere") {
        m.ask(
            &model,
            "C18 poles",
            line([0.5, -0.25, 8.0], [0.0, 0.0, -1.0]),
        );
        m.ask(
            &model,
            "C18 seam",
            line([8.0, -0.25, 1.5], [-1.0, 0.0, 0.0]),
        );
        m.ask(&model, "C18 easy", line([8.0, 0.5, 1.5], [-1.0, 0.1, 0.0]));
    }
    for (what, r) in [("r=0", 0.0), ("easy", 0.5)] {
        m.ask(
            "analytic/block.json.gz",
            &format!("C19 {what}"),
            ball([3.0, 0.25, 3.0], r),
        );
    }
    for wall in ["1e-3", "1e-6", "1e-9"] {
        let path = format!("stress/slab_{wall}.json.gz");
        let t = match wall {
            "1e-3" => 1e-3,
            "1e-6" => 1e-6,
            _ => 1e-9,
        };
        for (k, z) in [(1, -t), (2, 0.25 * t), (3, 2.0 * t)] {
            m.ask(&path, &format!("C21 wall {wall}"), ball([1.0, 1.5, z], t));
            m.ask(&path, "C21 easy", ball([1.0, 1.5, 1.0 + f64::from(k)], 0.5));
        }
    }
    // The block of `analytic` in place and 1e9 away.
    for (what, off) in [("far", 1e9), ("near", 0.0)] {
        let mut b = BrepBuilder::new();
        let moved = |p: [f64; 3]| [p[0] + off, p[1] - off, p[2] + off];
        block(
            &mut b,
            moved([-1.0, -2.0, 0.5]),
            moved([2.0, 2.0, 5.5]),
            false,
        )?;
        let name = format!("C22_{what}");
        m.model(&name, b.build().map_err(|e| e.to_string())?);
        let id = if off == 0.0 {
            "C22 easy"
        } else {
            "C22 1e9 away"
        };
        for (center, r) in [
            ([2.5, 0.5, 3.0], 0.75),
            ([2.5, 2.5, 6.0], 0.75),
            ([1.5, 0.0, 3.0], 0.25),
        ] {
            m.ask(&name, id, ball(moved(center), r));
        }
        m.ask(
            &name,
            id,
            line(Point3::from(moved([3.0, 2.5, 6.0])), [-1.0, -1.0, -1.0]),
        );
    }
    for k in 0..6 {
        let at = [0.5 + 0.6 * f64::from(k), 2.0 - 0.3 * f64::from(k), 0.7];
        m.ask(
            "stress/weights_1e12_quadratic.json.gz",
            "C23 1e12",
            ball(at, 0.25),
        );
        m.ask("stress/weights_1e3.json.gz", "C23 easy", ball(at, 0.25));
    }
    Ok(())
}
