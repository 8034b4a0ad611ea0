//! Separations against exact points of the faces.
//!
//! A claim that the distance is at least `lo` is refuted by one point of a trimmed face that is nearer, exactly. Candidates are found
//! in f64: samples of each face and of its trims, the best of them led downhill, and the feet that the kernel reports. Where one is
//! no farther than the claim up to rounding, its parameters are taken as they are, the region is asked exactly whether it
//! has them, and the point is evaluated exactly.

use super::{Effort, Found, Subject, agree_in_space, options, radius, second_of};
use feeler::numeric::{Dyadic, Enclosure};
use feeler::nurbs::Surface;
use feeler::query::{
    self, Accuracy, Contact, ContactAnswer, Contacts, Options, Probe, Sphere, Witness,
};
use feeler::trim::Side;
use feeler_corpus::Query;
use feeler_oracle::TruthEnclosure;
use feeler_oracle::second::{self, Bound};
use nalgebra::{Point3, Vector3};

/// Along each side of a face's domain.
const SAMPLES: usize = 7;
/// Along each trim.
const ON_TRIM: usize = 9;
/// Of the faces and of their trims.
const MOST: usize = 12;
/// Of the candidates, those that are led downhill.
pub(super) const LED: usize = 3;
/// Relative room within which a candidate is worth exact arithmetic.
pub(super) const NEAR: f64 = 1e-13;

pub(super) fn dyadic(x: f64) -> Dyadic {
    Dyadic::from_f64(x).unwrap_or(Dyadic::ZERO)
}

pub(super) fn square(x: &Dyadic) -> Dyadic {
    x * x
}

pub(super) fn larger(a: Dyadic, b: Dyadic) -> Dyadic {
    if a < b { b } else { a }
}

/// What is minimised: half the squared distance, from a point or from its way, or the height.
pub(super) enum Goal {
    Distance(Point3<f64>),
    Height(Vector3<f64>, f64),
    /// From the points `from + t velocity`, t from 0 until some time.
    Swept {
        from: Point3<f64>,
        velocity: Vector3<f64>,
        until: f64,
    },
}

impl Goal {
    fn of(probe: &Probe) -> Self {
        match probe {
            Probe::Sphere(s) => Self::Distance(s.center),
            Probe::HalfSpace(h) => Self::Height(h.normal, h.offset),
        }
    }

    /// Distance or height, about.
    fn value(&self, p: &Point3<f64>) -> f64 {
        match self {
            Self::Distance(c) => (p - c).norm(),
            Self::Height(n, h) => n.dot(&p.coords) - h,
            Self::Swept { .. } => self.across(p).norm(),
        }
    }

    /// When what moves is nearest to a point, about; 0 for what does not.
    pub(super) fn time(&self, p: &Point3<f64>) -> f64 {
        let Self::Swept {
            from,
            velocity,
            until,
        } = self
        else {
            return 0.0;
        };
        let time = velocity.dot(&(p - from)) / velocity.norm_squared();
        if time.is_nan() {
            0.0
        } else {
            time.clamp(0.0, *until)
        }
    }

    /// From what is measured from to a point, about; the direction of heights.
    fn across(&self, p: &Point3<f64>) -> Vector3<f64> {
        match self {
            Self::Distance(c) => p - c,
            Self::Height(n, _) => *n,
            Self::Swept { from, velocity, .. } => p - (from + velocity * self.time(p)),
        }
    }

    /// Not below the squared distance, or the height, of a point in this box.
    pub(super) fn most(&self, at: &[TruthEnclosure; 3]) -> Dyadic {
        match self {
            Self::Distance(c) => most_squared(at, &[c.x, c.y, c.z].map(dyadic)),
            Self::Height(n, h) => &highest(at, n) - &dyadic(*h),
            Self::Swept { from, velocity, .. } => {
                let about = at.each_ref().map(|x| x.lo.approximate());
                let time = dyadic(self.time(&about.into()));
                most_squared(at, &moved(from, velocity, &time))
            }
        }
    }
}

