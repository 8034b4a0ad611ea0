//! The patches of a face and the pieces of its boundary, in one arithmetic.

use super::boundary::{self, CurveSource, Cut, Piece};
use super::bunches::{self, Bunches};
use super::net::{Net, Products};
use super::{Box3, Homogeneous, Patches, jet};
use crate::brep::Brep;
use crate::numeric::Real;
use nalgebra::Point3;
use std::sync::{Arc, OnceLock};

/// The patches and boundary of one face in one arithmetic.
#[derive(Debug)]
pub(crate) struct FaceGeometry<T> {
    pub(super) brep: Arc<Brep>,
    pub(crate) patches: Patches<T>,
    pub(super) pieces: Box<[OnceLock<Box<KeptPiece<T>>>]>,
    frame: Arc<Frame>,
    pub(super) seeds: OnceLock<Box<[Seed]>>,
}

/// What all arithmetics have in common.
#[derive(Debug)]
struct Frame {
    face: usize,
    /// What the boundary pieces are parts of; a curve itself is made for each piece, as few are ever made.
    curves: Box<[CurveSource]>,
    cuts: Box<[Cut]>,
    /// The patches' boxes in space; `None` where a weight is not proven to be positive.
    patch_boxes: Box<[Option<Box3>]>,
    piece_boxes: OnceLock<Box<[Option<Box3>]>>,
    bunches: OnceLock<Option<Box<Bunches>>>,
}

/// A boundary piece, and what is made of it when it is first asked for.
#[derive(Debug)]
pub(super) struct KeptPiece<T> {
    pub(super) piece: Piece<T>,
    pub(super) products: OnceLock<Box<Products<T>>>,
    speeds: OnceLock<[f64; 2]>,
    /// Whether it leaves its patch, once that was asked.
    leaves: OnceLock<bool>,
}

/// A point of a patch: where a descent may start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seed {
    pub(crate) point: Point3<f64>,
    /// Of all places on all patches.
    place: usize,
}

impl Seed {
    pub(crate) fn patch(&self) -> usize {
        self.place / (SEEDS * SEEDS)
    }

    pub(crate) fn local(&self) -> [f64; 2] {
        let k = self.place % (SEEDS * SEEDS);
        [k / SEEDS, k % SEEDS].map(|k| (k as f64 + 0.5) / SEEDS as f64)
    }
}

/// Beside so many boundary pieces a patch, as a mean, the box of a patch tells little of each.
const MANY_PIECES: usize = 16;
/// So many seeds a patch along u and along v.
const SEEDS: usize = 3;
/// Faces of more patches have no seeds: to look at all of them would take longer than to open the nearest boxes.
const MOST_SEEDED: usize = 64;

impl<T: Real> FaceGeometry<T> {
    fn new(brep: &Arc<Brep>, patches: Patches<T>, frame: Arc<Frame>) -> Self {
        Self {
            brep: Arc::clone(brep),
            patches,
            pieces: frame.cuts.iter().map(|_| OnceLock::new()).collect(),
            frame,
            seeds: OnceLock::new(),
        }
    }

    /// The same face in another arithmetic, patches and pieces by the same index.
    pub(super) fn finer<U: Real>(&self) -> FaceGeometry<U> {
        let patches = Patches::on_demand(self.brep.surface(self.frame.face));
        FaceGeometry::new(&self.brep, patches, Arc::clone(&self.frame))
    }

    /// The patches' boxes in space; `None` where a weight is not proven to be positive.
    pub(crate) fn patch_boxes(&self) -> &[Option<Box3>] {
        &self.frame.patch_boxes
    }

    /// Bytes of what all arithmetics share.
    pub(super) fn shared_bytes(&self) -> usize {
        let f = &*self.frame;
        let bunches = f.bunches.get().and_then(Option::as_ref);
        let boxes = f.piece_boxes.get();
        size_of_val(f)
            + size_of_val(&*f.curves)
            + size_of_val(&*f.cuts)
            + size_of_val(&*f.patch_boxes)
            + boxes.map_or(0, |b| size_of_val(&**b))
            + bunches.map_or(0, |b| b.bytes())
    }

    /// How many boundary pieces there are.
    pub(crate) fn piece_count(&self) -> usize {
        self.frame.cuts.len()
    }

    /// The uv curve that a boundary piece is part of, as `uv_curves` numbers them.
    pub(crate) fn piece_curve(&self, index: usize) -> usize {
        self.frame.cuts[index].curve as usize
    }

    /// The patch that a boundary piece lies on.
    pub(crate) fn piece_patch(&self, index: usize) -> usize {
        self.frame.cuts[index].patch as usize
    }

    /// A boundary piece; made at the first call.
    pub(crate) fn piece(&self, index: usize) -> &Piece<T> {
        &self.kept_piece(index).piece
    }

