//! Curves and surfaces with first and second derivatives over whole intervals of their parameters.
//!
//! **Splines.** On a knot span, about the middle m of the interval, the basis functions are made by the recursion
//! of Cox and de Boor carried out on polynomials in x = t - m (The NURBS Book, section 2.2, each step a product
//! with a linear polynomial). With the control points they give the Taylor polynomial of the homogeneous spline at
//! m, which is the spline itself there. Over |x| <= h it differs from its value at m by at most the sum of
//! `|c_k| h^k`; likewise its derivatives. The polynomial goes on beyond the span, and so do these enclosures.
//!
//! **Quotients.** With the constant s about S(m) and Y = X - s W: W (S - s) = Y, W S_u = Y_u - (S - s) W_u, and so on, in
//! intervals. Y and S - s are of the order of h, so that a weight that varies costs h^2 only.
//!
//! **Native forms.** Rotation about an axis with sine and cosine enclosed; frames exactly normalised, X made
//! orthogonal to the axis exactly, as the crate `feeler` defines them.
//!
//! A surface's cells are its pairs of smooth pieces. Each is a closed box of parameters, and all of them cover
//! the domain.

use super::number::{Ball, Number, sin_cos};
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve, Curve3, KnotVector, NurbsCurve, NurbsSurface, Surface};
use nalgebra::SVector;

/// A point of a curve, first and second derivative.
#[derive(Clone, Debug)]
pub(crate) struct CurveJet<N, const D: usize> {
    pub(crate) p: [N; D],
    pub(crate) d: [N; D],
    pub(crate) dd: [N; D],
}

/// A point of a surface, first and second derivatives.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceJet<N> {
    pub(crate) p: [N; 3],
    pub(crate) u: [N; 3],
    pub(crate) v: [N; 3],
    pub(crate) uu: [N; 3],
    pub(crate) uv: [N; 3],
    pub(crate) vv: [N; 3],
}

fn map<N, const D: usize>(f: impl FnMut(usize) -> N) -> [N; D] {
    std::array::from_fn(f)
}

pub(crate) fn dot<N: Number, const D: usize>(a: &[N; D], b: &[N; D]) -> N {
    let mut all = a[0].times(&b[0]);
    for c in 1..D {
        all = all.plus(&a[c].times(&b[c]));
    }
    all
}

fn cross<N: Number>(a: &[N; 3], b: &[N; 3]) -> [N; 3] {
    map(|c| {
        let (i, j) = ((c + 1) % 3, (c + 2) % 3);
        a[i].times(&b[j]).minus(&a[j].times(&b[i]))
    })
}

pub(crate) fn sum<N: Number, const D: usize>(a: &[N; D], b: &[N; D]) -> [N; D] {
    map(|c| a[c].plus(&b[c]))
}

fn scaled<N: Number, const D: usize>(a: &[N; D], s: &N) -> [N; D] {
    map(|c| a[c].times(s))
}

fn of<N: Number, const D: usize>(a: &[Ball; D]) -> [N; D] {
    map(|c| N::of(&a[c]))
}

fn hulls<N: Number, const D: usize>(a: &[N; D], b: &[N; D]) -> [N; D] {
    map(|c| a[c].hull(&b[c]))
}

impl<N: Number, const D: usize> CurveJet<N, D> {
    /// Derivatives with respect to x, where t = t0 + k x.
    fn chained(self, k: &N) -> Self {
        let kk = k.squared();
        Self {
            d: scaled(&self.d, k),
            dd: scaled(&self.dd, &kk),
            p: self.p,
        }
    }
}

impl<N: Number> SurfaceJet<N> {
    pub(crate) fn hull(&self, o: &Self) -> Self {
        Self {
            p: hulls(&self.p, &o.p),
            u: hulls(&self.u, &o.u),
            v: hulls(&self.v, &o.v),
            uu: hulls(&self.uu, &o.uu),
            uv: hulls(&self.uv, &o.uv),
            vv: hulls(&self.vv, &o.vv),
        }
    }
}

