//! `feeler inspect --health`: what whoever imports a part must know, with proven bounds.

use feeler::brep::{Brep, Defect, LoopKind, Severity};
use feeler::numeric::Enclosure;
use feeler::prepare::{Direction, EdgeHealth, FaceHealth, Health, PreparedBrep, Undefined};
use feeler::trim::{Meeting, MeetingKind};
use serde_json::{Value, json};

/// How many lines of one kind are shown as text; all of them with `--json`.
const SHOWN: usize = 10;

fn made(brep: &Brep) -> Health {
    PreparedBrep::new(brep.clone()).health()
}

/// `3 faces`, `1 face`.
fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// A length, to the three digits that a bound is worth.
fn length(x: f64, unit: &str) -> String {
    if x.is_finite() {
        format!("{x:.3e} {unit}")
    } else {
        "an unknown length".into()
    }
}

/// What is to be said of one face or edge: how much it matters, for the order of lines, and the line.
struct Finding(f64, String);

/// Lines of one kind, the largest first.
fn list(mut findings: Vec<Finding>, lines: &mut Vec<String>) {
    findings.sort_by(|a, b| b.0.total_cmp(&a.0));
    let more = findings.len().saturating_sub(SHOWN);
    lines.extend(
        findings
            .into_iter()
            .take(SHOWN)
            .map(|f| format!("  {}", f.1)),
    );
    if more > 0 {
        lines.push(format!(
            "  and {more} more like these; --json lists them all"
        ));
    }
}

/// The numbers of some edges: the first few.
fn numbers(edges: &[usize]) -> String {
    let first: Vec<String> = edges.iter().take(SHOWN).map(usize::to_string).collect();
    let rest = if edges.len() > SHOWN { ", ..." } else { "" };
    first.join(", ") + rest
}

/// What the file itself allows is no news.
fn is_allowed(size: f64, tolerance: Option<f64>) -> bool {
    tolerance.is_some_and(|t| size <= t)
}

/// A summary, then a line for each face and edge with something to say, and what follows from it. Lengths are in `unit`.
pub(crate) fn text(brep: &Brep, unit: &str, lines: &mut Vec<String>) {
    let h = made(brep);
    let start = lines.len();
    faces(&h, unit, lines);
    edges(&h, unit, lines);
    let (noted, rest): (Vec<&Defect>, Vec<&Defect>) = h
        .defects
        .iter()
        .partition(|d| d.severity() == Severity::Note);
    let rest = rest.iter().map(|d| Finding(0.0, d.to_string()));
    list(rest.collect(), lines);
    if !noted.is_empty() {
        lines.push(format!(
            "  {} within the file's own tolerance",
            counted(
                noted.len(),
                "end of an edge or a trim off its vertex",
                "ends of edges and trims off their vertices"
            )
        ));
    }
    for u in &h.undefined {
        lines.push(format!("  so: {u}"));
    }
    let summary = summary(&h, unit, lines.len() == start);
    lines.insert(start, summary);
}

fn summary(h: &Health, unit: &str, sound: bool) -> String {
    let widest = |sizes: &mut dyn Iterator<Item = f64>| sizes.fold(0.0, f64::max);
    let gaps = h
        .faces
        .iter()
        .flat_map(|f| &f.loops)
        .filter_map(|l| l.widest_gap());
    let gap = widest(&mut gaps.map(|g| g.space.hi));
    let crack = widest(&mut h.edges.iter().map(|e| e.crack.hi));
    let offsets = h.edges.iter().filter_map(EdgeHealth::worst_offset);
    let offset = widest(&mut offsets.map(|o| o.at_most));
    let size = |x: f64| {
        if x <= h.rounding {
            "none".into()
        } else {
            format!("up to {}", length(x, unit))
        }
    };
    format!(
        "  health: {}, {}, {}; gaps {}, cracks {}, edge curves off their faces {}{}",
        if h.is_closed { "closed" } else { "open" },
        counted(h.faces.len(), "face", "faces"),
        counted(h.edges.len(), "edge", "edges"),
        size(gap),
        size(crack),
        size(offset),
        if sound { "; nothing to report" } else { "" }
    )
}

