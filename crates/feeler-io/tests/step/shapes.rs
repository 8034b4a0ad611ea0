//! Curves as a file names them, with their points by definition.

use super::{Random, Writer};
use nalgebra::{DMatrix, Vector3};
use std::f64::consts::PI;

pub(super) type V = Vector3<f64>;

impl Random {
    pub(super) fn range(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.next()
    }

    pub(super) fn below(&mut self, n: usize) -> usize {
        ((self.next() * n as f64) as usize).min(n - 1)
    }

    pub(super) fn chance(&mut self, p: f64) -> bool {
        self.next() < p
    }

    pub(super) fn unit(&mut self) -> V {
        loop {
            let v = self.within(1.0).coords;
            if v.norm() > 0.1 && v.norm() < 1.0 {
                return v.normalize();
            }
        }
    }

    /// A magnitude from 10^a to 10^b.
    pub(super) fn magnitude(&mut self, a: f64, b: f64) -> f64 {
        10f64.powf(self.range(a, b))
    }
}

/// A right-handed frame.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub(super) o: V,
    pub(super) x: V,
    pub(super) y: V,
    pub(super) z: V,
}

impl Frame {
    pub(super) fn random(r: &mut Random, far: f64) -> Self {
        let z = r.unit();
        let x = loop {
            let v = r.unit();
            let x = v - z * v.dot(&z);
            if x.norm() > 0.2 {
                break x.normalize();
            }
        };
        let y = z.cross(&x);
        let o = r.within(far).coords;
        Self { o, x, y, z }
    }

    pub(super) fn at(&self, x: f64, y: f64, z: f64) -> V {
        self.o + self.x * x + self.y * y + self.z * z
    }

    pub(super) fn turned(&self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self {
            x: self.x * cos + self.y * sin,
            y: self.y * cos - self.x * sin,
            ..*self
        }
    }
}

/// A small motion about a place.
#[derive(Clone, Copy)]
pub(super) struct Nudge {
    pub(super) about: V,
    pub(super) turn: V,
    pub(super) by: V,
}

impl Nudge {
    pub(super) fn point(&self, p: V) -> V {
        let d = p - self.about;
        self.vector(d) + self.about + self.by
    }

    pub(super) fn vector(&self, v: V) -> V {
        v + self.turn.cross(&v)
    }

    pub(super) fn frame(&self, f: &Frame) -> Frame {
        let z = self.vector(f.z).normalize();
        let x = self.vector(f.x);
        let x = (x - z * x.dot(&z)).normalize();
        Frame {
            o: self.point(f.o),
            x,
            y: z.cross(&x),
            z,
        }
    }
}

#[derive(Clone)]
pub(super) struct Spline {
    pub(super) degree: usize,
    /// Breaks, and how often each inner one counts.
    pub(super) breaks: Vec<f64>,
    pub(super) multiplicity: usize,
    pub(super) points: Vec<V>,
    pub(super) weights: Option<Vec<f64>>,
}

pub(super) fn bernstein(p: usize, t: f64) -> Vec<f64> {
    let mut b = vec![1.0];
    for k in 1..=p {
        let mut next = vec![0.0; k + 1];
        for (i, x) in b.iter().enumerate() {
            next[i] += x * (1.0 - t);
            next[i + 1] += x * t;
        }
        b = next;
    }
    b
}

