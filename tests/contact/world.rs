//! A body of dust and a sheet without stiffness, stepped with nothing but contact: what is left of the
//! method when all forces but contact are taken away. Free of the solver's own step.

use lateen::material::{PointBatch, PointLaw, PointState, StartState, Storage};
use lateen::math::{SymTensor, Tensor, Vector};
use lateen::mpm::contact::nodes::FoldedStencil;
use lateen::mpm::contact::sample::Facet;
use lateen::mpm::contact::{Contact, FrictionTable, SheetSource, Surface};
use lateen::mpm::wall::Walls;
use lateen::mpm::{Body, EDGE, Friction, Grid, GridSetup, Kernel, KernelKind, Particles};
use lateen::mpm::{SheetContact, Step, SubStep, Wall};
use std::sync::Arc;

/// A law without stress.
#[derive(Debug)]
struct Dust;

impl PointLaw for Dust {
    fn density(&self) -> f64 {
        1.0
    }
    fn storage(&self) -> Storage {
        Storage::default()
    }
    fn initial(&self, _: &StartState) -> Result<PointState, String> {
        Ok(PointState {
            density: 1.0,
            energy: 0.0,
            pressure: 0.0,
            stress: SymTensor::ZERO,
            deformation: Tensor::identity(),
            sound_speed: 0.0,
        })
    }
    fn update(&self, _: &mut PointBatch<'_>) {}
    fn reference_sound_speed(&self) -> f64 {
        0.0
    }
}

/// A body of cells of size `spacing` that fill the box, at density `density`.
pub fn block<const D: usize>(
    name: &str,
    field: usize,
    lower: [f64; D],
    count: [usize; D],
    spacing: f64,
    density: f64,
    velocity: Vector<D>,
) -> Body<D> {
    let number: usize = count.iter().product();
    let position = |n: usize| {
        let mut rest = n;
        Vector::from_fn(|a| {
            let i = rest % count[a];
            rest /= count[a];
            lower[a] + (i as f64 + 0.5) * spacing
        })
    };
    let volume = spacing.powi(D as i32);
    let particles = Particles {
        id: (0..number as u32).collect(),
        position: (0..number).map(position).collect(),
        velocity: vec![velocity; number],
        mass: vec![density * volume; number],
        volume: vec![volume; number],
        ..Particles::default()
    };
    let kernel = Kernel::new(KernelKind::Quadratic, 0.25);
    let mut body = Body::new(name.to_owned(), Arc::new(Dust), kernel, particles);
    body.field = field;
    body
}

/// A membrane reduced to its nodes.
pub struct Sheet<const D: usize> {
    pub facets: Vec<Facet>,
    pub position: Vec<Vector<D>>,
    pub velocity: Vec<Vector<D>>,
    pub mass: Vec<f64>,
    pub held: Vec<[bool; D]>,
    pub offset: Vec<f64>,
}

impl<const D: usize> Sheet<D> {
    pub fn new(elements: &[&[u32]], position: Vec<Vector<D>>, mass_per_area: f64) -> Self {
        let facets: Vec<_> = elements.iter().map(|nodes| Facet::new(nodes)).collect();
        let mut mass = vec![0.0; position.len()];
        for facet in &facets {
            for &k in facet.nodes() {
                mass[k as usize] += facet.area(&position).norm() * mass_per_area / facet.count as f64;
            }
        }
        let n = position.len();
        Self { facets, velocity: vec![Vector::ZERO; n], held: vec![[false; D]; n], mass, position, offset: Vec::new() }
    }
}

/// Momentum over mass.
pub fn mean_velocity<const D: usize>(body: &Body<D>) -> Vector<D> {
    let p = &body.particles;
    let momentum: Vector<D> = p.mass.iter().zip(&p.velocity).map(|(&m, &v)| v * m).sum();
    momentum / p.total_mass()
}

/// The state, and what contact knows.
pub struct World<const D: usize> {
    pub grid: Grid<D>,
    pub kernel: Kernel,
    pub bodies: Vec<Body<D>>,
    pub sheets: Vec<Sheet<D>>,
    pub contact: Contact<D>,
    pub substeps: usize,
    /// Passes of contact per sub-step.
    pub passes: usize,
    friction: Friction,
    /// Bodies that move as a whole: all their particles get the mean velocity after each step.
    pub rigid: bool,
    /// Bodies that don't move.
    pub fixed: Vec<usize>,
    /// Acceleration of all bodies [m/s²], and force on each sheet node per mass.
    pub gravity: Vector<D>,
    /// Σ nodal kinetic energy change − particle kinetic energy change [J].
    pub flip_loss: f64,
    /// Work of gravity on grid nodes and membrane nodes [J].
    pub work: f64,
    start: Vec<Vec<Vector<D>>>,
    moved: Vec<Vector<D>>,
}

fn source<const D: usize>(sheet: &Sheet<D>) -> SheetSource<'_, D> {
    SheetSource {
        name: "sheet",
        facets: sheet.facets.clone(),
        reference: &sheet.position,
        mass: &sheet.mass,
        held: sheet.held.clone(),
    }
}

