#!/usr/bin/env python3
"""Does a compiler see that the tick allocates nothing and waits for nothing, through every call that it makes?

Usage: function_effects.py CLANG UNIT ROOT SOURCE...
Writes all sources into one unit (UNIT), so that clang can infer the effect of every function below Controller::tick, and
compiles it with -Wfunction-effects as an error. Names that the unnamed namespaces of several sources share get a number.
Without vectors: Eigen's reductions of them call functions by pointer.
"""
import collections
import pathlib
import re
import subprocess
import sys

UNNAMED = re.compile(r"^namespace \{\n(.*?)^\}  // namespace$", re.M | re.S)
DECLARED = (re.compile(r"\b(k[A-Z]\w*) *[={\[(]"),              # constants
            re.compile(r"^[\w:<>,&* ]+[ &*](\w+)\(", re.M),       # functions
            re.compile(r"^(?:struct|class|enum|enum class) (\w+)", re.M))
INCLUDE = re.compile(r"^#include .*$", re.M)


def declared(text):
    """Names that the unnamed namespaces of a source declare."""
    return {name for block in UNNAMED.findall(text) for pattern in DECLARED for name in pattern.findall(block)}


def unit_of(sources):
    texts = {source: pathlib.Path(source).read_text(encoding="utf-8") for source in sources}
    owners = collections.Counter(name for text in texts.values() for name in declared(text))
    lines = sorted({line for text in texts.values() for line in INCLUDE.findall(text)})
    for number, (source, text) in enumerate(texts.items()):
        shared = sorted(name for name in declared(text) if owners[name] > 1)
        lines += [f"#define {name} {name}_of_{number}" for name in shared]
        lines.append(f'#include "{source}"')
        lines += [f"#undef {name}" for name in shared]
    return "\n".join(lines) + "\n"


def main():
    clang, unit, root, *sources = sys.argv[1:]
    pathlib.Path(unit).write_text(unit_of(sources), encoding="utf-8")
    command = [clang, "-std=c++20", "-fsyntax-only", "-fno-exceptions", "-fno-rtti", "-DEIGEN_DONT_VECTORIZE",
               "-Werror=function-effects", f"-I{root}", "-isystem", "/usr/include/eigen3", unit]
    done = subprocess.run(command)
    if done.returncode == 0:
        print(f"{len(sources)} sources: nothing below Controller::tick allocates, locks, throws or waits")
    return done.returncode


if __name__ == "__main__":
    sys.exit(main())
