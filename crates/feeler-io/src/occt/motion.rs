//! Locations: products of placements and their powers.
//!
//! A location is a word in the placements of the file's table, kept reduced (neighbours of the same placement
//! are one power, powers of 0 are gone): two locations are the same if their words are. So does OCCT compare them
//! when it looks for the curve of an edge on a face.
//!
//! Most are rigid motions. Those that scale evenly or mirror, which OCCT makes no more, are taken as what they are, maps of space: surfaces and curves are mapped, their parameters stay,
//! and faces that are mirrored are reversed where they were not. Others are refused.

use super::error::TextProblem;
use super::tokens::Tokens;
use crate::affine::{Affine, MapError, composed};
use crate::error::ReadError;
use crate::sheets::ROUNDING;
use feeler::nurbs::{Curve3, Surface};
use nalgebra::{Matrix3, Point3, Vector3, Vector4};
use std::collections::HashMap;

/// `x -> rotation x + translation`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Motion {
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
}

impl Motion {
    pub(crate) fn identity() -> Self {
        Self {
            rotation: Matrix3::identity(),
            translation: Vector3::zeros(),
        }
    }

    pub(crate) fn is_identity(&self) -> bool {
        *self == Self::identity()
    }

    pub(crate) fn vector(&self, v: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * v
    }

    pub(crate) fn point(&self, p: &Point3<f64>) -> Point3<f64> {
        Point3::from(self.rotation * p.coords + self.translation)
    }

    pub(crate) fn homogeneous(&self, p: &Vector4<f64>) -> Vector4<f64> {
        let moved = self.rotation * p.xyz() + self.translation * p.w;
        Vector4::new(moved.x, moved.y, moved.z, p.w)
    }

    /// First `other`, then this.
    fn after(&self, other: &Self) -> Self {
        Self {
            rotation: self.rotation * other.rotation,
            translation: self.rotation * other.translation + self.translation,
        }
    }

    /// `None`: there is none.
    fn inverse(&self) -> Option<Self> {
        let back = if self.is_rigid() {
            self.rotation.transpose()
        } else {
            self.rotation.try_inverse()?
        };
        Some(Self {
            rotation: back,
            translation: -(back * self.translation),
        })
    }

    /// The largest number that its matrix times the transposed one differs from `square` times the identity by.
    fn off(&self, square: f64) -> f64 {
        (self.rotation * self.rotation.transpose() - Matrix3::identity() * square).amax()
    }

    /// Whether lengths and angles stay what they are, up to the rounding of what a file prints, and it does not mirror.
    pub(crate) fn is_rigid(&self) -> bool {
        self.off(1.0) <= ROUNDING && !self.mirrors()
    }

    pub(crate) fn mirrors(&self) -> bool {
        self.rotation.determinant() < 0.0
    }

    /// Why no circle would stay one: angles change, by more than the rounding of what a file prints.
    fn defect(&self) -> Option<String> {
        let square = (self.rotation * self.rotation.transpose()).trace() / 3.0;
        let off = self.off(square) / square;
        // No number is none, too.
        (!(off <= ROUNDING)).then(|| {
            format!("it scales unevenly or shears: it changes squared lengths by up to {off:?} of themselves")
        })
    }

    fn affine(&self) -> Result<Affine, TextProblem> {
        let (r, t) = (&self.rotation, &self.translation);
        #[rustfmt::skip]
        let rows = [
            r[(0, 0)], r[(0, 1)], r[(0, 2)], t[0],
            r[(1, 0)], r[(1, 1)], r[(1, 2)], t[1],
            r[(2, 0)], r[(2, 1)], r[(2, 2)], t[2],
            0.0, 0.0, 0.0, 1.0,
        ];
        Affine::from_rows(&rows).ok_or_else(|| TextProblem::Shape {
            what: "a location has a number that is not finite".into(),
        })
    }

    /// A surface under a motion that is not rigid.
    pub(crate) fn surface(&self, surface: &Surface) -> Result<Surface, TextProblem> {
        self.affine()?.surface(surface).map_err(refusal)
    }