fn faces(h: &Health, unit: &str, lines: &mut Vec<String>) {
    let (mut gaps, mut turns, mut meetings, mut slivers) = (vec![], vec![], vec![], vec![]);
    for f in &h.faces {
        for l in &f.loops {
            let at = format!("face {}, loop {}", f.face, l.trim_loop);
            let wide = l.gaps.iter().filter(|g| g.space.hi > h.rounding).count();
            if let Some(g) = l.widest_gap().filter(|g| g.space.hi > h.rounding) {
                let most = if wide > 1 {
                    format!(", the widest of {wide}")
                } else {
                    String::new()
                };
                gaps.push(Finding(
                    g.space.hi,
                    format!(
                        "{at}: a gap of {} ({:.3e} in uv) after trim {}{most}: close the loop; meanwhile it is joined straight",
                        length(g.space.hi, unit),
                        g.uv.hi,
                        g.after
                    ),
                ));
            }
            if l.is_turned_wrong() {
                let (kind, runs) = match l.kind {
                    LoopKind::Inner => ("a hole", "counter-clockwise"),
                    _ => ("an outer loop", "clockwise"),
                };
                turns.push(Finding(
                    l.area.mid().abs(),
                    format!("{at}: {kind} that runs {runs}: reverse it; inside goes by parity all the same"),
                ));
            }
        }
        meetings.extend(meeting(f));
        if f.is_sliver() {
            slivers.push(Finding(
                f.border,
                format!(
                    "face {}: a sliver, at most {} wide in the mean with a border of at least {}: merge it with its neighbour",
                    f.face,
                    length(f.mean_width(), unit),
                    length(f.border, unit)
                ),
            ));
        }
    }
    for kind in [turns, meetings, gaps, slivers] {
        list(kind, lines);
    }
}

/// The worst of what a face's loops do to each other.
fn meeting(f: &FaceHealth) -> Option<Finding> {
    let own: Vec<&Meeting> = f.own_meetings().collect();
    let worst = own.iter().min_by_key(|m| m.kind)?;
    let [u, v] = worst.place.map(|r| 0.5 * r[0] + 0.5 * r[1]);
    let who = if worst.trims[0] == worst.trims[1] {
        format!("trim {}", worst.trims[0])
    } else {
        format!("trims {} and {}", worst.trims[0], worst.trims[1])
    };
    let (what, remedy) = match worst.kind {
        MeetingKind::Crossing => ("cross", "trim the face anew"),
        MeetingKind::Overlap => ("run along each other", "trim the face anew"),
        MeetingKind::Touch => ("touch", "part the loops if that is not meant"),
        MeetingKind::Undecided => (
            "come too near to each other to tell whether they cross",
            "look there",
        ),
    };
    let count = own.len() + f.meetings.more;
    let more = if count > 1 {
        format!(", one of {count} places")
    } else {
        String::new()
    };
    Some(Finding(
        -(worst.kind as u8 as f64),
        format!(
            "face {}: {who} {what} near uv ({u:.6}, {v:.6}){more}: {remedy}",
            f.face
        ),
    ))
}

fn edges(h: &Health, unit: &str, lines: &mut Vec<String>) {
    let (mut cracks, mut offsets, mut tiny) = (vec![], vec![], vec![]);
    // Those that the file allows: how many, and the widest.
    let (mut allowed_cracks, mut allowed_offsets) = ((0, 0.0f64), (0, 0.0f64));
    let allow = |of: &mut (usize, f64), size: f64| *of = (of.0 + 1, of.1.max(size));
    for e in &h.edges {
        let at = format!("edge {}", e.edge);
        if e.crack.hi > h.rounding {
            if is_allowed(e.crack.hi, e.tolerance) {
                allow(&mut allowed_cracks, e.crack.hi);
            } else {
                let least = if e.crack.lo > 0.5 * e.crack.hi {
                    String::new()
                } else {
                    format!(", at least {}", length(e.crack.lo, unit))
                };
                let faces = numbers(&e.faces);
                cracks.push(Finding(
                    e.crack.hi,
                    format!(
                        "{at} of faces {faces}: a crack of at most {}{least}: sew the faces anew",
                        length(e.crack.hi, unit)
                    ),
                ));
            }
        }
        if let Some(o) = e.worst_offset().filter(|o| o.at_most > h.rounding) {
            if is_allowed(o.at_most, e.tolerance) {
                allow(&mut allowed_offsets, o.at_most);
            } else {
                let about = match o.about {
                    Some(x) if x > 0.5 * o.at_most => String::new(),
                    Some(x) => format!(", about {} by samples", length(x, unit)),
                    None => ", none seen by samples".into(),
                };
                offsets.push(Finding(
                    o.at_most,
                    format!(
                        "{at}: its curve is at most {} off trim {}{about}: make it anew; answers go by the trims",
                        length(o.at_most, unit),
                        o.trim
                    ),
                ));
            }
        }
        if e.is_tiny {
            tiny.push(Finding(
                -e.reach,
                format!(
                    "{at}: tiny, it reaches at most {}: make its ends one",
                    length(e.reach, unit)
                ),
            ));
        }
    }
    list(cracks, lines);
    list(offsets, lines);
    for ((n, most), one, many) in [
        (allowed_cracks, "crack", "cracks"),
        (
            allowed_offsets,
            "edge curve off its faces",
            "edge curves off their faces",
        ),
    ] {
        if n > 0 {
            lines.push(format!(
                "  {} within the file's own tolerance, at most {}",
                counted(n, one, many),
                length(most, unit)
            ));
        }
    }
    list(tiny, lines);
    let those = |pred: &dyn Fn(&EdgeHealth) -> bool| -> Vec<usize> {
        h.edges.iter().filter(|e| pred(e)).map(|e| e.edge).collect()
    };
    for (edges, what) in [
        (
            those(&EdgeHealth::is_naked),
            "used once: the part is open there; join the faces that should meet",
        ),
        (
            those(&EdgeHealth::is_non_manifold),
            "used more than twice: no solid has such edges; split the part",
        ),
        (
            those(&|e| e.faces.is_empty()),
            "used by no face: delete what is left over",
        ),
        (
            those(&|e| e.offsets.is_empty() && !e.faces.is_empty()),
            "without a curve in space: none is needed here",
        ),
        (
            those(&|e| e.direction == Direction::Against),
            "where material changes sides: turn one of the two faces around",
        ),
    ] {
        if !edges.is_empty() {
            lines.push(format!(
                "  {} {what} ({})",
                counted(edges.len(), "edge", "edges"),
                numbers(&edges)
            ));
        }
    }
}

