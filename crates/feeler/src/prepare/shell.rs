//! Round surfaces recognised in others: spheres, cylinders, cones, tori.
//!
//! # What is proven
//! Let `y = A (x - o)` with a frame whose three rows of f64 are orthonormal but for rounding, `rho = |(y_0, y_1)|`, `z = y_2`. Each kind has
//! a function of space that is constant on it:
//!
//! | kind | function |
//! |---|---|
//! | sphere | `\|y\|` |
//! | cylinder | `rho` |
//! | cone | `k rho - s z`, with `k` and `s` near the cosine and the sine of its half angle |
//! | torus | `\|(rho - R, z)\|` |
//!
//! None grows faster than distances do, but for what the frame's rounding allows ([`Shell::new`] checks that it is a few units):
//! `x -> y` does not, nor `y -> (rho, z)` by the triangle inequality, nor what is made of these. So where the surface has values
//! in `[low, high]` alone, a point with the value `phi` is at least `max(phi - high, low - phi)` away from it.
//!
//! The range is proven on each patch from quotients of coefficients, in double-double with their errors; weights are positive, so that a
//! quotient of polynomials is a convex combination of its coefficients' quotients. The squares of `|y|` and of `rho` are such quotients. For
//! the others, with `C = w^2` and `k`, `s`, `R` not below zero:
//!
//! - Cone: `(k rho)^2 - (s z)^2 = F / C`, and the function is that over `k rho + s z`, which is no less than it is for the least `rho`
//!   and the least `z` of the patch.
//! - Torus: `E / C = |y|^2 + R^2 - r^2` and `(E^2 - 4 R^2 C (w rho)^2) / C^2 = (|y|^2 + R^2 - r^2 - 2 R rho) (E / C + 2 R rho)`, of which the first
//!   factor is the function's square less `r^2`, and the second is no less than for the least of `E / C` and `rho`.
//!
//! A turned arc whose centre `c` is next to the axis needs no coefficients: turning keeps distances from the point `o` of the axis next to `c`, and those of the arc's points from `o` are the
//! radius but for `|c - o|` at most.
//!
//! That the frame is off by a little costs sharpness, not truth. Nothing is claimed about which points of the shell are on the surface: an
//! upper bound is always a point of the surface itself.

use super::circle::{dot, normalized};
use super::closed::Target;
use super::net::Coefficients;
use super::recognise::{Frame, Round, recognise};
use super::{Net, PreparedBrep, Quotient};
use crate::numeric::bernstein::Bidegree;
use crate::numeric::{Ball, Dd, Real};
use crate::nurbs::{Curve3, Revolution, Surface};
use nalgebra::{Matrix3, Point3, Vector3};

/// A round surface and bounds of its function on a face's whole surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shell {
    round: Round,
    low: f64,
    high: f64,
}

/// `normal.(x - origin) <= offset`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearHalfSpace {
    pub(crate) origin: Point3<f64>,
    pub(crate) normal: Vector3<f64>,
    pub(crate) offset: f64,
}

/// A shell thicker than this part of the model's size serves no query.
const THICK: f64 = 1.0 / (1u64 << 30) as f64;
/// By how much the entries of a frame's Gram matrix may be off those of 1, half of it counted and half left to the rounding of what is counted; and a
/// cone's `k^2 + s^2`.
const SQUARE: f64 = 16.0 * f64::EPSILON;
/// No function grows faster than this: the Gram matrix is off by `3 SQUARE` at most in norm, so the frame's norm is at most
/// `1 + 3/2 SQUARE`, and a cone's two numbers are a vector of length `1 + SQUARE / 2` at most.
const LIPSCHITZ: f64 = 1.0 + 4.0 * SQUARE;
/// A bound that is off by some roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// Tori of patches of more coefficients are not looked at: those of `F` are sixteen times as many, from products of all with all.
const MOST_TORIC: usize = 100;

