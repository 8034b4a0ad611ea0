//! Loops that do not close in uv.
//!
//! On a closed surface a loop may run around and end one period from where it started, unless
//! the seam is part of it. Parity needs loops that close up to small gaps, and programs that write
//! .3dm files store the seam as trims of their own; a loop without them is reported.

use feeler::brep::{Brep, TrimCurve};
use nalgebra::Point2;

/// A gap as wide as this part of the surface's domain is no gap any more.
const JUMP: f64 = 0.5;

/// Where a trim starts (`0`) or ends (`1`) in uv.
fn end(brep: &Brep, trim: &TrimCurve, which: usize) -> Option<Point2<f64>> {
    let curve = brep.parts().curves2.get(trim.curve)?;
    let t = if (which == 0) == trim.reversed {
        trim.span.end
    } else {
        trim.span.start
    };
    Some(curve.point(t))
}

/// One line for each place where a loop jumps.
pub(super) fn jumps(brep: &Brep) -> Vec<String> {
    let parts = brep.parts();
    let mut found = Vec::new();
    for (l, trim_loop) in parts.loops.iter().enumerate() {
        let face = parts.faces.get(trim_loop.face);
        let Some(surface) = face.and_then(|f| parts.surfaces.get(f.surface)) else {
            continue;
        };
        let domain = surface.domain();
        let next = trim_loop.trims.iter().cycle().skip(1);
        for (&a, &b) in trim_loop.trims.iter().zip(next) {
            let (Some(ta), Some(tb)) = (parts.trims.get(a), parts.trims.get(b)) else {
                continue;
            };
            let (Some(p), Some(q)) = (end(brep, ta, 1), end(brep, tb, 0)) else {
                continue;
            };
            for (c, name) in ["u", "v"].into_iter().enumerate() {
                let gap = (q[c] - p[c]).abs();
                if gap > JUMP * domain[c].length() {
                    found.push(format!(
                        "loop {l} of face {} jumps by {gap} in {name} from trim {a} to trim {b}: \
                         a seam is missing",
                        trim_loop.face
                    ));
                }
            }
        }
    }
    found
}
