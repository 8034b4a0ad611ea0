//! The same of surfaces with knots a few steps of f64 apart, and of faces as thin as that.

use super::{NORMALS, ball, bounds, meet, place, prepared};
use feeler::brep::{
    Brep, BrepParts, Edge, Face, Iso, LoopKind, TrimCurve, TrimKind, TrimLoop, Vertex,
};
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Curve2, Line, NurbsSurface, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{HalfSpace, Options, Probe, Workspace, contact};
use nalgebra::{Point2, Point3, Vector3, Vector4};
use proptest::prelude::*;

/// A surface whose knots along u are in steps of 2^-52 above 1, and over [0, 1] along v.
#[derive(Clone, Debug)]
struct Stepped {
    degrees: [usize; 2],
    steps: Vec<i64>,
    /// Homogeneous, v running fastest.
    net: Vec<Vector4<f64>>,
}

/// One step.
const STEP: f64 = f64::EPSILON;

impl Stepped {
    fn made(&self, from: f64, step: f64, swapped: bool) -> Surface {
        let [p, q] = self.degrees;
        let u: Vec<f64> = self.steps.iter().map(|k| from + *k as f64 * step).collect();
        let v = [vec![0.0; q + 1], vec![1.0; q + 1]].concat();
        let rows = self.net.chunks(q + 1);
        let counts = [rows.len(), q + 1];
        let made = if swapped {
            let net = (0..=q).flat_map(|j| rows.clone().map(move |r| r[j]));
            NurbsSurface::new([q, p], [q + 1, counts[0]], net.collect(), [v, u])
        } else {
            NurbsSurface::new([p, q], counts, self.net.clone(), [u, v])
        };
        Surface::Nurbs(made.unwrap())
    }

    fn surface(&self) -> Surface {
        self.made(1.0, STEP, false)
    }
}

fn stepped() -> impl Strategy<Value = Stepped> {
    let gap = prop_oneof![3 => 1i64..=4, 1 => Just(1i64 << 40)];
    let inner = prop::collection::vec((gap, 1usize..=3), 1..3);
    (1usize..=3, 1usize..=2, inner, any::<bool>()).prop_flat_map(|(p, q, inner, rational)| {
        let mut steps = vec![0; p + 1];
        let mut at = 0;
        for (gap, times) in inner {
            at += gap;
            steps.extend(std::iter::repeat_n(at, times.min(p)));
        }
        steps.extend(std::iter::repeat_n(at + 2, p + 1));
        let count = (steps.len() - p - 1) * (q + 1);
        let point = (
            prop::array::uniform3(-24i32..=24),
            prop::sample::select(vec![0.5, 1.0, 2.0]),
        );
        prop::collection::vec(point, count).prop_map(move |points| {
            let one = |(k, (at, w)): (usize, &([i32; 3], f64))| {
                let w = if rational { *w } else { 1.0 };
                let [_, _, z] = at.map(|x| f64::from(x) / 8.0);
                // A graph, a little uneven.
                let x = 2.0 * (k / (q + 1)) as f64 + f64::from(at[0] / 8) / 8.0;
                let y = 2.0 * (k % (q + 1)) as f64 + f64::from(at[1] / 8) / 8.0;
                Vector4::new(x * w, y * w, z * w, w)
            };
            Stepped {
                degrees: [p, q],
                steps: steps.clone(),
                net: points.iter().enumerate().map(one).collect(),
            }
        })
    })
}

/// Faces of surfaces, each within a polygon in uv.
fn within(faces: &[(Surface, Vec<[f64; 2]>)]) -> PreparedBrep {
    let mut parts = BrepParts {
        vertices: vec![Vertex {
            point: Point3::origin(),
            edges: vec![],
            tolerance: None,
        }],
        ..BrepParts::default()
    };
    for (f, (surface, corners)) in faces.iter().enumerate() {
        let first = parts.trims.len();
        for i in 0..corners.len() {
            let [a, b] = [corners[i], corners[(i + 1) % corners.len()]].map(Point2::from);
            let unit = Interval::new(0.0, 1.0).unwrap();
            let line: Curve2 = Curve::Line(Line::new(a, b, unit).unwrap());
            let trim = parts.trims.len();
            parts.edges.push(Edge {
                curve: None,
                span: unit,
                reversed: false,
                vertices: [0; 2],
                trims: vec![trim],
                tolerance: None,
            });
            parts.trims.push(TrimCurve {
                curve: parts.curves2.len(),
                span: unit,
                reversed: false,
                edge: Some(trim),
                edge_reversed: false,
                vertices: [0, 0],
                kind: TrimKind::Boundary,
                iso: Iso::None,
                trim_loop: f,
            });
            parts.curves2.push(line);
        }
        parts.loops.push(TrimLoop {
            kind: LoopKind::Unknown,
            trims: (first..parts.trims.len()).collect(),
            face: f,
        });
        parts.surfaces.push(surface.clone());
        parts.faces.push(Face {
            surface: f,
            loops: Some(vec![f]),
            reversed: false,
        });
    }
    PreparedBrep::new(Brep::new(parts).unwrap())
}

/// The rectangle with these ends.
fn rectangle([a, b]: [f64; 2], [c, d]: [f64; 2]) -> Vec<[f64; 2]> {
    vec![[a, c], [b, c], [b, d], [a, d]]
}

/// A bilinear or biquadratic graph over [-4, 4]^2, with uv as x and y.
#[derive(Clone, Debug)]
struct Graph {
    degree: usize,
    heights: Vec<i32>,
}

