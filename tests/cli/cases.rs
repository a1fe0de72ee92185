//! The subcommands besides `run`, called as a process.

use lateen::catalog;
use std::fs;
use std::process::{Command, Output};

fn lateen(directory: &std::path::Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lateen")).args(arguments).current_dir(directory).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn the_list_of_cases_has_a_line_with_the_method_of_each() {
    let home = tempfile::tempdir().unwrap();
    let output = lateen(home.path(), &["cases"]);
    let list = text(&output.stdout);
    assert!(output.status.success());
    for case in catalog::all() {
        let line = list
            .lines()
            .find(|line| line.split_whitespace().next() == Some(case.name()))
            .expect("every case has its line");
        assert!(line.contains(case.method()), "{line}");
    }
}

#[test]
fn a_new_case_can_be_checked() {
    let home = tempfile::tempdir().unwrap();
    assert!(lateen(home.path(), &["new", "sphere-on-membrane", "mine"]).status.success());
    assert!(home.path().join("mine/reference/calculix.csv").is_file());
    let output = lateen(home.path(), &["check", "mine/case.toml"]);
    let report = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    // 50 × 50 quadrilaterals; as many particles as the sphere has volumes of a particle, up to the lattice at its
    // surface.
    assert!(report.contains("2500 elements"), "{report}");
    let line = report.lines().find(|line| line.starts_with("body sphere:")).expect("the sizes of the sphere");
    let particles: f64 = line.split_whitespace().nth(2).unwrap().parse().unwrap();
    assert!((particles / 3053.6 - 1.0).abs() < 0.03, "{line}");

    let spaced = text(&lateen(home.path(), &["new", "hertz", "my first case"]).stdout);
    assert!(spaced.contains("lateen run 'my first case/case.toml'\n"), "{spaced}");

    let again = lateen(home.path(), &["new", "sphere-on-membrane", "mine"]);
    assert_eq!(again.status.code(), Some(4), "nothing is overwritten");
    assert!(text(&again.stderr).contains("name another directory"), "{}", text(&again.stderr));
}

/// Of both methods, in two and three dimensions. (That all of them build without unexpected warnings is tested in
/// `case/catalog.rs`.)
#[test]
fn built_in_cases_are_checked_by_their_names() {
    let home = tempfile::tempdir().unwrap();
    for name in ["vibrating-bar", "bouncing-ball", "hydrostatic", "taylor-green-3d", "cantilever-static"] {
        let output = lateen(home.path(), &["check", name]);
        assert_eq!(output.status.code(), Some(0), "{name}: {}", text(&output.stderr));
        assert!(!text(&output.stderr).contains("warning"), "{name}: {}", text(&output.stderr));
        assert!(text(&output.stdout).contains("cells") || text(&output.stdout).contains("elements"), "{name}");
    }
}

#[test]
fn a_mistyped_case_name_is_an_error_that_suggests_the_nearest() {
    let home = tempfile::tempdir().unwrap();
    let output = lateen(home.path(), &["run", "water-spere"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("did you mean `water-sphere`?"), "{}", text(&output.stderr));
}

#[test]
fn completions_hold_the_subcommands() {
    let home = tempfile::tempdir().unwrap();
    let output = lateen(home.path(), &["completions", "bash"]);
    assert!(text(&output.stdout).contains("verify"));
}

#[cfg(unix)]
#[test]
fn a_closed_standard_output_is_no_failure() {
    use std::process::Stdio;
    for arguments in [&["cases"][..], &["laws"], &["schema"], &["completions", "bash"]] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lateen"));
        let mut child = command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), String::new()), "{arguments:?}");
    }
}

#[test]
fn a_number_of_threads_out_of_range_is_an_error() {
    let home = tempfile::tempdir().unwrap();
    for count in ["100000", "0", "many"] {
        let output = lateen(home.path(), &["run", "water-sphere", "--threads", count]);
        assert!(text(&output.stderr).contains("from 1 to 1024"), "{}", text(&output.stderr));
    }
}

#[test]
fn the_schema_is_json_and_laws_have_units() {
    let home = tempfile::tempdir().unwrap();
    let schema: serde_json::Value = serde_json::from_slice(&lateen(home.path(), &["schema"]).stdout).unwrap();
    assert!(schema["properties"]["grid"].is_object());
    let laws = text(&lateen(home.path(), &["laws"]).stdout);
    let defaults = ["default { kind = \"second-order\", theta = 0.6 }", "`relaxation` (number [s], default inf)"];
    for word in ["neo-hookean", "mie-gruneisen", "young", "Pa"].into_iter().chain(defaults) {
        assert!(laws.contains(word), "{word} is missing from\n{laws}");
    }
}

