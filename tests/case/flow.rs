//! Cases of PFEM-2: sizes, errors, files of a run, reproducibility.

use super::findings::{edited, expect_error, good, model};
use lateen::Error;
use lateen::case::{Case, Source};
use lateen::run::{Existing, Folder, Options, RunDirectory, run};
use lateen::simulation::{Event, Observer, Progress};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

const GOOD: &str = include_str!("../fixtures/two_fluids.toml");

/// Expects one finding at the place of `at` after replacing `from` by `to`.
#[track_caller]
fn expect(from: &str, to: &str, at: &str, message: &str, help: &str) {
    expect_error(&edited(GOOD, from, to), at, message, help);
}

#[test]
fn a_box_of_two_fluids_has_its_elements_unknowns_and_volumes() {
    let summary = good(GOOD).summary;
    assert_eq!((summary.cells, summary.nodes, summary.unknowns), (200.0, 121, 363));
    assert_eq!(summary.domain, [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
    // The plane leaves 0.47 below it on average.
    assert!((summary.bodies[0].volume - 0.47).abs() < 0.01, "{}", summary.bodies[0].volume);
    assert!((summary.bodies[0].volume + summary.bodies[1].volume - 1.0).abs() < 1e-12);
    assert!(summary.to_string().contains("pressure: zero at the highest node"), "{summary}");
    assert_eq!(summary.steps, 20.0);
}

#[test]
fn presets_fill_open_keys_and_a_resolved_case_reads_back_to_itself() {
    let paper = GOOD.replace("method =", "preset = \"becker-2015\"\nmethod =");
    let resolved = |text: &str| Case::read(Source::new("case.toml", "", text), &[]).unwrap().resolved_toml();
    for line in
        ["kind = \"backward-euler\"", "stabilisation = \"pspg\"", "kernel = \"shape\"", "interface = \"pseudo\""]
    {
        assert!(resolved(&paper).contains(line) && !resolved(GOOD).contains(line), "{line}");
    }
    assert!(resolved(GOOD).contains("stabilisation = \"oss\"") && !resolved(GOOD).contains("[mpm]"));
    // A resolved case resolves to itself.
    assert_eq!(resolved(&resolved(GOOD)), resolved(GOOD));
}

#[test]
fn the_default_history_has_fifty_rows_when_the_step_is_automatic() {
    let rows = |text: &str| {
        let case = Case::read(Source::new("case.toml", "", text), &[]).unwrap();
        (case.file.time.end / case.file.output.history.unwrap()).round()
    };
    let step = GOOD.lines().find(|line| line.starts_with("step")).expect("a fixed step");
    let history = GOOD.lines().find(|line| line.starts_with("history")).unwrap_or("no such line");
    assert_eq!(rows(&GOOD.replace(step, "").replace(history, "")), 50.0);
}

#[test]
fn keys_and_laws_of_the_other_method_are_errors() {
    expect("[pfem2]\n", "[mpm]\nsafety = 0.2\n[pfem2]\n", "[mpm]", "`mpm` does not belong", "");
    expect("name = \"oil\"", "name = \"oil\"\nspacing = \"1 mm\"", "\"1 mm\"", "does not belong", "");
    expect("method =", "preset = \"lian-2014\"\nmethod =", "\"lian-2014\"", "for `method = \"mpm\"`", "leave it out");
    let mpm = "law = \"hypoelastic\", density = \"800 kg/m^3\", young = \"1 MPa\", poisson = 0.3";
    let oil = "law = \"newtonian\", density = \"800 kg/m^3\", viscosity = \"0.01 Pa s\"";
    expect(oil, mpm, "", "is for `method = \"mpm\"`", "newtonian");
}

#[test]
fn every_part_of_the_boundary_needs_exactly_one_condition() {
    expect("[\"left\", \"right\"]", "[\"left\"]", "", "nothing is prescribed on `right`", "rest");
    expect("[\"left\", \"right\"]", "[\"left\", \"rigth\", \"right\"]", "[\"left\"", "no part `rigth`", "`right`");
    expect("[\"bottom\", \"top\"]", "[\"bottom\", \"top\", \"left\"]", "[\"bottom\"", "already has a condition", "");
    expect("kind = \"slip\"", "kind = \"slip\"\npressure = \"1 Pa\"", "\"1 Pa\"", "says nothing", "change `kind`");
    expect("kind = \"slip\"", "kind = \"slyp\"", "\"slyp\"", "unknown name", "`slip`");
    good(&GOOD.replace("[\"bottom\", \"top\"]", "\"rest\""));
}

#[test]
fn shifting_a_pseudo_level_set_is_an_error() {
    let both = "[pfem2]\ninterface = \"pseudo\"\nvolume = \"shift\"";
    expect("[pfem2]", both, "\"shift\"", "can't be shifted", "volume = \"none\"");
    let pseudo = GOOD.replace("[pfem2]", "[pfem2]\ninterface = \"pseudo\"");
    let resolved = Case::read(Source::new("case.toml", "", pseudo), &[]).unwrap().resolved_toml();
    assert!(resolved.contains("volume = \"none\""), "{resolved}");
}

#[test]
fn the_pressure_of_a_closed_box_is_pinned_where_the_case_says() {
    let pinned = GOOD.replace("[pfem2]", "[pfem2]\npressure-pin = { at = [\"0.5 m\", 0.5], value = \"1 bar\" }");
    assert!(good(&pinned).summary.to_string().contains("held at the node nearest to (0.5, 0.5)"));
    expect("[pfem2]", "[pfem2]\npressure-pin = { at = [2, 0] }", "[2, 0]", "not in the mesh", "nearest");
    expect("[pfem2]", "[pfem2]\npressure-pin = { at = [0, 0], value = \"1/t\" }", "\"1/t\"", "inf", "divides by zero");
    let open = pinned.replace("[\"left\", \"right\"]\nkind = \"slip\"", "[\"left\", \"right\"]\nkind = \"outlet\"");
    let found = model(&open, Path::new("")).map(|_| ()).unwrap_err();
    assert!(found.len() == 1 && found[0].message.contains("already says"), "{found:?}");
}

#[test]
fn an_inlet_without_an_opening_is_an_error() {
    let inlet = "kind = \"inlet\"\nvelocity = [\"ramp(t, 0.1 s) * 1 m/s\", 0]";
    let text = GOOD.replace("[\"left\", \"right\"]\nkind = \"slip\"", &format!("\"left\"\n{inlet}"));
    let closed = format!("{text}\n[[boundary]]\non = \"right\"\n");
    let found = model(&closed, Path::new("")).map(|_| ()).unwrap_err();
    assert!(found.len() == 1 && found[0].message.contains("nothing lets them out"), "{found:?}");
    let open = good(&format!("{text}\n[[boundary]]\non = \"right\"\nkind = \"outlet\"\n"));
    assert!(!open.summary.to_string().contains("pressure: zero"));
}

#[test]
fn fluids_must_fill_the_mesh_and_have_particles() {
    expect("upper = [\"2 m\", \"2 m\"]", "upper = [\"2 m\", \"0.8 m\"]", "", "elements lie in no body", "listed later");
    let under = "[[body]]\nname = \"oil\"";
    let hidden = "[[body]]\nname = \"drop\"\nregion = { shape = \"sphere\", center = [0.5, 0.1], radius = 0.05 }\n\
                  material = { law = \"newtonian\", density = 900.0 }\n[[body]]\nname = \"oil\"";
    expect(under, hidden, "{ shape = \"sphere\"", "no particles", "listed before it");
}

#[test]
fn boxes_without_extent_and_inverted_elements_are_errors() {
    expect("upper = [\"1 m\", \"1 m\"]", "upper = [\"1 m\", \"-1 m\"]", "[\"1 m\", \"-1 m\"]", "no extent along y", "");
    let home = tempfile::tempdir().unwrap();
    let inverted = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n$EndNodes\n\
                    $Elements\n2\n1 2 2 1 1 1 2 3\n2 2 2 1 1 2 3 4\n$EndElements\n";
    std::fs::write(home.path().join("bad.msh"), inverted).unwrap();
    let start = GOOD.find("shape = \"box\"\nlower").unwrap();
    let end = GOOD.find("[pfem2]").unwrap();
    let text = format!("{}shape = \"file\"\npath = \"bad.msh\"\n{}", &GOOD[..start], &GOOD[end..]);
    let found = model(&text, home.path()).map(|_| ()).unwrap_err();
    assert!(found.len() == 1 && found[0].message.contains("element 2"), "{found:?}");
    assert!(found[0].message.contains("inverted"), "{found:?}");
}

/// Histories of a run, by name.
fn histories(directory: &Path) -> Vec<(String, String)> {
    let files = std::fs::read_dir(directory.join("history")).unwrap().map(|entry| entry.unwrap().path());
    let csv = files.filter(|path| path.extension().is_some_and(|e| e == "csv"));
    let mut all: Vec<(String, String)> = csv
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read_to_string(path).unwrap()))
        .collect();
    all.sort();
    all
}