impl Graph {
    fn surface(&self, swapped: bool) -> Surface {
        let p = self.degree;
        let along = |i: usize| 8.0 * (i as f64 / p as f64) - 4.0;
        let net = (0..(p + 1) * (p + 1)).map(|k| {
            let (i, j) = (k / (p + 1), k % (p + 1));
            let (i, j) = if swapped { (j, i) } else { (i, j) };
            let z = f64::from(self.heights[i * (p + 1) + j]) / 8.0;
            Vector4::new(along(i), along(j), z, 1.0)
        });
        let knots = [vec![-4.0; p + 1], vec![4.0; p + 1]].concat();
        let made = NurbsSurface::new([p, p], [p + 1; 2], net.collect(), [knots.clone(), knots]);
        Surface::Nurbs(made.unwrap())
    }
}

fn graph() -> impl Strategy<Value = Graph> {
    (1usize..=2).prop_flat_map(|degree| {
        let heights = prop::collection::vec(-24i32..=24, (degree + 1) * (degree + 1));
        heights.prop_map(move |heights| Graph { degree, heights })
    })
}

/// A triangle with one side of a few steps of f64 to 2^-30.
fn thin() -> impl Strategy<Value = [[f64; 2]; 3]> {
    let at = || prop::array::uniform2(-28i32..=28).prop_map(|p| p.map(|x| f64::from(x) / 8.0));
    let wide = prop_oneof![
        (1u32..=4).prop_map(|n| f64::from(n) * 4.0 * STEP),
        (30i32..48).prop_map(|e| (-f64::from(e)).exp2()),
    ];
    (at(), at(), wide).prop_map(|(a, b, wide)| {
        let [x, y] = [b[0] - a[0], b[1] - a[1]];
        // Across the longer extent.
        if x.abs() < y.abs() {
            [a, b, [b[0] + wide, b[1]]]
        } else {
            [a, b, [b[0], b[1] + wide]]
        }
    })
}

/// So many cases, or as many as `PROPTEST_CASES` says.
fn cases(few: u32) -> ProptestConfig {
    let told = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    match std::env::var_os("PROPTEST_CASES") {
        Some(_) => told,
        None => ProptestConfig { cases: few, ..told },
    }
}

fn probes(center: Point3<f64>, normal: [f64; 3]) -> [Probe; 2] {
    let below = HalfSpace::new(Vector3::from(normal), 0.5).unwrap();
    [ball(center), Probe::HalfSpace(below)]
}

proptest! {
    #![proptest_config(cases(64))]

    /// With u and v swapped, knots of whole numbers, and in two faces that meet at any parameter.
    #[test]
    fn of_near_knots(
        s in stepped(), center in place(), normal in prop::sample::select(&NORMALS[..]), part in 0.0..1.0f64,
    ) {
        let whole = prepared(vec![s.surface()]);
        let last = s.steps[s.steps.len() - 1];
        let [from, to] = [1.0, 1.0 + last as f64 * STEP];
        let at = 1.0 + (1 + ((last - 2) as f64 * part) as i64) as f64 * STEP;
        let cut = [[from, at], [at, to]].map(|u| (s.surface(), rectangle(u, [0.0, 1.0])));
        let others = [
            ("swapped", prepared(vec![s.made(1.0, STEP, true)])),
            ("of whole knots", prepared(vec![s.made(0.0, 1.0, false)])),
            ("in two faces", within(&cut)),
        ];
        for probe in &probes(center, normal) {
            let a = bounds(&whole, probe);
            prop_assert!(a.hi - a.lo < 1e-9, "{:?}", a);
            for (how, other) in &others {
                // Trims in a domain of a few f64 may be out of reach, and are not looked for long.
                let is_cut = *how == "in two faces";
                let options = Options {
                    node_budget: if is_cut { 256 } else { Options::default().node_budget },
                    ..Options::default()
                };
                let b = contact(other, probe, &options, &mut Workspace::default());
                let b = b.separation.bounds;
                prop_assert!(meet(a, b), "{}: {:?} {:?}", how, a, b);
                prop_assert!(is_cut || b.hi - b.lo < 1e-9, "{}: {:?}", how, b);
            }
        }
    }

    /// With u and v swapped, run the other way, and in two faces: cut from the tip to the middle of the short side, or as near to it as there are numbers.
    #[test]
    fn of_slivers(
        g in graph(), t in thin(), center in place(), normal in prop::sample::select(&NORMALS[..]),
    ) {
        let [a, b, c] = t;
        prop_assume!(a != b);
        let middle = [0, 1].map(|i| b[i] + 0.5 * (c[i] - b[i]));
        let swap = |q: [f64; 2]| [q[1], q[0]];
        let plain = |corners: &[[f64; 2]]| (g.surface(false), corners.to_vec());
        let whole = within(&[plain(&t)]);
        let others = [
            ("swapped", within(&[(g.surface(true), t.map(swap).to_vec())])),
            ("the other way", within(&[plain(&[c, b, a])])),
            ("in two faces", within(&[plain(&[a, b, middle]), plain(&[a, middle, c])])),
        ];
        for probe in &probes(center, normal) {
            let one = bounds(&whole, probe);
            prop_assert!(one.hi - one.lo < 1e-9, "{:?}", one);
            for (how, other) in &others {
                let b = bounds(other, probe);
                prop_assert!(meet(one, b) && b.hi - b.lo < 1e-9, "{}: {:?} {:?}", how, one, b);
            }
        }
    }
}