impl Shell {
    /// The shell of a face's surface; `None` where no round surface is seen in it.
    pub(super) fn new(brep: &PreparedBrep, face: usize) -> Option<Self> {
        let thin = |s: &Self| s.high - s.low <= THICK * brep.size();
        let turned = match brep.brep().surface(face) {
            Surface::Revolution(s) => Self::of_turned_arc(s).filter(thin),
            _ => None,
        };
        if turned.is_some() {
            return turned;
        }
        let round = recognise(brep.double(face))?;
        let rows = Matrix3::from_rows(&round.frame().rows.map(|r| r.transpose()));
        let small = |x: f64| x.abs() <= 0.5 * SQUARE;
        let off = rows * rows.transpose() - Matrix3::identity();
        // The ranges of cones and tori are proven for numbers not below zero.
        let proper = match round {
            Round::Sphere { .. } | Round::Cylinder { .. } => true,
            Round::Cone { cos, sin, .. } => {
                cos >= 0.0 && sin >= 0.0 && small(cos * cos + sin * sin - 1.0)
            }
            Round::Torus { radius, tube, .. } => radius >= 0.0 && tube >= 0.0,
        };
        if !(proper && off.iter().all(|x| small(*x))) {
            return None;
        }
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let patches = &brep.double_double(face).patches;
        for index in 0..patches.len() {
            let [a, b] = round.range(&patches.lent(index).net)?;
            low = low.min(a);
            high = high.max(b);
        }
        Some(Self { round, low, high }).filter(thin)
    }

    /// That of a turned arc, if it is one about the point of the axis that is next to the arc's centre.
    fn of_turned_arc(s: &Revolution) -> Option<Self> {
        let Curve3::Arc(arc) = &s.profile else {
            return None;
        };
        let exact = |v: &Vector3<f64>| [0, 1, 2].map(|c| Ball::<Dd>::exact(v[c]));
        let axis = normalized(&exact(&s.axis));
        let way: [Ball<Dd>; 3] =
            std::array::from_fn(|c| Ball::difference(arc.center[c], s.origin[c]));
        let along = dot(&way, &axis);
        let next = [0, 1, 2].map(|c| Ball::exact(s.origin[c]) + along * axis[c]);
        let origin = Point3::from(next.map(|x| x.mid.hi));
        let apart = |p: &Point3<f64>| {
            let off = [0, 1, 2].map(|c| (next[c] - Ball::exact(p[c])).magnitude());
            off.iter().map(|x| x * x).sum::<f64>().sqrt() * UP + Round::TINY
        };
        let off = apart(&arc.center) + apart(&origin);
        let rows = [Vector3::x(), Vector3::y(), Vector3::z()];
        Some(Self {
            round: Round::Sphere {
                frame: Frame { origin, rows },
            },
            low: (arc.radius - off).next_down().max(0.0),
            high: (arc.radius + off).next_up(),
        })
    }

    /// Whether it is one about a sphere.
    pub(crate) fn is_sphere(&self) -> bool {
        matches!(self.round, Round::Sphere { .. })
    }

