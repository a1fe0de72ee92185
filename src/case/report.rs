//! Shows findings as rustc does: the place in the file, the text underlined, what to do.

use crate::error::{Diagnostic, Severity, escaped, first};
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

/// Renders findings, the first of many; `color` for terminals.
///
/// `name` is the path to show, `text` the case file.
pub fn render(findings: &[Diagnostic], name: &str, text: &str, color: bool) -> String {
    if findings.is_empty() {
        return String::new();
    }
    let renderer = if color { Renderer::styled() } else { Renderer::plain() };
    let (shown, more) = first(findings);
    let rendered = shown.into_iter().map(visible);
    let rendered = rendered.map(|finding| renderer.render(&[group(&finding, name, text)]).to_string());
    let mut page = rendered.chain(more).collect::<Vec<_>>().join("\n\n");
    page.push('\n');
    page
}

/// A finding with control characters made visible: names in it come from a file.
fn visible(finding: &Diagnostic) -> Diagnostic {
    let Diagnostic { key, message, help, span, severity } = finding;
    Diagnostic {
        key: escaped(key),
        message: escaped(message),
        help: help.as_deref().map(escaped),
        span: span.clone(),
        severity: *severity,
    }
}

fn group<'a>(finding: &'a Diagnostic, name: &'a str, text: &'a str) -> Group<'a> {
    let level = match finding.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let place = finding.span.as_ref().map(|span| within(span, text));
    let mut group = match place {
        Some(span) => {
            let underline = AnnotationKind::Primary.span(span);
            let underline = if finding.key.is_empty() { underline } else { underline.label(&finding.key) };
            level.primary_title(&finding.message).element(Snippet::source(text).path(name).annotation(underline))
        }
        None => Group::with_title(level.primary_title(without_place(finding, name))),
    };
    if let Some(help) = &finding.help {
        group = group.element(Level::HELP.message(help));
    }
    group
}

/// A finding about something that is not in the file: an override, or the case as a whole.
fn without_place(finding: &Diagnostic, name: &str) -> String {
    let key = if finding.key.is_empty() { name } else { &finding.key };
    format!("{key}: {}", finding.message)
}

/// The span, cut to the text and to whole characters.
fn within(span: &std::ops::Range<usize>, text: &str) -> std::ops::Range<usize> {
    let start = (0..=span.start.min(text.len())).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0);
    let end = span.end.clamp(start, text.len());
    let end = (end..=text.len()).find(|&i| text.is_char_boundary(i)).unwrap_or(text.len());
    start..end
}

/// Line and column (from 1, in characters) of a byte of the text.
pub fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let before = &text[..within(&(byte..byte), text).start];
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
    (line, column)
}
