//! The algorithms of the thesis that the project starts from, as published: what its own answers are held against.
//!
//! A. Östman, *Collision detection for trimming curves and BREPs*, Umeå University, 2014. Nothing else in the project uses
//! this module, and nothing of it should be copied: it is here to be compared with.
//!
//! | algorithm | here |
//! |---|---|
//! | 2: Newton for the contact of a sphere or plane with a face, from the middle of the domain | [`newton::foot`] |
//! | 2 for a line: Newton on `S(u, v) = o + t d` | [`newton::hit`] |
//! | 3: derivative roots of a trim curve: Newton from the middle of each interval, split at the root found; at most `order` roots | [`trims::pieces`] |
//! | 4: parity of a ray in uv, by Newton from the middle of each monotone piece | [`trims::inside`] |
//! | 5: where the foot is outside the trims, search along them, derivatives by finite differences | [`along::nearest`] |
//! | future work: the best of 100 sampled starts (10 by 10) instead of the middle | [`newton::start`] |
//!
//! # What is reconstruction
//! The methods, their starts and limits are known; the text and the program were not at hand. These are ours:
//! all tolerances and counts of steps; that a step out of a closed direction comes in at the other side, and one out of an open
//! direction ends the search; that a singular Jacobian is solved in the least-squares sense (a plane along a cylinder); that the
//! intervals of algorithm 3 are first the spans of the curve in NURBS form; that in algorithm 4 the start of a piece belongs to
//! it and its end does not; that algorithm 5 also runs where Newton
//! finds nothing; that ends of pieces are candidates in it; that the side is that of the face's normal at the foot,
//! of several feet equally near the one whose normal points along the gap; that straight joins of
//! gaps in loops are not known.
//!
//! # What is known to go wrong
//! Newton finds a stationary point near its start, if any: perhaps the farthest one, perhaps none; one hit of a line a face; no
//! more derivative roots than the order; rays that touch a curve count by roundings. Tests show each.

mod along;
mod newton;
mod trims;

use super::{Engine, value_alone};
use feeler::nurbs::Surface;
use feeler::query::{Contacts, Feature, LineKind, LineProbe, Probe};
use feeler::trim::Side;
use feeler_corpus::{Answer, Ask, Body, ContactLine, HitLine, Hits, Model, Query};
use nalgebra::{Point2, Point3, Vector3};
use std::sync::Arc;
use trims::Piece;

#[cfg(test)]
mod tests;

/// Feet whose distances differ by less than this part of the size are equally near.
const EQUALLY_NEAR: f64 = 1e-9;

/// What is looked for on a face.
#[derive(Clone, Copy, Debug)]
enum Target {
    /// The point nearest to this.
    Point(Point3<f64>),
    /// The point least along this.
    Along(Vector3<f64>),
}

impl Target {
    /// Half the squared distance, or the height.
    fn value(&self, p: &Vector3<f64>) -> f64 {
        match self {
            Self::Point(c) => 0.5 * (p - c.coords).norm_squared(),
            Self::Along(n) => n.dot(p),
        }
    }
}

#[derive(Clone, Debug)]
struct Face {
    surface: Surface,
    reversed: bool,
    /// Monotone pieces of all trims; none where the whole domain counts.
    pieces: Option<Vec<Piece>>,
}

impl Face {
    fn inside(&self, uv: Point2<f64>) -> bool {
        self.pieces.as_ref().is_none_or(|p| trims::inside(p, uv))
    }

    /// The unit normal; `None` at a pole.
    fn normal(&self, uv: Point2<f64>) -> Option<Vector3<f64>> {
        let d = self.surface.derivatives(uv.x, uv.y, 1);
        let n = d.get(1, 0).cross(&d.get(0, 1)).try_normalize(0.0)?;
        Some(if self.reversed { -n } else { n })
    }

    fn point(&self, uv: Point2<f64>) -> Point3<f64> {
        self.surface.point(uv.x, uv.y)
    }

