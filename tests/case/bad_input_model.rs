//! Errors between the parts of a case whose keys are valid one by one: names of files, meshes, fluids, conditions.

use lateen::case::{Case, Model, Source, line_and_column};
use lateen::error::{Diagnostic, Severity};
use lateen::run::{Options, RunDirectory, run};
use std::path::Path;

const FLOW: &str = include_str!("../fixtures/two_fluids.toml");

const POINTS: &str = r#"
name = "fall"
dimension = 2
[time]
end = 0.1
[grid]
cell = 0.1
lower = [0, 0]
upper = [1, 1]
walls = { bottom = "slip" }
[[body]]
name = "block"
spacing = 0.05
region = { shape = "box", lower = [0.4, 0.4], upper = [0.6, 0.6] }
material = { law = "hypoelastic", density = 1000, young = 1e5, poisson = 0.3 }
[[obstacle]]
name = "step"
kind = "slip"
region = { shape = "box", lower = [0, 0], upper = [0.1, 0.1] }
"#;

fn model(text: &str) -> Result<Model, Vec<Diagnostic>> {
    super::findings::model(text, Path::new(""))
}

/// Expects one error that underlines what begins with `at` (its last occurrence).
#[track_caller]
fn expect(text: &str, at: &str, message: &str, help: &str) {
    let Err(found) = model(text) else { panic!("a finding is expected: {message}") };
    let errors: Vec<&Diagnostic> = found.iter().filter(|finding| finding.severity == Severity::Error).collect();
    let [error] = errors[..] else { panic!("{found:#?}") };
    assert!(error.message.contains(message), "{}", error.message);
    assert!(error.help.as_deref().unwrap_or("").contains(help), "{error:?}");
    let start = error.span.as_ref().unwrap_or_else(|| panic!("no place: {error:?}")).start;
    let wanted = text.rfind(at).expect("the marked text is there");
    assert_eq!(line_and_column(text, start), line_and_column(text, wanted), "{error:?}");
}

#[track_caller]
fn warned(text: &str, message: &str) -> Model {
    let model = model(text).unwrap_or_else(|findings| panic!("{findings:#?}"));
    let found = model.warnings.iter().any(|warning| warning.message.contains(message) && warning.span.is_some());
    assert!(found, "{:#?}", model.warnings);
    model
}

fn probe(of: &str, name: &str) -> String {
    format!("[[probe]]\nname = \"{name}\"\nof = \"{of}\"\nquantity = \"position\"\nreduce = \"mean\"\n")
}

#[test]
fn two_outputs_of_a_flow_that_write_one_file_are_an_error() {
    let with = |names: &[&str]| names.iter().fold(FLOW.to_owned(), |text, name| text + &probe("water", name));
    for (name, other) in [("balance", "balance of the whole"), ("counts", "counts of the whole")] {
        expect(&with(&[name]), &format!("\"{name}\"\nof"), other, "another name");
    }
    expect(&with(&["left+right"]), "\"left+right\"\nof", "the force on `left+right`", "another name");
    expect(&with(&["a/b", "a-b"]), "\"a-b\"", "`history/a-b.csv`", "another name");
    expect(&with(&["Tip", "tip"]), "\"tip\"", "`history/tip.csv`", "another name");
    expect(&with(&[" "]), "\" \"", "the name is empty", "");
    let walls = FLOW.replace("kind = \"slip\"", "kind = \"slip\"\nname = \"walls\"");
    let walls = walls.replace("[\"bottom\", \"top\"]", "[\"bottom\", \"top\"]\nname = \"walls\"");
    expect(&walls, "\"walls\"", "the force on `walls`", "another name");
    let body = FLOW.replace("name = \"oil\"", "name = \"mesh\"");
    expect(&body, "\"mesh\"", "`fields/mesh.pvd`, as the mesh is", "another name");
}

#[test]
fn two_outputs_of_material_points_that_write_one_file_are_an_error() {
    let with = |name: &str| format!("{POINTS}{}", probe("block", name));
    model(&with("wall-left")).expect("an open wall has no history");
    expect(&with("balance"), "\"balance\"", "the balance of the whole", "another name");
    expect(&with("wall-bottom"), "\"wall-bottom\"", "the force on `wall:bottom`", "another name");
    expect(&with("obstacle-step"), "\"obstacle-step\"", "the force on `obstacle:step`", "another name");
    let obstacle = &POINTS[POINTS.find("[[obstacle]]").unwrap()..];
    let two = format!("{POINTS}{}", obstacle.replace("\"step\"", "\"STEP\""));
    expect(&two, "\"STEP\"", "as the force on `obstacle:step` is", "another name");
}

#[test]
fn a_mesh_with_too_many_elements_is_refused_before_it_is_allocated() {
    let box_of = |cell: &str, more: &str| FLOW.replace("cell = \"0.1 m\"", &format!("cell = {cell}{more}"));
    let hole = "\nholes = [{ name = \"h\", region = { shape = \"sphere\", center = [0.5, 0.5], radius = 0.1 } }]";
    for cell in ["\"1e-4 m\"", "1e-9"] {
        for more in ["", hole] {
            expect(&box_of(cell, more), cell, "", "increase `cell`");
        }
    }
    let long = FLOW.replace("upper = [\"1 m\", \"1 m\"]", "upper = [1e7, 1]");
    expect(&long, "\"0.1 m\"", "elements", "increase `cell`");
    let solid = FLOW.replace("dimension = 2", "dimension = 3").replace("\"1 m\"]", "\"1 m\", \"1 m\"]");
    let solid = solid.replace("\"0 m\"]", "\"0 m\", \"0 m\"]").replace("[0, \"-9.81 m/s^2\"]", "[0, 0, 0]");
    let found = model(&solid.replace("\"0.1 m\"", "1e-3")).map(|_| ()).unwrap_err();
    assert!(found.iter().any(|finding| finding.message.contains("elements: more than")), "{found:?}");
}

#[test]
fn a_step_above_the_capillary_bound_is_an_error_before_the_run() {
    let tension = "[[tension]]\nbetween = [\"water\", \"oil\"]\nvalue = 1e4\n";
    expect(&format!("{FLOW}{tension}"), "\"0.02 s\"", "above the stable one of 3.61", "write `step = 0.0036`");
    model(&format!("{FLOW}{tension}").replace("0.02 s", "0.0036 s").replace("0.04 s", "0.036 s")).expect("the bound");
    expect(
        &format!("{FLOW}{tension}{}", tension.replace("\"water\", \"oil\"", "\"oil\", \"water\"")),
        "[\"oil\"",
        "already",
        "",
    );
}

#[test]
fn a_closed_piece_of_a_mesh_is_an_error() {
    let across = "cell = \"0.1 m\"\nholes = [{ name = \"bar\", region = { shape = \"box\", lower = [0.4, -1], upper = [0.6, 2] } }]";
    let text = FLOW.replace("cell = \"0.1 m\"", across).replace("[\"bottom\", \"top\"]", "\"rest\"");
    let found = model(&text).map(|_| ()).unwrap_err();
    assert!(found.len() == 1 && found[0].key == "mesh" && found[0].span.is_some(), "{found:#?}");
    assert!(found[0].message.contains("2 pieces") && found[0].message.contains("around (0.8"), "{found:#?}");
    let open =
        text.replace("on = [\"left\", \"right\"]\nkind = \"slip\"", "on = [\"left\", \"right\"]\nkind = \"outlet\"");
    let shared = model(&open).map(|_| ()).unwrap_err();
    assert!(shared[0].key == "pfem2.volume" && shared[0].help.as_ref().unwrap().contains("\"none\""), "{shared:#?}");
    model(&open.replace("[pfem2]", "[pfem2]\nvolume = \"none\"")).expect("each piece has its outlet");
}

#[test]
fn holes_with_the_name_of_a_side_or_outside_the_box_are_errors() {
    let hole = |name: &str, x: f64, more: &str| {
        let region = format!("region = {{ shape = \"sphere\", center = [{x}, 0.5], radius = 0.1 }}");
        let text = format!("cell = \"0.1 m\"\nholes = [{{ name = \"{name}\", {region}{more} }}]");
        FLOW.replace("cell = \"0.1 m\"", &text).replace("[\"bottom\", \"top\"]", "\"rest\"")
    };
    expect(&hole("left", 0.5, ""), "\"left\", region", "the name of a side", "another name");
    expect(&hole("rest", 0.5, ""), "\"rest\", region", "means all parts", "another name");
    expect(&hole("disc", 3.0, ""), "{ shape = \"sphere\"", "outside the box", "from [0.0, 0.0] m to [1.0, 1.0] m");
    warned(&hole("disc", 0.5, ", cell = 0.2"), "coarser than `mesh.cell`");
    let refined = "cell = \"0.1 m\"\nrefine = [{ region = { shape = \"sphere\", center = [0.5, 0.5], radius = 0.2 }, cell = 0.3 }]";
    warned(&FLOW.replace("cell = \"0.1 m\"", refined), "coarser than `mesh.cell`");
}

