//! Lines that run along a seam or a rim within the width of its crack.

use feeler::prepare::PreparedBrep;
use feeler::query::{LineAnswer, LineKind, LineProbe, Options, Workspace, line};
use feeler_corpus::Model;
use std::path::Path;

fn model(name: &str) -> PreparedBrep {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/analytic");
    let model = Model::load(&models.join(format!("{name}.json.gz")), None);
    PreparedBrep::new(model.expect("a model of the corpus").breps.remove(0))
}

fn ask(brep: &PreparedBrep, origin: [f64; 3], d: [f64; 3]) -> LineAnswer {
    let probe = LineProbe::new(origin.into(), d.into(), LineKind::Line);
    let probe = probe.expect("a line");
    line(brep, &probe, &Options::default(), &mut Workspace::default())
}

/// The sphere about (1/2, -1/4, 1) of radius 2, whose pole is (1/2, -1/4, 3) but for a hole of some 1e-16, and whose seam is in the plane y = -1/4. The seam's angles are
/// 0 and 2 pi in f64, which is 2.4e-16 less: that turns it by 4.9e-16, its crack's width, at the equator. A line in that plane that is `below` the pole
/// is a chord of half length `l`, `l^2 = below (4 - below)`.
#[test]
fn along_the_seam_of_a_sphere() {
    let brep = model("sphere");
    for below in [
        0.0, 4.5e-16, -4.5e-16, 1e-15, 1e-12, 1e-9, 1e-8, -1e-15, -1e-12,
    ] {
        let z = 3.0 - below;
        let below = 3.0 - z;
        let answer = ask(&brep, [-4.0, -0.25, z], [1.0, 0.0, 0.0]);
        assert_eq!(answer.undecided, None, "{below}: {answer:?}");
        if below > 0.0 {
            let l = (below * (4.0 - below)).sqrt();
            let off = [4.5 - l, 4.5 + l];
            assert_eq!(answer.hits.len(), 2, "{below}: {answer:?}");
            for (h, t) in answer.hits.iter().zip(off) {
                let bounds = h.t.bounds;
                let near = 1e-14;
                assert!(
                    bounds.lo <= t + near && t - near <= bounds.hi,
                    "{below}: {answer:?}"
                );
            }
        } else {
            // At the pole it is through the hole.
            assert_eq!(answer.hits.len(), 0, "{below}: {answer:?}");
            assert_eq!(answer.crossings, Some(0), "{below}: {answer:?}");
            assert_eq!(answer.in_crack, below > -4.8e-16, "{below}: {answer:?}");
        }
    }
}

/// A cylinder of radius 5/2 and height 10 about the z axis, as NURBS, whose rims are trims that bulge off the surface's borders, `v = 0` and `v = 10`, by some 1e-16. A line in the plane of
/// the lower rim meets the border's circle; where the rim is above it that is no hit with the side (by the oracle: the first line has none with face 0, the second one at its start).
#[test]
fn in_the_plane_of_a_rim_that_bulges() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/thesis");
    let model = Model::load(&models.join("cylinder_nurbs.3dm"), None);
    let brep = PreparedBrep::new(model.expect("a model of the corpus").breps.remove(0));
    let answer = ask(&brep, [-3.5000000000000004, -1.25, 0.0], [1.0, 0.0, 0.0]);
    assert_eq!(answer.undecided, None, "{answer:?}");
    let half = (2.5f64.powi(2) - 1.25f64.powi(2)).sqrt();
    let side: Vec<f64> = answer
        .hits
        .iter()
        .filter(|h| h.face == 0)
        .map(|h| h.t.value)
        .collect();
    assert_eq!(side.len(), 1, "{answer:?}");
    assert!((side[0] - (3.5 - half)).abs() < 1e-14, "{answer:?}");
    let cap: Vec<_> = answer.hits.iter().filter(|h| h.face == 2).collect();
    assert!(cap.len() == 1 && cap[0].t_end.is_some(), "{answer:?}");
    // It leaves the cap through the crack, where the side has no hit.
    assert!(answer.in_crack, "{answer:?}");
}

/// A segment within an edge of a block runs in both faces there, though neither of its ends is one of the edge's.
#[test]
fn within_an_edge_of_a_block() {
    let brep = model("block_nurbs");
    let (origin, d) = ([2.0, -2.0, 1.5], [0.0, 0.0, 0.25]);
    let probe = LineProbe::new(origin.into(), d.into(), LineKind::Segment).expect("a segment");
    let answer = line(
        &brep,
        &probe,
        &Options::default(),
        &mut Workspace::default(),
    );
    assert_eq!(answer.undecided, None, "{answer:?}");
    assert_eq!(answer.hits.len(), 2, "{answer:?}");
    for h in &answer.hits {
        let ends = (h.t.value, h.t_end.map(|t| t.value));
        assert_eq!(ends, (0.0, Some(1.0)), "{answer:?}");
    }
    assert!(!answer.in_crack, "{answer:?}");
}

/// A cylinder as above: a line through its axis in the plane of its lower rim passes the seam where that meets the rim, at the corner (5/2, 0, 0) of the surface, where both borders' trims end.
#[test]
fn through_the_corner_of_a_seam() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/thesis");
    let model = Model::load(&models.join("cylinder_nurbs_unclamped.3dm"), None);
    let brep = PreparedBrep::new(model.expect("a model of the corpus").breps.remove(0));
    let answer = ask(&brep, [-3.5, 0.0, 0.0], [1.0, 0.0, 0.0]);
    assert_eq!(answer.undecided, None, "{answer:?}");
    let side = answer.hits.iter().filter(|h| h.face == 0);
    let side: Vec<f64> = side.map(|h| h.t.value).collect();
    assert_eq!(side.len(), 2, "{answer:?}");
    assert!(
        (side[0] - 1.0).abs() < 1e-14 && side[1] == 6.0,
        "{answer:?}"
    );
}
