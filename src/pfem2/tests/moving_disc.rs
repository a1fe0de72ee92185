//! A disc that turns to and fro in a viscous fluid, rigid or elastic, while both are carried through the mesh: errors
//! against exact solutions of finite amplitude, and their orders in the size of elements and of steps.
//!
//! ```text
//! all moves with V(t) = a ω e cos ωt, and about the centre X = a e sin ωt, x' = x − X, along circles: v = V + u_θ e_θ
//! fluid    u_θ = Re [(C K₁(κr) + D I₁(κr)) e^{iωt}],   κ = √(iω/ν),   ∂p/∂r = ρ u_θ²/r − ρ V'·e_r
//! elastic  θ = Θ + φ(r, t),   u_θ = r φ_t = A J₁(kr) cos ωt,   k = ω √(ρ/G),   γ = r φ_r = −(A k/ω) J₂(kr) sin ωt
//!          σ_rθ = G γ,   σ_θθ − σ_rr = G γ²,   ∂σ_rr/∂r = G γ²/r − ρ u_θ²/r + ρ V'·e_r
//!          neo-Hookean and incompressible; as fast as the fluid at r = b, and with the same traction:
//!          C K₁(κb) + D I₁(κb) = A J₁(kb),   μ κ (D I₂(κb) − C K₂(κb)) = i G (A k/ω) J₂(kb)
//! rigid    C K₁(κb) = Ω b,   D = 0
//! ```
//!
//! A shear along circles leaves volumes, whatever its size, so that pressures do nothing but balance the radii: the
//! equation along θ is that of linear waves. The disc is as heavy as the fluid, and a pressure −ρ V'·x' carries both.
//! The mesh ends amid the fluid, with the velocity of the solution.

use super::complex::{Complex, over, plus, scaled, times};
use super::*;
use crate::material::{Elastic, NeoHookean, Rigid};
use crate::pfem2::Pfem2;
use crate::pfem2::solid::setup::{PrescribedMotion, SolidSetup};
use crate::pfem2::solid::structure::Structure;
use crate::pfem2::solid::surface::tests::disc as solid_disc;
use crate::simulation::Solver;
use std::f64::consts::{PI, TAU};

/// ω [1/s], and ρ of both [kg/m³].
const OMEGA: f64 = TAU;
const DENSITY: f64 = 1000.0;

/// b, and half of the side of the box around the disc [m].
const RADIUS: f64 = 0.45;
const HALF: f64 = 0.75;

/// a [m]: as far as five of the finest elements. And e.
const WAY: f64 = 0.1;
const HEADING: Vector<2> = Vector([0.8, 0.6]);

/// √(2ν/ω), to which depth the fluid follows [m].
const DEPTH: f64 = 0.4;

/// Speed of the surface of the rigid disc, Ω b [m/s].
const SPEED: f64 = 0.5;

/// kb of the elastic disc, and the largest γ.
const WAVE: f64 = 2.0;
const STRAIN: f64 = 0.2;

/// Time at which errors are taken [s]: neither velocity nor strain are small there.
const END: f64 = 0.375;

/// Units of velocities [m/s], pressures and stresses [Pa].
const VELOCITY: f64 = WAY * OMEGA;
const PRESSURE: f64 = DENSITY * OMEGA * VELOCITY * RADIUS;

/// Re [amplitude e^{iωt}].
fn at(amplitude: Complex, t: f64) -> f64 {
    amplitude[0] * (OMEGA * t).cos() - amplitude[1] * (OMEGA * t).sin()
}

/// I_n(z), Abramowitz & Stegun (9.6.10).
fn bessel_i(n: u32, z: Complex) -> Complex {
    let half = scaled(z, 0.5);
    let first = (1..=n).fold([1.0, 0.0], |term, k| scaled(times(term, half), 1.0 / f64::from(k)));
    let next = |term: &Complex, k: u32| scaled(times(*term, times(half, half)), 1.0 / f64::from(k * (k + n)));
    let terms = (1..60).scan(first, |term, k| {
        *term = next(term, k);
        Some(*term)
    });
    terms.fold(first, plus)
}

/// K₁(z), Abramowitz & Stegun (9.6.11).
fn bessel_k1(z: Complex) -> Complex {
    const EULER: f64 = 0.577_215_664_901_532_9;
    let half = scaled(z, 0.5);
    let (mut term, mut digamma) = (half, 1.0 - 2.0 * EULER);
    let mut sum = scaled(term, digamma);
    for k in (1..60).map(f64::from) {
        term = scaled(times(term, times(half, half)), 1.0 / (k * (k + 1.0)));
        digamma += 1.0 / k + 1.0 / (k + 1.0);
        sum = plus(sum, scaled(term, digamma));
    }
    let log = [half[0].hypot(half[1]).ln(), half[1].atan2(half[0])];
    plus(plus(over([1.0, 0.0], z), times(log, bessel_i(1, z))), scaled(sum, -0.5))
}

