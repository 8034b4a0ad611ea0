//! Reading and writing files of text, compressed or not.

use flate2::read::GzDecoder;
use flate2::{Compression, GzBuilder};
use std::io::{Error, ErrorKind, Read, Result, Write};
use std::path::Path;

/// The most text that a file may hold, compressed or not: 256 MiB. A compressed file of a few
/// kilobytes can stand for more text than there is memory.
pub const MAX_TEXT: u64 = 1 << 28;

/// The end of a compressed file's name.
pub(crate) const COMPRESSED: &str = ".gz";

/// Whether a name says that the file is compressed.
fn is_compressed(path: &Path) -> bool {
    path.as_os_str().to_string_lossy().ends_with(COMPRESSED)
}

/// The text of a file; decompressed where its name ends with `.gz`.
///
/// # Errors
/// Besides those of the system: more than [`MAX_TEXT`] bytes, or not UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    let file = std::fs::File::open(path)?;
    let reader: Box<dyn Read> = if is_compressed(path) {
        Box::new(GzDecoder::new(std::io::BufReader::new(file)))
    } else {
        Box::new(file)
    };
    let mut text = String::new();
    reader.take(MAX_TEXT + 1).read_to_string(&mut text)?;
    if text.len() as u64 > MAX_TEXT {
        let why = format!("more than {MAX_TEXT} bytes of text");
        return Err(Error::new(ErrorKind::InvalidData, why));
    }
    Ok(text)
}

/// Writes a text; compressed where the name ends with `.gz`. Whoever reads sees the old file or the
/// whole of the new one, also when the writer is killed. The same text gives the same bytes: no time and no name
/// stand in the compressed file.
pub fn write_text(path: &Path, text: &str) -> Result<()> {
    let bytes = if is_compressed(path) {
        compressed(text.as_bytes())?
    } else {
        text.as_bytes().to_vec()
    };
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".part");
    let partial = path.with_file_name(name);
    std::fs::write(&partial, bytes)?;
    std::fs::rename(&partial, path)
}

fn compressed(bytes: &[u8]) -> Result<Vec<u8>> {
    /// "Unknown", where others write the system they run on.
    const NO_SYSTEM: u8 = 255;
    let mut encoder = GzBuilder::new()
        .mtime(0)
        .operating_system(NO_SYSTEM)
        .write(Vec::new(), Compression::best());
    encoder.write_all(bytes)?;
    encoder.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_comes_back_and_its_bytes_do_not_change() {
        let folder = std::env::temp_dir().join(format!("feeler-files-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.jsonl.gz");
        let text = "{\"a\": 0.1}\n".repeat(1000);
        write_text(&path, &text).unwrap();
        let first = std::fs::read(&path).unwrap();
        assert!(first.len() < 200);
        // No name, no time, no system.
        assert_eq!(&first[..10], &[0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 2, 255]);
        assert_eq!(read_text(&path).unwrap(), text);
        write_text(&path, &text).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), first);
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
        // Cut off, or no such file at all: an error.
        std::fs::write(&path, &first[..first.len() / 2]).unwrap();
        assert!(read_text(&path).is_err());
        std::fs::write(&path, "plain").unwrap();
        assert!(read_text(&path).is_err());
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_small_file_that_stands_for_more_than_memory_holds_is_refused() {
        let folder = std::env::temp_dir().join(format!("feeler-bomb-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("bomb.json.gz");
        // Members of a gzip file in a row are one text only for some readers; one member of spaces is enough.
        let mut encoder = GzBuilder::new().write(Vec::new(), Compression::fast());
        let spaces = vec![b' '; 1 << 20];
        for _ in 0..=(MAX_TEXT >> 20) {
            encoder.write_all(&spaces).unwrap();
        }
        std::fs::write(&path, encoder.finish().unwrap()).unwrap();
        let error = read_text(&path).unwrap_err();
        assert!(error.to_string().contains("more than"), "{error}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
