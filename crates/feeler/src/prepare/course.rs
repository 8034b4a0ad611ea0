//! What images of trims are exactly: straight, or circular.

use super::PreparedBrep;
use super::exact::{D3, Ratio, cross, dot, sub, vector};
use crate::numeric::Dyadic;
use crate::nurbs::{Curve2, Curve3, NurbsSurface, Surface};
use crate::trim::{BoundaryPiece, PieceOrigin};
use nalgebra::{Point3, Vector3};

/// The exact shape of a trim's image.
#[derive(Clone, Debug)]
pub(crate) enum Course {
    /// A segment, run through once.
    Straight,
    /// Part of a circle, run through in one direction and no more than once.
    Round(Box<Round>),
    /// Part of a circle about the point, of the radius, in a plane that holds a line through it along the axis.
    Meridian {
        center: Point3<f64>,
        axis: Vector3<f64>,
        radius: f64,
    },
}

/// A circle about an axis.
#[derive(Clone, Debug)]
pub(crate) struct Round {
    /// A point of the axis, over `bottom`.
    origin: D3,
    bottom: Dyadic,
    axis: D3,
}

impl Course {
    /// The tangent of the circle next to a point of it, and the circle's radius: rounded; `None` of a segment.
    pub(crate) fn tangent(&self, p: &Point3<f64>) -> Option<(Vector3<f64>, f64)> {
        match self {
            Self::Straight => None,
            Self::Round(round) => round.tangent(p),
            Self::Meridian {
                center,
                axis,
                radius,
            } => {
                let out = p - center;
                Some(((axis / axis.amax()).cross(&out).cross(&out), *radius))
            }
        }
    }
}

/// A tangent is made where rounding the circle's centre turns it by less than this, about.
const DIGITS: f64 = 1.0 / (1u64 << 24) as f64;

impl Round {
    /// Of a line in a plane orthogonal to the axis, exactly: where it is nearest to the axis, and whether it meets it there.
    pub(crate) fn foot(&self, o: &Point3<f64>, d: &Vector3<f64>) -> Option<(Ratio, bool)> {
        let (o, d) = (vector(o.coords.as_slice())?, vector(d.as_slice())?);
        if dot(&d, &self.axis).signum() != 0 {
            return None;
        }
        let from: D3 = std::array::from_fn(|c| &self.origin[c] - &(&o[c] * &self.bottom));
        let t = Ratio::new(dot(&from, &d), &dot(&d, &d) * &self.bottom);
        let meets = dot(&from, &cross(&self.axis, &d)).signum() == 0;
        Some((t, meets))
    }

    /// Whether a line is along the axis, exactly: then all distances of its points from part of the circle are least at one place.
    pub(crate) fn is_along(&self, d: &Vector3<f64>) -> bool {
        let along = vector(d.as_slice()).map(|d| cross(&d, &self.axis));
        along.is_some_and(|c| c.iter().all(|x| x.signum() == 0))
    }

    /// The circle's tangent next to a point of it, and its radius: rounded.
    fn tangent(&self, p: &Point3<f64>) -> Option<(Vector3<f64>, f64)> {
        let rounded = |v: &D3, by: f64| Vector3::from_fn(|c, _| v[c].approximate() / by);
        let axis = rounded(&self.axis, 1.0);
        let origin = rounded(&self.origin, self.bottom.approximate());
        let tangent = (axis / axis.amax()).normalize().cross(&(p.coords - origin));
        let radius = tangent.norm();
        (origin.amax() * f64::EPSILON <= DIGITS * radius).then_some((tangent, radius))
    }

    pub(super) fn new(origin: D3, bottom: Dyadic, axis: D3) -> Self {
        Self {
            origin,
            bottom,
            axis,
        }
    }
}

/// The parameter that a straight piece keeps, which is no point.
fn along_parameter(piece: &BoundaryPiece) -> Option<usize> {
    let [p, q] = piece.segment()?;
    let (k, _) = piece.kept()?;
    (p != q).then_some(k)
}

/// Whether parameter lines along the other parameter than `k` are segments: one span of degree one, clamped.
fn is_ruled(s: &NurbsSurface, k: usize) -> bool {
    let along = [s.knots_u(), s.knots_v()][1 - k];
    along.degree() == 1 && along.is_clamped() && along.control_points() == 2
}

