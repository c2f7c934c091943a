// Draws an isosurface with three.js and a ray caster in a fragment shader: steps of one voxel
// through a 3D texture (as in three.js's own VolumeShader), four bisections, and a normal from
// central differences.
import {
  BackSide,
  BoxGeometry,
  Data3DTexture,
  GLSL3,
  LinearFilter,
  Mesh,
  PerspectiveCamera,
  RedFormat,
  Scene,
  ShaderMaterial,
  Vector3,
  WebGLRenderer,
} from "three";

const vertexShader = `
out vec3 eye;
out vec3 direction;
void main() {
  eye = (inverse(modelMatrix) * vec4(cameraPosition, 1.0)).xyz;
  direction = position - eye;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

const fragmentShader = `
precision highp float;
precision highp sampler3D;
uniform sampler3D volume;
uniform vec3 voxels;
uniform vec3 size;
uniform float isovalue;
in vec3 eye;
in vec3 direction;
out vec4 color;

vec3 gradientAt(vec3 at) {
  vec3 e = 1.0 / voxels;
  vec3 difference = vec3(
    texture(volume, at + vec3(e.x, 0, 0)).r - texture(volume, at - vec3(e.x, 0, 0)).r,
    texture(volume, at + vec3(0, e.y, 0)).r - texture(volume, at - vec3(0, e.y, 0)).r,
    texture(volume, at + vec3(0, 0, e.z)).r - texture(volume, at - vec3(0, 0, e.z)).r);
  return difference * voxels / size;
}

void main() {
  vec3 ray = normalize(direction);
  vec3 a = (-0.5 - eye) / ray;
  vec3 b = (0.5 - eye) / ray;
  vec3 near = min(a, b);
  vec3 far = max(a, b);
  float begin = max(max(near.x, near.y), max(near.z, 0.0));
  float end = min(min(far.x, far.y), far.z);
  if (begin >= end) discard;
  vec3 span = (end - begin) * ray;
  int steps = int(ceil(length(span * voxels)));
  vec3 advance = span / float(steps);
  vec3 at = eye + begin * ray + 0.5;
  for (int i = 0; i <= steps; ++i) {
    if (texture(volume, at).r >= isovalue) {
      vec3 outside = at - advance;
      vec3 inside = at;
      for (int j = 0; j < 4; ++j) {
        vec3 middle = 0.5 * (outside + inside);
        if (texture(volume, middle).r >= isovalue) inside = middle;
        else outside = middle;
      }
      vec3 normal = normalize(gradientAt(inside));
      float light = abs(dot(normal, normalize(ray * size)));
      color = vec4(vec3(0.85, 0.8, 0.7) * (0.15 + 0.85 * light), 1.0);
      return;
    }
    at += advance;
  }
  discard;
}`;

export class RayCaster {
  #renderer = new WebGLRenderer({ antialias: false });
  #scene = new Scene();
  #camera = new PerspectiveCamera(30, innerWidth / innerHeight, 1, 10000);
  #material = new ShaderMaterial({
    glslVersion: GLSL3,
    vertexShader,
    fragmentShader,
    side: BackSide,
    uniforms: {
      volume: { value: null },
      voxels: { value: new Vector3() },
      size: { value: new Vector3() },
      isovalue: { value: 0 },
    },
  });

  /** `size`: of the volume, in world units. */
  constructor(container, size, isovalue) {
    this.#renderer.setSize(innerWidth, innerHeight);
    this.#renderer.setClearColor(0xffffff);
    container.append(this.#renderer.domElement);
    const box = new Mesh(new BoxGeometry(1, 1, 1), this.#material);
    box.scale.set(...size);
    this.#scene.add(box);
    this.#material.uniforms.size.value.set(...size);
    this.#material.uniforms.isovalue.value = isovalue / 255;
    const distance = Math.hypot(...size) / 2 / Math.sin(Math.PI / 12);
    this.#camera.position.set(0.5, 0.4, 1).setLength(distance);
    this.#camera.lookAt(0, 0, 0);
  }

  /** Draws another volume of the same size in world units: bytes, x fastest. */
  show(values, voxels) {
    const texture = new Data3DTexture(values, ...voxels);
    texture.format = RedFormat;
    texture.minFilter = LinearFilter;
    texture.magFilter = LinearFilter;
    texture.unpackAlignment = 1;
    texture.needsUpdate = true;
    const { volume, voxels: count } = this.#material.uniforms;
    volume.value?.dispose();
    volume.value = texture;
    count.value.set(...voxels);
    this.#renderer.render(this.#scene, this.#camera);
  }

  changeIsovalue(isovalue) {
    this.#material.uniforms.isovalue.value = isovalue / 255;
    this.#renderer.render(this.#scene, this.#camera);
  }
}
