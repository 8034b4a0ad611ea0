//! Random faces of all kinds of surfaces, whose edges are a little off.

use super::shapes::{Frame, Nudge, Shape, Spline, V, basis, list};
use super::{Random, Writer};
use nalgebra::Unit;
use std::f64::consts::{PI, TAU};

/// The part of a surface that a face is to be on.
pub(super) struct Patch {
    pub(super) name: &'static str,
    pub(super) surface: String,
    pub(super) at: Box<dyn Fn(f64, f64) -> V>,
    pub(super) uv: [[f64; 2]; 2],
    /// The curve of the surface at this u, or this v, and whether it runs with the other parameter.
    pub(super) along_v: Box<dyn Fn(f64) -> Option<(Shape, bool)>>,
    pub(super) along_u: Box<dyn Fn(f64) -> Option<(Shape, bool)>>,
    /// Whether u goes around.
    pub(super) is_round: bool,
    pub(super) size: f64,
}

pub(super) const KINDS: usize = 8;

pub(super) fn profile(r: &mut Random, f: &Frame) -> (Shape, [f64; 2]) {
    match r.below(6) {
        0 => (
            Shape::Line(f.o, f.x * r.range(0.3, 2.0) + f.y * r.range(-1.0, 1.0)),
            [-1.0, 1.5],
        ),
        1 => (
            Shape::Circle(*f, r.range(0.5, 3.0)),
            [0.3, 0.3 + r.range(0.5, 4.0)],
        ),
        2 => (
            Shape::Ellipse(*f, [r.range(1.5, 3.0), r.range(0.5, 1.5)]),
            [0.4, 0.4 + r.range(0.5, 4.0)],
        ),
        3 => (
            Shape::Parabola(*f, r.range(0.3, 2.0)),
            [r.range(-2.0, 0.0), r.range(0.5, 2.0)],
        ),
        4 => (
            Shape::Hyperbola(*f, [r.range(0.5, 2.0), r.range(0.5, 2.0)]),
            [r.range(-2.0, 0.0), r.range(0.5, 2.0)],
        ),
        _ => {
            let f = *f;
            let (a, b, c) = (r.range(-0.5, 0.5), r.range(1.0, 3.0), r.range(0.2, 0.8));
            let path = move |s: f64| f.at(3.0 * s, a * s + c * (b * s).sin(), 0.0);
            let spread = if r.chance(0.4) { 3.0 } else { 1.0 };
            let (p, n) = (1 + r.below(5), 1 + r.below(3));
            let s = Spline::through(r, &path, p, n, spread);
            let range = [s.breaks[0], *s.breaks.last().unwrap()];
            (Shape::Spline(s), range)
        }
    }
}

