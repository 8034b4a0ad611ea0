//! Extrusions: a profile in a plane, moved along a straight path, its ends cut by planes.
//!
//! The profile is one curve in uv, or an outer one and holes. A point `(x, y)` of it stands at the start of the path `P` at
//! `P + x X + y U + z T`, with `T` along the path, `U` the stored up direction, `X = U x T` and `z = 0`, or, where that end is mitred
//! with the normal `N` (given in the frame `X, U, T`), the `z` with `N . (x, y, z) = 0`; likewise at the path's end. Wherever that is a
//! plane or a cylinder the BREP has one:
//!
//! | part | surface | trims |
//! |---|---|---|
//! | straight piece of the profile | the plane through it along the path | four straight ones |
//! | arc, no mitre | the cylinder, as a revolution | four straight ones |
//! | anything else | ruled between the two ends, NURBS | four straight ones |
//! | cap | the plane | the profile as stored; of a mitred end its affine image, arcs as NURBS |
//!
//! Poly-curves and polylines give a face for each of their pieces. Directions and points are rounded to some units in the last
//! place of the coordinates.

use super::archive::{ANONYMOUS, Chunk};
use super::class::{self, Class};
use super::curves::{REMEDY, curve_of, geometry, poly_segments};
use crate::affine::image;
use crate::error::{Problem, ReadError};
use crate::sheets::{kinds, plane_domain};
use feeler::brep::{
    Brep, BrepParts, Edge, Face, Iso, LoopKind, TrimCurve, TrimKind, TrimLoop, Vertex,
};
use feeler::numeric::Interval;
use feeler::nurbs::{
    Curve, Curve2, Curve3, GeometryError, Line, NurbsSurface, Plane, Revolution, Surface,
};
use nalgebra::{Point2, Point3, SVector, Vector2, Vector3, Vector4};

/// openNURBS takes a mitre for none whose normal leans more than this (`ON_Extrusion::m_Nz_min`).
const LEAST_NORMAL: f64 = 1.0 / 64.0;

/// Profiles whose ends are no farther apart are closed: openNURBS's `ON_ZERO_TOLERANCE`, ...
const CLOSED: f64 = 1.0 / (1_u64 << 32) as f64;
/// ... or this part of the coordinates: writers keep as few as 12 digits.
const CLOSED_RELATIVE: f64 = 1.0 / (1_u64 << 40) as f64;

/// Samples of a piece of a profile when its turning sense is looked for.
const SAMPLES: u16 = 32;

/// What a file stores.
struct Stored {
    profiles: Vec<Curve2>,
    path: [Point3<f64>; 2],
    used: [f64; 2],
    up: Vector3<f64>,
    /// The normals of mitred ends.
    normals: [Option<Vector3<f64>>; 2],
    domain: Interval,
    caps: [bool; 2],
}

