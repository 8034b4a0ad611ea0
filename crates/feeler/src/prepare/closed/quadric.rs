//! Lines against spheres, cylinders, cones and hyperboloids of revolution, exactly: for those that touch them, or nearly.
//!
//! # What is exact
//! A native arc whose centre is on the axis of revolution, exactly, sweeps a part of the sphere about that centre with the stored radius. A
//! segment `P + s D` (relative to a point `o` of the axis, whose direction is `a`) sweeps points `X` for which some `s` has `h(X) = h(P + s
//! D)`, with `h = . a`, and `|X| = |P + s D|`: turning keeps both, and two points that share both are turns of each other. Where `h(D)` is not
//! zero, `s = (h(X) - h(P)) / h(D)`, so
//!
//! `h(D)^2 |X|^2 = |h(D) P + (h(X) - h(P)) D|^2`.
//!
//! On a line `X = w + x d` either is `A x^2 + 2 B x + C = 0` with dyadic coefficients: the signs of these and of `B^2 - A C` tell how often
//! the line meets the surface, and where it touches it. The surface goes on past the profile's ends, to the other half of a cone too.

use super::super::exact::{D3, Ratio, cross, dot, dyadic, enclosed, scale, sub, vector};
use crate::numeric::{Ball, Dd, Dyadic};
use crate::nurbs::{Curve3, Revolution};
use std::cmp::Ordering;

/// A surface of the second order, by the numbers it is stored with.
#[derive(Clone, Copy, Debug)]
pub(super) enum Quadric {
    Sphere {
        center: [f64; 3],
        radius: f64,
    },
    /// A segment turned about the axis.
    Turned {
        origin: [f64; 3],
        axis: [f64; 3],
        from: [f64; 3],
        to: [f64; 3],
    },
}

/// Where a line meets one.
pub(super) struct Root {
    /// The parameter, relative to where it was asked for.
    pub(super) x: Ball<Dd>,
    /// Whether it is a double root: the line touches the surface there (or passes a cone's apex).
    pub(super) double: bool,
}

fn sum(a: &D3, b: &D3) -> D3 {
    std::array::from_fn(|c| &a[c] + &b[c])
}

impl Quadric {
    /// That of a revolution; `None` where there is none.
    pub(super) fn new(s: &Revolution) -> Option<Self> {
        let (origin, axis): ([f64; 3], [f64; 3]) = (s.origin.coords.into(), s.axis.into());
        match &s.profile {
            Curve3::Arc(arc) => {
                let center: [f64; 3] = arc.center.coords.into();
                let off = sub(&vector(&center)?, &vector(&origin)?);
                let off = cross(&off, &vector(&axis)?);
                let on_axis = off.iter().all(|x| x.signum() == 0);
                on_axis.then_some(Self::Sphere {
                    center,
                    radius: arc.radius,
                })
            }
            Curve3::Line(line) => {
                let (from, to): ([f64; 3], [f64; 3]) =
                    (line.from.coords.into(), line.to.coords.into());
                let run = sub(&vector(&to)?, &vector(&from)?);
                let rises = dot(&run, &vector(&axis)?).signum() != 0;
                rises.then_some(Self::Turned {
                    origin,
                    axis,
                    from,
                    to,
                })
            }
            _ => None,
        }
    }

    /// Whether a point is on it: for a cone on either half.
    pub(super) fn holds_point(&self, point: &[f64; 3]) -> bool {
        let constant = self.on_line(point, &[0.0; 3], 0.0);
        constant.is_some_and(|[.., c]| c.signum() == 0)
    }

    /// `A`, `B`, `C` of `A x^2 + 2 B x + C` for the point `from + (middle + x) direction`.
    fn on_line(&self, from: &[f64; 3], direction: &[f64; 3], middle: f64) -> Option<[Dyadic; 3]> {
        let d = vector(direction)?;
        let start = sum(&vector(from)?, &scale(&d, &dyadic(middle)?));
        Some(match self {
            Self::Sphere { center, radius } => {
                let (w, radius) = (sub(&start, &vector(center)?), dyadic(*radius)?);
                [
                    dot(&d, &d),
                    dot(&w, &d),
                    &dot(&w, &w) - &(&radius * &radius),
                ]
            }
            Self::Turned {
                origin,
                axis,
                from,
                to,
            } => {
                let (origin, axis) = (vector(origin)?, vector(axis)?);
                let (from, to) = (vector(from)?, vector(to)?);
                let (w, run, first) = (sub(&start, &origin), sub(&to, &from), sub(&from, &origin));
                let rise = dot(&run, &axis);
                let square = &rise * &rise;
                let up = &dot(&w, &axis) - &dot(&first, &axis);
                let fixed = sum(&scale(&first, &rise), &scale(&run, &up));
                let moving = scale(&run, &dot(&d, &axis));
                let less = |a: &D3, b: &D3, c: &D3, e: &D3| &(&dot(a, b) * &square) - &dot(c, e);
                [
                    less(&d, &d, &moving, &moving),
                    less(&w, &d, &fixed, &moving),
                    less(&w, &w, &fixed, &fixed),
                ]
            }
        })
    }

