#!/usr/bin/env python3
"""Every C++ file is what .clang-format says, and no line is wider than 100 columns.

Usage: format.py ROOT [--fix]
"""
import pathlib
import shutil
import subprocess
import sys

LIMIT = 100
TOPS = ("shared", "firmware", "host", "tools", "tests")
FORMATTERS = ("clang-format-14", "clang-format")


def sources(root):
    for top in TOPS:
        for path in sorted((root / top).rglob("*")):
            if path.suffix in (".h", ".cpp", ".inc"):
                yield path


def wide_lines(name, text):
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > LIMIT:
            yield f"{name}:{number}: {len(line)} columns, at most {LIMIT}"


def deviations(formatter, paths):
    """Names of the files that the formatter would change, with its first complaint about each."""
    result = subprocess.run([formatter, "--dry-run", *map(str, paths)], capture_output=True, text=True)
    seen = {}
    for line in result.stderr.splitlines():
        if "[-Wclang-format-violations]" in line:
            seen.setdefault(line.split(":")[0], line)
    return list(seen.values())


def main():
    root = pathlib.Path(sys.argv[1])
    formatter = next((f for f in FORMATTERS if shutil.which(f)), None)
    if formatter is None:
        print("no clang-format found: install the packages of packages.txt (tools/setup)")
        return 1
    paths = list(sources(root))
    if "--fix" in sys.argv:
        subprocess.run([formatter, "-i", *map(str, paths)], check=True)
    assert list(wide_lines("self-test", "x" * (LIMIT + 1))), "a wide line is not caught"
    found = [w for p in paths for w in wide_lines(p, p.read_text(encoding="utf-8"))]
    found += deviations(formatter, paths)
    print("\n".join(found))
    print(f"{len(paths)} files read, {len(found)} deviations; mend with tests/layout/format.py . --fix")
    return 1 if found or not paths else 0


if __name__ == "__main__":
    sys.exit(main())
