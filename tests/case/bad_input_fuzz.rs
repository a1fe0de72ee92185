//! The case reader survives whatever it is given: random text, truncated cases, scrambled cases.

use lateen::Error;
use lateen::case::{Case, Source};
use lateen::math::{Signal, TimeTable, units::Quantity};
use proptest::prelude::*;

const GOOD: &str = include_str!("../fixtures/water_sphere.toml");

/// Reads a text as a case; findings must be there where it is wrong, and render.
fn read(text: &str) {
    let source = Source::new("case.toml", "", text);
    if let Err(Error::Case(findings)) = Case::read(source.clone(), &[]) {
        assert!(!findings.is_empty());
        assert!(source.render(&findings, true).len() > 10);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_text_never_panics_the_case_reader(text in "\\PC{0,200}") {
        read(&text);
    }

    #[test]
    fn random_bytes_never_panic_the_case_reader(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        read(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn truncated_cases_never_panic_the_case_reader(at in 0..GOOD.len()) {
        if GOOD.is_char_boundary(at) {
            read(&GOOD[..at]);
        }
    }

    #[test]
    fn edited_cases_never_panic_the_case_reader(edits in proptest::collection::vec((0..GOOD.len(), "[-\\[\\]{}=\"a-z0-9.,\n µ²]{0,3}"), 1..8)) {
        let mut text = GOOD.to_owned();
        for (at, insert) in edits {
            let end = (at + insert.len()).min(text.len());
            if at <= end && text.is_char_boundary(at) && text.is_char_boundary(end) {
                text.replace_range(at..end, &insert);
            }
        }
        read(&text);
    }

    #[test]
    fn a_value_of_any_type_at_any_key_never_panics_the_case_reader(
        line in 0..GOOD.lines().count(),
        value in prop_oneof![
            Just("[]"), Just("{}"), Just("[[[]]]"), Just("1979-05-27"), Just("\"\""), Just("-inf"), Just("nan"),
            Just("0xffffffff"), Just("9223372036854775807"), Just("1e400"), Just("\"1 m^99\""), Just("true"),
            Just("{ kind = 1 }"), Just("{ shape = [] }"), Just("[{ on = {} }]"), Just("{ table = \"none.csv\" }"),
        ],
    ) {
        let lines: Vec<String> = GOOD.lines().enumerate().map(|(i, text)| match text.split_once(" = ") {
            Some((key, _)) if i == line => format!("{key} = {value}"),
            _ => text.to_owned(),
        }).collect();
        read(&lines.join("\n"));
    }

    #[test]
    fn random_formulas_and_quantities_never_panic_their_parsers(text in "[-+*/^(). ,0-9a-zµ²]{0,40}") {
        let _ = Signal::formula(&text).map(|s| s.value([0.1, 0.2, 0.3], 0.4));
        let _ = Quantity::parse(&text);
    }

    #[test]
    fn random_tables_never_panic_their_parser(text in "(t|x)?,?(p \\[[a-z]{0,3}\\])?\n([0-9.,-]{0,8}\n){0,5}") {
        let _ = TimeTable::from_csv(&text, None, None).map(|t| t.value(0.5));
    }
}

#[test]
fn deep_nesting_never_overflows_the_stack() {
    read(&format!("a = {}", "[".repeat(100_000)));
    read(&format!("a = {}1{}", "[".repeat(60), "]".repeat(60)));
    read(&format!("body = [{{ region = {}", "{ of = ".repeat(5000)));
    read(&format!("[{}]", vec!["a"; 5000].join(".")));
}
