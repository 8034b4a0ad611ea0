//! `feeler inspect`.

use crate::{Bad, Outcome, health, plan, write_error};
use feeler::brep::{Brep, Defect};
use feeler::nurbs::Curve;
use feeler_corpus::{MODEL_FILE_VERSION, Model};
use feeler_io::{Block, Document, Object, ObjectKind};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;

/// How many defects of an object are shown as text; all of them with `--json`.
const SHOWN: usize = 10;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .3dm, .brep (OCCT, text) or .step file, or a model file of our own (.json, .json.gz).
    file: PathBuf,
    /// One JSON object instead of text.
    #[arg(long)]
    json: bool,
    /// What queries keep of each face and what they leave out, and why. Makes all of it, to weigh it.
    #[arg(long)]
    plan: bool,
    /// What an importer must know, with proven bounds: gaps, cracks, edge curves off their faces, loops that run wrong or
    /// cross, tiny edges, slivers, edges that are open or used too often, and what that leaves undefined.
    #[arg(long)]
    health: bool,
}

/// What is wanted besides the contents.
#[derive(Clone, Copy)]
struct More<'a> {
    plan: bool,
    health: bool,
    /// What lengths are in.
    unit: &'a str,
}

/// Where a file has no units.
const MODEL_UNITS: &str = "model units";

impl Args {
    fn more<'a>(&self, unit: &'a str) -> More<'a> {
        More {
            plan: self.plan,
            health: self.health,
            unit: if unit == "none" { MODEL_UNITS } else { unit },
        }
    }
}

pub(crate) fn run(args: &Args) -> Result<Outcome, Bad> {
    if Model::is_own(&args.file) {
        return own(args);
    }
    let document = feeler_io::read_file(&args.file).map_err(|e| Bad(e.to_string()))?;
    let mut out = std::io::stdout().lock();
    let more = args.more(document.units.symbol());
    let text = if args.json {
        format!("{}\n", as_json(&document, more))
    } else {
        as_text(&document, more)
    };
    out.write_all(text.as_bytes()).map_err(write_error)?;
    let refused: usize = (0..document.objects.len())
        .map(|i| refused(&document, i))
        .sum();
    if refused == 0 {
        return Ok(Outcome::Good);
    }
    out.flush().map_err(write_error)?;
    eprintln!(
        "error: {}: {refused} objects cannot be read, each with its reason and remedy above; all others were read",
        args.file.display()
    );
    Ok(Outcome::Refused)
}

/// How many objects could not be read: this one, or, of those that a block reference places, could not be moved there.
fn refused(document: &Document, index: usize) -> usize {
    let is_refused = |o: &Object| matches!(o.kind, ObjectKind::Refused { .. });
    if document.objects.get(index).is_some_and(is_refused) {
        return 1;
    }
    let placements = document.placements(index);
    placements
        .filter(|p| !is_refused(p.object) && is_refused(&p.placed()))
        .count()
}

/// A model file of our own: BREPs and nothing else.
fn own(args: &Args) -> Result<Outcome, Bad> {
    let model = Model::load(&args.file, None).map_err(|e| Bad(e.to_string()))?;
    let more = args.more(MODEL_UNITS);
    let text = if args.json {
        let objects = model.breps.iter().map(|b| {
            let mut o = Map::new();
            o.insert("kind".into(), json!("brep"));
            brep_json(b, more, &mut o);
            Value::Object(o)
        });
        let all = json!({
            "format": "feeler_model",
            "version": MODEL_FILE_VERSION,
            "objects": objects.collect::<Vec<_>>(),
        });
        format!("{all}\n")
    } else {
        let count = model.breps.len();
        let mut lines = vec![format!(
            "feeler model version {MODEL_FILE_VERSION}, {count} objects"
        )];
        for (i, brep) in model.breps.iter().enumerate() {
            lines.push(format!("object {i}: brep"));
            brep_text(brep, more, &mut lines);
        }
        lines.join("\n") + "\n"
    };
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).map_err(write_error)?;
    Ok(Outcome::Good)
}

type Counts = BTreeMap<&'static str, usize>;

fn count(names: impl Iterator<Item = &'static str>) -> Counts {
    let mut counts = Counts::new();
    for name in names {
        *counts.entry(name).or_default() += 1;
    }
    counts
}

/// What a BREP is made of, counted by use: a surface shared by two faces counts twice.
struct Contents {
    surfaces: Counts,
    trim_curves: Counts,
    edge_curves: Counts,
}

