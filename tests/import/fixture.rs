//! Writes small .3dm files byte by byte.

use crc32fast::Hasher;
use std::cell::Cell;

pub(crate) const ANONYMOUS: u32 = 0x4000_8000;
pub(crate) const UNSET: f64 = -1.234_321_012_343_21e308;

thread_local! {
    /// How many numbers have been written, and the one to replace.
    static COUNT: Cell<usize> = const { Cell::new(0) };
    static WILD: Cell<Option<(usize, (i32, f64))>> = const { Cell::new(None) };
    /// Whether objects are written with user data.
    static USER_DATA: Cell<bool> = const { Cell::new(false) };
}

/// What the next number is to be replaced with.
fn wild() -> Option<(i32, f64)> {
    let at = COUNT.get();
    COUNT.set(at + 1);
    WILD.get()
        .filter(|(place, _)| *place == at)
        .map(|(_, wild)| wild)
}

/// The bytes that `write` makes with its number `place` (an i32 or an f64) replaced, checksums
/// correct; `None` if it writes fewer.
pub(crate) fn with_wild(
    place: usize,
    value: (i32, f64),
    write: impl FnOnce() -> Vec<u8>,
) -> Option<Vec<u8>> {
    COUNT.set(0);
    WILD.set(Some((place, value)));
    let bytes = write();
    WILD.set(None);
    (place < COUNT.get()).then_some(bytes)
}

/// What `write` makes where each object, those within others too, carries what a plug-in attached to it.
pub(crate) fn with_user_data<T>(write: impl FnOnce() -> T) -> T {
    USER_DATA.set(true);
    let made = write();
    USER_DATA.set(false);
    made
}

/// The bytes of one chunk's body, and the checksum of those that are its own.
pub(crate) struct Writer {
    wide: bool,
    pub(crate) bytes: Vec<u8>,
    own: Hasher,
}

impl Writer {
    fn new(wide: bool) -> Self {
        Self {
            wide,
            bytes: Vec::new(),
            own: Hasher::new(),
        }
    }

    pub(crate) fn raw(&mut self, bytes: &[u8]) {
        self.bytes.extend(bytes);
        self.own.update(bytes);
    }

    pub(crate) fn u8(&mut self, x: u8) {
        self.raw(&[x]);
    }

    pub(crate) fn i32s(&mut self, all: &[i32]) {
        for x in all {
            let wild = wild().map(|w| w.0);
            self.raw(&wild.unwrap_or(*x).to_le_bytes());
        }
    }

    pub(crate) fn f64s(&mut self, all: &[f64]) {
        for x in all {
            let wild = wild().map(|w| w.1);
            self.raw(&wild.unwrap_or(*x).to_le_bytes());
        }
    }

    /// A count and the items.
    pub(crate) fn i32_array(&mut self, all: &[i32]) {
        self.i32s(&[all.len() as i32]);
        self.i32s(all);
    }

    pub(crate) fn f64_array(&mut self, all: &[f64]) {
        self.i32s(&[all.len() as i32]);
        self.f64s(all);
    }

    fn string(&mut self, text: &str) {
        let units: Vec<u16> = text.encode_utf16().chain([0]).collect();
        self.i32s(&[units.len() as i32]);
        units.iter().for_each(|x| self.raw(&x.to_le_bytes()));
    }

    /// Chunk headers are nobody's own bytes.
    fn header(&mut self, typecode: u32, value: i64) {
        self.bytes.extend(typecode.to_le_bytes());
        if self.wide {
            self.bytes.extend(value.to_le_bytes());
        } else {
            self.bytes.extend((value as i32).to_le_bytes());
        }
    }

    pub(crate) fn short(&mut self, typecode: u32, value: i64) {
        self.header(typecode, value);
    }

    pub(crate) fn chunk(&mut self, typecode: u32, body: impl FnOnce(&mut Writer)) {
        let mut inner = Writer::new(self.wide);
        body(&mut inner);
        if typecode & 0x8000 != 0 {
            let crc = inner.own.finalize();
            inner.bytes.extend(crc.to_le_bytes());
        }
        self.header(typecode, inner.bytes.len() as i64);
        self.bytes.extend(inner.bytes);
    }

