// The animation of the path: play, pause, scrub, speed, loop.

const kIcons = {
  play: "M4 2.5v11l9.5-5.5z",
  pause: "M3.5 2.5h3.2v11H3.5zM9.3 2.5h3.2v11H9.3z"
};
const kDefaultSeconds = 4;

class Player {
  constructor(data, on_change) {
    const times = data.times;
    const span = times.length ? times[times.length - 1] - times[0] : 0;
    this.seconds = span > 0 ? span : kDefaultSeconds;
    this.timed = span > 0;
    this.moves = data.samples > 1;
    this.on_change = on_change;
    this.t = 1;
    this.playing = false;
    this.looping = false;

    const controls = [$("play"), $("scrub"), $("speed"), $("loop")];
    if (!this.moves) {
      for (const control of controls) control.disabled = true;
      document.querySelector(".player").title = "This solution has no path: the posture at the goal is shown.";
      $("clock").textContent = "no path";
      return;
    }
    $("play").addEventListener("click", () => this.toggle());
    $("scrub").addEventListener("input", () => {
      this.pause();
      this.show($("scrub").value / 1000);
    });
    $("loop").addEventListener("click", () => {
      this.looping = !this.looping;
      $("loop").setAttribute("aria-pressed", String(this.looping));
    });
    addEventListener("keydown", (event) => {
      if (event.key !== " " || event.target.closest("button, select, a, summary")) return;
      event.preventDefault();
      this.toggle();
    });
    for (const milestone of data.milestones) {
      const at = span > 0 ? (times[milestone.sample] - times[0]) / span : milestone.sample / (data.samples - 1);
      const tick = element("span", {title: milestone.name});
      tick.style.left = `${100 * at}%`;
      $("ticks").append(tick);
    }
    this.show(1);
  }

  show(t) {
    this.t = Math.min(1, Math.max(0, t));
    if (this.moves) {
      $("scrub").value = String(Math.round(1000 * this.t));
      const clock = this.timed ? `${(this.t * this.seconds).toFixed(2)} / ${this.seconds.toFixed(2)} s` :
                                 `${Math.round(100 * this.t)} %`;
      $("clock").textContent = clock;
      $("scrub").setAttribute("aria-valuetext", clock);
    }
    this.on_change(this.t);
  }

  toggle() { this.playing ? this.pause() : this.play(); }

  play() {
    if (!this.moves) return;
    if (this.t >= 1) this.show(0);
    this.playing = true;
    this.last = null;
    this.mark();
  }

  pause() {
    this.playing = false;
    this.mark();
  }

  mark() {
    $("play-icon").setAttribute("d", this.playing ? kIcons.pause : kIcons.play);
    $("play").setAttribute("aria-label", this.playing ? "Pause" : "Play");
  }

  // Called at every frame with the browser's clock [ms].
  tick(now) {
    if (!this.playing) return;
    const elapsed = this.last === null ? 0 : Math.min(0.1, (now - this.last) / 1000);
    this.last = now;
    const next = this.t + (elapsed * Number($("speed").value)) / this.seconds;
    if (next < 1) return this.show(next);
    this.show(1);
    if (this.looping)
      this.show(0);
    else
      this.pause();
  }
}
