//! A few inputs for each target, the same every time: what a test runs.

use crate::target::{Outcome, Target};

/// Most of an input's bytes are random; a scene reads no more than a few hundred.
const LENGTH: usize = 512;

/// How many inputs were checked, and how many made nothing to check.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Smoke {
    /// Those that were.
    pub checked: usize,
    /// The others.
    pub rejected: usize,
}

/// SplitMix64 (G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014).
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Input `number` of the series `seed`: random bytes, biased toward small ones, which mean what is plain; of random length.
pub fn input(seed: u64, number: u64) -> Vec<u8> {
    let mut state = seed ^ number.wrapping_mul(0xd134_2543_de82_ef95);
    let length = 16 + next(&mut state) as usize % LENGTH;
    // Of each input another part of the bytes is kept small.
    let plain = next(&mut state) % 4;
    (0..length)
        .map(|_| {
            let r = next(&mut state);
            let byte = r as u8;
            if r >> 62 < plain { byte >> 2 } else { byte }
        })
        .collect()
}

/// Runs a target on inputs until so many were checked, at most twenty times as many in all.
///
/// # Errors
/// The input's number and what was found.
pub fn smoke(target: &Target, seed: u64, wanted: usize) -> Result<Smoke, String> {
    let mut done = Smoke::default();
    for number in 0..20 * wanted as u64 {
        match target.try_run(&input(seed, number)) {
            Ok(Outcome::Checked) => done.checked += 1,
            Ok(Outcome::Rejected) => done.rejected += 1,
            Err(found) => return Err(format!("{}, input {number}: {found}", target.name)),
        }
        if done.checked == wanted {
            break;
        }
    }
    Ok(done)
}
