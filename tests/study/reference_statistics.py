"""Writes reference_statistics.json: what SciPy, statsmodels and rliable say of the samples below.

usage: pip install scipy statsmodels rliable && python3 reference_statistics.py > reference_statistics.json
The file in this folder was made with SciPy 1.17.1, statsmodels 0.15.0 and rliable 1.2.0.
"""

import itertools
import json

import numpy as np
from rliable import metrics
from scipy import stats
from statsmodels.stats.multitest import multipletests

# Two solvers on three tasks with five runs each, some of them equal.
FIRST = [[3.1, 2.7, 4.4, 3.9, 3.1], [10.2, 9.6, 11.5, 10.2, 8.7], [0.4, 0.9, 0.1, 0.6, 0.35]]
SECOND = [[3.1, 2.5, 4.1, 3.0, 2.2], [10.4, 9.9, 12.5, 9.1, 8.7], [0.2, 0.3, 0.15, 0.5, 0.05]]

# Darwin's pairs of cross- and self-fertilised maize, in eighths of an inch (R. A. Fisher 1935, The design of
# experiments, table 3): 15 differences with ties.
MAIZE = [49, -67, 8, 16, 6, 23, 28, 41, 14, 29, 56, 24, 75, 60, -48]
DIFFERENCES = {
    "maize": MAIZE,
    "without ties": [1.5, -0.3, 2.25, 0.75, -1.0, 3.5, 0.1, 4.0],
    "with a zero": [1.5, 0.0, -0.3, 2.25, 0.75, -1.0, 3.5, 0.1],
    "ties": [1, -1, 2, 2, -3, 4, 4, 4, 5, 0, 0, 6],
    "even": [1, -1, 2, -2],
    "fifty": [0.37 * ((i * 29) % 101) - 13 + 0.001 * i for i in range(50)],
    "sixty": [0.37 * ((i * 29) % 101) - 13 + 0.001 * i for i in range(60)],
}
P_VALUES = [[0.01, 0.04, 0.03, 0.005], [0.2, 0.5, 0.9], [0.011, 0.02, 0.02, 0.2], [0.3]]


def signed_rank(differences):
    kept = [d for d in differences if d != 0]
    tied = len({abs(d) for d in kept}) < len(kept)
    exact = not tied and len(kept) <= 50
    p = stats.wilcoxon(kept, zero_method="wilcox", correction=not exact, method="exact" if exact else "approx").pvalue
    ranks = stats.rankdata(np.abs(kept))
    return {"differences": differences, "pairs": len(kept), "exact": exact, "p": float(p),
            "plus": float(ranks[np.array(kept) > 0].sum()), "minus": float(ranks[np.array(kept) < 0].sum())}


def exact_bootstrap(strata, statistic):
    """The whole distribution of the stratified bootstrap: every way to draw, each as likely as the others."""
    draws = [list(itertools.product(runs, repeat=len(runs))) for runs in strata]
    values = [statistic([value for runs in drawn for value in runs]) for drawn in itertools.product(*draws)]
    return [float(np.percentile(values, q)) for q in (2.5, 97.5)]


def iqm(values):
    return float(stats.trim_mean(values, 0.25))


small = [[1.0, 2.0, 5.0], [3.0, 7.0, 9.5]]
runs_by_tasks = np.array(FIRST).T, np.array(SECOND).T
references = {
    "first": FIRST,
    "second": SECOND,
    "interquartile_mean": float(metrics.aggregate_iqm(runs_by_tasks[0])),
    "probability_of_improvement": float(metrics.probability_of_improvement(*runs_by_tasks)),
    "trimmed": [{"values": FIRST[0][:n] + FIRST[1][:n], "mean": iqm(FIRST[0][:n] + FIRST[1][:n])} for n in (1, 2, 3, 5)],
    "bootstrap": {"strata": small, "interval": exact_bootstrap(small, iqm)},
    "signed_rank": {name: signed_rank(differences) for name, differences in DIFFERENCES.items()},
    "holm": [{"p": p, "adjusted": [float(a) for a in multipletests(p, method="holm")[1]]} for p in P_VALUES],
    "wilson": [{"successes": k, "trials": n, "interval": [float(e) for e in stats.binomtest(k, n).proportion_ci(
        0.95, method="wilson")]} for k, n in ((0, 10), (3, 10), (10, 10), (15, 16), (29, 30), (1, 1), (500, 1000))],
    "quantiles": [{"p": p, "value": float(np.quantile(FIRST[0], p))} for p in (0.0, 0.025, 0.3, 0.5, 0.975, 1.0)],
}
print("{" + ",\n".join(f"{json.dumps(name)}: {json.dumps(value)}" for name, value in references.items()) + "}")
