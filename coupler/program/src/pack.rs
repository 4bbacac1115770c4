//! `bedload pack`: a random packing as a table of grains, with the solid fraction that is asked for.
//!
//! Grains are placed one by one at random, as `[[groups]]` are, as long as each finds room. Where one does
//! not, it and those after it begin anywhere, and all are moved apart: soft spheres, a little larger than the
//! grains, that repel each other as springs do until no two grains overlap (O'Hern et al. 2003, Phys. Rev. E
//! 68, 011306), by the descent of Bitzek et al. (2006, Phys. Rev. Lett. 97, 170201).

use std::path::PathBuf;

use bedload_output::{GrainRow, atomic_write, grains_table};
use bedload_scene::SplitMix64;
use bedload_scene::table::{Table, number};
use clap::{Args, ValueEnum};
use coupler::failure::Failure;
use coupler::number::{AXES, Short, norm};
use protocol::loudness::is_quiet;

/// Largest solid fraction that may be asked for: in the plane, in space. Random packings of equal grains jam
/// at about 0.84 and 0.64.
const DENSEST: [f64; 2] = [0.84, 0.64];

/// Most grains.
const MOST: f64 = 2e6;

/// Tries for a place of one grain.
const TRIES: u32 = 10_000;

/// The same for one of a floor, whose layer is then full.
const FLOOR_TRIES: u32 = 2_000;

/// Steps of the descent, at most.
const SWEEPS: u32 = 20_000;

/// By so much soft spheres are larger than grains, so that the descent ends.
const SKIN: f64 = 1e-3;

/// Neighbours are searched to this gap over the mean diameter.
const REACH: f64 = 0.3;

/// Grains that one is held against, in cells as wide as the largest, and pairs of them in all: a search of
/// more of both takes minutes.
const MOST_NEAR: f64 = 1e3;
const MOST_PAIRS: f64 = 1e8;

/// Grains touch for the coordination number below this gap over the mean diameter.
const TOUCH: f64 = 0.01;

/// `--floor`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Floor {
    /// Fixed grains at random on the lower z face, up to a quarter of a diameter above it.
    Rough,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct Pack {
    /// Lengths of the box from 0: LX LZ of a plane, LX LY LZ of space, m
    #[arg(long = "box", value_name = "L", num_args = 2..=3, required = true, allow_negative_numbers = true)]
    size: Vec<f64>,
    /// Periodic axes, such as xy; at the others grains lie whole between the faces
    #[arg(long, value_name = "AXES", default_value = "", hide_default_value = true)]
    periodic: String,
    /// Part of the box that grains fill, up to 0.64 in space and 0.84 in the plane
    #[arg(long, value_name = "PART", allow_negative_numbers = true)]
    fraction: f64,
    /// Mean diameter, m
    #[arg(long, value_name = "D", required_unless_present = "sizes", allow_negative_numbers = true)]
    diameter: Option<f64>,
    /// Half-width of the uniform spread of diameters, relative to the mean
    #[arg(long, value_name = "PART", default_value_t = 0.0, allow_negative_numbers = true)]
    spread: f64,
    /// Table (CSV) of a distribution: column `diameter`, m, and `number` or `mass`, the share that has it
    #[arg(long, value_name = "FILE", conflicts_with_all = ["diameter", "spread"])]
    sizes: Option<PathBuf>,
    /// Density of the grains, kg/m³
    #[arg(long, value_name = "RHO", default_value_t = 1.0, allow_negative_numbers = true)]
    density: f64,
    /// Seed of the random numbers: the same seed, the same packing
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Fixed grains on the lower z face, which count as the others do
    #[arg(long)]
    floor: Option<Floor>,
    /// Table (CSV) of the grains, for [[grain_files]] of a scene
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Replace the table that stands there
    #[arg(long)]
    overwrite: bool,
}

/// A round grain; y = 0 in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ball {
    place: [f64; 3],
    radius: f64,
}

