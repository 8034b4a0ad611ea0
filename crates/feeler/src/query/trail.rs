//! Where a query of a probe that moves looks first.

use super::outcome::{Foot, Locus, Source};
use nalgebra::{Point2, Point3, Vector3};

/// A place to start from: a seed, of which nothing is believed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hint {
    pub(crate) face: usize,
    pub(crate) uv: Point2<f64>,
    /// The same as a patch and local parameters, where these are known.
    pub(crate) local: Option<(usize, [f64; 2])>,
    /// Where in that patch the next foot seems to be.
    pub(crate) ahead: Option<[f64; 2]>,
    /// The boundary piece that it was found on, if it was, and the parameter.
    pub(crate) piece: Option<(usize, f64)>,
}

/// Where the last foot was, and where the feet of a ball that goes straight on lead to.
#[derive(Clone, Debug, Default)]
pub(super) struct Trail {
    last: Option<Hint>,
    course: Option<Course>,
}

impl Trail {
    /// One that knows of one place.
    pub(super) fn at(face: usize, uv: Point2<f64>) -> Self {
        let hint = Hint {
            face,
            uv,
            local: None,
            ahead: None,
            piece: None,
        };
        Self {
            last: Some(hint),
            course: None,
        }
    }

    /// Adds a foot, and the ball's centre if there is one.
    pub(super) fn add(&mut self, foot: Option<&Foot>, center: Option<Point3<f64>>) {
        self.last = foot.map(|foot| {
            let local = match &foot.spot {
                Locus::Patch { patch, local, .. } => {
                    Some((*patch, local.map(|x| x.mid.hi.clamp(0.0, 1.0))))
                }
                Locus::Closed { .. } => None,
            };
            let piece = match foot.found {
                Some((Source::Piece { index, .. }, [t, _])) => Some((index, t)),
                _ => None,
            };
            Hint {
                face: foot.face,
                uv: foot.uv,
                local,
                ahead: None,
                piece,
            }
        });
        let place = self
            .last
            .and_then(|h| Some(((h.face, h.local?.0), h.local?.1)));
        let (Some((patch, foot)), Some(center)) = (place, center) else {
            self.course = None;
            return;
        };
        match &mut self.course {
            Some(course) if course.patch == patch => course.add(center, foot),
            _ => self.course = Some(Course::from(patch, center, foot)),
        }
    }

    /// The last foot, and for a ball whose last feet were on one patch the place where they lead to.
    pub(super) fn hint(&self, center: Option<Point3<f64>>) -> Option<Hint> {
        let mut hint = self.last?;
        let course = self.course.as_ref();
        hint.ahead = course.zip(center).and_then(|(way, c)| way.at(c));
        Some(hint)
    }
}

/// The feet of a ball that goes along a line, as Newton's divided differences over its way: the polynomial through the last `n` feet, followed on,
/// leaves what is of order `n` in the ball's step. (One step of Newton's method from the last foot leaves the second.)
#[derive(Clone, Debug)]
struct Course {
    /// The face and its patch on which they are.
    patch: (usize, usize),
    /// The centre where it began...
    start: Point3<f64>,
    /// ...the first step from there, and its product with that is the way in such steps.
    step: Vector3<f64>,
    along: Vector3<f64>,
    /// How far the ball was at the last feet, the last first, and the differences over the first, the first two, ... of these.
    way: [f64; FEET],
    differences: [[f64; 2]; FEET],
    count: usize,
}

/// So many feet tell where the next one is.
const FEET: usize = 5;
/// A ball that goes on by more than this times its last step is not followed.
const MOST_AHEAD: f64 = 4.0;
/// The square of how far, in parts of the first step, a centre may lie off the line.
const TURNED: f64 = 0.01;
/// A step shorter than this part of the first is no step.
const LEAST_STEP: f64 = 1.0 / 64.0;

impl Course {
    fn from(patch: (usize, usize), start: Point3<f64>, foot: [f64; 2]) -> Self {
        let mut differences = [[0.0; 2]; FEET];
        differences[0] = foot;
        Self {
            patch,
            start,
            step: Vector3::zeros(),
            along: Vector3::zeros(),
            way: [0.0; FEET],
            differences,
            count: 1,
        }
    }

