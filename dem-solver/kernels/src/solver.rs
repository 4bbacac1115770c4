//! The solver: all grains with the engine that moves them.

use crate::bulk::engine::Bulk;
use crate::bulk::requirements;
use crate::error::SpecError;
use crate::general::bodies::{BodyContacts, gap_between, gap_to_wall};
use crate::general::engine::General;
use crate::grain::{Grain, Shape};
use crate::grains::{Grains, Response};
use crate::laws::walls::{Follower, Plane};
use crate::motion::Vec3;
use crate::periods::Periods;
use crate::report::{Dissipated, Observations};
use crate::search::lists::Neighbours;
use crate::search::pairs::PairSearch;
use crate::spec::DemSpec;
use crate::state::SavedContact;
use crate::surroundings::Surroundings;
use bedload_over_time::OverTime;

/// The solver.
#[derive(Clone, Debug)]
pub struct Dem {
    /// Grains, in their present state.
    pub grains: Grains,
    pub(crate) engine: Running,
    pub(crate) around: Surroundings,
    pub(crate) response: Response,
    pub(crate) observed: Observations,
    pub(crate) gravity: OverTime<[f64; 3]>,
    pub(crate) time: f64,
    /// Done since the start of the run.
    pub(crate) substeps: u64,
    pub(crate) windows: u64,
    pub(crate) orientation: bool,
    shape: Shape,
    skin: f64,
    /// Grains near each other, where none is within the watched range, and those near one of them.
    pub(crate) search: (PairSearch, Vec<u32>),
}

#[derive(Clone, Debug)]
pub(crate) enum Running {
    General(Box<General>),
    Bulk(Box<Bulk>),
}

impl Dem {
    /// Checks the run and builds the solver at time zero.
    ///
    /// # Errors
    /// [`SpecError`]: the first fault of `spec`.
    pub fn new(spec: &DemSpec) -> Result<Self, SpecError> {
        spec.validate()?;
        let mut grains = Grains::new(&spec.grains, spec.shape, &spec.outlines);
        let around = Surroundings {
            walls: spec.walls.iter().map(Plane::from).collect(),
            periods: Periods::new(spec.periods),
            law: spec.contact.pair(),
            rolling: spec.contact.rolling(),
            range: spec.range(),
        };
        grains.wrap(&around.periods);
        let bulk = if requirements::takes(spec) { Bulk::new(spec) } else { None };
        let engine = match bulk {
            Some(bulk) => Running::Bulk(Box::new(bulk)),
            None => Running::General(Box::new(General::new(spec, &grains, &around))),
        };
        let is_bulk = matches!(engine, Running::Bulk(_));
        // the bulk engine needs it under loads only
        let mut response = Response::default();
        response.resize(if is_bulk { 0 } else { grains.len() });
        Ok(Self {
            response,
            observed: Observations::new(if is_bulk && !spec.observations { 0 } else { grains.len() }),
            engine,
            around,
            gravity: spec.gravity.clone(),
            time: 0.0,
            substeps: 0,
            windows: 0,
            orientation: spec.orientation,
            shape: spec.shape,
            skin: spec.skin(),
            search: Default::default(),
            grains,
        })
    }

    /// Time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Windows done since the start of the run.
    #[must_use]
    pub fn windows(&self) -> u64 {
        self.windows
    }

    /// The lists of the general engine at the present state, whichever engine runs.
    pub(crate) fn lists_now(&self) -> Neighbours {
        let n = self.grains.len();
        let mut lists = Neighbours::new(self.around.range, self.skin, n);
        let (pairs, walls) = self.bearing_contacts();
        lists.pairs.restore(&pairs, &[], n);
        lists.walls.restore(&walls, &[], n);
        lists.refresh(0.0, &self.grains, &self.around.walls, &self.around.periods, self.time);
        lists
    }

    /// Contacts between grains and with walls that bear a force, each ascending.
    pub(crate) fn bearing_contacts(&self) -> (Vec<SavedContact>, Vec<SavedContact>) {
        match &self.engine {
            Running::Bulk(bulk) => bulk.contacts(),
            Running::General(general) => {
                let lists = &general.evaluation.lists;
                (lists.pairs.bearing().collect(), lists.walls.bearing().collect())
            }
        }
    }

    /// The bodies that are not round as they stand; none where all are round.
    pub(crate) fn bodies_now(&self) -> Option<Box<BodyContacts>> {
        let mut bodies = self.general()?.evaluation.bodies.clone()?;
        bodies.placed.place(&self.grains);
        Some(bodies)
    }

    /// The first two grains that overlap by more than `share` of the smaller half width, and by how much, m.
    #[must_use]
    pub fn overlapping(&self, share: f64) -> Option<(usize, usize, f64)> {
        let (mut first, half) = (None, &self.grains.half_width);
        self.each_overlap(|i, j, overlap| {
            let found = overlap > share * half[i].min(half[j]);
            first = first.or(found.then_some((i, j, overlap)));
        });
        first
    }

