//! Solids and sheets known by formula: signs of separations, normals of hits, widths of cracks.

use crate::scenes::wavy_prism;
use feeler::brep::{Brep, BrepBuilder, TrimSpec};
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve, Line, NurbsSurface, Plane, Revolution, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    LineKind, LineProbe, Options, Probe, Sphere, Workspace, contact, inside, line,
};
use feeler::trim::Side;
use nalgebra::{Point2, Point3, Vector3, Vector4};
use proptest::prelude::*;

/// The box [0, 1]^3, its planes turned over where `over` says so: such a face is marked as reversed, and the solid is the same.
fn cube(over: [bool; 6]) -> Brep {
    let mut b = BrepBuilder::new();
    let corner = |i: usize| [(i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64];
    let v: Vec<usize> = (0..8).map(|i| b.vertex(corner(i))).collect();
    let wide = Interval::new(-2.0, 2.0).unwrap();
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    for (corners, over) in faces.into_iter().zip(over) {
        let at = |k: usize| Vector3::from(corner(corners[k]));
        let (x, y) = (at(1) - at(0), at(3) - at(0));
        let (x, y) = if over { (y, x) } else { (x, y) };
        let plane = Plane {
            origin: Point3::from(at(0)),
            x,
            y,
            domain: [wide; 2],
            extents: [wide; 2],
        };
        b.face(plane, &[&corners.map(|i| v[i])]).unwrap();
    }
    let brep = b.build().unwrap();
    let reversed: Vec<bool> = brep.faces().iter().map(|f| f.reversed).collect();
    assert_eq!(reversed, over);
    brep
}

/// Three sheets that share an edge, whose images on them are one parabola at three heights; the number of the edge.
fn book(heights: [f64; 3]) -> (Brep, usize) {
    let unit = Interval::new(0.0, 1.0).unwrap();
    let mut b = BrepBuilder::new();
    let ends = [0.0, 1.0].map(|x| b.vertex([x, 0.0, 0.0]));
    let shared = b.straight_edge(ends).unwrap();
    for (out, height) in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0]]
        .into_iter()
        .zip(heights)
    {
        let net = [(0.0, 0.0), (0.5, 1.0), (1.0, 0.0)]
            .into_iter()
            .flat_map(|(x, bulge)| {
                [0.0, 1.0].map(|v| Vector4::new(x, v * out[0], height + bulge + v * out[1], 1.0))
            });
        let knots = [vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
        let sheet = NurbsSurface::new([2, 1], [3, 2], net.collect(), knots).unwrap();
        let far = [1.0, 0.0].map(|x| b.vertex([x, out[0], height + out[1]]));
        let corners = [ends[0], ends[1], far[0], far[1]];
        let uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Point2::from);
        let trims = (0..4).map(|i| {
            let vertices = [corners[i], corners[(i + 1) % 4]];
            let edge = if i == 0 {
                shared
            } else {
                b.straight_edge(vertices).unwrap()
            };
            let line = Line::new(uv[i], uv[(i + 1) % 4], unit).unwrap();
            TrimSpec {
                vertices,
                curve: Curve::Line(line),
                edge: Some(edge),
            }
        });
        let trims = vec![trims.collect()];
        b.face_with_trims(Surface::Nurbs(sheet), trims).unwrap();
    }
    (b.build().unwrap(), shared)
}

/// A roof of slope 1, its ridge from y = -1 to 1 at x = 0, z = 1: one face of two patches.
fn roof() -> PreparedBrep {
    let net = [(-1.0, 0.0), (0.0, 1.0), (1.0, 0.0)]
        .into_iter()
        .flat_map(|(x, z)| [-1.0, 1.0].map(|y| Vector4::new(x, y, z, 1.0)));
    let knots = [vec![0.0, 0.0, 1.0, 2.0, 2.0], vec![0.0, 0.0, 1.0, 1.0]];
    let roof = NurbsSurface::new([1, 1], [3, 2], net.collect(), knots).unwrap();
    PreparedBrep::new(Brep::from_surface(Surface::Nurbs(roof)).unwrap())
}

