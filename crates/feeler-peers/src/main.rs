//! Other NURBS libraries in Rust as engines for `feeler gate` and `feeler report`.
//!
//! ```sh
//! cargo build --release --manifest-path crates/feeler-peers/Cargo.toml --target-dir target
//! cargo run --release -- gate --engine 'target/release/feeler-peers truck' --suite contact-sphere
//! ```
//!
//! Both search the point of a surface or curve that is nearest to a point: Newton's method from the best of some samples.
//! That is all that is theirs. What they do not have is ours, so that nothing else is measured: files, native surfaces and
//! curves turned into NURBS, the exact side of a foot point against the trims, and whether a point is in the solid. Where the
//! foot is trimmed away the nearest point is on an edge: it is sought on the edges' curves in space, which files may hold
//! less exactly.
//!
//! Balls against the deepest contact are treated; every other query is refused.
#![forbid(unsafe_code)]

mod library;

use feeler::brep::Brep;
use feeler::nurbs::ParameterMap;
use feeler::prepare::PreparedBrep;
use feeler::query::{self, Contacts, Feature, Probe, Sphere, Workspace};
use feeler::trim::{Side, TrimRegion};
use feeler_corpus::{Answer, Ask, Body, Claim, ContactLine, Model, Query, QueryLine};
use library::{Library, PeerCurve, PeerSurface};
use nalgebra::{Point2, Point3, Vector3};
use serde_json::{Value, json};
use std::io::{BufRead, Write};
use std::path::Path;
use std::process::ExitCode;

/// A face as a library has it.
struct PeerFace {
    surface: PeerSurface,
    maps: [ParameterMap; 2],
    region: TrimRegion,
}

/// An edge's curve in space, and the part of it that is the edge.
struct PeerEdge {
    curve: PeerCurve,
    range: [f64; 2],
}

struct Part {
    faces: Vec<PeerFace>,
    edges: Vec<PeerEdge>,
    /// For the side of a point in space alone.
    solid: PreparedBrep,
}

/// The nearest point so far.
struct Nearest {
    distance: f64,
    foot: Point3<f64>,
    feature: Feature,
    /// Unit normal of a face there.
    normal: Option<Vector3<f64>>,
}

fn part(brep: &Brep, library: Library) -> Result<Part, String> {
    let mut faces = Vec::new();
    for face in 0..brep.faces().len() {
        let converted = brep.surface(face).to_nurbs().map_err(|e| e.to_string())?;
        faces.push(PeerFace {
            surface: library.surface(&converted.nurbs)?,
            maps: converted.maps,
            region: TrimRegion::new(brep, face),
        });
    }
    let mut edges = Vec::new();
    for (i, edge) in brep.parts().edges.iter().enumerate() {
        let Some(curve) = edge.curve else {
            return Err(format!("edge {i} has no curve in space"));
        };
        let curve = &brep.parts().curves3[curve];
        let converted = curve.to_nurbs().map_err(|e| e.to_string())?;
        let ends = [edge.span.start, edge.span.end];
        edges.push(PeerEdge {
            curve: library.curve(&converted.nurbs)?,
            range: ends.map(|t| converted.map.to_nurbs(t)),
        });
    }
    Ok(Part {
        faces,
        edges,
        solid: PreparedBrep::new(brep.clone()),
    })
}

impl Part {
    /// The nearest point of the trimmed faces, as far as the library finds it.
    fn nearest(&self, center: Point3<f64>) -> Option<Nearest> {
        let mut best: Option<Nearest> = None;
        let mut keep = |foot: Point3<f64>, feature: Feature, normal: Option<Vector3<f64>>| {
            let distance = (center - foot).norm();
            if best.as_ref().is_none_or(|b| distance < b.distance) {
                best = Some(Nearest {
                    distance,
                    foot,
                    feature,
                    normal,
                });
            }
        };
        for (i, face) in self.faces.iter().enumerate() {
            let Some([u, v]) = face.surface.nearest(center) else {
                continue;
            };
            let [a, b] = &face.maps;
            let native = Point2::new(a.to_native(u), b.to_native(v));
            let side = face.region.side(native).side;
            if matches!(side, Some(Side::Inside | Side::Boundary)) {
                let (foot, normal) = face.surface.point_and_normal(u, v);
                keep(foot, Feature::Face(i), normal);
            }
        }
        for (i, edge) in self.edges.iter().enumerate() {
            let [from, to] = edge.range;
            let found = edge.curve.nearest(center, edge.range);
            for t in found
                .map(|t| t.clamp(from, to))
                .into_iter()
                .chain([from, to])
            {
                keep(edge.curve.point(t), Feature::Edge(i), None);
            }
        }
        best
    }

