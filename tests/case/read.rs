//! Reading cases: units, presets, overrides, defaults.

use lateen::case::{Case, FrictionSpec, KernelSpec, LockingSpec, SignalSpec, Source, TransferSpec};

/// The water sphere of Lian, Liu & Zhang (2014), section 7.2, in the paper's mm, ms, MPa, g.
const WATER_SPHERE: &str = include_str!("../fixtures/water_sphere.toml");

fn read(text: &str, overrides: &[(&str, &str)]) -> Case {
    let overrides: Vec<_> = overrides.iter().map(|(k, v)| (k.to_string(), v.to_string())).collect();
    let source = Source::new("case.toml", "", text);
    Case::read(source.clone(), &overrides).unwrap_or_else(|error| match error {
        lateen::Error::Case(findings) => panic!("{}", source.render(&findings, false)),
        other => panic!("{other}"),
    })
}

#[test]
fn units_are_converted_to_si() {
    let file = read(WATER_SPHERE, &[]).file;
    assert_eq!(file.time.end, 1.2e-3);
    assert_eq!(file.grid.as_ref().unwrap().cell, 1e-3);
    assert_eq!(file.grid.as_ref().unwrap().lower, [-27e-3, -27e-3, -12e-3]);
    assert_eq!(file.mpm.gravity[2], SignalSpec::Number(-9.81));
    assert_eq!(file.body[0].spacing, Some(0.5e-3));
    assert_eq!(file.body[0].velocity[2], SignalSpec::Number(-10.0));
    assert_eq!(file.membrane[0].thickness, 1e-4);
    assert_eq!(file.contact[0].friction, FrictionSpec::Coefficient(0.2));
}

#[test]
fn presets_fill_open_keys_and_explicit_keys_win() {
    let recommended = read(WATER_SPHERE, &[]).file.mpm;
    assert_eq!(recommended.kernel, KernelSpec::Quadratic);
    assert_eq!(recommended.transfer, TransferSpec::Apic);
    assert_eq!(recommended.locking, LockingSpec::Average { blend: 1.0 });
    let paper = read(WATER_SPHERE, &[("preset", "lian-2014"), ("mpm.kernel", "gimp")]).file.mpm;
    assert_eq!(paper.kernel, KernelSpec::Gimp, "explicit keys win");
    assert_eq!(paper.locking, LockingSpec::None);
    assert_eq!(paper.max_substeps, 1);
    assert!(matches!(paper.transfer, TransferSpec::Flip { relaxation: f64::INFINITY, filter_order: 0, .. }));
}

/// A key of a table leaves the others to the preset, unless its kind is another.
#[test]
fn a_key_of_the_transfer_leaves_the_others_to_the_preset() {
    let gas = [("body[0].material.eos", "{ kind = \"ideal-gas\", gamma = 1.4 }"), ("body[0].pressure", "1 bar")];
    let transfer = |value| read(WATER_SPHERE, &[gas[0], gas[1], ("mpm.transfer", value)]).file.mpm.transfer;
    let filtered =
        |filter_order, filter_interval| TransferSpec::Flip { relaxation: f64::INFINITY, filter_order, filter_interval };
    assert_eq!(transfer("{ kind = \"flip\", filter-interval = 7 }"), filtered(2, 7));
    assert_eq!(transfer("{ kind = \"flip\", filter-order = 0 }"), filtered(0, 20));
    assert_eq!(transfer("{ kind = \"apic\" }"), TransferSpec::Apic);
}

#[test]
fn overrides_reach_every_key_by_index_or_name() {
    let case = read(
        WATER_SPHERE,
        &[
            ("time.end", "2 ms"),
            ("body[0].spacing", "0.25 mm"),
            ("membrane.sheet.thickness", "0.2 mm"),
            ("body.water.velocity", "[0, 0, \"-20 mm/ms\"]"),
            ("time.step", "1e-8"),
        ],
    );
    assert_eq!(case.file.time.end, 2e-3);
    assert_eq!(case.file.time.step, Some(1e-8));
    assert_eq!(case.file.body[0].spacing, Some(0.25e-3));
    assert_eq!(case.file.membrane[0].thickness, 2e-4);
    assert_eq!(case.file.body[0].velocity[2], SignalSpec::Number(-20.0));
}

#[test]
fn the_resolved_case_reads_back_to_itself() {
    let case = read(WATER_SPHERE, &[("mpm.gravity", "[0, \"1 m/s^2 * sin(t / 1 ms)\", 0]")]);
    let resolved = case.resolved_toml();
    let again = read(&resolved, &[]);
    assert_eq!(again.resolved_toml(), resolved);
    assert_eq!(again.hash(), case.hash());
    assert!(resolved.contains("membrane-safety = 0.8"), "defaults are printed:\n{resolved}");
}

#[test]
fn the_hash_depends_on_the_problem_and_not_on_its_outputs() {
    let hash = |overrides: &[(&str, &str)]| read(WATER_SPHERE, overrides).hash();
    assert_eq!(hash(&[]), hash(&[("time.end", "5 ms"), ("output.fields", "1 ms"), ("title", "other")]));
    assert_ne!(hash(&[]), hash(&[("mpm.safety", "0.2")]));
    assert_ne!(hash(&[]), hash(&[("body[0].spacing", "1 mm")]));
}

#[test]
fn the_hash_depends_on_the_contents_of_tables() {
    let home = tempfile::tempdir().unwrap();
    let table = home.path().join("g.csv");
    let hash = || {
        let set = [("mpm.gravity".to_owned(), "[0, { table = \"g.csv\" }, 0]".to_owned())];
        Case::read(Source::new("case.toml", home.path(), WATER_SPHERE), &set).unwrap().hash()
    };
    std::fs::write(&table, "t [s], g [m/s^2]\n0, 1\n1, 2\n").unwrap();
    let before = hash();
    assert_eq!(before, hash());
    std::fs::write(&table, "t [s], g [m/s^2]\n0, 1\n1, 3\n").unwrap();
    assert_ne!(before, hash());
}

#[test]
fn a_dimensionless_case_takes_plain_numbers_and_formulas() {
    let case = read(
        r#"
        name = "column"
        dimension = 2
        units = "none"
        time = { end = 1 }
        grid = { cell = 0.1, lower = [0, 0], upper = [1, 2], walls = { bottom = { kind = "fixed", velocity = ["sin(t)", 0] } } }
        mpm = { gravity = [0, "-ramp(t, 2)"], friction = "stick" }
        output = { checkpoint = "60 s" }
        "#,
        &[],
    );
    assert_eq!(case.file.mpm.gravity[1], SignalSpec::Formula("-ramp(t, 2)".into()));
    assert_eq!(case.file.grid.as_ref().unwrap().upper, [1.0, 2.0, 0.0]);
    assert_eq!(case.file.output.checkpoint, Some(60.0));
}
