//! Lines over time, and marks over the number of triangles, as SVG.

use plotters::coord::ranged1d::Ranged;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;

/// Colours that people who confuse red and green can tell apart (Okabe and Ito, 2008).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];
const SIZE: (u32, u32) = (1040, 460);
/// Room on the right for names.
const NAMES: u32 = 270;
/// Pixels from one name to the next, and of the stroke before it.
const ROW: i32 = 22;
const STROKE: i32 = 18;

/// A named line.
pub(super) struct Line {
    pub(super) name: String,
    pub(super) points: Vec<(f64, f64)>,
    /// Marks at the points, too.
    pub(super) marked: bool,
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
        root.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(root)
            .caption(&self.title, ("sans-serif", 17))
            .margin(12)
            .margin_right(NAMES)
            .x_label_area_size(44)
            .y_label_area_size(78)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(RGBColor(225, 225, 225))
            .x_desc(&self.x)
            .y_desc(&self.y)
            .x_label_formatter(&|v| tick(*v))
            .y_label_formatter(&|v| tick(*v))
            .label_style(("sans-serif", 14))
            .axis_desc_style(("sans-serif", 15))
            .draw()?;
        for (k, line) in self.lines.iter().enumerate() {
            let colour = COLOURS[k % COLOURS.len()];
            let points = line.points.iter().copied();
            let points: Vec<_> = points
                .filter(|p| p.0.is_finite() && p.1.is_finite())
                .collect();
            chart.draw_series(LineSeries::new(points.clone(), colour.stroke_width(2)))?;
            let (x, y) = ((SIZE.0 - NAMES) as i32 + 12, 50 + ROW * k as i32);
            let stroke = [(x, y), (x + STROKE, y)];
            root.draw(&PathElement::new(stroke, colour.stroke_width(3)))?;
            let name = Text::new(
                line.name.clone(),
                (x + STROKE + 7, y - 7),
                ("sans-serif", 14),
            );
            root.draw(&name)?;
            if line.marked {
                let marks = points
                    .into_iter()
                    .map(|p| Circle::new(p, 4, colour.filled()));
                chart.draw_series(marks)?;
            }
        }
        root.present()?;
        Ok(())
    }
}
