//! Solids in the fluids of PFEM-2: sizes, meshes, particles around them, errors in their keys.

use super::findings::{edited, expect_error, good, model};
use lateen::case::{Case, Model, Source};
use lateen::error::Severity;
use lateen::pfem2::solid::setup::Damping;
use std::path::Path;

const GOOD: &str = r#"
name = "flap"
method = "pfem2"
dimension = 2
[time]
end = "0.1 s"
step = "0.01 s"
[mesh]
shape = "box"
lower = ["0 m", "0 m"]
upper = ["1 m", "0.5 m"]
cell = "0.02 m"
[pfem2]
volume = "none"
[[body]]
name = "flap"
region = { shape = "box", lower = ["0.4 m", "0 m"], upper = ["0.5 m", "0.3 m"] }
material = { law = "neo-hookean", density = "1200 kg/m^3", young = "1 MPa", poisson = 0.3 }
mesh = { cell = "0.05 m" }
supports = [{ on = "bottom" }]
traction = [{ on = "top", value = [0, "-10 Pa"] }]
damping = { mass = "0.1 1/s" }
plane = "stress"
[[body]]
name = "water"
region = { shape = "box", lower = ["-1 m", "-1 m"], upper = ["0.45 m", "2 m"] }
material = { law = "newtonian", density = "1000 kg/m^3", viscosity = "1e-3 Pa s" }
[[body]]
name = "oil"
region = { shape = "box", lower = ["-1 m", "-1 m"], upper = ["2 m", "2 m"] }
material = { law = "newtonian", density = "800 kg/m^3", viscosity = "1e-2 Pa s" }
[[tension]]
between = ["water", "oil"]
value = "0.01 N/m"
[[boundary]]
on = "left"
kind = "inlet"
velocity = ["0.1 m/s", 0]
fluid = "oil"
[[boundary]]
on = "right"
kind = "outlet"
[[boundary]]
on = "rest"
"#;

/// Expects one error at the place of `at` after replacing `from` by `to`.
#[track_caller]
fn expect(from: &str, to: &str, at: &str, message: &str, help: &str) {
    expect_error(&edited(GOOD, from, to), at, message, help);
}

/// 0.1 m by 0.3 m of 1200 kg/m³ in elements of 0.05 m. The fluids have the rest: 0.4 · 0.5 + 0.05 · 0.2 and what is
/// behind.
#[test]
fn a_solid_has_its_elements_and_mass_and_no_particles() {
    let model = good(GOOD);
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    let [solid] = &model.summary.solids[..] else { panic!("one solid") };
    assert_eq!((solid.name.as_str(), solid.elements, solid.nodes, solid.across), ("flap", 12, 5 * 13, 2));
    assert!((solid.mass - 36.0).abs() < 1e-9 && (solid.thickness - 0.1).abs() < 1e-12, "{solid:?}");
    assert!((solid.cells_across.unwrap() - 5.0).abs() < 1e-9, "{solid:?}");
    assert!(model.summary.to_string().contains("solid flap: 12 elements, 65 nodes, 36.0000 kg/m"), "{}", model.summary);
    let fluids: Vec<(&str, f64)> = model.summary.bodies.iter().map(|body| (body.name.as_str(), body.volume)).collect();
    let [("water", water), ("oil", oil)] = fluids[..] else { panic!("{fluids:?}") };
    assert!((water - 0.21).abs() < 2e-3 && (oil - 0.26).abs() < 2e-3, "{fluids:?}");
}

#[test]
fn a_resolved_case_keeps_the_keys_of_its_solids() {
    let resolved = |text: &str| Case::read(Source::new("case.toml", "", text), &[]).unwrap().resolved_toml();
    let first = resolved(GOOD);
    for key in ["[body.mesh]", "plane = \"stress\"", "[[body.supports]]", "[[body.traction]]", "[body.damping]"] {
        assert!(first.contains(key), "{key}\n{first}");
    }
    assert_eq!(resolved(&first), first);
}

/// The stabilisation that solids bring along, another in one fluid than in several, is shown, and one that the case
/// names stays.
#[test]
fn a_resolved_case_shows_the_stabilisation_beside_solids() {
    let resolved = |text: &str| Case::read(Source::new("case.toml", "", text), &[]).unwrap().resolved_toml();
    assert!(resolved(GOOD).contains("stabilisation = \"consistent-pspg\""));
    let (start, end) = (GOOD.find("[[body]]\nname = \"oil\"").unwrap(), GOOD.find("[[boundary]]").unwrap());
    let one = format!("{}{}", &GOOD[..start], GOOD[end..].replace("\"oil\"", "\"water\""));
    assert!(resolved(&one).contains("stabilisation = \"dynamic-subscales\""));
    let own = resolved(&GOOD.replace("[pfem2]", "[pfem2]\nstabilisation = \"oss\""));
    assert!(own.contains("stabilisation = \"oss\""), "{own}");
}

/// Without a size: two cells of 0.02 m, which makes 3 by 8 elements; a thin one has two across all the same.
#[test]
fn the_default_size_follows_the_mesh_of_the_fluid_and_the_thickness() {
    let sizes = |upper: &str| {
        let text = GOOD.replace("mesh = { cell = \"0.05 m\" }\n", "");
        let solid = good(&text.replace("[\"0.5 m\", \"0.3 m\"]", upper)).summary.solids[0].clone();
        (solid.elements, solid.across)
    };
    assert_eq!(sizes("[\"0.52 m\", \"0.32 m\"]"), (24, 3));
    let (elements, across) = sizes("[\"0.43 m\", \"0.3 m\"]");
    assert_eq!((elements, across), (16, 2));
}

