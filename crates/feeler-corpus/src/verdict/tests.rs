use super::*;
use crate::truth::ContactTruth;
use feeler::query::Feature;
use feeler::trim::Side;

fn truth(lo: &str, hi: &str) -> TruthEnclosure {
    TruthEnclosure {
        lo: lo.parse().unwrap(),
        hi: hi.parse().unwrap(),
    }
}

const ASKED: Asked = Asked {
    accuracy: Accuracy::Full,
    size: 10.0,
    prediction: 0.0,
    contacts: false,
    hits: Hits::All,
    scale: 1.0,
    tolerance: 0.0,
    probe: None,
};

fn separation(value: f64, lo: f64, hi: f64) -> Body {
    Body::Contact {
        separation: Claim {
            value,
            lo: Some(lo),
            hi: Some(hi),
        },
        continuum: None,
        contacts: vec![],
        undecided: None,
    }
}

/// 1/3 between its neighbouring f64s is not a f64: 0x5555..p-k.
fn third() -> TruthEnclosure {
    truth(
        "5555555555555555555555555555555555555555p-160",
        "5555555555555555555555555555555555555556p-160",
    )
}

#[test]
fn separations() {
    let t = Truth::Separation(third());
    let x = 1.0 / 3.0;
    let verdict = |a: &Body| judge(&ASKED, a, &t);
    let right = verdict(&separation(x, x, x.next_up()));
    assert_eq!(right.verdict, Verdict::Right);
    // 1/3 is rounded down by a third of an ulp.
    assert!((right.ulps.unwrap() - 1.0 / 3.0).abs() < 1e-6);
    assert_eq!(verdict(&separation(x, x, x)).verdict, Verdict::Wrong);
    let off = x + 1e-9;
    let wrong = verdict(&separation(off, off, off.next_up()));
    assert_eq!(wrong.verdict, Verdict::Wrong);
    assert!(wrong.reason.unwrap().contains("e-9") || wrong.error.unwrap() > 9e-10);
    // Too wide for full accuracy, but not wrong.
    let wide = verdict(&separation(x, x - 1e-12, x + 1e-12));
    assert_eq!(wide.verdict, Verdict::Undecided);
    assert!(!wide.unbounded);
    let unbounded = verdict(&separation(x, 0.0, f64::INFINITY));
    assert_eq!(unbounded.verdict, Verdict::Undecided);
    assert!(unbounded.unbounded);
    // The value to use must be in its own bounds, and a number.
    assert_eq!(verdict(&separation(1.0, 0.0, 0.5)).verdict, Verdict::Wrong);
    let nan = verdict(&separation(f64::NAN, 0.0, 0.5));
    assert_eq!(nan.verdict, Verdict::Wrong);
    let nan = verdict(&separation(x, f64::NAN, 0.5));
    assert_eq!(nan.verdict, Verdict::Wrong);
    // A truth that is too wide to judge.
    let t = Truth::Separation(truth("0p0", "1p0"));
    let j = judge(&ASKED, &separation(x, x, x.next_up()), &t);
    assert_eq!(j.verdict, Verdict::Indeterminate);
}

#[test]
fn an_undecided_answer_can_still_be_wrong() {
    let mut a = separation(0.25, 0.2, 0.3);
    if let Body::Contact { undecided, .. } = &mut a {
        *undecided = Some("node budget spent".into());
    }
    let t = Truth::Separation(third());
    assert_eq!(judge(&ASKED, &a, &t).verdict, Verdict::Wrong);
}

#[test]
fn a_contact_that_is_due_must_be_reported() {
    let asked = Asked {
        contacts: true,
        ..ASKED
    };
    let t = Truth::Separation(truth("-1p-1", "-1p-1"));
    let j = judge(&asked, &separation(-0.5, -0.5, -0.5), &t);
    assert_eq!(j.verdict, Verdict::Wrong);
    let apart = Truth::Separation(truth("1p-1", "1p-1"));
    let j = judge(&asked, &separation(0.5, 0.5, 0.5), &apart);
    assert_eq!(j.verdict, Verdict::Right);
    assert_eq!(j.error, Some(0.0));
}