fn read(data: &mut Chunk<'_>) -> Result<Stored, ReadError> {
    let mut d = data.expect(ANONYMOUS, "an extrusion")?;
    let at = d.position();
    let (major, minor) = (
        d.i32("the layout version")?,
        d.i32("the layout's minor version")?,
    );
    if major != 1 {
        return Err(d.fail_at(
            at,
            Problem::Layout {
                class: "Extrusion",
                major: u8::try_from(major).unwrap_or(u8::MAX),
                minor: u8::try_from(minor).unwrap_or(u8::MAX),
                remedy: REMEDY,
            },
        ));
    }
    let (class, profile) = class::object(&mut d)?;
    let role = "the profile of an extrusion";
    // With more than one profile the poly-curve's segments are the profiles; how many there are stands further on.
    let (segments, single) = if class == Class::PolyCurve {
        (Some(poly_segments(profile, role)?), None)
    } else {
        (None, Some(curve_of::<2, 3>(class, profile, role)?))
    };
    let path = [
        Point3::from(d.f64s::<3>("the start of a path")?),
        Point3::from(d.f64s::<3>("the end of a path")?),
    ];
    let used = d.f64s::<2>("the used part of a path")?;
    let up = Vector3::from(d.f64s::<3>("the up direction of an extrusion")?);
    let mitred = [
        d.u8("whether the start is mitred")? != 0,
        d.u8("whether the end is mitred")? != 0,
    ];
    let normals = [
        Vector3::from(d.f64s::<3>("the normal of a mitre")?),
        Vector3::from(d.f64s::<3>("the normal of a mitre")?),
    ];
    let domain = d.interval("the domain of a path")?;
    // Which of the two parameters is the path's: the BREP has its own.
    d.u8("the transposed flag")?;
    let mut count = 1;
    if minor >= 1 {
        count = d.i32("the number of profiles")?;
    }
    let mut caps = [false; 2];
    if minor >= 2 {
        for cap in &mut caps {
            *cap = d.u8("whether an end is capped")? != 0;
        }
    }
    let profiles = match (segments, single) {
        (Some(segments), _) if count > 1 => {
            if usize::try_from(count) != Ok(segments.curves.len()) {
                return Err(d.fail_at(
                    at,
                    Problem::Value {
                        what: "the number of profiles".into(),
                        found: count.to_string(),
                        expected: format!("{}, the poly-curve's segments", segments.curves.len()),
                    },
                ));
            }
            segments.curves
        }
        (Some(segments), _) => vec![geometry(&d, "PolyCurve", segments.join())?],
        (None, single) => single.into_iter().collect(),
    };
    if minor < 2 {
        caps = [profiles.first().is_some_and(is_closed); 2];
    }
    // A mesh for display may follow: left alone.
    d.finish()?;
    let normal = |i: usize| normals[i].try_normalize(0.0).filter(|_| mitred[i]);
    Ok(Stored {
        normals: [normal(0), normal(1)],
        profiles,
        path,
        used,
        up,
        domain,
        caps,
    })
}

type Axes<const D: usize> = [SVector<f64, D>; 2];

/// One end of the path.
struct End {
    origin: Point3<f64>,
    /// Where the profile's axes go; leaning, where the end is mitred.
    axes: [Vector3<f64>; 2],
    /// `z` along the path, in lengths of the path, is `slope . (x, y)`.
    slope: Vector2<f64>,
}

impl End {
    fn new(origin: Point3<f64>, frame: &Frame, length: f64, normal: Option<Vector3<f64>>) -> Self {
        let mut slope = Vector2::zeros();
        if let Some(n) = normal
            && n.z > LEAST_NORMAL
        {
            slope = Vector2::new(-n.x / n.z, -n.y / n.z);
        }
        Self {
            origin,
            axes: [
                frame.x + frame.along * slope.x,
                frame.up + frame.along * slope.y,
            ],
            slope: slope / length,
        }
    }

    fn is_mitred(&self) -> bool {
        self.slope != Vector2::zeros()
    }

    /// The direction about which the profile's arcs turn; `None` where they become ellipses.
    fn normal(&self) -> Option<Vector3<f64>> {
        (!self.is_mitred()).then(|| self.axes[0].cross(&self.axes[1]))
    }

    /// Orthonormal axes of the end's plane, and the profile's axes in them.
    fn plane(&self) -> Option<(Axes<3>, Axes<2>)> {
        let [a, b] = self.axes;
        if !self.is_mitred() {
            return Some((self.axes, [Vector2::x(), Vector2::y()]));
        }
        let x = a.try_normalize(0.0)?;
        let y = a.cross(&b).cross(&a).try_normalize(0.0)?;
        let inner = |v: Vector3<f64>| Vector2::new(v.dot(&x), v.dot(&y));
        Some(([x, y], [inner(a), inner(b)]))
    }

    fn point(&self, p: Point2<f64>) -> Point3<f64> {
        self.origin + self.axes[0] * p.x + self.axes[1] * p.y
    }
}

/// Unit directions.
struct Frame {
    x: Vector3<f64>,
    up: Vector3<f64>,
    along: Vector3<f64>,
}