#[test]
fn a_thin_solid_and_a_coarse_one_are_warned_of() {
    let warnings = |from: &str, to: &str| -> Vec<String> {
        assert_eq!(GOOD.matches(from).count(), 1, "{from}");
        good(&GOOD.replace(from, to)).warnings.iter().map(ToString::to_string).collect()
    };
    let coarse = warnings("cell = \"0.05 m\" }", "cell = \"0.1 m\" }");
    assert!(coarse.len() == 1 && coarse[0].contains("one element across its thinnest part"), "{coarse:?}");
    let thin = warnings("[\"0.5 m\", \"0.3 m\"]", "[\"0.45 m\", \"0.3 m\"]");
    let told = thin.iter().filter(|warning| warning.contains("2.5 elements of the mesh")).count();
    assert_eq!(told, 1, "{thin:?}");
}

/// Fluid flows between the nodes of the mesh through what is thinner than its elements, of 0.02 m. What is so at an edge
/// alone, as a wing, is not refused.
#[test]
fn a_solid_thinner_than_an_element_is_refused() {
    let whole = "region = { shape = \"box\", lower = [\"0.4 m\", \"0 m\"], upper = [\"0.5 m\", \"0.3 m\"] }";
    let thin = whole.replace("0.5 m", "0.415 m");
    expect(whole, &thin, "[[body]]", "thinner than an element of the mesh behind 86 %", "make it n times as thick");
    let wedge = "region = { shape = \"polygon\", corners = [[0.4, 0.1], [0.5, 0.1], [0.405, 0.3], [0.4, 0.3]] }";
    good(&edited(GOOD, whole, wedge));
}

#[test]
fn mistakes_in_solids_are_errors_with_their_place() {
    let steel = "law = \"j2\", density = 1.0, young = 1.0, poisson = 0.3, yield-stress = 1.0";
    let rubber = "law = \"neo-hookean\", density = \"1200 kg/m^3\", young = \"1 MPa\", poisson = 0.3";
    assert!(GOOD.contains(rubber));
    let bottom = "{ on = \"bottom\" }";
    expect(bottom, "{ on = \"foot\" }", "\"foot\"", "no such set of nodes", "all, surface, bottom, left, right, top");
    let twice = "{ on = \"bottom\" }, { on = \"all\", velocity = [\"1 m/s\", \"free\"] }";
    expect(bottom, twice, "{ on = \"all\"", "moves node 0 along x with another velocity", "\"free\"");
    expect("on = \"top\", value", "on = [0.45, 0.3], value", "[0.45", "no side of an element", "a force needs an area");
    let follower = "value = [0, \"-10 Pa\"]";
    good(&GOOD.replace(follower, "pressure = \"10 Pa * (1 + x / 1 m) * ramp(t, 1 s)\""));
    let both = format!("{follower}, pressure = \"10 Pa\"");
    expect(follower, &both, "{ on = \"top\"", "a pressure that follows the surface", "write two loads");
    expect(follower, "pressure = \"10 m\"", "\"10 m\"", "", "");
    expect("plane = \"stress\"", "plane = \"flat\"", "\"flat\"", "unknown name `flat`", "");
    expect(
        "{ cell = \"0.05 m\" }",
        "{ path = \"flap.msh\" }",
        "{ shape = \"box\", lower = [\"0.4",
        "needs no region",
        "",
    );
    expect(
        "fluid = \"oil\"",
        "fluid = \"flap\"",
        "\"flap\"\n[[boundary]]",
        "no body `flap` of a fluid",
        "`water`, `oil`",
    );
    expect("[\"water\", \"oil\"]", "[\"water\", \"flap\"]", "[\"water\", \"flap\"]", "not two bodies", "water, oil");
    expect(
        "lower = [\"0.4 m\", \"0 m\"], upper = [\"0.5 m\"",
        "lower = [\"4 m\", \"0 m\"], upper = [\"5 m\"",
        "",
        "outside the mesh",
        "",
    );
    let text = GOOD.replace("name = \"oil\"", "name = \"oil\"\nspacing = 1.0\nsupports = [{ on = \"left\" }]");
    let messages: Vec<String> =
        model(&text, Path::new("")).map(|_| ()).unwrap_err().iter().map(|f| f.message.clone()).collect();
    assert!(messages[0].contains("`body[2].spacing` does not belong to `method = \"pfem2\"`"), "{messages:?}");
    assert!(messages[1].contains("`supports` is for solids, and this body is a fluid"), "{messages:?}");
    // Laws that yield have no tangent.
    let text = GOOD.replace(rubber, steel);
    let found = model(&text, Path::new("")).map(|_| ()).unwrap_err();
    let law = found.iter().find(|f| f.message.contains("`j2` is for `method = \"mpm\"`")).expect("the law");
    assert!(
        law.help.as_deref().unwrap_or("").contains("an elastic law with a stored energy, such as `neo-hookean`"),
        "{law:?}"
    );
}

