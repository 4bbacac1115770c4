//! Wrong scenes: each is answered with file, line, key, what is wrong and what to do, never a panic.

mod bases;
mod cases;
mod elsewhere;
mod programs;

use bases::{AXIS, PLANE, SPACE};
use bedload_scene::{CheckedScene, SceneError, SceneSource};
use coupler::config::Coupling;
use coupler::plan::{Participants, Plan};
use dem_solver::config::Config;

/// Marks the place in a replacement on whose line the error must stand.
const MARK: char = '§';

/// One wrong scene.
struct Case {
    name: &'static str,
    /// Text of the base that is replaced, and what stands there instead.
    change: &'static [(&'static str, &'static str)],
    key: &'static str,
    /// Words of the message.
    words: &'static [&'static str],
}

/// Everything that `bedload check` asks of a scene, in its order, without processes.
fn plan(text: &str) -> Result<Plan, SceneError> {
    let source = SceneSource { file: "wrong.toml".into(), text: text.into() };
    let scene = CheckedScene::new(source.with_overrides(&[])?)?;
    let coupling = Coupling::read(&scene)?;
    let participants = Participants::of(&scene);
    let fluid = if participants.has_fluid() { Some(fluid_solver::facts::facts(&scene)?) } else { None };
    let dem = if participants.has_dem() { Some(Config::new(&scene)?.facts) } else { None };
    Plan::new(&scene, &coupling, fluid.as_ref(), dem.as_ref(), None)
}

/// The base with its changes; each must fit exactly once.
fn changed(base: &str, case: &Case) -> String {
    case.change.iter().fold(base.to_owned(), |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "{}: `{from}` must stand in the base once", case.name);
        text.replacen(from, to, 1)
    })
}

/// Line of the mark, from 1; 0 without one: the fault has no place.
fn expected_line(text: &str) -> usize {
    text.lines().position(|line| line.contains(MARK)).map_or(0, |line| line + 1)
}

/// What the case gives wrong, or nothing.
fn complaint(base: &str, case: &Case) -> Option<String> {
    let text = changed(base, case);
    let line = expected_line(&text);
    let error = match plan(&text.replace(MARK, "")) {
        Err(error) => error,
        Ok(_) => return Some(format!("{}: was accepted", case.name)),
    };
    let missing: Vec<_> = case.words.iter().filter(|word| !error.message.contains(**word)).collect();
    let right = error.file == "wrong.toml"
        && error.line == line
        && error.key == case.key
        && !error.remedy.trim().is_empty()
        && error.span.end <= error.text.len()
        && missing.is_empty();
    let wanted = format!("wrong.toml:{line}: {} … {:?}", case.key, case.words);
    (!right)
        .then(|| format!("{}:\n  wanted {wanted}\n  got    {error}\n  remedy {}", case.name, error.remedy))
}

fn check_all(base: &str, cases: &[Case]) {
    if let Err(error) = plan(base) {
        panic!("the base must be right: {error}");
    }
    let complaints: Vec<String> = cases.iter().filter_map(|case| complaint(base, case)).collect();
    assert!(complaints.is_empty(), "{} of {}:\n{}", complaints.len(), cases.len(), complaints.join("\n"));
}

#[test]
fn wrong_keys_and_types() {
    check_all(SPACE, cases::KEYS);
}

#[test]
fn wrong_boxes_and_fluids() {
    check_all(SPACE, cases::BOXES);
}

#[test]
fn wrong_grains_and_walls() {
    check_all(SPACE, cases::GRAINS);
}

#[test]
fn wrong_sections_of_the_solvers() {
    check_all(SPACE, cases::SECTIONS);
}

#[test]
fn wrong_observations() {
    check_all(SPACE, cases::OBSERVATIONS);
}

#[test]
fn wrong_on_an_axis_and_in_a_plane() {
    check_all(AXIS, cases::ON_AN_AXIS);
    check_all(PLANE, cases::IN_A_PLANE);
}

#[test]
fn every_case_has_a_name_of_its_own_and_there_are_enough() {
    let all = [
        cases::KEYS,
        cases::BOXES,
        cases::GRAINS,
        cases::SECTIONS,
        cases::OBSERVATIONS,
        cases::ON_AN_AXIS,
        cases::IN_A_PLANE,
    ];
    let mut names: Vec<&str> = all.iter().flat_map(|cases| cases.iter()).map(|case| case.name).collect();
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), count, "two cases with one name");
    assert!(count >= 45, "{count}");
}

/// Text cut at any byte, or with any line gone, is answered or accepted, never a panic.
#[test]
fn mutilated_scenes_never_panic() {
    for base in [SPACE, AXIS, PLANE] {
        for (end, _) in base.char_indices().step_by(7) {
            let _ = plan(&base[..end]);
        }
        let lines: Vec<&str> = base.lines().collect();
        for gone in 0..lines.len() {
            let rest: Vec<&str> =
                lines.iter().enumerate().filter(|(line, _)| *line != gone).map(|(_, line)| *line).collect();
            if let Err(error) = plan(&rest.join("\n")) {
                assert!(!error.message.is_empty() && !error.remedy.is_empty(), "without line {}", gone + 1);
            }
        }
    }
}
