"""Looks at pages in headless Chromium: is everything drawn, and does the animation move?

usage: screenshot.py demo WRITER FOLDER        the demo page, which WRITER FILE writes
       screenshot.py solved MODSEARCH FOLDER   the page of a problem that the command line solves
The pictures stay in FOLDER. Needs nothing but Python's standard library, hence the PNG reader.
"""

import colorsys
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import zlib

FLAGS = """--headless --no-sandbox --disable-quic --no-first-run --disable-background-networking
    --disable-component-update --disable-sync --use-gl=angle --use-angle=swiftshader
    --enable-unsafe-swiftshader""".split()

# Hues in degrees with the least saturation that counts. Light and shade move brightness, hardly the hue.
KINDS = {"robot": (205, 275, 0.35), "obstacle": (4, 24, 0.25), "target": (138, 160, 0.5), "path": (34, 48, 0.3)}

# Run in the page: presses what a visitor would press and writes down what came of it.
PROBE = """<script>
(function () {
  // Chromium writes the document down as soon as it has loaded. A frame whose document is still open keeps it loading.
  const hold = document.body.appendChild(document.createElement("iframe"));
  hold.contentDocument.open();
  const log = [], note = (what, holds) => log.push(what + (holds ? ": yes" : ": no"));
  const $ = (id) => document.getElementById(id);
  const key = { key: " ", bubbles: true, cancelable: true };
  const space = () => document.body.dispatchEvent(new KeyboardEvent("keydown", key));
  note("ready", window.modsearchReady === true);
  space();
  note("space starts", $("play").getAttribute("aria-label") === "Pause");
  // After so many frames, not after so much time: a busy machine draws few. A frame moves it by 0.1 s at most.
  let frames = 0;
  requestAnimationFrame(function count() {
    if (++frames < 6) return requestAnimationFrame(count);
    const moved = Number($("scrub").value);
    note("it plays", moved > 0 && moved < 1000);
    space();
    note("space stops", $("play").getAttribute("aria-label") === "Play");
    $("scrub").value = 250;
    $("scrub").dispatchEvent(new Event("input"));
    note("scrubbing sets the clock", $("clock").textContent === "0.80 / 3.20 s");
    document.querySelector("[data-view=top]").click();
    note("a view is chosen", document.querySelector("[data-view=top]").getAttribute("aria-pressed") === "true");
    document.documentElement.setAttribute("data-probe", log.join("; "));
    hold.contentDocument.close();
  });
})();
</script>"""


def chromium(*arguments):
    with tempfile.TemporaryDirectory(prefix="page-") as profile:
        return subprocess.run(["chromium", *FLAGS, f"--user-data-dir={profile}", *arguments],
                              capture_output=True, text=True, timeout=120)


