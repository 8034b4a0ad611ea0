//! Lines, the side of a point and signed separations on native surfaces and arcs: against closed forms
//! in exact arithmetic, and against the second method.

use crate::scene::native::{arc_xz, arc3, circle2, line3, revolved};
use crate::scene::{Random, brep, dyadic as d, interval, model, plane, polygon, sq};
use feeler::brep::Brep;
use feeler::numeric::Dyadic;
use feeler::nurbs::{Curve3, Line, Plane, Sum, Surface};
use feeler::query::LineKind;
use feeler_oracle::second::{Second, SecondSide};
use feeler_oracle::{InsideTruth, LineTruth, Oracle, TruthEnclosure};
use nalgebra::{Point3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn oracle(b: &Brep) -> Oracle {
    Oracle::new(&[b]).unwrap()
}

fn vector(random: &mut Random, size: f64) -> [f64; 3] {
    [0; 3].map(|_| random.range(-size, size))
}

/// The point at t, exactly.
fn at(o: [f64; 3], v: [f64; 3], t: &Dyadic) -> [Dyadic; 3] {
    std::array::from_fn(|k| &d(o[k]) + &(t * &d(v[k])))
}

/// The sign of a form that is 0 on the surface changes within each hit, and the hits are as many as its
/// sign changes seen at many places (fewer only if two are hidden between these).
fn check(
    o: &Oracle,
    origin: [f64; 3],
    v: [f64; 3],
    form: &dyn Fn(&[Dyadic; 3]) -> Dyadic,
    counts: &dyn Fn(&[f64; 3]) -> bool,
) -> usize {
    let truth = o.line(origin, v, LineKind::Line).unwrap();
    let what = format!("{origin:?} {v:?} {truth:?}");
    assert!(truth.open.is_empty(), "{what}");
    for h in &truth.hits {
        assert!(h.transversal && h.multiplicity == Some(1), "{what}");
        let widest: Dyadic = "1p-150".parse().unwrap();
        assert!(h.t.width() <= widest, "{what}");
        let signs = [&h.t.lo, &h.t.hi].map(|t| form(&at(origin, v, t)).signum());
        assert!(signs[0] * signs[1] <= 0, "{what}");
        let p = at(origin, v, &h.t.lo).map(|x| x.approximate());
        assert!(counts(&p), "{what}");
    }
    // Steps of 1/64 of the direction.
    let mut seen = 0;
    let mut last = 0;
    for i in -1024..1024 {
        let t = d((f64::from(i) + 0.123) / 64.0);
        let p = at(origin, v, &t);
        let sign = form(&p).signum();
        if last * sign < 0 && counts(&p.map(|x| x.approximate())) {
            seen += 1;
        }
        last = sign;
    }
    assert!(
        truth.hits.len() >= seen && (truth.hits.len() - seen).is_multiple_of(2),
        "{seen} {what}"
    );
    seen
}

#[test]
fn hits_of_quadrics_and_tori() {
    let mut random = Random(11);
    let [r, big] = [2.5, 3.0];
    let sphere = |p: &[Dyadic; 3]| &(&(&sq(&p[0]) + &sq(&p[1])) + &sq(&p[2])) - &d(r * r);
    let cylinder = |p: &[Dyadic; 3]| &(&sq(&p[0]) + &sq(&p[1])) - &d(4.0);
    let cone = |p: &[Dyadic; 3]| &(&d(16.0) * &(&sq(&p[0]) + &sq(&p[1]))) - &(&d(9.0) * &sq(&p[2]));
    let torus = |p: &[Dyadic; 3]| {
        let s = &sq(&p[0]) + &sq(&p[1]);
        let k = &(&s + &sq(&p[2])) + &d(big * big - 1.25 * 1.25);
        &sq(&k) - &(&d(4.0 * big * big) * &s)
    };
    let half = [-FRAC_PI_2, FRAC_PI_2];
    // A cylinder as a sum, with an axis that is not normalised.
    let sum = Surface::Sum(Sum {
        base: Vector3::new(0.0, 0.0, -8.0),
        first: arc3([0.0; 3], [0.0, 0.0, 7.0], 2.0, [-1.0, TAU - 1.0]),
        second: line3([0.0; 3], [0.0, 0.0, 16.0]),
    });
    type Form<'a> = &'a dyn Fn(&[Dyadic; 3]) -> Dyadic;
    type Part<'a> = &'a dyn Fn(&[f64; 3]) -> bool;
    let everywhere = |_: &[f64; 3]| true;
    let high = |p: &[f64; 3]| p[2].abs() < 8.0;
    let above = |p: &[f64; 3]| p[2] > 0.0 && p[2] < 8.0;
    let cases: [(Surface, Form, Part); 6] = [
        (
            revolved(arc_xz([0.0, 0.0, 0.0], r, half), [0.0, TAU], false),
            &sphere,
            &everywhere,
        ),
        (
            revolved(line3([2.0, 0.0, -8.0], [2.0, 0.0, 8.0]), [-PI, PI], true),
            &cylinder,
            &high,
        ),
        (sum, &cylinder, &high),
        (
            revolved(line3([0.0; 3], [6.0, 0.0, 8.0]), [0.0, TAU], false),
            &cone,
            &above,
        ),
        (
            revolved(arc_xz([big, 0.0, 0.0], 1.25, [0.0, TAU]), [0.0, TAU], false),
            &torus,
            &everywhere,
        ),
        (
            revolved(
                arc_xz([big, 0.0, 0.0], 1.25, [0.5, 0.5 + TAU]),
                [1.0, 1.0 + TAU],
                true,
            ),
            &torus,
            &everywhere,
        ),
    ];
    for (surface, form, counts) in cases {
        let o = oracle(&brep(surface, None));
        let mut met = 0;
        for _ in 0..20 {
            let (p, v) = (vector(&mut random, 2.0), vector(&mut random, 1.0));
            met += check(&o, p, v, form, counts);
        }
        assert!(met >= 8, "{met}");
    }
}

#[test]
fn cuts_seams_and_poles_count_once() {
    let sphere = revolved(
        arc_xz([0.0, 0.0, 0.0], 2.5, [-FRAC_PI_2, FRAC_PI_2]),
        [0.0, TAU],
        false,
    );
    let o = oracle(&brep(sphere, None));
    // The seam's half-plane y = 0, x > 0, at (2, 0, 1.5): exactly on the border, and on the other side
    // within.
    let t = o
        .line([0.0, 0.0, 1.5], [1.0, 0.0, 0.0], LineKind::Line)
        .unwrap();
    assert!(t.open.is_empty() && t.hits.len() == 2, "{t:?}");
    assert!(
        t.hits[0].t.contains(&d(-2.0)) && t.hits[1].t.contains(&d(2.0)),
        "{t:?}"
    );
    assert!(!t.hits[0].boundary && t.hits[1].boundary, "{t:?}");
    // A pole of the sphere is cut off by the rounding of pi / 2: a line along the axis meets nothing.
    let t = o.line([0.0; 3], [0.0, 0.0, 1.0], LineKind::Line).unwrap();
    assert!(t.open.is_empty() && t.hits.is_empty(), "{t:?}");
    // The tip of a cone is its own: one hit, on whichever of its patches.
    let cone = revolved(line3([0.0; 3], [6.0, 0.0, 8.0]), [0.0, TAU], false);
    let o = oracle(&brep(cone, None));
    let t = o
        .line([-1.0, -2.0, -3.0], [1.0, 2.0, 3.0], LineKind::Ray)
        .unwrap();
    assert!(t.open.is_empty() && t.hits.len() == 1, "{t:?}");
    assert!(t.hits[0].boundary && t.hits[0].t.contains(&d(1.0)), "{t:?}");
    let t = o
        .line([-3.0, -2.0, -1.0], [3.0, 2.0, 1.0], LineKind::Line)
        .unwrap();
    assert!(t.open.is_empty() && t.hits.len() == 1, "{t:?}");
    // A ruling lies in the face: not claimed to be anything.
    let t = o.line([0.0; 3], [3.0, 0.0, 4.0], LineKind::Line).unwrap();
    assert!(
        t.hits.iter().all(|h| h.boundary) && !t.open.is_empty(),
        "{t:?}"
    );
    // Many lines through the cuts of turns, wherever these are: in any direction from the centre two hits.
    let sphere = revolved(
        arc_xz([0.0, 0.0, 0.0], 2.0, [-FRAC_PI_2, FRAC_PI_2]),
        [0.0, TAU],
        false,
    );
    let o = oracle(&brep(sphere, None));
    let mut random = Random(12);
    for _ in 0..60 {
        let mut v = vector(&mut random, 1.0);
        v[1] += 0.01f64.copysign(v[1]);
        let t = o.line([0.0; 3], v, LineKind::Line).unwrap();
        assert!(t.open.is_empty() && t.hits.len() == 2, "{v:?} {t:?}");
    }
}

#[test]
fn window_in_a_cylinder() {
    // Trimmed by a circle of uv around (1, 3): azimuth and height.
    let profile = Curve3::Line(
        Line::new(
            Point3::new(2.0, 0.0, 0.0),
            Point3::new(2.0, 0.0, 8.0),
            interval(0.0, 8.0),
        )
        .unwrap(),
    );
    let o = oracle(&brep(
        revolved(profile, [0.0, TAU], false),
        Some(vec![vec![circle2([1.0, 3.0], 0.5, [0.3, 0.3 + TAU])]]),
    ));
    let mut random = Random(13);
    let mut met = 0;
    for _ in 0..40 {
        let (u, z) = (1.0 + random.range(-0.6, 0.6), 3.0 + random.range(-0.6, 0.6));
        let t = o
            .line(
                [0.0, 0.0, z],
                [f64::cos(u), f64::sin(u), 0.0],
                LineKind::Ray,
            )
            .unwrap();
        let within = (u - 1.0).hypot(z - 3.0) < 0.5;
        assert!(
            t.open.is_empty() && t.hits.len() == usize::from(within),
            "{u} {z} {t:?}"
        );
        met += t.hits.len();
    }
    assert!(met > 10);
}

/// Tangents of a sphere, a cylinder, a cone and an oblique sum, exactly and 2^-40 beside.
#[test]
fn tangents_of_quadrics() {
    let half = [-FRAC_PI_2, FRAC_PI_2];
    let sphere = revolved(arc_xz([0.0, 0.0, 0.0], 2.5, half), [0.0, TAU], false);
    let cylinder = revolved(line3([2.0, 0.0, -8.0], [2.0, 0.0, 8.0]), [-PI, PI], true);
    // Half-angle with tangent 3/4; its tangent plane at (3, 0, 4) has the normal (4, 0, -3).
    let cone = revolved(line3([0.0; 3], [6.0, 0.0, 8.0]), [-1.0, TAU - 1.0], false);
    // A circle of radius 5 about z, pulled along (1, 0, 2).
    let sum = Surface::Sum(Sum {
        base: Vector3::new(0.0, 0.0, -1.0),
        first: line3([0.0; 3], [1.0, 0.0, 2.0]),
        second: arc3([0.0; 3], [0.0, 0.0, 1.0], 5.0, [0.0, TAU]),
    });
    // Point, direction and normal.
    for (surface, x, v, n) in [
        (&sphere, [-1.5, 2.0, 0.0], [4.0, 3.0, 1.0], [-1.5, 2.0, 0.0]),
        (&sphere, [0.0, 1.5, -2.0], [1.0, 4.0, 3.0], [0.0, 1.5, -2.0]),
        (&sphere, [2.5, 0.0, 0.0], [0.0, 1.0, 0.25], [1.0, 0.0, 0.0]),
        (&cylinder, [0.0, 2.0, 1.0], [1.0, 0.0, 3.0], [0.0, 1.0, 0.0]),
        (&cylinder, [2.0, 0.0, 7.5], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]),
        (&cone, [3.0, 0.0, 4.0], [0.0, 1.0, 0.0], [4.0, 0.0, -3.0]),
        (&cone, [3.0, 0.0, 4.0], [3.0, 2.0, 4.0], [4.0, 0.0, -3.0]),
        // At half of the way: about (1/2, 0, 0), at (3, 4).
        (&sum, [3.5, 4.0, 0.0], [4.0, -3.0, 0.0], [3.0, 4.0, -1.5]),
    ] {
        let o = oracle(&brep(surface.clone(), None));
        let start = [0, 1, 2].map(|k| x[k] - 2.0 * v[k]);
        let t = o.line(start, v, LineKind::Segment).unwrap();
        assert!(t.open.is_empty() && t.hits.is_empty(), "{x:?} {t:?}");
        let t = o.line(start, v, LineKind::Ray).unwrap();
        assert!(t.open.is_empty() && t.hits.len() == 1, "{x:?} {t:?}");
        let h = &t.hits[0];
        assert!(
            h.tangential && !h.transversal && h.multiplicity == Some(2),
            "{t:?}"
        );
        assert_eq!((&h.t.lo, &h.t.hi), (&d(2.0), &d(2.0)));
        assert_eq!(t.crossings, Some(0), "{t:?}");
        // Beside it: none without, two within.
        for e in [(-40f64).exp2(), -(-40f64).exp2()] {
            let beside = [0, 1, 2].map(|k| start[k] + e * n[k]);
            let t = o.line(beside, v, LineKind::Line).unwrap();
            let expected = if e > 0.0 { 0 } else { 2 };
            assert!(
                t.open.is_empty() && t.hits.len() == expected,
                "{x:?} {e} {t:?}"
            );
        }
    }
    // Of the quadric, but beyond the face.
    let o = oracle(&brep(cylinder, None));
    let t = o
        .line([2.0, 0.0, 8.5], [0.0, 1.0, 0.0], LineKind::Line)
        .unwrap();
    assert!(t.open.is_empty() && t.hits.is_empty(), "{t:?}");
}

