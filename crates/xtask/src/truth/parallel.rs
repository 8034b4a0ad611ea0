//! Work on several threads whose results do not depend on how many there are.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Calls a worker for each of `0..count`, each once, and returns the results in that order. Every
/// thread makes a worker of its own; the next number goes to whoever is free.
pub(crate) fn in_parallel<T: Send, W: FnMut(usize) -> T>(
    count: usize,
    jobs: usize,
    make_worker: impl Fn() -> W + Sync,
) -> Result<Vec<T>, String> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut worker = make_worker();
        let mut done = Vec::new();
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            if i >= count {
                return done;
            }
            done.push((i, worker(i)));
        }
    };
    let results: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..jobs.max(1)).map(|_| scope.spawn(work)).collect();
        threads.into_iter().map(|t| t.join()).collect()
    });
    let mut all = Vec::with_capacity(count);
    for result in results {
        all.extend(result.map_err(|_| "a thread panicked")?);
    }
    all.sort_by_key(|(i, _)| *i);
    Ok(all.into_iter().map(|(_, t)| t).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_whatever_the_number_of_threads() {
        for jobs in [0, 1, 2, 7] {
            let made = AtomicUsize::new(0);
            let all = in_parallel(100, jobs, || {
                made.fetch_add(1, Ordering::Relaxed);
                |i| i * i
            });
            assert_eq!(all.unwrap(), (0..100).map(|i| i * i).collect::<Vec<_>>());
            assert_eq!(made.into_inner(), jobs.max(1));
        }
        assert!(in_parallel(10, 2, || |i| assert!(i < 5)).is_err());
    }
}
