//! Whether a contact is a continuum, as an answer says, judged from the model itself.
//!
//! A minimum is a continuum where points of the faces that are no higher than it by more than a slack, and hang together, reach farther from its foot than
//! the reach (module docs of the kernel). So every circle about the foot of that radius has a low point, which is looked for: over the face, all the way round, and along
//! the trims that begin at the foot. Nothing of the kernel's search is in it: the faces are evaluated, and their trims asked for sides.
//!
//! Each way the answer has the benefit of the doubt. It is wrong to deny a continuum where a way over the face or along a trim, low by half the slack all
//! along, leaves the reach. It is wrong to claim one where half the reach away, the same way round, all is higher than twice the slack, and where the truth
//! knows of one foot alone; of edges, seams and poles nothing is held against a claim, as faces beyond them may be low. What f64 cannot tell is not judged.

use crate::cases::Loaded;
use crate::place::{faces, local};
use feeler::brep::{Brep, TrimCurve};
use feeler::nurbs::Surface;
use feeler::prepare::PreparedBrep;
use feeler::query::{Accuracy, Feature, Probe, side};
use feeler::trim::Side;
use feeler_corpus::{Asked, Body, CONTINUUM_SLACK, ContactLine, Truth};
use nalgebra::{Point2, Point3};
use std::f64::consts::TAU;

/// Of the definition: points are low within the accuracy, or [`CONTINUUM_SLACK`] of the size, and far beyond this part of it.
const REACH: f64 = 1.0 / (1u64 << 12) as f64;

/// What is amiss with the claim that the contact is a continuum, or that it is none; `None` also where that cannot be told.
pub(crate) fn misjudged(
    loaded: &Loaded,
    asked: &Asked,
    answer: &Body,
    truth: &Truth,
) -> Option<String> {
    let Body::Contact {
        continuum: Some(claimed),
        contacts,
        undecided: None,
        ..
    } = answer
    else {
        return None;
    };
    let (first, probe) = (contacts.first()?, asked.probe?);
    let (prepared, feature) = local(&loaded.prepared, first.feature?)?;
    let (separation, one_foot) = match truth {
        Truth::Separation(separation) => (separation, false),
        Truth::Contact {
            separation, foot, ..
        } => (separation, foot.is_some()),
        _ => return None,
    };
    let [lo, hi] = [&separation.lo, &separation.hi].map(|x| x.approximate());
    let least = match probe {
        Probe::Sphere(s) => separation.raised(s.radius)[0].abs(),
        Probe::HalfSpace(h) => separation.raised(h.offset)[0],
    };
    let around = Around {
        brep: prepared,
        probe,
        foot: first.on_brep.into(),
        least,
    };
    // The size is the BREP's own in the kernel, and the model's in the definition.
    let [small, large] = [prepared.size(), loaded.size];
    let [low, high] = match asked.accuracy {
        Accuracy::Length(a) => [a, a],
        // As wide as full accuracy may be, which counts where the probe is far away.
        Accuracy::Full => [0.0, 2.0 * feeler_corpus::ulp(hi.abs().max(lo.abs()))],
    };
    let rounded = around.rounded(large) + (hi - lo).abs();
    if *claimed {
        let slack = high.max(CONTINUUM_SLACK * large);
        let is_telling = one_foot && rounded <= TELLING * slack;
        let told = || around.is_steep(feature, first, 2.0 * slack, 0.5 * REACH * small);
        (is_telling && told())
            .then(|| "a continuum is claimed, and all is higher next to its foot".to_owned())
    } else {
        let slack = low.max(CONTINUUM_SLACK * small);
        // A way that is half as low leaves no doubt.
        let is_telling = rounded <= TELLING * slack;
        let far =
            is_telling.then(|| around.far(feature, first, 0.5 * slack, BEYOND * REACH * large));
        far.flatten().map(|x| {
            let off = (x - around.foot).norm();
            format!("no continuum is claimed, and {x:?}, {off:e} from the foot, is as low, and so is a way there")
        })
    }
}