/// GOOD is in plane stress, of rubber with K = 0.83 MPa.
#[test]
fn the_stress_at_the_start_is_even_and_one_that_the_law_can_have() {
    let with = |stress: &str| format!("plane = \"stress\"\nstress = {stress}");
    let pulled = good(&GOOD.replace("plane = \"stress\"", &with("[\"10 kPa\", 0, 0, 0, 0, 0]")));
    assert!(pulled.warnings.is_empty(), "{:?}", pulled.warnings);
    let energy = |model: &Model| {
        let terms = model.solver.snapshot().ledger.terms;
        terms.iter().find(|term| term.name == "strain energy").expect("the energy of the solid").value
    };
    // ½ σ²/E per volume.
    assert!((energy(&pulled) / (0.5 * 1e8 / 1e6 * 0.03) - 1.0).abs() < 0.02, "{}", energy(&pulled));
    let refused = |stress: &str, message: &str, help: &str| {
        expect("plane = \"stress\"", &with(stress), "", message, help);
    };
    refused("[\"10 kPa * x / 1 m\", 0, 0, 0, 0, 0]", "the same everywhere", "six numbers");
    refused("[0, 0, \"10 kPa\", 0, 0, 0]", "`zz` acts across the plane", "`yz` and `zx`");
    refused("[0, 0, 0, 0, \"10 kPa\", 0]", "`yz` acts across the plane", "`yz` and `zx`");
    refused("[\"1e6 GPa\", \"1e6 GPa\", 0, 0, 0, 0]", "no deformation", "Tension is positive");
    let text = GOOD.replace("name = \"oil\"", "name = \"oil\"\nstress = [1.0, 0, 0, 0, 0, 0]");
    let found = model(&text, Path::new("")).map(|_| ()).unwrap_err();
    assert!(found[0].message.contains("`stress` is for solids"), "{found:?}");
}

#[test]
fn incompressible_solids_get_a_note_and_material_points_an_error() {
    let half = good(&GOOD.replace("poisson = 0.3", "poisson = 0.5"));
    let said = half
        .summary
        .notes
        .iter()
        .filter(|note| note.contains("10000 times the shear modulus") && note.contains("flap"));
    assert_eq!(said.count(), 1, "{:?}", half.summary.notes);
    expect("poisson = 0.3", "poisson = 0.51", "0.51", "0.5", "");
    let text = "name = \"bar\"\ndimension = 2\ntime = { end = 1.0 }\ngrid = { cell = 0.1, lower = [0, 0], upper = [1, 1] }\n\
        [[body]]\nname = \"bar\"\nregion = { shape = \"box\", lower = [0, 0], upper = [1, 1] }\nparticles-per-cell = 2\n\
        material = { law = \"neo-hookean\", density = 1200.0, young = 1e6, poisson = 0.5 }\n";
    let found = model(text, Path::new("")).map(|_| ()).unwrap_err();
    assert!(found.len() == 1 && found[0].message.contains("infinitely fast"), "{found:?}");
}

/// Stokes' layer is √(ν T/π) thick; elements of 0.02 m fill half of it at ν = π (0.04 m)²/T, and half of the layer of a
/// stream of the speed U along the 0.3 m of the flap, 2 √(ν 0.3 m/U), at ν = (0.02 m)² U/(0.3 m). The thicker one
/// counts.
#[test]
fn fluid_glides_where_elements_do_not_hold_its_layer() {
    let notes = |text: &str| good(text).summary.notes;
    let glides = |text: &str| notes(text).iter().any(|note| note.contains("glides along `flap`"));
    let periods = notes(GOOD).into_iter().find_map(|note| Some(note.split_once("flap ")?.1.to_owned())).unwrap();
    let longest: f64 = periods.split_once(" s").unwrap().0.parse().unwrap();
    let border = 1000.0 * std::f64::consts::PI * 0.04 * 0.04 / longest;
    let of_viscosity = |factor: f64| edited(GOOD, "1e-3 Pa s", &format!("{} Pa s", factor * border));
    let short = |text: &str| edited(text, "end = \"0.1 s\"\nstep = \"0.01 s\"", "end = \"5 ms\"\nstep = \"1 ms\"");
    let fast = |text: &str| short(&edited(text, "\"0.1 m/s\", 0", "\"50 m/s\", 0"));
    assert!(glides(GOOD) && glides(&fast(&of_viscosity(0.98))) && !glides(&fast(&of_viscosity(1.02))));
    let in_stream = 1000.0 * 0.02 * 0.02 * 0.1 / 0.3 / border;
    assert!(glides(&of_viscosity(0.98 * in_stream)) && !glides(&of_viscosity(1.02 * in_stream)));
    // In a stream that passes all of it, fluid sticks: 0.29 and 0.31 m in 0.1 s, along 0.3 m.
    let in_stream = |speed: &str| edited(GOOD, "\"0.1 m/s\", 0", &format!("\"{speed}\", 0"));
    assert!(glides(&in_stream("2.9 m/s")) && !glides(&in_stream("3.1 m/s")));
    let sticks = |text: &str| {
        notes(text).iter().any(|note| note.contains("oil sticks to `flap`") || note.contains("water sticks to `flap`"))
    };
    assert!(sticks(&in_stream("3.1 m/s")) && !sticks(&in_stream("2.9 m/s")));
    // So it does in one that pressures drive, √(2 Δp/ρ) = 3 m/s at 4.5 kPa, unless they bear a weight.
    let inlet = "kind = \"inlet\"\nvelocity = [\"0.1 m/s\", 0]\nfluid = \"oil\"";
    let pushed = |pressure: &str| {
        edited(GOOD, inlet, &format!("kind = \"pressure\"\npressure = \"{pressure}\"\nfluid = \"oil\""))
    };
    assert!(glides(&pushed("4.3 kPa")) && !glides(&pushed("4.7 kPa")));
    assert!(glides(&edited(&pushed("4.7 kPa"), "[pfem2]", "[pfem2]\ngravity = [0, \"-9.81 m/s^2\"]")));
    // A condition that the case gives counts, and a solid that isn't moved by its own inertia has no layer.
    for key in ["surface = \"no-slip\"", "surface = \"slip\"", "inertia = \"quasi-static\""] {
        assert!(!glides(&edited(GOOD, "plane = \"stress\"", &format!("plane = \"stress\"\n{key}"))), "{key}");
    }
    let at_rest = edited(GOOD, "[pfem2]", "[pfem2]\nstart = \"equilibrium\"");
    assert!(!glides(&edited(&at_rest, "\"0.1 m/s\", 0", "\"0.1 m/s * ramp(t, 1 s)\", 0")));
}

