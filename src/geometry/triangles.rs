//! Faces from STL (ASCII or binary) and OBJ files, open or closed, and the triangles that they are cut into.

use crate::input;
use crate::math::Vector;
use hashbrown::HashMap;
use std::io::Cursor;
use std::path::Path;

/// Triangles, quadrilaterals and polygons with shared vertices, as a file has them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Faces {
    /// Vertices [m], each position once.
    pub vertices: Vec<[f64; 3]>,
    /// Three vertices or more each, counter-clockwise seen from outside.
    pub faces: Vec<Vec<u32>>,
}

/// Triangles with shared vertices.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Triangles {
    /// Vertices [m], each position once.
    pub vertices: Vec<[f64; 3]>,
    /// Three vertices each, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Faces {
    /// Reads `path`; `unit` is the length of one unit of the file [m].
    ///
    /// Equal vertices are merged; corners that follow each other at one place are one, and what has fewer than three
    /// then is left out (it covers nothing).
    ///
    /// # Errors
    /// A file that is unreadable, neither STL nor OBJ, torn, empty, or not finite.
    pub fn read(path: &Path, unit: f64) -> Result<Self, String> {
        let bytes = input::read(path).map_err(|why| format!("can't be read: {why}"))?;
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        match ending.as_str() {
            "stl" => Self::from_stl(bytes, unit),
            "obj" => Self::from_obj(&bytes, unit),
            _ => Err("the ending must be .stl or .obj".into()),
        }
    }

    /// From the bytes of an STL file; `unit` as in [`Faces::read`].
    ///
    /// # Errors
    /// As [`Faces::read`].
    pub fn from_stl(mut bytes: Vec<u8>, unit: f64) -> Result<Self, String> {
        if bytes.is_empty() {
            return Err("the file is empty".into());
        }
        check_stl_size(&mut bytes)?;
        let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|why| format!("not a sound STL file: {why}"))?;
        let corner = |v: usize| mesh.vertices[v].0.map(f64::from);
        Self::merged(mesh.faces.iter().map(|face| face.vertices.map(corner).to_vec()), unit)
    }

    /// From the bytes of an OBJ file, all of its objects together; `unit` as in [`Faces::read`].
    ///
    /// # Errors
    /// As [`Faces::read`].
    pub fn from_obj(mut bytes: &[u8], unit: f64) -> Result<Self, String> {
        let options = tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..Default::default() };
        let no_materials = |_: &Path| Ok(Default::default());
        let (models, _) = tobj::load_obj_buf(&mut bytes, &options, no_materials)
            .map_err(|why| format!("not a sound OBJ file: {why}"))?;
        let corners = models.iter().flat_map(|model| {
            let mesh = &model.mesh;
            let corner = |&v: &u32| std::array::from_fn(|i| mesh.positions[3 * v as usize + i]);
            let count = if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { mesh.face_arities.len() };
            let mut left = &mesh.indices[..];
            (0..count).map(move |face| {
                let corners = mesh.face_arities.get(face).map_or(3, |&corners| corners as usize);
                let (own, others) = left.split_at(corners);
                left = others;
                own.iter().map(corner).collect()
            })
        });
        Self::merged(corners, unit)
    }

    fn merged(corners: impl Iterator<Item = Vec<[f64; 3]>>, unit: f64) -> Result<Self, String> {
        let mut merged = Self::default();
        let mut known: HashMap<[u64; 3], u32> = HashMap::new();
        for (index, face) in corners.enumerate() {
            if face.iter().flatten().any(|c| !c.is_finite()) {
                return Err(format!("face {index} has a coordinate that is not a finite number"));
            }
            let vertex = |x: [f64; 3]| {
                // Adding zero makes −0 and 0 one vertex.
                *known.entry(x.map(|c| (c + 0.0).to_bits())).or_insert_with(|| {
                    merged.vertices.push(x.map(|c| c * unit));
                    merged.vertices.len() as u32 - 1
                })
            };
            let mut face: Vec<u32> = face.into_iter().map(vertex).collect();
            face.dedup();
            if face.len() > 1 && face.first() == face.last() {
                face.pop();
            }
            if face.len() > 2 {
                merged.faces.push(face);
            }
        }
        if merged.faces.is_empty() {
            return Err("the file holds no triangles".into());
        }
        Ok(merged)
    }

    /// The triangles of all faces. One with more corners is cut about its middle: a diagonal would prefer one
    /// direction.
    ///
    /// # Errors
    /// A face whose corners can't all be seen from its middle.
    pub fn triangles(self) -> Result<Triangles, String> {
        let Self { mut vertices, faces } = self;
        let mut triangles = Vec::with_capacity(faces.len());
        for (index, face) in faces.iter().enumerate() {
            if let &[a, b, c] = &face[..] {
                triangles.push([a, b, c]);
                continue;
            }
            let corner = |i: usize| Vector(vertices[face[i % face.len()] as usize]);
            let middle = (0..face.len()).map(corner).sum::<Vector<3>>() / face.len() as f64;
            let area = |i: usize| (corner(i) - middle).cross(corner(i + 1) - middle);
            let whole = (0..face.len()).map(area).sum::<Vector<3>>();
            if let Some(i) = (0..face.len()).find(|&i| area(i).dot(whole) <= 0.0) {
                let [x, y, z] = corner(i).0;
                return Err(format!(
                    "face {index} has {} corners and folds back at ({x:.6e}, {y:.6e}, {z:.6e}) m: save it as triangles",
                    face.len()
                ));
            }
            let centre = vertices.len() as u32;
            vertices.push(middle.0);
            triangles.extend((0..face.len()).map(|i| [face[i], face[(i + 1) % face.len()], centre]));
        }
        Ok(Triangles { vertices, triangles })
    }
}

impl Triangles {
    /// Reads `path`; `unit` is the length of one unit of the file [m].
    ///
    /// # Errors
    /// As [`Faces::read`] and [`Faces::triangles`].
    pub fn read(path: &Path, unit: f64) -> Result<Self, String> {
        Faces::read(path, unit)?.triangles()
    }

    /// From the bytes of an STL file.
    ///
    /// # Errors
    /// As [`Triangles::read`].
    pub fn from_stl(bytes: Vec<u8>, unit: f64) -> Result<Self, String> {
        Faces::from_stl(bytes, unit)?.triangles()
    }

    /// From the bytes of an OBJ file.
    ///
    /// # Errors
    /// As [`Triangles::read`].
    pub fn from_obj(bytes: &[u8], unit: f64) -> Result<Self, String> {
        Faces::from_obj(bytes, unit)?.triangles()
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
