//! From a snapshot to shapes in pixels.

use super::camera::{Camera, ProjectedPoint};
use super::raster::{Finish, Paint, Primitive};
use super::skin::skin;
use super::spec::{MeshLines, PictureSpec};
use crate::math::Vector;
use crate::output::UnitLabels;
use crate::output::colour::{ColourMap, PALETTE, Rgb};
use crate::output::component::Component;
use crate::output::set::{On, Set, SetQuantity, Start};
use crate::output::ticks::round_step;
use crate::simulation::{Elements, Snapshot, SurfaceSet};
use std::collections::BTreeMap;

/// Colours of the table that graded paint looks up.
pub(super) const TABLE: usize = 512;
/// Particles are larger than their volume, so that neighbours close up: spheres a bit, discs up to the corners
/// of their squares.
const SWELL_3D: f64 = 1.24;
const SWELL_2D: f64 = 1.42;
/// Particles that are drawn together.
const BATCH: usize = 1 << 14;
/// Depth by which solids lie over the mesh of the fluid in two dimensions [pixels].
const RAISED: f64 = 1e3;
/// Colour of their outline.
const SOLID_EDGE: Rgb = [40, 40, 40];
/// Elements smaller than this [pixels] have no lines.
const SMALLEST_OUTLINED: f64 = 9.0;

/// The field that gives the colours of a picture.
pub(super) struct Colouring {
    /// Values at the ends of the colour bar.
    pub range: [f64; 2],
    /// Unit of the values.
    pub unit: String,
    /// The colours from one end to the other.
    pub table: Vec<Rgb>,
}

/// One number per entry or element.
struct Values {
    on: On,
    numbers: Vec<f64>,
}

/// A picture's view of a snapshot.
pub(super) struct Scene<'s> {
    spec: &'s PictureSpec,
    camera: &'s Camera,
    /// Pixels per logical pixel.
    pub pixel: f64,
    dimension: usize,
    sets: Vec<(Set<'s>, Option<Values>, Rgb)>,
    /// The colour bar, where the picture has a field.
    pub colouring: Option<Colouring>,
}

impl<'s> Scene<'s> {
    /// Chooses the parts shown and their colours.
    pub fn new(
        spec: &'s PictureSpec,
        camera: &'s Camera,
        pixel: f64,
        snapshot: &'s Snapshot<'s>,
        starts: &BTreeMap<String, Start>,
        units: UnitLabels,
    ) -> Self {
        let shown = |set: &Set<'_>| spec.of.is_empty() || spec.of.iter().any(|name| name == set.name());
        let mut unit = String::new();
        let sets: Vec<_> = Set::all(snapshot).zip(own_colours()).filter(|(set, _)| shown(set)).collect();
        let sets = sets.into_iter().map(|(set, colour)| {
            let field = spec.field.as_ref().filter(|_| !spec.plain.iter().any(|name| name == set.name()));
            let none = Start::new();
            let quantity = field.and_then(|field| set.quantity(field, starts.get(set.name()).unwrap_or(&none)));
            let values = quantity.map(|quantity| {
                units.unit(quantity.unit).clone_into(&mut unit);
                Values { on: quantity.on, numbers: numbers(spec, &quantity) }
            });
            (set, values, colour)
        });
        let sets: Vec<_> = sets.collect();
        let colouring = sets.iter().any(|(_, values, _)| values.is_some()).then(|| {
            let map = spec.map(snapshot.dimension);
            let own = || range(sets.iter().filter_map(|(_, values, _)| values.as_ref()));
            let range = spec.range.unwrap_or_else(|| if map == ColourMap::BlueRed { about_zero(own()) } else { own() });
            let table = (0..TABLE).map(|n| map.colour(n as f64 / (TABLE - 1) as f64)).collect();
            Colouring { range, unit, table }
        });
        Self { spec, camera, pixel, dimension: snapshot.dimension, sets, colouring }
    }