/// The basis functions that are not 0 on span `span`, as Taylor polynomials at `m`: `[j][k]` is the
/// coefficient of (t - m)^k of number `span - p + j`.
fn basis<N: Number>(knots: &KnotVector, span: usize, m: &N) -> Vec<Vec<N>> {
    let t = knots.knots();
    let mut previous = vec![vec![N::exact(1.0)]];
    for d in 1..=knots.degree() {
        let mut next = vec![vec![N::zero(); d + 1]; d + 1];
        for (i, old) in previous.iter().enumerate() {
            // N_{j, d-1}, with j from span - d + 1 on.
            let j = span + 1 + i - d;
            let (low, high) = (N::exact(t[j]), N::exact(t[j + d]));
            let width = high.minus(&low);
            // The width is at least that of the span: not 0. At a knot the quotients hold 0 and 1.
            let by = |n: &N| n.over(&width).unwrap_or_else(N::zero);
            let (rise, fall) = (by(&m.minus(&low)), by(&high.minus(m)));
            let slope = by(&N::exact(1.0));
            for (k, c) in old.iter().enumerate() {
                let w = slope.times(c);
                next[i + 1][k] = next[i + 1][k].plus(&rise.times(c));
                next[i + 1][k + 1] = next[i + 1][k + 1].plus(&w);
                next[i][k] = next[i][k].plus(&fall.times(c));
                next[i][k + 1] = next[i][k + 1].minus(&w);
            }
        }
        previous = next;
    }
    previous
}

/// Powers of h, rounded up.
fn powers(h: f64, n: usize) -> Vec<f64> {
    let mut all = vec![1.0];
    for k in 0..n {
        let next = if h == 0.0 {
            0.0
        } else {
            (all[k] * h).next_up()
        };
        all.push(next);
    }
    all
}

/// Makes up for the roundings of a sum of up to 1000 products of six factors.
const UP: f64 = 1.0 + 2048.0 * f64::EPSILON;

/// `k!/(k-d)!`: the factor of a coefficient in the d-th derivative.
fn falling(k: usize, d: usize) -> f64 {
    (0..d).map(|i| (k - i) as f64).product()
}

/// The d-th derivative of the polynomial over `|x| <= h`.
fn over_interval<N: Number>(c: &[N], d: usize, h: &[f64]) -> N {
    if c.len() <= d {
        return N::zero();
    }
    let mut rest = 0.0;
    if h[1] > 0.0 {
        for k in d + 1..c.len() {
            rest += falling(k, d) * c[k].magnitude() * h[k - d];
        }
    }
    let middle = c[d].times(&N::exact(falling(d, d)));
    if rest == 0.0 {
        middle
    } else {
        middle.widened(rest * UP + f64::MIN_POSITIVE)
    }
}

fn spline_curve<N: Number, const D: usize, const H: usize>(
    curve: &NurbsCurve<H>,
    span: usize,
    constant: &[Option<f64>; D],
    t: &N,
) -> Option<CurveJet<N, D>> {
    let p = curve.degree();
    let b = basis(curve.knots(), span, &t.middle());
    let h = powers(t.radius(), p);
    let points = &curve.control_points()[span - p..=span];
    let taylor = |c: usize| -> Vec<N> {
        let mut all = vec![N::zero(); p + 1];
        for (j, point) in points.iter().enumerate() {
            let x = N::exact(point[c]);
            for k in 0..=p {
                all[k] = all[k].plus(&b[j][k].times(&x));
            }
        }
        all
    };
    let weights = taylor(H - 1);
    let w: [N; 3] = map(|d| over_interval(&weights, d, &h));
    let two = N::exact(2.0);
    let mut jet = CurveJet {
        p: map(|_| N::zero()),
        d: map(|_| N::zero()),
        dd: map(|_| N::zero()),
    };
    for c in 0..D {
        if let Some(x) = constant[c] {
            jet.p[c] = N::exact(x);
            continue;
        }
        let x = taylor(c);
        let start = x[0].over(&weights[0])?.middle();
        let moved: Vec<N> = (0..=p)
            .map(|k| x[k].minus(&start.times(&weights[k])))
            .collect();
        let x: [N; 3] = map(|d| over_interval(&moved, d, &h));
        let off = x[0].over(&w[0])?;
        jet.d[c] = x[1].minus(&off.times(&w[1])).over(&w[0])?;
        jet.dd[c] = x[2]
            .minus(&two.times(&jet.d[c]).times(&w[1]))
            .minus(&off.times(&w[2]))
            .over(&w[0])?;
        jet.p[c] = start.plus(&off);
    }
    Some(jet)
}

/// What the x coordinate of all points is exactly, if they share one.
fn constant_of<const H: usize>(points: &[SVector<f64, H>], c: usize) -> Option<f64> {
    let first = &points[0];
    let product = |a: f64, b: f64| Ball::exact(a).times(&Ball::exact(b)).center();
    let value = first[c] / first[H - 1];
    (value.is_finite()
        && product(value, first[H - 1]) == product(first[c], 1.0)
        && points
            .iter()
            .all(|p| product(value, p[H - 1]) == product(p[c], 1.0)))
    .then_some(value)
}

