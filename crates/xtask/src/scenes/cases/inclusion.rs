//! I: sides in uv.

use super::super::loops::{Loops, circle, line as straight, polygon, rectangle, scenes};
use super::super::shapes::{face_of, unit_plane};
use super::super::trims::{at_joint, near};
use super::{Maker, inside, side, ulps};
use crate::random::Random;
use feeler::nurbs::Curve2;

type P = [f64; 2];

const UNIT: P = [1.0, 1.0];
/// Well inside or outside of most loops here.
const EASY: [P; 6] = [
    [0.51, 0.53],
    [0.3, 0.7],
    [0.7, 0.31],
    [0.02, 0.5],
    [0.98, 0.03],
    [0.4, 0.45],
];

fn face(m: &mut Maker, model: &str, loops: &Loops) -> Result<(), String> {
    m.model(model, face_of(unit_plane([0.0; 2], UNIT), Some(loops))?);
    Ok(())
}

/// The same loop gone the other way: straight trims only.
fn reversed(trims: &[Curve2]) -> Vec<Curve2> {
    let ends = trims.iter().rev().map(|c| {
        let span = c.domain();
        straight(c.point(span.end).into(), c.point(span.start).into())
    });
    ends.collect()
}

/// Queries about a scene of the suite `trim-loops`: half on or near its loops, or at the height of their joints.
fn as_there(m: &mut Maker, case: &str, what: &str, name: &str, joints: bool) {
    let path = format!("trim-loops/{name}.json.gz");
    let all = scenes();
    let Some(scene) = all.iter().find(|s| s.name == name) else {
        return;
    };
    let mut random = Random::new(&format!("{case} {name}"));
    for i in 0..16 {
        let uv = match &scene.loops {
            Some(l) if !l.is_empty() && joints => at_joint(l, UNIT, &mut random),
            Some(l) if !l.is_empty() => near(l, UNIT, &mut random),
            _ => [random.between(-0.1, 1.1), [0.0, 0.5, 1.0][i % 3]],
        };
        m.ask(&path, &format!("{case} {what}"), side(uv));
    }
    for uv in EASY {
        m.ask(&path, &format!("{case} easy"), side(uv));
    }
}

