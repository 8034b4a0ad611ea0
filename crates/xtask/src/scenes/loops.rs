//! Loops of trim curves in the unit square, from 4 to 200,000 arcs, regular and as bad as they come.
//!
//! Coordinates are multiples of 2^-20 where there are many, so that files stay small.

use crate::random::Random;
use feeler::numeric::{Ball, Interval, sin_cos};
use feeler::nurbs::{Arc, Curve, Curve2, Line, NurbsCurve, PolyCurve, Polyline};
use nalgebra::{Point2, Vector2, Vector3};

pub(crate) type Loops = Vec<Vec<Curve2>>;
type P = [f64; 2];

/// A scene of loops.
pub(crate) struct LoopScene {
    pub(crate) name: String,
    /// `None`: the whole domain.
    pub(crate) loops: Option<Loops>,
    /// Queries asked about it.
    pub(crate) queries: usize,
}

const UNIT: Interval = Interval {
    start: 0.0,
    end: 1.0,
};

fn grid(x: f64) -> f64 {
    const SCALE: f64 = (1u64 << 20) as f64;
    (x * SCALE).round() / SCALE
}

/// `center + radius (cos a, sin a)` on the grid; the same on every platform.
pub(crate) fn polar(center: P, radius: f64, angle: f64) -> P {
    let (s, c) = sin_cos(Ball::exact(angle));
    [
        grid(center[0] + radius * c.mid.hi),
        grid(center[1] + radius * s.mid.hi),
    ]
}

pub(crate) const TURN: f64 = std::f64::consts::TAU;

/// A straight trim.
pub(crate) fn line(a: P, b: P) -> Curve2 {
    Curve::Line(Line {
        from: Point2::from(a),
        to: Point2::from(b),
        domain: UNIT,
    })
}

/// A trim for each side.
pub(crate) fn polygon(points: &[P]) -> Vec<Curve2> {
    let next = |i: usize| points[(i + 1) % points.len()];
    points
        .iter()
        .enumerate()
        .map(|(i, p)| line(*p, next(i)))
        .collect()
}

/// One trim for all sides; the parameter counts them.
fn polyline(points: &[P]) -> Vec<Curve2> {
    let mut all: Vec<Point2<f64>> = points.iter().map(|p| Point2::from(*p)).collect();
    all.push(all[0]);
    let params = (0..all.len()).map(|i| i as f64).collect();
    Polyline::new(all, params)
        .map(|c| vec![Curve::Polyline(c)])
        .unwrap_or_default()
}

pub(crate) fn rectangle(a: P, b: P) -> Vec<Curve2> {
    polygon(&[a, [b[0], a[1]], b, [a[0], b[1]]])
}

/// Homogeneous points from points and weights.
pub(crate) fn nurbs(
    points: &[P],
    weights: &[f64],
    degree: usize,
    knots: Vec<f64>,
) -> Option<Curve2> {
    let all = points
        .iter()
        .zip(weights)
        .map(|(p, w)| Vector3::new(p[0] * w, p[1] * w, *w));
    let curve = NurbsCurve::new(degree, all.collect(), knots).ok()?;
    Some(Curve::Nurbs(curve))
}

/// A Bezier piece.
pub(crate) fn bezier(points: &[P], weights: &[f64]) -> Option<Curve2> {
    let p = points.len() - 1;
    let knots = (0..2 * points.len()).map(|i| if i <= p { 0.0 } else { 1.0 });
    nurbs(points, weights, p, knots.collect())
}

pub(crate) fn cubic(points: [P; 4]) -> Option<Curve2> {
    bezier(&points, &[1.0; 4])
}

/// A closed spline of this degree through no point of its closed control polygon: one trim, clamped, with the last
/// control point equal to the first.
fn closed_spline(points: &[P], weights: &[f64], degree: usize) -> Option<Vec<Curve2>> {
    let mut all = points.to_vec();
    let mut w = weights.to_vec();
    all.push(points[0]);
    w.push(weights[0]);
    let spans = all.len() - degree;
    let mut knots = vec![0.0; degree];
    knots.extend((0..=spans).map(|i| i as f64));
    knots.extend(vec![spans as f64; degree]);
    Some(vec![nurbs(&all, &w, degree, knots)?])
}

