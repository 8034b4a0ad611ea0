//! Import of .3dm files: against an independent reader, against files made up byte by byte, and
//! against damage; and of damaged .brep files.

mod brep_hostile;
mod classes;
mod fixture;
mod hostile;
mod models;
mod mutated;
mod older;
mod on_surface;
mod random;
mod reference;
mod written;
