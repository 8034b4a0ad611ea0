//! Binary glTF 2.0 (Khronos, ISO/IEC 12113).
//!
//! y is up there and z here: nodes are turned. Lengths stay in model units, though glTF means metres. Scene 0 holds the parts and all queries;
//! each query has a scene of its own besides, for viewers that let one choose.

use crate::part::{EdgeKind, Part};
use crate::shapes::{Shape, ball, cone, square};
use crate::{Mark, MarkKind, ProbeShape, Shown, View};
use nalgebra::Vector3;
use serde_json::{Value, json};

/// Why there is no file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GlbError {
    /// It would be longer than its 32-bit lengths can say.
    TooLarge,
}

impl std::fmt::Display for GlbError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooLarge => write!(
                f,
                "binary glTF holds 4 GiB at most: ask for fewer triangles"
            ),
        }
    }
}

impl std::error::Error for GlbError {}

// glTF's numbers for what things are.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const POINTS: u32 = 0;
const LINES: u32 = 1;
const TRIANGLES: u32 = 4;

/// Materials by their place in the file.
const FACES: usize = 0;
const EDGES: usize = 1;
const BORDERS: usize = 2;
const PROBE: usize = 3;
const PROBE_LINE: usize = 4;
const NORMALS: usize = 5;
const ON_BREP: usize = 6;
const INSIDE: usize = 7;
const OUTSIDE: usize = 8;

/// Length of arrows, as a part of the part's radius.
const ARROW: f32 = 0.16;

fn materials() -> Value {
    let faces = json!({"name": "faces", "doubleSided": true, "pbrMetallicRoughness":
        {"baseColorFactor": [0.39, 0.47, 0.58, 1.0], "metallicFactor": 0.1, "roughnessFactor": 0.6}});
    let probe = json!({"name": "probe", "doubleSided": true, "alphaMode": "BLEND", "pbrMetallicRoughness":
        {"baseColorFactor": [0.02, 0.21, 0.75, 0.35], "metallicFactor": 0.0, "roughnessFactor": 0.6}});
    let flat = |name: &str, color: [f64; 4]| {
        json!({"name": name, "doubleSided": true, "extensions": {"KHR_materials_unlit": {}},
            "pbrMetallicRoughness": {"baseColorFactor": color}})
    };
    json!([
        faces,
        flat("edges", [0.02, 0.02, 0.03, 1.0]),
        flat("borders", [0.57, 0.01, 0.01, 1.0]),
        probe,
        flat("probe outline", [0.006, 0.095, 0.48, 1.0]),
        flat("normals", [0.004, 0.26, 0.05, 1.0]),
        flat("points on the BREP", [0.69, 0.004, 0.17, 1.0]),
        flat("points inside", [0.004, 0.26, 0.05, 1.0]),
        flat("points outside", [0.69, 0.004, 0.17, 1.0]),
    ])
}

/// The file as it grows.
#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
}

impl File {
    fn view(&mut self, bytes: impl Iterator<Item = u8>, target: u32) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(bytes);
        self.views.push(json!({"buffer": 0, "byteOffset": start,
            "byteLength": self.bytes.len() - start, "target": target}));
        self.views.len() - 1
    }

    fn vectors(&mut self, points: &[[f32; 3]]) -> usize {
        let bytes = points.iter().flatten().flat_map(|x| x.to_le_bytes());
        let view = self.view(bytes, ARRAY_BUFFER);
        let mut lo = [f32::INFINITY; 3];
        let mut hi = [f32::NEG_INFINITY; 3];
        for p in points {
            for c in 0..3 {
                lo[c] = lo[c].min(p[c]);
                hi[c] = hi[c].max(p[c]);
            }
        }
        self.accessors.push(
            json!({"bufferView": view, "componentType": FLOAT, "type": "VEC3",
            "count": points.len(), "min": lo.map(f64::from), "max": hi.map(f64::from)}),
        );
        self.accessors.len() - 1
    }

    fn indices(&mut self, indices: impl ExactSizeIterator<Item = u32>) -> usize {
        let count = indices.len();
        let view = self.view(indices.flat_map(u32::to_le_bytes), ELEMENT_ARRAY_BUFFER);
        self.accessors
            .push(json!({"bufferView": view, "componentType": UNSIGNED_INT,
            "type": "SCALAR", "count": count}));
        self.accessors.len() - 1
    }

    fn solid(
        &mut self,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
        triangles: &[[u32; 3]],
        material: usize,
    ) -> Value {
        let (p, n) = (self.vectors(positions), self.vectors(normals));
        let indices = self.indices(triangles.as_flattened().iter().copied());
        json!({"attributes": {"POSITION": p, "NORMAL": n}, "indices": indices, "material": material, "mode": TRIANGLES})
    }

    fn bare(&mut self, points: &[[f32; 3]], mode: u32, material: usize) -> Value {
        let p = self.vectors(points);
        json!({"attributes": {"POSITION": p}, "material": material, "mode": mode})
    }

    /// A mesh; none without primitives, which glTF does not allow.
    fn mesh(&mut self, name: &str, primitives: Vec<Value>) -> Option<usize> {
        if primitives.is_empty() {
            return None;
        }
        self.meshes
            .push(json!({"name": name, "primitives": primitives}));
        Some(self.meshes.len() - 1)
    }

    fn node(&mut self, node: Value) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }
}

