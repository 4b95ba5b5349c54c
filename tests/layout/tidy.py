#!/usr/bin/env python3
"""clang-tidy over the rooms that hold it: every finding is an error; .clang-tidy says what is asked.

Usage: tidy.py ROOT BUILD [--changed] [--jobs N] [PATH...]
BUILD holds compile_commands.json. --changed: only sources that differ from the branch main, and
those whose header does. PATH: sources below it instead, also of rooms that are not held to it yet.
"""
import argparse
import concurrent.futures
import json
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import time

# More rooms join when they are clean.
ROOMS = ("firmware", "host/app", "host/learn", "host/link", "host/model")
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
    """Sources with a compile command below the rooms, relative to the root."""
    commands = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    inside = []
    for entry in commands:
        path = pathlib.Path(entry["file"])
        if path.is_relative_to(root):
            name = path.relative_to(root).as_posix()
            if any(name == room or name.startswith(room + "/") for room in rooms):
                inside.append(name)
    return sorted(set(inside))


def lint(linter, root, build, unit):
    """Findings in our own files; what the analyzer suspects inside of libraries is theirs."""
    run = subprocess.run([linter, "--quiet", "-p", str(build), str(root / unit)],
                         capture_output=True, text=True)
    all_found = FINDING.findall(run.stdout)
    if run.returncode != 0 and not all_found:
        return {f"{unit}: clang-tidy failed: {run.stderr.strip()[-400:]}"}
    return {f"{pathlib.Path(path).relative_to(root)}:{line}: {text}"
            for path, line, text in all_found if pathlib.Path(path).is_relative_to(root)}


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
            todo = [unit for unit in todo if unit.removesuffix(".cpp") in stems]
    assert FINDING.findall("/a/b.cpp:1:2: error: x [bugprone-y]"), "a finding is not seen"
    begin, found = time.monotonic(), set()
    with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        for findings in pool.map(lambda unit: lint(linter, root, build, unit), todo):
            for finding in sorted(findings - found):
                print(finding, flush=True)
            found |= findings
    spent, used = time.monotonic() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{len(todo)} sources linted in {spent:.0f} s ({used.ru_utime + used.ru_stime:.0f} s of "
          f"processor time), {len(found)} findings")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