    fn kept_piece(&self, index: usize) -> &KeptPiece<T> {
        self.pieces[index].get_or_init(|| {
            let cut = &self.frame.cuts[index];
            let patch = self.patches.lent(cut.patch as usize);
            let curve = boundary::uv_curve(&self.brep, self.frame.curves[cut.curve as usize]);
            Box::new(KeptPiece {
                piece: boundary::lift(&curve, cut, &patch),
                products: OnceLock::new(),
                speeds: OnceLock::new(),
                leaves: OnceLock::new(),
            })
        })
    }

    pub(crate) fn patch_products(&self, index: usize) -> &Products<T> {
        self.patches.products(index)
    }

    /// See [`Net::speeds`].
    pub(crate) fn patch_speeds(&self, index: usize) -> [f64; 2] {
        self.patches.speeds(index)
    }

    /// The same of a boundary piece.
    pub(crate) fn piece_speeds(&self, index: usize) -> [f64; 2] {
        let kept = self.kept_piece(index);
        let space = kept.piece.space.as_ref();
        let make = || space.map_or([f64::INFINITY; 2], Net::speeds);
        *kept.speeds.get_or_init(make)
    }

    /// Whether a boundary piece leaves its patch: asked of its curve there at the first call.
    pub(crate) fn piece_leaves(
        &self,
        index: usize,
        ask: impl FnOnce(&[Homogeneous<T, 3>]) -> bool,
    ) -> bool {
        let kept = self.kept_piece(index);
        *kept.leaves.get_or_init(|| ask(&kept.piece.local))
    }

    /// `None` where the piece's degree is too high to be composed.
    pub(crate) fn piece_products(&self, index: usize) -> Option<&Products<T>> {
        let kept = self.kept_piece(index);
        let space = kept.piece.space.as_ref()?;
        Some(kept.products.get_or_init(|| Box::new(space.products())))
    }
}

impl FaceGeometry<f64> {
    pub(super) fn of_face(brep: &Arc<Brep>, face: usize) -> Self {
        let (patches, patch_boxes) = Patches::with_boxes(brep.surface(face));
        let frame = Frame {
            face,
            curves: boundary::curve_sources(brep, face).into(),
            cuts: boundary::cut_boundary(brep, face, &patches).into(),
            patch_boxes,
            piece_boxes: OnceLock::new(),
            bunches: OnceLock::new(),
        };
        Self::new(brep, patches, Arc::new(frame))
    }

    /// Boxes around what matters of the boundary pieces, by the bunch: of a face with far more of these than patches. (Where there are not the boxes of the
    /// patches tell enough.)
    pub(crate) fn bunches(&self) -> Option<&Bunches> {
        let (pieces, patches) = (self.frame.cuts.len(), self.patches.len());
        let make = || {
            let many = pieces > bunches::FEW && pieces > MANY_PIECES * patches;
            many.then(|| Box::new(Bunches::new(self.piece_boxes().iter().copied())))
        };
        self.frame.bunches.get_or_init(make).as_deref()
    }

    /// A box around what lies on its patch of each boundary piece: the patch's own where no other is known. Made when pieces are first in line, so that those far off need
    /// not be made.
    ///
    /// That is an image of places in the box of the piece's control points in uv (all of the curve is in their hull, as weights are positive), cut to the patch.
    pub(crate) fn piece_boxes(&self) -> &[Option<Box3>] {
        self.frame.piece_boxes.get_or_init(|| {
            let surface = self.brep.surface(self.frame.face);
            let mut curve = None;
            let box_of = |cut: &Cut| {
                // Those of one curve come one after the other.
                let (_, curve) = match curve.take() {
                    Some((index, kept)) if index == cut.curve => curve.insert((index, kept)),
                    _ => {
                        let source = self.frame.curves[cut.curve as usize];
                        curve.insert((cut.curve, boundary::uv_curve(&self.brep, source)))
                    }
                };
                let patch = cut.patch as usize;
                let range = boundary::native_range(curve, cut, &self.patches.maps_of(patch));
                let own = self.patches.box_over(surface, patch, &range);
                own.or(self.frame.patch_boxes[patch])
            };
            self.frame.cuts.iter().map(box_of).collect()
        })
    }