    /// Shows the particles to `draw`, some of them at a time: their shapes would take more memory than they do.
    pub fn for_particles(&self, mut draw: impl FnMut(&[Primitive])) {
        let mut shapes = vec![];
        for (set, values, own) in &self.sets {
            let Set::Points(set) = set else { continue };
            let volumes = set.fields.iter().find(|field| field.name == "volume").map(|field| field.values());
            let fallback = spacing(&set.position);
            for start in (0..set.position.len()).step_by(BATCH) {
                let batch = start..set.position.len().min(start + BATCH);
                let size = |p: usize| volumes.as_ref().map_or(fallback, |volumes| self.size(volumes[p]));
                let colour = |p: usize| self.colour(values.as_ref().map(|values| values.numbers[p]), *own);
                shapes.clear();
                shapes.extend(batch.filter_map(|p| self.particle(&set.position[p], size(p), colour(p))));
                draw(&shapes);
            }
        }
    }

    /// Membranes and meshes. In two dimensions solids lie over the mesh of the fluid, with an outline.
    pub fn surfaces(&self) -> Vec<Primitive> {
        let surface = |set: &Set<'s>| if let Set::Surface(set) = set { set.elements.len() } else { 0 };
        let ground = (0..self.sets.len()).max_by_key(|&n| surface(&self.sets[n].0));
        let mut shapes = vec![];
        for (n, (set, values, own)) in self.sets.iter().enumerate() {
            if let Set::Surface(set) = set {
                // Large areas are calmer in a pale colour.
                let pale = if self.dimension == 2 { *own } else { own.map(|c| c / 2 + 122) };
                let before = shapes.len();
                self.add_elements(set, values.as_ref(), pale, &mut shapes);
                if self.dimension == 2 && ground != Some(n) {
                    shapes[before..].iter_mut().for_each(Primitive::raise);
                    self.add_outline(set, &mut shapes);
                }
            }
        }
        shapes
    }

    /// Edges that one element alone has, of elements with an area.
    fn add_outline(&self, set: &SurfaceSet<'_>, shapes: &mut Vec<Primitive>) {
        let mut edges: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        for nodes in set.elements.iter().filter(|nodes| nodes.len() > 2) {
            for (k, &a) in nodes.iter().enumerate() {
                let b = nodes[(k + 1) % nodes.len()];
                *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
            }
        }
        for (edge, _) in edges.into_iter().filter(|&(_, count)| count == 1) {
            let places = edge.map(|node| set.position[node as usize]);
            if !places.iter().any(|x| self.hidden(x)) {
                let ends = places
                    .map(|x| self.camera.project(x))
                    .map(|end| ProjectedPoint { near: end.near + 2.0 * RAISED, ..end });
                shapes.push(Primitive::Stroke { ends, radius: 0.6 * self.pixel, paint: [SOLID_EDGE; 2] });
            }
        }
    }

    /// Place of a value in the colour table, from 0 to 1.
    fn place(&self, value: f64) -> f64 {
        let [low, high] = self.colouring.as_ref().map_or([0.0, 1.0], |colouring| colouring.range);
        let place = (value - low) / (high - low);
        if place.is_nan() { 0.0 } else { place.clamp(0.0, 1.0) }
    }

    fn colour(&self, value: Option<f64>, own: Rgb) -> Rgb {
        match (value, &self.colouring) {
            (Some(value), Some(colouring)) => {
                colouring.table[(self.place(value) * (TABLE - 1) as f64).round() as usize]
            }
            _ => own,
        }
    }

    fn hidden(&self, x: &[f64; 3]) -> bool {
        self.spec.cut.as_ref().is_some_and(|cut| cut.hides(x)) || x.iter().any(|c| !c.is_finite())
    }

    /// The edge of a particle's volume [m].
    fn size(&self, volume: f64) -> f64 {
        volume.abs().powf(if self.dimension == 2 { 0.5 } else { 1.0 / 3.0 })
    }

    /// The shape of a particle of a size [m], unless it is hidden.
    fn particle(&self, x: &[f64; 3], size: f64, colour: Rgb) -> Option<Primitive> {
        let (swell, finish) = if self.dimension == 2 { (SWELL_2D, Finish::Flat) } else { (SWELL_3D, Finish::Lit) };
        let radius = 0.5 * swell * size * self.spec.particle_size * self.camera.scale;
        // Particles of less than a pixel would be lost between pixel centres.
        let radius = radius.max(0.75);
        (!self.hidden(x)).then(|| Primitive::Ball { centre: self.camera.project(*x), radius, colour, finish })
    }

