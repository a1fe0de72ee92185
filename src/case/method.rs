//! Keys of each method.

use super::tree::{PlacedValue, Value};
use super::walk::nearest;
use crate::error::Diagnostic;
use crate::material::PointLaws;

/// Top-level keys of one method alone; the first must be there.
const MPM: &[&str] = &["grid", "mpm", "membrane", "obstacle", "contact"];
const PFEM2: &[&str] = &["mesh", "pfem2", "boundary", "tension"];

/// Keys of a body that only solids in a fluid on a mesh have.
const SOLID_BODY: &[&str] = &[
    "mesh",
    "plane",
    "motion",
    "bond",
    "damping",
    "inertia",
    "friction",
    "restitution",
    "surface",
    "moment-about",
    "supports",
];

/// Keys of a body that only particles with a volume of their own have.
const MPM_BODY: &[&str] =
    &["spacing", "particles-per-cell", "exact-volume", "lattice", "pressure", "energy", "ambient", "group"];

/// The method that a case names.
fn name(tree: &PlacedValue) -> &str {
    tree.get("method").and_then(PlacedValue::as_str).unwrap_or("mpm")
}

/// Notes keys of the other method, and what this one needs.
pub(super) fn check(tree: &PlacedValue, findings: &mut Vec<Diagnostic>) {
    if let Some(finding) = forgotten(tree) {
        findings.push(finding);
        return;
    }
    let (own, other, example) = match name(tree) {
        "mpm" => (MPM, PFEM2, grid_example(tree)),
        "pfem2" => (PFEM2, MPM, "write `mesh = { shape = \"box\", lower = [...], upper = [...], cell = ... }`"),
        _ => return,
    };
    if tree.get(own[0]).is_none() {
        let finding = Diagnostic::error("", format!("the key `{}` is missing", own[0])).help(example);
        findings.push(Diagnostic { span: tree.span.clone(), ..finding });
    }
    for key in other.iter().filter(|key| tree.get(key).is_some()) {
        findings.push(foreign(tree, key, tree.get(key)));
    }
    preset(tree, findings);
    let Some(Value::Array(bodies)) = tree.get("body").map(|node| &node.value) else { return };
    for (i, body) in bodies.iter().enumerate() {
        keys_of_body(tree, &format!("body[{i}]"), body, findings);
        region(tree, &format!("body[{i}]"), body, findings);
    }
}

fn grid_example(tree: &PlacedValue) -> &'static str {
    match tree.get("method") {
        Some(_) => "write `[grid]` with `cell`, `lower` and `upper`",
        None => "write `[grid]` with `cell`, `lower` and `upper`, or `method = \"pfem2\"` and its `[mesh]`",
    }
}

/// A case that doesn't say its method is one of material points; where it has keys of PFEM-2 alone, that was forgotten.
fn forgotten(tree: &PlacedValue) -> Option<Diagnostic> {
    let said = |key: &&&str| tree.get(key).is_some();
    if said(&&"method") || MPM.iter().any(|key| said(&key)) {
        return None;
    }
    let key = PFEM2.iter().find(said)?;
    let message = format!("the key `method` is missing, and `{key}` belongs to `method = \"pfem2\"`");
    let help = "write `method = \"pfem2\"`: without it the method is `\"mpm\"`, which has a `[grid]`";
    Some(Diagnostic { span: tree.get(key)?.span.clone(), ..Diagnostic::error(*key, message).help(help) })
}

fn foreign(tree: &PlacedValue, key: &str, node: Option<&PlacedValue>) -> Diagnostic {
    let message = format!("`{key}` does not belong to `method = \"{}\"`", name(tree));
    let finding = Diagnostic::error(key, message).help("take it out, or choose the other method");
    Diagnostic { span: node.and_then(|node| node.span.clone()), ..finding }
}

fn preset(tree: &PlacedValue, findings: &mut Vec<Diagnostic>) {
    let Some(node) = tree.get("preset") else { return };
    let own = match node.as_str() {
        Some("lian-2014") => "mpm",
        Some("becker-2015") => "pfem2",
        _ => return,
    };
    if own != name(tree) {
        let message = format!("this preset is for `method = \"{own}\"`");
        let finding = Diagnostic::error("preset", message).help("leave it out: the recommended one then holds");
        findings.push(Diagnostic { span: node.span.clone(), ..finding });
    }
}

