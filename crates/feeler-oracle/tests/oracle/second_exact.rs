//! The first method against the second: derivative roots, sides, evaluation.

use crate::scene;
use crate::scene::stress::{chebyshev, curve, graph, reweighted, root};
use crate::scene::{Random, bezier, brep, changed, circle, interval, line, plane};
use feeler::brep::{Brep, TrimCurve};
use feeler::numeric::Enclosure;
use feeler::nurbs::{Arc, Curve2, NurbsCurve, PolyCurve};
use feeler::trim::trim_split;
use feeler_oracle::{
    AxisRootsTruth, DerivativeRootsTruth, Oracle, TruthEnclosure, eigen_candidates, second,
};
use nalgebra::{Point2, Vector2, Vector3};
use std::time::Instant;

fn overlap(a: &TruthEnclosure, b: &TruthEnclosure) -> bool {
    a.lo <= b.hi && b.lo <= a.hi
}

/// Whether two truths can both be true.
fn agree(a: &DerivativeRootsTruth, b: &DerivativeRootsTruth) -> bool {
    (0..2).all(|axis| {
        let (a, b) = (&a.axes[axis], &b.axes[axis]);
        a.roots.len() == b.roots.len()
            && a.constant.len() == b.constant.len()
            && a.roots.iter().zip(&b.roots).all(|(a, b)| {
                overlap(&a.t, &b.t)
                    && (a.multiplicity, a.sign, a.cusp) == (b.multiplicity, b.sign, b.cusp)
            })
            && a.constant
                .iter()
                .zip(&b.constant)
                .all(|(a, b)| overlap(&a[0], &b[0]) && overlap(&a[1], &b[1]))
    })
}

/// How many roots have a bracket of their own; each bracket must have a root of odd multiplicity of its own.
fn bracketed(truth: &AxisRootsTruth, brackets: &[TruthEnclosure]) -> usize {
    let mut roots = truth
        .roots
        .iter()
        .filter(|r| r.multiplicity.iter().any(|m| m % 2 == 1));
    for b in brackets {
        assert!(
            roots.any(|r| overlap(&r.t, b)),
            "no root in {b:?}: {truth:?}"
        );
    }
    brackets.len()
}

/// Times of the two methods in microseconds, and roots found.
#[derive(Default)]
struct Times {
    first: Vec<f64>,
    second: Vec<f64>,
    roots: usize,
    /// Those found from Eigen's eigenvalues.
    bracketed: usize,
}

impl Times {
    fn print(&mut self, what: &str) {
        for t in [&mut self.first, &mut self.second] {
            t.sort_by(f64::total_cmp);
        }
        let at = |t: &[f64], part: f64| t[((t.len() - 1) as f64 * part) as usize];
        println!(
            "{what}: {} queries, {} roots ({} from eigenvalues); first {:.0} us (p99 {:.0}), second {:.0} us (p99 {:.0})",
            self.first.len(),
            self.roots,
            self.bracketed,
            at(&self.first, 0.5),
            at(&self.first, 0.99),
            at(&self.second, 0.5),
            at(&self.second, 0.99),
        );
    }
}

/// The kernel's own: the same places, each within its bounds, which are a few ulp wide.
fn check_kernel(trim: &TrimCurve, curve: &Curve2, truth: &DerivativeRootsTruth) {
    let found = trim_split(trim, curve).unwrap();
    let size = trim.span.end - trim.span.start;
    for (claim, truth) in found.iter().zip(&truth.axes) {
        let context = || format!("{trim:?} {curve:?}\n{claim:?}\n{truth:?}");
        assert_eq!(claim.places.len(), truth.roots.len(), "{}", context());
        assert_eq!(claim.constant.len(), truth.constant.len(), "{}", context());
        let holds = |e: &Enclosure, t: &TruthEnclosure| {
            scene::dyadic(e.lo) <= t.lo && t.hi <= scene::dyadic(e.hi)
        };
        for (c, t) in claim.places.iter().zip(&truth.roots) {
            assert_eq!(
                (c.multiplicity, c.sign),
                (t.multiplicity, t.sign),
                "{}",
                context()
            );
            assert!(
                holds(&c.bounds, &t.t) && c.bounds.contains(c.t),
                "{}",
                context()
            );
            let ulp = c.t.abs().max(size).next_up() - c.t.abs().max(size);
            assert!(c.bounds.width() <= 8.0 * ulp, "{}", context());
        }
        for (c, t) in claim.constant.iter().zip(&truth.constant) {
            assert!(holds(&c[0], &t[0]) && holds(&c[1], &t[1]), "{}", context());
        }
    }
}

