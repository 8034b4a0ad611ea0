//! `feeler inspect --plan`: what the kernel keeps of each face, and why.

use feeler::brep::Brep;
use feeler::prepare::{FaceBytes, FacePlan, Form, PreparedBrep, Searched};
use feeler::trim::RegionShape;
use serde_json::{Value, json};

/// The plan of each face, and what is there before any query.
fn made(brep: &Brep) -> (usize, Vec<FacePlan>) {
    let prepared = PreparedBrep::new(brep.clone());
    let at_once = prepared.bytes();
    (at_once, prepared.plan())
}

fn later(b: &FaceBytes) -> usize {
    b.region + b.closed + b.patches + b.fine_patches
}

/// A line for the whole and one a face.
pub(crate) fn text(brep: &Brep, lines: &mut Vec<String>) {
    let (at_once, faces) = made(brep);
    let all: usize = faces.iter().map(|f| later(&f.bytes)).sum();
    lines.push(format!(
        "  plan: {at_once} bytes at once, up to {all} more as queries come near faces, \
         boundary pieces and products apart"
    ));
    for (i, face) in faces.iter().enumerate() {
        lines.push(format!("  face {i}: {}", line(face)));
    }
}

fn line(f: &FacePlan) -> String {
    let bytes = match f.form {
        Form::Closed { .. } => format!(
            "{} bytes when near (trims {}, formulas {}), patches left out but for lists of contacts and \
             where formulas lose digits ({})",
            f.bytes.region + f.bytes.closed,
            f.bytes.region,
            f.bytes.closed,
            f.bytes.patches + f.bytes.fine_patches,
        ),
        Form::Searched(_) => format!(
            "{} bytes when near (trims {}, patches {}), {} for the last digits",
            f.bytes.region + f.bytes.patches,
            f.bytes.region,
            f.bytes.patches,
            f.bytes.fine_patches,
        ),
    };
    format!(
        "{}, {}; {}; {} of degree {}x{}, {}; {bytes}",
        f.surface,
        form(&f.form),
        region(&f.region),
        counted(f.patches, "patch", "patches"),
        f.degree[0],
        f.degree[1],
        if f.rational {
            "rational"
        } else {
            "polynomial: weights left out"
        },
    )
}

fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

fn form(form: &Form) -> String {
    match form {
        Form::Closed {
            kind,
            curves,
            searched_curves: 0,
        } => format!("formula of a {kind}, its {curves} border curves too"),
        Form::Closed {
            kind,
            curves,
            searched_curves,
        } => format!("formula of a {kind}, {curves} border curves too, {searched_curves} searched"),
        Form::Searched(why) => format!("searched: {}", reason(why)),
    }
}

fn reason(why: &Searched) -> String {
    match why {
        Searched::SwitchedOff => "formulas are switched off".into(),
        Searched::Shell { kind, thickness } => {
            format!("a {kind} within {thickness:.1e}, which bounds it first")
        }
        Searched::General => "no round surface recognised".into(),
        Searched::Surface => "no formula for this plane or revolution".into(),
        Searched::Loops => "its loops leave the domain".into(),
    }
}

fn region(shape: &RegionShape) -> String {
    match shape {
        RegionShape::Whole => "no trims".into(),
        RegionShape::Nothing => "trimmed to nothing".into(),
        RegionShape::Rectangle(_) => "trims a rectangle: sides are comparisons".into(),
        RegionShape::ConvexPolygon(n) => format!("trims a convex polygon of {n} sides"),
        RegionShape::General(n) => format!("general trims of {}", counted(*n, "piece", "pieces")),
    }
}

/// The same as JSON.
pub(crate) fn json(brep: &Brep) -> Value {
    let (at_once, faces) = made(brep);
    let faces: Vec<Value> = faces.iter().map(face_json).collect();
    json!({ "bytes_at_once": at_once, "faces": faces })
}

fn face_json(f: &FacePlan) -> Value {
    let form = match f.form {
        Form::Closed {
            kind,
            curves,
            searched_curves,
        } => json!({
            "closed": kind,
            "curves": curves,
            "searched_curves": searched_curves,
        }),
        Form::Searched(why) => match why {
            Searched::Shell { kind, thickness } => {
                json!({ "searched": "shell", "kind": kind, "thickness": thickness })
            }
            Searched::General => json!({ "searched": "general" }),
            Searched::SwitchedOff => json!({ "searched": "switched_off" }),
            Searched::Surface => json!({ "searched": "surface" }),
            Searched::Loops => json!({ "searched": "loops" }),
        },
    };
    let trims = match f.region {
        RegionShape::Whole => json!({ "shape": "none" }),
        RegionShape::Nothing => json!({ "shape": "nothing" }),
        RegionShape::Rectangle(r) => json!({ "shape": "rectangle", "uv": r }),
        RegionShape::ConvexPolygon(n) => json!({ "shape": "convex_polygon", "pieces": n }),
        RegionShape::General(n) => json!({ "shape": "general", "pieces": n }),
    };
    json!({
        "surface": f.surface,
        "form": form,
        "trims": trims,
        "patches": f.patches,
        "degree": f.degree,
        "rational": f.rational,
        "bytes": {
            "at_once": f.bytes.at_once,
            "trims": f.bytes.region,
            "formulas": f.bytes.closed,
            "patches": f.bytes.patches,
            "fine_patches": f.bytes.fine_patches,
        },
    })
}
