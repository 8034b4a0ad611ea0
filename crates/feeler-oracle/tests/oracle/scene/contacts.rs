//! What lists of contacts must be.

use feeler_oracle::{ContactTruth, ContactsTruth};

pub(crate) fn near(at: &[[f64; 2]; 3], point: [f64; 3], slack: f64) -> bool {
    (0..3).all(|k| at[k][0] - slack <= point[k] && point[k] <= at[k][1] + slack)
}

/// Exactly these contacts, all proven points: where, and their separations.
#[track_caller]
pub(crate) fn must_be(found: &ContactsTruth, expected: &[([f64; 3], f64)]) {
    assert!(found.whole);
    assert_eq!(found.contacts.len(), expected.len(), "{found:#?}");
    for (point, separation) in expected {
        let fits = |c: &&ContactTruth| near(&c.at, *point, 1e-12);
        let mut all = found.contacts.iter().filter(fits);
        let (Some(c), None) = (all.next(), all.next()) else {
            panic!("none or several at {point:?}: {found:#?}");
        };
        assert!(c.proven && !c.continuum, "{c:?}");
        let (lo, hi) = (c.separation.lo.approximate(), c.separation.hi.approximate());
        assert!((lo - separation).abs() < 1e-14, "{lo}, not {separation}");
        assert!(c.separation.width().approximate() < 1e-30, "[{lo}, {hi}]");
    }
}

/// One contact that is proven, and it is no point. (What is level elsewhere, but not lowest, stays unsettled: the
/// oracle looks for ways down from points alone.)
#[track_caller]
pub(crate) fn one_continuum(found: &ContactsTruth) -> &ContactTruth {
    let mut proven = found.contacts.iter().filter(|c| c.proven);
    let (Some(c), None) = (proven.next(), proven.next()) else {
        panic!("{found:#?}");
    };
    assert!(c.continuum);
    c
}
