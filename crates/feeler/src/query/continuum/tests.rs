//! What single steps tell, against analysis.

use super::ball::STEEP;
use super::*;
use crate::brep::Brep;
use crate::numeric::Dd;
use crate::nurbs::{NurbsSurface, Surface};
use crate::query::tests::bowl;
use nalgebra::Vector4;

/// Thresholds are told from what is this part of them below and above.
const BESIDE: f64 = 1e-9;

/// A foot at local parameters of the only patch of the only face.
fn foot(at: [f64; 2]) -> Foot {
    Foot {
        face: 0,
        trim: None,
        uv: Point2::origin(),
        spot: Locus::Patch {
            patch: 0,
            local: at.map(Ball::<Dd>::exact),
            point: None,
        },
        found: None,
    }
}

/// Along the way on which it grows least, the squared distance of `center` from points `x` away from the foot is `f0 + least x^2 + ...`. With a growth that is
/// [`STEEP`]² times less than that at the reach it bends up, and with more it does not.
fn assert_threshold(brep: &PreparedBrep, at: [f64; 2], center: Point3<f64>, least: f64) {
    for reach in [1.0, 0.125, 1e-3] {
        let low = Low {
            brep,
            objective: &Objective::SquaredDistance(center),
            limit: 0.0,
            slack: 0.0,
            reach,
        };
        let threshold = least * reach * reach / (STEEP * STEEP);
        let bends_up = |part: f64| low.bends_up(&foot(at), part * threshold);
        let told = [1.0 - BESIDE, 1.0 + BESIDE].map(bends_up);
        assert_eq!(told, [least > 0.0, false], "{center} {least} {reach}");
    }
}

/// At the bottom of `z = x^2 + y^2` the squared distance of `(0, 0, c)` is `c^2 + (1 - 2 c) (x^2 + y^2) + ...`, alike on all sides; beside the axis plane `y = 0`, of
/// `p = (b, 0, b^2) + d n` with the unit normal `n` along `(-2 b, 0, 1)` there, it grows by `1 - d k` with the principal curvatures `k`: `2 / q^3` along x,
/// `2 / q` along y, where `q^2 = 1 + 4 b^2`; the larger leaves less.
#[test]
fn what_bends_up_in_a_bowl() {
    let brep = bowl(0.25);
    for c in [-2.0, -0.25, 0.0, 0.25, 0.484_375] {
        let center = Point3::new(0.0, 0.0, c);
        assert_threshold(&brep, [0.5, 0.5], center, 1.0 - 2.0 * c);
    }
    // Above the focal point it comes down on all sides.
    assert_threshold(&brep, [0.5, 0.5], Point3::new(0.0, 0.0, 0.75), 0.0);
    let b: f64 = -0.5;
    let q = (1.0 + 4.0 * b * b).sqrt();
    for d in [-1.5, 0.25, 0.5] {
        let center = Point3::new(b - 2.0 * b * d / q, 0.0, b * b + d / q);
        // Below the bowl the other one is less.
        let least = [q, q * q * q].map(|q| 1.0 - 2.0 * d / q);
        let least = least[0].min(least[1]);
        assert_threshold(&brep, [0.5 * (1.0 + b), 0.5], center, least);
    }
}

/// On a plane the squared distance from the foot of a centre grows by the square of the way, however skew and long its parameters' lines are.
#[test]
fn what_bends_up_over_a_skew_plane() {
    let (along_u, along_v) = (Vector3::new(2.0, 0.0, 0.0), Vector3::new(8.0, 0.5, 0.0));
    let corner = |k: usize| {
        let p = along_u * (k / 2) as f64 + along_v * (k % 2) as f64;
        Vector4::new(p.x, p.y, p.z, 1.0)
    };
    let knots = || vec![0.0, 0.0, 1.0, 1.0];
    let net = (0..4).map(corner).collect();
    let surface = NurbsSurface::new([1, 1], [2, 2], net, [knots(), knots()]).unwrap();
    let brep = Brep::from_surface(Surface::Nurbs(surface)).unwrap();
    let brep = PreparedBrep::new(brep);
    let at = [0.25, 0.75];
    for height in [0.0, 1.0, -20.0] {
        let p = along_u * at[0] + along_v * at[1];
        assert_threshold(&brep, at, Point3::new(p.x, p.y, height), 1.0);
    }
}

/// Of what a formula tells nothing is looked at.
#[test]
fn nothing_bends_up_in_closed_form() {
    let brep = bowl(0.25);
    let low = Low {
        brep: &brep,
        objective: &Objective::SquaredDistance(Point3::new(0.0, 0.0, -1.0)),
        limit: 0.0,
        slack: 0.0,
        reach: 1.0,
    };
    let closed = Foot {
        spot: Locus::Closed {
            point: [Ball::ZERO; 3],
        },
        ..foot([0.5, 0.5])
    };
    assert!(!low.bends_up(&closed, 0.0));
    assert!(low.bends_up(&foot([0.5, 0.5]), 0.0));
}
