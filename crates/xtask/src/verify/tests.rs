//! The verification finds mistakes put into truths, and what the second method once got wrong.

use super::*;
use feeler_corpus::ContactTruth;

/// The first queries of a suite with their truth, on one model.
fn stored(suite: &str, count: usize) -> (Model, Vec<(CorpusQuery, Truth)>) {
    let corpora = xtask_test::root().join("corpora");
    let suite = suites(&corpora, Some(suite)).unwrap().remove(0);
    let (queries, hash) = suite.files[0].queries().unwrap();
    let (_, truths) = suite.files[0].truth(queries.len(), &hash).unwrap();
    let name = queries[0].model.clone();
    let model = Model::load(&corpora.join(MODELS).join(&name), None).unwrap();
    let same = queries.into_iter().zip(truths);
    let same = same.filter(|(q, _)| q.model == name).take(count).collect();
    (model, same)
}

fn moved(e: &TruthEnclosure, by: f64) -> TruthEnclosure {
    let by = Dyadic::from_f64(by).unwrap();
    TruthEnclosure {
        lo: &e.lo + &by,
        hi: &e.hi + &by,
    }
}

/// Truths that are wrong by little, or in kind.
fn mistakes(truth: &Truth) -> Vec<Truth> {
    let mut all = Vec::new();
    match truth {
        // Far below an ulp.
        Truth::Separation(e)
        | Truth::Contact {
            separation: e,
            contacts: None,
            ..
        } => {
            all.extend([1e-25, -1e-25].map(|by| Truth::Separation(moved(e, by))));
            if e.lo.approximate().abs() > 1e-6 {
                let lo = -&e.hi;
                all.push(Truth::Separation(TruthEnclosure { lo, hi: -&e.lo }));
            }
        }
        Truth::Side { side, in_gap } => {
            let side = match side {
                Side::Inside => Side::Outside,
                _ => Side::Inside,
            };
            let in_gap = *in_gap;
            all.push(Truth::Side { side, in_gap });
        }
        Truth::Line { hits, .. } if !hits.is_empty() => {
            let with = |hits: Vec<HitTruth>| Truth::Line {
                hits,
                crossings: None,
                in_crack: None,
            };
            all.push(with(hits[1..].to_vec()));
            let mut other = hits.clone();
            other[0].t = moved(&other[0].t, 1e-25);
            all.push(with(other));
            let mut other = hits.clone();
            other[0].face += 1;
            all.push(with(other));
        }
        Truth::Contact {
            separation,
            contacts: Some(list),
            ..
        } => {
            let mut with = |list: Vec<ContactTruth>| {
                all.push(Truth::Contact {
                    separation: separation.clone(),
                    foot: None,
                    contacts: Some(list),
                });
            };
            let Some(last) = list.iter().rfind(|c| c.due) else {
                return all;
            };
            // One missed, one too many, one elsewhere, one of another depth.
            with(list.iter().filter(|c| *c != last).cloned().collect());
            let mut another = last.clone();
            another.at[0] = another.at[0].map(|x| x + 1e-3);
            with(list.iter().chain([&another]).cloned().collect());
            let others = list.iter().filter(|c| *c != last);
            with(others.clone().chain([&another]).cloned().collect());
            let mut deeper = last.clone();
            deeper.separation = moved(&last.separation, -1e-6);
            with(others.chain([&deeper]).cloned().collect());
        }
        Truth::Evaluate { point, du, dv } => {
            let mut wrong = point.clone();
            wrong[1] = moved(&wrong[1], 1e-25);
            all.push(Truth::Evaluate {
                point: wrong,
                du: du.clone(),
                dv: dv.clone(),
            });
            let mut wrong = dv.clone();
            wrong[2] = moved(&wrong[2], 1e-25);
            all.push(Truth::Evaluate {
                point: point.clone(),
                du: du.clone(),
                dv: wrong,
            });
        }
        _ => {}
    }
    all
}

#[test]
fn a_planted_mistake_is_caught() {
    for (suite, least) in [
        ("contact-half-space", 8),
        ("contact-sphere", 8),
        ("line", 4),
    ] {
        let (model, all) = stored(suite, 5);
        let mut checker = Checker::new(&model);
        let mut caught = 0;
        for (query, truth) in &all {
            let line = query.line.to_text();
            let found = checker.held(&query.query, truth);
            assert!(!matches!(found, Outcome::Disagrees(_)), "{line}: {found:?}");
            if !matches!(found, Outcome::Agrees(width) if width < 1e-28) {
                continue;
            }
            for wrong in mistakes(truth) {
                let found = checker.held(&query.query, &wrong);
                assert!(matches!(found, Outcome::Disagrees(_)), "{line}: {wrong:?}");
                caught += 1;
            }
        }
        assert!(caught >= least, "{suite}: {caught}");
    }
    let mut caught = 0;
    for suite in ["inside", "side", "evaluate"] {
        let (model, all) = stored(suite, 4);
        let mut checker = Checker::new(&model);
        for (query, truth) in &all {
            let found = checker.held(&query.query, truth);
            // The second method may know nothing of a point next to an edge.
            assert!(
                !matches!(found, Outcome::Disagrees(_)),
                "{suite}: {found:?}"
            );
            if !matches!(found, Outcome::Agrees(_)) {
                continue;
            }
            for wrong in mistakes(truth) {
                let found = checker.held(&query.query, &wrong);
                assert!(matches!(found, Outcome::Disagrees(_)), "{suite}: {wrong:?}");
                caught += 1;
            }
        }
    }
    assert!(caught >= 12, "{caught}");
}