/// Roundings that are no more than this part of the slack change nothing.
const TELLING: f64 = 1.0 / 8.0;
/// How far a way must lead, in units of the reach.
const BEYOND: f64 = 1.25;
/// So many directions are tried around a foot. Over so little of a face the height is a form of the second degree around it, and turns four times...
const DIRECTIONS: usize = 32;
/// ...and between two of them it falls below both by no more than this part of how much it differs around: `1 - cos(2 pi / 32) < 1 / 50`, twice.
const BETWEEN: f64 = 1.0 / 25.0;
/// Steps of a way.
const STEPS: usize = 64;

/// A foot, and what is low around it.
struct Around<'a> {
    brep: &'a PreparedBrep,
    probe: Probe,
    foot: Point3<f64>,
    /// Of the heights of all points.
    least: f64,
}

impl Around<'_> {
    fn height(&self, x: &Point3<f64>) -> f64 {
        let height = match self.probe {
            Probe::Sphere(s) => (x - s.center).norm(),
            Probe::HalfSpace(h) => h.normal.dot(&x.coords),
        };
        height - self.least
    }

    /// By how much heights may be off: a few roundings of what they are made of.
    fn rounded(&self, size: f64) -> f64 {
        let more = match self.probe {
            Probe::Sphere(s) => s.center.coords.amax(),
            Probe::HalfSpace(h) => h.offset.abs(),
        };
        16.0 * f64::EPSILON * self.foot.coords.amax().max(size).max(more).max(self.least)
    }

    /// A point farther than `reach` from the foot, with a way there all along which nothing is higher than `slack`.
    fn far(
        &self,
        feature: Feature,
        first: &ContactLine,
        slack: f64,
        reach: f64,
    ) -> Option<Point3<f64>> {
        let brep = self.brep.brep();
        let along = self
            .ends(feature)
            .find_map(|end| end.way(self, reach).filter(|w| w.highest <= slack));
        if let Some(way) = along {
            return Some(way.to);
        }
        let ring = |face: usize, uv: Point2<f64>| {
            let ring = Ring::new(self, face, uv, reach)?;
            let mut low = ring.turns(slack).into_iter();
            let low = low.find(|d| ring.height(*d) <= slack && self.is_low_way(&ring, *d, slack));
            low.map(|d| ring.at(d).1)
        };
        let uv = Point2::from(first.uv?);
        let own = faces(brep, feature).into_iter().find_map(|face| {
            let off = (brep.surface(face).point(uv.x, uv.y) - self.foot).norm();
            (off <= NEAR * self.brep.size())
                .then(|| ring(face, uv))
                .flatten()
        });
        own.or_else(|| self.ends(feature).find_map(|end| ring(end.face, end.uv())))
    }

    /// Whether a straight way over the parameters is low, and in the face.
    fn is_low_way(&self, ring: &Ring<'_>, to: f64, slack: f64) -> bool {
        let (to, _) = ring.at(to);
        let surface = self.brep.brep().surface(ring.face);
        (0..=STEPS).all(|k| {
            let uv = ring.from + (to - ring.from) * (k as f64 / STEPS as f64);
            self.height(&surface.point(uv.x, uv.y)) <= slack
                && (k == 0 || is_in(self.brep, ring.face, uv))
        })
    }

    /// Whether all is higher than `slack` at a distance of `reach` from a foot inside of a face.
    fn is_steep(&self, feature: Feature, first: &ContactLine, slack: f64, reach: f64) -> bool {
        let (Feature::Face(face), Some(uv)) = (feature, first.uv) else {
            return false;
        };
        let Some(ring) = Ring::new(self, face, uv.into(), reach) else {
            return false;
        };
        // The foot itself must be low, and no part of the ring beyond the face.
        let is_whole = ring.directions().all(|d| {
            let height = ring.height(d);
            height.is_finite() && is_in(self.brep, face, ring.at(d).0)
        });
        self.height(&self.foot) <= slack && is_whole && {
            let turns = ring.turns(slack);
            turns.into_iter().all(|d| ring.height(d) > slack)
        }
    }

    /// Where trims of a feature pass the foot.
    fn ends(&self, feature: Feature) -> impl Iterator<Item = End<'_>> {
        let brep = self.brep.brep();
        let parts = brep.parts();
        let is_on = move |t: &TrimCurve| match feature {
            Feature::Face(_) => false,
            Feature::Edge(e) => t.edge == Some(e),
            Feature::Vertex(v) => t.vertices.contains(&v),
        };
        let near = NEAR * self.brep.size();
        { parts.trims.iter() }
            .filter(move |t| is_on(t))
            .filter_map(move |trim| {
                let face = parts.loops.get(trim.trim_loop)?.face;
                let at = nearest(brep, face, trim, &self.foot)?;
                Some(End {
                    brep,
                    face,
                    trim,
                    at,
                })
            })
            .filter(move |end| {
                let uv = end.uv();
                (brep.surface(end.face).point(uv.x, uv.y) - self.foot).norm() <= near
            })
    }
}