fn runs(t: &LineTruth) -> Vec<[TruthEnclosure; 2]> {
    assert!(t.open.is_empty(), "{t:?}");
    let end = |h: &feeler_oracle::LineHitTruth| h.t_end.clone().unwrap_or_else(|| h.t.clone());
    t.hits.iter().map(|h| [h.t.clone(), end(h)]).collect()
}

/// y = 3/10 and so on in a disc about (1/2, 0): where the circle is, exactly.
#[test]
fn lines_in_the_plane_of_a_disc() {
    let (c, r) = (0.5, 1.5);
    for arcs in [
        vec![circle2([c, 0.0], r, [0.0, TAU])],
        vec![circle2([c, 0.0], r, [2.0, 2.0 + TAU])],
        vec![
            circle2([c, 0.0], r, [0.7, 3.0]),
            circle2([c, 0.0], r, [3.0, 0.7 + TAU]),
        ],
    ] {
        let o = oracle(&brep(plane(4.0), Some(vec![arcs])));
        let mut random = Random(14);
        let form = |p: &[Dyadic; 3]| &(&sq(&(&p[0] - &d(c))) + &sq(&p[1])) - &d(r * r);
        for i in 0..40 {
            let (p, mut v) = (vector(&mut random, 1.0), vector(&mut random, 1.0));
            let p = [c + p[0], p[1], 0.0];
            v[2] = 0.0;
            let v = if i % 4 == 0 { [0.0, v[1], 0.0] } else { v };
            let t = o.line(p, v, LineKind::Line).unwrap();
            let found = runs(&t);
            assert_eq!(found.len(), 1, "{p:?} {v:?} {t:?}");
            assert_eq!(t.crossings, None);
            for e in &found[0] {
                let signs = [&e.lo, &e.hi].map(|x| form(&at(p, v, x)).signum());
                assert!(signs[0] * signs[1] <= 0 && e.width() <= "1p-150".parse().unwrap());
            }
        }
        // Through the centre along x, where an arc starts; touching at the top; past it.
        let t = o
            .line([c, 0.0, 0.0], [1.0, 0.0, 0.0], LineKind::Line)
            .unwrap();
        let [a, b] = runs(&t)[0].clone();
        assert!(a.contains(&d(-r)), "{t:?}");
        // At [2, 2 + 2 pi] or so nothing is at the angle 0.
        assert!(b.contains(&d(r)), "{t:?}");
        let t = o
            .line([c, r, 0.0], [1.0, 0.0, 0.0], LineKind::Line)
            .unwrap();
        let found = runs(&t);
        assert!(
            found.len() == 1 && t.hits[0].t_end.is_none() && t.hits[0].boundary,
            "{t:?}"
        );
        assert!(found[0][0].contains(&Dyadic::ZERO));
        let t = o
            .line([c, r + 1e-300, 0.0], [1.0, 0.0, 0.0], LineKind::Line)
            .unwrap();
        assert!(runs(&t).len() <= 1);
        let t = o
            .line([c, 1.5000001, 0.0], [1.0, 0.0, 0.0], LineKind::Line)
            .unwrap();
        assert!(runs(&t).is_empty(), "{t:?}");
    }
}