#[test]
fn a_mistake_in_a_list_of_contacts_is_caught() {
    let (model, all) = stored("contacts", 6);
    let mut checker = Checker::new(&model);
    let mut caught = 0;
    for (query, truth) in &all {
        let line = query.line.to_text();
        let found = checker.held(&query.query, truth);
        assert!(!matches!(found, Outcome::Disagrees(_)), "{line}: {found:?}");
        if !matches!(found, Outcome::Agrees(_)) {
            continue;
        }
        for wrong in mistakes(truth) {
            let found = checker.held(&query.query, &wrong);
            assert!(matches!(found, Outcome::Disagrees(_)), "{line}: {wrong:?}");
            caught += 1;
        }
    }
    assert!(caught >= 12, "{caught}");
}

/// Balls whose feet are on borders of domains that trims cross back and forth by 1e-15. The second method was wrong on
/// the first (it went on along an arc beyond its end), and knew nothing of the other.
#[test]
fn ragged_borders() {
    for (query, truth) in [
        (
            r#"{"model":"thesis/ball_joint_socket_nurbs.3dm","sphere":{"center":[1.9210602367971947,7.418260422019432e-17,1.4407951775978984],"radius":0.0986747040036051}}"#,
            r#"{"separation":{"lo":"-70af3333333332161a013bf0f967e80958640bp-194","hi":"-e15e66666666642c340277e1f2cfd012b0c815p-195"}}"#,
        ),
        (
            r#"{"model":"thesis/cylinder_nurbs.3dm","sphere":{"center":[-2.0467062747732347,1.435616042785768,10.063331186170599],"radius":1.43410206977483}}"#,
            r#"{"separation":{"lo":"-af756b99b1d12800000000000000000000000000000000001p-195","hi":"-af756b99b1d127fffffffffffffffffffffffffffffffffffp-195"}}"#,
        ),
    ] {
        let line = feeler_corpus::QueryLine::parse(query).unwrap();
        let corpora = xtask_test::root().join("corpora");
        let path = corpora.join(MODELS).join(line.model.as_deref().unwrap());
        let model = Model::load(&path, None).unwrap();
        let truth: Truth = serde_json::from_str(truth).unwrap();
        let found = Checker::new(&model).held(&line.query().unwrap(), &truth);
        assert!(
            matches!(found, Outcome::Agrees(width) if width < 1e-50),
            "{query}: {found:?}"
        );
    }
}

#[test]
fn a_witness_is_kept_once() {
    let folder = std::env::temp_dir().join(format!("feeler-verify-{}", std::process::id()));
    for _ in 0..2 {
        keep(&folder, r#"{"model":"m.3dm","inside":{"point":[0,0,0]}}"#).unwrap();
    }
    let suite = suites(&folder, Some(REGRESSIONS)).unwrap().remove(0);
    assert_eq!(suite.files[0].queries().unwrap().0.len(), 1);
    fs::remove_dir_all(&folder).unwrap();
}

/// All critical points of a saddle: they hold the true distance, and none that is moved by little.
#[cfg(feature = "cgal")]
#[test]
fn critical_points_find_a_wrong_distance() {
    let path = xtask_test::root()
        .join("corpora")
        .join(MODELS)
        .join("stress/saddle.json.gz");
    let model = Model::load(&path, None).unwrap();
    let breps: Vec<_> = model.breps.iter().collect();
    let oracle = feeler_oracle::Oracle::new(&breps).unwrap();
    let point = [0.3, 0.4, 0.7];
    let truth = oracle.distance(point, None).unwrap().unwrap().enclosure;
    let truth = TruthEnclosure {
        lo: truth.lo,
        hi: truth.hi,
    };
    let held =
        |e: &TruthEnclosure| crate::verify_critical::held(&model, point, e, Outcome::Agrees(0.5));
    assert_eq!(held(&truth), Outcome::Agrees(0.5));
    for by in [1e-25, -1e-25] {
        let other = moved(&truth, by);
        let wrong = held(&other);
        assert!(matches!(wrong, Outcome::Disagrees(_)), "{wrong:?}");
    }
}
