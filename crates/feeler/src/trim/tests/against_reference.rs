//! Sides against the reference: shapes that are hard, points that are close.

use super::reference::Reference;
use super::shapes::*;
use crate::brep::Brep;
use crate::trim::{BoxSide, Side, TrimRegion};

const WIDE: [f64; 4] = [-10.0, 10.0, -10.0, 10.0];

/// A generator of our own: the same points on every platform.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
    fn within(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }
    fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }
}

fn steps(x: f64, n: i32) -> f64 {
    (0..n.abs()).fold(x, |x, _| if n > 0 { x.next_up() } else { x.next_down() })
}

/// Points to ask: random ones, control points' coordinates combined, points near the boundary within
/// a few ulps.
fn queries(region: &TrimRegion, brep: &Brep, random: &mut Random, count: usize) -> Vec<[f64; 2]> {
    let mut out = Vec::new();
    let mut us = Vec::new();
    let mut vs = Vec::new();
    for c in &brep.parts().curves2 {
        if let crate::nurbs::Curve::Nurbs(n) = c {
            for p in n.control_points() {
                us.push(p[0] / p[2]);
                vs.push(p[1] / p[2]);
            }
        }
    }
    for p in region.pieces() {
        let points = p.control_points();
        for c in [points.first(), points.last()].into_iter().flatten() {
            us.push(c[0] / c[2]);
            vs.push(c[1] / c[2]);
        }
        us.extend(p.hull[0]);
        vs.extend(p.hull[1]);
    }
    for _ in 0..count {
        let n = region.pieces().len();
        let p = region.piece(random.below(n));
        // A point of the piece by de Casteljau.
        let t = match random.below(4) {
            0 => random.below(9) as f64 / 8.0,
            _ => random.unit(),
        };
        let mut d = p.control_points();
        while d.len() > 1 {
            d = d
                .windows(2)
                .map(|w| [0, 1, 2].map(|i| w[0][i] * (1.0 - t) + w[1][i] * t))
                .collect();
        }
        let near = [d[0][0] / d[0][2], d[0][1] / d[0][2]];
        let nudge = |x: f64, random: &mut Random| match random.below(3) {
            0 => steps(x, random.below(9) as i32 - 4),
            1 => x + random.within(-1e-12, 1e-12),
            _ => x + random.within(-0.1, 0.1),
        };
        let q = match random.below(4) {
            0 => [
                random.within(p.hull[0][0], p.hull[0][1]),
                random.within(p.hull[1][0], p.hull[1][1]),
            ],
            1 => [us[random.below(us.len())], vs[random.below(vs.len())]],
            _ => [nudge(near[0], random), nudge(near[1], random)],
        };
        out.push(q);
    }
    out
}

fn swapped(brep: &Brep) -> Brep {
    use crate::nurbs::{Curve, NurbsCurve};
    let mut parts = brep.parts().clone();
    for c in &mut parts.curves2 {
        *c = match &*c {
            Curve::Line(l) => {
                let mut l = l.clone();
                (l.from.x, l.from.y) = (l.from.y, l.from.x);
                (l.to.x, l.to.y) = (l.to.y, l.to.x);
                Curve::Line(l)
            }
            Curve::Nurbs(n) => Curve::Nurbs(
                NurbsCurve::new(
                    n.degree(),
                    n.control_points()
                        .iter()
                        .map(|p| [p[1], p[0], p[2]].into())
                        .collect(),
                    n.knots().knots().to_vec(),
                )
                .unwrap(),
            ),
            other => other.clone(),
        };
    }
    for s in &mut parts.surfaces {
        if let crate::nurbs::Surface::Plane(p) = s {
            p.domain.swap(0, 1);
            p.extents.swap(0, 1);
        }
    }
    Brep::new(parts).unwrap()
}

fn reversed(brep: &Brep) -> Brep {
    let mut parts = brep.parts().clone();
    for l in &mut parts.loops {
        l.trims.reverse();
    }
    for t in &mut parts.trims {
        t.reversed = !t.reversed;
    }
    Brep::new(parts).unwrap()
}

fn negated(brep: &Brep) -> Brep {
    use crate::nurbs::{Curve, NurbsCurve};
    let mut parts = brep.parts().clone();
    for c in &mut parts.curves2 {
        *c = match &*c {
            Curve::Line(l) => {
                let mut l = l.clone();
                l.from = -l.from;
                l.to = -l.to;
                Curve::Line(l)
            }
            Curve::Nurbs(n) => Curve::Nurbs(
                NurbsCurve::new(
                    n.degree(),
                    n.control_points()
                        .iter()
                        .map(|p| [-p[0], -p[1], p[2]].into())
                        .collect(),
                    n.knots().knots().to_vec(),
                )
                .unwrap(),
            ),
            other => other.clone(),
        };
    }
    for s in &mut parts.surfaces {
        if let crate::nurbs::Surface::Plane(p) = s {
            for d in p.domain.iter_mut().chain(&mut p.extents) {
                (d.start, d.end) = (-d.end, -d.start);
            }
        }
    }
    Brep::new(parts).unwrap()
}