impl PreparedBrep {
    /// Whether a line meets the images of an edge, if they are one segment, exactly: then its crack has no width. `None` where they are not.
    pub(crate) fn meets_joined(
        &self,
        edge: usize,
        o: &Point3<f64>,
        d: &Vector3<f64>,
    ) -> Option<bool> {
        let trims = &self.brep().parts().edges[edge].trims;
        let segment = |t: &usize| self.polygon(self.face_of(*t))?.segment(*t);
        let all: Vec<_> = trims.iter().map(segment).collect::<Option<_>>()?;
        let same =
            |(a, m): (&D3, &Dyadic), (b, n): (&D3, &Dyadic)| (0..3).all(|c| &a[c] * n == &b[c] * m);
        let joined = all.windows(2).all(|pair| {
            let [(a, m), (b, n)] = [&pair[0], &pair[1]];
            let ends =
                |i: usize, k: usize| same((&a[0], m), (&b[i], n)) && same((&a[1], m), (&b[k], n));
            ends(0, 1) || ends(1, 0)
        });
        if !joined {
            return None;
        }
        // Of `a + s w`, all over `m`: the line meets it if `from + s w` is along `d` for some `s` in [0, 1].
        let ([a, b], m) = all.first()?;
        let (o, d) = (vector(o.coords.as_slice())?, vector(d.as_slice())?);
        let from: D3 = std::array::from_fn(|c| &a[c] - &(&o[c] * m));
        let w = sub(b, a);
        let (first, rate) = (cross(&from, &d), cross(&w, &d));
        // first + s rate = 0.
        let zero = |v: &D3| v.iter().all(|x| x.signum() == 0);
        if zero(&rate) {
            return Some(zero(&first));
        }
        if !zero(&cross(&first, &rate)) {
            return Some(false);
        }
        let (top, bottom) = (dot(&first, &rate), dot(&rate, &rate));
        Some(top.signum() <= 0 && (&top + &bottom).signum() >= 0)
    }

    /// What the image of a trim is; `None` where that is not known, or another curve.
    pub(crate) fn course(&self, trim: usize) -> Option<Course> {
        let face = self.face_of(trim);
        let parts = self.brep().parts();
        let pieces = self.region(face).pieces();
        let own =
            |p: &BoundaryPiece| matches!(p.origin, PieceOrigin::Trim { trim: t, .. } if t == trim);
        let mut own = pieces.filter(own);
        let surface = self.brep().surface(face);
        if let Some(polygon) = self.polygon(face) {
            if polygon.is_straight(trim) {
                return Some(Course::Straight);
            }
            return match &parts.curves2[parts.trims[trim].curve] {
                Curve2::Arc(arc) => polygon
                    .circle([arc.center.x, arc.center.y])
                    .map(|c| Course::Round(Box::new(c))),
                _ => None,
            };
        }
        let (piece, none) = (own.next()?, own.next().is_none());
        let k = if none {
            along_parameter(&piece)?
        } else {
            return None;
        };
        match surface {
            Surface::Revolution(s) => {
                let angular = usize::from(s.transposed);
                if k == angular {
                    return match &s.profile {
                        Curve3::Line(_) => Some(Course::Straight),
                        Curve3::Arc(arc) => {
                            let axis = vector(s.axis.as_slice())?;
                            let center = vector(arc.center.coords.as_slice())?;
                            let off = sub(&center, &vector(s.origin.coords.as_slice())?);
                            let skew = dot(&axis, &vector(arc.z.as_slice())?);
                            let zero = |v: &D3| v.iter().all(|x| x.signum() == 0);
                            let turned = zero(&cross(&off, &axis)) && skew.signum() == 0;
                            turned.then_some(Course::Meridian {
                                center: arc.center,
                                axis: s.axis,
                                radius: arc.radius,
                            })
                        }
                        _ => None,
                    };
                }
                let (origin, axis) = (
                    vector(s.origin.coords.as_slice())?,
                    vector(s.axis.as_slice())?,
                );
                // No more than a turn, which a form has.
                self.closed(face)?;
                let round = Round::new(origin, super::exact::dyadic(1.0)?, axis);
                Some(Course::Round(Box::new(round)))
            }
            Surface::Nurbs(s) => is_ruled(s, k).then_some(Course::Straight),
            _ => None,
        }
    }
}
