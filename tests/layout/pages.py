#!/usr/bin/env python3
"""What a reader meets first: first pages of at most 100 columns, links that lead somewhere, and an
index that lists every decision.

Usage: pages.py ROOT
"""
import pathlib
import re
import sys

LIMIT = 100
NARROW = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/tour.md", "docs/decisions/README.md")
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)|^\[[^\]]+\]:\s*(\S+)", re.M)


def wide(name, text):
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > LIMIT:
            yield f"{name}:{number}: {len(line)} columns, at most {LIMIT}"


def dead_links(root, name, text):
    """Links to files of the repository that are not there; addresses are left alone."""
    for match in LINK.finditer(text):
        target = (match.group(1) or match.group(2)).split("#")[0]
        if "://" in target or not target:
            continue
        if not (root / name).parent.joinpath(target).exists():
            yield f"{name}: link to {target}, which is not there"


def unlisted_decisions(root):
    index = (root / "docs/decisions/README.md").read_text(encoding="utf-8")
    for page in sorted((root / "docs/decisions").glob("2*.md")):
        if page.name not in index:
            yield f"docs/decisions/README.md: does not list {page.name}"


def main():
    root = pathlib.Path(sys.argv[1])
    assert list(wide("self-test", "x" * (LIMIT + 1))), "a wide line is not caught"
    assert list(dead_links(root, "README.md", "[a](no/such/page.md)")), "a dead link is not caught"
    found = list(unlisted_decisions(root))
    pages = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md",
             *(p.relative_to(root).as_posix() for p in sorted((root / "docs").rglob("*.md")))]
    for name in pages:
        text = (root / name).read_text(encoding="utf-8")
        found += wide(name, text) if name in NARROW else []
        found += dead_links(root, name, text)
    print("\n".join(found), end="\n" if found else "")
    print(f"{len(pages)} pages read, {len(found)} complaints")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
