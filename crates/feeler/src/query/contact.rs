//! Contacts of a sphere or a half-space.

use super::answer::{
    Accuracy, Contact, ContactAnswer, Contacts, Feature, Options, Probe, Separation, Undecided,
};
use super::front::Front;
use super::local::{Spot, Surroundings};
use super::objective::Objective;
use super::outcome::{Foot, Goal, Hint, Locus, Outcome, Settled, Source, Width};
use super::search::{QUARTER, minimize};
use super::task::Memory;
use super::{Work, Workspace, inside, one_sphere};
use crate::numeric::{Ball, Dd, Enclosure, Real};
use crate::prepare::closed::V3;
use crate::prepare::{Net, Patch, PreparedBrep, jet};
use crate::trim::{PieceOrigin, Side};
use nalgebra::{Point2, Point3, Vector3};
use std::sync::Arc;

/// The floor of full accuracy, relative to the model's size (module docs of the crate).
pub(super) const FULL_FLOOR: f64 = 1.0 / (1u128 << 96) as f64;
/// The minimum is a continuum when points within max(accuracy, this times the size) of it...
const CONTINUUM_SLACK: f64 = 1.0 / (1u64 << 44) as f64;
/// ...reach farther than this times the size from one foot.
pub(super) const CONTINUUM_REACH: f64 = 1.0 / (1u64 << 12) as f64;
/// Feet nearer to each other than this times the size are one contact.
const SAME_CONTACT: f64 = 1.0 / (1u64 << 24) as f64;
/// A foot nearer to a vertex than this times the size is on the vertex.
const ON_VERTEX: f64 = 1.0 / (1u64 << 40) as f64;

/// The separation and contacts of a sphere or half-space.
///
/// Separation of a sphere: the distance `d` of its centre from the union of the trimmed faces less
/// its radius, `d` taken negative where the centre is in material. Of a half-space `n.x <= h`:
/// the least `n.x - h` over the faces. The enclosure is proven (see the module `search`). The depth
/// `-separation` is the depth at the nearest boundary; on a part that is not convex it is not the shortest
/// translation that frees the ball.
pub fn contact(
    brep: &PreparedBrep,
    probe: &Probe,
    options: &Options,
    workspace: &mut Workspace,
) -> ContactAnswer {
    answer(brep, probe, None, options, workspace)
}

/// What the queries of one probe that moves past one BREP learn from each other: where the last foot was, and which parts of
/// the BREP a ball can come to touch before it has moved on by so much. The caller keeps one for each pair; a new one (`default`) knows nothing.
///
/// It holds some kilobytes for each of at most 64 boxes of patches (a dozen, as a rule).
#[derive(Clone, Debug, Default)]
pub struct Witness {
    /// Of which BREP, where one has answered.
    brep: Option<Arc<()>>,
    hint: Option<Hint>,
    front: Front,
}

impl Witness {
    /// Knows of one contact alone, as a place to look first.
    pub fn at(contact: &Contact) -> Self {
        Self {
            hint: Some(Hint {
                face: contact.face,
                uv: contact.uv,
            }),
            ..Self::default()
        }
    }
}

/// The same, for a probe that has moved a little since it was last asked about with this witness.
///
/// The search looks first where the last foot was. If a ball has moved no farther than its witness knows the BREP around it, only
/// the parts that may have come nearest are looked at (temporal coherence: Ericson, Real-Time Collision Detection, 2.4; the
/// argument is in the module `front`); else all of it, once, from which the witness learns. What is certified is certified for this query,
/// so the bounds hold as those of [`contact`] do and are as narrow; but where in them the value lies may differ in the last digits, as
/// may the foot within its bound. On closed forms there is nothing to look for, and the answer is the same. A witness that
/// is no use, be it of another BREP, costs a descent at most. An answer hangs on the witness as well as on the query.
pub fn contact_from(
    brep: &PreparedBrep,
    probe: &Probe,
    witness: &mut Witness,
    options: &Options,
    workspace: &mut Workspace,
) -> ContactAnswer {
    let own = brep.identity();
    if !witness.brep.as_ref().is_some_and(|b| Arc::ptr_eq(b, own)) {
        if witness.brep.is_some() {
            *witness = Witness::default();
        }
        witness.brep = Some(Arc::clone(own));
    }
    answer(brep, probe, Some(witness), options, workspace)
}

