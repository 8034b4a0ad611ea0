//! The kernel's answers about geometry aimed at where it breaks, against the oracle: sides next to trims, separations, feet, lists of contacts.
//!
//! `PROPTEST_CASES` asks for more cases than the few of each run.

#[path = "../../../feeler/src/trim/tests/near.rs"]
mod near;

use crate::scene::{brep, dyadic, plane, sq};
use feeler::brep::{Brep, BrepBuilder};
use feeler::numeric::Dyadic;
use feeler::nurbs::{Curve2, NurbsCurve, NurbsSurface, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{
    Accuracy, Contact, ContactAnswer, Contacts, Feature, HalfSpace, Options, Probe, Sphere,
    Workspace, contact,
};
use feeler::trim::{Side, TrimRegion};
use feeler_corpus::{Asked, Body, Hits, Truth, TruthEnclosure, Verdict, judge};
use feeler_oracle::{DistanceStatus, Oracle};
use nalgebra::{Point2, Point3, Vector3, Vector4};
use near::{Aim, Spline, aim, cases, loops, one_loop, stepped};
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};
use std::cell::Cell;

fn curve(s: &Spline) -> Curve2 {
    let net = s.net.iter().map(|p| (*p).into()).collect();
    Curve2::Nurbs(NurbsCurve::new(s.degree, net, s.knots()).unwrap())
}

fn curves(loops: &[Vec<Spline>]) -> Vec<Vec<Curve2>> {
    let one = |l: &Vec<Spline>| l.iter().map(curve).collect();
    loops.iter().map(one).collect()
}

proptest! {
    #![proptest_config(cases(48))]

    /// Up to 4 steps of f64 from trims with cusps and tangents, from slivers and joints, and at the height of joints.
    #[test]
    fn sides_are_the_oracles(loops in loops(), aims in prop::collection::vec(aim(), 8)) {
        let b = brep(plane(64.0), Some(curves(&loops)));
        let oracle = Oracle::new(&[&b]).unwrap();
        let region = TrimRegion::new(&b, 0);
        for a in &aims {
            let uv = a.at(&loops);
            let truth = oracle.side(0, uv).unwrap();
            let found = region.side(Point2::from(uv));
            prop_assert_eq!((found.side, found.in_gap), (Some(truth.side), truth.in_gap), "{:?}", uv);
        }
    }
}

/// Half the side of the square that sheets are drawn over, in uv; in space it is a quarter of that.
const HALF: f64 = 16.0;

/// What probes are asked about.
#[derive(Clone, Debug)]
enum Shape {
    /// A graph over the square, or a heap of control points; within these loops, if there are any.
    Sheet {
        degrees: [usize; 2],
        graph: bool,
        points: Vec<([i8; 3], f64)>,
        loops: Vec<Vec<Spline>>,
    },
    /// With these corners, in eighths: closed.
    Tetrahedron([[i8; 3]; 4]),
}

fn eighths(p: [i8; 3]) -> [f64; 3] {
    p.map(|x| f64::from(x) / 8.0)
}

impl Shape {
    fn loops(&self) -> &[Vec<Spline>] {
        match self {
            Self::Sheet { loops, .. } => loops,
            Self::Tetrahedron(_) => &[],
        }
    }

    /// None of a tetrahedron that is flat.
    fn brep(&self) -> Option<Brep> {
        match self {
            Self::Sheet {
                degrees: [p, q],
                graph,
                points,
                loops,
            } => {
                let net = points.iter().enumerate().map(|(k, (at, w))| {
                    let [x, y, z] = eighths(*at);
                    let along = |i: usize, p: usize| 8.0 * (i as f64 / p as f64) - 4.0;
                    let [x, y] = match graph {
                        true => [along(k / (q + 1), *p), along(k % (q + 1), *q)],
                        false => [x, y],
                    };
                    Vector4::new(x * w, y * w, z * w, *w)
                });
                let knots = |p: usize| [vec![-HALF; p + 1], vec![HALF; p + 1]].concat();
                let made = NurbsSurface::new(
                    [*p, *q],
                    [p + 1, q + 1],
                    net.collect(),
                    [knots(*p), knots(*q)],
                );
                let loops = (!loops.is_empty()).then(|| curves(loops));
                Some(brep(Surface::Nurbs(made.unwrap()), loops))
            }
            Self::Tetrahedron(corners) => {
                let c = corners.map(|c| Point3::from(eighths(c)));
                if (c[1] - c[0]).cross(&(c[2] - c[0])).dot(&(c[3] - c[0])) == 0.0 {
                    return None;
                }
                let mut b = BrepBuilder::new();
                let v = c.map(|c| b.vertex(c));
                for face in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
                    b.planar_face(&face.map(|i: usize| v[i])).unwrap();
                }
                let brep = b.build().unwrap();
                assert!(brep.is_closed());
                Some(brep)
            }
        }
    }
}

