// Puts the page together and keeps it drawn.

const data = JSON.parse($("data").textContent);

function make_renderer(canvas) {
  try {
    const renderer = new THREE.WebGLRenderer({canvas, antialias: true, alpha: true});
    renderer.gammaOutput = true;
    renderer.gammaFactor = 2.2;
    renderer.shadowMap.enabled = true;
    renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    return renderer;
  } catch (error) { return null; }
}

function fill_legend(scene) {
  const entry = (kind, hex, text) => {
    const swatch = element("span", {class: `swatch ${kind}`, "aria-hidden": "true"});
    swatch.style.background = swatch.style.color = hex;
    $("legend").append(element("li", {}, swatch, text));
  };
  if (scene.targets.length) entry("", kColours.target, scene.targets.length > 1 ? "targets" : "target");
  if (scene.region) entry("frame", kColours.target, "where targets are sampled");
  if (scene.obstacles.length) entry("", kColours.obstacle, scene.obstacles.length > 1 ? "obstacles" : "obstacle");
  if (scene.touches.length) entry("", kColours.touch, "what touches");
  if (scene.tip.length > 1) entry("line", kColours.path, "path of the tool centre point");
}

// What the address asks for: t, play, view.
function follow_address(player, view) {
  const asked = new URLSearchParams(location.hash.slice(1));
  if (view && Object.keys(kViews).includes(asked.get("view"))) view.look(asked.get("view"));
  const t = parseFloat(asked.get("t"));
  if (Number.isFinite(t)) player.show(t);
  if (asked.has("play")) player.play();
}

function show_hover(world, view) {
  const canvas = view.canvas, caster = new THREE.Raycaster(), tip = $("hover");
  canvas.addEventListener("pointerleave", () => (tip.hidden = true));
  canvas.addEventListener("pointermove", (event) => {
    const box = canvas.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
    caster.setFromCamera(new THREE.Vector2((2 * x) / box.width - 1, 1 - (2 * y) / box.height), view.camera);
    const hit =
        event.buttons ? null : caster.intersectObjects(world.pickable).find((seen) => seen.object.userData.name);
    tip.hidden = !hit;
    if (!hit) return;
    tip.textContent = hit.object.userData.name;
    tip.style.left = `${Math.min(x + 14, box.width - tip.offsetWidth - 8)}px`;
    tip.style.top = `${Math.max(8, y - 34)}px`;
  });
}

function start_view(world, renderer) {
  const canvas = $("canvas"), view = new View(canvas, world), labels = new Labels($("labels"), world.labels),
        gizmo = new Gizmo($("gizmo"));
  let stale = true;
  const touch = () => (stale = true);
  const theme = () => {
    world.set_theme(document.documentElement.dataset.theme === "dark");
    touch();
  };
  const resize = () => {
    renderer.setPixelRatio(Math.min(2, devicePixelRatio || 1));
    renderer.setSize(canvas.clientWidth, canvas.clientHeight, false);
    view.resize();
    // At once: a new size empties the canvas, and it would be shown empty until the next frame.
    draw();
  };
  const draw = () => {
    for (const object of world.facing) object.quaternion.copy(view.camera.quaternion);
    renderer.render(world.scene, view.camera);
    gizmo.turn(view.camera);
    labels.place(view.camera, canvas.clientWidth, canvas.clientHeight);
    stale = false;
  };
  view.controls.addEventListener("change", touch);
  for (const button of document.querySelectorAll("[data-view]"))
    button.addEventListener("click", () => view.look(button.dataset.view));
  addEventListener("themechange", theme);
  new ResizeObserver(resize).observe(canvas);
  show_hover(world, view);
  theme();
  resize();
  return {view, touch, draw_if_stale: () => stale && draw()};
}

(function main() {
  fill_legend(data.scene);
  const renderer = make_renderer($("canvas"));
  let world = null, shown = null;
  if (renderer) {
    world = new World(data.scene);
    shown = start_view(world, renderer);
  } else {
    $("no-webgl").hidden = false;
    for (const node of [$("canvas"), $("legend"), $("gizmo"), ...document.querySelectorAll(".toolbar")])
      node.hidden = true;
  }
  const first = world ? world.first_module : 1;
  const coloured = new Set(data.scene.bodies.map((body) => body.module));
  fill_panel(data.facts, (index) => (coloured.has(index) ? module_colour(index, first) : kColours.base), (index) => {
    if (!world) return;
    world.light_up(index);
    shown.touch();
  });
  // Drawing changes the height of the panel; only another width is a reason to draw again.
  let drawn_width = 0;
  const draw = () => {
    if ($("trace").clientWidth === drawn_width) return;
    drawn_width = $("trace").clientWidth;
    draw_trace($("trace"), data.facts);
  };
  new ResizeObserver(draw).observe($("trace"));
  draw();

  const player = new Player(data.scene, (t) => {
    if (!world) return;
    world.pose(t);
    shown.touch();
  });
  const follow = () => follow_address(player, shown && shown.view);
  addEventListener("hashchange", follow);
  follow();

  const frame = (now) => {
    player.tick(now);
    if (shown) shown.draw_if_stale();
    requestAnimationFrame(frame);
  };
  if (shown) shown.draw_if_stale();
  window.modsearchReady = true;
  requestAnimationFrame(frame);
})();
