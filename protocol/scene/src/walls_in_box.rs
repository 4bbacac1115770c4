//! What plane walls are in the box of a scene.

use crate::domain::Domain;
use crate::walls::Wall;
use bedload_over_time::{cross, length};

impl Wall {
    /// Largest speed of its surface in the box up to `until`, s.
    pub fn largest_speed(&self, domain: &Domain, until: f64) -> f64 {
        let spin = self.spin.longest(until);
        let about = self.about.unwrap_or(self.point);
        let corner = |number: usize| {
            let mut arm = [0.0; 3];
            for axis in 0..domain.dimensions() {
                let c = domain.geometry.component(axis);
                let side = if number >> axis & 1 == 0 { &domain.lower } else { &domain.upper };
                arm[c] = side[axis] - about[c];
            }
            length(&cross(&spin, &arm))
        };
        let servo = self.servo.as_ref().map_or(0.0, |servo| servo.largest_speed);
        let turning = if spin == [0.0; 3] { 0.0 } else { (0..8).map(corner).fold(0.0, f64::max) };
        self.velocity.largest(until) + servo + turning
    }

    /// Largest speed along its normal up to `until`, s: of one that turns that of its surface in the box.
    pub fn nearing_speed(&self, domain: &Domain, until: f64) -> f64 {
        if !self.spin.is_zero() {
            return self.largest_speed(domain, until);
        }
        let along = |velocity: &[f64; 3]| (0..3).map(|c| self.normal[c] * velocity[c]).sum::<f64>();
        let servo = self.servo.as_ref().map_or(0.0, |servo| servo.largest_speed);
        self.velocity.map(along).largest(until) / length(&self.normal) + servo
    }

    /// Area on which a servo acts, m² (plane: m): as given, or the cross-section of the box.
    pub fn area(&self, domain: &Domain) -> Option<f64> {
        let across = (0..domain.dimensions()).filter(|axis| {
            let c = domain.geometry.component(*axis);
            (0..3).all(|other| (self.normal[other] != 0.0) == (other == c))
        });
        let along = |axis: usize| (0..domain.dimensions()).filter(move |other| *other != axis);
        let of_box =
            across.map(|axis| along(axis).map(|a| domain.upper[a] - domain.lower[a]).product()).next();
        self.servo.as_ref()?.area.or(of_box)
    }
}
