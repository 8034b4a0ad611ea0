"""The table of crates/feeler-io/PARTS.md: what the program says of every part in some folders.

    cargo build --release -p feeler-cli && cargo build --release -p xtask --features cgal
    python3 corpora/parts_table.py [--seconds 60] [--queries 50] [--fewer 12] FOLDER_OR_FILE... > table.md

For each file: `feeler inspect --json` (objects, faces), its time and peak memory as the system counts them for
the process, `feeler inspect --health --json`, and `xtask agree --queries N`, which asks kernel and oracle the same random
queries and tells the largest error; fewer where these are not done in time, and what is not done then either says so.
`--bin` names the folder of both programs.
"""

import argparse
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ENDINGS = {".3dm", ".brep", ".rle", ".step", ".stp"}


def run(command, seconds):
    """Exit code (None: out of time), output, seconds, peak kilobytes."""
    with tempfile.TemporaryFile() as out, tempfile.NamedTemporaryFile() as peak:
        start = time.monotonic()
        # By way of a small program: the system counts what this one takes for its children, too.
        counted = ["/usr/bin/time", "-q", "-f", "%M", "-o", peak.name, *command]
        process = subprocess.Popen(counted, stdout=out, stderr=subprocess.STDOUT, start_new_session=True)
        try:
            code = process.wait(seconds)
        except subprocess.TimeoutExpired:
            code = None
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        taken = time.monotonic() - start
        out.seek(0)
        kilobytes = peak.read().split()
        return code, out.read().decode(errors="replace"), taken, int(kilobytes[-1]) if kilobytes else 0


def asked(text):
    """Sums of the columns right, wrong, indeterminate, undecided, no truth; and the largest of the last, the error."""
    sums = [0] * 5
    errors = []
    for line in text.splitlines():
        words = line.split()
        if len(words) == 7 and all(w.isdigit() for w in words[1:6]):
            sums = [a + int(w) for a, w in zip(sums, words[1:6])]
            errors.append(words[6])
    numbers = [e for e in errors if e != "-"]
    return (sums, max(numbers, key=float, default="")) if errors else None


def short(x):
    """The first two digits of a bound, rounded up."""
    unit = 10.0 ** (math.floor(math.log10(x)) - 1)
    return f"{math.ceil(x / unit) * unit:.1e}".replace("e-0", "e-").replace("e+0", "e")


# What `health` tells apart, the worst first.
KINDS = [
    ("crossing", "crossings"),
    ("overlap", "overlaps"),
    ("undecided meeting", "undecided meetings"),
    ("touch", "touches"),
    ("unlisted meeting", "unlisted meetings"),
    ("loop turned", "loops turned"),
    ("edge against", "edges against"),
    ("non-manifold edge", "non-manifold edges"),
    ("crack", "cracks"),
    ("gap", "gaps"),
    ("naked edge", "naked edges"),
    ("sliver", "slivers"),
    ("tiny edge", "tiny edges"),
    ("unused edge", "unused edges"),
    ("curve off", "curves off"),
    ("end off", "ends off"),
    ("other", "others"),
]


def health(bodies):
    """What `inspect --health` found, in words: kinds with their counts, and the largest of some. `sound`, if nothing."""
    counts = {one: 0 for one, _ in KINDS}
    # None: without a bound.
    lengths = {one: [] for one, _ in KINDS}
    for h in (body["health"] for body in bodies):
        faces, edges = h["faces"], h["edges"]
        loops = [each for f in faces for each in f["loops"]]
        off = [[o["at_most"] for o in e["offsets"]] for e in edges if e["offsets"]]
        for one, sizes in {
            "crack": [e["crack"][1] for e in edges],
            "gap": [g["space"][1] for each in loops for g in each["gaps"]],
            "curve off": [None if None in each else max(each) for each in off],
        }.items():
            large = [x for x in sizes if x is None or x > h["rounding"]]
            counts[one] += len(large)
            lengths[one] += large
        for meeting in (m for f in faces for m in f["meetings"] if not m["at_gap"]):
            counts["undecided meeting" if meeting["kind"] == "undecided" else meeting["kind"]] += 1
        vertices = sum(d.startswith("vertex ") for d in h["defects"])
        for one, count in {
            "unlisted meeting": sum(f["more_meetings"] for f in faces),
            "loop turned": sum(each["turned_wrong"] for each in loops),
            "edge against": sum(e["direction"] == "against" for e in edges),
            "non-manifold edge": sum(e["non_manifold"] for e in edges),
            "naked edge": sum(e["naked"] for e in edges),
            "sliver": sum(f["sliver"] for f in faces),
            "tiny edge": sum(e["tiny"] for e in edges),
            "unused edge": sum(not e["faces"] for e in edges),
            "end off": vertices,
            "other": len(h["defects"]) - vertices,
        }.items():
            counts[one] += count
    words = []
    for one, many in KINDS:
        sizes = lengths[one]
        most = ", no bound" if None in sizes else f" ≤ {short(max(sizes))}" if sizes else ""
        if counts[one]:
            words.append(f"{counts[one]} {one if counts[one] == 1 else many}{most}")
    return "; ".join(words) or "sound"


