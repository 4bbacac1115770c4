//! Checks of the messages of a window: all values finite, counts and bounds kept.

use bedload_scene::{CheckedScene, Motion};
use protocol::message::{Header, Kinematics, Loads, Record, Status};
use protocol::participant::{Role, Window};

use crate::bounds::MOST_OVERLAP;
use crate::failure::Failure;

/// How far the length of a quaternion may be from one: what renormalising once in a while leaves.
const UNIT: f64 = 1e-3;

/// A message must be of a window that was ordered, with one record per grain.
pub(crate) fn belongs<R: Record>(
    window: Option<&Window>,
    header: &Header,
    records: &[R],
    grains: usize,
) -> Result<(), Failure> {
    if window.is_none_or(|window| (header.step, header.attempt) != (window.step, window.attempt)) {
        return Err(Failure::Run(format!(
            "{} of window {} attempt {} came, where {} was due: a solver does not keep the order of calls",
            R::NAME,
            header.step,
            header.attempt,
            window.map_or("none".to_owned(), |due| format!("window {} attempt {}", due.step, due.attempt))
        )));
    }
    if records.len() != grains {
        return Err(Failure::Run(format!(
            "{} of window {} are of {} grains; the scene has {grains}",
            R::NAME,
            header.step,
            records.len()
        )));
    }
    Ok(())
}

/// A report of a window must be of the one that is due, by a solver of these grains; that of a DEM must count
/// the sub-steps of the window, `before` being its count until then.
pub(crate) fn report_of(
    due: Option<Window>,
    role: Role,
    status: &Status,
    grains: usize,
    before: u64,
) -> Result<(), Failure> {
    let Some(due) = due else {
        let what = format!("the {role} solver reports window {}, which was not ordered", status.step);
        return Err(Failure::Run(what));
    };
    let substeps = if role == Role::Dem { before.wrapping_add(due.substeps) } else { status.substeps };
    for (field, value, wanted) in [
        ("step", status.step, due.step),
        ("attempt", status.attempt, due.attempt),
        ("grains", status.grains, grains as u64),
        ("substeps", status.substeps, substeps),
    ] {
        if value != wanted {
            return Err(Failure::Run(format!(
                "the {role} solver reports {field} = {value} after window {} (t = {} s), where {wanted} was due",
                due.step, due.time
            )));
        }
    }
    Ok(())
}

/// The loads must be numbers.
pub(crate) fn loads(window: &Window, loads: &[Loads]) -> Result<(), Failure> {
    for (grain, load) in loads.iter().enumerate() {
        let values = load.force.iter().chain(&load.torque).chain([&load.added_mass, &load.added_inertia]);
        finite("fluid", window, grain, load, values)?;
    }
    Ok(())
}

/// Headers must be of the window's time, and what they report must be numbers.
pub(crate) fn headers(window: &Window, loads: &Header, motion: &Header) -> Result<(), Failure> {
    for (solver, message, header) in [("fluid", "Loads", loads), ("dem", "Kinematics", motion)] {
        let refuse = |field: &str, value: f64, wanted: &str| {
            Err(Failure::Run(format!(
                "the {solver} solver sent {message} with {field} = {value} in the header of window {} (t = \
                 {} s), {wanted}",
                window.step, window.time
            )))
        };
        for (field, value, wanted) in [("time", header.time, window.time), ("dt", header.dt, window.dt)] {
            // A solver may compute them anew, and round.
            if (value - wanted).abs() > 1e-9 * (window.time.abs() + window.dt) || value.is_nan() {
                let what = format!("where {wanted} was ordered: it does not keep the coupler's time");
                return refuse(field, value, &what);
            }
        }
        let Header { smallest_gap, largest_overlap, .. } = *header;
        if smallest_gap.is_nan() {
            return refuse("smallest_gap", smallest_gap, "which is no number (infinite: nothing near)");
        }
        if !(largest_overlap >= 0.0 && largest_overlap.is_finite()) {
            return refuse("largest_overlap", largest_overlap, "allowed: a finite number ≥ 0");
        }
    }
    Ok(())
}

/// What the solvers report of a window must be numbers.
pub(crate) fn reports(window: &Window, fluid: &Status, dem: &Status) -> Result<(), Failure> {
    for (solver, status) in [("fluid", fluid), ("dem", dem)] {
        let Status { dt_limit, solver_s, exchange_s, residual, pressure_gradient, .. } = *status;
        let counted = |value: f64| value >= 0.0 && value.is_finite();
        for (field, value, good, allowed) in [
            ("dt_limit", dt_limit, dt_limit > 0.0, "a positive number, infinite where it does not care"),
            ("solver_s", solver_s, counted(solver_s), "a finite number ≥ 0"),
            ("exchange_s", exchange_s, counted(exchange_s), "a finite number ≥ 0"),
            ("residual", residual, counted(residual), "a finite number ≥ 0"),
            ("pressure_gradient", pressure_gradient, pressure_gradient.is_finite(), "a finite number"),
        ] {
            if !good {
                return Err(Failure::Run(format!(
                    "the {solver} solver reports {field} = {value} after window {} (t = {} s); allowed: {allowed}",
                    window.step, window.time
                )));
            }
        }
    }
    Ok(())
}

