//! Widths of cracks, and what rests on them.
#![cfg(feature = "cgal")]

mod scene;

use feeler_oracle::Oracle;
use scene::model;
use std::time::Instant;

#[test]
fn print_widths() {
    for name in [
        "thesis/3dm/cube_nurbs.3dm",
        "thesis/3dm/cube.3dm",
        "thesis/3dm/ball_nurbs.3dm",
        "thesis/3dm/cylinder_nurbs.3dm",
        "thesis/3dm/cylinder_nurbs_unclamped.3dm",
        "thesis/3dm/ball_joint_cavity_nurbs.3dm",
        "thesis/3dm/ball_joint_socket_nurbs.3dm",
        "thesis/3dm/cube_corner_cut_nurbs.3dm",
        "thesis/3dm/cube_corner_sphere_cut_nurbs.3dm",
        "thesis/3dm/geneva4_wheel_nurbs.3dm",
        "thesis/3dm/geneva6_wheel_nurbs.3dm",
        "thesis/3dm/shift_gate_nurbs.3dm",
        "thesis/3dm/shift_gate_straight_nurbs.3dm",
        "real/v4_MechPartB.3dm",
        "real/v4_MechPartA.3dm",
        "real/v4_WishBone.3dm",
        "real/v4_DinerMug.3dm",
    ] {
        let Some(breps) = model(name) else { continue };
        let o = match Oracle::new(&breps.iter().collect::<Vec<_>>()) {
            Ok(o) => o,
            Err(e) => {
                println!("{name}: {e}");
                continue;
            }
        };
        let edges: usize = breps.iter().map(|b| b.parts().edges.len()).sum();
        println!("{name}: {edges} edges");
        let all = Instant::now();
        for e in 0..edges {
            let start = Instant::now();
            match o.crack_width(e) {
                Ok(Some(d)) => {
                    let (lo, hi) = (d.lo.approximate(), d.hi.approximate());
                    let time = start.elapsed();
                    let narrow = hi <= lo * (1.0 + 1.0 / 1000.0) || hi < 1e-28;
                    println!("  {e}: {lo:e} {hi:e} {} {time:?}", if narrow { "" } else { "WIDE" });
                }
                other => println!("  {e}: {other:?}"),
            }
        }
        println!("  {:?}", all.elapsed());
    }
}
