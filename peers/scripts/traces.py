"""Runs every bundle-adjustment peer of ../shared/peers/adjust on the two BAL problems, one thread, and writes one JSON line a run with its trace, for
the figure of blocks.py.

usage: traces.py DIR OUT.jsonl [--reps 3] [--ba BA] ; DIR was built by setup.sh there, and peers missing in it are left out."""
import argparse, json, os, statistics, subprocess

p = argparse.ArgumentParser()
p.add_argument("dir")
p.add_argument("out")
p.add_argument("--reps", type=int, default=3)
p.add_argument("--ba", default="target/release/ba")
p.add_argument("--scripts", default="../shared/peers/adjust")
a = p.parse_args()
# The least cost known; a run may stop a little above.
BEST = {"trafalgar-21-11315-pre.txt": 30378.635796, "ladybug-49-7776-pre.txt": 13344.240300}


def commands(path, target):
    ceres, python, rust = (os.path.join(a.dir, f) for f in ("bal_ceres", "venv/bin/python", "balpeers"))
    own = os.path.join(a.scripts, "ba_py.py")
    yield "collinear", [a.ba, path, "--threads", "1", "--json"]
    for solver in ("dense_schur", "sparse_schur", "iter_schur"):
        yield "Ceres " + solver, [ceres, path, solver, "1", "200", "1e-10", "target=" + target, "maxtime=60"]
    yield "GTSAM points first", [python, own, path, "gtsam_schur", "1", "40", target]
    yield "COLMAP", [python, own, path, "colmap", "1", "60", target]
    for name, mode in (("tiny-solver", "tiny"), ("apex-solver", "apex_explicit")):
        yield name, [rust, path, mode, "40"]


rows = []
for rep in range(a.reps):
    for file, best in BEST.items():
        path = os.path.join(a.dir, "data", file)
        for kind, command in commands(path, f"{best * 1.00001:.17g}"):
            if not os.path.exists(command[0]):
                continue
            env = dict(os.environ, GLOG_minloglevel="3", RAYON_NUM_THREADS="1")
            answer = subprocess.run(["timeout", "150"] + command, capture_output=True, text=True, env=env)
            try:
                row = json.loads(answer.stdout.strip().splitlines()[-1])
            except (IndexError, ValueError):
                print(f"{kind}, {file}: {answer.stderr.strip()[-200:]}")
                continue
            # COLMAP tells its end alone.
            end = row.get("final_plain", row["final"])
            row["trace"] = row.get("trace") or [[0, row["initial"], 0.0, 0.0], [row["steps"][0], end, row["total_s"], row["cpu_s"]]]
            if min(t[1] for t in row["trace"]) < 0.9999 * best:
                print(f"{kind}, {file}: not compared, as its cost leaves observations out")
                continue
            rows.append(dict(row, file=file, kind=kind, threads=1))
            with open(a.out, "w") as out:
                out.writelines(json.dumps(r) + "\n" for r in rows)

for file, best in BEST.items():
    for kind in dict.fromkeys(r["kind"] for r in rows):
        own = [r for r in rows if (r["file"], r["kind"]) == (file, kind)]
        hits = [next(((t[0], t[3]) for t in r["trace"] if t[1] <= 1.001 * best), None) for r in own]
        if own and all(hits):
            reached = f"{statistics.median(t for _, t in hits):.3f} s, {hits[0][0]} steps"
        else:
            reached = "never"
        print(f"| {file[:-8]} | {kind} | {reached} | {min(r['trace'][-1][1] for r in own):.6f} | {max(r['rss_mb'] for r in own):.1f} MB |" if own else "")
