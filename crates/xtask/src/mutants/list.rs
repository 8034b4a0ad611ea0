//! The changes, found in the syntax tree, and a file with switches for some of them.
//!
//! As cargo-mutants has them: a binary, assignment or unary operator for another, a function's value for one of its type, a guard for `true` or `false`, an arm
//! of a `match` with a wildcard left out. Not in tests, macros, patterns, types, and `const` items and functions, which have no switch.

use proc_macro2::Span;
use std::collections::BTreeMap;
use std::ops::Range;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{
    Attribute, BinOp, Block, Expr, ImplItemFn, ItemFn, ItemMod, Pat, ReturnType, Signature,
    TraitItemFn, Type, UnOp,
};

/// A change.
#[derive(Clone, Debug)]
pub(super) struct Mutant {
    /// Path from the root of the tree.
    pub(super) file: String,
    /// What is changed where, without the line: the same as long as the function is.
    pub(super) name: String,
    pub(super) line: usize,
    /// Bytes of the file that the switch is about.
    pub(super) range: Range<usize>,
    form: Form,
}

#[derive(Clone, Debug)]
enum Form {
    /// This expression for that one.
    Instead(String),
    /// At the start of a body.
    Return(String),
    /// An arm that is left out, by a guard that it gets.
    NoArm,
    /// The same, in front of the guard it has.
    NoGuardedArm,
}

impl Mutant {
    /// What comes before the bytes, and after them.
    fn switch(&self, number: usize) -> (String, String) {
        let on = format!("crate::mutant({number})");
        match &self.form {
            Form::Instead(other) => (format!("(if {on} {{ {other} }} else {{ "), " })".into()),
            Form::Return(value) => (format!(" if {on} {{ return {value}; }} "), String::new()),
            Form::NoArm => (format!(" if !{on}"), String::new()),
            Form::NoGuardedArm => (format!("!{on} && ("), ")".into()),
        }
    }
}

/// A file with a switch for each of these, which are all of that file; and where in it what is changed by each stands, with its number.
pub(super) fn with_switches(
    text: &str,
    chosen: &[(usize, &Mutant)],
) -> (String, Vec<(Range<usize>, usize)>) {
    // Position; closings before openings; of those the inner first, of these the outer.
    let mut pieces: Vec<(usize, bool, isize, String, usize)> = Vec::new();
    for (i, (number, mutant)) in chosen.iter().enumerate() {
        let (before, after) = mutant.switch(*number);
        let Range { start, end } = mutant.range.clone();
        let (length, turn) = ((end - start) as isize, i as isize);
        let rank = length * chosen.len() as isize + turn;
        // What is at a place, and not about a range, comes before all that begins there.
        let first = if length == 0 {
            isize::MIN + turn
        } else {
            -rank
        };
        pieces.push((start, true, first, before, *number));
        if !after.is_empty() {
            pieces.push((end, false, rank, after, *number));
        }
    }
    pieces.sort();
    let (mut out, mut next, mut places) = (String::new(), 0, Vec::new());
    for (at, opens, _, piece, number) in pieces {
        out += &text[next..at];
        if opens {
            places.push((out.len()..out.len() + piece.len(), number));
        }
        out += &piece;
        next = at;
    }
    (out + &text[next..], places)
}

/// The changes of a file.
pub(super) fn mutants(file: &str, text: &str) -> Result<Vec<Mutant>, String> {
    let tree = syn::parse_file(text).map_err(|e| format!("{file}: {e}"))?;
    let mut found = Finder {
        file,
        text,
        function: Vec::new(),
        all: Vec::new(),
    };
    found.visit_file(&tree);
    // Several that say the same of one function are told apart by their turn.
    let mut turns: BTreeMap<String, usize> = BTreeMap::new();
    for m in &mut found.all {
        let turn = turns.entry(m.name.clone()).or_default();
        *turn += 1;
        if *turn > 1 {
            m.name += &format!(" #{turn}");
        }
    }
    Ok(found.all)
}

struct Finder<'a> {
    file: &'a str,
    text: &'a str,
    /// The functions and types around what is looked at.
    function: Vec<String>,
    all: Vec<Mutant>,
}

