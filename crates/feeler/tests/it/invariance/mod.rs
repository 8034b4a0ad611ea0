//! What must not change a separation. All numbers are dyadic with few digits, so that what is moved, swapped or cut is so exactly, and two
//! enclosures of one separation must meet.

mod lists;
mod near;
mod paces;
mod stretched;

use feeler::brep::{Brep, BrepBuilder};
use feeler::numeric::Enclosure;
use feeler::nurbs::{NurbsSurface, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    ContactAnswer, HalfSpace, LineKind, LineProbe, Options, Probe, Sphere, Workspace, contact, line,
};
use nalgebra::{Point3, Vector3, Vector4};
use proptest::prelude::*;

/// A Bezier patch over the unit square.
#[derive(Clone, Debug)]
struct Patch {
    degrees: [usize; 2],
    /// Homogeneous, v running fastest.
    net: Vec<Vector4<f64>>,
}

impl Patch {
    fn surface(&self) -> Surface {
        let knots = |p: usize| [vec![0.0; p + 1], vec![1.0; p + 1]].concat();
        let [p, q] = self.degrees;
        let counts = [p + 1, q + 1];
        let made = NurbsSurface::new([p, q], counts, self.net.clone(), [knots(p), knots(q)]);
        Surface::Nurbs(made.unwrap())
    }

    fn transposed(&self) -> Self {
        let [p, q] = self.degrees;
        let at = |i: usize, j: usize| self.net[i * (q + 1) + j];
        Self {
            degrees: [q, p],
            net: (0..=q)
                .flat_map(|j| (0..=p).map(move |i| (i, j)))
                .map(|(i, j)| at(i, j))
                .collect(),
        }
    }

    fn weighted(&self, by: f64) -> Self {
        Self {
            degrees: self.degrees,
            net: self.net.iter().map(|p| p * by).collect(),
        }
    }

    fn rows(&self) -> Vec<Vec<Vector4<f64>>> {
        self.net
            .chunks(self.degrees[1] + 1)
            .map(<[_]>::to_vec)
            .collect()
    }

    /// Cut at u = 1/2 by de Casteljau's averages, which are exact here.
    fn halves(&self) -> [Self; 2] {
        let mut rows = self.rows();
        let (mut left, mut right) = (vec![rows[0].clone()], vec![rows[rows.len() - 1].clone()]);
        while rows.len() > 1 {
            let mean = |w: &[Vec<Vector4<f64>>]| {
                let both = w[0].iter().zip(&w[1]);
                both.map(|(a, b)| (a + b) * 0.5).collect::<Vec<_>>()
            };
            rows = rows.windows(2).map(mean).collect();
            left.push(rows[0].clone());
            right.push(rows[rows.len() - 1].clone());
        }
        right.reverse();
        [left, right].map(|rows| Self {
            degrees: self.degrees,
            net: rows.concat(),
        })
    }

    /// The same surface with the knot 1/2 inserted as often as the degree along u.
    fn with_knot(&self) -> Surface {
        let [left, right] = self.halves();
        let [p, q] = self.degrees;
        let mut net = left.net;
        net.extend_from_slice(&right.net[q + 1..]);
        let knots = [
            [vec![0.0; p + 1], vec![0.5; p], vec![1.0; p + 1]].concat(),
            [vec![0.0; q + 1], vec![1.0; q + 1]].concat(),
        ];
        let made = NurbsSurface::new([p, q], [2 * p + 1, q + 1], net, knots);
        Surface::Nurbs(made.unwrap())
    }

    fn moved(&self, by: &Motion) -> Self {
        let moved = |h: &Vector4<f64>| {
            let turned = by.turned(h.xyz()) + by.shift * h.w;
            Vector4::new(turned.x, turned.y, turned.z, h.w)
        };
        Self {
            degrees: self.degrees,
            net: self.net.iter().map(moved).collect(),
        }
    }
}

/// Axes exchanged and turned round, then a shift: exact for numbers of few digits.
#[derive(Clone, Debug)]
struct Motion {
    axes: [usize; 3],
    signs: [f64; 3],
    shift: Vector3<f64>,
}