#[test]
fn a_wall_velocity_with_a_normal_part_is_an_error() {
    let lid = |velocity: &str| format!("{}velocity = {velocity}\n", FLOW.split("[output]").next().unwrap());
    let lid = |velocity: &str| lid(velocity).replace("[\"bottom\", \"top\"]", "[\"top\", \"bottom\"]");
    expect(&lid("[1, 0.1]"), "[1, 0.1]", "` has a part across it", "`kind = \"inlet\"`");
    expect(&lid("[1, \"sin(t)\"]"), "[1, \"sin(t)\"]", "across it", "slides along itself");
    model(&lid("[\"cos(t)\", 0]")).expect("a lid that slides");
    let turning = "cell = \"0.1 m\"\nholes = [{ name = \"disc\", region = { shape = \"sphere\", center = [0.5, 0.5], radius = 0.1 } }]";
    let turning = FLOW.replace("cell = \"0.1 m\"", turning);
    let turning = turning.replace(
        "[\"bottom\", \"top\"]",
        "\"rest\"\n[[boundary]]\non = \"disc\"\nvelocity = [\"0.5 - y\", \"x - 0.5\"]",
    );
    model(&turning).expect("a disc that turns");
    let moving = turning.replace("[\"0.5 - y\", \"x - 0.5\"]", "[0.1, 0]");
    expect(&moving, "[0.1, 0]", "the wall `disc` has a part across it", "slides along itself");
}

#[test]
fn a_velocity_across_one_wall_of_a_list_is_an_error() {
    let (before, _) = FLOW.split_once("[[boundary]]").unwrap();
    let moved = |on: &str| format!("{before}[[boundary]]\non = {on}\nkind = \"wall\"\nvelocity = [0.1, 0]\n");
    for on in ["\"rest\"", "[\"bottom\", \"top\", \"left\", \"right\"]"] {
        expect(&moved(on), "[0.1, 0]", "has a part across it", "slides along itself");
    }
    let sides = "[[boundary]]\non = [\"left\", \"right\"]\nkind = \"slip\"\n";
    model(&format!("{}{sides}", moved("\"rest\""))).expect("a belt above and one below");
}

#[test]
fn a_wall_of_the_grid_with_a_normal_velocity_is_an_error() {
    let wall = |velocity: &str| {
        let wall = format!("bottom = {{ kind = \"slip\", velocity = {velocity} }}");
        POINTS.replace("bottom = \"slip\"", &wall)
    };
    model(&wall("[\"sin(t)\", 0]")).expect("a belt");
    expect(&wall("[0, 1]"), "[0, 1]", "can only move along itself", "`[[obstacle]]`");
    expect(&wall("[0, \"sin(t)\"]"), "[0, \"sin(t)\"]", "can only move along itself", "`[[obstacle]]`");
}

#[test]
fn lengths_of_implausible_unit_are_refused_or_warned_of() {
    let grid = |upper: &str| POINTS.replace("upper = [1, 1]", &format!("upper = {upper}"));
    expect(
        &grid("[1e9, 1]"),
        "1e9, 1]",
        "1.000e10 cells along x: a grid of 1000000000 m",
        "is the unit of one of the two",
    );
    expect(
        &grid("[1, 0.001]"),
        "0.001]",
        "0.001 m long along y, less than a cell of 0.1 m",
        "is the unit of one of the two",
    );
    expect(&grid("[1, -2]"), "-2]", "`upper` must exceed `lower` along y", "the upper one in `upper`");
    warned(&grid("[1000, 1]"), "the grid is 1000 m long along x, and what is in it is 0.15");
    let block = |upper: &str| POINTS.replace("upper = [0.6, 0.6]", &format!("upper = {upper}"));
    let (too_large, too_far) = (block("[4e4, 4e4]"), block("[30, 30]"));
    expect(&too_large, "0.05\nregion", "covers the region of 39999.6 m: too many", "are the units of both right?");
    expect(&too_far, "{ shape = \"box\", lower = [0.4", "lie outside the grid", "or is a unit wrong");
    // Nothing of it where there are no units.
    let bare = grid("[1e9, 1]").replace("dimension = 2", "dimension = 2\nunits = \"none\"");
    expect(&bare, "1e9, 1]", "cells along x", "at most 5e8 are possible");
    assert!(!model(&bare).err().unwrap()[0].help.as_deref().unwrap().contains("unit"));
}

const SHEET: &str = r#"
[[membrane]]
name = "sheet"
geometry = { shape = "chain", points = [[0.2, 0.2], [0.8, 0.2]], divisions = [12] }
thickness = 0.01
material = { law = "elastic", density = 1000, young = 1e6, poisson = 0.3 }
"#;

#[test]
fn implausible_values_are_warned_of() {
    let silent = |text: &str| assert!(model(text).unwrap().warnings.is_empty(), "{:#?}", model(text).unwrap().warnings);
    let points = |from: &str, to: &str| {
        assert_eq!(POINTS.matches(from).count(), 1, "{from}");
        POINTS.replace(from, to)
    };
    silent(POINTS);
    let dense = |density: &str| points("density = 1000", &format!("density = {density}"));
    for (density, shown) in [("7.8", "7.8"), ("7.8e6", "7800000")] {
        warned(&dense(density), &format!("`block` has a density of {shown}"));
    }
    silent(&dense("7.8").replace("dimension = 2", "dimension = 2\nunits = \"none\""));
    let pulled = |gravity: &str| points("[grid]", &format!("[mpm]\ngravity = [0, {gravity}]\n[grid]"));
    for gravity in ["-9810", "-0.00981", "-981", "\"-98100 * sin(t)\"", "2e4"] {
        warned(&pulled(gravity), "a gravity of ");
    }
    for gravity in ["-9.81", "-1.62", "-500", "\"-9810 mm/s^2\"", "0"] {
        silent(&pulled(gravity));
    }
    let thrown = |speed: &str| points("spacing = 0.05", &format!("velocity = [0, {speed}]\nspacing = 0.05"));
    // The speed of sound: (1e5 · 0.7 / (1.3 · 0.4) / 1000)^½ = 11.6 m/s.
    warned(&thrown("11.7"), "faster than sound in it: 1.1602e1 m/s");
    silent(&thrown("11.5"));
    let placed = |low: &str| points("lower = [0.4, 0.4]", &format!("lower = [0.4, {low}]"));
    warned(&placed("0.05"), "`block` begins 5.000e-2 m from the wall of kind `slip` at y = 0 m");
    silent(&placed("0.0"));
    silent(&placed("0.1"));
    let liquid = "law = \"fluid\", density = 1000, eos = { kind = \"tait\", sound-speed = 20 }";
    silent(&placed("0.05").replace("law = \"hypoelastic\", density = 1000, young = 1e5, poisson = 0.3", liquid));
}

#[test]
fn implausible_sheets_are_warned_of() {
    let with = |from: &str, to: &str| {
        assert_eq!(SHEET.matches(from).count(), 1, "{from}");
        format!("{POINTS}{}", SHEET.replace(from, to))
    };
    let sheet = model(&format!("{POINTS}{SHEET}")).unwrap();
    assert!(sheet.warnings.is_empty(), "{:#?}", sheet.warnings);
    warned(&with("thickness = 0.01", "thickness = 1"), "`sheet` is 1 m thick, in a grid of 1.0000 m");
    warned(&with("thickness = 0.01", "thickness = 1e-8"), "a few molecules");
    warned(&with("density = 1000", "density = 1"), "`sheet` has a density of 1 kg/m³");
    let fine = with("divisions = [12]", "divisions = [2]").replace("cell = 0.1", "cell = 0.025");
    warned(&fine, "the elements of `sheet` are 12.0 cells long");
    let silent = |text: &str| assert!(model(text).unwrap().warnings.is_empty(), "{:#?}", model(text).unwrap().warnings);
    // Contact at nodes of the grid asks for elements of its size; that at particles does less.
    let long = with("divisions = [12]", "divisions = [2]");
    let at_nodes = |text: &str| text.replace("[grid]", "[mpm]\nsheet-contact = \"nodes\"\n\n[grid]");
    silent(&long);
    warned(&at_nodes(&long), "the elements of `sheet` are 3.0 cells long");
    silent(&at_nodes(&with("divisions = [12]", "divisions = [24]")));
    let short = with("divisions = [12]", "divisions = [40]");
    silent(&short);
    warned(&at_nodes(&short), "the elements of `sheet` are 0.150 cells long");
    warned(&with("divisions = [12]", "divisions = [60]"), "the elements of `sheet` are 0.100 cells long");
}

