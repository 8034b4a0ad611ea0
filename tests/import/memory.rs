//! How much memory reading takes, whatever a file claims. A test binary of its own, as the
//! allocator counts for all threads.

#[allow(dead_code, unreachable_pub)]
mod fixture;

mod random;

use feeler::prepare::trim_offsets;
use feeler_io::{Document, ObjectKind, ReadError, read_3dm, read_brep, read_step};
use peak_alloc::PeakAlloc;
use random::Random;
use std::path::Path;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Bytes in memory for each byte of a .3dm file, at most. The densest: a missing curve takes 4 bytes in a
/// file and 16 in the table of places, doubled while that grows; a trim of 132 bytes becomes about 300.
const FACTOR: usize = 16;

/// The same of a .brep file. Parts of the thesis take 4 to 11; a control point of zeros takes
/// six bytes and is kept twice, as four numbers in vectors that double.
const BREP_FACTOR: usize = 64;

/// The same of a STEP file. Attributes of two bytes take 32 in a list that doubles; curves in uv that are fitted, and the proof of how far they are
/// from their edges, are in no file: parts of the corpus take up to 19.
const STEP_FACTOR: usize = 64;

/// And what every document takes; of STEP files nothing is left uncounted.
const FIXED: usize = 1 << 16;
const STEP_FIXED: usize = 0;

fn peak(read: fn(&[u8]) -> Result<Document, ReadError>, bytes: &[u8]) -> usize {
    ALLOCATOR.reset_peak_usage();
    let before = ALLOCATOR.current_usage();
    drop(read(bytes));
    ALLOCATOR.peak_usage().saturating_sub(before)
}

/// Bytes in memory for each byte of the file.
fn taken(read: fn(&[u8]) -> Result<Document, ReadError>, bytes: &[u8], factor: usize) -> f64 {
    within(read, bytes, factor, FIXED)
}

/// The same of a STEP file.
fn taken_by_step(bytes: &[u8]) -> f64 {
    within(read_step, bytes, STEP_FACTOR, STEP_FIXED)
}

fn within(
    read: fn(&[u8]) -> Result<Document, ReadError>,
    bytes: &[u8],
    factor: usize,
    fixed: usize,
) -> f64 {
    let used = peak(read, bytes);
    assert!(
        used <= factor * bytes.len() + fixed,
        "{used} bytes for a file of {}",
        bytes.len()
    );
    used as f64 / bytes.len() as f64
}

fn check(bytes: &[u8]) {
    taken(read_3dm, bytes, FACTOR);
}

fn check_brep(bytes: &[u8]) -> f64 {
    taken(read_brep, bytes, BREP_FACTOR)
}

/// One test, as the allocator counts for all threads.
#[test]
fn memory_stays_within_a_multiple_of_the_file() {
    of_3dm();
    of_blocks();
    of_nested_copies();
    of_brep();
    of_step();
    of_tiny_step_files();
    of_proofs();
}

fn of_3dm() {
    let bytes = fixture::file(60, |w| {
        w.record("sheet", fixture::BREP, fixture::brep);
        w.record("sum", fixture::SUM, fixture::sum);
        w.record("net", fixture::NURBS_SURFACE, fixture::nurbs_surface);
        w.record("chain", fixture::POLY_CURVE, fixture::poly_curve);
    });
    check(&bytes);
    for at in 0..bytes.len() - 4 {
        for wild in [i32::MAX, 0x0FFF_FFFF, 1 << 16, 1 << 10] {
            let mut damaged = bytes.clone();
            damaged[at..at + 4].copy_from_slice(&wild.to_le_bytes());
            check(&damaged);
        }
    }
    // A list that is nothing but missing curves.
    let missing = fixture::file(60, |w| {
        w.record("", fixture::BREP, |w| {
            w.u8(0x33);
            w.chunk(fixture::ANONYMOUS, |w| {
                w.u8(0x10);
                w.i32_array(&vec![0; 1 << 20]);
            });
        });
    });
    check(&missing);
}

