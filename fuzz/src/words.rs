//! Texts of OCCT with some words changed: random bytes are no text, and a change of a byte mostly makes no other number.

use crate::source::Source;

/// Small parts: a seam and poles, planes with rims, a periodic surface.
const PARTS: [&str; 3] = [
    include_str!("../../corpora/models/thesis/ball.brep"),
    include_str!("../../corpora/models/thesis/cylinder.brep"),
    include_str!("../../corpora/models/thesis/ball_nurbs_periodic.brep"),
];

/// What is no plain number.
const ODD: [&str; 8] = ["nan", "*", "+1", "-2", "i3", "CN", "0101000", "Fa"];

/// One of the parts with up to eight words replaced, taken out, said twice or moved.
pub(crate) fn mutated(s: &mut Source<'_>) -> String {
    let mut words: Vec<String> = PARTS[s.below(PARTS.len())]
        .split_inclusive(char::is_whitespace)
        .map(str::to_owned)
        .collect();
    // Behind the header, or all is lost at once.
    let first = 8;
    for _ in 0..1 + s.below(8) {
        let i = first + (s.below(256) * 256 + s.below(256)) % (words.len() - first);
        match s.below(8) {
            0 => drop(words.remove(i)),
            1 => words.insert(i, words[i].clone()),
            2 => {
                let j = first + s.below(256) % (words.len() - first);
                words.swap(i, j);
            }
            3 => words[i] = format!("{} ", ODD[s.below(ODD.len())]),
            4 | 5 => words[i] = format!("{} ", s.below(12)),
            6 => words[i] = format!("{} ", s.below(256) * 16_843_009),
            _ => words[i] = format!("{:?} ", s.hostile()),
        }
    }
    words.concat()
}