/// A resolved case holds the default, 0.05, which has no effect either: a warning there, an error for any other value.
#[test]
fn an_hourglass_stiffness_without_effect_on_a_wrinkling_sheet_is_reported() {
    let with = |wrinkling: bool, stiffness: &str| {
        let sheet = SHEET.replace("poisson = 0.3 }", &format!("poisson = 0.3, wrinkling = {wrinkling} }}"));
        format!("{POINTS}{sheet}hourglass = {{ viscosity = 0.02, {stiffness} }}\n")
    };
    let told = "has no effect: quadrilaterals of a sheet that wrinkles";
    expect(&with(true, "stiffness = 0.1"), "0.1 }", told, "`wrinkling`");
    warned(&with(true, "stiffness = 0.05"), told);
    for silent in [with(true, "stiffness = 0"), with(true, "warping = 0.02"), with(false, "stiffness = 0.1")] {
        let model = model(&silent).unwrap_or_else(|findings| panic!("{findings:#?}"));
        assert!(model.warnings.is_empty(), "{:#?}", model.warnings);
    }
}

#[test]
fn membranes_that_cross_or_nearly_touch_at_the_start_are_warned_of() {
    let line = |name: &str, points: &str| {
        SHEET.replace("\"sheet\"", &format!("\"{name}\"")).replace("[[0.2, 0.2], [0.8, 0.2]]", points)
    };
    let two = |points: &str| format!("{POINTS}{SHEET}{}", line("other", points));
    warned(
        &two("[[0.31, 0.1], [0.31, 0.3]]"),
        "the membranes `sheet` and `other` cross at (3.1000e-1, 2.0000e-1) at the start",
    );
    warned(&two("[[0.2, 0.192], [0.8, 0.192]]"), "`sheet` and `other` come within 8.000e-3 m");
    for apart in ["[[0.2, 0.188], [0.8, 0.188]]", "[[0.8, 0.2], [0.8, 0.5]]"] {
        assert!(model(&two(apart)).unwrap().warnings.is_empty(), "{apart}: one thickness apart, or sewn at an end");
    }
    let own = |points: &str| format!("{POINTS}{}", line("sheet", points));
    warned(&own("[[0.2, 0.2], [0.3, 0.2], [0.3, 0.3], [0.26, 0.3], [0.26, 0.15]]"), "`sheet` crosses itself at");
    warned(
        &own("[[0.2, 0.2], [0.4, 0.2], [0.4, 0.3], [0.2, 0.3], [0.2, 0.206]]"),
        "parts of the membrane `sheet` come",
    );
    assert!(model(&own("[[0.2, 0.2], [0.4, 0.2], [0.4, 0.3], [0.2, 0.3]]")).unwrap().warnings.is_empty());
}

/// A gas that reaches far to both sides of a closed membrane is taken as intended; one column of its particles outside
/// is not, and a solid never is.
#[test]
fn solids_and_thin_layers_on_both_sides_of_a_closed_membrane_are_warned_of() {
    let around = "[[0.3, 0.3], [0.7, 0.3], [0.7, 0.7], [0.3, 0.7]], closed = true";
    let closed = SHEET.replace("[[0.2, 0.2], [0.8, 0.2]]", around).replace("[12]", "[6]");
    let placed = |lower: &str, upper: &str| {
        let region = format!("lower = {lower}, upper = {upper}");
        POINTS.replace("lower = [0.4, 0.4], upper = [0.6, 0.6]", &region) + &closed
    };
    let solid = "{ law = \"hypoelastic\", density = 1000, young = 1e5, poisson = 0.3 }";
    let fluid =
        "{ law = \"fluid\", density = 1, viscosity = 0, eos = { kind = \"ideal-gas\", gamma = 1.4 } }\npressure = 1e5";
    let gas = |lower: &str, upper: &str| placed(lower, upper).replace(solid, fluid);
    warned(&gas("[0.25, 0.3]", "[0.7, 0.7]"), "8 particles of `block` begin outside the closed membrane `sheet`");
    warned(&placed("[0.1, 0.4]", "[0.5, 0.6]"), "16 particles of `block` begin outside the closed membrane `sheet`");
    let model = model(&gas("[0.15, 0.15]", "[0.95, 0.95]")).unwrap_or_else(|findings| panic!("{findings:#?}"));
    let both = model.warnings.iter().filter(|warning| warning.message.contains("closed membrane"));
    assert_eq!(both.count(), 0, "{:#?}", model.warnings);
}

#[test]
fn the_volume_of_a_membrane_with_free_edges_is_an_error() {
    let volume = |keys: &str| format!("[[probe]]\nname = \"inside\"\nof = \"sheet\"\nquantity = \"volume\"\n{keys}\n");
    let help = |text: &str| model(text).err().unwrap()[0].help.clone().unwrap();
    let sum = volume("reduce = \"sum\"");
    assert!(help(&format!("{POINTS}{SHEET}{sum}")).contains("without free edges"));
    let around = "[[0.3, 0.3], [0.7, 0.3], [0.7, 0.7], [0.3, 0.7]], closed = true";
    let closed = SHEET.replace("[[0.2, 0.2], [0.8, 0.2]]", around).replace("[12]", "[6]");
    assert!(model(&format!("{POINTS}{closed}{sum}")).is_ok());
    assert!(help(&format!("{POINTS}{closed}{}", volume("reduce = \"mean\""))).contains("`reduce = \"sum\"`"));
}

#[test]
fn implausible_flows_are_warned_of() {
    warned(&FLOW.replace("800 kg/m^3", "800 g/mm^3"), "`oil` has a density of 800000000 kg/m³");
    let heavy = FLOW.replace("-9.81 m/s^2", "-9.81 km/s^2").replace("step = \"0.02 s\"\n", "");
    warned(&heavy, "a gravity of 9810 m/s²");
    let lid = FLOW.replace("on = [\"bottom\", \"top\"]", "on = [\"bottom\", \"top\"]\nvelocity = [2000, 0]");
    warned(&lid, "2.0000e3 m/s: fluids are compressed");
    let calm = model(&lid.replace("2000", "20")).unwrap().warnings;
    assert!(calm.is_empty(), "{calm:#?}");
}

#[test]
fn one_friction_holds_for_all_bodies_of_a_group() {
    let body = &POINTS[POINTS.find("[[body]]").unwrap()..POINTS.find("[[obstacle]]").unwrap()];
    let other = |name: &str, from: f64, to: f64| {
        let place = format!("lower = [0.4, {from}], upper = [0.6, {to}]");
        body.replace("block", name).replace("lower = [0.4, 0.4], upper = [0.6, 0.6]", &place)
    };
    let grouped = POINTS.replace("spacing", "group = \"pair\"\nspacing");
    let lid = other("lid", 0.6, 0.8).replace("spacing", "group = \"pair\"\nspacing");
    let text = format!("{grouped}{lid}{}", other("floor", 0.2, 0.4));
    let contact =
        |a: &str, b: &str, friction: f64| format!("[[contact]]\nbetween = [\"{a}\", \"{b}\"]\nfriction = {friction}\n");
    let first = contact("block", "floor", 0.1);
    model(&format!("{text}{first}{}", contact("floor", "lid", 0.1))).expect("the same friction");
    let both = format!("{text}{first}{}", contact("floor", "lid", 0.2));
    expect(&both, "[\"floor\", \"lid\"]", "contact[0] says something else", "part the group");
    let within = format!("{text}{}", contact("block", "lid", 0.2));
    expect(&within, "[\"block\", \"lid\"]", "are of one group", "take the contact out");
}

#[test]
fn keys_without_effect_on_a_probe_are_errors() {
    let probe = |keys: &str| format!("{POINTS}[[probe]]\nname = \"p\"\nof = \"block\"\n{keys}\n");
    let places = "quantity = \"pressure\"\nreduce = \"center-of-mass\"";
    expect(&probe(places), "\"pressure\"", "looks at places alone", "`mean`");
    expect(&probe("component = \"x\"\nreduce = \"top\""), "\"x\"", "looks at places alone", "take it away");
    let below = "reduce = \"mean\"\nwithin = { lower = [0.5, 0.5], upper = [0.6, 0.4] }";
    expect(&probe(below), "{ lower = [0.5", "must be below", "nothing is in such a box");
    let depth = "reduce = \"mean\"\nquantity = \"velocity\"\ncomponent = \"z\"";
    expect(&probe(depth), "\"z\"", "no `z` in two dimensions", "x or y");
    expect(&probe("reduce = \"top\"\naxis = \"z\""), "\"z\"", "no `z` in two dimensions", "x or y");
    let at = |keys: &str| probe(&format!("at = [0.5, 0.5]\n{keys}"));
    let follows = "`at` follows one particle";
    expect(
        &at("within = { lower = [0, 0], upper = [1, 1] }"),
        "{ lower = [0, 0], upper = [1, 1] }\n",
        follows,
        "reduce",
    );
    for (key, value) in [("weight", "\"mass\""), ("axis", "\"x\""), ("center", "[0.5, 0]"), ("cell", "0.25")] {
        expect(&at(&format!("{key} = {value}")), value, follows, "reduce");
    }
    for (reduce, key, value) in [("max", "weight", "\"mass\""), ("mean", "axis", "\"x\""), ("top", "center", "[0, 1]")]
    {
        let keys = format!("reduce = \"{reduce}\"\n{key} = {value}");
        expect(&probe(&keys), value, "has no effect on this `reduce`", "another `reduce`");
    }
    model(&probe("reduce = \"mean-radius\"\nweight = \"mass\"\naxis = \"x\"\ncenter = [0, 1]")).expect("all are read");
}

