//! A question that asks less is answered with less work, and the same.

use crate::scenes::loops::face_within;
use crate::scenes::{
    Random, bicubic, blocks, cube, cylinder, nurbs_sphere, with_and_without_formulas,
};
use feeler::brep::{Brep, BrepBuilder, TrimSpec};
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve, NurbsCurve, NurbsSurface, Plane, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Contacts, HalfSpace, LineKind, LineProbe, Options, Probe, Sphere, Undecided, Work, Workspace,
    any_hit, contact, line, overlap,
};
use nalgebra::{Point2, Point3, Vector2, Vector3, Vector4};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, TAU};

const WIDE: Options = Options {
    prediction: f64::INFINITY,
    accuracy: feeler::query::Accuracy::Full,
    contacts: Contacts::Deepest,
    node_budget: 200_000,
};

fn ball(center: Point3<f64>, radius: f64) -> Probe {
    Probe::Sphere(Sphere::new(center, radius).unwrap())
}

/// The sign that `overlap` finds, and what it and `contact` cost.
fn both(brep: &PreparedBrep, probe: &Probe) -> (Option<bool>, Work, Work) {
    let mut workspace = Workspace::default();
    let full = contact(brep, probe, &WIDE, &mut workspace);
    let dear = workspace.work();
    let sign = overlap(brep, probe, &WIDE, &mut workspace);
    let cheap = workspace.work();
    assert_eq!(sign.overlap.is_none(), sign.undecided.is_some());
    let bounds = full.separation.bounds;
    match sign.overlap {
        Some(true) => assert!(bounds.lo < 0.0, "{probe:?} {full:?}"),
        Some(false) => assert!(bounds.hi >= 0.0, "{probe:?} {full:?}"),
        // What the whole separation settles, its sign must settle too.
        None => assert!(bounds.lo < 0.0 && bounds.hi >= 0.0, "{probe:?} {full:?}"),
    }
    assert_eq!(cheap.contacts, 0);
    (sign.overlap, cheap, dear)
}

#[test]
fn overlap_of_balls_with_a_cube_is_what_geometry_says() {
    let cube = PreparedBrep::new(cube());
    let mut random = Random::new(3);
    for _ in 0..300 {
        let c = Point3::from(Vector3::from_fn(|_, _| random.between(-1.0, 2.0)));
        let radius = random.between(0.0, 0.8);
        let out = Vector3::from_fn(|k, _| (-c[k]).max(c[k] - 1.0).max(0.0)).norm();
        let inside = out == 0.0;
        if (out - radius).abs() < 1e-9 {
            continue;
        }
        let (sign, ..) = both(&cube, &ball(c, radius));
        assert_eq!(sign, Some(inside || out < radius), "{c} {radius}");
    }
    // A ball deep inside, far from every face; one that is only a point; one beyond everything.
    assert_eq!(both(&cube, &ball([0.5; 3].into(), 0.01)).0, Some(true));
    assert_eq!(both(&cube, &ball([0.5; 3].into(), 0.0)).0, Some(true));
    assert_eq!(both(&cube, &ball([7.0; 3].into(), 0.0)).0, Some(false));
    // Touching exactly: the separation is 0, which is no overlap, where it can be proven.
    let touching = overlap(
        &cube,
        &ball([1.5, 0.5, 0.5].into(), 0.5),
        &WIDE,
        &mut Workspace::default(),
    );
    assert_ne!(touching.overlap, Some(true));
    // A radius whose square underflows.
    let tiny = ball([0.5; 3].into(), 1e-200);
    assert_eq!(both(&cube, &tiny).0, Some(true));
    let tiny = ball([1.5, 0.5, 0.5].into(), 1e-200);
    assert_eq!(both(&cube, &tiny).0, Some(false));
}