/// Directions must be of length one, grains in the box and held ones where they are held.
pub(crate) fn places(window: &Window, motion: &[Kinematics], scene: &CheckedScene) -> Result<(), Failure> {
    // Through other faces grains may leave.
    let domain = &scene.scene.domain;
    let (limits, open, periods) = (domain.limits(), domain.open_limits(), domain.periods());
    let refuse = |grain: usize, what: String| {
        Err(Failure::Run(format!(
            "the dem solver sent {what} of grain {grain} in window {} (t = {} s)",
            window.step, window.time
        )))
    };
    for (number, (now, grain)) in motion.iter().zip(&scene.grains).enumerate() {
        let length = now.orientation.iter().map(|part| part * part).sum::<f64>().sqrt();
        if (length - 1.0).abs() > UNIT {
            let what = format!("orientation = {:?}, of length {length}; allowed: 1", now.orientation);
            return refuse(number, what);
        }
        for (component, place) in now.position.into_iter().enumerate() {
            let [low, high] = limits[component];
            let (low, high) = (low - grain.radius, high + grain.radius);
            let [leaves_below, leaves_above] = open[component].map(f64::is_finite);
            if place.is_nan() || (place < low && !leaves_below) || (place > high && !leaves_above) {
                let what = format!(
                    "position[{component}] = {place}, outside the box, {low} to {high} with its radius,"
                );
                return refuse(number, what);
            }
        }
        let away = |c: usize| {
            let way = now.position[c] - grain.position[c];
            // An image is the same place.
            way - periods[c].map_or(0.0, |(_, length)| length * (way / length).round())
        };
        let strayed = (0..3).find(|c| away(*c).abs() > 1e-9 * grain.radius);
        if let Some(c) = strayed.filter(|_| grain.motion == Motion::Fixed) {
            let (is, was) = (now.position[c], grain.position[c]);
            return refuse(number, format!("position[{c}] = {is}, where the scene holds it at {was},"));
        }
    }
    Ok(())
}

/// The motion must be numbers, after as many sub-steps as were ordered.
pub(crate) fn motion(window: &Window, header: &Header, motion: &[Kinematics]) -> Result<(), Failure> {
    if header.substeps != window.substeps {
        return Err(Failure::Run(format!(
            "the dem solver did {} sub-steps in window {} where {} were ordered: it does not keep the coupler's time",
            header.substeps, window.step, window.substeps
        )));
    }
    for (grain, kinematics) in motion.iter().enumerate() {
        // The gap may be infinite, and is looked at below.
        let values = (kinematics.position.iter())
            .chain(&kinematics.orientation)
            .chain(&kinematics.velocity)
            .chain(&kinematics.spin)
            .chain(&kinematics.contact_force)
            .chain(&kinematics.lubrication_force)
            .chain([&kinematics.impact_speed, &kinematics.rebound_speed]);
        finite("dem", window, grain, kinematics, values)?;
        if kinematics.gap.is_nan() {
            return Err(Failure::Run(format!(
                "the dem solver sent gap = NaN of grain {grain} in window {} (t = {} s); allowed: a number, \
                 infinite where nothing is near",
                window.step, window.time
            )));
        }
    }
    Ok(())
}

fn finite<'a, R: Record>(
    solver: &str,
    window: &Window,
    grain: usize,
    record: &R,
    mut values: impl Iterator<Item = &'a f64>,
) -> Result<(), Failure> {
    if values.all(|value| value.is_finite()) {
        return Ok(());
    }
    let words = record.words();
    let bad = words.iter().position(|word| !f64::from_bits(*word).is_finite()).unwrap_or(0);
    Err(Failure::Run(format!(
        "the {solver} solver sent {} = {} of grain {grain} in window {} (t = {} s): the run has become \
         unstable; see the bounds of `bedload check`",
        R::field_of_word(bad),
        f64::from_bits(words[bad]),
        window.step,
        window.time
    )))
}

/// Grains must not sink into each other.
pub(crate) fn overlap(
    window: &Window,
    header: &Header,
    dem: &Status,
    largest_radius: f64,
    forced: &[String],
) -> Result<(), Failure> {
    // The DEM's own ratio if it gives one; else at least the overlap over the largest radius.
    let ratio = dem.residual.max(header.largest_overlap / largest_radius);
    if ratio <= MOST_OVERLAP || forced.iter().any(|name| name == "overlap") {
        return Ok(());
    }
    Err(Failure::Run(format!(
        "bound overlap: {:.1} % of a radius in window {} (t = {} s), at most 10 %: shorten the contact time, \
         or --set 'coupling.force=[\"overlap\"]'",
        100.0 * ratio,
        window.step,
        window.time
    )))
}

