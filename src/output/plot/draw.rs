//! The design of a plot: title and legend above, light grid, curves, axes.

use super::{Data, HorizontalLine, PlotSeries, PlotSpec};
use crate::output::canvas::{Align, Canvas, Text, Weight, text_width};
use crate::output::colour::{PALETTE, Rgb};
use crate::output::ticks::{Shown, Ticks};
use plotters::prelude::DrawingBackend;
use std::io;

/// Logical pixels.
pub(super) const SIZE: [u32; 2] = [760, 470];
const MARGIN: f64 = 20.0;
const BOTTOM: f64 = 52.0;
const FONT: f64 = 12.5;
const ROW: f64 = 21.0;
const INK: Rgb = [0x22, 0x22, 0x22];
const SOFT: Rgb = [0x55, 0x55, 0x55];
const GRID: Rgb = [0xe4, 0xe4, 0xe4];
const AXIS: Rgb = [0x88, 0x88, 0x88];
const CURVE: f64 = 1.8;
const SWATCH: f64 = 24.0;
/// Colours of references: dark, so that curves over them keep theirs.
const REFERENCE: [Rgb; 3] = [[0x44; 3], [0x99, 0x55, 0x22], [0x33, 0x66, 0x77]];

/// Draws the whole plot.
pub(super) fn draw<B: DrawingBackend>(canvas: &Canvas<'_, B>, spec: &PlotSpec) -> io::Result<()> {
    let [width, height] = SIZE.map(f64::from);
    canvas.rectangle([0.0, 0.0], [width, height], [255; 3])?;
    canvas.text(Text { weight: Weight::Bold, size: 15.0, ..text(&spec.title, [MARGIN, 30.0], INK) })?;
    let colours = colours(&spec.series);
    let below_legend = legend(canvas, &spec.series, &colours, 54.0)?;

    let frame = PlotFrame::new(spec, below_legend + 40.0);
    frame.draw_grid(canvas, spec, below_legend + 26.0)?;
    for (series, colour) in spec.series.iter().zip(colours) {
        frame.draw_series(canvas, &series.data, colour)?;
    }
    frame.draw_axis(canvas)
}

fn text(text: &str, at: [f64; 2], colour: Rgb) -> Text<'_> {
    Text { text, at, size: FONT, colour, weight: Weight::Regular, align: Align::Left }
}

/// Curves take colours from the palette in turn; references and bands have others.
fn colours(series: &[PlotSeries]) -> Vec<Rgb> {
    let (mut curves, mut references) = (PALETTE.iter().cycle(), REFERENCE.iter().cycle());
    let mut next = |data: &Data| match data {
        Data::Line(_) | Data::Dashed(_) => curves.next(),
        Data::Markers(_) | Data::Band(_) | Data::Levels(_) => references.next(),
    };
    series.iter().map(|series| next(&series.data).copied().unwrap_or(INK)).collect()
}

/// Draws the legend in rows; returns where it ends.
fn legend<B: DrawingBackend>(
    canvas: &Canvas<'_, B>,
    series: &[PlotSeries],
    colours: &[Rgb],
    top: f64,
) -> io::Result<f64> {
    let (mut x, mut y) = (MARGIN, top);
    for (series, &colour) in series.iter().zip(colours) {
        let width = SWATCH + 7.0 + text_width(&series.label, FONT, Weight::Regular) + 20.0;
        if x > MARGIN && x + width > f64::from(SIZE[0]) - MARGIN {
            (x, y) = (MARGIN, y + ROW);
        }
        swatch(canvas, &series.data, colour, [x, y - 4.5])?;
        canvas.text(text(&series.label, [x + SWATCH + 7.0, y], INK))?;
        x += width;
    }
    Ok(if series.is_empty() { top - ROW } else { y })
}

fn swatch<B: DrawingBackend>(canvas: &Canvas<'_, B>, data: &Data, colour: Rgb, [x, y]: [f64; 2]) -> io::Result<()> {
    match data {
        Data::Line(_) => canvas.line(&[[x, y], [x + SWATCH, y]], colour, 2.4),
        Data::Dashed(_) | Data::Levels(_) => {
            dashes(&[[x, y], [x + SWATCH, y]]).iter().try_for_each(|dash| canvas.line(dash, colour, 2.4))
        }
        Data::Markers(_) => canvas.ring([x + 0.5 * SWATCH, y], 3.2, colour, 1.4),
        Data::Band(_) => canvas.rectangle([x, y - 5.0], [x + SWATCH, y + 5.0], mixed_with_white(colour)),
    }
}

