//! Whether a hit of a line with a patch is in the face's region.

use crate::numeric::{Ball, Dd};
use crate::prepare::PreparedBrep;
use crate::trim::{BoxSide, Side, TrimRegion};
use nalgebra::Point2;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;

/// A border of a surface that a zero is on, exactly.
#[derive(Clone, Copy, Debug)]
pub(super) enum OnBorder {
    /// The seam across a coordinate.
    Seam(usize),
    /// No seam: across this coordinate, at this end of its domain.
    End(usize, f64),
    /// A corner of the domain.
    Corner([f64; 2]),
}

/// Where a zero is, known within `rho`: first by a box in f64, and where that meets the region's boundary by all digits. It
/// was found from a node that is known to be inside or not, but may lie beside it.
pub(super) fn side_at(
    brep: &PreparedBrep,
    (face, patch): (usize, usize),
    (local, rho, border): ([Dd; 2], f64, Option<OnBorder>),
    inside: Option<[[f64; 2]; 2]>,
) -> BoxSide {
    let off = Dd::from(rho * UP);
    let within = |b: [[f64; 2]; 2]| {
        (0..2).all(|k| Dd::from(b[k][0]) <= local[k] - off && local[k] + off <= Dd::from(b[k][1]))
    };
    if inside.is_some_and(within) {
        return BoxSide::Inside;
    }
    let region = brep.region(face);
    let maps = &brep.double(face).patches[patch].maps;
    let uv = [0, 1].map(|k| {
        let x = Ball {
            mid: local[k],
            rad: rho * UP,
        };
        maps[k].to_native_ball(x)
    });
    // Where the zero may be just beyond its patch, it stands for the next patch's, which is elsewhere by as little: a box holds
    // both, but not all digits do.
    let on_patch = |k: usize| local[k] - off >= Dd::ZERO && local[k] + off <= Dd::ONE;
    match border {
        Some(OnBorder::Seam(k)) => return side_on_seam(region, k, (uv[1 - k], on_patch(1 - k))),
        Some(OnBorder::End(k, at)) => {
            return match side_on_border(region, (k, at), (uv[1 - k], on_patch(1 - k))) {
                Some(Side::Inside) => BoxSide::Inside,
                Some(Side::Outside) => BoxSide::Outside,
                Some(Side::Boundary) | None => BoxSide::Mixed,
            };
        }
        Some(OnBorder::Corner(at)) => {
            return corner_side(brep, face, at).unwrap_or(BoxSide::Mixed);
        }
        None => {}
    }
    let r = rho * UP + 4.0 * f64::EPSILON;
    let around = |k: usize| {
        let x = local[k].hi;
        maps[k].to_native_range((x - r).max(0.0), (x + r).min(1.0))
    };
    let side = region.classify_box(around(0), around(1));
    if side != BoxSide::Mixed || !(0..2).all(on_patch) {
        return side;
    }
    match region.side_of_ball(uv) {
        Some(Side::Inside) => BoxSide::Inside,
        Some(Side::Outside) => BoxSide::Outside,
        Some(Side::Boundary) | None => BoxSide::Mixed,
    }
}

/// Where all of a parameter line is: on a border of the domain in the closed region where what is beside it is inside, on a seam where that is so on either side of it.
pub(super) fn row_side(brep: &PreparedBrep, face: usize, across: usize, at: f64) -> BoxSide {
    let region = brep.region(face);
    let domain = region.domain();
    let mut uv = domain.map(|d| [d.start, d.end]);
    let mut side = |r: [f64; 2]| {
        uv[across] = r;
        region.classify_box(uv[0], uv[1])
    };
    let d = domain[across];
    let here = side([at; 2]);
    if here == BoxSide::Inside || (at != d.start && at != d.end) {
        return here;
    }
    let is_seam = brep.meets_itself(face, across == 0);
    let ends = [d.start, d.end];
    let mut copies = ends.iter().filter(|end| is_seam || **end == at);
    if copies
        .clone()
        .any(|end| side(beside(region, (across, *end))) == BoxSide::Inside)
    {
        BoxSide::Inside
    } else if copies.all(|end| side([*end; 2]) == BoxSide::Outside) {
        BoxSide::Outside
    } else {
        BoxSide::Mixed
    }
}

/// Where a point is that is exactly on the seam across a coordinate, given the other and whether that is surely on its patch: in the region where it is on either side of the seam.
fn side_on_seam(region: &TrimRegion, across: usize, along: (Ball<Dd>, bool)) -> BoxSide {
    let domain = region.domain()[across];
    let sides = [domain.start, domain.end].map(|end| side_on_border(region, (across, end), along));
    if sides.contains(&Some(Side::Inside)) {
        BoxSide::Inside
    } else if sides == [Some(Side::Outside); 2] {
        BoxSide::Outside
    } else {
        BoxSide::Mixed
    }
}

/// Where a zero counts that is exactly at a corner of the domain. Over seams it is at others too: of these the first one that is in the closed region counts, which is a zero of its own patch.
/// Over two seams all count, if one is in the region: they are a joint as any other, and settled as that.
fn corner_side(brep: &PreparedBrep, face: usize, at: [f64; 2]) -> Option<BoxSide> {
    let region = brep.region(face);
    let is_joint = brep.meets_itself(face, true) && brep.meets_itself(face, false);
    let ends = [0, 1].map(|k| {
        let d = region.domain()[k];
        if brep.meets_itself(face, k == 0) {
            [d.start, d.end]
        } else {
            [at[k]; 2]
        }
    });
    for u in ends[0] {
        for v in ends[1] {
            if region.side(Point2::new(u, v)).side? != Side::Outside {
                let own = [u, v] == at || is_joint;
                return Some(if own {
                    BoxSide::Inside
                } else {
                    BoxSide::Outside
                });
            }
        }
    }
    Some(BoxSide::Outside)
}

/// Where a point is that is exactly on a border of the domain, given the other coordinate and whether that is surely on its patch: on the region's side of it where a loop runs along the border, so
/// that this is in the closed region.
fn side_on_border(
    region: &TrimRegion,
    (across, end): (usize, f64),
    (along, on_patch): (Ball<Dd>, bool),
) -> Option<Side> {
    let beside = beside(region, (across, end));
    let (mut uv, mut b) = ([along; 2], [[along.lower(), along.upper()]; 2]);
    (uv[across], b[across]) = (Ball::exact(end), beside);
    // A loop that runs along the border leaves what is beside it inside.
    match region.classify_box(b[0], b[1]) {
        BoxSide::Inside => Some(Side::Inside),
        BoxSide::Outside => Some(Side::Outside),
        BoxSide::Mixed if on_patch => region.side_of_ball(uv),
        BoxSide::Mixed => None,
    }
}

/// A narrow range of a coordinate beside an end of the domain, within it.
fn beside(region: &TrimRegion, (across, end): (usize, f64)) -> [f64; 2] {
    let domain = region.domain()[across];
    let width = BESIDE_SEAM * domain.length();
    if end == domain.start {
        [end, end + width]
    } else {
        [end - width, end]
    }
}

/// How wide a box beside a border is, as a part of the domain: hardly more than there are f64 for.
const BESIDE_SEAM: f64 = 1.0 / (1u64 << 48) as f64;