fn contact<const D: usize>(
    kernel: Kernel,
    bodies: &[Body<D>],
    sheets: &[Sheet<D>],
    friction: Friction,
    place: SheetContact,
) -> Contact<D> {
    let lattice = FoldedStencil::new(kernel, &std::array::from_fn(|_| [Wall::default(), Wall::default()]));
    let sources: Vec<_> = sheets.iter().map(source).collect();
    let table = FrictionTable { listed: Vec::new(), default: friction };
    Contact::new(lattice, &table, (place, 0.0), bodies, &sources)
}

/// What conservation laws speak of.
#[derive(Debug, Clone, Copy)]
pub struct Totals<const D: usize> {
    pub momentum: Vector<D>,
    pub kinetic: f64,
}

/// The blocks in the supports of points [m], and those that ghosts in these are folded into, the last axis slowest.
fn blocks_around<const D: usize>(
    grid: &Grid<D>,
    kernel: Kernel,
    points: impl Iterator<Item = Vector<D>>,
) -> Vec<[i32; D]> {
    let mut blocks = Vec::new();
    for x in points {
        let first: [i32; D] = std::array::from_fn(|a| kernel.first((x[a] - grid.origin[a]) * (1.0 / grid.cell)));
        let last = first.map(|i| i + kernel.support() - 1);
        let block = |i: i32| i.div_euclid(EDGE as i32);
        let lower: [i32; D] =
            std::array::from_fn(|a| block(first[a].min(2 * grid.cells[a] - last[a]).max(first[a] - 1)));
        let upper: [i32; D] = std::array::from_fn(|a| block(last[a].max(-first[a]).min(last[a] + 1)));
        let corner = |n: usize| std::array::from_fn(|a| if n >> a & 1 == 0 { lower[a] } else { upper[a] });
        blocks.extend((0..1 << D).map(corner));
    }
    blocks.sort_unstable_by(|a: &[i32; D], b| a.iter().rev().cmp(b.iter().rev()));
    blocks.dedup();
    blocks
}

impl<const D: usize> World<D> {
    pub fn new(
        cells: [i32; D],
        kind: KernelKind,
        bodies: Vec<Body<D>>,
        sheets: Vec<Sheet<D>>,
        friction: Friction,
        substeps: usize,
    ) -> Self {
        let kernel = Kernel::new(kind, 0.25);
        let fields = bodies.iter().map(|b| b.field).max().unwrap() + 1;
        let contact = contact(kernel, &bodies, &sheets, friction, SheetContact::Nodes);
        let grid = Grid::new(Vector::ZERO, 1.0, cells, fields);
        let (gravity, flip_loss, work) = (Vector::ZERO, 0.0, 0.0);
        let start = bodies.iter().map(|body| body.particles.position.clone()).collect();
        let moved = vec![Vector::ZERO; bodies.len()];
        Self {
            grid,
            kernel,
            bodies,
            sheets,
            contact,
            substeps,
            passes: 1,
            friction,
            rigid: false,
            fixed: Vec::new(),
            gravity,
            flip_loss,
            work,
            start,
            moved,
        }
    }

    /// The same with sheets and bodies meeting at `place`.
    pub fn meeting_at(mut self, place: SheetContact) -> Self {
        let friction = self.friction;
        self.contact = contact(self.kernel, &self.bodies, &self.sheets, friction, place);
        self
    }

    pub fn totals(&self) -> Totals<D> {
        let (mut momentum, mut kinetic) = (Vector::ZERO, 0.0);
        let mut add = |mass: f64, velocity: Vector<D>| {
            momentum += velocity * mass;
            kinetic += 0.5 * mass * velocity.norm_squared();
        };
        for body in &self.bodies {
            let p = &body.particles;
            p.mass.iter().zip(&p.velocity).for_each(|(&m, &v)| add(m, v));
        }
        for sheet in &self.sheets {
            sheet.mass.iter().zip(&sheet.velocity).for_each(|(&m, &v)| add(m, v));
        }
        Totals { momentum, kinetic }
    }

    fn nodal_kinetic(&self) -> f64 {
        let nodes = self.grid.fields.iter().flat_map(|field| &field.nodes);
        nodes.filter(|n| n.mass > 0.0).map(|n| 0.5 * n.momentum.norm_squared() / n.mass).sum()
    }

    fn particle_kinetic(&self) -> f64 {
        let of = |body: &Body<D>| -> f64 {
            let p = &body.particles;
            p.mass.iter().zip(&p.velocity).map(|(m, v)| 0.5 * m * v.norm_squared()).sum()
        };
        self.bodies.iter().map(of).sum()
    }