/// A tetrahedron with three edges of 0.3 m along the axes, from a file in millimetres.
/// A solid that nothing holds moves as a whole: 1.27 √(ν t) of 0.13 and 0.31 m count, of which elements of 0.1 m hold the
/// latter. Held, it swings, in layers below 0.03 m.
#[test]
fn fluid_sticks_to_a_free_solid_where_elements_hold_what_it_slows_down_in_the_run() {
    let text = r#"
name = "block"
method = "pfem2"
dimension = 2
time = { end = "1 s" }
mesh = { shape = "box", lower = [0, 0], upper = [2, 2], cell = "0.1 m" }
[[body]]
name = "block"
region = { shape = "box", lower = [0.8, 0.8], upper = [1.2, 1.2] }
material = { law = "neo-hookean", density = "1200 kg/m^3", young = "1 MPa", poisson = 0.3 }
[[body]]
name = "oil"
region = { shape = "box", lower = [-1, -1], upper = [3, 3] }
material = { law = "newtonian", density = "1000 kg/m^3", viscosity = "60 Pa s" }
[[boundary]]
on = "rest"
"#;
    let glides = |text: &str| {
        let notes = model(text, Path::new(".")).unwrap_or_else(|found| panic!("{found:#?}")).summary.notes;
        notes.iter().any(|note| note.contains("oil glides along `block`"))
    };
    assert!(!glides(text) && glides(&edited(text, "60 Pa s", "10 Pa s")));
    assert!(glides(&edited(text, "poisson = 0.3 }", "poisson = 0.3 }\nsupports = [{ on = \"bottom\" }]")));
}

#[test]
fn a_file_of_triangles_is_enough_for_a_rigid_solid() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = "solid tetrahedron\n".to_owned();
    let corner = [[0.0, 0.0, 0.0], [300.0, 0.0, 0.0], [0.0, 300.0, 0.0], [0.0, 0.0, 300.0]];
    for triangle in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]] {
        text += "facet normal 0 0 0\nouter loop\n";
        triangle.map(|a: usize| corner[a]).iter().for_each(|[x, y, z]| text += &format!("vertex {x} {y} {z}\n"));
        text += "endloop\nendfacet\n";
    }
    std::fs::write(folder.path().join("part.stl"), text + "endsolid\n").unwrap();
    let case = r#"
name = "part"
method = "pfem2"
dimension = 3
time = { end = "0.1 s", step = "0.01 s" }
mesh = { shape = "box", lower = [-0.2, -0.2, -0.2], upper = [1, 1, 1], cell = "0.2 m" }
[[body]]
name = "part"
region = { shape = "surface", file = "part.stl", unit = "1 mm" }
material = { law = "rigid", density = "2000 kg/m^3" }
[[body]]
name = "water"
region = { shape = "box", lower = [-1, -1, -1], upper = [2, 2, 2] }
material = { law = "newtonian", density = "1000 kg/m^3", viscosity = "1e-3 Pa s" }
[[boundary]]
on = "rest"
"#;
    let model_of = |text: &str| model(text, folder.path());
    let part = model_of(case).unwrap_or_else(|found| panic!("{found:#?}"));
    let [solid] = &part.summary.solids[..] else { panic!("one solid") };
    assert!((solid.mass / (2000.0 * 0.3f64.powi(3) / 6.0) - 1.0).abs() < 1e-6, "{solid:?}");
    assert!(part.summary.to_string().contains("rigid solid part: a surface of 57 nodes"), "{}", part.summary);
    // Elements of 0.2 m hold what honey slows down in 0.1 s, 0.4 m, and not what water does, 0.4 mm.
    let sticks = |text: &str| {
        let notes = model_of(text).unwrap_or_else(|found| panic!("{found:#?}")).summary.notes;
        notes.iter().any(|note| note.contains("water sticks to `part`"))
    };
    let glides = edited(case, "2000 kg/m^3\" }", "2000 kg/m^3\" }\nsurface = \"slip\"");
    assert!(sticks(case) && !sticks(&edited(case, "1e-3 Pa s", "1e3 Pa s")) && !sticks(&glides));
    // Between two fluids water glides along it by itself, unless it comes in somewhere.
    let air = "[[body]]\nname = \"air\"\nregion = { shape = \"box\", lower = [-1, -1, -1], upper = [2, 2, 2] }\n\
               material = { law = \"newtonian\", density = \"1 kg/m^3\", viscosity = \"1e-5 Pa s\" }\n[[boundary]]";
    let two = edited(&edited(case, "upper = [2, 2, 2]", "upper = [2, 2, 0.5]"), "[[boundary]]", air);
    let notes = model_of(&two).unwrap_or_else(|found| panic!("{found:#?}")).summary.notes;
    assert!(notes.iter().any(|note| note.contains("water glides along `part`")), "{notes:?}");
    let inlet = "[[boundary]]\non = \"left\"\nkind = \"inlet\"\nvelocity = [\"1 m/s\", 0, 0]\n[[boundary]]\non = \"right\"\nkind = \"outlet\"\n\
                 [[boundary]]";
    assert!(sticks(&edited(&two, "[[boundary]]", inlet)));
    let rubber = "law = \"neo-hookean\", density = \"1200 kg/m^3\", young = \"1 MPa\", poisson = 0.3";
    let refused = |text: &str, message: &str, help: &str| {
        let Err(found) = model_of(text) else { panic!("{message}") };
        let found: Vec<_> = found.iter().filter(|f| f.severity == Severity::Error).collect();
        assert!(found.len() == 1 && found[0].message.contains(message), "{found:#?}");
        assert!(found[0].help.as_deref().unwrap_or("").contains(help), "{found:#?}");
    };
    let rigid = "law = \"rigid\", density = \"2000 kg/m^3\"";
    // An elastic one has elements inside.
    let elastic = model_of(&case.replace(rigid, rubber)).unwrap_or_else(|found| panic!("{found:#?}"));
    assert!((elastic.summary.solids[0].mass / (1200.0 * 0.3f64.powi(3) / 6.0) - 1.0).abs() < 1e-6);
    assert!(!elastic.summary.to_string().contains("a surface of"), "{}", elastic.summary);
    let cells =
        case.replace("material = { law = \"rigid\"", "mesh = { cell = \"1 cm\" }\nmaterial = { law = \"rigid\"");
    refused(&cells, "is that of the file", "take it out");
}

