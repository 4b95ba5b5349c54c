// The room that the robot stands in: its ground, one robot, the ghost of its reference, and arrows of
// the forces on its feet.
import * as THREE from "three";
import { LinkRobot } from "./links.js";
import { Robot } from "./robot.js";
import { Room, tiles } from "./room.js";

const kGhost = 0xe69f00, kForce = 0x009e73, kMetrePerNewton = 0.3 / 30, kRobot_m = 0.5;

/** One mesh for each piece of the ground that the physics has. */
function groundMesh(geom) {
  const plane = geom.type === "plane";
  const geometry = plane ? new THREE.PlaneGeometry(40, 40)
                         : new THREE.BoxGeometry(...geom.size.map((s) => 2 * s));
  const material = new THREE.MeshStandardMaterial({ color: plane ? 0xe4e8ec : 0xd3d9df, roughness: 0.95 });
  const mesh = new THREE.Mesh(geometry, material);
  mesh.position.set(...geom.pos);
  mesh.rotation.set(...geom.euler, "XYZ");
  mesh.receiveShadow = true;
  if (plane) material.map = tiles(400);  // 0.1 m
  return mesh;
}

class Arrow {
  constructor(scene) {
    // seen through the leg that it goes up in
    const material = new THREE.MeshBasicMaterial({ color: kForce, transparent: true, opacity: 0.85, depthTest: false });
    this.shaft = new THREE.Mesh(new THREE.CylinderGeometry(0.004, 0.004, 1, 16), material);
    this.head = new THREE.Mesh(new THREE.ConeGeometry(0.011, 0.028, 20), material);
    this.shaft.renderOrder = this.head.renderOrder = 2;
    this.group = new THREE.Group().add(this.shaft, this.head);
    scene.add(this.group);
  }
  set(at, force) {
    const length = force.length() * kMetrePerNewton;
    this.group.visible = at != undefined && length > 0.01;
    if (!this.group.visible) return;
    this.group.position.copy(at);
    this.group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), force.clone().normalize());
    this.shaft.scale.y = length;
    this.shaft.position.y = 0.5 * length;
    this.head.position.y = length;
  }
}

/** Our robot as its own URDF shows it, with what Robot can do. */
class UrdfRobot extends LinkRobot {
  constructor(urdf, fixed, ghost) {
    super(urdf.links);
    for (const [name, angle] of Object.entries(fixed ?? {})) this.setJoint(name, angle);
    this.dress(kRobot_m, ghost);
  }
  setState(x, names) { super.setState(Array.from(x).slice(7), names, x); }
  /** The middle of the sole, below the last joint of a leg. */
  footCentre(side) {
    const foot = this.joints.get(`${side}_ank_roll`);
    if (!foot) return undefined;
    if (!foot.sole) {
      const box = new THREE.Box3();
      foot.group.traverse((o) => {
        if (o.parent !== foot.group || !o.geometry) return;
        o.geometry.computeBoundingBox();
        o.updateMatrix();
        box.union(o.geometry.boundingBox.clone().applyMatrix4(o.matrix));
      });
      foot.sole = box.isEmpty() ? new THREE.Vector3() : box.getCenter(new THREE.Vector3()).setZ(box.min.z);
    }
    return foot.group.localToWorld(foot.sole.clone());
  }
}

export class View extends Room {
  /** Draws into `holder`. `place` is {ground, robot} of mjcf.js; `urdf`, if there is one, says how the
      robot looks. */
  constructor(holder, place, fixed, names, urdf) {
    super(holder, 1);
    this.names = names;
    for (const geom of place.ground) this.scene.add(groundMesh(geom));
    const robot = (ghost) => (urdf ? new UrdfRobot(urdf, fixed, ghost) : new Robot(place.robot, fixed, ghost));
    this.robot = robot();
    this.ghost = robot(kGhost);
    this.ghost.root.visible = false;
    this.scene.add(this.robot.root, this.ghost.root);
    this.arrows = [new Arrow(this.scene), new Arrow(this.scene)];
    this.controls.minDistance = 0.25;
    this.controls.maxDistance = 3;
    this.controls.maxPolarAngle = 0.49 * Math.PI;
    this.controls.target.set(0, 0, 0.21);
    this.camera.position.set(0.95, -0.78, 0.5);
    this.open();
  }

  /** `x`, `reference`: 19 numbers (reference may be missing); `forces`: [right, left] in N. */
  show(x, reference, forces) {
    this.robot.setState(x, this.names);
    this.ghost.root.visible = reference != undefined;
    if (reference) this.ghost.setState(reference, this.names);
    this.robot.root.updateMatrixWorld(true);
    ["r", "l"].forEach((side, i) => {
      const force = new THREE.Vector3(...(forces?.[i] ?? [0, 0, 0]));
      this.arrows[i].set(this.robot.footCentre(side), force);
    });
    this.follow(x);
    this.dirty = true;
  }

  /** The camera stands still where it sees all these points of the way, and the robot at each. */
  standAside(points) {
    this.stands = true;
    const way = new THREE.Box3().setFromPoints(points.map((p) => new THREE.Vector3(p[0], p[1], 0)));
    const middle = way.getCenter(new THREE.Vector3()).setZ(0.21), size = way.getSize(new THREE.Vector3());
    const up = Math.tan(THREE.MathUtils.degToRad(0.5 * this.camera.fov));
    const away = Math.max((0.5 * size.x + 0.3) / (up * this.camera.aspect), 0.3 / up) + 0.5 * size.y;
    this.controls.target.copy(middle);
    this.camera.position.set(0.42, -0.86, 0.26).normalize().multiplyScalar(away).add(middle);
    this.scene.fog.near = away + 0.6;
    this.scene.fog.far = away + 3.5;
  }
  /** The camera is where it would be, had it gone along all the time. */
  jump(x) {
    const move = new THREE.Vector3(x[0] - this.controls.target.x, x[1] - this.controls.target.y, 0);
    this.controls.target.add(move);
    this.camera.position.add(move);
  }

  /** The camera goes along, so that a walking robot does not leave the picture. */
  follow(x) {
    const move = new THREE.Vector3(x[0] - this.controls.target.x, x[1] - this.controls.target.y, 0);
    move.multiplyScalar(this.stands ? 0 : 0.15);
    this.controls.target.add(move);
    this.camera.position.add(move);
    this.sun.target.position.set(x[0], x[1], 0.1);
    this.sun.position.copy(this.sunFrom).add(this.sun.target.position);
  }
}
