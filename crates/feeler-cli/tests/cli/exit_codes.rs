//! Exit codes and error lines: bad input gives one line on standard error that names the file, the place
//! and the remedy, and exit code 2; undecided answers give 1, all others 0.

use crate::program::{Run, feeler, root};
use serde_json::Value;
use std::path::PathBuf;

const PART: &str = "corpora/models/thesis/cube_corner_sphere_cut_nurbs.3dm";

/// A file of this test alone, in the folder that cargo gives tests.
fn scratch(name: &str, bytes: &[u8]) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

/// The run was refused as a whole, in one line that holds all these words.
fn refused(run: &Run, words: &[&str]) {
    assert_eq!(run.code, Some(2), "{run:?}");
    assert_eq!(run.out, "", "{run:?}");
    one_line(run, words);
}

fn one_line(run: &Run, words: &[&str]) {
    assert_eq!(run.err.lines().count(), 1, "{run:?}");
    assert!(run.err.starts_with("error: "), "{run:?}");
    for word in words {
        assert!(run.err.contains(word), "no `{word}` in {run:?}");
    }
}

fn answers(run: &Run) -> Vec<Value> {
    let lines = run.out.lines();
    lines.map(|l| serde_json::from_str(l).unwrap()).collect()
}

#[test]
fn good_queries_end_with_0() {
    for probe in [
        ["--half-space", "0,0,1,0.5"],
        ["--line", "-5,5,5,1,0.25,0.125"],
    ] {
        let run = feeler(&["contact", PART, probe[0], probe[1]], "");
        assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{run:?}");
        let answer = &answers(&run)[0];
        assert!(answer.get("error").is_none() && answer.get("undecided").is_none());
    }
    let run = feeler(
        &["contact", PART],
        "{\"inside\":{\"point\":[5,5,5]},\"id\":7}\n",
    );
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{run:?}");
    assert_eq!(run.out, "{\"id\":7,\"side\":\"inside\",\"in_gap\":false}\n");
    let run = feeler(&["inspect", PART], "");
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{run:?}");
    // Nothing asked, nothing answered.
    let run = feeler(&["contact", PART], "");
    assert_eq!((run.code, run.out.as_str()), (Some(0), ""), "{run:?}");
}

#[test]
fn a_ball_that_moves_arrives_or_never_does() {
    // The hole has radius 2.5 about the origin: half a millimetre at a quarter a second.
    const JOINT: &str = "corpora/models/thesis/ball_joint_cavity_nurbs.3dm";
    let ball = ["contact", JOINT, "--sphere", "0,0,0,2", "--velocity"];
    let run = feeler(&[&ball[..], &["0,0,-0.25"]].concat(), "");
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{run:?}");
    let answer = &answers(&run)[0];
    let time = |bound: &str| answer["arrival"][bound].as_f64().unwrap();
    assert!((time("value") - 2.0).abs() < 1e-9, "{run:?}");
    assert!(time("lo") <= time("hi") && time("hi") - time("lo") < 1e-9);
    assert_eq!(answer["contacts"].as_array().unwrap().len(), 1);
    let never = feeler(&[&ball[..], &["0,0,-0.25", "--until", "1.75"]].concat(), "");
    assert_eq!(never.code, Some(0));
    let silent = "{\"arrival\":null,\"continuum\":false,\"contacts\":[]}\n";
    assert_eq!(never.out, silent);
    let bad = feeler(&[&ball[..], &["0,0,nan"]].concat(), "");
    refused(&bad, &[JOINT, "velocity", "not finite"]);
}