    /// Where the line `from + (middle + x) direction` meets the surface, in any order; `None` where it lies in it.
    pub(super) fn roots(
        &self,
        from: &[f64; 3],
        direction: &[f64; 3],
        middle: f64,
    ) -> Option<Vec<Root>> {
        let [a, b, c] = self.on_line(from, direction, middle)?;
        let single = |x| Root { x, double: false };
        if a.signum() == 0 {
            if b.signum() != 0 {
                let x = Ratio::new(-&c, &b + &b);
                return Some(vec![single(x.enclosed())]);
            }
            return (c.signum() != 0).then(Vec::new);
        }
        let discriminant = &(&b * &b) - &(&a * &c);
        Some(match discriminant.signum() {
            -1 => Vec::new(),
            0 => vec![Root {
                x: Ratio::new(-&b, a).enclosed(),
                double: true,
            }],
            _ => {
                let root = enclosed(&discriminant).sqrt();
                let b_known = enclosed(&b);
                // No cancellation; it is not zero, since the root is not.
                let q = if b.signum() < 0 {
                    root - b_known
                } else {
                    -(root + b_known)
                };
                vec![single(q / enclosed(&a)), single(enclosed(&c) / q)]
            }
        })
    }
}

impl Quadric {
    /// Whether all of a line lies in the surface.
    pub(super) fn holds_line(&self, from: &[f64; 3], direction: &[f64; 3]) -> Option<bool> {
        let all = self.on_line(from, direction, 0.0)?;
        Some(all.iter().all(|x| x.signum() == 0))
    }

    /// Where the line `from + t direction` touches the surface, if it does.
    pub(super) fn touch(&self, from: &[f64; 3], direction: &[f64; 3]) -> Option<Ratio> {
        let [a, b, c] = self.on_line(from, direction, 0.0)?;
        let touches = a.signum() != 0 && &b * &b == &a * &c;
        touches.then(|| Ratio::new(-&b, a))
    }

    /// Whether a root of the line `from + t direction` that is known in an enclosure is `t`, exactly: where `t` is one, and the other (the sum of both is `-2 B / A`) is
    /// not in the enclosure. `None` where that may be.
    pub(super) fn is_root(
        &self,
        [from, direction]: [&[f64; 3]; 2],
        root: Ball<Dd>,
        t: &Ratio,
    ) -> Option<bool> {
        let [a, b, c] = self.on_line(from, direction, 0.0)?;
        let (top, bottom) = (&t.top, &t.bottom);
        let twice = &b + &b;
        let value =
            &(&(&a * top) * top) + &(&(&(&twice * top) * bottom) + &(&(&c * bottom) * bottom));
        if value.signum() != 0 {
            return Some(false);
        }
        if a.signum() == 0 {
            return Some(true);
        }
        let sum = -&(&twice * bottom);
        let other = Ratio::new(&sum - &(&a * top), &a * bottom);
        let off = root - other.enclosed();
        let apart = off.is_above(0.0) || (-off).is_above(0.0);
        (apart || other.cmp(t).is_eq()).then_some(true)
    }

