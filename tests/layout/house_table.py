#!/usr/bin/env python3
"""How the house is built, in figures: lengths of files and functions, widths, comments, tests over code, back arrows.

Usage: house_table.py ROOT [--report]
Prints the table for the whole tree and for tools/diagnose, then the limits with what was measured; fails when one is
broken (with --report it only says so). Functions are found by universal-ctags (first line to last line).
"""
import itertools
import pathlib
import re
import shutil
import subprocess
import sys

TOPS = ("shared", "firmware", "host", "tools", "tests")
SOURCES = (".h", ".cpp", ".inc")
DIAGNOSE = "tools/diagnose"
HOUSES = ("firmware", "host", DIAGNOSE)  # inside these, no two rooms may lean on each other
# Files that are tables made by a program: one long function each, which nobody reads.
GENERATED = ()
LONG, TOO_LONG, WIDE, LONG_FILE = 50, 80, 100, 400
TEXT_LITERAL = re.compile(r'"(?:[^"\\\n]|\\.)*"')
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.M)


def read_tree(root):
    """{path from the root: text} of every C++ file."""
    return {p.relative_to(root).as_posix(): p.read_text(encoding="utf-8")
            for top in TOPS for p in sorted((root / top).rglob("*")) if p.suffix in SOURCES}


def functions(root, paths):
    """[(path, first line, name, lines)] of every function with a body."""
    command = ["ctags", "--quiet=yes", "--languages=C++", "--langmap=C++:+.inc.h", "--kinds-C++=f", "-L", "-", "-x",
               "--_xformat=%F\t%n\t%{end}\t%N"]
    output = subprocess.run(command, cwd=root, input="\n".join(paths), capture_output=True, text=True, check=True).stdout
    found = []
    for line in output.splitlines():
        path, first, last, name = line.split("\t")
        if last.isdigit():
            found.append((path, int(first), name, int(last) - int(first) + 1))
    return found


def comment_lines(text):
    """Lines that hold a comment, alone or behind code."""
    count, inside = 0, False
    for line in TEXT_LITERAL.sub('""', text).splitlines():
        count += bool(line.strip()) and (inside or "//" in line or "/*" in line)
        inside = (inside or "/*" in line) and "*/" not in line
    return count


def non_blank(text):
    return sum(1 for line in text.splitlines() if line.strip())


def percentile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else 0


def spread(values):
    return f"{percentile(values, 0.5)} / {percentile(values, 0.9)} / {max(values, default=0)}"


def back_arrows(files, house):
    """Pairs of rooms (folders below `house`) that lean on each other, directly or through others."""
    leans = {}
    for path, text in files.items():
        room = path.rpartition("/")[0]
        if not path.startswith(house + "/"):
            continue
        leans.setdefault(room, set())
        for target in INCLUDE.findall(text):
            other = target.rpartition("/")[0]
            if other.startswith(house + "/") and other != room:
                leans[room].add(other)
    reach = {room: closure(room, leans) for room in leans}
    return [(a, b) for a, b in itertools.combinations(sorted(leans), 2) if b in reach[a] and a in reach[b]]


def closure(room, leans):
    seen, waiting = set(), [room]
    while waiting:
        for other in leans.get(waiting.pop(), ()):
            if other not in seen:
                seen.add(other)
                waiting.append(other)
    return seen


def area_of(path):
    parts = path.split("/")
    return "/".join(parts[:2]) if parts[0] == "tools" else parts[0]


def test_ratios(files):
    """{area: non-blank lines of tests/<area> over those of the area}."""
    code, tests = {}, {}
    for path, text in files.items():
        lines, is_test = non_blank(text), path.startswith("tests/")
        area = area_of(path.removeprefix("tests/"))
        table = tests if is_test else code
        table[area] = table.get(area, 0) + lines
    return {area: tests.get(area, 0) / lines for area, lines in sorted(code.items())}


def comment_share(files):
    return f"{100.0 * sum(map(comment_lines, files.values())) / max(1, sum(map(non_blank, files.values()))):.1f} %"


def column(files, found):
    """The figures of one column of the table: what is measured over `files` and their functions."""
    lengths = [len(t.splitlines()) for t in files.values()]
    sizes = [lines for _, _, _, lines in found]
    total = sum(lengths)
    headers = {p: t for p, t in files.items() if p.endswith(".h")}
    wide = sum(len(line) > WIDE for t in files.values() for line in t.splitlines())
    share = lambda n, of: f"{n} ({100.0 * n / max(1, of):.2f} %)"
    return {
        "files, lines": f"{len(files)}, {total}",
        "file lines, median / p90 / max": spread(lengths),
        f"files over {LONG_FILE} lines": str(sum(n > LONG_FILE for n in lengths)),
        "functions": str(len(sizes)),
        "function lines, median / p90 / max": spread(sizes),
        f"functions over {LONG} lines": share(sum(n > LONG for n in sizes), len(sizes)),
        f"functions over {TOO_LONG} lines": share(sum(n > TOO_LONG for n in sizes), len(sizes)),
        f"lines over {WIDE} columns": share(wide, total),
        "comment lines, all / headers": f"{comment_share(files)} / {comment_share(headers)}",
    }