fn shape() -> impl Strategy<Value = Shape> {
    let corner = || prop::array::uniform3(-32i8..=32);
    let trims = prop_oneof![1 => Just(Vec::new()), 3 => one_loop().prop_map(|l| vec![l])];
    let sheet = (1usize..=2, 1usize..=2, any::<bool>(), any::<bool>(), trims).prop_flat_map(
        move |(p, q, graph, rational, loops)| {
            let weight = prop::sample::select(vec![1.0, 0.5, 2.0]);
            let point =
                (corner(), weight).prop_map(move |(at, w)| (at, if rational { w } else { 1.0 }));
            let count = (p + 1) * (q + 1);
            prop::collection::vec(point, count).prop_map(move |points| Shape::Sheet {
                degrees: [p, q],
                graph,
                points,
                loops: loops.clone(),
            })
        },
    );
    prop_oneof![
        1 => prop::array::uniform4(corner()).prop_map(Shape::Tetrahedron),
        3 => sheet,
    ]
}

/// A probe, of whatever shape there is.
#[derive(Clone, Debug)]
enum Drawn {
    /// Over a point of a face next to a trim, or over any.
    Above {
        aim: Aim,
        off: f64,
        steps: [i8; 3],
        radius: f64,
    },
    Anywhere {
        center: [i8; 3],
        radius: f64,
    },
    Below {
        normal: [f64; 3],
        offset: f64,
    },
}

fn drawn() -> impl Strategy<Value = Drawn> {
    let radius = || prop::sample::select(vec![0.0, 0.25, 1.0]);
    let off = prop::sample::select(vec![0.0, 1e-9, 0.125, -0.5, 2.0]);
    let steps = prop::array::uniform3(-4i8..=4);
    let normals = [
        [0.0, 0.0, 1.0],
        [0.6, -0.8, 0.0],
        [0.48, 0.6, 0.64],
        [-0.28, 0.0, -0.96],
    ];
    prop_oneof![
        (aim(), off, steps, radius()).prop_map(|(aim, off, steps, radius)| Drawn::Above {
            aim,
            off,
            steps,
            radius
        }),
        (prop::array::uniform3(-48i8..=48), radius())
            .prop_map(|(center, radius)| Drawn::Anywhere { center, radius }),
        (prop::sample::select(normals.to_vec()), -8i8..=8).prop_map(|(normal, offset)| {
            Drawn::Below {
                normal,
                offset: f64::from(offset) / 4.0,
            }
        }),
    ]
}

impl Drawn {
    fn probe(&self, shape: &Shape, brep: &Brep) -> Probe {
        let ball = |center, radius| Probe::Sphere(Sphere::new(center, radius).unwrap());
        match self {
            Self::Above {
                aim,
                off,
                steps,
                radius,
            } => {
                let none = [vec![Spline::straight([-HALF, -HALF], [HALF, HALF])]];
                let loops = if shape.loops().is_empty() {
                    &none
                } else {
                    shape.loops()
                };
                let surface = brep.surface(0);
                let domain = surface.domain();
                let at = aim.at(loops);
                let uv = [0, 1].map(|i| at[i].clamp(domain[i].start, domain[i].end));
                let all = surface.derivatives(uv[0], uv[1], 1);
                let normal = all.get(1, 0).cross(&all.get(0, 1));
                let normal = normal.try_normalize(0.0).unwrap_or(Vector3::z());
                let center = all.get(0, 0) + normal * *off;
                ball(
                    Point3::from([0, 1, 2].map(|i| stepped(center[i], steps[i]))),
                    *radius,
                )
            }
            Self::Anywhere { center, radius } => ball(Point3::from(eighths(*center)), *radius),
            Self::Below { normal, offset } => {
                Probe::HalfSpace(HalfSpace::new(Vector3::from(*normal), *offset).unwrap())
            }
        }
    }
}

/// A truth is narrower than this part of the size, or is none: far below the floor of full accuracy.
const NARROW: f64 = 1.0 / (1u128 << 100) as f64;

fn corpus(e: &feeler_oracle::TruthEnclosure) -> TruthEnclosure {
    TruthEnclosure {
        lo: e.lo.clone(),
        hi: e.hi.clone(),
    }
}