fn ends(curve: &Curve2) -> [Point2<f64>; 2] {
    let domain = curve.domain();
    [curve.point(domain.start), curve.point(domain.end)]
}

fn meet(a: Point2<f64>, b: Point2<f64>) -> bool {
    let size = a.coords.amax().max(b.coords.amax());
    (b - a).amax() <= CLOSED.max(CLOSED_RELATIVE * size)
}

fn is_closed(curve: &Curve2) -> bool {
    let [a, b] = ends(curve);
    meet(a, b)
}

/// The pieces that become faces: no poly-curves, no polylines.
fn pieces(profile: Curve2) -> Result<Vec<Curve2>, GeometryError> {
    let mut all = Vec::new();
    let mut open = vec![profile];
    // Segments are never poly-curves themselves: this ends.
    while let Some(next) = open.pop() {
        match next {
            Curve::Poly(poly) => open.extend(poly.segments().iter().rev().cloned()),
            Curve::Polyline(line) => {
                let params = line.params().windows(2);
                for (p, t) in line.points().windows(2).zip(params) {
                    let domain = Interval {
                        start: t[0],
                        end: t[1],
                    };
                    all.push(Curve::Line(Line::new(p[0], p[1], domain)?));
                }
            }
            piece => all.push(piece),
        }
    }
    // Of a point there is no wall.
    all.retain(|piece| !matches!(piece, Curve::Line(l) if l.from == l.to));
    Ok(all)
}

/// Twice the signed area of the polygon through points of the pieces: its sign says which way they run.
fn turning(pieces: &[Curve2]) -> f64 {
    let points = pieces.iter().flat_map(|c| {
        let domain = c.domain();
        (0..SAMPLES).map(move |k| c.point(domain.lerp(f64::from(k) / f64::from(SAMPLES))))
    });
    let points: Vec<Point2<f64>> = points.collect();
    let Some(first) = points.first() else {
        return 0.0;
    };
    let next = points.iter().skip(1).chain([first]);
    let area = |(a, b): (&Point2<f64>, &Point2<f64>)| {
        let (a, b) = (a - first, b - first);
        a.x * b.y - a.y * b.x
    };
    points.iter().zip(next).map(area).sum()
}

/// An extrusion as a BREP, and what was odd about it.
///
/// # Errors
/// A path of no length, an up direction along the path, profiles or results that the kernel refuses.
pub(super) fn extrusion(mut data: Chunk<'_>) -> Result<(Brep, Vec<String>), ReadError> {
    let stored = read(&mut data)?;
    let at = data.id.offset;
    let mut warnings =
        vec!["an extrusion as a BREP: points and directions of its faces are rounded".to_owned()];
    let bad = |what: &str, found: String, expected: &str| {
        let problem = Problem::Value {
            what: what.into(),
            found,
            expected: expected.into(),
        };
        data.fail_at(at, problem)
    };
    let at_path = |s: f64| stored.path[0] + (stored.path[1] - stored.path[0]) * s;
    let [start, end] = stored.used.map(at_path);
    let path = end - start;
    let along = (stored.path[1] - stored.path[0]).try_normalize(0.0);
    let (Some(along), true) = (along, stored.used[0] < stored.used[1]) else {
        let found = format!("{:?} of {:?}", stored.used, stored.path);
        return Err(bad("the path of an extrusion", found, "a length above 0"));
    };
    let up = stored.up.try_normalize(0.0);
    let x = up.and_then(|up| up.cross(&along).try_normalize(0.0));
    let (Some(up), Some(x)) = (up, x) else {
        let found = format!("{:?}", stored.up.as_slice());
        return Err(bad(
            "the up direction of an extrusion",
            found,
            "one across the path",
        ));
    };
    let length = path.norm();
    if !(length > 0.0 && length.is_finite()) {
        return Err(bad(
            "the length of an extrusion",
            format!("{length:?}"),
            "one above 0",
        ));
    }
    let frame = Frame { x, up, along };
    let [n0, n1] = stored.normals;
    let ends = [
        End::new(start, &frame, length, n0),
        End::new(end, &frame, length, n1),
    ];
    let count = stored.profiles.len();
    let mut body = Body {
        parts: BrepParts::default(),
        frame,
        ends,
        path,
        domain: stored.domain,
    };
    let mut caps = stored.caps;
    let mut rims = Vec::with_capacity(count);
    for (i, profile) in stored.profiles.into_iter().enumerate() {
        let closed = is_closed(&profile);
        let all = geometry(&data, "Extrusion", pieces(profile))?;
        // As openNURBS has it: no caps unless the outer profile runs to the left and the others to the right.
        let turning = turning(&all);
        if caps != [false; 2] && (!closed || (i == 0) != (turning > 0.0) || turning == 0.0) {
            caps = [false; 2];
            warnings.push(format!(
                "profile {i} is not closed or runs the wrong way round: the ends are left open"
            ));
        }
        rims.push(geometry(&data, "Extrusion", body.walls(all, closed))?);
    }
    for (which, is_capped) in caps.into_iter().enumerate() {
        if is_capped {
            geometry(&data, "Extrusion", body.cap(which, &rims))?;
        }
    }
    kinds(&mut body.parts);
    let brep = Brep::new(body.parts).map_err(|e| data.fail_at(at, Problem::Brep(e)))?;
    data.finish()?;
    Ok((brep, warnings))
}

