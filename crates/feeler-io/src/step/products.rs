//! Representations and what relates them: assemblies, placements, names. [`sites`](super::sites) says where bodies stand.
//!
//! A representation is a list of items in one context. Bodies among its items are in it, as are representations that it maps
//! (`MAPPED_ITEM`) and those related to it by a transformation (`CONTEXT_DEPENDENT_SHAPE_REPRESENTATION`, the assembly's way); a plain
//! `SHAPE_REPRESENTATION_RELATIONSHIP` says that two are of one thing, in one frame. What is in no other is placed as it
//! stands.

use super::context::{Context, context};
use super::entities::{Entities, unsupported};
use super::geometry::Geometry;
use super::part21::{Attribute, Part};
use crate::affine::{Affine, composed};
use crate::error::ReadError;
use crate::occt::surfaces::Axes;
use crate::units::Units;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// The longest name of an object, in bytes: each placed part has its own.
const LONGEST_NAME: usize = 256;

/// Kinds of items that become objects.
pub(super) const BODIES: [&str; 5] = [
    "MANIFOLD_SOLID_BREP",
    "BREP_WITH_VOIDS",
    "FACETED_BREP",
    "SHELL_BASED_SURFACE_MODEL",
    "FACE_BASED_SURFACE_MODEL",
];
/// Kinds of items that are geometry, but no BREP here: said, not read.
const OTHERS: [(&str, &str); 9] = [
    ("GEOMETRIC_CURVE_SET", "curves"),
    ("GEOMETRIC_SET", "curves and points"),
    ("TESSELLATED_SOLID", "mesh"),
    ("TESSELLATED_SHELL", "mesh"),
    ("TRIANGULATED_FACE_SET", "mesh"),
    ("COMPLEX_TRIANGULATED_FACE_SET", "mesh"),
    ("EDGE_BASED_WIREFRAME_MODEL", "wireframe"),
    ("SHELL_BASED_WIREFRAME_MODEL", "wireframe"),
    ("CSG_SOLID", "CSG solid"),
];

pub(super) struct Child {
    pub(super) of: u64,
    /// The representation that it is in.
    within: u64,
    /// From which placement, in its own units, to which in those of the representation.
    placement: Option<(Axes, Axes)>,
    /// From the units of what stands for the one to those of what stands for the other.
    pub(super) map: Option<Affine>,
}

#[derive(Default)]
pub(super) struct Representation {
    pub(super) bodies: Vec<u64>,
    others: Vec<&'static str>,
    pub(super) children: Vec<Child>,
    context: Option<u64>,
    /// From its units to those of what stands for it.
    pub(super) scale: Option<Affine>,
}

/// The representations of a file.
pub(super) struct Products {
    pub(super) all: BTreeMap<u64, Representation>,
    /// The one that stands for all that are of one thing.
    same: HashMap<u64, u64>,
    pub(super) names: HashMap<u64, String>,
    /// The representation of each product definition.
    shapes: HashMap<u64, u64>,
    pub(super) others: BTreeMap<&'static str, usize>,
}

/// The matrix of a placement, by rows, and its inverse.
fn matrices(a: &Axes) -> [[f64; 16]; 2] {
    let o = a.origin.coords;
    let (x, y, z) = (a.x, a.y, a.z);
    let b = [-x.dot(&o), -y.dot(&o), -z.dot(&o)];
    [
        [
            x.x, y.x, z.x, o.x, x.y, y.y, z.y, o.y, x.z, y.z, z.z, o.z, 0.0, 0.0, 0.0, 1.0,
        ],
        [
            x.x, x.y, x.z, b[0], y.x, y.y, y.z, b[1], z.x, z.y, z.z, b[2], 0.0, 0.0, 0.0, 1.0,
        ],
    ]
}

/// The map from one placement to another; `None` where they are one.
fn between(from: &Axes, to: &Axes) -> Option<Affine> {
    let frame = |a: &Axes| (a.origin, a.x, a.y, a.z);
    if frame(from) == frame(to) {
        return None;
    }
    let [_, back] = matrices(from);
    let [forth, _] = matrices(to);
    Some(Affine::from_rows(&forth)?.after(&Affine::from_rows(&back)?))
}

