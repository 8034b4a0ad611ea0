//! The libraries' own surfaces and curves.

use curvo::prelude::{NurbsCurve3D, NurbsSurface3D};
use curvo_nalgebra as na;
use feeler::nurbs::{NurbsCurve3, NurbsSurface};
use nalgebra::{Point3, Vector3, Vector4};
use truck_geometry::prelude as truck;
use truck_geometry::prelude::{
    BoundedCurve, ParametricCurve, ParametricSurface, SearchNearestParameter,
};

/// Steps of truck's Newton iteration: what its own examples take.
const TRIALS: usize = 100;

/// Which library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Library {
    Truck,
    Curvo,
}

type TruckSurface = truck::NurbsSurface<truck::Vector4>;
type TruckCurve = truck::NurbsCurve<truck::Vector4>;

pub(crate) enum PeerSurface {
    Truck(Box<TruckSurface>),
    Curvo(Box<NurbsSurface3D<f64>>),
}

pub(crate) enum PeerCurve {
    Truck(TruckCurve),
    Curvo(NurbsCurve3D<f64>),
}

impl Library {
    pub(crate) fn by_name(name: &str) -> Option<Self> {
        [Self::Truck, Self::Curvo]
            .into_iter()
            .find(|l| l.name() == name)
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Truck => "truck",
            Self::Curvo => "curvo",
        }
    }

    /// Of the package, as far as `Cargo.toml` fixes it.
    pub(crate) fn version(self) -> &'static str {
        match self {
            Self::Truck => "0.5",
            Self::Curvo => "0.3",
        }
    }

    pub(crate) fn surface(self, s: &NurbsSurface) -> Result<PeerSurface, String> {
        let rows: Vec<Vec<Vector4<f64>>> = s
            .control_net()
            .chunks(s.counts()[1])
            .map(<[_]>::to_vec)
            .collect();
        let knots = [s.knots_u(), s.knots_v()].map(|k| k.knots().to_vec());
        let degrees = [s.knots_u(), s.knots_v()].map(|k| k.degree());
        match self {
            Self::Truck => {
                let rows = rows.iter().map(|r| r.iter().map(to_truck).collect());
                let [u, v] = knots.map(truck::KnotVec::from);
                let spline = truck::BSplineSurface::try_new((u, v), rows.collect());
                let spline = spline.map_err(|e| e.to_string())?;
                Ok(PeerSurface::Truck(Box::new(truck::NurbsSurface::new(
                    spline,
                ))))
            }
            Self::Curvo => {
                let rows = rows.iter().map(|r| r.iter().map(to_curvo).collect());
                let [u, v] = knots;
                let spline = NurbsSurface3D::new(degrees[0], degrees[1], u, v, rows.collect());
                Ok(PeerSurface::Curvo(Box::new(spline)))
            }
        }
    }

    pub(crate) fn curve(self, c: &NurbsCurve3) -> Result<PeerCurve, String> {
        let points = c.control_points();
        let knots = c.knots().knots().to_vec();
        match self {
            Self::Truck => {
                let points = points.iter().map(to_truck).collect();
                let spline = truck::BSplineCurve::try_new(knots.into(), points);
                let spline = spline.map_err(|e| e.to_string())?;
                Ok(PeerCurve::Truck(truck::NurbsCurve::new(spline)))
            }
            Self::Curvo => {
                let points = points.iter().map(to_curvo).collect();
                let spline = NurbsCurve3D::try_new(c.degree(), points, knots);
                spline.map(PeerCurve::Curvo).map_err(|e| e.to_string())
            }
        }
    }
}

/// Both take homogeneous points `(wx, wy, wz, w)`, as we do.
fn to_truck(p: &Vector4<f64>) -> truck::Vector4 {
    truck::Vector4::new(p.x, p.y, p.z, p.w)
}

fn to_curvo(p: &Vector4<f64>) -> na::Point4<f64> {
    na::Point4::new(p.x, p.y, p.z, p.w)
}

