//! Equations of the fluid in elements that the surface of a solid cuts, coupled to the nodes of the solid (theory J.3).
//!
//! The fluid part of an element e is divided into simplices s between its nodes and its cut points c, whose velocity is
//! that of the solid's surface, v_c = Σ_a N_a v_a. The pressure keeps the functions of e, also those of nodes inside
//! the solid. Where an interface of two fluids cuts e, too, each s is divided again, into pieces t of one fluid:
//!
//! ```text
//! M_ij     = Σ_t ρ_t ∫_t N^s_i N^s_j,   μ = Σ_t V_t μ_t/V_s                      theory (G.30); of one fluid as of an element s
//! D_k,jβ   = V_s N^e_k(x_s) g^s_jβ                    x_s: centre of s;   rows p_k of e, columns v_j of s
//! C_kl     = τ Σ_t V_t/ρ_t g^e_k·g^e_l
//! R_k,jβ   = τ V_s/(d + 1) g^e_kβ                     with the consistent stabilisation, theory (F.27)
//! ```
//!
//! Rows of cut points go to the nodes of the solid with the same weights N_a: the fluid does on the surface the work
//! that the solid takes. What flows through the surface beside that between cut points is added to D, theory (J.9a)
//! (`trace/mod.rs`). The pressure of two fluids is enriched (`enriched.rs`).

use super::element::{CoupledElement, Unknown, VelocityMap, VertexVelocities};
use super::enriched::enrich;
use super::fluid_part::{FluidPart, PartGeometry, masses, parts};
use super::trace::TracePoint;
use super::walls::part_facets;
use crate::math::{Tensor, Vector};
use crate::mesh::Mesh;
use crate::pfem2::cut_element::{Enrichment, Medium, SubSimplex, at_corners, surface_tension};
use crate::pfem2::element::{Equations, Stabilisation};
use crate::pfem2::solid::cut::{CutBySolid, CutPoint};

/// A cut element, its points of the surface, and all cut points.
pub struct CutParts<'a, const D: usize, const N: usize> {
    /// The element.
    pub cut: &'a CutBySolid<N>,
    /// Points of the surface in it.
    pub trace: &'a [TracePoint<D, N>],
    /// Cut points of the mesh.
    pub points: &'a [CutPoint<D>],
}

impl<const D: usize> VertexVelocities<D> {
    /// Σ v̂ over the vertices of a part [m/s].
    fn sum_of_hats<const N: usize>(&self, part: &PartGeometry<D, N>) -> Vector<D> {
        part.vertices.iter().map(|&vertex| self.hats[vertex]).fold(Vector::ZERO, |sum, hat| sum + hat)
    }
}

impl<const D: usize, const N: usize> CoupledElement<D, N> {
    /// Equations of a cut element; `velocity_hat`: v̂ of all nodes of solids [m/s].
    pub fn new(
        mesh: &Mesh<D, N>,
        &CutParts { cut, trace, points }: &CutParts<'_, D, N>,
        fluid: &FluidPart<D, N>,
        equations: &Equations,
        velocity_hat: &[Vector<D>],
    ) -> Self {
        let own: Vec<&CutPoint<D>> = cut.points.iter().map(|&point| &points[point as usize]).collect();
        let mut element = Self::empty(cut.element, &own, trace);
        let maps = element.velocity_maps(&cut.nodes, &own);
        let of = |unknown: Unknown| match unknown {
            Unknown::Node(i) => fluid.drive.convected[i],
            Unknown::Solid(a) => velocity_hat[element.solid[a] as usize],
        };
        let hat = |vertex: &VelocityMap<D>| vertex.iter().map(|&(unknown, p)| p.apply(of(unknown))).sum();
        let hats: Vec<Vector<D>> = maps.iter().map(hat).collect();
        let positions = own.iter().map(|point| point.position).collect();
        let velocities = VertexVelocities { maps, hats, positions };
        let (parent, corners) = (mesh.simplex(cut.element as usize), mesh.corners(cut.element as usize));
        element.content.tau = fluid.tau;
        let parts = parts(mesh, cut, &own, &fluid.level);
        for part in &parts {
            element.count(parent.volume, part, fluid);
            element.add(&parent.gradient, part, fluid, equations, &velocities);
            element.pull(mesh, part, fluid, &velocities);
            element.add_openings(part, fluid, &corners, &velocities);
        }
        match fluid.enrichment {
            Enrichment::None => {
                element.add_trace(trace, &velocities.maps);
                element.take_sides(cut, fluid, &corners);
            }
            _ => enrich(&mut element, &parent.gradient, &parts, fluid, equations, &velocities),
        }
        element
    }