    /// What the surface is.
    pub(super) fn name(&self) -> &'static str {
        self.round.name()
    }

    /// How thick it is.
    pub(crate) fn thickness(&self) -> f64 {
        (self.high - self.low).next_up()
    }

    /// A lower bound of the target on the surface.
    pub(crate) fn least(&self, target: &Target) -> Dd {
        match target {
            Target::Point(q) => {
                let (value, off) = self.round.value(&Point3::from(*q));
                let gap = (value - self.high).max(self.low - value) - off * UP;
                // The difference is rounded.
                let gap = gap - f64::EPSILON * (value.abs() + self.high.abs() + self.low.abs());
                let gap = (gap / (LIPSCHITZ * UP)).max(0.0);
                Dd::product(gap, gap) - Dd::from(4.0 * Dd::UNIT * gap * gap)
            }
            Target::Height(n, h) => self
                .least_height(&Vector3::from(*n), *h)
                .map_or(Dd::from(f64::NEG_INFINITY), Dd::from),
        }
    }

    /// A half-space `n.(x - o) <= t` that holds all points of a sphere in the box `within` whose squared distance from `q` is below
    /// `squared`; of other surfaces nothing is said.
    ///
    /// Let `s = A (x - o)` and `p = A (o - q)`: `|s| >= low` on the surface, and
    /// `|s + p|^2 <= |A (x - q)|^2 <= LIPSCHITZ^2 |x - q|^2`. So where that distance is below, `2 s.p = |s + p|^2 - |s|^2 - |p|^2 <
    /// LIPSCHITZ^2 squared - low^2 - |p|^2`. And `s.p = n.(x - o)` with `n` the sum of the frame's rows, each `p_k` times.
    ///
    /// In f64 `p` is off by some roundings of `|o - q|`, `n` by some more, the bound by some of its parts: fewer than ten each, of 64 that are counted.
    /// Where `|o - q|` times the reach underflows, the roundings of `n.(x - o)` are within those counted of the squares, since `|x - o| <= |o - q| +
    /// sqrt(squared)` for the points in question.
    pub(crate) fn near_half_space(
        &self,
        q: &Point3<f64>,
        squared: f64,
        within: &[[f64; 2]; 3],
    ) -> Option<NearHalfSpace> {
        const SLACK: f64 = 64.0 * f64::EPSILON;
        let Round::Sphere { frame } = &self.round else {
            return None;
        };
        let apart = frame.origin - q;
        let (mut normal, mut length) = (Vector3::zeros(), 0.0);
        for row in &frame.rows {
            let p = row.dot(&apart);
            normal += row * p;
            length += p * p;
        }
        let least = self.low * self.low;
        let farthest = |k: usize| {
            let [low, high] = within[k].map(|x| (x - frame.origin[k]).abs());
            low.max(high)
        };
        let reach = Vector3::from_fn(|k, _| farthest(k)).norm();
        let slack = (SLACK + 2.0 * LIPSCHITZ * (LIPSCHITZ - 1.0)) * (squared + least + length)
            + SLACK * apart.norm() * reach
            + f64::MIN_POSITIVE;
        Some(NearHalfSpace {
            origin: frame.origin,
            normal,
            offset: 0.5 * (squared - least - length) + slack,
        })
    }

    /// A lower bound of `n.x - h` on the surface, if it is bounded.
    ///
    /// `n.x = n.o + m.y` where `m` is `A n` but for the frame's rounding. On a sphere `|y| <= high`; a torus's points are within `high` of its
    /// circle, which adds `R |(m_0, m_1)|`.
    fn least_height(&self, n: &Vector3<f64>, h: f64) -> Option<f64> {
        let frame = self.round.frame();
        let wide = match self.round {
            Round::Sphere { .. } => 0.0,
            Round::Torus { radius, .. } => radius,
            Round::Cylinder { .. } | Round::Cone { .. } => return None,
        };
        let size = n.norm();
        let [x, y, _] = frame.rows.map(|r| r.dot(n));
        let reach = size * self.high + (x * x + y * y).sqrt() * wide;
        let most = size * (frame.origin.coords.norm() + self.high + wide) + h.abs();
        Some(n.dot(&frame.origin.coords) - h - reach - 2.0 * (LIPSCHITZ - 1.0) * most)
    }
}

impl Round {
    /// Its function at a point, and by how much that may be off.
    ///
    /// Differences are off by a rounding, rows' products with them by six more of no more than `2 |x - o|`, what is made of those by fewer
    /// than ten of no more than that and a torus's radius.
    fn value(&self, x: &Point3<f64>) -> (f64, f64) {
        const SLACK: f64 = 32.0 * f64::EPSILON;
        let frame = self.frame();
        let d = x - frame.origin;
        let [a, b, z] = frame.rows.map(|r| r.dot(&d));
        let rho = (a * a + b * b).sqrt();
        let size = d.norm() + Self::TINY;
        match self {
            Self::Sphere { .. } => ((a * a + b * b + z * z).sqrt(), SLACK * size),
            Self::Cylinder { .. } => (rho, SLACK * size),
            Self::Cone { cos, sin, .. } => (cos * rho - sin * z, SLACK * size),
            Self::Torus { radius, .. } => {
                let across = rho - radius;
                ((across * across + z * z).sqrt(), SLACK * (size + radius))
            }
        }
    }

    /// Lengths whose squares underflow are far below this part of it: covers them.
    const TINY: f64 = 1e-140;

