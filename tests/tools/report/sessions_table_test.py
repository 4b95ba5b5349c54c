"""Laws of the campaign's rows: nothing finished is lost, nothing unfinished counts, a replaced row is one row."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

TABLE = pathlib.Path(__file__).resolve().parents[3] / "tools/report/sessions_table.py"


def trial(number, right, cost=1.0, failed=False, loss=0.1):
    return {"trial": number, "succeeded": right, "failed": failed, "cost": cost, "model_loss": loss,
            "model_loss_initial": loss and 2 * loss, "model_loss_analytical": loss}


class SessionsTable(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        self.rows = self.root / "rows.csv"

    def tearDown(self):
        self.folder.cleanup()

    def session(self, motion, trials, world="back"):
        out = self.root / "runs" / f"{motion}_{world}"
        out.mkdir(parents=True, exist_ok=True)
        (out / "summary.json").write_text(json.dumps(
            {"motion": motion, "world": world, "seed": 1, "without": [], "iterations": trials}))

    def call(self, *words):
        done = subprocess.run([sys.executable, TABLE, *map(str, words)], capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

    def add(self, commit="abc"):
        return self.call("add", self.rows, self.root / "runs", "--commit", commit, "--trials", "12")

    def test_what_is_not_finished_does_not_count(self):
        self.session("stand", [trial(i, True) for i in range(11)])
        self.session("squat", [trial(i, True) for i in range(12)])
        self.assertEqual(self.add()[0], 0)
        self.assertEqual(len(self.rows.read_text().splitlines()), 2)

    def test_a_session_is_one_row_a_commit(self):
        self.session("stand", [trial(i, True) for i in range(12)])
        self.add()
        self.add()
        self.add("def")
        self.assertEqual(len(self.rows.read_text().splitlines()), 3)

    def test_it_counts_trials(self):
        self.session("stand", [trial(0, False, cost=9.0, failed=True, loss=None)] +
                     [trial(i, i != 5, cost=12.0 - i) for i in range(1, 12)])
        self.add()
        code, said = self.call("show", self.rows)
        self.assertEqual(code, 0)
        self.assertIn("| stand | back | failed | 2 | 9 | 9: 1 | 0.1; 0.2, 0.1, 0.1 |", said)
        self.assertIn("9 or 10 of the last 10 trials right in 1 of 1", said)

    def test_it_shows_one_commit(self):
        self.session("stand", [trial(i, True) for i in range(12)])
        self.add()
        self.session("squat", [trial(i, True) for i in range(12)])
        self.add("def")
        code, said = self.call("show", self.rows, "--commit", "abc")
        self.assertEqual(code, 0)
        self.assertIn("| stand |", said)
        self.assertNotIn("| squat |", said)
        code, said = self.call("show", self.rows, "--commit", "abd")
        self.assertNotEqual(code, 0)
        self.assertIn("no session of any world at abd", said)

    def test_a_file_of_something_else_is_refused(self):
        self.rows.write_text("a,b\n1,2\n")
        self.session("stand", [trial(i, True) for i in range(12)])
        code, said = self.add()
        self.assertNotEqual(code, 0)
        self.assertIn("line 1", said)
        self.assertEqual(self.rows.read_text(), "a,b\n1,2\n")


if __name__ == "__main__":
    unittest.main()
