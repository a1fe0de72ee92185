//! Images in memory: averaging down, and PNG files.

use super::atomic;
use crate::error::Result;
use std::io;
use std::path::Path;

/// An image of 8-bit red, green and blue, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Three bytes per pixel.
    pub pixels: Vec<u8>,
}

impl Image {
    /// A white image.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![255; 3 * width * height] }
    }

    /// The image with each block of `factor × factor` pixels averaged to one.
    pub fn averaged_down(&self, factor: usize) -> Self {
        let mut small = Self::new(self.width / factor, self.height / factor);
        let (row, count) = (3 * self.width, (factor * factor) as u32);
        // Down the columns first, which registers do many at a time.
        let mut sums = vec![0_u32; row];
        let blocks = self.pixels.chunks_exact(factor * row);
        for (means, block) in small.pixels.chunks_exact_mut((3 * small.width).max(1)).zip(blocks) {
            sums.fill(0);
            for line in block.chunks_exact(row) {
                sums.iter_mut().zip(line).for_each(|(sum, &value)| *sum += u32::from(value));
            }
            for (mean, sums) in means.chunks_exact_mut(3).zip(sums.chunks_exact(3 * factor)) {
                let mut sum = [count / 2; 3];
                for pixel in sums.chunks_exact(3) {
                    (0..3).for_each(|channel| sum[channel] += pixel[channel]);
                }
                (0..3).for_each(|channel| mean[channel] = (sum[channel] / count) as u8);
            }
        }
        small
    }

    /// The image with white to its right, up to `width` pixels per row.
    pub fn widened(&self, width: usize) -> Self {
        let mut wide = Self::new(width.max(self.width), self.height);
        let rows = wide.pixels.chunks_exact_mut(3 * wide.width).zip(self.pixels.chunks_exact(3 * self.width));
        rows.for_each(|(to, from)| to[..from.len()].copy_from_slice(from));
        wide
    }

    /// Writes a PNG file, whole or not at all.
    ///
    /// # Errors
    /// Input/output errors.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        atomic::write(path, |out| {
            let mut encoder = png::Encoder::new(out, self.width as u32, self.height as u32);
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_depth(png::BitDepth::Eight);
            encoder.set_compression(png::Compression::Fast);
            let mut writer = encoder.write_header().map_err(io::Error::other)?;
            writer.write_image_data(&self.pixels).map_err(io::Error::other)?;
            writer.finish().map_err(io::Error::other)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn averaging_rounds_the_mean_of_each_block() {
        let pixels = (0..4 * 2 * 3).map(|n| (n / 3 * 10) as u8).collect();
        let small = Image { width: 4, height: 2, pixels }.averaged_down(2);
        assert_eq!((small.width, small.height), (2, 1));
        assert_eq!(small.pixels, [25, 25, 25, 45, 45, 45]);
    }

    #[test]
    fn png_reads_back() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("image.png");
        let image = Image { width: 2, height: 1, pixels: vec![1, 2, 3, 4, 5, 6] };
        image.write_png(&path).unwrap();
        let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, image.pixels);
    }
}
