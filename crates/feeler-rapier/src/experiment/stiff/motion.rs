//! A ball under penalty contact, by an integrator for stiff problems.
//!
//! # The problem
//! `m x'' = m g + lambda n + f`, `I w' = -r n x f`, with the push `lambda = k max(0, depth)` along the wall's normal n, and, where the
//! ball rolls, the grip f in the tangent plane that keeps `x' + w x (-r n) = 0` while it touches. Frictionless, the push has the potential
//! `k depth^2 / 2`; the grip does no work: the energy is constant either way.
//!
//! # The method
//! Radau IIA with three stages: order 5, L-stable, stiffly accurate; it integrates penalty contact of any stiffness as it would the
//! constraint that it tends to, without resolving oscillations of frequency sqrt(k/m) (Hairer, Wanner, *Solving Ordinary Differential
//! Equations II*, IV.8 and VII; Lubich, *Integration of stiff mechanical systems by Runge-Kutta methods*, ZAMP 44, 1993). Push and grip are
//! unknowns of their own, so that k stands in the equations as 1/k alone: `lambda / k = max(0, depth)`. In positions,
//! push and grip of all stages the equations are solved by Newton's method, the contact's stiffness (its normals) in the Jacobian; that normals
//! turn is left out of it, which costs a factor of some (h sqrt(g/L)) an iteration. A step in which Newton does not settle is done again in
//! 2 to 16 parts, as is one that adds energy, of which there is no source: so the method answers a push that sets in, or a normal that jumps,
//! faster than its steps resolve. A part of the shortest that does not settle either is *forced*: a plastic impact, which takes the velocity into
//! the wall away and sets the ball on it.
//!
//! Which stages touch is looked for as by primal-dual active sets: those with `push h^2 / m + depth > 0`. (With `depth > 0` alone a first guess
//! a little above the wall lets go, and Newton may find a solution in which some stages hang in the air and others push for them.)

use super::wall::Wall;
use super::{BALL, MASS};
use ::nalgebra::{Point3, SMatrix, SVector, Vector3};

/// What holds the ball.
#[derive(Clone, Copy, Debug)]
pub(in crate::experiment) struct Law {
    /// N/m, which is kg/s^2 whatever the unit of length.
    pub(in crate::experiment) stiffness: f64,
    /// Rolls without slipping, or slides without friction.
    pub(in crate::experiment) rolls: bool,
    /// mm/s^2.
    pub(in crate::experiment) gravity: Vector3<f64>,
}

#[derive(Clone, Copy, Debug)]
pub(in crate::experiment) struct State {
    pub(in crate::experiment) at: Point3<f64>,
    pub(in crate::experiment) velocity: Vector3<f64>,
    /// 1/s.
    pub(in crate::experiment) spin: Vector3<f64>,
    /// kg mm/s^2, at the end of the last step: where the next one begins to look.
    pub(in crate::experiment) push: f64,
    pub(in crate::experiment) grip: Vector3<f64>,
    pub(in crate::experiment) normal: Vector3<f64>,
}

/// What steps cost.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::experiment) struct Tally {
    pub(in crate::experiment) steps: usize,
    pub(in crate::experiment) queries: usize,
    /// Steps that were done in parts.
    pub(in crate::experiment) parted: usize,
    /// Parts that did not settle.
    pub(in crate::experiment) forced: usize,
}

/// Stages, and unknowns of each: position, push, grip.
const STAGES: usize = 3;
const EACH: usize = 7;
const ALL: usize = STAGES * EACH;

const MOST_ITERATIONS: usize = 25;
/// Positions move no more, mm: some ulps of the coordinates.
const SETTLED: f64 = 2e-15;
/// Iterations that stop shrinking below this have met the wall's own noise, mm.
const NOISE: f64 = 1e-7;
/// Energy that a step may add, of that of its motion and height.
const ADDED: f64 = 1e-4;
const PARTS: [usize; 5] = [1, 2, 4, 8, 16];

/// Radau IIA: the stages' times and their matrix.
fn tableau() -> ([f64; 3], SMatrix<f64, 3, 3>) {
    let s = 6f64.sqrt();
    let a = SMatrix::<f64, 3, 3>::new(
        (88.0 - 7.0 * s) / 360.0,
        (296.0 - 169.0 * s) / 1800.0,
        (-2.0 + 3.0 * s) / 225.0,
        (296.0 + 169.0 * s) / 1800.0,
        (88.0 + 7.0 * s) / 360.0,
        (-2.0 - 3.0 * s) / 225.0,
        (16.0 - s) / 36.0,
        (16.0 + s) / 36.0,
        1.0 / 9.0,
    );
    ([(4.0 - s) / 10.0, (4.0 + s) / 10.0, 1.0], a)
}

