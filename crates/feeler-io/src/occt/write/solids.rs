//! Shells of a closed BREP: which holds which, and which way each faces.
//!
//! The format's solids are lumps: an outer shell whose faces look outward, and the shells of cavities, whose faces look into them. A
//! closed BREP may hold several lumps, and its flags may say anything: what is material is told by parity. So each shell is met by a
//! line: the shells that it is in when it first meets this one hold it, and the normal where it meets it says which way its faces look.
//!
//! **Cost.** A line tells of every shell that it meets, and those with the smallest boxes are asked first: of shells in each other the
//! innermost one's line tells of all. So the lines meet O(n) shells in all, where not many shells stand beside each other deep in many others.

use feeler::brep::Brep;
use feeler::prepare::PreparedBrep;
use feeler::query::{LineKind, LineProbe, Options, Workspace, line};
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// Directions of lines, along none of what parts are aligned with, to be tried one after the other.
const DIRECTIONS: [[f64; 3]; 4] = [
    [0.613, 0.271, 0.742],
    [-0.352, 0.877, 0.327],
    [0.191, -0.463, 0.866],
    [0.934, -0.158, -0.321],
];
/// How many points of a shell lines are sent through, in each direction.
const POINTS: usize = 6;

/// Lines that meet shells more often than this in all are not sent: seconds, of a file that has thousands of shells deep in thousands of others.
const MOST_HITS: usize = 1 << 22;

/// A shell.
pub(super) struct Shell {
    /// Its faces.
    pub(super) faces: Vec<usize>,
    place: Place,
}

/// Where a shell stands.
#[derive(Clone, Copy)]
struct Place {
    /// The innermost shell that holds it.
    parent: Option<usize>,
    /// How many hold it.
    depth: usize,
    /// Whether its faces look out of what it encloses by itself.
    outward: bool,
}

/// Shells that make one solid: the outer one, then those of its cavities; with each whether its faces have to be turned.
pub(super) type Lump = Vec<(usize, bool)>;

/// The faces of each shell, in the order of their first faces.
pub(super) fn shells(groups: &[usize]) -> Vec<Vec<usize>> {
    let mut place = vec![None; groups.len()];
    let mut shells: Vec<Vec<usize>> = Vec::new();
    for (face, group) in groups.iter().enumerate() {
        match place.get(*group).copied().flatten() {
            Some(s) => shells
                .get_mut(s)
                .into_iter()
                .for_each(|s: &mut Vec<usize>| s.push(face)),
            None => {
                if let Some(place) = place.get_mut(*group) {
                    *place = Some(shells.len());
                }
                shells.push(vec![face]);
            }
        }
    }
    shells
}

/// Points on the borders of a shell's faces.
fn borders(brep: &Brep, faces: &[usize]) -> Vec<Point3<f64>> {
    let parts = brep.parts();
    let trims = faces.iter().filter_map(|f| parts.faces.get(*f));
    let trims = trims.flat_map(|f| f.loops.iter().flatten().map(move |l| (f.surface, *l)));
    let trims = trims.filter_map(|(s, l)| Some((s, parts.loops.get(l)?)));
    let trims = trims.flat_map(|(s, l)| l.trims.iter().map(move |t| (s, *t)));
    trims
        .filter_map(|(s, t)| {
            let trim = parts.trims.get(t)?;
            let uv = parts.curves2.get(trim.curve)?.point(trim.span.lerp(0.382));
            Some(parts.surfaces.get(s)?.point(uv.x, uv.y))
        })
        .collect()
}

/// Points inside the box of some of a shell's borders: means of two.
fn points(on: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let far = |p: &Point3<f64>| {
        let away = |q: &&Point3<f64>| (*q - p).norm_squared();
        on.iter()
            .max_by(|a, b| away(a).total_cmp(&away(b)))
            .copied()
    };
    let step = (on.len() / POINTS).max(1);
    let some = on.iter().step_by(step).take(POINTS);
    // Not the middle, where parts are symmetric.
    some.filter_map(|p| Some(p + (far(p)? - p) * 0.457))
        .collect()
}

/// The square of a box's diagonal.
fn extent(points: &[Point3<f64>]) -> f64 {
    let Some(first) = points.first() else {
        return 0.0;
    };
    let corner = |of: fn(f64, f64) -> f64| {
        points
            .iter()
            .fold(first.coords, |a, p| a.zip_map(&p.coords, of))
    };
    (corner(f64::max) - corner(f64::min)).norm_squared()
}

