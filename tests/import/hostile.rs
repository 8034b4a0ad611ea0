//! Damage and malice: no input may panic, and damage must not pass for geometry.

use crate::classes::simple;
use crate::fixture::{self as f, Writer};
use feeler_io::{Document, MAX_DEPTH, ObjectKind, Problem, ReadError, read_3dm, read_file};

/// The files that are damaged: chunk lengths of 8 and of 4 bytes.
fn samples() -> [Vec<u8>; 2] {
    [60, 4].map(|version| f::file(version, simple))
}

/// The problem that an object was refused for.
fn refused(document: &Document, object: usize) -> &Problem {
    match &document.objects[object].kind {
        ObjectKind::Refused {
            reason: ReadError::Chunk { problem, .. },
            ..
        } => problem,
        other => panic!("object {object} is a {}", other.name()),
    }
}

/// A file with one object.
fn one(id: &str, data: impl Fn(&mut Writer)) -> Document {
    let bytes = f::file(60, |w| w.record("it", id, data));
    read_3dm(&bytes).expect("a file")
}

#[test]
fn a_truncated_file_is_an_error_that_names_the_place() {
    for bytes in samples() {
        for n in 0..bytes.len() {
            let error = read_3dm(&bytes[..n]).expect_err("a part of a file");
            let text = error.to_string();
            assert_eq!(text.lines().count(), 1);
            if n > 32 {
                assert!(
                    text.contains("byte ") && text.contains("truncated"),
                    "{text}"
                );
            }
        }
    }
}

/// Geometry is covered by checksums; what is not (chunk headers, the version, records that are one number)
/// must show in another way.
#[test]
fn a_flipped_bit_never_passes_for_geometry() {
    // Every bit of one sample, every fifth of the other.
    for (bytes, step) in samples().into_iter().zip([1, 5]) {
        let whole = read_3dm(&bytes).expect("a file");
        let (mut errors, mut refusals, mut noted, mut harmless) = (0, 0, 0, 0);
        for place in (0..8 * bytes.len()).step_by(step) {
            let mut damaged = bytes.clone();
            damaged[place / 8] ^= 1 << (place % 8);
            let Ok(document) = read_3dm(&damaged) else {
                errors += 1;
                continue;
            };
            let kinds = |d: &Document| d.objects.iter().map(|o| o.kind.clone()).collect::<Vec<_>>();
            if document
                .objects
                .iter()
                .any(|o| matches!(o.kind, ObjectKind::Refused { .. }))
            {
                // The others are as they were.
                assert_eq!(document.objects.len(), whole.objects.len(), "bit {place}");
                let pairs = document.objects.iter().zip(&whole.objects);
                let changed = pairs.filter(|(a, b)| a.kind != b.kind);
                let refused = changed.filter(|(a, _)| a.kind.name() != "refused").count();
                assert_eq!(refused, 0, "bit {place}");
                refusals += 1;
            } else if document.warnings.is_empty() {
                assert_eq!(kinds(&document), kinds(&whole), "bit {place}");
                harmless += 1;
            } else {
                noted += 1;
            }
        }
        eprintln!(
            "of {} bits flipped: {errors} errors, {refusals} refused objects, {noted} warnings, \
             {harmless} harmless",
            8 * bytes.len() / step
        );
        assert!(
            refusals > 2 * (errors + noted + harmless),
            "most are in objects"
        );
    }
}

/// Every i32 of the file in turn becomes a huge number, a negative one, and one that is just too large: no
/// panic, no endless loop. (`memory.rs` watches allocation.)
#[test]
fn wild_counts_are_refused() {
    let bytes = f::file(60, simple);
    for at in 0..bytes.len() - 4 {
        for wild in [i32::MAX, -1, i32::MIN, 1 << 16] {
            let mut damaged = bytes.clone();
            damaged[at..at + 4].copy_from_slice(&wild.to_le_bytes());
            let _ = read_3dm(&damaged);
        }
    }
}

/// Every number of the file in turn becomes a wild one, its checksum made to fit: what is read is
/// refused or valid, and valid geometry evaluates.
#[test]
fn wild_numbers_never_panic() {
    let wild = [
        (i32::MAX, f64::MAX),
        (i32::MIN, f64::MIN),
        (-1, f64::NAN),
        (0, 0.0),
        (1, f64::INFINITY),
        (2, 5e-324),
        (3, -1e-300),
        (4, 1e17),
    ];
    let (mut read, mut refused) = (0, 0);
    for value in wild {
        for place in 0.. {
            let Some(bytes) = f::with_wild(place, value, || f::file(60, simple)) else {
                break;
            };
            let Ok(document) = read_3dm(&bytes) else {
                continue;
            };
            for object in &document.objects {
                match &object.kind {
                    ObjectKind::Refused { .. } => refused += 1,
                    ObjectKind::Brep(brep) | ObjectKind::Surface(brep) => {
                        let [u, v] = brep.surface(0).domain();
                        brep.surface(0).point(u.mid(), v.mid());
                        read += 1;
                    }
                    ObjectKind::Curve(curve) => {
                        curve.point(curve.domain().mid());
                        read += 1;
                    }
                    _ => {}
                }
            }
        }
    }
    eprintln!("{read} objects read, {refused} refused");
    assert!(refused > 1000 && read > 10 * refused);
}

