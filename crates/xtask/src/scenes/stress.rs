//! The suite `stress`: surfaces and solids that are hard on arithmetic.

use super::shapes::{bilinear, patch};
use super::{Scene, Suite};
use crate::generate::{Generator, NEAR};
use crate::random::Random;
use feeler::brep::{Brep, BrepBuilder};
use feeler::nurbs::{NurbsSurface, Surface};
use feeler_corpus::{LineLine, Model, QueryLine, SphereLine};
use nalgebra::{Point3, Vector3, Vector4};
use std::path::PathBuf;

const DESCRIPTION: &str = "weights of 1e-12 to 1e12, degree 25, knots that nearly or fully break the surface, poles, collapsed edges, coordinates of 1e9, \
     1e6 by 1e-6, saddles with lines in them, evolutes, walls of 1e-3 to 1e-9, pyramids of 3 to 20 sides";

/// A height for control point (i, j), a multiple of 2^-20.
fn height(random: &mut Random, scale: f64) -> f64 {
    const GRID: f64 = (1u64 << 20) as f64;
    (random.between(-scale, scale) * GRID).round() / GRID
}

/// A patch of heights over a square with these weights.
pub(crate) fn weighted(name: &str, degrees: [usize; 2], weights: &[f64]) -> Result<Brep, String> {
    let mut random = Random::new(name);
    let mut table = Vec::new();
    for _ in 0..=degrees[0] {
        for _ in 0..=degrees[1] {
            table.push((
                height(&mut random, 0.5),
                weights[random.below(weights.len())],
            ));
        }
    }
    whole(patch(degrees, |i, j| {
        let (z, w) = table[i * (degrees[1] + 1) + j];
        (
            [
                4.0 * i as f64 / degrees[0] as f64,
                4.0 * j as f64 / degrees[1] as f64,
                z,
            ],
            w,
        )
    })?)
}

pub(crate) fn whole(surface: Surface) -> Result<Brep, String> {
    Brep::from_surface(surface).map_err(|e| e.to_string())
}

/// A bicubic spline of heights; knots along u as given, along v one span.
pub(crate) fn spline(
    name: &str,
    inner: &[f64],
    offset: [f64; 3],
    scale: [f64; 3],
) -> Result<Brep, String> {
    let mut random = Random::new(name);
    let count = 4 + inner.len();
    let mut ku = vec![0.0; 4];
    ku.extend(inner);
    ku.extend([1.0; 4]);
    let kv = [[0.0; 4], [1.0; 4]].concat();
    let mut net = Vec::new();
    for i in 0..count {
        for j in 0..4 {
            let p = [i as f64, j as f64, height(&mut random, 0.8)];
            let c = |k: usize| offset[k] + scale[k] * p[k];
            net.push(Vector4::new(c(0), c(1), c(2), 1.0));
        }
    }
    let made = NurbsSurface::new([3, 3], [count, 4], net, [ku, kv]);
    whole(Surface::Nurbs(made.map_err(|e| e.to_string())?))
}

/// An eighth of a sphere (up to rounding), rational biquadratic, one side a pole.
fn octant() -> Result<Brep, String> {
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let ring = |r: f64, z: f64| [[r, 0.0, z], [r, r, z], [0.0, r, z]];
    let rows = [ring(2.0, 0.0), ring(2.0, 2.0), ring(0.0, 2.0)];
    let w = [1.0, h, 1.0];
    whole(patch([2, 2], |i, j| (rows[j][i], w[i] * w[j]))?)
}

/// z = x^2 / 2 over [-1, 1] x [0, 1]: the line x = 0, z = 1 is on its evolute.
fn parabola() -> Result<Brep, String> {
    let profile = [[-1.0, 0.5], [0.0, -0.5], [1.0, 0.5]];
    whole(patch([2, 1], |i, j| {
        ([profile[i][0], j as f64, profile[i][1]], 1.0)
    })?)
}

/// The first three rows of control points in one place: no first derivative along u there.
fn triple_points() -> Result<Brep, String> {
    let mut random = Random::new("triple_points");
    let z: Vec<f64> = (0..16).map(|_| height(&mut random, 0.5)).collect();
    whole(patch([3, 3], |i, j| {
        let row = i.saturating_sub(2);
        let z = if row == 0 { z[j] } else { z[4 * i + j] };
        ([3.0 * row as f64, j as f64, z], 1.0)
    })?)
}

