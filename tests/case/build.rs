//! From cases to solvers: sizes against counts by hand, and errors between the parts of a case.

use super::findings::{edited, expect_one, good, good_with, overridden};
use lateen::Error;
use lateen::case::{Case, Model, Source};
use lateen::error::{Diagnostic, Place};
use std::path::Path;

const GOOD: &str = include_str!("../fixtures/water_sphere.toml");

fn model(text: &str, overrides: &[(&str, &str)]) -> Result<Model, Vec<Diagnostic>> {
    overridden(text, Path::new(""), overrides)
}

/// Expects one finding at the place of `at` after replacing `from` by `to`.
#[track_caller]
fn expect(from: &str, to: &str, at: &str, message: &str, help: &str) {
    let text = edited(GOOD, from, to);
    expect_one(&model(&text, &[]).err().unwrap_or_default(), &text, at, message, help);
}

#[test]
fn the_water_sphere_has_the_particles_elements_and_cells_of_the_paper() {
    let summary = good(GOOD).summary;
    // 4π R³/3h³ = 3053.6 lattice points; 50 × 50 quadrilaterals; 54 × 54 × 26 cells.
    assert!((summary.particles() as f64 / 3053.6 - 1.0).abs() < 0.02);
    assert_eq!((summary.membranes[0].nodes, summary.membranes[0].elements), (2601, 2500));
    assert_eq!(summary.cells, 54.0 * 54.0 * 26.0);
    // The volume is that of the sphere: 0.3817 g of water.
    assert!((summary.bodies[0].volume * 1e9 - 381.704).abs() < 1e-3);
    assert!(summary.stable_step > 0.0 && summary.steps > 100.0);
}

#[test]
fn a_plane_column_has_its_area_and_hydrostatic_pressure() {
    let text = r#"
        name = "column"
        dimension = 2
        time = { end = "0.1 s" }
        grid = { cell = "0.1 m", lower = [0, 0], upper = [1, 2], walls = { bottom = "fixed", left = "slip", right = "slip" } }
        mpm = { gravity = [0, "-9.81 m/s^2 * ramp(t, 1 s)"] }
        [[body]]
        name = "water"
        region = { shape = "box", lower = [0, 0], upper = [1, 1] }
        particles-per-cell = 2
        pressure = "1000 kg/m^3 * 9.81 m/s^2 * (1 m - y)"
        traction = [{ on = "top", value = [0, "-1 kPa"] }]
        material = { law = "fluid", density = 1000, eos = { kind = "tait", sound-speed = "35 m/s", exponent = 7 } }
    "#;
    let model = good(text);
    assert_eq!(model.summary.particles(), 400);
    assert!((model.summary.bodies[0].volume - 1.0).abs() < 1e-12);
    let snapshot = model.solver.snapshot();
    let pressure = snapshot.points[0].fields.iter().find(|f| f.name == "pressure").expect("a pressure");
    let greatest = pressure.values().iter().fold(0.0_f64, |a, &b| a.max(b));
    assert!((greatest - 9810.0 * 0.975).abs() < 1e-6 * greatest, "{greatest}");
}

#[test]
fn overlapping_bodies_are_an_error_and_touching_ones_are_not() {
    let second = "\n[[body]]\nname = \"rock\"\nregion = { shape = \"box\", lower = [\"4 mm\", \"-1 mm\", \"4 mm\"], upper = [\"9 mm\", \"1 mm\", \"6 mm\"] }\nspacing = \"0.5 mm\"\nmaterial = { law = \"hypoelastic\", density = 2000, young = \"1 MPa\", poisson = 0.2 }\n";
    expect(
        "\n[[contact]]",
        &format!("{second}\n[[contact]]"),
        "{ shape = \"box\"",
        "`rock` overlaps `water`",
        "move one of them",
    );
    let touching = second.replace("[\"4 mm\", \"-1 mm\"", "[\"4.5 mm\", \"-1 mm\"");
    good(&GOOD.replace("\n[[contact]]", &format!("{touching}\n[[contact]]")));
}

