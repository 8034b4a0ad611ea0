//! The same trims run through at another pace: rational ones with weights that rise along them by powers of two, so that all points stay the same exactly.

use feeler::brep::{BrepBuilder, TrimSpec};
use feeler::numeric::Enclosure;
use feeler::nurbs::{Curve, Curve2, Curve3, NurbsCurve, NurbsSurface, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Contacts, HalfSpace, LineKind, LineProbe, Options, Probe, Sphere, Workspace, contact, line,
    side, split,
};
use nalgebra::{Point2, Point3, SVector, Vector3, Vector4};

/// Weights of an arc of a quarter turn between the middle of its polygon and its ends: the nearest f64 to sqrt(1/2).
const ARC: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Homogeneous points in uv over [0, 1], whose weights are multiplied by `2^(power i)`.
fn curve<const H: usize>(points: &[SVector<f64, H>], power: i32) -> NurbsCurve<H> {
    let degree = points.len() - 1;
    let scaled = (0i32..).zip(points).map(|(i, p)| p * 2f64.powi(power * i));
    let knots = [vec![0.0; degree + 1], vec![1.0; degree + 1]].concat();
    NurbsCurve::new(degree, scaled.collect(), knots).unwrap()
}

fn segment(from: [f64; 2], to: [f64; 2], power: i32) -> Curve2 {
    let points = [from, to].map(|p| Point2::from(p).to_homogeneous());
    Curve::Nurbs(curve(&points, power))
}

/// A quarter of a turn about the origin, from the x axis to the y axis.
fn arc(power: i32) -> Curve2 {
    let points = [[1.0, 0.0, 1.0], [ARC, ARC, ARC], [0.0, 1.0, 1.0]].map(Into::into);
    Curve::Nurbs(curve(&points, power))
}

/// The square [0, 1]^2 at a height, with x as u and y as v.
fn square(z: f64) -> Surface {
    let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];
    let net = corners.map(|[x, y]| Vector4::new(x, y, z, 1.0)).to_vec();
    let knots = [(); 2].map(|()| vec![0.0, 0.0, 1.0, 1.0]);
    Surface::Nurbs(NurbsSurface::new([1, 1], [2, 2], net, knots).unwrap())
}