    fn add_elements(&self, set: &SurfaceSet<'_>, values: Option<&Values>, own: Rgb, shapes: &mut Vec<Primitive>) {
        let shown = |nodes: &[u32]| !nodes.iter().any(|&n| self.hidden(&set.position[n as usize]));
        let skin = if set.kind == Elements::Volume { skin(&set.elements, shown) } else { Vec::new() };
        let faces: Vec<_> = match set.kind {
            Elements::Sheet => set.elements.iter().copied().enumerate().collect(),
            Elements::Volume => skin.iter().map(|face| (face.element, face.nodes())).collect(),
        };
        self.add_faces(set, &faces, values, own, shapes);
    }

    /// `faces`: the element of each, and its nodes.
    fn add_faces(
        &self,
        set: &SurfaceSet<'_>,
        faces: &[(usize, &[u32])],
        values: Option<&Values>,
        own: Rgb,
        shapes: &mut Vec<Primitive>,
    ) {
        let projected: Vec<ProjectedPoint> = set.position.iter().map(|x| self.camera.project(*x)).collect();
        let normals = node_normals(set, faces, self.camera);
        let line = self.line_width(faces, &projected);
        for &(e, nodes) in faces {
            if nodes.iter().any(|&n| self.hidden(&set.position[n as usize])) {
                continue;
            }
            let value =
                |n: u32| values.map(|values| values.numbers[if values.on == On::Elements { e } else { n as usize }]);
            let node = |corner: usize| nodes[corner] as usize;
            match nodes.len() {
                2 => {
                    let paint = [self.colour(value(nodes[0]), own), self.colour(value(nodes[1]), own)];
                    // Membranes lie over the particles.
                    let ends = [projected[node(0)], projected[node(1)]]
                        .map(|end| ProjectedPoint { near: end.near + 1e6, ..end });
                    shapes.push(Primitive::Stroke { ends, radius: 1.6 * self.pixel, paint });
                }
                count => (2..count).for_each(|last| {
                    let fan = [0, last - 1, last];
                    let paint = if values.is_some() {
                        Paint::Graded(fan.map(|c| value(nodes[c]).map_or(0.0, |v| self.place(v) as f32)))
                    } else {
                        Paint::Solid(own)
                    };
                    let (corners, normals) = (fan.map(|c| projected[node(c)]), fan.map(|c| normals[node(c)]));
                    let edges = fan_edges(line, last, count);
                    shapes.push(Primitive::Triangle { corners, normals, paint, edges });
                }),
            }
        }
    }

    /// Half the width of mesh lines [pixels]; none for elements that are too small.
    fn line_width(&self, faces: &[(usize, &[u32])], projected: &[ProjectedPoint]) -> f32 {
        let edges = faces.iter().filter(|(_, nodes)| nodes.len() > 2).map(|(_, nodes)| {
            let [a, b] = [projected[nodes[0] as usize], projected[nodes[1] as usize]];
            (a.x - b.x).hypot(a.y - b.y).max((a.near - b.near).abs())
        });
        let (count, sum) = edges.fold((0.0, 0.0), |(count, sum), length| (count + 1.0, sum + length));
        let shown = self.spec.mesh_lines == MeshLines::Thin && sum / count >= SMALLEST_OUTLINED * self.pixel;
        if shown { (0.4 * self.pixel) as f32 } else { 0.0 }
    }
}

impl Primitive {
    /// Brings it nearer, over what lies in the plane of a two-dimensional picture.
    fn raise(&mut self) {
        match self {
            Self::Ball { centre, .. } => centre.near += RAISED,
            Self::Triangle { corners, .. } => corners.iter_mut().for_each(|corner| corner.near += RAISED),
            Self::Stroke { ends, .. } => ends.iter_mut().for_each(|end| end.near += RAISED),
        }
    }
}

