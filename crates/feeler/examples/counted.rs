//! Queries whose instructions `cargo xtask instructions` counts under valgrind.
//!
//! `counted NAME` makes the scene, asks every query once so that all that is made on demand is there, and asks them again
//! within `counted_queries`: what is executed in there is counted, and nothing else. Without a name it lists them.

#[path = "../tests/it/scenes/mod.rs"]
mod scenes;

use feeler::brep::Brep;
use feeler::nurbs::{Curve, NurbsCurve, NurbsSurface, PolyCurve, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, Contacts, HalfSpace, LineKind, LineProbe, Options, Probe, Sphere, StraightWay, Way,
    Witness, Workspace, arrival_along, arrival_past, contact, contact_from, line, overlap,
};
use nalgebra::{Point3, Vector3, Vector4};
use scenes::loops::{Holes, comb, face_of, face_within, over_holes, perforated};
use scenes::{
    Random, bicubic, cube, native_sphere, nurbs_cylinder, nurbs_sphere, trimmed_bicubic, wavy_prism,
};
use std::hint::black_box;

/// One query, as a closure that keeps what it needs.
type Query = Box<dyn FnMut()>;

const NAMES: [&str; 27] = [
    "ball_joint_native_1e-12",
    "ball_joint_native_full",
    "ball_joint_nurbs_1e-12",
    "ball_joint_nurbs_full",
    "ball_joint_nurbs_middle",
    "ball_joint_nurbs_near",
    "bicubic_arrival",
    "bicubic_arrival_past",
    "bicubic_contacts",
    "bicubic_trimmed",
    "bicubic_full",
    "bicubic_overlap",
    "bicubic_path",
    "bicubic_path_warm",
    "bicubic_half_space",
    "bicubic_line",
    "bicubic_prepare",
    "comb_contacts",
    "cube_contact",
    "cylinder_nurbs_1e-12",
    "high_degree_contacts",
    "native_prepare",
    "plate_arcs",
    "plate_splines",
    "prism_line",
    "prism_line_1e-12",
    "sphere_line",
];

/// How many places each query is asked at.
const PLACES: usize = 20;
/// The side of so many places is asked of a cube, for each of 12 edges four, before it is kept.
const SIDES: usize = 48;
/// Centres of balls keep this far, in the model's units, from the sphere's centre, but for those of `ball_joint_nurbs_near`...
const NEXT_TO_CENTRE: f64 = 1e-3;
/// ...which are this times as far...
const NEARER: f64 = 1e-6;
/// ...and those of `ball_joint_nurbs_middle`, this times (where a box says little of how steep the distance is)...
const MIDDLE: f64 = 1e-2;
/// ...and keep within half of its radius.
const HALF_RADIUS: f64 = 1.25;
/// A plate has so many holes along each side.
const HOLES: usize = 32;
/// A comb has so many cubics, and the ball over it this radius.
const TEETH: usize = 128;
const OVER_TEETH: f64 = 6.0;
/// The degree of a trim.
const OVAL: usize = 12;
/// About the sizes of the models, of which accuracies short of full are this part: that of the table of figures to beat.
const PART: f64 = 1e-12;
const BALL_SIZE: f64 = 5.0;
const PRISM_SIZE: f64 = 10.0;

fn main() {
    let name = std::env::args().nth(1);
    let Some(mut query) = name.as_deref().and_then(query) else {
        NAMES.iter().for_each(|n| println!("{n}"));
        return;
    };
    query();
    counted_queries(&mut query);
}

/// What valgrind counts: it finds this by its name.
#[inline(never)]
fn counted_queries(query: &mut Query) {
    query();
}