/// With extrusions and blocks.
const PLACED_FACTOR: usize = 64;

fn of_blocks() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpora/models/3dm");
    for name in ["extrusions.3dm", "blocks.3dm", "modes.3dm"] {
        let bytes = std::fs::read(folder.join(name)).expect("a file of the corpus");
        let factor = taken(read_3dm, &bytes, PLACED_FACTOR);
        println!("{name}: {factor:.1} bytes a byte");
    }
}

/// Parts placed by parts that are placed twice, and so on: 2^14 copies, which are told one by one and take no memory.
fn of_nested_copies() {
    const LEVELS: u8 = 14;
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpora/models");
    let blocks = fixture::nested_blocks(LEVELS, false);
    let brep = nested_compounds(LEVELS);
    let step = nested_assemblies(&models.join("step/torus_bare.step"), LEVELS);
    for (name, bytes, read) in [
        (".3dm", &blocks[..], read_3dm as fn(&[u8]) -> _),
        (".brep", brep.as_bytes(), read_brep),
        (".step", step.as_bytes(), read_step),
    ] {
        let factor = within(read, bytes, PLACED_FACTOR, 0);
        let document: Document = read(bytes).expect("a document");
        ALLOCATOR.reset_peak_usage();
        let before = ALLOCATOR.current_usage();
        let (count, faces) = document
            .bodies()
            .fold((0, 0), |(n, f), (_, b)| (n + 1, f + b.faces().len()));
        let used = ALLOCATOR.peak_usage().saturating_sub(before);
        println!(
            "2^{LEVELS} copies in a {name} of {} bytes: {factor:.1} bytes a byte, and {used} bytes while they are told",
            bytes.len()
        );
        assert_eq!(count, 1 << LEVELS, "{name}");
        assert_eq!(faces % count, 0, "{name}");
        assert!(used <= PLACED_FACTOR * bytes.len(), "{name}: {used}");
    }
}

/// A ball in a compound, in compounds that hold the one before twice, shifted the second time.
fn nested_compounds(levels: u8) -> String {
    let mut text = format!("CASCADE Topology V1, (c) Matra-Datavision\nLocations {levels}\n");
    for k in 0..levels {
        text += &format!("1\n1 0 0 {}\n0 1 0 0\n0 0 1 0\n", 1 << k);
    }
    let shapes = usize::from(levels) + 2;
    text += &format!(
        "Curve2ds 0\nCurves 0\nPolygon3D 0\nPolygonOnTriangulations 0\nSurfaces 1\n\
         4 0 0 0 0 0 1 1 0 0 0 1 0 1\nTriangulations 0\nTShapes {shapes}\n\
         Fa\n0 1e-07 1 0\n\n0101100\n*\nCo\n1100000\n+{shapes} 0 *\n"
    );
    for k in 0..levels {
        // Shapes are counted from the last one.
        let before = shapes - usize::from(k) - 1;
        text += &format!("Co\n1100000\n+{before} 0 +{before} {} *\n", k + 1);
    }
    text + "+1 0\n"
}

/// A STEP file's body in assemblies that hold the one before twice, shifted the second time.
fn nested_assemblies(part: &Path, levels: u8) -> String {
    let text = std::fs::read_to_string(part).expect("a file of the corpus");
    let is_body = |l: &&str| l.contains("MANIFOLD_SOLID_BREP(");
    let body = text.lines().find(is_body).expect("a body");
    let body = body.split_once('=').expect("an entity").0.trim();
    let mut more = String::from(
        "#90001=CARTESIAN_POINT('',(0.,0.,0.));#90002=AXIS2_PLACEMENT_3D('',#90001,$,$);",
    );
    more += &format!("#90010=REPRESENTATION('',(#90002,{body}),$);");
    for k in 0..u32::from(levels) {
        let id = 90_010 + 10 * (k + 1);
        let within = id - 10;
        more += &format!(
            "#{}=CARTESIAN_POINT('',({}.,0.,0.));#{}=AXIS2_PLACEMENT_3D('',#{},$,$);\
             #{}=REPRESENTATION_MAP(#90002,#{within});#{}=MAPPED_ITEM('',#{},#90002);\
             #{}=MAPPED_ITEM('',#{},#{});#{id}=REPRESENTATION('',(#{},#{}),$);",
            id + 1,
            1 << k,
            id + 2,
            id + 1,
            id + 3,
            id + 4,
            id + 3,
            id + 5,
            id + 3,
            id + 2,
            id + 4,
            id + 5,
        );
    }
    // The file's own representation of the body goes.
    let own: Vec<&str> = { text.lines() }
        .filter(|l| !l.contains("SHAPE_REPRESENTATION("))
        .collect();
    let end = "ENDSEC;\nEND-ISO";
    let own = own.join("\n");
    assert!(own.contains(end));
    own.replacen(end, &format!("{more}\n{end}"), 1)
}