/// Mapping of curves: ranges in shown units, and pixels.
struct PlotFrame {
    x: AxisScale,
    y: AxisScale,
}

/// One direction of a frame.
struct AxisScale {
    shown: Shown,
    range: [f64; 2],
    pixels: [f64; 2],
    ticks: Ticks,
}

impl AxisScale {
    fn new(numbers: impl Iterator<Item = f64>, unit: &str, padding: f64, count: usize) -> Self {
        let finite = numbers.filter(|number| number.is_finite());
        let [low, high] = finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], n| [a.min(n), b.max(n)]);
        let [low, high] = if low <= high { [low, high] } else { [0.0, 1.0] };
        let flat = high - low <= 1e-12 * low.abs().max(high.abs());
        let room = match (flat, low == 0.0) {
            (true, true) => 1.0,
            (true, false) => 0.5 * low.abs(),
            (false, _) => padding * (high - low),
        };
        // A range that starts or ends at zero stays there.
        let low = if low == 0.0 && !flat { 0.0 } else { low - room };
        let high = if high == 0.0 && !flat { 0.0 } else { high + room };
        let shown = Shown::new(low.abs().max(high.abs()), unit);
        let range = [low * shown.factor, high * shown.factor];
        Self { ticks: Ticks::new(range[0], range[1], count), shown, range, pixels: [0.0, 1.0] }
    }

    fn to_pixel(&self, number: f64) -> f64 {
        let [low, high] = self.range;
        let [from, to] = self.pixels;
        from + (number * self.shown.factor - low) / (high - low) * (to - from)
    }

    fn tick_pixels(&self) -> impl Iterator<Item = (f64, String)> {
        self.ticks.values.iter().map(|&v| (self.to_pixel(v / self.shown.factor), self.ticks.label(v)))
    }
}

impl PlotFrame {
    fn new(spec: &PlotSpec, top: f64) -> Self {
        let [width, height] = SIZE.map(f64::from);
        let all = || spec.series.iter().flat_map(|series| corners(&series.data));
        let mut x = AxisScale::new(all().map(|[x, _]| x), &spec.x.unit, 0.0, 7);
        let mut y = AxisScale::new(all().map(|[_, y]| y), &spec.y.unit, 0.05, 6);
        let widest = y.ticks.values.iter().map(|&v| text_width(&y.ticks.label(v), FONT, Weight::Regular));
        let left = MARGIN + widest.fold(0.0, f64::max) + 9.0;
        x.pixels = [left, width - MARGIN - 8.0];
        y.pixels = [height - BOTTOM, top];
        Self { x, y }
    }

    fn draw_grid<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>, spec: &PlotSpec, name_at: f64) -> io::Result<()> {
        let ([left, right], [bottom, top]) = (self.x.pixels, self.y.pixels);
        for (y, label) in self.y.tick_pixels() {
            canvas.line(&[[left, y], [right, y]], GRID, 1.0)?;
            canvas.text(Text { align: Align::Right, ..text(&label, [left - 9.0, y + 4.5], SOFT) })?;
        }
        for (x, label) in self.x.tick_pixels() {
            canvas.line(&[[x, bottom], [x, top]], GRID, 1.0)?;
            canvas.line(&[[x, bottom], [x, bottom + 5.0]], AXIS, 1.0)?;
            canvas.text(Text { align: Align::Center, ..text(&label, [x, bottom + 19.0], SOFT) })?;
        }
        canvas.text(text(&self.y.shown.head(&spec.y.name), [MARGIN, name_at], SOFT))?;
        let x_name = self.x.shown.head(&spec.x.name);
        let middle = [0.5 * (left + right), bottom + 38.0];
        canvas.text(Text { align: Align::Center, ..text(&x_name, middle, SOFT) })
    }

    fn draw_axis<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> io::Result<()> {
        let ([left, right], [bottom, _]) = (self.x.pixels, self.y.pixels);
        canvas.line(&[[left, bottom], [right, bottom]], AXIS, 1.2)?;
        let [low, high] = self.y.range;
        if low < 0.0 && high > 0.0 {
            let zero = self.y.to_pixel(0.0);
            canvas.line(&[[left, zero], [right, zero]], AXIS, 0.8)?;
        }
        Ok(())
    }

    fn draw_series<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>, data: &Data, colour: Rgb) -> io::Result<()> {
        match data {
            Data::Line(points) => self.pieces(points).iter().try_for_each(|piece| canvas.line(piece, colour, CURVE)),
            Data::Dashed(points) => self.draw_dashes(canvas, points, colour),
            Data::Levels(levels) => levels.iter().try_for_each(|level| self.draw_dashes(canvas, &ends(level), colour)),
            Data::Markers(points) => {
                self.pieces(points).concat().into_iter().try_for_each(|point| canvas.ring(point, 3.2, colour, 1.3))
            }
            Data::Band(points) => self.draw_band(canvas, points, colour),
        }
    }

    fn draw_dashes<B: DrawingBackend>(
        &self,
        canvas: &Canvas<'_, B>,
        points: &[[f64; 2]],
        colour: Rgb,
    ) -> io::Result<()> {
        let dashes = self.pieces(points).into_iter().flat_map(|piece| dashes(&piece));
        dashes.into_iter().try_for_each(|dash| canvas.line(&dash, colour, CURVE))
    }

    fn draw_band<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>, points: &[[f64; 3]], colour: Rgb) -> io::Result<()> {
        let edge = |side: usize| points.iter().map(move |p| [p[0], p[side]]);
        let outline: Vec<[f64; 2]> = edge(1).chain(edge(2).rev()).map(|point| self.to_pixel(point)).collect();
        if outline.iter().flatten().all(|number| number.is_finite()) {
            canvas.polygon(&outline, mixed_with_white(colour), 1.0)?;
        }
        Ok(())
    }

    fn to_pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.x.to_pixel(x), self.y.to_pixel(y)]
    }

    /// The points in pixels, cut where a number is not finite.
    fn pieces(&self, points: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
        let pixels: Vec<[f64; 2]> = points.iter().map(|&point| self.to_pixel(point)).collect();
        let finite = pixels.split(|[x, y]| !(x.is_finite() && y.is_finite()));
        finite.filter(|piece| !piece.is_empty()).map(<[_]>::to_vec).collect()
    }
}

