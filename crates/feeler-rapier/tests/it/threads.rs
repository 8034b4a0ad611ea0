//! Runs of Rapier on several threads.

#[allow(dead_code, reason = "the example's own main")]
#[path = "../../examples/same_bits.rs"]
mod same_bits;

/// One build of Rapier, with its feature `parallel`: on one thread and on several. (Without that feature Rapier is another program:
/// the example `same_bits` prints what is to be compared with it.)
#[test]
fn as_many_threads_give_the_same_bits() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| same_bits::run(40).unwrap())
    };
    let one = run(1);
    assert!(one.pairs > 40, "{one:?}");
    for threads in [2, 4] {
        assert_eq!(run(threads), one, "{threads}");
    }
}