/// The box.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    /// Lengths; none along y in the plane.
    size: [f64; 3],
    periodic: [bool; 3],
    space: bool,
}

/// A packing and how it came about.
struct Packed {
    grains: Vec<Ball>,
    /// How many of the first are fixed.
    fixed: usize,
    /// Sizes over those that were drawn.
    scale: f64,
    sweeps: u32,
}

/// Makes the table, and says what it holds. Fails with [`Failure::Input`] at the option that cannot be,
/// [`Failure::Run`] where the fraction was not reached.
pub(crate) fn pack(asked: &Pack) -> Result<(), Failure> {
    let bounds = asked.bounds()?;
    asked.refuse_to_replace()?;
    let packed = asked.packed(&bounds)?;
    let row = |(id, ball): (usize, &Ball)| GrainRow {
        id,
        position: ball.place,
        radius: ball.radius,
        density: asked.density,
        velocity: [0.0; 3],
        spin: [0.0; 3],
        free: id >= packed.fixed,
        round: true,
    };
    let rows: Vec<GrainRow> = packed.grains.iter().enumerate().map(row).collect();
    atomic_write(&asked.out, grains_table(0.0, &rows).as_bytes())?;
    if is_quiet() {
        protocol::show!("{}", asked.out.display());
        return Ok(());
    }
    let how = match packed.sweeps {
        0 => "placed one by one".to_owned(),
        sweeps => format!("moved apart in {sweeps} sweeps"),
    };
    let mean = bounds.mean_diameter(&packed.grains);
    let (touching, gap) = bounds.neighbours(&packed.grains);
    let fixed = if packed.fixed > 0 { format!(", {} of them fixed", packed.fixed) } else { String::new() };
    protocol::show!(
        "{} grains{fixed}, {how}\nsolid fraction {}; sizes scaled by {:.6} for it, mean diameter {}\n\
         coordination number {touching:.2} (gaps below {TOUCH} diameters); {}\n{}",
        rows.len(),
        Short(bounds.fraction(&packed.grains)),
        packed.scale,
        Short(mean),
        least(gap / mean),
        asked.out.display()
    );
    Ok(())
}

/// Refuses an option.
fn refuse<T>(option: &str, what: impl std::fmt::Display) -> Result<T, Failure> {
    Err(Failure::Input(format!("{option} {what}")))
}

impl Pack {
    /// Refuses what stands at `--out`, but for a file that may be overwritten.
    fn refuse_to_replace(&self) -> Result<(), Failure> {
        let out = self.out.display();
        match std::fs::symlink_metadata(&self.out).map(|data| data.is_file()) {
            Ok(true) if !self.overwrite => refuse(
                "--out",
                format_args!("{out} exists: name another file, or replace it with --overwrite"),
            ),
            Ok(false) => refuse("--out", format_args!("{out} is no plain file: name another")),
            _ => Ok(()),
        }
    }

    fn bounds(&self) -> Result<Bounds, Failure> {
        let space = self.size.len() == 3;
        if let Some(wrong) = self.size.iter().find(|length| !(**length > 0.0 && length.is_finite())) {
            return refuse("--box", format_args!("has {wrong}; allowed: lengths above 0, m"));
        }
        let size = match self.size[..] {
            [x, z] => [x, 0.0, z],
            [x, y, z] => [x, y, z],
            _ => return refuse("--box", "takes two lengths of a plane or three of space"),
        };
        let axes = if space { "xyz" } else { "xz" };
        if let Some(wrong) = self.periodic.chars().find(|axis| !axes.contains(*axis)) {
            let what = format!("has {wrong:?}; allowed: letters of {axes}, such as x");
            return refuse("--periodic", what);
        }
        let densest = DENSEST[usize::from(space)];
        if !(self.fraction > 0.0 && self.fraction <= densest) {
            let what =
                format!("is {}; allowed: above 0, up to {densest}; random packings jam there", self.fraction);
            return refuse("--fraction", what);
        }
        for (option, value) in [("--density", self.density), ("--diameter", self.diameter.unwrap_or(1.0))] {
            if !(value > 0.0 && value.is_finite()) {
                return refuse(option, format_args!("is {value}; allowed: above 0"));
            }
        }
        if !(0.0..1.0).contains(&self.spread) {
            return refuse("--spread", format_args!("is {}; allowed: 0 to below 1", self.spread));
        }
        let periodic = ['x', 'y', 'z'].map(|axis| self.periodic.contains(axis));
        if self.floor.is_some() && periodic[2] {
            return refuse("--floor", "needs a lower z face; leave z out of --periodic");
        }
        Ok(Bounds { size, periodic, space })
    }