fn of_brep() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpora/models/thesis");
    for part in [
        "cylinder.brep",
        "ball_nurbs_periodic.brep",
        "ball_joint_cavity_nurbs.brep",
        "geneva4_wheel.brep",
    ] {
        let text = std::fs::read_to_string(folder.join(part)).expect("a file of the corpus");
        println!("{part}: {:.1} bytes a byte", check_brep(text.as_bytes()));
        let words: Vec<&str> = text.split_inclusive(char::is_whitespace).collect();
        let step = 1 + words.len() / 120;
        for at in (0..words.len()).step_by(step) {
            for wild in ["1 ", "100 ", "1000 ", "40.5 "] {
                let mut words = words.clone();
                words[at] = wild;
                check_brep(words.concat().as_bytes());
            }
        }
    }
    // Tables of nothing but the shortest entries.
    let rest = "Polygon3D 0\nPolygonOnTriangulations 0\nSurfaces 0\nTriangulations 0\nTShapes 1\nCo\n0000000\n*\n+1 0\n";
    let lines = "1 0 0 0 0\n".repeat(20_000);
    let head = "CASCADE Topology V1, (c) Matra-Datavision\n";
    check_brep(format!("{head}Locations 0\nCurve2ds 20000\n{lines}Curves 0\n{rest}").as_bytes());
    let knots = "0 2 ".to_owned() + &(1..2000).map(|k| format!("{k} 1 ")).collect::<String>();
    let points = "0 0 ".repeat(2000);
    let spline = format!("7 0 1 1 1999 2000 {}{knots}\n", &points[4..]);
    check_brep(format!("{head}Locations 0\nCurve2ds 1\n{spline}Curves 0\n{rest}").as_bytes());
    let locations: String = (2..2000)
        .map(|i| format!("2 {i} 1 1 {} 0\n", 1 + i % 7))
        .collect();
    let first = "1\n1 0 0 1\n0 1 0 0\n0 0 1 0\n".repeat(2);
    check_brep(
        format!("{head}Locations 2000\n{first}{locations}Curve2ds 0\nCurves 0\n{rest}").as_bytes(),
    );
}

/// A body of one face with one circle, where what is listed is listed so often.
fn tiny_step(
    [bodies, bounds, edges, blanks]: [usize; 4],
    face: &str,
    circle: &str,
    end: &str,
) -> String {
    let list = |of: &str, count: usize| vec![of; count].join(",");
    format!(
        "ISO-10303-21;HEADER;ENDSEC;DATA;#1=REPRESENTATION('',({}),$);#2=MANIFOLD_SOLID_BREP('',#3);\
         #3=ADVANCED_FACE('',({}),#10,.T.);#4=FACE_BOUND('',#5,.T.);#5=EDGE_LOOP('',({}));#6=ORIENTED_EDGE('',*,*,#7,.T.);\
         #7=EDGE_CURVE('',#8,#9,#11,.T.);#8=VERTEX_POINT('',#12);#9=VERTEX_POINT('',#13);#12=CARTESIAN_POINT('',(0.,2.,1.E-6));\
         #13=CARTESIAN_POINT('',({end}));#14=CARTESIAN_POINT('',(0.,1.,0.));#23=DIRECTION('',(0.,0.,1.));\
         #25=AXIS2_PLACEMENT_3D('',#14,#23,$);#10={face};#11={circle};#16=NOTHING({});ENDSEC;END-ISO-10303-21;",
        list("#2", bodies),
        list("#4", bounds),
        list("#6", edges),
        ",".repeat(blanks),
    )
}

