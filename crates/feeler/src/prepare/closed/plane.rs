//! Planes.

use super::super::exact as dyadic;
use super::curve::{ClosedCurve, CurveShape, Of, UvPath};
use super::form::{
    Boxes, Critical, Extent, Linear, Minimum, SHARP, Target, V3, Vector, along, at_gap,
    distance_range, dot, exact, lead, least_square, range, rounded, scale, sub, unit,
};
use super::line::RoughHit;
use crate::numeric::{Ball, Dd, Dyadic, Interval, Real, sin_cos};
use crate::nurbs::{Arc, NurbsSurface, Plane};
use nalgebra::Vector4;

/// `origin + a x + b y`, what is needed to project onto it.
#[derive(Clone, Debug)]
pub(crate) struct PlaneForm {
    pub(crate) origin: [f64; 3],
    pub(crate) x: V3,
    pub(crate) y: V3,
    /// `x cross y`, and that as a unit vector.
    pub(crate) normal: V3,
    unit: V3,
    /// Vectors whose products with an offset from the origin are its coordinates along `x` and `y`, and the unit normal: in f64,
    /// to find where a foot is.
    rough: [Vector<f64>; 3],
    /// `x.x`, `x.y`, `y.y` and the determinant.
    gram: [Ball<Dd>; 4],
    pub(crate) maps: [Linear; 2],
    /// The corners of the domain.
    corners: [V3; 4],
    /// The exact length of both axes, where they are exactly orthogonal and of the same power of two, and
    /// parameters are coordinates.
    similar: Option<f64>,
    domain: [Interval; 2],
}

impl PlaneForm {
    pub(super) fn new(s: &Plane) -> Option<Self> {
        let axes = [exact(s.x.as_slice()), exact(s.y.as_slice())];
        let origin = [s.origin.x, s.origin.y, s.origin.z];
        Self::spanned(origin, axes, s.domain, s.extents, similar(s))
    }

    /// The plane that a NURBS surface is, exactly: a bilinear patch without weights whose control points are the corners of
    /// a parallelogram, `P00 + P11 = P01 + P10`, is `P00 + a (P10 - P00) + b (P01 - P00)` for `a` and `b` in `[0, 1]`. Sums and
    /// differences of two f64 are exact in double-double, so nothing is rounded.
    pub(super) fn recognised(s: &NurbsSurface) -> Option<Self> {
        let degrees = [s.knots_u().degree(), s.knots_v().degree()];
        let [p00, p01, p10, p11] = s.control_net() else {
            return None;
        };
        if degrees != [1, 1] || [p00, p01, p10, p11].iter().any(|p| p.w != 1.0) {
            return None;
        }
        if (0..3).any(|c| Dd::sum(p00[c], p11[c]) != Dd::sum(p01[c], p10[c])) {
            return None;
        }
        let axis = |p: &Vector4<f64>| std::array::from_fn(|c| Ball::difference(p[c], p00[c]));
        let unit = Interval {
            start: 0.0,
            end: 1.0,
        };
        let origin = [p00.x, p00.y, p00.z];
        let axes = [axis(p10), axis(p01)];
        Self::spanned(origin, axes, s.domain(), [unit, unit], None)
    }

