//! Files that a scene names, seen from any folder.

use std::path::PathBuf;

use bedload_scene::SceneSource;

#[test]
fn every_file_is_looked_up_from_the_scene_and_all_else_stays() {
    let text = "# a bed\nuntil = 1.0\ngrain_files = [{ file = \"a.csv\" }]\n[[metrics]] # one\nname = \"u\"\n\
                file = \"../b.csv\" # here\n[[metrics]]\nname = \"n\"\nfile = \"/c.csv\"\n\
                [dem]\ninitial_state = \"runs/d\"\ncommand = [\"bin/dem\", \"-q\", \"no-file\"]\n\
                [fluid]\ncommand = [\"fluid\"]\n\
                [medium]\ninitial = { type = \"run\", folder = \"runs/f\" }\n\
                [[grains]]\nvelocity = { file = \"v.csv\" }\n[grains.spin]\nfile = \"w.csv\"\n\
                [[walls]]\nservo = { pressure = { file = \"p.csv\" } }\n";
    let source = SceneSource { file: "/scenes/s.toml (with --set)".into(), text: text.into() };
    let expected = text
        .replace("a.csv", "/scenes/a.csv")
        .replace("../b.csv", "/b.csv")
        .replace("runs/d", "/scenes/runs/d")
        .replace("runs/f", "/scenes/runs/f")
        .replace("bin/dem", "/scenes/bin/dem")
        .replace("v.csv", "/scenes/v.csv")
        .replace("w.csv", "/scenes/w.csv")
        .replace("p.csv", "/scenes/p.csv");
    assert_eq!(source.text_for_any_folder(), expected);
    let files = source.files();
    assert_eq!(files.len(), 8);
    assert!(files.contains(&("dem.initial_state", PathBuf::from("/scenes/runs/d"))), "{files:?}");
    let again = SceneSource { file: "/other/s.toml".into(), text: expected.clone() };
    assert_eq!(again.text_for_any_folder(), expected);
}

#[test]
fn a_word_of_a_command_is_a_path_if_the_file_is_there() {
    let folder = std::env::temp_dir().join(format!("bedload-files-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("my-dem.py"), "").unwrap();
    let text = "[dem]\ncommand = [\"python3\", \"my-dem.py\", \"other.py\"]\n".to_owned();
    let file = folder.join("s.toml").display().to_string();
    let found = SceneSource { file, text: text.clone() }.text_for_any_folder().into_owned();
    std::fs::remove_dir_all(&folder).unwrap();
    let path = folder.join("my-dem.py").display().to_string();
    assert_eq!(found, text.replace("my-dem.py", &path));
}
