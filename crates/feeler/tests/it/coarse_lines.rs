//! Hits of lines at coarse accuracies against those at full accuracy, and on BREPs that have answered nothing before.

use crate::scenes::{
    Random, bicubic, cube, native_sphere, nurbs_cylinder, nurbs_sphere, trimmed_bicubic, wavy_prism,
};
use feeler::brep::Brep;
use feeler::prepare::PreparedBrep;
use feeler::query::{Accuracy, LineAnswer, LineKind, LineProbe, Options, Workspace, any_hit, line};
use nalgebra::{Point3, Vector3};

fn parts() -> Vec<(&'static str, Brep)> {
    vec![
        ("bicubic", bicubic()),
        ("trimmed bicubic", trimmed_bicubic()),
        ("cube", cube()),
        ("native sphere", native_sphere()),
        ("NURBS sphere", nurbs_sphere()),
        ("NURBS cylinder", nurbs_cylinder()),
        ("prism", wavy_prism(38)),
    ]
}

fn ask(brep: &PreparedBrep, probe: &LineProbe, accuracy: Accuracy) -> LineAnswer {
    let options = Options {
        accuracy,
        ..Options::default()
    };
    line(brep, probe, &options, &mut Workspace::default())
}

/// Lines, rays and segments: through the part, next to its vertices and edges, from afar, with long and short directions.
fn probes(brep: &Brep, count: usize, random: &mut Random) -> Vec<LineProbe> {
    let vertices = &brep.parts().vertices;
    let size = PreparedBrep::new(brep.clone()).size();
    let mut out = Vec::new();
    for k in 0..count {
        let free = Point3::from(random.direction() * random.between(0.0, 0.6 * size));
        let near = |random: &mut Random| {
            let v = vertices[(random.between(0.0, 1.0) * vertices.len() as f64) as usize].point;
            let v = Point3::new(v[0], v[1], v[2]);
            v + random.direction() * size * 10f64.powf(random.between(-14.0, -1.0))
        };
        let at = match k % 3 {
            0 if !vertices.is_empty() => near(random),
            1 if vertices.len() > 1 => near(random) + 0.5 * (near(random) - near(random)),
            _ => free,
        };
        let direction: Vector3<f64> = random.direction();
        let back = match k % 4 {
            0 => 0.0,
            1 => size,
            2 => -0.3 * size,
            _ => 1e6 * size,
        };
        let length = 10f64.powf(random.between(-3.0, 3.0));
        let kind = [LineKind::Line, LineKind::Ray, LineKind::Segment][k % 7 % 3];
        let stretch = match kind {
            LineKind::Segment => 2.0 * (size + back.abs()),
            _ => length,
        };
        out.push(LineProbe::new(at - direction * back, direction * stretch, kind).unwrap());
    }
    out
}

/// The same hits in the same order, each enclosure holding that of full accuracy up to its own width, and as narrow as was asked.
#[test]
fn coarse_hits_are_those_of_full_accuracy() {
    let mut random = Random::new(31);
    for (name, brep) in parts() {
        let probes = probes(&brep, 400, &mut random);
        let brep = PreparedBrep::new(brep);
        let (mut decided, mut hits) = (0, 0);
        for probe in &probes {
            let full = ask(&brep, probe, Accuracy::Full);
            if full.undecided.is_some() {
                continue;
            }
            decided += 1;
            for part in [1e-12, 1e-6, 1e-2] {
                let length = part * brep.size();
                let coarse = ask(&brep, probe, Accuracy::Length(length));
                assert_eq!(coarse.undecided, None, "{name} {probe:?}");
                assert_eq!(coarse.crossings, full.crossings, "{name} {probe:?}");
                assert_eq!(coarse.in_crack, full.in_crack, "{name} {probe:?}");
                let faces = |a: &LineAnswer| a.hits.iter().map(|h| h.face).collect::<Vec<_>>();
                assert_eq!(faces(&coarse).len(), faces(&full).len(), "{name} {probe:?}");
                for (a, b) in coarse.hits.iter().zip(&full.hits) {
                    hits += 1;
                    let (a, b) = (a.t.bounds, b.t.bounds);
                    assert!(a.lo <= b.hi && b.lo <= a.hi, "{name} {probe:?} {a:?} {b:?}");
                    let rounding = 4.0 * f64::EPSILON * a.hi.abs().max(a.lo.abs());
                    let widest = length / probe.direction.norm() + rounding;
                    assert!(a.hi - a.lo <= widest, "{name} {probe:?} {a:?}");
                }
            }
        }
        assert!(decided > 300 && hits > 100, "{name}: {decided} {hits}");
    }
}

/// What a BREP was asked before changes no bit of an answer, nor what it is said to have cost; and any hit is one where there is one.
#[test]
fn earlier_queries_change_nothing() {
    let mut random = Random::new(32);
    for (name, brep) in parts() {
        let probes = probes(&brep, 60, &mut random);
        let used = PreparedBrep::new(brep.clone());
        for probe in &probes {
            ask(&used, probe, Accuracy::Full);
        }
        for probe in &probes {
            for accuracy in [Accuracy::Full, Accuracy::Length(1e-9)] {
                let fresh = PreparedBrep::new(brep.clone());
                let options = Options {
                    accuracy,
                    ..Options::default()
                };
                let [a, b] = [&used, &fresh].map(|b| {
                    let mut workspace = Workspace::default();
                    let answer = line(b, probe, &options, &mut workspace);
                    format!("{answer:?} {:?}", workspace.work())
                });
                assert_eq!(a, b, "{name} {probe:?}");
            }
            let all = ask(&used, probe, Accuracy::Full);
            let any = any_hit(&used, probe, &Options::default(), &mut Workspace::default());
            if all.undecided.is_none() && any.undecided.is_none() {
                assert_eq!(any.hit.is_some(), !all.hits.is_empty(), "{name} {probe:?}");
            }
        }
    }
}

/// What f64 spends counts where double-double has to follow: no more is spent than is allowed, and all of it is told.
#[test]
fn what_f64_spends_in_vain_counts() {
    let mut random = Random::new(33);
    let (mut followed, mut short) = (0, 0);
    let brep = bicubic();
    let probes = probes(&brep, 200, &mut random);
    let brep = PreparedBrep::new(brep);
    for probe in &probes {
        let nodes = |accuracy: Accuracy, node_budget: usize| {
            let options = Options {
                accuracy,
                node_budget,
                ..Options::default()
            };
            let mut workspace = Workspace::default();
            let answer = line(&brep, probe, &options, &mut workspace);
            (workspace.work().nodes, answer)
        };
        // A sheet has no edges of two faces, near which coarse answers are full ones.
        let (full, answer) = nodes(Accuracy::Full, 200_000);
        if answer.hits.is_empty() || answer.undecided.is_some() {
            continue;
        }
        // No enclosure of f64 is that narrow.
        let (both, answer) = nodes(Accuracy::Length(1e-25), 200_000);
        assert!(both > full, "{both} {full} {probe:?}");
        assert_eq!(answer.undecided, None);
        followed += 1;
        let (less, answer) = nodes(Accuracy::Length(1e-25), 4 * full);
        assert!(less <= full, "{less} {full} {probe:?}");
        short += usize::from(answer.undecided.is_some());
    }
    assert!(followed > 30 && short > 10, "{followed} {short}");
}