pub(super) fn patch(r: &mut Random, w: &mut Writer, kind: usize, far: f64) -> Patch {
    let f = Frame::random(r, far);
    let u0 = r.range(-PI, PI);
    let u1 = u0 + r.range(0.3, 5.5);
    let axes = |w: &mut Writer| w.axes(f.o.into(), f.z.into(), f.x.into());
    match kind {
        0 => {
            let a = axes(w);
            let (v0, v1) = (r.range(-2.0, 0.0), r.range(0.5, 3.0));
            Patch {
                name: "plane",
                surface: w.put(format!("PLANE('',{a})")),
                at: Box::new(move |u, v| f.at(u, v, 0.0)),
                uv: [[u0, u1], [v0, v1]],
                along_v: Box::new(move |u| Some((Shape::Line(f.at(u, 0.0, 0.0), f.y), true))),
                along_u: Box::new(move |v| Some((Shape::Line(f.at(0.0, v, 0.0), f.x), true))),
                is_round: false,
                size: 6.0,
            }
        }
        1 => {
            let a = axes(w);
            let radius = r.range(0.5, 3.0);
            let v0 = r.range(-2.0, 2.0);
            let at = move |u: f64, v: f64| f.at(radius * u.cos(), radius * u.sin(), v);
            Patch {
                name: "cylinder",
                surface: w.put(format!("CYLINDRICAL_SURFACE('',{a},{radius:?})")),
                at: Box::new(at),
                uv: [[u0, u1], [v0, v0 + r.range(0.3, 4.0)]],
                along_v: Box::new(move |u| Some((Shape::Line(at(u, 0.0), f.z), true))),
                along_u: Box::new(move |v| {
                    Some((
                        Shape::Circle(
                            Frame {
                                o: f.at(0.0, 0.0, v),
                                ..f
                            },
                            radius,
                        ),
                        true,
                    ))
                }),
                is_round: true,
                size: 4.0,
            }
        }
        2 => {
            let a = axes(w);
            let radius = r.range(0.5, 3.0);
            let half = r.range(0.05, 1.3) * if r.chance(0.5) { 1.0 } else { -1.0 };
            let (sin, cos) = half.sin_cos();
            let rho = move |v: f64| radius + v * sin;
            let at = move |u: f64, v: f64| f.at(rho(v) * u.cos(), rho(v) * u.sin(), v * cos);
            // On one side of the apex.
            let apex = -radius / sin;
            let near = apex - r.range(0.3, 1.0) * apex.signum();
            let away = near + r.range(0.5, 3.0) * -apex.signum();
            let v = [near.min(away), near.max(away)];
            Patch {
                name: "cone",
                surface: w.put(format!("CONICAL_SURFACE('',{a},{radius:?},{half:?})")),
                at: Box::new(at),
                uv: [[u0, u1], v],
                along_v: Box::new(move |u| {
                    Some((Shape::Line(at(u, 0.0), at(u, 1.0) - at(u, 0.0)), true))
                }),
                along_u: Box::new(move |v| {
                    let own = rho(v);
                    let g = if own > 0.0 { f } else { f.turned(PI) };
                    Some((
                        Shape::Circle(
                            Frame {
                                o: f.at(0.0, 0.0, v * cos),
                                ..g
                            },
                            own.abs(),
                        ),
                        true,
                    ))
                }),
                is_round: true,
                size: 4.0,
            }
        }
        3 | 4 => {
            let a = axes(w);
            let minor = r.range(0.5, 2.0);
            let major = if kind == 3 {
                0.0
            } else {
                minor + r.range(0.1, 3.0)
            };
            let rho = move |v: f64| major + minor * v.cos();
            let at =
                move |u: f64, v: f64| f.at(rho(v) * u.cos(), rho(v) * u.sin(), minor * v.sin());
            let v0 = if kind == 3 {
                r.range(-1.3, 0.3)
            } else {
                r.range(-PI, PI)
            };
            let v1 = v0
                + if kind == 3 {
                    r.range(0.3, 1.0)
                } else {
                    r.range(0.3, 5.0)
                };
            Patch {
                name: if kind == 3 { "sphere" } else { "torus" },
                surface: w.put(if kind == 3 {
                    format!("SPHERICAL_SURFACE('',{a},{minor:?})")
                } else {
                    format!("TOROIDAL_SURFACE('',{a},{major:?},{minor:?})")
                }),
                at: Box::new(at),
                uv: [[u0, u1], [v0, v1]],
                along_v: Box::new(move |u| {
                    let g = f.turned(u);
                    let own = Frame {
                        o: g.at(major, 0.0, 0.0),
                        x: g.x,
                        y: g.z,
                        z: -g.y,
                    };
                    Some((Shape::Circle(own, minor), true))
                }),
                along_u: Box::new(move |v| {
                    Some((
                        Shape::Circle(
                            Frame {
                                o: f.at(0.0, 0.0, minor * v.sin()),
                                ..f
                            },
                            rho(v),
                        ),
                        true,
                    ))
                }),
                is_round: true,
                size: 5.0,
            }
        }
        5 => {
            let (p, range) = profile(r, &f);
            let d = f.z * r.range(0.5, 1.5) + f.x * r.range(-0.3, 0.3);
            let entity = p.put(w);
            let length = d.norm();
            let direction = w.direction((d / length).into());
            let vector = w.put(format!("VECTOR('',{direction},{length:?})"));
            let (own, other) = (p.clone(), p.clone());
            Patch {
                name: "extrusion",
                surface: w.put(format!("SURFACE_OF_LINEAR_EXTRUSION('',{entity},{vector})")),
                at: Box::new(move |u, v| p.point(u) + d * v),
                uv: [range, [r.range(-1.0, 0.0), r.range(0.3, 2.0)]],
                along_v: Box::new(move |u| Some((Shape::Line(own.point(u), d), true))),
                along_u: Box::new(move |v| {
                    let n = Nudge {
                        about: V::zeros(),
                        turn: V::zeros(),
                        by: d * v,
                    };
                    Some((other.nudged(&n), true))
                }),
                is_round: false,
                size: 6.0,
            }
        }
        6 => {
            // The profile is in a plane with the axis, or not quite.
            let tilt = if r.chance(0.5) {
                0.0
            } else {
                r.range(-0.4, 0.4)
            };
            let side = Frame {
                o: f.at(r.range(4.0, 6.0), 0.0, 0.0),
                x: f.z,
                y: (f.x + f.y * tilt).normalize(),
                z: V::zeros(),
            };
            let side = Frame {
                z: side.x.cross(&side.y),
                ..side
            };
            let (p, range) = profile(r, &side);
            let entity = p.put(w);
            let (o, z) = (w.point(f.o.into()), w.direction(f.z.into()));
            let axis = w.put(format!("AXIS1_PLACEMENT('',{o},{z})"));
            let turn = move |q: V, u: f64| {
                let axis = Unit::new_normalize(f.z);
                f.o + nalgebra::Rotation3::from_axis_angle(&axis, u) * (q - f.o)
            };
            let (own, circle) = (p.clone(), p.clone());
            Patch {
                name: "revolution",
                surface: w.put(format!("SURFACE_OF_REVOLUTION('',{entity},{axis})")),
                at: Box::new(move |u, v| turn(p.point(v), u)),
                uv: [[u0, u1], range],
                along_v: Box::new(move |u| {
                    let frame = |g: &Frame| Frame {
                        o: turn(g.o, u),
                        x: turn(f.o + g.x, u) - f.o,
                        y: turn(f.o + g.y, u) - f.o,
                        z: turn(f.o + g.z, u) - f.o,
                    };
                    Some((
                        match &own {
                            Shape::Line(p, d) => Shape::Line(turn(*p, u), turn(f.o + d, u) - f.o),
                            Shape::Circle(g, r) => Shape::Circle(frame(g), *r),
                            Shape::Ellipse(g, r) => Shape::Ellipse(frame(g), *r),
                            Shape::Parabola(g, r) => Shape::Parabola(frame(g), *r),
                            Shape::Hyperbola(g, r) => Shape::Hyperbola(frame(g), *r),
                            Shape::Spline(s) => Shape::Spline(Spline {
                                points: s.points.iter().map(|q| turn(*q, u)).collect(),
                                ..s.clone()
                            }),
                        },
                        true,
                    ))
                }),
                along_u: Box::new(move |v| {
                    let q = circle.point(v) - f.o;
                    let height = q.dot(&f.z);
                    let out = q - f.z * height;
                    let x = out.normalize();
                    let o = f.at(0.0, 0.0, height);
                    Some((
                        Shape::Circle(
                            Frame {
                                o,
                                x,
                                y: f.z.cross(&x),
                                z: f.z,
                            },
                            out.norm(),
                        ),
                        true,
                    ))
                }),
                is_round: true,
                size: 8.0,
            }
        }
        _ => net(r, w, &f),
    }
}

