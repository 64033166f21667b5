// Geometry. three.js stands its cylinders along y and has no capsule; ours lie along z.

function matrix_of(X) {
  return new THREE.Matrix4().set(X[0], X[1], X[2], X[3], X[4], X[5], X[6], X[7], X[8], X[9], X[10], X[11], 0, 0, 0, 1);
}

function capsule_geometry(radius, length) {
  const profile = [];
  const kSteps = 10;
  for (let i = 0; i <= kSteps; ++i) {
    const angle = -Math.PI / 2 + (i / kSteps) * (Math.PI / 2);
    profile.push(new THREE.Vector2(radius * Math.cos(angle), radius * Math.sin(angle) - length / 2));
  }
  for (let i = 0; i <= kSteps; ++i) {
    const angle = (i / kSteps) * (Math.PI / 2);
    profile.push(new THREE.Vector2(radius * Math.cos(angle), radius * Math.sin(angle) + length / 2));
  }
  return new THREE.LatheBufferGeometry(profile, 40).rotateX(Math.PI / 2);
}

function mesh_geometry(shape) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(shape.vertices), 3));
  geometry.setIndex(shape.triangles);
  // Vertices of its own for every triangle: facets and edges of a part are real, smoothing them away is not.
  const faceted = geometry.toNonIndexed();
  faceted.computeVertexNormals();
  return faceted;
}

function geometry_of(shape) {
  const size = shape.size;
  switch (shape.kind) {
    case "sphere":
      return new THREE.SphereBufferGeometry(size[0], 48, 32);
    case "box":
      return new THREE.BoxBufferGeometry(size[0], size[1], size[2]);
    case "cylinder":
      return new THREE.CylinderBufferGeometry(size[0], size[0], size[1], 48).rotateX(Math.PI / 2);
    case "capsule":
      return capsule_geometry(size[0], size[1]);
    default:
      return mesh_geometry(shape);
  }
}

// Half the thickness of a body at its thinnest: the scale of the joint symbols. Null where no shape tells.
function thickness_of(shapes) {
  let thickness = null;
  for (const shape of shapes) {
    let own = null;
    if (shape.kind === "box")
      own = Math.min(...shape.size) / 2;
    else if (shape.kind !== "mesh")
      own = shape.size[0];
    if (own !== null && (thickness === null || own < thickness)) thickness = own;
  }
  return thickness;
}

// A tube of straight pieces through `points`. Its index runs along the path, so that a draw range shows the part
// travelled: `counts[i]` indices lead to point i.
function tube_geometry(points, radius) {
  const kSides = 8;
  const positions = [], normals = [], index = [], counts = [0];
  for (let i = 1; i < points.length; ++i) {
    const from = new THREE.Vector3(...points[i - 1]), to = new THREE.Vector3(...points[i]);
    const along = to.clone().sub(from);
    if (along.length() > 1e-9) {
      along.normalize();
      const across = new THREE.Vector3(Math.abs(along.x) < 0.8 ? 1 : 0, Math.abs(along.x) < 0.8 ? 0 : 1, 0);
      const u = across.cross(along).normalize(), v = along.clone().cross(u);
      const first = positions.length / 3;
      for (let side = 0; side < kSides; ++side) {
        const angle = (side / kSides) * 2 * Math.PI;
        const normal = u.clone().multiplyScalar(Math.cos(angle)).addScaledVector(v, Math.sin(angle));
        for (const end of [from, to]) {
          positions.push(...end.clone().addScaledVector(normal, radius).toArray());
          normals.push(...normal.toArray());
        }
        const a = first + 2 * side, b = first + 2 * ((side + 1) % kSides);
        index.push(a, b, a + 1, b, b + 1, a + 1);
      }
    }
    counts.push(index.length);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(positions, 3));
  geometry.setAttribute("normal", new THREE.Float32BufferAttribute(normals, 3));
  geometry.setIndex(index);
  return {geometry, counts};
}

// Points that enclose a body, in its frame: the corners of the box about each of its shapes.
function corners_of(body_shapes) {
  const corners = [];
  for (const {geometry, matrix} of body_shapes) {
    geometry.computeBoundingBox();
    const {min, max} = geometry.boundingBox;
    for (const x of [min.x, max.x])
      for (const y of [min.y, max.y])
        for (const z of [min.z, max.z]) { corners.push(new THREE.Vector3(x, y, z).applyMatrix4(matrix)); }
  }
  return corners;
}
