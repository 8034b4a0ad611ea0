//! Feet next to a trim, within and beyond, against exact distances: cold, and by what the ball before it taught.

use feeler::brep::{BrepBuilder, TrimSpec};
use feeler::numeric::{Dyadic, Interval};
use feeler::nurbs::{Curve, Line, NurbsSurface, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, ContactAnswer, Options, Probe, Sphere, Witness, Workspace, contact, contact_from,
};
use nalgebra::{Point3, Vector4};

/// Where the trim is.
const BORDER: f64 = 0.25;

/// `z = x^2 + y^2` over `[-1, 1]^2`, a face for each polygon in uv; as it is, or with x and y swapped.
fn bowl(polygons: &[Vec<[f64; 2]>], swap: bool) -> PreparedBrep {
    let (linear, square) = ([-1.0, 0.0, 1.0], [1.0, -1.0, 1.0]);
    let net = (0..9).map(|k| {
        let (i, j) = (k / 3, k % 3);
        Vector4::new(linear[i], linear[j], square[i] + square[j], 1.0)
    });
    let knots = || vec![-1.0, -1.0, -1.0, 1.0, 1.0, 1.0];
    let surface = NurbsSurface::new([2, 2], [3, 3], net.collect(), [knots(), knots()]).unwrap();
    let mut b = BrepBuilder::new();
    for polygon in polygons {
        let mut corners = polygon.clone();
        if swap {
            corners.iter_mut().for_each(|c| c.reverse());
            corners.reverse();
        }
        let n = corners.len();
        let places = corners.iter().map(|[x, y]| [*x, *y, x * x + y * y]);
        let ids: Vec<usize> = places.map(|p| b.vertex(p)).collect();
        // The edges' own curves are for display; each is used once, so that nothing is material.
        let pairs = (0..n).map(|k| [ids[k], ids[(k + 1) % n]]);
        let edges: Vec<usize> = pairs.map(|p| b.straight_edge(p).unwrap()).collect();
        let trims = (0..n).map(|k| {
            let ends = [corners[k], corners[(k + 1) % n]].map(Into::into);
            let line = Line::new(ends[0], ends[1], Interval::new(0.0, 1.0).unwrap());
            TrimSpec {
                vertices: [ids[k], ids[(k + 1) % n]],
                curve: Curve::Line(line.unwrap()),
                edge: Some(edges[k]),
            }
        });
        let trims = trims.collect();
        b.face_with_trims(Surface::Nurbs(surface.clone()), vec![trims])
            .unwrap();
    }
    PreparedBrep::new(b.build().unwrap())
}

/// `lo <= sqrt(square) <= hi`, exactly.
fn check(answer: &ContactAnswer, square: &Dyadic, accuracy: f64, what: &str) {
    let bounds = answer.separation.bounds;
    let squared = |x: f64| {
        let x = Dyadic::from_f64(x).unwrap();
        &x * &x
    };
    let holds = (bounds.lo < 0.0 || &squared(bounds.lo) <= square) && square <= &squared(bounds.hi);
    assert!(
        holds && answer.undecided.is_none() && bounds.hi >= 0.0,
        "{what}: {bounds:?} of {}",
        square.approximate().sqrt()
    );
    assert!(
        bounds.width() <= accuracy.max(2f64.powi(-52)),
        "{what}: {bounds:?}"
    );
}