/// All points on all four ray directions against the reference; reversal changes nothing.
fn check(name: &str, brep: &Brep, seed: u64, count: usize) {
    let reference = Reference::new(brep);
    let region = TrimRegion::new(brep, 0);
    let (swap, back, minus) = (swapped(brep), reversed(brep), negated(brep));
    let others = [
        TrimRegion::new(&swap, 0),
        TrimRegion::new(&back, 0),
        TrimRegion::new(&minus, 0),
        TrimRegion::new(&swapped(&minus), 0),
    ];
    let mut random = Random(seed);
    let mut seen = [0usize; 3];
    for q in queries(&region, brep, &mut random, count) {
        let expected = reference.side(q);
        seen[expected as usize] += 1;
        let turned = [[q[1], q[0]], q, [-q[0], -q[1]], [-q[1], -q[0]]];
        let all = [
            region.side(q.into()).side,
            others[0].side(turned[0].into()).side,
            others[1].side(turned[1].into()).side,
            others[2].side(turned[2].into()).side,
            others[3].side(turned[3].into()).side,
        ];
        assert_eq!(
            all,
            [Some(expected); 5],
            "{name}: {q:?} = {:x?}",
            q.map(f64::to_bits)
        );
        // A box about the point never claims what its points deny.
        let h = 10f64.powi(-(random.below(12) as i32));
        let side = region.classify_box([q[0] - h, q[0] + h], [q[1] - h, q[1] + h]);
        match expected {
            Side::Inside => assert_ne!(side, BoxSide::Outside, "{name} {q:?} {h}"),
            Side::Outside if (0..2).all(|i| region.domain()[i].contains(q[i])) => {
                assert_ne!(side, BoxSide::Inside, "{name} {q:?} {h}");
            }
            Side::Outside => {}
            Side::Boundary => assert_ne!(side, BoxSide::Outside, "{name} {q:?} {h}"),
        }
    }
    assert!(seen[0] > 0 && seen[1] > 0, "{name}: {seen:?}");
}

fn closed(points: &[[f64; 3]], degree: usize) -> Vec<Use> {
    // A clamped spline whose last point is the first.
    let mut points = points.to_vec();
    points.push(points[0]);
    let n = points.len();
    let mut knots = vec![0.0; degree];
    knots.extend((0..=n - degree).map(|i| i as f64));
    knots.extend(vec![(n - degree) as f64; degree]);
    vec![nurbs(degree, &points, &knots).into()]
}

#[test]
fn polygons_with_vertices_on_the_ray() {
    let star = [
        [0.0, 3.0],
        [1.0, 1.0],
        [3.0, 1.0],
        [1.0, 0.0],
        [3.0, -1.0],
        [1.0, -1.0],
        [0.0, -3.0],
        [-1.0, -1.0],
        [-3.0, -1.0],
        [-1.0, 0.0],
        [-3.0, 1.0],
        [-1.0, 1.0],
    ];
    let brep = face(WIDE, Some(vec![polygon(&star)]));
    let (region, reference) = (TrimRegion::new(&brep, 0), Reference::new(&brep));
    for i in -7..=7 {
        for j in -7..=7 {
            let q = [f64::from(i) * 0.5, f64::from(j) * 0.5];
            assert_eq!(region.side(q.into()).side, Some(reference.side(q)), "{q:?}");
        }
    }
    check("star", &brep, 1, 300);
    // Repeated vertices, a slit, edges there and back.
    let slit = [
        [-4.0, -4.0],
        [0.0, -4.0],
        [0.0, 0.0],
        [0.0, -4.0],
        [4.0, -4.0],
        [4.0, -4.0],
        [4.0, 4.0],
        [-4.0, 4.0],
        [-6.0, 4.0],
        [-4.0, 4.0],
    ];
    check("slit", &face(WIDE, Some(vec![polygon(&slit)])), 2, 300);
}

#[test]
fn circles_islands_and_touching_loops() {
    let nested: Vec<_> = (1..=6).map(|k| circle([0.0, 0.0], f64::from(k))).collect();
    check("nested", &face(WIDE, Some(nested)), 3, 200);
    let touching = vec![
        circle([-1.0, 0.0], 1.0),
        circle([1.0, 0.0], 1.0),
        circle([0.0, 0.0], 2.0),
    ];
    check("touching", &face(WIDE, Some(touching)), 4, 200);
    let double = [circle([0.1, 0.3], 2.0), circle([0.1, 0.3], 2.0)]
        .into_iter()
        .flatten()
        .chain(circle([0.0, 0.5], 1.0))
        .collect();
    check("twice around", &face(WIDE, Some(vec![double])), 5, 200);
    check(
        "over the border",
        &face([-2.0, 2.0, -1.0, 1.0], Some(vec![circle([1.0, 0.5], 2.0)])),
        6,
        200,
    );
}

