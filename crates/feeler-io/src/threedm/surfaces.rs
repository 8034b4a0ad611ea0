//! Surfaces.

use super::archive::Chunk;
use super::class::{self, Class};
use super::curves::{
    REMEDY, SplineSize, control_point, control_point_count, curve, few_turns, geometry, rational,
};
use crate::error::{Problem, ReadError};
use feeler::nurbs::{NurbsSurface, Plane, Revolution, Sum, Surface};
use nalgebra::{Point3, Vector3};

/// The surface that is the next chunk of `parent`.
pub(super) fn surface(parent: &mut Chunk<'_>) -> Result<Surface, ReadError> {
    let (class, data) = class::object(parent)?;
    surface_of(class, data)
}

/// The same when class and data are at hand.
pub(super) fn surface_of(class: Class, mut data: Chunk<'_>) -> Result<Surface, ReadError> {
    let surface = match class {
        Class::PlaneSurface => Surface::Plane(plane(&mut data)?),
        Class::RevSurface => Surface::Revolution(revolution(&mut data)?),
        Class::SumSurface => Surface::Sum(sum(&mut data)?),
        Class::NurbsSurface => Surface::Nurbs(nurbs(&mut data)?),
        _ => {
            return Err(data.fail_at(
                data.id.offset,
                Problem::Class {
                    class: class.name(),
                    role: "a surface",
                    remedy: "convert it to NURBS (Rhino: ToNURBS) and save again",
                },
            ));
        }
    };
    data.finish()?;
    Ok(surface)
}

fn vector(data: &mut Chunk<'_>, what: &'static str) -> Result<Vector3<f64>, ReadError> {
    data.f64s(what).map(Vector3::from)
}

fn plane(data: &mut Chunk<'_>) -> Result<Plane, ReadError> {
    let (_, minor) = class::layout(data, "PlaneSurface", &[1], REMEDY)?;
    let origin = Point3::from(vector(data, "a plane's origin")?);
    let x = vector(data, "a plane's x axis")?;
    let y = vector(data, "a plane's y axis")?;
    // Normal and equation follow from the axes.
    data.f64s::<7>("a plane's normal and equation")?;
    let domain = [
        data.interval("a plane's domain along u")?,
        data.interval("a plane's domain along v")?,
    ];
    // Before 1.1 the parameters were the plane's coordinates.
    let extents = if minor >= 1 {
        [
            data.interval("a plane's extent along u")?,
            data.interval("a plane's extent along v")?,
        ]
    } else {
        domain
    };
    let plane = Plane {
        origin,
        x,
        y,
        domain,
        extents,
    };
    geometry(data, "PlaneSurface", Plane::new(plane))
}

fn revolution(data: &mut Chunk<'_>) -> Result<Revolution, ReadError> {
    let (major, _) = class::layout(data, "RevSurface", &[1, 2], REMEDY)?;
    let from = vector(data, "the start of an axis")?;
    let to = vector(data, "the end of an axis")?;
    let angle = few_turns(data, "an angle of revolution")?;
    // In 1.x the parameter was the angle.
    let angle_domain = if major >= 2 {
        data.interval("the domain of an angle of revolution")?
    } else {
        angle
    };
    data.f64s::<6>("a surface's box")?;
    let transposed = data.i32("the transposed flag")? != 0;
    let at = data.position();
    if data.u8("whether there is a profile")? == 0 {
        return Err(data.fail_at(
            at,
            Problem::Value {
                what: "the profile of a surface of revolution".into(),
                found: "missing".into(),
                expected: "a curve".into(),
            },
        ));
    }
    let profile = curve(data, "the profile of a surface of revolution")?;
    let revolution = Revolution {
        origin: Point3::from(from),
        axis: to - from,
        angle,
        angle_domain,
        profile,
        transposed,
    };
    geometry(data, "RevSurface", Revolution::new(revolution))
}

fn sum(data: &mut Chunk<'_>) -> Result<Sum, ReadError> {
    class::layout(data, "SumSurface", &[1], REMEDY)?;
    let at = data.position();
    let base = vector(data, "a base point")?;
    if base.iter().any(|x| !x.is_finite()) {
        return Err(data.fail_at(
            at,
            Problem::Value {
                what: "the base point of a sum surface".into(),
                found: format!("{:?}", base.as_slice()),
                expected: "finite numbers".into(),
            },
        ));
    }
    data.f64s::<6>("a surface's box")?;
    let first = curve(data, "the first curve of a sum surface")?;
    let second = curve(data, "the second curve of a sum surface")?;
    Ok(Sum {
        base,
        first,
        second,
    })
}

/// A NURBS surface whose fields come next.
pub(super) fn nurbs(data: &mut Chunk<'_>) -> Result<NurbsSurface, ReadError> {
    class::layout(data, "NurbsSurface", &[1], REMEDY)?;
    let at = data.position();
    let dimension = data.i32("the dimension")?;
    if dimension != 3 {
        return Err(data.fail_at(
            at,
            Problem::Value {
                what: "the surface's dimension".into(),
                found: dimension.to_string(),
                expected: "3".into(),
            },
        ));
    }
    let rational = rational(data)?;
    let at = data.position();
    let order_u = data.i32("the order along u")?;
    let order_v = data.i32("the order along v")?;
    let count_u = data.i32("the number of control points along u")?;
    let count_v = data.i32("the number of control points along v")?;
    let point_size = 3 * size_of::<f64>();
    let u = SplineSize::new(data, at, order_u, count_u, point_size)?;
    let v = SplineSize::new(data, at, order_v, count_v, point_size)?;
    // Each count is at most the file's size / 24, but their product may not be.
    let product = i64::from(count_u) * i64::from(count_v);
    let count = data.check_count(at, "control points", product, point_size)?;
    data.skip(2 * size_of::<i32>(), "reserved fields")?;
    data.f64s::<6>("a surface's box")?;
    let knots = [u.knots(data)?, v.knots(data)?];
    control_point_count(data, count)?;
    // u is the outer loop, as in the kernel.
    let mut net = Vec::with_capacity(count);
    for _ in 0..count {
        net.push(control_point(data, rational)?);
    }
    geometry(
        data,
        "NurbsSurface",
        NurbsSurface::new([u.degree, v.degree], [u.count, v.count], net, knots),
    )
}
