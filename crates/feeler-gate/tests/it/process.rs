//! Engines outside the process: well-behaved ones and others. They are shell scripts, a few lines each.

use feeler_corpus::{Body, Fault, Model, Query, QueryLine};
use feeler_gate::{Engine, Gate, ModelForm, ProcessEngine, ProcessOptions, Report, run};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const INTRODUCTION: &str = r#"echo '{"engine":"fake","version":"1.2","faces":6}'"#;
/// The query's id, which comes first in its line.
const ID: &str = r#"id=${query#*:}; id=${id%%,*}"#;

fn corpora() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap().join("corpora")
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("models")
}

fn options() -> ProcessOptions {
    ProcessOptions {
        timeout: Duration::from_secs(20),
        start_timeout: Duration::from_secs(20),
        models: ModelForm::Json(folder()),
    }
}

/// An engine of this script.
fn script(text: &str) -> ProcessEngine {
    with(text, options())
}

fn with(text: &str, options: ProcessOptions) -> ProcessEngine {
    let line = format!("sh -c {}", shlex::try_quote(text).unwrap());
    ProcessEngine::new(&line, options).unwrap()
}

/// A box: six faces.
fn model() -> Model {
    Model::load(&corpora().join("models/analytic/block.json.gz"), None).unwrap()
}

