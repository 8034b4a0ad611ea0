//! The kernel of this project as an engine.

use super::as_nurbs::as_nurbs;
use super::{Engine, FeelerWay, value_alone};
use feeler::numeric::Enclosure;
use feeler::prepare::PreparedBrep;
use feeler::query::{
    self, Accuracy, ArrivalAnswer, Contact, ContactAnswer, Contacts, Feature, Hit, LineAnswer,
    LineProbe, Motion, Options, OverlapAnswer, Probe, Separation, SideAnswer, Undecided, Unsettled,
    Workspace,
};
use feeler::trim::Side;
use feeler_corpus::{Answer, Ask, Body, Claim, HitLine, Hits, Model, Query, TrimLine, why_at};
use nalgebra::{Point2, Point3};

/// One BREP, and where the numbers of its features start.
#[derive(Debug)]
struct Part {
    brep: PreparedBrep,
    faces: usize,
    edges: usize,
    vertices: usize,
}

/// The kernel of this project.
///
/// With surfaces turned into NURBS its bounds are about the NURBS, which differ from what was asked about by rounding: they are
/// left out of its answers, but for accuracies far coarser than that, and only the separation of a ball or a half-space and its deepest contact are treated. Counts,
/// sides and parameters may rightly be others there.
#[derive(Debug, Default)]
pub struct FeelerEngine {
    parts: Vec<Part>,
    workspace: Workspace,
    way: FeelerWay,
    /// Of surfaces turned into NURBS: how far they are off, in model units, and how many faces stayed native.
    converted: (f64, usize),
    /// What holds where a query says nothing.
    pub defaults: Options,
}

impl FeelerEngine {
    /// An engine that answers about these options where a query says nothing.
    pub fn new(defaults: Options) -> Self {
        Self {
            defaults,
            ..Self::default()
        }
    }

    /// The same without some shortcuts, or with everything turned into NURBS.
    pub fn with(way: FeelerWay) -> Self {
        Self {
            way,
            ..Self::default()
        }
    }

    /// Size of the model: the longest side of its box.
    pub fn size(&self) -> f64 {
        self.parts.iter().fold(0.0, |m, p| p.brep.size().max(m))
    }

    fn faces(&self) -> usize {
        let last = self.parts.last();
        last.map_or(0, |p| p.faces + p.brep.brep().faces().len())
    }

    fn part_of(&self, face: usize) -> Option<(&Part, usize)> {
        let part = self.parts.iter().rev().find(|p| p.faces <= face)?;
        let local = face - part.faces;
        (local < part.brep.brep().faces().len()).then_some((part, local))
    }

    fn no_face(&self, face: usize) -> Body {
        Body::Error {
            error: format!("there is no face {face}: {}", choice(self.faces())),
        }
    }

    fn no_trim(&self, at: TrimLine) -> Body {
        let found = self.part_of(at.face);
        let loops = found.and_then(|(part, local)| {
            let parts = part.brep.brep().parts();
            let loops = parts.faces.get(local)?.loops.as_ref()?;
            Some((parts, loops))
        });
        let error = match loops {
            None => format!("face {} has no loops, and so no trims", at.face),
            Some((parts, loops)) => match loops.get(at.trim_loop) {
                None => format!(
                    "face {} has no loop {}: {}",
                    at.face,
                    at.trim_loop,
                    choice(loops.len())
                ),
                Some(l) => format!(
                    "loop {} of face {} has no trim {}: {}",
                    at.trim_loop,
                    at.face,
                    at.trim,
                    choice(parts.loops[*l].trims.len())
                ),
            },
        };
        Body::Error { error }
    }

    fn contact(&mut self, probe: &Probe, options: &Options) -> ContactAnswer {
        let mut answers = Vec::with_capacity(self.parts.len());
        for part in &self.parts {
            let mut answer = query::contact(&part.brep, probe, options, &mut self.workspace);
            part.name_in_model(&mut answer);
            answers.push(answer);
        }
        if answers.len() == 1
            && let Some(only) = answers.pop()
        {
            return only;
        }
        union(answers, options, self.size(), |c| match probe {
            Probe::Sphere(s) => (c.on_brep - s.center).norm(),
            Probe::HalfSpace(_) => c.separation.value,
        })
    }