    /// A curve under a motion that is not rigid.
    pub(crate) fn curve(&self, curve: &Curve3) -> Result<Curve3, TextProblem> {
        self.affine()?.curve(curve).map_err(refusal)
    }
}

fn refusal(error: MapError) -> TextProblem {
    match error {
        MapError::Geometry(source) => TextProblem::Geometry {
            what: "what a location places",
            source,
        },
        other => TextProblem::Shape {
            what: other.to_string(),
        },
    }
}

/// A reduced word: placements and their powers, the leftmost applied last.
type Word = Vec<(usize, i64)>;

/// The longest word, and the largest power.
const MAX_WORD: usize = 64;
const MAX_POWER: i64 = 64;

/// `a b`, reduced.
fn product(a: &[(usize, i64)], b: &[(usize, i64)]) -> Word {
    let mut word = a.to_vec();
    for &(placement, power) in b {
        match word.last_mut() {
            Some((last, p)) if *last == placement => {
                *p += power;
                if *p == 0 {
                    word.pop();
                }
            }
            _ => word.push((placement, power)),
        }
    }
    word
}

fn inverse(word: &[(usize, i64)]) -> Word {
    word.iter().rev().map(|(i, p)| (*i, -p)).collect()
}

fn bounded(word: Word) -> Result<Word, TextProblem> {
    if word.iter().any(|(_, p)| p.abs() > MAX_POWER) {
        return Err(TextProblem::Limit {
            what: "powers of a location",
            limit: MAX_POWER as usize,
        });
    }
    if word.len() > MAX_WORD {
        return Err(TextProblem::Limit {
            what: "factors of a location",
            limit: MAX_WORD,
        });
    }
    Ok(word)
}

/// A location, by its number among those met so far; 0 is the identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Place(usize);

impl Place {
    pub(crate) const HERE: Self = Self(0);
}

/// All locations: those of the file's table, and products met since.
pub(crate) struct Places {
    /// The file's placements with their numbers in the table.
    placements: Vec<(usize, Motion)>,
    /// The file's table.
    table: Vec<Place>,
    words: Vec<Word>,
    numbers: HashMap<Word, Place>,
    motions: Vec<Motion>,
    products: HashMap<(Place, Place), Place>,
}

