//! One axis of a grid: where its faces and centres lie, and its metric.

use thiserror::Error;

/// Why a grid is impossible: the axis, what is wrong with it and what is allowed.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{0}")]
pub struct GridError(pub String);

/// How an axis is divided into cells.
#[derive(Clone, Debug, PartialEq)]
pub enum AxisSpec {
    /// Equal cells.
    Uniform {
        /// Position of the lower face, m.
        start: f64,
        /// Position of the upper face, m.
        end: f64,
        /// Number of cells.
        cells: usize,
    },
    /// Equal cells from `start` to `core_end`, then widths in arithmetic progression up to `end`.
    ///
    /// The radial grid of Izard, Bonometti & Lacaze (2014, §3.1): 128 cells over 20 D,
    /// constant width D/20 up to 1.5 D.
    Growing {
        /// Position of the lower face, m.
        start: f64,
        /// End of the part with equal cells, m.
        core_end: f64,
        /// Width of the equal cells, m.
        width: f64,
        /// Position of the upper face, m.
        end: f64,
        /// Number of cells in total.
        cells: usize,
    },
    /// Any increasing face positions, m, one more than there are cells.
    Faces(Vec<f64>),
}

impl AxisSpec {
    /// Face positions, m, and whether all widths are equal by construction.
    fn faces(&self, axis: usize) -> Result<(Vec<f64>, bool), GridError> {
        match *self {
            Self::Uniform { start, end, cells } => {
                check_cells(axis, cells)?;
                let h = (end - start) / cells as f64;
                let mut faces: Vec<f64> = (0..cells).map(|i| start + h * i as f64).collect();
                faces.push(end);
                Ok((faces, true))
            }
            Self::Growing { start, core_end, width, end, cells } => {
                check_cells(axis, cells)?;
                growing(axis, [start, core_end, end], width, cells).map(|f| (f, false))
            }
            Self::Faces(ref faces) => {
                check_cells(axis, faces.len().saturating_sub(1))?;
                Ok((faces.clone(), false))
            }
        }
    }
}

/// Refuses an axis with too few cells for a staggered grid.
fn check_cells(axis: usize, cells: usize) -> Result<(), GridError> {
    if cells < 2 {
        return Err(GridError(format!("axis {axis} has {cells} cells: at least 2 are needed")));
    }
    Ok(())
}

/// Face positions of [`AxisSpec::Growing`]: `[start, core_end, end]`, core width, cells in total.
fn growing(axis: usize, ends: [f64; 3], width: f64, cells: usize) -> Result<Vec<f64>, GridError> {
    let [start, core_end, end] = ends;
    let wanted = (core_end - start) / width;
    let core = wanted.round();
    if !(core >= 1.0 && (wanted - core).abs() < 1e-6 * core && core < cells as f64) {
        return Err(GridError(format!(
            "axis {axis}: the uniform part, {} long, must hold a whole number of cells of width {width}, at \
             least one and fewer than the {cells} cells of the axis",
            core_end - start
        )));
    }
    let grown = cells as f64 - core;
    // Σ_{k=1..m} (width + k δ) = end − core_end
    let growth = 2.0 * (end - core_end - grown * width) / (grown * (grown + 1.0));
    if !(growth >= -1e-12 * width && growth.is_finite()) {
        let most = (core + ((end - core_end) / width).floor()) as usize;
        return Err(GridError(format!(
            "axis {axis}: {cells} cells are too many for widths that grow outwards: give at most {most}, or \
             a smaller uniform width"
        )));
    }
    let core = core as usize;
    let mut faces: Vec<f64> = (0..=core).map(|i| start + width * i as f64).collect();
    for k in 1..=cells - core {
        let k = k as f64;
        faces.push(core_end + k * width + 0.5 * growth * k * (k + 1.0));
    }
    faces[cells] = end;
    Ok(faces)
}