/// J₁(x) and J₂(x): I_n(ix) = iⁿ J_n(x).
fn bessel_j(x: f64) -> [f64; 2] {
    [bessel_i(1, [0.0, x])[1], -bessel_i(2, [0.0, x])[0]]
}

/// An exact solution.
#[derive(Debug, Clone, Copy)]
struct Swirl {
    /// C and D [m/s].
    fluid: [Complex; 2],
    /// A [m/s] and k [1/m] of an elastic disc.
    elastic: Option<[f64; 2]>,
}

impl Swirl {
    const VISCOSITY: f64 = 0.5 * DENSITY * OMEGA * DEPTH * DEPTH;
    const KAPPA: Complex = [1.0 / DEPTH; 2];

    /// I₁, I₂, K₁, K₂ at κb.
    fn bessel_at_surface() -> [Complex; 4] {
        let z = scaled(Self::KAPPA, RADIUS);
        let [i1, i2, k1] = [bessel_i(1, z), bessel_i(2, z), bessel_k1(z)];
        // I₁ K₂ + I₂ K₁ = 1/z
        let k2 = over(plus(over([1.0, 0.0], z), scaled(times(k1, i2), -1.0)), i1);
        [i1, i2, k1, k2]
    }

    fn rigid() -> Self {
        let [_, _, k1, _] = Self::bessel_at_surface();
        Self { fluid: [over([SPEED, 0.0], k1), [0.0; 2]], elastic: None }
    }

    fn elastic() -> Self {
        let (k, [j1, j2]) = (WAVE / RADIUS, bessel_j(WAVE));
        let a = STRAIN * OMEGA / (k * j2);
        let [i1, i2, k1, k2] = Self::bessel_at_surface();
        let shear = DENSITY * OMEGA * OMEGA / (k * k);
        let slope = over([0.0, shear * STRAIN], scaled(Self::KAPPA, Self::VISCOSITY));
        // The determinant is 1/κb.
        let (z, speed) = (scaled(Self::KAPPA, RADIUS), [a * j1, 0.0]);
        let c = times(z, plus(times(speed, i2), scaled(times(slope, i1), -1.0)));
        let d = times(z, plus(times(k1, slope), times(k2, speed)));
        Self { fluid: [c, d], elastic: Some([a, k]) }
    }

    /// G [Pa].
    fn shear(&self) -> f64 {
        self.elastic.map_or(0.0, |[_, k]| DENSITY * OMEGA * OMEGA / (k * k))
    }

    /// u_θ [m/s], a complex amplitude.
    fn amplitude(&self, r: f64) -> Complex {
        match self.elastic {
            Some([a, k]) if r < RADIUS => [a * bessel_j(k * r)[0], 0.0],
            None if r < RADIUS => [SPEED * r / RADIUS, 0.0],
            _ => {
                let z = scaled(Self::KAPPA, r);
                plus(times(self.fluid[0], bessel_k1(z)), times(self.fluid[1], bessel_i(1, z)))
            }
        }
    }

    fn velocity(&self, x: Vector<2>, t: f64) -> Vector<2> {
        let away = x - centre(t);
        let r = away.norm().max(1e-9);
        HEADING * (VELOCITY * (OMEGA * t).cos()) + Vector([-away[1], away[0]]) * (at(self.amplitude(r), t) / r)
    }

    /// The pressure less that of the surface, −p_b − ρ V'·x' [Pa].
    fn pressure(&self, x: Vector<2>, t: f64) -> f64 {
        let away = x - centre(t);
        let swirl = |r: f64| DENSITY * at(self.amplitude(r), t).powi(2) / r;
        integral(swirl, RADIUS, away.norm()) - DENSITY * acceleration(t).dot(away)
    }

    /// Traction of the fluid on the surface, along θ [Pa].
    fn drag(&self, t: f64) -> f64 {
        let [_, i2, _, k2] = Self::bessel_at_surface();
        let slope = plus(times(self.fluid[1], i2), scaled(times(self.fluid[0], k2), -1.0));
        at(times(scaled(Self::KAPPA, Self::VISCOSITY), slope), t)
    }

    /// φ and γ of the elastic disc.
    fn strain(&self, r: f64, t: f64) -> [f64; 2] {
        let Some([a, k]) = self.elastic else { return [0.0; 2] };
        let ([j1, j2], sin) = (bessel_j(k * r), (OMEGA * t).sin());
        [a * j1 / (OMEGA * r) * sin, -a * k / OMEGA * j2 * sin]
    }

