//! Boxes in a tree, for lines that miss most of them.
//!
//! # What is proven
//! A line `o + t d` misses a box of middle `m` and half sides `h` exactly if it does so as seen along one of the axes `x`, `y`, `z`: if for two
//! coordinates `i`, `j` the box lies on one side of the line's image, `|x_i d_j - x_j d_i| > h_i |d_j| + h_j |d_i|` with `x = m - o` (the
//! separating axes of a line and a box are the products of its direction and the box's). In f64 with `u = 2^-53` a difference `x_i`, its product
//! and the difference of two are off by at most `4 u (|x_i d_j| + |x_j d_i|)`, and `|x_i| <= (|m_i| + |o_i|)(1 + u)`; the right side by
//! four roundings of itself, and `m` and `h` are those of a box that is longer by four of `|m| + h` at most: together less than `12 u` of `E = (|m_i| + h_i +
//! |o_i|) |d_j| + (|m_j| + h_j + |o_j|) |d_i|`. [`SLACK`] adds `32 u E`, for halves and for origins. So what is said to be missed is missed.
//!
//! The box of a node holds those below it, whose `E` are no greater. At each level up the slack is as much more, which is more than what both are off: what
//! is said to miss a node is said to miss all below it. So what a line finds is the same whether the nodes above have been made or not.

use super::Box3;
use crate::numeric::bernstein::greater;
use std::sync::OnceLock;

/// So many boxes, or nodes, are below one node.
const WIDTH: usize = 8;
/// So many nodes have none above them.
const TOP: usize = 2;
/// Levels of a tree with as many leaves as a number of 32 bits counts.
const LEVELS: usize = 11;
/// What a box is longer by, in parts of its and the line's coordinates, for each level up to it.
const SLACK: f64 = 16.0 * f64::EPSILON;
/// What is added to sums so that nothing which underflows matters.
const LEAST: f64 = f64::MIN_POSITIVE / SLACK;

/// A line that boxes are held against, as if it had no ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Skewer {
    pub(crate) origin: [f64; 3],
    pub(crate) direction: [f64; 3],
    /// Whether it has, so that more may be known of a box that it meets here.
    pub(crate) has_ends: bool,
}

/// Up to [`WIDTH`] boxes.
#[derive(Clone, Debug)]
struct Node {
    middle: [[f64; WIDTH]; 3],
    /// Half of their sides, and the slack.
    half: [[f64; WIDTH]; 3],
    /// The slack for the line's own coordinates.
    slack: f64,
    /// A bit for each.
    all: u8,
    /// A box around them; `None` where one of them is not known.
    whole: Option<Box3>,
}

impl Node {
    /// Of boxes, or (a level up, and so on) of those around the boxes of nodes. One that is not known is missed by nothing.
    fn new(boxes: &[Option<Box3>], level: usize) -> Self {
        let slack = SLACK * (level + 1) as f64;
        let mut out = Self {
            middle: [[0.0; WIDTH]; 3],
            half: [[f64::INFINITY; WIDTH]; 3],
            slack,
            all: ((1u16 << boxes.len().min(WIDTH)) - 1) as u8,
            whole: Some([[f64::INFINITY, f64::NEG_INFINITY]; 3]),
        };
        for (k, known) in boxes.iter().take(WIDTH).enumerate() {
            let Some(b) = known else {
                out.whole = None;
                continue;
            };
            for (c, &[low, high]) in b.iter().enumerate() {
                let middle = low + 0.5 * (high - low);
                let half = (middle - low).max(high - middle);
                if !(middle.is_finite() && half.is_finite()) {
                    continue;
                }
                out.middle[c][k] = middle;
                // The differences are off by half an ulp: the next number up is no less.
                let half = half.next_up();
                out.half[c][k] = (half + slack * (middle.abs() + half)).next_up();
            }
            out.whole = out.whole.map(|w| super::around(&[w, *b]));
        }
        out
    }

