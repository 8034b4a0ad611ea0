"""The table of crates/feeler-io/PARTS.md: what the program says of every part in some folders.

    cargo build --release -p feeler-cli && cargo build --release -p xtask --features cgal
    python3 corpora/parts_table.py [--seconds 60] [--queries 50] [--fewer 12] FOLDER_OR_FILE... > table.md

For each file: `feeler inspect --json` (objects, faces, defects), its time and peak memory as the system counts them for
the process, and `xtask agree --queries N`, which asks kernel and oracle the same random queries; fewer where these are not
done in time, and what is not done then either says so. `--bin` names the folder of both programs.
"""

import argparse
import json
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
    """Sums of the columns right, wrong, indeterminate, undecided, no truth."""
    sums = [0] * 5
    found = False
    for line in text.splitlines():
        words = line.split()
        if len(words) == 6 and all(w.isdigit() for w in words[1:]):
            sums = [a + int(w) for a, w in zip(sums, words[1:])]
            found = True
    return sums if found else None


def row(path, args):
    size = path.stat().st_size
    runs = [run([args.bin / "feeler", "inspect", "--json", path], args.seconds) for _ in range(3)]
    code, text, _, _ = runs[0]
    best = min(r[2] for r in runs)
    peak = min(r[3] for r in runs)
    cells = [path.name, f"{(size + 999) // 1000}"]
    if code is None:
        return cells + ["not loaded in time"] + [""] * 10
    # With objects that are refused it ends with 2, too, after it has told them.
    lines = text.strip().splitlines()
    if code == 2 and not lines[0].startswith("{"):
        return cells + [lines[-1].replace(f"{path}", "it")[:120]] + [""] * 10
    seen = json.loads(lines[0])
    objects = seen["objects"]
    bodies = [o for o in objects if o.get("faces")]
    refused = sum(o["kind"] == "refused" for o in objects)
    faces = sum(o["faces"] for o in bodies)
    defects = sum(len(o.get("defects", [])) for o in bodies)
    closed = sum(bool(o.get("solid")) for o in bodies)
    cells += [f"{len(bodies)}" + (f" (+{refused} refused)" if refused else ""), str(closed), str(faces), str(defects)]
    cells += [f"{best * 1e3:.0f}", f"{peak / 1024:.0f}"]
    if not bodies:
        return cells + ["none"] + [""] * 4
    for queries in [args.queries, args.fewer]:
        code, text, _, _ = run([args.bin / "xtask", "agree", path, "--queries", str(queries)], args.seconds)
        if code is not None:
            break
    sums = asked(text)
    if code is None or sums is None:
        why = text.strip().splitlines()[-1].replace(f"{path}", "it")[:80] if text.strip() else "no answer"
        why = "out of time" if code is None else "not asked: objects are refused" if refused else why
        return cells + [why] + [""] * 4
    right, wrong, indeterminate, undecided, untold = sums
    return cells + [str(queries), str(right), str(undecided), str(wrong + indeterminate), str(untold)]


HEAD = [
    "part", "kB", "objects", "closed", "faces", "defects", "ms", "MB", "asked", "right", "undecided", "wrong", "no truth",
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
