//! How `feeler inspect` looks. The counts are facts of the model.

use crate::program::feeler;

const PART: &str = "corpora/models/thesis/cube_corner_sphere_cut_nurbs.3dm";

#[test]
fn inspect_as_text() {
    let run = feeler(&["inspect", PART], "");
    assert_eq!(run.code, Some(0), "{run:?}");
    insta::assert_snapshot!(run.out);
}

#[test]
fn inspect_as_json() {
    let run = feeler(&["inspect", PART, "--json"], "");
    assert_eq!(run.code, Some(0), "{run:?}");
    insta::assert_snapshot!(run.out);
}