fn answer(
    brep: &PreparedBrep,
    probe: &Probe,
    mut witness: Option<&mut Witness>,
    options: &Options,
    workspace: &mut Workspace,
) -> ContactAnswer {
    // What is no number is no distance within which anything could be.
    let within_none = Options {
        prediction: f64::NEG_INFINITY,
        ..*options
    };
    let options = match options.prediction.is_nan() {
        true => &within_none,
        false => options,
    };
    let (objective, radius) = match probe {
        Probe::Sphere(s) => (Objective::SquaredDistance(s.center), s.radius),
        Probe::HalfSpace(h) => (Objective::Height(h.normal, h.offset), 0.0),
    };
    let floor = FULL_FLOOR * brep.size();
    let width = match options.accuracy {
        Accuracy::Full => Width::Full { floor, radius },
        Accuracy::Length(a) => Width::Length(a),
    };
    workspace.work = Work::default();
    if let Probe::Sphere(ball) = probe
        && let Some(found) = one_sphere::contact(brep, ball, options, width, workspace)
    {
        return found;
    }
    workspace.work = Work::default();
    let all_below = match (options.contacts, probe) {
        (Contacts::All, Probe::Sphere(_)) => {
            // Rounded up: nodes just beyond are sorted out later.
            let reach = (radius + options.prediction).next_up().max(0.0);
            Some((reach * reach).next_up())
        }
        (Contacts::All, Probe::HalfSpace(_)) => Some(options.prediction),
        _ => None,
    };
    let hint = witness.as_ref().and_then(|w| w.hint);
    let search = |closed: bool, memory: &mut Memory, front: Option<&mut Front>| {
        let goal = Goal {
            width,
            all_below,
            threshold: None,
            budget: options.node_budget,
            closed,
            hint,
        };
        minimize(brep, &objective, goal, memory, front)
    };
    let front = witness.as_deref_mut().map(|w| &mut w.front);
    let front = front.filter(|_| objective.is_squared() && all_below.is_none());
    let mut found = search(true, &mut workspace.memory, front);
    workspace.work.nodes += found.nodes;
    // The side matters for a sphere about a closed solid only.
    let material = match probe {
        Probe::Sphere(s) if brep.brep().is_closed() => {
            in_material(brep, s.center, found.lo, workspace)
        }
        _ => Some(false),
    };
    let settle = |found: &Outcome| {
        let separation = separation([found.lo, found.hi], &objective, radius, material);
        let inside = material == Some(true);
        (separation, target_width(width, &separation, radius, inside))
    };
    let (mut separation, mut target) = settle(&found);
    if material.is_some() && found.used_closed && separation.bounds.width() > target {
        // A surface that is not quite what its closed form takes it for, or digits lost next to a focal point.
        found = search(false, &mut workspace.memory, None);
        workspace.work.nodes += found.nodes;
        (separation, target) = settle(&found);
    }
    if let Some(witness) = witness {
        let place = |foot: Foot| Hint {
            face: foot.face,
            uv: foot.uv,
        };
        witness.hint = found.foot.map(place);
    }
    // Contacts may be missing where the search for all of them was cut short.
    let cut_short = found.budget_spent && options.contacts == Contacts::All;
    let undecided = if separation.bounds.width() <= target {
        cut_short.then_some(Undecided::Budget)
    } else if material.is_none() {
        Some(Undecided::Degenerate)
    } else if found.budget_spent {
        Some(Undecided::Budget)
    } else {
        Some(Undecided::Precision)
    };
    if options.contacts == Contacts::None {
        workspace.memory.keep(found);
        return ContactAnswer {
            separation,
            continuum: false,
            contacts: Vec::new(),
            undecided,
        };
    }
    let slack = continuum_slack(brep, options);
    let reach = CONTINUUM_REACH * brep.size();
    let continuum = is_continuum(&found, &objective, slack, reach)
        || (found.left_open && spreads(brep, &found, &objective, slack, reach));
    let mut contacts = contacts(
        brep, probe, options, &found, &objective, separation, continuum, material,
    );
    workspace.work.contacts = contacts.len();
    workspace.memory.keep(found);
    if material.is_none() {
        // The normal may be the opposite one.
        contacts.iter_mut().for_each(|c| c.normal_bound = None);
    }
    ContactAnswer {
        separation,
        continuum,
        contacts,
        undecided,
    }
}

/// How wide the enclosure of a separation may be.
pub(super) fn target_width(
    width: Width,
    separation: &Separation,
    radius: f64,
    material: bool,
) -> f64 {
    let target = width.at(if material {
        // The separation is -d - r, that of the sum of both less r.
        separation.value.abs() + radius
    } else {
        separation.value + radius
    });
    target.max(0.0)
}

