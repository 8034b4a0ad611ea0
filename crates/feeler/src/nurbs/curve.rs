//! Curves in their native form.

use super::eval::frame;
use super::{GeometryError, NurbsCurve};
use crate::numeric::{Interval, MAX_ANGLE};
use nalgebra::{Point, SVector};

/// A curve in `D` dimensions; `H = D + 1` is the size of its homogeneous points.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve<const D: usize, const H: usize> {
    /// A straight segment.
    Line(Line<D>),
    /// A circular arc.
    Arc(Arc<D>),
    /// Straight segments in a row.
    Polyline(Polyline<D>),
    /// A NURBS curve.
    Nurbs(NurbsCurve<H>),
    /// Curves in a row.
    Poly(PolyCurve<D, H>),
}

/// A curve in uv.
pub type Curve2 = Curve<2, 3>;
/// A curve in space.
pub type Curve3 = Curve<3, 4>;

/// The segment `from + s (to - from)` with `s = (t - start) / (end - start)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Line<const D: usize> {
    /// Start point.
    pub from: Point<f64, D>,
    /// End point.
    pub to: Point<f64, D>,
    /// Domain of `t`.
    pub domain: Interval,
}

/// The exact arc `center + radius (cos a x' + sin a y')`, `a` running over `angle` as
/// the parameter runs over `domain`, linearly.
///
/// In space `z'` is the stored `z` exactly normalised, `x'` the stored `x` made
/// exactly orthogonal to `z'` and normalised, `y' = z' × x'`. In uv `x'` is the stored `x` normalised
/// and `y'` is `x'` turned by +90 degrees, or by -90 where the stored `y` lies on that side
/// (`z` is then zero and has no meaning).
#[derive(Clone, Debug, PartialEq)]
pub struct Arc<const D: usize> {
    /// Centre of the circle.
    pub center: Point<f64, D>,
    /// Direction of angle 0, as stored.
    pub x: SVector<f64, D>,
    /// Direction of angle 90 degrees, as stored.
    pub y: SVector<f64, D>,
    /// Axis of the circle, as stored (space only).
    pub z: SVector<f64, D>,
    /// Radius, positive.
    pub radius: f64,
    /// Angles at the start and at the end, in radians.
    pub angle: Interval,
    /// Domain of the parameter.
    pub domain: Interval,
}

/// Points in a row, joined by straight segments; point `i` at parameter `params[i]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline<const D: usize> {
    points: Vec<Point<f64, D>>,
    params: Vec<f64>,
}

/// Curves in a row; segment `i`, run over its own span of parameters, covers
/// `[params[i], params[i + 1]]` linearly. Segments are never poly-curves themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct PolyCurve<const D: usize, const H: usize> {
    segments: Vec<Curve<D, H>>,
    params: Vec<f64>,
}

fn finite<const D: usize>(
    what: &'static str,
    values: impl IntoIterator<Item = SVector<f64, D>>,
) -> Result<(), GeometryError> {
    let mut all = values.into_iter();
    if all.all(|v| v.iter().all(|x| x.is_finite())) {
        Ok(())
    } else {
        Err(GeometryError::NotFinite { what })
    }
}

/// An interval of finite ends in order.
pub(super) fn check_interval(what: &'static str, i: Interval) -> Result<(), GeometryError> {
    match Interval::new(i.start, i.end) {
        Some(_) => Ok(()),
        None => Err(GeometryError::EmptyInterval { what }),
    }
}

/// Angles whose sine and cosine are known, in order.
pub(super) fn check_angle(what: &'static str, angle: Interval) -> Result<(), GeometryError> {
    check_interval("an angle interval", angle)?;
    if angle.start < -MAX_ANGLE || angle.end > MAX_ANGLE {
        return Err(GeometryError::Angle {
            what,
            start: angle.start,
            end: angle.end,
        });
    }
    Ok(())
}

fn increasing(params: &[f64]) -> Result<(), GeometryError> {
    if params.iter().any(|t| !t.is_finite()) {
        return Err(GeometryError::NotFinite {
            what: "a parameter",
        });
    }
    match params.windows(2).position(|w| w[1] <= w[0]) {
        Some(_) => Err(GeometryError::EmptyInterval {
            what: "a parameter interval",
        }),
        None => Ok(()),
    }
}

impl<const D: usize> Line<D> {
    /// A segment; the end points must be finite (they may coincide).
    pub fn new(
        from: Point<f64, D>,
        to: Point<f64, D>,
        domain: Interval,
    ) -> Result<Self, GeometryError> {
        finite("a line's end point", [from.coords, to.coords])?;
        check_interval("a line's domain", domain)?;
        Ok(Self { from, to, domain })
    }
}