    /// σ_rr less its mean on the surface, σ_θθ likewise, σ_rθ [Pa].
    fn stress(&self, away: Vector<2>, t: f64) -> [f64; 3] {
        let square = |r: f64| self.shear() * self.strain(r, t)[1].powi(2);
        let slope = |r: f64| (square(r) - DENSITY * at(self.amplitude(r), t).powi(2)) / r;
        let r = away.norm().max(1e-9);
        let radial = integral(slope, RADIUS, r) + DENSITY * acceleration(t).dot(away);
        [radial, radial + square(r), self.shear() * self.strain(r, t)[1]]
    }

    /// The velocity as formulas, away from the disc: u_θ/r by the polynomial in r² through its values at points of
    /// Chebyshev.
    fn formulas(&self) -> [Signal; 2] {
        const POINTS: usize = 9;
        let [low, high] = [(HALF - WAY).powi(2), 2.0 * (HALF + WAY).powi(2)];
        let place = |k: usize| 0.5 * (low + high) + 0.5 * (high - low) * (PI * (k as f64 + 0.5) / POINTS as f64).cos();
        let points: [f64; POINTS] = std::array::from_fn(place);
        let mut newton = points.map(|q| scaled(self.amplitude(q.sqrt()), 1.0 / q.sqrt()));
        for level in 1..POINTS {
            for k in (level..POINTS).rev() {
                let difference = plus(newton[k], scaled(newton[k - 1], -1.0));
                newton[k] = scaled(difference, 1.0 / (points[k] - points[k - level]));
            }
        }
        let [x, y] = ["x", "y"].map(|axis| if axis == "x" { (axis, HEADING[0]) } else { (axis, HEADING[1]) });
        let [x, y] = [x, y].map(|(axis, e)| format!("({axis}-({:?})*sin({OMEGA:?}*t))", WAY * e));
        let term = |k: usize| format!("({:?})*cos({OMEGA:?}*t)-({:?})*sin({OMEGA:?}*t)", newton[k][0], newton[k][1]);
        let more = |rate: String, k: usize| format!("{}+({x}^2+{y}^2-{:?})*({rate})", term(k), points[k]);
        let rate = (0..POINTS - 1).rev().fold(term(POINTS - 1), more);
        let [u, v] = HEADING.0.map(|e| format!("({:?})*cos({OMEGA:?}*t)", VELOCITY * e));
        [formula(&format!("{u}-{y}*({rate})")), formula(&format!("{v}+{x}*({rate})"))]
    }

    /// The disc at the start, of five blocks of `count` × `count` elements.
    fn disc(&self, count: usize) -> SolidSetup<2> {
        let mut mesh = solid_disc(count);
        mesh.nodes.iter_mut().for_each(|x| *x *= RADIUS);
        let velocity = mesh.nodes.iter().map(|x| self.velocity(*x, 0.0)).collect();
        if self.elastic.is_some() {
            let law = NeoHookean { elastic: Elastic::new(DENSITY, 3.0 * self.shear(), 0.5) };
            return SolidSetup { velocity, ..SolidSetup::free("disc", mesh, Box::new(law)) };
        }
        let swing = |size: f64| Some(formula(&format!("{size:?}*cos({OMEGA:?}*t)")));
        let [u, v] = HEADING.0.map(|e| swing(VELOCITY * e));
        let motion = PrescribedMotion { velocity: [u, v, None], spin: [None, None, swing(SPEED / RADIUS)] };
        SolidSetup { velocity, motion, ..SolidSetup::free("disc", mesh, Box::new(Rigid { density: DENSITY })) }
    }

    /// The disc in its fluid, with `cells` elements along the sides of the box.
    fn immersed(&self, cells: usize) -> Pfem2<2, 3> {
        let mesh = Mesh::<2, 3>::block(Vector::splat(-HALF), Vector::splat(HALF), [cells; 2]).unwrap();
        let mesh = shaken(&mesh, 2.0 * HALF / cells as f64);
        let sets = vec![set(&mesh, "around", Condition::Inlet(self.formulas()), |_| true)];
        let physics = physics(vec![fluid("oil", DENSITY, Self::VISCOSITY)], weightless());
        let oil = Physics { stabilisation: Stabilisation::Dynamic, ..physics };
        let mut setup = setup(mesh, sets, oil, |_| 0, |x| self.velocity(x, 0.0));
        setup.solids = Some(Structure::new(vec![self.disc(cells / 6)]).unwrap());
        setup.linear = SolverOptions { tolerance: 1e-10, ..SolverOptions::default() };
        Pfem2::new(setup)
    }