    fn spanned(
        origin: [f64; 3],
        [x, y]: [V3; 2],
        domain: [Interval; 2],
        extents: [Interval; 2],
        similar: Option<f64>,
    ) -> Option<Self> {
        let normal = std::array::from_fn(|c| {
            let (i, j) = ((c + 1) % 3, (c + 2) % 3);
            x[i] * y[j] - x[j] * y[i]
        });
        let gram = [dot(&x, &x), dot(&x, &y), dot(&y, &y), dot(&normal, &normal)];
        // A plane whose axes are parallel up to half the digits is left to the search.
        const FLAT: f64 = 1.0 / (1u64 << 48) as f64;
        if !gram[3].is_above(FLAT * gram[0].magnitude() * gram[2].magnitude()) {
            return None;
        }
        let maps = [0, 1].map(|k| Linear {
            from: domain[k],
            to: extents[k],
        });
        let o = exact(&origin);
        let corner = |a: f64, b: f64| along(&along(&o, Ball::exact(a), &x), Ball::exact(b), &y);
        let [a, b] = extents;
        let length = gram[3].sqrt();
        let unit = normal.map(|x| x / length);
        let [xx, xy, yy, det] = gram;
        let dual = |a: &V3, aa: Ball<Dd>, b: &V3| -> V3 {
            std::array::from_fn(|c| (a[c] * aa - b[c] * xy) / det)
        };
        let rough = [dual(&x, yy, &y), dual(&y, xx, &x), unit]
            .each_ref()
            .map(rounded);
        Some(Self {
            origin,
            corners: [
                corner(a.start, b.start),
                corner(a.start, b.end),
                corner(a.end, b.start),
                corner(a.end, b.end),
            ],
            unit,
            rough,
            similar,
            x,
            y,
            normal,
            gram,
            maps,
            domain,
        })
    }

    /// The point at native parameters.
    pub(super) fn point(&self, uv: [Ball<Dd>; 2]) -> V3 {
        let [a, b] = [0, 1].map(|k| self.maps[k].at(uv[k]));
        along(&along(&exact(&self.origin), a, &self.x), b, &self.y)
    }

    /// Native parameters of the foot of a point given relative to the origin.
    pub(crate) fn parameters(&self, w: &V3) -> [Ball<Dd>; 2] {
        let (wx, wy) = (dot(w, &self.x), dot(w, &self.y));
        let [xx, xy, yy, det] = self.gram;
        let coordinates = [(wx * yy - wy * xy) / det, (wy * xx - wx * xy) / det];
        [0, 1].map(|k| self.maps[k].inverse().at(coordinates[k]))
    }

    /// Where a line meets the plane: `t = -n.w / n.d`, and the coordinates of `x = w + t d`; `w` is its origin relative to the plane's.
    ///
    /// With `u = 2^-53`: each `w_c` is off by `u |w_c|`, the vectors that these are multiplied by by `blur`. A sum of three products is off by at most four
    /// roundings of the sum of their magnitudes, with `u |w_c|` five; so `n.w` and `n.d` are off by `e = 5 u sum |n_c w_c| + blur sum |w_c|`, likewise; `t` by
    /// `(e + |t| e') / (|n.d| - e')` and a rounding; `x_c` by that times `|d_c|` and three roundings of `|w_c| + |t d_c|`. What is of second order, and
    /// roundings of the bounds, 2^-46 more of them covers.
    pub(super) fn rough_hit(&self, origin: &[f64; 3], d: &[f64; 3]) -> RoughHit {
        const U: f64 = f64::UNIT;
        const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
        let w = [0, 1, 2].map(|c| origin[c] - self.origin[c]);
        // A product with one of the vectors, and the bound that it has where `a` is known within `off`.
        let times = |of: usize, a: &[f64; 3], off: &[f64; 3]| {
            let v = &self.rough[of];
            let parts = [0, 1, 2].map(|c| v[c].mid * a[c]);
            let sizes = parts.map(f64::abs);
            let mut bound = 5.0 * U * (sizes[0] + sizes[1] + sizes[2]) + f64::MIN_POSITIVE;
            for c in 0..3 {
                bound += v[c].rad * (a[c].abs() + off[c]) + v[c].mid.abs() * off[c];
            }
            (parts[0] + parts[1] + parts[2], bound * UP)
        };
        let (height, e) = times(2, &w, &[0.0; 3]);
        let (rate, e_rate) = times(2, d, &[0.0; 3]);
        let t = -(height / rate);
        let left = rate.abs() - e_rate;
        let e_t = if left > 0.0 {
            // (What underflows of `t` and of its error included.)
            ((e + t.abs() * e_rate) / left + 2.0 * U * t.abs()) * UP + f64::MIN_POSITIVE
        } else {
            f64::INFINITY
        };
        let x = [0, 1, 2].map(|c| w[c] + t * d[c]);
        let off = [0, 1, 2].map(|c| {
            e_t * d[c].abs() + 4.0 * U * (w[c].abs() + (t * d[c]).abs()) + f64::MIN_POSITIVE
        });
        let uv = [0, 1].map(|k| {
            let (mid, rad) = times(k, &x, &off);
            self.maps[k].inverse().at(Ball { mid, rad })
        });
        RoughHit {
            t: Ball { mid: t, rad: e_t },
            uv,
        }
    }