/// By how much a distance or height may be larger than the least to count as least.
pub(super) fn continuum_slack(brep: &PreparedBrep, options: &Options) -> f64 {
    let slack = CONTINUUM_SLACK * brep.size();
    match options.accuracy {
        Accuracy::Length(a) => slack.max(a),
        Accuracy::Full => slack,
    }
}

/// Whether a point is in the material of a closed solid, given a lower bound of its squared distance from the faces; `None` where
/// that is undecided.
pub(super) fn in_material(
    brep: &PreparedBrep,
    point: Point3<f64>,
    squared: Dd,
    workspace: &mut Workspace,
) -> Option<bool> {
    let mut find = |p: Point3<f64>| match inside(brep, p, workspace).side {
        Some(Side::Inside) => Some(true),
        Some(Side::Outside | Side::Boundary) => Some(false),
        None => None,
    };
    // The root is correctly rounded.
    let distance = squared.floor_f64().max(0.0).sqrt().next_down();
    let kept = brep.side_cells();
    let kept = kept.and_then(|cells| cells.in_material(&point, distance, &mut find));
    kept.or_else(|| find(point))
}

/// Products lose at most [`TINY`](crate::numeric::TINY), 1e-280, to underflow: of squares below this nothing is left...
const LOST_SQUARE: f64 = 1e-270;
/// ...but that their roots are below this.
const LOST_LENGTH: f64 = 1e-134;

/// The bounds of the separation from those of `f`.
pub(super) fn separation(
    [lo, hi]: [Dd; 2],
    objective: &Objective,
    radius: f64,
    material: Option<bool>,
) -> Separation {
    let r = Dd::from(radius);
    let touches = objective.is_squared() && hi.hi < LOST_SQUARE;
    let ends = |lost: bool| {
        if !objective.is_squared() {
            return (lo, hi);
        }
        // Square roots and differences are off by a unit each, and so is what they are widened by.
        // What is infinite (nothing was found, or nothing is there) stays so.
        let widen = |x: Dd, up: f64| {
            if x.hi.is_finite() {
                x + Dd::from(up * 4.0 * Dd::UNIT * x.hi.abs())
            } else {
                Dd::from(x.hi)
            }
        };
        let less = |x: Dd| if x.hi.is_finite() { x - r } else { x };
        let root = |x: Dd| {
            if x.hi.is_finite() { x.sqrt() } else { x }
        };
        let (mut a, mut b) = (widen(root(lo), -1.0), widen(root(hi), 1.0));
        // What squares this small lost when they underflowed is more than a few units.
        if lost && lo.hi < LOST_SQUARE {
            a = Dd::ZERO;
        }
        if lost && touches {
            b = Dd::from(LOST_LENGTH);
        }
        let (a, b) = match material {
            Some(false) => (less(a), less(b)),
            Some(true) => (less(-b), less(-a)),
            None => (less(-b), less(b)),
        };
        (widen(a, -1.0), widen(b, 1.0))
    };
    // The value is that of what was found: where it touches a little less or more would be as good.
    let (lo, hi, found) = match ends(true) {
        (lo, hi) if touches => (lo, hi, ends(false)),
        (lo, hi) => (lo, hi, (lo, hi)),
    };
    let bounds = Enclosure {
        lo: if lo.hi.is_finite() {
            lo.floor_f64()
        } else {
            lo.hi
        },
        hi: if hi.hi.is_finite() {
            hi.ceil_f64()
        } else {
            hi.hi
        },
    };
    let mid = if lo.hi.is_finite() && hi.hi.is_finite() {
        (found.0 + found.1).half().hi
    } else {
        bounds.mid()
    };
    let value = if bounds.lo <= bounds.hi {
        mid.clamp(bounds.lo, bounds.hi)
    } else {
        mid
    };
    Separation { value, bounds }
}

/// `f` at a distance or height larger by `slack`.
fn raised(found: &Outcome, objective: &Objective, slack: f64) -> f64 {
    if objective.is_squared() {
        let d = found.hi.hi.sqrt() + slack;
        d * d
    } else {
        found.hi.hi + slack
    }
}

fn is_continuum(found: &Outcome, objective: &Objective, slack: f64, reach: f64) -> bool {
    let limit = raised(found, objective, slack);
    found.settled.iter().any(|s| {
        let growth = limit - s.lo.hi;
        growth >= 0.0 && s.extent.length(growth) > reach
    })
}

