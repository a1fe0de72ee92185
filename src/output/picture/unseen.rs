//! Cuts of pictures that hide everything, or that can't be seen.

use super::camera::STANDARD_VIEW;
use super::spec::{CutSpec, PictureSpec};
use crate::error::Diagnostic;
use crate::math::Vector;
use crate::output::set::Set;
use crate::simulation::Snapshot;

/// A warning where the cut of a picture hides all of what is shown at the start, or what lies behind its plane, as
/// seen from the camera.
pub fn unseen_cut(spec: &PictureSpec, key: &str, initial: &Snapshot<'_>) -> Option<Diagnostic> {
    let cut = spec.cut.as_ref()?;
    let mut parts = Set::all(initial).filter(|set| spec.of.is_empty() || spec.of.iter().any(|name| name == set.name()));
    let view = spec.view.unwrap_or(STANDARD_VIEW);
    let (message, help) = if parts.all(|set| hides_all(cut, set)) {
        (
            "the plane hides all of what is shown at the start: the picture is empty",
            "move `at`, or turn `normal` around",
        )
    } else if initial.dimension == 3 && Vector(cut.normal).dot(Vector(view)) <= 0.0 {
        ("the plane hides what lies behind it: from the camera it can't be seen", "turn `normal` or `view` around")
    } else {
        return None;
    };
    let help = format!("{help}: what lies where `normal` points to is hidden, and `view` points to the camera");
    Some(Diagnostic::warning(format!("{key}.cut"), message).help(help))
}

/// True if a cut hides all particles, or a node of each element, of a set that has some.
fn hides_all(cut: &CutSpec, set: Set<'_>) -> bool {
    match set {
        Set::Points(set) => !set.position.is_empty() && set.position.iter().all(|x| cut.hides(x)),
        Set::Surface(set) => {
            let hidden = |nodes: &&[u32]| nodes.iter().any(|&node| cut.hides(&set.position[node as usize]));
            !set.elements.is_empty() && set.elements.iter().all(hidden)
        }
    }
}