/// The same as JSON, complete: see HEALTH.md.
pub(crate) fn json(brep: &Brep) -> Value {
    let h = made(brep);
    json!({
        "closed": h.is_closed,
        "size": h.size,
        "rounding": h.rounding,
        "faces": h.faces.iter().map(|f| face_json(brep, f)).collect::<Vec<_>>(),
        "edges": h.edges.iter().map(edge_json).collect::<Vec<_>>(),
        "defects": h.defects.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "undefined": h.undefined.iter().map(undefined_json).collect::<Vec<_>>(),
    })
}

/// `[lo, hi]`; an end that is infinite is `null`.
fn range(e: &Enclosure) -> Value {
    json!([e.lo, e.hi])
}

fn kind(kind: LoopKind) -> &'static str {
    match kind {
        LoopKind::Unknown => "unknown",
        LoopKind::Outer => "outer",
        LoopKind::Inner => "inner",
        LoopKind::Slit => "slit",
    }
}

fn face_json(brep: &Brep, f: &FaceHealth) -> Value {
    let loops = f.loops.iter().map(|l| {
        let gaps = l
            .gaps
            .iter()
            .map(|g| json!({ "after": g.after, "uv": range(&g.uv), "space": range(&g.space) }));
        json!({
            "loop": l.trim_loop,
            "kind": kind(l.kind),
            "turn": l.turn.name(),
            "turned_wrong": l.is_turned_wrong(),
            "area": range(&l.area),
            "gaps": gaps.collect::<Vec<_>>(),
        })
    });
    let meetings = f.meetings.found.iter().map(|m| {
        json!({
            "kind": m.kind.name(),
            "loops": m.loops,
            "trims": m.trims,
            "place": m.place,
            "at_gap": m.at_gap,
        })
    });
    json!({
        "face": f.face,
        "surface": brep.surface(f.face).type_name(),
        "loops": loops.collect::<Vec<_>>(),
        "meetings": meetings.collect::<Vec<_>>(),
        "more_meetings": f.meetings.more,
        "area_at_most": f.area,
        "border_at_least": f.border,
        "mean_width_at_most": f.mean_width(),
        "sliver": f.is_sliver(),
    })
}

fn edge_json(e: &EdgeHealth) -> Value {
    let offsets = e
        .offsets
        .iter()
        .map(|o| json!({ "trim": o.trim, "at_most": o.at_most, "about": o.about }));
    json!({
        "edge": e.edge,
        "faces": e.faces,
        "crack": range(&e.crack),
        "offsets": offsets.collect::<Vec<_>>(),
        "reach_at_most": e.reach,
        "tiny": e.is_tiny,
        "tolerance": e.tolerance,
        "naked": e.is_naked(),
        "non_manifold": e.is_non_manifold(),
        "direction": e.direction.name(),
    })
}

fn undefined_json(u: &Undefined) -> Value {
    let amount = match *u {
        Undefined::Material => Value::Null,
        Undefined::NearCracks(width) => json!(width),
        Undefined::UnknownCracks(n)
        | Undefined::CrossedLoops(n)
        | Undefined::UndecidedLoops(n)
        | Undefined::InGaps(n)
        | Undefined::Normals(n) => json!(n),
    };
    json!({ "name": u.name(), "amount": amount, "text": u.to_string() })
}