    /// What is known of the native BREP from the one turned into NURBS.
    fn as_nurbs(&mut self, probe: &Probe, mut options: Options) -> Body {
        /// Accuracies coarser than this part of the size leave room for how far surfaces move.
        const COARSE: f64 = 1.0 / (1u64 << 30) as f64;
        let size = self.size();
        let coarse = match options.accuracy {
            Accuracy::Length(a) if a > COARSE * size => Some(a),
            _ => None,
        };
        if let Some(a) = coarse {
            options.accuracy = Accuracy::Length(a - 2.0 * ROOM * size);
        }
        about_native(
            Body::from(&self.contact(probe, &options)),
            coarse.is_some(),
            size,
        )
    }

    fn line(&mut self, line: &LineProbe, options: &Options) -> LineAnswer {
        let mut all = LineAnswer {
            hits: Vec::new(),
            crossings: Some(0),
            in_crack: false,
            undecided: None,
            unsettled: None,
        };
        for part in &self.parts {
            let answer = query::line(&part.brep, line, options, &mut self.workspace);
            all.hits.extend(answer.hits.into_iter().map(|h| Hit {
                feature: part.feature(h.feature),
                face: h.face + part.faces,
                ..h
            }));
            all.crossings = all.crossings.zip(answer.crossings).map(|(a, b)| a + b);
            all.in_crack |= answer.in_crack;
            if all.undecided.is_none() {
                all.undecided = answer.undecided;
                all.unsettled = answer.unsettled.map(|u| part.place(u));
            }
        }
        all.hits.sort_by(|a, b| a.t.value.total_cmp(&b.t.value));
        all
    }

    /// With any BREP.
    fn overlap(&mut self, probe: &Probe, options: &Options) -> OverlapAnswer {
        let mut all = OverlapAnswer {
            overlap: Some(false),
            undecided: None,
        };
        for part in &self.parts {
            let one = query::overlap(&part.brep, probe, options, &mut self.workspace);
            match one.overlap {
                Some(true) => return one,
                Some(false) => {}
                None => all = one,
            }
        }
        all
    }

    /// The first arrival at any BREP, with the contacts of all of them then.
    fn arrival(&mut self, probe: &Probe, motion: &Motion, options: &Options) -> ArrivalAnswer {
        let mut first = ArrivalAnswer::default();
        for part in &self.parts {
            let one = query::arrival(&part.brep, probe, motion, options, &mut self.workspace);
            first = first.or_earlier(one);
        }
        let at = first.time.filter(|t| t.bounds.hi.is_finite());
        let (Some(at), 2..) = (at, self.parts.len()) else {
            return first;
        };
        let mut answers = Vec::with_capacity(self.parts.len());
        for part in &self.parts {
            let workspace = &mut self.workspace;
            let time = at.bounds.hi;
            let found =
                query::contact_on_arrival(&part.brep, probe, motion, time, options, workspace);
            let Some(mut found) = found else {
                first.undecided = first.undecided.or(Some(Undecided::Precision));
                continue;
            };
            if options.contacts == Contacts::All {
                first.undecided = first.undecided.or(found.undecided);
            }
            part.name_in_model(&mut found);
            answers.push(found);
        }
        let all = union(answers, options, self.size(), |c| c.separation.value);
        (first.contacts, first.continuum) = (all.contacts, all.continuum);
        first
    }

    /// The hit of least t, which all of them tell; of the answer to a line, only that.
    fn first_hit(&mut self, line: &LineProbe, options: &Options) -> Body {
        let all = self.line(line, options);
        Body::Line {
            hits: all.hits.first().map(HitLine::from).into_iter().collect(),
            crossings: None,
            in_crack: None,
            undecided: why_at(all.undecided, all.unsettled),
        }
    }

    /// A certain hit with any BREP; of the answer to a line, only that.
    fn any_hit(&mut self, line: &LineProbe, options: &Options) -> Body {
        let (mut undecided, mut unsettled) = (None, None);
        let mut hits = Vec::new();
        for part in &self.parts {
            let one = query::any_hit(&part.brep, line, options, &mut self.workspace);
            if let Some(hit) = one.hit {
                hits.push(HitLine::from(&Hit {
                    feature: part.feature(hit.feature),
                    face: hit.face + part.faces,
                    ..hit
                }));
                undecided = None;
                break;
            }
            if undecided.is_none() {
                undecided = one.undecided;
                unsettled = one.unsettled.map(|u| part.place(u));
            }
        }
        Body::Line {
            hits,
            crossings: None,
            in_crack: None,
            undecided: why_at(undecided, unsettled),
        }
    }

    fn side(&self, face: usize, uv: Point2<f64>) -> Option<SideAnswer> {
        let (part, local) = self.part_of(face)?;
        query::side(&part.brep, local, uv)
    }

