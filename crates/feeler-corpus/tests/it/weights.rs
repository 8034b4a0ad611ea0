//! Balls beside loops and patches whose weights are very different: most of a span's parameters are next to one control point, and the way to the next takes a thousandth of
//! them, or a millionth of a millionth.

use feeler::prepare::PreparedBrep;
use feeler::query::{Accuracy, Options, Probe, Sphere, Workspace, contact};
use feeler_corpus::Model;
use nalgebra::Point3;
use std::path::Path;

/// Asks for the distance of points from a model, which is known within so much.
fn check(model: &str, known: &[([f64; 3], f64)], within: f64) {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models");
    let model = Model::load(&models.join(model), None);
    let brep = PreparedBrep::new(model.expect("a model of the corpus").breps.remove(0));
    for &(center, distance) in known {
        let probe = Probe::Sphere(Sphere::new(Point3::from(center), 0.0).expect("a point"));
        for accuracy in [
            Accuracy::Full,
            Accuracy::Length(1e-12),
            Accuracy::Length(1e-3),
        ] {
            let options = Options {
                accuracy,
                node_budget: 4_000,
                ..Options::default()
            };
            let answer = contact(&brep, &probe, &options, &mut Workspace::default());
            let bounds = answer.separation.bounds;
            assert!(
                answer.undecided.is_none()
                    && bounds.lo - within <= distance
                    && distance <= bounds.hi + within,
                "{center:?} {accuracy:?}: {answer:?}"
            );
        }
    }
}

/// Weights of 1e-6 to 1e6. The distances were found apart, by de Boor's algorithm and a search by thirds over a hundred thousandth of the parameter, in f64.
#[test]
fn what_is_narrow_of_a_piece_is_found() {
    const KNOWN_WITHIN: f64 = 1e-12;
    let known = [
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
    ];
    check("trim-loops/weights_1e12_8.json.gz", &known, KNOWN_WITHIN);
}

/// The distances were found apart: Newton's method in numbers of 60 digits from the six best places of a grid in the logarithms of `u / (1 - u)` and `v / (1 - v)`.
const KNOWN_TO_60_DIGITS: f64 = 1e-16;

/// Weights of 1e-3 to 1e3 on a patch: on widths of a millionth `f` is no more convex than elsewhere, and the way down on a box need not end where it is least there.
#[test]
fn a_narrow_box_is_put_aside_by_its_least_value() {
    let known = [
        (
            [0.9433515347576795, 0.7064117218784494, 0.2381007573400178],
            0.4778664061700988,
        ),
        (
            [0.9635407261672411, 0.7070455775728646, 0.24360254783237456],
            0.4856891189049713,
        ),
    ];
    check("stress/weights_1e3.json.gz", &known, KNOWN_TO_60_DIGITS);
    // The nearest point is 1e-13 from a corner of the square of parameters.
    let known = [(
        [0.42627464587451724, 3.059316797931716, -0.758154248580839],
        0.8743608559822985,
    )];
    check("cases/E1_1e6.json.gz", &known, KNOWN_TO_60_DIGITS);
}

/// Weights of 1e-12 to 1e12: what is near is between 1e-14 and 1e-11 from the corner where the parameters are 0, on boxes of widths far below that.
#[test]
fn what_is_next_to_the_start_of_a_patch_is_found() {
    let known = [
        (
            [
                -0.12019869864989409,
                1.1651393884019294,
                -0.3817075493978235,
            ],
            0.6452748609286753,
        ),
        (
            [
                -0.0010425178744970232,
                0.6343126992571717,
                0.05108731077332074,
            ],
            0.04009489970319037,
        ),
    ];
    check("cases/E1_1e12.json.gz", &known, KNOWN_TO_60_DIGITS);
}
