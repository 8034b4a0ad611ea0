//! `ON_Brep` 3.2.

use super::super::archive::{ANONYMOUS, UNSET};
use super::chunks::Writer;
use super::geometry::{Bounds, Geometry, bound, bound_surface};
use feeler::brep::{Brep, Iso, LoopKind, TrimCurve, TrimKind};
use feeler::nurbs::{Curve, Curve2};

const BREP: &str = "60B5DBC5-E660-11d3-BFE4-0010830122F0";

/// A list of curves or surfaces, all there.
fn geometry<T>(w: &mut Writer, all: &[T], mut write: impl FnMut(&mut Writer, &T)) {
    w.chunk(ANONYMOUS, |w| {
        w.u8(0x10);
        w.index(all.len());
        for item in all {
            w.i32(1);
            write(w, item);
        }
    });
}

/// A list of items that start with their own index.
fn list<T>(w: &mut Writer, all: &[T], mut write: impl FnMut(&mut Writer, &T)) {
    w.chunk(ANONYMOUS, |w| {
        w.u8(0x10);
        w.index(all.len());
        for (i, item) in all.iter().enumerate() {
            w.index(i);
            write(w, item);
        }
    });
}

fn optional(index: Option<usize>) -> i32 {
    index.map_or(-1, |i| i32::try_from(i).unwrap_or(i32::MAX))
}

fn kind(kind: TrimKind) -> i32 {
    match kind {
        TrimKind::Unknown => 0,
        TrimKind::Boundary => 1,
        TrimKind::Mated => 2,
        TrimKind::Seam => 3,
        TrimKind::Singular => 4,
    }
}

fn iso(iso: Iso) -> i32 {
    match iso {
        Iso::None => 0,
        Iso::U => 1,
        Iso::V => 2,
        Iso::West => 3,
        Iso::South => 4,
        Iso::East => 5,
        Iso::North => 6,
    }
}

/// openNURBS takes a trim for one along a border that is off it by no more than this part of the domain: the root of 2^-52.
const ALONG: f64 = 1.0 / (1_u64 << 26) as f64;

/// How far a straight curve, or the control points of a spline, reach in u and v; `None` of other curves.
fn reach(curve: &Curve2) -> Option<[[f64; 2]; 2]> {
    let around = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let none = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        points.fold(none, |r, p| {
            [0, 1].map(|c| [r[c][0].min(p[c]), r[c][1].max(p[c])])
        })
    };
    match curve {
        Curve::Line(l) => Some(around(&mut [l.from, l.to].iter().map(|p| [p.x, p.y]))),
        Curve::Nurbs(n) => {
            let points = n.control_points().iter();
            Some(around(&mut points.map(|p| [p.x / p.z, p.y / p.z])))
        }
        _ => None,
    }
}

/// The place on its surface's domain, which import may have widened, of a trim along a parameter line; of curves that are neither straight nor
/// splines what the file said.
fn iso_on_surface(brep: &Brep, trim: &TrimCurve) -> Iso {
    let parts = brep.parts();
    let face = parts.loops.get(trim.trim_loop).map(|l| l.face);
    let surface = face.and_then(|f| parts.faces.get(f)).map(|f| f.surface);
    let surface = surface.and_then(|s| parts.surfaces.get(s));
    let (Some(surface), Some(reach)) = (surface, parts.curves2.get(trim.curve).and_then(reach))
    else {
        return trim.iso;
    };
    let kinds = [
        [Iso::West, Iso::U, Iso::East],
        [Iso::South, Iso::V, Iso::North],
    ];
    for (c, ([low, inside, high], domain)) in kinds.into_iter().zip(surface.domain()).enumerate() {
        let slack = ALONG * domain.length();
        let near = |x: f64| reach[c].iter().all(|end| (end - x).abs() <= slack);
        if near(domain.start) {
            return low;
        } else if near(domain.end) {
            return high;
        } else if near(reach[c][0]) {
            return inside;
        }
    }
    trim.iso
}

/// A BREP with its wrapper.
pub(super) fn brep(w: &mut Writer, g: &mut Geometry, brep: &Brep) {
    w.object(BREP, |w| data(w, g, brep));
}

fn data(w: &mut Writer, g: &mut Geometry, brep: &Brep) {
    let p = brep.parts();
    w.u8(0x32);
    geometry(w, &p.curves2, |w, c| g.curve(w, c));
    geometry(w, &p.curves3, |w, c| g.curve(w, c));
    geometry(w, &p.surfaces, |w, s| g.surface(w, s));
    list(w, &p.vertices, |w, v| {
        w.f64s(v.point.coords.as_slice());
        w.indices(&v.edges);
        w.f64s(&[v.tolerance.unwrap_or(UNSET)]);
    });
    list(w, &p.edges, |w, e| {
        let span = [e.span.start, e.span.end];
        w.i32(optional(e.curve));
        w.i32(i32::from(e.reversed));
        w.f64s(&span);
        e.vertices.iter().for_each(|v| w.index(*v));
        w.indices(&e.trims);
        w.f64s(&[e.tolerance.unwrap_or(UNSET)]);
        w.f64s(&span);
    });
    list(w, &p.trims, |w, t| {
        let span = [t.span.start, t.span.end];
        w.index(t.curve);
        w.f64s(&span);
        w.i32(optional(t.edge));
        t.vertices.iter().for_each(|v| w.index(*v));
        w.i32(i32::from(t.edge_reversed));
        w.i32(kind(t.kind));
        w.i32(iso(iso_on_surface(brep, t)));
        w.index(t.trim_loop);
        // Tolerances of trims are not kept; valid ones are numbers.
        w.f64s(&[0.0; 2]);
        w.f64s(&span);
        w.raw(&[u8::from(t.reversed), 0, 0, 0, 0, 0, 0, 0]);
        w.raw(&[0; 24]);
        w.f64s(&[0.0; 2]);
    });
    list(w, &p.loops, |w, l| {
        w.indices(&l.trims);
        w.i32(match l.kind {
            LoopKind::Unknown => 0,
            LoopKind::Outer => 1,
            LoopKind::Inner => 2,
            LoopKind::Slit => 3,
        });
        w.index(l.face);
    });
    list(w, &p.faces, |w, f| {
        w.indices(f.loops.as_deref().unwrap_or(&[]));
        w.index(f.surface);
        w.i32(i32::from(f.reversed));
        // No material.
        w.i32(-1);
    });
    let mut bounds = Bounds::empty();
    p.surfaces
        .iter()
        .for_each(|s| bound_surface(s, &mut bounds));
    p.curves3.iter().for_each(|c| bound(c, &mut bounds));
    p.vertices.iter().for_each(|v| bounds.add(v.point.coords));
    bounds.write(w);
    // Meshes for display: none, face by face, of both kinds.
    for _ in 0..2 {
        w.chunk(ANONYMOUS, |w| p.faces.iter().for_each(|_| w.u8(0)));
    }
    // Whether it is a solid: let the reader look.
    w.i32(0);
}
