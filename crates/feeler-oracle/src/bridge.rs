//! The calls into C++; see `cpp/bridge.hpp` for what each does.
#![allow(
    unsafe_code,
    missing_docs,
    unreachable_pub,
    reason = "cxx generates the calls"
)]

#[cxx::bridge(namespace = "feeler_oracle")]
pub(crate) mod ffi {
    /// `mantissa * 2^exponent`, the mantissa in hexadecimal.
    struct RawDyadic {
        mantissa: String,
        exponent: i64,
    }

    struct RawEnclosure {
        lo: RawDyadic,
        hi: RawDyadic,
    }

    /// Point, u, v, uu, uv and vv derivatives: eighteen numbers.
    struct RawEvaluation {
        numbers: Vec<RawEnclosure>,
    }

    /// 0 inside, 1 outside, 2 boundary.
    struct RawSide {
        side: u8,
        in_gap: bool,
    }

    /// The enclosure `[lo, hi]`, infinite (no face) or not; the status and face as in
    /// `distance.hpp`.
    struct RawDistance {
        enclosure: RawEnclosure,
        finite: bool,
        status: u8,
        face: i64,
        nodes64: u64,
        nodes: u64,
    }

    struct RawHit {
        face: usize,
        t: RawEnclosure,
        lies_in: bool,
        t_end: RawEnclosure,
        boundary: bool,
        /// 0: not known.
        multiplicity: u32,
        transversal: bool,
        tangential: bool,
        u: f64,
        v: f64,
    }

    struct RawOpen {
        face: usize,
        t: RawEnclosure,
        why: String,
    }

    struct RawLine {
        hits: Vec<RawHit>,
        open: Vec<RawOpen>,
        /// -1: not known.
        crossings: i32,
        /// 0, 1, or -1: not known.
        in_crack: i32,
    }

    /// The width of an edge's crack.
    struct RawCrack {
        width: RawEnclosure,
        shared: bool,
        known: bool,
        cuts: u32,
    }

    /// 0 inside, 1 outside, 2 boundary, 3 undecided.
    struct RawInside {
        kind: u8,
        why: String,
    }

    struct RawDerivativeRoot {
        t: RawEnclosure,
        multiplicity: [u32; 2],
        sign: [i8; 2],
        cusp: bool,
    }

    /// The two ends of a part of a curve.
    struct RawPart {
        start: RawEnclosure,
        end: RawEnclosure,
    }

    struct RawAxisRoots {
        roots: Vec<RawDerivativeRoot>,
        constant: Vec<RawPart>,
    }

    struct RawDerivativeRoots {
        u: RawAxisRoots,
        v: RawAxisRoots,
    }

    /// A box in space, x0, x1, y0, y1, z0, z1; `held`: `f.hi` is the value of a point of a face.
    struct RawEntry {
        f: RawEnclosure,
        held: bool,
        at: [f64; 6],
        minimum: bool,
        continuum: bool,
        face: i64,
    }

    struct RawContacts {
        entries: Vec<RawEntry>,
        join: f64,
        whole: bool,
        nodes: u64,
    }

    /// `kind`: 0 a local minimiser, 1 none, 2 not known; `at` as in `RawEntry`.
    struct RawCriticalPoint {
        distance: RawEnclosure,
        at: [f64; 6],
        kind: u8,
        inner: bool,
    }

    struct RawCriticalPoints {
        all: bool,
        points: Vec<RawCriticalPoint>,
    }

    unsafe extern "C++" {
        include!("bridge.hpp");

        type Builder;
        type Core;

        fn new_builder() -> UniquePtr<Builder>;
        fn add_brep(self: Pin<&mut Builder>, closed: bool, edges: usize) -> Result<()>;
        fn add_nurbs_face(
            self: Pin<&mut Builder>,
            reversed: bool,
            degree_u: usize,
            degree_v: usize,
            knots_u: &[f64],
            knots_v: &[f64],
            net: &[f64],
        ) -> Result<()>;
        fn add_plane_face(self: Pin<&mut Builder>, reversed: bool, numbers: &[f64]) -> Result<()>;
        fn add_curve(self: Pin<&mut Builder>, params: &[f64]) -> Result<()>;
        fn add_space_polyline(
            self: Pin<&mut Builder>,
            points: &[f64],
            params: &[f64],
        ) -> Result<()>;
        fn add_space_nurbs_curve(
            self: Pin<&mut Builder>,
            degree: usize,
            knots: &[f64],
            points: &[f64],
        ) -> Result<()>;
        fn add_space_arc(self: Pin<&mut Builder>, numbers: &[f64]) -> Result<()>;
        fn add_revolution_face(
            self: Pin<&mut Builder>,
            reversed: bool,
            transposed: bool,
            numbers: &[f64],
        ) -> Result<()>;
        fn add_sum_face(self: Pin<&mut Builder>, reversed: bool, base: &[f64]) -> Result<()>;
        fn set_trimmed(self: Pin<&mut Builder>) -> Result<()>;
        fn add_loop(self: Pin<&mut Builder>) -> Result<()>;
        fn add_trim(
            self: Pin<&mut Builder>,
            start: f64,
            end: f64,
            reversed: bool,
            edge: i64,
            params: &[f64],
        ) -> Result<()>;
        fn add_polyline(self: Pin<&mut Builder>, points: &[f64], params: &[f64]) -> Result<()>;
        fn add_nurbs_curve(
            self: Pin<&mut Builder>,
            degree: usize,
            knots: &[f64],
            points: &[f64],
        ) -> Result<()>;
        fn add_arc(self: Pin<&mut Builder>, numbers: &[f64]) -> Result<()>;
        fn finish(self: Pin<&mut Builder>) -> Result<UniquePtr<Core>>;

        fn prepare(core: &Core, what: u8, face: usize) -> Result<()>;
        fn evaluate_face(
            core: &Core,
            face: usize,
            u: f64,
            v: f64,
            below_u: bool,
            below_v: bool,
        ) -> Result<RawEvaluation>;
        fn side_of(core: &Core, face: usize, u: f64, v: f64) -> Result<RawSide>;
        fn derivative_roots_of(
            core: &Core,
            face: usize,
            trim_loop: usize,
            trim: usize,
        ) -> Result<RawDerivativeRoots>;
        fn distance_to(core: &Core, x: f64, y: f64, z: f64, nodes: i64) -> Result<RawDistance>;
        fn support_of(
            core: &Core,
            x: f64,
            y: f64,
            z: f64,
            h: f64,
            nodes: i64,
        ) -> Result<RawDistance>;
        fn line_truth(core: &Core, origin: &[f64], direction: &[f64], kind: u8) -> Result<RawLine>;
        fn crack_of(core: &Core, edge: usize) -> Result<RawCrack>;
        fn contacts_of(
            core: &Core,
            linear: bool,
            at: &[f64],
            h: f64,
            limit: f64,
            join: f64,
        ) -> Result<RawContacts>;
        fn foot_of(core: &Core, linear: bool, at: &[f64], h: f64, limit: f64) -> Result<Vec<f64>>;
        fn join_width(core: &Core) -> Result<f64>;
        fn inside_of(core: &Core, x: f64, y: f64, z: f64, rays: i32) -> Result<RawInside>;
        fn critical_points_of(
            p: usize,
            q: usize,
            net: &[f64],
            point: &[f64; 3],
        ) -> Result<RawCriticalPoints>;
        fn eigen_candidates(bernstein: &[f64]) -> Result<Vec<f64>>;
        fn set_rounding_upward(upward: bool);
    }
}