fn run_whole(text: &str, directory: &Path) {
    let case = Case::read(Source::new("case.toml", "", text), &[]).unwrap();
    let solver = case.build().unwrap();
    run(&case, solver, &RunDirectory::new(directory), Options::default()).unwrap();
}

#[test]
fn a_run_writes_histories_fields_and_pictures() {
    let home = tempfile::tempdir().unwrap();
    let pictures = "\n[[picture]]\nname = \"flow\"\nof = [\"mesh\"]\nfield = \"velocity\"\nevery = \"0.2 s\"\n";
    run_whole(&format!("{GOOD}{pictures}"), home.path());
    let histories = histories(home.path());
    let text = |name: &str| &histories.iter().find(|(file, _)| file == name).expect(name).1;
    assert!(text("balance.csv").lines().next().unwrap().contains("volume: water"), "{}", text("balance.csv"));
    let counts = text("counts.csv");
    assert!(counts.contains("solver: iterations") && counts.contains("particles"), "{counts}");
    assert_eq!(counts.lines().count(), 12);
    let written = |folder: &str, end: &str| {
        let files = std::fs::read_dir(home.path().join(folder)).unwrap().map(|f| f.unwrap().path());
        files.filter(|f| f.to_string_lossy().ends_with(end)).count()
    };
    assert_eq!(written("fields", ".pvd"), 4, "particles of both fluids, the mesh, the interface");
    assert_eq!(written("pictures/flow", ".png"), 3, "at 0, 0.2 and 0.4 s");
}

