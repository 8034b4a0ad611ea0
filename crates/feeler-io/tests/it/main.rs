//! Files that are read and written, in one program.

mod locations;
mod models;
mod regions;
mod round_trips;
mod siblings;
mod written_brep;
mod written_solids;
