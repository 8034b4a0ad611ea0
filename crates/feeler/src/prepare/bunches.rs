//! Boxes around bunches of things that lie near each other, one after the other along a boundary, and around bunches of these: what is far from a
//! query is put aside by the bunch.

use super::{Box3, around};

/// So many things, or bunches, are in one.
const WIDTH: usize = 8;
/// Of so few each is looked at.
pub(crate) const FEW: usize = 3 * WIDTH;

/// A tree of boxes. The bunch `i` of the lowest level holds the things `8 i` to `8 i + 7`, of another the bunches `8 i` to `8 i + 7` below it.
#[derive(Debug)]
pub(crate) struct Bunches {
    /// How many things there are.
    count: usize,
    /// The boxes of each level, the lowest first; `None` around what is not known.
    levels: Vec<Box<[Option<Box3>]>>,
}

/// One of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Bunch {
    level: u8,
    index: u32,
}

impl Bunches {
    /// Around boxes of things in their order.
    pub(super) fn new(boxes: impl Iterator<Item = Option<Box3>>) -> Self {
        let (mut count, mut bunch) = (0, Vec::with_capacity(WIDTH));
        let mut lowest = Vec::new();
        for b in boxes {
            count += 1;
            bunch.push(b);
            if bunch.len() == WIDTH {
                lowest.push(together(&bunch));
                bunch.clear();
            }
        }
        if !bunch.is_empty() {
            lowest.push(together(&bunch));
        }
        let mut levels = vec![lowest.into_boxed_slice()];
        while let Some(last) = levels.last()
            && last.len() > WIDTH
        {
            levels.push(last.chunks(WIDTH).map(together).collect());
        }
        Self { count, levels }
    }

    /// Those of the highest level: at most as many as are in one.
    pub(crate) fn highest(&self) -> impl Iterator<Item = Bunch> + use<> {
        let level = self.levels.len() - 1;
        bunches(level, 0..self.levels[level].len())
    }

    /// The box of a bunch; `None` where something in it is not known.
    pub(crate) fn bounds(&self, bunch: Bunch) -> Option<&Box3> {
        self.levels[usize::from(bunch.level)][bunch.index as usize].as_ref()
    }

    /// What is in a bunch.
    pub(crate) fn within(&self, bunch: Bunch) -> Within<impl Iterator<Item = Bunch> + use<>> {
        match bunch.level.checked_sub(1).map(usize::from) {
            Some(below) => {
                Within::Bunches(bunches(below, members(bunch, self.levels[below].len())))
            }
            None => Within::Things(members(bunch, self.count)),
        }
    }

    /// The things in a bunch and in those within it.
    pub(crate) fn all_within(&self, bunch: Bunch) -> std::ops::Range<usize> {
        let each = WIDTH.pow(u32::from(bunch.level) + 1);
        let first = bunch.index as usize * each;
        first..(first + each).min(self.count)
    }

    /// The first thing from `from` on that is in no bunch which is not near, of those that begin with it or after it.
    pub(crate) fn next(&self, from: usize, near: impl Fn(&Box3) -> bool) -> Option<usize> {
        let mut thing = from;
        'things: while thing < self.count {
            // The widest that begins here comes first.
            for (level, boxes) in self.levels.iter().enumerate().rev() {
                let each = WIDTH.pow(level as u32 + 1);
                let is_far = |b: &Box3| !near(b);
                if thing.is_multiple_of(each) && boxes[thing / each].as_ref().is_some_and(is_far) {
                    thing += each;
                    continue 'things;
                }
            }
            return Some(thing);
        }
        None
    }

    pub(super) fn bytes(&self) -> usize {
        let boxes = self.levels.iter().map(|l| size_of_val(&**l));
        size_of::<Self>()
            + self.levels.capacity() * size_of::<Box<[Option<Box3>]>>()
            + boxes.sum::<usize>()
    }
}

/// Of a bunch: the bunches in it or, of one of the lowest level, the numbers of the things.
pub(crate) enum Within<B> {
    Bunches(B),
    Things(std::ops::Range<usize>),
}

fn bunches(level: usize, range: std::ops::Range<usize>) -> impl Iterator<Item = Bunch> {
    range.map(move |index| Bunch {
        level: level as u8,
        index: index as u32,
    })
}

/// The numbers of what is in a bunch, of `count` below it.
fn members(bunch: Bunch, count: usize) -> std::ops::Range<usize> {
    let first = bunch.index as usize * WIDTH;
    first..(first + WIDTH).min(count)
}

fn together(boxes: &[Option<Box3>]) -> Option<Box3> {
    let known: Option<Vec<Box3>> = boxes.iter().copied().collect();
    known.map(|k| around(&k))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every thing is in just one bunch of each level, whose box holds its own, for as many as make one level and three.
    #[test]
    fn bunches_hold_each_thing_once() {
        for count in [1, 7, 8, 9, 64, 65, 600] {
            let box_of = |i: usize| [[i as f64, i as f64 + 0.5], [-(i as f64), 1.0], [0.0, 0.0]];
            let tree = Bunches::new((0..count).map(|i| Some(box_of(i))));
            let mut open: Vec<Bunch> = tree.highest().collect();
            assert!((1..=WIDTH).contains(&open.len()));
            let mut seen = Vec::new();
            while let Some(bunch) = open.pop() {
                let own = tree.bounds(bunch).unwrap();
                for i in tree.all_within(bunch) {
                    for (out, b) in own.iter().zip(box_of(i)) {
                        assert!(out[0] <= b[0] && b[1] <= out[1]);
                    }
                }
                match tree.within(bunch) {
                    Within::Bunches(more) => open.extend(more),
                    Within::Things(range) => {
                        assert_eq!(range, tree.all_within(bunch));
                        seen.extend(range);
                    }
                }
            }
            seen.sort_unstable();
            assert_eq!(seen, (0..count).collect::<Vec<_>>());
        }
    }

    /// What is not known leaves those that hold it without a box, and no other.
    #[test]
    fn what_is_not_known_is_in_no_box() {
        let tree = Bunches::new((0..100).map(|i| (i != 42).then_some([[0.0, 1.0]; 3])));
        let unknown = |level: u8| {
            let all = tree.levels[usize::from(level)].iter().enumerate();
            let none = all.filter(|(_, b)| b.is_none()).map(|(i, _)| i);
            none.collect::<Vec<_>>()
        };
        assert_eq!(unknown(0), [5]);
        assert_eq!(unknown(1), [0]);
    }
}
