//! Grains that hang together by contacts.

use std::collections::HashMap;

/// Two grains touch where their gap is below this part of their mean radius: a contact at rest
/// overlaps by less, and an integrator leaves that much between grains that have just parted.
const NEAR: f64 = 0.01;

/// A grain: centre (x, y, z) and radius, m.
pub(super) type Ball = ([f64; 3], f64);

/// Which of `balls` belong to the largest cluster of touching ones; `period` is the length of the
/// box along y, if it is periodic there. Of equal clusters the one with the first ball.
pub(super) fn largest_cluster(balls: &[Ball], period: Option<f64>) -> Vec<bool> {
    let mut clusters = Clusters { parent: (0..balls.len()).collect() };
    for (i, j) in touching(balls, period) {
        clusters.join(i, j);
    }
    let roots: Vec<usize> = (0..balls.len()).map(|i| clusters.root(i)).collect();
    let mut sizes = vec![0_usize; balls.len()];
    roots.iter().for_each(|root| sizes[*root] += 1);
    let largest = (0..balls.len()).rev().max_by_key(|root| sizes[*root]);
    roots.iter().map(|root| Some(*root) == largest).collect()
}

/// Pairs that touch, found through columns of cells as wide as the largest ball, upright in y.
fn touching(balls: &[Ball], period: Option<f64>) -> Vec<(usize, usize)> {
    let width = 2.0 * (1.0 + NEAR) * balls.iter().map(|(_, radius)| *radius).fold(0.0, f64::max);
    let cell = |x: &[f64; 3]| ((x[0] / width).floor() as i64, (x[2] / width).floor() as i64);
    let mut cells: HashMap<(i64, i64), Vec<usize>> = HashMap::new();
    for (i, (x, _)) in balls.iter().enumerate() {
        cells.entry(cell(x)).or_default().push(i);
    }
    let mut pairs = Vec::new();
    for (i, (x, radius)) in balls.iter().enumerate() {
        let (p, q) = cell(x);
        for neighbour in (p - 1..=p + 1).flat_map(|p| (q - 1..=q + 1).map(move |q| (p, q))) {
            for &j in cells.get(&neighbour).into_iter().flatten().filter(|j| **j > i) {
                let (other, theirs) = balls[j];
                let mut apart: [f64; 3] = std::array::from_fn(|c| other[c] - x[c]);
                if let Some(length) = period {
                    apart[1] -= length * (apart[1] / length).round();
                }
                let reach = (radius + theirs) * (1.0 + 0.5 * NEAR);
                if apart.iter().map(|d| d * d).sum::<f64>() <= reach * reach {
                    pairs.push((i, j));
                }
            }
        }
    }
    pairs
}

/// Union–find (Tarjan 1975); the smallest index is the root of its cluster.
struct Clusters {
    parent: Vec<usize>,
}

impl Clusters {
    fn root(&mut self, mut i: usize) -> usize {
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }

    fn join(&mut self, i: usize, j: usize) {
        let (i, j) = (self.root(i), self.root(j));
        self.parent[i.max(j)] = i.min(j);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_cluster_is_found_through_chains_and_the_period() {
        let ball = |x: f64, y: f64| ([x, y, 0.5], 0.5);
        // a chain of three, joined to a fourth through the period 5 along y, and a pair apart
        let balls =
            [ball(9.0, 1.0), ball(0.0, 0.2), ball(1.0, 0.2), ball(2.0, 0.2), ball(2.0, 4.2), ball(10.0, 1.0)];
        assert_eq!(largest_cluster(&balls, Some(5.0)), [false, true, true, true, true, false]);
        assert_eq!(largest_cluster(&balls, None), [false, true, true, true, false, false]);
        let apart = [ball(0.0, 0.0), ball(1.02, 0.0)];
        assert_eq!(largest_cluster(&apart, None), [true, false]);
        assert!(largest_cluster(&[], None).is_empty());
    }
}