/// Where what starts at a point and moves is at a time, exactly.
pub(super) fn moved(from: &Point3<f64>, velocity: &Vector3<f64>, time: &Dyadic) -> [Dyadic; 3] {
    [0, 1, 2].map(|i| &dyadic(from[i]) + &(&dyadic(velocity[i]) * time))
}

/// Not below the squared distance of a point in this box from a point.
pub(super) fn most_squared(at: &[TruthEnclosure; 3], from: &[Dyadic; 3]) -> Dyadic {
    (0..3).fold(Dyadic::ZERO, |sum, i| {
        let ends = [&at[i].lo, &at[i].hi].map(|x| square(&(x - &from[i])));
        let [a, b] = ends;
        &sum + &larger(a, b)
    })
}

/// Not below the height of a point in this box along a direction.
pub(super) fn highest(at: &[TruthEnclosure; 3], normal: &Vector3<f64>) -> Dyadic {
    (0..3).fold(Dyadic::ZERO, |sum, i| {
        let n = dyadic(normal[i]);
        &sum + &larger(&at[i].lo * &n, &at[i].hi * &n)
    })
}

/// What is claimed not to be passed: the distance (never negative) or the height.
struct Claim {
    exact: Dyadic,
    about: f64,
    squared: bool,
}

impl Claim {
    /// Of an enclosure of the separation; none where it claims nothing.
    fn of(probe: &Probe, bounds: &Enclosure) -> Option<Self> {
        if matches!(probe, Probe::HalfSpace(_)) {
            return bounds.lo.is_finite().then(|| Self {
                exact: dyadic(bounds.lo),
                about: bounds.lo,
                squared: false,
            });
        }
        let r = radius(probe);
        let outside = Dyadic::from_f64(bounds.lo).map(|lo| &lo + &dyadic(r));
        let inside = Dyadic::from_f64(bounds.hi).map(|hi| &(-&hi) - &dyadic(r));
        let mut at_least = [outside, inside].into_iter().flatten();
        let exact = at_least.find(|d| d.signum() > 0)?;
        Some(Self {
            about: exact.approximate(),
            exact,
            squared: true,
        })
    }

    fn is_near(&self, value: f64, size: f64) -> bool {
        value <= self.about + NEAR * (self.about.abs() + size)
    }

    fn is_passed(&self, most: &Dyadic) -> bool {
        if self.squared {
            *most < square(&self.exact)
        } else {
            *most < self.exact
        }
    }
}

/// A place to try.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) face: usize,
    pub(super) uv: [f64; 2],
    pub(super) value: f64,
}

pub(super) fn contact(
    subject: &mut Subject<'_>,
    query: &Query,
    probe: &Probe,
    effort: Effort,
) -> Found {
    let asked = options(query);
    let found = query::contact(&subject.prepared, probe, &asked, &mut subject.workspace);
    let size = subject.prepared.size();
    sound(&found, &asked, probe, subject.scene.brep.is_closed(), size)?;
    let claim = Claim::of(probe, &found.separation.bounds);
    if let Some(claim) = &claim {
        refuted(subject, probe, claim, &found)?;
    }
    for c in &found.contacts {
        foot(probe, c)?;
    }
    among_themselves(subject, probe, &asked, &found)?;
    if effort == Effort::Full {
        by_second(subject, probe, &found)?;
    }
    Ok(())
}

