//! Effects of the environment on a run: signals, closed pipes, limits of memory and file size, folders that no run
//! made.
#![cfg(target_os = "linux")]

use super::home::{Home, messages};
use std::fs::{self, File};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// An elastic block that falls in the plane.
const BLOCK: &str = r#"
name = "block"
dimension = 2
[time]
end = "20 ms"
[grid]
cell = "10 mm"
lower = ["0 mm", "0 mm"]
upper = ["200 mm", "200 mm"]
[mpm]
gravity = [0, "-9.81 m/s^2"]
[[body]]
name = "block"
region = { shape = "box", lower = ["50 mm", "50 mm"], upper = ["150 mm", "150 mm"] }
spacing = "5 mm"
material = { law = "hypoelastic", density = "1000 kg/m^3", young = "10 MPa", poisson = 0.3 }
[output]
history = "1 ms"
fields = "10 ms"
"#;

/// The block without gravity, for as long as it takes.
fn still(end: &str) -> String {
    BLOCK.replace("20 ms", end).replace("-9.81 m/s^2", "0 m/s^2").replace("history = \"1 ms\"", "history = \"0.1 ms\"")
}

impl Home {
    fn state(&self, run: &str) -> String {
        let status = fs::read_to_string(self.path(run).join("status.json")).unwrap();
        let status: serde_json::Value = serde_json::from_str(&status).unwrap();
        status["state"].as_str().unwrap().to_owned()
    }

    /// Waits until a run has written a row of its balance.
    fn wait_for_rows(&self, run: &str, child: &mut Child) {
        let (start, path) = (Instant::now(), self.path(run).join("history/balance.csv"));
        let rows = || fs::read_to_string(&path).map_or(0, |text| text.lines().count());
        while rows() < 3 && start.elapsed() < Duration::from_secs(60) {
            assert!(child.try_wait().unwrap().is_none(), "the run ended before its time");
            sleep(Duration::from_millis(5));
        }
    }
}

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn send(signal: &str, child: &Child) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn a_run_survives_a_full_or_closed_standard_error() {
    let home = Home::new(BLOCK);
    let full = || Stdio::from(File::options().write(true).open("/dev/full").unwrap());
    let outcome = home.command(&["run", "case.toml", "--out", "full"]).stderr(full()).output().unwrap();
    assert_eq!((outcome.status.code(), home.state("full").as_str()), (Some(0), "done"));
    let piped =
        home.shell("lateen run case.toml --out piped 2>&1 | head -c 1; exit ${PIPESTATUS[0]}").output().unwrap();
    assert_eq!((piped.status.code(), home.state("piped").as_str()), (Some(0), "done"));
    // An error keeps its code.
    let wrong = home.command(&["run", "case.toml", "--set", "grid.cell=-1"]).stderr(full()).status().unwrap();
    assert_eq!(wrong.code(), Some(2));
    let lost = home.command(&["run", "case.toml", "--out", "lost"]).stdout(full()).output().unwrap();
    assert_eq!((lost.status.code(), home.state("lost").as_str()), (Some(4), "done"), "{}", messages(&lost));
    assert!(messages(&lost).contains("standard output"), "{}", messages(&lost));
}

#[test]
fn signals_end_a_run_after_the_current_step_with_a_checkpoint() {
    let home = Home::new(&still("1000 s"));
    for signal in ["-HUP", "-QUIT", "-INT", "-TERM"] {
        let run = &signal[1..];
        let mut command = home.command(&["run", "case.toml", "--out", run]);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        home.wait_for_rows(run, &mut child);
        send(signal, &child);
        let ended = child.wait_with_output().unwrap();
        assert_eq!((ended.status.code(), home.state(run).as_str()), (Some(130), "interrupted"), "{signal}");
        assert!(messages(&ended).contains("--resume"), "{}", messages(&ended));
    }
}

#[test]
fn an_ignored_hangup_signal_stays_ignored() {
    let home = Home::new(&still("100 ms"));
    let mut command = home.shell("trap '' HUP; exec lateen run case.toml --out a");
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    home.wait_for_rows("a", &mut child);
    send("-HUP", &child);
    assert_eq!((child.wait().unwrap().code(), home.state("a").as_str()), (Some(0), "done"));
}

