//! What single steps of answers are by their definitions.

use super::advance::StraightWay;
use super::answer::{HalfSpace, Options, Probe};
use super::arrival::{Motion, arrival};
use super::contact::separation;
use super::objective::Objective;
use super::outcome::{Settled, Source, Spread};
use super::past::arrival_past;
use super::place::ball_of;
use super::{Accuracy, Workspace};
use crate::brep::{BrepBuilder, TrimSpec};
use crate::numeric::bernstein::Bidegree;
use crate::numeric::{Ball, Dd, Interval, Real};
use crate::nurbs::{Curve, Line, NurbsSurface, Surface};
use crate::prepare::closed::Extent;
use crate::prepare::{Net, PreparedBrep};
use nalgebra::{Point3, Vector3, Vector4};

/// `z = x^2 + y^2` over `[-1, 1]^2`, up to `x = border`.
pub(super) fn bowl(border: f64) -> PreparedBrep {
    let (linear, square) = ([-1.0, 0.0, 1.0], [1.0, -1.0, 1.0]);
    let net = (0..9).map(|k| {
        let (i, j) = (k / 3, k % 3);
        Vector4::new(linear[i], linear[j], square[i] + square[j], 1.0)
    });
    let knots = || vec![-1.0, -1.0, -1.0, 1.0, 1.0, 1.0];
    let surface = NurbsSurface::new([2, 2], [3, 3], net.collect(), [knots(), knots()]).unwrap();
    let corners = [[-1.0, -1.0], [border, -1.0], [border, 1.0], [-0.75, 0.0]];
    let mut b = BrepBuilder::new();
    let ids = corners.map(|[x, y]| b.vertex([x, y, x * x + y * y]));
    let trims = [0, 1, 2, 3].map(|k| {
        let vertices = [ids[k], ids[(k + 1) % 4]];
        let ends = [corners[k], corners[(k + 1) % 4]].map(Into::into);
        let unit = Interval::new(0.0, 1.0).unwrap();
        TrimSpec {
            vertices,
            curve: Curve::Line(Line::new(ends[0], ends[1], unit).unwrap()),
            edge: Some(b.straight_edge(vertices).unwrap()),
        }
    });
    b.face_with_trims(Surface::Nurbs(surface), vec![trims.to_vec()])
        .unwrap();
    PreparedBrep::new(b.build().unwrap())
}

/// The square in the plane x = 4 with y and z from -1 to 1.
fn wall() -> PreparedBrep {
    let mut b = BrepBuilder::new();
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let corners = corners.map(|[y, z]| b.vertex([4.0, y, z]));
    b.planar_face(&corners).unwrap();
    PreparedBrep::new(b.build().unwrap())
}

/// Of a box of the bowl's one patch, whose parameters are x and y moved to [0, 1].
#[test]
fn what_is_known_of_a_box_only_is_anywhere_on_it() {
    let brep = bowl(0.25);
    let source = Source::Patch { face: 0, index: 0 };
    let on_bowl = |s: f64| {
        let x = 2.0 * s - 1.0;
        Point3::new(x, 0.0, x * x)
    };
    for (at, range) in [(0.5, [0.5, 1.0]), (0.5, [0.0, 0.5]), (0.25, [0.25, 0.75])] {
        let all_of_it = Settled {
            face: 0,
            source: Some(source),
            lo: Dd::ZERO,
            at: [at, 0.5],
            spread: Some(Spread::Within([range, [0.5, 0.5]])),
            extent: Extent::Root(0.0),
            local_minimum: true,
            on_border: false,
            flat: false,
        };
        let (center, radius) = ball_of(&brep, &all_of_it, Dd::ZERO, None).unwrap();
        let center = Point3::from(center.map(|x| x.mid));
        assert!(
            (center - on_bowl(at)).norm() <= 4.0 * f64::EPSILON,
            "{center}"
        );
        for end in range {
            let far = (on_bowl(end) - on_bowl(at)).norm();
            assert!(far <= radius && radius < 8.0, "{radius}: {far}");
        }
    }
}

/// The distance is in [3, 5], the radius 1: outside it is d - r, in material -d - r, and where that is not known anything between.
#[test]
fn the_sign_of_a_separation() {
    let squares = [9.0, 25.0].map(Dd::from);
    let about = Objective::SquaredDistance(Point3::origin());
    // In material the farther a boundary is, the lower the separation.
    for (material, expected) in [
        (Some(false), [2.0, 4.0]),
        (Some(true), [-6.0, -4.0]),
        (None, [-6.0, 4.0]),
    ] {
        let bounds = separation(squares, &about, 1.0, material).bounds;
        let [lo, hi] = expected;
        assert!(bounds.lo <= lo && lo <= bounds.lo.next_up(), "{bounds:?}");
        assert!(bounds.hi >= hi && hi >= bounds.hi.next_down(), "{bounds:?}");
    }
}

