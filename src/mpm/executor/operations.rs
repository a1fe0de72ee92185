//! The operations of a visit, a chunk of particles at a time; `perform` of [`super::plain`] has the same for one
//! particle.

use super::visit::{MoveBy, Operation};
use crate::material::PointLaw;
use crate::mpm::motion::{Landing, Transport, keep_velocity};
use crate::mpm::particles::{Body, Summary};
use crate::mpm::spacing::{set_shift_factors, set_shifts};
use crate::mpm::stress::average::average_pressure;
use crate::mpm::stress::heat::{warm, warm_by_filter};
use crate::mpm::stress::strain::{
    Positions, blend_volume_ratio, blend_volume_ratio_and_gradient, measure, refer_to_start,
};
use crate::mpm::stress::update::update_stress;
use crate::mpm::transfer::{Chunk, GatherFields};
use crate::mpm::{Dissipation, Grid};

/// The numbers of a step that operations need.
#[derive(Debug, Clone, Copy)]
pub(in crate::mpm) struct OperationParameters<const D: usize> {
    /// Step of the momentum [s].
    pub momentum_dt: f64,
    /// PIC fraction of the velocities.
    pub pic_fraction: f64,
    /// Increment over which the stresses are updated, or the time for which particles are shifted [s].
    pub strain_dt: f64,
    /// Weight β of averages over the nodes.
    pub blend: f64,
    /// The fate of the energy that the transfer dissipates.
    pub dissipation: Dissipation,
    /// The end of the step.
    pub landing: Landing<D>,
}

/// The operations of a visit on the particles of a body.
#[derive(Debug, Clone, Copy)]
pub(in crate::mpm) struct Operations<'a, const D: usize> {
    /// The operations, in their order.
    pub list: &'a [Operation],
    /// The motion of the particles from that of the nodes.
    pub transport: Transport,
    /// Increment over which the stresses are updated [s].
    pub strain_dt: f64,
    /// Weight β of averages over the nodes.
    pub blend: f64,
    /// Cell size [m].
    pub cell: f64,
    /// The end of the step.
    pub landing: Landing<D>,
    /// True if the nodes hand heat to the body.
    pub heated: bool,
    /// True if the particles move by the velocity that strains them.
    pub strain_moves: bool,
}

impl<'a, const D: usize> Operations<'a, D> {
    /// Operations of `list` for a body.
    pub fn new(list: &'a [Operation], parameters: &OperationParameters<D>, grid: &Grid<D>, body: &Body<D>) -> Self {
        let &OperationParameters { momentum_dt, pic_fraction, strain_dt, blend, dissipation, landing } = parameters;
        let solid = body.particles.affine.is_empty() && body.law.keeps_shape();
        Self {
            list,
            transport: Transport::new(momentum_dt, pic_fraction, body.kernel, grid.cell),
            strain_dt,
            blend,
            cell: grid.cell,
            landing,
            heated: list.contains(&Operation::Heat) && dissipation.warms(body),
            strain_moves: list.contains(&Operation::Land(MoveBy::StrainOfSolids)) && solid,
        }
    }

    /// The sums that they need, of particles with or without an affine matrix. Laws that don't read the velocity
    /// gradient need no second look at it.
    pub fn fields(&self, law: &dyn PointLaw, affine: bool) -> GatherFields {
        let has = |operation| self.list.contains(&operation);
        if has(Operation::Velocity) {
            return self.transport.fields(affine, has(Operation::VolumeRatio(Positions::Start)));
        }
        let averaged = has(Operation::AverageVolumeRatio);
        match self.list {
            [Operation::MidstepVelocity, ..] => GatherFields::Motion,
            [Operation::TakeVelocity] => GatherFields::Motion,
            [Operation::AveragePressure, ..] => GatherFields::Scalar,
            _ if averaged && !law.needs_gradient() && !self.strain_moves => GatherFields::Scalar,
            _ => GatherFields::Gradient,
        }
    }

    /// Performs them on a chunk, unless a particle is turned inside out.
    pub fn perform(&self, law: &dyn PointLaw, chunk: &mut Chunk<'_, D>) -> Summary {
        let (mut summary, dt) = (Summary::default(), self.strain_dt);
        for operation in self.list {
            match operation {
                Operation::MidstepVelocity => keep_velocity(chunk.particles.mean, chunk.rows),
                Operation::Rate => keep_velocity(chunk.particles.rate, chunk.rows),
                Operation::Velocity => self.transport.carry(chunk),
                Operation::TakeVelocity => keep_velocity(chunk.particles.velocity, chunk.rows),
                Operation::FilterHeat { stage, order } => summary.heat += warm_by_filter(chunk, *stage, *order),
                Operation::VolumeRatio(positions) => measure(chunk, dt, *positions),
                Operation::Heat if self.heated => summary.heat += warm(chunk),
                Operation::ReferToStart if law.needs_gradient() => refer_to_start(chunk, dt),
                Operation::AverageVolumeRatio if law.needs_gradient() => {
                    blend_volume_ratio_and_gradient(chunk, dt, self.blend);
                }
                Operation::AverageVolumeRatio => blend_volume_ratio(chunk, self.blend),
                Operation::Stress if !update_stress(law, chunk, dt, self.cell) => return Summary::inverted(),
                Operation::AveragePressure => average_pressure(chunk, self.blend),
                Operation::ShiftFactor => set_shift_factors(chunk, dt),
                Operation::Shift => summary.volume_work += set_shifts(chunk, self.cell, law.reference_sound_speed()),
                Operation::Land(by) => {
                    let gathered = *by == MoveBy::Gathered || self.strain_moves;
                    let (particles, visits) = (&mut chunk.particles, chunk.visits);
                    let landed = if gathered {
                        self.landing.land_by(particles, &*chunk.rows)
                    } else {
                        self.landing.land(particles)
                    };
                    summary = Summary { heat: summary.heat, visits, ..landed };
                }
                Operation::Heat | Operation::ReferToStart | Operation::Stress => {}
            }
        }
        summary
    }
}
