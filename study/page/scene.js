// The robot and its world as three.js objects, posed at any moment of the path.

// A colour of the screen as the linear one that shading computes with.
const linear = (hex) => new THREE.Color(hex).convertSRGBToLinear();

function solid(hex, options) {
  return new THREE.MeshStandardMaterial(Object.assign({color: linear(hex), roughness: 0.55, metalness: 0.05}, options));
}

// A group whose pose follows keyframes. `at(i, w)` poses it between samples i and i + 1.
class Follower {
  constructor(keyframes) {
    this.group = new THREE.Group();
    this.frames = keyframes.map((X) => {
      const position = new THREE.Vector3(), rotation = new THREE.Quaternion();
      matrix_of(X).decompose(position, rotation, new THREE.Vector3());
      return {position, rotation};
    });
    this.at(0, 0);
  }
  at(i, weight) {
    const from = this.frames[Math.min(i, this.frames.length - 1)],
          to = this.frames[Math.min(i + 1, this.frames.length - 1)];
    this.group.position.lerpVectors(from.position, to.position, weight);
    THREE.Quaternion.slerp(from.rotation, to.rotation, this.group.quaternion, weight);
  }
  // `points` of the group's own frame in the world, at up to `limit` moments.
  sweep(points, limit) {
    const stride = Math.max(1, Math.ceil(this.frames.length / limit));
    const swept = [];
    for (let i = 0; i < this.frames.length; i += stride) {
      const frame = this.frames[Math.min(i, this.frames.length - 1)];
      for (const point of points) swept.push(point.clone().applyQuaternion(frame.rotation).add(frame.position));
    }
    return swept;
  }
}

class World {
  constructor(scene_data) {
    this.data = scene_data;
    this.scene = new THREE.Scene();
    this.followers = [];
    this.pickable = [];
    this.materials = new Map();  // of each module, to light it up
    this.labels = [];            // {name, note, position, radius}: the page draws them above the canvas
    this.facing = [];            // objects that turn to the camera
    this.points = [];            // what the camera has to show

    const first = Math.min(
        ...scene_data.bodies.filter((body) => body.module >= 0 && body.shapes.length).map((body) => body.module));
    this.first_module = Number.isFinite(first) ? first : 0;
    this.thickness = Math.max(...scene_data.bodies.map((body) => thickness_of(body.shapes) || 0), 0);

    for (const body of scene_data.bodies) this.add_robot_body(body);
    for (const body of scene_data.obstacles) this.add_obstacle(body);
    for (const target of scene_data.targets) this.points.push(new THREE.Vector3(...target.position));
    if (scene_data.base) this.points.push(new THREE.Vector3().setFromMatrixPosition(matrix_of(scene_data.base)));
    this.measure();

    for (const body of scene_data.bodies) this.add_joints(body);
    for (const target of scene_data.targets) this.add_target(target);
    for (const touch of scene_data.touches) this.add_touch(touch);
    if (scene_data.region) this.add_region(scene_data.region);
    if (scene_data.base) this.add_base(scene_data.base);
    this.add_tip_path(scene_data.tip);
    this.add_axes();
    this.add_floor();
    this.add_lights();
    this.pose(1);
  }

  measure() {
    if (!this.points.length) this.points.push(new THREE.Vector3(-0.5, -0.5, 0), new THREE.Vector3(0.5, 0.5, 0.5));
    this.box = new THREE.Box3().setFromPoints(this.points);
    this.size = Math.max(this.box.getSize(new THREE.Vector3()).length(), 0.1);
    if (this.thickness === 0) this.thickness = 0.02 * this.size;
  }

