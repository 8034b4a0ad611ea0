//! Surfaces of revolution over more than a turn, as a screw's thread has: openNURBS finds them invalid. They are written as NURBS, whose angular
//! parameter is another, and the curves in uv are taken along.

use crate::occt::curves::Budget;
use crate::warp::Warp;
use feeler::brep::Brep;
use feeler::nurbs::Surface;
use std::f64::consts::TAU;

/// Numbers that may be made for the curves.
const NUMBERS: usize = 1 << 24;

fn winds(surface: &Surface) -> bool {
    matches!(surface, Surface::Revolution(r) if r.angle.length() > TAU * (1.0 + 4.0 * f64::EPSILON))
}

/// The BREP without such surfaces, and what is to be said of that; `None` where it has none.
///
/// # Errors
/// What cannot be written so.
pub(super) fn unwound(brep: &Brep) -> Result<Option<(Brep, String)>, String> {
    if !brep.parts().surfaces.iter().any(winds) {
        return Ok(None);
    }
    let mut parts = brep.parts().clone();
    let (mut count, mut bound) = (0, 0.0_f64);
    let mut numbers = Budget::new(NUMBERS);
    for i in 0..parts.surfaces.len() {
        if !winds(&parts.surfaces[i]) {
            continue;
        }
        let lengths = parts.surfaces[i].domain().map(|d| d.length());
        let made = parts.surfaces[i].to_nurbs().map_err(|e| e.to_string())?;
        parts.surfaces[i] = Surface::Nurbs(made.nurbs);
        (count, bound) = (count + 1, bound.max(made.bound));
        let faces = parts.faces.iter().filter(|f| f.surface == i);
        let loops = faces.flat_map(|f| f.loops.iter().flatten());
        let trims: Vec<usize> = loops
            .filter_map(|l| parts.loops.get(*l))
            .flat_map(|l| l.trims.iter().copied())
            .collect();
        for (c, map) in made.maps.into_iter().enumerate() {
            if map.is_identity() {
                continue;
            }
            let warp = Warp::Arcs(map);
            for &t in &trims {
                let trim = &parts.trims[t];
                let curve = &parts.curves2[trim.curve];
                let taken = warp.taken(curve, trim.span, c, lengths, &mut numbers);
                let taken = taken.map_err(|e| e.to_string())?;
                parts.trims[t].curve = parts.curves2.len();
                parts.curves2.push(taken);
            }
        }
    }
    let said = format!(
        "{count} surfaces of revolution over more than a turn, which openNURBS does not allow, are written as NURBS (off by {bound:.1e} at most), \
         and their curves in uv taken along"
    );
    let brep = Brep::new(parts).map_err(|e| e.to_string())?;
    Ok(Some((brep, said)))
}
