//! The syntax of STEP files, ISO 10303-21: entities with their attributes.
//!
//! Read here rather than by a library: `step-io` 0.3.0 takes several minutes to build, for schemas of which nothing is needed; `ruststep`
//! 0.4.0 recurses as deep as a file says, so that a few kilobytes of brackets end the program, and knows no binary values and no text but
//! UTF-8.
//!
//! Lists nest at most [`MOST_NESTED`] deep. An attribute takes 32 bytes in memory and at least two in the file; more than
//! [`MOST_BLANK`] attributes that are not even a `$` are refused, fewer in small files.

use crate::error::ReadError;
use crate::step_problem::StepProblem;
use std::rc::Rc;

/// How deep lists may nest: files have three levels.
const MOST_NESTED: usize = 32;
/// How many parts an entity may have, which are looked through one by one: files have a dozen.
const MOST_PARTS: usize = 64;
/// How many attributes may be left blank, which the standard does not allow and some programs do.
const MOST_BLANK: usize = 1000;
/// Of small files fewer: these, and one for so many bytes.
const FEW_BLANK: usize = 16;
const BYTES_A_BLANK: usize = 32;

/// An attribute.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Attribute {
    Integer(i64),
    Real(f64),
    Text(Box<str>),
    /// Without its dots.
    Enum(Rc<str>),
    EntityRef(u64),
    /// `$`, `*`, a binary value.
    Unset,
    List(Vec<Attribute>),
    /// `LENGTH_MEASURE(1.)`: the value alone.
    Typed(Box<Attribute>),
}

/// A kind and its attributes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    pub(super) name: Rc<str>,
    pub(super) attributes: Vec<Attribute>,
}

/// An entity.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RawEntity {
    /// Byte offset from the start of the file.
    pub(super) offset: usize,
    /// One, or those of a complex entity.
    pub(super) parts: Vec<Part>,
    /// Whether it is written as `(A()B())`.
    pub(super) is_complex: bool,
}

/// A file.
pub(super) struct Graph {
    /// What `FILE_SCHEMA` says.
    pub(super) schema: String,
    /// In the order of their numbers.
    pub(super) entities: Vec<(u64, RawEntity)>,
    /// Attributes that were left blank.
    pub(super) blank: usize,
}

impl Graph {
    /// Where the entity of a number is in the list.
    pub(super) fn place(&self, id: u64) -> Option<usize> {
        // Most files count from 1 and leave none out.
        let (first, _) = self.entities.first()?;
        let guess = usize::try_from(id.checked_sub(*first)?).ok()?;
        match self.entities.get(guess) {
            Some((found, _)) if *found == id => Some(guess),
            _ => self.entities.binary_search_by_key(&id, |(i, _)| *i).ok(),
        }
    }

    pub(super) fn get(&self, id: u64) -> Option<&RawEntity> {
        Some(&self.entities.get(self.place(id)?)?.1)
    }

    /// Bytes that it takes, some more than less: an entity has a place in a list that doubles.
    pub(super) fn bytes(&self) -> usize {
        let of_entity = |e: &RawEntity| -> usize {
            let parts = { e.parts.iter() }
                .map(|p| size_of::<Part>() + p.name.len() + listed(&p.attributes));
            2 * size_of::<(u64, RawEntity)>() + parts.sum::<usize>()
        };
        self.entities.iter().map(|(_, e)| of_entity(e)).sum()
    }
}

/// Bytes that attributes take; recursion is bounded by [`MOST_NESTED`].
fn listed(attributes: &[Attribute]) -> usize {
    let beside = |a: &Attribute| match a {
        Attribute::Text(text) => text.len(),
        Attribute::Enum(word) => word.len(),
        Attribute::List(list) => listed(list),
        Attribute::Typed(one) => listed(std::slice::from_ref(&**one)),
        Attribute::Integer(_) | Attribute::Real(_) | Attribute::EntityRef(_) | Attribute::Unset => {
            0
        }
    };
    size_of_val(attributes) + attributes.iter().map(beside).sum::<usize>()
}