    /// Goes on to a foot; from the last one, where the ball turned.
    fn add(&mut self, center: Point3<f64>, foot: [f64; 2]) {
        let mut off = center - self.start;
        let mut way = off.dot(&self.along);
        let turned = (off - self.step * way).norm_squared() > TURNED * self.step.norm_squared();
        if self.count > 1 && (turned || way < self.way[0] + LEAST_STEP) {
            let last = self.start + self.step * self.way[0];
            *self = Self::from(self.patch, last, self.differences[0]);
            off = center - last;
        }
        if self.count == 1 {
            let length = off.norm_squared();
            // Negated: a ball that stays goes nowhere.
            if !(length > 0.0) {
                self.differences[0] = foot;
                return;
            }
            (self.step, self.along) = (off, off / length);
            way = 1.0;
        }
        let mut new = foot;
        for k in 0..FEET {
            let old = std::mem::replace(&mut self.differences[k], new);
            if k == self.count || k + 1 == FEET {
                break;
            }
            let over = 1.0 / (way - self.way[k]);
            new = [0, 1].map(|c| (new[c] - old[c]) * over);
        }
        self.way.copy_within(..FEET - 1, 1);
        self.way[0] = way;
        self.count = (self.count + 1).min(FEET);
    }

    /// Where the foot of a ball at a centre seems to be.
    fn at(&self, center: Point3<f64>) -> Option<[f64; 2]> {
        let way = (center - self.start).dot(&self.along);
        let last_step = self.way[0] - self.way[1];
        // Negated: nor is what is no number followed.
        if self.count == 1 || !((way - self.way[0]).abs() <= MOST_AHEAD * last_step) {
            return None;
        }
        let mut place = self.differences[self.count - 1];
        for k in (0..self.count - 1).rev() {
            let over = way - self.way[k];
            place = [0, 1].map(|c| self.differences[k][c] + over * place[c]);
        }
        Some(place.map(|x| x.clamp(0.0, 1.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(way: f64) -> Point3<f64> {
        Point3::new(1.0, 2.0, 3.0) + Vector3::new(2.0, -1.0, 0.5) * way
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

        /// Feet that are polynomials of degree `FEET - 1` over the way are followed, whatever the steps, and however many went before.
        #[test]
        fn polynomials_are_followed(
            steps in prop::collection::vec(0.5..2.0f64, FEET..12),
            coefficients in prop::array::uniform5([-0.1..0.1f64, -0.1..0.1f64]),
        ) {
            let total: f64 = steps.iter().sum();
            let foot = |way: f64| {
                let x = way / total;
                [0, 1].map(|c| 0.5 + coefficients.iter().rev().fold(0.0, |sum, p| sum * x + 0.5 * p[c]))
            };
            let mut way = 0.0;
            let mut course = Course::from((0, 0), at(way), foot(way));
            for (k, step) in steps.iter().enumerate() {
                way += step;
                let told = course.at(at(way));
                if k < FEET {
                    prop_assert_eq!(told.is_some(), k > 0);
                } else if let Some(told) = told {
                    // Differences of some roundings of 1 over steps of 1/24 of the way at least, four times: 2^-52 24^4 is 2^-33.
                    let off = [0, 1].map(|c| (told[c] - foot(way)[c]).abs());
                    prop_assert!(off[0].max(off[1]) < 1.0 / (1u64 << 33) as f64, "{:?}", off);
                }
                course.add(at(way), foot(way));
            }
        }
    }

    /// After a turn the feet before it tell nothing; nor is a ball followed that stays, or goes much farther than it did.
    #[test]
    fn what_is_not_followed() {
        // All numbers here are exact.
        let at = |way: f64| Point3::new(2.0 * way, 0.0, 0.0);
        let mut course = Course::from((0, 0), at(0.0), [0.5, 0.5]);
        assert_eq!(course.at(at(1.0)), None);
        course.add(at(0.0), [0.25, 0.5]);
        assert_eq!(course.at(at(1.0)), None, "it stayed");
        course.add(at(1.0), [0.5, 0.5]);
        assert_eq!(course.at(at(1.5)), Some([0.625, 0.5]));
        assert_eq!(course.at(at(6.0)), None, "too far");
        // Back again: from the last foot on.
        course.add(at(0.5), [0.25, 0.75]);
        assert_eq!(course.count, 2);
        assert_eq!(course.at(at(0.25)), Some([0.125, 0.875]));
    }
}