/// The separation, if the oracle settles it.
fn separation(oracle: &Oracle, probe: &Probe, size: f64) -> Option<feeler_oracle::TruthEnclosure> {
    let found = match probe {
        Probe::Sphere(s) => oracle.sphere(s.center.coords.into(), s.radius, None),
        Probe::HalfSpace(h) => oracle.half_space(h.normal.into(), h.offset, None),
    };
    let found = found.unwrap()?;
    let is_narrow = found.enclosure.width().approximate() <= NARROW * size;
    (found.status != DistanceStatus::Budget && is_narrow).then_some(found.enclosure)
}

/// What a list must have: all contacts within the prediction that the oracle proves, if it settles them.
fn listed(
    oracle: &Oracle,
    probe: &Probe,
    prediction: f64,
    size: f64,
) -> Option<Vec<feeler_oracle::ContactTruth>> {
    let found = oracle
        .contacts(probe, prediction)
        .ok()
        .filter(|c| c.whole)?;
    let due = found.contacts.into_iter().filter(|c| c.proven && c.within);
    let all: Vec<_> = due.collect();
    let narrow = |c: &feeler_oracle::ContactTruth| {
        c.continuum || c.separation.width().approximate() <= NARROW * size
    };
    all.iter().all(narrow).then_some(all)
}

/// Contacts nearer to each other than this part of the size are not told apart.
const ONE_CONTACT: f64 = 1.0 / (1u64 << 24) as f64;

/// Whether a contact is that one, by its place and its separation. (What else is told need not be false: the oracle takes what falls but for a rise of less than
/// its `join` for one way down, and the definition does not.)
fn is_it(found: &Contact, truth: &feeler_oracle::ContactTruth, size: f64) -> bool {
    let near = ONE_CONTACT * size;
    let at = |k: usize| {
        let [lo, hi] = truth.at[k];
        lo - near <= found.on_brep[k] && found.on_brep[k] <= hi + near
    };
    let b = found.separation.bounds;
    let meets = dyadic(b.lo) <= truth.separation.hi && truth.separation.lo <= dyadic(b.hi);
    (0..3).all(at) && (truth.continuum || meets)
}

/// The foot stands at the separation that is told, up to the bound on its place: exactly.
fn stands_off(probe: &Probe, c: &Contact) -> bool {
    let Some(reach) = c.position_bound.map(dyadic) else {
        return true;
    };
    let (lo, hi) = (
        dyadic(c.separation.bounds.lo),
        dyadic(c.separation.bounds.hi),
    );
    let foot: [Dyadic; 3] = [0, 1, 2].map(|i| dyadic(c.on_brep[i]));
    match probe {
        Probe::HalfSpace(h) => {
            let height = (0..3).fold(-&dyadic(h.offset), |sum, i| {
                &sum + &(&dyadic(h.normal[i]) * &foot[i])
            });
            // |n| <= 1 + 2^-50.
            let reach = &reach * &dyadic(1.0 + 4.0 * f64::EPSILON);
            &lo - &reach <= height && height <= &hi + &reach
        }
        Probe::Sphere(s) => {
            let square = (0..3).fold(Dyadic::ZERO, |sum, i| {
                &sum + &sq(&(&foot[i] - &dyadic(s.center[i])))
            });
            // In material the separation is below -r: the distance is its negative.
            let (lo, hi) = (&lo + &dyadic(s.radius), &hi + &dyadic(s.radius));
            let larger = |a: Dyadic, b: Dyadic| if a < b { b } else { a };
            let far = &larger(hi.clone(), -&lo) + &reach;
            let near = &larger(lo, -&hi) - &reach;
            square <= sq(&far) && (near.signum() <= 0 || sq(&near) <= square)
        }
    }
}

/// In uv: parameters of feet are rounded, so that one on a trim may be off it.
const OFF_TRIM: f64 = 1.0 / (1u64 << 20) as f64;

/// The face has a point of its region there, exactly, or next to it; and its surface is where the foot is said to be, up to the bound.
fn is_on_the_face(oracle: &Oracle, c: &Contact) -> Result<(), String> {
    let Some(reach) = c.position_bound else {
        return Ok(());
    };
    let uv: [f64; 2] = c.uv.coords.into();
    let about = [
        [0.0, 0.0],
        [1.0, 0.0],
        [-1.0, 0.0],
        [0.0, 1.0],
        [0.0, -1.0],
        [1.0, 1.0],
        [-1.0, -1.0],
        [1.0, -1.0],
        [-1.0, 1.0],
    ];
    let in_region = |off: f64| {
        about.iter().any(|d| {
            let at = [0, 1].map(|i| uv[i] + off * d[i]);
            oracle.side(c.face, at).unwrap().side != Side::Outside
        })
    };
    let offs = (0..30).map(|k| OFF_TRIM * (-f64::from(k)).exp2());
    // On a trim it stands at a cusp or in a sliver, between all points that are tried; the deepest is held against the oracle's.
    let is_inside = matches!(c.feature, Feature::Face(_));
    if is_inside && !in_region(0.0) && !offs.into_iter().any(in_region) {
        return Err(format!(
            "the foot's parameters {uv:?} are not in the region"
        ));
    }
    let point = oracle
        .evaluate(c.face, uv)
        .map_err(|e| e.to_string())?
        .point;
    let off: Vector3<f64> =
        Vector3::from([0, 1, 2].map(|i| (&point[i].lo - &dyadic(c.on_brep[i])).approximate()));
    let most = reach + 1e-9;
    if off.norm() <= most {
        Ok(())
    } else {
        Err(format!(
            "the foot is {:e} from its parameters' point, the bound is {reach:e}",
            off.norm()
        ))
    }
}