struct Parser<'b> {
    bytes: &'b [u8],
    at: usize,
    blank: usize,
    /// Attributes of lists that are not ended yet, those of the innermost last.
    open: Vec<Attribute>,
    /// Names that were met, each in a place of its own: most are met again.
    names: [Option<Rc<str>>; NAMES],
}

/// How many names are kept: files have some 50 kinds.
const NAMES: usize = 256;

fn is_name(b: u8) -> bool {
    b.is_ascii_alphanumeric() || b == b'_' || b == b'-'
}

/// Reads a file.
pub(super) fn parse(bytes: &[u8]) -> Result<Graph, ReadError> {
    let mut p = Parser {
        bytes,
        at: 0,
        blank: 0,
        open: Vec::new(),
        names: [const { None }; NAMES],
    };
    p.word("ISO-10303-21")?;
    p.byte(b';')?;
    p.word("HEADER")?;
    p.byte(b';')?;
    let mut graph = Graph {
        schema: String::new(),
        entities: Vec::new(),
        blank: 0,
    };
    while !p.is_word("ENDSEC") {
        let part = p.part()?;
        if &*part.name == "FILE_SCHEMA"
            && let Some(Attribute::List(list)) = part.attributes.first()
            && let Some(Attribute::Text(text)) = list.first()
        {
            graph.schema = text.to_uppercase();
        }
        // Some programs forget it here.
        if p.peek() == Some(b';') {
            p.at += 1;
        }
    }
    p.word("ENDSEC")?;
    p.byte(b';')?;
    let mut any = false;
    loop {
        if p.is_word("DATA") {
            p.word("DATA")?;
            if p.peek() == Some(b'(') {
                p.list(0)?;
            }
            p.byte(b';')?;
            p.data(&mut graph.entities)?;
            any = true;
        } else if p.is_word("END-ISO-10303-21") || (any && p.peek().is_none()) {
            break;
        } else {
            // A section of a later edition: nothing in it is geometry.
            p.skip_section()?;
        }
    }
    graph.blank = p.blank;
    let entities = &mut graph.entities;
    if !entities.is_sorted_by_key(|(id, _)| *id) {
        // In memory of its own, and of one number the later comes second.
        entities.sort_unstable_by_key(|(id, e)| (*id, e.offset));
    }
    let twice = { entities.windows(2) }.filter(|w| w[0].0 == w[1].0);
    if let Some(at) = twice.map(|w| w[1].1.offset).min() {
        p.at = at;
        return Err(p.fail("another number than that of an entity before"));
    }
    Ok(graph)
}

