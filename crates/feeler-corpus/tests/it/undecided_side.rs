//! Lists of contacts where the side of the centre is not known: each separation must hold both signs of the distance.

use feeler::prepare::PreparedBrep;
use feeler::query::{Contacts, Options, Probe, Sphere, Undecided, Workspace, contact};
use feeler_corpus::Model;
use nalgebra::Point3;
use std::path::Path;

#[test]
fn separations_hold_both_signs_where_the_side_is_undecided() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models");
    let path = models.join("parts/bored_block.json.gz");
    let model = Model::load(&path, None).expect("a model of the corpus");
    let brep = model.breps.into_iter().next().expect("a BREP");
    let brep = PreparedBrep::new(brep);
    // Within a crack's width of an edge as seen along every ray that is tried; it is in material.
    let center = Point3::new(-12.853967712206433, -2.149803955022726, -13.522263360787846);
    let radius = 3.466529946178027;
    let probe = Probe::Sphere(Sphere::new(center, radius).expect("a sphere"));
    let options = Options {
        prediction: 6.24954062456856,
        contacts: Contacts::All,
        ..Options::default()
    };
    let found = contact(&brep, &probe, &options, &mut Workspace::default());
    if found.undecided != Some(Undecided::Degenerate) {
        println!("the side of this centre is decided now: choose another for this test");
    }
    assert!(found.contacts.len() > 1, "{found:?}");
    for c in &found.contacts {
        let d = (c.on_brep - center).norm();
        // Rounding of the distance computed here.
        let off = 1e-12;
        let bounds = c.separation.bounds;
        assert!(bounds.lo <= -d - radius + off, "{d} {c:?}");
        if found.undecided == Some(Undecided::Degenerate) {
            assert!(bounds.hi >= d - radius - off, "{d} {c:?}");
        }
    }
}