#[test]
fn moments_are_of_solids_and_of_what_holds_the_fluid() {
    let text = GOOD.replace("plane = \"stress\"", "plane = \"stress\"\nmoment-about = [\"45 cm\", 0]");
    let text = text.replace("on = \"left\"\nkind", "on = \"left\"\nmoment-about = [0, \"1 m\"]\nkind");
    let moments = good(&text).solver.snapshot().moments.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    assert_eq!(moments, ["left", "flap", "support:flap[0]", "contacts:flap"]);
    let open = "on = \"right\"\nkind";
    expect(open, "on = \"right\"\nmoment-about = [0, 0]\nkind", "[0, 0]\nkind", "holds nothing", "inlets");
    let text = GOOD.replace("name = \"oil\"", "name = \"oil\"\nmoment-about = [0, 0]");
    let found = model(&text, Path::new("")).map(|_| ()).unwrap_err();
    assert!(found[0].message.contains("`moment-about` is for solids"), "{found:?}");
    // Their forces would be written to one file.
    let text = GOOD.replace("on = \"right\"\nkind", "on = \"right\"\nname = \"flap\"\nkind");
    good(&text);
    let found = model(&GOOD.replace("on = \"left\"\n", "on = \"left\"\nname = \"flap\"\n"), Path::new("")).map(|_| ());
    assert!(found.unwrap_err()[0].message.contains("would be written to"), "one file");
}

#[test]
fn solids_that_overlap_are_refused_and_may_touch() {
    let second = |lower: &str| {
        let body = format!(
            "[[body]]\nname = \"block\"\nregion = {{ shape = \"box\", lower = [\"{lower}\", \"5 cm\"], upper = [\"0.8 m\", \"0.2 m\"] }}\n\
             material = {{ law = \"neo-hookean\", density = 1200.0, young = 1e6, poisson = 0.3 }}\n[[tension]]"
        );
        model(&GOOD.replace("[[tension]]", &body), Path::new(""))
    };
    assert!(second("0.5 m").is_ok());
    let found = second("0.42 m").map(|_| ()).unwrap_err();
    assert!(found.len() == 1 && found[0].message.contains("lie in `block`"), "{found:?}");
}

/// A wall across the whole channel parts the fluid on its left, which nothing opens, from that at the outlet.
#[test]
fn fluid_that_solids_close_off_is_noted() {
    let notes = |text: &str| model(text, Path::new("")).unwrap_or_else(|found| panic!("{found:#?}")).summary.notes;
    let is_told =
        |text: &str| notes(text).iter().filter(|note| note.contains("solids close off the fluid around (0.2")).count();
    let across = edited(GOOD, "upper = [\"0.5 m\", \"0.3 m\"]", "upper = [\"0.5 m\", \"0.5 m\"]");
    let across = across.replace("[{ on = \"bottom\" }]", "[{ on = \"bottom\" }, { on = \"top\" }]");
    assert_eq!([is_told(GOOD), is_told(&across)], [0, 1], "{:?}", notes(&across));
}

/// Nothing lifts off a wall that it lies on: the elements there have no fluid.
#[test]
fn solids_that_lie_on_a_wall_without_a_support_are_refused() {
    let supports = "supports = [{ on = \"bottom\" }]";
    expect(supports, "friction = 0.3", "[[body]]", "`flap` touches the boundary of the mesh at (0.4", "move it away");
    // Half a solid on a plane of symmetry glides along it.
    let guided = r#"supports = [{ on = "bottom", velocity = ["free", 0] }]"#;
    assert!(model(&edited(GOOD, supports, guided), Path::new("")).is_ok());
}

