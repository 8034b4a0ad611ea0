//! The program `feeler`, run as a user runs it.

mod exit_codes;
mod layout;
mod program;
