//! Model files of our own: BREPs as JSON, exactly.
//!
//! ```text
//! {"feeler_model": 1, "unit": "mm", "breps": [{
//!   "surfaces": [{"nurbs": {"degrees": [1, 2], "knots": [[..], [..]], "points": [wx, wy, wz, w, ..]}},
//!                {"plane": {"origin", "x", "y", "domain": [[a, b], [a, b]], "extents": [[a, b], [a, b]]}},
//!                {"revolution": {"origin", "axis", "angle", "angle_domain", "profile", "transposed"}},
//!                {"sum": {"base", "first", "second"}}],
//!   "curves2": [{"line": {"from", "to", "domain"}}, {"polyline": {"points", "params"}},
//!               {"arc": {"center", "x", "y", "z", "radius", "angle", "domain"}},
//!               {"nurbs": {"degree", "knots", "points"}}, {"poly": {"segments", "params"}}],
//!   "curves3": [..],
//!   "vertices": [{"point", "edges", "tolerance"}],
//!   "edges": [{"curve", "span", "reversed", "vertices", "trims", "tolerance"}],
//!   "trims": [{"curve", "span", "reversed", "edge", "edge_reversed", "vertices", "kind", "iso", "loop"}],
//!   "loops": [{"kind", "trims", "face"}],
//!   "faces": [{"surface", "reversed", "loops"}]}]}
//! ```
//!
//! The fields mean what they mean in [`feeler::brep`] and [`feeler::nurbs`]; points are flat lists, the net of a surface
//! row by row, all NURBS homogeneous with full knot vectors (`n + p + 2` knots). What is `false` or absent is
//! left out, but `"loops"` of a face: absent for the whole domain, empty for nothing. Numbers are written in their
//! shortest form that reads as the same f64, so that BREPs come back bit for bit.
//!
//! Nothing in a file is trusted: geometry goes through its own constructors and all else through
//! [`Brep::new`].

use feeler::brep::{
    Brep, BrepParts, Edge, Face, Iso, LoopKind, TrimCurve, TrimKind, TrimLoop, Vertex,
};
use feeler::numeric::Interval;
use feeler::nurbs::{
    Arc, Curve, GeometryError, Line, NurbsCurve, NurbsSurface, Plane, PolyCurve, Polyline,
    Revolution, Sum, Surface,
};
use nalgebra::{Point, SVector, Vector4};
use serde::{Deserialize, Serialize};

/// The version of the format that is written, and the only one that is read.
pub const MODEL_FILE_VERSION: u32 = 1;

