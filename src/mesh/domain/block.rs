//! Boxes, refined where asked, with holes.

use super::BuildMesh;
use super::carve::{CutBox, carve, planes};
use super::graded::lines;
use super::planar::{bounded, triangulate};
use super::size::{Refined, SizeField};
use crate::error::Diagnostic;
use crate::geometry::{Region, Shape};
use crate::math::Vector;
use crate::mesh::{CellCut, Mesh, side_names};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A rectangle or a box. Its sides are named `left`, `right` (x), `front`, `back` (y, in 3D) and `bottom`,
/// `top` (the last axis); holes have the names that the case gives them.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BoxMesh {
    /// Lower corner [m].
    #[schemars(extend("unit" = "m"), length(min = 2, max = 3))]
    pub lower: Vec<f64>,
    /// Upper corner [m].
    #[schemars(extend("unit" = "m"), length(min = 2, max = 3))]
    pub upper: Vec<f64>,
    /// Edge length of the elements away from refined regions [m].
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub cell: f64,
    /// Pattern of the elements.
    #[serde(default)]
    pub pattern: CellPattern,
    /// Growth of the edge length with the distance from a refined region. An error of second order falls by four if
    /// all lengths and this are halved: with the same growth, elements at a distance stay as they are.
    #[serde(default = "growth")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub growth: f64,
    /// Regions with smaller elements.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refine: Vec<Refinement>,
    /// Regions without elements; in 3D boxes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub holes: Vec<Hole>,
}

fn growth() -> f64 {
    0.2
}

/// Patterns of the elements of a box.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CellPattern {
    /// `mirrored`, but `free` in 2D where regions are refined or there are holes.
    #[default]
    Auto,
    /// Cells of a lattice, cut in alternating directions (union jack); refined regions make its planes closer.
    Mirrored,
    /// Cells of a lattice, all cut alike.
    Parallel,
    /// Triangles that follow the size in all directions; 2D only.
    Free,
}

/// A region with smaller elements.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Refinement {
    /// The region.
    pub region: Shape,
    /// Edge length in it [m].
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub cell: f64,
    /// Growth of the edge length with the distance from it; by default that of the mesh. A sharp corner, at which the
    /// solution is singular, needs small elements near it alone: a fast growth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub growth: Option<f64>,
}

/// A region without elements.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hole {
    /// Name of its boundary.
    pub name: String,
    /// The region.
    pub region: Shape,
    /// Edge length along its boundary [m]; by default what holds there anyway.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub cell: Option<f64>,
}

impl BuildMesh for BoxMesh {
    fn triangles(&self, base_dir: &Path) -> Result<Mesh<2, 3>, Diagnostic> {
        let (lower, upper) = self.corners::<2>()?;
        let size = self.size(base_dir, 2)?;
        let graded = !(self.refine.is_empty() && self.holes.is_empty());
        let cut = match self.pattern {
            CellPattern::Auto if graded => None,
            CellPattern::Auto | CellPattern::Mirrored => Some(CellCut::Mirrored),
            CellPattern::Parallel => Some(CellCut::Parallel),
            CellPattern::Free => None,
        };
        if let Some(cut) = cut {
            self.no_holes("leave `pattern` out, or say `pattern = \"free\"`")?;
            let planes = lines(lower, upper, Default::default(), &size).map_err(wrong_size)?;
            return Mesh::lattice(&planes, cut).map_err(wrong_size);
        }
        let holes = self.hole_regions(base_dir, 2)?;
        let plane = |x: [f64; 2], z: f64| [x[0], x[1], z];
        let whole = Region::Box { lower: plane(lower, f64::NEG_INFINITY), upper: plane(upper, f64::INFINITY) };
        let rest = holes.iter().map(|hole| Region::Complement(Box::new(hole.clone())));
        let domain = Region::Intersection(std::iter::once(whole).chain(rest).collect());
        bounded(&domain, &size).map_err(wrong_size)?;
        let mut mesh = triangulate(&domain, &size).map_err(|why| Diagnostic::error("cell", why))?;
        self.name_boundary(&mut mesh, [lower, upper], &holes);
        self.useless_holes(&mesh)?;
        Ok(mesh)
    }

