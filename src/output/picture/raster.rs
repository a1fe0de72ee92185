//! Spheres, triangles and thick lines into a depth buffer.
//!
//! The image is cut into bands of rows; each band is drawn by one thread, all shapes in their order, so
//! the result doesn't depend on the number of threads.

use super::camera::{Camera, ProjectedPoint};
use crate::math::Vector;
use crate::output::colour::Rgb;
use crate::parallel;

/// Rows per band.
const BAND: usize = 64;

/// A pixel: depth, normal and colour of the nearest surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pixel {
    /// Pixels towards the eye; −∞ where nothing is seen.
    pub near: f32,
    /// Unit normal to the right and up; the rest points to the eye.
    pub normal: [f32; 2],
    /// Colour without light.
    pub colour: Rgb,
    /// Its finish.
    pub finish: Finish,
}

/// Finish of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Finish {
    /// By the lamps.
    Lit,
    /// Unlit: its colour is shown as it is.
    Flat,
}

impl Pixel {
    /// Nothing.
    pub const EMPTY: Self = Self { near: f32::NEG_INFINITY, normal: [0.0; 2], colour: [255; 3], finish: Finish::Flat };
}

/// Colours over a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) enum Paint {
    /// One for all.
    Solid(Rgb),
    /// A place in the colour table at each corner.
    Graded([f32; 3]),
}

/// A thing to draw, in pixels.
#[derive(Debug, Clone, Copy)]
pub(super) enum Primitive {
    /// A sphere (a disc when flat).
    Ball { centre: ProjectedPoint, radius: f64, colour: Rgb, finish: Finish },
    /// A triangle. `edges[i]` is half the width of the line along the edge opposite to corner `i`; none where 0.
    Triangle { corners: [ProjectedPoint; 3], normals: [Vector<3>; 3], paint: Paint, edges: [f32; 3] },
    /// A line with round ends.
    Stroke { ends: [ProjectedPoint; 2], radius: f64, paint: [Rgb; 2] },
}

/// The depth buffer: the nearest surface at each pixel.
pub(super) struct Buffer {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<Pixel>,
    /// Translucent layer in front of the pixels: colour times opacity, and opacity.
    /// Empty where there is no such thing.
    pub veil: Vec<[f32; 4]>,
}

impl Buffer {
    /// An empty image.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![Pixel::EMPTY; width * height], veil: vec![] }
    }

    /// Draws shapes; `table` has the colours of graded paint.
    pub fn draw(&mut self, shapes: &[Primitive], table: &[Rgb]) {
        let bins = self.bins(shapes);
        let width = self.width;
        parallel::for_each_chunk(&mut self.pixels[..], width * BAND, |start, pixels| {
            let rows = ImageBand { first: start / width, width, count: pixels.len() / width };
            let mut keep_nearest = |at: usize, pixel: Pixel| {
                if pixel.near > pixels[at].near {
                    pixels[at] = pixel;
                }
            };
            bins[rows.first / BAND].iter().for_each(|&index| rows.draw(&shapes[index], table, &mut keep_nearest));
        });
    }

    /// Draws shapes that let the light through, over everything that is there already; `lit` gives the colour seen at a
    /// pixel.
    pub fn draw_veil(
        &mut self,
        mut shapes: Vec<Primitive>,
        table: &[Rgb],
        opacity: f64,
        lit: impl Fn(&Pixel) -> Rgb + Sync,
    ) {
        // From back to front: each veil covers those behind it.
        shapes.sort_by(|a, b| a.near().total_cmp(&b.near()));
        let bins = self.bins(&shapes);
        let (width, opacity) = (self.width, opacity as f32);
        self.veil.resize(self.pixels.len(), [0.0; 4]);
        parallel::for_each_chunk((&self.pixels[..], &mut self.veil[..]), width * BAND, |start, (pixels, veil)| {
            let rows = ImageBand { first: start / width, width, count: pixels.len() / width };
            let mut cover = |at: usize, pixel: Pixel| {
                if pixel.near > pixels[at].near {
                    let [red, green, blue] = lit(&pixel).map(f32::from);
                    let over = [red * opacity, green * opacity, blue * opacity, opacity];
                    veil[at] = std::array::from_fn(|c| over[c] + (1.0 - opacity) * veil[at][c]);
                }
            };
            bins[rows.first / BAND].iter().for_each(|&index| rows.draw(&shapes[index], table, &mut cover));
        });
    }

    /// The primitives that touch each band, in their order.
    fn bins(&self, shapes: &[Primitive]) -> Vec<Vec<usize>> {
        let mut bins = vec![vec![]; self.height.div_ceil(BAND)];
        for (index, shape) in shapes.iter().enumerate() {
            let [top, bottom] = shape.rows();
            if bottom >= 0.0 && top < self.height as f64 && top <= bottom {
                let last = (bottom as usize).min(self.height - 1) / BAND;
                bins[top.max(0.0) as usize / BAND..=last].iter_mut().for_each(|bin| bin.push(index));
            }
        }
        bins
    }

    /// Draws the visible surface of an obstacle.
    pub fn draw_obstacle(&mut self, outlook: &Outlook, colour: Rgb, finish: Finish) {
        let width = self.width;
        parallel::for_each_chunk(&mut self.pixels[..], width, |start, pixels| {
            for &Hit { column, near, normal } in outlook.rows.get(start / width).into_iter().flatten() {
                let pixel = &mut pixels[column as usize];
                if near > pixel.near {
                    *pixel = Pixel { near, normal, colour, finish };
                }
            }
        });
    }
}