/// A pyramid over `n` corners on a circle-like polygon with coordinates of few bits; the apex is a vertex of n edges.
fn pyramid(n: usize) -> Result<Brep, String> {
    let mut b = BrepBuilder::new();
    let apex = b.vertex([0.0, 0.0, 2.0]);
    let ring: Vec<usize> = (0..n)
        .map(|i| {
            let angle = super::loops::TURN * (i as f64) / n as f64;
            let [x, y] = super::loops::polar([0.0, 0.0], 3.0, angle);
            b.vertex([x, y, 0.0])
        })
        .collect();
    let fail = |e: feeler::brep::BuildError| e.to_string();
    let below: Vec<usize> = ring.iter().rev().copied().collect();
    b.planar_face(&below).map_err(fail)?;
    for i in 0..n {
        b.planar_face(&[ring[i], ring[(i + 1) % n], apex])
            .map_err(fail)?;
    }
    b.build().map_err(fail)
}

/// A box from corner to corner; inward: the same as a cavity.
pub(crate) fn block(
    b: &mut BrepBuilder,
    from: [f64; 3],
    to: [f64; 3],
    inward: bool,
) -> Result<(), String> {
    let v: Vec<usize> = (0..8)
        .map(|i| {
            let c = |k: usize| if i >> k & 1 == 0 { from[k] } else { to[k] };
            b.vertex([c(0), c(1), c(2)])
        })
        .collect();
    for mut corners in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [1, 3, 7, 5],
        [3, 2, 6, 7],
        [2, 0, 4, 6],
    ] {
        if inward {
            corners.reverse();
        }
        b.planar_face(&corners.map(|k| v[k]))
            .map_err(|e| e.to_string())?;
    }
    Ok(())
}

fn slab(thickness: f64) -> Result<Brep, String> {
    let mut b = BrepBuilder::new();
    block(&mut b, [0.0; 3], [4.0, 3.0, thickness], false)?;
    b.build().map_err(|e| e.to_string())
}

/// A closed box with walls this thin.
fn hollow(wall: f64) -> Result<Brep, String> {
    let mut b = BrepBuilder::new();
    block(&mut b, [0.0; 3], [4.0, 3.0, 2.0], false)?;
    block(
        &mut b,
        [wall; 3],
        [4.0 - wall, 3.0 - wall, 2.0 - wall],
        true,
    )?;
    b.build().map_err(|e| e.to_string())
}

fn models() -> Result<Vec<(&'static str, Brep)>, String> {
    let one = f64::EPSILON / 2.0;
    Ok(vec![
        (
            "weights_1e3",
            weighted("weights_1e3", [3, 3], &[1e-3, 1.0, 1e3])?,
        ),
        (
            "weights_1e6",
            weighted("weights_1e6", [3, 3], &[1e-6, 1.0, 1e6])?,
        ),
        (
            "weights_1e12",
            weighted("weights_1e12", [3, 3], &[1e-12, 1.0, 1e12])?,
        ),
        (
            "weights_1e12_quadratic",
            weighted("quadratic", [2, 2], &[1e-12, 1e-6, 1.0, 1e6, 1e12])?,
        ),
        ("degree_9", weighted("degree_9", [9, 9], &[1.0])?),
        ("degree_25_by_3", weighted("degree_25", [25, 3], &[1.0])?),
        (
            "broken_knots",
            spline(
                "broken_knots",
                &[0.25, 0.25, 0.25, 0.5, 0.5],
                [0.0; 3],
                [1.0; 3],
            )?,
        ),
        (
            "near_knots",
            spline(
                "near_knots",
                &[0.5 - 1e-9, 0.5, 0.5 + one, 0.5 + 1e-12],
                [0.0; 3],
                [1.0; 3],
            )?,
        ),
        (
            "far",
            spline("far", &[0.3, 0.6], [1e9, -1e9, 1e9], [1.0; 3])?,
        ),
        (
            "flat_and_long",
            spline("flat_and_long", &[0.5], [0.0; 3], [1e6, 1.0, 1e-6])?,
        ),
        ("octant", octant()?),
        ("parabola", parabola()?),
        ("triple_points", triple_points()?),
        ("saddle", whole(bilinear()?)?),
        ("pyramid_3", pyramid(3)?),
        ("pyramid_7", pyramid(7)?),
        ("pyramid_20", pyramid(20)?),
        ("slab_1e-3", slab(1e-3)?),
        ("slab_1e-6", slab(1e-6)?),
        ("slab_1e-9", slab(1e-9)?),
        ("hollow_1e-3", hollow(1e-3)?),
        ("hollow_1e-9", hollow(1e-9)?),
    ])
}