    /// The distribution: diameters with the part of all grains up to each; none: uniform about the mean.
    fn curve(&self, space: bool) -> Result<Vec<(f64, f64)>, Failure> {
        let Some(path) = &self.sizes else { return Ok(Vec::new()) };
        let read = || -> Result<Vec<(f64, f64)>, String> {
            let text =
                protocol::input_file::read_text(path).map_err(|error| format!("cannot be read: {error}"))?;
            let table = Table::parse(&text)?;
            table.refuse_odd().map_err(|what| format!("line {what}"))?;
            let diameter = table.need("diameter")?;
            let (share, by_mass) = match (table.find("number"), table.find("mass")) {
                (Some(share), None) => (share, false),
                (None, Some(share)) => (share, true),
                _ => return Err("needs one column `number` or `mass` beside `diameter`".into()),
            };
            let known = |name: &&String| ["diameter", "number", "mass"].contains(&name.as_str());
            if let Some(other) = table.columns.iter().find(|name| !known(name)) {
                return Err(format!("has a column `{other}`, which is not read: remove it"));
            }
            let mut sum = 0.0;
            let row = |row| {
                let known = number(row, diameter).zip(number(row, share));
                let known = known.filter(|(d, s)| *d > 0.0 && *s >= 0.0 && d.is_finite() && s.is_finite());
                let (d, share) = known.ok_or_else(|| {
                    let line = bedload_scene::table::line(row);
                    format!("has the row {line}; allowed: a diameter above 0 and a share, 0 and more")
                })?;
                sum += if by_mass { share / d.powi(if space { 3 } else { 2 }) } else { share };
                Ok((d, sum))
            };
            let curve = table.rows.iter().map(row).collect::<Result<Vec<_>, String>>()?;
            if sum > 0.0 { Ok(curve) } else { Err("has no share above 0".into()) }
        };
        read().or_else(|why| refuse("--sizes", format_args!("{}: {why}", path.display())))
    }

    /// Radii whose sum of volumes is that of the fraction, and what they were scaled by.
    fn radii(&self, bounds: &Bounds, random: &mut SplitMix64) -> Result<(Vec<f64>, f64), Failure> {
        let curve = self.curve(bounds.space)?;
        let mut draw = || match curve.last() {
            None => random.about(0.5 * self.diameter.unwrap_or(1.0), self.spread),
            Some((_, whole)) => {
                let part = whole * random.unit();
                0.5 * curve[curve.partition_point(|(_, sum)| *sum <= part).min(curve.len() - 1)].0
            }
        };
        let wanted = self.fraction * bounds.volume();
        let (mut radii, mut filled) = (Vec::new(), 0.0);
        loop {
            let radius = draw();
            let more = bounds.volume_of(radius);
            // The last grain counts where it brings the sum nearer.
            if filled + 0.5 * more > wanted {
                break;
            }
            filled += more;
            radii.push(radius);
            if radii.len() as f64 > MOST {
                let what = format!("takes more than {MOST:e} grains; allowed: fewer, larger");
                return refuse("--box", what);
            }
        }
        if radii.is_empty() {
            return refuse("--fraction", "is less than half a grain in this box; give a larger --box");
        }
        let scale = (wanted / filled).powf(if bounds.space { 1.0 / 3.0 } else { 0.5 });
        radii.iter_mut().for_each(|radius| *radius *= scale);
        let widest = 2.0 * radii.iter().copied().fold(0.0, f64::max);
        for axis in bounds.axes() {
            let least = if bounds.periodic[axis] { 2.0 * widest } else { widest };
            if bounds.size[axis] < least {
                let (name, has) = (AXES[axis], bounds.size[axis]);
                let why = "once, twice along a periodic axis, the largest diameter";
                let what = format!("is {has} along {name}; allowed: from {least} on: {why}");
                return refuse("--box", what);
            }
        }
        Ok((radii, scale))
    }