/// `2 n` points round a centre, in and out.
fn star(center: P, n: usize, inner: f64, outer: f64) -> Vec<P> {
    let n2 = 2 * n;
    (0..n2)
        .map(|i| {
            let r = if i % 2 == 0 { outer } else { inner };
            polar(center, r, TURN * (i as f64) / n2 as f64)
        })
        .collect()
}

/// A random star-shaped polygon.
fn blob(random: &mut Random, center: P, n: usize, inner: f64, outer: f64) -> Vec<P> {
    (0..n)
        .map(|i| {
            polar(
                center,
                random.between(inner, outer),
                TURN * (i as f64) / n as f64,
            )
        })
        .collect()
}

/// A comb of `n` teeth from 0.05 to 0.95: `4 n` sides and the back's three.
fn comb(n: usize) -> Vec<P> {
    let mut points = vec![[0.05, 0.95], [0.05, 0.05]];
    for i in 0..n {
        let x = |k: f64| grid(0.05 + 0.9 * (i as f64 + k) / n as f64);
        points.extend([
            [x(0.25), 0.05],
            [x(0.25), 0.75],
            [x(0.75), 0.75],
            [x(0.75), 0.05],
        ]);
    }
    points.extend([[0.95, 0.05], [0.95, 0.95]]);
    points
}

/// A native circle, as `n` arcs.
pub(crate) fn circle(center: P, radius: f64, n: usize, clockwise: bool) -> Vec<Curve2> {
    let arcs = (0..n).filter_map(|i| {
        let at = |k: usize| TURN * (k as f64) / n as f64;
        let sign = if clockwise { -1.0 } else { 1.0 };
        let arc = Arc::new(Arc {
            center: Point2::from(center),
            x: Vector2::x(),
            y: Vector2::y() * sign,
            z: Vector2::zeros(),
            radius,
            angle: Interval {
                start: at(i),
                end: at(i + 1),
            },
            domain: UNIT,
        });
        arc.ok().map(Curve::Arc)
    });
    arcs.collect()
}

/// The same as four rational quadratics, up to rounding.
fn rational_circle(center: P, r: f64) -> Option<Vec<Curve2>> {
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let [x, y] = center;
    let corners = [
        [[x + r, y], [x + r, y + r], [x, y + r]],
        [[x, y + r], [x - r, y + r], [x - r, y]],
        [[x - r, y], [x - r, y - r], [x, y - r]],
        [[x, y - r], [x + r, y - r], [x + r, y]],
    ];
    let arcs = corners.iter().map(|p| bezier(p, &[1.0, h, 1.0]));
    arcs.collect()
}

/// The same loops with every coordinate scaled exactly (powers of two).
pub(crate) fn scaled(loops: &Loops, s: P) -> Option<Loops> {
    let map = |p: &Point2<f64>| Point2::new(p.x * s[0], p.y * s[1]);
    loops
        .iter()
        .map(|l| l.iter().map(|c| scaled_curve(c, s, &map)).collect())
        .collect()
}

fn scaled_curve(c: &Curve2, s: P, map: &dyn Fn(&Point2<f64>) -> Point2<f64>) -> Option<Curve2> {
    Some(match c {
        Curve::Line(c) => Curve::Line(Line {
            from: map(&c.from),
            to: map(&c.to),
            domain: c.domain,
        }),
        Curve::Polyline(c) => {
            let points = c.points().iter().map(map).collect();
            Curve::Polyline(Polyline::new(points, c.params().to_vec()).ok()?)
        }
        Curve::Nurbs(c) => {
            let points = c.control_points().iter();
            let points = points.map(|p| Vector3::new(p.x * s[0], p.y * s[1], p.z));
            let knots = c.knots().knots().to_vec();
            Curve::Nurbs(NurbsCurve::new(c.degree(), points.collect(), knots).ok()?)
        }
        // Circles would become ellipses.
        Curve::Arc(_) | Curve::Poly(_) => return None,
    })
}