    /// The range of its function on a net; `None` where no range is proven.
    fn range(&self, net: &Net<Dd>) -> Option<[f64; 2]> {
        let frame = self.frame();
        let w = Poly::weight(net);
        let c = w.times(&w);
        let [x, y, z] = frame.rows.map(|r| Poly::linear(net, &r, &frame.origin));
        let across = x.times(&x).plus(&y.times(&y), Ball::ONE);
        // The square root is correctly rounded.
        let roots = |[a, b]: [f64; 2]| [a.max(0.0).sqrt().next_down(), b.max(0.0).sqrt().next_up()];
        let rho = roots(across.over(&c)?);
        match self {
            Self::Sphere { .. } => {
                let square = across.plus(&z.times(&z), Ball::ONE);
                Some(roots(square.over(&c)?))
            }
            Self::Cylinder { .. } => Some(rho),
            Self::Cone { cos, sin, .. } => {
                let [k, s] = [*cos, *sin].map(Ball::<Dd>::exact);
                let zero = across.plus(&across, Ball::exact(-1.0));
                let f = zero
                    .plus(&across, k.square())
                    .plus(&z.times(&z), -s.square());
                let along = z.over(&w)?[0];
                let other = cos * rho[0] + sin * along;
                let other = other - 4.0 * f64::EPSILON * (cos * rho[0] + sin * along.abs());
                let [a, b] = f.over(&c)?;
                (other > 0.0).then(|| [(a / other).min(0.0) * UP, (b / other).max(0.0) * UP])
            }
            Self::Torus { radius, tube, .. } => {
                if net.degree.count() > MOST_TORIC {
                    return None;
                }
                let [big, small] = [*radius, *tube].map(|r| Ball::<Dd>::exact(r).square());
                let square = across.plus(&z.times(&z), Ball::ONE);
                let e = square.plus(&c, big - small);
                let four = Ball::exact(4.0);
                let f = e.times(&e).plus(&c.times(&across), -(four * big));
                let low = e.over(&c)?[0];
                let other = low + 2.0 * radius * rho[0];
                let other = other - 4.0 * f64::EPSILON * (low.abs() + 2.0 * radius * rho[0]);
                let [a, b] = f.over(&c.times(&c))?;
                let square = tube * tube;
                let ends = [
                    square / UP + (a / other).min(0.0) * UP,
                    square * UP + (b / other).max(0.0) * UP,
                ];
                (other > 0.0).then(|| roots(ends))
            }
        }
    }
}

/// A polynomial on a net's square.
struct Poly {
    degree: Bidegree,
    c: Coefficients<Dd>,
}

impl Poly {
    /// The weight.
    fn weight(net: &Net<Dd>) -> Self {
        Self {
            degree: net.degree,
            c: net.coordinate(3),
        }
    }

    /// `w row.(S - origin)`.
    fn linear(net: &Net<Dd>, row: &Vector3<f64>, origin: &Point3<f64>) -> Self {
        let w = Self::weight(net);
        let zero = Self {
            degree: net.degree,
            c: Coefficients {
                values: vec![Dd::ZERO; w.c.values.len()],
                error: 0.0,
                largest: 0.0,
                tiny: w.c.tiny,
            },
        };
        (0..3).fold(zero, |sum, k| {
            let c = net.coordinate(k);
            let degree = net.degree;
            let shift = Ball::difference(net.origin[k], origin[k]);
            let own = Self { degree, c }.plus(&w, shift);
            sum.plus(&own, Ball::exact(row[k]))
        })
    }

    fn times(&self, other: &Self) -> Self {
        Self {
            degree: self.degree + other.degree,
            c: self.c.times(self.degree, &other.c, other.degree),
        }
    }

    /// `self + factor other`, of one degree and over one power of the weight: two roundings of parts no larger than the sum of both.
    fn plus(&self, other: &Self, factor: Ball<Dd>) -> Self {
        let pairs = self.c.values.iter().zip(&other.c.values);
        let values = pairs.map(|(a, b)| *a + factor.mid * *b).collect();
        let size = self.c.largest + factor.magnitude() * other.c.largest;
        let inherited = self.c.error
            + factor.magnitude() * other.c.error
            + factor.rad * (other.c.largest + other.c.error);
        let error = (inherited + 4.0 * Dd::UNIT * size + 4.0 * self.c.tiny) * UP;
        Self {
            degree: self.degree,
            c: Coefficients {
                values,
                error,
                largest: (size + error) * UP,
                tiny: self.c.tiny,
            },
        }
    }

    /// Bounds of the quotient.
    fn over(&self, bottom: &Self) -> Option<[f64; 2]> {
        let quotient = Quotient {
            degree: self.degree,
            n: self.c.values.clone(),
            n_error: self.c.error,
            c: bottom.c.values.clone(),
            c_error: bottom.c.error,
            tiny: bottom.c.tiny,
        };
        quotient.range()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brep::Brep;
    use crate::numeric::Interval;
    use crate::nurbs::{Arc, Curve, Curve3, Line, NurbsSurface, Revolution, Surface};
    use std::f64::consts::TAU;

    /// Thicker shells than this part of the size are not what a surface known to f64 should have.
    const ROUNDING: f64 = 1e-14;

    struct Random(u64);

    impl Random {
        fn between(&mut self, a: f64, b: f64) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            a + (b - a) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
        }

        fn vector(&mut self) -> Vector3<f64> {
            Vector3::from_fn(|_, _| self.between(-1.0, 1.0))
        }
    }

