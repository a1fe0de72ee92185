//! Defaults of `[mpm]` and `[pfem2]` by preset and material (theory A.7). A preset is a piece of TOML under
//! what the case says itself.

use super::Material;
use crate::material::{MaterialKind, PointLaws};

/// Lian, Liu & Zhang (2014): hat functions, pure FLIP, stresses first, one step for bodies and membranes.
const LIAN_2014: &str = r#"
kernel = "linear"
transfer = { kind = "flip", relaxation = inf, filter-order = 0 }
dissipation = "lost"
stress-update = "first"
locking = { kind = "none" }
max-substeps = 1
sheet-contact = "nodes"
contact-passes = 1
"#;

/// Gases: FLIP keeps the entropy where it is; the filter removes what the grid can't see.
const GAS: &str = r#"
kernel = "quadratic"
transfer = { kind = "flip", relaxation = inf, filter-order = 2, filter-interval = 20 }
stress-update = "average"
locking = { kind = "none" }
sheet-contact = "nodes"
"#;

/// Liquids: APIC keeps angular momentum in splashes; nearly incompressible particles lock without a cure.
const LIQUID: &str = r#"
kernel = "quadratic"
transfer = { kind = "apic" }
stress-update = "average"
locking = { kind = "average", blend = 1.0 }
"#;

/// Bodies that yield: nothing but the filter resists the noise in plastic flow.
const PLASTIC: &str = r#"
kernel = "quadratic"
transfer = { kind = "flip", relaxation = inf, filter-order = 2, filter-interval = 100 }
stress-update = "average"
locking = { kind = "none" }
"#;

/// Elastic solids: the filter would take spin, at their surfaces, for noise (theory A.7: pure FLIP).
const ELASTIC: &str = r#"
kernel = "quadratic"
transfer = { kind = "flip", relaxation = inf, filter-order = 0 }
stress-update = "average"
locking = { kind = "none" }
"#;

/// The choices of Becker, Idelsohn & Oñate (2015) and of their program.
const BECKER_2015: &str = r#"
scheme = { kind = "backward-euler" }
stabilisation = "pspg"
mass = "lumped"
enrichment = "kink"
kernel = "shape"
interface = "pseudo"
volume = "none"
unresolved = "kept"
reseeding = "elements"
courant = inf
step-tolerance = inf
projectile-ratio = 10.0
relaxation = inf
"#;

/// Three and more fluids: a sharp interface is for two.
const SEVERAL_FLUIDS: &str = r#"
interface = "pseudo"
"#;

/// A line that follows the particles can't be shifted to keep volumes.
const PSEUDO: &str = r#"
volume = "none"
"#;

/// Beside elastic solids, whose motion orthogonal subscales would damp (theory J.3).
const BESIDE_SOLIDS: &str = r#"
stabilisation = "dynamic-subscales"
"#;

/// With several fluids, too: elements with their interface can't keep subscales (theory F.7.4).
const FLUIDS_BESIDE_SOLIDS: &str = r#"
stabilisation = "consistent-pspg"
"#;

/// 15 particles in a triangle, 20 in a tetrahedron.
const BECKER_2015_PER_EDGE: [i64; 2] = [5, 4];

/// Fills the keys of the method's section that the case leaves open.
pub(super) fn apply(case: &mut toml::Table) {
    let text = |key| case.get(key).and_then(toml::Value::as_str);
    let (section, presets) = match (text("method"), text("preset")) {
        (Some("pfem2"), Some("becker-2015")) => ("pfem2", vec![BECKER_2015]),
        // The defaults of the section are the recommended ones.
        (Some("pfem2"), _) => ("pfem2", recommended_flow(case)),
        (_, Some("lian-2014")) => ("mpm", vec![LIAN_2014]),
        _ => ("mpm", vec![recommended(case)]),
    };
    let mut defaults = toml::Table::new();
    for preset in &presets {
        defaults.extend(toml::from_str::<toml::Table>(preset).expect("presets are TOML"));
    }
    if presets == [BECKER_2015] {
        let solid = case.get("dimension").and_then(toml::Value::as_integer) == Some(3);
        let per_edge = BECKER_2015_PER_EDGE[usize::from(solid)];
        defaults.insert("particles-per-edge".to_owned(), toml::Value::Integer(per_edge));
    }
    let section = case.entry(section).or_insert_with(|| toml::Value::Table(toml::Table::new()));
    if let toml::Value::Table(section) = section {
        fill(section, defaults);
    }
}

