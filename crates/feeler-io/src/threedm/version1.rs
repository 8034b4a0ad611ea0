//! Files of version 1: no tables, no classes. Layers, settings and objects follow each other, each a chunk of its own
//! kind; the geometry of an object is in a chunk in a chunk, which ends with a checksum.
//!
//! There are curves (splines in a row), trimmed surfaces and shells of these. A trim that has an edge holds the edge's
//! curve; lists say which trims share one, of a face (seams) and of the shell. All else is [rebuilt](super::rebuild).

use super::archive::Chunk;
use super::attributes::Layer;
use super::brep::finished;
use super::curves::{SplineSize, geometry, widened};
use super::rebuild::{OldBrep, OldFace, OldLoop, OldTrim, parts};
use crate::document::{Document, Format, Object, ObjectKind};
use crate::error::{Problem, ReadError};
use crate::units::Units;
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Curve2, Curve3, Line, NurbsCurve, NurbsSurface, PolyCurve, Surface};
use nalgebra::{Point, SVector};
use std::collections::HashMap;

const END_OF_FILE: u32 = 0x0000_7FFF;
const SHELL: u32 = 0x0001_0003;
const FACE: u32 = 0x0001_0004;
const LOOP: u32 = 0x0001_0005;
const TRIM: u32 = 0x0001_0006;
const SURFACE: u32 = 0x0001_0007;
const CURVE: u32 = 0x0001_0008;
const SPLINE: u32 = 0x0001_0009;
/// What a chunk of geometry holds, beside attributes, is in a chunk of the same typecode with this bit.
const STUFF: u32 = 0x0000_0100;
/// Objects of another toolkit of that time.
const TOOLKIT_CURVE: u32 = 0x0002_0008;
const TOOLKIT_SURFACE: u32 = 0x0002_0009;
const TOOLKIT_BREP: u32 = 0x0002_000B;
const POINT: u32 = 0x0010_0001;
const MESH: u32 = 0x0010_0015;
const TEXT: u32 = 0x0020_0004;
const RADIAL_DIMENSION: u32 = 0x0020_0008;
const LAYER: u32 = 0x0040_0010;
const LAYER_NAME: u32 = 0x0040_0011;
const LAYER_STATE: u32 = 0x8040_0033;
const UNITS: u32 = 0x0200_0010;
const NAME: u32 = 0x0200_0001;
const LAYER_REFERENCE: u32 = 0xA000_0001;
const EXTRA: u32 = 0x4000_0001;
/// Typecodes of settings, and of lights, which later versions keep in a table of their own, have one of these bits: user data,
/// tolerances, interface, lights, display, annotation.
const SETTINGS: u32 = 0x4AE0_0000;
/// Typecodes of tables, which files of version 1 do not have.
const TABLES: u32 = 0x1000_0000;
const TABLE_MASK: u32 = 0xFFFF_0000;

/// The fewest bytes of a loop, a trim and a spline: the headers of two chunks and their fields.
const MIN_LOOP: usize = 16 + 40 + 2;
const MIN_TRIM: usize = 16 + 29 + 2;
const MIN_SPLINE: usize = 16 + 7 + 2;
const MIN_FACE: usize = 16 + 64 + 2;

/// Whether what follows the header is a later version's: some files have the older header by mistake.
pub(super) fn has_tables(mut file: Chunk<'_>) -> bool {
    while let Ok(chunk) = file.child() {
        if chunk.id.typecode & TABLE_MASK == TABLES {
            return true;
        }
    }
    false
}

/// The file's layers, in its order and by their names.
#[derive(Default)]
struct Layers {
    all: Vec<Layer>,
    by_name: HashMap<String, usize>,
}

impl Layers {
    fn add(&mut self, layer: Layer) {
        let index = self.all.len();
        self.by_name.entry(layer.name.clone()).or_insert(index);
        self.all.push(layer);
    }
}