impl PeerSurface {
    /// Parameters of the nearest point that the library finds.
    pub(crate) fn nearest(&self, p: Point3<f64>) -> Option<[f64; 2]> {
        match self {
            Self::Truck(s) => {
                let at = truck::Point3::new(p.x, p.y, p.z);
                let (u, v) = s.search_nearest_parameter(at, None, TRIALS)?;
                Some([u, v])
            }
            Self::Curvo(s) => {
                let at = na::Point3::new(p.x, p.y, p.z);
                let (u, v) = s.find_closest_parameter(&at, None).ok()?;
                Some([u, v])
            }
        }
    }

    /// A point, and the unit normal where there is one.
    pub(crate) fn point_and_normal(&self, u: f64, v: f64) -> (Point3<f64>, Option<Vector3<f64>>) {
        let (p, n) = match self {
            Self::Truck(s) => {
                let (p, a, b) = (s.subs(u, v), s.uder(u, v), s.vder(u, v));
                let [a, b] = [a, b].map(|d| Vector3::new(d.x, d.y, d.z));
                (Point3::new(p.x, p.y, p.z), a.cross(&b))
            }
            Self::Curvo(s) => {
                let (p, n) = (s.point_at(u, v), s.normal_at(u, v));
                (Point3::new(p.x, p.y, p.z), Vector3::new(n.x, n.y, n.z))
            }
        };
        (p, n.try_normalize(0.0))
    }
}

impl PeerCurve {
    /// The parameter of the nearest point that the library finds.
    pub(crate) fn nearest(&self, p: Point3<f64>, range: [f64; 2]) -> Option<f64> {
        match self {
            Self::Truck(c) => {
                let at = truck::Point3::new(p.x, p.y, p.z);
                c.search_nearest_parameter(at, (range[0], range[1]), TRIALS)
            }
            Self::Curvo(c) => {
                let at = na::Point3::new(p.x, p.y, p.z);
                c.find_closest_parameter(&at).ok()
            }
        }
    }

    pub(crate) fn point(&self, t: f64) -> Point3<f64> {
        match self {
            Self::Truck(c) => {
                let (from, to) = c.range_tuple();
                let p = c.subs(t.clamp(from, to));
                Point3::new(p.x, p.y, p.z)
            }
            Self::Curvo(c) => {
                let p = c.point_at(t);
                Point3::new(p.x, p.y, p.z)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The surfaces arrive as they are: a rational quarter of a cylinder.
    #[test]
    fn points_are_the_kernels() {
        let w = std::f64::consts::FRAC_1_SQRT_2;
        let arc = [(1.0, 0.0, 1.0), (w, w, w), (0.0, 1.0, 1.0)];
        let net = arc
            .iter()
            .flat_map(|(x, y, w)| [0.0, 3.0].map(|z| Vector4::new(*x, *y, z * w, *w)));
        let knots = [vec![0.0, 0.0, 0.0, 2.0, 2.0, 2.0], vec![0.0, 0.0, 1.0, 1.0]];
        let ours = NurbsSurface::new([2, 1], [3, 2], net.collect(), knots).unwrap();
        let kernel = feeler::nurbs::Surface::Nurbs(ours.clone());
        for library in [Library::Truck, Library::Curvo] {
            let theirs = library.surface(&ours).unwrap();
            for (u, v) in [(0.3, 0.2), (1.0, 0.5), (1.9, 1.0)] {
                let p = kernel.point(u, v);
                let (q, n) = theirs.point_and_normal(u, v);
                assert!((p - q).norm() < 1e-14, "{library:?}: {p} {q}");
                // On a cylinder about z the normal is the point's own direction, in or out.
                let out = Vector3::new(p.x, p.y, 0.0);
                assert!((n.unwrap().dot(&out).abs() - 1.0).abs() < 1e-14);
                let [a, b] = theirs.nearest(p + out * 0.1).unwrap();
                assert!((a - u).abs() + (b - v).abs() < 1e-5, "{library:?}: {a} {b}");
            }
        }
    }
}
