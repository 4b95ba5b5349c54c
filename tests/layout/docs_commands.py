#!/usr/bin/env python3
"""Runs every command shown in README.md and docs/, so that none goes stale.

A fenced block marked `sh` holds commands, one a line (a trailing backslash continues). A block preceded by the comment
`<!-- not run: REASON -->` is listed with its reason instead. `<!-- exit: N -->` before a block states the expected status.
Blocks of one page run in order in one scratch folder, with the built programs on the PATH.

Usage: docs_commands.py ROOT BUILD [PAGE...]
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

NOT_RUN = re.compile(r"<!--\s*not run:\s*(.+?)\s*-->")
EXIT = re.compile(r"<!--\s*exit:\s*(\d+)\s*-->")
TIME_LIMIT_S = 600


def blocks(text):
    """Yields (line number, reason or None, expected exit status, commands)."""
    lines = text.splitlines()
    reason, status, i = None, 0, 0
    while i < len(lines):
        line = lines[i].strip()
        if line.startswith("```"):
            language, start, body = line[3:].strip(), i + 1, []
            i += 1
            while i < len(lines) and not lines[i].strip().startswith("```"):
                body.append(lines[i])
                i += 1
            if language == "sh":
                yield start + 1, reason, status, commands(body)
            reason, status = None, 0
        elif line:
            if NOT_RUN.search(line):
                reason = NOT_RUN.search(line).group(1)
            elif EXIT.search(line):
                status = int(EXIT.search(line).group(1))
            else:
                reason, status = None, 0
        i += 1


def commands(body):
    joined, out = "", []
    for line in body:
        joined += line.rstrip()
        if joined.endswith("\\"):
            joined = joined[:-1]
            continue
        if joined.strip() and not joined.strip().startswith("#"):
            out.append(joined.strip())
        joined = ""
    return out


def program_folders(build):
    return sorted({str(p.parent) for p in build.glob("*/**/*") if p.name.startswith("sanso") and os.access(p, os.X_OK) and p.is_file()})


def main():
    root, build = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    pages = [root / p for p in sys.argv[3:]] or [root / "README.md", *sorted((root / "docs").rglob("*.md"))]
    env = dict(os.environ, PATH=os.pathsep.join([*program_folders(build), os.environ["PATH"]]))
    ran = skipped = failed = 0
    for page in pages:
        name = page.relative_to(root)
        with tempfile.TemporaryDirectory() as scratch:
            # Pages speak from the top of a clone: they see the tree, and what they write stays in the scratch folder.
            for entry in root.iterdir():
                if entry.name not in ("build", "out", "runs", ".git"):
                    os.symlink(entry, os.path.join(scratch, entry.name))
            for number, reason, status, lines in blocks(page.read_text(encoding="utf-8")):
                for command in lines:
                    if reason:
                        skipped += 1
                        print(f"skip {name}:{number}: {command}  ({reason})")
                        continue
                    done = subprocess.run(["bash", "-c", command], cwd=scratch, env=env, stdout=subprocess.PIPE,
                                          stderr=subprocess.STDOUT, text=True, timeout=TIME_LIMIT_S, check=False)
                    ran += 1
                    if done.returncode != status:
                        failed += 1
                        print(f"FAIL {name}:{number}: {command}\n  status {done.returncode}, expected {status}\n{done.stdout[-2000:]}")
    print(f"{ran} commands ran, {skipped} not run for a stated reason, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
