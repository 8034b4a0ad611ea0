//! Lines in the plane of a face whose outline has steps: where they lie in it, against counting.

use feeler::brep::BrepBuilder;
use feeler::prepare::PreparedBrep;
use feeler::query::{LineAnswer, LineKind, LineProbe, Options, Workspace, line};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

fn ask(brep: &PreparedBrep, origin: [f64; 3], direction: [f64; 3]) -> LineAnswer {
    let (origin, direction) = (Point3::from(origin), Vector3::from(direction));
    let probe = LineProbe::new(origin, direction, LineKind::Line).unwrap();
    line(brep, &probe, &Options::default(), &mut Workspace::default())
}

/// Columns of these heights beside each other, each 1 wide, from x = 0 and y = 0 on; or with x and y swapped. Their outline is one face.
fn columns(heights: &[i32], swap: bool) -> PreparedBrep {
    let mut outline = vec![[0, 0], [heights.len() as i32, 0]];
    for (i, h) in heights.iter().enumerate().rev() {
        let (left, right) = (i as i32, i as i32 + 1);
        // Where the next column is as high, the side goes on.
        if heights.get(i + 1) != Some(h) {
            outline.push([right, *h]);
        }
        if i == 0 || heights[i - 1] != *h {
            outline.push([left, *h]);
        }
    }
    let mut b = BrepBuilder::new();
    let corners: Vec<usize> = { outline.iter().map(|p| p.map(f64::from)) }
        .map(|[x, y]| b.vertex(if swap { [y, x, 0.0] } else { [x, y, 0.0] }))
        .collect();
    b.planar_face(&corners).unwrap();
    PreparedBrep::new(b.build().unwrap())
}

/// From where to where the columns are at least so high.
fn runs(heights: &[i32], level: i32) -> Vec<[f64; 2]> {
    let mut found: Vec<[f64; 2]> = Vec::new();
    for (i, _) in heights.iter().enumerate().filter(|(_, h)| **h >= level) {
        let (from, to) = (i as f64, i as f64 + 1.0);
        match found.last_mut() {
            Some(last) if last[1] == from => last[1] = to,
            _ => found.push([from, to]),
        }
    }
    found
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// A level line lies in the face where columns are as high, in runs that may begin and end at corners, along sides, and within.
    #[test]
    fn a_level_line_lies_in_the_columns_that_are_as_high(
        heights in prop::collection::vec(1..5i32, 1..9),
        (swap, back) in (any::<bool>(), any::<bool>()),
    ) {
        let brep = columns(&heights, swap);
        for level in 0..=5 {
            let begin = if back { 16.0 } else { -1.0 };
            let step = if back { -1.0 } else { 1.0 };
            let both = |x: f64, y: f64| if swap { [y, x, 0.0] } else { [x, y, 0.0] };
            let answer = ask(&brep, both(begin, f64::from(level)), both(step, 0.0));
            prop_assert_eq!(answer.undecided, None);
            let mut expected = runs(&heights, level);
            if back {
                expected.reverse();
            }
            let t = |x: f64| (x - begin) * step;
            let expected: Vec<_> = { expected.iter() }
                .map(|[a, z]| if back { [t(*z), t(*a)] } else { [t(*a), t(*z)] })
                .map(|[a, z]| (a, Some(z)))
                .collect();
            let found: Vec<_> = { answer.hits.iter() }
                .map(|h| (h.t.value, h.t_end.map(|t| t.value)))
                .collect();
            prop_assert_eq!(found, expected, "{:?} at {}", heights, level);
        }
    }
}