/// Colours of bodies and membranes without a field, in the order of the snapshot.
fn own_colours() -> impl Iterator<Item = Rgb> {
    // Lighter than curves: they are shaded.
    PALETTE.into_iter().map(|colour| colour.map(|c| (f64::from(c) * 0.8 + 255.0 * 0.2) as u8)).cycle()
}

fn numbers(spec: &PictureSpec, quantity: &SetQuantity<'_>) -> Vec<f64> {
    let number = |value: &[f64]| match spec.component {
        Some(component) if component.fits(value.len()) => component.of(value),
        _ if value.len() == 1 => value[0],
        _ => Component::Magnitude.of(value),
    };
    quantity.values.chunks_exact(quantity.components).map(number).collect()
}

/// A round range around all but the outermost values.
fn range<'v>(values: impl Iterator<Item = &'v Values>) -> [f64; 2] {
    /// Part of the values that is left out at each end.
    const OUTSIDE: f64 = 0.002;
    /// Values that differ by less than this part of them are one value: no colours for round-off.
    const UNIFORM: f64 = 1e-6;
    let mut all: Vec<f64> =
        values.flat_map(|values| values.numbers.iter().copied().filter(|v| v.is_finite())).collect();
    if all.is_empty() {
        return [0.0, 1.0];
    }
    let count = all.len();
    let mut quantile = |part: f64| *all.select_nth_unstable_by((part * (count - 1) as f64) as usize, f64::total_cmp).1;
    let (low, high) = (quantile(OUTSIDE), quantile(1.0 - OUTSIDE));
    let low = if low > 0.0 && low < 0.25 * high { 0.0 } else { low };
    if high == 0.0 && low == 0.0 {
        return [0.0, 1.0];
    }
    if high - low <= UNIFORM * high.abs().max(low.abs()) {
        let room = 0.5 * high.abs();
        return [low - room, high + room];
    }
    let step = round_step((high - low) / 10.0);
    [(low / step + 1e-9).floor() * step, (high / step - 1e-9).ceil() * step]
}

/// The range of both signs that holds this one.
fn about_zero([low, high]: [f64; 2]) -> [f64; 2] {
    let most = high.abs().max(low.abs());
    [-most, most]
}

/// Sums of the normals of the faces around each node, in the camera's frame.
fn node_normals(set: &SurfaceSet<'_>, faces: &[(usize, &[u32])], camera: &Camera) -> Vec<Vector<3>> {
    let mut normals = vec![Vector::ZERO; set.position.len()];
    let at = |n: u32| Vector(set.position[n as usize]);
    for (_, nodes) in faces.iter().filter(|(_, nodes)| nodes.len() > 2) {
        let normal = if nodes.len() == 4 {
            (at(nodes[2]) - at(nodes[0])).cross(at(nodes[3]) - at(nodes[1]))
        } else {
            (at(nodes[1]) - at(nodes[0])).cross(at(nodes[2]) - at(nodes[0]))
        };
        nodes.iter().for_each(|&n| normals[n as usize] += normal);
    }
    normals.into_iter().map(|normal| camera.turn(normal).normalized().unwrap_or(Vector::unit(2))).collect()
}

/// Typical distance of neighbours [m], for particles without volume: the median over a few of them.
fn spacing(position: &[[f64; 3]]) -> f64 {
    const PROBES: usize = 25;
    let stride = position.len().div_ceil(PROBES).max(1);
    let squared = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>();
    let nearest = |p: usize| {
        let others = position.iter().enumerate().filter(|(other, _)| *other != p);
        others.map(|(_, x)| squared(x, &position[p])).fold(f64::INFINITY, f64::min).sqrt()
    };
    let mut distances: Vec<f64> = (0..position.len()).step_by(stride).map(nearest).filter(|d| d.is_finite()).collect();
    distances.sort_unstable_by(f64::total_cmp);
    distances.get(distances.len() / 2).copied().unwrap_or(0.0)
}

/// Widths of the lines of a triangle (first, `last` − 1, `last`) of the fan of an element with `count` corners: along
/// edges of the element, not along the diagonals of the fan.
fn fan_edges(line: f32, last: usize, count: usize) -> [f32; 3] {
    [line, if last + 1 == count { line } else { 0.0 }, if last == 2 { line } else { 0.0 }]
}
