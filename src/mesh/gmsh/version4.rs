//! Sections of version 4.1.

use super::cursor::{Cursor, GmshError};
use super::{Builder, CellKind};

/// Counts of points, curves, surfaces and volumes; then each entity with its physical tags.
pub(super) fn entities(cursor: &mut Cursor<'_>, builder: &mut Builder) -> Result<(), GmshError> {
    let counts = [cursor.long()?, cursor.long()?, cursor.long()?, cursor.long()?];
    for (dimension, count) in counts.into_iter().enumerate() {
        let extents = if dimension == 0 { 3 } else { 6 };
        for _ in 0..cursor.count(count, 2 * (extents + 2), 4 + 8 * (extents + 1))? {
            let tag = cursor.integer()?;
            for _ in 0..extents {
                cursor.real()?;
            }
            let physical = tags(cursor)?;
            if dimension > 0 {
                tags(cursor)?;
            }
            builder.entities.insert((dimension as i64, tag), physical);
        }
    }
    Ok(())
}

fn tags(cursor: &mut Cursor<'_>) -> Result<Vec<i64>, GmshError> {
    let count = cursor.long()?;
    (0..cursor.count(count, 2, 4)?).map(|_| cursor.integer()).collect()
}

/// Counts of blocks and nodes, least and greatest number; blocks of one entity: its dimension and number,
/// whether parameters follow the positions, the count, all numbers, then all positions.
pub(super) fn nodes(cursor: &mut Cursor<'_>, builder: &mut Builder) -> Result<(), GmshError> {
    let blocks = cursor.long()?;
    for _ in 0..3 {
        cursor.long()?;
    }
    for _ in 0..cursor.count(blocks, 8, 20)? {
        let dimension = cursor.integer()?;
        cursor.integer()?;
        let parametric = cursor.integer()? != 0;
        let count = cursor.long()?;
        let count = cursor.count(count, 8, 32)?;
        let numbers = (0..count).map(|_| cursor.long()).collect::<Result<Vec<_>, _>>()?;
        for tag in numbers {
            let position = cursor.position()?;
            for _ in 0..if parametric { dimension } else { 0 } {
                cursor.real()?;
            }
            builder.node(cursor, tag, position)?;
        }
    }
    Ok(())
}

/// Counts of blocks and elements, least and greatest number; blocks of one entity: its dimension and number,
/// the element type, the count, then `number nodes` each.
pub(super) fn elements(cursor: &mut Cursor<'_>, builder: &mut Builder) -> Result<(), GmshError> {
    let blocks = cursor.long()?;
    for _ in 0..3 {
        cursor.long()?;
    }
    for _ in 0..cursor.count(blocks, 8, 20)? {
        let entity = (cursor.integer()?, cursor.integer()?);
        let number = cursor.integer()?;
        let kind = CellKind::from_number(number).or_else(|why| cursor.fail(why))?;
        let count = cursor.long()?;
        let count = cursor.count(count, 4, 16)?;
        let membership = builder.membership(builder.entities.get(&entity).cloned().unwrap_or_default());
        for _ in 0..count {
            let own = cursor.long()?;
            builder.cell(cursor, (kind, own), membership, Cursor::long)?;
        }
    }
    Ok(())
}
