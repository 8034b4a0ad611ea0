//! Lines over time, and marks over the number of triangles, as SVG.

use feeler_gate::plot::{Frame, chart, colour};
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;

const SIZE: (u32, u32) = (1040, 460);
/// Room on the right for names.
const NAMES: u32 = 270;
/// Pixels from one name to the next, and of the stroke before it.
const ROW: i32 = 22;
const STROKE: i32 = 18;

/// Whether points are marked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Marks {
    /// A line alone.
    None,
    /// Marks on the line.
    Too,
    /// Small marks without a line.
    Only,
}

/// A named line.
pub(super) struct Line {
    pub(super) name: String,
    pub(super) points: Vec<(f64, f64)>,
    pub(super) marks: Marks,
}

/// A plot of lines.
pub(super) struct Plot {
    pub(super) title: String,
    pub(super) x: String,
    pub(super) y: String,
    pub(super) lines: Vec<Line>,
    /// Logarithmic along x, along y; values must then be above 0.
    pub(super) log: [bool; 2],
}

/// From the smallest to the largest, with some room.
fn range(values: impl Iterator<Item = f64>, log: bool) -> std::ops::Range<f64> {
    let known = values.filter(|v| v.is_finite() && (!log || *v > 0.0));
    let [lo, hi] = known.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], v| {
        [lo.min(v), hi.max(v)]
    });
    if lo > hi {
        return if log { 1.0..10.0 } else { 0.0..1.0 };
    }
    if log {
        return 10f64.powf(lo.log10().floor())..10f64.powf((hi * 1.0001).log10().ceil());
    }
    let room = (0.06 * (hi - lo)).max(1e-9 * hi.abs()).max(1e-300);
    lo - room..hi + room
}

/// A number at an axis.
fn tick(v: f64) -> String {
    if v == 0.0 || (1e-3..1e4).contains(&v.abs()) {
        // What is left of roundings in steps of the axis.
        let text = format!("{v:.6}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{:e}", format!("{v:.2e}").parse().unwrap_or(v))
    }
}

impl Plot {
    /// The drawing; drawing into a string does not fail.
    pub(super) fn svg(&self) -> String {
        let mut svg = String::new();
        {
            let points = || self.lines.iter().flat_map(|l| &l.points);
            let x = range(points().map(|p| p.0), self.log[0]);
            let y = range(points().map(|p| p.1), self.log[1]);
            let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
            let _ = match self.log {
                [false, false] => self.draw(&root, x, y),
                [false, true] => self.draw(&root, x, y.log_scale()),
                [true, false] => self.draw(&root, x.log_scale(), y),
                [true, true] => self.draw(&root, x.log_scale(), y.log_scale()),
            };
        }
        svg
    }

    fn draw<X, Y>(
        &self,
        root: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
        x: X,
        y: Y,
    ) -> Result<(), Box<dyn std::error::Error>>
    where
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let frame = Frame {
            title: &self.title,
            x: &self.x,
            y: &self.y,
            right: NAMES,
        };
        let mut chart = chart(root, &frame, (x, y), tick)?;
        for (k, line) in self.lines.iter().enumerate() {
            let colour = colour(k);
            let points = line.points.iter().copied();
            let points: Vec<_> = points
                .filter(|p| p.0.is_finite() && p.1.is_finite())
                .collect();
            if line.marks != Marks::Only {
                chart.draw_series(LineSeries::new(points.clone(), colour.stroke_width(2)))?;
            }
            let (x, y) = ((SIZE.0 - NAMES) as i32 + 12, 50 + ROW * k as i32);
            let stroke = [(x, y), (x + STROKE, y)];
            root.draw(&PathElement::new(stroke, colour.stroke_width(3)))?;
            let name = Text::new(
                line.name.clone(),
                (x + STROKE + 7, y - 7),
                ("sans-serif", 14),
            );
            root.draw(&name)?;
            let size = match line.marks {
                Marks::None => continue,
                Marks::Too => 4,
                Marks::Only => 2,
            };
            let marks = points
                .into_iter()
                .map(|p| Circle::new(p, size, colour.filled()));
            chart.draw_series(marks)?;
        }
        root.present()?;
        Ok(())
    }
}
