// Where the scene is seen from.

const kViews = {
  iso: [0.75, -1, 0.5],
  front: [0, -1, 0.0001],
  side: [1, 0, 0.0001],
  top: [0, -0.0001, 1]
};

// Room that the buttons over the view need, in pixels: the scene is fitted into what is left.
const kMargins = {
  top: 64,
  bottom: 84,
  side: 36
};

class View {
  constructor(canvas, world) {
    this.canvas = canvas;
    this.world = world;
    this.camera = new THREE.PerspectiveCamera(32, 1, 0.01 * world.size, 40 * world.size);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.enableKeys = false;
    this.controls.screenSpacePanning = true;
    this.controls.minDistance = 0.05 * world.size;
    this.controls.maxDistance = 12 * world.size;
    this.controls.addEventListener("start", () => this.name_view(null));
    this.name_view("iso");
  }

  name_view(name) {
    this.view = name;
    for (const button of document.querySelectorAll("[data-view]"))
      button.setAttribute("aria-pressed", String(button.dataset.view === name));
  }

  // Moves the camera along a direction to where every point of the scene just fits.
  look(name) {
    this.name_view(name);
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    const toward = new THREE.Vector3(...kViews[name]).normalize();
    const right = new THREE.Vector3(0, 0, 1).cross(toward).normalize(), up = toward.clone().cross(right);
    const slope_y = Math.tan((this.camera.fov * Math.PI) / 360), slope_x = (slope_y * width) / height;
    const room_x = Math.max(0.4, 1 - (2 * kMargins.side) / width);
    const room_y = Math.max(0.4, 1 - (kMargins.top + kMargins.bottom) / height);
    const centre = this.world.box.getCenter(new THREE.Vector3());
    const points = this.world.points.map((p) => [p.dot(right), p.dot(up), p.dot(toward)]);
    let [x, y, z] = [centre.dot(right), centre.dot(up), centre.dot(toward)];
    let distance = 0;
    for (let round = 0; round < 8; ++round) {
      distance = 0.3 * this.world.size;
      for (const p of points) {
        distance = Math.max(
            distance, p[2] - z + Math.abs(p[0] - x) / (slope_x * room_x),
            p[2] - z + Math.abs(p[1] - y) / (slope_y * room_y));
      }
      const across = points.map((p) => (p[0] - x) / (distance - p[2] + z)),
            upward = points.map((p) => (p[1] - y) / (distance - p[2] + z));
      x += (distance * (Math.max(...across) + Math.min(...across))) / 2;
      y += (distance * (Math.max(...upward) + Math.min(...upward))) / 2;
    }
    // The free room lies a little above the middle of the canvas.
    y -= (distance * slope_y * (kMargins.bottom - kMargins.top)) / height;
    const target = right.multiplyScalar(x).addScaledVector(up, y).addScaledVector(toward, z);
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(toward, distance);
    this.controls.update();
  }

  resize() {
    this.camera.aspect = this.canvas.clientWidth / this.canvas.clientHeight;
    this.camera.updateProjectionMatrix();
    if (this.view) this.look(this.view);
  }
}

// Text that follows points of the scene, above the canvas, so that it is as crisp as the rest of the page.
class Labels {
  constructor(layer, labels) {
    this.items = labels.map((label) => {
      const node = element(
          "span", label.touch ? {class: "touch"} : {}, element("b", {}, label.name),
          label.note ? element("i", {}, ` ${label.note}`) : null, label.miss ? element("em", {}, label.miss) : null);
      layer.append(node);
      return {node, label};
    });
  }
  place(camera, width, height) {
    const scale = height / (2 * Math.tan((camera.fov * Math.PI) / 360));
    const placed = [];  // {left, top, right, bottom} of the labels so far
    for (const {node, label} of this.items) {
      const seen = label.position.clone().project(camera);
      node.hidden = seen.z > 1 || Math.abs(seen.x) > 1.05 || Math.abs(seen.y) > 1.05;
      if (node.hidden) continue;
      const x = ((seen.x + 1) / 2) * width, y = ((1 - seen.y) / 2) * height;
      const away = (label.radius * scale) / camera.position.distanceTo(label.position) + 9;
      const box = [node.offsetWidth, node.offsetHeight];
      // Beside the ring, or above it where the view ends, or below it where the buttons are.
      const beside = x + away + box[0] <= width - 6;
      const left = beside ? x + away : Math.min(x - box[0] / 2, width - box[0] - 6);
      const above = y - away - box[1];
      let top = beside ? y - box[1] / 2 : above < kMargins.top ? y + away : above;
      // Below whatever label is there already; as often as there are labels at most.
      for (let i = 0; i < placed.length; ++i) {
        const hit = placed.find(
            (other) => left < other.right && left + box[0] > other.left && top < other.bottom &&
                top + box[1] > other.top);
        if (!hit) break;
        top = hit.bottom + 4;
      }
      placed.push({left, top, right: left + box[0], bottom: top + box[1]});
      node.style.transform = `translate(${Math.round(left)}px, ${Math.round(top)}px)`;
    }
  }
}

// The directions of the world's axes as the camera sees them.
class Gizmo {
  constructor(host) {
    this.axes = ["x", "y", "z"].map((name, i) => {
      const line = svg("line", {x1: 0, y1: 0, stroke: kAxisColours[i]}), text = svg("text", {}, name);
      host.append(line, text);
      return {line, text, direction: new THREE.Vector3().setComponent(i, 1)};
    });
  }
  turn(camera) {
    const to_camera = camera.quaternion.clone().inverse();
    for (const {line, text, direction} of this.axes) {
      const seen = direction.clone().applyQuaternion(to_camera);
      line.setAttribute("x2", 26 * seen.x);
      line.setAttribute("y2", -26 * seen.y);
      const flat = Math.hypot(seen.x, seen.y), out = 26 + 10 / Math.max(flat, 0.3);
      text.setAttribute("x", out * seen.x);
      text.setAttribute("y", -out * seen.y);
      text.setAttribute("visibility", flat < 0.15 ? "hidden" : "visible");
    }
  }
}