/// A plane that moves arrives where what is left between the two is the prediction, not nothing.
#[test]
fn a_plane_arrives_at_its_prediction() {
    let brep = wall();
    let plane = Probe::HalfSpace(HalfSpace::new(Vector3::x(), 0.0).unwrap());
    let motion = Motion::new(Vector3::new(2.0, 0.0, 0.0), f64::INFINITY).unwrap();
    for prediction in [0.0, 0.5, -0.25] {
        let options = Options {
            prediction,
            ..Options::default()
        };
        let found = arrival(&brep, &plane, &motion, &options, &mut Workspace::default());
        let time = found.time.unwrap().bounds;
        assert!(
            time.contains((4.0 - prediction) / 2.0),
            "{prediction} {time:?}"
        );
        assert!(time.width() < 1e-12, "{prediction} {time:?}");
    }
}

/// A ball straight to a wall, from a place known to a bound: it may come sooner by that and later by that; a wall that it misses by less is not missed.
#[test]
fn a_ball_whose_place_is_known_to_a_bound() {
    let brep = wall();
    let (radius, allowance, bound) = (0.5, 1.0 / 32.0, 1.0 / 1024.0);
    let options = Options {
        accuracy: Accuracy::Length(bound / 64.0),
        ..Options::default()
    };
    let ask = |y: f64| {
        let way = StraightWay {
            center: Point3::new(0.0, y, 0.0),
            center_bound: bound,
            velocity: Vector3::x(),
            velocity_bound: 0.0,
        };
        let span = [0.0, 8.0];
        arrival_past(
            &brep,
            radius,
            &way,
            span,
            allowance,
            &options,
            &mut Workspace::default(),
        )
        .time
    };
    let head_on = ask(0.0).unwrap().bounds;
    assert!(
        head_on.lo <= 3.5 - bound && 3.5 + bound <= head_on.hi,
        "{head_on:?}"
    );
    // The rim at y = 1 counts where it is nearer to the way than r - a.
    let counts = 1.0 + radius - allowance;
    assert!(ask(counts + 0.5 * bound).is_some());
    assert!(ask(counts + 2.0 * bound).is_none());
}

/// Values in double-double and derivatives in f64 are of nets whose origins are not the same number, by some ulps: derivatives of `X` hang on it where
/// weights differ.
#[test]
fn a_fine_sample_is_of_two_nets() {
    let points = [
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.5],
        [1.0, 0.0, 0.25],
        [1.0, 1.0, 0.0],
    ];
    let weights = [1.0, 0.5, 2.0, 0.75];
    let degree = Bidegree { u: 1, v: 1 };
    let origin = [1.0, 2.0, 3.0];
    let off = origin.map(|x| x + 4.0 * f64::EPSILON);
    // Digits enough for products with weights of a bit or two.
    let scale = 1.0 / 1024.0;
    fn net<T: Real>(
        parts: impl Iterator<Item = ([f64; 3], f64)>,
        degree: Bidegree,
        (scale, shift): (f64, [f64; 3]),
        origin: [f64; 3],
    ) -> Net<T> {
        let points = parts.map(|(p, w)| {
            let x = [0, 1, 2].map(|c| Ball::exact((p[c] * scale + shift[c]) * w));
            [x[0], x[1], x[2], Ball::exact(w)]
        });
        Net::new(degree, points.collect(), origin)
    }
    let parts = || points.into_iter().zip(weights);
    let fine = net::<Dd>(parts(), degree, (scale, [0.0; 3]), origin);
    let shift = [0, 1, 2].map(|c| origin[c] - off[c]);
    let coarse = net::<f64>(parts(), degree, (scale, shift), off);
    let q = Point3::new(1.0 + 0.5 * scale, 2.0, 3.0 + 2.0 * scale);
    let height = Objective::Height(Vector3::new(0.6, 0.0, 0.8), 3.0);
    for objective in [Objective::SquaredDistance(q), height] {
        for at in [[0.25, 0.5], [0.0, 1.0], [0.75, 0.125]] {
            let found = objective.fine_sample(&coarse, &fine, at).unwrap();
            let truth = objective.sample(&fine, Ball::exact(at[0]), Ball::exact(at[1]));
            for k in 0..2 {
                for (a, b) in [
                    (found.n_slope[k], truth.n_slope[k]),
                    (found.c_slope[k], truth.c_slope[k]),
                ] {
                    assert!((a.mid - b.mid).magnitude() <= a.rad + b.rad, "{a:?} {b:?}");
                }
            }
        }
    }
}
