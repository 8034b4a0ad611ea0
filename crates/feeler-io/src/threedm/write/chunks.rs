//! Chunks with 64-bit lengths, and plain values.

use crc32fast::Hasher;

/// A chunk with this bit set in its typecode ends with a checksum.
const HAS_CRC: u32 = 0x8000;

/// The bytes of one chunk's body, and the checksum of those that are its own: not those of the chunks in it.
pub(super) struct Writer {
    bytes: Vec<u8>,
    own: Hasher,
}

impl Writer {
    pub(super) fn new() -> Self {
        Self {
            bytes: Vec::new(),
            own: Hasher::new(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.bytes.len()
    }

    pub(super) fn finish(self) -> Vec<u8> {
        self.bytes
    }

    pub(super) fn raw(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
        self.own.update(bytes);
    }

    /// Whole chunks, made elsewhere.
    pub(super) fn nested(&mut self, chunks: Writer) {
        self.bytes.extend(chunks.bytes);
    }

    pub(super) fn u8(&mut self, x: u8) {
        self.raw(&[x]);
    }

    pub(super) fn i32(&mut self, x: i32) {
        self.raw(&x.to_le_bytes());
    }

    /// A count or an index. What exceeds the format's 31 bits exceeds a file of 1 GiB, too, which is not read either.
    pub(super) fn index(&mut self, x: usize) {
        self.i32(i32::try_from(x).unwrap_or(i32::MAX));
    }

    pub(super) fn f64s(&mut self, all: &[f64]) {
        for x in all {
            self.raw(&x.to_le_bytes());
        }
    }

    /// A count and the numbers.
    pub(super) fn f64_array(&mut self, all: &[f64]) {
        self.index(all.len());
        self.f64s(all);
    }

    /// A count and the indices.
    pub(super) fn indices(&mut self, all: &[usize]) {
        self.index(all.len());
        all.iter().for_each(|x| self.index(*x));
    }

    /// UTF-16 with a zero at its end; nothing but a count of zero for an empty one.
    pub(super) fn string(&mut self, text: &str) {
        if text.is_empty() {
            return self.i32(0);
        }
        let units: Vec<u16> = text.encode_utf16().chain([0]).collect();
        self.index(units.len());
        units.iter().for_each(|x| self.raw(&x.to_le_bytes()));
    }

    fn header(&mut self, typecode: u32, value: i64) {
        // Nobody's own bytes.
        self.bytes.extend(typecode.to_le_bytes());
        self.bytes.extend(value.to_le_bytes());
    }

    pub(super) fn short(&mut self, typecode: u32, value: i64) {
        self.header(typecode, value);
    }

    pub(super) fn chunk(&mut self, typecode: u32, body: impl FnOnce(&mut Writer)) {
        let mut inner = Writer::new();
        body(&mut inner);
        if typecode & HAS_CRC != 0 {
            let crc = inner.own.finalize();
            inner.bytes.extend(crc.to_le_bytes());
        }
        self.header(typecode, inner.bytes.len() as i64);
        self.bytes.extend(inner.bytes);
    }

    /// An object of the class with this id (as printed).
    pub(super) fn object(&mut self, class: &str, data: impl FnOnce(&mut Writer)) {
        self.chunk(0x0002_7FFA, |w| {
            w.chunk(0x0002_FFFB, |w| w.raw(&uuid(class)));
            w.chunk(0x0002_FFFC, data);
            w.short(0x8002_7FFF, 0);
        });
    }
}

/// The bytes of an id as printed: its first three fields are stored little-endian.
fn uuid(text: &str) -> [u8; 16] {
    let mut id = [0; 16];
    let digits: Vec<u8> = text
        .bytes()
        .filter_map(|b| (b as char).to_digit(16))
        .map(|d| d as u8)
        .collect();
    for (byte, pair) in id.iter_mut().zip(digits.chunks(2)) {
        *byte = pair.iter().fold(0, |x, d| x << 4 | d);
    }
    id[..4].reverse();
    id[4..6].reverse();
    id[6..8].reverse();
    id
}
