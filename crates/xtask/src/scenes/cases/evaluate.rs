//! E: evaluation.

use super::super::shapes::patch;
use super::super::stress::{spline, weighted, whole};
use super::{Maker, evaluate_at};

/// Places in the unit square, none on a simple fraction but the last four.
const PLACES: [[f64; 2]; 12] = [
    [0.123, 0.321],
    [0.877, 0.111],
    [0.4, 0.6],
    [0.05, 0.95],
    [0.99, 0.98],
    [0.31, 0.77],
    [0.66, 0.02],
    [0.001, 0.499],
    [0.5, 0.5],
    [0.0, 1.0],
    [1.0, 0.25],
    [1.0, 1.0],
];

pub(super) fn add(m: &mut Maker) -> Result<(), String> {
    let everywhere = |m: &mut Maker, model: &str, id: &str, scale: [f64; 2]| {
        for uv in PLACES {
            m.ask(model, id, evaluate_at([uv[0] * scale[0], uv[1] * scale[1]]));
        }
    };
    for (name, ratio) in [("1", 1.0), ("1e3", 1e3), ("1e6", 1e6), ("1e12", 1e12)] {
        let model = format!("E1_{name}");
        m.model(&model, weighted("E1", [3, 3], &[1.0, ratio, 1.0 / ratio])?);
        let id = if ratio == 1.0 {
            "E1 easy".to_owned()
        } else {
            format!("E1 ratio={name}")
        };
        everywhere(m, &model, &id, [1.0; 2]);
    }
    let half = 0.5f64;
    for (name, next) in [
        ("easy", 0.75),
        ("1e-6", half + 1e-6),
        ("1e-9", half + 1e-9),
        ("1e-12", half + 1e-12),
        ("1ulp", half.next_up()),
    ] {
        let model = format!("E3_{name}");
        m.model(&model, spline("E3", &[half, next], [0.0; 3], [1.0; 3])?);
        let id = if name == "easy" {
            "E3 easy".to_owned()
        } else {
            format!("E3 span={name}")
        };
        for u in [
            half.next_down(),
            half,
            0.5 * (half + next),
            next,
            next.next_up(),
            0.25,
            0.875,
        ] {
            m.ask(&model, &id, evaluate_at([u, 0.375]));
        }
    }
    m.model("E4", spline("E4", &[0.5; 3], [0.0; 3], [1.0; 3])?);
    for u in [half.next_down(), half, half.next_up()] {
        m.ask("E4", "E4 at the knot", evaluate_at([u, 0.375]));
        m.ask("E4", "E4 easy", evaluate_at([u - 0.25, 0.375]));
    }
    for p in [1, 2, 3, 5, 8, 13, 19, 25] {
        let model = format!("E6_{p}");
        m.model(&model, weighted("E6", [p, 3], &[1.0])?);
        let id = if p == 3 {
            "E6 easy".to_owned()
        } else {
            format!("E6 p={p}")
        };
        everywhere(m, &model, &id, [1.0; 2]);
    }
    m.model("E8", spline("E8", &[0.5], [1e9, -1e9, 1e9], [1e-6; 3])?);
    everywhere(m, "E8", "E8 1e9", [1.0; 2]);
    m.model("E8_near", spline("E8", &[0.5], [0.0; 3], [1e-6; 3])?);
    everywhere(m, "E8_near", "E8 easy", [1.0; 2]);
    m.model("E9", spline("E9", &[0.5], [0.0; 3], [1e6, 1e-6, 1.0])?);
    everywhere(m, "E9", "E9 1e6 by 1e-6", [1.0; 2]);
    m.model("E9_even", spline("E9", &[0.5], [0.0; 3], [1.0; 3])?);
    everywhere(m, "E9_even", "E9 easy", [1.0; 2]);
    for u in [0.0, 0.25, 0.5, 1.0] {
        m.ask(
            "stress/octant.json.gz",
            "E10 at the pole",
            evaluate_at([u, 1.0]),
        );
        m.ask(
            "stress/octant.json.gz",
            "E10 1ulp",
            evaluate_at([u, 1f64.next_down()]),
        );
        m.ask("stress/octant.json.gz", "E10 easy", evaluate_at([u, 0.5]));
        m.ask(
            "stress/triple_points.json.gz",
            "E11 no derivative",
            evaluate_at([0.0, u]),
        );
        m.ask(
            "stress/triple_points.json.gz",
            "E11 beside",
            evaluate_at([1e-9, u]),
        );
        m.ask(
            "stress/triple_points.json.gz",
            "E11 easy",
            evaluate_at([0.5, u]),
        );
    }
    let (unclamped, clamped) = (
        "thesis/cylinder_nurbs_unclamped.3dm",
        "thesis/cylinder_nurbs.3dm",
    );
    for u in [0.0, 0.1, 1.0, 2.0, 3.0, 5.0, 6.0] {
        m.ask(unclamped, "E12 unclamped", evaluate_at([u, 1.0]));
        m.ask(clamped, "E12 easy", evaluate_at([u, 1.0]));
    }
    for (name, scale) in [("1e-310", 1e-310), ("easy", 1.0)] {
        let model = format!("E13_{name}");
        m.model(
            &model,
            whole(patch([2, 2], |i, j| {
                (
                    [i as f64 * scale, j as f64 * scale, (i * j) as f64 * scale],
                    1.0,
                )
            })?)?,
        );
        let id = if scale == 1.0 {
            "E13 easy"
        } else {
            "E13 1e-310"
        };
        everywhere(m, &model, id, [1.0; 2]);
    }
    Ok(())
}
