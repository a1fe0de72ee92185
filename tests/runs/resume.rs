//! Resuming runs: changed cases, missing histories, altered checkpoints.

use lateen::Error;
use lateen::case::{Case, Source};
use lateen::output::Checkpoints;
use lateen::run::{Existing, Options, RunDirectory, run};
use lateen::simulation::{CheckpointStore, Column, ColumnData, OF_OUTPUT, Plan, Simulation, Size};
use std::fs;
use std::path::Path;
use std::time::Duration;

const FLOW: &str = include_str!("../fixtures/two_fluids.toml");

const BALL: &str = r#"
name = "ball"
dimension = 2
[time]
end = "20 ms"
[grid]
cell = "20 mm"
lower = [0, 0]
upper = [0.4, 0.4]
walls = { bottom = "separate" }
[mpm]
gravity = [0, "-9.81 m/s^2"]
transfer = { kind = "apic" }
[[body]]
name = "ball"
region = { shape = "sphere", center = [0.2, 0.16], radius = 0.05 }
spacing = "10 mm"
velocity = [0, -2]
material = { law = "hypoelastic", density = 1000, young = 1e5, poisson = 0.3 }
[[membrane]]
name = "sheet"
geometry = { shape = "chain", points = [[0.05, 0.1], [0.35, 0.1]], divisions = [20] }
thickness = "1 mm"
material = { law = "elastic", density = 1000, young = 1e6, poisson = 0.3 }
supports = [{ on = "edges", velocity = [0, 0] }]
[output]
history = "2 ms"
[[probe]]
name = "top"
of = "ball"
reduce = "top"
"#;

