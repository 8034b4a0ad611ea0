//! Shapes and poses.

use feeler::brep::{Brep, BrepBuilder};
use feeler::numeric::Interval;
use feeler::nurbs::{Arc as NurbsArc, Curve, Revolution, Surface};
use feeler::prepare::PreparedBrep;
use feeler_io::{ObjectKind, read_file};
use feeler_rapier::BrepShape;
use nalgebra::{Point3, Vector3};
use parry3d_f64::math::{Pose, Rotation, Vector};
use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::sync::Arc;

/// Numbers that are the same on every machine (Vigna's splitmix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn between(&mut self, a: f64, b: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        a + (b - a) * ((z >> 11) as f64 / (1u64 << 53) as f64)
    }

    pub(crate) fn vector(&mut self, size: f64) -> Vector {
        Vector::from_array([0; 3].map(|_| self.between(-size, size)))
    }

    pub(crate) fn rotation(&mut self) -> Rotation {
        let [x, y, z, w] = [0; 4].map(|_| self.between(-1.0, 1.0));
        Rotation::from_xyzw(x, y, z, w).normalize()
    }

    pub(crate) fn pose(&mut self, size: f64) -> Pose {
        Pose::from_parts(self.vector(size), self.rotation())
    }
}

pub(crate) fn shape(brep: Brep) -> BrepShape {
    BrepShape::new(Arc::new(PreparedBrep::new(brep))).unwrap()
}

/// A box from one corner to the other; faces as planes.
pub(crate) fn block(low: [f64; 3], high: [f64; 3]) -> Brep {
    let mut b = BrepBuilder::new();
    let pick = |i: usize, c: usize| {
        if i >> c & 1 == 0 { low[c] } else { high[c] }
    };
    let v: Vec<usize> = (0..8)
        .map(|i| b.vertex([pick(i, 0), pick(i, 1), pick(i, 2)]))
        .collect();
    for face in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ] {
        b.planar_face(&face.map(|i| v[i])).unwrap();
    }
    b.build().unwrap()
}

/// An L from the side: a floor at z = 0 from x = -8 to 4, a wall at x = 4 up to z = 3; as far to both sides along y as is said.
pub(crate) fn floor_and_wall(half: f64) -> BrepShape {
    let profile = [
        [-8.0, -1.0],
        [5.0, -1.0],
        [5.0, 3.0],
        [4.0, 3.0],
        [4.0, 0.0],
        [-8.0, 0.0],
    ];
    shape(prism(&profile, [-half, half]))
}

/// A polygon in x and z, its material to the left of its sides, drawn out along y; faces as planes.
pub(crate) fn prism(profile: &[[f64; 2]], [front, back]: [f64; 2]) -> Brep {
    let mut b = BrepBuilder::new();
    let n = profile.len();
    let mut row = |y: f64| -> Vec<usize> {
        let at = profile.iter().map(|[x, z]| b.vertex([*x, y, *z]));
        at.collect()
    };
    let (near, far) = (row(front), row(back));
    b.planar_face(&near).unwrap();
    let back: Vec<usize> = far.iter().rev().copied().collect();
    b.planar_face(&back).unwrap();
    for i in 0..n {
        let j = (i + 1) % n;
        b.planar_face(&[near[j], near[i], far[i], far[j]]).unwrap();
    }
    b.build().unwrap()
}

pub(crate) fn cube() -> Brep {
    block([0.0; 3], [1.0; 3])
}

/// The signed distance from the unit cube, negative inside.
pub(crate) fn to_cube(p: Vector) -> f64 {
    let off = (p - Vector::splat(0.5)).abs() - Vector::splat(0.5);
    let outside = off.max(Vector::ZERO).length();
    outside + off.max_element().min(0.0)
}

/// A sheet: the torus of radii `major` and `minor` about the z axis.
pub(crate) fn torus(major: f64, minor: f64) -> Brep {
    let interval = |a, b| Interval::new(a, b).unwrap();
    let profile = NurbsArc {
        center: Point3::new(major, 0.0, 0.0),
        x: Vector3::x(),
        y: Vector3::z(),
        z: -Vector3::y(),
        radius: minor,
        angle: interval(-PI, PI),
        domain: interval(0.0, 1.0),
    };
    let turned = Revolution {
        origin: Point3::origin(),
        axis: Vector3::z(),
        angle: interval(0.0, TAU),
        angle_domain: interval(0.0, 1.0),
        profile: Curve::Arc(NurbsArc::new(profile).unwrap()),
        transposed: false,
    };
    Brep::from_surface(Surface::Revolution(Revolution::new(turned).unwrap())).unwrap()
}

/// The BREP of a part of the corpora.
pub(crate) fn part(name: &str) -> Brep {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/thesis");
    let document = read_file(root.join(name)).unwrap();
    let mut objects = document.objects.into_iter();
    objects
        .find_map(|o| match o.kind {
            ObjectKind::Brep(brep) => Some(brep),
            _ => None,
        })
        .unwrap()
}
