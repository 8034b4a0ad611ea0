//! Curved pieces of the outline of a plane face, and lines in its plane, exactly.
//!
//! # What is exact
//! The piece is `X(s) / w(s)`, a rational Bezier curve of degree one or two with positive weights, and the line runs through `p` along `q`. Of
//! what is to the left of the line `b = q x (X - w p)` is above zero: in Bernstein form with coefficients `b_i`, dyadic numbers where the
//! control points are (a spline's, or whole quarters of a native circle). With `b_0`, `b_1`, `b_2`:
//!
//! - `b' = 2 ((b_1 - b_0) (1 - s) + (b_2 - b_1) s)`: if and only if these two have opposite signs there is one place within `(0, 1)` where it is
//!   zero, and there `b = (b_0 b_2 - b_1^2) / (b_0 - 2 b_1 + b_2)`. So the signs of `b` at the ends and there are known, and between two of these
//!   places `b` is monotone: it has one simple zero there if their signs are opposite, else none.
//! - Where it is zero and rises, `s = (r - h) / a` with `a = b_0 - 2 b_1 + b_2`, `h = b_1 - b_0`, `r^2 = b_1^2 - b_0 b_2`, for `b' / 2 = a s + h = r`
//!   there; where it falls `-r`. Either is written without cancellation, since `(r - h) (r + h) = -a b_0`.
//! - A zero at an end, or where `b' = 0`, is at a rational `s`, and so is the line's parameter there.
//!
//! Of a piece whose control points are known in enclosures only, whatever a sign is needed of must be known by enclosures, but for ends that are known exactly.
//!
//! A point is on such a curve if both quadratics `X_k - w p_k` have a common root there: if their resultant is zero, which gives the root.

use super::exact::{Ratio, When, dyadic};
use super::polygon::{Event, turn};
use crate::numeric::{Ball, Dd, Dyadic};
use crate::trim::{ExactPiece, ExactPoint};

type D2 = [Dyadic; 2];

/// A piece, relative to the corner of the domain.
#[derive(Debug)]
pub(super) struct Bow {
    pub(super) trim: Option<usize>,
    points: Option<Vec<ExactPoint>>,
    /// Where there are no exact ones.
    balls: Vec<[Ball<Dd>; 3]>,
    ends: [Option<ExactPoint>; 2],
    /// Centre and radius of the circle that it is part of, if it is a native arc's without exact control points.
    circle: Option<(D2, Dyadic)>,
}

/// The line `(p + t q) / square` in the plane, relative to the corner; `q` is not zero along `axis`.
pub(super) struct Track<'a> {
    pub(super) p: &'a D2,
    pub(super) q: &'a D2,
    pub(super) square: &'a Dyadic,
    pub(super) axis: usize,
}

/// What is known of a number's sign.
fn sign(x: &Ball<Dd>) -> Option<i32> {
    if x.is_above(0.0) {
        Some(1)
    } else if (-*x).is_above(0.0) {
        Some(-1)
    } else {
        None
    }
}

/// The form `b` on a piece, and the numerator of the line's parameter, `a / (w q)`.
struct Form {
    /// At the ends, and where `b' = 0` within.
    nodes: Vec<Node>,
    b: [Ball<Dd>; 3],
    a: [Ball<Dd>; 3],
    w: [Ball<Dd>; 3],
    /// Of the line along the axis.
    q: Ball<Dd>,
    /// `b_1^2 - b_0 b_2`.
    square: Ball<Dd>,
}

/// A place of a piece where the sign of `b` is known; where it is zero, the line's parameter.
struct Node {
    sign: i32,
    t: Option<When>,
}

