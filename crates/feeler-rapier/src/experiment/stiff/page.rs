//! What was found, as a page and plots.

use super::run::Found;
use super::scene::{seam, socket};
use super::{BALL, GRAVITY, Grid, HOLE, MASS, REFERENCE};
use crate::experiment::plot::{Line, Marks, Plot};
use crate::experiment::{Finding, short, table};
use std::fmt::Write;

/// Values below this are drawn on it.
const LEAST: f64 = 1e-18;
/// Pushes below this, over m g, are drawn on it.
const LEAST_PUSH: f64 = 1e-3;
/// The stiffness of plots over time.
const DRAWN: f64 = 1e8;

/// A run.
struct Entry {
    name: String,
    stiffness: f64,
    step: f64,
    found: Found,
}

/// The runs of one scene.
pub(super) struct Results {
    name: &'static str,
    loss: Option<f64>,
    /// Stiffness, and the reference's own error, mm.
    pub(super) reference: Vec<(f64, f64)>,
    entries: Vec<Entry>,
}

impl Results {
    pub(super) fn new(name: &'static str, loss: Option<f64>) -> Self {
        Self {
            name,
            loss,
            reference: Vec::new(),
            entries: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, name: &str, stiffness: f64, step: f64, found: Found) {
        self.entries.push(Entry {
            name: name.to_owned(),
            stiffness,
            step,
            found,
        });
    }

    /// Where the ball was each millisecond on the first wall, a BREP, at the largest stiffness and in the shortest steps.
    pub(super) fn way(&self) -> Vec<[f64; 3]> {
        let first = self.names().first().copied();
        let mut own = self.entries.iter().rev();
        let last = own.find(|e| Some(e.name.as_str()) == first);
        last.map_or_else(Vec::new, |e| {
            e.found.path.iter().map(|p| (*p).into()).collect()
        })
    }

    /// Names of walls, in the order of their first runs.
    fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for e in &self.entries {
            if !names.contains(&e.name.as_str()) {
                names.push(&e.name);
            }
        }
        names
    }

    fn stiffnesses(&self) -> Vec<f64> {
        self.reference.iter().map(|r| r.0).collect()
    }

    fn of(&self, name: &str, stiffness: f64, step: f64) -> Option<&Found> {
        let same = |e: &&Entry| e.name == name && e.stiffness == stiffness && e.step == step;
        self.entries.iter().find(same).map(|e| &e.found)
    }

    /// A row a wall and stiffness.
    fn detail(&self, step: f64) -> String {
        let head = [
            "wall",
            "stiffness N/m",
            "energy drift",
            "off the reference mm",
            "force noise",
            "push off, median",
            "push off, most",
            "jump of the normal rad",
            "us a step",
            "queries a step",
            "steps parted, forced",
        ];
        let mut rows = Vec::new();
        for name in self.names() {
            for k in self.stiffnesses() {
                let Some(f) = self.of(name, k, step) else {
                    continue;
                };
                let cut = f.cut.map_or(String::new(), |t| format!(" (to {t:.3} s)"));
                let steps = f.tally.steps as f64;
                rows.push(vec![
                    name.to_owned(),
                    format!("{k:.0e}"),
                    format!("{}{cut}", short(f.drift)),
                    short(f.off),
                    short(f.noise),
                    short(f.push[0]),
                    short(f.push[1]),
                    short(f.jump),
                    short(f.seconds / steps * 1e6),
                    short(f.tally.queries as f64 / steps),
                    format!("{}, {}", f.tally.parted, f.tally.forced),
                ]);
            }
        }
        table(&head, &rows)
    }

    /// Energy drift over stiffness and step.
    fn drifts(&self, steps: &[f64]) -> String {
        let head: Vec<String> = steps.iter().map(|h| format!("{h:.0e} s")).collect();
        let mut titles = vec!["wall", "stiffness N/m"];
        titles.extend(head.iter().map(String::as_str));
        let mut rows = Vec::new();
        for name in self.names() {
            for k in self.stiffnesses() {
                let mut row = vec![name.to_owned(), format!("{k:.0e}")];
                for h in steps {
                    row.push(self.of(name, k, *h).map_or("-".to_owned(), |f| {
                        let cut = f.cut.map_or(String::new(), |t| format!(" (to {t:.3} s)"));
                        format!("{}{cut}", short(f.drift))
                    }));
                }
                rows.push(row);
            }
        }
        table(&titles, &rows)
    }