/// What is so near, as a part of the size, may be the foot: faces lie apart at edges, and feet next to a vertex are said to be there.
const NEAR: f64 = 1.0 / (1_u64 << 32) as f64;

/// The parameter of a trim where it is nearest to a point.
fn nearest(brep: &Brep, face: usize, trim: &TrimCurve, point: &Point3<f64>) -> Option<f64> {
    const PARTS: usize = 64;
    const THIRDS: usize = 80;
    let curve = brep.parts().curves2.get(trim.curve)?;
    let surface = brep.surface(face);
    let off = |s: f64| {
        let uv = curve.point(trim.span.lerp(s));
        (surface.point(uv.x, uv.y) - point).norm()
    };
    let at = |k: usize| k as f64 / PARTS as f64;
    let best = (0..=PARTS).min_by(|a, b| off(at(*a)).total_cmp(&off(at(*b))))?;
    let [mut a, mut b] = [at(best.saturating_sub(1)), at((best + 1).min(PARTS))];
    for _ in 0..THIRDS {
        let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        if off(c) < off(d) { b = d } else { a = c }
    }
    [at(best), a, b]
        .into_iter()
        .min_by(|a, b| off(*a).total_cmp(&off(*b)))
}

/// Where a trim is at the foot.
struct End<'a> {
    brep: &'a Brep,
    face: usize,
    trim: &'a TrimCurve,
    /// From 0 to 1 over the trim.
    at: f64,
}

/// A way along a trim.
struct Way {
    to: Point3<f64>,
    highest: f64,
}

impl End<'_> {
    fn uv_at(&self, s: f64) -> Point2<f64> {
        match self.brep.parts().curves2.get(self.trim.curve) {
            Some(curve) => {
                let [u, v] = self.brep.surface(self.face).domain();
                let uv = curve.point(self.trim.span.lerp(s));
                // As the definition has it.
                Point2::new(uv.x.clamp(u.start, u.end), uv.y.clamp(v.start, v.end))
            }
            None => Point2::new(f64::NAN, f64::NAN),
        }
    }

    fn uv(&self) -> Point2<f64> {
        self.uv_at(self.at)
    }

    /// The lower one of the two ways along the trim that lead beyond `reach`.
    fn way(&self, around: &Around<'_>, reach: f64) -> Option<Way> {
        let surface = self.brep.surface(self.face);
        let point = |s: f64| {
            let uv = self.uv_at(s);
            surface.point(uv.x, uv.y)
        };
        let off = |s: f64| (point(s) - around.foot).norm();
        let ways = [0.0, 1.0].into_iter().filter_map(|end| {
            // The first place that is far enough, by halves of the way there.
            let step = |k: usize| self.at + (end - self.at) * (k as f64 / STEPS as f64);
            let first = (1..=STEPS).find(|k| off(step(*k)) > reach)?;
            let [mut near, mut far] = [step(first - 1), step(first)];
            for _ in 0..60 {
                let middle = 0.5 * (near + far);
                if off(middle) > reach {
                    far = middle
                } else {
                    near = middle
                }
            }
            let heights = (1..=STEPS).map(|k| {
                around.height(&point(
                    self.at + (far - self.at) * (k as f64 / STEPS as f64),
                ))
            });
            Some(Way {
                to: point(far),
                highest: heights.fold(f64::NEG_INFINITY, nan_max),
            })
        });
        ways.min_by(|a, b| a.highest.total_cmp(&b.highest))
    }
}