#[test]
fn counts_are_checked_before_anything_is_allocated() {
    let counted = |data: &dyn Fn(&mut Writer), id: &str| {
        let document = one(id, data);
        let problem = refused(&document, 0);
        assert!(matches!(problem, Problem::Count { .. }), "{problem}");
    };
    let huge = i32::MAX;
    counted(
        &|w| {
            w.u8(0x10);
            w.i32s(&[huge]);
        },
        f::POLYLINE,
    );
    counted(
        &|w| {
            w.u8(0x10);
            w.i32s(&[huge, 0, 0]);
        },
        f::POLY_CURVE,
    );
    counted(
        &|w| {
            w.u8(0x10);
            w.i32s(&[3, 0, 4, huge, 0, 0]);
        },
        f::NURBS_CURVE,
    );
    // Each count fits, their product does not.
    let surface = |w: &mut Writer| {
        w.u8(0x10);
        w.i32s(&[3, 0, 2, 2, 40, 40, 0, 0]);
        w.raw(&[0; 1000]);
    };
    counted(&surface, f::NURBS_SURFACE);
    for count in [huge, -1, 1000] {
        let list = |w: &mut Writer| {
            w.u8(0x33);
            w.chunk(f::ANONYMOUS, |w| {
                w.u8(0x10);
                w.i32s(&[count]);
                w.raw(&[0; 16]);
            });
        };
        counted(&list, f::BREP);
    }
}

fn nested(w: &mut Writer, levels: u32) {
    if levels == 0 {
        w.object(f::LINE, |w| f::line(w, [0.0; 3], [1.0; 3], [0.0, 1.0], 3));
        return;
    }
    w.object(f::POLY_CURVE, |w| {
        w.u8(0x10);
        w.i32s(&[1, 0, 0]);
        w.f64s(&[0.0; 6]);
        w.f64_array(&[0.0, 1.0]);
        nested(w, levels - 1);
    });
}

#[test]
fn deep_nesting_is_refused() {
    let poly = |levels: u32| {
        one(f::POLY_CURVE, move |w| {
            w.u8(0x10);
            w.i32s(&[1, 0, 0]);
            w.f64s(&[0.0; 6]);
            w.f64_array(&[0.0, 1.0]);
            nested(w, levels);
        })
    };
    assert_eq!(poly(8).objects[0].kind.name(), "curve");
    for levels in [MAX_DEPTH, 200] {
        let document = poly(levels);
        let problem = refused(&document, 0);
        assert!(matches!(problem, Problem::Depth { .. }), "{problem}");
    }
}

#[test]
fn junk_before_the_header_is_skipped_and_after_the_end_ignored() {
    let bytes = f::file(60, simple);
    let whole = read_3dm(&bytes).expect("a file");
    let wrapped = [b"3D Geometry junk".as_slice(), &bytes, b"more"].concat();
    let document = read_3dm(&wrapped).expect("a file");
    assert_eq!(document.warnings, Vec::<String>::new());
    for (a, b) in document.objects.iter().zip(&whole.objects) {
        assert_eq!(a.kind, b.kind);
    }
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    for x in bad {
        let line = one(f::LINE, |w| {
            f::line(w, [0.0; 3], [1.0, x, 1.0], [0.0, 1.0], 3)
        });
        refused(&line, 0);
        let domain = one(f::LINE, |w| f::line(w, [0.0; 3], [1.0; 3], [0.0, x], 3));
        refused(&domain, 0);
        refused(&one(f::PLANE, |w| f::plane(w, [0.0, x, 0.0, 1.0])), 0);
    }
}

fn message(bytes: &[u8]) -> String {
    match read_3dm(bytes) {
        Err(error) => error.to_string(),
        Ok(document) => match &document.objects[0].kind {
            ObjectKind::Refused { class, reason } => format!("{class}: {reason}"),
            other => panic!("read as a {}", other.name()),
        },
    }
}

