"""Laws of the claims' test: what is certain is decided by its sign, chance is not, unfinished sessions do not count."""
import contextlib
import importlib.util
import io
import itertools
import json
import pathlib
import random
import sys
import tempfile
import unittest

PATH = pathlib.Path(__file__).resolve().parents[3] / "tools/report/ablation_claims.py"
spec = importlib.util.spec_from_file_location("ablation_claims", PATH)
tool = importlib.util.module_from_spec(spec)
spec.loader.exec_module(tool)


def trials(cost, loss, count=30, right=False):
    return [{"succeeded": right, "failed": False, "cost": cost * (1 + 0.01 * (i % 2)), "model_loss": loss} for i in range(count)]


class Claims(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def session(self, without, world, seed, its, motion="jog"):
        out = self.root / ("-".join(without) or "none") / f"{motion}_{world}_{seed}"
        out.mkdir(parents=True)
        (out / "summary.json").write_text(json.dumps(
            {"motion": motion, "world": world, "seed": seed, "without": without, "iterations": its}))

    def said(self, *words):
        out = io.StringIO()
        argv, sys.argv = sys.argv, ["ablation_claims.py", str(self.root), "--bootstrap", "200", *words]
        try:
            with contextlib.redirect_stdout(out):
                tool.main()
        finally:
            sys.argv = argv
        return out.getvalue()

    def study(self, factor):
        draw = random.Random(3)
        for world, seed in itertools.product(("a", "b", "c"), range(1, 6)):
            noise = draw.uniform(0.9, 1.1)
            self.session([], world, seed, trials(10 * noise, 0.1))
            self.session(["lower"], world, seed, trials(10 * noise * factor(draw), 0.1))

    def test_what_always_costs_more_is_reproduced(self):
        self.study(lambda draw: draw.uniform(1.2, 1.5))
        row = next(l for l in self.said().splitlines() if "without the lower layer" in l)
        self.assertIn("| reproduced |", row)
        self.assertIn("| 15 |", row)

    def test_what_always_costs_less_is_refuted(self):
        self.study(lambda draw: draw.uniform(0.6, 0.8))
        self.assertIn("| refuted |", self.said())

    def test_chance_decides_nothing(self):
        self.study(lambda draw: draw.uniform(0.8, 1.25))
        self.assertIn("| not decided |", self.said())

    def test_what_is_not_finished_does_not_count(self):
        self.study(lambda draw: 1.3)
        self.session(["upper"], "a", 1, trials(99, 0.1, count=29))
        self.assertNotIn("upper", self.said())

    def test_only_the_seeds_that_are_asked_for(self):
        self.study(lambda draw: 1.3)
        row = next(l for l in self.said("--seeds", "1,2").splitlines() if "without the lower layer" in l)
        self.assertIn("| 6 |", row)

    def test_p_of_turned_signs_is_the_share_of_turns_as_far_from_nothing(self):
        self.assertEqual(tool.sign_flip_p([[1.0, 1.0, 1.0]]), 0.25)
        self.assertEqual(tool.sign_flip_p([[1.0, -1.0]]), 1.0)
        self.assertEqual(tool.sign_flip_p([[3.0, 1.0], [1.0]]), 2 / 8)

    def test_holm_asks_most_of_the_smallest(self):
        self.assertEqual(tool.holm([0.04, 0.01, 0.03]), [0.06, 0.03, 0.06])

    def test_losses_of_trials_without_data_are_left_out(self):
        self.assertAlmostEqual(tool.log_mean([None, 0.1, 0.1]), -1.0)


if __name__ == "__main__":
    unittest.main()