/// The larger one; what is no number is larger than any.
fn nan_max(a: f64, b: f64) -> f64 {
    if b.is_nan() || b > a { b } else { a }
}

/// What is about as far from the foot, over one face.
struct Ring<'a> {
    around: &'a Around<'a>,
    surface: &'a Surface,
    face: usize,
    from: Point2<f64>,
    /// How far in either parameter goes as far as the ring.
    step: [f64; 2],
    reach: f64,
}

impl<'a> Ring<'a> {
    /// `None` next to a pole, and where derivatives are no numbers.
    fn new(around: &'a Around<'a>, face: usize, from: Point2<f64>, reach: f64) -> Option<Self> {
        let surface = around.brep.brep().surface(face);
        let at = surface.first_derivatives_with_bound(from.x, from.y);
        let [u, v] = surface.domain();
        let step = [reach / at.du.norm(), reach / at.dv.norm()];
        let fits = step[0] <= 0.25 * u.length() && step[1] <= 0.25 * v.length();
        // Where parameter lines all but coincide, directions are not what they seem.
        let sine = at.du.cross(&at.dv).norm() / (at.du.norm() * at.dv.norm());
        (fits && sine > 0.1).then_some(Self {
            around,
            surface,
            face,
            from,
            step,
            reach,
        })
    }

    fn directions(&self) -> impl Iterator<Item = f64> {
        (0..DIRECTIONS).map(|k| TAU * k as f64 / DIRECTIONS as f64)
    }

    /// A place in a direction, beyond the reach by a little.
    fn at(&self, direction: f64) -> (Point2<f64>, Point3<f64>) {
        const UP: f64 = 1.0 + 1.0 / 64.0;
        let (sin, cos) = direction.sin_cos();
        /// A sine of less is one of a multiple of pi, but for its roundings.
        const ALONG: f64 = 1e-12;
        // Exactly along a parameter where that is meant.
        let whole = |x: f64| if x.abs() < ALONG { 0.0 } else { x };
        let way = [whole(cos) * self.step[0], whole(sin) * self.step[1]];
        let place = |t: f64| {
            let uv = Point2::new(self.from.x + t * way[0], self.from.y + t * way[1]);
            (uv, self.surface.point(uv.x, uv.y))
        };
        let mut t = 1.0;
        for _ in 0..3 {
            let off = (place(t).1 - self.around.foot).norm();
            t *= UP * self.reach / off;
        }
        place(t)
    }

    /// How high it is in a direction; infinite beyond the domain and where the ring is not as far as it should be.
    fn height(&self, direction: f64) -> f64 {
        let (uv, point) = self.at(direction);
        let [u, v] = self.surface.domain();
        let off = (point - self.around.foot).norm();
        let is_there = u.start <= uv.x && uv.x <= u.end && v.start <= uv.y && uv.y <= v.end;
        if is_there && off >= self.reach && off <= 1.5 * self.reach {
            self.around.height(&point)
        } else {
            f64::INFINITY
        }
    }

    /// The directions in which it is lower than beside them, if any may be as low as `low`.
    fn turns(&self, low: f64) -> Vec<f64> {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let heights: Vec<f64> = self.directions().map(|d| self.height(d)).collect();
        let finite = || heights.iter().copied().filter(|h| h.is_finite());
        let least = finite().fold(f64::INFINITY, f64::min);
        let most = finite().fold(f64::NEG_INFINITY, f64::max);
        // Negated in effect: what is no number is not low.
        let may_be_low = least - BETWEEN * (most - least) <= low;
        let n = heights.len();
        let turns = (0..n).filter(|k| {
            let [before, after] = [heights[(k + n - 1) % n], heights[(k + 1) % n]];
            may_be_low && heights[*k] <= before && heights[*k] <= after && heights[*k].is_finite()
        });
        let spacing = TAU / n as f64;
        let refined = turns.flat_map(|k| {
            let middle = spacing * k as f64;
            let (mut a, mut b) = (middle - spacing, middle + spacing);
            for _ in 0..60 {
                let [c, d] = [b - GOLDEN * (b - a), a + GOLDEN * (b - a)];
                if self.height(c) <= self.height(d) {
                    b = d
                } else {
                    a = c
                }
            }
            [middle, 0.5 * (a + b)]
        });
        refined.collect()
    }
}

