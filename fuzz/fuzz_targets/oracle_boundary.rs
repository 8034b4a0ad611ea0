//! The target `oracle_boundary` under libFuzzer.
#![no_main]
feeler_fuzz::drive!("oracle_boundary");
