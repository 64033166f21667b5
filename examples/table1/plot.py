#!/usr/bin/env python3
"""Draws the curves of the report's figures 11 to 13 from what examples/table1/run has written.

usage: examples/table1/plot.py [BUILD/table1] [OUTPUT.png]
Needs the Debian package python3-matplotlib; nothing else here does.
"""
import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROBLEMS = ["fixed", "random_narrow", "random_wide", "random_obstacles"]
COLOURS = {"report": "tab:blue", "best": "tab:red"}


def column(file, name):
    with open(file, newline="") as rows:
        return [float(row[name]) for row in csv.DictReader(rows)]


def smoothed(values, n=10):
    """Mean of the last n values, fewer at the beginning."""
    return [sum(values[max(0, i + 1 - n):i + 1]) / min(i + 1, n) for i in range(len(values))]


def draw(axes, folder, problem):
    for preset, colour in COLOURS.items():
        log = folder / f"{problem}.{preset}.log"
        if not log.exists():
            continue
        episodes = column(log, "episode")
        axes.plot(episodes, smoothed(column(log, "training_return")), color=colour, alpha=0.35, lw=1.0,
                  label=f"training, {preset}")
        axes.plot(episodes, smoothed(column(log, "evaluation_return")), color=colour, lw=1.5,
                  label=f"evaluation, {preset}")
        if preset == "report":
            lines = folder / f"{problem}.{preset}.lines"
            at = column(lines, "episode")
            axes.plot(at, smoothed(column(lines, "best_return")), color="black", lw=1.0, ls="--", label="best possible")
            axes.plot(at, smoothed(column(lines, "random_return")), color="tab:gray", lw=1.0, label="random actions")
    axes.set_title(f"seed/{problem}", fontsize=10)
    axes.set_xscale("symlog", linthresh=100)
    axes.set_xlim(left=0)
    axes.grid(alpha=0.3)


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build" / "table1"
    output = sys.argv[2] if len(sys.argv) > 2 else str(ROOT / "docs" / "table1_curves.png")
    figure, panels = plt.subplots(2, 2, figsize=(10, 7), sharey=True)
    for axes, problem in zip(panels.flat, PROBLEMS):
        draw(axes, folder / "curves", problem)
    for axes in panels[1]:
        axes.set_xlabel("training episodes (logarithmic)")
    for axes in panels[:, 0]:
        axes.set_ylabel("return, mean of ten evaluations")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=6, fontsize=9, frameon=False)
    figure.suptitle("MP-DQN, seed 0", fontsize=11)
    figure.tight_layout(rect=(0, 0.04, 1, 1))
    figure.savefig(output, dpi=100)


if __name__ == "__main__":
    main()
