//! Points exactly on the surface of a solid, whose places are numbers that f64 holds: on faces, seams and rims. Next to them it is another side.

use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, Feature, HalfSpace, Options, Probe, Sphere, Workspace, contact, inside, side,
};
use feeler::trim::Side;
use feeler_corpus::Model;
use nalgebra::{Point3, Vector3};
use std::path::Path;

fn model(name: &str) -> PreparedBrep {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/analytic");
    let model = Model::load(&models.join(format!("{name}.json.gz")), None);
    PreparedBrep::new(model.expect("a model of the corpus").breps.remove(0))
}

/// The point is on the boundary, and the separation of a ball about it is minus its radius; off it along `out` it is outside, against it
/// inside, as far as that is told: by a rounding it need not be, and on a rim not even that is so.
fn on_boundary(brep: &PreparedBrep, at: [f64; 3], out: [f64; 3], what: &str) {
    let (mut w, at, out) = (Workspace::default(), Point3::from(at), Vector3::from(out));
    let found = inside(brep, at, &mut w);
    assert_eq!(found.side, Some(Side::Boundary), "{what}, {at}: {found:?}");
    for accuracy in [Accuracy::Full, Accuracy::Length(1e-9)] {
        let options = Options {
            accuracy,
            prediction: f64::INFINITY,
            ..Options::default()
        };
        let probe = Probe::Sphere(Sphere::new(at, 0.5).expect("a ball"));
        let answer = contact(brep, &probe, &options, &mut w);
        let bounds = answer.separation.bounds;
        assert!(
            answer.undecided.is_none() && bounds.lo <= -0.5 && -0.5 <= bounds.hi,
            "{what}, {at}: {answer:?}"
        );
    }
    let rim = out.iter().filter(|x| **x != 0.0).count() > 1 && out.norm() > 1.1;
    for (off, must) in [
        (1e-6, true),
        (4.0 * f64::EPSILON, false),
        (f64::EPSILON, false),
    ] {
        for (sign, side) in [(1.0, Side::Outside), (-1.0, Side::Inside)] {
            let moved = at + out * (sign * off);
            if moved == at {
                continue;
            }
            let found = inside(brep, moved, &mut w).side;
            let right = found == Some(side) || !must && (rim || found.is_none());
            assert!(right, "{what}, {moved}, off {at}: {found:?}");
        }
    }
}

const ACROSS: [[f64; 2]; 4] = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];

/// The axis is `x = 1/4, y = 1/2`, the radius 3/2, and z goes from -1 to 4; the seam is along x.
#[test]
fn on_a_cylinder() {
    let brep = model("cylinder");
    for [x, y] in ACROSS {
        let at = |z: f64| [0.25 + 1.5 * x, 0.5 + 1.5 * y, z];
        for z in [-0.75, 0.0, 1.0, 3.5] {
            on_boundary(&brep, at(z), [x, y, 0.0], "cylinder");
        }
        on_boundary(&brep, at(-1.0), [x, y, -1.0], "its lower rim");
        on_boundary(&brep, at(4.0), [x, y, 1.0], "its upper rim");
    }
}

/// About `(1/2, -1/4, 1)`, of radius 2: its seam is along x.
#[test]
fn on_a_sphere() {
    let brep = model("sphere");
    for [x, y] in ACROSS {
        let at = [0.5 + 2.0 * x, -0.25 + 2.0 * y, 1.0];
        on_boundary(&brep, at, [x, y, 0.0], "sphere");
    }
}

/// The base has radius 3 about the origin, the apex is `(0, 0, 4)`.
#[test]
fn on_a_cone() {
    let brep = model("cone");
    for [x, y] in ACROSS {
        for z in [0.5, 1.0, 2.0, 3.0] {
            let radius = 0.75 * (4.0 - z);
            let out = [0.8 * x, 0.8 * y, 0.6];
            on_boundary(&brep, [radius * x, radius * y, z], out, "cone");
        }
        on_boundary(&brep, [3.0 * x, 3.0 * y, 0.0], [x, y, -1.0], "its rim");
    }
    // The other half of the cone is no part of it.
    let found = inside(
        &brep,
        Point3::new(0.75, 0.0, 5.0),
        &mut Workspace::default(),
    );
    assert_eq!(found.side, Some(Side::Outside));
}

/// A half-space rests all but flat on a base of the cylinder: asked coarsely, the foot is found higher than the least, and the point opposite is on the plane all the same.
#[test]
fn opposite_a_coarse_foot_on_the_plane_of_a_half_space() {
    for name in ["cylinder", "cylinder_nurbs"] {
        let brep = model(name);
        for tilt in [1e-6, 1e-5, 1e-3, 0.25] {
            let normal = Vector3::new(0.6 * tilt, 0.8 * tilt, -1.0).normalize();
            let plane = HalfSpace::new(normal, -3.5).expect("a half-space");
            for accuracy in [1e-12, 1e-6, 1e-2] {
                let options = Options {
                    accuracy: Accuracy::Length(accuracy),
                    prediction: f64::INFINITY,
                    ..Options::default()
                };
                let probe = Probe::HalfSpace(plane);
                let answer = contact(&brep, &probe, &options, &mut Workspace::default());
                let at = answer.contacts[0].on_probe;
                let off = plane.normal.dot(&at.coords) - plane.offset;
                // Some roundings of coordinates.
                assert!(off.abs() <= 64.0 * f64::EPSILON, "{name} {tilt} {off:e}");
            }
        }
    }
}

