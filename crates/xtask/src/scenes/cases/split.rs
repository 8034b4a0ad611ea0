//! S: derivative roots of trim curves.
//!
//! A trim that is the graph of a polynomial with chosen roots of its derivative is written by its Bernstein
//! coefficients, which are small integers or exact sums of powers of two wherever the case is about exactness.

use super::super::loops::{TURN, bezier, line as straight, nurbs, polar};
use super::super::shapes::{face_of, unit_plane};
use super::Maker;
use feeler::nurbs::Curve2;
use feeler_corpus::{QueryLine, TrimLine};

type P = [f64; 2];

/// The curve and a way back to its start; the plane is large enough for all.
fn asked(m: &mut Maker, model: &str, id: &str, curve: Option<Curve2>) -> Result<(), String> {
    let curve = curve.ok_or_else(|| format!("{id}: no such curve"))?;
    let span = curve.domain();
    let (a, b) = (curve.point(span.start), curve.point(span.end));
    let mut trims = vec![curve];
    if a != b {
        let below = [0.5 * (a.x + b.x), a.y.min(b.y) - 1.0];
        trims.push(straight(b.into(), below));
        trims.push(straight(below, a.into()));
    }
    let plane = unit_plane([-300.0; 2], [300.0; 2]);
    m.model(model, face_of(plane, Some(&vec![trims]))?);
    let query = QueryLine {
        split: Some(TrimLine {
            face: 0,
            trim_loop: 0,
            trim: 0,
        }),
        ..QueryLine::default()
    };
    m.ask(model, id, query);
    Ok(())
}

/// The graph over [0, 1] of the polynomial with these Bernstein coefficients.
fn graph(coefficients: &[f64]) -> Option<Curve2> {
    let n = coefficients.len() - 1;
    let points: Vec<P> = coefficients
        .iter()
        .enumerate()
        .map(|(i, y)| [i as f64 / n as f64, *y])
        .collect();
    bezier(&points, &vec![1.0; n + 1])
}

/// The graph of the polynomial whose derivative has these roots: its Bernstein coefficients are the sums of the
/// derivative's, and those come from the product of linear factors, rounded.
fn with_roots(roots: &[f64]) -> Option<Curve2> {
    // Scaled Bernstein coefficients: those times the binomial multiply like polynomials.
    let mut scaled = vec![1.0];
    for r in roots {
        let factor = [-r, 1.0 - r];
        let mut product = vec![0.0; scaled.len() + 1];
        for (i, a) in scaled.iter().enumerate() {
            for (j, b) in factor.iter().enumerate() {
                product[i + j] += a * b;
            }
        }
        scaled = product;
    }
    let n = scaled.len() - 1;
    let mut binomial = 1.0;
    let mut sum = 0.0;
    let mut all = vec![0.0];
    let largest = scaled.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    for (k, s) in scaled.iter().enumerate() {
        sum += s / binomial / largest;
        all.push(sum);
        binomial = binomial * (n - k) as f64 / (k + 1) as f64;
    }
    graph(&all)
}

