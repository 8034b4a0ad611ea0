//! Which surfaces and curves occur in a folder of parts: the question of section 3.2 of the 2014 thesis.
//!
//! A surface is counted once for each face that uses it, a curve in uv once for each trim, a curve in space once for each
//! edge: what an importer meets. Kinds say what a reader must know of them: which form, and of splines the degree and
//! whether they are rational.

mod plot;

use feeler::brep::Brep;
use feeler::nurbs::{Curve, Surface};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// What is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// Surfaces, by faces.
    Surface,
    /// Curves in uv, by trims.
    TrimCurve,
    /// Curves in space, by edges.
    EdgeCurve,
    /// Objects that are no BREPs, and those that were refused.
    Other,
}

impl Subject {
    /// All of them, in the order of tables.
    pub const ALL: [Self; 4] = [Self::Surface, Self::TrimCurve, Self::EdgeCurve, Self::Other];

    /// What stands above its rows.
    pub fn title(self) -> &'static str {
        match self {
            Self::Surface => "surfaces (uses by faces)",
            Self::TrimCurve => "trim curves (uses by trims)",
            Self::EdgeCurve => "edge curves (uses by edges)",
            Self::Other => "other objects",
        }
    }
}

/// How often something occurs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Uses in all.
    pub uses: usize,
    /// Files it occurs in.
    pub files: usize,
    /// The last file it was seen in, counted from 1.
    last: usize,
}

/// What was found in a folder of parts.
#[derive(Clone, Debug, Default)]
pub struct Census {
    counts: BTreeMap<(Subject, String), Count>,
    files: usize,
    breps: usize,
    unreadable: Vec<String>,
}

fn spline(degree: impl std::fmt::Display, rational: bool) -> String {
    let kind = if rational { "rational" } else { "polynomial" };
    format!("nurbs of degree {degree}, {kind}")
}

fn curve<const D: usize, const H: usize>(c: &Curve<D, H>) -> String {
    match c {
        Curve::Nurbs(n) => {
            let first = n.control_points().first().map(|p| p[H - 1]);
            let rational = n.control_points().iter().any(|p| Some(p[H - 1]) != first);
            spline(n.degree(), rational)
        }
        other => other.type_name().into(),
    }
}

/// The kind of a curve that makes a surface, its degree left out.
fn made_of<const D: usize, const H: usize>(c: &Curve<D, H>) -> &'static str {
    c.type_name()
}

fn surface(s: &Surface) -> String {
    match s {
        Surface::Revolution(r) => format!("revolution of {}", made_of(&r.profile)),
        Surface::Sum(s) => format!("sum of {} and {}", made_of(&s.first), made_of(&s.second)),
        Surface::Nurbs(n) => {
            let first = n.control_net().first().map(|p| p[3]);
            let rational = n.control_net().iter().any(|p| Some(p[3]) != first);
            let [p, q] = [n.knots_u().degree(), n.knots_v().degree()];
            spline(format!("{}x{}", p.max(q), p.min(q)), rational)
        }
        Surface::Plane(_) => s.type_name().into(),
    }
}

impl Census {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Begins a file: what is added from now on is in it.
    pub fn file(&mut self) {
        self.files += 1;
    }

    /// Names a file that could not be read, and why.
    pub fn unreadable(&mut self, why: String) {
        self.unreadable.push(why);
    }

    fn add(&mut self, subject: Subject, kind: String) {
        let count = self.counts.entry((subject, kind)).or_default();
        count.uses += 1;
        if count.last != self.files {
            (count.last, count.files) = (self.files, count.files + 1);
        }
    }

    /// Counts what a BREP is made of.
    pub fn brep(&mut self, brep: &Brep) {
        self.breps += 1;
        let p = brep.parts();
        for face in 0..p.faces.len() {
            self.add(Subject::Surface, surface(brep.surface(face)));
        }
        for t in &p.trims {
            self.add(Subject::TrimCurve, curve(&p.curves2[t.curve]));
        }
        for e in &p.edges {
            let kind = e.curve.map_or("none".into(), |c| curve(&p.curves3[c]));
            self.add(Subject::EdgeCurve, kind);
        }
    }