fn within(half: f64) -> impl Strategy<Value = Point3<f64>> {
    prop::array::uniform3(-half..=half).prop_map(Point3::from)
}

/// Asks about one point after the other: what is kept of the first must not mislead the next.
fn signs(brep: Brep, points: &[Point3<f64>], is_inside: impl Fn(&Point3<f64>) -> Option<bool>) {
    let brep = PreparedBrep::new(brep);
    let mut workspace = Workspace::default();
    for p in points {
        let Some(inside) = is_inside(p) else { continue };
        let probe = Probe::Sphere(Sphere::new(*p, 0.0).unwrap());
        let found = contact(&brep, &probe, &Options::default(), &mut workspace);
        let b = found.separation.bounds;
        assert!(if inside { b.hi < 0.0 } else { b.lo > 0.0 }, "{p}: {b:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// A prism between the radii 4 and 6 and the heights -1 and 1.
    #[test]
    fn the_sign_of_a_separation_is_the_side_of_the_centre(
        points in prop::collection::vec(within(6.0), 16), sides in 3usize..8,
    ) {
        let flat: Vec<_> = points.iter().map(|p| Point3::new(p.x, p.y, p.z / 5.0)).collect();
        // Control points are at radii from 4 to 6, those of a side within a sector: so is its curve no nearer than their hull.
        let inner = 4.0 * (std::f64::consts::PI / sides as f64).cos();
        signs(wavy_prism(sides), &flat, |p| {
            let r = p.coords.xy().norm();
            if r > 6.0 || p.z.abs() > 1.0 {
                Some(false)
            } else {
                (r < inner && p.z.abs() < 1.0).then_some(true)
            }
        });
    }

    /// Curves that are moved copies of one another are as far apart as they were moved: their ends are, and no point need be farther.
    #[test]
    fn a_crack_is_no_narrower_than_its_widest_pair(
        heights in prop::array::uniform3((0i32..64).prop_map(|h| f64::from(h) / 4096.0)),
    ) {
        let (brep, edge) = book(heights);
        let width = PreparedBrep::new(brep).crack_width(edge);
        let ends = heights.iter().fold([1.0f64, 0.0f64], |[a, b], h| [a.min(*h), b.max(*h)]);
        prop_assert!(width >= ends[1] - ends[0], "{width}");
        prop_assert!(width.is_finite());
    }

    /// A line that runs across the roof `2^-e` below its ridge hits both sides, `2^-e` before and behind.
    #[test]
    fn both_sides_of_a_ridge_are_hit(e in 12i32..24, y in -0.75f64..0.75) {
        let below = 2f64.powi(-e);
        let from = Point3::new(-4.0, y, 1.0 - below);
        let probe = LineProbe::new(from, Vector3::x(), LineKind::Line).unwrap();
        let found = line(&roof(), &probe, &Options::default(), &mut Workspace::default());
        prop_assert!(found.undecided.is_none(), "{:?}", found);
        prop_assert_eq!(found.hits.len(), 2);
        for (h, t) in found.hits.iter().zip([4.0 - below, 4.0 + below]) {
            prop_assert!(h.t.bounds.lo <= t && t <= h.t.bounds.hi, "{:?}", h.t);
        }
    }

    /// A line down through the ridge, where two patches of one face meet, hits that face once.
    #[test]
    fn a_joint_of_patches_is_hit_once(y in -48i32..48, along in prop::array::uniform2(-24i32..24)) {
        let direction = Vector3::new(f64::from(along[0]) / 64.0, f64::from(along[1]) / 64.0, -1.0);
        let on_ridge = Point3::new(0.0, f64::from(y) / 64.0, 1.0);
        let probe = LineProbe::new(on_ridge - direction, direction, LineKind::Line).unwrap();
        let found = line(&roof(), &probe, &Options::default(), &mut Workspace::default());
        prop_assert!(found.undecided.is_none(), "{:?}", found);
        prop_assert_eq!((found.hits.len(), found.crossings), (1, Some(1)));
        let t = found.hits[0].t.bounds;
        prop_assert!(t.lo <= 1.0 && 1.0 <= t.hi, "{:?}", t);
    }

    /// A line through a box goes in against one normal and out along another; each is that of the side of the box where the hit lies.
    #[test]
    fn normals_of_hits_point_out(
        over in prop::array::uniform6(any::<bool>()),
        through in prop::array::uniform3(0.1f64..0.9),
        direction in within(1.0),
    ) {
        let direction = direction.coords;
        prop_assume!(direction.norm() > 0.1);
        let brep = PreparedBrep::new(cube(over));
        let probe = LineProbe::new(Point3::from(through), direction, LineKind::Line).unwrap();
        let found = line(&brep, &probe, &Options::default(), &mut Workspace::default());
        prop_assume!(found.undecided.is_none() && found.hits.len() == 2);
        let along: Vec<f64> = found.hits.iter().map(|h| h.normal.dot(&direction)).collect();
        prop_assert!(along[0] < 0.0 && along[1] > 0.0, "{:?}", along);
        for h in &found.hits {
            let from_middle = h.point - Point3::new(0.5, 0.5, 0.5);
            prop_assert!((h.normal.dot(&from_middle) - 0.5).abs() < 1e-12, "{:?}", h);
        }
    }
}

/// A native cylinder with both caps: its axis through the origin along `a`, from `-a` to `a`, the seam one radian before `d`, a vector across the axis
/// to its side.
fn cylinder(a: Vector3<f64>, d: Vector3<f64>) -> Brep {
    let turn = Interval::new(1.0, 1.0 + std::f64::consts::TAU).unwrap();
    let unit = Interval::new(0.0, 1.0).unwrap();
    let radius = d.norm();
    let (z, x) = (a.normalize(), d.normalize());
    let y = z.cross(&x);
    let mut b = BrepBuilder::new();
    let start = x * turn.start.cos() + y * turn.start.sin();
    let ends = [-1.0, 1.0].map(|s| Point3::from(a * s));
    let corners = ends.map(|e| b.vertex(e + start * radius));
    let rims = [0, 1].map(|k| {
        let arc = Arc {
            center: ends[k],
            x,
            y,
            z,
            radius,
            angle: turn,
            domain: turn,
        };
        b.edge([corners[k]; 2], Curve::Arc(arc)).unwrap()
    });
    let seam = b.straight_edge(corners).unwrap();
    let side = Revolution {
        origin: Point3::origin(),
        axis: a,
        angle: turn,
        angle_domain: turn,
        profile: Curve::Line(Line {
            from: ends[0] + d,
            to: ends[1] + d,
            domain: unit,
        }),
        transposed: false,
    };
    let straight = |from: [f64; 2], to: [f64; 2]| {
        Curve::Line(Line {
            from: Point2::from(from),
            to: Point2::from(to),
            domain: unit,
        })
    };
    let trim = |vertices: [usize; 2], curve, edge| TrimSpec {
        vertices,
        curve,
        edge: Some(edge),
    };
    let [low, high] = corners;
    let (from, to) = (turn.start, turn.end);
    let around = vec![
        trim([low, low], straight([from, 0.0], [to, 0.0]), rims[0]),
        trim([low, high], straight([to, 0.0], [to, 1.0]), seam),
        trim([high, high], straight([to, 1.0], [from, 1.0]), rims[1]),
        trim([high, low], straight([from, 1.0], [from, 0.0]), seam),
    ];
    b.face_with_trims(Surface::Revolution(side), vec![around])
        .unwrap();
    for (k, sign) in [(0, -1.0), (1, 1.0)] {
        let wide = Interval::new(-2.0 * radius, 2.0 * radius).unwrap();
        let plane = Plane {
            origin: ends[k],
            x,
            y: y * sign,
            domain: [wide; 2],
            extents: [wide; 2],
        };
        // Seen from outside the lower rim runs the other way.
        let rim = Arc {
            center: Point2::origin(),
            x: nalgebra::Vector2::x(),
            y: nalgebra::Vector2::y(),
            z: nalgebra::Vector2::zeros(),
            radius,
            angle: Interval::new(sign * 1.0, sign * 1.0 + std::f64::consts::TAU).unwrap(),
            domain: unit,
        };
        let rim = trim([corners[k]; 2], Curve::Arc(rim), rims[k]);
        b.face_with_trims(Surface::Plane(plane), vec![vec![rim]])
            .unwrap();
    }
    b.build().unwrap()
}

/// A ray of the parity test may touch a surface, exactly: that is no crossing. From `D - R / 16`, with `R` the first of the kernel's directions, it
/// touches the cylinder at `D`: `D` is across the axis and, exactly, across `R`.
#[test]
fn a_ray_that_touches_a_cylinder_does_not_enter_it() {
    let d = Vector3::new(14.0, 222.0, -155.0) / 4096.0;
    let axis = Vector3::new(0.0, 155.0, 222.0) / 512.0;
    let ray = Vector3::new(0.352, 0.521, 0.778);
    let exact = |x: f64| feeler::numeric::Dyadic::from_f64(x).unwrap();
    let dot = |a: &Vector3<f64>, b: &Vector3<f64>| {
        let part = |k: usize| &exact(a[k]) * &exact(b[k]);
        (&(&part(0) + &part(1)) + &part(2)).signum()
    };
    assert_eq!([dot(&d, &ray), dot(&d, &axis)], [0, 0]);
    let p = d - ray / 16.0;
    for k in 0..3 {
        assert_eq!((&exact(p[k]) + &exact(ray[k] / 16.0)), exact(d[k]));
    }
    let brep = cylinder(axis, d);
    assert!(brep.is_closed());
    let brep = PreparedBrep::new(brep);
    let mut workspace = Workspace::default();
    let mut side = |p: Vector3<f64>| inside(&brep, Point3::from(p), &mut workspace).side;
    assert_eq!(side(p), Some(Side::Outside));
    assert_eq!(side(0.5 * d), Some(Side::Inside));
    // The ray touches, as a line: once, and it crosses nothing.
    let probe = LineProbe::new(Point3::from(p), ray, LineKind::Ray).unwrap();
    let found = line(&brep, &probe, &Options::default(), &mut workspace);
    assert_eq!((found.undecided, found.crossings), (None, Some(0)));
    assert!(
        found.hits.len() == 1 && found.hits[0].tangential,
        "{found:?}"
    );
}

/// The unit cube, its bottom lowered by 1/64: between it and the sides is a crack, where nobody can say what is material. A ball with its centre there is
/// as far out of the faces as in.
#[test]
fn in_a_crack_the_separation_holds_both_signs() {
    let mut parts = cube([false; 6]).parts().clone();
    let Surface::Plane(bottom) = &mut parts.surfaces[0] else {
        unreachable!()
    };
    bottom.origin.z -= 1.0 / 64.0;
    let brep = PreparedBrep::new(Brep::new(parts).unwrap());
    let mut workspace = Workspace::default();
    let center = Point3::new(1.0, 0.5, -1.0 / 128.0);
    assert_eq!(inside(&brep, center, &mut workspace).side, None);
    let ball = Probe::Sphere(Sphere::new(center, 0.25).unwrap());
    let found = contact(&brep, &ball, &Options::default(), &mut workspace);
    // Half way between the two: 1/128 from either.
    let b = found.separation.bounds;
    assert!(
        b.contains(1.0 / 128.0 - 0.25) && b.contains(-1.0 / 128.0 - 0.25),
        "{b:?}"
    );
    assert!(found.undecided.is_some());
    for c in &found.contacts {
        assert_eq!(c.normal_bound, None, "the normal may be the opposite one");
    }
    // Clear of the crack it is known: inside 17/64 above the bottom, and outside as far below it.
    for (z, expected) in [
        (0.25, -17.0 / 64.0 - 0.25),
        (-18.0 / 64.0, 17.0 / 64.0 - 0.25),
    ] {
        let ball = Probe::Sphere(Sphere::new(Point3::new(0.5, 0.5, z), 0.25).unwrap());
        let found = contact(&brep, &ball, &Options::default(), &mut workspace);
        let b = found.separation.bounds;
        assert!(b.contains(expected) && b.width() < 1e-15, "{z}: {b:?}");
    }
}
