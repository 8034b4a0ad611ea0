//! Blocks: objects that stand together and that references place, each kept once however often it is placed.
//!
//! A .3dm file has block definitions and references to them, a STEP file assemblies, a .brep file shapes at locations. A few of them that
//! place each other twice make thousands of copies of a part: memory of a [`Document`] does not grow with them. What a reference places is told one by
//! one ([`Document::placements`]), as the object and the map it is under, and moved there only when that is asked for.

use crate::affine::{Affine, MapError, composed, rounded_up};
use crate::document::{Document, Object, ObjectKind};
use crate::error::{Problem, ReadError};
use crate::numbers::{numbers, numbers_of_curve};
use crate::rescale::moved_curve;
use feeler::brep::Brep;
use std::borrow::Cow;

/// A block. No block of a [`Document`] holds itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Its name; empty if it has none.
    pub name: String,
    /// What it consists of, in the file's order.
    pub members: Vec<Member>,
    /// What was odd about it.
    pub warnings: Vec<String>,
}

/// What a block consists of.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Which object or block.
    pub of: MemberOf,
    /// Where it is in the block; `None`: as it stands. (Boxed: most lists are of objects as they stand.)
    pub map: Option<Box<Affine>>,
    /// Whether the reference that places it in the block, or that one's layer, is hidden.
    pub hidden: bool,
    /// The same of locked.
    pub locked: bool,
}

impl Member {
    /// One that is neither hidden nor locked.
    pub(crate) fn new(of: MemberOf, map: Option<Box<Affine>>) -> Self {
        Self {
            of,
            map,
            hidden: false,
            locked: false,
        }
    }
}

/// An object or a block, by its index in the [`Document`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemberOf {
    /// One of [`Document::objects`].
    Object(usize),
    /// One of [`Document::blocks`].
    Block(usize),
}

/// An object where a reference places it, not moved yet.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement<'d> {
    /// Its index in [`Document::objects`].
    pub index: usize,
    /// The object.
    pub object: &'d Object,
    /// Where it is; `None`: as it stands.
    pub map: Option<Affine>,
    /// Whether it is hidden, by itself or by a reference within the block that places it. (Of the outermost reference ask the object that it is.)
    pub hidden: bool,
    /// The same of locked.
    pub locked: bool,
}

impl<'d> Placement<'d> {
    /// The object moved there, hidden or locked where this is. Its last warning then has the bound on how far that is off, if anything was rounded; what other warnings say of lengths holds
    /// where the object stands by itself. What cannot be moved becomes [`ObjectKind::Refused`].
    ///
    /// # Cost
    /// O(size) where there is a map.
    pub fn placed(&self) -> Cow<'d, Object> {
        self.placed_within().0
    }

    /// The same, with the bound; 0: nothing was rounded.
    pub(crate) fn placed_within(&self) -> (Cow<'d, Object>, f64) {
        let (hidden, locked) = (self.hidden, self.locked);
        let is_marked = (hidden, locked) == (self.object.hidden, self.object.locked);
        let as_it_stands = || {
            let object = match is_marked {
                true => Cow::Borrowed(self.object),
                false => Cow::Owned(Object {
                    hidden,
                    locked,
                    ..self.object.clone()
                }),
            };
            (object, 0.0)
        };
        let Some(map) = &self.map else {
            return as_it_stands();
        };
        let moved = |brep: &Brep, kind: fn(Brep) -> ObjectKind| {
            map.apply(brep).map(|moved| (kind(moved.brep), moved.off))
        };
        let moved = match &self.object.kind {
            ObjectKind::Brep(brep) => moved(brep, ObjectKind::Brep),
            ObjectKind::Surface(brep) => moved(brep, ObjectKind::Surface),
            ObjectKind::Extrusion(brep) => moved(brep, ObjectKind::Extrusion),
            ObjectKind::Curve(curve) => {
                moved_curve(curve, map).map(|(curve, off)| (ObjectKind::Curve(curve), off))
            }
            _ => return as_it_stands(),
        };
        let (kind, off) = moved.unwrap_or_else(|problem| (self.refused(&problem), 0.0));
        let mut warnings = self.object.warnings.clone();
        if off > 0.0 {
            warnings.push(format!(
                "moved to where a block reference puts it: coordinates are rounded, off by no more than {}",
                rounded_up(off)
            ));
        }
        let object = Object {
            name: self.object.name.clone(),
            layer: self.object.layer.clone(),
            hidden,
            locked,
            kind,
            warnings,
            ..*self.object
        };
        (Cow::Owned(object), off)
    }

    fn refused(&self, problem: &MapError) -> ObjectKind {
        ObjectKind::Refused {
            class: format!("Brep of a block ({})", self.object.kind.name()),
            reason: ReadError::Object {
                at: self.object.offset,
                problem: Box::new(Problem::Block {
                    why: problem.to_string(),
                }),
            },
        }
    }
}

