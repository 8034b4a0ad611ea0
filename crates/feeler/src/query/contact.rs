//! Contacts of a sphere or a half-space.

use super::answer::{
    Accuracy, Contact, ContactAnswer, Contacts, Options, Probe, Separation, Undecided,
};
use super::continuum::is_continuum;
use super::front::Front;
use super::list::List;
use super::objective::Objective;
use super::outcome::{Goal, Outcome, Width};
use super::place::{Centre, Place, bound_contact, make_contact};
use super::search::minimize;
use super::trail::Trail;
use super::{Work, Workspace, inside, one_sphere};
use crate::numeric::{Dd, Enclosure, Real};
use crate::prepare::PreparedBrep;
use crate::trim::Side;
use nalgebra::Point3;
use std::sync::Arc;

/// The floor of full accuracy, relative to the model's size (module docs of the crate).
pub(super) const FULL_FLOOR: f64 = 1.0 / (1u128 << 96) as f64;

/// The separation and contacts of a sphere or half-space.
///
/// Separation of a sphere: the distance `d` of its centre from the union of the trimmed faces less
/// its radius, `d` taken negative where the centre is in material. Of a half-space `n.x <= h`:
/// the least `n.x - h` over the faces. The enclosure is proven (see the module `search`). The depth
/// `-separation` is the depth at the nearest boundary; on a part that is not convex it is not the shortest
/// translation that frees the ball.
///
/// What it allocates: see [`Workspace`].
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
/// It holds some kilobytes for each of at most 128 boxes of patches (some dozens, as a rule).
#[derive(Clone, Debug, Default)]
pub struct Witness {
    /// Of which BREP, where one has answered.
    brep: Option<Arc<()>>,
    trail: Trail,
    front: Front,
}

impl Witness {
    /// Knows of one contact alone, as a place to look first.
    pub fn at(contact: &Contact) -> Self {
        Self {
            trail: Trail::at(contact.face, contact.uv),
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
///
/// What it allocates: see [`Workspace`].
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

#[inline]
fn answer(
    brep: &PreparedBrep,
    probe: &Probe,
    witness: Option<&mut Witness>,
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
    let radius = probe.radius();
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
    searched(brep, probe, witness, (options, width), workspace)
}

/// The same by a search.
#[inline(never)] // What answers without one has no use for its room on the stack.
fn searched(
    brep: &PreparedBrep,
    probe: &Probe,
    mut witness: Option<&mut Witness>,
    (options, width): (&Options, Width),
    workspace: &mut Workspace,
) -> ContactAnswer {
    let radius = probe.radius();
    let objective = match probe {
        Probe::Sphere(s) => Objective::SquaredDistance(s.center),
        Probe::HalfSpace(h) => Objective::Height(h.normal, h.offset),
    };
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
    let center = match probe {
        Probe::Sphere(s) => Some(s.center),
        Probe::HalfSpace(_) => None,
    };
    let hint = witness.as_ref().and_then(|w| w.trail.hint(center));
    let mut goal = Goal {
        width,
        all_below,
        extents: None,
        threshold: None,
        budget: options.node_budget,
        closed: true,
        foot: options.contacts != Contacts::None,
        hint,
    };
    let front = witness.as_deref_mut().map(|w| &mut w.front);
    let front = front.filter(|_| objective.is_squared() && all_below.is_none());
    let mut found = minimize(brep, &objective, goal, &mut workspace.memory, front);
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
        goal.closed = false;
        found = minimize(brep, &objective, goal, &mut workspace.memory, None);
        workspace.work.nodes += found.nodes;
        (separation, target) = settle(&found);
    }
    if let Some(witness) = witness {
        witness.trail.add(found.foot.as_ref(), center);
    }
    // Contacts may be missing where the search for all of them was cut short.
    let cut_short = found.budget_spent && options.contacts == Contacts::All;
    let mut undecided = if separation.bounds.width() <= target {
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
    let (continuum, nodes) = is_continuum(
        brep,
        &objective,
        &found,
        (&goal, options),
        &mut workspace.memory,
    );
    workspace.work.nodes += nodes;
    // Mostly there is one.
    let mut contacts: Vec<Contact> = Vec::with_capacity(1);
    // Where the enclosure holds the prediction, a contact too many is better than one lost.
    if !(separation.bounds.lo > options.prediction) {
        let known = (separation, continuum, material);
        contacts.extend(deepest(brep, probe, options, &found, known));
        if options.contacts == Contacts::All {
            let list = List {
                brep,
                probe,
                options,
                objective: &objective,
                material,
            };
            let (nodes, is_whole) = list.fill(&found, &mut contacts);
            workspace.work.nodes += nodes;
            if !is_whole {
                undecided = undecided.or(Some(Undecided::Budget));
            }
        }
    }
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
    if brep.is_beyond(&point) {
        return Some(false);
    }
    // The root is correctly rounded.
    let distance = squared.floor_f64().max(0.0).sqrt().next_down();
    let kept = |find: &mut dyn FnMut(Point3<f64>) -> Option<bool>| {
        let cells = brep.side_cells()?;
        cells.in_material(&point, distance, find)
    };
    // What either tells is proven: which is asked first makes no difference to the answer.
    if brep.has_side_cells() {
        kept(&mut find).or_else(|| find(point))
    } else {
        find(point).or_else(|| kept(&mut find))
    }
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

/// The deepest contact.
fn deepest(
    brep: &PreparedBrep,
    probe: &Probe,
    options: &Options,
    found: &Outcome,
    (separation, continuum, material): (Separation, bool, Option<bool>),
) -> Option<Contact> {
    let foot = found.foot.as_ref()?;
    let place = Place {
        face: foot.face,
        trim: foot.trim,
        spot: foot.spot,
        uv: foot.uv,
    };
    let centre = Centre {
        in_material: material == Some(true),
        may_touch: !(found.lo > Dd::ZERO),
    };
    let mut c = make_contact(
        brep,
        probe,
        &place,
        separation,
        centre,
        options.accuracy,
        found.rough.as_deref(),
    );
    bound_contact(&mut c, probe, found, brep, continuum);
    Some(c)
}
