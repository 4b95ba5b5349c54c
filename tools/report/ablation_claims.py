#!/usr/bin/env python3
"""The paper's claims about what its parts do, asked of ablated sessions.

    ablation_claims.py FOLDER [--seeds 1,2,3] [--bootstrap 10000] [--seed 1]

FOLDER holds session folders at any depth, each with summary.json of `sanso learn`. Sessions of one motion, world and
seed are compared with each other: the whole method and what was left out. Measures, claims and test are those of
docs/decisions/2026-11-26-ablation-plan.md. Prints Markdown: what every choice did, then the claims.
"""
import argparse
import collections
import itertools
import json
import math
import pathlib
import random
import statistics

LAST, EARLY, SETTLED = 10, slice(3, 10), 10  # trials: the last, the fourth to the tenth, those after the tenth
LEVEL = 0.05
CLAIMS = [  # (what is left out, measure, what the paper says)
    ("lower", "cost", "no motion without the lower layer"),
    ("upper", "cost", "no motion without the upper layer"),
    ("middle", "cost", "worse without the middle layer"),
    ("middle", "unrest of cost", "learned less stably without the middle layer"),
    ("residual", "loss", "a less accurate model without the network"),
    ("stochastic", "early loss", "a less accurate model without the stochastic term, early"),
    ("stochastic", "unrest of loss", "less stable without the stochastic term"),
    ("residual+stochastic", "unrest of loss", "unstable without both"),
]


def log_mean(values):
    """log10 of the mean of what is there; trials without data have no loss."""
    known = [v for v in values if v is not None and v > 0]
    return math.log10(statistics.fmean(known)) if known else math.nan


def unrest(values):
    known = [math.log10(v) for v in values if v is not None and v > 0]
    steps = [abs(b - a) for a, b in zip(known, known[1:])]
    return statistics.fmean(steps) if steps else math.nan


def measures(session):
    trials = session["iterations"]
    cost, loss = ([t[key] for t in trials] for key in ("cost", "model_loss"))
    return {
        "cost": log_mean(cost[-LAST:]),
        "success": sum(t["succeeded"] for t in trials[-LAST:]),
        "failed": sum(t["failed"] for t in trials),
        "loss": log_mean(loss[-LAST:]),
        "early loss": log_mean(loss[EARLY]),
        "unrest of cost": unrest(cost[SETTLED:]),
        "unrest of loss": unrest(loss[SETTLED:]),
    }


def load(folder, seeds):
    """measures by (motion, without) and (world, seed); sessions shorter than the longest are not finished."""
    found = collections.defaultdict(dict)
    sessions = [json.loads(p.read_text()) for p in sorted(pathlib.Path(folder).rglob("summary.json"))]
    sessions = [s for s in sessions if not seeds or s["seed"] in seeds]
    longest = max((len(s["iterations"]) for s in sessions), default=0)
    for session in sessions:
        if len(session["iterations"]) < longest:
            continue
        without = "+".join(sorted(session["without"])) or "none"
        found[session["motion"], without][session["world"], session["seed"]] = measures(session)
    return found


def differences(with_it, without_it, measure):
    """without - with, by world, of the pairs in which both are numbers."""
    by_world = collections.defaultdict(list)
    for key in sorted(with_it.keys() & without_it.keys()):
        d = without_it[key][measure] - with_it[key][measure]
        if math.isfinite(d):
            by_world[key[0]].append(d)
    return list(by_world.values())


def mean(by_world):
    return statistics.fmean(itertools.chain(*by_world))


def interval(by_world, count, seed):
    """95 % of the mean, seeds drawn again within worlds."""
    draw = random.Random(seed)
    means = sorted(mean([draw.choices(w, k=len(w)) for w in by_world]) for _ in range(count))
    return means[int(0.025 * count)], means[min(count - 1, int(0.975 * count))]


def sign_flip_p(by_world):
    """Two-sided p of the mean when every difference is as likely turned: all turns of up to 20, else 2^20 drawn."""
    values = list(itertools.chain(*by_world))
    seen = abs(sum(values)) * (1 - 1e-12)
    if len(values) <= 20:
        sums = [0.0]
        for v in values:
            sums = [s + t for s in sums for t in (v, -v)]
        return sum(abs(s) >= seen for s in sums) / len(sums)
    draw = random.Random(1)
    count = 1 << 20
    hits = sum(abs(sum(v if draw.random() < 0.5 else -v for v in values)) >= seen for _ in range(count))
    return (hits + 1) / (count + 1)


def holm(ps):
    """Adjusted p in the order given."""
    order = sorted(range(len(ps)), key=lambda i: ps[i])
    out, least = [0.0] * len(ps), 0.0
    for rank, i in enumerate(order):
        least = max(least, min(1.0, (len(ps) - rank) * ps[i]))
        out[i] = least
    return out


def say(difference, p):
    if p >= LEVEL:
        return "not decided"
    return "reproduced" if difference > 0 else "refuted"


def overview(found):
    print("| motion | without | sessions | success of the last 10, mean | sessions without success | trials that failed, mean | cost, last 10 "
          "| N-step loss, last 10 | early loss | unrest of cost, of loss |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for (motion, without), sessions in sorted(found.items(), key=lambda e: (e[0][0], e[0][1] != "none", e[0][1])):
        ms = list(sessions.values())

        def of(key, rows=ms):
            known = [m[key] for m in rows if math.isfinite(m[key])]
            return statistics.fmean(known) if known else math.nan
        print(f'| {motion} | {without} | {len(ms)} | {of("success"):.1f} | {sum(m["success"] == 0 for m in ms)} | {of("failed"):.1f} '
              f'| {10 ** of("cost"):.1f} | {10 ** of("loss"):.3f} | {10 ** of("early loss"):.3f} '
              f'| {of("unrest of cost"):.3f}, {of("unrest of loss"):.3f} |')


def claims(found, bootstrap, seed):
    rows = []
    for motion in sorted({m for m, _ in found}):
        for without, measure, text in CLAIMS:
            pairs = differences(found[motion, "none"], found[motion, without], measure)
            if sum(map(len, pairs)) < 2:
                continue
            low, high = interval(pairs, bootstrap, seed)
            rows.append((motion, text, measure, sum(map(len, pairs)), mean(pairs), low, high, sign_flip_p(pairs)))
    print("| motion | the paper | measure | pairs | difference | 95 % | p, Holm | |")
    print("|---|---|---|---|---|---|---|---|")
    for (motion, text, measure, count, d, low, high, _), p in zip(rows, holm([r[-1] for r in rows])):
        print(f"| {motion} | {text} | {measure} | {count} | {d:+.3f} | {low:+.3f} to {high:+.3f} | {p:.2g} | {say(d, p)} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--seeds", type=lambda text: [int(s) for s in text.split(",")], default=[],
                        help="sessions of these only (1,2,3); all when not given")
    parser.add_argument("--bootstrap", type=int, default=10000, help="draws of the intervals")
    parser.add_argument("--seed", type=int, default=1, help="of these draws")
    args = parser.parse_args()
    found = load(args.folder, args.seeds)
    if not found:
        parser.error(f"{args.folder}: no summary.json below it; run `sanso-sweep learn --out {args.folder}/...` first")
    overview(found)
    print()
    claims(found, args.bootstrap, args.seed)


if __name__ == "__main__":
    main()