    fn tetrahedra(&self, base_dir: &Path) -> Result<Mesh<3, 4>, Diagnostic> {
        let (lower, upper) = self.corners::<3>()?;
        let cut = match self.pattern {
            CellPattern::Auto | CellPattern::Mirrored => CellCut::Mirrored,
            CellPattern::Parallel => CellCut::Parallel,
            CellPattern::Free => {
                return Err(Diagnostic::error("pattern", "`free` is for 2D")
                    .help("use `mirrored`, or make the mesh with Gmsh, `shape = \"file\"`"));
            }
        };
        let size = self.size(base_dir, 3)?;
        let blocks = self.blocks(base_dir)?;
        let planes = lines(lower, upper, planes(&blocks, lower, upper), &size).map_err(wrong_size)?;
        let lattice = Mesh::lattice(&planes, cut).map_err(wrong_size)?;
        if blocks.is_empty() {
            return Ok(lattice);
        }
        let names: Vec<&str> = self.holes.iter().map(|hole| hole.name.as_str()).collect();
        let ends = std::array::from_fn(|i| [lower[i], upper[i]]);
        let mesh = carve(&lattice, ends, &blocks, &names).map_err(|why| Diagnostic::error("cell", why))?;
        self.useless_holes(&mesh)?;
        Ok(mesh)
    }
}

impl BoxMesh {
    /// Says where a box of a lattice is no whole number of cells, and how long they are instead.
    pub(super) fn adjusted(&self) -> Option<String> {
        let graded = !(self.refine.is_empty() && self.holes.is_empty());
        if graded || self.pattern == CellPattern::Free {
            return None;
        }
        let axes = self.lower.iter().zip(&self.upper).zip(["x", "y", "z"]);
        let along = axes.filter_map(|((lower, upper), name)| {
            let exact = (upper - lower) / self.cell;
            let cells = exact.round().max(1.0);
            let length = (upper - lower) / cells;
            ((exact - cells).abs() > 1e-6 * cells).then(|| format!("{cells} of {length:.6} m along {name}"))
        });
        let along: Vec<String> = along.collect();
        let asked = self.cell;
        let text = || format!("mesh: the box is no whole number of cells of {asked} m; there are {}", along.join(", "));
        (!along.is_empty()).then(text)
    }

    fn corners<const D: usize>(&self) -> Result<([f64; D], [f64; D]), Diagnostic> {
        let corner = |key: &str, x: &Vec<f64>| {
            let wrong = || Diagnostic::error(key, format!("{} coordinates in {D}D", x.len())).help(format!("give {D}"));
            <[f64; D]>::try_from(x.as_slice()).map_err(|_| wrong())
        };
        let (lower, upper) = (corner("lower", &self.lower)?, corner("upper", &self.upper)?);
        let extent = |i: usize| upper[i] - lower[i];
        match (0..D).find(|&i| !(extent(i) > 0.0 && extent(i).is_finite())) {
            Some(i) => Err(Diagnostic::error("upper", format!("the box has no extent along {}", ["x", "y", "z"][i]))
                .help("every coordinate of `upper` must exceed that of `lower`")),
            None => Ok((lower, upper)),
        }
    }

    fn size(&self, base_dir: &Path, dimension: usize) -> Result<SizeField, Diagnostic> {
        let growth = positive("growth", self.growth)?;
        let refined = |key: String, shape: &Shape, cell: f64, own: Option<f64>| {
            let region = shape.build(base_dir, dimension).map_err(|why| within(&format!("{key}.region"), why))?;
            let growth = own.map_or(Ok(growth), |own| positive(&format!("{key}.growth"), own))?;
            Ok(Refined { region, cell: positive(&format!("{key}.cell"), cell)?, growth })
        };
        let regions = self.refine.iter().enumerate();
        let regions = regions.map(|(i, fine)| refined(format!("refine[{i}]"), &fine.region, fine.cell, fine.growth));
        let holes = self
            .holes
            .iter()
            .enumerate()
            .filter_map(|(i, hole)| hole.cell.map(|cell| refined(format!("holes[{i}]"), &hole.region, cell, None)));
        let refined = regions.chain(holes).collect::<Result<_, Diagnostic>>()?;
        Ok(SizeField { coarse: positive("cell", self.cell)?, refined })
    }

    /// The holes of a box in 3D, which a lattice can follow if they are boxes, too.
    fn blocks(&self, base_dir: &Path) -> Result<Vec<CutBox>, Diagnostic> {
        let block = |(i, region): (usize, Region)| match region {
            Region::Box { lower, upper } => Ok([lower, upper]),
            _ => {
                Err(Diagnostic::error(format!("holes[{i}].region"), "in 3D a generated mesh has holes that are boxes")
                    .help("use a `box`, or make the mesh with Gmsh, `shape = \"file\"`"))
            }
        };
        self.hole_regions(base_dir, 3)?.into_iter().enumerate().map(block).collect()
    }

