//! F: what CAD kernels are known to get wrong, as scenes of our own.

use super::super::loops::circle;
use super::super::shapes::{face_of, unit_plane};
use super::super::stress::block;
use super::{Maker, ball, inside, line, side};
use feeler::brep::{Brep, BrepBuilder};
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve, Curve3, Plane, Revolution, Surface};
use feeler_corpus::{LineKindLine, LineLine, QueryLine};
use nalgebra::{Point3, Vector3};
use std::f64::consts::{FRAC_PI_2, TAU};

fn solid(from: [f64; 3], to: [f64; 3]) -> Result<Brep, String> {
    let mut b = BrepBuilder::new();
    block(&mut b, from, to, false)?;
    b.build().map_err(|e| e.to_string())
}

fn interval(start: f64, end: f64) -> Interval {
    Interval { start, end }
}

/// Disc of radius 1 with a hole of radius 1/2 about its origin.
fn ring(origin: [f64; 3], y: Vector3<f64>) -> Result<Brep, String> {
    let range = [interval(-1.0, 1.0); 2];
    let plane = Surface::Plane(Plane {
        origin: Point3::from(origin),
        x: Vector3::x(),
        y,
        domain: range,
        extents: range,
    });
    let loops = vec![
        circle([0.0; 2], 1.0, 1, false),
        circle([0.0; 2], 0.5, 1, true),
    ];
    face_of(plane, Some(&loops))
}

/// The sphere of radius 2 about the origin, as one turn of half a circle.
fn sphere() -> Result<Surface, String> {
    let half = Arc::new(Arc {
        center: Point3::origin(),
        x: Vector3::x(),
        y: Vector3::z(),
        z: -Vector3::y(),
        radius: 2.0,
        angle: interval(-FRAC_PI_2, FRAC_PI_2),
        domain: interval(-FRAC_PI_2, FRAC_PI_2),
    })
    .map_err(|e| e.to_string())?;
    let turn = Revolution::new(Revolution {
        origin: Point3::origin(),
        axis: Vector3::z(),
        angle: interval(0.0, TAU),
        angle_domain: interval(0.0, TAU),
        profile: Curve3::Arc(half),
        transposed: false,
    });
    Ok(Surface::Revolution(turn.map_err(|e| e.to_string())?))
}

/// The copies of edges in space moved: what a file may hold, and no distance may be measured to.
fn with_edges_off(brep: &Brep, by: f64) -> Result<Brep, String> {
    let mut parts = brep.parts().clone();
    for curve in &mut parts.curves3 {
        if let Curve::Line(l) = curve {
            for end in [&mut l.from, &mut l.to] {
                *end += Vector3::new(by, -by, by);
            }
        }
    }
    Brep::new(parts).map_err(|e| e.to_string())
}