/// What a file lists as a set is in it once, however often it is said: a body of a representation, a bound of a face.
fn of_tiny_step_files() {
    let (cylinder, sphere) = (
        "CYLINDRICAL_SURFACE('',#25,3.)",
        "SPHERICAL_SURFACE('',#25,3.)",
    );
    let plane = "PLANE('',#25)";
    let cone = "CONICAL_SURFACE('',#25,1.E-12,.5)";
    let near = "1.,0.,0.";
    for (name, counts, face, radius, end) in [
        ("a body 50 times", [50, 1, 1, 0], cylinder, "3.", near),
        ("a bound 300 times", [1, 300, 1, 0], cylinder, "1.", near),
        ("a bound 50 times", [1, 50, 1, 0], plane, "1.E-12", near),
        ("a bound 1000 times", [1, 1000, 1, 0], sphere, "2.", near),
        ("an edge three times", [1, 1, 3, 0], sphere, "2.", near),
        (
            "an edge three times, far off",
            [1, 1, 3, 0],
            sphere,
            "2.",
            "-1.,1.E9,1.E9",
        ),
        // Each place where a loop jumps was a line of the report, kept twice.
        ("an edge that jumps", [1, 1, 50, 0], plane, "1.E-300", near),
        // Beside each use lies a straight one, along a pole.
        ("an edge at a pole", [1, 1, 50, 0], cone, "1.E-300", near),
        ("blanks", [1, 1, 1, 512], plane, "1.", near),
        ("more blanks", [1, 1, 1, 1000], plane, "1.", near),
    ] {
        let circle = format!("CIRCLE('',#25,{radius})");
        let text = tiny_step(counts, face, &circle, end);
        let used = peak(read_step, text.as_bytes());
        println!(
            "{name}: {:.1} bytes a byte",
            used as f64 / text.len() as f64
        );
        taken_by_step(text.as_bytes());
    }
    let text = tiny_far().replacen("DATA;", &format!("DATA;{UNUSED}"), 1);
    let text = text.replacen("(0.,2.,1.E-6)", "(-0.,2.,1.E-6)", 1);
    let factor = taken_by_step(text.as_bytes());
    println!(
        "an edge three times, far off, {} bytes: {factor:.1} bytes a byte",
        text.len()
    );
}

/// What a proof may take beside the bytes that it is given: the lists of what is asked for.
const PROOF_FIXED: usize = 1 << 10;

/// The proof of how far an image is off takes no more memory than it is given, work included: files of any size are read by that.
fn of_proofs() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpora/models/step");
    let far = tiny_far();
    for part in PROVEN {
        let bytes = match part {
            "" => far.clone().into_bytes(),
            name => std::fs::read(folder.join(name)).expect("a file of the corpus"),
        };
        let document = read_step(&bytes).expect("a document");
        let mut most = 0;
        for object in &document.objects {
            let ObjectKind::Brep(brep) = &object.kind else {
                continue;
            };
            for (trim, t) in brep.parts().trims.iter().enumerate() {
                if t.edge.is_none() {
                    continue;
                }
                for room in (8..22).map(|e| 1 << e) {
                    ALLOCATOR.reset_peak_usage();
                    let before = ALLOCATOR.current_usage();
                    let found = trim_offsets(brep, &[trim], room);
                    let used = ALLOCATOR.peak_usage().saturating_sub(before);
                    most = most.max(used.saturating_sub(room));
                    assert!(
                        used <= room + PROOF_FIXED,
                        "{part}, trim {trim}: {used} bytes of {room}"
                    );
                    if found.iter().all(|o| o.at_most.is_finite()) {
                        break;
                    }
                }
            }
        }
        println!("proofs of {part}: {most} bytes more than given at most");
    }
}