/// The shapes' meshes.
struct Unit {
    ball: Option<usize>,
    square: Option<usize>,
    cone: Option<usize>,
}

/// A node over others that turns z up to y up and moves to the part's centre.
fn turned(name: &str, part: &Part, children: &[usize]) -> Value {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let [x, y, z] = part.center;
    let mut node =
        json!({"name": name, "rotation": [-half, 0.0, 0.0, half], "translation": [x, z, -y]});
    if !children.is_empty() {
        node["children"] = json!(children);
    }
    node
}

fn part_node(file: &mut File, part: &Part) -> usize {
    let mut children = Vec::new();
    if !part.triangles.is_empty() {
        let faces = file.solid(&part.positions, &part.normals, &part.triangles, FACES);
        if let Some(mesh) = file.mesh("faces", vec![faces]) {
            children.push(file.node(json!({"name": "faces", "mesh": mesh})));
        }
    }
    let mut lines = Vec::new();
    for (border, material) in [(false, EDGES), (true, BORDERS)] {
        let of_kind = part
            .edges
            .iter()
            .filter(|e| (e.kind == EdgeKind::Border) == border);
        let segments = of_kind.flat_map(|e| e.points.windows(2));
        let ends: Vec<[f32; 3]> = segments.flatten().copied().collect();
        if !ends.is_empty() {
            lines.push(file.bare(&ends, LINES, material));
        }
    }
    if let Some(mesh) = file.mesh("edges", lines) {
        children.push(file.node(json!({"name": "edges", "mesh": mesh})));
    }
    let node = turned(&part.name, part, &children);
    file.node(node)
}

/// Two unit vectors across a third, so that all three turn right.
fn across(n: &Vector3<f32>) -> [Vector3<f32>; 2] {
    let other = match n.z.abs() < 0.9 {
        true => Vector3::z(),
        false => Vector3::x(),
    };
    let x = other.cross(n).normalize();
    [x, n.cross(&x)]
}

/// A unit shape by its axes and its origin.
fn placed(mesh: usize, axes: [Vector3<f32>; 3], origin: Vector3<f32>) -> Value {
    let mut matrix = Vec::with_capacity(16);
    for (axis, last) in axes.iter().chain([&origin]).zip([0.0, 0.0, 0.0, 1.0]) {
        matrix.extend(axis.iter().map(|x| f64::from(*x)));
        matrix.push(last);
    }
    json!({"mesh": mesh, "matrix": matrix})
}

