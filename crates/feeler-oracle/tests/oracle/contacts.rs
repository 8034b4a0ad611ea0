//! All contacts within a prediction, against what geometry says.

use crate::scene;
use crate::scene::contacts::{must_be, near, one_continuum};
use crate::scene::{bezier, interval, line, patch};
use feeler::brep::{Brep, BrepBuilder, TrimSpec};
use feeler::nurbs::Surface;
use feeler::query::{HalfSpace, Probe, Sphere};
use feeler_oracle::{ContactsTruth, Oracle};
use nalgebra::{Point3, Vector3};

fn ball(center: [f64; 3], radius: f64) -> Probe {
    Probe::Sphere(Sphere::new(Point3::from(center), radius).unwrap())
}

fn half_space(normal: [f64; 3], offset: f64) -> Probe {
    Probe::HalfSpace(HalfSpace::new(Vector3::from(normal), offset).unwrap())
}

fn contacts(breps: &[&Brep], probe: &Probe, prediction: f64) -> ContactsTruth {
    Oracle::new(breps)
        .unwrap()
        .contacts(probe, prediction)
        .unwrap()
}

/// The box [0, 1]^3.
fn cube() -> Brep {
    let mut b = BrepBuilder::new();
    let corner = |i: usize| [(i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64];
    let v: Vec<usize> = (0..8).map(|i| b.vertex(corner(i))).collect();
    for face in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ] {
        b.planar_face(&face.map(|i| v[i])).unwrap();
    }
    let brep = b.build().unwrap();
    assert!(brep.is_closed());
    brep
}

/// Planar faces that touch nothing, each by its corners.
fn sheets(faces: &[[[f64; 3]; 4]]) -> Brep {
    let mut b = BrepBuilder::new();
    for corners in faces {
        let v: Vec<usize> = corners.iter().map(|c| b.vertex(*c)).collect();
        b.planar_face(&v).unwrap();
    }
    b.build().unwrap()
}

#[test]
fn a_ball_at_the_corner_of_a_box() {
    let cube = cube();
    let oracle = Oracle::new(&[&cube]).unwrap();
    let ask = |c, r, p| oracle.contacts(&ball(c, r), p).unwrap();
    // Outside, before a corner: the vertex alone, however far the prediction reaches.
    let d = (0.01f64 + 0.04 + 0.09).sqrt();
    must_be(&ask([1.1, 1.2, 1.3], 0.0, 5.0), &[([1.0; 3], d)]);
    // Before an edge.
    let found = ask([1.3, 1.4, 0.25], 0.0, 5.0);
    must_be(&found, &[([1.0, 1.0, 0.25], 0.5)]);
    // Before a face: its foot, and that of the face behind.
    let found = ask([1.5, 0.5, 0.25], 0.25, 5.0);
    must_be(
        &found,
        &[([1.0, 0.5, 0.25], 0.25), ([0.0, 0.5, 0.25], 1.25)],
    );
    // Nothing within the prediction.
    must_be(&ask([1.5, 0.5, 0.25], 0.25, 0.125), &[]);
    // In the box: as many feet as faces are in reach; the nearest in any case.
    let c = [0.875, 0.75, 0.5];
    must_be(&ask(c, 0.0625, 0.0), &[([1.0, 0.75, 0.5], -0.1875)]);
    let three = [([1.0, 0.75, 0.5], -0.4375), ([0.875, 1.0, 0.5], -0.5625)];
    must_be(&ask(c, 0.3125, 0.0), &three);
    assert_eq!(ask(c, 1.0, 0.0).contacts.len(), 6);
    // On a face, and on a vertex.
    must_be(&ask([1.0, 0.5, 0.5], 0.0, 0.125), &[([1.0, 0.5, 0.5], 0.0)]);
    must_be(&ask([1.0; 3], 0.0, 0.125), &[([1.0; 3], 0.0)]);
}