#[test]
fn keys_of_a_field_on_a_picture_without_one_are_errors() {
    let picture = |keys: &str| format!("{POINTS}[[picture]]\nname = \"p\"\n{keys}\n");
    for (key, value) in [("component", "\"x\""), ("range", "[0, 7]"), ("map", "\"plasma\""), ("plain", "[\"block\"]")] {
        expect(&picture(&format!("{key} = {value}")), value, "on a picture without `field`", "add the `field`");
        model(&picture(&format!("field = \"velocity\"\n{key} = {value}"))).expect("a field");
    }
    for (field, component, message) in [
        ("velocity", "xy", "`velocity` has 3 component(s), and no `xy`"),
        ("pressure", "x", "`pressure` has 1 component(s), and no `x`"),
        ("velocity", "z", "there is no `z` in two dimensions"),
    ] {
        let text = picture(&format!("field = \"{field}\"\ncomponent = \"{component}\""));
        expect(&text, &format!("\"{component}\""), message, "");
    }
}

#[test]
fn surface_tension_requires_an_enrichment_with_a_pressure_jump() {
    let tension = "[[tension]]\nbetween = [\"water\", \"oil\"]\nvalue = 0.07\n";
    let with = |enrichment: &str| FLOW.replace("[pfem2]", &format!("[pfem2]\nenrichment = \"{enrichment}\""));
    for word in ["none", "kink"] {
        let text = format!("{}{tension}", with(word));
        expect(&text, &format!("\"{word}\""), "with surface tension the pressure jumps", "`[[tension]]`");
        model(&with(word)).expect("no tension");
        model(&format!("{}{tension}", with(word)).replace("0.07", "0.0")).expect("no tension either");
    }
    model(&format!("{}{tension}", with("jump"))).expect("what holds anyway");
    let paper = FLOW.replace("dimension = 2", "dimension = 2\npreset = \"becker-2015\"");
    model(&format!("{paper}{tension}")).expect("the kink is the preset's");
}

#[test]
fn a_probe_of_an_empty_box_is_warned_of() {
    let probe = |keys: &str| format!("{POINTS}[[probe]]\nname = \"p\"\nof = \"block\"\n{keys}\n");
    let below = "within = { lower = [0, 0], upper = [1, 0.2] }";
    let model = warned(&probe(&format!("reduce = \"top\"\n{below}")), "the box holds nothing of `block` at the start");
    let help = model.warnings[0].help.as_ref().unwrap();
    assert!(help.contains("from (0.425, 0.425) to (0.575, 0.575) m"), "{help}");
    // A count has a value in an empty box: zero.
    let counted = self::model(&probe(&format!("reduce = \"count\"\n{below}"))).unwrap();
    assert_eq!(counted.warnings, []);
    let around = self::model(&probe("reduce = \"top\"\nwithin = { lower = [0, 0], upper = [1, 0.5] }")).unwrap();
    assert_eq!(around.warnings, []);
    let between = "[[probe]]\nname = \"p\"\nof = \"mesh\"\nquantity = \"pressure\"\nreduce = \"mean\"\n\
                   within = { lower = [0.51, 0.51], upper = [0.59, 0.59] }\n";
    warned(&format!("{FLOW}{between}"), "the box holds nothing of `mesh` at the start");
}

#[test]
fn names_that_no_file_can_have_are_errors() {
    let long = "n".repeat(101);
    let named = |name: &str| {
        let bodies = [(POINTS, "fall"), (POINTS, "block"), (POINTS, "step"), (FLOW, "oil")];
        let parts =
            bodies.map(|(text, part)| text.replace(&format!("name = \"{part}\""), &format!("name = \"{name}\"")));
        let boundary = FLOW.replace("kind = \"slip\"", &format!("kind = \"slip\"\nname = \"{name}\""));
        let picture = format!("{POINTS}[[picture]]\nname = \"{name}\"\n");
        parts.into_iter().chain([boundary, picture, format!("{POINTS}{}", probe("block", name))])
    };
    for text in named(&long) {
        expect(&text, &format!("\"{long}\""), "this name is too long: 101 bytes", "100 at most");
    }
    for text in named("a\\u0000b") {
        expect(&text, "\"a\\u0000b\"", "the control character U+0000", "letters, digits");
    }
    named(&long[1..]).for_each(|text| drop(model(&text).expect("100 bytes")));
    let long = &long[6..];
    let hole = format!(
        "holes = [{{ name = \"{long}\", region = {{ shape = \"sphere\", center = [0.5, 0.5], radius = 0.2 }} }}]"
    );
    let text = FLOW.replace("cell = \"0.1 m\"", &format!("cell = 0.1\n{hole}"));
    let text = text.replace("[\"bottom\", \"top\"]", &format!("[\"bottom\", \"top\", \"{long}\"]"));
    expect(&text, "[\"bottom\"", "too long: 106 bytes", "give this boundary a short `name`");
}

#[test]
fn a_refinement_too_far_from_the_mesh_to_change_it_is_warned_of() {
    let refined = |x: f64| {
        let region = format!("region = {{ shape = \"sphere\", center = [{x}, 0.5], radius = 0.1 }}");
        FLOW.replace("cell = \"0.1 m\"", &format!("cell = 0.1\nrefine = [{{ {region}, cell = 0.05 }}]"))
    };
    let far = warned(&refined(5.0), "this region changes nothing");
    assert!(far.warnings[0].help.as_ref().unwrap().contains("from [0.0, 0.0] m to [1.0, 1.0] m"), "{:?}", far.warnings);
    // From the second elements grow into the box.
    for x in [0.5, 1.2] {
        assert_eq!(model(&refined(x)).unwrap().warnings, []);
    }
}

/// The plane hides what lies where its normal points to; `view` points to the camera.
#[test]
fn cuts_that_hide_everything_or_face_away_are_warned_of() {
    let picture = |cut: &str| format!("{POINTS}[[picture]]\nname = \"p\"\n{cut}\n");
    let space = |cut: &str| {
        let text = picture(cut).replace("dimension = 2", "dimension = 3").replace("[0, 0]", "[0, 0, 0]");
        let text = text.replace("[1, 1]", "[1, 1, 1]").replace("[0.1, 0.1]", "[0.1, 0.1, 0.1]");
        text.replace("[0.4, 0.4]", "[0.4, 0.4, 0.4]").replace("[0.6, 0.6]", "[0.6, 0.6, 0.6]")
    };
    let flat = "cut = { at = [0.3, 0, 0], normal = [1, 0, 0] }";
    warned(&picture(flat), "the picture is empty");
    warned(&space(flat), "the picture is empty");
    warned(&space("cut = { at = [0, 0.5, 0], normal = [0, 1, 0] }\nview = [0, -1, 0]"), "can't be seen");
    warned(&space("cut = { at = [0, 0.5, 0], normal = [0, 1, 0] }"), "can't be seen");
    for seen in [
        "cut = { at = [0, 0.5, 0], normal = [0, -1, 0] }",
        "cut = { at = [0, 0.5, 0], normal = [0, 1, 0] }\nview = [0, 1, 0]",
    ] {
        assert!(model(&space(seen)).unwrap().warnings.is_empty(), "{:#?}", model(&space(seen)).unwrap().warnings);
    }
    let whole = picture("cut = { at = [0.5, 0, 0], normal = [1, 0, 0] }");
    assert!(model(&whole).unwrap().warnings.is_empty(), "{:#?}", model(&whole).unwrap().warnings);
}

#[test]
fn empty_pictures_and_absurd_output_intervals_are_errors() {
    let picture = format!("{POINTS}[[picture]]\nname = \"p\"\nof = []\n");
    let found = model(&picture).err().unwrap();
    assert!(found.iter().any(|finding| finding.message.contains("at least 1 entries")), "{found:?}");
    let rows = POINTS.replace("[[body]]", "[output]\nhistory = 1e-300\n[[body]]");
    expect(&rows, "1e-300", "would be 1e", "is its unit right");
    let probe = format!("{POINTS}[[probe]]\nname = \"p\"\nof = \"block\"\nreduce = \"top\"\nevery = 1e-200\n");
    expect(&probe, "1e-200", "would be 1e", "is its unit right");
}

#[test]
fn a_step_that_makes_an_absurd_number_of_steps_is_an_error() {
    let step = POINTS.replace("end = 0.1", "end = 0.1\nstep = 1e-30");
    expect(&step, "1e-30", "would be 1e", "are the units right");
}

#[test]
fn a_height_that_depends_on_more_than_x_is_an_error() {
    let box_at = POINTS.find("region = ").unwrap();
    let end = box_at + POINTS[box_at..].find('\n').unwrap();
    for height in ["0.3 + 0.1*y", "0.3 + t"] {
        let curve =
            format!("region = {{ shape = \"below\", height = \"{height}\", from = 0.2, to = 0.8, bottom = 0.1 }}");
        let text = format!("{}{curve}{}", &POINTS[..box_at], &POINTS[end..]);
        expect(&text, &format!("\"{height}\""), "depends on x alone", "drop y, z and t");
    }
}