    /// The state at the end, after a number of steps.
    fn at_end(&self, cells: usize, steps: usize) -> Pfem2<2, 3> {
        let dt = END / steps as f64;
        let mut pfem = self.immersed(cells);
        pfem.begin(0.0, dt).unwrap();
        (0..steps).for_each(|k| pfem.step(k as f64 * dt, dt).unwrap());
        pfem
    }

    /// Errors of the velocity at nodes outside; of the pressure at those within an element of the surface, less its
    /// mean; of the force on the disc over that of a pressure of one unit, and of its moment likewise.
    fn errors_outside(&self, pfem: &Pfem2<2, 3>, cells: usize) -> [f64; 4] {
        let (distance, nodes) = (&pfem.system.immersed.as_ref().unwrap().cut.distance, pfem.system.mesh.nodes());
        let outside: Vec<usize> = (0..nodes.len()).filter(|&i| distance[i] > 0.0).collect();
        let off = outside.iter().map(|&i| (pfem.system.velocity[i] - self.velocity(nodes[i], END)).norm() / VELOCITY);
        let close = outside.iter().filter(|&&i| (nodes[i] - centre(END)).norm() < RADIUS + 2.0 * HALF / cells as f64);
        let pressure = close.map(|&i| (pfem.system.pressure[i] - self.pressure(nodes[i], END)) / PRESSURE);
        let solids = pfem.solids.as_ref().unwrap();
        let force = acceleration(END) * (DENSITY * PI * RADIUS * RADIUS);
        let places = solids.structure.positions(&solids.last.predicted);
        let arms = places.iter().map(|x| *x - centre(END)).zip(&solids.last.nodal);
        let moment = arms.map(|(x, f)| x[0] * f[1] - x[1] * f[0]).sum::<f64>();
        let lost = moment - TAU * RADIUS * RADIUS * self.drag(END);
        [
            root_mean_square(&off.collect::<Vec<_>>()),
            root_mean_square(&less_mean(&pressure.collect::<Vec<_>>())),
            (solids.last.forces.last[0] - force).norm() / (PRESSURE * RADIUS),
            lost.abs() / (PRESSURE * RADIUS * RADIUS),
        ]
    }

    /// Errors of the elastic disc: of its velocity, of its stress less the mean of the pressure, and of the traction of
    /// the fluid along r less its mean.
    fn errors_inside(&self, pfem: &Pfem2<2, 3>) -> [f64; 3] {
        let solids = pfem.solids.as_ref().unwrap();
        let (structure, mesh) = (&solids.structure, &solids.structure.setups()[0].mesh);
        let now = |x: &Vector<2>| turned(*x, self.strain(x.norm().max(1e-9), END)[0]);
        let away: Vec<Vector<2>> = mesh.nodes.iter().map(now).collect();
        let both = structure.state.velocity.iter().zip(&away);
        let velocity = both.map(|(v, x)| (*v - self.velocity(centre(END) + *x, END)).norm() / VELOCITY);
        let (mut mean, mut shear) = (Vec::new(), Vec::new());
        for (x, found) in away.iter().zip(structure.nodal_stresses(0)) {
            let [xx, yy, _, xy, ..] = found.stress.0;
            let (cos, sin) = x.normalized().map_or((1.0, 0.0), |e| (e[0] * e[0] - e[1] * e[1], 2.0 * e[0] * e[1]));
            let [rr, tt, rt] = self.stress(*x, END);
            mean.push((0.5 * (xx + yy) - 0.5 * (rr + tt)) / PRESSURE);
            let difference = 0.5 * (xx - yy) * cos + xy * sin - 0.5 * (rr - tt);
            shear.push(difference.hypot(xy * cos - 0.5 * (xx - yy) * sin - rt) / PRESSURE);
        }
        let stress = root_mean_square(&less_mean(&mean)).hypot(root_mean_square(&shear));
        let cut = structure.positions(&solids.last.predicted);
        let outline = &solids.outlines[0];
        let tractions = outline.tractions(mesh, &cut, &solids.last.nodal);
        let normal = outline.gather(&cut).into_iter().zip(tractions).map(|(x, traction)| {
            let e = (x - centre(END)) / RADIUS;
            (traction.dot(e) - DENSITY * RADIUS * acceleration(END).dot(e)) / PRESSURE
        });
        let traction = root_mean_square(&less_mean(&normal.collect::<Vec<_>>()));
        [root_mean_square(&velocity.collect::<Vec<_>>()), stress, traction]
    }
}