#[test]
fn half_spaces_against_a_box() {
    let cube = cube();
    let oracle = Oracle::new(&[&cube]).unwrap();
    let ask = |n, p| oracle.contacts(&half_space(n, 0.0), p).unwrap();
    must_be(&ask([0.6, 0.48, 0.64], 9.0), &[([0.0; 3], 0.0)]);
    let x = -(0.36f64 - 0.2304);
    let found = ask([-0.6, 0.48, 0.64], 9.0);
    assert_eq!(found.contacts.len(), 1, "{x}");
    assert!(near(&found.contacts[0].at, [1.0, 0.0, 0.0], 1e-15));
    // Parallel to a face, and to an edge: all of it, once.
    for (n, size) in [
        ([1.0, 0.0, 0.0], [0.0, 1.0, 1.0]),
        ([0.6, 0.8, 0.0], [0.0, 0.0, 1.0]),
    ] {
        let found = ask(n, 9.0);
        let c = one_continuum(&found);
        for k in 0..3 {
            assert!(
                (c.at[k][0]).abs() < 1e-12 && (c.at[k][1] - size[k]).abs() < 1e-12,
                "{c:?}"
            );
        }
    }
}

#[test]
fn plates_and_a_slot() {
    let (l, h) = (4.0, 3.0);
    let floor = [[-l, -l, 0.0], [l, -l, 0.0], [l, l, 0.0], [-l, l, 0.0]];
    let lid = [[-l, -l, 1.0], [l, -l, 1.0], [l, l, 1.0], [-l, l, 1.0]];
    let plates = sheets(&[floor, lid]);
    let found = contacts(&[&plates], &ball([0.5, 0.25, 0.25], 0.125), 2.0);
    must_be(
        &found,
        &[([0.5, 0.25, 0.0], 0.125), ([0.5, 0.25, 1.0], 0.625)],
    );
    // Midway: equally near.
    let found = contacts(&[&plates], &ball([0.5, 0.25, 0.5], 0.5), 0.0);
    must_be(&found, &[([0.5, 0.25, 0.0], 0.0), ([0.5, 0.25, 1.0], 0.0)]);
    // A slot: floor and two walls that stand apart from it.
    let left = [[-1.0, -l, 0.5], [-1.0, l, 0.5], [-1.0, l, h], [-1.0, -l, h]];
    let right = [[1.0, -l, 0.5], [1.0, l, 0.5], [1.0, l, h], [1.0, -l, h]];
    let slot = sheets(&[floor, left, right]);
    let found = contacts(&[&slot], &ball([0.25, 0.5, 0.75], 0.75), 0.75);
    must_be(
        &found,
        &[
            ([0.25, 0.5, 0.0], 0.0),
            ([1.0, 0.5, 0.75], 0.0),
            ([-1.0, 0.5, 0.75], 0.5),
        ],
    );
}

/// z = x^2 - y^2 over [-1, 1]^2.
fn saddle() -> Brep {
    let square = [1.0, -1.0, 1.0];
    let at = [-1.0, 0.0, 1.0];
    let mut net = Vec::new();
    for i in 0..3 {
        for j in 0..3 {
            net.push([at[i], at[j], square[i] - square[j], 1.0]);
        }
    }
    scene::brep(patch(2, 2, net), None)
}

#[test]
fn a_saddle() {
    let saddle = saddle();
    must_be(
        &contacts(&[&saddle], &ball([0.0, 0.0, 0.25], 0.0), 0.5),
        &[([0.0; 3], 0.25)],
    );
    // Beyond the centre of curvature the foot is a saddle of the distance, with a minimum on each side.
    let x = 0.5f64.sqrt();
    must_be(
        &contacts(&[&saddle], &ball([0.0, 0.0, 1.0], 0.0), 1.25),
        &[
            ([x, 0.0, 0.5], 0.75f64.sqrt()),
            ([-x, 0.0, 0.5], 0.75f64.sqrt()),
        ],
    );
    // At the centre of curvature the minimum is flat to the fourth order: one, or not settled.
    let found = contacts(&[&saddle], &ball([0.0, 0.0, 0.5], 0.0), 0.75);
    assert_eq!(found.contacts.len(), 1, "{found:#?}");
    assert!(near(&found.contacts[0].at, [0.0; 3], 1e-9));
    // Half-spaces: the saddle is none, the minima on the border are.
    let found = contacts(&[&saddle], &half_space([0.0, 0.0, 1.0], 0.0), 5.0);
    must_be(
        &found,
        &[([0.0, 1.0, -1.0], -1.0), ([0.0, -1.0, -1.0], -1.0)],
    );
}

