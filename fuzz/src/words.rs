//! Texts of OCCT with some words changed: random bytes are no text, and a change of a byte mostly makes no other number.

use crate::source::Source;

/// Small parts: a seam and poles, planes with rims, a periodic surface.
const BREPS: [&str; 3] = [
    include_str!("../../corpora/models/thesis/ball.brep"),
    include_str!("../../corpora/models/thesis/cylinder.brep"),
    include_str!("../../corpora/models/thesis/ball_nurbs_periodic.brep"),
];

/// What is no plain number of a .brep.
const ODD: [&str; 8] = ["nan", "*", "+1", "-2", "i3", "CN", "0101000", "Fa"];

/// One of the parts with up to eight words replaced, taken out, said twice or moved.
pub(crate) fn mutated_brep(s: &mut Source<'_>) -> String {
    let words = BREPS[s.below(BREPS.len())].split_inclusive(char::is_whitespace);
    // Behind the header, or all is lost at once.
    let mut words = Words::new(words, 8);
    for _ in 0..1 + s.below(8) {
        let i = words.one(s);
        match s.below(8) {
            0..=2 => words.moved(s, i),
            3 => words.all[i] = format!("{} ", s.one_of(&ODD)),
            4 | 5 => words.all[i] = format!("{} ", s.below(12)),
            6 => words.all[i] = format!("{} ", s.below(256) * 16_843_009),
            _ => words.all[i] = format!("{:?} ", s.hostile()),
        }
    }
    words.all.concat()
}

/// Small parts: a face whose only bound is a vertex, rims with and without seams, curves on a torus, B-splines, planes in degrees, inches.
const STEPS: [&str; 8] = [
    include_str!("../../corpora/models/step/sphere_bare.step"),
    include_str!("../../corpora/models/step/cylinder_bare.step"),
    include_str!("../../corpora/models/step/cone_seamless.step"),
    include_str!("../../corpora/models/step/torus.step"),
    include_str!("../../corpora/models/step/torus_part_bare.step"),
    include_str!("../../corpora/models/step/elliptic_cylinder_seamless.step"),
    include_str!("../../corpora/models/step/revolution_nurbs_bare.step"),
    include_str!("../../corpora/models/step/box_bare.step"),
];

/// Attributes of STEP, valid where others are meant.
const ATTRIBUTES: [&str; 16] = [
    "$",
    "*",
    ".T.",
    ".F.",
    ".U.",
    "()",
    "''",
    "1.",
    "-0.",
    "1.E-07",
    "(1.,2.)",
    "LENGTH_MEASURE(2.)",
    "\"0FF\"",
    "((1,2),(3))",
    "'\\X2\\00E9\\X0\\'",
    ".UNSPECIFIED.",
];

/// The same of STEP, whose words are names, numbers, references, texts and single signs. Most changes leave a text whose syntax holds.
pub(crate) fn mutated_step(s: &mut Source<'_>) -> String {
    let text = STEPS[s.below(STEPS.len())];
    let all = split_step(text);
    let header = all.iter().position(|w| *w == "DATA");
    let mut words = Words::new(all.into_iter(), header.map_or(0, |n| n + 2));
    let entities = text.matches("\n#").count();
    for _ in 0..1 + s.below(8) {
        let mut i = words.one(s);
        let kind = s.below(12);
        if (3..10).contains(&kind) {
            // The next word that is one.
            let rest = &words.all[i..];
            i += { rest.iter() }.position(|w| is_word(w)).unwrap_or(0);
        }
        match kind {
            0..=2 => words.moved(s, i),
            // Another entity, rarely one that is not there.
            3..=5 => words.all[i] = format!("#{}", s.below(256) % (entities + 3)),
            6 | 7 => words.all[i] = s.one_of(&ATTRIBUTES).to_owned(),
            8 => words.all[i] = step_real(s.hostile()),
            9 => words.all[i] = s.below(12).to_string(),
            // A word of the file: a kind becomes another.
            _ => {
                let j = words.one(s);
                words.all[i] = words.all[j].clone();
            }
        }
    }
    words.all.concat()
}

/// A number as STEP writes it; what it cannot write, as something near it.
fn step_real(x: f64) -> String {
    if !x.is_finite() {
        return "1.E400".to_owned();
    }
    let text = format!("{x:E}");
    match text.split_once('E') {
        Some((m, e)) if m.contains('.') => format!("{m}E{e}"),
        Some((m, e)) => format!("{m}.E{e}"),
        None => text,
    }
}

fn is_word(w: &str) -> bool {
    w.starts_with(|c: char| c.is_ascii_alphanumeric() || "#'.-$*".contains(c))
}

/// A text's words, which joined are the text.
fn split_step(text: &str) -> Vec<&str> {
    let bytes = text.as_bytes();
    let belongs = |b: u8| b.is_ascii_alphanumeric() || b"_.+-#".contains(&b);
    let mut words = Vec::new();
    let mut from = 0;
    while from < bytes.len() {
        let rest = &bytes[from..];
        let until = |stop: &dyn Fn(u8) -> bool| {
            let end = rest[1..].iter().position(|b| stop(*b));
            end.map_or(rest.len(), |n| n + 1)
        };
        let length = match rest[0] {
            b'\'' => (until(&|b| b == b'\'') + 1).min(rest.len()),
            b if belongs(b) => until(&|b| !belongs(b)),
            _ => 1,
        };
        words.push(&text[from..from + length]);
        from += length;
    }
    words
}

/// The words of a text, of which those from `first` on are changed.
struct Words {
    all: Vec<String>,
    first: usize,
}

impl Words {
    fn new<'a>(words: impl Iterator<Item = &'a str>, first: usize) -> Self {
        Self {
            all: words.map(str::to_owned).collect(),
            first,
        }
    }

    /// Where one of them stands.
    fn one(&self, s: &mut Source<'_>) -> usize {
        self.first + (s.below(256) * 256 + s.below(256)) % (self.all.len() - self.first)
    }

    /// Takes a word out, says it twice, or swaps it with another.
    fn moved(&mut self, s: &mut Source<'_>, i: usize) {
        match s.below(3) {
            0 => drop(self.all.remove(i)),
            1 => self.all.insert(i, self.all[i].clone()),
            _ => {
                let j = self.one(s);
                self.all.swap(i, j);
            }
        }
    }
}