impl Bow {
    /// `None` where its degree is above two. `start` is the corner.
    pub(super) fn new(piece: &ExactPiece, trim: Option<usize>, start: [f64; 2]) -> Option<Self> {
        let corner = [dyadic(start[0])?, dyadic(start[1])?];
        let moved = |p: &ExactPoint| -> ExactPoint {
            let [x, y, w] = p;
            [x - &(w * &corner[0]), y - &(w * &corner[1]), w.clone()]
        };
        let count = piece.balls.len();
        if !(2..=3).contains(&count) {
            return None;
        }
        let points = piece.points.as_ref();
        let [u, v] = start.map(Ball::exact);
        Some(Self {
            trim,
            points: points.map(|p| p.iter().map(moved).collect()),
            balls: match points {
                Some(_) => Vec::new(),
                None => {
                    let moved = piece.balls.iter();
                    moved
                        .map(|[x, y, w]| [*x - *w * u, *y - *w * v, *w])
                        .collect()
                }
            },
            ends: piece.ends.each_ref().map(|e| e.as_ref().map(moved)),
            circle: match piece.circle {
                Some(([x, y], radius)) => {
                    let center = [&dyadic(x)? - &corner[0], &dyadic(y)? - &corner[1]];
                    Some((center, dyadic(radius)?))
                }
                None => None,
            },
        })
    }

    /// Whether `at + A a + B b` is proven to be nowhere negative on it: at its control points, given homogeneous ones, or at the point of its circle where it is least.
    pub(super) fn is_above(
        &self,
        [at, a, b]: [&Dyadic; 3],
        is_above: impl Fn(&D2, &Dyadic) -> bool,
    ) -> bool {
        if let Some(points) = &self.points {
            return points
                .iter()
                .all(|[x, y, w]| is_above(&[x.clone(), y.clone()], w));
        }
        let Some((center, radius)) = &self.circle else {
            return false;
        };
        // At the centre, against the slope times the radius.
        let value = at + &(&(a * &center[0]) + &(b * &center[1]));
        let slope = &(a * a) + &(b * b);
        let fall = &(radius * radius) * &slope;
        value.signum() >= 0 && &value * &value >= fall
    }

    /// Where the line meets the piece; `None` where that is not known.
    pub(super) fn events(&self, line: &Track) -> Option<Vec<Event>> {
        let form = match &self.points {
            Some(points) => exact_form(points, line)?,
            None => self.form(line)?,
        };
        let last = form.nodes.len() - 1;
        // All of it is on the line.
        if form.nodes.iter().all(|n| n.sign == 0) && self.degree() > 1 {
            return None;
        }
        let mut out = Vec::new();
        for (k, node) in form.nodes.iter().enumerate() {
            let Some(t) = &node.t else {
                continue;
            };
            let mut event = Event::new(t.clone(), self.trim);
            if k == 0 || k == last {
                event.ways.push(self.way(k != 0)?);
            }
            out.push(event);
        }
        for pair in form.nodes.windows(2) {
            let [from, to] = [&pair[0], &pair[1]];
            let changes = [
                (from.sign > 0) != (to.sign > 0),
                (from.sign < 0) != (to.sign < 0),
            ];
            if !(changes[0] || changes[1]) {
                continue;
            }
            let t = match (&from.t, &to.t) {
                (Some(t), None) | (None, Some(t)) => t.clone(),
                _ => When::Known(form.root(to.sign > 0)?),
            };
            let mut event = Event::new(t, self.trim);
            event.changes = changes;
            out.push(event);
        }
        Some(out)
    }

    fn degree(&self) -> usize {
        self.points.as_ref().map_or(self.balls.len(), Vec::len) - 1
    }

    /// Along which it leaves one of its ends: exact, or rounded where there are enclosures only.
    fn way(&self, last: bool) -> Option<D2> {
        let between =
            |e: &ExactPoint, n: &ExactPoint| [0, 1].map(|k| &(&n[k] * &e[2]) - &(&e[k] * &n[2]));
        let at = |count: usize| if last { [count - 1, count - 2] } else { [0, 1] };
        if let Some(points) = &self.points {
            let [end, next] = at(points.len());
            return Some(between(&points[end], &points[next]));
        }
        let [end, next] = at(self.balls.len()).map(|k| &self.balls[k]);
        let way = [0, 1].map(|k| next[k] / next[2] - end[k] / end[2]);
        Some([dyadic(way[0].mid.hi)?, dyadic(way[1].mid.hi)?])
    }