/// A quarter of the exact circle, homogeneous: (x, y, w) of three points; turned by `turns` quarters.
fn quarter(turns: usize) -> [[f64; 3]; 3] {
    let turn = |[x, y, w]: [f64; 3]| match turns % 4 {
        0 => [x, y, w],
        1 => [-y, x, w],
        2 => [-x, -y, w],
        _ => [y, -x, w],
    };
    [[1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 2.0, 2.0]].map(turn)
}

/// The torus of radii 3 and 1 about z in 16 patches that meet exactly.
fn torus() -> Brep {
    let mut b = BrepBuilder::new();
    for a in 0..4 {
        for c in 0..4 {
            let mut net = Vec::new();
            for [x, y, w] in quarter(a) {
                for [s, t, v] in quarter(c) {
                    let r = 3.0 * v + s;
                    net.push([x * r, y * r, w * t, w * v]);
                }
            }
            b.whole_surface(patch(2, 2, net));
        }
    }
    b.build().unwrap()
}

#[test]
fn a_torus() {
    let torus = torus();
    let oracle = Oracle::new(&[&torus]).unwrap();
    let ask = |c, p| oracle.contacts(&ball(c, 0.0), p).unwrap();
    // Off every seam, in the plane of the ring.
    let found = ask([6.0, 8.0, 0.0], 20.0);
    must_be(&found, &[([2.4, 3.2, 0.0], 6.0)]);
    // On the seams of four patches.
    must_be(&ask([5.0, 0.0, 0.0], 20.0), &[([4.0, 0.0, 0.0], 1.0)]);
    must_be(&ask([0.5, 0.0, 0.0], 20.0), &[([2.0, 0.0, 0.0], 1.5)]);
    // Next to a seam: one, on one side of it.
    for off in [1e-5, 1e-8, 1e-11, 1e-14, -1e-5, -1e-8, -1e-11] {
        let found = ask([5.0, off, 0.3], 1.5);
        assert_eq!(found.contacts.len(), 1, "{off}: {found:#?}");
        assert!(found.contacts[0].proven);
    }
    // On the axis: a circle.
    one_continuum(&ask([0.0, 0.0, 0.5], 20.0));
    // A half-space in a general direction has one support; parallel to the ring, a circle.
    let found = oracle
        .contacts(&half_space([0.6, 0.48, 0.64], 0.0), 20.0)
        .unwrap();
    assert_eq!(found.contacts.len(), 1, "{found:#?}");
    let found = oracle
        .contacts(&half_space([0.0, 0.0, 1.0], 0.0), 20.0)
        .unwrap();
    one_continuum(&found);
}

#[test]
fn a_domain_is_an_interval() {
    // Guards the helper: the whole surface of a patch runs over the unit square.
    let Surface::Nurbs(s) = &saddle().parts().surfaces[0].clone() else {
        panic!("no NURBS");
    };
    assert_eq!(s.knots_u().domain(), interval(0.0, 1.0));
}

/// The polynomial with these zeros, times `scale`, by its Bernstein coefficients.
fn with_zeros(zeros: &[f64], scale: f64) -> Vec<f64> {
    let mut b = vec![scale];
    for zero in zeros {
        let n = b.len();
        // Times (1 - t) (-zero) + t (1 - zero).
        b = (0..=n)
            .map(|i| {
                let at = |k: usize| b.get(k).copied().unwrap_or(0.0);
                let share = i as f64 / n as f64;
                let below = if i > 0 { at(i - 1) } else { 0.0 };
                (1.0 - share) * -zero * at(i) + share * (1.0 - zero) * below
            })
            .collect();
    }
    b
}