/// A smooth curve over its own parameter.
#[derive(Clone, Debug)]
enum Smooth<'a, const D: usize, const H: usize> {
    /// From one point to the other, over an interval.
    Segment([Ball; D], [Ball; D], Interval),
    /// `center + radius (cos x + sin y)`.
    Circle {
        center: [Ball; D],
        x: [Ball; D],
        y: [Ball; D],
        angle: Interval,
        domain: Interval,
    },
    Spline(&'a NurbsCurve<H>, usize, [Option<f64>; D]),
}

/// A smooth piece of a curve over a parameter x that goes linearly with the curve's own.
#[derive(Clone, Debug)]
pub(crate) struct Piece<'a, const D: usize, const H: usize> {
    smooth: Smooth<'a, D, H>,
    /// t = t0 + k (x - x0).
    x0: Ball,
    t0: Ball,
    k: Ball,
    /// The range of x.
    pub(crate) from: Ball,
    pub(crate) to: Ball,
}

fn point<const D: usize>(p: &nalgebra::Point<f64, D>) -> [Ball; D] {
    map(|c| Ball::exact(p[c]))
}

fn normalised<const D: usize>(a: &[Ball; D]) -> [Ball; D] {
    let length = dot(a, a).root();
    map(|c| {
        a[c].over(&length)
            .unwrap_or_else(|| Ball::about_zero(f64::INFINITY))
    })
}

fn circle<const D: usize, const H: usize>(arc: &Arc<D>) -> Smooth<'static, D, H> {
    let exact = |v: &SVector<f64, D>| -> [Ball; D] { map(|c| Ball::exact(v[c])) };
    let r = Ball::exact(arc.radius);
    let (x, y): ([Ball; D], [Ball; D]) = if D == 3 {
        let three = |v: [Ball; D]| -> [Ball; 3] { map(|c| v[c].clone()) };
        let (x, z) = (three(exact(&arc.x)), three(exact(&arc.z)));
        // x |z|^2 - (x.z) z has the direction of the part of x at right angles to z.
        let (zz, xz) = (dot(&z, &z), dot(&x, &z));
        let across: [Ball; 3] = map(|c| x[c].times(&zz).minus(&z[c].times(&xz)));
        let (x, z) = (normalised(&across), normalised(&z));
        let y = cross(&z, &x);
        (map(|c| x[c].clone()), map(|c| y[c].clone()))
    } else {
        let x = normalised(&exact(&arc.x));
        let (a, b) = (exact(&arc.x), exact(&arc.y));
        let turn = a[0].times(&b[1]).minus(&a[1].times(&b[0]));
        let left = [x[1].negated(), x[0].clone()];
        let y = if turn.is_negative() {
            [left[0].negated(), left[1].negated()]
        } else {
            left
        };
        (x, map(|c| y[c].clone()))
    };
    Smooth::Circle {
        center: point(&arc.center),
        x: scaled(&x, &r),
        y: scaled(&y, &r),
        angle: arc.angle,
        domain: arc.domain,
    }
}

/// `a0 + (t - t0) (a1 - a0) / (t1 - t0)`, and its derivative.
fn linear<N: Number>(t: &N, domain: Interval, range: Interval) -> Option<(N, N)> {
    let e = |x| N::exact(x);
    if domain == range {
        return Some((t.clone(), e(1.0)));
    }
    let k = e(range.end)
        .minus(&e(range.start))
        .over(&e(domain.end).minus(&e(domain.start)))?;
    Some((e(range.start).plus(&t.minus(&e(domain.start)).times(&k)), k))
}

impl<const D: usize, const H: usize> Smooth<'_, D, H> {
    fn jet<N: Number>(&self, t: &N) -> Option<CurveJet<N, D>> {
        match self {
            Self::Segment(a, b, domain) => {
                let unit = Interval {
                    start: 0.0,
                    end: 1.0,
                };
                let (s, k) = linear(t, *domain, unit)?;
                let (a, b): ([N; D], [N; D]) = (of(a), of(b));
                let along: [N; D] = map(|c| b[c].minus(&a[c]));
                Some(CurveJet {
                    p: sum(&a, &scaled(&along, &s)),
                    d: scaled(&along, &k),
                    dd: map(|_| N::zero()),
                })
            }
            Self::Circle {
                center,
                x,
                y,
                angle,
                domain,
            } => {
                let (a, k) = linear(t, *domain, *angle)?;
                let (sin, cos) = sin_cos(&a);
                let (x, y): ([N; D], [N; D]) = (of(x), of(y));
                let out = sum(&scaled(&x, &cos), &scaled(&y, &sin));
                let along: [N; D] = map(|c| y[c].times(&cos).minus(&x[c].times(&sin)));
                Some(CurveJet {
                    p: sum(&of(center), &out),
                    d: scaled(&along, &k),
                    dd: scaled(&out, &k.squared().negated()),
                })
            }
            Self::Spline(curve, span, constant) => spline_curve(curve, *span, constant, t),
        }
    }
}

