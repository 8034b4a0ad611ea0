//! A hash of everything a BREP says.

use feeler::brep::{Brep, Iso, LoopKind, TrimKind};
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, KnotVector, Surface};
use sha2::{Digest, Sha256};

/// SHA-256 in hexadecimal of the imported BREPs: every number (as its bits), index, flag and kind,
/// in order, each list preceded by its length. Two imports have the same hash only if every query
/// has the same truth for both.
pub fn breps_hash(breps: &[&Brep]) -> String {
    let mut feed = Feed(Sha256::new());
    feed.tag("feeler brep 1");
    feed.count(breps.len());
    for brep in breps {
        feed.brep(brep);
    }
    hex(&feed.0.finalize())
}

/// SHA-256 of some bytes in hexadecimal.
pub fn bytes_hash(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

struct Feed(Sha256);

impl Feed {
    /// A word with its length, so that words in a row cannot be taken for others.
    fn tag(&mut self, word: &str) {
        self.count(word.len());
        self.0.update(word.as_bytes());
    }

    fn count(&mut self, n: usize) {
        self.0.update((n as u64).to_le_bytes());
    }

    /// `None` is a number that no index is.
    fn index(&mut self, i: Option<usize>) {
        self.0
            .update(i.map_or(u64::MAX, |i| i as u64).to_le_bytes());
    }

    fn flag(&mut self, b: bool) {
        self.0.update([u8::from(b)]);
    }

    fn number(&mut self, x: f64) {
        self.0.update(x.to_bits().to_le_bytes());
    }

    fn numbers<'a>(&mut self, all: impl IntoIterator<Item = &'a f64>) {
        all.into_iter().for_each(|x| self.number(*x));
    }

    fn interval(&mut self, i: Interval) {
        self.number(i.start);
        self.number(i.end);
    }

    fn indices(&mut self, all: &[usize]) {
        self.count(all.len());
        all.iter().for_each(|i| self.count(*i));
    }

    fn brep(&mut self, brep: &Brep) {
        let p = brep.parts();
        self.count(p.curves2.len());
        p.curves2.iter().for_each(|c| self.curve(c));
        self.count(p.curves3.len());
        p.curves3.iter().for_each(|c| self.curve(c));
        self.count(p.surfaces.len());
        p.surfaces.iter().for_each(|s| self.surface(s));
        self.count(p.vertices.len());
        for v in &p.vertices {
            self.numbers(v.point.iter());
            self.indices(&v.edges);
            self.tolerance(v.tolerance);
        }
        self.count(p.edges.len());
        for e in &p.edges {
            self.index(e.curve);
            self.interval(e.span);
            self.flag(e.reversed);
            self.indices(&e.vertices);
            self.indices(&e.trims);
            self.tolerance(e.tolerance);
        }
        self.count(p.trims.len());
        for t in &p.trims {
            self.count(t.curve);
            self.interval(t.span);
            self.flag(t.reversed);
            self.index(t.edge);
            self.flag(t.edge_reversed);
            self.indices(&t.vertices);
            self.tag(match t.kind {
                TrimKind::Unknown => "unknown",
                TrimKind::Boundary => "boundary",
                TrimKind::Mated => "mated",
                TrimKind::Seam => "seam",
                TrimKind::Singular => "singular",
            });
            self.tag(match t.iso {
                Iso::None => "none",
                Iso::U => "u",
                Iso::V => "v",
                Iso::West => "west",
                Iso::South => "south",
                Iso::East => "east",
                Iso::North => "north",
            });
            self.count(t.trim_loop);
        }
        self.count(p.loops.len());
        for l in &p.loops {
            self.tag(match l.kind {
                LoopKind::Unknown => "unknown",
                LoopKind::Outer => "outer",
                LoopKind::Inner => "inner",
                LoopKind::Slit => "slit",
            });
            self.indices(&l.trims);
            self.count(l.face);
        }
        self.count(p.faces.len());
        for f in &p.faces {
            self.count(f.surface);
            self.flag(f.reversed);
            self.flag(f.loops.is_some());
            self.indices(f.loops.as_deref().unwrap_or_default());
        }
    }

    fn tolerance(&mut self, tolerance: Option<f64>) {
        self.flag(tolerance.is_some());
        self.number(tolerance.unwrap_or(0.0));
    }

    fn knots(&mut self, k: &KnotVector) {
        self.count(k.degree());
        self.count(k.knots().len());
        self.numbers(k.knots());
    }

    fn curve<const D: usize, const H: usize>(&mut self, curve: &Curve<D, H>) {
        match curve {
            Curve::Line(c) => {
                self.tag("line");
                self.numbers(c.from.iter().chain(c.to.iter()));
                self.interval(c.domain);
            }
            Curve::Arc(c) => {
                self.tag("arc");
                self.numbers(c.center.iter());
                self.numbers(c.x.iter().chain(c.y.iter()).chain(c.z.iter()));
                self.number(c.radius);
                self.interval(c.angle);
                self.interval(c.domain);
            }
            Curve::Polyline(c) => {
                self.tag("polyline");
                self.count(c.points().len());
                c.points().iter().for_each(|p| self.numbers(p.iter()));
                self.numbers(c.params());
            }
            Curve::Nurbs(c) => {
                self.tag("nurbs");
                self.knots(c.knots());
                c.control_points()
                    .iter()
                    .for_each(|p| self.numbers(p.iter()));
            }
            Curve::Poly(c) => {
                self.tag("poly");
                self.count(c.segments().len());
                self.numbers(c.params());
                // One level: segments are never poly-curves themselves.
                c.segments().iter().for_each(|s| self.curve(s));
            }
        }
    }

    fn surface(&mut self, surface: &Surface) {
        self.tag(surface.type_name());
        match surface {
            Surface::Plane(s) => {
                self.numbers(s.origin.iter().chain(s.x.iter()).chain(s.y.iter()));
                s.domain.iter().for_each(|i| self.interval(*i));
                s.extents.iter().for_each(|i| self.interval(*i));
            }
            Surface::Revolution(s) => {
                self.numbers(s.origin.iter().chain(s.axis.iter()));
                self.interval(s.angle);
                self.interval(s.angle_domain);
                self.curve(&s.profile);
                self.flag(s.transposed);
            }
            Surface::Sum(s) => {
                self.numbers(s.base.iter());
                self.curve(&s.first);
                self.curve(&s.second);
            }
            Surface::Nurbs(s) => {
                self.knots(s.knots_u());
                self.knots(s.knots_v());
                s.control_net().iter().for_each(|p| self.numbers(p.iter()));
            }
        }
    }
}