    /// The form's signs at the ends of an arc of a circle that the line does not cross, exactly: all else is on one side of the line, unless
    /// the place where it touches the circle is on the arc and no end; `None` where that may be, or it crosses the circle.
    fn beside(&self, line: &Track) -> Option<Vec<Node>> {
        let (center, radius) = self.circle.as_ref()?;
        let one = dyadic(1.0)?;
        let at = less(&[center[0].clone(), center[1].clone(), one], line);
        let height = turn(line.q, &at);
        let reach = radius * line.square;
        let length = &(&line.q[0] * &line.q[0]) + &(&line.q[1] * &line.q[1]);
        let gap = &(&height * &height) - &(&(&reach * &reach) * &length);
        if gap.signum() < 0 {
            return None;
        }
        let mut touched = gap.signum() == 0;
        let nodes = self.ends.each_ref().map(|end| match end {
            Some(point) => {
                let node = exact_node(point, line);
                touched &= node.sign != 0;
                node
            }
            None => Node {
                sign: height.signum(),
                t: None,
            },
        });
        (!touched).then(|| nodes.into())
    }

    /// The form of a piece that is known in enclosures.
    fn form(&self, line: &Track) -> Option<Form> {
        let [p, q] = [line.p, line.q].map(|v| {
            v.each_ref()
                .map(|x| Ratio::new(x.clone(), line.square.clone()).enclosed())
        });
        let count = self.balls.len();
        let e: Vec<[Ball<Dd>; 2]> = self
            .balls
            .iter()
            .map(|[x, y, w]| [*x - *w * p[0], *y - *w * p[1]])
            .collect();
        let b: Vec<Ball<Dd>> = e.iter().map(|e| q[0] * e[1] - q[1] * e[0]).collect();
        let end = |k: usize, at: usize| -> Option<Node> {
            if let Some(point) = &self.ends[k] {
                return Some(exact_node(point, line));
            }
            Some(Node {
                sign: sign(&b[at])?,
                t: None,
            })
        };
        if let Some(nodes) = self.beside(line) {
            let none = [Ball::ZERO; 3];
            return Some(Form {
                nodes,
                b: none,
                a: none,
                w: none,
                q: Ball::ZERO,
                square: Ball::ZERO,
            });
        }
        let (first, last) = (end(0, 0)?, end(1, count - 1)?);
        // All of it is on one side, as its control points are.
        let signs: Vec<Option<i32>> = b.iter().map(sign).collect();
        let one_side = signs[0].is_some() && signs.iter().all(|s| *s == signs[0]);
        let three = |v: &dyn Fn(usize) -> Ball<Dd>| match count {
            2 => [v(0), (v(0) + v(1)).half(), v(1)],
            _ => [v(0), v(1), v(2)],
        };
        let [b0, b1, b2] = three(&|k| b[k]);
        let square = b1.square() - b0 * b2;
        let mut nodes = vec![first];
        if count > 2 && !one_side {
            let rises = [sign(&(b1 - b0))?, sign(&(b2 - b1))?];
            if rises[0] * rises[1] < 0 {
                nodes.push(Node {
                    sign: -sign(&square)? * rises[1],
                    t: None,
                });
            }
        }
        nodes.push(last);
        Some(Form {
            nodes,
            b: [b0, b1, b2],
            a: three(&|k| e[k][line.axis]),
            w: three(&|k| self.balls[k][2]),
            q: q[line.axis],
            square,
        })
    }

