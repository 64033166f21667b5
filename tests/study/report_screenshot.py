"""Looks at the report of a made-up study in headless Chromium: is every solver drawn, in both themes and two widths, does
nothing stick out, and do the controls and the readout work?

usage: report_screenshot.py report WRITER FOLDER   WRITER FILE writes the report
"""

import pathlib
import re
import subprocess
import sys

from screenshot import Checks, chromium, read_png

# The colours of the three solvers: the palette's first three, the blue lighter on dark ground.
SOLVERS = {"light": {"steady": "0072b2", "slow": "d55e00", "agent": "009e73"},
           "dark": {"steady": "6d84ff", "slow": "d55e00", "agent": "009e73"}}

# Run in the page: does what a reader would do and writes down what came of it.
PROBE = """<script>
(function () {
  const log = [], note = (what, holds) => log.push(what + (holds ? ": yes" : ": no"));
  const $ = (id) => document.getElementById(id);
  const choose = (id, value) => { $(id).value = value; $(id).dispatchEvent(new Event("change")); };
  note("ready", window.reportReady === true);
  note("nothing sticks out", document.documentElement.scrollWidth <= innerWidth);
  note("six figures", document.querySelectorAll("figure").length === 6);
  note("the finding names the best", $("finding").textContent.startsWith("steady has the least regret"));
  note("the finding names the break-even point", /agent .met in \\d+ % of its runs. pays from \\d+ tasks? on/.test($("finding").textContent));
  note("a row per solver", $("summary").tBodies[0].rows.length === 3);
  note("a row per instance", $("instances").tBodies[0].rows.length === 30);
  choose("group", "1");
  note("a problem is chosen", $("instances").tBodies[0].rows.length === 15);

  const plot = document.querySelector(".plot"), box = plot.getBoundingClientRect();
  const hover = () => plot.dispatchEvent(new PointerEvent("pointermove", {clientX: box.right - 8, clientY: box.top + 50}));
  const values = document.querySelector("details table"), readout = document.querySelector(".readout");
  note("values as a table", values.tBodies[0].rows.length === 3);
  hover();
  note("the readout lists the solvers", !readout.hidden && readout.querySelectorAll(".row").length === 3);
  note("steady met nearly everything by the end", /steady(9\\d|100) %/.test(readout.textContent));
  plot.dispatchEvent(new PointerEvent("pointerleave"));
  note("the readout goes away", readout.hidden);
  document.querySelectorAll("#legend button")[1].click();
  hover();
  note("the legend hides a solver", !readout.textContent.includes("slow") && readout.querySelectorAll(".row").length === 2);
  choose("charging", "perInstance");
  hover();
  note("charged per instance, the axis holds the training", Math.max(...[...document.querySelectorAll("details th")]
      .map((head) => Number(head.textContent.replace(/\\D/g, "")))) >= 10000);
  choose("measure", "seconds");
  note("costs are in seconds", $("costs-note").textContent.includes("seconds") && / m?s/.test($("costs").textContent));
  $("theme").click();
  note("the theme changes", document.documentElement.dataset.theme === "dark" && $("theme").textContent === "Light");
  document.documentElement.setAttribute("data-probe", log.join("; "));
})();
</script>"""


def nearly(pixel, hexadecimal):
    return all(abs(have - int(hexadecimal[i:i + 2], 16)) <= 3 for have, i in zip(pixel, (0, 2, 4)))


def look(check, page, folder, theme, size):
    name = f"{theme}_{size[0]}"
    path = folder / f"{name}.png"
    path.unlink(missing_ok=True)
    said = chromium(f"--window-size={size[0]},{size[1]}", f"--screenshot={path}", f"{page.as_uri()}#theme={theme}")
    if not path.exists():
        sys.exit(f"chromium took no picture for {name}:\n{said.stderr}")
    _, _, rows = read_png(path)
    counts = {}
    for row in rows:
        for pixel in row:
            counts[pixel] = counts.get(pixel, 0) + 1
    for solver, colour in SOLVERS[theme].items():
        drawn = sum(n for pixel, n in counts.items() if nearly(pixel, colour))
        # A line two pixels thick across a figure 200 wide, in each of two figures.
        check(drawn > 800, f"{name}: {drawn} pixels of {solver}, more than 800")
    red, green, blue = max(counts, key=counts.get)
    check((red + green + blue > 600) == (theme == "light"), f"{name}: the ground is {theme}")


def main():
    _, writer, folder = sys.argv[1:]
    folder = pathlib.Path(folder).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    page = folder / "report.html"
    subprocess.run([writer, str(page)], check=True)
    check = Checks()
    for theme in ("light", "dark"):
        for size in ((1280, 1800), (480, 2200)):
            look(check, page, folder, theme, size)
    probed = folder / "probed.html"
    probed.write_text(page.read_text(encoding="utf-8").replace("</body>", PROBE + "</body>"), encoding="utf-8")
    for width in (1280, 480):
        said = chromium(f"--window-size={width},1000", "--dump-dom", f"{probed.as_uri()}#theme=light").stdout
        answers = re.search(r'data-probe="([^"]*)"', said)
        check(answers is not None, f"{width}: the page answers the probe")
        for answer in answers.group(1).split("; ") if answers else []:
            check(answer.endswith(": yes"), f"{width}: {answer}")
    return 1 if check.faults else 0


if __name__ == "__main__":
    sys.exit(main())