fn check_roots(breps: &[&Brep], times: &mut Times) {
    let o = Oracle::new(breps).unwrap();
    let mut face = 0;
    for b in breps {
        for f in b.faces() {
            for (l, index) in f.loops.iter().flatten().enumerate() {
                for t in 0..b.parts().loops[*index].trims.len() {
                    let start = Instant::now();
                    let first = o.derivative_roots(face, l, t).unwrap();
                    times.first.push(start.elapsed().as_secs_f64() * 1e6);
                    let start = Instant::now();
                    let other = second::derivative_roots(breps, face, l, t).unwrap();
                    times.second.push(start.elapsed().as_secs_f64() * 1e6);
                    times.roots += first.axes.iter().map(|a| a.roots.len()).sum::<usize>();
                    let brackets = second::root_brackets(breps, [face, l, t], &eigen_candidates);
                    for (truth, found) in first.axes.iter().zip(&brackets.unwrap()) {
                        times.bracketed += bracketed(truth, found);
                    }
                    let curve =
                        &b.parts().curves2[b.parts().trims[b.parts().loops[*index].trims[t]].curve];
                    let trim = &b.parts().trims[b.parts().loops[*index].trims[t]];
                    check_kernel(trim, curve, &first);
                    assert!(
                        agree(&first, &other),
                        "face {face} loop {l} trim {t}: {curve:?}\n{first:?}\n{other:?}"
                    );
                }
            }
            face += 1;
        }
    }
}

const PARTS: [&str; 9] = [
    "ball_joint_cavity_nurbs",
    "ball_joint_socket_nurbs",
    "cube_corner_cut_nurbs",
    "cube_corner_sphere_cut_nurbs",
    "cylinder_nurbs",
    "cylinder_nurbs_unclamped",
    "sheet_trimmed_nurbs",
    "shift_gate_straight_nurbs",
    "geneva4_wheel_nurbs",
];

fn part(name: &str) -> Vec<Brep> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../corpora/models/thesis")
        .join(format!("{name}.3dm"));
    let document = feeler_io::read_file(&path).unwrap();
    let breps = document.objects.into_iter().filter_map(|o| match o.kind {
        feeler_io::ObjectKind::Brep(b) => Some(b),
        _ => None,
    });
    breps.collect()
}

#[test]
fn derivative_roots_of_the_thesis_parts() {
    let mut times = Times::default();
    for name in PARTS {
        let breps = part(name);
        check_roots(&breps.iter().collect::<Vec<_>>(), &mut times);
    }
    times.print("thesis");
}

/// A random spline of this degree; knots are doubled at random, weights between 1 / w and w.
fn random_curve(g: &mut Random, degree: usize, spans: usize, w: f64) -> Curve2 {
    let mut knots = vec![0.0; degree + 1];
    let mut x = 0.0;
    for _ in 1..spans {
        x += g.range(0.001, 1.0);
        let times = 1 + (g.next() * degree as f64 * g.next()) as usize;
        knots.extend(vec![x; times.min(degree)]);
    }
    x += g.range(0.1, 1.0);
    knots.extend(vec![x; degree + 1]);
    let count = knots.len() - degree - 1;
    // Few distinct values: repeated points, level parts, cusps.
    let few = g.next() < 0.4;
    let mut coordinate = || {
        if few {
            (g.range(-2.0, 3.0)).floor()
        } else {
            g.range(-5.0, 5.0)
        }
    };
    let mut points: Vec<[f64; 2]> = (0..count).map(|_| [coordinate(), coordinate()]).collect();
    if g.next() < 0.2 {
        let k = (g.next() * (count - 1) as f64) as usize;
        points[k + 1] = points[k];
    }
    let points = points
        .iter()
        .map(|p| {
            let weight = w.powf(g.range(-1.0, 1.0));
            Vector3::new(p[0] * weight, p[1] * weight, weight)
        })
        .collect();
    Curve2::Nurbs(NurbsCurve::new(degree, points, knots).unwrap())
}