#[test]
fn a_value_without_bounds_is_held_to_the_tolerance() {
    let bare = |value: f64, reported: bool| {
        let mut body = with_contacts(vec![contact(1.0, value, None)], None);
        if let Body::Contact {
            separation,
            contacts,
            ..
        } = &mut body
        {
            *separation = Claim {
                value,
                lo: None,
                hi: None,
            };
            match reported {
                true => contacts[0].separation = *separation,
                false => contacts.clear(),
            }
        }
        body
    };
    let asked = Asked {
        contacts: true,
        tolerance: 0.125,
        ..ASKED
    };
    let overlapping = Truth::Separation(truth("-1p-1", "-1p-1"));
    let off = |value, contact| judge(&asked, &bare(value, contact), &overlapping);
    assert_eq!(off(-0.4, true).verdict, Verdict::Right);
    assert_eq!(off(-0.4, true).error, Some(0.09999999999999998));
    assert_eq!(off(-0.25, true).fault, Some(Fault::Value));
    assert_eq!(off(-0.4, false).fault, Some(Fault::MissedContact));
    assert_eq!(off(0.5, false).fault, Some(Fault::MissedContact));
    // Within the tolerance of touching it may go either way.
    let touching = Truth::Separation(truth("-1p-4", "-1p-4"));
    let verdict = |value, contact| judge(&asked, &bare(value, contact), &touching).verdict;
    assert_eq!(verdict(0.0, false), Verdict::Right);
    assert_eq!(verdict(-0.0625, true), Verdict::Right);
    let apart = Truth::Separation(truth("1p-1", "1p-1"));
    let j = judge(&asked, &bare(-0.5, true), &apart);
    assert_eq!(j.fault, Some(Fault::FalseContact));
}

#[test]
fn a_contact_beyond_the_prediction_is_false() {
    let asked = Asked {
        contacts: true,
        ..ASKED
    };
    let apart = Truth::Separation(truth("1p-1", "1p-1"));
    let mut body = with_contacts(vec![contact(1.0, 0.5, None)], None);
    if let Body::Contact { separation, .. } = &mut body {
        *separation = Claim {
            value: 0.5,
            lo: Some(0.5),
            hi: Some(0.5),
        };
    }
    let j = judge(&asked, &body, &apart);
    assert_eq!(j.fault, Some(Fault::FalseContact));
    // Where the enclosure leaves it open, it may be reported.
    if let Body::Contact { separation, .. } = &mut body {
        separation.lo = Some(0.0);
    }
    assert_eq!(judge(&asked, &body, &apart).fault, None);
}

fn line(ts: &[(f64, bool)]) -> Body {
    Body::Line {
        hits: ts
            .iter()
            .map(|&(t, tangential)| HitLine {
                t: Claim {
                    value: t,
                    lo: Some(t.next_down()),
                    hi: Some(t.next_up()),
                },
                t_end: None,
                point: [0.0; 3],
                normal: [0.0, 0.0, 1.0],
                feature: Some(Feature::Face(0)),
                uv: Some([0.0; 2]),
                tangential: Some(tangential),
            })
            .collect(),
        crossings: Some(2),
        in_crack: Some(false),
        undecided: None,
    }
}

fn hit(t: &TruthEnclosure, face: usize) -> HitTruth {
    HitTruth {
        t: t.clone(),
        t_end: None,
        face,
        tangential: Some(false),
    }
}

#[test]
fn lines() {
    let one = truth("1p0", "1p0");
    let t = Truth::Line {
        hits: vec![hit(&third(), 0), hit(&one, 1), hit(&one, 2)],
        crossings: Some(2),
        in_crack: Some(false),
    };
    let x = 1.0 / 3.0;
    let verdict = |a: &Body| judge(&ASKED, a, &t).verdict;
    // The edge at t = 1 may count once or for each of its faces.
    let two = [(x, false), (1.0, false)];
    let three = [(x, false), (1.0, false), (1.0, false)];
    assert_eq!(verdict(&line(&two)), Verdict::Right);
    assert_eq!(verdict(&line(&three)), Verdict::Right);
    assert_eq!(verdict(&line(&[(x, false)])), Verdict::Wrong);
    assert_eq!(verdict(&line(&[(x, true), (1.0, false)])), Verdict::Wrong);
    assert_eq!(
        verdict(&line(&[(x + 1e-9, false), (1.0, false)])),
        Verdict::Wrong
    );
    let mut extra = two.to_vec();
    extra.extend([(2.0, false), (3.0, false)]);
    assert_eq!(verdict(&line(&extra)), Verdict::Wrong);
}