/// Visible surface of an obstacle, row by row, as if it stood alone.
pub(super) struct Outlook {
    /// Pixels per row.
    pub width: usize,
    rows: Vec<Vec<Hit>>,
}

/// A place of an obstacle that is seen: its pixel, how near it is to the eye, and its normal.
#[derive(Debug, Clone, Copy)]
struct Hit {
    column: u32,
    near: f32,
    normal: [f32; 2],
}

impl Outlook {
    /// The zero surface of an obstacle, found by stepping along each line of sight.
    pub fn new([width, height]: [usize; 2], obstacle: &ImplicitSolid<'_>, camera: &Camera) -> Self {
        let hit = |row: usize, column: usize| {
            let (x, y, near) = (column as f64 + 0.5, row as f64 + 0.5, obstacle.depth[1]);
            let near = obstacle.first_hit(camera, ProjectedPoint { x, y, near })?;
            let normal = obstacle.normal(camera, ProjectedPoint { x, y, near });
            Some(Hit { column: column as u32, near: near as f32, normal })
        };
        let row = |row: usize| (0..width).filter_map(|column| hit(row, column)).collect();
        Self { width, rows: parallel::collect(height, 1, row) }
    }
}

/// A solid given by its signed distance [m].
pub(super) struct ImplicitSolid<'d> {
    pub distance: &'d (dyn Fn([f64; 3]) -> f64 + Sync),
    /// Box outside of which nothing is drawn: lower and upper corner [m].
    pub frame: [[f64; 3]; 2],
    /// Farthest and nearest place of the box, in pixels towards the eye.
    pub depth: [f64; 2],
}

impl ImplicitSolid<'_> {
    /// The first intersection of a line of sight with the surface.
    fn first_hit(&self, camera: &Camera, from: ProjectedPoint) -> Option<f64> {
        /// Steps after which a line that grazes a surface gives up.
        const STEPS: usize = 200;
        let mut at = from;
        for _ in 0..STEPS {
            let point = camera.point(at);
            // Pixels until the surface, or until the box.
            let gap = (self.distance)(point).max(self.outside(&point)) * camera.scale;
            if gap < 0.05 {
                return Some(at.near);
            }
            at.near -= gap;
            if at.near.is_nan() || at.near <= self.depth[0] - 1.0 {
                return None;
            }
        }
        None
    }

    /// Distance of a point outside of the box [m].
    fn outside(&self, point: &[f64; 3]) -> f64 {
        let [lower, upper] = &self.frame;
        (0..3).map(|i| (lower[i] - point[i]).max(point[i] - upper[i])).fold(0.0, f64::max)
    }

    /// Unit normal in the camera's frame, to the right and up.
    fn normal(&self, camera: &Camera, at: ProjectedPoint) -> [f32; 2] {
        let slope = |dx: f64, dy: f64, dz: f64| {
            let side = |s: f64| {
                (self.distance)(camera.point(ProjectedPoint {
                    x: at.x + s * dx,
                    y: at.y - s * dy,
                    near: at.near + s * dz,
                }))
            };
            side(1.0) - side(-1.0)
        };
        let gradient = Vector([slope(1.0, 0.0, 0.0), slope(0.0, 1.0, 0.0), slope(0.0, 0.0, 1.0)]);
        let normal = gradient.normalized().unwrap_or(Vector::unit(2));
        [normal[0] as f32, normal[1] as f32]
    }
}

