//! Errors of case files: all are reported at once, each with line, column and the text to write instead.

use super::findings::{edited, expect_one};
use lateen::Error;
use lateen::case::{Case, Source, is_case_name, line_and_column};
use lateen::error::Diagnostic;

const GOOD: &str = include_str!("../fixtures/water_sphere.toml");

fn findings(text: &str) -> Vec<Diagnostic> {
    match Case::read(Source::new("case.toml", "", text), &[]) {
        Ok(_) => Vec::new(),
        Err(Error::Case(findings)) => findings,
        Err(other) => panic!("{other}"),
    }
}

/// Replaces `from` in the good case and expects one finding, at the place of `at` in the new text.
#[track_caller]
fn expect(from: &str, to: &str, at: &str, message: &str, help: &str) {
    let text = edited(GOOD, from, to);
    expect_one(&findings(&text), &text, at, message, help);
}

#[test]
fn a_correct_case_has_no_findings() {
    assert_eq!(findings(GOOD), []);
}

#[test]
fn errors_of_syntax_are_shown_at_their_place() {
    expect("dimension = 3", "dimension = ", "\n\n[time]", "not TOML", "");
    expect("dimension = 3", "dimension = 3\ndimension = 2", "dimension = 2", "not TOML: duplicate key", "");
    expect("[0, 0, \"-9.81 m/s^2\"]", "[0, 0, \"-9.81 m/s^2]", "\n\n[[body]]", "not TOML", "");
}

#[test]
fn an_unknown_key_is_an_error_that_suggests_the_nearest_key() {
    expect("spacing =", "spacng = \"1 mm\"\nspacing =", "spacng", "unknown key `spacng`", "did you mean `spacing`?");
    expect("[mpm]", "[mpn]\n[mpm]", "mpn", "unknown key `mpn`", "did you mean `mpm`?");
    expect("slope =", "frobnicate = 1, slope =", "frobnicate", "unknown key `frobnicate`", "known keys are kind,");
}

#[test]
fn a_missing_key_is_an_error_that_shows_what_to_write() {
    expect("thickness = \"0.1 mm\"\n", "", "[[membrane]]", "the key `thickness` is missing", "thickness = \"1 mm\"");
    expect("law = \"fluid\", ", "", "{ density = \"1e-3", "the key `law` is missing", "`fluid`");
}

/// Without a method a case is one of material points; keys of the other method say which was meant.
#[test]
fn a_missing_method_is_an_error_that_names_the_one_the_keys_belong_to() {
    let flow = include_str!("../fixtures/two_fluids.toml").replace("method = \"pfem2\"\n", "");
    let found = findings(&flow);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].message.starts_with("the key `method` is missing, and `mesh` belongs to"), "{found:?}");
    assert!(found[0].help.as_ref().unwrap().starts_with("write `method = \"pfem2\"`"), "{found:?}");
    assert_eq!(line_and_column(&flow, found[0].span.as_ref().unwrap().start).0, 6);
    let neither = findings("name = \"a\"\ndimension = 2\ntime = { end = 1 }\n");
    assert!(neither[0].message.contains("`grid` is missing"), "{neither:?}");
    assert!(neither[0].help.as_ref().unwrap().contains("or `method = \"pfem2\"` and its `[mesh]`"), "{neither:?}");
}

#[test]
fn an_empty_table_is_an_error_at_the_key_that_names_it() {
    let home = tempfile::tempdir().unwrap();
    std::fs::write(home.path().join("empty.csv"), "").unwrap();
    let metal =
        "{ law = \"j2\", density = 1000, young = \"1 GPa\", poisson = 0.3, yield-stress = { table = \"empty.csv\" } }";
    let law = GOOD.find("{ law = \"fluid\"").unwrap();
    let end = law + GOOD[law..].find('\n').unwrap();
    let curve = format!("{}{metal}{}", &GOOD[..law], &GOOD[end..]);
    let force =
        |columns: &str| GOOD.replace("\"1 kPa * ramp(t, 0.1 ms)\"", &format!("{{ table = \"empty.csv\"{columns} }}"));
    for text in [curve, force(""), force(", time = \"t\"")] {
        let Err(Error::Case(found)) = Case::read(Source::new("case.toml", home.path(), &text), &[]) else {
            panic!("{text}")
        };
        assert_eq!(found.len(), 1, "{found:#?}");
        assert!(
            found[0]
                .message
                .ends_with("the file is empty: it needs a row of names, such as `t [s],p [Pa]`, and rows of numbers")
        );
        assert!(text[found[0].span.clone().unwrap()].starts_with("{ table = \"empty.csv\""), "{found:?}");
    }
}