    fn packed(&self, bounds: &Bounds) -> Result<Packed, Failure> {
        let mut random = SplitMix64::new(self.seed);
        let (radii, scale) = self.radii(bounds, &mut random)?;
        let count = radii.len();
        let mut grid = Grid::new(bounds, &radii, 0.0);
        let near = grid.share_near() * count as f64;
        if near > MOST_NEAR && near * count as f64 > MOST_PAIRS {
            let what = format!(
                "is too wide: {count} grains with some {near:.0} each within reach of the largest; allowed: up to \
                 {MOST_NEAR:e} each, or {MOST_PAIRS:e} pairs: leave the smallest sizes out, or take a smaller --box"
            );
            return refuse("--sizes", what);
        }
        let mut grains: Vec<Ball> = Vec::with_capacity(count);
        if self.floor.is_some() {
            while let Some(radius) = radii.get(grains.len()) {
                let layer = |random: &mut SplitMix64| {
                    let mut place = bounds.anywhere(*radius, random);
                    place[2] = radius * (1.0 + 0.5 * random.unit());
                    place
                };
                if !grid.place(&mut grains, *radius, FLOOR_TRIES, || layer(&mut random)) {
                    break;
                }
            }
            if grains.len() == count {
                let what = format!("is {}, too little to cover the floor; give more", self.fraction);
                return refuse("--fraction", what);
            }
        }
        let fixed = grains.len();
        // None begins within the floor, between whose grains it could be caught.
        let floor = grid.clone();
        while let Some(radius) = radii.get(grains.len()) {
            if !grid.place(&mut grains, *radius, TRIES, || bounds.anywhere(*radius, &mut random)) {
                break;
            }
        }
        let mut sweeps = 0;
        if grains.len() < count {
            for radius in &radii[grains.len()..] {
                let mut ball = Ball { place: bounds.anywhere(*radius, &mut random), radius: *radius };
                for _ in 0..TRIES {
                    if floor.is_clear(&ball, &grains) {
                        break;
                    }
                    ball.place = bounds.anywhere(*radius, &mut random);
                }
                grains.push(ball);
            }
            sweeps = bounds.relax(&mut grains, fixed).map_err(|sweeps| {
                let reached = bounds.without_overlap(&grains);
                let (touching, gap) = bounds.neighbours(&grains);
                let gap = gap / bounds.mean_diameter(&grains);
                Failure::Run(format!(
                    "the solid fraction {} was not reached in {sweeps} sweeps: without overlap these grains fill \
                     {reached:.4} where they lie now (coordination number {touching:.2}, {}); no file was \
                     written; give a lower --fraction, a larger --box or another --seed",
                    self.fraction,
                    least(gap)
                ))
            })?;
        }
        Ok(Packed { grains, fixed, scale, sweeps })
    }
}

/// What is said of the least gap over the mean diameter.
fn least(gap: f64) -> String {
    if gap.is_finite() {
        format!("least gap {gap:.3e} diameters")
    } else {
        format!("no gap below {REACH} diameters")
    }
}