    /// Native parameters of a point of the plane, up to roundings of its distance from the origin.
    pub(super) fn rough_parameters(&self, point: &[f64; 3]) -> [f64; 2] {
        let w = [0, 1, 2].map(|c| point[c] - self.origin[c]);
        [0, 1].map(|k| {
            let mid = [0, 1, 2].map(|c| self.rough[k][c].mid * w[c]).iter().sum();
            self.maps[k].inverse().at(Ball { mid, rad: 0.0 }).mid
        })
    }

    /// Whether a line meets the plane at native parameters, exactly; `None` where these are not coordinates themselves or the axes not those of
    /// a file.
    pub(super) fn meets_at(&self, [from, direction]: [[f64; 3]; 2], uv: [f64; 2]) -> Option<bool> {
        let plain = |v: &V3| {
            let stored = v.iter().all(|x| x.rad == 0.0 && x.mid.lo == 0.0);
            stored.then(|| v.map(|x| x.mid.hi))
        };
        if self.maps.iter().any(|m| m.from != m.to) {
            return None;
        }
        let (x, y) = (
            dyadic::vector(&plain(&self.x)?)?,
            dyadic::vector(&plain(&self.y)?)?,
        );
        let off = dyadic::sub(&dyadic::vector(&self.origin)?, &dyadic::vector(&from)?);
        let [u, v] = [dyadic::dyadic(uv[0])?, dyadic::dyadic(uv[1])?];
        let point: dyadic::D3 = std::array::from_fn(|c| &off[c] + &(&(&u * &x[c]) + &(&v * &y[c])));
        let beside = dyadic::cross(&point, &dyadic::vector(&direction)?);
        Some(beside.iter().all(|x| x.signum() == 0))
    }

    /// The image of a segment; that of one between points of f64 is made later.
    pub(super) fn segment(&self, ends: [[Ball<Dd>; 2]; 2], of: Of) -> ClosedCurve {
        let is_f64 = |x: &Ball<Dd>| x.rad == 0.0 && x.mid.lo == 0.0;
        if ends.iter().flatten().all(is_f64) {
            return ClosedCurve::unmade(of, UvPath::straight(ends));
        }
        let [a, b] = ends.map(|e| self.point(e));
        ClosedCurve::segment(a, b, ends, of)
    }

    /// The image of a circular arc; a circle only where the axes are exactly orthogonal and of one length.
    pub(super) fn arc(&self, arc: &Arc<2>, span: Interval, trim: usize) -> Option<ClosedCurve> {
        let unit = Ball::exact(self.similar?);
        let ([start, turned], turn) = directions(arc, span);
        let lift = |d: [Ball<Dd>; 2]| -> V3 {
            std::array::from_fn(|c| (d[0] * self.x[c] + d[1] * self.y[c]) / unit)
        };
        let center = self.point([arc.center[0], arc.center[1]].map(Ball::exact));
        let radius = Ball::exact(arc.radius) * unit;
        let shape = CurveShape::arc(center, lift(start), lift(turned), radius, turn)?;
        // uv of a point at angle `a` from the start.
        let uv = UvPath::Circle {
            center: [arc.center[0], arc.center[1]],
            x: start.map(|c| c.mid.hi * arc.radius),
            y: turned.map(|c| c.mid.hi * arc.radius),
        };
        Some(ClosedCurve::new(Of::Trim(trim as u32), uv, shape))
    }

