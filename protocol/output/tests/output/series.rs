//! `series.csv`: columns, round trip to the bit, rhythm, resumption.

use std::path::Path;

use bedload_output::{Columns, OutputError, Series, SeriesMark, SeriesWriter, Sides};
use protocol::message::{Header, Kinematics, Loads};

use crate::stage::{Watch, discs, falling, fresh, sphere};

fn names(columns: &[&str]) -> Vec<String> {
    columns.iter().map(|name| (*name).to_owned()).collect()
}

fn write(path: &Path, every: f64, rows: &[[f64; 2]]) {
    let mut writer = SeriesWriter::create(path, &names(&["t", "x"]), every).expect("creates");
    for row in rows {
        writer.record(row).expect("writes");
    }
    writer.flush().expect("flushes");
}

#[test]
fn every_number_reads_back_to_the_same_bits() {
    let path = fresh("bits").join("series.csv");
    let mut values = vec![
        0.0,
        -0.0,
        1.0,
        0.1,
        1.0 / 3.0,
        f64::MAX,
        f64::MIN_POSITIVE,
        5e-324,
        -1e300,
        1e16,
        12345678.9,
        f64::INFINITY,
        f64::NEG_INFINITY,
    ];
    // A fixed sequence over all exponents.
    let mut bits = 0x0123_4567_89ab_cdefu64;
    for _ in 0..2000 {
        bits = bits.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        values.push(f64::from_bits(bits));
    }
    let rows: Vec<[f64; 2]> =
        values.iter().filter(|x| !x.is_nan()).enumerate().map(|(i, x)| [i as f64, *x]).collect();
    write(&path, 0.0, &rows);
    let series = Series::read(&path).expect("reads");
    assert_eq!(series.len(), rows.len());
    for (read, row) in series.column("x").expect("x").iter().zip(&rows) {
        assert_eq!(read.to_bits(), row[1].to_bits());
    }
    assert!(std::fs::read_to_string(&path).expect("text").lines().all(|line| line.len() < 60));
}

#[test]
fn nan_stays_nan_and_an_empty_cell_is_nan() {
    let series = Series::parse("t,x\n0,NaN\n1,\n").expect("reads");
    assert!(series.column("x").expect("x").iter().all(|x| x.is_nan()));
}

#[test]
fn rows_come_once_a_period() {
    let path = fresh("rhythm").join("series.csv");
    // Windows of 0.1 s whose sums do not hit 0.3, 0.6 … exactly.
    let mut t = 0.0;
    let rows: Vec<[f64; 2]> = (0..30)
        .map(|_| {
            t += 0.1;
            [t, 0.0]
        })
        .collect();
    write(&path, 0.3, &rows);
    let times: Vec<f64> = Series::read(&path).expect("reads").time().to_vec();
    assert_eq!(times.len(), 10);
    assert!(times.iter().enumerate().all(|(i, t)| (t - 0.3 * (i + 1) as f64).abs() < 1e-9), "{times:?}");
}

/// The file of six rows, and the mark after each number of rows.
fn marked(path: &std::path::Path) -> (Vec<[f64; 2]>, Vec<SeriesMark>) {
    let rows: Vec<[f64; 2]> = (1..=6).map(|i| [0.5 * f64::from(i), f64::from(i)]).collect();
    let mut writer = SeriesWriter::create(path, &names(&["t", "x"]), 0.5).expect("creates");
    let mut marks = vec![writer.mark().expect("marks")];
    for row in &rows {
        assert!(writer.record(row).expect("writes"));
        marks.push(writer.mark().expect("marks"));
    }
    (rows, marks)
}

