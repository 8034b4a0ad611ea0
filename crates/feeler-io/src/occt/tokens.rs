//! The words of a text, with their lines.

use super::error::TextProblem;
use crate::error::ReadError;
use std::str::FromStr;

/// How much of a word a message shows.
const SHOWN: usize = 24;

/// What ends a word, by byte: a look costs less than five comparisons.
const IS_SPACE: [bool; 256] = {
    let mut all = [false; 256];
    let mut b = 0;
    while b < 256 {
        all[b] = (b as u8).is_ascii_whitespace();
        b += 1;
    }
    all
};

fn is_space(b: &u8) -> bool {
    IS_SPACE[usize::from(*b)]
}

/// Reads words from the front.
pub(super) struct Tokens<'a> {
    bytes: &'a [u8],
    /// The bytes up to the first that is no UTF-8: looked at once, not word by word.
    text: &'a str,
    at: usize,
    /// The line of `at`, counted from 1.
    line: usize,
    /// The line of the word read last.
    last: usize,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let text = std::str::from_utf8(bytes).or_else(|e| {
            let good = bytes.get(..e.valid_up_to()).unwrap_or_default();
            std::str::from_utf8(good)
        });
        Self {
            bytes,
            text: text.unwrap_or_default(),
            at: 0,
            line: 1,
            last: 1,
        }
    }

    /// The line of the word read last.
    pub(super) fn last_line(&self) -> usize {
        self.last
    }

    /// Byte offset of what follows.
    pub(super) fn position(&self) -> usize {
        self.at
    }

    fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The whole file's size.
    pub(super) fn size(&self) -> usize {
        self.bytes.len()
    }

    pub(super) fn fail(&self, problem: TextProblem) -> ReadError {
        fail(self.last, problem)
    }

    /// What says that a word cannot stand there.
    pub(super) fn unexpected(
        &self,
        what: &'static str,
        word: &[u8],
        expected: impl Into<String>,
    ) -> ReadError {
        let shown = &word[..word.len().min(SHOWN)];
        self.fail(TextProblem::Word {
            what,
            found: String::from_utf8_lossy(shown).escape_debug().to_string(),
            expected: expected.into(),
        })
    }

    /// The rest of the line, without its end; `None` at the end of the file.
    pub(super) fn rest_of_line(&mut self) -> Option<&'a [u8]> {
        let rest = self.bytes.get(self.at..).filter(|r| !r.is_empty())?;
        self.last = self.line;
        let end = rest.iter().position(|b| *b == b'\n');
        self.at += end.map_or(rest.len(), |e| e + 1);
        self.line += usize::from(end.is_some());
        rest.get(..end.unwrap_or(rest.len()))
    }

    /// The next word; `None` at the end of the file.
    fn next(&mut self) -> Option<&'a [u8]> {
        let mut start = self.at;
        while let Some(b) = self.bytes.get(start).filter(|b| is_space(b)) {
            self.line += usize::from(*b == b'\n');
            start += 1;
        }
        self.at = start;
        self.last = self.line;
        let rest = self.bytes.get(start..)?;
        let end = rest.iter().position(is_space);
        let word = rest.get(..end.unwrap_or(rest.len()))?;
        self.at += word.len();
        (!word.is_empty()).then_some(word)
    }

    /// The word read last, which this is, as a value.
    fn parsed<T: FromStr>(&self, word: &[u8]) -> Option<T> {
        let text = self.text.get(self.at - word.len()..self.at);
        text.or_else(|| std::str::from_utf8(word).ok())?
            .parse()
            .ok()
    }

    pub(super) fn word(&mut self, what: &'static str) -> Result<&'a [u8], ReadError> {
        match self.next() {
            Some(word) => Ok(word),
            None => Err(self.fail(TextProblem::Truncated { what })),
        }
    }

    /// The next word without taking it.
    pub(super) fn peek(&mut self) -> Option<&'a [u8]> {
        let (at, line) = (self.at, self.line);
        let word = self.next();
        (self.at, self.line) = (at, line);
        word
    }

    pub(super) fn expect(
        &mut self,
        what: &'static str,
        expected: &'static str,
    ) -> Result<(), ReadError> {
        let word = self.word(what)?;
        if word == expected.as_bytes() {
            return Ok(());
        }
        Err(self.unexpected(what, word, format!("`{expected}`")))
    }

    /// A finite number.
    pub(super) fn number(&mut self, what: &'static str) -> Result<f64, ReadError> {
        let word = self.word(what)?;
        match self.parsed(word) {
            Some(value) if f64::is_finite(value) => Ok(value),
            _ => Err(self.unexpected(what, word, "a finite number")),
        }
    }

    pub(super) fn numbers<const N: usize>(
        &mut self,
        what: &'static str,
    ) -> Result<[f64; N], ReadError> {
        let mut all = [0.0; N];
        for x in &mut all {
            *x = self.number(what)?;
        }
        Ok(all)
    }

    pub(super) fn integer(&mut self, what: &'static str) -> Result<i64, ReadError> {
        let word = self.word(what)?;
        self.parsed(word)
            .ok_or_else(|| self.unexpected(what, word, "an integer"))
    }

    pub(super) fn flag(&mut self, what: &'static str) -> Result<bool, ReadError> {
        match self.word(what)? {
            b"0" => Ok(false),
            b"1" => Ok(true),
            word => Err(self.unexpected(what, word, "0 or 1")),
        }
    }

    /// A count of things of at least `words` words each, no more than what is left can hold: a word
    /// and what separates it from the next take two bytes.
    pub(super) fn count(&mut self, what: &'static str, words: usize) -> Result<usize, ReadError> {
        let count = self.integer(what)?;
        self.check_count(what, count, words)
    }

    /// The same for a count at hand.
    pub(super) fn check_count(
        &self,
        what: &'static str,
        count: i64,
        words: usize,
    ) -> Result<usize, ReadError> {
        let left = self.left();
        let most = (left + 1) / words.saturating_mul(2).max(1);
        match usize::try_from(count) {
            Ok(count) if count <= most => Ok(count),
            Ok(count) => Err(self.fail(TextProblem::Count {
                what,
                count: count as u64,
                left,
            })),
            Err(_) => Err(self.unexpected(what, count.to_string().as_bytes(), "0 or more")),
        }
    }

    /// A number from 1 to `count`, as an index from 0; `None` for 0.
    pub(super) fn optional_index(
        &mut self,
        what: &'static str,
        count: usize,
    ) -> Result<Option<usize>, ReadError> {
        let found = self.integer(what)?;
        match usize::try_from(found) {
            Ok(0) => Ok(None),
            Ok(i) if i <= count => Ok(Some(i - 1)),
            _ => Err(self.fail(TextProblem::Reference { what, found, count })),
        }
    }

    /// A number from 1 to `count`, as an index from 0.
    pub(super) fn index(&mut self, what: &'static str, count: usize) -> Result<usize, ReadError> {
        match self.optional_index(what, count)? {
            Some(i) => Ok(i),
            None => Err(self.fail(TextProblem::Reference {
                what,
                found: 0,
                count,
            })),
        }
    }

    /// Steps over words.
    pub(super) fn skip(&mut self, what: &'static str, words: usize) -> Result<(), ReadError> {
        for _ in 0..words {
            self.word(what)?;
        }
        Ok(())
    }
}

pub(super) fn fail(line: usize, problem: TextProblem) -> ReadError {
    ReadError::Line {
        line,
        problem: Box::new(problem),
    }
}