#[test]
fn boundaries_without_facets_and_fluids_without_particles_are_errors() {
    let nowhere = FLOW.replace("[output]", "[[boundary]]\non = []\n[output]");
    expect(&nowhere, "[]", "names no part of the boundary", "`left`");
    let drop = "[[body]]\nname = \"drop\"\nregion = { shape = \"sphere\", center = [0.52, 0.53], radius = 1e-3 }\n\
                material = { law = \"newtonian\", density = 900, viscosity = 1 }\n[[body]]";
    expect(
        &FLOW.replacen("[[body]]", drop, 1),
        "{ shape = \"sphere\"",
        "no particles are in this region",
        "between particles",
    );
    let stripe = |n: usize| {
        format!(
            "[[body]]\nname = \"b{n}\"\nregion = {{ shape = \"box\", lower = [-1, {}], upper = [2, {}] }}\n\
             material = {{ law = \"newtonian\", density = 900, viscosity = 1 }}\n",
            n as f64 / 256.0,
            (n + 1) as f64 / 256.0
        )
    };
    let (head, tail) = (FLOW.find("[[body]]").unwrap(), FLOW.find("[[boundary]]").unwrap());
    let stripes: String = (0..257).map(stripe).collect();
    let many = format!("{}{stripes}{}", &FLOW[..head], &FLOW[tail..]);
    expect(&many, "[[body]]", "at most 256 bodies", "join those of one material");
}

#[test]
fn an_initial_state_that_depends_on_time_is_an_error() {
    for text in [FLOW, POINTS] {
        let moving = text.replacen("[[body]]\n", "[[body]]\nvelocity = [\"sin(t)\", 0]\n", 1);
        expect(&moving, "\"sin(t)\"", "must not depend on the time", "take `t` out");
    }
    expect(&POINTS.replace("spacing", "pressure = \"1 + t\"\nspacing"), "\"1 + t\"", "must not depend on the time", "");
}

/// Formulas that are undefined beyond the faces of the body, where it has no particles.
#[test]
fn an_initial_velocity_needs_values_within_its_body_only() {
    for velocity in ["sqrt(x - 0.4)", "sqrt(0.6 - x)", "sqrt((x - 0.4) * (0.6 - x))"] {
        let moving = POINTS.replacen("[[body]]\n", &format!("[[body]]\nvelocity = [\"{velocity}\", 0]\n"), 1);
        assert!(model(&moving).is_ok(), "{velocity}");
    }
}

/// A gap of 0.02 m across the whole box; every centre of an element lies in one of the fluids.
#[test]
fn the_volume_of_gaps_between_fluids_is_warned_of() {
    let text = FLOW.replace("[\"0.5 m\", \"0.47 m\"], normal = [0.2, 1]", "[0, 0.44], normal = [0, 1]");
    let text = text.replace("lower = [\"-1 m\", \"-1 m\"]", "lower = [-1, 0.46]");
    let model = warned(&text, "between the bodies belong to none");
    let message = &model.warnings[0].message;
    let volume: f64 = message.split_whitespace().nth(1).unwrap().parse().unwrap();
    // The volume is sampled at points an eighth of an element apart.
    assert!((volume - 0.02).abs() < 0.5 * 0.1 / 8.0, "{message}");
}

#[test]
fn two_contacts_of_one_pair_are_an_error() {
    let body = &POINTS[POINTS.find("[[body]]").unwrap()..POINTS.find("[[obstacle]]").unwrap()];
    let lid = body.replace("block", "lid").replace("0.4]", "0.7]").replace("0.6]", "0.9]");
    let contact = "[[contact]]\nbetween = [\"block\", \"lid\"]\nfriction = 0.1\n";
    let text = format!("{POINTS}{lid}{contact}");
    model(&text).expect("one contact");
    let again = contact.replace("\"block\", \"lid\"", "\"lid\", \"block\"");
    expect(&format!("{text}{again}"), "[\"lid\"", "already has a contact", "take one of them out");
}

#[test]
fn a_probe_outside_the_domain_is_an_error() {
    let at = "[[probe]]\nname = \"far\"\nof = \"mesh\"\nat = [7, 0.5]\nquantity = \"pressure\"\n";
    expect(&format!("{FLOW}{at}"), "[7, 0.5]", "x = 7 m", "from 0 m to 1 m along x");
    let at = at.replace("mesh", "block").replace("7", "0.5").replace("[0.5, 0.5]", "[0.5, -2]");
    expect(&format!("{POINTS}{at}"), "[0.5, -2]", "y = -2 m", "from 0 m to 1 m along y");
}

#[test]
fn overrides_reach_parts_of_the_boundary_by_name() {
    let set = |key: &str| {
        let overrides = [(key.to_owned(), "outlet".to_owned())];
        Case::read(Source::new("case.toml", "", FLOW), &overrides).map(|case| case.file.boundary[1].kind)
    };
    assert_eq!(set("boundary.top.kind").unwrap(), lateen::case::BoundaryWord::Outlet);
    let error = set("boundary.lid.kind").unwrap_err().to_string();
    assert!(error.contains("no `lid` to set; there are 0 to 1, `left`, `right`, `bottom`, `top`"), "{error}");
}

#[test]
fn scheme_and_solver_take_a_word_or_a_table() {
    let with = |keys: &str| FLOW.replace("[pfem2]", &format!("[pfem2]\n{keys}"));
    let resolved = |text: &str| Case::read(Source::new("case.toml", "", text), &[]).unwrap().resolved_toml();
    assert!(resolved(&with("scheme = \"backward-euler\"")).contains("scheme = \"backward-euler\""));
    for keys in
        ["scheme = { kind = \"second-order\", theta = 0.5 }", "solver = \"direct\"", "solver = { tolerance = 1e-9 }"]
    {
        model(&with(keys)).unwrap_or_else(|findings| panic!("{keys}: {findings:?}"));
    }
    expect(&with("scheme = \"backwards\""), "\"backwards\"", "`backward-euler`, `second-order`", "");
    expect(&with("solver = \"dircet\""), "\"dircet\"", "unknown name", "did you mean `direct`?");
}

/// Names that other programs have for a boundary are answered with those of this one.
#[test]
fn boundaries_by_other_names_are_recognised() {
    for (other, meant) in [("no-slip", "wall"), ("free-slip", "slip"), ("velocity", "inlet"), ("outflow", "outlet")] {
        let text = FLOW.replace("kind = \"slip\"", &format!("kind = \"{other}\""));
        let named = format!("unknown name `{other}`");
        expect(&text, &format!("\"{other}\""), &named, &format!("did you mean `{meant}`?"));
    }
}

/// Water under oil under petrol.
fn three_fluids() -> String {
    let layer = "[[body]]\nname = \"petrol\"\nregion = { shape = \"half-space\", point = [0, 0.75], normal = [0, -1] }\n\
        material = { law = \"newtonian\", density = 700.0, viscosity = 0.01 }\n[[body]]\nname = \"oil\"";
    let level = FLOW.replace("[\"0.5 m\", \"0.47 m\"], normal = [0.2, 1]", "[0, 0.45], normal = [0, 1]");
    level.replace("[[body]]\nname = \"oil\"", layer)
}

/// Three layers at rest stay at rest up to the error of pressure in the elements that hold two fluids: the exact
/// velocity is zero, and the bound is 1 % of free fall. A warning names the interface that is used; asking for the
/// sharp one is an error.
#[test]
fn three_layered_fluids_stay_nearly_at_rest_with_the_pseudo_level_set() {
    let text = three_fluids();
    warned(&text, "interfaces of 3 fluids");
    let with = |keys: &str| text.replace("[pfem2]", &format!("[pfem2]\n{keys}"));
    expect(&with("interface = \"sharp\""), "\"sharp\"", "for two fluids, and here are 3", "`interface = \"pseudo\"`");
    let outlet = "on = [\"bottom\"]\n[[boundary]]\nname = \"above\"\non = \"top\"\nkind = \"outlet\"";
    let opened = text.replace("on = [\"bottom\", \"top\"]", outlet);
    warned(&opened, "the volumes of three and more fluids are kept in closed boxes, and `above` is open");
    let opened = opened.replace("[pfem2]", "[pfem2]\nvolume = \"shift\"");
    expect(&opened, "\"shift\"", "kept in closed boxes, and `above` is open", "`volume = \"none\"`");
    let case = Case::read(Source::new("case.toml", "", with("interface = \"pseudo\"")), &[]).unwrap();
    let model = case.model().unwrap();
    assert!(model.warnings.is_empty() && case.resolved_toml().contains("volume = \"shift\""), "{:?}", model.warnings);
    let home = tempfile::tempdir().unwrap();
    run(&case, model.solver, &RunDirectory::new(home.path()), Options::default()).unwrap();
    let table = std::fs::read_to_string(home.path().join("history/balance.csv")).unwrap();
    let heads: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let last: Vec<f64> = table.lines().last().unwrap().split(',').map(|number| number.parse().unwrap()).collect();
    let value = |name: &str| last[heads.iter().position(|head| head.starts_with(name)).unwrap()];
    // Free fall over 0.4 s gives 3.9 m/s.
    assert!(value("largest speed") < 0.04, "{}", value("largest speed"));
    for (fluid, volume) in [("water", 0.45), ("oil", 0.3), ("petrol", 0.25)] {
        let found = value(&format!("volume: {fluid}"));
        assert!((found - volume).abs() < 0.01, "{fluid}: {found}");
    }
}