/// X [m].
fn centre(t: f64) -> Vector<2> {
    HEADING * (WAY * (OMEGA * t).sin())
}

/// V' [m/s²].
fn acceleration(t: f64) -> Vector<2> {
    HEADING * (-WAY * OMEGA * OMEGA * (OMEGA * t).sin())
}

fn turned(x: Vector<2>, angle: f64) -> Vector<2> {
    let (sin, cos) = angle.sin_cos();
    Vector([cos * x[0] - sin * x[1], sin * x[0] + cos * x[1]])
}

/// ∫ f dr by Simpson's rule.
fn integral(f: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    const PIECES: usize = 16;
    let piece = (to - from) / PIECES as f64;
    let at = |k: f64| f(from + k * piece);
    (0..PIECES).map(|k| k as f64).map(|k| (at(k) + 4.0 * at(k + 0.5) + at(k + 1.0)) * piece / 6.0).sum()
}

fn less_mean(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|value| value - mean).collect()
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

/// Mean order of errors of meshes with these numbers of elements.
fn order<const K: usize>(cells: &[usize], errors: &[[f64; K]]) -> [f64; K] {
    let last = errors.len() - 1;
    let finer = cells[last] as f64 / cells[0] as f64;
    std::array::from_fn(|k| (errors[0][k] / errors[last][k]).ln() / finer.ln())
}

/// Two fifths as many steps as elements along a side: a step moves the disc by a quarter of an element. The order of
/// the velocity rises with the number of elements, 1.67 and 1.85.
#[test]
fn the_flow_around_a_rigid_disc_that_moves_through_the_mesh_converges() {
    let (cells, exact) = ([20, 40, 80], Swirl::rigid());
    let errors = cells.map(|cells| exact.errors_outside(&exact.at_end(cells, cells * 2 / 5), cells));
    let [_, pressure, force, moment] = order(&cells, &errors);
    let [velocity, ..] = order(&cells[1..], &errors[1..]);
    assert!(velocity > 1.8 && pressure > 1.0 && force > 1.0 && moment > 1.0, "{errors:?}");
    assert!(errors[2][0] < 1e-3, "{errors:?}");
}

/// The same of the elastic disc, with its velocity, its stress and the traction that it takes, two thirds as many steps
/// as elements.
#[test]
fn an_elastic_disc_and_the_flow_around_it_converge() {
    let (cells, exact) = ([12, 24, 48], Swirl::elastic());
    let ends = cells.map(|cells| (cells, exact.at_end(cells, cells * 2 / 3)));
    let outside = ends.each_ref().map(|(cells, pfem)| exact.errors_outside(pfem, *cells));
    let inside = ends.each_ref().map(|(_, pfem)| exact.errors_inside(pfem));
    let ([flow, pressure, force, moment], [velocity, stress, traction]) =
        (order(&cells, &outside), order(&cells, &inside));
    assert!(flow > 1.8 && velocity > 1.8, "{outside:?} {inside:?}");
    assert!([pressure, force, moment, stress, traction].iter().all(|order| *order > 1.0), "{outside:?} {inside:?}");
    assert!(outside[2][0] < 2e-3 && inside[2].iter().all(|error| *error < 5e-3), "{outside:?} {inside:?}");
}

/// Differences between steps and half of them, on one mesh: of second order, down to a fifth of the error of the mesh
/// beside the rigid disc, a quarter of it beside the elastic one. Below that, sooner on coarser meshes, a part of first
/// order shows, the change of the error of the mesh with the step (theory J.7).
#[test]
fn a_step_is_of_second_order_beside_discs_that_move_through_the_mesh() {
    for (exact, cells, steps) in [(Swirl::rigid(), 40, [4, 8, 16, 32]), (Swirl::elastic(), 24, [8, 16, 32, 64])] {
        let ends = steps.map(|steps| exact.at_end(cells, steps));
        let distances = |i: usize| ends.iter().map(move |end| end.system.immersed.as_ref().unwrap().cut.distance[i]);
        let count = ends[0].system.velocity.len();
        let outside: Vec<usize> = (0..count).filter(|&i| distances(i).all(|distance| distance > 0.0)).collect();
        let change = |pair: &[Pfem2<2, 3>]| {
            let of = |&i: &usize| (pair[0].system.velocity[i] - pair[1].system.velocity[i]).norm() / VELOCITY;
            root_mean_square(&outside.iter().map(of).collect::<Vec<_>>())
        };
        let changes: Vec<[f64; 1]> = ends.windows(2).map(|pair| [change(pair)]).collect();
        let [velocity] = order(&steps[..3], &changes);
        assert!(velocity > 1.8, "{changes:?}");
    }
}