impl<'a, const D: usize, const H: usize> Piece<'a, D, H> {
    /// The curve over the interval `x` of this piece's parameter (it goes on beyond its ends).
    pub(crate) fn jet<N: Number>(&self, x: &N) -> Option<CurveJet<N, D>> {
        let k = N::of(&self.k);
        let t = N::of(&self.t0).plus(&x.minus(&N::of(&self.x0)).times(&k));
        Some(self.smooth.jet(&t)?.chained(&k))
    }

    /// The straight piece between two points, over [0, 1].
    pub(crate) fn segment(a: [Ball; D], b: [Ball; D]) -> Self {
        let unit = Interval {
            start: 0.0,
            end: 1.0,
        };
        Self {
            smooth: Smooth::Segment(a, b, unit),
            x0: Ball::exact(0.0),
            t0: Ball::exact(0.0),
            k: Ball::exact(1.0),
            from: Ball::exact(0.0),
            to: Ball::exact(1.0),
        }
    }

    /// Whether all of it is proven to lie between two numbers along coordinate `c`: by its ends, or by the
    /// control points, of whose convex hull a spline never leaves.
    pub(crate) fn within(&self, c: usize, range: Interval) -> bool {
        let (low, high) = (Ball::exact(range.start), Ball::exact(range.end));
        let between = |x: &Ball, w: &Ball| {
            !x.lower().below(&low.times(w)) && !high.times(w).below(&x.upper())
        };
        match &self.smooth {
            Smooth::Segment(a, b, _) => {
                let one = Ball::exact(1.0);
                between(&a[c], &one) && between(&b[c], &one)
            }
            Smooth::Circle { .. } => false,
            Smooth::Spline(s, span, _) => s.control_points()[span - s.degree()..=*span]
                .iter()
                .all(|p| between(&Ball::exact(p[c]), &Ball::exact(p[H - 1]))),
        }
    }

    /// The same over [0, 1], perhaps backwards.
    pub(crate) fn over_unit(self, reversed: bool) -> Self {
        let (a, b) = if reversed {
            (&self.to, &self.from)
        } else {
            (&self.from, &self.to)
        };
        let at = |x: &Ball| self.t0.plus(&x.minus(&self.x0).times(&self.k));
        let (t0, t1) = (at(a), at(b));
        Self {
            x0: Ball::exact(0.0),
            k: t1.minus(&t0),
            t0,
            from: Ball::exact(0.0),
            to: Ball::exact(1.0),
            smooth: self.smooth,
        }
    }
}

/// The smooth pieces, in order, of a curve that is no poly-curve, each over the curve's own parameter.
fn smooth_pieces<const D: usize, const H: usize>(
    curve: &Curve<D, H>,
) -> Vec<(Smooth<'_, D, H>, Interval)> {
    match curve {
        Curve::Line(c) => {
            vec![(
                Smooth::Segment(point(&c.from), point(&c.to), c.domain),
                c.domain,
            )]
        }
        Curve::Arc(c) => vec![(circle(c), c.domain)],
        Curve::Polyline(c) => (0..c.points().len() - 1)
            .map(|i| {
                let on = Interval {
                    start: c.params()[i],
                    end: c.params()[i + 1],
                };
                let (a, b) = (point(&c.points()[i]), point(&c.points()[i + 1]));
                (Smooth::Segment(a, b, on), on)
            })
            .collect(),
        Curve::Nurbs(c) => {
            let p = c.degree();
            c.knots()
                .spans()
                .map(|(span, start, end)| {
                    let points = &c.control_points()[span - p..=span];
                    let constant = map(|k| constant_of(points, k));
                    (Smooth::Spline(c, span, constant), Interval { start, end })
                })
                .collect()
        }
        Curve::Poly(_) => Vec::new(),
    }
}

