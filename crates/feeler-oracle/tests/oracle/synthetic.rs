//! Contacts of the kernel against the oracle on random faces made to be hard: kinks, wild weights, spans of
//! very different lengths, poles, high degrees, and trims that run along joints or leave the domain.

use crate::scene::{Random, bezier, brep, dyadic, polygon};
use feeler::brep::Brep;
use feeler::nurbs::{Curve2, NurbsSurface, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{Accuracy, Options, Probe, Sphere, Workspace, contact, evaluate};
use feeler_oracle::Oracle;
use nalgebra::{Point3, Vector3, Vector4};

/// A random face, and points of it to ask near to.
struct Case {
    name: &'static str,
    brep: Brep,
    targets: Vec<[f64; 2]>,
    size: f64,
}

fn pick(r: &mut Random, n: usize) -> usize {
    ((r.next() * n as f64) as usize).min(n - 1)
}

/// A knot vector of `spans` spans on [0, 1]; inner knots of full multiplicity where `kinks`.
fn knots(r: &mut Random, degree: usize, spans: usize, kinks: bool, wild: bool) -> Vec<f64> {
    let mut inner: Vec<f64> = (1..spans)
        .map(|i| {
            if wild {
                10f64.powf(-3.0 * r.next()) * i as f64 / spans as f64
            } else {
                i as f64 / spans as f64
            }
        })
        .collect();
    inner.sort_by(f64::total_cmp);
    let mut all = vec![0.0; degree + 1];
    for k in inner {
        all.extend(vec![k; if kinks { degree } else { 1 }]);
    }
    all.extend(vec![1.0; degree + 1]);
    all
}

fn surface(r: &mut Random, kind: usize, scale: f64, offset: f64) -> (NurbsSurface, &'static str) {
    let (degrees, spans, kinks, wild, weights, name) = match kind {
        0 => ([3, 3], [2, 2], false, false, 0.0, "bicubic"),
        1 => ([2, 2], [3, 2], true, false, 0.0, "kinks"),
        2 => ([3, 2], [1, 1], false, false, 3.0, "weights 1e+-3"),
        3 => ([2, 2], [2, 1], false, false, 6.0, "weights 1e+-6"),
        4 => ([5, 4], [1, 1], false, false, 0.3, "degree 5"),
        5 => ([3, 3], [1, 2], false, false, 0.0, "pole"),
        6 => ([3, 2], [3, 2], false, true, 0.3, "uneven spans"),
        7 => ([1, 2], [3, 1], true, true, 0.5, "ruled kinks"),
        _ => ([2, 2], [1, 1], false, false, 0.0, "symmetric"),
    };
    let ku = knots(r, degrees[0], spans[0], kinks, wild);
    let kv = knots(r, degrees[1], spans[1], kinks, wild);
    let counts = [ku.len() - degrees[0] - 1, kv.len() - degrees[1] - 1];
    let mut net = Vec::new();
    for i in 0..counts[0] {
        for j in 0..counts[1] {
            let at = |k: usize, n: usize| 2.0 * k as f64 / (n - 1) as f64 - 1.0;
            let (x, y) = (at(i, counts[0]), at(j, counts[1]));
            let jitter = 0.3 * (r.next() - 0.5);
            let z = if kind == 8 {
                0.5 * (x * x + y * y)
            } else {
                1.4 * (r.next() - 0.5)
            };
            let (x, y) = if kind == 5 && i == 0 {
                (-1.0, 0.0)
            } else if kind == 8 {
                (x, y)
            } else {
                (x + jitter, y - 0.5 * jitter)
            };
            let z = if kind == 5 && i == 0 { 0.25 } else { z };
            let w = 10f64.powf(weights * 2.0 * (r.next() - 0.5));
            let p = [x, y, z].map(|c| scale * c + offset);
            net.push(Vector4::new(w * p[0], w * p[1], w * p[2], w));
        }
    }
    (
        NurbsSurface::new(degrees, counts, net, [ku, kv]).unwrap(),
        name,
    )
}

/// A loop and points on it.
fn trims(
    r: &mut Random,
    kind: usize,
    inner: [f64; 2],
) -> (Option<Vec<Vec<Curve2>>>, Vec<[f64; 2]>) {
    let [ku, kv] = inner;
    match kind {
        0 => (
            None,
            vec![[0.0, r.next()], [1.0, 1.0], [ku, kv], [ku, r.next()]],
        ),
        1 => {
            // A diamond that leaves the domain at four places, with a hole.
            let e = 0.2 * r.next();
            let diamond = [[0.5, -e], [1.0 + e, 0.5], [0.5, 1.0 + e], [-e, 0.5]];
            let hole = [[0.4, 0.4], [0.4, 0.6], [0.6, 0.55]];
            let cut = e / (0.5 + e) * (0.5 + e);
            (
                Some(vec![polygon(&diamond), polygon(&hole)]),
                vec![
                    [0.5 - cut, 0.0],
                    [0.5 + cut, 0.0],
                    [1.0, 0.5 - cut],
                    [0.4, 0.4],
                ],
            )
        }
        2 => {
            // A side along an inner knot, off by almost nothing.
            let e = 10f64.powf(-9.0 - 8.0 * r.next());
            let e = if r.next() < 0.5 { -e } else { e };
            (
                Some(vec![polygon(&[
                    [ku + e, 0.1],
                    [0.95, 0.1],
                    [0.95, 0.9],
                    [ku - e, 0.9],
                ])]),
                vec![[ku, r.range(0.1, 0.9)], [ku, 0.5], [ku, kv]],
            )
        }
        3 => {
            // Two rational cubics over many patches; they do not quite meet.
            let e = 10f64.powf(-4.0 - 12.0 * r.next());
            let (w, a) = (10f64.powf(2.0 * r.next() - 1.0), r.range(0.05, 0.2));
            let lower = bezier(&[
                [a, 0.5, 1.0],
                [0.3 * w, -0.3 * w, w],
                [0.7 * w, -0.1 * w, w],
                [0.9, 0.5, 1.0],
            ]);
            let upper = bezier(&[
                [0.9 + e, 0.5, 1.0],
                [0.7 * w, 1.3 * w, w],
                [0.3 * w, 1.1 * w, w],
                [a, 0.5 + e, 1.0],
            ]);
            (
                Some(vec![vec![lower, upper]]),
                vec![[a, 0.5], [0.9, 0.5], [0.5, 0.05], [0.5, 0.95], [ku, 0.1]],
            )
        }
        _ => {
            // A triangle whose tip just passes an inner knot.
            let e = 10f64.powf(-3.0 - 10.0 * r.next());
            (
                Some(vec![polygon(&[[ku - e, kv], [0.97, 0.2], [0.97, 0.8]])]),
                vec![[ku, kv], [ku - e, kv], [0.97, 0.2]],
            )
        }
    }
}

fn case(r: &mut Random, number: usize) -> Case {
    let scale = [1.0, 1e-6, 1e6, 1.0][pick(r, 4)];
    let offset = if pick(r, 4) == 0 { 1e6 * scale } else { 0.0 };
    let (surface, name) = surface(r, number % 9, scale, offset);
    let inner = |k: &[f64]| k.iter().copied().find(|t| *t > 0.0 && *t < 1.0);
    let ku = inner(surface.knots_u().knots()).unwrap_or(0.5);
    let kv = inner(surface.knots_v().knots()).unwrap_or(0.5);
    let (loops, targets) = trims(r, (number / 9) % 5, [ku, kv]);
    Case {
        name,
        brep: brep(Surface::Nurbs(surface), loops),
        targets,
        size: scale,
    }
}

/// What came of the queries: how many, and how many claims were wider than asked.
fn attack(seed: u64, cases: std::ops::Range<usize>, queries: usize) -> [usize; 2] {
    let mut count = [0; 2];
    let mut wrong = Vec::new();
    for number in cases {
        let mut r = Random(seed ^ (number as u64) << 20);
        let c = case(&mut r, number);
        let Ok(oracle) = Oracle::new(&[&c.brep]) else {
            continue;
        };
        let prepared = PreparedBrep::new(c.brep.clone());
        let surface = c.brep.surface(0);
        for q in 0..queries {
            let uv = if q % 3 == 0 {
                [r.next(), r.next()]
            } else {
                let t = c.targets[pick(&mut r, c.targets.len())];
                let e = if q % 3 == 1 {
                    0.0
                } else {
                    10f64.powf(-3.0 - 12.0 * r.next())
                };
                [t[0] + e * (r.next() - 0.5), t[1] + e * (r.next() - 0.5)]
                    .map(|x| x.clamp(0.0, 1.0))
            };
            let away = Vector3::new(r.next() - 0.5, r.next() - 0.5, r.next() - 0.5)
                * c.size
                * 10f64.powf(1.0 - 5.0 * r.next().powi(3) * 3.0);
            let center: Point3<f64> = surface.point(uv[0], uv[1]) + away;
            let center = if c.name == "symmetric" && q % 2 == 0 {
                let o = surface.point(0.5, 0.5);
                Point3::new(o.x, o.y, o.z + c.size * r.next() * 2.0)
            } else {
                center
            };
            let accuracy = if q % 2 == 0 {
                Accuracy::Full
            } else {
                Accuracy::Length(c.size * 10f64.powf(-6.0 - 6.0 * r.next()))
            };
            let probe = Probe::Sphere(Sphere::new(center, 0.0).unwrap());
            let options = Options {
                accuracy,
                prediction: f64::INFINITY,
                node_budget: 20_000,
                ..Options::default()
            };
            let a = contact(&prepared, &probe, &options, &mut Workspace::default());
            let truth = match oracle.distance([center.x, center.y, center.z], None) {
                Ok(Some(t)) => t,
                other => {
                    println!("{number} {}: oracle {other:?}", c.name);
                    continue;
                }
            };
            count[0] += 1;
            let [lo, hi] = [a.separation.bounds.lo, a.separation.bounds.hi];
            let at = format!("case {number} {} query {q} {center:?} {accuracy:?}", c.name);
            if a.undecided.is_some() {
                count[1] += 1;
                println!(
                    "OPEN {at}: [{lo:e}, {hi:e}] {:?} {:e} truth {:e}",
                    a.undecided,
                    hi - lo,
                    truth.enclosure.lo.approximate()
                );
            }
            let above = hi.is_finite() && truth.enclosure.lo > dyadic(hi);
            let below = lo.is_finite() && truth.enclosure.hi < dyadic(lo);
            if above || below || lo.is_nan() || hi.is_nan() {
                wrong.push(format!(
                    "{at}: [{lo:e}, {hi:e}] but {:e} ({:e} off) {:?}",
                    truth.enclosure.lo.approximate(),
                    if above {
                        (&truth.enclosure.lo - &dyadic(hi)).approximate()
                    } else {
                        (&dyadic(lo) - &truth.enclosure.hi).approximate()
                    },
                    truth.status
                ));
            }
            for k in &a.contacts {
                let on = evaluate(&prepared, 0, k.uv).unwrap().point;
                let n = k.normal.norm();
                let side = oracle.side(0, [k.uv.x, k.uv.y]);
                let gap = (center - k.on_brep).norm();
                // Plain evaluations are off by some roundings of the largest coordinate, and uv by one in uv.
                let slack = 1e-12
                    * (center.coords.amax() + c.size)
                    * if c.name.starts_with("weights") {
                        1e6
                    } else {
                        100.0
                    };
                if !((n - 1.0).abs() < 1e-14)
                    || (on - k.on_brep).norm() > slack
                    || (gap - k.separation.value).abs() > slack + hi - lo
                {
                    wrong.push(format!("{at}: contact {k:?} side {side:?} on {on:?}"));
                }
            }
        }
    }
    for w in &wrong {
        println!("WRONG {w}");
    }
    assert!(wrong.is_empty(), "{} wrong", wrong.len());
    count
}

#[test]
fn random_faces_agree_with_the_oracle() {
    let [asked, open] = attack(1, 0..90, 6);
    println!("{asked} queries, {open} wider than asked");
    assert!(asked > 500);
}
