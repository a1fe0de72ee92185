//! The way that solids of PFEM-2 are likely to take, against closed forms, and the elements of the mesh across them
//! there.

use super::findings::{edited, good, good_with};
use lateen::case::{Model, SolidSummary};

/// A cantilever, 1 m long and 0.1 m thick, of ν = 0 and E I = 62.5 N m², let go under its weight in a gas: ρ g h l⁴/(8
/// E I) = 0.2 m at rest, in a mesh that is fine about where it starts.
const CANTILEVER: &str = r#"
name = "cantilever"
method = "pfem2"
dimension = 2
time = { end = "3 s", step = "0.01 s" }
[mesh]
shape = "box"
lower = [0, 0]
upper = [1.5, 1.2]
cell = "50 mm"
pattern = "free"
growth = 0.5
refine = [{ region = { shape = "box", lower = [-1, 0.9], upper = [1.1, 1.1] }, cell = "20 mm" }]
[pfem2]
gravity = [0, "-1 m/s^2"]
[[body]]
name = "beam"
region = { shape = "box", lower = [0, 0.95], upper = [1, 1.05] }
material = { law = "st-venant-kirchhoff", density = 1000.0, young = "750 kPa", poisson = 0.0 }
mesh = { cell = "50 mm" }
supports = [{ on = "left" }]
surface = "no-slip"
[[body]]
name = "gas"
region = { shape = "box", lower = [-1, -1], upper = [2, 2] }
material = { law = "newtonian", density = 0.01, viscosity = 1e-5 }
[[boundary]]
on = "rest"
"#;

/// The edge of the square that has twice the area of an equilateral triangle, over the edge of that: (√3/2)^½.
const EQUILATERAL: f64 = 0.930_604_859_102_1;

/// A square of 0.1 m, in a mesh of 20 mm.
const SQUARE: &str = r#"
name = "square"
method = "pfem2"
dimension = 2
time = { end = "0.5 s", step = "0.01 s" }
mesh = { shape = "box", lower = [0, 0], upper = [1, 1], cell = "20 mm" }
[pfem2]
gravity = [0, "-4 m/s^2"]
[[body]]
name = "square"
region = { shape = "box", lower = [0.4, 0.7], upper = [0.5, 0.8] }
material = { law = "rigid", density = "2000 kg/m^3" }
mesh = { cell = "50 mm" }
[[body]]
name = "water"
region = { shape = "box", lower = [-1, -1], upper = [2, 2] }
material = { law = "newtonian", density = "1000 kg/m^3", viscosity = "1e-3 Pa s" }
[[boundary]]
on = "rest"
"#;

fn solid(model: &Model) -> SolidSummary {
    let [solid] = &model.summary.solids[..] else { panic!("one solid") };
    solid.clone()
}

/// Distance that the solid of a case is said to come; zero where it stays [m].
fn way(text: &str) -> f64 {
    solid(&good(text)).path.map_or(0.0, |path| path.way)
}

fn warnings(model: &Model) -> Vec<String> {
    model.warnings.iter().map(|w| format!("{}: {} ({})", w.key, w.message, w.help.as_deref().unwrap_or(""))).collect()
}

#[track_caller]
fn near(value: f64, exact: f64, tolerance: f64) {
    assert!((value / exact - 1.0).abs() < tolerance, "{value} instead of {exact}");
}

/// Let go it swings twice as far as it hangs, to where elements are 50 mm wide: two across it. With the fine elements
/// in all that it sweeps there are more than five, and in equilibrium from the start it comes half as far.
#[test]
fn a_beam_that_swings_out_of_fine_elements_is_warned_of() {
    let model = good(CANTILEVER);
    let path = solid(&model).path.unwrap();
    near(path.way, 0.4, 0.02);
    near(path.cells, 0.1 / (EQUILATERAL * 0.05), 0.12);
    near(path.thickness, 0.1, 1e-9);
    near(solid(&model).cells_across.unwrap(), 0.1 / (EQUILATERAL * 0.02), 0.1);
    assert!(path.place[1] < 0.8 && path.place[0] > 0.5, "{path:?}");
    assert!((path.swept[0][1] - 0.55).abs() < 0.01, "{path:?}");
    let found = warnings(&model);
    let [warning] = &found[..] else { panic!("{found:?}") };
    let told = [
        "body[0]: `beam` is likely to come to",
        "elements of the mesh lie across its 1.0e-1 m",
        "3.3e-2 m or smaller",
        "refine",
    ];
    told.iter().for_each(|part| assert!(warning.contains(part), "{part}: {warning}"));
    assert!(model.summary.to_string().contains("m that it is likely to move"), "{}", model.summary);
    let fine = good(&edited(CANTILEVER, "lower = [-1, 0.9]", "lower = [-1, 0.4]"));
    assert!(warnings(&fine).is_empty(), "{:?}", warnings(&fine));
    near(solid(&fine).path.unwrap().cells, 0.1 / (EQUILATERAL * 0.02), 0.15);
    near(way(&edited(CANTILEVER, "[pfem2]", "[pfem2]\nstart = \"equilibrium\"")), 0.2, 0.02);
}

