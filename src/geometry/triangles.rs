//! Triangles from STL (ASCII or binary) and OBJ files, open or closed.

use hashbrown::HashMap;
use std::io::Cursor;
use std::path::Path;

/// Triangles with shared vertices.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Triangles {
    /// Vertices [m], each position once.
    pub vertices: Vec<[f64; 3]>,
    /// Three vertices each, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Triangles {
    /// Reads `path`; `unit` is the length of one unit of the file [m].
    ///
    /// Equal vertices are merged; triangles that use a vertex twice are left out (they cover nothing).
    ///
    /// # Errors
    /// What is wrong with the file: unreadable, neither STL nor OBJ, torn, empty, not finite.
    pub fn read(path: &Path, unit: f64) -> Result<Self, String> {
        let bytes = std::fs::read(path).map_err(|why| format!("can't be read: {why}"))?;
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        match ending.as_str() {
            "stl" => Self::from_stl(bytes, unit),
            "obj" => Self::from_obj(&bytes, unit),
            _ => Err("the ending must be .stl or .obj".into()),
        }
    }

    /// From the bytes of an STL file; `unit` as in [`Triangles::read`].
    ///
    /// # Errors
    /// As [`Triangles::read`].
    pub fn from_stl(mut bytes: Vec<u8>, unit: f64) -> Result<Self, String> {
        if bytes.is_empty() {
            return Err("the file is empty".into());
        }
        check_stl_size(&mut bytes)?;
        let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|why| format!("not a sound STL file: {why}"))?;
        let corner = |v: usize| mesh.vertices[v].0.map(f64::from);
        Self::merged(mesh.faces.iter().map(|face| face.vertices.map(corner)), unit)
    }

    /// From the bytes of an OBJ file, all of its objects together; `unit` as in [`Triangles::read`].
    ///
    /// # Errors
    /// As [`Triangles::read`].
    pub fn from_obj(mut bytes: &[u8], unit: f64) -> Result<Self, String> {
        let options =
            tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
        let no_materials = |_: &Path| Ok(Default::default());
        let (models, _) = tobj::load_obj_buf(&mut bytes, &options, no_materials)
            .map_err(|why| format!("not a sound OBJ file: {why}"))?;
        let corners = models.iter().flat_map(|model| {
            let corner = |v: u32| std::array::from_fn(|i| model.mesh.positions[3 * v as usize + i]);
            model.mesh.indices.chunks_exact(3).map(move |t| [corner(t[0]), corner(t[1]), corner(t[2])])
        });
        Self::merged(corners, unit)
    }

    fn merged(corners: impl Iterator<Item = [[f64; 3]; 3]>, unit: f64) -> Result<Self, String> {
        let mut merged = Self::default();
        let mut known: HashMap<[u64; 3], u32> = HashMap::new();
        for (index, triangle) in corners.enumerate() {
            if triangle.iter().flatten().any(|c| !c.is_finite()) {
                return Err(format!("triangle {index} has a coordinate that is not a finite number"));
            }
            let triangle = triangle.map(|x| {
                // Adding zero makes −0 and 0 one vertex.
                *known.entry(x.map(|c| (c + 0.0).to_bits())).or_insert_with(|| {
                    merged.vertices.push(x.map(|c| c * unit));
                    merged.vertices.len() as u32 - 1
                })
            });
            if triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0] {
                merged.triangles.push(triangle);
            }
        }
        if merged.triangles.is_empty() {
            return Err("the file holds no triangles".into());
        }
        Ok(merged)
    }
}

/// A binary STL file has 84 + 50 n bytes; one of exactly this size is binary even when its header begins
/// with `solid`, the mark of ASCII files.
fn check_stl_size(bytes: &mut [u8]) -> Result<(), String> {
    const HEADER: usize = 80;
    const START: usize = 84;
    const TRIANGLE: usize = 50;
    let text = bytes.trim_ascii_start().starts_with(b"solid");
    if bytes.len() < START {
        return if text { Ok(()) } else { Err(format!("{} bytes are too few for an STL file", bytes.len())) };
    }
    let count = u32::from_le_bytes([bytes[80], bytes[81], bytes[82], bytes[83]]) as usize;
    if count.checked_mul(TRIANGLE).and_then(|size| size.checked_add(START)) == Some(bytes.len()) {
        bytes[..HEADER].fill(0);
    } else if !text {
        let held = (bytes.len() - START) / TRIANGLE;
        if count > held {
            return Err(format!("the header promises {count} triangles, the file holds {held}: it is cut off"));
        }
    }
    Ok(())
}
