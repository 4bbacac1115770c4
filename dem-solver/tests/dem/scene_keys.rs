//! Models as keys of the scene's `[dem]` section.
use dem_solver::{ContactLaw, Integrator, LinearSpringDashpot, Lubrication};
use serde::Deserialize;

#[derive(Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Section {
    contact: ContactLaw,
    #[serde(default)]
    lubrication: Lubrication,
    #[serde(default)]
    integrator: Integrator,
}

fn read(text: &str) -> Result<Section, toml::de::Error> {
    toml::from_str(text)
}

#[test]
fn models_read_with_their_defaults() {
    let section = read(
        "integrator = \"velocity-verlet\"\n\
         [contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.97\ncontact_time = 1e-4\nfriction = 0.25\n\
         [lubrication]\nform = \"as-printed\"\nroughness = 1e-4\n",
    )
    .expect("reads");
    let law = LinearSpringDashpot::new(0.97, 1e-4, 0.25);
    assert_eq!(section.contact, ContactLaw::LinearSpringDashpot(law));
    let film = section.lubrication.settings().expect("a film");
    assert_eq!((film.roughness, film.cut_off, film.sweeps), (1e-4, 0.5, 8));
    assert_eq!(section.integrator, Integrator::VelocityVerlet);
    let again = toml::to_string(&section.contact).expect("writes");
    assert_eq!(toml::from_str::<ContactLaw>(&again).expect("reads"), section.contact);
}

#[test]
fn all_forms_have_their_names() {
    for (text, ok) in [
        ("[contact]\nlaw = \"wan-turek\"\nsoftness = 1e-6\nwall_softness = 5e-7\nrange = 0.1\n", true),
        (
            "[contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.9\ncontact_time = 1.0\nform \
             = \"exact-restitution\"\nrolling = { friction = 0.1 }\n",
            true,
        ),
        (
            "[contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.9\ncontact_time = 1.0\nfrction = 0.3\n",
            false,
        ),
        ("[contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.9\nstiffness = 1e4\n", true),
        ("[contact]\nlaw = \"hertz\"\n", false),
        ("[contact]\nlaw = \"linear-spring-dashpot\"\ncontact_time = 1.0\n", false),
        (
            "[contact]\nlaw = \"wan-turek\"\nsoftness = 1.0\nwall_softness = 1.0\nrange = 0.1\nrolling = { \
             friction = 0.1 }\n",
            false,
        ),
    ] {
        assert_eq!(read(text).is_ok(), ok, "{text}{:?}", read(text));
    }
    for (text, ok) in [
        ("form = \"none\"", true),
        ("form = \"as-printed\"\nroughness = 1e-3\ncut_off = 0.2", true),
        ("form = \"as-printed\"\nroughness = 1e-3\nsweeps = 4", false),
        ("form = \"as-printed\"", false),
        ("form = \"as-printed\"\nroughness = 1e-3\nrougness = 1e-3", false),
    ] {
        assert_eq!(toml::from_str::<Lubrication>(text).is_ok(), ok, "{text}");
    }
}

#[test]
fn schema_carries_the_documentation() {
    let schema = serde_json::to_string(&schemars::schema_for!(ContactLaw)).expect("writes");
    assert!(schema.contains("Coefficient of normal restitution") && schema.contains("wan-turek"));
    let schema = serde_json::to_string(&schemars::schema_for!(Lubrication)).expect("writes");
    assert!(schema.contains("complement") && schema.contains("cut_off"));
}

/// A dry scene of two grains with the given lines in `[dem]`.
fn dry(dem: &str) -> Result<protocol::facts::DemFacts, bedload_scene::SceneError> {
    let text = format!(
        "until = 1.0\n[domain]\ngeometry = \"space\"\nlower = [0.0, 0.0, 0.0]\nupper = [1.0, 1.0, 1.0]\ncells = [64, 64, 64]\n\
         boundary = {{ x = \"no-slip\", y = \"no-slip\", z = \"no-slip\" }}\n\
         [[grains]]\nposition = [0.5, 0.5, 0.2]\nradius = 0.1\ndensity = 2500.0\n\
         [[grains]]\nposition = [0.5, 0.5, 0.6]\nradius = 0.05\ndensity = 2500.0\n\
         [dem]\n{dem}\n"
    );
    let source = bedload_scene::SceneSource { file: "s.toml".into(), text };
    let scene = bedload_scene::CheckedScene::new(source)?;
    Ok(dem_solver::config::Config::new(&scene)?.facts)
}

/// 200 ns for each grain and sub-step were estimated for all; beds take 24 to 66.
#[test]
fn the_cost_is_that_of_the_engine_that_runs() {
    let law = "contact = { law = \"linear-spring-dashpot\", restitution = 0.9, contact_time = 1e-3 }";
    let few = |more: &str| dry(&format!("{law}\n{more}")).expect("a scene").substep_cost / 2.0;
    assert_eq!(few(""), 5e-8);
    let films = "lubrication = { form = \"as-printed\", roughness = 1e-3, cut_off = 0.2 }\n[medium]\n\
                 density = 1.0\nviscosity = 1e-3";
    assert_eq!(few(films), 1.2e-7);
    let bed = format!(
        "until = 1.0\n[domain]\ngeometry = \"space\"\nlower = [0.0, 0.0, 0.0]\nupper = [9.0, 9.0, 9.0]\n\
         boundary = {{ x = \"no-slip\", y = \"no-slip\", z = \"no-slip\" }}\n[[groups]]\ncount = 300\n\
         lower = [0.0, 0.0, 0.0]\nupper = [9.0, 9.0, 9.0]\nradius = 0.3\ndensity = 1.0\nseed = 1\n[dem]\n{law}\n"
    );
    let source = bedload_scene::SceneSource { file: "s.toml".into(), text: bed };
    let scene = bedload_scene::CheckedScene::new(source).expect("a scene");
    let cost = dem_solver::config::Config::new(&scene).expect("builds").facts.substep_cost;
    assert!((cost / 300.0 - 4e-8).abs() < 1e-15, "{cost}");
}

