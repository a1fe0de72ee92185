//! Light: lamps, and the shade of near things (ambient occlusion).
//!
//! Ambient occlusion after McGuire, Osman, Bukowski & Hennessy, *The Alchemy screen-space ambient
//! obscurance algorithm* (2011): a point is darker the more of its surroundings, sampled in the depth
//! buffer, rise above its tangent plane.

use super::raster::{Buffer, Finish, Pixel};
use crate::math::Vector;
use crate::output::colour::Rgb;
use crate::output::image::Image;
use crate::parallel;
use std::f32::consts::TAU;

/// Samples of the surroundings.
const SAMPLES: usize = 14;
/// Turns of their pattern.
const TURNS: usize = 16;
/// Darkness of full occlusion.
const STRENGTH: f32 = 1.1;
/// Light from everywhere, from the main lamp, and from the lamp at the other side.
const AMBIENT: f32 = 0.56;
const MAIN: f32 = 0.52;
const SIDE: f32 = 0.12;
/// Gloss of the main lamp.
const GLOSS: f32 = 0.10;
const SHININESS: i32 = 24;

/// Lights everything that the buffer sees, over white; `reach` is how far shade reaches, in pixels.
pub(super) fn light(buffer: &Buffer, lamps: &Lamps, reach: f64) -> Image {
    let mut image = Image::new(buffer.width, buffer.height);
    let shade = Shade::new(reach as f32);
    parallel::for_each_chunk(&mut image.pixels[..], 3 * buffer.width, |start, line| {
        let row = start / (3 * buffer.width);
        for (column, out) in line.chunks_exact_mut(3).enumerate() {
            let at = row * buffer.width + column;
            let pixel = &buffer.pixels[at];
            let lit = lamps.colour(pixel, || shade.occlusion(buffer, pixel, [column, row]));
            let veiled = match buffer.veil.get(at) {
                Some(&[red, green, blue, opacity]) => {
                    let veil = [red, green, blue];
                    std::array::from_fn(|c| (veil[c] + (1.0 - opacity) * f32::from(lit[c])).round() as u8)
                }
                None => lit,
            };
            out.copy_from_slice(&veiled);
        }
    });
    image
}

/// Directions of the lamps, in the camera's frame.
pub(super) struct Lamps {
    main: Vector<3>,
    side: Vector<3>,
    half: Vector<3>,
    tones: Tones,
}

impl Lamps {
    pub fn new() -> Self {
        let unit = |v: [f64; 3]| Vector(v).normalized().unwrap_or(Vector::unit(2));
        let main = unit([-0.45, 0.65, 0.75]);
        Self { main, side: unit([0.8, -0.1, 0.45]), half: unit((main + Vector::unit(2)).0), tones: Tones::new() }
    }

    /// The colour that is seen at a pixel.
    pub fn colour(&self, pixel: &Pixel, occlusion: impl FnOnce() -> f32) -> Rgb {
        if pixel.near == f32::NEG_INFINITY || pixel.finish == Finish::Flat {
            return pixel.colour;
        }
        let [nx, ny] = pixel.normal;
        let nz = (1.0 - nx * nx - ny * ny).max(0.0).sqrt();
        let facing = |lamp: &Vector<3>| (nx * lamp[0] as f32 + ny * lamp[1] as f32 + nz * lamp[2] as f32).max(0.0);
        let open = 1.0 - occlusion();
        let diffuse = (AMBIENT + MAIN * facing(&self.main) + SIDE * facing(&self.side)) * (0.25 + 0.75 * open);
        let gloss = GLOSS * facing(&self.half).powi(SHININESS) * open;
        pixel.colour.map(|c| self.tones.srgb(self.tones.linear[usize::from(c)] * diffuse * open + gloss))
    }
}

/// Sampling pattern around a pixel.
struct Shade {
    reach: f32,
    /// Offsets to the right and up, for each turn of the pattern.
    patterns: Vec<[[f32; 2]; SAMPLES]>,
}

