//! Tridiagonal systems `(σ − c (L + λ)) x = b`: L the stencil along the swept axis, λ the eigenvalue of the
//! transformed axes. Off-diagonals are the same for all λ.

/// Tridiagonal form of a stencil along the swept axis, walls folded into the diagonal. Unknowns only.
#[derive(Clone, Debug)]
pub(crate) struct Sweep {
    /// Weight of the lower neighbour; zero for the first unknown.
    pub(crate) lower: Vec<f64>,
    /// Weight of the upper neighbour; zero for the last unknown.
    pub(crate) upper: Vec<f64>,
    /// Diagonal (negative).
    pub(crate) diagonal: Vec<f64>,
    /// Metric volume of each unknown, for the mean of the singular mode.
    pub(crate) volume: Vec<f64>,
    /// The last true unknown: there may be idle ones around, see [`Sweep::padded`].
    pub(crate) last: usize,
}

impl Sweep {
    pub(crate) fn len(&self) -> usize {
        self.diagonal.len()
    }

    /// The same with `before` idle unknowns in front and some behind, to whole tiles of eight. An
    /// idle one has no neighbour and nothing to do with the others.
    pub(crate) fn padded(mut self, before: usize) -> Self {
        let len = (self.len() + before).next_multiple_of(8);
        let lines = [&mut self.lower, &mut self.upper, &mut self.diagonal, &mut self.volume];
        for (values, idle) in lines.into_iter().zip([0.0, 0.0, -1.0, 0.0]) {
            values.splice(0..0, std::iter::repeat_n(idle, before));
            values.resize(len, idle);
        }
        self.last += before;
        self
    }
}