    /// An object of the class with this id (as printed).
    pub(crate) fn object(&mut self, id: &str, data: impl FnOnce(&mut Writer)) {
        self.chunk(0x0002_7FFA, |w| {
            w.chunk(0x0002_FFFB, |w| w.raw(&uuid(id)));
            w.chunk(0x0002_FFFC, data);
            if USER_DATA.get() {
                w.user_data(b"of a plug-in that nobody has");
                w.user_data(&[]);
            }
            w.short(0x8002_7FFF, 0);
        });
    }

    /// User data, as `ON_BinaryArchive::WriteObjectUserData` of openNURBS lays it out (version 2.2).
    fn user_data(&mut self, data: &[u8]) {
        self.chunk(0x0002_7FFD, |w| {
            w.u8(0x22);
            w.chunk(0x0002_FFF9, |w| {
                // Its class, which item it is, how often it was copied, where it was moved, whose it is.
                w.raw(&[0xAB; 16]);
                w.raw(&[0xCD; 16]);
                w.raw(&1_i32.to_le_bytes());
                for k in 0..16 {
                    let one = f64::from(u8::from(k % 5 == 0));
                    w.raw(&one.to_le_bytes());
                }
                w.raw(&[0xEF; 16]);
                // Of a class that was known, and the versions that wrote it.
                w.u8(0);
                w.raw(&[0; 8]);
            });
            w.chunk(ANONYMOUS, |w| w.raw(data));
        });
    }

    /// The record of an object in the object table.
    pub(crate) fn record(&mut self, name: &str, id: &str, data: impl FnOnce(&mut Writer)) {
        let numbered = self.wide;
        self.chunk(0x2000_8070, |w| {
            w.short(0x8200_0071, 0);
            w.object(id, data);
            w.chunk(0x0200_8072, |w| {
                if numbered {
                    w.u8(0x20);
                    w.raw(&[7; 16]);
                    w.i32s(&[0]);
                    w.u8(1);
                    w.string(name);
                    w.u8(0);
                } else {
                    w.u8(0x10);
                    w.raw(&[7; 16]);
                    w.i32s(&[0, -1]);
                    w.raw(&[0; 8]);
                    w.f64s(&[0.0, 1.0]);
                    w.i32s(&[1]);
                    w.raw(&[0; 4]);
                    w.string(name);
                    w.string("");
                }
            });
            w.short(0x8200_007F, 0);
        });
    }
}

/// A class id in the order in which it is stored: the first three fields little-endian.
fn uuid(printed: &str) -> [u8; 16] {
    let hex: Vec<u8> = printed
        .bytes()
        .filter(|b| *b != b'-')
        .map(|b| (b as char).to_digit(16).expect("a hex digit") as u8)
        .collect();
    let mut id: [u8; 16] = std::array::from_fn(|i| hex[2 * i] << 4 | hex[2 * i + 1]);
    id[..4].reverse();
    id[4..6].reverse();
    id[6..8].reverse();
    id
}

/// A file of this version with these records in its object table.
pub(crate) fn file(version: u32, records: impl FnOnce(&mut Writer)) -> Vec<u8> {
    file_with(version, |_| {}, records)
}