impl Parser<'_> {
    /// What is wrong where it stands.
    fn fail(&self, expected: &str) -> ReadError {
        let before = self.bytes.get(..self.at).unwrap_or(self.bytes);
        let line = 1 + before.iter().filter(|b| **b == b'\n').count();
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let message = if rest.is_empty() {
            format!("the file ends where {expected} should stand")
        } else {
            let shown = rest.get(..rest.len().min(16)).unwrap_or(rest);
            let shown: String = String::from_utf8_lossy(shown)
                .chars()
                .map(|c| if c.is_control() { ' ' } else { c })
                .collect();
            format!("line {line}: {expected} expected, found `{shown}`")
        };
        ReadError::Step(Box::new(StepProblem::Syntax { message }))
    }

    /// The next byte that is neither blank nor in a comment.
    fn peek(&mut self) -> Option<u8> {
        loop {
            let b = *self.bytes.get(self.at)?;
            if b.is_ascii_whitespace() || b == 0 {
                self.at += 1;
            } else if b == b'/' && self.bytes.get(self.at + 1) == Some(&b'*') {
                let rest = self.bytes.get(self.at + 2..)?;
                let end = rest.windows(2).position(|w| w == b"*/");
                self.at = end.map_or(self.bytes.len(), |e| self.at + e + 4);
            } else {
                return Some(b);
            }
        }
    }

    fn byte(&mut self, b: u8) -> Result<(), ReadError> {
        if self.peek() == Some(b) {
            self.at += 1;
            return Ok(());
        }
        Err(self.fail(&format!("`{}`", char::from(b))))
    }

    fn is_word(&mut self, word: &str) -> bool {
        self.peek();
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        rest.get(..word.len())
            .is_some_and(|w| w.eq_ignore_ascii_case(word.as_bytes()))
            && !rest.get(word.len()).is_some_and(|b| is_name(*b))
    }

    fn word(&mut self, word: &str) -> Result<(), ReadError> {
        if !self.is_word(word) {
            return Err(self.fail(word));
        }
        self.at += word.len();
        Ok(())
    }

    fn name(&mut self) -> Result<Rc<str>, ReadError> {
        self.peek();
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let user = usize::from(rest.first() == Some(&b'!'));
        let count = rest.iter().skip(user).take_while(|b| is_name(**b)).count();
        if count == 0 {
            return Err(self.fail("a name"));
        }
        let own = rest.get(user..user + count).unwrap_or_default();
        self.at += user + count;
        let mixed = |h: usize, b: &u8| {
            h.wrapping_mul(31)
                .wrapping_add(usize::from(b.to_ascii_uppercase()))
        };
        let place = own.iter().fold(0, mixed) % NAMES;
        let is_own = |n: &&Rc<str>| n.as_bytes().eq_ignore_ascii_case(own);
        if let Some(known) = self
            .names
            .get(place)
            .and_then(Option::as_ref)
            .filter(is_own)
        {
            return Ok(Rc::clone(known));
        }
        let name: Rc<str> = String::from_utf8_lossy(own).to_ascii_uppercase().into();
        if let Some(place) = self.names.get_mut(place) {
            *place = Some(Rc::clone(&name));
        }
        Ok(name)
    }

    /// `NAME(attributes)`.
    fn part(&mut self) -> Result<Part, ReadError> {
        let name = self.name()?;
        let attributes = self.list(0)?;
        Ok(Part { name, attributes })
    }

    fn skip_section(&mut self) -> Result<(), ReadError> {
        while !self.is_word("ENDSEC") {
            match self.peek() {
                None => return Err(self.fail("ENDSEC")),
                Some(b'\'') => drop(self.text()?),
                Some(b) if is_name(b) => drop(self.name()?),
                Some(_) => self.at += 1,
            }
        }
        self.word("ENDSEC")?;
        self.byte(b';')
    }

    fn data(&mut self, entities: &mut Vec<(u64, RawEntity)>) -> Result<(), ReadError> {
        loop {
            match self.peek() {
                Some(b'#') => {}
                _ if self.is_word("ENDSEC") => {
                    self.word("ENDSEC")?;
                    return self.byte(b';');
                }
                _ => return Err(self.fail("an entity or ENDSEC")),
            }
            let offset = self.at;
            let id = self.reference()?;
            self.byte(b'=')?;
            let is_complex = self.peek() == Some(b'(');
            let mut parts = Vec::with_capacity(usize::from(!is_complex));
            if is_complex {
                self.byte(b'(')?;
                while self.peek() != Some(b')') {
                    if parts.len() >= MOST_PARTS {
                        return Err(self.fail("the end of an entity of so many parts"));
                    }
                    parts.push(self.part()?);
                }
                self.byte(b')')?;
                parts.shrink_to_fit();
            } else {
                parts.push(self.part()?);
            }
            self.byte(b';')?;
            let entity = RawEntity {
                offset,
                parts,
                is_complex,
            };
            entities.push((id, entity));
        }
    }

    fn reference(&mut self) -> Result<u64, ReadError> {
        self.byte(b'#')?;
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let digits = rest.iter().take_while(|b| b.is_ascii_digit());
        let (count, id) = digits.fold((0, Some(0_u64)), |(n, id), b| {
            let id = id.and_then(|i| i.checked_mul(10)?.checked_add(u64::from(b - b'0')));
            (n + 1, id)
        });
        let id = id.filter(|_| count > 0);
        let id = id.ok_or_else(|| self.fail("the number of an entity"))?;
        self.at += count;
        Ok(id)
    }

    /// Recursion is bounded by [`MOST_NESTED`].
    fn list(&mut self, depth: usize) -> Result<Vec<Attribute>, ReadError> {
        if depth >= MOST_NESTED {
            return Err(self.fail("a list that is not nested so deep"));
        }
        self.byte(b'(')?;
        if self.peek() == Some(b')') {
            self.at += 1;
            return Ok(Vec::new());
        }
        let start = self.open.len();
        loop {
            let attribute = self.attribute(depth)?;
            self.open.push(attribute);
            match self.peek() {
                Some(b',') => self.at += 1,
                Some(b')') => {
                    self.at += 1;
                    return Ok(self.open.drain(start..).collect());
                }
                _ => return Err(self.fail("`,` or `)`")),
            }
        }
    }

    fn attribute(&mut self, depth: usize) -> Result<Attribute, ReadError> {
        let Some(b) = self.peek() else {
            return Err(self.fail("an attribute"));
        };
        Ok(match b {
            b'$' | b'*' => {
                self.at += 1;
                Attribute::Unset
            }
            b',' | b')' => {
                self.blank += 1;
                let most = MOST_BLANK.min(FEW_BLANK + self.bytes.len() / BYTES_A_BLANK);
                if self.blank > most {
                    return Err(self.fail("an attribute"));
                }
                Attribute::Unset
            }
            b'#' => Attribute::EntityRef(self.reference()?),
            b'(' => Attribute::List(self.list(depth + 1)?),
            b'\'' => Attribute::Text(self.text()?),
            b'.' if !self.bytes.get(self.at + 1).is_some_and(u8::is_ascii_digit) => {
                self.at += 1;
                let word = self.name()?;
                self.byte(b'.')?;
                Attribute::Enum(word)
            }
            b'"' => {
                let rest = self.bytes.get(self.at + 1..).unwrap_or_default();
                let Some(end) = rest.iter().position(|b| *b == b'"') else {
                    return Err(self.fail("a binary value"));
                };
                self.at += end + 2;
                Attribute::Unset
            }
            b'+' | b'-' | b'.' | b'0'..=b'9' => self.number()?,
            _ if is_name(b) || b == b'!' => {
                self.name()?;
                let mut inner = self.list(depth + 1)?;
                match (inner.pop(), inner.is_empty()) {
                    (Some(one), true) => Attribute::Typed(Box::new(one)),
                    _ => Attribute::Unset,
                }
            }
            _ => return Err(self.fail("an attribute")),
        })
    }

    fn number(&mut self) -> Result<Attribute, ReadError> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let count = rest
            .iter()
            .take_while(|b| matches!(b, b'+' | b'-' | b'.' | b'0'..=b'9' | b'E' | b'e'))
            .count();
        let text = std::str::from_utf8(rest.get(..count).unwrap_or_default()).unwrap_or("");
        let found = match text.parse::<i64>() {
            Ok(i) => Some(Attribute::Integer(i)),
            Err(_) => text.parse().ok().map(Attribute::Real),
        };
        let found = found.ok_or_else(|| self.fail("a number"))?;
        self.at += count;
        Ok(found)
    }

    /// A string, its escapes of the standard decoded.
    fn text(&mut self) -> Result<Box<str>, ReadError> {
        self.byte(b'\'')?;
        let start = self.at;
        loop {
            match self.bytes.get(self.at) {
                None => {
                    self.at = start;
                    return Err(self.fail("a string that ends"));
                }
                Some(b'\'') if self.bytes.get(self.at + 1) == Some(&b'\'') => self.at += 2,
                Some(b'\'') => break,
                Some(_) => self.at += 1,
            }
        }
        let raw = self.bytes.get(start..self.at).unwrap_or_default();
        self.at += 1;
        Ok(decoded(raw).into())
    }
}

