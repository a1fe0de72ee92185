//! Whole files: particles and surfaces of solids as `.vtp`, membranes and meshes as `.vtu`.

use super::array::{ArrayValues, DataArray, FieldPrecision};
use crate::error::Result;
use crate::output::{UnitLabels, atomic};
use crate::simulation::{Elements, PointSet, SurfaceSet};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

/// One element of the XML that holds arrays, for example `PointData`.
struct Section<'a> {
    tag: &'static str,
    arrays: Vec<DataArray<'a>>,
}

/// Writes particles as a `.vtp` file: one vertex per particle, their fields, `id`, and the time.
///
/// # Errors
/// Input/output errors; an older file at `path` is still there then.
pub fn write_points(
    path: &Path,
    set: &PointSet<'_>,
    time: f64,
    precision: FieldPrecision,
    units: UnitLabels,
) -> Result<()> {
    let count = set.position.len();
    let mut fields = vec![DataArray::plain("id", ArrayValues::U32(&set.id))];
    fields.extend(set.fields.iter().map(|field| DataArray::field(field, units.unit(field.unit), precision)));
    let vertices = vec![
        DataArray::plain("connectivity", ArrayValues::I64(Box::new(move || (0..count as i64).collect()))),
        DataArray::plain("offsets", ArrayValues::I64(Box::new(move || (1..=count as i64).collect()))),
    ];
    let sections = [
        Section { tag: "PointData", arrays: fields },
        points_section(&set.position, precision, units),
        Section { tag: "Verts", arrays: vertices },
    ];
    let piece = format!("<Piece NumberOfPoints=\"{count}\" NumberOfVerts=\"{count}\">");
    atomic::write(path, |out| write_file(out, "PolyData", &piece, &sections, time))
}

/// Writes a membrane or mesh as a `.vtu` file: nodes, elements, their fields, and the time.
///
/// # Errors
/// Input/output errors; an older file at `path` is still there then.
pub fn write_surface(
    path: &Path,
    set: &SurfaceSet<'_>,
    time: f64,
    precision: FieldPrecision,
    units: UnitLabels,
) -> Result<()> {
    let node_fields = set.node_fields.iter().map(|field| DataArray::field(field, units.unit(field.unit), precision));
    let element_fields =
        set.element_fields.iter().map(|field| DataArray::field(field, units.unit(field.unit), precision));
    let sections = [
        Section { tag: "PointData", arrays: node_fields.collect() },
        Section { tag: "CellData", arrays: element_fields.collect() },
        points_section(&set.position, precision, units),
        Section { tag: "Cells", arrays: cells(set) },
    ];
    let (nodes, elements) = (set.position.len(), set.elements.len());
    let piece = format!("<Piece NumberOfPoints=\"{nodes}\" NumberOfCells=\"{elements}\">");
    atomic::write(path, |out| write_file(out, "UnstructuredGrid", &piece, &sections, time))
}

/// Writes the surface of a solid as a `.vtp` file: nodes, lines of two nodes and polygons of more, fields of the nodes,
/// and the time.
///
/// # Errors
/// Input/output errors; an older file at `path` is still there then.
pub fn write_outline(
    path: &Path,
    set: &SurfaceSet<'_>,
    time: f64,
    precision: FieldPrecision,
    units: UnitLabels,
) -> Result<()> {
    let fields = set.node_fields.iter().map(|field| DataArray::field(field, units.unit(field.unit), precision));
    let (lines, polygons): (Vec<&[u32]>, Vec<&[u32]>) = set.elements.iter().partition(|nodes| nodes.len() == 2);
    let piece = format!(
        "<Piece NumberOfPoints=\"{}\" NumberOfLines=\"{}\" NumberOfPolys=\"{}\">",
        set.position.len(),
        lines.len(),
        polygons.len()
    );
    let sections = [
        Section { tag: "PointData", arrays: fields.collect() },
        points_section(&set.position, precision, units),
        Section { tag: "Lines", arrays: connections(&lines).into() },
        Section { tag: "Polys", arrays: connections(&polygons).into() },
    ];
    atomic::write(path, |out| write_file(out, "PolyData", &piece, &sections, time))
}

