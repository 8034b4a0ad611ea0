"""Damaged files through other readers, each file in a process of its own: how many crash, hang, use memory without bound.

    python3 tests/import/peers.py --feeler target/release/feeler [--count 1000] [--start 0] [--seconds 10] corpora/models

The damage is that of `mutated.rs`, from the same random numbers: truncated, bits flipped, numbers replaced, pieces moved, said
twice or blanked. .3dm files go through rhino3dm, .brep and STEP files through OCCT (cadquery-ocp), where these can be imported; all
through `feeler inspect`, which looks at what it read besides. A reader is loaded once, and forks for
each file; what crashes so, or waits for something, is read again in a fresh process, and counts as that does.
"""

import argparse
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

SMALL = 50_000
# Of the processor, so that other work beside counts little; of the clock eight times as many. `--seconds` sets it.
SECONDS = 10
# A process that wants more than this is told that there is no more.
MEMORY = 4 << 30
MASK = (1 << 64) - 1
WILD = [
    bytes(8), b"\xff" * 8, b"\x01" + bytes(7), b"\xff\xff\xff\x7f" + bytes(4), b"\0\0\0\x80" + bytes(4),
    b"\0\0\x01" + bytes(5), b"\x02\0\0\0\x01\0\0\0", bytes(6) + b"\xf8\x7f", bytes(6) + b"\xf0\x7f",
    b"\xff" * 6 + b"\xef\x7f", b"\x01" + bytes(6) + b"\x80", bytes(6) + b"\xf0\xbf",
]


class Random:
    def __init__(self, seed):
        self.state = seed

    def next(self):
        self.state = (self.state * 6_364_136_223_846_793_005 + 1_442_695_040_888_963_407) & MASK
        return self.state >> 33

    def below(self, count):
        return self.next() % max(count, 1)


def damage(data, r):
    data = bytearray(data)
    for _ in range(r.below(4) + 1):
        at = r.below(len(data))
        rest = len(data) - at
        size = min(1 + r.below(64), rest)
        how = r.below(9)
        if how == 0:
            del data[max(at, 1):]
        elif how <= 2:
            data[at] ^= 1 << r.below(8)
        elif how <= 4:
            wild = WILD[r.below(len(WILD))]
            size = min([4, 8][r.below(2)], rest)
            data[at:at + size] = wild[:size]
        elif how == 5:
            piece = data[at:at + size]
            to = r.below(len(data))
            data[to:to] = piece
        elif how == 6:
            del data[at:at + size]
        elif how == 7:
            data[at:at + size] = b"0" * size
        else:
            to = r.below(len(data) - size + 1)
            data[to:to + size] = data[at:at + size]
        if not data:
            data += b" "
    return bytes(data)


def rhino(path):
    import rhino3dm

    model = rhino3dm.File3dm.Read(path)
    return model is not None and len([o.Geometry.IsValid for o in model.Objects]) >= 0


def brep(path):
    from OCP.BRep import BRep_Builder
    from OCP.BRepTools import BRepTools
    from OCP.TopoDS import TopoDS_Shape

    shape = TopoDS_Shape()
    return BRepTools.Read_s(shape, path, BRep_Builder()) and not shape.IsNull()


def step(path):
    from OCP.STEPControl import STEPControl_Reader

    reader = STEPControl_Reader()
    return int(reader.ReadFile(path)) == 1 and reader.TransferRoots() > 0


def limited():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 1))


def killed(by):
    return "hang" if by == signal.SIGXCPU else f"crash ({signal.Signals(by).name})"


def outcome(pid):
    start = time.monotonic()
    while time.monotonic() - start < 8 * SECONDS:
        done, status = os.waitpid(pid, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.001)
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)
    return None


def forked(read, path):
    """What reading does in a process of its own: loaded, refused, crash (with the signal), hang (its seconds of the processor were used up), or waits."""
    pid = os.fork()
    if pid == 0:
        quiet = os.open(os.devnull, os.O_WRONLY)
        os.dup2(quiet, 1)
        os.dup2(quiet, 2)
        limited()
        try:
            os._exit(0 if read(path) else 1)
        except MemoryError:
            os._exit(3)
        except BaseException:
            os._exit(2)
    code = outcome(pid)
    if code is None:
        return "waits"
    if code < 0:
        return killed(-code)
    return ["loaded", "refused", "refused", "no memory"][code] if code < 4 else f"exit {code}"


def alone(ending, path):
    """The same in a fresh process, so that a crash or a wait is not the fork's."""
    return started([sys.executable, __file__, "--one", ending, path], {0: "loaded", 1: "refused"})


def started(command, names, out=subprocess.DEVNULL):
    process = subprocess.Popen(command, stdout=out, stderr=subprocess.DEVNULL, preexec_fn=limited)
    try:
        code = process.wait(8 * SECONDS)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        return "hang"
    if code < 0:
        return killed(-code)
    return names.get(code, f"exit {code}")


def ours(feeler, path):
    # 101 would be a panic. A file of which objects are refused ends with 2 as well, but is told.
    with tempfile.TemporaryFile() as out:
        result = started([feeler, "inspect", path], {0: "loaded", 1: "loaded", 2: "refused"}, out)
        return "loaded" if result == "refused" and os.fstat(out.fileno()).st_size > 0 else result


def available(read, good):
    """Whether a reader is there, and reads a good file."""
    try:
        return read(str(good))
    except ImportError as error:
        print(f"not asked: {error}")
        return False


def main():
    global SECONDS
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--one", nargs=2, metavar=("ENDING", "FILE"), help=argparse.SUPPRESS)
    parser.add_argument("--feeler", type=Path, default=Path("target/release/feeler"))
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--start", type=int, default=0, help="the first file's number")
    parser.add_argument("--seconds", type=int, default=SECONDS)
    parser.add_argument("--only", default="")
    parser.add_argument("models", type=Path, nargs="?", default=Path("corpora/models"))
    args = parser.parse_args()
    SECONDS = args.seconds
    kinds = [("3dm", "rhino3dm", rhino, 0), ("brep", "OCCT", brep, 1 << 32), ("step", "OCCT", step, 1 << 33)]
    if args.one:
        read = next(k[2] for k in kinds if k[0] == args.one[0])
        try:
            sys.exit(0 if read(args.one[1]) else 1)
        except Exception:
            sys.exit(1)
    for ending, name, read, base in kinds:
        if args.only and ending != args.only:
            continue
        files = sorted(p for p in args.models.rglob(f"*.{ending}") if p.stat().st_size <= SMALL)
        contents = [p.read_bytes() for p in files]
        asked = available(read, files[0])
        theirs, own = Counter(), Counter()
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, f"damaged.{ending}")
            for i in range(args.start, args.start + args.count):
                r = Random(base + i)
                r.next()
                data = damage(contents[r.below(len(contents))], r)
                with open(path, "wb") as out:
                    out.write(data)
                own[ours(args.feeler, path)] += 1
                if asked:
                    found = forked(read, path)
                    if found not in ("loaded", "refused", "hang"):
                        found = alone(ending, path)
                    theirs[found] += 1
                if sys.stderr.isatty():
                    print(f"\r{ending} {i + 1 - args.start}/{args.count}\x1b[K", end="", file=sys.stderr)
                elif (i + 1 - args.start) % 100 == 0:
                    print(f"{ending} {i + 1 - args.start}: {dict(own)}; {dict(theirs)}", file=sys.stderr, flush=True)
        print(f".{ending}: {args.count} files; feeler: {dict(own)}; {name}: {dict(theirs)}", flush=True)


if __name__ == "__main__":
    main()