impl Primitive {
    /// Depth of its middle, towards the eye.
    fn near(&self) -> f64 {
        match self {
            Self::Ball { centre, .. } => centre.near,
            Self::Triangle { corners, .. } => corners.iter().map(|corner| corner.near).sum::<f64>() / 3.0,
            Self::Stroke { ends, .. } => 0.5 * (ends[0].near + ends[1].near),
        }
    }

    /// First and last row.
    fn rows(&self) -> [f64; 2] {
        let around = |ys: &[f64], by: f64| {
            let low = ys.iter().copied().fold(f64::INFINITY, f64::min);
            [low - by, ys.iter().copied().fold(f64::NEG_INFINITY, f64::max) + by]
        };
        match self {
            Self::Ball { centre, radius, .. } => around(&[centre.y], *radius),
            Self::Triangle { corners, .. } => around(&corners.map(|corner| corner.y), 0.0),
            Self::Stroke { ends, radius, .. } => around(&ends.map(|end| end.y), *radius),
        }
    }
}

/// A band of the image.
struct ImageBand {
    first: usize,
    width: usize,
    count: usize,
}

impl ImageBand {
    /// Calls `keep` with each pixel of the shape and its place in the band.
    fn draw(&self, shape: &Primitive, table: &[Rgb], keep: &mut impl FnMut(usize, Pixel)) {
        match *shape {
            Primitive::Ball { centre, radius, colour, finish } => {
                let (x, y) = ([centre.x - radius, centre.x + radius], [centre.y - radius, centre.y + radius]);
                self.cover(x, y, keep, |x, y| ball(centre, radius, colour, finish, [x, y]));
            }
            Primitive::Triangle { corners, normals, paint, edges } => {
                if let Some(triangle) = ScreenTriangle::new(corners, normals, paint, edges, table) {
                    let (x, y) = (bounds(corners.map(|c| c.x)), bounds(corners.map(|c| c.y)));
                    self.cover(x, y, keep, |x, y| triangle.pixel([x, y]));
                }
            }
            Primitive::Stroke { ends, radius, paint } => {
                let around = |a: f64, b: f64| [a.min(b) - radius, a.max(b) + radius];
                let (x, y) = (around(ends[0].x, ends[1].x), around(ends[0].y, ends[1].y));
                self.cover(x, y, keep, |x, y| stroke(&ends, radius, paint, [x, y]));
            }
        }
    }

    /// Calls `seen` at the centre of each pixel in a rectangle, and `keep` with the result.
    fn cover(
        &self,
        [left, right]: [f64; 2],
        [top, bottom]: [f64; 2],
        keep: &mut impl FnMut(usize, Pixel),
        seen: impl Fn(f64, f64) -> Option<Pixel>,
    ) {
        let range = |low: f64, high: f64, limit: usize| {
            (low - 0.5).ceil().max(0.0) as usize..((high - 0.5).floor() + 1.0).clamp(0.0, limit as f64) as usize
        };
        let first = self.first as f64;
        for row in range(top - first, bottom - first, self.count) {
            let y = (self.first + row) as f64 + 0.5;
            for column in range(left, right, self.width) {
                if let Some(pixel) = seen(column as f64 + 0.5, y) {
                    keep(row * self.width + column, pixel);
                }
            }
        }
    }
}

