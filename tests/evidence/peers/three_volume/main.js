// Uses three.js with the whole volume as a 3D texture.
// ?volume=FILE.raw.gz&dims=x,y,z&spacing=x,y,z&isovalue=V
import { RayCaster } from "../ray_caster/ray_caster.js";

const asked = new URL(location.href).searchParams;
const numbers = (name) => asked.get(name).split(",").map(Number);
const [voxels, spacing] = [numbers("dims"), numbers("spacing")];

const answer = await fetch(asked.get("volume"));
const text = answer.body.pipeThrough(new DecompressionStream("gzip"));
const values = new Uint8Array(await new Response(text).arrayBuffer());
const size = voxels.map((n, axis) => n * spacing[axis]);
const caster = new RayCaster(document.getElementById("view"), size, Number(asked.get("isovalue")));
caster.show(values, voxels);
performance.mark("peer:image");
globalThis.changeIsovalue = (isovalue) => caster.changeIsovalue(isovalue);
