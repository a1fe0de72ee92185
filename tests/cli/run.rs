//! `lateen run` as a process: files, exit codes, interruption and resume, folders that can't be used, a full disk.

use super::home::{Home, messages};
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// An elastic block under gravity in the plane: a few milliseconds per thousand steps.
const BLOCK: &str = r#"
name = "block"
dimension = 2
[time]
end = "20 ms"
[grid]
cell = "10 mm"
lower = ["0 mm", "0 mm"]
upper = ["200 mm", "200 mm"]
walls = { bottom = "slip" }
[mpm]
gravity = [0, "-9.81 m/s^2"]
[[body]]
name = "block"
region = { shape = "box", lower = ["50 mm", "0 mm"], upper = ["150 mm", "100 mm"] }
spacing = "5 mm"
material = { law = "hypoelastic", density = "1000 kg/m^3", young = "10 MPa", poisson = 0.3 }
[output]
history = "1 ms"
fields = "10 ms"
[[probe]]
name = "top"
of = "block"
reduce = "top"
"#;

fn code(output: &Output) -> i32 {
    output.status.code().expect("ends by itself")
}

/// Every history by name.
fn histories(run: &Path) -> Vec<(String, String)> {
    let files = fs::read_dir(run.join("history")).unwrap().map(|entry| entry.unwrap().path());
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    let mut tables: Vec<_> = files.map(|path| (name(&path), fs::read_to_string(&path).unwrap())).collect();
    tables.sort();
    tables
}

#[test]
fn a_run_writes_every_file_with_rows_at_multiples_of_the_interval() {
    let home = Home::new(BLOCK);
    let output = home.lateen(&["run", "case.toml"]);
    assert_eq!(code(&output), 0, "{}", messages(&output));
    let run = home.path("runs/block");
    for file in [
        "case.toml",
        "resolved.toml",
        "run.log",
        "status.json",
        "history/balance.csv",
        "history/top.csv",
        "fields/block.pvd",
        "plots/top.svg",
        "plots/top.png",
    ] {
        assert!(run.join(file).is_file(), "{file} is missing");
    }
    assert_eq!(fs::read_to_string(run.join("case.toml")).unwrap(), BLOCK);
    let status: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(run.join("status.json")).unwrap()).unwrap();
    assert_eq!((status["state"].as_str(), status["time"].as_f64()), (Some("done"), Some(0.02)));

    let top = fs::read_to_string(run.join("history/top.csv")).unwrap();
    let times: Vec<f64> = top.lines().skip(1).map(|row| row.split(',').next().unwrap().parse().unwrap()).collect();
    let expected: Vec<f64> = (0..=20).map(|n| f64::from(n) * 1e-3).collect();
    assert_eq!(times, expected, "rows at integer multiples of the interval");
    assert!(top.starts_with("time [s],top [m]"), "{top}");
    let summary = String::from_utf8_lossy(&output.stdout);
    assert!(summary.contains("particle-steps/s") && summary.contains("accounted for"), "{summary}");
}

#[test]
fn a_directory_with_a_run_is_refused_unless_forced() {
    let home = Home::new(BLOCK);
    assert_eq!(code(&home.lateen(&["run", "case.toml", "--out", "a"])), 0);
    let before = histories(&home.path("a"));
    let refused = home.lateen(&["run", "case.toml", "--out", "a", "--set", "mpm.gravity=[0, -1]"]);
    assert_eq!(code(&refused), 4);
    assert!(messages(&refused).contains("--force"), "{}", messages(&refused));
    assert_eq!(histories(&home.path("a")), before, "nothing was touched");
    assert_eq!(code(&home.lateen(&["run", "case.toml", "--out", "a", "--force", "--set", "mpm.gravity=[0, -1]"])), 0);
    assert_ne!(histories(&home.path("a")), before);
}

#[test]
fn histories_are_the_same_bytes_for_any_number_of_threads() {
    let home = Home::new(BLOCK);
    assert_eq!(code(&home.lateen(&["run", "case.toml", "--out", "one", "--threads", "1"])), 0);
    assert_eq!(code(&home.lateen(&["run", "case.toml", "--out", "three", "--threads", "3"])), 0);
    assert_eq!(histories(&home.path("one")), histories(&home.path("three")));
}

