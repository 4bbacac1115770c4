//! Contacts of bodies that are not round, among themselves, with discs and with walls.
//!
//! Every point of contact is a soft contact like that of two discs (`general::contact`), with its own spring
//! and its own effective mass, which is taken at the first touch and kept: a point's spring is constant.
//! Forces turn a body by their whole arm, the normal force too.

use crate::bodies::meeting::{SECOND, distance, meet};
use crate::bodies::placed::{Form, Placed};
use crate::bodies::plane::{Vec2, dot, minus, plus, turning};
use crate::bodies::points::Points;
use crate::general::body_point::{Place, flat};
use crate::general::forces::Scene;
use crate::general::sums::Forces;
use crate::grains::Grains;
use crate::laws::table::PairLaw;
use crate::laws::walls::Plane;
use crate::motion::Vec3;
use crate::periods::Periods;
use crate::report::Observations;
use crate::search::lists::Neighbours;
use crate::state::SavedPoint;
use bedload_outline::Outline;

/// A point of contact that was evaluated.
pub(crate) struct Acting {
    pub(crate) place: Place,
    /// On the first, N.
    pub(crate) force: Vec2,
    /// Of the gap, m/s.
    rate: f64,
    /// Whether it bore a force before, and does now.
    bears: (bool, bool),
}

/// What an evaluation meets.
enum Met<'a> {
    /// Grains within reach of each other, or a grain and a wall, with their gap.
    Gap(usize, Option<usize>, f64),
    Point(&'a Acting),
}

/// Bodies that are not round, and their points of contact.
#[derive(Clone, Debug)]
pub(crate) struct BodyContacts {
    /// As they stood when they were placed last, for [`Self::distance`] and [`Self::gap_to_wall`].
    pub(crate) placed: Placed,
    pub(crate) pairs: Points,
    pub(crate) walls: Points,
}

impl BodyContacts {
    /// For these grains; none if all are round.
    pub(crate) fn new(grains: &Grains, outlines: &[Outline]) -> Option<Box<Self>> {
        let any = (0..grains.len()).any(|i| !grains.is_round(i));
        let placed = || Placed::new(grains, outlines);
        any.then(|| Box::new(Self { placed: placed(), pairs: Points::default(), walls: Points::default() }))
    }

    /// Adds the forces and torques of all points; springs take their step on the way.
    pub(super) fn add_forces(
        &mut self,
        scene: &Scene<'_>,
        lists: &Neighbours,
        forces: &mut Forces,
        observed: &mut Observations,
    ) {
        let range = scene.around.range;
        self.visit(scene, lists, |met| match met {
            Met::Gap(i, j, gap) => {
                if gap <= range {
                    for grain in [Some(i), j].into_iter().flatten() {
                        observed.smallest_gap[grain] = observed.smallest_gap[grain].min(gap);
                    }
                    forces.overlap = forces.overlap.max(-gap);
                }
            }
            Met::Point(Acting { place, force, rate, bears }) => {
                observed.note_event(*bears, *rate, place.first, place.second);
                let push = Vec3::new(force[0], 0.0, force[1]);
                forces.contact[place.first] += push;
                forces.torque[place.first].y += turning(place.arms.0, *force);
                if let Some((wall, _)) = place.wall {
                    forces.walls[wall] -= push;
                }
                if let Some(j) = place.second {
                    forces.contact[j] -= push;
                    forces.torque[j].y -= turning(place.arms.1, *force);
                }
            }
        });
    }

    /// Every point that bears a force at the present state; nothing changes but the memory of this copy.
    pub(crate) fn bearing(
        &mut self,
        scene: &Scene<'_>,
        lists: &Neighbours,
        mut each: impl FnMut(&Place, Vec2),
    ) {
        self.visit(scene, lists, |met| {
            if let Met::Point(acting) = met
                && acting.bears.1
            {
                each(&acting.place, acting.force);
            }
        });
    }