/// Adds the keys that are open. Tables of one `kind` are filled key by key: to set `filter-interval` alone must not
/// turn the filter off.
fn fill(open: &mut toml::Table, defaults: toml::Table) {
    for (key, default) in defaults {
        match (open.get_mut(&key), default) {
            (None, default) => drop(open.insert(key, default)),
            (Some(toml::Value::Table(own)), toml::Value::Table(default)) if same_kind(own, &default) => {
                fill(own, default)
            }
            (Some(_), _) => {}
        }
    }
}

fn same_kind(own: &toml::Table, default: &toml::Table) -> bool {
    own.get("kind") == default.get("kind")
}

fn interface(case: &toml::Table) -> Option<&str> {
    case.get("pfem2")?.get("interface")?.as_str()
}

fn bodies(case: &toml::Table) -> impl Iterator<Item = &toml::Value> {
    case.get("body").and_then(toml::Value::as_array).into_iter().flatten()
}

/// True unless the law is one of material points, which in PFEM-2 solids have.
fn is_fluid(body: &toml::Value) -> bool {
    let law = body.get("material").and_then(|material| material.get("law")).and_then(toml::Value::as_str);
    law.is_none_or(|law| !PointLaws::NAMES.contains(&law))
}

/// Settings that depend on the bodies of a case of PFEM-2.
fn recommended_flow(case: &toml::Table) -> Vec<&'static str> {
    let fluids = bodies(case).filter(|body| is_fluid(body)).count();
    let of_fluids = match () {
        () if fluids > 2 => Some(SEVERAL_FLUIDS),
        () if interface(case) == Some("pseudo") => Some(PSEUDO),
        () => None,
    };
    let beside_solids = if fluids > 1 { FLUIDS_BESIDE_SOLIDS } else { BESIDE_SOLIDS };
    let of_solids = (fluids < bodies(case).count()).then_some(beside_solids);
    of_fluids.into_iter().chain(of_solids).collect()
}

/// One choice serves all bodies: liquids are the most demanding, then gases, then what yields.
fn recommended(case: &toml::Table) -> &'static str {
    let phases: Vec<MaterialKind> = bodies(case).filter_map(phase).collect();
    match () {
        () if phases.contains(&MaterialKind::Liquid) => LIQUID,
        () if phases.contains(&MaterialKind::Gas) => GAS,
        () if phases.contains(&MaterialKind::Plastic) => PLASTIC,
        () => ELASTIC,
    }
}

/// Kind of the material of a body, by its law. A law with a fault has no phase; reading the case reports it.
fn phase(body: &toml::Value) -> Option<MaterialKind> {
    match body.get("material")?.clone().try_into() {
        Ok(Material::Point(law)) => Some(law.as_dyn().phase()),
        Ok(Material::Flow(_)) | Err(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{ELASTIC, GAS, LIQUID, PLASTIC, recommended};

    #[test]
    fn materials_choose_the_preset() {
        let gas = "{ law = 'fluid', density = 1.2, eos = { kind = 'ideal-gas', gamma = 1.4 } }";
        let water = "{ law = 'fluid', density = 1e3, eos = { kind = 'linear', sound-speed = 100.0 } }";
        let metal = "{ law = 'j2', density = 8e3, young = 2e11, poisson = 0.3, yield-stress = 4e8 }";
        let rubber = "{ law = 'neo-hookean', density = 1e3, young = 1e6, poisson = 0.3 }";
        let chosen = |materials: &[&str]| {
            let body = |material: &&str| format!("[[body]]\nmaterial = {material}\n");
            recommended(&toml::from_str(&materials.iter().map(body).collect::<String>()).unwrap())
        };
        assert_eq!(chosen(&[rubber]), ELASTIC);
        assert_eq!(chosen(&[rubber, metal]), PLASTIC);
        assert_eq!(chosen(&[metal, gas]), GAS);
        assert_eq!(chosen(&[gas, rubber, water]), LIQUID);
    }
}
