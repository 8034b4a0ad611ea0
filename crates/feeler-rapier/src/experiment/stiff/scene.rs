//! The socket and the seams.

use super::wall::{BrepWall, Closed, MeshWall, ThesisWall, Wall};
use super::{BALL, GRAVITY, HOLE, MASS};
use crate::experiment::world::{Edges, mesh_body};
use ::nalgebra::{Point3, Vector3, Vector4};
use feeler::brep::{Brep, BrepBuilder};
use feeler::nurbs::{NurbsSurface, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::Accuracy;
use feeler_corpus::Model;
use feeler_gate::{Engine, ThesisEngine};
use std::path::Path;
use std::sync::Arc;

/// Where and how a ball sets out.
pub(super) struct Scene {
    pub(super) name: &'static str,
    pub(super) truth: Closed,
    pub(super) at: Point3<f64>,
    pub(super) velocity: Vector3<f64>,
    /// Where gravity points, a unit.
    pub(super) down: Vector3<f64>,
    pub(super) rolls: bool,
    /// s.
    pub(super) time: f64,
    /// What changes of the energy are measured by, kg mm^2/s^2.
    pub(super) energy: f64,
    /// What is lost of it by right in steps that do not resolve the bounce off an edge.
    pub(super) loss: Option<f64>,
}

/// A wall under its name.
pub(super) struct Case {
    pub(super) name: String,
    pub(super) wall: Box<dyn Wall>,
}

fn mesh(brep: &Brep, degrees: f64) -> Result<Case, String> {
    let body = mesh_body(brep, degrees, Edges::Plain)?;
    Ok(Case {
        name: body.name,
        wall: Box::new(MeshWall(body.shape)),
    })
}

pub(super) mod socket {
    use super::*;

    /// How far from the bottom the ball sets out, radians.
    pub(in super::super) const FROM: f64 = std::f64::consts::FRAC_PI_3;
    /// Gravity, and the direction in which the ball is raised: units up to rounding, and askew to the sphere's
    /// poles, where triangles are slivers.
    const DOWN: Vector3<f64> = Vector3::new(0.36, 0.48, -0.8);
    const ASIDE: Vector3<f64> = Vector3::new(0.8, -0.6, 0.0);

    pub(in super::super) fn scene(rolls: bool) -> Scene {
        let length = HOLE - BALL;
        Scene {
            name: if rolls {
                "Rolling in the socket"
            } else {
                "Sliding in the socket"
            },
            truth: Closed::Socket { radius: HOLE },
            at: Point3::from((DOWN * FROM.cos() + ASIDE * FROM.sin()) * length),
            velocity: Vector3::zeros(),
            down: DOWN,
            rolls,
            time: 0.05,
            energy: MASS * GRAVITY * length * (1.0 - FROM.cos()),
            loss: None,
        }
    }

    fn load(models: &Path, name: &str) -> Result<Model, String> {
        let model = Model::load(&models.join("thesis").join(name), None);
        model.map_err(|e| e.to_string())
    }

    /// The part as NURBS.
    const NURBS: &str = "ball_joint_cavity_nurbs.3dm";

    pub(in super::super) fn part(models: &Path) -> Result<Brep, String> {
        let mut breps = load(models, NURBS)?.breps.into_iter();
        breps
            .next()
            .ok_or_else(|| format!("{NURBS}: no BREP in it"))
    }

    pub(in super::super) fn cases(
        models: &Path,
        meshes: &[f64],
        all: bool,
    ) -> Result<Vec<Case>, String> {
        let nurbs = load(models, NURBS)?;
        let native = load(models, "ball_joint_cavity.3dm")?;
        let prepared = |m: &Model| Arc::new(PreparedBrep::new(m.breps[0].clone()));
        let (own, closed) = (prepared(&nurbs), prepared(&native));
        let mut cases = Vec::new();
        let mut brep = |name: &str, brep, accuracy| {
            cases.push(Case {
                name: name.to_owned(),
                wall: Box::new(BrepWall::new(brep, accuracy)),
            });
        };
        brep("BREP, NURBS, full", &own, Accuracy::Full);
        if all {
            brep("BREP, NURBS, 1e-6 mm", &own, Accuracy::Length(1e-6));
            brep("BREP, NURBS, 1e-12 mm", &own, Accuracy::Length(1e-12));
            brep("BREP, native sphere, full", &closed, Accuracy::Full);
            let mut engine = ThesisEngine::new(100);
            engine.open(&nurbs)?;
            cases.push(Case {
                name: "thesis, NURBS".to_owned(),
                wall: Box::new(ThesisWall(engine)),
            });
        }
        for degrees in meshes {
            cases.push(mesh(&nurbs.breps[0], *degrees)?);
        }
        Ok(cases)
    }
}

pub(super) mod seam {
    use super::*;

    /// Half the width of the sheet, and its ends, mm: such that all control points are exact.
    const WIDTH: f64 = 4.0;
    const ENDS: [f64; 2] = [-12.0, 12.0];
    /// mm/s.
    const SPEED: f64 = 200.0;
    /// Slope of the C0 sheet, degrees.
    pub(in super::super) const SLOPE: f64 = 10.0;

    /// z = a x^p, such that no curve bends more than the ball.
    fn factor(power: i32) -> f64 {
        match power {
            1 => SLOPE.to_radians().tan(),
            2 => 1.0 / 16.0,
            _ => 1.0 / 32.0,
        }
    }

    /// The part of the sheet from one x to another on which z = a x^p, as a polynomial NURBS: over [0, X] all Bernstein coefficients
    /// of x^p but the last are 0.
    fn face(from: f64, to: f64, factor: f64, power: usize) -> Result<Surface, String> {
        let mut net = Vec::new();
        for i in 0..=power {
            let x = from + (to - from) * i as f64 / power as f64;
            let z = if i == power {
                factor * (to - from).powi(power as i32)
            } else {
                0.0
            };
            for y in [-WIDTH, WIDTH] {
                net.push(Vector4::new(x, y, z, 1.0));
            }
        }
        let knots = |degree: usize, a: f64, b: f64| [vec![a; degree + 1], vec![b; degree + 1]];
        let u = knots(power, from, to).concat();
        let v = knots(1, -WIDTH, WIDTH).concat();
        let made = NurbsSurface::new([power, 1], [power + 1, 2], net, [u, v]);
        made.map(Surface::Nurbs).map_err(|e| e.to_string())
    }

    pub(in super::super) fn sheet(power: i32) -> Result<Brep, String> {
        let mut builder = BrepBuilder::new();
        builder.whole_surface(face(ENDS[0], 0.0, 0.0, 1)?);
        builder.whole_surface(face(0.0, ENDS[1], factor(power), power as usize)?);
        builder.build().map_err(|e| e.to_string())
    }

    pub(in super::super) fn scene_and_cases(
        power: i32,
        meshes: &[f64],
    ) -> Result<(Scene, Vec<Case>), String> {
        let scene = Scene {
            name: match power {
                1 => "Over a C0 seam",
                2 => "Over a G1 seam",
                _ => "Over a G2 seam",
            },
            truth: Closed::Seam {
                factor: factor(power),
                power,
            },
            at: Point3::new(-3.0, 0.0, BALL),
            velocity: Vector3::new(SPEED, 0.0, 0.0),
            down: -Vector3::z(),
            rolls: false,
            time: 0.05,
            energy: 0.5 * MASS * SPEED * SPEED,
            loss: (power == 1).then(|| SLOPE.to_radians().sin().powi(2)),
        };
        let brep = sheet(power)?;
        let prepared = Arc::new(PreparedBrep::new(brep.clone()));
        let mut cases = vec![Case {
            name: "BREP, full".to_owned(),
            wall: Box::new(BrepWall::new(&prepared, Accuracy::Full)),
        }];
        // Planes have no finer triangles.
        if power > 1 {
            for degrees in meshes {
                cases.push(mesh(&brep, *degrees)?);
            }
        }
        Ok((scene, cases))
    }
}