/// Files whose edges the kernel can be asked about on surfaces of each kind; the last is a [file](tiny_step) of an edge three times, far off.
const PROVEN: [&str; 6] = [
    "filleted_bare.step",
    "bored_nurbs.step",
    "bored_nurbs_bare.step",
    "revolution_part_bare.step",
    "torus_bare.step",
    "",
];

/// An edge three times on a sphere, with a point far off.
fn tiny_far() -> String {
    let (face, circle) = ("SPHERICAL_SURFACE('',#25,3.)", "CIRCLE('',#25,2.)");
    tiny_step([1, 1, 3, 0], face, circle, "-1.,1.E9,1.E9")
}

/// What nothing uses: with more bytes a proof has more room.
const UNUSED: &str = "#15=CARTESIAN_POINT('',(1.,1.,.1));#22=VECTOR('',#23,1.);#24=AXIS1_PLACEMENT('',#12,#23);\
                      #21=DIRECTION('',(-1.,1.E9,1.E9));#20=VECTOR('',#21,1.);";

fn of_step() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpora/models/step");
    // The first has the most curves that are fitted for its size.
    for part in [
        "bored_nurbs_bare.step",
        "bored_bare.step",
        "assembly_bare.step",
        "revolution_part_bare.step",
        "drilled_torus_bare.step",
        "ball_and_cone_bare.step",
    ] {
        let bytes = std::fs::read(folder.join(part)).expect("a file of the corpus");
        let factor = taken_by_step(&bytes);
        println!("{part}: {factor:.1} bytes a byte");
    }
    // A rim that is tilted a little: the curve made for it on the torus is composed in thousands of parts, if it is.
    let text =
        std::fs::read_to_string(folder.join("torus_bare.step")).expect("a file of the corpus");
    let tilted = text.replacen("-0.195698421916", "-0.175698421916", 1);
    assert_ne!(text, tilted);
    let factor = taken_by_step(tilted.as_bytes());
    println!("a tilted rim: {factor:.1} bytes a byte");
    // One edge, listed over and over at a few bytes: fitted to the tilted rim, and straight.
    for text in [&tilted, &text] {
        for count in [100, 1000, 10_000] {
            let often = text.replacen("(#20,#29,", &format!("({}", "#29,".repeat(count)), 1);
            assert_ne!(text, &often);
            let factor = taken_by_step(often.as_bytes());
            println!("an edge {count} times in a loop: {factor:.1} bytes a byte");
        }
    }
    // Splines, too: each loop's first edge a thousand times.
    for part in ["bored_bare.step", "bored_nurbs.step"] {
        let text = std::fs::read_to_string(folder.join(part)).expect("a file of the corpus");
        let mut most: f64 = 0.0;
        for (at, head) in text.match_indices("EDGE_LOOP('',(") {
            let (before, list) = text.split_at(at + head.len());
            let first = &list[..=list.find([',', ')']).expect("an edge")];
            let first = first.replace(')', ",");
            let often = format!("{before}{}{list}", first.repeat(1000));
            most = most.max(taken_by_step(often.as_bytes()));
        }
        println!("{part} with an edge 1000 times in a loop: {most:.1} bytes a byte");
    }
    // The tilted rim beside entities that take much for their bytes.
    for count in [300, 1000, 3000, 10_000] {
        let blanks = format!("DATA;#9999=A({}$);", "$,".repeat(count));
        let factor = taken_by_step(tilted.replacen("DATA;", &blanks, 1).as_bytes());
        println!("a tilted rim beside {count} blanks: {factor:.1} bytes a byte");
    }
    of_wrong_numbers(&folder);
    of_splines();
    of_faces();
    of_rims();
    let text = std::fs::read_to_string(folder.join("cylinder.step")).expect("a file of the corpus");
    let words: Vec<&str> = text.split_inclusive(['(', ',', ')']).collect();
    let step = 1 + words.len() / 120;
    for at in (0..words.len()).step_by(step) {
        for wild in ["1,", "1000000000,", "#1,", "(((("] {
            let mut words = words.clone();
            words[at] = wild;
            taken_by_step(words.concat().as_bytes());
        }
    }
    // Nothing but the shortest attributes, entities and lists.
    let file =
        |data: &str| format!("ISO-10303-21;HEADER;ENDSEC;DATA;{data}ENDSEC;END-ISO-10303-21;");
    // One more than a power of two: the list has just doubled.
    let blank = format!("#1=A({}$);", "$,".repeat(1 << 15));
    let empty: String = (1..10_000).map(|i| format!("#{i}=A();")).collect();
    let nested = format!("#1=A({}$);", "((((($))))),".repeat(4000));
    let named = format!("#1=A({}$);", "A(1),".repeat(10_000));
    for data in [blank, empty, nested, named] {
        let factor = taken_by_step(file(&data).as_bytes());
        println!("{}...: {factor:.1} bytes a byte", &data[..16]);
    }
}

