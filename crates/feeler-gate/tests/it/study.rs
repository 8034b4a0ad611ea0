//! How the report looks, on one made up here: the layout alone is fixed.

use feeler_corpus::Fault;
use feeler_gate::study::{
    About, BALLS, BallCell, BallRow, Extreme, LeftOut, Plan, Point, Spread, Study, SuiteStudy,
};
use std::collections::BTreeMap;

fn spread(x: f64) -> Spread {
    Spread {
        count: 40,
        median: x,
        p99: 2.0 * x,
        p999: 3.0 * x,
        max: 4.0 * x,
    }
}

fn point(engine: &str, setting: &str, microseconds: f64, error: f64) -> Point {
    Point {
        engine: engine.to_owned(),
        setting: setting.to_owned(),
        queries: 40,
        not_asked: 0,
        not_reached: 0,
        right: 40,
        undecided: 0,
        indeterminate: 0,
        faults: BTreeMap::new(),
        error: Some(spread(error)),
        ulps: Some(spread(error * 1e16)),
        width: None,
        microseconds: spread(microseconds),
        between: [0.9 * microseconds, 1.1 * microseconds],
        open_microseconds: 12.0,
        bytes: None,
        witnesses: Vec::new(),
    }
}

fn made_up() -> Study {
    let mut off = point("another", "fast <& loose>", 0.5, 1e-3);
    off.right = 37;
    off.faults = BTreeMap::from([(Fault::MissedContact, 1), (Fault::Value, 2)]);
    let cell = |radius: f64| BallCell {
        radius,
        microseconds: spread(2.0),
        error: spread(0.0),
        missed: 0,
    };
    Study {
        about: About {
            processor: "a processor".to_owned(),
            threads: 2,
            system: "a system".to_owned(),
            version: "1.2.3".to_owned(),
            compiler: "a compiler".to_owned(),
            commit: "0123456789ab".to_owned(),
        },
        plan: Plan {
            sample: 40,
            repetitions: 3,
            seconds: 0.3,
        },
        suites: vec![SuiteStudy {
            suite: "spheres".to_owned(),
            description: "what spheres are about".to_owned(),
            queries: 1200,
            floor: Some(1e-40),
            points: vec![point("feeler", "full", 100.0, 1e-16), off],
        }],
        balls: vec![BallRow {
            engine: "feeler full".to_owned(),
            model: "thesis/hole.3dm".to_owned(),
            file_bytes: Some(20_000),
            bytes: None,
            open_milliseconds: 0.1,
            balls: BALLS.map(|(radius, _)| cell(radius)).to_vec(),
            error: None,
        }],
        left_out: vec![LeftOut {
            what: "less, against more".to_owned(),
            suite: "spheres".to_owned(),
            queries: 40,
            less: 10.0,
            full: 20.0,
            ratio: 2.0,
            undecided: [0, 3],
        }],
        extremes: vec![Extreme {
            id: "C2".to_owned(),
            about: "off the centre".to_owned(),
            elsewhere: None,
            queries: 18,
            right: 17,
            undecided: 1,
            wrong: 0,
            ulps: Some(0.5),
            conditioning: Some(f64::INFINITY),
            microseconds: Some(4.0),
            easy_microseconds: Some(2.0),
            reasons: vec!["e=1e-15 R: why".to_owned()],
            not_reached: 0,
        }],
        omissions: vec!["what is not in it".to_owned()],
    }
}

#[test]
fn summary() {
    insta::assert_snapshot!(made_up().summary());
}

#[test]
fn the_page_needs_nothing_else_and_escapes_what_it_shows() {
    let page = made_up().page();
    // Names of markup languages are no links.
    let page = page.replace("http://www.w3.org/2000/svg", "");
    for outside in [
        "http:", "https:", "src=", "<script", "<link", "@import", "url(",
    ] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.contains("fast &lt;&amp; loose&gt;"));
    assert!(!page.contains("<& loose>"));
    // One plot in model units, one in ulp, a dot and a ring for each of the two engines.
    assert_eq!(page.matches("<svg").count(), 2);
    assert_eq!(page.matches("<circle").count(), 8);
    assert!(
        page.contains("(1 wrong)"),
        "a missed contact beside its dot"
    );
}