/// A file of version 50 of blocks, each of which holds two references to the next, as it is and shifted along x by a power of two; the last holds a BREP.
/// The model has two references to the first: it unfolds to `2^levels` copies. In a ring the last holds one to the first instead. Shifted references are on
/// a hidden layer.
pub(crate) fn nested_blocks(levels: u8, is_ring: bool) -> Vec<u8> {
    const MEMBER: u8 = 3;
    let id = |kind: u8, n: u8| {
        let mut id = [kind; 16];
        id[0] = n;
        id
    };
    let record =
        |w: &mut Writer, own: [u8; 16], mode: u8, class: &str, data: &dyn Fn(&mut Writer)| {
            let is_shifted = own == id(2, own[0]);
            w.chunk(0x2000_8070, |w| {
                w.short(0x8200_0071, 0);
                w.object(class, data);
                w.chunk(0x0200_8072, |w| {
                    w.u8(0x20);
                    w.raw(&own);
                    w.i32s(&[i32::from(is_shifted)]);
                    w.raw(&[12, mode, 0]);
                });
                w.short(0x8200_007F, 0);
            });
        };
    let references = |w: &mut Writer, level: u8, mode: u8| {
        for (kind, shift) in [(1, 0.0), (2, f64::from(1 << level))] {
            record(w, id(kind, level), mode, INSTANCE_REFERENCE, &|w| {
                w.u8(0x10);
                w.raw(&id(3, level));
                for k in 0..16 {
                    let one = f64::from(u8::from(k % 5 == 0));
                    w.f64s(&[if k == 3 { shift } else { one }]);
                }
                // A box.
                w.f64s(&[0.0; 6]);
            });
        }
    };
    let definitions = |w: &mut Writer| {
        w.chunk(0x1000_0021, |w| {
            for level in 0..levels {
                let members = match level + 1 {
                    next if next == levels && is_ring => vec![id(1, 0)],
                    next if next == levels => vec![id(4, 0)],
                    next => vec![id(1, next), id(2, next)],
                };
                w.chunk(0x2000_8076, |w| {
                    w.object(INSTANCE_DEFINITION, |w| {
                        w.u8(0x10);
                        w.raw(&id(3, level));
                        w.i32s(&[members.len() as i32]);
                        members.iter().for_each(|m| w.raw(m));
                        for _ in 0..4 {
                            w.i32s(&[0]);
                        }
                        w.f64s(&[0.0; 6]);
                        w.i32s(&[0, 0]);
                    });
                });
            }
            w.short(0xFFFF_FFFF, 0);
        });
    };
    let tables = |w: &mut Writer| {
        w.chunk(0x1000_0011, |w| {
            layer(w, 0, "as they are", true);
            layer(w, 1, "shifted", false);
            w.short(0xFFFF_FFFF, 0);
        });
        definitions(w);
    };
    file_with(50, tables, |w| {
        for level in 0..levels {
            references(w, level, if level == 0 { 0 } else { MEMBER });
        }
        record(w, id(4, 0), MEMBER, BREP, &brep);
    })
}

/// A layer's record, as `ON_Layer::Write` of openNURBS lays it out (version 1.1).
fn layer(w: &mut Writer, index: i32, name: &str, is_visible: bool) {
    w.chunk(0x2000_8050, |w| {
        w.object(LAYER, |w| {
            w.u8(0x11);
            // Its mode, and three numbers that say nothing here.
            w.i32s(&[0, index, 0, -1, 0]);
            // A colour, a line style.
            w.raw(&[0; 4 + 4 + 16]);
            w.string(name);
            w.u8(u8::from(is_visible));
        });
    });
}

const LAYER: &str = "95809813-E985-11D3-BFE5-0010830122F0";
const INSTANCE_REFERENCE: &str = "F9CFB638-B9D4-4340-87E3-C56E7865D96A";
const INSTANCE_DEFINITION: &str = "26F8BFF6-2618-417F-A158-153D64A94989";

/// A file with tables before that of its objects.
fn file_with(
    version: u32,
    tables: impl FnOnce(&mut Writer),
    records: impl FnOnce(&mut Writer),
) -> Vec<u8> {
    let opennurbs = match version {
        3..=5 => 200_710_174,
        50 => 201_101_285,
        60 => 2_348_834_708,
        70 => 2_382_393_748,
        _ => 2_415_950_832,
    };
    let mut w = Writer::new(version >= 50);
    w.raw(format!("3D Geometry File Format {version:>8}").as_bytes());
    w.chunk(1, |w| w.raw(b"made up by a test\0"));
    w.chunk(0x1000_0014, |w| {
        w.short(0xA000_0026, opennurbs);
        w.short(0xFFFF_FFFF, 0);
    });
    w.chunk(0x1000_0015, |w| {
        w.chunk(0x2000_8031, |w| {
            w.i32s(&[100, 2]);
            w.f64s(&[0.001, 0.017, 0.01]);
        });
        w.short(0xFFFF_FFFF, 0);
    });
    tables(&mut w);
    w.chunk(0x1000_0013, |w| {
        records(w);
        w.short(0xFFFF_FFFF, 0);
    });
    if version >= 4 {
        // The table of history records: other readers ask for it.
        w.chunk(0x1000_0026, |w| w.short(0xFFFF_FFFF, 0));
    }
    let size = w.bytes.len() as u64;
    if version >= 50 {
        w.chunk(0x7FFF, |w| w.raw(&(size + 20).to_le_bytes()));
    } else {
        w.chunk(0x7FFF, |w| w.raw(&(size as u32 + 12).to_le_bytes()));
    }
    w.bytes
}

/// Ends that most ids share.
macro_rules! common {
    ($start:literal) => {
        concat!($start, "-0010830122F0")
    };
}