/// What a line tells of the shells that it meets, one after the other, each with whether against the normal; `None` where it is in one of them
/// at its end, or leaves one before another that it entered later: shells that cross. Left out is what looks both ways.
fn told(hits: impl Iterator<Item = (usize, bool)>) -> Option<Vec<(usize, Place)>> {
    struct Met {
        shell: usize,
        place: Place,
        agrees: bool,
        is_open: bool,
    }
    let mut all: Vec<Met> = Vec::new();
    let mut of: HashMap<usize, usize> = HashMap::new();
    // Those that the line is in, from the outermost one on.
    let mut open: Vec<usize> = Vec::new();
    for (shell, against) in hits {
        let leaves = open.last() == Some(&shell);
        // In, out, in, ...: against the normal first.
        let outward = against != leaves;
        let met = *of.entry(shell).or_insert_with(|| {
            all.push(Met {
                shell,
                place: Place {
                    parent: open.last().copied(),
                    depth: open.len(),
                    outward,
                },
                agrees: true,
                is_open: false,
            });
            all.len() - 1
        });
        let met = all.get_mut(met)?;
        met.agrees &= met.place.outward == outward;
        if met.is_open != leaves {
            return None;
        }
        met.is_open = !leaves;
        if leaves {
            open.pop();
        } else {
            open.push(shell);
        }
    }
    let agreed = all.iter().filter(|m| m.agrees);
    let agreed = agreed.map(|m| (m.shell, m.place)).collect();
    open.is_empty().then_some(agreed)
}

/// What lines say of each shell; `None` where none of those that were sent decides, or they are too many. Counts how often they `meet` one.
fn met(brep: &Brep, shells: Vec<Vec<usize>>, meet: &mut usize) -> Option<Vec<Shell>> {
    let mut shell_of = vec![0; brep.faces().len()];
    for (s, faces) in shells.iter().enumerate() {
        for f in faces {
            *shell_of.get_mut(*f)? = s;
        }
    }
    let prepared = PreparedBrep::new(brep.clone());
    let options = Options::default();
    let mut workspace = Workspace::default();
    let mut order: Vec<(usize, f64)> = { shells.iter() }
        .map(|faces| extent(&borders(brep, faces)))
        .enumerate()
        .collect();
    order.sort_by(|(_, a), (_, b)| a.total_cmp(b));
    let mut places: Vec<Option<Place>> = vec![None; shells.len()];
    for (s, _) in order {
        if places.get(s)?.is_some() {
            continue;
        }
        let points = points(&borders(brep, shells.get(s)?));
        let lines = DIRECTIONS
            .iter()
            .flat_map(|d| points.iter().map(move |p| (p, d)));
        for (origin, direction) in lines {
            let probe = LineProbe {
                origin: *origin,
                direction: Vector3::from(*direction),
                kind: LineKind::Line,
            };
            let answer = line(&prepared, &probe, &options, &mut workspace);
            let hits = &answer.hits;
            *meet = meet.saturating_add(hits.len());
            if *meet > MOST_HITS {
                return None;
            }
            let unclear = answer.undecided.is_some()
                || answer.in_crack
                || answer.crossings != Some(hits.len())
                || hits.iter().any(|h| h.tangential)
                // Where shells touch, which of two comes first is not known.
                || hits.windows(2).any(|h| h[0].t.bounds.hi >= h[1].t.bounds.lo);
            if unclear {
                continue;
            }
            let hits = hits.iter().filter_map(|hit| {
                let against = hit.normal.dot(&probe.direction) < 0.0;
                Some((*shell_of.get(hit.face)?, against))
            });
            for (shell, place) in told(hits).into_iter().flatten() {
                places.get_mut(shell)?.get_or_insert(place);
            }
            if places.get(s)?.is_some() {
                break;
            }
        }
        places.get(s)?.as_ref()?;
    }
    let shells = shells.into_iter().zip(places);
    let shells = shells.map(|(faces, place)| {
        let place = place?;
        Some(Shell { faces, place })
    });
    shells.collect()
}

