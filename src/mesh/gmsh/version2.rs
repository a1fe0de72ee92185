//! Sections of version 2.2.

use super::cursor::{Cursor, GmshError};
use super::{Builder, CellKind, ElementOrder};

/// `count`, then `number x y z` each.
pub(super) fn nodes<const MOST_NODES: usize>(
    cursor: &mut Cursor<'_>,
    builder: &mut Builder<MOST_NODES>,
) -> Result<(), GmshError> {
    let count = cursor.text_integer()?;
    cursor.end_line();
    for _ in 0..cursor.count(count, 8, 28)? {
        let tag = cursor.integer()?;
        let position = cursor.position()?;
        builder.node(cursor, tag, position)?;
    }
    Ok(())
}

/// `count`, then in text `number type tag-count tags nodes` each; in binary blocks of one type and one count
/// of tags: `type element-count tag-count`, then `number tags nodes` each.
pub(super) fn elements<const MOST_NODES: usize>(
    cursor: &mut Cursor<'_>,
    builder: &mut Builder<MOST_NODES>,
) -> Result<(), GmshError> {
    let count = cursor.text_integer()?;
    cursor.end_line();
    let mut left = cursor.count(count, 6, 8)?;
    while left > 0 {
        let (block, kind, tags);
        let mut own = 0;
        if cursor.is_binary() {
            kind = self::kind(cursor, builder.order)?;
            let size = cursor.integer()?;
            block = cursor.checked_count(size, 8)?;
            tags = cursor.integer()?;
            if block == 0 || block > left {
                return cursor.fail(format!("a block of {block} elements where {left} are left"));
            }
        } else {
            own = cursor.integer()?;
            kind = self::kind(cursor, builder.order)?;
            block = 1;
            tags = cursor.integer()?;
        }
        let tags = cursor.count(tags, 2, 4)?;
        for _ in 0..block {
            if cursor.is_binary() {
                own = cursor.integer()?;
            }
            element(cursor, builder, kind, own, tags)?;
        }
        left -= block;
    }
    Ok(())
}

fn kind(cursor: &mut Cursor<'_>, order: ElementOrder) -> Result<CellKind, GmshError> {
    let number = cursor.integer()?;
    CellKind::from_number(number, order).or_else(|why| cursor.fail(why))
}

/// An element of a kind, with its number. The first tag is the physical group; 0 means none.
fn element<const MOST_NODES: usize>(
    cursor: &mut Cursor<'_>,
    builder: &mut Builder<MOST_NODES>,
    kind: CellKind,
    own: i64,
    tags: usize,
) -> Result<(), GmshError> {
    let mut physical = 0;
    for place in 0..tags {
        let tag = cursor.integer()?;
        if place == 0 {
            physical = tag;
        }
    }
    let membership = builder.membership(if physical == 0 { Vec::new() } else { vec![physical] });
    builder.cell(cursor, kind, own, membership, Cursor::integer)
}
