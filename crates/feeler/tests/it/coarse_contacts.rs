//! What answers say beside the separation where a coarse accuracy was asked for: whether the minimum is a continuum, and normals.

use crate::scenes::{
    Random, as_nurbs, bicubic, cylinder, part_of_sphere, with_and_without_formulas,
};
use feeler::brep::Brep;
use feeler::nurbs::Surface;
use feeler::prepare::PreparedBrep;
use feeler::query::{Accuracy, ContactAnswer, Feature, Options, Probe, Sphere, Workspace, contact};
use nalgebra::{Point3, Vector3};
use std::f64::consts::FRAC_PI_2;

/// Of the definition: points are low within the accuracy, and far beyond this part of the size.
const REACH: f64 = 1.0 / 4096.0;
/// Radius of the scenes' spheres.
const RADIUS: f64 = 2.5;

fn ask(brep: &PreparedBrep, center: Point3<f64>, radius: f64, accuracy: f64) -> ContactAnswer {
    let options = Options {
        accuracy: Accuracy::Length(accuracy),
        prediction: f64::INFINITY,
        ..Options::default()
    };
    let probe = Probe::Sphere(Sphere::new(center, radius).unwrap());
    contact(brep, &probe, &options, &mut Workspace::default())
}

/// A surface as it is, searched, and as NURBS.
fn each_way(surface: &Surface) -> Vec<PreparedBrep> {
    let native = with_and_without_formulas(Brep::from_surface(surface.clone()).unwrap());
    native
        .into_iter()
        .chain(with_and_without_formulas(as_nurbs(surface)))
        .collect()
}

/// How far apart on a circle of radius R are its point nearest to a place in its plane and one that is farther by `more`, the place being `off` from its centre and
/// `up` from its plane: `d^2 = R^2 + off^2 + up^2 - 2 R off cos(angle)`.
fn low_on_circle(off: f64, up: f64, more: f64) -> f64 {
    let least = ((RADIUS - off).powi(2) + up * up).sqrt();
    // 1 - cos(angle), of which half the root is the sine of half the angle.
    let rise = more * (2.0 * least + more) / (2.0 * RADIUS * off);
    2.0 * RADIUS * (0.5 * rise).min(1.0).sqrt()
}

/// What is to be said of points that are low so far from the foot; nothing is asked for about the reach.
fn is_far(low: f64, size: f64) -> Option<bool> {
    let reach = REACH * size;
    if low > 1.25 * reach {
        Some(true)
    } else if low < 0.8 * reach {
        Some(false)
    } else {
        None
    }
}

/// An offset from a sphere's middle at which points as low within an accuracy are a part or a multiple of the reach from the foot, roughly.
fn offset(accuracy: f64, size: f64, random: &mut Random) -> f64 {
    let far = random.between(0.2, 1.8) * REACH * size;
    // From a half of the square of the angle.
    let off = 2.0 * accuracy * RADIUS * RADIUS / (far * far);
    off.min(random.between(0.2, 0.9) * RADIUS)
}

/// Holds what is told of balls that are off from the axis or the middle of a scene against how far points as low lie from the foot: `place` makes of such an offset
/// the ball's middle and that.
fn assert_told(
    breps: &[PreparedBrep],
    (accuracies, each): (&[f64], usize),
    seed: u64,
    place: impl Fn(f64, f64, &mut Random) -> (Point3<f64>, f64),
) {
    let mut random = Random::new(seed);
    let mut told = [0; 2];
    for brep in breps {
        for accuracy in accuracies {
            for _ in 0..each {
                let off = offset(*accuracy, brep.size(), &mut random);
                let (center, low) = place(off, *accuracy, &mut random);
                let Some(expected) = is_far(low, brep.size()) else {
                    continue;
                };
                let found = ask(brep, center, 0.25, *accuracy);
                let what = format!("{accuracy:e} {off:e} {low:e} {center}");
                assert_eq!(found.continuum, expected, "{what}");
                told[usize::from(expected)] += 1;
            }
        }
    }
    assert!(told.iter().all(|n| *n > 20), "{told:?}");
}

/// A point off the z axis, at a height.
fn around_axis(off: f64, height: f64, random: &mut Random) -> Point3<f64> {
    let turn = random.between(0.1, 6.2);
    Point3::new(off * turn.cos(), off * turn.sin(), height)
}

