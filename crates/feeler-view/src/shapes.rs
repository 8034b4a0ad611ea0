//! The shapes that probes and arrows are placed copies of.

use std::f32::consts::PI;

/// A shape of unit size.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    pub(crate) name: &'static str,
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Meridians of the ball, and sides of the arrow's head.
const AROUND: u32 = 64;
/// Parallels of the ball, from pole to pole.
const PARALLELS: u32 = 32;

pub(crate) fn all() -> [Shape; 3] {
    [ball(), square(), cone()]
}

/// The unit ball.
pub(crate) fn ball() -> Shape {
    let mut positions = Vec::new();
    for j in 0..=PARALLELS {
        let (ring, z) = (PI * j as f32 / PARALLELS as f32).sin_cos();
        for i in 0..=AROUND {
            let (y, x) = (2.0 * PI * i as f32 / AROUND as f32).sin_cos();
            positions.push([ring * x, ring * y, z]);
        }
    }
    let mut triangles = Vec::new();
    let row = AROUND + 1;
    for j in 0..PARALLELS {
        for i in 0..AROUND {
            let (a, b) = (j * row + i, (j + 1) * row + i);
            if j > 0 {
                triangles.push([a, b, a + 1]);
            }
            if j + 1 < PARALLELS {
                triangles.push([a + 1, b, b + 1]);
            }
        }
    }
    Shape {
        name: "ball",
        normals: positions.clone(),
        positions,
        triangles,
    }
}

/// The square from -1 to 1 in x and y.
pub(crate) fn square() -> Shape {
    Shape {
        name: "square",
        positions: vec![
            [-1.0, -1.0, 0.0],
            [1.0, -1.0, 0.0],
            [1.0, 1.0, 0.0],
            [-1.0, 1.0, 0.0],
        ],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// The cone over the unit circle with its tip at z = 1.
pub(crate) fn cone() -> Shape {
    let (mut positions, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    let slant = 0.5f32.sqrt();
    for i in 0..AROUND {
        let (y, x) = (2.0 * PI * i as f32 / AROUND as f32).sin_cos();
        let side = [slant * x, slant * y, slant];
        for (p, n) in [
            ([x, y, 0.0], side),
            ([0.0, 0.0, 1.0], side),
            ([x, y, 0.0], [0.0, 0.0, -1.0]),
        ] {
            positions.push(p);
            normals.push(n);
        }
    }
    positions.push([0.0; 3]);
    normals.push([0.0, 0.0, -1.0]);
    for i in 0..AROUND {
        let (a, b) = (3 * i, 3 * ((i + 1) % AROUND));
        triangles.push([a, b, a + 1]);
        triangles.push([b + 2, a + 2, 3 * AROUND]);
    }
    Shape {
        name: "cone",
        positions,
        normals,
        triangles,
    }
}
