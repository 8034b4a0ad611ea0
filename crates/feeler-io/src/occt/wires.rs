//! The order of a loop's trims. A wire lists its edges in any order; a loop's trims follow each other head to tail.

use nalgebra::Point2;
use std::collections::HashMap;

/// One use of an edge, in the direction of the loop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Use {
    pub(super) vertices: [usize; 2],
    pub(super) ends: [Point2<f64>; 2],
}

/// How many ways on from one vertex are compared. Wires have one or two; beyond this number the ones listed first
/// are taken, so that no file makes this quadratic.
const WAYS: usize = 32;

/// The uses as chains: each goes on at its last vertex, with the use that starts nearest in uv. As listed where that
/// is equal.
pub(super) fn chains(uses: &[Use]) -> Vec<Vec<usize>> {
    // By start vertex, the first listed last.
    let mut ways: HashMap<usize, Vec<usize>> = HashMap::new();
    for (i, u) in uses.iter().enumerate().rev() {
        ways.entry(u.vertices[0]).or_default().push(i);
    }
    let mut used = vec![false; uses.len()];
    let mut chains = Vec::new();
    for first in 0..uses.len() {
        if used[first] {
            continue;
        }
        let mut chain = Vec::new();
        let mut next = Some(first);
        while let Some(i) = next {
            used[i] = true;
            chain.push(i);
            let [_, vertex] = uses[i].vertices;
            let [_, end] = uses[i].ends;
            next = ways.get_mut(&vertex).and_then(|list| {
                // Taken ones at the end of the list are gone for good; a few others may be in between.
                while list.last().is_some_and(|j| used[*j]) {
                    list.pop();
                }
                let open = list.iter().rev().take(WAYS).filter(|j| !used[**j]);
                let distance = |j: usize| (uses[j].ends[0] - end).norm_squared();
                let best = open.fold(None, |best: Option<(f64, usize)>, &j| {
                    let d = distance(j);
                    if best.is_none_or(|(least, _)| d < least) {
                        Some((d, j))
                    } else {
                        best
                    }
                });
                best.map(|(_, j)| j)
            });
        }
        chains.push(chain);
    }
    chains
}