/// The distance is irrational: no enclosure by f64 can be as narrow as asked.
#[test]
fn an_undecided_answer_ends_with_1() {
    let arguments = [
        "contact",
        PART,
        "--sphere",
        "-1,-2,-3,0.5",
        "--accuracy",
        "1e-300",
    ];
    let run = feeler(&arguments, "");
    assert_eq!((run.code, run.err.as_str()), (Some(1), ""), "{run:?}");
    let answer = &answers(&run)[0];
    assert!(answer["undecided"].is_string(), "{run:?}");
    // The bound that there is: sqrt(14) - 0.5, rounded outward.
    let exact = 3.241_657_386_773_941_3;
    let end = |name: &str| answer["separation"][name].as_f64().unwrap();
    assert!(end("lo") <= exact && exact <= end("hi"), "{run:?}");
    assert!(end("hi") - end("lo") < 1e-14, "{run:?}");
}

#[test]
fn a_file_of_another_format() {
    let path = scratch("text.3dm", b"this is no model\n");
    let path = path.to_str().unwrap();
    for command in ["inspect", "contact"] {
        let run = feeler(&[command, path], "");
        refused(&run, &["text.3dm", "not a .3dm file", "export the model"]);
    }
}

/// OCCT's text format, told by its content; by its name where that says nothing.
#[test]
fn a_brep_file() {
    let part = |end: &str| format!("corpora/models/thesis/ball_joint_cavity_nurbs.{end}");
    let [ours, theirs] = ["brep", "3dm"].map(|end| {
        let run = feeler(
            &["contact", &part(end), "--sphere", "0.01,0.02,0.03,2.51"],
            "",
        );
        assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{run:?}");
        answers(&run).swap_remove(0)
    });
    // The faces have the same bits in both files.
    assert_eq!(ours["separation"], theirs["separation"]);
    assert_eq!(
        ours["contacts"][0]["feature"],
        theirs["contacts"][0]["feature"]
    );

    let whole = std::fs::read(root().join(part("brep"))).unwrap();
    let renamed = scratch("renamed.3dm", &whole);
    let run = feeler(&["inspect", renamed.to_str().unwrap()], "");
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{run:?}");
    let head = "brep version 3, units none, 1 objects\nobject 0: brep\n  7 faces, 7 loops, 28 trims, 13 edges, 10 vertices; closed\n";
    assert!(run.out.starts_with(head), "{run:?}");

    let half = scratch("half.brep", &whole[..whole.len() / 2]);
    let text = scratch("text.brep", b"this is no model\n");
    for command in ["inspect", "contact"] {
        let run = feeler(&[command, half.to_str().unwrap()], "");
        refused(&run, &["half.brep", "line ", "cut off", "write it again"]);
        let run = feeler(&[command, text.to_str().unwrap()], "");
        refused(&run, &["text.brep", "line 1", "not a .brep file", "export"]);
    }
    // A surface of one object is refused by name, and the others can be asked alone.
    let some = "corpora/models/brep/refused.brep";
    refused(
        &feeler(&["contact", some], ""),
        &["refused.brep", "object 0", "offset surface", "--object"],
    );
    let run = feeler(
        &["contact", some, "--object", "4", "--line", "0,0,0,1,2,4"],
        "",
    );
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{run:?}");
}

/// What could not be read is shown, and the exit code says that there is some.
#[test]
fn inspect_tells_refused_objects_by_its_exit_code() {
    for (file, count) in [
        (
            "corpora/models/brep/refused.brep",
            "1 objects cannot be read",
        ),
        (
            "corpora/models/3dm/blocks_linked_v8.3dm",
            "3 objects cannot be read",
        ),
    ] {
        for json in [&[][..], &["--json"]] {
            let run = feeler(&[&["inspect", file][..], json].concat(), "");
            assert_eq!(run.code, Some(2), "{run:?}");
            assert!(run.err.contains(file) && run.err.contains(count), "{run:?}");
            assert!(run.out.contains("refused"), "{run:?}");
        }
    }
}

