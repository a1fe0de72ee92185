//! Pictures: a small renderer for particles, membranes and obstacles, the same to the bit on every machine
//! with the same floating-point arithmetic and for any number of threads.
//!
//! Particles are spheres of their volume, membranes are surfaces that are lit from both sides; depth is
//! resolved per pixel, the image is drawn at twice its size and averaged down. In 2D one looks from above,
//! and colours are not shaded, so that they are those of the colour bar.

mod annotate;
mod camera;
mod light;
mod raster;
mod scene;
mod skin;
mod spec;
mod unseen;

pub use spec::{CutSpec, FrameSpec, FrameWord, MeshLines, PictureSpec};
pub use unseen::unseen_cut;

use super::atomic::create_directory;
use super::component::Component;
use super::history::{History, HistoryTable};
use super::image::Image;
use super::label::{UnitLabels, file_name};
use super::set::{Set, SetQuantity, Start, expected};
use super::ticks::{Shown, Ticks};
use crate::error::{Diagnostic, Error, Result};
use crate::parallel;
use crate::simulation::{Monitor, Snapshot};
use annotate::{Notes, annotate};
use camera::{Camera, ProjectedPoint, STANDARD_VIEW};
use light::Lamps;
use raster::{Buffer, Finish, ImplicitSolid, Outlook, Primitive};
use scene::Scene;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Pixels that are averaged to one, per direction.
const SUPERSAMPLING: usize = 2;
/// Pictures of this height have one pixel per logical pixel.
const LOGICAL_HEIGHT: f64 = 960.0;
/// Reach of ambient occlusion, relative to the height of the picture.
const SHADE: f64 = 0.022;
/// Obstacles and outlines.
const OBSTACLE: [u8; 3] = [0xb9, 0xbc, 0xc2];
const OUTLINE: [u8; 3] = [0xcf, 0xcf, 0xcf];

/// A box [m]: lower and upper corner.
pub type BoxCorners = [[f64; 3]; 2];

/// Something rigid that stands in a picture and is not in the snapshots.
pub trait PictureObstacle: Send + Sync {
    /// Signed distance [m] of a point from its surface, where that is at the start.
    fn distance(&self, x: [f64; 3]) -> f64;

    /// Displacement [m] at a time [s].
    fn displacement(&self, t: f64) -> [f64; 3];
}

/// An obstacle, and what was seen of it last, with how far it had moved then [m]: most obstacles rest, and lines of
/// sight take long.
struct DrawnObstacle {
    solid: Box<dyn PictureObstacle>,
    seen: Mutex<Option<([f64; 3], Outlook)>>,
}

/// Renders the pictures of one [`PictureSpec`].
pub struct Picture {
    spec: PictureSpec,
    camera: Camera,
    frame: BoxCorners,
    starts: BTreeMap<String, Start>,
    obstacles: Vec<DrawnObstacle>,
    directory: PathBuf,
    index: History,
    count: usize,
    last_time: f64,
    interval: f64,
    units: UnitLabels,
}