    fn visit(&mut self, scene: &Scene<'_>, lists: &Neighbours, mut met: impl FnMut(Met<'_>)) {
        let Scene { around, grains, .. } = *scene;
        let Self { placed, pairs, walls } = self;
        placed.place(grains);
        pairs.begin();
        for &[first, second] in &lists.body_pairs {
            let (i, j) = (first as usize, second as usize);
            let touched = !pairs.go_to(first, second).is_empty();
            let apart = around.periods.nearest(grains.position[i] - grains.position[j]);
            let reach = grains.radius[i] + grains.radius[j] + around.range;
            if apart.norm_squared() > reach * reach && !touched {
                continue;
            }
            let (one, other, apart) = (placed.form(grains, i), placed.form(grains, j), flat(&apart));
            let meeting = meet(&one, &other, apart, touched);
            met(Met::Gap(i, Some(j), meeting.gap));
            let law = &around.law;
            let site = |feature: u32| site(&one, &other, apart, feature);
            let span2 = grains.radius[i].min(grains.radius[j]).powi(2);
            for touch in meeting.touches() {
                let place = Place {
                    first: i,
                    second: Some(j),
                    wall: None,
                    normal: touch.normal,
                    gap: touch.gap,
                    arms: (touch.arm, plus(touch.arm, apart)),
                };
                let known = |feature| meeting.touches().iter().any(|touch| touch.feature == feature);
                let far = |a: u32, b: u32| {
                    let between = minus(site(a), site(b));
                    dot(between, between) / span2
                };
                let old = pairs.find(touch.feature, known, far);
                act(scene, law, pairs, (second, touch.feature, old), place, &mut met);
            }
        }
        pairs.finish();
        walls.begin();
        for &[first, second] in &lists.body_walls {
            let (i, w) = (first as usize, second as usize);
            let (wall, stand) = (&around.walls[w], &scene.stands[w]);
            walls.go_to(first, second);
            if !wall.acts(scene.kinematics.t) {
                continue;
            }
            let law = &around.law;
            let x0 = grains.position[i];
            let height = stand.gap(&x0, 0.0);
            let normal = flat(&stand.normal);
            let mut lowest = f64::INFINITY;
            let mut at = |feature: usize, x: Vec2, walls: &mut Points| {
                let gap = height + dot(x, normal);
                lowest = lowest.min(gap);
                let feature = feature as u32;
                let old = walls.old().iter().find(|point| point.feature == feature).copied();
                if gap >= 0.0 && old.is_none() {
                    return;
                }
                // A wall does not yield: the point lies in its plane.
                let arm = [x[0] - normal[0] * gap, x[1] - normal[1] * gap];
                let arms = (arm, [0.0; 2]);
                let velocity = stand.velocity_at(&(x0 + Vec3::new(arm[0], 0.0, arm[1])));
                let place =
                    Place { first: i, second: None, wall: Some((w, flat(&velocity))), normal, gap, arms };
                act(scene, law, walls, (second, feature, old), place, &mut met);
            };
            match placed.form(grains, i) {
                Form::Polygon { edges, .. } => {
                    edges.vertices.iter().enumerate().for_each(|(v, x)| at(v, *x, walls));
                }
                form => at(0, form.support([-normal[0], -normal[1]]), walls),
            }
            met(Met::Gap(i, None, lowest));
        }
        walls.finish();
    }

    /// Distance of the surfaces of two grains, negative where they overlap, m.
    pub(crate) fn distance(&self, grains: &Grains, periods: &Periods, i: usize, j: usize) -> f64 {
        let apart = periods.nearest(grains.position[i] - grains.position[j]);
        distance(&self.placed.form(grains, i), &self.placed.form(grains, j), flat(&apart))
    }

    /// Gap between a grain and a wall, m.
    pub(crate) fn gap_to_wall(&self, grains: &Grains, i: usize, wall: &Plane, t: f64) -> f64 {
        let stand = wall.at(t);
        let normal = flat(&stand.normal);
        let lowest = self.placed.form(grains, i).support([-normal[0], -normal[1]]);
        stand.gap(&grains.position[i], -dot(lowest, normal))
    }
}

/// Gap of a grain to a wall, m.
pub(crate) fn gap_to_wall(
    (grains, bodies): (&Grains, Option<&BodyContacts>),
    i: usize,
    wall: &Plane,
    time: f64,
) -> f64 {
    match bodies.filter(|_| !grains.is_round(i)) {
        Some(bodies) => bodies.gap_to_wall(grains, i, wall, time),
        None => wall.gap(&grains.position[i], grains.radius[i], time),
    }
}

/// Gap between two grains, m; of bodies that are farther apart than `least`, that of the circles about them,
/// which are as near as they can be.
pub(crate) fn gap_between(
    (grains, bodies): (&Grains, Option<&BodyContacts>),
    periods: &Periods,
    [i, j]: [usize; 2],
    least: f64,
) -> f64 {
    let apart = periods.nearest(grains.position[i] - grains.position[j]);
    let gap = apart.norm() - grains.radius[i] - grains.radius[j];
    match bodies.filter(|_| gap < least && !(grains.is_round(i) && grains.is_round(j))) {
        Some(bodies) => bodies.distance(grains, periods, i, j),
        None => gap,
    }
}

/// Where a feature lies, from the centre of the second.
fn site(one: &Form<'_>, other: &Form<'_>, apart: Vec2, feature: u32) -> Vec2 {
    let vertex = |form: &Form<'_>, v: u32| match form {
        Form::Polygon { edges, .. } => edges.vertices.get(v as usize).copied().unwrap_or_default(),
        _ => [0.0; 2],
    };
    if feature < SECOND { plus(vertex(one, feature), apart) } else { vertex(other, feature - SECOND) }
}

/// Evaluates one point, tells of it and keeps it if it bears a force.
#[inline(always)]
fn act(
    scene: &Scene<'_>,
    law: &PairLaw,
    points: &mut Points,
    (second, feature, old): (u32, u32, Option<SavedPoint>),
    place: Place,
    met: &mut impl FnMut(Met<'_>),
) {
    if place.gap >= 0.0 && old.is_none() {
        return;
    }
    let (mass, mut spring) = match old {
        Some(point) => (point.mass, point.spring),
        None => (place.mass(scene.grains, scene.response), 0.0),
    };
    let Some(law) = law.at(mass) else { return };
    let (force, rate) = place.force(&law, (mass, old.is_none()), scene.kinematics, &mut spring);
    let bears = (old.is_some(), force != [0.0; 2]);
    met(Met::Point(&Acting { place, force, rate, bears }));
    if bears.1 {
        points.next.push(SavedPoint { first: place.first as u32, second, feature, spring, mass });
    }
}
