//! Class ids, and the wrapper around the data of an object.

use super::archive::Chunk;
use crate::error::{Problem, ReadError};
use std::fmt::Write;

const OBJECT: u32 = 0x0002_7FFA;
const CLASS_ID: u32 = 0x0002_FFFB;
const CLASS_DATA: u32 = 0x0002_FFFC;

/// What an object's class id says it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    LineCurve,
    ArcCurve,
    PolylineCurve,
    NurbsCurve,
    PolyCurve,
    CurveOnSurface,
    PlaneSurface,
    RevSurface,
    SumSurface,
    NurbsSurface,
    Brep,
    Extrusion,
    Mesh,
    InstanceRef,
    Other([u8; 16]),
}

/// The id's fields in the order in which they are printed; stored little-endian, the rest as is.
const fn id(a: u32, b: u16, c: u16, rest: [u8; 8]) -> [u8; 16] {
    let (a, b, c) = (a.to_le_bytes(), b.to_le_bytes(), c.to_le_bytes());
    let [r0, r1, r2, r3, r4, r5, r6, r7] = rest;
    [
        a[0], a[1], a[2], a[3], b[0], b[1], c[0], c[1], r0, r1, r2, r3, r4, r5, r6, r7,
    ]
}

/// An id that ends in `xxxx-0010830122F0`, as most do.
const fn common(a: u32, b: u16, c: u16, node: u16) -> [u8; 16] {
    let [n0, n1] = node.to_be_bytes();
    id(a, b, c, [n0, n1, 0x00, 0x10, 0x83, 0x01, 0x22, 0xF0])
}

/// Every id that is known, with the aliases that older programs wrote.
const IDS: &[([u8; 16], Class)] = &[
    (
        common(0x4ED7_D4DB, 0xE947, 0x11D3, 0xBFE5),
        Class::LineCurve,
    ),
    (common(0xCF33_BE2A, 0x09B4, 0x11D4, 0xBFFB), Class::ArcCurve),
    (
        common(0x4ED7_D4E6, 0xE947, 0x11D3, 0xBFE5),
        Class::PolylineCurve,
    ),
    (
        common(0x4ED7_D4DD, 0xE947, 0x11D3, 0xBFE5),
        Class::NurbsCurve,
    ),
    (
        common(0x5EAF_1119, 0x0B51, 0x11D4, 0xBFFE),
        Class::NurbsCurve,
    ),
    (
        common(0x76A7_09D5, 0x1550, 0x11D4, 0x8000),
        Class::NurbsCurve,
    ),
    (
        common(0x4ED7_D4E0, 0xE947, 0x11D3, 0xBFE5),
        Class::PolyCurve,
    ),
    (
        common(0xEF63_8317, 0x154B, 0x11D4, 0x8000),
        Class::PolyCurve,
    ),
    (
        common(0x4ED7_D4D8, 0xE947, 0x11D3, 0xBFE5),
        Class::CurveOnSurface,
    ),
    (
        common(0x4ED7_D4DF, 0xE947, 0x11D3, 0xBFE5),
        Class::PlaneSurface,
    ),
    (
        common(0xA162_20D3, 0x163B, 0x11D4, 0x8000),
        Class::RevSurface,
    ),
    (
        id(
            0x0A84_01B6,
            0x4D34,
            0x4B99,
            [0x86, 0x15, 0x1B, 0x4E, 0x72, 0x3D, 0xC4, 0xE5],
        ),
        Class::RevSurface,
    ),
    (
        id(
            0xC4CD_5359,
            0x446D,
            0x4690,
            [0x9F, 0xF5, 0x29, 0x05, 0x97, 0x32, 0x47, 0x2B],
        ),
        Class::SumSurface,
    ),
    (
        id(
            0x665F_6331,
            0x2A66,
            0x4CCE,
            [0x81, 0xD0, 0xB5, 0xEE, 0xBD, 0x9B, 0x54, 0x17],
        ),
        Class::SumSurface,
    ),
    (
        common(0x4ED7_D4DE, 0xE947, 0x11D3, 0xBFE5),
        Class::NurbsSurface,
    ),
    (
        common(0x4760_C817, 0x0BE3, 0x11D4, 0xBFFE),
        Class::NurbsSurface,
    ),
    (
        common(0xFA4F_D4B5, 0x1613, 0x11D4, 0x8000),
        Class::NurbsSurface,
    ),
    (common(0x60B5_DBC5, 0xE660, 0x11D3, 0xBFE4), Class::Brep),
    (common(0x0705_FDEF, 0x3E2A, 0x11D4, 0x800E), Class::Brep),
    (common(0x2D4C_FEDB, 0x3E2A, 0x11D4, 0x800E), Class::Brep),
    (
        id(
            0xF06F_C243,
            0xA32A,
            0x4608,
            [0x9D, 0xD8, 0xA7, 0xD2, 0xC4, 0xCE, 0x2A, 0x36],
        ),
        Class::Brep,
    ),
    (
        id(
            0x36F5_3175,
            0x72B8,
            0x4D47,
            [0xBF, 0x1F, 0xB4, 0xE6, 0xFC, 0x24, 0xF4, 0xB9],
        ),
        Class::Extrusion,
    ),
    (common(0x4ED7_D4E4, 0xE947, 0x11D3, 0xBFE5), Class::Mesh),
    (
        id(
            0xF9CF_B638,
            0xB9D4,
            0x4340,
            [0x87, 0xE3, 0xC5, 0x6E, 0x78, 0x65, 0xD9, 0x6A],
        ),
        Class::InstanceRef,
    ),
];

