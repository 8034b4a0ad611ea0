//! `feeler gate` against a baseline, with JUnit, and with engines outside.

use crate::program::{Run, feeler};
use std::path::{Path, PathBuf};

fn folder(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn gate(out: &Path, more: &[&str]) -> Run {
    let out = out.to_str().unwrap();
    let mut arguments = vec!["gate", "--suite", "evaluate", "--out", out];
    arguments.extend(more);
    feeler(&arguments, "")
}

#[test]
fn a_baseline_decides() {
    let out = folder("gate-baseline");
    let junit = out.join("reports/junit.xml");
    let run = gate(&out, &["--junit", junit.to_str().unwrap()]);
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{run:?}");
    let xml = std::fs::read_to_string(&junit).unwrap();
    assert!(xml.contains("<testsuite name=\"evaluate\"") && xml.contains("failures=\"0\""));

    let report = out.join("report.json");
    let better = out.join("better.json");
    let text = std::fs::read_to_string(&report).unwrap();
    let mut before: serde_json::Value = serde_json::from_str(&text).unwrap();
    let row = &mut before["suites"][0];
    // As if it had been ten times more accurate, and held to more.
    row["error_length"] = (row["error_length"].as_f64().unwrap() / 10.0).into();
    row["ceilings"]["error_ulp"] = 0.75.into();
    std::fs::write(&better, before.to_string()).unwrap();
    let against = |file: &Path| gate(&out, &["--baseline", file.to_str().unwrap()]);

    let run = against(&report);
    assert_eq!(run.code, Some(0), "{run:?}");
    let run = against(&better);
    assert_eq!((run.code, run.err.as_str()), (Some(1), ""), "{run:?}");
    assert!(
        run.out
            .contains("regression: evaluate: worst error in length: "),
        "{run:?}"
    );
    let ceiling =
        "changed: evaluate: the ceiling on error in ulp: 7.5e-1 before, 1e0 now: loosened";
    assert!(run.out.contains(ceiling), "{run:?}");

    let run = against(&out.join("no-such.json"));
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.err.contains("no-such.json"), "{run:?}");
}

/// A line a query, and the same bits on any number of threads.
#[test]
fn the_answers_themselves() {
    let answers = |jobs: &str| {
        let out = folder(&format!("gate-answers-{jobs}"));
        let file = out.join("deeper/answers.txt");
        let (out, path) = (out.to_str().unwrap(), file.to_str().unwrap());
        let suite = "contact-sphere";
        let run = feeler(
            &[
                "gate",
                "--suite",
                suite,
                "--out",
                out,
                "--jobs",
                jobs,
                "--answers",
                path,
            ],
            "",
        );
        assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{run:?}");
        std::fs::read_to_string(file).unwrap()
    };
    let alone = answers("1");
    assert!(alone.lines().count() > 600);
    for line in alone.lines() {
        let (place, answer) = line.split_once('\t').unwrap();
        assert!(place.starts_with("corpora/contact-sphere/"), "{line}");
        assert!(answer.contains(r#""separation":{"value":"#), "{line}");
    }
    for jobs in ["2", "3"] {
        assert!(answers(jobs) == alone, "other answers on {jobs} threads");
    }
}

#[test]
fn engines_that_cannot_be() {
    let out = folder("gate-engines");
    for (arguments, what) in [
        (["--engine", "no-such-program -x"], "no-such-program"),
        (["--engine", "parry:0"], "parry:0"),
        (["--engine", "an 'open quote"], "quotes"),
        (["--tolerance", "1"], "a part of the size"),
        (["--timeout", "0"], "a positive number of seconds"),
    ] {
        let run = gate(&out, &arguments);
        assert_eq!(run.code, Some(2), "{run:?}");
        assert_eq!(run.err.lines().count(), 1, "{run:?}");
        assert!(run.err.contains(what), "{run:?}");
    }
}

/// Through the protocol the kernel earns the same verdicts and the same errors, to the last digit, as within the
/// program: nothing is lost on the way there and back.
#[test]
fn the_kernel_as_an_engine_outside() {
    let engine = format!("{} engine", env!("CARGO_BIN_EXE_feeler"));
    let row = |suite: &str, more: &[&str]| {
        let out = folder(&format!("gate-outside-{}", more.len()));
        let text = out.to_str().unwrap();
        let mut arguments = vec!["gate", "--suite", suite, "--out", text];
        arguments.extend(more);
        let run = feeler(&arguments, "");
        assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{run:?}");
        let report = std::fs::read_to_string(out.join("report.json")).unwrap();
        let mut report: serde_json::Value = serde_json::from_str(&report).unwrap();
        let row = report["suites"][0].as_object_mut().unwrap();
        for times in ["median_microseconds", "p99_microseconds", "seconds"] {
            assert!(row.remove(times).is_some_and(|t| t.as_f64() > Some(0.0)));
        }
        for kind in row["kinds"].as_object_mut().unwrap().values_mut() {
            assert!(kind.as_array_mut().unwrap().pop().unwrap().as_f64() > Some(0.0));
        }
        // Another engine, another command that repeats a query.
        for failure in row["failures"].as_array_mut().unwrap() {
            failure.as_object_mut().unwrap().remove("command");
        }
        row.clone()
    };
    for suite in ["evaluate", "split", "line-grazing", "contact-half-space"] {
        let outside = row(suite, &["--engine", &engine, "--tolerance", "0"]);
        assert_eq!(outside, row(suite, &[]), "{suite}");
        assert!(outside["queries"].as_u64() > Some(100));
    }
}

#[test]
fn an_engine_that_gets_no_model() {
    for (first, what) in [
        ("", "not valid JSON"),
        ("{}", "missing field `model`"),
        (r#"{"model":"no/such.3dm"}"#, "no/such.3dm"),
        (
            r#"{"model":"corpora/models/thesis/ball.3dm","object":9}"#,
            "object 9",
        ),
        (
            r#"{"model":"corpora/models/thesis/ball.3dm","accuracy":-1}"#,
            "accuracy",
        ),
    ] {
        let run = feeler(&["engine"], &format!("{first}\n"));
        assert_eq!(run.code, Some(2), "{run:?}");
        let answer: serde_json::Value = serde_json::from_str(&run.out).unwrap();
        assert!(
            answer["error"].as_str().is_some_and(|e| e.contains(what)),
            "{run:?}"
        );
    }
}