/// A piece of a profile and the edges it became: at the path's start and at its end.
struct Rim {
    curve: Curve2,
    edges: [usize; 2],
    /// The vertices at either end: those of the piece's start, those of its end.
    vertices: [[usize; 2]; 2],
}

/// A BREP in the making.
struct Body {
    parts: BrepParts,
    frame: Frame,
    ends: [End; 2],
    /// From the path's start to its end.
    path: Vector3<f64>,
    domain: Interval,
}

const UNIT: Interval = Interval {
    start: 0.0,
    end: 1.0,
};

impl Body {
    fn is_mitred(&self) -> bool {
        self.ends.iter().any(End::is_mitred)
    }

    fn vertex(&mut self, point: Point3<f64>) -> usize {
        self.parts.vertices.push(Vertex {
            point,
            edges: Vec::new(),
            tolerance: Some(0.0),
        });
        self.parts.vertices.len() - 1
    }

    fn edge(&mut self, curve: Curve3, vertices: [usize; 2]) -> usize {
        let edge = self.parts.edges.len();
        self.parts.edges.push(Edge {
            curve: Some(self.parts.curves3.len()),
            span: curve.domain(),
            reversed: false,
            vertices,
            trims: Vec::new(),
            tolerance: Some(0.0),
        });
        self.parts.curves3.push(curve);
        for v in vertices {
            if let Some(vertex) = self.parts.vertices.get_mut(v)
                && vertex.edges.last() != Some(&edge)
            {
                vertex.edges.push(edge);
            }
        }
        edge
    }

    fn trim(
        &mut self,
        curve: Curve2,
        edge: usize,
        edge_reversed: bool,
        domain: [Interval; 2],
    ) -> usize {
        let trim = self.parts.trims.len();
        let mut vertices = [0; 2];
        if let Some(e) = self.parts.edges.get_mut(edge) {
            e.trims.push(trim);
            vertices = e.vertices;
        }
        if edge_reversed {
            vertices.reverse();
        }
        self.parts.trims.push(TrimCurve {
            curve: self.parts.curves2.len(),
            span: curve.domain(),
            reversed: false,
            edge: Some(edge),
            edge_reversed,
            vertices,
            kind: TrimKind::Unknown,
            iso: Iso::of(&curve, domain),
            trim_loop: self.parts.loops.len(),
        });
        self.parts.curves2.push(curve);
        trim
    }