/// True for a body with a law of material points, which in PFEM-2 is one of solids.
fn is_solid(body: &PlacedValue) -> bool {
    let law = body.get("material").and_then(|material| material.get("law")).and_then(PlacedValue::as_str);
    law.is_some_and(|law| PointLaws::NAMES.contains(&law))
}

fn keys_of_body(tree: &PlacedValue, key: &str, body: &PlacedValue, findings: &mut Vec<Diagnostic>) {
    let given = |keys: &'static [&str]| keys.iter().filter(|key| body.get(key).is_some());
    if name(tree) == "mpm" {
        findings.extend(given(SOLID_BODY).map(|own| foreign(tree, &format!("{key}.{own}"), body.get(own))));
        findings.extend(incompressible(key, body));
        return;
    }
    findings.extend(given(MPM_BODY).map(|own| foreign(tree, &format!("{key}.{own}"), body.get(own))));
    if !is_solid(body) {
        for own in given(SOLID_BODY).chain(given(&["traction", "stress"])) {
            let message = format!("`{own}` is for solids, and this body is a fluid");
            let help = "take it out, or give the body the law of a solid, such as `law = \"neo-hookean\"` or `law = \"rigid\"`";
            let finding = Diagnostic::error(format!("{key}.{own}"), message).help(help);
            findings.push(Diagnostic { span: body.get(own).and_then(|node| node.span.clone()), ..finding });
        }
    }
}

/// Material points of an elastic solid are compressible.
fn incompressible(key: &str, body: &PlacedValue) -> Option<Diagnostic> {
    let node = body.get("material").and_then(|material| material.get("poisson"))?;
    let is_half = match &node.value {
        Value::Float(poisson) => *poisson == 0.5,
        Value::String(text) => text.trim().parse() == Ok(0.5),
        _ => false,
    };
    let message = "a Poisson's ratio of 0.5 is for solids of `method = \"pfem2\"` on meshes of their own: waves in material points would be \
                   infinitely fast";
    let finding = Diagnostic::error(format!("{key}.material.poisson"), message).help("take 0.49 or less");
    is_half.then(|| Diagnostic { span: node.span.clone(), ..finding })
}

/// Every body has a region, except solids whose mesh comes from a file.
fn region(tree: &PlacedValue, key: &str, body: &PlacedValue, findings: &mut Vec<Diagnostic>) {
    let file = body.get("mesh").and_then(|mesh| mesh.get("path")).filter(|_| name(tree) == "pfem2");
    let misspelt = |known: &str| nearest(known, ["region"].into_iter()).is_some();
    let finding = match (&body.value, body.get("region"), file) {
        (_, Some(node), Some(_)) => {
            let message = "the mesh says where the body is: it needs no region";
            let finding = Diagnostic::error(format!("{key}.region"), message).help("take it out, or the mesh");
            Diagnostic { span: node.span.clone(), ..finding }
        }
        (Value::Table(entries), None, None) if !entries.iter().any(|entry| misspelt(&entry.key)) => {
            let finding = Diagnostic::error(key, "the key `region` is missing");
            Diagnostic { span: body.span.clone(), ..finding }
        }
        _ => return,
    };
    findings.push(finding);
}

/// Takes the sections of the other method out of a resolved case.
pub(super) fn keep_own(table: &mut toml::Table) {
    let other = match table.get("method").and_then(toml::Value::as_str) {
        Some("pfem2") => MPM,
        _ => PFEM2,
    };
    other.iter().for_each(|key| drop(table.remove(*key)));
    if other == MPM {
        let bodies = table.get_mut("body").and_then(toml::Value::as_array_mut).into_iter().flatten();
        for body in bodies.filter_map(toml::Value::as_table_mut) {
            MPM_BODY.iter().for_each(|key| drop(body.remove(*key)));
        }
    }
}
