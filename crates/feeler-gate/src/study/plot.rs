//! Plots as SVG.

use crate::plot::{Frame, chart, colour};
use plotters::coord::Shift;
use plotters::prelude::*;

/// One point of a curve.
#[derive(Clone, Debug)]
pub(crate) struct Mark {
    /// Along x, from the smallest to the largest seen.
    pub(crate) x: [f64; 2],
    /// The middle of it.
    pub(crate) at: f64,
    /// Along y.
    pub(crate) y: f64,
    /// A second value along y, drawn hollow.
    pub(crate) second: Option<f64>,
    /// What stands beside it.
    pub(crate) label: String,
}

/// A curve.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    pub(crate) name: String,
    pub(crate) marks: Vec<Mark>,
    /// Whether its marks are steps of one dial, joined by a line.
    pub(crate) joined: bool,
}

/// A plot with logarithmic axes.
#[derive(Clone, Debug)]
pub(crate) struct Plot {
    pub(crate) x: String,
    pub(crate) y: String,
    pub(crate) curves: Vec<Curve>,
    /// A line along x that no curve can go below, and what it is; not drawn if it is below `least`.
    pub(crate) floor: Option<(f64, String)>,
    /// Values below this are drawn on it.
    pub(crate) least: f64,
}

const SIZE: (u32, u32) = (760, 470);

/// Height of the labels beside dots, and about how wide a letter of them is.
const LABEL: i32 = 14;
const LETTER: f64 = 0.52;
/// Room that a dot takes about its centre.
const DOT: i32 = 5;
/// How far labels move away from their dots, at most, in heights.
const FARTHEST: i32 = 4;

/// A box in pixels: left, top, right, bottom.
type Pixels = [i32; 4];

/// Where a label of this width stands beside a dot, relative to it: where it covers no other label and no dot, and
/// stays in the frame; `None` if there is no such place.
fn place((x, y): (i32, i32), width: i32, frame: Pixels, taken: &[Pixels]) -> Option<(i32, i32)> {
    let rows = (0..=FARTHEST).flat_map(|k| [-LABEL - 3 - k * LABEL, 3 + k * LABEL]);
    let mut places = rows.flat_map(|dy| [(DOT + 1, dy), (-DOT - 1 - width, dy)]);
    places.find(|(dx, dy)| {
        let own = [x + dx, y + dy, x + dx + width, y + dy + LABEL];
        let inside =
            own[0] >= frame[0] && own[1] >= frame[1] && own[2] <= frame[2] && own[3] <= frame[3];
        let apart =
            |t: &Pixels| own[2] <= t[0] || t[2] <= own[0] || own[3] <= t[1] || t[3] <= own[1];
        inside && taken.iter().all(apart)
    })
}

impl Plot {
    /// Each curve in the colour of its name's place among `names`. Empty if there is nothing to draw.
    pub(crate) fn svg(&self, names: &[String]) -> String {
        let mut svg = String::new();
        {
            let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
            // Drawing into a string does not fail.
            let _ = self.draw(&root, names);
        }
        svg
    }

    fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
        let all = values.filter(|v| v.is_finite() && *v > 0.0);
        let [lo, hi] = all.fold([f64::INFINITY, 0.0], |[lo, hi]: [f64; 2], v| {
            [lo.min(v), hi.max(v)]
        });
        // Whole decades, one at least.
        let (from, to) = (lo.log10().floor(), hi.log10().ceil());
        (lo <= hi).then(|| [10f64.powf(from), 10f64.powf(to.max(from + 1.0))])
    }

    fn draw(
        &self,
        root: &DrawingArea<SVGBackend<'_>, Shift>,
        names: &[String],
    ) -> Result<(), Box<dyn std::error::Error>> {
        let marks = || self.curves.iter().flat_map(|c| &c.marks);
        let Some([x0, x1]) = Self::range(marks().flat_map(|m| [m.x[0], m.x[1], m.at])) else {
            return Ok(());
        };
        let least = self.least;
        let ys = marks().flat_map(|m| [Some(m.y), m.second]).flatten();
        let floor = self.floor.as_ref().filter(|f| f.0 >= least);
        let ys = ys.chain(floor.map(|f| f.0)).map(|y| y.max(least));
        let Some([y0, y1]) = Self::range(ys) else {
            return Ok(());
        };
        let frame = Frame {
            x: &self.x,
            y: &self.y,
            ..Frame::default()
        };
        let axes = ((x0..x1).log_scale(), (y0..y1).log_scale());
        let mut chart = chart(root, &frame, axes, power)?;
        if let Some((y, what)) = floor {
            let y = *y;
            let line = RGBColor(150, 150, 150);
            chart.draw_series(DashedLineSeries::new(
                [(x0, y), (x1, y)],
                6,
                4,
                line.stroke_width(1),
            ))?;
            let style = ("sans-serif", 12).into_font().color(&line);
            chart.draw_series([Text::new(what.clone(), (x0 * 1.1, y), style)])?;
        }
        for curve in &self.curves {
            let at = names.iter().position(|n| *n == curve.name).unwrap_or(0);
            let colour = colour(at);
            if curve.joined {
                let line = curve.marks.iter().map(|m| (m.at, m.y.max(least)));
                chart.draw_series(LineSeries::new(line, colour.stroke_width(2)))?;
            }
            for m in &curve.marks {
                let y = m.y.max(least);
                chart.draw_series([PathElement::new(
                    vec![(m.x[0], y), (m.x[1], y)],
                    colour.mix(0.5).stroke_width(5),
                )])?;
                chart.draw_series([Circle::new((m.at, y), 4, colour.filled())])?;
                if let Some(second) = m.second {
                    let hollow = Circle::new((m.at, second.max(least)), 4, colour.stroke_width(1));
                    chart.draw_series([hollow])?;
                }
            }
        }
        // Labels last: they keep clear of all dots.
        let dot = |(x, y): (i32, i32)| [x - DOT, y - DOT, x + DOT, y + DOT];
        let dots = marks().map(|m| dot(chart.backend_coord(&(m.at, m.y.max(least)))));
        let mut taken: Vec<Pixels> = dots.collect();
        let corner = chart.backend_coord(&(x0, y0));
        let frame = [corner.0, 0, SIZE.0 as i32, corner.1];
        for curve in &self.curves {
            let at = names.iter().position(|n| *n == curve.name).unwrap_or(0);
            for m in &curve.marks {
                let spot = (m.at, m.y.max(least));
                let dot = chart.backend_coord(&spot);
                let width = (m.label.chars().count() as f64 * LETTER * f64::from(LABEL)) as i32;
                // Where there is no room the table below has it.
                let Some((dx, dy)) = place(dot, width, frame, &taken) else {
                    continue;
                };
                let (x, y) = (dot.0 + dx, dot.1 + dy);
                taken.push([x, y, x + width, y + LABEL]);
                let style = ("sans-serif", LABEL).into_font().color(&colour(at));
                let text = EmptyElement::at(spot) + Text::new(m.label.clone(), (dx, dy), style);
                chart.draw_series([text])?;
            }
        }
        root.present()?;
        Ok(())
    }
}

/// Powers of ten as such.
fn power(v: f64) -> String {
    let exponent = v.log10().round();
    if (v.log10() - exponent).abs() > 1e-9 {
        return String::new();
    }
    if (0.0..=4.0).contains(&exponent) {
        format!("{v:.0}")
    } else {
        format!("1e{exponent:.0}")
    }
}
