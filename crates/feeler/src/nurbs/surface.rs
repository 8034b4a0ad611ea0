//! Surfaces in their native form.

use super::curve::{check_angle, check_interval};
use super::{Curve3, GeometryError, NurbsSurface};
use crate::numeric::Interval;
use nalgebra::{Point3, Vector3};

/// A surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// A plane.
    Plane(Plane),
    /// A surface of revolution.
    Revolution(Revolution),
    /// The sum of two curves.
    Sum(Sum),
    /// A NURBS surface.
    Nurbs(NurbsSurface),
}

/// The plane `origin + a x + b y`, axes as stored (not normalised); `a` runs
/// over `extents[0]` as `u` runs over `domain[0]`, linearly, and `b` likewise.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Origin.
    pub origin: Point3<f64>,
    /// First axis.
    pub x: Vector3<f64>,
    /// Second axis.
    pub y: Vector3<f64>,
    /// Domains of u and v.
    pub domain: [Interval; 2],
    /// Ranges of a and b.
    pub extents: [Interval; 2],
}

/// The exact surface swept by `profile` turned about the axis through `origin`
/// along `axis` (exactly normalised), right-handed, by the angle `a`; `a` runs over `angle` as
/// the angular parameter runs over `angle_domain`, linearly.
///
/// Not transposed, u is the angular parameter and v the profile's; transposed,
/// they swap.
#[derive(Clone, Debug, PartialEq)]
pub struct Revolution {
    /// A point of the axis.
    pub origin: Point3<f64>,
    /// Direction of the axis, as stored.
    pub axis: Vector3<f64>,
    /// Angles in radians.
    pub angle: Interval,
    /// Domain of the angular parameter.
    pub angle_domain: Interval,
    /// The curve that is turned; at angle 0 it stands where it is stored.
    pub profile: Curve3,
    /// Whether u is the profile's parameter.
    pub transposed: bool,
}

/// `S(u, v) = base + first(u) + second(v)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Sum {
    /// Added to both.
    pub base: Vector3<f64>,
    /// The curve along u.
    pub first: Curve3,
    /// The curve along v.
    pub second: Curve3,
}

impl Plane {
    /// Checks that everything is finite and the axes span a plane.
    pub fn new(plane: Self) -> Result<Self, GeometryError> {
        let numbers = [plane.origin.coords, plane.x, plane.y];
        if numbers.iter().any(|v| v.iter().any(|x| !x.is_finite())) {
            return Err(GeometryError::NotFinite {
                what: "a plane's frame",
            });
        }
        for i in 0..2 {
            check_interval("a plane's domain", plane.domain[i])?;
            check_interval("a plane's range", plane.extents[i])?;
        }
        if plane.x.cross(&plane.y).norm() == 0.0 {
            return Err(GeometryError::Degenerate {
                what: "a plane's frame",
            });
        }
        Ok(plane)
    }
}

impl Revolution {
    /// Checks that the axis is finite and not zero.
    pub fn new(revolution: Self) -> Result<Self, GeometryError> {
        let numbers = [revolution.origin.coords, revolution.axis];
        if numbers.iter().any(|v| v.iter().any(|x| !x.is_finite())) {
            return Err(GeometryError::NotFinite {
                what: "a revolution's axis",
            });
        }
        check_angle("a revolution", revolution.angle)?;
        check_interval("a revolution's angular domain", revolution.angle_domain)?;
        if revolution.axis.norm() == 0.0 {
            return Err(GeometryError::Degenerate {
                what: "a revolution's axis",
            });
        }
        Ok(revolution)
    }
}

impl Surface {
    /// The same surface where the first weight of each NURBS in it is between 1 and 2, as of [curves](Curve3::with_scaled_weights).
    pub(crate) fn with_scaled_weights(&self) -> Option<Self> {
        match self {
            Self::Nurbs(s) => s.with_scaled_weights().map(Self::Nurbs),
            Self::Revolution(s) => {
                let profile = s.profile.with_scaled_weights()?;
                Some(Self::Revolution(Revolution {
                    profile,
                    ..s.clone()
                }))
            }
            Self::Sum(s) => {
                let [first, second] = [&s.first, &s.second].map(Curve3::with_scaled_weights);
                (first.is_some() || second.is_some()).then(|| {
                    Self::Sum(Sum {
                        base: s.base,
                        first: first.unwrap_or_else(|| s.first.clone()),
                        second: second.unwrap_or_else(|| s.second.clone()),
                    })
                })
            }
            Self::Plane(_) => None,
        }
    }

    /// The parameter domain, u and v.
    pub fn domain(&self) -> [Interval; 2] {
        match self {
            Self::Plane(s) => s.domain,
            Self::Revolution(s) => {
                let profile = s.profile.domain();
                if s.transposed {
                    [profile, s.angle_domain]
                } else {
                    [s.angle_domain, profile]
                }
            }
            Self::Sum(s) => [s.first.domain(), s.second.domain()],
            Self::Nurbs(s) => s.domain(),
        }
    }

    /// The type's name in reports: `plane`, `revolution`, `sum`, `nurbs`.
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::Plane(_) => "plane",
            Self::Revolution(_) => "revolution",
            Self::Sum(_) => "sum",
            Self::Nurbs(_) => "nurbs",
        }
    }
}
