//! Whether the places that an answer names are one place: the point, the face, edge or vertex, and the parameters there.
//!
//! The truth holds points and not parameters, as the same point has others on each face that it is on. So the gate evaluates the
//! face itself where the answer says the point is, with a bound, and asks which side of the face's border that is on.

use crate::cases::Loaded;
use feeler::brep::Brep;
use feeler::nurbs::Surface;
use feeler::prepare::PreparedBrep;
use feeler::query::{Feature, side};
use feeler::trim::Side;
use feeler_corpus::Body;
use nalgebra::{Point2, Point3};
use std::collections::BTreeSet;

/// A place that an answer names.
struct Named {
    point: [f64; 3],
    feature: Option<Feature>,
    uv: Option<[f64; 2]>,
}

/// What is amiss with the places of an answer's contacts or hits, the first of them; `None` if nothing is, or none is named.
pub(crate) fn misplaced(loaded: &Loaded, answer: &Body) -> Option<String> {
    let named: Vec<Named> = match answer {
        Body::Contact { contacts, .. } => { contacts.iter() }
            .map(|c| Named {
                point: c.on_brep,
                feature: c.feature,
                uv: c.uv,
            })
            .collect(),
        Body::Line { hits, .. } => { hits.iter() }
            .map(|h| Named {
                point: h.point,
                feature: h.feature,
                uv: h.uv,
            })
            .collect(),
        _ => return None,
    };
    for (i, named) in named.into_iter().enumerate() {
        let (Some(feature), Some(uv)) = (named.feature, named.uv) else {
            continue;
        };
        if let Err(why) = placed(loaded, &named.point.into(), feature, uv.into()) {
            return Some(format!("place {i} is on {feature:?} at uv {uv:?}: {why}"));
        }
    }
    None
}

/// What is so near to an edge or a vertex, as a part of the model's size, may be said to be on it: the kernel takes a foot within 2^-40 of the size of a vertex for the
/// vertex, and an end of a trim may be off that by as much again.
const NEAR: f64 = 1.0 / (1_u64 << 39) as f64;

/// Whether a point is on a feature, at these parameters of one of its faces.
fn placed(
    loaded: &Loaded,
    point: &Point3<f64>,
    feature: Feature,
    uv: Point2<f64>,
) -> Result<(), String> {
    let (prepared, feature) = local(&loaded.prepared, feature)
        .ok_or_else(|| "the model has none of that number".to_owned())?;
    let brep = prepared.brep();
    let mut nearest = f64::INFINITY;
    let mut why = None;
    for face in faces(brep, feature) {
        let domain = brep.surface(face).domain();
        let is_in = |c: usize| {
            let slack = 8.0 * f64::EPSILON * domain[c].length();
            domain[c].start - slack <= uv[c] && uv[c] <= domain[c].end + slack
        };
        if !(is_in(0) && is_in(1)) {
            why = Some(format!("that is outside of the domain of face {face}"));
            continue;
        }
        let (off, slack) = off(brep.surface(face), point, &uv, loaded.size);
        nearest = nearest.min(off);
        // NaN is no place.
        if !(off <= slack) {
            continue;
        }
        let is_there = match feature {
            Feature::Face(_) => is_on(prepared, face, &uv, slack),
            Feature::Edge(_) | Feature::Vertex(_) => {
                let near = (4.0 * slack).max(NEAR * loaded.size);
                from_border(brep, feature, face, point, near) <= near
            }
        };
        if is_there {
            return Ok(());
        }
        why = Some(match feature {
            Feature::Face(_) => format!("that is trimmed away of face {face}"),
            _ => format!("that is elsewhere on face {face}"),
        });
    }
    Err(why.unwrap_or_else(|| format!("the point is off by {nearest:e}")))
}