    /// Adds what a part holds; `volume` of the element [m³].
    fn count(&mut self, volume: f64, part: &PartGeometry<D, N>, fluid: &FluidPart<D, N>) {
        /// Part of the volume of an element that ties no pressure.
        const ROUND_OFF: f64 = 1e-10;
        for piece in &part.pieces {
            let (own, Medium { density, viscosity }) =
                (part.simplex.volume * piece.volume_fraction, fluid.medium(piece));
            let center = part.at(&piece.center);
            (0..N).for_each(|k| self.content.mass[k] += own * density * center[k]);
            let corners = part.vertices.iter().zip(&piece.center);
            corners.for_each(|(&vertex, weight)| self.vertex_mass[vertex] += own * density * weight);
            self.content.viscosity += own / volume * viscosity;
            self.content.volume_over_density += own / density;
            for (tied, phi) in self.tied.iter_mut().zip(&fluid.level) {
                let acts = fluid.enrichment == Enrichment::None || (*phi < 0.0) == piece.negative;
                *tied |= acts && own > ROUND_OFF * volume;
            }
        }
    }

    /// Adds the surface tension of the interface in a part (theory (G.20)).
    fn pull(
        &mut self,
        mesh: &Mesh<D, N>,
        part: &PartGeometry<D, N>,
        fluid: &FluidPart<D, N>,
        velocities: &VertexVelocities<D>,
    ) {
        if fluid.tension == 0.0 || part.pieces.len() < 2 {
            return;
        }
        let corners = mesh.corners(self.element as usize);
        let x = part.shapes.map(|shape| shape.iter().zip(&corners).map(|(&n, &x)| x * n).sum());
        let level = at_corners(&part.shapes, &fluid.level);
        let forces = surface_tension::forces(&level, &x, &part.simplex, fluid.tension, 0);
        part.vertices.iter().zip(forces).for_each(|(&vertex, force)| self.add_load(&velocities.maps[vertex], force));
        self.energy += fluid.tension * surface_tension::area(&level, &x);
    }

    /// Adds the equations of a part.
    fn add(
        &mut self,
        parent: &[Vector<D>; N],
        part: &PartGeometry<D, N>,
        fluid: &FluidPart<D, N>,
        equations: &Equations,
        velocities: &VertexVelocities<D>,
    ) {
        let residual = match equations.stabilisation {
            Stabilisation::ConsistentPspg | Stabilisation::Dynamic => {
                fluid.tau / equations.delta * part.simplex.volume / N as f64
            }
            Stabilisation::Pspg | Stabilisation::Oss => 0.0,
        };
        self.add_momentum(part, fluid, equations, velocities);
        self.add_continuity(parent, part, residual, velocities);
        self.add_walls(part, fluid, velocities);
        self.add_stabilisation(parent, part, fluid, velocities.sum_of_hats(part) * residual);
    }

    /// Adds inertia, viscosity and body force of a part to the rows of its velocities.
    fn add_momentum(
        &mut self,
        part: &PartGeometry<D, N>,
        fluid: &FluidPart<D, N>,
        equations: &Equations,
        VertexVelocities { maps, hats, .. }: &VertexVelocities<D>,
    ) {
        let (g, volume, delta) = (&part.simplex.gradient, part.simplex.volume, equations.delta);
        let force = fluid.drive.force.iter().copied().sum::<Vector<D>>() / N as f64;
        let stiffness = part.mean(|piece| fluid.medium(piece).viscosity) * volume;
        let masses = masses(equations.mass, part, fluid);
        for i in 0..N {
            let row = &maps[part.vertices[i]];
            let mut load = Vector::ZERO;
            for j in 0..N {
                let mass = masses[i][j];
                load += (hats[part.vertices[j]] / delta + force) * mass;
                let both = g[i].dot(g[j]);
                let block = Tensor::from_fn(|r, s| {
                    let inertia = if r == s { stiffness * both + mass / delta } else { 0.0 };
                    inertia + stiffness * g[i][s] * g[j][r]
                });
                self.add_velocities(row, &maps[part.vertices[j]], &block);
            }
            self.add_load(row, load);
        }
    }

