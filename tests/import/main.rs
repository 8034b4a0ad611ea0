//! Import of .3dm files: against an independent reader, against files made up byte by byte, and
//! against damage.

mod classes;
mod fixture;
mod hostile;
mod models;
mod reference;