    /// A frame, and the profile `(rho, z)` of a surface of revolution in it.
    struct Turned {
        origin: Point3<f64>,
        rows: [Vector3<f64>; 3],
    }

    impl Turned {
        fn new(random: &mut Random) -> Self {
            let z = random.vector().normalize();
            let x = z.cross(&random.vector()).normalize();
            Self {
                origin: Point3::from(random.vector() * 3.0),
                rows: [x, z.cross(&x), z],
            }
        }

        fn at(&self, rho: f64, z: f64) -> Point3<f64> {
            self.origin + self.rows[0] * rho + self.rows[2] * z
        }

        fn line(&self, a: [f64; 2], b: [f64; 2]) -> Curve3 {
            let domain = Interval::new(0.0, 1.0).unwrap();
            Curve::Line(Line::new(self.at(a[0], a[1]), self.at(b[0], b[1]), domain).unwrap())
        }

        fn arc(&self, center: [f64; 2], radius: f64, angle: [f64; 2]) -> Curve3 {
            let angle = Interval::new(angle[0], angle[1]).unwrap();
            let arc = Arc::new(Arc {
                center: self.at(center[0], center[1]),
                x: self.rows[0],
                y: self.rows[2],
                z: -self.rows[1],
                radius,
                angle,
                domain: angle,
            });
            Curve::Arc(arc.unwrap())
        }

        fn nurbs(&self, profile: Curve3, angle: [f64; 2]) -> NurbsSurface {
            let angle = Interval::new(angle[0], angle[1]).unwrap();
            let turned = Revolution {
                profile,
                origin: self.origin,
                axis: self.rows[2],
                angle,
                angle_domain: angle,
                transposed: false,
            };
            Surface::Revolution(turned).to_nurbs().unwrap().nurbs
        }

        /// `(rho, z)` of a point.
        fn profile(&self, p: &Point3<f64>) -> [f64; 2] {
            let [x, y, z] = self.rows.map(|r| r.dot(&(p - self.origin)));
            [(x * x + y * y).sqrt(), z]
        }
    }

    fn prepared(surface: NurbsSurface) -> PreparedBrep {
        PreparedBrep::new(Brep::from_surface(Surface::Nurbs(surface)).unwrap())
    }

    type Distance = Box<dyn Fn([f64; 2]) -> f64>;

    /// Kinds, whole and in parts, with the distance of a point from the whole round surface by its profile.
    fn kinds(t: &Turned) -> Vec<(&'static str, NurbsSurface, Distance)> {
        let (whole, part) = ([0.0, TAU], [0.4, 1.1]);
        let cone = 0.3f64;
        vec![
            (
                "sphere",
                t.nurbs(t.arc([0.0, 0.5], 2.0, [-1.5, 1.2]), whole),
                Box::new(|[r, z]| ((r * r + (z - 0.5).powi(2)).sqrt() - 2.0).abs()),
            ),
            (
                "cylinder",
                t.nurbs(t.line([1.5, -1.0], [1.5, 2.0]), whole),
                Box::new(|[r, _]| (r - 1.5).abs()),
            ),
            (
                "cylinder",
                t.nurbs(t.line([1.5, -1.0], [1.5, 2.0]), part),
                Box::new(|[r, _]| (r - 1.5).abs()),
            ),
            (
                "cone",
                t.nurbs(t.line([1.0, 0.0], [1.0 + 2.0 * cone, 2.0]), whole),
                Box::new(move |[r, z]| ((r - 1.0) - cone * z).abs() / (1.0 + cone * cone).sqrt()),
            ),
            (
                "cone",
                t.nurbs(t.line([1.0, 0.0], [1.0 - 2.0 * cone, 2.0]), part),
                Box::new(move |[r, z]| ((r - 1.0) + cone * z).abs() / (1.0 + cone * cone).sqrt()),
            ),
            (
                "torus",
                t.nurbs(t.arc([2.0, 0.25], 0.75, [0.0, TAU]), whole),
                Box::new(|[r, z]| (((r - 2.0).powi(2) + (z - 0.25).powi(2)).sqrt() - 0.75).abs()),
            ),
            (
                "torus",
                t.nurbs(t.arc([2.0, 0.25], 0.75, [0.3, 1.4]), part),
                Box::new(|[r, z]| (((r - 2.0).powi(2) + (z - 0.25).powi(2)).sqrt() - 0.75).abs()),
            ),
        ]
    }

