//! Shells of a closed BREP: which holds which, and which way each faces.
//!
//! The format's solids are lumps: an outer shell whose faces look outward, and the shells of cavities, whose faces look into them. A
//! closed BREP may hold several lumps, and its flags may say anything: what is material is told by parity. So each shell is met by a
//! line: how often that passes through another shell before it first meets this one says whether it stands inside that one, and the normal
//! where it meets it says which way its faces look.

use feeler::brep::Brep;
use feeler::prepare::PreparedBrep;
use feeler::query::{LineKind, LineProbe, Options, Workspace, line};
use nalgebra::{Point3, Vector3};

/// Directions of lines, along none of what parts are aligned with, to be tried one after the other.
const DIRECTIONS: [[f64; 3]; 4] = [
    [0.613, 0.271, 0.742],
    [-0.352, 0.877, 0.327],
    [0.191, -0.463, 0.866],
    [0.934, -0.158, -0.321],
];
/// How many points of a shell lines are sent through, in each direction.
const POINTS: usize = 6;

/// A shell.
pub(super) struct Shell {
    /// Its faces.
    pub(super) faces: Vec<usize>,
    /// The shells that hold it.
    within: Vec<usize>,
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

/// Points inside the box of some of a shell's faces: means of points on the borders of two.
fn points(brep: &Brep, faces: &[usize]) -> Vec<Point3<f64>> {
    let parts = brep.parts();
    let trims = faces.iter().filter_map(|f| parts.faces.get(*f));
    let trims = trims.flat_map(|f| f.loops.iter().flatten().map(move |l| (f.surface, *l)));
    let trims = trims.filter_map(|(s, l)| Some((s, parts.loops.get(l)?)));
    let trims = trims.flat_map(|(s, l)| l.trims.iter().map(move |t| (s, *t)));
    let on: Vec<Point3<f64>> = trims
        .filter_map(|(s, t)| {
            let trim = parts.trims.get(t)?;
            let uv = parts.curves2.get(trim.curve)?.point(trim.span.lerp(0.382));
            Some(parts.surfaces.get(s)?.point(uv.x, uv.y))
        })
        .collect();
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

/// What lines say of each shell; `None` where none of those that were sent decides.
fn met(brep: &Brep, shells: Vec<Vec<usize>>) -> Option<Vec<Shell>> {
    let mut shell_of = vec![0; brep.faces().len()];
    for (s, faces) in shells.iter().enumerate() {
        for f in faces {
            *shell_of.get_mut(*f)? = s;
        }
    }
    let prepared = PreparedBrep::new(brep.clone());
    let options = Options::default();
    let mut workspace = Workspace::default();
    let count = shells.len();
    let mut found = Vec::with_capacity(count);
    for (s, faces) in shells.into_iter().enumerate() {
        let points = points(brep, &faces);
        let lines = DIRECTIONS
            .iter()
            .flat_map(|d| points.iter().map(move |p| (p, d)));
        let mut result = None;
        for (origin, direction) in lines {
            let probe = LineProbe {
                origin: *origin,
                direction: Vector3::from(*direction),
                kind: LineKind::Line,
            };
            let answer = line(&prepared, &probe, &options, &mut workspace);
            let hits = &answer.hits;
            let unclear = answer.undecided.is_some()
                || answer.in_crack
                || answer.crossings != Some(hits.len())
                || hits.iter().any(|h| h.tangential)
                // Where shells touch, which of two comes first is not known.
                || hits.windows(2).any(|h| h[0].t.bounds.hi >= h[1].t.bounds.lo);
            if unclear {
                continue;
            }
            let mut passed = vec![0_usize; count];
            let mut outward = None;
            let mut agree = true;
            for hit in hits {
                let at = shell_of.get(hit.face).copied()?;
                if at == s {
                    // In, out, in, ...: against the normal first.
                    let against = hit.normal.dot(&probe.direction) < 0.0;
                    let looks_out = against == passed.get(s)?.is_multiple_of(2);
                    agree &= *outward.get_or_insert(looks_out) == looks_out;
                }
                if outward.is_none() || at == s {
                    *passed.get_mut(at)? += 1;
                }
            }
            if let (Some(outward), true) = (outward, agree) {
                let within = (0..count)
                    .filter(|t| *t != s && !passed[*t].is_multiple_of(2))
                    .collect();
                result = Some((within, outward));
                break;
            }
        }
        let (within, outward) = result?;
        found.push(Shell {
            faces,
            within,
            outward,
        });
    }
    Some(found)
}

/// The lumps of a closed BREP, and its shells; `None` where lines do not tell.
pub(super) fn lumps(brep: &Brep, groups: &[usize]) -> Option<(Vec<Lump>, Vec<Shell>)> {
    let shells = met(brep, shells(groups))?;
    let is_outer = |s: &Shell| s.within.len().is_multiple_of(2);
    let mut lump_of = vec![None; shells.len()];
    let mut lumps: Vec<Lump> = Vec::new();
    for (i, shell) in shells.iter().enumerate() {
        if is_outer(shell) {
            *lump_of.get_mut(i)? = Some(lumps.len());
            lumps.push(vec![(i, !shell.outward)]);
        }
    }
    for (i, shell) in shells.iter().enumerate() {
        if !is_outer(shell) {
            // The innermost of those around it.
            let depth = |s: &&usize| shells.get(**s).map(|s| s.within.len());
            let around = shell.within.iter().max_by_key(depth)?;
            let lump = lump_of.get(*around).copied().flatten()?;
            lumps.get_mut(lump)?.push((i, shell.outward));
        }
    }
    Some((lumps, shells))
}