/// A face with one edge, as short as files can be. Entities 10 and 11, the surface and the curve, are those of `rest`; some that these may be made of are
/// there.
fn face(rest: &str) -> String {
    format!(
        "ISO-10303-21;HEADER;ENDSEC;DATA;#1=REPRESENTATION('',(#2),$);#2=MANIFOLD_SOLID_BREP('',#3);\
         #3=ADVANCED_FACE('',(#4),#10,.T.);#4=FACE_BOUND('',#5,.T.);#5=EDGE_LOOP('',(#6));\
         #6=ORIENTED_EDGE('',*,*,#7,.T.);#7=EDGE_CURVE('',#8,#9,#11,.T.);#8=VERTEX_POINT('',#12);\
         #9=VERTEX_POINT('',#13);#12=CARTESIAN_POINT('',(0.,0.,0.));#13=CARTESIAN_POINT('',(1.,0.,0.));\
         #14=CARTESIAN_POINT('',(0.,1.,0.));#15=CARTESIAN_POINT('',(1.,1.,.1));{rest}\
         ENDSEC;END-ISO-10303-21;"
    )
}

/// A list of `count` points, the first half one, the others another.
fn row(count: usize, [first, last]: [&str; 2]) -> String {
    let all = (0..count).map(|i| if 2 * i < count { first } else { last });
    format!("({})", all.collect::<Vec<_>>().join(","))
}

fn net([n, m]: [usize; 2]) -> String {
    let rows = (0..n).map(|i| row(m, [["#12", "#13"], ["#14", "#15"]][usize::from(2 * i >= n)]));
    let rows = rows.collect::<Vec<_>>().join(",");
    format!("#10=QUASI_UNIFORM_SURFACE('',1,1,({rows}),$,$,$,$);")
}

const LINE: &str = "#11=LINE('',#12,#20);#20=VECTOR('',#21,1.);#21=DIRECTION('',(1.,0.,0.));";
const UP: &str = "#22=VECTOR('',#23,1.);#23=DIRECTION('',(0.,0.,1.));#24=AXIS1_PLACEMENT('',#12,#23);\
                  #25=AXIS2_PLACEMENT_3D('',#14,#23,$);";