/// Reads what follows the header.
pub(super) fn read(mut file: Chunk<'_>) -> Result<Document, ReadError> {
    let mut document = Document {
        format: Format::Rhino,
        version: 1,
        opennurbs_version: 0,
        units: Units::None,
        tolerance: None,
        objects: Vec::new(),
        blocks: Vec::new(),
        warnings: Vec::new(),
    };
    let mut layers = Layers::default();
    // What the file says of itself.
    file.child()?;
    while file.left() > 0 {
        let mut chunk = file.child()?;
        let id = chunk.id;
        let kind = match id.typecode {
            END_OF_FILE => break,
            UNITS => {
                (document.units, document.tolerance) = units(&mut chunk)?;
                continue;
            }
            LAYER => {
                let read = layer(&mut chunk);
                layers.add(read.unwrap_or_else(|reason| {
                    let warning = format!("a layer could not be read: {reason}");
                    document.warnings.push(warning);
                    Layer::default()
                }));
                continue;
            }
            SHELL | FACE | CURVE => {
                document.objects.push(object(chunk, &layers));
                continue;
            }
            TOOLKIT_CURVE | TOOLKIT_SURFACE | TOOLKIT_BREP => ObjectKind::Refused {
                class: match id.typecode {
                    TOOLKIT_CURVE => "curve".into(),
                    TOOLKIT_SURFACE => "surface".into(),
                    _ => "Brep".into(),
                },
                reason: chunk.fail_at(
                    id.offset,
                    Problem::Class {
                        class: "geometry of the RhinoIO toolkit (version 1)".into(),
                        role: "an object",
                        remedy: "open the file in Rhino or with rhino3dm and save it as version 5 to 8",
                    },
                ),
            },
            POINT => ObjectKind::Other("point".into()),
            MESH => ObjectKind::Mesh,
            TEXT..=RADIAL_DIMENSION => ObjectKind::Other("annotation".into()),
            code if code & SETTINGS != 0 => continue,
            _ => {
                document.warnings.push(format!("skipped an unknown {id}"));
                continue;
            }
        };
        let mut other = Object::new(id.offset, ObjectKind::Other("object".into()));
        other.kind = kind;
        // Names and layers stand among what is not read.
        document.objects.push(other);
    }
    if document.objects.is_empty() {
        let warning = "the file holds no objects: it is damaged, or holds no model";
        document.warnings.push(warning.into());
    }
    Ok(document)
}

fn units(d: &mut Chunk<'_>) -> Result<(Units, Option<f64>), ReadError> {
    d.i32("the layout version")?;
    let units = Units::from_code(d.i32("the unit")?);
    Ok((units, d.optional_f64("the absolute tolerance")?))
}

fn layer(d: &mut Chunk<'_>) -> Result<Layer, ReadError> {
    let mut layer = Layer::default();
    while d.left() > 0 {
        let mut field = d.child()?;
        match field.id.typecode {
            LAYER_NAME => layer.name = field.narrow_string("a layer's name")?,
            LAYER_STATE => {
                layer.hidden = field.value == 1;
                layer.locked = field.value == 2;
            }
            _ => {}
        }
    }
    Ok(layer)
}

fn object(mut chunk: Chunk<'_>, layers: &Layers) -> Object {
    let mut object = Object::new(chunk.id.offset, ObjectKind::Other("object".into()));
    if let Err(reason) = record(&mut chunk, layers, &mut object) {
        object.kind = ObjectKind::Refused {
            class: if chunk.id.typecode == CURVE {
                "curve".into()
            } else {
                "Brep".into()
            },
            reason,
        };
    }
    object
}

fn record(chunk: &mut Chunk<'_>, layers: &Layers, object: &mut Object) -> Result<(), ReadError> {
    let stuff = chunk.id.typecode | STUFF;
    let mut layer = None;
    // Hidden and locked objects are on a layer of their own; their true one stands beside.
    let mut true_layer = None;
    loop {
        let mut child = next(chunk, "an object's geometry")?;
        match child.id.typecode {
            LAYER_REFERENCE => layer = usize::try_from(child.value).ok(),
            NAME => object.name = child.narrow_string("an object's name")?,
            EXTRA => {
                if let Some((hides, name)) = extra(&mut child)? {
                    object.hidden |= hides;
                    object.locked |= !hides;
                    true_layer = layers.by_name.get(&name).copied();
                }
            }
            code if code == stuff => {
                object.kind = kind(child, &mut object.warnings)?;
                break;
            }
            _ => {}
        }
    }
    if let Some(layer) = true_layer.or(layer).and_then(|i| layers.all.get(i)) {
        object.layer = Some(layer.name.clone());
        object.hidden |= layer.hidden;
        object.locked |= layer.locked;
    }
    Ok(())
}

/// Of data beside an object: whether it says that the object is hidden (or else locked), and its layer's name.
fn extra(d: &mut Chunk<'_>) -> Result<Option<(bool, String)>, ReadError> {
    let sizes = [d.count("bytes of a name", 1)?, d.count("bytes of data", 1)?];
    let mut texts = sizes.map(|size| (size, String::new()));
    for (size, text) in &mut texts {
        for _ in 0..*size {
            text.push(char::from(d.u8("data beside an object")?));
        }
        text.truncate(text.trim_end_matches('\0').len());
    }
    let [(_, what), (_, data)] = texts;
    Ok(match what.to_ascii_lowercase().as_str() {
        "rhhideprevlayer" => Some((true, data)),
        "rhfreezeprevlayer" => Some((false, data)),
        _ => None,
    })
}

