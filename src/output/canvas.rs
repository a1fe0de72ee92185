//! Lines, shapes and text in logical pixels, on any of plotters' back ends.
//!
//! Back ends place things on whole pixels only; a canvas has more of them than logical pixels, so that
//! curves are smooth in SVG, and PNG images can be averaged down.

use super::colour::Rgb;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontDesc, FontFamily, register_font};
use std::io;
use std::sync::Once;

/// Fonts that a viewer of an SVG tries in turn; also the name of the bundled one.
const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";
/// Font height (ascent to descent) per em, of DejaVu Sans.
const HEIGHT_PER_EM: f64 = 1.164;

/// A weight of the font.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Weight {
    Regular,
    Bold,
}

/// Horizontal alignment of a text at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Align {
    Left,
    Center,
    Right,
}

/// Joins of a polyline at its corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Joins {
    /// By the back end.
    OfBackEnd,
    /// By discs between straight pieces. The bitmap back end limits mitres on the outer side of a corner only: on the
    /// inner one they reach far beyond a sharp peak.
    Round,
}

/// Operations that each back end implements.
#[derive(Debug, Clone, Copy)]
pub(super) struct BackEnd {
    joins: Joins,
    /// Size that the back end must be given for a font of one pixel per em.
    size_per_em: f64,
    /// From the place of a text to its baseline, in that size.
    baseline: f64,
}

impl BackEnd {
    /// As plotters' SVG back end does: `font-size = size / 1.24`, `dy = 0.76em`.
    pub const SVG: Self = Self { joins: Joins::OfBackEnd, size_per_em: 1.24, baseline: 0.76 / 1.24 };
    /// As plotters' bitmap back end does with `ab_glyph`.
    pub const BITMAP: Self = Self { joins: Joins::Round, size_per_em: HEIGHT_PER_EM, baseline: 0.5 };
}

/// A text to be set.
#[derive(Debug, Clone, Copy)]
pub(super) struct Text<'a> {
    pub text: &'a str,
    /// Left end, centre or right end of the baseline.
    pub at: [f64; 2],
    /// Pixels per em.
    pub size: f64,
    pub colour: Rgb,
    pub weight: Weight,
    pub align: Align,
}

/// A drawing in logical pixels, from the top left.
pub(super) struct Canvas<'b, B: DrawingBackend> {
    area: &'b DrawingArea<B, Shift>,
    scale: f64,
    back_end: BackEnd,
}

impl<'b, B: DrawingBackend> Canvas<'b, B> {
    /// A canvas of `scale` back-end pixels per logical pixel.
    pub fn new(area: &'b DrawingArea<B, Shift>, scale: f64, back_end: BackEnd) -> Self {
        register_fonts();
        Self { area, scale, back_end }
    }

    /// An open polyline.
    pub fn line(&self, points: &[[f64; 2]], colour: Rgb, width: f64) -> io::Result<()> {
        let mut places: Vec<(i32, i32)> = points.iter().map(|&p| self.place(p)).collect();
        places.dedup();
        let width = (width * self.scale).round().max(1.0) as u32;
        let style = rgba(colour, 1.0).stroke_width(width);
        if self.back_end.joins == Joins::OfBackEnd || places.len() < 3 {
            return self.area.draw(&PathElement::new(places, style)).map_err(other);
        }
        for ends in places.windows(2) {
            self.area.draw(&PathElement::new(ends, style)).map_err(other)?;
        }
        let disc = |&corner: &(i32, i32)| Circle::new(corner, (width / 2) as i32, rgba(colour, 1.0).filled());
        places[1..places.len() - 1].iter().try_for_each(|corner| self.area.draw(&disc(corner)).map_err(other))
    }

    /// A filled polygon.
    pub fn polygon(&self, points: &[[f64; 2]], colour: Rgb, opacity: f64) -> io::Result<()> {
        let places: Vec<(i32, i32)> = points.iter().map(|&p| self.place(p)).collect();
        self.area.draw(&Polygon::new(places, rgba(colour, opacity).filled())).map_err(other)
    }

    /// A filled rectangle between two corners.
    pub fn rectangle(&self, from: [f64; 2], to: [f64; 2], colour: Rgb) -> io::Result<()> {
        let corners = [self.place(from), self.place(to)];
        self.area.draw(&Rectangle::new(corners, rgba(colour, 1.0).filled())).map_err(other)
    }

    /// A circle that shows white inside.
    pub fn ring(&self, centre: [f64; 2], radius: f64, colour: Rgb, width: f64) -> io::Result<()> {
        let (outer, inner) = ((radius + 0.5 * width) * self.scale, (radius - 0.5 * width) * self.scale);
        for (radius, colour) in [(outer, colour), (inner, [255; 3])] {
            let circle = Circle::new(self.place(centre), radius.round() as i32, rgba(colour, 1.0).filled());
            self.area.draw(&circle).map_err(other)?;
        }
        Ok(())
    }

    /// Text on one line.
    pub fn text(&self, text: Text<'_>) -> io::Result<()> {
        let BackEnd { size_per_em, baseline, .. } = self.back_end;
        let size = text.size * size_per_em * self.scale;
        let horizontal = match text.align {
            Align::Left => HPos::Left,
            Align::Center => HPos::Center,
            Align::Right => HPos::Right,
        };
        let style = TextStyle::from(font(size, text.weight)).pos(Pos::new(horizontal, VPos::Top));
        let (x, y) = self.place(text.at);
        let place = (x, y - (baseline * size).round() as i32);
        self.area.draw_text(text.text, &style.color(&rgba(text.colour, 1.0)), place).map_err(other)
    }

    fn place(&self, [x, y]: [f64; 2]) -> (i32, i32) {
        ((x * self.scale).round() as i32, (y * self.scale).round() as i32)
    }
}

/// Width of a text in logical pixels.
pub(super) fn text_width(text: &str, size: f64, weight: Weight) -> f64 {
    register_fonts();
    // Widths are whole pixels: measured at 16 times the size.
    let width = font(size * HEIGHT_PER_EM * 16.0, weight).box_size(text).map(|(width, _)| width);
    f64::from(width.unwrap_or(0)) / 16.0
}

fn font(size: f64, weight: Weight) -> FontDesc<'static> {
    let style = match weight {
        Weight::Regular => FontStyle::Normal,
        Weight::Bold => FontStyle::Bold,
    };
    FontDesc::new(FontFamily::Name(FAMILY), size, style)
}

fn register_fonts() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let fonts: [(FontStyle, &'static [u8]); 2] = [
            (FontStyle::Normal, include_bytes!("../../assets/fonts/DejaVuSans-subset.ttf")),
            (FontStyle::Bold, include_bytes!("../../assets/fonts/DejaVuSans-Bold-subset.ttf")),
        ];
        for (style, bytes) in fonts {
            assert!(register_font(FAMILY, style, bytes).is_ok(), "the bundled fonts are fonts");
        }
    });
}

fn rgba([red, green, blue]: Rgb, opacity: f64) -> RGBAColor {
    RGBAColor(red, green, blue, opacity)
}

fn other(error: impl std::fmt::Display) -> io::Error {
    io::Error::other(error.to_string())
}
