"""Makes files of models/3dm that no program of today writes, byte by byte: BREPs of files of versions 1 and 2, and blocks
that are linked to other files. Run by hand: `python3 corpora/make_old_3dm.py`; with rhino3dm installed it says what that makes of
each (8.35.0 was used). All shapes are our own.

pyramid_v1, pyramid_v2    a pyramid of two faces: its side, with a seam and a pole, and its base, with one closed edge; beside it
                          in version 1 a hidden copy of the base and curves whose knots are stored in short
blocks_linked_v4, _v8     references to blocks: linked, linked with a copy, and one that holds a reference to the first
"""

import pathlib
import struct
import uuid
import zlib

FOLDER = pathlib.Path(__file__).parent / "models" / "3dm"
ANONYMOUS = 0x40008000


def i32(*x):
    return struct.pack(f"<{len(x)}i", *x)


def u16(*x):
    return struct.pack(f"<{len(x)}H", *x)


def f64(*x):
    return struct.pack(f"<{len(x)}d", *x)


def guid(text):
    return uuid.UUID(text).bytes_le


def string(text):
    data = (text + "\0").encode("utf-16-le") if text else b""
    return i32(len(data) // 2) + data


class Body:
    """The bytes of a chunk, and those of them that are its own."""

    def __init__(self, version):
        self.version, self.all, self.own = version, b"", b""

    def raw(self, *data):
        for d in data:
            self.all += d
            self.own += d
        return self

    def header(self, code, value):
        self.all += struct.pack("<Iq" if self.version >= 50 else "<Ii", code, value)

    def short(self, code, value):
        self.header(code, value)
        return self

    def chunk(self, code, inner):
        body = inner.all
        if self.version == 1:
            if code & 0x10100 == 0x10100:
                body += struct.pack(">H", crc16(inner.own + b"\0\0"))
        elif code & 0x8000:
            body += struct.pack("<I", zlib.crc32(inner.own))
        self.header(code, len(body))
        self.all += body
        return self

    def object(self, code, data):
        wrapped = Body(self.version)
        wrapped.chunk(0x0002FFFB, Body(self.version).raw(guid(code)))
        wrapped.chunk(0x0002FFFC, data)
        wrapped.short(0x80027FFF, 0)
        return self.chunk(0x00027FFA, wrapped)


def crc16(data, register=1):
    for byte in data:
        for bit in range(7, -1, -1):
            top = register & 0x8000
            register = (register << 1 | byte >> bit & 1) & 0xFFFF
            if top:
                register ^= 0x1021
    return register


# The pyramid.
BASE = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 0)]
APEX = (1, 1, 1.5)
SQUARE = [(0, 0), (2, 0), (2, 2), (0, 2), (0, 0)]
# Splines: degree, knots as stored, points, weights.
ROUND_BASE = (1, [0, 1, 2, 3, 4], BASE, None)
RIDGE = (1, [0, 3], [BASE[0], APEX], [1, 2])
SIDE = ((1, 1), ([0, 1, 2, 3, 4], [0, 1]), [[b, APEX] for b in BASE])
BOTTOM = ((1, 1), ([0, 2], [0, 2]), [[(0, 0, 0), (0, 2, 0)], [(2, 0, 0), (2, 2, 0)]])


def straight(a, b):
    return (1, [0, 1], [a, b], None)


# Of each face: surface, whether it is reversed, its trims: segments in uv, edge, whether it is the first to use it, twin, reversed.
FACES = [
    (SIDE, 0, [
        ([straight((0, 0), (4, 0))], 0, True, 4, 0),
        ([straight((4, 0), (4, 1))], 1, True, 3, 0),
        ([straight((4, 1), (0, 1))], -1, False, -1, 0),
        ([straight((0, 1), (0, 0))], 1, False, 1, 1),
    ]),
    (BOTTOM, 1, [([straight(a, b) for a, b in zip(SQUARE, SQUARE[1:])], 0, False, 0, 0)]),
]
EDGES = [ROUND_BASE, RIDGE]