/// What a reference places, one after the other: see [`Document::placements`].
#[derive(Clone, Debug)]
pub struct Placements<'d> {
    document: &'d Document,
    /// What is no reference stands for itself.
    itself: Option<Placement<'d>>,
    /// Blocks that are gone through, the outermost first: a list, not the machine's stack.
    open: Vec<Open<'d>>,
}

/// A block that is gone through.
#[derive(Clone, Debug)]
struct Open<'d> {
    members: std::slice::Iter<'d, Member>,
    map: Option<Affine>,
    hidden: bool,
    locked: bool,
}

impl<'d> Iterator for Placements<'d> {
    type Item = Placement<'d>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Some(itself) = self.itself.take() {
            return Some(itself);
        }
        loop {
            let outer = self.open.last_mut()?;
            let Some(member) = outer.members.next() else {
                self.open.pop();
                continue;
            };
            let map = composed(outer.map.as_ref(), member.map.as_deref());
            let (hidden, locked) = (outer.hidden || member.hidden, outer.locked || member.locked);
            match member.of {
                MemberOf::Object(index) => {
                    if let Some(object) = self.document.objects.get(index) {
                        return Some(Placement {
                            index,
                            object,
                            map,
                            hidden: hidden || object.hidden,
                            locked: locked || object.locked,
                        });
                    }
                }
                MemberOf::Block(block) => {
                    if let Some(block) = self.document.blocks.get(block) {
                        self.open.push(Open {
                            members: block.members.iter(),
                            map,
                            hidden,
                            locked,
                        });
                    }
                }
            }
        }
    }
}

impl Document {
    /// What the object of this index places: the members of its block, of blocks within it too, if it is a reference, else itself. What is placed is
    /// never a reference. Nothing if there is no such object.
    pub fn placements(&self, index: usize) -> Placements<'_> {
        let mut placements = Placements {
            document: self,
            itself: None,
            open: Vec::new(),
        };
        match self.objects.get(index) {
            Some(Object {
                kind: ObjectKind::Block { block, map },
                ..
            }) => {
                if let Some(block) = self.blocks.get(*block) {
                    placements.open.push(Open {
                        members: block.members.iter(),
                        map: map.as_deref().cloned(),
                        hidden: false,
                        locked: false,
                    });
                }
            }
            Some(object) => {
                placements.itself = Some(Placement {
                    index,
                    object,
                    map: None,
                    hidden: object.hidden,
                    locked: object.locked,
                });
            }
            None => {}
        }
        placements
    }

    /// All blocks that the object of this index places, each once, if it is a reference.
    pub fn placed_blocks(&self, index: usize) -> Vec<&Block> {
        let mut found = Vec::new();
        let mut seen = vec![false; self.blocks.len()];
        let mut open = Vec::new();
        if let Some(ObjectKind::Block { block, .. }) = self.objects.get(index).map(|o| &o.kind) {
            open.push(*block);
        }
        while let Some(block) = open.pop() {
            let (Some(own), Some(seen)) = (self.blocks.get(block), seen.get_mut(block)) else {
                continue;
            };
            if std::mem::replace(seen, true) {
                continue;
            }
            found.push(own);
            open.extend(own.members.iter().rev().filter_map(|m| match m.of {
                MemberOf::Block(inner) => Some(inner),
                MemberOf::Object(_) => None,
            }));
        }
        found
    }

    /// What it [places](Self::placements), moved there.
    pub fn parts(&self, index: usize) -> impl Iterator<Item = Cow<'_, Object>> {
        self.placements(index).map(|p| p.placed())
    }
}

