//! Chunks: the container that everything in a .3dm file lies in.
//!
//! A chunk is a typecode (u32) and a value (i32 before version 50, i64 from then on). Typecodes
//! with [`SHORT`] set are the whole chunk. Otherwise the value is the length of the
//! body; with [`HAS_CRC`] set the body's last 4 bytes are the CRC-32 of the bytes that belong to the
//! chunk itself, not to the chunks inside it. A [`Chunk`] is a cursor over one
//! body that hashes what it steps over, so that [`Chunk::finish`] can compare.
//!
//! Files of version 1 have no such bit: there a typecode of 0 is a whole chunk, too, and the inner chunks of geometry
//! ([`STUFF_1`]) end with a checksum of 16 bits.

use crate::error::{ChunkId, Problem, ReadError};
use crc32fast::Hasher;
use feeler::numeric::Interval;

/// How deep chunks may nest. A poly-curve inside a poly-curve is two levels; a BREP's curves
/// start at level 7, so poly-curves may nest 12 deep. Files seen in the wild use 2 at most.
pub const MAX_DEPTH: u32 = 32;

/// A typecode with this bit has its payload in place of a length.
const SHORT: u32 = 0x8000_0000;
/// A typecode with this bit ends with a checksum.
const HAS_CRC: u32 = 0x0000_8000;
/// The checksum's size.
const CRC_SIZE: usize = 4;
/// The bits of a typecode whose chunk ends with a checksum of 16 bits in files of version 1, ...
const STUFF_1: u32 = 0x0001_0100;
/// ... its size, the register it starts from, and its polynomial (that of the CCITT).
const CRC_SIZE_1: usize = 2;
const CRC_START_1: u16 = 1;
const CRC_POLYNOMIAL_1: u16 = 0x1021;
/// The chunk that wraps parts without a typecode of their own.
pub(super) const ANONYMOUS: u32 = 0x4000_8000;
/// What the format stores for "not set".
pub(super) const UNSET: f64 = -1.234_321_012_343_21e308;

/// The whole file and what its header says.
#[derive(Clone, Copy)]
pub(super) struct Archive<'a> {
    pub(super) bytes: &'a [u8],
    /// 1, 2, 3, 4, 5, 50, 60, ...
    pub(super) version: u32,
    /// Version of the library that wrote it; 0 if not said.
    pub(super) opennurbs: u32,
}

/// A cursor over the body of one chunk.
pub(super) struct Chunk<'a> {
    pub(super) archive: Archive<'a>,
    pub(super) id: ChunkId,
    /// The payload of a short chunk.
    pub(super) value: i64,
    depth: u32,
    pos: usize,
    end: usize,
    check: Check,
    hashed: usize,
}

/// A checksum, and what was hashed so far.
#[derive(Clone)]
enum Check {
    None,
    Crc32 { stored: u32, hasher: Hasher },
    Crc16 { stored: u16, register: u16 },
}

/// The register after these bytes: the rest of the division of what went through it as one polynomial, so that it is 0 after a
/// message with its checksum. Bit by bit: the old files are small.
fn crc16(register: u16, bytes: &[u8]) -> u16 {
    bytes.iter().fold(register, |register, byte| {
        (0..8).fold(register, |r, bit| {
            let next = (r << 1) | u16::from(byte >> (7 - bit) & 1);
            if r & 0x8000 == 0 {
                next
            } else {
                next ^ CRC_POLYNOMIAL_1
            }
        })
    })
}

impl<'a> Chunk<'a> {
    /// The file's chunks from `start` on, as if they were one chunk's body.
    pub(super) fn file(archive: Archive<'a>, start: usize) -> Self {
        Self {
            archive,
            id: ChunkId {
                typecode: 0,
                offset: start,
            },
            value: 0,
            depth: 0,
            pos: start,
            end: archive.bytes.len(),
            check: Check::None,
            hashed: start,
        }
    }

    /// Where the next byte is read.
    pub(super) fn position(&self) -> usize {
        self.pos
    }

    /// How many bytes are left.
    pub(super) fn left(&self) -> usize {
        self.end - self.pos
    }

