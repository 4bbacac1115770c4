//! Grains in a fluid that several ranks share: the same bits whatever their number.

use crate::immersed::newton::{Run, scene};
use crate::immersed::restart::{folder, messages};
use bedload_output::vtk;
use fluid_solver::follow::follow;
use fluid_solver::orders::dismiss;
use fluid_solver::participant::Fluid;
use fluid_solver::ranks::{Ranks, threads};
use protocol::participant::{Participant, Window};
use std::path::Path;

/// Spheres that cross from slab to slab and, along z, the ends of a periodic box.
fn text(ends: &str, motion: &str, keys: &str) -> String {
    let [first, second] = match motion {
        "fixed" => ["", ""],
        _ => ["velocity = [0.0, 0.2, -0.6]", "velocity = [0.0, 0.0, 0.4]\n        spin = [0.0, 1.0, 0.5]"],
    };
    format!(
        "until = 1.0
        gravity = [0.3, 0.0, -1.0]
        [domain]
        geometry = \"space\"
        lower = [0.0, 0.0, 0.0]
        upper = [2.0, 2.0, 3.0]
        cells = [32, 32, 48]
        boundary = {{ x = \"periodic\", y = \"periodic\", z = \"{ends}\" }}
        [medium]
        density = 1.0
        viscosity = 0.05
        body_force = [0.2, 0.0, 0.0]
        [[grains]]
        position = [0.5, 0.5, 0.45]
        {first}
        radius = 0.35
        density = 2.0
        motion = \"{motion}\"
        [[grains]]
        position = [0.6, 1.4, 1.5]
        {second}
        radius = 0.4
        density = 2.5
        motion = \"{motion}\"
        [[grains]]
        position = [1.5, 0.9, 2.55]
        radius = 0.4
        density = 2.0
        motion = \"{motion}\"
        [fluid]
        launcher = [\"mpirun\", \"-np\", \"1\"]
        {keys}
        "
    )
}

/// What `task` makes of a run whose fluid `size` ranks share.
pub(crate) fn shared<R: Send>(
    text: &str,
    size: usize,
    folder: &Path,
    task: impl Fn(&mut Run) -> R + Sync,
) -> R {
    let found = threads::together(size, |ranks| {
        if !ranks.is_first() {
            follow(&ranks).expect("the first rank says when it ends");
            return None;
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1 + size % 2).build().expect("a pool");
        let found = pool.install(|| task(&mut Run::with_ranks(text, &ranks, folder)));
        dismiss(&ranks).expect("all live");
        Some(found)
    });
    found.into_iter().next().flatten().expect("the first rank's")
}

/// Windows that take the force along and tell viscosity of it, that leave it, that do not: with one process,
/// 2, 3 and 4 ranks.
#[test]
fn ranks_do_not_change_a_bit_of_the_loads() {
    let cases = [
        ("no-slip", "free", ""),
        ("periodic", "free", ""),
        ("periodic", "fixed", ""),
        ("no-slip", "free", "time = { scheme = \"ab2\" }"),
        ("no-slip", "free", "time = { viscosity = \"implicit\" }"),
        ("no-slip", "free", "method = \"izard-2014\""),
    ];
    let unused = Path::new("unused");
    for (ends, motion, keys) in cases {
        let text = text(ends, motion, keys);
        let one = messages(&mut Run::new(&text), 4);
        for size in [2, 3, 4] {
            let several = shared(&text, size, unused, |run| messages(run, 4));
            assert_eq!(one, several, "{size} ranks, {ends}, {motion}, {keys}");
        }
    }
}

/// Totals of the box and averages over planes, stresses and pressure with them, to the last bit: of one
/// process and of 2 and 3 ranks, across the slabs and along them.
#[test]
fn ranks_do_not_change_a_bit_of_totals_and_stresses() {
    for axis in ["z", "x"] {
        let observe = format!(
            "[observe]
            totals = {{ columns = [\"wall-force\", \"fluid-flux\", \"shields\"], axis = \"{axis}\" }}
            planes = {{ axis = \"{axis}\", every = 1e-9, stress = true }}"
        );
        let text = text("no-slip", "free", &observe)
            .replace("x = \"periodic\"", "x = \"no-slip\"")
            .replace("[0.2, 0.0", "[0.0, 0.2");
        let sums = |run: &mut Run, folder: &Path| {
            run.windows(3);
            let mut totals = Vec::new();
            run.fluid.totals(&mut totals);
            let planes = std::fs::read_to_string(folder.join("fields/planes_00000002.csv")).expect("planes");
            std::fs::remove_dir_all(folder).expect("a folder");
            (totals.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), planes)
        };
        let folder = folder(&format!("ranks-totals-{axis}"));
        let one = sums(&mut Run::with_ranks(&text, &Ranks::alone(), &folder), &folder);
        assert_eq!(one.0.len(), 2 + 4 * 3);
        for size in [2, 3] {
            let several = shared(&text, size, &folder, |run| sums(run, &folder));
            assert!(one == several, "{size} ranks, {axis}: {one:?} {several:?}");
        }
    }
}

/// Does a run of three windows and writes its checkpoint; the messages of the three windows after it.
fn write_and_go_on(run: &mut Run, folder: &Path) -> Vec<u64> {
    run.windows(3);
    run.fluid.write_checkpoint(folder).expect("writes");
    messages(run, 3)
}

/// The same windows from the checkpoint: the grains' side does the first ones again.
fn read_and_go_on(run: &mut Run, folder: &Path) -> Vec<u64> {
    run.windows(3);
    run.fluid.read_checkpoint(folder).expect("reads");
    messages(run, 3)
}

/// Names of the files in a folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("there").flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Written by 1, 2 and 4 ranks, read by 1, 3 and one process without ranks: a run goes on with the same bits.
#[test]
fn a_checkpoint_is_read_by_any_number_of_ranks() {
    let unused = Path::new("unused");
    for keys in ["time = { scheme = \"ab2\" }", "method = \"izard-2014\""] {
        let text = text("no-slip", "free", keys);
        let whole = folder("ranks-whole");
        let expected = write_and_go_on(&mut Run::new(&text), &whole);
        assert_eq!(names(&whole), ["fluid.checkpoint"]);
        let mut folders = vec![whole];
        for size in [2, 4] {
            let folder = folder(&format!("ranks-{size}"));
            let found = shared(&text, size, unused, |run| write_and_go_on(run, &folder));
            assert_eq!(found, expected, "{size} ranks, {keys}");
            assert_eq!(names(&folder).len(), size + 1, "{:?}", names(&folder));
            folders.push(folder);
        }
        for folder in &folders {
            assert_eq!(read_and_go_on(&mut Run::new(&text), folder), expected, "{folder:?}");
            for size in [2, 3] {
                let found = shared(&text, size, unused, |run| read_and_go_on(run, folder));
                assert_eq!(found, expected, "{folder:?} by {size} ranks");
            }
        }
        folders.iter().for_each(|folder| std::fs::remove_dir_all(folder).expect("removes"));
    }
}

/// A later checkpoint takes the place of the parts of an earlier one, and one process that of both. A part
/// that is gone or from elsewhere is refused with its name, whoever needed it.
#[test]
fn parts_belong_to_their_head() {
    let text = text("periodic", "fixed", "");
    let (folder, unused) = (folder("ranks-parts"), Path::new("unused"));
    let write = |run: &mut Run| {
        for _ in 0..2 {
            run.windows(1);
            run.fluid.write_checkpoint(&folder).expect("writes");
        }
    };
    shared(&text, 2, unused, write);
    let [first, second] = ["fluid-2-0-of-2.checkpoint", "fluid-2-1-of-2.checkpoint"];
    assert_eq!(names(&folder), [first, second, "fluid.checkpoint"]);

    let refused = |size: usize| {
        let read = |run: &mut Run| run.fluid.read_checkpoint(&folder).expect_err("is refused").to_string();
        shared(&text, size, unused, read)
    };
    let kept = std::fs::read(folder.join(second)).expect("there");
    std::fs::copy(folder.join(first), folder.join(second)).expect("copies");
    for size in [2, 3] {
        let what = refused(size);
        assert!(what.contains(second) && what.contains("another checkpoint"), "{what}");
    }
    std::fs::remove_file(folder.join(second)).expect("removes");
    for size in [2, 3] {
        let what = refused(size);
        assert!(what.contains(second), "{what}");
    }
    std::fs::write(folder.join(second), &kept[..kept.len() - 1]).expect("writes");
    assert!(refused(2).contains("truncated"));
    std::fs::write(folder.join(second), kept).expect("writes");
    write(&mut Run::new(&text));
    assert_eq!(names(&folder), ["fluid.checkpoint"]);
    std::fs::remove_dir_all(folder).expect("removes");
}

/// A window that is done again, and the field files of the ranks, which are one grid.
#[test]
fn ranks_go_back_and_write_as_one() {
    let task = |run: &mut Run| {
        run.windows(2);
        run.fluid.save();
        let (time, step, dt) = (run.time, run.step, run.dt);
        let first = messages(run, 2);
        run.fluid.restore();
        (run.time, run.step, run.dt) = (time, step, dt);
        assert_eq!(messages(run, 2), first);
        let window = Window { step: 4, attempt: 0, time, dt, substeps: 1, output: true };
        run.fluid.write_fields(&window).expect("writes");
    };
    let folder = folder("ranks-fields");
    let read =
        |ending: &str| vtk::read(&folder.join(format!("fields/fluid_00000004.{ending}"))).expect("reads");
    for ends in ["periodic", "no-slip"] {
        let text = text(ends, "fixed", "");
        task(&mut Run::with_ranks(&text, &Ranks::alone(), &folder));
        let one = read("vtr");
        assert_eq!((one.counts(), one.arrays.len()), ([32, 32, 48], 4));
        for size in [2, 4] {
            shared(&text, size, &folder, task);
            assert!(read("pvtr") == one, "the fields of {size} ranks differ, {ends}");
        }
        std::fs::remove_dir_all(&folder).expect("removes");
    }
}

/// What several ranks cannot do is refused with the key, on all of them alike.
#[test]
fn what_ranks_cannot_do_is_refused() {
    let refuse = |text: String, size: usize| {
        let told = threads::together(size, |ranks| {
            if !ranks.is_first() {
                follow(&ranks).expect("the first rank says when it ends");
                return None;
            }
            let built = Fluid::with_ranks(&scene(&text), Path::new("unused"), &ranks);
            dismiss(&ranks).expect("all live");
            built.err().map(|error| (error.key, error.message))
        });
        told.into_iter().next().flatten().expect("is refused")
    };
    let plain = text("no-slip", "free", "");
    let (key, what) = refuse(plain.clone(), 9);
    assert!(key == "domain.cells" && what.contains("1 to 8"), "{key}: {what}");
    let (key, _) = refuse(text("no-slip", "free", "[coupling]\nscheme = \"iterated\""), 2);
    assert_eq!(key, "coupling.scheme");
}
