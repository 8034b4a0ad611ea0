//! The oracle's distances against analysis and against samples.

use crate::scene::{Random, dyadic as d, interval, polygon};
use feeler::brep::{
    Brep, BrepParts, Edge, Face, Iso, LoopKind, TrimCurve, TrimKind, TrimLoop, Vertex,
};
use feeler::numeric::Dyadic;
use feeler::nurbs::{Curve2, NurbsCurve, NurbsSurface, Plane, Surface};
use feeler::trim::Side;
use feeler_oracle::{DistanceStatus, DistanceTruth, Oracle, TruthEnclosure};
use nalgebra::{Point3, Vector3, Vector4};

// ---- building

/// Adds a face to `parts`; each loop is a list of curves, used over their whole domains.
fn add_face(parts: &mut BrepParts, surface: Surface, loops: Option<Vec<Vec<Curve2>>>) {
    let face = parts.faces.len();
    parts.surfaces.push(surface);
    let loops = loops.map(|loops| {
        loops
            .into_iter()
            .map(|curves| {
                let index = parts.loops.len();
                let mut trims = Vec::new();
                for curve in curves {
                    let vertex = parts.vertices.len();
                    parts.vertices.push(Vertex {
                        point: Point3::origin(),
                        edges: vec![parts.edges.len()],
                        tolerance: None,
                    });
                    parts.edges.push(Edge {
                        curve: None,
                        span: interval(0.0, 1.0),
                        reversed: false,
                        vertices: [vertex; 2],
                        trims: vec![parts.trims.len()],
                        tolerance: None,
                    });
                    trims.push(parts.trims.len());
                    parts.trims.push(TrimCurve {
                        curve: parts.curves2.len(),
                        span: curve.domain(),
                        reversed: false,
                        edge: Some(parts.edges.len() - 1),
                        edge_reversed: false,
                        vertices: [vertex; 2],
                        kind: TrimKind::Boundary,
                        iso: Iso::None,
                        trim_loop: index,
                    });
                    parts.curves2.push(curve);
                }
                parts.loops.push(TrimLoop {
                    kind: LoopKind::Unknown,
                    trims,
                    face,
                });
                index
            })
            .collect()
    });
    parts.faces.push(Face {
        surface: face,
        loops,
        reversed: false,
    });
}

fn brep(surface: Surface, loops: Option<Vec<Vec<Curve2>>>) -> Brep {
    let mut parts = BrepParts::default();
    add_face(&mut parts, surface, loops);
    Brep::new(parts).unwrap()
}

/// A full circle of four rational quadratic arcs.
fn circle(center: [f64; 2], radius: f64) -> Curve2 {
    let w = 0.5f64.sqrt();
    let mut points = Vec::new();
    let corners = [
        [1.0, 0.0],
        [1.0, 1.0],
        [0.0, 1.0],
        [-1.0, 1.0],
        [-1.0, 0.0],
        [-1.0, -1.0],
        [0.0, -1.0],
        [1.0, -1.0],
        [1.0, 0.0],
    ];
    for (i, c) in corners.iter().enumerate() {
        let w = if i % 2 == 1 { w } else { 1.0 };
        points.push(Vector3::new(
            w * (center[0] + radius * c[0]),
            w * (center[1] + radius * c[1]),
            w,
        ));
    }
    let knots = vec![
        0.0, 0.0, 0.0, 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1.0, 1.0, 1.0,
    ];
    Curve2::Nurbs(NurbsCurve::new(2, points, knots).unwrap())
}

fn xy_plane(size: f64) -> Surface {
    Surface::Plane(
        Plane::new(Plane {
            origin: Point3::origin(),
            x: Vector3::x(),
            y: Vector3::y(),
            domain: [interval(-size, size); 2],
            extents: [interval(-size, size); 2],
        })
        .unwrap(),
    )
}