def version2(name):
    v = 2

    def spline(degree, knots, points, weights):
        dim, n = len(points[0]), len(points)
        b = Body(v).raw(b"\x10", i32(dim, 1 if weights else 0, degree + 1, n, 0, 0), f64(*[0] * 6))
        b.raw(i32(len(knots)), f64(*knots), i32(n))
        for p, w in zip(points, weights or [None] * n):
            b.raw(f64(*p) if w is None else f64(*[w * x for x in p], w))
        return b

    def poly(body, segments):
        body.raw(b"\x10", i32(len(segments), 0, 0), f64(*[0] * 6))
        body.raw(i32(len(segments) + 1), f64(*range(len(segments) + 1)))
        for s in segments:
            body.object("5EAF1119-0B51-11D4-BFFE-0010830122F0", spline(*s))

    def surface(body, degrees, knots, net):
        nu, nv = len(net), len(net[0])
        body.raw(b"\x10", i32(3, 0, degrees[0] + 1, degrees[1] + 1, nu, nv, 0, 0), f64(*[0] * 6))
        for k in knots:
            body.raw(i32(len(k)), f64(*k))
        body.raw(i32(nu * nv))
        for row in net:
            for p in row:
                body.raw(f64(*p))

    brep = Body(v).raw(b"\x21", i32(2, 2, 2, 5, 1), f64(0, 0, 0, 2, 2, 1.5))
    for _, _, trims in FACES:
        for segments, *_ in trims:
            poly(brep, segments)
    for e in EDGES:
        poly(brep, [e])
    for s, _, _ in FACES:
        surface(brep, *s)
    number = 0
    for f, (_, reversed_, trims) in enumerate(FACES):
        brep.raw(i32(f, -1, reversed_, 0), f64(0, 0, 0, 2, 2, 1.5), i32(1))
        brep.raw(i32(0, 0), f64(0, 0, 4, 4), i32(len(trims)))
        for _, edge, owns, twin, against in trims:
            brep.raw(i32(number, twin), bytes([owns]), i32(edge, against, 0, 0), f64(1e-3, 1e-4))
            number += 1
    # No meshes, of either kind.
    brep.raw(b"\0\0\0\0")

    objects = Body(v).chunk(0x20008070, Body(v)
        .short(0x82000071, 0x10)
        .object("2D4CFEDB-3E2A-11D4-800E-0010830122F0", brep)
        .chunk(0x02008072, attributes(v, uuid.UUID(int=7), "pyramid", 0))
        .short(0x8200007F, 0))
    save(name, v, Body(v), objects)


def attributes(version, own, name, mode):
    b = Body(version)
    if version >= 50:
        b.raw(b"\x20", own.bytes_le, i32(0), b"\x01", string(name))
        return b.raw(b"\x0c", bytes([mode]), b"\0") if mode else b.raw(b"\0")
    b.raw(b"\x10", own.bytes_le, i32(0, -1), b"\0" * 8, f64(0, 1), i32(1))
    return b.raw(bytes([mode, 0, 0, 0]), string(name), string(""))


def save(name, v, blocks, objects):
    opennurbs = {2: 200012210, 4: 200710174, 50: 201101285, 80: 2415950832}[v]
    file = Body(v).raw(f"3D Geometry File Format {v:>8}".encode())
    file.chunk(1, Body(v).raw(b"corpora/make_old_3dm.py\x1a"))
    properties = Body(v)
    properties.header(0xA0000026, struct.unpack("<i", struct.pack("<I", opennurbs))[0] if v < 50 else opennurbs)
    file.chunk(0x10000014, properties.short(0xFFFFFFFF, 0))
    units = Body(v).raw(i32(100, 2), f64(0.001, 0.017, 0.01))
    file.chunk(0x10000015, Body(v).chunk(0x20008031, units).short(0xFFFFFFFF, 0))
    if blocks.all:
        file.chunk(0x10000021, blocks.short(0xFFFFFFFF, 0))
    file.chunk(0x10000013, objects.short(0xFFFFFFFF, 0))
    if v >= 4:
        file.chunk(0x10000026, Body(v).short(0xFFFFFFFF, 0))
    wide = v >= 50
    size = len(file.all) + (20 if wide else 12)
    file.chunk(0x7FFF, Body(v).raw(struct.pack("<Q" if wide else "<I", size)))
    (FOLDER / f"{name}.3dm").write_bytes(file.all)