fn case(text: &str) -> Case {
    Case::read(Source::new("case.toml", "", text), &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn go(text: &str, home: &Path, existing: Existing) -> Result<(), Error> {
    let case = case(text);
    run(&case, case.build()?, &RunDirectory::new(home), Options { existing, ..Options::default() }).map(|_| ())
}

fn told(text: &str, home: &Path) -> String {
    let error = go(text, home, Existing::Resume).unwrap_err();
    assert_eq!(error.exit_code(), 4, "{error}");
    error.to_string()
}

#[test]
fn resuming_a_changed_case_is_refused_with_the_changed_keys() {
    let home = tempfile::tempdir().unwrap();
    go(BALL, home.path(), Existing::Refuse).unwrap();
    let changed = BALL.replace("cell = \"20 mm\"", "cell = \"40 mm\"").replace("young = 1e5", "young = 2e5");
    let changed =
        changed.replace("walls = { bottom = \"separate\" }", "walls = { bottom = \"slip\", left = \"slip\" }");
    let told = told(&changed.replace("20 ms", "30 ms"), home.path());
    for part in [
        "`grid.cell` was 0.02, and is 0.04",
        "`grid.walls.bottom` was \"separate\", and is \"slip\"",
        "`grid.walls.left` was \"open\", and is \"slip\"",
        "`body[0].material.young` was 100000.0, and is 200000.0",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert!(!told.contains("time.end") && !told.contains("density"), "{told}");
    go(&BALL.replace("20 ms", "24 ms"), home.path(), Existing::Resume).expect("the end may be another");
}

/// Liquids have a column of pressures that doesn't exist before the first step.
#[test]
fn a_liquid_on_a_sheet_is_resumed() {
    let home = tempfile::tempdir().unwrap();
    let solid = "material = { law = \"hypoelastic\", density = 1000, young = 1e5, poisson = 0.3 }";
    let eos = "eos = { kind = \"tait\", sound-speed = 20 }";
    let liquid = format!("material = {{ law = \"fluid\", density = 1000, viscosity = 0.01, {eos} }}");
    let drop = BALL.replace(solid, &liquid).replace("transfer = { kind = \"apic\" }\n", "");
    assert!(drop.contains(&liquid));
    go(&drop, home.path(), Existing::Refuse).unwrap();
    go(&drop.replace("20 ms", "24 ms"), home.path(), Existing::Resume).unwrap();
}

#[test]
fn resuming_without_a_history_is_refused() {
    let home = tempfile::tempdir().unwrap();
    go(BALL, home.path(), Existing::Refuse).unwrap();
    let longer = BALL.replace("20 ms", "24 ms");
    let files: Vec<_> = fs::read_dir(home.path().join("history")).unwrap().map(|file| file.unwrap().path()).collect();
    assert!(files.len() > 3, "{files:?}");
    for path in files {
        let text = fs::read_to_string(&path).unwrap();
        fs::remove_file(&path).unwrap();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let missed = told(&longer, home.path());
        assert!(missed.contains(&name) && missed.contains("--force"), "{missed}");
        fs::write(&path, "").unwrap();
        assert!(told(&longer, home.path()).contains(&name));
        fs::write(&path, text).unwrap();
    }
    let another = "[[probe]]\nname = \"bottom\"\nof = \"ball\"\nreduce = \"bottom\"\n";
    let more = format!("{longer}{another}");
    go(&more, home.path(), Existing::Resume).expect("a history that was not asked for before begins now");
    fs::remove_file(home.path().join("history/bottom.csv")).unwrap();
    assert!(told(&more.replace("24 ms", "28 ms"), home.path()).contains("bottom.csv"));
}

#[test]
fn resuming_before_the_first_checkpoint_begins_anew() {
    let home = tempfile::tempdir().unwrap();
    drop(RunDirectory::new(home.path()).prepare(Existing::Refuse).unwrap());
    go(BALL, home.path(), Existing::Resume).expect("killed before its first checkpoint");
    assert_eq!(fs::read_to_string(home.path().join("case.toml")).unwrap(), BALL);
    fs::remove_file(home.path().join("case.toml")).unwrap();
    go(&BALL.replace("20 ms", "22 ms"), home.path(), Existing::Resume).unwrap();
    assert!(home.path().join("case.toml").is_file());
}

/// A column of any kind, byte by byte.
#[derive(Clone)]
struct Raw {
    kind: &'static str,
    number: usize,
    bytes: Vec<u8>,
}

impl ColumnData for Raw {
    fn kind(&self) -> &'static str {
        self.kind
    }

    fn number_size(&self) -> usize {
        self.number
    }

    fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn replace(&mut self, bytes: &[u8]) -> bool {
        self.bytes = bytes.to_vec();
        true
    }
}

/// All columns of the newest checkpoint of a run.
#[derive(Clone)]
struct State {
    columns: Vec<(String, usize, Raw)>,
}

impl State {
    fn visit(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        for (name, components, data) in &mut self.columns {
            visit(name, Column { components: *components, size: Size::Free, data });
        }
    }

    /// Reads what a run of a case has left.
    fn read(text: &str, home: &Path) -> Self {
        let mut columns = Vec::new();
        let mut note = |name: &str, column: Column<'_>| {
            let (kind, number) = (column.data.kind(), column.data.number_size());
            columns.push((name.to_owned(), column.components, Raw { kind, number, bytes: Vec::new() }));
        };
        let mut reals = vec![0.0; 3];
        note("loop/time, dt, stored energy", Column::record(&mut [0.0; 3]));
        note("loop/step", Column::scalar(&mut 0_u64));
        note("loop/impulses", Column::new(&mut reals));
        note("loop/time of impulses", Column::new(&mut reals));
        case(text).build().unwrap().columns(&mut note);
        let mut state = Self { columns };
        let mut store = Checkpoints::new(home.join("checkpoint"), case(text).hash());
        store.restore(&mut |visit| state.visit(visit)).unwrap().expect("a checkpoint");
        state
    }

    /// Writes it as a checkpoint into a folder.
    fn write(&mut self, text: &str, checkpoints: &Path) {
        let mut store = Checkpoints::new(checkpoints.to_owned(), case(text).hash());
        store.save(999_999, 1.0, &mut |visit| self.visit(visit)).unwrap();
    }
}

/// Columns of a checkpoint: name, place in the file, contents.
type RawColumns = Vec<(String, usize, Raw)>;

/// Goes on from the newest checkpoint in a folder to the end of a case, without outputs.
fn go_on(text: &str, checkpoints: &Path) -> Result<(), Error> {
    let case = case(text);
    let plan = Plan { end: case.file.time.end, step: case.file.time.step, checkpoint_every: Duration::MAX };
    let mut simulation = Simulation::new(case.build()?, plan);
    simulation.keep_checkpoints(Box::new(Checkpoints::new(checkpoints.to_owned(), case.hash())));
    assert!(simulation.resume()?, "a checkpoint");
    simulation.run().map(|_| ())
}

/// Checkpoints with valid checksums and wrong contents: each column in turn is missing, of another type, cut, full of
/// ones or empty, and one is added. Columns that are missing, cut or of another type are refused; nothing panics.
fn altered_columns_are_refused(text: &str, longer: &str) {
    let home = tempfile::tempdir().unwrap();
    go(text, home.path(), Existing::Refuse).unwrap();
    let honest = State::read(text, home.path());
    let forge = |edit: &dyn Fn(&mut RawColumns)| {
        let folder = tempfile::tempdir().unwrap();
        let mut state = honest.clone();
        edit(&mut state.columns);
        state.write(text, folder.path());
        go_on(longer, folder.path())
    };
    forge(&|_| {}).expect("an honest copy goes on");
    let mut taken = Vec::new();
    for (n, (name, _, data)) in honest.columns.iter().enumerate() {
        let mut refuse = |what: &str, edit: &dyn Fn(&mut RawColumns)| match forge(edit) {
            Ok(()) => taken.push(format!("{name}, {what}")),
            Err(error) => assert!(matches!(error, Error::Checkpoint { .. }), "{name}, {what}: {error}"),
        };
        refuse("gone", &|columns| drop(columns.remove(n)));
        refuse("of another kind", &|columns| columns[n].2.kind = if columns[n].2.kind == "u8" { "i8" } else { "u8" });
        // A column of free size can't have a wrong one.
        if !(data.bytes.is_empty() || name.starts_with("loop/") || name.contains("side:")) {
            refuse("cut", &|columns| {
                let (_, components, data) = &mut columns[n];
                data.bytes.truncate(data.bytes.len() - *components * data.number);
            });
        }
        // Any outcome but a panic is right: the values themselves can't be checked.
        let _ = forge(&|columns| columns[n].2.bytes.fill(0xff));
        let _ = forge(&|columns| columns[n].2.bytes.clear());
    }
    assert!(taken.is_empty(), "{taken:?}");
    let error = forge(&|columns| {
        let bytes = vec![0; 8];
        columns.push(("more".to_owned(), 1, Raw { kind: "f64", number: 8, bytes }));
    });
    assert!(error.unwrap_err().to_string().contains("a column `more`, which this model does not have"));
    let probe = || (format!("{OF_OUTPUT}probe/x"), 1, Raw { kind: "f64", number: 8, bytes: vec![0; 8] });
    forge(&|columns| columns.push(probe())).expect("outputs may change");
}

/// (Takes long: each column is altered in up to five ways, and a run goes on from each.)
#[test]
fn altered_columns_of_a_checkpoint_of_material_points_are_refused() {
    let rarely = BALL.replace("history = \"2 ms\"", "history = \"2 ms\"\nfields = \"1 s\"");
    altered_columns_are_refused(&rarely, &rarely.replace("20 ms", "21 ms"));
}

/// (Takes long, as that of material points.)
#[test]
fn altered_columns_of_a_checkpoint_of_a_flow_are_refused() {
    let small = FLOW.replace("cell = \"0.1 m\"", "cell = \"0.25 m\"").replace("0.4 s", "0.04 s");
    let small = small.replace("fields = \"0.2 s\"", "fields = \"1 s\"");
    altered_columns_are_refused(&small, &small.replace("end = \"0.04 s\"", "end = \"0.06 s\""));
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_as_checkpoints_and_tables() {
    let home = tempfile::tempdir().unwrap();
    go(BALL, home.path(), Existing::Refuse).unwrap();
    let pipe = home.path().join("checkpoint/step-000999999999.checkpoint");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    go(&BALL.replace("20 ms", "22 ms"), home.path(), Existing::Resume).expect("the older one is used");
    let table = BALL.replace("velocity = [0, -2]\n", "velocity = [0, -2]\n# table\n");
    for device in ["/dev/zero", pipe.with_extension("damaged").to_str().unwrap()] {
        let table = table
            .replace("# table", &format!("traction = [{{ on = \"top\", pressure = {{ table = \"{device}\" }} }}]"));
        let error = Case::read(Source::new("case.toml", "", table), &[]).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("pipe or a device"), "{error}");
    }
}