    /// Whether a point `p / s` with `s > 0`, relative to the corner, is on it; `None` where that is not known.
    pub(super) fn holds(&self, p: &D2, s: &Dyadic) -> Option<bool> {
        let Some(points) = self.points.as_ref() else {
            return self.holds_on_circle(p, s);
        };
        let at = |k: usize| -> Vec<Dyadic> {
            let of = points.iter();
            of.map(|x| &(&x[k] * s) - &(&x[2] * &p[k])).collect()
        };
        let (a, b) = (at(0), at(1));
        let zero = |x: &Dyadic| x.signum() == 0;
        let end = |k: usize| zero(&a[k]) && zero(&b[k]);
        if end(0) || end(a.len() - 1) {
            return Some(true);
        }
        let pair = |i: usize, k: usize| &(&a[i] * &b[k]) - &(&a[k] * &b[i]);
        if a.len() == 2 {
            let within = (0..2).any(|k| {
                let c = if k == 0 { &a } else { &b };
                c[0].signum() * c[1].signum() < 0
            });
            return Some(zero(&pair(0, 1)) && within);
        }
        // A = a_0 + 2 a_1 x + a_2 x^2 with x = s / (1 - s), and B: b_2 A - a_2 B = (a_0 b_2 - a_2 b_0) + 2 (a_1 b_2 - a_2 b_1) x.
        let (ends, first, second) = (pair(0, 2), pair(0, 1), pair(1, 2));
        let four = dyadic(4.0)?;
        let resultant = &(&ends * &ends) - &(&four * &(&first * &second));
        if !zero(&resultant) {
            return Some(false);
        }
        if zero(&second) {
            return None;
        }
        Some(-ends.signum() * second.signum() > 0)
    }
}

impl Bow {
    /// The same of part of a circle, of a quarter at most: its points are those of the circle that its chord parts from the centre.
    fn holds_on_circle(&self, p: &D2, s: &Dyadic) -> Option<bool> {
        let (center, radius) = self.circle.as_ref()?;
        let off = [0, 1].map(|k| &p[k] - &(&center[k] * s));
        let reach = radius * s;
        if &(&off[0] * &off[0]) + &(&off[1] * &off[1]) != &reach * &reach {
            return Some(false);
        }
        let is = |end: &ExactPoint| (0..2).all(|k| &end[k] * s == &p[k] * &end[2]);
        if self.ends.iter().flatten().any(is) {
            return Some(true);
        }
        let known = |x: &Dyadic, over: &Dyadic| Ratio::new(x.clone(), over.clone()).enclosed();
        let (one, place) = (dyadic(1.0)?, [known(&p[0], s), known(&p[1], s)]);
        let middle = [known(&center[0], &one), known(&center[1], &one)];
        let end = |b: &[Ball<Dd>; 3]| [b[0] / b[2], b[1] / b[2]];
        let (first, last) = (end(self.balls.first()?), end(self.balls.last()?));
        let beside = |x: [Ball<Dd>; 2]| {
            let (along, to) = (
                [last[0] - first[0], last[1] - first[1]],
                [x[0] - first[0], x[1] - first[1]],
            );
            sign(&(along[0] * to[1] - along[1] * to[0]))
        };
        Some(beside(place)? != beside(middle)?)
    }
}

/// `b` at a point that is known exactly.
fn exact_node(point: &ExactPoint, line: &Track) -> Node {
    let e = less(point, line);
    let sign = turn(line.q, &e).signum();
    Node {
        sign,
        t: (sign == 0).then(|| {
            let bottom = &point[2] * &line.q[line.axis];
            When::Exact(Ratio::new(e[line.axis].clone(), bottom))
        }),
    }
}

/// `square X - w p`.
fn less(point: &ExactPoint, line: &Track) -> D2 {
    [0, 1].map(|k| &(&point[k] * line.square) - &(&point[2] * &line.p[k]))
}

