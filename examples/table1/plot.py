#!/usr/bin/env python3
"""Draws what examples/table1/run has written: the curves of the report's figures 11 to 13, and what the tolerance does.

usage: examples/table1/plot.py [BUILD/table1 [FOLDER]]   writes FOLDER/table1_curves.png and FOLDER/table1_tolerance.png
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
SEEDS = range(3)


def column(file, name):
    with open(file, newline="") as rows:
        return [float(row[name]) for row in csv.DictReader(rows)]


def smoothed(values, n=10):
    """Mean of the last n values, fewer at the beginning."""
    return [sum(values[max(0, i + 1 - n):i + 1]) / min(i + 1, n) for i in range(len(values))]


def draw_curves(axes, folder, problem):
    lines = folder / f"{problem}.report.lines"
    at = column(lines, "episode")
    axes.plot(at, smoothed(column(lines, "best_return")), color="black", lw=1.0, ls="--", label="best possible")
    for preset, colour in COLOURS.items():
        log = folder / f"{problem}.{preset}.log"
        episodes = column(log, "episode")
        axes.plot(episodes, column(log, "evaluation_return"), color=colour, lw=1.5, label=f"evaluation, {preset}")
        axes.plot(episodes, smoothed(column(log, "training_return")), color=colour, alpha=0.35, lw=1.0,
                  label=f"training, {preset}")
    axes.plot(at, smoothed(column(lines, "random_return")), color="tab:gray", lw=1.0, label="random actions")
    axes.set_title(f"seed/{problem}", fontsize=10)


def draw_tolerances(axes, cells, rows):
    for (row, label), colour in zip(rows, ["tab:blue", "tab:orange", "tab:green"]):
        for seed in SEEDS:
            log = cells / f"{row}.{seed}.log"
            if log.exists():
                axes.plot(column(log, "episode"), column(log, "evaluation_return"), ".", ms=2, color=colour,
                          label=label if seed == 0 else None)
    axes.set_ylim(150, 350)
    axes.legend(fontsize=9, loc="center left", markerscale=5)


def finish(axes):
    axes.set_xscale("log")
    axes.grid(alpha=0.3)
    axes.set_xlabel("training episodes")


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build" / "table1"
    output = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else ROOT / "docs"

    figure, panels = plt.subplots(2, 2, figsize=(10, 7), sharey=True)
    for axes, problem in zip(panels.flat, PROBLEMS):
        draw_curves(axes, folder / "curves", problem)
        finish(axes)
    for axes in panels[:, 0]:
        axes.set_ylabel("return of an episode")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=6, fontsize=9, frameon=False)
    figure.suptitle("MP-DQN, seed 0 (training and random actions: means of ten points)", fontsize=11)
    figure.tight_layout(rect=(0, 0.04, 1, 1))
    figure.savefig(output / "table1_curves.png", dpi=90)

    figure, panels = plt.subplots(1, 2, figsize=(10, 3.8), sharey=True)
    draw_tolerances(panels[0], folder / "cells", [("agents.mpdqn", "reached within 1 mm"),
                                                  ("tolerance.mpdqn-1cm", "within 1 cm"),
                                                  ("tolerance.mpdqn-3cm", "within 3 cm")])
    panels[0].set_title("MP-DQN, three seeds each", fontsize=10)
    draw_tolerances(panels[1], folder / "cells", [("tolerance.paddpg-as-published-3cm", "within 3 cm, as published"),
                                                  ("tolerance.paddpg-3cm", "within 3 cm, ends of episodes stored")])
    panels[1].set_title("PA-DDPG, three seeds each", fontsize=10)
    for axes in panels:
        finish(axes)
    panels[0].set_ylabel("return of a greedy episode")
    figure.suptitle("seed/fixed, preset report", fontsize=11)
    figure.tight_layout()
    figure.savefig(output / "table1_tolerance.png", dpi=90)


if __name__ == "__main__":
    main()