/// How far lists of contacts reach.
const PREDICTION: f64 = 0.5;

fn asked(prepared: &PreparedBrep, probe: &Probe, contacts: Contacts) -> ContactAnswer {
    let options = Options {
        contacts,
        prediction: PREDICTION,
        ..Options::default()
    };
    contact(prepared, probe, &options, &mut Workspace::default())
}

#[derive(Default)]
struct Told {
    asked: Cell<u32>,
    known: Cell<u32>,
    listed: Cell<u32>,
    undecided: Cell<u32>,
    feet: Cell<u32>,
}

fn more(count: &Cell<u32>) {
    count.set(count.get() + 1);
}

fn held(shape: &Shape, drawn: &Drawn, told: &Told) -> Result<(), TestCaseError> {
    let Some(brep) = shape.brep() else {
        return Ok(());
    };
    let probe = drawn.probe(shape, &brep);
    let prepared = PreparedBrep::new(brep.clone());
    let size = prepared.size();
    let oracle = Oracle::new(&[&brep]).unwrap();
    more(&told.asked);
    let Some(truth) = separation(&oracle, &probe, size) else {
        return Ok(());
    };
    more(&told.known);
    let asked_for = Asked {
        accuracy: Accuracy::Full,
        size,
        prediction: PREDICTION,
        contacts: true,
        hits: Hits::All,
        scale: 1.0,
        tolerance: 0.0,
        probe: Some(probe),
    };
    let separation = corpus(&truth);
    let deepest = match oracle.foot(&probe, &truth).unwrap() {
        Some(foot) => Truth::Contact {
            separation,
            foot: Some(foot),
            contacts: None,
        },
        None => Truth::Separation(separation),
    };
    for contacts in [Contacts::Deepest, Contacts::All] {
        let found = asked(&prepared, &probe, contacts);
        let body: Body = (&found).into();
        let judged = judge(&asked_for, &body, &deepest);
        let is_sound = matches!(judged.verdict, Verdict::Right | Verdict::Undecided);
        prop_assert!(
            is_sound,
            "{:?}: {:?}\n{:?}\n{:?}",
            contacts,
            judged,
            found,
            deepest
        );
        if judged.verdict == Verdict::Undecided {
            more(&told.undecided);
        }
        for c in &found.contacts {
            more(&told.feet);
            prop_assert!(stands_off(&probe, c), "{:?}", c);
            let on = is_on_the_face(&oracle, c);
            prop_assert!(on.is_ok(), "{:?} {:?}", on, c);
        }
        if contacts == Contacts::All
            && let Some(all) = listed(&oracle, &probe, PREDICTION, size)
        {
            more(&told.listed);
            for c in all {
                let told =
                    found.undecided.is_some() || found.contacts.iter().any(|f| is_it(f, &c, size));
                prop_assert!(told, "missed: {:?}\n{:?}", c, found);
            }
        }
    }
    Ok(())
}

/// The separation's enclosure holds the truth, the foot is on the face within its trims and as far away as is told, and no contact is missed.
#[test]
fn contacts_are_the_oracles() {
    let told = Told::default();
    let mut config = cases(20);
    // The same ones each time, as some in thousands take the oracle minutes.
    if std::env::var_os("PROPTEST_CASES").is_none() {
        config.rng_seed = RngSeed::Fixed(1);
    }
    let mut runner = TestRunner::new(config);

    let run = runner.run(&(shape(), drawn()), |(shape, drawn)| {
        held(&shape, &drawn, &told)
    });
    let [asked, known, listed, undecided, feet] = [
        &told.asked,
        &told.known,
        &told.listed,
        &told.undecided,
        &told.feet,
    ]
    .map(Cell::get);
    println!(
        "{asked} asked, {known} with a truth, {listed} with a list; {undecided} answers undecided; {feet} feet"
    );
    run.unwrap_or_else(|e| panic!("{e}"));
    // Most count.
    assert!(2 * known > asked && undecided < asked && 2 * feet > asked);
}