#[test]
fn keys_of_solids_do_not_belong_to_material_points() {
    let text = "name = \"bar\"\ndimension = 2\ntime = { end = 1.0 }\ngrid = { cell = 0.1, lower = [0, 0], upper = [1, 1] }\n\
        [[body]]\nname = \"bar\"\nregion = { shape = \"box\", lower = [0, 0], upper = [1, 1] }\nparticles-per-cell = 2\n\
        material = { law = \"neo-hookean\", density = 1200.0, young = 1e6, poisson = 0.3 }\nsupports = [{ on = \"left\" }]\n";
    let found = model(text, Path::new("")).map(|_| ()).unwrap_err();
    assert!(
        found.len() == 1 && found[0].message.contains("`body[0].supports` does not belong to `method = \"mpm\"`"),
        "{found:?}"
    );
    let text = text.replace("supports = [{ on = \"left\" }]", "traction = [{ on = [0.0, 0.5], value = [1.0, 0] }]");
    let found = model(&text, Path::new("")).map(|_| ()).unwrap_err();
    assert!(found.len() == 1 && found[0].message.contains("act on a side of the body"), "{found:?}");
    let text = text.replace("region = { shape = \"box\", lower = [0, 0], upper = [1, 1] }\n", "");
    let found = model(&text, Path::new("")).map(|_| ()).unwrap_err();
    assert!(found.len() == 1 && found[0].message.contains("the key `region` is missing"), "{found:?}");
}

/// A flap on particles, under the preset of the paper.
const PAPER: &str = r#"
name = "flap"
method = "pfem2"
dimension = 2
preset = "becker-2015"
[time]
end = "0.1 s"
step = "0.01 s"
[mesh]
shape = "box"
lower = ["0 m", "0 m"]
upper = ["1 m", "0.5 m"]
cell = "0.02 m"
[[body]]
name = "water"
region = { shape = "box", lower = ["-1 m", "-1 m"], upper = ["2 m", "2 m"] }
material = { law = "newtonian", density = "1000 kg/m^3", viscosity = "1e-3 Pa s" }
[[body]]
name = "flap"
region = { shape = "box", lower = ["0.4 m", "0 m"], upper = ["0.5 m", "0.3 m"] }
material = { law = "hypoelastic", density = "1200 kg/m^3", young = "1 MPa", poisson = 0.3 }
plane = "stress"
supports = [{ on = { shape = "box", lower = ["0.3 m", "-0.1 m"], upper = ["0.6 m", "0.05 m"] } }]
[[boundary]]
on = "rest"
"#;

/// Expects one error at the place of `at`, after `from` was replaced by `to` in the case of the paper.
#[track_caller]
fn expect_of_paper(from: &str, to: &str, at: &str, message: &str, help: &str) {
    expect_error(&edited(PAPER, from, to), at, message, help);
}

#[test]
fn a_solid_on_particles_has_its_volume_and_comes_before_fluids() {
    let model = good(PAPER);
    let volumes: Vec<(&str, f64)> = model.summary.bodies.iter().map(|body| (body.name.as_str(), body.volume)).collect();
    assert_eq!((volumes[0].0, volumes[1].0), ("water", "flap"));
    assert!((volumes[1].1 - 0.03).abs() < 1e-3 && (volumes[0].1 + volumes[1].1 - 0.5).abs() < 1e-12, "{volumes:?}");
    let snapshot = model.solver.snapshot();
    let flap = snapshot.points.iter().find(|set| set.name == "flap").expect("particles");
    assert!(flap.fields.iter().any(|field| field.name == "stress"));
    assert!(snapshot.forces.iter().any(|(name, _)| name == "flap"));
    assert!(snapshot.ledger.terms.iter().any(|term| term.name == "strain energy"));
}

