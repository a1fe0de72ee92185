//! Plots as SVG and PNG: curves, reference points and bands over a light grid.

mod curve_shape;
mod draw;
mod phase;
mod run;

pub use curve_shape::CurveShape;
pub use phase::PhaseReference;
pub use run::{ReferenceCurve, plot_run};

use super::atomic;
use super::canvas::{BackEnd, Canvas};
use super::image::Image;
use crate::error::{Error, Result};
use plotters::prelude::*;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// SVG units per logical pixel: coordinates are whole numbers.
const SVG_SCALE: u32 = 20;
/// Pixels per logical pixel of a PNG.
const PNG_SCALE: usize = 2;
/// Pixels that are averaged to one, per direction.
const SUPERSAMPLING: usize = 3;

/// Contents of a plot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlotSpec {
    /// Above the plot.
    pub title: String,
    /// Horizontal axis.
    pub x: PlotAxis,
    /// Vertical axis.
    pub y: PlotAxis,
    /// Curves, points and bands, drawn in this order.
    pub series: Vec<PlotSeries>,
}

/// An axis: its name and unit without prefix; the plot chooses prefix, range and ticks.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlotAxis {
    /// For example `time`.
    pub name: String,
    /// For example `s`.
    pub unit: String,
}

impl PlotAxis {
    /// The axis of a column head such as `time [s]`.
    pub fn of_head(head: &str) -> Self {
        match head.strip_suffix(']').and_then(|head| head.rsplit_once(" [")) {
            Some((name, unit)) => Self { name: name.to_owned(), unit: unit.to_owned() },
            None => Self { name: head.to_owned(), unit: String::new() },
        }
    }
}

/// One entry of the legend.
#[derive(Debug, Clone, PartialEq)]
pub struct PlotSeries {
    /// Its name.
    pub label: String,
    /// Its shape.
    pub data: Data,
}

/// Shape of a series. Numbers that are not finite make gaps.
#[derive(Debug, Clone, PartialEq)]
pub enum Data {
    /// A curve through (x, y).
    Line(Vec<[f64; 2]>),
    /// A dashed curve through (x, y).
    Dashed(Vec<[f64; 2]>),
    /// A ring at each (x, y).
    Markers(Vec<[f64; 2]>),
    /// The area between (x, lower) and (x, upper).
    Band(Vec<[f64; 3]>),
    /// Horizontal lines.
    Levels(Vec<HorizontalLine>),
}

/// A horizontal line, from one x to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HorizontalLine {
    /// Its height.
    pub y: f64,
    /// Its ends.
    pub x: [f64; 2],
}

/// Writes `<stem>.svg` and `<stem>.png`.
///
/// # Errors
/// Input/output errors.
pub fn lines(spec: &PlotSpec, stem: &Path) -> Result<()> {
    let svg_path = with_extension(stem, ".svg");
    let svg = to_svg(spec).map_err(|error| Error::io(&svg_path, error))?;
    atomic::write(&svg_path, |out| out.write_all(svg.as_bytes()))?;
    let png_path = with_extension(stem, ".png");
    to_image(spec).map_err(|error| Error::io(&png_path, error))?.write_png(&png_path)
}

/// The path with an extension after whatever it ends in.
fn with_extension(stem: &Path, extension: &str) -> PathBuf {
    let mut path = stem.as_os_str().to_owned();
    path.push(extension);
    PathBuf::from(path)
}

/// The plot as SVG text.
///
/// # Errors
/// When the back end fails.
pub fn to_svg(spec: &PlotSpec) -> io::Result<String> {
    let [width, height] = draw::SIZE;
    let mut svg = String::new();
    {
        let size = (width * SVG_SCALE, height * SVG_SCALE);
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        draw::draw(&Canvas::new(&area, f64::from(SVG_SCALE), BackEnd::SVG), spec)?;
        area.present().map_err(|error| io::Error::other(error.to_string()))?;
    }
    // The view box keeps the fine coordinates; the image has the logical size.
    let fine = format!("width=\"{}\" height=\"{}\"", width * SVG_SCALE, height * SVG_SCALE);
    Ok(svg.replacen(&fine, &format!("width=\"{width}\" height=\"{height}\""), 1))
}

/// The plot as an image.
///
/// # Errors
/// When the back end fails.
pub fn to_image(spec: &PlotSpec) -> io::Result<Image> {
    let scale = PNG_SCALE * SUPERSAMPLING;
    let [width, height] = draw::SIZE.map(|pixels| pixels as usize * scale);
    let mut image = Image::new(width, height);
    {
        let size = (width as u32, height as u32);
        let area = BitMapBackend::with_buffer(&mut image.pixels, size).into_drawing_area();
        draw::draw(&Canvas::new(&area, scale as f64, BackEnd::BITMAP), spec)?;
        area.present().map_err(|error| io::Error::other(error.to_string()))?;
    }
    Ok(image.averaged_down(SUPERSAMPLING))
}
