//! What the plots of reports and experiments have in common: colours, and the frame with its axes.

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use std::error::Error;

/// Colours that people who confuse red and green can tell apart (Okabe and Ito, 2008), in the order of first use.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(90, 90, 90),
    RGBColor(0, 0, 0),
];

/// The colour of the k-th thing in a plot; from the ninth on they come again.
pub fn colour(k: usize) -> RGBColor {
    COLOURS[k % COLOURS.len()]
}

/// The words and the room around a plot.
#[derive(Clone, Copy, Debug, Default)]
pub struct Frame<'a> {
    /// Above it; nothing where empty.
    pub title: &'a str,
    /// Along the axes, with units.
    pub x: &'a str,
    /// Along y.
    pub y: &'a str,
    /// Pixels kept free on the right, for names.
    pub right: u32,
}

/// A chart in SVG.
pub type Chart<'r, 's, X, Y> = ChartContext<
    'r,
    SVGBackend<'s>,
    Cartesian2d<<X as AsRangedCoord>::CoordDescType, <Y as AsRangedCoord>::CoordDescType>,
>;

/// A white page with axes and a grid, ready for what is to be drawn.
///
/// # Errors
/// None while the drawing goes into a string.
pub fn chart<'r, 's, X, Y>(
    root: &'r DrawingArea<SVGBackend<'s>, Shift>,
    frame: &Frame<'_>,
    (x, y): (X, Y),
    tick: impl Fn(f64) -> String,
) -> Result<Chart<'r, 's, X, Y>, Box<dyn Error>>
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    root.fill(&WHITE)?;
    let mut builder = ChartBuilder::on(root);
    if !frame.title.is_empty() {
        builder.caption(frame.title, ("sans-serif", 17));
    }
    let mut chart = builder
        .margin(14)
        .margin_right(14 + frame.right)
        .x_label_area_size(44)
        .y_label_area_size(74)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .light_line_style(RGBColor(245, 245, 245))
        .bold_line_style(RGBColor(225, 225, 225))
        .x_desc(frame.x)
        .y_desc(frame.y)
        .x_label_formatter(&|v| tick(*v))
        .y_label_formatter(&|v| tick(*v))
        .label_style(("sans-serif", 15))
        .axis_desc_style(("sans-serif", 16))
        .draw()?;
    Ok(chart)
}