#[test]
fn verify_exits_with_1_when_a_comparison_fails_and_2_when_nothing_is_compared() {
    let home = tempfile::tempdir().unwrap();
    let case = "name = 'fall'\ndimension = 2\n[time]\nend = 0.1\n[grid]\ncell = 0.1\nlower = [0, 0]\nupper = [1, 1]\n\
        [mpm]\ngravity = [0, -10]\n[[body]]\nname = 'block'\nspacing = 0.05\n\
        region = { shape = 'box', lower = [0.4, 0.4], upper = [0.6, 0.6] }\n\
        material = { law = 'hypoelastic', density = 1000, young = 1e5, poisson = 0.3 }\n\
        [[probe]]\nname = 'centre'\nof = 'block'\nreduce = 'center-of-mass'\n";
    let expected = "[[check]]\nname = 'fallen'\nhistory = 'centre'\nvalue = 'y'\nkind = 'final'\nreference = 0.45\n\
        tolerance = { absolute = 0.001 }\nsource = 'g t^2 / 2'\n";
    fs::write(home.path().join("case.toml"), case).unwrap();
    fs::write(home.path().join("expected.toml"), expected).unwrap();
    let good = lateen(home.path(), &["verify", "case.toml"]);
    assert_eq!(good.status.code(), Some(0), "{}{}", text(&good.stdout), text(&good.stderr));
    assert!(text(&good.stdout).contains("1 of 1 comparisons hold"), "{}", text(&good.stdout));

    fs::write(home.path().join("expected.toml"), expected.replace("0.45", "0.46")).unwrap();
    let bad = lateen(home.path(), &["verify", "case.toml"]);
    assert_eq!(bad.status.code(), Some(1), "{}", text(&bad.stderr));
    assert!(text(&bad.stdout).contains("FAILED"), "{}", text(&bad.stdout));

    // A case that is left out is listed with its run time.
    let long = format!("[measured]\ntime = '29 min'\n[quick]\nskip = true\n{expected}");
    fs::write(home.path().join("expected.toml"), long).unwrap();
    let short = lateen(home.path(), &["verify", "case.toml"]);
    assert_eq!(short.status.code(), Some(2), "{}", text(&short.stdout));
    assert!(text(&short.stdout).contains("left out    takes 29 min"), "{}", text(&short.stdout));
    assert!(text(&short.stderr).contains("add `--full`"), "{}", text(&short.stderr));
    let full = lateen(home.path(), &["verify", "case.toml", "--full"]);
    assert!(text(&full.stdout).contains("1 of 1 comparisons hold"), "{}", text(&full.stdout));

    // A variant runs with `--full`, with its settings and comparisons.
    let slower = expected.replace("[[check]]", "[[variant.check]]").replace("0.45", "0.475");
    let variant = format!("{expected}[[variant]]\nname = 'half-g'\nset = {{ 'mpm.gravity' = [0, -5] }}\n");
    fs::write(home.path().join("expected.toml"), format!("{variant}{slower}")).unwrap();
    for (arguments, holds) in
        [(vec!["verify", "case.toml"], "1 of 1"), (vec!["verify", "case.toml", "--full"], "2 of 2")]
    {
        let run = lateen(home.path(), &arguments);
        assert!(text(&run.stdout).contains(&format!("{holds} comparisons hold")), "{}", text(&run.stdout));
    }
    assert!(home.path().join("runs/verify/fall-half-g/history/centre.csv").is_file());
    fs::write(home.path().join("expected.toml"), variant).unwrap();
    let bare = lateen(home.path(), &["verify", "case.toml"]);
    assert!(text(&bare.stderr).contains("it is compared with nothing"), "{}", text(&bare.stderr));
    assert!(text(&bare.stderr).contains("--> expected.toml:9:1"), "{}", text(&bare.stderr));

    // Errors in `expected.toml` are shown at their place there, and a case without comparisons is no success.
    fs::write(home.path().join("expected.toml"), expected.replace("kind = 'final'", "kind = 'value'")).unwrap();
    for command in [["verify", "case.toml"], ["run", "case.toml"]] {
        let wrong = lateen(home.path(), &command);
        assert_eq!(wrong.status.code(), Some(2), "{}", text(&wrong.stderr));
        assert!(text(&wrong.stderr).contains("--> expected.toml:1:1"), "{}", text(&wrong.stderr));
    }
    fs::remove_file(home.path().join("expected.toml")).unwrap();
    let nothing = lateen(home.path(), &["verify", "case.toml"]);
    assert_eq!(nothing.status.code(), Some(2), "{}", text(&nothing.stderr));
    assert!(text(&nothing.stderr).contains("nothing to compare `case.toml` with"), "{}", text(&nothing.stderr));
}
