#!/usr/bin/env python3
"""clang-tidy over the rooms that hold it: every finding is an error; .clang-tidy says what is asked.

Usage: tidy.py ROOT BUILD [--changed] [--jobs N] [PATH...]
BUILD holds compile_commands.json. --changed: only sources that differ from the branch main, and
those whose header does. PATH: sources below it instead, also of rooms that are not held to it yet.
What was clean is remembered below $XDG_CACHE_HOME (else ~/.cache), with a digest of all that was read: sources,
headers, flags, .clang-tidy, the linter. It is read again when one of them changes; --fresh reads everything.
"""
import argparse
import collections
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import resource
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

# What runs on the robot, and more rooms when they are clean. The rest of shared, host/mpc, host/motion and
# tools/diagnose is clean too, and asked for by name (CONTRIBUTING.md): the last alone would take 284 s more of
# processor time, and all of tools/test has an hour.
ROOMS = ("firmware", "host/app", "host/learn", "host/link", "host/model", "shared/model", "shared/policy",
         "shared/servo_bus", "shared/wire", "tools/diagnose/gate", "tools/diagnose/model_folder",
         "tools/diagnose/stats")
TOGETHER = 8  # sources read at once
# States of one function that the analyzer looks at, at most. Its own 225000 are three quarters of all the time: eight
# sources of the diagnosis take 50 s with them, 20 s with these, 13 s without the analyzer.
NODES = 50000
LINTERS = ("clang-tidy-14", "clang-tidy")
COMPILERS = ("clang++-14", "clang++", "c++")  # say which headers a source reads
FORGOTTEN = 60 * 86400  # s: what nobody asked for as long is removed
FINDING = re.compile(r"^(\S+?):(\d+):\d+: (?:warning|error): (.*)$", re.M)


def changed(root):
    """Paths that differ from main, uncommitted ones included; None when git cannot say."""
    git = ["git", "-C", str(root)]
    base = subprocess.run([*git, "merge-base", "main", "HEAD"], capture_output=True, text=True)
    if base.returncode != 0:
        return None
    diff = [*git, "diff", "--name-only", base.stdout.strip()]
    return subprocess.run(diff, capture_output=True, text=True, check=True).stdout.split()


def units(root, build, rooms):
    """Sources below the rooms, relative to the root, each with its compiler flags (no input, no output)."""
    commands = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    inside = {}
    for entry in commands:
        path = pathlib.Path(entry["file"])
        if path.is_relative_to(root):
            name = path.relative_to(root).as_posix()
            if any(name == room or name.startswith(room + "/") for room in rooms):
                inside[name] = flags(entry["command"])
    return dict(sorted(inside.items()))


def flags(command):
    """What a compile command says but for compiler, input, output and precompiled headers."""
    words, kept = shlex.split(command), []
    skip = False
    for word in words:
        if skip or word in ("-o", "-c", "-include"):
            skip = word in ("-o", "-include")
        elif word.startswith("-") or (kept and kept[-1] in ("-isystem", "-I")):
            kept.append(word)
    return tuple(kept)


def batches(sources):
    """Sources of one folder with the same flags, some together: their headers are then read once."""
    groups = collections.defaultdict(list)
    for name, words in sources.items():
        groups[(str(pathlib.PurePosixPath(name).parent), words)].append(name)
    for (_, words), names in groups.items():
        for first in range(0, len(names), TOGETHER):
            yield names[first:first + TOGETHER], words