    /// A circular arc near the image of one, and how far that may be from it at the same part of the angle: where the axes are orthogonal and of one length up to roundings, so
    /// that the image is one of an ellipse.
    ///
    /// The image is `C + R (cos a X + sin a Y)` with the images `X`, `Y` of two directions; the arc has `C`, the unit vector along `X`, the radius `R |X|`, and a
    /// unit vector across `X`. So they differ by what `R Y` is off the radius along that, times `sin a`.
    pub(super) fn nearly_arc(&self, arc: &Arc<2>, span: Interval) -> Option<(CurveShape, f64)> {
        /// Of the radius: far more than the roundings of axes.
        const MOST: f64 = 1.0 / (1u64 << 40) as f64;
        if self.maps.iter().any(|m| m.from != m.to) {
            return None;
        }
        let (directions, turn) = directions(arc, span);
        let [x, y] = directions
            .map(|d| -> V3 { std::array::from_fn(|c| d[0] * self.x[c] + d[1] * self.y[c]) });
        let along_x = unit(&x)?;
        let along_y = unit(&along(&y, -dot(&y, &along_x), &along_x))?;
        let center = self.point([arc.center[0], arc.center[1]].map(Ball::exact));
        let own = Ball::exact(arc.radius);
        let radius = own * dot(&x, &along_x);
        let off = sub(&scale(&y, own), &scale(&along_y, radius));
        // A few roundings.
        let slack = off.iter().map(Ball::magnitude).sum::<f64>() * (1.0 + 16.0 * f64::EPSILON);
        // Negated: what is no number is no bound.
        if !(slack <= MOST * radius.lower()) {
            return None;
        }
        let shape = CurveShape::arc(center, along_x, along_y, radius, turn)?;
        Some((shape, slack))
    }

    /// As that of a revolution: distances in f64, heights to their last digits.
    pub(super) fn least(&self, target: &Target) -> Dd {
        match target {
            Target::Point(q) => {
                let w: Vector<f64> = sub(&exact(q), &exact(&self.origin));
                least_square(dot(&w, &self.rough[2]), 0.0)
            }
            // Linear: least at a corner.
            Target::Height(n, h) => {
                let n: V3 = exact(n);
                let values = self.corners.iter();
                let values = values.map(|p| range(dot(&n, p) - Ball::exact(*h), 0.0)[0]);
                values.fold(Dd::from(f64::INFINITY), |m, x| if x < m { x } else { m })
            }
        }
    }

    /// A distance is least at the foot. A height has no minimum in the interior unless both its slopes vanish: where they do
    /// so within their bounds, all of the plane counts. From numbers in f64, as far as they go.
    pub(super) fn critical(&self, target: &Target) -> Option<Critical> {
        let Target::Point(q) = target else {
            return self.critical_fine(target);
        };
        let w: Vector<f64> = sub(&exact(q), &exact(&self.origin));
        let [a, b, height] = self.rough.each_ref().map(|v| dot(&w, v));
        let uv = [self.maps[0].inverse().at(a), self.maps[1].inverse().at(b)];
        let range = distance_range(height, 0.0);
        let point = at_gap(q, height, &self.rough[2]);
        let sharp = a.rad.max(b.rad) < SHARP;
        Some(self.at_foot(uv, range, point, sharp))
    }