impl<const D: usize> Arc<D> {
    /// Checks that everything is finite, the radius positive and the axes usable.
    pub fn new(arc: Self) -> Result<Self, GeometryError> {
        finite("an arc's frame", [arc.center.coords, arc.x, arc.y, arc.z])?;
        if !arc.radius.is_finite() {
            return Err(GeometryError::NotFinite {
                what: "an arc's radius",
            });
        }
        if arc.radius <= 0.0 {
            return Err(GeometryError::Degenerate {
                what: "an arc's radius",
            });
        }
        check_angle("an arc", arc.angle)?;
        check_interval("an arc's domain", arc.domain)?;
        if arc.x.norm() == 0.0 || (D == 3 && arc.z.norm() == 0.0) {
            return Err(GeometryError::Degenerate {
                what: "an arc's frame",
            });
        }
        /// 2^-60: a direction known worse than that in double-double (106 bits) is none: x and z
        /// parallel up to their last digits.
        const UNKNOWN: f64 = 1.0 / (1u64 << 60) as f64;
        let (x, _) = frame(&arc);
        if !x.iter().all(|c| c.rad <= UNKNOWN) {
            return Err(GeometryError::Degenerate {
                what: "an arc's frame",
            });
        }
        Ok(arc)
    }
}

impl<const D: usize> Polyline<D> {
    /// At least two points, as many parameters, strictly increasing.
    pub fn new(points: Vec<Point<f64, D>>, params: Vec<f64>) -> Result<Self, GeometryError> {
        if points.len() < 2 || params.len() != points.len() {
            return Err(GeometryError::TooFew {
                what: "polyline points",
                found: points.len().min(params.len()),
                needed: points.len().max(2),
            });
        }
        finite("a polyline point", points.iter().map(|p| p.coords))?;
        increasing(&params)?;
        Ok(Self { points, params })
    }

    /// The points.
    pub fn points(&self) -> &[Point<f64, D>] {
        &self.points
    }

    /// The parameter of each point.
    pub fn params(&self) -> &[f64] {
        &self.params
    }
}

impl<const D: usize, const H: usize> PolyCurve<D, H> {
    /// At least one segment and one parameter more than segments, strictly
    /// increasing. Segments that are poly-curves are replaced by their own segments,
    /// their parameters mapped linearly (rounded; the points are untouched).
    pub fn new(segments: Vec<Curve<D, H>>, params: Vec<f64>) -> Result<Self, GeometryError> {
        if segments.is_empty() || params.len() != segments.len() + 1 {
            return Err(GeometryError::TooFew {
                what: "poly-curve parameters",
                found: params.len(),
                needed: segments.len().max(1) + 1,
            });
        }
        increasing(&params)?;
        let mut flat = Vec::with_capacity(segments.len());
        let mut flat_params = vec![params[0]];
        for (i, segment) in segments.into_iter().enumerate() {
            let to = params[i + 1];
            if let Curve::Poly(inner) = segment {
                let own = inner.domain();
                let scale = (to - params[i]) / own.length();
                let last = inner.segments.len();
                for (k, piece) in inner.segments.into_iter().enumerate() {
                    flat.push(piece);
                    flat_params.push(if k + 1 == last {
                        to
                    } else {
                        params[i] + (inner.params[k + 1] - own.start) * scale
                    });
                }
            } else {
                flat.push(segment);
                flat_params.push(to);
            }
        }
        increasing(&flat_params)?;
        Ok(Self {
            segments: flat,
            params: flat_params,
        })
    }

    /// The segments, none of them a poly-curve.
    pub fn segments(&self) -> &[Curve<D, H>] {
        &self.segments
    }

    /// Where each segment starts, and the end of the last.
    pub fn params(&self) -> &[f64] {
        &self.params
    }

    /// The parameter domain.
    pub fn domain(&self) -> Interval {
        Interval {
            start: self.params[0],
            end: self.params[self.params.len() - 1],
        }
    }
}

impl<const D: usize, const H: usize> Curve<D, H> {
    /// The same curve where the first weight of each NURBS in it is between 1 and 2: homogeneous points are multiplied by powers of two, which loses no digit.
    /// `None` where it is so, or may not be made so.
    pub(crate) fn with_scaled_weights(&self) -> Option<Self> {
        self.with_each_nurbs(NurbsCurve::with_scaled_weights)
    }