/// How much the references of a file may place in all: so many objects and blocks...
pub(crate) const PLACED: usize = 100_000;
/// ...and so many numbers in them (512 MB), and for each byte of the file. Nothing of this is made while reading.
const NUMBERS: usize = 1 << 26;
const NUMBERS_PER_BYTE: usize = 8;

/// What is wrong with a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    /// Its block holds itself.
    Itself,
    /// It places more than is left.
    TooMuch,
}

/// What a block places: objects and blocks, and the numbers in them.
#[derive(Clone, Copy, Default)]
struct Weight {
    places: usize,
    numbers: usize,
}

impl Weight {
    fn plus(self, other: Self) -> Self {
        Self {
            places: self.places.saturating_add(other.places),
            numbers: self.numbers.saturating_add(other.numbers),
        }
    }

    fn of_object(object: &Object) -> Self {
        let numbers = match &object.kind {
            ObjectKind::Brep(b) | ObjectKind::Surface(b) | ObjectKind::Extrusion(b) => numbers(b),
            ObjectKind::Curve(curve) => numbers_of_curve(curve),
            _ => 0,
        };
        Self { places: 1, numbers }
    }
}

/// Blocks, those that others hold before these; where one holds itself not all are. O(size).
fn inner_first(blocks: &[Block]) -> Vec<usize> {
    let mut order = Vec::with_capacity(blocks.len());
    let mut seen = vec![false; blocks.len()];
    for first in 0..blocks.len() {
        // Each with the members that are not looked at yet: a list, not the machine's stack.
        let mut open: Vec<(usize, std::slice::Iter<'_, Member>)> = Vec::new();
        let mut next = Some(first);
        loop {
            if let Some(block) = next.take()
                && let Some(seen) = seen.get_mut(block)
                && !std::mem::replace(seen, true)
            {
                let members = blocks.get(block).map_or(&[][..], |b| &b.members);
                open.push((block, members.iter()));
            }
            let Some((block, members)) = open.last_mut() else {
                break;
            };
            match members.next() {
                Some(member) => {
                    if let MemberOf::Block(inner) = member.of {
                        next = Some(inner);
                    }
                }
                None => {
                    order.push(*block);
                    open.pop();
                }
            }
        }
    }
    order
}

/// What each block places; `None` of one that holds itself or one that does. O(size) whatever they unfold to.
fn weights(document: &Document) -> Vec<Option<Weight>> {
    let own: Vec<Weight> = document.objects.iter().map(Weight::of_object).collect();
    // One that is not known when it is asked for is within itself.
    let mut known: Vec<Option<Weight>> = vec![None; document.blocks.len()];
    for block in inner_first(&document.blocks) {
        let itself = Weight {
            places: 1,
            numbers: 0,
        };
        let members = { document.blocks.get(block) }.map_or(&[][..], |b| &b.members);
        let found = members.iter().map(|m| match m.of {
            MemberOf::Object(object) => own.get(object).copied(),
            MemberOf::Block(inner) => known.get(inner).copied().flatten(),
        });
        let sum = { found }.try_fold(itself, |sum, found| Some(sum.plus(found?)));
        if let Some(known) = known.get_mut(block) {
            *known = sum;
        }
    }
    known
}

/// How far from their exact places the exact maps of a document take points, where objects by themselves are off by `off` and each coordinate of each map's translation by
/// one rounding.
///
/// Of `x -> M x + t` with a point off by `e` and `t` off by `r` in norm the image is off by `|M| e + r` at most: `|M|` is no more than [`Affine::stretch`], and `r` no more than
/// half of [`Affine::rounding`], whose other half has room for the few roundings of this sum, each an epsilon of what it is a bound of; `stretch` is 1e-12 of itself too large
/// for the same. From block to block by induction, the inner ones first.
pub(crate) fn carried(document: &Document, off: f64) -> f64 {
    let through = |map: Option<&Affine>, inner: f64| match map {
        Some(map) => map.stretch() * inner + map.rounding(),
        None => inner,
    };
    let mut known = vec![off; document.blocks.len()];
    for block in inner_first(&document.blocks) {
        let members = { document.blocks.get(block) }.map_or(&[][..], |b| &b.members);
        let most = { members.iter() }.map(|m| {
            let inner = match m.of {
                MemberOf::Object(_) => off,
                MemberOf::Block(inner) => known.get(inner).copied().unwrap_or(off),
            };
            through(m.map.as_deref(), inner)
        });
        let most = most.fold(off, f64::max);
        if let Some(known) = known.get_mut(block) {
            *known = most;
        }
    }
    let references = document.objects.iter().filter_map(|o| match &o.kind {
        ObjectKind::Block { block, map } => Some(through(map.as_deref(), *known.get(*block)?)),
        _ => None,
    });
    references.fold(off, f64::max)
}

/// Looks at the blocks of a document of so many bytes, once all is read: empties those that hold themselves, and tells which references cannot be taken, by the index of their object.
pub(crate) fn faults(document: &mut Document, bytes: usize) -> Vec<(usize, Fault)> {
    let weights = weights(document);
    for (block, weight) in document.blocks.iter_mut().zip(&weights) {
        if weight.is_none() {
            block.members = Vec::new();
        }
    }
    let mut left = Weight {
        places: PLACED,
        numbers: NUMBERS.saturating_add(NUMBERS_PER_BYTE.saturating_mul(bytes)),
    };
    let mut faults = Vec::new();
    for (index, object) in document.objects.iter().enumerate() {
        let ObjectKind::Block { block, .. } = &object.kind else {
            continue;
        };
        let Some(weight) = weights.get(*block).copied().flatten() else {
            faults.push((index, Fault::Itself));
            continue;
        };
        let places = left.places.checked_sub(weight.places);
        match places.zip(left.numbers.checked_sub(weight.numbers)) {
            Some((places, numbers)) => left = Weight { places, numbers },
            None => faults.push((index, Fault::TooMuch)),
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::affine::tests::{exact, image, rows};
    use crate::units::Units;
    use feeler::brep::BrepBuilder;

    /// A part of a millimetre, a million times as large far away, twice over: in other units the maps take its corners to where they were, within what is said, and to
    /// no nearer than what is said of the part alone.
    #[test]
    fn converted_maps_lead_to_where_parts_were() {
        let mut b = BrepBuilder::new();
        let v = [[0.1, 0.2, 0.3], [0.7, 0.4, 0.3], [0.6, 0.3, 0.9]].map(|p| b.vertex(p));
        b.planar_face(&v).expect("a triangle");
        let mut document = Document::of_breps(vec![b.build().expect("a BREP")]);
        document.units = Units::Millimetres;
        let far = |scale: f64| {
            let mut map = [0.0; 16];
            (map[0], map[5], map[10], map[15]) = (scale, scale, scale, 1.0);
            (map[3], map[7]) = (1e9 / 3.0, -1e8 / 7.0);
            Some(Box::new(Affine::from_rows(&map).expect("a map")))
        };
        for (of, map) in [
            (MemberOf::Object(0), far(1e6)),
            (MemberOf::Block(0), far(3.0)),
        ] {
            document.blocks.push(Block {
                name: String::new(),
                members: vec![Member::new(of, map)],
                warnings: Vec::new(),
            });
        }
        let mut reference = document.objects[0].clone();
        document.objects[0].block_member = true;
        reference.kind = ObjectKind::Block {
            block: 1,
            map: None,
        };
        document.objects.push(reference);
        let mut feet = document.clone();
        let off = feet.convert_units(Units::Feet).expect("millimetres");
        let factor = exact(Units::Millimetres.ratio(&Units::Feet).expect("lengths"));
        let mut most: f64 = 0.0;
        // Each through its own maps, exactly.
        let through = |d: &Document, k: usize| {
            let corner = d.objects[0].body().expect("a triangle").parts().vertices[k].point;
            let point = [0, 1, 2].map(|c| exact(corner[c]));
            d.blocks.iter().fold(point, |p, block| {
                let map = block.members[0].map.as_ref().expect("a map");
                image(&rows(map), &p)
            })
        };
        for k in 0..3 {
            for (a, b) in through(&document, k).iter().zip(&through(&feet, k)) {
                most = most.max((&(a * &factor) - b).approximate().abs());
            }
        }
        assert!(most <= off, "{most:e} {off:e}");
        // A thousandth of a foot is the part's size.
        assert!(most > 1e3 * f64::EPSILON, "{most:e}");
    }
}