/// A surface that is no part of a BREP is asked by itself.
#[test]
fn loose_surfaces_are_named() {
    let plane = feeler::nurbs::Plane {
        origin: [0.0; 3].into(),
        x: [1.0, 0.0, 0.0].into(),
        y: [0.0, 1.0, 0.0].into(),
        domain: [feeler::numeric::Interval {
            start: 0.0,
            end: 1.0,
        }; 2],
        extents: [feeler::numeric::Interval {
            start: 0.0,
            end: 1.0,
        }; 2],
    };
    let mut builder = feeler::brep::BrepBuilder::new();
    builder.whole_surface(feeler::nurbs::Surface::Plane(plane));
    let mut document = feeler_io::Document::of_breps(vec![builder.build().unwrap()]);
    let feeler_io::ObjectKind::Brep(sheet) = document.objects[0].kind.clone() else {
        panic!("a BREP");
    };
    document.objects[0].kind = feeler_io::ObjectKind::Surface(sheet);
    let bytes = feeler_io::write_3dm(&document).unwrap().bytes;
    let file = scratch("sheet.3dm", &bytes);
    let file = file.to_str().unwrap();
    let ask = ["contact", file, "--sphere", "0.5,0.5,1,0.25"];
    refused(
        &feeler(&ask, ""),
        &["sheet.3dm", "loose surfaces", "--object 0"],
    );
    let run = feeler(&[&ask[..], &["--object", "0"]].concat(), "");
    assert_eq!(run.code, Some(0), "{run:?}");
}

#[test]
fn a_truncated_file() {
    let whole = std::fs::read(root().join(PART)).unwrap();
    let half = scratch("half.3dm", &whole[..whole.len() / 2]);
    let half = half.to_str().unwrap();
    for command in ["inspect", "contact"] {
        let run = feeler(&[command, half], "");
        refused(&run, &["half.3dm", "truncated", "byte", "save it again"]);
    }
    let empty = scratch("empty.3dm", b"");
    let run = feeler(&["inspect", empty.to_str().unwrap()], "");
    refused(&run, &["empty.3dm", "empty", "export the model"]);
}

#[test]
fn a_missing_file() {
    for command in ["inspect", "contact"] {
        let run = feeler(&[command, "no/such/part.3dm"], "");
        refused(&run, &["no/such/part.3dm", "check the path"]);
    }
    let run = feeler(&["contact", PART, "--object", "7"], "");
    refused(&run, &[PART, "object 7", "feeler inspect"]);
    let run = feeler(&["gate", "--corpora", "no/such/corpus"], "");
    refused(&run, &["no/such/corpus", "check the path"]);
    let run = feeler(&["gate", "--suite", "no-such-suite"], "");
    refused(&run, &["no-such-suite", "suite.json"]);
}

#[test]
fn impossible_probes_on_the_command_line() {
    for (flag, value, what, remedy) in [
        (
            "--sphere",
            "0,0,0,nan",
            "the radius is not finite",
            "give a number",
        ),
        (
            "--sphere",
            "0,0,0,inf",
            "the radius is not finite",
            "give a number",
        ),
        ("--sphere", "nan,0,0,1", "not finite", "give a number"),
        (
            "--sphere",
            "0,0,0,-1",
            "the radius is negative",
            "give 0 or more",
        ),
        (
            "--line",
            "0,0,0,0,0,0",
            "the direction is zero",
            "give a vector",
        ),
        (
            "--half-space",
            "1,1,0,0",
            "not a unit vector",
            "divide it by its length",
        ),
        (
            "--half-space",
            "0,0,0,0",
            "not a unit vector",
            "divide it by its length",
        ),
    ] {
        let run = feeler(&["contact", PART, flag, value], "");
        refused(&run, &[PART, flag, what, remedy]);
    }
}