/// How far a point is from what an edge or a vertex is on a face: the image of its trims there, or an end of them. What is within `near` is near enough.
fn from_border(brep: &Brep, feature: Feature, face: usize, point: &Point3<f64>, near: f64) -> f64 {
    /// Parts of a trim, in each of which the nearest point is looked for: so many at least, and in each of its spans.
    const PARTS: usize = 64;
    const PARTS_OF_SPAN: usize = 4;
    const STEPS: usize = 80;
    let parts = brep.parts();
    let own = { parts.trims.iter() }
        .filter(|t| parts.loops.get(t.trim_loop).is_some_and(|l| l.face == face));
    let surface = brep.surface(face);
    let mut least = f64::INFINITY;
    for trim in own {
        let Some(curve) = parts.curves2.get(trim.curve) else {
            continue;
        };
        let off = |t: f64| {
            let uv = curve.point(t);
            (surface.point(uv.x, uv.y) - point).norm()
        };
        match feature {
            Feature::Edge(e) if trim.edge == Some(e) => {
                let count = PARTS.max(PARTS_OF_SPAN * curve.breaks().len());
                for k in 0..count {
                    if least <= near {
                        return least;
                    }
                    // By thirds: the distance falls and rises once on so short a part, near its least.
                    let [mut a, mut b] =
                        [k, k + 1].map(|k| trim.span.lerp(k as f64 / count as f64));
                    for _ in 0..STEPS {
                        let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
                        if off(c) < off(d) { b = d } else { a = c }
                    }
                    least = least.min(off(a)).min(off(b));
                }
            }
            Feature::Vertex(v) if trim.vertices.contains(&v) => {
                let (mut start, mut end) = (trim.span.start, trim.span.end);
                if trim.reversed {
                    std::mem::swap(&mut start, &mut end);
                }
                for (vertex, t) in trim.vertices.iter().zip([start, end]) {
                    if *vertex == v {
                        least = least.min(off(t));
                    }
                }
            }
            _ => {}
        }
    }
    least
}

/// The BREP of a feature that is counted through all of a model, and the feature there.
pub(crate) fn local(breps: &[PreparedBrep], feature: Feature) -> Option<(&PreparedBrep, Feature)> {
    let (Feature::Face(mut index) | Feature::Edge(mut index) | Feature::Vertex(mut index)) =
        feature;
    for prepared in breps {
        let parts = prepared.brep().parts();
        let (count, own) = match feature {
            Feature::Face(_) => (parts.faces.len(), Feature::Face(index)),
            Feature::Edge(_) => (parts.edges.len(), Feature::Edge(index)),
            Feature::Vertex(_) => (parts.vertices.len(), Feature::Vertex(index)),
        };
        if index < count {
            return Some((prepared, own));
        }
        index -= count;
    }
    None
}

/// The faces that a feature is on.
pub(crate) fn faces(brep: &Brep, feature: Feature) -> BTreeSet<usize> {
    let parts = brep.parts();
    let is_on = |t: &feeler::brep::TrimCurve| match feature {
        Feature::Face(_) => false,
        Feature::Edge(e) => t.edge == Some(e),
        Feature::Vertex(v) => t.vertices.contains(&v),
    };
    match feature {
        Feature::Face(f) => BTreeSet::from([f]),
        _ => { parts.trims.iter().filter(|t| is_on(t)) }
            .filter_map(|t| Some(parts.loops.get(t.trim_loop)?.face))
            .collect(),
    }
}

/// Corners of a square about a point, its sides' middles, and itself.
const AROUND: [[f64; 2]; 9] = [
    [0.0, 0.0],
    [1.0, 0.0],
    [-1.0, 0.0],
    [0.0, 1.0],
    [0.0, -1.0],
    [1.0, 1.0],
    [1.0, -1.0],
    [-1.0, 1.0],
    [-1.0, -1.0],
];

/// How far a point is from that of a surface at parameters, and how far it may be: by what roundings of the parameters, of both points and of a model of this
/// size come to.
fn off(surface: &Surface, point: &Point3<f64>, uv: &Point2<f64>, size: f64) -> (f64, f64) {
    let (here, bound) = surface.point_with_bound(uv.x, uv.y);
    let mut slack = 0.0_f64;
    for [i, j] in AROUND {
        let near = surface.point(moved(uv.x, i), moved(uv.y, j));
        slack = slack.max((near - here).norm());
    }
    let rounded = 8.0 * f64::EPSILON * point.coords.amax().max(size);
    ((point - here).norm(), 2.0 * (slack + bound) + rounded)
}

/// A parameter, moved up or down by a few units in its last place.
fn moved(x: f64, by: f64) -> f64 {
    x + by * 4.0 * f64::EPSILON * x.abs().max(f64::MIN_POSITIVE)
}