    fn scatter(&mut self, dt: f64) -> f64 {
        let positions = self.bodies.iter().flat_map(|body| body.particles.position.iter().copied());
        self.grid.set_blocks(blocks_around(&self.grid, self.kernel, positions));
        for body in &self.bodies {
            let p = &body.particles;
            let mut field = std::mem::take(&mut self.grid.fields[body.field].nodes);
            for i in 0..p.len() {
                self.kernel.for_each(&self.grid, p.position[i], |node, weight, _| {
                    field[node].mass += weight * p.mass[i];
                    field[node].momentum += p.velocity[i] * (weight * p.mass[i]);
                });
            }
            self.grid.fields[body.field].nodes = field;
        }
        let before = self.nodal_kinetic();
        for node in self.grid.fields.iter_mut().flat_map(|field| &mut field.nodes) {
            node.force = self.gravity * node.mass;
            node.momentum += node.force * dt;
        }
        before
    }

    fn gather(&mut self, dt: f64) {
        for body in &mut self.bodies {
            let nodes = &self.grid.fields[body.field].nodes;
            let p = &mut body.particles;
            for i in 0..p.position.len() {
                let (mut change, mut velocity) = (Vector::ZERO, Vector::ZERO);
                self.kernel.for_each(&self.grid, p.position[i], |node, weight, _| {
                    if weight == 0.0 {
                        return;
                    }
                    change += nodes[node].force * (dt * weight / nodes[node].mass);
                    velocity += nodes[node].momentum * (weight / nodes[node].mass);
                });
                p.velocity[i] += change;
                p.position[i] += velocity * dt;
            }
        }
        self.stiffen(dt);
    }

    /// Undoes the deformation of rigid bodies, and the motion of fixed ones.
    fn stiffen(&mut self, dt: f64) {
        for (index, body) in self.bodies.iter_mut().enumerate() {
            let held = self.fixed.contains(&index);
            if !self.rigid && !held {
                continue;
            }
            let mean = if held { Vector::ZERO } else { mean_velocity(body) };
            let p = &mut body.particles;
            p.velocity.fill(mean);
            self.moved[index] += mean * dt;
            for (x, start) in p.position.iter_mut().zip(&self.start[index]) {
                *x = *start + self.moved[index];
            }
        }
    }

    /// Walls that nothing meets.
    fn open_walls(&self) -> Walls<D> {
        let walls = std::array::from_fn(|_| [Wall::default(), Wall::default()]);
        let setup = GridSetup { lower: self.grid.origin, cell: self.grid.cell, cells: self.grid.cells, walls };
        let lattice = FoldedStencil::new(Kernel::new(KernelKind::Quadratic, 0.25), &setup.walls);
        Walls::new(&setup, Vec::new(), self.grid.fields.len(), lattice)
    }

    /// One step of length `dt` [s].
    pub fn step(&mut self, dt: f64) {
        let before = self.scatter(dt);
        let surfaces: Vec<Surface<'_, D>> = self
            .sheets
            .iter()
            .map(|s| Surface { position: &s.position, velocity: &s.velocity, previous: &s.velocity, offset: &s.offset })
            .collect();
        let walls = self.open_walls();
        let step = Step { t: 0.0, dt, dt_before: dt, momentum_dt: dt };
        self.contact.begin_step((&mut self.grid, &walls), &self.bodies, &surfaces, dt);
        let part = dt / self.substeps as f64;
        for sub in 1..=self.substeps {
            let (elapsed, momentum_end) = ((sub - 1) as f64 * part, sub as f64 * part);
            let at = SubStep { step: &step, elapsed, dt: part, momentum_end, momentum_dt: part };
            for (index, sheet) in self.sheets.iter_mut().enumerate() {
                let previous = sheet.velocity.clone();
                for (v, held) in sheet.velocity.iter_mut().zip(&sheet.held) {
                    *v += Vector::from_fn(|a| if held[a] { 0.0 } else { self.gravity[a] * part });
                }
                for pass in 0..self.passes {
                    let surface = Surface {
                        position: &sheet.position,
                        velocity: &sheet.velocity,
                        previous: &previous,
                        offset: &sheet.offset,
                    };
                    let forces = self.contact.resolve((index, pass), &surface, &walls, &at);
                    for (k, force) in forces.iter().enumerate() {
                        let free = Vector::from_fn(|a| if sheet.held[k][a] { 0.0 } else { force[a] });
                        sheet.velocity[k] += free * (part / sheet.mass[k]);
                    }
                }
                for k in 0..sheet.position.len() {
                    self.work += (self.gravity * (sheet.mass[k] * part)).dot((previous[k] + sheet.velocity[k]) * 0.5);
                    sheet.position[k] += sheet.velocity[k] * part;
                }
                let surface = Surface {
                    position: &sheet.position,
                    velocity: &sheet.velocity,
                    previous: &previous,
                    offset: &sheet.offset,
                };
                self.contact.conclude(index, &surface, &at);
            }
        }
        self.contact.finish_step(&mut self.grid);
        self.contact.account(&self.grid);
        for node in self.grid.fields.iter().flat_map(|field| &field.nodes).filter(|node| node.mass > 0.0) {
            let mean = (node.momentum - node.force * (0.5 * dt)) / node.mass;
            self.work += (self.gravity * (node.mass * dt)).dot(mean);
        }
        let nodal = self.nodal_kinetic() - before;
        let particles = self.particle_kinetic();
        self.gather(dt);
        self.flip_loss += nodal - (self.particle_kinetic() - particles);
    }
}