#[test]
fn a_body_that_lies_between_the_particles_of_another_overlaps_it() {
    // The particles of the water lie at odd multiples of a quarter of a millimetre.
    let speck = "\n[[body]]\nname = \"speck\"\nregion = { shape = \"box\", lower = [\"0.05 mm\", \"0.05 mm\", \"5.55 mm\"], upper = [\"0.2 mm\", \"0.2 mm\", \"5.7 mm\"] }\nspacing = \"0.05 mm\"\nmaterial = { law = \"hypoelastic\", density = 2000, young = \"1 MPa\", poisson = 0.2 }\n";
    expect(
        "\n[[contact]]",
        &format!("{speck}\n[[contact]]"),
        "{ shape = \"box\"",
        "`speck` overlaps `water`: 27 particles",
        "move one of them",
    );
}

#[test]
fn bodies_and_membranes_within_an_obstacle_are_errors() {
    let floor = |height: &str, more: &str| {
        format!(
            "\n[[obstacle]]\nname = \"floor\"\nregion = {{ shape = \"half-space\", point = [0, 0, \"{height}\"], normal = \"z\" }}\n{more}\n[[contact]]"
        )
    };
    let slab = |top: &str| {
        let region = format!(
            "{{ shape = \"box\", lower = [\"-5 mm\", \"-5 mm\", \"0.6 mm\"], upper = [\"5 mm\", \"5 mm\", \"{top}\"] }}"
        );
        format!("\n[[obstacle]]\nname = \"floor\"\nregion = {region}\n[[contact]]")
    };
    let message = "`water` lies in the obstacle `floor`";
    expect("\n[[contact]]", &slab("5 mm"), "{ shape = \"sphere\"", message, "may touch an obstacle");
    // All nodes of the sheet but those on its edges and the one that is moved.
    let message = "2400 free nodes of `sheet` lie in the obstacle `floor`, the deepest at (";
    let Err(buried) = model(&GOOD.replace("\n[[contact]]", &floor("0.9 mm", "")), &[]) else { panic!("{message}") };
    assert!(
        buried.iter().any(|finding| {
            let told =
                finding.message.starts_with(message) && finding.message.ends_with(", 9.000e-4 m below its surface");
            told && finding.key == "membrane[0].geometry"
        }),
        "{buried:#?}"
    );
    assert!(buried.iter().any(|finding| finding.message.starts_with("supports hold 201 nodes")), "{buried:#?}");
    let coefficient = floor("-5 mm", "coefficient = 0.3");
    expect("\n[[contact]]", &coefficient, "0.3\n[[contact]]", "has no friction", "kind = \"friction\"");
    let warnings = good(&GOOD.replace("\n[[contact]]", &floor("-50 mm", ""))).warnings;
    assert!(warnings.len() == 1 && warnings[0].message.contains("outside the grid"), "{warnings:#?}");
    assert_eq!(good(&GOOD.replace("\n[[contact]]", &slab("1 mm"))).warnings, []);
    assert_eq!(good(&GOOD.replace("\n[[contact]]", &floor("-1 mm", ""))).warnings, []);
}

#[test]
fn supports_that_prescribe_two_velocities_at_a_node_are_an_error() {
    let both = |velocity: &str| format!("{{ on = \"edges\" }}, {{ on = \"left\", velocity = {velocity} }}, {{ on = [");
    let pull = both("[0, \"1 m/s\", \"free\"]");
    let message = "supports[0] moves node 0 along y with another velocity";
    expect("{ on = \"edges\" }, { on = [", &pull, "{ on = \"left\"", message, "write \"free\"");
    good(&GOOD.replace("{ on = \"edges\" }, { on = [", &both("[0, 0, \"free\"]")));
}

#[test]
fn repeated_contacts_and_contacts_of_two_membranes_are_errors() {
    let again = "friction = 0.2\n[[contact]]\nbetween = [\"sheet\", \"water\"]\nfriction = 0.1\n";
    let at = "[\"sheet\", \"water\"]";
    expect("friction = 0.2\n", again, at, "this pair already has a contact, contact[0]", "one friction");
    let second = "\n[[membrane]]\nname = \"lid\"\nthickness = \"0.1 mm\"\ngeometry = { shape = \"sheet\", center = [0, 0, \"12 mm\"], size = [\"20 mm\", \"20 mm\"], divisions = [20, 20], normal = \"z\" }\nmaterial = { law = \"elastic\", density = 1000, young = \"1 GPa\", poisson = 0.3 }\n";
    let pair = format!("{second}\n[[contact]]\nbetween = [\"lid\", \"sheet\"]\nfriction = 0.1\n[[contact]]");
    expect("\n[[contact]]", &pair, "[\"lid\", \"sheet\"]", "are membranes, which don't meet", "a body and a membrane");
}