    /// An error at the current position.
    pub(super) fn fail(&self, problem: Problem) -> ReadError {
        self.fail_at(self.pos, problem)
    }

    /// An error at byte `at`.
    pub(super) fn fail_at(&self, at: usize, problem: Problem) -> ReadError {
        ReadError::Chunk {
            chunk: self.id,
            at,
            problem: Box::new(problem),
        }
    }

    fn take<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], ReadError> {
        let bytes = self.archive.bytes.get(self.pos..self.end);
        match bytes.and_then(|b| b.first_chunk::<N>()) {
            Some(&bytes) => {
                self.pos += N;
                Ok(bytes)
            }
            None => Err(self.fail(Problem::Truncated {
                what,
                needed: N as u64,
                left: self.left() as u64,
            })),
        }
    }

    pub(super) fn u8(&mut self, what: &'static str) -> Result<u8, ReadError> {
        self.take::<1>(what).map(|b| b[0])
    }

    pub(super) fn u16(&mut self, what: &'static str) -> Result<u16, ReadError> {
        self.take(what).map(u16::from_le_bytes)
    }

    pub(super) fn i32(&mut self, what: &'static str) -> Result<i32, ReadError> {
        self.take(what).map(i32::from_le_bytes)
    }

    fn u32(&mut self, what: &'static str) -> Result<u32, ReadError> {
        self.take(what).map(u32::from_le_bytes)
    }

    pub(super) fn f64(&mut self, what: &'static str) -> Result<f64, ReadError> {
        self.take(what).map(f64::from_le_bytes)
    }

    pub(super) fn f64s<const N: usize>(
        &mut self,
        what: &'static str,
    ) -> Result<[f64; N], ReadError> {
        let mut all = [0.0; N];
        for x in &mut all {
            *x = self.f64(what)?;
        }
        Ok(all)
    }

    /// A tolerance or the like; `None` if it is unset, negative or not finite.
    pub(super) fn optional_f64(&mut self, what: &'static str) -> Result<Option<f64>, ReadError> {
        let x = self.f64(what)?;
        Ok((x != UNSET && x.is_finite() && x >= 0.0).then_some(x))
    }

    /// A class id, as stored.
    pub(super) fn uuid(&mut self) -> Result<[u8; 16], ReadError> {
        self.take("a class id")
    }

    /// The typecode that would come next, if there is one.
    pub(super) fn next_typecode(&self) -> Option<u32> {
        let bytes = self.archive.bytes.get(self.pos..self.end)?;
        bytes.first_chunk().map(|b| u32::from_le_bytes(*b))
    }

    /// Steps over `count` bytes.
    pub(super) fn skip(&mut self, count: usize, what: &'static str) -> Result<(), ReadError> {
        if count > self.left() {
            return Err(self.fail(Problem::Truncated {
                what,
                needed: count as u64,
                left: self.left() as u64,
            }));
        }
        self.pos += count;
        Ok(())
    }

    /// An integer of the size that lengths have in this version.
    fn integer(&mut self, what: &'static str) -> Result<i64, ReadError> {
        if self.archive.version < 50 {
            self.i32(what).map(i64::from)
        } else {
            self.take(what).map(i64::from_le_bytes)
        }
    }

    /// The size of the file, in its last chunk; unsigned, whatever its size.
    pub(super) fn length(&mut self) -> Result<u64, ReadError> {
        if self.archive.version < 50 {
            self.u32("the file's size").map(u64::from)
        } else {
            self.take("the file's size").map(u64::from_le_bytes)
        }
    }

    /// A count of items that take at least `item_size` bytes each in this chunk: refused if they
    /// cannot all be there.
    pub(super) fn count(
        &mut self,
        what: &'static str,
        item_size: usize,
    ) -> Result<usize, ReadError> {
        let at = self.pos;
        let count = self.i32(what)?;
        self.check_count(at, what, i64::from(count), item_size)
    }

    /// `count` (read at byte `at`) if that many items of `item_size` bytes fit into what is left.
    pub(super) fn check_count(
        &self,
        at: usize,
        what: &'static str,
        count: i64,
        item_size: usize,
    ) -> Result<usize, ReadError> {
        let most = self.left() / item_size.max(1);
        match usize::try_from(count) {
            Ok(n) if n <= most => Ok(n),
            _ => Err(self.fail_at(
                at,
                Problem::Count {
                    what,
                    count,
                    left: self.left() as u64,
                },
            )),
        }
    }

    pub(super) fn i32_array(&mut self, what: &'static str) -> Result<Vec<i32>, ReadError> {
        let n = self.count(what, size_of::<i32>())?;
        (0..n).map(|_| self.i32(what)).collect()
    }

    pub(super) fn f64_array(&mut self, what: &'static str) -> Result<Vec<f64>, ReadError> {
        let n = self.count(what, size_of::<f64>())?;
        (0..n).map(|_| self.f64(what)).collect()
    }

    /// UTF-16 with its length in front; a trailing zero is dropped.
    pub(super) fn string(&mut self, what: &'static str) -> Result<String, ReadError> {
        let n = self.count(what, size_of::<u16>())?;
        let mut units = Vec::with_capacity(n);
        for _ in 0..n {
            units.push(self.u16(what)?);
        }
        while units.last() == Some(&0) {
            units.pop();
        }
        Ok(cut(String::from_utf16_lossy(&units)))
    }

    /// Text of files of version 1: its length in front, a byte a character (those of Latin-1).
    pub(super) fn narrow_string(&mut self, what: &'static str) -> Result<String, ReadError> {
        let n = self.count(what, 1)?;
        let text = (0..n).map(|_| self.u8(what).map(char::from));
        let text = text.collect::<Result<String, _>>()?;
        Ok(cut(text.trim_end_matches('\0').to_owned()))
    }

    /// A parameter interval, which must be finite and increasing.
    pub(super) fn interval(&mut self, what: &'static str) -> Result<Interval, ReadError> {
        let at = self.pos;
        let [start, end] = self.f64s(what)?;
        Interval::new(start, end).ok_or_else(|| {
            self.fail_at(
                at,
                Problem::Value {
                    what: what.into(),
                    found: format!("[{start:?}, {end:?}]"),
                    expected: "a finite increasing interval".into(),
                },
            )
        })
    }

    /// The layout version of a class: one byte, major and minor.
    pub(super) fn layout(&mut self) -> Result<(u8, u8), ReadError> {
        self.u8("the layout version").map(|b| (b >> 4, b & 15))
    }

    /// The next chunk in this one; its bytes are stepped over.
    pub(super) fn child(&mut self) -> Result<Chunk<'a>, ReadError> {
        let offset = self.pos;
        self.hash_to(offset);
        let typecode = self.u32("a chunk's typecode")?;
        let value = self.integer("a chunk's length")?;
        if self.depth >= MAX_DEPTH {
            return Err(self.fail_at(offset, Problem::Depth { limit: MAX_DEPTH }));
        }
        let start = self.pos;
        let first_version = self.archive.version == 1;
        let short = typecode & SHORT != 0 || (first_version && typecode == 0);
        let length = if short { 0 } else { value };
        let bad_length = |left| Problem::ChunkLength {
            typecode,
            length,
            left,
        };
        let Some(end) = usize::try_from(length)
            .ok()
            .and_then(|n| start.checked_add(n))
            .filter(|end| *end <= self.end)
        else {
            return Err(self.fail_at(offset, bad_length(self.left() as u64)));
        };
        let id = ChunkId { typecode, offset };
        let size = match (short, first_version) {
            (false, false) if typecode & HAS_CRC != 0 => CRC_SIZE,
            (false, true) if typecode & STUFF_1 == STUFF_1 => CRC_SIZE_1,
            _ => 0,
        };
        let Some(end_of_data) = end.checked_sub(size).filter(|e| *e >= start) else {
            return Err(self.fail_at(
                offset,
                Problem::Truncated {
                    what: "a checksum",
                    needed: size as u64,
                    left: (end - start) as u64,
                },
            ));
        };
        let check = match self.archive.bytes.get(end_of_data..end) {
            Some(&[a, b, c, d]) => Check::Crc32 {
                stored: u32::from_le_bytes([a, b, c, d]),
                hasher: Hasher::new(),
            },
            Some(&[a, b]) => Check::Crc16 {
                stored: u16::from_be_bytes([a, b]),
                register: CRC_START_1,
            },
            _ => Check::None,
        };
        self.pos = end;
        self.hashed = end;
        Ok(Chunk {
            archive: self.archive,
            id,
            value,
            depth: self.depth + 1,
            pos: start,
            end: end_of_data,
            check,
            hashed: start,
        })
    }

    /// The next chunk, which must have this typecode.
    pub(super) fn expect(
        &mut self,
        typecode: u32,
        expected: &'static str,
    ) -> Result<Chunk<'a>, ReadError> {
        let child = self.child()?;
        if child.id.typecode == typecode {
            Ok(child)
        } else {
            Err(self.fail_at(
                child.id.offset,
                Problem::Unexpected {
                    expected,
                    found: child.id.typecode,
                },
            ))
        }
    }

    fn hash_to(&mut self, to: usize) {
        if let Some(bytes) = self.archive.bytes.get(self.hashed..to) {
            match &mut self.check {
                Check::None => {}
                Check::Crc32 { hasher, .. } => hasher.update(bytes),
                Check::Crc16 { register, .. } => *register = crc16(*register, bytes),
            }
        }
        self.hashed = to;
    }

    /// Verifies the checksum. What was not read (fields of newer layouts) belongs to the chunk, too:
    /// either all of it, or, if that does not fit, all but the chunks found in it.
    pub(super) fn finish(mut self) -> Result<(), ReadError> {
        self.hash_to(self.pos);
        let rest = self.archive.bytes.get(self.pos..self.end).unwrap_or(&[]);
        let (stored, computed) = match &self.check {
            Check::None => return Ok(()),
            Check::Crc32 { stored, hasher } => {
                let mut whole = hasher.clone();
                whole.update(rest);
                (*stored, whole.finalize())
            }
            Check::Crc16 { stored, register } => {
                let computed = crc16(crc16(*register, rest), &[0; CRC_SIZE_1]);
                (u32::from(*stored), u32::from(computed))
            }
        };
        if stored == computed || self.crc_without_chunks() == Some(stored) {
            Ok(())
        } else {
            Err(self.fail_at(self.end, Problem::Checksum { stored, computed }))
        }
    }

    /// The checksum when the unread rest is searched for chunks and these are left out. One pass: what
    /// looks like a chunk and fits is taken for one, and a wrong guess shows in the checksum.
    fn crc_without_chunks(&self) -> Option<u32> {
        let Check::Crc32 { hasher, .. } = &self.check else {
            return None;
        };
        let mut hasher = hasher.clone();
        let bytes = self.archive.bytes;
        let header = if self.archive.version < 50 { 8 } else { 12 };
        let (mut pos, mut hashed) = (self.pos, self.pos);
        while pos + header <= self.end {
            let inner = bytes.get(pos..self.end).unwrap_or(&[]);
            let typecode = inner.first_chunk().map(|b| u32::from_le_bytes(*b));
            if !matches!(typecode, Some(ANONYMOUS | 0x0002_7FFA)) {
                pos += 1;
                continue;
            }
            let rest = inner.get(4..).unwrap_or(&[]);
            let length = if header == 8 {
                rest.first_chunk()
                    .map(|b| i64::from(i32::from_le_bytes(*b)))
            } else {
                rest.first_chunk().map(|b| i64::from_le_bytes(*b))
            };
            let room = self.end - pos - header;
            match length.and_then(|n| usize::try_from(n).ok()) {
                Some(n) if n <= room => {
                    hasher.update(bytes.get(hashed..pos).unwrap_or(&[]));
                    pos += header + n;
                    hashed = pos;
                }
                _ => pos += 1,
            }
        }
        hasher.update(bytes.get(hashed..self.end).unwrap_or(&[]));
        Some(hasher.finalize())
    }
}

/// Names and paths have no more characters than this: one layer's or block's is told with each object on it.
const MOST_NAME: usize = 1024;

/// A name, without what is past [`MOST_NAME`].
fn cut(mut name: String) -> String {
    if let Some((end, _)) = name.char_indices().nth(MOST_NAME) {
        name.truncate(end);
        name.push('…');
        name.shrink_to_fit();
    }
    name
}