#[test]
fn results_are_the_same_bits_for_any_number_of_threads() {
    let runs = [1, 3].map(|threads| {
        let home = tempfile::tempdir().unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run_whole(GOOD, home.path()));
        histories(home.path())
    });
    assert!(runs[0] == runs[1]);
}

#[test]
fn a_resumed_run_repeats_the_uninterrupted_one_bit_for_bit() {
    struct StopAt(f64, Arc<AtomicBool>);
    impl Observer for StopAt {
        fn event(&mut self, _: &Event<'_>, progress: &Progress) -> lateen::Result<()> {
            if progress.clock.time > self.0 {
                self.1.store(true, Ordering::Relaxed);
            }
            Ok(())
        }
    }
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    run_whole(GOOD, whole.path());
    let case = Case::read(Source::new("case.toml", "", GOOD), &[]).unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let options = Options { observers: vec![Box::new(StopAt(0.15, stop.clone()))], stop, ..Options::default() };
    let interrupted = run(&case, case.build().unwrap(), &RunDirectory::new(parts.path()), options);
    assert!(matches!(interrupted, Err(Error::Interrupted)));
    let options = Options { existing: Existing::Resume, ..Options::default() };
    run(&case, case.build().unwrap(), &RunDirectory::new(parts.path()), options).unwrap();
    for ((name, whole), (_, parts)) in histories(whole.path()).iter().zip(&histories(parts.path())) {
        let differing = whole.lines().zip(parts.lines()).find(|(a, b)| a != b);
        assert!(whole == parts, "{name}: {differing:?}");
    }
}

/// Decaying vortices (Taylor & Green) lose 1 − exp(−4π²νt) of their energy 1 to viscosity; the first step, whose
/// explicit part of the forces is that of the initial state, is no exception.
#[test]
fn viscous_dissipation_of_the_first_step_is_that_of_decaying_vortices() {
    let set = [("time.end", "0.05"), ("mesh.cell", "0.0625")].map(|(key, value)| (key.to_owned(), value.to_owned()));
    let case = Folder::open("taylor-green").unwrap().read(&set).unwrap();
    let home = tempfile::tempdir().unwrap();
    run(&case, case.build().unwrap(), &RunDirectory::new(home.path()), Options::default()).unwrap();
    let text = std::fs::read_to_string(home.path().join("history/balance.csv")).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let column = rows[0].iter().position(|head| *head == "viscous dissipation").unwrap();
    for row in &rows[2..] {
        let [time, lost] = [0, column].map(|c| row[c].parse::<f64>().unwrap());
        let exact = 1.0 - (-4.0 * std::f64::consts::PI.powi(2) * 0.01 * time).exp();
        assert!((lost / exact - 1.0).abs() < 0.05, "t = {time}: {lost} instead of {exact}");
    }
}

#[test]
fn resuming_with_another_quantity_of_a_probe_is_refused() {
    let home = tempfile::tempdir().unwrap();
    let probe = "\n[[probe]]\nname = \"mid\"\nof = \"mesh\"\nat = [0.5, 0.5]\nquantity = ";
    let text = |quantity: &str, end: &str| format!("{GOOD}{probe}\"{quantity}\"\n").replace("end = \"0.4 s\"", end);
    let start = |text: &str, existing: Existing| {
        let case = Case::read(Source::new("case.toml", "", text), &[]).unwrap();
        run(&case, case.build().unwrap(), &RunDirectory::new(home.path()), Options { existing, ..Options::default() })
    };
    start(&text("pressure", "end = \"0.1 s\""), Existing::Refuse).unwrap();
    let before = std::fs::read_to_string(home.path().join("history/mid.csv")).unwrap();
    let error = start(&text("velocity", "end = \"0.2 s\""), Existing::Resume).unwrap_err();
    assert!(error.to_string().contains("give what is measured another name"), "{error}");
    assert_eq!(std::fs::read_to_string(home.path().join("history/mid.csv")).unwrap(), before);
}

#[test]
fn resuming_without_checkpoints_is_refused() {
    let home = tempfile::tempdir().unwrap();
    let case = Case::read(Source::new("case.toml", "", GOOD), &[("time.end".into(), "0.1 s".into())]).unwrap();
    let start = |existing: Existing| {
        run(&case, case.build().unwrap(), &RunDirectory::new(home.path()), Options { existing, ..Options::default() })
    };
    start(Existing::Refuse).unwrap();
    std::fs::remove_dir_all(home.path().join("checkpoint")).unwrap();
    let before = std::fs::read(home.path().join("history/balance.csv")).unwrap();
    let error = start(Existing::Resume).unwrap_err();
    assert!(error.to_string().contains("the checkpoints of this run are gone"), "{error}");
    assert_eq!(std::fs::read(home.path().join("history/balance.csv")).unwrap(), before);
}