/// What holds of any answer.
fn sound(a: &ContactAnswer, asked: &Options, probe: &Probe, closed: bool, size: f64) -> Found {
    let b = a.separation.bounds;
    let value = a.separation.value;
    if !(b.lo <= value && value <= b.hi) {
        return Err(format!(
            "value {value:e} is not in [{:e}, {:e}]",
            b.lo, b.hi
        ));
    }
    /// The floor of full accuracy, as a part of the size.
    const FLOOR: f64 = 1.0 / (1u128 << 96) as f64;
    let largest = b.lo.abs().max(b.hi.abs());
    let widest = match asked.accuracy {
        Accuracy::Full => (2.0 * (largest.next_up() - largest)).max(FLOOR * size),
        Accuracy::Length(length) => length,
    };
    // The difference of the ends is rounded.
    if a.undecided.is_none() && (b.hi - b.lo).next_down() > widest {
        return Err(format!(
            "decided, but [{:e}, {:e}] is wider than {widest:e}",
            b.lo, b.hi
        ));
    }
    if matches!(probe, Probe::Sphere(_)) && !closed && b.hi < -radius(probe) {
        return Err(format!("{:e} inside an open sheet", b.hi));
    }
    // The nearest first, also where the centre is in material, as far as the enclosures tell.
    let nearness = |bounds: &Enclosure| {
        let (lo, hi) = (bounds.lo, bounds.hi);
        match probe {
            Probe::HalfSpace(_) => [lo, hi],
            Probe::Sphere(s) => match [lo + s.radius, hi + s.radius] {
                [lo, hi] if lo >= 0.0 => [lo, hi],
                [lo, hi] if hi <= 0.0 => [-hi, -lo],
                [lo, hi] => [0.0, hi.max(-lo)],
            },
        }
    };
    // Of the sums with the radius.
    let room = 16.0 * f64::EPSILON * (radius(probe) + value.abs() + size);
    let mut pairs = a.contacts.windows(2);
    let of = |c: &Contact| nearness(&c.separation.bounds);
    if pairs.any(|w| of(&w[1])[1] < of(&w[0])[0] - room) {
        return Err("contacts that are not in order".to_owned());
    }
    for c in &a.contacts {
        if !((c.normal.norm() - 1.0).abs() <= 1e-12) {
            return Err(format!("a normal of length {:e}", c.normal.norm()));
        }
        // In material the farther contacts have the lower separations.
        if of(c)[1] < nearness(&b)[0] - room {
            return Err(format!(
                "a contact in [{:e}, {:e}], nearer than all the separation may be, [{:e}, {:e}]",
                c.separation.bounds.lo, c.separation.bounds.hi, b.lo, b.hi
            ));
        }
    }
    if asked.contacts == Contacts::None && !a.contacts.is_empty() {
        return Err("contacts that were not asked for".to_owned());
    }
    Ok(())
}

/// A foot stands as far from the centre, or as high, as its separation says, up to the bound on its place: exactly.
fn foot(probe: &Probe, c: &Contact) -> Found {
    let Some(reach) = c.position_bound.and_then(Dyadic::from_f64) else {
        return Ok(());
    };
    let bounds = c.separation.bounds;
    let (Some(lo), Some(hi)) = (Dyadic::from_f64(bounds.lo), Dyadic::from_f64(bounds.hi)) else {
        return Ok(());
    };
    let at = [0, 1, 2].map(|i| TruthEnclosure {
        lo: dyadic(c.on_brep[i]),
        hi: dyadic(c.on_brep[i]),
    });
    let value = Goal::of(probe).most(&at);
    let fits = match probe {
        Probe::HalfSpace(_) => {
            // |n| <= 1 + 2^-50.
            let reach = &reach * &dyadic(1.0 + 4.0 * f64::EPSILON);
            &lo - &reach <= value && value <= &hi + &reach
        }
        Probe::Sphere(s) => {
            let r = dyadic(s.radius);
            let (lo, hi) = (&lo + &r, &hi + &r);
            let farthest = &larger(hi.clone(), -&lo) + &reach;
            let nearest = &larger(lo, -&hi) - &reach;
            let high = value <= square(&farthest);
            high && (nearest.signum() <= 0 || square(&nearest) <= value)
        }
    };
    if fits {
        Ok(())
    } else {
        Err(format!(
            "the foot {:?} within {:e} is not at the separation [{:e}, {:e}]",
            c.on_brep,
            reach.approximate(),
            bounds.lo,
            bounds.hi
        ))
    }
}