impl Picture {
    /// Pictures in `directory/<name>`, every `interval` seconds unless the picture says otherwise.
    ///
    /// `initial` is the state at the start, also of a run that is going to be resumed; `domain` is what the
    /// picture shows if it doesn't say. `key` is the picture's place in the case, for messages.
    ///
    /// # Errors
    /// A name that the model doesn't have, or values that make no picture.
    pub fn new(
        spec: PictureSpec,
        key: &str,
        initial: &Snapshot<'_>,
        domain: BoxCorners,
        directory: &Path,
        interval: f64,
    ) -> Result<Self, Diagnostic> {
        spec.check(key)?;
        check_names(&spec, key, initial)?;
        let frame = frame(&spec, initial, domain);
        let pixel = pixel(&spec);
        let [width, height] = spec.size.map(|pixels| f64::from(pixels) * SUPERSAMPLING as f64);
        let [left, top, right, bottom] = annotate::margins(spec.field.is_some()).map(|margin| margin * pixel);
        let flat = initial.dimension == 2;
        let view = spec.view.unwrap_or(if flat { [0.0, 0.0, 1.0] } else { STANDARD_VIEW });
        let up = spec.up.unwrap_or(if flat { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] });
        let camera = Camera::new(view, up, frame, [left, top, width - right, height - bottom]);
        let moved = spec.field.as_deref() == Some("displacement");
        let starts = Set::all(initial).filter(|_| moved).map(|set| (set.name().to_owned(), set.start())).collect();
        let name = file_name(&spec.name);
        Ok(Self {
            camera,
            frame,
            starts,
            obstacles: vec![],
            directory: directory.join(&name),
            index: History::new(directory.join(format!("{name}.csv"))),
            count: 0,
            last_time: f64::NEG_INFINITY,
            interval: spec.every.unwrap_or(interval),
            units: UnitLabels::default(),
            spec,
        })
    }

    /// The picture with units in its text, or without.
    #[must_use]
    pub fn with_units(self, units: UnitLabels) -> Self {
        Self { units, ..self }
    }

    /// Adds something that is not in the snapshots.
    #[must_use]
    pub fn with_obstacle(mut self, obstacle: Box<dyn PictureObstacle>) -> Self {
        self.obstacles.push(DrawnObstacle { solid: obstacle, seen: Mutex::default() });
        self
    }

    /// The picture of a snapshot.
    ///
    /// # Errors
    /// When text can't be set.
    pub fn render(&self, snapshot: &Snapshot<'_>) -> std::io::Result<Image> {
        let pixel = pixel(&self.spec);
        let scene = Scene::new(&self.spec, &self.camera, pixel, snapshot, &self.starts, self.units);
        let [width, height] = self.spec.size.map(|pixels| pixels as usize * SUPERSAMPLING);
        let [_, _, bar, _] = annotate::margins(scene.colouring.is_some());
        // The colour bar stands on white, also where the model is larger than the frame.
        let room = if scene.colouring.is_some() { (bar * pixel) as usize } else { 0 };
        let buffer = self.draw(Buffer::new(width - room.min(width / 2), height), &scene, snapshot);
        let mut image = light::light(&buffer, &Lamps::new(), SHADE * height as f64).widened(width);
        let notes = Notes {
            time: self.time_label(snapshot.time),
            field: self.spec.field.as_deref().unwrap_or_default(),
            colouring: scene.colouring.as_ref(),
            scale: self.camera.scale / pixel,
            length_unit: self.units.unit("m"),
        };
        annotate(&mut image, pixel, &notes)?;
        Ok(image.averaged_down(SUPERSAMPLING))
    }

    /// Draws everything that has a depth.
    fn draw(&self, mut buffer: Buffer, scene: &Scene<'_>, snapshot: &Snapshot<'_>) -> Buffer {
        let table = scene.colouring.as_ref().map_or(&[][..], |colouring| &colouring.table);
        buffer.draw(&self.outline(snapshot.dimension, scene.pixel), table);
        let finish = if snapshot.dimension == 2 { Finish::Flat } else { Finish::Lit };
        for obstacle in &self.obstacles {
            let mut seen = obstacle.seen.lock().unwrap_or_else(PoisonError::into_inner);
            let (moved, size) = (obstacle.solid.displacement(snapshot.time), [buffer.width, buffer.height]);
            if !seen.as_ref().is_some_and(|(place, outlook)| *place == moved && outlook.width == buffer.width) {
                let distance = |x: [f64; 3]| obstacle.solid.distance(std::array::from_fn(|i| x[i] - moved[i]));
                let solid = ImplicitSolid { distance: &distance, frame: self.frame, depth: self.depth() };
                *seen = Some((moved, Outlook::new(size, &solid, &self.camera)));
            }
            if let Some((_, outlook)) = &*seen {
                buffer.draw_obstacle(outlook, OBSTACLE, finish);
            }
        }
        scene.for_particles(|shapes| buffer.draw(shapes, table));
        if self.spec.opacity < 1.0 {
            let lamps = Lamps::new();
            buffer.draw_veil(scene.surfaces(), table, self.spec.opacity, |pixel| lamps.colour(pixel, || 0.0));
        } else {
            buffer.draw(&scene.surfaces(), table);
        }
        buffer
    }

    /// The unit of the time fits the interval, so that it stays the same over a run; so do the digits, but at an end
    /// that is no whole number of intervals.
    fn time_label(&self, time: f64) -> String {
        let shown = Shown::new(time.abs().max(10.0 * self.interval), self.units.unit("s"));
        let count = time / self.interval;
        let whole = !count.is_finite() || (count - count.round()).abs() < 1e-6;
        let finest = if whole { self.interval } else { 0.01 * time.abs() };
        let ticks = Ticks::new(0.0, 0.2 * finest * shown.factor, 1);
        format!("t = {} {}", ticks.label(time * shown.factor), shown.unit).trim_end().to_owned()
    }

    /// The edges of the frame, but those that would lie before the model.
    fn outline(&self, dimension: usize, pixel: f64) -> Vec<Primitive> {
        let corner = |n: usize| std::array::from_fn(|i| self.frame[n >> i & 1][i]);
        let near = |n: usize| self.camera.project(corner(n)).near;
        let nearest = (0..8).max_by(|&a, &b| near(a).total_cmp(&near(b))).unwrap_or(0);
        let pairs = (0..8).flat_map(|n| (0..dimension).map(move |axis| (n, n | 1 << axis))).filter(|(a, b)| a != b);
        let behind = |&(a, b): &(usize, usize)| if dimension == 2 { b < 4 } else { a != nearest && b != nearest };
        let stroke = |(a, b)| {
            let ends = [corner(a), corner(b)].map(|x| self.camera.project(x));
            Primitive::Stroke { ends, radius: 0.7 * pixel, paint: [OUTLINE; 2] }
        };
        pairs.filter(behind).map(stroke).collect()
    }

    /// From the farthest to the nearest corner of the frame, in pixels towards the eye.
    fn depth(&self) -> [f64; 2] {
        let corner = |n: usize| -> [f64; 3] { std::array::from_fn(|i| self.frame[n >> i & 1][i]) };
        let near = (0..8).map(|n| self.camera.project(corner(n))).map(|ProjectedPoint { near, .. }| near);
        near.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], near| [low.min(near), high.max(near)])
    }
}

