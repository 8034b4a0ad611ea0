//! The program `feeler`, run as a user runs it.

mod convert;
mod exit_codes;
mod gate;
mod health;
mod layout;
mod program;
mod view;