    /// Free grains, and how deep each is in the walls that are there, m; negative beside them.
    pub fn overlaps_with_walls(&self) -> impl Iterator<Item = (usize, f64)> {
        let (grains, bodies, time) = (&self.grains, self.bodies_now(), self.time);
        (0..grains.len()).filter(|i| grains.responds(*i)).map(move |i| {
            let walls = self.around.walls.iter().filter(|wall| wall.acts(time));
            let overlap = |wall| -gap_to_wall((grains, bodies.as_deref()), i, wall, time);
            (i, walls.map(overlap).fold(f64::NEG_INFINITY, f64::max))
        })
    }

    /// The largest overlap of two grains of which one is free over the smaller half width, or of a free grain
    /// and a wall over its own.
    #[must_use]
    pub fn deepest(&self) -> f64 {
        let g = &self.grains;
        let mut deepest = 0.0_f64;
        self.each_overlap(|i, j, overlap| {
            if g.responds(i) || g.responds(j) {
                deepest = deepest.max(overlap / g.half_width[i].min(g.half_width[j]));
            }
        });
        self.overlaps_with_walls().map(|(i, overlap)| overlap / g.half_width[i]).fold(deepest, f64::max)
    }

    /// Gap between a round grain of radius `radius` at `x` and the nearest wall that is there, m.
    #[must_use]
    pub fn gap_to_walls(&self, x: &Vec3, radius: f64) -> f64 {
        let walls = self.around.walls.iter().filter(|wall| wall.acts(self.time));
        walls.map(|wall| wall.gap(x, radius, self.time)).fold(f64::INFINITY, f64::min)
    }

    /// Hands `each` the numbers of grains that are near each other, and their overlap, m.
    fn each_overlap(&self, mut each: impl FnMut(usize, usize, f64)) {
        let (lists, g, periods) = (self.lists_now(), &self.grains, &self.around.periods);
        let bodies = self.bodies_now();
        let round = lists.pairs.entries().map(|(i, k)| (i, lists.pairs.other[k] as usize));
        for (i, j) in round.chain(lists.body_pairs.iter().map(|[i, j]| (*i as usize, *j as usize))) {
            each(i, j, -gap_between((g, bodies.as_deref()), periods, [i, j], f64::INFINITY));
        }
    }

    /// Directions in which the box repeats.
    #[must_use]
    pub fn periods(&self) -> &Periods {
        &self.around.periods
    }

    /// Walls with a servo, by number.
    pub fn servos(&self) -> impl Iterator<Item = (usize, &Follower)> {
        let walls = self.around.walls.iter().enumerate();
        walls.filter_map(|(w, wall)| Some((w, &**wall.servo.as_ref()?)))
    }

    pub(crate) fn general(&self) -> Option<&General> {
        if let Running::General(general) = &self.engine { Some(general) } else { None }
    }

    /// Threads of the bulk engine; they change no bit.
    pub fn set_threads(&mut self, threads: usize) {
        if let Running::Bulk(bulk) = &mut self.engine {
            bulk.set_threads(threads);
        }
    }

    /// Adds `more` grains at `places`, behind those that are there. False, and nothing done, if the present
    /// engine cannot: then a solver for all of them must take the state over.
    pub fn insert(&mut self, more: &[Grain], places: &[Vec3]) -> bool {
        let Running::Bulk(bulk) = &mut self.engine else { return false };
        let before = self.grains.len();
        let mut new = Grains::new(more, self.shape, &[]);
        new.position.copy_from_slice(places);
        self.grains.append(new);
        let inserted = bulk.insert(&self.grains);
        if !inserted {
            self.grains.truncate(before);
        }
        inserted
    }

    /// Threads that the present size is worth, of those allowed.
    #[must_use]
    pub fn threads(&self) -> usize {
        if let Running::Bulk(bulk) = &self.engine { bulk.threads() } else { 1 }
    }

    /// Whether the next windows note forces, gaps and speeds per grain. The general engine always does.
    pub fn set_observations(&mut self, wanted: bool) {
        let n = if wanted { self.grains.len() } else { 0 };
        if self.is_bulk() && self.observed.gap_end.len() != n {
            self.observed = Observations::new(n);
        }
    }

    /// Notes in each sub-step of the next windows what acts on `grains`, for [`Observations::split`]; the
    /// bulk engine does not.
    pub fn split(&mut self, grains: &[usize]) {
        self.observed.split.choose(grains);
    }

    /// Whether the bulk engine does the work.
    #[must_use]
    pub fn is_bulk(&self) -> bool {
        matches!(self.engine, Running::Bulk(_))
    }

    /// Observations of the last window; empty in the bulk engine if they were not asked for.
    #[must_use]
    pub fn observations(&self) -> &Observations {
        &self.observed
    }

    /// How often the neighbour lists were built.
    #[must_use]
    pub fn list_builds(&self) -> u64 {
        match &self.engine {
            Running::General(general) => general.evaluation.lists.builds,
            Running::Bulk(bulk) => bulk.builds,
        }
    }

    /// What contacts have taken since the start, where [`DemSpec::energy`] asked for an account.
    #[must_use]
    pub fn dissipated(&self) -> Option<Dissipated> {
        let lost = self.account()?;
        Some(Dissipated { sliding: lost.sliding + self.spring_energy().1, ..lost })
    }

    /// The same as it is kept, with springs counted whole.
    pub(crate) fn account(&self) -> Option<Dissipated> {
        self.general()?.evaluation.account.as_ref().map(|account| account.lost)
    }
}
