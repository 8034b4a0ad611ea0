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

/// Where the last three feet were, the last first, and the centres of the balls.
#[derive(Clone, Debug, Default)]
pub(super) struct Trail {
    feet: [Option<(Hint, Option<Point3<f64>>)>; 3],
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
            feet: [Some((hint, None)), None, None],
        }
    }

    /// Adds a foot, and the ball's centre if there is one.
    pub(super) fn add(&mut self, foot: Option<&Foot>, center: Option<Point3<f64>>) {
        let [last, before, _] = std::mem::take(&mut self.feet);
        let new = foot.map(|foot| {
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
        self.feet = [new, last, before];
    }

    /// The last foot, and for a ball whose last feet were on one patch the place where they lead to.
    pub(super) fn hint(&self, center: Option<Point3<f64>>) -> Option<Hint> {
        let mut hint = self.feet[0]?.0;
        hint.ahead = center.and_then(|c| self.ahead(&hint, c));
        Some(hint)
    }

    /// The polynomial through the last two or three feet, over the way of the ball along its last step, is followed on (Newton's divided differences): what is
    /// left is of second or third order in the step. One step of Newton's method from the last foot leaves the second.
    fn ahead(&self, hint: &Hint, center: Point3<f64>) -> Option<[f64; 2]> {
        let (patch, p) = hint.local?;
        let place = |foot: &Option<(Hint, Option<Point3<f64>>)>| {
            let (own, center) = foot.as_ref()?;
            let (index, local) = own.local?;
            ((own.face, index) == (hint.face, patch)).then_some((local, (*center)?))
        };
        let (_, last) = place(&self.feet[0])?;
        let (q, before) = place(&self.feet[1])?;
        let step = last - before;
        let length = step.norm_squared();
        // In steps, from the last centre; that of the one before is -1.
        let along = |c: Point3<f64>| (c - last).dot(&step) / length;
        let t = along(center);
        // Negated: a ball that did not move is followed no further.
        if !(t.abs() <= MOST_AHEAD) {
            return None;
        }
        let bent = place(&self.feet[2]).and_then(|(r, first)| {
            let s = along(first);
            // Of a ball that turned the third foot tells nothing.
            let straight = (first - last - step * s).norm_squared() <= TURNED * length;
            (straight && s < -1.0 - LEAST_STEP).then_some((r, s))
        });
        Some(std::array::from_fn(|k| {
            let slope = p[k] - q[k];
            let bend = bent.map_or(0.0, |(r, s)| ((q[k] - r[k]) / (-1.0 - s) - slope) / s);
            (p[k] + t * (slope + (t + 1.0) * bend)).clamp(0.0, 1.0)
        }))
    }
}

/// The square of how far, in parts of a step, a centre may lie off the line of the step.
const TURNED: f64 = 0.01;
/// A step shorter than this part of the next one is no step.
const LEAST_STEP: f64 = 1.0 / 64.0;