impl Bounds {
    fn axes(&self) -> impl Iterator<Item = usize> + use<> {
        let space = self.space;
        (0..3).filter(move |axis| space || *axis != 1)
    }

    /// Volume, of a plane area.
    fn volume(&self) -> f64 {
        self.axes().map(|axis| self.size[axis]).product()
    }

    fn volume_of(&self, radius: f64) -> f64 {
        use std::f64::consts::PI;
        if self.space { 4.0 / 3.0 * PI * radius.powi(3) } else { PI * radius * radius }
    }

    fn fraction(&self, grains: &[Ball]) -> f64 {
        grains.iter().map(|ball| self.volume_of(ball.radius)).sum::<f64>() / self.volume()
    }

    fn mean_diameter(&self, grains: &[Ball]) -> f64 {
        2.0 * grains.iter().map(|ball| ball.radius).sum::<f64>() / grains.len() as f64
    }

    /// A place for a grain between the faces.
    fn anywhere(&self, radius: f64, random: &mut SplitMix64) -> [f64; 3] {
        std::array::from_fn(|axis| match (self.periodic[axis], self.size[axis]) {
            (_, 0.0) => 0.0,
            (true, length) => length * random.unit(),
            (false, length) => radius + (length - 2.0 * radius) * random.unit(),
        })
    }

