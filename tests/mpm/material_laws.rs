//! The laws of material points, sheets and fluids on a mesh as a case file names them.

use lateen::material::sheet::SheetLaw;
use lateen::material::{EquationsOfState, PointLaws, ViscousLaws};
use lateen::math::units::Unit;

fn law(text: &str) -> Result<PointLaws, String> {
    toml::from_str(text).map_err(|error| error.to_string())
}

#[test]
fn a_fluid_is_read_with_its_defaults() {
    let text = r#"
        law = "fluid"
        density = 1000.0
        eos = { kind = "mie-gruneisen", sound-speed = 1647.0, slope = 1.921, gruneisen = 0.1 }
        bulk-viscosity = [1.5, 0.06]
    "#;
    let PointLaws::Fluid(fluid) = law(text).unwrap() else { panic!("a fluid") };
    assert_eq!((fluid.viscosity, fluid.eos.name()), (0.0, "mie-gruneisen"));
    assert_eq!(fluid.bulk_viscosity.0, [1.5, 0.06]);
}

#[test]
fn unknown_keys_and_names_are_errors() {
    let solid = r#"law = "hypoelastic"
        density = 1.0
        young = 1.0
        poisson = 0.3"#;
    assert!(law(solid).is_ok());
    assert!(law(&format!("{solid}\nyuong = 2.0")).unwrap_err().contains("unknown field `yuong`"));
    assert!(law(&solid.replace("hypoelastic", "hypo")).unwrap_err().contains("unknown variant `hypo`"));
    let gas = r#"law = "fluid"
        density = 1.0
        eos = { kind = "ideal-gas", gama = 1.4 }"#;
    assert!(law(gas).unwrap_err().contains("unknown field `gama`"));
}

/// The keys that each law of sheets and of fluids on a mesh must have, every law of the two lists once.
const SHEETS: [(&str, &[&str]); 4] = [
    ("elastic", &["density", "young", "poisson"]),
    ("neo-hookean", &["density", "shear"]),
    ("mooney-rivlin", &["density", "c1", "c2"]),
    ("fabric", &["density", "young-warp", "young-weft", "shear"]),
];
const FLUIDS: [(&str, &[&str]); 3] = [
    ("newtonian", &["density"]),
    ("bingham", &["density", "viscosity", "yield-stress"]),
    ("herschel-bulkley", &["density", "consistency", "index", "yield-stress"]),
];

#[test]
fn sheets_and_viscous_laws_name_the_key_that_is_unknown_or_missing() {
    assert_eq!(SHEETS.map(|(name, _)| name), *SheetLaw::NAMES);
    assert_eq!(FLUIDS.map(|(name, _)| name), *ViscousLaws::NAMES);
    let sheet = |text: &str| toml::from_str::<SheetLaw>(text).map(drop).map_err(|error| error.to_string());
    let fluid = |text: &str| toml::from_str::<ViscousLaws>(text).map(drop).map_err(|error| error.to_string());
    SHEETS.iter().for_each(|(name, keys)| refuses_unknown_and_missing_keys(name, keys, sheet));
    FLUIDS.iter().for_each(|(name, keys)| refuses_unknown_and_missing_keys(name, keys, fluid));
    assert!(sheet("law = 'silk'\ndensity = 1.0").unwrap_err().contains("unknown variant `silk`"));
    assert!(fluid("law = 'honey'\ndensity = 1.0").unwrap_err().contains("unknown variant `honey`"));
}

fn refuses_unknown_and_missing_keys(name: &str, keys: &[&str], read: impl Fn(&str) -> Result<(), String>) {
    let text =
        |keys: &[&str]| format!("law = '{name}'\n{}", keys.iter().map(|k| format!("{k} = 0.4\n")).collect::<String>());
    assert_eq!(read(&text(keys)), Ok(()), "{name}");
    let refusal = read(&text(&[keys, &["densty"]].concat())).unwrap_err();
    assert!(refusal.contains("unknown field `densty`"), "{name}: {refusal}");
    for missing in keys {
        let others: Vec<&str> = keys.iter().copied().filter(|key| key != missing).collect();
        let refusal = read(&text(&others)).unwrap_err();
        assert!(refusal.contains(&format!("missing field `{missing}`")), "{name}: {refusal}");
    }
}

