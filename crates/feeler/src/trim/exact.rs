//! The pieces of a region's boundary as they are, exactly: for what lies in the region's plane.

use super::circle::Blur;
use super::region::TrimRegion;
use super::source::{Ball3, Exact3, Source};
use crate::numeric::Dyadic;

/// A homogeneous control point `(w u, w v, w)`, exactly.
pub(crate) type ExactPoint = [Dyadic; 3];

/// A piece of the boundary: a rational Bezier curve of positive weights.
#[derive(Debug)]
pub(crate) struct ExactPiece {
    /// Control points up to a common factor above zero; `None` where they are known in enclosures only.
    pub(crate) points: Option<Vec<ExactPoint>>,
    /// The same in enclosures, up to another such factor.
    pub(crate) balls: Vec<Ball3>,
    /// Its end points, where they are known exactly.
    pub(crate) ends: [Option<ExactPoint>; 2],
    /// Centre and radius of the circle of a piece of a native arc that has no exact control points.
    pub(crate) circle: Option<([f64; 2], f64)>,
}

fn dyadics(p: &Exact3) -> ExactPoint {
    p.each_ref().map(|x| Dyadic::new(x.clone(), 0))
}

fn blur(b: &Blur) -> Option<ExactPoint> {
    if b.at.iter().any(|x| x.rad != 0.0) {
        return None;
    }
    let number = |x: f64| Dyadic::from_f64(x);
    let [u, v] = b.at.map(|x| Some(&number(x.mid.hi)? + &number(x.mid.lo)?));
    Some([u?, v?, number(1.0)?])
}

fn piece(source: &Source) -> ExactPiece {
    let points: Option<Vec<ExactPoint>> = source.exact().map(|p| p.iter().map(dyadics).collect());
    let ends = match (source, &points) {
        (_, Some(points)) => [points.first().cloned(), points.last().cloned()],
        (Source::Arc(arc), _) => arc.exact_ends().map(|e| e.as_ref().map(dyadics)),
        (Source::Blurred(ends), _) => [blur(&ends[0]), blur(&ends[1])],
        _ => [None, None],
    };
    ExactPiece {
        points,
        balls: source.balls(),
        ends,
        circle: match source {
            Source::Arc(arc) => Some(arc.circle()),
            _ => None,
        },
    }
}

impl TrimRegion {
    /// What [`pieces`](Self::pieces) are, in their order.
    pub(crate) fn exact_pieces(&self) -> impl Iterator<Item = ExactPiece> {
        self.all_pieces().map(|p| piece(&p.source))
    }
}