pub(crate) const LINE: &str = common!("4ED7D4DB-E947-11D3-BFE5");
pub(crate) const ARC: &str = common!("CF33BE2A-09B4-11D4-BFFB");
pub(crate) const POLYLINE: &str = common!("4ED7D4E6-E947-11D3-BFE5");
pub(crate) const NURBS_CURVE: &str = common!("4ED7D4DD-E947-11D3-BFE5");
pub(crate) const NURBS_CURVE_ALIASES: [&str; 2] = [
    common!("5EAF1119-0B51-11D4-BFFE"),
    common!("76A709D5-1550-11D4-8000"),
];
pub(crate) const POLY_CURVE: &str = common!("4ED7D4E0-E947-11D3-BFE5");
pub(crate) const POLY_CURVE_ALIAS: &str = common!("EF638317-154B-11D4-8000");
pub(crate) const CURVE_ON_SURFACE: &str = common!("4ED7D4D8-E947-11D3-BFE5");
pub(crate) const PLANE: &str = common!("4ED7D4DF-E947-11D3-BFE5");
pub(crate) const REV: &str = common!("A16220D3-163B-11D4-8000");
pub(crate) const REV_ALIAS: &str = "0A8401B6-4D34-4B99-8615-1B4E723DC4E5";
pub(crate) const EXTRUSION: &str = "36F53175-72B8-4D47-BF1F-B4E6FC24F4B9";
pub(crate) const SUM: &str = "C4CD5359-446D-4690-9FF5-29059732472B";
pub(crate) const SUM_ALIAS: &str = "665F6331-2A66-4CCE-81D0-B5EEBD9B5417";
pub(crate) const NURBS_SURFACE: &str = common!("4ED7D4DE-E947-11D3-BFE5");
pub(crate) const NURBS_SURFACE_ALIASES: [&str; 2] = [
    common!("4760C817-0BE3-11D4-BFFE"),
    common!("FA4FD4B5-1613-11D4-8000"),
];
pub(crate) const BREP: &str = common!("60B5DBC5-E660-11D3-BFE4");
pub(crate) const BREP_ALIASES: [&str; 3] = [
    common!("0705FDEF-3E2A-11D4-800E"),
    common!("2D4CFEDB-3E2A-11D4-800E"),
    "F06FC243-A32A-4608-9DD8-A7D2C4CE2A36",
];

pub(crate) fn line(w: &mut Writer, from: [f64; 3], to: [f64; 3], domain: [f64; 2], dim: i32) {
    w.u8(0x10);
    w.f64s(&from);
    w.f64s(&to);
    w.f64s(&domain);
    w.i32s(&[dim]);
}

/// A quarter circle about (1, 2, 3) in a plane that is not aligned with the axes.
pub(crate) fn arc(w: &mut Writer) {
    w.u8(0x10);
    w.f64s(&[1.0, 2.0, 3.0]);
    w.f64s(&[0.6, 0.8, 0.0, -0.8, 0.6, 0.0, 0.0, 0.0, 1.0]);
    w.f64s(&[0.0, 0.0, 1.0, -3.0]);
    w.f64s(&[2.5]);
    w.f64s(&[2.5, 4.0, 3.0, -1.0, 3.5, 3.0, -0.5, 0.0, 3.0]);
    w.f64s(&[0.25, 1.75, -1.0, 4.0]);
    w.i32s(&[3]);
}

pub(crate) fn polyline(w: &mut Writer, points: &[[f64; 3]], params: &[f64], dim: i32) {
    w.u8(0x10);
    w.i32s(&[points.len() as i32]);
    points.iter().for_each(|p| w.f64s(p));
    w.f64_array(params);
    w.i32s(&[dim]);
}

/// The knots of [`nurbs_curve`], as stored: not clamped at the start.
pub(crate) const KNOTS: [f64; 6] = [-0.5, 0.0, 0.25, 1.0, 2.0, 2.0];

/// A rational quadratic with 5 control points.
pub(crate) fn nurbs_curve(w: &mut Writer) {
    w.u8(0x11);
    w.i32s(&[3, 1, 3, 5, 0, 0]);
    w.f64s(&[0.0; 6]);
    w.f64_array(&KNOTS);
    w.i32s(&[5]);
    for (x, y, z, weight) in [
        (0.0, 0.0, 0.0, 1.0),
        (1.0, 2.0, 0.5, 0.5),
        (2.0, 0.1, 1.0, 2.0),
        (3.0, 1.0, -1.0, 0.75),
        (4.0, 0.0, 0.0, 1.0),
    ] {
        w.f64s(&[x * weight, y * weight, z * weight, weight]);
    }
    w.u8(0);
}

