//! Acceptance tests over the whole system; see `tests/`.