#[test]
fn messages_name_the_place_and_the_remedy() {
    assert_eq!(message(b""), "the file is empty; export the model again");
    assert_eq!(
        message(b"solid cube\nfacet normal 0 0 1\n"),
        "not a .3dm file: no \"3D Geometry File Format\" header in its 30 bytes; export the model \
         as .3dm (version 3 to 8)"
    );
    assert_eq!(
        message(b"3D Geometry File Format        9"),
        "a .3dm file of version 9; versions 1 to 8 are read: open it in Rhino or with rhino3dm and \
         save it as one of these"
    );
    assert_eq!(
        message(b"3D Geometry File Format        1"),
        message(b"3D Geometry File Format       60")
    );
    assert_eq!(
        message(b"3D Geometry File Format       60"),
        "file: a chunk's typecode needs 4 bytes and 0 are left; the file is truncated or damaged: \
         copy or save it again (byte 32)"
    );
    // Where the class data starts.
    let class_data = |bytes: &[u8]| {
        let typecode = 0x0002_FFFC_u32.to_le_bytes();
        bytes
            .windows(4)
            .position(|w| w == typecode)
            .expect("class data")
    };
    let old = f::file(4, |w| w.record("", f::BREP, |w| w.u8(0x11)));
    let at = class_data(&old);
    assert_eq!(
        message(&old),
        format!(
            "Brep: class data 0x0002FFFC at byte {at}: Brep 1.1 is not read; save the file as version \
             3 or later (open it in Rhino or with rhino3dm) (byte {})",
            at + 8
        )
    );
    // Oblique on a surface of revolution: no curve that there is.
    let on_surface = f::file(4, |w| {
        w.record("", f::CURVE_ON_SURFACE, |w| {
            w.object(f::LINE, |w| {
                f::line(w, [0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0], 2)
            });
            w.i32s(&[0]);
            w.object(f::REV, |w| f::revolution(w, 0x20, 0));
        });
    });
    let at = class_data(&on_surface);
    assert_eq!(
        message(&on_surface),
        format!(
            "CurveOnSurface: class data 0x0002FFFC at byte {at}: CurveOnSurface cannot be used as a \
             curve; convert it to a NURBS curve (Rhino: ToNURBS) and save again (byte {at})"
        )
    );
    let mut damaged = f::file(4, |w| {
        w.record("", f::LINE, |w| {
            f::line(w, [0.0; 3], [1.0; 3], [0.0, 1.0], 3)
        });
    });
    let at = class_data(&damaged);
    damaged[at + 20] ^= 1;
    let text = message(&damaged);
    let start = format!("LineCurve: class data 0x0002FFFC at byte {at}: checksum 0x");
    // Two points, a domain and a dimension after the header and the layout version.
    let end = format!(
        "the file is damaged: copy or save it again (byte {})",
        at + 8 + 1 + 6 * 8 + 2 * 8 + 4
    );
    assert!(text.starts_with(&start) && text.ends_with(&end), "{text}");
}

#[test]
fn files_are_named() {
    let missing = read_file("no/such/part.3dm")
        .expect_err("no file")
        .to_string();
    assert!(missing.starts_with("no/such/part.3dm: "), "{missing}");
    let folder = read_file(std::env::temp_dir())
        .expect_err("a folder")
        .to_string();
    assert_eq!(folder.lines().count(), 1);
}

/// What a query takes grows with the turns of circles and of what is turned: over 32 they are refused wherever they stand, as the profile of an
/// extrusion too.
#[test]
fn many_turns_are_refused_wherever_they_stand() {
    type Write = fn(&mut Writer, f64);
    fn arc(w: &mut Writer, dim: i32, to: f64) {
        w.u8(0x10);
        w.f64s(&[0.0; 3]);
        w.f64s(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        w.f64s(&[0.0, 0.0, 1.0, 0.0, 1.0]);
        w.f64s(&[1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
        w.f64s(&[0.0, to, 0.0, 1.0]);
        w.i32s(&[dim]);
    }
    let places: [(&str, Write); 4] = [
        (f::ARC, |w, to| arc(w, 3, to)),
        (f::POLY_CURVE, |w, to| {
            w.u8(0x10);
            w.i32s(&[1, 0, 0]);
            w.f64s(&[0.0; 6]);
            w.f64_array(&[0.0, 1.0]);
            w.object(f::ARC, |w| arc(w, 3, to));
        }),
        (f::REV, |w, to| {
            w.u8(0x10);
            w.f64s(&[0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
            w.f64s(&[0.0, to]);
            w.f64s(&[0.0; 6]);
            w.i32s(&[0]);
            w.u8(1);
            let ends = [[1.0, 0.0, 0.0], [1.0, 0.0, 1.0]];
            w.object(f::LINE, |w| f::line(w, ends[0], ends[1], [0.0, 1.0], 3));
        }),
        (f::EXTRUSION, |w, to| {
            w.chunk(f::ANONYMOUS, |w| {
                w.i32s(&[1, 2]);
                w.object(f::ARC, |w| arc(w, 2, to));
                w.f64s(&[0.0, 0.0, 0.0, 0.0, 0.0, 3.0]);
                w.f64s(&[0.0, 1.0]);
                w.f64s(&[0.0, 1.0, 0.0]);
                w.raw(&[0, 0]);
                w.f64s(&[0.0; 6]);
                w.f64s(&[0.0, 1.0]);
                w.u8(0);
                w.i32s(&[1]);
                w.raw(&[1, 1]);
            });
        }),
    ];
    for (id, write) in places {
        let turn = std::f64::consts::TAU;
        for (to, is_read) in [(turn, true), (33.0 * turn, false), (522_133_279.0, false)] {
            let document = one(id, |w| write(w, to));
            let told = match &document.objects[0].kind {
                ObjectKind::Refused { reason, .. } => reason.to_string(),
                read => read.name().to_owned(),
            };
            assert_eq!(told.contains("32 turns at most"), !is_read, "{id}: {told}");
            assert_eq!(!told.contains("expected"), is_read, "{id}: {told}");
        }
    }
}
