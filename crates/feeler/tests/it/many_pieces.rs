//! Faces whose loops have many pieces: against distances of round holes by analysis, and of polygons side by side.

use crate::scenes::Random;
use crate::scenes::loops::{
    HOLE, Holes, PITCH, face_of, face_within, over_holes, perforated, square_plane,
};
use feeler::nurbs::{NurbsSurface, Surface};
use feeler::prepare::{PreparedBrep, Shortcuts};
use feeler::query::{
    Accuracy, Contacts, Feature, HalfSpace, Options, Probe, Sphere, Witness, Workspace, contact,
    contact_from,
};
use nalgebra::{Point2, Point3, Vector2, Vector3, Vector4};

/// Holes along each side.
const SIDE: usize = 16;
const RADIUS: f64 = 0.25;
/// Contacts are asked for of what is no farther from a ball's centre.
const REACH: f64 = 1.25;
/// The coarser accuracy.
const WIDTH: f64 = 1e-12;
/// How far coordinates of a few units that are computed here may be off.
const ROUNDED: f64 = 1e-14;

/// What is true of a point at a height over a plate.
struct Truth {
    distance: f64,
    over_hole: bool,
    /// At how many places no farther than [`REACH`] the distance is a local minimum.
    minima: usize,
}

fn truth(p: Point2<f64>, z: f64, holes: Holes, centers: &[Point2<f64>]) -> Truth {
    let Holes::Polygons(sides) = holes else {
        // The far side of a rim is where it is greatest along the rim.
        let gap = centers.iter().map(|c| HOLE - (p - c).norm());
        let gap = gap.fold(0.0, f64::max);
        return Truth {
            distance: gap.hypot(z),
            over_hole: gap > 0.0,
            minima: 1,
        };
    };
    let corner = |c: &Point2<f64>, k: usize| {
        let (sin, cos) = (k as f64 * std::f64::consts::TAU / sides as f64).sin_cos();
        c + Vector2::new(cos, sin) * HOLE
    };
    let (mut gap, mut minima): (f64, usize) = (0.0, 0);
    for c in centers {
        // How far to the left of each side, and whether it has a foot: beyond it is the plate, which rises from there.
        let side = |k: usize| {
            let (a, b) = (corner(c, k), corner(c, k + 1));
            let along = (b - a).normalize();
            let part = (p - a).dot(&along);
            (along.perp(&(p - a)), 0.0 < part && part < (b - a).norm())
        };
        let all: Vec<(f64, bool)> = (0..sides).map(side).collect();
        let low = |(left, foot): &&(f64, bool)| *foot && *left > 0.0 && left.hypot(z) <= REACH;
        minima += all.iter().filter(low).count();
        let least = all.iter().fold(f64::INFINITY, |m, (left, _)| m.min(*left));
        // (In a regular polygon the nearest side has a foot.)
        gap = gap.max(least);
    }
    Truth {
        distance: gap.hypot(z),
        over_hole: gap > 0.0,
        minima: minima + usize::from(gap <= 0.0),
    }
}

/// Balls over and in holes touch the plate, or the rim of the hole below them, and nothing else; whether one contact is asked for or all, at a coarse
/// accuracy and at full.
#[test]
fn balls_over_a_perforated_plate() {
    for holes in [Holes::Arcs, Holes::Splines, Holes::Polygons(24)] {
        let (loops, centers) = perforated(SIDE, holes);
        let brep = PreparedBrep::new(face_within(loops));
        let mut random = Random::new(3);
        let mut workspace = Workspace::default();
        let mut counts = [0; 2];
        for k in 0..60 {
            let center = centers[random.below(centers.len())];
            let off = [0, 1].map(|_| random.between(-0.5 * PITCH, 0.5 * PITCH) * 0.6);
            let p = Point2::new(center.x + off[0], center.y + off[1]);
            let z = random.between(0.0, 0.2);
            let truth = truth(p, z, holes, &centers);
            counts[usize::from(truth.over_hole)] += 1;
            for contacts in [Contacts::Deepest, Contacts::All] {
                for accuracy in [Accuracy::Length(WIDTH), Accuracy::Full] {
                    let options = Options {
                        accuracy,
                        contacts,
                        prediction: REACH - RADIUS,
                        ..Options::default()
                    };
                    let ball = Sphere::new(Point3::new(p.x, p.y, z), RADIUS).unwrap();
                    let a = contact(&brep, &Probe::Sphere(ball), &options, &mut workspace);
                    let b = a.separation.bounds;
                    let separation = truth.distance - RADIUS;
                    assert!(
                        b.lo <= separation + ROUNDED && separation - ROUNDED <= b.hi,
                        "{holes:?} {k}: {b:?} {separation}"
                    );
                    assert!(b.width() <= WIDTH, "{holes:?} {k}: {b:?}");
                    let count = match contacts {
                        Contacts::All => truth.minima,
                        _ => 1,
                    };
                    assert_eq!(
                        (a.undecided, a.contacts.len()),
                        (None, count),
                        "{holes:?} {k}"
                    );
                    let is_face = matches!(a.contacts[0].feature, Feature::Face(_));
                    assert_eq!(is_face, !truth.over_hole, "{holes:?} {k}: {:?}", a.contacts);
                }
            }
        }
        assert!(counts.into_iter().all(|n| n > 10), "{counts:?}");
    }
}