    /// Adds a loop of trims to the face that comes next.
    fn add_loop(&mut self, kind: LoopKind, trims: Vec<usize>) -> usize {
        self.parts.loops.push(TrimLoop {
            kind,
            trims,
            face: self.parts.faces.len(),
        });
        self.parts.loops.len() - 1
    }

    fn face(&mut self, surface: Surface, loops: Vec<usize>, reversed: bool) {
        self.parts.faces.push(Face {
            surface: self.parts.surfaces.len(),
            loops: Some(loops),
            reversed,
        });
        self.parts.surfaces.push(surface);
    }

    /// The faces along the path of one profile.
    fn walls(&mut self, pieces: Vec<Curve2>, closed: bool) -> Result<Vec<Rim>, GeometryError> {
        let mut rims: Vec<Rim> = Vec::with_capacity(pieces.len());
        let count = pieces.len();
        // The joint before the next piece: its vertices and the edge between them.
        let mut joint: Option<([usize; 2], usize)> = None;
        let mut first = None;
        for (i, piece) in pieces.into_iter().enumerate() {
            let [from, to] = ends(&piece);
            let before = match joint {
                Some(joint) => joint,
                None => self.joint(from)?,
            };
            let first = *first.get_or_insert(before);
            let after = if i + 1 == count && closed {
                first
            } else {
                self.joint(to)?
            };
            joint = Some(after);
            let mut edges = [0; 2];
            for (which, edge) in edges.iter_mut().enumerate() {
                let Some(end) = self.ends.get(which) else {
                    continue;
                };
                let curve = image(&piece, end.origin, end.axes, end.normal())?;
                *edge = self.edge(curve, [before.0[which], after.0[which]]);
            }
            let (surface, corners) = self.wall(&piece)?;
            let domain = surface.domain();
            let [a, b, c, d] = corners;
            let line = |p, q| Ok(Curve::Line(Line::new(p, q, UNIT)?));
            let trims = vec![
                self.trim(line(a, b)?, edges[0], false, domain),
                self.trim(line(b, c)?, after.1, false, domain),
                self.trim(line(c, d)?, edges[1], true, domain),
                self.trim(line(d, a)?, before.1, true, domain),
            ];
            let outer = self.add_loop(LoopKind::Outer, trims);
            self.face(surface, vec![outer], false);
            rims.push(Rim {
                curve: piece,
                edges,
                vertices: [before.0, after.0],
            });
        }
        Ok(rims)
    }

    /// The vertices at a point of the profile, and the edge along the path between them.
    fn joint(&mut self, p: Point2<f64>) -> Result<([usize; 2], usize), GeometryError> {
        let [from, to] = [0, 1].map(|i: usize| self.ends[i].point(p));
        let vertices = [self.vertex(from), self.vertex(to)];
        let line = Curve::Line(Line::new(from, to, self.domain)?);
        Ok((vertices, self.edge(line, vertices)))
    }