/// Three lines in a row, the last two in a poly-curve of their own.
pub(crate) fn poly_curve(w: &mut Writer) {
    w.u8(0x10);
    w.i32s(&[2, 0, 0]);
    w.f64s(&[0.0; 6]);
    w.f64_array(&[0.0, 1.0, 4.0]);
    w.object(LINE, |w| line(w, [0.0; 3], [1.0, 0.0, 0.0], [5.0, 6.0], 3));
    w.object(POLY_CURVE_ALIAS, |w| {
        w.u8(0x10);
        w.i32s(&[2, 0, 0]);
        w.f64s(&[0.0; 6]);
        w.f64_array(&[-1.0, 0.0, 2.0]);
        w.object(LINE, |w| {
            line(w, [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0], 3)
        });
        w.object(LINE, |w| {
            line(w, [1.0, 1.0, 0.0], [1.0, 1.0, 7.0], [3.0, 9.0], 3)
        });
    });
}

/// A plane over [0, 1] x [0, 1] with these coordinates.
pub(crate) fn plane(w: &mut Writer, extents: [f64; 4]) {
    w.u8(0x11);
    w.f64s(&[1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0, 0.6, 0.8, 0.0, -0.8, 0.6]);
    w.f64s(&[0.0, -0.8, 0.6, -0.2]);
    w.f64s(&[0.0, 1.0, 0.0, 1.0]);
    w.f64s(&extents);
}

/// A line turned about an axis that is neither aligned nor of unit length.
pub(crate) fn revolution(w: &mut Writer, layout: u8, transposed: i32) {
    w.u8(layout);
    w.f64s(&[1.0, 0.0, 0.0, 1.0, 3.0, 4.0]);
    w.f64s(&[0.5, 3.0]);
    if layout >= 0x20 {
        w.f64s(&[0.0, 10.0]);
    }
    w.f64s(&[-9.0, -9.0, -9.0, 9.0, 9.0, 9.0]);
    w.i32s(&[transposed]);
    w.u8(1);
    w.object(LINE, |w| {
        line(w, [3.0, 0.0, 1.0], [2.0, 2.0, 5.0], [0.0, 2.0], 3)
    });
}

pub(crate) fn sum(w: &mut Writer) {
    w.u8(0x10);
    w.f64s(&[0.5, -0.25, 10.0]);
    w.f64s(&[-9.0, -9.0, -9.0, 9.0, 9.0, 9.0]);
    w.object(NURBS_CURVE, nurbs_curve);
    w.object(ARC, arc);
}

/// A rational surface, quadratic along u and linear along v.
pub(crate) fn nurbs_surface(w: &mut Writer) {
    w.u8(0x10);
    w.i32s(&[3, 1, 3, 2, 4, 3, 0, 0]);
    w.f64s(&[0.0; 6]);
    w.f64_array(&[0.0, 0.0, 0.5, 1.0, 1.0]);
    w.f64_array(&[2.0, 3.0, 5.0]);
    w.i32s(&[12]);
    for i in 0..4 {
        for j in 0..3 {
            let (x, y) = (f64::from(i), f64::from(j));
            let weight = 1.0 + 0.25 * y * x;
            w.f64s(&[x * weight, (y + 0.1 * x) * weight, x * y * weight, weight]);
        }
    }
}

/// A square sheet with what a BREP may hold: missing curves, parts of curves, curves run backwards.
pub(crate) fn brep(w: &mut Writer) {
    brep_with(w, None);
}

/// The same with one edge whose curve is a curve on a surface.
pub(crate) fn brep_on_surface(w: &mut Writer) {
    brep_with(w, Some(PLANE));
}

/// The same where what should be that surface is none.
pub(crate) fn brep_on_damaged_surface(w: &mut Writer) {
    brep_with(w, Some(LINE));
}

