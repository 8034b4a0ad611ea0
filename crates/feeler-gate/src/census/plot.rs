//! Bars of uses as SVG.

use super::{Census, Subject};
use crate::plot::colour;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Pixels: the whole width, where bars begin, the longest bar, a row, the room above a group, margins.
const WIDTH: u32 = 860;
const LEFT: i32 = 300;
const LONGEST: f64 = 360.0;
const ROW: i32 = 22;
const HEAD: i32 = 34;
const MARGIN: i32 = 14;
/// Rows of one group: the most frequent kinds; the rest is one row.
const MOST_ROWS: usize = 12;

/// A row: its label, and what stands behind its bar.
struct Row {
    label: String,
    uses: usize,
    note: String,
}

fn rows(census: &Census, subject: Subject) -> Vec<Row> {
    let kinds = census.kinds(subject);
    let shown = if kinds.len() > MOST_ROWS {
        MOST_ROWS - 1
    } else {
        kinds.len()
    };
    let mut rows: Vec<Row> = kinds[..shown]
        .iter()
        .map(|(kind, c)| Row {
            label: (*kind).to_owned(),
            uses: c.uses,
            note: format!(
                "{} in {} file{}",
                c.uses,
                c.files,
                if c.files == 1 { "" } else { "s" }
            ),
        })
        .collect();
    let rest = &kinds[shown..];
    if !rest.is_empty() {
        let uses = rest.iter().map(|(_, c)| c.uses).sum();
        rows.push(Row {
            label: format!("{} other kinds", rest.len()),
            uses,
            note: format!("{uses}"),
        });
    }
    rows
}

/// Empty where nothing was counted.
pub(super) fn svg(census: &Census) -> String {
    let groups: Vec<(Subject, Vec<Row>)> = Subject::ALL
        .into_iter()
        .map(|s| (s, rows(census, s)))
        .filter(|(_, rows)| !rows.is_empty())
        .collect();
    if groups.is_empty() {
        return String::new();
    }
    let height: i32 = groups
        .iter()
        .map(|(_, r)| HEAD + ROW * r.len() as i32)
        .sum();
    let mut svg = String::new();
    {
        let size = (WIDTH, (height + 2 * MARGIN) as u32);
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        // Drawing into a string does not fail.
        let _ = draw(&root, &groups);
    }
    svg
}

fn draw(
    root: &DrawingArea<SVGBackend<'_>, Shift>,
    groups: &[(Subject, Vec<Row>)],
) -> Result<(), Box<dyn std::error::Error>> {
    root.fill(&WHITE)?;
    let text = |size: i32, across: HPos| {
        let font = ("sans-serif", size).into_font().color(&BLACK);
        font.pos(Pos::new(across, VPos::Center))
    };
    let mut y = MARGIN;
    for (k, (subject, rows)) in groups.iter().enumerate() {
        let title = text(16, HPos::Left);
        root.draw(&Text::new(subject.title(), (MARGIN, y + HEAD / 2), title))?;
        y += HEAD;
        // Bars of one group have one scale, from zero.
        let most = rows.iter().map(|r| r.uses).max().unwrap_or(1).max(1);
        for row in rows {
            let middle = y + ROW / 2;
            let label = text(14, HPos::Right);
            root.draw(&Text::new(row.label.clone(), (LEFT - 8, middle), label))?;
            let end = LEFT + (LONGEST * row.uses as f64 / most as f64).round() as i32;
            // As wide as a line, at least, so that it is seen.
            let corners = [(LEFT, y + 4), (end.max(LEFT + 1), y + ROW - 4)];
            root.draw(&Rectangle::new(corners, colour(k).filled()))?;
            let note = text(13, HPos::Left);
            root.draw(&Text::new(row.note.clone(), (end + 8, middle), note))?;
            y += ROW;
        }
    }
    root.present()?;
    Ok(())
}
