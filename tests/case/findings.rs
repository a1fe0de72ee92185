//! Cases from text, and what is found wrong with them.

use lateen::Error;
use lateen::case::{Case, Model, Source, line_and_column};
use lateen::error::{Diagnostic, Severity};
use std::path::Path;

/// The model of a case in the folder `base`, with values that replace its own.
pub fn overridden(text: &str, base: &Path, overrides: &[(&str, &str)]) -> Result<Model, Vec<Diagnostic>> {
    let overrides: Vec<_> = overrides.iter().map(|(key, value)| (key.to_string(), value.to_string())).collect();
    match Case::read(Source::new("case.toml", base, text), &overrides).and_then(|case| case.model()) {
        Ok(model) => Ok(model),
        Err(Error::Case(findings)) => Err(findings),
        Err(other) => panic!("{other}"),
    }
}

/// The model of a case in the folder `base`.
pub fn model(text: &str, base: &Path) -> Result<Model, Vec<Diagnostic>> {
    overridden(text, base, &[])
}

/// The model of a case that is right.
pub fn good(text: &str) -> Model {
    good_with(text, &[])
}

/// The model of a case that is right with values that replace its own.
pub fn good_with(text: &str, overrides: &[(&str, &str)]) -> Model {
    overridden(text, Path::new(""), overrides).unwrap_or_else(|findings| {
        panic!("{}", Source::new("case.toml", "", text).render(&findings, false));
    })
}

/// A case in which `from`, which it has once, is replaced.
#[track_caller]
pub fn edited(case: &str, from: &str, to: &str) -> String {
    assert_eq!(case.matches(from).count(), 1, "`{from}` must occur once");
    case.replace(from, to)
}

/// Expects one finding, at the first place of `at` in the text; at any if that is empty.
#[track_caller]
pub fn expect_one(found: &[Diagnostic], text: &str, at: &str, message: &str, help: &str) {
    let [finding] = found else { panic!("one finding is expected, {message}: {found:#?}") };
    assert!(finding.message.contains(message), "{}", finding.message);
    assert!(finding.help.as_deref().unwrap_or("").contains(help), "{finding:?}");
    if !at.is_empty() {
        let start = finding.span.as_ref().expect("a place").start;
        let wanted = text.find(at).expect("the marked text is there");
        assert_eq!(line_and_column(text, start), line_and_column(text, wanted), "{finding:?}");
    }
}

/// Expects one error, whatever warnings there are, as [`expect_one`].
#[track_caller]
pub fn expect_error(text: &str, at: &str, message: &str, help: &str) {
    let mut found = model(text, Path::new("")).err().unwrap_or_default();
    found.retain(|finding| finding.severity == Severity::Error);
    expect_one(&found, text, at, message, help);
}