#[test]
fn case_names_are_those_that_a_folder_can_have() {
    for name in ["a\"b", "it's", "two words", &"x".repeat(100)] {
        assert!(is_case_name(name), "{name}");
    }
    for name in ["", " ", ".hidden", "a/b", "a\\b", "a\nb", "a\0", &"x".repeat(101), &"ö".repeat(51)] {
        assert!(!is_case_name(name), "{name:?}");
    }
}

#[test]
fn a_wrong_unit_is_an_error_that_names_both_quantities() {
    expect(
        "density = \"1e-3 g/mm^3\"",
        "density = \"1e-3 g/mm^2\"",
        "\"1e-3 g/mm^2\"",
        "expected a density (kg/m^3), found a mass per area (kg/m^2)",
        "\"1000 kg/m^3\"",
    );
    expect("\"-10 mm/ms\"", "\"-10 mm\"", "\"-10 mm\"", "expected a velocity (m/s), found a length (m)", "\"10 m/s\"");
    expect("poisson = 0.3", "poisson = \"0.3 m\"", "\"0.3 m\"", "expected a plain number, found a length (m)", "0.3");
    expect("end = \"1.2 ms\"", "end = \"1.2 msec\"", "\"1.2 msec\"", "`msec` is not a unit", "\"0.5 ms\"");
}

#[test]
fn units_in_a_dimensionless_case_are_errors() {
    let text = GOOD.replace("dimension = 3", "dimension = 3\nunits = \"none\"");
    let found = findings(&text);
    assert!(found.len() > 10);
    assert!(found.iter().all(|f| f.message == "this case has no units"), "{found:#?}");
}

/// A condition between several parameters has no place of its own: the finding stands at the law.
#[test]
fn parameters_that_a_law_refuses_are_errors_at_the_law() {
    let water = "{ law = \"fluid\", density = \"1e-3 g/mm^3\", eos = { kind = \"mie-gruneisen\", \
                 sound-speed = \"1647 mm/ms\", slope = 1.921, gruneisen = 0.1 } }";
    let metal = "{ law = \"j2\", density = 1000, young = \"1 GPa\", poisson = 0.3, \
                 yield-stress = [[0, \"1 MPa\"], [0.1, \"2 MPa\"], [0.1, \"3 MPa\"]] }";
    expect(water, metal, "{ law = \"j2\"", "the plastic strains must increase: row 3 has 0.1 after 0.1", "");
}

#[test]
fn a_value_of_the_wrong_type_is_an_error_that_names_both_types() {
    expect("dimension = 3", "dimension = \"three\"", "\"three\"", "expected a whole number, found text", "");
    expect("thickness = \"0.1 mm\"", "thickness = [1]", "[1]", "expected a length (m), found a list", "");
    expect("wrinkling = true", "wrinkling = 7", "7 }", "expected true or false, found a whole number", "");
    expect("between = [\"water\", \"sheet\"]", "between = \"water\"", "\"water\"\nfriction", "expected a list", "");
}

#[test]
fn a_value_out_of_range_is_an_error_that_states_the_range() {
    expect("\"1e-3 g/mm^3\"", "-1000", "-1000", "must be above 0 kg/m^3, found -1000 kg/m^3", "");
    expect("thickness = \"0.1 mm\"", "thickness = 0.0", "0.0\nmaterial", "must be above 0 m, found 0 m", "");
    expect("poisson = 0.3", "poisson = 0.6", "0.6", "must be", "");
    expect("end = \"1.2 ms\"", "end = \"-1 ms\"", "\"-1 ms\"", "must be above 0 s, found -0.001 s", "");
    expect("end = \"1.2 ms\"", "end = nan", "nan", "NaN is not a usable number here", "");
    expect("radius = \"4.5 mm\"", "radius = inf", "inf", "inf is not a usable number here", "");
}