/// The smooth pieces of the part `span` of a curve, each over the curve's parameter.
pub(crate) fn pieces<'a, const D: usize, const H: usize>(
    curve: &'a Curve<D, H>,
    span: Interval,
) -> Vec<Piece<'a, D, H>> {
    let mut all = Vec::new();
    let (start, end) = (Ball::exact(span.start), Ball::exact(span.end));
    let mut add = |smooth: Smooth<'a, D, H>, from: Ball, to: Ball, x0: Ball, t0: Ball, k: Ball| {
        // Cut to the span: a piece that meets it in a point alone adds nothing.
        let from = if from.below(&start) {
            start.clone()
        } else {
            from
        };
        let to = if end.below(&to) { end.clone() } else { to };
        if from.below(&to) {
            all.push((smooth, from, to, x0, t0, k));
        }
    };
    let zero = Ball::exact(0.0);
    if let Curve::Poly(c) = curve {
        for (segment, w) in c.segments().iter().zip(c.params().windows(2)) {
            let own = segment.domain();
            let (x0, x1) = (Ball::exact(w[0]), Ball::exact(w[1]));
            let (t0, t1) = (Ball::exact(own.start), Ball::exact(own.end));
            let Some(k) = t1.minus(&t0).over(&x1.minus(&x0)) else {
                continue;
            };
            let Some(back) = x1.minus(&x0).over(&t1.minus(&t0)) else {
                continue;
            };
            for (smooth, on) in smooth_pieces(segment) {
                let x = |t: f64| {
                    if t == own.start {
                        x0.clone()
                    } else if t == own.end {
                        x1.clone()
                    } else {
                        x0.plus(&Ball::exact(t).minus(&t0).times(&back))
                    }
                };
                add(
                    smooth,
                    x(on.start),
                    x(on.end),
                    x0.clone(),
                    t0.clone(),
                    k.clone(),
                );
            }
        }
    } else {
        for (smooth, on) in smooth_pieces(curve) {
            add(
                smooth,
                Ball::exact(on.start),
                Ball::exact(on.end),
                zero.clone(),
                zero.clone(),
                Ball::exact(1.0),
            );
        }
    }
    all.into_iter()
        .map(|(smooth, from, to, x0, t0, k)| Piece {
            smooth,
            x0,
            t0,
            k,
            from,
            to,
        })
        .collect()
}

/// One of a surface's smooth ranges along u or v.
#[derive(Clone, Debug)]
pub(crate) struct Range<'a> {
    pub(crate) from: Ball,
    pub(crate) to: Ball,
    kind: RangeKind<'a>,
}

#[derive(Clone, Debug)]
enum RangeKind<'a> {
    Span(usize),
    Straight,
    Angle,
    Profile(Box<Piece<'a, 3, 4>>),
}

#[derive(Clone, Debug)]
enum Form<'a> {
    Nurbs(&'a NurbsSurface),
    Plane {
        origin: [Ball; 3],
        axes: [[Ball; 3]; 2],
        domain: [Interval; 2],
        extents: [Interval; 2],
    },
    Turned {
        origin: [Ball; 3],
        axis: [Ball; 3],
        angle: Interval,
        domain: Interval,
        transposed: bool,
    },
    Sum([Ball; 3]),
}

/// A surface in smooth cells.
#[derive(Clone, Debug)]
pub(crate) struct Shape<'a> {
    form: Form<'a>,
    /// Along u and along v.
    pub(crate) ranges: [Vec<Range<'a>>; 2],
    pub(crate) domain: [Interval; 2],
    /// Knot lines inside the domain across which the tangent plane may break, along u and v.
    pub(crate) creases: [Vec<Ball>; 2],
}

fn profile(curve: &Curve3) -> Vec<Range<'_>> {
    pieces(curve, curve.domain())
        .into_iter()
        .map(|p| Range {
            from: p.from.clone(),
            to: p.to.clone(),
            kind: RangeKind::Profile(Box::new(p)),
        })
        .collect()
}

fn simple<'a>(domain: Interval, kind: RangeKind<'a>) -> Vec<Range<'a>> {
    vec![Range {
        from: Ball::exact(domain.start),
        to: Ball::exact(domain.end),
        kind,
    }]
}

fn spans<'a>(knots: &KnotVector) -> Vec<Range<'a>> {
    knots
        .spans()
        .map(|(i, a, b)| Range {
            from: Ball::exact(a),
            to: Ball::exact(b),
            kind: RangeKind::Span(i),
        })
        .collect()
}