/// The same where the one has other units than the other.
fn scaled(from: &Axes, to: &Axes, scale: &Affine) -> Option<Affine> {
    let [_, back] = matrices(from);
    let [forth, _] = matrices(to);
    let inner = scale.after(&Affine::from_rows(&back)?);
    Some(Affine::from_rows(&forth)?.after(&inner))
}

/// From the units of one representation to those of another; `None` where they are the same, or one is not known.
fn scaling(units: &BTreeMap<u64, Units>, from: u64, to: u64) -> Option<Affine> {
    let (from, to) = (units.get(&from)?, units.get(&to)?);
    if from == to {
        return None;
    }
    from.ratio(to).map(Affine::scaling)
}

fn is_representation(name: &str) -> bool {
    (name == "REPRESENTATION" || name.ends_with("SHAPE_REPRESENTATION"))
        && !name.starts_with("CONTEXT_DEPENDENT")
        && !name.starts_with("PROPERTY")
}

impl Products {
    pub(super) fn read(geometry: &Geometry<'_>) -> Result<Self, ReadError> {
        let entities = geometry.entities;
        let mut products = Self {
            all: BTreeMap::new(),
            same: HashMap::new(),
            names: HashMap::new(),
            shapes: HashMap::new(),
            others: BTreeMap::new(),
        };
        let ids = representations(entities);
        for &id in &ids {
            products.representation(geometry, id)?;
        }
        // Relations without a transformation first: two representations of one thing; but those of an assembly place a part.
        let placing: BTreeSet<u64> = { ids.iter() }
            .filter_map(|id| {
                let e = entities.part(*id, "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION")?;
                e.optional(0)
            })
            .collect();
        for &id in &ids {
            if placing.contains(&id) {
                continue;
            }
            let Some(e) = entities.simple(id) else {
                continue;
            };
            if e.name == "SHAPE_REPRESENTATION_RELATIONSHIP" {
                let (a, b) = (e.reference(2)?, e.reference(3)?);
                if products.all.contains_key(&a) && products.all.contains_key(&b) {
                    products.unite(a, b);
                }
            }
        }
        for id in products.all.keys().copied().collect::<Vec<_>>() {
            products.flatten(id);
        }
        for &id in &ids {
            if let Some((definition, representation)) = definition(entities, id) {
                products.shapes.insert(definition, representation);
            }
        }
        for &id in &ids {
            products.related(geometry, id)?;
        }
        products.named(entities);
        products.map(entities);
        Ok(products)
    }

    /// The maps of children: placements are in the units of their representations.
    fn map(&mut self, entities: &Entities) {
        let units: BTreeMap<u64, Units> = { self.all.keys() }
            .map(|id| {
                let units = self.context(entities, *id).map_or(Units::None, |c| c.units);
                (*id, units)
            })
            .collect();
        let mut all = std::mem::take(&mut self.all);
        for child in all.values_mut().flat_map(|r| &mut r.children) {
            let turned = match (&child.placement, scaling(&units, child.of, child.within)) {
                (Some((from, to)), Some(scale)) => scaled(from, to, &scale),
                (Some((from, to)), None) => between(from, to),
                (None, scale) => scale,
            };
            let first = scaling(&units, self.root(child.of), child.of);
            let last = scaling(&units, child.within, self.root(child.within));
            let inner = composed(turned.as_ref(), first.as_ref());
            child.map = composed(last.as_ref(), inner.as_ref());
        }
        for (id, r) in &mut all {
            r.scale = scaling(&units, *id, self.root(*id));
        }
        self.all = all;
    }

