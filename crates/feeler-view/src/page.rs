//! One HTML file that needs nothing else.

use crate::part::{EdgeKind, Part, quantised};
use crate::shapes::{self, Shape};
use crate::{Shown, View};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use nalgebra::Vector3;
use serde::Serialize;
use std::collections::BTreeMap;

const PAGE: &str = include_str!("../page/page.html");
const SCRIPT: &str = include_str!("../page/view.js");

/// What the script reads. Arrays of numbers are base64 of little-endian f32, i16 (four for each normal) or u32.
#[derive(Serialize)]
struct Data<'a> {
    title: &'a str,
    notes: &'a [String],
    overview: bool,
    shapes: BTreeMap<&'static str, Triangles>,
    parts: Vec<PartData<'a>>,
    queries: &'a [Shown],
}

#[derive(Serialize)]
struct Triangles {
    positions: String,
    normals: String,
    indices: String,
}

#[derive(Serialize)]
struct PartData<'a> {
    name: &'a str,
    center: [f64; 3],
    radius: f64,
    chord: f64,
    chord_relative: f64,
    chord_found: f64,
    notes: &'a [String],
    /// Number, kind, first index, count of indices.
    faces: Vec<(usize, &'static str, usize, usize)>,
    indices_count: usize,
    line_points: String,
    /// Kind, first point, count of points.
    lines: Vec<(&'static str, usize, usize)>,
    #[serde(flatten)]
    triangles: Triangles,
}

fn text(bytes: impl Iterator<Item = u8>) -> String {
    STANDARD.encode(bytes.collect::<Vec<u8>>())
}

fn floats(points: &[[f32; 3]]) -> String {
    text(points.iter().flatten().flat_map(|x| x.to_le_bytes()))
}

fn triangles(positions: &[[f32; 3]], normals: &[[f32; 3]], indices: &[[u32; 3]]) -> Triangles {
    let short = |n: &[f32; 3]| {
        let [x, y, z] = quantised(&Vector3::from(*n).map(f64::from));
        [x, y, z, 0]
    };
    let normals = normals.iter().flat_map(short);
    Triangles {
        positions: floats(positions),
        normals: text(normals.flat_map(|x| x.to_le_bytes())),
        indices: text(indices.iter().flatten().flat_map(|x| x.to_le_bytes())),
    }
}

fn part(part: &Part) -> PartData<'_> {
    let mut points = Vec::new();
    let mut lines = Vec::new();
    for edge in &part.edges {
        let kind = match edge.kind {
            EdgeKind::Shared => "shared",
            EdgeKind::Seam => "seam",
            EdgeKind::Border => "border",
        };
        lines.push((kind, points.len(), edge.points.len()));
        points.extend_from_slice(&edge.points);
    }
    let faces = part.faces.iter();
    // JSON has no infinity: a part without size has no chords either.
    let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
    PartData {
        name: &part.name,
        center: part.center,
        radius: part.radius,
        chord: finite(part.chord),
        chord_relative: finite(part.chord / part.size),
        chord_found: part.chord_found,
        notes: &part.notes,
        faces: faces
            .map(|f| (f.face, f.kind, 3 * f.first, 3 * f.count))
            .collect(),
        indices_count: 3 * part.triangles.len(),
        line_points: floats(&points),
        lines,
        triangles: triangles(&part.positions, &part.normals, &part.triangles),
    }
}

impl View {
    /// The view as a page: HTML with its script and all data, nothing from elsewhere.
    pub fn page(&self) -> String {
        let shape = |s: &Shape| (s.name, triangles(&s.positions, &s.normals, &s.triangles));
        let data = Data {
            title: &self.title,
            notes: &self.notes,
            overview: self.overview,
            shapes: shapes::all().iter().map(shape).collect(),
            parts: self.parts.iter().map(part).collect(),
            queries: &self.queries,
        };
        let json = serde_json::to_string(&data).unwrap_or_default();
        // Nothing in the data may end its element: in JSON `<` occurs in strings alone.
        let json = json.replace('<', "\\u003c");
        let (before, after) = PAGE.split_once("{DATA}").unwrap_or((PAGE, ""));
        let (between, end) = after.split_once("{SCRIPT}").unwrap_or((after, ""));
        [before, &json, between, SCRIPT, end].concat()
    }
}