impl Spline {
    /// Through points of a path, piece by piece, with these weights.
    pub(super) fn through(
        r: &mut Random,
        path: &dyn Fn(f64) -> V,
        degree: usize,
        pieces: usize,
        spread: f64,
    ) -> Self {
        let mut points = vec![path(0.0)];
        let mut weights = vec![1.0];
        let mut breaks = vec![0.0];
        let lengths: Vec<f64> = (0..pieces).map(|_| r.range(0.5, 1.5)).collect();
        let sum: f64 = lengths.iter().sum();
        let mut from = 0.0;
        for (k, l) in lengths.iter().enumerate() {
            let to = if k + 1 == pieces { 1.0 } else { from + l / sum };
            let mut w = vec![1.0];
            w.extend((1..degree).map(|_| {
                if spread > 1.0 {
                    spread.powf(r.range(-1.0, 1.0))
                } else {
                    1.0
                }
            }));
            w.push(1.0);
            let nodes: Vec<f64> = (0..=degree)
                .map(|j| 0.5 - 0.5 * (PI * j as f64 / degree as f64).cos())
                .collect();
            let m = DMatrix::from_fn(degree + 1, degree + 1, |j, i| {
                bernstein(degree, nodes[j])[i]
            });
            let rhs = DMatrix::from_fn(degree + 1, 3, |j, c| {
                let b = bernstein(degree, nodes[j]);
                let total: f64 = b.iter().zip(&w).map(|(b, w)| b * w).sum();
                let s = if j == degree {
                    to
                } else {
                    from + (to - from) * nodes[j]
                };
                total * path(s)[c]
            });
            let own = m.lu().solve(&rhs).expect("nodes that differ");
            for i in 1..=degree {
                let p = if i == degree {
                    path(to)
                } else {
                    V::new(own[(i, 0)], own[(i, 1)], own[(i, 2)]) / w[i]
                };
                points.push(p);
                weights.push(w[i]);
            }
            breaks.push(to);
            from = to;
        }
        // Another parameter.
        let (a, b) = (r.range(-3.0, 3.0), r.magnitude(-1.0, 2.0));
        let breaks = breaks.iter().map(|t| a + b * t).collect();
        Self {
            degree,
            breaks,
            multiplicity: degree,
            points,
            weights: (spread > 1.0).then_some(weights),
        }
    }

    pub(super) fn nudged(&self, n: &Nudge) -> Self {
        let points = self.points.iter().map(|p| n.point(*p)).collect();
        Self {
            points,
            ..self.clone()
        }
    }

    pub(super) fn knots(&self) -> Vec<f64> {
        let last = self.breaks.len() - 1;
        let times = |k: usize| {
            if k == 0 || k == last {
                self.degree + 1
            } else {
                self.multiplicity
            }
        };
        let all = self.breaks.iter().enumerate();
        all.flat_map(|(k, t)| vec![*t; times(k)]).collect()
    }

    pub(super) fn point(&self, t: f64) -> V {
        let b = basis(&self.knots(), self.degree, t);
        let one = vec![1.0; self.points.len()];
        let w = self.weights.as_ref().unwrap_or(&one);
        let (mut sum, mut all) = (V::zeros(), 0.0);
        for (i, b) in b.iter().enumerate() {
            sum += self.points[i] * (b * w[i]);
            all += b * w[i];
        }
        sum / all
    }

    pub(super) fn put(&self, w: &mut Writer) -> String {
        let points: Vec<String> = self.points.iter().map(|p| w.point((*p).into())).collect();
        let points = points.join(",");
        let last = self.breaks.len() - 1;
        let times = |k: usize| {
            if k == 0 || k == last {
                self.degree + 1
            } else {
                self.multiplicity
            }
        };
        let m: Vec<String> = (0..=last).map(|k| times(k).to_string()).collect();
        let m = m.join(",");
        let knots = list(&self.breaks);
        let p = self.degree;
        match &self.weights {
            None => w.put(format!(
                "B_SPLINE_CURVE_WITH_KNOTS('',{p},({points}),.UNSPECIFIED.,.F.,.F.,({m}),({knots}),.UNSPECIFIED.)"
            )),
            Some(weights) => w.put(format!(
                "(BOUNDED_CURVE()B_SPLINE_CURVE({p},({points}),.UNSPECIFIED.,.F.,.F.)\
                 B_SPLINE_CURVE_WITH_KNOTS(({m}),({knots}),.UNSPECIFIED.)CURVE()\
                 GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_CURVE(({}))REPRESENTATION_ITEM(''))",
                list(weights)
            )),
        }
    }
}

