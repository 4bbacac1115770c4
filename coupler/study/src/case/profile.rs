//! Two columns of a table that runs left: those of one run, or their mean over several.

use std::path::Path;

use super::compare::mean;
use crate::folder::{columns, content};
use crate::make::Made;
use crate::plot::{Bars, Point};
use crate::section::matches;
use coupler::failure::Failure;

/// Points, in the order of the table, with the standard errors of a mean.
pub(super) type Profile = (Vec<Point>, Bars);

/// The columns `x` and `y` of `file`, of every run that a pattern means and that was made; none if there is
/// no such run. Of several, one column is the same in all, and the other is averaged.
pub(super) fn profile(
    made: &Made<'_>,
    pattern: &str,
    file: &Path,
    x: &str,
    y: &str,
) -> Result<Option<Profile>, Failure> {
    let runs = made.results().filter(|(run, _)| matches(pattern, &run.label));
    let path = |label: &String| made.folder.join(label).join(file);
    let tables = runs.map(|(run, _)| columns(&path(&run.label), x, y)).collect::<Result<Vec<_>, _>>()?;
    match &tables[..] {
        [] => Ok(None),
        [one] => Ok(Some((one.clone(), Bars::None))),
        several => averaged(several).map(Some).ok_or_else(|| {
            let what = format!("neither {x} nor {y} is the same in all runs {pattern}: no mean over them");
            content(file)(what)
        }),
    }
}

fn averaged(tables: &[Vec<Point>]) -> Option<Profile> {
    let (first, others) = tables.split_first()?;
    let shared = |of: fn(&Point) -> f64| {
        let same = |other: &Vec<Point>| other.iter().map(of).eq(first.iter().map(of));
        others.iter().all(same)
    };
    let over = |of: fn(&Point) -> f64| -> (Vec<f64>, Vec<f64>) {
        let row = |row| mean(&tables.iter().map(|table| of(&table[row])).collect::<Vec<_>>());
        (0..first.len()).map(row).map(|(mean, error)| (mean, error.unwrap_or(0.0))).unzip()
    };
    if shared(|(x, _)| *x) {
        let (means, errors) = over(|(_, y)| *y);
        Some((first.iter().map(|(x, _)| *x).zip(means).collect(), Bars::Upright(errors)))
    } else if shared(|(_, y)| *y) {
        let (means, errors) = over(|(x, _)| *x);
        Some((means.into_iter().zip(first.iter().map(|(_, y)| *y)).collect(), Bars::Level(errors)))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_column_that_differs_is_averaged() {
        let [a, b] = [vec![(1.0, 10.0), (4.0, 20.0)], vec![(3.0, 10.0), (4.0, 20.0)]];
        let level = averaged(&[a.clone(), b.clone()]);
        assert_eq!(level, Some((vec![(2.0, 10.0), (4.0, 20.0)], Bars::Level(vec![1.0, 0.0]))));
        let turned = |table: Vec<Point>| table.into_iter().map(|(x, y)| (y, x)).collect::<Vec<_>>();
        let upright = averaged(&[turned(a.clone()), turned(b)]);
        assert_eq!(upright, Some((vec![(10.0, 2.0), (20.0, 4.0)], Bars::Upright(vec![1.0, 0.0]))));
        // other places, and fewer of them
        assert_eq!(averaged(&[a.clone(), vec![(3.0, 11.0), (4.0, 20.0)]]), None);
        assert_eq!(averaged(&[a, vec![(3.0, 10.0)]]), None);
    }
}