/// A fixed step must stay stable as the flow grows; says whether the solver's own limit is passed.
pub(crate) fn step_limit(
    window: &Window,
    limit: f64,
    reserve: f64,
    forced: &[String],
) -> Result<bool, Failure> {
    let passed = window.dt > limit * (1.0 + 1e-9);
    if window.dt > limit * reserve * (1.0 + 1e-9) && !forced.iter().any(|name| name == "cfl") {
        return Err(Failure::Run(format!(
            "bound cfl: dt = {} s after window {} (t = {} s), the solver accepts {limit} s: lower dt, make \
             it adaptive, or --set 'coupling.force=[\"cfl\"]'",
            window.dt, window.step, window.time
        )));
    }
    Ok(passed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window() -> Window {
        Window { step: 3, attempt: 0, time: 0.3, dt: 0.1, substeps: 10, output: false }
    }

    #[test]
    fn another_count_of_sub_steps_is_an_error_with_both_counts() {
        let good = Header { substeps: 10, ..window().header() };
        motion(&window(), &good, &[Kinematics::default()]).unwrap();
        let bad = Header { substeps: 9, ..window().header() };
        let text = motion(&window(), &bad, &[]).unwrap_err().to_string();
        assert!(text.contains("dem solver did 9") && text.contains("10 were ordered"), "{text}");
    }

    #[test]
    fn what_is_not_a_number_is_named_by_grain_and_field() {
        let mut sick = vec![Loads::default(); 3];
        sick[2].torque[1] = f64::NAN;
        let text = loads(&window(), &sick).unwrap_err().to_string();
        assert!(text.contains("torque[1]") && text.contains("grain 2") && text.contains("fluid"), "{text}");
        let header = Header { substeps: 10, ..window().header() };
        let far = Kinematics { gap: f64::INFINITY, ..Kinematics::default() };
        motion(&window(), &header, &[far]).expect("an infinite gap is an observation");
        let gone = Kinematics { velocity: [0.0, 0.0, f64::INFINITY], ..Kinematics::default() };
        let text = motion(&window(), &header, &[gone]).unwrap_err().to_string();
        assert!(text.contains("velocity[2]"), "{text}");
    }

    #[test]
    fn messages_of_another_window_or_count_are_refused() {
        let header = window().header();
        belongs(Some(&window()), &header, &[Loads::default()], 1).unwrap();
        assert!(belongs(Some(&window()), &header, &[Loads::default()], 2).is_err());
        let repeated = Header { attempt: 1, ..header };
        assert!(belongs(Some(&window()), &repeated, &[Loads::default()], 1).is_err());
        assert!(belongs(None, &header, &[Loads::default()], 1).is_err());
    }

    #[test]
    fn a_report_is_of_the_window_that_is_due_field_by_field() {
        let good = Status { step: 3, grains: 2, substeps: 25, ..Status::default() };
        let judged = |status: Status| report_of(Some(window()), Role::Dem, &status, 2, 15);
        judged(good).expect("ten sub-steps more");
        report_of(Some(window()), Role::Fluid, &Status { substeps: 7, ..good }, 2, 0)
            .expect("a fluid has none");
        for (field, status) in [
            ("step = 4", Status { step: 4, ..good }),
            ("attempt = 1", Status { attempt: 1, ..good }),
            ("grains = 3", Status { grains: 3, ..good }),
            ("substeps = 0", Status { substeps: 0, ..good }),
            ("substeps = 18446744073709551615", Status { substeps: u64::MAX, ..good }),
        ] {
            let text = judged(status).expect_err(field).to_string();
            assert!(text.contains(field) && text.contains("after window 3"), "{text}");
        }
        assert!(report_of(None, Role::Dem, &good, 2, 15).is_err());
    }

    #[test]
    fn overlap_and_step_limit_can_be_forced() {
        let status = |residual| Status { residual, ..Status::default() };
        let header = window().header();
        overlap(&window(), &header, &status(0.1), 1.0, &[]).unwrap();
        assert!(
            overlap(&window(), &header, &status(0.11), 1.0, &[]).unwrap_err().to_string().contains("overlap")
        );
        overlap(&window(), &header, &status(0.11), 1.0, &["overlap".into()]).unwrap();
        let deep = Header { largest_overlap: 0.3, ..header };
        assert!(overlap(&window(), &deep, &status(0.0), 2.0, &[]).is_err());
        assert!(!step_limit(&window(), 0.1, 1.0, &[]).unwrap());
        assert!(step_limit(&window(), 0.09, 1.5, &[]).unwrap(), "passed, but stable");
        assert!(step_limit(&window(), 0.05, 1.5, &[]).is_err());
        assert!(step_limit(&window(), 0.05, 1.5, &["cfl".into()]).unwrap());
    }
}
