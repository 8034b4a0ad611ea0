//! Where bodies stand.
//!
//! Compounds hold other shapes at locations, and the same as often as they like. A compound that is itself held more than once, or that holds what
//! is, becomes a block, as do compounds in it; what is held only there is made once, where it stands by itself. All else stands where its locations say.

use super::assembly::{Assembly, Body};
use super::motion::Place;
use super::shapes::{Kind, Orientation, Sub};
use super::tokens::fail;
use crate::affine::Affine;
use crate::error::ReadError;
use std::collections::{HashMap, HashSet};

/// A shape as it is held, wherever.
type Node = (usize, Orientation);

/// A body or a block, by its index in [`Sites`].
#[derive(Clone, Copy, Debug)]
pub(super) enum What {
    Body(usize),
    Block(usize),
}

/// A body or a block in its place.
#[derive(Debug)]
pub(super) struct Site {
    pub(super) what: What,
    /// The shape in the table.
    pub(super) shape: usize,
    /// Where it is; `None`: as it stands.
    pub(super) map: Result<Option<Affine>, ReadError>,
}

/// Where everything stands.
#[derive(Debug, Default)]
pub(super) struct Sites {
    pub(super) bodies: Vec<Body>,
    /// What is in no block, in the order of the file.
    pub(super) top: Vec<Site>,
    pub(super) blocks: Vec<Vec<Site>>,
}

/// What is met in blocks, by its index.
#[derive(Default)]
struct Met {
    blocks: HashMap<Node, usize>,
    /// The nodes of these, in order.
    order: Vec<Node>,
    bodies: HashMap<Node, usize>,
}

fn node(sub: &Sub) -> Node {
    (sub.shape, sub.orientation)
}

impl Assembly {
    fn is_compound(&self, shape: usize) -> bool {
        matches!(self.kind(shape), Some(Kind::Compound | Kind::CompSolid))
    }

    fn is_face(&self, shape: usize) -> bool {
        matches!(self.kind(shape), Some(Kind::Face { .. }))
    }

    /// The compounds that become blocks, but for those that only blocks hold. O(size): each is looked into once.
    fn holders(&self) -> HashSet<Node> {
        let mut uses: HashMap<Node, usize> = HashMap::new();
        let mut compounds: Vec<(Node, Vec<Node>)> = Vec::new();
        let mut open = vec![node(&self.tables.root)];
        while let Some(next) = open.pop() {
            if !self.is_compound(next.0) {
                continue;
            }
            let parts = { self.tables.shapes.get(next.0) }.map_or(&[][..], |s| &s.parts);
            let mut held = Vec::new();
            for part in parts.iter().filter(|p| !self.is_face(p.shape)) {
                let inner = (part.shape, part.orientation.within(next.1));
                let count = uses.entry(inner).or_default();
                *count += 1;
                if *count == 1 {
                    open.push(inner);
                }
                held.push(inner);
            }
            compounds.push((next, held));
        }
        let often = |n: &Node| uses.get(n).is_some_and(|count| *count > 1);
        let holders = compounds
            .iter()
            .filter(|(own, held)| often(own) || held.iter().any(often));
        holders.map(|(own, _)| *own).collect()
    }

    /// The body of a shape that is no compound.
    fn body(&mut self, of: Sub) -> Result<Body, ReadError> {
        let mut body = self.nothing(of.shape);
        match self.kind(of.shape) {
            Some(Kind::Solid | Kind::Shell) => self.faces(of, &mut body)?,
            Some(Kind::Face { .. }) => body.faces.push(of),
            _ => {}
        }
        Ok(body)
    }

    /// A body without faces.
    fn nothing(&self, shape: usize) -> Body {
        Body {
            shape,
            class: self.kind(shape).map_or("shape", Kind::name),
            faces: Vec::new(),
            skipped: 0,
        }
    }

    /// The body of the faces that lie loose in a compound, if there are any, and what else it holds.
    fn compound(&mut self, of: Sub) -> Result<(Option<Body>, Vec<Sub>), ReadError> {
        let (faces, others) = { self.parts(of)?.into_iter() }.partition(|p| self.is_face(p.shape));
        let body = Body {
            faces,
            ..self.nothing(of.shape)
        };
        Ok(((!body.faces.is_empty()).then_some(body), others))
    }

    /// All that becomes an object.
    pub(super) fn sites(&mut self) -> Result<Sites, ReadError> {
        let holders = self.holders();
        let mut sites = Sites::default();
        let mut met = Met::default();
        let mut open = vec![self.tables.root];
        while let Some(next) = open.pop() {
            let mut site = Site {
                what: What::Body(sites.bodies.len()),
                shape: next.shape,
                map: Ok(None),
            };
            if holders.contains(&node(&next)) {
                site.what = What::Block(met.block(node(&next)));
                site.map = self.map(next);
            } else if self.is_compound(next.shape) {
                let (body, others) = self.compound(next)?;
                open.extend(others.into_iter().rev());
                let Some(body) = body else {
                    continue;
                };
                sites.bodies.push(body);
            } else {
                let body = self.body(next)?;
                sites.bodies.push(body);
            }
            sites.top.push(site);
        }
        while let Some(&(shape, orientation)) = met.order.get(sites.blocks.len()) {
            let here = Sub {
                shape,
                orientation,
                place: Place::HERE,
            };
            let mut members = Vec::new();
            let (body, others) = self.compound(here)?;
            if let Some(body) = body {
                members.push(Site {
                    what: What::Body(sites.bodies.len()),
                    shape,
                    map: Ok(None),
                });
                sites.bodies.push(body);
            }
            for part in others {
                let what = if self.is_compound(part.shape) {
                    What::Block(met.block(node(&part)))
                } else {
                    let next = sites.bodies.len();
                    let index = *met.bodies.entry(node(&part)).or_insert(next);
                    if index == next {
                        let place = Place::HERE;
                        let body = self.body(Sub { place, ..part })?;
                        sites.bodies.push(body);
                    }
                    What::Body(index)
                };
                members.push(Site {
                    what,
                    shape: part.shape,
                    map: self.map(part),
                });
            }
            sites.blocks.push(members);
        }
        Ok(sites)
    }

    /// Where a part of a compound is in it.
    fn map(&self, part: Sub) -> Result<Option<Affine>, ReadError> {
        let map = self.tables.places.affine(part.place);
        map.map_err(|problem| fail(self.line(part.shape), problem))
    }
}

impl Met {
    fn block(&mut self, node: Node) -> usize {
        let next = self.order.len();
        let index = *self.blocks.entry(node).or_insert(next);
        if index == next {
            self.order.push(node);
        }
        index
    }
}