/// Whether points as low as the minimum are seen farther than `reach` from its foot: where the search stopped at an enclosure
/// that is narrow enough, it did not look for them.
fn spreads(
    brep: &PreparedBrep,
    found: &Outcome,
    objective: &Objective,
    slack: f64,
    reach: f64,
) -> bool {
    /// Directions in which to look.
    const AROUND: [[f64; 2]; 8] = [
        [1.0, 0.0],
        [-1.0, 0.0],
        [0.0, 1.0],
        [0.0, -1.0],
        [0.7, 0.7],
        [-0.7, 0.7],
        [0.7, -0.7],
        [-0.7, -0.7],
    ];
    /// How far, in units of `reach`: the foot itself may be anywhere in its box.
    const FAR: f64 = 2.5;
    let Some(foot) = &found.foot else {
        return false;
    };
    let Locus::Patch { patch, local, .. } = foot.spot else {
        return false;
    };
    let Patch { net, maps, .. } = &brep.double(foot.face).patches[patch];
    let at = local.map(|x| x.mid.hi);
    let limit = raised(found, objective, slack);
    let [here, along_u, along_v] = rough_jet(net, at);
    // A step in the patch that goes `FAR` times the reach, roughly, or to the patch's border.
    AROUND.iter().any(|d| {
        // On a border only along it.
        let open = |k: usize| {
            let out = at[k] <= 0.0 && d[k] < 0.0 || at[k] >= 1.0 && d[k] > 0.0;
            if out { 0.0 } else { d[k] }
        };
        let speed = (along_u * open(0) + along_v * open(1)).norm();
        if !(speed > 0.0) {
            return false;
        }
        let step = (FAR * reach / speed).min(1.0);
        let there = [0, 1].map(|k| (at[k] + step * d[k]).clamp(0.0, 1.0));
        if objective.guide_value(net, there[0], there[1]) > limit {
            return false;
        }
        let uv = [0, 1].map(|k| maps[k].to_native(there[k]));
        let [point, ..] = rough_jet(net, there);
        (point - here).norm() > reach
            && brep.region(foot.face).side(Point2::new(uv[0], uv[1])).side == Some(Side::Inside)
    })
}

/// A point of a net, relative to the net's origin, and its derivatives, in f64.
pub(super) fn rough_jet(net: &Net<f64>, at: [f64; 2]) -> [Vector3<f64>; 3] {
    let [h, s, t] = if jet::fits(net.degree) {
        jet::jet1(net, at[0], at[1])
    } else {
        let j = net.jet(Ball::exact(at[0]), Ball::exact(at[1]));
        [j.value, j.s, j.t].map(|v| v.map(|x| x.mid))
    };
    let point = Vector3::from_fn(|c, _| h[c] / h[3]);
    let along = |d: &[f64; 4]| Vector3::from_fn(|c, _| (d[c] - d[3] * point[c]) / h[3]);
    [point, along(&s), along(&t)]
}

/// A point of the BREP in the search's terms.
pub(super) struct Place {
    pub(super) face: usize,
    pub(super) trim: Option<usize>,
    pub(super) spot: Locus,
    pub(super) uv: Point2<f64>,
}

#[allow(clippy::too_many_arguments)] // One caller; the parts of one answer.
fn contacts(
    brep: &PreparedBrep,
    probe: &Probe,
    options: &Options,
    found: &Outcome,
    objective: &Objective,
    separation: Separation,
    continuum: bool,
    material: Option<bool>,
) -> Vec<Contact> {
    let mut out: Vec<Contact> = Vec::new();
    if separation.bounds.lo > options.prediction {
        return out;
    }
    // Where the enclosure holds the prediction, a contact too many is better than one lost.
    if let Some(foot) = &found.foot {
        let place = Place {
            face: foot.face,
            trim: foot.trim,
            spot: foot.spot,
            uv: foot.uv,
        };
        let mut c = make_contact(
            brep,
            probe,
            &place,
            separation,
            material == Some(true),
            options.accuracy,
        );
        bound_contact(&mut c, found, foot, brep, continuum);
        out.push(c);
    }
    if options.contacts == Contacts::All {
        let with_deepest = !out.is_empty();
        for s in &found.settled {
            other_contact(
                brep,
                probe,
                options,
                objective,
                s,
                material,
                with_deepest,
                &mut out,
            );
        }
        out[usize::from(with_deepest)..].sort_by(|a, b| {
            let by_distance = nearness(a, material).total_cmp(&nearness(b, material));
            by_distance.then(a.feature.cmp(&b.feature))
        });
    }
    out
}

