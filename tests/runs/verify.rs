//! `expected.toml` applied to histories that were made by hand.

use lateen::error::Error;
use lateen::run::Folder;
use lateen::verify::{self, Level};
use std::fs;

const EXPECTED: &str = "
[quick]
set = { 'grid.cell' = '2 mm', 'body.water.spacing' = 0.001 }
[[check]]
name = 'deflection'
history = 'centre'
value = 'z'
kind = 'curve'
reference = [{ file = 'a.csv', x = 't', y = 'z' }, { file = 'b.csv', x = 't', y = 'z' }]
tolerance = { relative = 0.05 }
quick = { relative = 0.2 }
source = 'two programs'
[[drawn]]
history = 'corner'
value = 'z'
reference = [{ file = 'a.csv', x = 't', y = 'z', x-scale = 2.0 }]
source = 'one program'
";

fn folder(home: &tempfile::TempDir, history: &str) -> Folder {
    for (file, text) in [
        ("case.toml", "name = 'c'"),
        ("expected.toml", EXPECTED),
        ("a.csv", "# a\nt,z\n0,0\n1,-1\n"),
        ("b.csv", "t,z\n0,0\n1,-1.2\n"),
        ("centre.csv", history),
    ] {
        fs::write(home.path().join(file), text).unwrap();
    }
    Folder::open(home.path().to_str().unwrap()).unwrap()
}

#[test]
fn a_history_is_compared_with_the_band_of_curves_within_the_tolerance_of_the_level() {
    let home = tempfile::tempdir().unwrap();
    let folder = folder(&home, "time [s],z [m]\n0,0\n0.5,-0.7\n1,-1.25\n");
    let expected = verify::expected(&folder).unwrap().unwrap();
    let outcome = |level| verify::compare(&folder, &expected, level, home.path()).unwrap().remove(0);
    let quick = outcome(Level::Quick);
    assert_eq!((quick.computed, quick.reference), (Some(-0.7), -1.2));
    assert!((quick.deviation - 0.1).abs() < 1e-12 && quick.passed());
    assert!(!outcome(Level::Full).passed(), "0.1 is more than 5 % of 1.2");
}

#[test]
fn two_curves_are_drawn_as_a_band_and_one_as_points() {
    use lateen::output::plot::CurveShape;
    let home = tempfile::tempdir().unwrap();
    let folder = folder(&home, "time [s],z [m]\n");
    let expected = verify::expected(&folder).unwrap().unwrap();
    let drawn = verify::drawn(&folder, &expected).unwrap();
    assert_eq!(drawn[0].shape, CurveShape::Band(vec![[0.0, 0.0, 0.0], [1.0, -1.2, -1.0]]));
    assert_eq!(drawn[1].shape, CurveShape::Points(vec![[0.0, 0.0], [2.0, -1.0]]));
}

#[test]
fn overrides_of_a_level_are_those_of_the_command_line() {
    let home = tempfile::tempdir().unwrap();
    let expected = verify::expected(&folder(&home, "")).unwrap().unwrap();
    let pairs = expected.effort(Level::Quick).overrides();
    assert_eq!(pairs[0], ("body.water.spacing".to_owned(), "0.001".to_owned()));
    assert_eq!(pairs[1], ("grid.cell".to_owned(), "2 mm".to_owned()));
}

#[test]
fn a_missing_history_is_an_error_that_lists_the_written_ones() {
    let home = tempfile::tempdir().unwrap();
    let folder = folder(&home, "");
    fs::remove_file(home.path().join("centre.csv")).unwrap();
    let expected = verify::expected(&folder).unwrap().unwrap();
    fs::write(home.path().join("corner.csv"), "time [s],z [m]\n").unwrap();
    let error = verify::compare(&folder, &expected, Level::Full, home.path()).unwrap_err();
    assert!(matches!(error, Error::Case(_)));
    let text = error.to_string();
    assert!(text.contains("`check `deflection``: there is no history `centre`"), "{text}");
    assert!(text.contains("the run wrote a, b, corner"), "{text}");
}

#[test]
fn the_references_of_every_built_in_case_can_be_read() {
    for case in lateen::catalog::all() {
        let folder = Folder::built_in(case);
        let expected = verify::expected(&folder).unwrap().unwrap();
        assert!(!expected.checks.is_empty(), "{} is compared with nothing", case.name());
        verify::drawn(&folder, &expected).unwrap();
    }
}
