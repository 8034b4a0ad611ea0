//! Separations by the second method.

use super::number::{Ball, Number};
use super::search::{Goal, Least, Scene};
use feeler::brep::Brep;
use feeler::numeric::Dyadic;

/// The second oracle of some BREPs, whose faces are numbered through all of them in order.
///
/// `Send` and `Sync`, unlike the first.
pub struct Second<'a> {
    pub(super) scene: Scene<'a>,
    budget: [usize; 2],
}

/// What the second method proved of a minimum.
#[derive(Clone, Debug)]
pub struct Bound {
    /// Not above it; -2^4096, below all that can be asked for, where nothing is known.
    pub lo: Dyadic,
    /// Not below it; `None` if no point was proven to belong to a face.
    pub hi: Option<Dyadic>,
    /// Boxes looked at in f64, and in balls.
    pub nodes: [usize; 2],
}

impl Bound {
    /// `hi - lo`, about; infinite without an upper end.
    pub fn width(&self) -> f64 {
        match &self.hi {
            Some(hi) => (hi - &self.lo).approximate(),
            None => f64::INFINITY,
        }
    }
}

/// Boxes in f64 and in balls, unless told otherwise.
pub const BUDGET: [usize; 2] = [5000, 400];

/// -2^4096: products of f64 are no lower.
const BELOW_ALL: i64 = 4096;

fn bound(least: &Least, of: impl Fn(&Ball) -> Ball) -> Bound {
    // Of what nothing is known (few boxes next to a point that is too far away for f64) there is no end.
    let end = |x: Ball| x.is_point().then(|| x.center());
    let low = end(of(&least.low).lower());
    Bound {
        lo: low.unwrap_or_else(|| Dyadic::new((-1).into(), BELOW_ALL)),
        hi: least.high.as_ref().and_then(|h| end(of(h).upper())),
        nodes: least.nodes,
    }
}

impl<'a> Second<'a> {
    /// Takes the BREPs apart into smooth pieces: O(their size).
    pub fn new(breps: &[&'a Brep]) -> Self {
        Self {
            scene: Scene::new(breps),
            budget: BUDGET,
        }
    }

    /// The same for distances and half-spaces that look at no more boxes than these, in f64 and in balls, instead of [`BUDGET`]: where that is too few,
    /// bounds are wider, and hold. A box on a curve of degree p costs O(p^3).
    #[must_use]
    pub fn with_budget(self, budget: [usize; 2]) -> Self {
        Self { budget, ..self }
    }

    /// The distance from a point to the union of the trimmed faces; `None` if there is none. Milliseconds,
    /// up to a second on the focal set of a surface, and the bound may be wide there.
    pub fn distance(&self, point: [f64; 3]) -> Option<Bound> {
        self.distance_to(point, None)
    }

    pub(super) fn distance_to(&self, point: [f64; 3], brep: Option<usize>) -> Option<Bound> {
        let least = self
            .scene
            .least(&Goal::Distance(point), brep, self.budget)?;
        let two = Ball::exact(2.0);
        Some(bound(&least, |f| {
            if f.is_negative() {
                Ball::exact(0.0)
            } else {
                f.times(&two).root()
            }
        }))
    }

    /// The least `normal . x - offset` over the union of the trimmed faces, with `normal` as given.
    pub fn half_space(&self, normal: [f64; 3], offset: f64) -> Option<Bound> {
        let least = self
            .scene
            .least(&Goal::Plane(normal, offset), None, self.budget)?;
        Some(bound(&least, Ball::clone))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball without bounds has a middle all the same, which is no bound.
    #[test]
    fn what_is_not_known_is_no_bound() {
        let anything = || Ball::exact(0.0).widened(f64::INFINITY);
        let least = Least {
            low: anything(),
            high: Some(Ball::exact(-2.5)),
            nodes: [1, 1],
        };
        let found = bound(&least, Ball::clone);
        assert!(found.lo < Dyadic::from_f64(f64::MIN).unwrap());
        assert_eq!(found.hi, Dyadic::from_f64(-2.5));
        assert_eq!(found.width(), f64::INFINITY);
        let least = Least {
            low: Ball::exact(-3.0),
            high: Some(anything()),
            nodes: [1, 1],
        };
        let found = bound(&least, Ball::clone);
        assert_eq!(found.lo, Dyadic::from_f64(-3.0).unwrap());
        assert_eq!(found.hi, None);
    }
}