    /// The same from numbers in double-double.
    pub(super) fn critical_fine(&self, target: &Target) -> Option<Critical> {
        match target {
            Target::Point(q) => {
                let w = sub(&exact(q), &exact(&self.origin));
                let uv = self.parameters(&w);
                let range = distance_range(dot(&w, &self.unit), 0.0);
                Some(self.at_foot(uv, range, self.point(uv), true))
            }
            Target::Height(n, h) => {
                let n: V3 = exact(n);
                let slopes = [dot(&n, &self.x), dot(&n, &self.y)];
                if slopes.iter().any(|s| s.mid.abs().hi > s.rad * 2.0) {
                    return None;
                }
                let uv = [0, 1].map(|k| self.domain[k].mid());
                let point = self.point(uv.map(Ball::exact));
                let high = range(dot(&n, &point) - Ball::exact(*h), 0.0)[1];
                Some(Critical {
                    boxes: Boxes::one(self.domain.map(|d| [d.start, d.end])),
                    minimum: Minimum {
                        range: [self.least(target), high],
                        point,
                        uv,
                        uv_off: [0.0; 2],
                        unique: false,
                        extent: Extent::Root(f64::INFINITY),
                    },
                    sharp: false,
                    up: self.rough[2],
                })
            }
        }
    }

    /// The same minimum to the last digits, of one that is sharp.
    pub(super) fn sharpened(&self, target: &Target, found: &Critical) -> Minimum {
        let Target::Point(q) = target else {
            return found.minimum;
        };
        let height = dot(&sub(&exact(q), &exact(&self.origin)), &self.unit);
        Minimum {
            range: distance_range(height, 0.0),
            point: at_gap(q, lead(height), &found.up),
            ..found.minimum
        }
    }

    fn at_foot<T: Real>(
        &self,
        uv: [Ball<T>; 2],
        range: [Dd; 2],
        point: V3,
        sharp: bool,
    ) -> Critical {
        Critical {
            boxes: Boxes::one(uv.map(|x| [x.lower(), x.upper()])),
            minimum: Minimum {
                range,
                point,
                uv: uv.map(|x| x.mid.approximate()),
                uv_off: [0.0; 2],
                unique: true,
                extent: Extent::Root(1.0),
            },
            sharp,
            up: self.rough[2],
        }
    }
}

fn exact_pair(v: &[f64]) -> [Ball<Dd>; 2] {
    [Ball::exact(v[0]), Ball::exact(v[1])]
}

/// The directions of an arc in uv from its centre at its start and a right angle further, as unit vectors, and how far it turns.
fn directions(arc: &Arc<2>, span: Interval) -> ([[Ball<Dd>; 2]; 2], Ball<Dd>) {
    let map = Linear {
        from: arc.domain,
        to: arc.angle,
    };
    let [from, to] = [span.start, span.end].map(|t| map.at(Ball::exact(t)));
    let x = exact_pair(arc.x.as_slice());
    let length = (x[0].square() + x[1].square()).sqrt();
    let x = x.map(|c| c / length);
    // +90 degrees, or -90 where the stored y lies on that side: as `Arc` says.
    let turn = Dd::product(arc.x[0], arc.y[1]) - Dd::product(arc.x[1], arc.y[0]);
    let sign = if turn < Dd::ZERO {
        -Ball::ONE
    } else {
        Ball::ONE
    };
    let y = [-(sign * x[1]), sign * x[0]];
    let (sin, cos) = sin_cos(from);
    let start = [0, 1].map(|c| cos * x[c] + sin * y[c]);
    let turned = [0, 1].map(|c| cos * y[c] - sin * x[c]);
    ([start, turned], to - from)
}

/// The length of both axes, if they are exactly orthogonal, exactly equally long, and the length is a f64, and the
/// coordinates are the native parameters.
fn similar(s: &Plane) -> Option<f64> {
    if (0..2).any(|k| s.domain[k] != s.extents[k]) {
        return None;
    }
    let product = |a: &[f64], b: &[f64]| {
        let mut sum = Dyadic::from_f64(0.0)?;
        for c in 0..3 {
            sum = &sum + &(&Dyadic::from_f64(a[c])? * &Dyadic::from_f64(b[c])?);
        }
        Some(sum)
    };
    let (x, y) = (s.x.as_slice(), s.y.as_slice());
    let square = product(x, x)?;
    let length = s.x.norm();
    let root = Dyadic::from_f64(length)?;
    let holds = product(x, y)?.signum() == 0 && product(y, y)? == square && &root * &root == square;
    holds.then_some(length)
}

