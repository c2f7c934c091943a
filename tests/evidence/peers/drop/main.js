// Acts like a user of NiiVue. A file is dropped on it, and its volume renderer shows the file,
// opaque from an isovalue on and lit by gradients. Or it fetches the file
// (?volume=FILE.nii.gz&isovalue=V). peer:image and peer:changed mark pictures that the GPU has
// finished.
import { Niivue } from "@niivue/niivue";

const asked = new URL(location.href).searchParams;
const view = document.getElementById("view");
const niivue = new Niivue({ show3Dcrosshair: false, backColor: [1, 1, 1, 1] });
await niivue.attachToCanvas(view);
niivue.addColormap("surface", {
  R: [217, 217],
  G: [204, 204],
  B: [179, 179],
  A: [0, 255],
  I: [0, 255],
});
await niivue.setVolumeRenderIllumination(1);
niivue.setSliceType(niivue.sliceTypeRender);

/** Draws the isosurface, and waits for the GPU. */
function show(volume, isovalue) {
  volume.colormap = "surface";
  volume.cal_min = isovalue;
  volume.cal_max = isovalue + 0.5;
  niivue.updateGLVolume();
  niivue.drawScene();
  const { gl } = niivue;
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
}

niivue.onImageLoaded = (volume) => {
  const middle = (volume.global_min + volume.global_max) / 2;
  show(volume, asked.has("isovalue") ? Number(asked.get("isovalue")) : middle);
  performance.mark("peer:image");
  globalThis.changeIsovalue = (isovalue = middle + 1) => {
    performance.mark("peer:change");
    show(volume, isovalue);
    performance.mark("peer:changed");
  };
};
performance.mark("peer:ready");
if (asked.has("volume")) await niivue.loadVolumes([{ url: asked.get("volume") }]);