pub(super) fn add(m: &mut Maker) -> Result<(), String> {
    // The easy version of all: one root in the middle.
    let cases = [
        "S1", "S2", "S3", "S4", "S5", "S6", "S7", "S8", "S9", "S10", "S11", "S12", "S13",
    ];
    for case in cases {
        let id = format!("{case} easy");
        asked(m, &format!("{case}_easy"), &id, graph(&[0.0, 1.0, 0.5]))?;
    }
    asked(m, "S1", "S1 no extrema", graph(&[0.0, 0.25, 0.5, 1.0]))?;
    // (2t - 1)^3: a double root of the derivative in the middle, exactly.
    asked(m, "S2", "S2 double root", graph(&[-1.0, 1.0, -1.0, 1.0]))?;
    let d = f64::EPSILON;
    // (2t - 1)^3 - 3 d (2t - 1): two roots 1.5e-8 apart, or none.
    for (name, d) in [("two", d), ("none", -d)] {
        let c = [-1.0 + 3.0 * d, 1.0 + d, -1.0 - d, 1.0 - 3.0 * d];
        asked(m, &format!("S3_{name}"), &format!("S3 {name}"), graph(&c))?;
    }
    for n in [4, 8] {
        let roots: Vec<f64> = (0..n)
            .map(|k| 0.5 + 1e-10 * (f64::from(k) / f64::from(n) - 0.5))
            .collect();
        asked(
            m,
            &format!("S4_{n}"),
            &format!("S4 {n} in 1e-10"),
            with_roots(&roots),
        )?;
    }
    for n in [19, 24] {
        let roots: Vec<f64> = (1..=n).map(|k| f64::from(k) / f64::from(n + 1)).collect();
        asked(
            m,
            &format!("S4_w{n}"),
            &format!("S4 Wilkinson {n}"),
            with_roots(&roots),
        )?;
    }
    asked(
        m,
        "S5_start",
        "S5 at the start",
        graph(&[0.5, 0.5, 1.0, 2.0]),
    )?;
    asked(m, "S5_end", "S5 at the end", graph(&[0.0, 1.0, 2.0, 2.0]))?;
    let knots = vec![0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0];
    let joint = nurbs(
        &[[0.0, 0.0], [1.0, 1.0], [2.0, 1.0], [3.0, 0.0]],
        &[1.0; 4],
        2,
        knots,
    );
    asked(m, "S5_knot", "S5 at a knot", joint)?;
    // ((2t - 1)^2, (2t - 1)^3) times 3 and 1.
    let cusp = [[3.0, -1.0], [-1.0, 1.0], [-1.0, -1.0], [3.0, 1.0]];
    asked(m, "S6", "S6 cusp", bezier(&cusp, &[1.0; 4]))?;
    let knot = [[0.0, 0.0], [-100.0, 100.0], [100.0, 100.0], [0.0, -50.0]];
    asked(m, "S7", "S7 loop", bezier(&knot, &[1.0; 4]))?;
    asked(m, "S8", "S8 constant", graph(&[0.5; 4]))?;
    asked(
        m,
        "S9_1e-300",
        "S9 1e-300",
        graph(&[0.0, 1e-300, 0.0, 1e-300]),
    )?;
    let one = 1.0f64;
    asked(
        m,
        "S9_ulp",
        "S9 1ulp",
        graph(&[one, one.next_up(), one, one.next_up()]),
    )?;
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let around = [
        [1.0, 0.0],
        [1.0, 1.0],
        [0.0, 1.0],
        [-1.0, 1.0],
        [-1.0, 0.0],
        [-1.0, -1.0],
        [0.0, -1.0],
        [1.0, -1.0],
        [1.0, 0.0],
    ];
    let weights = [1.0, h, 1.0, h, 1.0, h, 1.0, h, 1.0];
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    asked(
        m,
        "S10",
        "S10 nine points",
        nurbs(&around, &weights, 2, knots),
    )?;
    // Bernstein coefficients of Chebyshev's polynomial of degree 25, in both coordinates:
    // (-1)^(n-k) C(2n, 2k) / C(n, k).
    let n = 25;
    let mut ratio = 1.0;
    let mut chebyshev = Vec::new();
    for k in 0..=n {
        let sign = if (n - k) % 2 == 0 { 1.0 } else { -1.0 };
        chebyshev.push(sign * ratio);
        // C(2n, 2k+2) / C(2n, 2k) over C(n, k+1) / C(n, k).
        let (n, k) = (n as f64, k as f64);
        ratio *= (2.0 * n - 2.0 * k - 1.0) / (2.0 * k + 1.0);
    }
    let largest = chebyshev.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let wave: Vec<P> = (0..=n)
        .map(|k| [chebyshev[k] / largest, chebyshev[n - k] / largest])
        .collect();
    asked(m, "S11", "S11 Chebyshev 25", bezier(&wave, &[1.0; 26]))?;
    let points: Vec<P> = (0..6)
        .map(|i| {
            polar(
                [0.0, 0.0],
                1.0 + f64::from(i % 2),
                TURN * f64::from(i) / 5.5,
            )
        })
        .collect();
    let weights = [1.0, 1e6, 1e-6, 1e6, 1.0, 1e-6];
    asked(m, "S12", "S12 rational", bezier(&points, &weights))?;
    for (name, s) in [("1e-15", 1e-15), ("1e-300", 1e-300)] {
        let tiny: Vec<P> = [[0.0, 0.0], [1.0, 2.0], [2.0, -1.0], [3.0, 1.0]]
            .map(|p: P| [p[0] * s, p[1] * s])
            .to_vec();
        asked(
            m,
            &format!("S13_{name}"),
            &format!("S13 {name}"),
            bezier(&tiny, &[1.0; 4]),
        )?;
    }
    Ok(())
}
