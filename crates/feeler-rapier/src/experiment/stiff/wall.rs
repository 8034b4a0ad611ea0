//! What a ball meets: a BREP at an accuracy, triangles, the thesis's algorithms, or a closed form.

use super::BALL;
use ::nalgebra::{Point3, Vector3};
use feeler::numeric::Dd;
use feeler::prepare::PreparedBrep;
use feeler::query::{Accuracy, Options, Probe, Sphere, Witness, Workspace, contact_from};
use feeler_corpus::{Ask, Body, Hits, Query};
use feeler_gate::{Engine, ThesisEngine};
use rapier3d_f64::prelude::{SharedShape, Vector};
use std::sync::Arc;

/// How deep a ball is in a wall, and the unit normal towards its centre.
#[derive(Clone, Copy, Debug)]
pub(in crate::experiment) struct Near {
    /// mm; negative apart.
    pub(in crate::experiment) depth: f64,
    pub(in crate::experiment) normal: Vector3<f64>,
}

/// Nothing is near.
const FAR: Near = Near {
    depth: f64::NEG_INFINITY,
    normal: Vector3::new(0.0, 0.0, 1.0),
};

/// The wall that a ball of radius [`BALL`] meets.
pub(in crate::experiment) trait Wall {
    fn near(&mut self, center: &Point3<f64>) -> Near;
}

/// A BREP, asked as exactly as is said.
pub(in crate::experiment) struct BrepWall {
    brep: Arc<PreparedBrep>,
    options: Options,
    witness: Witness,
    workspace: Workspace,
}

impl BrepWall {
    pub(in crate::experiment) fn new(brep: &Arc<PreparedBrep>, accuracy: Accuracy) -> Self {
        Self {
            brep: Arc::clone(brep),
            options: Options {
                accuracy,
                prediction: f64::INFINITY,
                ..Options::default()
            },
            witness: Witness::default(),
            workspace: Workspace::default(),
        }
    }
}

impl Wall for BrepWall {
    fn near(&mut self, center: &Point3<f64>) -> Near {
        let Ok(sphere) = Sphere::new(*center, BALL) else {
            return FAR;
        };
        let probe = Probe::Sphere(sphere);
        let Self {
            brep,
            options,
            witness,
            workspace,
        } = self;
        let answer = contact_from(brep, &probe, witness, options, workspace);
        answer.contacts.first().map_or(FAR, |c| Near {
            depth: -answer.separation.value,
            normal: c.normal,
        })
    }
}

/// Triangles in Parry; the ball's centre stays on the free side, which a projection does not need to know.
pub(super) struct MeshWall(pub(super) SharedShape);

impl Wall for MeshWall {
    fn near(&mut self, center: &Point3<f64>) -> Near {
        let at = Vector::new(center.x, center.y, center.z);
        let off = at - self.0.project_local_point(at, false).point;
        let distance = off.length();
        if !(distance > 0.0) {
            return FAR;
        }
        let normal = off / distance;
        Near {
            depth: BALL - distance,
            normal: Vector3::new(normal.x, normal.y, normal.z),
        }
    }
}

/// The thesis's algorithms, as the gate's engine has them.
pub(super) struct ThesisWall(pub(super) ThesisEngine);

impl Wall for ThesisWall {
    fn near(&mut self, center: &Point3<f64>) -> Near {
        let Ok(sphere) = Sphere::new(*center, BALL) else {
            return FAR;
        };
        let query = Query {
            id: None,
            ask: Ask::Contact(Probe::Sphere(sphere)),
            prediction: Some(f64::INFINITY),
            contacts: None,
            hits: Hits::All,
            accuracy: None,
            overlap: false,
        };
        match self.0.answer(&query).body {
            Body::Contact {
                separation,
                contacts,
                ..
            } => contacts.first().map_or(FAR, |c| Near {
                depth: -separation.value,
                normal: Vector3::from(c.normal),
            }),
            _ => FAR,
        }
    }
}

/// Walls whose distance is known in closed form, or nearly so.
#[derive(Clone, Copy, Debug)]
pub(super) enum Closed {
    /// A sphere about the origin, from within; in double-double.
    Socket { radius: f64 },
    /// The plane z = 0 up to x = 0, and z = a x^p beyond; the foot on the curve by bisection.
    Seam { factor: f64, power: i32 },
}

impl Closed {
    /// Where on the curve, x >= 0, the nearest point to (x, z) is, if the centre is above and nearer than any radius
    /// of curvature: there the derivative of the squared distance rises.
    fn foot(factor: f64, power: i32, x: f64, z: f64) -> f64 {
        let slope = |t: f64| f64::from(power) * factor * t.powi(power - 1);
        let rising = |t: f64| t - x + slope(t) * (factor * t.powi(power) - z);
        let (mut lo, mut hi) = (0.0, x.max(0.0) + 2.0 * BALL);
        if rising(lo) >= 0.0 {
            return lo;
        }
        loop {
            let t = 0.5 * (lo + hi);
            if !(t > lo && t < hi) {
                return t;
            }
            if rising(t) < 0.0 {
                lo = t;
            } else {
                hi = t;
            }
        }
    }

    /// Curvature of the way of the ball's centre along the wall, 1/mm: by it, speed and slope the wall's push is known.
    pub(super) fn bend(&self, center: &Point3<f64>) -> f64 {
        match *self {
            Self::Socket { .. } => 1.0 / center.coords.norm(),
            Self::Seam { factor, power } => {
                let t = Self::foot(factor, power, center.x, center.z);
                if t == 0.0 || power == 1 {
                    return 0.0;
                }
                let p = f64::from(power);
                let slope = p * factor * t.powi(power - 1);
                let second = p * (p - 1.0) * factor * t.powi(power - 2);
                let bend = second / (1.0 + slope * slope).powf(1.5);
                bend / (1.0 - BALL * bend)
            }
        }
    }
}

impl Wall for Closed {
    fn near(&mut self, center: &Point3<f64>) -> Near {
        match *self {
            Self::Socket { radius } => {
                let square = center
                    .coords
                    .iter()
                    .map(|c| Dd::product(*c, *c))
                    .fold(Dd::ZERO, |a, b| a + b);
                let depth = square.sqrt() - Dd::difference(radius, BALL);
                Near {
                    depth: depth.hi,
                    normal: -center.coords.normalize(),
                }
            }
            Self::Seam { factor, power } => {
                let t = Self::foot(factor, power, center.x, center.z);
                let curve = Vector3::new(center.x - t, 0.0, center.z - factor * t.powi(power));
                let plane = Vector3::new(center.x.max(0.0), 0.0, center.z);
                let off = if curve.norm() < plane.norm() {
                    curve
                } else {
                    plane
                };
                let distance = off.norm();
                Near {
                    depth: BALL - distance,
                    normal: off / distance,
                }
            }
        }
    }
}