    /// The same points at another pace, that of the Bezier curves of which NURBS in it are made: one of a single span has a last weight about as large as its first.
    /// `None` where it is so, or may not be made so.
    pub(crate) fn with_even_weights(&self) -> Option<Self> {
        self.with_each_nurbs(NurbsCurve::with_even_weights)
    }

    /// The same curve with what becomes of each NURBS in it, if anything.
    fn with_each_nurbs(
        &self,
        changed: fn(&NurbsCurve<H>) -> Option<NurbsCurve<H>>,
    ) -> Option<Self> {
        match self {
            Self::Nurbs(c) => changed(c).map(Self::Nurbs),
            // Segments are never poly-curves themselves: this goes one level deep.
            Self::Poly(c) => {
                let all: Vec<_> = { c.segments.iter() }
                    .map(|s| s.with_each_nurbs(changed))
                    .collect();
                all.iter().any(Option::is_some).then(|| {
                    let pairs = c.segments.iter().zip(all);
                    let segments = pairs.map(|(own, new)| new.unwrap_or_else(|| own.clone()));
                    Self::Poly(PolyCurve {
                        segments: segments.collect(),
                        params: c.params.clone(),
                    })
                })
            }
            Self::Line(_) | Self::Arc(_) | Self::Polyline(_) => None,
        }
    }

    /// The parameter domain.
    pub fn domain(&self) -> Interval {
        match self {
            Self::Line(c) => c.domain,
            Self::Arc(c) => c.domain,
            Self::Polyline(c) => Interval {
                start: c.params[0],
                end: c.params[c.params.len() - 1],
            },
            Self::Nurbs(c) => c.domain(),
            Self::Poly(c) => c.domain(),
        }
    }

    /// Where the curve may be less smooth than elsewhere, in order, with both ends of the domain: knots,
    /// corners and joints (those inside segments of a poly-curve rounded).
    pub fn breaks(&self) -> Vec<f64> {
        let own = |c: &Self| -> Vec<f64> {
            match c {
                Self::Polyline(c) => c.params.clone(),
                Self::Nurbs(c) => {
                    let mut all = vec![c.domain().start];
                    all.extend(c.knots().spans().map(|(_, _, end)| end));
                    all
                }
                _ => vec![c.domain().start, c.domain().end],
            }
        };
        let Self::Poly(poly) = self else {
            return own(self);
        };
        let mut all = vec![poly.params[0]];
        for (segment, w) in poly.segments.iter().zip(poly.params.windows(2)) {
            let (from, to) = (
                segment.domain(),
                Interval {
                    start: w[0],
                    end: w[1],
                },
            );
            let inner = own(segment);
            for t in &inner[1..inner.len() - 1] {
                all.push(to.lerp((t - from.start) / from.length()));
            }
            all.push(to.end);
        }
        all
    }