/// A sphere at a place of the image.
fn ball(centre: ProjectedPoint, radius: f64, colour: Rgb, finish: Finish, [x, y]: [f64; 2]) -> Option<Pixel> {
    let (nx, ny) = ((x - centre.x) / radius, (centre.y - y) / radius);
    let inside = 1.0 - nx * nx - ny * ny;
    let near = centre.near + radius * inside.max(0.0).sqrt();
    (inside >= 0.0).then_some(Pixel { near: near as f32, normal: [nx as f32, ny as f32], colour, finish })
}

/// A line with round ends at a place of the image.
fn stroke([from, to]: &[ProjectedPoint; 2], radius: f64, paint: [Rgb; 2], [x, y]: [f64; 2]) -> Option<Pixel> {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let length = (dx * dx + dy * dy).max(f64::MIN_POSITIVE);
    let along = (((x - from.x) * dx + (y - from.y) * dy) / length).clamp(0.0, 1.0);
    let distance = (x - from.x - along * dx).hypot(y - from.y - along * dy);
    let near = (from.near + along * (to.near - from.near)) as f32;
    let colour = paint[usize::from(along > 0.5)];
    (distance <= radius).then_some(Pixel { near, normal: [0.0; 2], colour, finish: Finish::Flat })
}

/// A triangle that is ready to be drawn.
struct ScreenTriangle<'t> {
    corners: [ProjectedPoint; 3],
    normals: [Vector<3>; 3],
    paint: Paint,
    edges: [f32; 3],
    table: &'t [Rgb],
    /// Twice the signed area.
    area: f64,
    /// Distance of a corner from the opposite edge, in pixels.
    heights: [f64; 3],
}

impl<'t> ScreenTriangle<'t> {
    /// `None` if it is seen from its edge.
    fn new(
        corners: [ProjectedPoint; 3],
        normals: [Vector<3>; 3],
        paint: Paint,
        edges: [f32; 3],
        table: &'t [Rgb],
    ) -> Option<Self> {
        let [a, b, c] = &corners;
        let area = cross(a, b, [c.x, c.y]);
        let heights = [(b, c), (c, a), (a, b)].map(|(p, q)| area.abs() / (q.x - p.x).hypot(q.y - p.y));
        (area != 0.0 && area.is_finite()).then_some(Self { corners, normals, paint, edges, table, area, heights })
    }

    /// The pixel of the triangle at a place of the image; `None` outside.
    fn pixel(&self, place: [f64; 2]) -> Option<Pixel> {
        let [a, b, c] = &self.corners;
        let weights = [(b, c), (c, a), (a, b)].map(|(p, q)| cross(p, q, place) / self.area);
        if weights.iter().any(|&w| w < 0.0) {
            return None;
        }
        let near = (0..3).map(|i| weights[i] * self.corners[i].near).sum::<f64>() as f32;
        let colour = match self.paint {
            Paint::Solid(colour) => colour,
            Paint::Graded(places) => {
                let place: f64 = (0..3).map(|i| weights[i] * f64::from(places[i])).sum();
                self.table[(place * (self.table.len() - 1) as f64).round() as usize]
            }
        };
        let on_line = (0..3).any(|i| weights[i] * self.heights[i] < f64::from(self.edges[i]));
        let colour = if on_line { colour.map(|c| (f32::from(c) * 0.66) as u8) } else { colour };
        let normals = &self.normals;
        let normal = (normals[0] * weights[0] + normals[1] * weights[1] + normals[2] * weights[2]).normalized();
        let normal = normal.unwrap_or(Vector::unit(2));
        // Both sides of a sheet are lit.
        let side = if normal[2] < 0.0 { -1.0 } else { 1.0 };
        let normal = [(side * normal[0]) as f32, (side * normal[1]) as f32];
        Some(Pixel { near, normal, colour, finish: Finish::Lit })
    }
}

fn bounds(numbers: [f64; 3]) -> [f64; 2] {
    [numbers.into_iter().fold(f64::INFINITY, f64::min), numbers.into_iter().fold(f64::NEG_INFINITY, f64::max)]
}

/// Twice the signed area of a triangle.
fn cross(p: &ProjectedPoint, q: &ProjectedPoint, [x, y]: [f64; 2]) -> f64 {
    (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x)
}