/// The form of a piece that is known exactly.
fn exact_form(points: &[ExactPoint], line: &Track) -> Option<Form> {
    let e: Vec<D2> = points.iter().map(|p| less(p, line)).collect();
    let b: Vec<Dyadic> = e.iter().map(|e| turn(line.q, e)).collect();
    let count = points.len();
    let mut nodes = vec![exact_node(&points[0], line)];
    let half = dyadic(0.5)?;
    let three = |v: &dyn Fn(usize) -> Dyadic| match count {
        2 => [v(0), &(&v(0) + &v(1)) * &half, v(1)],
        _ => [v(0), v(1), v(2)],
    };
    let [b0, b1, b2] = three(&|k| b[k].clone());
    let [a0, a1, a2] = three(&|k| e[k][line.axis].clone());
    let [w0, w1, w2] = three(&|k| points[k][2].clone());
    let rises = [&b1 - &b0, &b2 - &b1];
    let square = &(&b1 * &b1) - &(&b0 * &b2);
    if rises[0].signum() * rises[1].signum() < 0 {
        let sign = -square.signum() * rises[1].signum();
        // At s : 1 - s = -rise_0 : rise_1, both times one number above zero.
        let t = (sign == 0).then(|| {
            let (s, r) = if rises[1].signum() > 0 {
                (-&rises[0], rises[1].clone())
            } else {
                (rises[0].clone(), -&rises[1])
            };
            let (rr, rs, ss) = (&r * &r, &(&r * &s) + &(&r * &s), &s * &s);
            let at = |c: [&Dyadic; 3]| &(&(c[0] * &rr) + &(c[1] * &rs)) + &(c[2] * &ss);
            let bottom = &at([&w0, &w1, &w2]) * &line.q[line.axis];
            When::Exact(Ratio::new(at([&a0, &a1, &a2]), bottom))
        });
        nodes.push(Node { sign, t });
    }
    nodes.push(exact_node(&points[count - 1], line));
    // To sizes that f64 holds: a common factor of the b is one of no matter, and one of a, w and q cancels or is kept.
    let largest = |x: [&Dyadic; 3]| {
        let bits = x.map(|x| x.exponent() + x.bits() as i64);
        let of = x.iter().zip(bits).filter(|(x, _)| x.signum() != 0);
        of.map(|(_, b)| b).max().unwrap_or(0)
    };
    let by = -largest([&b0, &b1, &b2]);
    let known = |x: &Dyadic, by: i64| super::exact::enclosed(&x.shifted(by));
    let w_by = -largest([&w0, &w1, &w2]);
    let (q, q_by) = (&line.q[line.axis], -largest([&line.q[line.axis]; 3]));
    Some(Form {
        nodes,
        b: [&b0, &b1, &b2].map(|x| known(x, by)),
        a: [&a0, &a1, &a2].map(|x| known(x, w_by + q_by)),
        w: [&w0, &w1, &w2].map(|x| known(x, w_by)),
        q: known(q, q_by),
        square: known(&square, 2 * by),
    })
}

impl Form {
    /// The line's parameter at the zero where `b` rises, or falls; `None` where it is not known.
    fn root(&self, rises: bool) -> Option<Ball<Dd>> {
        let [b0, b1, b2] = self.b;
        let (a, h) = (b2 - b1 - (b1 - b0), b1 - b0);
        let r = if self.square.is_above(0.0) {
            self.square.sqrt()
        } else {
            return None;
        };
        let s = match (rises, h.mid > Dd::ZERO) {
            (true, true) => -(b0 / (h + r)),
            (true, false) => (r - h) / a,
            (false, true) => -((r + h) / a),
            (false, false) => b0 / (r - h),
        };
        let o = Ball::ONE - s;
        let at = |c: [Ball<Dd>; 3]| c[0] * o.square() + (c[1] + c[1]) * (o * s) + c[2] * s.square();
        let t = at(self.a) / (at(self.w) * self.q);
        t.rad.is_finite().then_some(t)
    }
}