#[test]
fn an_unknown_name_of_a_law_shape_or_wall_is_an_error_that_lists_the_known_ones() {
    expect(
        "law = \"fluid\"",
        "law = \"flud\"",
        "\"flud\"",
        "unknown name `flud`; expected one of `fluid`, `hypoelastic`",
        "did you mean `fluid`?",
    );
    expect("shape = \"sphere\"", "shape = \"Ball\"", "\"Ball\"", "unknown name `Ball`", "did you mean `sphere`?");
    expect(
        "left = \"slip\"",
        "left = \"slipp\"",
        "\"slipp\"",
        "expected one of `open`, `fixed`",
        "did you mean `slip`?",
    );
    expect("kind = \"friction\"", "kind = \"frictional\"", "\"frictional\"", "unknown name", "");
    expect("friction = 0.2", "friction = \"sticky\"", "\"sticky\"", "one of `stick`, `none`", "did you mean `stick`?");
}

#[test]
fn a_list_of_the_wrong_length_is_an_error_that_states_the_length() {
    expect(
        "upper = [\"27 mm\", ",
        "upper = [",
        "[\"27 mm\", \"14 mm\"]",
        "expected 3 entries (one per axis), found 2",
        "",
    );
    expect("[\"water\", \"sheet\"]", "[\"water\"]", "[\"water\"]", "expected 2 entries, found 1", "");
}

#[test]
fn a_third_coordinate_in_2d_is_an_error() {
    let text =
        "name = \"a\"\ndimension = 2\ntime = { end = 1 }\ngrid = { cell = 1, lower = [0, 0, 1], upper = [1, 1] }";
    let found = findings(text);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert_eq!(found[0].key, "grid.lower");
    assert_eq!(found[0].help.as_deref(), Some("this case is two-dimensional"));
}

#[test]
fn a_wrong_formula_is_an_error_at_the_place_within_it() {
    expect("\"1 kPa * ramp(t, 0.1 ms)\"", "\"1 kPa * rmp(t)\"", "rmp", "`rmp` is not known in formulas", "");
    expect(
        "\"1 kPa * ramp(t, 0.1 ms)\"",
        "\"1 kPa * sin(t)\"",
        "t)\"",
        "`sin` takes a plain number; this is a time",
        "",
    );
    expect("\"1 kPa * ramp(t, 0.1 ms)\"", "\"1 kN * ramp(t, 1 ms)\"", "\"1 kN", "expected a pressure", "\"70 GPa\"");
    expect("\"1 kPa * ramp(t, 0.1 ms)\"", "\"1/(2 - 2)\"", "\"1/(2 - 2)\"", "inf is not a usable number here", "");
    expect("\"1 kPa * ramp(t, 0.1 ms)\"", "\"2*(t\"", "\", follower", "a closing parenthesis is missing", "");
}

#[test]
fn all_errors_are_reported_at_once_in_the_order_of_the_file() {
    let text = GOOD
        .replace("\"1.2 ms\"", "\"1.2 kg\"")
        .replace("spacing =", "spacng =")
        .replace("thickness = \"0.1 mm\"", "thickness = 0")
        .replace("between = [\"water\", \"sheet\"]", "between = 3");
    let found = findings(&text);
    let keys: Vec<&str> = found.iter().map(|f| f.key.as_str()).collect();
    assert_eq!(keys, ["time.end", "body[0].spacng", "membrane[0].thickness", "contact[0].between"]);
}