pub(super) fn list(all: &[f64]) -> String {
    let each: Vec<String> = all.iter().map(|x| format!("{x:?}")).collect();
    each.join(",")
}

/// All B-splines at a place, by the definition.
pub(super) fn basis(knots: &[f64], p: usize, t: f64) -> Vec<f64> {
    let n = knots.len() - 1 - p;
    let t = t.clamp(knots[p], knots[n]);
    let span = (p..n)
        .rev()
        .find(|k| knots[*k] <= t && knots[*k] < knots[k + 1])
        .unwrap();
    let mut b = vec![0.0; knots.len() - 1];
    b[span] = 1.0;
    for q in 1..=p {
        for i in 0..knots.len() - 1 - q {
            let part = |a: f64, c: f64| if c > 0.0 { a / c } else { 0.0 };
            b[i] = b[i] * part(t - knots[i], knots[i + q] - knots[i])
                + b[i + 1] * part(knots[i + q + 1] - t, knots[i + q + 1] - knots[i + 1]);
        }
    }
    b.truncate(n);
    b
}

/// A curve that a file names.
#[derive(Clone)]
pub(super) enum Shape {
    Line(V, V),
    Circle(Frame, f64),
    Ellipse(Frame, [f64; 2]),
    Parabola(Frame, f64),
    Hyperbola(Frame, [f64; 2]),
    Spline(Spline),
}

impl Shape {
    pub(super) fn nudged(&self, n: &Nudge) -> Self {
        match self {
            Self::Line(p, d) => Self::Line(n.point(*p), n.vector(*d)),
            Self::Circle(f, r) => Self::Circle(n.frame(f), *r),
            Self::Ellipse(f, r) => Self::Ellipse(n.frame(f), *r),
            Self::Parabola(f, r) => Self::Parabola(n.frame(f), *r),
            Self::Hyperbola(f, r) => Self::Hyperbola(n.frame(f), *r),
            Self::Spline(s) => Self::Spline(s.nudged(n)),
        }
    }

    pub(super) fn point(&self, t: f64) -> V {
        match self {
            Self::Line(p, d) => p + d * t,
            Self::Circle(f, r) => f.at(r * t.cos(), r * t.sin(), 0.0),
            Self::Ellipse(f, [a, b]) => f.at(a * t.cos(), b * t.sin(), 0.0),
            // With the file's parameter in units of the focal length, doubled.
            Self::Parabola(f, c) => f.at(t * t / (4.0 * c), t, 0.0),
            Self::Hyperbola(f, [a, b]) => f.at(a * t.cosh(), b * t.sinh(), 0.0),
            Self::Spline(s) => s.point(t),
        }
    }

    pub(super) fn put(&self, w: &mut Writer) -> String {
        let axes = |w: &mut Writer, f: &Frame| w.axes(f.o.into(), f.z.into(), f.x.into());
        match self {
            Self::Line(p, d) => {
                let (p, length) = (w.point((*p).into()), d.norm());
                let d = w.direction((d / length).into());
                let v = w.put(format!("VECTOR('',{d},{length:?})"));
                w.put(format!("LINE('',{p},{v})"))
            }
            Self::Circle(f, r) => {
                let a = axes(w, f);
                w.put(format!("CIRCLE('',{a},{r:?})"))
            }
            Self::Ellipse(f, [a, b]) => {
                let axes = axes(w, f);
                w.put(format!("ELLIPSE('',{axes},{a:?},{b:?})"))
            }
            Self::Parabola(f, c) => {
                let axes = axes(w, f);
                w.put(format!("PARABOLA('',{axes},{c:?})"))
            }
            Self::Hyperbola(f, [a, b]) => {
                let axes = axes(w, f);
                w.put(format!("HYPERBOLA('',{axes},{a:?},{b:?})"))
            }
            Self::Spline(s) => s.put(w),
        }
    }
}
