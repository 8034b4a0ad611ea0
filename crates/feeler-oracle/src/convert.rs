//! Handing a BREP to C++ as raw numbers.

use crate::bridge::ffi;
use crate::truth::OracleError;
use feeler::brep::Brep;
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Curve2, Curve3, NurbsSurface, Plane, Revolution, Sum, Surface};

type Result<T = ()> = std::result::Result<T, OracleError>;

/// The C++ model of these BREPs, and how many faces it has.
pub(crate) fn core(breps: &[&Brep]) -> Result<(cxx::UniquePtr<ffi::Core>, usize)> {
    let mut builder = ffi::new_builder();
    let mut faces = 0;
    let mut edges = 0;
    for brep in breps {
        let count = brep.parts().edges.len();
        builder.pin_mut().add_brep(brep.is_closed(), count)?;
        for index in 0..brep.faces().len() {
            face(&mut builder, brep, index, edges)?;
            faces += 1;
        }
        edges += count;
    }
    Ok((builder.pin_mut().finish()?, faces))
}

impl From<cxx::Exception> for OracleError {
    fn from(e: cxx::Exception) -> Self {
        Self::Refused(e.what().to_owned())
    }
}

/// Face `index` of one BREP, whose edges start at `edges`.
fn face(
    builder: &mut cxx::UniquePtr<ffi::Builder>,
    brep: &Brep,
    index: usize,
    edges: usize,
) -> Result {
    let parts = brep.parts();
    let face = &brep.faces()[index];
    match brep.surface(index) {
        Surface::Nurbs(s) => nurbs_surface(builder, s, face.reversed)?,
        Surface::Plane(s) => plane(builder, s, face.reversed)?,
        Surface::Revolution(s) => revolution(builder, s, face.reversed)?,
        Surface::Sum(s) => sum(builder, s, face.reversed)?,
    }
    let Some(loops) = &face.loops else {
        return Ok(());
    };
    builder.pin_mut().set_trimmed()?;
    for l in loops {
        builder.pin_mut().add_loop()?;
        for t in &parts.loops[*l].trims {
            let trim = &parts.trims[*t];
            let edge = trim.edge.map_or(-1, |e| (edges + e) as i64);
            let curve = &parts.curves2[trim.curve];
            builder.pin_mut().add_trim(
                trim.span.start,
                trim.span.end,
                trim.reversed,
                edge,
                &params(curve),
            )?;
            for segment in segments(curve) {
                piece(builder, segment)?;
            }
        }
    }
    Ok(())
}

fn ends(domain: Interval) -> [f64; 2] {
    [domain.start, domain.end]
}

/// Where the pieces of a curve start, and the end of the last.
fn params<const D: usize, const H: usize>(curve: &Curve<D, H>) -> Vec<f64> {
    match curve {
        Curve::Poly(c) => c.params().to_vec(),
        other => ends(other.domain()).to_vec(),
    }
}

/// The pieces, none of them a poly-curve.
fn segments<const D: usize, const H: usize>(curve: &Curve<D, H>) -> &[Curve<D, H>] {
    match curve {
        Curve::Poly(c) => c.segments(),
        other => std::slice::from_ref(other),
    }
}

/// A trim curve that is no poly-curve.
fn piece(builder: &mut cxx::UniquePtr<ffi::Builder>, curve: &Curve2) -> Result {
    let builder = builder.pin_mut();
    match curve {
        Curve2::Line(c) => {
            builder.add_polyline(&[c.from.x, c.from.y, c.to.x, c.to.y], &ends(c.domain))?;
        }
        Curve2::Polyline(c) => {
            let points: Vec<f64> = c.points().iter().flat_map(|p| [p.x, p.y]).collect();
            builder.add_polyline(&points, c.params())?;
        }
        Curve2::Nurbs(c) => {
            let points: Vec<f64> = numbers(c.control_points());
            builder.add_nurbs_curve(c.degree(), c.knots().knots(), &points)?;
        }
        Curve2::Arc(c) => {
            let mut all = numbers(&[c.center.coords, c.x, c.y]);
            all.push(c.radius);
            all.extend([c.angle, c.domain].into_iter().flat_map(ends));
            builder.add_arc(&all)?;
        }
        Curve2::Poly(_) => return Err(nested()),
    }
    Ok(())
}

fn nested() -> OracleError {
    OracleError::Defect("a poly-curve inside a poly-curve")
}

/// The coordinates of all vectors in a row.
fn numbers<const N: usize>(vectors: &[nalgebra::SVector<f64, N>]) -> Vec<f64> {
    vectors.iter().flat_map(|v| v.iter().copied()).collect()
}

/// A curve in space, for the next face.
fn space_curve(builder: &mut cxx::UniquePtr<ffi::Builder>, curve: &Curve3) -> Result {
    let mut builder = builder.pin_mut();
    builder.as_mut().add_curve(&params(curve))?;
    for segment in segments(curve) {
        let builder = builder.as_mut();
        match segment {
            Curve3::Line(c) => {
                let points = numbers(&[c.from.coords, c.to.coords]);
                builder.add_space_polyline(&points, &ends(c.domain))?;
            }
            Curve3::Polyline(c) => {
                let points: Vec<f64> = c.points().iter().flat_map(|p| [p.x, p.y, p.z]).collect();
                builder.add_space_polyline(&points, c.params())?;
            }
            Curve3::Nurbs(c) => {
                let points = numbers(c.control_points());
                builder.add_space_nurbs_curve(c.degree(), c.knots().knots(), &points)?;
            }
            Curve3::Arc(c) => {
                let mut all = numbers(&[c.center.coords, c.x, c.z]);
                all.push(c.radius);
                all.extend([c.angle, c.domain].into_iter().flat_map(ends));
                builder.add_space_arc(&all)?;
            }
            Curve3::Poly(_) => return Err(nested()),
        }
    }
    Ok(())
}

fn nurbs_surface(
    builder: &mut cxx::UniquePtr<ffi::Builder>,
    s: &NurbsSurface,
    reversed: bool,
) -> Result {
    builder.pin_mut().add_nurbs_face(
        reversed,
        s.knots_u().degree(),
        s.knots_v().degree(),
        s.knots_u().knots(),
        s.knots_v().knots(),
        &numbers(s.control_net()),
    )?;
    Ok(())
}

fn plane(builder: &mut cxx::UniquePtr<ffi::Builder>, s: &Plane, reversed: bool) -> Result {
    let mut all = numbers(&[s.origin.coords, s.x, s.y]);
    all.extend(s.domain.into_iter().chain(s.extents).flat_map(ends));
    builder.pin_mut().add_plane_face(reversed, &all)?;
    Ok(())
}

fn revolution(
    builder: &mut cxx::UniquePtr<ffi::Builder>,
    s: &Revolution,
    reversed: bool,
) -> Result {
    space_curve(builder, &s.profile)?;
    let mut all = numbers(&[s.origin.coords, s.axis]);
    all.extend([s.angle, s.angle_domain].into_iter().flat_map(ends));
    builder
        .pin_mut()
        .add_revolution_face(reversed, s.transposed, &all)?;
    Ok(())
}

fn sum(builder: &mut cxx::UniquePtr<ffi::Builder>, s: &Sum, reversed: bool) -> Result {
    space_curve(builder, &s.first)?;
    space_curve(builder, &s.second)?;
    builder
        .pin_mut()
        .add_sum_face(reversed, s.base.as_slice())?;
    Ok(())
}