#[test]
fn a_coarse_sub_step_is_refused_unless_asked_for() {
    let law = "contact = { law = \"linear-spring-dashpot\", restitution = 0.9, contact_time = 1e-3 }";
    assert_eq!(dry(&format!("steps_per_contact = 10\n{law}")).expect("at the limit").dt, 1e-4);
    for (line, key) in [("steps_per_contact = 9.0", "dem.steps_per_contact"), ("dt = 2e-4", "dem.dt")] {
        let error = dry(&format!("{line}\n{law}")).expect_err(line);
        assert!(error.key == key && error.message.contains("t_c/10"), "{error}");
        assert!(error.remedy.contains("allow_coarse_dt"), "{}", error.remedy);
        let asked = dry(&format!("allow_coarse_dt = true\n{line}\n{law}")).expect("asked for");
        assert!(asked.coarse_dt && asked.dt > 1.1e-4);
    }
}

#[test]
fn a_packing_that_could_not_rest_is_refused_unless_asked_for() {
    let more: String = (0..8)
        .map(|k| {
            format!(
                "\n[[grains]]\nposition = [0.1, 0.1, {}]\nradius = 0.04\ndensity = 2500.0\n",
                0.1 + 0.1 * f64::from(k)
            )
        })
        .collect();
    let law = "contact = { law = \"linear-spring-dashpot\", restitution = 0.3, friction = 0.5, contact_time = 1e-3 }";
    let facts = |steps: u32, keys: &str| dry(&format!("steps_per_contact = {steps}\n{keys}{law}\n{more}"));
    let bounds = facts(17, "").expect("enough sub-steps").bounds;
    let rate = bounds.iter().find(|bound| bound.name == "contact-dashpot").expect("a packing").factor;
    assert!((rate / (2000.0 * -(0.3f64.ln())) - 1.0).abs() < 1e-12, "−2 ln(e_n)/t_c: {rate}");
    let error = facts(16, "").expect_err("too few");
    assert!(error.key == "dem.steps_per_contact" && error.message.contains("t_c/17"), "{error}");
    assert!(error.remedy.contains("allow_coarse_dt"), "{}", error.remedy);
    assert!(facts(16, "allow_coarse_dt = true\n").is_ok());
    assert!(dry(&format!("steps_per_contact = 16\n{law}")).is_ok(), "two grains are no packing");
}

#[test]
fn contact_time_follows_from_a_stiffness_and_the_smallest_pair() {
    let facts = dry("contact = { law = \"linear-spring-dashpot\", restitution = 1.0, stiffness = 1e5 }")
        .expect("fits");
    let mass = 4.0 / 3.0 * std::f64::consts::PI * 0.05f64.powi(3) * 2500.0;
    let expected = std::f64::consts::PI * (0.5 * mass / 1e5).sqrt();
    assert!((facts.contact_time / expected - 1.0).abs() < 1e-12, "{} {expected}", facts.contact_time);
}

/// Choices that a scene had before are refused where they stand, with what to do.
#[test]
fn retired_keys_and_values_are_refused_with_a_remedy() {
    let law = "law = \"linear-spring-dashpot\"\nrestitution = 0.9\ncontact_time = 1e-3";
    let film = "[dem.lubrication]\nroughness = 1e-3";
    for (lines, key, remedy) in [
        ("skin = 0.1".to_owned(), "dem.skin", "leave it out"),
        ("engine = \"bulk\"".to_owned(), "dem.engine", "leave it out"),
        (format!("[dem.contact]\n{law}\nsliding = \"uncapped\""), "dem.contact.sliding", "leave it out"),
        (format!("[dem.contact]\n{law}\nlever_arm = \"radius\""), "dem.contact.lever_arm", "leave it out"),
        ("[dem.contact]\nlaw = \"hertz-mindlin\"".to_owned(), "dem.contact.law", "linear-spring-dashpot"),
        (format!("{film}\nform = \"continuous\""), "dem.lubrication.form", "complement"),
        (format!("{film}\nform = \"as-printed\"\nfilm = \"line\""), "dem.lubrication.film", "leave it out"),
        (format!("{film}\nintegration = \"explicit\""), "dem.lubrication.integration", "implicit"),
        (format!("{film}\nsweeps = 3"), "dem.lubrication.sweeps", "leave it out"),
    ] {
        let error = dry(&lines).expect_err(&lines);
        assert!(error.key == key && error.message.contains("retired"), "{error}");
        assert!(error.remedy.contains(remedy), "{}", error.remedy);
    }
}