/// All scenes, small ones first.
pub(crate) fn scenes() -> Vec<LoopScene> {
    let mut all = Vec::new();
    let mut add = |name: &str, queries: usize, loops: Option<Loops>| {
        all.push(LoopScene {
            name: name.to_owned(),
            loops,
            queries,
        });
    };
    let mut random = Random::new("loops");
    let outer = || rectangle([0.0625, 0.0625], [0.9375, 0.9375]);
    let middle = [0.5, 0.5];

    add("whole_domain", 40, None);
    add("no_loops", 40, Some(vec![]));
    add("rectangle", 160, Some(vec![outer()]));
    for n in [16, 64, 256, 1024] {
        let points = blob(&mut random, middle, n, 0.2, 0.45);
        add(&format!("polygon_{n}"), 200, Some(vec![polygon(&points)]));
    }
    for n in [8, 128] {
        add(&format!("comb_{n}"), 240, Some(vec![polygon(&comb(n))]));
    }
    for n in [4096, 50_000] {
        add(&format!("comb_{n}"), 300, Some(vec![polyline(&comb(n))]));
    }
    for n in [8, 64, 512] {
        let points = star(middle, n, 0.3, 0.45);
        let ones = vec![1.0; points.len()];
        let weights: Vec<f64> = points
            .iter()
            .map(|_| grid(random.between(0.1, 10.0)))
            .collect();
        let wild: Vec<f64> = points
            .iter()
            .map(|_| [1e-6, 1e-3, 1.0, 1e3, 1e6][random.below(5)])
            .collect();
        let spline = |w: &[f64], p| closed_spline(&points, w, p).map(|l| vec![l]);
        add(&format!("cubics_{n}"), 220, spline(&ones, 3));
        add(&format!("rational_cubics_{n}"), 220, spline(&weights, 3));
        add(&format!("quintics_{n}"), 160, spline(&ones, 5));
        add(&format!("weights_1e12_{n}"), 160, spline(&wild, 3));
    }
    {
        let points = star(middle, 32_768, 0.4, 0.45);
        let ones = vec![1.0; points.len()];
        add(
            "cubics_65536",
            300,
            closed_spline(&points, &ones, 3).map(|l| vec![l]),
        );
    }
    {
        let ones = [1.0; 26];
        let points: Vec<P> = (0..26)
            .map(|i| {
                let x = grid(0.1 + 0.8 * i as f64 / 25.0);
                // Control points that swing far, so that the curve itself swings.
                [
                    x,
                    if i % 2 == 0 {
                        0.45 - 0.3 * (i % 3) as f64
                    } else {
                        0.9
                    },
                ]
            })
            .collect();
        let back = [
            line(points[25], [0.9, 0.01]),
            line([0.9, 0.01], [0.1, 0.01]),
        ];
        let mut l: Vec<Curve2> = bezier(&points, &ones).into_iter().collect();
        l.extend(back);
        l.push(line([0.1, 0.01], points[0]));
        add("degree_25", 200, Some(vec![l]));
    }
    // Nested islands to depth 6: squares, native circles, rational circles.
    let depths = |k: usize| 0.46 - 0.07 * k as f64;
    let squares = (0..6).map(|k| {
        let r = grid(depths(k));
        rectangle([0.5 - r, 0.5 - r], [0.5 + r, 0.5 + r])
    });
    add("islands_squares", 200, Some(squares.collect()));
    let circles = (0..6).map(|k| circle(middle, depths(k), 1 + k, k % 2 == 1));
    add("islands_arcs", 200, Some(circles.collect()));
    let rational = (0..6).map(|k| rational_circle(middle, depths(k)));
    add("islands_rational", 200, rational.collect());
    // Ten by ten holes.
    let mut holes = vec![outer()];
    for i in 0..100 {
        let c = [
            grid(0.12 + 0.084 * f64::from(i % 10)),
            grid(0.12 + 0.084 * f64::from(i / 10)),
        ];
        holes.push(circle(c, grid(0.03), 1 + i as usize % 4, true));
    }
    add("holes_100_arcs", 240, Some(holes));
    // Two holes that share an edge, exactly or nearly.
    for (name, gap) in [
        ("exact", 0.0),
        ("apart", 1e-12),
        ("overlapping", -1e-12),
        ("apart_ulp", f64::EPSILON / 2.0),
    ] {
        let loops = vec![
            outer(),
            rectangle([0.25, 0.25], [0.5, 0.75]),
            rectangle([0.5 + gap, 0.25], [0.75, 0.75]),
        ];
        add(&format!("shared_edge_{name}"), 200, Some(loops));
    }
    let diamond = |x: f64| polygon(&[[x - 0.125, 0.5], [x, 0.375], [x + 0.125, 0.5], [x, 0.625]]);
    add(
        "touching_vertices",
        200,
        Some(vec![outer(), diamond(0.375), diamond(0.625)]),
    );
    add(
        "tangent_circles",
        200,
        Some(vec![
            outer(),
            circle([0.375, 0.5], 0.125, 2, true),
            circle([0.625, 0.5], 0.125, 3, true),
        ]),
    );
    add(
        "hole_touches_outer",
        160,
        Some(vec![outer(), diamond(0.8125)]),
    );
    // Curves that are bad in themselves.
    let closing = |c: Option<Curve2>, a: P, b: P| c.map(|c| vec![vec![c, line(b, a)]]);
    let cusp = cubic([[0.2, 0.2], [0.8, 0.8], [0.2, 0.8], [0.8, 0.2]]);
    add("cusp", 200, closing(cusp, [0.2, 0.2], [0.8, 0.2]));
    let knot = cubic([[0.5, 0.4], [0.1, 0.8], [0.9, 0.8], [0.5, 0.2]]);
    add("self_crossing", 200, closing(knot, [0.5, 0.4], [0.5, 0.2]));
    let flat = cubic([[0.1, 0.5], [0.4, 0.5], [0.6, 0.5], [0.9, 0.5]]);
    let flat = flat.map(|c| {
        vec![vec![
            c,
            line([0.9, 0.5], [0.9, 0.9]),
            line([0.9, 0.9], [0.1, 0.9]),
            line([0.1, 0.9], [0.1, 0.5]),
        ]]
    });
    add("horizontal_cubic", 200, flat);
    let tangent = cubic([[0.1, 0.5], [0.4, 0.3], [0.6, 0.7], [0.9, 0.5]]);
    let tangent = tangent.map(|c| {
        vec![vec![
            c,
            line([0.9, 0.5], [0.9, 0.9]),
            line([0.9, 0.9], [0.1, 0.9]),
            line([0.1, 0.9], [0.1, 0.5]),
        ]]
    });
    add("inflection", 200, tangent);
    let almost = cubic([
        [0.1, 0.5],
        [0.4, 0.5f64.next_up()],
        [0.6, 0.5f64.next_down()],
        [0.9, 0.5],
    ]);
    add(
        "almost_horizontal",
        200,
        almost.map(|c| {
            vec![vec![
                c,
                line([0.9, 0.5], [0.9, 0.9]),
                line([0.9, 0.9], [0.1, 0.9]),
                line([0.1, 0.9], [0.1, 0.5]),
            ]]
        }),
    );
    let eight = [[0.2, 0.2], [0.8, 0.8], [0.8, 0.2], [0.2, 0.8]];
    add("figure_eight", 200, Some(vec![polygon(&eight)]));
    let pentagram: Vec<P> = (0..5)
        .map(|i| polar(middle, 0.4, TURN * f64::from(2 * i) / 5.0))
        .collect();
    add("pentagram", 200, Some(vec![polygon(&pentagram)]));
    let mut twice = rectangle([0.25, 0.25], [0.75, 0.75]);
    twice.extend(rectangle([0.25, 0.25], [0.75, 0.75]));
    add("twice_around", 120, Some(vec![twice]));
    let mut double = circle(middle, 0.375, 2, false);
    double.extend(circle(middle, 0.375, 2, false));
    add("twice_around_arcs", 120, Some(vec![double]));
    let spiral: Vec<P> = (0..64)
        .map(|i| {
            polar(
                middle,
                0.15 + 0.3 * f64::from(i) / 64.0,
                TURN * 3.0 * f64::from(i) / 64.0,
            )
        })
        .collect();
    add("overlapping_spiral", 200, Some(vec![polygon(&spiral)]));
    add(
        "overlapping_loops",
        200,
        Some(vec![
            rectangle([0.1, 0.1], [0.6, 0.6]),
            rectangle([0.4, 0.4], [0.9, 0.9]),
        ]),
    );
    // Out and back: encloses nothing.
    let slit = vec![
        line([0.25, 0.5], [0.75, 0.5]),
        line([0.75, 0.5], [0.25, 0.5]),
    ];
    add("slit", 160, Some(vec![outer(), slit]));
    // All kinds in one loop, with gaps, and a trim of no length.
    for (name, gap) in [("mixture", 0.0), ("mixture_gaps", 1e-7)] {
        let h = std::f64::consts::FRAC_1_SQRT_2;
        let arc = Arc::new(Arc {
            center: Point2::new(0.75, 0.5),
            x: -Vector2::y(),
            y: Vector2::x(),
            z: Vector2::zeros(),
            radius: 0.125,
            angle: Interval {
                start: 0.0,
                end: TURN / 2.0,
            },
            domain: UNIT,
        });
        let l = [
            Some(line([0.25, 0.25], [0.75 - gap, 0.25])),
            Some(line([0.75, 0.25], [0.75, 0.375])),
            Some(line([0.75, 0.375], [0.75, 0.375])),
            arc.ok().map(Curve::Arc),
            cubic([[0.75, 0.625 + gap], [0.9, 0.75], [0.5, 0.95], [0.5, 0.75]]),
            bezier(
                &[[0.5, 0.75 + gap], [0.25, 0.75], [0.25, 0.5]],
                &[1.0, h, 1.0],
            ),
            Some(line([0.25 - gap, 0.5], [0.25, 0.25 + gap])),
        ];
        add(
            name,
            300,
            l.into_iter().collect::<Option<_>>().map(|l| vec![l]),
        );
    }
    // Pieces in one trim.
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let pieces = [
        Some(line([0.25, 0.25], [0.75, 0.25])),
        cubic([[0.75, 0.25], [0.9, 0.4], [0.6, 0.6], [0.75, 0.75]]),
        bezier(&[[0.75, 0.75], [0.25, 0.75], [0.25, 0.25]], &[1.0, h, 1.0]),
    ];
    let poly = pieces
        .into_iter()
        .collect::<Option<Vec<_>>>()
        .and_then(|p| PolyCurve::new(p, vec![0.0, 1.0, 3.0, 3.5]).ok());
    add(
        "poly_curve",
        200,
        poly.map(|p| vec![outer(), vec![Curve::Poly(p)]]),
    );
    // Holes too small to see.
    for (name, size) in [("1e-9", 1e-9), ("1e-15", 1e-15), ("1e-300", 0.0)] {
        let tiny = if size > 0.0 {
            rectangle([0.5, 0.5], [0.5 + size, 0.5 + size])
        } else {
            rectangle([0.0, 0.0], [1e-300, 1e-300])
        };
        let border = rectangle([-0.5, -0.5], [0.9375, 0.9375]);
        add(&format!("tiny_hole_{name}"), 160, Some(vec![border, tiny]));
    }
    let outside = |d: f64| vec![rectangle([-d, 0.25], [1.0 + d, 0.75])];
    add("beyond_domain_1e-9", 160, Some(outside(1e-9)));
    add("beyond_domain_tenth", 160, Some(outside(0.1)));
    all
}
