//! The suite `analytic`: surfaces with closed forms, native and as NURBS, asked at focal points and grazing.

use super::{Scene, Suite};
use crate::generate::{Generator, NEAR};
use crate::random::Random;
use feeler_corpus::{
    HalfSpaceLine, LineKindLine, LineLine, MODELS, Model, QueryLine, SpacePoint, SphereLine, ulp,
};
use nalgebra::{Point3, Vector3};
use std::path::Path;

/// As `corpora/make_parts.py` makes them.
#[derive(Clone, Copy)]
enum Shape {
    Sphere {
        center: [f64; 3],
        radius: f64,
    },
    Cylinder {
        base: [f64; 3],
        axis: [f64; 3],
        radius: f64,
        height: f64,
    },
    Cone {
        base: [f64; 3],
        bottom: f64,
        top: f64,
        height: f64,
    },
    Torus {
        center: [f64; 3],
        big: f64,
        small: f64,
    },
    Block {
        corner: [f64; 3],
        sides: [f64; 3],
    },
}

const SHAPES: [(&str, Shape); 7] = [
    (
        "sphere",
        Shape::Sphere {
            center: [0.5, -0.25, 1.0],
            radius: 2.0,
        },
    ),
    (
        "cylinder",
        Shape::Cylinder {
            base: [0.25, 0.5, -1.0],
            axis: [0.0, 0.0, 1.0],
            radius: 1.5,
            height: 5.0,
        },
    ),
    (
        "cylinder_slanted",
        Shape::Cylinder {
            base: [1.0, 0.0, 0.5],
            axis: [1.0, 2.0, 2.0],
            radius: 1.25,
            height: 6.0,
        },
    ),
    (
        "cone",
        Shape::Cone {
            base: [0.0, 0.0, 0.0],
            bottom: 3.0,
            top: 0.0,
            height: 4.0,
        },
    ),
    (
        "frustum",
        Shape::Cone {
            base: [-1.0, 0.5, 0.25],
            bottom: 3.0,
            top: 1.0,
            height: 2.5,
        },
    ),
    (
        "torus",
        Shape::Torus {
            center: [0.125, 0.25, -0.5],
            big: 4.0,
            small: 1.0,
        },
    ),
    (
        "block",
        Shape::Block {
            corner: [-1.0, -2.0, 0.5],
            sides: [3.0, 4.0, 5.0],
        },
    ),
];

/// A point of the surface, its outward normal, and two tangents.
struct Place {
    point: Point3<f64>,
    normal: Vector3<f64>,
    tangents: [Vector3<f64>; 2],
}

/// Two unit vectors normal to `axis` and to each other.
fn across(axis: Vector3<f64>) -> [Vector3<f64>; 2] {
    let start = if axis.x.abs() < 0.9 * axis.norm() {
        Vector3::x()
    } else {
        Vector3::y()
    };
    let a = (start - axis * (start.dot(&axis) / axis.norm_squared())).normalize();
    [a, axis.normalize().cross(&a)]
}

impl Shape {
    /// A direction normal to the axis: along the frame, or anywhere.
    fn around(axis: Vector3<f64>, random: &mut Random) -> Vector3<f64> {
        let [a, b] = across(axis);
        match random.below(6) {
            0 => a,
            1 => b,
            2 => -a,
            3 => -b,
            _ => {
                let d = random.direction();
                let d = a * d.x + b * d.y;
                d.normalize()
            }
        }
    }

