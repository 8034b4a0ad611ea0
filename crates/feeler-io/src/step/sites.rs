//! Where bodies stand: what of a file's products becomes objects, and what blocks.

use super::entities::{Entities, problem};
use super::part21::Part;
use super::products::{BODIES, Products, short};
use crate::affine::{Affine, composed};
use crate::error::ReadError;
use crate::step_problem::StepProblem;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// What stands somewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum What {
    /// A body, by its entity.
    Body(u64),
    /// An assembly, by its index in [`Sites::assemblies`].
    Assembly(usize),
}

/// A body or an assembly in its place.
pub(super) struct Placed {
    pub(super) what: What,
    pub(super) representation: u64,
    /// The representation in whose units it is placed.
    pub(super) top: u64,
    /// `None`: as it stands.
    pub(super) map: Option<Affine>,
    pub(super) name: String,
}

/// An assembly that is placed more than once or holds what is.
pub(super) struct Assembly {
    pub(super) name: String,
    /// In its own units.
    pub(super) members: Vec<Placed>,
}

/// Where everything stands.
pub(super) struct Sites {
    /// What is in no [`Assembly`].
    pub(super) top: Vec<Placed>,
    pub(super) assemblies: Vec<Assembly>,
}

impl Sites {
    /// The body that is placed first.
    pub(super) fn first(&self) -> Option<&Placed> {
        let mut open: Vec<&Placed> = self.top.iter().rev().collect();
        let mut seen = BTreeSet::new();
        while let Some(next) = open.pop() {
            match next.what {
                What::Body(_) => return Some(next),
                What::Assembly(k) if seen.insert(k) => {
                    let members = self.assemblies.get(k).map(|a| a.members.iter().rev());
                    open.extend(members.into_iter().flatten());
                }
                What::Assembly(_) => {}
            }
        }
        None
    }

    /// All places of bodies, each once.
    pub(super) fn bodies(&self) -> impl Iterator<Item = u64> {
        let members = self.assemblies.iter().flat_map(|a| &a.members);
        { self.top.iter().chain(members) }.filter_map(|p| match p.what {
            What::Body(id) => Some(id),
            What::Assembly(_) => None,
        })
    }
}

impl Products {
    /// All bodies in their places. An assembly is kept as one where it is placed more than once or holds what is, so that all this is no longer than the
    /// file is, whatever it unfolds to.
    pub(super) fn sites(&self, entities: &Entities) -> Result<Sites, ReadError> {
        let walk = Walk::new(self);
        let mut sites = Sites {
            top: Vec::new(),
            assemblies: Vec::new(),
        };
        let mut assemblies = Assemblies::default();
        let mut visited = BTreeSet::new();
        let tops = { walk.groups.keys() }.filter(|g| !walk.uses.contains_key(g));
        for &top in tops {
            let mut open = vec![(top, None, "")];
            while let Some((group, map, outer)) = open.pop() {
                let name = self.name(group, outer);
                if walk.is_assembly(group) {
                    sites.top.push(Placed {
                        what: What::Assembly(assemblies.index(group)),
                        representation: group,
                        top,
                        map,
                        name: name.to_owned(),
                    });
                    continue;
                }
                // It is used once at most: this ends.
                visited.insert(group);
                let inner = self.members(entities, &walk, group, name, |of, c| {
                    (of, composed(map.as_ref(), c), name)
                });
                sites.top.extend(inner.bodies.into_iter().map(|p| Placed {
                    top,
                    map: composed(map.as_ref(), p.map.as_ref()),
                    ..p
                }));
                open.extend(inner.children.into_iter().rev());
            }
        }
        while let Some(&group) = assemblies.order.get(sites.assemblies.len()) {
            visited.insert(group);
            let name = self.name(group, "");
            // All that an assembly holds is one, too.
            let inner = self.members(entities, &walk, group, name, |of, c| Placed {
                what: What::Assembly(assemblies.index(of)),
                representation: of,
                top: group,
                map: c.cloned(),
                name: String::new(),
            });
            let mut members = inner.bodies;
            members.extend(inner.children);
            sites.assemblies.push(Assembly {
                name: name.to_owned(),
                members,
            });
        }
        // What is only within itself is below no top.
        for (group, ids) in &walk.groups {
            let lost = |id: &&u64| self.all.get(id).is_some_and(|r| !r.bodies.is_empty());
            if !visited.contains(group)
                && let Some(id) = ids.iter().find(lost)
            {
                return Err(within_itself(*id));
            }
        }
        // What no representation holds.
        for (id, raw) in &entities.graph().entities {
            let is_body = |p: &Part| BODIES.contains(&&*p.name);
            if !raw.is_complex
                && raw.parts.first().is_some_and(is_body)
                && !walk.bodies.contains_key(id)
            {
                sites.top.push(Placed {
                    what: What::Body(*id),
                    representation: 0,
                    top: 0,
                    map: None,
                    name: String::new(),
                });
            }
        }
        Ok(sites)
    }

