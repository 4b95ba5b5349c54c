// The robot as three.js meshes, from the bodies of mjcf.js: limbs are the collision primitives, feet
// the outline of the sole points, and every joint shows its servo where its axis is.
import * as THREE from "three";
import { RoundedBoxGeometry } from "three/examples/jsm/geometries/RoundedBoxGeometry.js";

const kServoRadius = 0.0145, kServoLength = 0.036, kStrutRadius = 0.008, kFootHeight = 0.009;

const vector = (a) => new THREE.Vector3(a[0], a[1], a[2]);

/** Cylinders and capsules of three.js lie along y; this turns y into `direction`. */
function along(direction) {
  const up = new THREE.Vector3(0, 1, 0);
  return new THREE.Quaternion().setFromUnitVectors(up, direction.clone().normalize());
}

function bar(from, to, radius, round) {
  const delta = to.clone().sub(from);
  const geometry = round
    ? new THREE.CapsuleGeometry(radius, delta.length(), 6, 20)
    : new THREE.CylinderGeometry(radius, radius, delta.length(), 24);
  geometry.applyQuaternion(along(delta));
  geometry.translate(...from.clone().add(to).multiplyScalar(0.5).toArray());
  return geometry;
}

function box(geom) {
  const [x, y, z] = geom.size.map((s) => 2 * s);
  const geometry = new RoundedBoxGeometry(x, y, z, 4, 0.22 * Math.min(x, y, z));
  geometry.translate(...geom.pos);
  return geometry;
}

/** The plate whose corners are the sole's points, in the order in which they lie around it. */
function plate(points) {
  const centre = points.reduce((c, p) => c.add(vector(p.pos)), new THREE.Vector3());
  centre.divideScalar(points.length);
  const around = [...points].sort((a, b) =>
    Math.atan2(a.pos[1] - centre.y, a.pos[0] - centre.x) -
    Math.atan2(b.pos[1] - centre.y, b.pos[0] - centre.x));
  const shape = new THREE.Shape(around.map((p) => new THREE.Vector2(p.pos[0], p.pos[1])));
  const geometry = new THREE.ExtrudeGeometry(shape, {
    depth: kFootHeight, bevelEnabled: true, bevelSize: 0.002, bevelThickness: 0.002, bevelSegments: 2,
  });
  geometry.translate(0, 0, points[0].pos[2] - points[0].size[0] + 0.002);
  return { geometry, centre };
}

function* shapesOf(body) {
  const limbs = body.geoms.filter((g) => g.role !== "sole" && !g.name.includes("plate"));
  const isTrunk = body.joint == undefined || /head/.test(body.name);
  for (const g of limbs) {
    if (g.type === "box") yield { geometry: box(g), look: isTrunk ? "shell" : "limb" };
    if (g.type === "capsule")
      yield { geometry: bar(vector(g.fromto), vector(g.fromto.slice(3)), g.size[0], true), look: "limb" };
    if (g.type === "box" && /head/.test(body.name)) {  // where it looks
      const visor = { pos: [g.pos[0] + 0.85 * g.size[0], g.pos[1], g.pos[2] + 0.1 * g.size[2]],
                      size: [0.2 * g.size[0], 0.78 * g.size[1], 0.36 * g.size[2]] };
      yield { geometry: box(visor), look: "dark" };
    }
  }
  if (body.joint && !/wheel/.test(body.name)) {
    const half = vector(body.joint.axis).multiplyScalar(0.5 * kServoLength);
    yield { geometry: bar(half.clone().negate(), half, kServoRadius), look: "dark" };
    const cap = vector(body.joint.axis).multiplyScalar(0.5 * kServoLength + 0.0015);
    yield { geometry: bar(cap.clone().negate(), cap, 0.6 * kServoRadius), look: "accent" };
  }
  for (const child of body.children) {
    const to = vector(child.pos);
    if (body.joint && to.length() > 0.015 && !/wheel/.test(child.name))
      yield { geometry: bar(new THREE.Vector3(), to, kStrutRadius, true), look: "dark" };
  }
}

const kLooks = {
  shell: { color: 0xf2f4f6, roughness: 0.35, metalness: 0.05 },
  limb: { color: 0xd5dae0, roughness: 0.4, metalness: 0.15 },
  dark: { color: 0x454d56, roughness: 0.55, metalness: 0.05 },
  accent: { color: 0x0a86cc, roughness: 0.4, metalness: 0.05 },
};

function materials(ghost) {
  const out = {};
  for (const [name, look] of Object.entries(kLooks))
    out[name] = ghost
      ? new THREE.MeshStandardMaterial({ color: ghost, transparent: true, opacity: 0.3, depthWrite: false,
          polygonOffset: true, polygonOffsetFactor: 4, polygonOffsetUnits: 40 })
      : new THREE.MeshStandardMaterial(look);
  return out;
}

export class Robot {
  /** `fixed`: angles of the joints that no state names. `ghost`: a colour, for one you look through. */
  constructor(definition, fixed, ghost) {
    this.joints = new Map();
    this.feet = [];
    this.materials = materials(ghost);
    this.solid = !ghost;
    this.root = this.build(definition);
    for (const [name, angle] of Object.entries(fixed ?? {})) this.setJoint(name, angle);
  }

  build(body) {
    const group = new THREE.Group();
    group.position.set(...body.pos);
    if (body.joint)
      this.joints.set(body.joint.name, { group, axis: vector(body.joint.axis), angle: 0 });
    const add = (geometry, look) => {
      const mesh = new THREE.Mesh(geometry, this.materials[look]);
      mesh.castShadow = this.solid;
      mesh.receiveShadow = this.solid;
      group.add(mesh);
    };
    for (const shape of shapesOf(body)) add(shape.geometry, shape.look);
    const sole = body.geoms.filter((g) => g.role === "sole");
    if (sole.length > 2) {
      const { geometry, centre } = plate(sole);
      add(geometry, "dark");
      this.feet.push({ group, centre });
    }
    for (const child of body.children) group.add(this.build(child));
    return group;
  }

  setJoint(name, angle) {
    const joint = this.joints.get(name);
    if (!joint) return;
    joint.angle = angle;
    joint.group.quaternion.setFromAxisAngle(joint.axis, angle);
  }

  /** `x`: position, quaternion w x y z, then the angles of `names`. */
  setState(x, names) {
    this.root.position.set(x[0], x[1], x[2]);
    this.root.quaternion.set(x[4], x[5], x[6], x[3]).normalize();
    names.forEach((name, j) => this.setJoint(name, x[7 + j]));
  }

  /** Where foot `i` (in the order of the model: the order of the bodies) stands in the world. */
  footCentre(side) {
    const foot = this.feet.find((f) => this.sideOf(f) === side);
    return foot && foot.group.localToWorld(foot.centre.clone());
  }
  sideOf(foot) {
    for (const [name, joint] of this.joints) if (joint.group === foot.group) return name[0];
    return "";
  }
}
