"""Makes the table of large blocks of benches/README.md, and the figure of cost against time.

usage: blocks.py WORK [--sizes 50,200,500,1000,2000] [--reps 3] [--ceres BAL_CERES] [--ba BA] [--block BLOCK]
                 [--figure OUT.svg PEERS.jsonl...]

WORK keeps the blocks and the answers (WORK/blocks.jsonl, one line a run). Runs of different programs, solvers and threads go by turns; the
median is printed. With --figure nothing is run: the traces of all lines of the files are drawn, one panel a problem."""
import argparse, json, os, statistics, subprocess, sys

SIZES = {50: 100_000, 200: 400_000, 500: 1_000_000, 1000: 2_500_000, 2000: 5_000_000}
COLOURS = ["#0b62a4", "#c2410c", "#15803d", "#7e22ce", "#b91c1c", "#525252", "#0e7490", "#a16207"]


def reached(trace, limit, column):
    return next((t[column] for t in trace if t[1] <= limit), None)


def run(command):
    answer = subprocess.run(["timeout", "900"] + command, capture_output=True, text=True)
    lines = answer.stdout.strip().splitlines()
    return json.loads(lines[-1]) if lines else None


def table(a):
    rows = []
    for size in a.sizes:
        path = os.path.join(a.work, f"b{size}.txt")
        if not os.path.exists(path):
            subprocess.run([a.block, str(size), str(SIZES[size]), "1", path], check=True)
        for _ in range(a.reps):
            for threads in (1, 2):
                solvers = ["automatic"] + (["dense"] if size <= 200 else [])
                for solver in solvers:
                    extra = [] if solver == "automatic" else ["--solver", solver]
                    answer = run([a.ba, path, "--threads", str(threads), "--json", "--steps", "60"] + extra)
                    if answer:
                        rows.append(dict(answer, kind="collinear " + solver, size=size, threads=threads))
                if a.ceres:
                    kinds = ["sparse_schur"] + (["dense_schur"] if size <= 200 else [])
                    for solver in kinds:
                        answer = run([a.ceres, path, solver, str(threads), "60", "1e-10", "maxtime=600"])
                        if answer:
                            rows.append(dict(answer, kind="Ceres " + solver, size=size, threads=threads))
            with open(os.path.join(a.work, "blocks.jsonl"), "w") as out:
                out.writelines(json.dumps(r) + "\n" for r in rows)
    print("| photographs | image points | solver | threads | CPU s to 1.001× | wall s to 1.001× | wall s, all | steps | peak MB |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for size in a.sizes:
        best = min(r["final"] for r in rows if r["size"] == size)
        for key in sorted({(r["kind"], r["threads"]) for r in rows if r["size"] == size}):
            own = [r for r in rows if r["size"] == size and (r["kind"], r["threads"]) == key]

            def median(values):
                values = [v for v in values if v is not None]
                return f"{statistics.median(values):.2f}" if values else "never"

            cpu, wall = ([reached(r["trace"], 1.001 * best, c) for r in own] for c in (3, 2))
            print(f"| {size} | {own[0]['obs']} | {key[0]} | {key[1]} | {median(cpu)} | {median(wall)} | {median([r['total_s'] for r in own])} "
                  f"| {own[0]['trace'][-1][0]} | {max(r['rss_mb'] for r in own):.0f} |")


def figure(out, files):
    import math
    rows = [json.loads(line) for f in files for line in open(f)]
    rows = [r for r in rows if r.get("trace") and r.get("threads", 1) == 1]
    problems = list(dict.fromkeys(os.path.basename(r["file"]) for r in rows))
    wide, high = 420, 260
    text = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}" height="{high * len(problems)}" font-family="sans-serif" font-size="11">',
            '<rect width="100%" height="100%" fill="white"/>']
    for k, problem in enumerate(problems):
        own = {}
        for r in rows:
            if os.path.basename(r["file"]) == problem:
                own.setdefault(r.get("kind", r["solver"]), []).append(r)
        # The run of median length.
        own = {name: sorted(runs, key=lambda r: r["total_s"])[len(runs) // 2] for name, runs in own.items()}
        best = min(t[1] for r in own.values() for t in r["trace"])
        lines = {name: [(max(t[3], 1e-3), max(t[1] / best - 1, 1e-6)) for t in r["trace"] if len(t) > 3] for name, r in own.items()}
        times = [t for line in lines.values() for t, _ in line[1:]] or [1.0]
        t0, t1 = math.floor(math.log10(min(times))), math.ceil(math.log10(max(times)))
        c1 = math.ceil(math.log10(max(c for line in lines.values() for _, c in line)))
        x = lambda t: 50 + (wide - 190) * (math.log10(t) - t0) / max(t1 - t0, 1)
        y = lambda c: high * k + 30 + (high - 70) * (c1 - math.log10(c)) / (c1 + 6)
        text.append(f'<text x="50" y="{high * k + 18}" font-weight="bold">{problem.removesuffix(".txt").removesuffix("-pre")}</text>')
        for d in range(t0, t1 + 1):
            text.append(f'<path d="M{x(10**d):.1f} {y(10**c1):.1f}V{y(1e-6):.1f}" stroke="#ddd"/>'
                        f'<text x="{x(10**d):.1f}" y="{y(1e-6) + 14:.1f}" text-anchor="middle">{10.0**d:g} s</text>')
        for d in range(-6, c1 + 1, 2):
            text.append(f'<path d="M50 {y(10.0**d):.1f}H{x(10**t1):.1f}" stroke="#ddd"/>'
                        f'<text x="46" y="{y(10.0**d) + 4:.1f}" text-anchor="end">1e{d}</text>')
        text.append(f'<text x="50" y="{high * (k + 1) - 8}">cost/least cost − 1 against CPU time, one thread</text>')
        for n, (name, line) in enumerate(lines.items()):
            points = " ".join(f"{x(t):.1f},{y(c):.1f}" for t, c in line[1:])
            colour = COLOURS[n % len(COLOURS)]
            mark = (f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.6"/>' if len(line) > 2 else
                    f'<circle cx="{points.split(",")[0]}" cy="{points.split(",")[1]}" r="3.5" fill="{colour}"/>')
            text.append(f'{mark}'
                        f'<text x="{wide - 132}" y="{high * k + 42 + 15 * n}" fill="{colour}">{name}</text>')
    text.append("</svg>")
    with open(out, "w") as f:
        f.write("\n".join(text) + "\n")


p = argparse.ArgumentParser()
p.add_argument("work", nargs="?")
p.add_argument("--sizes", type=lambda s: [int(v) for v in s.split(",")], default=list(SIZES))
p.add_argument("--reps", type=int, default=3)
p.add_argument("--ceres")
p.add_argument("--ba", default="target/release/ba")
p.add_argument("--block", default="target/release/block")
p.add_argument("--figure", nargs="+")
a = p.parse_args()
if a.figure:
    figure(a.figure[0], a.figure[1:])
elif a.work:
    table(a)
else:
    sys.exit(p.format_usage())
