//! What waits to be searched, in the order of its bounds, and the arithmetics that it is searched in.

use super::front::Left;
use super::node::Node;
use super::outcome::{Outcome, Rough, Settled, Source};
use crate::numeric::{Dd, Real, Td};
use crate::prepare::{Bunch, FaceGeometry, PreparedBrep};
use std::cmp::Ordering;

/// A node that f64 cannot settle: where it is, and its bound.
pub(super) type Noisy = (Source, [f64; 2], [f64; 2], Dd);

/// Lists that one search leaves to the next, emptied.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    pub(super) tasks: Vec<Task<f64>>,
    pub(super) fine_tasks: Vec<Task<Dd>>,
    pub(super) finest_tasks: Vec<Task<Td>>,
    pub(super) settled: Vec<Settled>,
    pub(super) noisy: Vec<Noisy>,
    pub(super) spare: Spare<f64>,
    pub(super) fine_spare: Spare<Dd>,
    pub(super) finest_spare: Spare<Td>,
    /// The room for what is known of the place that a search starts from.
    pub(super) rough: Option<Box<Rough>>,
    /// Which parts of a front are to be looked at, with what no squared distance of them is less than.
    pub(super) todo: Vec<(usize, f64)>,
    /// What the search put aside, for a front.
    pub(super) left: Vec<Left>,
    /// Faces that are not searched: what is asked for is proven not to be on them.
    pub(super) passed_over: Vec<usize>,
}

/// Nodes that are done with, for their lists.
pub(super) type Spare<T> = Vec<Box<Node<T>>>;

/// No more nodes are kept for their lists: of rational bicubic patches so many hold 200 kB, of the highest degrees some megabytes.
const MOST_SPARE: usize = 256;

impl Memory {
    /// A node to fill.
    pub(super) fn spare_node<T: Real + Arithmetic>(&mut self) -> Box<Node<T>> {
        let spare = T::spare(self).pop();
        spare.unwrap_or_else(|| Box::new(Node::BLANK))
    }

    /// Keeps a node that is done with.
    pub(super) fn put_back<T: Arithmetic>(&mut self, node: Box<Node<T>>) {
        let spare = T::spare(self);
        if spare.len() < MOST_SPARE {
            spare.push(node);
        }
    }

    /// Takes back the list of a search's tasks, and the nodes that were left in it.
    pub(super) fn put_away<T: Arithmetic>(&mut self, mut tasks: Vec<Task<T>>) {
        for task in tasks.drain(..) {
            if let Kind::Node { node, .. } = task.kind {
                self.put_back(node);
            }
        }
        *T::tasks(self) = tasks;
    }

    /// Takes back what an outcome was kept in.
    pub(crate) fn keep(&mut self, outcome: Outcome) {
        self.settled = outcome.settled;
        self.settled.clear();
        self.rough = outcome.rough.or_else(|| self.rough.take());
    }
}

#[derive(Debug)]
pub(super) struct Task<T> {
    pub(super) lo: Dd,
    /// How many were made before it.
    pub(super) order: u32,
    /// Whether it is part of something that was put aside with a bound: only this search's centre makes it a task of its own.
    pub(super) covered: bool,
    pub(super) kind: Kind<T>,
}

#[derive(Debug)]
pub(super) enum Kind<T> {
    Face(usize),
    Closed(usize),
    /// Curves in closed form, or boundary pieces, of a face.
    Bunch(usize, Bunched, Bunch),
    Root(Source),
    Node {
        source: Source,
        /// Whether the node's box is known to lie in the region.
        inside: bool,
        node: Box<Node<T>>,
    },
}

/// What is in a bunch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bunched {
    Curves,
    Pieces,
}

impl<T> PartialEq for Task<T> {
    fn eq(&self, o: &Self) -> bool {
        self.cmp(o) == Ordering::Equal
    }
}
impl<T> Eq for Task<T> {}
impl<T> PartialOrd for Task<T> {
    fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
        Some(self.cmp(o))
    }
}
impl<T> Ord for Task<T> {
    /// The heap gives the largest first: the least bound, then the oldest.
    fn cmp(&self, o: &Self) -> Ordering {
        let by_bound = o.lo.partial_cmp(&self.lo).unwrap_or(Ordering::Equal);
        by_bound.then(o.order.cmp(&self.order))
    }
}

/// Which arithmetic's geometry a node type works on.
pub(crate) trait Arithmetic: Sized {
    /// The list that a search in this arithmetic keeps its heap in.
    fn tasks(memory: &mut Memory) -> &mut Vec<Task<Self>>;
    /// The nodes that it is done with.
    fn spare(memory: &mut Memory) -> &mut Spare<Self>;
    fn geometry(brep: &PreparedBrep, face: usize) -> &FaceGeometry<Self>;
}

impl Arithmetic for f64 {
    fn tasks(memory: &mut Memory) -> &mut Vec<Task<Self>> {
        &mut memory.tasks
    }

    fn spare(memory: &mut Memory) -> &mut Spare<Self> {
        &mut memory.spare
    }

    fn geometry(brep: &PreparedBrep, face: usize) -> &FaceGeometry<Self> {
        brep.double(face)
    }
}

impl Arithmetic for Dd {
    fn tasks(memory: &mut Memory) -> &mut Vec<Task<Self>> {
        &mut memory.fine_tasks
    }

    fn spare(memory: &mut Memory) -> &mut Spare<Self> {
        &mut memory.fine_spare
    }

    fn geometry(brep: &PreparedBrep, face: usize) -> &FaceGeometry<Self> {
        brep.double_double(face)
    }
}

impl Arithmetic for Td {
    fn tasks(memory: &mut Memory) -> &mut Vec<Task<Self>> {
        &mut memory.finest_tasks
    }

    fn spare(memory: &mut Memory) -> &mut Spare<Self> {
        &mut memory.finest_spare
    }

    fn geometry(brep: &PreparedBrep, face: usize) -> &FaceGeometry<Self> {
        brep.triple_double(face)
    }
}
