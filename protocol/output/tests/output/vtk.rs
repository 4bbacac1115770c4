//! Files for viewers of VTK.

use bedload_output::vtk::{Array, list, points};

#[test]
fn offsets_point_at_the_blocks() {
    let bytes = points(0.5, vec![1.0, 2.0, 3.0], &[Array::scalar("radius", vec![0.25])]);
    let text = String::from_utf8_lossy(&bytes);
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let start = bytes.windows(mark.len()).position(|window| window == mark).unwrap() + mark.len();
    let real = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    assert!(text.contains("Name=\"radius\" NumberOfComponents=\"1\" format=\"appended\" offset=\"0\""));
    assert_eq!(u64::from_le_bytes(bytes[start..start + 8].try_into().unwrap()), 8);
    assert_eq!(real(start + 8), 0.25);
    assert!(text.contains("offset=\"16\"") && real(start + 24) == 1.0 && real(start + 40) == 3.0);
}

#[test]
fn the_list_is_in_order_of_time_and_names_each_file_once() {
    let path = std::env::temp_dir().join(format!("bedload-list-{}.pvd", std::process::id()));
    let _ = std::fs::remove_file(&path);
    for (time, name) in [(0.2, "b.vtp"), (0.1, "a.vtp"), (0.3, "b.vtp")] {
        list(&path, time, name).unwrap();
    }
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let (a, b) = (text.find("a.vtp").unwrap(), text.find("b.vtp").unwrap());
    assert!(a < b && text.matches("b.vtp").count() == 1 && text.contains("timestep=\"3e-1\""));
}