def print_table(columns):
    print(f"{'':36}" + "".join(f"{name:>22}" for name in columns))
    for row in next(iter(columns.values())):
        print(f"{row:36}" + "".join(f"{values[row]:>22}" for values in columns.values()))


def limits(files, found):
    """[(what, measured, bound, broken?, where it is broken)]"""
    named = lambda items: [f"{path}:{line}: {name}, {lines} lines" for path, line, name, lines in items]
    over = [f for f in found if f[3] > LONG]
    far_over = [f for f in found if f[3] > TOO_LONG and f[0] not in GENERATED]
    share = len(over) / max(1, len(found))
    wide = [f"{p}:{n}" for p, t in files.items() for n, line in enumerate(t.splitlines(), 1) if len(line) > WIDE]
    large = [f"{p}: {len(t.splitlines())} lines" for p, t in files.items() if len(t.splitlines()) > LONG_FILE]
    bare = [p for p, t in files.items() if not t.startswith(("//", "/*"))]
    arrows = [f"{a} <-> {b}" for house in HOUSES for a, b in back_arrows(files, house)]
    ratio = test_ratios(files).get(DIAGNOSE, 0.0)
    return [
        (f"functions over {LONG} lines", f"{100 * share:.2f} %", "at most 0.5 %", share > 0.005, named(over)),
        (f"functions over {TOO_LONG} lines", len(far_over), "none", bool(far_over), named(far_over)),
        (f"lines over {WIDE} columns", len(wide), "none", bool(wide), wide),
        (f"files over {LONG_FILE} lines", len(large), "none", bool(large), large),
        ("files that open without a comment", len(bare), "none", bool(bare), bare),
        (f"tests over code of {DIAGNOSE}", f"{ratio:.2f}", "at least 0.5", ratio < 0.5, []),
        ("back arrows in " + ", ".join(HOUSES), len(arrows), "none", bool(arrows), arrows),
    ]


def self_test():
    circle = {"host/a/x.h": '#include "host/b/y.h"', "host/b/y.h": '#include "host/c/z.h"',
              "host/c/z.h": '#include "host/a/x.h"', "host/d/w.h": '#include "host/a/x.h"'}
    assert len(back_arrows(circle, "host")) == 3, "a circle of three rooms is three pairs"
    assert not back_arrows({k: v for k, v in circle.items() if k != "host/c/z.h"}, "host")
    ratio = test_ratios({"tools/diagnose/fit/a.cpp": "x\n\ny\n", "tests/tools/diagnose/fit/a.cpp": "x\n"})
    assert ratio == {DIAGNOSE: 0.5}, "blank lines do not count"
    wide = {"host/a/x.h": "x" * (WIDE + 1), "host/b/y.h": "x\n" * (LONG_FILE + 1)}
    broken = {what for what, _, _, bad, _ in limits(wide, [("host/a/x.h", 1, "f", TOO_LONG + 1)]) if bad}
    assert len(broken) == 6, f"a limit does not hold what it says: {broken}"
    assert comment_lines('// a\nint b;  // c\n/* d\ne */\n\nf("//");\n') == 4


def main():
    root = pathlib.Path(sys.argv[1])
    self_test()
    if shutil.which("ctags") is None:
        print("no ctags found: install the packages of packages.txt (tools/setup)")
        return 1
    files = read_tree(root)
    found = functions(root, list(files))
    inside = lambda path: path.startswith(DIAGNOSE + "/")
    product = {p: t for p, t in files.items() if not p.startswith("tests/")}
    print_table({
        "tree": column(files, found),
        "product": column(product, [f for f in found if f[0] in product]),
        "diagnose": column({p: t for p, t in files.items() if inside(p)}, [f for f in found if inside(f[0])]),
    })
    print("\ntests over code (non-blank lines): " + ", ".join(f"{a} {r:.2f}" for a, r in test_ratios(files).items()) + "\n")
    failed = False
    for what, measured, bound, broken, where in limits(files, found):
        failed |= broken
        print(f"{'BROKEN' if broken else 'holds '} {what}: {measured} ({bound})")
        print("".join(f"       {w}\n" for w in where if broken), end="")
    return 1 if (failed and "--report" not in sys.argv) or not found else 0


if __name__ == "__main__":
    sys.exit(main())