class Memory:
    """Which sources were clean. An entry says what else was read, each with a digest, as ccache does."""

    def __init__(self, folder, root, salt):
        self.folder, self.root, self.salt = folder, root, salt
        self.digests = {}  # of headers that many sources read
        folder.mkdir(parents=True, exist_ok=True)

    def digest(self, path):
        if path not in self.digests:
            try:
                self.digests[path] = hashlib.sha256((self.root / path).read_bytes()).hexdigest()
            except OSError:
                self.digests[path] = ""  # gone: equal to nothing
        return self.digests[path]

    def entry(self, names, words):
        """Of these sources as they are now; that the tree stands elsewhere does not matter."""
        said = [self.salt, [word.replace(str(self.root), ".") for word in words],
                [(name, self.digest(name)) for name in names]]
        return self.folder / (hashlib.sha256(json.dumps(said).encode()).hexdigest() + ".json")

    def knows(self, names, words):
        entry = self.entry(names, words)
        try:
            read = json.loads(entry.read_text(encoding="utf-8"))
            known = all(digest and self.digest(path) == digest for path, digest in read.items())
            if known:
                os.utime(entry)
        except (OSError, ValueError):
            return False
        return known

    def keep(self, names, words, headers):
        """headers: paths that were read, of the tree relative to its root."""
        entry = self.entry(names, words)
        new = entry.with_suffix(f".{os.getpid()}")
        new.write_text(json.dumps({path: self.digest(path) for path in sorted(headers)}), encoding="utf-8")
        new.replace(entry)

    def forget(self, now):
        for entry in self.folder.glob("*.json"):
            if now - entry.stat().st_mtime > FORGOTTEN:
                entry.unlink()


def headers_of(root, build, joined, words):
    """What the joined source reads beside itself; None when no compiler says."""
    compiler = next((name for name in COMPILERS if shutil.which(name)), None)
    if compiler is None:
        return None
    run = subprocess.run([compiler, "-M", *words, str(joined)], capture_output=True, text=True, cwd=build)
    if run.returncode != 0:
        return None
    found = set()
    for word in run.stdout.replace("\\\n", " ").split()[1:]:
        path = pathlib.Path(word) if word.startswith("/") else (build / word).resolve()
        if path != joined:
            found.add(path.relative_to(root).as_posix() if path.is_relative_to(root) else str(path))
    return found


def remembered(memory, linter, root, build, names, words):
    """Findings, from memory where there were none."""
    if memory is not None and memory.knows(names, words):
        return set()
    found = lint(linter, root, build, names, words)
    if memory is not None and not found:
        headers = headers_of(root, build, joined_path(build, names), words)
        if headers is not None:
            memory.keep(names, words, headers)
    return found


def joined_path(build, names):
    return build / "lint" / (names[0].replace("/", "_").removesuffix(".cpp") + f"_{len(names)}.cpp")


def lint(linter, root, build, names, words):
    """Findings in our own files; what the analyzer suspects inside of libraries is theirs.

    The sources stand one after the other in one file, so that the analyzer takes all of it for the main file. Where
    two of them define the same name the later ones are read apart.
    """
    origin, text = [], []
    for name in names:
        lines = (root / name).read_text(encoding="utf-8").splitlines()
        origin += [(name, number) for number in range(1, len(lines) + 1)]
        text += lines
    joined = joined_path(build, names)
    joined.parent.mkdir(exist_ok=True)
    joined.write_text("\n".join(text) + "\n", encoding="utf-8")
    config = f"--config-file={root / '.clang-tidy'}"
    depth = ["-Xclang", "-analyzer-config", "-Xclang", f"max-nodes={NODES}"]
    run = subprocess.run([linter, "--quiet", config, str(joined), "--", *words, *depth],
                         capture_output=True, text=True, cwd=build)
    all_found = FINDING.findall(run.stdout)
    if len(names) > 1 and ("[clang-diagnostic-error]" in run.stdout or (run.returncode and not all_found)):
        return set().union(*(lint(linter, root, build, part, words)
                             for part in parted(names, clashing(build, joined, origin, all_found))))
    if run.returncode != 0 and not all_found:
        return {f"{names[0]}: clang-tidy failed: {run.stderr.strip()[-400:]}"}
    return set(own_findings(root, build, joined, origin, all_found))


def clashing(build, joined, origin, all_found):
    """Sources in which the joined file does not compile."""
    return {origin[int(line) - 1][0] for path, line, text in all_found
            if "[clang-diagnostic-error" in text and build / path == joined}