fn random_arc(g: &mut Random) -> Curve2 {
    let axes = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -2.0]];
    let x = if g.next() < 0.5 {
        axes[(g.next() * 4.0) as usize]
    } else {
        [g.range(-2.0, 2.0), g.range(-2.0, 2.0)]
    };
    let y = if g.next() < 0.5 {
        [-x[1], x[0]]
    } else {
        [x[1], -x[0]]
    };
    let a = match (g.next() * 4.0) as usize {
        0 => 0.0,
        1 => std::f64::consts::FRAC_PI_2 * (g.range(-4.0, 4.0)).floor(),
        _ => g.range(-7.0, 7.0),
    };
    let b = if g.next() < 0.3 {
        a + std::f64::consts::PI
    } else {
        a + g.range(0.001, 6.0)
    };
    Curve2::Arc(
        Arc::new(Arc {
            center: Point2::new(g.range(-1.0, 1.0), g.range(-1.0, 1.0)),
            x: x.into(),
            y: y.into(),
            z: Vector2::zeros(),
            radius: g.range(0.1, 3.0),
            angle: interval(a, b),
            domain: interval(0.0, g.range(0.1, 3.0)),
        })
        .unwrap(),
    )
}

/// A trim that uses a part of the curve, perhaps backwards.
fn some_part(g: &mut Random, c: &Curve2) -> Brep {
    let whole = brep(plane(1e3), Some(vec![vec![c.clone()]]));
    let d = c.domain();
    let cut = g.next() < 0.5;
    let reversed = g.next() < 0.5;
    changed(&whole, |p| {
        if cut {
            p.trims[0].span = interval(
                d.lerp(g.range(0.0, 0.4)).next_up(),
                d.lerp(g.range(0.5, 1.0)).next_down(),
            );
        }
        p.trims[0].reversed = reversed;
    })
}

#[test]
fn derivative_roots_of_hostile_curves() {
    let mut g = Random(31);
    let mut times = Times::default();
    for i in 0..120 {
        let degree = 1 + (g.next() * g.next() * 9.0) as usize;
        let w = [1.0, 3.0, 1e6, 1e12][i % 4];
        let c = random_curve(&mut g, degree, 1 + i % 5, w);
        check_roots(&[&some_part(&mut g, &c)], &mut times);
    }
    times.print("random, degree to 9");
    let mut times = Times::default();
    for w in [1.0, 1e12] {
        let c = random_curve(&mut g, 25, 1, w);
        check_roots(&[&some_part(&mut g, &c)], &mut times);
    }
    let t = chebyshev(25);
    let back: Vec<f64> = t.iter().rev().copied().collect();
    check_roots(&[&some_part(&mut g, &curve(&t, &back))], &mut times);
    check_roots(
        &[&some_part(&mut g, &reweighted(&t, &back, 2.0))],
        &mut times,
    );
    times.print("degree 25");
    let mut times = Times::default();
    for _ in 0..60 {
        let c = random_arc(&mut g);
        check_roots(&[&some_part(&mut g, &c)], &mut times);
    }
    times.print("arcs");
    let mut times = Times::default();
    let many = [
        root(1, 3),
        root(1, 3),
        root(1, 3),
        root(1, 2),
        root(1, 2),
        root(5, 7),
    ];
    let cubic = graph(&[root(1, 4), root(1, 2), root(3, 4)]);
    let mixed = PolyCurve::new(
        vec![
            cubic.clone(),
            random_arc(&mut g),
            line([0.0, 1.0], [3.0, 1.0]),
            cubic,
        ],
        vec![0.0, 0.7, 1.3, 2.0, 7.0],
    );
    for c in [
        graph(&many),
        Curve2::Poly(mixed.unwrap()),
        bezier(&[[1.0, 2.0, 1.0], [1.0, 2.0, 1.0], [1.0, 2.0, 1.0]]),
        bezier(&[
            [0.0, 0.0, 1.0],
            [2.0, 0.0, 2.0],
            [0.0, 0.0, 3.0],
            [3.0, 0.0, 1.0],
        ]),
        curve(&[0.0, -1.0, -1.0, 0.0], &[0.0, 1.0, -1.0, 3.0]),
        curve(&[0.0, -1.0, -1.0, 0.0], &[0.0, 1.0, -1.0, 0.0]),
        circle(2.0).swap_remove(1),
    ] {
        for _ in 0..3 {
            check_roots(&[&some_part(&mut g, &c)], &mut times);
        }
    }
    times.print("special");
}

