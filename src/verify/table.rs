//! The table that `lateen verify` prints.

use super::Outcome;

/// One line per comparison: verdict, what, computed, reference, deviation, tolerance, source.
pub fn render(case: &str, outcomes: &[Outcome]) -> String {
    let width = outcomes.iter().map(|outcome| outcome.name.chars().count()).max().unwrap_or(0);
    let mut text = format!("{case}\n");
    text.push_str(&format!(
        "        {:width$}  {:>11}  {:>11}  {:>10}  {:>10}  source\n",
        "", "computed", "reference", "deviation", "tolerance"
    ));
    for outcome in outcomes {
        let verdict = if outcome.passed() { "ok" } else { "FAILED" };
        let computed = outcome.computed.map_or_else(|| "nothing".to_owned(), |value| format!("{value:.4e}"));
        text.push_str(&format!(
            "{verdict:6}  {:width$}  {computed:>11}  {:>11}  {:>10}  {:>10}  {}\n",
            outcome.name,
            format!("{:.4e}", outcome.reference),
            relative(outcome.deviation, outcome.reference),
            relative(outcome.limit, outcome.reference),
            outcome.source,
        ));
    }
    text
}

/// A deviation as a percentage of the reference, or as it is if the reference is zero.
fn relative(deviation: f64, reference: f64) -> String {
    if reference == 0.0 { format!("{deviation:.2e}") } else { format!("{:.2} %", 100.0 * deviation / reference.abs()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_what_was_compared_and_how_it_ended() {
        let outcome = |computed, deviation| Outcome {
            name: "peak".into(),
            computed,
            reference: -2.0,
            deviation,
            limit: 0.06,
            source: "a paper".into(),
        };
        let text = render("case", &[outcome(Some(-2.02), 0.02), outcome(None, f64::INFINITY)]);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[2].starts_with("ok") && lines[2].contains("1.00 %") && lines[2].contains("3.00 %"), "{text}");
        assert!(lines[3].starts_with("FAILED") && lines[3].contains("nothing"), "{text}");
        assert!(lines[2].ends_with("a paper"));
    }
}