#[test]
fn resuming_cuts_rows_after_the_checkpoint_and_a_torn_one() {
    let path = fresh("resume").join("series.csv");
    let (rows, marks) = marked(&path);
    let whole = std::fs::read(&path).expect("whole");
    let mut torn = whole.clone();
    torn.extend(b"3.5,7.");
    for (killed, done) in [(torn.clone(), 6), (torn, 3), (whole.clone(), 0)] {
        std::fs::write(&path, killed).expect("as killed");
        let mut writer =
            SeriesWriter::resume(&path, &names(&["t", "x"]), 0.5, &marks[done]).expect("resumes");
        for row in &rows[done..] {
            assert!(writer.record(row).expect("writes"), "row at {}", row[0]);
        }
        assert_eq!(&writer.mark().expect("marks"), &marks[6], "as without a resume");
        assert_eq!(std::fs::read(&path).expect("resumed"), whole);
    }
}

#[test]
fn resuming_a_file_that_was_altered_or_cut_is_refused() {
    let path = fresh("altered").join("series.csv");
    let (_, marks) = marked(&path);
    let whole = std::fs::read_to_string(&path).expect("whole");
    let first = &whole[..whole.len() / 2];
    for (altered, word) in [
        (whole.replace("1.5,3", "1.5,4"), "another text"),
        (first.to_owned(), "shorter"),
        (String::new(), "columns"),
    ] {
        std::fs::write(&path, &altered).expect("altered");
        let error = SeriesWriter::resume(&path, &names(&["t", "x"]), 0.5, &marks[5]).expect_err("altered");
        assert!(error.to_string().contains(word), "{word}: {error}");
        assert_eq!(std::fs::read_to_string(&path).expect("unharmed"), altered);
    }
}

#[test]
fn resuming_other_columns_is_refused() {
    let path = fresh("other").join("series.csv");
    let (_, marks) = marked(&path);
    let error = SeriesWriter::resume(&path, &names(&["t", "y"]), 0.0, &marks[2]).expect_err("other columns");
    assert!(error.to_string().contains("columns"), "{error}");
    assert_eq!(Series::read(&path).expect("unharmed").len(), 6);
}

#[test]
fn a_file_that_is_removed_under_the_writer_is_missed() {
    let path = fresh("removed").join("series.csv");
    let mut writer = SeriesWriter::create(&path, &names(&["t"]), 0.0).expect("creates");
    writer.record(&[1.0]).expect("writes");
    std::fs::remove_file(&path).expect("removed");
    assert!(matches!(writer.flush(), Err(OutputError::Gone(_))));
    std::fs::write(&path, "t\n").expect("another");
    assert!(matches!(writer.mark(), Err(OutputError::Gone(_))));
}

#[test]
fn a_torn_last_row_is_left_out_and_a_bad_cell_is_named() {
    assert_eq!(Series::parse("t,x\n1,2\n3,4").expect("reads").len(), 1);
    let error = Series::parse("t,x\n1,2\n3,four\n").expect_err("no number");
    assert!(error.contains("line 3") && error.contains("four"), "{error}");
    let error = Series::parse("t,x\n1\n").expect_err("short row");
    assert!(error.contains("line 2"), "{error}");
}

#[test]
fn names_with_commas_and_quotes_survive() {
    let path = fresh("quotes").join("series.csv");
    let odd = names(&["t", "a,b", "say \"x\""]);
    SeriesWriter::create(&path, &odd, 0.0).expect("creates").flush().expect("flushes");
    assert_eq!(Series::read(&path).expect("reads").names(), odd);
}

#[test]
fn columns_follow_the_geometry() {
    let axis = Columns::new(&sphere(""), Sides::coupled());
    assert_eq!(
        axis.names(),
        [
            "t",
            "dt",
            "substeps",
            "smallest_gap",
            "largest_overlap",
            "kinetic_energy",
            "position_z[0]",
            "velocity_z[0]",
            "hydrodynamic_force_z[0]",
            "contact_force_z[0]",
            "lubrication_force_z[0]",
            "gap[0]"
        ]
    );
    let plane = Columns::new(&discs("[observe]\ngrains = [1]\n"), Sides::dry());
    assert_eq!(
        plane.names(),
        [
            "t",
            "dt",
            "substeps",
            "smallest_gap",
            "largest_overlap",
            "kinetic_energy",
            "run_out",
            "height",
            "position_x[1]",
            "position_z[1]",
            "velocity_x[1]",
            "velocity_z[1]",
            "spin_y[1]",
            "contact_force_x[1]",
            "contact_force_z[1]",
            "lubrication_force_x[1]",
            "lubrication_force_z[1]",
            "gap[1]"
        ]
    );
    let fluid = Columns::new(&sphere(""), Sides::fluid_alone(false));
    assert_eq!(fluid.names(), ["t", "dt", "hydrodynamic_force_z[0]"]);
}