/// A half disc between an arc and its chord, a square with a round hole, a tilted frame.
#[test]
fn chords_and_holes() {
    // Above the chord from angle 0.25 to 0.25 + 3: a line of a large slope crosses both.
    let (a0, a1) = (0.25f64, 3.25f64);
    let o = oracle(&brep(
        plane(4.0),
        Some(vec![vec![circle2([0.0; 2], 1.0, [a0, a1])]]),
    ));
    for x in [-0.5, 0.0, 0.3] {
        let t = o
            .line([x, 0.0, 0.0], [0.0, 1.0, 0.0], LineKind::Line)
            .unwrap();
        let found = runs(&t);
        assert_eq!(found.len(), 1, "{t:?}");
        let s = (x - a0.cos()) / (a1.cos() - a0.cos());
        let chord = a0.sin() + s * (a1.sin() - a0.sin());
        assert!(
            (found[0][0].lo.approximate() - chord).abs() < 1e-14,
            "{t:?}"
        );
        assert!(
            (found[0][1].lo.approximate() - (1.0 - x * x).sqrt()).abs() < 1e-14,
            "{t:?}"
        );
    }
    // Below the chord the circle is no border.
    let t = o
        .line([0.0, -0.5, 0.0], [1.0, 0.0, 0.0], LineKind::Line)
        .unwrap();
    assert!(runs(&t).is_empty(), "{t:?}");
    let square = polygon(&[[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]]);
    let o = oracle(&brep(
        plane(4.0),
        Some(vec![square, vec![circle2([0.0; 2], 1.0, [0.0, TAU])]]),
    ));
    let t = o
        .line([-3.0, 0.6, 0.0], [1.0, 0.0, 0.0], LineKind::Line)
        .unwrap();
    let found = runs(&t);
    assert_eq!(found.len(), 2, "{t:?}");
    let root = (1.0 - 0.6f64 * 0.6).sqrt();
    let ends: Vec<f64> = found.iter().flatten().map(|e| e.lo.approximate()).collect();
    for (e, expected) in ends.iter().zip([1.0, 3.0 - root, 3.0 + root, 5.0]) {
        assert!((e - expected).abs() < 1e-14, "{ends:?}");
    }
    // A tilted plane with another scale: (3, 4, 0) / 5 is x.
    let o = oracle(&brep(
        Surface::Plane(
            Plane::new(Plane {
                origin: Point3::new(1.0, 2.0, 3.0),
                x: Vector3::new(3.0, 4.0, 0.0),
                y: Vector3::new(0.0, 0.0, 5.0),
                domain: [interval(-4.0, 4.0); 2],
                extents: [interval(-4.0, 4.0); 2],
            })
            .unwrap(),
        ),
        Some(vec![vec![circle2([0.0; 2], 1.0, [0.0, TAU])]]),
    ));
    let t = o
        .line([1.0, 2.0, 6.0], [3.0, 4.0, 0.0], LineKind::Line)
        .unwrap();
    let found = runs(&t);
    // v = 3/5, so u from -4/5 to 4/5.
    let fifth = |e: &TruthEnclosure| [&(&d(5.0) * &e.lo) - &d(4.0), &(&d(5.0) * &e.hi) - &d(4.0)];
    let [lo, hi] = fifth(&found[0][1]);
    assert!(lo.signum() <= 0 && hi.signum() >= 0, "{t:?}");
}