fn brep_with(w: &mut Writer, on_surface: Option<&str>) {
    let object_list = |w: &mut Writer, objects: &[&dyn Fn(&mut Writer)]| {
        w.chunk(ANONYMOUS, |w| {
            w.u8(0x10);
            w.i32s(&[objects.len() as i32]);
            objects.iter().for_each(|o| o(w));
        });
    };
    let missing = |w: &mut Writer| w.i32s(&[0]);
    w.u8(0x33);
    // Three sides of the square as one polyline, the fourth as a line run backwards.
    let sides = |w: &mut Writer| {
        w.i32s(&[1]);
        let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        w.object(POLYLINE, |w| polyline(w, &square, &[0.0, 1.0, 2.0, 3.0], 2));
    };
    let left = |w: &mut Writer| {
        w.i32s(&[1]);
        w.object(LINE, |w| line(w, [0.0; 3], [0.0, 2.0, 0.0], [0.0, 4.0], 2));
    };
    object_list(w, &[&sides, &missing, &left]);
    // The same in space, for a plane with x = 1 + a, y = 2 + 0.6 b, z = 3 + 0.8 b, a and b from 0 to 5.
    let corners = [
        [1.0, 2.0, 3.0],
        [6.0, 2.0, 3.0],
        [6.0, 5.0, 7.0],
        [1.0, 5.0, 7.0],
    ];
    let around = |w: &mut Writer| {
        w.i32s(&[1]);
        w.object(POLYLINE, |w| {
            polyline(w, &corners, &[0.0, 1.0, 2.0, 3.0], 3)
        });
    };
    let back = |w: &mut Writer| {
        w.i32s(&[1]);
        if let Some(surface) = on_surface {
            w.object(CURVE_ON_SURFACE, |w| {
                w.object(LINE, |w| line(w, [0.0; 3], [0.0, 2.0, 0.0], [0.0, 4.0], 2));
                w.i32s(&[0]);
                w.object(surface, |w| plane(w, [0.0, 5.0, 0.0, 5.0]));
            });
            return;
        }
        w.object(LINE, |w| {
            line(w, corners[0], [1.0, 8.0, 11.0], [0.0, 4.0], 3)
        });
    };
    object_list(w, &[&missing, &around, &back]);
    let face = |w: &mut Writer| {
        w.i32s(&[1]);
        w.object(PLANE, |w| plane(w, [0.0, 5.0, 0.0, 5.0]));
    };
    object_list(w, &[&face]);
    let list = |w: &mut Writer, layout: u8, count: i32, items: &dyn Fn(&mut Writer, i32)| {
        w.chunk(ANONYMOUS, |w| {
            w.u8(layout);
            w.i32s(&[count]);
            (0..count).for_each(|i| items(w, i));
            if layout == 0x11 {
                w.raw(&[0; 16]);
            }
        });
    };
    list(w, 0x10, 4, &|w, i| {
        w.i32s(&[i]);
        w.f64s(&corners[i as usize]);
        w.i32_array(&[i, (i + 3) % 4]);
        w.f64s(&[if i == 0 { UNSET } else { 0.0 }]);
    });
    let span = |i: i32| [f64::from(i), f64::from(i + 1)];
    list(w, 0x10, 4, &|w, i| {
        let backwards = i == 3;
        w.i32s(&[i, if backwards { 2 } else { 1 }, i32::from(backwards)]);
        w.f64s(&if backwards { [0.0, 2.0] } else { span(i) });
        w.i32s(&[i, (i + 1) % 4]);
        w.i32_array(&[i]);
        w.f64s(&[1e-6, 0.0, 1.0]);
    });
    list(w, 0x10, 4, &|w, i| {
        let backwards = i == 3;
        w.i32s(&[i, if backwards { 2 } else { 0 }]);
        w.f64s(&if backwards { [0.0, 2.0] } else { span(i) });
        w.i32s(&[i, i, (i + 1) % 4, 0, 1, [4, 5, 6, 3][i as usize], 0]);
        w.f64s(&[0.0, 0.0]);
        w.f64s(&[0.0, 1.0]);
        w.raw(&[u8::from(backwards), 0, 0, 0, 0, 0, 0, 0]);
        w.raw(&[0; 24]);
        w.f64s(&[UNSET, UNSET]);
    });
    list(w, 0x10, 1, &|w, _| {
        w.i32s(&[0]);
        w.i32_array(&[0, 1, 2, 3]);
        w.i32s(&[1, 0]);
    });
    list(w, 0x11, 1, &|w, _| {
        w.i32s(&[0]);
        w.i32_array(&[0]);
        w.i32s(&[0, 0, 0]);
    });
    w.f64s(&[1.0, 2.0, 3.0, 6.0, 5.0, 7.0]);
    w.chunk(ANONYMOUS, |w| w.u8(0));
    w.chunk(ANONYMOUS, |w| w.u8(0));
    w.i32s(&[0]);
    w.chunk(ANONYMOUS, |w| {
        w.i32s(&[1, 1]);
        w.u8(0);
    });
}