#[test]
fn keys_that_solids_on_particles_lack_are_an_error() {
    let law = "law = \"hypoelastic\", density = \"1200 kg/m^3\", young = \"1 MPa\", poisson = 0.3";
    for other in ["neo-hookean", "st-venant-kirchhoff"] {
        // Without the keys that are those of particles.
        let text = PAPER.replace("hypoelastic", other);
        let Err(found) = model(&text, Path::new("")) else { panic!("{other} is refused") };
        assert!(
            found.iter().any(|f| f.message.contains("with a law in rates") && f.key == "body[1].material"),
            "{found:#?}"
        );
    }
    let metal = "law = \"j2\", density = \"1200 kg/m^3\", young = \"1 MPa\", poisson = 0.3, yield-stress = \"1 kPa\"";
    let Err(found) = model(&PAPER.replace(law, metal), Path::new("")) else { panic!("a law that yields is refused") };
    assert!(found.iter().any(|f| f.message.contains("`j2` is none")), "{found:#?}");
    expect_of_paper("poisson = 0.3", "poisson = 0.495", "0.495", "0.49 at most", "smaller");
    for key in
        ["mesh = { cell = \"0.05 m\" }", "friction = 0.3", "surface = \"slip\"", "damping = { mass = \"0.1 1/s\" }"]
    {
        let name = key.split(' ').next().unwrap();
        let to = format!("plane = \"stress\"\n{key}");
        expect_of_paper(
            "plane = \"stress\"",
            &to,
            "",
            &format!("`{name}` is for solids on meshes of their own"),
            "preset",
        );
    }
    let box_support = "on = { shape = \"box\", lower = [\"0.3 m\", \"-0.1 m\"], upper = [\"0.6 m\", \"0.05 m\"] }";
    expect_of_paper(box_support, "on = \"bottom\"", "\"bottom\"", "no sides or nodes of its own", "region");
    let above = box_support.replace("\"-0.1 m\"", "\"0.31 m\"").replace("\"0.05 m\"", "\"0.4 m\"");
    expect_of_paper(box_support, &above, "", "no node of the mesh lies in this region", "larger");
    expect_of_paper(
        "[[boundary]]",
        "[pfem2]\nscheme = \"second-order\"\n[[boundary]]",
        "\"second-order\"",
        "time integration",
        "backward-euler",
    );
    expect_of_paper(
        "[[boundary]]",
        "[pfem2]\ninterface = \"sharp\"\n[[boundary]]",
        "\"sharp\"",
        "where their particles are",
        "pseudo",
    );
    let oil = "[[body]]\nname = \"oil\"\nregion = { shape = \"box\", lower = [-1, -1], upper = [2, 0.2] }\n\
               material = { law = \"newtonian\", density = 800, viscosity = 0.01 }\n[[boundary]]";
    let oil_first =
        PAPER.replace("[[boundary]]", oil).replace("lower = [\"-1 m\", \"-1 m\"]", "lower = [\"-1 m\", \"0.2 m\"]");
    let Err(found) = model(&oil_first, Path::new("")) else { panic!("two fluids are refused") };
    assert!(found.iter().any(|f| f.message.contains("in one fluid, and here are 2")), "{found:#?}");
    expect_of_paper(
        "lower = [\"0.4 m\", \"0 m\"], upper = [\"0.5 m\"",
        "lower = [\"0.405 m\", \"0 m\"], upper = [\"0.415 m\"",
        "",
        "elements are larger than it",
        "refine",
    );
}

/// The flap as a rigid solid.
fn stiff() -> String {
    let rubber = "law = \"neo-hookean\", density = \"1200 kg/m^3\", young = \"1 MPa\", poisson = 0.3";
    GOOD.replace(rubber, "law = \"rigid\", density = \"1200 kg/m^3\"").replace("plane = \"stress\"\n", "")
}

/// Errors of a case, with the keys that they are about.
fn errors(text: &str) -> Vec<(String, String, String)> {
    let found = model(text, Path::new("")).map(|_| ()).expect_err("a finding");
    let errors = found.into_iter().filter(|finding| finding.severity == Severity::Error);
    errors.map(|finding| (finding.key, finding.message, finding.help.unwrap_or_default())).collect()
}

#[test]
fn a_rigid_solid_has_a_mass_a_motion_and_no_strain() {
    let model = good(&stiff());
    let [solid] = &model.summary.solids[..] else { panic!("one solid") };
    assert!(solid.is_rigid && (solid.mass - 36.0).abs() < 1e-9, "{solid:?}");
    assert!(model.summary.to_string().contains("rigid solid flap"), "{}", model.summary);
    let motion = "motion = { velocity = [\"free\", \"0.1 m/s\"], spin = [\"2 * cos(t / 1 s) / 1 s\"] }\ndamping";
    let moved = stiff().replace("supports = [{ on = \"bottom\" }]\n", "").replace("damping", motion);
    good(&moved);
    let resolved = Case::read(Source::new("case.toml", "", &moved), &[]).unwrap().resolved_toml();
    assert!(resolved.contains("[body.motion]"), "{resolved}");
    let wrong = [
        (moved.replace("spin = [", "spin = [0.0, 0.0, "), "body[0].motion.spin", "expected 1 entry, found 3", "in 2D"),
        (stiff().replace("damping", "plane = \"stress\"\ndamping"), "body[0].plane", "no strain", "elastic law"),
        (GOOD.replace("damping", motion), "body[0].motion", "this one is elastic", "law = \"rigid\""),
        (
            stiff().replace("{ on = \"bottom\" }", "{ on = \"bottom\" }, { on = \"top\", velocity = [\"1 m/s\", 0] }"),
            "body",
            "ask for a deformation",
            "",
        ),
    ];
    for (text, key, message, help) in wrong {
        let found = errors(&text);
        let told =
            |(at, what, how): &(String, String, String)| at == key && what.contains(message) && how.contains(help);
        assert!(found.iter().any(told), "{key}: {found:?}");
    }
}