#[test]
fn splines_of_many_kinds() {
    let wave = [
        [-3.0, -2.0, 1.0],
        [-1.0, -5.0, 1.0],
        [4.0, -4.0, 1.0],
        [2.5, 1.0, 1.0],
        [5.0, 3.0, 1.0],
        [0.0, 2.0, 1.0],
        [-3.0, 6.0, 1.0],
        [-2.0, 0.0, 1.0],
    ];
    for degree in 2..=5 {
        check(
            "wave",
            &face(WIDE, Some(vec![closed(&wave, degree)])),
            degree as u64,
            120,
        );
    }
    let weighted: Vec<[f64; 3]> = wave
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let w = 10f64.powi([0, 3, -3, 6, -6, 0, 1, 0][i]);
            [p[0] * w, p[1] * w, w]
        })
        .collect();
    check(
        "weighted",
        &face(WIDE, Some(vec![closed(&weighted, 3)])),
        7,
        120,
    );
    let extreme: Vec<[f64; 3]> = wave
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let w = [1e12, 1e-12, 1.0][i % 3];
            [p[0] * w, p[1] * w, w]
        })
        .collect();
    check(
        "weights 1e±12",
        &face(WIDE, Some(vec![closed(&extreme, 2)])),
        8,
        120,
    );
    // Knots that are neither uniform nor clamped, a part of the domain, closed by a join.
    let knots = [-1.0, -0.3, 0.0, 0.1, 0.7, 1.1, 1.7, 2.0, 2.1, 3.0, 3.5, 4.0];
    let curve = nurbs(3, &wave, &knots);
    for (a, b) in [(0.1, 2.1), (0.3, 1.9), (1.2, 1.6)] {
        for reversed in [false, true] {
            let part = Use {
                curve: curve.clone(),
                span: Some([a, b]),
                reversed,
            };
            check("part", &face(WIDE, Some(vec![vec![part]])), 9, 80);
        }
    }
}

#[test]
fn cusps_inflections_and_self_intersections() {
    // (t², t³) about t = 1/2, closed by its chord.
    let cusp = bezier(&[
        [1.0, -1.0, 1.0],
        [-1.0 / 3.0, 1.0, 1.0],
        [-1.0 / 3.0, -1.0, 1.0],
        [1.0, 1.0, 1.0],
    ]);
    check(
        "near cusp",
        &face(WIDE, Some(vec![vec![cusp.into()]])),
        10,
        200,
    );
    // x = (2t - 1)², y = (2t - 1)³ exactly: Bernstein coefficients 1, -1/3.. times 3.
    let exact = bezier(&[
        [3.0, -3.0, 1.0],
        [-1.0, 3.0, 1.0],
        [-1.0, -3.0, 1.0],
        [3.0, 3.0, 1.0],
    ]);
    check("cusp", &face(WIDE, Some(vec![vec![exact.into()]])), 11, 200);
    let tip = face(
        WIDE,
        Some(vec![vec![
            bezier(&[
                [3.0, -3.0, 1.0],
                [-1.0, 3.0, 1.0],
                [-1.0, -3.0, 1.0],
                [3.0, 3.0, 1.0],
            ])
            .into(),
        ]]),
    );
    assert_eq!(
        TrimRegion::new(&tip, 0).side([0.0, 0.0].into()).side,
        Some(Side::Boundary)
    );
    // An inflection with a horizontal tangent: y' = 3 (2t - 1)².
    let inflection = vec![
        bezier(&[
            [-3.0, -3.0, 1.0],
            [-1.0, 3.0, 1.0],
            [1.0, -3.0, 1.0],
            [3.0, 3.0, 1.0],
        ])
        .into(),
        line([3.0, 3.0], [-3.0, 3.0]).into(),
        line([-3.0, 3.0], [-3.0, -3.0]).into(),
    ];
    check("inflection", &face(WIDE, Some(vec![inflection])), 12, 200);
    let s7 = bezier(&[
        [0.0, 0.0, 1.0],
        [-10.0, 10.0, 1.0],
        [10.0, 10.0, 1.0],
        [0.0, -5.0, 1.0],
    ]);
    check("loop", &face(WIDE, Some(vec![vec![s7.into()]])), 13, 200);
}