    fn representation(&mut self, geometry: &Geometry<'_>, id: u64) -> Result<(), ReadError> {
        let entities = geometry.entities;
        let mut kinds = entities.kinds(id);
        let is_simple = entities.simple(id).is_some();
        let name = match kinds.find(|k| is_representation(k)) {
            Some(_) if !is_simple => "REPRESENTATION",
            Some(name) => name,
            None => return Ok(()),
        };
        let Some(e) = entities.part(id, name) else {
            return Ok(());
        };
        let mut own = Representation {
            context: e.optional(2),
            ..Representation::default()
        };
        let mut listed = BTreeSet::new();
        for attribute in e.list(1)? {
            let Attribute::EntityRef(item) = attribute else {
                continue;
            };
            // Items are a set: one that is said again is in it already.
            if !listed.insert(*item) {
                continue;
            }
            if let Some(m) = entities.part(*item, "MAPPED_ITEM") {
                let (source, target) = (m.reference(1)?, m.reference(2)?);
                let s = entities.expect(*item, source, "REPRESENTATION_MAP", "what is mapped")?;
                let from = geometry.axes(source, s.reference(0)?)?;
                if !entities.is(target, "AXIS2_PLACEMENT_3D") {
                    return Err(unsupported(
                        *item,
                        format!("a part placed by {}", entities.described(target)),
                        "place it without scaling and export it again",
                    ));
                }
                let to = geometry.axes(*item, target)?;
                own.children.push(Child {
                    of: s.reference(1)?,
                    within: id,
                    placement: Some((from, to)),
                    map: None,
                });
                continue;
            }
            let mut kinds = entities.kinds(*item);
            if kinds.clone().any(|k| BODIES.contains(&k)) {
                own.bodies.push(*item);
            } else if let Some((_, what)) = kinds.find_map(|k| OTHERS.iter().find(|(o, _)| *o == k))
            {
                own.others.push(what);
            }
        }
        for what in &own.others {
            *self.others.entry(what).or_default() += 1;
        }
        self.all.insert(id, own);
        Ok(())
    }

    pub(super) fn root(&self, mut id: u64) -> u64 {
        while let Some(next) = self.same.get(&id) {
            id = *next;
        }
        id
    }

    /// The same; all on the way point at it from now on.
    fn flatten(&mut self, id: u64) -> u64 {
        let root = self.root(id);
        let mut at = id;
        while at != root
            && let Some(next) = self.same.insert(at, root)
        {
            at = next;
        }
        root
    }

    fn unite(&mut self, a: u64, b: u64) {
        let (a, b) = (self.flatten(a), self.flatten(b));
        if a != b {
            self.same.insert(a.max(b), a.min(b));
        }
    }

    /// The relation of an assembly to a part of it.
    fn related(&mut self, geometry: &Geometry<'_>, id: u64) -> Result<(), ReadError> {
        let entities = geometry.entities;
        let Some(e) = entities.part(id, "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION") else {
            return Ok(());
        };
        let relation = e.reference(0)?;
        let simple = entities.simple(relation).is_some();
        let ends = if simple {
            entities.simple(relation).map(|r| (r, 2, 3))
        } else {
            entities
                .part(relation, "REPRESENTATION_RELATIONSHIP")
                .map(|r| (r, 2, 3))
        };
        let Some((r, first, second)) = ends else {
            return Err(entities.unexpected(
                id,
                relation,
                "the relation of a part to its assembly",
            ));
        };
        let (child, parent) = (r.reference(first)?, r.reference(second)?);
        let with = "REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION";
        let transformation = match entities.part(relation, with) {
            Some(t) => t.optional(if simple { 4 } else { 0 }),
            None => None,
        };
        let mut map = None;
        if let Some(t) = transformation {
            let t_e = entities.expect(relation, t, "ITEM_DEFINED_TRANSFORMATION", "a placement")?;
            let from = geometry.axes(t, t_e.reference(2)?)?;
            let to = geometry.axes(t, t_e.reference(3)?)?;
            map = Some((from, to));
        }
        // The product's side says which of the two is the part: the first, by the standard, but some files have them the other way.
        let (mut child, mut parent) = (child, parent);
        if let Some(part) = self.occurrence(entities, e.reference(1)?)
            && self.root(part) == self.root(parent)
            && self.root(part) != self.root(child)
        {
            std::mem::swap(&mut child, &mut parent);
            map = map.map(|(a, b)| (b, a));
        }
        let root = self.root(parent);
        if root == self.root(child) && map.is_none() {
            // Two of one thing, in one frame.
            return Ok(());
        }
        if let Some(p) = self.all.get_mut(&root) {
            p.children.push(Child {
                of: child,
                within: parent,
                placement: map,
                map: None,
            });
        }
        Ok(())
    }