fn query() -> Query {
    let line = QueryLine::parse(r#"{"inside":{"point":[0.5,0.5,0.5]},"id":"mine"}"#).unwrap();
    line.query().unwrap()
}

/// The answer's text.
fn ask(engine: &mut ProcessEngine) -> String {
    engine.answer(&query()).to_text()
}

/// Why a query was refused.
fn refusal(engine: &mut ProcessEngine) -> String {
    match engine.answer(&query()).body {
        Body::Error { error } => error,
        other => panic!("answered: {other:?}"),
    }
}

/// The model's path comes in the first line, ids go there and back, and the user's own id is kept.
#[test]
fn a_good_engine() {
    let text = format!(
        r#"read -r model; path=${{model#*\"model\":\"}}; path=${{path%%\"*}}
        test -s "$path" || exit 4
        {INTRODUCTION}
        while read -r query; do {ID}; echo "{{\"id\":$id,\"side\":\"inside\"}}"; done"#
    );
    let mut engine = script(&text);
    engine.open(&model()).unwrap();
    assert_eq!(engine.name(), "fake 1.2");
    for _ in 0..3 {
        assert_eq!(ask(&mut engine), r#"{"id":"mine","side":"inside"}"#);
    }
    // Another model, another process.
    engine.open(&model()).unwrap();
    assert_eq!(ask(&mut engine), r#"{"id":"mine","side":"inside"}"#);
    let repeat = engine.repeats(&query()).unwrap();
    let run = std::process::Command::new("sh")
        .args(["-c", &repeat])
        .output();
    // The user's id is no number: this engine repeats it as it came.
    let out = String::from_utf8(run.unwrap().stdout).unwrap();
    assert!(
        !out.contains("error") && out.contains("inside"),
        "{repeat}: {out}"
    );
}

/// The file that is written holds the same BREPs; a .3dm file is handed over as it is where that was asked.
#[test]
fn what_an_engine_reads() {
    let path = corpora().join("models/thesis/ball.3dm");
    let model = Model::load(&path, None).unwrap();
    let copy = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("first-line");
    let text = format!(
        r#"read -r model; echo "$model" > {}
        echo '{{"engine":"fake","version":"1","faces":{}}}'; read -r end"#,
        copy.display(),
        model.faces()
    );
    let first = |models: ModelForm| {
        let mut engine = with(
            &text,
            ProcessOptions {
                models,
                ..options()
            },
        );
        engine.open(&model).unwrap();
        let line = std::fs::read_to_string(&copy).unwrap();
        let line: serde_json::Value = serde_json::from_str(&line).unwrap();
        assert_eq!(line["accuracy"], "full");
        PathBuf::from(line["model"].as_str().unwrap())
    };
    assert_eq!(first(ModelForm::File), path);
    let written = first(ModelForm::Json(folder()));
    assert_ne!(written, path);
    assert_eq!(Model::load(&written, None).unwrap().hash(), model.hash());
}

#[test]
fn only_the_kinds_it_treats_are_asked() {
    let mut engine = script(
        r#"read -r model; echo '{"engine":"fake","version":"1","faces":6,"treats":["sphere"]}'; read -r end"#,
    );
    engine.open(&model()).unwrap();
    assert!(!engine.treats(&query()));
    let sphere = QueryLine::parse(r#"{"sphere":{"center":[0,0,0],"radius":1}}"#).unwrap();
    assert!(engine.treats(&sphere.query().unwrap()));
    let mut engine = script(
        r#"read -r model; echo '{"engine":"fake","version":"1","faces":6,"treats":["ball"]}'; read -r end"#,
    );
    let error = engine.open(&model()).unwrap_err();
    assert!(error.contains("`ball`"), "{error}");
}

#[test]
fn an_engine_that_does_not_start() {
    let error = ProcessEngine::new("no-such-program --at-all", options()).unwrap_err();
    assert!(error.contains("no-such-program"), "{error}");
    assert!(ProcessEngine::new("an 'open quote", options()).is_err());
    assert!(ProcessEngine::new("", options()).is_err());
    for (text, what) in [
        ("read -r model; echo hello; read -r end", "`hello"),
        ("echo broken >&2; exit 3", "exit status: 3): broken"),
        (
            r#"read -r model; echo '{"error":"a format of the future"}'; read -r end"#,
            "a format of the future",
        ),
        (
            r#"read -r model; echo '{"engine":"fake","version":"1","faces":5}'; read -r end"#,
            "it counts 5 faces, and the model has 6",
        ),
        (
            r#"read -r model; echo '{"engine":"fake"}'; read -r end"#,
            "missing field `version`",
        ),
    ] {
        let error = script(text).open(&model()).unwrap_err();
        assert!(error.contains(what), "{text}: {error}");
    }
    let options = ProcessOptions {
        start_timeout: Duration::from_millis(200),
        ..options()
    };
    let error = with("exec sleep 60", options).open(&model()).unwrap_err();
    assert!(error.contains("no first line within 200ms"), "{error}");
}

/// Each second query ends it: the others are answered by a new process.
#[test]
fn an_engine_that_dies() {
    let text = format!(
        r#"read -r model; {INTRODUCTION}
        read -r query; {ID}; echo "{{\"id\":$id,\"side\":\"inside\"}}"
        read -r query; echo "no more" >&2; exit 3"#
    );
    let mut engine = script(&text);
    engine.open(&model()).unwrap();
    for _ in 0..3 {
        assert_eq!(ask(&mut engine), r#"{"id":"mine","side":"inside"}"#);
        assert_eq!(refusal(&mut engine), "it ended (exit status: 3): no more");
    }
}

/// What cannot be started again is not tried for each query.
#[test]
fn an_engine_that_dies_for_good() {
    let flag = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("started-once");
    let _ = std::fs::remove_file(&flag);
    let text = format!(
        r#"read -r model || exit 0; test -e {0} && exit 5; touch {0}; {INTRODUCTION}; read -r query"#,
        flag.display()
    );
    let mut engine = script(&text);
    engine.open(&model()).unwrap();
    assert_eq!(refusal(&mut engine), "it ended (exit status: 0)");
    for _ in 0..2 {
        let why = refusal(&mut engine);
        assert!(
            why.starts_with("not started again") && why.contains("status: 5"),
            "{why}"
        );
    }
}

#[test]
fn an_engine_that_hangs() {
    let text = format!(
        r#"read -r model; {INTRODUCTION}
        read -r query; {ID}; echo "{{\"id\":$id,\"side\":\"inside\"}}"
        read -r query; exec sleep 60"#
    );
    // Long enough for a good answer on a busy machine.
    let timeout = Duration::from_secs(2);
    let mut engine = with(
        &text,
        ProcessOptions {
            timeout,
            ..options()
        },
    );
    engine.open(&model()).unwrap();
    let start = Instant::now();
    for _ in 0..2 {
        assert_eq!(ask(&mut engine), r#"{"id":"mine","side":"inside"}"#);
        assert_eq!(refusal(&mut engine), "no answer within 2s; killed");
    }
    assert!(start.elapsed() < Duration::from_secs(30));
}

/// A program that does not read, and writes without end, holds up nobody; nor does a line without end.
#[test]
fn an_engine_that_floods() {
    let mut engine = script(&format!("{INTRODUCTION}; yes"));
    engine.open(&model()).unwrap();
    for _ in 0..2000 {
        let why = refusal(&mut engine);
        assert!(why.contains("`y`"), "{why}");
    }
    let mut engine = script(&format!(
        "{INTRODUCTION}; read -r model; exec cat /dev/zero"
    ));
    engine.open(&model()).unwrap();
    let why = refusal(&mut engine);
    // Which of both it is depends on who is faster.
    assert!(
        why.starts_with("it ended") || why.starts_with("it closed"),
        "{why}"
    );
}

/// A line that is no answer is charged to one query, and the answer that follows it to none.
#[test]
fn an_engine_that_prints_garbage() {
    let text = format!(
        r#"read -r model; {INTRODUCTION}; n=0
        while read -r query; do {ID}; n=$((n+1))
        test $n = 2 && echo "warning: hot"
        echo "{{\"id\":$id,\"side\":\"inside\"}}"; done"#
    );
    let mut engine = script(&text);
    engine.open(&model()).unwrap();
    assert_eq!(ask(&mut engine), r#"{"id":"mine","side":"inside"}"#);
    let why = refusal(&mut engine);
    assert!(why.contains("`warning: hot`"), "{why}");
    for _ in 0..3 {
        assert_eq!(ask(&mut engine), r#"{"id":"mine","side":"inside"}"#);
    }
}

#[test]
fn an_engine_that_says_too_little() {
    for (answer, what) in [
        (r#"{\"id\":$id}"#, "missing field `side`"),
        (r#"{\"id\":$id,\"side\":\"perhaps\"}"#, "perhaps"),
        (r#"{\"side\":\"inside\"}"#, "id"),
        (r#"{\"id\":99,\"side\":\"inside\"}"#, "id"),
        (r#"{\"error\":\"not today\"}"#, "not today"),
    ] {
        let text = format!(
            r#"read -r model; {INTRODUCTION}; while read -r query; do {ID}; echo "{answer}"; done"#
        );
        let mut engine = script(&text);
        engine.open(&model()).unwrap();
        let why = refusal(&mut engine);
        assert!(why.contains(what), "{answer}: {why}");
    }
}

fn gate(engine: &mut ProcessEngine, suite: &str) -> Report {
    let corpora = corpora();
    let gate = Gate {
        corpus: &corpora,
        suite: Some(suite),
        tolerance: 1e-9,
        sample: None,
        answers: false,
    };
    run(&mut [engine], &gate, &mut |_| ()).unwrap()
}

/// Through the gate: whatever it does, each query gets its verdict.
#[test]
fn the_gate_goes_on() {
    let mut all_in = script(
        r#"read -r model; path=${model#*\"model\":\"}; path=${path%%\"*}
        faces=$(grep -o '"surface":' "$path" | wc -l)
        echo "{\"engine\":\"all-in\",\"version\":\"1\",\"faces\":$((faces)),\"treats\":[\"inside\"]}"
        n=0; while read -r query; do id=${query#*:}; id=${id%%,*}; n=$((n+1))
        test $n = 10 && exit 3
        echo "{\"id\":$id,\"side\":\"inside\"}"; done"#,
    );
    let report = gate(&mut all_in, "inside");
    assert_eq!(report.engine, "all-in 1");
    let row = &report.suites[0];
    let refused = row.faults[&Fault::Refused];
    assert!(
        refused * 20 > row.queries && refused * 9 < row.queries,
        "{refused} refused"
    );
    assert_eq!(row.wrong, refused + row.faults[&Fault::Side]);
    assert!(row.wrong < row.queries && row.indeterminate == 0);
    assert!(
        row.failures[0].command.contains("printf"),
        "{:?}",
        row.failures[0]
    );
    // Nothing that it treats.
    let row = &gate(&mut all_in, "split").suites[0];
    assert_eq!((row.queries, row.wrong), (0, 0));
    assert!(row.not_asked > 0);
}
