#!/usr/bin/env python3
"""Who may include whom (docs/tour.md): reads every #include "..." of the product and fails on a forbidden direction.

Usage: include_rules.py ROOT [--table]
"""
import pathlib
import re
import sys

PAGE = "docs/tour.md"


# What the controller may include: shared without shared/files and mcap, which use heap and exceptions.
REALTIME = [f"shared/{room}" for room in ("base", "math", "model", "policy", "servo_bus", "wire")]
# Top-level folder -> folders it may include. docs/tour.md shows this table; the test compares.
MAY = {
    "shared/base": [],
    "shared/math": ["shared/base"],
    "shared/model": ["shared/base", "shared/math"],
    "shared/policy": ["shared/base", "shared/math", "shared/model"],
    "shared/servo_bus": ["shared/base"],
    "shared/wire": ["shared/base", "shared/math", "shared/model/state_layout.h",
                    "shared/policy/policy_types.h"],
    "shared/files": ["shared/base"],
    "shared/mcap": ["shared/base", "shared/files"],
    "shared/grounds": ["shared/base", "shared/files", "shared/model"],
    "firmware": REALTIME,
    "host": ["shared"],
    "tools/recording": ["shared/base", "shared/files", "shared/mcap"],
    "tools/page": ["shared", "host", "tools/plant", "tools/emulator"],
    "tools/export": ["shared", "firmware", "host", "tools/plant", "tools/emulator"],
    "tools/report": ["shared", "host", "tools/recording"],
    "tools/session_report": ["shared", "host", "tools/recording", "tools/report", "tools/page",
                             "tools/plant"],
    "tools/plant": ["shared/base", "shared/files", "shared/servo_bus"],
    "tools/emulator": ["shared/base", "shared/files", "shared/servo_bus", "tools/plant"],
    "tools/conceal": ["shared/base", "shared/files", "tools/recording", "tools/plant"],
    "tools/diagnose": ["shared", "host/model", "tools/recording"],
    "tools/bench": ["shared", "firmware", "host", "tools/recording", "tools/report",
                    "tools/diagnose"],
    "tools/campaign": ["shared", "firmware", "host", "tools/emulator", "tools/inprocess"],
    # The places where everything meets.
    "tools/inprocess": ["shared", "firmware", "host", "tools"],
    "tools/sanso": ["shared", "firmware", "host", "tools"],
    "tools/sweep": ["shared", "host", "tools/inprocess"],
    "tests": ["shared", "firmware", "host", "tools", "tests"],
}
# The floors of the large folders, ground floor first. A room may include what its folder may, and
# the rooms of the floors below; rooms of one floor do not know each other. What stands in the
# folder itself is the roof (a main) unless the folder is named as a room of its own (".").
FLOORS = {
    "firmware": [
        ["exchange"],
        ["board", "config"],
        ["bus"],
        ["estimate", "guard", "imu", "link", "log", "lower"],
        ["app"],
    ],
    "host": [
        ["learn", "link", "model", "motion/mocap"],
        ["learn/episodes", "mpc"],
        ["learn/layers", "learn/model", "motion"],
        ["learn/session", "motion/make"],
        ["app"],
    ],
    # The order of the method. settings.h stands below all rooms.
    "tools/diagnose": [
        ["."], ["stats"], ["model_folder"], ["gate"], ["sim"], ["effects"],
        ["compare", "formats"], ["torque"], ["fit"], ["explain"], ["verdict"], ["wholebody"],
        ["run"],
    ],
}
# What single rooms may include beyond their floor. Of the controller, what reads its configuration
# and writes its log is not real-time, and neither is main.
MORE = {
    "firmware": ["shared/files"],
    "firmware/config": ["shared/files"],
    "firmware/log": ["shared/files", "shared/mcap"],
    "tools/diagnose/run": ["host", "tools/report", "tools/page/embedded"],
}


def room_path(base, room):
    return base if room == "." else f"{base}/{room}"


def rules():
    """Folder -> folders it may include, with the rooms of the large folders."""
    table = dict(MAY)
    for base, floors in FLOORS.items():
        below = []
        for floor in floors:
            for room in floor:
                path = room_path(base, room)
                table[path] = MAY[base] + below + MORE.get(path, [])
            below = below + [room_path(base, room) for room in floor]
        if ["."] not in floors:
            table[base] = MAY[base] + below + MORE.get(base, [])
    return table