#[test]
fn sides_and_points() {
    let side = |side, undecided: Option<&str>| Body::Side {
        side,
        in_gap: Some(false),
        undecided: undecided.map(str::to_owned),
    };
    let t = Truth::Side {
        side: Side::Inside,
        in_gap: Some(false),
    };
    let verdict = |b: &Body| judge(&ASKED, b, &t).verdict;
    assert_eq!(verdict(&side(Some(Side::Inside), None)), Verdict::Right);
    assert_eq!(verdict(&side(Some(Side::Boundary), None)), Verdict::Wrong);
    assert_eq!(verdict(&side(None, Some("crack"))), Verdict::Undecided);
    assert_eq!(verdict(&side(None, None)), Verdict::Wrong);

    let zero = truth("0p0", "0p0");
    let t = Truth::Evaluate {
        point: [third(), zero.clone(), zero.clone()],
        du: [third(), zero.clone(), zero.clone()],
        dv: [zero.clone(), zero.clone(), zero],
    };
    let evaluate = |x: f64, bound: f64| Body::Evaluate {
        point: [x, 0.0, 0.0],
        du: [x, 0.0, 0.0],
        dv: [0.0; 3],
        bound: Some(bound),
    };
    let x = 1.0 / 3.0;
    let j = judge(&ASKED, &evaluate(x, 1e-16), &t);
    assert_eq!(j.verdict, Verdict::Right);
    assert!(j.derivative_error.unwrap() < 1e-16);
    let j = judge(&ASKED, &evaluate(x, 1e-18), &t);
    assert_eq!(j.verdict, Verdict::Wrong);
    let j = judge(&ASKED, &evaluate(x, f64::NAN), &t);
    assert_eq!(j.verdict, Verdict::Wrong);
    assert!(judge(&ASKED, &evaluate(x, f64::INFINITY), &t).unbounded);
}

fn contact(x: f64, separation: f64, position_bound: Option<f64>) -> ContactLine {
    ContactLine {
        on_brep: [x, 0.0, 0.0],
        on_probe: [x, 0.0, 1.0],
        normal: [0.0, 0.0, 1.0],
        separation: Claim {
            value: separation,
            lo: Some(separation),
            hi: Some(separation),
        },
        feature: Some(Feature::Face(0)),
        uv: Some([0.0; 2]),
        position_bound,
        normal_bound: None,
        normal_is_choice: false,
    }
}

fn with_contacts(contacts: Vec<ContactLine>, undecided: Option<&str>) -> Body {
    let separation = contacts[0].separation;
    Body::Contact {
        separation,
        continuum: Some(false),
        contacts,
        undecided: undecided.map(str::to_owned),
    }
}

#[test]
fn all_contacts() {
    let one = truth("-1p-1", "-1p-1");
    let at = |x: f64, separation: &str, due| ContactTruth {
        separation: truth(separation, separation),
        at: [[x, x.next_up()], [0.0; 2], [0.0; 2]],
        due,
        continuum: false,
    };
    let mut t = Truth::Contact {
        separation: one,
        foot: None,
        contacts: Some(vec![
            at(1.0, "-1p-1", true),
            at(2.0, "-1p-2", true),
            at(3.0, "1p-3", false),
        ]),
    };
    let asked = Asked {
        contacts: true,
        ..ASKED
    };
    let (a, b) = (contact(1.0, -0.5, Some(1e-12)), contact(2.0, -0.25, None));
    let judged = |t: &Truth, c: &[&ContactLine]| {
        let all = c.iter().map(|c| (*c).clone()).collect();
        judge(&asked, &with_contacts(all, None), t)
    };
    assert_eq!(judged(&t, &[&a, &b]).verdict, Verdict::Right);
    // One that may be, and one that is not.
    let maybe = contact(3.0, 0.2, None);
    assert_eq!(judged(&t, &[&a, &b, &maybe]).verdict, Verdict::Right);
    let wrong = |c: &[&ContactLine], why: &str| {
        let j = judged(&t, c);
        assert_eq!(j.verdict, Verdict::Wrong);
        assert!(j.reason.unwrap().contains(why), "{why}");
    };
    wrong(&[&a, &b, &contact(4.0, 0.0, None)], "false contact");
    wrong(&[&a], "missed contact");
    wrong(&[&a, &b, &b], "2 contacts for one");
    wrong(&[&a, &contact(2.0, -0.24, None)], "a contact");
    wrong(
        &[&a, &contact(2.0 + 1e-8, -0.25, Some(1e-9))],
        "foot is off",
    );
    wrong(
        &[&a, &contact(2.0 + 1e-8, -0.25, Some(f64::NAN))],
        "foot is off",
    );
    assert_eq!(
        judged(&t, &[&a, &contact(2.0 + 1e-8, -0.25, Some(1e-7))]).verdict,
        Verdict::Right
    );
    // An answer that is not whole is not wrong for what it lacks.
    let j = judge(&asked, &with_contacts(vec![a.clone()], Some("budget")), &t);
    assert_eq!(j.verdict, Verdict::Undecided);
    // Nor for one that is within reach on the one side of the surface and not on the other, as long as it says that it does not know the side.
    let reaching = |lo: f64, hi: f64, undecided: Option<&str>| {
        let mut c = contact(4.0, 0.0, None);
        (c.separation.lo, c.separation.hi) = (Some(lo), Some(hi));
        let all = with_contacts(vec![a.clone(), b.clone(), c], undecided);
        judge(&asked, &all, &t).verdict
    };
    let side = Some("the side is not known");
    assert_eq!(reaching(-2.0, 0.5, side), Verdict::Undecided);
    assert_eq!(reaching(-2.0, 0.5, None), Verdict::Wrong);
    assert_eq!(reaching(-2.0, -1.0, side), Verdict::Wrong);
    // Of a continuum there may be several, and nothing is said of feet.
    if let Truth::Contact {
        contacts: Some(all),
        ..
    } = &mut t
    {
        all[1].at[0] = [2.0, 2.5];
        all[1].continuum = true;
    }
    let c = contact(2.4, -0.25, Some(1e-9));
    assert_eq!(judged(&t, &[&a, &b, &c]).verdict, Verdict::Right);
    assert_eq!(judged(&t, &[&a]).verdict, Verdict::Wrong);
}