#[test]
fn a_row_holds_the_window() {
    let mut watch = Watch::new(&discs("[observe]\ngrains = [1]\n"), 0.25);
    let header = Header { substeps: 12, smallest_gap: 0.5, largest_overlap: 0.01, ..Header::default() };
    let moving = Kinematics {
        position: [3.0, 0.0, 2.0],
        velocity: [3.0, 0.0, 4.0],
        spin: [0.0, 2.0, 0.0],
        ..Kinematics::default()
    };
    let other = Kinematics { position: [8.0, 0.0, 1.0], gap: 0.75, ..Kinematics::default() };
    let loads = [Loads::default(), Loads { force: [1.0, 2.0, 3.0], ..Loads::default() }];
    let row = watch.feed_all(&loads, &header, &[moving, other], &[]);
    let value = |name: &str| row[watch.columns.find(name).unwrap_or_else(|| panic!("no {name}")).0];
    assert_eq!([value("t"), value("dt"), value("substeps")], [0.25, 0.25, 12.0]);
    assert_eq!([value("smallest_gap"), value("largest_overlap"), value("gap[1]")], [0.5, 0.01, 0.75]);
    assert_eq!([value("hydrodynamic_force_x[1]"), value("hydrodynamic_force_z[1]")], [1.0, 3.0]);
    // Disc of mass 2π: ½·2π·25 + ½·(½·2π)·4.
    let energy = 27.0 * std::f64::consts::PI;
    assert!((value("kinetic_energy") - energy).abs() < 1e-12);
    // Foremost surface from 6.5 to 8.5; topmost at 3 over a floor at −1.
    assert_eq!([value("run_out"), value("height")], [2.0, 4.0]);
}

#[test]
fn a_force_and_the_mean_velocity_of_its_window_are_of_one_time() {
    // A drag of −2 v on a grain that is led: the force of a row is its mean over the window.
    let (dt, rate) = (0.1, 2.0_f64);
    let mut watch = Watch::new(&sphere("[observe]\nmean_velocity = true\n"), dt);
    let place = |watch: &Watch, name: &str| watch.columns.find(name).unwrap_or_else(|| panic!("no {name}")).0;
    let places =
        ["mean_velocity_z[0]", "velocity_z[0]", "hydrodynamic_force_z[0]"].map(|name| place(&watch, name));
    // Σ e^{iωt} of each, at the time of the row, over ten periods less the first window.
    let mut sums = [[0.0; 2]; 3];
    for step in 0..=314 {
        let (start, t) = (f64::from(step) * dt, f64::from(step + 1) * dt);
        let force = -2.0 * ((rate * start).cos() - (rate * t).cos()) / (rate * dt);
        let loads = [Loads { force: [0.0, 0.0, force], ..Loads::default() }];
        let row = watch.feed_all(&loads, &Header::default(), &[falling((rate * t).sin(), 1.0)], &[]);
        assert_eq!(row[places[0]].is_nan(), step == 0, "of the first window one end alone is known");
        if step > 0 {
            for (sum, place) in sums.iter_mut().zip(places) {
                sum[0] += row[place] * (rate * t).cos();
                sum[1] += row[place] * (rate * t).sin();
            }
        }
    }
    let [mean, end, force] = sums.map(|[cosine, sine]| cosine.atan2(sine));
    let lag = |phase: f64| (phase + std::f64::consts::PI - force).rem_euclid(std::f64::consts::TAU);
    assert!(lag(mean) < 1e-12 || lag(mean) > std::f64::consts::TAU - 1e-12, "{}", lag(mean));
    assert!((lag(end) - 0.5 * rate * dt).abs() < 5e-3, "{}", lag(end));
}