    /// From `b` to the nearest image of `a`.
    fn apart(&self, a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let apart = a[axis] - b[axis];
            let turn = if self.periodic[axis] { (apart / self.size[axis]).round() } else { 0.0 };
            apart - self.size[axis] * turn
        })
    }

    /// Pairs with a gap below `gap`, each once.
    fn pairs(&self, grains: &[Ball], gap: f64) -> Vec<(usize, usize)> {
        let radii: Vec<f64> = grains.iter().map(|ball| ball.radius).collect();
        let mut grid = Grid::new(self, &radii, gap);
        let mut pairs = Vec::new();
        for (i, ball) in grains.iter().enumerate() {
            let near = grid.near(&ball.place).filter(|j| self.gap(ball, &grains[*j]) < gap);
            pairs.extend(near.map(|j| (i, j)));
            grid.add(i, &ball.place);
        }
        pairs
    }

    fn gap(&self, a: &Ball, b: &Ball) -> f64 {
        norm(&self.apart(&a.place, &b.place)) - a.radius - b.radius
    }

    /// Distances of a grain from the faces that it must not cross, with the way off each.
    fn faces(&self, ball: &Ball) -> impl Iterator<Item = (usize, f64, f64)> + use<> {
        let (place, size, periodic) = (ball.place, self.size, self.periodic);
        let walls = self.axes().filter(move |axis| !periodic[*axis]);
        walls.flat_map(move |a| [(a, place[a], 1.0), (a, size[a] - place[a], -1.0)])
    }

    /// Mean number of grains that each touches, and the least gap.
    fn neighbours(&self, grains: &[Ball]) -> (f64, f64) {
        let mean = self.mean_diameter(grains);
        let gaps =
            self.pairs(grains, REACH * mean).into_iter().map(|(i, j)| self.gap(&grains[i], &grains[j]));
        let (mut touching, mut least) = (0, f64::INFINITY);
        for gap in gaps {
            touching += usize::from(gap < TOUCH * mean);
            least = least.min(gap);
        }
        (2.0 * touching as f64 / grains.len() as f64, least)
    }

    /// The fraction with all sizes so small that none overlap where they lie.
    fn without_overlap(&self, grains: &[Ball]) -> f64 {
        let pair = |(i, j): (usize, usize)| {
            let (a, b) = (&grains[i], &grains[j]);
            norm(&self.apart(&a.place, &b.place)) / (a.radius + b.radius)
        };
        let pairs = self.pairs(grains, 0.0).into_iter().map(pair);
        let faces = grains.iter().flat_map(|ball| self.faces(ball).map(|(_, far, _)| far / ball.radius));
        let least = pairs.chain(faces).fold(1.0, f64::min);
        self.fraction(grains) * least.powi(if self.space { 3 } else { 2 })
    }

    /// Moves grains apart until none overlap; the first `fixed`, those of a floor, keep their height: held in
    /// place they could catch another between them. Sweeps that it took; of a packing that jams or does not
    /// end, as an error.
    fn relax(&self, grains: &mut [Ball], fixed: usize) -> Result<u32, u32> {
        let reach = REACH * self.mean_diameter(grains);
        let mut pairs = self.pairs(grains, reach);
        let mut known: Vec<[f64; 3]> = grains.iter().map(|ball| ball.place).collect();
        let mut velocity = vec![[0.0; 3]; grains.len()];
        let mut force = velocity.clone();
        // Unit mass and stiffness: a grain with twelve contacts swings with 2π/24^½.
        let (mut dt, mut mix, mut downhill): (f64, f64, u32) = (0.1, 0.1, 0);
        for sweep in 0..SWEEPS {
            let moved = |(ball, known): (&Ball, &[f64; 3])| norm(&self.apart(&ball.place, known));
            if grains.iter().zip(&known).map(moved).fold(0.0, f64::max) > 0.5 * reach {
                pairs = self.pairs(grains, reach);
                known.iter_mut().zip(grains.iter()).for_each(|(known, ball)| *known = ball.place);
            }
            let clear = self.push(grains, &pairs, &mut force);
            force[..fixed].iter_mut().for_each(|force| force[2] = 0.0);
            let largest = force.iter().map(norm).fold(0.0, f64::max);
            if clear {
                grains.iter_mut().for_each(|ball| self.wrap(ball));
                return Ok(sweep);
            }
            if largest < 1e-9 * reach {
                return Err(sweep);
            }
            let sum = |a: &[[f64; 3]], b: &[[f64; 3]]| -> f64 {
                a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).sum()
            };
            if sum(&force, &velocity) > 0.0 {
                let turn = mix * (sum(&velocity, &velocity) / sum(&force, &force)).sqrt();
                for (v, f) in velocity.iter_mut().flatten().zip(force.iter().flatten()) {
                    *v += turn * f - mix * *v;
                }
                downhill += 1;
                if downhill > 5 {
                    (dt, mix) = ((1.1 * dt).min(0.35), 0.99 * mix);
                }
            } else {
                velocity.fill([0.0; 3]);
                (dt, mix, downhill) = (0.5 * dt, 0.1, 0);
            }
            for ((ball, v), f) in grains.iter_mut().zip(&mut velocity).zip(&force) {
                for axis in 0..3 {
                    v[axis] += dt * f[axis];
                    ball.place[axis] += dt * v[axis];
                }
            }
        }
        Err(SWEEPS)
    }

    /// Forces of soft spheres and faces; says whether all grains are clear of each other and of the faces.
    fn push(&self, grains: &[Ball], pairs: &[(usize, usize)], force: &mut [[f64; 3]]) -> bool {
        force.fill([0.0; 3]);
        let mut clear = true;
        for (i, j) in pairs {
            let (a, b) = (&grains[*i], &grains[*j]);
            let apart = self.apart(&a.place, &b.place);
            let (distance, touch) = (norm(&apart), a.radius + b.radius);
            clear &= distance >= touch;
            let push = (1.0 + SKIN) * touch - distance;
            if push > 0.0 && distance > 0.0 {
                for axis in 0..3 {
                    let along = push * apart[axis] / distance;
                    force[*i][axis] += along;
                    force[*j][axis] -= along;
                }
            }
        }
        if self.periodic != [true; 3] {
            for (ball, force) in grains.iter().zip(force.iter_mut()) {
                for (axis, far, way) in self.faces(ball) {
                    clear &= far >= ball.radius;
                    force[axis] += way * ((1.0 + SKIN) * ball.radius - far).max(0.0);
                }
            }
        }
        clear
    }

    /// Puts a grain back into the box along periodic axes.
    fn wrap(&self, ball: &mut Ball) {
        for axis in self.axes().filter(|axis| self.periodic[*axis]) {
            let place = ball.place[axis].rem_euclid(self.size[axis]);
            ball.place[axis] = if place < self.size[axis] { place } else { 0.0 };
        }
    }
}

