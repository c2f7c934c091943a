// NiiVue: its volume renderer, opaque from the isovalue on, lit by gradients. Its projection is
// parallel, and it turns about the volume's centre: the scale is that of the target's distance.
import { Niivue, NVImage } from "@niivue/niivue";

// A NIfTI-1 file of bytes with these dimensions: the header's fields that are not zero.
function nifti({ voxels, spacing }, values) {
  const file = new Uint8Array(352 + values.length);
  const header = new DataView(file.buffer);
  header.setInt32(0, 348, true);
  for (const [i, n] of [3, ...voxels, 1, 1, 1, 1].entries()) header.setInt16(40 + 2 * i, n, true);
  header.setInt16(70, 2, true); // unsigned bytes
  header.setInt16(72, 8, true);
  for (const [i, s] of [1, ...spacing, 1, 1, 1, 1].entries())
    header.setFloat32(76 + 4 * i, s, true);
  header.setFloat32(108, 352, true); // where the values begin
  header.setFloat32(112, 1, true); // slope
  header.setInt16(254, 1, true); // the affine map below
  for (const [axis, s] of spacing.entries()) header.setFloat32(280 + 20 * axis, s, true);
  file.set([0x6e, 0x2b, 0x31, 0], 344);
  file.set(values, 352);
  return file.buffer;
}

export async function draw(scene, values, container) {
  const canvas = document.createElement("canvas");
  container.append(canvas);
  canvas.style.cssText = "width: 100%; height: 100%";
  const niivue = new Niivue({
    backColor: [...scene.background, 1],
    show3Dcrosshair: false,
    isOrientCube: false,
    isOrientationTextVisible: false,
    isColorbar: false,
    crosshairWidth: 0,
  });
  await niivue.attachToCanvas(canvas);
  const [r, g, b] = scene.colour.map((c) => [Math.round(255 * c), Math.round(255 * c)]);
  niivue.addColormap("surface", { R: r, G: g, B: b, A: [0, 255], I: [0, 255] });
  const image = await NVImage.loadFromUrl({
    url: nifti(scene, values),
    name: "volume.nii",
    colormap: "surface",
    cal_min: scene.isovalue,
    cal_max: scene.isovalue + 0.5,
  });
  niivue.addVolume(image);
  niivue.setSliceType(niivue.sliceTypeRender);
  await niivue.setVolumeRenderIllumination(1);
  niivue.setRenderAzimuthElevation(scene.niivue.azimuth, scene.niivue.elevation);
  niivue.setScale(scene.niivue.scale);
  niivue.drawScene();
}