/// What is wrong with a model file: where, and why.
#[derive(Debug)]
pub(crate) struct Problem {
    pub(crate) place: String,
    pub(crate) reason: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileText {
    feeler_model: u32,
    /// Of lengths; for readers, it changes nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    unit: Option<String>,
    breps: Vec<BrepText>,
}

/// What every version begins with.
#[derive(Deserialize)]
struct VersionText {
    feeler_model: u32,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BrepText {
    surfaces: Vec<SurfaceText>,
    curves2: Vec<CurveText>,
    curves3: Vec<CurveText>,
    vertices: Vec<VertexText>,
    edges: Vec<EdgeText>,
    trims: Vec<TrimText>,
    loops: Vec<LoopText>,
    faces: Vec<FaceText>,
}

type Ends = [f64; 2];

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum SurfaceText {
    Plane {
        origin: [f64; 3],
        x: [f64; 3],
        y: [f64; 3],
        domain: [Ends; 2],
        extents: [Ends; 2],
    },
    Revolution {
        origin: [f64; 3],
        axis: [f64; 3],
        angle: Ends,
        angle_domain: Ends,
        profile: CurveText,
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        transposed: bool,
    },
    Sum {
        base: [f64; 3],
        first: CurveText,
        second: CurveText,
    },
    Nurbs {
        degrees: [usize; 2],
        knots: [Vec<f64>; 2],
        points: Vec<f64>,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum CurveText {
    Line {
        from: Vec<f64>,
        to: Vec<f64>,
        domain: Ends,
    },
    Arc {
        center: Vec<f64>,
        x: Vec<f64>,
        y: Vec<f64>,
        z: Vec<f64>,
        radius: f64,
        angle: Ends,
        domain: Ends,
    },
    Polyline {
        points: Vec<f64>,
        params: Vec<f64>,
    },
    Nurbs {
        degree: usize,
        knots: Vec<f64>,
        points: Vec<f64>,
    },
    Poly {
        segments: Vec<CurveText>,
        params: Vec<f64>,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct VertexText {
    point: [f64; 3],
    edges: Vec<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    tolerance: Option<f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct EdgeText {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    curve: Option<usize>,
    span: Ends,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    reversed: bool,
    vertices: [usize; 2],
    trims: Vec<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    tolerance: Option<f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TrimText {
    curve: usize,
    span: Ends,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    reversed: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    edge: Option<usize>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    edge_reversed: bool,
    vertices: [usize; 2],
    kind: TrimKindText,
    iso: IsoText,
    #[serde(rename = "loop")]
    trim_loop: usize,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LoopText {
    kind: LoopKindText,
    trims: Vec<usize>,
    face: usize,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FaceText {
    surface: usize,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    reversed: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    loops: Option<Vec<usize>>,
}

/// The words of a kind, both ways.
macro_rules! words {
    ($text:ident, $kind:ident, $($variant:ident),*) => {
        #[derive(Clone, Copy, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        enum $text { $($variant),* }

        impl From<$text> for $kind {
            fn from(t: $text) -> Self {
                match t { $($text::$variant => Self::$variant),* }
            }
        }

        impl From<$kind> for $text {
            fn from(k: $kind) -> Self {
                match k { $($kind::$variant => Self::$variant),* }
            }
        }
    };
}

words!(
    TrimKindText,
    TrimKind,
    Unknown,
    Boundary,
    Mated,
    Seam,
    Singular
);
words!(IsoText, Iso, None, U, V, West, South, East, North);
words!(LoopKindText, LoopKind, Unknown, Outer, Inner, Slit);

fn interval([start, end]: Ends) -> Interval {
    Interval { start, end }
}

fn ends(i: Interval) -> Ends {
    [i.start, i.end]
}

/// The text of a model file.
pub(crate) fn to_text(breps: &[Brep], unit: Option<&str>) -> String {
    let file = FileText {
        feeler_model: MODEL_FILE_VERSION,
        unit: unit.map(str::to_owned),
        breps: breps.iter().map(|b| brep_text(b.parts())).collect(),
    };
    serde_json::to_string(&file).unwrap_or_default() + "\n"
}

fn brep_text(p: &BrepParts) -> BrepText {
    BrepText {
        surfaces: p.surfaces.iter().map(surface_text).collect(),
        curves2: p.curves2.iter().map(curve_text).collect(),
        curves3: p.curves3.iter().map(curve_text).collect(),
        vertices: p
            .vertices
            .iter()
            .map(|v| VertexText {
                point: v.point.coords.into(),
                edges: v.edges.clone(),
                tolerance: v.tolerance,
            })
            .collect(),
        edges: p
            .edges
            .iter()
            .map(|e| EdgeText {
                curve: e.curve,
                span: ends(e.span),
                reversed: e.reversed,
                vertices: e.vertices,
                trims: e.trims.clone(),
                tolerance: e.tolerance,
            })
            .collect(),
        trims: p
            .trims
            .iter()
            .map(|t| TrimText {
                curve: t.curve,
                span: ends(t.span),
                reversed: t.reversed,
                edge: t.edge,
                edge_reversed: t.edge_reversed,
                vertices: t.vertices,
                kind: t.kind.into(),
                iso: t.iso.into(),
                trim_loop: t.trim_loop,
            })
            .collect(),
        loops: p
            .loops
            .iter()
            .map(|l| LoopText {
                kind: l.kind.into(),
                trims: l.trims.clone(),
                face: l.face,
            })
            .collect(),
        faces: p
            .faces
            .iter()
            .map(|f| FaceText {
                surface: f.surface,
                reversed: f.reversed,
                loops: f.loops.clone(),
            })
            .collect(),
    }
}

fn flat<'a, const N: usize>(points: impl IntoIterator<Item = &'a SVector<f64, N>>) -> Vec<f64> {
    points.into_iter().flat_map(|p| p.iter().copied()).collect()
}

fn surface_text(surface: &Surface) -> SurfaceText {
    match surface {
        Surface::Plane(s) => SurfaceText::Plane {
            origin: s.origin.coords.into(),
            x: s.x.into(),
            y: s.y.into(),
            domain: s.domain.map(ends),
            extents: s.extents.map(ends),
        },
        Surface::Revolution(s) => SurfaceText::Revolution {
            origin: s.origin.coords.into(),
            axis: s.axis.into(),
            angle: ends(s.angle),
            angle_domain: ends(s.angle_domain),
            profile: curve_text(&s.profile),
            transposed: s.transposed,
        },
        Surface::Sum(s) => SurfaceText::Sum {
            base: s.base.into(),
            first: curve_text(&s.first),
            second: curve_text(&s.second),
        },
        Surface::Nurbs(s) => SurfaceText::Nurbs {
            degrees: [s.knots_u().degree(), s.knots_v().degree()],
            knots: [s.knots_u().knots().to_vec(), s.knots_v().knots().to_vec()],
            points: flat(s.control_net()),
        },
    }
}

fn curve_text<const D: usize, const H: usize>(curve: &Curve<D, H>) -> CurveText {
    match curve {
        Curve::Line(c) => CurveText::Line {
            from: flat([&c.from.coords]),
            to: flat([&c.to.coords]),
            domain: ends(c.domain),
        },
        Curve::Arc(c) => CurveText::Arc {
            center: flat([&c.center.coords]),
            x: flat([&c.x]),
            y: flat([&c.y]),
            z: flat([&c.z]),
            radius: c.radius,
            angle: ends(c.angle),
            domain: ends(c.domain),
        },
        Curve::Polyline(c) => CurveText::Polyline {
            points: flat(c.points().iter().map(|p| &p.coords)),
            params: c.params().to_vec(),
        },
        Curve::Nurbs(c) => CurveText::Nurbs {
            degree: c.degree(),
            knots: c.knots().knots().to_vec(),
            points: flat(c.control_points()),
        },
        // Segments are never poly-curves themselves: one level deep.
        Curve::Poly(c) => CurveText::Poly {
            segments: c.segments().iter().map(curve_text).collect(),
            params: c.params().to_vec(),
        },
    }
}

/// The BREPs of a model file's text.
pub(crate) fn from_text(text: &str) -> Result<Vec<Brep>, Problem> {
    let whole = |reason: String| Problem {
        place: "the file as a whole".to_owned(),
        reason,
    };
    let version = |v: u32| {
        whole(format!(
            "format version {v}, where this program reads {MODEL_FILE_VERSION}"
        ))
    };
    let file: FileText = match serde_json::from_str(text) {
        Ok(file) => file,
        Err(error) => {
            // A later version may have other fields: say that, not which field is unknown.
            return Err(match serde_json::from_str::<VersionText>(text) {
                Ok(v) if v.feeler_model != MODEL_FILE_VERSION => version(v.feeler_model),
                _ => Problem {
                    place: format!("line {} column {}", error.line(), error.column()),
                    reason: match error.to_string().rsplit_once(" at line ") {
                        Some((what, _)) => what.to_owned(),
                        None => error.to_string(),
                    },
                },
            });
        }
    };
    if file.feeler_model != MODEL_FILE_VERSION {
        return Err(version(file.feeler_model));
    }
    if file.breps.is_empty() {
        return Err(whole("it holds no BREP".to_owned()));
    }
    let breps = file.breps.into_iter().enumerate();
    breps.map(|(i, b)| brep(i, b)).collect()
}

/// Which part of which BREP, where it cannot be built.
fn at<T, U>(
    brep: usize,
    what: &str,
    all: Vec<T>,
    make: impl Fn(T) -> Result<U, String>,
) -> Result<Vec<U>, Problem> {
    let one = |(i, t)| {
        make(t).map_err(|reason| Problem {
            place: format!("brep {brep}, {what} {i}"),
            reason,
        })
    };
    all.into_iter().enumerate().map(one).collect()
}

fn brep(number: usize, text: BrepText) -> Result<Brep, Problem> {
    let parts = BrepParts {
        surfaces: at(number, "surfaces", text.surfaces, surface)?,
        curves2: at(number, "curves2", text.curves2, curve)?,
        curves3: at(number, "curves3", text.curves3, curve)?,
        vertices: text
            .vertices
            .into_iter()
            .map(|v| Vertex {
                point: v.point.into(),
                edges: v.edges,
                tolerance: v.tolerance,
            })
            .collect(),
        edges: text
            .edges
            .into_iter()
            .map(|e| Edge {
                curve: e.curve,
                span: interval(e.span),
                reversed: e.reversed,
                vertices: e.vertices,
                trims: e.trims,
                tolerance: e.tolerance,
            })
            .collect(),
        trims: text
            .trims
            .into_iter()
            .map(|t| TrimCurve {
                curve: t.curve,
                span: interval(t.span),
                reversed: t.reversed,
                edge: t.edge,
                edge_reversed: t.edge_reversed,
                vertices: t.vertices,
                kind: t.kind.into(),
                iso: t.iso.into(),
                trim_loop: t.trim_loop,
            })
            .collect(),
        loops: text
            .loops
            .into_iter()
            .map(|l| TrimLoop {
                kind: l.kind.into(),
                trims: l.trims,
                face: l.face,
            })
            .collect(),
        faces: text
            .faces
            .into_iter()
            .map(|f| Face {
                surface: f.surface,
                loops: f.loops,
                reversed: f.reversed,
            })
            .collect(),
    };
    Brep::new(parts).map_err(|e| Problem {
        place: format!("brep {number}"),
        reason: e.to_string(),
    })
}

fn geometry(e: GeometryError) -> String {
    e.to_string()
}

/// Numbers in groups of `N`.
fn groups<const N: usize>(what: &str, numbers: &[f64]) -> Result<Vec<SVector<f64, N>>, String> {
    if numbers.len().is_multiple_of(N) {
        let all = numbers.chunks_exact(N);
        Ok(all.map(SVector::from_column_slice).collect())
    } else {
        let n = numbers.len();
        Err(format!("{what} has {n} numbers, no multiple of {N}"))
    }
}

fn one<const N: usize>(what: &str, numbers: &[f64]) -> Result<SVector<f64, N>, String> {
    match groups(what, numbers)?.as_slice() {
        [one] => Ok(*one),
        _ => Err(format!("{what} has {} numbers, not {N}", numbers.len())),
    }
}

fn surface(text: SurfaceText) -> Result<Surface, String> {
    Ok(match text {
        SurfaceText::Plane {
            origin,
            x,
            y,
            domain,
            extents,
        } => {
            let plane = Plane {
                origin: origin.into(),
                x: x.into(),
                y: y.into(),
                domain: domain.map(interval),
                extents: extents.map(interval),
            };
            Surface::Plane(Plane::new(plane).map_err(geometry)?)
        }
        SurfaceText::Revolution {
            origin,
            axis,
            angle,
            angle_domain,
            profile,
            transposed,
        } => {
            let revolution = Revolution {
                origin: origin.into(),
                axis: axis.into(),
                angle: interval(angle),
                angle_domain: interval(angle_domain),
                profile: curve(profile)?,
                transposed,
            };
            Surface::Revolution(Revolution::new(revolution).map_err(geometry)?)
        }
        SurfaceText::Sum {
            base,
            first,
            second,
        } => Surface::Sum(Sum {
            base: base.into(),
            first: curve(first)?,
            second: curve(second)?,
        }),
        SurfaceText::Nurbs {
            degrees,
            knots,
            points,
        } => {
            let count = |k: usize| {
                let order = degrees[k].saturating_add(1);
                knots[k].len().checked_sub(order).ok_or_else(|| {
                    let n = knots[k].len();
                    format!("{n} knots are too few for degree {}", degrees[k])
                })
            };
            let counts = [count(0)?, count(1)?];
            let net: Vec<Vector4<f64>> = groups("a net", &points)?;
            let made = NurbsSurface::new(degrees, counts, net, knots);
            Surface::Nurbs(made.map_err(geometry)?)
        }
    })
}

/// Recursion: as deep as the JSON, which serde_json keeps below 128.
fn curve<const D: usize, const H: usize>(text: CurveText) -> Result<Curve<D, H>, String> {
    Ok(match text {
        CurveText::Line { from, to, domain } => {
            let point = |p: &[f64]| one("an end point", p).map(Point::from);
            let line = Line::new(point(&from)?, point(&to)?, interval(domain));
            Curve::Line(line.map_err(geometry)?)
        }
        CurveText::Arc {
            center,
            x,
            y,
            z,
            radius,
            angle,
            domain,
        } => {
            let arc = Arc {
                center: Point::from(one("a centre", &center)?),
                x: one("an axis", &x)?,
                y: one("an axis", &y)?,
                z: one("an axis", &z)?,
                radius,
                angle: interval(angle),
                domain: interval(domain),
            };
            Curve::Arc(Arc::new(arc).map_err(geometry)?)
        }
        CurveText::Polyline { points, params } => {
            let all = groups("a polyline", &points)?;
            let all = all.into_iter().map(Point::from).collect();
            Curve::Polyline(Polyline::new(all, params).map_err(geometry)?)
        }
        CurveText::Nurbs {
            degree,
            knots,
            points,
        } => {
            let all = groups("a control polygon", &points)?;
            Curve::Nurbs(NurbsCurve::new(degree, all, knots).map_err(geometry)?)
        }
        CurveText::Poly { segments, params } => {
            let all = segments.into_iter().map(curve).collect::<Result<_, _>>()?;
            Curve::Poly(PolyCurve::new(all, params).map_err(geometry)?)
        }
    })
}

#[cfg(test)]
mod tests;
