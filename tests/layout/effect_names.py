#!/usr/bin/env python3
"""No effect is called by its id but where it is declared.

Usage: effect_names.py ROOT
Reads the ids that tools/diagnose/effects declares (`.id = "..."`) and fails on every string of the product that is one,
or has one of several words in it, unless KEPT or READERS names it with a reason. What an effect is to a room of the
diagnosis stands with the effect (Effect::effort, whole, drive, settings, ...); rooms ask the library for it. Who must
not include the library and still speaks of effects is a reader, whose names a test holds to the library.
"""
import pathlib
import re
import sys

TOPS = ("shared", "firmware", "host", "tools")
LIBRARY = "tools/diagnose/effects/"
# (file, id): why it is no name of an effect there.
KEPT = {
    ("tools/conceal/experiment.cpp", "payload"): "a condition of an experiment",
    ("tools/diagnose/formats/lost.cpp", "backlash"): "a word for a property of a joint that a format may lack",
    ("tools/diagnose/formats/lost.cpp", "cogging"): "a word for a property of a joint that a format may lack",
    ("tools/diagnose/model_folder/model_folder.cpp", "restitution"): "a key of model.toml",
    ("tools/diagnose/model_folder/whole_body.cpp", "restitution"): "a key of model.toml",
    ("tools/diagnose/settings_of_whole.h", "restitution"): "a setting's own name",
    ("tools/plant/world.cpp", "load_friction"): "a key of a world's file",
    ("tools/recording/joint_settings.h", "current_limit"): "a key of model.toml",
    ("tools/recording/joint_settings.h", "torque_constant"): "a key of model.toml",
    ("tools/recording/sidecar.cpp", "payload"): "a key of a recording's sidecar",
}
# File or folder that speaks of effects without including the library, and the test that compares.
READERS = {
    "host/learn/model/named_figures.cpp": "tests/host/learn/model/figure_names_test.cpp",
    "tools/conceal/built.cpp": "tests/tools/conceal/conceal_test.cpp",
    "tools/conceal/conceal.cpp": "tests/tools/conceal/conceal_test.cpp",
    "tools/conceal/hideable_body.cpp": "tests/tools/conceal/conceal_test.cpp",
    "tools/conceal/hideable_drive.cpp": "tests/tools/conceal/conceal_test.cpp",
    "tools/conceal/hideable_servo.cpp": "tests/tools/conceal/conceal_test.cpp",
    "tools/conceal/floor_effects.cpp": "tests/tools/conceal/floor_test.cpp",
    "tools/conceal/floor_world.cpp": "tests/tools/conceal/floor_test.cpp",
}
DECLARED = re.compile(r'\.id\s*=\s*"(\w+)"')
INCLUDE = re.compile(r"^\s*#[^\n]*", re.M)
TEXT = re.compile(r'"((?:[^"\\\n]|\\.)*)"')
TOKEN = re.compile(TEXT.pattern + r"|//[^\n]*|/\*.*?\*/", re.S)  # whichever begins first holds the other


def blank(match):
    """Keeps lines where they are."""
    return re.sub(r"[^\n]", " ", match.group())


def names(text, ids):
    """[(line, id)] of the ids in strings of the source."""
    text = INCLUDE.sub(blank, TOKEN.sub(lambda m: m.group() if m.group().startswith('"') else blank(m), text))
    found = []
    for string in TEXT.finditer(text):
        words = re.findall(r"\w+", string.group(1))
        # a single word is an id only where it stands alone: payload and tether are words of sentences too
        for word in words:
            if word in ids and ("_" in word or string.group(1) == word):
                found.append((text.count("\n", 0, string.start()) + 1, word))
    return found


def complaints(files, kept, readers):
    """files: {path from the root: text}, tests included."""
    ids = {i for path, text in files.items() if path.startswith(LIBRARY) for i in DECLARED.findall(text)}
    if not ids:
        yield f"{LIBRARY}: no effect is declared"
    seen, speaking = set(), set()
    for path, text in sorted(files.items()):
        if path.startswith((LIBRARY, "tests/")):
            continue
        for line, name in names(text, ids):
            seen.add((path, name))
            if path in readers:
                speaking.add(path)
            elif (path, name) not in kept:
                yield f"{path}:{line}: {name} is an effect: ask the library, do not name it"
    for path, name in sorted(kept.keys() - seen):
        yield f"{path}: no {name}; take it off the list of tests/layout/effect_names.py"
    for path, test in sorted(readers.items()):
        if path not in speaking:
            yield f"{path}: no effect in it; take it off the list of tests/layout/effect_names.py"
        if "find_effect(" not in files.get(test, ""):
            yield f"{test}: does not ask the library for the names of {path}"


def self_test():
    library = {f"{LIBRARY}x.cpp": '.id = "dry_friction",\n.id = "payload",'}

    def found(text, kept=(), where="tools/diagnose/fit/x.cpp", readers=None, tests=()):
        files = {**library, where: text, **dict(tests)}
        return list(complaints(files, dict.fromkeys(kept, "a reason"), readers or {}))

    for text in ('f("dry_friction");', 'if (id == "payload")', 'say("no dry_friction, no payload");',
                 '{"dry_friction",\n "payload"}', 'x = "a";  // "b"\ny = "payload";'):
        assert found(text), f"not caught: {text}"
        assert found(text, where="host/app/x.cpp"), f"not caught in host: {text}"
    for text in ('say("a payload is heavy");', "// dry_friction is one", "dry_friction();", 'f("dry_friction_2");',
                 '#include "tools/dry_friction"', 'f("dry friction");'):
        assert not found(text), f"wrongly caught: {text}"
    assert not found('f("payload");', [("tools/diagnose/fit/x.cpp", "payload")])
    assert found("", [("tools/diagnose/fit/x.cpp", "payload")]), "a kept name that is gone"
    reader, compares = {"host/x.cpp": "tests/x.cpp"}, [("tests/x.cpp", "find_effect(name)")]
    assert not found('f("payload");', where="host/x.cpp", readers=reader, tests=compares)
    assert found('f("payload");', where="host/x.cpp", readers=reader), "a reader that no test compares"
    assert found("", where="host/x.cpp", readers=reader, tests=compares), "a reader that names none"
    assert list(complaints({}, {}, {})), "a library without effects"
    assert all(len(reason) > 4 for reason in KEPT.values())


def main():
    self_test()
    root = pathlib.Path(sys.argv[1])
    files = {p.relative_to(root).as_posix(): p.read_text(encoding="utf-8")
             for top in (*TOPS, "tests") for p in sorted((root / top).rglob("*")) if p.suffix in (".h", ".cpp", ".inc")}
    found = list(complaints(files, KEPT, READERS))
    print("\n".join(found + [f"{len(files)} files read, {len(KEPT)} names kept, {len(READERS)} readers, "
                             f"{len(found)} complaints"]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