#[test]
fn the_deepest_foot() {
    let t = Truth::Contact {
        separation: truth("-1p-1", "-1p-1"),
        foot: Some([[1.0, 1.0], [0.0; 2], [0.0; 2]]),
        contacts: None,
    };
    let verdict = |c: ContactLine| judge(&ASKED, &with_contacts(vec![c], None), &t).verdict;
    assert_eq!(verdict(contact(1.0, -0.5, Some(0.0))), Verdict::Right);
    assert_eq!(
        verdict(contact(1.0 + 1e-9, -0.5, Some(1e-8))),
        Verdict::Right
    );
    assert_eq!(
        verdict(contact(1.0 + 1e-8, -0.5, Some(1e-9))),
        Verdict::Wrong
    );
    assert_eq!(verdict(contact(7.0, -0.5, None)), Verdict::Right);
}

#[test]
fn splits_are_judged_place_by_place() {
    use crate::answer::SplitRootLine;
    use crate::truth::SplitRootTruth;
    let third = TruthEnclosure {
        lo: "5555p-16".parse().unwrap(),
        hi: "5556p-16".parse().unwrap(),
    };
    let root = |multiplicity: usize, turns: bool| AxisSplitTruth {
        roots: vec![SplitRootTruth {
            t: third.clone(),
            multiplicity: [multiplicity; 2],
            turns,
        }],
        constant: Vec::new(),
    };
    let level = AxisSplitTruth {
        roots: Vec::new(),
        constant: vec![[truth("0p0", "0p0"), truth("1p0", "1p0")]],
    };
    let split = Truth::Split {
        u: root(1, true),
        v: level,
    };
    let claim = |lo: f64, hi: f64| Claim {
        value: lo,
        lo: Some(lo),
        hi: Some(hi),
    };
    let one = |t: Claim, multiplicity: usize, turns: bool| AxisSplitLine {
        roots: vec![SplitRootLine {
            t,
            multiplicity: [multiplicity; 2],
            turns,
        }],
        constant: Vec::new(),
    };
    let flat = AxisSplitLine {
        roots: Vec::new(),
        constant: vec![[claim(0.0, 0.0), claim(1.0, 1.0)]],
    };
    let verdict = |u: AxisSplitLine, v: AxisSplitLine| {
        let body = Body::Split {
            u,
            v,
            undecided: None,
        };
        judge(&ASKED, &body, &split).verdict
    };
    let good = claim(0.333, 0.334);
    assert_eq!(verdict(one(good, 1, true), flat.clone()), Verdict::Right);
    assert_eq!(verdict(one(good, 2, false), flat.clone()), Verdict::Wrong);
    assert_eq!(
        verdict(one(claim(0.34, 0.35), 1, true), flat.clone()),
        Verdict::Wrong
    );
    assert_eq!(
        verdict(AxisSplitLine::default(), flat.clone()),
        Verdict::Wrong
    );
    assert_eq!(
        verdict(one(good, 1, true), AxisSplitLine::default()),
        Verdict::Wrong
    );
    let cut = third.lo.approximate();
    let partly = claim(cut, cut + 1e-6);
    assert_eq!(
        verdict(one(partly, 1, true), flat.clone()),
        Verdict::Indeterminate
    );
    assert_eq!(verdict(flat, one(good, 1, true)), Verdict::Wrong);
    let open = Body::Split {
        u: AxisSplitLine::default(),
        v: AxisSplitLine::default(),
        undecided: Some("why".into()),
    };
    assert_eq!(judge(&ASKED, &open, &split).verdict, Verdict::Undecided);
}