/// Splines whose points are named at three bytes each and whose knots are not written at all: what is looked up on them is much for their bytes.
fn of_splines() {
    let curve = |at: usize, n: usize, ends: [&str; 2]| {
        format!("#{at}=QUASI_UNIFORM_CURVE('',1,{},$,$,$);", row(n, ends))
    };
    let mut most: f64 = 0.0;
    let mut check = |rest: &[&str]| most = most.max(taken_by_step(face(&rest.concat()).as_bytes()));
    for n in [2, 3, 5, 9, 17, 33, 65, 129, 257, 1025, 4097] {
        let edges = [["#12", "#13"], ["#14", "#13"]].map(|ends| curve(11, n, ends));
        let [wide, square] = [[n, 2], [n.min(129); 2]].map(net);
        for edge in edges.iter().map(String::as_str).chain([LINE]) {
            for surface in [net([2, 2]), wide.clone(), square.clone()] {
                check(&[&surface, edge]);
            }
            let profile = curve(26, n, ["#12", "#15"]);
            for surface in [
                "#10=SURFACE_OF_LINEAR_EXTRUSION('',#26,#22);",
                "#10=SURFACE_OF_REVOLUTION('',#26,#24);",
            ] {
                check(&[UP, &profile, surface, edge]);
            }
            for surface in [
                "PLANE('',#25",
                "CYLINDRICAL_SURFACE('',#25,1.",
                "SPHERICAL_SURFACE('',#25,1.",
                "CONICAL_SURFACE('',#25,1.,.5",
            ] {
                check(&[UP, &format!("#10={surface});"), edge]);
            }
        }
    }
    // On a plane an image is looked at as Bezier pieces: of a high degree they have many points.
    for n in [25, 50] {
        let points = "#14,#14,#13,#12,#12,#13,#12,#15,".repeat(n / 2);
        let edge = format!("#11=QUASI_UNIFORM_CURVE('',8,({points}#12),$,$,$);");
        let flat = face(&[UP, "#10=PLANE('',#25);", &edge].concat());
        let flat = flat.replacen("(1.,1.,.1)", "(1.,1.,0.)", 1);
        most = most.max(taken_by_step(flat.as_bytes()));
    }
    // And that of a circle across it is a spline, for each use.
    let circle = "#11=CIRCLE('',#35,.5);#35=AXIS2_PLACEMENT_3D('',#31,#32,#23);#31=CARTESIAN_POINT('',(1.E9,1.,0.));\
                  #32=DIRECTION('',(0.,1.,1.E-9));";
    let across = face(&[UP, "#10=PLANE('',#25);", circle].concat());
    let across = across.replacen("(0.,0.,1.)", "(0.,1.E-6,3.)", 1);
    let across = across.replacen("(#6)", &format!("({}#6)", "#6,".repeat(300)), 1);
    most = most.max(taken_by_step(across.as_bytes()));
    // An edge that is split at a pole over and over.
    let split = "#26=QUASI_UNIFORM_CURVE('',3,(#12,#12,#12,#12,#13,#15,#14,#12),$,$,$);\
                 #10=SURFACE_OF_REVOLUTION('',#26,#24);\
                 #11=(BOUNDED_CURVE()B_SPLINE_CURVE(3,(#13,#13,#12,#12,#12,#12,#12,#12),.U.,.F.,.F.)B_SPLINE_CURVE_WITH_KNOTS((4,1,2,1,4),(-1.0,999999999.0,1999999999.0,2999999999.0,3999999999.0),.U.)CURVE()GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_CURVE((6.28318530718,1.,1.,1.,1.,1.,1.,1.E16))REPRESENTATION_ITEM(''));";
    let often = face(&[UP, split].concat());
    let often = often.replacen("(0.,0.,0.)", "(2.,1.E9,1.0000000000000002)", 1);
    let faces = "#40=ADVANCED_FACE('',(#4),#10,.T.);#41=ADVANCED_FACE('',(#4),#10,.T.);#42=ADVANCED_FACE('',(#4),#10,.T.);";
    let shell = format!("BREP('',#30);{faces}#30=OPEN_SHELL('',(#40,#41,#42,#3));");
    let often = often.replacen("BREP('',#3);", &shell, 1);
    most = most.max(taken_by_step(often.as_bytes()));
    println!("splines: {most:.1} bytes a byte");
}

