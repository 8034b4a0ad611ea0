//! Lists of contacts about corners: narrow ones, ones whose vertex the file holds elsewhere, and trims that stand still there. A height over a flat face has its
//! minima where both sides of a corner rise, and nowhere else.

use crate::scenes::loop_face;
use feeler::nurbs::{Curve, Curve2, NurbsCurve, NurbsSurface, Surface};
use feeler::prepare::{PreparedBrep, Shortcuts};
use feeler::query::{Contacts, HalfSpace, Options, Probe, Workspace, contact};
use nalgebra::{Point2, Point3, Vector2, Vector3, Vector4};
use proptest::prelude::*;

/// The polygon's corners, how each side is drawn, and where the file says that the vertices are.
#[derive(Clone, Debug)]
struct Flat {
    corners: Vec<[f64; 2]>,
    sides: Vec<usize>,
    misplaced: bool,
    /// The plane's rise along x and along y.
    slope: [f64; 2],
    inner: bool,
    closed_forms: bool,
}

const SIDE: f64 = 16.0;

impl Flat {
    fn surface(&self) -> Surface {
        let at = |x: f64, y: f64| Vector4::new(x, y, self.slope[0] * x + self.slope[1] * y, 1.0);
        let own: &[f64] = if self.inner {
            &[-SIDE, 0.0, SIDE]
        } else {
            &[-SIDE, SIDE]
        };
        let net = own.iter().flat_map(|x| own.iter().map(move |y| at(*x, *y)));
        let knots = [&own[..1], own, &own[own.len() - 1..]].concat();
        let counts = [own.len(); 2];
        let made = NurbsSurface::new([1; 2], counts, net.collect(), [knots.clone(), knots]);
        Surface::Nurbs(made.unwrap())
    }

    /// A straight side: evenly; with the next control point next to the corner at its start or its end; and standing still at one of them.
    fn side(&self, i: usize) -> Curve2 {
        const NEAR: f64 = 5e-15;
        let [a, b] = [i, i + 1].map(|k| Vector2::from(self.corners[k % self.corners.len()]));
        let along = b - a;
        let points = match self.sides[i] {
            0 => vec![a, b],
            1 => vec![a, a + along * NEAR, b],
            2 => vec![a, b - along * NEAR, b],
            3 => vec![a, a, b],
            _ => vec![a, b, b],
        };
        let p = points.len() - 1;
        let points = points.into_iter().map(|p| Vector3::new(p.x, p.y, 1.0));
        let knots = [vec![0.0; p + 1], vec![1.0; p + 1]].concat();
        Curve::Nurbs(NurbsCurve::new(p, points.collect(), knots).unwrap())
    }

    fn brep(&self) -> PreparedBrep {
        let surface = self.surface();
        let curves = (0..self.corners.len()).map(|i| self.side(i)).collect();
        let own = |c: &[f64; 2]| -> Point3<f64> {
            if self.misplaced {
                Point3::new(1.0, 2.0, 100.0)
            } else {
                surface.point(c[0], c[1])
            }
        };
        let vertices = self.corners.iter().map(own).collect();
        let shortcuts = Shortcuts {
            closed_forms: self.closed_forms,
            ..Shortcuts::default()
        };
        PreparedBrep::with_shortcuts(loop_face(&surface, curves, vertices), shortcuts)
    }

    /// The corners that are minima, if it is clear for each side whether it rises.
    fn minima(&self, normal: Vector3<f64>) -> Option<Vec<Point2<f64>>> {
        let count = self.corners.len();
        let corner = |i: usize| Point2::from(self.corners[i % count]);
        let down = Vector2::new(
            normal.x + normal.z * self.slope[0],
            normal.y + normal.z * self.slope[1],
        );
        let rise = |i: usize| {
            let along = corner(i + 1) - corner(i);
            let r = down.dot(&along) / along.norm();
            (r.abs() > 1.0 / 64.0 && along.norm() > 1.0 / 16.0).then_some(r > 0.0)
        };
        let rises: Option<Vec<bool>> = (0..count).map(rise).collect();
        let rises = rises?;
        let least = |i: &usize| rises[*i] && !rises[(i + count - 1) % count];
        // Of those the corners that bend outward: on the way round the face is on the left.
        let outward = |i: &usize| {
            let [a, b, c] = [i + count - 1, *i, i + 1].map(corner);
            (b - a).perp(&(c - b)) > 0.0
        };
        Some(
            (0..count)
                .filter(|i| least(i) && outward(i))
                .map(corner)
                .collect(),
        )
    }
}

/// A star about the origin, some of whose rays are close together.
fn flat() -> impl Strategy<Value = Flat> {
    let step = prop_oneof![3 => 0.2f64..2.0, 2 => 0.001f64..0.05];
    let ray = (step, 1.0f64..12.0, 0usize..5);
    (
        prop::collection::vec(ray, 3..7),
        [-1.0f64..1.0, -1.0f64..1.0],
        0.0f64..6.3,
        any::<[bool; 3]>(),
    )
        .prop_map(|(rays, slope, turn, [misplaced, inner, closed_forms])| {
            let whole: f64 = rays.iter().map(|r| r.0).sum();
            let mut angle = turn;
            let mut corners = Vec::new();
            for (step, length, _) in &rays {
                corners.push([length * angle.cos(), length * angle.sin()]);
                angle += step / whole * std::f64::consts::TAU;
            }
            Flat {
                corners,
                sides: rays.iter().map(|r| r.2).collect(),
                misplaced,
                slope,
                inner,
                closed_forms,
            }
        })
        // About a gap of half a turn the loop goes round outside of the star.
        .prop_filter("a gap", |f| {
            let count = f.corners.len();
            (0..count).all(|i| {
                let [a, b] = [i, (i + 1) % count].map(|k| Vector2::from(f.corners[k]));
                a.perp(&b) > 0.01 * a.norm() * b.norm() || a.perp(&b) > 0.0 && a.dot(&b) > 0.0
            })
        })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]

    #[test]
    fn lists_of_flat_stars(face in flat(), tilt in [-0.5f64..0.5, -0.5f64..0.5]) {
        let normal = Vector3::new(tilt[0], tilt[1], 1.0).normalize();
        let Some(minima) = face.minima(normal) else { return Ok(()) };
        let below = Probe::HalfSpace(HalfSpace::new(normal, 0.0).unwrap());
        let options = Options {
            contacts: Contacts::All,
            prediction: 1000.0,
            ..Options::default()
        };
        let found = contact(&face.brep(), &below, &options, &mut Workspace::default());
        prop_assert!(found.undecided.is_none() && !found.continuum, "{:?}", found);
        for c in &found.contacts {
            let own = |p: &Point2<f64>| (c.on_brep.xy() - p).norm() < 1e-6;
            prop_assert!(minima.iter().any(own), "no minimum: {:?} of {:?}", c, minima);
        }
        prop_assert_eq!(found.contacts.len(), minima.len(), "{:?} {:?}", found.contacts, minima);
    }
}
