//! `plants.txt`: mistakes as text, and the kernel's files with them in.

use std::collections::BTreeMap;

/// A mistake.
#[derive(Debug, PartialEq)]
pub(super) struct Plant<'a> {
    pub(super) name: &'a str,
    hunks: Vec<Hunk<'a>>,
}

/// Lines of a file, without their indentation, with marks.
#[derive(Debug, PartialEq)]
struct Hunk<'a> {
    file: &'a str,
    lines: Vec<&'a str>,
}

/// What a mark becomes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Form {
    /// As it should be.
    Right,
    /// The mistake.
    Wrong,
    /// Either, by the switch of that number.
    Switched(usize),
}

pub(super) fn plants(text: &str) -> Result<Vec<Plant<'_>>, String> {
    let mut all: Vec<Plant<'_>> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let bad = || {
            format!(
                "plants.txt:{}: `= name`, then `@ file`, then `| line`",
                i + 1
            )
        };
        let (mark, rest) = line.split_once(' ').ok_or_else(bad)?;
        match mark {
            "=" => all.push(Plant {
                name: rest,
                hunks: Vec::new(),
            }),
            "@" => all.last_mut().ok_or_else(bad)?.hunks.push(Hunk {
                file: rest,
                lines: Vec::new(),
            }),
            "|" => {
                let hunk = all.last_mut().and_then(|p| p.hunks.last_mut());
                hunk.ok_or_else(bad)?.lines.push(rest.trim());
            }
            _ => return Err(bad()),
        }
    }
    Ok(all)
}

/// A text with its marks in that form; `None` where a mark is broken, or there is none.
fn in_form(marked: &str, form: Form) -> Option<String> {
    let mut out = String::new();
    let mut rest = marked;
    while let Some((before, mark)) = rest.split_once('«') {
        let (change, after) = mark.split_once('»')?;
        let (right, wrong) = change.split_once(" → ")?;
        out += before;
        match form {
            Form::Right => out += right,
            Form::Wrong => out += wrong,
            // An `if` that begins a statement ends it, too; elsewhere it must not.
            Form::Switched(n) if right.ends_with(';') => {
                out += &format!("if crate::planted({n}) {{ {wrong} }} else {{ {right} }}");
            }
            Form::Switched(n) => {
                out += &format!("(if crate::planted({n}) {{ {wrong} }} else {{ {right} }})");
            }
        }
        rest = after;
    }
    (rest.len() < marked.len()).then(|| out + rest)
}

/// The files with mistakes in them, each in its form. `read` gives a file as it is.
pub(super) fn planted<'a>(
    chosen: impl IntoIterator<Item = (&'a Plant<'a>, Form)>,
    read: impl Fn(&str) -> Result<String, String>,
) -> Result<BTreeMap<&'a str, String>, String> {
    // First line, number of lines, what takes their place.
    let mut changes: BTreeMap<&str, Vec<(usize, usize, String)>> = BTreeMap::new();
    for (plant, form) in chosen {
        if plant.hunks.is_empty() {
            return Err(format!("`{}` changes nothing", plant.name));
        }
        for hunk in &plant.hunks {
            let marked = hunk.lines.join("\n");
            let broken = || format!("`{}`: a mark is `«right → wrong»`", plant.name);
            let right = in_form(&marked, Form::Right).ok_or_else(broken)?;
            let other = in_form(&marked, form).ok_or_else(broken)?;
            let right: Vec<&str> = right.lines().collect();
            let text = read(hunk.file)?;
            let lines: Vec<&str> = text.lines().map(str::trim).collect();
            let found = lines.windows(right.len()).enumerate();
            let found: Vec<usize> = found
                .filter(|(_, w)| *w == &right[..])
                .map(|(i, _)| i)
                .collect();
            let &[at] = &found[..] else {
                return Err(format!(
                    "`{}`: its lines are {} times in {}; correct plants.txt",
                    plant.name,
                    found.len(),
                    hunk.file
                ));
            };
            changes
                .entry(hunk.file)
                .or_default()
                .push((at, right.len(), other));
        }
    }
    let mut all = BTreeMap::new();
    for (file, mut of_file) in changes {
        of_file.sort();
        let text = read(file)?;
        let lines: Vec<&str> = text.lines().collect();
        let (mut out, mut next) = (Vec::new(), 0);
        for (at, count, other) in &of_file {
            if *at < next {
                return Err(format!("{file}:{}: two mistakes in one line", at + 1));
            }
            out.extend(&lines[next..*at]);
            out.push(other.as_str());
            next = at + count;
        }
        out.extend(&lines[next..]);
        all.insert(file, out.join("\n") + "\n");
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(text: &str, file: &str, form: Form) -> Result<String, String> {
        let all = plants(text).unwrap();
        let all = planted(all.iter().map(|p| (p, form)), |_| Ok(file.to_owned()));
        all.map(|files| files.values().next().unwrap().clone())
    }

    #[test]
    fn a_mistake_is_written_in_three_forms() {
        let text = "= a\n@ f\n| let x = «1 → 2»;\n| «g(); → »\n";
        let file = "a\n    let x = 1;\n  g();\nb\n";
        assert_eq!(
            one(text, file, Form::Right).unwrap(),
            "a\nlet x = 1;\ng();\nb\n"
        );
        assert_eq!(
            one(text, file, Form::Wrong).unwrap(),
            "a\nlet x = 2;\n\nb\n"
        );
        assert_eq!(
            one(text, file, Form::Switched(7)).unwrap(),
            "a\nlet x = (if crate::planted(7) { 2 } else { 1 });\n\
             if crate::planted(7) {  } else { g(); }\nb\n"
        );
    }

    #[test]
    fn lines_that_are_not_there_or_twice_or_shared_are_refused() {
        let text = "= a\n@ f\n| «x → y»;\n";
        for file in ["a\nb\n", "x;\nx;\n", ""] {
            assert!(one(text, file, Form::Wrong).is_err(), "{file}");
        }
        let both = format!("{text}= b\n@ f\n| «x → z»;\n");
        assert!(one(&both, "x;\n", Form::Switched(1)).is_err());
    }

    #[test]
    fn broken_marks_are_refused() {
        for line in ["x;", "«x;", "«x»;", "«x→y»;"] {
            let text = format!("= a\n@ f\n| {line}\n");
            assert!(one(&text, "x;\n", Form::Wrong).is_err(), "{line}");
        }
        for text in ["| x\n", "@ f\n", "= a\n| x\n", "x\n"] {
            assert!(plants(text).is_err(), "{text}");
        }
        assert!(one("= a\n", "x;\n", Form::Wrong).is_err());
    }
}
