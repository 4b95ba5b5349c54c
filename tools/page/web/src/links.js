// Any robot as three.js meshes, from the links of tools/page/embedded/urdf_scene.h: the shapes of its URDF, or,
// where a link has none, bars between its joints and to its centre of mass.
import * as THREE from "three";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";

const kBar = 0.012, kJoint = 0.022, kJointLength = 0.07, kBob = 0.04, kRail = 0.014;  // of the size
const kLitJoint = 1.5, kNear = 0.02;

const vector = (a) => new THREE.Vector3(a[0], a[1], a[2]);
const rotation = (q) => new THREE.Quaternion(q[1], q[2], q[3], q[0]);

export const kLit = 0xd6006c;
const kLooks = {
  link: { color: 0xd5dae0, roughness: 0.4, metalness: 0.15 },
  joint: { color: 0x454d56, roughness: 0.55, metalness: 0.05 },
  lit: { color: kLit, roughness: 0.4, emissive: kLit, emissiveIntensity: 0.35 },
};

/** Cylinders of three.js lie along y; a bar from one point to another. */
function bar(from, to, radius, round = true) {
  const delta = to.clone().sub(from);
  const geometry = round ? new THREE.CapsuleGeometry(radius, delta.length(), 6, 16)
                         : new THREE.CylinderGeometry(radius, radius, delta.length(), 24);
  const up = new THREE.Vector3(0, 1, 0);
  geometry.applyQuaternion(new THREE.Quaternion().setFromUnitVectors(up, delta.normalize()));
  return geometry.translate(...from.clone().add(to).multiplyScalar(0.5).toArray());
}

function geometryOf(shape) {
  if (shape.type === "box") return new THREE.BoxGeometry(...shape.size);
  if (shape.type === "sphere") return new THREE.SphereGeometry(shape.radius, 28, 18);
  if (shape.type === "cylinder")
    return new THREE.CylinderGeometry(shape.radius, shape.radius, shape.length, 28).rotateX(Math.PI / 2);
  const bytes = Uint8Array.from(atob(shape.stl), (c) => c.charCodeAt(0));
  const geometry = new STLLoader().parse(bytes.buffer).scale(...shape.scale);
  geometry.computeVertexNormals();  // many files have none
  return geometry;
}

export class LinkRobot {
  /** Joints and places alone: dress() adds what is seen. */
  constructor(links) {
    this.links = links;
    this.root = new THREE.Group();
    this.joints = new Map();
    this.groups = links.map(() => new THREE.Group());
    links.forEach((link, i) => {
      const group = this.groups[i], home = vector(link.pos), turn = rotation(link.quat);
      group.position.copy(home);
      group.quaternion.copy(turn);
      (link.parent < 0 ? this.root : this.groups[link.parent]).add(group);
      if (!link.joint) return;
      const axis = vector(link.joint.axis).normalize();
      this.joints.set(link.joint.name, { group, axis, home, turn, slides: link.joint.slides, q: 0, range: [0, 0] });
    });
  }

  setJoint(name, q) {
    const joint = this.joints.get(name);
    if (!joint) return;
    joint.q = q;
    if (joint.slides) joint.group.position.copy(joint.axis).multiplyScalar(q).applyQuaternion(joint.turn).add(joint.home);
    else joint.group.quaternion.setFromAxisAngle(joint.axis, q).premultiply(joint.turn);
  }
  /** `base`: position, quaternion w x y z; absent: it stands where it is. */
  setState(q, names, base) {
    if (base) {
      this.root.position.set(base[0], base[1], base[2]);
      this.root.quaternion.set(base[4], base[5], base[6], base[3]).normalize();
    }
    names.forEach((name, j) => this.setJoint(name, q[j]));
  }

  /** What the skeleton takes up now, shapes roughly. */
  extend(box) {
    this.root.updateMatrixWorld(true);
    this.links.forEach((link, i) => {
      const at = (p) => box.expandByPoint(this.groups[i].localToWorld(p));
      at(new THREE.Vector3());
      if (link.com) at(vector(link.com));
      for (const shape of link.shapes) {
        const half = shape.type === "box" ? 0.5 * Math.max(...shape.size)
          : Math.max(shape.radius ?? 0, 0.5 * (shape.length ?? 0));
        for (const side of [-half, half]) at(vector(shape.pos).addScalar(side));
      }
    });
  }

  /** `size`: of the whole, m. `ghost`: a colour, for one that is looked through. `lit`: names of
      joints and links. */
  dress(size, ghost, lit = new Set()) {
    this.ghost = ghost;
    const looks = ghost ? this.ghostly(ghost) : undefined;
    const made = new Map();
    const material = (look) => {
      if (looks) return looks;
      if (!made.has(look)) made.set(look, new THREE.MeshStandardMaterial(kLooks[look]));
      return made.get(look);
    };
    this.links.forEach((link, i) => {
      const add = (geometry, look, to = this.groups[i]) => {
        const mesh = new THREE.Mesh(geometry, material(look));
        mesh.castShadow = mesh.receiveShadow = !ghost;
        to.add(mesh);
        return mesh;
      };
      const look = lit.has(link.name) ? "lit" : "link";
      for (const shape of link.shapes) {
        const mesh = add(geometryOf(shape), look);
        mesh.position.copy(vector(shape.pos));
        mesh.quaternion.copy(rotation(shape.quat));
      }
      if (link.shapes.length === 0) for (const geometry of this.bars(link, i, size)) add(geometry, look);
      if (link.joint) this.addJoint(link, size, lit.has(link.joint.name), add);
    });
  }
  ghostly(color) {
    this.look = new THREE.MeshStandardMaterial({ color, transparent: true, opacity: 0.4, depthWrite: false,
      polygonOffset: true, polygonOffsetFactor: 4, polygonOffsetUnits: 40 });
    return this.look;
  }

  /** Of a link without shapes: to the joints that it carries and to its mass. */
  *bars(link, i, size) {
    const origin = new THREE.Vector3();
    const ends = this.links.filter((l) => l.parent === i).map((l) => vector(l.pos));
    const com = link.com && vector(link.com);
    for (const end of ends) if (end.length() > kNear * size) yield bar(origin, end, kBar * size);
    if (!com || (ends.length > 0 && link.parent < 0)) return;
    if (com.length() > kNear * size) {
      if (ends.length > 0) return;  // along its bars anyway
      yield bar(origin, com, kBar * size);
      yield new THREE.SphereGeometry(kBob * size, 28, 18).translate(...com.toArray());
    } else if (link.joint && ends.length === 0) {
      yield new THREE.BoxGeometry(3 * kBob * size, 3 * kBob * size, 2 * kBob * size);
    }
  }
  addJoint(link, size, lit, add) {
    const joint = this.joints.get(link.joint.name), grow = lit ? kLitJoint : 1, look = lit ? "lit" : "joint";
    if (!joint.slides) {
      const half = joint.axis.clone().multiplyScalar(0.5 * kJointLength * grow * size);
      add(bar(half.clone().negate(), half, kJoint * grow * size, false), look);
      return;
    }
    const along = joint.axis.clone().applyQuaternion(joint.turn);
    const ends = joint.range.map((q) => along.clone().multiplyScalar(q).add(joint.home));
    if (ends[0].distanceTo(ends[1]) > 1e-6)  // the way that it goes, on what carries it
      add(bar(ends[0], ends[1], kRail * grow * size, false), look, joint.group.parent);
  }
}