fn query(name: &str) -> Option<Query> {
    let mut random = Random::new(11);
    let off_centre: Vec<Point3<f64>> = (0..PLACES)
        .map(|_| Point3::from(random.direction() * random.between(NEXT_TO_CENTRE, HALF_RADIUS)))
        .collect();
    let over: Vec<Point3<f64>> = (0..PLACES)
        .map(|_| {
            let [x, y] = [0, 1].map(|_| random.between(0.1, 0.9));
            Point3::new(x, y, random.between(-0.3, 0.3))
        })
        .collect();
    let directions: Vec<Vector3<f64>> = (0..PLACES).map(|_| random.direction()).collect();
    let coarse = Accuracy::Length(BALL_SIZE * PART);
    Some(match name {
        "ball_joint_native_1e-12" => balls(native_sphere(), 2.49, coarse, off_centre),
        "ball_joint_native_full" => balls(native_sphere(), 2.49, Accuracy::Full, off_centre),
        "ball_joint_nurbs_1e-12" => balls(nurbs_sphere(), 2.49, coarse, off_centre),
        "ball_joint_nurbs_full" => balls(nurbs_sphere(), 2.49, Accuracy::Full, off_centre),
        "ball_joint_nurbs_middle" => {
            let middle = off_centre.iter().map(|p| p * MIDDLE).collect();
            balls(nurbs_sphere(), 2.49, Accuracy::Full, middle)
        }
        "ball_joint_nurbs_near" => {
            let near = off_centre.iter().map(|p| p * NEARER).collect();
            balls(nurbs_sphere(), 2.49, Accuracy::Full, near)
        }
        "bicubic_arrival" => arrivals(&over, &directions, false),
        "bicubic_arrival_past" => arrivals(&over, &directions, true),
        "bicubic_contacts" => lists(trimmed_bicubic(), over),
        "high_degree_contacts" => lists(sheet_within_oval(), over),
        "comb_contacts" => {
            let teeth = comb(TEETH);
            let params = (0..=teeth.len()).map(|k| k as f64).collect();
            let around = PolyCurve::new(teeth, params).expect("a poly-curve");
            let brep = PreparedBrep::new(face_within(vec![vec![Curve::Poly(around)]]));
            let mut workspace = Workspace::default();
            let options = Options {
                contacts: Contacts::All,
                ..Options::default()
            };
            let above = ball(Point3::new(0.1, 0.2, 0.5), OVER_TEETH);
            Box::new(move || {
                black_box(contact(&brep, &above, &options, &mut workspace));
            })
        }
        "bicubic_trimmed" => balls(trimmed_bicubic(), 0.01, Accuracy::Full, over),
        "bicubic_full" => balls(bicubic(), 0.01, Accuracy::Full, over),
        "cube_contact" => {
            let mut query = balls(cube(), 0.01, Accuracy::Full, over);
            // Until sides are kept: some of the places are within its box.
            for _ in 0..SIDES {
                query();
            }
            query
        }
        "cylinder_nurbs_1e-12" => balls(nurbs_cylinder(), 2.49, coarse, off_centre),
        "plate_arcs" | "plate_splines" => {
            let holes = match name {
                "plate_arcs" => Holes::Arcs,
                _ => Holes::Splines,
            };
            let (loops, centers) = perforated(HOLES, holes);
            let over = over_holes(&centers, PLACES, &mut random);
            balls(face_within(loops), 0.01, Accuracy::Full, over)
        }
        "bicubic_overlap" => {
            let brep = PreparedBrep::new(bicubic());
            let mut workspace = Workspace::default();
            Box::new(move || {
                for at in &over {
                    let probe = ball(*at, 0.1);
                    black_box(overlap(&brep, &probe, &Options::default(), &mut workspace));
                }
            })
        }
        "bicubic_half_space" => {
            let brep = PreparedBrep::new(bicubic());
            let mut workspace = Workspace::default();
            Box::new(move || {
                for n in &directions {
                    let probe = HalfSpace::new(*n, -1.0).expect("a half-space");
                    let probe = Probe::HalfSpace(probe);
                    black_box(contact(&brep, &probe, &wide(), &mut workspace));
                }
            })
        }
        "bicubic_path" => path(over[0], directions[0], false),
        "bicubic_path_warm" => path(over[0], directions[0], true),
        "bicubic_line" => lines(bicubic(), over, directions, Accuracy::Full),
        "sphere_line" => lines(nurbs_sphere(), over, directions, Accuracy::Full),
        "prism_line" | "prism_line_1e-12" => {
            let accuracy = match name {
                "prism_line" => Accuracy::Full,
                _ => Accuracy::Length(PRISM_SIZE * PART),
            };
            let scaled = off_centre
                .iter()
                .map(|p| Point3::new(4.0 * p.x, 4.0 * p.y, 0.7 * p.z));
            lines(wavy_prism(38), scaled.collect(), directions, accuracy)
        }
        "bicubic_prepare" => prepare(bicubic(), over[0]),
        "native_prepare" => prepare(native_sphere(), off_centre[0]),
        _ => return None,
    })
}

/// What it takes to prepare a BREP, and the first ball.
fn prepare(brep: Brep, center: Point3<f64>) -> Query {
    Box::new(move || {
        let brep = PreparedBrep::new(brep.clone());
        let mut workspace = Workspace::default();
        black_box(contact(&brep, &ball(center, 0.1), &wide(), &mut workspace));
    })
}

fn wide() -> Options {
    Options {
        prediction: f64::INFINITY,
        ..Options::default()
    }
}

fn ball(center: Point3<f64>, radius: f64) -> Probe {
    Probe::Sphere(Sphere::new(center, radius).expect("a ball"))
}

fn balls(brep: Brep, radius: f64, accuracy: Accuracy, centers: Vec<Point3<f64>>) -> Query {
    let brep = PreparedBrep::new(brep);
    let mut workspace = Workspace::default();
    let options = Options { accuracy, ..wide() };
    Box::new(move || {
        for c in &centers {
            black_box(contact(&brep, &ball(*c, radius), &options, &mut workspace));
        }
    })
}