impl Finder<'_> {
    fn add(&mut self, at: Span, range: Range<usize>, what: &str, form: Form) {
        // Short names of files are unique in a module.
        let place = self.function.join("::");
        let name = format!("{}: {what} in {place}", self.file);
        self.all.push(Mutant {
            file: self.file.to_owned(),
            name,
            line: at.start().line,
            range,
            form,
        });
    }

    fn source(&self, of: &impl Spanned) -> String {
        self.text[of.span().byte_range()].to_owned()
    }

    fn function(&mut self, signature: &Signature, body: &Block) {
        let name = signature.ident.to_string();
        let skipped = signature.constness.is_some() || name == "fmt" || name == "default";
        if skipped || body.stmts.is_empty() {
            return;
        }
        self.function.push(name);
        let start = body.brace_token.span.open().byte_range().end;
        let whole = self.source(body);
        for value in values_returned(&signature.output) {
            if whole.trim_matches(['{', '}', ' ', '\n']) != value {
                let what = format!("return {value}");
                let form = Form::Return(value);
                self.add(signature.ident.span(), start..start, &what, form);
            }
        }
        visit::visit_block(self, body);
        self.function.pop();
    }
}

/// What is for tests alone.
fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|a| {
        let path = a.path();
        let is_cfg_test = path.is_ident("cfg")
            && matches!(&a.meta, syn::Meta::List(l) if l.tokens.to_string() == "test");
        path.is_ident("test") || is_cfg_test
    })
}