/// Squares of the least numbers are zero in f64; the distances are not.
#[test]
fn a_centre_beside_a_face_by_the_least_number() {
    let brep = PreparedBrep::new(cube());
    let least = 5e-324;
    for (height, inside) in [
        (least, true),
        (1e-200, true),
        (-least, false),
        (-1e-160, false),
    ] {
        let probe = ball(Point3::new(0.25, 0.5, height), 0.0);
        for contacts in [Contacts::None, Contacts::Deepest] {
            let options = Options {
                contacts,
                ..Options::default()
            };
            let mut workspace = Workspace::default();
            let found = contact(&brep, &probe, &options, &mut workspace);
            let b = found.separation.bounds;
            assert!(b.lo <= -height && -height <= b.hi, "{height:e} in {b:?}");
            assert_eq!(found.undecided, None);
            let over = overlap(&brep, &probe, &options, &mut workspace);
            // The side may be left open so near to a face; it is never the wrong one.
            assert_ne!(over.overlap, Some(!inside));
        }
    }
    // What touches is at 0.
    let probe = ball(Point3::new(0.25, 0.5, 0.0), 0.0);
    let found = contact(
        &brep,
        &probe,
        &Options::default(),
        &mut Workspace::default(),
    );
    assert!(found.separation.value.abs() < 1e-134);
}

#[test]
fn overlap_of_half_spaces() {
    let cube = PreparedBrep::new(cube());
    let at = |h: f64| Probe::HalfSpace(HalfSpace::new(Vector3::x(), h).unwrap());
    assert_eq!(both(&cube, &at(-0.25)).0, Some(false));
    assert_eq!(both(&cube, &at(0.25)).0, Some(true));
    assert_eq!(both(&cube, &at(5.0)).0, Some(true));
}

/// What rests on a plane, or is a step away from it.
#[test]
fn what_touches_a_half_space_does_not_overlap() {
    let box_of = |a: [f64; 3], b: [f64; 3]| blocks(&[[a, b]]);
    let block = box_of([-0.25, 0.75, 1.0 / 1024.0], [0.125, 1e3, 2.5]);
    let drum = cylinder([0.3, -0.7, 0.1], [1.25, 1.25], 0.3, 1.5);
    // Its sides are not tangent to planes in exact numbers.
    for (brep, axes, top) in [
        (block, 3, [0.125, 1e3, 2.5]),
        (drum, 1, [0.0, 0.0, 0.1 + 0.3]),
    ] {
        for brep in with_and_without_formulas(brep) {
            for k in 3 - axes..3 {
                let mut normal = Vector3::zeros();
                normal[k] = -1.0;
                let at = |h: f64| Probe::HalfSpace(HalfSpace::new(normal, h).unwrap());
                let height: f64 = -top[k];
                assert_eq!(both(&brep, &at(height)).0, Some(false), "{k}");
                assert_eq!(both(&brep, &at(height.next_down())).0, Some(false), "{k}");
                assert_eq!(both(&brep, &at(height.next_up())).0, Some(true), "{k}");
            }
        }
    }
    // On an edge and on a corner.
    let cube = PreparedBrep::new(cube());
    for normal in [
        [0.6, 0.8, 0.0],
        [0.8, 0.0, 0.6],
        [0.48, 0.64, 0.6],
        [1.0, 1e-20, 0.0],
    ] {
        let at = |h: f64| Probe::HalfSpace(HalfSpace::new(normal.into(), h).unwrap());
        assert_eq!(both(&cube, &at(0.0)).0, Some(false), "{normal:?}");
        assert_eq!(both(&cube, &at(-1e-300)).0, Some(false), "{normal:?}");
        // A step of the least f64 may be left open; it is no touch.
        assert_ne!(both(&cube, &at(5e-324)).0, Some(false), "{normal:?}");
        assert_eq!(both(&cube, &at(1e-40)).0, Some(true), "{normal:?}");
    }
}