/// All contacts of balls.
fn lists(brep: Brep, centers: Vec<Point3<f64>>) -> Query {
    let brep = PreparedBrep::new(brep);
    let mut workspace = Workspace::default();
    let options = Options {
        contacts: Contacts::All,
        ..wide()
    };
    Box::new(move || {
        for c in &centers {
            black_box(contact(&brep, &ball(*c, 0.01), &options, &mut workspace));
        }
    })
}

/// A sheet of three by three parabolic patches within one Bezier curve of degree `OVAL`: on a patch that is degree `4 OVAL`.
fn sheet_within_oval() -> Brep {
    let knots = vec![0.0, 0.0, 0.0, 0.3, 0.7, 1.0, 1.0, 1.0];
    // The Greville abscissas: u and v are x and y.
    let at = |k: usize| 0.5 * (knots[k + 1] + knots[k + 2]);
    let place = |k: usize| {
        (
            at(k / 5),
            at(k % 5),
            if k.is_multiple_of(2) { 0.2 } else { -0.2 },
        )
    };
    let point = |(x, y, z): (f64, f64, f64)| Vector4::new(x, y, z, 1.0);
    let net = (0..25).map(place).map(point).collect();
    let sheet = NurbsSurface::new([2, 2], [5, 5], net, [knots.clone(), knots]);
    // A convex polygon of control points: the curve is convex, too.
    let point = |k: usize| {
        let turn = std::f64::consts::TAU * (k % OVAL) as f64 / OVAL as f64;
        Vector3::new(0.5 + 0.45 * turn.cos(), 0.5 + 0.45 * turn.sin(), 1.0)
    };
    let net = (0..=OVAL).map(point).collect();
    let knots = [vec![0.0; OVAL + 1], vec![1.0; OVAL + 1]].concat();
    let oval = NurbsCurve::new(OVAL, net, knots).expect("a curve");
    let sheet = Surface::Nurbs(sheet.expect("a sheet"));
    face_of(sheet, vec![vec![Curve::Nurbs(oval)]])
}

/// Balls that fall onto the wave; or, from where they touch it, go off along it or away from it.
fn arrivals(over: &[Point3<f64>], directions: &[Vector3<f64>], past: bool) -> Query {
    const RADIUS: f64 = 0.05;
    const ALLOWANCE: f64 = RADIUS / 128.0;
    // To a thousandth of a thousandth, as engines ask.
    let options = Options {
        accuracy: Accuracy::Length(1e-6),
        ..Options::default()
    };
    let brep = PreparedBrep::new(bicubic());
    let mut workspace = Workspace::default();
    let mut ways = Vec::new();
    for (at, direction) in over.iter().zip(directions) {
        let to = Vector3::new(0.5, 0.5, 0.0) + 0.3 * direction;
        let from = Point3::new(at.x, at.y, 1.0);
        let down = straight(from, Vector3::new(to.x - at.x, to.y - at.y, -1.0));
        let met = arrival_along(&brep, RADIUS, &down, [0.0, 2.0], &options, &mut workspace);
        let (Some(time), Some(contact)) = (met.time, met.contacts.first()) else {
            continue;
        };
        ways.push(match past {
            false => down,
            true => {
                let off = direction - contact.normal * direction.dot(&contact.normal).min(0.0);
                straight(down.center(time.value).0, off)
            }
        });
    }
    Box::new(move || {
        for way in &ways {
            let span = [0.0, 2.0];
            black_box(match past {
                false => arrival_along(&brep, RADIUS, way, span, &options, &mut workspace),
                true => arrival_past(
                    &brep,
                    RADIUS,
                    way,
                    span,
                    ALLOWANCE,
                    &options,
                    &mut workspace,
                ),
            });
        }
    })
}

fn straight(center: Point3<f64>, velocity: Vector3<f64>) -> StraightWay {
    StraightWay {
        center,
        center_bound: 0.0,
        velocity,
        velocity_bound: 0.0,
    }
}

/// Small steps over the wave, each with what the one before has learnt if `warm`.
fn path(from: Point3<f64>, direction: Vector3<f64>, warm: bool) -> Query {
    const STEP: f64 = 1e-3;
    let brep = PreparedBrep::new(bicubic());
    let mut workspace = Workspace::default();
    Box::new(move || {
        let mut witness = Witness::default();
        for k in 0..PLACES {
            let probe = ball(from + direction * (STEP * k as f64), 0.01);
            black_box(if warm {
                contact_from(&brep, &probe, &mut witness, &wide(), &mut workspace)
            } else {
                contact(&brep, &probe, &wide(), &mut workspace)
            });
        }
    })
}

fn lines(
    brep: Brep,
    origins: Vec<Point3<f64>>,
    directions: Vec<Vector3<f64>>,
    accuracy: Accuracy,
) -> Query {
    let brep = PreparedBrep::new(brep);
    let mut workspace = Workspace::default();
    let options = Options { accuracy, ..wide() };
    Box::new(move || {
        for (o, d) in origins.iter().zip(&directions) {
            let probe = LineProbe::new(*o, *d, LineKind::Line).expect("a line");
            black_box(line(&brep, &probe, &options, &mut workspace));
        }
    })
}
