//! Loads on the grains, in each of the forms of docs/equations-immersed.md, section 4.
//!
//! With `f` the force per unit density that the grain would exert on the fluid, m_f the mass of the
//! fluid it displaces and ρ the fluid's density, the message carries
//! ```text
//! izard-2014                           −ρ ρ_p / (ρ_p − ρ) ∫ f dV    as printed (Izard et al. 2014, eqs 5–6)
//! kempe-froehlich-2012                 −ρ ∫ f dV + ρ d/dt ∫ α u dV − m_f g
//! uhlmann-2005                         −ρ ∫ f dV + m_f dU/dt − m_f g
//! yu-shao-2007, yu-shao-fixed-point    ρ G / dt − m_f g
//! ```
//! so that `m_p dU/dt = m_p g + F` in every case: buoyancy is in F, weight is not. Eq. 5 holds the
//! buoyancy already. Why −m_f g stands along periodic axes too: `docs/equations-immersed.md`.

use crate::immersed::Wrench;
use crate::immersed::body::Shape;
use protocol::facts::LoadsForm;
use protocol::message::Loads;

/// Largest mass, and inertia, that may act through the acceleration of the window before, over those of density ρ_p −
/// ρ/2, where it is positive and where it is negative: with a third of it discs were seen to fail
/// (docs/equations-immersed.md, section 4).
const LATE: [f64; 2] = [1.0 / 16.0, 0.5];

/// What is the same for all grains and steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadsRule {
    /// Form.
    pub form: LoadsForm,
    /// Virtual mass coefficient C_v of a grain with nothing near it.
    pub virtual_mass: f64,
    /// Gravity, m/s².
    pub gravity: [f64; 3],
    /// Density of the fluid, kg/m³.
    pub density: f64,
    /// Number of axes of a grain: 3 for a sphere, 2 for a disc.
    pub dimensions: i32,
    /// Whether ρ(∫β dV − V) goes with the added mass, else with the force.
    pub displaced_mass: bool,
}

/// What the fluid knows about one grain in one window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// ∫ f dV; for yu-shao-2007 and yu-shao-fixed-point −G/dt.
    pub force: Wrench,
    /// d/dt ∫ α u dV (kempe-froehlich-2012).
    pub interior: Wrench,
    /// Acceleration and angular acceleration over the window before (uhlmann-2005, displaced mass).
    pub acceleration: Wrench,
    /// Acceleration of the attempt before less that of the window before: what a DEM does not know when it
    /// adds added_mass A_prev. Zero in the first attempt at a window.
    pub ahead: Wrench,
    /// Added to C_v by walls and neighbours. It has no part in the virtual inertia: a sphere that turns moves no
    /// ideal fluid.
    pub near: f64,
    /// The same in the window before, whose acceleration the DEM adds: with it the virtual masses of all windows
    /// cancel in the sum, however they change.
    pub near_before: f64,
    /// Added to C_v: what repeated windows need so that the first attempts do not overshoot. It drops out.
    pub more: f64,
    /// ∫ β dV on the grid's nodes of each component, m³, where it is to count.
    pub volume: Option<[f64; 3]>,
    /// Acceleration that the fluid as a whole begins with, m/s²: in the first window only.
    pub drive: [f64; 3],
    /// Is it the first window of a fluid at rest? Then the grain starts with C_v alone (Izard et al. 2014, eq. 20).
    pub starts: bool,
}

impl LoadsRule {
    /// The message about one grain.
    pub fn loads(&self, shape: &Shape, measured: &Measured) -> Loads {
        let rho = self.density;
        let mass = rho * shape.volume;
        let inertia = mass * shape.gyration;
        let coefficient = self.virtual_mass + measured.more;
        let mut loads = Loads {
            added_mass: (coefficient + measured.near) * mass,
            added_inertia: coefficient * inertia,
            ..Loads::default()
        };
        let scale = match self.form {
            LoadsForm::Izard2014 => rho * shape.density / (shape.density - rho),
            _ => rho,
        };
        let buoyant = if self.form == LoadsForm::Izard2014 { 0.0 } else { mass };
        let (f, inside, a) = (&measured.force, &measured.interior, &measured.acceleration);
        for c in 0..3 {
            loads.force[c] = -scale * f.force[c] - buoyant * self.gravity[c];
            loads.torque[c] = -scale * f.torque[c];
            // Virtual mass resists motion relative to the fluid. A DEM counts the part of the fluid
            // through A_prev, of which it knows nothing before the first window.
            loads.force[c] += loads.added_mass * (measured.drive[c] + measured.ahead.force[c])
                + (measured.near_before - measured.near) * mass * a.force[c];
            loads.torque[c] += loads.added_inertia * measured.ahead.torque[c];
            match self.form {
                LoadsForm::KempeFroehlich2012 => {
                    loads.force[c] += rho * inside.force[c];
                    loads.torque[c] += rho * inside.torque[c];
                }
                LoadsForm::Uhlmann2005 => {
                    loads.force[c] += mass * a.force[c];
                    loads.torque[c] += inertia * a.torque[c];
                }
                LoadsForm::Izard2014 | LoadsForm::YuShao2007 | LoadsForm::YuShaoFixedPoint => {}
            }
        }
        if let Some(volumes) = measured.volume {
            self.displace(shape, volumes, measured, &mut loads);
        }
        loads
    }

