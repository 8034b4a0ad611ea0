//! Handing a BREP to C++ as raw numbers.

use crate::bridge::ffi;
use crate::truth::OracleError;
use feeler::brep::Brep;
use feeler::numeric::Interval;
use feeler::nurbs::{Curve2, NurbsSurface, Plane, Surface};

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
            face(&mut builder, brep, index, faces, edges)?;
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

/// Face `index` of one BREP; it is face `global` of all, and the BREP's edges start at `edges`.
fn face(
    builder: &mut cxx::UniquePtr<ffi::Builder>,
    brep: &Brep,
    index: usize,
    global: usize,
    edges: usize,
) -> Result {
    let parts = brep.parts();
    let face = &brep.faces()[index];
    match brep.surface(index) {
        Surface::Nurbs(s) => nurbs_surface(builder, s, face.reversed)?,
        Surface::Plane(s) => plane(builder, s, face.reversed)?,
        other => {
            return Err(OracleError::Unsupported {
                face: global,
                kind: other.type_name(),
            });
        }
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
            let params = match curve {
                Curve2::Poly(c) => c.params().to_vec(),
                other => ends(other.domain()),
            };
            builder.pin_mut().add_trim(
                trim.span.start,
                trim.span.end,
                trim.reversed,
                edge,
                &params,
            )?;
            match curve {
                Curve2::Poly(c) => {
                    for segment in c.segments() {
                        piece(builder, segment, global)?;
                    }
                }
                other => piece(builder, other, global)?,
            }
        }
    }
    Ok(())
}

fn ends(domain: Interval) -> Vec<f64> {
    vec![domain.start, domain.end]
}

/// A curve that is no poly-curve.
fn piece(builder: &mut cxx::UniquePtr<ffi::Builder>, curve: &Curve2, face: usize) -> Result {
    match curve {
        Curve2::Line(c) => builder
            .pin_mut()
            .add_polyline(&[c.from.x, c.from.y, c.to.x, c.to.y], &ends(c.domain))?,
        Curve2::Polyline(c) => {
            let points: Vec<f64> = c.points().iter().flat_map(|p| [p.x, p.y]).collect();
            builder.pin_mut().add_polyline(&points, c.params())?;
        }
        Curve2::Nurbs(c) => {
            let points: Vec<f64> = c
                .control_points()
                .iter()
                .flat_map(|p| [p.x, p.y, p.z])
                .collect();
            builder
                .pin_mut()
                .add_nurbs_curve(c.degree(), c.knots().knots(), &points)?;
        }
        other => {
            return Err(OracleError::Unsupported {
                face,
                kind: other.type_name(),
            });
        }
    }
    Ok(())
}

fn nurbs_surface(
    builder: &mut cxx::UniquePtr<ffi::Builder>,
    s: &NurbsSurface,
    reversed: bool,
) -> Result {
    let net: Vec<f64> = s
        .control_net()
        .iter()
        .flat_map(|p| [p.x, p.y, p.z, p.w])
        .collect();
    builder.pin_mut().add_nurbs_face(
        reversed,
        s.knots_u().degree(),
        s.knots_v().degree(),
        s.knots_u().knots(),
        s.knots_v().knots(),
        &net,
    )?;
    Ok(())
}

fn plane(builder: &mut cxx::UniquePtr<ffi::Builder>, s: &Plane, reversed: bool) -> Result {
    let mut numbers = Vec::with_capacity(17);
    for v in [&s.origin.coords, &s.x, &s.y] {
        numbers.extend_from_slice(v.as_slice());
    }
    for i in s.domain.iter().chain(&s.extents) {
        numbers.extend(ends(*i));
    }
    builder.pin_mut().add_plane_face(reversed, &numbers)?;
    Ok(())
}
