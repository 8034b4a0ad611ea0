//! The experiments run, and say what the closed forms say.

use feeler_rapier::experiment::{Extent, run};
use std::path::Path;

/// The cells of the rows of the page's table that have this word.
fn rows(page: &str, word: &str) -> Vec<Vec<String>> {
    let lines = page
        .lines()
        .filter(|l| l.starts_with('|') && l.contains(word));
    lines
        .map(|l| l.split('|').map(|c| c.trim().to_owned()).collect())
        .collect()
}

#[test]
fn ball_joint() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models");
    let mut heard = 0;
    let found = run("ball-joint", &models, Extent::Quick, &mut |_| heard += 1).unwrap();
    assert!(heard >= 9);
    // The ball that fits slides where the closed form says.
    let brep = rows(&found.page, "BREP");
    let off = brep[0].iter().rev().nth(2).unwrap();
    let off: f64 = off.trim_end_matches('%').trim().parse().unwrap();
    assert!(off.abs() < 2.0, "{:?}", brep[0]);
    assert_eq!(brep.len(), 3);
    for (name, svg) in &found.plots {
        assert!(
            found.page.contains(name) && svg.contains("<polyline"),
            "{name}"
        );
    }
    assert!(run("none", &models, Extent::Quick, &mut |_| {}).is_err());
}

#[test]
fn rolling() {
    let models = Path::new("");
    let found = run("rolling", models, Extent::Quick, &mut |_| {}).unwrap();
    let number = |row: &[String], k: usize| row[k].parse::<f64>().unwrap();
    let breps = rows(&found.page, "BREP");
    let brep = &breps[0];
    // What the BREP is off by goes with the engine's time steps: a tenth of the step, a tenth of it.
    for column in [4, 6, 7] {
        let ratio = number(&breps[1], column) / number(brep, column);
        assert!((0.05..0.2).contains(&ratio), "{column}: {ratio}");
    }
    let mesh = &rows(&found.page, "mesh")[0];
    // The path in mm, and the largest jump of the velocity: the mesh has bumps.
    assert!(number(brep, 4) < 1.0, "{brep:?}");
    assert!(number(mesh, 4) > 3.0 * number(brep, 4), "{brep:?} {mesh:?}");
    assert!(number(mesh, 7) > 3.0 * number(brep, 7), "{brep:?} {mesh:?}");
}