    fn is_inside(&self, center: Point3<f64>) -> bool {
        let closed = self.solid.brep().is_closed();
        closed
            && query::inside(&self.solid, center, &mut Workspace::default()).side
                == Some(Side::Inside)
    }
}

fn value(value: f64) -> Claim {
    Claim {
        value,
        lo: None,
        hi: None,
    }
}

fn contact(parts: &[Part], sphere: &Sphere, prediction: f64, contacts: Contacts) -> Body {
    let found = parts.iter().filter_map(|p| p.nearest(sphere.center));
    let Some(near) = found.min_by(|a, b| a.distance.total_cmp(&b.distance)) else {
        return Body::Error {
            error: "no nearest point was found".to_owned(),
        };
    };
    let inside = parts.iter().any(|p| p.is_inside(sphere.center));
    let sign = if inside { -1.0 } else { 1.0 };
    let separation = sign * near.distance - sphere.radius;
    let mut lines = Vec::new();
    if separation <= prediction && contacts != Contacts::None {
        let normal = if near.distance > 0.0 {
            (sphere.center - near.foot) * (sign / near.distance)
        } else {
            near.normal.unwrap_or_else(Vector3::zeros)
        };
        let on_probe = sphere.center - normal * sphere.radius;
        lines.push(ContactLine {
            on_brep: near.foot.coords.into(),
            on_probe: on_probe.coords.into(),
            normal: normal.into(),
            separation: value(separation),
            feature: Some(near.feature),
            uv: None,
            position_bound: None,
            normal_bound: None,
            normal_is_choice: false,
        });
    }
    Body::Contact {
        separation: value(separation),
        continuum: None,
        contacts: lines,
        undecided: None,
    }
}

fn answer(parts: &[Part], query: &Query) -> Body {
    let contacts = query.contacts.unwrap_or(Contacts::Deepest);
    match &query.ask {
        Ask::Contact(Probe::Sphere(sphere)) if !query.overlap && contacts != Contacts::All => {
            contact(parts, sphere, query.prediction.unwrap_or(0.0), contacts)
        }
        _ => Body::Error {
            error: "only balls and their deepest contact are treated".to_owned(),
        },
    }
}

fn open(line: &str, library: Library) -> Result<(usize, Vec<Part>), String> {
    let first: Value = serde_json::from_str(line).map_err(|e| e.to_string())?;
    let path = first["model"].as_str().ok_or("no model named")?;
    let model = Model::load(Path::new(path), None).map_err(|e| e.to_string())?;
    let parts = model.breps.iter().map(|b| part(b, library));
    Ok((model.faces(), parts.collect::<Result<_, _>>()?))
}

fn serve(library: Library) -> std::io::Result<()> {
    let mut lines = std::io::stdin().lock().lines();
    let mut out = std::io::stdout().lock();
    let Some(first) = lines.next() else {
        return Ok(());
    };
    let parts = match open(&first?, library) {
        Ok((faces, parts)) => {
            let hello = json!({"engine": library.name(), "version": library.version(), "faces": faces, "treats": ["sphere"]});
            writeln!(out, "{hello}")?;
            out.flush()?;
            parts
        }
        Err(error) => return writeln!(out, "{}", json!({ "error": error })),
    };
    for line in lines {
        let query = QueryLine::parse(&line?).and_then(|l| l.query());
        let answer = match query {
            Ok(query) => Answer {
                body: answer(&parts, &query),
                id: query.id,
            },
            Err(error) => Answer {
                id: None,
                body: Body::Error {
                    error: error.to_string(),
                },
            },
        };
        writeln!(out, "{}", answer.to_text())?;
        out.flush()?;
    }
    Ok(())
}

fn main() -> ExitCode {
    let name = std::env::args().nth(1).unwrap_or_default();
    let Some(library) = Library::by_name(&name) else {
        eprintln!("error: no library `{name}`: give truck or curvo");
        return ExitCode::from(2);
    };
    match serve(library) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}