    fn own_errors(&self) -> String {
        let each = self
            .reference
            .iter()
            .map(|(k, e)| format!("{} at {k:.0e} N/m", short(*e)));
        each.collect::<Vec<_>>().join(", ")
    }

    /// A line a wall over the stiffness.
    fn over_stiffness(&self, step: f64, value: impl Fn(&Found) -> f64) -> Vec<Line> {
        let line = |name: &&str| Line {
            name: (*name).to_owned(),
            points: self
                .stiffnesses()
                .into_iter()
                .filter_map(|k| Some((k, value(self.of(name, k, step)?).max(LEAST))))
                .collect(),
            marks: Marks::Too,
        };
        self.names().iter().map(line).collect()
    }

    fn pushes(&self, name: &str, label: &str, stiffness: f64, step: f64) -> Option<Line> {
        let f = self.of(name, stiffness, step)?;
        let points = f.pushes.iter().map(|p| (p.0, p.1.max(LEAST_PUSH)));
        Some(Line {
            name: label.to_owned(),
            points: points.collect(),
            marks: Marks::None,
        })
    }
}

fn plots(slid: &Results, seams: &[Results], grid: &Grid) -> Vec<(String, String)> {
    let step = grid.usual;
    let middle = |r: &Results| {
        let all = r.stiffnesses();
        if all.contains(&DRAWN) {
            DRAWN
        } else {
            all[all.len() - 1]
        }
    };
    let k = middle(slid);
    let mut times = Vec::new();
    for name in slid.names() {
        let runs = slid
            .entries
            .iter()
            .filter(|e| e.name == name && e.stiffness == k && e.found.cut.is_none());
        times.push(Line {
            name: name.to_owned(),
            points: runs
                .map(|e| (e.found.seconds, e.found.off.max(LEAST)))
                .collect(),
            marks: Marks::Too,
        });
    }
    let plot = |title: String, x: &str, y: &str, lines, log| Plot {
        title,
        x: x.to_owned(),
        y: y.to_owned(),
        lines,
        log,
    };
    let stiff = "stiffness, N/m";
    let mut out = vec![
        (
            "stiff-time.svg".to_owned(),
            plot(
                format!(
                    "Sliding in the socket for 0.05 s, {k:.0e} N/m: error against run time, a mark a step length"
                ),
                "run time, s",
                "off the reference, mm",
                times,
                [true, true],
            ),
        ),
        (
            "stiff-drift.svg".to_owned(),
            plot(
                format!("Sliding in the socket, steps of {step:.0e} s: drift of the energy"),
                stiff,
                "of the energy of the swing",
                slid.over_stiffness(step, |f| f.drift),
                [true, true],
            ),
        ),
        (
            "stiff-noise.svg".to_owned(),
            plot(
                "Sliding in the socket: stiffness times error of the depth".to_owned(),
                stiff,
                "of the ball's weight",
                slid.over_stiffness(step, |f| f.noise),
                [true, true],
            ),
        ),
    ];
    let walls = slid.names();
    let shown = walls
        .iter()
        .filter(|n| n.ends_with("NURBS, full") || n.contains("mesh"));
    // Meshes first: what lies within their spikes is drawn over them.
    let mut lines: Vec<Line> = shown
        .rev()
        .filter_map(|n| slid.pushes(n, n, k, step))
        .collect();
    out.push((
        "stiff-push.svg".to_owned(),
        plot(
            format!("Sliding in the socket, {k:.0e} N/m, steps of {step:.0e} s: push of the wall"),
            "time, s",
            "of the ball's weight",
            std::mem::take(&mut lines),
            [false, true],
        ),
    ));
    for r in seams {
        let k = middle(r);
        for name in r.names() {
            if r.name.contains("G2") || name.contains("BREP") {
                let label = format!("{}, {name}", r.name.trim_start_matches("Over a "));
                lines.extend(r.pushes(name, &label, k, step));
            }
        }
    }
    out.push((
        "stiff-seams.svg".to_owned(),
        plot(
            format!("Over seams, {k:.0e} N/m, steps of {step:.0e} s: push of the wall"),
            "time, s",
            "of the ball's weight",
            lines,
            [false, true],
        ),
    ));
    out.into_iter().map(|(n, p)| (n, p.svg())).collect()
}