fn contents(brep: &Brep) -> Contents {
    fn name<const D: usize, const H: usize>(c: Option<&Curve<D, H>>) -> &'static str {
        c.map_or("none", Curve::type_name)
    }
    let p = brep.parts();
    Contents {
        surfaces: count((0..p.faces.len()).map(|f| brep.surface(f).type_name())),
        trim_curves: count(p.trims.iter().map(|t| name(p.curves2.get(t.curve)))),
        edge_curves: count(
            p.edges
                .iter()
                .map(|e| name(e.curve.and_then(|c| p.curves3.get(c)))),
        ),
    }
}

fn as_json(document: &Document, more: More) -> Value {
    let objects = document.objects.iter().enumerate();
    let objects: Vec<Value> = objects
        .map(|(i, o)| match document.block(o) {
            Some(block) => reference_json(document, i, o, block, more),
            None => Value::Object(object_json(o, more)),
        })
        .collect();
    json!({
        "format": document.format.name(),
        "version": document.version,
        "units": document.units.symbol(),
        "warnings": document.warnings,
        "objects": objects,
        "unsupported": unread(document),
    })
}

/// A reference and what it places.
fn reference_json(
    document: &Document,
    index: usize,
    object: &Object,
    block: &Block,
    more: More,
) -> Value {
    let mut o = object_json(object, more);
    o.remove("supported");
    o.insert("block".into(), json!(block.name));
    let parts = { document.parts(index) }.map(|p| Value::Object(object_json(&p, more)));
    o.insert("parts".into(), parts.collect());
    let blocks = document.placed_blocks(index);
    let of_blocks = blocks.iter().flat_map(|b| &b.warnings);
    let warnings: Vec<&String> = object.warnings.iter().chain(of_blocks).collect();
    if !warnings.is_empty() {
        o.insert("warnings".into(), json!(warnings));
    }
    Value::Object(o)
}

fn object_json(object: &Object, more: More) -> Map<String, Value> {
    let mut o = Map::new();
    o.insert("kind".into(), json!(object.kind.name()));
    o.insert("name".into(), json!(object.name));
    o.insert("layer".into(), json!(object.layer));
    for (key, is_so) in marks(object) {
        if is_so {
            o.insert(key.into(), json!(true));
        }
    }
    match &object.kind {
        ObjectKind::Brep(brep) | ObjectKind::Surface(brep) | ObjectKind::Extrusion(brep) => {
            brep_json(brep, more, &mut o);
        }
        ObjectKind::Curve(curve) => {
            o.insert("curve".into(), json!(curve.type_name()));
            o.insert("supported".into(), json!(false));
        }
        ObjectKind::Refused { class, reason } => {
            o.insert("class".into(), json!(class));
            o.insert("reason".into(), json!(reason.to_string()));
            o.insert("supported".into(), json!(false));
        }
        _ => {
            o.insert("supported".into(), json!(false));
        }
    }
    if !object.warnings.is_empty() {
        o.insert("warnings".into(), json!(object.warnings));
    }
    o
}

fn brep_json(brep: &Brep, more: More, o: &mut Map<String, Value>) {
    let p = brep.parts();
    let c = contents(brep);
    let (allowed, defects) = deviations_and_defects(brep);
    let said = |all: &[Defect]| all.iter().map(ToString::to_string).collect::<Vec<_>>();
    for (key, value) in [
        ("faces", json!(p.faces.len())),
        ("loops", json!(p.loops.len())),
        ("trims", json!(p.trims.len())),
        ("edges", json!(p.edges.len())),
        ("vertices", json!(p.vertices.len())),
        ("solid", json!(brep.is_closed())),
        ("surfaces", json!(c.surfaces)),
        ("trim_curves", json!(c.trim_curves)),
        ("edge_curves", json!(c.edge_curves)),
        ("defects", json!(said(&defects))),
    ] {
        o.insert(key.into(), value);
    }
    if !allowed.is_empty() {
        o.insert("within_tolerance".into(), json!(said(&allowed)));
    }
    if more.plan {
        o.insert("plan".into(), plan::json(brep));
    }
    if more.health {
        o.insert("health".into(), health::json(brep));
    }
}

fn list(counts: &Counts) -> String {
    let all: Vec<String> = counts.iter().map(|(k, n)| format!("{n} {k}")).collect();
    all.join(", ")
}