    /// The surface through a piece along the path, and its corners in uv: counter-clockwise from the piece's start at the path's.
    fn wall(&self, piece: &Curve2) -> Result<(Surface, [Point2<f64>; 4]), GeometryError> {
        let rectangle = |[u, v]: [Interval; 2]| {
            [
                Point2::new(u.start, v.start),
                Point2::new(u.end, v.start),
                Point2::new(u.end, v.end),
                Point2::new(u.start, v.end),
            ]
        };
        let lift = |v: Vector2<f64>| self.frame.x * v.x + self.frame.up * v.y;
        let origin = self.ends[0].origin;
        match piece {
            Curve::Line(line) => {
                let length = self.path.norm();
                let height = |which: usize, p: Point2<f64>| {
                    length * (self.ends[which].slope.dot(&p.coords) + which as f64)
                };
                let (from, to) = (line.from, line.to);
                let across = lift(to - from);
                let width = across.norm();
                let corners = [
                    Point2::new(0.0, height(0, from)),
                    Point2::new(width, height(0, to)),
                    Point2::new(width, height(1, to)),
                    Point2::new(0.0, height(1, from)),
                ];
                let least = corners.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
                let most = corners
                    .iter()
                    .map(|p| p.y)
                    .fold(f64::NEG_INFINITY, f64::max);
                let interval = |start, end| Interval { start, end };
                let domain = [interval(0.0, width), interval(least, most)];
                let plane = Plane::new(Plane {
                    origin: origin + lift(from.coords),
                    x: across / width,
                    y: self.frame.along,
                    domain,
                    extents: domain,
                })?;
                Ok((Surface::Plane(plane), corners))
            }
            Curve::Arc(arc) if !self.is_mitred() => {
                let Some(x) = arc.x.try_normalize(0.0) else {
                    return Err(GeometryError::Degenerate {
                        what: "an arc's frame",
                    });
                };
                let center = origin + lift(arc.center.coords);
                let from = center + lift(x * arc.radius);
                // To the right in the profile's plane is against the path. The axis is the difference of two points, as the
                // format keeps it: rounded no more than the points of the wall are.
                let tip = if arc.x.perp(&arc.y) < 0.0 {
                    center - self.path
                } else {
                    center + self.path
                };
                let profile = Line::new(from, from + self.path, self.domain)?;
                let surface = Surface::Revolution(Revolution::new(Revolution {
                    origin: center,
                    axis: tip - center,
                    angle: arc.angle,
                    angle_domain: arc.domain,
                    profile: Curve::Line(profile),
                    transposed: false,
                })?);
                let corners = rectangle(surface.domain());
                Ok((surface, corners))
            }
            _ => {
                let [a, b] = &self.ends;
                let ruled = |end: &End| -> Result<_, GeometryError> {
                    let curve: Curve3 = image(piece, end.origin, end.axes, None)?;
                    Ok(curve.to_nurbs()?.nurbs)
                };
                let (first, second) = (ruled(a)?, ruled(b)?);
                let rows = first.control_points().iter().zip(second.control_points());
                let net: Vec<Vector4<f64>> = rows.flat_map(|(p, q)| [*p, *q]).collect();
                let count = first.control_points().len();
                let Interval { start, end } = self.domain;
                let knots = [first.knots().knots().to_vec(), vec![start, start, end, end]];
                let surface = NurbsSurface::new([first.degree(), 1], [count, 2], net, knots)?;
                let surface = Surface::Nurbs(surface);
                let corners = rectangle(surface.domain());
                Ok((surface, corners))
            }
        }
    }

    /// The face that closes one end.
    fn cap(&mut self, which: usize, rims: &[Vec<Rim>]) -> Result<(), GeometryError> {
        let flat = GeometryError::Degenerate {
            what: "the profile of an extrusion",
        };
        let end = &self.ends[which];
        let (axes, inner) = end.plane().ok_or(flat.clone())?;
        let mut curves: Vec<Curve2> = Vec::new();
        for rim in rims.iter().flatten() {
            curves.push(if end.is_mitred() {
                image(&rim.curve, Point2::origin(), inner, None)?
            } else {
                rim.curve.clone()
            });
        }
        let domain = plane_domain(curves.iter()).ok_or(flat)?;
        let plane = Plane::new(Plane {
            origin: end.origin,
            x: axes[0],
            y: axes[1],
            domain,
            extents: domain,
        })?;
        let mut curves = curves.into_iter();
        let mut loops = Vec::with_capacity(rims.len());
        for (i, rim) in rims.iter().enumerate() {
            let mut trims = Vec::with_capacity(rim.len());
            for piece in rim {
                let Some(curve) = curves.next() else { continue };
                let trim = self.trim(curve, piece.edges[which], false, domain);
                if let Some(t) = self.parts.trims.get_mut(trim) {
                    t.vertices = piece.vertices.map(|v| v[which]);
                }
                trims.push(trim);
            }
            let kind = if i == 0 {
                LoopKind::Outer
            } else {
                LoopKind::Inner
            };
            loops.push(self.add_loop(kind, trims));
        }
        self.face(Surface::Plane(plane), loops, which == 0);
        Ok(())
    }
}