    /// Where many points of the surface are equally near, and the distance there.
    fn focal(&self, random: &mut Random) -> (Point3<f64>, f64) {
        let z = Vector3::z();
        match *self {
            Self::Sphere { center, radius } => (center.into(), radius),
            Self::Cylinder {
                base,
                axis,
                radius,
                height,
            } => {
                let axis = Vector3::from(axis).normalize();
                let t = [0.25, 0.5, random.unit()][random.below(3)] * height;
                (Point3::from(base) + axis * t, radius)
            }
            Self::Cone {
                base,
                bottom,
                top,
                height,
            } => {
                let t = [0.5, 1.0, random.unit()][random.below(3)] * height;
                let r = bottom + (top - bottom) * t / height;
                let slope = height / (height * height + (bottom - top) * (bottom - top)).sqrt();
                (Point3::from(base) + z * t, r * slope)
            }
            Self::Torus { center, big, small } => {
                let center = Point3::from(center);
                match random.below(4) {
                    0 => (center, big - small),
                    1 => {
                        let t = [0.5, 1.0, 3.0][random.below(3)];
                        (center + z * t, (big * big + t * t).sqrt() - small)
                    }
                    _ => (center + Self::around(z, random) * big, small),
                }
            }
            Self::Block { corner, sides } => {
                let half = Vector3::from(sides) * 0.5;
                let mut at = Point3::from(corner) + half;
                // On medial planes: to two sides, or three.
                at.z += [0.0, 0.5, 1.0, -1.0][random.below(4)];
                (at, 1.5)
            }
        }
    }

    fn place(&self, random: &mut Random) -> Place {
        let z = Vector3::z();
        match *self {
            Self::Sphere { center, radius } => {
                let normal = match random.below(2) {
                    0 => [z, Vector3::x(), -Vector3::y()][random.below(3)],
                    _ => random.direction(),
                };
                Place {
                    point: Point3::from(center) + normal * radius,
                    normal,
                    tangents: across(normal),
                }
            }
            Self::Cylinder {
                base,
                axis,
                radius,
                height,
            } => {
                let axis = Vector3::from(axis).normalize();
                let normal = Self::around(axis, random);
                let t = [0.5, random.unit()][random.below(2)] * height;
                Place {
                    point: Point3::from(base) + axis * t + normal * radius,
                    normal,
                    tangents: [axis, axis.cross(&normal)],
                }
            }
            Self::Cone {
                base,
                bottom,
                top,
                height,
            } => {
                let out = Self::around(z, random);
                let t = [0.5, random.unit()][random.below(2)] * height;
                let r = bottom + (top - bottom) * t / height;
                let along = z * height + out * (top - bottom);
                Place {
                    point: Point3::from(base) + z * t + out * r,
                    normal: (out * height + z * (bottom - top)).normalize(),
                    tangents: [along.normalize(), z.cross(&out)],
                }
            }
            Self::Torus { center, big, small } => {
                let out = Self::around(z, random);
                let normal = match random.below(5) {
                    0 => z,
                    1 => -z,
                    2 => out,
                    3 => -out,
                    _ => {
                        let d = random.direction();
                        (out * d.x + z * d.y).normalize()
                    }
                };
                let round = z.cross(&out);
                Place {
                    point: Point3::from(center) + out * big + normal * small,
                    normal,
                    tangents: [round, round.cross(&normal)],
                }
            }
            Self::Block { corner, sides } => {
                let k = random.below(3);
                let mut normal = Vector3::zeros();
                let mut point = Point3::from(corner);
                for c in 0..3 {
                    point[c] += sides[c] * [0.0, 0.25, 0.5, 1.0, random.unit()][random.below(5)];
                }
                normal[k] = random.sign();
                point[k] = corner[k] + if normal[k] > 0.0 { sides[k] } else { 0.0 };
                Place {
                    point,
                    normal,
                    tangents: across(normal),
                }
            }
        }
    }

    /// The length whose ulp counts here.
    fn radius(&self) -> f64 {
        match *self {
            Self::Sphere { radius, .. } | Self::Cylinder { radius, .. } => radius,
            Self::Cone { bottom, .. } => bottom,
            Self::Torus { big, .. } => big,
            Self::Block { sides, .. } => sides[2],
        }
    }
}

/// -4 to 4 ulp of the radius, or 1e-15 to 1e-6 of it.
fn small(random: &mut Random, radius: f64) -> f64 {
    match random.below(2) {
        0 => (random.below(9) as f64 - 4.0) * ulp(radius),
        _ => random.sign() * NEAR[random.below(NEAR.len())] * radius,
    }
}

