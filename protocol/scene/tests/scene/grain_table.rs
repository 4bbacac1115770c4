//! Tables of grains, and what is wrong with them.

use bedload_scene::{CheckedScene, SceneSource};

/// Number of grains of a scene with this table, and what is to be known of it; or why it is refused.
fn read_text(name: &str, text: &str) -> Result<(usize, Vec<String>), String> {
    let file = std::env::temp_dir().join(format!("bedload-grains-{}-{name}.csv", std::process::id()));
    std::fs::write(&file, text).expect("written");
    let scene = format!(
        "until = 1.0\ngrain_files = [{{ file = {file:?} }}]\n[domain]\ngeometry = \"space\"\n\
         lower = [0, 0, 0]\nupper = [8, 8, 8]\n\
         boundary = {{ x = \"free-slip\", y = \"free-slip\", z = \"free-slip\" }}\n"
    );
    let read = CheckedScene::new(SceneSource { file: "s.toml".into(), text: scene });
    std::fs::remove_file(file).expect("removed");
    read.map(|scene| (scene.grains.len(), scene.notes)).map_err(|error| error.message)
}

#[test]
fn a_column_that_is_not_read_is_named() {
    let text = "id,x,y,z,radius,density,colour,\n0,1,1,1,0.5,2,red,\n";
    let (grains, notes) = read_text("colour", text).expect("read");
    assert_eq!((grains, notes.len()), (1, 1));
    assert!(notes[0].contains("not read: column `colour`;"), "{notes:?}");
    let (_, notes) = read_text("nameless", "x,y,z,radius,density,\n1,1,1,0.5,2,7\n").expect("read");
    assert!(notes[0].contains("not read: column 6 (without a name);"), "{notes:?}");
}

#[test]
fn a_column_under_another_name_or_twice_is_refused() {
    for (column, words) in [
        ("Vx", "`Vx` would not be read: name it vx"),
        ("u", "name it vx"),
        ("w", "name it vz"),
        ("v_x [m/s]", "name it vx"),
        ("Omega_y", "name it wy"),
        ("diameter", "name it radius, of half the value"),
        ("radius", "has the name of column 4: rename or remove"),
    ] {
        let text = format!("# a bed\nx,y,z,radius,density,{column}\n1,1,1,0.5,2,0\n");
        let why = read_text("names", &text).expect_err(column);
        assert!(why.contains(".csv:2: column 6 `") && why.contains(words), "{column}: {why}");
    }
}

#[test]
fn a_cell_past_the_last_column_is_refused_with_its_row() {
    let why = read_text("surplus", "x,y,z,radius,density\n1,1,1,0.5,2\n1,1,3,0.5,2,7\n").unwrap_err();
    assert!(why.contains(".csv:3: `7` in column 6 is past the last column, 5"), "{why}");
    assert!(read_text("blank", "x,y,z,radius,density\n1,1,1,0.5,2,\n").is_ok());
}

#[test]
fn a_number_that_cannot_be_is_named_with_its_row() {
    let rows = |radius: &str| format!("x,y,z,radius,density\n1,1,1,0.5,2\n1,1,3,{radius},2\n");
    for (radius, words) in [
        ("0", ".csv:3: column radius is 0; allowed: a finite number > 0"),
        (
            "2.0D-02",
            ".csv:3: `2.0D-02` in column radius is not a finite number: write the exponent with e, \
             2.0e-02",
        ),
    ] {
        let why = read_text("numbers", &rows(radius)).expect_err(radius);
        assert!(why.contains(words), "{why}");
    }
    for radius in ["nan", "1e400", "1D400"] {
        let why = read_text("numbers", &rows(radius)).expect_err(radius);
        assert!(why.ends_with("in column radius is not a finite number"), "{why}");
    }
}

#[test]
fn a_remark_is_a_remark_and_a_count_a_count() {
    let rows = "x,y,z,radius,density\n1,1,1,0.5,2\n";
    for remark in ["# grains: 32 of glass", "# not round: none of them", "# grains: 1"] {
        assert!(read_text("remark", &format!("{remark}\n{rows}")).is_ok(), "{remark}");
    }
    let why = read_text("count", &format!("# grains: 2\n{rows}")).unwrap_err();
    assert!(why.contains("says that it holds 2 grains, but has 1"), "{why}");
}
