//! Pages and pictures, in one program.

mod mouse;
mod view;
