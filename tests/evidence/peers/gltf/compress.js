// node compress.js MESH OUT.glb: compresses a mesh with meshopt. MESH: a GLB file, or a file of
// flying_edges_mesh.py.
import { readFileSync } from "node:fs";
import { Document, NodeIO } from "@gltf-transform/core";
import { EXTMeshoptCompression, KHRMeshQuantization } from "@gltf-transform/extensions";
import { meshopt } from "@gltf-transform/functions";
import { MeshoptEncoder } from "meshoptimizer";

const colour = [0.85, 0.8, 0.7, 1];

/** Points (u64), triangles (u64), positions, normals (3 f32 each), 3 u32 for each triangle. */
function flyingEdgesDocument(file) {
  const { buffer, byteOffset } = file;
  const counts = new BigUint64Array(buffer.slice(byteOffset, byteOffset + 16));
  const [points, triangles] = [Number(counts[0]), Number(counts[1])];
  const expected = 16 + 24 * points + 12 * triangles;
  if (file.length !== expected) throw new Error(`expected ${expected} bytes, found ${file.length}`);
  const floats = new Float32Array(buffer.slice(byteOffset + 16, byteOffset + 16 + 24 * points));
  const indices = new Uint32Array(
    buffer.slice(byteOffset + 16 + 24 * points, byteOffset + expected),
  );
  const document = new Document();
  const place = document.createBuffer();
  const accessor = (type, array) =>
    document.createAccessor().setType(type).setArray(array).setBuffer(place);
  const primitive = document
    .createPrimitive()
    .setAttribute("POSITION", accessor("VEC3", floats.slice(0, 3 * points)))
    .setAttribute("NORMAL", accessor("VEC3", floats.slice(3 * points)))
    .setIndices(accessor("SCALAR", indices))
    .setMaterial(document.createMaterial().setMetallicFactor(0).setBaseColorFactor(colour));
  const mesh = document.createMesh().addPrimitive(primitive);
  document.createScene().addChild(document.createNode().setMesh(mesh));
  return document;
}

const [from, to] = process.argv.slice(2);
await MeshoptEncoder.ready;
const io = new NodeIO()
  .registerExtensions([EXTMeshoptCompression, KHRMeshQuantization])
  .registerDependencies({ "meshopt.encoder": MeshoptEncoder });
const document = from.endsWith(".glb")
  ? await io.read(from)
  : flyingEdgesDocument(readFileSync(from));
await document.transform(meshopt({ encoder: MeshoptEncoder }));
await io.write(to, document);