/// Eigen's candidates against roots that are known, and against a truth from which a root is left out.
#[test]
fn candidates_of_eigen_find_what_was_missed() {
    let factors: Vec<_> = (1..=6).map(|k| root(k, 7)).collect();
    let b = brep(plane(1e9), Some(vec![vec![graph(&factors)]]));
    let brackets = second::root_brackets(&[&b], [0; 3], &eigen_candidates).unwrap();
    assert!(brackets[0].is_empty());
    assert_eq!(brackets[1].len(), 6);
    for (k, e) in brackets[1].iter().enumerate() {
        let x = (k + 1) as f64 / 7.0;
        assert!(e.lo <= scene::dyadic(x.next_up()) && scene::dyadic(x.next_down()) <= e.hi);
        assert!(e.width().approximate() < 1e-10, "{e:?}");
    }
    let o = Oracle::new(&[&b]).unwrap();
    let mut truth = o.derivative_roots(0, 0, 0).unwrap().axes[1].clone();
    assert_eq!(bracketed(&truth, &brackets[1]), 6);
    truth.roots.remove(3);
    let missed = std::panic::catch_unwind(|| bracketed(&truth, &brackets[1]));
    assert!(missed.is_err());
    // What is no candidate gives no bracket.
    let wrong = second::root_brackets(&[&b], [0; 3], &|_| Ok(vec![0.2, 0.21])).unwrap();
    assert!(wrong.iter().all(Vec::is_empty), "{wrong:?}");
}

#[test]
fn eigenvalues_isolate_most_roots() {
    let mut g = Random(5);
    let mut counts = [0; 2];
    for i in 0..40 {
        let c = random_curve(&mut g, 2 + i % 8, 1, if i % 2 == 0 { 1.0 } else { 3.0 });
        let b = brep(plane(1e3), Some(vec![vec![c]]));
        let [all, simple] = second::isolated_by_candidates(&[&b], 0).unwrap();
        counts[0] += all;
        counts[1] += simple;
    }
    println!(
        "{} of {} roots isolated by eigenvalues alone",
        counts[1], counts[0]
    );
    assert!(counts[0] > 50 && counts[1] * 10 >= counts[0] * 9);
}

// ---- sides

/// Points of the domain: at random, at ends of trims and nearby, between ends, off them by an ulp.
fn points(g: &mut Random, b: &Brep, face: usize, count: usize) -> Vec<[f64; 2]> {
    let d = b.surface(face).domain();
    let mut ends = Vec::new();
    for l in b.faces()[face].loops.iter().flatten() {
        for t in &b.parts().loops[*l].trims {
            match &b.parts().curves2[b.parts().trims[*t].curve] {
                Curve2::Line(c) => ends.extend([c.from, c.to, c.from + 0.5 * (c.to - c.from)]),
                Curve2::Nurbs(c) => ends.extend(
                    c.control_points()
                        .iter()
                        .map(|p| Point2::new(p[0] / p[2], p[1] / p[2])),
                ),
                Curve2::Arc(c) => {
                    let r = c.radius;
                    ends.extend([
                        c.center,
                        c.center + Vector2::new(r, 0.0),
                        c.center - Vector2::new(0.0, r),
                    ]);
                }
                _ => {}
            }
        }
    }
    (0..count)
        .map(|i| {
            let random = [g.range(d[0].start, d[0].end), g.range(d[1].start, d[1].end)];
            if ends.is_empty() || i % 4 == 0 {
                return random;
            }
            let p = ends[(g.next() * ends.len() as f64) as usize];
            let q = ends[(g.next() * ends.len() as f64) as usize];
            match i % 4 {
                1 => [p.x, p.y],
                2 => [p.x, q.y],
                _ => [
                    p.x.next_up(),
                    if g.next() < 0.5 { p.y } else { p.y.next_down() },
                ],
            }
        })
        .collect()
}

fn check_sides(g: &mut Random, breps: &[&Brep], count: usize, times: &mut Times) {
    let o = Oracle::new(breps).unwrap();
    let mut face = 0;
    for b in breps {
        for local in 0..b.faces().len() {
            let region = second::TrimmedRegion::new(b, local).unwrap();
            for uv in points(g, b, local, count) {
                let start = Instant::now();
                let first = o.side(face, uv).unwrap();
                times.first.push(start.elapsed().as_secs_f64() * 1e6);
                let start = Instant::now();
                let other = region.side(uv).unwrap();
                times.second.push(start.elapsed().as_secs_f64() * 1e6);
                for found in [other, region.side_by_halving(uv).unwrap()] {
                    assert_eq!(
                        first,
                        found,
                        "face {face} at {uv:?}: {:?}",
                        b.parts().curves2
                    );
                }
                times.roots += usize::from(first.side == feeler::trim::Side::Boundary);
            }
            face += 1;
        }
    }
}