    /// What is recognised is what was made, and its bound is the distance from it but for rounding.
    #[test]
    fn round_surfaces_are_recognised() {
        let mut random = Random(0x2545_f491_4f6c_dd1d);
        for _ in 0..8 {
            let turned = Turned::new(&mut random);
            for (kind, surface, distance) in kinds(&turned) {
                let brep = prepared(surface);
                let shell = brep.shell(0);
                let shell = shell.unwrap_or_else(|| panic!("no {kind}"));
                assert_eq!(shell.name(), kind);
                let thick = shell.thickness() / brep.size();
                assert!(thick < ROUNDING, "{kind}: {thick:e}");
                let d = brep.brep().surface(0).domain();
                for _ in 0..20 {
                    // Not farther from the part than it is large: what a part tells of the rest is less sure.
                    let [u, v] = d.map(|d| random.between(d.start, d.end));
                    let p = brep.brep().surface(0).derivatives(u, v, 0).get(0, 0);
                    let q = Point3::from(p + random.vector() * (0.5 * brep.size()));
                    let least = shell.least(&Target::Point(q.coords.into())).hi.sqrt();
                    let known = distance(turned.profile(&q));
                    assert!(
                        (least - known).abs() < 8.0 * ROUNDING * brep.size(),
                        "{kind}: {least} {known}"
                    );
                }
            }
        }
    }

    /// A turned arc is in a shell about its centre, from within a rounding of the axis to what is too far for one: no thinner than its points need, nor by far thicker.
    #[test]
    fn turned_arcs_are_in_shells() {
        let mut random = Random(0x3c6e_f372_fe94_f82b);
        for round in 0..24 {
            let turned = Turned::new(&mut random);
            let off = [0.0, 1e-17, 1e-15, 1e-13, 1e-11, 1e-6][round % 6];
            let angle = Interval::new(0.3, 5.0).unwrap();
            let surface = Revolution {
                // About the axis through the pole, in part, or off it.
                profile: turned.arc([off, 0.5], 2.0, [[-1.5, 1.2], [-0.3, 0.9]][round % 2]),
                origin: turned.origin,
                axis: turned.rows[2] * random.between(0.3, 3.0),
                angle,
                angle_domain: angle,
                transposed: false,
            };
            let surface = Surface::Revolution(Revolution::new(surface).unwrap());
            let Surface::Revolution(s) = &surface else {
                unreachable!()
            };
            let shell = Shell::of_turned_arc(s).unwrap();
            // The centre was rounded too, as far from the origin as it is.
            assert!(
                shell.thickness() <= 2.0 * off + ROUNDING,
                "{off:e} {shell:?}"
            );
            let Curve3::Arc(arc) = &s.profile else {
                unreachable!()
            };
            let [u, v] = surface.domain();
            let (mut low, mut high) = (f64::INFINITY, 0.0f64);
            for _ in 0..200 {
                let p = surface.point(
                    random.between(u.start, u.end),
                    random.between(v.start, v.end),
                );
                let (value, _) = shell.round.value(&p);
                let rounding = 64.0 * f64::EPSILON * p.coords.norm().max(1.0);
                assert!(
                    shell.low - rounding <= value && value <= shell.high + rounding,
                    "{off:e}"
                );
                (low, high) = (low.min(value), high.max(value));
            }
            // Were the shell's centre elsewhere, points would differ by more than where the arc's centre is off.
            assert!(
                high - low <= 2.0 * off + 10.0 * ROUNDING,
                "{off:e} {}",
                high - low
            );
            assert!(
                (low - arc.radius).abs() <= off + 10.0 * ROUNDING,
                "{off:e} {low}"
            );
        }
    }