/// Waits until a run has written a row of its balance.
fn wait_for_rows(run: &Path, child: &mut Child) {
    let start = Instant::now();
    let rows = || fs::read_to_string(run.join("history/balance.csv")).map_or(0, |text| text.lines().count());
    while rows() < 3 && start.elapsed() < Duration::from_secs(60) {
        assert!(child.try_wait().unwrap().is_none(), "the run ended before it could be interrupted");
        sleep(Duration::from_millis(5));
    }
}

#[test]
#[cfg(unix)]
fn a_run_resumed_after_a_signal_leaves_the_same_bytes() {
    let home = Home::new(&BLOCK.replace("20 ms", "400 ms"));
    assert_eq!(code(&home.lateen(&["run", "case.toml", "--out", "whole"])), 0);

    let mut command = home.command(&["run", "case.toml", "--out", "parts"]);
    let mut child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    wait_for_rows(&home.path("parts"), &mut child);
    let sent = Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let interrupted = child.wait_with_output().unwrap();
    assert_eq!(code(&interrupted), 130, "{}", messages(&interrupted));
    assert!(messages(&interrupted).contains("--resume"), "{}", messages(&interrupted));
    let status = fs::read_to_string(home.path("parts/status.json")).unwrap();
    assert!(status.contains("\"interrupted\""), "{status}");

    let resumed = home.lateen(&["run", "case.toml", "--out", "parts", "--resume"]);
    assert_eq!(code(&resumed), 0, "{}", messages(&resumed));
    assert!(messages(&resumed).contains("resumed from"), "{}", messages(&resumed));
    assert_eq!(histories(&home.path("parts")), histories(&home.path("whole")));
}

/// A soft flap in a stream of water with automatic steps: a hundred of them, some milliseconds each.
const FLAP: &str = r#"
name = "flap"
method = "pfem2"
dimension = 2
[time]
end = "0.4 s"
[mesh]
shape = "box"
lower = ["0 m", "0 m"]
upper = ["1 m", "0.5 m"]
cell = "0.05 m"
[[body]]
name = "flap"
region = { shape = "box", lower = ["0.41 m", "0 m"], upper = ["0.52 m", "0.28 m"] }
material = { law = "neo-hookean", density = "1200 kg/m^3", young = "0.1 MPa", poisson = 0.3 }
mesh = { cell = "0.1 m" }
supports = [{ on = "bottom" }]
[[body]]
name = "water"
region = { shape = "box", lower = ["-1 m", "-1 m"], upper = ["2 m", "2 m"] }
material = { law = "newtonian", density = "1000 kg/m^3", viscosity = "1 Pa s" }
[[boundary]]
on = "left"
kind = "inlet"
velocity = ["0.5 m/s * sin(5*t/(1 s))", 0]
[[boundary]]
on = "right"
kind = "outlet"
[[boundary]]
on = "rest"
[output]
history = "10 ms"
[[probe]]
name = "top"
of = "flap"
reduce = "top"
"#;

/// The state of solids, subscales and of the length of steps goes through the file of a checkpoint, too, twice: after a
/// signal, and after a process that was killed within a step. (Takes long, as it runs the case several times with a
/// program that is hardly optimised.)
#[test]
#[cfg(unix)]
fn a_flow_with_a_solid_resumed_after_signals_leaves_the_same_bytes() {
    let home = Home::new(FLAP);
    let whole = home.lateen(&["run", "case.toml", "--out", "whole"]);
    assert_eq!(code(&whole), 0, "{}", messages(&whole));
    for (signal, threads) in [("-TERM", "1"), ("-KILL", "2")] {
        let run = &signal[1..];
        let often = ["--set", "output.checkpoint=1e-3", "--threads", threads];
        let mut command = home.command(&[&["run", "case.toml", "--out", run][..], &often[..]].concat());
        let mut child = command.stderr(Stdio::null()).stdout(Stdio::null()).spawn().unwrap();
        wait_for_rows(&home.path(run), &mut child);
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        let ended = child.wait().unwrap();
        assert_eq!(
            ended.code(),
            (signal == "-TERM").then_some(130),
            "{signal}: it ended before it could be interrupted"
        );
        let resumed = home.lateen(&["run", "case.toml", "--out", run, "--resume"]);
        assert_eq!(code(&resumed), 0, "{}", messages(&resumed));
        assert!(messages(&resumed).contains("resumed from"), "{}", messages(&resumed));
        assert_eq!(histories(&home.path(run)), histories(&home.path("whole")), "{signal}");
    }
}