pub(super) fn net(r: &mut Random, w: &mut Writer, f: &Frame) -> Patch {
    let degrees = [1 + r.below(4), 1 + r.below(4)];
    let spans = [1 + r.below(3), 1 + r.below(3)];
    let breaks = spans.map(|n| {
        let mut all = vec![r.range(-1.0, 1.0)];
        for _ in 0..n {
            all.push(all.last().unwrap() + r.range(0.3, 1.5));
        }
        all
    });
    let knots = [0, 1].map(|c| {
        let (b, p) = (&breaks[c], degrees[c]);
        let mut k = vec![b[0]; p + 1];
        k.extend(&b[1..b.len() - 1]);
        k.extend(vec![b[b.len() - 1]; p + 1]);
        k
    });
    let counts = [0, 1].map(|c| knots[c].len() - 1 - degrees[c]);
    let spread: f64 = if r.chance(0.5) { 1.0 } else { 2.0 };
    let wave = r.range(0.0, 1.0);
    let mut points = Vec::new();
    let mut weights = Vec::new();
    for i in 0..counts[0] {
        for j in 0..counts[1] {
            let [x, y] = [
                4.0 * i as f64 / (counts[0] - 1) as f64,
                3.0 * j as f64 / (counts[1] - 1) as f64,
            ];
            let z = wave * ((1.3 * x).sin() + (x * y * 0.4).cos());
            points.push(f.at(x + r.range(-0.2, 0.2), y + r.range(-0.2, 0.2), z));
            weights.push(if spread > 1.0 {
                spread.powf(r.range(-1.0, 1.0))
            } else {
                1.0
            });
        }
    }
    let rows: Vec<String> = { points.chunks(counts[1]) }
        .map(|row| {
            let row: Vec<String> = row.iter().map(|p| w.point((*p).into())).collect();
            format!("({})", row.join(","))
        })
        .collect();
    let rows = rows.join(",");
    let m = [0, 1].map(|c| {
        let last = breaks[c].len() - 1;
        let each: Vec<String> = (0..=last)
            .map(|k| {
                if k == 0 || k == last {
                    degrees[c] + 1
                } else {
                    1
                }
                .to_string()
            })
            .collect();
        each.join(",")
    });
    let [p, q] = degrees;
    let (ku, kv) = (list(&breaks[0]), list(&breaks[1]));
    let surface = if spread > 1.0 {
        let rows_w: Vec<String> = { weights.chunks(counts[1]) }
            .map(|c| format!("({})", list(c)))
            .collect();
        w.put(format!(
            "(BOUNDED_SURFACE()B_SPLINE_SURFACE({p},{q},({rows}),.UNSPECIFIED.,.F.,.F.,.F.)\
             B_SPLINE_SURFACE_WITH_KNOTS(({}),({}),({ku}),({kv}),.UNSPECIFIED.)GEOMETRIC_REPRESENTATION_ITEM()\
             RATIONAL_B_SPLINE_SURFACE(({}))REPRESENTATION_ITEM('')SURFACE())",
            m[0], m[1], rows_w.join(",")
        ))
    } else {
        w.put(format!(
            "B_SPLINE_SURFACE_WITH_KNOTS('',{p},{q},({rows}),.UNSPECIFIED.,.F.,.F.,.F.,({}),({}),({ku}),({kv}),.UNSPECIFIED.)",
            m[0], m[1]
        ))
    };
    let at = move |u: f64, v: f64| {
        let (a, b) = (basis(&knots[0], p, u), basis(&knots[1], q, v));
        let (mut sum, mut all) = (V::zeros(), 0.0);
        for i in 0..counts[0] {
            for j in 0..counts[1] {
                let own = a[i] * b[j] * weights[i * counts[1] + j];
                sum += points[i * counts[1] + j] * own;
                all += own;
            }
        }
        sum / all
    };
    let inner = |r: &mut Random, c: usize| {
        let (a, b) = (breaks[c][0], *breaks[c].last().unwrap());
        if r.chance(0.5) {
            [a, b]
        } else {
            [a + 0.1 * (b - a), b - 0.15 * (b - a)]
        }
    };
    Patch {
        name: "net",
        surface,
        at: Box::new(at),
        uv: [inner(r, 0), inner(r, 1)],
        along_v: Box::new(|_| None),
        along_u: Box::new(|_| None),
        is_round: false,
        size: 5.0,
    }
}