/// Where a line enters a face at an edge, the hit in the one and the run in the other begin together: in whichever order.
#[test]
fn hits_at_one_parameter_are_in_no_order() {
    let run = |begin: &TruthEnclosure| HitTruth {
        t_end: Some(truth("3p0", "3p0")),
        tangential: Some(true),
        ..hit(begin, 1)
    };
    let begin = truth("1p0", "1p0");
    let t = Truth::Line {
        hits: vec![hit(&begin, 0), run(&begin), hit(&truth("3p0", "3p0"), 2)],
        crossings: None,
        in_crack: Some(false),
    };
    let claim = |value| Claim {
        value,
        lo: Some(value),
        hi: Some(value),
    };
    let one = |value, end: Option<f64>| HitLine {
        t: claim(value),
        t_end: end.map(claim),
        point: [0.0; 3],
        normal: [0.0, 0.0, 1.0],
        feature: None,
        uv: None,
        tangential: Some(end.is_some()),
    };
    let answer = |hits| Body::Line {
        hits,
        crossings: None,
        in_crack: Some(false),
        undecided: None,
    };
    let verdict = |hits| judge(&ASKED, &answer(hits), &t).verdict;
    let (point, run, last) = (one(1.0, None), one(1.0, Some(3.0)), one(3.0, None));
    assert_eq!(
        verdict(vec![point.clone(), run.clone(), last.clone()]),
        Verdict::Right
    );
    assert_eq!(
        verdict(vec![run.clone(), point.clone(), last.clone()]),
        Verdict::Right
    );
    // But not in any order at all, nor of any end.
    assert_eq!(
        verdict(vec![last.clone(), run.clone(), point.clone()]),
        Verdict::Wrong
    );
    assert_eq!(
        verdict(vec![point, one(1.0, Some(2.0)), last]),
        Verdict::Wrong
    );
}

/// Where the truth says of one hit only whether it is a touch, the claims at its parameter are held against that, in
/// whichever order.
#[test]
fn a_hit_of_unknown_kind_is_paired_with_any() {
    let one = truth("1p0", "1p0");
    let unsaid = |face| HitTruth {
        tangential: None,
        ..hit(&one, face)
    };
    let verdict = |truths: Vec<HitTruth>, claims: &[(f64, bool)]| {
        let t = Truth::Line {
            hits: truths,
            crossings: Some(2),
            in_crack: Some(false),
        };
        judge(&ASKED, &line(claims), &t).verdict
    };
    let (touch, cross) = ((1.0, true), (1.0, false));
    for claims in [[touch, cross], [cross, touch]] {
        assert_eq!(
            verdict(vec![unsaid(0), hit(&one, 1)], &claims),
            Verdict::Right
        );
        assert_eq!(
            verdict(vec![hit(&one, 0), unsaid(1)], &claims),
            Verdict::Right
        );
        let both = vec![hit(&one, 0), hit(&one, 1)];
        assert_eq!(verdict(both, &claims), Verdict::Wrong);
    }
    // One hit for the edge that two faces share: a touch of the one and a crossing of the other is either.
    let touched = HitTruth {
        tangential: Some(true),
        ..hit(&one, 0)
    };
    for claim in [touch, cross] {
        let both = vec![touched.clone(), hit(&one, 1)];
        assert_eq!(verdict(both, &[claim]), Verdict::Right);
    }
    let both = vec![touched.clone(), touched];
    assert_eq!(verdict(both, &[cross]), Verdict::Wrong);
}

#[test]
fn both_ends_of_a_run_have_errors() {
    let t = Truth::Line {
        hits: vec![HitTruth {
            t_end: Some(truth("3p0", "3p0")),
            ..hit(&truth("1p0", "1p0"), 0)
        }],
        crossings: None,
        in_crack: None,
    };
    let claim = |value: f64| Claim {
        value,
        lo: Some(value.next_down()),
        hi: Some(value.next_up()),
    };
    let ulps = |begin: f64, end: f64| {
        let mut body = line(&[(begin, false)]);
        if let Body::Line { hits, .. } = &mut body {
            hits[0].t_end = Some(claim(end));
        }
        let j = judge(&ASKED, &body, &t);
        assert_eq!(j.verdict, Verdict::Right);
        j.ulps.unwrap()
    };
    assert_eq!(ulps(1.0, 3.0), 0.0);
    assert_eq!(ulps(1.0f64.next_up(), 3.0), 1.0);
    assert_eq!(ulps(1.0, 3.0f64.next_up()), 1.0);
}