/// What grows with the distance of a contact's foot. In material the nearest has the largest separation; where the side is not
/// known the bounds are those of both, and their upper end is as on the outside.
fn nearness(c: &Contact, material: Option<bool>) -> f64 {
    match material {
        Some(false) => c.separation.value,
        Some(true) => -c.separation.value,
        None => c.separation.bounds.hi,
    }
}

/// Adds the local minimum of a settled node, if it is one and a new one.
#[allow(clippy::too_many_arguments)] // As above.
fn other_contact(
    brep: &PreparedBrep,
    probe: &Probe,
    options: &Options,
    objective: &Objective,
    s: &Settled,
    material: Option<bool>,
    with_deepest: bool,
    out: &mut Vec<Contact>,
) {
    if !s.local_minimum {
        return;
    }
    let Some((mut place, index, mut local)) = place_of(brep, s) else {
        return;
    };
    let patch = &brep.double_double(place.face).patches[index];
    if let Some(Source::Patch { face, .. }) = s.source {
        // A foot beside the region is none: the border's own is.
        if brep.region(face).side(place.uv).side == Some(Side::Outside) {
            return;
        }
        let at = [place.uv.x, place.uv.y];
        local = [0, 1].map(|k| patch.maps[k].to_local(Ball::exact(at[k])));
        place.spot = Locus::Patch {
            patch: index,
            local,
            point: None,
        };
    }
    // Below: the bound of the node. Above: f at the point itself.
    let f = objective.sample(&patch.net, local[0], local[1]).value();
    let hi = f.mid + Dd::from(f.rad * (1.0 + 16.0 * f64::EPSILON));
    let radius = match probe {
        Probe::Sphere(p) => p.radius,
        Probe::HalfSpace(_) => 0.0,
    };
    // In material, too, it is the distance that counts.
    let reach = Dd::from(radius) + Dd::from(options.prediction);
    let most = if !objective.is_squared() {
        reach
    } else if reach > Dd::ZERO {
        reach * reach
    } else {
        return;
    };
    if f.mid - Dd::from(f.rad) > most {
        return;
    }
    let near = separation([s.lo, hi], objective, radius, material);
    let c = make_contact(
        brep,
        probe,
        &place,
        near,
        material == Some(true),
        options.accuracy,
    );
    let apart = SAME_CONTACT * brep.size();
    // The first is the deepest of all: its separation is the answer's.
    let same = out
        .iter()
        .position(|o| (o.on_brep - c.on_brep).norm() <= apart);
    match same {
        Some(0) if with_deepest => {}
        // The lower one is the contact's foot. (With the centre in material the nearer one.)
        Some(i) => {
            if nearness(&c, material) < nearness(&out[i], material) {
                out[i] = c;
            }
        }
        None => {
            let around = Surroundings { brep, objective };
            let own = Spot {
                face: place.face,
                uv: place.uv,
            };
            let trim = place.trim.or_else(|| trim_at(brep, &place));
            // Where all of a node is one value up to rounding, its minimum is elsewhere on it, and a way falls only if it falls by more.
            let f = if s.flat {
                let range = (f.mid - s.lo).magnitude();
                Ball {
                    mid: f.mid,
                    rad: f.rad + range,
                }
            } else {
                f
            };
            if around.is_minimum(own, trim, &c.on_brep, f) {
                out.push(c);
            }
        }
    }
}

/// Where a settled node's minimum is: the place, its patch and the local parameters there.
fn place_of(brep: &PreparedBrep, s: &Settled) -> Option<(Place, usize, [Ball<Dd>; 2])> {
    let (face, trim, patch, local, uv) = match s.source? {
        Source::Patch { face, index } => {
            let maps = &brep.double(face).patches[index].maps;
            let uv = Point2::new(maps[0].to_native(s.at[0]), maps[1].to_native(s.at[1]));
            (face, None, index, s.at.map(Ball::exact), uv)
        }
        Source::Piece { face, index } => {
            let geometry = brep.double_double(face);
            let piece = geometry.piece(index);
            let (p, _) = crate::prepare::curve_jet(&piece.local, Ball::exact(s.at[0]));
            let local = [p[0] / p[2], p[1] / p[2]];
            let maps = &geometry.patches[piece.patch].maps;
            let uv = Point2::new(
                maps[0].to_native(local[0].mid.hi),
                maps[1].to_native(local[1].mid.hi),
            );
            (face, piece.trim, piece.patch, local, uv)
        }
    };
    let place = Place {
        face,
        trim,
        spot: Locus::Patch {
            patch,
            local,
            point: None,
        },
        uv,
    };
    Some((place, patch, local))
}