    /// Which of the boxes the line may meet, a bit for each.
    fn met(&self, line: &Skewer) -> u8 {
        let (o, d) = (line.origin, line.direction);
        let size = d.map(f64::abs);
        let far = o.map(f64::abs);
        // By how much each box is clear, in the axis along which it is most.
        let mut clear = [f64::NEG_INFINITY; WIDTH];
        for axis in 0..3 {
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            let slack = self.slack * (far[i] * size[j] + far[j] * size[i] + LEAST);
            for k in 0..WIDTH {
                let across = (self.middle[i][k] - o[i]) * d[j] - (self.middle[j][k] - o[j]) * d[i];
                let reach = self.half[i][k] * size[j] + self.half[j][k] * size[i];
                clear[k] = greater(across.abs() - (reach + slack), clear[k]);
            }
        }
        let mut met = 0;
        for (k, by) in clear.iter().enumerate() {
            // The difference of two numbers has the sign of their order.
            met |= u8::from(!(*by > 0.0)) << k;
        }
        met & self.all
    }
}

/// What is known of a box when a line comes to it.
pub(crate) enum Known {
    /// The line misses it, or what is in it; the box itself has not been made.
    Missed,
    /// The box, if there is one.
    Box(Option<Box3>),
}

/// Numbered boxes, which are made when a line first comes to them: those of a node are kept once all of them are made.
#[derive(Debug)]
pub(crate) struct BoxTree {
    /// The numbers of the boxes, those near each other together.
    order: Vec<u32>,
    /// Nodes over boxes, over those nodes, and so on up to [`TOP`].
    levels: Vec<Vec<OnceLock<Node>>>,
}

impl BoxTree {
    /// A tree over boxes that are about these points.
    pub(crate) fn new(points: &[[f64; 3]]) -> Self {
        let mut levels = Vec::new();
        let mut count = points.len();
        while count > 0 {
            count = count.div_ceil(WIDTH);
            levels.push((0..count).map(|_| OnceLock::new()).collect());
            if count <= TOP {
                break;
            }
        }
        Self {
            order: order(points),
            levels,
        }
    }

    /// Bytes of its lists.
    pub(crate) fn bytes(&self) -> usize {
        let nodes: usize = self.levels.iter().map(Vec::capacity).sum();
        self.order.capacity() * size_of::<u32>() + nodes * size_of::<OnceLock<Node>>()
    }

    /// Calls `found` with the numbers of the boxes that a line may meet, in no order that says anything, until it returns true;
    /// whether it did.
    pub(crate) fn any(
        &self,
        line: &Skewer,
        known: impl Fn(usize) -> Known,
        mut found: impl FnMut(usize) -> bool,
    ) -> bool {
        // A level has at most WIDTH nodes of one parent waiting.
        let mut stack = [(0u8, 0u32); WIDTH * LEVELS];
        let mut waiting = 0;
        if let Some(top) = self.levels.len().checked_sub(1) {
            for index in 0..self.levels[top].len() {
                stack[waiting] = (top as u8, index as u32);
                waiting += 1;
            }
        }
        while waiting > 0 {
            waiting -= 1;
            let (level, index) = stack[waiting];
            let first = index as usize * WIDTH;
            let mut met = self.met(line, level as usize, index as usize, &known);
            while met != 0 {
                let child = first + met.trailing_zeros() as usize;
                met &= met - 1;
                if level > 0 {
                    stack[waiting] = (level - 1, child as u32);
                    waiting += 1;
                } else if found(self.order[child] as usize) {
                    return true;
                }
            }
        }
        false
    }

