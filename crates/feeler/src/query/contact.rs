//! Contacts of a sphere or a half-space.

use super::answer::{
    Accuracy, Contact, ContactAnswer, Contacts, Options, Probe, Separation, Undecided,
};
use super::continuum::is_continuum;
use super::front::Front;
use super::local::{Spot, Surroundings};
use super::objective::Objective;
use super::objective::ball_around;
use super::outcome::{FormulaMinimum, Goal, Locus, Outcome, Settled, Source, Width};
use super::place::{Centre, Place, bound_contact, make_contact, place_of, trim_at};
use super::search::minimize;
use super::trail::Trail;
use super::{Work, Workspace, inside, one_sphere};
use crate::numeric::{Ball, Dd, Enclosure, Real};
use crate::prepare::PreparedBrep;
use crate::trim::Side;
use nalgebra::Point3;
use std::sync::Arc;

/// The floor of full accuracy, relative to the model's size (module docs of the crate).
pub(super) const FULL_FLOOR: f64 = 1.0 / (1u128 << 96) as f64;
/// Feet nearer to each other than this times the size are one contact.
const SAME_CONTACT: f64 = 1.0 / (1u64 << 24) as f64;

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
    let (continuum, nodes) = is_continuum(
        brep,
        &objective,
        &found,
        (&goal, options),
        &mut workspace.memory,
    );
    workspace.work.nodes += nodes;
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
    if separation.bounds.lo > options.prediction {
        return Vec::new();
    }
    // Mostly there is one.
    let mut out: Vec<Contact> = Vec::with_capacity(1);
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
            Centre {
                in_material: material == Some(true),
                may_touch: !(found.lo > Dd::ZERO),
            },
            options.accuracy,
            found.rough.as_deref(),
        );
        bound_contact(&mut c, probe, found, brep, continuum);
        out.push(c);
    }
    if options.contacts == Contacts::All {
        let with_deepest = !out.is_empty();
        let list = List {
            brep,
            probe,
            options,
            objective,
            material,
            with_deepest,
        };
        for s in &found.settled {
            if let Some(candidate) = list.of_node(s) {
                list.add(candidate, &mut out);
            }
        }
        for m in &found.formulas {
            list.add(Candidate::of_formula(m), &mut out);
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

/// The separation of the nearer of two places, whichever it is: faces may be a rounding apart at an edge.
fn nearer([a, b]: [Separation; 2], material: Option<bool>) -> Separation {
    let ([a_lo, a_hi], [b_lo, b_hi]) = ([a.bounds.lo, a.bounds.hi], [b.bounds.lo, b.bounds.hi]);
    let (lo, hi, value) = match material {
        Some(false) => (a_lo.min(b_lo), a_hi.min(b_hi), a.value.min(b.value)),
        Some(true) => (a_lo.max(b_lo), a_hi.max(b_hi), a.value.max(b.value)),
        None => (a_lo.min(b_lo), a_hi.max(b_hi), a.value),
    };
    Separation {
        value: value.clamp(lo, hi),
        bounds: Enclosure { lo, hi },
    }
}

/// What may be one of all contacts.
struct Candidate {
    place: Place,
    /// Bounds of `f`.
    range: [Dd; 2],
    /// `f` at the place. Where all of a node is one value up to rounding its minimum is elsewhere on it, and a way falls only if it falls by more.
    value: Ball<Dd>,
}

impl Candidate {
    fn of_formula(m: &FormulaMinimum) -> Self {
        let value = ball_around(m.here);
        let place = Place {
            face: m.face,
            trim: m.trim,
            spot: Locus::Closed { point: m.point },
            uv: m.uv,
        };
        Self {
            place,
            range: m.range,
            value,
        }
    }
}

/// A list of all contacts in the making.
struct List<'a> {
    brep: &'a PreparedBrep,
    probe: &'a Probe,
    options: &'a Options,
    objective: &'a Objective,
    material: Option<bool>,
    /// Whether the first is the deepest of all.
    with_deepest: bool,
}

impl List<'_> {
    /// The local minimum of a settled node, if it has one.
    fn of_node(&self, s: &Settled) -> Option<Candidate> {
        // At the end of the face, or on a crease, a patch alone goes on falling: whether another is lower is tested of every candidate.
        if !(s.local_minimum || s.on_border) {
            return None;
        }
        let brep = self.brep;
        let (mut place, index, mut local) = place_of(brep, s)?;
        let patch = &brep.double_double(place.face).patches[index];
        if let Some(Source::Patch { face, .. }) = s.source {
            // A foot beside the region is none: the border's own is.
            if brep.region(face).side(place.uv).side == Some(Side::Outside) {
                return None;
            }
            let at = [place.uv.x, place.uv.y];
            local = [0, 1].map(|k| patch.maps[k].to_local(Ball::exact(at[k])));
            place.spot = Locus::Patch {
                patch: index,
                local,
                point: None,
            };
        }
        // A piece that passes the border of its patch is known to be on it there, up to a slack: the ball holds the patch's own point.
        for x in &mut local {
            let inside = if x.mid < Dd::ZERO {
                Dd::ZERO
            } else if x.mid > Dd::ONE {
                Dd::ONE
            } else {
                continue;
            };
            x.rad = (x.rad + (x.mid - inside).magnitude()) * (1.0 + 4.0 * f64::EPSILON);
            x.mid = inside;
        }
        // Below: the bound of the node. Above: f at the point itself.
        let f = self.objective.value(&patch.net, local);
        let hi = f.mid + Dd::from(f.rad * (1.0 + 16.0 * f64::EPSILON));
        let more = match s.flat {
            true => (f.mid - s.lo).magnitude(),
            false => 0.0,
        };
        Some(Candidate {
            place,
            range: [s.lo, hi],
            value: Ball {
                mid: f.mid,
                rad: f.rad + more,
            },
        })
    }

    /// Adds one, if it is a minimum, near enough and a new one.
    fn add(&self, candidate: Candidate, out: &mut Vec<Contact>) {
        let Candidate {
            place,
            range,
            value,
        } = candidate;
        let (brep, radius) = (self.brep, self.probe.radius());
        // In material, too, it is the distance that counts.
        let reach = Dd::from(radius) + Dd::from(self.options.prediction);
        let most = if self.options.prediction == f64::INFINITY {
            // Sums and products with it are no numbers.
            Dd::from(f64::INFINITY)
        } else if !self.objective.is_squared() {
            reach
        } else if reach > Dd::ZERO {
            reach * reach
        } else {
            return;
        };
        if value.mid - Dd::from(value.rad) > most {
            return;
        }
        let near = separation(range, self.objective, radius, self.material);
        let c = make_contact(
            brep,
            self.probe,
            &place,
            near,
            Centre {
                in_material: self.material == Some(true),
                may_touch: !(range[0] > Dd::ZERO),
            },
            self.options.accuracy,
            None,
        );
        let apart = SAME_CONTACT * brep.size();
        // The first is the deepest of all: its separation is the answer's.
        let same = out
            .iter()
            .position(|o| (o.on_brep - c.on_brep).norm() <= apart);
        match same {
            Some(0) if self.with_deepest => {}
            // The lower one is the contact's foot. (With the centre in material the nearer one.)
            Some(i) => {
                let both = [out[i].separation, c.separation];
                if nearness(&c, self.material) < nearness(&out[i], self.material) {
                    out[i] = c;
                }
                out[i].separation = nearer(both, self.material);
            }
            None => {
                let around = Surroundings {
                    brep,
                    objective: self.objective,
                };
                let own = Spot {
                    face: place.face,
                    uv: place.uv,
                };
                let trim = place.trim.or_else(|| trim_at(brep, &place));
                if around.is_minimum(own, trim, &c.on_brep, value) {
                    out.push(c);
                }
            }
        }
    }
}