pub(super) fn add(m: &mut Maker) -> Result<(), String> {
    as_there(m, "I1", "joints", "polygon_16", true);
    as_there(m, "I1", "joints of cubics", "rational_cubics_8", true);
    // A circle whose topmost point is exact: (0.5, 0.75).
    let disc = vec![circle([0.5, 0.5], 0.25, 1, false)];
    face(m, "disc", &disc)?;
    for x in [0.1, 0.25, 0.4, 0.499, 0.6, 0.9] {
        m.ask("disc", "I2 at the top's height", side([x, 0.75]));
        m.ask("disc", "I2 easy", side([x, 0.55]));
    }
    face(m, "square", &vec![rectangle([0.25; 2], [0.75; 2])])?;
    for x in [0.1, 0.25, 0.4, 0.5, 0.75, 0.9] {
        m.ask("square", "I3 along a side", side([x, 0.25]));
        m.ask("square", "I3 easy", side([x, 0.4]));
    }
    for k in -4..=4 {
        m.ask("disc", &format!("I4 k={k}"), side([0.5, ulps(0.75, k)]));
        m.ask(
            "disc",
            &format!("I4 beside k={k}"),
            side([0.499_999, ulps(0.75, k)]),
        );
        m.ask("disc", "I4 easy", side([0.5, 0.7 + 0.01 * f64::from(k)]));
    }
    as_there(m, "I5", "near a curve", "cubics_8", false);
    as_there(m, "I5", "near arcs", "islands_arcs", false);
    for (case, gap) in [("I6", 1e-7), ("I7", -1e-7)] {
        // The first and third side end short of their joints, or beyond them.
        let (a, b) = (0.25 + gap, 0.75 - gap);
        let sides = vec![
            straight([0.25, 0.25], [b, 0.25]),
            straight([0.75, 0.25], [0.75, 0.75]),
            straight([0.75, 0.75], [a, 0.75]),
            straight([0.25, 0.75], [0.25, 0.25]),
        ];
        face(m, case, &vec![sides])?;
        let half = 0.5 * gap;
        for uv in [
            [0.75 - half, 0.25],
            [0.75 - half, 0.25 + 1e-9],
            [0.25 + half, 0.75],
            [0.25 + half, 0.75 - 1e-9],
        ] {
            m.ask(case, &format!("{case} in the gap"), side(uv));
        }
        for uv in EASY {
            m.ask(case, &format!("{case} easy"), side(uv));
        }
    }
    let (outer, hole) = (
        rectangle([0.1; 2], [0.9; 2]),
        polygon(&[[0.3, 0.3], [0.3, 0.7], [0.7, 0.7], [0.7, 0.3]]),
    );
    for k in 0..4 {
        let turn = |l: &Vec<Curve2>, t: bool| if t { reversed(l) } else { l.clone() };
        let name = format!("I8_{k}");
        face(
            m,
            &name,
            &vec![turn(&outer, k & 1 == 1), turn(&hole, k & 2 == 2)],
        )?;
        let id = if k == 0 {
            "I8 easy".to_owned()
        } else {
            format!("I8 turned {k}")
        };
        for uv in EASY.into_iter().chain([[0.1, 0.5], [0.3, 0.5], [0.2, 0.3]]) {
            m.ask(&name, &id, side(uv));
        }
    }
    as_there(m, "I9", "six deep", "islands_squares", false);
    as_there(m, "I9", "six deep, rational", "islands_rational", false);
    for name in [
        "shared_edge_exact",
        "shared_edge_apart",
        "shared_edge_overlapping",
    ] {
        as_there(m, "I10", name, name, false);
    }
    for name in ["figure_eight", "tangent_circles", "touching_vertices"] {
        as_there(m, "I11", name, name, true);
    }
    as_there(m, "I12", "a trim of no length", "mixture", true);
    // The rims of a cylinder close only around it; its trims run along the seam besides.
    for k in 0..8 {
        let height = [0.0, 1e-9, 1.0, 2.5][k % 4];
        let angle = [0.0, f64::EPSILON, 1.0, std::f64::consts::TAU][k / 2];
        m.ask(
            "analytic/cylinder.json.gz",
            "I14 near a rim",
            side([angle, height]),
        );
        m.ask(
            "analytic/cylinder.json.gz",
            "I14 easy",
            side([0.5 + 0.5 * k as f64, 2.0]),
        );
    }
    // The whole sphere is one face without an edge but its seam and poles.
    for k in 0..8 {
        let u = 0.75 * k as f64;
        let pole = [1f64, -1.0][k % 2] * std::f64::consts::FRAC_PI_2;
        m.ask("analytic/sphere.json.gz", "I15 at a pole", side([u, pole]));
        m.ask(
            "analytic/sphere.json.gz",
            "I15 beside a pole",
            side([u, ulps(pole, -2 * (k as i32 % 2) + 1)]),
        );
        m.ask(
            "analytic/sphere.json.gz",
            "I15 easy",
            side([u, 0.25 * pole]),
        );
        let z = 1.0 + pole.signum() * 2.0;
        m.ask(
            "analytic/sphere.json.gz",
            "I15 in space",
            inside([0.5, -0.25, z * (1.0 - 1e-12)]),
        );
    }
    as_there(m, "I16", "by 1e-9", "beyond_domain_1e-9", false);
    as_there(m, "I16", "by a tenth", "beyond_domain_tenth", false);
    as_there(m, "I17", "whole", "whole_domain", false);
    as_there(m, "I17", "nothing", "no_loops", false);
    as_there(m, "I18", "a comb of 200,000", "comb_50000", false);
    as_there(m, "I18", "65,536 cubics", "cubics_65536", false);
    as_there(m, "I19", "square", "twice_around", false);
    as_there(m, "I19", "circle", "twice_around_arcs", false);
    // Long and narrow: u in 1e-6, v in 1e6, by powers of two.
    let s = [1.0 / f64::from(1 << 20), f64::from(1 << 20)];
    let mut random = Random::new("I20");
    let path = "trim-loops/rational_cubics_8_anisotropic.json.gz";
    let all = scenes();
    let loops = all.iter().find(|l| l.name == "rational_cubics_8");
    if let Some(loops) = loops.and_then(|l| l.loops.as_ref()) {
        for _ in 0..16 {
            let uv = near(loops, UNIT, &mut random);
            m.ask(path, "I20 narrow", side([uv[0] * s[0], uv[1] * s[1]]));
            m.ask("trim-loops/rational_cubics_8.json.gz", "I20 easy", side(uv));
        }
    }
    Ok(())
}
