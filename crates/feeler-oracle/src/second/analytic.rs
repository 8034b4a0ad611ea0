//! Closed forms: distances, supports and hits of spheres, tori and whatever a segment turned fully about an axis
//! gives (cylinders, cones, discs), in balls of 256 bits.
//!
//! A surface of full revolution and a point: the nearest point lies in the half-plane of the axis that holds
//! the point, so the distance is that of (rho, z) from the profile there.

use super::number::{Ball, Number};

fn exact(v: [f64; 3]) -> [Ball; 3] {
    v.map(Ball::exact)
}

fn dot(a: &[Ball; 3], b: &[Ball; 3]) -> Ball {
    a[0].times(&b[0])
        .plus(&a[1].times(&b[1]))
        .plus(&a[2].times(&b[2]))
}

fn minus(a: &[Ball; 3], b: &[Ball; 3]) -> [Ball; 3] {
    std::array::from_fn(|c| a[c].minus(&b[c]))
}

/// `|x|`.
fn magnitude(x: &Ball) -> Ball {
    x.squared().root()
}

/// Distance from the axis through `origin` along `axis` (of any length but 0), and height along it.
pub fn meridian(point: [f64; 3], origin: [f64; 3], axis: [f64; 3]) -> Option<[Ball; 2]> {
    let (r, e) = (minus(&exact(point), &exact(origin)), exact(axis));
    let ee = dot(&e, &e);
    let along = dot(&r, &e);
    let z = along.over(&ee.root())?;
    let across = dot(&r, &r).minus(&along.squared().over(&ee)?);
    Some([across.root(), z])
}

/// The distance of a point of the half-plane from the segment between two of its points.
pub fn to_segment(p: &[Ball; 2], a: [f64; 2], b: [f64; 2]) -> Option<Ball> {
    let [a, b] = [a, b].map(|x| x.map(Ball::exact));
    let sub = |x: &[Ball; 2], y: &[Ball; 2]| [x[0].minus(&y[0]), x[1].minus(&y[1])];
    let inner = |x: &[Ball; 2], y: &[Ball; 2]| x[0].times(&y[0]).plus(&x[1].times(&y[1]));
    let (d, r, s) = (sub(&b, &a), sub(p, &a), sub(p, &b));
    let along = inner(&r, &d);
    let all = inner(&d, &d);
    let end = |v: &[Ball; 2]| inner(v, v).root();
    if along.is_negative() {
        return Some(end(&r));
    }
    if all.below(&along) {
        return Some(end(&s));
    }
    let side = r[0].times(&d[1]).minus(&r[1].times(&d[0]));
    let line = magnitude(&side).over(&all.root())?;
    if along.is_positive() && along.below(&all) {
        return Some(line);
    }
    // Not known on which side of an end's perpendicular: there both are the same up to rounding.
    Some(line.hull(&end(&r)).hull(&end(&s)))
}

/// The distance of a point of the half-plane from a full circle in it.
pub fn to_circle(p: &[Ball; 2], center: [f64; 2], radius: f64) -> Ball {
    let x = p[0].minus(&Ball::exact(center[0]));
    let y = p[1].minus(&Ball::exact(center[1]));
    let d = x.squared().plus(&y.squared()).root();
    magnitude(&d.minus(&Ball::exact(radius)))
}

/// The distance from a full sphere.
pub fn to_sphere(point: [f64; 3], center: [f64; 3], radius: f64) -> Ball {
    let r = minus(&exact(point), &exact(center));
    magnitude(&dot(&r, &r).root().minus(&Ball::exact(radius)))
}

/// The least n.x - h over a full sphere: n.c - h - r |n|.
pub fn sphere_support(normal: [f64; 3], offset: f64, center: [f64; 3], radius: f64) -> Ball {
    let n = exact(normal);
    let length = dot(&n, &n).root();
    dot(&n, &exact(center))
        .minus(&Ball::exact(offset))
        .minus(&length.times(&Ball::exact(radius)))
}

/// Where a line passes through a full sphere: none, or two parameters. `None` where that is not known.
pub fn sphere_hits(
    origin: [f64; 3],
    direction: [f64; 3],
    center: [f64; 3],
    radius: f64,
) -> Option<Vec<Ball>> {
    let (r, d) = (minus(&exact(origin), &exact(center)), exact(direction));
    // dd t^2 + 2 rd t + rr - R^2 = 0.
    let (dd, rd) = (dot(&d, &d), dot(&r, &d));
    let rest = dot(&r, &r).minus(&Ball::exact(radius).squared());
    let discriminant = rd.squared().minus(&dd.times(&rest));
    if discriminant.is_negative() {
        return Some(Vec::new());
    }
    if !discriminant.is_positive() {
        return None;
    }
    let root = discriminant.root();
    let both = [rd.negated().minus(&root), root.minus(&rd)];
    both.iter().map(|x| x.over(&dd)).collect()
}