def row(path, args):
    size = path.stat().st_size
    runs = [run([args.bin / "feeler", "inspect", "--json", path], args.seconds) for _ in range(3)]
    code, text, _, _ = runs[0]
    best = min(r[2] for r in runs)
    peak = min(r[3] for r in runs)
    cells = [path.name, f"{(size + 999) // 1000}"]
    if code is None:
        return cells + ["not loaded in time"] + [""] * 11
    # With objects that are refused it ends with 2, too, after it has told them.
    lines = text.strip().splitlines()
    if code == 2 and not lines[0].startswith("{"):
        return cells + [lines[-1].replace(f"{path}", "it")[:120]] + [""] * 11
    seen = json.loads(lines[0])
    objects = seen["objects"]
    bodies = [o for o in objects if o.get("faces")]
    refused = sum(o["kind"] == "refused" for o in objects)
    faces = sum(o["faces"] for o in bodies)
    closed = sum(bool(o.get("solid")) for o in bodies)
    cells += [f"{len(bodies)}" + (f" (+{refused} refused)" if refused else ""), str(closed), str(faces)]
    code, text, _, _ = run([args.bin / "feeler", "inspect", "--health", "--json", path], args.seconds)
    checked = [] if code is None else [o for o in json.loads(text.splitlines()[0])["objects"] if o.get("faces")]
    cells += ["out of time" if code is None else health(checked) if bodies else ""]
    cells += [f"{best * 1e3:.0f}", f"{peak / 1024:.0f}"]
    if not bodies:
        return cells + ["none"] + [""] * 5
    # Loose surfaces are asked one by one.
    loose = all(o["kind"] == "surface" for o in bodies)
    alone = ["--object", str(objects.index(bodies[0]))] if loose else []
    for queries in [args.queries, args.fewer]:
        agree = [args.bin / "xtask", "agree", path, "--queries", str(queries), *alone]
        code, text, _, _ = run(agree, args.seconds)
        if code is not None:
            break
    said = asked(text)
    if code is None or said is None:
        why = text.strip().splitlines()[-1].replace(f"{path}", "it")[:80] if text.strip() else "no answer"
        why = "out of time" if code is None else "not asked: objects are refused" if refused else why
        return cells + [why] + [""] * 5
    (right, wrong, indeterminate, undecided, untold), error = said
    return cells + [str(queries), str(right), str(undecided), str(wrong + indeterminate), str(untold), error]


HEAD = [
    "part", "kB", "objects", "closed", "faces", "health", "ms", "MB", "asked", "right", "undecided", "wrong", "no truth", "error",
]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--queries", type=int, default=50)
    parser.add_argument("--fewer", type=int, default=12)
    parser.add_argument("--bin", type=Path, default=Path("target/release"))
    parser.add_argument("where", type=Path, nargs="+")
    args = parser.parse_args()
    print("| " + " | ".join(HEAD) + " |\n|" + "---|" * len(HEAD), flush=True)
    for where in args.where:
        files = [where] if where.is_file() else sorted(p for p in where.rglob("*") if p.suffix.lower() in ENDINGS)
        for i, path in enumerate(files):
            if sys.stderr.isatty():
                print(f"\r{i + 1}/{len(files)} {path.name}\x1b[K", end="", file=sys.stderr)
            print("| " + " | ".join(row(path, args)) + " |", flush=True)


if __name__ == "__main__":
    main()
