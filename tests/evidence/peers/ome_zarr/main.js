// Represents programs that stream bricks. It loads the scales of an OME-Zarr from the coarsest to
// the finest, each completely before the next, and draws them with the same ray caster.
// ?volume=NAME.zarr&isovalue=V
import * as zarr from "zarrita";
import { RayCaster } from "../ray_caster/ray_caster.js";

const asked = new URL(location.href).searchParams;
const root = await zarr.open.v3(
  new zarr.FetchStore(new URL(asked.get("volume"), location.href).href),
  { kind: "group" },
);
const [{ datasets }] = root.attrs.ome.multiscales;
const arrays = await Promise.all(
  datasets.map(({ path }) => zarr.open.v3(root.resolve(path), { kind: "array" })),
);
const scale = datasets[0].coordinateTransformations[0].scale;
const size = arrays[0].shape.map((n, axis) => n * scale[axis]).reverse();
const caster = new RayCaster(document.getElementById("view"), size, Number(asked.get("isovalue")));
for (const [i, array] of arrays.reverse().entries()) {
  const { data, shape } = await zarr.get(array);
  caster.show(data, [...shape].reverse());
  if (i === 0) performance.mark("peer:image");
}
performance.mark("peer:final");
globalThis.changeIsovalue = (isovalue) => caster.changeIsovalue(isovalue);