/// Discs and half discs, of arcs and of NURBS, upright on a plane: their lowest points are quadrants.
#[test]
fn an_upright_disc_does_not_overlap_what_it_touches() {
    let (center, radius) = ([0.5, -0.25], 1.25);
    let arc = |from: f64, to: f64| {
        let arc = Arc {
            center: center.into(),
            x: Vector2::x(),
            y: Vector2::y(),
            z: Vector2::zeros(),
            radius,
            angle: Interval::new(from, to).unwrap(),
            domain: Interval::new(0.0, 1.0).unwrap(),
        };
        Curve::Arc(Arc::new(arc).unwrap())
    };
    // A square about the circle, with the circle's points at the middles of its sides.
    let quadrant = |k: usize| {
        let turned = |[x, y]: [f64; 2]| [[x, y], [-y, x], [-x, -y], [y, -x]][k];
        let (w, points) = (FRAC_1_SQRT_2, [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        let net = points.into_iter().zip([1.0, w, 1.0]).map(|(p, w)| {
            let [x, y] = turned(p);
            let at = [center[0] + radius * x, center[1] + radius * y];
            Vector3::new(at[0] * w, at[1] * w, w)
        });
        let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        Curve::Nurbs(NurbsCurve::new(2, net.collect(), knots).unwrap())
    };
    let disc = || (0..4).map(|k| arc(f64::from(k) * FRAC_PI_2, f64::from(k + 1) * FRAC_PI_2));
    for (curves, is_exact) in [
        (disc().collect(), true),
        (vec![arc(0.0, TAU)], true),
        // Their control points are off by roundings of the weights.
        ((0..4).map(quadrant).collect(), false),
    ] {
        for brep in with_and_without_formulas(face_within(vec![curves])) {
            for (k, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
                let mut normal = Vector3::zeros();
                normal[k] = sign;
                let at = |h: f64| Probe::HalfSpace(HalfSpace::new(normal, h).unwrap());
                let height: f64 = sign * center[k] - radius;
                let over = both(&brep, &at(height)).0;
                let told = over == Some(false) || (!is_exact && over.is_none());
                assert!(told, "{k} {sign} {over:?}");
                assert_eq!(
                    both(&brep, &at(height - 1e-15)).0,
                    Some(false),
                    "{k} {sign}"
                );
                assert_eq!(both(&brep, &at(height + 1e-15)).0, Some(true), "{k} {sign}");
            }
        }
    }
}

/// What dips below a plane by less than any enclosure tells overlaps it: the far end of a square that is tilted, and a disc beside its quadrant.
#[test]
fn what_dips_by_less_than_enclosures_tell_is_no_touch() {
    let tilt = 2.0f64.powi(-130);
    let unit = Interval::new(0.0, 1.0).unwrap();
    let square = |x: Vector3<f64>, y: Vector3<f64>| {
        let plane = Plane {
            origin: Point3::new(0.1, 0.2, 0.3),
            x,
            y,
            domain: [unit; 2],
            extents: [unit; 2],
        };
        let surface = Surface::Plane(Plane::new(plane).unwrap());
        PreparedBrep::new(Brep::from_surface(surface).unwrap())
    };
    let down = Vector3::new(1.0, 0.0, -tilt);
    let level = Vector3::y();
    let rests = Probe::HalfSpace(HalfSpace::new(Vector3::z(), 0.3).unwrap());
    for brep in [square(down, level), square(level, down)] {
        assert_ne!(both(&brep, &rests).0, Some(false));
    }
    let up = Vector3::new(1.0, 0.0, tilt);
    for brep in [square(up, level), square(level, up)] {
        assert_eq!(both(&brep, &rests).0, Some(false));
    }
    // Of radius 5/4 about (1/2, 0): least where the normal meets it, 4e-43 below -3/4.
    let circle = Arc {
        center: Point2::new(0.5, 0.0),
        x: Vector2::x(),
        y: Vector2::y(),
        z: Vector2::zeros(),
        radius: 1.25,
        // Its lowest point is on a part that ends at no axis: of these the circle alone is exact.
        angle: Interval::new(3.5, 3.5 + TAU).unwrap(),
        domain: unit,
    };
    let circle = Curve::Arc(Arc::new(circle).unwrap());
    let disc = PreparedBrep::new(face_within(vec![vec![circle]]));
    let slant = Vector3::new(1.0, 2.0f64.powi(-70), 0.0);
    let beside = |h: f64| Probe::HalfSpace(HalfSpace::new(slant, h).unwrap());
    assert_ne!(both(&disc, &beside(-0.75)).0, Some(false));
    assert_eq!(both(&disc, &beside((-0.75f64).next_down())).0, Some(false));
}

/// Balls on flat faces, along the axes and aslant, with a radius that is the distance, exactly.
#[test]
fn what_touches_a_ball_does_not_overlap() {
    let cube = PreparedBrep::new(cube());
    for radius in [0.5, 0.1, 1e-3, 2.0f64.powi(-60)] {
        // One more or less where the sum is rounded.
        let over = 1.0 + radius;
        for (c, axis) in [
            (Point3::new(0.3, 0.6, over), 2),
            (Point3::new(over, 0.7, 0.2), 0),
        ] {
            let gap = (c[axis] - 1.0) - radius;
            let sign = both(&cube, &ball(c, radius)).0;
            assert_eq!(sign, Some(gap < 0.0), "{c} {radius:e}");
            if gap == 0.0 {
                assert_eq!(both(&cube, &ball(c, radius.next_up())).0, Some(true));
            }
        }
    }
    // A plane along (-4, 0, 3) and y: five below the middle of the ball, in units of a quarter.
    let wide = Interval::new(-2.0, 2.0).unwrap();
    let plane = Plane {
        origin: Point3::origin(),
        x: Vector3::new(3.0, 0.0, 4.0),
        y: Vector3::y(),
        domain: [wide; 2],
        extents: [wide; 2],
    };
    let slope = Brep::from_surface(Surface::Plane(Plane::new(plane).unwrap())).unwrap();
    let slope = PreparedBrep::new(slope);
    let c = Point3::new(-1.0, 0.25, 0.75);
    assert_eq!(both(&slope, &ball(c, 1.25)).0, Some(false));
    assert_eq!(both(&slope, &ball(c, 1.25f64.next_up())).0, Some(true));
}

#[test]
fn overlap_costs_less_on_a_search() {
    let wave = PreparedBrep::new(bicubic());
    let hole = PreparedBrep::new(nurbs_sphere());
    let mut random = Random::new(5);
    let (mut cheap, mut dear) = (0, 0);
    for _ in 0..200 {
        let over = Point3::new(
            random.between(0.1, 0.9),
            random.between(0.1, 0.9),
            random.between(-0.3, 0.3),
        );
        let (sign, less, more) = both(&wave, &ball(over, 0.1));
        assert_ne!(sign, None);
        assert!(less.nodes <= more.nodes, "{over} {less:?} {more:?}");
        (cheap, dear) = (cheap + less.nodes, dear + more.nodes);
        // Off the centre of a ball of radius 2.5 by `off`.
        let off = random.between(0.01, 1.0);
        let radius = random.between(1.0, 3.0);
        if (2.5 - off - radius).abs() < 1e-9 {
            continue;
        }
        let at = Point3::from(random.direction() * off);
        let (sign, ..) = both(&hole, &ball(at, radius));
        // An open sheet, whatever it encloses.
        assert_eq!(sign, Some(2.5 - off < radius), "{at} {radius}");
    }
    assert!(2 * cheap < dear, "{cheap} of {dear}");
}

#[test]
fn a_centre_beyond_everything_casts_no_ray() {
    let cube = PreparedBrep::new(cube());
    let mut workspace = Workspace::default();
    let far = contact(
        &cube,
        &ball([2.0, 0.5, 0.5].into(), 0.25),
        &WIDE,
        &mut workspace,
    );
    assert_eq!(far.separation.value, 0.75);
    assert_eq!(workspace.work().rays, 0);
    contact(
        &cube,
        &ball([0.5, 0.25, 0.5].into(), 0.25),
        &WIDE,
        &mut workspace,
    );
    assert!(workspace.work().rays > 0);
    // The first face found nearer than the radius says all.
    overlap(
        &cube,
        &ball([0.5, 0.25, 0.5].into(), 0.5),
        &WIDE,
        &mut workspace,
    );
    assert_eq!(workspace.work().rays, 0);
}

#[test]
fn without_contacts_the_separation_is_the_same() {
    let mut random = Random::new(9);
    for brep in [bicubic(), nurbs_sphere(), cube()] {
        let brep = PreparedBrep::new(brep);
        for _ in 0..50 {
            let at = Point3::from(Vector3::from_fn(|_, _| random.between(-0.5, 1.5)));
            let probe = ball(at, 0.1);
            let mut workspace = Workspace::default();
            let deepest = contact(&brep, &probe, &WIDE, &mut workspace);
            assert_eq!(workspace.work().contacts, 1);
            let none = Options {
                contacts: Contacts::None,
                ..WIDE
            };
            let bare = contact(&brep, &probe, &none, &mut workspace);
            assert_eq!(workspace.work().contacts, 0);
            assert_eq!(bare.separation, deepest.separation);
            assert_eq!(bare.undecided, deepest.undecided);
            assert!(bare.contacts.is_empty());
        }
    }
}

#[test]
fn any_hit_is_one_of_all() {
    let mut random = Random::new(17);
    for brep in [bicubic(), nurbs_sphere(), cube()] {
        let brep = PreparedBrep::new(brep);
        let (mut cheap, mut dear, mut met) = (0, 0, 0);
        for _ in 0..200 {
            let from = Point3::from(Vector3::from_fn(|_, _| random.between(-0.5, 1.5)));
            let kind = [LineKind::Line, LineKind::Ray, LineKind::Segment][random.below(3)];
            let probe = LineProbe::new(from, random.direction() * 3.0, kind).unwrap();
            let mut workspace = Workspace::default();
            let all = line(&brep, &probe, &WIDE, &mut workspace);
            dear += workspace.work().nodes;
            let any = any_hit(&brep, &probe, &WIDE, &mut workspace);
            cheap += workspace.work().nodes;
            match (&any.hit, any.undecided) {
                (Some(hit), None) => {
                    assert!(all.hits.contains(hit), "{probe:?}");
                    met += 1;
                }
                (None, None) => assert!(all.hits.is_empty(), "{probe:?}"),
                (None, Some(_)) => assert!(all.undecided.is_some(), "{probe:?}"),
                (Some(_), Some(_)) => panic!("certain and undecided: {probe:?}"),
            }
            // What all hits settle, one does.
            if all.undecided.is_none() {
                assert_eq!(any.hit.is_some(), !all.hits.is_empty(), "{probe:?}");
            }
        }
        assert!(met > 10, "{met}");
        assert!(cheap <= dear, "{cheap} {dear}");
    }
}

#[test]
fn a_spent_budget_is_no_sign() {
    let wave = PreparedBrep::new(bicubic());
    let starved = Options {
        node_budget: 0,
        ..WIDE
    };
    let probe = ball([0.5, 0.5, 0.1].into(), 0.1);
    let answer = overlap(&wave, &probe, &starved, &mut Workspace::default());
    assert_eq!(answer.overlap, None);
    assert_eq!(answer.undecided, Some(Undecided::Budget));
}

/// A bicubic sheet `(3u, 3v, z)` with waves of height 1, trimmed to `u >= 1/2`, and its height in the middle.
fn half_a_sheet() -> (Brep, f64) {
    let heights = [
        [1.0, -1.0, 1.0, -1.0],
        [-1.0, 1.0, -1.0, 1.0],
        [1.0, 1.0, -1.0, -1.0],
        [-1.0, 1.0, 1.0, -1.0],
    ];
    let net = (0..16).map(|k| {
        let (i, j) = (k / 4, k % 4);
        Vector4::new(f64::from(i as u8), f64::from(j as u8), heights[i][j], 1.0)
    });
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let surface = NurbsSurface::new([3, 3], [4, 4], net.collect(), [knots.clone(), knots]);
    let surface = Surface::Nurbs(surface.unwrap());
    // The Bernstein polynomials are 1/8, 3/8, 3/8 and 1/8 there.
    let weight = [0.125, 0.375, 0.375, 0.125];
    let middle = (0..16).map(|k| weight[k / 4] * weight[k % 4] * heights[k / 4][k % 4]);
    let middle = middle.sum();
    let mut b = BrepBuilder::new();
    let corners = [[0.5, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 1.0]];
    let vertices = corners.map(|[u, v]| b.vertex(surface.point(u, v)));
    let trims = (0..4).map(|i| {
        let ends = [i, (i + 1) % 4];
        let net = ends.map(|e| Vector3::new(corners[e][0], corners[e][1], 1.0));
        let curve = NurbsCurve::new(1, net.to_vec(), vec![0.0, 0.0, 1.0, 1.0]).unwrap();
        TrimSpec {
            vertices: ends.map(|e| vertices[e]),
            curve: Curve::Nurbs(curve),
            edge: None,
        }
    });
    b.face_with_trims(surface, vec![trims.collect()]).unwrap();
    (b.build().unwrap(), middle)
}

/// A hit beside a trim by 1e-20 is on the side where exact arithmetic puts it.
#[test]
fn a_hit_next_to_a_trim() {
    let (brep, middle) = half_a_sheet();
    let brep = PreparedBrep::new(brep);
    for (lean, hits) in [(3e-20, 0), (-3e-20, 1)] {
        // It meets the sheet at t = -1, up to the lean times the slope.
        let from = Point3::new(1.5, 1.5, middle + 1.0);
        let probe = LineProbe::new(from, Vector3::new(lean, 0.0, 1.0), LineKind::Line).unwrap();
        let found = line(&brep, &probe, &WIDE, &mut Workspace::default());
        assert_eq!(found.undecided, None, "{lean:e}");
        assert_eq!(found.hits.len(), hits, "{lean:e}");
    }
}