fn sharp_knots(knots: &KnotVector) -> Vec<Ball> {
    let p = knots.degree();
    let all = knots.knots();
    let domain = knots.domain();
    let mut found: Vec<f64> = Vec::new();
    for k in all {
        let inside = domain.start < *k && *k < domain.end;
        let multiplicity = all.iter().filter(|x| *x == k).count();
        if inside && multiplicity >= p && found.last() != Some(k) {
            found.push(*k);
        }
    }
    found.into_iter().map(Ball::exact).collect()
}

fn breaks(ranges: &[Range<'_>]) -> Vec<Ball> {
    ranges.iter().skip(1).map(|r| r.from.clone()).collect()
}

impl<'a> Shape<'a> {
    pub(crate) fn new(surface: &'a Surface) -> Self {
        let domain = surface.domain();
        let vector = |v: &nalgebra::Vector3<f64>| -> [Ball; 3] { map(|c| Ball::exact(v[c])) };
        let (form, ranges) = match surface {
            Surface::Nurbs(s) => (Form::Nurbs(s), [spans(s.knots_u()), spans(s.knots_v())]),
            Surface::Plane(s) => (
                Form::Plane {
                    origin: point(&s.origin),
                    axes: [vector(&s.x), vector(&s.y)],
                    domain: s.domain,
                    extents: s.extents,
                },
                domain.map(|d| simple(d, RangeKind::Straight)),
            ),
            Surface::Revolution(s) => {
                let across = profile(&s.profile);
                let around = simple(s.angle_domain, RangeKind::Angle);
                let form = Form::Turned {
                    origin: point(&s.origin),
                    axis: normalised(&vector(&s.axis)),
                    angle: s.angle,
                    domain: s.angle_domain,
                    transposed: s.transposed,
                };
                let ranges = if s.transposed {
                    [across, around]
                } else {
                    [around, across]
                };
                (form, ranges)
            }
            Surface::Sum(s) => (
                Form::Sum(vector(&s.base)),
                [profile(&s.first), profile(&s.second)],
            ),
        };
        let creases = match surface {
            Surface::Nurbs(s) => [sharp_knots(s.knots_u()), sharp_knots(s.knots_v())],
            // Joints of profiles: smooth or not, they are looked at.
            _ => [breaks(&ranges[0]), breaks(&ranges[1])],
        };
        Self {
            form,
            ranges,
            domain,
            creases,
        }
    }

    /// The ranges along u (0) or v (1) that together cover an interval (as far as it is in the domain); one that it
    /// meets in an end alone is not needed, as the others hold that point too.
    pub(crate) fn met<N: Number>(&self, which: usize, x: &N) -> std::ops::Range<usize> {
        let all = &self.ranges[which];
        let (lower, upper) = (x.lower().ball(), x.upper().ball());
        let first = all.partition_point(|r| !lower.below(&r.to));
        let end = all.partition_point(|r| r.from.below(&upper));
        let first = first.min(all.len() - 1);
        first..end.max(first + 1)
    }

    /// Whether the tangent plane may break inside the box.
    pub(crate) fn creased<N: Number>(&self, uv: &[N; 2]) -> bool {
        (0..2).any(|c| {
            let (lower, upper) = (uv[c].lower().ball(), uv[c].upper().ball());
            self.creases[c]
                .iter()
                .any(|k| lower.below(k) && k.below(&upper))
        })
    }

    /// The surface over a box of parameters, by the formula of one cell (which goes on beyond it).
    /// `None` where the weight may be 0: the box is too large.
    pub(crate) fn jet<N: Number>(&self, cell: [usize; 2], uv: &[N; 2]) -> Option<SurfaceJet<N>> {
        let kinds = [&self.ranges[0][cell[0]].kind, &self.ranges[1][cell[1]].kind];
        match (&self.form, kinds) {
            (Form::Nurbs(s), [RangeKind::Span(i), RangeKind::Span(j)]) => {
                spline_surface(s, [*i, *j], uv)
            }
            (
                Form::Plane {
                    origin,
                    axes,
                    domain,
                    extents,
                },
                _,
            ) => {
                let (a, ka) = linear(&uv[0], domain[0], extents[0])?;
                let (b, kb) = linear(&uv[1], domain[1], extents[1])?;
                let (x, y): ([N; 3], [N; 3]) = (of(&axes[0]), of(&axes[1]));
                let p = sum(&of(origin), &sum(&scaled(&x, &a), &scaled(&y, &b)));
                let none = || map(|_| N::zero());
                Some(SurfaceJet {
                    p,
                    u: scaled(&x, &ka),
                    v: scaled(&y, &kb),
                    uu: none(),
                    uv: none(),
                    vv: none(),
                })
            }
            (
                Form::Turned {
                    origin,
                    axis,
                    angle,
                    domain,
                    transposed,
                },
                [a, b],
            ) => {
                let (around, along) = if *transposed {
                    (&uv[1], &uv[0])
                } else {
                    (&uv[0], &uv[1])
                };
                let ((RangeKind::Profile(piece), _) | (_, RangeKind::Profile(piece))) = (a, b)
                else {
                    return None;
                };
                let jet = piece.jet(along)?;
                let (a, k) = linear(around, *domain, *angle)?;
                let turned = turned(&of(origin), &of(axis), jet, &a, &k);
                Some(if *transposed {
                    turned.swapped()
                } else {
                    turned
                })
            }
            (Form::Sum(base), [RangeKind::Profile(a), RangeKind::Profile(b)]) => {
                let (a, b) = (a.jet(&uv[0])?, b.jet(&uv[1])?);
                Some(SurfaceJet {
                    p: sum(&of(base), &sum(&a.p, &b.p)),
                    u: a.d,
                    v: b.d,
                    uu: a.dd,
                    uv: map(|_| N::zero()),
                    vv: b.dd,
                })
            }
            _ => None,
        }
    }

    /// The surface over a box that may meet several cells: the hull over all of them.
    pub(crate) fn jet_across<N: Number>(&self, uv: &[N; 2]) -> Option<SurfaceJet<N>> {
        let mut all: Option<SurfaceJet<N>> = None;
        for i in self.met(0, &uv[0]) {
            for j in self.met(1, &uv[1]) {
                let clip = |x: &N, r: &Range<'_>| {
                    let range = N::of(&r.from).hull(&N::of(&r.to));
                    x.meet(&range).unwrap_or_else(|| x.clone())
                };
                let part = [
                    clip(&uv[0], &self.ranges[0][i]),
                    clip(&uv[1], &self.ranges[1][j]),
                ];
                let jet = self.jet([i, j], &part)?;
                all = Some(match all {
                    Some(old) => old.hull(&jet),
                    None => jet,
                });
            }
        }
        all
    }
}