    /// Counts an object that is no BREP.
    pub fn other(&mut self, kind: impl Into<String>) {
        self.add(Subject::Other, kind.into());
    }

    /// Files that were read.
    pub fn files(&self) -> usize {
        self.files
    }

    /// Files that were not.
    pub fn unreadable_files(&self) -> usize {
        self.unreadable.len()
    }

    /// The kinds of a subject, the most frequent first, then by name.
    pub fn kinds(&self, subject: Subject) -> Vec<(&str, Count)> {
        let own = self.counts.iter().filter(|((s, _), _)| *s == subject);
        let mut all: Vec<(&str, Count)> = own.map(|((_, k), c)| (k.as_str(), *c)).collect();
        all.sort_by_key(|(_, c)| std::cmp::Reverse(c.uses));
        all
    }

    /// The tables as Markdown.
    pub fn markdown(&self) -> String {
        let mut out = format!(
            "{} files read, {} unreadable; {} BREPs\n",
            self.files,
            self.unreadable.len(),
            self.breps
        );
        for subject in Subject::ALL {
            let kinds = self.kinds(subject);
            let all: usize = kinds.iter().map(|(_, c)| c.uses).sum();
            if all == 0 {
                continue;
            }
            // Writing to a string does not fail.
            let _ = write!(
                out,
                "\n| {} | count | share | files |\n|---|---:|---:|---:|\n",
                subject.title()
            );
            for (kind, c) in kinds {
                let share = 100.0 * c.uses as f64 / all as f64;
                let _ = writeln!(out, "| {kind} | {} | {share:.1} % | {} |", c.uses, c.files);
            }
        }
        if !self.unreadable.is_empty() {
            out.push_str("\nUnreadable:\n\n");
            for why in &self.unreadable {
                let _ = writeln!(out, "- {}", why.replace('\n', " "));
            }
        }
        out
    }

    /// The same as a plot: bars of uses, in SVG.
    pub fn svg(&self) -> String {
        plot::svg(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler::brep::BrepBuilder;

    fn tetrahedron() -> Brep {
        let mut b = BrepBuilder::new();
        for p in [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]] {
            b.vertex(p);
        }
        for f in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
            b.planar_face(&f).unwrap();
        }
        b.build().unwrap()
    }

    #[test]
    fn uses_and_files_are_counted() {
        let mut c = Census::new();
        c.file();
        c.brep(&tetrahedron());
        c.brep(&tetrahedron());
        c.other("mesh");
        c.file();
        c.brep(&tetrahedron());
        c.unreadable("a.3dm: broken".into());
        let is = |subject, uses, files| {
            let kinds = c.kinds(subject);
            assert_eq!(kinds.len(), 1);
            assert_eq!((kinds[0].1.uses, kinds[0].1.files), (uses, files));
            kinds[0].0.to_owned()
        };
        // Four faces of three trims, six edges.
        assert_eq!(is(Subject::Surface, 12, 2), "plane");
        assert_eq!(is(Subject::TrimCurve, 36, 2), "line");
        assert_eq!(is(Subject::EdgeCurve, 18, 2), "line");
        assert_eq!(is(Subject::Other, 1, 1), "mesh");
        let text = c.markdown();
        assert!(text.starts_with("2 files read, 1 unreadable; 3 BREPs\n"));
        assert!(text.contains("| plane | 12 | 100.0 % | 2 |"));
        assert!(text.ends_with("\nUnreadable:\n\n- a.3dm: broken\n"));
    }

    #[test]
    fn the_plot_has_a_bar_for_each_kind() {
        let mut c = Census::new();
        c.file();
        c.brep(&tetrahedron());
        c.other("mesh");
        let svg = c.svg();
        // One row each, in four groups.
        for words in ["plane", "line", "mesh", "4 in 1 file", "12 in 1 file"] {
            assert!(svg.contains(words), "{words}");
        }
        assert_eq!(Census::new().svg(), "");
    }
}