/// One axis: positions, widths and metric factors. `n` is its number of cells.
///
/// The metric is 1, or r on the radial axis of an axisymmetric grid (per unit angle). Cell `i` lies
/// between faces `i` and `i + 1`. Face arrays have `n + 1` entries; on a periodic axis the last
/// repeats the first, one period on.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Positions of the faces, m, `n + 1`.
    pub faces: Vec<f64>,
    /// Positions of the cell centres (mid-points), m, `n`.
    pub centres: Vec<f64>,
    /// Cell widths, m, `n`.
    pub widths: Vec<f64>,
    /// 1 / widths, 1/m, `n`.
    pub inverse_widths: Vec<f64>,
    /// Distance between the centres on the two sides of a face, m, `n + 1`. At a wall the outer
    /// centre is the mirror image of the first one.
    pub distances: Vec<f64>,
    /// Metric area of the faces (1 or r), `n + 1`.
    pub face_area: Vec<f64>,
    /// Metric area at the centres (1 or r), `n`.
    pub centre_area: Vec<f64>,
    /// Metric volume of the cells, ∫ dx or ∫ r dr, `n`.
    pub cell_volume: Vec<f64>,
    /// 1 / `cell_volume`, `n`.
    pub inverse_cell_volume: Vec<f64>,
    /// Metric volume of a face's control volume, half of each neighbour cell, `n + 1`. At a wall it
    /// is the inner half only; on a periodic axis both halves.
    pub face_volume: Vec<f64>,
    /// Width shared by all cells, m, if the axis is uniform.
    pub uniform_width: Option<f64>,
    /// Whether the metric is r.
    pub radial: bool,
}

impl Axis {
    /// Builds axis number `number` (for messages) from its description.
    ///
    /// # Errors
    /// If the description is impossible, not increasing, or starts below r = 0.
    pub fn new(number: usize, spec: &AxisSpec, periodic: bool, radial: bool) -> Result<Self, GridError> {
        let (faces, uniform) = spec.faces(number)?;
        if let Some(at) = faces.iter().copied().find(|f| !f.is_finite()) {
            let what = format!("axis {number} has a face at {at}: every position must be a finite number");
            return Err(GridError(what));
        }
        if let Some(i) = (0..faces.len() - 1).find(|&i| faces[i + 1] <= faces[i]) {
            let (at, next) = (faces[i], faces[i + 1]);
            return Err(GridError(format!(
                "axis {number}: face {i} at {at} is followed by a face at {next}: positions must increase"
            )));
        }
        if radial && faces[0] < 0.0 {
            let start = faces[0];
            return Err(GridError(format!(
                "the radial axis starts at r = {start}: it must start at r = 0 or above"
            )));
        }
        let n = faces.len() - 1;
        let uniform_width = uniform.then(|| (faces[n] - faces[0]) / n as f64);
        let widths: Vec<f64> = (0..n).map(|i| uniform_width.unwrap_or(faces[i + 1] - faces[i])).collect();
        let centres: Vec<f64> = (0..n).map(|i| 0.5 * (faces[i] + faces[i + 1])).collect();
        let metric = |x: &f64| if radial { *x } else { 1.0 };
        let face_area: Vec<f64> = faces.iter().map(metric).collect();
        let centre_area: Vec<f64> = centres.iter().map(metric).collect();
        let cell_volume: Vec<f64> = (0..n).map(|i| centre_area[i] * widths[i]).collect();
        let (below, above) = if periodic { (n - 1, 0) } else { (0, n - 1) };
        let sides = |i: usize| (if i == 0 { below } else { i - 1 }, if i == n { above } else { i });
        let distances = (0..=n).map(|i| 0.5 * (widths[sides(i).0] + widths[sides(i).1])).collect();
        let face_volume = (0..=n)
            .map(|i| {
                let (a, b) = sides(i);
                let half = if !periodic && (i == 0 || i == n) { 0.25 } else { 0.5 };
                half * (cell_volume[a] + cell_volume[b])
            })
            .collect();
        Ok(Self {
            faces,
            centres,
            inverse_widths: widths.iter().map(|width| 1.0 / width).collect(),
            widths,
            distances,
            face_area,
            centre_area,
            inverse_cell_volume: cell_volume.iter().map(|volume| 1.0 / volume).collect(),
            cell_volume,
            face_volume,
            uniform_width,
            radial,
        })
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.widths.len()
    }

    /// Width of the cell at `place`, m; beyond the ends of the axis that of the last one.
    pub fn width_at(&self, place: f64) -> f64 {
        self.widths[self.faces.partition_point(|face| *face <= place).clamp(1, self.cells()) - 1]
    }

    /// Length of the axis, m.
    pub fn length(&self) -> f64 {
        self.faces[self.cells()] - self.faces[0]
    }

    /// Whether a transform along this axis diagonalises the operators: equal cells, metric 1.
    pub fn is_transformable(&self) -> bool {
        self.uniform_width.is_some() && !self.radial
    }
}