/// Classes that are read no further, by OpenNURBS's own names of them.
const NAMED: &[([u8; 16], &str)] = &[
    (
        id(
            0xC8C6_6EFA,
            0xB3CB,
            0x4E00,
            [0x94, 0x40, 0x2A, 0xD6, 0x62, 0x03, 0x37, 0x9E],
        ),
        "detail view",
    ),
    (
        id(
            0xDBC5_A584,
            0xCE3F,
            0x4170,
            [0x98, 0xA8, 0x49, 0x70, 0x69, 0xCA, 0x5C, 0x36],
        ),
        "clipping plane",
    ),
    (
        id(
            0x0693_6AFB,
            0x3D3C,
            0x41AC,
            [0xBF, 0x70, 0xC9, 0x31, 0x9F, 0xA4, 0x80, 0xA1],
        ),
        "cage",
    ),
    (
        id(
            0xD379_E6D8,
            0x7C31,
            0x4407,
            [0xA9, 0x13, 0xE3, 0xB7, 0x04, 0x0D, 0x03, 0x4A],
        ),
        "morph control",
    ),
];

impl Class {
    fn of(id: [u8; 16]) -> Self {
        let known = IDS.iter().find(|(known, _)| *known == id);
        known.map_or(Self::Other(id), |(_, class)| *class)
    }

    /// The class's name; for an unknown one its id.
    pub(super) fn name(&self) -> String {
        match self {
            Self::LineCurve => "LineCurve",
            Self::ArcCurve => "ArcCurve",
            Self::PolylineCurve => "PolylineCurve",
            Self::NurbsCurve => "NurbsCurve",
            Self::PolyCurve => "PolyCurve",
            Self::CurveOnSurface => "CurveOnSurface",
            Self::PlaneSurface => "PlaneSurface",
            Self::RevSurface => "RevSurface",
            Self::SumSurface => "SumSurface",
            Self::NurbsSurface => "NurbsSurface",
            Self::Brep => "Brep",
            Self::Extrusion => "Extrusion",
            Self::Mesh => "Mesh",
            Self::InstanceRef => "InstanceRef",
            Self::Other(id) => {
                if let Some((_, name)) = NAMED.iter().find(|(known, _)| known == id) {
                    return (*name).into();
                }
                // The first three fields are stored little-endian.
                const PRINTED: [usize; 16] = [3, 2, 1, 0, 5, 4, 7, 6, 8, 9, 10, 11, 12, 13, 14, 15];
                let mut text = String::from("class ");
                for (i, from) in PRINTED.into_iter().enumerate() {
                    if matches!(i, 4 | 6 | 8 | 10) {
                        text.push('-');
                    }
                    let _ = write!(text, "{:02X}", id[from]);
                }
                return text;
            }
        }
        .into()
    }
}

/// The class and the data of the object that is the next chunk of `parent`. User data that
/// follows the class data is left alone.
pub(super) fn object<'a>(parent: &mut Chunk<'a>) -> Result<(Class, Chunk<'a>), ReadError> {
    let wrapper = parent.expect(OBJECT, "an object")?;
    object_in(wrapper)
}

/// The same when the object's own chunk is at hand.
pub(super) fn object_in(mut wrapper: Chunk<'_>) -> Result<(Class, Chunk<'_>), ReadError> {
    let mut id = wrapper.expect(CLASS_ID, "a class id")?;
    let class = Class::of(id.uuid()?);
    id.finish()?;
    Ok((class, wrapper.expect(CLASS_DATA, "class data")?))
}

/// Reads the layout version, which must have this major version.
pub(super) fn layout(
    data: &mut Chunk<'_>,
    class: &'static str,
    majors: &[u8],
    remedy: &'static str,
) -> Result<(u8, u8), ReadError> {
    let at = data.position();
    let (major, minor) = data.layout()?;
    if majors.contains(&major) {
        return Ok((major, minor));
    }
    Err(data.fail_at(
        at,
        Problem::Layout {
            class,
            major,
            minor,
            remedy,
        },
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_named() {
        let detail = id(
            0xC8C6_6EFA,
            0xB3CB,
            0x4E00,
            [0x94, 0x40, 0x2A, 0xD6, 0x62, 0x03, 0x37, 0x9E],
        );
        assert_eq!(Class::of(detail).name(), "detail view");
        let unknown = id(1, 2, 3, [4; 8]);
        let text = "class 00000001-0002-0003-0404-040404040404";
        assert_eq!(Class::of(unknown).name(), text);
        for (i, (id, name)) in NAMED.iter().enumerate() {
            assert!(IDS.iter().all(|(known, _)| known != id), "{name}");
            assert!(NAMED[..i].iter().all(|(known, _)| known != id), "{name}");
        }
    }
}