def read_png(path):
    """Width, height and rows of (r, g, b) of an 8-bit RGB or RGBA picture without interlacing."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", f"{path} is no PNG"
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, colour, _, _, interlaced = struct.unpack(">IIBBBBB", body)
            assert depth == 8 and colour in (2, 6) and not interlaced, f"{path}: unexpected kind of PNG"
        elif kind == b"IDAT":
            packed += body
        at += 12 + size
    step = 3 if colour == 2 else 4
    raw, stride, rows = zlib.decompress(packed), width * step, []
    above = bytearray(stride)
    for y in range(height):
        start = y * (stride + 1)
        row = unfilter(raw[start], bytearray(raw[start + 1:start + 1 + stride]), above, step)
        rows.append([tuple(row[i:i + 3]) for i in range(0, stride, step)])
        above = row
    return width, height, rows


def unfilter(method, row, above, step):
    """Undoes one of the five line filters of the PNG specification (section 9)."""
    for i in range(len(row) if method else 0):
        a, b, c = (row[i - step], above[i], above[i - step]) if i >= step else (0, above[i], 0)
        if method == 1:
            guess = a
        elif method == 2:
            guess = b
        elif method == 3:
            guess = (a + b) // 2
        else:
            p = a + b - c
            guess = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
        row[i] = (row[i] + guess) & 255
    return row


def kind_of(pixel):
    hue, _, value = colorsys.rgb_to_hsv(*(channel / 255 for channel in pixel))
    saturation = (max(pixel) - min(pixel)) / max(max(pixel), 1)
    for kind, (low, high, least) in KINDS.items():
        if low <= 360 * hue <= high and saturation >= least and value > 0.2:
            return kind
    return None


def view_of(picture):
    """The pixels of the 3-D view alone: without the panel, the buttons above and the player below."""
    width, height, rows = picture
    right, bottom = (width - 410, height) if width > 960 else (width - 20, int(0.62 * height))
    return [row[:right] for row in rows[105:bottom - 80]]


def take(page, folder, name, size, state):
    path = folder / f"{name}.png"
    path.unlink(missing_ok=True)
    said = chromium(f"--window-size={size[0]},{size[1]}", f"--screenshot={path}", f"{page.as_uri()}#{state}")
    if not path.exists():
        sys.exit(f"chromium took no picture for {name}:\n{said.stderr}")
    picture = read_png(path)
    if picture[:2] != size:
        sys.exit(f"{name}: the picture is {picture[0]} x {picture[1]}, not {size[0]} x {size[1]}")
    return view_of(picture)


class Checks:
    def __init__(self):
        self.faults = 0

    def __call__(self, holds, what):
        print(("ok    " if holds else "FAULT ") + what)
        self.faults += not holds


def check_drawn(check, page, folder, shots, least_pixels):
    """Takes the pictures `shots`, (name, size, state), and looks for the kinds: pixels per million of the picture."""
    views = {}
    for name, size, state in shots:
        views[name] = view = take(page, folder, name, size, state)
        colours = {pixel for row in view for pixel in row}
        check(len(colours) > 1000, f"{name}: {len(colours)} distinct colours, more than 1000")
        counts = dict.fromkeys(KINDS, 0)
        # The kind is worked out once per colour: a picture has far fewer colours than pixels.
        kinds = {pixel: kind_of(pixel) for pixel in colours}
        for row in view:
            for pixel in row:
                if kinds[pixel]:
                    counts[kinds[pixel]] += 1
        area = size[0] * size[1] / 1e6
        for kind, least in least_pixels.items():
            check(counts[kind] > least * area,
                  f"{name}: {counts[kind]} pixels of the {kind}, more than {least * area:.0f}")

    moved = sum(max(abs(p - q) for p, q in zip(a, b)) > 40
                for row_a, row_b in zip(views["wide_start"], views["wide_end"]) for a, b in zip(row_a, row_b))
    check(moved > 10000, f"from start to end of the path {moved} pixels change, more than 10000")


def look_at_demo(check, writer, folder):
    page = folder / "demo.html"
    subprocess.run([writer, str(page)], check=True)
    shots = [("wide_start", (1400, 900), "t=0&theme=light"), ("wide_end", (1400, 900), "t=1&theme=light"),
             ("narrow_dark", (700, 1000), "t=1&theme=dark")]
    check_drawn(check, page, folder, shots, {"robot": 6000, "obstacle": 15000, "target": 800, "path": 400})
    probed = folder / "probed.html"
    probed.write_text(page.read_text(encoding="utf-8").replace("</body>", PROBE + "</body>"), encoding="utf-8")
    said = chromium("--dump-dom", f"{probed.as_uri()}#t=0").stdout
    answers = re.search(r'data-probe="([^"]*)"', said)
    check(answers is not None, "the page answers the probe")
    for answer in answers.group(1).split("; ") if answers else []:
        check(answer.endswith(": yes"), answer)


def look_at_solved(check, modsearch, folder):
    out = folder / "out"
    subprocess.run([modsearch, "solve", "seed/random_obstacles", "--instance", "0:3", "--out", str(out), "--quiet"],
                   check=True)
    # 500 pixels are too narrow for the legend, and it is left out.
    shots = [("wide_start", (1400, 900), "t=0&theme=light"), ("wide_end", (1400, 900), "t=1&theme=light"),
             ("phone_dark", (500, 900), "t=1&theme=dark")]
    # An arm 11 cm thick and 2 m long, two spheres and a box. The target stands so high that the view, which leaves out
    # what is behind the buttons, shows little of its ring and of the path that leads to it.
    check_drawn(check, out / "view.html", folder, shots, {"robot": 6000, "obstacle": 15000, "target": 400, "path": 30})


def main():
    what, program, folder = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    check = Checks()
    {"demo": look_at_demo, "solved": look_at_solved}[what](check, program, folder)
    return 1 if check.faults else 0


if __name__ == "__main__":
    sys.exit(main())
