#!/usr/bin/env python3
"""Tables and figures of docs/results from finished sessions.

    campaign.py learning FOLDER --figures docs/results/figures     FOLDER holds one session folder each, with summary.json
    campaign.py ablation FOLDER --figures docs/results/figures
    campaign.py motions FOLDER --figures docs/results/figures      one session of each motion: one table, cost and loss over trials
    campaign.py long SESSION --figures docs/results/figures        one long session
    campaign.py predictions predictions.json --figures docs/results/figures
    campaign.py pushes FILE... --figures docs/results/figures      pushes.json of `sanso-sweep pushes`

Prints the tables as Markdown. Reads only what `sanso learn` and `sanso-sweep` wrote.
"""
import argparse
import collections
import json
import math
import pathlib
import statistics

COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"]  # Okabe and Ito
MOTIONS = ["stand", "sway", "squat", "one_leg", "walk_forward", "walk_backward", "sidestep", "jog",
           "skate_ramp", "skate_jump"]


def load(folder):
    """Summaries of all sessions below `folder`, sorted by motion, world and seed."""
    found = [json.loads(f.read_text()) for f in pathlib.Path(folder).glob("*/summary.json")]
    order = {m: i for i, m in enumerate(MOTIONS)}
    return sorted(found, key=lambda s: (order.get(s["motion"], 99), s["world"], s["seed"]))


def moving_average(values, width=10):
    return [sum(values[max(0, i - width + 1):i + 1]) / min(i + 1, width) for i in range(len(values))]


class Chart:
    """One chart with linear x and linear or logarithmic y."""

    def __init__(self, title, x_label, y_label, x_range, y_range, log=False, width=430, height=270):
        self.size, self.log, self.x_range, self.y_range = (width, height), log, x_range, y_range
        self.body = [f'<text x="{width / 2}" y="16" text-anchor="middle" font-size="13">{title}</text>',
                     f'<text x="{width / 2}" y="{height - 6}" text-anchor="middle">{x_label}</text>',
                     f'<text transform="translate(13,{height / 2}) rotate(-90)" text-anchor="middle">{y_label}</text>']
        self.legend = 0
        for tick in self.ticks(*y_range, log):
            y = self.y(tick)
            self.body.append(f'<path d="M52 {y:.1f}H{width - 12}" stroke="#ddd"/>'
                             f'<text x="48" y="{y + 4:.1f}" text-anchor="end">{tick:g}</text>')
        for tick in self.ticks(*x_range, False):
            self.body.append(f'<text x="{self.x(tick):.1f}" y="{height - 24}" text-anchor="middle">{tick:g}</text>')

    @staticmethod
    def ticks(low, high, log):
        if log:
            return [m * 10.0**e for e in range(-5, 5) for m in (1, 2, 5) if low <= m * 10.0**e <= high]
        step = 10 ** math.floor(math.log10(high - low))
        step = step / 5 if (high - low) / step < 2 else step / 2 if (high - low) / step < 5 else step
        return [round(i * step, 10) for i in range(math.ceil(low / step), math.floor(high / step) + 1)]

    def x(self, value):
        return 52 + (value - self.x_range[0]) / (self.x_range[1] - self.x_range[0]) * (self.size[0] - 64)

    def y(self, value):
        low, high = self.y_range
        if self.log:
            value, low, high = (math.log(max(v, 1e-9)) for v in (value, low, high))
        return 28 + (high - min(max(value, low), high)) / (high - low) * (self.size[1] - 70)

    def line(self, xs, ys, colour, name="", width=1.6):
        points = " ".join(f"{self.x(a):.1f},{self.y(b):.1f}" for a, b in zip(xs, ys))
        self.body.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="{width}"/>')
        self.name(colour, name)

    def band(self, xs, lows, highs, colour):
        points = [f"{self.x(a):.1f},{self.y(b):.1f}" for a, b in zip(xs, lows)]
        points += [f"{self.x(a):.1f},{self.y(b):.1f}" for a, b in reversed(list(zip(xs, highs)))]
        self.body.append(f'<polygon points="{" ".join(points)}" fill="{colour}" opacity="0.18"/>')

    def name(self, colour, name):
        if not name:
            return
        y = 36 + 14 * self.legend
        self.legend += 1
        self.body.append(f'<path d="M{self.size[0] - 150} {y - 4}h18" stroke="{colour}" stroke-width="2"/>'
                         f'<text x="{self.size[0] - 127}" y="{y}">{name}</text>')