#[test]
fn rubber_has_keys_of_its_own() {
    let rubber = r#"law = "mooney-rivlin"
        density = 1100.0
        c10 = 0.2e6
        c01 = 0.05e6
        bulk = 2e6"#;
    let PointLaws::MooneyRivlin(law_of_rubber) = law(rubber).unwrap() else { panic!("rubber") };
    assert_eq!((law_of_rubber.c10, law_of_rubber.c01, law_of_rubber.bulk), (0.2e6, 0.05e6, 2e6));
    assert!(law(&format!("{rubber}\nyoung = 1e6")).unwrap_err().contains("unknown field `young`"));
    assert!(law(&rubber.replace("bulk = 2e6", "")).unwrap_err().contains("missing field `bulk`"));
}

/// Only elastic solids can be linearised; others say why not.
#[test]
fn elastic_laws_have_tangents_and_others_refuse() {
    let numbers = "density = 1e3\nyoung = 1e6\npoisson = 0.3";
    for name in ["hypoelastic", "neo-hookean", "st-venant-kirchhoff"] {
        assert!(law(&format!("law = '{name}'\n{numbers}")).unwrap().as_dyn().elastic_law().is_ok(), "{name}");
    }
    let soil = law(&format!("law = 'drucker-prager'\nfriction-angle = 0.5\n{numbers}")).unwrap();
    let refusal = soil.as_dyn().elastic_law().unwrap_err();
    assert!(refusal.contains("plastic strain"), "{refusal}");
    let water = law("law = 'fluid'\ndensity = 1e3\neos = { kind = 'linear', sound-speed = 100.0 }").unwrap();
    assert!(water.as_dyn().elastic_law().unwrap_err().contains("fluid"));
}

#[test]
fn laws_read_back_what_they_write() {
    let text = r#"law = "j2"
        density = 8930.0
        young = 117e9
        poisson = 0.35
        yield-stress = 400e6"#;
    let written = toml::to_string(&law(text).unwrap()).unwrap();
    assert!(written.contains("hardening-exponent = 1.0"), "{written}");
    assert_eq!(toml::to_string(&law(&written).unwrap()).unwrap(), written);
}

/// Every number of every law has a unit in the schema, from which the case reader converts, and every key a
/// description.
#[test]
fn every_parameter_of_a_law_has_a_unit_and_a_description() {
    let points = [schemars::schema_for!(PointLaws), schemars::schema_for!(EquationsOfState)];
    let sheets_and_fluids = [schemars::schema_for!(SheetLaw), schemars::schema_for!(ViscousLaws)];
    for schema in points.into_iter().chain(sheets_and_fluids) {
        let schema = serde_json::to_value(schema).unwrap();
        let mut numbers = 0;
        visit(&schema, &mut |name, field| {
            let is_name = field["const"].is_string();
            assert!(is_name || field["description"].is_string(), "`{name}` has no description: {field}");
            // Pa sⁿ: its unit depends on the exponent.
            if (field["type"] == "number" || field["type"] == "array") && name != "consistency" {
                let unit = field["unit"].as_str().unwrap_or_else(|| panic!("`{name}` has no unit: {field}"));
                assert!(unit == "1" || Unit::parse(unit).is_ok(), "`{name}` has the unknown unit `{unit}`");
                numbers += 1;
            }
        });
        assert!(numbers >= 10);
    }
}

fn visit(schema: &serde_json::Value, check: &mut impl FnMut(&str, &serde_json::Value)) {
    if let Some(fields) = schema["properties"].as_object() {
        for (name, field) in fields {
            check(name, field);
        }
    }
    match schema {
        serde_json::Value::Object(map) => map.values().for_each(|value| visit(value, check)),
        serde_json::Value::Array(list) => list.iter().for_each(|value| visit(value, check)),
        _ => {}
    }
}