impl Shade {
    /// Spirals of radius `reach` [pixels]. The pattern is turned from pixel to pixel; averaging the image
    /// down mixes its turns.
    fn new(reach: f32) -> Self {
        let spiral = |turn: usize| {
            std::array::from_fn(|sample| {
                let part = (sample as f32 + 0.5) / SAMPLES as f32;
                let (sin, cos) = (part * 5.0 * TAU + turn as f32 / TURNS as f32 * TAU).sin_cos();
                [(part * reach * cos).round(), (part * reach * sin).round()]
            })
        };
        Self { reach, patterns: (0..TURNS).map(spiral).collect() }
    }

    /// 0 in the open, up to 1 where everything around is nearer to the eye.
    fn occlusion(&self, buffer: &Buffer, pixel: &Pixel, [column, row]: [usize; 2]) -> f32 {
        let [nx, ny] = pixel.normal;
        let nz = (1.0 - nx * nx - ny * ny).max(0.0).sqrt();
        let area = self.reach * self.reach;
        let mut sum = 0.0;
        for [dx, dy] in &self.patterns[(column * 5 + row * 11) % TURNS] {
            let (x, y) = (column as isize + *dx as isize, row as isize - *dy as isize);
            if x < 0 || y < 0 || x >= buffer.width as isize || y >= buffer.height as isize {
                continue;
            }
            let dz = buffer.pixels[y as usize * buffer.width + x as usize].near - pixel.near;
            if dz.is_finite() {
                let squared = dx * dx + dy * dy + dz * dz;
                let rise = (nx * dx + ny * dy + nz * dz) - 0.03 * self.reach;
                let fade = (1.0 - squared / (4.0 * area)).max(0.0);
                sum += (rise / (squared + 0.01 * area).sqrt()).max(0.0) * fade;
            }
        }
        (STRENGTH * sum / SAMPLES as f32).min(0.85)
    }
}

/// [`to_linear`] and [`srgb`] in tables: powers of every channel of every pixel would take most of the time of a
/// picture.
struct Tones {
    /// Linear intensity of each sRGB value.
    linear: [f32; 256],
    /// The least light that has at least each tone; [`srgb`] grows with it.
    least: [f32; 256],
    /// The tone of the start of each step of light.
    coarse: [u8; Self::STEPS + 1],
}

impl Tones {
    const STEPS: usize = 1024;

    fn new() -> Self {
        let linear = std::array::from_fn(|tone| to_linear(tone as u8));
        let least = std::array::from_fn(|tone| least_light(tone as u8));
        let coarse = std::array::from_fn(|step| srgb(step as f32 / Self::STEPS as f32));
        Self { linear, least, coarse }
    }

    /// [`srgb`].
    fn srgb(&self, c: f32) -> u8 {
        let c = c.clamp(0.0, 1.0);
        let mut tone = self.coarse[(c * Self::STEPS as f32) as usize];
        while tone < 255 && self.least[usize::from(tone) + 1] <= c {
            tone += 1;
        }
        tone
    }
}

/// The least light whose tone is at least this one: positive floats are ordered like their bits.
fn least_light(tone: u8) -> f32 {
    let (mut low, mut high) = (0, 1.0_f32.to_bits());
    while low < high {
        let middle = low + (high - low) / 2;
        if srgb(f32::from_bits(middle)) >= tone { high = middle } else { low = middle + 1 }
    }
    f32::from_bits(low)
}

/// The light of a tone: sRGB, with the one power 2.2 in place of its curve.
fn to_linear(c: u8) -> f32 {
    (f32::from(c) / 255.0).powf(2.2)
}

/// The tone of light, by the same power.
fn srgb(c: f32) -> u8 {
    (c.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tables agree with the power functions, also next to the places where tones change.
    #[test]
    fn tones_are_those_of_the_powers() {
        let tones = Tones::new();
        let close = tones.least.iter().flat_map(|x| [f32::from_bits(x.to_bits().saturating_sub(1)), *x, x + 1e-6]);
        for c in (0..=5000).map(|n| n as f32 / 4900.0 - 0.01).chain(close) {
            assert_eq!(tones.srgb(c), srgb(c), "{c}");
        }
        assert!((0..=255).all(|tone| tones.linear[usize::from(tone)] == to_linear(tone)));
    }
}