/// A polynomial or rational Bezier patch over the unit square, from points and weights.
fn patch(p: usize, q: usize, f: impl Fn(usize, usize) -> [f64; 4]) -> Surface {
    let mut net = Vec::new();
    for i in 0..=p {
        for j in 0..=q {
            let [x, y, z, w] = f(i, j);
            net.push(Vector4::new(w * x, w * y, w * z, w));
        }
    }
    let knots = |n: usize| {
        let mut k = vec![0.0; n + 1];
        k.extend(vec![1.0; n + 1]);
        k
    };
    Surface::Nurbs(NurbsSurface::new([p, q], [p + 1, q + 1], net, [knots(p), knots(q)]).unwrap())
}

/// An octant of a sphere, rational biquadratic, whose pole is an edge of length zero.
fn octant(center: [f64; 3], radius: f64, sign: [f64; 3]) -> Surface {
    let w = 0.5f64.sqrt();
    let arc = [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let weights = [1.0, w, 1.0];
    patch(2, 2, |i, j| {
        let (c, z) = (arc[j][0], arc[j][1]);
        [
            center[0] + sign[0] * radius * c * arc[i][0],
            center[1] + sign[1] * radius * c * arc[i][1],
            center[2] + sign[2] * radius * z,
            weights[i] * weights[j],
        ]
    })
}

// ---- numbers

fn power_of_two(e: i64) -> Dyadic {
    Dyadic::new(1.into(), e)
}

fn distance(o: &Oracle, p: [f64; 3]) -> DistanceTruth {
    let t = o.distance(p, None).unwrap().unwrap();
    assert!(t.enclosure.lo <= t.enclosure.hi);
    t
}

/// Asserts that the enclosure of a distance holds the root of `square`, and is narrow.
#[track_caller]
fn assert_root(e: &TruthEnclosure, square: &Dyadic) {
    assert!(
        &e.lo * &e.lo <= *square,
        "{e:?} is above the root of {square:?}"
    );
    assert!(
        *square <= &e.hi * &e.hi,
        "{e:?} is below the root of {square:?}"
    );
    assert!(e.width() < power_of_two(-100), "{e:?} is wide");
}

// ---- analysis

#[test]
fn rectangle() {
    let b = brep(xy_plane(1.0), None);
    let o = Oracle::new(&[&b]).unwrap();
    for z in [0.0, 0.3, -1e-15, 7.0] {
        let above = distance(&o, [0.25, -0.75, z]);
        assert_root(&above.enclosure, &(&d(z) * &d(z)));
        let beside = distance(&o, [1.3, 0.1, z]);
        let dx = &d(1.3) - &d(1.0);
        assert_root(&beside.enclosure, &(&(&dx * &dx) + &(&d(z) * &d(z))));
        let corner = distance(&o, [1.3, -2.0, z]);
        let square = &(&(&dx * &dx) + &d(1.0)) + &(&d(z) * &d(z));
        assert_root(&corner.enclosure, &square);
    }
    assert_eq!(
        distance(&o, [0.25, -0.75, 0.5]).status,
        DistanceStatus::Regular
    );
    assert_eq!(
        distance(&o, [1.3, 0.1, 0.5]).status,
        DistanceStatus::EdgeOrCorner
    );
}

/// A search over squares leaves a width at 0; a point exactly on a planar face has none.
#[test]
fn on_a_plane_the_distance_is_zero_exactly() {
    // A plane 0.001 up, which no power of two is.
    let Surface::Plane(plane) = xy_plane(1.0) else {
        unreachable!()
    };
    let origin = Point3::new(0.0, 0.0, 0.001);
    let b = brep(Surface::Plane(Plane { origin, ..plane }), None);
    let o = Oracle::new(&[&b]).unwrap();
    for uv in [[0.25, -0.75], [1.0, 0.1], [-1.0, 1.0]] {
        let e = distance(&o, [uv[0], uv[1], 0.001]).enclosure;
        assert!(e.lo.signum() == 0 && e.hi.signum() == 0, "{e:?}");
    }
    let beside = distance(&o, [1.0f64.next_up(), 0.0, 0.001]).enclosure;
    assert!(beside.hi.signum() > 0);
    let above = distance(&o, [0.0, 0.0, 0.001f64.next_up()]).enclosure;
    assert!(above.lo.signum() > 0);
}

#[test]
fn triangle_in_a_plane() {
    let triangle = polygon(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    let b = brep(xy_plane(2.0), Some(vec![triangle]));
    let o = Oracle::new(&[&b]).unwrap();
    // Nearest the hypotenuse: the squared distance is (x + y - 1)^2 / 2 + z^2.
    for (x, y, z) in [(0.7, 0.9, 0.2), (0.5000000001, 0.5, -0.1), (1.0, 1.0, 0.0)] {
        let s = &(&d(x) + &d(y)) - &d(1.0);
        let square = &(&(&s * &s) * &d(0.5)) + &(&d(z) * &d(z));
        assert_root(&distance(&o, [x, y, z]).enclosure, &square);
    }
    // Above the inside; within 1e-15 of the hypotenuse on both sides; beyond a corner.
    assert_root(
        &distance(&o, [0.2, 0.3, 0.7]).enclosure,
        &(&d(0.7) * &d(0.7)),
    );
    for e in [-1e-15, 1e-15] {
        let s = &(&d(0.5 + e) + &d(0.5)) - &d(1.0);
        let outside = if s.signum() > 0 {
            &(&s * &s) * &d(0.5)
        } else {
            Dyadic::ZERO
        };
        let t = distance(&o, [0.5 + e, 0.5, 0.25]);
        assert_root(&t.enclosure, &(&outside + &d(0.0625)));
    }
    assert_root(
        &distance(&o, [-0.25, -0.5, 0.5]).enclosure,
        &d(0.0625 + 0.25 + 0.25),
    );
}

#[test]
fn hyperbolic_paraboloid() {
    // z = x y over [0, 1]^2; q = foot + s normal, with the foot's normal (-y, -x, 1).
    let b = brep(
        patch(1, 1, |i, j| [i as f64, j as f64, (i * j) as f64, 1.0]),
        None,
    );
    let o = Oracle::new(&[&b]).unwrap();
    for (u, v) in [(0.5, 0.25), (0.625, 0.375), (0.0625, 0.9375), (0.5, 0.5)] {
        // The curvature is at most 1 here, so that these are the closest points.
        for s in [0.0, 2f64.powi(-46), 0.125, -0.25, 0.5] {
            let q = [u - s * v, v - s * u, u * v + s];
            let t = distance(&o, q);
            assert_root(&t.enclosure, &d(s * s * (1.0 + u * u + v * v)));
            assert_eq!(t.status, DistanceStatus::Regular, "{u} {v} {s}");
        }
    }
}

/// A circle on a plane, a hole in it; from the axis the whole rim is equally far, but for the
/// rounding of the weights.
#[test]
fn hole_seen_from_its_axis() {
    let outer = polygon(&[[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]]);
    let b = brep(
        xy_plane(5.0),
        Some(vec![outer, vec![circle([0.0, 0.0], 1.5)]]),
    );
    let o = Oracle::new(&[&b]).unwrap();
    for z in [0.0, 1.0, 1e-9] {
        let t = distance(&o, [0.0, 0.0, z]);
        // Weight w for the exact root of 1/2: the radius is off by less than |w - sqrt(1/2)|.
        let exact = (1.5 * 1.5 + z * z).sqrt();
        assert!((t.enclosure.lo.approximate() - exact).abs() < 1e-15);
        assert!(t.enclosure.width() < power_of_two(-100), "{t:?}");
    }
    // Off the axis: regular, on the rim, above it, and inside the material.
    let t = distance(&o, [0.25, 0.0, 0.0]);
    assert_root(&t.enclosure, &d(1.25 * 1.25));
    assert_eq!(t.status, DistanceStatus::EdgeOrCorner);
    assert_root(&distance(&o, [2.0, 0.0, 0.25]).enclosure, &d(0.0625));
}

#[test]
fn sphere_octants() {
    let center = [0.3, -0.7, 1.1];
    let mut parts = BrepParts::default();
    for k in 0..8 {
        let sign = [0, 1, 2].map(|i| if k >> i & 1 == 0 { 1.0 } else { -1.0 });
        add_face(&mut parts, octant(center, 2.5, sign), None);
    }
    let b = Brep::new(parts).unwrap();
    let o = Oracle::new(&[&b]).unwrap();
    let mut random = Random(3);
    // The data are rounded: control points to 2^-53 of 4, weights to 2^-54, in few terms.
    let noise = 4e-15;
    for off in [0.0, 1e-15, 1e-12, 1e-6, 0.05, 1.0, 2.5 - 1e-12, 2.6, 10.0] {
        let v = Vector3::from_fn(|_, _| random.range(-1.0, 1.0)).normalize() * off;
        let q = [center[0] + v.x, center[1] + v.y, center[2] + v.z];
        let t = distance(&o, q);
        let value = t.enclosure.lo.approximate();
        assert!((value - (2.5 - off).abs()).abs() < noise, "{off}: {value}");
        assert!(t.enclosure.width() < power_of_two(-98), "{off}: {t:?}");
        // No sampled point is closer: exactly.
        for face in 0..8 {
            for uv in [[0.25, 0.5], [0.5, 0.75], [0.875, 0.125], [0.0, 0.5]] {
                let point = o.evaluate(face, uv).unwrap().point;
                let mut high = Dyadic::ZERO;
                for (k, x) in point.iter().enumerate() {
                    let (a, b) = (&x.lo - &d(q[k]), &x.hi - &d(q[k]));
                    let (a, b) = (&a * &a, &b * &b);
                    high = &high + if a > b { &a } else { &b };
                }
                assert!(&t.enclosure.lo * &t.enclosure.lo <= high);
            }
        }
    }
}

#[test]
fn cylinder_seen_from_its_axis() {
    // Radius 0.75 about the z axis, 0 <= z <= 3: four rational quadratic arcs; C0 knots.
    let Curve2::Nurbs(c) = circle([0.0, 0.0], 0.75) else {
        panic!()
    };
    let mut net = Vec::new();
    for p in c.control_points() {
        for z in [0.0, 3.0] {
            net.push(Vector4::new(p.x, p.y, z * p.z, p.z));
        }
    }
    let knots = [c.knots().knots().to_vec(), vec![0.0, 0.0, 1.0, 1.0]];
    let surface = Surface::Nurbs(NurbsSurface::new([2, 1], [9, 2], net, knots).unwrap());
    let b = brep(surface, None);
    let o = Oracle::new(&[&b]).unwrap();
    for (x, z) in [
        (0.0, 1.0),
        (1e-14, 1.0),
        (0.0, -0.5),
        (0.5, 2.0),
        (0.75, 3.5),
    ] {
        let t = distance(&o, [x, 0.0, z]);
        let beyond = (z - 3.0).max(-z).max(0.0);
        let exact = (0.75 - x).hypot(beyond);
        assert!(
            (t.enclosure.lo.approximate() - exact).abs() < 1e-15,
            "{t:?}"
        );
        assert!(t.enclosure.width() < power_of_two(-98), "{x} {z}: {t:?}");
    }
    // The half-space that touches along a generator, exactly: x <= h.
    let t = o.half_space([-1.0, 0.0, 0.0], 0.0, None).unwrap().unwrap();
    // (w 0.75 is rounded in the control points, so that the arc may bulge by that much.)
    assert!((t.enclosure.lo.approximate() + 0.75).abs() < 1e-15, "{t:?}");
    assert!(t.enclosure.width() < power_of_two(-100), "{t:?}");
}

#[test]
fn half_space_on_a_bowl() {
    // z = x^2 + y^2 over [-1, 1]^2, biquadratic Bezier.
    let t = [-1.0, 0.0, 1.0];
    let s = [1.0, -1.0, 1.0];
    let b = brep(patch(2, 2, |i, j| [t[i], t[j], s[i] + s[j], 1.0]), None);
    let o = Oracle::new(&[&b]).unwrap();
    let n = [0.6, 0.0, 0.8];
    let h = 0.125;
    let t = o.half_space(n, h, None).unwrap().unwrap();
    // The least value m of n_x x + n_z x^2 - h: 4 n_z (m + h) = -n_x^2, n_z > 0.
    let product = |m: &Dyadic| &(&(m + &d(h)) * &d(4.0)) * &d(n[2]);
    let minus_square = -&(&d(n[0]) * &d(n[0]));
    assert!(product(&t.enclosure.lo) <= minus_square);
    assert!(minus_square <= product(&t.enclosure.hi));
    assert!(t.enclosure.width() < power_of_two(-100));
    assert_eq!(t.status, DistanceStatus::Regular);
    // Downwards the corners touch.
    let t = o.half_space([0.0, 0.0, -1.0], 0.0, None).unwrap().unwrap();
    assert!(t.enclosure.contains(&d(-2.0)) && t.enclosure.width() < power_of_two(-100));
}

#[test]
fn empty_and_refused() {
    let b = brep(xy_plane(1.0), Some(vec![]));
    let o = Oracle::new(&[&b]).unwrap();
    assert_eq!(o.distance([0.0; 3], None).unwrap(), None);
    assert!(o.distance([f64::NAN, 0.0, 0.0], None).is_err());
    assert!(o.distance([1e300, 0.0, 0.0], None).is_err());
    assert!(o.half_space([1.0, 0.0, 0.0], f64::INFINITY, None).is_err());
}

#[test]
fn a_small_budget_still_holds() {
    let b = brep(octant([0.0; 3], 1.0, [1.0; 3]), None);
    let o = Oracle::new(&[&b]).unwrap();
    let narrow = distance(&o, [0.0; 3]).enclosure;
    for nodes in [0, 1, 5, 50] {
        let t = o.distance([0.0; 3], Some(nodes)).unwrap().unwrap();
        assert!(
            t.enclosure.lo <= narrow.lo && narrow.hi <= t.enclosure.hi,
            "{nodes}"
        );
        assert!(t.enclosure.width() < d(1e-14));
    }
}

// ---- samples

/// Bicubic faces with knot lines, trimmed by a curved loop that crosses them: no sample of the region
/// is closer than the lower end, and some sample is about as close as the upper end.
#[test]
fn trimmed_bicubic_faces_against_samples() {
    let mut random = Random(11);
    let (mut descents, mut arrived) = (0, 0);
    for case in 0..4 {
        let rational = case % 2 == 1;
        let knots = vec![0.0, 0.0, 0.0, 0.0, 0.3, 0.7, 1.0, 1.0, 1.0, 1.0];
        let mut net = Vec::new();
        for i in 0..6 {
            for j in 0..6 {
                let w = if rational {
                    random.range(0.5, 1.5)
                } else {
                    1.0
                };
                let p = [i as f64 / 5.0, j as f64 / 5.0, random.range(-0.4, 0.4)];
                net.push(Vector4::new(w * p[0], w * p[1], w * p[2], w));
            }
        }
        let surface = NurbsSurface::new([3, 3], [6, 6], net, [knots.clone(), knots]).unwrap();
        let mut hole = polygon(&[[0.4, 0.4], [0.45, 0.6], [0.6, 0.5]]);
        let blob = wobbly(&mut random, 5);
        hole.truncate(3);
        let b = brep(Surface::Nurbs(surface), Some(vec![blob, hole]));
        let o = Oracle::new(&[&b]).unwrap();
        // Samples: points of a grid inside the region, to doubles.
        let n = 48;
        let mut points = Vec::new();
        let mut parameters = Vec::new();
        for i in 0..=n {
            for j in 0..=n {
                let uv = [i as f64 / n as f64, j as f64 / n as f64];
                if o.side(0, uv).unwrap().side != Side::Outside {
                    let p = o.evaluate(0, uv).unwrap().point;
                    points.push(Vector3::from_fn(|k, _| p[k].lo.approximate()));
                    parameters.push(uv);
                }
            }
        }
        assert!(points.len() > 200);
        for _ in 0..250 {
            let q = Vector3::new(
                random.range(-0.2, 1.2),
                random.range(-0.2, 1.2),
                random.range(-0.8, 0.8),
            );
            let t = distance(&o, [q.x, q.y, q.z]);
            let sampled = points
                .iter()
                .map(|p| (p - q).norm())
                .fold(f64::INFINITY, f64::min);
            let (lo, hi) = (t.enclosure.lo.approximate(), t.enclosure.hi.approximate());
            assert!(sampled >= lo * (1.0 - 1e-14), "{q:?}: {sampled} {t:?}");
            // The grid's step is 1/48, the surface's stretch at most about 6.
            assert!(sampled <= hi + 0.1, "{q:?}: {sampled} {t:?}");
            assert!(
                t.enclosure.width() < power_of_two(-100),
                "{q:?}: {} {t:?}",
                t.enclosure.width().approximate()
            );
            assert_ne!(t.status, DistanceStatus::Budget);
            if t.status == DistanceStatus::Regular && descents < 10 {
                // Downhill from the best sample, within the region (on a trim curve such a search
                // stops short where both axes lead out).
                let near = |i: &usize, j: &usize| {
                    (points[*i] - q).norm().total_cmp(&(points[*j] - q).norm())
                };
                let best = (0..points.len()).min_by(near).unwrap();
                let found = descend(&o, &q, parameters[best], 0.5 / n as f64);
                assert!(found >= lo * (1.0 - 1e-14), "{q:?}: {found} {t:?}");
                descents += 1;
                arrived += usize::from(found <= hi + 1e-6);
            }
        }
    }
    // A few may end in another valley.
    assert!(
        descents > 4 && 4 * arrived >= 3 * descents,
        "{arrived} of {descents}"
    );
}

/// The distance that a pattern search over the region of face 0 comes to.
fn descend(o: &Oracle, q: &Vector3<f64>, mut uv: [f64; 2], mut step: f64) -> f64 {
    let distance = |uv: [f64; 2]| {
        let p = o.evaluate(0, uv).unwrap().point;
        (Vector3::from_fn(|k, _| p[k].lo.approximate()) - q).norm()
    };
    let mut best = distance(uv);
    while step > 1e-7 {
        let from = uv;
        for (du, dv) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let to = [from[0] + du * step, from[1] + dv * step];
            let inside = to.iter().all(|x| (0.0..=1.0).contains(x))
                && o.side(0, to).unwrap().side != Side::Outside;
            if inside && distance(to) < best {
                (best, uv) = (distance(to), to);
            }
        }
        if uv == from {
            step *= 0.5;
        }
    }
    best
}

/// A closed loop of rational cubics around (0.5, 0.5).
fn wobbly(random: &mut Random, n: usize) -> Vec<Curve2> {
    let ends: Vec<[f64; 2]> = (0..n)
        .map(|i| {
            let a = std::f64::consts::TAU * i as f64 / n as f64;
            let r = random.range(0.3, 0.4);
            [0.5 + r * a.cos(), 0.5 + r * a.sin()]
        })
        .collect();
    (0..n)
        .map(|i| {
            let (a, b) = (ends[i], ends[(i + 1) % n]);
            let mut at = |t: f64| {
                let mut c = |k: usize| a[k] + t * (b[k] - a[k]) + random.range(-0.05, 0.05);
                let (u, v) = (c(0), c(1));
                let w = random.range(0.5, 1.5);
                Vector3::new(w * u, w * v, w)
            };
            let inner = [at(1.0 / 3.0), at(2.0 / 3.0)];
            let points = vec![
                Vector3::new(a[0], a[1], 1.0),
                inner[0],
                inner[1],
                Vector3::new(b[0], b[1], 1.0),
            ];
            let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
            Curve2::Nurbs(NurbsCurve::new(3, points, knots).unwrap())
        })
        .collect()
}
