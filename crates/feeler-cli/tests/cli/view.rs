//! `feeler view`.

use crate::program::feeler;

const PART: &str = "corpora/models/thesis/ball_joint_cavity.3dm";

/// A place for a file of this test.
fn out(name: &str) -> String {
    let name = format!("feeler-view-{}-{name}", std::process::id());
    std::env::temp_dir()
        .join(name)
        .to_string_lossy()
        .into_owned()
}

#[test]
fn a_page_and_a_binary_gltf_are_written() {
    let queries = r#"{"sphere":{"center":[0.01,0.02,0.03],"radius":2.51}}

{"inside":{"point":[0,0,0]}}
"#;
    for (name, start) in [
        ("socket.html", &b"<!DOCTYPE html>"[..]),
        ("socket.glb", b"glTF"),
    ] {
        let path = out(name);
        let run = feeler(&["view", PART, "--queries", "-", "-o", &path], queries);
        assert_eq!(run.code, Some(0), "{run:?}");
        assert!(
            run.out.contains("7 faces, ") && run.out.contains(" 2 queries"),
            "{run:?}"
        );
        let bytes = std::fs::read(&path).expect("the file");
        assert!(bytes.starts_with(start));
        std::fs::remove_file(path).expect("the file");
    }
}

#[test]
fn probes_of_the_command_line_are_shown() {
    let path = out("probe.html");
    let run = feeler(
        &[
            "view",
            PART,
            "--sphere",
            "0,0,0,1",
            "--line",
            "-9,0.5,0.25,1,0,0",
            "-o",
            &path,
        ],
        "",
    );
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(run.out.contains(" 2 queries"), "{run:?}");
    let run = feeler(&["view", PART, "--sphere", "0,0,0,-1", "-o", &path], "");
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.err.contains("the radius is negative"), "{run:?}");
    std::fs::remove_file(path).expect("the file of before");
}

#[test]
fn a_query_that_is_refused_is_said_and_the_others_are_shown() {
    let path = out("refused.html");
    let queries = "{\"inside\":{\"point\":[0,0,0]}}\n{\"inside\":[]}\n";
    let run = feeler(&["view", PART, "--queries", "-", "-o", &path], queries);
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(
        run.err.starts_with("error: query 2: not a query"),
        "{run:?}"
    );
    assert!(run.out.contains(" 2 queries"), "{run:?}");
    std::fs::remove_file(path).expect("the page is there all the same");
}

#[test]
fn what_cannot_be_shown_is_said_in_one_line() {
    for (arguments, says) in [
        (
            &["view", PART, "-o", "part.stl"][..],
            "end it with .html or .glb",
        ),
        (&["view", "no such.3dm", "-o", "x.html"], "no such.3dm"),
        (&["view", "README.md", "-o", "x.html"], "README.md"),
        (&["view", PART, "--chord", "0", "-o", "x.html"], "above 0"),
        (
            &["view", PART, "--triangles", "2", "-o", "x.html"],
            "more than 2 triangles",
        ),
        (
            &["view", PART, "--queries", "no such.jsonl", "-o", "x.html"],
            "no such.jsonl",
        ),
        (
            &["view", PART, "-o", "no such folder/x.html"],
            "cannot be written",
        ),
        (
            &["view", "--suite", "no such", "-o", "x.html"],
            "no suite `no such`",
        ),
        (
            &["view", "--suite", "thesis", "-o", "x.glb"],
            "write a page",
        ),
        (&["view", "-o", "x.html"], "required"),
    ] {
        let run = feeler(arguments, "");
        assert_eq!(run.code, Some(2), "{run:?}");
        assert_eq!(run.err.lines().count(), 1, "{run:?}");
        assert!(run.err.contains(says), "{run:?}");
        assert!(run.out.is_empty(), "{run:?}");
    }
}
