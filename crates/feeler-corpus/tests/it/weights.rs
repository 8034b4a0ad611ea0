//! Balls beside a loop whose weights are 1e-6 to 1e6: most of a span's parameters are next to one control point, and the way to the next takes a thousandth of them.

use feeler::prepare::PreparedBrep;
use feeler::query::{Accuracy, Options, Probe, Sphere, Workspace, contact};
use feeler_corpus::Model;
use nalgebra::Point3;
use std::path::Path;

/// The distances were found apart, by de Boor's algorithm and a search by thirds over a hundred thousandth of the parameter, in f64.
const KNOWN_WITHIN: f64 = 1e-12;

#[test]
fn what_is_narrow_of_a_piece_is_found() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/trim-loops");
    let model = Model::load(&models.join("weights_1e12_8.json.gz"), None);
    let brep = PreparedBrep::new(model.expect("a model of the corpus").breps.remove(0));
    for (center, distance) in [
        (
            [
                1.0764014376527111,
                0.33966241081064646,
                -0.08650744746727829,
            ],
            0.19803242696184312,
        ),
        (
            [1.0818875743476928, 0.32175061070225563, 0.25583632524083055],
            0.31870927535802884,
        ),
    ] {
        let probe = Probe::Sphere(Sphere::new(Point3::from(center), 0.0).expect("a point"));
        for accuracy in [
            Accuracy::Full,
            Accuracy::Length(1e-12),
            Accuracy::Length(1e-3),
        ] {
            let options = Options {
                accuracy,
                node_budget: 1_000,
                ..Options::default()
            };
            let answer = contact(&brep, &probe, &options, &mut Workspace::default());
            let bounds = answer.separation.bounds;
            assert!(
                answer.undecided.is_none()
                    && bounds.lo - KNOWN_WITHIN <= distance
                    && distance <= bounds.hi + KNOWN_WITHIN,
                "{center:?} {accuracy:?}: {answer:?}"
            );
        }
    }
}