    /// In material if in that of any BREP.
    fn inside(&mut self, point: Point3<f64>) -> SideAnswer {
        let mut all = SideAnswer {
            side: Some(Side::Outside),
            in_gap: false,
            undecided: None,
        };
        for part in &self.parts {
            let one = query::inside(&part.brep, point, &mut self.workspace);
            match one.side {
                Some(Side::Inside) => return one,
                Some(Side::Boundary) if all.undecided.is_none() => all.side = one.side,
                Some(_) => {}
                None => all = one,
            }
        }
        all
    }
}

/// What there is to ask about instead.
fn choice(count: usize) -> String {
    match count {
        0 => "there are none".to_owned(),
        1 => "there is one, ask about 0".to_owned(),
        n => format!("there are {n}, ask about 0 to {}", n - 1),
    }
}

impl Part {
    /// Counts the faces and features of contacts through the whole model.
    fn name_in_model(&self, answer: &mut ContactAnswer) {
        for c in &mut answer.contacts {
            c.feature = self.feature(c.feature);
            c.face += self.faces;
        }
    }

    fn place(&self, at: Unsettled) -> Unsettled {
        Unsettled {
            face: at.face + self.faces,
            ..at
        }
    }

    fn feature(&self, feature: Feature) -> Feature {
        match feature {
            Feature::Face(i) => Feature::Face(i + self.faces),
            Feature::Edge(i) => Feature::Edge(i + self.edges),
            Feature::Vertex(i) => Feature::Vertex(i + self.vertices),
        }
    }
}

/// The answer for the union of several BREPs: the separation is the minimum. The first contact is the deepest, of that BREP; then come the others in the order
/// of what `away` says, as they do of one BREP: in material what is farther off has less of a separation.
fn union(
    answers: Vec<ContactAnswer>,
    options: &Options,
    size: f64,
    away: impl Fn(&Contact) -> f64,
) -> ContactAnswer {
    /// The floor of full accuracy, as a fraction of the size.
    const FLOOR: f64 = 1.0 / (1u128 << 96) as f64;
    let none = Enclosure::exact(f64::INFINITY);
    let bounds = answers
        .iter()
        .fold(none, |b, a| b.min(&a.separation.bounds));
    let value = answers
        .iter()
        .fold(f64::INFINITY, |v, a| v.min(a.separation.value));
    let mut all = ContactAnswer {
        separation: Separation {
            value: value.clamp(bounds.lo, bounds.hi),
            bounds,
        },
        continuum: false,
        contacts: Vec::new(),
        undecided: None,
    };
    let largest = bounds.lo.abs().max(bounds.hi.abs());
    let widest = match options.accuracy {
        Accuracy::Full => (2.0 * (largest.next_up() - largest)).max(FLOOR * size),
        Accuracy::Length(a) => a,
    };
    let too_wide = bounds.hi - bounds.lo > widest;
    let first = answers.iter().filter_map(|a| a.contacts.first());
    let deepest = first
        .min_by(|a, b| a.separation.value.total_cmp(&b.separation.value))
        .cloned();
    for a in answers {
        // Only those that may be the nearest have a say.
        if a.separation.bounds.lo <= bounds.hi {
            all.continuum |= a.continuum;
            if too_wide {
                all.undecided = all.undecided.or(a.undecided).or(Some(Undecided::Precision));
            }
        }
        all.contacts.extend(a.contacts);
    }
    all.contacts.sort_by(|a, b| away(a).total_cmp(&away(b)));
    if let Some(deepest) = deepest
        && let Some(at) = all.contacts.iter().position(|c| *c == deepest)
    {
        all.contacts[..=at].rotate_right(1);
    }
    if options.contacts == Contacts::Deepest {
        all.contacts.truncate(1);
    }
    all
}

impl Engine for FeelerEngine {
    fn name(&self) -> String {
        let version = env!("CARGO_PKG_VERSION");
        match self.way.to_string().as_str() {
            "" => format!("feeler {version}"),
            way => format!("feeler {version} ({way})"),
        }
    }

    fn open(&mut self, model: &Model) -> Result<(), String> {
        self.parts.clear();
        let (mut faces, mut edges, mut vertices) = (0, 0, 0);
        self.converted = (0.0, 0);
        for brep in &model.breps {
            let own = match self.way.nurbs {
                true => {
                    let found = as_nurbs(brep).map_err(|e| format!("as NURBS: {e}"))?;
                    let (bound, kept) = self.converted;
                    self.converted = (bound.max(found.bound), kept + found.kept);
                    found.brep
                }
                false => brep.clone(),
            };
            self.parts.push(Part {
                brep: PreparedBrep::with_shortcuts(own, self.way.shortcuts),
                faces,
                edges,
                vertices,
            });
            faces += brep.faces().len();
            edges += brep.parts().edges.len();
            vertices += brep.parts().vertices.len();
        }
        Ok(())
    }