    /// How much more inertia a body has whose volume is `ratio` times as large, less one: it goes with V^(1 + 2/d).
    fn swollen(&self, ratio: f64) -> f64 {
        ratio.powf(1.0 + 2.0 / f64::from(self.dimensions)) - 1.0
    }

    /// What is sent for the first window where loads are one window late: of the flow nothing is known but
    /// that it begins to move with `drive`.
    pub fn first(&self, shape: &Shape, drive: [f64; 3]) -> Loads {
        let force = Wrench { force: drive.map(|a| -shape.volume * a), ..Wrench::default() };
        self.loads(shape, &Measured { force, drive, ..Measured::default() })
    }

    /// Puts the mass ρ(∫β dV − V), by which the mask differs from the grain, on the grain's side of the equation:
    /// as force, times the acceleration that is known, as far as the grain is heavy enough to bear a force that comes
    /// one window late; the rest, where it is positive, as mass. A DEM adds added_mass A_prev to the force, which
    /// belongs to C_v m_f alone, so that of this mass is taken off here.
    ///
    /// The mass of a message has no direction: it is the mean over the components that the grain
    /// moves along, and what differs from it acts through the acceleration that is known.
    fn displace(&self, shape: &Shape, volumes: [f64; 3], measured: &Measured, loads: &mut Loads) {
        let (a, ahead) = (&measured.acceleration, &measured.ahead);
        let filled = volumes.iter().filter(|v| **v > 0.0).count().max(1);
        let volume = volumes.iter().sum::<f64>() / filled as f64;
        let mass = self.density * (volume - shape.volume);
        let inertia = self.density * shape.volume * shape.gyration * self.swollen(volume / shape.volume);
        let bears = LATE[usize::from(mass < 0.0)] * (shape.density / self.density - 0.5).max(0.0);
        // Parts that go with the force and with the mass.
        let parts = |extra: f64, own: f64| {
            if self.displaced_mass {
                return (0.0, 1.0);
            }
            let late = (bears * own / extra.abs()).min(1.0);
            (late, if extra > 0.0 && !measured.starts { 1.0 - late } else { 0.0 })
        };
        let (late, now) = parts(mass, self.density * shape.volume);
        let (late_spin, now_spin) = parts(inertia, self.density * shape.volume * shape.gyration);
        loads.added_mass += now * mass;
        loads.added_inertia += now_spin * inertia;
        for (c, here) in volumes.into_iter().enumerate() {
            let uneven = if here > 0.0 { self.density * (here - volume) } else { 0.0 };
            let known = a.force[c] + ahead.force[c] + measured.drive[c];
            loads.force[c] -= now * mass * a.force[c] + (late * mass + (late + now) * uneven) * known;
            loads.torque[c] -=
                inertia * (now_spin * a.torque[c] + late_spin * (a.torque[c] + ahead.torque[c]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: Shape =
        Shape { radius: 1.0, mask_radius: 1.0, outline: None, density: 4.0, volume: 3.0, gyration: 0.4 };

    fn rule(form: LoadsForm) -> LoadsRule {
        LoadsRule {
            form,
            virtual_mass: 0.5,
            gravity: [0.0, 0.0, -2.0],
            density: 1.0,
            dimensions: 3,
            displaced_mass: false,
        }
    }

    #[test]
    fn buoyancy_is_in_every_form_but_the_printed_one() {
        let none = Measured::default();
        for form in [
            LoadsForm::KempeFroehlich2012,
            LoadsForm::Uhlmann2005,
            LoadsForm::YuShao2007,
            LoadsForm::YuShaoFixedPoint,
        ] {
            let loads = rule(form).loads(&SHAPE, &none);
            assert_eq!(loads.force, [0.0, 0.0, 6.0]);
            assert_eq!((loads.added_mass, loads.added_inertia), (0.5 * 3.0, 0.5 * (3.0 * 0.4)));
        }
        assert_eq!(rule(LoadsForm::Izard2014).loads(&SHAPE, &none).force, [0.0; 3]);
    }

    /// A grain at rest in fluid at rest: interior fluid would fall with (ρ_p − ρ)/ρ_p g but is held.
    #[test]
    fn all_forms_agree_on_a_grain_that_moves_with_its_interior() {
        // Rigid interior, surface force per unit density s: ρV a = s − ρV g_h + ρ∫f with the
        // hydrostatic part subtracted, so ∫f = V a − s; every form must return s − m_f g.
        let (surface, a) = (1.7, 0.3);
        let force = Wrench { force: [0.0, 0.0, SHAPE.volume * a - surface], torque: [0.0; 3] };
        let interior = Wrench { force: [0.0, 0.0, SHAPE.volume * a], torque: [0.0; 3] };
        let acceleration = Wrench { force: [0.0, 0.0, a], torque: [0.0; 3] };
        let measured = Measured { force, interior, acceleration, ..Measured::default() };
        for form in [LoadsForm::KempeFroehlich2012, LoadsForm::Uhlmann2005] {
            let loads = rule(form).loads(&SHAPE, &measured);
            assert!((loads.force[2] - (surface + 6.0)).abs() < 1e-14, "{form:?}: {:?}", loads.force);
        }
        // izard-2014 agrees when `a` is the grain's true acceleration: m_p a = m_p g + F.
        let a = (12.0 * -2.0 + surface + 6.0) / 12.0;
        let force = Wrench { force: [0.0, 0.0, SHAPE.volume * a - surface], torque: [0.0; 3] };
        let loads = rule(LoadsForm::Izard2014).loads(&SHAPE, &Measured { force, ..Measured::default() });
        assert!((loads.force[2] - (surface + 6.0)).abs() < 1e-13, "{:?}", loads.force);
    }

    /// In repeated windows the virtual mass drops out: at A = A_k a DEM finds (m_p + m_a) A = … + m_a A_k,
    /// whatever A_prev it adds.
    #[test]
    fn virtual_mass_follows_the_attempts() {
        let (previous, attempt) = (0.25, -0.75);
        let ahead = Wrench { force: [0.0, 0.0, attempt - previous], torque: [0.0, attempt - previous, 0.0] };
        let plain = Measured::default();
        let (p, f) = (
            rule(LoadsForm::YuShaoFixedPoint).loads(&SHAPE, &plain),
            rule(LoadsForm::YuShaoFixedPoint).loads(&SHAPE, &Measured { ahead, more: 1.5, ..plain }),
        );
        assert_eq!(f.added_mass, 2.0 * 3.0);
        let (force, torque) =
            (f.force[2] + f.added_mass * previous, f.torque[1] + f.added_inertia * previous);
        assert!((force - (p.force[2] + 2.0 * 3.0 * attempt)).abs() < 1e-14);
        assert!((torque - (p.torque[1] + 2.0 * 3.0 * 0.4 * attempt)).abs() < 1e-14);
    }

    /// (m_p + m_a) A = … + m_a A_prev, window by window, with virtual masses that change: what they add cancels in
    /// the sum over a contact, which begins and ends without acceleration.
    #[test]
    fn virtual_masses_that_change_cancel_in_the_sum() {
        let rule = rule(LoadsForm::YuShaoFixedPoint);
        let buoyant = 6.0;
        let (mut sum, mut before, mut near_before) = (0.0, 0.0, 0.0);
        for (near, a) in [(0.1, 0.0), (0.3, 5.0), (0.2, -1.0), (0.0, 0.0)] {
            let acceleration = Wrench { force: [0.0, 0.0, before], torque: [0.0; 3] };
            let loads =
                rule.loads(&SHAPE, &Measured { acceleration, near, near_before, ..Measured::default() });
            sum += loads.force[2] - buoyant + loads.added_mass * (before - a);
            (before, near_before) = (a, near);
        }
        assert!(f64::abs(sum) < 1e-14, "{sum}");
    }

    /// A DEM solves (m_p + m_a) a = m_p g + F + m_a A_prev. With A_prev = a the message must add
    /// ρ(∫β dV − V) a, component by component, to the grain's side, and nothing else: as mass or as force.
    #[test]
    fn displaced_mass_stands_on_the_grains_side() {
        let (a, volumes) = (0.25, [3.2, 3.3, 3.3]);
        let acceleration = Wrench { force: [0.0, 0.0, a], torque: [0.0; 3] };
        let plain = Measured { acceleration, ..Measured::default() };
        let filled = Measured { volume: Some(volumes), ..plain };
        let rule = LoadsRule { displaced_mass: true, ..rule(LoadsForm::YuShaoFixedPoint) };
        let (p, f) = (rule.loads(&SHAPE, &plain), rule.loads(&SHAPE, &filled));
        let side = |l: &Loads| (12.0 + l.added_mass) * a - l.force[2] - l.added_mass * a;
        assert!((side(&f) - side(&p) - (volumes[2] - SHAPE.volume) * a).abs() < 1e-14);
        assert!(f.added_mass > p.added_mass && f.added_inertia > p.added_inertia);
        let f = LoadsRule { displaced_mass: false, ..rule }.loads(&SHAPE, &filled);
        assert!((side(&f) - side(&p) - (volumes[2] - SHAPE.volume) * a).abs() < 1e-14);
        assert_eq!((f.added_mass, f.added_inertia), (p.added_mass, p.added_inertia));
    }
}