const PARTS: [&str; 6] = [
    "ball",
    "ball_joint_cavity",
    "ball_joint_socket",
    "cylinder",
    "cube_corner_sphere_cut",
    "geneva4_driver",
];

/// Sides and hits of the thesis's native parts by both methods.
#[test]
fn thesis_parts_by_both_methods() {
    for name in PARTS {
        let Some(breps) = model(&format!("thesis/3dm/{name}.3dm")) else {
            return;
        };
        let breps: Vec<&Brep> = breps.iter().collect();
        let o = Oracle::new(&breps).unwrap();
        let second = Second::new(&breps);
        // The vertices' box; a ball has none but its poles.
        let vertices = &breps[0].parts().vertices;
        let box_of = |k: usize| {
            let x = || vertices.iter().map(|v| v.point[k]);
            let (lo, hi) = (
                x().fold(f64::INFINITY, f64::min),
                x().fold(-f64::INFINITY, f64::max),
            );
            if hi - lo < 0.1 {
                [lo - 1.5, hi + 1.5]
            } else {
                [lo - 0.1 * (hi - lo), hi + 0.1 * (hi - lo)]
            }
        };
        let mut random = Random(15);
        let (mut sides, mut hits) = ([0; 3], 0);
        for _ in 0..8 {
            let p = [0, 1, 2].map(|k| random.range(box_of(k)[0], box_of(k)[1]));
            let side = o.inside_by_rays(p, 3).unwrap();
            match (&side, second.inside(p)) {
                (InsideTruth::Inside, SecondSide::Inside) => sides[0] += 1,
                (InsideTruth::Outside, SecondSide::Outside) => sides[1] += 1,
                (InsideTruth::Inside | InsideTruth::Outside, SecondSide::Undecided) => {
                    sides[2] += 1;
                }
                other => panic!("{name} {p:?}: {other:?}"),
            }
            let v = vector(&mut random, 1.0);
            let (a, b) = (
                o.line(p, v, LineKind::Line).unwrap(),
                second.line(p, v, LineKind::Line),
            );
            assert!(a.open.is_empty(), "{name} {p:?} {v:?} {a:?}");
            assert!(
                a.crossings.is_some_and(|n| n % 2 == 0),
                "{name} {p:?} {v:?} {a:?}"
            );
            for h in &b.hits {
                let (lo, hi) = h.t.ends().unwrap();
                let same = a
                    .hits
                    .iter()
                    .any(|x| x.face == h.face && x.t.lo <= hi && lo <= x.t.hi);
                assert!(same || !h.certain, "{name} {p:?} {v:?}: {h:?} {a:?}");
            }
            if b.open.is_empty() {
                assert_eq!(a.hits.len(), b.hits.len(), "{name} {p:?} {v:?}");
            }
            hits += a.hits.len();
        }
        println!("{name}: sides {sides:?}, {hits} hits");
        assert!(hits > 0, "{name}");
    }
}