def version1(name):
    v = 1

    def spline(degree, knots, points, weights, clamped=None):
        dim, n = len(points[0]), len(points)
        b = Body(v).raw(bytes([dim, 1 if weights else 0, degree + 1]), u16(n), b"\0\0", f64(*[0] * (2 * dim)))
        if degree > 1:
            b.raw(bytes([clamped]))
        b.raw(f64(*knots))
        for p, w in zip(points, weights or [None] * n):
            b.raw(f64(*p) if w is None else f64(*p, w))
        return Body(v).chunk(0x10109, b)

    def curve_data(segments):
        dim = len(segments[0][2][0])
        b = Body(v).raw(bytes([dim, 0]), u16(len(segments)), f64(*[0] * (2 * dim)))
        for s in segments:
            b.chunk(0x10009, spline(*s))
        return b

    def curve(body, segments):
        body.chunk(0x10008, Body(v).chunk(0x10108, curve_data(segments)))

    def surface(degrees, knots, net):
        spans = [len(net) - degrees[0], len(net[0]) - degrees[1]]
        b = Body(v).raw(bytes([3, 0, *degrees]), u16(*spans), bytes([0, 0, 0, 0, 0, 0]), f64(*[0] * 6))
        for k in knots:
            b.raw(f64(*k))
        for row in net:
            for p in row:
                b.raw(f64(*p))
        return Body(v).chunk(0x10107, b)

    def face(s, reversed_, trims, in_shell):
        twins = u16(1, 0) if len(trims) > 1 else b""
        b = Body(v).raw(i32(reversed_, 0, 2 + 1), f64(0, 0, 0, 2, 2, 1.5), i32(len(twins) // 2), twins)
        b.chunk(0x10007, surface(*s))
        loop = Body(v).raw(i32(len(trims), 0), f64(0, 0, 4, 4))
        for segments, edge, owns, _, against in trims:
            owns |= not in_shell
            seam = edge == 1
            flags = (1 if owns else 0) | (2 if seam else 4 if edge == 0 and in_shell else 0)
            t = Body(v).raw(bytes([flags]), i32(against, 0, 0), f64(1e-3, 1e-4))
            curve(t, segments)
            if owns:
                curve(t, [EDGES[edge]])
            loop.chunk(0x10006, Body(v).chunk(0x10106, t))
        b.chunk(0x10005, Body(v).chunk(0x10105, loop))
        return Body(v).chunk(0x10104, b)

    def text(code, body, words):
        body.chunk(code, Body(v).raw(i32(len(words)), words.encode()))

    file = Body(v).raw(f"3D Geometry File Format {1:>8}".encode())
    file.chunk(1, Body(v).raw(b"corpora/make_old_3dm.py\x1a"))
    file.chunk(0x02000010, Body(v).raw(i32(1, 2), f64(0.001, 0.01, 0.017)))
    for layer, state in [("shapes", 0), ("put away", 1)]:
        body = Body(v)
        text(0x00400011, body, layer)
        file.chunk(0x00400010, body.short(0x80400033, state).short(0xFFFFFFFF, 0))
    shell = Body(v).raw(i32(1, 2), f64(0, 0, 0, 2, 2, 1.5), i32(2), u16(1, 0))
    for f in FACES:
        shell.chunk(0x10004, face(*f, True))
    body = Body(v).short(0xA0000001, 0)
    text(0x02000001, body, "pyramid")
    file.chunk(0x10003, body.chunk(0x10103, shell))
    # Hidden: on a layer for that, its true one beside it.
    hidden = Body(v).short(0xA0000001, 1)
    key = b"RhHidePrevLayer\0"
    hidden.chunk(0x40000001, Body(v).raw(i32(len(key), 7), key, b"shapes\0"))
    hidden.all += face(*FACES[1], False).all
    file.chunk(0x10004, hidden)
    points = [(0, 0, 0), (1, 2, 0), (2, 2, 1), (3, 0, 1)]
    weights = [1, 0.5, 2, 1]
    # A bit each: the start's knots are stored once, the end's.
    for clamped, knots in [(0, [-1, 0, 0.5, 1, 2]), (1, [0, 0.5, 1, 2]), (2, [-1, 0, 0.5, 1]), (3, [0, 0.5, 1])]:
        body = Body(v).short(0xA0000001, 0)
        file.chunk(0x10008, body.chunk(0x10108, curve_data([(2, knots, points, weights, clamped)])))
    (FOLDER / f"{name}.3dm").write_bytes(file.all)


LINKED, LINKED_AND_EMBEDDED, STATIC = 3, 2, 1
ELSEWHERE = "C:\\parts\\bolt.3dm"


def linked(name, v):
    ids = [uuid.UUID(int=0x1000 + k) for k in range(3)]
    members = [uuid.UUID(int=0x2000 + k) for k in range(2)]
    none = uuid.UUID(int=0)

    def definition(own, title, kind, path, objects):
        b = Body(v)
        if v < 60:
            b.raw(b"\x10", own.bytes_le, i32(len(objects)), *[o.bytes_le for o in objects])
            b.raw(string(title), string(""), string(""), string(""), f64(*[0] * 6), i32(kind), string(path))
        else:
            # Serial numbers are not set; id, parent and index follow, then the name.
            parts = Body(v).raw(i32(1, 0), b"\0", b"\1", own.bytes_le, b"\0", b"\0", b"\1", string(title))
            d = Body(v).raw(i32(1, 0)).chunk(0x40008002, parts).raw(i32(kind))
            d.chunk(ANONYMOUS, Body(v).raw(i32(1, 0, 2), f64(0.001), string("")))
            d.raw(string(""), string(""), string(""), f64(*[0] * 6), bytes([1 if objects else 0]))
            if objects:
                d.raw(i32(len(objects)), *[o.bytes_le for o in objects])
            d.raw(bytes([1 if path else 0]))
            if path:
                hashes = Body(v).raw(i32(1, 0), b"\0" * 24)
                for _ in range(2):
                    hashes.chunk(ANONYMOUS, Body(v).raw(i32(1, 0), b"\0" * 20))
                file = Body(v).raw(i32(1, 0), string(path), string("")).chunk(ANONYMOUS, hashes).raw(i32(0))
                link = Body(v).raw(i32(1, 0)).chunk(ANONYMOUS, file).raw(i32(0, 1), b"\0")
                d.chunk(ANONYMOUS, link)
            b.chunk(ANONYMOUS, d)
        return Body(v).object("26F8BFF6-2618-417F-A158-153D64A94989", b)

    blocks = Body(v)
    blocks.chunk(0x20008076, definition(ids[0], "bolt", LINKED, ELSEWHERE, []))
    blocks.chunk(0x20008076, definition(ids[1], "nut", LINKED_AND_EMBEDDED, ELSEWHERE, [members[0]]))
    blocks.chunk(0x20008076, definition(ids[2], "both", STATIC, "", members))

    def record(own, title, mode, code, data):
        return Body(v).short(0x82000071, 0).object(code, data).chunk(0x02008072, attributes(v, own, title, mode)).short(0x8200007F, 0)

    def reference(block, x):
        rows = [1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
        return "F9CFB638-B9D4-4340-87E3-C56E7865D96A", Body(v).raw(b"\x10", block.bytes_le, f64(*rows), f64(*[0] * 6))

    plane = Body(v).raw(b"\x11", f64(0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0), f64(*[0, 1] * 4))
    objects = Body(v)
    objects.chunk(0x20008070, record(members[0], "sheet", 3, "4ED7D4DF-E947-11D3-BFE5-0010830122F0", plane))
    objects.chunk(0x20008070, record(members[1], "bolt in both", 3, *reference(ids[0], 1)))
    for k, title in enumerate(["bolt", "nut", "both"]):
        objects.chunk(0x20008070, record(uuid.UUID(int=0x3000 + k), title, 0, *reference(ids[k], 10 * k)))
    objects.chunk(0x20008070, record(uuid.UUID(int=0x3003), "nothing", 0, *reference(none, 0)))
    save(name, v, blocks, objects)


def main():
    version1("pyramid_v1")
    version2("pyramid_v2")
    linked("blocks_linked_v4", 4)
    linked("blocks_linked_v8", 80)
    try:
        import rhino3dm
    except ImportError:
        return
    for path in sorted(FOLDER.glob("pyramid_*.3dm")) + sorted(FOLDER.glob("blocks_linked_*.3dm")):
        model = rhino3dm.File3dm.Read(str(path))
        print(path.name, [(o.Attributes.Name, type(o.Geometry).__name__, o.Geometry.IsValid) for o in model.Objects])
        for d in model.InstanceDefinitions:
            print("   ", d.Name, d.UpdateType, d.SourceArchive, len(d.GetObjectIds()))
        for o in model.Objects:
            if type(o.Geometry).__name__ == "Brep":
                b = o.Geometry
                print("   ", len(b.Faces), len(b.Edges), len(b.Vertices), "solid" if b.IsSolid else "open", b.IsValidWithLog)


main()