/// Of the distance of a ball's centre: where a foot is known to so little, the normal is good to nearly all digits of f64.
const SHARP_FOOT: f64 = 1.0 / (1u64 << 44) as f64;

/// The point of a place in f64, where that is known within `enough`, and in the direction of a ball's centre within [`SHARP_FOOT`].
///
/// The place's parameters are rounded, each by half a unit of one at most, besides what they are known to.
fn rough_point(brep: &PreparedBrep, probe: &Probe, place: &Place, enough: f64) -> Option<V3> {
    let Locus::Patch { patch, local, .. } = place.spot else {
        return None;
    };
    let geometry = brep.double(place.face);
    let net = &geometry.patches[patch].net;
    if !jet::fits(net.degree) {
        return None;
    }
    let at = local.map(|x| x.mid.hi.clamp(0.0, 1.0));
    let speeds = geometry.patch_speeds(patch);
    let moved: f64 = (0..2)
        .map(|k| speeds[k] * (f64::EPSILON + local[k].rad))
        .sum();
    let value = jet::point(net, at[0], at[1]);
    let point: [Ball<f64>; 3] = std::array::from_fn(|c| {
        let x = value[c] / value[3] + Ball::exact(net.origin[c]);
        Ball {
            rad: (x.rad + moved) * BOUND_UP,
            ..x
        }
    });
    let enough = match probe {
        Probe::Sphere(s) => {
            let off = Vector3::from_fn(|c, _| s.center[c] - point[c].mid);
            enough.min(SHARP_FOOT * off.norm())
        }
        Probe::HalfSpace(_) => enough,
    };
    let known = point.iter().all(|x| x.rad <= enough);
    known.then(|| point.map(Ball::to_dd))
}

/// The point of a place.
fn point_of(brep: &PreparedBrep, place: &Place) -> V3 {
    match place.spot {
        Locus::Patch {
            patch,
            local,
            point,
        } => {
            let net = &brep.double_double(place.face).patches[patch].net;
            let value = point.or_else(|| jet::fine_value(net, local));
            let value = value.unwrap_or_else(|| net.jet(local[0], local[1]).value);
            std::array::from_fn(|c| value[c] / value[3] + Ball::exact(net.origin[c]))
        }
        Locus::Closed { point, .. } => point,
    }
}

/// A vector along `S_u x S_v` at a place, rounded.
fn face_normal(brep: &PreparedBrep, place: &Place) -> Vector3<f64> {
    match place.spot {
        Locus::Patch { patch, local, .. } => {
            let net = &brep.double_double(place.face).patches[patch].net;
            let jet = net.jet(local[0], local[1]);
            let w = jet.value[3];
            let along = |d: &[Ball<Dd>; 4]| -> Vector3<f64> {
                Vector3::from_fn(|c, _| ((d[c] - d[3] * (jet.value[c] / w)) / w).mid.hi)
            };
            along(&jet.s).cross(&along(&jet.t))
        }
        Locus::Closed { .. } => match brep.closed(place.face) {
            Some(form) => form.surface.normal([place.uv.x, place.uv.y]).into(),
            None => Vector3::zeros(),
        },
    }
}

pub(super) fn make_contact(
    brep: &PreparedBrep,
    probe: &Probe,
    place: &Place,
    separation: Separation,
    material: bool,
    accuracy: Accuracy,
) -> Contact {
    let rough = match accuracy {
        Accuracy::Length(a) => rough_point(brep, probe, place, QUARTER * a),
        Accuracy::Full => None,
    };
    let point = rough.unwrap_or_else(|| point_of(brep, place));
    let on_brep = Point3::new(point[0].mid.hi, point[1].mid.hi, point[2].mid.hi);
    let (normal, on_probe) = match probe {
        Probe::Sphere(s) => {
            let off: V3 = std::array::from_fn(|c| Ball::exact(s.center[c]) - point[c]);
            let to_center = Vector3::from_fn(|c, _| off[c].mid.hi);
            // Within its own error it points nowhere.
            let error = Vector3::from_fn(|c, _| off[c].rad).norm();
            let towards = if to_center.norm() > error {
                if material { -to_center } else { to_center }
            } else {
                let normal = face_normal(brep, place);
                if brep.brep().faces()[place.face].reversed {
                    -normal
                } else {
                    normal
                }
            };
            let normal = unit(towards).or_else(|| {
                let around = normal_around(brep, place)?;
                let reversed = brep.brep().faces()[place.face].reversed;
                unit(if reversed { -around } else { around })
            });
            // Of what has no normal anywhere (a surface that is a curve) any direction is one.
            let normal = normal.unwrap_or_else(Vector3::z);
            (normal, s.center - normal * s.radius)
        }
        Probe::HalfSpace(h) => (-h.normal, on_brep - h.normal * separation.value),
    };
    Contact {
        on_brep,
        on_probe,
        normal,
        separation,
        feature: feature(brep, place, &on_brep),
        face: place.face,
        uv: place.uv,
        position_bound: None,
        normal_bound: None,
    }
}