/// A unit square of 2 n² triangles as a file of Gmsh, with these elements besides, and its case.
fn on_file(nodes: &[&str], elements: &[&str]) -> Result<Model, Vec<Diagnostic>> {
    const N: usize = 2;
    let home = tempfile::tempdir().unwrap();
    let mut places: Vec<String> = (0..(N + 1) * (N + 1))
        .map(|n| format!("{} {} 0", (n % (N + 1)) as f64 / 2.0, (n / (N + 1)) as f64 / 2.0))
        .collect();
    places.extend(nodes.iter().map(|&place| place.to_owned()));
    let mut all: Vec<String> = Vec::new();
    for (i, j) in (0..N * N).map(|n| (n % N, n / N)) {
        let k = |i: usize, j: usize| j * (N + 1) + i + 1;
        all.push(format!("2 2 9 9 {} {} {}", k(i, j), k(i + 1, j), k(i + 1, j + 1)));
        all.push(format!("2 2 9 9 {} {} {}", k(i, j), k(i + 1, j + 1), k(i, j + 1)));
    }
    all.extend(elements.iter().map(|&element| element.to_owned()));
    let number = |lines: &[String]| (1..).zip(lines).map(|(i, line)| format!("{i} {line}\n")).collect::<String>();
    let text = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 1 \"floor\"\n1 2 \"again\"\n2 9 \"domain\"\n$EndPhysicalNames\n\
         $Nodes\n{}\n{}$EndNodes\n$Elements\n{}\n{}$EndElements\n",
        places.len(),
        number(&places),
        all.len(),
        number(&all)
    );
    std::fs::write(home.path().join("domain.msh"), text).unwrap();
    let start = FLOW.find("shape = \"box\"\nlower").unwrap();
    let end = FLOW.find("[pfem2]").unwrap();
    let case = format!("{}shape = \"file\"\npath = \"domain.msh\"\n{}", &FLOW[..start], &FLOW[end..]);
    let conditions = case.find("[[boundary]]").unwrap();
    let floor =
        if elements.iter().any(|line| line.starts_with("1 2 1 ")) { "[[boundary]]\non = \"floor\"\n" } else { "" };
    let again =
        if elements.iter().any(|line| line.starts_with("1 2 2 ")) { "[[boundary]]\non = \"again\"\n" } else { "" };
    super::findings::model(&format!("{}{floor}{again}[[boundary]]\non = \"rest\"\n", &case[..conditions]), home.path())
}

#[track_caller]
fn one(found: Result<Model, Vec<Diagnostic>>) -> String {
    let found = found.map(|_| ()).unwrap_err();
    assert!(found.len() == 1 && found[0].span.is_some(), "{found:?}");
    found[0].message.clone()
}

#[test]
fn overlapping_and_inverted_elements_of_a_file_are_errors_and_flat_ones_warned_of() {
    on_file(&[], &[]).expect("a sound file");
    // On the floor 1–2 from above, as the element that is there already.
    let overlap = one(on_file(&["0.25 0.1 0"], &["2 2 9 9 1 2 10"]));
    assert!(overlap.contains("elements 1 and 9 overlap"), "{overlap}");
    let inverted = one(on_file(&["0.25 -0.5 0", "0.75 -0.5 0"], &["2 2 9 9 1 2 10", "2 2 9 9 2 3 11"]));
    assert!(inverted.contains("element 9 at (0.250000, -0.166667) m is inverted, and 1 more"), "{inverted}");
    let flat = on_file(&["0.25 -1e-9 0"], &["2 2 9 9 2 1 10"]).unwrap();
    assert!(
        flat.warnings.iter().any(|w| w.message.contains("1 elements are nearly flat, the worst at (0.25")),
        "{:?}",
        flat.warnings
    );
}

#[test]
fn groups_that_share_facets_and_closed_pieces_of_a_file_are_errors() {
    let both = one(on_file(&[], &["1 2 1 1 1 2", "1 2 1 1 2 3", "1 2 2 2 1 2"]));
    assert!(both.contains("1 facets belong to both `floor` and `again`, the first at (0.25"), "{both}");
    let apart = one(on_file(&["1.2 0 0", "1.8 0 0", "1.8 0.6 0"], &["2 2 9 9 10 11 12"]));
    assert!(apart.contains("2 pieces") && apart.contains("around (1.600000, 0.200000)"), "{apart}");
    // Over the others, sharing no node with them.
    let over = one(on_file(&["0.2 0.1 0", "0.8 0.1 0", "0.8 0.3 0"], &["2 2 9 9 10 11 12"]));
    assert!(over.contains("pieces of the mesh overlap: two elements hold the place (0."), "{over}");
}

/// Names of cases, parts, groups, probes and holes that hold a direction mark.
#[test]
fn invisible_characters_are_errors_in_every_name() {
    let told = |text: &str| {
        let Err(found) = model(text) else { panic!("a finding is expected") };
        assert!(found.iter().any(|f| f.message.contains("invisible character U+202E")), "{found:#?}");
        assert!(found.iter().all(|f| !f.message.contains('\u{202e}')), "{found:#?}");
    };
    told(&POINTS.replace("name = \"fall\"", "name = \"fa\\u202ell\""));
    told(&POINTS.replace("name = \"block\"", "name = \"blo\\u202eck\""));
    told(&POINTS.replace("name = \"step\"", "name = \"st\\u202eep\""));
    told(&POINTS.replace("spacing = 0.05", "spacing = 0.05\ngroup = \"g\\u202e\""));
    told(&format!("{POINTS}{}", probe("block", "p\\u202e")));
    let hole = "holes = [{ name = \"h\\u202e\", region = { shape = \"sphere\", center = [0.5, 0.5], radius = 0.1 } }]";
    let flow = FLOW.replace("[\"bottom\", \"top\"]", "\"rest\"");
    told(&flow.replace("cell = \"0.1 m\"", &format!("cell = \"0.1 m\"\n{hole}")));
}

/// A second block and a membrane, for contacts.
fn contact(first: &str, second: &str) -> String {
    let body = &POINTS[POINTS.find("[[body]]").unwrap()..POINTS.find("[[obstacle]]").unwrap()];
    let upper = body.replace("block", "upper").replace("[0.4, 0.4]", "[0.4, 0.7]").replace("[0.6, 0.6]", "[0.6, 0.9]");
    format!("{POINTS}{upper}[[contact]]\nbetween = [\"{first}\", \"{second}\"]\nfriction = 0.3\n")
}

#[test]
fn a_contact_of_a_body_with_a_wall_or_obstacle_is_an_error_that_says_where_its_friction_goes() {
    model(&contact("block", "upper")).expect("both are there");
    expect(&contact("block", "uper"), "\"uper\"", "no body or membrane named `uper`", "did you mean `upper`?");
    expect(&contact("block", "step"), "\"step\"", "`step` is an obstacle", "in its `[[obstacle]]`");
    expect(&contact("block", "obstacle:step"), "\"obstacle:step\"", "is an obstacle", "in its `[[obstacle]]`");
    expect(&contact("block", "bottom"), "\"bottom\"", "`bottom` is a wall of the grid", "walls = { bottom = { kind");
    expect(&contact("wall:left", "block"), "\"wall:left\"", "is a wall of the grid", "walls = { left = {");
    expect(
        &contact("block", "stpe"),
        "\"stpe\"",
        "no body or membrane named `stpe`",
        "`step` is an obstacle or a wall",
    );
    expect(&contact("block", "x"), "\"x\"", "no body or membrane named `x`", "there are block, upper");
}

/// Blocks side by side, 55 in a row, each with these keys.
fn blocks(count: usize, keys: &str) -> String {
    const SIDE: usize = 55;
    let head = &POINTS[..POINTS.find("[[body]]").unwrap()];
    let body = |i: usize| {
        let [x, y] = [i % SIDE, i / SIDE].map(|k| k as f64 + 0.4);
        format!(
            "[[body]]\nname = \"b{i}\"\nspacing = 0.05\n{keys}region = {{ shape = \"box\", lower = [{x}, {y}], \
             upper = [{}, {}] }}\nmaterial = {{ law = \"hypoelastic\", density = 1000, young = 1e5, poisson = 0.3 }}\n",
            x + 0.1,
            y + 0.1
        )
    };
    let head = head.replace("upper = [1, 1]", &format!("upper = [{SIDE}, {SIDE}]"));
    (0..count).fold(head, |text, i| text + &body(i))
}

