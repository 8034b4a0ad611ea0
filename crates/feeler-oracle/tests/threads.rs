//! Oracles on several threads at once: each has its own, none disturbs another. `cargo xtask
//! sanitize thread` runs this under ThreadSanitizer.
#![allow(dead_code, reason = "of the shared scenes a few are used")]

#[path = "oracle/scene/mod.rs"]
mod scene;

use feeler::brep::Brep;
use feeler::query::LineKind;
use feeler_oracle::Oracle;
use scene::model;

/// All kinds of truths, from an oracle of the calling thread's own, as text.
fn truths(breps: &[Brep]) -> String {
    let all: Vec<&Brep> = breps.iter().collect();
    let oracle = Oracle::new(&all).unwrap();
    let mut text = String::new();
    for k in 0..4 {
        let x = f64::from(k) * 0.75 - 1.0;
        text += &format!(
            "{:?}\n{:?}\n{:?}\n{:?}\n",
            oracle.sphere([x, 0.3, 6.0], 0.25, None).unwrap(),
            oracle.half_space([0.6, 0.0, 0.8], x, None).unwrap(),
            oracle
                .line([x, 0.1, -9.0], [0.1, 0.2, 1.0], LineKind::Line)
                .unwrap(),
            oracle.inside([x, 0.2, 0.1]).unwrap(),
        );
        for face in 0..oracle.faces() {
            text += &format!(
                "{:?}\n{:?}\n",
                oracle.side(face, [x, 0.1]).unwrap(),
                oracle.evaluate(face, [x.abs().fract(), 0.5]).ok(),
            );
        }
    }
    text
}

fn main() {
    let Some(breps) = model("thesis/3dm/cube_corner_cut_nurbs.3dm") else {
        return;
    };
    let expected = truths(&breps);
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..3).map(|_| scope.spawn(|| truths(&breps))).collect();
        for thread in threads {
            assert!(thread.join().unwrap() == expected);
        }
    });
    println!("oracles on threads give the same bits: ok");
}