/// The round face of a quarter of a cylinder of radius 1, from z = 0 to 2, and its top: all of its trims at a pace.
fn quarter(power: i32) -> PreparedBrep {
    let mut b = BrepBuilder::new();
    let axis = b.vertex([0.0, 0.0, 2.0]);
    let low = [b.vertex([1.0, 0.0, 0.0]), b.vertex([0.0, 1.0, 0.0])];
    let high = [b.vertex([1.0, 0.0, 2.0]), b.vertex([0.0, 1.0, 2.0])];
    let rim = |z: f64| {
        [[1.0, 0.0, 1.0], [ARC, ARC, ARC], [0.0, 1.0, 1.0]]
            .map(|[x, y, w]| Vector4::new(x, y, z * w, w))
    };
    let mut round = |ends: [usize; 2], z: f64| {
        let curve = Curve3::Nurbs(curve(&rim(z), 0));
        b.edge(ends, curve).unwrap()
    };
    let (below, above) = (round(low, 0.0), round(high, 2.0));
    let mut straight = |ends: [usize; 2]| b.straight_edge(ends).unwrap();
    let up = [straight([low[1], high[1]]), straight([high[0], low[0]])];
    let (left, right) = (straight([high[1], axis]), straight([axis, high[0]]));
    let trim = |vertices: [usize; 2], curve: Curve2, edge: usize| TrimSpec {
        vertices,
        curve,
        edge: Some(edge),
    };
    let net: Vec<_> = { rim(0.0).into_iter().zip(rim(2.0)) }
        .flat_map(|(a, b)| [a, b])
        .collect();
    let knots = [vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
    let wall = NurbsSurface::new([2, 1], [3, 2], net, knots).unwrap();
    let wall_trims = vec![
        trim(low, segment([0.0, 0.0], [1.0, 0.0], power), below),
        trim(
            [low[1], high[1]],
            segment([1.0, 0.0], [1.0, 1.0], power),
            up[0],
        ),
        trim(
            [high[1], high[0]],
            segment([1.0, 1.0], [0.0, 1.0], power),
            above,
        ),
        trim(
            [high[0], low[0]],
            segment([0.0, 1.0], [0.0, 0.0], power),
            up[1],
        ),
    ];
    b.face_with_trims(Surface::Nurbs(wall), vec![wall_trims])
        .unwrap();
    let top_trims = vec![
        trim(high, arc(power), above),
        trim(
            [high[1], axis],
            segment([0.0, 1.0], [0.0, 0.0], power),
            left,
        ),
        trim(
            [axis, high[0]],
            segment([0.0, 0.0], [1.0, 0.0], power),
            right,
        ),
    ];
    b.face_with_trims(square(2.0), vec![top_trims]).unwrap();
    PreparedBrep::new(b.build().unwrap())
}

/// Answers are the same to the last bit: lists of contacts, where ways along trims lead down, widths of cracks, sides and hits.
#[test]
fn trims_at_another_pace_are_the_same() {
    let usual = quarter(0);
    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
        (state >> 40) as f64 / (1u64 << 24) as f64
    };
    let all = Options {
        contacts: Contacts::All,
        prediction: 4.0,
        ..Options::default()
    };
    let mut w = Workspace::default();
    for power in [-31, -12, 1, 12, 40] {
        let paced = quarter(power);
        for edge in 0..6 {
            assert_eq!(
                usual.crack_width(edge),
                paced.crack_width(edge),
                "{power} {edge}"
            );
        }
        for k in 0..48 {
            let at = Point3::from([0, 1, 2].map(|_| 3.0 * random() - 1.0));
            let normal = (Vector3::from([0, 1, 2].map(|_| random() - 0.5))).normalize();
            let below = HalfSpace::new(normal, normal.dot(&at.coords)).unwrap();
            let ball = Sphere::new(at, 0.25).unwrap();
            for probe in [Probe::Sphere(ball), Probe::HalfSpace(below)] {
                let mut asked = |brep| contact(brep, &probe, &all, &mut w);
                assert_eq!(asked(&usual), asked(&paced), "{power} {k}: {probe:?}");
            }
            let way = LineProbe::new(at, normal, LineKind::Line).unwrap();
            let mut hits = |brep| line(brep, &way, &Options::default(), &mut w);
            assert_eq!(hits(&usual), hits(&paced), "{power} {k}: {way:?}");
            let uv = Point2::new(random(), random());
            assert_eq!(
                side(&usual, 1, uv),
                side(&paced, 1, uv),
                "{power} {k}: {uv:?}"
            );
        }
    }
}

/// What tells a parameter of a trim tells the one that was given: weights `1, c, c^2` have the top of an arch of three points at `1 / (1 + c)`.
#[test]
fn splits_are_at_the_parameters_that_were_given() {
    for power in [-12, 0, 3, 12] {
        let mut b = BrepBuilder::new();
        let ids = [[0.0, 0.0], [1.0, 0.0]].map(|[x, y]| b.vertex([x, y, 0.0]));
        let arch = [[1.0, 0.0], [0.5, 1.0], [0.0, 0.0]];
        let arch = arch.map(|p| Point2::from(p).to_homogeneous());
        let trims = [
            (ids, segment([0.0, 0.0], [1.0, 0.0], power)),
            ([ids[1], ids[0]], Curve::Nurbs(curve(&arch, power))),
        ];
        let trims = trims.map(|(vertices, curve)| TrimSpec {
            vertices,
            curve,
            edge: Some(b.straight_edge(vertices).unwrap()),
        });
        b.face_with_trims(square(0.0), vec![trims.to_vec()])
            .unwrap();
        let brep = PreparedBrep::new(b.build().unwrap());
        let [_, v] = split(&brep, 0, 0, 1).unwrap().unwrap();
        let [top] = v.places.as_slice() else {
            panic!("{power}: {v:?}")
        };
        let expected = 1.0 / (1.0 + 2f64.powi(power));
        let Enclosure { lo, hi } = top.bounds;
        assert!(
            lo.next_down() <= expected && expected <= hi.next_up(),
            "{power}: {top:?}"
        );
    }
}