const ACCURACIES: [f64; 8] = [1e-12, 1e-10, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-2];

/// About a ball in a spherical socket what is low is a cap around its foot.
#[test]
fn a_cap_of_a_socket_is_low() {
    let sockets = each_way(&part_of_sphere([-FRAC_PI_2, FRAC_PI_2], 4.0 * FRAC_PI_2));
    assert_told(&sockets, (&ACCURACIES, 12), 11, |off, accuracy, random| {
        let center = Point3::origin() + random.direction() * off;
        (center, low_on_circle(off, 0.0, accuracy))
    });
}

/// About a ball in a tube, nearer to the wall than to the lids, what is low is longest around it.
#[test]
fn a_strip_of_a_tube_is_low() {
    let tubes = with_and_without_formulas(cylinder([0.0; 3], [RADIUS; 2], 8.0, 1.5));
    assert_told(
        &tubes,
        (&ACCURACIES[..4], 64),
        14,
        |off, accuracy, random| {
            let off = off.min(0.5 * RADIUS);
            let center = around_axis(off, 4.0 + off * 0.1, random);
            (center, low_on_circle(off, 0.0, accuracy))
        },
    );
}

/// Where the middle of a ball is so far above the rim of a bowl that the bowl rises from there much faster than the rim does, what is low is a part of the rim, on which its foot is.
#[test]
fn a_part_of_a_rim_is_low() {
    let bowls = each_way(&part_of_sphere([-FRAC_PI_2, 0.0], 4.0 * FRAC_PI_2));
    assert_told(&bowls, (&ACCURACIES, 12), 12, |off, accuracy, random| {
        let up = random.between(0.5, 0.9) * RADIUS;
        let center = around_axis(off, up, random);
        (center, low_on_circle(off, up, accuracy))
    });
}

/// A ball whose middle is next to a sheet, on either side of it: the normal does not point away from there, however coarse the accuracy.
#[test]
fn no_normal_of_a_sheet_points_away() {
    let brep = PreparedBrep::new(bicubic());
    let surface = bicubic().surface(0).clone();
    let mut random = Random::new(13);
    for _ in 0..1000 {
        let (u, v) = (random.between(0.1, 0.9), random.between(0.1, 0.9));
        let [du, dv] = surface.domain();
        let at = surface.first_derivatives_with_bound(du.lerp(u), dv.lerp(v));
        let side = if random.below(2) == 0 { 1.0 } else { -1.0 };
        let normal = at.du.cross(&at.dv).normalize() * side;
        let height = 10f64.powf(random.between(-14.0, -11.0));
        let center = at.point + normal * height;
        let found = ask(&brep, center, 0.125, 1e-2);
        let contact = &found.contacts[0];
        // A foot that is beside it by more than it is away tells no side.
        let way = (center - contact.on_brep).normalize();
        assert!(contact.normal.dot(&way) > -0.5, "{u} {v} {contact:?}");
    }
}

/// Two thirds of a turn up to the seam: a foot that is there but for less than f64 tells is told by the end of the face, not by the other end of the domain.
#[test]
fn a_foot_at_a_seam_is_on_its_face() {
    let surface = part_of_sphere([-0.5, 0.5], 4.0 * FRAC_PI_2);
    let corners = [[0.25, 0.25], [1.0, 0.25], [1.0, 0.75], [0.25, 0.75]];
    let corners = corners.map(|[u, v]| nalgebra::Point2::new(u, v));
    let brep = crate::scenes::polygon_face(&surface, &corners);
    for azimuth in [1e-9, 1e-15, 2e-16, 1e-16, 1e-20] {
        let direction = Vector3::new(1.0, -azimuth, 0.0);
        for center in [direction * 2.0, direction * 3.0] {
            let found = ask(&brep, Point3::from(center), 0.25, 1e-12);
            let [contact] = &found.contacts[..] else {
                panic!("{azimuth:e} {found:?}");
            };
            assert!((contact.uv.x - 1.0).abs() < 1e-8, "{azimuth:e} {contact:?}");
            let far = (contact.on_brep - Point3::from(direction * RADIUS)).norm();
            assert!(far < 1e-8, "{azimuth:e} {contact:?}");
            let is_here = matches!(contact.feature, Feature::Face(0) | Feature::Edge(1));
            assert!(is_here, "{azimuth:e} {contact:?}");
        }
    }
}