/// An engine without certificates leaves out what it does not claim: only what it says is judged.
#[test]
fn what_is_left_out_is_not_judged() {
    let t = Truth::Line {
        hits: vec![hit(&truth("1p0", "1p0"), 0)],
        crossings: Some(1),
        in_crack: Some(false),
    };
    let asked = Asked {
        tolerance: 1e-9,
        ..ASKED
    };
    let answer = |value, tangential, crossings, in_crack| Body::Line {
        hits: vec![HitLine {
            t: Claim {
                value,
                lo: None,
                hi: None,
            },
            t_end: None,
            point: [0.0; 3],
            normal: [0.0, 0.0, 1.0],
            feature: None,
            uv: None,
            tangential,
        }],
        crossings,
        in_crack,
        undecided: None,
    };
    let verdict = |b: &Body| judge(&asked, b, &t).verdict;
    assert_eq!(verdict(&answer(1.0, None, None, None)), Verdict::Right);
    for wrong in [
        answer(1.0 + 1e-8, None, None, None),
        answer(1.0, Some(true), None, None),
        answer(1.0, None, Some(2), None),
        answer(1.0, None, None, Some(true)),
    ] {
        assert_eq!(verdict(&wrong), Verdict::Wrong);
    }
    let side = |in_gap| Body::Side {
        side: Some(Side::Inside),
        in_gap,
        undecided: None,
    };
    let t = Truth::Side {
        side: Side::Inside,
        in_gap: Some(false),
    };
    let verdict = |b: &Body| judge(&asked, b, &t).verdict;
    assert_eq!(verdict(&side(None)), Verdict::Right);
    assert_eq!(verdict(&side(Some(true))), Verdict::Wrong);
}

/// A ball of radius 1 whose centre is at a distance of 2 above the foot, or in material 2 below it.
#[test]
fn feet_and_normals() {
    let probe = |z: f64| {
        let ball = feeler::query::Sphere::new(nalgebra::Point3::new(1.0, 0.0, z), 1.0);
        Some(feeler::query::Probe::Sphere(ball.unwrap()))
    };
    let asked = |z: f64| Asked {
        contacts: true,
        probe: probe(z),
        ..ASKED
    };
    for (z, separation) in [(2.0, 1.0), (-2.0, -3.0)] {
        let s = if separation > 0.0 { "1p0" } else { "-3p0" };
        let t = Truth::Contact {
            separation: truth(s, s),
            foot: Some([[1.0, 1.0], [0.0; 2], [-1e-18, 1e-18]]),
            contacts: None,
        };
        let judged =
            |c: ContactLine, asked: &Asked| judge(asked, &with_contacts(vec![c], None), &t);
        let asked = Asked {
            prediction: 2.0,
            ..asked(z)
        };
        let line = |x: f64, normal: [f64; 3]| ContactLine {
            // From the centre, the radius long.
            on_probe: [1.0 - normal[0], -normal[1], z - normal[2]],
            normal,
            normal_bound: Some(1e-12),
            normal_is_choice: false,
            ..contact(x, separation, Some(1e-12))
        };
        let up = [0.0, 0.0, 1.0];
        assert_eq!(judged(line(1.0, up), &asked).verdict, Verdict::Right);
        assert_eq!(
            judged(line(1.0 + 1e-13, [1e-13, 0.0, 1.0]), &asked).verdict,
            Verdict::Right
        );
        for (wrong, why) in [
            (line(1.0 + 1e-11, up), "the foot is off"),
            (line(1.0, [0.0, 0.0, -1.0]), "the normal is off"),
            (line(1.0, [1e-11, 0.0, 1.0]), "the normal is off"),
            (line(1.0, [f64::NAN, 0.0, 1.0]), "the normal is off"),
        ] {
            let judged = judged(wrong, &asked);
            assert_eq!(judged.verdict, Verdict::Wrong);
            assert!(judged.reason.unwrap().contains(why), "{why}");
        }
    }
}

/// So large a ball that its separation has no digit left of where its centre is: above a face or below it by less than a rounding of the radius.
#[test]
fn the_normal_of_a_large_ball() {
    const RADIUS: f64 = (1u64 << 60) as f64;
    /// Far less than its last digit, 256.
    const HEIGHT: f64 = 1.0 / 1024.0;
    /// What foot and normal, which are exact, are said to be known within: any will do.
    const BOUND: f64 = f64::EPSILON;
    for z in [HEIGHT, -HEIGHT] {
        let ball = feeler::query::Sphere::new([1.0, 0.0, z].into(), RADIUS).unwrap();
        let asked = Asked {
            contacts: true,
            probe: Some(Probe::Sphere(ball)),
            ..ASKED
        };
        let exact = &Dyadic::from_f64(z).unwrap() - &Dyadic::from_f64(RADIUS).unwrap();
        let t = Truth::Contact {
            separation: TruthEnclosure {
                lo: exact.clone(),
                hi: exact,
            },
            foot: Some([[1.0, 1.0], [0.0; 2], [0.0; 2]]),
            contacts: None,
        };
        let judged = |up: f64| {
            let separation = Claim {
                value: -RADIUS,
                lo: Some((-RADIUS).next_down()),
                hi: Some((-RADIUS).next_up()),
            };
            let contact = ContactLine {
                on_probe: [1.0, 0.0, z - up * RADIUS],
                normal: [0.0, 0.0, up],
                normal_bound: Some(BOUND),
                separation,
                ..contact(1.0, -RADIUS, Some(BOUND))
            };
            judge(&asked, &with_contacts(vec![contact], None), &t)
        };
        assert_eq!(
            judged(1.0).verdict,
            Verdict::Right,
            "{z}: {:?}",
            judged(1.0)
        );
        assert_eq!(judged(-1.0).verdict, Verdict::Wrong, "{z}");
    }
}

