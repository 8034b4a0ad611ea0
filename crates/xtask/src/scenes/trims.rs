//! The suite `trim-loops`: one face, loops of all sorts, sides asked where they are hard to tell.

use super::loops::{LoopScene, Loops, scaled, scenes};
use super::shapes::{bilinear, face_of, unit_plane};
use super::{Scene, Suite};
use crate::random::Random;
use feeler::numeric::Interval;
use feeler::nurbs::{Curve2, Surface};
use feeler_corpus::{FacePoint, QueryLine, SphereLine};

const DESCRIPTION: &str = "sides in uv of one face whose loops have 4 to 200,000 arcs: combs, islands to depth 6, touching, overlapping, \
     cusped and self-crossing loops, mixtures with gaps, uv ranges of 1e-6 by 1e6; half of the points 0 to 4 ulp from a loop, \
     a quarter at the height of a joint";

pub(crate) fn suite() -> Result<Suite, String> {
    let mut all = Vec::new();
    for scene in scenes() {
        let Some(made) = one(&scene, [1.0, 1.0], unit_plane([0.0, 0.0], [1.0, 1.0]))? else {
            return Err(format!("{}: loops that cannot be", scene.name));
        };
        all.push(made);
        // Long and narrow: u in 1e-6, v in 1e6, both by powers of two.
        let narrow = [
            "polygon_64",
            "comb_128",
            "cubics_64",
            "rational_cubics_8",
            "cusp",
            "self_crossing",
        ];
        if narrow.contains(&&*scene.name) {
            let s = [1.0 / f64::from(1 << 20), f64::from(1 << 20)];
            let plane = unit_plane([0.0, 0.0], s);
            let loops = scene.loops.as_ref().and_then(|l| scaled(l, s));
            let scene = LoopScene {
                name: format!("{}_anisotropic", scene.name),
                loops,
                queries: scene.queries,
            };
            all.extend(one(&scene, s, plane)?);
        }
        // On a warped face, with balls near the border besides.
        let warped = [
            "polygon_16",
            "cubics_8",
            "rational_cubics_8",
            "mixture",
            "islands_rational",
            "touching_vertices",
        ];
        if warped.contains(&&*scene.name) {
            let scene = LoopScene {
                name: format!("{}_warped", scene.name),
                loops: scene.loops.clone(),
                queries: 60,
            };
            if let Some(mut made) = one(&scene, [1.0, 1.0], bilinear()?)? {
                let mut random = Random::new(&scene.name);
                let surface = bilinear()?;
                for _ in 0..60 {
                    let Some(uv) = scene
                        .loops
                        .as_ref()
                        .map(|l| near(l, [1.0, 1.0], &mut random))
                    else {
                        break;
                    };
                    let at = surface.point(uv[0], uv[1]);
                    let off = random.direction() * [1e-9, 1e-3, 0.05, 0.3][random.below(4)];
                    made.queries.push(QueryLine {
                        sphere: Some(SphereLine {
                            center: (at + off).coords.into(),
                            radius: [0.0, 0.01, 0.1][random.below(3)],
                        }),
                        ..QueryLine::default()
                    });
                }
                all.push(made);
            }
        }
    }
    Ok(Suite {
        name: "trim-loops",
        description: DESCRIPTION,
        scenes: all,
    })
}

fn one(scene: &LoopScene, size: [f64; 2], surface: Surface) -> Result<Option<Scene>, String> {
    if scene.loops.is_none() && scene.name != "whole_domain" {
        return Ok(None);
    }
    let mut random = Random::new(&scene.name);
    let brep = face_of(surface, scene.loops.as_ref())?;
    let queries = (0..scene.queries).map(|i| {
        let uv = match (&scene.loops, i % 4) {
            (Some(l), 1 | 2) if !l.is_empty() => near(l, size, &mut random),
            (Some(l), 3) if !l.is_empty() => at_joint(l, size, &mut random),
            _ => anywhere(size, &mut random),
        };
        QueryLine {
            side: Some(FacePoint { face: 0, uv }),
            ..QueryLine::default()
        }
    });
    Ok(Some(Scene {
        name: scene.name.clone(),
        queries: queries.collect(),
        breps: vec![brep],
    }))
}

/// In the square or a little beyond; one in eight on its border.
fn anywhere(size: [f64; 2], random: &mut Random) -> [f64; 2] {
    let mut uv = [0, 1].map(|k| random.between(-0.02, 1.02) * size[k]);
    if random.below(8) == 0 {
        let k = random.below(2);
        uv[k] = [0.0, size[k]][random.below(2)];
    }
    uv
}

fn any_curve<'a>(loops: &'a Loops, random: &mut Random) -> &'a Curve2 {
    let l = &loops[random.below(loops.len())];
    &l[random.below(l.len())]
}

/// 0 to 4 ulp from a loop, or 1e-6 to 1e-15.
pub(crate) fn near(loops: &Loops, size: [f64; 2], random: &mut Random) -> [f64; 2] {
    let curve = any_curve(loops, random);
    let Interval { start, end } = curve.domain();
    // One in six at a break: where pieces meet.
    let t = if random.below(6) == 0 {
        let breaks = curve.breaks();
        breaks[random.below(breaks.len())]
    } else {
        random.between(start, end)
    };
    let p = curve.point(t);
    let mut uv = [p.x, p.y];
    let k = random.below(2);
    if random.below(3) > 0 {
        for _ in 0..random.below(5) {
            uv[k] = if random.sign() > 0.0 {
                uv[k].next_up()
            } else {
                uv[k].next_down()
            };
        }
    } else {
        uv[k] += random.sign() * crate::generate::NEAR[random.below(10)] * size[k];
    }
    uv
}

/// At the exact u or v of a joint, elsewhere in the other; or at the joint itself.
pub(crate) fn at_joint(loops: &Loops, size: [f64; 2], random: &mut Random) -> [f64; 2] {
    let curve = any_curve(loops, random);
    let breaks = curve.breaks();
    let p = curve.point(breaks[random.below(breaks.len())]);
    let mut uv = [p.x, p.y];
    match random.below(8) {
        0 => {}
        1..=2 => uv[1] = random.between(-0.01, 1.01) * size[1],
        _ => uv[0] = random.between(-0.01, 1.01) * size[0],
    }
    // At the joint's height, or one or two ulp from it.
    let k = random.below(2);
    for _ in 0..random.below(3) {
        uv[k] = uv[k].next_up();
    }
    uv
}