    /// Adds the columns of pressures in the rows of the velocities of a part, and those of velocities in the rows
    /// of pressures: −Dᵀ and −(D + R/Δ), theory (J.7), (J.9); `residual` is τ V_s/(d + 1)/Δ.
    fn add_continuity(
        &mut self,
        parent: &[Vector<D>; N],
        part: &PartGeometry<D, N>,
        residual: f64,
        velocities: &VertexVelocities<D>,
    ) {
        let (g, volume, center) = (&part.simplex.gradient, part.simplex.volume, part.at(&[1.0 / N as f64; N]));
        for (gradient, &vertex) in g.iter().zip(&part.vertices) {
            for k in 0..N {
                let pressure = *gradient * -(volume * center[k]);
                let row = &velocities.maps[vertex];
                self.add_pressure(row, k, pressure, pressure - parent[k] * residual);
            }
        }
    }

    /// Adds the walls at which the surface ends (theory (J.9c)).
    fn add_walls(&mut self, part: &PartGeometry<D, N>, fluid: &FluidPart<D, N>, velocities: &VertexVelocities<D>) {
        for facet in part_facets(part, fluid.held) {
            for (vertex, wall) in facet.wall_areas(part, |vertex| velocities.positions[vertex - N]) {
                for (k, &area) in wall.area.iter().enumerate() {
                    self.add_pressure(&velocities.maps[vertex], k, area, area);
                }
                self.on_walls.push(wall);
            }
        }
    }

    /// Adds −C, theory (J.8), and what stands with it on the right: the sources of the part, and `hats`, the term
    /// of v̂.
    fn add_stabilisation(
        &mut self,
        parent: &[Vector<D>; N],
        part: &PartGeometry<D, N>,
        fluid: &FluidPart<D, N>,
        hats: Vector<D>,
    ) {
        let (tau, volume) = (fluid.tau, part.simplex.volume);
        let of = |piece: &SubSimplex<N>| fluid.source(piece) * (tau * volume * piece.volume_fraction);
        let source = part.pieces.iter().map(of).sum::<Vector<D>>() + hats;
        let over_density = part.mean(|piece| 1.0 / fluid.medium(piece).density);
        for k in 0..N {
            self.loads[k][D] -= parent[k].dot(source);
            for l in 0..N {
                self.blocks[k][l][D][D] -= tau * volume * over_density * parent[k].dot(parent[l]);
            }
        }
    }

    /// Adds the points of the surface, where the solid moves otherwise than the boundary of the fluid part: their flux
    /// to the rows of pressures, and the transpose to those of velocities. The velocity with which the fluid glides
    /// along chords is no part of v_h: an even pressure doesn't push it through them, but would along a surface from
    /// which they turn away.
    fn add_trace(&mut self, trace: &[TracePoint<D, N>], maps: &[VelocityMap<D>]) {
        // Σ φ_c N_k n dA of each cut point, since many points have the same.
        let mut chords = vec![[Vector::ZERO; N]; maps.len() - N];
        for point in trace {
            for &(c, weight) in &point.chord {
                (0..N).for_each(|k| chords[c][k] += point.area * (point.shape[k] * weight));
            }
            for &(a, weight) in &point.weights {
                let Ok(place) = self.solid.binary_search(&a) else { continue };
                for (k, shape) in point.shape.iter().enumerate() {
                    for r in 0..D {
                        let flux = point.area[r] * (shape * weight);
                        self.to_solid[place][k][r][D] += flux;
                        self.to_fluid[place][k][D][r] += flux;
                    }
                }
            }
        }
        for (vertex, chord) in maps[N..].iter().zip(chords) {
            let own = vertex.iter().copied().filter(|(unknown, _)| matches!(unknown, Unknown::Solid(_))).collect();
            (0..N).filter(|k| chord[*k] != Vector::ZERO).for_each(|k| self.add_pressure(&own, k, -chord[k], -chord[k]));
        }
    }
}