/// Where a face has no normal (the apex of a cone, a collapsed side): the sum of the unit normals at points around, a
/// little inside the surface's domain. Where these cancel, the first of them: the direction is a choice there, but the
/// contact is not.
fn normal_around(brep: &PreparedBrep, place: &Place) -> Option<Vector3<f64>> {
    /// Points along each side of the domain.
    const AROUND: u8 = 16;
    /// How far inside, as a part of the domain.
    const INSIDE: f64 = 1.0 / (1u64 << 20) as f64;
    /// A sum shorter than this has cancelled but for roundings.
    const CANCELLED: f64 = 1.0 / (1u64 << 40) as f64;
    let surface = brep.brep().surface(place.face);
    let domain = surface.domain();
    let at = [place.uv.x, place.uv.y];
    let inward = |k: usize| {
        let middle = 0.5 * (domain[k].start + domain[k].end);
        at[k] + INSIDE * (middle - at[k])
    };
    let (mut sum, mut first) = (Vector3::zeros(), None);
    for collapsed in 0..2 {
        // The whole of a side is this point where the derivative along it vanishes.
        let mut uv = at;
        uv[1 - collapsed] = inward(1 - collapsed);
        for i in 0..AROUND {
            uv[collapsed] = domain[collapsed].lerp((f64::from(i) + 0.5) / f64::from(AROUND));
            let p = surface.first_derivatives_with_bound(uv[0], uv[1]);
            let near = (p.point - surface.point(at[0], at[1])).norm() <= NEAR_POLE * brep.size();
            if let (true, Some(n)) = (near, unit(p.du.cross(&p.dv))) {
                sum += n;
                first = first.or(Some(n));
            }
        }
    }
    if sum.norm() > CANCELLED {
        return Some(sum);
    }
    // At a corner where one derivative vanishes no side is this point: what is inward of it then.
    first.or_else(|| {
        let [u, v] = [inward(0), inward(1)];
        let beside = [[u, v], [u, at[1]], [at[0], v]];
        beside.iter().find_map(|[u, v]| {
            let p = surface.first_derivatives_with_bound(*u, *v);
            unit(p.du.cross(&p.dv))
        })
    })
}

/// Points taken as neighbours of a pole are nearer to it than this part of the model's size: above what
/// [`normal_around`] goes inside, below what is another place.
const NEAR_POLE: f64 = 1.0 / (1u64 << 12) as f64;

/// The unit vector, scaled first so that tiny ones survive.
fn unit(v: Vector3<f64>) -> Option<Vector3<f64>> {
    let size = v.amax();
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    let v = v / size;
    Some(v / v.norm())
}

fn feature(brep: &PreparedBrep, place: &Place, point: &Point3<f64>) -> Feature {
    let parts = brep.brep().parts();
    let Some(trim) = place.trim.or_else(|| trim_at(brep, place)) else {
        return Feature::Face(place.face);
    };
    let near = ON_VERTEX * brep.size();
    let at_vertex = parts.trims[trim]
        .vertices
        .iter()
        .find(|v| (parts.vertices[**v].point - point).norm() <= near);
    match (at_vertex, parts.trims[trim].edge) {
        (Some(v), _) => Feature::Vertex(*v),
        (None, Some(e)) => Feature::Edge(e),
        (None, None) => Feature::Vertex(parts.trims[trim].vertices[0]),
    }
}