/// The ball's centre is 1/8 of the slope's normal (-2 x, 0, 1) above the bowl at (x, 0): nearer than its centres of curvature. Up to the trim it is
/// sqrt(1 + 4 x^2) / 8 off; beyond, the nearest point is that of the trim on y = 0, where (x - 1/4)^2 + (z - (1/16 + y^2))^2 + y^2 is least.
#[test]
fn feet_within_and_beyond_a_trim() {
    let exact = |x: f64| Dyadic::from_f64(x).unwrap();
    let square = |x: &Dyadic| x * x;
    // Feet pass from one part of the last to the other.
    let cut = BORDER - 0.0625;
    let shapes = [
        // A rectangle, a convex polygon, one that is not, and the first cut in two.
        vec![vec![
            [-1.0, -1.0],
            [BORDER, -1.0],
            [BORDER, 1.0],
            [-1.0, 1.0],
        ]],
        vec![vec![
            [-1.0, -1.0],
            [BORDER, -1.0],
            [BORDER, 1.0],
            [-0.5, 1.0],
            [-1.0, 0.5],
        ]],
        vec![vec![
            [-1.0, -1.0],
            [BORDER, -1.0],
            [BORDER, 1.0],
            [-0.75, 0.0],
        ]],
        vec![
            vec![[-1.0, -1.0], [cut, -1.0], [cut, 1.0], [-1.0, 1.0]],
            vec![[cut, -1.0], [BORDER, -1.0], [BORDER, 1.0], [cut, 1.0]],
        ],
    ];
    for (shape, swap) in shapes.iter().flat_map(|s| [(s, false), (s, true)]) {
        let brep = bowl(shape, swap);
        let mut workspace = Workspace::default();
        for accuracy in [2f64.powi(-8), 2f64.powi(-14), 2f64.powi(-24), 0.0] {
            let options = Options {
                accuracy: if accuracy > 0.0 {
                    Accuracy::Length(accuracy)
                } else {
                    Accuracy::Full
                },
                prediction: f64::INFINITY,
                ..Options::default()
            };
            let mut witness = Witness::default();
            // There and back again, nearer each time.
            for digits in [3, 6, 9, 12, 16, 20, 24] {
                for k in [-3, -2, -1, 0, 1, 2, 3, 2, 1, 0, -1, -2, -3] {
                    let x = BORDER + f64::from(k) * 2f64.powi(-digits);
                    let (across, up) = (0.75 * x, x * x + 0.125);
                    let truth = if k <= 0 {
                        let slope = &exact(1.0) + &(&exact(4.0) * &square(&exact(x)));
                        &slope * &exact(1.0 / 64.0)
                    } else {
                        let aside = &exact(across) - &exact(BORDER);
                        let above = &exact(up) - &exact(BORDER * BORDER);
                        &square(&aside) + &square(&above)
                    };
                    let center = if swap {
                        Point3::new(0.0, across, up)
                    } else {
                        Point3::new(across, 0.0, up)
                    };
                    let probe = Probe::Sphere(Sphere::new(center, 0.0).unwrap());
                    let what = format!("{accuracy:e}, {k} * 2^-{digits}");
                    let cold = contact(&brep, &probe, &options, &mut workspace);
                    check(&cold, &truth, accuracy, &what);
                    let warm = contact_from(&brep, &probe, &mut witness, &options, &mut workspace);
                    check(&warm, &truth, accuracy, &format!("{what}, warm"));
                }
            }
        }
    }
}

/// The same bowl up to x = 0, where numbers as small as one likes are f64: the centre `(k h, 0, h)` is `h` off, but for a part of `h` itself, up to the trim, and
/// `h sqrt(1 + k^2)` from the origin beyond it. Where a parameter's leading digits do not tell on which side the foot is, an answer may be undecided, but not wrong.
#[test]
fn feet_next_to_a_trim_by_less_than_a_parameters_digits() {
    let shape = vec![[-1.0, -1.0], [0.0, -1.0], [0.0, 1.0], [-0.75, 0.0]];
    for swap in [false, true] {
        let brep = bowl(std::slice::from_ref(&shape), swap);
        let (options, mut workspace) = (Options::default(), Workspace::default());
        let options = Options {
            prediction: f64::INFINITY,
            ..options
        };
        let mut witness = Witness::default();
        for digits in [40, 50, 52, 54, 58, 64, 72] {
            let h = 2f64.powi(-digits);
            for k in [-3, -2, -1, 0, 1, 2, 3, 2, 1, 0, -1, -2, -3] {
                let across = f64::from(k) * h;
                let truth = h * (1.0 + f64::from(k.max(0)).powi(2)).sqrt();
                let center = if swap {
                    Point3::new(0.0, across, h)
                } else {
                    Point3::new(across, 0.0, h)
                };
                let probe = Probe::Sphere(Sphere::new(center, 0.0).unwrap());
                let cold = contact(&brep, &probe, &options, &mut workspace);
                let warm = contact_from(&brep, &probe, &mut witness, &options, &mut workspace);
                for answer in [cold, warm] {
                    let bounds = answer.separation.bounds;
                    // Besides its rounding the truth is off by a part of 4 k^2 h.
                    let part = truth * 2f64.powi(-34);
                    assert!(
                        bounds.lo <= truth + part && bounds.hi >= truth - part,
                        "{k} * 2^-{digits}: {bounds:?} of {truth:e}"
                    );
                    let narrow = (truth * 2f64.powi(-50)).max(2f64.powi(-94));
                    assert!(bounds.width() <= narrow || answer.undecided.is_some());
                }
            }
        }
    }
}
