//! A ball that jumps, with what its last places taught: the answer must be as narrow as a new one.

use feeler::prepare::PreparedBrep;
use feeler::query::{Accuracy, Options, Probe, Sphere, Witness, Workspace, contact, contact_from};
use feeler_corpus::Model;
use nalgebra::{Point3, Vector3};
use std::path::Path;

/// The nearest point may be on a kept part of which no point is known, far below the best one that is: on a trim that is a point in space, all of whose values are
/// one, or on one of many trims of a face that is nearest within none of them.
#[test]
fn a_jump_costs_no_answer() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models");
    let mut workspace = Workspace::default();
    // A ball under the base and then above the apex, which is at (0, 0, 4); over the islands, and far away.
    for (model, from, to) in [
        (
            "analytic/cone_nurbs.json.gz",
            [0.5, 0.25, 0.25],
            [0.5, 2.25, 8.75],
        ),
        (
            "trim-loops/islands_rational_warped.json.gz",
            [0.5, 0.5, 0.25],
            [736.0, -519.0, 434.0],
        ),
    ] {
        let model = Model::load(&models.join(model), None).expect("a model of the corpus");
        let brep = PreparedBrep::new(model.breps.into_iter().next().expect("a BREP"));
        let mut witness = Witness::default();
        for k in 0..12 {
            let home = if k % 3 == 2 { to } else { from };
            let off = Vector3::new(0.0, 1e-3 * f64::from(k), 0.0);
            let probe = Probe::Sphere(Sphere::new(Point3::from(home) + off, 0.125).unwrap());
            for accuracy in [Accuracy::Full, Accuracy::Length(1e-6)] {
                let options = Options {
                    accuracy,
                    prediction: f64::INFINITY,
                    node_budget: 20_000,
                    ..Options::default()
                };
                let warm = contact_from(&brep, &probe, &mut witness, &options, &mut workspace);
                let cold = contact(&brep, &probe, &options, &mut workspace);
                let (a, b) = (cold.separation.bounds, warm.separation.bounds);
                assert!(a.lo <= b.hi && b.lo <= a.hi, "{cold:?} {warm:?}");
                assert_eq!(cold.undecided, warm.undecided, "{k} {probe:?} {warm:?}");
            }
        }
    }
}
