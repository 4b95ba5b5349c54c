#!/usr/bin/env python3
"""Who may include whom (docs/tour.md): reads every #include "..." of the product and fails on a forbidden direction.

Usage: include_rules.py ROOT [--self-test]
"""
import pathlib
import re
import sys



def rooms(base, outside, order):
    """Rules for rooms that build on each other: each may include `outside` and the rooms before it."""
    table = {base: outside}
    for number, room in enumerate(order):
        table[f"{base}/{room}"] = outside + [f"{base}/{r}" for r in order[:number]] + [f"{base}/constants.h"]
    return table


# Folder -> folders it may include. The longest matching folder decides; a folder may always include itself.
MAY = {
    "shared/base": [],
    "shared/math": ["shared/base"],
    "shared/model": ["shared/base", "shared/math"],
    "shared/policy": ["shared/base", "shared/math", "shared/model"],
    "shared/servo_bus": ["shared/base"],
    "shared/wire": ["shared/base", "shared/math", "shared/model/state_layout.h", "shared/policy/policy_types.h"],
    "firmware": ["shared"],
    "host": ["shared", "tools/recording"],
    "tools/recording": ["shared/base"],
    "tools/report": ["shared", "host", "tools/recording"],
    "tools/plant": ["shared/base", "shared/servo_bus"],
    "tools/emulator": ["shared/base", "shared/servo_bus", "tools/plant"],
    "tools/conceal": ["shared/base", "tools/recording", "tools/plant"],
    # The rooms of the diagnosis, in the order of the method: each may include those above it.
    **rooms("tools/diagnose", ["shared", "host/model", "host/learn/hash.h", "tools/recording"],
            ["stats", "model_folder", "gate", "sim", "effects", "compare", "fit", "explain",
             "verdict", "run"]),
    "tools/diagnose/run": ["shared", "host", "tools/recording", "tools/report", "tools/diagnose"],
    "tools/bench": ["shared", "host", "firmware", "tools/recording", "tools/report", "tools/diagnose"],
    # The places where everything meets.
    "tools/inprocess": ["shared", "firmware", "host", "tools"],
    "tools/sanso": ["shared", "firmware", "host", "tools"],
    "tools/sweep": ["shared", "host", "tools/inprocess"],
    "tests": ["shared", "firmware", "host", "tools", "tests"],
}
# Third-party headers that only some folders may use: the emulated world stays independent of our own model.
ONLY = {r"mujoco/": ["tools/plant", "tools/emulator", "tools/conceal", "tools/bench", "tests"]}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[">]')


def area_of(path):
    parts = path.split("/")
    for n in range(len(parts), 0, -1):
        candidate = "/".join(parts[:n])
        if candidate in MAY:
            return candidate
    return None


def within(path, folder):
    return path == folder or path.startswith(folder + "/")


def violations(files):
    """files: iterable of (path from the root, text). Yields (path, line number, include, reason)."""
    for path, text in files:
        area = area_of(path)
        for number, line in enumerate(text.splitlines(), 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            kind, target = match.groups()
            for pattern, allowed in ONLY.items():
                if re.match(pattern, target) and not any(within(path, a) for a in allowed):
                    yield path, number, target, f"only {', '.join(allowed)} may"
            if kind == "<":
                continue
            if area is None:
                yield path, number, target, "the including folder has no rule"
            elif not within(target, area) and not any(within(target, folder) for folder in MAY[area]):
                yield path, number, target, f"{area} may include only {', '.join([area] + MAY[area])}"


def product_files(root):
    for top in ("shared", "firmware", "host", "tools", "tests"):
        for path in sorted((root / top).rglob("*")):
            if path.suffix in (".h", ".hpp", ".cpp", ".cc", ".c", ".inc"):
                yield path.relative_to(root).as_posix(), path.read_text(encoding="utf-8")


def self_test():
    bad = [
        ("firmware/app/x.cpp", '#include "host/mpc/solver.h"'),
        ("tools/plant/x.cpp", '#include "shared/model/tree.h"'),
        ("shared/model/x.h", '#  include "shared/wire/codec.h"'),
        ("host/mpc/x.cpp", "#include <mujoco/mujoco.h>"),
    ]
    good = [("tests/loop/x.cpp", '#include "tools/plant/world.h"'), ("host/a/b.h", '#include "host/c/d.h"')]
    for item in bad:
        assert list(violations([item])), f"not caught: {item}"
    for item in good:
        assert not list(violations([item])), f"wrongly caught: {item}"


def main():
    root = pathlib.Path(sys.argv[1])
    self_test()
    files = list(product_files(root))
    found = list(violations(files))
    for path, number, target, reason in found:
        print(f'{path}:{number}: includes "{target}": {reason}')
    print(f"{len(files)} files read, {len(found)} forbidden includes")
    return 1 if found or not files else 0


if __name__ == "__main__":
    sys.exit(main())
