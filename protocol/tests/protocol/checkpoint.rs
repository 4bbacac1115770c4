//! Files of checkpoints that are damaged, or of another scene.

use protocol::checkpoint::{path, read, write};

#[test]
fn damaged_and_foreign_files_are_refused() {
    let folder = std::env::temp_dir().join(format!("bedload-checkpoint-{}", std::process::id()));
    let state = vec![1.0f64, -0.0, 3.5];
    write(&folder, "dem", "scene-a", &state).expect("writes");
    let back: Vec<f64> = read(&folder, "dem", "scene-a").expect("reads");
    assert_eq!(
        back.iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
        state.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
    );
    assert!(
        read::<Vec<f64>>(&folder, "dem", "scene-b")
            .expect_err("foreign")
            .to_string()
            .contains("another scene")
    );
    assert!(read::<Vec<f64>>(&folder, "fluid", "scene-a").is_err());
    let whole = std::fs::read(path(&folder, "dem")).expect("there");
    for end in 0..whole.len() {
        std::fs::write(path(&folder, "dem"), &whole[..end]).expect("writes");
        assert!(read::<Vec<f64>>(&folder, "dem", "scene-a").is_err(), "cut at {end}");
    }
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 4;
        std::fs::write(path(&folder, "dem"), &bytes).expect("writes");
        assert!(read::<Vec<f64>>(&folder, "dem", "scene-a").is_err(), "flipped at {at}");
    }
    std::fs::remove_dir_all(&folder).expect("removes");
}