    /// The name of a group, or else that of what it is in.
    fn name<'a>(&'a self, group: u64, outer: &'a str) -> &'a str {
        self.names.get(&group).map_or(outer, String::as_str)
    }

    /// What a group holds, in its own frame: its bodies, named like it where they have no name, and what `child` makes of the groups in it and their maps.
    fn members<T>(
        &self,
        entities: &Entities,
        walk: &Walk,
        group: u64,
        name: &str,
        mut child: impl FnMut(u64, Option<&Affine>) -> T,
    ) -> Members<T> {
        let mut found = Members {
            bodies: Vec::new(),
            children: Vec::new(),
        };
        // What representations of one thing both list is there once.
        let mut listed = BTreeSet::new();
        for id in walk.groups.get(&group).into_iter().flatten() {
            let Some(r) = self.all.get(id) else { continue };
            for body in r.bodies.iter().filter(|b| listed.insert(**b)) {
                let own = entities.simple(*body).map_or("", |e| e.text(0));
                let plain = own.is_empty() || own == "NONE";
                found.bodies.push(Placed {
                    what: What::Body(*body),
                    representation: *id,
                    top: group,
                    map: r.scale.clone(),
                    name: short(if plain { name } else { own }),
                });
            }
            for c in &r.children {
                let made = child(self.root(c.of), c.map.as_ref());
                found.children.push(made);
            }
        }
        found
    }
}

struct Members<T> {
    bodies: Vec<Placed>,
    children: Vec<T>,
}

/// What is in what, by the representations that stand for all that are of one thing.
struct Walk {
    /// The representations of each.
    groups: BTreeMap<u64, Vec<u64>>,
    /// How often each is in others, and each body in any.
    uses: HashMap<u64, usize>,
    bodies: HashMap<u64, usize>,
    /// Those that hold what is used more than once.
    holders: BTreeSet<u64>,
}

impl Walk {
    fn new(products: &Products) -> Self {
        let mut walk = Self {
            groups: BTreeMap::new(),
            uses: HashMap::new(),
            bodies: HashMap::new(),
            holders: BTreeSet::new(),
        };
        let mut listed = BTreeSet::new();
        for (id, r) in &products.all {
            walk.groups.entry(products.root(*id)).or_default().push(*id);
            for c in &r.children {
                *walk.uses.entry(products.root(c.of)).or_default() += 1;
            }
            let group = products.root(*id);
            for b in r.bodies.iter().filter(|b| listed.insert((group, **b))) {
                *walk.bodies.entry(*b).or_default() += 1;
            }
        }
        let often = |counts: &HashMap<u64, usize>, id: u64| counts.get(&id).is_some_and(|n| *n > 1);
        for (id, r) in &products.all {
            let mut children = r.children.iter().map(|c| products.root(c.of));
            if r.bodies.iter().any(|b| often(&walk.bodies, *b))
                || children.any(|c| often(&walk.uses, c))
            {
                walk.holders.insert(products.root(*id));
            }
        }
        walk
    }

    fn is_assembly(&self, group: u64) -> bool {
        self.holders.contains(&group) || self.uses.get(&group).is_some_and(|n| *n > 1)
    }
}

/// Groups that are assemblies, in the order met.
#[derive(Default)]
struct Assemblies {
    order: Vec<u64>,
    indices: HashMap<u64, usize>,
}

impl Assemblies {
    fn index(&mut self, group: u64) -> usize {
        let next = self.order.len();
        let index = *self.indices.entry(group).or_insert(next);
        if index == next {
            self.order.push(group);
        }
        index
    }
}

/// The refusal of an assembly, by its representation.
pub(super) fn within_itself(representation: u64) -> ReadError {
    problem(
        representation,
        StepProblem::Shape {
            what: "an assembly that is part of itself".into(),
        },
    )
}