#[test]
fn a_checkpoint_of_another_case_is_refused() {
    let home = Home::new(BLOCK);
    assert_eq!(code(&home.lateen(&["run", "case.toml", "--out", "a"])), 0);
    let other = home.lateen(&["run", "case.toml", "--out", "a", "--resume", "--set", "body.block.spacing=2 mm"]);
    assert_eq!(code(&other), 4, "{}", messages(&other));
    assert!(messages(&other).contains("checkpoint"), "{}", messages(&other));
}

#[test]
fn a_wrong_case_is_shown_with_its_line_and_creates_no_folder() {
    let home = Home::new(&BLOCK.replace("spacing", "spacin"));
    let output = home.lateen(&["run", "case.toml"]);
    assert_eq!(code(&output), 2);
    let text = messages(&output);
    assert!(text.contains("case.toml:16") && text.contains("spacing"), "{text}");
    assert!(!home.path("runs").exists());
}

#[test]
fn a_probe_of_an_unknown_part_is_a_case_error() {
    let home = Home::new(&BLOCK.replace("of = \"block\"", "of = \"blok\""));
    let output = home.lateen(&["run", "case.toml"]);
    assert_eq!(code(&output), 2);
    assert!(messages(&output).contains("`block`"), "{}", messages(&output));
}

#[test]
fn a_body_that_leaves_the_grid_stops_the_run_with_its_place() {
    let thrown = BLOCK.replace("spacing", "velocity = [0, \"50 m/s\"]\nspacing").replace("bottom = \"slip\"", "");
    let home = Home::new(&thrown);
    let output = home.lateen(&["run", "case.toml"]);
    assert_eq!(code(&output), 3, "{}", messages(&output));
    assert!(messages(&output).contains("help:") && messages(&output).contains("`block`"), "{}", messages(&output));
    let status = fs::read_to_string(home.path("runs/block/status.json")).unwrap();
    assert!(status.contains("\"failed\""), "{status}");
    assert!(home.path("runs/block/plots/top.svg").is_file(), "what was computed is plotted");
}

/// The last good state is reached by repeating steps from a checkpoint: it must equal, byte for byte, that of a run
/// that saves every step.
#[test]
fn a_failed_run_saves_and_shows_its_last_good_state() {
    let thrown = BLOCK.replace("spacing", "velocity = [0, \"50 m/s\"]\nspacing").replace("bottom = \"slip\"", "");
    let home = Home::new(&thrown);
    let newest = |run: &str| -> (String, Vec<u8>) {
        let files = fs::read_dir(home.path(run).join("checkpoint")).unwrap().map(|entry| entry.unwrap().path());
        let newest = files.max().unwrap();
        (newest.file_name().unwrap().to_string_lossy().into_owned(), fs::read(newest).unwrap())
    };
    assert_eq!(code(&home.lateen(&["run", "case.toml", "--out", "often", "--set", "output.checkpoint=1e-9"])), 3);
    let output = home.lateen(&["run", "case.toml", "--out", "once", "--set", "output.checkpoint=1 h"]);
    assert!(messages(&output).contains("saved"), "{}", messages(&output));
    assert_eq!(newest("once"), newest("often"));
    let top = fs::read_to_string(home.path("once/history/top.csv")).unwrap();
    let last: f64 = top.lines().last().unwrap().split(',').next().unwrap().parse().unwrap();
    let status: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(home.path("once/status.json")).unwrap()).unwrap();
    assert_eq!(status["time"].as_f64(), Some(last), "the state is shown, too");
}

#[test]
fn an_output_folder_that_can_not_be_written_is_an_output_error() {
    let home = Home::new(BLOCK);
    let output = home.lateen(&["run", "case.toml", "--out", "case.toml/run"]);
    assert_eq!(code(&output), 4);
    assert!(messages(&output).contains("can't write here"), "{}", messages(&output));
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_ends_the_run_and_leaves_whole_files() {
    let home = Home::new(BLOCK);
    // A limit on the size of files makes writes fail as a full disk does.
    let output = home.shell("trap '' XFSZ; ulimit -f 4; exec lateen run case.toml --out a").output().unwrap();
    assert_eq!(code(&output), 4, "{}", messages(&output));
    let mut folders = vec![home.path("a")];
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            let name = path.to_string_lossy().into_owned();
            assert!(!name.ends_with("partial") && !name.ends_with("tmp"), "{name} is half-written");
            if path.is_dir() {
                folders.push(path);
            } else if name.ends_with("csv") {
                assert!(fs::read_to_string(&path).unwrap().ends_with('\n'), "{name} ends within a row");
            }
        }
    }
}
