#!/usr/bin/env python3
"""The form of commits: a subject that is an imperative of at most 60 columns, an empty line, a body that says why.

Usage: commits.py ROOT [RANGE]
RANGE as git log takes it; without it, all after the commit from which the form is held. Merges are left out. Ends with
77 (skipped) where the history is not there: a copy without git, a shallow clone.
"""
import re
import subprocess
import sys

HELD_SINCE = "fc62a7d"
SUBJECT, BODY = 60, 100
SEPARATOR = "\x1e"
# An imperative does not end like a participle, a past tense or a third person.
NOT_IMPERATIVE = re.compile(r"^(\w+ing|\w+[^eo]ed|[A-Z]\w*[^s]s)\b")
IMPERATIVES = ("Bring", "Ring", "String", "Need", "Speed", "Feed", "Seed", "Embed", "Shed", "Spring", "Bias",
               "Alias", "Focus")


def deviations(message):
    """What is wrong with one commit message."""
    lines = message.rstrip("\n").split("\n")
    subject = lines[0]
    first = subject.split(" ")[0]
    if len(subject) > SUBJECT:
        yield f"subject has {len(subject)} columns, at most {SUBJECT}"
    if not subject[:1].isupper():
        yield "subject begins without a capital"
    if subject.endswith("."):
        yield "subject ends with a full stop"
    if NOT_IMPERATIVE.match(subject) and first not in IMPERATIVES:
        yield f"subject begins with '{first}', not with an imperative"
    if len(lines) > 1 and lines[1]:
        yield "second line is not empty"
    if not any(line.strip() for line in lines[2:]):
        yield "no body that says why"
    for line in lines[2:]:
        if len(line) > BODY:
            yield f"body line of {len(line)} columns, at most {BODY}: {line[:40]}..."


def main():
    root = sys.argv[1]
    chosen = sys.argv[2] if len(sys.argv) > 2 else f"{HELD_SINCE}..HEAD"
    log = subprocess.run(["git", "-C", root, "log", "--no-merges", f"--format=%h %B{SEPARATOR}", chosen],
                         capture_output=True, text=True)
    if log.returncode != 0:
        print(f"skipped: no history of {chosen} here: {log.stderr.strip()[:200]}")
        return 77
    messages = [entry.strip("\n") for entry in log.stdout.split(SEPARATOR) if entry.strip()]
    complaints = 0
    for entry in messages:
        name, message = entry.split(" ", 1)
        for complaint in deviations(message):
            print(f"{name}: {complaint}")
            complaints += 1
    print(f"{len(messages)} commits read, {complaints} deviations; the form is in CONTRIBUTING.md")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