impl Motion {
    fn turned(&self, v: Vector3<f64>) -> Vector3<f64> {
        Vector3::from_fn(|i, _| self.signs[i] * v[self.axes[i]])
    }
}

fn motion() -> impl Strategy<Value = Motion> {
    let axes = prop_oneof![
        Just([0, 1, 2]),
        Just([1, 2, 0]),
        Just([2, 0, 1]),
        Just([1, 0, 2])
    ];
    let signs = prop::array::uniform3(prop::bool::ANY);
    let shift = prop::array::uniform3(-40i32..40);
    (axes, signs, shift).prop_map(|(axes, signs, shift)| Motion {
        axes,
        signs: signs.map(|s| if s { 1.0 } else { -1.0 }),
        shift: Vector3::from(shift.map(|x| f64::from(x) / 8.0)),
    })
}

/// A bumpy graph, or a heap of points; weights 1/2, 1 or 2, mostly 1.
fn patch() -> impl Strategy<Value = Patch> {
    (1usize..=3, 1usize..=3, prop::bool::ANY, prop::bool::ANY).prop_flat_map(
        |(p, q, graph, rational)| {
            let point = (prop::array::uniform3(-24i32..=24), 0usize..3);
            prop::collection::vec(point, (p + 1) * (q + 1)).prop_map(move |points| {
                let all = points.iter().enumerate();
                let net = all.map(|(k, (at, w))| {
                    let [x, y, z] = at.map(|x| f64::from(x) / 8.0);
                    let (i, j) = ((k / (q + 1)) as f64, (k % (q + 1)) as f64);
                    let [x, y, z] = if graph {
                        [2.0 * i, 2.0 * j, z]
                    } else {
                        [x, y, z]
                    };
                    let w = if rational { [0.5, 1.0, 2.0][*w] } else { 1.0 };
                    Vector4::new(x * w, y * w, z * w, w)
                });
                Patch {
                    degrees: [p, q],
                    net: net.collect(),
                }
            })
        },
    )
}

fn place() -> impl Strategy<Value = Point3<f64>> {
    prop::array::uniform3(-48i32..=48).prop_map(|p| Point3::from(p.map(|x| f64::from(x) / 8.0)))
}

fn prepared(surfaces: Vec<Surface>) -> PreparedBrep {
    let mut b = BrepBuilder::new();
    for s in surfaces {
        b.whole_surface(s);
    }
    PreparedBrep::new(b.build().unwrap())
}

fn of(patch: &Patch) -> PreparedBrep {
    PreparedBrep::new(Brep::from_surface(patch.surface()).unwrap())
}

fn ball(center: Point3<f64>) -> Probe {
    Probe::Sphere(Sphere::new(center, 0.0).unwrap())
}

fn asked(brep: &PreparedBrep, probe: &Probe) -> ContactAnswer {
    contact(brep, probe, &Options::default(), &mut Workspace::default())
}

fn bounds(brep: &PreparedBrep, probe: &Probe) -> Enclosure {
    asked(brep, probe).separation.bounds
}

fn meet(a: Enclosure, b: Enclosure) -> bool {
    a.lo <= b.hi && b.lo <= a.hi
}