/// A condition that binds names holds no switch.
fn has_let(e: &Expr) -> bool {
    match e {
        Expr::Let(_) => true,
        Expr::Binary(b) => has_let(&b.left) || has_let(&b.right),
        _ => false,
    }
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        if is_test(&item.attrs) {
            return;
        }
        self.function.push(self.source(&item.self_ty));
        visit::visit_item_impl(self, item);
        self.function.pop();
    }

    fn visit_item_fn(&mut self, item: &'ast ItemFn) {
        if !is_test(&item.attrs) {
            self.function(&item.sig, &item.block);
        }
    }

    fn visit_impl_item_fn(&mut self, item: &'ast ImplItemFn) {
        if !is_test(&item.attrs) {
            self.function(&item.sig, &item.block);
        }
    }

    fn visit_trait_item_fn(&mut self, item: &'ast TraitItemFn) {
        if let Some(body) = &item.default {
            self.function(&item.sig, body);
        }
    }

    // What is evaluated while compiling.
    fn visit_item_const(&mut self, _: &'ast syn::ItemConst) {}
    fn visit_impl_item_const(&mut self, _: &'ast syn::ImplItemConst) {}
    fn visit_trait_item_const(&mut self, _: &'ast syn::TraitItemConst) {}
    fn visit_item_static(&mut self, _: &'ast syn::ItemStatic) {}
    fn visit_type(&mut self, _: &'ast Type) {}
    fn visit_pat(&mut self, _: &'ast Pat) {}
    fn visit_generic_argument(&mut self, _: &'ast syn::GenericArgument) {}
    fn visit_expr_repeat(&mut self, e: &'ast syn::ExprRepeat) {
        self.visit_expr(&e.expr);
    }

    fn visit_expr_binary(&mut self, e: &'ast syn::ExprBinary) {
        let range = e.span().byte_range();
        let from = self.source(&e.op);
        if !has_let(&Expr::Binary(e.clone())) {
            for to in operators(&e.op) {
                let (left, right) = (self.source(&e.left), self.source(&e.right));
                let other = if to.ends_with('=') && !matches!(*to, "==" | "!=" | "<=" | ">=") {
                    format!("{left} {to} ({right})")
                } else {
                    format!("({left}) {to} ({right})")
                };
                let what = format!("{from} -> {to}");
                self.add(e.op.span(), range.clone(), &what, Form::Instead(other));
            }
        }
        visit::visit_expr_binary(self, e);
    }

    fn visit_expr_unary(&mut self, e: &'ast syn::ExprUnary) {
        if matches!(e.op, UnOp::Not(_) | UnOp::Neg(_)) {
            let what = format!("no {}", self.source(&e.op));
            let form = Form::Instead(self.source(&e.expr));
            self.add(e.span(), e.span().byte_range(), &what, form);
        }
        visit::visit_expr_unary(self, e);
    }

    fn visit_expr_match(&mut self, e: &'ast syn::ExprMatch) {
        let has_wildcard = e.arms.iter().any(|a| matches!(a.pat, Pat::Wild(_)));
        for arm in &e.arms {
            let pattern = arm.pat.span().byte_range();
            let shown = self.source(&arm.pat);
            if let Some((_, guard)) = &arm.guard {
                let range = guard.span().byte_range();
                for value in ["true", "false"] {
                    let what = format!("guard {value} of {shown}");
                    let form = Form::Instead(value.to_owned());
                    self.add(guard.span(), range.clone(), &what, form);
                }
                if has_wildcard && !matches!(arm.pat, Pat::Wild(_)) {
                    let what = format!("no arm {shown}");
                    self.add(arm.pat.span(), range, &what, Form::NoGuardedArm);
                }
            } else if has_wildcard && !matches!(arm.pat, Pat::Wild(_)) {
                let what = format!("no arm {shown}");
                self.add(arm.pat.span(), pattern.end..pattern.end, &what, Form::NoArm);
            }
        }
        visit::visit_expr_match(self, e);
    }
}

fn operators(op: &BinOp) -> &'static [&'static str] {
    match op {
        BinOp::Eq(_) => &["!="],
        BinOp::Ne(_) => &["=="],
        BinOp::And(_) => &["||"],
        BinOp::Or(_) => &["&&"],
        BinOp::Lt(_) => &["==", ">", "<="],
        BinOp::Gt(_) => &["==", "<", ">="],
        BinOp::Le(_) => &[">", "<"],
        BinOp::Ge(_) => &["<", ">"],
        BinOp::Add(_) => &["-", "*"],
        BinOp::Sub(_) => &["+", "/"],
        BinOp::Mul(_) => &["+", "/"],
        BinOp::Div(_) => &["%", "*"],
        BinOp::Rem(_) => &["/", "+"],
        BinOp::Shl(_) => &[">>"],
        BinOp::Shr(_) => &["<<"],
        BinOp::BitAnd(_) => &["|", "^"],
        BinOp::BitOr(_) => &["&", "^"],
        BinOp::BitXor(_) => &["|", "&"],
        BinOp::AddAssign(_) => &["-=", "*="],
        BinOp::SubAssign(_) => &["+=", "/="],
        BinOp::MulAssign(_) => &["+=", "/="],
        BinOp::DivAssign(_) => &["%=", "*="],
        BinOp::RemAssign(_) => &["/=", "+="],
        BinOp::ShlAssign(_) => &[">>="],
        BinOp::ShrAssign(_) => &["<<="],
        BinOp::BitAndAssign(_) => &["|=", "^="],
        BinOp::BitOrAssign(_) => &["&=", "^="],
        BinOp::BitXorAssign(_) => &["|=", "&="],
        _ => &[],
    }
}

fn values_returned(output: &ReturnType) -> Vec<String> {
    match output {
        ReturnType::Default => vec!["()".to_owned()],
        ReturnType::Type(_, of) => values(of),
    }
}

/// Some values of a type, as far as its name tells.
fn values(of: &Type) -> Vec<String> {
    let all = |words: &[&str]| words.iter().map(|w| (*w).to_owned()).collect();
    match of {
        Type::Tuple(t) if t.elems.is_empty() => all(&["()"]),
        Type::Tuple(t) => {
            // The first of each, then each other one beside the firsts.
            let each: Vec<Vec<String>> = t.elems.iter().map(values).collect();
            let firsts: Vec<&str> = each.iter().map(|v| v[0].as_str()).collect();
            let mut rows = vec![firsts.clone()];
            for (i, of_one) in each.iter().enumerate() {
                for other in &of_one[1..] {
                    let mut row = firsts.clone();
                    row[i] = other;
                    rows.push(row);
                }
            }
            rows.iter()
                .map(|r| format!("({},)", r.join(", ")))
                .collect()
        }
        Type::Array(a) => {
            let filled = |v: String| format!("std::array::from_fn(|_| {v})");
            values(&a.elem).into_iter().map(filled).collect()
        }
        Type::Path(p) => {
            let Some(last) = p.path.segments.last() else {
                return all(&["Default::default()"]);
            };
            let inner = || match &last.arguments {
                syn::PathArguments::AngleBracketed(a) => match a.args.first() {
                    Some(syn::GenericArgument::Type(t)) => values(t),
                    _ => Vec::new(),
                },
                _ => Vec::new(),
            };
            let wrapped = |with: &str| -> Vec<String> {
                inner().iter().map(|v| format!("{with}({v})")).collect()
            };
            match last.ident.to_string().as_str() {
                "bool" => all(&["true", "false"]),
                "u8" | "u16" | "u32" | "u64" | "u128" | "usize" => all(&["0", "1"]),
                "i8" | "i16" | "i32" | "i64" | "i128" | "isize" => all(&["0", "1", "-1"]),
                "f32" | "f64" => all(&["0.0", "1.0", "-1.0"]),
                "String" => all(&["String::new()", "\"xyzzy\".into()"]),
                "Option" => [all(&["None"]), wrapped("Some")].concat(),
                "Result" => wrapped("Ok"),
                "Box" => wrapped("Box::new"),
                "Vec" => {
                    let one = inner().into_iter().map(|v| format!("vec![{v}]"));
                    std::iter::once("vec![]".to_owned()).chain(one).collect()
                }
                _ => all(&["Default::default()"]),
            }
        }
        _ => all(&["Default::default()"]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_changed_and_what_is_not() {
        let text = "const N: usize = 2 + 3;\nfn f(a: i32) -> bool { a + 1 > 2 * a }\n\
                    const fn g() -> bool { true }\n#[cfg(test)]\nmod t { fn h() { let _ = 1 + 1; } }\n";
        let all = mutants("x.rs", text).unwrap();
        let names: Vec<&str> = all.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(
            names,
            [
                "x.rs: return true in f",
                "x.rs: return false in f",
                "x.rs: > -> == in f",
                "x.rs: > -> < in f",
                "x.rs: > -> >= in f",
                "x.rs: + -> - in f",
                "x.rs: + -> * in f",
                "x.rs: * -> + in f",
                "x.rs: * -> / in f",
            ]
        );
        assert!(all.iter().all(|m| m.line == 2));
    }

    #[test]
    fn switches_nest() {
        let text = "fn f(a: i32) -> i32 { match a { 1 if a > 0 => a * (2 - a), 3 => 1, _ => -a } }";
        let all = mutants("x.rs", text).unwrap();
        let numbered: Vec<(usize, &Mutant)> = (1..).zip(&all).collect();
        let (out, places) = with_switches(text, &numbered);
        assert_eq!(places.len(), all.len());
        assert!(syn::parse_file(&out).is_ok(), "{out}");
        let count = |part: &str| out.matches(part).count();
        assert_eq!(count("crate::mutant("), all.len());
        let one = |what: &str| -> String {
            let i = all.iter().position(|m| m.name.contains(what)).unwrap();
            with_switches(text, &[(7, &all[i])]).0
        };
        let found = one("* -> +");
        assert!(
            found.contains("(if crate::mutant(7) { (a) + ((2 - a)) } else { a * (2 - a) })"),
            "{found}"
        );
        let found = one("no arm 1");
        assert!(
            found.contains("1 if !crate::mutant(7) && (a > 0) =>"),
            "{found}"
        );
        let found = one("no arm 3");
        assert!(found.contains("3 if !crate::mutant(7) => 1"), "{found}");
        let found = one("return -1");
        assert!(
            found.contains("{ if crate::mutant(7) { return -1; } "),
            "{found}"
        );
    }

    #[test]
    fn values_of_types() {
        let of = |t: &str| values(&syn::parse_str(t).unwrap());
        assert_eq!(of("Option<bool>"), ["None", "Some(true)", "Some(false)"]);
        assert_eq!(
            of("(bool, f64)"),
            [
                "(true, 0.0,)",
                "(false, 0.0,)",
                "(true, 1.0,)",
                "(true, -1.0,)"
            ]
        );
        assert_eq!(of("Vec<u8>"), ["vec![]", "vec![0]", "vec![1]"]);
        assert_eq!(of("Ball"), ["Default::default()"]);
    }
}
