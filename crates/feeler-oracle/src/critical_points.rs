//! All critical points of a distance by the bivariate algebraic kernel: a safe call into C++.

use crate::bridge::ffi;
use crate::oracle::enclosure;
use crate::truth::{CriticalPoint, CriticalPoints, OracleError};
use feeler::nurbs::NurbsSurface;

/// The largest degree that is taken.
const MOST_DEGREE: usize = 3;

/// All critical points of the distance from `point` to a surface that is one polynomial Bezier patch of degrees 1
/// to 3, untrimmed, with weights of 1; `None` for any other. The least distance among them is the minimum.
///
/// CGAL's `Algebraic_kernel_d_2` and `_d_1` (`cpp/critical_points.hpp`): another method than
/// [`Oracle::distance`](crate::Oracle::distance), which checks that. It shares nothing with it but the numbers given.
///
/// # Errors
/// The point must be finite.
pub fn critical_points(
    surface: &NurbsSurface,
    point: [f64; 3],
) -> Result<Option<CriticalPoints>, OracleError> {
    let [p, q] = [surface.knots_u(), surface.knots_v()].map(|k| k.degree());
    let one_patch = surface.counts() == [p + 1, q + 1]
        && [(surface.knots_u(), p), (surface.knots_v(), q)]
            .iter()
            .all(|(k, p)| {
                let k = k.knots();
                k[..=*p].iter().all(|x| *x == k[*p]) && k[p + 1..].iter().all(|x| *x == k[p + 1])
            });
    let small = [p, q].iter().all(|p| (1..=MOST_DEGREE).contains(p));
    if !one_patch || !small || surface.control_net().iter().any(|x| x.w != 1.0) {
        return Ok(None);
    }
    let net: Vec<f64> = surface
        .control_net()
        .iter()
        .flat_map(|x| [x.x, x.y, x.z])
        .collect();
    let raw = ffi::critical_points_of(p, q, &net, &point)?;
    let points = raw
        .points
        .iter()
        .map(|c| {
            let [x0, x1, y0, y1, z0, z1] = c.at;
            Ok(CriticalPoint {
                distance: enclosure(&c.distance)?,
                at: [[x0, x1], [y0, y1], [z0, z1]],
                minimum: match c.kind {
                    0 => Some(true),
                    1 => Some(false),
                    _ => None,
                },
                inner: c.inner,
            })
        })
        .collect::<Result<_, OracleError>>()?;
    Ok(Some(CriticalPoints {
        all: raw.all,
        points,
    }))
}