/// The lumps of a closed BREP, and its shells; `None` where lines do not tell.
pub(super) fn lumps(brep: &Brep, groups: &[usize]) -> Option<(Vec<Lump>, Vec<Shell>)> {
    let shells = met(brep, shells(groups), &mut 0)?;
    let is_outer = |s: &Shell| s.place.depth.is_multiple_of(2);
    let mut lump_of = vec![None; shells.len()];
    let mut lumps: Vec<Lump> = Vec::new();
    for (i, shell) in shells.iter().enumerate() {
        if is_outer(shell) {
            *lump_of.get_mut(i)? = Some(lumps.len());
            lumps.push(vec![(i, !shell.place.outward)]);
        }
    }
    for (i, shell) in shells.iter().enumerate() {
        if !is_outer(shell) {
            let lump = lump_of.get(shell.place.parent?).copied().flatten()?;
            lumps.get_mut(lump)?.push((i, shell.place.outward));
        }
    }
    Some((lumps, shells))
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler::brep::BrepBuilder;

    /// Adds the cube around the middle that reaches so far.
    fn cube(b: &mut BrepBuilder, reach: f64) {
        let corner = |i: usize| [0, 1, 2].map(|c| if i >> c & 1 == 1 { reach } else { -reach });
        let v: Vec<usize> = (0..8).map(|i| b.vertex(corner(i))).collect();
        for corners in [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [1, 3, 7, 5],
            [3, 2, 6, 7],
            [2, 0, 4, 6],
        ] {
            b.planar_face(&corners.map(|i| v[i])).expect("a square");
        }
    }

    /// Of shells in each other few lines tell: those sent meet each some few times, whichever order the file has them in.
    #[test]
    fn nested_shells_are_met_a_few_times_each() {
        const COUNT: usize = 64;
        for outermost_first in [true, false] {
            let mut b = BrepBuilder::new();
            for k in 0..COUNT {
                let k = if outermost_first { COUNT - k } else { k + 1 };
                cube(&mut b, k as f64);
            }
            let brep = b.build().expect("cubes");
            let groups: Vec<usize> = (0..6 * COUNT).map(|f| f / 6).collect();
            let mut meet = 0;
            let found = met(&brep, shells(&groups), &mut meet).expect("clear lines");
            for (s, shell) in found.iter().enumerate() {
                let (depth, outer) = if outermost_first {
                    (s, s.checked_sub(1))
                } else {
                    (COUNT - 1 - s, (s + 1 < COUNT).then_some(s + 1))
                };
                assert_eq!((shell.place.depth, shell.place.parent), (depth, outer));
                assert!(shell.place.outward);
            }
            // One line meets all twice; a few may be unclear.
            assert!(meet <= 8 * COUNT, "{meet}");
            let (lumps, _) = lumps(&brep, &groups).expect("lumps");
            assert_eq!(lumps.len(), COUNT / 2);
            assert!(lumps.iter().all(|l| l.len() == 2 && !l[0].1 && l[1].1));
        }
    }

    /// A hole right through a plate, as shells of their own whose ends are in one plane each: which of the two a line meets first is only a matter of
    /// the faces' numbers, here those of a plate within its hole, at both ends.
    #[test]
    fn lines_through_shells_that_touch_tell_nothing() {
        const LOW: [usize; 4] = [2, 0, 4, 6];
        const HIGH: [usize; 4] = [1, 3, 7, 5];
        const SIDES: [[usize; 4]; 4] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [3, 2, 6, 7]];
        for thickness in [0.5, 1.0, 2.0, 4.0, 6.0] {
            let mut b = BrepBuilder::new();
            let [hole, plate] = [1.0, 0.0].map(|from| {
                let low = [0.0, from, from];
                let high = [thickness, 10.0 - from, 10.0 - from];
                let corner =
                    |i: usize| [0, 1, 2].map(|c| if i >> c & 1 == 1 { high[c] } else { low[c] });
                let corners: Vec<usize> = (0..8).map(|i| b.vertex(corner(i))).collect();
                corners
            });
            let mut groups = Vec::new();
            let mut face = |b: &mut BrepBuilder, group: usize, corners: [usize; 4]| {
                let of = if group == 0 { &hole } else { &plate };
                b.planar_face(&corners.map(|i| of[i])).expect("a rectangle");
                groups.push(group);
            };
            for (group, corners) in [(0, LOW), (1, LOW), (1, HIGH), (0, HIGH)] {
                face(&mut b, group, corners);
            }
            for group in [0, 1] {
                for corners in SIDES {
                    face(&mut b, group, corners);
                }
            }
            let brep = b.build().expect("two boxes");
            if let Some((lumps, _)) = lumps(&brep, &groups) {
                let shells: Vec<Vec<usize>> = { lumps.iter() }
                    .map(|l| l.iter().map(|(s, _)| *s).collect())
                    .collect();
                // The plate, and the hole in it.
                assert_eq!(shells, [[1, 0]], "{thickness}");
            }
        }
    }
}