/// The trim that a foot on the border of its region lies on: the one that comes nearest in uv. Only those are looked at whose
/// pieces have the foot near their boxes, if there are any. (A foot on the border of the domain may be beside the
/// trim that bounds the face there, by a rounding or more.)
fn trim_at(brep: &PreparedBrep, place: &Place) -> Option<usize> {
    let region = brep.region(place.face);
    if region.side(place.uv).side != Some(Side::Boundary) {
        return None;
    }
    let parts = brep.brep().parts();
    let at = [place.uv.x, place.uv.y];
    let slack = region.domain().map(|d| NEAR_TRIM * (d.end - d.start));
    let mut near: Vec<usize> = Vec::new();
    for piece in region.pieces() {
        let (PieceOrigin::Trim { trim, .. } | PieceOrigin::Join { trim, .. }) = piece.origin else {
            continue;
        };
        let close =
            |k: usize| piece.hull[k][0] - slack[k] <= at[k] && at[k] <= piece.hull[k][1] + slack[k];
        if close(0) && close(1) && near.last() != Some(&trim) {
            near.push(trim);
        }
    }
    if let [only] = near.as_slice() {
        return Some(*only);
    }
    if near.is_empty() {
        let loops = parts.faces[place.face].loops.as_ref()?;
        near.extend(loops.iter().flat_map(|l| &parts.loops[*l].trims));
    }
    let distance = |t: usize| {
        let trim = &parts.trims[t];
        let curve = &parts.curves2[trim.curve];
        nearest(|s: f64| (curve.point(trim.span.lerp(s)) - place.uv).norm())
    };
    let all = near.iter().map(|t| (distance(*t), *t));
    all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, t)| t)
}

/// A foot nearer to a trim's box than this part of the domain may be on the trim.
const NEAR_TRIM: f64 = 1.0 / (1u64 << 24) as f64;

/// The least value of a function on [0, 1], roughly: the best of some samples, narrowed down.
fn nearest(f: impl Fn(f64) -> f64) -> f64 {
    const SAMPLES: usize = 32;
    const ROUNDS: usize = 40;
    let mut best = (f64::INFINITY, 0.0);
    for k in 0..=SAMPLES {
        let s = k as f64 / SAMPLES as f64;
        let value = f(s);
        if value < best.0 {
            best = (value, s);
        }
    }
    let mut step = 0.5 / SAMPLES as f64;
    for _ in 0..ROUNDS {
        for s in [best.1 - step, best.1 + step] {
            let s = s.clamp(0.0, 1.0);
            let value = f(s);
            if value < best.0 {
                best = (value, s);
            }
        }
        step *= 0.5;
    }
    best.0
}

/// Bounds on foot and normal, where exactly one settled node can hold the minimum.
fn bound_contact(
    c: &mut Contact,
    found: &Outcome,
    foot: &Foot,
    brep: &PreparedBrep,
    continuum: bool,
) {
    if continuum || found.left_open || found.budget_spent {
        return;
    }
    let mut candidates = found.settled.iter().filter(|s| !(s.lo > found.hi));
    let (Some(only), None) = (candidates.next(), candidates.next()) else {
        return;
    };
    // What is left is the foot's own face or curve: it is where its formula says.
    if let (None, Locus::Closed { point, unique }) = (only.source, foot.spot) {
        let apart = (0..3).map(|k| (point[k] - Ball::exact(c.on_brep[k])).magnitude().powi(2));
        if unique {
            set_bound(c, apart.sum::<f64>().sqrt() * BOUND_UP, found);
        }
        return;
    }
    let (Some(spread), Some((place, patch, local))) = (only.spread, place_of(brep, only)) else {
        return;
    };
    let radius = spread.radius(found.hi);
    if place.face != foot.face {
        return;
    }
    let geometry = brep.double(place.face);
    let net = &geometry.patches[patch].net;
    // The place is rounded, twice at most, and so moved by this much.
    let at = local.map(|x| x.mid.hi.clamp(0.0, 1.0));
    let [along_u, along_v] = geometry.patch_speeds(patch);
    let rounded = 2.0 * f64::EPSILON * (along_u + along_v);
    let value = if jet::fits(net.degree) {
        jet::point(net, at[0], at[1])
    } else {
        let at = at.map(Ball::<f64>::exact);
        net.jet(at[0], at[1]).value
    };
    let mut apart = 0.0;
    for k in 0..3 {
        let x = value[k] / value[3] + Ball::exact(net.origin[k]);
        apart += (x - Ball::exact(c.on_brep[k])).magnitude().powi(2);
    }
    set_bound(c, (radius + rounded + apart.sqrt()) * BOUND_UP, found);
}

/// A bound is off by a few roundings.
const BOUND_UP: f64 = 1.0 + 16.0 * f64::EPSILON;

fn set_bound(c: &mut Contact, bound: f64, found: &Outcome) {
    if !bound.is_finite() {
        return;
    }
    c.position_bound = Some(bound);
    let distance = found.lo.hi.max(0.0).sqrt();
    // The angle at the centre: sin(angle) <= bound / distance, and asin x <= 1.6 x.
    if distance > bound {
        c.normal_bound = Some(1.6 * bound / distance + 4.0 * f64::EPSILON);
    }
}
