//! The film of a report, in a browser: it plays, scrubs and turns, in space and in the plane, in wide and
//! narrow windows, and its console stays empty.

use tests::harness::{Folder, bedload, browse, said};

const SCENE: &str = r#"
title = "Two grains settle"
until = 0.4
gravity = [0.0, 0.0, -1.0]
[domain]
geometry = "GEOMETRY"
lower = [0.0, 0.0, 0.0]
upper = [2.0, 2.0, 3.0]
cells = [20, 20, 30]
boundary = { x = "periodic", y = "periodic", z = "no-slip" }
[medium]
density = 1.0
viscosity = 0.1
[[grains]]
position = [0.1, 0.9, 1.8]
radius = 0.3
density = 3.0
[[grains]]
position = [1.1, 1.2, 1.2]
radius = 0.3
density = 2.0
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.9
contact_time = 0.02
[observe]
every = 0.02
fields_every = 0.05
"#;

/// Uses the film as a reader does, and leaves what came of it in the page.
const SCRIPT: &str = r#"<script>
(async () => {
  const part = (name) => document.querySelector(`#player [data-part="${name}"]`);
  const [canvas, seen] = [part("view"), () => part("view").toDataURL()];
  const pause = (time) => new Promise((go) => setTimeout(go, time));
  const result = {};
  await pause(300);
  const [end, last] = [seen(), part("time").textContent];
  part("instant").value = 0;
  part("instant").dispatchEvent(new Event("input"));
  await pause(300);
  result.scrubs = seen() !== end && part("time").textContent !== last;
  part("play").click();
  await pause(1500);
  part("play").click();
  result.plays = part("instant").value !== "0";
  part("quantity").value = "1";
  const before = seen();
  part("quantity").dispatchEvent(new Event("change"));
  await pause(300);
  result.colours = seen() !== before;
  result.space = !part("in-space").hidden;
  if (result.space) {
    part("space").checked = true;
    part("space").dispatchEvent(new Event("change"));
    await pause(300);
    const still = seen();
    const at = (on, type, x, y) => on.dispatchEvent(new PointerEvent(type, { clientX: x, clientY: y }));
    at(canvas, "pointerdown", 100, 100);
    at(window, "pointermove", 160, 120);
    at(window, "pointerup", 160, 120);
    await pause(100);
    result.turns = seen() !== still;
  }
  result.fits = document.documentElement.scrollWidth <= window.innerWidth;
  document.body.dataset.result = Object.entries(result).map(([name, is]) => `${name}=${is}`).join(" ");
})();
</script>
</body>"#;

#[test]
fn the_film_plays_scrubs_and_turns() {
    let folder = Folder::new("player");
    let plane = SCENE
        .replace("GEOMETRY", "plane")
        .replace("lower = [0.0, 0.0, 0.0]\nupper = [2.0, 2.0, 3.0]", "lower = [0.0, 0.0]\nupper = [2.0, 3.0]")
        .replace("cells = [20, 20, 30]", "cells = [20, 30]")
        .replace(" y = \"periodic\",", "")
        .replace("[0.1, 0.9, 1.8]", "[0.1, 0.0, 1.8]")
        .replace("[1.1, 1.2, 1.2]", "[1.1, 0.0, 1.2]");
    for (name, scene, turns) in [("space", SCENE.replace("GEOMETRY", "space"), true), ("plane", plane, false)]
    {
        let scene = folder.write(&format!("{name}.toml"), &scene);
        let out = folder.join(name);
        let run = bedload(&["run".as_ref(), scene.as_os_str(), "--out".as_ref(), out.as_os_str()]);
        assert_eq!(run.status.code(), Some(0), "{}", said(&run));
        let page = std::fs::read_to_string(out.join("report.html")).expect("a report");
        assert!(page.contains("8 of 8 instants"), "{name}");
        let used = folder.write(&format!("{name}.html"), &page.replace("</body>", SCRIPT));
        for width in [1100, 500] {
            let Some(said) = browse(&used, (width, 900), &["--virtual-time-budget=9000", "--dump-dom"])
            else {
                return;
            };
            let turned = if turns { "true turns=true" } else { "false" };
            let expected =
                format!("data-result=\"scrubs=true plays=true colours=true space={turned} fits=true\"");
            let line = said.lines().find(|line| line.contains("data-result")).unwrap_or("no result");
            assert!(line.contains(&expected), "{name} {width}: {line}");
            assert!(!said.contains("CONSOLE"), "{name} {width}: {said}");
        }
    }
}
