//! The cheapest setting of a chart that is exact enough.

use super::charted::Run;

/// A setting: what the runs of several cases share.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Setting<'a> {
    /// The run of it that errs the most.
    pub(super) worst: &'a Run,
    /// CPU time of all its runs, s.
    cost: f64,
    /// Cases that were run with it.
    cases: usize,
}

/// The settings of these runs.
fn settings<'a>(runs: &[&'a Run]) -> Vec<Setting<'a>> {
    let mut settings: Vec<Setting<'a>> = Vec::new();
    for run in runs {
        let alike = |setting: &&mut Setting<'_>| {
            setting.worst.fineness == run.fineness && setting.worst.others == run.others
        };
        match settings.iter_mut().find(alike) {
            Some(setting) => {
                setting.cost += run.cost;
                setting.cases += 1;
                if run.error > setting.worst.error {
                    setting.worst = run;
                }
            }
            None => settings.push(Setting { worst: run, cost: run.cost, cases: 1 }),
        }
    }
    // What failed or was refused in a case has no run there, and promises nothing.
    let all = settings.iter().map(|setting| setting.cases).max().unwrap_or(0);
    settings.retain(|setting| setting.cases == all);
    settings
}

/// The cheapest setting whose error in each of the cases is at most `target`, and stays so in every finer one
/// that differs in fineness alone: an error that is small by chance does not count, nor does a setting that
/// no other one stands by. Else the least error of such a setting.
pub(super) fn cheapest<'a>(runs: &[&'a Run], target: f64) -> Result<Setting<'a>, f64> {
    let settings = settings(runs);
    let alike = |setting: &Setting<'_>| {
        let others = settings.iter().filter(|other| other.worst.others == setting.worst.others);
        others.cloned().collect::<Vec<_>>()
    };
    let worst = |setting: &Setting<'_>| {
        let alike = alike(setting);
        let finer = alike.iter().filter(|other| other.worst.fineness >= setting.worst.fineness);
        let worst = finer.map(|other| other.worst.error).fold(setting.worst.error, f64::max);
        if alike.len() > 1 { worst } else { f64::INFINITY }
    };
    let enough = settings.iter().filter(|setting| worst(setting) <= target);
    let best = || settings.iter().map(worst).fold(f64::INFINITY, f64::min);
    enough.min_by(|a, b| a.cost.total_cmp(&b.cost)).cloned().ok_or_else(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run from `METHOD,D/Δx,COST,ERROR,LABEL`.
    fn run(text: &str) -> Run {
        let cells: Vec<&str> = text.split(',').collect();
        let number = |place: usize| cells[place].parse().unwrap();
        Run {
            label: cells[4].to_owned(),
            cost: number(2),
            error: number(3),
            fineness: number(1),
            others: vec![cells[0].to_owned()],
            ..Run::default()
        }
    }

    #[test]
    fn the_cheapest_that_is_exact_enough_among_all_finer_ones_is_taken() {
        let rows = [
            "good,5,2.0,0.03,a",
            "good,8,4.0,0.01,b",
            "good,16,9.0,0.004,c",
            "lucky,5,1.0,0.2,d",
            "lucky,8,1.5,0.001,e",
            "lucky,16,3.0,0.3,f",
            "alone,8,0.5,0.001,h",
        ]
        .map(run);
        let rows: Vec<&Run> = rows.iter().collect();
        assert_eq!(cheapest(&rows, 0.05).unwrap().worst.label, "a");
        assert_eq!(cheapest(&rows, 0.02).unwrap().worst.label, "b");
        assert_eq!(cheapest(&rows, 0.001), Err(0.004));
    }

    #[test]
    fn a_setting_is_as_exact_as_in_its_worst_case_and_must_have_run_in_all() {
        // Two cases, and a setting that was run in one of them.
        let rows = [",8,1,0.01,a", ",16,8,0.002,b", ",8,1,0.05,c", ",16,8,0.01,d", ",32,60,0.001,e"].map(run);
        let rows: Vec<&Run> = rows.iter().collect();
        assert_eq!(cheapest(&rows, 0.05).unwrap().worst.label, "c");
        assert_eq!(cheapest(&rows, 0.02).unwrap().worst.label, "d");
        assert_eq!(cheapest(&rows, 0.005), Err(0.01));
    }
}