impl Places {
    pub(super) fn read(t: &mut Tokens<'_>) -> Result<Self, ReadError> {
        let mut places = Self {
            placements: Vec::new(),
            table: Vec::new(),
            words: Vec::new(),
            numbers: HashMap::new(),
            motions: Vec::new(),
            products: HashMap::new(),
        };
        places.number(Word::new());
        t.expect("the table of locations", "Locations")?;
        let count = t.count("locations", 2)?;
        for i in 0..count {
            let word = match t.word("the kind of a location")? {
                b"1" => {
                    let m = t.numbers::<12>("a location's matrix")?;
                    places.placements.push((
                        i + 1,
                        Motion {
                            rotation: Matrix3::new(
                                m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10],
                            ),
                            translation: Vector3::new(m[3], m[7], m[11]),
                        },
                    ));
                    vec![(places.placements.len() - 1, 1)]
                }
                b"2" => {
                    let mut word = Word::new();
                    while let Some(factor) = t.optional_index("location", places.table.len())? {
                        let power = t.integer("the power of a location")?;
                        let factor = places.word(places.table[factor]);
                        word = power_of(&factor, power)
                            .and_then(|f| bounded(product(&f, &word)))
                            .map_err(|problem| t.fail(problem))?;
                    }
                    word
                }
                other => return Err(t.unexpected("the kind of a location", other, "1 or 2")),
            };
            let place = places.number(word);
            places.table.push(place);
        }
        Ok(places)
    }

    /// The number of locations in the file's table.
    pub(crate) fn count(&self) -> usize {
        self.table.len()
    }

    /// Reads a location by its number in the table.
    pub(super) fn reference(&self, t: &mut Tokens<'_>) -> Result<Place, ReadError> {
        let index = t.optional_index("location", self.count())?;
        Ok(index
            .and_then(|i| self.table.get(i).copied())
            .unwrap_or(Place::HERE))
    }

    fn word(&self, place: Place) -> Word {
        self.words.get(place.0).cloned().unwrap_or_default()
    }

    fn number(&mut self, word: Word) -> Place {
        if let Some(place) = self.numbers.get(&word) {
            return *place;
        }
        let mut motion = Motion::identity();
        for (placement, power) in &word {
            let Some((_, m)) = self.placements.get(*placement) else {
                continue;
            };
            // One without an inverse is refused where it is used.
            let step = match power {
                ..0 => m.inverse().unwrap_or_else(Motion::identity),
                _ => m.clone(),
            };
            for _ in 0..power.unsigned_abs() {
                motion = motion.after(&step);
            }
        }
        let place = Place(self.words.len());
        self.motions.push(motion);
        self.words.push(word.clone());
        self.numbers.insert(word, place);
        place
    }

    /// `a b`: first b, then a.
    pub(crate) fn product(&mut self, a: Place, b: Place) -> Result<Place, TextProblem> {
        if a == Place::HERE || b == Place::HERE {
            return Ok(if a == Place::HERE { b } else { a });
        }
        if let Some(place) = self.products.get(&(a, b)) {
            return Ok(*place);
        }
        let word = bounded(product(&self.word(a), &self.word(b)))?;
        let place = self.number(word);
        self.products.insert((a, b), place);
        Ok(place)
    }

    /// `a^-1 b`.
    pub(crate) fn relative(&mut self, a: Place, b: Place) -> Result<Place, TextProblem> {
        if a == b {
            return Ok(Place::HERE);
        }
        let inverse = self.number(inverse(&self.word(a)));
        self.product(inverse, b)
    }

    /// The motion of a location.
    ///
    /// # Errors
    /// One of its placements scales unevenly or shears.
    pub(crate) fn motion(&self, place: Place) -> Result<&Motion, TextProblem> {
        for (placement, _) in self.words.get(place.0).into_iter().flatten() {
            if let Some((location, motion)) = self.placements.get(*placement)
                && let Some(why) = motion.defect()
            {
                return Err(TextProblem::Uneven {
                    location: *location,
                    why,
                });
            }
        }
        let identity = TextProblem::Reference {
            what: "location",
            found: -1,
            count: self.words.len(),
        };
        self.motions.get(place.0).ok_or(identity)
    }
}

impl Places {
    /// The same as a map that knows of how many it is a product; `None`: nothing moves.
    ///
    /// # Errors
    /// As of [`motion`](Self::motion), or a number that is not finite.
    pub(super) fn affine(&self, place: Place) -> Result<Option<Affine>, TextProblem> {
        self.motion(place)?;
        let mut whole: Option<Affine> = None;
        for (placement, power) in self.words.get(place.0).into_iter().flatten() {
            let Some((_, m)) = self.placements.get(*placement) else {
                continue;
            };
            let step = match power {
                ..0 => m
                    .inverse()
                    .unwrap_or_else(Motion::identity)
                    .affine()?
                    .rounded(),
                _ => m.affine()?,
            };
            for _ in 0..power.unsigned_abs() {
                whole = composed(whole.as_ref(), Some(&step));
            }
        }
        Ok(whole)
    }
}

fn power_of(word: &[(usize, i64)], power: i64) -> Result<Word, TextProblem> {
    if power.abs() > MAX_POWER {
        return bounded(vec![(0, power)]);
    }
    let base = if power < 0 {
        inverse(word)
    } else {
        word.to_vec()
    };
    if let &[(placement, p)] = &base[..] {
        // p is bounded, so is the product.
        return bounded(if power == 0 {
            Word::new()
        } else {
            vec![(placement, p * power.abs())]
        });
    }
    let mut result = Word::new();
    for _ in 0..power.unsigned_abs() {
        result = bounded(product(&result, &base))?;
    }
    Ok(result)
}