    fn hole_regions(&self, base_dir: &Path, dimension: usize) -> Result<Vec<Region>, Diagnostic> {
        let build = |(i, hole): (usize, &Hole)| {
            hole_name(&format!("holes[{i}].name"), &hole.name, dimension)?;
            hole.region.build(base_dir, dimension).map_err(|why| within(&format!("holes[{i}].region"), why))
        };
        self.holes.iter().enumerate().map(build).collect()
    }

    /// A hole that takes nothing away is a mistake: it lies outside the box, or in another hole.
    fn useless_holes<const D: usize, const N: usize>(&self, mesh: &Mesh<D, N>) -> Result<(), Diagnostic> {
        let Some(i) = self.holes.iter().position(|hole| !mesh.sets.contains_key(&hole.name)) else { return Ok(()) };
        let message = format!(
            "the hole `{}` has no boundary in the mesh: it lies outside the box, or in another hole",
            self.holes[i].name
        );
        let help = format!(
            "the box reaches from {:?} m to {:?} m: move the hole into it, or take it out",
            self.lower, self.upper
        );
        Err(Diagnostic::error(format!("holes[{i}].region"), message).help(help))
    }

    fn no_holes(&self, instead: &str) -> Result<(), Diagnostic> {
        match self.holes.is_empty() {
            true => Ok(()),
            false => Err(Diagnostic::error("holes", "this mesh cannot have holes").help(instead)),
        }
    }

    /// A facet belongs to the hole or the side of the box on which its middle lies.
    fn name_boundary(&self, mesh: &mut Mesh<2, 3>, [lower, upper]: [[f64; 2]; 2], holes: &[Region]) {
        let near = 1e-9 * (upper[0] - lower[0]).max(upper[1] - lower[1]);
        let side = |x: [f64; 2]| {
            let distance = [x[0] - lower[0], upper[0] - x[0], x[1] - lower[1], upper[1] - x[1]];
            let place = distance.iter().position(|d| d.abs() <= near)?;
            Some(["left", "right", "bottom", "top"][place])
        };
        for facet in mesh.boundary().to_vec() {
            let ends =
                mesh.facet_nodes(facet).into_iter().map(|n| mesh.nodes()[n as usize]).collect::<Vec<Vector<2>>>();
            let middle = (ends[0] + ends[1]) * 0.5;
            let gap = |hole: &Region| ends.iter().map(|x| hole.signed_distance(x.to3()).abs()).fold(0.0, f64::max);
            let name = side(middle.0).map(str::to_owned).or_else(|| {
                let nearest = (0..holes.len()).min_by(|&i, &j| gap(&holes[i]).total_cmp(&gap(&holes[j])))?;
                Some(self.holes[nearest].name.clone())
            });
            if let Some(name) = name {
                mesh.sets.entry(name).or_default().push(facet);
            }
        }
    }
}

/// The name of a hole must not be that of a side, nor that of all that is left.
fn hole_name(key: &str, name: &str, dimension: usize) -> Result<(), Diagnostic> {
    let sides = (0..dimension).flat_map(if dimension == 2 { side_names::<2> } else { side_names::<3> });
    let why = match name {
        "" => "the name is empty".to_owned(),
        "rest" => "`rest` means all parts of the boundary that have no condition of their own".to_owned(),
        name if sides.clone().any(|side| side == name) => format!("`{name}` is the name of a side of the box"),
        _ => return Ok(()),
    };
    Err(Diagnostic::error(key, why).help("give the hole another name: conditions on the boundary refer to it"))
}

/// A finding about the sizes of a mesh.
fn wrong_size(why: String) -> Diagnostic {
    Diagnostic::error("cell", why).help(
        "increase `cell`, or the cells of refined regions; a graded mesh can come from Gmsh; are the units right?",
    )
}

fn within(key: &str, why: Diagnostic) -> Diagnostic {
    let key = if why.key.is_empty() { key.to_owned() } else { format!("{key}.{}", why.key) };
    Diagnostic { key, ..why }
}

fn positive(key: &str, value: f64) -> Result<f64, Diagnostic> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(Diagnostic::error(key, format!("must be positive and finite, not {value}")))
}