    /// Algorithms 2, 4 and 5: where on the face.
    fn foot(&self, target: &Target, starts: usize) -> Option<Point2<f64>> {
        let start = newton::start(&self.surface, starts, |p| target.value(&p.coords));
        match newton::foot(&self.surface, target, start) {
            Some(uv) if self.inside(uv) => Some(uv),
            found => match &self.pieces {
                Some(pieces) => along::nearest(&self.surface, pieces, target),
                // No trims to search: the foot as it is.
                None => found,
            },
        }
    }
}

/// The algorithms of A. Östman's thesis of 2014, reconstructed: Newton's method from the middle of each face, parity and search
/// along trims likewise. Without bounds, and known to take a stationary point for the nearest one; what is
/// reconstruction, and what goes wrong, stands in the module's text and tests. Cost: every query visits every face, and
/// every trim of those whose foot is outside.
#[derive(Debug)]
pub struct ThesisEngine {
    starts: usize,
    faces: Vec<Face>,
    size: f64,
}

/// A foot of a probe.
#[derive(Clone, Copy, Debug)]
struct Found {
    face: usize,
    uv: Point2<f64>,
    on_brep: Point3<f64>,
    /// From BREP to probe.
    normal: Vector3<f64>,
    /// Signed distance, or height.
    value: f64,
    /// How nearly the gap runs along the face's normal, 0 to 1.
    along: f64,
}

impl ThesisEngine {
    /// The engine with Newton from the middle (1), or from the best of so many starts (a square number).
    pub fn new(starts: usize) -> Self {
        Self {
            starts,
            faces: Vec::new(),
            size: 0.0,
        }
    }

    fn nearest(&self, center: &Point3<f64>) -> Option<Found> {
        let target = Target::Point(*center);
        let mut best: Option<Found> = None;
        for (i, face) in self.faces.iter().enumerate() {
            let Some(uv) = face.foot(&target, self.starts) else {
                continue;
            };
            let on_brep = face.point(uv);
            let gap = center - on_brep;
            let distance = gap.norm();
            let normal = face.normal(uv).unwrap_or_else(Vector3::zeros);
            let height = gap.dot(&normal);
            let below = height < 0.0;
            let found = Found {
                face: i,
                uv,
                on_brep,
                normal: match gap.try_normalize(0.0) {
                    Some(way) if below => -way,
                    Some(way) => way,
                    None => normal,
                },
                value: if below { -distance } else { distance },
                along: if distance > 0.0 {
                    height.abs() / distance
                } else {
                    1.0
                },
            };
            let better = best.is_none_or(|b| {
                let nearer = distance - b.value.abs();
                let same = nearer.abs() <= EQUALLY_NEAR * self.size;
                if same {
                    found.along > b.along
                } else {
                    nearer < 0.0
                }
            });
            if better {
                best = Some(found);
            }
        }
        best
    }

    fn lowest(&self, n: &Vector3<f64>) -> Option<Found> {
        let target = Target::Along(*n);
        let one = |(i, face): (usize, &Face)| {
            let uv = face.foot(&target, self.starts)?;
            let on_brep = face.point(uv);
            Some(Found {
                face: i,
                uv,
                on_brep,
                normal: -n,
                value: n.dot(&on_brep.coords),
                along: 1.0,
            })
        };
        let all = self.faces.iter().enumerate().filter_map(one);
        all.min_by(|a, b| a.value.total_cmp(&b.value))
    }

    fn contact(&self, probe: &Probe, query: &Query) -> Option<Body> {
        let (found, value, on_probe) = match probe {
            Probe::Sphere(s) => {
                let found = self.nearest(&s.center)?;
                let on_probe = s.center - found.normal * s.radius;
                (found, found.value - s.radius, on_probe)
            }
            Probe::HalfSpace(h) => {
                let found = self.lowest(&h.normal)?;
                let value = found.value - h.offset;
                (found, value, found.on_brep - h.normal * value)
            }
        };
        if query.overlap {
            return Some(Body::Overlap {
                overlap: Some(value < 0.0),
                undecided: None,
            });
        }
        let mut contacts = Vec::new();
        let wanted = query.contacts != Some(Contacts::None);
        if wanted && value <= query.prediction.unwrap_or(0.0) {
            contacts.push(ContactLine {
                on_brep: found.on_brep.coords.into(),
                on_probe: on_probe.coords.into(),
                normal: found.normal.into(),
                separation: value_alone(value),
                feature: Some(Feature::Face(found.face)),
                uv: Some(found.uv.coords.into()),
                position_bound: None,
                normal_bound: None,
                normal_is_choice: false,
            });
        }
        Some(Body::Contact {
            separation: value_alone(value),
            continuum: None,
            contacts,
            undecided: None,
        })
    }