#[test]
fn overrides_are_checked_as_the_file_is() {
    let set = |key: &str, value: &str| {
        let overrides = [(key.to_owned(), value.to_owned())];
        match Case::read(Source::new("case.toml", "", GOOD), &overrides) {
            Err(Error::Case(findings)) => findings[0].to_string(),
            other => panic!("{other:?}"),
        }
    };
    assert!(set("time.end", "1 kg").contains("`--set time.end=1 kg`: expected a time (s), found a mass (kg)"));
    assert!(set("body[0].spacing", "1 kg").contains("`--set body[0].spacing=1 kg`: expected a length"));
    let law = set("body[0].material", "{ law = 'wood' }");
    assert!(law.contains("`--set body[0].material={ law = 'wood' }`: `body[0].material.law`: unknown name"), "{law}");
    assert!(set("body[7].spacing", "1").contains("there is no `7` to set"));
    assert!(set("body.watr.spacing", "1").contains("there is no `watr` to set"));
    assert!(set("mpm.kernl", "linear").contains("did you mean `kernel`?"));
    assert!(set("", "1").contains("there is no"));
}

#[test]
fn findings_are_rendered_as_the_rust_compiler_does() {
    let source = Source::new("case.toml", "", GOOD.replace("thickness = \"0.1 mm\"", "thickness = \"0.1 kg\""));
    let Err(Error::Case(findings)) = Case::read(source.clone(), &[]) else { panic!("a finding is expected") };
    let expected = "\
error: expected a length (m), found a mass (kg)
  --> case.toml:27:13
   |
27 | thickness = \"0.1 kg\"
   |             ^^^^^^^^ membrane[0].thickness
   |
   = help: write for example \"1 mm\"
";
    assert_eq!(source.render(&findings, false), expected);
}

#[test]
fn missing_and_unreadable_case_files_are_input_errors() {
    let directory = tempfile::tempdir().unwrap();
    let missing = Source::read(directory.path().join("none.toml")).unwrap_err();
    assert!(matches!(missing, Error::Io { .. }), "{missing}");
    assert_eq!(missing.exit_code(), 4);
    assert!(Source::read(directory.path()).is_err(), "a directory is no case");
    let binary = directory.path().join("binary.toml");
    std::fs::write(&binary, [b'a', 0xff, 0xfe]).unwrap();
    let error = Source::read(&binary).unwrap_err();
    assert!(error.to_string().contains("is not UTF-8 text (byte 1)"), "{error}");
}

/// Of a long file with one error per line the first twenty are shown, and the number of the others.
#[test]
fn at_most_twenty_findings_are_shown() {
    let wrong = |count: usize| (0..count).map(|i| format!("wrong-{i} = 1\n")).collect::<String>() + GOOD;
    let shown = |count: usize| {
        let source = Source::new("case.toml", "", wrong(count));
        let found = findings(&source.text);
        assert_eq!(found.len(), count);
        (source.render(&found, false), Error::Case(found).to_string())
    };
    let (page, text) = shown(20);
    assert!(page.matches("unknown key").count() == 20 && !page.contains("more errors"), "{page}");
    assert_eq!(text.matches("unknown key").count(), 20);
    let (page, text) = shown(3000);
    for text in [page, text] {
        assert_eq!(text.matches("unknown key").count(), 20);
        assert!(text.contains("`wrong-19`") && text.contains("… and 2980 more errors"), "{text}");
    }
}

/// Direction marks reverse the text behind them, and names that differ in invisible characters look alike.
#[test]
fn case_names_hold_no_invisible_characters() {
    for character in ['\u{202e}', '\u{7}', '\u{200b}', '\u{feff}', '\u{2066}', '\u{2028}', '\u{85}'] {
        assert!(!is_case_name(&format!("a{character}b")), "{character:?}");
    }
    for name in ["наука", "水", "été", "a b"] {
        assert!(is_case_name(name), "{name}");
    }
}

/// A key may hold escape sequences, which a terminal would execute.
#[test]
fn findings_escape_control_sequences_of_the_terminal() {
    let text = GOOD.replace("dimension = 3", "dimension = 3\n\"\\u001b[31m\\u202edoof\" = 1");
    let source = Source::new("case.toml", "", text.as_str());
    let found = findings(&text);
    for shown in [source.render(&found, false), Error::Case(found).to_string()] {
        assert!(!shown.contains(['\u{1b}', '\u{202e}']), "{shown:?}");
        assert!(shown.contains("\\u{1b}[31m\\u{202e}doof"), "{shown}");
    }
}
