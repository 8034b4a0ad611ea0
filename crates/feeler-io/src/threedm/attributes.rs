//! What surrounds the geometry: names, layers, units.

use super::archive::{ANONYMOUS, Archive, Chunk};
use super::class;
use crate::error::{Problem, ReadError};
use crate::units::Units;

/// What is used of an object's attributes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Attributes {
    pub(super) name: String,
    pub(super) layer: Option<i32>,
    pub(super) block_member: bool,
    pub(super) hidden: bool,
    pub(super) locked: bool,
    pub(super) id: [u8; 16],
}

impl Attributes {
    /// The low 4 bits say what the object is to its model.
    fn mode(&mut self, mode: u8) {
        self.hidden |= mode & 15 == MODE_HIDDEN;
        self.locked = mode & 15 == MODE_LOCKED;
        self.block_member = mode & 15 == MODE_BLOCK_MEMBER;
    }
}

/// A layer's name and what it does to its objects. That of its parents, to which newer files nest layers, is not looked at.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Layer {
    pub(super) name: String,
    pub(super) hidden: bool,
    pub(super) locked: bool,
}

const MODE_HIDDEN: u8 = 1;
const MODE_LOCKED: u8 = 2;

/// The mode (low 4 bits) of an object that is part of a block's definition.
const MODE_BLOCK_MEMBER: u8 = 3;

/// The first version of the library that writes attributes as numbered items.
const NUMBERED_ITEMS_SINCE: u32 = 200_712_190;

/// An object's attributes.
pub(super) fn attributes(mut data: Chunk<'_>) -> Result<Attributes, ReadError> {
    let Archive {
        version, opennurbs, ..
    } = data.archive;
    let result = if version >= 5 && opennurbs >= NUMBERED_ITEMS_SINCE {
        numbered(&mut data)?
    } else {
        fixed(&mut data)?
    };
    data.finish()?;
    Ok(result)
}

/// Layout 1.x: fields in a fixed order.
fn fixed(data: &mut Chunk<'_>) -> Result<Attributes, ReadError> {
    class::layout(data, "object attributes", &[1], super::curves::REMEDY)?;
    let id = data.uuid()?;
    let layer = data.i32("a layer")?;
    // Material and colour, then line style: two i16, two f64; then wire density.
    data.skip(4 + 4 + 2 * 2 + 2 * 8 + 4, "attributes")?;
    let mode = data.u8("an object's mode")?;
    data.skip(3, "attributes")?;
    let name = data.string("an object's name")?;
    let mut result = Attributes {
        name,
        layer: Some(layer),
        id,
        ..Attributes::default()
    };
    result.mode(mode);
    Ok(result)
}

/// Layout 2.x: items in the order of their numbers, each only if it differs from the default. The mode
/// is the last one of interest.
fn numbered(data: &mut Chunk<'_>) -> Result<Attributes, ReadError> {
    class::layout(data, "object attributes", &[2], super::curves::REMEDY)?;
    let mut result = Attributes {
        id: data.uuid()?,
        layer: Some(data.i32("a layer")?),
        ..Attributes::default()
    };
    loop {
        match data.u8("an attribute's number")? {
            1 => result.name = data.string("an object's name")?,
            2 => {
                data.string("an object's address")?;
            }
            3 | 4 | 6 | 7 | 10 => data.skip(4, "an attribute")?,
            5 => {
                data.expect(ANONYMOUS, "rendering attributes")?;
            }
            8 => data.skip(8, "an attribute")?,
            9 => data.skip(1, "an attribute")?,
            11 => result.hidden = data.u8("whether an object is visible")? == 0,
            12 => {
                let mode = data.u8("an object's mode")?;
                result.mode(mode);
                return Ok(result);
            }
            _ => return Ok(result),
        }
    }
}

/// The index of the layer in a layer record, and what is used of it.
pub(super) fn layer(record: &mut Chunk<'_>) -> Result<(i32, Layer), ReadError> {
    let (_, mut data) = class::object(record)?;
    let (_, minor) = class::layout(&mut data, "layer", &[1], super::curves::REMEDY)?;
    let mode = data.i32("a layer's mode")?;
    let index = data.i32("a layer's index")?;
    // Two levels and a material, a number no longer used, a colour, a line style: two i16 and two f64.
    data.skip(3 * 4 + 4 + 2 * 2 + 2 * 8, "a layer's fields")?;
    let mut layer = Layer {
        name: data.string("a layer's name")?,
        hidden: mode == i32::from(MODE_HIDDEN),
        locked: mode == i32::from(MODE_LOCKED),
    };
    if minor >= 1 {
        layer.hidden = data.u8("whether a layer is visible")? == 0;
    }
    if minor >= 4 {
        // A line pattern, a colour and a width.
        data.skip(4 + 4 + 8, "a layer's fields")?;
        layer.locked = data.u8("whether a layer is locked")? != 0;
    }
    data.finish()?;
    Ok((index, layer))
}

/// Units and the tolerance the model was made with, in these units.
pub(super) fn units(mut data: Chunk<'_>) -> Result<(Units, Option<f64>), ReadError> {
    let at = data.position();
    let version = data.i32("the layout version")?;
    if !(100..200).contains(&version) {
        return Err(data.fail_at(
            at,
            Problem::Value {
                what: "the layout version of the units".into(),
                found: version.to_string(),
                expected: "100 to 199".into(),
            },
        ));
    }
    let mut units = Units::from_code(data.i32("the unit")?);
    let tolerance = data.optional_f64("the absolute tolerance")?;
    data.f64s::<2>("angle and relative tolerance")?;
    if version >= 101 {
        data.skip(2 * size_of::<i32>(), "display mode and precision")?;
    }
    if version >= 102 {
        let metres = data.optional_f64("metres per unit")?;
        let name = data.string("the unit's name")?;
        if let Units::Custom { .. } = units {
            units = Units::Custom { name, metres };
        }
    }
    data.finish()?;
    Ok((units, tolerance))
}