/// Answers to the same question cannot be disjoint.
fn among_themselves(
    subject: &mut Subject<'_>,
    probe: &Probe,
    asked: &Options,
    found: &ContactAnswer,
) -> Found {
    let b = found.separation.bounds;
    let (brep, workspace) = (&subject.prepared, &mut subject.workspace);
    let apart = |what: &str, other: &Enclosure| {
        if other.hi < b.lo || b.hi < other.lo {
            Err(format!(
                "[{:e}, {:e}], but {what} [{:e}, {:e}]",
                b.lo, b.hi, other.lo, other.hi
            ))
        } else {
            Ok(())
        }
    };
    let coarse = Options {
        accuracy: Accuracy::Length(1e-3 * brep.size().max(f64::MIN_POSITIVE)),
        contacts: Contacts::None,
        ..*asked
    };
    let other = query::contact(brep, probe, &coarse, workspace);
    apart("coarsely", &other.separation.bounds)?;
    if let Some(last) = found.contacts.first() {
        let mut witness = Witness::at(last);
        // With what a ball beside it teaches.
        if let Probe::Sphere(s) = probe {
            let aside = s.center + Vector3::repeat(1e-3 * brep.size());
            if let Ok(beside) = Sphere::new(aside, s.radius) {
                let beside = Probe::Sphere(beside);
                query::contact_from(brep, &beside, &mut witness, asked, workspace);
            }
        }
        let other = query::contact_from(brep, probe, &mut witness, asked, workspace);
        apart("from what it knew", &other.separation.bounds)?;
    }
    match query::overlap(brep, probe, asked, workspace).overlap {
        Some(true) if b.lo >= 0.0 => Err(format!("overlap, but not below {:e}", b.lo)),
        Some(false) if b.hi < 0.0 => Err(format!("no overlap, but below {:e}", b.hi)),
        _ => Ok(()),
    }
}

fn refuted(
    subject: &mut Subject<'_>,
    probe: &Probe,
    claim: &Claim,
    found: &ContactAnswer,
) -> Found {
    let goal = Goal::of(probe);
    let size = subject.prepared.size();
    let mut places = sampled(subject, &goal);
    places.extend(found.contacts.iter().map(|c| Place {
        face: c.face,
        uv: c.uv.coords.into(),
        value: goal.value(&c.on_brep),
    }));
    places.retain(|p| p.value.is_finite());
    places.sort_by(|a, b| a.value.total_cmp(&b.value));
    let led: Vec<Place> = places
        .iter()
        .take(LED)
        .map(|p| led(subject.scene.brep.surface(p.face), &goal, *p))
        .collect();
    places.truncate(LED);
    places.extend(led);
    for p in places {
        if !claim.is_near(p.value, size) {
            continue;
        }
        let Some(uv) = in_region(subject, &p) else {
            continue;
        };
        let Ok(at) = second::evaluate(&[&subject.scene.brep], p.face, uv) else {
            continue;
        };
        if claim.is_passed(&goal.most(&at.point)) {
            return Err(format!(
                "the separation is claimed to be in [{:e}, {:e}], and the point of face {} at {uv:?} is at {:e}",
                found.separation.bounds.lo,
                found.separation.bounds.hi,
                p.face,
                p.value - radius(probe)
            ));
        }
    }
    Ok(())
}

pub(super) fn sampled(subject: &Subject<'_>, goal: &Goal) -> Vec<Place> {
    let brep = &subject.scene.brep;
    let mut all = Vec::new();
    for face in 0..brep.faces().len().min(MOST) {
        let surface = brep.surface(face);
        let domain = surface.domain();
        let mut add = |uv: [f64; 2]| {
            let uv = [0, 1].map(|i| uv[i].clamp(domain[i].start, domain[i].end));
            let value = goal.value(&surface.point(uv[0], uv[1]));
            all.push(Place { face, uv, value });
        };
        let step = |k: usize| k as f64 / (SAMPLES - 1) as f64;
        for i in 0..SAMPLES {
            for j in 0..SAMPLES {
                add([domain[0].lerp(step(i)), domain[1].lerp(step(j))]);
            }
        }
        let parts = brep.parts();
        let loops = brep.faces()[face].loops.iter().flatten();
        let trims = loops.flat_map(|l| &parts.loops[*l].trims);
        for t in trims.take(MOST) {
            let trim = &parts.trims[*t];
            let curve = &parts.curves2[trim.curve];
            let at = |s: f64| -> [f64; 2] { curve.point(trim.span.lerp(s)).coords.into() };
            let value = |s: f64| {
                let [u, v] = at(s);
                goal.value(&surface.point(u, v))
            };
            let best = lowest(value);
            add(at(best));
        }
    }
    // What lies outside its region is no point of the face; the second method decides it exactly later.
    all.retain(|p| {
        let found = query::side(&subject.prepared, p.face, p.uv.into());
        found.is_none_or(|s| s.side != Some(Side::Outside)) || is_on_trim(subject, p)
    });
    all
}