pub(super) fn add(m: &mut Maker) -> Result<(), String> {
    let parts = vec![solid([0.0; 3], [2.0; 3])?, solid([1.0; 3], [3.0; 3])?];
    m.models("F1", parts);
    for (id, at) in [
        ("F1 in both", [1.5, 1.5, 1.5]),
        ("F1 in both, aside", [1.875, 1.25, 1.375]),
        ("F1 in one, next to the other", [0.9375, 1.5, 1.5]),
        ("F1 over the crease", [2.25, 1.5, 2.5]),
        ("F1 easy", [4.0, 1.5, 2.25]),
    ] {
        m.ask("F1", id, ball(at, 0.25));
        m.ask("F1", id, inside(at));
    }
    m.ask(
        "F1",
        "F1 through both",
        line([-1.0, 1.25, 1.5], [1.0, 0.0, 0.0]),
    );
    m.ask("F1", "F1 easy", line([-1.0, 0.25, 0.5], [1.0, 0.0, 0.0]));

    let rings = vec![
        ring([0.0; 3], Vector3::y())?,
        ring([1.0, 0.0, 0.0], Vector3::z())?,
    ];
    m.models("F2", rings);
    for (id, at) in [
        ("F2 on both inner rims", [0.5, 0.0, 0.0]),
        ("F2 centre of one, rim of the other", [0.0, 0.0, 0.0]),
        ("F2 centre of the other, rim of one", [1.0, 0.0, 0.0]),
        ("F2 between", [0.25, 0.0, 0.0]),
        ("F2 over a centre", [1.0, 0.25, 0.0]),
        ("F2 over a rim", [0.5, 0.0, 0.125]),
        ("F2 easy", [-0.75, 0.125, 0.5]),
    ] {
        m.ask("F2", id, ball(at, 0.375));
    }

    for k in ["", "_nurbs"] {
        let model = format!("analytic/block{k}.json.gz");
        for (id, at) in [
            ("F3 in a face's plane", [3.0, 2.0, 3.0]),
            ("F3 in two", [3.0, 2.0, 5.5]),
            ("F3 diagonal to an edge", [4.0, 4.0, 3.0]),
            ("F3 diagonal to a vertex", [3.0, 3.0, 6.5]),
            ("F3 diagonal from inside", [1.0, 1.0, 4.5]),
            ("F3 easy", [0.5, 0.125, 3.0]),
        ] {
            m.ask(&model, id, inside(at));
        }
        let ray = |origin: [f64; 3], direction: [f64; 3]| QueryLine {
            line: Some(LineLine {
                origin,
                direction,
                kind: LineKindLine::Ray,
            }),
            ..QueryLine::default()
        };
        m.ask(
            &model,
            "F3 ray at an edge",
            ray([1.0, 1.0, 3.0], [1.0, 1.0, 0.0]),
        );
        m.ask(&model, "F3 easy", ray([1.0, 0.5, 3.0], [1.0, 0.25, 0.0]));
    }

    let holed = vec![
        circle([2.0; 2], 1.5, 1, false),
        circle([2.0; 2], 0.5, 1, true),
        circle([3.0, 2.0], 0.25, 1, true),
    ];
    m.model("F5", face_of(unit_plane([0.0; 2], [4.0; 2]), Some(&holed))?);
    for (id, uv) in [
        ("F5 in the hole of the ring", [3.0, 2.0]),
        ("F5 in the ring's own", [2.0, 2.0]),
        ("F5 on a rim", [3.25, 2.0]),
        ("F5 between them", [2.625, 2.0]),
        ("F5 beyond", [3.75, 2.0]),
        ("F5 easy", [1.0, 2.125]),
    ] {
        m.ask("F5", id, side(uv));
        m.ask("F5", id, ball([uv[0], uv[1], 0.125], 0.25));
    }

    // Along x and along y they graze the sphere of radius 2 about (0.5, -0.25, 1).
    for k in ["", "_nurbs"] {
        let model = format!("analytic/sphere{k}.json.gz");
        for (what, by) in [
            ("1e-3", 1e-3),
            ("1e-6", 1e-6),
            ("1e-9", 1e-9),
            ("1e-12", 1e-12),
        ] {
            for sign in [-1.0, 1.0] {
                let off = 2.0 * (1.0 + sign * by);
                let id = format!("F6 {what}");
                m.ask(&model, &id, inside([-3.0, -0.25, 1.0 + off]));
                m.ask(&model, &id, inside([0.5 + off, -4.0, 1.0]));
                m.ask(&model, &id, inside([0.5, -0.25, 1.0 + off]));
            }
        }
        m.ask(&model, "F6 easy", inside([0.75, 0.5, 1.5]));
    }

    let native = sphere()?;
    let nurbs = native.to_nurbs().map_err(|e| e.to_string())?;
    for (name, surface) in [("F7", native), ("F7_nurbs", Surface::Nurbs(nurbs.nurbs))] {
        m.model(name, face_of(surface, None)?);
        for (id, at) in [
            ("F7 off the centre", [0.25, -0.5, 0.125]),
            ("F7 at the seam", [2.25, 0.0, 0.5]),
            ("F7 over a pole", [0.0, 0.0, 2.25]),
            ("F7 in a pole", [0.0, 0.0, 1.75]),
            ("F7 easy", [-1.5, 2.0, 0.75]),
        ] {
            m.ask(name, id, ball(at, 0.375));
        }
        m.ask(name, "F7 easy", line([-4.0, 0.5, 0.25], [1.0, 0.0, 0.125]));
    }

    // OCCT measures to the copy, and errs by as much.
    const OFF: f64 = 8e-6;
    let exact = solid([-1.0, -2.0, 0.5], [2.0, 2.0, 5.5])?;
    m.model("F8", with_edges_off(&exact, OFF)?);
    for at in [[2.5, 2.25, 3.0], [2.0, 3.0, 6.0], [-1.5, -2.5, 0.25]] {
        m.ask("F8", "F8 at an edge", ball(at, 0.75));
        m.ask("analytic/block.json.gz", "F8 easy", ball(at, 0.75));
    }
    Ok(())
}