  add_shapes(body, follower, material, edges) {
    const added = body.shapes.map((shape) => {
      const geometry = geometry_of(shape), matrix = matrix_of(shape.X);
      const mesh = new THREE.Mesh(geometry, material);
      mesh.applyMatrix(matrix);
      mesh.castShadow = true;
      mesh.userData.name = [body.name, shape.name].filter(Boolean).join(" · ");
      follower.group.add(mesh);
      this.pickable.push(mesh);
      if (edges && shape.kind !== "sphere" && shape.kind !== "capsule") {
        const lines = new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 30), edges);
        lines.applyMatrix(matrix);
        follower.group.add(lines);
      }
      return {geometry, matrix};
    });
    this.points.push(...follower.sweep(corners_of(added), 24));
  }

  follow(body) {
    const follower = new Follower(body.keyframes);
    this.followers.push(follower);
    this.scene.add(follower.group);
    return follower;
  }

  add_robot_body(body) {
    const follower = this.follow(body);
    if (!this.materials.has(body.module)) {
      this.materials.set(body.module, solid(module_colour(body.module, this.first_module), {side: THREE.DoubleSide}));
    }
    this.add_shapes(body, follower, this.materials.get(body.module), null);
    for (const child of follower.group.children) child.userData.module = body.module;
    body.follower = follower;
  }

  add_obstacle(body) {
    const material = solid(kColours.obstacle, {transparent: true, opacity: 0.7, roughness: 0.9});
    const edges = new THREE.LineBasicMaterial({color: linear(kColours.obstacle), transparent: true, opacity: 0.9});
    body.follower = this.follow(body);
    this.add_shapes(body, body.follower, material, edges);
  }

  // A revolute joint is a drum about its axis with lighter caps, a prismatic one a sleeve.
  add_joints(body) {
    const r = this.thickness;
    for (const joint of body.joints) {
      const symbol = new THREE.Group();
      const add = (geometry, hex) => {
        const mesh = new THREE.Mesh(geometry, solid(hex, {roughness: 0.4, metalness: 0.1}));
        mesh.castShadow = true;
        mesh.userData = {name: [joint.name, joint.kind + " joint"].filter(Boolean).join(" · "), module: body.module};
        symbol.add(mesh);
        this.pickable.push(mesh);
      };
      if (joint.kind === "revolute") {
        add(new THREE.CylinderBufferGeometry(1.24 * r, 1.24 * r, 2.3 * r, 40).rotateX(Math.PI / 2), kColours.joint);
        add(new THREE.CylinderBufferGeometry(0.78 * r, 0.78 * r, 2.5 * r, 40).rotateX(Math.PI / 2), "#c3cad3");
      } else if (joint.kind === "prismatic") {
        add(new THREE.BoxBufferGeometry(2.5 * r, 2.5 * r, 1.6 * r), kColours.joint);
      } else {
        add(new THREE.CylinderBufferGeometry(1.1 * r, 1.1 * r, 0.5 * r, 40).rotateX(Math.PI / 2), kColours.joint);
      }
      symbol.applyMatrix(matrix_of(joint.X));
      body.follower.group.add(symbol);
    }
  }

  // A ring that faces the camera finds the eye; the ball inside is the tolerance to scale, or the least that can be
  // seen. Both shimmer through whatever stands before them.
  add_target(target) {
    const centre = new THREE.Vector3(...target.position);
    const least = 0.28 * this.thickness;
    const ring_radius = Math.max(1.75 * this.thickness, 1.3 * target.tolerance);
    const hex = target.miss ? kColours.touch : kColours.target;
    const bright = new THREE.MeshBasicMaterial({color: linear(hex)});
    const through =
        new THREE.MeshBasicMaterial({color: linear(hex), transparent: true, opacity: 0.45, depthTest: false});
    const ring = new THREE.TorusBufferGeometry(ring_radius, 0.16 * this.thickness, 12, 64);
    const ball = new THREE.SphereBufferGeometry(Math.max(target.tolerance, least), 32, 24);
    const soft = new THREE.MeshBasicMaterial({color: linear(hex), transparent: true, opacity: 0.35});
    const faces = new THREE.Group();
    for (const material of [bright, through]) {
      faces.add(
          new THREE.Mesh(ring, material),
          new THREE.Mesh(ball, material === bright && target.tolerance > least ? soft : material));
    }
    faces.position.copy(centre);
    faces.traverse((node) => (node.renderOrder = node.material === through ? 2 : 1));
    this.facing.push(faces);
    this.scene.add(faces);
    const axis_reach = target.frame ? Math.min(0.09 * this.size, 3.2 * this.thickness) : 0;
    if (target.frame) {
      const triad = this.triad(axis_reach, 0.025 * axis_reach);
      triad.applyMatrix(matrix_of(target.frame));
      this.scene.add(triad);
    }
    for (const axis of [new THREE.Vector3(1, 0, 0), new THREE.Vector3(0, 1, 0), new THREE.Vector3(0, 0, 1)])
      for (const side of [-ring_radius, ring_radius]) this.points.push(centre.clone().addScaledVector(axis, side));
    this.labels.push({
      name: target.name || "target",
      note: target.tolerance > 0 ? `± ${length(target.tolerance)}` : "",
      miss: target.miss,
      position: centre,
      radius: ring_radius
    });
  }

  // The two that overlap, and a cross where they are deepest, seen through everything.
  add_touch(touch) {
    const paint = (body, options) => {
      const material = solid(kColours.touch, options);
      body.follower.group.traverse((node) => {
        if (node.isMesh && node.userData.name) node.material = material;
      });
    };
    paint(this.data.bodies[touch.body], {side: THREE.DoubleSide});
    if (touch.obstacle)
      paint(this.data.obstacles[touch.other], {transparent: true, opacity: 0.6, roughness: 0.9});
    else
      paint(this.data.bodies[touch.other], {side: THREE.DoubleSide});
    const reach = 1.6 * this.thickness, mark = new THREE.Group();
    const material = new THREE.MeshBasicMaterial({color: linear("#ffffff"), depthTest: false, transparent: true});
    for (const angle of [Math.PI / 4, -Math.PI / 4]) {
      const bar = new THREE.Mesh(new THREE.BoxBufferGeometry(reach, 0.2 * this.thickness, 0.01 * reach), material);
      bar.rotation.z = angle;
      bar.renderOrder = 3;
      mark.add(bar);
    }
    mark.position.set(...touch.position);
    this.facing.push(mark);
    this.scene.add(mark);
    // Beside its goal the touch is told already; at home there is none.
    if (!this.data.targets.some((target) => target.miss))
      this.labels.push({name: `${length(touch.depth)} deep`, position: mark.position, radius: reach / 2, touch: true});
  }

  add_region(region) {
    const low = new THREE.Vector3(...region.lower), high = new THREE.Vector3(...region.upper);
    const size = high.clone().sub(low), centre = low.clone().add(high).multiplyScalar(0.5);
    const box = new THREE.BoxBufferGeometry(Math.max(size.x, 1e-4), Math.max(size.y, 1e-4), Math.max(size.z, 1e-4));
    const lines = new THREE.LineSegments(new THREE.EdgesGeometry(box), new THREE.LineDashedMaterial({
      color: linear(kColours.target),
      dashSize: 0.02 * this.size,
      gapSize: 0.014 * this.size,
      transparent: true,
      opacity: 0.9
    }));
    lines.computeLineDistances();
    const fill = new THREE.Mesh(
        box,
        new THREE.MeshBasicMaterial(
            {color: linear(kColours.target), transparent: true, opacity: 0.035, depthWrite: false}));
    for (const part of [lines, fill]) {
      part.position.copy(centre);
      this.scene.add(part);
    }
    for (const x of [low.x, high.x])
      for (const y of [low.y, high.y])
        for (const z of [low.z, high.z]) this.points.push(new THREE.Vector3(x, y, z));
  }

  add_base(X) {
    const r = this.thickness;
    const plate = new THREE.Group();
    for (const [radius, height, hex] of [[2.3, 0.3, kColours.base], [1.6, 0.7, kColours.joint]]) {
      const mesh = new THREE.Mesh(
          new THREE.CylinderBufferGeometry(radius * r, radius * r, height * r, 48).rotateX(Math.PI / 2), solid(hex));
      mesh.castShadow = true;
      mesh.userData.name = "base";
      this.pickable.push(mesh);
      plate.add(mesh);
    }
    const X_WB = matrix_of(X);
    for (const x of [-2.3 * r, 2.3 * r])
      for (const y of [-2.3 * r, 2.3 * r]) this.points.push(new THREE.Vector3(x, y, 0).applyMatrix4(X_WB));
    plate.applyMatrix(X_WB);
    this.scene.add(plate);
  }

  add_tip_path(tip) {
    if (tip.length < 2) return;
    const {geometry, counts} = tube_geometry(tip, 0.13 * this.thickness);
    if (!geometry.index.count) return;
    const whole =
        new THREE.MeshBasicMaterial({color: linear(kColours.path), transparent: true, opacity: 0.4, depthWrite: false});
    this.scene.add(new THREE.Mesh(geometry, whole));
    this.travelled = new THREE.Mesh(geometry.clone(), new THREE.MeshBasicMaterial({color: linear(kColours.path)}));
    this.travelled_counts = counts;
    this.scene.add(this.travelled);
    this.points.push(...tip.map((point) => new THREE.Vector3(...point)));
  }

  triad(reach, radius) {
    const group = new THREE.Group();
    // three.js stands arrows along y: turned to x, left, turned to z.
    [[0, 0, -Math.PI / 2], [0, 0, 0], [Math.PI / 2, 0, 0]].forEach(([x, y, z], axis) => {
      const hex = kAxisColours[axis];
      const arrow = new THREE.Group(), material = new THREE.MeshBasicMaterial({color: linear(hex)});
      const shaft = new THREE.Mesh(new THREE.CylinderBufferGeometry(radius, radius, reach, 12), material);
      const head = new THREE.Mesh(new THREE.ConeBufferGeometry(2.6 * radius, 8 * radius, 20), material);
      shaft.position.y = reach / 2;
      head.position.y = reach;
      arrow.add(shaft, head);
      arrow.rotation.set(x, y, z);
      group.add(arrow);
    });
    return group;
  }

  add_axes() {
    const reach = Math.max(0.14 * this.size, 5 * this.thickness);
    this.scene.add(this.triad(reach, 0.0022 * this.size));
  }

  // Lines every half metre, stronger every metre, fading out around the scene; drawn by a shader because lines of the
  // graphics library are one pixel wide and shimmer at a distance.
  add_floor() {
    const middle = this.box.getCenter(new THREE.Vector3());
    const reach = 1.25 * this.size + 0.5;
    this.floor = new THREE.ShaderMaterial({
      uniforms: {
        colour: {value: new THREE.Color()},
        strength: {value: 1},
        middle: {value: new THREE.Vector2(middle.x, middle.y)},
        reach: {value: reach}
      },
      vertexShader: `
        varying vec2 p;
        void main() {
          vec4 world = modelMatrix * vec4(position, 1.0);
          p = world.xy;
          gl_Position = projectionMatrix * viewMatrix * world;
        }`,
      fragmentShader: `
        varying vec2 p; uniform vec3 colour; uniform float strength, reach; uniform vec2 middle;
        float lines(float cell, float pixels) {
          vec2 x = p / cell, width = fwidth(x);
          vec2 near = abs(fract(x - 0.5) - 0.5) / max(width, 1e-6);
          vec2 on = (1.0 - smoothstep(pixels - 0.5, pixels + 0.5, near)) * (1.0 - smoothstep(0.15, 0.5, width));
          return max(on.x, on.y);
        }
        void main() {
          float fade = 1.0 - smoothstep(0.35, 1.0, length(p - middle) / reach);
          float on = max(0.5 * lines(0.5, 0.6), lines(1.0, 0.8));
          gl_FragColor = vec4(colour, strength * on * fade);
        }`,
      extensions: {derivatives: true},
      transparent: true,
      depthWrite: false,
      side: THREE.DoubleSide,
    });
    const plane = new THREE.PlaneBufferGeometry(2 * reach, 2 * reach);
    const grid = new THREE.Mesh(plane, this.floor);
    this.shade = new THREE.ShadowMaterial({opacity: 0.16, depthWrite: false});
    const shadow = new THREE.Mesh(plane, this.shade);
    shadow.receiveShadow = true;
    [shadow, grid].forEach((mesh, order) => {
      mesh.position.set(middle.x, middle.y, -0.0005 * this.size * (2 - order));
      mesh.renderOrder = -2 + order;
      this.scene.add(mesh);
    });
  }

  add_lights() {
    this.sky = new THREE.HemisphereLight(0xffffff, 0xb9c0cc, 0.6);
    this.sky.position.set(0, 0, 1);
    const middle = this.box.getCenter(new THREE.Vector3()), far = 1.5 * this.size;
    this.sun = new THREE.DirectionalLight(0xffffff, 0.62);
    this.sun.position.copy(middle).add(new THREE.Vector3(-0.35, -0.55, 1.1).normalize().multiplyScalar(far));
    this.sun.target.position.copy(middle);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    this.sun.shadow.radius = 3;
    const reach = 0.85 * this.size;
    Object.assign(
        this.sun.shadow.camera,
        {left: -reach, right: reach, top: reach, bottom: -reach, near: 0.01 * far, far: 3 * far});
    const fill = new THREE.DirectionalLight(0xffffff, 0.16);
    fill.position.set(1, -0.6, 0.3);
    this.scene.add(this.sky, this.sun, this.sun.target, fill);
  }

  set_theme(dark) {
    this.floor.uniforms.colour.value.set(dark ? "#8b9bb0" : "#5d6b80");
    this.floor.uniforms.strength.value = dark ? 0.38 : 0.42;
    this.shade.opacity = dark ? 0.42 : 0.17;
    this.sky.groundColor.set(dark ? 0x77808c : 0xb9c0cc);
  }

  // Poses everything at `t`, a fraction of the path's duration. Poses between samples are interpolated.
  pose(t) {
    const samples = this.data.samples;
    if (!this.moments) {
      const times = this.data.times, span = times.length ? times[times.length - 1] - times[0] : 0;
      this.moments = Array.from(
          {length: samples}, (_, i) => (span > 0 ? (times[i] - times[0]) / span : i / Math.max(1, samples - 1)));
    }
    let low = 0, high = samples - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.moments[middle] <= t)
        low = middle;
      else
        high = middle;
    }
    const gap = this.moments[high] - this.moments[low];
    const weight = gap > 0 ? Math.min(1, Math.max(0, (t - this.moments[low]) / gap)) : 1;
    for (const follower of this.followers) follower.at(low, weight);
    if (this.travelled) this.travelled.geometry.setDrawRange(0, this.travelled_counts[weight >= 1 ? high : low]);
  }

  light_up(module) {
    for (const [own, material] of this.materials) material.emissive.set(own === module ? 0x333333 : 0x000000);
  }
}