#[test]
fn unstable_combinations_of_kernel_transfer_and_stress_update_are_warned_of() {
    let apic = [("mpm.kernel", "linear"), ("mpm.transfer", "{ kind = \"apic\" }")];
    let warnings = good_with(GOOD, &apic).warnings;
    assert!(warnings.len() == 1 && warnings[0].message.contains("unstable at free surfaces"), "{warnings:#?}");
    assert_eq!(good_with(GOOD, &apic[1..]).warnings, []);
    let last = [("mpm.kernel", "linear"), ("mpm.stress-update", "last"), ("mpm.transfer", "{ kind = \"flip\" }")];
    let warnings = good_with(GOOD, &last).warnings;
    assert!(warnings.len() == 1 && warnings[0].message.contains("inside out"), "{warnings:#?}");
    assert_eq!(good_with(GOOD, &last[1..]).warnings, []);

    let wide = GOOD.replace("\"-27 mm\", \"-27 mm\", \"-12 mm\"", "\"-25 mm\", \"-27 mm\", \"-12 mm\"");
    let loose = wide.replace("{ on = \"edges\" }", "{ on = \"edges\", velocity = [\"free\", 0, 0] }");
    let warnings = good(&loose).warnings;
    assert!(
        warnings.len() == 1 && warnings[0].message.contains("51 nodes of `sheet` on the plane of"),
        "{warnings:#?}"
    );
    assert!(warnings[0].help.as_deref().unwrap_or("").contains("along x with `supports`"), "{warnings:#?}");
    assert_eq!(good(&wide).warnings, []);
}

#[test]
fn particles_and_nodes_outside_the_grid_are_errors() {
    expect(
        "\"14 mm\"]",
        "\"8 mm\"]",
        "{ shape = \"sphere\"",
        "particles of `water` lie outside the grid",
        "enlarge the grid",
    );
    expect(
        "size = [\"50 mm\"",
        "size = [\"80 mm\"",
        "{ shape = \"sheet\"",
        "nodes of `sheet` lie outside the grid",
        "",
    );
}

#[test]
fn a_grid_of_a_fractional_or_negative_number_of_cells_is_an_error() {
    expect("\"14 mm\"]", "\"14.3 mm\"]", "\"14.3 mm\"]", "not a whole number", "upper end is 0.014 m");
    let message = "`upper` must exceed `lower` along z: -0.014 m is not above -0.012 m";
    expect("\"14 mm\"]", "\"-14 mm\"]", "\"-14 mm\"]", message, "the upper one in `upper`");
}

#[test]
fn a_body_without_particles_or_spacing_is_an_error() {
    expect("spacing = \"0.5 mm\"", "spacing = \"50 mm\"", "{ shape = \"sphere\"", "no particles", "decrease `spacing`");
    expect(
        "spacing = \"0.5 mm\"\n",
        "",
        "[[body]]",
        "the distance of the particles is missing",
        "particles-per-cell = 2",
    );
}

#[test]
fn a_membrane_with_elements_of_many_cells_is_an_error() {
    // Without the support of the centre, whose nearest node is a corner here.
    let (edges, centre) = GOOD.split_once(", { on = [\"0 mm\"").expect("two supports");
    let text = format!("{edges}]\n{}", centre.split_once("}]\n").expect("the end of the list").1);
    let text = text.replace("divisions = [50, 50]", "divisions = [1, 1]");
    let Err(found) = model(&text, &[]) else { panic!("the elements are too coarse") };
    assert_eq!((found.len(), found[0].key.as_str()), (1, "membrane[0].geometry"), "{found:#?}");
    assert!(found[0].message.contains("too coarse for the grid"), "{found:#?}");
    assert!(found[0].help.as_deref().unwrap_or("").contains("32 cells"), "{found:#?}");
}

#[test]
fn a_support_on_an_unknown_set_of_nodes_lists_the_known_ones() {
    expect("on = \"edges\"", "on = \"egdes\"", "\"egdes\"", "no such set of nodes", "all, edges, back");
}

