//! Native surfaces and arcs: evaluation, sides in uv.
#![cfg(feature = "cgal")]

mod scene;

use feeler::brep::Brep;
use feeler::nurbs::Surface;
use feeler_oracle::Oracle;

/// Models of the thesis in their native form.
const NATIVE: [&str; 6] = [
    "ball",
    "ball_joint_cavity",
    "cylinder",
    "cube_corner_sphere_cut",
    "geneva4_driver",
    "shift_gate_straight",
];

#[test]
fn native_models_are_accepted() {
    let mut revolutions = 0;
    for name in NATIVE {
        let Some(breps) = scene::model(&format!("thesis/3dm/{name}.3dm")) else {
            continue;
        };
        let all: Vec<&Brep> = breps.iter().collect();
        let oracle = Oracle::new(&all).unwrap();
        let faces: usize = breps.iter().map(|b| b.faces().len()).sum();
        assert_eq!(oracle.faces(), faces);
        for b in &breps {
            revolutions += (0..b.faces().len())
                .filter(|f| matches!(b.surface(*f), Surface::Revolution(_)))
                .count();
        }
    }
    println!("{revolutions} revolutions");
}
