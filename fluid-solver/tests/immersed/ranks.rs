//! Grains in a fluid that several ranks share: the same bits whatever their number.

use crate::newton::{Run, scene};
use crate::restart::{folder, messages};
use fluid_solver::follow::follow;
use fluid_solver::orders::dismiss;
use fluid_solver::participant::Fluid;
use fluid_solver::ranks::{Ranks, threads};
use protocol::participant::{Participant, Window};
use std::path::Path;

/// Spheres that cross from slab to slab and, along z, the ends of a periodic box.
fn text(ends: &str, motion: &str, keys: &str) -> String {
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
        body_force = [0.0, 0.0, 1.0]
        [[grains]]
        position = [0.5, 0.5, 0.45]
        velocity = [0.0, 0.2, -0.6]
        radius = 0.35
        density = 2.0
        motion = \"{motion}\"
        [[grains]]
        position = [0.6, 1.4, 1.5]
        velocity = [0.0, 0.0, 0.4]
        spin = [0.0, 1.0, 0.5]
        radius = 0.4
        density = 2.5
        motion = \"{motion}\"
        [[grains]]
        position = [1.5, 0.9, 2.55]
        radius = 0.4
        density = 2.0
        motion = \"{motion}\"
        [fluid]
        division = \"blocks\"
        {keys}
        "
    )
}

/// What `task` makes of a run whose fluid `size` ranks share.
fn shared<R: Send>(text: &str, size: usize, folder: &Path, task: impl Fn(&mut Run) -> R + Sync) -> R {
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

/// Windows that take the force along and tell viscosity of it, that leave it, that do not: with one process, 2, 3 and 4
/// ranks.
#[test]
fn ranks_do_not_change_a_bit_of_the_loads() {
    let cases = [
        ("no-slip", "free", ""),
        ("periodic", "free", ""),
        ("periodic", "fixed", ""),
        ("no-slip", "free", "time = { scheme = \"ab2\" }\nimmersed = { force_transport = \"advected\" }"),
        ("no-slip", "free", "time = { viscosity = \"implicit\" }\nimmersed = { viscous_sweeps = 6 }"),
        ("no-slip", "free", "immersed = { force_transport = \"eulerian\", mask_radius = \"nominal\" }"),
        (
            "no-slip",
            "free",
            "immersed = { method = \"direct\" }\nloads = { form = \"kempe-froehlich-2012\" }",
        ),
        ("periodic", "free", "immersed = { force_transport = \"advected\", viscous_sweeps = 6 }"),
        ("periodic", "free", "loads = { form = \"yu-shao-2007\" }"),
        ("no-slip", "free", "[coupling]\nscheme = \"overlapped\""),
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

/// Written by 2 ranks, read by 3 and by one process: a run goes on with the same bits, and the file is as long.
#[test]
fn a_checkpoint_is_read_by_any_number_of_ranks() {
    let text = text("no-slip", "free", "time = { scheme = \"ab2\" }");
    let [one, two] = ["ranks-1", "ranks-2"].map(folder);
    let unused = Path::new("unused");
    let first = |run: &mut Run, folder: &Path| {
        run.windows(3);
        run.fluid.write_checkpoint(folder).expect("writes");
        (messages(run, 3), run.step)
    };
    let (whole, _) = first(&mut Run::new(&text), &one);
    let (several, _) = shared(&text, 2, unused, |run| first(run, &two));
    assert_eq!(whole, several);
    let go_on = |run: &mut Run, folder: &Path| {
        // The grains' side does the first windows again, the fluid takes its own from the file.
        run.windows(3);
        run.fluid.read_checkpoint(folder).expect("reads");
        messages(run, 3)
    };
    for folder in [&one, &two] {
        assert_eq!(go_on(&mut Run::new(&text), folder), whole);
        assert_eq!(shared(&text, 3, unused, |run| go_on(run, folder)), whole);
    }
    let size =
        |folder: &Path| std::fs::metadata(protocol::checkpoint::path(folder, "fluid")).expect("there").len();
    assert_eq!(size(&one), size(&two));
    for folder in [one, two] {
        std::fs::remove_dir_all(folder).expect("removes");
    }
}

/// A window that is done again, and the files of the first rank.
#[test]
fn ranks_go_back_and_write_as_one() {
    let text = text("periodic", "fixed", "");
    let task = |run: &mut Run, folder: &Path| {
        run.windows(2);
        run.fluid.save();
        let (time, step, dt) = (run.time, run.step, run.dt);
        let first = messages(run, 2);
        run.fluid.restore();
        (run.time, run.step, run.dt) = (time, step, dt);
        assert_eq!(messages(run, 2), first);
        let window = Window { step: 4, attempt: 0, time, dt, substeps: 1, output: true };
        run.fluid.write_fields(&window).expect("writes");
        std::fs::read(folder.join("fields/fluid_00000004.vtr")).expect("there")
    };
    let folder = folder("ranks-fields");
    let one = task(&mut Run::with_ranks(&text, &Ranks::alone(), &folder), &folder);
    let several = shared(&text, 4, &folder, |run| task(run, &folder));
    std::fs::remove_dir_all(&folder).expect("removes");
    assert!(one == several, "the field files differ");
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
    let (key, _) = refuse(plain.replace("\"blocks\"", "\"whole\""), 2);
    assert_eq!(key, "fluid.division");
    let (key, _) = refuse(text("no-slip", "free", "[coupling]\nscheme = \"iterated\""), 2);
    assert_eq!(key, "coupling.scheme");
}