#[test]
fn sides_of_the_thesis_parts() {
    let mut g = Random(77);
    let mut times = Times::default();
    for name in PARTS {
        let breps = part(name);
        check_sides(&mut g, &breps.iter().collect::<Vec<_>>(), 12, &mut times);
    }
    times.print("sides, thesis (roots: on the boundary)");
    assert!(times.roots > 20);
}

#[test]
fn sides_of_hostile_loops() {
    let mut g = Random(13);
    let mut times = Times::default();
    for i in 0..60 {
        let w = [1.0, 3.0, 1e6, 1e12][i % 4];
        let curves = (0..1 + i % 3)
            .map(|_| {
                let degree = 1 + (g.next() * g.next() * 9.0) as usize;
                random_curve(&mut g, degree, 1 + i % 4, w)
            })
            .collect();
        let loops = vec![curves, circle(2.0)];
        check_sides(&mut g, &[&brep(plane(4.0), Some(loops))], 16, &mut times);
    }
    let high = vec![vec![
        random_curve(&mut g, 25, 1, 1e12),
        random_curve(&mut g, 25, 1, 1.0),
    ]];
    check_sides(&mut g, &[&brep(plane(6.0), Some(high))], 16, &mut times);
    // A cusp, a loop that crosses itself, a level loop without area, no loop, nothing.
    let cusp = curve(&[0.0, -1.0, -1.0, 0.0], &[0.0, 1.0, -1.0, 0.0]);
    let crossing = bezier(&[
        [0.0, 0.0, 1.0],
        [-3.0, 2.0, 1.0],
        [3.0, 2.0, 1.0],
        [0.0, -1.0, 1.0],
    ]);
    let flat = bezier(&[
        [0.0, 1.0, 1.0],
        [3.0, 1.0, 1.0],
        [1.0, 1.0, 1.0],
        [2.0, 1.0, 1.0],
    ]);
    for loops in [vec![vec![cusp], vec![crossing]], vec![vec![flat]], vec![]] {
        check_sides(&mut g, &[&brep(plane(4.0), Some(loops))], 40, &mut times);
    }
    check_sides(&mut g, &[&brep(plane(4.0), None)], 40, &mut times);
    times.print("sides, hostile (roots: on the boundary)");
}

// ---- evaluation

fn check_points(g: &mut Random, breps: &[&Brep], count: usize, times: &mut Times) {
    let o = Oracle::new(breps).unwrap();
    let mut face = 0;
    for b in breps {
        for local in 0..b.faces().len() {
            let d = b.surface(local).domain();
            for i in 0..count {
                let mut uv = [g.range(d[0].start, d[0].end), g.range(d[1].start, d[1].end)];
                if let feeler::nurbs::Surface::Nurbs(s) = b.surface(local)
                    && i % 3 == 0
                {
                    // At a knot, or the end of the domain.
                    let k = s.knots_u().knots();
                    uv[0] = k[(g.next() * k.len() as f64) as usize].clamp(d[0].start, d[0].end);
                    if i % 2 == 0 {
                        uv[1] = d[1].end;
                    }
                }
                let start = Instant::now();
                let first = o.evaluate(face, uv).unwrap();
                times.first.push(start.elapsed().as_secs_f64() * 1e6);
                let start = Instant::now();
                let other = second::evaluate(breps, face, uv).unwrap();
                times.second.push(start.elapsed().as_secs_f64() * 1e6);
                let pairs = [
                    (&first.point, &other.point),
                    (&first.du, &other.du),
                    (&first.dv, &other.dv),
                    (&first.second[0], &other.second[0]),
                    (&first.second[1], &other.second[1]),
                    (&first.second[2], &other.second[2]),
                ];
                for (a, b) in pairs {
                    assert!(
                        (0..3).all(|c| overlap(&a[c], &b[c])),
                        "face {face} {uv:?}\n{a:?}\n{b:?}"
                    );
                }
            }
            face += 1;
        }
    }
}

