//! Many queries on one BREP: a slice in, answers in the same order out, in a list whose room is kept from batch to batch.
//!
//! An answer hangs on the BREP, the query and the options alone: not on what was asked before, on what has been made of the BREP so
//! far, or on which thread asks (what is made on demand is the same whoever makes it). So a batch has the same bits as its queries one
//! by one, for any number of threads. With the feature `rayon` it runs on the threads of the current rayon pool, without it
//! on this one.

use super::{
    AnyHit, ContactAnswer, LineAnswer, LineProbe, Options, OverlapAnswer, Probe, SideAnswer,
    Workspace,
};
use crate::prepare::PreparedBrep;
use nalgebra::Point3;

/// [`contact`](super::contact) for each probe. What `answers` held is dropped.
pub fn contact(
    brep: &PreparedBrep,
    probes: &[Probe],
    options: &Options,
    answers: &mut Vec<ContactAnswer>,
) {
    each(probes, answers, |p, w| super::contact(brep, p, options, w));
}

/// [`overlap`](super::overlap) for each probe, likewise.
pub fn overlap(
    brep: &PreparedBrep,
    probes: &[Probe],
    options: &Options,
    answers: &mut Vec<OverlapAnswer>,
) {
    each(probes, answers, |p, w| super::overlap(brep, p, options, w));
}

/// [`line`](super::line) for each line, likewise.
pub fn line(
    brep: &PreparedBrep,
    lines: &[LineProbe],
    options: &Options,
    answers: &mut Vec<LineAnswer>,
) {
    each(lines, answers, |l, w| super::line(brep, l, options, w));
}

/// [`any_hit`](super::any_hit) for each line, likewise.
pub fn any_hit(
    brep: &PreparedBrep,
    lines: &[LineProbe],
    options: &Options,
    answers: &mut Vec<AnyHit>,
) {
    each(lines, answers, |l, w| super::any_hit(brep, l, options, w));
}

/// [`inside`](super::inside) for each point, likewise.
pub fn inside(brep: &PreparedBrep, points: &[Point3<f64>], answers: &mut Vec<SideAnswer>) {
    each(points, answers, |p, w| super::inside(brep, *p, w));
}

#[cfg(feature = "rayon")]
fn each<Q: Sync, A: Send>(
    queries: &[Q],
    answers: &mut Vec<A>,
    ask: impl Fn(&Q, &mut Workspace) -> A + Sync,
) {
    use rayon::prelude::*;
    /// Fewer queries than this are not worth handing to another thread: each takes a microsecond or more.
    const LEAST: usize = 8;
    let each = queries.par_iter().with_min_len(LEAST);
    let each = each.map_init(Workspace::default, |w, q| ask(q, w));
    each.collect_into_vec(answers);
}

#[cfg(not(feature = "rayon"))]
fn each<Q, A>(queries: &[Q], answers: &mut Vec<A>, ask: impl Fn(&Q, &mut Workspace) -> A) {
    let mut workspace = Workspace::default();
    answers.clear();
    answers.extend(queries.iter().map(|q| ask(q, &mut workspace)));
}