    /// The representation of the part that an occurrence in an assembly is of.
    fn occurrence(&self, entities: &Entities, definition: u64) -> Option<u64> {
        let shape = entities.part(definition, "PRODUCT_DEFINITION_SHAPE")?;
        let occurrence = shape.optional(2)?;
        let part = entities
            .part(occurrence, "NEXT_ASSEMBLY_USAGE_OCCURRENCE")?
            .optional(4)?;
        self.shapes.get(&part).copied()
    }

    fn named(&mut self, entities: &Entities) {
        for (&definition, &representation) in &self.shapes {
            let name = || {
                let d = entities.simple(definition)?;
                let formation = entities.simple(d.optional(2)?)?;
                let product = entities.part(formation.optional(2)?, "PRODUCT")?;
                let [id, name] = [product.text(0), product.text(1)];
                Some(short(if name.is_empty() { id } else { name }))
            };
            if let Some(name) = name() {
                let root = self.root(representation);
                // One name where there are several: the same at each reading.
                let first = self.names.entry(root).or_insert_with(|| name.clone());
                if name < *first {
                    *first = name;
                }
            }
        }
    }

    /// The context of a representation.
    pub(super) fn context(&self, entities: &Entities, representation: u64) -> Option<Context> {
        let id = self.all.get(&representation)?.context?;
        context(entities, id)
    }
}

/// A name of at most [`LONGEST_NAME`] bytes.
pub(super) fn short(name: &str) -> String {
    let mut end = 0;
    for (at, c) in name.char_indices() {
        if at + c.len_utf8() > LONGEST_NAME {
            break;
        }
        end = at + c.len_utf8();
    }
    name.get(..end).unwrap_or_default().to_string()
}

/// The entities that products and their representations are told by, in order: all such kinds are named alike.
fn representations(entities: &Entities) -> Vec<u64> {
    let is_one = |p: &Part| {
        ["REPRESENTATION", "REPRESENTATION_RELATIONSHIP"]
            .iter()
            .any(|end| p.name.ends_with(end))
    };
    { entities.graph().entities.iter() }
        .filter(|(_, e)| e.parts.iter().any(is_one))
        .map(|(id, _)| *id)
        .collect()
}

/// The product definition and the representation that an entity brings together.
fn definition(entities: &Entities, id: u64) -> Option<(u64, u64)> {
    let e = entities.part(id, "SHAPE_DEFINITION_REPRESENTATION")?;
    let shape = entities.part(e.optional(0)?, "PRODUCT_DEFINITION_SHAPE")?;
    Some((shape.optional(2)?, e.optional(1)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How many steps it is from a representation to the one that stands for it.
    fn steps(products: &Products, mut id: u64) -> usize {
        let mut count = 0;
        while let Some(next) = products.same.get(&id) {
            (id, count) = (*next, count + 1);
        }
        count
    }

    /// Files may say of very many representations, two by two, that they are one thing: in whichever order, the ways that are gone are short.
    #[test]
    fn many_of_one_thing_are_brought_together_in_few_steps() {
        const COUNT: u64 = 1 << 11;
        let up: Vec<(u64, u64)> = (1..COUNT).map(|k| (k, k + 1)).collect();
        let down: Vec<(u64, u64)> = up.iter().rev().copied().collect();
        // The far end of the chain that there is, each time.
        let far: Vec<(u64, u64)> = (1..COUNT).rev().map(|k| (COUNT, k)).collect();
        for pairs in [up, down, far] {
            let mut products = Products {
                all: BTreeMap::new(),
                same: HashMap::new(),
                names: HashMap::new(),
                shapes: HashMap::new(),
                others: BTreeMap::new(),
            };
            let mut gone = 0;
            for (a, b) in pairs {
                gone += steps(&products, a) + steps(&products, b);
                products.unite(a, b);
            }
            for id in 1..=COUNT {
                gone += steps(&products, id);
                products.flatten(id);
            }
            assert!((1..=COUNT).all(|id| products.root(id) == 1));
            // n log n bounds what joining with shortened ways costs; a few steps each is what it comes to here.
            let most = COUNT * u64::from(COUNT.ilog2());
            assert!(gone as u64 <= most, "{gone}");
        }
    }
}