RULES = rules()
# Third-party headers that only some folders may use: the emulated world stays independent of our own model.
ONLY = {r"mujoco/": ["tools/plant", "tools/emulator", "tools/conceal", "tools/bench", "tests"]}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[">]')


def area_of(path):
    parts = path.split("/")
    for n in range(len(parts), 0, -1):
        candidate = "/".join(parts[:n])
        if candidate in RULES:
            return candidate
    return None


def within(path, folder):
    return path == folder or path.startswith(folder + "/")


def allowed_by(folder, target, area):
    """Whether `target` belongs to `folder`. Among the rooms of one folder a room is not its parts."""
    same_house = any(within(folder, base) and within(area, base) for base in FLOORS)
    return area_of(target) == folder if same_house else within(target, folder)


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
            elif area_of(target) != area and not any(allowed_by(f, target, area) for f in RULES[area]):
                yield path, number, target, f"{area} may include only {', '.join(RULES[area])}"


def product_files(root):
    for top in ("shared", "firmware", "host", "tools", "tests"):
        for path in sorted((root / top).rglob("*")):
            if path.suffix in (".h", ".hpp", ".cpp", ".cc", ".c", ".inc"):
                yield path.relative_to(root).as_posix(), path.read_text(encoding="utf-8")


def self_test():
    bad = [
        ("firmware/app/x.cpp", '#include "host/mpc/solver.h"'),
        ("tools/plant/x.cpp", '#include "shared/model/op3_step.h"'),
        ("shared/model/x.h", '#  include "shared/wire/codec.h"'),
        ("host/mpc/x.cpp", "#include <mujoco/mujoco.h>"),
        ("shared/wire/x.cpp", '#include "shared/files/hash.h"'),
        ("firmware/bus/x.cpp", '#include "shared/files/parallel.h"'),
        ("host/model/x.cpp", '#include "tools/recording/recording.h"'),
        ("firmware/bus/x.h", '#include "firmware/guard/guard.h"'),
        ("firmware/exchange/x.h", '#include "firmware/config/settings.h"'),
        ("host/learn/x.h", '#include "host/learn/session/trial.h"'),
        ("host/learn/layers/x.h", '#include "host/learn/model/identify.h"'),
        ("tools/diagnose/fit/x.h", '#include "tools/diagnose/explain/select.h"'),
    ]
    good = [
        ("tests/loop/x.cpp", '#include "tools/plant/world.h"'),
        ("host/learn/session/x.h", '#include "host/learn/model/identify.h"'),
        ("firmware/main.cpp", '#include "firmware/app/controller.h"'),
        ("firmware/log/x.cpp", '#include "shared/files/atomic_file.h"'),
        ("tools/diagnose/stats/x.h", '#include "tools/diagnose/settings.h"'),
    ]
    for item in bad:
        assert list(violations([item])), f"not caught: {item}"
    for item in good:
        assert not list(violations([item])), f"wrongly caught: {item}"


def table():
    """The rules as docs/tour.md shows them."""
    lines = ["| folder | may include |", "|---|---|"]
    for folder, others in MAY.items():
        shown = [o.rsplit("/", 1)[1] if o.endswith(".h") else o for o in others]
        lines.append(f"| {folder} | {', '.join(shown) or '-'} |")
    lines += ["", "Inside the large folders, ground floor first:", "", "```"]
    for base, floors in FLOORS.items():
        lines += [f"{base}:"] + [f"    {', '.join(floor)}" for floor in floors if floor != ["."]]
    lines += ["", "beyond that:"]
    lines += [f"    {room}: {', '.join(others)}" for room, others in MORE.items()]
    return "\n".join(lines + ["```"]) + "\n"


def complaints_about(root):
    """What the rules themselves have wrong: folders that are not there, a page that says otherwise."""
    for folder in RULES:
        if not (root / folder).is_dir():
            yield f"tests/layout/include_rules.py: no folder {folder}"
    page = (root / PAGE).read_text(encoding="utf-8")
    if table() not in page:
        yield f"{PAGE}: the table of includes is not what include_rules.py --table prints"


def main():
    root = pathlib.Path(sys.argv[1])
    if "--table" in sys.argv:
        print(table(), end="")
        return 0
    self_test()
    wrong = list(complaints_about(root))
    print("\n".join(wrong), end="\n" if wrong else "")
    files = list(product_files(root))
    found = list(violations(files))
    for path, number, target, reason in found:
        print(f'{path}:{number}: includes "{target}": {reason}')
    print(f"{len(files)} files read, {len(found)} forbidden includes")
    return 1 if found or wrong or not files else 0


if __name__ == "__main__":
    sys.exit(main())
