//! Switches for what saves work.

/// What a prepared BREP may leave out.
///
/// Answers are proven with and without each of them, and so agree within their bounds; without one a query takes longer, or is
/// [`Undecided`](crate::query::Undecided) where its budget ends. They are all on unless something is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shortcuts {
    /// Formulas for planes, cylinders, cones, spheres and tori and for the segments and arcs that bound them; without, they are
    /// searched like any other surface, as rational patches.
    pub closed_forms: bool,
    /// Planes, spheres, cylinders, cones and tori are recognised in NURBS surfaces: planes have formulas (with
    /// [`closed_forms`](Self::closed_forms)), the others are bounded as such; without, only by their coefficients.
    pub recognition: bool,
    /// The search for a minimum puts faces and patches aside by boxes around them; without, it opens each.
    pub boxes: bool,
    /// The search settles a box at once where the function is convex; without, it halves boxes down to the asked bound.
    pub convex_leaves: bool,
    /// The search leaves of a box only its lower border where the function is monotone, and for lists of contacts only two borders where
    /// it has no minimum between them; without, it halves it.
    pub monotone_borders: bool,
    /// The search for a minimum works in f64, and in double-double where f64 no longer suffices; without, in double-double
    /// at once.
    pub double_first: bool,
    /// A grid of cells over the loops of a face; without, one cell that holds all of them.
    pub trim_cells: bool,
    /// The side of a sphere's centre that is far from the surface is that of the middle of a cell around it, which is kept; without,
    /// a ray is cast for each centre.
    pub side_cells: bool,
}

impl Shortcuts {
    /// All of them.
    pub const ALL: Self = Self {
        closed_forms: true,
        recognition: true,
        boxes: true,
        convex_leaves: true,
        monotone_borders: true,
        double_first: true,
        trim_cells: true,
        side_cells: true,
    };
}

impl Default for Shortcuts {
    fn default() -> Self {
        Self::ALL
    }
}
