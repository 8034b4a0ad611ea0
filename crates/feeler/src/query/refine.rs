//! What f64 leaves open, again in double-double, and what that leaves open in triple-double.

use super::list::may_be_contact;
use super::local::Surroundings;
use super::node::Node;
use super::objective::Objective;
use super::outcome::Source;
use super::search::Search;
use super::task::{Arithmetic, Noisy};
use crate::numeric::{Dd, Real, Td};
use crate::prepare::Quotient;
use std::collections::BinaryHeap;

impl Search<'_> {
    /// Searches what f64 left open again in double-double, and what that leaves open in triple-double.
    pub(super) fn refine_noisy(&mut self) {
        let mut noisy = std::mem::take(&mut self.noisy);
        if !noisy.is_empty() && !self.out.budget_spent {
            self.sharpen();
            let around = Surroundings::new(self.brep, self.objective);
            noisy.retain(|&(source, u, v, lo)| {
                if self.hopeless(lo) {
                    return true;
                }
                self.settle_unshaped(source, u, v, lo);
                // Of most that is no minimum, a piece's end on the border of its patch, the way down is seen from here. (Only where all minima are asked
                // for is anything left that is not below the best.)
                let kept = self.out.settled.last().filter(|_| lo >= self.out.hi);
                let falls = kept.is_some_and(|s| !may_be_contact(&around, s));
                if falls {
                    self.out.settled.pop();
                }
                !falls
            });
            self.out.nodes += around.nodes();
            self.refine::<Dd>(&mut noisy, false);
            if self.goal.all_below.is_some() {
                for &(source, u, v, lo) in &noisy {
                    if self.hopeless(lo) {
                        continue;
                    }
                    self.settle_unshaped(source, u, v, lo);
                    if let Some(last) = self.out.settled.last_mut() {
                        last.flat = true;
                    }
                }
            }
            if self.goal.width.is_full() {
                self.refine_least(&mut noisy);
            }
        }
        for (.., lo) in &noisy {
            self.lower_unsettled(*lo);
        }
        noisy.clear();
        self.memory.noisy = noisy;
    }

    /// Searches what double-double leaves open for the least minimum alone, with more digits. (Where all minima are asked for, others on these nodes are
    /// settled, as [flat](super::outcome::Settled::flat).)
    fn refine_least(&mut self, noisy: &mut Vec<Noisy>) {
        let all = self.goal.all_below.take();
        let settled = self.out.settled.len();
        self.forget_enough();
        let about = self.is_next_to_centre();
        if about && (1..=MOST_ABOUT).contains(&self.open(noisy)) {
            self.refine_within::<Dd>(noisy, about, ABOUT_BUDGET);
        }
        let (most, budget) = if self.objective.is_squared() {
            (MOST_FINEST, FINEST_BUDGET)
        } else {
            (MOST_FINEST_HEIGHTS, FINEST_HEIGHTS_BUDGET)
        };
        if (1..=most).contains(&self.open(noisy)) {
            self.refine_within::<Td>(noisy, about, budget);
        }
        if all.is_some() {
            self.out.settled.truncate(settled);
            self.goal.all_below = all;
            self.forget_enough();
        }
    }

    /// How many nodes of a list may hold the minimum.
    fn open(&self, noisy: &[Noisy]) -> usize {
        let enough = self.enough();
        noisy.iter().filter(|n| n.3 < enough).count()
    }

    /// Whether the centre is so near to the best point so far, against the size of the BREP, that distances lose digits where products are about the middle of a patch.
    fn is_next_to_centre(&self) -> bool {
        let near = NEXT * self.brep.size();
        self.objective.is_squared() && self.out.hi.hi < near * near
    }

    /// The same as [`Self::refine`], with so many nodes at most.
    fn refine_within<T: Real + Arithmetic>(
        &mut self,
        noisy: &mut Vec<Noisy>,
        about: bool,
        nodes: usize,
    ) {
        if self.out.budget_spent {
            return;
        }
        let budget = self.goal.budget;
        self.goal.budget = budget.min(self.out.nodes + nodes);
        self.refine::<T>(noisy, about);
        self.goal.budget = budget;
        // What is left is bounded; it is the precision that is at an end, unless the whole budget is.
        if self.out.nodes < budget {
            self.out.left_open |= std::mem::take(&mut self.out.budget_spent);
        }
    }

    /// Searches the nodes of a list again, in another arithmetic, and leaves in it what that leaves open; `about` the centre, where digits are lost that are not lost
    /// there.
    fn refine<T: Real + Arithmetic>(&mut self, noisy: &mut Vec<Noisy>, about: bool) {
        let mut heap = BinaryHeap::from(std::mem::take(T::tasks(self.memory)));
        for &(source, u, v, lo) in noisy.iter() {
            if self.hopeless(lo) {
                continue;
            }
            if lo >= self.enough() {
                self.lower(lo);
                continue;
            }
            let squared = self.objective.is_squared();
            let node = if about {
                self.box_about(source, u, v)
            } else {
                let root = self.root::<T>(source);
                root.map(|root| self.narrow(root, u, v, squared))
            };
            match node {
                Some(mut node) => {
                    if lo > node.lo {
                        node.lo = lo;
                    }
                    // The finer coefficients may see a slope where f64 saw noise.
                    let guess = node.guess();
                    self.try_point(source, guess.map(Dd::from), false);
                    let start = self.descend(source, guess, [node.u, node.v]);
                    self.try_point(source, start.map(Dd::from), false);
                    self.enqueue(&mut heap, source, false, node, true);
                }
                None => self.lower(lo),
            }
        }
        self.run(&mut heap);
        self.memory.put_away(heap.into_vec());
        noisy.clear();
        noisy.append(&mut self.noisy);
    }

    /// A box of a source, from its points relative to the centre: see [`Net::about`](crate::prepare::Net::about).
    fn box_about<T: Real + Arithmetic>(
        &mut self,
        source: Source,
        u: [f64; 2],
        v: [f64; 2],
    ) -> Option<Box<Node<T>>> {
        let Objective::SquaredDistance(q) = self.objective else {
            return None;
        };
        let net = self.net_in::<T>(source)?.about(q.coords.into(), [u, v]);
        let products = net.products();
        let mut node = self.memory.spare_node();
        let spare = std::mem::replace(&mut node.f, Quotient::BLANK);
        let quotient = self.objective.quotient(&net, || &products, spare);
        *node = Node::over(quotient, u, v, true);
        Some(node)
    }

    /// The part of a root node over a box.
    fn narrow<T: Real + Arithmetic>(
        &mut self,
        mut node: Box<Node<T>>,
        u: [f64; 2],
        v: [f64; 2],
        squared: bool,
    ) -> Box<Node<T>> {
        for (along_u, target, range) in [(true, u, node.u), (false, v, node.v)] {
            // A border of the patch: collapsed dimensions are always at 0 or 1.
            if target[0] == target[1] && range[0] != range[1] {
                let mut border = self.memory.spare_node();
                node.border(&mut border, along_u, target[0] == range[1], squared);
                self.memory.put_back(std::mem::replace(&mut node, border));
            }
        }
        node.cut(u, v, squared);
        node
    }
}

/// Below this part of the size the centre is next to the surface: what products about it lose is some tens of times less than what others do, as it goes with the square of the
/// distance.
const NEXT: f64 = 1.0 / 8.0;
/// So many nodes are looked at again about the centre at most: about a pole there are as many as all patches and trims there have, some dozens.
const MOST_ABOUT: usize = 64;
/// How many nodes may be visited then.
const ABOUT_BUDGET: usize = 1024;
/// So many nodes are looked at again in triple-double at most: beyond, it is a whole curve or region that no digits tell.
const MOST_FINEST: usize = 16;
/// How many nodes may be visited then; each costs as much as some thousand in f64.
const FINEST_BUDGET: usize = 128;
/// The same of heights, whose nodes have no products, so that each costs a few: all of a rim that rests on a plane is at one height, on some tens of pieces and of borders of
/// patches, of which double-double tells the last digits but one.
const MOST_FINEST_HEIGHTS: usize = 256;
/// How many nodes may be visited then.
const FINEST_HEIGHTS_BUDGET: usize = 512;