/// A half-space rests on a plane end of part of a torus, whose loop's trims meet but for roundings, as STEP has them. Its foot is on the segment that joins two, beside the
/// region by roundings: that is on their vertex.
#[test]
fn a_foot_between_ends_of_trims_is_on_their_vertex() {
    /// A vertex and the ends of its trims are that near in STEP files, as a part of the size.
    const NEAR: f64 = 1e-9;
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/step");
    let model = Model::load(&models.join("torus_part.step"), None);
    let brep = PreparedBrep::new(model.expect("a model of the corpus").breps.remove(0));
    let normal = Vector3::new(0.20628424918308755, -0.3094263738970618, 0.9282791216416998);
    let plane = HalfSpace::new(normal, 1.580544601759037).expect("a half-space");
    let options = Options {
        prediction: f64::INFINITY,
        ..Options::default()
    };
    let probe = Probe::HalfSpace(plane);
    let answer = contact(&brep, &probe, &options, &mut Workspace::default());
    let found = answer.contacts[0];
    let told = side(&brep, found.face, found.uv).expect("a face");
    assert_ne!(told.side, Some(Side::Inside), "{found:?}");
    let Feature::Vertex(vertex) = found.feature else {
        panic!("{found:?}");
    };
    let off = brep.brep().parts().vertices[vertex].point - found.on_brep;
    assert!(off.norm() <= NEAR * brep.size(), "{found:?}");
}

/// A half-space is flush with an end of a NURBS cylinder or frustum, whose rim's trims bulge over the border of the side's domain by roundings, as those of the corpus do: the
/// end is a plane at `z`, no point of the side is beyond it, and so the separation is exactly 0. That takes few nodes.
#[test]
fn flush_with_an_end_whose_rim_bulges_by_roundings() {
    const BUDGET: usize = 10_000;
    for (name, up, z) in [
        ("cylinder_nurbs", 1.0, 4.0),
        ("cylinder_nurbs", -1.0, -1.0),
        ("frustum_nurbs", 1.0, 2.75),
    ] {
        let brep = model(name);
        let normal = Vector3::new(0.0, 0.0, -up);
        let plane = HalfSpace::new(normal, -up * z).expect("a half-space");
        let options = Options {
            prediction: f64::INFINITY,
            node_budget: BUDGET,
            ..Options::default()
        };
        let probe = Probe::HalfSpace(plane);
        let answer = contact(&brep, &probe, &options, &mut Workspace::default());
        assert!(answer.undecided.is_none(), "{name} {up}: {answer:?}");
        let found = answer.separation;
        assert!(
            found.bounds.lo <= 0.0 && 0.0 <= found.bounds.hi,
            "{name} {up}: {found:?}"
        );
        assert!(answer.continuum, "{name} {up}");
    }
}

/// A half-space is flush with a part, no point of which is beyond the plane, and one is on it: the separation is exactly 0. Where a rim rests on it all of that is at one height, on some
/// tens of pieces. The seam of the frustum begins beyond the border of the side's domain, by roundings, along which it bulges inward by as little. By an ulp of the plane's offset
/// farther off or deeper it is that.
#[test]
fn flush_with_a_rim_and_with_what_ends_beyond_a_border() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models");
    for (name, normal, offset) in [
        ("parts/bored_block.json.gz", [1.0, 0.0, 0.0], -20.0),
        ("parts/bored_block.json.gz", [-1.0, 0.0, 0.0], -20.0),
        ("parts/vase.json.gz", [0.0, 0.0, -1.0], -36.0),
        ("thesis/cube_corner_cut_nurbs.3dm", [0.0, -1.0, 0.0], -10.0),
        ("analytic/frustum_nurbs.json.gz", [-1.0, 0.0, 0.0], -2.0),
        ("analytic/frustum_nurbs.json.gz", [0.0, 0.0, 1.0], 0.25f64),
    ] {
        let model = Model::load(&models.join(name), None);
        let brep = PreparedBrep::new(model.expect("a model of the corpus").breps.remove(0));
        for moved in [offset, offset.next_up(), offset.next_down()] {
            let plane = HalfSpace::new(Vector3::from(normal), moved).expect("a half-space");
            let probe = Probe::HalfSpace(plane);
            let answer = contact(
                &brep,
                &probe,
                &Options::default(),
                &mut Workspace::default(),
            );
            assert!(answer.undecided.is_none(), "{name} {moved}: {answer:?}");
            let bounds = answer.separation.bounds;
            // Of numbers next to each other this is exact.
            let expected = offset - moved;
            assert!(
                bounds.lo <= expected && expected <= bounds.hi,
                "{name} {moved}: {bounds:?}"
            );
        }
    }
}