/// Text is UTF-8, or else Latin-1; `''` is an apostrophe; `\X2\...\X0\` has UTF-16 in hexadecimal digits. Other escapes stay as they are.
fn decoded(raw: &[u8]) -> String {
    let is_special = |b: &u8| matches!(b, b'\'' | b'\\' | b'\n' | b'\r');
    let text = match std::str::from_utf8(raw) {
        Ok(text) if !raw.iter().any(is_special) => return text.to_string(),
        Ok(text) => text.to_string(),
        Err(_) => raw.iter().map(|b| char::from(*b)).collect(),
    };
    let text = text.replace("''", "'").replace(['\n', '\r'], "");
    let mut out = String::with_capacity(text.len());
    let mut rest = text.as_str();
    while let Some(at) = rest.find("\\X2\\") {
        let (before, after) = rest.split_at(at);
        let Some(end) = after.find("\\X0\\") else {
            break;
        };
        out.push_str(before);
        let digits = after.get(4..end).unwrap_or("");
        let units: Option<Vec<u16>> = { digits.as_bytes() }
            .chunks(4)
            .map(|c| u16::from_str_radix(std::str::from_utf8(c).ok()?, 16).ok())
            .collect();
        out.push_str(&String::from_utf16_lossy(&units.unwrap_or_default()));
        rest = after.get(end + 4..).unwrap_or("");
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(data: &str) -> Result<Graph, ReadError> {
        let text = format!(
            "ISO-10303-21; HEADER; FILE_DESCRIPTION((''),'2;1');\nFILE_SCHEMA(('Automotive_Design {{ 1 }}'));\nENDSEC;\n\
             DATA;\n{data}\nENDSEC;\nEND-ISO-10303-21;"
        );
        parse(text.as_bytes())
    }

    #[test]
    fn all_kinds_of_attributes() {
        let graph = read(
            "#1=A('it''s \\X2\\00E4\\X0\\',$,*,.T.,#22,-3,1.5E-3,-.5,(1.,(2)),B(7.),\"0F\"); /* ; */ #2 = (C()D(#1));",
        )
        .unwrap();
        assert_eq!(graph.schema, "AUTOMOTIVE_DESIGN { 1 }");
        use Attribute::*;
        let list = List(vec![Real(1.0), List(vec![Integer(2)])]);
        let expected = vec![
            Text("it's \u{e4}".into()),
            Unset,
            Unset,
            Enum("T".into()),
            EntityRef(22),
            Integer(-3),
            Real(1.5e-3),
            Real(-0.5),
            list,
            Typed(Box::new(Real(7.0))),
            Unset,
        ];
        assert_eq!(graph.get(1).unwrap().parts[0].attributes, expected);
        let two = graph.get(2).unwrap();
        assert!(two.is_complex && &*two.parts[1].name == "D");
    }

    #[test]
    fn what_is_no_step_file_is_said_with_its_line() {
        for (data, said) in [
            ("#1=A(", "the file ends"),
            ("#1=A();#1=B();ENDSEC;", "another number"),
            ("#1=A(&);", "an attribute expected"),
            (&format!("#1=({});", "A()".repeat(65)), "so many parts"),
            ("#1=A('", "a string that ends"),
            ("#1 A();", "`=` expected"),
            (&format!("#1=A({}", "(".repeat(100_000)), "nested so deep"),
            (
                &format!("#1=A({});", ",".repeat(10_000)),
                "an attribute expected",
            ),
        ] {
            let text = format!("ISO-10303-21;HEADER;ENDSEC;\nDATA;\n{data}");
            let why = parse(text.as_bytes()).err().unwrap().to_string();
            assert!(why.contains(said), "{why}");
        }
    }
}