/// (1 − ρ_f/ρ) g t²/2 = 0.25 m, or 0.7 m to the floor; upward if it is lighter, and not at all if it is as heavy as the
/// water.
#[test]
fn a_square_sinks_as_far_as_its_weight_in_water_leads_it() {
    near(way(SQUARE), 0.25, 0.01);
    let longer =
        |density: &str| solid(&good_with(SQUARE, &[("time.end", "2 s"), ("body.square.material.density", density)]));
    near(longer("2000 kg/m^3").path.unwrap().way, 0.7, 1e-9);
    near(longer("500 kg/m^3").path.unwrap().way, 0.2, 1e-9);
    assert!(longer("1000 kg/m^3").path.is_none());
    let coarse = good_with(
        SQUARE,
        &[
            ("mesh.cell", "50 mm"),
            ("mesh.refine", "[{ region = { shape = 'box', lower = [0, 0.6], upper = [1, 1] }, cell = '20 mm' }]"),
        ],
    );
    assert!(warnings(&coarse).iter().any(|w| w.contains("`square` is likely to come to")), "{:?}", warnings(&coarse));
}

/// 0.3 m/s for 0.5 s; half a turn moves its corners across, by 2 · 0.05 m √2; a held one stays.
#[test]
fn prescribed_motions_are_followed() {
    let moved = |keys: &str| {
        way(&edited(SQUARE, "mesh = { cell = \"50 mm\" }", &format!("mesh = {{ cell = \"50 mm\" }}\n{keys}")))
    };
    near(moved("motion = { velocity = [\"0.6 m/s * t / 0.5 s\", 0], spin = [0] }"), 0.15, 1e-3);
    near(moved("motion = { velocity = [0, 0], spin = [\"2*pi / 1 s\"] }"), 2.0 * 0.05 * 2f64.sqrt(), 0.02);
    assert_eq!(moved("supports = [{ on = \"all\" }]"), 0.0);
}

/// A column of water of a · H, 0.2 m by 0.8 m, in a tank of W = 1 m comes down: its mean speed is U = √(g (H − a H/W)),
/// the work of gravity is ρ g a H (H/2 − a H/(2 W)). It pushes the square, on a spring along x, by ½ρU² 2 s/k.
#[test]
fn a_column_that_falls_pushes_what_stands_on_springs() {
    let text = edited(SQUARE, "lower = [-1, -1], upper = [2, 2] }", "lower = [-1, -1], upper = [0.2, 0.8] }");
    let air = "[[body]]\nname = \"air\"\nregion = { shape = \"box\", lower = [-1, -1], upper = [2, 2] }\n\
               material = { law = \"newtonian\", density = 0.001, viscosity = 1e-5 }\n[[boundary]]";
    let text = edited(&text, "[[boundary]]", air);
    let text = edited(
        &text,
        "mesh = { cell = \"50 mm\" }",
        "mesh = { cell = \"50 mm\" }\nsupports = [{ on = \"all\", velocity = [\"free\", 0] }, { on = \"all\", stiffness = [\"10 kN/m\", 0] }]",
    );
    let pressure = 0.5 * 1000.0 * 4.0 * (0.8 - 0.2 * 0.8);
    near(way(&text), pressure * 2.0 * 0.1 / 1e4, 0.02);
}

/// Along a slow stream a beam swings by as much as the first mode has of the deflection under ½ρU² from one side,
/// 0.1267 ½ρU² l⁴/(E I) (1/8 in all modes); along a stronger one by U/ω = 0.18 m: Euler's ω = 3.5160 √(E I/(ρ h))/l². A
/// fast stream shakes it by a quarter of its length.
#[test]
fn a_beam_in_a_stream_swings_no_faster_than_that_and_no_wider_than_flags_do() {
    let text = edited(CANTILEVER, "gravity = [0, \"-1 m/s^2\"]\n", "");
    let text = edited(&text, "density = 0.01,", "density = 1000.0,");
    let text = edited(&text, "supports = [{ on = \"left\" }]", "supports = [{ on = \"right\" }]");
    let stream = |speed: &str| {
        let ends = format!(
            "[[boundary]]\non = \"left\"\nkind = \"inlet\"\nvelocity = [\"{speed}\", 0]\n[[boundary]]\non = \"right\"\nkind = \"outlet\"\n"
        );
        let text = edited(&text, "[[boundary]]", &format!("{ends}[[boundary]]"));
        // Away from the inlet.
        edited(&text, "lower = [0, 0.95], upper = [1, 1.05]", "lower = [0.3, 0.95], upper = [1.3, 1.05]")
    };
    let omega = 3.516_015 * (62.5f64 / 100.0).sqrt();
    near(way(&stream("0.2 m/s")), 0.1267 * 0.5 * 1000.0 * 0.2f64.powi(2) / 62.5, 0.03);
    near(way(&stream("0.5 m/s")), 0.5 / omega, 0.02);
    near(way(&stream("5 m/s")), 0.25, 1e-6);
}