def parted(names, clash):
    """What can stay together and what cannot; halves where nothing tells."""
    together, apart = [n for n in names if n not in clash], [n for n in names if n in clash]
    if together and apart:
        return together, apart
    return names[:len(names) // 2], names[len(names) // 2:]


def own_findings(root, build, joined, origin, all_found):
    """Findings as file:line: text, those of the joined file at the place where the line came from."""
    for path, line, text in all_found:
        where = pathlib.Path(path) if path.startswith("/") else (build / path).resolve()
        if where == joined:
            name, number = origin[int(line) - 1]
            yield f"{name}:{number}: {text}"
        elif where.is_relative_to(root):
            yield f"{where.relative_to(root)}:{line}: {text}"


def memory_of(linter, root):
    """What holds for all sources: the rules, the linter, how this script joins them."""
    said = [(root / ".clang-tidy").read_text(encoding="utf-8"), str(TOGETHER), str(NODES),
            subprocess.run([linter, "--version"], capture_output=True, text=True, check=True).stdout]
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache")
    return Memory(cache / "sanso-tidy", root, hashlib.sha256("\0".join(said).encode()).hexdigest())


def self_test():
    """A source is read again when it, a header, the flags or the rules change, and only then."""
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "a.cpp").write_text("1"), (root / "a.h").write_text("2")

        def memory(salt="rules"):
            return Memory(root / "memory", root, salt)

        assert not memory().knows(["a.cpp"], ("-O2",)), "nothing was kept"
        memory().keep(["a.cpp"], ("-O2",), {"a.h"})
        assert memory().knows(["a.cpp"], ("-O2",))
        assert not memory().knows(["a.cpp"], ("-O0",)) and not memory("others").knows(["a.cpp"], ("-O2",))
        (root / "a.h").write_text("3")
        assert not memory().knows(["a.cpp"], ("-O2",)), "a header changed"
        (root / "a.h").write_text("2"), (root / "a.cpp").write_text("4")
        assert not memory().knows(["a.cpp"], ("-O2",)), "the source changed"
        (root / "a.cpp").write_text("1"), (root / "a.h").unlink()
        assert not memory().knows(["a.cpp"], ("-O2",)), "a header is gone"
        memory().forget(time.time() + 2 * FORGOTTEN)
        assert not list((root / "memory").iterdir())
    assert parted(["a", "b", "c"], {"b"}) == (["a", "c"], ["b"]), "what compiles stays together"
    assert parted(["a", "b"], {"a", "b"}) == (["a"], ["b"]), "no end"
    assert FINDING.findall("/a/b.cpp:1:2: error: x [bugprone-y]"), "a finding is not seen"


def main():
    self_test()
    parser = argparse.ArgumentParser()
    parser.add_argument("root", type=pathlib.Path)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("paths", nargs="*")
    parser.add_argument("--changed", action="store_true")
    parser.add_argument("--fresh", action="store_true")
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_intermixed_args()
    root, build = given.root.resolve(), given.build.resolve()
    linter = next((name for name in LINTERS if shutil.which(name)), None)
    if linter is None:
        print("no clang-tidy found: install the packages of packages.txt (tools/setup)")
        return 1
    todo = units(root, build, given.paths or ROOMS)
    if not todo:
        print(f"no source to lint in {build / 'compile_commands.json'}")
        return 1
    if given.changed:
        names = changed(root)
        if names is None:
            print("no branch main to compare with: linting everything")
        else:
            stems = {str(pathlib.PurePosixPath(name).with_suffix("")) for name in names}
            todo = {unit: words for unit, words in todo.items() if unit.removesuffix(".cpp") in stems}
    memory = None if given.fresh else memory_of(linter, root)
    begin, found = time.monotonic(), set()
    with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        for findings in pool.map(lambda batch: remembered(memory, linter, root, build, *batch), batches(todo)):
            for finding in sorted(findings - found):
                print(finding, flush=True)
            found |= findings
    if memory is not None:
        memory.forget(time.time())
    spent, used = time.monotonic() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{len(todo)} sources linted in {spent:.0f} s ({used.ru_utime + used.ru_stime:.0f} s of "
          f"processor time), {len(found)} findings")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