    /// Of two points of a sphere the half-space of what is as near as the nearer holds that one alone.
    #[test]
    fn what_is_nearer_is_in_a_half_space() {
        let mut random = Random(0x1234_5678_9abc_def1);
        let (mut kept, mut excluded) = (0, 0);
        for _ in 0..8 {
            let turned = Turned::new(&mut random);
            for (kind, surface, _) in kinds(&turned) {
                let brep = prepared(surface);
                let (shell, face_box) = (brep.shell(0).unwrap(), brep.face_box(0).unwrap());
                let d = brep.brep().surface(0).domain();
                let point = |q: &Point3<f64>, random: &mut Random| {
                    let [u, v] = d.map(|d| random.between(d.start, d.end));
                    let p = Point3::from(brep.brep().surface(0).derivatives(u, v, 0).get(0, 0));
                    (p, (p - q).norm_squared())
                };
                for _ in 0..50 {
                    let q = turned.origin + random.vector() * 2.0;
                    let (a, b) = (point(&q, &mut random), point(&q, &mut random));
                    let (near, far) = if a.1 < b.1 { (a, b) } else { (b, a) };
                    let Some(half) = shell.near_half_space(&q, near.1, face_box) else {
                        assert!(kind != "sphere");
                        continue;
                    };
                    let above = |p: Point3<f64>| half.normal.dot(&(p - half.origin)) > half.offset;
                    assert!(!above(near.0), "{kind}");
                    kept += 1;
                    if far.1 > near.1 + ROUNDING * brep.size().powi(2) * 16.0 {
                        assert!(above(far.0), "{kind}");
                        excluded += 1;
                    }
                }
            }
        }
        assert!(kept > 300 && excluded > 200, "{kept} {excluded}");
    }

    /// Of surfaces that are not quite round the bounds are below all their points.
    #[test]
    fn bounds_are_below_all_points() {
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        let mut seen = 0;
        for round in 0..6 {
            let turned = Turned::new(&mut random);
            for (kind, surface, _) in kinds(&turned) {
                let mut net = surface.control_net().to_vec();
                for p in &mut net {
                    let off = 10f64.powi(-9 - 2 * (round % 4));
                    p.x += p.w * off * random.between(-1.0, 1.0);
                    p.y += p.w * off * random.between(-1.0, 1.0);
                }
                let knots = [surface.knots_u(), surface.knots_v()];
                let [nu, nv] = knots.map(|k| k.control_points());
                let degrees = knots.map(|k| k.degree());
                let dented =
                    NurbsSurface::new(degrees, [nu, nv], net, knots.map(|k| k.knots().to_vec()));
                let brep = prepared(dented.unwrap());
                // Farther off than samples may be, none is seen.
                let Some(shell) = brep.shell(0) else { continue };
                seen += 1;
                let [du, dv] = brep.brep().surface(0).domain();
                for _ in 0..200 {
                    let q = turned.origin + random.vector() * 4.0;
                    let (u, v) = (
                        random.between(du.start, du.end),
                        random.between(dv.start, dv.end),
                    );
                    let p = brep.brep().surface(0).derivatives(u, v, 0).get(0, 0);
                    let rounding = 64.0 * f64::EPSILON * brep.size();
                    let near = shell.least(&Target::Point(q.coords.into())).hi.sqrt();
                    assert!(near <= (p - q.coords).norm() + rounding, "{kind} {near}");
                    let squared = (p - q.coords).norm_squared() + rounding * brep.size();
                    let face_box = brep.face_box(0).unwrap();
                    if let Some(half) = shell.near_half_space(&q, squared, face_box) {
                        let height = half.normal.dot(&(p - half.origin.coords));
                        assert!(height <= half.offset, "{kind} {height}");
                    }
                    let n = random.vector();
                    let low = shell.least(&Target::Height(n.into(), 0.5)).hi;
                    assert!(low <= n.dot(&p) - 0.5 + rounding, "{kind} {low}");
                }
                // Near a point of the surface itself.
                for _ in 0..50 {
                    let (u, v) = (
                        random.between(du.start, du.end),
                        random.between(dv.start, dv.end),
                    );
                    let p = brep.brep().surface(0).derivatives(u, v, 0).get(0, 0);
                    let least = shell.least(&Target::Point(p.into())).hi.sqrt();
                    assert!(
                        least <= 64.0 * f64::EPSILON * brep.size(),
                        "{kind} {least:e}"
                    );
                }
            }
        }
        assert!(seen > 20, "{seen}");
    }
}