/// A roof whose eaves are the lower edge of a wall: the wall's trim wavers about the roof's, and meets it at the
/// parameters where cracks once were sampled. Where it hangs below the eaves the distance has a minimum over the wall; but
/// from within the crack's width the roof falls on.
#[test]
fn a_crack_between_samples_joins() {
    let samples = [0.0, 0.03, 0.25, 0.5, 0.77, 1.0];
    let scale = -1.0 / 32.0;
    let wave = with_zeros(&samples, scale);
    let height = |t: f64| scale * samples.iter().map(|z| t - z).product::<f64>();
    let (hanging, standing) = (height(0.63), height(0.88));
    assert!(hanging < -2e-5 && standing > 5e-5, "{hanging} {standing}");
    let degree = wave.len() - 1;
    let waves: Vec<[f64; 3]> = (0..=degree)
        .map(|i| [i as f64 / degree as f64, wave[i], 1.0])
        .collect();

    let mut b = BrepBuilder::new();
    let low = b.vertex([0.0, 0.0, -0.5]);
    let [near, far] = [0.0, 1.0].map(|y| b.vertex([1.0, y, 0.0]));
    let back = b.vertex([0.0, 1.0, -0.4]);
    let [top_far, top_near] = [1.0, 0.0].map(|y| b.vertex([1.0, y, 1.0]));
    let roof = patch(
        1,
        1,
        vec![
            [0.0, 0.0, -0.5, 1.0],
            [0.0, 1.0, -0.4, 1.0],
            [1.0, 0.0, 0.0, 1.0],
            [1.0, 1.0, 0.0, 1.0],
        ],
    );
    // u is y, and v from 0 to 1 is z from -1 to 1.
    let wall = patch(
        1,
        1,
        vec![
            [1.0, 0.0, -1.0, 1.0],
            [1.0, 0.0, 1.0, 1.0],
            [1.0, 1.0, -1.0, 1.0],
            [1.0, 1.0, 1.0, 1.0],
        ],
    );
    let mut side = |vertices: [usize; 2], curve| {
        let edge = Some(b.straight_edge(vertices).unwrap());
        TrimSpec {
            vertices,
            curve,
            edge,
        }
    };
    let of_roof = vec![
        side([low, near], line([0.0, 0.0], [1.0, 0.0])),
        side([near, far], line([1.0, 0.0], [1.0, 1.0])),
        side([far, back], line([1.0, 1.0], [0.0, 1.0])),
        side([back, low], line([0.0, 1.0], [0.0, 0.0])),
    ];
    let eaves: Vec<[f64; 3]> = waves
        .iter()
        .map(|p| [p[0], 0.5 + 0.5 * p[1], 1.0])
        .collect();
    let of_wall = vec![
        side([near, far], bezier(&eaves)),
        side([far, top_far], line([1.0, 0.5], [1.0, 1.0])),
        side([top_far, top_near], line([1.0, 1.0], [0.0, 1.0])),
        side([top_near, near], line([0.0, 1.0], [0.0, 0.5])),
    ];
    b.face_with_trims(roof, vec![of_roof]).unwrap();
    b.face_with_trims(wall, vec![of_wall]).unwrap();
    let brep = b.build().unwrap();

    let mut found = contacts(&[&brep], &half_space([0.0, 0.0, 1.0], 0.0), 0.25);
    // The eaves may stay unsettled, as one; no contact is claimed of them.
    found.contacts.retain(|c| c.proven);
    must_be(&found, &[([0.0, 0.0, -0.5], -0.5)]);
    assert!(found.join >= standing, "{} {standing}", found.join);
}