/// Grains by cells that are as wide as the largest, and a gap.
#[derive(Clone)]
struct Grid<'a> {
    bounds: &'a Bounds,
    counts: [usize; 3],
    cells: Vec<Vec<usize>>,
}

impl<'a> Grid<'a> {
    fn new(bounds: &'a Bounds, radii: &[f64], gap: f64) -> Self {
        let width = 2.0 * radii.iter().copied().fold(0.0, f64::max) + gap.max(0.0);
        // Not many more cells than grains.
        let most = 2.0 * (radii.len() as f64).sqrt() + 3.0;
        let counts = bounds.size.map(|length| (length / width).clamp(1.0, most) as usize);
        Self { bounds, counts, cells: vec![Vec::new(); counts.iter().product()] }
    }

    fn cell(&self, place: &[f64; 3]) -> [usize; 3] {
        std::array::from_fn(|axis| {
            let (count, length) = (self.counts[axis], self.bounds.size[axis]);
            let part = if length > 0.0 { place[axis] / length } else { 0.0 };
            let part = if self.bounds.periodic[axis] { part.rem_euclid(1.0) } else { part };
            ((part * count as f64).max(0.0) as usize).min(count - 1)
        })
    }

    fn add(&mut self, index: usize, place: &[f64; 3]) {
        let [x, y, z] = self.cell(place);
        let cell = x + self.counts[0] * (y + self.counts[1] * z);
        self.cells[cell].push(index);
    }

    /// Part of the box that the cells about one have.
    fn share_near(&self) -> f64 {
        self.counts.iter().map(|count| *count.min(&3) as f64 / *count as f64).product()
    }

    /// Cells about one along an axis, each once.
    fn about(&self, axis: usize, cell: usize) -> Vec<usize> {
        let count = self.counts[axis];
        if count < 3 {
            return (0..count).collect();
        }
        let near = (count + cell - 1)..(count + cell + 2);
        let inside = |near: &usize| self.bounds.periodic[axis] || (count..2 * count).contains(near);
        near.filter(inside).map(|near| near % count).collect()
    }

    /// Grains of the cells about a place.
    fn near(&self, place: &[f64; 3]) -> impl Iterator<Item = usize> {
        let cell = self.cell(place);
        let [x, y, z] = std::array::from_fn(|axis| self.about(axis, cell[axis]));
        let mut near = Vec::with_capacity(27);
        for z in z {
            for y in &y {
                near.extend(x.iter().map(|x| x + self.counts[0] * (y + self.counts[1] * z)));
            }
        }
        near.into_iter().flat_map(|cell| self.cells[cell].iter().copied())
    }

    /// Does a grain meet none of those that were added?
    fn is_clear(&self, ball: &Ball, grains: &[Ball]) -> bool {
        self.near(&ball.place).all(|j| self.bounds.gap(ball, &grains[j]) >= 0.0)
    }

    /// Adds a grain at the first place that is clear of all others; says whether there was one.
    fn place(
        &mut self,
        grains: &mut Vec<Ball>,
        radius: f64,
        tries: u32,
        mut draw: impl FnMut() -> [f64; 3],
    ) -> bool {
        let mut balls = (0..tries).map(|_| Ball { place: draw(), radius });
        let found = balls.find(|ball| self.is_clear(ball, grains));
        let Some(ball) = found else { return false };
        self.add(grains.len(), &ball.place);
        grains.push(ball);
        true
    }
}