    /// Where a root at `t` of the line `from + t direction`, whose enclosure holds `end`, is beside it; `None` where that is not known.
    ///
    /// `f = A x^2 + 2 B x + C` for `x = t - end`. A double root is at `-B / A`, at the end where `C` is zero. A simple one: where `f' / 2 = A x
    /// + B` has one sign on an interval that holds the end and the enclosure, `f` has one root there, at the end where `C` is zero, else on the
    /// side to which `f` comes nearer to zero. Two roots that are nearer to each other than enclosures tell leave the sign of `f'` open.
    pub(super) fn order(
        &self,
        from: &[f64; 3],
        direction: &[f64; 3],
        end: f64,
        t: Ball<Dd>,
        double: bool,
    ) -> Option<Ordering> {
        let [a, b, c] = self.on_line(from, direction, end)?;
        if double {
            return Some((-a.signum() * b.signum()).cmp(&0));
        }
        let x = t - Ball::exact(end);
        // Half of it is as exact, and within half of its magnitude of both.
        let half = x * Ball::exact(0.5);
        let hull = Ball {
            mid: half.mid,
            rad: (half.mid.hi.abs() + x.rad) * (1.0 + 8.0 * f64::EPSILON),
        };
        let slope = enclosed(&a) * hull + enclosed(&b);
        let rises = if slope.is_above(0.0) {
            1
        } else if (-slope).is_above(0.0) {
            -1
        } else {
            return None;
        };
        Some((-rises * c.signum()).cmp(&0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Interval;
    use crate::nurbs::Line;
    use nalgebra::{Point3, Vector3};

    /// The cone `x^2 + y^2 = (z / 2)^2` above its apex, about an axis that is no unit vector.
    fn cone() -> Quadric {
        let turn = Interval::new(0.0, std::f64::consts::TAU).unwrap();
        let line = Line {
            from: Point3::new(0.5, 0.0, 1.0),
            to: Point3::new(1.5, 0.0, 3.0),
            domain: Interval::new(0.0, 1.0).unwrap(),
        };
        Quadric::new(&Revolution {
            origin: Point3::new(0.0, 0.0, 0.25),
            axis: Vector3::new(0.0, 0.0, 3.0),
            angle: turn,
            angle_domain: turn,
            profile: Curve3::Line(line),
            transposed: false,
        })
        .unwrap()
    }

    #[test]
    fn lines_touch_miss_and_lie_in_a_cone() {
        let cone = cone();
        let count = |from: [f64; 3], d: [f64; 3]| cone.roots(&from, &d, 0.5).map(|r| r.len());
        // Level lines at height 2, where the radius is 1.
        assert_eq!(count([1.0, 0.0, 2.0], [0.0, 1.0, 0.0]), Some(1));
        assert_eq!(
            count([1.0f64.next_up(), 0.0, 2.0], [0.0, 1.0, 0.0]),
            Some(0)
        );
        assert_eq!(
            count([1.0f64.next_down(), 0.0, 2.0], [0.0, 1.0, 0.0]),
            Some(2)
        );
        // A ruling, one beside it, and a parallel to it that meets the surface once.
        assert_eq!(count([1.0, 0.0, 2.0], [0.5, 0.0, 1.0]), None);
        assert_eq!(
            count([1.0f64.next_up(), 0.0, 2.0], [0.5, 0.0, 1.0]),
            Some(1)
        );
        assert_eq!(count([0.0, 1.0, 2.5], [0.5, 0.0, 1.0]), Some(1));
        // Tangent planes hold lines that meet the cone nowhere but in the ruling: parallels to it never.
        assert_eq!(count([1.0, 0.25, 2.0], [0.5, 0.0, 1.0]), Some(0));
    }

    /// A line through a point of the cylinder `x^2 + y^2 = 1` off its tangent by so little that no enclosure tells the second root from the first.
    #[test]
    fn a_root_is_told_from_its_neighbour() {
        let turn = Interval::new(0.0, std::f64::consts::TAU).unwrap();
        let cylinder = Quadric::new(&Revolution {
            origin: Point3::origin(),
            axis: Vector3::z(),
            angle: turn,
            angle_domain: turn,
            profile: Curve3::Line(Line {
                from: Point3::new(1.0, 0.0, 0.0),
                to: Point3::new(1.0, 0.0, 1.0),
                domain: Interval::new(0.0, 1.0).unwrap(),
            }),
            transposed: false,
        });
        let cylinder = cylinder.unwrap();
        let zero = Ratio::from_f64(0.0).unwrap();
        let asked = |slope: f64, root: Ball<Dd>| {
            cylinder.is_root([&[1.0, 0.0, 0.5], &[slope, 1.0, 0.0]], root, &zero)
        };
        let near = |mid: f64, rad: f64| Ball {
            mid: Dd::from(mid),
            rad,
        };
        // The other root is at -2 slope, about.
        assert_eq!(asked(1e-40, near(0.0, 1e-32)), None);
        assert_eq!(asked(1e-40, near(0.0, 1e-41)), Some(true));
        assert_eq!(asked(0.25, near(0.0, 1e-32)), Some(true));
        // The double root of the tangent, and a line that does not meet the surface there.
        assert_eq!(asked(0.0, near(0.0, 1e-32)), Some(true));
        let beside = [&[1.0, 0.5, 0.5], &[0.25, 1.0, 0.0]];
        assert_eq!(
            cylinder.is_root(beside, near(0.0, 1e-32), &zero),
            Some(false)
        );
    }

    #[test]
    fn roots_are_where_the_surface_is() {
        // Along x at height 2 and y = 0.6: x = -0.8 and 0.8; from t = 0.5 on, with steps of 2: x = 1 + 2 t.
        let cone = cone();
        let roots = cone.roots(&[1.0, 0.6, 2.0], &[2.0, 0.0, 0.0], 0.5).unwrap();
        let mut at: Vec<f64> = roots.iter().map(|r| r.x.mid.hi + 0.5).collect();
        at.sort_by(f64::total_cmp);
        // 0.6 is off by 2.2e-17, which moves the roots by less; the sum above is rounded.
        let near = |x: f64, y: f64| (x - y).abs() <= f64::EPSILON;
        assert!(near(at[0], -0.9) && near(at[1], -0.1), "{at:?}");
        let touch = &cone
            .roots(&[1.0, -3.0, 2.0], &[0.0, 0.75, 0.0], 0.0)
            .unwrap()[0];
        assert!(touch.double && touch.x.mid.hi == 4.0 && touch.x.rad < 1e-28);
    }
}
