//! The cheapest setting of a chart that is exact enough.

use super::charted::Run;

/// The cheapest run whose error is at most `target`, and stays so in every finer run of those that differ from it in fineness alone: an error that is small
/// by chance does not count, nor does a run that no other one stands by. Else the least error of such a run.
pub(super) fn cheapest(runs: &[Run], target: f64) -> Result<&Run, f64> {
    let alike = |run: &Run| runs.iter().filter(|other| other.others == run.others).collect::<Vec<_>>();
    let worst = |run: &Run| {
        let alike = alike(run);
        let finer = alike.iter().filter(|other| other.fineness >= run.fineness);
        let worst = finer.map(|other| other.error).fold(run.error, f64::max);
        if alike.len() > 1 { worst } else { f64::INFINITY }
    };
    let enough = runs.iter().filter(|run| worst(run) <= target);
    let best = || runs.iter().map(worst).fold(f64::INFINITY, f64::min);
    enough.min_by(|a, b| a.cost.total_cmp(&b.cost)).ok_or_else(best)
}

#[cfg(test)]
mod tests {
    use super::super::made::measured;
    use super::*;

    #[test]
    fn the_cheapest_that_is_exact_enough_among_all_finer_ones_is_taken() {
        let line = |text: &str| text.split(',').map(str::to_owned).collect::<Vec<_>>();
        let header = line("method,resolution,cpu_s,error,label");
        let rows = [
            "good,5,2.0,0.03,a",
            "good,8,4.0,0.01,b",
            "good,16,9.0,0.004,c",
            "lucky,5,1.0,0.2,d",
            "lucky,8,1.5,0.001,e",
            "lucky,16,3.0,0.3,f",
            "alone,8,0.5,0.001,h",
            "broken,8,1.0,,g",
            "good,32,20.0,0,the reference",
        ];
        let rows = measured(&header, &rows.map(line)).unwrap();
        assert_eq!(rows.len(), 7);
        assert_eq!(cheapest(&rows, 0.05).unwrap().label, "a");
        assert_eq!(cheapest(&rows, 0.02).unwrap().label, "b");
        assert_eq!(cheapest(&rows, 0.001), Err(0.004));
        assert!(measured(&line("x,error,label"), &[]).unwrap_err().contains("cpu_s"));
    }
}