#[test]
fn a_second_signal_ends_a_run_at_once() {
    // Steps that take long: the first signal waits for the end of one, the second doesn't.
    let case = BLOCK.replace("\"5 mm\"", "\"0.1 mm\"").replace("[output]", "[output]\ncheckpoint = \"1 h\"");
    let home = Home::new(&case);
    for (first, second) in [("-TERM", "-TERM"), ("-HUP", "-QUIT")] {
        let (run, start) = (&second[1..], Instant::now());
        let arguments = ["run", "case.toml", "--threads", "1", "--out", run];
        let mut child = home.command(&arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let saved =
            || fs::read_to_string(home.path(run).join("status.json")).is_ok_and(|s| s.contains(".checkpoint\""));
        while !saved() && start.elapsed() < Duration::from_secs(120) {
            sleep(Duration::from_millis(5));
        }
        send(first, &child);
        sleep(Duration::from_millis(20));
        send(second, &child);
        assert_eq!((child.wait().unwrap().code(), home.state(run).as_str()), (Some(130), "running"), "{second}");
    }
}

#[test]
fn a_limit_on_the_size_of_files_is_an_error_that_names_it() {
    let home = Home::new(BLOCK);
    let output = home.shell("ulimit -f 4; exec lateen run case.toml --out a").output().unwrap();
    assert_eq!(output.status.code(), Some(4), "{}", messages(&output));
    assert!(messages(&output).contains("ulimit -f"), "{}", messages(&output));
    assert_eq!(home.state("a"), "failed");
}

#[test]
fn a_failed_run_prints_the_times_of_its_stages() {
    let home = Home::new(&BLOCK.replace("spacing", "velocity = [0, \"50 m/s\"]\nspacing"));
    let output = home.command(&["run", "case.toml"]).output().unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", messages(&output));
    let text = printed(&output);
    assert!(
        text.starts_with("stopped: t = ")
            && text.contains("%")
            && text.contains("  outputs\n")
            && text.contains("  the rest\n"),
        "{text}"
    );
}

#[test]
fn force_refuses_a_folder_that_no_run_made() {
    let home = Home::new(BLOCK);
    fs::create_dir(home.path("reference")).unwrap();
    fs::write(home.path("reference/measured.csv"), "mine").unwrap();
    let output = home.command(&["run", "case.toml", "--out", ".", "--force"]).output().unwrap();
    assert_eq!(output.status.code(), Some(4), "{}", messages(&output));
    assert!(messages(&output).contains("no run of lateen made"), "{}", messages(&output));
    assert_eq!(fs::read_to_string(home.path("case.toml")).unwrap(), BLOCK);
    assert_eq!(fs::read_to_string(home.path("reference/measured.csv")).unwrap(), "mine");
}

#[test]
fn force_keeps_files_of_the_user_among_the_results() {
    let home = Home::new(BLOCK);
    let run = |more: &[&str]| {
        let output = home.command(&[&["run", "case.toml", "--out", "a"][..], more].concat()).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", messages(&output));
    };
    run(&[]);
    fs::write(home.path("a/plots/mine.svg"), "mine").unwrap();
    fs::write(home.path("a/history/measured.csv"), "time [s],u [m]\n0,0\n").unwrap();
    fs::write(home.path("a/fields/block/old.vtp"), "mine").unwrap();
    let frames = || fs::read_dir(home.path("a/fields/block")).unwrap().count();
    assert_eq!(frames(), 4, "three frames and one of the user's");
    run(&["--force", "--set", "output.fields=20 ms"]);
    assert_eq!(frames(), 3, "the frames of before are gone");
    for mine in ["plots/mine.svg", "history/measured.csv", "fields/block/old.vtp"] {
        assert!(home.path("a").join(mine).is_file(), "{mine} is gone");
    }
}

/// A limit on the address space stands for a machine with little memory.
const LITTLE: &str = "export RAYON_NUM_THREADS=2; ulimit -v 4000000; exec lateen check";

#[test]
fn memory_follows_the_material_and_not_the_size_of_the_grid() {
    let home = Home::new(BLOCK);
    for set in ["hertz --set grid.upper.0=1e6", "dam-break --set grid.upper='[2000, 500, 1000]'"] {
        let output = home.shell(&format!("{LITTLE} {set}")).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{set}: {}", messages(&output));
        assert!(messages(&output).contains("the grid is"), "{set}: {}", messages(&output));
    }
    let sphere = home.shell(&format!("{LITTLE} water-sphere --set grid.upper.2=1000")).output().unwrap();
    assert!(messages(&sphere).contains("is the unit right?"), "{}", messages(&sphere));
    // The end of the grid is no part of what is stored.
    let stored = |more: &str| {
        let output = home.shell(&format!("{LITTLE} water-sphere {more}")).output().unwrap();
        printed(&output).lines().find(|line| line.starts_with("memory")).map(str::to_owned)
    };
    assert_eq!(stored("--set grid.upper.2=1000"), stored(""));
}

#[test]
fn a_model_that_exceeds_the_memory_is_refused_before_it_is_allocated() {
    let home = Home::new(BLOCK);
    for (set, key) in [("dam-break --set grid.cell=0.0025", "`spacing`"), ("cavity --set mesh.cell=2.5e-4", "`cell`")] {
        let output = home.shell(&format!("{LITTLE} {set}")).output().unwrap();
        let text = messages(&output);
        assert_eq!(output.status.code(), Some(2), "{set}: {text}");
        assert!(text.contains("of memory") && text.contains(key) && text.contains("right?"), "{text}");
    }
}