def write(path, charts, columns=2):
    width, height = charts[0].size
    rows = math.ceil(len(charts) / columns)
    columns = min(columns, len(charts))
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {columns * width} {rows * height}" '
             'font-family="sans-serif" font-size="11"><rect width="100%" height="100%" fill="white"/>']
    for i, chart in enumerate(charts):
        parts.append(f'<g transform="translate({i % columns * width},{i // columns * height})">' + "".join(chart.body) + "</g>")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(parts) + "</svg>\n")


def best_cost(iterations):
    return min((i["cost"] for i in iterations if not i["failed"]), default=math.nan)


def broken_in(iterations):
    """How often each clause was broken, or how trials ended that ended early."""
    words = [c.split()[0] for i in iterations for c in i["broken_clauses"]] + [i["end"] for i in iterations if i["failed"]]
    return ", ".join(f"{name} {count}" for name, count in collections.Counter(words).most_common()) or "-"


def learning_table(sessions):
    print("| motion | world | trials | succeeded, of the last 10 | first success | first cost | best cost | best / first | broken in the last 10 |")
    print("|---|---|---|---|---|---|---|---|---|")
    for s in sessions:
        its = s["iterations"]
        first_success = next((str(i["trial"] + 1) for i in its if i["succeeded"]), "-")
        print(f'| {s["motion"]} | {s["world"]} | {len(its)} | {sum(i["succeeded"] for i in its[-10:])} | {first_success} | '
              f'{its[0]["cost"]:.3g}{" (fell)" if its[0]["failed"] else ""} | {best_cost(its):.2g} | '
              f'{best_cost(its) / its[0]["cost"]:.2g} | {broken_in(its[-10:])} |')


def loss_table(sessions):
    """N-step losses on trials that no learning has seen yet: each is predicted before the next learning takes it in."""
    print("\n| motion | world | initial model | identified | as used (with network) | share used | initial / used | trials worse with network |")
    print("|---|---|---|---|---|---|---|---|")
    for s in sessions:
        last = [i for i in s["iterations"][-10:] if i["model_loss"] is not None]
        mean = [statistics.fmean(i[k] for i in last) for k in ("model_loss_initial", "model_loss_analytical", "model_loss")]
        share = f'{statistics.fmean(i["residual_share"] for i in last):.2f}' if "residual_share" in last[0] else "1"
        worse = sum(i["model_loss"] > i["model_loss_analytical"] for i in s["iterations"] if i["model_loss"] is not None)
        print(f'| {s["motion"]} | {s["world"]} | {mean[0]:.3f} | {mean[1]:.3f} | {mean[2]:.3f} | {share} | '
              f'{mean[0] / mean[2]:.0f} x | {worse} of {len(s["iterations"])} |')


def curves(session, key, label, title):
    its = session["iterations"]
    values = [max(i[key], 1e-4) for i in its]
    chart = Chart(title, "trial", label, (1, len(its)), (min(values) * 0.8, max(values) * 1.25), log=True)
    xs = [i["trial"] + 1 for i in its]
    chart.line(xs, values, "#bbbbbb", "each trial", 1.0)
    chart.line(xs, moving_average(values), COLOURS[0 if key == "model_loss" else 1], "mean of 10")
    return chart


def learning(args):
    sessions = load(args.inputs[0])
    learning_table(sessions)
    loss_table(sessions)
    lab = {s["motion"]: s for s in sessions if s["world"] == "lab"}
    if not lab:
        return
    bars = Chart("Best cost over first cost, world lab", "motion", "ratio", (0, len(lab)), (0.0, 1.05), width=760)
    for i, (name, s) in enumerate(lab.items()):
        ratio = best_cost(s["iterations"]) / s["iterations"][0]["cost"]
        x, y = bars.x(i + 0.15), bars.y(ratio)
        bars.body.append(f'<rect x="{x:.1f}" y="{y:.1f}" width="{0.7 * (bars.x(1) - bars.x(0)):.1f}" height="{bars.y(0) - y:.1f}" fill="#d55e00"/>'
                         f'<text x="{bars.x(i + 0.5):.1f}" y="{y - 4:.1f}" text-anchor="middle">{name} {ratio:.2f}</text>')
    bars.line((0, len(lab)), (1, 1), "#000000", "", 1.0)
    write(args.figures / "learning_bars.svg", [bars], 1)
    charts = []
    for name in ("one_leg", "walk_forward", "sidestep", "jog"):
        if name in lab:
            charts += [curves(lab[name], "cost", "cost J", f"{name}: cost"),
                       curves(lab[name], "model_loss", "N-step loss", f"{name}: N-step loss")]
    write(args.figures / "learning_curves.svg", charts)