impl<N> SurfaceJet<N> {
    fn swapped(self) -> Self {
        Self {
            p: self.p,
            u: self.v,
            v: self.u,
            uu: self.vv,
            uv: self.uv,
            vv: self.uu,
        }
    }
}

/// The profile turned by `a` about the axis: with e the unit axis and r = P - O,
/// O + (e.r) e + cos a (r - (e.r) e) + sin a e x r. u is the angular parameter.
fn turned<N: Number>(
    origin: &[N; 3],
    e: &[N; 3],
    profile: CurveJet<N, 3>,
    a: &N,
    k: &N,
) -> SurfaceJet<N> {
    let (sin, cos) = sin_cos(a);
    let relative: [N; 3] = map(|c| profile.p[c].minus(&origin[c]));
    // The turned vector and its first and second derivative by the angle.
    let turn = |r: &[N; 3]| -> [[N; 3]; 3] {
        let along = scaled(e, &dot(e, r));
        let across: [N; 3] = map(|c| r[c].minus(&along[c]));
        let side = cross(e, r);
        let moving: [N; 3] = sum(&scaled(&across, &cos), &scaled(&side, &sin));
        let first: [N; 3] = map(|c| side[c].times(&cos).minus(&across[c].times(&sin)));
        let second = map(|c| moving[c].negated());
        [sum(&along, &moving), first, second]
    };
    let [p, du, duu] = turn(&relative);
    let [v, duv, _] = turn(&profile.d);
    let [vv, _, _] = turn(&profile.dd);
    SurfaceJet {
        p: sum(origin, &p),
        u: scaled(&du, k),
        v,
        uu: scaled(&duu, &k.squared()),
        uv: scaled(&duv, k),
        vv,
    }
}