fn points_section<'a>(position: &'a [[f64; 3]], precision: FieldPrecision, units: UnitLabels) -> Section<'a> {
    Section { tag: "Points", arrays: vec![DataArray::points(position, units.unit("m"), precision)] }
}

fn cells<'a>(set: &'a SurfaceSet<'a>) -> Vec<DataArray<'a>> {
    let elements = &set.elements;
    let types = || elements.iter().map(|e| cell_type(set.kind, e.len())).collect();
    let mut arrays: Vec<_> = connections(elements).into();
    arrays.push(DataArray::plain("types", ArrayValues::U8(Box::new(types))));
    arrays
}

/// The nodes of all elements, and where those of each end.
fn connections<'a>(elements: &'a [&'a [u32]]) -> [DataArray<'a>; 2] {
    let connectivity = move || elements.iter().flat_map(|nodes| nodes.iter().map(|&node| i64::from(node))).collect();
    let offsets = move || {
        let ends = elements.iter().scan(0, |end, nodes| {
            *end += nodes.len() as i64;
            Some(*end)
        });
        ends.collect()
    };
    [
        DataArray::plain("connectivity", ArrayValues::I64(Box::new(connectivity))),
        DataArray::plain("offsets", ArrayValues::I64(Box::new(offsets))),
    ]
}

/// VTK's number for a tetrahedron, hexahedron, vertex, line, triangle or quadrilateral; a polygon for anything else.
fn cell_type(kind: Elements, nodes: usize) -> u8 {
    match (kind, nodes) {
        (Elements::Volume, 4) => 10,
        (Elements::Volume, 8) => 12,
        (_, 1) => 1,
        (_, 2) => 3,
        (_, 3) => 5,
        (_, 4) => 9,
        _ => 7,
    }
}

/// Writes the XML, then every array, then fills in where the arrays are.
fn write_file(
    out: &mut (impl Write + Seek),
    kind: &str,
    piece: &str,
    sections: &[Section<'_>],
    time: f64,
) -> io::Result<()> {
    let time = DataArray::plain("TimeValue", ArrayValues::Time(time));
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    writeln!(
        out,
        "<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
         compressor=\"vtkZLibDataCompressor\">\n<{kind}>"
    )?;
    let mut places: Vec<(&DataArray<'_>, u64)> = vec![];
    let mut header = |out: &mut dyn SeekWrite, array| -> io::Result<()> {
        places.push((array, out.stream_position()?));
        out.write_all(array.header(None).as_bytes())
    };
    writeln!(out, "<FieldData>")?;
    header(out, &time)?;
    writeln!(out, "</FieldData>\n{piece}")?;
    for section in sections {
        writeln!(out, "<{}>", section.tag)?;
        section.arrays.iter().try_for_each(|array| header(out, array))?;
        writeln!(out, "</{}>", section.tag)?;
    }
    write!(out, "</Piece>\n</{kind}>\n<AppendedData encoding=\"raw\">\n_")?;
    append_arrays(out, &places)?;
    writeln!(out, "\n</AppendedData>\n</VTKFile>")
}

/// Appends the arrays, and writes their headers again with the offsets that are known now.
fn append_arrays(out: &mut (impl Write + Seek), places: &[(&DataArray<'_>, u64)]) -> io::Result<()> {
    let start = out.stream_position()?;
    for (array, header_at) in places {
        let array_at = out.stream_position()?;
        array.append(out)?;
        let end = out.stream_position()?;
        out.seek(SeekFrom::Start(*header_at))?;
        out.write_all(array.header(Some(array_at - start)).as_bytes())?;
        out.seek(SeekFrom::Start(end))?;
    }
    Ok(())
}

trait SeekWrite: Seek + Write {}
impl<T: Seek + Write> SeekWrite for T {}