impl Monitor for Picture {
    fn interval(&self) -> f64 {
        self.interval
    }

    fn sample(&mut self, snapshot: &Snapshot<'_>, _due: f64) -> Result<()> {
        if snapshot.time <= self.last_time {
            return Ok(());
        }
        let path = self.directory.join(format!("{:06}.png", self.count));
        create_directory(&self.directory)?;
        self.render(snapshot).map_err(|error| Error::io(&path, error))?.write_png(&path)?;
        let heads = [self.units.head("time", "s"), "picture".to_owned()];
        self.index.append(&heads, &[snapshot.time, self.count as f64])?;
        self.last_time = snapshot.time;
        self.count += 1;
        Ok(())
    }

    fn resume(&mut self, time: f64) -> Result<()> {
        self.index.resume(time)?;
        let table = HistoryTable::read(self.index.path())?;
        if let Some(times) = table.columns.first() {
            self.count = times.len();
            self.last_time = times.last().copied().unwrap_or(f64::NEG_INFINITY);
        }
        Ok(())
    }
}

/// Pixels of the supersampled image per logical pixel.
fn pixel(spec: &PictureSpec) -> f64 {
    f64::from(spec.size[1]) / LOGICAL_HEIGHT * SUPERSAMPLING as f64
}

/// Lower and upper corner of the box around places.
fn box_around(places: &[[f64; 3]]) -> BoxCorners {
    parallel::corners(places.len(), |n| places[n])
}

/// The box that must fit into the picture.
fn frame(spec: &PictureSpec, initial: &Snapshot<'_>, domain: BoxCorners) -> BoxCorners {
    match &spec.frame {
        FrameSpec::Word(FrameWord::Domain) => domain,
        FrameSpec::Word(FrameWord::Start) => {
            let shown =
                Set::all(initial).filter(|set| spec.of.is_empty() || spec.of.iter().any(|name| name == set.name()));
            let places = shown.map(Set::position).filter(|places| !places.is_empty());
            let corners: Vec<[f64; 3]> = places.flat_map(box_around).collect();
            let all = box_around(&corners);
            if all[0][0] <= all[1][0] { all } else { domain }
        }
        FrameSpec::Box(given) => {
            let side =
                |given: &[f64], domain: [f64; 3]| std::array::from_fn(|i| given.get(i).copied().unwrap_or(domain[i]));
            [side(&given.lower, domain[0]), side(&given.upper, domain[1])]
        }
    }
}

fn check_names(spec: &PictureSpec, key: &str, initial: &Snapshot<'_>) -> Result<(), Diagnostic> {
    let names: Vec<&str> = Set::all(initial).map(Set::name).collect();
    for (list, field) in [(&spec.of, "of"), (&spec.plain, "plain")] {
        if let Some(name) = list.iter().find(|name| !names.contains(&name.as_str())) {
            let message = format!("there is no body, membrane or mesh named `{name}`");
            return Err(Diagnostic::error(format!("{key}.{field}"), message).help(expected(name, &names)));
        }
    }
    let Some(field) = &spec.field else { return Ok(()) };
    let shown = || Set::all(initial).filter(|set| spec.of.is_empty() || spec.of.iter().any(|name| name == set.name()));
    let known: Vec<&str> = shown().flat_map(Set::quantity_names).collect();
    if known.contains(&field.as_str()) {
        let found = shown().find_map(|set| set.quantity(field, &Start::new()));
        let misfit = |(component, quantity): (Component, SetQuantity<'_>)| {
            component.misfit(&format!("{key}.component"), field, quantity.components, initial.dimension)
        };
        return spec.component.zip(found).and_then(misfit).map_or(Ok(()), Err);
    }
    let mut once = vec![];
    known.into_iter().for_each(|name| {
        if !once.contains(&name) {
            once.push(name)
        }
    });
    let message = format!("nothing in this picture has a field `{field}`");
    Err(Diagnostic::error(format!("{key}.field"), message).help(expected(field, &once)))
}