fn kind(mut stuff: Chunk<'_>, warnings: &mut Vec<String>) -> Result<ObjectKind, ReadError> {
    let code = stuff.id.typecode & !STUFF;
    if code == CURVE {
        let curve: Curve3 = curve(&mut stuff)?;
        stuff.finish()?;
        return Ok(ObjectKind::Curve(curve));
    }
    let mut old = OldBrep::default();
    if code == FACE {
        // What it shares with others is nobody's here.
        face(&mut stuff, &mut old)?;
    } else {
        shell(&mut stuff, &mut old)?;
    }
    let (brep, found) = finished(parts(old), stuff)?;
    warnings.extend(found);
    Ok(ObjectKind::Brep(brep))
}

fn bad(d: &Chunk<'_>, at: usize, what: String, found: String, expected: &str) -> ReadError {
    d.fail_at(
        at,
        Problem::Value {
            what,
            found,
            expected: expected.into(),
        },
    )
}

/// The next chunk in `parent`, which must hold one more: `what` is looked for.
fn next<'a>(parent: &mut Chunk<'a>, what: &str) -> Result<Chunk<'a>, ReadError> {
    if parent.left() == 0 {
        let at = parent.position();
        return Err(bad(parent, at, what.into(), "missing".into(), "one"));
    }
    parent.child()
}

/// The first chunk of this kind that is still to come in `parent`.
fn find<'a>(parent: &mut Chunk<'a>, typecode: u32, what: &str) -> Result<Chunk<'a>, ReadError> {
    loop {
        let child = next(parent, what)?;
        if child.id.typecode == typecode {
            return Ok(child);
        }
    }
}

/// Calls `read` with the inner chunk of the next one of this kind, and checks that one.
fn inner<'a, T>(
    parent: &mut Chunk<'a>,
    typecode: u32,
    what: &str,
    read: impl FnOnce(&mut Chunk<'a>) -> Result<T, ReadError>,
) -> Result<T, ReadError> {
    let mut outer = find(parent, typecode, what)?;
    let mut stuff = find(&mut outer, typecode | STUFF, what)?;
    let result = read(&mut stuff)?;
    stuff.finish()?;
    Ok(result)
}

/// The dimension, a byte, which must be `D`.
fn dimension<const D: usize>(d: &mut Chunk<'_>) -> Result<(), ReadError> {
    let at = d.position();
    let found = d.u8("the dimension")?;
    if usize::from(found) == D {
        return Ok(());
    }
    Err(bad(
        d,
        at,
        "the dimension".into(),
        found.to_string(),
        &D.to_string(),
    ))
}

/// A box of `D` coordinates: of no use.
fn skip_box<const D: usize>(d: &mut Chunk<'_>) -> Result<(), ReadError> {
    d.skip(2 * D * size_of::<f64>(), "a box")
}

/// A control point; stored with its weight it is that of the point itself, which is rounded as it becomes homogeneous.
fn control_point<const H: usize>(
    d: &mut Chunk<'_>,
    rational: bool,
    homogeneous: bool,
) -> Result<SVector<f64, H>, ReadError> {
    let mut p = super::curves::control_point::<H>(d, rational)?;
    if rational && !homogeneous {
        let weight = p[H - 1];
        p.iter_mut().take(H - 1).for_each(|x| *x *= weight);
    }
    Ok(p)
}

fn spline<const D: usize, const H: usize>(d: &mut Chunk<'_>) -> Result<Curve<D, H>, ReadError> {
    dimension::<D>(d)?;
    let rational = d.u8("the rational flag")? != 0;
    let at = d.position();
    let order = i32::from(d.u8("the order")?);
    let count = i32::from(d.u16("the number of control points")?);
    let size = SplineSize::new(d, at, order, count, D * size_of::<f64>())?;
    d.skip(2, "flags")?;
    skip_box::<D>(d)?;
    let knots = knots(d, &size)?;
    let mut points = Vec::with_capacity(size.count);
    for _ in 0..size.count {
        // Files say of homogeneous points what they say of others.
        points.push(control_point::<H>(d, rational, false)?);
    }
    if let ([from, to], false, [_, start, end, _]) = (&points[..], rational, &knots[..]) {
        let at =
            |p: &SVector<f64, H>| Point::from(SVector::from_iterator(p.iter().take(D).copied()));
        let domain = Interval {
            start: *start,
            end: *end,
        };
        return geometry(d, "line", Line::new(at(from), at(to), domain)).map(Curve::Line);
    }
    let curve = NurbsCurve::new(size.degree, points, knots);
    geometry(d, "spline", curve).map(Curve::Nurbs)
}

