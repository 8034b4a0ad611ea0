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
    // Rows of the first table: the second is about the solver.
    let mut brep = rows(&found.page, "BREP");
    brep.retain(|r| r.len() == 12);
    let off = brep[0].iter().rev().nth(2).unwrap();
    let off: f64 = off.trim_end_matches('%').trim().parse().unwrap();
    assert!(off.abs() < 2.0, "{:?}", brep[0]);
    assert_eq!(brep.len(), 3);
    // The depth grows because of the engine's limit of the corrective velocity.
    let growth = |solver: &str| rows(&found.page, solver)[0][3].parse::<f64>().unwrap();
    let free = growth("no limit of the corrective velocity").abs();
    assert!(growth("as above |") > 10.0 * free, "{}", found.page);
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
    // What is to be seen is named, and is where the ball touches.
    let names: Vec<_> = found.scenes.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["rolling-torus", "rolling-sheet"]);
    for scene in &found.scenes {
        assert!(found.page.contains(&format!("({}.html)", scene.name)));
        assert_eq!(scene.queries.len(), 12);
    }
}

#[test]
fn stiff() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models");
    let found = run("stiff", &models, Extent::Quick, &mut |_| {}).unwrap();
    let number = |row: &[String], k: usize| row[k].parse::<f64>().unwrap();
    // The tables in detail have 11 columns, of which the third is the drift; in order: sliding, rolling, seams.
    let detailed = |word: &str| {
        let all = rows(&found.page, word).into_iter();
        all.filter(|r| r.len() == 13).collect::<Vec<_>>()
    };
    let breps = detailed("BREP, NURBS, full");
    let meshes = detailed("10 degree mesh");
    assert_eq!((breps.len(), meshes.len()), (4, 8));
    // Steps of 1e-4 s are 0.014 of the pendulum's time sqrt(L / g): errors of a method of order 3 or better go with its cube.
    let pendulum = (9810.0f64 / 0.5).sqrt();
    let bound = (1e-4 * pendulum).powi(3);
    for brep in breps.iter().filter(|r| r[2] == "1e12") {
        assert!(number(brep, 3) < bound, "{brep:?}");
    }
    // Each edge of the mesh costs some sin^2 of its angle.
    for mesh in meshes[..2].iter().filter(|r| r[2] == "1e12") {
        let loss = 10f64.to_radians().sin().powi(2);
        assert!(number(mesh, 3) > loss, "{mesh:?}");
    }
    for (name, svg) in &found.plots {
        assert!(
            found.page.contains(name) && svg.contains("<polyline"),
            "{name}"
        );
    }
}

#[test]
fn shift_gate() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models");
    let found = run("shift-gate", &models, Extent::Quick, &mut |_| {}).unwrap();
    let brep = &rows(&found.page, "BREP")[0];
    assert_eq!(brep[3], "1 2 3 4 5", "{brep:?}");
    // The wall bears a spring that is drawn beyond it, and is not passed: depths stay below what is left of the ball's play.
    assert!(brep[8].parse::<f64>().unwrap() < 0.1, "{brep:?}");
}

#[test]
fn balls() {
    let found = run("balls", Path::new(""), Extent::Quick, &mut |_| {}).unwrap();
    let brep = &rows(&found.page, "BREP |")[0];
    // All lie on the ground, no deeper than the softness lets them: some g / (2 pi f)^2 = 0.25 um.
    assert!(brep[4].contains("(10 touch"), "{brep:?}");
    let depth = brep[4].split(", ").nth(1).unwrap();
    let depth: f64 = depth.trim_end_matches(" mm)").parse().unwrap();
    assert!((5e-5..5e-4).contains(&depth), "{brep:?}");
}

#[test]
fn geneva() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models");
    let found = run("geneva", &models, Extent::Quick, &mut |_| {}).unwrap();
    let wheel = &rows(&found.page, "geneva4_wheel.3dm |")[0];
    let number = |k: usize| {
        let cell = wheel[k].split(' ').next().unwrap();
        cell.parse::<f64>().unwrap()
    };
    // A quarter a turn, within the play; where it is driven, too.
    let play = wheel[4].split("(play ").nth(1).unwrap();
    let play: f64 = play.trim_end_matches(')').parse().unwrap();
    assert!(number(4) <= play && play < 0.7, "{wheel:?}");
    assert!(number(5) <= 1.0, "{wheel:?}");
    assert!((number(6) / 2.414 - 1.0).abs() < 0.1, "{wheel:?}");
    // The pin touches the walls of slots, and hardly sinks in.
    assert!(number(7) > 0.0 && number(7) < 0.02, "{wheel:?}");
    // Or the round end of the slot, within the play of 0.1 mm.
    assert!(number(8) <= 0.101, "{wheel:?}");
    let scene = &found.scenes[0];
    assert_eq!(scene.queries.len(), 9);
}