/// The arm of the grip over the ball's moment of inertia, times mass and arm again: 1 / (2/5).
const LEVER: f64 = 2.5;

struct Stage {
    depth: f64,
    normal: Vector3<f64>,
}

/// One step of length h; `None` where Newton does not settle.
fn radau(wall: &mut dyn Wall, law: &Law, s: &State, h: f64, tally: &mut Tally) -> Option<State> {
    let (c, a) = tableau();
    let aa = a * a;
    let scale = h * h / MASS;
    // Push and grip in lengths: times h^2 / m.
    let fall = law.gravity * (h * h);
    let soft = 1.0 / (law.stiffness * scale);
    let start = s.velocity * h;
    let force = fall + (s.normal * s.push + s.grip) * scale;
    let mut x = SVector::<f64, ALL>::zeros();
    for i in 0..STAGES {
        let way = start * c[i] + force * (0.5 * c[i] * c[i]);
        x.fixed_rows_mut::<3>(EACH * i).copy_from(&way);
        x[EACH * i + 3] = s.push * scale;
        x.fixed_rows_mut::<3>(EACH * i + 4)
            .copy_from(&(s.grip * scale));
    }
    let mut last = f64::INFINITY;
    for _ in 0..MOST_ITERATIONS {
        let way = |x: &SVector<f64, ALL>, i: usize| x.fixed_rows::<3>(EACH * i).into_owned();
        let grip = |x: &SVector<f64, ALL>, i: usize| x.fixed_rows::<3>(EACH * i + 4).into_owned();
        let stages: [Stage; STAGES] = std::array::from_fn(|i| {
            let near = wall.near(&(s.at + way(&x, i)));
            Stage {
                depth: near.depth,
                normal: near.normal,
            }
        });
        tally.queries += STAGES;
        let mut residual = SVector::<f64, ALL>::zeros();
        let mut matrix = SMatrix::<f64, ALL, ALL>::identity();
        for i in 0..STAGES {
            let at = EACH * i;
            let n = stages[i].normal;
            let touches = x[at + 3] + stages[i].depth > 0.0;
            let mut off = way(&x, i) - start * c[i];
            let mut speed = start;
            let mut spin = s.spin * (h * BALL);
            for j in 0..STAGES {
                let nj = stages[j].normal;
                let (push, grip) = (x[EACH * j + 3], grip(&x, j));
                let all = fall + nj * push + grip;
                off -= all * aa[(i, j)];
                speed += all * a[(i, j)];
                spin -= nj.cross(&grip) * (LEVER * a[(i, j)]);
                let b = EACH * j;
                matrix
                    .fixed_view_mut::<3, 1>(at, b + 3)
                    .copy_from(&(nj * -aa[(i, j)]));
                for k in 0..3 {
                    matrix[(at + k, b + 4 + k)] = -aa[(i, j)];
                }
            }
            residual.fixed_rows_mut::<3>(at).copy_from(&off);
            if touches {
                residual[at + 3] = x[at + 3] * soft - stages[i].depth;
                matrix[(at + 3, at + 3)] = soft;
                for k in 0..3 {
                    matrix[(at + 3, at + k)] = n[k];
                }
            } else {
                residual[at + 3] = x[at + 3];
            }
            if !(touches && law.rolls) {
                residual.fixed_rows_mut::<3>(at + 4).copy_from(&grip(&x, i));
                continue;
            }
            // The point of the ball at the wall does not move along it; the grip has no part across.
            let slip = speed - spin.cross(&n);
            let along = |v: Vector3<f64>| v - n * n.dot(&v);
            let own = grip(&x, i);
            residual
                .fixed_rows_mut::<3>(at + 4)
                .copy_from(&(along(slip) + n * n.dot(&own)));
            for j in 0..STAGES {
                let nj = stages[j].normal;
                let b = EACH * j;
                matrix
                    .fixed_view_mut::<3, 1>(at + 4, b + 3)
                    .copy_from(&(along(nj) * a[(i, j)]));
                for k in 0..3 {
                    let e = Vector3::from_fn(|r, _| f64::from(u8::from(r == k)));
                    // (nj x e) x n.
                    let turned = e * nj.dot(&n) - nj * n[k];
                    let mut column = along(e + turned * LEVER) * a[(i, j)];
                    if i == j {
                        column += n * n[k];
                    }
                    matrix
                        .fixed_view_mut::<3, 1>(at + 4, b + 4 + k)
                        .copy_from(&column);
                }
            }
        }
        let step = matrix.lu().solve(&residual)?;
        x -= step;
        let moved = (0..STAGES)
            .map(|i| way(&step, i).amax())
            .fold(0.0, f64::max);
        if !moved.is_finite() {
            return None;
        }
        if moved <= SETTLED || (moved <= NOISE && moved >= 0.5 * last) {
            let (mut speed, mut spin) = (start, s.spin * h);
            for j in 0..STAGES {
                let (nj, push, grip) = (stages[j].normal, x[EACH * j + 3], grip(&x, j));
                speed += (fall + nj * push + grip) * a[(STAGES - 1, j)];
                spin -= nj.cross(&grip) * (LEVER / BALL * a[(STAGES - 1, j)]);
            }
            let end = STAGES - 1;
            return Some(State {
                at: s.at + way(&x, end),
                velocity: speed / h,
                spin: spin / h,
                push: x[EACH * end + 3] / scale,
                grip: grip(&x, end) / scale,
                normal: stages[end].normal,
            });
        }
        last = moved;
    }
    None
}