/// All points that must be inside the frame.
fn corners(data: &Data) -> Vec<[f64; 2]> {
    match data {
        Data::Line(points) | Data::Dashed(points) | Data::Markers(points) => points.clone(),
        Data::Band(points) => points.iter().flat_map(|&[x, lower, upper]| [[x, lower], [x, upper]]).collect(),
        Data::Levels(levels) => levels.iter().flat_map(ends).collect(),
    }
}

/// The two ends of a level.
fn ends(level: &HorizontalLine) -> [[f64; 2]; 2] {
    level.x.map(|x| [x, level.y])
}

fn mixed_with_white(colour: Rgb) -> Rgb {
    colour.map(|c| (255.0 - 0.22 * (255.0 - f64::from(c))).round() as u8)
}

/// A polyline cut into dashes.
fn dashes(points: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
    const DASH: f64 = 6.0;
    const GAP: f64 = 3.6;
    let mut dashes = vec![];
    let (mut dash, mut left) = (vec![points[0]], DASH);
    for pair in points.windows(2) {
        let [mut from, to] = [pair[0], pair[1]];
        loop {
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            if length < left {
                left -= length;
                break;
            }
            let part = left / length.max(f64::MIN_POSITIVE);
            from = [from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])];
            if dash.is_empty() {
                (dash, left) = (vec![from], DASH);
            } else {
                dash.push(from);
                dashes.push(std::mem::take(&mut dash));
                left = GAP;
            }
        }
        if !dash.is_empty() {
            dash.push(to);
        }
    }
    if dash.len() > 1 {
        dashes.push(dash);
    }
    dashes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_follow_the_line_and_keep_their_length() {
        let points: Vec<[f64; 2]> = (0..=100).map(|i| [f64::from(i), 0.0]).collect();
        let dashes = dashes(&points);
        assert_eq!(dashes.len(), 11);
        for dash in &dashes[..10] {
            assert!((dash[dash.len() - 1][0] - dash[0][0] - 6.0).abs() < 1e-9, "{dash:?}");
        }
    }

    #[test]
    fn a_scale_maps_its_ends_to_its_pixels_and_keeps_zero() {
        let mut scale = AxisScale::new([0.0, 2e-3, f64::NAN].into_iter(), "s", 0.05, 5);
        scale.pixels = [100.0, 200.0];
        assert_eq!(scale.shown.unit, "ms");
        assert_eq!(scale.to_pixel(0.0), 100.0);
        assert!((scale.to_pixel(2.1e-3) - 200.0).abs() < 1e-9);
    }

    #[test]
    fn a_curve_of_zeros_has_an_ordinary_scale() {
        let scale = AxisScale::new([0.0; 3].into_iter(), "", 0.05, 5);
        assert_eq!((scale.range, scale.shown.unit.as_str()), ([-1.0, 1.0], ""));
    }
}
