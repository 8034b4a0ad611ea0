//! What f64 leaves open, again in double-double, and what that leaves open in triple-double.

use super::node::Node;
use super::search::Search;
use super::task::{Arithmetic, Noisy};
use crate::numeric::{Dd, Real, Td};
use std::collections::BinaryHeap;

impl Search<'_> {
    /// Searches what f64 left open again in double-double, and what that leaves open in triple-double.
    pub(super) fn refine_noisy(&mut self) {
        let mut noisy = std::mem::take(&mut self.noisy);
        if !noisy.is_empty() && !self.out.budget_spent {
            self.sharpen();
            for &(source, u, v, lo) in &noisy {
                if !self.hopeless(lo) {
                    self.settle_unshaped(source, u, v, lo);
                }
            }
            self.refine::<Dd>(&mut noisy);
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
            let enough = self.enough();
            let open = noisy.iter().filter(|n| n.3 < enough).count();
            if self.goal.width.is_full()
                && self.goal.all_below.is_none()
                && (1..=MOST_FINEST).contains(&open)
                && !self.out.budget_spent
            {
                let budget = self.goal.budget;
                self.goal.budget = budget.min(self.out.nodes + FINEST_BUDGET);
                self.refine::<Td>(&mut noisy);
                self.goal.budget = budget;
                // What is left is bounded; it is the precision that is at an end, unless the whole budget is.
                if self.out.nodes < budget {
                    self.out.left_open |= std::mem::take(&mut self.out.budget_spent);
                }
            }
        }
        for (.., lo) in &noisy {
            self.lower_unsettled(*lo);
        }
        noisy.clear();
        self.memory.noisy = noisy;
    }

    /// Searches the nodes of a list again, in another arithmetic, and leaves in it what that leaves open.
    fn refine<T: Real + Arithmetic>(&mut self, noisy: &mut Vec<Noisy>) {
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
            match self.root::<T>(source) {
                Some(root) => {
                    let mut node = self.narrow(root, u, v, squared);
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

/// So many nodes are looked at again in triple-double at most: beyond, it is a whole curve or region that no digits tell.
const MOST_FINEST: usize = 16;
/// How many nodes may be visited then; each costs as much as some thousand in f64.
const FINEST_BUDGET: usize = 128;