/// Knots, of which those that are equal at an end stand there once where a flag says so.
fn knots(d: &mut Chunk<'_>, size: &SplineSize) -> Result<Vec<f64>, ReadError> {
    let degree = size.degree;
    let total = size.count.saturating_add(degree).saturating_sub(1);
    let clamped = if degree > 1 {
        d.u8("which ends are clamped")?
    } else {
        0
    };
    let what = "a knot";
    let mut knots = Vec::with_capacity(total);
    let first = d.f64(what)?;
    knots.resize(if clamped & 1 == 1 { degree } else { 1 }, first);
    while knots.len() < size.count {
        knots.push(d.f64(what)?);
    }
    let last = *knots.last().unwrap_or(&first);
    if clamped >= 2 {
        knots.resize(total, last);
    }
    while knots.len() < total {
        knots.push(d.f64(what)?);
    }
    Ok(widened(&knots))
}

fn curve<const D: usize, const H: usize>(d: &mut Chunk<'_>) -> Result<Curve<D, H>, ReadError> {
    dimension::<D>(d)?;
    d.u8("whether a curve is closed")?;
    let at = d.position();
    let count = i64::from(d.u16("the number of segments")?);
    let count = d.check_count(at, "segments", count, MIN_SPLINE)?;
    skip_box::<D>(d)?;
    let mut segments: Vec<Curve<D, H>> = Vec::with_capacity(count);
    for _ in 0..count {
        segments.push(inner(d, SPLINE, "a spline", spline)?);
    }
    if segments.len() == 1
        && let Some(only) = segments.pop()
    {
        return Ok(only);
    }
    // Each goes on where the one before ends.
    let mut params = Vec::with_capacity(count + 1);
    for s in &segments {
        let domain = s.domain();
        match params.last().copied() {
            None => params.extend([domain.start, domain.end]),
            Some(last) if last == domain.start => params.push(domain.end),
            Some(last) => params.push(last + domain.length()),
        }
    }
    geometry(d, "curve", PolyCurve::new(segments, params)).map(Curve::Poly)
}

fn surface(d: &mut Chunk<'_>) -> Result<NurbsSurface, ReadError> {
    dimension::<3>(d)?;
    d.u8("the form")?;
    let degrees = [d.u8("a degree")?, d.u8("a degree")?].map(i32::from);
    let at = d.position();
    let spans = [d.u16("a number of spans")?, d.u16("a number of spans")?].map(i32::from);
    let [u, v] = [0, 1].map(|i| {
        SplineSize::new(
            d,
            at,
            degrees[i] + 1,
            degrees[i] + spans[i],
            3 * size_of::<f64>(),
        )
    });
    let (u, v) = (u?, v?);
    let flags = [d.u8("the rational flag")?, d.u8("the rational flag")?];
    let rational = flags.iter().any(|f| matches!(f, 1 | 2));
    let homogeneous = if flags[1] == 0 {
        flags[0] == 2
    } else {
        flags[1] == 2
    };
    d.skip(4, "flags")?;
    skip_box::<3>(d)?;
    let at = d.position();
    let count = d.check_count(at, "control points", product(&u, &v), 3 * size_of::<f64>())?;
    let mut knots = [Vec::new(), Vec::new()];
    for (list, size) in knots.iter_mut().zip([&u, &v]) {
        for _ in 0..size.count + size.degree - 1 {
            list.push(d.f64("a knot")?);
        }
    }
    let mut net = Vec::with_capacity(count);
    for _ in 0..count {
        net.push(control_point::<4>(d, rational, homogeneous)?);
    }
    let surface = NurbsSurface::new(
        [u.degree, v.degree],
        [u.count, v.count],
        net,
        knots.map(|k| widened(&k)),
    );
    geometry(d, "surface", surface)
}

fn product(u: &SplineSize, v: &SplineSize) -> i64 {
    i64::try_from(u.count.saturating_mul(v.count)).unwrap_or(i64::MAX)
}