/// An edge between two places of a patch.
#[allow(clippy::too_many_arguments)]
pub(super) fn side(
    r: &mut Random,
    w: &mut Writer,
    p: &Patch,
    [a, b]: [[f64; 2]; 2],
    vertices: [&str; 2],
    off: f64,
    can_bulge: bool,
) -> (String, bool) {
    let middle = (p.at)(0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]));
    let nudge = Nudge {
        about: middle,
        turn: if r.chance(0.5) {
            r.unit() * off / p.size
        } else {
            V::zeros()
        },
        by: if r.chance(0.5) {
            r.unit() * off
        } else {
            V::zeros()
        },
    };
    if r.chance(0.5) {
        let natural = if a[0] == b[0] {
            (p.along_v)(a[0])
        } else {
            (p.along_u)(a[1])
        };
        if let Some((shape, with)) = natural {
            let grows = if a[0] == b[0] {
                a[1] < b[1]
            } else {
                a[0] < b[0]
            };
            let entity = shape.nudged(&nudge).put(w);
            let [from, to] = vertices;
            // The entity runs with the parameter.
            return if with == grows {
                (w.edge(from, to, &entity), true)
            } else {
                (w.edge(to, from, &entity), false)
            };
        }
    }
    let bulge = if can_bulge && r.chance(0.6) {
        r.range(-0.15, 0.15)
    } else {
        0.0
    };
    let lengths = [0, 1].map(|c| p.uv[c][1] - p.uv[c][0]);
    let uneven = r.range(-0.4, 0.4);
    let across = if a[0] == b[0] {
        [bulge * lengths[0], 0.0]
    } else {
        [0.0, bulge * lengths[1]]
    };
    let path = |s: f64| {
        let s = s + uneven * s * (1.0 - s);
        let by = (PI * s).sin();
        let uv = [0, 1].map(|c| if s == 1.0 { b[c] } else { a[c] + (b[c] - a[c]) * s } + across[c] * by);
        (p.at)(uv[0], uv[1])
    };
    let degree = 1 + r.below(9);
    // A chord is too far off.
    let pieces = if degree < 4 {
        40 + r.below(100)
    } else {
        3 + r.below(12)
    };
    let pieces = if degree == 1 { 400 } else { pieces };
    let spread = if degree < 6 && r.chance(0.35) {
        r.magnitude(0.1, 1.0)
    } else {
        1.0
    };
    let spline = Spline::through(r, &path, degree, pieces, spread).nudged(&nudge);
    let entity = spline.put(w);
    (w.edge(vertices[0], vertices[1], &entity), true)
}

