//! Periodic directions: nearest images, and turns around a period.

use crate::motion::Vec3;

/// Periodic directions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Periods {
    start: [f64; 3],
    /// m; 0 where there is no period.
    pub(crate) length: [f64; 3],
    inverse: [f64; 3],
    any: bool,
}

impl Periods {
    /// From lower end and length per axis.
    #[must_use]
    pub fn new(axes: [Option<(f64, f64)>; 3]) -> Self {
        let mut periods = Self::default();
        for (axis, period) in axes.iter().enumerate() {
            if let Some((start, length)) = *period {
                periods.start[axis] = start;
                periods.length[axis] = length;
                periods.inverse[axis] = 1.0 / length;
                periods.any = true;
            }
        }
        periods
    }

    /// Lower end and length of the period along `axis`, m; length 0 where there is none.
    #[must_use]
    pub fn of(&self, axis: usize) -> (f64, f64) {
        (self.start[axis], self.length[axis])
    }

    /// Whether `axis` is periodic.
    #[must_use]
    pub fn is_periodic(&self, axis: usize) -> bool {
        self.length[axis] > 0.0
    }

    /// The shortest of all images of the distance vector `d`.
    #[inline(always)]
    #[must_use]
    pub fn nearest(&self, mut d: Vec3) -> Vec3 {
        if self.any {
            /// Adding it rounds to a whole number.
            const WHOLE: f64 = 6_755_399_441_055_744.0;
            for axis in 0..3 {
                let turns = (d[axis] * self.inverse[axis] + WHOLE) - WHOLE;
                d[axis] -= self.length[axis] * turns;
            }
        }
        d
    }

    /// Where `x` is, its turns around the periods counted in.
    #[must_use]
    pub fn unwrap(&self, x: &Vec3, image: &[i32; 3]) -> Vec3 {
        x + Vec3::from_fn(|axis, _| self.length[axis] * f64::from(image[axis]))
    }

    /// Puts `x` back into the period and counts the turns in `image`.
    #[inline]
    pub fn wrap(&self, x: &mut Vec3, image: &mut [i32; 3]) {
        for axis in 0..3 {
            if self.length[axis] > 0.0 {
                let turns = ((x[axis] - self.start[axis]) * self.inverse[axis]).floor();
                if turns != 0.0 {
                    x[axis] -= turns * self.length[axis];
                    image[axis] = image[axis].saturating_add(turns as i32);
                }
            }
        }
    }
}
