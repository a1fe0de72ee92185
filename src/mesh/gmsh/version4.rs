//! Sections of version 4.1.

use super::cursor::{Cursor, GmshError};
use super::{Builder, CellKind};

/// Counts of points, curves, surfaces and volumes; then each entity with its physical tags.
pub(super) fn entities<const MOST_NODES: usize>(
    cursor: &mut Cursor<'_>,
    builder: &mut Builder<MOST_NODES>,
) -> Result<(), GmshError> {
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

/// Counts in the first line of a section, compared with the lines that follow.
struct Promise {
    /// The name of the counted items.
    what: &'static str,
    blocks: usize,
    total: i64,
    least: i64,
    greatest: i64,
    found: i64,
}

impl Promise {
    /// Counts of blocks and of all entries, least and greatest number.
    fn read(cursor: &mut Cursor<'_>, what: &'static str) -> Result<Self, GmshError> {
        let blocks = cursor.long()?;
        let (total, least, greatest) = (cursor.long()?, cursor.long()?, cursor.long()?);
        Ok(Self { what, blocks: cursor.count(blocks, 8, 20)?, total, least, greatest, found: 0 })
    }

    fn count(&mut self, cursor: &Cursor<'_>, number: i64) -> Result<(), GmshError> {
        self.found += 1;
        let Self { what, least, greatest, .. } = self;
        if (*least..=*greatest).contains(&number) {
            return Ok(());
        }
        cursor.fail(format!("{what} {number} is there, where the section promises numbers from {least} to {greatest}"))
    }

    fn keep(&self, cursor: &Cursor<'_>) -> Result<(), GmshError> {
        let Self { what, total, found, .. } = self;
        if total == found {
            return Ok(());
        }
        cursor.fail(format!("the section promises {total} {what}s, and has {found}"))
    }
}

/// The dimension and the number of the entity that a block belongs to.
fn entity(cursor: &mut Cursor<'_>) -> Result<(i64, i64), GmshError> {
    let entity = (cursor.integer()?, cursor.integer()?);
    if (0..=3).contains(&entity.0) {
        return Ok(entity);
    }
    cursor.fail(format!("an entity has dimension 0 to 3, not {}", entity.0))
}

/// Counts of blocks and nodes, least and greatest number; blocks of one entity: its dimension and number,
/// whether parameters follow the positions, the count, all numbers, then all positions.
pub(super) fn nodes<const MOST_NODES: usize>(
    cursor: &mut Cursor<'_>,
    builder: &mut Builder<MOST_NODES>,
) -> Result<(), GmshError> {
    let mut promise = Promise::read(cursor, "node")?;
    for _ in 0..promise.blocks {
        let (dimension, _) = entity(cursor)?;
        let parametric = match cursor.integer()? {
            0 => false,
            1 => true,
            other => return cursor.fail(format!("nodes have parameters (1) or not (0), not {other}")),
        };
        let count = cursor.long()?;
        let count = cursor.count(count, 8, 32)?;
        let numbers = (0..count).map(|_| cursor.long()).collect::<Result<Vec<_>, _>>()?;
        for tag in numbers {
            promise.count(cursor, tag)?;
            let position = cursor.position()?;
            for _ in 0..if parametric { dimension } else { 0 } {
                cursor.real()?;
            }
            builder.node(cursor, tag, position)?;
        }
    }
    promise.keep(cursor)
}

/// Counts of blocks and elements, least and greatest number; blocks of one entity: its dimension and number,
/// the element type, the count, then `number nodes` each.
pub(super) fn elements<const MOST_NODES: usize>(
    cursor: &mut Cursor<'_>,
    builder: &mut Builder<MOST_NODES>,
) -> Result<(), GmshError> {
    let mut promise = Promise::read(cursor, "element")?;
    for _ in 0..promise.blocks {
        let entity = entity(cursor)?;
        if !(builder.entities.is_empty() || builder.entities.contains_key(&entity)) {
            let (dimension, number) = entity;
            return cursor.fail(format!("entity {number} of dimension {dimension} is not in $Entities"));
        }
        let number = cursor.integer()?;
        let kind = CellKind::from_number(number, builder.order).or_else(|why| cursor.fail(why))?;
        if kind.dimension() as i64 != entity.0 {
            let (own, of) = (kind.dimension(), entity.0);
            return cursor.fail(format!("elements of dimension {own} in a block of dimension {of}"));
        }
        let count = cursor.long()?;
        let count = cursor.count(count, 4, 16)?;
        let membership = builder.membership(builder.entities.get(&entity).cloned().unwrap_or_default());
        for _ in 0..count {
            let own = cursor.long()?;
            promise.count(cursor, own)?;
            builder.cell(cursor, kind, own, membership, Cursor::long)?;
        }
    }
    promise.keep(cursor)
}
