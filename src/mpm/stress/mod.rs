//! Strain increments from the grid velocity, stresses, and what keeps them sound.
//!
//! ```text
//! L_p = Σ v_I ⊗ ∇N_Ip,   ΔJ_p = det(1 + Δt L_p)                    `strain`   Lian (62, 63)
//! σ_p ← law(σ_p, Δt L_p, ΔJ_p)                                     `update`   theory A.8, B
//! A q = Σ N_Ip (Σ V_p q_p N_Ip / Σ V_p N_Ip)                        `average`  the cure of locking, theory A.10
//! q_p = m_p Σ N_Ip h_I/m_I                                         `heat`     of what transfers dissipate, theory A.16
//! f_I = Σ V_p (p_p − p_a) ∇N_Ip                                    `ambient`  an atmosphere around gases, theory A.13
//! ```

pub(in crate::mpm) mod ambient;
pub(in crate::mpm) mod average;
pub(in crate::mpm) mod heat;
pub(in crate::mpm) mod strain;
pub(in crate::mpm) mod update;
