#!/usr/bin/env python3
"""One row for every finished session of a campaign, kept in a file that grows, and what they show.

    sessions_table.py add ROWS.csv FOLDER --commit HASH   takes in FOLDER/*/summary.json; a session that is there is replaced
    sessions_table.py show ROWS.csv [--world back,worst] [--commit HASH]  prints the tables as Markdown

A campaign of 64 sessions takes hours: what is finished is kept, with the commit of the program, and the same command goes on.
Sessions with fewer trials than --trials (default 100) are not finished and are left out.
"""
import argparse
import csv
import json
import math
import os
import pathlib
import statistics
import sys

KEY = ["commit", "motion", "world", "seed", "without"]
FIGURES = ["trials", "first_failed", "first_right", "failed", "right_of_last_10", "first_cost", "best_cost", "cost_of_last_10",
           "first_loss", "initial_loss_of_last_10", "identified_loss_of_last_10", "loss_of_last_10"]
MOTIONS = ["stand", "sway", "squat", "one_leg", "walk_forward", "walk_backward", "sidestep", "jog", "skate_ramp", "skate_jump"]


def mean(trials, key):
    known = [t[key] for t in trials if t[key] is not None]
    return f"{statistics.fmean(known):.4g}" if known else ""


def row_of(summary, commit):
    trials = summary["iterations"]
    last = trials[-10:]
    losses = [t["model_loss"] for t in trials if t["model_loss"] is not None]
    best = min((t["cost"] for t in trials if not t["failed"]), default=math.nan)
    return {
        "commit": commit, "motion": summary["motion"], "world": summary["world"].split("+")[0], "seed": str(summary["seed"]),
        "without": "+".join(summary["without"]), "trials": len(trials), "first_failed": int(not trials[0]["succeeded"]),
        "first_right": next((t["trial"] + 1 for t in trials if t["succeeded"]), ""),
        "failed": sum(t["failed"] for t in trials), "right_of_last_10": sum(t["succeeded"] for t in last),
        "first_cost": f'{trials[0]["cost"]:.4g}', "best_cost": f"{best:.4g}", "cost_of_last_10": mean(last, "cost"),
        "first_loss": f"{losses[0]:.4g}" if losses else "",
        "initial_loss_of_last_10": mean(last, "model_loss_initial"),
        "identified_loss_of_last_10": mean(last, "model_loss_analytical"), "loss_of_last_10": mean(last, "model_loss")}


def key_of(row):
    return tuple(row[k] for k in KEY)


def read(path):
    if not path.exists():
        return {}
    with path.open(newline="") as file:
        reader = csv.DictReader(file)
        if reader.fieldnames != KEY + FIGURES:
            sys.exit(f"{path}: line 1: expected the columns {','.join(KEY + FIGURES)}")
        return {key_of(row): row for row in reader}


def write(path, rows):
    """Beside and renamed: a run that is ended halfway loses nothing."""
    beside = path.with_suffix(".tmp")
    with beside.open("w", newline="") as file:
        writer = csv.DictWriter(file, KEY + FIGURES, lineterminator="\n")
        writer.writeheader()
        order = {m: f"{i:02}" for i, m in enumerate(MOTIONS)}
        for key in sorted(rows, key=lambda k: (k[0], order.get(k[1], k[1]), k[2:])):
            writer.writerow(rows[key])
    os.replace(beside, path)


def add(args):
    rows, before = read(args.rows), 0
    for file in sorted(pathlib.Path(args.folder).glob("*/summary.json")):
        summary = json.loads(file.read_text())
        if len(summary["iterations"]) < args.trials:
            before += 1
            continue
        row = row_of(summary, args.commit)
        rows[key_of(row)] = row
    write(args.rows, rows)
    print(f"{args.rows}: {len(rows)} sessions; {before} of {args.folder} not finished")


def wilson(k, n, z=1.96):
    """95 % interval of a share."""
    middle, half = (k + z * z / 2) / (n + z * z), z * math.sqrt(k * (n - k) / n + z * z / 4) / (n + z * z)
    return f"{k} of {n} [{100 * (middle - half):.0f}, {100 * (middle + half):.0f}] %"


def show(args):
    worlds = args.world.split(",") if args.world else None
    rows = [r for r in read(args.rows).values()
            if (not worlds or r["world"] in worlds) and args.commit in (None, r["commit"])]
    if not rows:
        sys.exit(f"{args.rows}: no session of {args.world or 'any world'} at {args.commit or 'any commit'}; "
                 "see `sessions_table.py add --help`")
    print("| motion | world | first trial | first right | right of the last 10 | cost, first: best | "
          "N-step loss: first; last ten initial, identified, used |")
    print("|---|---|---|---|---|---|---|")
    for r in rows:
        print(f'| {r["motion"]} | {r["world"]} | {"failed" if int(r["first_failed"]) else "right"} | {r["first_right"] or "-"} | '
              f'{r["right_of_last_10"]} | {r["first_cost"]}: {r["best_cost"]} | {r["first_loss"] or "none"}; '
              f'{r["initial_loss_of_last_10"]}, {r["identified_loss_of_last_10"]}, {r["loss_of_last_10"]} |')
    good = sum(int(r["right_of_last_10"]) >= 9 for r in rows)
    fails = sum(int(r["first_failed"]) for r in rows)
    falls = sum(int(r["loss_of_last_10"] != "" and float(r["loss_of_last_10"]) < float(r["initial_loss_of_last_10"])) for r in rows)
    print(f"\n{len(rows)} sessions: 9 or 10 of the last 10 trials right in {wilson(good, len(rows))}; trial 1 fails in "
          f"{wilson(fails, len(rows))}; loss of the model in use under that of the initial model in {wilson(falls, len(rows))}.")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    one = commands.add_parser("add", help="take in what is finished")
    one.add_argument("rows", type=pathlib.Path)
    one.add_argument("folder", type=pathlib.Path)
    one.add_argument("--commit", required=True, help="of the program that ran")
    one.add_argument("--trials", type=int, default=100)
    one.set_defaults(run=add)
    other = commands.add_parser("show", help="print the tables")
    other.add_argument("rows", type=pathlib.Path)
    other.add_argument("--world", help="a comma between two")
    other.add_argument("--commit", help="of the program that ran; otherwise of all")
    other.set_defaults(run=show)
    args = parser.parse_args()
    args.run(args)


if __name__ == "__main__":
    main()
