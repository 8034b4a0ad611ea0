//! The same face with parameters of other ranges: by powers of two, so that it is the same exactly.

use feeler::brep::{Brep, BrepBuilder, TrimSpec};
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Line, NurbsSurface, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, Feature, LineKind, LineProbe, Options, Probe, Sphere, Workspace, contact, line,
};
use nalgebra::{Point3, Vector2, Vector3, Vector4};

/// Corners of the square, counter-clockwise.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// `z = x^2 + y^2` over `[-1, 1]^2`, with x times one number as u and y times another as v, or the other way round; edge k
/// runs from corner k to the next.
fn bowl(stretch: [f64; 2], swap: bool) -> PreparedBrep {
    let (linear, square) = ([-1.0, 0.0, 1.0], [1.0, -1.0, 1.0]);
    let net = (0..9).map(|k| {
        let (i, j) = if swap { (k % 3, k / 3) } else { (k / 3, k % 3) };
        Vector4::new(linear[i], linear[j], square[i] + square[j], 1.0)
    });
    let uv = |[x, y]: [f64; 2]| if swap { [y, x] } else { [x, y] };
    let knots = uv(stretch).map(|s| [[-s; 3], [s; 3]].concat());
    let surface = NurbsSurface::new([2, 2], [3, 3], net.collect(), knots).unwrap();
    let mut b = BrepBuilder::new();
    let ids = CORNERS.map(|[x, y]| b.vertex([x, y, 2.0]));
    let trim = |k: usize| {
        let vertices = [ids[k], ids[(k + 1) % 4]];
        let ends = [k, (k + 1) % 4].map(|k| {
            let [x, y] = CORNERS[k];
            uv([x * stretch[0], y * stretch[1]]).into()
        });
        let line = Line::new(ends[0], ends[1], Interval::new(0.0, 1.0).unwrap());
        TrimSpec {
            vertices,
            curve: Curve::Line(line.unwrap()),
            edge: Some(b.straight_edge(vertices).unwrap()),
        }
    };
    let trims = [0, 1, 2, 3].map(trim);
    b.face_with_trims(Surface::Nurbs(surface), vec![trims.to_vec()])
        .unwrap();
    PreparedBrep::new(b.build().unwrap())
}

/// A ball straight outward of an edge, in its normal plane: its foot is on that edge, a little away from a corner, whatever u and v are. Ranges of parameters that
/// differ as 1 and 1e12 or more have the corner's other edge no farther in uv than roundings of the longer one.
#[test]
fn a_foot_on_an_edge_is_on_that_edge_whatever_its_parameters() {
    for stretch in [
        [1.0, 1.0],
        [2f64.powi(20), 2f64.powi(-20)],
        [2f64.powi(-45), 2f64.powi(30)],
    ] {
        for swap in [false, true] {
            let brep = bowl(stretch, swap);
            let edges = (0..4).flat_map(|k| [(k, k), (k, (k + 1) % 4)]);
            for (edge, corner) in edges {
                let ends = [edge, (edge + 1) % 4].map(|k| Vector2::from(CORNERS[k]));
                let middle = (ends[0] + ends[1]) * 0.5;
                for off in [1e-2, 1.1e-5, 1.2e-8, 1.3e-10] {
                    let at = Vector2::from(CORNERS[corner]);
                    let at = at + (middle - at) * off;
                    let foot = Point3::new(at.x, at.y, at.norm_squared());
                    let center = foot + middle.push(0.0) * 0.125;
                    let probe = Probe::Sphere(Sphere::new(center, 0.1875).unwrap());
                    let found = contact(
                        &brep,
                        &probe,
                        &Options::default(),
                        &mut Workspace::default(),
                    );
                    let named: Vec<Feature> = found.contacts.iter().map(|c| c.feature).collect();
                    assert_eq!(
                        named,
                        [Feature::Edge(edge)],
                        "{stretch:?} {swap} {corner} {off}"
                    );
                }
            }
        }
    }
}

/// `z = y^2` with x and y from 0 to 1 and from -1 to 1; x runs with u from -1 to 0, nearly all of it next to 0, where parameters have more digits than their part of the
/// domain has: what is told of places has them too.
#[test]
fn parameters_next_to_zero_have_all_their_digits() {
    const WEIGHT: f64 = 1.0 / (1u64 << 36) as f64;
    /// Some roundings of coordinates up to 3; and of u, of which a part is that over x (1 - x), with x from 1/64.
    const ROUNDED: f64 = 64.0 * f64::EPSILON;
    const ROUNDED_U: f64 = 65.0 * ROUNDED;
    let linear = [[-1.0, 1.0], [0.0, -1.0], [1.0, 1.0]];
    let net = [0.0, 1.0].into_iter().flat_map(|x| {
        let w = if x == 0.0 { 1.0 } else { WEIGHT };
        linear.map(|[y, z]| Vector4::new(x, y, z, 1.0) * w)
    });
    let knots = [
        vec![-1.0, -1.0, 0.0, 0.0],
        vec![-1.0, -1.0, -1.0, 1.0, 1.0, 1.0],
    ];
    let surface = NurbsSurface::new([1, 2], [2, 3], net.collect(), knots).unwrap();
    let brep = PreparedBrep::new(Brep::from_surface(Surface::Nurbs(surface)).unwrap());
    let on_face = |uv: [f64; 2]| brep.brep().surface(0).point(uv[0], uv[1]);
    let mut w = Workspace::default();
    for k in 1..64 {
        let x = f64::from(k) / 64.0;
        let u = -WEIGHT * (1.0 - x) / (x + WEIGHT * (1.0 - x));
        let checked = |what: &str, uv: [f64; 2], point: Point3<f64>, y: f64| {
            // Of all places with y the one with x; u has its digits, which x keeps as they are.
            let [off_u, off_v] = [(uv[0] - u) / u, uv[1] - y];
            let off = (on_face(uv) - point).norm();
            assert!(
                off < ROUNDED && off_u.abs() < ROUNDED_U && off_v.abs() < ROUNDED,
                "{what} {x}: {uv:?} is off by {off:e}, u by {off_u:e} of itself"
            );
        };
        let ball = Probe::Sphere(Sphere::new(Point3::new(x, 0.0, 0.125), 0.25).unwrap());
        for accuracy in [Accuracy::Full, Accuracy::Length(1e-12)] {
            let options = Options {
                accuracy,
                ..Options::default()
            };
            let found = contact(&brep, &ball, &options, &mut w);
            let [c] = found.contacts.as_slice() else {
                panic!("{x}: {found:?}")
            };
            checked("ball", c.uv.into(), c.on_brep, 0.0);
        }
        let y = 0.3125;
        let down = LineProbe::new(Point3::new(x, y, 3.0), -Vector3::z(), LineKind::Ray).unwrap();
        let found = line(&brep, &down, &Options::default(), &mut w);
        let [h] = found.hits.as_slice() else {
            panic!("{x}: {found:?}")
        };
        checked("line", h.uv.into(), h.point, y);
    }
}