/// Exact unit vectors, up to rounding that `HalfSpace` allows.
const NORMALS: [[f64; 3]; 4] = [
    [0.0, 0.0, 1.0],
    [0.6, -0.8, 0.0],
    [0.48, 0.6, 0.64],
    [-0.28, 0.0, 0.96],
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn a_motion_moves_no_separation(
        patch in patch(), by in motion(), center in place(), normal in prop::sample::select(&NORMALS[..]),
    ) {
        let (here, there) = (of(&patch), of(&patch.moved(&by)));
        let moved = Point3::from(by.turned(center.coords) + by.shift);
        let (a, b) = (bounds(&here, &ball(center)), bounds(&there, &ball(moved)));
        prop_assert!(meet(a, b), "{:?} {:?}", a, b);
        // Without the shift, which a rounded normal does not take exactly.
        let turned = Motion { shift: Vector3::zeros(), ..by };
        let there = of(&patch.moved(&turned));
        let n = Vector3::from(normal);
        let below = |n| Probe::HalfSpace(HalfSpace::new(n, 0.25).unwrap());
        let (a, b) = (bounds(&here, &below(n)), bounds(&there, &below(turned.turned(n))));
        prop_assert!(meet(a, b), "{:?} {:?}", a, b);
    }

    #[test]
    fn u_and_v_knots_and_cuts_change_nothing(
        patch in patch(), center in place(), normal in prop::sample::select(&NORMALS[..]),
    ) {
        let whole = of(&patch);
        let others = [
            ("swapped", of(&patch.transposed())),
            ("with a knot", prepared(vec![patch.with_knot()])),
            ("in two faces", prepared(patch.halves().map(|p| p.surface()).into())),
        ];
        let probes = [
            ball(center),
            Probe::HalfSpace(HalfSpace::new(Vector3::from(normal), 0.5).unwrap()),
        ];
        for probe in &probes {
            let a = bounds(&whole, probe);
            for (how, other) in &others {
                let b = bounds(other, probe);
                prop_assert!(meet(a, b), "{}: {:?} {:?}", how, a, b);
            }
        }
    }

    /// Homogeneous points times a power of two are the same points: the answer is the same to the last bit.
    #[test]
    fn weights_times_a_power_of_two_are_the_same(
        patch in patch(), center in place(), normal in prop::sample::select(&NORMALS[..]), power in -150i32..150,
    ) {
        let (own, other) = (of(&patch), of(&patch.weighted(2f64.powi(power))));
        let below = HalfSpace::new(Vector3::from(normal), 0.5).unwrap();
        for probe in [ball(center), Probe::HalfSpace(below)] {
            prop_assert_eq!(asked(&own, &probe), asked(&other, &probe));
        }
        let way = LineProbe::new(center, Vector3::from(normal), LineKind::Line).unwrap();
        let hits = |brep| line(brep, &way, &Options::default(), &mut Workspace::default());
        prop_assert_eq!(hits(&own), hits(&other));
    }

    /// From the centre straight to the foot: the foot stays the nearest, and no step changes the distance by more than its length.
    #[test]
    fn depth_along_the_way_to_the_foot(patch in patch(), center in place(), part in 1u32..16) {
        let brep = of(&patch);
        let far = asked(&brep, &ball(center));
        let Some(c) = far.contacts.first() else { return Ok(()) };
        let Some(off) = c.position_bound else { return Ok(()) };
        let s = f64::from(part) / 16.0;
        let between = center + (c.on_brep - center) * s;
        let near = bounds(&brep, &ball(between));
        // Distances of rounded points: some units of the largest coordinate.
        let rounding = 64.0 * f64::EPSILON * (center.coords.norm() + c.on_brep.coords.norm() + 1.0);
        let step = (between - center).norm();
        prop_assert!(near.hi >= far.separation.bounds.lo - step - rounding);
        prop_assert!(near.lo <= far.separation.bounds.hi + step + rounding);
        let left = (c.on_brep - between).norm();
        prop_assert!(near.lo <= left + off + rounding, "{:?} {}", near, left);
        prop_assert!(near.hi >= left - off - rounding - (far.separation.bounds.hi - far.separation.bounds.lo), "{:?} {}", near, left);
    }

    /// A segment with its ends exchanged has the same hits, at 1 - t.
    #[test]
    fn a_segment_run_the_other_way(patch in patch(), a in place(), b in place()) {
        prop_assume!(a != b);
        let brep = of(&patch);
        let hits = |from: Point3<f64>, to: Point3<f64>| {
            let probe = LineProbe::new(from, to - from, LineKind::Segment).unwrap();
            line(&brep, &probe, &Options::default(), &mut Workspace::default())
        };
        let (there, back) = (hits(a, b), hits(b, a));
        if there.undecided.is_none() && back.undecided.is_none() {
            prop_assert_eq!(there.crossings, back.crossings);
            prop_assert_eq!(there.hits.len(), back.hits.len());
            for (h, g) in there.hits.iter().zip(back.hits.iter().rev()) {
                let (lo, hi) = (1.0 - g.t.bounds.hi, 1.0 - g.t.bounds.lo);
                prop_assert!(lo.next_down() <= h.t.bounds.hi && h.t.bounds.lo <= hi.next_up());
            }
        }
    }
}