/// A plastic impact, if the ball would come to touch, else free fall.
fn plastic(wall: &mut dyn Wall, law: &Law, s: &State, h: f64, tally: &mut Tally) -> State {
    tally.queries += 2;
    let near = wall.near(&s.at);
    let n = near.normal;
    let mut velocity = s.velocity + law.gravity * h;
    let (mut spin, mut push, mut grip) = (s.spin, 0.0, Vector3::zeros());
    let across = n.dot(&velocity);
    if near.depth > across * h {
        let stop = (-across).max(0.0);
        velocity += n * stop;
        push = stop * MASS / h;
        if law.rolls {
            let slip = velocity - spin.cross(&n) * BALL;
            let change = (slip - n * n.dot(&slip)) * (-1.0 / (1.0 + LEVER));
            velocity += change;
            spin -= n.cross(&change) * (LEVER / BALL);
            grip = change * (MASS / h);
        }
    }
    let mut at = s.at + velocity * h;
    let there = wall.near(&at);
    at += there.normal * (there.depth - push / law.stiffness).max(0.0);
    State {
        at,
        velocity,
        spin,
        push,
        grip,
        normal: there.normal,
    }
}

/// Energy of motion and height; that of the overlap from the push.
fn own_energy(law: &Law, s: &State) -> f64 {
    let spin = BALL * BALL / LEVER * s.spin.norm_squared();
    0.5 * MASS * (s.velocity.norm_squared() + spin) - MASS * law.gravity.dot(&s.at.coords)
        + 0.5 * s.push * s.push / law.stiffness
}

/// Whether a step has added energy, beyond what the method is off by where all is smooth.
fn adds(law: &Law, before: &State, after: &State) -> bool {
    let way = (after.at - before.at).norm() * MASS * law.gravity.norm();
    let scale = 0.5 * MASS * after.velocity.norm_squared() + way;
    own_energy(law, after) - own_energy(law, before) > ADDED * scale
}

/// One step of length h.
pub(in crate::experiment) fn step(
    wall: &mut dyn Wall,
    law: &Law,
    state: &State,
    h: f64,
    tally: &mut Tally,
) -> State {
    tally.steps += 1;
    for parts in PARTS {
        let h = h / parts as f64;
        let mut s = *state;
        let mut done = 0;
        while done < parts {
            match radau(wall, law, &s, h, tally).filter(|next| !adds(law, &s, next)) {
                Some(next) => s = next,
                None if parts == PARTS[PARTS.len() - 1] => {
                    tally.forced += 1;
                    s = plastic(wall, law, &s, h, tally);
                }
                None => break,
            }
            done += 1;
        }
        if done == parts {
            tally.parted += usize::from(parts > 1);
            return s;
        }
    }
    // The shortest parts are always done.
    *state
}

/// Energy of motion, height and the overlap with the wall, kg mm^2/s^2.
pub(in crate::experiment) fn energy(wall: &mut dyn Wall, law: &Law, s: &State) -> f64 {
    let push = law.stiffness * wall.near(&s.at).depth.max(0.0);
    own_energy(law, &State { push, ..*s })
}