/// A point made from a trim may be outside by rounding: kept, and moved later.
fn is_on_trim(subject: &Subject<'_>, p: &Place) -> bool {
    near_by(p.uv).into_iter().any(|uv| {
        let found = query::side(&subject.prepared, p.face, uv.into());
        found.is_some_and(|s| s.side != Some(Side::Outside))
    })
}

/// Points a few steps of f64 off.
fn near_by(uv: [f64; 2]) -> Vec<[f64; 2]> {
    let steps = |x: f64| [x, x.next_up().next_up(), x.next_down().next_down()];
    let (us, vs) = (steps(uv[0]), steps(uv[1]));
    us.iter()
        .flat_map(|u| vs.iter().map(|v| [*u, *v]))
        .collect()
}

/// Where in `[0, 1]` a function is low: the best of a few places, and golden section about it.
fn lowest(f: impl Fn(f64) -> f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    const STEPS: usize = 40;
    let step = 1.0 / (ON_TRIM - 1) as f64;
    let mut best = (f64::INFINITY, 0.0);
    for k in 0..ON_TRIM {
        let s = k as f64 * step;
        let value = f(s);
        if value < best.0 {
            best = (value, s);
        }
    }
    let (mut a, mut b) = ((best.1 - step).max(0.0), (best.1 + step).min(1.0));
    for _ in 0..STEPS {
        let (c, d) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
        if f(c) < f(d) {
            b = d;
        } else {
            a = c;
        }
    }
    let middle = 0.5 * (a + b);
    if f(middle) < best.0 { middle } else { best.1 }
}

/// The parameters of a place, or some a few steps of f64 off, that are in the face for certain.
pub(super) fn in_region(subject: &mut Subject<'_>, p: &Place) -> Option<[f64; 2]> {
    let domain = subject.scene.brep.surface(p.face).domain();
    let inside = |uv: &[f64; 2]| (0..2).all(|i| domain[i].contains(uv[i]));
    if subject.scene.brep.faces()[p.face].loops.is_none() {
        return Some(p.uv).filter(inside);
    }
    let near = near_by(p.uv).into_iter().filter(inside);
    let mut some = near.collect::<Vec<_>>().into_iter();
    some.find(|uv| {
        let found = subject.side(p.face, *uv, Effort::Loop);
        found.is_some_and(|s| s.side != Side::Outside && !s.in_gap)
    })
}