def mean_of(its, key):
    values = [i[key] for i in its if i[key] is not None]
    return statistics.fmean(values) if values else math.nan


def motions(args):
    sessions = load(args.inputs[0])
    print("| motion | world | trials | succeeded | of the last 20 | first success | first cost | best cost | N-step loss, last ten: initial -> used | broken in the last 20 |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for s in sessions:
        its = s["iterations"]
        first = next((str(i["trial"] + 1) for i in its if i["succeeded"]), "-")
        print(f'| {s["motion"]} | {s["world"].split("+")[0]} | {len(its)} | {sum(i["succeeded"] for i in its)} | {sum(i["succeeded"] for i in its[-20:])} | {first} | '
              f'{its[0]["cost"]:.3g}{" (failed)" if its[0]["failed"] else ""} | {best_cost(its):.3g} | '
              f'{mean_of(its[-10:], "model_loss_initial"):.3g} -> {mean_of(its[-10:], "model_loss"):.3g} | {broken_in(its[-20:])} |')
    write(args.figures / "motions_cost.svg", [curves(s, "cost", "cost J", s["motion"]) for s in sessions])


def groups_of(sessions):
    groups = {}
    for s in sessions:
        groups.setdefault("+".join(s["without"]) or "proposed", []).append(s)
    return groups


def ablation(args):
    groups = groups_of(load(args.inputs[0]))
    print("| without | seeds | succeeded, of all trials | cost of the last 10, mean (lowest to highest seed) | failed trials | N-step loss of the last 10, mean (lowest to highest seed) |")
    print("|---|---|---|---|---|---|")
    for name, sessions in groups.items():
        cost = [statistics.fmean(i["cost"] for i in s["iterations"][-10:]) for s in sessions]
        loss = [statistics.fmean(i["model_loss"] for i in s["iterations"][-10:]) for s in sessions]
        its = [i for s in sessions for i in s["iterations"]]
        print(f'| {name} | {len(sessions)} | {sum(i["succeeded"] for i in its)} of {len(its)} | '
              f'{statistics.fmean(cost):.1f} ({min(cost):.1f} to {max(cost):.1f}) | {sum(i["failed"] for i in its)} | '
              f'{statistics.fmean(loss):.3f} ({min(loss):.3f} to {max(loss):.3f}) |')
    figures = [("Layers: cost", "cost J", "cost", ["proposed", "lower", "middle", "upper"]),
               ("Model: N-step loss", "N-step loss", "model_loss", ["proposed", "residual", "stochastic", "residual+stochastic"])]
    charts = []
    for title, label, key, names in figures:
        lines = {n: [moving_average([i[key] for i in s["iterations"]]) for s in groups[n]] for n in names if n in groups}
        values = [v for line in lines.values() for one in line for v in one]
        count = min(len(one) for line in lines.values() for one in line)
        chart = Chart(title, "trial", label, (1, count), (min(values) * 0.8, max(values) * 1.3), log=True)
        for colour, (name, line) in zip(COLOURS, lines.items()):
            columns = list(zip(*[one[:count] for one in line]))
            xs = range(1, count + 1)
            chart.band(xs, [min(c) for c in columns], [max(c) for c in columns], colour)
            chart.line(xs, [statistics.fmean(c) for c in columns], colour, name if name == "proposed" else f"without {name}")
        charts.append(chart)
    write(args.figures / "ablation.svg", charts)


def long_session(args):
    s = json.loads((pathlib.Path(args.inputs[0]) / "summary.json").read_text())
    cost = [i["cost"] for i in s["iterations"]]
    late = cost[100:]
    print(f'{len(cost)} trials of {s["motion"]}: lowest cost {min(cost):.2f} (trial {cost.index(min(cost)) + 1}); after trial 100 '
          f'between {min(late):.2f} and {max(late):.2f}, largest / lowest of all {max(late) / min(cost):.2f}; '
          f'{sum(not i["succeeded"] for i in s["iterations"])} trials did not succeed')
    gains = Chart("Gains", "trial", "mean norm of K", (1, len(cost)), (0, 1.2 * max(i["gain_upper"] for i in s["iterations"])))
    xs = range(1, len(cost) + 1)
    gains.line(xs, [i["gain_upper"] for i in s["iterations"]], COLOURS[0], "upper layer")
    gains.line(xs, [i["gain_middle"] for i in s["iterations"]], COLOURS[1], "middle layer")
    write(args.figures / "learning_long.svg", [curves(s, "cost", "cost J", f'{s["motion"]}, {len(cost)} trials'), gains])


def sign_test(a, b):
    """Two-sided p of a against b when both are equally likely."""
    n, k = a + b, min(a, b)
    return min(1.0, 2 * sum(math.comb(n, i) for i in range(k + 1)) / 2**n) if n else 1.0


def paired_table(campaigns):
    """The pushes are the same for every choice of layers: how often did only one of two choices survive?"""
    print("\nonly with all layers / only without the layer (p of a two-sided sign test):\n")
    print("| without | " + " | ".join(data["motion"] for data in campaigns) + " |\n|---|" + "---|" * len(campaigns))
    for name in ("lower", "middle", "upper"):
        cells = []
        for data in campaigns:
            whole, less = ({(p["impulse_Ns"], p["direction_rad"]): p["survived"] for p in data["pushes"] if p["without"] == n}
                           for n in ("none", name))
            a, b = sum(whole[k] and not less[k] for k in whole), sum(less[k] and not whole[k] for k in whole)
            cells.append(f"{a} / {b} (p {sign_test(a, b):.2g})")
        print(f"| {name} | " + " | ".join(cells) + " |")


def pushes(args):
    charts = []
    merged = {}
    for data in (json.loads(pathlib.Path(f).read_text()) for f in args.inputs):  # several seeds of one motion are one campaign
        merged.setdefault(data["motion"], data | {"pushes": []})["pushes"] += data["pushes"]
    for data in merged.values():
        largest = max(p["impulse_Ns"] for p in data["pushes"])
        edges = [largest * k / 8 for k in range(9)]
        chart = Chart(f'{data["motion"]}, world {data["world"]}', "impulse [N s]", "share on its feet", (0, largest), (0, 1.02))
        names = sorted({p["without"] for p in data["pushes"]}, key=["none", "lower", "middle", "upper"].index)
        print(f'\n{data["motion"]}:\n\n| without | ' + " | ".join(f"{a:.2f} to {b:.2f} N s" for a, b in zip(edges, edges[1:])) + " | all |")
        print("|---|" + "---|" * 9)
        for colour, name in zip(COLOURS, names):
            mine = [p for p in data["pushes"] if p["without"] == name]
            bins = [[p["survived"] for p in mine if a <= p["impulse_Ns"] < b + 1e-9] for a, b in zip(edges, edges[1:])]
            print(f"| {name} | " + " | ".join(f"{sum(b)} of {len(b)}" for b in bins) + f' | {sum(p["survived"] for p in mine)} of {len(mine)} |')
            drawn = [((a + b) / 2, statistics.fmean(v)) for a, b, v in zip(edges, edges[1:], bins) if v]
            chart.line([d[0] for d in drawn], [d[1] for d in drawn], colour, "all layers" if name == "none" else f"without {name}")
        charts.append(chart)
    paired_table(list(merged.values()))
    write(args.figures / "pushes.svg", charts)


def predictions(args):
    data = json.loads(pathlib.Path(args.inputs[0]).read_text())
    recorded, charts = data["recorded"], []
    for channel in [k for k in recorded if k != "t"]:
        for i, model in enumerate(data["models"]):
            values = recorded[channel]
            margin = 0.15 * (max(values) - min(values))
            unit = "m" if channel.startswith("base") else "rad"
            chart = Chart(f'{channel}: {"with" if model["network"] else "without"} network', "time [s]", f"[{unit}]",
                          (0, recorded["t"][-1]), (min(values) - margin, max(values) + margin), height=190)
            chart.line(recorded["t"][::3], values[::3], COLOURS[2])
            for stretch in model["stretches"]:
                chart.line(stretch["t"], stretch[channel], COLOURS[0 if model["network"] else 6])
                chart.body.append(f'<circle cx="{chart.x(stretch["t"][0]):.1f}" cy="{chart.y(stretch[channel][0]):.1f}" r="2.5"/>')
            charts.append(chart)
    for model in data["models"]:
        print(f'{model["session"]}: N-step loss {model["n_step_loss"]:.4f}')
    write(args.figures / "predictions.svg", charts)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["learning", "motions", "ablation", "long", "predictions", "pushes"])
    parser.add_argument("inputs", nargs="+")
    parser.add_argument("--figures", type=pathlib.Path, default=pathlib.Path("docs/results/figures"))
    args = parser.parse_args()
    {"learning": learning, "motions": motions, "ablation": ablation, "long": long_session, "predictions": predictions,
     "pushes": pushes}[args.what](args)


if __name__ == "__main__":
    main()
