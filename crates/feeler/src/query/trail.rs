//! Where a query of a probe that moves looks first.

use super::outcome::{Foot, Locus};
use nalgebra::{Point2, Point3};

/// A place to start from: a seed, of which nothing is believed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hint {
    pub(crate) face: usize,
    pub(crate) uv: Point2<f64>,
    /// The same as a patch and local parameters, where these are known.
    pub(crate) local: Option<(usize, [f64; 2])>,
    /// Where in that patch the next foot seems to be.
    pub(crate) ahead: Option<[f64; 2]>,
}

/// Where the last two feet were, and the centres of the balls.
#[derive(Clone, Debug, Default)]
pub(super) struct Trail {
    last: Option<(Hint, Option<Point3<f64>>)>,
    before: Option<(Hint, Option<Point3<f64>>)>,
}

/// A ball that goes on by more than this times its last step is not followed.
const MOST_AHEAD: f64 = 4.0;

impl Trail {
    /// One that knows of one place.
    pub(super) fn at(face: usize, uv: Point2<f64>) -> Self {
        let hint = Hint {
            face,
            uv,
            local: None,
            ahead: None,
        };
        Self {
            last: Some((hint, None)),
            before: None,
        }
    }

    /// Adds a foot, and the ball's centre if there is one.
    pub(super) fn add(&mut self, foot: Option<&Foot>, center: Option<Point3<f64>>) {
        self.before = self.last.take();
        self.last = foot.map(|foot| {
            let local = match &foot.spot {
                Locus::Patch { patch, local, .. } => {
                    Some((*patch, local.map(|x| x.mid.hi.clamp(0.0, 1.0))))
                }
                Locus::Closed { .. } => None,
            };
            let hint = Hint {
                face: foot.face,
                uv: foot.uv,
                local,
                ahead: None,
            };
            (hint, center)
        });
    }

    /// The last foot, and for a ball whose last two feet were on one patch the place that is as far on from the last as the ball has gone on from there, in
    /// parts of the step before. What is left is of second order in the step, as after one step of Newton's method from the last foot.
    pub(super) fn hint(&self, center: Option<Point3<f64>>) -> Option<Hint> {
        let (mut hint, last) = self.last?;
        hint.ahead = self.ahead(&hint, last, center);
        Some(hint)
    }

    fn ahead(
        &self,
        hint: &Hint,
        last: Option<Point3<f64>>,
        center: Option<Point3<f64>>,
    ) -> Option<[f64; 2]> {
        let (before, first) = self.before.as_ref()?;
        let ((patch, at), (other, from)) = (hint.local?, before.local?);
        if (hint.face, patch) != (before.face, other) {
            return None;
        }
        let (step, way) = (last? - (*first)?, center? - last?);
        let share = way.dot(&step) / step.norm_squared();
        // Negated: a ball that did not move is followed no further.
        if !(share.abs() <= MOST_AHEAD) {
            return None;
        }
        Some(std::array::from_fn(|k| {
            (at[k] + share * (at[k] - from[k])).clamp(0.0, 1.0)
        }))
    }
}