/// Whether parameters, or others whose points are so near, are not trimmed away.
fn is_on(prepared: &PreparedBrep, face: usize, uv: &Point2<f64>, slack: f64) -> bool {
    let at = prepared
        .brep()
        .surface(face)
        .first_derivatives_with_bound(uv.x, uv.y);
    let [u, v] = [at.du, at.dv].map(|d| slack / d.norm());
    AROUND.iter().any(|[i, j]| {
        let step = |x: f64, by: f64, far: f64| match far.is_finite() {
            true => moved(x, by) + by * far,
            // A pole: all that has this parameter is one point.
            false => moved(x, by),
        };
        let near = Point2::new(step(uv.x, *i, u), step(uv.y, *j, v));
        match side(prepared, face, near).and_then(|s| s.side) {
            Some(side) => side != Side::Outside,
            // What cannot be told may be.
            None => true,
        }
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use feeler_corpus::Model;
    use serde_json::json;

    /// A cube of side 1 from the origin.
    pub(crate) fn unit_cube() -> Brep {
        let corners = [
            [0., 0., 0.],
            [1., 0., 0.],
            [1., 1., 0.],
            [0., 1., 0.],
            [0., 0., 1.],
            [1., 0., 1.],
            [1., 1., 1.],
            [0., 1., 1.],
        ];
        let mut b = feeler::brep::BrepBuilder::new();
        let v = corners.map(|p| b.vertex(p));
        for face in [
            [0, 3, 2, 1],
            [4, 5, 6, 7],
            [0, 1, 5, 4],
            [1, 2, 6, 5],
            [2, 3, 7, 6],
            [3, 0, 4, 7],
        ] {
            b.planar_face(&face.map(|i| v[i])).unwrap();
        }
        b.build().unwrap()
    }

    fn cube() -> Loaded {
        crate::cases::loaded(Model {
            path: "cube".into(),
            breps: vec![unit_cube()],
        })
    }

    /// What is said of a hit at this point.
    fn said(
        cube: &Loaded,
        point: [f64; 3],
        feature: &str,
        index: usize,
        uv: Point2<f64>,
    ) -> Option<String> {
        let t = json!({"value": 0.5});
        let hit = json!({
            "t": t, "point": point, "normal": [0.0, 0.0, 1.0], "feature": {feature: index}, "uv": [uv.x, uv.y],
            "tangential": false,
        });
        let hits = vec![serde_json::from_value(hit).expect("a hit")];
        let answer = Body::Line {
            hits,
            crossings: Some(1),
            in_crack: None,
            undecided: None,
        };
        misplaced(cube, &answer)
    }

    #[test]
    fn what_is_elsewhere_is_told() {
        let cube = cube();
        let brep = cube.prepared[0].brep();
        let parts = brep.parts();
        for (f, face) in parts.faces.iter().enumerate() {
            let [u, v] = brep.surface(f).domain();
            let at = |s: f64, t: f64| Point2::new(u.lerp(s), v.lerp(t));
            let of = |uv: &Point2<f64>| <[f64; 3]>::from(brep.surface(f).point(uv.x, uv.y).coords);
            let uv = at(0.25, 0.5);
            let point = of(&uv);
            assert_eq!(said(&cube, point, "face", f, uv), None);
            // Off by some roundings, and by more.
            let by = |d: f64| Point2::new(uv.x + d, uv.y);
            assert_eq!(said(&cube, point, "face", f, by(1e-16)), None);
            for d in [1e-13, -1e-10, 1e-3] {
                assert!(said(&cube, point, "face", f, by(d)).is_some(), "{d}");
            }
            // Another face, none, an edge or a vertex, which are elsewhere.
            let other = (f + 1) % parts.faces.len();
            assert!(said(&cube, point, "face", other, uv).is_some());
            assert!(said(&cube, point, "face", 99, uv).is_some());
            assert!((0..parts.edges.len()).all(|e| said(&cube, point, "edge", e, uv).is_some()));
            assert!((0..8).all(|e| said(&cube, point, "vertex", e, uv).is_some()));
            // On a border: the face and its edge.
            let border = at(0.25, 0.0);
            let point = of(&border);
            assert_eq!(said(&cube, point, "face", f, border), None);
            let own = parts.loops[face.loops.as_ref().unwrap()[0]].trims.iter();
            let edges: BTreeSet<usize> = own.filter_map(|t| parts.trims[*t].edge).collect();
            let there = |e: &usize| said(&cube, point, "edge", *e, border).is_none();
            assert_eq!(edges.iter().filter(|e| there(e)).count(), 1);
            assert!((0..parts.edges.len()).all(|e| edges.contains(&e) || !there(&e)));
            assert!((0..8).all(|v| said(&cube, point, "vertex", v, border).is_some()));
            // At a corner one vertex, and edges.
            let corner = at(0.0, 0.0);
            let point = of(&corner);
            let at_corner = |what: &str, n: usize| {
                (0..n)
                    .filter(|i| said(&cube, point, what, *i, corner).is_none())
                    .count()
            };
            assert_eq!(at_corner("vertex", 8), 1);
            // Its third edge is on two other faces, which may have the same parameters there.
            assert!((2..=3).contains(&at_corner("edge", 12)));
            // Beyond the domain, whichever point a surface has there.
            let beyond = Point2::new(1e200, 1e200);
            assert!(said(&cube, point, "face", f, beyond).is_some());
        }
    }
}