/// Whether a place is in a face, as far as is known.
fn is_in(brep: &PreparedBrep, face: usize, uv: Point2<f64>) -> bool {
    let told = side(brep, face, uv).and_then(|s| s.side);
    matches!(told, Some(Side::Inside | Side::Boundary))
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler::numeric::Dyadic;
    use feeler::query::{HalfSpace, Options, Sphere, Workspace, contact};
    use feeler_corpus::{Hits, MODELS, TruthEnclosure, judge};
    use nalgebra::{Unit, UnitQuaternion, Vector3};
    use std::path::Path;

    /// The same numbers each time (SplitMix64: G. L. Steele and others, OOPSLA 2014).
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> u64 {
            self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            z ^ (z >> 31)
        }

        fn below(&mut self, n: usize) -> usize {
            (self.next() % n as u64) as usize
        }

        fn unit(&mut self) -> f64 {
            (self.next() >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn direction(&mut self) -> Vector3<f64> {
            let [z, a] = [2.0 * self.unit() - 1.0, TAU * self.unit()];
            let r = (1.0 - z * z).sqrt();
            Vector3::new(r * a.cos(), r * a.sin(), z)
        }

        /// Nothing, or a tenth to the power of 1 to 16.
        fn little(&mut self) -> f64 {
            match self.below(4) {
                0 => 0.0,
                _ => 10.0_f64.powi(-1 - self.below(16) as i32),
            }
        }
    }

    fn load(name: &str) -> Loaded {
        let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora");
        let path = corpus.join(MODELS).join(name);
        crate::cases::loaded(feeler_corpus::Model::load(&path, None).expect("a model"))
    }

    /// The point, a normal and one of the centres of curvature at a place of a surface, roughly.
    fn osculating(
        surface: &Surface,
        uv: Point2<f64>,
        which: usize,
    ) -> (Point3<f64>, Vector3<f64>, Option<f64>) {
        let at = surface.first_derivatives_with_bound(uv.x, uv.y);
        let normal = at.du.cross(&at.dv).try_normalize(0.0);
        let normal = normal.unwrap_or_else(Vector3::z);
        let domain = surface.domain();
        // How the normal turns along a parameter.
        /// The part of a domain over which its turning is seen: a centre need not be met by more than a few digits.
        const STEP: f64 = 1e-4;
        let h = STEP * domain[which].length();
        let way = |x: f64| match which {
            0 => Point2::new(x, uv.y),
            _ => Point2::new(uv.x, x),
        };
        let x = [uv.x, uv.y][which];
        let x = x.clamp(domain[which].start + h, domain[which].end - h);
        let [a, b] = [x - h, x + h].map(|x| {
            let uv = way(x);
            let at = surface.first_derivatives_with_bound(uv.x, uv.y);
            (at.point, at.du.cross(&at.dv).try_normalize(0.0))
        });
        let radius = a.1.zip(b.1).map(|(m, n)| {
            let along = b.0 - a.0;
            -along.norm_squared() / (n - m).dot(&along)
        });
        (at.point, normal, radius.filter(|r| r.is_finite()))
    }

    /// Where many points may be nearest, or lowest, and a little beside it.
    fn probe(loaded: &Loaded, random: &mut Random) -> Option<Probe> {
        let brep = loaded.prepared[0].brep();
        let (parts, size) = (brep.parts(), loaded.size);
        let face = random.below(parts.faces.len());
        let surface = brep.surface(face);
        let domain = surface.domain();
        let own: Vec<&TrimCurve> = { parts.trims.iter() }
            .filter(|t| parts.loops[t.trim_loop].face == face)
            .collect();
        let uv = match random.below(3) {
            // On a trim, or at its end.
            0 if !own.is_empty() => {
                let trim = own[random.below(own.len())];
                let s = [0.0, 1.0, 0.5, random.unit()][random.below(4)];
                parts.curves2[trim.curve].point(trim.span.lerp(s))
            }
            _ => {
                let s = [0, 1].map(|_| [0.5, random.unit(), random.unit()][random.below(3)]);
                Point2::new(domain[0].lerp(s[0]), domain[1].lerp(s[1]))
            }
        };
        let (point, normal, radius) = osculating(surface, uv, random.below(2));
        let sign = [1.0, -1.0][random.below(2)];
        let little = random.little();
        if random.below(2) == 0 {
            let axis = Unit::new_normalize(random.direction());
            let turned = UnitQuaternion::from_axis_angle(&axis, little) * normal;
            let mut turned = (turned * sign).normalize();
            // What is round stays so.
            if little == 0.0 && random.below(2) == 0 {
                turned = turned.map(|x| (x * 4096.0).round() / 4096.0).normalize();
            }
            HalfSpace::new(turned, turned.dot(&point.coords))
                .ok()
                .map(Probe::HalfSpace)
        } else {
            let away = match (random.below(3), radius) {
                (0, Some(radius)) if radius.abs() < 16.0 * size => -radius,
                (1, _) => sign * size * 0.25 * random.unit(),
                _ => sign * size * random.little(),
            };
            let mut center = point + normal * away;
            if random.below(2) == 0 {
                center = center.map(|x| (x * 4096.0).round() / 4096.0);
            }
            let center = center + random.direction() * (little * size);
            Sphere::new(center, 0.125 * size * random.unit())
                .ok()
                .map(Probe::Sphere)
        }
    }

    /// An answer of the kernel with its own separation, which others judge, for the truth.
    fn answered(
        loaded: &Loaded,
        probe: &Probe,
        accuracy: Accuracy,
        workspace: &mut Workspace,
    ) -> Option<(Asked, Body, Truth)> {
        let options = Options {
            accuracy,
            prediction: f64::INFINITY,
            ..Options::default()
        };
        let found = contact(&loaded.prepared[0], probe, &options, workspace);
        let bounds = found.separation.bounds;
        let [lo, hi] = [bounds.lo, bounds.hi].map(Dyadic::from_f64);
        let foot = found.contacts.first().and_then(|c| {
            let bound = c.position_bound?;
            Some(c.on_brep.coords.map(|x| [x - bound, x + bound]).into())
        });
        let truth = Truth::Contact {
            separation: TruthEnclosure { lo: lo?, hi: hi? },
            foot,
            contacts: None,
        };
        let asked = Asked {
            accuracy,
            size: loaded.size,
            prediction: f64::INFINITY,
            contacts: false,
            hits: Hits::All,
            scale: 1.0,
            tolerance: 0.0,
            probe: Some(*probe),
        };
        Some((asked, Body::from(&found), truth))
    }

    /// What is amiss with what the kernel says of a probe.
    fn amiss(
        loaded: &Loaded,
        probe: &Probe,
        accuracy: Accuracy,
        workspace: &mut Workspace,
    ) -> Option<String> {
        let (asked, body, truth) = answered(loaded, probe, accuracy, workspace)?;
        let judged = judge(&asked, &body, &truth);
        let wrong = judged.fault.and(judged.reason);
        misjudged(loaded, &asked, &body, &truth).or(wrong)
    }

    fn half_space(normal: [f64; 3]) -> Probe {
        let normal = Vector3::from(normal).normalize();
        Probe::HalfSpace(HalfSpace::new(normal, 0.25).expect("a half-space"))
    }

    fn ball(center: [f64; 3]) -> Probe {
        Probe::Sphere(Sphere::new(center.into(), 0.125).expect("a ball"))
    }

    /// What a block, a cylinder and a cone (see the kernel's own test of these in `feeler-corpus`) are a continuum for, and what not: told as it is and the
    /// other way round.
    #[test]
    fn a_claim_is_wrong_one_way_alone() {
        let told = |shape: &str, probe: Probe, expected: bool| {
            for suffix in ["", "_nurbs"] {
                let loaded = load(&format!("analytic/{shape}{suffix}.json.gz"));
                for accuracy in [Accuracy::Full, Accuracy::Length(1e-9)] {
                    let mut workspace = Workspace::default();
                    let (asked, mut body, mut truth) =
                        answered(&loaded, &probe, accuracy, &mut workspace).expect("numbers");
                    let Body::Contact {
                        continuum,
                        contacts,
                        ..
                    } = &mut body
                    else {
                        panic!("of a probe")
                    };
                    assert_eq!(*continuum, Some(expected), "{shape}{suffix} {probe:?}");
                    let feet = contacts[0].on_brep.map(|x| [x, x]);
                    let is_face = matches!(contacts[0].feature, Some(Feature::Face(_)));
                    if let Truth::Contact { foot, .. } = &mut truth {
                        *foot = Some(feet);
                    }
                    assert_eq!(misjudged(&loaded, &asked, &body, &truth), None);
                    if let Body::Contact { continuum, .. } = &mut body {
                        *continuum = Some(!expected);
                    }
                    let why = misjudged(&loaded, &asked, &body, &truth);
                    // Nothing is held against a claim next to edges.
                    let is_told = expected || is_face;
                    assert_eq!(why.is_some(), is_told, "{shape}{suffix} {probe:?} {why:?}");
                }
            }
        };
        told("block", half_space([0.0, 1.0, 0.0]), true);
        told("block", half_space([0.75, 0.0, 1.0]), true);
        told("block", half_space([0.75, 0.5, 1.0]), false);
        told("block", ball([0.5, 0.25, 6.0]), false);
        told("block", ball([2.5, 2.25, 6.0]), false);
        told("cylinder", half_space([0.6, 0.8, 0.0]), true);
        told("cylinder", half_space([0.0, 0.0, 1.0]), true);
        told("cylinder", ball([0.25, 0.5, 1.5]), true);
        told("cylinder", ball([1.0, 1.25, 1.5]), false);
        told("cylinder", ball([0.25, 2.5, 1.5]), false);
        told("cone", half_space([-2.4, -3.2, -3.0]), true);
        told("cone", half_space([0.0, 0.0, -1.0]), false);
        told("sphere", half_space([0.6, 0.0, 0.8]), false);
        told("sphere", ball([0.5, -0.25, 1.0]), true);
        told("sphere", ball([0.75, 0.25, 1.5]), false);
    }

    /// Balls about centres of curvature, half-spaces tangent to faces and resting on edges, and a little beside these.
    #[test]
    fn what_the_kernel_tells_next_to_continua_holds() {
        let mut random = Random(7);
        let mut faults = Vec::new();
        for shape in [
            "block",
            "cone",
            "cylinder",
            "cylinder_slanted",
            "frustum",
            "sphere",
            "torus",
        ] {
            for suffix in ["", "_nurbs"] {
                let name = format!("analytic/{shape}{suffix}.json.gz");
                faults.extend(tried(&name, 60, &mut random));
            }
        }
        assert!(faults.is_empty(), "{}", faults.join("\n"));
    }

    /// What is amiss with answers to so many probes of a model.
    fn tried(name: &str, count: usize, random: &mut Random) -> Vec<String> {
        let loaded = load(name);
        let mut workspace = Workspace::default();
        let mut faults = Vec::new();
        let accuracies = [
            Accuracy::Full,
            Accuracy::Length(1e-9 * loaded.size),
            Accuracy::Length(1e-5 * loaded.size),
        ];
        for _ in 0..count {
            let accuracy = accuracies[random.below(3)];
            let Some(probe) = probe(&loaded, random) else {
                continue;
            };
            // Of a ball the kernel looks for no more than its search saw where less than full accuracy is asked.
            let accuracy = match probe {
                Probe::Sphere(_) => Accuracy::Full,
                Probe::HalfSpace(_) => accuracy,
            };
            if let Some(why) = amiss(&loaded, &probe, accuracy, &mut workspace) {
                faults.push(format!("{name} {accuracy:?} {probe:?}: {why}"));
            }
        }
        faults
    }
}