/// A centre that is 2^-20 above a face, and by a coarse claim on it or within twice that: then the face's normal counts, which a foot that is beside it does not tell, but
/// for its side.
#[test]
fn a_normal_next_to_the_surface() {
    const HEIGHT: f64 = 1.0 / (1u64 << 20) as f64;
    let ball = feeler::query::Sphere::new([0.0; 3].into(), 0.5).unwrap();
    let asked = Asked {
        accuracy: Accuracy::Length(0.01),
        contacts: true,
        prediction: 4.0,
        probe: Some(Probe::Sphere(ball)),
        ..ASKED
    };
    let t = Truth::Separation(truth("-7ffffp-20", "-7ffffp-20"));
    let judged = |lo: f64, normal: [f64; 3], normal_is_choice: bool, undecided: Option<&str>| {
        let separation = Claim {
            value: HEIGHT - 0.5,
            lo: Some(lo),
            hi: Some(2.0 * HEIGHT - 0.5),
        };
        let contact = ContactLine {
            on_brep: [0.0, 0.0, -HEIGHT],
            on_probe: normal.map(|x| -0.5 * x),
            normal,
            separation,
            normal_is_choice,
            ..contact(0.0, 0.0, None)
        };
        let body = Body::Contact {
            separation,
            continuum: Some(true),
            contacts: vec![contact],
            undecided: undecided.map(str::to_owned),
        };
        judge(&asked, &body, &t).verdict
    };
    for (normal, right) in [
        ([0.0, 0.0, 1.0], true),
        ([0.6, 0.0, 0.8], true),
        ([1.0, 0.0, 0.0], true),
        ([0.6, 0.0, -0.8], false),
        ([0.0, 0.0, -1.0], false),
    ] {
        let expected = if right {
            Verdict::Right
        } else {
            Verdict::Wrong
        };
        assert_eq!(judged(-0.5, normal, false, None), expected, "{normal:?}");
        assert_eq!(
            judged(-0.5, normal, true, None),
            Verdict::Right,
            "{normal:?}"
        );
        // Of bounds that leave it open on which side of the face the centre is, nothing is asked.
        let either = judged(-0.5 - HEIGHT, normal, false, None);
        assert_eq!(either, Verdict::Right, "{normal:?}");
        // Nor of an answer that says so.
        let open = judged(-0.5, normal, false, Some("the side is not known"));
        assert_eq!(open, Verdict::Undecided, "{normal:?}");
        // What is not on it is where its foot says.
        let is_up = normal == [0.0, 0.0, 1.0];
        let apart = judged(0.5 * HEIGHT - 0.5, normal, true, None);
        assert_eq!(apart == Verdict::Right, is_up, "{normal:?}");
    }
}