    fn memory(&self) -> Option<usize> {
        Some(self.parts.iter().map(|p| p.brep.bytes()).sum())
    }

    fn treats(&self, query: &Query) -> bool {
        let contact = matches!(query.ask, Ask::Contact(_)) && !query.overlap;
        !self.way.nurbs || contact && query.contacts != Some(Contacts::All)
    }

    fn answer(&mut self, query: &Query) -> Answer {
        let options = Options {
            accuracy: query.accuracy.unwrap_or(self.defaults.accuracy),
            prediction: query.prediction.unwrap_or(self.defaults.prediction),
            contacts: query.contacts.unwrap_or(self.defaults.contacts),
            ..self.defaults
        };
        let body = match query.ask {
            Ask::Contact(probe) if query.overlap => {
                let asked = self.overlap(&probe, &options);
                Body::Overlap {
                    overlap: asked.overlap,
                    undecided: asked.undecided.map(|u| u.to_string()),
                }
            }
            Ask::Contact(probe) if self.way.nurbs => self.as_nurbs(&probe, options),
            Ask::Contact(probe) => Body::from(&self.contact(&probe, &options)),
            Ask::Arrival(probe, motion) => Body::from(&self.arrival(&probe, &motion, &options)),
            Ask::Line(line) => match query.hits {
                Hits::All => Body::from(&self.line(&line, &options)),
                Hits::First => self.first_hit(&line, &options),
                Hits::Any => self.any_hit(&line, &options),
            },
            Ask::Side(face, uv) => match self.side(face, uv) {
                Some(side) => Body::Side {
                    side: side.side,
                    in_gap: Some(side.in_gap),
                    undecided: side
                        .undecided
                        .map(|why| format!("face {face}, uv ({:?}, {:?}): {why}", uv.x, uv.y)),
                },
                None => self.no_face(face),
            },
            Ask::Inside(point) => self.inside(point).into(),
            Ask::Split(at) => {
                let found = self
                    .part_of(at.face)
                    .map(|(part, local)| query::split(&part.brep, local, at.trim_loop, at.trim));
                match found {
                    Some(Some(split)) => split.into(),
                    Some(None) => self.no_trim(at),
                    None => self.no_face(at.face),
                }
            }
            Ask::Evaluate(face, uv) => match self.part_of(face) {
                Some((part, local)) => match query::evaluate(&part.brep, local, uv) {
                    Some(found) => found.into(),
                    None => self.no_face(face),
                },
                None => self.no_face(face),
            },
        };
        Answer {
            id: query.id.clone(),
            body: match options.contacts {
                Contacts::None => body.without_continuum(),
                _ => body,
            },
        }
    }
}

/// Turned into NURBS, models move by some 2^-50 of their size: this part of it is far more.
const ROOM: f64 = 1.0 / (1u64 << 40) as f64;