#[test]
fn unknown_and_repeated_names_of_parts_are_errors() {
    expect("[\"water\", \"sheet\"]", "[\"water\", \"shet\"]", "\"shet\"", "named `shet`", "water, sheet");
    let probe = "\n[[probe]]\nname = \"p\"\nof = \"wter\"\nreduce = \"mean\"\n";
    expect("\n[[contact]]", &format!("{probe}\n[[contact]]"), "\"wter\"", "named `wter`", "water");
    let twice = GOOD.replace("name = \"sheet\"", "name = \"water\"");
    let Err(found) = model(&twice, &[]) else { panic!("two parts have one name") };
    assert!(found[0].message.contains("already something named `water`"), "{found:#?}");
}

#[test]
fn a_step_above_the_stable_one_is_an_error_and_a_shorter_interval_is_warned_of() {
    expect(
        "end = \"1.2 ms\"",
        "end = \"1.2 ms\"\nstep = \"1 us\"",
        "\"1 us\"",
        "the step of 1.0000e-6 s is above the stable one of",
        "leave `step` out: it then adapts (`mpm.safety` is 0.3)",
    );
    let model = good_with(GOOD, &[("output.history", "1e-12")]);
    assert_eq!(model.warnings.len(), 1);
    assert!(model.warnings[0].message.contains("is shorter than the step"), "{:?}", model.warnings);
}

#[test]
fn formulas_that_divide_by_zero_in_the_run_are_errors_before_it() {
    let pressure = "\"1 kPa * ramp(t, 0.1 ms)\"";
    expect(pressure, "\"1 kPa * (1 us) / t\"", "\"1 kPa * (1 us)", "the formula gives inf at x =", "divides by zero");
    expect(pressure, "\"1 Pa / (t / 0.6 ms - 1)\"", "\"1 Pa / (t", "the formula gives inf", "");
    expect(
        "velocity = [0, 0, \"-10 mm/ms\"]",
        "velocity = [0, 0, \"sqrt(-z)\"]",
        "\"sqrt(-z)\"",
        "the formula gives NaN",
        "",
    );
}

/// A net below a block, 0.06 m from node to node: its middle is at x = 1 but for rounding.
const NET: &str = r#"
    name = "net"
    dimension = 2
    time = { end = "10 ms" }
    grid = { cell = "0.1 m", lower = [0, 0], upper = [2, 2], walls = { bottom = "slip" } }
    mpm = { gravity = [0, -9.81] }
    [[body]]
    name = "block"
    spacing = "0.05 m"
    region = { shape = "box", lower = [0.4, 0.4], upper = [0.8, 0.8] }
    material = { law = "hypoelastic", density = 1000, young = 1e5, poisson = 0.3 }
    [[membrane]]
    name = "net"
    geometry = { shape = "chain", points = [[0.1, 0.2], [1.9, 0.2]], divisions = [30] }
    thickness = "1 mm"
    velocity = [0, -10]
    material = { law = "elastic", density = 500, young = "1 MPa", poisson = 0.3 }
"#;

#[test]
fn a_pole_at_a_node_is_an_error_even_where_rounding_makes_it_finite() {
    let text = NET.replace("[0, -9.81]", "[\"1/(x - 1)\", 0]");
    let Err(found) = model(&text, &[]) else { panic!("a pole lies at a node") };
    assert!(found.len() == 1 && found[0].key == "mpm.gravity[0]", "{found:#?}");
    assert!(found[0].message.contains("e15 at x = 0.99999"), "{found:#?}");
    good(&NET.replace("[0, -9.81]", "[\"step(x - 1)\", \"1/(x - 0.97)^2\"]"));
    let text = NET.replace("bottom = \"slip\"", "bottom = { kind = \"slip\", velocity = [\"1/(x - 1)\", 0] }");
    let Err(found) = model(&text, &[]) else { panic!("a pole lies at a node of the wall") };
    assert!(found[0].key.starts_with("grid.walls.bottom.velocity"), "{found:#?}");
}