/// What the deepest contact is judged by where nothing is known of its foot, as of a continuum: the ball of radius 1/2 in the middle of a sphere of radius 2 about the
/// origin, from within material, and a half-space on a face `z = 1`.
#[test]
fn a_contact_stands_on_its_own() {
    /// By how much places are off, of their own lengths: far more than what is low (2^-44 of the size) and roundings...
    const OFF: f64 = 1e-9;
    /// ...and bounds that have no room for it, and that have.
    const NARROW: f64 = OFF / 10.0;
    const WIDE: f64 = 100.0 * OFF;
    /// A normal's length is off by some thousand roundings.
    const LONGER: f64 = 1.0 + 4096.0 * f64::EPSILON;
    let asked = Asked {
        contacts: true,
        prediction: 4.0,
        ..ASKED
    };
    let judged = |probe: Probe, truth: &str, c: &ContactLine, continuum: bool| {
        let asked = Asked {
            probe: Some(probe),
            ..asked
        };
        let t = Truth::Contact {
            separation: self::truth(truth, truth),
            foot: None,
            contacts: None,
        };
        let mut body = with_contacts(vec![c.clone()], None);
        if let Body::Contact {
            continuum: told, ..
        } = &mut body
        {
            *told = Some(continuum);
        }
        judge(&asked, &body, &t)
    };
    let ball = Probe::Sphere(feeler::query::Sphere::new([0.0; 3].into(), 0.5).unwrap());
    let rests = feeler::query::HalfSpace::new([0.0, 0.0, 1.0].into(), 0.5).unwrap();
    let rests = Probe::HalfSpace(rests);
    let in_ball = ContactLine {
        on_brep: [1.2, 1.6, 0.0],
        normal: [0.6, 0.8, 0.0],
        on_probe: [-0.3, -0.4, 0.0],
        ..contact(0.0, -2.5, None)
    };
    let on_face = ContactLine {
        on_brep: [3.0, -2.0, 1.0],
        normal: [0.0, 0.0, -1.0],
        on_probe: [3.0, -2.0, 0.5],
        ..contact(0.0, 0.5, None)
    };
    for (probe, truth, right) in [(ball, "-5p-1", &in_ball), (rests, "1p-1", &on_face)] {
        for continuum in [true, false] {
            let verdict = judged(probe, truth, right, continuum);
            assert_eq!(verdict.verdict, Verdict::Right, "{:?}", verdict.reason);
        }
        let wrong = |c: ContactLine, continuum: bool, why: &str| {
            let verdict = judged(probe, truth, &c, continuum);
            assert_eq!(verdict.verdict, Verdict::Wrong, "{why}");
            assert!(verdict.reason.unwrap().contains(why), "{why}");
        };
        let times = |x: [f64; 3], by: f64| x.map(|x| x * by);
        // A foot away from the BREP or in front of it, by more than what is low; in a continuum, or by more than its bound.
        let off = |by: f64, position_bound: Option<f64>| ContactLine {
            on_brep: times(right.on_brep, by),
            position_bound,
            ..right.clone()
        };
        wrong(off(1.0 + OFF, None), true, "farther away");
        wrong(off(1.0 + OFF, Some(NARROW)), false, "farther away");
        // Bounds that are wider than the accuracy leave a foot room, of a continuum too, but no more.
        let undecided = |by: f64| {
            let mut claim = off(by, None);
            if let Probe::HalfSpace(_) = probe {
                claim.on_probe = [claim.on_brep[0], claim.on_brep[1], right.on_probe[2]];
            }
            let own = &mut claim.separation;
            own.lo = own.lo.map(|x| x - WIDE);
            claim
        };
        let verdict = judged(probe, truth, &undecided(1.0 + OFF), true);
        assert_eq!(verdict.verdict, Verdict::Undecided, "{:?}", verdict.reason);
        wrong(undecided(1.0 + 2.0 * WIDE), true, "farther away");
        wrong(off(1.0 - OFF, None), true, "nearer");
        wrong(off(1.0 - OFF, Some(WIDE)), false, "nearer");
        wrong(off(f64::NAN, None), true, "nearer");
        let normal = |normal: [f64; 3]| ContactLine {
            normal,
            ..right.clone()
        };
        wrong(normal(times(right.normal, LONGER)), true, "length");
        wrong(normal(times(right.normal, f64::NAN)), false, "length");
        wrong(normal(times(right.normal, -1.0)), true, "its foot's");
        wrong(normal([0.8, 0.6, 0.0]), true, "its foot's");
        let beside = ContactLine {
            on_probe: right.on_probe.map(|x| x + OFF),
            ..right.clone()
        };
        wrong(beside, true, "on the probe");
    }
}

/// One hit may be asked for: the first, or whichever.
#[test]
fn one_hit_of_many() {
    let at = |t: &str| hit(&truth(t, t), 0);
    let none = Truth::Line {
        hits: vec![],
        crossings: Some(0),
        in_crack: Some(false),
    };
    let many = Truth::Line {
        hits: vec![at("1p0"), at("3p0")],
        crossings: Some(2),
        in_crack: Some(false),
    };
    let verdict = |hits, claims: &[(f64, bool)], t: &Truth| {
        let asked = Asked { hits, ..ASKED };
        let mut body = line(claims);
        if let Body::Line { crossings, .. } = &mut body {
            *crossings = None;
        }
        judge(&asked, &body, t).verdict
    };
    for hits in [Hits::First, Hits::Any] {
        assert_eq!(verdict(hits, &[(1.0, false)], &many), Verdict::Right);
        assert_eq!(verdict(hits, &[(2.0, false)], &many), Verdict::Wrong);
        assert_eq!(verdict(hits, &[(1.0, true)], &many), Verdict::Wrong);
        assert_eq!(verdict(hits, &[], &many), Verdict::Wrong);
        let two = [(1.0, false), (3.0, false)];
        assert_eq!(verdict(hits, &two, &many), Verdict::Wrong);
        assert_eq!(verdict(hits, &[(1.0, false)], &none), Verdict::Wrong);
        assert_eq!(verdict(hits, &[], &none), Verdict::Right);
    }
    assert_eq!(verdict(Hits::First, &[(3.0, false)], &many), Verdict::Wrong);
    assert_eq!(verdict(Hits::Any, &[(3.0, false)], &many), Verdict::Right);
    assert_eq!(verdict(Hits::All, &[(1.0, false)], &many), Verdict::Wrong);
}
