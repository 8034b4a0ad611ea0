//! The width of the cracks between faces.

use super::{PreparedBrep, curve_jet};
use crate::numeric::Ball;
use nalgebra::{Point3, Vector3};

/// How many points of each image of an edge are looked at.
const SAMPLES: usize = 16;
/// The nearest point of the other image is found by this many rounds of narrowing.
const ROUNDS: usize = 24;

/// The largest distance found between the two images of an edge over all edges that two trims use, in
/// model units: sampled, so an estimate from below, which those who use it multiply.
pub(crate) fn crack_width(brep: &PreparedBrep) -> f64 {
    let parts = brep.brep().parts();
    let images: Vec<Vec<Image>> = (0..parts.edges.len()).map(|_| Vec::new()).collect();
    let mut images = images;
    for face in 0..parts.faces.len() {
        let Ok(geometry) = brep.double(face) else {
            continue;
        };
        for (index, piece) in geometry.pieces.iter().enumerate() {
            let Some(trim) = piece.trim else { continue };
            if let Some(edge) = parts.trims[trim].edge
                && let Some(of_edge) = images.get_mut(edge)
            {
                of_edge.push(Image { face, trim, index });
            }
        }
    }
    let mut widest: f64 = 0.0;
    for of_edge in &images {
        for a in of_edge {
            for k in 0..=SAMPLES {
                let Some(p) = a.point(brep, k as f64 / SAMPLES as f64) else {
                    continue;
                };
                let others = of_edge.iter().filter(|b| b.trim != a.trim);
                let nearest = others
                    .map(|b| b.distance(brep, &p))
                    .fold(f64::INFINITY, f64::min);
                if nearest.is_finite() {
                    widest = widest.max(nearest);
                }
            }
        }
    }
    widest
}

/// A piece of one image of an edge.
struct Image {
    face: usize,
    trim: usize,
    index: usize,
}

impl Image {
    fn point(&self, brep: &PreparedBrep, t: f64) -> Option<Point3<f64>> {
        let geometry = brep.double(self.face).ok()?;
        let net = geometry.pieces[self.index].space.as_ref()?;
        let (p, _) = curve_jet(&net.points, Ball::exact(t));
        Some(Point3::from(Vector3::from_fn(|c, _| {
            p[c].mid / p[3].mid + net.origin[c]
        })))
    }

    /// The distance of a point from the piece: the best sample, then narrowing about it.
    fn distance(&self, brep: &PreparedBrep, p: &Point3<f64>) -> f64 {
        let at = |t: f64| {
            self.point(brep, t)
                .map_or(f64::INFINITY, |x| (x - p).norm())
        };
        let mut best = (f64::INFINITY, 0.0);
        for k in 0..=SAMPLES {
            let t = k as f64 / SAMPLES as f64;
            let d = at(t);
            if d < best.0 {
                best = (d, t);
            }
        }
        let mut step = 0.5 / SAMPLES as f64;
        for _ in 0..ROUNDS {
            for t in [best.1 - step, best.1 + step] {
                let d = at(t.clamp(0.0, 1.0));
                if d < best.0 {
                    best = (d, t.clamp(0.0, 1.0));
                }
            }
            step *= 0.5;
        }
        best.0
    }
}
