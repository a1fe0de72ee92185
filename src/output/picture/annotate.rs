//! Annotations of a picture: time, colour bar, scale bar.

use super::scene::Colouring;
use crate::output::canvas::{Align, BackEnd, Canvas, Text, Weight};
use crate::output::colour::Rgb;
use crate::output::image::Image;
use crate::output::ticks::{Shown, Ticks, round_step};
use plotters::prelude::*;
use std::io;

const INK: Rgb = [0x22, 0x22, 0x22];
const SOFT: Rgb = [0x55, 0x55, 0x55];
/// From the border of the picture, in logical pixels.
const MARGIN: f64 = 28.0;
const FONT: f64 = 17.0;
/// Width of the colour bar, and room for its numbers.
const BAR: f64 = 16.0;
const NUMBERS: f64 = 72.0;

/// Room that the model must leave at the left, top, right and bottom, in logical pixels.
pub(super) fn margins(with_bar: bool) -> [f64; 4] {
    [MARGIN, 52.0, if with_bar { MARGIN + BAR + NUMBERS + 20.0 } else { MARGIN }, 66.0]
}

/// Texts of a picture.
pub(super) struct Notes<'n> {
    /// For example `t = 0.24 ms`.
    pub time: String,
    /// Name of the field, for the colour bar.
    pub field: &'n str,
    pub colouring: Option<&'n Colouring>,
    /// Logical pixels per metre.
    pub scale: f64,
    /// Unit of lengths; empty in a dimensionless case.
    pub length_unit: &'n str,
}

/// Writes on the image, which has `pixel` pixels per logical pixel.
pub(super) fn annotate(image: &mut Image, pixel: f64, notes: &Notes<'_>) -> io::Result<()> {
    let size = [image.width as f64 / pixel, image.height as f64 / pixel];
    let area_size = (image.width as u32, image.height as u32);
    let area = BitMapBackend::with_buffer(&mut image.pixels, area_size).into_drawing_area();
    let canvas = Canvas::new(&area, pixel, BackEnd::BITMAP);
    canvas.text(Text { weight: Weight::Bold, ..text(&notes.time, [MARGIN, MARGIN + 12.0], INK) })?;
    scale_bar(&canvas, size, notes)?;
    if let Some(colouring) = notes.colouring {
        colour_bar(&canvas, size, notes.field, colouring)?;
    }
    area.present().map_err(|error| io::Error::other(error.to_string()))
}

fn text(text: &str, at: [f64; 2], colour: Rgb) -> Text<'_> {
    Text { text, at, size: FONT, colour, weight: Weight::Regular, align: Align::Left }
}

/// A round length of about a fifth of the width.
fn scale_bar<B: DrawingBackend>(
    canvas: &Canvas<'_, B>,
    [width, height]: [f64; 2],
    notes: &Notes<'_>,
) -> io::Result<()> {
    let length = round_step(0.11 * width / notes.scale);
    let [left, right, y] = [MARGIN, MARGIN + length * notes.scale, height - MARGIN];
    for x in [left, right] {
        canvas.line(&[[x, y - 5.0], [x, y + 5.0]], INK, 2.0)?;
    }
    canvas.line(&[[left, y], [right, y]], INK, 2.0)?;
    let shown = Shown::new(length, notes.length_unit);
    let label = format!("{} {}", number(length * shown.factor), shown.unit);
    canvas.text(Text { align: Align::Center, ..text(label.trim_end(), [0.5 * (left + right), y - 12.0], INK) })
}

/// A round number in the fewest digits.
fn number(value: f64) -> String {
    let text = format!("{value:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn colour_bar<B: DrawingBackend>(
    canvas: &Canvas<'_, B>,
    [width, height]: [f64; 2],
    field: &str,
    colouring: &Colouring,
) -> io::Result<()> {
    let [low, high] = colouring.range;
    let shown = Shown::new(low.abs().max(high.abs()), &colouring.unit);
    let (left, length) = (width - MARGIN - NUMBERS - BAR, 0.52 * height);
    let (top, bottom) = (0.5 * (height - length), 0.5 * (height + length));
    let steps = colouring.table.len();
    for (n, &colour) in colouring.table.iter().enumerate() {
        let edge = |n: usize| bottom - length * n as f64 / steps as f64;
        canvas.rectangle([left, edge(n + 1)], [left + BAR, edge(n)], colour)?;
    }
    let ticks = Ticks::new(low * shown.factor, high * shown.factor, 6);
    for &value in &ticks.values {
        let y = bottom - length * (value / shown.factor - low) / (high - low);
        canvas.line(&[[left + BAR, y], [left + BAR + 5.0, y]], SOFT, 1.2)?;
        canvas.text(Text { size: 15.0, ..text(&ticks.label(value), [left + BAR + 9.0, y + 5.5], INK) })?;
    }
    let head = shown.head(field);
    canvas.text(Text { align: Align::Right, size: 16.0, ..text(&head, [width - MARGIN, top - 18.0], INK) })
}