#[cfg(test)]
mod tests {
    use super::super::form::add;
    use super::*;
    use nalgebra::{Point2, Point3, Vector2, Vector3};

    fn interval(a: f64, b: f64) -> Interval {
        Interval::new(a, b).unwrap()
    }

    /// With axes that are orthonormal up to roundings, but for how far the second is tilted.
    fn plane(tilt: f64) -> PlaneForm {
        let domain = [interval(-9.0, 9.0); 2];
        let plane = Plane {
            origin: Point3::new(0.3, -0.2, 0.1),
            x: Vector3::new(1.0, 2.0, 3.0).normalize(),
            y: Vector3::new(3.0, tilt, -1.0).normalize(),
            domain,
            extents: domain,
        };
        PlaneForm::new(&plane).unwrap()
    }

    /// Points of the image, at each part of the angle, are off the arc by the slack at most: seen from either side. Some are by half of it, and it is some roundings.
    #[test]
    fn an_image_is_as_near_an_arc_as_is_said() {
        let form = plane(0.0);
        assert_eq!(form.similar, None);
        for up in [1.0, -1.0] {
            let arc = Arc {
                center: Point2::new(0.7, -1.1),
                x: Vector2::new(0.6, 0.8),
                y: Vector2::new(-0.8, 0.6) * up,
                z: Vector2::zeros(),
                radius: 2.0,
                angle: interval(0.0, 6.0),
                domain: interval(0.0, 3.0),
            };
            let arc = Arc::new(arc).unwrap();
            let span = interval(0.25, 2.75);
            let (shape, slack) = form.nearly_arc(&arc, span).unwrap();
            let CurveShape::Arc(own) = &shape else {
                panic!("no arc");
            };
            let mut most: f64 = 0.0;
            for k in 0..=32 {
                // In parts of the domain, half as long as the angle.
                let turn = f64::from(k) / 32.0 * 5.0;
                let (sin, cos) = sin_cos(Ball::exact(0.5 + turn));
                let [dx, dy] = [arc.x, arc.y].map(|d| {
                    let d = exact_pair(d.as_slice());
                    let length = (d[0].square() + d[1].square()).sqrt();
                    d.map(|c| c / length)
                });
                let uv = [0, 1].map(|c| {
                    Ball::exact(arc.center[c]) + Ball::exact(2.0) * (cos * dx[c] + sin * dy[c])
                });
                let (sin, cos) = sin_cos(Ball::exact(turn));
                let there = add(&scale(&own.x, cos), &scale(&own.y, sin));
                let off = sub(&form.point(uv), &along(&own.center, own.radius, &there));
                let far = off.iter().map(|x| x.mid.hi * x.mid.hi).sum::<f64>().sqrt();
                assert!(far <= slack, "{k}: {far:e} {slack:e}");
                most = most.max(far);
            }
            assert!(
                most > 0.25 * slack && slack < 8.0 * f64::EPSILON,
                "{most:e} {slack:e}"
            );
        }
    }

    #[test]
    fn a_circle_on_skew_axes_is_near_no_arc() {
        let form = plane(1e-6);
        let arc = Arc {
            center: Point2::origin(),
            x: Vector2::x(),
            y: Vector2::y(),
            z: Vector2::zeros(),
            radius: 1.0,
            angle: interval(0.0, 6.0),
            domain: interval(0.0, 6.0),
        };
        let arc = Arc::new(arc).unwrap();
        assert!(form.nearly_arc(&arc, arc.domain).is_none());
    }
}
