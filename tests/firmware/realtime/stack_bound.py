#!/usr/bin/env python3
"""How much stack a tick can need at most, from the instructions of the program itself.

Usage: stack_bound.py PROGRAM REALTIME_CPP
Follows every call from Controller::tick. Fails when one of them makes a frame whose size is not known when it is compiled
(alloca, array of variable length), when a function can come back to itself, when a call by pointer leaves by another way than
the board's interface, or when the sum is more than half of the stack that REALTIME_CPP touches before the first tick.
"""
import collections
import pathlib
import re
import subprocess
import sys

ROOT = "sanso::firmware::Controller::tick(long)"
SEAM = re.compile(r"^sanso::board::\w+(::\w+)*::(read|write|ready|now|thread_cpu)\(")  # behind the interfaces of board.h
MAY_CALL_BY_POINTER = re.compile(r"\bsanso::firmware::(Controller|BusMaster)::|\bsanso::board::")
LIBRARY = 8 * 1024  # allowed to one call into libc, libm or libusb, whose instructions are not read
HEAD = re.compile(r"^[0-9a-f]+ <(.+)>:$")
PUSH = re.compile(r"\tpush ")
SUB = re.compile(r"\t(?:sub +\$0x([0-9a-f]+)|add +\$0xf+([0-9a-f]+)|lea +-0x([0-9a-f]+)\(%rsp\)),%rsp")
DYNAMIC = re.compile(r"\tsub +%\w+,%rsp")
GO = re.compile(r"\t(?:bnd |notrack )?(call|jmp|j\w+) +[0-9a-f]+ <(.+)>$")
POINTER = re.compile(r"\t(?:bnd )?(?:call|jmp) +\*(?:0x[0-9a-f]+)?\(%r\w+\)|\tcall +\*")

Function = collections.namedtuple("Function", "frame dynamic pointer calls")


def disassemble(program):
    """{name: Function} of every function in the program."""
    text = subprocess.run(["objdump", "-d", "-C", "--no-show-raw-insn", program], capture_output=True, text=True, check=True).stdout
    functions, name, lines = {}, None, []
    for line in text.splitlines() + ["0 <end>:"]:
        head = HEAD.match(line)
        if not head:
            lines.append(line)
            continue
        if name is not None:
            one = measure(name, lines)
            if name in functions:  # two with one name, in unnamed namespaces: the larger of each figure
                old = functions[name]
                one = Function(max(old.frame, one.frame), old.dynamic or one.dynamic, old.pointer or one.pointer, old.calls | one.calls)
            functions[name] = one
        name, lines = head[1], []
    return functions


def measure(name, lines):
    """Its frame, an upper bound: every push and every subtraction that it contains, and the return address."""
    frame, calls, dynamic, pointer = 8, set(), False, False
    for line in lines:
        frame += 8 if PUSH.search(line) else 0
        sub = SUB.search(line)
        if sub:
            frame += int(sub[1] or sub[3], 16) if not sub[2] else 0x100 - int(sub[2], 16) & 0xff
        dynamic = dynamic or bool(DYNAMIC.search(line))
        pointer = pointer or bool(POINTER.search(line))
        go = GO.search(line)
        # a jump into the middle of a function is its own cold part's way back
        if go and not re.search(r"\+0x[0-9a-f]+$", go[2]) and go[2] != name or go and go[1] == "call":
            calls.add(re.sub(r"\+0x[0-9a-f]+$", "", go[2]))
    return Function(frame, dynamic, pointer, calls)


class Walk:
    def __init__(self, functions):
        self.functions, self.depth, self.open, self.broken = functions, {}, [], []

    def below(self, name):
        """(bytes, path) of the deepest way from `name` down, itself included."""
        if name in self.depth:
            return self.depth[name]
        if name in self.open:
            self.broken.append("comes back to itself: " + " -> ".join(self.open[self.open.index(name):] + [name]))
            return 0, []
        if name == "__assert_fail@plt":
            return 0, []  # the end of the program
        if name.endswith("@plt") or name not in self.functions:
            return LIBRARY, [name]
        one = self.functions[name]
        if one.dynamic:
            self.broken.append("a frame of a size that only the run knows: " + name)
        if one.pointer and not MAY_CALL_BY_POINTER.search(name):
            self.broken.append("calls by pointer: " + name)
        self.open.append(name)
        ways = [self.below(call) for call in sorted(one.calls)]
        if one.pointer and not SEAM.search(name):
            ways += [self.below(f) for f in sorted(self.functions) if SEAM.search(f)]
        elif one.pointer:
            ways.append((LIBRARY, ["by pointer"]))
        self.open.pop()
        deepest = max(ways, default=(0, []), key=lambda way: way[0])
        self.depth[name] = one.frame + deepest[0], [name] + deepest[1]
        return self.depth[name]


def main():
    program, source = sys.argv[1:]
    functions = disassemble(program)
    if ROOT not in functions:
        sys.exit(f"{program}: no {ROOT}; expected the onboard controller with its symbols")
    touched = re.search(r"kTouchedStack_bytes = (\d+) \* 1024", pathlib.Path(source).read_text(encoding="utf-8"))
    if not touched:
        sys.exit(f"{source}: expected a line 'kTouchedStack_bytes = N * 1024'")
    walk = Walk(functions)
    total, path = walk.below(ROOT)
    print(f"{len(walk.depth)} functions; the deepest way of a tick needs at most {total} bytes "
          f"({LIBRARY} of them for a library), touched are {int(touched[1]) * 1024}:")
    for name in path:
        print(f"{functions[name].frame if name in functions else LIBRARY:8d}  {name[:150]}")
    if 2 * total > int(touched[1]) * 1024:
        walk.broken.append(f"{total} bytes are more than half of the stack that is touched before the first tick")
    for line in sorted(set(walk.broken)):
        print("BROKEN: " + line)
    return 1 if walk.broken else 0


if __name__ == "__main__":
    sys.exit(main())