#[test]
fn wrong_springs_and_bonds_are_found_at_their_keys() {
    let spring = "{ on = \"bottom\", stiffness = [\"1 kN/m\", 0], damping = [0, \"2 N s/m\"] }";
    let lifted = GOOD.replace("lower = [\"0.4 m\", \"0 m\"]", "lower = [\"0.4 m\", \"2 cm\"]");
    good(&lifted.replace("{ on = \"bottom\" }", spring));
    let second = |bond: &str, lower: &str| {
        let body = format!(
            "[[body]]\nname = \"block\"\nregion = {{ shape = \"box\", lower = [\"{lower}\", \"5 cm\"], upper = [\"0.8 m\", \"0.2 m\"] }}\n\
             material = {{ law = \"rigid\", density = 1200.0 }}\nbond = [\"{bond}\"]\n[[tension]]"
        );
        GOOD.replace("[[tension]]", &body)
    };
    good(&second("flap", "0.5 m"));
    let moving = spring.replace("stiffness", "velocity = [0, 0], stiffness");
    let wrong = [
        (GOOD.replace("{ on = \"bottom\" }", &moving), "body[0].supports[0].velocity", "where its nodes start"),
        (
            GOOD.replace("{ on = \"bottom\" }", &spring.replace("1 kN", "-1 kN")),
            "body[0].supports[0].stiffness",
            "negative",
        ),
        (second("water", "0.5 m"), "body[3].bond[0]", "no other solid `water`"),
        (second("block", "0.5 m"), "body[3].bond[0]", "no other solid `block`"),
        (second("flap", "0.6 m"), "body[3].bond", "only solids that touch"),
    ];
    for (text, key, message) in wrong {
        let found = errors(&text);
        assert!(found.iter().any(|(at, what, _)| at == key && what.contains(message)), "{key}: {found:?}");
    }
}

#[test]
fn material_points_are_not_rigid() {
    let text = "name = \"bar\"\ndimension = 2\ntime = { end = 1.0 }\ngrid = { cell = 0.1, lower = [0, 0], upper = [1, 1] }\n\
        [[body]]\nname = \"bar\"\nregion = { shape = \"box\", lower = [0, 0], upper = [1, 1] }\nparticles-per-cell = 2\n\
        material = { law = \"rigid\", density = 1200.0 }\n";
    let found = errors(text);
    assert!(found.iter().any(|(_, what, _)| what.contains("it is for `method = \"pfem2\"`")), "{found:?}");
}

/// α = 2 ζ ω and β = 2 ζ/ω.
#[test]
fn damping_may_be_given_by_its_ratio_at_a_frequency() {
    let ratio = "{ ratio = 0.02, at = \"5 Hz\" }";
    let text = GOOD.replace("mass = \"0.1 1/s\"", &format!("mass = {ratio}, stiffness = {ratio}"));
    let case = Case::read(Source::new("case.toml", Path::new(""), &text), &[]).unwrap();
    let damping: Damping = case.file.body[0].damping.unwrap().into();
    let omega = 10.0 * std::f64::consts::PI;
    assert!(
        (damping.mass - 0.04 * omega).abs() < 1e-14 && (damping.stiffness - 0.04 / omega).abs() < 1e-16,
        "{damping:?}"
    );
    let wrong = GOOD.replace("mass = \"0.1 1/s\"", "stiffness = { ratio = 0.02, at = \"0 Hz\" }");
    let Err(found) = model(&wrong, Path::new("")) else { panic!("a frequency of zero is refused") };
    assert!(found.iter().any(|finding| finding.key.contains("damping")), "{found:?}");
}

#[test]
fn a_start_in_equilibrium_is_one_at_rest() {
    let still = GOOD.replace("volume = \"none\"", "volume = \"none\"\nstart = \"equilibrium\"");
    let still = still.replace("velocity = [\"0.1 m/s\", 0]", "velocity = [\"0.1 m/s * ramp(t, 1 s)\", 0]");
    good(&still);
    let moving_support = still.replace("{ on = \"bottom\" }", "{ on = \"bottom\", velocity = [\"1 m/s\", 0] }");
    let wrong = [
        (still.replace("0.1 m/s * ramp(t, 1 s)", "0.1 m/s"), "boundary"),
        (still.replace("plane = \"stress\"", "plane = \"stress\"\nvelocity = [0, \"1 m/s\"]"), "body[0].velocity"),
        (moving_support, "body[0].supports[0]"),
        (still.replace("name = \"oil\"\n", "name = \"oil\"\nvelocity = [0, \"1 m/s\"]\n"), "pfem2.start"),
    ];
    for (text, key) in wrong {
        let found = errors(&text);
        assert!(found.iter().any(|(at, what, _)| at == key && what.contains("one at rest")), "{key}: {found:?}");
    }
    let begin = still.find("[[body]]\nname = \"flap\"").unwrap();
    let end = still.find("[[body]]\nname = \"water\"").unwrap();
    let found = errors(&format!("{}{}", &still[..begin], &still[end..]));
    assert!(found.iter().any(|(at, what, _)| at == "pfem2.start" && what.contains("no solid")), "{found:?}");
}

/// Elastic solids bounce by their waves, and a coefficient of restitution is between 0 and 1.
#[test]
fn restitution_is_a_part_of_the_speed_of_a_rigid_solid() {
    good(&stiff().replace("supports", "restitution = 0.8\nsupports"));
    for (text, says) in [
        (stiff().replace("supports", "restitution = 1.2\nsupports"), "1.2"),
        (stiff().replace("supports", "restitution = -0.1\nsupports"), "-0.1"),
        (GOOD.to_owned(), "elastic"),
    ] {
        let text = if says == "elastic" { text.replacen("supports", "restitution = 0.8\nsupports", 1) } else { text };
        let found = errors(&text);
        let names = found.iter().any(|(at, what, _)| at == "body[0].restitution" && what.contains(says));
        assert!(names, "{says}: {found:?}");
    }
}

#[test]
fn a_rigid_solid_moves_by_its_inertia() {
    let found = errors(&stiff().replace("supports", "inertia = \"quasi-static\"\nsupports"));
    assert!(found.iter().any(|(at, ..)| at == "body[0].inertia"), "{found:?}");
}
