//! Colours: a palette for curves and bodies, and maps for fields.
//!
//! The palette is that of Okabe & Ito, *Color universal design* (2008), safe for all common kinds of
//! colour blindness. The maps are perceptually uniform: viridis, plasma and inferno by S. van der Walt and N. Smith
//! (matplotlib, CC0), cividis by Nuñez, Anderton & Renslow (2018), and a diverging blue–white–red of
//! equal lightness steps after Moreland (2009). Each is given by samples at equal distances, and linear
//! between them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Red, green and blue, 0 to 255, as sRGB.
pub type Rgb = [u8; 3];

/// Curves and bodies, in the order in which they are used. Yellow is left out: it is faint on white.
pub const PALETTE: [Rgb; 7] = [
    [0x00, 0x72, 0xb2],
    [0xd5, 0x5e, 0x00],
    [0x00, 0x9e, 0x73],
    [0xcc, 0x79, 0xa7],
    [0xe6, 0x9f, 0x00],
    [0x56, 0xb4, 0xe9],
    [0x33, 0x33, 0x33],
];

/// Colour maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ColourMap {
    /// Dark blue over green to yellow.
    #[default]
    Viridis,
    /// Dark blue over grey to yellow; the same for most kinds of colour vision.
    Cividis,
    /// Dark blue over magenta to yellow.
    Plasma,
    /// Black over red to light yellow.
    Inferno,
    /// Blue over white to red, for values around zero.
    BlueRed,
}

impl ColourMap {
    /// The colour of `value` from 0 to 1; grey if it is not a number.
    pub fn colour(self, value: f64) -> Rgb {
        if value.is_nan() {
            return [0x99; 3];
        }
        let samples = self.samples();
        let place = value.clamp(0.0, 1.0) * (samples.len() - 1) as f64;
        let (low, weight) = (place.floor() as usize, place.fract());
        let (a, b) = (rgb(samples[low]), rgb(samples[(low + 1).min(samples.len() - 1)]));
        std::array::from_fn(|i| (f64::from(a[i]) * (1.0 - weight) + f64::from(b[i]) * weight).round() as u8)
    }

    fn samples(self) -> &'static [u32] {
        match self {
            Self::Viridis => &VIRIDIS,
            Self::Cividis => &CIVIDIS,
            Self::Plasma => &PLASMA,
            Self::Inferno => &INFERNO,
            Self::BlueRed => &BLUE_RED,
        }
    }
}

fn rgb(hexadecimal: u32) -> Rgb {
    let [_, red, green, blue] = hexadecimal.to_be_bytes();
    [red, green, blue]
}

const VIRIDIS: [u32; 33] = [
    0x440154, 0x470d60, 0x48186a, 0x482374, 0x472d7b, 0x453781, 0x424086, 0x3e4989, 0x3b528b, 0x375b8d, 0x33638d,
    0x2f6b8e, 0x2c728e, 0x297a8e, 0x26828e, 0x23898e, 0x21918c, 0x1f988b, 0x1fa088, 0x22a785, 0x28ae80, 0x32b67a,
    0x3fbc73, 0x4ec36b, 0x5ec962, 0x70cf57, 0x84d44b, 0x98d83e, 0xaddc30, 0xc2df23, 0xd8e219, 0xece51b, 0xfde725,
];

const CIVIDIS: [u32; 33] = [
    0x00224e, 0x00285b, 0x002e6a, 0x053371, 0x1a386f, 0x273e6e, 0x32436d, 0x3b496c, 0x434e6c, 0x4b546c, 0x535a6d,
    0x5a5f6e, 0x61656f, 0x686a71, 0x6f7073, 0x767676, 0x7d7c78, 0x848279, 0x8c8878, 0x938e78, 0x9b9476, 0xa39a74,
    0xaba072, 0xb4a76f, 0xbcae6c, 0xc4b468, 0xcdbb63, 0xd5c25e, 0xdec958, 0xe7d150, 0xf0d846, 0xf9e03a, 0xfee838,
];

const PLASMA: [u32; 33] = [
    0x0d0887, 0x220690, 0x310597, 0x3f049c, 0x4c02a1, 0x5901a5, 0x6600a7, 0x7201a8, 0x7e03a8, 0x8a09a5, 0x9511a1,
    0xa01a9c, 0xaa2395, 0xb32c8e, 0xbc3587, 0xc43e7f, 0xcc4778, 0xd35171, 0xda5a6a, 0xe06363, 0xe66c5c, 0xeb7655,
    0xf0804e, 0xf58b47, 0xf89540, 0xfba139, 0xfdac33, 0xfeb82c, 0xfdc527, 0xfcd225, 0xf8df25, 0xf4ed27, 0xf0f921,
];

const INFERNO: [u32; 33] = [
    0x000004, 0x040312, 0x0b0724, 0x150b37, 0x210c4a, 0x2f0a5b, 0x3d0965, 0x4a0c6b, 0x57106e, 0x64156e, 0x71196e,
    0x7d1e6d, 0x8a226a, 0x972766, 0xa32c61, 0xb0315b, 0xbc3754, 0xc73e4c, 0xd24644, 0xdb503b, 0xe45a31, 0xeb6628,
    0xf1731d, 0xf68013, 0xf98e09, 0xfb9d07, 0xfcac11, 0xfbbc21, 0xf9cb35, 0xf5db4c, 0xf2ea69, 0xf3f68a, 0xfcffa4,
];

const BLUE_RED: [u32; 33] = [
    0x3b4cc0, 0x5058ca, 0x6264d3, 0x736fdc, 0x827be3, 0x9086e9, 0x9d91ee, 0xa99cf2, 0xb4a6f5, 0xbeb0f6, 0xc6b9f7,
    0xcdc1f6, 0xd3c9f3, 0xd8cfef, 0xdbd5ea, 0xddd9e4, 0xdddddd, 0xe5d8d2, 0xecd3c6, 0xf2ccba, 0xf6c4ae, 0xf8bba2,
    0xf9b095, 0xf8a589, 0xf5997d, 0xf28c70, 0xed7e65, 0xe67059, 0xde604e, 0xd54f43, 0xcb3d39, 0xc0282f, 0xb40426,
];

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE lightness L* of an sRGB colour.
    fn lightness(colour: Rgb) -> f64 {
        let linear = |c: u8| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        let y = 0.2126 * linear(colour[0]) + 0.7152 * linear(colour[1]) + 0.0722 * linear(colour[2]);
        if y > 0.008856 { 116.0 * y.cbrt() - 16.0 } else { 903.3 * y }
    }

    #[test]
    fn sequential_maps_grow_lighter_in_even_steps() {
        for map in [ColourMap::Viridis, ColourMap::Cividis, ColourMap::Plasma, ColourMap::Inferno] {
            let steps: Vec<f64> = (0..=32).map(|i| lightness(map.colour(f64::from(i) / 32.0))).collect();
            let mean = (steps[32] - steps[0]) / 32.0;
            for pair in steps.windows(2) {
                assert!((pair[1] - pair[0]).abs() < 2.0 * mean && pair[1] > pair[0], "{map:?}: {steps:?}");
            }
        }
    }

    #[test]
    fn the_ends_of_a_map_and_nan_have_their_colours() {
        assert_eq!(ColourMap::Viridis.colour(0.0), [0x44, 0x01, 0x54]);
        assert_eq!(ColourMap::Viridis.colour(7.0), [0xfd, 0xe7, 0x25]);
        assert_eq!(ColourMap::Viridis.colour(f64::NAN), [0x99; 3]);
    }
}