/// A half-space that looks up at a plate from the side touches the corner farthest down, and one that lies flat all of it.
#[test]
fn half_spaces_under_a_perforated_plate() {
    let half = 0.5 * PITCH * SIDE as f64;
    for holes in [Holes::Arcs, Holes::Splines, Holes::Polygons(24)] {
        let (loops, _) = perforated(SIDE, holes);
        let brep = PreparedBrep::new(face_within(loops));
        let mut workspace = Workspace::default();
        for contacts in [Contacts::Deepest, Contacts::All] {
            let options = Options {
                contacts,
                ..Options::default()
            };
            let mut ask = |normal: [f64; 3]| {
                let probe = HalfSpace::new(Vector3::from(normal), 0.0).unwrap();
                contact(&brep, &Probe::HalfSpace(probe), &options, &mut workspace)
            };
            let tilted = ask([0.6, 0.0, 0.8]);
            let b = tilted.separation.bounds;
            assert!(
                (b.lo + 0.6 * half).abs() <= ROUNDED && b.width() <= ROUNDED,
                "{b:?}"
            );
            assert!(tilted.continuum, "it lies on a side");
            let corner = ask([2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0]);
            let b = corner.separation.bounds;
            assert!(
                (b.lo + 5.0 / 7.0 * half).abs() <= ROUNDED && b.width() <= ROUNDED,
                "{b:?}"
            );
            assert!(!corner.continuum);
            let flat = ask([0.0, 0.0, 1.0]);
            let b = flat.separation.bounds;
            assert!(b.lo <= 0.0 && 0.0 <= b.hi && b.width() <= ROUNDED, "{b:?}");
            assert!(flat.continuum, "{holes:?}");
        }
    }
}

/// A rational bicubic patch, wavy in height, over a square of so far to each side of the origin.
fn rational_patch(half: f64) -> Surface {
    let mut random = Random::new(8);
    let knots = [[-half; 4], [half; 4]].concat();
    let at = |k: usize| (2.0 * k as f64 / 3.0 - 1.0) * half;
    let mut point = |k: usize| {
        let w = random.between(0.5, 2.0);
        let z = random.between(-0.5, 0.5);
        Vector4::new(at(k / 4) * w, at(k % 4) * w, z * w, w)
    };
    let net = (0..16).map(&mut point).collect();
    let s = NurbsSurface::new([3, 3], [4, 4], net, [knots.clone(), knots]);
    Surface::Nurbs(s.unwrap())
}

/// What is put aside by boxes around many pieces holds nothing that is nearer: without any boxes the answers are the same, on a patch with weights and on a plane that is
/// searched as a patch.
#[test]
fn boxes_around_pieces_hide_nothing() {
    const HOLES: usize = 8;
    let half = 0.5 * PITCH * HOLES as f64;
    for surface in [rational_patch(half), square_plane(half)] {
        let (loops, centers) = perforated(HOLES, Holes::Splines);
        let brep = face_of(surface, loops);
        let with = |boxes: bool| {
            let shortcuts = Shortcuts {
                boxes,
                closed_forms: false,
                ..Shortcuts::ALL
            };
            PreparedBrep::with_shortcuts(brep.clone(), shortcuts)
        };
        let both = [with(true), with(false)];
        let mut random = Random::new(4);
        let mut workspace = Workspace::default();
        for at in over_holes(&centers, 40, &mut random) {
            for contacts in [Contacts::Deepest, Contacts::All] {
                let options = Options {
                    contacts,
                    prediction: REACH,
                    accuracy: Accuracy::Length(WIDTH),
                    ..Options::default()
                };
                let ball = Probe::Sphere(Sphere::new(at, RADIUS).unwrap());
                let [a, b] = both.each_ref().map(|brep| {
                    let a = contact(brep, &ball, &options, &mut workspace);
                    assert_eq!(a.undecided, None, "{at:?}");
                    let bounds = a.separation.bounds;
                    (bounds, a.contacts.len())
                });
                assert!(a.0.lo <= b.0.hi && b.0.lo <= a.0.hi, "{at:?}: {a:?} {b:?}");
                assert_eq!(a.1, b.1, "{at:?}: {contacts:?}");
            }
        }
    }
}

/// Balls on their way over a plate that is searched as a patch, whose witnesses learn from whole bunches of pieces: by short steps and long ones the distance is that by
/// analysis.
#[test]
fn ways_over_a_perforated_plate() {
    let (loops, centers) = perforated(SIDE, Holes::Splines);
    let searched = Shortcuts {
        closed_forms: false,
        ..Shortcuts::ALL
    };
    let brep = PreparedBrep::with_shortcuts(face_within(loops), searched);
    let mut random = Random::new(6);
    let mut workspace = Workspace::default();
    let options = Options {
        prediction: REACH,
        ..Options::default()
    };
    for step in [1e-4, 1e-2, 0.2] {
        let mut witness = Witness::default();
        let mut at = over_holes(&centers, 1, &mut random)[0];
        for k in 0..60 {
            let next = at + random.direction() * step;
            let half = 0.25 * PITCH * SIDE as f64;
            if next.x.abs().max(next.y.abs()) < half {
                at = Point3::new(next.x, next.y, next.z.abs());
            }
            let ball = Probe::Sphere(Sphere::new(at, RADIUS).unwrap());
            let a = contact_from(&brep, &ball, &mut witness, &options, &mut workspace);
            let truth = truth(Point2::new(at.x, at.y), at.z, Holes::Splines, &centers);
            let (b, separation) = (a.separation.bounds, truth.distance - RADIUS);
            assert!(
                b.lo <= separation + ROUNDED && separation - ROUNDED <= b.hi,
                "{step} {k}: {b:?} {separation}"
            );
            assert!(
                b.width() <= WIDTH && a.undecided.is_none(),
                "{step} {k}: {b:?}"
            );
        }
    }
}
