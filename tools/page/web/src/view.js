// The room that the robot stands in: light, floor, camera, one robot, the ghost of its reference, and
// arrows of the forces on its feet.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Robot } from "./robot.js";

const kGhost = 0xe69f00, kForce = 0x009e73, kMetrePerNewton = 0.3 / 30;
const kBackground = 0xe9edf1;
const kMeasureEvery = 8, kRest = 3, kLongestRest_ms = 400;  // draws; times what a draw took

function light(scene) {
  scene.add(new THREE.HemisphereLight(0xffffff, 0xb9c2cc, 1.9));
  const sun = new THREE.DirectionalLight(0xffffff, 2.4);
  sun.position.set(0.7, -0.9, 1.6);
  sun.castShadow = true;
  sun.shadow.mapSize.set(1024, 1024);
  Object.assign(sun.shadow.camera, { left: -0.6, right: 0.6, top: 0.6, bottom: -0.6, near: 0.2, far: 4 });
  sun.shadow.radius = 4;
  sun.shadow.bias = -0.0006;
  scene.add(sun, sun.target);
  return sun;
}

/** Tiles as a texture: lines of their own shimmer when one looks along the floor. */
function tiles(count) {
  const size = 128, canvas = document.createElement("canvas");
  canvas.width = canvas.height = size;
  const c = canvas.getContext("2d");
  c.fillStyle = "#ffffff";
  c.fillRect(0, 0, size, size);
  c.strokeStyle = "#b4bec8";
  c.lineWidth = 3;
  c.strokeRect(0, 0, size, size);
  const texture = new THREE.CanvasTexture(canvas);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.repeat.set(count, count);
  texture.anisotropy = 8;
  texture.colorSpace = THREE.SRGBColorSpace;
  return texture;
}

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

export class View {
  /** Draws into `holder`. `place` is {ground, robot} of mjcf.js. */
  constructor(holder, place, fixed, names) {
    this.holder = holder;
    this.names = names;
    this.drawn = this.cost_ms = this.rest_until = 0;
    this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    holder.append(this.renderer.domElement);
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(kBackground);
    this.scene.fog = new THREE.Fog(kBackground, 1.6, 4.5);
    this.camera = new THREE.PerspectiveCamera(32, 1, 0.02, 30);
    this.camera.up.set(0, 0, 1);
    this.sun = light(this.scene);
    this.sunFrom = this.sun.position.clone();
    for (const geom of place.ground) this.scene.add(groundMesh(geom));
    this.robot = new Robot(place.robot, fixed);
    this.ghost = new Robot(place.robot, fixed, kGhost);
    this.ghost.root.visible = false;
    this.scene.add(this.robot.root, this.ghost.root);
    this.arrows = [new Arrow(this.scene), new Arrow(this.scene)];
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableDamping = false;
    this.controls.minDistance = 0.25;
    this.controls.maxDistance = 3;
    this.controls.maxPolarAngle = 0.49 * Math.PI;
    this.controls.target.set(0, 0, 0.21);
    this.camera.position.set(0.95, -0.78, 0.5);
    this.controls.addEventListener("change", () => (this.dirty = true));
    new ResizeObserver(() => this.resize()).observe(holder);
    this.resize();
  }

  resize() {
    const { clientWidth: w, clientHeight: h } = this.holder;
    if (w === 0 || h === 0) return;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.renderer.setSize(w, h);
    this.camera.aspect = w / h;
    this.camera.fov = w < h ? 42 : 32;
    this.camera.updateProjectionMatrix();
    this.draw();
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

  draw() {
    const begin = performance.now();
    this.dirty = false;
    this.controls.update();
    this.renderer.render(this.scene, this.camera);
    if (++this.drawn % kMeasureEvery === 0) {  // asking for a pixel waits until it is there
      const gl = this.renderer.getContext();
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
      this.cost_ms = performance.now() - begin;
    }
    this.rest_until = performance.now() + Math.min(kLongestRest_ms, kRest * this.cost_ms);
  }
  /** A machine that draws by software shares its cores with the robot: it draws less often. */
  drawIfNew() { if (this.dirty && performance.now() >= this.rest_until) this.draw(); }
}