pub(super) fn page(slid: &Results, rolled: &Results, seams: &[Results], grid: &Grid) -> Finding {
    let plots = plots(slid, seams, grid);
    let step = grid.usual;
    let degrees = seam::SLOPE;
    let mut page = format!(
        "# Stiff contact\n\n\
        A ball of radius {BALL} mm and {MASS} kg slides without friction, then rolls without slipping, in a spherical socket of radius {HOLE} mm (the thesis's \
        part), let go {:.0} degrees from the bottom; and it slides at 200 mm/s over the seam of two faces that meet in an edge (C0, \
        {degrees} degrees), with one tangent (G1, z = x^2/16) or with one curvature (G2, z = x^3/32). The wall pushes back with a stiffness times the depth, 1e2 to \
        1e12 N/m, at the deepest point, without damping: the energy is constant. Gravity {GRAVITY} mm/s^2; 0.05 s.\n\n\
        The integrator is Radau IIA with three stages (order 5, L-stable; Hairer and Wanner, *Solving Ordinary Differential Equations II*), the contact's \
        stiffness in its Jacobian: it takes steps thousands of times as long as the contact's own period, which is 0.1 us at 1e12 N/m. What is stiff is then no trouble in itself, \
        and what is left is the wall's: errors of its depth and jumps of its normal. All walls have the same integrator and settings, and the ball starts at rest in the \
        surface of the wall in use.\n\n\
        - *Energy drift*: the largest change of the energy (in motion, height and overlap with the wall in use) at a millisecond's end, of that of the swing from \
        {:.0} degrees (of the seam's: of that of the motion). The closed form's is 0.\n\
        - *Off the reference*: the largest distance of the ball's centre from where it is in the same motion on the closed form of the wall in steps of {REFERENCE:.0e} s \
        (ten times that in quick runs).\n\
        - *Force noise*: stiffness times the error of the depth against the closed form (a sphere in double-double; a seam's foot by bisection, to some 1e-16 mm), of the ball's weight: median. \
        This is what whoever reads a force off the depth is off by.\n\
        - *Push off*: the integrator's push less that of the closed form at the same place, of the weight, over all steps but the first three. The closed form leaves out the swing of the contact itself, which at 1e2 N/m, where the \
        ball's rest depth is 0.02 mm, is no small part.\n\
        - *Jump of the normal*: the largest turn of the normal in one step beyond that of the way.\n\
        - Steps *parted*: done again in 2 to 16 parts since they did not settle; *forced*: a part of the shortest that did not either, taken as a plastic impact. A step that would add energy counts as not settled: so do \
        edges that are met faster than the steps resolve.\n\
        - Times are those of one run on a machine that did other work, too: what counts are ratios. A run of more than 10 s is cut short, which is said.\n\n",
        socket::FROM.to_degrees(),
        socket::FROM.to_degrees(),
    );
    let section = |page: &mut String, r: &Results| {
        let _ = write!(
            page,
            "## {}, steps of {step:.0e} s\n\nThe reference's own error (against twice its step), mm: {}.\n\n{}\n",
            r.name,
            r.own_errors(),
            r.detail(step)
        );
    };
    section(&mut page, slid);
    let _ = write!(
        page,
        "### Energy drift over stiffness and step\n\n{}\n",
        slid.drifts(&grid.steps)
    );
    section(&mut page, rolled);
    for r in seams {
        section(&mut page, r);
        if let Some(loss) = r.loss {
            let _ = write!(
                page,
                "An edge throws the ball: on the closed form it bounces off the second plane without loss, in pi sqrt(m/k). Steps that resolve this keep the energy; steps much longer than that \
                take the bounce as plastic, and lose the part of the velocity across the second plane, sin^2 of {degrees} degrees = {:.4} of the energy, at each \
                meeting. A mesh has such an edge between any two triangles.\n\n",
                loss
            );
        }
    }
    for (name, _) in &plots {
        let _ = writeln!(page, "![{name}]({name})\n");
    }
    Finding {
        page,
        plots,
        ..Finding::default()
    }
}