/// Formulas of the place that are defined at the start, and not at the places that particles, nodes and elements reach.
#[test]
fn a_formula_that_becomes_undefined_stops_the_run_and_is_named() {
    let error = |text: &str| {
        let (mut solver, mut t) = (good(text).solver, 0.0);
        loop {
            let dt = solver.stable_dt().min(1e-4);
            match solver.step(t, dt) {
                Ok(()) => t += dt,
                Err(error) => return error,
            }
        }
    };
    let loaded = error(&format!("{NET}    pressure = {{ value = \"1e-3*sqrt(y - 0.19)\" }}\n"));
    assert!(loaded.what.contains("the formula of `membrane[0].pressure.value` has no value"), "{loaded}");
    assert!((loaded.time - 1e-3).abs() < 2.1e-4 && matches!(loaded.place, Place::Element { .. }), "{loaded}");
    let drawn = error(&NET.replace("[0, -9.81]", "[0, \"sqrt(y - 0.19)\"]"));
    assert!(drawn.what.contains("the formula of `mpm.gravity[1]` has no value"), "{drawn}");
    assert!(matches!(drawn.place, Place::Node { .. }), "{drawn}");
    let fallen = NET
        .replace("[0, -9.81]", "[\"sqrt(y - 0.41)\", 0]")
        .replace("[0.1, 0.2], [1.9, 0.2]", "[0.1, 1.2], [1.9, 1.2]");
    let fallen = error(&fallen.replace("name = \"block\"", "name = \"block\"\n    velocity = [0, -2]"));
    assert!(fallen.what.contains("the formula of `mpm.gravity[0]` has no value"), "{fallen}");
    assert!(matches!(fallen.place, Place::Particle { .. }), "{fallen}");
}

#[test]
fn a_membrane_across_a_solid_is_warned_of() {
    let across = NET.replace("lower = [0.4, 0.4]", "lower = [0.4, 0.1]");
    let warnings = good(&across).warnings;
    assert!(warnings.len() == 1 && warnings[0].message.contains("`net` cuts through `block`"), "{warnings:#?}");
    assert_eq!(good(&NET.replace("lower = [0.4, 0.4]", "lower = [0.4, 0.2]")).warnings, []);
}

#[test]
fn wrong_tables_are_errors_with_row_and_column() {
    let directory = tempfile::tempdir().unwrap();
    let build = |csv: &str| {
        std::fs::write(directory.path().join("p.csv"), csv).unwrap();
        let text = GOOD.replace("\"1 kPa * ramp(t, 0.1 ms)\"", "{ table = \"p.csv\" }");
        let case = Case::read(Source::new("case.toml", directory.path(), text.clone()), &[]);
        case.and_then(|case| case.build()).map(|_| ()).map_err(|error| match error {
            Error::Case(findings) => {
                let start = findings[0].span.as_ref().expect("a place").start;
                assert_eq!(start, text.find("{ table").unwrap());
                findings[0].message.clone()
            }
            other => panic!("{other}"),
        })
    };
    assert_eq!(build("t [ms],p [kPa]\n0,0\n1,2\n"), Ok(()));
    assert!(build("t [ms],p [kPa]\n0,0\n1,2\n1,3\n").unwrap_err().contains("the times must increase: row 3"));
    assert!(build("t [ms],p [kPa]\n0,zero\n").unwrap_err().contains("line 2: `zero` is not a number"));
    assert!(build("t [ms],p [kN]\n0,0\n1,2\n").unwrap_err().contains("column 2 of the table: expected a pressure"));
    assert!(build("t [m],p [kPa]\n0,0\n1,2\n").unwrap_err().contains("column 1 of the table: expected a time"));
    std::fs::remove_file(directory.path().join("p.csv")).unwrap();
}

