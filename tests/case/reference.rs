//! The schema and the reference of keys, which are made from the same structs that read the case.

use lateen::case::{laws, schema};
use lateen::math::units::Unit;
use serde_json::Value;

fn visit(value: &Value, look: &mut impl FnMut(&serde_json::Map<String, Value>)) {
    match value {
        Value::Object(object) => {
            look(object);
            object.values().for_each(|v| visit(v, look));
        }
        Value::Array(items) => items.iter().for_each(|v| visit(v, look)),
        _ => {}
    }
}

#[test]
fn every_unit_in_the_schema_is_a_unit() {
    let mut count = 0;
    visit(&schema(), &mut |object| {
        // A property may be called `unit`: then it is a schema, not text.
        if let Some(unit) = object.get("unit").and_then(Value::as_str) {
            count += 1;
            assert!(Unit::parse(unit).is_ok(), "`{unit}` in {object:?}");
        }
    });
    assert!(count > 50, "{count}");
}

#[test]
fn every_key_is_described() {
    let mut bare = Vec::new();
    visit(&schema(), &mut |object| {
        for (key, value) in object.get("properties").and_then(Value::as_object).into_iter().flatten() {
            if value.get("description").is_none() && value.get("const").is_none() {
                bare.push(key.clone());
            }
        }
    });
    assert_eq!(bare, Vec::<String>::new());
}

#[test]
fn the_schema_allows_quantities_as_text() {
    let schema = schema();
    let cell = &schema["$defs"]["GridSpec"]["properties"]["cell"];
    assert_eq!(cell["type"], serde_json::json!(["number", "string"]), "{cell}");
    let lower = &schema["$defs"]["GridSpec"]["properties"]["lower"];
    assert_eq!(lower["minItems"], 2, "{lower}");
}

#[test]
fn the_reference_names_laws_units_and_defaults() {
    let page = laws();
    for expected in [
        "### `law = \"fluid\"`",
        "### `kind = \"mie-gruneisen\"`",
        "### `law = \"mooney-rivlin\"`",
        "### `shape = \"half-space\"`",
        "- `young` (number [Pa], required)",
        "- `safety` (number, default 0.3)",
        "- `cell` (number [m], required): Size of a cell.",
    ] {
        assert!(page.contains(expected), "`{expected}` is missing in\n{page}");
    }
}
