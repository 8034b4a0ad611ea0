//! A BREP with its native surfaces turned into NURBS.

use feeler::brep::{Brep, BrepError};
use feeler::nurbs::{Curve2, Line, ParameterMap, Surface};
use nalgebra::Point2;

/// What became of a BREP.
#[derive(Clone, Debug)]
pub struct AsNurbs {
    /// The BREP with NURBS.
    pub brep: Brep,
    /// No point of a converted surface is farther than this from its native one, in model units: proven by
    /// [`Surface::to_nurbs`].
    pub bound: f64,
    /// Faces that stay native: a trim on them is no isoparametric line, and the angle is not the parameter of the
    /// rational form, so that the trim would only be approximated.
    pub kept: usize,
}

/// Turns the native surfaces of a BREP into NURBS, each face on its own.
///
/// Planes keep their parameters, and so their trims. Where the parameters change (revolutions), trims that are
/// isoparametric lines are moved along, their ends rounded to f64: such a trim moves by a rounding of its parameter.
///
/// # Errors
/// The new parts make no BREP (a parameter range that vanishes, for one).
pub fn as_nurbs(brep: &Brep) -> Result<AsNurbs, BrepError> {
    let mut parts = brep.parts().clone();
    let (mut bound, mut kept) = (0.0f64, 0);
    for face in 0..brep.faces().len() {
        let native = brep.surface(face);
        if matches!(native, Surface::Nurbs(_)) {
            continue;
        }
        let Ok(converted) = native.to_nurbs() else {
            kept += 1;
            continue;
        };
        let loops = brep.faces()[face].loops.iter().flatten();
        let trims = loops.flat_map(|l| &brep.parts().loops[*l].trims);
        let moved: Option<Vec<_>> = trims
            .map(|&t| Some((t, moved_trim(brep, t, &converted.maps)?)))
            .collect();
        let Some(moved) = moved else {
            kept += 1;
            continue;
        };
        for (trim, curve) in moved {
            if let Some(curve) = curve {
                parts.trims[trim].curve = parts.curves2.len();
                parts.curves2.push(curve);
            }
        }
        parts.faces[face].surface = parts.surfaces.len();
        parts.surfaces.push(Surface::Nurbs(converted.nurbs));
        bound = bound.max(converted.bound);
    }
    Ok(AsNurbs {
        brep: Brep::new(parts)?,
        bound,
        kept,
    })
}

/// The curve of a trim in the new parameters, `Some(None)` where it stays; `None` where there is no such line.
fn moved_trim(brep: &Brep, trim: usize, maps: &[ParameterMap; 2]) -> Option<Option<Curve2>> {
    if maps.iter().all(ParameterMap::is_identity) {
        return Some(None);
    }
    let trim = &brep.parts().trims[trim];
    let curve = &brep.parts().curves2[trim.curve];
    let Curve2::Line(line) = curve else {
        return None;
    };
    if line.from.x != line.to.x && line.from.y != line.to.y {
        return None;
    }
    let end = |t: f64| {
        let p = curve.point(t);
        Point2::new(maps[0].to_nurbs(p.x), maps[1].to_nurbs(p.y))
    };
    let (from, to) = (end(trim.span.start), end(trim.span.end));
    Line::new(from, to, trim.span)
        .ok()
        .map(|line| Some(Curve2::Line(line)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_corpus::Model;
    use std::path::Path;

    fn brep(model: &str) -> Brep {
        let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models");
        let model = Model::load(&models.join(model), None).unwrap();
        model.breps.into_iter().next().unwrap()
    }

    /// The images of trims, which bound the faces, stay where they are.
    #[test]
    fn trims_stay_in_space() {
        for (model, kept) in [
            ("thesis/ball_joint_cavity.3dm", 0),
            ("thesis/geneva4_wheel.3dm", 0),
            ("thesis/ball.3dm", 0),
            ("analytic/torus.json.gz", 0),
            // A bore's trims on a sphere are splines.
            ("parts/chain_link.json.gz", 2),
        ] {
            let native = brep(model);
            let found = as_nurbs(&native).unwrap();
            assert_eq!(found.kept, kept, "{model}");
            assert!(found.bound < 1e-13, "{model}: {}", found.bound);
            let (old, new) = (native.parts(), found.brep.parts());
            for (i, (a, b)) in old.trims.iter().zip(&new.trims).enumerate() {
                let face = old.loops[a.trim_loop].face;
                for (p, q) in [(a.span.start, b.span.start), (a.span.end, b.span.end)] {
                    let (x, y) = (old.curves2[a.curve].point(p), new.curves2[b.curve].point(q));
                    let off = native.surface(face).point(x.x, x.y)
                        - found.brep.surface(face).point(y.x, y.y);
                    assert!(off.norm() < 1e-12, "{model} trim {i}: {off}");
                }
            }
            let nurbs = |s: &&Surface| matches!(s, Surface::Nurbs(_));
            let faces = 0..native.faces().len();
            let now: Vec<&Surface> = faces.map(|f| found.brep.surface(f)).collect();
            assert_eq!(now.iter().filter(|s| nurbs(s)).count(), now.len() - kept);
        }
    }
}