/// Guards against work that grows with the square of the number of bodies, which would take minutes; the time is not
/// asserted.
#[test]
fn three_thousand_bodies_build_and_a_repeated_name_among_them_is_an_error() {
    let text = blocks(3000, "group = \"all\"\n");
    let bodies = model(&text).unwrap_or_else(|found| panic!("{:?}", found.first())).summary.bodies.len();
    assert_eq!(bodies, 3000);
    let twice = text.replace("\"b2999\"", "\"b17\"");
    expect(&twice, "\"b17\"", "already something named `b17`", "");
}

/// 400 bodies with a velocity field each have 79,800 pairs, which must not be compared with each other; 3000 have too
/// many.
#[test]
fn too_many_pairs_of_bodies_in_contact_are_an_error() {
    let bodies = model(&blocks(400, "")).unwrap_or_else(|found| panic!("{:?}", found.first())).summary.bodies.len();
    assert_eq!(bodies, 400);
    let Err(found) = model(&blocks(3000, "")) else { panic!("too many pairs") };
    let errors: Vec<&Diagnostic> = found.iter().filter(|finding| finding.severity == Severity::Error).collect();
    let [finding] = errors[..] else { panic!("{found:#?}") };
    assert!(finding.message.contains("3000 bodies and groups") && finding.message.contains("4498500 pairs"));
    assert!(finding.help.as_deref().unwrap().contains("share a `group`") && finding.span.is_some(), "{finding:?}");
}

/// Guards against a comparison of all sides with all others, too.
#[test]
fn a_polygon_of_a_hundred_thousand_corners_has_the_area_of_its_circle() {
    let corner = |i: u32| {
        let angle = std::f64::consts::TAU * f64::from(i) / 1e5;
        format!("[{}, {}]", 0.5 + 0.1 * angle.cos(), 0.5 + 0.1 * angle.sin())
    };
    let corners = (0..100_000).map(corner).collect::<Vec<_>>().join(", ");
    let polygon = format!("region = {{ shape = \"polygon\", corners = [{corners}] }}");
    let body = "region = { shape = \"box\", lower = [0.4, 0.4], upper = [0.6, 0.6] }";
    let area = std::f64::consts::PI * 0.01;
    let model = model(&POINTS.replace(body, &polygon).replace("spacing = 0.05", "spacing = 0.002"));
    let volume = model.unwrap_or_else(|found| panic!("{:?}", found.first())).summary.bodies[0].volume;
    assert!((volume / area - 1.0).abs() < 5e-3, "{volume} instead of {area}");
}

/// The chain at y = 0.2, with nodes every 0.05 from 0.2 on, and a bar.
fn with_bar(keys: &str, lower: [f64; 2], upper: [f64; 2]) -> String {
    let region = format!("region = {{ shape = \"box\", lower = {lower:?}, upper = {upper:?} }}");
    format!("{POINTS}{SHEET}{keys}[[obstacle]]\nname = \"bar\"\n{region}\n")
}

#[test]
fn a_membrane_that_starts_in_an_obstacle_is_an_error() {
    let chain = "{ shape = \"chain\"";
    let told =
        "4 free nodes of `sheet` lie in the obstacle `bar`, the deepest at (0.5, 0.2), 2.000e-2 m below its surface";
    expect(&with_bar("", [0.44, 0.15], [0.61, 0.22]), chain, told, "they may touch");
    // Half its thickness is 0.005.
    let model = model(&with_bar("", [0.44, 0.1], [0.61, 0.204])).unwrap();
    assert!(model.warnings.is_empty(), "{:#?}", model.warnings);
    let told = "`sheet` goes through the obstacle `bar`, between its nodes at (0.5, 0.2) and (0.55, 0.2)";
    expect(&with_bar("", [0.52, 0.1], [0.53, 0.3]), chain, told, "move one of the two apart");
}

/// The chain at y = 0.2, half its thickness of 0.01 over and under it, and a press above it.
fn under_a_press(velocity: &str, keys: &str) -> String {
    let press =
        "[[obstacle]]\nname = \"press\"\nregion = { shape = \"box\", lower = [0.3, 0.25], upper = [0.7, 0.3] }\n";
    format!("{POINTS}{SHEET}contact-thickness = true\n{press}velocity = {velocity}\n{keys}")
}

/// The press falls at 3 m/s: from 0.25 on, it is less than nine tenths of a thickness over the floor after 80.3 ms. At
/// 2.4 m/s it ends a thickness over the floor at 0.1 s.
#[test]
fn obstacles_that_will_close_on_a_membrane_are_warned_of_with_time_and_gap() {
    let text = |velocity: &str| under_a_press(velocity, "");
    let closing = warned(&text("[0, -3]"), "`wall:bottom` and `obstacle:press` close on `sheet`: at t = 8.");
    let warning = closing.warnings.iter().find(|warning| warning.message.contains("close on")).unwrap();
    let (apart, time) = (number_before(&warning.message, " m apart"), number_before(&warning.message, " s they are"));
    assert!((0.25 - 3.0 * time - apart).abs() < 2e-3 && (0.0..0.009).contains(&apart), "{}", warning.message);
    assert!(warning.help.as_deref().unwrap().contains("`time.end`"));
    // 0.1 m there, and back.
    warned(&text("[0, \"-0.25*pi/0.1*sin(pi*t/0.05)\"]"), "close on `sheet`: at t = ");
    for silent in ["[0, -2.4]", "[0, \"-0.23*pi/0.1*sin(pi*t/0.05)\"]", "[1, 0]"] {
        let model = model(&text(silent)).unwrap_or_else(|findings| panic!("{findings:#?}"));
        assert!(model.warnings.is_empty(), "{silent}: {:#?}", model.warnings);
    }
    let table = "[[obstacle]]\nname = \"table\"\nregion = { shape = \"box\", lower = [0.3, 0.1], upper = [0.7, 0.15] }\nvelocity = [0, 1]\n";
    warned(&under_a_press("[0, -1]", table), "`obstacle:press` and `obstacle:table` close on `sheet`: at t = 4.");
}

/// A ram from the side pushes the sheet ahead of it, though less than a thickness is left between ram and floor; and an
/// obstacle without contact with the sheet doesn't close on it.
#[test]
fn obstacles_that_push_a_sheet_away_do_not_close_on_it() {
    let ram = "[[obstacle]]\nname = \"ram\"\nregion = { shape = \"box\", lower = [0.82, 0.005], upper = [0.9, 0.35] }\nvelocity = [-4, 0]\n";
    let apart = "[[contact]]\nbetween = [\"sheet\", \"press\"]\nfriction = \"none\"\n";
    for text in [under_a_press("[0, 0]", ram), under_a_press("[0, -3]", apart)] {
        let model = model(&text).unwrap_or_else(|findings| panic!("{findings:#?}"));
        assert!(model.warnings.is_empty(), "{:#?}", model.warnings);
    }
}

/// The number that stands before a word of a message.
fn number_before(message: &str, word: &str) -> f64 {
    message.split(word).next().and_then(|text| text.rsplit(' ').next()).unwrap().parse().unwrap()
}

/// The first node lies in the bar, nearest to its right side.
#[test]
fn supported_nodes_within_an_obstacle_are_warned_of() {
    let held =
        |velocity: &str| with_bar(&format!("supports = [{{ on = \"left\"{velocity} }}]\n"), [0.15, 0.15], [0.22, 0.25]);
    let told = "supports hold 1 nodes of `sheet` in the obstacle `bar`, the deepest at (0.2, 0.2), 2.000e-2 m below";
    let clamped = warned(&held(""), told);
    assert!(clamped.warnings[0].help.as_ref().unwrap().contains("pressed for ever"), "{:#?}", clamped.warnings);
    warned(&held(", velocity = [0, \"free\"]"), told);
    let told = "1 free nodes of `sheet` lie in the obstacle `bar`";
    expect(&held(", velocity = [\"free\", 0]"), "{ shape = \"chain\"", told, "they may touch");
}

#[test]
fn a_membrane_that_starts_outside_the_grid_is_an_error() {
    let across = SHEET.replace("[0.8, 0.2]", "[0.8, -0.1]");
    let told = "4 of 13 nodes of `sheet` lie outside the grid, the first at (0.65, -0.025), and up to 1.000e-1 m beyond its end `bottom`";
    expect(&format!("{POINTS}{across}"), "{ shape = \"chain\"", told, "cut the part off");
}

/// A loop around the block, in one sense or the other.
fn around(points: &str, keys: &str) -> String {
    let loop_of = format!("{points}, closed = true");
    let sheet = SHEET.replace("[[0.2, 0.2], [0.8, 0.2]]", &loop_of).replace("[12]", "[6]");
    format!("{POINTS}{sheet}{keys}\n")
}

