#!/usr/bin/env python3
"""The diagnosis cannot read a sealed answer: nothing that it is built from knows the seal's name, its code or its folder.

usage: sealed_answer.py REPOSITORY
Checks the sources of tools/diagnose and of every folder it includes, and the libraries that its CMake files link.
"""
import pathlib
import re
import sys

FORBIDDEN = [r"answer\.sealed", r"tools/conceal", r"sanso_conceal", r"open_seal", r"namespace sanso::conceal", r"tools/plant"]


def folders_included_from(root: pathlib.Path, start: str) -> set[str]:
    """Folders that `start` includes, directly or through others."""
    found, open_folders = {start}, [start]
    while open_folders:
        folder = open_folders.pop()
        for path in (root / folder).rglob("*"):
            if path.suffix not in {".h", ".cpp"}:
                continue
            for include in re.findall(r'#include "([^"]+)"', path.read_text()):
                other = str(pathlib.PurePosixPath(include).parent)
                if other not in found and (root / other).is_dir():
                    found.add(other)
                    open_folders.append(other)
    return found


def main() -> int:
    root = pathlib.Path(sys.argv[1])
    folders = folders_included_from(root, "tools/diagnose")
    files, offences = 0, []
    for folder in sorted(folders):
        pattern = "**/*" if folder == "tools/diagnose" else "*"
        for path in sorted((root / folder).glob(pattern)):
            if path.suffix not in {".h", ".cpp"} and path.name != "CMakeLists.txt":
                continue
            files += 1
            for number, line in enumerate(path.read_text().splitlines(), 1):
                if any(re.search(f, line) for f in FORBIDDEN):
                    offences.append(f"{path.relative_to(root)}:{number}: {line.strip()}")
    print(f"{files} files of the diagnosis read, {len(offences)} know of sealed answers")
    print("\n".join(offences))
    return 1 if offences or files < 50 else 0


if __name__ == "__main__":
    sys.exit(main())