    /// Points spread over all patches.
    pub(crate) fn seeds(&self) -> &[Seed] {
        self.seeds.get_or_init(|| {
            if self.patches.len() > MOST_SEEDED {
                return Box::default();
            }
            let mut out = Vec::with_capacity(self.patches.len() * SEEDS * SEEDS);
            for patch in 0..self.patches.len() {
                let p = self.patches.lent(patch);
                if !jet::fits(p.net.degree) {
                    continue;
                }
                // What is rounded for this alone is not kept.
                let own = (p.is_kept() && !p.net.has_plain()).then(|| p.net.clone());
                let net = own.as_ref().unwrap_or(&p.net);
                for k in 0..SEEDS * SEEDS {
                    let mut seed = Seed {
                        point: Point3::origin(),
                        place: patch * SEEDS * SEEDS + k,
                    };
                    let [s, t] = seed.local();
                    let h = jet::value(net, s, t);
                    seed.point = Point3::from([0, 1, 2].map(|c| h[c] / h[3] + net.origin[c]));
                    out.push(seed);
                }
            }
            out.into()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brep::{BrepBuilder, TrimSpec};
    use crate::numeric::{Ball, Interval};
    use crate::nurbs::{Curve2, Curve3, Line, NurbsCurve, NurbsSurface, Revolution, Sum, Surface};
    use crate::prepare::curve_jet;
    use nalgebra::{Point2, Vector3, Vector4};

    const UNIT: Interval = Interval {
        start: 0.0,
        end: 1.0,
    };

    /// Rational, of two spans.
    fn curve(far: f64) -> Curve3 {
        let points = (0..4).map(|k| {
            let (t, w) = (f64::from(k), 1.0 + 0.25 * f64::from(k % 2));
            Vector4::new((far + t * t * 0.1) * w, 0.3 * t * w, t * w, w)
        });
        let knots = vec![0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0];
        Curve3::Nurbs(NurbsCurve::new(2, points.collect(), knots).unwrap())
    }

    /// Of several patches along u and along v, of each kind that is.
    fn surfaces() -> [Surface; 4] {
        let revolution = |transposed| {
            Surface::Revolution(Revolution {
                origin: Point3::new(0.5, 0.0, 0.0),
                axis: Vector3::new(0.0, 0.2, 1.0),
                profile: curve(3.0),
                angle: Interval::new(0.0, 2.0).unwrap(),
                angle_domain: UNIT,
                transposed,
            })
        };
        let sum = Surface::Sum(Sum {
            base: Vector3::new(1.0, 2.0, 3.0),
            first: curve(0.0),
            second: curve(-5.0),
        });
        let net = (0..16).map(|k| {
            let (i, j) = (f64::from(k / 4), f64::from(k % 4));
            let w = 1.0 + 0.5 * f64::from(k % 3);
            Vector4::new(i * w, j * w, (i - j) * i * w, w)
        });
        let knots = vec![0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0];
        let nurbs = NurbsSurface::new([2, 2], [4, 4], net.collect(), [knots.clone(), knots]);
        let nurbs = Surface::Nurbs(nurbs.unwrap());
        [revolution(false), revolution(true), sum, nurbs]
    }

    /// What a piece has on its patch is in its box; boxes of pieces that are short, where a trim passes from patch to patch, are small.
    #[test]
    fn what_is_on_its_patch_of_a_piece_is_in_its_box() {
        /// Both boxes are wider than what they hold by roundings of this part at most.
        const ROUNDED: f64 = 1e-9;
        for surface in surfaces() {
            let corners = [[0.1, 0.2], [0.9, 0.3], [0.4, 0.9]].map(Point2::from);
            let mut b = BrepBuilder::new();
            let vertices = [0.0, 1.0, 2.0].map(|x| b.vertex([x, x * x, 0.0]));
            let trims = (0..3).map(|k| {
                let next = (k + 1) % 3;
                let vertices = [vertices[k], vertices[next]];
                TrimSpec {
                    vertices,
                    curve: Curve2::Line(Line::new(corners[k], corners[next], UNIT).unwrap()),
                    edge: Some(b.straight_edge(vertices).unwrap()),
                }
            });
            let trims = trims.collect();
            b.face_with_trims(surface, vec![trims]).unwrap();
            let geometry = FaceGeometry::of_face(&Arc::new(b.build().unwrap()), 0);
            let (mut seen, mut small) = (0, 0);
            for index in 0..geometry.piece_count() {
                let piece = geometry.piece(index);
                let own = geometry.piece_boxes()[index].expect("a box");
                let patch = &geometry.patches[piece.patch];
                for k in 0..=16 {
                    let (p, _) = curve_jet(&piece.local, Ball::exact(f64::from(k) / 16.0));
                    let [s, t] = [0, 1].map(|c| p[c] / p[2]);
                    if [s, t].iter().any(|x| x.mid < 0.0 || x.mid > 1.0) {
                        continue;
                    }
                    seen += 1;
                    let h = patch.net.jet(s, t).value;
                    for c in 0..3 {
                        let x = h[c] / h[3] + Ball::exact(patch.net.origin[c]);
                        assert!(
                            x.lower() <= own[c][1] && x.upper() >= own[c][0],
                            "{index} {k}: {x:?} {own:?}"
                        );
                    }
                }
                let wide = |b: &Box3| b.iter().fold(0.0, |m: f64, r| m.max(r[1] - r[0]));
                let of_patch = geometry.patch_boxes()[piece.patch].expect("a box");
                assert!(wide(&own) <= wide(&of_patch) * (1.0 + ROUNDED));
                small += usize::from(wide(&own) < ROUNDED * wide(&of_patch));
            }
            // Each of three sides passes from one to another once at least.
            assert!(seen > 100 && small >= 6, "{seen} {small}");
        }
    }
}