    /// The type's name in reports: `line`, `arc`, `polyline`, `nurbs`, `polycurve`.
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::Line(_) => "line",
            Self::Arc(_) => "arc",
            Self::Polyline(_) => "polyline",
            Self::Nurbs(_) => "nurbs",
            Self::Poly(_) => "polycurve",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector4};

    fn line(a: [f64; 3], b: [f64; 3]) -> Curve3 {
        let domain = Interval::new(0.0, 1.0).unwrap();
        Curve::Line(Line::new(a.into(), b.into(), domain).unwrap())
    }

    /// A poly-curve within another is taken apart, its parameters moved linearly.
    #[test]
    fn nested_poly_curves() {
        let a = [0., 1., 2., 5.].map(|x| [x, x * x, 0.]);
        let inner = vec![line(a[1], a[2]), line(a[2], a[3])];
        let inner = PolyCurve::new(inner, vec![1.0, 2.0, 4.0]).unwrap();
        let segments = vec![line(a[0], a[1]), Curve::Poly(inner)];
        let outer = PolyCurve::new(segments.clone(), vec![0.0, 2.0, 8.0]).unwrap();
        // [1, 4] goes to [2, 8]: twice as fast.
        assert_eq!(outer.params(), [0.0, 2.0, 4.0, 8.0]);
        assert_eq!(outer.segments().len(), 3);
        let c: Curve3 = Curve::Poly(outer);
        assert_eq!(c.point(3.0), Point3::new(1.5, 2.5, 0.));
        assert_eq!(c.point(6.0), Point3::new(3.5, 14.5, 0.));
        // As many parameters as segments are one too few.
        let few = PolyCurve::new(segments, vec![0.0, 2.0]);
        let expected = GeometryError::TooFew {
            what: "poly-curve parameters",
            found: 2,
            needed: 3,
        };
        assert_eq!(few.unwrap_err(), expected);
    }

    /// Only the directions of axes count, and the ends of a line are its points, bit for bit.
    #[test]
    fn frames_of_any_length_and_ends_of_lines() {
        let of = |x: f64, z: f64| -> Curve3 {
            let arc = Arc::new(Arc {
                center: Point3::origin(),
                x: SVector::from([3., 4., 0.]) * x,
                y: SVector::from([0.; 3]),
                z: SVector::from([0., 0., 1.]) * z,
                radius: 5.0,
                angle: Interval::new(0.0, 1.0).unwrap(),
                domain: Interval::new(0.0, 1.0).unwrap(),
            });
            Curve::Arc(arc.unwrap())
        };
        for (x, z) in [
            (1.0, 1.0),
            (1e-150, 1.0),
            (1.0, 1e-150),
            (1e150, 1e-150),
            (1e-150, 1e150),
        ] {
            let start = of(x, z).point(0.0);
            assert!(
                (start - Point3::new(3., 4., 0.)).norm() < 1e-14,
                "{x:e} {z:e}"
            );
        }
        for k in 1..50 {
            let x = f64::from(k) * 0.1;
            let (a, b) = ([x, 7.3, -1e3 / x], [1.0 / x, 1e-3 * x, 2.7]);
            let c = line(a, b);
            assert_eq!((c.point(0.0), c.point(1.0)), (a.into(), b.into()));
        }
    }

    #[test]
    fn parameters_of_polylines_rise() {
        let of = |count: u32, params: &[f64]| {
            let points = (0..count).map(|i| Point3::new(f64::from(i), 0., 0.));
            Polyline::new(points.collect(), params.to_vec())
        };
        assert!(of(3, &[0.0, 1.0, 2.0]).is_ok());
        for (count, params) in [
            (1, &[0.0][..]),
            (0, &[]),
            (3, &[0.0, 1.0]),
            (2, &[0.0, 1.0, 2.0]),
        ] {
            assert!(matches!(
                of(count, params),
                Err(GeometryError::TooFew { .. })
            ));
        }
        for params in [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 2.0, 1.0]] {
            assert!(matches!(
                of(3, &params),
                Err(GeometryError::EmptyInterval { .. })
            ));
        }
        let nan = of(2, &[0.0, f64::NAN]);
        assert!(matches!(nan, Err(GeometryError::NotFinite { .. })));
    }

    #[test]
    fn breaks_are_knots_corners_and_joints() {
        let points = [0., 1., 2., 3.].map(|x| Vector4::new(x, 0., 0., 1.));
        let knots = vec![0., 0., 0., 0.4, 1., 1., 1.];
        let spline: Curve3 = Curve::Nurbs(NurbsCurve::new(2, points.to_vec(), knots).unwrap());
        assert_eq!(spline.breaks(), [0.0, 0.4, 1.0]);
        let corners = [[0., 0.], [1., 1.], [2., 0.]].map(|p| Point3::new(p[0], p[1], 0.));
        let bent: Curve3 =
            Curve::Polyline(Polyline::new(corners.to_vec(), vec![1.0, 1.5, 3.0]).unwrap());
        assert_eq!(bent.breaks(), [1.0, 1.5, 3.0]);
        assert_eq!(line([0., 0., 0.], [1., 0., 0.]).breaks(), [0.0, 1.0]);
        let all = vec![bent, line([2., 0., 0.], [3., 0., 0.])];
        let poly: Curve3 = Curve::Poly(PolyCurve::new(all, vec![4.0, 12.0, 13.0]).unwrap());
        // A quarter of the way from 4 to 12.
        assert_eq!(poly.breaks(), [4.0, 6.0, 12.0, 13.0]);
    }

    /// Coordinates that are no numbers are refused, wherever they stand.
    #[test]
    fn points_are_finite() {
        let domain = Interval::new(0.0, 1.0).unwrap();
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for k in 0..3 {
                let mut p = [1.0, 2.0, 3.0];
                p[k] = bad;
                for (a, b) in [(p, [0.0; 3]), ([0.0; 3], p)] {
                    let found = Line::new(a.into(), b.into(), domain);
                    assert!(matches!(found, Err(GeometryError::NotFinite { .. })));
                }
                let points = vec![Point3::origin(), p.into()];
                let found = Polyline::new(points, vec![0.0, 1.0]);
                assert!(matches!(found, Err(GeometryError::NotFinite { .. })));
            }
        }
    }
}