#[test]
fn evaluations() {
    let mut g = Random(3);
    let mut times = Times::default();
    for name in PARTS {
        let breps = part(name);
        check_points(&mut g, &breps.iter().collect::<Vec<_>>(), 6, &mut times);
    }
    times.print("points, thesis");
    let mut times = Times::default();
    for (p, q, w) in [(1, 2, 1.0), (5, 4, 1e12), (25, 3, 3.0), (2, 25, 1e12)] {
        let net = (0..(p + 1) * (q + 1))
            .map(|_| {
                let w: f64 = f64::powf(w, g.range(-1.0, 1.0));
                [
                    g.range(-3.0, 3.0) * w,
                    g.range(-3.0, 3.0) * w,
                    g.range(-3.0, 3.0) * w,
                    w,
                ]
            })
            .collect();
        check_points(
            &mut g,
            &[&brep(scene::patch(p, q, net), None)],
            6,
            &mut times,
        );
    }
    times.print("points, patches of degree to 25");
}

#[test]
fn sides_with_arcs() {
    let mut g = Random(99);
    let mut times = Times::default();
    for i in 0..40 {
        let mut curves = vec![random_arc(&mut g)];
        if i % 3 == 1 {
            curves.push(random_curve(&mut g, 3, 2, 2.0));
        } else if i % 3 == 2 {
            curves.push(random_arc(&mut g));
        }
        check_sides(
            &mut g,
            &[&brep(plane(4.0), Some(vec![curves]))],
            24,
            &mut times,
        );
    }
    times.print("sides, arcs (roots: on the boundary)");
}

#[test]
fn evaluations_of_native_surfaces() {
    use feeler::nurbs::{Arc, Curve3, Line, NurbsCurve3, Polyline, Revolution, Sum, Surface};
    use nalgebra::{Point3, Vector4};
    let mut g = Random(8);
    let mut times = Times::default();
    for i in 0..24 {
        let mut v = |s: f64| Vector3::new(g.range(-s, s), g.range(-s, s), g.range(-s, s));
        let (a, b, c, x, z, axis) = (v(2.0), v(2.0), v(2.0), v(1.0), v(1.0), v(3.0));
        let curves: [Curve3; 5] = [
            Curve3::Line(Line::new(a.into(), b.into(), interval(-1.0, 2.5)).unwrap()),
            Curve3::Polyline(
                Polyline::new(vec![a.into(), b.into(), c.into()], vec![0.0, 0.3, 2.0]).unwrap(),
            ),
            Curve3::Nurbs(
                NurbsCurve3::new(
                    2,
                    [a, b, c, a]
                        .iter()
                        .enumerate()
                        .map(|(i, p)| {
                            let w = 1.0 + i as f64;
                            Vector4::new(p.x * w, p.y * w, p.z * w, w)
                        })
                        .collect(),
                    vec![0.0, 0.0, 0.0, 0.4, 1.0, 1.0, 1.0],
                )
                .unwrap(),
            ),
            Curve3::Arc(
                Arc::new(Arc {
                    center: Point3::from(a),
                    x,
                    y: z.cross(&x),
                    z,
                    radius: 1.25,
                    angle: interval(-0.5, 4.0),
                    domain: interval(0.0, 1.7),
                })
                .unwrap(),
            ),
            Curve3::Arc(
                Arc::new(Arc {
                    center: Point3::from(b),
                    x: Vector3::x(),
                    y: Vector3::y(),
                    z: Vector3::z(),
                    radius: 0.5,
                    angle: interval(0.0, std::f64::consts::TAU),
                    domain: interval(0.0, std::f64::consts::TAU),
                })
                .unwrap(),
            ),
        ];
        let surface = if i % 3 == 0 {
            let (first, second) = (curves[i % 5].clone(), curves[(i / 3) % 5].clone());
            Surface::Sum(Sum {
                base: c,
                first,
                second,
            })
        } else {
            Surface::Revolution(
                Revolution::new(Revolution {
                    origin: Point3::from(c),
                    axis,
                    angle: interval(-1.0, 2.0 + i as f64 / 8.0),
                    angle_domain: interval(0.0, 1.0),
                    profile: curves[i % 5].clone(),
                    transposed: i % 2 == 0,
                })
                .unwrap(),
            )
        };
        check_points(&mut g, &[&brep(surface, None)], 6, &mut times);
    }
    times.print("points, native surfaces");
}