fn as_text(document: &Document, more: More) -> String {
    // A STEP file of another application protocol than those known, which a warning tells.
    let version = match document.version {
        0 => "unknown".to_owned(),
        n => n.to_string(),
    };
    let mut lines = vec![format!(
        "{} version {version}, units {}, {} objects",
        document.format.name(),
        document.units,
        document.objects.len()
    )];
    lines.extend(document.warnings.iter().map(|w| format!("  warning: {w}")));
    for (i, object) in document.objects.iter().enumerate() {
        let title = format!("object {i}");
        let Some(block) = document.block(object) else {
            object_text(&title, object, more, &mut lines);
            continue;
        };
        let count = document.placements(i).count();
        let of = match block.name.as_str() {
            "" => String::new(),
            name => format!(" of `{name}`"),
        };
        lines.push(format!(
            "{}{of}, which places {count}",
            head(&title, object)
        ));
        for (k, part) in document.parts(i).enumerate() {
            object_text(&format!("{title}, part {k}"), &part, more, &mut lines);
        }
        let blocks = document.placed_blocks(i);
        let of_blocks = blocks.iter().flat_map(|b| &b.warnings);
        let warnings = object.warnings.iter().chain(of_blocks);
        lines.extend(warnings.map(|w| format!("  warning: {w}")));
    }
    let unread = unread(document);
    if !unread.is_empty() {
        let all: Vec<String> = unread.iter().map(|(k, n)| format!("{n} {k}")).collect();
        lines.push(format!("not supported: {}", all.join(", ")));
    }
    lines.join("\n") + "\n"
}

/// What an object is to its model.
fn marks(object: &Object) -> [(&'static str, bool); 3] {
    [
        ("hidden", object.hidden),
        ("locked", object.locked),
        ("block_member", object.block_member),
    ]
}

/// The objects that are not read, by kind: meshes, subdivision surfaces, ...
fn unread(document: &Document) -> BTreeMap<&str, usize> {
    let mut counts = BTreeMap::new();
    for object in &document.objects {
        if matches!(object.kind, ObjectKind::Mesh | ObjectKind::Other(_)) {
            *counts.entry(object.kind.name()).or_default() += 1;
        }
    }
    counts
}

/// What an object is called.
fn head(title: &str, object: &Object) -> String {
    let mut head = format!("{title}: {}", object.kind.name());
    if !object.name.is_empty() {
        head += &format!(" `{}`", object.name);
    }
    if let Some(layer) = &object.layer {
        head += &format!(" on layer `{layer}`");
    }
    for (mark, is_so) in marks(object) {
        if is_so {
            head += &format!(", {}", mark.replace('_', " "));
        }
    }
    head
}

fn object_text(title: &str, object: &Object, more: More, lines: &mut Vec<String>) {
    let head = head(title, object);
    match &object.kind {
        ObjectKind::Brep(brep) | ObjectKind::Surface(brep) | ObjectKind::Extrusion(brep) => {
            lines.push(head);
            brep_text(brep, more, lines);
        }
        ObjectKind::Refused { class, reason } => {
            lines.push(format!("{head} ({class}): {reason}"));
        }
        ObjectKind::Curve(curve) => {
            lines.push(format!("{head} ({}), not asked", curve.type_name()))
        }
        _ => lines.push(format!("{head}, not supported")),
    }
    lines.extend(object.warnings.iter().map(|w| format!("  warning: {w}")));
}

fn brep_text(brep: &Brep, more: More, lines: &mut Vec<String>) {
    let p = brep.parts();
    let c = contents(brep);
    lines.push(format!(
        "  {} faces, {} loops, {} trims, {} edges, {} vertices; {}",
        p.faces.len(),
        p.loops.len(),
        p.trims.len(),
        p.edges.len(),
        p.vertices.len(),
        if brep.is_closed() { "closed" } else { "open" }
    ));
    lines.push(format!("  surfaces: {}", list(&c.surfaces)));
    lines.push(format!("  trim curves: {}", list(&c.trim_curves)));
    lines.push(format!("  edge curves: {}", list(&c.edge_curves)));
    if more.health {
        health::text(brep, more.unit, lines);
    } else {
        defects_text(brep, lines);
    }
    if more.plan {
        plan::text(brep, lines);
    }
}

/// What the file's own tolerance covers is no defect.
fn deviations_and_defects(brep: &Brep) -> (Vec<Defect>, Vec<Defect>) {
    let all = brep.defects().into_iter();
    all.partition(Defect::is_within_tolerance)
}

fn defects_text(brep: &Brep, lines: &mut Vec<String>) {
    let (allowed, defects) = deviations_and_defects(brep);
    if defects.is_empty() {
        lines.push("  no defects".into());
    }
    for defect in defects.iter().take(SHOWN) {
        lines.push(format!("  defect: {defect}"));
    }
    if defects.len() > SHOWN {
        lines.push(format!(
            "  and {} more; --json lists them all",
            defects.len() - SHOWN
        ));
    }
    match allowed.len() {
        0 => {}
        1 => lines.push("  1 deviation within the file's own tolerance; --json tells it".into()),
        n => lines.push(format!(
            "  {n} deviations within the file's own tolerance; --json lists them"
        )),
    }
}
