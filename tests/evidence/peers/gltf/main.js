// Shows a mesh that was made in advance for one isovalue. Each isovalue has a separate mesh.
// ?mesh=V.glb
import { MeshoptDecoder } from "meshoptimizer/decoder";
import {
  Box3,
  Color,
  HemisphereLight,
  PerspectiveCamera,
  Scene,
  Sphere,
  WebGLRenderer,
} from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
const renderer = new WebGLRenderer({ antialias: true });
renderer.setSize(innerWidth, innerHeight);
document.getElementById("view").append(renderer.domElement);
const scene = new Scene();
scene.background = new Color(0xffffff);
scene.add(new HemisphereLight(0xffffff, 0x444444, 3));
const camera = new PerspectiveCamera(30, innerWidth / innerHeight, 1, 10000);
let shown;

async function show(file) {
  const { scene: mesh } = await loader.loadAsync(file);
  if (shown) {
    scene.remove(shown);
    shown.traverse((part) => part.geometry?.dispose());
  } else {
    const { center, radius } = new Box3().setFromObject(mesh).getBoundingSphere(new Sphere());
    camera.position.set(0.5, 0.4, 1).setLength(radius / Math.sin(Math.PI / 12));
    camera.position.add(center);
    camera.lookAt(center);
  }
  shown = mesh;
  scene.add(mesh);
  renderer.render(scene, camera);
}

await show(new URL(location.href).searchParams.get("mesh"));
performance.mark("peer:image");
globalThis.changeIsovalue = (isovalue) => show(`${isovalue}.glb`);
