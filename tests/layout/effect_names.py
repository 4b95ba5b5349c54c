#!/usr/bin/env python3
"""No effect is called by its id in the diagnosis but where it is declared.

Usage: effect_names.py ROOT
Reads the ids that tools/diagnose/effects declares (`.id = "..."`) and fails on every string in another room of
tools/diagnose that is one, or has one of several words in it, unless KEPT names it with a reason. What an effect is to
a room stands with the effect (Effect::effort, whole, drive, settings, ...); rooms ask the library for it.
"""
import pathlib
import re
import sys

HOUSE = "tools/diagnose"
LIBRARY = f"{HOUSE}/effects/"
# (file below tools/diagnose, id): why it is no name of an effect there.
KEPT = {
    ("formats/lost.cpp", "backlash"): "a word for a property of a joint that a format may lack, effect or not",
    ("formats/lost.cpp", "cogging"): "a word for a property of a joint that a format may lack, effect or not",
    ("model_folder/model_folder.cpp", "restitution"): "a key of model.toml",
    ("model_folder/whole_body.cpp", "restitution"): "a key of model.toml",
    ("settings_of_whole.h", "restitution"): "a setting's own name",
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


def complaints(files, kept):
    """files: {path from the root: text}."""
    ids = {i for path, text in files.items() if path.startswith(LIBRARY) for i in DECLARED.findall(text)}
    if not ids:
        yield f"{LIBRARY}: no effect is declared"
    seen = set()
    for path, text in sorted(files.items()):
        if path.startswith(LIBRARY):
            continue
        for line, name in names(text, ids):
            key = (path.removeprefix(HOUSE + "/"), name)
            seen.add(key)
            if key not in kept:
                yield f"{path}:{line}: {name} is an effect: ask the library, do not name it"
    for path, name in sorted(kept.keys() - seen):
        yield f"{HOUSE}/{path}: no {name}; take it off the list of tests/layout/effect_names.py"


def self_test():
    library = {f"{LIBRARY}x.cpp": '.id = "dry_friction",\n.id = "payload",'}

    def found(text, kept=()):
        return list(complaints({**library, f"{HOUSE}/fit/x.cpp": text}, dict.fromkeys(kept, "a reason")))

    for text in ('f("dry_friction");', 'if (id == "payload")', 'say("no dry_friction, no payload");',
                 '{"dry_friction",\n "payload"}', 'x = "a";  // "b"\ny = "payload";'):
        assert found(text), f"not caught: {text}"
    for text in ('say("a payload is heavy");', "// dry_friction is one", "dry_friction();", 'f("dry_friction_2");',
                 '#include "tools/dry_friction"', 'f("dry friction");'):
        assert not found(text), f"wrongly caught: {text}"
    assert not found('f("payload");', [("fit/x.cpp", "payload")])
    assert found("", [("fit/x.cpp", "payload")]), "a kept name that is gone"
    assert list(complaints({}, {})), "a library without effects"
    assert all(len(reason) > 4 for reason in KEPT.values())


def main():
    self_test()
    root = pathlib.Path(sys.argv[1])
    files = {p.relative_to(root).as_posix(): p.read_text(encoding="utf-8")
             for p in sorted((root / HOUSE).rglob("*")) if p.suffix in (".h", ".cpp", ".inc")}
    found = list(complaints(files, KEPT))
    print("\n".join(found + [f"{len(files)} files read, {len(KEPT)} names kept, {len(found)} complaints"]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