/// What is asked of one model alone.
fn special(name: &str, random: &mut Random) -> Vec<QueryLine> {
    let ball = |center: Point3<f64>, radius: f64| QueryLine {
        sphere: Some(SphereLine {
            center: center.coords.into(),
            radius,
        }),
        ..QueryLine::default()
    };
    let line = |origin: Point3<f64>, direction: Vector3<f64>| QueryLine {
        line: Some(LineLine {
            origin: origin.coords.into(),
            direction: direction.into(),
            kind: Default::default(),
        }),
        ..QueryLine::default()
    };
    let mut lines = Vec::new();
    let mut off = |i: usize| {
        let by = if i.is_multiple_of(4) {
            0.0
        } else {
            NEAR[i % NEAR.len()]
        };
        random.direction() * by
    };
    let kind = name.split('_').next().unwrap_or(name);
    match kind {
        // On the evolute, where the minimum is of fourth order.
        "parabola" => {
            for i in 0..30 {
                let y = f64::from(i as u32 % 5) / 4.0;
                lines.push(ball(Point3::new(0.0, y, 1.0) + off(i), 1.0));
            }
        }
        "octant" => {
            for i in 0..30 {
                lines.push(ball(Point3::origin() + off(i), [2.0, 1.0][i % 2]));
                lines.push(line(Point3::new(0.0, 0.0, 2.0) + off(i), Vector3::z()));
            }
        }
        // In the surface: its rulings, and lines beside them.
        "saddle" => {
            for i in 0..30 {
                let s = [0.0, 0.25, 0.5, 0.75, 1.0][i % 5];
                let z = |u: f64, v: f64| {
                    0.25 * ((1.0 - u) * (1.0 - v) + u * v) - 0.125 * (u * (1.0 - v) + (1.0 - u) * v)
                };
                let (a, b) = if i % 2 == 0 {
                    (
                        Point3::new(s, 0.0, z(s, 0.0)),
                        Point3::new(s, 1.0, z(s, 1.0)),
                    )
                } else {
                    (
                        Point3::new(0.0, s, z(0.0, s)),
                        Point3::new(1.0, s, z(1.0, s)),
                    )
                };
                let off = if i < 10 { Vector3::zeros() } else { off(i) };
                lines.push(line(a + off, b - a));
            }
        }
        // At the apex, above and below, and lines through it.
        "pyramid" => {
            for i in 0..24 {
                let z = [2.5, 1.0, 2.0][i % 3];
                lines.push(ball(Point3::new(0.0, 0.0, z) + off(i), 0.5));
                let apex = Point3::new(0.0, 0.0, 2.0) + off(i);
                let across = Vector3::new(1.0, 0.25 * (i % 5) as f64, 0.0);
                lines.push(line(apex, [Vector3::z(), across][i % 2]));
            }
        }
        // Between the two sides of a wall.
        "slab" | "hollow" => {
            let wall = match name.rsplit('_').next() {
                Some("1e-3") => 1e-3,
                Some("1e-6") => 1e-6,
                _ => 1e-9,
            };
            for i in 0..24 {
                let z = wall * [0.5, 0.25, 0.0, 1.0, -1.0, 2.0][i % 6];
                let at = Point3::new(1.0 + 0.125 * i as f64, 1.5, z);
                lines.push(ball(at, [0.0, wall, 0.1][i % 3]));
                lines.push(line(at, Vector3::new(1.0, 0.5, [0.0, wall, 1.0][i % 3])));
            }
        }
        _ => {}
    }
    lines
}

pub(crate) fn suite() -> Result<Suite, String> {
    let mut scenes = Vec::new();
    for (name, brep) in models()? {
        let model = Model {
            path: PathBuf::new(),
            breps: vec![brep.clone()],
        };
        let mut generator = Generator::new(&model, name);
        let mut queries = Vec::new();
        for i in 0..24 {
            let near = i % 2 == 0;
            // Some queries of these take the oracle minutes.
            if name != "weights_1e12" {
                queries.push(generator.sphere(near));
            }
            if !name.starts_with("degree") || i % 12 == 0 {
                queries.push(generator.line(near));
            }
            if i % 2 == 0 {
                queries.push(generator.half_space(i % 4 == 0));
                queries.push(generator.evaluate(i % 4 == 0));
                queries.push(generator.side(i % 4 == 0));
            }
            if brep.is_closed() {
                queries.push(generator.inside(near));
            }
        }
        let mut random = Random::new(&format!("special {name}"));
        queries.extend(special(name, &mut random));
        scenes.push(Scene {
            name: name.to_owned(),
            breps: vec![brep],
            queries,
        });
    }
    Ok(Suite {
        name: "stress",
        description: DESCRIPTION,
        scenes,
    })
}