/// The values alone, unless `bounds` are wanted or it is undecided: then there is [`ROOM`] about the bounds.
fn about_native(mut body: Body, bounds: bool, size: f64) -> Body {
    if let Body::Contact {
        separation,
        contacts,
        undecided,
        ..
    } = &mut body
    {
        let alone = |claim: &Claim| match bounds || undecided.is_some() {
            false => value_alone(claim.value),
            true => Claim {
                value: claim.value,
                lo: claim.lo.map(|lo| lo - ROOM * size),
                hi: claim.hi.map(|hi| hi + ROOM * size),
            },
        };
        *separation = alone(separation);
        for c in contacts {
            c.separation = alone(&c.separation);
            (c.position_bound, c.normal_bound) = (None, None);
        }
    }
    body
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::place::tests::unit_cube;
    use feeler::brep::{Brep, BrepBuilder};
    use feeler::query::{LineKind, Sphere};
    use nalgebra::Vector3;
    use std::path::PathBuf;

    /// A square of side 2 about the origin, at a height.
    fn plate(x: f64, height: f64) -> Brep {
        let mut b = BrepBuilder::new();
        let corners = [[-1., -1.], [1., -1.], [1., 1.], [-1., 1.]];
        let corners = corners.map(|[u, v]| b.vertex([x + u, v, height]));
        b.planar_face(&corners).unwrap();
        b.build().unwrap()
    }

    /// A ball comes down on three plates of which two are reached together: both are told, the deepest first, and the third is not.
    #[test]
    fn a_ball_arrives_at_several_breps() {
        // On the borders of the first two, 1 to either side of it, and a hair deeper on the second.
        let hair = 1e-13;
        let model = Model {
            path: PathBuf::from("plates"),
            breps: vec![plate(-2.0, 0.0), plate(2.0, hair), plate(0.0, -8.0)],
        };
        let mut engine = FeelerEngine::new(Options::default());
        engine.open(&model).unwrap();
        let ball = Sphere::new(Point3::new(0.0, 0.0, 2.75), 1.25).unwrap();
        let motion = Motion::new(-Vector3::z(), f64::INFINITY).unwrap();
        let mut ask = |contacts| {
            let options = Options {
                contacts,
                ..Options::default()
            };
            engine.arrival(&Probe::Sphere(ball), &motion, &options)
        };
        let all = ask(Contacts::All);
        // It hangs 0.75 above the edges.
        let time = all.time.unwrap();
        assert!((time.value - 2.0).abs() < 1e-10, "{time:?}");
        assert_eq!(all.undecided, None);
        let faces: Vec<usize> = all.contacts.iter().map(|c| c.face).collect();
        assert_eq!(faces, [1, 0], "{:?}", all.contacts);
        let features: Vec<Feature> = all.contacts.iter().map(|c| c.feature).collect();
        assert!(matches!(features[0], Feature::Edge(4..8)), "{features:?}");
        assert!(matches!(features[1], Feature::Edge(0..4)), "{features:?}");
        let deepest = ask(Contacts::Deepest);
        assert_eq!(deepest.time, all.time);
        let faces: Vec<usize> = deepest.contacts.iter().map(|c| c.face).collect();
        assert_eq!(faces, [1]);
    }

    /// A ball in a cube with a plate above it: the nearest face is the deepest contact, and then what is nearer comes first, the
    /// plate among the faces, though what is farther off in material is deeper.
    #[test]
    fn a_ball_in_material_lists_what_is_nearest_first() {
        let cube = unit_cube();
        let center = Point3::new(0.75, 0.625, 0.5625);
        // To x = 1, y = 1, z = 1, z = 0, y = 0, the plate at z = 1.21875, and x = 0.
        let away = [0.25, 0.375, 0.4375, 0.5625, 0.625, 0.65625, 0.75];
        let ball = Probe::Sphere(Sphere::new(center, 1.0).unwrap());
        let options = Options {
            contacts: Contacts::All,
            ..Options::default()
        };
        for first in [0, 1] {
            let mut breps = vec![cube.clone(), plate(0.0, 1.21875)];
            breps.rotate_left(first);
            let model = Model {
                path: PathBuf::from("cube and plate"),
                breps,
            };
            let mut engine = FeelerEngine::new(Options::default());
            engine.open(&model).unwrap();
            let found = engine.contact(&ball, &options);
            assert_eq!(found.separation.value, -1.25);
            let off: Vec<f64> = { found.contacts.iter() }
                .map(|c| (c.on_brep - center).norm())
                .collect();
            assert_eq!(off, away, "{first}: {:?}", found.contacts);
            assert_eq!(found.contacts[0].separation.value, -1.25);
        }
    }

    /// A line down through three plates: the first hit is the one of least t, of whichever BREP.
    #[test]
    fn the_first_hit_is_of_least_t() {
        let model = Model {
            path: PathBuf::from("plates"),
            breps: vec![plate(0.0, 0.0), plate(0.0, 3.0), plate(0.0, 1.0)],
        };
        let mut engine = FeelerEngine::new(Options::default());
        engine.open(&model).unwrap();
        let mut ask = |origin: Point3<f64>, hits| {
            let line = LineProbe::new(origin, -Vector3::z(), LineKind::Line).unwrap();
            let query = Query {
                id: None,
                ask: Ask::Line(line),
                prediction: None,
                contacts: None,
                hits,
                accuracy: None,
                overlap: false,
            };
            match engine.answer(&query).body {
                Body::Line { hits, .. } => hits.iter().map(|h| h.t.value).collect::<Vec<f64>>(),
                other => panic!("{other:?}"),
            }
        };
        let above = Point3::new(0.5, 0.25, 5.0);
        assert_eq!(ask(above, Hits::All), [2.0, 4.0, 5.0]);
        assert_eq!(ask(above, Hits::First), [2.0]);
        assert_eq!(ask(above, Hits::Any).len(), 1);
        let beside = Point3::new(1.5, 0.25, 5.0);
        assert!(ask(beside, Hits::First).is_empty());
    }
}