#[test]
fn a_yield_curve_is_a_number_rows_or_a_file() {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("copper.csv"), "strain,stress [MPa]\n0,400\n0.1,450\n").unwrap();
    std::fs::write(directory.path().join("wrong.csv"), "strain,stress [MPa]\n0,400\n0,450\n").unwrap();
    let read = |value: &str| {
        let fluid = GOOD.find("material = { law = \"fluid\"").unwrap();
        let end = fluid + GOOD[fluid..].find('\n').unwrap();
        let law = format!("law = \"j2\", density = 8960, young = \"124 GPa\", poisson = 0.34, yield-stress = {value}");
        let text = format!("{}material = {{ {law} }}{}", &GOOD[..fluid], &GOOD[end..]);
        Case::read(Source::new("case.toml", directory.path(), text), &[]).map(|case| case.resolved_toml())
    };
    let rows = "yield-stress = [[0.0, 400000000.0], [0.1, 450000000.0]]";
    for value in ["[[0, \"400 MPa\"], [0.1, \"450 MPa\"]]", "{ table = \"copper.csv\" }"] {
        let resolved = read(value).unwrap().replace("\n    ", "").replace(",\n]", "]");
        assert!(resolved.contains(rows), "{resolved}");
    }
    assert!(read("\"400 MPa\"").is_ok());
    let error = |value: &str| read(value).unwrap_err().to_string();
    assert!(error("[[0, \"400 MPa\"], [0.1, \"450 mm\"]]").contains("expected a pressure"));
    assert!(error("[[0, \"400 MPa\"], [0.1, \"300 MPa\"]]").contains("must not fall: row 2"));
    assert!(error("{ table = \"wrong.csv\" }").contains("plastic strains must increase: row 2"));
    assert!(error("{ table = \"none.csv\" }").contains("none.csv"));
    assert!(error("-3").contains("must be above 0 Pa"));
}

#[test]
fn pressure_and_energy_together_are_an_error() {
    expect(
        "spacing = \"0.5 mm\"",
        "spacing = \"0.5 mm\"\npressure = 0\nenergy = 0",
        "0\nvelocity",
        "`pressure` and `energy` both prescribe",
        "",
    );
}

#[test]
fn tractions_and_pressures_give_a_body_the_momentum_of_force_times_time() {
    let plane = |load: &str| {
        let text = format!(
            "name = 'block'\ndimension = 2\ntime = {{ end = 1e-4 }}\ngrid = {{ cell = 1, lower = [0, 0], upper = [8, 8] }}\n\
             [[body]]\nname = 'block'\nregion = {{ shape = 'box', lower = [2, 2], upper = [6, 5] }}\nspacing = 0.5\n\
             material = {{ law = 'neo-hookean', density = 1000, young = '1 MPa', poisson = 0.3 }}\n\
             traction = [{{ {load} }}]\n"
        );
        let mut solver = model(&text, &[])?.solver;
        let dt = 1e-5;
        solver.step(0.0, dt).unwrap();
        let momentum = |name: &str| {
            let ledger = solver.snapshot().ledger;
            ledger.terms.iter().find(|term| term.name == name).unwrap().value / (0.5 * dt)
        };
        Ok::<_, Vec<Diagnostic>>([momentum("momentum x"), momentum("momentum y")])
    };
    // 4 m of surface per metre of depth, half a step of momentum.
    let near = |found: [f64; 2], exact: [f64; 2]| (0..2).all(|i| (found[i] - exact[i]).abs() < 1e-6);
    for (load, force) in [
        ("on = 'top', pressure = '1 kPa'", [0.0, -4e3]),
        ("on = 'bottom', pressure = '1 kPa'", [0.0, 4e3]),
        ("on = 'left', pressure = '1 kPa'", [3e3, 0.0]),
        ("on = 'right', value = ['1 kPa', 0]", [3e3, 0.0]),
    ] {
        let found = plane(load).unwrap();
        assert!(near(found, force), "{load}: {found:?}");
    }
    assert!(plane("on = 'top'").unwrap_err()[0].message.contains("give `value`"));
    assert!(plane("on = 'front', pressure = 1").unwrap_err()[0].message.contains("3D only"));
}

#[test]
fn a_case_without_bodies_and_membranes_is_an_error() {
    let text = "name = \"a\"\ndimension = 2\ntime = { end = 1 }\ngrid = { cell = 1, lower = [0, 0], upper = [1, 1] }";
    let Err(found) = model(text, &[]) else { panic!("nothing would move") };
    assert!(found[0].message.contains("neither a body nor a membrane"));
}

#[test]
fn a_missing_surface_file_is_an_error_at_its_key() {
    expect(
        "{ shape = \"sphere\", center = [\"0 mm\", \"0 mm\", \"5.5 mm\"], radius = \"4.5 mm\" }",
        "{ shape = \"surface\", file = \"none.stl\" }",
        "\"none.stl\"",
        "none.stl",
        "",
    );
}
