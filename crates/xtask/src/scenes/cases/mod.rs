//! The suite `cases`: the cases of stress that the field knows, one by one, each beside an easy version of the
//! same question.
//!
//! The id of a query names its case, and how hard it is: `C2 e=1e-9`, or `C2 easy`. `corpora/cases/cases.json` says what
//! each is about, and where those are tested that are no queries.

mod contact;
mod evaluate;
mod field;
mod inclusion;
mod split;

use super::{Scene, Suite};
use feeler::brep::Brep;
use feeler_corpus::{FacePoint, HalfSpaceLine, LineLine, QueryLine, SpacePoint, SphereLine};
use nalgebra::{Point3, Vector3};

/// The scenes under way.
#[derive(Default)]
struct Maker {
    scenes: Vec<Scene>,
}

impl Maker {
    /// A model made for a case.
    fn model(&mut self, name: &str, brep: Brep) {
        self.models(name, vec![brep]);
    }

    /// One of several BREPs.
    fn models(&mut self, name: &str, breps: Vec<Brep>) {
        self.scenes.push(Scene {
            name: name.to_owned(),
            breps,
            queries: Vec::new(),
        });
    }

    /// A question about a model made before, or about one of the corpus's by its path.
    fn ask(&mut self, model: &str, id: &str, query: QueryLine) {
        let query = QueryLine {
            id: Some(id.into()),
            ..query
        };
        match self.scenes.iter_mut().find(|s| s.name == model) {
            Some(scene) => scene.queries.push(query),
            None => self.scenes.push(Scene {
                name: model.to_owned(),
                breps: Vec::new(),
                queries: vec![query],
            }),
        }
    }
}

fn ball(center: impl Into<Point3<f64>>, radius: f64) -> QueryLine {
    QueryLine {
        sphere: Some(SphereLine {
            center: center.into().coords.into(),
            radius,
        }),
        ..QueryLine::default()
    }
}

fn half_space(normal: Vector3<f64>, offset: f64) -> QueryLine {
    QueryLine {
        half_space: Some(HalfSpaceLine {
            normal: normal.into(),
            offset,
        }),
        ..QueryLine::default()
    }
}

fn line(origin: impl Into<Point3<f64>>, direction: [f64; 3]) -> QueryLine {
    QueryLine {
        line: Some(LineLine {
            origin: origin.into().coords.into(),
            direction,
            kind: Default::default(),
        }),
        ..QueryLine::default()
    }
}

fn side(uv: [f64; 2]) -> QueryLine {
    QueryLine {
        side: Some(FacePoint { face: 0, uv }),
        ..QueryLine::default()
    }
}

fn inside(point: [f64; 3]) -> QueryLine {
    QueryLine {
        inside: Some(SpacePoint { point }),
        ..QueryLine::default()
    }
}

fn evaluate_at(uv: [f64; 2]) -> QueryLine {
    QueryLine {
        evaluate: Some(FacePoint { face: 0, uv }),
        ..QueryLine::default()
    }
}

/// `k` ulp further.
fn ulps(x: f64, k: i32) -> f64 {
    (0..k.abs()).fold(x, |x, _| if k > 0 { x.next_up() } else { x.next_down() })
}

pub(crate) fn suite() -> Result<Suite, String> {
    let mut maker = Maker::default();
    evaluate::add(&mut maker)?;
    split::add(&mut maker)?;
    inclusion::add(&mut maker)?;
    contact::add(&mut maker)?;
    field::add(&mut maker)?;
    Ok(Suite {
        name: "cases",
        description: "the field's cases of stress one by one, each beside an easy version of the same question; the id of a query names its case",
        scenes: maker.scenes,
    })
}
