//! BREPs and random numbers for tests and benches of queries.
#![allow(dead_code, reason = "each test file uses its own part of this")]

use feeler::brep::{Brep, BrepBuilder};
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve, NurbsSurface, Revolution, Surface};
use nalgebra::{Point3, Vector3, Vector4};

/// Xorshift: the same numbers everywhere.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub(crate) fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * ((self.next() >> 11) as f64 / (1u64 << 53) as f64)
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() >> 11) as usize % n
    }

    pub(crate) fn direction(&mut self) -> Vector3<f64> {
        loop {
            let v = Vector3::from_fn(|_, _| self.between(-1.0, 1.0));
            let n = v.norm();
            if n > 0.1 && n < 1.0 {
                return v / n;
            }
        }
    }
}

/// The box [0, 1]^3: native planes.
pub(crate) fn cube() -> Brep {
    let mut b = BrepBuilder::new();
    let corner = |i: usize| [(i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64];
    let v: Vec<usize> = (0..8).map(|i| b.vertex(corner(i))).collect();
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

/// A bicubic surface of 8 x 8 control points over the unit square, wavy in height.
pub(crate) fn bicubic() -> Brep {
    let mut random = Random::new(0x9e37_79b9_7f4a_7c15);
    let knots: Vec<f64> = [vec![0.0; 4], vec![0.2, 0.4, 0.6, 0.8], vec![1.0; 4]].concat();
    // The Greville abscissas: u and v are x and y.
    let at = |k: usize| (knots[k + 1] + knots[k + 2] + knots[k + 3]) / 3.0;
    let mut net = Vec::new();
    for i in 0..8 {
        for j in 0..8 {
            net.push(Vector4::new(at(i), at(j), random.between(-0.25, 0.25), 1.0));
        }
    }
    let surface = NurbsSurface::new([3, 3], [8, 8], net, [knots.clone(), knots]).unwrap();
    Brep::from_surface(Surface::Nurbs(surface)).unwrap()
}

/// A sphere of radius 2.5 about the origin as a revolution; an open sheet.
pub(crate) fn sphere() -> Surface {
    let half = std::f64::consts::FRAC_PI_2;
    let interval = |a, b| Interval::new(a, b).unwrap();
    let profile = Arc {
        center: Point3::origin(),
        x: Vector3::x(),
        y: Vector3::z(),
        z: -Vector3::y(),
        radius: 2.5,
        angle: interval(-half, half),
        domain: interval(0.0, 1.0),
    };
    let turned = Revolution {
        origin: Point3::origin(),
        axis: Vector3::z(),
        angle: interval(0.0, 4.0 * half),
        angle_domain: interval(0.0, 1.0),
        profile: Curve::Arc(Arc::new(profile).unwrap()),
        transposed: false,
    };
    Surface::Revolution(Revolution::new(turned).unwrap())
}

/// The same in closed form.
pub(crate) fn native_sphere() -> Brep {
    Brep::from_surface(sphere()).unwrap()
}

/// The same as NURBS.
pub(crate) fn nurbs_sphere() -> Brep {
    Brep::from_surface(Surface::Nurbs(sphere().to_nurbs().unwrap().nurbs)).unwrap()
}