#[test]
fn inward_normals_of_a_closed_membrane_under_pressure_are_warned_of() {
    let clockwise = "[[0.3, 0.3], [0.3, 0.7], [0.7, 0.7], [0.7, 0.3]]";
    let counter = "[[0.3, 0.3], [0.7, 0.3], [0.7, 0.7], [0.3, 0.7]]";
    let load = |value: &str| format!("pressure = {{ value = {value} }}");
    let told = "`sheet` is turned inside out: its normals point inwards, and so does this pressure";
    for value in ["100", "\"100 Pa * sin(t / 10 ms)\""] {
        warned(&around(clockwise, &load(value)), told);
    }
    let probe = |quantity: &str, keys: &str| {
        format!("[[probe]]\nname = \"p\"\nof = \"sheet\"\nquantity = \"{quantity}\"\n{keys}")
    };
    let contact = probe("contact pressure", "reduce = \"mean\"\nweight = \"area\"");
    warned(&around(clockwise, &contact), "its normals point inwards, where this pressure counts as positive");
    // Without a load that pushes along normals, and for the volume, the sense doesn't matter.
    let volume = probe("volume", "reduce = \"sum\"");
    let calm = [(clockwise, load("-100")), (counter, load("100")), (clockwise, volume), (counter, contact)];
    for (points, keys) in calm {
        let model = model(&around(points, &keys)).unwrap_or_else(|found| panic!("{found:#?}"));
        assert!(model.warnings.is_empty(), "{points} {keys}: {:#?}", model.warnings);
    }
}

/// Squares of sides 0.1 and 0.2 in one file of Gmsh; the second runs clockwise, and one of its sides the other way in
/// the last.
#[test]
fn closed_parts_of_opposite_orientation_are_errors_for_a_volume_and_warned_of_for_a_pressure() {
    let nodes = [[0.1, 0.2], [0.2, 0.2], [0.2, 0.3], [0.1, 0.3], [0.7, 0.2], [0.7, 0.4], [0.9, 0.4], [0.9, 0.2]];
    let file = |last: [usize; 2]| {
        let side = |k: usize| [k + 1, if k % 4 == 3 { k - 2 } else { k + 2 }];
        let sides: Vec<[usize; 2]> = (0..7).map(side).chain([last]).collect();
        let node = |(k, [x, y]): (usize, &[f64; 2])| format!("{} {x} {y} 0\n", k + 1);
        let element = |(k, [a, b]): (usize, &[usize; 2])| format!("{} 1 2 0 1 {a} {b}\n", k + 1);
        let nodes: String = nodes.iter().enumerate().map(node).collect();
        let elements: String = sides.iter().enumerate().map(element).collect();
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n{nodes}$EndNodes\n$Elements\n8\n{elements}$EndElements\n"
        )
    };
    let home = tempfile::tempdir().unwrap();
    let build = |last: [usize; 2], keys: &str| {
        std::fs::write(home.path().join("two.msh"), file(last)).unwrap();
        let chain = "{ shape = \"chain\", points = [[0.2, 0.2], [0.8, 0.2]], divisions = [12] }";
        let sheet = SHEET.replace(chain, "{ shape = \"file\", path = \"two.msh\" }");
        super::findings::model(&format!("{POINTS}{sheet}{keys}\n"), home.path())
    };
    build([8, 5], "").expect("nothing depends on the sense");
    let volume = "[[probe]]\nname = \"p\"\nof = \"sheet\"\nquantity = \"volume\"\nreduce = \"sum\"";
    let told = one(build([8, 5], volume));
    assert!(
        told.contains("1 of the 2 closed parts of `sheet` are turned inside out, the first from [0.7, 0.2]"),
        "{told}"
    );
    assert!(told.ends_with("their volumes are taken from those of the others"), "{told}");
    let pushed = build([8, 5], "pressure = { value = 100 }").unwrap();
    assert!(pushed.warnings.iter().any(|warning| warning.message.contains("and so does this pressure")));
    let mixed = one(build([5, 8], ""));
    assert!(mixed.contains("is inverted: its normal is opposite to that of element"), "{mixed}");
}

/// Water on both sides of the chain, which has two rows of particles within a cell above it, and two below.
#[test]
fn a_fluid_on_both_sides_of_an_open_membrane_is_warned_of() {
    let liquid = "law = \"fluid\", density = 1000, eos = { kind = \"tait\", sound-speed = 20 }";
    let water = POINTS.replace("law = \"hypoelastic\", density = 1000, young = 1e5, poisson = 0.3", liquid);
    let filled = |low: f64, high: f64| {
        let region = format!("lower = [0.3, {low:?}], upper = [0.7, {high:?}]");
        format!("{}{SHEET}", water.replace("lower = [0.4, 0.4], upper = [0.6, 0.6]", &region))
    };
    let told = "`block` lies on both sides of the membrane `sheet`, which has free edges: within a cell of it are 16 of its particles";
    let both = warned(&filled(0.1, 0.3), told);
    assert!(both.warnings[0].help.as_ref().unwrap().contains("one body of each side"), "{:#?}", both.warnings);
    let parted = format!("{}[[contact]]\nbetween = [\"block\", \"sheet\"]\nfriction = \"none\"\n", filled(0.1, 0.3));
    for text in [filled(0.2, 0.4), filled(0.1, 0.2), filled(0.35, 0.5), parted] {
        let model = model(&text).unwrap_or_else(|found| panic!("{found:#?}"));
        assert!(model.warnings.is_empty(), "{:#?}", model.warnings);
    }
}

#[test]
fn membranes_have_contact_with_walls_and_obstacles_but_not_with_membranes() {
    let between = |names: [&str; 2]| format!("[[contact]]\nbetween = {names:?}\nfriction = 0.3\n");
    let with = |names: [&str; 2]| format!("{POINTS}{SHEET}{}", between(names));
    for solid in ["step", "obstacle:step", "bottom", "wall:bottom"] {
        for names in [["sheet", solid], [solid, "sheet"]] {
            model(&with(names)).unwrap_or_else(|found| panic!("{names:?}: {found:#?}"));
        }
    }
    let twice = format!("{}{}", with(["sheet", "bottom"]), between(["wall:bottom", "sheet"]));
    expect(&twice, "[\"wall:bottom\"", "already has a contact, contact[0]", "one friction");
    expect(&with(["sheet", "left"]), "\"left\"", "the wall `left` is open: nothing meets it", "left = \"separate\"");
    expect(
        &with(["wall:front", "sheet"]),
        "\"wall:front\"",
        "the wall `front` exists in 3D only",
        "`bottom` and `top`",
    );
    expect(&with(["sheet", "sheet"]), "[\"sheet\"", "contact of a part with itself", "with itself comes later");
    let other = SHEET.replace("\"sheet\"", "\"other\"").replace("0.2], [0.8, 0.2]", "0.3], [0.8, 0.3]");
    let pair = format!("{POINTS}{SHEET}{other}{}", between(["other", "sheet"]));
    expect(&pair, "[\"other\"", "are membranes, which don't meet each other", "among membranes comes later");
}

/// Gas in the place of the block, in air.
fn gas(ambient: &str) -> String {
    let eos = "law = \"fluid\", density = 1.2, eos = { kind = \"ideal-gas\", gamma = 1.4 }";
    let elastic = "law = \"hypoelastic\", density = 1000, young = 1e5, poisson = 0.3";
    let air = format!("[[body]]\npressure = \"1 bar\"\nambient = {ambient}");
    POINTS.replace(elastic, eos).replace("[[body]]", &air)
}

#[test]
fn ambient_is_a_positive_pressure_of_ideal_gases_alone() {
    model(&gas("\"1 bar\"")).expect("gas in air");
    expect(&gas("-1.0"), "-1.0", "must be at least 0 Pa, found -1 Pa", "");
    expect(&gas("inf"), "inf", "inf is not a usable number here", "");
    expect(&gas("nan"), "nan", "NaN is not a usable number here", "");
    expect(&gas("\"1 m\""), "\"1 m\"", "expected a pressure", "write for example");
    let solid = POINTS.replace("[[body]]", "[[body]]\nambient = 2.5e4");
    expect(&solid, "2.5e4", "`block` is no ideal gas", "take it out");
    expect(
        &FLOW.replacen("[[body]]", "[[body]]\nambient = 1e5", 1),
        "1e5",
        "does not belong to `method = \"pfem2\"`",
        "take it out",
    );
}

#[test]
fn gases_in_different_atmospheres_are_warned_of() {
    let air = gas("\"1 bar\"");
    let body = &air[air.find("[[body]]").unwrap()..air.find("[[obstacle]]").unwrap()];
    let beside =
        body.replace("block", "other").replace("0.4, 0.4], upper = [0.6, 0.6]", "0.7, 0.7], upper = [0.9, 0.9]");
    let both = |ambient: &str| format!("{air}{}", beside.replace("ambient = \"1 bar\"", ambient));
    warned(&both("ambient = \"2 bar\""), "from 100000 Pa and `other` from 200000 Pa");
    warned(&both(""), "and `other` from 0 Pa");
    let one = model(&both("ambient = \"1 bar\"")).unwrap_or_else(|findings| panic!("{findings:#?}"));
    assert!(one.warnings.iter().all(|warning| !warning.message.contains("what is zero")), "{:#?}", one.warnings);
}
