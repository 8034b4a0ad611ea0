//! Hits of lines: what must hold between answers, and against the second method.

use super::{Effort, Found, Subject, options, second_of};
use feeler::numeric::Dyadic;
use feeler::query::{self, Hit, LineAnswer, LineKind, LineProbe, Parameter};
use feeler_corpus::Query;
use feeler_oracle::second::SecondHit;
use feeler_oracle::second::number::Number;

pub(super) fn line(
    subject: &mut Subject<'_>,
    query: &Query,
    probe: &LineProbe,
    effort: Effort,
) -> Found {
    let asked = options(query);
    let (brep, workspace) = (&subject.prepared, &mut subject.workspace);
    let found = query::line(brep, probe, &asked, workspace);
    sound(&found, probe)?;
    let any = query::any_hit(brep, probe, &asked, workspace);
    let all_known = found.undecided.is_none();
    match (&any.hit, any.undecided) {
        (None, None) if !found.hits.is_empty() => {
            return Err("no hit at all, and hits listed".to_owned());
        }
        (Some(_), _) if all_known && found.hits.is_empty() => {
            return Err("a certain hit that is not listed".to_owned());
        }
        _ => {}
    }
    if probe.kind == LineKind::Line {
        let back = LineProbe {
            direction: -probe.direction,
            ..*probe
        };
        let other = query::line(brep, &back, &asked, workspace);
        if all_known && other.undecided.is_none() {
            mirrored(&found, &other)?;
        }
        let ray = LineProbe {
            kind: LineKind::Ray,
            ..*probe
        };
        let ahead = query::line(brep, &ray, &asked, workspace);
        let before = |h: &&Hit| end(h).bounds.hi >= 0.0;
        let at_most = found.hits.iter().filter(before).count();
        if all_known && ahead.undecided.is_none() && ahead.hits.len() > at_most {
            return Err(format!(
                "{} hits of the ray, at most {at_most} of the line",
                ahead.hits.len()
            ));
        }
    }
    if effort == Effort::Full {
        by_second(subject, probe, &found)?;
    }
    Ok(())
}

/// The last parameter of a hit, which is another where the line lies in the face.
fn end(hit: &Hit) -> &Parameter {
    hit.t_end.as_ref().unwrap_or(&hit.t)
}

fn sound(found: &LineAnswer, probe: &LineProbe) -> Found {
    for h in &found.hits {
        let b = h.t.bounds;
        if !(b.lo <= h.t.value && h.t.value <= b.hi) {
            return Err(format!(
                "t {:e} is not in [{:e}, {:e}]",
                h.t.value, b.lo, b.hi
            ));
        }
        let beyond = match probe.kind {
            LineKind::Line => false,
            LineKind::Ray => b.hi < 0.0,
            LineKind::Segment => b.hi < 0.0 || b.lo > 1.0,
        };
        if beyond {
            return Err(format!("a hit at t = {:e}, beyond the end", h.t.value));
        }
    }
    if found.hits.windows(2).any(|w| w[1].t.value < w[0].t.value) {
        return Err("hits that are not in order".to_owned());
    }
    Ok(())
}

/// The line run the other way has the same hits.
fn mirrored(found: &LineAnswer, other: &LineAnswer) -> Found {
    let same =
        |a: &Parameter, b: &Parameter| a.bounds.lo <= -b.bounds.lo && -b.bounds.hi <= a.bounds.hi;
    let meets = |a: &Hit, b: &Hit| a.face == b.face && same(&a.t, end(b)) && same(end(a), &b.t);
    for (these, those) in [(&found.hits, &other.hits), (&other.hits, &found.hits)] {
        for a in these {
            if !those.iter().any(|b| meets(a, b)) {
                return Err(format!(
                    "the hit at t = {:e} is none when the line runs the other way",
                    a.t.value
                ));
            }
        }
    }
    if found.crossings != other.crossings {
        return Err(format!(
            "{:?} crossings, and {:?} when the line runs the other way",
            found.crossings, other.crossings
        ));
    }
    Ok(())
}

fn by_second(subject: &Subject<'_>, probe: &LineProbe, found: &LineAnswer) -> Found {
    let second = second_of(&subject.scene.brep);
    let truth = second.line(
        probe.origin.coords.into(),
        probe.direction.into(),
        probe.kind,
    );
    let meets = |h: &Hit, t: &SecondHit| {
        let ends = (
            t.t.ends(),
            Dyadic::from_f64(h.t.bounds.lo),
            Dyadic::from_f64(h.t.bounds.hi),
        );
        let (Some((lo, hi)), Some(a), Some(b)) = ends else {
            return true;
        };
        h.face == t.face && lo <= b && a <= hi
    };
    if found.undecided.is_none() {
        for t in truth.hits.iter().filter(|t| t.certain) {
            if !found.hits.iter().any(|h| meets(h, t)) {
                return Err(format!(
                    "decided, but the hit with face {} at t = {:e} is missed",
                    t.face,
                    t.t.lo()
                ));
            }
        }
    }
    for h in &found.hits {
        let b = h.t.bounds;
        let open =
            |&(face, [lo, hi]): &(usize, [f64; 2])| face == h.face && lo <= b.hi && b.lo <= hi;
        if !truth.hits.iter().any(|t| meets(h, t)) && !truth.open.iter().any(open) {
            return Err(format!(
                "the hit with face {} at t = {:e} is none",
                h.face, h.t.value
            ));
        }
    }
    Ok(())
}
