// A lit room with a camera that a person turns: what every picture of a robot is drawn in.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

const kBackground = 0xe9edf1;
const kMeasureEvery = 8, kRest = 3, kLongestRest_ms = 400;  // draws; times what a draw took

function light(scene, scale) {
  scene.add(new THREE.HemisphereLight(0xffffff, 0xb9c2cc, 1.9));
  const sun = new THREE.DirectionalLight(0xffffff, 2.4);
  sun.position.set(0.7, -0.9, 1.6).multiplyScalar(scale);
  sun.castShadow = true;
  sun.shadow.mapSize.set(1024, 1024);
  Object.assign(sun.shadow.camera, { left: -0.6 * scale, right: 0.6 * scale, top: 0.6 * scale, bottom: -0.6 * scale, near: 0.2 * scale, far: 4 * scale });
  sun.shadow.radius = 4;
  sun.shadow.bias = -0.0006;
  scene.add(sun, sun.target);
  return sun;
}

/** Tiles as a texture: lines of their own shimmer when one looks along the floor. */
export function tiles(count) {
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

export class Room {
  /** Draws into `holder`. `scale`: of what is in the room, against a robot of half a metre. */
  constructor(holder, scale) {
    this.holder = holder;
    this.scale = scale;
    this.drawn = this.cost_ms = this.rest_until = 0;
    this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    holder.append(this.renderer.domElement);
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(kBackground);
    this.scene.fog = new THREE.Fog(kBackground, 1.6 * scale, 4.5 * scale);
    this.camera = new THREE.PerspectiveCamera(32, 1, 0.02 * scale, 30 * scale);
    this.camera.up.set(0, 0, 1);
    this.sun = light(this.scene, scale);
    this.sunFrom = this.sun.position.clone();
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableDamping = false;
    this.controls.addEventListener("change", () => (this.dirty = true));
  }
  /** Once everything is in the room: follows the size of what it is drawn into. */
  open() {
    new ResizeObserver(() => this.resize()).observe(this.holder);
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