/// A face of four sides.
pub(super) fn quad(
    r: &mut Random,
    w: &mut Writer,
    kind: usize,
    off: f64,
    far: f64,
) -> &'static str {
    let p = patch(r, w, kind, far);
    let [[u0, u1], [v0, v1]] = p.uv;
    let corners = [[u0, v0], [u1, v0], [u1, v1], [u0, v1]];
    let vertices = corners.map(|[u, v]| w.vertex((p.at)(u, v).into()));
    // On a B-spline nothing goes beyond its ends.
    let can_bulge = p.name != "net";
    let edges: Vec<(String, bool)> = (0..4)
        .map(|k| {
            let n = (k + 1) % 4;
            let ends = [&vertices[k][..], &vertices[n][..]];
            side(r, w, &p, [corners[k], corners[n]], ends, off, can_bulge)
        })
        .collect();
    let uses: Vec<_> = edges.iter().map(|(e, s)| (&e[..], *s)).collect();
    let bound = w.bound(&uses);
    let face = w.face(&p.surface, &[bound]);
    w.sheet(&[face]);
    p.name
}

/// A face that goes around, between two rims, and discs in these.
pub(super) fn band(
    r: &mut Random,
    w: &mut Writer,
    kind: usize,
    off: f64,
    far: f64,
) -> &'static str {
    let p = patch(r, w, kind, far);
    assert!(p.is_round);
    let mut faces = Vec::new();
    let mut bounds = Vec::new();
    let start = r.range(0.0, TAU);
    for (k, v) in p.uv[1].into_iter().enumerate() {
        let (circle, _) = (p.along_u)(v).unwrap();
        let nudge = Nudge {
            about: (p.at)(0.0, v),
            turn: if r.chance(0.5) {
                r.unit() * off / p.size
            } else {
                V::zeros()
            },
            by: if r.chance(0.5) {
                r.unit() * off
            } else {
                V::zeros()
            },
        };
        let from = if r.chance(0.5) {
            start
        } else {
            r.range(0.0, TAU)
        };
        let shape = match r.below(3) {
            0 => {
                let path = |s: f64| (p.at)(if s == 1.0 { from } else { from + TAU * s }, v);
                let degree = 3 + r.below(5);
                let (pieces, spread) = (6 + r.below(20), if r.chance(0.3) { 2.0 } else { 1.0 });
                let pieces = if degree < 5 { 3 * pieces } else { pieces };
                Shape::Spline(Spline::through(r, &path, degree, pieces, spread))
            }
            1 => circle.clone(),
            _ => match circle.clone() {
                Shape::Circle(f, radius) => {
                    Shape::Ellipse(f, [radius * (1.0 + 0.5 * off / p.size), radius])
                }
                other => other,
            },
        };
        let shape = shape.nudged(&nudge);
        let start = match &shape {
            Shape::Spline(s) => s.points[0],
            other => other.point(from),
        };
        let vertex = w.vertex(start.into());
        let entity = shape.put(w);
        let edge = w.edge(&vertex, &vertex, &entity);
        bounds.push(w.bound(&[(&edge, k == 0)]));
        if r.chance(0.5)
            && let Shape::Circle(f, _) = &circle
        {
            let nudge = Nudge {
                about: f.o,
                turn: r.unit() * off / p.size,
                by: V::zeros(),
            };
            let g = nudge.frame(f);
            let z = if k == 0 { -g.z } else { g.z };
            let axes = w.axes(g.o.into(), z.into(), g.x.into());
            let plane = w.put(format!("PLANE('',{axes})"));
            let bound = w.bound(&[(&edge, k == 1)]);
            faces.push(w.face(&plane, &[bound]));
        }
    }
    faces.push(w.face(&p.surface, &bounds));
    w.sheet(&faces);
    p.name
}