#[test]
fn bad_usage() {
    for (arguments, words) in [
        (&["bogus"][..], &["bogus"][..]),
        (&["contact"], &["<FILE>"]),
        (&["contact", PART, "--sphere", "0,0,0"], &["--sphere", "4"]),
        (
            &["contact", PART, "--sphere", "0,0,0,x"],
            &["--sphere", "`x` is no number"],
        ),
        (
            &["contact", PART, "--accuracy", "nan"],
            &["--accuracy", "positive length"],
        ),
        (
            &["contact", PART, "--accuracy", "0"],
            &["--accuracy", "positive length"],
        ),
        (
            &["contact", PART, "--prediction", "nan"],
            &["--prediction", "length"],
        ),
        (&["contact", PART, "--kind", "ray"], &["--line"]),
    ] {
        refused(&feeler(arguments, ""), words);
    }
    assert_eq!(feeler(&["--help"], "").code, Some(0));
    assert_eq!(feeler(&["--version"], "").code, Some(0));
    assert_eq!(feeler(&[], "").code, Some(2));
}

/// Each bad line alone among two good ones: these are answered, its own answer is an error, and the
/// one line on standard error names file, line and remedy.
#[test]
fn a_bad_query_among_good_ones() {
    let good = r#"{"evaluate":{"face":0,"uv":[0.5,0.5]},"id":"good"}"#;
    for (bad, what) in [
        (
            r#"{"sphere":{"center":[0,0,0],"radius":NaN}}"#,
            "not valid JSON",
        ),
        (
            r#"{"sphere":{"center":[0,0,0],"radius":1e999}}"#,
            "not valid JSON",
        ),
        (
            r#"{"sphere":{"center":[0,0,0],"radius":-1}}"#,
            "the radius is negative",
        ),
        (r#"{"sphere":{"center":[0,0],"radius":1}}"#, "not a query"),
        (
            r#"{"line":{"origin":[0,0,0],"direction":[0,0,0]}}"#,
            "the direction is zero",
        ),
        (
            r#"{"half_space":{"normal":[1,1,0],"offset":0}}"#,
            "not a unit vector",
        ),
        (r#"{"evaluate":{"face":99,"uv":[0,0]}}"#, "no face 99"),
        (
            r#"{"spere":{"center":[0,0,0],"radius":1}}"#,
            "unknown field `spere`",
        ),
        ("{}", "asks one of sphere"),
        ("[1]", "not a list"),
        ("not json", "not valid JSON"),
        ("", "not valid JSON"),
        (r#"{"sphere": "#, "not valid JSON"),
    ] {
        let run = feeler(&["contact", PART], &format!("{good}\n{bad}\n{good}\n"));
        assert_eq!(run.code, Some(2), "{bad}: {run:?}");
        one_line(&run, &[PART, "query line 2", what, "correct the query"]);
        let all = answers(&run);
        assert_eq!(all.len(), 3, "{bad}: {run:?}");
        assert!(
            all[1]["error"].as_str().unwrap().contains(what),
            "{bad}: {run:?}"
        );
        for i in [0, 2] {
            assert_eq!(all[i]["id"], "good");
            assert!(all[i]["point"].is_array(), "{bad}: {run:?}");
        }
    }
}

/// Bytes that are no text, and a line without end, are refused like any other.
#[test]
fn wild_input() {
    let long = "9".repeat(3 << 20);
    let run = feeler(
        &["contact", PART],
        &format!("{long}\n{{\"inside\":{{\"point\":[5,5,5]}}}}"),
    );
    assert_eq!(run.code, Some(2));
    one_line(&run, &["query line 1", "longer than"]);
    assert_eq!(answers(&run)[1]["side"], "inside");
    let deep = "[".repeat(1 << 19);
    let run = feeler(&["contact", PART], &format!("{{\"id\":{deep}\n"));
    assert_eq!(run.code, Some(2));
    one_line(&run, &["query line 1", "not valid JSON"]);
}

/// Whoever asks without waiting tells by the id which line was refused, whatever is wrong with it.
#[test]
fn a_refused_line_keeps_its_id() {
    for (line, what) in [
        (r#"{"inside":{"point":[1,2]},"id":14}"#, "length 2"),
        (r#"{"id":14,"ball":1}"#, "unknown field `ball`"),
        (
            r#"{"id":14,"inside":{"point":[0,0,1e999]}}"#,
            "out of range",
        ),
        (r#"{"id":14,"inside":{"point":[0,0,1e99]}}"#, "range"),
        (
            r#"{"id":14,"side":{"face":99,"uv":[0,0]}}"#,
            "there are 7, ask about 0 to 6",
        ),
    ] {
        let run = feeler(&["contact", PART], line);
        assert_eq!(run.code, Some(2), "{line}: {run:?}");
        let answer = &answers(&run)[0];
        assert_eq!(answer["id"], 14, "{line}: {run:?}");
        let error = answer["error"].as_str().unwrap();
        assert!(error.contains(what), "{line}: {error}");
    }
    // What is no object has none.
    let run = feeler(&["contact", PART], r#"{"id":14,"inside":"#);
    assert_eq!(answers(&run)[0].get("id"), None, "{run:?}");
}

/// Nothing in the first line of the protocol is passed over.
#[test]
fn the_first_line_of_an_engine() {
    let good = r#"{"inside":{"point":[0,0,0]}}"#;
    for (first, words) in [
        (
            format!(r#"{{"model":"{PART}","foo":1}}"#),
            &[
                "unknown field `foo`",
                "`model`, `object`, `accuracy`",
                "write {",
            ][..],
        ),
        (
            format!(r#"{{"model":"{PART}","accuracy":"Full"}}"#),
            &["\"Full\", expected a positive length or \"full\""],
        ),
        (
            format!(r#"{{"model":"{PART}","accuracy":0}}"#),
            &["positive length"],
        ),
        (
            format!(r#"{{"model":"{PART}","object":-1}}"#),
            &["-1", "write {"],
        ),
        (
            r#"{"object":0}"#.to_owned(),
            &["missing field `model`", "write {"],
        ),
        (r#"["part.3dm"]"#.to_owned(), &["a list", "write {"]),
        ("hello".to_owned(), &["not valid JSON", "write {"]),
    ] {
        let run = feeler(&["engine"], &format!("{first}\n{good}\n"));
        assert_eq!(run.code, Some(2), "{first}: {run:?}");
        let all = answers(&run);
        let error = all[0]["error"].as_str().unwrap();
        assert_eq!(all.len(), 1, "{run:?}");
        for word in words {
            assert!(error.contains(word), "{first}: no `{word}` in {error}");
        }
    }
    let first = format!(r#"{{"model":"{PART}","object":0,"accuracy":"full"}}"#);
    let run = feeler(&["engine"], &format!("{first}\n{good}\n"));
    assert_eq!(run.code, Some(0), "{run:?}");
    assert_eq!(answers(&run)[0]["faces"], 7, "{run:?}");
}

/// What is not looked at is not told, and what is assumed stands in the help.
#[test]
fn what_is_not_looked_at_is_left_out() {
    let ask = ["contact", PART, "--sphere", "-1,-2,-3,0.5"];
    let run = feeler(&[&ask[..], &["--contacts", "none"]].concat(), "");
    assert_eq!(answers(&run)[0].get("continuum"), None, "{run:?}");
    let moving = ["--velocity", "1,1,1", "--contacts", "none"];
    let run = feeler(&[&ask[..], &moving].concat(), "");
    assert!(answers(&run)[0].get("arrival").is_some(), "{run:?}");
    assert_eq!(answers(&run)[0].get("continuum"), None, "{run:?}");
    let run = feeler(&ask, "");
    assert_eq!(answers(&run)[0]["continuum"], false, "{run:?}");
    let run = feeler(&["contact", "--help"], "");
    for word in [
        "moved to its border",
        "is not looked at",
        "also of a line that is refused",
    ] {
        assert!(run.out.contains(word), "no `{word}` in {}", run.out);
    }
}