    /// At most one hit a face.
    fn line(&self, line: &LineProbe, wanted: Hits) -> Body {
        let mut hits = Vec::new();
        for (i, face) in self.faces.iter().enumerate() {
            let Some((uv, t)) = newton::hit(&face.surface, line, self.starts) else {
                continue;
            };
            let counts = match line.kind {
                LineKind::Line => true,
                LineKind::Ray => t >= 0.0,
                LineKind::Segment => (0.0..=1.0).contains(&t),
            };
            if counts && face.inside(uv) {
                hits.push(HitLine {
                    t: value_alone(t),
                    t_end: None,
                    point: (line.origin + line.direction * t).coords.into(),
                    normal: face.normal(uv).unwrap_or_else(Vector3::zeros).into(),
                    feature: Some(Feature::Face(i)),
                    uv: Some(uv.coords.into()),
                    tangential: None,
                });
            }
        }
        hits.sort_by(|a, b| a.t.value.total_cmp(&b.t.value));
        if wanted != Hits::All {
            hits.truncate(1);
        }
        Body::Line {
            hits,
            crossings: None,
            in_crack: None,
            undecided: None,
        }
    }

    fn side(&self, face: usize, uv: Point2<f64>) -> Body {
        let Some(face) = self.faces.get(face) else {
            return Body::Error {
                error: format!(
                    "there is no face {face}: there are {}, counted from 0",
                    self.faces.len()
                ),
            };
        };
        Body::Side {
            side: Some(match face.inside(uv) {
                true => Side::Inside,
                false => Side::Outside,
            }),
            in_gap: None,
            undecided: None,
        }
    }
}

impl Engine for ThesisEngine {
    fn name(&self) -> String {
        match self.starts {
            1 => "thesis (2014)".to_owned(),
            n => format!("thesis (2014), {n} starts"),
        }
    }

    fn open(&mut self, model: &Model) -> Result<(), String> {
        self.faces.clear();
        for brep in &model.breps {
            let parts = brep.parts();
            let curves: Vec<_> = parts.curves2.iter().cloned().map(Arc::new).collect();
            for face in brep.faces() {
                let pieces = face.loops.as_ref().map(|loops| {
                    let trims = loops.iter().flat_map(|l| &parts.loops[*l].trims);
                    let trims = trims.map(|t| &parts.trims[*t]);
                    trims
                        .flat_map(|t| trims::pieces(&curves[t.curve], t.span))
                        .collect()
                });
                self.faces.push(Face {
                    surface: parts.surfaces[face.surface].clone(),
                    reversed: face.reversed,
                    pieces,
                });
            }
        }
        self.size = crate::model_size(model);
        Ok(())
    }

    fn answer(&mut self, query: &Query) -> Answer {
        let body = match &query.ask {
            Ask::Contact(probe) => self.contact(probe, query).unwrap_or_else(|| Body::Error {
                error: "Newton's method found nothing on any face".into(),
            }),
            Ask::Line(line) => self.line(line, query.hits),
            Ask::Side(face, uv) => self.side(*face, *uv),
            Ask::Arrival(..) | Ask::Inside(_) | Ask::Evaluate(..) | Ask::Split(_) => Body::Error {
                error: "not treated here".into(),
            },
        };
        Answer {
            id: query.id.clone(),
            body,
        }
    }

    fn treats(&self, query: &Query) -> bool {
        match query.ask {
            Ask::Contact(_) => query.contacts != Some(Contacts::All),
            Ask::Line(_) | Ask::Side(..) => true,
            Ask::Arrival(..) | Ask::Inside(_) | Ask::Evaluate(..) | Ask::Split(_) => false,
        }
    }
}