#[test]
fn gaps_and_overlaps() {
    let gap = |d: f64| {
        vec![
            line([-1.0, -1.0], [1.0, -1.0 + d]).into(),
            line([1.0, -1.0], [1.0 + d, 1.0]).into(),
            line([1.0, 1.0], [-1.0, 1.0 - d]).into(),
            line([-1.0, 1.0], [-1.0 - d, -1.0]).into(),
        ]
    };
    for d in [1e-7, -1e-7, 1e-16, 0.25] {
        let brep = face(WIDE, Some(vec![gap(d)]));
        check("gap", &brep, 14, 150);
        let region = TrimRegion::new(&brep, 0);
        assert!(region.side([1.0, -1.0].into()).in_gap);
        assert!(region.side([1.0, -1.0 + d / 2.0].into()).in_gap);
        assert!(!region.side([0.9, -1.0 + d / 2.0].into()).in_gap);
        assert!(!region.side([0.0, 0.0].into()).in_gap);
    }
    // Two curves only, each joined to the other by a long segment.
    let open = vec![
        bezier(&[[-2.0, -2.0, 1.0], [0.0, -4.0, 2.0], [2.0, -2.0, 1.0]]).into(),
        bezier(&[[1.5, 2.0, 1.0], [0.0, 4.0, 0.5], [-1.0, 2.0, 1.0]]).into(),
    ];
    check("open", &face(WIDE, Some(vec![open])), 15, 200);
    // Thirds: end points that are no f64.
    let thirds = vec![
        bezier(&[[1.0, 1.0, 3.0], [5.0, -4.0, 1.0], [2.0, 1.0, 3.0]]).into(),
        bezier(&[[2.0, 1.0, 3.0], [1.0, 5.0, 7.0], [1.0, 1.0, 3.0]]).into(),
    ];
    check("thirds", &face(WIDE, Some(vec![thirds])), 16, 200);
}

#[test]
fn degenerate_pieces() {
    // Points, axis-parallel splines that double back, a curve that is one point.
    let mut uses: Vec<Use> = vec![
        bezier(&[
            [-2.0, -2.0, 1.0],
            [3.0, -2.0, 1.0],
            [-1.0, -2.0, 1.0],
            [2.0, -2.0, 1.0],
        ])
        .into(),
        bezier(&[[2.0, -2.0, 1.0], [2.0, -2.0, 1.0], [2.0, -2.0, 1.0]]).into(),
        bezier(&[[2.0, -2.0, 1.0], [8.0, 4.0, 4.0], [2.0, 2.0, 1.0]]).into(),
        line([2.0, 2.0], [2.0, 2.0]).into(),
    ];
    uses.push(bezier(&[[2.0, 2.0, 1.0], [0.0, 2.0, 1.0], [-2.0, 2.0, 1.0]]).into());
    uses.push(line([-2.0, 2.0], [-2.0, -2.0]).into());
    check("doubling back", &face(WIDE, Some(vec![uses])), 17, 300);
    // Tiny and tall.
    let tiny = [[0.0, 0.0], [1e-300, 0.0], [1e-300, 1e-300], [0.0, 1e-300]];
    let brep = face(WIDE, Some(vec![polygon(&tiny)]));
    let region = TrimRegion::new(&brep, 0);
    assert_eq!(
        region.side([0.5e-300, 0.5e-300].into()).side,
        Some(Side::Inside)
    );
    assert_eq!(
        region.side([1e-300, 0.5e-300].into()).side,
        Some(Side::Boundary)
    );
    assert_eq!(
        region.side([1.1e-300, 0.5e-300].into()).side,
        Some(Side::Outside)
    );
    let flat = [[-1e6, 0.0], [1e6, 1e-6], [1e6, 3e-6], [-1e6, 2e-6]];
    let brep = face([-1e7, 1e7, -1.0, 1.0], Some(vec![polygon(&flat)]));
    check("anisotropic", &brep, 18, 300);
}

#[test]
fn high_degree() {
    // Degree 13, wild: coordinates from a fixed table.
    let mut random = Random(77);
    let points: Vec<[f64; 3]> = (0..14)
        .map(|_| {
            let w = random.within(0.5, 2.0);
            [
                random.within(-9.0, 9.0) * w,
                random.within(-9.0, 9.0) * w,
                w,
            ]
        })
        .collect();
    check(
        "degree 13",
        &face(WIDE, Some(vec![vec![bezier(&points).into()]])),
        19,
        12,
    );
    let points: Vec<[f64; 3]> = (0..26)
        .map(|_| [random.within(-9.0, 9.0), random.within(-9.0, 9.0), 1.0])
        .collect();
    check(
        "degree 25",
        &face(WIDE, Some(vec![vec![bezier(&points).into()]])),
        20,
        8,
    );
}