fn query_node(file: &mut File, unit: &Unit, part: &Part, query: &Shown) -> usize {
    let mut children = Vec::new();
    let mut primitives = Vec::new();
    match query.probe {
        Some(ProbeShape::Ball { center, radius }) if radius > 0.0 => {
            if let Some(mesh) = unit.ball {
                let r = f64::from(radius);
                children.push(file.node(json!({"name": "probe", "mesh": mesh,
                    "translation": center.map(f64::from), "scale": [r, r, r]})));
            }
        }
        // A point.
        Some(ProbeShape::Ball { center, .. }) => {
            primitives.push(file.bare(&[center], POINTS, PROBE_LINE));
        }
        Some(ProbeShape::Plane(p)) => {
            let n = Vector3::from(p.normal);
            let [x, y] = across(&n);
            let axes = [x, y, n].map(|a| a * p.half);
            if let Some(mesh) = unit.square {
                children.push(file.node(placed(mesh, axes, p.center.into())));
            }
        }
        Some(ProbeShape::Line(l)) => {
            primitives.push(file.bare(&[l.from, l.to], LINES, PROBE_LINE));
        }
        None => {}
    }
    let length = ARROW * part.radius as f32;
    let mut stems = Vec::new();
    let mut gaps = Vec::new();
    for Mark {
        at,
        normal,
        to,
        until,
        arrows,
        ..
    } in &query.marks
    {
        gaps.extend([to, until].into_iter().flatten().flat_map(|p| [*at, *p]));
        for n in normal.iter().chain(arrows) {
            let (at, n) = (Vector3::from(*at), Vector3::from(*n));
            let neck = at + n * (0.7 * length);
            stems.extend([<[f32; 3]>::from(at), neck.into()]);
            let [x, y] = across(&n);
            let axes = [x * (0.1 * length), y * (0.1 * length), n * (0.3 * length)];
            if let Some(mesh) = unit.cone {
                children.push(file.node(placed(mesh, axes, neck)));
            }
        }
    }
    for (ends, material) in [(stems, NORMALS), (gaps, PROBE_LINE)] {
        if !ends.is_empty() {
            primitives.push(file.bare(&ends, LINES, material));
        }
    }
    for (kind, material) in [
        (MarkKind::Brep, ON_BREP),
        (MarkKind::Inside, INSIDE),
        (MarkKind::Outside, OUTSIDE),
    ] {
        let of_kind = query.marks.iter().filter(|m| m.kind == kind);
        let points: Vec<[f32; 3]> = of_kind.map(|m| m.at).collect();
        if !points.is_empty() {
            primitives.push(file.bare(&points, POINTS, material));
        }
    }
    if let Some(mesh) = file.mesh(&query.label, primitives) {
        children.push(file.node(json!({"name": "answer", "mesh": mesh})));
    }
    let mut node = turned(&query.label, part, &children);
    node["extras"] = json!({"query": query.query, "answer": query.answer});
    file.node(node)
}

impl View {
    /// The view as binary glTF.
    ///
    /// # Errors
    /// More than 4 GiB.
    pub fn glb(&self) -> Result<Vec<u8>, GlbError> {
        let mut file = File::default();
        let parts: Vec<usize> = self
            .parts
            .iter()
            .map(|part| part_node(&mut file, part))
            .collect();
        let shape = |file: &mut File, s: &Shape, material| {
            let solid = file.solid(&s.positions, &s.normals, &s.triangles, material);
            file.mesh(s.name, vec![solid])
        };
        // A mesh that no node uses is no error, but of no use either.
        let unit = match self.queries.is_empty() {
            true => Unit {
                ball: None,
                square: None,
                cone: None,
            },
            false => Unit {
                ball: shape(&mut file, &ball(), PROBE),
                square: shape(&mut file, &square(), PROBE),
                cone: shape(&mut file, &cone(), NORMALS),
            },
        };
        let mut scenes = Vec::new();
        let mut all = parts.clone();
        for query in &self.queries {
            let Some(part) = self.parts.get(query.part) else {
                continue;
            };
            let node = query_node(&mut file, &unit, part, query);
            all.push(node);
            scenes.push(json!({"name": query.label, "nodes": [parts[query.part], node]}));
        }
        let mut root = json!({
            "asset": {"version": "2.0", "generator": concat!("feeler ", env!("CARGO_PKG_VERSION"))},
            "extensionsUsed": ["KHR_materials_unlit"],
            "materials": materials(),
        });
        // glTF wants no empty lists, in scenes neither.
        if !all.is_empty() {
            scenes.insert(0, json!({"name": self.title, "nodes": all}));
            root["scene"] = json!(0);
            root["scenes"] = Value::Array(scenes);
        }
        for (key, list) in [
            ("nodes", file.nodes),
            ("meshes", file.meshes),
            ("accessors", file.accessors),
            ("bufferViews", file.views),
        ] {
            if !list.is_empty() {
                root[key] = Value::Array(list);
            }
        }
        if !file.bytes.is_empty() {
            root["buffers"] = json!([{"byteLength": file.bytes.len()}]);
        }
        let mut text = root.to_string().into_bytes();
        while !text.len().is_multiple_of(4) {
            text.push(b' ');
        }
        // All that is stored has four bytes.
        let binary = match file.bytes.len() {
            0 => 0,
            n => 8 + n,
        };
        let length = 12 + 8 + text.len() + binary;
        let length = u32::try_from(length).map_err(|_| GlbError::TooLarge)?;
        let mut out = Vec::with_capacity(length as usize);
        out.extend(b"glTF");
        out.extend(2u32.to_le_bytes());
        out.extend(length.to_le_bytes());
        let mut chunk = |kind: &[u8; 4], bytes: &[u8]| {
            out.extend((bytes.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(bytes);
        };
        chunk(b"JSON", &text);
        if binary > 0 {
            chunk(b"BIN\0", &file.bytes);
        }
        Ok(out)
    }
}
