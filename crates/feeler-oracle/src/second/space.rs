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
    /// Not above it.
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

fn bound(least: &Least, of: impl Fn(&Ball) -> Ball) -> Bound {
    let end = |x: Ball| x.center();
    Bound {
        lo: end(of(&least.low).lower()),
        hi: least.high.as_ref().map(|h| end(of(h).upper())),
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