/// Faces that a shell lists over and over; spheres and tori may have no edge in the file.
fn of_faces() {
    let mut most: f64 = 0.0;
    let nets = [2, 5, 9, 17, 33, 65].map(|n| net([n, n]));
    let others = [
        "#10=PLANE('',#25);",
        "#10=SPHERICAL_SURFACE('',#25,1.);",
        "#10=TOROIDAL_SURFACE('',#25,2.,1.);",
    ];
    for surface in nets.iter().map(String::as_str).chain(others) {
        for bounds in ["()", "(#4)"] {
            for count in [3, 10, 30, 100, 1000, 10_000] {
                let once = face(&[UP, surface, LINE].concat());
                let listed = "#3,".repeat(count);
                let shell = format!("SOLID_BREP('',#30);#30=OPEN_SHELL('',({listed}#3));");
                let often = once.replacen("SOLID_BREP('',#3);", &shell, 1);
                let often = often.replacen("FACE('',(#4)", &format!("FACE('',{bounds}"), 1);
                most = most.max(taken_by_step(often.as_bytes()));
            }
        }
    }
    println!("faces listed again: {most:.1} bytes a byte");
}

/// Circles on a torus that are tilted: what their curves in uv are off is proven in as many pieces as that may be.
fn of_rims() {
    let mut most: f64 = 0.0;
    for by in ["1.E-1", "1.E-2", "1.E-3", "1.E-4", "1.E-5", "1.E-6"] {
        for [major, minor] in [
            ["5.", "1."],
            ["5.", "1.E-2"],
            ["1.E3", "1."],
            ["1.", ".999"],
        ] {
            let rest = format!(
                "{UP}#10=TOROIDAL_SURFACE('',#25,{major},{minor});#11=CIRCLE('',#30,{minor});\
                 #30=AXIS2_PLACEMENT_3D('',#31,#32,#23);#31=CARTESIAN_POINT('',({major},1.,0.));\
                 #32=DIRECTION('',(0.,1.,{by}));"
            );
            // From the circle's top to itself.
            let once = face(&rest).replacen("#8,#9,", "#8,#8,", 1);
            let once = once.replacen("(0.,0.,0.)", &format!("({major},1.,{minor})"), 1);
            most = most.max(taken_by_step(once.as_bytes()));
        }
    }
    println!("tilted circles: {most:.1} bytes a byte");
}

/// Files of curved faces, small ones, with which most is made of each byte.
const CURVED: [&str; 12] = [
    "elliptic_cylinder_bare.step",
    "elliptic_cylinder_seamless.step",
    "revolution_bare.step",
    "revolution_seamless.step",
    "revolution_part_bare.step",
    "torus_bare.step",
    "torus_part_bare.step",
    "cone_bare.step",
    "frustum_bare.step",
    "cylinder_bare.step",
    "sphere_slice_bare.step",
    "extrusion_bare.step",
];

/// How many of each.
const WRONG_NUMBERS: usize = 96;

/// One number of a part's geometry is another: an axis is tilted, a curve is off its surface a little, a radius or a part of a domain is much
/// larger. What has no formula any more is fitted, and proven from its image, in as many parts as that may be.
fn of_wrong_numbers(folder: &Path) {
    let mut random = Random(7);
    for part in CURVED {
        let text = std::fs::read_to_string(folder.join(part)).expect("a file of the corpus");
        let words: Vec<&str> = text.split_inclusive(['(', ',', ')']).collect();
        let number = |w: &str| {
            let w = &w[..w.len() - 1];
            w.contains('.').then(|| w.parse::<f64>().ok()).flatten()
        };
        let numbers: Vec<(usize, f64)> = { words.iter().enumerate() }
            .filter_map(|(i, w)| Some((i, number(w)?)))
            .collect();
        let mut most: f64 = 0.0;
        for _ in 0..WRONG_NUMBERS {
            let (at, is) = numbers[random.below(numbers.len())];
            let by = [1e-5, 1e-3, 1e-2, 0.1][random.below(4)];
            let wrong = match random.below(6) {
                0 | 1 => is + by,
                2 | 3 => is - by,
                4 => is * [0.01, 0.5, 2.0, 1000.0][random.below(4)],
                _ => numbers[random.below(numbers.len())].1,
            };
            let word = words[at];
            let wrong = format!("{wrong:?}{}", &word[word.len() - 1..]);
            let mut words = words.clone();
            words[at] = &wrong;
            most = most.max(taken_by_step(words.concat().as_bytes()));
        }
        println!("{part} with wrong numbers: {most:.1} bytes a byte");
    }
}