    /// Which children of a node a line may meet, a bit for each.
    fn met(&self, line: &Skewer, level: usize, index: usize, known: impl Fn(usize) -> Known) -> u8 {
        let slot = &self.levels[level][index];
        if let Some(node) = slot.get() {
            return node.met(line);
        }
        let mut boxes = [None; WIDTH];
        let (mut missed, mut kept) = (0, true);
        let below = if level > 0 {
            self.levels[level - 1].len()
        } else {
            self.order.len()
        };
        let children = index * WIDTH..below.min((index + 1) * WIDTH);
        let count = children.len();
        for (k, child) in children.enumerate() {
            if level > 0 {
                let node = self.levels[level - 1][child].get();
                boxes[k] = node.and_then(|n| n.whole);
                kept &= node.is_some();
            } else {
                match known(self.order[child] as usize) {
                    Known::Box(b) => boxes[k] = b,
                    Known::Missed => {
                        missed |= 1 << k;
                        kept = false;
                    }
                }
            }
        }
        let node = Node::new(&boxes[..count], level);
        let met = node.met(line) & !missed;
        if kept {
            slot.get_or_init(|| node);
        }
        met
    }
}

/// The points' numbers, those near each other together: halved again and again across the longest side of the box around them, at
/// multiples of whole nodes.
fn order(points: &[[f64; 3]]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    let mut runs = Vec::from_iter(std::iter::once(0..points.len()));
    while let Some(run) = runs.pop() {
        if run.len() <= WIDTH {
            continue;
        }
        let sides = [0, 1, 2].map(|c| {
            let ends = order[run.clone()].iter().fold(
                [f64::INFINITY, f64::NEG_INFINITY],
                |[low, high], k| {
                    let x = points[*k as usize][c];
                    [low.min(x), high.max(x)]
                },
            );
            ends[1] - ends[0]
        });
        let longest = if sides[0] >= sides[1] && sides[0] >= sides[2] {
            0
        } else if sides[1] >= sides[2] {
            1
        } else {
            2
        };
        let mut unit = WIDTH;
        while unit * WIDTH < run.len() {
            unit *= WIDTH;
        }
        let low = (run.len() / 2).div_ceil(unit) * unit;
        // Of points level with each other, the numbers tell: the order is one and the same on every run.
        order[run.clone()].select_nth_unstable_by(low, |a, b| {
            let by = points[*a as usize][longest].total_cmp(&points[*b as usize][longest]);
            by.then(a.cmp(b))
        });
        runs.push(run.start..run.start + low);
        runs.push(run.start + low..run.end);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(seed: &mut u64) -> f64 {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        (*seed >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Small boxes, flat ones, points, an unknown one; lines through points of them, which must all be found, and few others.
    #[test]
    fn lines_find_the_boxes_that_they_meet() {
        let mut seed = 0x853c_49e6_748f_ea9b;
        for count in [0, 1, 7, 8, 9, 64, 65, 600, 4100] {
            let mut boxes: Vec<Option<Box3>> = (0..count)
                .map(|k| {
                    let side = 0.02 * random(&mut seed);
                    let flat = random(&mut seed);
                    let b = [0, 1, 2].map(|c| {
                        let low = 10.0 * random(&mut seed) + 1e3;
                        let thin = flat < 0.3 && c == k % 3 || flat < 0.05;
                        [low, if thin { low } else { low + side }]
                    });
                    Some(b)
                })
                .collect();
            if count > 8 {
                boxes[5] = None;
            }
            let points: Vec<[f64; 3]> = boxes
                .iter()
                .map(|b| b.map_or([0.0; 3], |b| b.map(|r| r[0])))
                .collect();
            let tree = BoxTree::new(&points);
            let mut others = 0;
            for k in 0..count.min(200) {
                let Some(b) = boxes[k] else { continue };
                let at = b.map(|r| r[0] + (r[1] - r[0]) * random(&mut seed).min(1.0));
                let mut direction = [0, 1, 2].map(|_| random(&mut seed) - 0.5);
                if k % 5 == 0 {
                    direction[k % 3] = 0.0;
                }
                if k % 7 == 0 {
                    direction = [0.0, 0.0, if k % 2 == 0 { 1.0 } else { -1e-30 }];
                }
                // From the box's own point, so that the line is exactly through it.
                let line = Skewer {
                    origin: at,
                    direction,
                    has_ends: false,
                };
                for _ in 0..2 {
                    let mut found = Vec::new();
                    let known = |i: usize| Known::Box(boxes[i]);
                    assert!(!tree.any(&line, known, |i| {
                        found.push(i);
                        false
                    }));
                    assert!(found.contains(&k));
                    assert!(count <= 8 || found.contains(&5));
                    others += found.len() - 1;
                    found.sort_unstable();
                    assert!(found.windows(2).all(|w| w[0] < w[1]));
                }
            }
            assert!(others <= 2 * 200 * (2 + count / 50), "{others} of {count}");
        }
    }

    /// A box that was not made is asked for again; what made it missed is not found.
    #[test]
    fn boxes_are_made_when_a_line_comes() {
        let tree = BoxTree::new(&[[0.0; 3]; 20]);
        let line = Skewer {
            origin: [0.0; 3],
            direction: [1.0, 0.0, 0.0],
            has_ends: false,
        };
        let unit = Known::Box;
        let mut found = 0;
        let mut count = |_: usize| {
            found += 1;
            false
        };
        let half = |i: usize| match i % 2 {
            0 => Known::Missed,
            _ => unit(Some([[-1.0, 1.0]; 3])),
        };
        tree.any(&line, half, &mut count);
        tree.any(&line, |_| unit(Some([[-1.0, 1.0]; 3])), &mut count);
        tree.any(&line, |_| unreachable!("they are kept"), &mut count);
        assert_eq!(found, 10 + 20 + 20);
    }

    /// What a line finds is the same whatever lines came before it, to the last digit: lines that all but touch the corners of boxes, some of which
    /// are not made at first.
    #[test]
    fn earlier_lines_change_nothing() {
        let mut seed = 0x853c_49e6_748f_ea9b;
        let (mut all, mut beside) = (0, 0);
        for round in 0..4000 {
            let count = 17 + round % 60;
            let boxes: Vec<Box3> = (0..count)
                .map(|_| {
                    let large = random(&mut seed) < 0.2;
                    [0, 1, 2].map(|_| {
                        let low = 4.0 * random(&mut seed) - 2.0;
                        [
                            low,
                            low + if large { 3.0 } else { 0.25 } * random(&mut seed),
                        ]
                    })
                })
                .collect();
            let points: Vec<[f64; 3]> = boxes.iter().map(|b| b.map(|r| r[0])).collect();
            let near = |r: f64| r * (1.0 + 16.0 * f64::EPSILON * (random_of(r) - 0.5));
            let corner = boxes[round % count].map(|r| near(r[round % 2]));
            let mut direction = [0, 1, 2].map(|_| random(&mut seed) - 0.5);
            direction[round % 3] = 0.0;
            let back = 8.0 * random(&mut seed);
            let line = Skewer {
                origin: [0, 1, 2].map(|c| corner[c] - back * direction[c]),
                direction,
                has_ends: false,
            };
            let other = Skewer {
                origin: [0.0; 3],
                direction: [random(&mut seed), random(&mut seed), random(&mut seed)],
                has_ends: false,
            };
            let tree = BoxTree::new(&points);
            let found = |line: &Skewer, missed: bool| {
                let mut found = Vec::new();
                let known = |i: usize| match missed && i.is_multiple_of(3) {
                    true => Known::Missed,
                    false => Known::Box(Some(boxes[i])),
                };
                tree.any(line, known, |i| {
                    found.push(i);
                    false
                });
                found.retain(|i| !i.is_multiple_of(3));
                found
            };
            let first = found(&line, true);
            let second = found(&line, false);
            found(&other, false);
            assert_eq!((round, &first), (round, &second));
            assert_eq!((round, &first), (round, &found(&line, false)));
            all += first.len();
            beside += usize::from(!first.contains(&(round % count)));
        }
        assert!(all > 4000 && beside > 100, "{all} {beside}");
    }

    /// A number from 0 to 1 made of another's digits.
    fn random_of(x: f64) -> f64 {
        random(&mut (x.to_bits() | 1))
    }
}
