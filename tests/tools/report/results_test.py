"""Laws of tools/results, on a tree of its own with a program that only says what it was asked."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
PROGRAM = """#!/bin/sh
echo "asked: $*"
[ "$1" = fail ] && exit 3
while [ $# -gt 1 ]; do [ "$1" = --out ] && mkdir -p "$2"; shift; done
exit 0
"""


class Results(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        for part in ("tools/results", "tests/layout/docs_commands.py"):
            (self.root / part).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / part, self.root / part)
        self.program = self.root / "build/dev/tools/sanso/sanso"
        self.program.parent.mkdir(parents=True)
        self.program.write_text(PROGRAM)
        self.program.chmod(0o755)
        (self.root / "docs/results").mkdir(parents=True)

    def tearDown(self):
        self.folder.cleanup()

    def page(self, name, *lines):
        (self.root / f"docs/results/{name}.md").write_text("\n".join(["# Page", "", "```sh", *lines, "```", ""]))

    def call(self, *words):
        done = subprocess.run([sys.executable, self.root / "tools/results", *words], capture_output=True, text=True,
                              env=dict(os.environ))
        return done.returncode, done.stdout + done.stderr

    def log(self, name):
        return (self.root / f"out/results/{name}.txt").read_text()

    def test_a_page_runs_what_it_says(self):
        self.page("a", "for n in 1 2; do", "  sanso bench $n", "done")
        self.assertEqual(self.call("a")[0], 0)
        self.assertIn("asked: bench 1\nasked: bench 2\n", self.log("a"))

    def test_a_command_that_fails_is_told_and_the_next_page_goes_on(self):
        self.page("a", "sanso fail", "sanso never")
        self.page("b", "sanso bench")
        code, said = self.call("a", "b")
        self.assertEqual(code, 1)
        self.assertIn("status 3, expected 0", said)
        self.assertNotIn("asked: never", self.log("a"))
        self.assertIn("asked: bench", self.log("b"))

    def test_a_session_that_is_there_goes_on(self):
        self.page("a", "sanso learn --motion stand --out runs/one")
        self.call("a")
        self.assertNotIn("--resume", self.log("a"))
        self.call("a")
        self.assertIn("asked: learn --motion stand --out runs/one --resume", self.log("a"))

    def test_what_is_to_be_filled_in_is_left_out(self):
        self.page("a", "sanso bench --setting NAME=FACTOR", "sanso bench --cases 2")
        self.call("a")
        self.assertNotIn("FACTOR", self.log("a"))
        self.assertIn("asked: bench --cases 2", self.log("a"))

    def test_nothing_is_run_unasked_and_nothing_without_a_program(self):
        self.page("a", "sanso bench")
        self.assertEqual(self.call()[0], 2)
        self.assertEqual(self.call("nowhere")[0], 1)
        self.program.unlink()
        code, said = self.call("a")
        self.assertEqual(code, 1)
        self.assertIn("cmake --build", said)


if __name__ == "__main__":
    unittest.main()