fn spline_surface<N: Number>(
    s: &NurbsSurface,
    spans: [usize; 2],
    uv: &[N; 2],
) -> Option<SurfaceJet<N>> {
    let (p, q) = (s.knots_u().degree(), s.knots_v().degree());
    let bu = basis(s.knots_u(), spans[0], &uv[0].middle());
    let bv = basis(s.knots_v(), spans[1], &uv[1].middle());
    let (hu, hv) = (powers(uv[0].radius(), p), powers(uv[1].radius(), q));
    let columns = s.counts()[1];
    let net = s.control_net();
    let at = |a: usize, b: usize| &net[(spans[0] - p + a) * columns + spans[1] - q + b];
    let first = at(0, 0)[3];
    let rational = (0..=p).any(|a| (0..=q).any(|b| at(a, b)[3] != first));
    let thin = hu[1.min(p)] == 0.0 && hv[1.min(q)] == 0.0;
    // All derivatives up to the second of one homogeneous coordinate: 00 10 01 20 11 02.
    const ORDERS: [(usize, usize); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];
    let needed = |k: usize, l: usize| !thin || k + l <= 2;
    let taylor = |c: usize| -> Vec<Vec<N>> {
        // rows[a][l]: coefficient of y^l of row a.
        let rows: Vec<Vec<N>> = (0..=p)
            .map(|a| {
                (0..=q)
                    .map(|l| {
                        let mut all = N::zero();
                        for b in 0..=q {
                            all = all.plus(&bv[b][l].times(&N::exact(at(a, b)[c])));
                        }
                        all
                    })
                    .collect()
            })
            .collect();
        let coefficient = |k: usize, l: usize| {
            let mut all = N::zero();
            if needed(k, l) {
                for a in 0..=p {
                    all = all.plus(&bu[a][k].times(&rows[a][l]));
                }
            }
            all
        };
        (0..=p)
            .map(|k| (0..=q).map(|l| coefficient(k, l)).collect())
            .collect()
    };
    let ranges = |coefficients: &[Vec<N>]| -> [N; 6] {
        let sizes: Vec<Vec<f64>> = if thin {
            Vec::new()
        } else {
            coefficients
                .iter()
                .map(|row| row.iter().map(Number::magnitude).collect())
                .collect()
        };
        ORDERS.map(|(d, e)| {
            if d > p || e > q {
                return N::zero();
            }
            let middle = coefficients[d][e].times(&N::exact(falling(d, d) * falling(e, e)));
            if thin {
                return middle;
            }
            let mut rest = 0.0;
            for k in d..=p {
                let fall = falling(k, d) * hu[k - d];
                for l in e..=q {
                    if (k, l) != (d, e) {
                        rest += fall * falling(l, e) * sizes[k][l] * hv[l - e];
                    }
                }
            }
            middle.widened(rest * UP + f64::MIN_POSITIVE)
        })
    };
    let weights = if rational { Some(taylor(3)) } else { None };
    let w = weights.as_deref().map(ranges);
    let mut jet = SurfaceJet {
        p: map(|_| N::zero()),
        u: map(|_| N::zero()),
        v: map(|_| N::zero()),
        uu: map(|_| N::zero()),
        uv: map(|_| N::zero()),
        vv: map(|_| N::zero()),
    };
    for c in 0..3 {
        let mut x = taylor(c);
        if let (Some(weights), Some(w)) = (&weights, &w) {
            let start = x[0][0].over(&weights[0][0])?.middle();
            for (row, weights) in x.iter_mut().zip(weights) {
                for (x, w) in row.iter_mut().zip(weights) {
                    *x = x.minus(&start.times(w));
                }
            }
            let x = ranges(&x);
            let by = |n: N| n.over(&w[0]);
            let off = by(x[0].clone())?;
            let su = by(x[1].minus(&off.times(&w[1])))?;
            let sv = by(x[2].minus(&off.times(&w[2])))?;
            let second = |x: &N, a: &N, b: &N, wa: &N, wb: &N, wab: &N| {
                x.minus(&a.times(wb))
                    .minus(&b.times(wa))
                    .minus(&off.times(wab))
            };
            jet.uu[c] = by(second(&x[3], &su, &su, &w[1], &w[1], &w[3]))?;
            jet.uv[c] = by(second(&x[4], &su, &sv, &w[1], &w[2], &w[4]))?;
            jet.vv[c] = by(second(&x[5], &sv, &sv, &w[2], &w[2], &w[5]))?;
            jet.p[c] = start.plus(&off);
            (jet.u[c], jet.v[c]) = (su, sv);
        } else {
            let x = ranges(&x);
            let weight = N::exact(first);
            let by = |n: &N| n.over(&weight);
            jet.p[c] = by(&x[0])?;
            jet.u[c] = by(&x[1])?;
            jet.v[c] = by(&x[2])?;
            jet.uu[c] = by(&x[3])?;
            jet.uv[c] = by(&x[4])?;
            jet.vv[c] = by(&x[5])?;
        }
    }
    Some(jet)
}