/// A ball in the thesis's socket (2.5 about the origin): the separation is 2.5 less distance and radius,
/// in the cavity and in the material around it.
#[test]
fn ball_in_a_native_socket() {
    let Some(breps) = model("thesis/3dm/ball_joint_cavity.3dm") else {
        return;
    };
    let o = oracle(&breps[0]);
    let r = 2.25;
    let check = |c: [f64; 3]| {
        let t = o.sphere(c, r, None).unwrap().unwrap();
        let [x, y, z] = c.map(|x| sq(&d(x)));
        let s = &(&x + &y) + &z;
        let [far, near] = [&t.enclosure.lo, &t.enclosure.hi].map(|e| &d(2.5 - r) - e);
        assert!(near.signum() <= 0 || sq(&near) <= s, "{c:?} {t:?}");
        assert!(far.signum() >= 0 && s <= sq(&far), "{c:?} {t:?}");
        assert!(
            t.enclosure.width() <= "1p-96".parse().unwrap(),
            "{c:?} {t:?}"
        );
    };
    let mut random = Random(16);
    for i in 0..30 {
        // About the centre, near the surface on either side, and in the block.
        let mut c = vector(&mut random, 1.0);
        c[1] += 0.01f64.copysign(c[1]);
        let length = (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]).sqrt();
        let wanted = [1e-3, 0.3, 2.5 - 1e-9, 2.5 + 1e-9, 2.4, 3.0][i % 6];
        check(c.map(|x| x * wanted / length));
    }
    // On the cavity, exactly, and next to it.
    for x in [[1.5, 2.0, 0.0], [0.0, -1.5, 2.0], [-1.5, 0.0, -2.0]] {
        assert_eq!(o.inside(x).unwrap(), InsideTruth::Boundary, "{x:?}");
    }
    let next = [1.5, 2.0f64.next_up(), 0.0];
    assert_eq!(o.inside(next).unwrap(), InsideTruth::Inside);
    let next = [1.5, 2.0f64.next_down(), 0.0];
    assert_eq!(o.inside(next).unwrap(), InsideTruth::Outside);
    // Through the centre: twice the cavity, twice the block.
    let t = o.line([0.0; 3], [0.6, 0.48, 0.64], LineKind::Line).unwrap();
    assert!(t.open.is_empty() && t.hits.len() == 4, "{t:?}");
    assert_eq!((t.crossings, t.in_crack), (Some(4), Some(false)));
}
