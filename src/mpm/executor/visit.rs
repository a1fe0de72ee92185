//! Sweeps over the particles as data: nodal fields that are read, operations on the particles, nodal fields to which
//! they scatter.

use crate::mpm::stress::strain::Positions;
use crate::mpm::transfer::ScatterContent;

/// One sweep over the particles of a body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::mpm) enum Visit {
    /// Particles → nodes.
    Scatter(ScatterContent, Onto),
    /// Nodes → particles: the operations, in their order.
    Gather(Read, Vec<Operation>),
    /// Nodes → particles → nodes: the particles are scattered in the same sweep as the operations have left them.
    Relay(Read, Vec<Operation>, ScatterContent, Onto),
    /// Particles alone: x_p ← x_p + Δt ẋ_p with the rates that were kept.
    Land,
}

/// The nodal fields that a gather reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::mpm) enum Read {
    /// v̂_I = ½ (v_I⁻ + v_I⁺).
    MidstepVelocity,
    /// v_I⁺ and a_I.
    Motion,
    /// The velocity that strains the bodies, and the heat that nodes hand over.
    Strain,
    /// Averages over the nodes of what was summed up last, and the velocity that strains the bodies.
    Averages,
}

/// The nodal field that a scatter adds to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::mpm) enum Onto {
    /// (m, p, f).
    Nodes,
    /// The momentum of the particles' new velocities, which becomes the re-mapped velocity ṽ_I.
    Velocity,
    /// Σ V N and Σ V q N, from zero.
    Sums,
}

/// An operation on the particles of a gather.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::mpm) enum Operation {
    /// Keeps Σ N_Ip v̂_I, on which external forces work; of bodies without them nothing is gathered.
    MidstepVelocity,
    /// ẋ_p = Σ N_Ip v_I⁺, Lian (19), kept for the end of the step.
    Rate,
    /// v_p, and C_p of APIC, Lian (65).
    Velocity,
    /// v_p = Σ N_Ip w_I of the nodal velocity that is read, in the noise filter (theory A.7).
    TakeVelocity,
    /// The heat of what a stage of the noise filter of this order takes (theory A.16); after
    /// [`Operation::TakeVelocity`].
    FilterHeat {
        /// Stage j, from 1.
        stage: u32,
        /// Order k.
        order: u32,
    },
    /// ΔJ_p from the velocity gradient over these positions, Lian (62).
    VolumeRatio(Positions),
    /// e_p ← e_p + m_p Σ N_Ip h_I/m_I: the heat of what transfers dissipate (theory A.16).
    Heat,
    /// Refers the velocity gradient to the positions at the start of the increment.
    ReferToStart,
    /// Blends ΔJ_p, and the velocity gradient, with the average over the nodes (theory A.10).
    AverageVolumeRatio,
    /// σ_p, p_p and e_p by the law (theory A.8).
    Stress,
    /// p̃ − p, the difference between the averaged pressure, which makes forces, and that of the particle
    /// (theory A.10).
    AveragePressure,
    /// The shift factors of a liquid, from its velocity gradient (theory A.11).
    ShiftFactor,
    /// The shifts of a liquid by these factors, and what is taken from its volumes, from the excess of what particles
    /// fill: a scalar, and the first component of a velocity.
    Shift,
    /// x_p ← x_p + Δt ẋ_p, Lian (19), and the sums of the ledger.
    Land(MoveBy),
}

/// The velocity that particles move by (theory A.9).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::mpm) enum MoveBy {
    /// v⁺, whose rate was kept ([`Operation::Rate`]).
    Kept,
    /// v⁺, which this visit reads.
    Gathered,
    /// Solids by the velocity ṽ that strains them, which this visit reads; other bodies, and all with APIC, by v⁺.
    StrainOfSolids,
}