/// Downhill by damped Newton steps within the domain.
pub(super) fn led(surface: &Surface, goal: &Goal, mut p: Place) -> Place {
    const STEPS: usize = 16;
    const HALVINGS: usize = 6;
    let domain = surface.domain();
    for _ in 0..STEPS {
        let all = surface.derivatives(p.uv[0], p.uv[1], 2);
        let d = |i: usize, j: usize| all.get(i, j);
        let across = goal.across(&Point3::from(d(0, 0)));
        let metric = f64::from(!matches!(goal, Goal::Height(..)));
        let (su, sv) = (d(1, 0), d(0, 1));
        let mut g = [across.dot(&su), across.dot(&sv)];
        let mut h = [
            metric * su.dot(&su) + across.dot(&d(2, 0)),
            metric * su.dot(&sv) + across.dot(&d(1, 1)),
            metric * sv.dot(&sv) + across.dot(&d(0, 2)),
        ];
        for i in 0..2 {
            let at_end = (p.uv[i] <= domain[i].start && g[i] > 0.0)
                || (p.uv[i] >= domain[i].end && g[i] < 0.0);
            if at_end {
                g[i] = 0.0;
                h[1] = 0.0;
                h[2 * i] = 1.0;
            }
        }
        let determinant = h[0] * h[2] - h[1] * h[1];
        let step = if determinant > 0.0 && h[0] > 0.0 {
            [
                -(g[0] * h[2] - g[1] * h[1]) / determinant,
                -(g[1] * h[0] - g[0] * h[1]) / determinant,
            ]
        } else {
            [
                -g[0] / (h[0].abs() + h[1].abs()),
                -g[1] / (h[2].abs() + h[1].abs()),
            ]
        };
        let mut scale = 1.0;
        let mut moved = None;
        for _ in 0..HALVINGS {
            let uv = [0, 1].map(|i| {
                let x = p.uv[i] + scale * step[i];
                if x.is_nan() {
                    p.uv[i]
                } else {
                    x.clamp(domain[i].start, domain[i].end)
                }
            });
            let value = goal.value(&surface.point(uv[0], uv[1]));
            if value < p.value {
                moved = Some(Place { uv, value, ..p });
                break;
            }
            scale *= 0.25;
        }
        match moved {
            Some(next) => p = next,
            None => break,
        }
    }
    p
}

/// Against the second method, whole.
fn by_second(subject: &Subject<'_>, probe: &Probe, found: &ContactAnswer) -> Found {
    let second = second_of(&subject.scene.brep);
    let b = found.separation.bounds;
    let (Some(lo), Some(hi)) = (Dyadic::from_f64(b.lo), Dyadic::from_f64(b.hi)) else {
        return Ok(());
    };
    match probe {
        Probe::HalfSpace(h) => match second.half_space(h.normal.into(), h.offset) {
            Some(truth) => disjoint(&lo, &hi, &truth),
            None => Ok(()),
        },
        Probe::Sphere(s) => {
            let r = dyadic(s.radius);
            let (lo, hi) = (&lo + &r, &hi + &r);
            let center = s.center.coords.into();
            // The sign is another question.
            let (near, far) = if lo.signum() >= 0 {
                (lo.clone(), hi.clone())
            } else if hi.signum() <= 0 {
                (-&hi, -&lo)
            } else {
                (Dyadic::ZERO, larger(-&lo, hi.clone()))
            };
            if let Some(truth) = second.distance(center) {
                disjoint(&near, &far, &truth)?;
            }
            if hi.signum() < 0 {
                agree_in_space(&second, center, Side::Inside)?;
            }
            if lo.signum() > 0 && subject.scene.brep.is_closed() {
                agree_in_space(&second, center, Side::Outside)?;
            }
            for c in &found.contacts {
                let Some(reach) = c.position_bound.and_then(Dyadic::from_f64) else {
                    continue;
                };
                if let Some(truth) = second.distance(c.on_brep.coords.into())
                    && reach < truth.lo
                {
                    return Err(format!(
                        "the foot {:?} is {:e} off the faces, and its bound is {:e}",
                        c.on_brep,
                        truth.lo.approximate(),
                        reach.approximate()
                    ));
                }
            }
            Ok(())
        }
    }
}

fn disjoint(lo: &Dyadic, hi: &Dyadic, truth: &Bound) -> Found {
    let above = truth.hi.as_ref().is_some_and(|t| t < lo);
    if above || *hi < truth.lo {
        let ends = [lo, hi].map(Dyadic::approximate);
        return Err(format!(
            "claimed in [{:e}, {:e}], truly in [{:e}, {:e}]",
            ends[0],
            ends[1],
            truth.lo.approximate(),
            truth.hi.as_ref().map_or(f64::INFINITY, Dyadic::approximate)
        ));
    }
    Ok(())
}
