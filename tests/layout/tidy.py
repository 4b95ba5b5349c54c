#!/usr/bin/env python3
"""clang-tidy over the rooms that hold it: every finding is an error; .clang-tidy says what is asked.

Usage: tidy.py ROOT BUILD [--changed] [--jobs N] [PATH...]
BUILD holds compile_commands.json. --changed: only sources that differ from the branch main, and
those whose header does. PATH: sources below it instead, also of rooms that are not held to it yet.
"""
import argparse
import collections
import concurrent.futures
import json
import pathlib
import re
import resource
import shlex
import shutil
import subprocess
import sys
import time

# More rooms join when they are clean.
ROOMS = ("firmware", "host/app", "host/learn", "host/link", "host/model", "tools/diagnose/gate",
         "tools/diagnose/model_folder", "tools/diagnose/stats")
TOGETHER = 8  # sources read at once
LINTERS = ("clang-tidy-14", "clang-tidy")
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


def lint(linter, root, build, names, words):
    """Findings in our own files; what the analyzer suspects inside of libraries is theirs.

    The sources stand one after the other in one file, so that the analyzer takes all of it for the main file. Where
    two of them define the same name the halves are read apart.
    """
    origin, text = [], []
    for name in names:
        lines = (root / name).read_text(encoding="utf-8").splitlines()
        origin += [(name, number) for number in range(1, len(lines) + 1)]
        text += lines
    folder = build / "lint"
    folder.mkdir(exist_ok=True)
    joined = folder / (names[0].replace("/", "_").removesuffix(".cpp") + f"_{len(names)}.cpp")
    joined.write_text("\n".join(text) + "\n", encoding="utf-8")
    config = f"--config-file={root / '.clang-tidy'}"
    run = subprocess.run([linter, "--quiet", config, str(joined), "--", *words],
                         capture_output=True, text=True, cwd=build)
    all_found = FINDING.findall(run.stdout)
    if len(names) > 1 and ("[clang-diagnostic-error]" in run.stdout or (run.returncode and not all_found)):
        half = len(names) // 2
        return lint(linter, root, build, names[:half], words) | lint(linter, root, build, names[half:], words)
    if run.returncode != 0 and not all_found:
        return {f"{names[0]}: clang-tidy failed: {run.stderr.strip()[-400:]}"}
    return set(own_findings(root, build, joined, origin, all_found))


def own_findings(root, build, joined, origin, all_found):
    """Findings as file:line: text, those of the joined file at the place where the line came from."""
    for path, line, text in all_found:
        where = pathlib.Path(path) if path.startswith("/") else (build / path).resolve()
        if where == joined:
            name, number = origin[int(line) - 1]
            yield f"{name}:{number}: {text}"
        elif where.is_relative_to(root):
            yield f"{where.relative_to(root)}:{line}: {text}"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("root", type=pathlib.Path)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("paths", nargs="*")
    parser.add_argument("--changed", action="store_true")
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
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
    assert FINDING.findall("/a/b.cpp:1:2: error: x [bugprone-y]"), "a finding is not seen"
    begin, found = time.monotonic(), set()
    with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        for findings in pool.map(lambda batch: lint(linter, root, build, *batch), batches(todo)):
            for finding in sorted(findings - found):
                print(finding, flush=True)
            found |= findings
    spent, used = time.monotonic() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{len(todo)} sources linted in {spent:.0f} s ({used.ru_utime + used.ru_stime:.0f} s of "
          f"processor time), {len(found)} findings")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
