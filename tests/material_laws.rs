//! The laws of material points as a case file names them.

use lateen::material::{EquationsOfState, PointLaws};
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

/// Every number of every law has a unit in the schema, from which the case reader converts.
#[test]
fn every_parameter_of_a_law_has_a_unit_and_a_description() {
    for schema in [schemars::schema_for!(PointLaws), schemars::schema_for!(EquationsOfState)] {
        let schema = serde_json::to_value(schema).unwrap();
        let mut numbers = 0;
        visit(&schema, &mut |name, field| {
            if field["type"] == "number" || field["type"] == "array" {
                let unit = field["unit"].as_str().unwrap_or_else(|| panic!("`{name}` has no unit: {field}"));
                assert!(unit == "1" || Unit::parse(unit).is_ok(), "`{name}` has the unknown unit `{unit}`");
                assert!(field["description"].is_string(), "`{name}` has no description");
                numbers += 1;
            }
        });
        assert!(numbers > 10);
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