/// Gives trims that share an edge the one that one of them has. Of those that do so in the same way (`sharing`, in order) the
/// list says the place of the other one.
fn glue(
    d: &Chunk<'_>,
    old: &mut OldBrep,
    sharing: &[usize],
    twins: &[usize],
) -> Result<(), ReadError> {
    for (&trim, &twin) in sharing.iter().zip(twins) {
        let other = sharing.get(twin).and_then(|t| old.trims.get(*t));
        let edge = other.and_then(|t| t.edge);
        if let Some(trim) = old.trims.get_mut(trim) {
            trim.edge = trim.edge.or(edge);
        }
    }
    let lost = |t: &&usize| old.trims.get(**t).is_some_and(|t| t.edge.is_none());
    match sharing.iter().find(lost) {
        None => Ok(()),
        Some(t) => Err(bad(
            d,
            d.id.offset,
            format!("the edge of trim {t}"),
            "missing".into(),
            "one that it shares with another trim",
        )),
    }
}

fn twins(d: &mut Chunk<'_>) -> Result<Vec<usize>, ReadError> {
    let count = d.count("shared edges", size_of::<u16>())?;
    (0..count)
        .map(|_| d.u16("a shared edge").map(usize::from))
        .collect()
}

fn shell(d: &mut Chunk<'_>, old: &mut OldBrep) -> Result<(), ReadError> {
    d.i32("the flag which way faces look")?;
    let at = d.position();
    let faces = i64::from(d.i32("the number of faces")?);
    skip_box::<3>(d)?;
    let twins = twins(d)?;
    let faces = d.check_count(at, "faces", faces, MIN_FACE)?;
    let mut mated = Vec::new();
    for _ in 0..faces {
        mated.extend(inner(d, FACE, "a face", |d| face(d, old))?);
    }
    glue(d, old, &mated, &twins)
}

/// A face; of its trims those that share an edge with another face.
fn face(d: &mut Chunk<'_>, old: &mut OldBrep) -> Result<Vec<usize>, ReadError> {
    let reversed = d.i32("a face's direction")? != 0;
    d.i32("a face's kind")?;
    let at = d.position();
    // The lowest bit says whether the border is among them, as it always is.
    let loops = i64::from(d.i32("the number of loops")?) / 2;
    skip_box::<3>(d)?;
    let twins = twins(d)?;
    let surface = inner(d, SURFACE, "a surface", surface)?;
    let count = d.check_count(at, "loops", loops, MIN_LOOP)?;
    let mut shared = Shared::default();
    let mut loops = Vec::with_capacity(count);
    for _ in 0..count {
        loops.push(inner(d, LOOP, "a loop", |d| {
            trim_loop(d, old, &mut shared)
        })?);
    }
    glue(d, old, &shared.seams, &twins)?;
    old.faces.push(OldFace {
        surface: Surface::Nurbs(surface),
        reversed,
        loops,
    });
    Ok(shared.mated)
}

/// Trims that share their edge, within their face or with another one.
#[derive(Default)]
struct Shared {
    seams: Vec<usize>,
    mated: Vec<usize>,
}

fn trim_loop(
    d: &mut Chunk<'_>,
    old: &mut OldBrep,
    shared: &mut Shared,
) -> Result<OldLoop, ReadError> {
    let at = d.position();
    let count = i64::from(d.i32("the number of trims")?);
    let kind = d.i32("a loop's kind")?;
    skip_box::<2>(d)?;
    let count = d.check_count(at, "trims", count, MIN_TRIM)?;
    let mut trims = Vec::with_capacity(count);
    for _ in 0..count {
        let t = old.trims.len();
        let flags = inner(d, TRIM, "a trim", |d| trim(d, old))?;
        if flags & 2 != 0 {
            shared.seams.push(t);
        } else if flags & 4 != 0 {
            shared.mated.push(t);
        }
        trims.push(t);
    }
    Ok(OldLoop { kind, trims })
}

/// A trim; returns its flags: 1 for an edge of its own, 2 for one shared within the face, 4 with another.
fn trim(d: &mut Chunk<'_>, old: &mut OldBrep) -> Result<u8, ReadError> {
    let flags = d.u8("a trim's flags")?;
    let reversed = d.i32("a trim's direction")? != 0;
    d.skip(8, "a trim's flags")?;
    let tolerance = d.optional_f64("a trim's tolerance in space")?;
    d.f64("a trim's tolerance in uv")?;
    let in_uv: Curve2 = inner(d, CURVE, "a uv curve", curve)?;
    let edge = if flags & 1 == 1 {
        let in_space: Curve3 = inner(d, CURVE, "a space curve", curve)?;
        old.curves3.push(in_space);
        Some(old.curves3.len() - 1)
    } else {
        None
    };
    old.trims.push(OldTrim {
        curve: in_uv,
        edge,
        reversed,
        tolerance,
    });
    Ok(flags)
}