fn questions(
    shape: &Shape,
    generator: &mut Generator<'_>,
    each: usize,
    native: bool,
) -> Vec<QueryLine> {
    let mut lines = Vec::new();
    let mut sphere = |center: Point3<f64>, radius: f64| {
        lines.push(QueryLine {
            sphere: Some(SphereLine {
                center: center.coords.into(),
                radius,
            }),
            ..QueryLine::default()
        });
    };
    let r = shape.radius();
    for i in 0..2 * each {
        let random = &mut generator.random;
        let (point, distance) = shape.focal(random);
        let off = match i % 3 {
            0 => 0.0,
            1 => NEAR[random.below(NEAR.len())],
            _ => [1e-5, 1e-4, 1e-3, 0.01][random.below(4)],
        };
        let center = point + random.direction() * off;
        let radius = match random.below(3) {
            0 => distance + (random.below(9) as f64 - 4.0) * ulp(distance),
            1 => distance * random.between(0.9, 1.1),
            _ => 0.0,
        };
        sphere(center, radius.max(0.0));
    }
    for i in 0..each {
        lines.push(generator.sphere(i % 2 == 0));
    }
    // Few where the kernel has no formula yet and searches for half a second or so.
    let slow = native && matches!(shape, Shape::Torus { .. });
    for i in 0..if slow { each / 4 } else { 2 * each } {
        let random = &mut generator.random;
        let place = shape.place(random);
        let [a, b] = place.tangents;
        // Along the frame, where curves on the surface are straight or widest; or any way between.
        let direction = match random.below(3) {
            0 => a,
            1 => b,
            _ => {
                let d = random.direction();
                (a * d.x + b * d.y).normalize()
            }
        };
        let off = if i % 5 == 0 { 0.0 } else { small(random, r) };
        let direction = direction * [1.0, 4.0, 0.3][random.below(3)];
        let origin =
            place.point + place.normal * off - direction * [0.0, 0.5, 2.0][random.below(3)];
        let kind = [LineKindLine::Line, LineKindLine::Ray, LineKindLine::Segment];
        lines.push(QueryLine {
            line: Some(LineLine {
                origin: origin.coords.into(),
                direction: direction.into(),
                kind: kind[random.below(3)],
            }),
            ..QueryLine::default()
        });
    }
    let slow = native && !matches!(shape, Shape::Sphere { .. } | Shape::Block { .. });
    for i in 0..if slow { each / 4 } else { each } {
        let random = &mut generator.random;
        let place = shape.place(random);
        // Flat on it, along a generator, or tilted by very little.
        let tilt = if i % 3 == 0 {
            0.0
        } else {
            NEAR[random.below(NEAR.len())]
        };
        let normal = (random.direction() * tilt - place.normal).normalize();
        let offset = normal.dot(&place.point.coords) + small(random, r);
        lines.push(QueryLine {
            half_space: Some(HalfSpaceLine {
                normal: normal.into(),
                offset,
            }),
            ..QueryLine::default()
        });
    }
    for _ in 0..each {
        let random = &mut generator.random;
        let place = shape.place(random);
        let point = place.point + place.normal * small(random, r);
        lines.push(QueryLine {
            inside: Some(SpacePoint {
                point: point.coords.into(),
            }),
            ..QueryLine::default()
        });
    }
    for i in 0..each / 2 {
        lines.push(generator.side(i % 2 == 0));
        lines.push(generator.evaluate(i % 2 == 0));
    }
    lines
}

pub(crate) fn suite(corpus: &Path) -> Result<Suite, String> {
    let mut scenes = Vec::new();
    for (name, shape) in SHAPES {
        for (kind, each) in [("", 20), ("_nurbs", 20)] {
            let path = format!("analytic/{name}{kind}.json.gz");
            let model = Model::load(&corpus.join(MODELS).join(&path), None);
            let model = model.map_err(|e| e.to_string())?;
            let mut generator = Generator::new(&model, &path);
            let queries = questions(&shape, &mut generator, each, kind.is_empty());
            scenes.push(Scene {
                name: path,
                breps: Vec::new(),
                queries,
            });
        }
    }
    Ok(Suite {
        name: "analytic",
        description: "spheres, cylinders, cones, tori and boxes, native and as NURBS: balls at focal points exactly and 1e-15 to \
                      0.01 off, lines that graze within 0 to 4 ulp, half-spaces flat on them or tilted by 1e-6 to 1e-15",
        scenes,
    })
}
